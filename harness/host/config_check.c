/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Configuration as a whole: what must fit together, and what the host makes of it. */
#include "host/config.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "host/servo_wire.h"

/* Type 92: which feedback an axis can have (config.md 3). */
enum { DSL = 1, ENDAT = 2, SSI = 3 };
enum { TYPE_VIRTUAL = 0, TYPE_TGM_CONTROLLER = 92 };

void config_add_problem(struct config *config, unsigned line, bool warning, const char *format, ...)
{
    va_list arguments;
    *(warning ? &config->warnings : &config->errors) += 1;
    if (config->problem_count == CONFIG_PROBLEMS)
        return;
    struct config_problem *problem = &config->problems[config->problem_count++];
    problem->line = line;
    problem->warning = warning;
    va_start(arguments, format);
    vsnprintf(problem->text, sizeof problem->text, format, arguments);
    va_end(arguments);
    /* It goes to a terminal; the file could hold anything. */
    for (char *c = problem->text; *c != '\0'; c++)
        if ((unsigned char)*c < ' ' || *c == 0x7F)
            *c = '?';
}

/* Line of a key by where it goes, 0 when it is not in the file. */
static unsigned line_of(const struct config *config, size_t offset, unsigned n)
{
    for (size_t i = 0; config_key(i) != NULL; i++)
        if (config_key(i)->offset == offset && config->line[i][n] != 0)
            return config->line[i][n];
    return 0;
}
#define LINE(config, member)          line_of(config, offsetof(struct config, member), 0)
#define SERVO_LINE(config, member, n) line_of(config, offsetof(struct config, servos[0].member), n)

/* First line in which a servo is mentioned at all. */
static unsigned servo_line(const struct config *config, unsigned n)
{
    unsigned first = 0;
    for (size_t i = 0; config_key(i) != NULL; i++) {
        const unsigned line = config->line[i][n];
        if (config_key(i)->each == CONFIG_EACH_SERVO && line != 0 && (first == 0 || line < first))
            first = line;
    }
    return first;
}

/* One more than the highest number of a servo that is mentioned. */
static unsigned servos_named(const struct config *config)
{
    unsigned after = 0;
    for (size_t i = 0; config_key(i) != NULL; i++) {
        unsigned n = config_key(i)->each == CONFIG_EACH_SERVO ? config->product->max_servo : 0;
        while (n > after && config->line[i][n - 1] == 0)
            n--;
        after = n > after ? n : after;
    }
    return after;
}

/* Servos have numbers from 00 on, without gaps, and each has a type. */
static void count_servos(struct config *config)
{
    const unsigned after = servos_named(config);
    for (unsigned n = 0; n < after; n++) {
        const unsigned line = servo_line(config, n);
        if (line == 0)
            config_add_problem(config, servo_line(config, after - 1), false,
                               "Servo[%02u] is missing: servos are numbered from 00, without gaps",
                               n);
        else if (SERVO_LINE(config, type, n) == 0)
            config_add_problem(config, line, false, "Servo[%02u] has no Type", n);
    }
    config->servo_count = after;
}

/* Two axes of one drive share its Node. */
static void check_nodes(struct config *config, unsigned n)
{
    const struct config_servo *servo = &config->servos[n];
    if (servo->type <= TYPE_VIRTUAL)
        return;
    if (servo->node > 64)
        config_add_problem(config, servo_line(config, n), false, "Servo[%02u] has no Node", n);
    for (unsigned k = 0; k < n; k++) {
        const struct config_servo *other = &config->servos[k];
        if (other->type <= TYPE_VIRTUAL || other->node != servo->node || other->axis != servo->axis)
            continue;
        config_add_problem(config, servo_line(config, n), false,
                           "Servo[%02u] and Servo[%02u] are both axis %lld of node %lld", k, n,
                           (long long)servo->axis, (long long)servo->node);
        return;
    }
}

/* An invalid pair is an error, not a servo without feedback (C6). */
static void check_feedback(struct config *config, unsigned n)
{
    const struct config_servo *servo = &config->servos[n];
    const unsigned line = SERVO_LINE(config, feedback, n);
    if (servo->type != TYPE_TGM_CONTROLLER) {
        if (line != 0)
            config_add_problem(config, line, true, "Servo[%02u].FeedbackType is of type 92 only",
                               n);
        return;
    }
    if (servo->feedback == DSL || (servo->axis == 1 && servo->feedback == ENDAT) ||
        (servo->axis == 2 && servo->feedback == SSI))
        return;
    config_add_problem(
        config, line, false, "Servo[%02u].FeedbackType=%lld: axis %lld takes 1 or %d", n,
        (long long)servo->feedback, (long long)servo->axis, servo->axis == 1 ? ENDAT : SSI);
}

/* What a servo loop looks at decides which source of motion: no value may mean two of them. */
static void check_modes(struct config *config)
{
    const struct {
        const char *name;
        int64_t value;
        unsigned line;
    } modes[] = {
        { "Off", config->mode_off, LINE(config, mode_off) },
        { "Position", config->mode_position, LINE(config, mode_position) },
        { "PG", config->mode_pg, LINE(config, mode_pg) },
        { "Gear", config->mode_gear, LINE(config, mode_gear) },
        { "PG_Gear", config->mode_pg_gear, LINE(config, mode_pg_gear) },
        { "Interpolator", config->mode_interpolator, LINE(config, mode_interpolator) },
        { "User", config->mode_user, LINE(config, mode_user) },
    };
    for (size_t i = 0; i < sizeof modes / sizeof *modes; i++)
        for (size_t k = 0; k < i; k++)
            if (modes[i].value == modes[k].value)
                config_add_problem(config,
                                   modes[i].line > modes[k].line ? modes[i].line : modes[k].line,
                                   false, "%s and %s in [Servo_Modes] are both %lld", modes[k].name,
                                   modes[i].name, (long long)modes[i].value);
}

