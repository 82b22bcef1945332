/* SPDX-License-Identifier: GPL-2.0-or-later */
/* How large the shared memories are: the layout says what one element is, the product how many. */
#include "host/host.h"

#include <string.h>

static size_t elements(const struct catalogue_memory *memory, unsigned count)
{
    return memory->size / memory->count * count;
}

size_t host_memory_bytes(const struct host_config *config, const struct catalogue_memory *memory)
{
    const struct product *product = config->product;
    const struct {
        const char *name;
        size_t bytes;
    } rows[] = {
        { "TGM_Data", config->data_bytes != 0 ? config->data_bytes : DATA_BYTES },
        { "TGM_Oscilloscope", config->osc_bytes != 0 ? config->osc_bytes : product->osc_bytes },
        { "TGM_Servo", elements(memory, product->max_servo) },
        { "TGM_Dio", elements(memory, product->max_dio) },
        { "TGM_Interpolator", elements(memory, product->max_interpolator) },
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (strcmp(rows[i].name, memory->name) == 0)
            return rows[i].bytes;
    return memory->size;
}

bool host_has_register(const struct host_config *config, const struct catalogue_register *reg)
{
    const size_t bytes = host_memory_bytes(config, reg->memory);
    return reg->offset <= bytes && bytes - reg->offset >= scalar_size(reg->type);
}
