/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_machine_load.c - what the loader does to an image: places, data, relocations, protection. */
#include <errno.h>
#include <signal.h>
#include <stdbool.h>
#include <sys/mman.h>

#include "machine_fixture.h"

#define HULL_GUARD (16u << 20)

/* An image put together by hand: one file of three pages. */
struct raw {
    uint8_t bytes[3 * 4096];
    struct image_segment segments[3];
    struct image_reloc relocs[4];
    struct image image;
};

enum { R = IMAGE_READ, RW = IMAGE_READ | IMAGE_WRITE, RX = IMAGE_READ | IMAGE_EXEC };

static void raw_init(struct raw *raw, uint64_t span_begin, uint64_t span_end)
{
    memset(raw, 0, sizeof *raw);
    raw->image = (struct image){ .bytes = raw->bytes,
                                 .size = sizeof raw->bytes,
                                 .format = IMAGE_FORMAT_ELF64,
                                 .target = IMAGE_TARGET_X86_64,
                                 .format_name = "ELF64",
                                 .target_name = "x86-64",
                                 .segments = raw->segments,
                                 .relocs = raw->relocs,
                                 .span_begin = span_begin,
                                 .span_end = span_end };
}

static void raw_segment(struct raw *raw, uint64_t vaddr, uint64_t mem_size, uint64_t file_size,
                        uint64_t file_offset, unsigned perm)
{
    raw->segments[raw->image.segment_count++] =
        (struct image_segment){ vaddr, mem_size, file_size, file_offset, perm };
}

static void raw_reloc(struct raw *raw, uint64_t vaddr, int64_t addend, enum image_reloc_kind kind)
{
    raw->relocs[raw->image.reloc_count++] =
        (struct image_reloc){ .vaddr = vaddr, .addend = addend, .kind = kind, .width = 8 };
}

static struct machine *raw_load(struct raw *raw, uint64_t seed, bool poison)
{
    struct machine_config config = { .kind = fixture_kind, .seed = seed, .poison = poison };
    char why[MACHINE_WHY];

    if (machine_load(&the_fixture.machine, &raw->image, &config, why) != 0)
        fail_msg("machine_load: %s", why);
    return the_fixture.machine;
}

static struct machine_outcome raw_call(uint64_t function, void *argument)
{
    struct machine_outcome outcome;

    machine_call(the_fixture.machine, function, argument, &outcome);
    return outcome;
}

static int unload(void **state)
{
    (void)state;
    machine_unload(the_fixture.machine);
    memset(&the_fixture, 0, sizeof the_fixture);
    return 0;
}

static uint64_t word_at(const struct machine *machine, uint64_t vaddr)
{
    uint64_t word;

    memcpy(&word, machine_address(machine, vaddr), sizeof word);
    return word;
}

static const uint8_t return_42[] = { 0xb8, 42, 0, 0, 0, 0xc3 };
static const uint8_t write_to_argument[] = { 0xc6, 0x07, 0x01, 0xc3 };

static void segments_go_where_the_image_says(void **state)
{
    struct raw raw;
    struct machine *machine;
    uint64_t vaddr = 0;

    (void)state;
    raw_init(&raw, 0x400000, 0x404000);
    memcpy(raw.bytes + 0x10, return_42, sizeof return_42);
    memset(raw.bytes + 0x1000, 0x77, 0x30);
    raw_segment(&raw, 0x400010, 0x100, 0x100, 0x10, RX);
    raw_segment(&raw, 0x402008, 0x1800, 0x20, 0x1000, RW);
    machine = raw_load(&raw, 5, false);
    assert_int_equal(raw_call(0x400010, NULL).value, 42);
    assert_int_equal(word_at(machine, 0x402008), 0x7777777777777777);
    assert_int_equal(word_at(machine, 0x402020), 0x7777777777777777);
    assert_int_equal(word_at(machine, 0x402028), 0);
    assert_int_equal(word_at(machine, 0x403800), 0);
    assert_true(machine_vaddr(machine, machine_address(machine, 0x402008), &vaddr));
    assert_int_equal(vaddr, 0x402008);
    assert_false(machine_vaddr(machine, machine_address(machine, 0x404000), &vaddr));
    assert_false(machine_vaddr(machine, machine_address(machine, 0x3fffff), &vaddr));
}

