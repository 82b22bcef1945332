/* SPDX-License-Identifier: GPL-2.0-or-later */
/* report_rig.h - reports to print: one that has everything in it, with names as hostile as a file
 * can make them, and one where all is well. */
#ifndef TESTS_REPORT_RIG_H
#define TESTS_REPORT_RIG_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "report/report.h"

#define HOSTILE "<script>alert(1)</script>\" onload='x' & ]]> \xE2\x80\xAE \xFF\x1B[31m --> "

static struct finding rig_findings[] = {
    { .what = "Program_04 wrote SERVO[0].Position (read-only)",
      .when = "in cycle 200 at Cycle_Time 500 us",
      .place = "gantry.tgm+0x1a4 (Program_04) gantry.c:88",
      .again = "tgm check gantry.tgm --rule write-read-only --seed 0x1d2f --cycles 201",
      .function = "Program_04",
      .has_address = true,
      .address = 0x1a4,
      .file = "source/gantry.c",
      .line = 88,
      .has_cycle = true,
      .cycle = 200,
      .count = 1800 },
    { .what = "exports " HOSTILE, .place = HOSTILE, .file = HOSTILE, .line = 1, .count = 1 },
    { .what = "Program_01 took 24.1 us", .function = "Program_01", .count = 1 },
    { .what = "no debug information", .count = 1 },
    { .what = "Program_02 jumps its set point by 12 inc", .function = "Program_02", .count = 3 },
};

static const struct waiver_report rig_waivers[] = {
    { .rule = "set-point-steps",
      .reason = "homing against a stop",
      .owner = "J. Novak <jn@plant>",
      .expiry = "2027-03-31",
      .used = true },
    { .rule = "inputs-first",
      .reason = HOSTILE,
      .owner = "nobody",
      .expiry = "2020-01-01",
      .expired = true },
};

#define RIG_RULE(name, where, how, what)                                                           \
    .id = name, .group = where, .clause = "manual: Functions PLC", .title = what,                  \
    .advice = "Do it as the sample does.", .severity = how

static struct rule_report rig_rules[] = {
    { RIG_RULE("export-names", "file", SEVERITY_MUST, "Exactly six functions are exported."),
      .outcome = RULE_FAILED, .findings = &rig_findings[1], .finding_count = 1, .dropped = 2 },
    { RIG_RULE("no-imports", "file", SEVERITY_MUST, "The module is linked to nothing.") },
    { RIG_RULE("debug-lines", "file", SEVERITY_NOTE, "Lines can be named."), .outcome = RULE_FAILED,
      .findings = &rig_findings[3], .finding_count = 1 },
    { RIG_RULE("ini-returns-one", "start", SEVERITY_MUST, "Program_Ini returns 1.") },
    { RIG_RULE("write-read-only", "cycle", SEVERITY_MUST, "No read-only register is written."),
      .outcome = RULE_FAILED, .findings = &rig_findings[0], .finding_count = 1 },
    { RIG_RULE("budget-programs", "cycle", SEVERITY_SHOULD, "20 % of the own period."),
      .outcome = RULE_FAILED, .findings = &rig_findings[2], .finding_count = 1 },
    { RIG_RULE("set-point-steps", "cycle", SEVERITY_MUST, "Set points do not jump."),
      .outcome = RULE_FAILED, .findings = &rig_findings[4], .finding_count = 1,
      .waiver = &rig_waivers[0] },
    { RIG_RULE("budget-program-05", "cycle", SEVERITY_MUST, "10 us at most."),
      .outcome = RULE_NOT_JUDGED, .reason = "the instrumented CPU has no AVX" },
    { RIG_RULE("torn", "preempted", SEVERITY_SHOULD, "No register is torn."),
      .outcome = RULE_NOT_JUDGED, .reason = "the instrumented CPU has no AVX" },
};

static struct group_report rig_groups[] = {
    { .name = "file", .seconds = 0.003 },
    { .name = "start", .seconds = 0.041 },
    { .name = "cycle", .seconds = 2.1, .note = "250 / 500 / 1000 us, 10 s of machine time each" },
    { .name = "preempted", .seconds = 1.9, .note = "1850 interruption points" },
    { .name = "machine" },
};

static const struct budget_report rig_budgets[] = {
    { .name = "Program_04",
      .unit = "us",
      .worst = 6.1,
      .allowed = 25,
      .has_cycle = true,
      .cycle = 31207,
      .cycle_us = 250,
      .instructions = 6100 },
    { .name = "Program_05",
      .unit = "us",
      .worst = 11.3,
      .allowed = 10,
      .has_cycle = true,
      .cycle = 12,
      .cycle_us = 500,
      .instructions = 11300 },
    { .name = "Program_01", .unit = "us", .worst = 0.04, .allowed = 200 },
    { .name = "Program_02", .unit = "us", .reason = "the instrumented CPU has no AVX" },
    { .name = "stack", .unit = "bytes", .worst = 1240, .allowed = 65536 },
};

