/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * scenario_value.h - the numbers that a scenario computes with (docs/scenarios.md, Expressions).
 *
 * Whole numbers have 64 bits and are exact; what does not fit any more becomes a floating-point
 * number. The same operands give the same result, to the last bit, on every machine.
 */
#ifndef HARNESS_HOST_SCENARIO_VALUE_H
#define HARNESS_HOST_SCENARIO_VALUE_H

#include "host/catalogue.h"

struct scenario_value {
    bool is_double;
    union {
        int64_t i;
        double d;
    };
};

enum scenario_op {
    SCENARIO_NUMBER,   /* pushes value */
    SCENARIO_REGISTER, /* pushes what register `index` holds */
    /* Unary. */
    SCENARIO_BIT, /* bit `index` of a register */
    SCENARIO_MINUS,
    SCENARIO_NOT,
    SCENARIO_FLIP,
    SCENARIO_ABS,
    /* Binary. */
    SCENARIO_MIN,
    SCENARIO_MAX,
    SCENARIO_TIMES,
    SCENARIO_DIVIDED,
    SCENARIO_REST,
    SCENARIO_PLUS,
    SCENARIO_LESS_BY,
    SCENARIO_BITS_AND,
    SCENARIO_BITS_XOR,
    SCENARIO_BITS_OR,
    SCENARIO_EQUAL,
    SCENARIO_UNEQUAL,
    SCENARIO_BELOW,
    SCENARIO_AT_MOST,
    SCENARIO_ABOVE,
    SCENARIO_AT_LEAST,
    SCENARIO_AND,
    SCENARIO_OR
};

struct scenario_code {
    enum scenario_op op;
    unsigned index;
    struct scenario_value value;
};

#define SCENARIO_STACK 64 /* operands that wait at the same time, at most */

double scenario_double(struct scenario_value value);
/* Neither 0 nor "not a number". */
bool scenario_true(struct scenario_value value);

struct scenario_value scenario_load(enum scalar type, const void *at);
/* False: the register cannot hold the value as it is (range, or a fraction in a whole register);
 * nothing is written then. A single-precision register takes the nearest value. */
bool scenario_store(enum scalar type, void *at, struct scenario_value value);

struct scenario_value scenario_unary(enum scenario_op op, struct scenario_value a, unsigned index);
struct scenario_value scenario_binary(enum scenario_op op, struct scenario_value a,
                                      struct scenario_value b);

#endif
