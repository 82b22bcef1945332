/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * What moves servos by itself: the profile generator (SERVO.Pg) and the gear (SERVO.Gear), once a
 * cycle in slot 2. First come all profile generators, then the gears, each after its master, so
 * that a slave follows without a delay of a cycle.
 *
 * What the manual leaves open is decided in docs/decisions.md: M1 (Mode), M4 (gear and cam), M8
 * (profiles). The arithmetic is in profile_motion.h and gear_motion.h.
 */
#include "host/host_parts.h"

#include <math.h>
#include <string.h>

static unsigned sources_of(const struct servo_modes *modes, int32_t mode)
{
    return (mode == modes->pg || mode == modes->pg_gear ? MOTION_PG : 0u) |
           (mode == modes->gear || mode == modes->pg_gear ? MOTION_GEAR : 0u);
}

/* Where a generator takes over: at the set-point of an axis that follows it, else where the axis
 * is. */
double motion_start(const struct host *host, const struct axis *axis)
{
    const SERVO *reg = axis->reg;
    const double place =
        servo_runs(host, axis) ? reg->WritePosition : axis->actual - reg->Offset - reg->Correction;
    return isfinite(place) ? place : axis->actual;
}

static void choose_sources(const struct host *host, struct axis *axis)
{
    struct axis_motion *m = &axis->motion;
    const unsigned now = servo_runs(host, axis) ? sources_of(host_modes(host), axis->reg->Mode) : 0;
    m->restarted = now != m->sources;
    m->sources = now;
}

/* --- profile generator --- */

static struct profile_wanted wanted_profile(const PG *pg)
{
    const bool positioning = pg->Mode == PG_MODE_POSITION || pg->Mode == PG_MODE_DECELERATING;
    return (struct profile_wanted)
    {
        .positioning = positioning, .destination = pg->DPos,
        .speed = positioning ? pg->PosSpeed : pg->Speed, .acceleration = pg->Acc,
        .deceleration = pg->Dec,
#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
        .percent = pg->Jerklimitation,
#endif
        .type = pg->Type
    };
}

static void publish_profile(PG *pg, const struct profile *profile)
{
    pg->APos = profile->position;
    pg->ASpeed = profile->speed;
    pg->Rdy = profile->ready;
    if (pg->Mode == PG_MODE_POSITION || pg->Mode == PG_MODE_DECELERATING)
        pg->Mode = profile->braking ? PG_MODE_DECELERATING : PG_MODE_POSITION;
}

static void profile_calculate(const struct host *host, struct axis *axis)
{
    struct axis_motion *m = &axis->motion;
    PG *pg = &axis->reg->Pg;
    const bool on = (m->sources & MOTION_PG) != 0;
    if (!on || m->restarted)
        profile_set(&m->profile, motion_start(host, axis), on ? axis->sent_speed : 0);
    if (on) {
        const struct profile_wanted wanted = wanted_profile(pg);
        profile_step(&m->profile, &wanted, host_cycle_seconds(host));
    }
    publish_profile(pg, &m->profile);
}

/* --- gear --- */

/* The master whose set-point of this cycle the gear needs, or NULL. */
static struct axis *master_of(struct host *host, const struct axis *axis)
{
    const GEAR *gear = &axis->reg->Gear;
    if (gear->Mode == GEAR_MODE_OFF || gear->SourcePosition != GEAR_SOURCEPOSITION_WRITE_POSITION ||
        (uint32_t)gear->SourceNumber >= host->axis_count)
        return NULL;
    return &host->axes[gear->SourceNumber];
}

/* No number when there is no such source. */
static double source_value(const struct host *host, const GEAR *gear)
{
    if (gear->SourcePosition == GEAR_SOURCEPOSITION_SERVO_TICK)
        return (double)host->servo_tick;
    if ((uint32_t)gear->SourceNumber >= host->axis_count)
        return NAN;
    const SERVO *master = host->axes[gear->SourceNumber].reg;
    switch (gear->SourcePosition) {
    case GEAR_SOURCEPOSITION_WRITE_POSITION:
        return master->WritePosition;
    case GEAR_SOURCEPOSITION_POSITION:
        return host->axes[gear->SourceNumber].actual;
    case GEAR_SOURCEPOSITION_EXT_POSITION:
        return master->ExtPosition;
    default:
        return NAN;
    }
}

