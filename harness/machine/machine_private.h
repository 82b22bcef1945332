/* SPDX-License-Identifier: GPL-2.0-or-later */
/* machine_private.h - shared by the files of machine/, nobody else's business. */
#ifndef HARNESS_MACHINE_PRIVATE_H
#define HARNESS_MACHINE_PRIVATE_H

#if !defined(__x86_64__) || !defined(__linux__) || defined(__ILP32__)
#error "machine/ runs x86-64 modules natively on Linux; this target is another one"
#endif

#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <time.h>
#include <ucontext.h>

#if defined(__SANITIZE_ADDRESS__)
#define ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define ADDRESS_SANITIZER 1
#endif
#endif

#include "machine/machine.h"
#include "machine/trampoline.h"

#define PAGE            4096u
#define PLACE_ALIGN     65536u         /* places are multiples of this */
#define HULL_GUARD      (16ull << 20)  /* on both sides of the module, and below its stack */
#define REGION_GUARD    (1ull << 20)   /* on both sides of a region */
#define HULL_LIMIT      (512ull << 20) /* largest module span that is mapped */
#define REGION_LIMIT    (1ull << 30)   /* largest region that is mapped */
#define STACK_LIMIT     (256ull << 20)
#define MAX_REGIONS     64   /* "module" and "stack" included */
#define SLACK_BYTE      0xcd /* fills what belongs to a region's page, not to it */
#define MACHINE_SIGNALS 8
#define MACHINE_ALARM   SIGVTALRM /* interrupts, see interrupt.c */
#define HANG_TICKS      4         /* watchdog periods in hang_ns */
#define DEFAULT_STACK   (256u << 10)
#define DEFAULT_HANG_NS 1000000000ull

/* Address space reserved without access. */
struct machine_reservation {
    uint8_t *base;
    size_t size;
};

/* A named range; the reservation around it is what counts as near. */
struct machine_region {
    char name[MACHINE_REGION_NAME];
    uint64_t start, size;
    struct machine_reservation around;
    struct machine_reservation host; /* second mapping of a read-only region, size 0: none */
};

/* What of the process was there before us. */
struct machine_borrowed {
    struct sigaction actions[MACHINE_SIGNALS];
    stack_t alternate;
    bool installed;
};

/* One of the calls that stand inside one another, and what is to interrupt it. */
struct machine_level {
    uint8_t *stack; /* lowest byte */
    machine_interrupt *hook;
    void *argument;
    uint64_t after;    /* instructions until the interrupt */
    uint64_t executed; /* instructions so far, while stepping */
    bool stepping;     /* the trap flag is ours */
    bool stepped;      /* it was, at some time of this call */
    bool inside;       /* the latest trap was before an instruction of the module */
    bool pending;      /* the alarm came where nothing can be interrupted */
    /* The interrupted context. */
    greg_t registers[NGREG];
    uint8_t *extended;
    size_t extended_size;
    /* Set aside. */
    const char *service;
    void *service_return;
    uint64_t stack_pointer; /* natively */
    uint64_t begun_ns;
};

/* A function of the host that the module may call. */
struct machine_served {
    const char *name;
    machine_function *function;
    void *context;
};

/*
 * What the two machines do in ways of their own; machine.c does the rest for both. Called with the
 * module mapped, relocated and copied, in the order open, mapped..., sealing, calls, close.
 */
struct machine_ops {
    int (*open)(struct machine *machine, const struct image *image, char why[MACHINE_WHY]);
    void (*close)(struct machine *machine); /* also after an open that failed half way */
    /* A region was added; pages is what module code may reach of it. */
    int (*mapped)(struct machine *machine, const struct machine_region *region, uint8_t *pages,
                  size_t size, enum machine_region_access access, char why[MACHINE_WHY]);
    /* NULL: no services are made */
    int (*service)(struct machine *machine, const char *name, machine_function *function,
                   void *context, void **pointer, char why[MACHINE_WHY]);
    int (*sealing)(struct machine *machine, char why[MACHINE_WHY]);
    bool (*busy)(const struct machine *machine); /* a call is under way */
    void (*call)(struct machine *machine, uint64_t function, void *argument,
                 struct machine_outcome *outcome);
    void (*reloaded)(struct machine *machine);
    void (*interrupt_next)(struct machine *machine, uint64_t after, machine_interrupt *hook,
                           void *argument);
    uint64_t (*instructions)(const struct machine *machine);
    void (*rehearse)(struct machine *machine, struct machine_outcome *outcome);
    bool (*set_aside)(const struct machine *machine); /* whether the running call can be */
    void (*step_aside)(struct machine *machine);      /* NULL: the machine sees to it itself */
    unsigned (*depth)(const struct machine *machine); /* of the next call */
    void (*go_on)(struct machine *machine, struct machine_outcome *outcome);
    unsigned (*next_operands)(struct machine *machine, struct code_operand operands[CODE_OPERANDS]);
    int (*alarm_open)(struct machine *machine, char why[MACHINE_WHY]);
    void (*alarm_at)(struct machine *machine, uint64_t monotonic_ns);
    size_t (*stack_used)(const struct machine *machine);
    const uint8_t *(*coverage)(const struct machine *machine);
    void (*service_enter)(struct machine *machine, const char *service, void *return_address);
    void (*service_leave)(struct machine *machine);
};
extern const struct machine_ops machine_native, machine_instrumented;

