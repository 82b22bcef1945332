/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_stack.c - how much stack functions of known depth take, and what cannot be bounded.
 */
#include "image_open.h"

struct expected {
    const char *name;
    uint64_t bytes;
    enum image_stack_limit limit;
    const char *where; /* symbol at the instruction that the limit is about */
};

static const struct image_routine *routine(const struct image *image, const char *name)
{
    const struct image_routine *found = image_routine(image, symbol(image, name)->vaddr);
    if (found == NULL)
        fail_msg("%s is no routine", name);
    return found;
}

static void check(const struct image *image, const struct expected *expected, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const struct expected *e = &expected[i];
        const struct image_routine *r = routine(image, e->name);
        if (r->limit != e->limit || r->stack != e->bytes)
            fail_msg("%s takes %llu bytes, limit %d; expected %llu, %d", e->name,
                     (unsigned long long)r->stack, (int)r->limit, (unsigned long long)e->bytes,
                     (int)e->limit);
        if (e->where != NULL && r->where != symbol(image, e->where)->vaddr)
            fail_msg("%s: the limit is at 0x%llx, expected %s", e->name,
                     (unsigned long long)r->where, e->where);
    }
}

#define CHECK(image, expected) check(image, expected, sizeof(expected) / sizeof(expected)[0])

/* Without seccomp there is no child, and nothing is known. */
static struct image *open_measured(const char *name)
{
    if (under_valgrind())
        skip();
    return open_module(name);
}

static void functions_with_a_bound_on_x86_64(void **state)
{
    static const struct expected expected[] = {
        { "straight", 56, IMAGE_STACK_BOUNDED, NULL },
        { "leaf", 32, IMAGE_STACK_BOUNDED, NULL },
        { "byte_below", 32, IMAGE_STACK_BOUNDED, NULL },
        { "segment", 24, IMAGE_STACK_BOUNDED, NULL },
        { "half_word", 16, IMAGE_STACK_BOUNDED, NULL },
        { "nested", 72, IMAGE_STACK_BOUNDED, NULL },
        { "deeper_way", 128, IMAGE_STACK_BOUNDED, NULL },
        { "framed", 104, IMAGE_STACK_BOUNDED, NULL },
        { "entered", 48, IMAGE_STACK_BOUNDED, NULL },
        { "tail", 56, IMAGE_STACK_BOUNDED, NULL },
        { "tail_loop", 16, IMAGE_STACK_BOUNDED, NULL },
        { "balanced_loop", 32, IMAGE_STACK_BOUNDED, NULL },
        { "probed", 8200, IMAGE_STACK_BOUNDED, NULL },
        { "table", 56, IMAGE_STACK_BOUNDED, NULL },
        { "service", 24, IMAGE_STACK_BOUNDED, NULL },
        { "get_place", 16, IMAGE_STACK_BOUNDED, NULL },
        { "far_jump", 24, IMAGE_STACK_BOUNDED, NULL },
        { "falls_into_next", 16, IMAGE_STACK_BOUNDED, NULL },
        { "stops", 16, IMAGE_STACK_BOUNDED, NULL },
        { "pointer", 56, IMAGE_STACK_BOUNDED, NULL },
    };
    (void)state;
    struct image *image = open_measured("stack.so");
    CHECK(image, expected);
    image_close(image);
}

static void functions_without_a_bound_on_x86_64(void **state)
{
    static const struct expected expected[] = {
        { "recursive", 40, IMAGE_STACK_RECURSION, "recursive_call" },
        { "calls_recursive", 48, IMAGE_STACK_RECURSION, "recursive_call" },
        { "mutual", 40, IMAGE_STACK_RECURSION, "other_call" },
        { "loop_push", 272, IMAGE_STACK_LOOP, "loop_push" },
        { "alloca", 16, IMAGE_STACK_VARIABLE, "alloca_sub" },
        { "underflow", 8, IMAGE_STACK_UNBALANCED, "underflow" },
        { "no_code", 8, IMAGE_STACK_CODE, "no_code" },
        { "unknown_jump", 16, IMAGE_STACK_JUMP, "unknown_jump_jmp" },
    };
    (void)state;
    struct image *image = open_measured("stack.so");
    CHECK(image, expected);
    image_close(image);
}

