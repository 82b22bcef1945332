/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "report/report.h"

#include <inttypes.h>
#include <string.h>

static const char *const severity_names[] = { "must", "should", "note" };
static const char *const outcome_names[] = { "pass", "fail", "not judged" };
static const char *const verdict_names[] = { "PASS", "FAIL", "INCOMPLETE" };

struct paint {
    const char *good, *bad, *weak, *strong, *off;
};
static const struct paint plain = { "", "", "", "", "" };
static const struct paint bright = { "\033[32m", "\033[31;1m", "\033[2m", "\033[1m", "\033[0m" };

const char *severity_name(enum severity severity)
{
    return severity_names[severity];
}

const char *outcome_name(enum rule_outcome outcome)
{
    return outcome_names[outcome];
}

const char *verdict_name(enum verdict verdict)
{
    return verdict_names[verdict];
}

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash != NULL && slash[1] != '\0' ? slash + 1 : path;
}

/* Names from outside must not write lines of the report or move the cursor. */
static void print_clean(const char *text, FILE *out)
{
    for (; *text != '\0'; text++)
        fputc((unsigned char)*text < 0x20 || *text == 0x7F ? '?' : *text, out);
}

static void head(const struct report *r, FILE *out, const struct paint *p)
{
    fputs(p->strong, out);
    print_clean(base_name(r->path), out);
    fputs(p->off, out);
    if (r->format[0] != '\0')
        fprintf(out, "  %s %s", r->format, r->target);
    if (r->size < 10240)
        fprintf(out, "  %" PRIu64 " bytes", r->size);
    else
        fprintf(out, "  %.1f KiB", (double)r->size / 1024);
    fprintf(out, "  sha256 %.8s...%s  profile %s (%s)\n", r->sha256,
            strlen(r->sha256) >= 8 ? r->sha256 + strlen(r->sha256) - 8 : "", r->profile,
            r->profile_title);
}

static void group_line(const struct report *r, const struct group_report *group, FILE *out,
                       const struct paint *p)
{
    unsigned count[3] = { 0 };
    for (size_t i = 0; i < r->rule_count; i++)
        if (strcmp(r->rules[i].group, group->name) == 0)
            count[r->rules[i].outcome]++;
    if (count[0] + count[1] + count[2] == 0)
        return;
    char text[128];
    int at = snprintf(text, sizeof text, "%u passed", count[RULE_PASSED]);
    if (count[RULE_FAILED] > 0)
        at += snprintf(text + at, sizeof text - (size_t)at, ", %u failed", count[RULE_FAILED]);
    if (count[RULE_NOT_JUDGED] > 0)
        snprintf(text + at, sizeof text - (size_t)at, ", %u not judged", count[RULE_NOT_JUDGED]);
    const char *colour = count[RULE_FAILED] > 0       ? p->bad
                         : count[RULE_NOT_JUDGED] > 0 ? p->strong
                                                      : p->good;
    fprintf(out, "  %-8s %s%-34s%s %-42s", group->name, colour, text, p->off, group->note);
    if (group->seconds < 1)
        fprintf(out, " %s%5.0f ms%s\n", p->weak, group->seconds * 1e3, p->off);
    else
        fprintf(out, " %s%6.1f s%s\n", p->weak, group->seconds, p->off);
}

static void rule_head(const struct rule_report *rule, const char *mark, const char *colour,
                      FILE *out, const struct paint *p)
{
    fprintf(out, "\n%s%s%s  %s%-22s%s %-8s %s%s%s\n", colour, mark, p->off, p->strong, rule->id,
            p->off, severity_name(rule->severity), p->weak, rule->clause, p->off);
}

static void finding_text(const struct finding *finding, FILE *out, const struct paint *p)
{
    fprintf(out, "      %s%s%s\n", finding->what, finding->when[0] != '\0' ? " " : "",
            finding->when);
    if (finding->place[0] != '\0')
        fprintf(out, "        %s%s%s\n", p->strong, finding->place, p->off);
    if (finding->count > 1)
        fprintf(out, "        seen %" PRIu64 " times, this is the first\n", finding->count);
}

static void rule_failed(const struct rule_report *rule, FILE *out, const struct paint *p)
{
    const char *again = "";
    rule_head(rule, rule->severity == SEVERITY_MUST ? "FAIL" : "warn", p->bad, out, p);
    for (size_t i = 0; i < rule->finding_count; i++) {
        finding_text(&rule->findings[i], out, p);
        if (again[0] == '\0')
            again = rule->findings[i].again;
    }
    if (rule->dropped > 0)
        fprintf(out, "      and %zu more\n", rule->dropped);
    fprintf(out, "      %s\n", rule->advice);
    if (again[0] != '\0') {
        fprintf(out, "      %sagain:%s ", p->weak, p->off);
        print_clean(again, out);
        fputc('\n', out);
    }
    fprintf(out, "      %smore:%s  tgm explain %s\n", p->weak, p->off, rule->id);
}

/* Rules that could not be judged for one and the same reason are named together. */
static void not_judged(const struct report *r, FILE *out, const struct paint *p)
{
    for (size_t i = 0; i < r->rule_count; i++) {
        const struct rule_report *rule = &r->rules[i];
        bool told = rule->outcome != RULE_NOT_JUDGED;
        for (size_t k = 0; k < i && !told; k++)
            told = r->rules[k].outcome == RULE_NOT_JUDGED &&
                   strcmp(r->rules[k].reason, rule->reason) == 0;
        if (told)
            continue;
        fprintf(out, "\n%s----%s  not judged:", p->strong, p->off);
        for (size_t k = i; k < r->rule_count; k++)
            if (r->rules[k].outcome == RULE_NOT_JUDGED &&
                strcmp(r->rules[k].reason, rule->reason) == 0)
                fprintf(out, " %s", r->rules[k].id);
        fprintf(out, "\n      %s\n", rule->reason);
    }
}

void report_text(const struct report *r, FILE *out, bool colour)
{
    const struct paint *p = colour ? &bright : &plain;
    head(r, out, p);
    for (size_t i = 0; i < r->group_count; i++)
        group_line(r, &r->groups[i], out, p);
    for (size_t i = 0; i < r->rule_count; i++)
        if (r->rules[i].outcome == RULE_FAILED)
            rule_failed(&r->rules[i], out, p);
    not_judged(r, out, p);
    char cycles[40] = "";
    if (r->cycles != 0)
        snprintf(cycles, sizeof cycles, " cycles=%" PRIu64, r->cycles);
    fprintf(out, "\n%sRESULT: %s%s (%u passed, %u failed, %u not judged) profile=%s",
            r->verdict == VERDICT_PASS ? p->good : p->bad, verdict_name(r->verdict), p->off,
            r->passed, r->failed, r->not_judged, r->profile);
    if (r->selection != NULL) {
        fputs(" rules=", out);
        print_clean(r->selection, out);
    }
    fprintf(out, "%s seed=0x%" PRIx64 " sha256=%s\n", cycles, r->seed, r->sha256);
}