struct machine {
    const struct machine_ops *ops;
    struct machine_config config;
    enum arguments_convention convention; /* of the module's functions */
    pid_t process;
    bool sealed;
    bool timing;

    uint8_t *hull; /* where span_begin runs */
    uint64_t span_begin, span_end;
    uint8_t *page_access;      /* PROT_* of each page of the hull */
    struct emulator *emulator; /* of an instrumented machine */
    unsigned pointer_size;
    bool low; /* everything that the module sees lies below 2 GiB */

    uint8_t *stack; /* lowest byte of the running level's */
    size_t stack_size;
    uint64_t stack_pattern;
    size_t stack_deepest; /* before the latest machine_reload() */

    struct machine_served services[MACHINE_SERVICES];
    unsigned service_count;
    const void *caller; /* where the latest service returns to */
    uint64_t served;    /* services entered so far */

    struct code_decoder *decoder; /* of machine_next_operands(), NULL: not open yet */

    unsigned level; /* how many calls are interrupted */
    unsigned level_count;
    struct machine_level levels[MACHINE_LEVELS];
    unsigned order[MACHINE_LEVELS]; /* which of them is used at what depth; behind levels_left are
                                       those of calls that are set aside */
    unsigned levels_left;
    bool aside;      /* the service that runs has set the call aside */
    bool rehearsing; /* the call that runs is put back afterwards */
    size_t extended_room;
    uint8_t *rehearsed; /* room for the stack of a call that is rehearsed */
    bool resuming;      /* machine_resume is about to trap */
    timer_t alarm;
    bool has_alarm;

    struct machine_reservation copy; /* of the writable pages, one after the other */

    struct machine_region regions[MAX_REGIONS];
    unsigned region_count;

    struct thread_block *thread_block; /* of a PE module, the host's view of it; NULL: none */
    uint64_t borrowed_gs;              /* base of gs before */

    struct machine_reservation signal_stack;
    timer_t timer;
    bool has_timer;
    uint64_t watched; /* call that the last tick saw */
    unsigned ticks;   /* how many more ticks saw it */
    struct machine_borrowed borrowed;
};

/*
 * The call in progress. One in the process, at a fixed place, because the trampoline must find it
 * when the module has destroyed every register. trampoline.S knows the layout.
 */
struct machine_state {
    uint64_t host_rsp;    /* callee-saved registers of machine_enter()'s caller lie there */
    uint64_t stack_top;   /* module's stack pointer before the call */
    uint64_t serial;      /* number of the call */
    uint64_t sentinel[6]; /* rbx, rbp, r12-r15 on entry */
    /* After a return that broke the convention; each zero when nothing is wrong with it. */
    uint64_t seen[6]; /* register xor sentinel */
    uint64_t seen_stack;
    uint64_t seen_flags;
    uint64_t seen_mxcsr;
    uint64_t seen_x87;
    uint64_t seen_fs;
    uint64_t seen_x87tag;
    uint64_t host_fs; /* fs base of this thread */
    uint32_t host_mxcsr, module_mxcsr;
    uint16_t host_x87, module_x87;
    uint32_t active; /* module code may be running */
    uint32_t has_fsgsbase;
    uint64_t enter_flags; /* rflags of the first instruction when the call is stepped, else 0 */
    /* The Windows convention, where there is a thread block. */
    uint64_t thread_block;        /* base of gs; 0: the convention is that of ELF */
    uint64_t windows_sentinel[2]; /* rdi, rsi on entry */
    uint64_t windows_xmm[10][2];  /* xmm6-xmm15 on entry */
    uint64_t windows_seen;        /* the next five together */
    uint64_t seen_di, seen_si, seen_xmm, seen_gs, seen_windows_x87;
    uint16_t windows_x87; /* x87 control word on entry */
};

