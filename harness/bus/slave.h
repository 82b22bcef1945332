/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * slave.h - one EtherCAT slave controller with its device: register file, process memory, sync
 * managers, FMMUs, AL state machine, mailbox, distributed clock, watchdog, SII.
 *
 * A slave knows nothing of frames and of its neighbours; the segment hands it single accesses. All
 * time is the virtual time given to it; nothing happens between two calls that would not have
 * happened the same way with calls in between. That is why a slave may lag: a frame only tells it
 * the time (slave_meet), and the slave lives up to it when an access comes.
 */
#ifndef HARNESS_BUS_SLAVE_H
#define HARNESS_BUS_SLAVE_H

#include "bus/device.h"
#include "bus/mailbox.h"
#include "bus/registers.h"
#include "bus/sii.h"

#define SLAVE_SMS     8
#define SLAVE_FMMUS   8
#define SLAVE_RAM_KIB 8
#define SLAVE_MEMORY  (REG_RAM + SLAVE_RAM_KIB * 1024)
#define SLAVE_NEVER   UINT64_MAX

/* How long the simulated slave controllers and their processors take. Real ones vary widely
 * (ethercat.md 3.3, 4, 6.2); these lie inside what was measured there and make masters poll at
 * least once. */
#define SLAVE_AL_NS           500000
#define SLAVE_AL_READ_NS      20000
#define SLAVE_MAILBOX_NS      300000
#define SLAVE_SII_READ_NS     150000
#define SLAVE_SII_WRITE_NS    3000000
#define SLAVE_FIRST_OUTPUT_NS 200000000 /* patience for outputs on the way to OP */

/* A sync manager as decoded from its registers. */
struct syncman {
    uint16_t start, length;
    uint16_t span; /* bytes it occupies: length, or three times that when buffered */
    bool enabled, usable, mailbox, buffered, master_writes, watchdog;
    bool full;                    /* mailbox */
    bool open;                    /* the master has opened the area at its first byte */
    uint8_t latest;               /* buffered: last complete buffer, 3 none */
    uint8_t master_at, device_at; /* buffered: buffer each side is in */
};

struct fmmu {
    bool active, reads, writes, bytewise;
    uint32_t first, last; /* logical bytes */
    uint8_t first_bit, last_bit;
    uint16_t physical;
    uint8_t physical_bit;
};

struct al {
    bool pending;     /* AL control written, application has not acted yet */
    uint64_t read_ns; /* when it has looked: from then on it takes another request */
    uint16_t request;
    uint64_t due_ns;
    bool wait_outputs; /* on the way to OP until the first outputs come or due_ns passes */
    bool outputs_seen;
};

struct watchdog {
    uint64_t period_ns; /* 0: off */
    uint64_t deadline_ns;
    bool running;
};

struct dc {
    int64_t born_local; /* local time at power-on */
    uint64_t anchor_ns; /* virtual time of the anchor */
    int64_t anchor_local;
    int64_t drift_ppb;
    int64_t trim_ppb, integral_ppb;
    uint64_t compared_ns;
    uint64_t interval_ns; /* between the last two comparisons */
    int64_t pull;         /* ppb per ns of difference, for that interval */
    int64_t mean;
};

/* What goes wrong in a slave because a script says so (faults.h); all zero: nothing. It outlives a
 * power cycle. */
#define SLAVE_ABORTS 8

struct slave_faults {
    bool mailbox_silent;    /* requests are taken and never looked at */
    bool mailbox_malformed; /* every bit of a reply's content is inverted */
    uint8_t abort_count;
    struct slave_abort {
        uint32_t code;
        uint16_t index;     /* 0: every object */
        int16_t subindex;   /* negative: every one */
    } aborts[SLAVE_ABORTS]; /* SDO requests that are aborted; the first row that fits */
    bool eeprom_busy;       /* never gets ready */
    bool eeprom_nack;       /* acknowledges no command */
    int64_t drift_ppb;      /* on top of the crystal's own */
    uint32_t jitter_ns;     /* frames are stamped up to this much too early or too late */
    uint64_t jitter_seed;
};

/* A port of the controller. 0: towards the master's port A, 1: away from it. */
struct port {
    bool link;   /* a cable with somebody at its other end */
    bool closed; /* what would leave here turns round */
    bool hears;  /* frames that this slave processes come in here, sooner or later */
};

struct dc_sync {
    bool running;
    uint64_t start;   /* as written */
    bool pending[2];  /* first pulse yet to come */
    uint64_t next[2]; /* system time of the next pulse, SLAVE_NEVER none */
    uint64_t due_ns;  /* virtual time of the earliest that somebody waits for */
};

