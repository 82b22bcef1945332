/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The engine of the fault script: when faults begin and end, and what that means for others that
 * last at the same place. */
#include "bus/fault_parts.h"
#include "bus/spread.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MILLION = 1000000 };

static bool lasts(const struct fault_statement *st)
{
    return st->action.verb->kind != FAULT_MOMENT;
}

static uint64_t later(uint64_t time_ns, uint64_t by_ns)
{
    return by_ns >= FAULT_NEVER - time_ns ? FAULT_NEVER : time_ns + by_ns;
}

void faults_note(struct faults *faults, uint64_t now_ns, const char *text, const char *remark)
{
    struct bus_fault_event *event = &faults->log[faults->logged++ % FAULTS_LOG];

    event->time_ns = now_ns;
    snprintf(event->text, sizeof event->text, "%.79s%.48s", text, remark);
}

struct slave *faults_slave(struct faults *faults, const struct fault_statement *statement,
                           uint64_t now_ns)
{
    struct slave *slave = &faults->segment->slaves[statement->action.place - 1];

    if (slave->powered)
        slave_advance(slave, now_ns);
    return slave;
}

static bool together(const struct fault_action *a, const struct fault_action *b)
{
    return a->verb->kind == b->verb->kind && a->place == b->place &&
           (a->verb->kind != FAULT_INPUT || a->channel == b->channel);
}

struct fault_statement *faults_still(struct faults *faults, const struct fault_statement *statement)
{
    for (size_t i = faults->count; i-- > 0;) {
        struct fault_statement *other = &faults->statements[i];

        if (other != statement && other->phase == FAULT_ACTIVE &&
            together(&other->action, &statement->action))
            return other;
    }
    return NULL;
}

/* What is wrong with a slave is the sum of what lasts. */
static void disturb(struct faults *faults, const struct fault_statement *about, uint64_t now_ns)
{
    struct slave_faults sum = { 0 };

    for (size_t i = 0; i < faults->count; i++) {
        const struct fault_statement *st = &faults->statements[i];

        if (st->phase == FAULT_ACTIVE && together(&st->action, &about->action))
            st->action.verb->effect(&st->action, &sum);
    }
    slave_disturb(faults_slave(faults, about, now_ns), &sum);
}

static void note_end(struct faults *faults, const struct fault_statement *st, uint64_t now_ns)
{
    char remark[64] = " ends";

    if (st->action.verb->kind == FAULT_FRAMES)
        snprintf(remark, sizeof remark, " ends, %llu of %llu frames", (unsigned long long)st->hits,
                 (unsigned long long)st->seen);
    faults_note(faults, now_ns, st->action.text, remark);
}

/* Phase and next time when nothing lasts (any more). */
static void rest(struct faults *faults, struct fault_statement *st)
{
    faults->changed = true;
    st->phase = st->resume_ns == FAULT_NEVER ? FAULT_OVER : FAULT_WAITING;
    st->next_ns = st->resume_ns;
}

static void end(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    const struct fault_verb *verb = st->action.verb;

    rest(faults, st);
    if (verb->kind == FAULT_SLAVE)
        disturb(faults, st, now_ns);
    else if (verb->end)
        verb->end(faults, st, now_ns);
    note_end(faults, st, now_ns);
}

static void pick_frames(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    const struct fault_action *action = &st->action;

    st->seen = st->hits = 0;
    st->left = action->pick == FAULT_PICK_COUNT  ? action->pick_number
               : action->pick == FAULT_PICK_NEXT ? 1
                                                 : FAULT_NEVER;
    if (action->pick == FAULT_PICK_NUMBER && action->pick_number <= faults->frames) {
        faults_note(faults, now_ns, action->text, ": that frame has passed already");
        rest(faults, st);
    }
}

static uint64_t end_time(const struct faults *faults, const struct fault_statement *st,
                         uint64_t now_ns)
{
    uint64_t ns = st->action.lasts_ns ? st->action.lasts_ns : st->action.verb->lasts_ns;
    uint64_t until = ns ? later(now_ns, ns) : FAULT_NEVER;
    uint64_t to = faults->begun ? later(faults->zero_ns, st->when.to_ns) : FAULT_NEVER;

    if (st->resume_ns < until)
        until = st->resume_ns;
    return until < to ? until : to;
}

/* Would this one be too many for its slave? */
static bool crowded(const struct faults *faults, const struct fault_action *action)
{
    unsigned same = 0;

    for (size_t i = 0; action->verb->most && i < faults->count; i++) {
        const struct fault_statement *st = &faults->statements[i];

        same += st->phase == FAULT_ACTIVE && st->action.verb == action->verb &&
                st->action.place == action->place;
    }
    return action->verb->most && same >= action->verb->most;
}

