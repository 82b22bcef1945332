/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * libFuzzer target: any frames at a segment of one slave of every kind, with time, cables, power,
 * damage and faults in between (segment_ops.h). Every input starts from the same fresh segment and
 * ends with a power cycle, after which everybody has to answer.
 */
#define SEGMENT_OPS_EXACT
#include "segment_ops.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct field field;

    if (!field.count)
        field_init(&field);
    else
        field_reset(&field);
    field_run(&field, data, size);
    check_revival(&field);
    return 0;
}
