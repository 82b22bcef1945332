/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/profile_motion.h"

#include <math.h>

/* A brake that is too long by this part is one that just fits: rounding, after a change halfway. */
#define FITS (1 + 1e-9)

void profile_set(struct profile *profile, double position, double speed)
{
    profile->position = position;
    profile->speed = speed;
    profile->acceleration = 0;
    profile->ready = profile->braking = profile->planned = false;
}

static bool usable(const struct profile_wanted *w)
{
    return fabs(w->destination) <= PROFILE_LARGEST && fabs(w->speed) <= PROFILE_LARGEST &&
           w->acceleration <= PROFILE_LARGEST && w->acceleration >= 1 / PROFILE_LARGEST;
}

/* What the type makes of the wanted values; what does not count for the mode is taken out, so that
 * its change is none. */
static struct profile_wanted effective(const struct profile_wanted *wanted)
{
    struct profile_wanted w = *wanted;
    if (!(w.deceleration <= PROFILE_LARGEST && w.deceleration >= 1 / PROFILE_LARGEST) ||
        w.type == 1)
        w.deceleration = w.acceleration;
    if (w.type == 2)
        w.acceleration = w.deceleration = fmin(w.acceleration, w.deceleration);
    if (w.type != 4 || !(w.percent >= 0))
        w.percent = 0;
    if (w.positioning)
        w.speed = fabs(w.speed);
    else
        w.destination = 0;
    return w;
}

static bool same(const struct profile_wanted *a, const struct profile_wanted *b)
{
    return a->positioning == b->positioning && a->destination == b->destination &&
           a->speed == b->speed && a->acceleration == b->acceleration &&
           a->deceleration == b->deceleration && a->type == b->type && a->percent == b->percent;
}

/* What is left of a ramp between two speeds when the part `begun` lies behind. */
static struct profile_segment ramp(const struct profile *p, double from, double to, double begun)
{
    const double change = (to - from) / (1 - profile_shape_speed(&p->shape, begun));
    const bool braking = fabs(to) < fabs(from);
    const double limit = braking ? p->wanted.deceleration : p->wanted.acceleration;
    const double time = p->shape.peak * fabs(change) / limit;
    return (struct profile_segment){ .lasts = (1 - begun) * time,
                                     .from = to - change,
                                     .change = change,
                                     .time = time,
                                     .begun = begun,
                                     .begun_way = profile_shape_way(&p->shape, begun),
                                     .braking = braking };
}

/* How much of such a ramp lies behind, so that the present acceleration goes on. */
static double begun(const struct profile *p, double from, double to)
{
    const double limit = fabs(to) < fabs(from) ? p->wanted.deceleration : p->wanted.acceleration;
    const double present = to < from ? -p->acceleration : p->acceleration;
    return profile_shape_onset(&p->shape, present / limit);
}

static struct profile_segment constant(double speed, double way)
{
    return (struct profile_segment){ .lasts = way / speed, .from = speed };
}

static double way_of(const struct profile_segment *s)
{
    return s->from * s->lasts + s->change * s->time * (0.5 - s->begun_way);
}

static void add(struct profile *p, struct profile_segment segment)
{
    if (!(segment.lasts > 0))
        return;
    if (segment.time == 0)
        segment.begun_way = 0.5; /* way_of(): no ramp, no way of one */
    segment.begins = p->ends;
    segment.position = p->end_position;
    p->segments[p->count++] = segment;
    p->ends += segment.lasts;
    p->end_position += way_of(&segment);
}

/* The speed from which the way is just enough to brake: what both ramps take is a polynomial of the
 * speed w that the first one adds. */
static double top_speed(const struct profile *p, double speed, double begun_up, double way)
{
    const double peak = p->shape.peak, brake = peak / (2 * p->wanted.deceleration);
    const double rest = 1 - profile_shape_speed(&p->shape, begun_up);
    const double time = peak / (p->wanted.acceleration * rest); /* for each unit of speed */
    const double lasts = (1 - begun_up) * time;
    const double loss =
        time / rest * ((1 - begun_up) - (0.5 - profile_shape_way(&p->shape, begun_up)));
    /* (lasts - loss + brake) w^2 + (lasts + 2 brake) speed w + brake speed^2 - way = 0 */
    const double a = lasts - loss + brake, b = (lasts + 2 * brake) * speed;
    const double c = brake * speed * speed - way;
    const double root = b + sqrt(b * b - 4 * a * c);
    return c < 0 && root > 0 ? speed - 2 * c / root : speed;
}

/* The present brake goes on, with less of it behind than its deceleration says, where the way
 * demands it. */
static double late_brake(const struct profile *p, double speed, double way, double most)
{
    double low = 0, high = most;
    for (int i = 0; i < 60 && high > low; i++) {
        const double middle = (low + high) / 2;
        const struct profile_segment brake = ramp(p, speed, 0, middle);
        if (fabs(way_of(&brake)) > way)
            low = middle;
        else
            high = middle;
    }
    return high;
}

