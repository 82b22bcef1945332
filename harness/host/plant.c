/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/host.h"

static const struct bus_stimulus button = { .bit = 0,
                                            .period_ns = 400000000,
                                            .phase_ns = 100000000 };
static const struct bus_device default_devices[] = {
    { .type = "drive-cia402" },
    { .type = "dio-8x8", .stimuli = &button, .stimulus_count = 1 },
};
const struct plant plant_default = { default_devices, 2, 1, 1 };
