/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * instrumented.h - the machine that is an emulated CPU; private to instrumented*.c and cpu_*.c.
 *
 * Guest memory is mapped where the host has it, with the rights of its pages and nothing in
 * between, so that whatever the module should not reach is not there for it. The stack is an
 * exception to ordinary memory: each access to it passes a function of ours, which is the cheapest
 * way to know how deep it went (and cheaper for Unicorn than its own writes to ordinary memory,
 * each of which looks for translated code).
 *
 * One hook sees every instruction before it is executed. It counts, stops where the count says so,
 * and knows by a table of one byte per byte of the module which instructions are ordinary.
 */
#ifndef HARNESS_MACHINE_INSTRUMENTED_H
#define HARNESS_MACHINE_INSTRUMENTED_H

#include <setjmp.h>
#include <string.h>

#include <unicorn/unicorn.h>

#include "image/code_step.h"
#include "machine/arguments.h"
#include "machine/machine_private.h"

#define EMULATOR_SIGNALS 6

/* Why the emulation stopped. */
enum emulator_stop {
    EMULATOR_RUNNING,
    EMULATOR_RETURNED,  /* to where the call came from */
    EMULATOR_SERVICE,   /* at the entry of a host service */
    EMULATOR_INTERRUPT, /* the wanted number of instructions */
    EMULATOR_ASIDE,     /* behind a host service that has set the call aside */
    EMULATOR_HANG,
    EMULATOR_MEMORY,      /* an access that is not allowed */
    EMULATOR_EXCEPTION,   /* vector in number */
    EMULATOR_INSTRUCTION, /* one that cannot be executed, kind in number */
    EMULATOR_BROKEN       /* Unicorn gave up, its error in number */
};

struct emulator;

/* What differs by processor and calling convention. */
struct emulator_cpu {
    uc_arch arch;
    uc_mode mode;
    int pc, sp;
    int counter; /* of repeated instructions */
    unsigned word;
    unsigned slot;       /* bytes from one entry of the services' page to the next */
    const uint8_t *back; /* the code of an entry: an instruction that returns */
    unsigned back_size;
    /* State of the processor before every call, except what enter() sets. Once. */
    void (*fresh)(struct emulator *emulator);
    /* Registers and stack for a call of the function there with that argument. */
    void (*enter)(struct emulator *emulator, uint64_t function, uint64_t argument);
    /* After the return. */
    void (*leave)(struct emulator *emulator, uint64_t top, struct machine_outcome *outcome);
    /* At the entry of a service: its arguments, and where it returns to. */
    uint64_t (*arguments)(struct emulator *emulator, struct arguments *arguments);
    /* Behind its return. */
    void (*answer)(struct emulator *emulator, int64_t value, uint64_t back);
    /* Signal of an exception, 0: not the module's doing. */
    int (*signal)(struct emulator *emulator, uint32_t vector, bool *syscall);
    /* In a fault: what the processor's rules add to an access to that address. */
    void (*access)(struct emulator *emulator, struct machine_fault *fault);
    /* The return address of a call that led nowhere, from the registers; false: look at the stack.
     */
    bool (*caller)(struct emulator *emulator, uint64_t *back);
};

/* One of the calls that stand inside one another. */
struct emulator_level {
    uint8_t *stack;
    uint64_t top;
    uint64_t lowest;         /* address of the stack that the call touched */
    machine_interrupt *hook; /* for the next call */
    void *argument;
    uint64_t after;
    uint64_t executed; /* instructions of its latest call */
    /* While it is interrupted or aside: where it is gone on with, and what else belongs to its
     * state. */
    uint64_t interrupted_back, interrupted_pc, interrupted_sp, interrupted_executed;
    uint64_t interrupt_at, block_next, block_end; /* aside */
    uc_context *interrupted;
};

struct emulator_memory {
    uint64_t begin, end; /* what the module can reach */
    uint64_t start;      /* of the region */
    bool writable;
    uint32_t number;
};

/* Memory as it was before an instruction that is tried out wrote there. */
#define EMULATOR_KEPT 64
struct emulator_kept {
    uint64_t address;
    unsigned size;
    uint8_t bytes[16];
};

/* One instruction tried out for what it accesses. */
struct emulator_probe {
    struct code_operand *operands;
    unsigned count;
    unsigned kept_count;
    struct emulator_kept kept[EMULATOR_KEPT];
};