static void stretch(struct profile_segment *segment, double by)
{
    segment->lasts *= by;
    segment->time *= by;
}

/* From a speed towards the destination that allows to stop there; direction is 1 or -1, speed and
 * way are counted in it. */
static void approach(struct profile *p, double direction, double speed, double way)
{
    const double whole = p->shape.peak * speed * speed / (2 * p->wanted.deceleration);
    if (way < whole) {
        const double most = begun(p, direction * speed, 0);
        add(p, ramp(p, direction * speed, 0, late_brake(p, speed, way, most)));
        return;
    }
    const double limit = p->wanted.speed;
    const double up = begun(p, direction * speed, direction * (speed + 1));
    double top = limit < speed ? limit : top_speed(p, speed, up, way);
    const bool limited = top >= limit;
    top = direction * (limited ? limit : top);
    struct profile_segment first =
        ramp(p, direction * speed, top, begun(p, direction * speed, top));
    struct profile_segment last = ramp(p, top, 0, 0);
    const double ramps = fabs(way_of(&first)) + fabs(way_of(&last));
    if (limited && p->wanted.type == 2 && ramps > 0) {
        stretch(&first, way / ramps);
        stretch(&last, way / ramps);
    }
    add(p, first);
    if (limited && p->wanted.type != 2 && top != 0)
        add(p, constant(top, direction * (way - ramps)));
    add(p, last);
}

static void brake(struct profile *p)
{
    add(p, ramp(p, p->speed, 0, begun(p, p->speed, 0)));
    p->acceleration = 0;
}

static void plan_position(struct profile *p)
{
    const double destination = p->wanted.destination;
    double way = destination - p->position, speed = p->speed;
    if (speed != 0) {
        const struct profile_segment stop = ramp(p, speed, 0, begun(p, speed, 0));
        const double needs = way_of(&stop);
        const bool in_time = needs > 0 ? way * FITS >= needs : way * FITS <= needs;
        if (!in_time || p->wanted.speed == 0) {
            brake(p);
            way = destination - p->end_position;
            speed = 0;
        }
    }
    p->end_speed = 0;
    p->reaches = p->wanted.speed > 0 || way == 0;
    if (!p->reaches)
        return;
    const double direction = way < 0 || (way == 0 && speed < 0) ? -1 : 1;
    approach(p, direction, direction * speed, direction * way);
    p->end_position = destination;
}

static void plan_speed(struct profile *p)
{
    const double target = p->wanted.speed;
    double speed = p->speed;
    if (speed * target < 0) {
        brake(p);
        speed = 0;
    }
    add(p, ramp(p, speed, target, begun(p, speed, target)));
    p->end_speed = target;
    p->reaches = true;
}

static void plan(struct profile *p, const struct profile_wanted *wanted)
{
    p->wanted = *wanted;
    p->shape = profile_shape_of(wanted->type, wanted->percent);
    p->planned = true;
    p->count = 0;
    p->step = 0;
    p->ends = 0;
    p->end_position = p->position;
    if (wanted->positioning)
        plan_position(p);
    else
        plan_speed(p);
}

static void evaluate(struct profile *p, const struct profile_segment *s, double time)
{
    p->braking = s->braking;
    if (s->time == 0) {
        p->position = s->position + s->from * time;
        p->speed = s->from;
        p->acceleration = 0;
        return;
    }
    double u = s->begun + time / s->time;
    if (u > 1)
        u = 1;
    p->position = s->position + s->from * time +
                  s->change * s->time * (profile_shape_way(&p->shape, u) - s->begun_way);
    p->speed = s->from + s->change * profile_shape_speed(&p->shape, u);
    p->acceleration = s->change / s->time * profile_shape_rate(&p->shape, u);
}

static void at_time(struct profile *p, double time)
{
    for (unsigned i = 0; i < p->count; i++)
        if (time < p->segments[i].begins + p->segments[i].lasts) {
            evaluate(p, &p->segments[i], time - p->segments[i].begins);
            p->ready = false;
            return;
        }
    p->position = p->end_position + p->end_speed * (time - p->ends);
    p->speed = p->end_speed;
    p->acceleration = 0;
    p->braking = false;
    p->ready = p->reaches;
}

void profile_step(struct profile *p, const struct profile_wanted *wanted, double cycle)
{
    const struct profile_wanted now = effective(wanted);
    if (usable(&now) && (!p->planned || !same(&now, &p->wanted)))
        plan(p, &now);
    if (!p->planned) {
        p->speed = p->acceleration = 0;
        return;
    }
    p->step++;
    at_time(p, (double)p->step * cycle);
}

void profile_shift(struct profile *p, double by)
{
    p->position += by;
    if (!p->planned)
        return;
    p->end_position += by;
    if (p->wanted.positioning)
        p->wanted.destination += by;
    for (unsigned i = 0; i < p->count; i++)
        p->segments[i].position += by;
}
