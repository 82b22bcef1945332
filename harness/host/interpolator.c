/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * The INTERPOLATOR registers. The "CNC side" that fills and starts an interpolator is host.h's
 * host_interpolator_...() or a path that the configuration names; a PLC can only stop it.
 *
 * The arithmetic is in interp_run.h and interp_filter.h. What the manual leaves open is decided in
 * docs/decisions.md: M9 (the way to the servo), M10 (LookAheadBuffer), M11 (ranges), M15 (the
 * rest).
 */
#include "host/host_parts.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define AHEAD           8 /* entries of LookAheadBuffer */
#define HISTORY         8
#define NOT_A_DIRECTION 1.1e38
#define PER_MINUTE      60
#define INTERNAL        (-1) /* fileIdx */

/* --- M functions --- */

static void signal_continuous(struct interpolator *in, int32_t code)
{
    INTERPOLATOR *reg = in->reg;
    in->history = (in->history + 1) % HISTORY;
    reg->Cont_MFunc_History.mFuncs[in->history] = (uint32_t)code;
    reg->Cont_MFunc_History.lastValidEntry = in->history;
    reg->M_Func = reg->Last_ContMFunc = code;
}

static void signal_due(struct interpolator *in)
{
    unsigned left = 0;
    for (unsigned i = 0; i < in->signal_count; i++)
        if (in->signals[i].steps == 0)
            signal_continuous(in, in->signals[i].code);
        else {
            in->signals[left] = in->signals[i];
            in->signals[left++].steps--;
        }
    in->signal_count = left;
}

/* The run has reached it: interp_signal. */
static void signalled(void *argument, const struct interp_part *part)
{
    struct interpolator *in = argument;
    memcpy(in->reg->M_Function_Parameter, part->letters, sizeof part->letters);
    if (part->code < INTERPOLATOR_M_FUNC_CONTINUOUS_ABOVE) {
        in->reg->M_Func = in->reg->Act_MFunc = part->code;
        return;
    }
    if (in->signal_count == INTERPOLATOR_SIGNALS) { /* the oldest comes early */
        in->signals[0].steps = 0;
        signal_due(in);
    }
    in->signals[in->signal_count].code = part->code;
    in->signals[in->signal_count++].steps = in->spline.points;
}

/* --- positions --- */

void interpolator_place(struct interpolator *in, const double position[INTERP_AXES])
{
    interp_run_place(&in->run, position);
    interp_spline_set(&in->spline, in->spline.points, position);
    interp_iir_place(&in->iir, position);
    memcpy(in->position, position, sizeof in->position);
}

static void backlash(struct interpolator *in, unsigned axis, double moved)
{
    const struct interp_limits *limits = &in->path.limits;
    double *value = &in->backlash[axis];
    if (moved != 0)
        in->backwards[axis] = moved < 0;
    const double wanted = in->backwards[axis] ? -limits->backlash[axis] : 0;
    const double step = limits->backlash_step;
    *value = *value < wanted ? fmin(*value + step, wanted) : fmax(*value - step, wanted);
}

static void publish_positions(struct interpolator *in, const double position[INTERP_AXES],
                              double step)
{
    INTERPOLATOR *reg = in->reg;
    in->still = true;
    for (unsigned axis = 0; axis < INTERP_AXES; axis++) {
        const double moved = position[axis] - in->position[axis], before = in->backlash[axis];
        backlash(in, axis, moved);
        in->still = in->still && moved == 0 && in->backlash[axis] == before;
        reg->Orig_Position[axis] = in->run.position[axis];
        reg->Position[axis] = position[axis];
        reg->Speed[axis] = moved / step;
        reg->PositionInc[axis] = position[axis] * reg->Ratio[axis];
        reg->Backlash[axis] = in->backlash[axis];
        in->position[axis] = position[axis];
    }
}

/* Bit by bit, in line: this is asked in every slot. */
static bool same_place(const double a[INTERP_AXES], const double b[INTERP_AXES])
{
    uint64_t differs = 0;
    for (unsigned axis = 0; axis < INTERP_AXES; axis++) {
        uint64_t one, other;
        memcpy(&one, &a[axis], sizeof one);
        memcpy(&other, &b[axis], sizeof other);
        differs |= one ^ other;
    }
    return differs == 0;
}