/* A function whose address the module has calls through a pointer itself. */
static void pointers_that_may_come_back_have_no_bound(void **state)
{
    static const struct expected expected[] = {
        { "back", 72, IMAGE_STACK_POINTER, "back_call" },
        { "pointer", 72, IMAGE_STACK_POINTER, "back_call" },
        { "service", 24, IMAGE_STACK_BOUNDED, NULL },
    };
    (void)state;
    struct image *image = open_measured("stack_back.so");
    CHECK(image, expected);
    image_close(image);
}

static void services_are_told_from_the_modules_own_calls(void **state)
{
    (void)state;
    struct image *image = open_measured("stack.so");
    assert_true(routine(image, "service")->outside);
    assert_true(routine(image, "pointer")->outside);
    assert_false(routine(image, "nested")->outside);
    assert_null(image_routine(image, symbol(image, "callback")->vaddr));
    image_close(image);
}

static void functions_on_i386(void **state)
{
    static const struct expected expected[] = {
        { "straight", 48, IMAGE_STACK_BOUNDED, NULL },
        { "nested", 64, IMAGE_STACK_BOUNDED, NULL },
        { "realigned", 52, IMAGE_STACK_BOUNDED, NULL },
        { "dynamic_realign", 48, IMAGE_STACK_BOUNDED, NULL },
        { "gives", 20, IMAGE_STACK_BOUNDED, NULL },
        { "probed", 8196, IMAGE_STACK_BOUNDED, NULL },
        { "table", 68, IMAGE_STACK_BOUNDED, NULL },
        { "service", 12, IMAGE_STACK_BOUNDED, NULL },
        { "all_registers", 40, IMAGE_STACK_BOUNDED, NULL },
        { "negative", 20, IMAGE_STACK_BOUNDED, NULL },
        { "tail", 48, IMAGE_STACK_BOUNDED, NULL },
        { "pointer", 24, IMAGE_STACK_BOUNDED, NULL },
        { "loop_push", 136, IMAGE_STACK_LOOP, "loop_push" },
        { "alloca", 8, IMAGE_STACK_VARIABLE, NULL },
    };
    (void)state;
    struct image *image = open_measured("stack_i386.dll");
    CHECK(image, expected);
    assert_int_equal(routine(image, "recursive")->limit, IMAGE_STACK_RECURSION);
    image_close(image);
}

static void functions_on_arm(void **state)
{
    static const struct expected expected[] = {
        { "straight", 48, IMAGE_STACK_BOUNDED, NULL },
        { "nested", 52, IMAGE_STACK_BOUNDED, NULL },
        { "vectors", 40, IMAGE_STACK_BOUNDED, NULL },
        { "multiple", 28, IMAGE_STACK_BOUNDED, NULL },
        { "apcs", 48, IMAGE_STACK_BOUNDED, NULL },
        { "aligned", 36, IMAGE_STACK_BOUNDED, NULL },
        { "conditional", 108, IMAGE_STACK_BOUNDED, NULL },
        { "table", 64, IMAGE_STACK_BOUNDED, NULL },
        { "steps", 32, IMAGE_STACK_BOUNDED, NULL },
        { "service", 8, IMAGE_STACK_BOUNDED, NULL },
        { "interwork", 40, IMAGE_STACK_BOUNDED, NULL },
        { "post_index", 4, IMAGE_STACK_BOUNDED, NULL },
        { "tail", 48, IMAGE_STACK_BOUNDED, NULL },
        { "recursive", 8, IMAGE_STACK_RECURSION, NULL },
        { "loop_push", 132, IMAGE_STACK_LOOP, "loop_push" },
        { "alloca", 8, IMAGE_STACK_VARIABLE, NULL },
    };
    (void)state;
    struct image *image = open_measured("stack_arm.so");
    CHECK(image, expected);
    image_close(image);
}

