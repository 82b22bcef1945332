/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * catalogue.h - the registers of the shared memories by name, as generated from sdk/layout/.
 *
 * A name is a path: SERVO[0].Position, SERVO[1].Pg.Acc, SYSTEM.Main.Servo_Tick, DIO[0].In0. The
 * parts of SYSTEM may be named without it, as the manual does: HEADER.Compatibility_Id,
 * MAIN.Servo_Tick, TIMERS.Timer_Up[3], OSC.Control. Memories without a structure are named by byte
 * offset and type: DATA.F64[16], CAM.I32[0]. Letter case counts.
 */
#ifndef HARNESS_HOST_CATALOGUE_H
#define HARNESS_HOST_CATALOGUE_H

#include <stddef.h>
#include <stdint.h>

#define CATALOGUE_WHY 256

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
    const char *unit;   /* "-" when there is none */
    const char *access; /* "R", "W", "RW", "?", "reserved" */
};

/* Memories of the generation, in order of number; NULL past the end. */
const struct catalogue_memory *catalogue_memory(size_t index);
/* The one with that name ("TGM_Servo"), NULL when there is none. */
const struct catalogue_memory *catalogue_memory_named(const char *name);

/* 0, or -EINVAL with a sentence in why: which part of the name is wrong and what is allowed. */
int catalogue_resolve(const char *name, struct catalogue_register *out, char why[CATALOGUE_WHY]);

/* One line of the register list: arrays as one, [n] for the element of a memory. */
struct catalogue_line {
    const struct catalogue_memory *memory;
    char name[160];     /* "SERVO[n].Pg.Acc", "SYSTEM.Timers.Timer_Up[64]" */
    size_t offset;      /* bytes in the memory, of element 0 */
    size_t stride;      /* bytes from one element of the memory to the next */
    size_t size, count; /* bytes of all of it; array length */
    enum scalar type;
    const char *access, *unit, *note;
};

typedef void catalogue_visit(void *argument, const struct catalogue_line *line);

/* Every register that is not reserved, in order of memory and offset. */
void catalogue_walk(catalogue_visit *visit, void *argument);

size_t scalar_size(enum scalar type);
/* Value at an address as a number; 64-bit integers beyond 2^53 lose their low bits. */
double scalar_get(enum scalar type, const void *at);
const char *scalar_name(enum scalar type);

#endif