/* It stood in the last step and stands in this one, and no filter has anything to say to it. */
static bool rests(const struct interpolator *in)
{
    const struct interp_run *run = &in->run;
    return in->still && !interp_run_is_active(run) && in->spline.points == 0 && in->iir.axes == 0 &&
           same_place(run->position, in->position);
}

/* What a step leaves of one that rests: the module may have written there (M9). */
static void publish_rest(struct interpolator *in)
{
    INTERPOLATOR *reg = in->reg;
    memcpy(reg->Orig_Position, in->position, sizeof in->position);
    memcpy(reg->Position, in->position, sizeof in->position);
    memset(reg->Speed, 0, sizeof reg->Speed);
    for (unsigned axis = 0; axis < INTERP_AXES; axis++)
        reg->PositionInc[axis] = in->position[axis] * reg->Ratio[axis];
    memcpy(reg->Backlash, in->backlash, sizeof in->backlash);
}

/* --- LookAheadBuffer --- */

static double tangent_of(const struct interp_part *part)
{
    double tangent[INTERP_AXES];
    unsigned axes[2];
    if (!interp_part_moves(part))
        return part->kind == INTERP_M ? NOT_A_DIRECTION : 0;
    interp_part_tangent(part, 0, tangent);
    interp_plane_axes(part->plane != 0 ? part->plane : INTERP_XY, axes);
    return angle_of(tangent[axes[0]], tangent[axes[1]]) * ANGLE_PI;
}

static double degrees(double half_turns)
{
    const double turns = half_turns / 2;
    return (turns - floor(turns)) * 360;
}

static void look_at(INTERPOLATOR_LOOK_AHEAD_ENTRY *entry, const struct interp_part *part,
                    size_t index)
{
    const bool m = part->kind == INTERP_M, arc = interp_part_is_arc(part);
    memcpy(entry->allParams, part->letters, sizeof entry->allParams);
    memcpy(entry->endPos, part->end, sizeof entry->endPos);
    entry->tangens = tangent_of(part);
    entry->movementType = m ? INTERPOLATOR_LOOK_AHEAD_ENTRY_MOVEMENTTYPE_M
                            : INTERPOLATOR_LOOK_AHEAD_ENTRY_MOVEMENTTYPE_G;
    entry->movementCode = m ? part->code : (int32_t)part->kind;
    entry->plane = part->plane != 0 ? part->plane : INTERP_XY;
    entry->tool = part->tool;
    entry->startAngle = arc ? degrees(part->start_angle) : NOT_A_DIRECTION;
    entry->endAngle = arc ? degrees(part->start_angle + part->sweep) : NOT_A_DIRECTION;
    entry->radius = part->radius;
    entry->partLength = part->length;
    entry->gCodeIndex = (int32_t)index;
    entry->editorLine = part->line;
    entry->fileIdx = 0;
    entry->correction = part->correction;
}

/* Generation 4 shifts: the running part is entry 0. In generation 5 a part stays where it is, at
 * its number modulo 8 (M10). */
static void look_ahead(struct interpolator *in)
{
    INTERPOLATOR *reg = in->reg;
    const struct interp_path *path = &in->path;
    const size_t first = in->run.part, left = path->count - first;
    const size_t count = left < AHEAD ? left : AHEAD;
    const size_t base = GENERATION(0, first % AHEAD);
    if (in->looked && in->looked_from == first && in->looked_count == count)
        return;
    in->looked = true;
    in->looked_from = first;
    in->looked_count = count;
    for (size_t i = 0; i < AHEAD; i++) {
        INTERPOLATOR_LOOK_AHEAD_ENTRY *entry = &reg->LookAheadBuffer[(base + i) % AHEAD].buf;
        if (i < count)
            look_at(entry, &path->parts[first + i], first + i);
        else
            *entry = (INTERPOLATOR_LOOK_AHEAD_ENTRY){
                .movementType = INTERPOLATOR_LOOK_AHEAD_ENTRY_MOVEMENTTYPE_INVALID
            };
    }
    reg->LookAheadBufferValidStart = (uint32_t)base;
    reg->LookAheadBufferValidEnd = (uint32_t)((base + (count > 0 ? count - 1 : 0)) % AHEAD);
}

