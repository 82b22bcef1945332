/* SPDX-License-Identifier: MIT */
#include "tgm/motion.h"

void tgm_edge_init(struct tgm_edge *e, int level)
{
    e->level = level != 0;
}

enum tgm_edge_kind tgm_edge_step(struct tgm_edge *e, int level)
{
    const int before = e->level;
    e->level = level != 0;
    return e->level == before ? TGM_EDGE_NONE : e->level ? TGM_EDGE_RISING : TGM_EDGE_FALLING;
}

void tgm_tick_init(struct tgm_tick *t, uint32_t now)
{
    t->last = now;
}

uint32_t tgm_tick_elapsed(struct tgm_tick *t, uint32_t now)
{
    const uint32_t elapsed = now - t->last;
    t->last = now;
    return elapsed;
}

/* Time that stops at its end, so that it cannot wrap. */
static uint64_t advance(uint64_t elapsed, uint64_t by, uint64_t end)
{
    return elapsed >= end || end - elapsed <= by ? end : elapsed + by;
}

void tgm_debounce_init(struct tgm_debounce *d, int level, uint64_t hold_us)
{
    d->level = level != 0;
    d->elapsed_us = 0;
    d->hold_us = hold_us;
    d->differs = 0;
}

int tgm_debounce_step(struct tgm_debounce *d, int input, uint32_t elapsed_us)
{
    const int differs = (input != 0) != d->level;

    d->elapsed_us = differs && d->differs ? advance(d->elapsed_us, elapsed_us, d->hold_us) : 0;
    d->differs = differs;
    if (differs && d->elapsed_us >= d->hold_us) {
        d->level = !d->level;
        d->elapsed_us = 0;
        d->differs = 0;
    }
    return d->level;
}

void tgm_ton_init(struct tgm_ton *t, uint64_t preset_us)
{
    t->preset_us = preset_us;
    t->elapsed_us = 0;
    t->input = 0;
    t->output = 0;
}

int tgm_ton_step(struct tgm_ton *t, int input, uint32_t elapsed_us)
{
    t->elapsed_us = input && t->input ? advance(t->elapsed_us, elapsed_us, t->preset_us) : 0;
    t->input = input != 0;
    t->output = t->input && t->elapsed_us >= t->preset_us;
    return t->output;
}

void tgm_tof_init(struct tgm_tof *t, uint64_t preset_us)
{
    t->preset_us = preset_us;
    t->elapsed_us = 0;
    t->input = 0;
    t->output = 0;
}

int tgm_tof_step(struct tgm_tof *t, int input, uint32_t elapsed_us)
{
    if (input || t->input)
        t->elapsed_us = 0;
    else if (t->output)
        t->elapsed_us = advance(t->elapsed_us, elapsed_us, t->preset_us);
    t->output = input != 0 || ((t->input || t->output) && t->elapsed_us < t->preset_us);
    t->input = input != 0;
    return t->output;
}

void tgm_tp_init(struct tgm_tp *t, uint64_t preset_us)
{
    t->preset_us = preset_us;
    t->elapsed_us = 0;
    t->input = 0;
    t->output = 0;
}

int tgm_tp_step(struct tgm_tp *t, int input, uint32_t elapsed_us)
{
    const int rising = input && !t->input;

    if (t->output) {
        t->elapsed_us = advance(t->elapsed_us, elapsed_us, t->preset_us);
        t->output = t->elapsed_us < t->preset_us;
    } else if (rising) {
        t->elapsed_us = 0;
        t->output = t->preset_us > 0;
    }
    if (!t->output && !input)
        t->elapsed_us = 0;
    t->input = input != 0;
    return t->output;
}

void tgm_ramp_init(struct tgm_ramp *r, double value, double up, double down)
{
    r->value = value;
    r->up = up;
    r->down = down;
}

double tgm_ramp_step(struct tgm_ramp *r, double target, uint32_t elapsed_us)
{
    const double seconds = elapsed_us * 1e-6;

    if (target > r->value && r->up > 0) {
        const double next = r->value + r->up * seconds;
        r->value = next < target ? next : target;
    } else if (target < r->value && r->down > 0) {
        const double next = r->value - r->down * seconds;
        r->value = next > target ? next : target;
    }
    return r->value;
}

int tgm_dio4_get(const int32_t *words, uint32_t bit)
{
    return bit < TGM_DIO4_BITS ? (int)((uint32_t)words[bit / 8] >> bit % 8 & 1u) : 0;
}

void tgm_dio4_set(int32_t *words, uint32_t bit, int level)
{
    if (bit >= TGM_DIO4_BITS)
        return;
    const uint32_t mask = 1u << bit % 8;
    const uint32_t word = (uint32_t)words[bit / 8];
    words[bit / 8] = (int32_t)(level ? word | mask : word & ~mask);
}

int tgm_dio5_get(const uint32_t *words, uint32_t bit)
{
    return bit < TGM_DIO5_BITS ? (int)(words[bit / 32] >> bit % 32 & 1u) : 0;
}

void tgm_dio5_set(uint32_t *words, uint32_t bit, int level)
{
    if (bit >= TGM_DIO5_BITS)
        return;
    const uint32_t mask = 1u << bit % 32;
    words[bit / 32] = level ? words[bit / 32] | mask : words[bit / 32] & ~mask;
}
