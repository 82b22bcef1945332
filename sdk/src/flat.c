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

const void *const *GetProcAddress(void);

__attribute__((section(".text.GetProcAddress"), used)) const void *const *GetProcAddress(void)
{
    memset(tgm_bss_begin, 0, (size_t)(tgm_bss_end - tgm_bss_begin));
    return functions;
}