/* --- status --- */

static const uint32_t statuses[] = {
    [INTERP_EMPTY] = INTERPOLATOR_STATUS_EMPTY_00,
    [INTERP_READY] = INTERPOLATOR_STATUS_TRAJECTORY_START_04,
    [INTERP_RUNNING] = INTERPOLATOR_STATUS_MOVE_01,
    [INTERP_STOPPING] = INTERPOLATOR_STATUS_MOVE_01,
    [INTERP_BRAKING] = INTERPOLATOR_STATUS_EMERGENCY_BREAKING_06,
    [INTERP_EMERGENCY] = INTERPOLATOR_STATUS_EMERGENCY_STOP_07,
    [INTERP_ENDED] = INTERPOLATOR_STATUS_STOP_03,
    [INTERP_STARVED] = INTERPOLATOR_STATUS_STOP_WHILE_BUFFER_FILL_08,
};

static uint32_t run_flag(const struct interp_run *run)
{
    static const uint32_t waits[] = {
        [INTERP_NO_WAIT] = INTERPOLATOR_RUN_FLAG_RUN,
        [INTERP_M_SIGNALLED] = INTERPOLATOR_RUN_FLAG_WAIT_MFUNC,
        [INTERP_M_END] = INTERPOLATOR_RUN_FLAG_WAIT_MFUNC_END,
        [INTERP_PULSE] = INTERPOLATOR_RUN_FLAG_WAIT_PULSE,
    };
    return (interp_run_is_active(run) ? waits[run->wait] : INTERPOLATOR_RUN_FLAG_STOP) |
           (uint32_t)run->phase << 16;
}

static void publish_part(const struct interp_run *run, INTERPOLATOR *reg)
{
    const struct interp_part *part = interp_run_part(run);
    if (part == NULL)
        return;
    reg->Act_Part = (int32_t)run->part;
    if (part->kind <= INTERP_DWELL)
        reg->Act_GFunc = (int32_t)part->kind;
    if (part->kind <= INTERP_CCW)
        reg->Set_Speed = part->feed * PER_MINUTE;
    reg->editorLine = part->line;
    reg->fileIdx = run->connecting ? INTERNAL : 0;
    reg->correction = part->correction;
    if (!run->connecting)
        reg->Tool_Number = part->tool;
}

static void publish_status(struct interpolator *in)
{
    const struct interp_run *run = &in->run;
    INTERPOLATOR *reg = in->reg;
    reg->Status = statuses[run->state];
    reg->Run_Flag = run_flag(run);
#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
    reg->Run_State = reg->Run_Flag >> INTERPOLATOR_RUN_STATE_SOURCE_SHIFT;
    reg->Act_Rel_Speed = in->override;
#endif
    reg->Act_Speed = run->speed * PER_MINUTE;
    reg->Move_Distance = run->passed + (run->connecting ? run->resume : run->way);
    if (run->wait != INTERP_M_SIGNALLED && run->wait != INTERP_M_END)
        reg->Act_MFunc = 0;
    if (interp_run_is_active(run))
        publish_part(run, reg);
}

/* --- stepping --- */

static double override_of(struct interpolator *in)
{
    const double wanted = in->reg->Rel_Speed;
    if (!isnan(wanted))
        in->override = wanted < 0.01 ? 0.01 : wanted > 2 ? 2 : wanted;
    return in->override;
}

/* An integer in TGM_Data; 0 where there is none. */
static int32_t external_position(const struct host *host, const INTERPOLATOR *reg)
{
    const size_t size = host->memory_bytes[SHARED_MEMORY_DATA];
    int32_t value = 0;
    if (reg->Adrress_External_Position <= size - sizeof value)
        memcpy(&value,
               (const char *)host->memory[SHARED_MEMORY_DATA] + reg->Adrress_External_Position,
               sizeof value);
    return value;
}

