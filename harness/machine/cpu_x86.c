/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * cpu_x86.c - x86-64 with the calling conventions of ELF and of Windows, and i386 with that of
 * Windows (cdecl).
 */
#include <signal.h>

#include "machine/instrumented.h"

#define CLEAN_FLAGS   0x202u
#define MXCSR         0x1f80u
#define X87_ELF       0x37fu
#define X87_WINDOWS   0x27fu /* doubles */
#define X87_EMPTY     0xffffu
#define WORDS_OF_HOME 4 /* Win64: room above the return address for the arguments in registers */
#define MSR_FS_BASE   0xc0000100u
#define CR4_FSGSBASE  0x10000u

enum {
    VECTOR_DIVIDE,
    VECTOR_DEBUG,
    VECTOR_STACK = 12,
    VECTOR_X87 = 16,
    VECTOR_ALIGNMENT,
    VECTOR_SSE = 19
};

static const uint8_t ret[] = { 0xc3 };

/* What a callee has to leave as it was: register, what it is called when broken, sentinel's number
 * as the native machine has it. */
struct kept {
    int reg;
    unsigned bit, number;
};

static const struct kept kept_64[] = {
    { UC_X86_REG_RBX, MACHINE_ABI_RBX, 0 }, { UC_X86_REG_RBP, MACHINE_ABI_RBP, 1 },
    { UC_X86_REG_R12, MACHINE_ABI_R12, 2 }, { UC_X86_REG_R13, MACHINE_ABI_R13, 3 },
    { UC_X86_REG_R14, MACHINE_ABI_R14, 4 }, { UC_X86_REG_R15, MACHINE_ABI_R15, 5 },
    { UC_X86_REG_RDI, MACHINE_ABI_RDI, 6 }, { UC_X86_REG_RSI, MACHINE_ABI_RSI, 7 },
};
static const struct kept kept_32[] = {
    { UC_X86_REG_EBX, MACHINE_ABI_RBX, 0 },
    { UC_X86_REG_EBP, MACHINE_ABI_RBP, 1 },
    { UC_X86_REG_EDI, MACHINE_ABI_RDI, 6 },
    { UC_X86_REG_ESI, MACHINE_ABI_RSI, 7 },
};

#define COUNT(array) (sizeof(array) / sizeof(array)[0])
#define FIRST_XMM    6 /* that Windows keeps */
#define KEPT_XMMS    10

static bool is_wide(const struct emulator *emulator)
{
    return emulator->cpu->word == 8;
}

static bool is_windows(const struct emulator *emulator)
{
    return emulator->machine->convention != ARGUMENTS_SYSV;
}

static const struct kept *kept_of(const struct emulator *emulator, size_t *count)
{
    if (!is_wide(emulator)) {
        *count = COUNT(kept_32);
        return kept_32;
    }
    *count = is_windows(emulator) ? COUNT(kept_64) : COUNT(kept_64) - 2;
    return kept_64;
}

/* No address of anything. */
static uint64_t sentinel(const struct emulator *emulator, unsigned number)
{
    const uint64_t value = machine_sentinel(emulator->machine, number);

    return is_wide(emulator) ? value : (value & 0x0fffffffu) | 0xb0000000u;
}

static void xmm_sentinel(const struct emulator *emulator, unsigned number, uint64_t value[2])
{
    value[0] = machine_mix(emulator->machine->config.seed, 3, 2 * number);
    value[1] = machine_mix(emulator->machine->config.seed, 3, 2 * number + 1);
}

static bool keeps_xmm(const struct emulator *emulator)
{
    return emulator->machine->convention == ARGUMENTS_WIN64;
}

static uint16_t x87_control(const struct emulator *emulator)
{
    return is_windows(emulator) ? X87_WINDOWS : X87_ELF;
}

static void set_thread(struct emulator *emulator)
{
    uc_x86_msr base = { MSR_FS_BASE, (uint64_t)emulator->thread };

    if (!is_wide(emulator)) {
        uc_reg_write(emulator->uc, UC_X86_REG_MSR, &base);
        return;
    }
    emulator_write(emulator, UC_X86_REG_CR4,
                   emulator_read(emulator, UC_X86_REG_CR4) | CR4_FSGSBASE);
    emulator_write(emulator, is_windows(emulator) ? UC_X86_REG_GS_BASE : UC_X86_REG_FS_BASE,
                   base.value);
}

