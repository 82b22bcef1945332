/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_census.c - instructions that no computation needs are found by every way that leads to them,
 * and who uses an import is found behind the linker's stubs.
 */
#include "image_open.h"

struct expected {
    const char *label; /* of the instruction */
    enum image_special_kind kind;
    enum image_special_how how;
    const char *from; /* NULL: not looked at */
    const char *text;
};

static struct image *open_read(const char *name)
{
    if (under_valgrind()) /* without seccomp there is no child */
        skip();
    struct image *image = open_module(name);
    assert_true(image_code(image)->known);
    return image;
}

static const struct image_special *special_at(const struct image *image, uint64_t vaddr)
{
    const struct image_code *code = image_code(image);
    for (size_t i = 0; i < code->special_count; i++)
        if (code->specials[i].vaddr == vaddr)
            return &code->specials[i];
    return NULL;
}

static void check(const struct image *image, const struct expected *e)
{
    const struct image_special *found = special_at(image, symbol(image, e->label)->vaddr);
    if (found == NULL)
        fail_msg("nothing at %s", e->label);
    if (found->kind != e->kind || found->how != e->how || strcmp(found->text, e->text) != 0)
        fail_msg("%s: kind %d, how %d, `%s`", e->label, (int)found->kind, (int)found->how,
                 found->text);
    if (e->from != NULL && found->from != symbol(image, e->from)->vaddr)
        fail_msg("%s: from 0x%llx, not %s", e->label, (unsigned long long)found->from, e->from);
}

/* These and no others. */
static void check_all(const struct image *image, const struct expected *expected, size_t count)
{
    for (size_t i = 0; i < count; i++)
        check(image, &expected[i]);
    const struct image_code *code = image_code(image);
    for (size_t i = count; i < code->special_count || i < count; i++)
        print_message("  %zu: 0x%llx %s\n", i, (unsigned long long)code->specials[i].vaddr,
                      code->specials[i].text);
    assert_int_equal(code->special_count, count);
}

#define SYSTEM     IMAGE_SPECIAL_SYSTEM
#define PRIVILEGED IMAGE_SPECIAL_PRIVILEGED
#define THREAD     IMAGE_SPECIAL_THREAD
#define MACHINE    IMAGE_SPECIAL_MACHINE
#define REACHED    IMAGE_SPECIAL_REACHED

static void every_way_on_x86_64_leads_to_the_instructions_behind_it(void **state)
{
    static const struct expected expected[] = {
        { "at_syscall", SYSTEM, REACHED, "straight", "syscall" },
        { "at_sysenter", SYSTEM, REACHED, "straight", "sysenter" },
        { "at_int", SYSTEM, REACHED, "calls", "int 0x80" },
        { "at_in", PRIVILEGED, REACHED, "branches", "in al, dx" },
        { "at_hlt", PRIVILEGED, REACHED, "branches", "hlt" },
        { "at_cli", PRIVILEGED, REACHED, "branches", "cli" },
        { "at_hidden", SYSTEM, REACHED, "hidden", "syscall" },
        { "at_rdtsc", MACHINE, REACHED, "switched", "rdtsc" },
        { "at_wrmsr", PRIVILEGED, REACHED, "by_pointer", "wrmsr" },
        { "at_rdmsr", PRIVILEGED, IMAGE_SPECIAL_POINTER, "unknown_pointer", "rdmsr" },
        { "at_out", PRIVILEGED, REACHED, "lost_stack", "out 0x80, al" },
        { "at_cpuid", MACHINE, REACHED, "lost_jump", "cpuid" },
        { "at_canary", THREAD, REACHED, "thread", "mov rax, qword ptr fs:[0x28]" },
        { "at_teb", THREAD, REACHED, "thread", "mov rax, qword ptr gs:[0x30]" },
        { "at_limit", THREAD, REACHED, "thread", "mov rax, qword ptr gs:[0x10]" },
        { "at_cr", PRIVILEGED, REACHED, "registers", "mov rax, cr4" },
        { "at_es", PRIVILEGED, REACHED, "registers", "mov es, eax" },
        { "at_dead", SYSTEM, IMAGE_SPECIAL_UNREACHED, "dead", "sysenter" },
        { "at_bytes", SYSTEM, IMAGE_SPECIAL_BYTES, "at_bytes", "int 0x2e" },
    };
    (void)state;
    struct image *image = open_read("census.so");
    check_all(image, expected, sizeof expected / sizeof expected[0]);
    assert_true(image_code(image)->complete);
    image_close(image);
}

