/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_bad_files.c - the verdict on files that lie: FAIL, by the rule on the format and no other,
 * with the sentence that names the lie; and nothing of such a file is called passed.
 */
#include <stdlib.h>
#include <unistd.h>

#include "conformance/check.h"
#include "image_lies.h"
#include "image_lies_pe.h"
#include "image_open.h"

static char folder[] = "/tmp/tgm-bad-files-XXXXXX";

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) == NULL ? -1 : 0;
}

static int remove_folder(void **state)
{
    (void)state;
    return rmdir(folder);
}

/* Looks at every rule of the report. */
static bool is_failed_for(const struct report *report, const char *sentence)
{
    bool named = false;
    if (report->verdict != VERDICT_FAIL || report->failed != 1 || report->passed != 0)
        return false;
    for (size_t i = 0; i < report->rule_count; i++) {
        const struct rule_report *rule = &report->rules[i];
        if (rule->outcome == RULE_FAILED)
            named = strcmp(rule->id, "file-format") == 0 && rule->finding_count == 1 &&
                    strstr(rule->findings[0].what, sentence) != NULL;
    }
    return named;
}

static void judge(const char *profile, const char *name, const void *bytes, size_t size,
                  const char *sentence, unsigned *wrong)
{
    char path[256], why[CHECK_WHY];
    struct check *check;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
    const struct check_options options = {
        .path = path, .tool = "test", .profile = profile_find(profile), .seed = 1, .cycles = 1
    };
    if (check_run(&check, &options, why) != 0)
        fail_msg("%s: %s", name, why);
    unlink(path);
    const struct report *report = check_report(check);
    if (!is_failed_for(report, sentence)) {
        print_error("%s: verdict %d with %zu rules failed, %zu passed, expected the sentence "
                    "\"%s\"\n",
                    name, (int)report->verdict, (size_t)report->failed, (size_t)report->passed,
                    sentence);
        for (size_t i = 0; i < report->rule_count; i++)
            for (size_t k = 0; k < report->rules[i].finding_count; k++)
                print_error("    %s: %s\n", report->rules[i].id, report->rules[i].findings[k].what);
        (*wrong)++;
    }
    check_free(check);
}

static void elf_files_that_lie_fail(void **state)
{
    static struct tiny t;
    unsigned wrong = 0;
    (void)state;
    for (size_t i = 0; i < sizeof elf_lies / sizeof elf_lies[0]; i++) {
        tiny_init(&t);
        elf_lies[i].tell(&t);
        judge("pc4", elf_lies[i].name, &t, sizeof t, elf_lies[i].sentence, &wrong);
    }
    assert_int_equal(wrong, 0);
}

static void windows_files_that_lie_fail(void **state)
{
    static struct tiny_pe t;
    unsigned wrong = 0;
    (void)state;
    for (size_t i = 0; i < 2 * sizeof pe_lies / sizeof pe_lies[0]; i++) {
        tiny_pe_init(&t, i % 2 == 0);
        pe_lies[i / 2].tell(&t);
        judge("pc4", pe_lies[i / 2].name, t.bytes, TINY_PE_SIZE, pe_lies[i / 2].sentence, &wrong);
    }
    assert_int_equal(wrong, 0);
}

/* A module of a linker with one field changed. */
static void judge_changed(const char *profile, const char *module, size_t at, unsigned width,
                          uint64_t value, const char *sentence, unsigned *wrong)
{
    struct image *image = open_module(module);
    assert_true(at + width <= image->size);
    memcpy(image->bytes + at, &value, width);
    judge(profile, module, image->bytes, image->size, sentence, wrong);
    image_close(image);
}

static void files_for_arm_that_lie_fail(void **state)
{
    static const struct {
        size_t at;
        unsigned width;
        uint32_t value;
        const char *sentence;
    } lies[] = {
        { EI_CLASS, 1, ELFCLASS64, "a 64-bit little-endian ELF file for Arm" },
        { EI_DATA, 1, ELFDATA2MSB, "a 32-bit big-endian ELF file" },
        { offsetof(Elf32_Ehdr, e_machine), 2, EM_386, "a 32-bit little-endian ELF file for i386" },
        { offsetof(Elf32_Ehdr, e_type), 2, ET_EXEC, "an executable, not a module" },
        { offsetof(Elf32_Ehdr, e_flags), 4, 0x04000000, "Arm EABI version (e_flags 0x4000000)" },
        { offsetof(Elf32_Ehdr, e_flags), 4, 0x05800000, "big-endian Arm data" },
        { offsetof(Elf32_Ehdr, e_ehsize), 2, 64, "(e_ehsize) is 64, allowed is 52" },
        { offsetof(Elf32_Ehdr, e_phentsize), 2, 56, "(e_phentsize) is 56, allowed is 32" },
        { offsetof(Elf32_Ehdr, e_phoff), 4, UINT32_MAX, "program header table (e_phoff" },
        { offsetof(Elf32_Ehdr, e_shoff), 4, UINT32_MAX, "section header table (e_shoff" },
    };
    unsigned wrong = 0;
    (void)state;
    for (size_t i = 0; i < sizeof lies / sizeof lies[0]; i++)
        judge_changed("tgmmini", "six_arm.so", lies[i].at, lies[i].width, lies[i].value,
                      lies[i].sentence, &wrong);
    assert_int_equal(wrong, 0);
}

