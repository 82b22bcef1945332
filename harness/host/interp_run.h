/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * interp_run.h - how an interpolator moves along its path: speed with trapezoidal ramps,
 * look-ahead, waiting, stopping. Step after step, without registers.
 *
 * A part is planned when it begins, or when something changes in it, and is then only evaluated:
 * within a part nothing is summed up. Its speed rises to the feed times the override and falls so
 * that every speed ahead can be met: at a joint the lower feed of both, at a corner 0, in front of
 * a pause 0. Time that a part does not need to the end of a step belongs to the next one.
 */
#ifndef HARNESS_HOST_INTERP_RUN_H
#define HARNESS_HOST_INTERP_RUN_H

#include "host/interp_path.h"

#define INTERP_LOOK_AHEAD 256 /* parts; what is behind them counts as a stop */

enum interp_state {
    INTERP_EMPTY,     /* nothing to run */
    INTERP_READY,     /* stands on its path, or in front of it, and can be started */
    INTERP_RUNNING,   /* moves, or waits within the path */
    INTERP_STOPPING,  /* on the normal ramp */
    INTERP_BRAKING,   /* on the emergency ramp */
    INTERP_EMERGENCY, /* stands after it; can be started unless the path was dropped */
    INTERP_ENDED,     /* stands at the end */
    INTERP_STARVED    /* stands where a path that is still being filled ends so far */
};

enum interp_wait { INTERP_NO_WAIT, INTERP_M_SIGNALLED, INTERP_M_END, INTERP_PULSE };

/* Run_Flag's high half. */
enum interp_phase {
    INTERP_STANDS = 1,
    INTERP_ACCELERATES,
    INTERP_AT_SPEED,
    INTERP_DECELERATES,
    INTERP_NEXT_SPEED, /* a part with another speed began in this step */
    INTERP_LAST_DECELERATION,
    INTERP_EMERGENCY_RAMP
};

/* What a step needs to know. */
struct interp_inputs {
    double step;         /* s, always the same */
    double override;     /* > 0 */
    double acceleration; /* mm/s2: no ramp but the emergency ramp is steeper; or infinite */
    bool m_done;         /* the M function that was signalled has ended */
    unsigned m_delay;    /* steps between standing and signalling an M function */
    int32_t external;
};

/* An M function is reached. */
typedef void interp_signal(void *argument, const struct interp_part *part);

struct interp_stretch {
    double begins, way, speed, acceleration; /* the first two: of the plan, of the part */
};

struct interp_run {
    struct interp_path *path;
    interp_signal *signal;
    void *argument;

    enum interp_state state;
    enum interp_wait wait;
    bool drop;         /* no path any more when it stands */
    size_t part;       /* the running part, or where it will go on; path->count past the end */
    bool connecting;   /* on the way to where the path will go on */
    double resume;     /* how far in the part that is */
    double way;        /* in the running part */
    double speed;      /* mm/s */
    double passed;     /* length of all parts left behind since the path was loaded */
    unsigned m_waited; /* steps in front of an M function that is to be signalled */
    bool m_signalled;  /* the one of the running part */
    double dwelt;      /* s, of the running part */
    enum interp_phase phase;
    double position[INTERP_AXES];
    struct interp_part connection;

    /* The plan. */
    bool planned, stands_after, speed_changes;
    double override, acceleration;
    struct interp_stretch stretches[3];
    unsigned stretch_count;
    double ends, end_speed, first;
    uint64_t steps;
    double last_feed; /* of the last part that moved */
};

/* Stands there without a path. */
void interp_run_init(struct interp_run *run, struct interp_path *path, interp_signal *signal,
                     void *argument);
/* It is somewhere else now, without having moved. Only when it stands. */
void interp_run_place(struct interp_run *run, const double position[INTERP_AXES]);
/* The path has been filled anew; false while it moves. */
bool interp_run_load(struct interp_run *run);
/* Parts were added to the path. */
void interp_run_appended(struct interp_run *run);
/* From where it stands in a straight line to where the path goes on, if that is somewhere else, and
 * on. False when there is nothing to run, or it runs. */
bool interp_run_start(struct interp_run *run);
/* Brakes along the path; drop: what is left of it is forgotten then. */
void interp_run_stop(struct interp_run *run, bool emergency, bool drop);
/* Without a path, at once; only when it stands. */
void interp_run_drop(struct interp_run *run);

void interp_run_step(struct interp_run *run, const struct interp_inputs *inputs);

static inline bool interp_run_is_active(const struct interp_run *run)
{
    return run->state >= INTERP_RUNNING && run->state <= INTERP_BRAKING;
}

/* The part it is in, NULL at the end. */
const struct interp_part *interp_run_part(const struct interp_run *run);

#endif
