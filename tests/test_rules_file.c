/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_rules_file.c - what the rules about the file say, and where: beyond their fixtures, on
 * modules of every format and on images made by hand.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "conformance/rules_file.h"

static struct image *opened(const char *directory, const char *name)
{
    struct image *image;
    char path[512], why[IMAGE_WHY];
    snprintf(path, sizeof path, "%s/%s", directory, name);
    if (image_open(&image, path, why) != 0)
        fail_msg("%s", why);
    return image;
}

static struct image *module_of(const char *name)
{
    return opened(TEST_MODULES_DIR, name);
}

static void judge(const struct image *image, const char *profile, const char *rule,
                  struct findings *findings)
{
    const struct case_file file = {
        .image = image, .profile = profile_find(profile), .name = "x.tgm", .cannot_run = ""
    };
    memset(findings, 0, sizeof *findings);
    rule_find(rule)->check(&file, findings);
}

/* Some finding says all of what, at a place that holds the other text. */
static void expect(const struct findings *findings, const char *what, const char *place)
{
    for (size_t i = 0; i < findings->count; i++)
        if (strstr(findings->list[i].what, what) != NULL &&
            strstr(findings->list[i].place, place) != NULL)
            return;
    for (size_t i = 0; i < findings->count; i++)
        print_message("  %s [%s]\n", findings->list[i].what, findings->list[i].place);
    fail_msg("no finding says '%s' at '%s' (%s)", what, place, findings->reason);
}

/* ---- names ---- */

static void names_are_recognised_however_a_compiler_decorates_them(void **state)
{
    static const struct {
        const char *name;
        enum name_style style;
    } meant[] = {
        { "Program_01", NAME_PLAIN },
        { "program_01", NAME_CASE },
        { "PROGRAM_01", NAME_CASE },
        { "_Program_01", NAME_UNDERSCORE },
        { "__Program_01", NAME_UNDERSCORE },
        { "Program_01@4", NAME_STDCALL },
        { "_Program_01@4", NAME_STDCALL },
        { "_Program_01@12", NAME_STDCALL },
        { "@Program_01@4", NAME_FASTCALL },
        { "Program_01@@8", NAME_VECTORCALL },
        { "_Z10Program_01P8PLC_DATA", NAME_CPP },
        { "__Z10Program_01P8PLC_DATA", NAME_CPP },
        { "_ZL10Program_01P8PLC_DATA", NAME_CPP },
        { "_ZN7machine10Program_01EP8PLC_DATA", NAME_CPP },
        { "_ZN1a1b10Program_01Ev", NAME_CPP },
        { "?Program_01@@YAJPEAUPLC_DATA@@@Z", NAME_CPP },
        { "?Program_01@machine@@YAJPEAUPLC_DATA@@@Z", NAME_CPP },
        { "?Program_01@@YAJPAUPLC_DATA@@@Z", NAME_CPP },
        { "GANTRY_$$_PROGRAM_01$PPLC_DATA$$LONGINT", NAME_PASCAL },
        { "P$GANTRY_$$_PROGRAM_01$PPLC_DATA$$LONGINT", NAME_PASCAL },
    };
    static const char *const others[] = {
        "",
        "_",
        "Program_02",
        "Program_011",
        "Program_0",
        "Program_01@",
        "Program_01@x",
        "Program_01x@4",
        "@",
        "_Z",
        "_ZN",
        "_Z10",
        "_Z10Program_0",
        "_Z11Program_01xv",
        "_Z99999999999999999999Program_01",
        "_ZN10Program_013fooEv",
        "?",
        "?Program_01",
        "?Program_02@@YAJXZ",
        "GANTRY_$$_PROGRAM_02$$LONGINT",
        "GANTRY_$$_",
        "Program_01$$x",
    };
    enum name_style style;
    (void)state;
    for (size_t i = 0; i < sizeof meant / sizeof meant[0]; i++)
        if (!name_is_meant(meant[i].name, "Program_01", &style) || style != meant[i].style)
            fail_msg("%s", meant[i].name);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        if (name_is_meant(others[i], "Program_01", &style))
            fail_msg("%s", others[i]);
}

static void library_functions_are_told_by_name(void **state)
{
    (void)state;
    assert_string_equal(runtime_symbol("malloc"), "an allocator");
    assert_string_equal(runtime_symbol("_malloc"), "an allocator");
    assert_string_equal(runtime_symbol("_start"), "start-up code");
    assert_string_equal(runtime_symbol("__libc_start_main"), "start-up code");
    assert_string_equal(runtime_symbol("_DllMainCRTStartup@12"), "start-up code");
    assert_string_equal(runtime_symbol("??2@YAPEAX_K@Z"), "the allocator of C++");
    assert_null(runtime_symbol("start"));
    assert_null(runtime_symbol("abort"));
    assert_null(runtime_symbol("mallocate"));
    assert_null(runtime_symbol("mallo"));
    assert_null(runtime_symbol("Program_01"));
    assert_null(runtime_symbol(""));
    assert_null(runtime_symbol("_"));
}

/* ---- whole files ---- */