static void begin(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    const struct fault_verb *verb = st->action.verb;

    faults_note(faults, now_ns, st->action.text, "");
    st->resume_ns = st->when.every_ns ? later(now_ns, st->when.every_ns) : FAULT_NEVER;
    if (st->resume_ns != FAULT_NEVER && st->resume_ns >= later(faults->zero_ns, st->when.to_ns))
        st->resume_ns = FAULT_NEVER;
    if (crowded(faults, &st->action)) {
        faults_note(faults, now_ns, st->action.text, ": nothing happens, too many at once");
        rest(faults, st);
        return;
    }
    if (!lasts(st)) {
        rest(faults, st);
        verb->begin(faults, st, now_ns);
        return;
    }
    faults->changed = true;
    st->phase = FAULT_ACTIVE;
    st->next_ns = end_time(faults, st, now_ns);
    if (verb->kind == FAULT_SLAVE)
        disturb(faults, st, now_ns);
    else if (verb->kind == FAULT_FRAMES)
        pick_frames(faults, st, now_ns);
    else
        verb->begin(faults, st, now_ns);
}

/* What the engine has to look out for. */
static void look_ahead(struct faults *faults)
{
    faults->due_ns = FAULT_NEVER;
    faults->changed = false;
    faults->watching = faults->shaking = false;
    for (size_t i = 0; i < faults->count; i++) {
        const struct fault_statement *st = &faults->statements[i];
        bool active = st->phase == FAULT_ACTIVE;

        if (!active && st->phase != FAULT_WAITING)
            continue;
        if (st->next_ns < faults->due_ns)
            faults->due_ns = st->next_ns;
        faults->watching |= st->when.frame || (active && st->action.verb->kind == FAULT_FRAMES);
        faults->shaking |= active && st->action.verb->shake;
    }
}

static void happen(struct faults *faults, uint64_t time_ns)
{
    for (size_t i = 0; i < faults->count; i++) {
        struct fault_statement *st = &faults->statements[i];

        if (st->next_ns != time_ns)
            continue;
        if (st->phase == FAULT_ACTIVE)
            end(faults, st, time_ns);
        /* An end may be the next begin as well. */
        if (st->phase == FAULT_WAITING && st->next_ns == time_ns)
            begin(faults, st, time_ns);
    }
}

void faults_advance(struct faults *faults, uint64_t now_ns)
{
    while (faults->due_ns <= now_ns) {
        happen(faults, faults->due_ns);
        look_ahead(faults);
    }
}

void faults_begin(struct faults *faults, uint64_t zero_ns)
{
    if (faults->begun)
        return;
    faults->begun = true;
    faults->zero_ns = zero_ns;
    for (size_t i = 0; i < faults->script_count; i++) {
        struct fault_statement *st = &faults->statements[i];

        if (st->when.from_start) {
            if (st->phase == FAULT_ACTIVE && later(zero_ns, st->when.to_ns) < st->next_ns)
                st->next_ns = later(zero_ns, st->when.to_ns);
            continue;
        }
        st->phase = FAULT_WAITING;
        if (!st->when.frame)
            st->next_ns = later(zero_ns, st->when.at_ns);
    }
    look_ahead(faults);
}

static bool hit(const struct faults *faults, struct fault_statement *st)
{
    const struct fault_action *action = &st->action;

    switch (action->pick) {
    case FAULT_PICK_NUMBER:
        return action->pick_number == faults->frames;
    case FAULT_PICK_SHARE:
        return spread_next(&st->random) % MILLION < action->pick_number;
    default:
        return true;
    }
}

static bool strike(struct faults *faults, struct fault_statement *st, struct fault_fate *fate)
{
    st->seen++;
    if (!hit(faults, st))
        return false;
    st->hits++;
    st->action.verb->strike(&st->action, fate);
    if (st->action.pick == FAULT_PICK_NUMBER || --st->left == 0)
        rest(faults, st);
    return true;
}

bool faults_frame(struct faults *faults, uint64_t now_ns, struct fault_fate *fate)
{
    bool struck = false;

    faults->frames += faults->begun;
    if (!faults->watching && !faults->shaking)
        return false;
    *fate = (struct fault_fate){ 0 };
    for (size_t i = 0; i < faults->count; i++) {
        struct fault_statement *st = &faults->statements[i];

        if (st->phase == FAULT_WAITING && st->when.frame && st->when.frame == faults->frames)
            begin(faults, st, now_ns);
        if (st->phase != FAULT_ACTIVE)
            continue;
        if (st->action.verb->strike)
            struck |= strike(faults, st, fate);
        else if (st->action.verb->shake)
            st->action.verb->shake(faults, st, now_ns);
    }
    if (faults->changed)
        look_ahead(faults);
    return struck;
}

