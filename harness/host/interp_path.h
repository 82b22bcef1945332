/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * interp_path.h - the way of an interpolator: a row of parts, lines and arcs with M functions and
 * pauses between them; lengths, positions and tangents. Knows no time (interp_run.h) and no
 * registers (interpolator.c).
 *
 * Lengths are in mm, speeds in mm/s, angles in half turns. Axes are numbered as TG Motion does:
 * X Y Z C B U V W A O = 0..9. Whatever one of them turns or moves, the length of a line is the root
 * of the sum of the squares of all ten.
 */
#ifndef HARNESS_HOST_INTERP_PATH_H
#define HARNESS_HOST_INTERP_PATH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define INTERP_AXES    10
#define INTERP_LETTERS 26
#define INTERP_LARGEST 1e9  /* of any coordinate, speed or acceleration */
#define INTERP_LEAST   1e-9 /* of a speed or acceleration */
/* How far the two ends of an arc may be from its centre, one more than the other, mm. */
#define INTERP_OFF_CIRCLE 0.001

/* The first five are the number of the G function. */
enum interp_kind {
    INTERP_RAPID,
    INTERP_LINE,
    INTERP_CW,
    INTERP_CCW,
    INTERP_DWELL,
    INTERP_M,
    INTERP_WAIT /* for the external position */
};

enum interp_plane { INTERP_XY = 17, INTERP_XZ = 18, INTERP_YZ = 19 };

/* One part. What is not said to belong to a kind, every part has. */
struct interp_part {
    enum interp_kind kind;
    double end[INTERP_AXES]; /* rapid, line, arc; of other parts interp_path_add() fills it */
    double feed;             /* line, arc */
    enum interp_plane plane; /* arc: from its first axis to its second is counter-clockwise */
    double centre[2];        /* arc, absolute */
    int32_t code;            /* M: its number; 0 and 1 are not signalled, 1000 is none */
    double dwell;            /* dwell: seconds */
    int32_t external;        /* wait: goes on when the external position is not below it */
    double letters[INTERP_LETTERS]; /* parameters A to Z */
    uint32_t tool, correction;      /* 41, 42, otherwise none */
    uint32_t line;                  /* of the text it is from */

    /* Filled by interp_path_add(). */
    double start[INTERP_AXES];
    double length; /* 0: does not move */
    double radius, end_radius, start_angle, sweep;
};

struct interp_limits {
    double acceleration, deceleration, emergency; /* mm/s2, along the path */
    double rapid;                                 /* mm/s */
    double corner; /* half turns: up to this change of direction the speed is kept */
    /* Of every axis, increments: what it has to go more after it has turned round, and how much of
     * it in a step of the interpolator. */
    double backlash[INTERP_AXES], backlash_step;
};

extern const struct interp_limits interp_limits_default;

/* The caller owns `parts`, of which there are `capacity`. */
struct interp_path {
    struct interp_limits limits;
    double start[INTERP_AXES];
    struct interp_part *parts;
    size_t count, capacity;
    bool more; /* is still being filled: its end is not the end of the program */
};

void interp_path_init(struct interp_path *path, struct interp_part *parts, size_t capacity);

/* Appends a part, and fills what follows from those before. 0, -ENOSPC, or -EINVAL with what is
 * wrong with it. */
int interp_path_add(struct interp_path *path, const struct interp_part *part, const char **what);
/* NULL, or what is wrong with the limits. */
const char *interp_limits_wrong(const struct interp_limits *limits);

/* Where the path ends so far. */
const double *interp_path_end(const struct interp_path *path);

/* The centre of an arc from start to end (both in its plane); a negative radius is the longer one
 * of the two arcs. False when there is none. */
bool interp_arc_centre(const double start[2], const double end[2], double radius, bool clockwise,
                       double centre[2]);
/* The two axes of a plane. */
void interp_plane_axes(enum interp_plane plane, unsigned axes[2]);

/* Goes somewhere, takes time doing so. */
static inline bool interp_part_moves(const struct interp_part *part)
{
    return part->length > 0;
}

static inline bool interp_part_is_arc(const struct interp_part *part)
{
    return part->kind == INTERP_CW || part->kind == INTERP_CCW;
}

/* A point of it, `way` mm from its start; past the ends: the ends, exactly. */
void interp_part_position(const struct interp_part *part, double way, double position[INTERP_AXES]);
/* The direction there, of length 1; the part moves. */
void interp_part_tangent(const struct interp_part *part, double way, double tangent[INTERP_AXES]);

#endif