static void every_kind_on_arm_is_told_from_what_user_code_may_do(void **state)
{
    static const struct expected expected[] = {
        { "at_svc", SYSTEM, REACHED, "straight", "svc #0" },
        { "at_bkpt", SYSTEM, REACHED, "straight", "bkpt #1" },
        { "at_smc", SYSTEM, REACHED, "straight", "smc #0" },
        { "at_cpsid", PRIVILEGED, REACHED, "privileged", "cpsid i" },
        { "at_wfi", PRIVILEGED, REACHED, "privileged", "wfi" },
        { "at_cache", PRIVILEGED, REACHED, "privileged", "mcr p15, #0, r0, c7, c5, #0" },
        { "at_control", PRIVILEGED, REACHED, "privileged", "mrc p15, #0, r0, c1, c0, #0" },
        { "at_msr", PRIVILEGED, REACHED, "privileged", "msr cpsr_c, r0" },
        { "at_spsr", PRIVILEGED, REACHED, "privileged", "mrs r0, spsr" },
        { "at_fpexc", PRIVILEGED, REACHED, "privileged", "vmsr fpexc, r0" },
        { "at_rfe", PRIVILEGED, REACHED, "privileged", "rfeia r0" },
        { "at_tpidruro", THREAD, REACHED, "thread", "mrc p15, #0, r0, c13, c0, #3" },
        { "at_pmccntr", MACHINE, REACHED, "machine", "mrc p15, #0, r0, c9, c13, #0" },
        { "at_cntvct", MACHINE, REACHED, "machine", "mrrc p15, #1, r0, r1, c14" },
        { "at_conditional", SYSTEM, REACHED, "conditional", "svceq #0" },
        { "at_thumb_svc", SYSTEM, REACHED, "in_thumb", "svc #7" },
        { "at_thumb_cps", PRIVILEGED, REACHED, "in_thumb", "cpsie i" },
        { "at_thumb_msr", PRIVILEGED, REACHED, "in_thumb", "msr cpsr_c, r0" },
    };
    (void)state;
    struct image *image = open_read("census_arm.so");
    check_all(image, expected, sizeof expected / sizeof expected[0]);
    assert_true(image_code(image)->complete);
    image_close(image);
}

static void an_unknown_jump_in_a_stripped_module_leaves_the_census_incomplete(void **state)
{
    (void)state;
    struct image *image = open_read("census_stripped.so");
    const struct image_code *code = image_code(image);
    /* The exports keep their sizes; without them the end of a function is not known. */
    assert_true(code->complete);
    image_close(image);
    image = open_read("census_sizeless.so");
    code = image_code(image);
    const uint64_t lost = symbol(image, "lost_jump")->vaddr;
    assert_false(code->complete);
    assert_true(code->lost > lost && code->lost < lost + 16);
    image_close(image);
}

static void the_stack_limit_of_a_windows_thread_may_be_read_by_a_probe(void **state)
{
    (void)state;
    struct image *image = open_read("census.dll");
    const struct image_code *code = image_code(image);
    bool canary = false, limit = false;
    for (size_t i = 0; i < code->special_count; i++) {
        canary |= strcmp(code->specials[i].text, "mov rax, qword ptr gs:[0x30]") == 0;
        limit |= strcmp(code->specials[i].text, "mov rax, qword ptr gs:[0x10]") == 0;
    }
    assert_true(canary);
    assert_false(limit);
    image_close(image);
}

/* ---- imports ---- */

static void check_user(const char *module, const char *import, const char *function, int line)
{
    struct image *image = open_read(module);
    const struct image_code *code = image_code(image);
    for (size_t i = 0; i < image->import_count; i++) {
        struct image_place place;
        if (strcmp(image->imports[i].name, import) != 0)
            continue;
        if (!code->users[i].found)
            fail_msg("%s: nobody uses %s", module, import);
        image_where(image, code->users[i].vaddr, &place);
        assert_string_equal(place.function, function);
        if (line != 0)
            assert_int_equal(place.line, line);
        image_close(image);
        return;
    }
    fail_msg("%s does not import %s", module, import);
}

static void the_user_of_an_import_is_found_behind_stub_and_slot(void **state)
{
    (void)state;
    check_user("libc.so", "printf", "Program_01", 11);
    check_user("libc_lld.so", "printf", "Program_01", 11);
    check_user("pe_mingw_x86_64.dll", "OTHER.dll!by_name", "Program_01", 0);
    check_user("pe_mingw_i686.dll", "OTHER.dll!by_name", "Program_01", 0);
    check_user("pe_lld_x86_64.dll", "OTHER.dll!by_name", "Program_01", 0);
}

/* ---- entry points ---- */

static void an_entry_point_is_idle_when_it_returns_at_once_and_changes_nothing(void **state)
{
    static const char *const idle[] = { "pe_mingw_x86_64.dll", "pe_lld_x86_64.dll",
                                        "pe_lld_i686.dll" };
    (void)state;
    for (size_t i = 0; i < sizeof idle / sizeof idle[0]; i++) {
        struct image *image = open_read(idle[i]);
        assert_true(image->has_entry_point);
        if (!image_code(image)->entry_idle)
            fail_msg("%s: DllMain does something", idle[i]);
        image_close(image);
    }
}

static void an_entry_point_that_writes_calls_or_loops_is_not_idle(void **state)
{
    static const char *const busy[] = { "entry_writes.dll", "entry_calls.dll", "entry_loops.dll",
                                        "entry_asks.dll" };
    (void)state;
    for (size_t i = 0; i < sizeof busy / sizeof busy[0]; i++) {
        struct image *image = open_read(busy[i]);
        assert_true(image->has_entry_point);
        if (image_code(image)->entry_idle)
            fail_msg("%s: DllMain does nothing", busy[i]);
        image_close(image);
    }
    struct image *image = open_read("entry_idle.dll");
    assert_true(image_code(image)->entry_idle);
    image_close(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_way_on_x86_64_leads_to_the_instructions_behind_it),
        cmocka_unit_test(every_kind_on_arm_is_told_from_what_user_code_may_do),
        cmocka_unit_test(an_unknown_jump_in_a_stripped_module_leaves_the_census_incomplete),
        cmocka_unit_test(the_stack_limit_of_a_windows_thread_may_be_read_by_a_probe),
        cmocka_unit_test(the_user_of_an_import_is_found_behind_stub_and_slot),
        cmocka_unit_test(an_entry_point_is_idle_when_it_returns_at_once_and_changes_nothing),
        cmocka_unit_test(an_entry_point_that_writes_calls_or_loops_is_not_idle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
