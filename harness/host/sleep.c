/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * SleepFt in Program_01 to Program_03: the call is set aside, the schedule goes on, and the call
 * goes on in the first slot that is not before its time (R17). What is above and below it runs
 * meanwhile.
 */
#include "host/host_parts.h"

#define UNIT_NS 100

static struct sleeper *sleeper_of(struct host *host, enum entry entry)
{
    return &host->sleepers[entry - ENTRY_01];
}

static bool may_sleep(const struct host *host)
{
    const enum entry entry = host->evidence->entry;
    return entry >= ENTRY_01 && entry <= ENTRY_03 && (host->races == NULL || !host->races->trying);
}

static uint64_t now(const struct host *host)
{
    return host->real != NULL ? realtime_now(host->real) : host->now_ns;
}

/* Of more than a second nobody sees the end; what is not positive is over at once. */
static uint64_t nanoseconds(int64_t units)
{
    if (units <= 0)
        return 0;
    return units > (int64_t)(SLEEP_HANG_NS / UNIT_NS) ? SLEEP_HANG_NS + 1
                                                      : (uint64_t)units * UNIT_NS;
}

void sleep_wanted(struct host *host, int64_t units)
{
    const uint64_t wanted = nanoseconds(units);
    if (wanted == 0)
        return;
    if (may_sleep(host) && machine_set_aside(host->machine))
        sleeper_of(host, host->evidence->entry)->wanted_ns = wanted;
    else if (host->evidence->entry == ENTRY_INI && host->real != NULL)
        realtime_sleep(host->real, wanted);
}

void sleep_begins(struct host *host, enum entry entry, unsigned aside)
{
    struct sleeper *sleeper = sleeper_of(host, entry);
    sleeper->asleep = true;
    sleeper->aside = aside;
    sleeper->since_ns = now(host);
}

bool sleep_is(const struct host *host, enum entry entry)
{
    return entry >= ENTRY_01 && entry <= ENTRY_03 && host->sleepers[entry - ENTRY_01].asleep;
}

bool sleep_anyone(const struct host *host)
{
    return sleep_is(host, ENTRY_01) || sleep_is(host, ENTRY_02) || sleep_is(host, ENTRY_03);
}

static void give_up(struct host *host, enum entry entry)
{
    struct machine_outcome outcome;
    machine_drop(host->machine, sleeper_of(host, entry)->aside, &outcome);
    sleeper_of(host, entry)->total_ns = 0;
    preempt_done(host, entry);
    host_incident(host, entry, &outcome);
}

void sleep_goes_on(struct host *host, enum entry entry)
{
    struct machine_outcome outcome;
    struct sleeper *sleeper = sleeper_of(host, entry);
    const uint64_t left = SLEEP_HANG_NS - sleeper->total_ns;
    const bool forever = sleeper->wanted_ns > left;
    if (now(host) - sleeper->since_ns < (forever ? left : sleeper->wanted_ns))
        return;
    sleeper->asleep = false;
    if (forever) {
        give_up(host, entry);
        return;
    }
    sleeper->total_ns += sleeper->wanted_ns;
    machine_take_up(host->machine, sleeper->aside);
    preempt_plan_on(host, entry, sleeper->since_ns);
    host_calling(host, entry);
    machine_go_on(host->machine, &outcome);
    host_called(host, entry, &outcome);
    if (!sleeper->asleep)
        sleeper->total_ns = 0;
}

void sleep_drop_all(struct host *host)
{
    struct machine_outcome outcome;
    for (enum entry entry = ENTRY_01; entry <= ENTRY_03; entry++) {
        if (sleep_is(host, entry))
            machine_drop(host->machine, sleeper_of(host, entry)->aside, &outcome);
        sleeper_of(host, entry)->asleep = false;
    }
}
