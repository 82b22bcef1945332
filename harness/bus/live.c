/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * live.c - see live.h.
 *
 * A frame stays in the slot it was received into: it passes the segment there, waits there for its
 * time, and leaves from there. order[] lists the waiting ones by time, then the free ones.
 */
#define _GNU_SOURCE 1
#include "bus/live.h"
#include "bus/bytes.h"
#include "bus/faults.h"
#include "bus/live_socket.h"
#include "bus/slave.h"

#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum {
    SLOTS = 128,
    BATCH = 32, /* frames a system call takes or gives */
    ETHER_HEADER = 14,
    ECAT_HEADER = 2,
    DATAGRAMS = 1,
    DATAGRAM_HEADER = 10,
    WKC = 2,
    LENGTH = 0x07ff,
    MORE = 0x8000,
    LRD = 10,
    LRW = 12,
    BYTE_NS = 80,
    ETHER_OVERHEAD = 24,
};

struct slot {
    uint64_t due_ns;
    size_t length;
    uint8_t frame[SEGMENT_FRAME_MAX];
};

struct live {
    int fd;
    char interface[32];
    struct wire *wire;
    enum live_timing timing;
    uint64_t begin_ns, last_ns;
    struct live_counts counts;
    unsigned waiting; /* entries of order[] that are answers */
    uint8_t order[SLOTS];
    struct slot slot[SLOTS];
};

static uint64_t monotonic(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

uint64_t live_now(const struct live *live)
{
    return monotonic() - live->begin_ns;
}

const struct live_counts *live_counts(const struct live *live)
{
    return &live->counts;
}

int live_open(struct live **out, const struct live_config *config, char why[LIVE_WHY])
{
    int fd = live_socket(config->interface, config->real_network, why);
    struct live *live;

    *out = NULL;
    if (fd < 0)
        return fd;
    live = calloc(1, sizeof *live);
    if (!live) {
        close(fd);
        return live_fail(why, -ENOMEM, "no memory");
    }
    live->fd = fd;
    strncpy(live->interface, config->interface, sizeof live->interface - 1);
    live->wire = config->wire;
    live->timing = config->timing;
    live->begin_ns = monotonic();
    for (unsigned i = 0; i < SLOTS; i++)
        live->order[i] = (uint8_t)i;
    /* The kernel's usual 50 us of slack would be several times the way through the segment. */
    if (config->timing == LIVE_REAL)
        prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0);
    *out = live;
    return 0;
}

void live_close(struct live *live)
{
    if (!live)
        return;
    close(live->fd);
    free(live);
}

/* Notes the working counters of a frame with logical commands. */
static void note_wkc(struct live *live, const struct slot *slot)
{
    const uint8_t *at = slot->frame + ETHER_HEADER + ECAT_HEADER;
    size_t left = get_u16(slot->frame + ETHER_HEADER) & LENGTH, length = 0;
    unsigned sum = 0;
    bool any = false, more = get_u16(slot->frame + ETHER_HEADER) >> 12 == DATAGRAMS;

    if (left > slot->length - ETHER_HEADER - ECAT_HEADER)
        return;
    for (; more && left >= DATAGRAM_HEADER + WKC; at += length, left -= length) {
        length = (get_u16(at + 6) & LENGTH) + (size_t)(DATAGRAM_HEADER + WKC);
        more = get_u16(at + 6) & MORE;
        if (length > left)
            return;
        if (at[0] < LRD || at[0] > LRW)
            continue;
        sum += get_u16(at + length - WKC);
        any = true;
    }
    if (any)
        live->counts.wkc = sum;
}

/* What the way through undisturbed slaves takes at most. */
static uint64_t way_ns(const struct live *live, size_t length)
{
    return (length + ETHER_OVERHEAD) * BYTE_NS + 2 * live->wire->segment->count * SEGMENT_HOP_NS;
}

static uint64_t due(const struct live *live, size_t length, uint64_t now_ns, uint64_t back_ns)
{
    uint64_t way = way_ns(live, length);

    if (live->timing == LIVE_REAL)
        return back_ns;
    return back_ns > now_ns + way ? back_ns - way : now_ns;
}

/* Moves the free slot order[free] among the waiting ones. */
static void queue(struct live *live, unsigned free, uint64_t due_ns)
{
    uint8_t slot = live->order[free];
    unsigned place = live->waiting++;

    live->slot[slot].due_ns = due_ns;
    memmove(live->order + place + 1, live->order + place, free - place);
    for (; place > 0 && live->slot[live->order[place - 1]].due_ns > due_ns; place--)
        live->order[place] = live->order[place - 1];
    live->order[place] = slot;
}

/* One frame through the segment. True: it comes back. */
static bool pass(struct live *live, struct slot *slot, uint64_t *due_ns)
{
    enum segment_port port = SEGMENT_PORT_A;
    uint64_t now_ns = live_now(live), back_ns = now_ns;

    /* A network card pads on the way out; a virtual cable does not. */
    if (slot->length < SEGMENT_FRAME_MIN) {
        memset(slot->frame + slot->length, 0, SEGMENT_FRAME_MIN - slot->length);
        slot->length = SEGMENT_FRAME_MIN;
    }
    live->last_ns = now_ns;
    if (!wire_transfer(live->wire, &port, slot->frame, slot->length, now_ns, &back_ns) ||
        port != SEGMENT_PORT_A)
        return false;
    note_wkc(live, slot);
    *due_ns = due(live, slot->length, now_ns, back_ns);
    return true;
}

