/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <jansson.h>
#include <libxml/parser.h>
#include <libxml/tree.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "report/markup.h"
#include "report_rig.h"

static unsigned times(const char *text, const char *what)
{
    unsigned count = 0;
    for (; (text = strstr(text, what)) != NULL; text += strlen(what))
        count++;
    return count;
}

/* --- text from outside ------------------------------------------------------------------------ */

static void markup_ends_no_element_and_no_attribute(void **state)
{
    char *text = NULL;
    size_t size;
    FILE *stream = open_memstream(&text, &size);
    (void)state;
    markup_text(stream, "<a href=\"x\" b='y'>&amp;");
    fclose(stream);
    assert_string_equal(text, "&lt;a href=&quot;x&quot; b=&#39;y&#39;&gt;&amp;amp;");
    free(text);
}

static void bytes_that_no_document_may_hold_are_replaced(void **state)
{
    static const struct {
        const char *bytes;
        uint32_t first;
        size_t length;
    } rows[] = {
        { "a", 'a', 1 },
        { "\xC3\xA9", 0xE9, 2 },
        { "\xE2\x82\xAC", 0x20AC, 3 },
        { "\xF0\x9F\x98\x80", 0x1F600, 4 },
        { "\x1B[0m", MARKUP_REPLACEMENT, 1 },
        { "\x7F", MARKUP_REPLACEMENT, 1 },
        { "\xC2\x9B", MARKUP_REPLACEMENT, 2 },     /* CSI as one character */
        { "\xC0\xAF", MARKUP_REPLACEMENT, 1 },     /* '/' in two bytes */
        { "\xE0\x80\xAF", MARKUP_REPLACEMENT, 1 }, /* in three */
        { "\xED\xA0\x80", MARKUP_REPLACEMENT, 3 }, /* half of a UTF-16 pair */
        { "\xE2\x80\xAE", MARKUP_REPLACEMENT, 3 }, /* right to left from here */
        { "\xEF\xBF\xBF", MARKUP_REPLACEMENT, 3 }, /* not in XML */
        { "\xF4\x90\x80\x80", MARKUP_REPLACEMENT, 4 },
        { "\xE2\x82", MARKUP_REPLACEMENT, 1 }, /* cut off: nothing beyond the end is read */
        { "\xFF", MARKUP_REPLACEMENT, 1 },
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const char *at = rows[i].bytes;
        assert_int_equal(markup_next(&at), rows[i].first);
        assert_int_equal(at - rows[i].bytes, rows[i].length);
    }
}

static void uris_have_no_spaces_and_no_quotes(void **state)
{
    char uri[64];
    (void)state;
    markup_uri("a b/\"\xC3\xA9.c", uri, sizeof uri);
    assert_string_equal(uri, "a%20b/%22%C3%A9.c");
    markup_uri("xxxxxxxx", uri, 6);
    assert_string_equal(uri, "xxx"); /* room is kept for an encoded byte, whole */
    markup_uri("abc d", uri, 6);
    assert_string_equal(uri, "abc");
}

/* --- text ------------------------------------------------------------------------------------- */

static void text_says_budgets_as_bars_with_the_worst_cycle(void **state)
{
    const struct report report = rig_report();
    char *text = rig_print(&report, rig_text);
    (void)state;
    assert_non_null(strstr(text, "\n  Program_04      6.1 us         25.0 us    "
                                 "\u2587\u2587\u2581\u2581\u2581\u2581\u2581\u2581   24 %   cycle "
                                 "31207 at 250 us\n"));
    assert_non_null(strstr(text, "\n  Program_05      11.3 us        10.0 us    "
                                 "\u2587\u2587\u2587\u2587\u2587\u2587\u2587\u2587  113 %"));
    assert_non_null(strstr(text, "\n  Program_01      0.040 us       200.0 us "));
    assert_non_null(strstr(text, "\n  Program_02      the instrumented CPU has no AVX\n"));
    assert_non_null(strstr(text, "\n  stack           1240 bytes     64.0 KiB   "));
    free(text);
}