void faults_finish(struct faults *faults, enum fault_kind kind, size_t place, uint64_t now_ns)
{
    for (size_t i = 0; i < faults->count; i++) {
        struct fault_statement *st = &faults->statements[i];

        if (st->phase == FAULT_ACTIVE && st->action.verb->kind == kind && st->action.place == place)
            end(faults, st, now_ns);
    }
}

void faults_mend(struct faults *faults, size_t place, uint64_t now_ns)
{
    for (size_t i = 0; i < faults->count; i++) {
        struct fault_statement *st = &faults->statements[i];
        enum fault_kind kind = st->phase == FAULT_ACTIVE ? st->action.verb->kind : FAULT_MOMENT;
        bool of_slave = kind != FAULT_FRAMES && kind != FAULT_CABLE && st->action.place == place;

        if (kind != FAULT_MOMENT && (!place || of_slave))
            end(faults, st, now_ns);
    }
}

/* --- by command --- */

static void plant_seed(struct fault_statement *st, uint64_t seed)
{
    if (!st->action.seeded)
        st->action.seed = seed;
    st->random = spread(st->action.seed + SPREAD_STEP);
}

static struct fault_statement *free_slot(struct faults *faults)
{
    for (size_t i = faults->script_count; i < faults->count; i++) {
        if (faults->statements[i].phase == FAULT_OVER)
            return &faults->statements[i];
    }
    return faults->count < faults->room ? &faults->statements[faults->count++] : NULL;
}

int faults_apply(struct faults *faults, const struct fault_action *action, uint64_t now_ns,
                 char why[FAULTS_WHY])
{
    struct fault_statement *st = crowded(faults, action) ? NULL : free_slot(faults);

    if (!st) {
        snprintf(why, FAULTS_WHY, "%s: too many faults at once", action->text);
        return -ENOSPC;
    }
    faults_advance(faults, now_ns);
    *st = (struct fault_statement){ .when = { .to_ns = FAULT_NEVER }, .action = *action };
    plant_seed(st, spread(~faults->seed + SPREAD_STEP * ++faults->commands));
    begin(faults, st, now_ns);
    look_ahead(faults);
    return 0;
}

int faults_command(struct faults *faults, const char *text, uint64_t now_ns, char why[FAULTS_WHY])
{
    struct fault_action action;
    int error = fault_parse(&action, text, faults->segment, why);

    return error ? error : faults_apply(faults, &action, now_ns, why);
}

/* --- open, close, look back --- */

int faults_open(struct faults **out, const char *text, size_t length, const char *name,
                struct segment *segment, uint64_t seed, char why[FAULTS_WHY])
{
    struct faults *faults;
    size_t count = 0;
    int error = fault_script_read(text, length, name, segment, NULL, &count, why);

    *out = NULL;
    if (error)
        return error;
    faults = calloc(1, sizeof *faults);
    if (faults)
        faults->statements = calloc(count + FAULTS_COMMANDS, sizeof *faults->statements);
    if (!faults || !faults->statements) {
        snprintf(why, FAULTS_WHY, "%s: no memory for %zu statements", name, count);
        faults_close(faults);
        return -ENOMEM;
    }
    fault_script_read(text, length, name, segment, faults->statements, &count, why);
    faults->segment = segment;
    faults->seed = seed;
    faults->script_count = count;
    faults->count = count;
    faults->room = count + FAULTS_COMMANDS;
    for (size_t i = 0; i < count; i++) {
        struct fault_statement *st = &faults->statements[i];

        plant_seed(st, spread(seed + SPREAD_STEP * (i + 1)));
        st->phase = st->when.from_start ? FAULT_WAITING : FAULT_IDLE;
        st->next_ns = st->when.from_start ? 0 : FAULT_NEVER;
    }
    look_ahead(faults);
    *out = faults;
    return 0;
}

void faults_close(struct faults *faults)
{
    if (!faults)
        return;
    free(faults->statements);
    free(faults);
}

bool faults_event(const struct faults *faults, uint64_t number, struct bus_fault_event *event)
{
    if (number >= faults->logged)
        return false;
    *event = faults->log[number % FAULTS_LOG];
    if (faults->logged - number > FAULTS_LOG)
        *event = (struct bus_fault_event){ 0 };
    return true;
}
