/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * audit.h - what the host makes of what it sees the module do, call by call: a fixed table of
 * accesses by function, instruction and register, the order of inputs and outputs in a call, what
 * each function cost at most, and whether its set-points can be followed.
 *
 * Accesses, costs and depths are those of an instrumented machine (machine/trace.h); on a native
 * one there are none of them, and `traced` is false. The rest is seen on every machine.
 *
 * struct audit_record is a part of struct evidence: filled in the worker, not trusted by the parent
 * before audit_clean(). struct audit is the worker's own.
 */
#ifndef HARNESS_HOST_AUDIT_H
#define HARNESS_HOST_AUDIT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/catalogue.h"
#include "host/product.h"
#include "machine/machine.h"
#include "machine/trace.h"

#define AUDIT_ACCESSES 2048
#define AUDIT_MEMORIES 16
#define AUDIT_NAME     160
/* audit_access.memory of a write to the module's own code; offset is then a module address. */
#define AUDIT_CODE 255

/* Whoever runs faster than this needs another motor; no register of TG Motion says what the axis
 * can do (decision H19). */
#define AUDIT_AXIS_SPEED 100.0 /* rev/s */
#define AUDIT_AXIS_JUMP                                                                            \
    0.01 /* rev: how far from the axis a set-point may be that it is to hold                       \
          */

/* What a register is to the judgement, bits. */
enum audit_class {
    AUDIT_READ_ONLY = 1 << 0, /* the layout says that the PLC reads it */
    AUDIT_INPUT = 1 << 1,     /* tells of the machine: SERVO.Position, DIO.In */
    AUDIT_OUTPUT = 1 << 2,    /* acts on the machine: SERVO.WritePosition, DIO.Out */
    AUDIT_DOUBLE = 1 << 3,
    AUDIT_SINGLE = 1 << 4
};

/* What one instruction of one function did to one register (of an array: to its elements; of a
 * memory without registers: to all of it). */
struct audit_access {
    uint64_t pc; /* module address */
    uint64_t count;
    uint64_t first_cycle, first_value; /* EVIDENCE_NO_CYCLE: in Program_Ini; its bits */
    uint32_t offset;                   /* of the first, in the memory */
    uint32_t odd_offset;               /* of the first odd one */
    uint64_t odd_count, odd_cycle;     /* writes of NaN or infinity to an output */
    uint8_t entry, memory;             /* enum entry; index in the catalogue, or AUDIT_CODE */
    uint8_t size, classes;             /* bytes of the first; enum audit_class */
    bool write, before_op; /* the first came before every slave was in OP for the first time */
};

/* An input that was read in a call that had written an output already. */
struct audit_order {
    uint64_t count, cycle; /* calls in which it was so; the first */
    uint64_t output_pc, input_pc;
    uint32_t output_offset, input_offset;
    uint8_t output_memory, input_memory;
};

struct audit_function {
    uint64_t calls; /* that were counted: traced */
    uint64_t instructions, worst_instructions, worst_cycle;
    uint64_t stack_bytes;
    uint64_t looked;     /* accesses to the PLC_DATA that it was given */
    unsigned abi_broken; /* enum machine_abi, of all calls */
    uint64_t abi_cycle;  /* of the first that broke something */
    uint64_t sleeps, sleep_cycle, sleep_pc;
    uint64_t messages;
    struct audit_order order;
};

/* What is wrong with a set-point when it leaves for the bus. */
enum audit_motion_kind {
    AUDIT_TOO_FAST,  /* further from the last one than the axis can go in a cycle */
    AUDIT_JUMP,      /* away from the axis in the cycle in which it begins to follow */
    AUDIT_EARLY,     /* the axis is to move before its slave has been in OP */
    AUDIT_NO_NUMBER, /* NaN, infinity */
    AUDIT_MOTION_KINDS
};

struct audit_motion {
    uint64_t count, cycle;
    uint32_t axis;
    double value, limit; /* of the first: inc */
};

struct audit_record {
    bool traced; /* a machine has counted what it executed */
    uint32_t access_count;
    uint64_t access_dropped; /* accesses for which there was no row any more */
    struct audit_access accesses[AUDIT_ACCESSES];
    struct audit_function functions[ENTRY_COUNT];
    struct audit_motion motion[AUDIT_MOTION_KINDS];
};

/* One memory, byte by byte: which of the catalogue's lines, and what it is. */
struct audit_memory {
    size_t bytes, stride;
    uint16_t *line;   /* by offset % stride; 0: none; NULL: a memory without registers */
    uint8_t *classes; /* by line */
};

enum { AUDIT_SLOTS = 4 * AUDIT_ACCESSES };

struct audit {
    struct audit_record *record;
    struct audit_memory memories[AUDIT_MEMORIES];
    size_t memory_count;
    uint16_t slots[AUDIT_SLOTS]; /* hash of a row -> its index + 1 */
    unsigned depth;              /* calls that stand inside one another */
    struct audit_call {
        enum entry entry;
        uint64_t cycle;
        bool op;            /* every slave has been in OP */
        bool written, told; /* an output was; and an input was read then */
        uint64_t pc;        /* of the first output */
        uint32_t offset;
        uint8_t memory;
    } calls[MACHINE_LEVELS];
};

/* Makes the tables for a catalogue and writes to the record from now on. Region n of the machine is
 * memory n of the catalogue. 0 or -ENOMEM. */
int audit_open(struct audit *audit, const struct catalogue *catalogue, struct audit_record *record);
void audit_close(struct audit *audit);

/* Around every call. Calls nest where one interrupts another. One that sleeps is paused and begun
 * once more: behind SleepFt the order of inputs and outputs is a new one. */
void audit_begin(struct audit *audit, enum entry entry, uint64_t cycle, bool op);
void audit_pause(struct audit *audit);
/* What a call took that did not return does not count. */
void audit_end(struct audit *audit, bool returned, uint64_t instructions, uint64_t stack_bytes);
/* One access of the module: a trace_callback. */
void audit_access(void *audit, const struct trace_access *access);

/* Counts something wrong with the set-point of an axis. */
void audit_motion(struct audit_record *record, enum audit_motion_kind kind, uint64_t cycle,
                  size_t axis, double value, double limit);

/* Makes a record that a worker wrote safe to read. */
void audit_clean(struct audit_record *record);

/* "SERVO[0].Position": the register at an offset of a memory, "byte 16 of TGM_Data" where there is
 * none. */
void audit_name(const struct catalogue *catalogue, unsigned memory, uint32_t offset,
                char name[AUDIT_NAME]);
/* What the catalogue says of it; false where there is no register. */
bool audit_line(const struct catalogue *catalogue, unsigned memory, uint32_t offset,
                struct catalogue_line *line);

#endif
