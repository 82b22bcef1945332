/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_image_memory.c - lack of memory is the harness's trouble: never a defect of the file, never
 * half an image, never a leak.
 *
 * Replaces the allocator, which sanitizers and valgrind do, too: there the test skips itself.
 */
#include <errno.h>

#include "image_open.h"

#if defined(__SANITIZE_ADDRESS__)
#define SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SANITIZED
#endif
#endif

static long until_failure = -1; /* allocations that still succeed; negative: all */
static long live;               /* blocks in use */

#ifndef SANITIZED

/* glibc's own names of its allocator. */
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *block, size_t size);
void __libc_free(void *block);

static bool fails(void)
{
    if (until_failure < 0)
        return false;
    if (until_failure > 0) {
        until_failure--;
        return false;
    }
    errno = ENOMEM;
    return true;
}

static void *count(void *block)
{
    live += block != NULL;
    return block;
}

void *malloc(size_t size)
{
    return fails() ? NULL : count(__libc_malloc(size));
}

void *calloc(size_t number, size_t size)
{
    return fails() ? NULL : count(__libc_calloc(number, size));
}

void *realloc(void *block, size_t size)
{
    if (fails())
        return NULL;
    void *moved = __libc_realloc(block, size);
    return block == NULL ? count(moved) : moved;
}

void *reallocarray(void *block, size_t number, size_t size)
{
    return realloc(block, number * size);
}

void free(void *block)
{
    live -= block != NULL;
    __libc_free(block);
}

#endif

static bool replaced(void)
{
#ifdef SANITIZED
    return false;
#else
    return !under_valgrind();
#endif
}

/* Opens with only so many allocations; true when that was enough. */
static bool open_with(const void *bytes, size_t size, long allocations)
{
    struct image *image;
    char why[IMAGE_WHY];
    long before = live;
    until_failure = allocations;
    int error = image_open_memory(&image, "bytes", bytes, size, why);
    until_failure = -1;
    if (error == 0) {
        assert_null(image_broken_promise(image));
        assert_string_equal(image->defect, "");
        image_close(image);
    } else {
        assert_int_equal(error, -ENOMEM);
        assert_null(image);
        assert_non_null(strstr(why, "no memory"));
    }
    assert_int_equal(live, before);
    return error == 0;
}

static void lack_of_memory_is_no_defect(void **state)
{
    (void)state;
    if (!replaced())
        skip();
    static const char *const modules[] = { "six.so",
                                           "start.so",
                                           "libc.so",
                                           "old.so",
                                           "start_arm.so",
                                           "six_arm_relr.so",
                                           "pe_mingw_x86_64.dll",
                                           "pe_mingw_i686.dll",
                                           "pe_delay_i686.dll",
                                           "pe_ctors_x86_64.dll" };
    for (size_t i = 0; i < sizeof modules / sizeof modules[0]; i++) {
        struct image *image = open_module(modules[i]);
        /* What the libraries keep for themselves is allocated by now. */
        long needed = 0;
        while (!open_with(image->bytes, image->size, needed))
            needed++;
        assert_true(needed > 4);
        image_close(image);
    }
}

static void lack_of_memory_leaves_an_address_without_a_line(void **state)
{
    (void)state;
    if (!replaced())
        skip();
    struct image *image = open_module("six.so");
    struct image_place place;
    until_failure = 0;
    image_where(image, image_export(image, "Program_04")->vaddr, &place);
    until_failure = -1;
    assert_string_equal(place.function, "Program_04");
    assert_null(place.file);
    image_close(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lack_of_memory_is_no_defect),
        cmocka_unit_test(lack_of_memory_leaves_an_address_without_a_line),
    };
    return cmocka_run_group_tests_name("image_memory", tests, NULL, NULL);
}
