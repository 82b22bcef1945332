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
 */
#ifndef HARNESS_MACHINE_H
#define HARNESS_MACHINE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "image/image.h"

#define MACHINE_WHY         512
#define MACHINE_REGION_NAME 32

struct machine;

struct machine_config {
    uint64_t seed;     /* places and poison are a function of it (and of nothing else) */
    bool poison;       /* fill writable data with a seeded pattern instead of its initial values:
                          TG Motion does not initialise globals. Words that a relocation patches and
                          the RELRO range keep their values. */
    size_t stack_size; /* bytes for module code, rounded up to pages; 0 = 256 KiB */
    uint64_t hang_ns;  /* a call longer than this is a hang; 0 = 1 s. Wall time, resolution 1/4. */
};

enum machine_region_access { MACHINE_REGION_READ, MACHINE_REGION_READ_WRITE };

enum machine_outcome_kind {
    MACHINE_RETURNED,
    MACHINE_FAULT,   /* processor exception: see fault */
    MACHINE_SYSCALL, /* module code issued a system call; it was not carried out */
    MACHINE_HANG     /* did not return in hang_ns */
};

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
                    nothing, a host service), the module's return address, if found */
    bool has_pc;
    uint64_t ip;         /* raw instruction pointer */
    long syscall;        /* number, for MACHINE_SYSCALL */
    const char *service; /* host service that was running for the module, NULL when none */
    char region[MACHINE_REGION_NAME]; /* nearest named region to address, "" when none is near */
    int64_t region_offset; /* address - start of that region (may be negative or past its end) */
    uint64_t region_size;
};

struct machine_outcome {
    enum machine_outcome_kind kind;
    int64_t value;       /* raw 64-bit return register when MACHINE_RETURNED */
    uint64_t elapsed_ns; /* wall time of the call, 0 unless timing is on (machine_timing) */
    struct machine_fault fault;
};

/*
 * Maps and relocates the module. 0, or negative errno with a reason: a defect in the image, an
 * executable segment that is also writable (mapped without write), a relocation that is not
 * relative (left unapplied: the rules report it; calling the module may then fault), no memory.
 * After success every exported entry can be called.
 */
int machine_load(struct machine **out, const struct image *image,
                 const struct machine_config *config, char why[MACHINE_WHY]);
void machine_unload(struct machine *machine);

/*
 * A named piece of memory that module code may reach, between guard pages of at least 1 MiB. It
 * ends exactly at a page boundary when size is a multiple of 16 (so that the first byte past it
 * faults); bytes before it down to the page boundary are filled with 0xCD. Zero-filled itself. With
 * MACHINE_REGION_READ the host's own pointer stays writable (second mapping) while the module's is
 * not. *host is for the host, *module is what the module is given; for READ_WRITE both are equal.
 */
int machine_map(struct machine *machine, const char *name, size_t size,
                enum machine_region_access access, void **host, void **module,
                char why[MACHINE_WHY]);

/* Arms the traps: from here on, system calls issued by module code are caught (seccomp filter on
 * the instruction pointer's range, plus the sandbox of sandbox.h). Cannot be undone in this
 * process. */
int machine_seal(struct machine *machine, int evidence_fd, char why[MACHINE_WHY]);

/* Measures elapsed_ns of each call when on (costs two clock reads a call). Off at start. */
void machine_timing(struct machine *machine, bool on);

/* Calls the exported function with one pointer argument on the module's own stack. Never fails to
 * return. function is an address of the module (image_symbol.vaddr). */
void machine_call(struct machine *machine, uint64_t function, void *argument,
                  struct machine_outcome *outcome);

/* Deepest use of the module stack so far, in bytes (from the untouched part of its fill pattern).
 */
size_t machine_stack_used(const struct machine *machine);

/* The address at which the module address vaddr runs. */
void *machine_address(const struct machine *machine, uint64_t vaddr);

/*
 * Host services (functions that the module calls through PLC_DATA) bracket themselves with these,
 * so that a bad pointer or an endless loop inside them is charged to the module's call:
 *   machine_service_enter(m, "pswprintf", __builtin_return_address(0)); ...
 * machine_service_leave(m); leave does not return when the call has been declared hung meanwhile.
 */
void machine_service_enter(struct machine *machine, const char *service, void *return_address);
void machine_service_leave(struct machine *machine);

#endif
