/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * watchdog.c - calls that do not return.
 *
 * One timer ticks all the time, so that a call costs no system call. A tick that finds the call
 * which an earlier tick saw counts; the one that makes HANG_TICKS periods finds a hang, between
 * hang_ns and a quarter more after the call began. It ticks by the time that the processor spends
 * on this thread, so that a busy machine does not make a hang.
 *
 * A tick may land anywhere. Between calls it finds no call active. In the trampoline the call is
 * beginning or over: nothing is done, the next tick sees. In a host service the service is asked to
 * leave by itself (machine_service_leave) and made to by the next tick if it has not. Anywhere else
 * (the module, or host code that it jumped to) the call is abandoned on the spot.
 */
#define _GNU_SOURCE 1
#include <errno.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "machine/machine_private.h"

#ifndef sigev_notify_thread_id
#define sigev_notify_thread_id _sigev_un._tid
#endif

/* A tick costs some 10 us. Were ticks not far apart next to that, the same call could be found by
 * several of them without having had the processor in between. */
#define SHORTEST_PERIOD_NS 250000u

int machine_watchdog_start(struct machine *machine, char why[MACHINE_WHY])
{
    uint64_t period = machine->config.hang_ns / HANG_TICKS;
    struct itimerspec every;
    struct sigevent event;

    if (period < SHORTEST_PERIOD_NS)
        period = SHORTEST_PERIOD_NS;
    memset(&event, 0, sizeof event);
    event.sigev_notify = SIGEV_THREAD_ID;
    event.sigev_signo = SIGALRM;
    event.sigev_notify_thread_id = (int)syscall(SYS_gettid);
    if (timer_create(CLOCK_THREAD_CPUTIME_ID, &event, &machine->timer) != 0)
        return machine_fail(why, -errno, "no timer for the watchdog: %s", strerror(errno));
    machine->has_timer = true;
    every.it_value.tv_sec = (time_t)(period / 1000000000u);
    every.it_value.tv_nsec = (long)(period % 1000000000u);
    every.it_interval = every.it_value;
    if (timer_settime(machine->timer, 0, &every, NULL) != 0)
        return machine_fail(why, -errno, "the watchdog's timer does not start: %s",
                            strerror(errno));
    return 0;
}

void machine_watchdog_stop(struct machine *machine)
{
    if (machine->has_timer && !machine->sealed)
        timer_delete(machine->timer);
    machine->has_timer = false;
}

/* True when the call in progress is to be abandoned now. */
bool machine_watchdog_tick(struct machine *machine, uint64_t ip)
{
    if (!machine_state.active || machine->watched != machine_state.serial) {
        machine->watched = machine_state.serial;
        machine->ticks = 0;
        return false;
    }
    if (++machine->ticks < HANG_TICKS)
        return false;
    if (ip >= (uint64_t)machine_trampoline_begin && ip < (uint64_t)machine_trampoline_end)
        return false;
    if (machine_incident.service_depth > 0 && !machine_executes(machine, ip, 1) &&
        !machine_incident.hung) {
        machine_incident.hung = true;
        return false;
    }
    return true;
}
