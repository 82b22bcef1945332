/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Formats of modules, whatever they are: nothing is written past the buffer, the result tells how
 * much was, and the text ends with 0. Input: capacity, then numbers for the arguments, then the
 * format.
 *
 * Where the format may ask for text all arguments are pointers to text.
 */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "host/text16.h"

#define ARGUMENTS 64
#define FORMAT    256
#define ROOM      512
#define MARK      0xA5A5

static const uint16_t a_text[] = { 'w', 0x20AC, 0xD800, 'x', 0 };

struct slots {
    uint64_t value[ARGUMENTS];
};

static int format_with(uint16_t *out, size_t capacity, const uint16_t *format, struct slots *slots)
{
    struct arguments arguments;
    arguments_from_values(&arguments, slots->value, ARGUMENTS);
    return text16_vformat(out, capacity, format, &arguments);
}

/* At most one argument for each unit of a format, and one more for '*'. */
static size_t read_format(uint16_t *format, const uint8_t *data, size_t size, int *texts)
{
    size_t count = 0;
    unsigned takers = 0;
    for (; count < FORMAT - 1 && 2 * count + 1 < size; count++) {
        const uint16_t unit = (uint16_t)(data[2 * count] | (data[2 * count + 1] & 1) << 8);
        takers += unit == '%' || unit == '*';
        if (takers > ARGUMENTS)
            break;
        *texts |= unit == 's' || unit == 'S';
        format[count] = unit;
    }
    format[count] = 0;
    return count;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint16_t out[ROOM], format[FORMAT];
    struct slots slots;
    char narrow[64];
    int texts = 0;
    if (size < 18)
        return 0;
    const size_t capacity = (data[0] | data[1] << 8) % (ROOM - 1);
    for (size_t i = 0; i < ARGUMENTS; i++)
        memcpy(&slots.value[i], data + 2 + 8 * (i % 2), 8);
    read_format(format, data + 18, size - 18, &texts);
    for (size_t i = 0; texts && i < ARGUMENTS; i++)
        slots.value[i] = (uint64_t)(uintptr_t)a_text;
    for (size_t i = 0; i < ROOM; i++)
        out[i] = MARK;
    const int result = format_with(out, capacity, format, &slots);
    for (size_t i = capacity; i < ROOM; i++)
        if (out[i] != MARK)
            abort();
    if (capacity == 0)
        return result == -1 ? 0 : (abort(), 0);
    if (result < -1 || result >= (int)capacity)
        abort();
    if (result >= 0 && out[result] != 0)
        abort();
    size_t length = 0;
    while (length < capacity && out[length] != 0)
        length++;
    if (length == capacity)
        abort();
    if (text16_to_utf8(narrow, sizeof narrow, out) >= sizeof narrow)
        abort();
    return 0;
}