static void module_stands_between_wide_guards(void **state)
{
    static const int64_t outside[] = { -1,     -(int64_t)HULL_GUARD,   0x1000, 0x2000,
                                       0x3000, 0x3000 + HULL_GUARD - 1 };
    struct raw raw;
    struct machine *machine;

    (void)state;
    raw_init(&raw, 0, 0x3000);
    memcpy(raw.bytes, write_to_argument, sizeof write_to_argument);
    raw_segment(&raw, 0, 0x100, 0x100, 0, RX);
    machine = raw_load(&raw, 5, false);
    for (size_t i = 0; i < COUNT(outside); i++) {
        struct machine_outcome outcome =
            raw_call(0, (uint8_t *)machine_address(machine, 0) + outside[i]);

        assert_int_equal(outcome.kind, MACHINE_FAULT);
        assert_string_equal(outcome.fault.region, "module");
        assert_int_equal(outcome.fault.region_offset, outside[i]);
    }
}

static void code_that_runs_off_its_end_traps(void **state)
{
    struct raw raw;
    struct machine_outcome outcome;

    (void)state;
    raw_init(&raw, 0, 0x1000);
    memset(raw.bytes, 0x90, 0x20);
    raw_segment(&raw, 0, 0x20, 0x20, 0, RX);
    raw_load(&raw, 5, false);
    outcome = raw_call(0, NULL);
    assert_int_equal(outcome.kind, MACHINE_FAULT);
    assert_int_equal(outcome.fault.signal, SIGTRAP);
    assert_int_equal(outcome.fault.pc, 0x20);
}

static void writable_code_stays_writable_and_is_not_poisoned(void **state)
{
    struct raw raw;
    struct machine *machine;
    struct machine_outcome outcome;

    (void)state;
    raw_init(&raw, 0, 0x1000);
    memcpy(raw.bytes, write_to_argument, sizeof write_to_argument);
    raw_segment(&raw, 0, 0x100, 0x100, 0, IMAGE_READ | IMAGE_WRITE | IMAGE_EXEC);
    machine = raw_load(&raw, 5, true);
    assert_memory_equal(machine_address(machine, 0), write_to_argument, sizeof write_to_argument);
    outcome = raw_call(0, machine_address(machine, 0x80));
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
}

static void read_only_data_is_mapped_read_only(void **state)
{
    struct raw raw;
    struct machine *machine;

    (void)state;
    raw_init(&raw, 0, 0x3000);
    memcpy(raw.bytes, write_to_argument, sizeof write_to_argument);
    raw_segment(&raw, 0, 0x100, 0x100, 0, RX);
    raw_segment(&raw, 0x1000, 0x100, 0x100, 0x1000, R);
    raw_segment(&raw, 0x2000, 0x100, 0x100, 0x2000, RW);
    machine = raw_load(&raw, 5, false);
    assert_int_equal(raw_call(0, machine_address(machine, 0x1000)).kind, MACHINE_FAULT);
    assert_int_equal(raw_call(0, machine_address(machine, 0x2000)).kind, MACHINE_RETURNED);
}

static void page_shared_by_code_and_data_is_not_writable(void **state)
{
    struct raw raw;
    struct machine *machine;

    (void)state;
    raw_init(&raw, 0, 0x3000);
    memcpy(raw.bytes, write_to_argument, sizeof write_to_argument);
    raw_segment(&raw, 0, 0x100, 0x100, 0, RX);
    raw_segment(&raw, 0x800, 0x1800, 0, 0, RW);
    machine = raw_load(&raw, 5, false);
    assert_int_equal(raw_call(0, machine_address(machine, 0x900)).kind, MACHINE_FAULT);
    assert_int_equal(raw_call(0, machine_address(machine, 0x1000)).kind, MACHINE_RETURNED);
}

static void relocations_add_the_load_address(void **state)
{
    struct raw raw;
    struct machine *machine;

    (void)state;
    raw_init(&raw, 0x1000, 0x4000);
    memset(raw.bytes, 0x22, sizeof raw.bytes);
    raw_segment(&raw, 0x1000, 0x1000, 0x1000, 0, RX);
    raw_segment(&raw, 0x2000, 0x1000, 0x1000, 0, RW);
    raw_reloc(&raw, 0x1100, 0x2345, IMAGE_RELOC_RELATIVE); /* in code */
    raw_reloc(&raw, 0x2003, -1, IMAGE_RELOC_RELATIVE);     /* not aligned */
    raw_reloc(&raw, 0x2100, 0x2000, IMAGE_RELOC_SYMBOLIC);
    raw_reloc(&raw, 0xfffffffffffff000, 0x2000, IMAGE_RELOC_OTHER);
    machine = raw_load(&raw, 5, true);
    assert_ptr_equal(word_at(machine, 0x1100), machine_address(machine, 0x2345));
    assert_ptr_equal(word_at(machine, 0x2003), machine_address(machine, (uint64_t)-1));
    assert_int_equal(word_at(machine, 0x2100), 0x2222222222222222);
    assert_int_not_equal(word_at(machine, 0x2108), 0x2222222222222222);
}

