/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/scenario_value.h"

#include <math.h>
#include <string.h>

static struct scenario_value whole(int64_t i)
{
    return (struct scenario_value){ .is_double = false, .i = i };
}

static struct scenario_value real(double d)
{
    return (struct scenario_value){ .is_double = true, .d = d };
}

double scenario_double(struct scenario_value value)
{
    return value.is_double ? value.d : (double)value.i;
}

bool scenario_true(struct scenario_value value)
{
    return value.is_double ? value.d < 0 || value.d > 0 : value.i != 0;
}

struct scenario_value scenario_load(enum scalar type, const void *at)
{
    int64_t i = 0;
    switch (type) {
    case F32:
    case F64:
        return real(scalar_get(type, at));
    case U64:
    case I64:
        memcpy(&i, at, sizeof i);
        return type == U64 && i < 0 ? real(scalar_get(type, at)) : whole(i);
    default:
        return whole((int64_t)scalar_get(type, at));
    }
}

/* Least and most of the whole types up to 32 bits. */
static const struct {
    int64_t least, most;
} ranges[] = { [I8] = { INT8_MIN, INT8_MAX },    [U8] = { 0, UINT8_MAX },
               [I16] = { INT16_MIN, INT16_MAX }, [U16] = { 0, UINT16_MAX },
               [I32] = { INT32_MIN, INT32_MAX }, [U32] = { 0, UINT32_MAX },
               [I64] = { INT64_MIN, INT64_MAX }, [U64] = { 0, INT64_MAX } };

/* A value beyond 2^63 that an unsigned register holds. */
static bool store_large(void *at, double value)
{
    uint64_t u;
    if (!(value >= 0x1p63 && value < 0x1p64))
        return false;
    u = (uint64_t)value;
    memcpy(at, &u, sizeof u);
    return true;
}

bool scenario_store(enum scalar type, void *at, struct scenario_value value)
{
    if (type == F64 || type == F32) {
        const double d = scenario_double(value);
        const float f = (float)d;
        memcpy(at, type == F64 ? (const void *)&d : (const void *)&f, scalar_size(type));
        return true;
    }
    if (value.is_double) {
        if (type == U64 && store_large(at, value.d))
            return true;
        if (!(value.d >= -0x1p63 && value.d < 0x1p63) || floor(value.d) < value.d)
            return false;
        value = whole((int64_t)value.d);
    }
    if (value.i < ranges[type].least || value.i > ranges[type].most)
        return false;
    memcpy(at, &value.i, scalar_size(type)); /* little-endian, as all targets are */
    return true;
}

static struct scenario_value absolute(struct scenario_value a)
{
    if (a.is_double)
        return real(fabs(a.d));
    return a.i == INT64_MIN ? real(0x1p63) : whole(a.i < 0 ? -a.i : a.i);
}

struct scenario_value scenario_unary(enum scenario_op op, struct scenario_value a, unsigned index)
{
    switch (op) {
    case SCENARIO_BIT:
        return a.is_double ? real(NAN) : whole((int64_t)((uint64_t)a.i >> index & 1));
    case SCENARIO_MINUS:
        return a.is_double || a.i == INT64_MIN ? real(-scenario_double(a)) : whole(-a.i);
    case SCENARIO_NOT:
        return whole(!scenario_true(a));
    case SCENARIO_FLIP:
        return a.is_double ? real(NAN) : whole(~a.i);
    case SCENARIO_ABS:
        return absolute(a);
    default:
        return real(NAN);
    }
}

static struct scenario_value divided(enum scenario_op op, struct scenario_value a,
                                     struct scenario_value b)
{
    const bool rest = op == SCENARIO_REST;
    if (a.is_double || b.is_double)
        return real(rest ? NAN : scenario_double(a) / scenario_double(b));
    if (b.i == 0)
        return real(NAN);
    if (b.i == -1) /* the least number has no opposite */
        return rest ? whole(0) : scenario_unary(SCENARIO_MINUS, a, 0);
    return whole(rest ? a.i % b.i : a.i / b.i);
}

static struct scenario_value arithmetic(enum scenario_op op, struct scenario_value a,
                                        struct scenario_value b)
{
    const double x = scenario_double(a), y = scenario_double(b);
    int64_t sum = 0;
    bool over = a.is_double || b.is_double;
    switch (op) {
    case SCENARIO_TIMES:
        over = over || __builtin_mul_overflow(a.i, b.i, &sum);
        return over ? real(x * y) : whole(sum);
    case SCENARIO_PLUS:
        over = over || __builtin_add_overflow(a.i, b.i, &sum);
        return over ? real(x + y) : whole(sum);
    default:
        over = over || __builtin_sub_overflow(a.i, b.i, &sum);
        return over ? real(x - y) : whole(sum);
    }
}

static bool compared(enum scenario_op op, struct scenario_value a, struct scenario_value b)
{
    const bool doubles = a.is_double || b.is_double;
    const double x = scenario_double(a), y = scenario_double(b);
    const bool below = doubles ? x < y : a.i < b.i, above = doubles ? x > y : a.i > b.i;
    const bool equal = doubles ? x <= y && x >= y : a.i == b.i;
    switch (op) {
    case SCENARIO_EQUAL:
        return equal;
    case SCENARIO_UNEQUAL:
        return !equal;
    case SCENARIO_BELOW:
        return below;
    case SCENARIO_AT_MOST:
        return below || equal;
    case SCENARIO_ABOVE:
        return above;
    default:
        return above || equal;
    }
}

static struct scenario_value bits(enum scenario_op op, struct scenario_value a,
                                  struct scenario_value b)
{
    if (a.is_double || b.is_double)
        return real(NAN);
    return whole(op == SCENARIO_BITS_AND   ? a.i & b.i
                 : op == SCENARIO_BITS_XOR ? a.i ^ b.i
                                           : a.i | b.i);
}

struct scenario_value scenario_binary(enum scenario_op op, struct scenario_value a,
                                      struct scenario_value b)
{
    switch (op) {
    case SCENARIO_MIN:
    case SCENARIO_MAX:
        if (isnan(scenario_double(a)) || isnan(scenario_double(b)))
            return real(NAN);
        return compared(SCENARIO_BELOW, a, b) == (op == SCENARIO_MIN) ? a : b;
    case SCENARIO_DIVIDED:
    case SCENARIO_REST:
        return divided(op, a, b);
    case SCENARIO_TIMES:
    case SCENARIO_PLUS:
    case SCENARIO_LESS_BY:
        return arithmetic(op, a, b);
    case SCENARIO_BITS_AND:
    case SCENARIO_BITS_XOR:
    case SCENARIO_BITS_OR:
        return bits(op, a, b);
    case SCENARIO_AND:
        return whole(scenario_true(a) && scenario_true(b));
    case SCENARIO_OR:
        return whole(scenario_true(a) || scenario_true(b));
    default:
        return whole(compared(op, a, b));
    }
}
