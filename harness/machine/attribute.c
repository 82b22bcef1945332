/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * attribute.c - which instruction of the module is to blame. Runs in the signal handler, on values
 * that the module controls: touches nothing but the module's own stack and code.
 */
#include "machine/machine_private.h"

#define SCAN_WORDS   512 /* how far up the stack a return address is looked for */
#define LONGEST_CALL 7

/* [address, address + size) lies in executable pages of the module. */
bool machine_executes(const struct machine *machine, uint64_t address, size_t size)
{
    uint64_t offset = address - (uint64_t)machine->hull;
    uint64_t span = machine->span_end - machine->span_begin;

    if (offset >= span || size > span - offset)
        return false;
    for (uint64_t page = offset / PAGE; page <= (offset + size - 1) / PAGE; page++)
        if (!(machine->page_access[page] & 4 /* PROT_EXEC */))
            return false;
    return true;
}

/* Length of an indirect near call (ff /2) beginning at code, as its addressing byte says. */
static size_t indirect_call_length(const uint8_t *code)
{
    unsigned mod = code[1] >> 6, reg = code[1] >> 3 & 7, rm = code[1] & 7;
    size_t length = 2;

    if (code[0] != 0xff || reg != 2)
        return 0;
    if (mod == 3)
        return length;
    if (rm == 4) {
        length++;
        if (mod == 0 && (code[2] & 7) == 5)
            return length + 4;
    }
    if (mod == 1)
        return length + 1;
    if (mod == 2 || (mod == 0 && rm == 5))
        return length + 4;
    return length;
}

/* The instruction before address is a call: address can be where it returns to. */
static bool follows_call(const struct machine *machine, uint64_t address)
{
    const uint8_t *code = (const uint8_t *)address;

    if (!machine_executes(machine, address - LONGEST_CALL, LONGEST_CALL + 1))
        return false;
    if (code[-5] == 0xe8)
        return true;
    for (size_t length = 2; length <= LONGEST_CALL; length++)
        if (indirect_call_length(code - length) == length)
            return true;
    return false;
}

static bool find_return_address(const struct machine *machine, uint64_t sp, uint64_t *found)
{
    const unsigned word = machine->pointer_size;

    for (unsigned i = 0; i < SCAN_WORDS; i++, sp += word) {
        if (sp - (uint64_t)machine->stack > machine->stack_size - sizeof *found)
            return false;
        *found = machine_peek(sp);
        if (word < sizeof *found)
            *found &= UINT32_MAX;
        if (follows_call(machine, *found))
            return true;
    }
    return false;
}

/* Fills ip, in_module, service, pc and has_pc. */
void machine_attribute(const struct machine *machine, uint64_t ip, uint64_t sp,
                       struct machine_fault *fault)
{
    uint64_t blamed = ip;

    fault->ip = ip;
    fault->in_module = machine_vaddr(machine, (const void *)ip, &fault->pc);
    fault->has_pc = fault->in_module;
    /* Of a call into the module's own data, the caller is what a person wants to see. */
    if (fault->in_module && !machine_executes(machine, ip, 1) &&
        find_return_address(machine, sp, &blamed)) {
        fault->in_module = false;
        fault->has_pc = machine_vaddr(machine, (const void *)blamed, &fault->pc);
        return;
    }
    if (fault->in_module)
        return;
    if (machine_incident.service_depth > 0) {
        fault->service = machine_incident.service;
        blamed = (uint64_t)machine_incident.service_return;
    } else if (!find_return_address(machine, sp, &blamed)) {
        return;
    }
    fault->has_pc = machine_vaddr(machine, (const void *)blamed, &fault->pc);
}