static void a_module_that_leans_on_the_c_library_is_told_so_line_by_line(void **state)
{
    struct findings found;
    (void)state;
    struct image *image = module_of("libc.so");
    judge(image, "pc4", "no-imports", &found);
    expect(&found, "printf is not defined in the module; TG Motion prints with",
           "(Program_01) tests/modules/image_libc.c:11");
    expect(&found, "the module needs the library libc.so.6", "");
    judge(image, "pc4", "no-runtime-library", &found);
    expect(&found, "frame_dummy is in the module: start-up code", "(frame_dummy)");
    judge(image, "pc4", "no-initialisers", &found);
    expect(&found, "DT_INIT_ARRAY entry 0", "(frame_dummy)");
    judge(image, "pc4", "export-names", &found);
    expect(&found, "Program_02 is missing: all six functions must exist", "");
    image_close(image);
}

static void a_flat_image_without_the_table_of_its_functions_is_told_so(void **state)
{
    static struct case_run runs[EXPERIMENT_COUNT];
    static struct findings found;
    struct image *image = opened(FIXTURE_DIR, "export-names/bad-flat-forgotten.tgm.bin");
    const struct case_file file = { .image = image,
                                    .profile = profile_find("tgmcontroller"),
                                    .name = "x.tgm.bin",
                                    .runs = runs,
                                    .cannot_run = "" };
    struct evidence_lookup *lookup = &runs[EXPERIMENT_START].result.evidence.lookup;
    (void)state;
    runs[EXPERIMENT_START].ran = true;
    *lookup = (struct evidence_lookup){ .asked = true, .table = 0x01234568 };
    rule_find("export-names")->check(&file, &found);
    expect(&found, "hands out no table of the five functions", "");
    expect(&found, "0x01234568", "");
    assert_int_equal(found.count, 1); /* with no name known, none is missing */
    memset(&found, 0, sizeof found);
    lookup->found = true;
    for (int i = 0; i < 5; i++)
        lookup->functions[i] = (uint32_t)image->entry_point | 1;
    rule_find("export-names")->check(&file, &found);
    assert_int_equal(found.count, 0);
    assert_string_equal(found.reason, "");
    image_close(image);
}

static void what_windows_would_have_to_do_for_a_module_is_named(void **state)
{
    struct findings found;
    (void)state;
    struct image *image = module_of("pe_mingw_x86_64.dll");
    judge(image, "pc4", "no-imports", &found);
    expect(&found, "OTHER.dll!by_name is imported", "(Program_01)");
    expect(&found, "the module needs the library OTHER.dll", "");
    assert_int_equal(found.count, 3); /* forwarded exports are none of its business */
    judge(image, "pc4", "no-tls", &found);
    expect(&found, "TLS callback 0 would have to run at every thread's start", "(first)");
    expect(&found, "TLS callback 1", "(second)");
    judge(image, "pc4", "no-initialisers", &found);
    assert_int_equal(found.count, 0);
    judge(image, "pc4", "no-entry-point", &found);
    assert_int_equal(found.count, 0);
    image_close(image);
    image = module_of("pe_delay_x86_64.dll");
    judge(image, "pc4", "no-imports", &found);
    expect(&found, "OTHER.dll!by_name is imported at its first call (delay import)", "");
    expect(&found, "the module needs the library OTHER.dll, loaded at the first call", "");
    image_close(image);
    image = module_of("entry_writes.dll");
    judge(image, "pc4", "no-entry-point", &found);
    expect(&found, "the entry point (DllMain or a library's start-up code) does something",
           "(DllMain)");
    image_close(image);
}

static void instructions_are_named_with_the_export_that_leads_to_them(void **state)
{
    struct findings found;
    (void)state;
    struct image *image = module_of("census.so");
    judge(image, "pc4", "no-system-instruction", &found);
    expect(&found,
           "`int 0x80` asks an operating system, monitor or debugger; control comes there "
           "from calls",
           "(callee)");
    assert_int_equal(found.count, 3 + 1);
    assert_string_equal(found.reason, "");
    judge(image, "pc4", "no-privileged-instruction", &found);
    expect(&found,
           "`rdmsr` commands the processor or the machine itself; control comes there from "
           "a call through a pointer",
           "(unknown_pointer)");
    judge(image, "pc4", "suspicious-code", &found);
    expect(&found, "`sysenter` stands in a function that nothing was seen to call", "(dead)");
    expect(&found, "the bytes of `int 0x2e` stand in executable memory, outside all code",
           "(at_bytes)");
    assert_int_equal(found.count, 2);
    image_close(image);
    image = module_of("census_sizeless.so");
    judge(image, "pc4", "repeatable-instructions", &found);
    if (strstr(found.reason, "the code was not read to its end: the jump at x.tgm+0x") == NULL)
        fail_msg("reason: %s", found.reason);
    image_close(image);
}

static void the_same_rules_judge_arm(void **state)
{
    struct findings found;
    (void)state;
    struct image *image = module_of("census_arm.so");
    judge(image, "tgmmini", "no-privileged-instruction", &found);
    expect(&found, "`cpsid i` commands the processor", "(privileged)");
    judge(image, "tgmmini", "no-thread-block", &found);
    expect(&found, "control comes there from thread", "(thread)");
    judge(image, "pc4", "no-thread-block", &found);
    assert_int_equal(found.count, 0);
    assert_string_not_equal(found.reason, "");
    image_close(image);
}

