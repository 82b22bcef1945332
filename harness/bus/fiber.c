/* SPDX-License-Identifier: GPL-2.0-or-later */
#define _GNU_SOURCE 1
#include "bus/fiber.h"

#include <errno.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#if defined(__SANITIZE_ADDRESS__)
#define FIBER_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define FIBER_SANITIZED 1
#endif
#endif

#ifdef FIBER_SANITIZED
#include <sanitizer/asan_interface.h>
#include <sanitizer/common_interface_defs.h>
#endif

enum { GUARD = 4096 };

struct fiber {
    void *stack;       /* lowest address of the mapping: a guard page, then the stack */
    void *own, *other; /* stack pointers of the side that is not running */
    void (*entry)(void *);
    void *argument;
    bool inside;
    /* What the address sanitizer has to know of the stack that is left. */
    void *fake_own, *fake_other;
    const void *other_bottom;
    size_t other_size;
};

/* What fiber_switch() leaves on a stack. */
struct frame {
    uint32_t mxcsr;
    uint16_t control, unused;
    uint64_t r15, r14, r13, r12, rbx, rbp;
    uint64_t return_address;
};

extern void fiber_switch(void **leave, void *enter);
extern void fiber_begin(void);

#ifdef FIBER_SANITIZED
static void leave_for(struct fiber *fiber, bool into)
{
    if (into)
        __sanitizer_start_switch_fiber(&fiber->fake_other, (char *)fiber->stack + GUARD,
                                       FIBER_STACK);
    else
        __sanitizer_start_switch_fiber(&fiber->fake_own, fiber->other_bottom, fiber->other_size);
}

static void arrived(struct fiber *fiber, bool inside)
{
    if (inside)
        __sanitizer_finish_switch_fiber(fiber->fake_own, &fiber->other_bottom, &fiber->other_size);
    else
        __sanitizer_finish_switch_fiber(fiber->fake_other, NULL, NULL);
}
#else
static void leave_for(struct fiber *fiber, bool into)
{
    (void)fiber, (void)into;
}

static void arrived(struct fiber *fiber, bool inside)
{
    (void)fiber, (void)inside;
}
#endif

static void start(void *argument)
{
    struct fiber *fiber = argument;

    arrived(fiber, true);
    fiber->entry(fiber->argument);
    abort();
}

/* What the first switch to the fiber finds. */
static void prepare(struct fiber *fiber)
{
    struct frame *frame;
    uint32_t mxcsr;
    uint16_t control;

    __asm__("stmxcsr %0" : "=m"(mxcsr));
    __asm__("fnstcw %0" : "=m"(control));
    /* fiber_begin() calls: the stack must be aligned to 16 when it has popped the whole frame. */
    frame = (struct frame *)((char *)fiber->stack + GUARD + FIBER_STACK - 16 - sizeof *frame);
    *frame = (struct frame){ .mxcsr = mxcsr,
                             .control = control,
                             .r12 = (uint64_t)start,
                             .r13 = (uint64_t)fiber,
                             .return_address = (uint64_t)fiber_begin };
    fiber->own = frame;
}

int fiber_open(struct fiber **out, void (*entry)(void *argument), void *argument)
{
    struct fiber *fiber = calloc(1, sizeof *fiber);

    *out = NULL;
    if (!fiber)
        return -ENOMEM;
    fiber->stack = mmap(NULL, GUARD + FIBER_STACK, PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS | MAP_STACK, -1, 0);
    if (fiber->stack == MAP_FAILED || mprotect(fiber->stack, GUARD, PROT_NONE) != 0) {
        if (fiber->stack != MAP_FAILED)
            munmap(fiber->stack, GUARD + FIBER_STACK);
        free(fiber);
        return -ENOMEM;
    }
    fiber->entry = entry;
    fiber->argument = argument;
    prepare(fiber);
    *out = fiber;
    return 0;
}

void fiber_restart(struct fiber *fiber)
{
#ifdef FIBER_SANITIZED
    __asan_unpoison_memory_region((char *)fiber->stack + GUARD, FIBER_STACK);
    fiber->fake_own = NULL;
#endif
    prepare(fiber);
}

void fiber_close(struct fiber *fiber)
{
    if (!fiber)
        return;
    munmap(fiber->stack, GUARD + FIBER_STACK);
    free(fiber);
}

void fiber_resume(struct fiber *fiber)
{
    fiber->inside = true;
    leave_for(fiber, true);
    fiber_switch(&fiber->other, fiber->own);
    arrived(fiber, false);
    fiber->inside = false;
}

void fiber_yield(struct fiber *fiber)
{
    leave_for(fiber, false);
    fiber_switch(&fiber->own, fiber->other);
    arrived(fiber, true);
}

bool fiber_inside(const struct fiber *fiber)
{
    return fiber->inside;
}
