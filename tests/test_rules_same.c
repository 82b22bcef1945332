/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_rules_same.c - what is made of runs that differ, from evidence made up here. */
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

static const struct image image = { .format = IMAGE_FORMAT_ELF64 };
static struct case_run *runs;
static struct case_file file;
static struct findings findings;

/* Every run is complete, started and did nothing to any register. */
static int begin(void **state)
{
    (void)state;
    runs = complete_runs();
    if (runs == NULL)
        return -1;
    memset(&findings, 0, sizeof findings);
    file = (struct case_file){ .image = &image,
                               .profile = profile_find("pc4"),
                               .name = "made-up.tgm",
                               .runs = runs,
                               .cannot_run = "" };
    for (int id = 0; id < EXPERIMENT_COUNT; id++)
        runs[id].result.evidence.digest.state_count = CYCLES;
    return 0;
}

static int end(void **state)
{
    (void)state;
    free(runs);
    return 0;
}

struct place {
    const char *name; /* as in the register list */
    size_t number, trail, memory, offset;
};

static void find(void *argument, const struct catalogue_line *line)
{
    struct place *place = argument;
    const size_t number = place->number++;
    if (strcmp(line->name, place->name) == 0) {
        place->trail = number;
        place->offset = line->offset;
        while (catalogue_memory(catalogue_find(4, 0), place->memory) != line->memory)
            place->memory++;
    }
}

/* From that cycle on, the register of element 0 is 1 in the run. */
static void differs(enum experiment_id id, const char *name, uint32_t cycle)
{
    struct digest *digest = &runs[id].result.evidence.digest;
    struct digest_state state = { 0, 0 };
    struct place place = { .name = name, .trail = SIZE_MAX };
    catalogue_walk(catalogue_find(4, 0), find, &place);
    assert_true(place.trail != SIZE_MAX);
    digest->state_count = cycle;
    digest_change(digest, &state, place.trail, digest_unit(place.memory, place.offset), 0, 1);
    for (uint32_t n = cycle + 1; n < CYCLES; n++)
        digest->states[n] = state;
    digest->state_count = CYCLES;
}

static void expect_one(const char *what)
{
    assert_int_equal(findings.count, 1);
    assert_string_equal(findings.list[0].what, what);
}

static void alike_runs_are_right(void **state)
{
    (void)state;
    check_deterministic(&file, &findings);
    check_globals(&file, &findings);
    check_counter_wrap(&file, &findings);
    check_data_size(&file, &findings);
    assert_int_equal(findings.count, 0);
    assert_string_equal(findings.reason, "");
}

static void a_second_run_names_register_and_cycle(void **state)
{
    (void)state;
    differs(EXPERIMENT_REPEATED, "DIO[n].Out0", 42);
    check_deterministic(&file, &findings);
    expect_one("in a second run of the same: DIO[0].Out0 is not what it is otherwise");
    assert_true(findings.list[0].has_cycle);
    assert_int_equal(findings.list[0].cycle, 42);
}

static void what_does_not_repeat_itself_is_not_judged_by_its_globals(void **state)
{
    (void)state;
    differs(EXPERIMENT_REPEATED, "DIO[n].Out0", 42);
    differs(EXPERIMENT_POISON_ZERO, "DIO[n].Out0", 42);
    check_globals(&file, &findings);
    assert_int_equal(findings.count, 0);
    assert_non_null(strstr(findings.reason, "rule deterministic"));
}

static void other_globals_and_zeros_are_both_looked_at(void **state)
{
    (void)state;
    differs(EXPERIMENT_POISON_ZERO, "SERVO[n].Mode", 3);
    check_globals(&file, &findings);
    expect_one("with zeros in the globals before Program_Ini: SERVO[0].Mode is not what it is "
               "otherwise");
}