static void fresh(struct emulator *emulator)
{
    size_t count;
    const struct kept *kept = kept_of(emulator, &count);

    emulator_write(emulator, UC_X86_REG_EFLAGS, CLEAN_FLAGS);
    emulator_write(emulator, UC_X86_REG_MXCSR, MXCSR);
    emulator_write(emulator, UC_X86_REG_FPCW, x87_control(emulator));
    emulator_write(emulator, UC_X86_REG_FPTAG, X87_EMPTY);
    for (size_t i = 0; i < count; i++)
        emulator_write(emulator, kept[i].reg, sentinel(emulator, kept[i].number));
    for (unsigned i = 0; i < KEPT_XMMS && keeps_xmm(emulator); i++) {
        uint64_t value[2];

        xmm_sentinel(emulator, i, value);
        uc_reg_write(emulator->uc, UC_X86_REG_XMM0 + FIRST_XMM + (int)i, value);
    }
    set_thread(emulator);
}

static void enter(struct emulator *emulator, uint64_t function, uint64_t argument)
{
    struct emulator_level *level = emulator_level_at(emulator, emulator->depth - 1);
    const uint64_t sp = level->top - emulator->cpu->word;

    emulator_poke(emulator, sp, emulator->trap);
    if (!is_wide(emulator))
        emulator_poke(emulator, level->top, argument);
    else
        emulator_write(emulator, is_windows(emulator) ? UC_X86_REG_RCX : UC_X86_REG_RDI, argument);
    emulator_write(emulator, is_wide(emulator) ? UC_X86_REG_RAX : UC_X86_REG_EAX,
                   function); /* as a call through it would have */
    emulator_write(emulator, emulator->cpu->sp, sp);
    level->lowest = sp;
}

static unsigned broken_registers(struct emulator *emulator)
{
    size_t count;
    const struct kept *kept = kept_of(emulator, &count);
    unsigned broken = 0;

    for (size_t i = 0; i < count; i++)
        if (emulator_read(emulator, kept[i].reg) != sentinel(emulator, kept[i].number))
            broken |= kept[i].bit;
    for (unsigned i = 0; i < KEPT_XMMS && keeps_xmm(emulator); i++) {
        uint64_t wanted[2], seen[2];

        xmm_sentinel(emulator, i, wanted);
        uc_reg_read(emulator->uc, UC_X86_REG_XMM0 + FIRST_XMM + (int)i, seen);
        if (memcmp(wanted, seen, sizeof seen) != 0)
            broken |= MACHINE_ABI_XMM;
    }
    return broken;
}

static unsigned broken_state(struct emulator *emulator, uint64_t top)
{
    const uint64_t flags = emulator_read(emulator, UC_X86_REG_EFLAGS);
    const uint64_t mxcsr = emulator_read(emulator, UC_X86_REG_MXCSR);
    unsigned broken = 0;

    if (emulator_read(emulator, emulator->cpu->sp) != top)
        broken |= MACHINE_ABI_STACK;
    if (flags & FLAG_DIRECTION)
        broken |= MACHINE_ABI_DIRECTION;
    if (flags & FLAGS_CHECKED & ~(uint64_t)FLAG_DIRECTION)
        broken |= MACHINE_ABI_FLAGS;
    if ((mxcsr ^ MXCSR) & MXCSR_CONTROL)
        broken |= MACHINE_ABI_MXCSR;
    if (emulator_read(emulator, UC_X86_REG_FPCW) != x87_control(emulator))
        broken |= MACHINE_ABI_X87_CONTROL;
    if (!is_wide(emulator))
        return broken;
    if (is_windows(emulator) &&
        emulator_read(emulator, UC_X86_REG_GS_BASE) != (uint64_t)emulator->thread)
        broken |= MACHINE_ABI_GS;
    if (!is_windows(emulator) &&
        emulator_read(emulator, UC_X86_REG_FS_BASE) != (uint64_t)emulator->thread)
        broken |= MACHINE_ABI_FS;
    return broken;
}

static void leave(struct emulator *emulator, uint64_t top, struct machine_outcome *outcome)
{
    const uint64_t low = emulator_read(emulator, UC_X86_REG_EAX);

    outcome->value = is_wide(emulator)
                         ? (int64_t)emulator_read(emulator, UC_X86_REG_RAX)
                         : (int64_t)(low | emulator_read(emulator, UC_X86_REG_EDX) << 32);
    outcome->abi_broken = broken_registers(emulator) | broken_state(emulator, top);
    if (outcome->abi_broken == 0 && emulator_read(emulator, UC_X86_REG_FPTAG) != X87_EMPTY)
        outcome->abi_broken = MACHINE_ABI_X87_STACK;
}

