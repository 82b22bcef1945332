/* SPDX-License-Identifier: MIT */
/*
 * GetProcAddress of a flat image: the first code of the image, at the address where the controller expects it
 * (manual: TGMcontroller, PLC project). It clears the uninitialised data, which is not part of the image, and hands
 * out the addresses of the functions. Program_05 is not among them: the manual's list ends at Program_04.
 *
 * The signature is not documented: this one is ours (docs/decisions.md, C4). A module for a real controller takes
 * GetProcAddress from the vendor's project instead.
 */
#include <tgm_plc.h>

extern unsigned char tgm_bss_begin[], tgm_bss_end[];

static const void *const functions[] = {
    (const void *)Program_Ini, (const void *)Program_01, (const void *)Program_02,
    (const void *)Program_03,  (const void *)Program_04,
};

/*
 * What the image hands out, for who has nothing but the file: a flat image has no table of its exports, so this
 * SDK puts one in (docs/decisions.md, I10). No controller looks at it; `tgm inspect` does. `self` is the address of
 * the table: bytes that only look like one do not lie where they say.
 */
struct flat_exports {
    char magic[16];
    const void *self;
    uint32_t count;
    struct {
        const void *address;
        char name[12];
    } entries[5];
};

__attribute__((section(".rodata.tgm_exports"), used)) static const struct flat_exports exports = {
    "TGM-EXPORTS-1",
    &exports,
    5,
    { { (const void *)Program_Ini, "Program_Ini" },
      { (const void *)Program_01, "Program_01" },
      { (const void *)Program_02, "Program_02" },
      { (const void *)Program_03, "Program_03" },
      { (const void *)Program_04, "Program_04" } },
};

const void *const *GetProcAddress(void);

__attribute__((section(".text.GetProcAddress"), used)) const void *const *GetProcAddress(void)
{
    memset(tgm_bss_begin, 0, (size_t)(tgm_bss_end - tgm_bss_begin));
    return functions;
}