static void text_tells_what_decides_from_what_does_not(void **state)
{
    struct report report = rig_report();
    char *text = rig_print(&report, rig_text);
    (void)state;
    assert_non_null(strstr(text, "\nFAIL  write-read-only"));
    assert_non_null(strstr(text, "\nwarn  budget-programs"));
    assert_non_null(strstr(text, "\nnote  debug-lines"));
    assert_non_null(strstr(text, "\nwaived  set-point-steps"));
    assert_non_null(strstr(text, "0 passed, 1 failed, 1 warned, 1 waived, 1 not judged"));
    assert_null(strstr(text, " strict"));
    free(text);
    report.strict = true;
    text = rig_print(&report, rig_text);
    assert_non_null(strstr(text, "\nFAIL  budget-programs"));
    assert_non_null(strstr(text, "\nnote  debug-lines"));
    assert_non_null(strstr(text, " profile=pc4 strict seed=0x1d2f"));
    free(text);
}

static void text_prints_every_waiver_and_who_answers_for_it(void **state)
{
    const struct report report = rig_report();
    char *text = rig_print(&report, rig_text);
    (void)state;
    assert_non_null(strstr(text, "\nwaived  set-point-steps until 2027-03-31 by J. Novak "
                                 "<jn@plant>: homing against a stop\n"));
    assert_non_null(strstr(text, "(out of date: it fails the module; renew it or take it away)\n"));
    assert_null(strchr(text, '\x1B'));
    assert_null(strstr(text, "\xE2\x80\xAE"));
    free(text);
}

/* --- JSON ------------------------------------------------------------------------------------- */

static json_t *parsed(const struct report *report, rig_form *form)
{
    json_error_t error;
    char *text = rig_print(report, form);
    json_t *root = json_loads(text, JSON_REJECT_DUPLICATES, &error);
    if (root == NULL)
        print_error("%s\n", error.text);
    free(text);
    assert_non_null(root);
    return root;
}

static void json_holds_what_the_report_holds(void **state)
{
    const struct report report = rig_report();
    json_t *root = parsed(&report, report_json), *rules = json_object_get(root, "rules");
    const char *verdict, *evidence, *file, *kind, *owner;
    json_int_t waived, line, cycle, events;
    double worst;
    (void)state;
    assert_int_equal(json_unpack(root, "{s:s, s:s, s:{s:I}}", "verdict", &verdict, "evidence",
                                 &evidence, "counts", "waived", &waived),
                     0);
    assert_string_equal(verdict, "FAIL");
    assert_string_equal(evidence, report.evidence);
    assert_int_equal(waived, 1);
    assert_int_equal(json_array_size(rules), report.rule_count);
    assert_int_equal(json_unpack(json_array_get(rules, 4), "{s:[{s:s, s:I, s:I}]}", "findings",
                                 "file", &file, "line", &line, "cycle", &cycle),
                     0);
    assert_string_equal(file, "source/gantry.c");
    assert_int_equal(line, 88);
    assert_int_equal(cycle, 200);
    assert_int_equal(json_unpack(json_array_get(json_object_get(root, "budgets"), 0), "{s:f, s:I}",
                                 "worst", &worst, "cycle", &cycle),
                     0);
    assert_true(worst == 6.1);
    assert_int_equal(cycle, 31207);
    json_t *run = json_array_get(json_object_get(root, "runs"), 0);
    assert_int_equal(json_unpack(run, "{s:I}", "events_dropped", &events), 0);
    assert_int_equal(
        json_unpack(json_array_get(json_object_get(run, "events"), 3), "{s:s}", "kind", &kind), 0);
    assert_string_equal(kind, "incident");
    assert_int_equal(events, 3);
    assert_int_equal(json_array_size(json_object_get(run, "events")), 4);
    assert_int_equal(
        json_unpack(json_array_get(json_object_get(root, "waivers"), 0), "{s:s}", "owner", &owner),
        0);
    assert_string_equal(owner, "J. Novak <jn@plant>");
    json_decref(root);
}

/* --- JUnit ------------------------------------------------------------------------------------ */

static xmlDoc *xml(const struct report *report, rig_form *form)
{
    char *text = rig_print(report, form);
    xmlDoc *document = xmlReadMemory(text, (int)strlen(text), NULL, NULL, XML_PARSE_NONET);
    free(text);
    assert_non_null(document);
    return document;
}

