/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * instrumented_hooks.c - what is seen of the module while it runs.
 *
 * Whoever wants the emulation to end says so through emulator_stop(), of which the first counts:
 * Unicorn finishes the instruction that made an access that is not allowed (and in Thumb code the
 * whole block that an IT began) before it stops.
 */
#include <errno.h>

#include "machine/instrumented.h"

void emulator_stop(struct emulator *emulator, enum emulator_stop stop, uint32_t number)
{
    if (emulator->stop == EMULATOR_RUNNING) {
        emulator->stop = stop;
        emulator->number = number;
    }
    uc_emu_stop(emulator->uc);
}

static bool is_thumb(struct emulator *emulator)
{
    enum { THUMB_STATE = 1 << 5 };

    return emulator->cpu->arch == UC_ARCH_ARM &&
           (emulator_read(emulator, UC_ARM_REG_CPSR) & THUMB_STATE) != 0;
}

/* An instruction that is executed for the first time. */
static uint8_t learn(struct emulator *emulator, uint64_t address)
{
    enum { LONGEST = 15 };
    const struct machine *machine = emulator->machine;
    const uint64_t offset = address - emulator->base;
    const uint64_t rest = machine->span_end - machine->span_begin - offset;
    struct code_step step;

    code_step_read(&emulator->stepper, (const uint8_t *)address, rest < LONGEST ? rest : LONGEST,
                   address, is_thumb(emulator), &step);
    for (uint64_t at = offset; at < offset + step.size && at < offset + rest; at++)
        emulator->covered[at / 8] |= (uint8_t)(1u << at % 8);
    return emulator->kinds[offset] = (uint8_t)(step.kind | step.covers << 4);
}

/* Unicorn looks at a repeated instruction once more when its counter has come to zero. */
static bool is_repeated_out(struct emulator *emulator, uint8_t kind)
{
    const unsigned bits = 8 * (unsigned)(kind >> 4);
    const uint64_t mask = bits < 64 ? (UINT64_C(1) << bits) - 1 : UINT64_MAX;

    return (emulator_read(emulator, emulator->cpu->counter) & mask) == 0;
}

static unsigned thumb_size(uint64_t address)
{
    uint16_t half;

    memcpy(&half, (const void *)address, sizeof half);
    return half >> 11 >= 0x1d ? 4 : 2;
}

/* Thumb instructions from one address to another. */
static uint64_t thumbs(uint64_t from, uint64_t to)
{
    uint64_t count = 0;

    for (; from < to; count++)
        from += thumb_size(from);
    return count;
}

/* The block of an IT is entered, of so many instructions. */
static void begin_block(struct emulator *emulator, uint64_t address, unsigned covers)
{
    emulator->block_next = emulator->block_end = address + 2;
    while (covers-- > 0)
        emulator->block_end += thumb_size(emulator->block_end);
}

/* The emulator passes over the instructions of such a block whose condition is not met, which a
 * processor executes like all others. True when this one is not in the block any more. */
static bool behind_block(struct emulator *emulator, uint64_t address)
{
    const bool inside = address >= emulator->block_next && address < emulator->block_end;

    emulator->executed += thumbs(emulator->block_next, inside ? address : emulator->block_end);
    if (inside)
        emulator->block_next = address + thumb_size(address);
    else
        emulator->block_end = 0;
    return !inside;
}

static bool is_aligned(struct emulator *emulator, unsigned reg)
{
    return (emulator_read(emulator, UC_ARM_REG_R0 + (int)reg) & 3) == 0;
}

/* Of an A32 instruction, by the flags (Arm Architecture Reference Manual, condition codes). */
static bool condition_holds(uint32_t instruction, uint32_t flags)
{
    const uint32_t condition = instruction >> 28;
    const bool n = flags >> 31 & 1, z = flags >> 30 & 1, c = flags >> 29 & 1, v = flags >> 28 & 1;
    const bool holds[] = { z, c, n, v, c && !z, n == v, n == v && !z, true };

    return holds[condition >> 1] != (condition % 2 == 1 && condition < 14);
}

/* An instruction whose condition is not met does nothing, wherever its registers point. Of Thumb
 * those do not come here. */
static bool is_skipped(struct emulator *emulator, uint64_t address)
{
    uint32_t instruction;

    if (emulator->cpu->arch != UC_ARCH_ARM || is_thumb(emulator))
        return false;
    memcpy(&instruction, (const void *)address, sizeof instruction);
    return !condition_holds(instruction, (uint32_t)emulator_read(emulator, UC_ARM_REG_CPSR));
}

/* True when the instruction is to be executed. */
static bool go_on(struct emulator *emulator, uint64_t address, uint8_t kind)
{
    const unsigned covers = kind >> 4;

    switch (kind & 15) {
    case CODE_STEP_PLAIN:
    case CODE_STEP_REPEAT:
        return true;
    case CODE_STEP_CONDITION:
        begin_block(emulator, address, covers);
        return true;
    case CODE_STEP_ALIGNED:
        if (is_aligned(emulator, covers))
            return true;
        break;
    default:
        break;
    }
    if (is_skipped(emulator, address))
        return true;
    emulator_stop(emulator, EMULATOR_INSTRUCTION, kind & 15);
    return false;
}