static void check_network(struct config *config)
{
    const unsigned line = LINE(config, gateway) != 0 ? LINE(config, gateway) : LINE(config, ip);
    if (((config->gateway ^ config->ip) & config->mask) != 0)
        config_add_problem(config, line, false,
                           "Gateway in [DHCP] is not in the segment of IPAddress");
    if (config->modbus_offset % 4 != 0)
        config_add_problem(config, LINE(config, modbus_offset), true,
                           "Offset=%lld in [Modbus] should be divisible by 4",
                           (long long)config->modbus_offset);
    if (config->modbus_offset >= config->data_bytes)
        config_add_problem(config, LINE(config, modbus_offset), false,
                           "Offset=%lld in [Modbus] is past the end of TGM_Data (%lld bytes)",
                           (long long)config->modbus_offset, (long long)config->data_bytes);
}

void config_check(struct config *config)
{
    count_servos(config);
    for (unsigned n = 0; n < config->servo_count; n++) {
        check_nodes(config, n);
        check_feedback(config, n);
    }
    check_modes(config);
    check_network(config);
}

/* --- what the host makes of it --- */

/* Up to 64 it is a number of bits (C5). */
static uint32_t increments(int64_t resolution)
{
    return resolution > 0 && resolution <= 64 ? UINT32_C(1) << resolution : (uint32_t)resolution;
}

static uint32_t period_of(const struct config *config, int which)
{
    const uint32_t period = (uint32_t)config->period_us[which];
    return period == 0 && config->product->periods[which].may_be_off ? PERIOD_OFF : period;
}

void config_apply(const struct config *config, struct config_store *store, struct host_config *host)
{
    host->product = config->product;
    host->cycle_us = (uint32_t)config->cycle_us;
    for (int i = 0; i < 3; i++)
        host->program_period_us[i] = period_of(config, i);
    host->data_bytes = (uint32_t)config->data_bytes;
    host->osc_bytes = (uint32_t)config->osc_mib * 1048576u;
    host->eeprom_bytes = (uint32_t)config->eeprom_bytes;
    host->can_kbit = (uint32_t)config->can_kbit;
    host->log_ctrl = (uint32_t)config->log;
    for (int i = 0; i < CONFIG_INTERPOLATORS; i++)
        host->interpolator_items[i] = (uint32_t)config->interpolator_items[i];
    if (LINE(config, distributed_clock) != 0)
        host->clock = config->distributed_clock != 0 ? CLOCK_ON : CLOCK_OFF;
    store->modes = (struct servo_modes){
        .off = (int32_t)config->mode_off,
        .position = (int32_t)config->mode_position,
        .pg = (int32_t)config->mode_pg,
        .gear = (int32_t)config->mode_gear,
        .pg_gear = (int32_t)config->mode_pg_gear,
        .interpolator = (int32_t)config->mode_interpolator,
        .user = (int32_t)config->mode_user,
    };
    host->modes = &store->modes;
    for (unsigned n = 0; n < config->servo_count; n++) {
        const struct config_servo *servo = &config->servos[n];
        store->servos[n] = (struct host_servo){
            .type = (uint32_t)servo->type,
            .node = (uint32_t)servo->node,
            .axis = (uint32_t)servo->axis,
            .feedback = (uint32_t)servo->feedback,
            .resolution = increments(servo->resolution),
        };
    }
    if (config->servo_count > 0) {
        host->servos = store->servos;
        host->servo_count = config->servo_count;
    }
}

/* Drives that answer to what a servo type asks for, with one and two axes. */
static const char *drive_for(uint32_t type, bool two)
{
    switch (type) {
    case 9:
    case 91:
    case 92:
    case 93:
    case 94:
    case 95:
    case 99:
        return two ? "tgz-2" : "tgz-1";
    default:
        return two ? "drive-cia402x2" : "drive-cia402";
    }
}

/* The device of the servo, made when there is none yet. Drives inside the controller come first. */
static void add_drive(struct config_store *store, const struct host_servo *servo)
{
    struct plant *plant = &store->plant;
    const bool internal = wire_is_internal(servo->type);
    const uint16_t alias = internal ? 0 : (uint16_t)servo->node;
    size_t i = 0;
    while (i < plant->device_count && store->devices[i].alias != alias)
        i++;
    if (i == plant->device_count) {
        plant->device_count++;
        store->devices[i] =
            (struct bus_device){ .type = drive_for(servo->type, false), .alias = alias };
    }
    if (servo->axis == 2)
        store->devices[i].type = drive_for(servo->type, true);
}

const struct plant *config_plant(const struct config *config, struct config_store *store)
{
    store->plant = (struct plant){ .devices = store->devices,
                                   .servos = config->servo_count > 0 ? config->servo_count : 1,
                                   .dios = 1,
                                   .redundant = config->redundancy != 0 };
    if (config->servo_count == 0) {
        memcpy(store->devices, plant_default.devices, sizeof *store->devices);
        store->plant.device_count = 1;
    }
    for (int internal = 1; internal >= 0; internal--)
        for (unsigned n = 0; n < config->servo_count; n++)
            if (store->servos[n].type != TYPE_VIRTUAL &&
                wire_is_internal(store->servos[n].type) == (internal != 0))
                add_drive(store, &store->servos[n]);
    store->devices[store->plant.device_count++] =
        plant_default.devices[plant_default.device_count - 1];
    return &store->plant;
}
