/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * machine.h - where module code executes.
 *
 * A machine holds one loaded module: its segments mapped at a random place between guard pages,
 * relocated relatively, nothing else done to it. Calls into it return an outcome and never take
 * the caller down: faults, system calls and endless loops are caught and attributed.
 *
 * A machine is used by one thread of one process. Only one may be active in a process at a time
 * (it owns the signal handlers). It runs hostile code in the caller's address space, so the caller
 * is a worker process (worker.h) that can be thrown away.
 *
 * Nothing here allocates after machine_load()/machine_map(); machine_call() is fit for cyclic use.
 *
 * machine_load() to machine_unload() must happen in the same process and thread, the one that makes
 * the calls: load in the worker, not before the fork. No service may make a call of its own; calls
 * nest only where one interrupts another (machine_interrupt_next). From load to unload of a native
 * machine a watchdog's SIGALRM arrives four times per hang_ns of the thread's processor time:
 * sleeping system calls of the host may end early with EINTR then. The emulator of an instrumented
 * one does allocate when it meets code for the first time.
 *
 * What the module sees on entry is the same on every run with the same seed: addresses, poison, the
 * untouched part of its stack, and every general register and xmm register except its argument.
 * Not so, natively, the addresses of the host's functions, and what host services leave behind on
 * its stack.
 */
#ifndef HARNESS_MACHINE_H
#define HARNESS_MACHINE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "image/code_operands.h"
#include "image/image.h"
#include "machine/arguments.h"
#include "machine/thunks.h"
#include "machine/trace.h"

#define MACHINE_WHY         512
#define MACHINE_LEVELS      4 /* calls that may stand inside one another, each with its own stack */
#define MACHINE_NEVER       UINT64_MAX
#define MACHINE_ABANDON     (UINT64_MAX - 1)
#define MACHINE_REGION_NAME 32

struct machine;

/* What writable data holds before the first call: TG Motion does not initialise globals. Words that
 * a relocation patches and the RELRO range keep their values in any case. */
enum machine_poison {
    MACHINE_POISON_NONE,     /* the initial values of the file, zeros where it has none */
    MACHINE_POISON_SEEDED,   /* a pattern that is a function of the seed */
    MACHINE_POISON_INVERTED, /* the same with every bit turned over */
    MACHINE_POISON_ZERO      /* all zeros, initial values as well */
};

/*
 * Two machines, the same in everything that a caller sees but where it says "instrumented".
 *
 * Native: the processor runs the module in this process. x86-64 only.
 *
 * Instrumented: an emulated CPU runs it, of whatever target the image is for. Addresses are the
 * host's: what machine_map() returns can be handed to the module as it is; memory of 32-bit targets
 * lies below 2 GiB. Time is instructions: nothing that a call does depends on the clock, but for
 * instructions that read it (rdtsc). It does less than a processor in these, and never more:
 *   - no AVX and other late extensions (MACHINE_UNSUPPORTED, before anything is computed wrongly);
 *   - x86: the alignment check flag and the alignment of movaps are not looked at, far calls, jumps
 *     and returns fault, fsin and its like are computed with doubles;
 *   - Thumb: no interrupt inside of the block that an IT begins.
 */
enum machine_kind { MACHINE_NATIVE, MACHINE_INSTRUMENTED };

/* Address space that a worker needs to make an instrumented machine, of which little is used. */
#define MACHINE_INSTRUMENTED_MEMORY (UINT64_C(3) << 30)

struct machine_config {
    enum machine_kind kind;
    uint64_t seed;   /* what the module sees on entry is a function of it and of the next two */
    uint64_t places; /* another number: module, stack and memories lie elsewhere, all else alike */
    enum machine_poison poison;
    size_t stack_size; /* bytes for module code, rounded up to pages; 0 = 256 KiB */
    uint64_t hang_ns;  /* a call longer than this is a hang; 0 = 1 s. The processor's time, so
                          that what waits in a service does not count: found when it has taken
                          between 1 and 1.25 of this; at least 1 ms. */
    uint64_t hang_instructions; /* instrumented, instead of hang_ns: a call that has executed so
                                   many is a hang; 0 = hang_ns / 50 */
    const struct machine_trace *trace; /* instrumented; NULL: nothing is traced, which is faster */
    bool interruptible; /* calls may be interrupted; costs MACHINE_LEVELS - 1 stacks more, and
                           nothing in calls that are not */
    bool asides;        /* calls may be set aside; costs the same stacks */
};

enum machine_region_access { MACHINE_REGION_READ, MACHINE_REGION_READ_WRITE };