/* What a cycle touches comes first: with many slaves the cache lines count. */
struct slave {
    const struct device_type *type;
    void *device;
    uint64_t now_ns;   /* virtual time up to which this slave has lived */
    uint64_t frame_ns; /* time of the frame at this slave; during an event, of the event */
    uint64_t due_ns; /* earliest of al, mailbox, watchdog, sync; may be too early, never too late */
    uint32_t delay_ns; /* from the master to this slave's processing unit */
    bool powered;
    bool behind; /* a frame is here and the slave has not lived up to it yet */
    bool outputs_fresh;
    uint8_t state; /* AL state without error bit */
    int8_t output_sm, input_sm;
    bool mute;         /* no logical command is processed, as with sync managers deactivated */
    uint8_t protected; /* bit 0 registers, bit 1 everything */
    uint8_t unlocked;  /* likewise, for the rest of this frame */
    uint8_t sm_end;    /* one past the last enabled */
    uint8_t fmmu_end;
    bool fmmu_crossed; /* a read and a write mapping share logical bytes */

    struct syncman sm[SLAVE_SMS];
    struct watchdog watchdog;
    struct dc dc;
    struct dc_sync sync;
    struct al al;
    uint32_t *changes; /* see slave_changed() */
    uint32_t logical_first, logical_last;

    struct port port[2];
    int32_t
        port1_ns; /* from there until the frame is heard at port 1; negative: it came from there */
    uint64_t loops_until_ns; /* temporary loop settings hold until then */
    uint8_t loops_before;
    bool rerouted; /* loops have changed; for the segment to see */

    struct fmmu fmmu[SLAVE_FMMUS];
    struct mailbox mailbox;
    uint64_t sii_busy_until;
    struct slave_faults faults;

    uint8_t image[SII_SIZE];
    uint8_t memory[SLAVE_MEMORY];
};

struct slave_setup {
    const struct device_type *type;
    void *device; /* type->size zeroed bytes, outlives the slave */
    uint64_t seed;
    uint32_t serial;
    const struct bus_stimulus *stimuli;
    size_t stimulus_count;
    const struct bus_identity *identity; /* instead of the type's; NULL: the type's */
    uint16_t alias;
};

/* Power-on at virtual time 0. 0, or -EINVAL when the type's SII does not build or its mailbox is
 * larger than MAILBOX_MAX or too small for an SDO. */
int slave_init(struct slave *slave, const struct slave_setup *setup);

/* Switched on again: registers, SII, application and state as after slave_init(); what the machine
 * behind it did (an axis' position) stays. In a segment use segment_power(): routes may change. */
void slave_power_on(struct slave *slave, uint64_t now_ns);
/* Switched off: its machine is left to itself. */
void slave_power_off(struct slave *slave, uint64_t now_ns);

/* Lets virtual time at this slave pass up to now_ns; earlier times are ignored. Whoever reaches
 * into a slave or its device without a frame calls this first. */
void slave_advance(struct slave *slave, uint64_t now_ns);
/* From now on these faults instead of those before. */
void slave_disturb(struct slave *slave, const struct slave_faults *faults);
/* Falls by itself to AL state `state`, with the error bit when there is a code. False: it is lower
 * already. */
bool slave_drop(struct slave *slave, unsigned state, uint16_t code);
/* The process data watchdog expires now. False: it does not run. */
bool slave_expire(struct slave *slave);
/* A frame is at this slave at now_ns: the time of the accesses that follow. */
static inline void slave_meet(struct slave *slave, uint64_t now_ns)
{
    if (now_ns >= slave->frame_ns) {
        slave->frame_ns = now_ns;
        slave->behind = true;
    }
}
static inline void slave_catch_up(struct slave *slave)
{
    if (slave->behind)
        slave_advance(slave, slave->frame_ns);
}
/* Something that decides what frames do at this slave has changed: its registers below the
 * distributed clock, its power, its place. Plans (plan.h) made before are void. */
static inline void slave_changed(struct slave *slave)
{
    if (slave->changes)
        ++*slave->changes;
}
/* To be called after a frame has passed: the device sees what the frame brought. */
void slave_settle(struct slave *slave);

/* Accesses from the wire. True: at least one byte was accessible (working counter). Bytes of data
 * that were not accessible stay as they are. */
bool slave_read(struct slave *slave, uint16_t address, uint8_t *data, size_t length);
bool slave_write(struct slave *slave, uint16_t address, const uint8_t *data, size_t length);
/* Read-write: data comes back with the old content. Bit 0 read, bit 1 written. */
unsigned slave_exchange(struct slave *slave, uint16_t address, uint8_t *data, size_t length);
/* Logical access through the FMMUs; `reads`/`writes` select the directions. Bits as above. */
unsigned slave_logical(struct slave *slave, uint32_t address, uint8_t *data, size_t length,
                       bool reads, bool writes);

/* The event request a datagram takes along. */
uint16_t slave_irq(struct slave *slave);
bool slave_is_addressed(const struct slave *slave, uint16_t station);

#endif
