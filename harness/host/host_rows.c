/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/host_parts.h"

const struct host_part *const host_parts[] = {
    &host_timers,
    &host_interpolator, /* its positions are set-points of the servos */
    &host_servo,
    &host_capture,
    &host_motion,
    &host_dio,
    &host_scope,
    NULL,
};
