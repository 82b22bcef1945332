/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_rules_ends.c - runs that ended otherwise than a module can end them: by a signal from
 * outside, by the clock, by the harness in trouble. Evidence made up here. */
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "case_rig.h"

static const struct image image = { .format = IMAGE_FORMAT_ELF64, .target = IMAGE_TARGET_X86_64 };
static struct case_run *runs;
static struct case_scenario scenario;
static struct case_file file;
static struct findings findings;

static int begin(void **state)
{
    (void)state;
    runs = complete_runs();
    if (runs == NULL)
        return -1;
    memset(&findings, 0, sizeof findings);
    memset(&scenario, 0, sizeof scenario);
    scenario.name = "a.scenario";
    scenario.ran = true;
    complete(&scenario.experiment, &scenario.result);
    scenario.result.evidence.play = PLAY_DONE;
    scenario.result.evidence.checked = 1;
    file = (struct case_file){ .image = &image,
                               .profile = profile_find("pc4"),
                               .name = "gantry.tgm",
                               .runs = runs,
                               .scenarios = &scenario,
                               .scenario_count = 1,
                               .cannot_run = "not run" };
    return 0;
}

static int end(void **state)
{
    (void)state;
    free(runs);
    return 0;
}

/* The run at 500 us ended so, inside Program_04, in cycle 70. */
static struct experiment_result *ended(enum worker_end how, int value)
{
    struct experiment_result *result = &runs[EXPERIMENT_CYCLE_500].result;
    result->worker.end = how;
    result->worker.value = value;
    result->evidence.stage = EVIDENCE_CALLING;
    result->evidence.entry = ENTRY_04;
    result->evidence.cycle = 70;
    result->evidence.cycles_done = 70;
    return result;
}

static void expect(const char *what, const char *reason)
{
    assert_int_equal(findings.count, what != NULL);
    if (what != NULL)
        assert_string_equal(findings.list[0].what, what);
    assert_string_equal(findings.reason, reason);
}

static void check_anew(void (*check)(const struct case_file *, struct findings *))
{
    memset(&findings, 0, sizeof findings);
    check(&file, &findings);
}

static void nothing_is_said_of_complete_runs(void **state)
{
    (void)state;
    check_anew(check_no_fault);
    expect(NULL, "");
    check_anew(check_ini_returns_one);
    expect(NULL, "");
    check_anew(check_scenario);
    expect(NULL, "");
}

static void a_destroyed_process_is_a_fault_with_its_signal(void **state)
{
    (void)state;
    ended(WORKER_KILLED, SIGSEGV);
    check_anew(check_no_fault);
    expect("Program_04 destroyed the process it ran in (signal 11: Segmentation fault)",
           "experiment made up: the module ended the process it ran in");
    assert_string_equal(findings.list[0].function, "Program_04");
    assert_int_equal(findings.list[0].cycle, 70);
    snprintf(runs[EXPERIMENT_CYCLE_500].result.worker.reason, 20, "its last words");
    check_anew(check_no_fault);
    expect("Program_04 destroyed the process it ran in (signal 11: Segmentation fault): its last "
           "words",
           "experiment made up: the module ended the process it ran in");
    check_anew(check_returns); /* is not what that rule is about */
    expect(NULL, "experiment made up: the module ended the process it ran in");
}

static void a_process_that_exits_is_a_fault_with_its_status(void **state)
{
    (void)state;
    ended(WORKER_EXITED, 3);
    check_anew(check_no_fault);
    expect("Program_04 ended the process it ran in (exit status 3)",
           "experiment made up: the module ended the process it ran in");
}

static void signals_from_outside_are_nobody_s_fault(void **state)
{
    static const int outside[] = { SIGKILL, SIGTERM, SIGINT, SIGHUP, SIGXCPU, SIGQUIT };
    char reason[200];
    (void)state;
    for (size_t i = 0; i < sizeof outside / sizeof *outside; i++) {
        ended(WORKER_KILLED, outside[i]);
        check_anew(check_no_fault);
        snprintf(reason, sizeof reason,
                 "experiment made up: the worker was stopped from outside (%s)",
                 strsignal(outside[i]));
        expect(NULL, reason);
    }
    /* Exit status 9 is no signal 9. */
    ended(WORKER_EXITED, SIGKILL);
    check_anew(check_no_fault);
    expect("Program_04 ended the process it ran in (exit status 9)",
           "experiment made up: the module ended the process it ran in");
}