static const struct {
    uint64_t begin, end;
    enum image_format format;
    const char *defect;
    int error;
} refused[] = {
    { 0, 0x1000, IMAGE_FORMAT_ELF64, "e_phoff is 7, allowed is 64", -ENOEXEC },
    { 0, 0x1000, IMAGE_FORMAT_FLAT, "", -ENOEXEC },
    { 0x1000, 0x1000, IMAGE_FORMAT_ELF64, "", -ENOEXEC },
    { 0x2000, 0x1000, IMAGE_FORMAT_ELF64, "", -ENOEXEC },
    { 0x10, 0x1000, IMAGE_FORMAT_ELF64, "", -ENOEXEC },
    { 0, 1ull << 30, IMAGE_FORMAT_ELF64, "", -EFBIG },
    { 0x1000, 1ull << 63, IMAGE_FORMAT_ELF64, "", -EFBIG },
};

static void what_cannot_run_is_refused_with_a_reason(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(refused); i++) {
        struct machine *machine = (void *)1;
        struct machine_config config = { .kind = fixture_kind, .seed = 1 };
        char why[MACHINE_WHY] = "";
        struct raw raw;

        raw_init(&raw, refused[i].begin, refused[i].end);
        raw.image.format = refused[i].format;
        strcpy(raw.image.defect, refused[i].defect);
        assert_int_equal(machine_load(&machine, &raw.image, &config, why), refused[i].error);
        assert_null(machine);
        assert_string_not_equal(why, "");
    }
}

/* Everything that a module can see of its surroundings. */
struct surroundings {
    void *module, *region, *read_only;
    uint64_t stack, words[512];
};

static void look_around(uint64_t seed, struct surroundings *seen)
{
    static const uint8_t store_rsp[] = { 0x48, 0x89, 0x27, 0xc3 }; /* mov %rsp,(%rdi); ret */
    struct raw raw;
    struct machine *machine;

    raw_init(&raw, 0, 0x3000);
    memcpy(raw.bytes, store_rsp, sizeof store_rsp);
    raw_segment(&raw, 0, 0x100, 0x100, 0, RX);
    raw_segment(&raw, 0x2000, 0x1000, 0, 0, RW);
    machine = raw_load(&raw, seed, true);
    seen->module = machine_address(machine, 0);
    seen->region = map(&the_fixture, "one", 100, MACHINE_REGION_READ_WRITE, NULL);
    seen->read_only = map(&the_fixture, "two", 5000, MACHINE_REGION_READ, NULL);
    memcpy(seen->words, machine_address(machine, 0x2000), sizeof seen->words);
    assert_int_equal(raw_call(0, seen->region).kind, MACHINE_RETURNED);
    memcpy(&seen->stack, seen->region, sizeof seen->stack);
    unload(NULL);
}

static void seed_determines_places_and_poison(void **state)
{
    static struct surroundings first, again, other;
    size_t same = 0;

    (void)state;
    look_around(11, &first);
    look_around(11, &again);
    look_around(12, &other);
    assert_memory_equal(&first, &again, sizeof first);
    assert_ptr_not_equal(first.module, other.module);
    assert_ptr_not_equal(first.region, other.region);
    assert_ptr_not_equal(first.read_only, other.read_only);
    assert_int_not_equal(first.stack, other.stack);
    for (size_t i = 0; i < COUNT(first.words); i++)
        same += first.words[i] == other.words[i];
    assert_int_equal(same, 0);
    assert_int_equal((uintptr_t)first.module % 65536, 0);
}