static void flat_images_that_are_none_fail(void **state)
{
    static const struct {
        uint32_t words[4];
        size_t size;
        const char *name, *sentence;
    } files[] = {
        { { 0x03a00001, 0xe12fff1e }, 8, "a.tgm.bin", "starts with the word 0x03a00001" },
        { { 0xe3a00001, 0, 0xe12fff1e }, 12, "a.tgm.bin", "the word 0x00000000 at 0x4" },
        { { 0xe3a00001, 0xef000000, 0xe12fff1e }, 12, "a.tgm.bin", "the word 0xef000000 at 0x4" },
        { { 0xeaffffff }, 4, "a.tgm.bin", "the word 0xeaffffff at 0x0" },
        { { 0xe59f0004, 0xe12fff1e }, 8, "a.tgm.bin", "the word 0xe59f0004 at 0x0" },
        { { 0xe3a00001, 0xe3a00001 }, 8, "a.tgm.bin", "no return instruction in the first" },
        { { 0xe12fff1e }, 0, "a.tgm.bin", "the file is empty" },
        { { 0xe12fff1e }, 4, "a.tgm_controller", "the vendor's stamp is not documented" },
        { { 0xe12fff1e }, 4, "a.tgm", "starts with the bytes 1e ff 2f e1" },
    };
    unsigned wrong = 0;
    uint8_t *large = calloc(1, IMAGE_FLAT_REGION + 4);
    (void)state;
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++)
        judge("tgmcontroller", files[i].name, files[i].words, files[i].size, files[i].sentence,
              &wrong);
    assert_non_null(large);
    memcpy(large, &files[7].words[0], 4);
    judge("tgmcontroller", "large.tgm.bin", large, IMAGE_FLAT_REGION + 4, "has room for 8388608",
          &wrong);
    free(large);
    assert_int_equal(wrong, 0);
}

/* Right files in the wrong place. */
static void files_for_another_product_fail(void **state)
{
    static const struct {
        const char *profile, *module, *name, *sentence;
    } files[] = {
        { "pc4", "six_arm.so", "six.tgm", "ELF32 Arm" },
        { "pc4", "flat.tgm.bin", "six.tgm.bin", "flat Arm" },
        { "tgmmini", "six_mingw_x86_64.dll", "six.tgm", "PE x86-64" },
        { "tgmmini", "flat.tgm.bin", "six.tgm.bin", "flat Arm" },
        { "tgmcontroller", "six_arm.so", "six.tgm", "ELF32 Arm" },
        { "tgmcontroller", "six_mingw_i686.dll", "six.tgm", "PE i386" },
        { "tgzmotion", "six_lld_x86_64.dll", "six.tgm", "PE x86-64" },
    };
    unsigned wrong = 0;
    (void)state;
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        struct image *image = open_module(files[i].module);
        judge(files[i].profile, files[i].name, image->bytes, image->size, files[i].sentence,
              &wrong);
        image_close(image);
    }
    assert_int_equal(wrong, 0);
}

static void modules_cut_short_fail(void **state)
{
    static const struct {
        const char *profile, *module;
    } files[] = {
        { "pc4", "six_lld.so" },
        { "pc4", "six_mingw_x86_64.dll" },
        { "pc4", "six_lld_i686.dll" },
        { "tgmmini", "six_arm.so" },
    };
    unsigned wrong = 0;
    (void)state;
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        struct image *image = open_module(files[i].module);
        for (size_t size = 1; size < 1024; size += size < 64 ? 1 : 61)
            judge(files[i].profile, "cut.tgm", image->bytes, size, "", &wrong);
        image_close(image);
    }
    assert_int_equal(wrong, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elf_files_that_lie_fail),
        cmocka_unit_test(windows_files_that_lie_fail),
        cmocka_unit_test(files_for_arm_that_lie_fail),
        cmocka_unit_test(flat_images_that_are_none_fail),
        cmocka_unit_test(files_for_another_product_fail),
        cmocka_unit_test(modules_cut_short_fail),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