static const struct coverage_report rig_coverage[] = {
    { .name = "Program_04", .executed = 180, .total = 200, .missed = "gantry.c:140" },
    { .name = HOSTILE, .executed = 7, .total = 7 },
};

static struct timeline_event rig_events[] = {
    { .kind = TIMELINE_STATE,
      .source = "bus",
      .text = "every slave in OP",
      .seconds = 0.0125,
      .has_cycle = true,
      .cycle = 25,
      .count = 1 },
    { .kind = TIMELINE_FAULT,
      .source = "bus",
      .text = "frame 200 lost",
      .seconds = 3.2,
      .count = 40 },
    { .kind = TIMELINE_MESSAGE,
      .source = "Program_01",
      .text = HOSTILE,
      .seconds = 4,
      .has_cycle = true,
      .cycle = 8000,
      .count = 1 },
    { .kind = TIMELINE_INCIDENT,
      .source = "Program_04",
      .text = "divided by zero",
      .seconds = 7.5,
      .has_cycle = true,
      .cycle = 15000,
      .count = 1 },
};

static struct timeline_report rig_timelines[] = {
    { .name = "cycle-500",
      .about = "Cycle_Time 500 us, 20000 cycles",
      .seconds = 10,
      .events = rig_events,
      .event_count = 4,
      .dropped = 3 },
};

#define RIG_BUCKETS 200
static double rig_curve[4][RIG_BUCKETS];
static struct plot_curve rig_curves[] = {
    { .name = "SERVO[0].Position", .unit = "inc", .least = rig_curve[0], .greatest = rig_curve[1] },
    { .name = "SERVO[1].Position", .unit = "inc", .least = rig_curve[2], .greatest = rig_curve[2] },
    { .name = "Program_04",
      .unit = "instructions",
      .least = rig_curve[3],
      .greatest = rig_curve[3] },
};
static const struct plot_report rig_plots[] = {
    { .title = "cycle-500, Cycle_Time 500 us",
      .begin = 0,
      .end = 10,
      .buckets = RIG_BUCKETS,
      .curves = rig_curves,
      .curve_count = 3 },
};

/* Six failed, waived among them; two not judged; one passed twice. */
static struct report rig_report(void)
{
    for (int i = 0; i < RIG_BUCKETS; i++) {
        rig_curve[0][i] = 41000 * sin(i * 0.06) - 300;
        rig_curve[1][i] = rig_curve[0][i] + 600;
        rig_curve[2][i] = i < 20 ? NAN : 9000 * cos(i * 0.09);
        rig_curve[3][i] = 900 + i % 7 * 40;
    }
    return (struct report){
        .tool = "tgm 0.1.0",
        .path = "/plant/gantry <&>.tgm",
        .size = 18840,
        .sha256 = "3f9c0000000000000000000000000000000000000000000000000000000000a1",
        .format = "ELF64",
        .target = "x86-64",
        .profile = "pc4",
        .profile_title = "TG Motion 4.21, ids 4033/904",
        .seed = 0x1d2f,
        .rules = rig_rules,
        .rule_count = sizeof rig_rules / sizeof *rig_rules,
        .groups = rig_groups,
        .group_count = sizeof rig_groups / sizeof *rig_groups,
        .passed = 2,
        .failed = 5,
        .not_judged = 2,
        .verdict = VERDICT_FAIL,
        .rule_book = "77aa000000000000000000000000000000000000000000000000000000000000",
        .evidence = "e0e0000000000000000000000000000000000000000000000000000000000000",
        .budgets = rig_budgets,
        .budget_count = sizeof rig_budgets / sizeof *rig_budgets,
        .coverage = rig_coverage,
        .coverage_count = 2,
        .timelines = rig_timelines,
        .timeline_count = 1,
        .plots = rig_plots,
        .plot_count = 1,
        .waivers = rig_waivers,
        .waiver_count = 2,
    };
}

/* Two rules, both passed, and nothing else. */
static struct report rig_quiet_report(void)
{
    static struct rule_report rules[] = {
        { RIG_RULE("no-imports", "file", SEVERITY_MUST, "The module is linked to nothing.") },
        { RIG_RULE("ini-returns-one", "start", SEVERITY_MUST, "Program_Ini returns 1.") },
    };
    struct report report = rig_report();
    report.rules = rules;
    report.rule_count = 2;
    report.passed = 2;
    report.failed = report.not_judged = 0;
    report.verdict = VERDICT_PASS;
    report.budget_count = report.coverage_count = report.timeline_count = report.plot_count =
        report.waiver_count = 0;
    report.rule_book = report.evidence = NULL;
    return report;
}

typedef int rig_form(const struct report *, FILE *);

static inline int rig_text(const struct report *report, FILE *stream)
{
    report_text(report, stream, false);
    return fflush(stream);
}

/* What the form prints, to be freed. */
static inline char *rig_print(const struct report *report, rig_form *form)
{
    char *text = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&text, &size);
    if (form(report, stream) != 0)
        abort();
    fclose(stream);
    char *copy = strdup(text);
    free(text);
    return copy;
}

#endif