static void step(struct host *host, struct interpolator *in)
{
    const double seconds = host->schedule->interpolator_us * 1e-6;
    const struct interp_inputs inputs = {
        .step = seconds,
        .override = override_of(in),
        .acceleration = in->spline.points > 0 && in->jerk > 0
                            ? in->jerk * in->spline.points * seconds
                            : INFINITY,
        .m_done = in->reg->M_Func == 0,
        .m_delay = in->spline.points,
        .external = external_position(host, in->reg),
    };
    double position[INTERP_AXES];
    interp_run_step(&in->run, &inputs);
    signal_due(in);
    if (rests(in)) {
        publish_rest(in);
    } else {
        memcpy(position, in->run.position, sizeof position);
        interp_spline_step(&in->spline, position);
        interp_iir_step(&in->iir, position);
        publish_positions(in, position, seconds);
    }
    publish_status(in);
    look_ahead(in);
    in->asleep = rests(in) && in->command == 0 && in->signal_count == 0;
}

/* Nothing has happened to it since a step that left it at rest; whoever loads or starts it, or
 * writes a command, wakes it. There are steps in every slot, and mostly nobody moves. */
static bool asleep(const struct interpolator *in)
{
    return in->asleep && in->still && in->reg->Command == INTERPOLATOR_COMMANDS_NONE_00 &&
           !interp_run_is_active(&in->run);
}

/* Once a cycle, before Program_05 has its say in slot 0 and the set-points leave (M9): what a
 * module writes there stands until then. */
static void step_asleep(const struct host *host, struct interpolator *in)
{
    if (host->now_ns != host_time_of(host))
        return;
    override_of(in);
    publish_rest(in);
    publish_status(in);
}

/* Loaded since the Run sequence, and again now, because a PLC may have made it be dropped. */
static void start_configured(struct host *host)
{
    char why[HOST_WHY];
    if (host->config.path == NULL || host->path_started ||
        host->now_ns < host->config.path_start_ns)
        return;
    host->path_started = true;
    if (interpolator_load(host, 0, host->config.path, false, why) == 0)
        interpolator_start(host, 0);
}

static void slot(struct host *host)
{
    if (host->now_ns % (host->schedule->interpolator_us * UINT64_C(1000)) != 0)
        return;
    start_configured(host);
    for (size_t i = 0; i < host->interpolator_count; i++) {
        struct interpolator *in = &host->interpolators[i];
        const uint64_t begin = host_stopwatch(host);
        if (asleep(in)) {
            step_asleep(host, in);
        } else {
            interpolator_command(host, in);
            step(host, in);
        }
        measure_longest(&host->measured.interpolator_ns[i], host_stopwatch(host) - begin);
    }
}

/* --- the way to the servos --- */

/* Before the servos take their set-points: Program_05 has had its say in slot 0 (M9). */
static void send(struct host *host)
{
    for (size_t i = 0; i < host->axis_count; i++) {
        SERVO *servo = host->axes[i].reg;
        const uint32_t number = servo->Cnc.IntNumber, axis = servo->Cnc.AxisIndex;
        if (servo->Mode != host_modes(host)->interpolator || number >= host->interpolator_count)
            continue;
        const INTERPOLATOR *reg = host->interpolators[number].reg;
        if (axis < INTERP_AXES && axis < reg->Number_Axes)
            servo->WritePosition = reg->PositionInc[axis] + reg->Backlash[axis] + reg->Offset[axis];
    }
}

/* --- the CNC side --- */

static int load(struct host *host, size_t number, const struct interp_path *path, bool append,
                char why[HOST_WHY])
{
    struct interpolator *in = &host->interpolators[number];
    const size_t before = append ? in->path.count : 0;
    if (!append && interp_run_is_active(&in->run)) {
        snprintf(why, HOST_WHY, "interpolator %zu is moving", number);
        return -EBUSY;
    }
    if (append && !in->path.more) {
        snprintf(why, HOST_WHY, "the path of interpolator %zu has come to its end", number);
        return -EINVAL;
    }
    if (path->count > in->path.capacity - before) {
        snprintf(why, HOST_WHY, "the path has %zu parts, the buffer of interpolator %zu takes %zu",
                 path->count, number, in->path.capacity - before);
        return -ENOSPC;
    }
    if (!append) {
        in->path.limits = path->limits;
        memcpy(in->path.start, path->start, sizeof in->path.start);
    }
    in->path.count = before;
    in->path.more = path->more;
    for (size_t i = 0; i < path->count; i++) {
        const char *what;
        const int r = interp_path_add(&in->path, &path->parts[i], &what);
        if (r != 0) {
            in->path.count = before;
            snprintf(why, HOST_WHY, "part %zu: %s", i, what);
            return r;
        }
    }
    in->looked = in->still = false;
    if (append)
        interp_run_appended(&in->run);
    else
        interp_run_load(&in->run);
    return 0;
}

