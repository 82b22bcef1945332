/* SPDX-License-Identifier: GPL-2.0-or-later */
/* cpu_arm.c - 32-bit Arm, hard-float procedure call standard, as user code of a Cortex-A9. */
#include <signal.h>

#include "machine/instrumented.h"

#define USER_MODE         0x10u
#define FLOATS_ENABLED    0x40000000u  /* FPEXC.EN */
#define COPROCESSORS      (0xfu << 20) /* CPACR: 10 and 11 for everybody */
#define ROUNDING_AND_MORE 0x03f79f00u  /* FPSCR: what is not a result: modes, traps, lengths */
#define FIRST_KEPT        4            /* r4 to r11 */
#define FIRST_KEPT_DOUBLE 8            /* d8 to d15 */
#define KEPT              8

enum { VECTOR_SVC = 2, VECTOR_PREFETCH = 3, VECTOR_DATA = 4, VECTOR_BREAKPOINT = 7 };

static const uint8_t bx_lr[] = { 0x1e, 0xff, 0x2f, 0xe1 };

static const unsigned kept_bits[KEPT] = {
    MACHINE_ABI_RBX, MACHINE_ABI_RBP, MACHINE_ABI_R12, MACHINE_ABI_R13,
    MACHINE_ABI_R14, MACHINE_ABI_R14, MACHINE_ABI_R15, MACHINE_ABI_R15,
};

/* No address of anything. */
static uint32_t sentinel(const struct emulator *emulator, unsigned i)
{
    return (uint32_t)(machine_sentinel(emulator->machine, i) & 0x0fffffffu) | 0xb0000000u;
}

static uint64_t double_sentinel(const struct emulator *emulator, unsigned i)
{
    return machine_mix(emulator->machine->config.seed, 3, i);
}

static void fresh(struct emulator *emulator)
{
    uc_arm_cp_reg access = {
        .cp = 15, .is64 = 0, .sec = 0, .crn = 1, .crm = 0, .opc1 = 0, .opc2 = 2, .val = COPROCESSORS
    };

    uc_reg_write(emulator->uc, UC_ARM_REG_CP_REG, &access);
    emulator_write(emulator, UC_ARM_REG_FPEXC, FLOATS_ENABLED);
    emulator_write(emulator, UC_ARM_REG_FPSCR, 0);
    emulator_write(emulator, UC_ARM_REG_CPSR, USER_MODE);
    for (unsigned i = 0; i < KEPT; i++) {
        emulator_write(emulator, UC_ARM_REG_R0 + FIRST_KEPT + (int)i, sentinel(emulator, i));
        emulator_write(emulator, UC_ARM_REG_D0 + FIRST_KEPT_DOUBLE + (int)i,
                       double_sentinel(emulator, i));
    }
}

static void enter(struct emulator *emulator, uint64_t function, uint64_t argument)
{
    (void)function;
    emulator_write(emulator, UC_ARM_REG_R0, argument);
    emulator_write(emulator, UC_ARM_REG_SP, emulator_level_at(emulator, emulator->depth - 1)->top);
    emulator_write(emulator, UC_ARM_REG_LR, emulator->trap);
}

static void leave(struct emulator *emulator, uint64_t top, struct machine_outcome *outcome)
{
    unsigned broken = 0;

    for (unsigned i = 0; i < KEPT; i++) {
        if (emulator_read(emulator, UC_ARM_REG_R0 + FIRST_KEPT + (int)i) != sentinel(emulator, i))
            broken |= kept_bits[i];
        if (emulator_read(emulator, UC_ARM_REG_D0 + FIRST_KEPT_DOUBLE + (int)i) !=
            double_sentinel(emulator, i))
            broken |= MACHINE_ABI_XMM;
    }
    if (emulator_read(emulator, UC_ARM_REG_SP) != top)
        broken |= MACHINE_ABI_STACK;
    if (emulator_read(emulator, UC_ARM_REG_FPSCR) & ROUNDING_AND_MORE)
        broken |= MACHINE_ABI_MXCSR;
    outcome->abi_broken = broken;
    outcome->value = (int64_t)(emulator_read(emulator, UC_ARM_REG_R0) |
                               emulator_read(emulator, UC_ARM_REG_R1) << 32);
}

static uint64_t arguments(struct emulator *emulator, struct arguments *arguments)
{
    for (int i = 0; i < 4; i++)
        emulator->core_registers[i] = (uint32_t)emulator_read(emulator, UC_ARM_REG_R0 + i);
    arguments_from_aapcs(arguments, emulator->core_registers,
                         (const void *)emulator_read(emulator, UC_ARM_REG_SP));
    return emulator_read(emulator, UC_ARM_REG_LR);
}

static void answer(struct emulator *emulator, int64_t value, uint64_t back)
{
    (void)back;
    emulator_write(emulator, UC_ARM_REG_R0, (uint32_t)value);
    emulator_write(emulator, UC_ARM_REG_R1, (uint64_t)value >> 32);
}

static int signal_of(struct emulator *emulator, uint32_t vector, bool *syscall)
{
    (void)emulator;
    switch (vector) {
    case VECTOR_SVC:
        *syscall = true;
        return SIGSYS;
    case VECTOR_PREFETCH:
        return SIGSEGV;
    case VECTOR_DATA: /* what is missing is seen before: this one is not aligned */
        return SIGBUS;
    case VECTOR_BREAKPOINT:
        return SIGTRAP;
    default:
        return 0;
    }
}

static void access_rules(struct emulator *emulator, struct machine_fault *fault)
{
    (void)emulator;
    (void)fault;
}

static bool caller(struct emulator *emulator, uint64_t *back)
{
    const uint64_t lr = emulator_read(emulator, UC_ARM_REG_LR);

    *back = lr & ~UINT64_C(1);
    return machine_executes(emulator->machine, *back - 4, 5) &&
           code_call_before(&emulator->stepper, (const uint8_t *)*back, 4, *back, lr & 1) != 0;
}

const struct emulator_cpu emulator_arm = {
    .arch = UC_ARCH_ARM,
    .mode = UC_MODE_ARM,
    .pc = UC_ARM_REG_PC,
    .sp = UC_ARM_REG_SP,
    .word = 4,
    .slot = 16,
    .back = bx_lr,
    .back_size = sizeof bx_lr,
    .fresh = fresh,
    .enter = enter,
    .leave = leave,
    .arguments = arguments,
    .answer = answer,
    .signal = signal_of,
    .access = access_rules,
    .caller = caller,
};