static void occupied_place_is_not_taken(void **state)
{
    static struct surroundings free_place, next;
    const size_t size = 4096;
    uint8_t *squatter;

    (void)state;
    look_around(13, &free_place);
    squatter = mmap(free_place.module, size, PROT_READ | PROT_WRITE,
                    MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0);
    assert_ptr_equal(squatter, free_place.module);
    memset(squatter, 0x5c, size);
    look_around(13, &next);
    assert_ptr_not_equal(next.module, free_place.module);
    assert_ptr_equal(next.region, free_place.region);
    for (size_t i = 0; i < size; i++)
        assert_int_equal(squatter[i], 0x5c);
    munmap(squatter, size);
}

/* The rest with a module from a real linker. */
static void open_data(bool poison)
{
    struct machine_config config = {
        .kind = fixture_kind, .seed = 3, .poison = poison, .hang_ns = TEST_HANG_NS
    };

    fixture_open(&the_fixture, "data", &config);
}

static void data_without_poison_is_as_in_the_file(void **state)
{
    static const uint8_t bytes[3] = { 1, 2, 3 };

    (void)state;
    open_data(false);
    assert_int_equal(*(int *)place(&the_fixture, "plain"), 0x11223344);
    assert_memory_equal(place(&the_fixture, "bytes"), bytes, 3);
    assert_int_equal(*(int *)place(&the_fixture, "zeroed"), 0);
    assert_int_equal(call(&the_fixture, "read_plain", NULL).value, 0x11223344);
    assert_int_equal(call(&the_fixture, "write_plain", NULL).value, 5);
    assert_int_equal(call(&the_fixture, "read_protected", NULL).value, 88 + 'k');
}

static void poison_replaces_initial_values_but_not_pointers(void **state)
{
    const struct {
        int *where;
        long number;
    } * pair;
    const int *zeroed;
    int zeros = 0;

    (void)state;
    open_data(true);
    assert_int_not_equal(*(int *)place(&the_fixture, "plain"), 0x11223344);
    zeroed = place(&the_fixture, "zeroed");
    for (int i = 0; i < 1000; i++)
        zeros += zeroed[i] == 0;
    assert_int_equal(zeros, 0);
    assert_ptr_equal(*(int **)place(&the_fixture, "pointer"), place(&the_fixture, "plain"));
    pair = place(&the_fixture, "pairs");
    assert_ptr_equal(pair[0].where, place(&the_fixture, "plain"));
    assert_int_not_equal(pair[0].number, 99);
    assert_int_not_equal(pair[1].number, 111);
    pair = place(&the_fixture, "protected_pairs");
    assert_ptr_equal(pair[0].where, place(&the_fixture, "plain"));
    assert_int_equal(pair[0].number, 77);
    assert_int_equal(pair[1].number, 88);
    assert_int_equal(call(&the_fixture, "read_protected", NULL).value, 88 + 'k');
}

static void data_read_only_after_relocation_is(void **state)
{
    struct machine_outcome outcome;

    (void)state;
    open_data(false);
    outcome = call(&the_fixture, "write_protected", NULL);
    assert_int_equal(outcome.kind, MACHINE_FAULT);
    assert_int_equal(outcome.fault.access, MACHINE_ACCESS_WRITE);
    assert_string_equal(outcome.fault.region, "module");
    assert_int_equal(outcome.fault.region_offset, at(&the_fixture, "protected_pairs") + 8);
}

#define RAW(test)    cmocka_unit_test_teardown(test, unload)
#define LOADED(test) cmocka_unit_test_teardown(test, close_fixture)

int main(void)
{
    const struct CMUnitTest tests[] = {
        RAW(segments_go_where_the_image_says),
        RAW(module_stands_between_wide_guards),
        RAW(code_that_runs_off_its_end_traps),
        RAW(writable_code_stays_writable_and_is_not_poisoned),
        RAW(read_only_data_is_mapped_read_only),
        RAW(page_shared_by_code_and_data_is_not_writable),
        RAW(relocations_add_the_load_address),
        RAW(what_cannot_run_is_refused_with_a_reason),
        RAW(seed_determines_places_and_poison),
        RAW(occupied_place_is_not_taken),
        LOADED(data_without_poison_is_as_in_the_file),
        LOADED(poison_replaces_initial_values_but_not_pointers),
        LOADED(data_read_only_after_relocation_is),
    };

    int failed = cmocka_run_group_tests_name("loading, native", tests, NULL, NULL);

    fixture_kind = MACHINE_INSTRUMENTED;
    return failed + cmocka_run_group_tests_name("loading, instrumented", tests, NULL, NULL);
}