static int number(const xmlNode *node, const char *name)
{
    xmlChar *value = xmlGetProp(node, (const xmlChar *)name);
    const int result = value != NULL ? atoi((const char *)value) : -1;
    xmlFree(value);
    return result;
}

static unsigned count_elements(const xmlNode *node, const char *name)
{
    unsigned count = 0;
    for (; node != NULL; node = node->next)
        count += (node->type == XML_ELEMENT_NODE && strcmp((const char *)node->name, name) == 0) +
                 count_elements(node->children, name);
    return count;
}

static void junit_fails_exactly_when_the_verdict_does(void **state)
{
    struct report report = rig_report();
    xmlDoc *document = xml(&report, report_junit);
    const xmlNode *root = xmlDocGetRootElement(document);
    (void)state;
    /* Nine rules, and a waiver that is out of date. */
    assert_int_equal(number(root, "tests"), 10);
    assert_int_equal(number(root, "failures"), 3);
    assert_int_equal(number(root, "errors"), 1);
    assert_int_equal(number(root, "skipped"), 4);
    assert_int_equal(count_elements(root, "testcase"), 10);
    assert_int_equal(count_elements(root, "failure"), 3);
    assert_int_equal(count_elements(root, "error"), 1);
    assert_int_equal(count_elements(root, "skipped"), 4);
    assert_int_equal(count_elements(root, "testsuite"), 5); /* none for a group without rules */
    xmlFreeDoc(document);
    report.strict = true;
    document = xml(&report, report_junit);
    root = xmlDocGetRootElement(document);
    assert_int_equal(number(root, "failures"), 4);
    assert_int_equal(number(root, "errors"), 2);
    xmlFreeDoc(document);
    report = rig_quiet_report();
    document = xml(&report, report_junit);
    root = xmlDocGetRootElement(document);
    assert_int_equal(number(root, "failures"), 0);
    assert_int_equal(number(root, "errors"), 0);
    assert_int_equal(number(root, "skipped"), 0);
    xmlFreeDoc(document);
}

static void junit_takes_any_bytes_as_text(void **state)
{
    const struct report report = rig_report();
    xmlDoc *document = xml(&report, report_junit);
    char *text = rig_print(&report, report_junit);
    (void)state;
    assert_int_equal(count_elements(xmlDocGetRootElement(document), "script"), 0);
    assert_int_equal(times(text, "message=\"exports &lt;script&gt;"), 1);
    assert_null(strchr(text, '\x1B'));
    free(text);
    xmlFreeDoc(document);
}

/* --- SARIF ------------------------------------------------------------------------------------ */

static json_t *sarif_results(json_t *root)
{
    return json_object_get(json_array_get(json_object_get(root, "runs"), 0), "results");
}

static void sarif_has_a_result_for_every_finding_and_every_other_rule(void **state)
{
    static const struct {
        const char *rule, *kind, *level;
    } wanted[] = {
        { "export-names", "fail", "error" },
        { "no-imports", "pass", "none" },
        { "debug-lines", "fail", "note" },
        { "ini-returns-one", "pass", "none" },
        { "write-read-only", "fail", "error" },
        { "budget-programs", "fail", "warning" },
        { "set-point-steps", "fail", "error" },
        { "budget-program-05", "open", "none" },
        { "torn", "open", "none" },
    };
    const struct report report = rig_report();
    json_t *root = parsed(&report, report_sarif), *results = sarif_results(root);
    (void)state;
    assert_int_equal(json_array_size(results), 9);
    for (size_t i = 0; i < 9; i++) {
        const char *rule, *kind, *level;
        json_int_t index;
        assert_int_equal(json_unpack(json_array_get(results, i), "{s:s, s:s, s:s, s:I}", "ruleId",
                                     &rule, "kind", &kind, "level", &level, "ruleIndex", &index),
                         0);
        assert_string_equal(rule, wanted[i].rule);
        assert_string_equal(kind, wanted[i].kind);
        assert_string_equal(level, wanted[i].level);
        assert_int_equal(index, i);
        assert_int_equal(json_object_get(json_array_get(results, i), "suppressions") != NULL,
                         i == 6);
    }
    json_decref(root);
}

