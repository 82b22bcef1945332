/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * interp_filter.h - what lies between the calculated position of an interpolator and the one that
 * leaves it: the spline, which is a moving average, and behind it a second-order low-pass
 * (docs/decisions.md, M15).
 */
#ifndef HARNESS_HOST_INTERP_FILTER_H
#define HARNESS_HOST_INTERP_FILTER_H

#include "host/interp_path.h"

#define INTERP_SPLINE_LEAST 50
#define INTERP_SPLINE_MOST  500

/* The mean of the last `points` positions. Sums are taken of the way from a reference that is
 * renewed with every turn of the ring, so that rounding does not add up and what stands is met
 * exactly. */
struct interp_spline {
    unsigned points;      /* 0: off, positions pass */
    unsigned next, stood; /* stood: steps without motion, at most `points` */
    double reference[INTERP_AXES], sum[INTERP_AXES];
    double ring[INTERP_AXES][INTERP_SPLINE_MOST];
};

/* With so many points; as if it had always stood there. */
void interp_spline_set(struct interp_spline *spline, unsigned points,
                       const double position[INTERP_AXES]);
void interp_spline_step(struct interp_spline *spline, double position[INTERP_AXES]);

/*
 * H = q / ((f s)^2 + p f s + q), sampled without error for an input that is constant from step to
 * step. f is in seconds. What it keeps is how far it is from its input, so that it arrives exactly.
 */
struct interp_iir {
    uint32_t axes; /* bits: which axes it acts upon */
    double transition[2][2];
    double distance[INTERP_AXES], rate[INTERP_AXES], input[INTERP_AXES];
};

/* False, and nothing changed, when the parameters are not usable (each must be above 0). Axes = 0
 * switches off whatever they are. */
bool interp_iir_set(struct interp_iir *iir, double p, double q, double f, uint32_t axes,
                    double step, const double position[INTERP_AXES]);
void interp_iir_place(struct interp_iir *iir, const double position[INTERP_AXES]);
void interp_iir_step(struct interp_iir *iir, double position[INTERP_AXES]);

#endif
