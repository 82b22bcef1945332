/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * libFuzzer target: any text as a path for an interpolator. What is refused is refused with a
 * place; what is accepted is a chain without gaps, and runs: positions stay numbers and near the
 * path, whatever the override, with stops, starts and M functions in between, and through the
 * filters. The same text read twice gives the same path.
 *
 * Input: six bytes of settings, then the text.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/interp_file.h"
#include "host/interp_filter.h"
#include "host/interp_run.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { PARTS = 200, STEPS = 400, SETTINGS = 6 };

static void must(int holds)
{
    if (!holds)
        abort();
}

static struct interp_part first[PARTS], second[PARTS];
static struct interp_spline spline;

static void read_twice(struct interp_path *path, const char *text, size_t size)
{
    char a[INTERP_FILE_WHY], b[INTERP_FILE_WHY];
    struct interp_path again;
    int error;

    interp_path_init(path, first, PARTS);
    interp_path_init(&again, second, PARTS);
    error = interp_file_read(path, text, size, "fuzz", a);
    must(interp_file_read(&again, text, size, "fuzz", b) == error && strcmp(a, b) == 0);
    must((error == 0) == (a[0] == '\0') && (error == 0 || strncmp(a, "fuzz:", 5) == 0));
    must(path->count == again.count && path->count <= interp_file_parts(text, size));
    must(interp_limits_wrong(&path->limits) == NULL || error != 0);
    if (error != 0)
        path->count = 0;
}

static void check_chain(const struct interp_path *path)
{
    const double *end = path->start;

    for (size_t i = 0; i < path->count; end = path->parts[i++].end) {
        const struct interp_part *part = &path->parts[i];
        double position[INTERP_AXES], tangent[INTERP_AXES], size = 0;

        must(memcmp(part->start, end, sizeof part->start) == 0);
        must(part->length >= 0 && isfinite(part->length));
        if (!interp_part_moves(part))
            continue;
        interp_part_position(part, part->length / 3, position);
        interp_part_tangent(part, part->length / 3, tangent);
        for (unsigned axis = 0; axis < INTERP_AXES; axis++) {
            must(fabs(position[axis]) <= 4 * INTERP_LARGEST);
            size += tangent[axis] * tangent[axis];
        }
        must(fabs(size - 1) < 1e-3);
    }
}

static void ignore(void *argument, const struct interp_part *part)
{
    (void)argument;
    must(part->code > 1 && part->code != 1000);
}

static void run(struct interp_path *path, const uint8_t settings[SETTINGS])
{
    static struct interp_run motion;
    static struct interp_iir iir;
    struct interp_inputs inputs = { .step = 1e-4 * (1 + settings[0] % 20),
                                    .override = 0.01 + settings[1] / 128.0,
                                    .acceleration =
                                        settings[2] % 2 ? INFINITY : 1 + settings[2] * 20.0 };
    const double nowhere[INTERP_AXES] = { settings[5] % 3 };

    interp_run_init(&motion, path, ignore, NULL);
    interp_run_place(&motion, nowhere);
    interp_spline_set(&spline, settings[3] % 2 ? 50 : 0, nowhere);
    interp_iir_set(&iir, 0.1 + settings[4], 1 + settings[3], 0.01, 0x3ff, inputs.step, nowhere);
    interp_run_load(&motion);
    interp_run_start(&motion);
    for (unsigned i = 0; i < STEPS; i++) {
        double position[INTERP_AXES];

        inputs.m_done = i % 7 == 0;
        inputs.m_delay = i % 3;
        inputs.external = (int32_t)(i * settings[4]);
        if (i % 64 == settings[5])
            interp_run_stop(&motion, settings[5] % 2, false);
        if (i % 64 == 63)
            interp_run_start(&motion);
        if (i % 100 == 99)
            inputs.override = 2 - inputs.override / 2;
        interp_run_step(&motion, &inputs);
        memcpy(position, motion.position, sizeof position);
        interp_spline_step(&spline, position);
        interp_iir_step(&iir, position);
        must(motion.speed >= 0 && isfinite(motion.speed) && motion.part <= path->count);
        for (unsigned axis = 0; axis < INTERP_AXES; axis++)
            must(fabs(motion.position[axis]) <= 4 * INTERP_LARGEST && isfinite(position[axis]));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct interp_path path;
    char *text;

    if (size < SETTINGS)
        return 0;
    /* Exactly as long as it is, so that a step beyond is seen. */
    text = malloc(size > SETTINGS ? size - SETTINGS : 1);
    must(text != NULL);
    memcpy(text, data + SETTINGS, size - SETTINGS);
    read_twice(&path, text, size - SETTINGS);
    check_chain(&path);
    if (path.count > 0)
        run(&path, data);
    free(text);
    return 0;
}