static void sarif_tells_of_waivers_that_are_out_of_date(void **state)
{
    const struct report report = rig_report();
    json_t *root = parsed(&report, report_sarif), *notes;
    const char *level, *text, *rule;
    (void)state;
    assert_int_equal(json_unpack(root, "{s:[{s:[{s:o}]}]}", "runs", "invocations",
                                 "toolConfigurationNotifications", &notes),
                     0);
    assert_int_equal(json_array_size(notes), 1);
    assert_int_equal(json_unpack(json_array_get(notes, 0), "{s:s, s:{s:s}, s:{s:s}}", "level",
                                 &level, "message", "text", &text, "associatedRule", "id", &rule),
                     0);
    assert_string_equal(level, "error");
    assert_string_equal(rule, "inputs-first");
    assert_non_null(strstr(text, "out of date since 2020-01-01 (nobody: "));
    json_decref(root);
}

static void sarif_names_source_line_and_address(void **state)
{
    const struct report report = rig_report();
    json_t *root = parsed(&report, report_sarif);
    json_t *result = json_array_get(sarif_results(root), 4);
    const char *uri, *base, *function;
    json_int_t line, address, count;
    (void)state;
    assert_int_equal(
        json_unpack(result, "{s:[{s:{s:{s:s, s:s}, s:{s:I}, s:{s:I}}, s:[{s:s}]}], s:I}",
                    "locations", "physicalLocation", "artifactLocation", "uri", &uri, "uriBaseId",
                    &base, "region", "startLine", &line, "address", "relativeAddress", &address,
                    "logicalLocations", "fullyQualifiedName", &function, "occurrenceCount", &count),
        0);
    assert_string_equal(uri, "source/gantry.c");
    assert_string_equal(base, "SRCROOT");
    assert_int_equal(line, 88);
    assert_int_equal(address, 0x1a4);
    assert_string_equal(function, "Program_04");
    assert_int_equal(count, 1800);
    json_decref(root);
}

static void sarif_prints_do_not_depend_on_cycle_or_line(void **state)
{
    const struct report report = rig_report();
    const struct finding before = rig_findings[0];
    char *first, *second;
    json_t *root = parsed(&report, report_sarif);
    (void)state;
    first = json_dumps(
        json_object_get(json_array_get(sarif_results(root), 4), "partialFingerprints"), 0);
    json_decref(root);
    rig_findings[0].line = 99;
    rig_findings[0].cycle = 7;
    snprintf(rig_findings[0].when, sizeof rig_findings[0].when, "in cycle 7");
    root = parsed(&report, report_sarif);
    second = json_dumps(
        json_object_get(json_array_get(sarif_results(root), 4), "partialFingerprints"), 0);
    json_decref(root);
    rig_findings[0] = before;
    assert_string_equal(first, second);
    assert_int_equal(strlen(first), strlen("{\"tgmFinding/v1\": \"\"}") + 64);
    free(first);
    free(second);
}

/* --- HTML ------------------------------------------------------------------------------------- */

static void html_is_one_file_without_script_or_resource(void **state)
{
    const struct report report = rig_report();
    char *text = rig_print(&report, report_html);
    (void)state;
    assert_null(strstr(text, "<script"));
    assert_null(strstr(text, "<link"));
    assert_null(strstr(text, "<img"));
    assert_null(strstr(text, " src="));
    assert_null(strstr(text, "href"));
    assert_null(strstr(text, "url("));
    assert_null(strstr(text, "@import"));
    assert_null(strstr(text, "://"));
    assert_non_null(strstr(text, "default-src 'none'"));
    free(text);
}

static void html_takes_any_bytes_as_text(void **state)
{
    const struct report report = rig_report();
    char *text = rig_print(&report, report_html);
    (void)state;
    assert_true(times(text, "&lt;script&gt;alert(1)&lt;/script&gt;&quot; onload=&#39;x&#39;") >= 5);
    assert_null(strchr(text, '\x1B'));
    assert_null(strchr(text, '\xFF'));
    assert_null(strstr(text, "\xE2\x80\xAE"));
    free(text);
}