/* Frames that come back beside the one returned: into the last free slots. How many. */
static unsigned queue_extras(struct live *live, unsigned spare, uint64_t now_ns)
{
    const struct wire_frame *extra;
    unsigned n = 0;

    while ((extra = wire_extra(live->wire)) != NULL) {
        struct slot *slot = &live->slot[live->order[SLOTS - 1]];

        if (n >= spare || extra->port != SEGMENT_PORT_A) {
            live->counts.dropped++;
            continue;
        }
        slot->length = extra->length;
        memcpy(slot->frame, extra->bytes, extra->length);
        queue(live, SLOTS - 1, due(live, extra->length, now_ns, extra->back_ns));
        n++;
    }
    return n;
}

/* Takes what has arrived, at most one batch. The number of frames, or negative errno. */
static int receive(struct live *live)
{
    unsigned room = SLOTS - live->waiting < BATCH ? SLOTS - live->waiting : BATCH;
    uint8_t taken[BATCH];
    struct mmsghdr messages[BATCH];
    struct iovec parts[BATCH];
    int count;

    for (unsigned i = 0; i < room; i++) {
        taken[i] = live->order[live->waiting + i];
        parts[i] = (struct iovec){ live->slot[taken[i]].frame, SEGMENT_FRAME_MAX };
        messages[i].msg_hdr = (struct msghdr){ .msg_iov = &parts[i], .msg_iovlen = 1 };
    }
    count = recvmmsg(live->fd, messages, room, MSG_DONTWAIT | MSG_TRUNC, NULL);
    if (count < 0)
        return errno == EAGAIN || errno == EINTR ? 0 : -errno;
    /* Slots that stay free are passed over: `next` is where in order[] the slot of frame i is. */
    unsigned next = live->waiting;
    for (int i = 0; i < count; i++, next++) {
        struct slot *slot = &live->slot[taken[i]];
        uint64_t due_ns;

        live->counts.received++;
        slot->length = messages[i].msg_len;
        if (slot->length <= SEGMENT_FRAME_MAX && pass(live, slot, &due_ns))
            queue(live, next, due_ns);
        else
            live->counts.dropped++;
        /* What was received and not passed yet keeps its slot. */
        next += queue_extras(live, SLOTS - live->waiting - (unsigned)(count - i), live->last_ns);
    }
    return count;
}

/* The first n waiting slots are free again. */
static void release(struct live *live, unsigned n)
{
    uint8_t freed[BATCH];

    memcpy(freed, live->order, n);
    memmove(live->order, live->order + n, live->waiting - n);
    live->waiting -= n;
    memcpy(live->order + live->waiting, freed, n);
}

/* Gives back the answers whose time has come. 0 or negative errno. */
static int answer(struct live *live)
{
    struct mmsghdr messages[BATCH];
    struct iovec parts[BATCH];
    uint64_t now_ns = live->waiting ? live_now(live) : 0;
    unsigned n = 0;

    for (; n < BATCH && n < live->waiting; n++) {
        struct slot *slot = &live->slot[live->order[n]];

        if (slot->due_ns > now_ns && live->waiting < SLOTS)
            break;
        parts[n] = (struct iovec){ slot->frame, slot->length };
        messages[n].msg_hdr = (struct msghdr){ .msg_iov = &parts[n], .msg_iovlen = 1 };
    }
    if (!n)
        return 0;
    int sent = sendmmsg(live->fd, messages, n, 0);
    int error = sent < 0 ? errno : 0;
    live->counts.answered += (unsigned)(sent > 0 ? sent : 0);
    /* A full queue loses frames, as on a wire; the first that is not taken is not tried again. */
    if (sent < (int)n) {
        live->counts.dropped++;
        sent = sent < 0 ? 1 : sent + 1;
    }
    release(live, (unsigned)sent);
    return error == ENETDOWN || error == ENXIO || error == ENODEV ? -error : 0;
}

static void pass_time(struct live *live)
{
    uint64_t now_ns = live_now(live);

    if (live->wire->faults)
        faults_advance(live->wire->faults, now_ns);
    for (size_t i = 0; i < live->wire->segment->count; i++) {
        struct slave *slave = &live->wire->segment->slaves[i];

        if (slave->powered)
            slave_advance(slave, now_ns);
    }
}

/* True when a signal handler has run. */
static bool sleep_until(const struct live *live, uint64_t until_ns)
{
    struct pollfd fd = { .fd = live->fd, .events = POLLIN };
    uint64_t now_ns = live_now(live);
    struct timespec wait = { 0, 0 };

    if (live->waiting && live->slot[live->order[0]].due_ns < until_ns)
        until_ns = live->slot[live->order[0]].due_ns;
    if (until_ns > now_ns) {
        wait.tv_sec = (time_t)((until_ns - now_ns) / 1000000000u);
        wait.tv_nsec = (long)((until_ns - now_ns) % 1000000000u);
    }
    return ppoll(&fd, 1, &wait, NULL) < 0;
}

int live_run(struct live *live, uint64_t until_ns, char why[LIVE_WHY])
{
    bool interrupted = false;
    int error = 0;

    while (!interrupted && error >= 0 && live_now(live) < until_ns) {
        interrupted = sleep_until(live, until_ns);
        error = receive(live);
        if (error >= 0)
            error = answer(live);
    }
    pass_time(live);
    return error >= 0 ? 0
                      : live_fail(why, error, "%s is gone or was taken down: %s", live->interface,
                                  strerror(-error));
}
