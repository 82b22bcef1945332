/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "machine/arguments.h"

#include <string.h>

enum { NO_ALIGNMENT = 1 };

/* What the conventions differ in. */
static const struct {
    uint8_t pointer, long_;    /* bytes */
    uint8_t slot;              /* bytes of the smallest argument */
    uint8_t general;           /* bytes of the area of general registers */
    uint8_t vector;            /* of vector registers; 0: reals are passed as whole numbers */
    uint8_t alignment_of_wide; /* of 64 bits, in registers and on the stack */
} conventions[] = {
    [ARGUMENTS_SYSV] = { 8, 8, 8, 48, 128, NO_ALIGNMENT },
    [ARGUMENTS_WIN64] = { 8, 4, 8, 0, 0, NO_ALIGNMENT },
    [ARGUMENTS_CDECL] = { 4, 4, 4, 0, 0, NO_ALIGNMENT },
    [ARGUMENTS_AAPCS] = { 4, 4, 4, 16, 0, 8 },
    [ARGUMENTS_VALUES] = { 8, 8, 8, 0, 0, NO_ALIGNMENT },
};

_Static_assert(sizeof(struct arguments_sysv) == 48 + 128, "as a va_list has it");

enum arguments_convention arguments_convention_of(const struct image *image)
{
    switch (image->target) {
    case IMAGE_TARGET_I386:
        return ARGUMENTS_CDECL;
    case IMAGE_TARGET_ARM:
        return ARGUMENTS_AAPCS;
    case IMAGE_TARGET_X86_64:
    case IMAGE_TARGET_NONE:
        break;
    }
    return image->format == IMAGE_FORMAT_PE ? ARGUMENTS_WIN64 : ARGUMENTS_SYSV;
}

size_t arguments_pointer_bytes(enum arguments_convention convention)
{
    return conventions[convention].pointer;
}

size_t arguments_long_bytes(enum arguments_convention convention)
{
    return conventions[convention].long_;
}

void arguments_from_sysv(struct arguments *arguments, const struct arguments_sysv *registers,
                         const void *stack)
{
    *arguments =
        (struct arguments){ .convention = ARGUMENTS_SYSV, .registers = registers, .stack = stack };
}

void arguments_from_win64(struct arguments *arguments, const void *stack)
{
    *arguments = (struct arguments){ .convention = ARGUMENTS_WIN64, .stack = stack };
}

void arguments_from_cdecl(struct arguments *arguments, const void *stack)
{
    *arguments = (struct arguments){ .convention = ARGUMENTS_CDECL, .stack = stack };
}

void arguments_from_aapcs(struct arguments *arguments, const uint32_t registers[4],
                          const void *stack)
{
    *arguments =
        (struct arguments){ .convention = ARGUMENTS_AAPCS, .registers = registers, .stack = stack };
}

void arguments_from_values(struct arguments *arguments, const uint64_t *values, size_t count)
{
    *arguments = (struct arguments){ .convention = ARGUMENTS_VALUES,
                                     .stack = (const unsigned char *)values,
                                     .left = count };
}

/* The ABI lays down what is in a va_list. */
void arguments_from_list(struct arguments *arguments, va_list list)
{
    struct {
        unsigned general, vector;
        const unsigned char *stack;
        const struct arguments_sysv *registers;
    } made;
#if !defined(__x86_64__)
#error "the va_list of another processor"
#endif
    memcpy(&made, list, sizeof made);
    arguments_from_sysv(arguments, made.registers, made.stack);
    arguments->general = made.general;
    arguments->vector = made.vector - (unsigned)sizeof made.registers->general;
}

/* The place of the next argument of so many bytes, on the stack. */
static const unsigned char *on_stack(struct arguments *arguments, size_t size)
{
    static const uint64_t nothing = 0;
    const size_t slot = conventions[arguments->convention].slot;
    const size_t alignment = size > slot ? conventions[arguments->convention].alignment_of_wide : 1;
    if (arguments->convention == ARGUMENTS_VALUES) {
        if (arguments->left == 0)
            return (const unsigned char *)&nothing;
        arguments->left--;
    }
    const unsigned char *at =
        arguments->stack + (-(uintptr_t)arguments->stack & (uintptr_t)(alignment - 1));
    arguments->stack = at + (size > slot ? size : slot);
    return at;
}

static const unsigned char *next_general(struct arguments *arguments, size_t size)
{
    const size_t room = conventions[arguments->convention].general;
    const size_t slot = conventions[arguments->convention].slot;
    const size_t alignment =
        size > slot ? conventions[arguments->convention].alignment_of_wide : slot;
    const size_t at = (arguments->general + alignment - 1) / alignment * alignment;
    const size_t taken = size > slot ? size : slot;
    if (at + taken > room) {
        arguments->general = (unsigned)room; /* what comes later is not in a register either */
        return on_stack(arguments, size);
    }
    arguments->general = (unsigned)(at + taken);
    return (const unsigned char *)arguments->registers + at;
}

static const unsigned char *next_real(struct arguments *arguments)
{
    const size_t room = conventions[arguments->convention].vector;
    if (room == 0)
        return next_general(arguments, sizeof(double));
    if (arguments->vector >= room)
        return on_stack(arguments, sizeof(double));
    const unsigned at = arguments->vector;
    arguments->vector += 16;
    return (const unsigned char *)arguments->registers +
           conventions[arguments->convention].general + at;
}

uint32_t arguments_u32(struct arguments *arguments)
{
    uint32_t value;
    memcpy(&value, next_general(arguments, sizeof value), sizeof value);
    return value;
}

uint64_t arguments_u64(struct arguments *arguments)
{
    uint64_t value;
    memcpy(&value, next_general(arguments, sizeof value), sizeof value);
    return value;
}

double arguments_f64(struct arguments *arguments)
{
    double value;
    memcpy(&value, next_real(arguments), sizeof value);
    return value;
}

uint64_t arguments_size(struct arguments *arguments)
{
    return conventions[arguments->convention].pointer == sizeof(uint64_t)
               ? arguments_u64(arguments)
               : arguments_u32(arguments);
}

int64_t arguments_long(struct arguments *arguments)
{
    return conventions[arguments->convention].long_ == sizeof(int64_t)
               ? (int64_t)arguments_u64(arguments)
               : (int32_t)arguments_u32(arguments);
}

uint64_t arguments_ulong(struct arguments *arguments)
{
    return conventions[arguments->convention].long_ == sizeof(uint64_t) ? arguments_u64(arguments)
                                                                        : arguments_u32(arguments);
}

void *arguments_pointer(struct arguments *arguments)
{
    return (void *)(uintptr_t)arguments_size(arguments);
}
