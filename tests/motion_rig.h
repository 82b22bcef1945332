/* SPDX-License-Identifier: GPL-2.0-or-later */
/* motion_rig.h - the bench with servos that move by themselves, on every layout. */
#ifndef TESTS_MOTION_RIG_H
#define TESTS_MOTION_RIG_H

#include "tests/host_rig.h"

#include <math.h>

#define COUNT(array) (sizeof(array) / sizeof *(array))
#define RELATIVE     1e-9L
#define SERVOS       4

enum { OFF, POSITION, PG, GEAR, PG_GEAR, INTERPOLATOR, USER = 9 };
enum { WRITE_POSITION = 1, ACTUAL_POSITION, TICK, EXT_POSITION };
enum { LINEAR = 1, CAM };

static const struct plant nothing = { 0 };
static const struct host_servo virtuals[SERVOS];

/* The two products, and TG Motion 5.00, which is none but has a layout of its own. */
static inline const struct product *product_of(size_t index)
{
    static struct product older;

    if (index < 2)
        return product_find(index == 0 ? "pc4" : "pc5");
    older = *product_find("pc5");
    older.version = 500;
    older.memory_id = 905;
    return &older;
}

#define EACH_LAYOUT(p) for (size_t p = 0; p < 3; p++)

static inline struct rig *open_virtuals(size_t product, uint32_t cycle_us)
{
    const struct host_config config = { .product = product_of(product),
                                        .cycle_us = cycle_us,
                                        .plant = &nothing,
                                        .servos = virtuals,
                                        .servo_count = SERVOS };
    struct rig *rig = rig_open("idle", &config);

    rig_start(rig);
    rig_cycles(rig, 1);
    return rig;
}

static inline const char *name_of(unsigned servo, const char *member)
{
    static char names[8][64];
    static unsigned next;
    char *name = names[next++ % COUNT(names)];

    snprintf(name, sizeof names[0], "SERVO[%u].%s", servo, member);
    return name;
}

static inline double get(const struct rig *rig, unsigned servo, const char *member)
{
    return rig_get(rig, name_of(servo, member));
}

static inline void set(const struct rig *rig, unsigned servo, const char *member, double value)
{
    rig_set(rig, name_of(servo, member), value);
}

struct setting {
    const char *member;
    double value;
};

static inline void set_all(const struct rig *rig, unsigned servo, const struct setting *settings)
{
    for (; settings->member != NULL; settings++)
        set(rig, servo, settings->member, settings->value);
}

#define SET(rig, servo, ...)                                                                       \
    set_all(rig, servo, (const struct setting[]){ __VA_ARGS__, { NULL, 0 } })

static inline void set_table(const struct rig *rig, const char *memory, unsigned line,
                             unsigned count, double (*value)(unsigned index))
{
    char name[32];

    for (unsigned i = 0; i < count; i++) {
        snprintf(name, sizeof name, "%s.F64[%u]", memory, line + i * 8);
        rig_set(rig, name, value(i));
    }
}

static inline void assert_near(long double value, long double reference)
{
    if (!(fabsl(value - reference) <= RELATIVE * fabsl(reference)))
        fail_msg("%.17Lg instead of %.17Lg", value, reference);
}

/* Goes on until the command has finished. */
static inline void command(struct rig *rig, unsigned servo, int number, unsigned most)
{
    set(rig, servo, "Command.Control", number);
    rig_until(rig, name_of(servo, "Command.Control"), 0, most);
}

static inline void profile_of(const struct rig *rig, unsigned servo, double speed,
                              double acceleration)
{
    SET(rig, servo, { "Pg.Mode", 1 }, { "Pg.Type", 3 }, { "Pg.PosSpeed", speed },
        { "Pg.Acc", acceleration }, { "Pg.Dec", acceleration });
}

/* Servo `slave` goes in/out times the way of servo `master`. */
static inline void link_servos(const struct rig *rig, unsigned slave, unsigned master, double in,
                               double out)
{
    SET(rig, slave, { "Gear.SourceNumber", master }, { "Gear.SourcePosition", WRITE_POSITION },
        { "Gear.In", in }, { "Gear.Out", out }, { "Gear.Mode", LINEAR }, { "Mode", GEAR });
}

#define POINTS 37 /* of a cam */

static inline double slope(unsigned index)
{
    return 100.0 + index;
}

#endif