struct emulator {
    /* Looked at for every instruction. */
    uint64_t base;     /* where the module lies */
    uint8_t *kinds;    /* for each byte of it: enum code_step_kind of the instruction that begins
                          there and has been executed, else 0 */
    uint64_t executed; /* instructions of the call */
    uint64_t stop_at;  /* stop instead of executing this one */
    uint64_t pc;       /* the latest instruction */
    uint64_t block_next, block_end; /* of the block that a Thumb IT began; 0: none */

    struct machine *machine;
    const struct emulator_cpu *cpu;
    uc_engine *uc;
    uc_context *fresh;
    struct code_stepper stepper;
    uint8_t *covered; /* a bit for each byte of the module */
    bool shared;      /* some page of the module is writable and executable */

    enum emulator_stop stop;
    uint32_t number;
    uc_mem_type access;
    uint64_t address;

    uint64_t interrupt_at;
    bool pass; /* the next instruction is executed whatever stop_at says */

    struct emulator_probe *probe; /* NULL: none */
    uint8_t *rehearsed;           /* room for the stack of a call that is rehearsed */

    unsigned depth; /* calls that stand inside one another */
    struct emulator_level levels[MACHINE_LEVELS];
    size_t deepest;

    struct machine_reservation services; /* return trap, then the services */
    uint64_t trap;
    uint64_t odd; /* Arm: the bit of an address that stands for Thumb code */
    void *thread; /* what fs or gs points to, as the module sees it; NULL: nothing */
    uint8_t *thread_host;
    struct arguments_sysv registers; /* of the service that runs */
    uint32_t core_registers[4];

    /* A host service is running for the module. */
    const char *service;
    uint64_t service_back;
    volatile bool serving;
    sigjmp_buf escape;
    volatile int escaped_signal;
    volatile uint64_t escaped_address, escaped_error, escaped_ip;
    struct sigaction borrowed[EMULATOR_SIGNALS];
    bool handling;

    struct emulator_memory memories[MAX_REGIONS];
    uint32_t memory_count;
};

extern const struct emulator_cpu emulator_x86_64, emulator_i386, emulator_arm;

/* instrumented_hooks.c */
int emulator_hooks(struct emulator *emulator, char why[MACHINE_WHY]);
int emulator_map_stack(struct emulator *emulator, unsigned level, char why[MACHINE_WHY]);
void emulator_stop(struct emulator *emulator, enum emulator_stop stop, uint32_t number);

/* instrumented_call.c */
void emulator_call(struct machine *machine, uint64_t function, void *argument,
                   struct machine_outcome *outcome);

/* instrumented_call.c: calls that are set aside */
bool emulator_set_aside(const struct machine *machine);
unsigned emulator_depth(const struct machine *machine);
void emulator_go_on(struct machine *machine, struct machine_outcome *outcome);

void emulator_set_stop(struct emulator *emulator, uint64_t interrupt_at);
void emulator_use_stack(struct emulator *emulator, const struct emulator_level *level);
/* Back to the state of a call that is interrupted or aside. */
void emulator_take_up(struct emulator *emulator, const struct emulator_level *level);
/* The running level's call to its end, from an address on. */
void emulator_run_on(struct emulator *emulator, uint64_t pc, struct machine_outcome *outcome);

/* instrumented_rehearse.c */
void emulator_rehearse(struct machine *machine, struct machine_outcome *outcome);
void emulator_probe(struct emulator *emulator, uint64_t address, unsigned size, bool write);
unsigned emulator_next_operands(struct machine *machine,
                                struct code_operand operands[CODE_OPERANDS]);

/* instrumented_fault.c: what happened, as a native machine would put it */
void emulator_fault(struct emulator *emulator, struct machine_outcome *outcome);
void emulator_service_fault(struct emulator *emulator, struct machine_outcome *outcome);

/* What a call at that depth stands in. */
static inline struct emulator_level *emulator_level_at(struct emulator *emulator, unsigned depth)
{
    return &emulator->levels[emulator->machine->order[depth]];
}

static inline uint64_t emulator_read(struct emulator *emulator, int reg)
{
    uint64_t value = 0;

    uc_reg_read(emulator->uc, reg, &value);
    return value;
}

static inline void emulator_write(struct emulator *emulator, int reg, uint64_t value)
{
    uc_reg_write(emulator->uc, reg, &value);
}

/* A word of the module's memory that is there. */
static inline uint64_t emulator_peek(const struct emulator *emulator, uint64_t address)
{
    uint64_t value = 0;

    memcpy(&value, (const void *)address, emulator->cpu->word);
    return value;
}

static inline void emulator_poke(const struct emulator *emulator, uint64_t address, uint64_t value)
{
    memcpy((void *)address, &value, emulator->cpu->word);
}

#endif
