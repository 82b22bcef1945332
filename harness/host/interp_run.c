/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/interp_run.h"

#include <math.h>
#include <string.h>

#include "host/angle.h"

#define M_STOP       0 /* program stop: goes on when it is started again */
#define M_OPTIONAL   1 /* not asked for */
#define M_CONTINUOUS 1000

void interp_run_init(struct interp_run *run, struct interp_path *path, interp_signal *signal,
                     void *argument)
{
    *run = (struct interp_run){
        .path = path, .signal = signal, .argument = argument, .phase = INTERP_STANDS
    };
}

const struct interp_part *interp_run_part(const struct interp_run *run)
{
    if (run->connecting)
        return &run->connection;
    return run->part < run->path->count ? &run->path->parts[run->part] : NULL;
}

static void stand(struct interp_run *run, enum interp_state state)
{
    run->state = state;
    run->speed = 0;
    run->phase = INTERP_STANDS;
    run->planned = false;
}

void interp_run_drop(struct interp_run *run)
{
    run->drop = run->connecting = run->m_signalled = false;
    run->wait = INTERP_NO_WAIT;
    run->path->count = run->part = 0;
    run->way = run->resume = 0;
    if (run->state != INTERP_EMERGENCY)
        run->state = INTERP_EMPTY;
}

void interp_run_place(struct interp_run *run, const double position[INTERP_AXES])
{
    memcpy(run->position, position, sizeof run->position);
}

bool interp_run_load(struct interp_run *run)
{
    if (interp_run_is_active(run))
        return false;
    run->drop = run->connecting = run->m_signalled = false;
    run->wait = INTERP_NO_WAIT;
    run->part = 0;
    run->way = run->resume = run->passed = run->dwelt = run->last_feed = 0;
    run->m_waited = 0;
    run->state = run->path->count > 0 ? INTERP_READY : INTERP_EMPTY;
    return true;
}

void interp_run_appended(struct interp_run *run)
{
    run->planned = false;
    if (run->state == INTERP_EMPTY && run->path->count > 0)
        run->state = INTERP_READY;
}

/* --- planning --- */

static double set_speed(const struct interp_run *run, const struct interp_part *part)
{
    return part->feed * run->override;
}

static double smaller(double a, double b)
{
    return a < b ? a : b;
}

/* Motion goes on over it without a pause. */
static bool passes(const struct interp_part *part)
{
    if (part->kind == INTERP_M)
        return part->code > M_CONTINUOUS || part->code == M_OPTIONAL;
    return part->kind <= INTERP_CCW;
}

static double joint_speed(const struct interp_run *run, const struct interp_part *before,
                          const struct interp_part *after)
{
    double leaves[INTERP_AXES], enters[INTERP_AXES], product = 0;
    interp_part_tangent(before, before->length, leaves);
    interp_part_tangent(after, 0, enters);
    for (unsigned i = 0; i < INTERP_AXES; i++)
        product += leaves[i] * enters[i];
    /* The limit includes what rounding makes of two equal directions. */
    if (product < angle_cosine(run->path->limits.corner) - 1e-12)
        return 0;
    return smaller(set_speed(run, before), set_speed(run, after));
}

/* The highest speed at the end of the running part from which every speed ahead can be met. */
static double exit_speed(const struct interp_run *run, const struct interp_part *part,
                         double deceleration)
{
    const struct interp_path *path = run->path;
    double most = set_speed(run, part), ahead = 0;
    if (run->connecting)
        return 0;
    for (size_t i = run->part + 1; 2 * deceleration * ahead < most * most; i++) {
        if (i >= path->count || i > run->part + INTERP_LOOK_AHEAD || !passes(&path->parts[i]))
            return smaller(most, sqrt(2 * deceleration * ahead));
        const struct interp_part *next = &path->parts[i];
        if (!interp_part_moves(next))
            continue;
        const double joint = joint_speed(run, part, next);
        most = smaller(most, sqrt(joint * joint + 2 * deceleration * ahead));
        ahead += next->length;
        part = next;
    }
    return most;
}

static void add_stretch(struct interp_run *run, double way, double speed, double acceleration,
                        double lasts)
{
    if (!(lasts > 0))
        return;
    run->stretches[run->stretch_count++] = (struct interp_stretch){
        .begins = run->ends, .way = way, .speed = speed, .acceleration = acceleration
    };
    run->ends += lasts;
}

/* As the ramp goes: to a standstill in this part, or through it. */
static void plan_ramp(struct interp_run *run, double rest, double deceleration)
{
    const double v = run->speed, left = v * v - 2 * deceleration * rest;
    run->stands_after = left <= 0;
    run->end_speed = left > 0 ? sqrt(left) : 0;
    add_stretch(run, run->way, v, -deceleration, (v - run->end_speed) / deceleration);
}

