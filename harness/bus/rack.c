/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/rack.h"
#include "bus/library.h"
#include "bus/spread.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int rack_fail(char why[BUS_WHY], int error, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(why, BUS_WHY, format, arguments);
    va_end(arguments);
    return error;
}

static int fill_place(struct rack *rack, const struct bus_config *config, size_t i,
                      char why[BUS_WHY])
{
    const struct bus_device *device = &config->devices[i];
    struct slave_setup setup = { .type = library_find(config->library, device->type),
                                 .seed = spread(config->seed + SPREAD_STEP * (i + 1)),
                                 .serial = (uint32_t)(i + 1),
                                 .stimuli = device->stimuli,
                                 .stimulus_count = device->stimulus_count,
                                 .identity = &device->identity,
                                 .alias = device->alias };

    if (!setup.type)
        return rack_fail(why, -EINVAL, "device %zu: no device type \"%s\"", i + 1, device->type);
    setup.device = rack->devices[i] = calloc(1, setup.type->size);
    if (!setup.device)
        return rack_fail(why, -ENOMEM, "no memory for device %zu", i + 1);
    if (slave_init(&rack->slaves[i], &setup))
        return rack_fail(why, -EINVAL, "device type \"%s\": its SII does not fit", device->type);
    return 0;
}

int rack_open(struct rack *rack, const struct bus_config *config, char why[BUS_WHY])
{
    int error = 0;

    memset(rack, 0, sizeof *rack);
    if (!config->device_count || config->device_count > BUS_MAX_SLAVES)
        return rack_fail(why, -EINVAL, "a bus has 1 to %d devices, not %zu", BUS_MAX_SLAVES,
                         config->device_count);
    rack->slaves = calloc(config->device_count, sizeof *rack->slaves);
    if (!rack->slaves)
        return rack_fail(why, -ENOMEM, "no memory for %zu slaves", config->device_count);
    for (size_t i = 0; i < config->device_count && !error; i++)
        error = fill_place(rack, config, i, why);
    if (error)
        rack_close(rack);
    else
        segment_init(&rack->segment, rack->slaves, config->device_count);
    return error;
}

void rack_close(struct rack *rack)
{
    for (size_t i = 0; i < BUS_MAX_SLAVES; i++)
        free(rack->devices[i]);
    free(rack->slaves);
    memset(rack, 0, sizeof *rack);
}
