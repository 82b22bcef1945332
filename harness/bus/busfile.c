/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/busfile.h"
#include "bus/library.h"
#include "bus/scan.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define BUSFILE_NAMES 2048 /* device types to look for a near one among */

struct reader {
    struct scan scan;
    struct busfile *to;
    const struct device_type *type; /* of the last device */
};

static bool use(struct reader *r)
{
    const char *name, *slash = strrchr(r->scan.file, '/');
    char path[4096], why[LIBRARY_WHY];
    int length;

    if (!scan_text(&r->scan, "the path of a device file or ESI file", &name))
        return false;
    if (*name == '/' || !slash)
        length = snprintf(path, sizeof path, "%s", name);
    else
        length =
            snprintf(path, sizeof path, "%.*s/%s", (int)(slash - r->scan.file), r->scan.file, name);
    if (length < 0 || (size_t)length >= sizeof path)
        return scan_fail(&r->scan, "the path is too long; expected at most %zu characters",
                         sizeof path - 1);
    if (library_load(r->to->library, path, why) == 0)
        return true;
    return scan_fail(&r->scan, "%s", why);
}

static bool ring(struct reader *r)
{
    r->to->redundant = true;
    return true;
}

static bool shape(struct reader *r, struct bus_stimulus *s)
{
    static const char *const words[] = { "phase", "amplitude", "offset" };
    const int64_t most = (int64_t)1 << 31;
    unsigned n;
    bool ok = true;

    while (ok && scan_more(&r->scan) &&
           (r->scan.token[r->scan.next].quoted ||
            strcmp(r->scan.token[r->scan.next].text, "input") != 0)) {
        if (!scan_choice(&r->scan, "phase, amplitude, offset or another input", words, 3, &n))
            return false;
        if (n == 0)
            ok = scan_duration(&r->scan, "a time", &s->phase_ns);
        else
            ok = scan_number(&r->scan, words[n], -most, most, n == 1 ? &s->amplitude : &s->offset);
    }
    return ok;
}

static bool channel(struct reader *r, unsigned *to)
{
    unsigned count = r->type->input_count;
    int64_t n;

    if (!r->type->set_input)
        return scan_fail(&r->scan, "\"%s\" has no inputs; expected a device with inputs",
                         r->type->name);
    /* A type that does not say how many inputs it has is asked when the bus runs. */
    if (!scan_number(&r->scan, "the number of an input", 0, count ? count - 1 : 255, &n))
        return false;
    *to = (unsigned)n;
    return true;
}

/* input 0 square 400ms phase 100ms */
static bool input(struct reader *r)
{
    static const char *const kinds[] = {
        "square", "triangle", "ramp", "sine", "noise", "constant"
    };
    static const enum bus_stimulus_kind kind[] = { BUS_SQUARE, BUS_TRIANGLE, BUS_RAMP,
                                                   BUS_SINE,   BUS_NOISE,    BUS_CONSTANT };
    struct bus_device *device = r->to->devices;
    struct bus_stimulus *s = &r->to->stimuli[r->to->stimulus_count];
    unsigned n;

    if (!r->to->device_count)
        return scan_fail(&r->scan, "an input of nothing; expected a device before it");
    device += r->to->device_count - 1;
    if (r->to->stimulus_count == BUSFILE_STIMULI)
        return scan_fail(&r->scan, "too many inputs; expected at most %d", BUSFILE_STIMULI);
    if (!channel(r, &s->bit) || !scan_choice(&r->scan, "the kind of signal", kinds, 6, &n))
        return false;
    s->kind = kind[n];
    if (s->kind == BUS_CONSTANT) {
        if (!scan_number(&r->scan, "the value", -((int64_t)1 << 31), (int64_t)1 << 31, &s->offset))
            return false;
    } else {
        if (!scan_duration(&r->scan, "a period", &s->period_ns))
            return false;
        if (!s->period_ns)
            return scan_fail(&r->scan, "a period of nothing; expected more than 0");
    }
    if (!device->stimulus_count++)
        device->stimuli = s;
    r->to->stimulus_count++;
    return shape(r, s);
}