static void plan_motion(struct interp_run *run, const struct interp_part *part, double rest)
{
    const double a = smaller(run->path->limits.acceleration, run->acceleration);
    const double d = smaller(run->path->limits.deceleration, run->acceleration);
    const double v = run->speed, most = set_speed(run, part);
    const double end = smaller(exit_speed(run, part, d), sqrt(v * v + 2 * a * rest));
    if (v * v - end * end >= 2 * d * rest) { /* just fits, or is too fast already */
        plan_ramp(run, rest, d);
        run->stands_after = false;
        if (run->end_speed - end < 1e-6 * v)
            run->end_speed = end;
        return;
    }
    double way = run->way, from = v;
    if (v > most) {
        add_stretch(run, way, v, -d, (v - most) / d);
        way += (v * v - most * most) / (2 * d);
        from = most;
    }
    rest = part->length - way;
    const double peak =
        smaller(sqrt((2 * a * d * rest + d * from * from + a * end * end) / (a + d)), most);
    const double up = peak > from ? (peak * peak - from * from) / (2 * a) : 0;
    const double down = peak > end ? (peak * peak - end * end) / (2 * d) : 0;
    add_stretch(run, way, from, a, (peak - from) / a);
    if (rest > up + down && peak == most)
        add_stretch(run, way + up, peak, 0, (rest - up - down) / peak);
    add_stretch(run, part->length - down, peak, -d, (peak - end) / d);
    run->end_speed = end;
}

static void plan(struct interp_run *run, const struct interp_part *part, double left)
{
    const struct interp_limits *limits = &run->path->limits;
    const double rest = part->length - run->way;
    run->planned = true;
    run->stretch_count = 0;
    run->ends = run->end_speed = 0;
    run->stands_after = run->speed_changes = false;
    run->first = left;
    run->steps = 0;
    if (part->kind == INTERP_DWELL) {
        run->stands_after = run->state != INTERP_RUNNING;
        run->ends = run->stands_after ? 0 : part->dwell - run->dwelt;
    } else if (run->state == INTERP_BRAKING)
        plan_ramp(run, rest, limits->emergency);
    else if (run->state == INTERP_STOPPING)
        plan_ramp(run, rest, smaller(limits->deceleration, run->acceleration));
    else if (interp_part_moves(part)) {
        run->speed_changes = run->last_feed != 0 && run->last_feed != part->feed && run->speed > 0;
        plan_motion(run, part, rest);
        run->last_feed = part->feed;
    } else
        run->end_speed = run->speed;
}

/* Nothing but M functions behind it. */
static bool is_last(const struct interp_run *run)
{
    if (run->connecting)
        return false;
    for (size_t i = run->part + 1; i < run->path->count; i++)
        if (interp_part_moves(&run->path->parts[i]))
            return false;
    return true;
}

static enum interp_phase phase_of(const struct interp_run *run, double acceleration)
{
    if (run->state == INTERP_BRAKING)
        return INTERP_EMERGENCY_RAMP;
    if (run->speed_changes)
        return INTERP_NEXT_SPEED;
    if (acceleration > 0)
        return INTERP_ACCELERATES;
    if (acceleration == 0)
        return INTERP_AT_SPEED;
    return is_last(run) ? INTERP_LAST_DECELERATION : INTERP_DECELERATES;
}

/* --- stepping --- */

static void evaluate(struct interp_run *run, double time)
{
    unsigned i = run->stretch_count - 1;
    while (i > 0 && run->stretches[i].begins > time)
        i--;
    const struct interp_stretch *s = &run->stretches[i];
    const double t = time - s->begins;
    run->way = s->way + t * (s->speed + s->acceleration * t / 2);
    run->speed = s->speed + s->acceleration * t;
    run->phase = phase_of(run, s->acceleration);
    run->speed_changes = false;
}

static void dwell(struct interp_run *run, const struct interp_part *part, double time)
{
    run->dwelt = part->dwell - (run->ends - time);
    run->speed = 0;
    run->phase = INTERP_STANDS;
}

static void next_part(struct interp_run *run)
{
    run->planned = run->m_signalled = false;
    run->wait = INTERP_NO_WAIT;
    run->m_waited = 0;
    run->dwelt = 0;
    if (run->connecting) {
        run->connecting = false;
        run->way = run->resume;
        return;
    }
    run->passed += run->path->parts[run->part].length;
    run->part++;
    run->way = 0;
}

static enum interp_state state_when_stopped(const struct interp_run *run)
{
    return run->state == INTERP_BRAKING ? INTERP_EMERGENCY : INTERP_READY;
}

/* A part that takes time. Returns what it leaves of the step. */
static double advance(struct interp_run *run, const struct interp_part *part, double left,
                      double step)
{
    if (run->planned)
        run->steps++;
    else
        plan(run, part, left);
    const double time = run->first + (double)run->steps * step;
    if (time < run->ends) {
        if (part->kind == INTERP_DWELL)
            dwell(run, part, time);
        else
            evaluate(run, time);
        return 0;
    }
    left = smaller(time - run->ends, left);
    run->speed = run->end_speed;
    if (!run->stands_after) {
        next_part(run);
        return left;
    }
    const struct interp_stretch *s = &run->stretches[0];
    if (run->stretch_count > 0)
        run->way = smaller(s->way + s->speed * s->speed / (-2 * s->acceleration), part->length);
    stand(run, state_when_stopped(run));
    return 0;
}

