/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * arguments.h - what a module has passed to a host function, read one after the other.
 *
 * One cursor for the calling conventions that modules are compiled for. It reads memory only:
 * registers have been written down by the machine before. Whether an argument is fixed or variadic
 * makes no difference in any of them for what the module API passes (whole numbers and pointers;
 * reals in the variadic part alone).
 *
 *   SYSV     x86-64 ELF: six general and eight vector registers, then 8-byte slots. `long` 64 bit
 *   WIN64    x86-64 PE: 8-byte slots, of which the caller left room for the first four
 *   CDECL    i386 PE: 4-byte slots; 64-bit arguments take two, aligned to 4
 *   AAPCS    Arm: r0 to r3, then 4-byte slots; 64-bit arguments begin at an even register or at a
 *            multiple of 8
 *   VALUES   a given number of 64-bit values of the host's own; behind the last comes 0
 *
 * Every read takes what the type takes in that convention, wrong types included: a module that
 * passes an int for %f gets what it would get from the C library.
 */
#ifndef HARNESS_MACHINE_ARGUMENTS_H
#define HARNESS_MACHINE_ARGUMENTS_H

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include "image/image.h"

enum arguments_convention {
    ARGUMENTS_SYSV,
    ARGUMENTS_WIN64,
    ARGUMENTS_CDECL,
    ARGUMENTS_AAPCS,
    ARGUMENTS_VALUES
};

/* What SYSV finds its registers in. The order is that of the convention; of a vector register the
 * first 8 bytes count. */
struct arguments_sysv {
    uint64_t general[6]; /* rdi, rsi, rdx, rcx, r8, r9 */
    struct {
        uint64_t low, high;
    } vector[8];
};

struct arguments {
    enum arguments_convention convention;
    unsigned general, vector;   /* bytes of the register areas that have been read */
    const void *registers;      /* SYSV, AAPCS */
    const unsigned char *stack; /* the next slot */
    size_t left;                /* VALUES: how many there are */
};

/* The convention of the functions of a module. */
enum arguments_convention arguments_convention_of(const struct image *image);
/* Bytes of a pointer, and of size_t, in it; of `long`. */
size_t arguments_pointer_bytes(enum arguments_convention convention);
size_t arguments_long_bytes(enum arguments_convention convention);

/* `stack`: the first slot on the stack, above the return address. WIN64: the room for rcx, in which
 * it has been put, as rdx, r8 and r9 in theirs. */
void arguments_from_sysv(struct arguments *arguments, const struct arguments_sysv *registers,
                         const void *stack);
void arguments_from_win64(struct arguments *arguments, const void *stack);
void arguments_from_cdecl(struct arguments *arguments, const void *stack);
void arguments_from_aapcs(struct arguments *arguments, const uint32_t registers[4],
                          const void *stack);
void arguments_from_values(struct arguments *arguments, const uint64_t *values, size_t count);
/* Those of a function of the host. The list must not end before the cursor's last use. */
void arguments_from_list(struct arguments *arguments, va_list list);

/* A whole number of 32 bits, or of less, which is passed as one of 32. */
uint32_t arguments_u32(struct arguments *arguments);
uint64_t arguments_u64(struct arguments *arguments);
double arguments_f64(struct arguments *arguments);
/* size_t and everything as wide; a `long`, with its sign or without. */
uint64_t arguments_size(struct arguments *arguments);
int64_t arguments_long(struct arguments *arguments);
uint64_t arguments_ulong(struct arguments *arguments);
/* As an address of the host's, which it is: modules live in the harness's own address space. */
void *arguments_pointer(struct arguments *arguments);

#endif
