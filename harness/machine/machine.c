/* SPDX-License-Identifier: GPL-2.0-or-later */
/* machine.c - what is the same for every kind of machine, and the way to what is not. */
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include "machine/machine_private.h"

#define HANG_NS_AN_INSTRUCTION 50

int machine_fail(char why[MACHINE_WHY], int error, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(why, MACHINE_WHY, format, arguments);
    va_end(arguments);
    return error;
}

/* What runs where. */
static const struct {
    enum image_format format;
    enum image_target target;
    const char *name; /* for people */
    unsigned pointer_size;
    bool native;
} targets[] = {
    { IMAGE_FORMAT_ELF64, IMAGE_TARGET_X86_64, "ELF64 modules for x86-64", 8, true },
    { IMAGE_FORMAT_PE, IMAGE_TARGET_X86_64, "PE modules for x86-64", 8, true },
    { IMAGE_FORMAT_PE, IMAGE_TARGET_I386, "PE modules for i386", 4, false },
    { IMAGE_FORMAT_ELF32, IMAGE_TARGET_ARM, "ELF32 modules for Arm", 4, false },
    { IMAGE_FORMAT_FLAT, IMAGE_TARGET_ARM, "flat images for Arm", 4, false },
};

#define TARGETS (sizeof targets / sizeof targets[0])

static size_t target_of(const struct image *image)
{
    size_t i = 0;

    while (i < TARGETS &&
           (image->format != targets[i].format || image->target != targets[i].target))
        i++;
    return i;
}

int machine_fits(const struct image *image, enum machine_kind kind, char why[MACHINE_WHY])
{
    const size_t target = target_of(image);

    if (image->defect[0] != '\0')
        return machine_fail(why, -ENOEXEC, "%s", image->defect);
    if (kind != MACHINE_NATIVE && kind != MACHINE_INSTRUMENTED)
        return machine_fail(why, -ENOEXEC, "there is no such machine");
    if (target == TARGETS || (kind == MACHINE_NATIVE && !targets[target].native))
        return machine_fail(why, -ENOEXEC,
                            kind == MACHINE_NATIVE
                                ? "only ELF64 and PE modules for x86-64 run natively, this is %s %s"
                                : "no emulated CPU for a module that is %s %s",
                            image->format_name, image->target_name);
    return 0;
}

static int check_span(const struct image *image, char why[MACHINE_WHY])
{
    uint64_t span = image->span_end - image->span_begin;

    if (image->span_begin >= image->span_end || (image->span_begin | image->span_end) % PAGE != 0)
        return machine_fail(why, -ENOEXEC, "nothing to map");
    if (span > HULL_LIMIT)
        return machine_fail(why, -EFBIG,
                            "the segments span %llu bytes of memory, at most %llu are mapped",
                            (unsigned long long)span, (unsigned long long)HULL_LIMIT);
    return 0;
}

static const struct machine_ops *const kinds[] = {
    [MACHINE_NATIVE] = &machine_native,
    [MACHINE_INSTRUMENTED] = &machine_instrumented,
};

/* Of whichever kind: the signal handlers are one's. */
static const struct machine *loaded;

static void settle_config(struct machine *machine, const struct machine_config *given)
{
    struct machine_config *config = &machine->config;

    *config = *given;
    if (config->stack_size == 0)
        config->stack_size = DEFAULT_STACK;
    if (config->hang_ns == 0)
        config->hang_ns = DEFAULT_HANG_NS;
    if (config->hang_instructions == 0)
        config->hang_instructions = config->hang_ns / HANG_NS_AN_INSTRUCTION;
}

