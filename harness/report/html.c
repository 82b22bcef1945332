/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "report/html.h"

#include <errno.h>
#include <inttypes.h>

#include "report/markup.h"

extern const char report_style[]; /* style.S */

/* Nothing is loaded and nothing runs, whatever the file's names are made of. */
static void head(const struct report *r, FILE *out)
{
    fputs("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
          "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
          "'unsafe-inline'\">\n"
          "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>",
          out);
    fprintf(out, "%s ", verdict_name(r->verdict));
    markup_text(out, report_file_name(r));
    fputs("</title>\n<style>\n", out);
    fputs(report_style, out);
    fputs("</style>\n</head>\n<body>\n", out);
}

static void title(const struct report *r, FILE *out)
{
    fputs("<header>\n<p class=\"kicker\">Conformance of a TG Motion PLC module</p>\n<h1>", out);
    markup_text(out, report_file_name(r));
    fputs("</h1>\n<p class=\"weak\">", out);
    if (r->format[0] != '\0') {
        markup_text(out, r->format);
        fputc(' ', out);
        markup_text(out, r->target);
        fputs(" &#183; ", out);
    }
    fprintf(out, "%" PRIu64 " bytes &#183; profile ", r->size);
    markup_text(out, r->profile);
    fputs(" (", out);
    markup_text(out, r->profile_title);
    fputs(")</p>\n</header>\n", out);
}

static void counted(FILE *out, unsigned count, const char *one, const char *many)
{
    if (count > 0)
        fprintf(out, " %u %s.", count, count == 1 ? one : many);
}

static void verdict(const struct report *r, FILE *out)
{
    struct report_tally tally;
    report_tally(r, NULL, &tally);
    fprintf(out, "<section class=\"verdict %s\">\n<b>%s</b>\n<p>", verdict_name(r->verdict),
            verdict_name(r->verdict));
    fprintf(out, "%u of %u rules passed.", tally.passed, tally.all);
    counted(out, tally.failed, "failed", "failed");
    counted(out, tally.warned, "failed without deciding the verdict",
            "failed without deciding the verdict");
    counted(out, tally.noted, "note", "notes");
    counted(out, tally.waived, "failed and is waived", "failed and are waived");
    counted(out, tally.not_judged, "could not be judged", "could not be judged");
    if (r->selection != NULL) {
        fputs(" Only rules that match <code>", out);
        markup_text(out, r->selection);
        fputs("</code> were asked for: no verdict over the whole module.", out);
    }
    fputs("</p>\n</section>\n", out);
}

static void fact(FILE *out, const char *name, const char *value, bool code)
{
    if (value == NULL)
        return;
    fprintf(out, "<dt>%s</dt><dd>%s", name, code ? "<code>" : "");
    markup_text(out, value);
    fprintf(out, "%s</dd>\n", code ? "</code>" : "");
}

static void facts(const struct report *r, FILE *out)
{
    char number[24], runs[96];
    fputs("<dl>\n", out);
    fact(out, "Module", r->path, true);
    fact(out, "SHA-256", r->sha256, true);
    fact(out, "Judged by", r->tool, false);
    fact(out, "Rule book", r->rule_book, true);
    fact(out, "Evidence", r->evidence, true);
    snprintf(number, sizeof number, "0x%" PRIx64, r->seed);
    fact(out, "Seed", number, true);
    fact(out, "Configuration", r->config, true);
    if (r->cycles != 0) {
        snprintf(number, sizeof number, "%" PRIu64, r->cycles);
        fact(out, "Cycles of a run", number, false);
    }
    if (r->runs_all > 0) {
        snprintf(runs, sizeof runs, "%u, %u of them on the instrumented machine (emulated CPU)",
                 r->runs_all, r->runs_emulated);
        fact(out, "Runs", runs, false);
    }
    if (r->strict)
        fact(out, "Strict", "\"should\" rules decide, too", false);
    fputs("</dl>\n", out);
}

static void foot(const struct report *r, FILE *out)
{
    fputs("<footer><p>", out);
    fprintf(out,
            "RESULT: %s (%u passed, %u failed, %u not judged) profile=", verdict_name(r->verdict),
            r->passed, r->failed, r->not_judged);
    markup_text(out, r->profile);
    fprintf(out, " seed=0x%" PRIx64 "</p>\n", r->seed);
    fputs("<p>All times are machine time: the same module, seed and program give the same report."
          "</p></footer>\n</body>\n</html>\n",
          out);
}

int report_html(const struct report *r, FILE *stream)
{
    head(r, stream);
    title(r, stream);
    verdict(r, stream);
    facts(r, stream);
    html_failed(r, stream);
    html_not_judged(r, stream);
    html_waivers(r, stream);
    html_groups(r, stream);
    html_budgets(r, stream);
    html_coverage(r, stream);
    html_plots(r, stream);
    html_runs(r, stream);
    html_rules(r, stream);
    foot(r, stream);
    return fflush(stream) == 0 && !ferror(stream) ? 0 : -EIO;
}
