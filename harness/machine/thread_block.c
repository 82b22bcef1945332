/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * thread_block.c - what code made for Windows finds through gs: the block of its thread.
 *
 * Of all that Windows keeps there, compiled code without a C library reads the bounds of its stack
 * (__chkstk, in front of every frame of more than a page) and where the block lies. The rest is
 * zero: a module that goes looking for the system's libraries through it finds a null pointer. The
 * block cannot be written by the module.
 */
#define _GNU_SOURCE 1
#include <asm/prctl.h>
#include <errno.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "machine/machine_private.h"

/* NT_TIB of winnt.h, as far as it is used, and room for the rest of the block. */
struct thread_block {
    uint64_t exception_list;
    uint64_t stack_base;  /* first byte above the stack */
    uint64_t stack_limit; /* its lowest byte that is there; a page's first */
    uint64_t unused[3];
    uint64_t self;
    uint8_t rest[8192 - 56];
};
_Static_assert(offsetof(struct thread_block, stack_base) == 0x08, "gs:8");
_Static_assert(offsetof(struct thread_block, stack_limit) == 0x10, "gs:0x10");
_Static_assert(offsetof(struct thread_block, self) == 0x30, "gs:0x30");

int machine_thread_block_open(struct machine *machine, char why[MACHINE_WHY])
{
    void *host, *module;
    int error = machine_map(machine, "thread block", sizeof(struct thread_block),
                            MACHINE_REGION_READ, &host, &module, why);

    if (error != 0)
        return error;
    if (syscall(SYS_arch_prctl, ARCH_GET_GS, &machine->borrowed_gs) != 0 ||
        syscall(SYS_arch_prctl, ARCH_SET_GS, module) != 0)
        return machine_fail(why, -errno, "no thread block for the module: %s", strerror(errno));
    machine->thread_block = host;
    machine->thread_block->self = (uint64_t)module;
    machine_state.thread_block = (uint64_t)module;
    machine_thread_block_update(machine);
    return 0;
}

void machine_thread_block_close(struct machine *machine)
{
    if (machine->thread_block == NULL)
        return;
    if (!machine->sealed)
        syscall(SYS_arch_prctl, ARCH_SET_GS, machine->borrowed_gs);
    machine->thread_block = NULL;
    machine_state.thread_block = 0;
}

void machine_thread_block_update(const struct machine *machine)
{
    if (machine->thread_block == NULL)
        return;
    machine->thread_block->stack_base = (uint64_t)machine->stack + machine->stack_size;
    machine->thread_block->stack_limit = (uint64_t)machine->stack;
}

void machine_thread_block_restore(void)
{
    const uint64_t base = machine_state.thread_block;

    if (base == 0)
        return;
    if (machine_state.has_fsgsbase)
        __asm__ volatile("wrgsbase %0" : : "r"(base));
    else
        syscall(SYS_arch_prctl, ARCH_SET_GS, base);
}
