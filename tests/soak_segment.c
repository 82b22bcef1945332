/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * soak_segment FRAMES [SEED] - the operations of segment_ops.h from a pseudo-random string, without
 * libFuzzer: the same frames on every machine. Ends with what went out, what came back and a sum
 * over the state of all slaves.
 */
#ifdef __SANITIZE_ADDRESS__
#define SEGMENT_OPS_EXACT
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SEGMENT_OPS_EXACT
#endif
#endif
#include "segment_ops.h"

#include <inttypes.h>
#include <signal.h>

enum { CASE_BYTES = 1536, CASES_PER_LIFE = 4 };

static volatile sig_atomic_t dying;
static uint64_t life_seed;

static uint64_t next_random(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

static void say_where(int signal_number)
{
    if (!dying) {
        dying = 1;
        fprintf(stderr, "again: soak_segment 1 0x%" PRIx64 "\n", life_seed);
    }
    signal(signal_number, SIG_DFL);
    raise(signal_number);
}

/* A segment's life: from fresh through some cases to the power cycle. The first case begins with
 * slaves on their way up, or random frames would hardly ever meet one in OP. */
static void live(struct field *field, uint64_t seed)
{
    uint64_t state = seed | 1;
    uint8_t bytes[CASE_BYTES];

    field_reset(field);
    for (unsigned n = 0; n < CASES_PER_LIFE; n++) {
        for (size_t i = 0; i < sizeof bytes; i += 8)
            put_u64(bytes + i, next_random(&state));
        if (n == 0) {
            for (size_t i = 0; i < field->count; i++) {
                bytes[3 * i] = 4;
                bytes[3 * i + 1] = (uint8_t)i;
            }
        }
        field_run(field, bytes, sizeof bytes);
    }
    check_revival(field);
}

static uint64_t sum(const struct field *field)
{
    uint64_t value = 14695981039346656037u;

    for (size_t i = 0; i < field->count; i++) {
        for (size_t k = 0; k < SLAVE_MEMORY; k++)
            value = (value ^ field->slaves[i].memory[k]) * 1099511628211u;
    }
    return value;
}

int main(int argc, char **argv)
{
    static struct field field;
    uint64_t wanted = argc > 1 ? strtoull(argv[1], NULL, 0) : 1000000;
    uint64_t state = 0x2545f4914f6cdd1du, seed = argc > 2 ? strtoull(argv[2], NULL, 0) : 0;
    uint64_t total = 0, value = 0;

    signal(SIGABRT, say_where);
    signal(SIGSEGV, say_where);
    signal(SIGFPE, say_where);
    field_init(&field);
    while (field.frames < wanted) {
        life_seed = seed ? seed : next_random(&state);
        live(&field, life_seed);
        value = value * 31 + sum(&field);
        total++;
    }
    printf("%" PRIu64 " frames in %" PRIu64 " lives of %zu slaves, %" PRIu64
           " came back, sum %016" PRIx64 "\n",
           field.frames, total, field.count, field.back, value);
    return 0;
}