int interpolator_load(struct host *host, unsigned number, const struct interp_path *path,
                      bool append, char why[HOST_WHY])
{
    const char *wrong = interp_limits_wrong(&path->limits);
    if (number >= host->interpolator_count || wrong != NULL) {
        snprintf(why, HOST_WHY, "%s", wrong != NULL ? wrong : "no such interpolator");
        return -EINVAL;
    }
    return load(host, number, path, append, why);
}

bool interpolator_start(struct host *host, unsigned number)
{
    return number < host->interpolator_count && interp_run_start(&host->interpolators[number].run);
}

void interpolator_stop(struct host *host, unsigned number, bool emergency, bool drop)
{
    if (number < host->interpolator_count)
        interp_run_stop(&host->interpolators[number].run, emergency, drop);
}

/* --- Run sequence --- */

static void clear(struct host *host)
{
    static const double nowhere[INTERP_AXES];
    char why[HOST_WHY];
    for (size_t i = 0; i < host->interpolator_count; i++) {
        struct interpolator *in = &host->interpolators[i];
        INTERPOLATOR *reg = in->reg;
        const struct interp_path path = in->path;
        *in = (struct interpolator){ .reg = reg, .override = 1 };
        interp_path_init(&in->path, path.parts, path.capacity);
        interp_run_init(&in->run, &in->path, signalled, in);
        interpolator_place(in, nowhere);
        memset(reg, 0, sizeof *reg);
        reg->Number = (uint32_t)i;
        reg->Number_Axes = MAX_INTERPOLATOR_AXES;
        reg->Buffer_Size = (uint32_t)path.capacity;
        reg->Rel_Speed = 1;
        for (unsigned axis = 0; axis < INTERP_AXES; axis++)
            reg->Ratio[axis] = 1;
    }
    host->path_started = false;
    if (host->config.path != NULL)
        interpolator_load(host, 0, host->config.path, false, why);
}

static uint32_t buffer_of(const struct host_config *config, size_t number)
{
    static const uint32_t least = GENERATION(1000, 500), most = GENERATION(100000, 50000);
    const uint32_t wanted = config->interpolator_items[number];
    if (wanted == 0)
        return INTERPOLATOR_BUFFER;
    return wanted < least ? least : wanted > most ? most : wanted;
}

static int open_interpolators(struct host *host, char why[HOST_WHY])
{
    const unsigned most = host->config.product->max_interpolator;
    const unsigned wanted = host->config.interpolators;
    if (wanted > most || wanted > INTERPOLATORS_MOST) {
        snprintf(why, HOST_WHY, "%u interpolators are more than the %u that %s has", wanted, most,
                 host->config.product->title);
        return -E2BIG;
    }
    host->interpolator_count = wanted != 0 ? wanted : most;
    host->system->Main.Number_Interpolators = (uint32_t)host->interpolator_count;
    for (size_t i = 0; i < host->interpolator_count; i++) {
        const uint32_t capacity = buffer_of(&host->config, i);
        struct interp_path *path = &host->interpolators[i].path;
        host->interpolators[i].reg = (INTERPOLATOR *)host->memory[SHARED_MEMORY_INTERPOLATOR] + i;
        interp_path_init(path, calloc(capacity, sizeof *path->parts), capacity);
        if (path->parts == NULL) {
            snprintf(why, HOST_WHY, "no memory");
            return -ENOMEM;
        }
    }
    clear(host);
    return host->config.path != NULL ? interpolator_load(host, 0, host->config.path, false, why)
                                     : 0;
}

void interpolators_close(struct host *host)
{
    for (size_t i = 0; i < INTERPOLATORS_MOST; i++)
        free(host->interpolators[i].path.parts);
}

const struct host_part host_interpolator = {
    .name = "interpolator", .open = open_interpolators, .clear = clear, .send = send, .slot = slot
};
