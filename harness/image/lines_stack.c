/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * lines_stack.c - how much stack each function takes, from the call frame information that
 * debuggers unwind with. Runs in the confined child of lines_extract.c.
 *
 * The canonical frame address is the stack pointer before the call plus a constant; where a
 * function keeps it relative to the stack pointer, its largest distance is the function's frame. A
 * function that keeps it relative to another register has a frame of variable size: it is counted
 * as unknown.
 */
#include "image/image_private.h"

#include <dwarf.h>
#include <elfutils/libdw.h>
#include <stdlib.h>
#include <string.h>

#define MAX_STEPS 100000u /* rows of one function; more is hostile */
#define MAX_FRAME (1u << 30)

struct measure {
    Dwarf_CFI *cfi;
    unsigned stack_register;
    struct image_stack *stack;
    bool believed; /* the compiler of this unit states frames completely */
};

static unsigned stack_register(const struct image *image)
{
    return image->target == IMAGE_TARGET_X86_64 ? 7 : image->target == IMAGE_TARGET_I386 ? 4 : 13;
}

/* Distance from the stack pointer to the frame address, -1 when it is not relative to it. */
static int64_t distance(const struct measure *measure, Dwarf_Frame *frame)
{
    Dwarf_Op *ops;
    size_t count;
    if (dwarf_frame_cfa(frame, &ops, &count) != 0 || count != 1)
        return -1;
    if (ops[0].atom == DW_OP_bregx)
        return ops[0].number == measure->stack_register ? (int64_t)ops[0].number2 : -1;
    if (ops[0].atom >= DW_OP_breg0 && ops[0].atom <= DW_OP_breg31)
        return (unsigned)ops[0].atom - DW_OP_breg0 == measure->stack_register
                   ? (int64_t)ops[0].number
                   : -1;
    return -1;
}

/* Largest distance in [low, high), -1 when it is not known everywhere. */
static int64_t frame_of(const struct measure *measure, Dwarf_Addr low, Dwarf_Addr high)
{
    int64_t largest = 0;
    unsigned steps = 0;
    while (low < high) {
        Dwarf_Frame *frame = NULL;
        Dwarf_Addr begin, end;
        if (++steps > MAX_STEPS || dwarf_cfi_addrframe(measure->cfi, low, &frame) != 0)
            return -1;
        const int64_t here = distance(measure, frame);
        const int bad = dwarf_frame_info(frame, &begin, &end, NULL) < 0 || end <= low;
        free(frame);
        if (bad || here < 0 || here > MAX_FRAME)
            return -1;
        largest = here > largest ? here : largest;
        low = end;
    }
    return largest;
}

static int measure_function(Dwarf_Die *function, void *argument)
{
    struct measure *measure = argument;
    Dwarf_Addr low, high;
    if (dwarf_lowpc(function, &low) != 0 || dwarf_highpc(function, &high) != 0 || low == 0)
        return DWARF_CB_OK; /* a declaration, inlined everywhere, or dropped by the linker */
    const int64_t frame = measure->believed ? frame_of(measure, low, high) : -1;
    measure->stack->functions++;
    if (frame < 0) {
        measure->stack->unknown++;
        return DWARF_CB_OK;
    }
    measure->stack->sum += (uint64_t)frame;
    if ((uint64_t)frame > measure->stack->largest)
        measure->stack->largest = (uint64_t)frame;
    return DWARF_CB_OK;
}

static bool is_believed(Dwarf_Die *unit)
{
    Dwarf_Attribute attribute;
    const char *producer = dwarf_formstring(dwarf_attr(unit, DW_AT_producer, &attribute));
    return producer != NULL && strstr(producer, "Free Pascal") == NULL;
}

void lines_stack(const struct image *image, void *dwarf_pointer, struct image_stack *stack)
{
    Dwarf *dwarf = dwarf_pointer;
    Dwarf_Off offset = 0, next;
    size_t header;
    Dwarf_Die unit;
    struct measure measure = { dwarf_getcfi(dwarf), stack_register(image), stack, false };
    if (measure.cfi == NULL)
        return;
    while (dwarf_nextcu(dwarf, offset, &next, &header, NULL, NULL, NULL) == 0 && next > offset) {
        if (dwarf_offdie(dwarf, offset + header, &unit) != NULL) {
            measure.believed = is_believed(&unit);
            dwarf_getfuncs(&unit, measure_function, &measure, 0);
        }
        offset = next;
    }
}
