/* SPDX-License-Identifier: GPL-2.0-or-later */
/* native.c - the machine that is this process's own processor. */
#define _GNU_SOURCE 1
#include <errno.h>
#include <sys/auxv.h>
#include <sys/personality.h>

#include "machine/machine_private.h"

#define HWCAP2_FSGSBASE_BIT (1ul << 1)
#define WINDOWS_X87         0x27f /* precision of 53 bits, where Linux has 64 */

/* Otherwise every readable page would be executable. */
static int check_process(char why[MACHINE_WHY])
{
    int persona = personality(0xffffffff);

    if (persona != -1 && (persona & READ_IMPLIES_EXEC))
        return machine_fail(why, -ENOTSUP, "the process runs with READ_IMPLIES_EXEC");
    return 0;
}

/* The module starts every call with the same callee-saved registers: no host address leaks in, and
 * a change is noticed. No canonical address, so that using one as a pointer faults. */
uint64_t machine_sentinel(const struct machine *machine, unsigned i)
{
    return (machine_mix(machine->config.seed, 2, i) & 0x0000ffffffffffffu) | 0x5e00000000000000u;
}

static void prepare_state(const struct machine *machine)
{
    struct machine_state fresh = { .has_fsgsbase = 0 };

    fresh.serial = machine_state.serial;
    for (unsigned i = 0; i < 6; i++)
        fresh.sentinel[i] = machine_sentinel(machine, i);
    for (unsigned i = 0; i < 2; i++)
        fresh.windows_sentinel[i] = machine_sentinel(machine, 6 + i);
    for (unsigned i = 0; i < 20; i++)
        fresh.windows_xmm[i / 2][i % 2] = machine_mix(machine->config.seed, 3, i);
    fresh.windows_x87 = WINDOWS_X87;
    fresh.stack_top = machine_stack_top(machine, machine->stack);
    fresh.has_fsgsbase = (getauxval(AT_HWCAP2) & HWCAP2_FSGSBASE_BIT) != 0;
    fresh.host_fs = machine_thread_base();
    machine_state = fresh;
}

static int native_open(struct machine *machine, const struct image *image, char why[MACHINE_WHY])
{
    int error = check_process(why);

    if (error == 0)
        error = machine_levels_open(machine, why);
    if (error != 0)
        return error;
    prepare_state(machine);
    if (image->format == IMAGE_FORMAT_PE)
        error = machine_thread_block_open(machine, why);
    if (error != 0)
        return error;
    machine_incident = (struct machine_incident){ .machine = machine };
    error = machine_handlers_install(machine, why);
    return error != 0 ? error : machine_watchdog_start(machine, why);
}

static void native_close(struct machine *machine)
{
    machine_watchdog_stop(machine);
    for (unsigned i = 0; i < machine->level_count; i++)
        machine_forget_frames(machine, machine->levels[i].stack);
    machine_levels_close(machine);
    machine_handlers_remove(machine);
    machine_thread_block_close(machine);
    if (machine_incident.machine == machine)
        machine_incident.machine = NULL;
    if (!machine->sealed)
        machine_release(&machine->signal_stack);
}

static bool native_busy(const struct machine *machine)
{
    return machine->level > 0 || machine_state.active ||
           machine->levels_left < machine->level_count;
}

const struct machine_ops machine_native = {
    .open = native_open,
    .close = native_close,
    .service = machine_native_service,
    .busy = native_busy,
    .call = machine_native_call,
    .interrupt_next = machine_native_interrupt_next,
    .instructions = machine_native_instructions,
    .rehearse = machine_native_rehearse,
    .set_aside = machine_native_set_aside,
    .step_aside = machine_native_step_aside,
    .depth = machine_native_depth,
    .go_on = machine_native_go_on,
    .next_operands = machine_native_next_operands,
    .alarm_open = machine_native_alarm_open,
    .alarm_at = machine_native_alarm_at,
    .stack_used = machine_stack_deepest,
    .service_enter = machine_native_service_enter,
    .service_leave = machine_native_service_leave,
};