static void m_function(struct interp_run *run, const struct interp_part *part,
                       const struct interp_inputs *inputs, double *left)
{
    if (part->code > M_CONTINUOUS || part->code == M_OPTIONAL) {
        if (part->code != M_OPTIONAL)
            run->signal(run->argument, part);
        next_part(run);
        return;
    }
    run->speed = 0;
    run->phase = INTERP_STANDS;
    if (run->state != INTERP_RUNNING) {
        stand(run, state_when_stopped(run));
    } else if (part->code == M_STOP) {
        next_part(run);
        stand(run, INTERP_READY);
    } else if (run->m_signalled && inputs->m_done) {
        next_part(run);
        return;
    } else if (!run->m_signalled && run->m_waited++ >= inputs->m_delay) {
        run->m_signalled = true;
        run->wait = INTERP_M_SIGNALLED;
        run->signal(run->argument, part);
    } else if (run->m_signalled) {
        run->wait = INTERP_M_END;
    }
    *left = 0;
}

static void wait_for_pulse(struct interp_run *run, const struct interp_part *part,
                           const struct interp_inputs *inputs, double *left)
{
    run->speed = 0;
    run->phase = INTERP_STANDS;
    if (run->state != INTERP_RUNNING) {
        run->wait = INTERP_NO_WAIT;
        stand(run, state_when_stopped(run));
        *left = 0;
    } else if (inputs->external >= part->external) {
        next_part(run);
    } else {
        run->wait = INTERP_PULSE;
        *left = 0;
    }
}

static void run_step(struct interp_run *run, const struct interp_inputs *inputs)
{
    double left = inputs->step;
    while (left > 0 && interp_run_is_active(run)) {
        const struct interp_part *part = interp_run_part(run);
        if (part == NULL) {
            if (run->state == INTERP_RUNNING)
                stand(run, run->path->more ? INTERP_STARVED : INTERP_ENDED);
            else
                stand(run, state_when_stopped(run));
        } else if (part->kind == INTERP_M) {
            m_function(run, part, inputs, &left);
        } else if (part->kind == INTERP_WAIT) {
            wait_for_pulse(run, part, inputs, &left);
        } else {
            left = advance(run, part, left, inputs->step);
        }
    }
}

static void locate(struct interp_run *run)
{
    const struct interp_part *part = interp_run_part(run);
    if (part != NULL)
        interp_part_position(part, run->way, run->position);
    else if (run->path->count > 0)
        memcpy(run->position, interp_path_end(run->path), sizeof run->position);
}

void interp_run_step(struct interp_run *run, const struct interp_inputs *inputs)
{
    if (run->override != inputs->override || run->acceleration != inputs->acceleration)
        run->planned = false;
    run->override = inputs->override;
    run->acceleration = inputs->acceleration;
    if (!interp_run_is_active(run))
        return;
    run_step(run, inputs);
    locate(run);
    if (run->drop && !interp_run_is_active(run))
        interp_run_drop(run);
}

/* --- start and stop --- */

static bool is_there(const struct interp_run *run, const double point[INTERP_AXES])
{
    for (unsigned i = 0; i < INTERP_AXES; i++)
        if (fabs(run->position[i] - point[i]) > 1e-9)
            return false;
    return true;
}

static void connect(struct interp_run *run, const double point[INTERP_AXES])
{
    struct interp_part *line = &run->connection;
    double sum = 0;
    *line = (struct interp_part){ .kind = INTERP_RAPID, .feed = run->path->limits.rapid };
    memcpy(line->start, run->position, sizeof line->start);
    memcpy(line->end, point, sizeof line->end);
    for (unsigned i = 0; i < INTERP_AXES; i++)
        sum += (line->end[i] - line->start[i]) * (line->end[i] - line->start[i]);
    line->length = sqrt(sum);
    run->connecting = true;
    run->way = 0;
}

bool interp_run_start(struct interp_run *run)
{
    double point[INTERP_AXES];
    if (interp_run_is_active(run) || run->state == INTERP_ENDED || run->part >= run->path->count)
        return false;
    if (!run->connecting)
        run->resume = run->way;
    interp_part_position(&run->path->parts[run->part], run->resume, point);
    run->connecting = false;
    run->way = run->resume;
    if (!is_there(run, point))
        connect(run, point);
    run->planned = run->drop = false;
    run->speed = 0;
    run->state = INTERP_RUNNING;
    return true;
}

void interp_run_stop(struct interp_run *run, bool emergency, bool drop)
{
    if (!interp_run_is_active(run)) {
        if (emergency)
            run->state = INTERP_EMERGENCY;
        if (drop)
            interp_run_drop(run);
        return;
    }
    run->drop = run->drop || drop;
    if (emergency)
        run->state = INTERP_BRAKING;
    else if (run->state == INTERP_RUNNING)
        run->state = INTERP_STOPPING;
    run->planned = false;
}
