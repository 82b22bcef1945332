/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * catalogue.h - the registers of the shared memories by name, as generated from sdk/layout/, one
 * catalogue for each layout of TG Motion: 4.21, 5.00, 5.02.
 *
 * A name is a path: SERVO[0].Position, SERVO[1].Pg.Acc, SYSTEM.Main.Servo_Tick, DIO[0].In0. The
 * parts of SYSTEM may be named without it, as the manual does: HEADER.Compatibility_Id,
 * MAIN.Servo_Tick, TIMERS.Timer_Up[3], OSC.Control, EEPROM.Data[0] and, in 5.02, OSC_EX and ETH.
 * Memories without a structure are named by byte offset and type: DATA.F64[16], CAM.I32[0]. Letter
 * case counts.
 */
#ifndef HARNESS_HOST_CATALOGUE_H
#define HARNESS_HOST_CATALOGUE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define CATALOGUE_WHY 256

/* Who says what may be done with a register: a document of TG Motion's, or decision L5. */
enum access_by { ACCESS_STATED, ACCESS_OURS };

enum scalar { I8, U8, I16, U16, I32, U32, I64, U64, F32, F64, STRUCT };

struct catalogue_memory {
    unsigned number;    /* SHARED_MEMORY number of the generation */
    const char *name;   /* "TGM_Servo" */
    const char *root;   /* first part of a register name, "-" when there is none */
    const char *type;   /* structure of an element, "-" for flat memories */
    size_t count, size; /* elements; bytes of the whole memory */
    int pointer;        /* offset of its pointer in PLC_DATA (64-bit), -1 when the PLC has none */
};

struct catalogue_register {
    const struct catalogue_memory *memory;
    size_t offset; /* bytes in the memory */
    enum scalar type;
    const char *unit;   /* "-": it has none; "?": no document says which */
    const char *access; /* "R": the PLC reads, "W": it writes, "RW": both; "reserved" */
    enum access_by access_by;
};

struct catalogue;

/* The catalogue of a generation (4, 5) and memory id (904; 905, 906; 0: the newest of the
 * generation), NULL when there is none. */
const struct catalogue *catalogue_find(int generation, int memory_id);

/* Its memories, in order of number; NULL past the end. */
const struct catalogue_memory *catalogue_memory(const struct catalogue *catalogue, size_t index);
/* The one with that name ("TGM_Servo"), NULL when there is none. */
const struct catalogue_memory *catalogue_memory_named(const struct catalogue *catalogue,
                                                      const char *name);

/* 0, or -EINVAL with a sentence in why: which part of the name is wrong and what is allowed. */
int catalogue_resolve(const struct catalogue *catalogue, const char *name,
                      struct catalogue_register *out, char why[CATALOGUE_WHY]);

/* The layout's constants that are whole numbers, by name: SERVO_READY_ENABLE. */
bool catalogue_constant(const struct catalogue *catalogue, const char *name, int64_t *value);
/* Their names; NULL past the end. */
const char *catalogue_constant_name(const struct catalogue *catalogue, size_t index);

/* One line of the register list: arrays as one, [n] for the element of a memory. */
struct catalogue_line {
    const struct catalogue_memory *memory;
    char name[160];     /* "SERVO[n].Pg.Acc", "SYSTEM.Timers.Timer_Up[64]" */
    size_t offset;      /* bytes in the memory, of element 0 */
    size_t stride;      /* bytes from one element of the memory to the next */
    size_t size, count; /* bytes of all of it; array length */
    enum scalar type;
    const char *access, *unit, *note; /* as in struct catalogue_register; its meaning */
    enum access_by access_by;
    struct {
        size_t count, stride;
    } arrays[4]; /* of structures that it lies in, outermost first, as the 32 of Channel[32].Offset
                  */
    size_t array_count;
};

/* Whether the byte at an offset in the memory belongs to the line, in whichever element. */
bool catalogue_line_holds(const struct catalogue_line *line, uint64_t offset);

/* The name of the register of the line that has the byte: "SERVO[3].Pg.Acc". */
void catalogue_line_name(const struct catalogue_line *line, uint64_t offset, char *out,
                         size_t size);

typedef void catalogue_visit(void *argument, const struct catalogue_line *line);

/* Every register that is not reserved, in order of memory and offset. */
void catalogue_walk(const struct catalogue *catalogue, catalogue_visit *visit, void *argument);

size_t scalar_size(enum scalar type);
/* Value at an address as a number; 64-bit integers beyond 2^53 lose their low bits. */
double scalar_get(enum scalar type, const void *at);
const char *scalar_name(enum scalar type);

#endif