static void faults(enum experiment_id id)
{
    struct evidence *evidence = &runs[id].result.evidence;
    evidence->incident_count = 1;
    evidence->incidents[0] = (struct evidence_incident){ .entry = ENTRY_INI,
                                                         .cycle = EVIDENCE_NO_CYCLE,
                                                         .kind = MACHINE_FAULT,
                                                         .fault.signal = SIGFPE };
    evidence->calls[ENTRY_INI] = (struct evidence_calls){ .count = 0 };
}

static void a_start_that_ends_otherwise_says_how_each_ended(void **state)
{
    (void)state;
    runs[EXPERIMENT_POISON_ZERO].result.evidence.calls[ENTRY_INI].last_value = 0;
    check_globals(&file, &findings);
    expect_one("with zeros in the globals before Program_Ini: Program_Ini returned 0, otherwise "
               "it returned 1");
}

/* A call that never returned has no value, not even 0. */
static void a_start_that_faulted_has_not_returned(void **state)
{
    (void)state;
    faults(EXPERIMENT_CYCLE_500);
    faults(EXPERIMENT_REPEATED);
    faults(EXPERIMENT_POISON_INVERTED);
    check_globals(&file, &findings);
    expect_one("with zeros in the globals before Program_Ini: Program_Ini returned 1, otherwise "
               "it did not return");
    assert_string_equal(findings.list[0].function, "Program_Ini");
}

static void a_start_that_faults_either_way_is_alike(void **state)
{
    (void)state;
    for (int id = 0; id < EXPERIMENT_COUNT; id++)
        faults((enum experiment_id)id);
    check_globals(&file, &findings);
    assert_int_equal(findings.count, 0);
}

static void addresses_count_where_the_machine_is(void **state)
{
    (void)state;
    differs(EXPERIMENT_PLACES, "SYSTEM.Timers.Timer_Down[64]", 5); /* no register of the machine */
    check_deterministic(&file, &findings);
    assert_int_equal(findings.count, 0);
    differs(EXPERIMENT_PLACES, "SERVO[n].WritePosition", 5);
    check_deterministic(&file, &findings);
    expect_one("with module and memories at other addresses: SERVO[n].WritePosition is not what it "
               "is otherwise");
}

static void a_wrap_is_what_only_the_wrapping_run_does(void **state)
{
    (void)state;
    differs(EXPERIMENT_COUNTERS, "DIO[n].Out0", 60);
    check_counter_wrap(&file, &findings);
    expect_one("when the counters pass 4294967295: DIO[n].Out0 is not what it is otherwise");
}

static void who_acts_by_the_value_of_a_counter_may(void **state)
{
    (void)state;
    differs(EXPERIMENT_COUNTERS, "DIO[n].Out0", 60);
    differs(EXPERIMENT_COUNTERS_FAR, "DIO[n].Out0", 61);
    check_counter_wrap(&file, &findings);
    assert_int_equal(findings.count, 0);
    assert_string_equal(findings.reason, "");
}

static void refusing_another_size_is_right(void **state)
{
    (void)state;
    runs[EXPERIMENT_DATA_LESS].result.evidence.calls[ENTRY_INI].last_value = 0;
    check_data_size(&file, &findings);
    assert_int_equal(findings.count, 0);
    runs[EXPERIMENT_DATA_MORE].plan.experiment.host.data_bytes = 1048576;
    runs[EXPERIMENT_DATA_MORE].result.evidence.incident_count = 1;
    runs[EXPERIMENT_DATA_MORE].result.evidence.incidents[0].kind = MACHINE_HANG;
    runs[EXPERIMENT_DATA_MORE].result.evidence.incidents[0].entry = ENTRY_04;
    check_data_size(&file, &findings);
    expect_one("with 1048576 bytes of TGM_Data: Program_04 did not return within a second");
}

static void a_start_that_did_not_come_is_not_judged(void **state)
{
    (void)state;
    check_restart(&file, &findings);
    assert_int_equal(findings.count, 0);
    assert_string_equal(findings.reason, "the PLC was not run again");
}

