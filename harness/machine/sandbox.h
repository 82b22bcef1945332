/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * sandbox.h - what a sealed process may still ask of the kernel.
 *
 * From the module's own code: nothing. Every system call made there, in whichever way (syscall,
 * int 0x80, x32 numbers), is refused and reported as MACHINE_SYSCALL with its place.
 *
 * From anywhere else in the process (host code, or library code that the module jumped into): what
 * the table in sandbox.c lists. Those calls open nothing, start nothing, reach no other process and
 * make nothing executable. Files are locked a second time (Landlock), where the kernel can.
 * Anything else is refused in the same way: while a module call is active it is the call's outcome,
 * otherwise it is a defect of the harness and ends the process with SIGSYS, which the parent sees
 * as WORKER_KILLED.
 *
 * Not caught here, because no system call is involved: rdtsc, rdtscp, rdpmc, cpuid, rdrand and
 * other unprivileged instructions that are not repeatable, and functions of the vDSO such as
 * clock_gettime(), should a module find it. The static rules look for those. (rdtsc could be made
 * to trap with PR_SET_TSC, but the host's own clock reads through the vDSO use it.) The legacy
 * vsyscall page is caught: its calls pass the filter and none of them is allowed.
 *
 * Not prevented: a module that finds the C library's way out of signal handlers can make up a
 * signal frame that blocks every signal, and spin: the watchdog does not reach it, the parent's
 * time limit does (WORKER_TIMEOUT: not judged, never passed).
 *
 * Not prevented either: the module can write to whatever memory of its process it finds. It then
 * spoils its own evidence or crashes its worker; that is why the worker is a process, and why the
 * parent trusts nothing that it says.
 */
#ifndef HARNESS_MACHINE_SANDBOX_H
#define HARNESS_MACHINE_SANDBOX_H

#include <stdint.h>

struct sandbox {
    uint64_t begin, end;   /* address range of the module; same upper 32 bits */
    uint64_t thread_base;  /* fs base, which the fault handler may have to set again */
    uint64_t thread_block; /* base of gs that may be set again, 0: none */
    int evidence_fd;       /* the one descriptor that may be written to, -1 for none */
    int alarm;             /* the one timer that may be set, -1 for none */
};

/* 0 or negative errno. Cannot be undone. */
int sandbox_enter(const struct sandbox *sandbox);

#endif
