/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/gear_motion.h"

#include <math.h>
#include <string.h>

double gear_ramp(double value, double wanted, double step)
{
    if (!(step > 0) || fabs(wanted - value) <= step)
        return wanted;
    return wanted > value ? value + step : value - step;
}

void gear_link_set(struct gear_link *link, double position)
{
    *link = (struct gear_link){ .last_position = position };
}

double gear_link_step(struct gear_link *link, double source, double in, double out)
{
    if (!link->holds)
        link->last_source = source;
    if (!link->holds || link->in != in || link->out != out) {
        link->holds = true;
        link->in = in;
        link->out = out;
        link->source = link->last_source;
        link->position = link->last_position;
    }
    const double position = link->position + (source - link->source) * in / out;
    if (!isfinite(position)) { /* the source is no number, or `out` is 0 */
        gear_link_set(link, link->last_position);
        return link->last_position;
    }
    link->last_source = source;
    link->last_position = position;
    return position;
}

bool cam_pointer(double unwrapped, uint32_t length, double *pointer, double *turns)
{
    if (length == 0 || !(fabs(unwrapped) < 9.0e15))
        return false;
    double turn = floor(unwrapped / length);
    double place = unwrapped - turn * length;
    if (place < 0) { /* the division was rounded up */
        place += length;
        turn -= 1;
    } else if (place >= length) {
        place -= length;
        turn += 1;
    }
    *pointer = place;
    *turns = turn;
    return place >= 0 && place < length;
}

static double point(const struct cam *cam, uint32_t index)
{
    double value;
    memcpy(&value, (const char *)cam->memory + cam->line + (size_t)index * sizeof value,
           sizeof value);
    return value;
}

bool cam_value(const struct cam *cam, double pointer, double turns, double *value)
{
    if (cam->length == 0 || cam->line > cam->size ||
        cam->length > (cam->size - cam->line) / sizeof(double) ||
        !(pointer >= 0 && pointer < cam->length))
        return false;
    const uint32_t before = (uint32_t)pointer;
    const double left = point(cam, before);
    const double right =
        before + 1 < cam->length ? point(cam, before + 1) : point(cam, 0) + cam->increment;
    const double sum = left + (right - left) * (pointer - before) + turns * cam->increment;
    if (!isfinite(sum))
        return false;
    *value = sum;
    return true;
}

bool cam_output(void *memory, size_t size, uint32_t address, double value)
{
    if (size < sizeof value || address > size - sizeof value)
        return false;
    memcpy((char *)memory + address, &value, sizeof value);
    return true;
}
