/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "report/report.h"

#include <inttypes.h>
#include <string.h>

#include "report/markup.h"

struct paint {
    const char *good, *bad, *weak, *strong, *off;
};
static const struct paint plain = { "", "", "", "", "" };
static const struct paint bright = { "\033[32m", "\033[31;1m", "\033[2m", "\033[1m", "\033[0m" };

static void head(const struct report *r, FILE *out, const struct paint *p)
{
    fputs(p->strong, out);
    markup_plain(out, report_file_name(r));
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
    struct report_tally tally;
    report_tally(r, group->name, &tally);
    const struct {
        unsigned count;
        const char *word;
    } words[] = { { tally.failed, "failed" },
                  { tally.warned, "warned" },
                  { tally.noted, tally.noted == 1 ? "note" : "notes" },
                  { tally.waived, "waived" },
                  { tally.not_judged, "not judged" } };
    char text[128];
    if (tally.all == 0)
        return;
    int at = snprintf(text, sizeof text, "%u passed", tally.passed);
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (words[i].count > 0)
            at += snprintf(text + at, sizeof text - (size_t)at, ", %u %s", words[i].count,
                           words[i].word);
    const char *colour = tally.failed > 0            ? p->bad
                         : tally.passed == tally.all ? p->good
                                                     : p->strong;
    fprintf(out, "  %-9s %s%-33s%s %-42s", group->name, colour, text, p->off, group->note);
    if (group->seconds < 1)
        fprintf(out, " %s%5.0f ms%s\n", p->weak, group->seconds * 1e3, p->off);
    else
        fprintf(out, " %s%6.1f s%s\n", p->weak, group->seconds, p->off);
}

/* A bar of eight: what is taken of what is allowed. */
static void bar(double share, FILE *out)
{
    const int full = share >= 1 ? 8 : (int)(share * 8 + 0.5);
    for (int i = 0; i < 8; i++)
        fputs(i < full ? "\u2587" : "\u2581", out);
}

/* 6.1 us, 25.0 us, 640 bytes, 1.2 KiB */
static void amount(double value, const char *unit, char out[32])
{
    if (strcmp(unit, "bytes") != 0)
        snprintf(out, 32, "%.*f %s", value < 0.095 ? 3 : value < 0.95 ? 2 : 1, value, unit);
    else if (value < 10240)
        snprintf(out, 32, "%.0f bytes", value);
    else
        snprintf(out, 32, "%.1f KiB", value / 1024);
}

static void budget_line(const struct budget_report *budget, FILE *out, const struct paint *p)
{
    char worst[32], allowed[32] = "";
    if (budget->reason[0] != '\0') {
        fprintf(out, "  %-15s %s%s%s\n", budget->name, p->weak, budget->reason, p->off);
        return;
    }
    amount(budget->worst, budget->unit, worst);
    if (budget->allowed > 0)
        amount(budget->allowed, budget->unit, allowed);
    fprintf(out, "  %-15s %-14s %-10s ", budget->name, worst, allowed);
    if (budget->allowed > 0) {
        const double share = budget_share(budget);
        fputs(share > 1 ? p->bad : p->good, out);
        bar(share, out);
        fprintf(out, "%s %4.0f %%", p->off, share * 100);
    }
    if (budget->has_cycle)
        fprintf(out, "   %scycle %" PRIu64 "%s", p->weak, budget->cycle, p->off);
    if (budget->has_cycle && budget->cycle_us != 0)
        fprintf(out, " %sat %" PRIu32 " us%s", p->weak, budget->cycle_us, p->off);
    fputc('\n', out);
}

static void budgets(const struct report *r, FILE *out, const struct paint *p)
{
    if (r->budget_count == 0)
        return;
    fprintf(out, "\n  %s%-15s %-14s %-10s share%s\n", p->weak, "budget", "worst", "allowed",
            p->off);
    for (size_t i = 0; i < r->budget_count; i++)
        budget_line(&r->budgets[i], out, p);
}