static __attribute__((noinline)) void unusual(struct emulator *emulator, uint64_t address,
                                              uint64_t before)
{
    uint8_t kind = emulator->kinds[address - emulator->base];
    bool between = true; /* instructions that can be stopped between */

    if ((kind & 15) == CODE_STEP_REPEAT && before == address && is_repeated_out(emulator, kind))
        return;
    if (emulator->block_end != 0)
        between = behind_block(emulator, address);
    if (emulator->executed >= emulator->stop_at && !emulator->pass && between) {
        emulator_stop(
            emulator,
            emulator->executed >= emulator->interrupt_at ? EMULATOR_INTERRUPT : EMULATOR_HANG, 0);
        return;
    }
    emulator->pass = false;
    if (kind == 0)
        kind = learn(emulator, address);
    if (go_on(emulator, address, kind))
        emulator->executed++;
}

static void on_instruction(uc_engine *uc, uint64_t address, uint32_t size, void *argument)
{
    struct emulator *emulator = argument;
    const uint64_t before = emulator->pc;

    (void)uc;
    (void)size;
    emulator->pc = address;
    if (emulator->kinds[address - emulator->base] != CODE_STEP_PLAIN ||
        emulator->executed >= emulator->stop_at || emulator->block_end != 0)
        unusual(emulator, address, before);
    else
        emulator->executed++;
}

static void on_service(uc_engine *uc, uint64_t address, uint32_t size, void *argument)
{
    struct emulator *emulator = argument;
    const uint64_t offset = address - emulator->trap;
    const uint64_t number = offset / emulator->cpu->slot - 1;

    (void)uc;
    (void)size;
    if (offset % emulator->cpu->slot == 0 && number < emulator->machine->service_count) {
        emulator_stop(emulator, EMULATOR_SERVICE, (uint32_t)number);
        return;
    }
    /* The module made up an address. */
    if (emulator->stop == EMULATOR_RUNNING) {
        emulator->access = UC_MEM_FETCH_UNMAPPED;
        emulator->address = address;
    }
    emulator_stop(emulator, EMULATOR_MEMORY, 0);
}

static bool on_bad_access(uc_engine *uc, uc_mem_type type, uint64_t address, int size,
                          int64_t value, void *argument)
{
    struct emulator *emulator = argument;

    (void)uc;
    (void)size;
    (void)value;
    if (emulator->stop == EMULATOR_RUNNING) {
        emulator->access = type;
        emulator->address = address;
    }
    emulator_stop(emulator, EMULATOR_MEMORY, 0);
    return false;
}

static void on_exception(uc_engine *uc, uint32_t vector, void *argument)
{
    (void)uc;
    emulator_stop(argument, EMULATOR_EXCEPTION, vector);
}

static bool on_invalid(uc_engine *uc, void *argument)
{
    (void)uc;
    emulator_stop(argument, EMULATOR_INSTRUCTION, 0);
    return false;
}

static const struct emulator_memory *memory_of(const struct emulator *emulator, uint64_t address)
{
    for (uint32_t i = 0; i < emulator->memory_count; i++)
        if (address - emulator->memories[i].begin <
            emulator->memories[i].end - emulator->memories[i].begin)
            return &emulator->memories[i];
    return NULL;
}

static bool is_covered(const struct emulator *emulator, uint64_t offset, unsigned size)
{
    bool covered = false;

    for (uint64_t at = offset; at < offset + size; at++)
        covered |= (emulator->covered[at / 8] >> at % 8 & 1) != 0;
    return covered;
}

/* What has been executed and is about to be something else will be looked at anew. */
static void forget(struct emulator *emulator, uint64_t offset, unsigned size)
{
    enum { LONGEST = 15 };

    for (uint64_t at = offset < LONGEST ? 0 : offset - LONGEST; at < offset + size; at++)
        emulator->kinds[at] = 0;
}

static uint64_t low_bytes(uint64_t value, unsigned size)
{
    return size < sizeof value ? value & ((UINT64_C(1) << 8 * size) - 1) : value;
}

/* Of the instruction that is tried out: what is memory, and not the stack. */
static void probe(struct emulator *emulator, const struct emulator_memory *memory, uint64_t address,
                  unsigned size, bool write)
{
    const struct machine *machine = emulator->machine;
    const uint64_t offset = address - emulator->base;
    const bool own = offset < machine->span_end - machine->span_begin;

    if (memory == NULL && !own)
        return;
    if (write && (own ? !(machine->page_access[offset / PAGE] & 2 /* PROT_WRITE */)
                      : !memory->writable || address + size > memory->end))
        return;
    emulator_probe(emulator, address, size, write);
}