static void take_part(struct axis_motion *m, double output)
{
    if (m->zero_next)
        m->zero = output;
    m->zero_next = false;
    m->part = output - m->zero;
}

static void linear_calculate(const struct host *host, struct axis *axis)
{
    struct axis_motion *m = &axis->motion;
    GEAR *gear = &axis->reg->Gear;
    const bool on = (m->sources & MOTION_GEAR) != 0;
    if (!on || m->restarted || m->mode != GEAR_MODE_LINEAR) {
        m->ratio_in = 0;
        gear_link_set(&m->link, m->part + m->zero - gear->Offset);
    } else if ((uint32_t)gear->SourceNumber != m->source_number ||
               (uint32_t)gear->SourcePosition != m->source_position)
        gear_link_set(&m->link, m->link.last_position);
    if (on) {
        m->ratio_in = gear_ramp(m->ratio_in, gear->In, gear->IncIn);
        gear_link_step(&m->link, source_value(host, gear), m->ratio_in, gear->Out);
    }
    gear->ActualIn = (int32_t)floor(m->ratio_in + 0.5);
    gear->Position = m->link.last_position;
    if (on)
        take_part(m, gear->Position + gear->Offset);
}

static void external_cam(const struct host *host, const GEAR *gear, struct cam cam, uint32_t line,
                         uint32_t address)
{
    double value = 0;
    cam.line = line;
    cam.increment = 0;
    if (cam_value(&cam, gear->Position, 0, &value))
        cam_output(host->memory[SHARED_MEMORY_DATA], host->memory_bytes[SHARED_MEMORY_DATA],
                   address, value);
}

static void cam_calculate(const struct host *host, struct axis *axis)
{
    struct axis_motion *m = &axis->motion;
    GEAR *gear = &axis->reg->Gear;
    const int memory =
        gear->CamTab == GEAR_CAMTAB_DATA_MEMORY ? SHARED_MEMORY_DATA : SHARED_MEMORY_CAM_PROFILE;
    const struct cam cam = {
        .memory = host->memory[memory],
        .size = host->memory_bytes[memory],
        .line = (uint32_t)gear->CamLine,
        .length = (uint32_t)gear->CamLen,
        .increment = gear->CamType == GEAR_CAMTYPE_FORWARD ? gear->CamIncPosition : 0,
    };
    double turns, value;
    gear->ActualIn = gear->In;
    gear->ActualShift = gear_ramp(gear->ActualShift, gear->Shift, gear->IncShift);
    const double way = source_value(host, gear) * gear->In / gear->Out + gear->ActualShift;
    if (gear->Out == 0 || !cam_pointer(way, cam.length, &gear->Position, &turns))
        return;
    if (cam_value(&cam, gear->Position, turns, &value)) {
        const double output = value * gear->CamScale + gear->Offset;
        gear->CamPosition = isfinite(output) ? output : gear->CamPosition;
        if ((m->sources & MOTION_GEAR) != 0)
            take_part(m, gear->CamPosition);
    }
    if (((uint32_t)gear->CamExpControl & GEAR_CAMEXPCONTROL_EXT_CAM_1) != 0)
        external_cam(host, gear, cam, (uint32_t)gear->CamExpLine1, (uint32_t)gear->CamExpAddress1);
    if (((uint32_t)gear->CamExpControl & GEAR_CAMEXPCONTROL_EXT_CAM_2) != 0)
        external_cam(host, gear, cam, (uint32_t)gear->CamExpLine2, (uint32_t)gear->CamExpAddress2);
}