/* What the browser forgives, a reader of the archive in twenty years may not. */
static void html_body_is_well_formed(void **state)
{
    struct report reports[] = { rig_report(), rig_quiet_report() };
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        char *text = rig_print(&reports[i], report_html), *body = strstr(text, "<body>");
        *strstr(body, "</html>") = '\0';
        xmlDoc *document = xmlReadMemory(body, (int)strlen(body), NULL, NULL, XML_PARSE_NONET);
        assert_non_null(document);
        xmlFreeDoc(document);
        free(text);
    }
}

static void html_shows_budgets_coverage_runs_and_curves(void **state)
{
    struct report report = rig_report();
    char *text = rig_print(&report, report_html);
    (void)state;
    assert_non_null(strstr(text, "<b>FAIL</b>"));
    assert_non_null(strstr(
        text, "2 of 9 rules passed. 2 failed. 1 failed without deciding the verdict. 1 note."));
    assert_int_equal(times(text, "class=\"limit\""), 4); /* five budgets, one not judged */
    assert_non_null(strstr(text, "113.0 %"));
    assert_non_null(strstr(text, "90 %"));
    assert_non_null(strstr(text, "frame 200 lost <span class=\"weak\">&#215; 40</span>"));
    assert_int_equal(times(text, "<path"), 6); /* a band and a line each */
    assert_non_null(strstr(text, "SERVO[1].Position"));
    assert_null(strstr(text, "nan"));
    free(text);
    report = rig_quiet_report();
    text = rig_print(&report, report_html);
    assert_non_null(strstr(text, "<b>PASS</b>"));
    assert_null(strstr(text, "<h2>Budgets"));
    assert_null(strstr(text, "<h2>Runs"));
    assert_null(strstr(text, "What was found"));
    free(text);
}

static void html_is_the_same_however_long_the_check_took(void **state)
{
    const struct report report = rig_report();
    char *first = rig_print(&report, report_html), *second;
    (void)state;
    rig_groups[2].seconds = 99;
    second = rig_print(&report, report_html);
    rig_groups[2].seconds = 2.1;
    assert_string_equal(first, second);
    free(first);
    free(second);
}

/* For tests/reports.sh, which holds them against what others say a report is. */
static void reports_are_left_for_others_to_read(void **state)
{
    static const struct {
        const char *name;
        rig_form *form;
    } forms[] = { { "rich.txt", rig_text },
                  { "rich.json", report_json },
                  { "rich.xml", report_junit },
                  { "rich.sarif", report_sarif },
                  { "rich.html", report_html } };
    const struct report report = rig_report();
    (void)state;
    mkdir(TEST_REPORTS_DIR, 0777);
    for (size_t i = 0; i < sizeof forms / sizeof *forms; i++) {
        char path[256];
        snprintf(path, sizeof path, "%s/%s", TEST_REPORTS_DIR, forms[i].name);
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        assert_int_equal(forms[i].form(&report, file), 0);
        assert_int_equal(fclose(file), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(markup_ends_no_element_and_no_attribute),
        cmocka_unit_test(bytes_that_no_document_may_hold_are_replaced),
        cmocka_unit_test(uris_have_no_spaces_and_no_quotes),
        cmocka_unit_test(text_says_budgets_as_bars_with_the_worst_cycle),
        cmocka_unit_test(text_tells_what_decides_from_what_does_not),
        cmocka_unit_test(text_prints_every_waiver_and_who_answers_for_it),
        cmocka_unit_test(json_holds_what_the_report_holds),
        cmocka_unit_test(junit_fails_exactly_when_the_verdict_does),
        cmocka_unit_test(junit_takes_any_bytes_as_text),
        cmocka_unit_test(sarif_has_a_result_for_every_finding_and_every_other_rule),
        cmocka_unit_test(sarif_tells_of_waivers_that_are_out_of_date),
        cmocka_unit_test(sarif_names_source_line_and_address),
        cmocka_unit_test(sarif_prints_do_not_depend_on_cycle_or_line),
        cmocka_unit_test(html_is_one_file_without_script_or_resource),
        cmocka_unit_test(html_takes_any_bytes_as_text),
        cmocka_unit_test(html_body_is_well_formed),
        cmocka_unit_test(html_shows_budgets_coverage_runs_and_curves),
        cmocka_unit_test(html_is_the_same_however_long_the_check_took),
        cmocka_unit_test(reports_are_left_for_others_to_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