static void who_is_too_slow_is_not_judged(void **state)
{
    (void)state;
    ended(WORKER_TIMEOUT, 0)->worker.wall_ns = UINT64_C(12000000000);
    check_anew(check_no_fault);
    expect(NULL,
           "experiment made up: only 70 of 100 cycles were done in 12 s: the module is too slow, "
           "or this computer too busy; fewer cycles: --cycles N");
    runs[EXPERIMENT_START].result.worker.end = WORKER_TIMEOUT;
    check_anew(check_ini_returns_one);
    expect(NULL, "experiment made up: the worker was stopped before it was done");
}

/* With words for it and without, whether the worker came to its end or not. */
static void expect_trouble(struct experiment_result *result,
                           void (*check)(const struct case_file *, struct findings *))
{
    result->worker.end = WORKER_FAILED;
    check_anew(check);
    expect(NULL, "experiment made up: the worker failed");
    snprintf(result->evidence.trouble, sizeof result->evidence.trouble, "no bus");
    check_anew(check);
    expect(NULL, "experiment made up: no bus");
    result->worker.end = WORKER_DONE;
    check_anew(check);
    expect(NULL, "experiment made up: no bus");
}

static void the_harness_s_trouble_is_told(void **state)
{
    (void)state;
    expect_trouble(ended(WORKER_FAILED, 0), check_no_fault);
    expect_trouble(&runs[EXPERIMENT_START].result, check_ini_returns_one);
}

static void a_run_is_complete_with_all_cycles_or_nothing_to_call(void **state)
{
    struct evidence *evidence = &runs[EXPERIMENT_CYCLE_500].result.evidence;
    (void)state;
    evidence->cycles_done = 99;
    check_anew(check_no_fault);
    expect(NULL, "experiment made up: its evidence is not complete");
    for (int entry = ENTRY_01; entry < ENTRY_COUNT; entry++)
        evidence->calls[entry].disabled = true;
    check_anew(check_no_fault);
    expect(NULL, "");
    evidence->calls[ENTRY_03].disabled = false;
    check_anew(check_no_fault);
    expect(NULL, "experiment made up: its evidence is not complete");
    evidence->cycles_done = 0;
    check_anew(check_no_fault);
    expect(NULL, "no cycle was run: Program_Ini did not return 1 (rule ini-returns-one)");
}

static void a_scenario_proves_nothing_unless_it_was_played(void **state)
{
    struct evidence *evidence = &scenario.result.evidence;
    struct worker_result *worker = &scenario.result.worker;
    (void)state;
    evidence->checked = 0;
    check_anew(check_scenario);
    expect(NULL, "a.scenario: it expects nothing of the module");
    evidence->play = PLAY_RUNNING;
    check_anew(check_scenario);
    expect("a.scenario: not played to its end", "");
    evidence->failed = 1;
    check_anew(check_scenario);
    expect("a.scenario: and 1 failures of other statements", "");
    evidence->failed = 0;
    evidence->cycles_done = 0;
    check_anew(check_scenario);
    expect("a.scenario: not played to its end", "");
    evidence->calls[ENTRY_INI].last_value = 0;
    check_anew(check_scenario);
    expect("a.scenario: not played: Program_Ini returned 0", "");
    worker->end = WORKER_EXITED;
    evidence->entry = ENTRY_02;
    check_anew(check_scenario);
    expect("a.scenario: Program_02 ended the process it ran in", "");
    worker->end = WORKER_KILLED;
    worker->value = SIGTERM;
    check_anew(check_scenario);
    expect(NULL, "a.scenario: the worker was stopped from outside");
    worker->end = WORKER_TIMEOUT;
    worker->wall_ns = UINT64_C(12000000000);
    check_anew(check_scenario);
    expect(
        NULL,
        "a.scenario: only 0 cycles were done in 12 s: the module is too slow, or this computer too "
        "busy");
    worker->end = WORKER_FAILED;
    check_anew(check_scenario);
    expect(NULL, "a.scenario: the worker failed");
    snprintf(evidence->trouble, sizeof evidence->trouble, "no bus");
    worker->end = WORKER_DONE;
    check_anew(check_scenario);
    expect(NULL, "a.scenario: no bus");
    evidence->trouble[0] = '\0';
    scenario.ran = false;
    check_anew(check_scenario);
    expect(NULL, "not run");
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)
    const struct CMUnitTest tests[] = {
        TEST(nothing_is_said_of_complete_runs),
        TEST(a_destroyed_process_is_a_fault_with_its_signal),
        TEST(a_process_that_exits_is_a_fault_with_its_status),
        TEST(signals_from_outside_are_nobody_s_fault),
        TEST(who_is_too_slow_is_not_judged),
        TEST(the_harness_s_trouble_is_told),
        TEST(a_run_is_complete_with_all_cycles_or_nothing_to_call),
        TEST(a_scenario_proves_nothing_unless_it_was_played),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