#define STATE_AT(field, offset)                                                                    \
    _Static_assert(offsetof(struct machine_state, field) == (offset), #field)
STATE_AT(host_rsp, STATE_HOST_RSP);
STATE_AT(stack_top, STATE_STACK_TOP);
STATE_AT(serial, STATE_SERIAL);
STATE_AT(sentinel, STATE_SENTINEL);
STATE_AT(seen, STATE_SEEN);
STATE_AT(seen_stack, STATE_SEEN_STACK);
STATE_AT(seen_flags, STATE_SEEN_FLAGS);
STATE_AT(seen_mxcsr, STATE_SEEN_MXCSR);
STATE_AT(seen_x87, STATE_SEEN_X87);
STATE_AT(seen_fs, STATE_SEEN_FS);
STATE_AT(seen_x87tag, STATE_SEEN_X87TAG);
STATE_AT(host_fs, STATE_HOST_FS);
STATE_AT(host_mxcsr, STATE_HOST_MXCSR);
STATE_AT(module_mxcsr, STATE_MODULE_MXCSR);
STATE_AT(host_x87, STATE_HOST_X87);
STATE_AT(module_x87, STATE_MODULE_X87);
STATE_AT(active, STATE_ACTIVE);
STATE_AT(has_fsgsbase, STATE_HAS_FSGSBASE);
STATE_AT(enter_flags, STATE_ENTER_FLAGS);
STATE_AT(thread_block, STATE_THREAD_BLOCK);
STATE_AT(windows_sentinel, STATE_WINDOWS_SENTINEL);
STATE_AT(windows_xmm, STATE_WINDOWS_XMM);
STATE_AT(windows_seen, STATE_WINDOWS_SEEN);
STATE_AT(seen_di, STATE_SEEN_DI);
STATE_AT(seen_si, STATE_SEEN_SI);
STATE_AT(seen_xmm, STATE_SEEN_XMM);
STATE_AT(seen_gs, STATE_SEEN_GS);
STATE_AT(seen_windows_x87, STATE_SEEN_WINDOWS_X87);
STATE_AT(windows_x87, STATE_WINDOWS_X87);

extern volatile struct machine_state machine_state __attribute__((visibility("hidden")));

/* What the signal handler leaves for machine_call(), and the service that is running. */
struct machine_incident {
    struct machine *machine; /* the loaded one, NULL when there is none */
    enum machine_outcome_kind kind;
    struct machine_fault fault;
    const char *volatile service;
    void *volatile service_return;
    volatile unsigned service_depth;
    volatile bool hung; /* declared hung while in a service, which is to leave by itself */
};
extern struct machine_incident machine_incident __attribute__((visibility("hidden")));

/* trampoline.S */
struct machine_left {
    int64_t value;
    uint64_t how; /* LEFT_... */
};
struct machine_left machine_enter(void *function, void *argument);
void machine_abandon(void) __attribute__((noreturn));
void machine_signal_entry(int sig, siginfo_t *info, void *context);
void machine_resume(void) __attribute__((noreturn));
void machine_step_aside(uint64_t *stack_pointer);
struct machine_left machine_enter_aside(uint64_t stack_pointer);
struct machine_left machine_enter_again(void);
extern const uint8_t machine_trampoline_begin[], machine_trampoline_end[], machine_returned[];

/* Reads a word of the module's stack: not aligned perhaps, and in frames of host functions that the
 * address sanitizer has fenced. */
static inline uint64_t machine_peek(uint64_t address)
{
    uint64_t word;

    __asm__("mov (%1), %0" : "=r"(word) : "r"(address) : "memory");
    return word;
}

/* Base of fs: the thread control block, which points to itself. */
static inline uint64_t machine_thread_base(void)
{
    uint64_t base;

    __asm__("mov %%fs:0, %0" : "=r"(base));
    return base;
}

/* Where a call's stack pointer begins. */
static inline uint64_t machine_stack_top(const struct machine *machine, const uint8_t *stack)
{
    return (uint64_t)stack + machine->stack_size - 64;
}

/* call.c: what became of a native call that the processor is back from */
void machine_came_back(struct machine *machine, struct machine_left left,
                       struct machine_outcome *outcome);
uint64_t machine_now_ns(void);
/* Services that were cut short left red zones of their frames in the shadow of a stack. */
void machine_forget_frames(const struct machine *machine, const uint8_t *stack);
/* what became of a call that did not return in good order */
void machine_irregular(const struct machine *machine, uint64_t how,
                       struct machine_outcome *outcome);
/* native.c: what callee-saved register i holds on entry */
uint64_t machine_sentinel(const struct machine *machine, unsigned i);

/* aside.c */
struct machine_level *machine_level_at(struct machine *machine, unsigned depth);
/* The level at that depth, whose call is the running one, is set aside; which one it is. */
unsigned machine_level_aside(struct machine *machine, unsigned depth);
bool machine_native_set_aside(const struct machine *machine);
void machine_native_step_aside(struct machine *machine);
unsigned machine_native_depth(const struct machine *machine);
void machine_native_go_on(struct machine *machine, struct machine_outcome *outcome);

/* regions.c */
uint64_t machine_mix(uint64_t seed, uint64_t a, uint64_t b);
/* The seed of places. */
uint64_t machine_place_seed(const struct machine *machine);
/* Anywhere, as seed and ordinal determine; low: below 2 GiB. */
int machine_reserve(struct machine_reservation *out, uint64_t seed, unsigned ordinal, bool low,
                    size_t size);
/* There and nowhere else. */
int machine_reserve_at(struct machine_reservation *out, uint64_t address, size_t size);
void machine_release(struct machine_reservation *reservation);
struct machine_region *machine_region_add(struct machine *machine, const char *name);
/* The row that machine_region_add() returned is in force: counted, and the machine knows it. */
int machine_region_done(struct machine *machine, uint8_t *pages, size_t size,
                        enum machine_region_access access, char why[MACHINE_WHY]);
int machine_map_stacks(struct machine *machine, char why[MACHINE_WHY]);
void machine_fill_stacks(struct machine *machine);
size_t machine_stack_deepest(const struct machine *machine);
void machine_regions_release(struct machine *machine);
void machine_describe_address(const struct machine *machine, struct machine_fault *fault);

/* thread_block.c: what a PE module finds through gs; nothing of it for other modules */
int machine_thread_block_open(struct machine *machine, char why[MACHINE_WHY]);
void machine_thread_block_close(struct machine *machine);
/* The stack bounds are those of the level that runs. */
void machine_thread_block_update(const struct machine *machine);
/* gs as it was before module code ran. */
void machine_thread_block_restore(void);

/* serve.c */
int machine_native_service(struct machine *machine, const char *name, machine_function *function,
                           void *context, void **pointer, char why[MACHINE_WHY]);
/* What every machine does when module code has called service `number`. */
int64_t machine_service_call(struct machine *machine, unsigned number, struct arguments *arguments,
                             void *return_address);

/* poison.c */
void machine_poison(const struct image *image, uint8_t *hull, enum machine_poison poison,
                    uint64_t seed);

/* reload.c */
int machine_copy_keep(struct machine *machine, char why[MACHINE_WHY]);

/* load.c */
int machine_map_image(struct machine *machine, const struct image *image, char why[MACHINE_WHY]);

/* call.c */
void machine_native_call(struct machine *machine, uint64_t function, void *argument,
                         struct machine_outcome *outcome);
void machine_native_service_enter(struct machine *machine, const char *service,
                                  void *return_address);
void machine_native_service_leave(struct machine *machine);

/* interrupt.c */
void machine_native_interrupt_next(struct machine *machine, uint64_t after, machine_interrupt *hook,
                                   void *argument);
uint64_t machine_native_instructions(const struct machine *machine);
int machine_native_alarm_open(struct machine *machine, char why[MACHINE_WHY]);
void machine_native_alarm_at(struct machine *machine, uint64_t monotonic_ns);
int machine_levels_open(struct machine *machine, char why[MACHINE_WHY]);
void machine_levels_close(struct machine *machine);
/* The kernel's number of the alarm, -1 when there is none. */
int machine_alarm_number(const struct machine *machine);
void machine_level_set(struct machine *machine, unsigned level);
void machine_level_begin(struct machine *machine);
void machine_level_end(struct machine *machine);
/* Host services are not stepped: off on the way in, on again, if wanted, on the way out. */
void machine_service_steps(struct machine *machine, bool on);
/* rehearse.c */
void machine_native_rehearse(struct machine *machine, struct machine_outcome *outcome);
unsigned machine_native_next_operands(struct machine *machine,
                                      struct code_operand operands[CODE_OPERANDS]);
/* In the signal handler. True when the signal was about interrupts and has been dealt with. */
bool machine_interrupt_signal(struct machine *machine, int sig, ucontext_t *context);

/* fault.c */
void machine_redirect(ucontext_t *context, uint64_t ip, uint64_t sp);
int machine_handlers_install(struct machine *machine, char why[MACHINE_WHY]);
void machine_handlers_remove(struct machine *machine);
/* In a signal handler: ends the process by this signal, saying why. */
void machine_die(int sig, const siginfo_t *info, ucontext_t *context);
void machine_on_signal(int sig, siginfo_t *info, void *context)
    __attribute__((visibility("hidden")));

/* attribute.c: from a raw instruction pointer to a place in the module */
bool machine_executes(const struct machine *machine, uint64_t address, size_t size);
void machine_attribute(const struct machine *machine, uint64_t ip, uint64_t sp,
                       struct machine_fault *fault);

/* watchdog.c */
int machine_watchdog_start(struct machine *machine, char why[MACHINE_WHY]);
void machine_watchdog_stop(struct machine *machine);
bool machine_watchdog_tick(struct machine *machine, uint64_t ip);

/* machine.c: prints into why and returns error, for `return machine_fail(...)` */
int machine_fail(char why[MACHINE_WHY], int error, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