static bool unknown_type(struct reader *r, const char *name)
{
    const char *names[BUSFILE_NAMES], *close;
    struct library_entry entry;
    size_t count = 0;

    while (count < BUSFILE_NAMES && library_get(r->to->library, count, &entry))
        names[count++] = entry.name;
    close = scan_nearest(name, names, count);
    if (close)
        return scan_fail(&r->scan,
                         "no device type \"%.40s\" (did you mean \"%.40s\"?); expected a device "
                         "type, use, ring or input",
                         name, close);
    return scan_fail(&r->scan,
                     "no device type \"%.40s\"; expected a device type (tgm device lists them), "
                     "use, ring or input",
                     name);
}

static bool device(struct reader *r)
{
    static const char *const words[] = { "vendor", "product", "revision", "alias", "input" };
    const char *name = r->scan.token[0].text;
    struct bus_device *to = &r->to->devices[r->to->device_count];
    uint32_t *const ids[] = { &to->identity.vendor, &to->identity.product, &to->identity.revision };
    unsigned n;
    int64_t value;

    r->scan.next = 1;
    r->type = library_find(r->to->library, name);
    if (!r->type)
        return unknown_type(r, name);
    if (r->to->device_count == BUS_MAX_SLAVES)
        return scan_fail(&r->scan, "too many devices; expected at most %d", BUS_MAX_SLAVES);
    to->type = r->type->name;
    r->to->device_count++;
    while (scan_more(&r->scan)) {
        if (!scan_choice(&r->scan, "vendor, product, revision, alias or input", words, 5, &n))
            return false;
        if (n == 4) {
            if (!input(r))
                return false;
            continue;
        }
        if (!scan_number(&r->scan, words[n], 1, n == 3 ? 0xffff : 0xffffffff, &value))
            return false;
        if (n == 3)
            to->alias = (uint16_t)value;
        else
            *ids[n] = (uint32_t)value;
    }
    return true;
}

/* More inputs of the device above. */
static bool more_inputs(struct reader *r)
{
    bool ok = input(r);

    while (ok && scan_is(&r->scan, "input"))
        ok = input(r);
    return ok;
}

static bool line(struct reader *r)
{
    bool ok;

    if (scan_is(&r->scan, "use"))
        ok = use(r);
    else if (scan_is(&r->scan, "ring"))
        ok = ring(r);
    else if (scan_is(&r->scan, "input"))
        ok = more_inputs(r);
    else
        ok = device(r);
    return ok && scan_end(&r->scan);
}

static int parse(struct busfile *to, const char *path, char why[LIBRARY_WHY])
{
    struct reader *r = calloc(1, sizeof *r);
    size_t length;
    int error = 0;
    char *text = scan_read_file(path, SCAN_FILE, &length, &error, why);

    if (text && !r) {
        snprintf(why, LIBRARY_WHY, "%.200s: no memory", path);
        error = -ENOMEM;
    }
    if (text && r) {
        r->to = to;
        scan_init(&r->scan, path, text, length, why);
        while (scan_line(&r->scan) && line(r))
            continue;
        if (!r->scan.failed && !to->device_count)
            scan_fail_at(&r->scan, (struct place){ r->scan.line + (r->scan.line == 0), 1 },
                         "the file names no device; expected one a line");
        error = r->scan.failed ? -EINVAL : 0;
    }
    free(text);
    free(r);
    return error;
}

int busfile_read(struct busfile **out, const char *path, char why[LIBRARY_WHY])
{
    struct busfile *file = calloc(1, sizeof *file);
    int error;

    why[0] = '\0';
    *out = NULL;
    if (!file || library_open(&file->library)) {
        free(file);
        snprintf(why, LIBRARY_WHY, "%.200s: no memory", path);
        return -ENOMEM;
    }
    error = parse(file, path, why);
    if (error)
        busfile_close(file);
    else
        *out = file;
    return error;
}

void busfile_close(struct busfile *file)
{
    if (!file)
        return;
    library_close(file->library);
    free(file);
}
