/* SPDX-License-Identifier: GPL-2.0-or-later */
/* bench_machine.c - what the emulated CPU does in a second of this computer's processor, on modules
 * of tests/machine_modules, with and without a trace; and what a call costs. */
#include <stdio.h>
#include <time.h>

#include "image/image.h"
#include "machine/machine.h"

enum { LOOPS = 10000, CALLS = 100000 };

static const struct {
    const char *module, *function;
    int calls;
} runs[] = {
    { "interrupt.so", "loop_1000", LOOPS }, { "i386.dll", "loop_1000", LOOPS },
    { "arm.so", "loop_1000", LOOPS },       { "arm.so", "loop_thumb", LOOPS },
    { "traced.so", "touch", CALLS },
};

static uint64_t accesses;

static void see(void *argument, const struct trace_access *access)
{
    (void)argument, (void)access;
    accesses++;
}

static double processor_seconds(void)
{
    struct timespec now;

    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

static int measure(struct machine *machine, const struct image_symbol *symbol, void *memory,
                   int calls, const char *what, bool traced)
{
    uint64_t instructions = 0;
    const double begin = processor_seconds();

    accesses = 0;
    for (int i = 0; i < calls; i++) {
        struct machine_outcome outcome;

        machine_call(machine, symbol->vaddr | symbol->thumb, memory, &outcome);
        if (outcome.kind != MACHINE_RETURNED)
            return 1;
        instructions += outcome.instructions;
    }
    const double seconds = processor_seconds() - begin;

    printf("  %-12s %-10s %-8s %6.1f million instructions a second, %6.2f us a call, %llu "
           "accesses\n",
           what, symbol->name, traced ? "traced" : "", (double)instructions / seconds * 1e-6,
           seconds / calls * 1e6, (unsigned long long)accesses);
    return 0;
}

static int bench(const char *module, const char *function, int calls,
                 const struct machine_trace *trace)
{
    const struct machine_config config = { .kind = MACHINE_INSTRUMENTED,
                                           .seed = 1,
                                           .trace = trace };
    char path[4096], why[MACHINE_WHY] = "";
    struct image *image = NULL;
    struct machine *machine = NULL;
    void *host, *memory;
    int failed = 1;

    snprintf(path, sizeof path, "%s/%s", TEST_MACHINE_MODULES_DIR, module);
    if (image_open(&image, path, why) == 0 && machine_load(&machine, image, &config, why) == 0 &&
        machine_map(machine, "memory", 4096, MACHINE_REGION_READ_WRITE, &host, &memory, why) == 0)
        failed =
            measure(machine, image_export(image, function), memory, calls, module, trace != NULL);
    if (failed)
        printf("  %s: %s\n", module, why);
    machine_unload(machine);
    image_close(image);
    return failed;
}

int main(void)
{
    static const struct machine_trace trace = { see, NULL };
    int failed = 0;

    printf("emulated CPU\n");
    for (size_t i = 0; i < sizeof runs / sizeof runs[0]; i++) {
        failed |= bench(runs[i].module, runs[i].function, runs[i].calls, NULL);
        failed |= bench(runs[i].module, runs[i].function, runs[i].calls, &trace);
    }
    return failed;
}
