/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <inttypes.h>
#include <string.h>

#include "report/html.h"
#include "report/markup.h"

static void cell(FILE *out, const char *attributes, const char *text)
{
    fprintf(out, "<td%s>", attributes);
    markup_text(out, text);
    fputs("</td>", out);
}

static void group_row(const struct report *r, const struct group_report *group, FILE *out)
{
    struct report_tally tally;
    report_tally(r, group->name, &tally);
    if (tally.all == 0)
        return;
    const double all = tally.all;
    const struct html_share shares[] = { { tally.passed / all, "fill-good" },
                                         { tally.failed / all, "fill-bad" },
                                         { tally.warned / all, "fill-warn" },
                                         { tally.waived / all, "fill-weak" },
                                         { tally.not_judged / all, "fill-open" } };
    const struct {
        unsigned count;
        const char *word, *style;
    } words[] = { { tally.failed, "failed", "bad" },
                  { tally.warned, "warned", "warn" },
                  { tally.waived, "waived", "weak" },
                  { tally.not_judged, "not judged", "open" } };
    fputs("<tr>", out);
    cell(out, " class=\"n\"", group->name);
    fputs("<td class=\"bar\">", out);
    html_bar(shares, sizeof shares / sizeof *shares, out);
    fprintf(out, "</td><td>%u passed", tally.passed);
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (words[i].count > 0)
            fprintf(out, ", <span class=\"%s\">%u %s</span>", words[i].style, words[i].count,
                    words[i].word);
    if (group->note[0] != '\0') {
        fputs("<br/><span class=\"weak\">", out);
        markup_text(out, group->note);
        fputs("</span>", out);
    }
    fputs("</td></tr>\n", out);
}

void html_groups(const struct report *r, FILE *out)
{
    fputs("<h2>Rules by group</h2>\n<table>\n", out);
    for (size_t i = 0; i < r->group_count; i++)
        group_row(r, &r->groups[i], out);
    fputs("</table>\n", out);
}

static void finding_item(const struct finding *finding, FILE *out)
{
    fputs("<li>", out);
    markup_text(out, finding->what);
    if (finding->when[0] != '\0') {
        fputs(" <span class=\"weak\">", out);
        markup_text(out, finding->when);
        fputs("</span>", out);
    }
    if (finding->place[0] != '\0') {
        fputs("<br/><code>", out);
        markup_text(out, finding->place);
        fputs("</code>", out);
    }
    if (finding->count > 1)
        fprintf(out, "<br/><span class=\"weak\">seen %" PRIu64 " times, this is the first</span>",
                finding->count);
    fputs("</li>\n", out);
}

static void rule_title(const struct rule_report *rule, const char *style, const char *mark,
                       FILE *out)
{
    fprintf(out, "<article class=\"%s\">\n<h3><span class=\"%s\">%s</span> ", style, style, mark);
    markup_text(out, rule->id);
    fprintf(out, " <span class=\"weak\">%s &#183; ", severity_name(rule->severity));
    markup_text(out, rule->clause);
    fputs("</span></h3>\n<p>", out);
    markup_text(out, rule->title);
    fputs("</p>\n", out);
}

static void failed_rule(const struct report *r, const struct rule_report *rule, FILE *out)
{
    const char *again = "";
    rule_title(rule,
               report_fails(r, rule)  ? "bad"
               : rule->waiver != NULL ? "weak"
                                      : "warn",
               report_fails(r, rule)  ? "FAIL"
               : rule->waiver != NULL ? "WAIVED"
                                      : "WARN",
               out);
    fputs("<ul>\n", out);
    for (size_t i = 0; i < rule->finding_count; i++) {
        finding_item(&rule->findings[i], out);
        if (again[0] == '\0')
            again = rule->findings[i].again;
    }
    if (rule->dropped > 0)
        fprintf(out, "<li class=\"weak\">and %zu more</li>\n", rule->dropped);
    fputs("</ul>\n<p>", out);
    markup_text(out, rule->advice);
    fputs("</p>\n", out);
    if (again[0] != '\0') {
        fputs("<p class=\"again\"><code>", out);
        markup_text(out, again);
        fputs("</code></p>\n", out);
    }
    fputs("</article>\n", out);
}

