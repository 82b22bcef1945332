/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/host.h"

static const struct bus_stimulus button = { .bit = 0,
                                            .period_ns = 400000000,
                                            .phase_ns = 100000000 };
static const struct bus_device default_devices[] = {
    { .type = "drive-cia402" },
    { .type = "dio-8x8", .stimuli = &button, .stimulus_count = 1 },
};
const struct plant plant_default = {
    .devices = default_devices, .device_count = 2, .servos = 1, .dios = 1
};

const struct servo_modes servo_modes_default = {
    .off = 0, .position = 1, .pg = 2, .gear = 3, .pg_gear = 4, .interpolator = 5, .user = 9
};
