/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/host_parts.h"

const struct host_part *const host_parts[HOST_PARTS_MOST] = {
    &host_digest, /* what the cycle before left behind */
    &host_console,
    &host_timers,
    &host_statistics,
    &host_eeprom,
    &host_can,
    &host_safety,
    &host_interpolator, /* its positions are set-points of the servos */
    &host_watch,        /* what is about to leave */
    &host_servo,
    &host_servo_outputs,
    &host_unable,
    &host_capture,
    &host_motion,
    &host_dio,
    &host_general,
    &host_channels,
    &host_scope,
    &host_measure,
    &host_scene, /* behind all that receives */
    NULL,
};