/* 0: decides the verdict; 1: does not; 2: somebody answers for it. */
static int weight(const struct report *r, const struct rule_report *rule)
{
    return report_fails(r, rule) ? 0 : rule->waiver != NULL ? 2 : 1;
}

void html_failed(const struct report *r, FILE *out)
{
    bool any = false;
    for (int step = 0; step < 3; step++)
        for (size_t i = 0; i < r->rule_count; i++) {
            if (r->rules[i].outcome != RULE_FAILED || weight(r, &r->rules[i]) != step)
                continue;
            if (!any)
                fputs("<h2>What was found</h2>\n", out);
            any = true;
            failed_rule(r, &r->rules[i], out);
        }
}

static bool same_reason(const struct rule_report *a, const struct rule_report *b)
{
    return a->outcome == RULE_NOT_JUDGED && b->outcome == RULE_NOT_JUDGED &&
           strcmp(a->reason, b->reason) == 0;
}

/* Rules that could not be judged for one and the same reason stand together. */
static void reason(const struct report *r, size_t first, FILE *out)
{
    fputs("<article class=\"open\">\n<p>", out);
    markup_text(out, r->rules[first].reason);
    fputs("</p>\n<p class=\"weak\">", out);
    for (size_t i = first; i < r->rule_count; i++)
        if (same_reason(&r->rules[first], &r->rules[i])) {
            fputs(i > first ? ", " : "", out);
            markup_text(out, r->rules[i].id);
        }
    fputs("</p>\n</article>\n", out);
}

void html_not_judged(const struct report *r, FILE *out)
{
    bool any = false;
    for (size_t i = 0; i < r->rule_count; i++) {
        bool told = r->rules[i].outcome != RULE_NOT_JUDGED;
        for (size_t k = 0; k < i && !told; k++)
            told = same_reason(&r->rules[k], &r->rules[i]);
        if (told)
            continue;
        if (!any)
            fputs("<h2>What could not be judged</h2>\n", out);
        any = true;
        reason(r, i, out);
    }
}

void html_waivers(const struct report *r, FILE *out)
{
    if (r->waiver_count == 0)
        return;
    fputs("<h2>Waivers</h2>\n<table>\n<tr><th>rule</th><th>reason</th><th>who answers for it</th>"
          "<th>until</th></tr>\n",
          out);
    for (size_t i = 0; i < r->waiver_count; i++) {
        const struct waiver_report *waiver = &r->waivers[i];
        fputs("<tr>", out);
        cell(out, " class=\"n\"", waiver->rule);
        cell(out, "", waiver->reason);
        cell(out, "", waiver->owner);
        fputs("<td class=\"n\">", out);
        markup_text(out, waiver->expiry);
        fputs(waiver->expired ? " <span class=\"bad\">out of date</span>"
              : !waiver->used ? " <span class=\"weak\">not needed</span>"
                              : "",
              out);
        fputs("</td></tr>\n", out);
    }
    fputs("</table>\n", out);
}

static const char *outcome_style(const struct report *r, const struct rule_report *rule)
{
    return rule->outcome == RULE_PASSED       ? "good"
           : rule->outcome == RULE_NOT_JUDGED ? "open"
           : report_fails(r, rule)            ? "bad"
           : rule->waiver != NULL             ? "weak"
                                              : "warn";
}

void html_rules(const struct report *r, FILE *out)
{
    fputs("<h2>Every rule</h2>\n<table class=\"quiet\">\n"
          "<tr><th>rule</th><th></th><th>what must hold</th><th>outcome</th></tr>\n",
          out);
    for (size_t i = 0; i < r->rule_count; i++) {
        const struct rule_report *rule = &r->rules[i];
        fputs("<tr>", out);
        cell(out, " class=\"n\"", rule->id);
        cell(out, " class=\"weak\"", severity_name(rule->severity));
        fputs("<td>", out);
        markup_text(out, rule->title);
        fputs(" <span class=\"weak\">", out);
        markup_text(out, rule->clause);
        fprintf(out, "</span></td><td class=\"n %s\">%s</td></tr>\n", outcome_style(r, rule),
                rule->waiver != NULL && rule->outcome == RULE_FAILED ? "waived"
                                                                     : outcome_name(rule->outcome));
    }
    fputs("</table>\n", out);
}