static void functions_in_thumb_code(void **state)
{
    static const struct expected expected[] = {
        { "t_straight", 32, IMAGE_STACK_BOUNDED, NULL },
        { "t_nested", 48, IMAGE_STACK_BOUNDED, NULL },
        { "t_if_then", 48, IMAGE_STACK_BOUNDED, NULL },
        { "t_table", 64, IMAGE_STACK_BOUNDED, NULL },
        { "t_frame", 24, IMAGE_STACK_BOUNDED, NULL },
        { "t_to_arm", 48, IMAGE_STACK_BOUNDED, NULL },
    };
    (void)state;
    struct image *image = open_measured("stack_arm.so");
    CHECK(image, expected);
    image_close(image);
}

/* ---- the size of functions ---- */

static void sizes_from_the_code_are_those_that_the_file_states(void **state)
{
    static const char *const modules[] = { "six.so", "six_lld.so", "six_arm.so", "six_thumb.so" };
    (void)state;
    for (size_t i = 0; i < sizeof modules / sizeof modules[0]; i++) {
        struct image *image = open_measured(modules[i]);
        for (size_t k = 0; k < image->symbol_count; k++) {
            const struct image_symbol *s = &image->symbols[k];
            if (!s->exported || s->kind != IMAGE_SYMBOL_FUNC)
                continue;
            if (image_routine(image, s->vaddr)->size != s->size)
                fail_msg("%s of %s: %llu bytes of code, the file says %llu", s->name, modules[i],
                         (unsigned long long)image_routine(image, s->vaddr)->size,
                         (unsigned long long)s->size);
        }
        image_close(image);
    }
}

static void a_function_ends_where_the_next_one_begins(void **state)
{
    (void)state;
    struct image *image = open_measured("stack.so");
    assert_int_equal(routine(image, "falls_into_next")->size, 3);
    assert_int_equal(routine(image, "next")->size, 3);
    image_close(image);
}

static void pdata_says_how_long_functions_are(void **state)
{
    (void)state;
    struct image *with = open_measured("six_pdata.dll");
    struct image *without = open_module("six_mingw_x86_64.dll");
    for (int i = 0; i < 6; i++) {
        static const char *const names[] = { "Program_Ini", "Program_01", "Program_02",
                                             "Program_03",  "Program_04", "Program_05" };
        const struct image_symbol *s = image_export(with, names[i]);
        const struct image_symbol *t = image_export(without, names[i]);
        assert_true(s->size > 0);
        assert_int_equal(t->size, 0);
        assert_int_equal(image_routine(with, s->vaddr)->size, s->size);
        assert_int_equal(image_routine(without, t->vaddr)->size, s->size);
    }
    image_close(with);
    image_close(without);
}

static void without_exported_code_there_are_no_routines(void **state)
{
    (void)state;
    struct image *image = open_any_module("six_exec");
    assert_null(image_routine(image, 0x1000));
    image_close(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(functions_with_a_bound_on_x86_64),
        cmocka_unit_test(functions_without_a_bound_on_x86_64),
        cmocka_unit_test(pointers_that_may_come_back_have_no_bound),
        cmocka_unit_test(services_are_told_from_the_modules_own_calls),
        cmocka_unit_test(functions_on_i386),
        cmocka_unit_test(functions_on_arm),
        cmocka_unit_test(functions_in_thumb_code),
        cmocka_unit_test(sizes_from_the_code_are_those_that_the_file_states),
        cmocka_unit_test(a_function_ends_where_the_next_one_begins),
        cmocka_unit_test(pdata_says_how_long_functions_are),
        cmocka_unit_test(without_exported_code_there_are_no_routines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
