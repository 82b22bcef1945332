/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_start.c - everything that a loader would have to run, find or set up: constructor,
 * destructor, thread-local data, indirect function, symbols that are not there.
 */
#define EXPORT __attribute__((visibility("default")))

extern long somewhere_else(long);
extern __attribute__((weak)) long perhaps(long);
extern __attribute__((weak, visibility("hidden"))) long never(long);

static __thread long per_thread = 5;
EXPORT __thread long exported_per_thread = 6;
static volatile long started;

static __attribute__((constructor)) void constructor(void)
{
    started = 1;
}

static __attribute__((destructor)) void destructor(void)
{
    started = 0;
}

static long picked_implementation(long x)
{
    return x + 1;
}

static void *resolver(void)
{
    return (void *)picked_implementation;
}

EXPORT long picked(long x) __attribute__((ifunc("resolver")));
EXPORT long Program_01(void *data);

long Program_01(void *data)
{
    long x = data != 0 ? somewhere_else(started) : per_thread++ + exported_per_thread;
    if (perhaps != 0)
        x += perhaps(x);
    if (never != 0)
        x += never(x);
    return picked(x);
}
