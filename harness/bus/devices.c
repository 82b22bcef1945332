/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/device.h"
#include "bus/library.h"

#include <string.h>

extern const struct device_type dev_drive_cia402;
extern const struct device_type dev_drive_cia402x2;
extern const struct device_type dev_drive_heavy;
extern const struct device_type dev_drive_rotary;
extern const struct device_type dev_drive_ideal;
extern const struct device_type dev_tgz_1;
extern const struct device_type dev_tgz_2;
extern const struct device_type dev_tgz_1_native;
extern const struct device_type dev_tgz_2_native;
extern const struct device_type dev_dio_8x8;

static const struct device_type *const types[] = {
    &dev_drive_cia402, &dev_drive_cia402x2, &dev_drive_heavy,  &dev_drive_rotary, &dev_drive_ideal,
    &dev_tgz_1,        &dev_tgz_2,          &dev_tgz_1_native, &dev_tgz_2_native, &dev_dio_8x8,
};

const struct device_type *device_type(size_t index)
{
    return index < sizeof types / sizeof *types ? types[index] : NULL;
}

const struct device_type *device_type_find(const char *name)
{
    const struct device_type *type;

    for (size_t i = 0; (type = device_type(i)); i++) {
        if (strcmp(type->name, name) == 0)
            return type;
    }
    return NULL;
}

const struct device_type *library_find(const struct bus_library *library, const char *name)
{
    (void)library;
    return device_type_find(name);
}

const char *bus_device_type(size_t index, const char **description)
{
    const struct device_type *type = device_type(index);

    if (description)
        *description = type ? type->description : NULL;
    return type ? type->name : NULL;
}