int machine_load(struct machine **out, const struct image *image,
                 const struct machine_config *config, char why[MACHINE_WHY])
{
    struct machine *machine;
    int error;

    *out = NULL;
    why[0] = '\0';
    error = machine_fits(image, config->kind, why);
    if (error == 0)
        error = check_span(image, why);
    if (error == 0 && loaded != NULL)
        error = machine_fail(why, -EBUSY, "this process has loaded a module already");
    if (error != 0)
        return error;
    machine = calloc(1, sizeof *machine);
    if (machine == NULL)
        return machine_fail(why, -ENOMEM, "no memory");
    loaded = machine;
    machine->ops = kinds[config->kind];
    machine->convention = arguments_convention_of(image);
    machine->pointer_size = targets[target_of(image)].pointer_size;
    machine->low = machine->pointer_size == 4;
    settle_config(machine, config);

    error = machine_map_image(machine, image, why);
    if (error == 0)
        error = machine_map_stacks(machine, why);
    if (error == 0)
        error = machine_copy_keep(machine, why);
    if (error == 0)
        error = machine->ops->open(machine, image, why);
    if (error != 0) {
        machine_unload(machine);
        return error;
    }
    *out = machine;
    return 0;
}

void machine_unload(struct machine *machine)
{
    if (machine == NULL)
        return;
    machine->ops->close(machine);
    machine_regions_release(machine);
    machine_release(&machine->copy);
    free(machine->page_access);
    free(machine);
    loaded = NULL;
}

unsigned machine_pointer_size(const struct machine *machine)
{
    return machine->pointer_size;
}

void machine_timing(struct machine *machine, bool on)
{
    machine->timing = on;
}

void machine_call(struct machine *machine, uint64_t function, void *argument,
                  struct machine_outcome *outcome)
{
    machine->ops->call(machine, function, argument, outcome);
}

int machine_service(struct machine *machine, const char *name, machine_function *function,
                    void *context, void **pointer, char why[MACHINE_WHY])
{
    if (machine->sealed)
        return machine_fail(why, -EPERM, "%s: too late, the machine is sealed", name);
    if (machine->ops->service == NULL)
        return machine_fail(why, -ENOTSUP, "%s: this machine makes no services", name);
    return machine->ops->service(machine, name, function, context, pointer, why);
}

void machine_interrupt_next(struct machine *machine, uint64_t after, machine_interrupt *hook,
                            void *argument)
{
    machine->ops->interrupt_next(machine, after, hook, argument);
}

uint64_t machine_instructions(const struct machine *machine)
{
    return machine->ops->instructions(machine);
}

bool machine_rehearses(const struct machine *machine)
{
    return machine->ops->rehearse != NULL && machine->config.interruptible;
}

void machine_rehearse(struct machine *machine, struct machine_outcome *outcome)
{
    machine->ops->rehearse(machine, outcome);
}

unsigned machine_next_operands(struct machine *machine, struct code_operand operands[CODE_OPERANDS])
{
    return machine->ops->next_operands(machine, operands);
}

uint64_t machine_services(const struct machine *machine)
{
    return machine->served;
}

bool machine_own_data(const struct machine *machine, unsigned index, void **at, size_t *size)
{
    size_t count = (machine->span_end - machine->span_begin) / PAGE;

    for (size_t page = 0; page < count; page++) {
        size_t end = page;

        while (end < count && (machine->page_access[end] & PROT_WRITE))
            end++;
        if (end == page || index-- > 0) {
            page = end;
            continue;
        }
        *at = machine->hull + page * PAGE;
        *size = (end - page) * PAGE;
        return true;
    }
    return false;
}

int machine_alarm_open(struct machine *machine, char why[MACHINE_WHY])
{
    return machine->ops->alarm_open(machine, why);
}

void machine_alarm_at(struct machine *machine, uint64_t monotonic_ns)
{
    machine->ops->alarm_at(machine, monotonic_ns);
}

size_t machine_stack_used(const struct machine *machine)
{
    return machine->ops->stack_used(machine);
}

const uint8_t *machine_coverage(const struct machine *machine, uint64_t *begin, uint64_t *end)
{
    *begin = machine->span_begin;
    *end = machine->span_end;
    return machine->ops->coverage != NULL ? machine->ops->coverage(machine) : NULL;
}

void machine_service_enter(struct machine *machine, const char *service, void *return_address)
{
    machine->ops->service_enter(machine, service, return_address);
}

void machine_service_leave(struct machine *machine)
{
    machine->ops->service_leave(machine);
}