enum machine_outcome_kind {
    MACHINE_RETURNED,
    MACHINE_FAULT,       /* processor exception: see fault */
    MACHINE_SYSCALL,     /* module code issued a system call; it was not carried out */
    MACHINE_HANG,        /* did not return in hang_ns */
    MACHINE_UNSUPPORTED, /* instrumented: the emulated CPU lacks an instruction that a real one of
                            the target may have (fault.pc); says nothing about the module */
    MACHINE_ASIDE        /* a service has set the call aside; it is not over */
};

/* Parts of the calling convention that a module can break and still return. Everything is put right
 * again before machine_call() returns. The names are those of x86-64; other targets use the same
 * bits:
 * i386: RBX, RBP, RSI, RDI for ebx, ebp, esi, edi
 * Arm:  RBX, RBP, R12, R13 for r4 to r7, R14 for r8 and r9, R15 for r10 and r11; XMM for d8 to d15;
 *       MXCSR for rounding, flush to zero, default NaN and traps of the FPSCR
 */
enum machine_abi {
    MACHINE_ABI_RBX = 1 << 0, /* callee-saved registers */
    MACHINE_ABI_RBP = 1 << 1,
    MACHINE_ABI_R12 = 1 << 2,
    MACHINE_ABI_R13 = 1 << 3,
    MACHINE_ABI_R14 = 1 << 4,
    MACHINE_ABI_R15 = 1 << 5,
    MACHINE_ABI_STACK = 1 << 6,        /* stack pointer not where it was */
    MACHINE_ABI_DIRECTION = 1 << 7,    /* direction flag left set */
    MACHINE_ABI_FLAGS = 1 << 8,        /* trap, nested-task or alignment-check flag left set */
    MACHINE_ABI_MXCSR = 1 << 9,        /* SSE rounding, exception masks, flush to zero */
    MACHINE_ABI_X87_CONTROL = 1 << 10, /* x87 rounding, precision, exception masks */
    MACHINE_ABI_X87_STACK = 1 << 11,   /* values left in the x87 registers, or MMX without emms;
                                          looked   at only when nothing else is broken */
    MACHINE_ABI_FS = 1 << 12,          /* base of fs: the host's thread pointer */
    /* Of the Windows convention, but for what is said of Arm above: */
    MACHINE_ABI_RDI = 1 << 13, /* callee-saved registers */
    MACHINE_ABI_RSI = 1 << 14,
    MACHINE_ABI_XMM = 1 << 15, /* one of xmm6 to xmm15 */
    MACHINE_ABI_GS = 1 << 16   /* base of gs: the thread block */
};
#define MACHINE_ABI_BITS 17

enum machine_access {
    MACHINE_ACCESS_NONE,
    MACHINE_ACCESS_READ,
    MACHINE_ACCESS_WRITE,
    MACHINE_ACCESS_EXECUTE
};

struct machine_fault {
    int signal; /* SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGSYS, SIGALRM (hang) */
    enum machine_access access; /* for SIGSEGV/SIGBUS */
    uint64_t address;           /* accessed address (SIGSEGV/SIGBUS), else 0 */
    bool in_module;             /* ip lay in the module; pc is the module address (unrelocated) */
    uint64_t pc; /* module address of the instruction; when ip lay outside (a call into
                    nothing, a host service), the module's return address, if found: that is the
                    instruction after the call, so look up the line of pc - 1 */
    bool has_pc;
    uint64_t ip;         /* raw instruction pointer */
    long syscall;        /* number, for MACHINE_SYSCALL */
    bool syscall_i386;   /* it is a number of the 32-bit table (int 0x80) */
    bool syscall_arm;    /* of Arm's (svc) */
    const char *service; /* host service that was running for the module, NULL when none */
    /* Nearest named region to address, "" when none is near (a null pointer). Besides those of
     * machine_map() there are "module" (begins at image.span_begin) and "stack". */
    char region[MACHINE_REGION_NAME];
    int64_t region_offset; /* address - start of that region (may be negative or past its end) */
    uint64_t region_size;
};

struct machine_outcome {
    enum machine_outcome_kind kind;
    unsigned abi_broken;   /* enum machine_abi bits when MACHINE_RETURNED, 0 otherwise */
    int64_t value;         /* raw 64-bit return register when MACHINE_RETURNED */
    uint64_t instructions; /* instrumented: of the module's own that this call executed, exact, also
                              when it did not return (a repeated string instruction counts each
                              time; what an interrupting call executes is that one's); native: 0 */
    uint64_t stack_bytes;  /* instrumented: how deep this call went into the module's stack, host
                              services not included; native: 0 */
    uint64_t elapsed_ns;   /* wall time of the call, 0 unless timing is on (machine_timing) */
    unsigned aside;        /* which one it is, when MACHINE_ASIDE */
    struct machine_fault fault; /* not written when MACHINE_RETURNED or MACHINE_ASIDE */
};

