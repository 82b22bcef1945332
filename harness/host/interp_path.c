/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/interp_path.h"

#include <errno.h>
#include <math.h>
#include <string.h>

#include "host/angle.h"

const struct interp_limits interp_limits_default = {
    .acceleration = 1000, .deceleration = 1000, .emergency = 5000, .rapid = 200, .corner = 5 / 180.
};

void interp_path_init(struct interp_path *path, struct interp_part *parts, size_t capacity)
{
    *path = (struct interp_path){ .limits = interp_limits_default,
                                  .parts = parts,
                                  .capacity = capacity };
}

const double *interp_path_end(const struct interp_path *path)
{
    return path->count > 0 ? path->parts[path->count - 1].end : path->start;
}

void interp_plane_axes(enum interp_plane plane, unsigned axes[2])
{
    axes[0] = plane == INTERP_YZ ? 1 : 0;
    axes[1] = plane == INTERP_XY ? 1 : 2;
}

static bool is_speed(double value)
{
    return value >= INTERP_LEAST && value <= INTERP_LARGEST;
}

const char *interp_limits_wrong(const struct interp_limits *limits)
{
    if (!is_speed(limits->acceleration) || !is_speed(limits->deceleration) ||
        !is_speed(limits->emergency) || !is_speed(limits->rapid))
        return "a speed or acceleration is not positive";
    if (limits->emergency < limits->deceleration)
        return "the emergency ramp is slower than the normal one";
    if (!(limits->corner >= 0 && limits->corner <= 1))
        return "the corner is not between 0 and 180 degrees";
    for (unsigned i = 0; i < INTERP_AXES; i++)
        if (!(fabs(limits->backlash[i]) <= INTERP_LARGEST))
            return "a backlash is too large";
    return limits->backlash_step >= 0 && limits->backlash_step <= INTERP_LARGEST
               ? NULL
               : "the step of the backlash is negative";
}

bool interp_arc_centre(const double start[2], const double end[2], double radius, bool clockwise,
                       double centre[2])
{
    const double x = end[0] - start[0], y = end[1] - start[1], chord = sqrt(x * x + y * y);
    const double half = chord / 2, size = fabs(radius);
    if (!(chord > 0) || !(size <= INTERP_LARGEST) || size < half * (1 - 1e-9))
        return false;
    const double away = size > half ? sqrt((size - half) * (size + half)) : 0;
    /* To the left of the chord lies the centre of the short arc that goes counter-clockwise. */
    const double left = (clockwise ? -away : away) * (radius < 0 ? -1 : 1);
    centre[0] = start[0] + x / 2 - left * y / chord;
    centre[1] = start[1] + y / 2 + left * x / chord;
    return true;
}

static double length_of_line(const struct interp_part *part, unsigned without, unsigned without_too)
{
    double sum = 0;
    for (unsigned i = 0; i < INTERP_AXES; i++)
        if (i != without && i != without_too)
            sum += (part->end[i] - part->start[i]) * (part->end[i] - part->start[i]);
    return sqrt(sum);
}

static double arc_length(const struct interp_part *part)
{
    return (part->radius + part->end_radius) / 2 * ANGLE_PI * fabs(part->sweep);
}

static const char *complete_arc(struct interp_part *part)
{
    unsigned axes[2];
    double from[2], to[2];
    interp_plane_axes(part->plane, axes);
    for (int i = 0; i < 2; i++) {
        if (!(fabs(part->centre[i]) <= INTERP_LARGEST))
            return "the centre is too far away";
        from[i] = part->start[axes[i]] - part->centre[i];
        to[i] = part->end[axes[i]] - part->centre[i];
    }
    part->radius = sqrt(from[0] * from[0] + from[1] * from[1]);
    part->end_radius = sqrt(to[0] * to[0] + to[1] * to[1]);
    if (!(part->radius > INTERP_OFF_CIRCLE))
        return "the arc has no radius";
    if (fabs(part->radius - part->end_radius) > INTERP_OFF_CIRCLE)
        return "the end of the arc is not as far from its centre as the start";
    part->start_angle = angle_of(from[0], from[1]);
    part->sweep = angle_of(to[0], to[1]) - part->start_angle;
    if (part->kind == INTERP_CCW && part->sweep <= 0)
        part->sweep += 2;
    if (part->kind == INTERP_CW && part->sweep >= 0)
        part->sweep -= 2;
    const double arc = arc_length(part), beside = length_of_line(part, axes[0], axes[1]);
    part->length = sqrt(arc * arc + beside * beside);
    return NULL;
}

