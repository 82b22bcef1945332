/* SPDX-License-Identifier: GPL-2.0-or-later */
/* JUnit XML as CI systems read it: one suite a group, one case a rule. What makes the verdict other
 * than PASS is a failure or an error there; what does not is at most skipped. */
#include <errno.h>
#include <inttypes.h>
#include <string.h>

#include "report/markup.h"
#include "report/report.h"

static void attribute(FILE *out, const char *name, const char *value)
{
    fprintf(out, " %s=\"", name);
    markup_text(out, value);
    fputc('"', out);
}

static void finding_lines(const struct finding *finding, FILE *out)
{
    markup_text(out, finding->what);
    if (finding->when[0] != '\0') {
        fputc(' ', out);
        markup_text(out, finding->when);
    }
    fputc('\n', out);
    if (finding->place[0] != '\0') {
        fputs("  ", out);
        markup_text(out, finding->place);
        fputc('\n', out);
    }
    if (finding->count > 1)
        fprintf(out, "  seen %" PRIu64 " times, this is the first\n", finding->count);
    if (finding->again[0] != '\0') {
        fputs("  again: ", out);
        markup_text(out, finding->again);
        fputc('\n', out);
    }
}

static void rule_lines(const struct rule_report *rule, FILE *out)
{
    for (size_t i = 0; i < rule->finding_count; i++)
        finding_lines(&rule->findings[i], out);
    if (rule->dropped > 0)
        fprintf(out, "and %zu more\n", rule->dropped);
    markup_text(out, rule->advice);
    fputs("\nmore: tgm explain ", out);
    markup_text(out, rule->id);
    fputc('\n', out);
}

static void whose(const struct waiver_report *waiver, FILE *out)
{
    fputs("by ", out);
    markup_text(out, waiver->owner);
    fputs(": ", out);
    markup_text(out, waiver->reason);
}

static void waived(const struct waiver_report *waiver, FILE *out)
{
    fputs("<skipped message=\"waived until ", out);
    markup_text(out, waiver->expiry);
    fputc(' ', out);
    whose(waiver, out);
    fputs("\"/>", out);
}

static void failed(const struct report *r, const struct rule_report *rule, FILE *out)
{
    const char *first = rule->finding_count > 0 ? rule->findings[0].what : rule->title;
    if (report_fails(r, rule)) {
        fputs("<failure", out);
        attribute(out, "type", rule->id);
        attribute(out, "message", first);
        fputc('>', out);
        rule_lines(rule, out);
        fputs("</failure>", out);
        return;
    }
    if (rule->waiver != NULL) {
        waived(rule->waiver, out);
    } else {
        fputs("<skipped", out);
        attribute(out, "message", first);
        fputs("/>", out);
    }
    fputs("\n      <system-out>", out);
    rule_lines(rule, out);
    fputs("</system-out>", out);
}

static void not_judged(const struct report *r, const struct rule_report *rule, FILE *out)
{
    if (report_decides(r, rule))
        fputs("<error type=\"not judged\"", out);
    else
        fputs("<skipped", out);
    attribute(out, "message", rule->reason);
    fputs("/>", out);
}

static void rule_case(const struct report *r, const struct rule_report *rule, FILE *out)
{
    fputs("    <testcase classname=\"tgm.", out);
    markup_text(out, r->profile);
    fputc('.', out);
    markup_text(out, rule->group);
    fputc('"', out);
    attribute(out, "name", rule->id);
    if (rule->outcome == RULE_PASSED) {
        fputs("/>\n", out);
        return;
    }
    fputs(">\n      ", out);
    if (rule->outcome == RULE_FAILED)
        failed(r, rule, out);
    else
        not_judged(r, rule, out);
    fputs("\n    </testcase>\n", out);
}

static unsigned expired_waivers(const struct report *r)
{
    unsigned count = 0;
    for (size_t i = 0; i < r->waiver_count; i++)
        count += r->waivers[i].expired;
    return count;
}

/* Of a group, or of all (NULL), waivers included: tests, failures, errors, skipped. */
static void counts(const struct report *r, const char *group, FILE *out)
{
    struct report_tally tally;
    unsigned errors = 0;
    const unsigned expired = group == NULL ? expired_waivers(r) : 0;
    report_tally(r, group, &tally);
    for (size_t i = 0; i < r->rule_count; i++)
        errors += r->rules[i].outcome == RULE_NOT_JUDGED && report_decides(r, &r->rules[i]) &&
                  (group == NULL || strcmp(group, r->rules[i].group) == 0);
    fprintf(out, " tests=\"%u\" failures=\"%u\" errors=\"%u\" skipped=\"%u\"", tally.all + expired,
            tally.failed + expired, errors, tally.all - tally.passed - tally.failed - errors);
}

static void property(FILE *out, const char *name, const char *value)
{
    fputs("      <property", out);
    attribute(out, "name", name);
    attribute(out, "value", value);
    fputs("/>\n", out);
}

static void group_suite(const struct report *r, const struct group_report *group, FILE *out)
{
    struct report_tally tally;
    char seed[24];
    report_tally(r, group->name, &tally);
    if (tally.all == 0)
        return;
    fputs("  <testsuite", out);
    attribute(out, "name", group->name);
    counts(r, group->name, out);
    fprintf(out, " time=\"%.3f\">\n    <properties>\n", group->seconds);
    snprintf(seed, sizeof seed, "0x%" PRIx64, r->seed);
    property(out, "tool", r->tool);
    property(out, "module", r->path);
    property(out, "sha256", r->sha256);
    property(out, "seed", seed);
    fputs("    </properties>\n", out);
    for (size_t i = 0; i < r->rule_count; i++)
        if (strcmp(r->rules[i].group, group->name) == 0)
            rule_case(r, &r->rules[i], out);
    fputs("  </testsuite>\n", out);
}

/* One that is out of date fails the module, whatever became of its rule. */
static void waiver_suite(const struct report *r, FILE *out)
{
    const unsigned expired = expired_waivers(r);
    if (expired == 0)
        return;
    fprintf(out,
            "  <testsuite name=\"waivers\" tests=\"%u\" failures=\"%u\" errors=\"0\" "
            "skipped=\"0\" time=\"0.000\">\n",
            expired, expired);
    for (size_t i = 0; i < r->waiver_count; i++) {
        const struct waiver_report *waiver = &r->waivers[i];
        if (!waiver->expired)
            continue;
        fputs("    <testcase classname=\"tgm.", out);
        markup_text(out, r->profile);
        fputs(".waivers\"", out);
        attribute(out, "name", waiver->rule);
        fputs(">\n      <failure type=\"waiver\" message=\"out of date since ", out);
        markup_text(out, waiver->expiry);
        fputs("\">", out);
        whose(waiver, out);
        fputs("\nrenew it or take it away</failure>\n    </testcase>\n", out);
    }
    fputs("  </testsuite>\n", out);
}

int report_junit(const struct report *r, FILE *stream)
{
    double seconds = 0;
    for (size_t i = 0; i < r->group_count; i++)
        seconds += r->groups[i].seconds;
    fputs("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites", stream);
    attribute(stream, "name", report_file_name(r));
    counts(r, NULL, stream);
    fprintf(stream, " time=\"%.3f\">\n", seconds);
    for (size_t i = 0; i < r->group_count; i++)
        group_suite(r, &r->groups[i], stream);
    waiver_suite(r, stream);
    fputs("</testsuites>\n", stream);
    return fflush(stream) == 0 && !ferror(stream) ? 0 : -EIO;
}