/* Superposed on the profile generator it adds what it has moved since then. */
static void gear_begin(const struct host *host, struct axis *axis)
{
    struct axis_motion *m = &axis->motion;
    const bool superposed = (m->sources & MOTION_PG) != 0;
    m->zero_next = superposed;
    m->zero = 0;
    m->part = superposed ? 0 : motion_start(host, axis);
}

static void gear_calculate(const struct host *host, struct axis *axis)
{
    struct axis_motion *m = &axis->motion;
    GEAR *gear = &axis->reg->Gear;
    if ((m->sources & MOTION_GEAR) == 0 || m->restarted)
        gear_begin(host, axis);
    if (gear->Mode == GEAR_MODE_LINEAR)
        linear_calculate(host, axis);
    else if (gear->Mode == GEAR_MODE_CAM)
        cam_calculate(host, axis);
    else
        gear->ActualIn = 0;
    m->mode = (uint32_t)gear->Mode;
    m->source_number = (uint32_t)gear->SourceNumber;
    m->source_position = (uint32_t)gear->SourcePosition;
}

/* --- set-point --- */

static void axis_output(const struct host *host, struct axis *axis)
{
    struct axis_motion *m = &axis->motion;
    SERVO *reg = axis->reg;
    gear_calculate(host, axis);
    if (m->sources != 0)
        reg->WritePosition = ((m->sources & MOTION_PG) != 0 ? m->profile.position : 0) +
                             ((m->sources & MOTION_GEAR) != 0 ? m->part : 0);
    else if (sources_of(host_modes(host), reg->Mode) != 0)
        reg->WritePosition = motion_start(host, axis);
}

/* The axis after its master, that after its own, and so on. Where masters go round in a circle, the
 * last one is taken as it was in the last cycle. */
static void in_order(struct host *host, struct axis *axis)
{
    struct axis *chain[HOST_AXES];
    size_t count = 0;
    for (; axis != NULL && axis->motion.ordered != host->cycle + 1; axis = master_of(host, axis)) {
        axis->motion.ordered = host->cycle + 1;
        chain[count++] = axis;
    }
    while (count > 0)
        axis_output(host, chain[--count]);
}

static void profile(struct host *host)
{
    /* The register has 32 bits; a cam driven by it goes on when it wraps. */
    host->servo_tick += (uint32_t)(host->system->Main.Servo_Tick - (uint32_t)host->servo_tick);
    for (size_t i = 0; i < host->axis_count; i++) {
        command_before(host, &host->axes[i]);
        choose_sources(host, &host->axes[i]);
        profile_calculate(host, &host->axes[i]);
    }
    for (size_t i = 0; i < host->axis_count; i++)
        in_order(host, &host->axes[i]);
    for (size_t i = 0; i < host->axis_count; i++)
        command_after(host, &host->axes[i]);
}

void motion_refer(struct axis *axis, double reference)
{
    struct axis_motion *m = &axis->motion;
    SERVO *reg = axis->reg;
    const double offset = axis->actual - reference, by = offset - reg->Offset;
    reg->Offset = offset;
    reg->RefPosition = axis->actual - offset;
    reg->WritePosition -= by;
    reg->Pg.DPos -= by;
    reg->Pg.APos -= by;
    profile_shift(&m->profile, -by);
    if (m->sources != MOTION_GEAR)
        return;
    m->part -= by;
    if (reg->Gear.Mode == GEAR_MODE_CAM) {
        reg->Gear.Offset -= by;
        reg->Gear.CamPosition -= by;
    } else {
        m->link.position -= by;
        m->link.last_position -= by;
        reg->Gear.Position -= by;
    }
}

static void clear(struct host *host)
{
    for (size_t i = 0; i < host->axis_count; i++) {
        host->axes[i].motion = (struct axis_motion){ .sources = 0 };
        host->axes[i].reg->Mode = host_modes(host)->off;
        host->axes[i].reg->Command.Control = COMMAND_CONTROL_DONE;
    }
}

const struct host_part host_motion = { .name = "motion", .clear = clear, .profile = profile };
