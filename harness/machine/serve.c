/* SPDX-License-Identifier: GPL-2.0-or-later */
/* serve.c - functions of the host that module code may call. */
#include <errno.h>
#include <string.h>

#include "machine/machine_private.h"

extern const uint8_t machine_thunks_sysv[], machine_thunks_win64[];
/* Called by thunks.S; `registers` are those of SYSV. */
bool machine_service_caller(const struct machine *machine, uint64_t *pc)
{
    return machine_vaddr(machine, machine->caller, pc);
}

int64_t machine_served(unsigned number, const struct arguments_sysv *registers, const void *stack,
                       void *return_address) __attribute__((visibility("hidden")));

int machine_native_service(struct machine *machine, const char *name, machine_function *function,
                           void *context, void **pointer, char why[MACHINE_WHY])
{
    const uint8_t *thunks =
        machine->convention == ARGUMENTS_WIN64 ? machine_thunks_win64 : machine_thunks_sysv;

    if (machine->service_count == MACHINE_SERVICES)
        return machine_fail(why, -ENOSPC, "%s: more than %d services", name, MACHINE_SERVICES);
    machine->services[machine->service_count] = (struct machine_served){ name, function, context };
    *pointer = (void *)(uintptr_t)(thunks + (size_t)THUNK_BYTES * machine->service_count++);
    return 0;
}

int64_t machine_service_call(struct machine *machine, unsigned number, struct arguments *arguments,
                             void *return_address)
{
    const struct machine_served *service = &machine->services[number];
    int64_t value;

    machine_service_enter(machine, service->name, return_address);
    machine->caller = return_address;
    machine->aside = false;
    value = service->function(service->context, arguments);
    if (machine->aside && machine->ops->step_aside != NULL)
        machine->ops->step_aside(machine);
    machine_service_leave(machine);
    return value;
}

int64_t machine_served(unsigned number, const struct arguments_sysv *registers, const void *stack,
                       void *return_address)
{
    struct machine *machine = machine_incident.machine;
    struct arguments arguments;

    if (number >= machine->service_count)
        return 0; /* the module made up an address */
    if (registers != NULL)
        arguments_from_sysv(&arguments, registers, stack);
    else
        arguments_from_win64(&arguments, stack);
    return machine_service_call(machine, number, &arguments, return_address);
}
