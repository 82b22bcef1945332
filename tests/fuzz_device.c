/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Descriptions of devices that nobody wrote: whatever the bytes are, reading ends with a device
 * type or with a complaint that names the file. What is read and written again means the same.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/description.h"
#include "bus/library.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Only mappings made of bytes need it, and terminals have none. */
uint32_t pdo_check(const struct od *od, void *device, uint16_t index, uint8_t subindex,
                   int64_t value)
{
    (void)od, (void)device, (void)index, (void)subindex, (void)value;
    return 0;
}

static void must(bool good)
{
    if (!good)
        abort();
}

static void run(const struct terminal_type *type)
{
    const struct device_type *device = &type->type;
    struct device_setup setup = { .type = device, .seed = 1 };
    uint8_t image[65536] = { 0 };
    void *instance = calloc(1, device->size);

    must(instance);
    if (device->od)
        od_reset(device->od, instance);
    device->init(instance, &setup);
    for (unsigned d = PDO_RX; device->od && d <= PDO_TX; d++)
        must(device->od->pdo[d].resolve(instance, (enum pdo_direction)d) == 0);
    for (unsigned i = 0; i < device->input_count; i++) {
        must(device->set_input(instance, i, 1) == 0);
        device->set_input(instance, i, INT64_MAX);
    }
    device->step(instance, 1000);
    device->outputs(instance, image, sizeof image, 1000);
    device->inputs(instance, image, sizeof image);
    device->pins(instance);
    device->watchdog(instance, 2000);
    free(instance);
}

static int take(void *argument, const struct description *d, char why[LIBRARY_WHY])
{
    struct terminal_type *type;
    char *text = NULL;
    size_t length = 0;
    FILE *stream;
    int error = description_build(d, &type, why);

    if (error)
        return error;
    run(type);
    free(type);
    if (argument)
        return 0;
    stream = open_memstream(&text, &length);
    must(stream);
    device_file_write(d, stream);
    fclose(stream);
    struct description *again = description_new("written");

    must(again);
    /* Texts may grow past the limits by their escapes; nothing else may go wrong. */
    if (device_file_read(again, text, length, why) == 0)
        must(take(again, again, why) == 0);
    free(again);
    free(text);
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char why[SCAN_WHY] = "";
    int error;

    if (size && data[0] == '<') {
        error = esi_read("fuzz", (const char *)data, size, NULL, take, NULL, why);
    } else {
        struct description *d = description_new("fuzz");

        must(d);
        error = device_file_read(d, (const char *)data, size, why);
        if (!error)
            error = take(NULL, d, why);
        free(d);
    }
    must(!error || strncmp(why, "fuzz", 4) == 0);
    return 0;
}