static void without_a_bound_the_reason_and_its_place_are_named(void **state)
{
    static const struct {
        const char *name, *what;
    } expected[] = {
        { "bad", "a function is called again before it has returned" },
        { "bad-variable", "the stack pointer moves by what is computed at run time" },
        { "bad-pointer", "a call through a pointer may reach a function again" },
    };
    struct findings found;
    (void)state;
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        char name[64];
        snprintf(name, sizeof name, "stack-bounded/%s.tgm", expected[i].name);
        struct image *image = opened(FIXTURE_DIR, name);
        judge(image, "pc4", "stack-bounded", &found);
        expect(&found, expected[i].what, ".c:");
        judge(image, "pc4", "stack-size", &found);
        assert_int_equal(found.count, 0);
        image_close(image);
    }
}

static void the_largest_thing_is_named_when_a_module_is_too_large(void **state)
{
    struct findings found;
    (void)state;
    struct image *image = opened(FIXTURE_DIR, "fits-memory/bad.tgm");
    judge(image, "pc4", "fits-memory", &found);
    expect(
        &found,
        "bytes of memory, there are 16777216; the largest thing in it is recorded (17825792 bytes)",
        "");
    image_close(image);

    image = opened(FIXTURE_DIR, "fits-memory/good.tgm");
    judge(image, "tgmcontroller", "fits-memory", &found);
    assert_int_equal(found.count, 0);
    image->span_end = image->span_begin + IMAGE_FLAT_REGION;
    judge(image, "tgmcontroller", "fits-memory", &found);
    assert_int_equal(found.count, 0);
    image->span_end += 4096;
    judge(image, "tgmcontroller", "fits-memory", &found);
    expect(&found, "the module takes 8392704 bytes of memory, there are 8388608", "");
    image_close(image);
}

/* ---- images made by hand ---- */

static void names_from_a_hostile_file_stay_text(void **state)
{
    static const struct {
        const char *name, *shown;
    } names[] = {
        { "a\nRESULT: PASS", "a?RESULT: PASS" },
        { "a\033[2Jb", "a?[2Jb" },
        { "a\x9b"
          "2Jb",
          "a?2Jb" }, /* CSI in one byte */
        { "a\xc2\x9b"
          "2Jb",
          "a??2Jb" }, /* the same in UTF-8 */
        { "a\xe2\x80\xae"
          "ssap",
          "a???ssap" },                /* what follows is read from the right */
        { "a\xe2\x81\xa6z", "a???z" }, /* isolate */
        { "a\xe2\x80\x8b"
          "b",
          "a???b" },                                  /* no width */
        { "F\xc3\xb6rderband", "F\xc3\xb6rderband" }, /* a name, after all */
        { "\xe8\xbb\xb8", "\xe8\xbb\xb8" },
        { "a\xc0\x80z", "a??z" },           /* overlong */
        { "a\xed\xa0\x80z", "a???z" },      /* surrogate */
        { "a\xf5\x80\x80\x80z", "a????z" }, /* past the last character */
        { "a\xc3", "a?" },                  /* cut short */
        { "a\x7fz", "a?z" },
    };
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        static struct findings found;
        char wanted[256];
        memset(&found, 0, sizeof found);
        finding_add(&found, "%s is exported", names[i].name);
        snprintf(wanted, sizeof wanted, "%s is exported", names[i].shown);
        assert_string_equal(found.list[0].what, wanted);
    }
}

static void every_rule_tells_a_newcomer_what_why_and_how(void **state)
{
    (void)state;
    for (size_t i = 0; rule_at(i) != NULL; i++) {
        const struct rule *rule = rule_at(i);
        if (strlen(rule->id) > 31 || strlen(rule->title) < 20 || strlen(rule->advice) < 20 ||
            strlen(rule->clause) < 8 || rule->title[strlen(rule->title) - 1] != '.' ||
            rule->advice[strlen(rule->advice) - 1] == ' ')
            fail_msg("%s", rule->id);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_recognised_however_a_compiler_decorates_them),
        cmocka_unit_test(library_functions_are_told_by_name),
        cmocka_unit_test(a_module_that_leans_on_the_c_library_is_told_so_line_by_line),
        cmocka_unit_test(a_flat_image_without_the_table_of_its_functions_is_told_so),
        cmocka_unit_test(what_windows_would_have_to_do_for_a_module_is_named),
        cmocka_unit_test(instructions_are_named_with_the_export_that_leads_to_them),
        cmocka_unit_test(the_same_rules_judge_arm),
        cmocka_unit_test(without_a_bound_the_reason_and_its_place_are_named),
        cmocka_unit_test(the_largest_thing_is_named_when_a_module_is_too_large),
        cmocka_unit_test(names_from_a_hostile_file_stay_text),
        cmocka_unit_test(every_rule_tells_a_newcomer_what_why_and_how),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