static const char *complete(const struct interp_path *path, struct interp_part *part)
{
    const bool goes = part->kind <= INTERP_CCW;
    memcpy(part->start, interp_path_end(path), sizeof part->start);
    if (!goes)
        memcpy(part->end, part->start, sizeof part->end);
    part->length = part->radius = part->end_radius = part->start_angle = part->sweep = 0;
    for (unsigned i = 0; i < INTERP_AXES; i++)
        if (!(fabs(part->end[i]) <= INTERP_LARGEST))
            return "a coordinate is too large";
    switch (part->kind) {
    case INTERP_LINE:
    case INTERP_CW:
    case INTERP_CCW:
        if (!is_speed(part->feed))
            return "the feed is not positive";
        if (interp_part_is_arc(part))
            return complete_arc(part);
        break;
    case INTERP_RAPID:
        break;
    case INTERP_DWELL:
        return part->dwell >= 0 && part->dwell <= INTERP_LARGEST ? NULL : "no such time";
    case INTERP_M:
        return part->code >= 0 && part->code != 1000 ? NULL
                                                     : "M functions are 0 to 999 and from 1001 on";
    case INTERP_WAIT:
        return NULL;
    default:
        return "no such kind of part";
    }
    part->length = length_of_line(part, INTERP_AXES, INTERP_AXES);
    return NULL;
}

int interp_path_add(struct interp_path *path, const struct interp_part *part, const char **what)
{
    *what = "the path has more parts than the buffer";
    if (path->count >= path->capacity)
        return -ENOSPC;
    struct interp_part next = *part;
    if (next.kind == INTERP_RAPID)
        next.feed = path->limits.rapid;
    *what = complete(path, &next);
    if (*what != NULL)
        return -EINVAL;
    path->parts[path->count++] = next;
    return 0;
}

void interp_part_position(const struct interp_part *part, double way, double position[INTERP_AXES])
{
    if (!(way < part->length) || way <= 0) {
        memcpy(position, way <= 0 && part->length > 0 ? part->start : part->end,
               sizeof part->start);
        return;
    }
    const double u = way / part->length;
    for (unsigned i = 0; i < INTERP_AXES; i++)
        position[i] = part->start[i] + (part->end[i] - part->start[i]) * u;
    if (interp_part_is_arc(part)) {
        const double angle = part->start_angle + part->sweep * u;
        const double radius = part->radius + (part->end_radius - part->radius) * u;
        unsigned axes[2];
        interp_plane_axes(part->plane, axes);
        position[axes[0]] = part->centre[0] + radius * angle_cosine(angle);
        position[axes[1]] = part->centre[1] + radius * angle_sine(angle);
    }
}

void interp_part_tangent(const struct interp_part *part, double way, double tangent[INTERP_AXES])
{
    for (unsigned i = 0; i < INTERP_AXES; i++)
        tangent[i] = (part->end[i] - part->start[i]) / part->length;
    if (interp_part_is_arc(part)) {
        const double u = way < part->length ? way / part->length : 1;
        const double angle = part->start_angle + part->sweep * u;
        const double along = arc_length(part) / part->length * (part->sweep < 0 ? -1 : 1);
        unsigned axes[2];
        interp_plane_axes(part->plane, axes);
        tangent[axes[0]] = -along * angle_sine(angle);
        tangent[axes[1]] = along * angle_cosine(angle);
    }
}
