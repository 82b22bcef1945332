/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Calls that did not return as they should, in words. */
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules.h"

/* Where the address lies, seen from the nearest memory that has a name. */
static void describe_address(const struct machine_fault *fault, char *text, size_t size)
{
    const int64_t offset = fault->region_offset;
    const char *name = fault->region;
    if (strcmp(name, "module") == 0)
        name = "the module's own memory";
    else if (strcmp(name, "stack") == 0)
        name = "the stack";
    if (fault->address < 65536)
        snprintf(text, size, "through a null pointer (address 0x%" PRIx64 ")", fault->address);
    else if (fault->region[0] == '\0')
        snprintf(text, size, "at 0x%" PRIx64 " (near no shared memory)", fault->address);
    else if (offset < 0)
        snprintf(text, size, "%" PRIi64 " bytes before the start of %s", -offset, name);
    else if ((uint64_t)offset >= fault->region_size)
        snprintf(text, size, "at byte %" PRIi64 " of %s, which has %" PRIu64, offset, name,
                 fault->region_size);
    else
        snprintf(text, size, "at byte %" PRIi64 " of %s", offset, name);
}

bool experiment_was_stopped(const struct experiment_result *result)
{
    static const int from_outside[] = { SIGKILL, SIGTERM, SIGINT, SIGHUP, SIGXCPU, SIGQUIT };
    for (size_t i = 0; i < sizeof from_outside / sizeof *from_outside; i++)
        if (result->worker.end == WORKER_KILLED && result->worker.value == from_outside[i])
            return true;
    return false;
}

bool incident_is_stack_overflow(const struct machine_fault *fault)
{
    return strcmp(fault->region, "stack") == 0 && fault->region_offset < 0;
}

static void describe_fault(const struct machine_fault *fault, char *text, size_t size)
{
    static const char *const verbs[] = { "accessed memory", "read", "wrote", "jumped" };
    char address[200];
    switch (fault->signal) {
    case SIGFPE:
        snprintf(text, size, "divided by zero or overflowed a division");
        return;
    case SIGILL:
        snprintf(text, size, "executed an invalid instruction");
        return;
    case SIGBUS:
        snprintf(text, size, "accessed words at an address that is no multiple of 4");
        return;
    case SIGTRAP:
        snprintf(text, size, "executed a breakpoint or trap instruction");
        return;
    default:
        break;
    }
    if (incident_is_stack_overflow(fault)) {
        snprintf(text, size, "needs more than the %" PRIu64 " bytes of stack that it has",
                 fault->region_size);
        return;
    }
    describe_address(fault, address, sizeof address);
    snprintf(text, size, "%s %s", verbs[fault->access], address);
}

void incident_describe(const struct evidence_incident *incident, char text[FINDING_TEXT])
{
    const struct machine_fault *fault = &incident->fault;
    char what[FINDING_TEXT / 2] = "returned", name_of_call[MACHINE_CALL_NAME];
    const char *name = entry_name(incident->entry);
    switch (incident->kind) {
    case MACHINE_SYSCALL:
        machine_system_call_name(fault, name_of_call);
        snprintf(what, sizeof what, "called the operating system: %s (%ssystem call %ld)",
                 name_of_call,
                 fault->syscall_arm    ? "Arm "
                 : fault->syscall_i386 ? "32-bit "
                                       : "",
                 fault->syscall);
        break;
    case MACHINE_HANG:
        snprintf(what, sizeof what, "did not return within a second%s",
                 strcmp(incident->service, "pSleepFt") == 0 ? ", all of which it slept" : "");
        break;
    case MACHINE_FAULT:
        describe_fault(fault, what, sizeof what);
        break;
    case MACHINE_UNSUPPORTED:
        snprintf(what, sizeof what, "executed an instruction that the emulated CPU lacks");
        break;
    case MACHINE_RETURNED:
    case MACHINE_ASIDE:
        break;
    }
    if (incident->service[0] != '\0')
        snprintf(text, FINDING_TEXT, "%s %s, inside %s that it had called", name, what,
                 incident->service);
    else
        snprintf(text, FINDING_TEXT, "%s %s", name, what);
}

void incident_place(const struct evidence_incident *incident, struct finding *finding,
                    const struct case_file *file)
{
    const struct machine_fault *fault = &incident->fault;
    finding->stops = incident->kind == MACHINE_FAULT;
    if (incident->kind == MACHINE_SYSCALL)
        finding->plain_us = 0; /* in one process nothing would keep it from the system */
    /* A return address is behind the call, and may be on the next line. */
    if (fault->has_pc)
        finding_place(finding, file, fault->in_module ? fault->pc : fault->pc - 1);
}