/* Whether a machine of that kind runs such an image: 0, or -ENOEXEC with the reason. An image with
 * a defect runs nowhere. */
int machine_fits(const struct image *image, enum machine_kind kind, char why[MACHINE_WHY]);

/* Bytes of a pointer as the module knows it: 4 or 8. */
unsigned machine_pointer_size(const struct machine *machine);

/*
 * Maps and relocates the module. 0, or negative errno with a reason: a defect in the image, no
 * memory, a machine in this process already (-EBUSY). A relocation that is not relative is left
 * unapplied and a segment that is writable and executable is mapped so: the rules report both.
 * After success every exported entry can be called.
 */
int machine_load(struct machine **out, const struct image *image,
                 const struct machine_config *config, char why[MACHINE_WHY]);

/* Unmaps everything and gives signal handlers and timer back. In a sealed process the handlers stay
 * (the seal forbids changing them); they do nothing but end the process on a fault. */
void machine_unload(struct machine *machine);

/*
 * The module as if loaded again: its writable memory, poison included, and its stacks are put back
 * to what machine_load() made of them. In a sealed process nothing can be mapped or protected any
 * more, hence from a copy that machine_load() kept; for the module it is the same. Constant memory
 * cannot have changed. Not from inside a call, nor while one is set aside. 0, or -EFBIG when the
 * writable memory was too large for a copy (MACHINE_COPY_LIMIT).
 */
#define MACHINE_COPY_LIMIT (64u << 20)
int machine_reload(struct machine *machine, char why[MACHINE_WHY]);

/*
 * A named piece of memory that module code may reach, between guard pages of at least 1 MiB. It
 * ends exactly at a page boundary when size is a multiple of 16 (so that the first byte past it
 * faults); bytes before it down to the page boundary are filled with 0xCD. Zero-filled itself. With
 * MACHINE_REGION_READ the host's own pointer stays writable (second mapping) while the module's is
 * not. *host is for the host, *module is what the module is given; for READ_WRITE both are equal.
 * Aligned to 16 bytes. Names are shorter than MACHINE_REGION_NAME. Not possible after
 * machine_seal().
 */
int machine_map(struct machine *machine, const char *name, size_t size,
                enum machine_region_access access, void **host, void **module,
                char why[MACHINE_WHY]);

/* The same, readable and writable, with memory of somebody else's: the object behind fd, mapped
 * from its beginning, so that it is the last page that has slack. */
int machine_map_shared(struct machine *machine, const char *name, size_t size, int fd,
                       void **memory, char why[MACHINE_WHY]);

/*
 * A function of the host as a pointer that the module can call, whatever its calling convention:
 * the machine reads what the module passes (arguments.h) and brackets the call as
 * machine_service_enter() does. What function returns is what the module gets, in the register of
 * the convention for whole numbers (a pair of them where it has 32 bits). name lives as long as the
 * machine. At most MACHINE_SERVICES of them (thunks.h); not after machine_seal().
 */
typedef int64_t machine_function(void *context, struct arguments *arguments);
int machine_service(struct machine *machine, const char *name, machine_function *function,
                    void *context, void **pointer, char why[MACHINE_WHY]);

/* In a service: the module address behind the instruction that called it. False when that is none
 * of the module's. */
bool machine_service_caller(const struct machine *machine, uint64_t *pc);

/* Arms the traps: from here on, system calls issued by module code are caught (seccomp filter on
 * the instruction pointer's range, plus the sandbox of sandbox.h). Cannot be undone in this
 * process. */
int machine_seal(struct machine *machine, int evidence_fd, char why[MACHINE_WHY]);

/* "write", "kill": the name of the fault's system call, in the table that it says, "unknown" for
 * what has none. Allocates. */
#define MACHINE_CALL_NAME 32
void machine_system_call_name(const struct machine_fault *fault, char name[MACHINE_CALL_NAME]);

/* Measures elapsed_ns of each call when on (costs two clock reads a call). Off at start. */
void machine_timing(struct machine *machine, bool on);

/* Calls the exported function with one pointer argument on the module's own stack. Never fails to
 * return. function is an address of the module (image_symbol.vaddr), on Arm with bit 0 set when it
 * is Thumb code. When the outcome is not MACHINE_RETURNED the host may go on calling, but a service
 * that was cut short is not resumed. */
void machine_call(struct machine *machine, uint64_t function, void *argument,
                  struct machine_outcome *outcome);

