/* SPDX-License-Identifier: GPL-2.0-or-later */
/* call.c - one native call into the module, seen from the host; and the brackets around services.
 */
#include <signal.h>
#include <string.h>

#include "machine/machine_private.h"

#ifdef ADDRESS_SANITIZER
#include <sanitizer/asan_interface.h>
#endif

volatile struct machine_state machine_state;
struct machine_incident machine_incident;

/* Which part of struct machine_state says that which part of the convention was broken. */
static const struct {
    size_t offset;
    uint64_t mask;
    unsigned bit;
} broken_parts[] = {
    { STATE_SEEN + 0, UINT64_MAX, MACHINE_ABI_RBX },
    { STATE_SEEN + 8, UINT64_MAX, MACHINE_ABI_RBP },
    { STATE_SEEN + 16, UINT64_MAX, MACHINE_ABI_R12 },
    { STATE_SEEN + 24, UINT64_MAX, MACHINE_ABI_R13 },
    { STATE_SEEN + 32, UINT64_MAX, MACHINE_ABI_R14 },
    { STATE_SEEN + 40, UINT64_MAX, MACHINE_ABI_R15 },
    { STATE_SEEN_STACK, UINT64_MAX, MACHINE_ABI_STACK },
    { STATE_SEEN_FLAGS, FLAG_DIRECTION, MACHINE_ABI_DIRECTION },
    { STATE_SEEN_FLAGS, FLAGS_CHECKED & ~FLAG_DIRECTION, MACHINE_ABI_FLAGS },
    { STATE_SEEN_MXCSR, UINT64_MAX, MACHINE_ABI_MXCSR },
    { STATE_SEEN_X87, UINT64_MAX, MACHINE_ABI_X87_CONTROL },
    { STATE_SEEN_X87TAG, UINT64_MAX, MACHINE_ABI_X87_STACK },
    { STATE_SEEN_FS, UINT64_MAX, MACHINE_ABI_FS },
    { STATE_SEEN_DI, UINT64_MAX, MACHINE_ABI_RDI },
    { STATE_SEEN_SI, UINT64_MAX, MACHINE_ABI_RSI },
    { STATE_SEEN_XMM, UINT64_MAX, MACHINE_ABI_XMM },
    { STATE_SEEN_GS, UINT64_MAX, MACHINE_ABI_GS },
    { STATE_SEEN_WINDOWS_X87, UINT64_MAX, MACHINE_ABI_X87_CONTROL },
};

static unsigned what_was_broken(void)
{
    unsigned bits = 0;

    for (size_t i = 0; i < sizeof broken_parts / sizeof broken_parts[0]; i++) {
        uint64_t seen;

        memcpy(&seen, (const char *)&machine_state + broken_parts[i].offset, sizeof seen);
        if (seen & broken_parts[i].mask)
            bits |= broken_parts[i].bit;
    }
    return bits;
}

uint64_t machine_now_ns(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

void machine_forget_frames(const struct machine *machine, const uint8_t *stack)
{
#ifdef ADDRESS_SANITIZER
    __asan_unpoison_memory_region(stack, machine->stack_size);
#else
    (void)machine;
    (void)stack;
#endif
}

__attribute__((noinline)) void machine_irregular(const struct machine *machine, uint64_t how,
                                                 struct machine_outcome *outcome)
{
    machine_thread_block_restore();
    if (how == LEFT_BROKEN) {
        outcome->kind = MACHINE_RETURNED;
        outcome->abi_broken = what_was_broken();
        return;
    }
    machine_forget_frames(machine, machine->stack);
    outcome->kind = machine_incident.kind;
    outcome->fault = machine_incident.fault;
    outcome->value = 0;
}

void machine_came_back(struct machine *machine, struct machine_left left,
                       struct machine_outcome *outcome)
{
    const struct machine_level *level = machine_level_at(machine, machine->level);

    outcome->elapsed_ns = machine->timing ? machine_now_ns() - level->begun_ns : 0;
    outcome->kind = MACHINE_RETURNED;
    outcome->abi_broken = 0;
    outcome->instructions = outcome->stack_bytes = 0;
    outcome->value = left.value;
    if (left.how == LEFT_ASIDE) {
        outcome->kind = MACHINE_ASIDE;
        outcome->aside = machine_level_aside(machine, machine->level);
        machine_level_set(machine, machine->level);
        return;
    }
    if (machine->config.interruptible)
        machine_level_end(machine);
    if (__builtin_expect(left.how != LEFT_CLEAN, 0))
        machine_irregular(machine, left.how, outcome);
}

void machine_native_call(struct machine *machine, uint64_t function, void *argument,
                         struct machine_outcome *outcome)
{
    machine_level_at(machine, machine->level)->begun_ns = machine->timing ? machine_now_ns() : 0;
    machine_incident.service_depth = 0;
    machine_incident.hung = false;
    if (machine->config.interruptible)
        machine_level_begin(machine);
    machine_came_back(machine, machine_enter(machine_address(machine, function), argument),
                      outcome);
}

void machine_native_service_enter(struct machine *machine, const char *service,
                                  void *return_address)
{
    if (machine_incident.service_depth == 0) {
        machine->served++;
        if (machine->config.interruptible)
            machine_service_steps(machine, false);
        machine_incident.service = service;
        machine_incident.service_return = return_address;
    }
    machine_incident.service_depth++;
}

/* The call was declared hung while the service ran, which has come to its own end in good order. */
static __attribute__((noinline)) void leave_hung(const struct machine *machine)
{
    struct machine_fault *fault = &machine_incident.fault;

    memset(fault, 0, sizeof *fault);
    fault->signal = SIGALRM;
    machine_attribute(machine, (uint64_t)__builtin_return_address(0), 0, fault);
    machine_incident.kind = MACHINE_HANG;
    machine_abandon();
}

void machine_native_service_leave(struct machine *machine)
{
    if (machine_incident.service_depth == 0)
        return;
    if (machine_incident.service_depth == 1 && machine_incident.hung && machine_state.active)
        leave_hung(machine);
    machine_incident.service_depth--;
    if (machine_incident.service_depth == 0 && machine->config.interruptible)
        machine_service_steps(machine, true);
}