static void what_faults_without_it_is_not_judged_by_a_second_start(void **state)
{
    (void)state;
    faults(EXPERIMENT_CYCLE_500);
    faults(EXPERIMENT_RESTART);
    runs[EXPERIMENT_CYCLE_500].result.evidence.calls[ENTRY_INI].last_value = 1;
    runs[EXPERIMENT_CYCLE_500].result.evidence.incidents[0].entry = ENTRY_04;
    check_restart(&file, &findings);
    assert_int_equal(findings.count, 0);
    assert_string_equal(findings.reason, "even without being run again: Program_04 divided by zero "
                                         "or overflowed a division");
}

static void a_second_start_must_end_with_one(void **state)
{
    (void)state;
    runs[EXPERIMENT_RESTART].result.evidence.loads = 1;
    check_restart(&file, &findings);
    assert_int_equal(findings.count, 0);
    assert_string_equal(findings.reason, "");
    runs[EXPERIMENT_RESTART].result.evidence.calls[ENTRY_INI].last_value = 0;
    check_restart(&file, &findings);
    expect_one("when the PLC is run again, Program_Ini returns 0");
}

static void what_an_emulated_cpu_lacks_is_no_finding(void **state)
{
    (void)state;
    struct evidence *evidence = &runs[EXPERIMENT_POISON_ZERO].result.evidence;
    evidence->incident_count = 1;
    evidence->incidents[0].kind = MACHINE_UNSUPPORTED;
    evidence->incidents[0].entry = ENTRY_04;
    check_globals(&file, &findings);
    assert_int_equal(findings.count, 0);
    assert_non_null(strstr(findings.reason, "the emulated CPU lacks an instruction of Program_04"));
}

static void ends(enum experiment_id id, int signal)
{
    struct evidence *evidence = &runs[id].result.evidence;
    runs[id].result.worker.end = WORKER_KILLED;
    runs[id].result.worker.value = signal;
    evidence->stage = EVIDENCE_CALLING;
    evidence->entry = ENTRY_04;
    evidence->cycle = 70;
}

static void the_end_of_the_process_is_a_disturbance_s_doing(void **state)
{
    (void)state;
    ends(EXPERIMENT_CABLE, SIGSEGV);
    check_disturbed_returns(&file, &findings);
    expect_one("made up: Program_04 ended the process it ran in");
    assert_int_equal(findings.list[0].cycle, 70);
}

static void the_end_of_the_process_from_outside_is_nobody_s(void **state)
{
    (void)state;
    ends(EXPERIMENT_CABLE, SIGTERM);
    check_disturbed_returns(&file, &findings);
    assert_int_equal(findings.count, 0);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)
    const struct CMUnitTest tests[] = {
        TEST(alike_runs_are_right),
        TEST(a_second_run_names_register_and_cycle),
        TEST(what_does_not_repeat_itself_is_not_judged_by_its_globals),
        TEST(other_globals_and_zeros_are_both_looked_at),
        TEST(a_start_that_ends_otherwise_says_how_each_ended),
        TEST(a_start_that_faulted_has_not_returned),
        TEST(a_start_that_faults_either_way_is_alike),
        TEST(addresses_count_where_the_machine_is),
        TEST(a_wrap_is_what_only_the_wrapping_run_does),
        TEST(who_acts_by_the_value_of_a_counter_may),
        TEST(refusing_another_size_is_right),
        TEST(a_start_that_did_not_come_is_not_judged),
        TEST(what_faults_without_it_is_not_judged_by_a_second_start),
        TEST(a_second_start_must_end_with_one),
        TEST(what_an_emulated_cpu_lacks_is_no_finding),
        TEST(the_end_of_the_process_is_a_disturbance_s_doing),
        TEST(the_end_of_the_process_from_outside_is_nobody_s),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
