/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * libFuzzer target: any text as a scenario of each layout. What is refused is refused with a place;
 * what is accepted is played against memories of noise, cycle by cycle, on a bus that is none, and
 * what failed is told. Every fourth is read twice, which gives the same answer.
 *
 * Input: the scenario; its first byte chooses the layout. Limits are smaller than in earnest (the
 * Makefile's FUZZ_LIMITS).
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/scenario_play.h"

int LLVMFuzzerInitialize(int *argument_count, char ***arguments);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static unsigned long long inputs, played, failures;

enum { CYCLES = 60, CYCLE_NS = 500000 };

static void must(int holds)
{
    if (!holds)
        abort();
}

/* A bus that takes what is even. */
int bus_set_input(struct bus *bus, size_t slave, unsigned channel, int64_t value)
{
    must(bus == NULL && slave < 7 && channel < 64);
    return value % 2 == 0 ? 0 : -EINVAL;
}

int bus_fault(struct bus *bus, const char *text, uint64_t now_ns, char why[BUS_WHY])
{
    must(bus == NULL && strlen(text) > 0 && now_ns < CYCLES * CYCLE_NS);
    why[0] = '\0';
    return strlen(text) % 2 == 0 ? 0 : -ENOSPC;
}

/* `input` leads to one channel, every fifth `set` to a word of them. */
static void route(struct play *play)
{
    for (size_t i = 0; i < play->scenario->statement_count; i++) {
        const bool word = play->scenario->statements[i].kind == SCENARIO_SET;
        play->route[i] = (struct play_route){ .slave = word && i % 5 != 0 ? PLAY_NO_SLAVE : i % 7,
                                              .channel = word ? 8 : 3,
                                              .channels = word ? 1 + i % 32 : 1,
                                              .word = word };
    }
}

static void play_it(struct scenario *scenario, const uint8_t *noise, size_t size)
{
    static struct evidence evidence;
    static uint64_t cells[SCENARIO_REGISTERS];
    struct play *play = calloc(1, sizeof *play);
    char text[SCENARIO_TEXT];

    must(play != NULL);
    memset(&evidence, 0, sizeof evidence);
    play->scenario = scenario;
    play->evidence = &evidence;
    play->cycle_ns = CYCLE_NS;
    for (size_t i = 0; i < SCENARIO_REGISTERS; i++)
        play->at[i] = &cells[i];
    route(play);
    play_begin(play, 0);
    for (uint64_t cycle = 0; cycle < CYCLES; cycle++) {
        for (size_t i = 0; i < 8; i++)
            ((uint8_t *)cells)[(cycle * 13 + i * 5) % sizeof cells] ^= noise[(cycle + i) % size];
        play_before(play, cycle, cycle * CYCLE_NS);
        play_received(play, cycle, cycle * CYCLE_NS);
        play_after(play, cycle, cycle * CYCLE_NS);
        if (evidence.play != PLAY_RUNNING)
            break;
    }
    must(evidence.play != PLAY_RUNNING || scenario_cycles(scenario, 500) > CYCLES);
    for (unsigned i = 0; i < evidence.failure_count; i++)
        scenario_tell(scenario, &evidence.failures[i], text);
    for (uint64_t i = 0; i < evidence.line_count && i < EVIDENCE_LINES; i++)
        scenario_tell_line(scenario, &evidence.lines[i], text);
    played++;
    failures += evidence.failure_count;
    free(play);
}

static void say_what_was_seen(void)
{
    fprintf(stderr, "%llu inputs: %llu scenarios, %llu failed statements\n", inputs, played,
            failures);
}

int LLVMFuzzerInitialize(int *argument_count, char ***arguments)
{
    (void)argument_count;
    (void)arguments;
    return atexit(say_what_was_seen);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const int layouts[][2] = { { 4, 904 }, { 5, 905 }, { 5, 906 } };
    char first[SCENARIO_WHY], second[SCENARIO_WHY];
    struct scenario *a, *b;

    if (size < 2 || size > 8192)
        return 0;
    inputs++;
    const int *layout = layouts[data[0] % 3];
    const struct catalogue *catalogue = catalogue_find(layout[0], layout[1]);
    const char *text = (const char *)data + 1;
    const int error = scenario_read(&a, text, size - 1, "fuzz", catalogue, first);
    must((error == 0) == (first[0] == '\0') && (a != NULL) == (error == 0));
    must(error == 0 || strncmp(first, "fuzz:", 5) == 0);
    if (size % 4 == 0) {
        must(scenario_read(&b, text, size - 1, "fuzz", catalogue, second) == error);
        must(strcmp(first, second) == 0 && (b != NULL) == (error == 0));
        scenario_close(b);
    }
    if (a != NULL)
        play_it(a, data, size);
    scenario_close(a);
    return 0;
}
