/* SPDX-License-Identifier: GPL-2.0-or-later */
/* instrumented.c - an emulated CPU with the module's memory around it, from beginning to end. */
#define _GNU_SOURCE 1
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "machine/instrumented.h"

static const struct {
    enum image_target target;
    const struct emulator_cpu *cpu;
    int model; /* -1: Unicorn's own choice */
} cpus[] = {
    { IMAGE_TARGET_X86_64, &emulator_x86_64, -1 },
    { IMAGE_TARGET_I386, &emulator_i386, -1 },
    { IMAGE_TARGET_ARM, &emulator_arm, UC_CPU_ARM_CORTEX_A9 },
};

/* The first three are what a bad pointer in a host service ends in. Of the rest, as outside
 * services, the reason is told. */
static const int guarded[] = { SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGSYS };
#define GUARDED      (sizeof guarded / sizeof guarded[0])
#define SERVICE_ENDS 3

_Static_assert(GUARDED == EMULATOR_SIGNALS, "each has an action to give back");

/* The machine whose services the handler looks after. */
static struct emulator *handled;

static int fail(char why[MACHINE_WHY], const char *what, uc_err error)
{
    return machine_fail(why, error == UC_ERR_NOMEM ? -ENOMEM : -EIO, "the emulator %s: %s", what,
                        uc_strerror(error));
}

static __attribute__((noreturn)) void escape(void)
{
    siglongjmp(handled->escape, 1);
}

static bool ends_a_service(int sig, const siginfo_t *info)
{
    bool ends = false;

    for (size_t i = 0; i < SERVICE_ENDS; i++)
        ends |= sig == guarded[i];
    return ends && handled != NULL && handled->serving && info->si_code > 0;
}

/* Goes on with escape() instead of jumping there, so that the kernel puts the signal mask back: a
 * sealed process cannot. */
static void on_signal(int sig, siginfo_t *info, void *context)
{
    ucontext_t *interrupted = context;
    const greg_t *registers = interrupted->uc_mcontext.gregs;

    if (!ends_a_service(sig, info)) {
        machine_die(sig, info, interrupted);
        return;
    }
    handled->escaped_signal = sig;
    handled->escaped_address = (uint64_t)info->si_addr;
    handled->escaped_error = (uint64_t)registers[REG_ERR];
    handled->escaped_ip = (uint64_t)registers[REG_RIP];
    /* As if called from there: the return address would have taken 8 bytes. */
    machine_redirect(interrupted, (uint64_t)escape,
                     (((uint64_t)registers[REG_RSP] - 256) & ~(uint64_t)15) - 8);
}

static void install_handlers(struct emulator *emulator)
{
    struct sigaction action;

    memset(&action, 0, sizeof action);
    action.sa_sigaction = on_signal;
    action.sa_flags = SA_SIGINFO;
    sigfillset(&action.sa_mask);
    for (size_t i = 0; i < GUARDED; i++)
        sigaction(guarded[i], &action, &emulator->borrowed[i]);
    emulator->handling = true;
    handled = emulator;
}

static void remove_handlers(struct emulator *emulator)
{
    if (!emulator->handling)
        return;
    handled = NULL;
    for (size_t i = 0; i < GUARDED && !emulator->machine->sealed; i++)
        sigaction(guarded[i], &emulator->borrowed[i], NULL);
}

static uint32_t rights(int access)
{
    return (access & PROT_READ ? UC_PROT_READ : 0u) | (access & PROT_WRITE ? UC_PROT_WRITE : 0u) |
           (access & PROT_EXEC ? UC_PROT_EXEC : 0u);
}

/* The pages of the module, with the rights that they have. */
static int map_module(struct emulator *emulator, char why[MACHINE_WHY])
{
    const struct machine *machine = emulator->machine;
    const size_t count = (machine->span_end - machine->span_begin) / PAGE;

    for (size_t page = 0, run; page < count; page += run) {
        const int access = machine->page_access[page];
        uint8_t *at = machine->hull + page * PAGE;
        uc_err error = UC_ERR_OK;

        for (run = 1; page + run < count && machine->page_access[page + run] == access; run++)
            ;
        if (access != 0)
            error = uc_mem_map_ptr(emulator->uc, (uint64_t)at, run * PAGE, rights(access), at);
        if (error != UC_ERR_OK)
            return fail(why, "takes no module", error);
        emulator->shared |= (access & PROT_WRITE) && (access & PROT_EXEC);
    }
    return 0;
}

/* One page: where calls come back to, then an entry for each host service, each an instruction that
 * returns. The emulation never executes the rest. */