static void on_access(uc_engine *uc, uc_mem_type type, uint64_t address, int size, int64_t value,
                      void *argument)
{
    struct emulator *emulator = argument;
    const struct machine *machine = emulator->machine;
    const struct machine_trace *trace = machine->config.trace;
    const struct emulator_memory *memory = memory_of(emulator, address);
    struct trace_access access = { .instruction = emulator->executed - 1,
                                   .address = address,
                                   .size = (unsigned)size,
                                   .write = type == UC_MEM_WRITE,
                                   .value = low_bytes((uint64_t)value, (unsigned)size) };

    (void)uc;
    if (emulator->probe != NULL) {
        probe(emulator, memory, address, (unsigned)size, access.write);
        return;
    }
    /* Writes are seen before it is known whether they are allowed. */
    if (emulator->stop != EMULATOR_RUNNING || trace == NULL)
        return;
    access.pc = emulator->pc - emulator->base + machine->span_begin;
    if (memory != NULL) {
        if (access.write && (!memory->writable || address + access.size > memory->end))
            return;
        access.region = memory->number;
        access.offset = (int64_t)(address - memory->start);
        trace->access(trace->argument, &access);
        return;
    }
    const uint64_t offset = address - emulator->base;
    const uint64_t span = machine->span_end - machine->span_begin;

    if (!access.write || offset >= span || access.size > span - offset ||
        !(machine->page_access[offset / PAGE] & 2 /* PROT_WRITE */) ||
        !is_covered(emulator, offset, access.size))
        return;
    access.region = TRACE_CODE;
    access.offset = (int64_t)(offset + machine->span_begin);
    trace->access(trace->argument, &access);
    forget(emulator, offset, access.size);
}

/* The stack: memory that is asked for through these. */
static uint64_t stack_read(uc_engine *uc, uint64_t offset, unsigned size, void *argument)
{
    struct emulator_level *level = argument;
    const uint64_t address = (uint64_t)level->stack + offset;
    uint64_t value = 0;

    (void)uc;
    if (address < level->lowest)
        level->lowest = address;
    memcpy(&value, (const void *)address, size);
    return value;
}

static void stack_write(uc_engine *uc, uint64_t offset, unsigned size, uint64_t value,
                        void *argument)
{
    struct emulator_level *level = argument;
    const uint64_t address = (uint64_t)level->stack + offset;

    (void)uc;
    if (address < level->lowest)
        level->lowest = address;
    memcpy((void *)address, &value, size);
}

int emulator_map_stack(struct emulator *emulator, unsigned level, char why[MACHINE_WHY])
{
    struct emulator_level *own = &emulator->levels[level];
    const struct machine *machine = emulator->machine;
    uc_err error;

    own->stack = machine->levels[level].stack;
    own->top = machine_stack_top(machine, own->stack);
    own->lowest = own->top;
    own->after = MACHINE_NEVER;
    error = uc_mmio_map(emulator->uc, (uint64_t)own->stack, machine->stack_size, stack_read, own,
                        stack_write, own);
    return error == UC_ERR_OK
               ? 0
               : machine_fail(why, -ENOMEM, "the emulator takes no stack: %s", uc_strerror(error));
}

int emulator_hooks(struct emulator *emulator, char why[MACHINE_WHY])
{
    const struct machine *machine = emulator->machine;
    const uint64_t span = machine->span_end - machine->span_begin;
    const uint64_t services = emulator->trap + emulator->cpu->slot;
    const struct {
        int type;
        void *function;
        uint64_t begin, end; /* begin > end: everywhere */
        bool wanted;
    } hooks[] = {
        { UC_HOOK_CODE, (void *)(uintptr_t)on_instruction, emulator->base,
          emulator->base + span - 1, true },
        { UC_HOOK_CODE, (void *)(uintptr_t)on_service, services, emulator->trap + PAGE - 1, true },
        { UC_HOOK_MEM_INVALID, (void *)(uintptr_t)on_bad_access, 1, 0, true },
        { UC_HOOK_INTR, (void *)(uintptr_t)on_exception, 1, 0, true },
        { UC_HOOK_INSN_INVALID, (void *)(uintptr_t)on_invalid, 1, 0, true },
        { UC_HOOK_MEM_READ_AFTER | UC_HOOK_MEM_WRITE, (void *)(uintptr_t)on_access, 1, 0,
          machine->config.trace != NULL || machine->config.interruptible },
    };

    for (size_t i = 0; i < sizeof hooks / sizeof hooks[0]; i++) {
        uc_hook handle;
        uc_err error = hooks[i].wanted
                           ? uc_hook_add(emulator->uc, &handle, hooks[i].type, hooks[i].function,
                                         emulator, hooks[i].begin, hooks[i].end)
                           : UC_ERR_OK;

        if (error != UC_ERR_OK)
            return machine_fail(why, -EIO, "the emulator takes no hook: %s", uc_strerror(error));
    }
    return 0;
}
