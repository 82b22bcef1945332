/* SPDX-License-Identifier: GPL-2.0-or-later */
/* interpolator.h - what an interpolator remembers beside its registers; included by host_parts.h.
 */
#ifndef HARNESS_HOST_INTERPOLATOR_H
#define HARNESS_HOST_INTERPOLATOR_H

#include "host/interp_filter.h"
#include "host/interp_run.h"

#define INTERPOLATORS_MOST   3
#define INTERPOLATOR_BUFFER  2000 /* parts, unless configured */
#define INTERPOLATOR_SIGNALS 16   /* continuous M functions on their way through the spline */

struct interpolator {
    INTERPOLATOR *reg;
    bool asleep;     /* the last step left it at rest, with nothing to come */
    bool still;      /* nothing moved in the last full step, and nothing was about to */
    double override; /* the last usable Rel_Speed */
    double position[INTERP_AXES]; /* after the filters, of the last step */
    double backlash[INTERP_AXES];
    struct interp_path path; /* its parts are the interpolator's own */
    struct interp_run run;
    struct interp_spline spline;
    struct interp_iir iir;
    double jerk; /* mm/s3, limit of the spline; 0: none */

    bool backwards[INTERP_AXES];

    int32_t command; /* a stop that is being carried out, as it was written; 0: none */
    /* Continuous M functions, which come out as late as the positions do. */
    struct {
        int32_t code;
        unsigned steps; /* until then */
    } signals[INTERPOLATOR_SIGNALS];
    unsigned signal_count;
    uint32_t history; /* newest entry of Cont_MFunc_History */
    /* What LookAheadBuffer shows, unless it is out of date. */
    bool looked;
    size_t looked_from, looked_count;
};

#endif