static void sysv_arguments(struct emulator *emulator, uint64_t sp, struct arguments *arguments)
{
    static const int general[6] = { UC_X86_REG_RDI, UC_X86_REG_RSI, UC_X86_REG_RDX,
                                    UC_X86_REG_RCX, UC_X86_REG_R8,  UC_X86_REG_R9 };
    struct arguments_sysv *registers = &emulator->registers;

    for (size_t i = 0; i < COUNT(general); i++)
        registers->general[i] = emulator_read(emulator, general[i]);
    for (int i = 0; i < (int)COUNT(registers->vector); i++)
        uc_reg_read(emulator->uc, UC_X86_REG_XMM0 + i, &registers->vector[i]);
    arguments_from_sysv(arguments, registers, (const void *)(sp + 8));
}

static void win64_arguments(struct emulator *emulator, uint64_t sp, struct arguments *arguments)
{
    static const int general[WORDS_OF_HOME] = { UC_X86_REG_RCX, UC_X86_REG_RDX, UC_X86_REG_R8,
                                                UC_X86_REG_R9 };

    for (size_t i = 0; i < COUNT(general); i++)
        emulator_poke(emulator, sp + 8 + 8 * i, emulator_read(emulator, general[i]));
    arguments_from_win64(arguments, (const void *)(sp + 8));
}

static uint64_t arguments(struct emulator *emulator, struct arguments *arguments)
{
    const uint64_t sp = emulator_read(emulator, emulator->cpu->sp);

    if (!is_wide(emulator))
        arguments_from_cdecl(arguments, (const void *)(sp + 4));
    else if (is_windows(emulator))
        win64_arguments(emulator, sp, arguments);
    else
        sysv_arguments(emulator, sp, arguments);
    return emulator_peek(emulator, sp);
}

static void answer(struct emulator *emulator, int64_t value, uint64_t back)
{
    (void)back;
    emulator_write(emulator, emulator->cpu->sp,
                   emulator_read(emulator, emulator->cpu->sp) + emulator->cpu->word);
    if (is_wide(emulator)) {
        emulator_write(emulator, UC_X86_REG_RAX, (uint64_t)value);
        return;
    }
    emulator_write(emulator, UC_X86_REG_EAX, (uint32_t)value);
    emulator_write(emulator, UC_X86_REG_EDX, (uint64_t)value >> 32);
}

static int signal_of(struct emulator *emulator, uint32_t vector, bool *syscall)
{
    (void)emulator;
    (void)syscall;
    switch (vector) {
    case VECTOR_DIVIDE:
    case VECTOR_X87:
    case VECTOR_SSE:
        return SIGFPE;
    case VECTOR_DEBUG:
        return SIGTRAP;
    case VECTOR_STACK:
    case VECTOR_ALIGNMENT:
        return SIGBUS;
    default:
        return SIGSEGV;
    }
}

/* An address that no processor has is not told: no page of it is missing. */
static void access_rules(struct emulator *emulator, struct machine_fault *fault)
{
    enum { LONGEST = 15, UPPER_BITS = 17 };
    const uint64_t upper = fault->address >> 47;
    struct code_step step;

    if (!is_wide(emulator) || upper == 0 || upper == (1u << UPPER_BITS) - 1)
        return;
    fault->address = 0;
    fault->access = MACHINE_ACCESS_NONE;
    if (!machine_executes(emulator->machine, emulator->pc, 1))
        return;
    code_step_read(&emulator->stepper, (const uint8_t *)emulator->pc, LONGEST, emulator->pc, false,
                   &step);
    if (step.by_stack)
        fault->signal = SIGBUS;
}

#define X86(name, processor_mode, program_counter, stack, repeat_counter, bytes)                   \
    const struct emulator_cpu name = {                                                             \
        .arch = UC_ARCH_X86,                                                                       \
        .mode = processor_mode,                                                                    \
        .pc = program_counter,                                                                     \
        .sp = stack,                                                                               \
        .counter = repeat_counter,                                                                 \
        .word = bytes,                                                                             \
        .slot = 16,                                                                                \
        .back = ret,                                                                               \
        .back_size = sizeof ret,                                                                   \
        .fresh = fresh,                                                                            \
        .enter = enter,                                                                            \
        .leave = leave,                                                                            \
        .arguments = arguments,                                                                    \
        .answer = answer,                                                                          \
        .signal = signal_of,                                                                       \
        .access = access_rules,                                                                    \
    }

X86(emulator_x86_64, UC_MODE_64, UC_X86_REG_RIP, UC_X86_REG_RSP, UC_X86_REG_RCX, 8);
X86(emulator_i386, UC_MODE_32, UC_X86_REG_EIP, UC_X86_REG_ESP, UC_X86_REG_ECX, 4);
