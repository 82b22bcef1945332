/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * libFuzzer target: any text as a fault script for a drive, a terminal, a drive and a terminal.
 * What is refused is refused with a place; what is accepted runs: frames pass, time passes, and at
 * the end everything is mended. The same text read twice gives the same answer.
 *
 * Input: the script. Its first line is tried as a command, too.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/faults.h"
#include "bus/slave.h"
#include "bus/wire.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { SLAVES = 4, FRAMES = 40, STEP_NS = 700000 };

struct plant {
    struct segment segment;
    struct slave slaves[SLAVES];
    void *devices[SLAVES];
};

static void must(int holds)
{
    if (!holds)
        abort();
}

static void plant_open(struct plant *plant)
{
    static const char *const types[SLAVES] = { "drive-cia402", "dio-8x8", "drive-cia402",
                                               "dio-8x8" };

    for (size_t i = 0; i < SLAVES; i++) {
        struct slave_setup setup = { .type = device_type_find(types[i]), .seed = i };

        setup.device = plant->devices[i] = calloc(1, setup.type->size);
        must(setup.device && slave_init(&plant->slaves[i], &setup) == 0);
    }
    segment_init(&plant->segment, plant->slaves, SLAVES);
}

static void plant_close(struct plant *plant)
{
    for (size_t i = 0; i < SLAVES; i++)
        free(plant->devices[i]);
}

/* A BRD of one byte, and the clock of the reference for the others. */
static size_t make_frame(uint8_t frame[SEGMENT_FRAME_MAX])
{
    static const uint8_t head[] = { 255,  255, 255,  255, 255, 255, 1, 1,    1, 1, 1,    1, 0x88,
                                    0xa4, 33,  0x10, 7,   0,   0,   0, 0x30, 1, 1, 0x80, 0, 0 };
    static const uint8_t armw[] = { 13, 0, 0, 0, 0x10, 9, 8, 0, 0, 0 };

    memset(frame, 0, SEGMENT_FRAME_MAX);
    memcpy(frame, head, sizeof head);
    memcpy(frame + 29, armw, sizeof armw);
    return SEGMENT_FRAME_MIN;
}

static void run(struct plant *plant, struct faults *faults)
{
    struct wire wire = { .segment = &plant->segment, .faults = faults };
    char why[FAULTS_WHY];

    for (uint64_t i = 0; i < FRAMES; i++) {
        uint64_t now = i * STEP_NS << i / 6, back = 0;
        enum segment_port port = SEGMENT_PORT_A;
        uint8_t frame[SEGMENT_FRAME_MAX];
        size_t length = make_frame(frame);

        if (i == 3)
            faults_begin(faults, now);
        if (wire_transfer(&wire, &port, frame, length, now, &back))
            must(back >= now);
        while (wire_extra(&wire))
            ;
        if (i == FRAMES - 2)
            must(faults_command(faults, "mend", now, why) == 0);
    }
}

static struct faults *open_twice(struct plant *plant, const char *text, size_t size)
{
    char first[FAULTS_WHY], second[FAULTS_WHY];
    struct faults *a, *b;
    int error = faults_open(&a, text, size, "fuzz", &plant->segment, 1, first);

    must(faults_open(&b, text, size, "fuzz", &plant->segment, 1, second) == error);
    must(strcmp(first, second) == 0 && (error == 0) == (first[0] == '\0'));
    must((a != NULL) == (error == 0) && (b != NULL) == (error == 0));
    must(error == 0 || strncmp(first, "fuzz:", 5) == 0);
    faults_close(b);
    return a;
}

static void try_command(struct plant *plant, struct faults *faults, const char *text, size_t size)
{
    size_t length = strcspn(text, "\n");
    char line[256], why[FAULTS_WHY];

    (void)plant;
    if (size < length || length >= sizeof line)
        return;
    memcpy(line, text, length);
    line[length] = '\0';
    must((faults_command(faults, line, 0, why) == 0) == (why[0] == '\0'));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct plant *plant = calloc(1, sizeof *plant);
    char *text = malloc(size + 1);
    struct faults *faults;

    must(plant && text);
    if (size)
        memcpy(text, data, size);
    text[size] = '\0';
    plant_open(plant);
    faults = open_twice(plant, text, size);
    if (!faults)
        faults = open_twice(plant, "", 0);
    try_command(plant, faults, text, size);
    run(plant, faults);
    faults_close(faults);
    free(text);
    plant_close(plant);
    free(plant);
    return 0;
}
