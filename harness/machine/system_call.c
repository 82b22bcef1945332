/* SPDX-License-Identifier: GPL-2.0-or-later */
/* system_call.c - system calls by name, as libseccomp knows them. */
#include <stdio.h>
#include <stdlib.h>

#include <seccomp.h>

#include "machine/machine.h"

#define X32_BIT 0x40000000

void machine_system_call_name(const struct machine_fault *fault, char name[MACHINE_CALL_NAME])
{
    const uint32_t table = fault->syscall_arm                ? SCMP_ARCH_ARM
                           : fault->syscall_i386             ? SCMP_ARCH_X86
                           : (fault->syscall & X32_BIT) != 0 ? SCMP_ARCH_X32
                                                             : SCMP_ARCH_X86_64;
    char *found = seccomp_syscall_resolve_num_arch(table, (int)fault->syscall);

    snprintf(name, MACHINE_CALL_NAME, "%s", found != NULL ? found : "unknown");
    free(found);
}