static int map_services(struct emulator *emulator, char why[MACHINE_WHY])
{
    const struct machine *machine = emulator->machine;
    const struct emulator_cpu *cpu = emulator->cpu;
    int error = machine_reserve(&emulator->services, machine_place_seed(machine), MAX_REGIONS,
                                machine->low, PAGE + 2 * REGION_GUARD);
    uint8_t *page = emulator->services.base + REGION_GUARD;
    uc_err refused;

    if (error != 0 || mprotect(page, PAGE, PROT_READ | PROT_WRITE) != 0)
        return machine_fail(why, error != 0 ? error : -errno, "no page for host services");
    for (size_t i = 0; i < PAGE; i += cpu->slot)
        memcpy(page + i, cpu->back, cpu->back_size);
    if (mprotect(page, PAGE, PROT_READ) != 0)
        return machine_fail(why, -errno, "no page for host services");
    emulator->trap = (uint64_t)page;
    refused = uc_mem_map_ptr(emulator->uc, emulator->trap, PAGE, UC_PROT_READ | UC_PROT_EXEC, page);
    return refused == UC_ERR_OK ? 0 : fail(why, "takes no services", refused);
}

static int open_levels(struct emulator *emulator, char why[MACHINE_WHY])
{
    int error = 0;

    for (unsigned i = 0; i < emulator->machine->level_count && error == 0; i++) {
        if (uc_context_alloc(emulator->uc, &emulator->levels[i].interrupted) != UC_ERR_OK)
            return machine_fail(why, -ENOMEM, "no memory for interrupted calls");
        error = emulator_map_stack(emulator, i, why);
    }
    return error;
}

/* What code for Windows or Linux finds through gs or fs: itself, and how far the stack reaches. */
static int open_thread(struct emulator *emulator, char why[MACHINE_WHY])
{
    struct machine *machine = emulator->machine;
    const bool windows = machine->convention != ARGUMENTS_SYSV;
    void *host;
    int error;

    if (emulator->cpu->arch != UC_ARCH_X86)
        return 0;
    error = machine_map(machine, "thread block", 2 * PAGE,
                        windows ? MACHINE_REGION_READ : MACHINE_REGION_READ_WRITE, &host,
                        &emulator->thread, why);
    if (error != 0)
        return error;
    emulator->thread_host = host;
    const uint64_t self = (uint64_t)emulator->thread;

    if (machine->convention == ARGUMENTS_SYSV)
        memcpy(host, &self, 8);
    else if (machine->convention == ARGUMENTS_WIN64)
        memcpy((uint8_t *)host + 0x30, &self, 8);
    else
        memcpy((uint8_t *)host + 0x18, &self, 4);
    emulator->memory_count = 0; /* it is none of the caller's */
    return 0;
}

static int open_cpu(struct emulator *emulator, const struct image *image, char why[MACHINE_WHY])
{
    size_t i = 0;
    uc_err error;

    while (i < sizeof cpus / sizeof cpus[0] && cpus[i].target != image->target)
        i++;
    if (i == sizeof cpus / sizeof cpus[0])
        return machine_fail(why, -ENOEXEC, "no emulated CPU for %s", image->target_name);
    emulator->cpu = cpus[i].cpu;
    emulator->odd = emulator->cpu->arch == UC_ARCH_ARM ? 1 : 0;
    if (!code_stepper_open(&emulator->stepper, image->target))
        return machine_fail(why, -ENOMEM, "no disassembler for %s", image->target_name);
    error = uc_open(emulator->cpu->arch, emulator->cpu->mode, &emulator->uc);
    if (error == UC_ERR_OK && cpus[i].model >= 0)
        error = uc_ctl_set_cpu_model(emulator->uc, cpus[i].model);
    if (error == UC_ERR_OK) /* the first use makes everything that Unicorn has */
        error = uc_context_alloc(emulator->uc, &emulator->fresh);
    return error == UC_ERR_OK ? 0 : fail(why, "cannot be made", error);
}

static int instrumented_open(struct machine *machine, const struct image *image,
                             char why[MACHINE_WHY])
{
    const size_t span = machine->span_end - machine->span_begin;
    struct emulator *emulator = calloc(1, sizeof *emulator);
    int error;

    if (emulator == NULL)
        return machine_fail(why, -ENOMEM, "no memory for the emulator");
    machine->emulator = emulator;
    emulator->machine = machine;
    emulator->base = (uint64_t)machine->hull;
    emulator->kinds = calloc(span, 1);
    emulator->covered = calloc(span / 8, 1);
    emulator->rehearsed = malloc(machine->stack_size);
    if (emulator->kinds == NULL || emulator->covered == NULL || emulator->rehearsed == NULL)
        return machine_fail(why, -ENOMEM, "no memory for the emulator");
    error = open_cpu(emulator, image, why);
    if (error == 0)
        error = map_module(emulator, why);
    if (error == 0)
        error = map_services(emulator, why);
    if (error == 0)
        error = open_levels(emulator, why);
    if (error == 0)
        error = open_thread(emulator, why);
    if (error == 0)
        error = emulator_hooks(emulator, why);
    if (error != 0)
        return error;
    install_handlers(emulator);
    emulator->cpu->fresh(emulator);
    uc_context_save(emulator->uc, emulator->fresh);
    return 0;
}