/* Every one, on every report: whoever reads it knows who answers for what. */
static void waivers(const struct report *r, FILE *out, const struct paint *p)
{
    if (r->waiver_count > 0)
        fputc('\n', out);
    for (size_t i = 0; i < r->waiver_count; i++) {
        const struct waiver_report *waiver = &r->waivers[i];
        fprintf(out, "%swaived%s  %s%s%s until %s by ", waiver->expired ? p->bad : p->strong,
                p->off, p->strong, waiver->rule, p->off, waiver->expiry);
        markup_plain(out, waiver->owner);
        fputs(": ", out);
        markup_plain(out, waiver->reason);
        fputs(waiver->expired ? " (out of date: it fails the module; renew it or take it away)"
              : !waiver->used ? " (not needed: the rule did not fail)"
                              : "",
              out);
        fputc('\n', out);
    }
}

static void rule_head(const struct rule_report *rule, const char *mark, const char *colour,
                      FILE *out, const struct paint *p)
{
    fprintf(out, "\n%s%s%s  %s%-22s%s %-8s %s%s%s\n", colour, mark, p->off, p->strong, rule->id,
            p->off, severity_name(rule->severity), p->weak, rule->clause, p->off);
}

static void finding_text(const struct finding *finding, FILE *out, const struct paint *p)
{
    fputs("      ", out);
    markup_plain(out, finding->what);
    fprintf(out, "%s%s\n", finding->when[0] != '\0' ? " " : "", finding->when);
    if (finding->place[0] != '\0') {
        fprintf(out, "        %s", p->strong);
        markup_plain(out, finding->place);
        fprintf(out, "%s\n", p->off);
    }
    if (finding->count > 1)
        fprintf(out, "        seen %" PRIu64 " times, this is the first\n", finding->count);
}

static void rule_failed(const struct report *r, const struct rule_report *rule, FILE *out,
                        const struct paint *p)
{
    const char *again = "", *debug = "";
    rule_head(rule,
              rule->waiver != NULL              ? "waived"
              : report_fails(r, rule)           ? "FAIL"
              : rule->severity == SEVERITY_NOTE ? "note"
                                                : "warn",
              report_fails(r, rule) ? p->bad : p->strong, out, p);
    for (size_t i = 0; i < rule->finding_count; i++) {
        finding_text(&rule->findings[i], out, p);
        if (again[0] == '\0')
            again = rule->findings[i].again;
        if (debug[0] == '\0')
            debug = rule->findings[i].debug;
    }
    if (rule->dropped > 0)
        fprintf(out, "      and %zu more\n", rule->dropped);
    fprintf(out, "      %s\n", rule->advice);
    if (again[0] != '\0') {
        fprintf(out, "      %sagain:%s ", p->weak, p->off);
        markup_plain(out, again);
        fputc('\n', out);
    }
    if (debug[0] != '\0') {
        fprintf(out, "      %sdebug:%s ", p->weak, p->off);
        markup_plain(out, debug);
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
        fputs("\n      ", out);
        markup_plain(out, rule->reason);
        fputc('\n', out);
    }
}

void report_text(const struct report *r, FILE *out, bool colour)
{
    const struct paint *p = colour ? &bright : &plain;
    head(r, out, p);
    for (size_t i = 0; i < r->group_count; i++)
        group_line(r, &r->groups[i], out, p);
    budgets(r, out, p);
    for (size_t i = 0; i < r->rule_count; i++)
        if (r->rules[i].outcome == RULE_FAILED)
            rule_failed(r, &r->rules[i], out, p);
    not_judged(r, out, p);
    waivers(r, out, p);
    char cycles[40] = "", notes[32] = "";
    if (r->noted > 0)
        snprintf(notes, sizeof notes, ", %u note%s", r->noted, r->noted == 1 ? "" : "s");
    if (r->cycles != 0)
        snprintf(cycles, sizeof cycles, " cycles=%" PRIu64, r->cycles);
    fprintf(out, "\n%sRESULT: %s%s (%u passed, %u failed, %u not judged%s) profile=%s",
            r->verdict == VERDICT_PASS ? p->good : p->bad, verdict_name(r->verdict), p->off,
            r->passed, r->failed, r->not_judged, notes, r->profile);
    if (r->selection != NULL) {
        fputs(" rules=", out);
        markup_plain(out, r->selection);
    }
    if (r->config != NULL) {
        fputs(" config=", out);
        markup_plain(out, r->config);
    }
    fprintf(out, "%s%s%s seed=0x%" PRIx64 " sha256=%s\n", r->strict ? " strict" : "",
            r->instrumented ? " instrumented" : "", cycles, r->seed, r->sha256);
}