/*
 * Interrupts: a call can be stopped between any two instructions of the module's own, something
 * else done, and be gone on with as if nothing had been. What is done may be calls of other
 * functions: those run at the next level, on a stack of their own, and may be interrupted in turn;
 * at most MACHINE_LEVELS deep.
 *
 * The hook runs on the host's stack. `pc` is the module address of the instruction that comes next,
 * `instructions` how many the call has executed (a repeated string instruction counts each time;
 * those of host services do not count; 0 unless they were counted from the beginning). It returns
 * after how many more it wants to be called again, MACHINE_NEVER: not; MACHINE_ABANDON: the call is
 * over, its outcome MACHINE_HANG there.
 */
typedef uint64_t machine_interrupt(void *argument, uint64_t pc, uint64_t instructions);

/*
 * The next machine_call() of this level, and that one only, may be interrupted: before it executes
 * instruction number `after` (from 0) - exact and the same on every run; the processor's trap flag
 * is used, which makes the call slow up to there, some microseconds an instruction - and whenever
 * the alarm comes.
 */
void machine_interrupt_next(struct machine *machine, uint64_t after, machine_interrupt *hook,
                            void *argument);
/* Instructions that the latest call of this level executed, if it was stepped to its end. */
uint64_t machine_instructions(const struct machine *machine);

/*
 * For hooks, which can so try out what an interrupt would lead to: goes on with the call that is
 * interrupted to its end, without further interrupts, and comes back with its outcome. The call
 * stands where it stood then, registers and stack as they were; memory elsewhere is the caller's to
 * put back.
 */
void machine_rehearse(struct machine *machine, struct machine_outcome *outcome);
/* Whether it can: not where calls cannot be interrupted. */
bool machine_rehearses(const struct machine *machine);

/* For hooks: memory that the instruction which comes next reads or writes by its operands (not what
 * it pushes or pops). Allocates when first called. How many there are. */
unsigned machine_next_operands(struct machine *machine,
                               struct code_operand operands[CODE_OPERANDS]);

/*
 * Calls set aside: a call that waits for something in a host service, while others are made. It
 * keeps its stack, and comes back from the service when it is gone on with. What it executes, how
 * deep it goes and how long it takes is counted from its beginning to its end; the hang is found
 * anew in each of its pieces natively, in their sum on an instrumented machine.
 *
 * In a service: the call is left when the service has returned, and machine_call() comes back with
 * MACHINE_ASIDE. False when it cannot be: no stack would be left for another call, it is being
 * rehearsed, or the machine sets none aside.
 */
bool machine_set_aside(struct machine *machine);
/* Makes a call that is set aside the next one to go on; from here on the alarm reaches it. Nothing
 * but machine_alarm_at() may come between this and machine_go_on(). */
void machine_take_up(struct machine *machine, unsigned aside);
/* As machine_call(), and its outcome may be MACHINE_ASIDE again. */
void machine_go_on(struct machine *machine, struct machine_outcome *outcome);
/* Or it is over: its outcome is MACHINE_HANG in the service. */
void machine_drop(struct machine *machine, unsigned aside, struct machine_outcome *outcome);

/* How many host services module code has entered so far. */
uint64_t machine_services(const struct machine *machine);

/* The module's own memory that it may write, in pieces; false past the last. */
bool machine_own_data(const struct machine *machine, unsigned index, void **at, size_t *size);

/* An alarm by the wall clock, for machine_seal()ed processes, too, when opened before. 0 or
 * negative errno. */
int machine_alarm_open(struct machine *machine, char why[MACHINE_WHY]);
/* Interrupts the call that is in progress or planned for (machine_interrupt_next) at that time of
 * CLOCK_MONOTONIC, as soon as no host service runs for it; 0: no more. What comes when there is no
 * such call is lost. */
void machine_alarm_at(struct machine *machine, uint64_t monotonic_ns);

/* Deepest use of the module stack so far, in bytes (from the untouched part of its fill pattern).
 * Host services run on the module's stack as well and count. */
size_t machine_stack_used(const struct machine *machine);

/* Instrumented: which bytes of the module have been executed since machine_load(), bit n % 8 of
 * byte n / 8 for module address *begin + n, up to *end. NULL natively. */
const uint8_t *machine_coverage(const struct machine *machine, uint64_t *begin, uint64_t *end);

/* The address at which the module address vaddr runs. */
void *machine_address(const struct machine *machine, uint64_t vaddr);

/* The other way round: false when address lies outside the module. */
bool machine_vaddr(const struct machine *machine, const void *address, uint64_t *vaddr);

/*
 * What machine_service() puts around a service; for functions of the host that are called in
 * another way: machine_service_enter(m, "pswprintf", __builtin_return_address(0)); ...
 * machine_service_leave(m); leave does not return when the call has been declared hung meanwhile.
 * Services may use one another: the outermost one is charged.
 */
void machine_service_enter(struct machine *machine, const char *service, void *return_address);
void machine_service_leave(struct machine *machine);

#endif