static void instrumented_close(struct machine *machine)
{
    struct emulator *emulator = machine->emulator;

    if (emulator == NULL)
        return;
    remove_handlers(emulator);
    for (unsigned i = 0; i < MACHINE_LEVELS; i++)
        if (emulator->levels[i].interrupted != NULL)
            uc_context_free(emulator->levels[i].interrupted);
    if (emulator->fresh != NULL)
        uc_context_free(emulator->fresh);
    if (emulator->uc != NULL)
        uc_close(emulator->uc);
    code_stepper_close(&emulator->stepper);
    machine_release(&emulator->services);
    free(emulator->kinds);
    free(emulator->covered);
    free(emulator->rehearsed);
    free(emulator);
    machine->emulator = NULL;
}

static int instrumented_mapped(struct machine *machine, const struct machine_region *region,
                               uint8_t *pages, size_t size, enum machine_region_access access,
                               char why[MACHINE_WHY])
{
    struct emulator *emulator = machine->emulator;
    const uint32_t allowed =
        UC_PROT_READ | (access == MACHINE_REGION_READ_WRITE ? UC_PROT_WRITE : 0u);
    uc_err error = uc_mem_map_ptr(emulator->uc, (uint64_t)pages, size, allowed, pages);

    if (error != UC_ERR_OK)
        return fail(why, "takes no memory", error);
    emulator->memories[emulator->memory_count] = (struct emulator_memory){
        .begin = (uint64_t)pages,
        .end = (uint64_t)pages + size,
        .start = region->start,
        .writable = access == MACHINE_REGION_READ_WRITE,
        .number = emulator->memory_count,
    };
    emulator->memory_count++;
    return 0;
}

static int instrumented_service(struct machine *machine, const char *name,
                                machine_function *function, void *context, void **pointer,
                                char why[MACHINE_WHY])
{
    const struct emulator *emulator = machine->emulator;

    if (machine->service_count == MACHINE_SERVICES)
        return machine_fail(why, -ENOSPC, "%s: more than %d services", name, MACHINE_SERVICES);
    machine->services[machine->service_count++] =
        (struct machine_served){ name, function, context };
    *pointer = (void *)(emulator->trap + (uint64_t)machine->service_count * emulator->cpu->slot);
    return 0;
}

static bool instrumented_busy(const struct machine *machine)
{
    return machine->emulator->depth > 0 || machine->levels_left < machine->level_count;
}

/* Where code may be written, other code may be there again. */
static void instrumented_reloaded(struct machine *machine)
{
    struct emulator *emulator = machine->emulator;
    const uint64_t span = machine->span_end - machine->span_begin;

    if (!emulator->shared)
        return;
    uc_ctl_remove_cache(emulator->uc, emulator->base, emulator->base + span);
    memset(emulator->kinds, 0, span);
}

static void instrumented_interrupt_next(struct machine *machine, uint64_t after,
                                        machine_interrupt *hook, void *argument)
{
    struct emulator *emulator = machine->emulator;
    struct emulator_level *level;

    if (!machine->config.interruptible || emulator->depth + 1 >= machine->levels_left)
        return;
    level = emulator_level_at(emulator, emulator->depth);
    level->after = after;
    level->hook = hook;
    level->argument = argument;
}

static uint64_t instrumented_instructions(const struct machine *machine)
{
    return emulator_level_at(machine->emulator, machine->emulator->depth)->executed;
}

static int instrumented_alarm_open(struct machine *machine, char why[MACHINE_WHY])
{
    (void)machine;
    return machine_fail(why, -ENOTSUP, "an instrumented machine knows no time of day");
}

static void instrumented_alarm_at(struct machine *machine, uint64_t monotonic_ns)
{
    (void)machine;
    (void)monotonic_ns;
}

static size_t instrumented_stack_used(const struct machine *machine)
{
    return machine->emulator->deepest;
}

static const uint8_t *instrumented_coverage(const struct machine *machine)
{
    return machine->emulator->covered;
}

/* The calls of services are the machine's own and bracketed already. */
static void instrumented_service_enter(struct machine *machine, const char *service,
                                       void *return_address)
{
    (void)machine;
    (void)service;
    (void)return_address;
}

static void instrumented_service_leave(struct machine *machine)
{
    (void)machine;
}

const struct machine_ops machine_instrumented = {
    .open = instrumented_open,
    .close = instrumented_close,
    .mapped = instrumented_mapped,
    .service = instrumented_service,
    .busy = instrumented_busy,
    .call = emulator_call,
    .reloaded = instrumented_reloaded,
    .interrupt_next = instrumented_interrupt_next,
    .instructions = instrumented_instructions,
    .rehearse = emulator_rehearse,
    .set_aside = emulator_set_aside,
    .depth = emulator_depth,
    .go_on = emulator_go_on,
    .next_operands = emulator_next_operands,
    .alarm_open = instrumented_alarm_open,
    .alarm_at = instrumented_alarm_at,
    .stack_used = instrumented_stack_used,
    .coverage = instrumented_coverage,
    .service_enter = instrumented_service_enter,
    .service_leave = instrumented_service_leave,
};
