/* SPDX-License-Identifier: GPL-2.0-or-later */
/* filter.c - see filter.h. */
#define _GNU_SOURCE 1
#include <errno.h>
#include <linux/audit.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "machine/filter.h"

#define X32_BIT 0x40000000u

#ifndef SECCOMP_FILTER_FLAG_SPEC_ALLOW
#define SECCOMP_FILTER_FLAG_SPEC_ALLOW (1ul << 2)
#endif

static void emit(struct filter *filter, unsigned code, uint8_t when_true, uint8_t when_false,
                 uint32_t operand)
{
    struct sock_filter instruction = { (uint16_t)code, when_true, when_false, operand };

    if (filter->length == FILTER_CODE)
        filter->too_long = true;
    else
        filter->code[filter->length++] = instruction;
}

static void load(struct filter *filter, size_t offset)
{
    emit(filter, BPF_LD | BPF_W | BPF_ABS, 0, 0, (uint32_t)offset);
}

static void decide(struct filter *filter, uint32_t action)
{
    emit(filter, BPF_RET | BPF_K, 0, 0, action);
}

void filter_begin(struct filter *filter, uint32_t foreign)
{
    filter->length = 0;
    filter->too_long = false;
    load(filter, offsetof(struct seccomp_data, arch));
    emit(filter, BPF_JMP | BPF_JEQ | BPF_K, 1, 0, AUDIT_ARCH_X86_64);
    decide(filter, foreign);
    load(filter, offsetof(struct seccomp_data, nr));
    emit(filter, BPF_JMP | BPF_JSET | BPF_K, 0, 1, X32_BIT);
    decide(filter, foreign);
}

void filter_range(struct filter *filter, uint64_t begin, uint64_t end, uint32_t action)
{
    size_t at = offsetof(struct seccomp_data, instruction_pointer);

    load(filter, at + 4);
    emit(filter, BPF_JMP | BPF_JEQ | BPF_K, 0, 4, (uint32_t)(begin >> 32));
    load(filter, at);
    emit(filter, BPF_JMP | BPF_JGE | BPF_K, 0, 2, (uint32_t)begin);
    emit(filter, BPF_JMP | BPF_JGT | BPF_K, 1, 0, (uint32_t)end);
    decide(filter, action);
}

/* One half of an argument; a miss skips `rest` instructions. */
static void match(struct filter *filter, size_t offset, uint32_t mask, uint32_t value, uint8_t rest)
{
    load(filter, offset);
    emit(filter, BPF_ALU | BPF_AND | BPF_K, 0, 0, mask);
    emit(filter, BPF_JMP | BPF_JEQ | BPF_K, 0, rest, value & mask);
}

void filter_rule(struct filter *filter, const struct filter_rule *rule)
{
    enum { PER_CONDITION = 6 };
    /* Instructions after the comparison of the number; a miss jumps over all of them. */
    unsigned rest = rule->count * PER_CONDITION + 1;

    load(filter, offsetof(struct seccomp_data, nr));
    emit(filter, BPF_JMP | BPF_JEQ | BPF_K, 0, (uint8_t)rest, (uint32_t)rule->number);
    for (unsigned i = 0; i < rule->count; i++) {
        const struct filter_condition *condition = &rule->conditions[i];
        size_t at = offsetof(struct seccomp_data, args) + 8u * condition->argument;
        uint32_t high = (uint32_t)(condition->mask >> 32), low = (uint32_t)condition->mask;

        rest -= PER_CONDITION;
        if (condition->differs) {
            /* The halves differ unless both match: the second miss is the hit. */
            match(filter, at + 4, high, (uint32_t)(condition->value >> 32), 3);
            load(filter, at);
            emit(filter, BPF_ALU | BPF_AND | BPF_K, 0, 0, low);
            emit(filter, BPF_JMP | BPF_JEQ | BPF_K, (uint8_t)rest, 0,
                 (uint32_t)condition->value & low);
        } else {
            match(filter, at + 4, high, (uint32_t)(condition->value >> 32), (uint8_t)(rest + 3));
            match(filter, at, low, (uint32_t)condition->value, (uint8_t)rest);
        }
    }
    decide(filter, rule->action);
}

void filter_end(struct filter *filter, uint32_t action)
{
    decide(filter, action);
}

int filter_install(const struct filter *filter)
{
    struct sock_fprog program = { (unsigned short)filter->length,
                                  (struct sock_filter *)(uintptr_t)filter->code };

    if (filter->too_long)
        return -E2BIG;
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
        return -errno;
    /* Without SPEC_ALLOW some kernels slow every load after a store of a filtered process, and so
     * every timing of the module. */
    if (syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_SPEC_ALLOW, &program) ==
        0)
        return 0;
    if (errno != EINVAL)
        return -errno;
    return syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, &program) == 0 ? 0 : -errno;
}
