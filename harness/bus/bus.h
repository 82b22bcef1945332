/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * bus.h - the EtherCAT bus as the emulated TG Motion uses it: SOEM on top of a simulated segment.
 *
 * Everything above this header sees slaves, states and process data entries by object index;
 * nothing above it sees SOEM or the segment. The configuration path is SOEM's ordinary one: scan,
 * SII, CoE mapping over the mailbox, sync managers, FMMUs, distributed clock, SAFEOP, OP, all in
 * frames.
 *
 * Time is virtual and given by the caller: `now_ns` counts from bus_open() and never goes back.
 * During bus_open() (scan and configuration block, as in SOEM) time runs by itself from 0 to what
 * the exchanges took; bus_now() tells where it stands afterwards.
 */
#ifndef HARNESS_BUS_H
#define HARNESS_BUS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define BUS_WHY        256
#define BUS_MAX_SLAVES 200
#define BUS_FAULT_TEXT 128

struct bus;
struct bus_library; /* device types: those built in and those of device files (library.h) */
struct faults;      /* what goes wrong, and when (faults.h) */
struct pcap;        /* where frames are written to (pcap.h) */

/* Who a slave says it is; 0: what its type says. */
struct bus_identity {
    uint32_t vendor, product, revision;
};

/* What stands on the bus, in wiring order. `type` names a row of the device table
 * (bus_device_types). */
struct bus_device {
    const char *type;
    struct bus_identity identity;
    uint16_t alias;                     /* configured station alias, SII word 4 */
    const struct bus_stimulus *stimuli; /* what the outside world does to its inputs; may be NULL */
    size_t stimulus_count;
};

enum bus_stimulus_kind {
    BUS_SQUARE,   /* offset + amplitude for half of every period, then offset - amplitude */
    BUS_TRIANGLE, /* starts at offset and rises */
    BUS_RAMP,     /* from offset - amplitude to offset + amplitude, then back at once */
    BUS_SINE,     /* starts at offset and rises */
    BUS_NOISE,    /* another value every period, evenly spread, from the seed */
    BUS_CONSTANT, /* offset from phase on, 0 before */
};

/* The outside world at one input. Until phase it rests: analog inputs at offset, digital ones low.
 * A digital input is high while the signal is above the middle (constant: while it is not 0); its
 * amplitude and offset mean nothing otherwise. Several stimuli of one input add up, digital ones by
 * OR. Amplitude and offset within +-2^31. */
struct bus_stimulus {
    unsigned bit; /* channel, as in bus_set_input() */
    uint64_t period_ns;
    uint64_t phase_ns;
    enum bus_stimulus_kind kind;
    int64_t amplitude, offset;
};

/* A value of an object that a slave needs before it can go to SAFEOP: a choice of mapping, say. */
struct bus_startup {
    size_t slave;
    uint16_t index;
    uint8_t subindex;
    uint8_t size; /* bytes: 1, 2, 4 */
    uint32_t value;
};

struct bus_config {
    const struct bus_device *devices;
    size_t device_count;
    uint32_t cycle_ns; /* period of the process data exchange */
    uint64_t seed;
    const struct bus_library *library; /* NULL: built-in types only */
    struct pcap *capture;              /* NULL: none */
    bool redundant;                    /* SOEM's second port closes the ring */
    bool dc_sync;                      /* slaves with axes and a clock get SYNC0 every cycle */
    /* Written by CoE on the way from PREOP to SAFEOP, whenever a slave goes it, in this order. */
    const struct bus_startup *startup;
    size_t startup_count;
    const char *faults;                /* script of what goes wrong (faults.h); NULL: nothing */
    const char *faults_name;           /* what messages call it */
};

/* A fault that was applied, or its end. */
struct bus_fault_event {
    uint64_t time_ns;
    char text[BUS_FAULT_TEXT];
};

struct bus_slave {
    char name[64];
    uint32_t vendor, product, revision;
    uint16_t
        al_state; /* as last read from the slave: 1 INIT, 2 PREOP, 4 SAFEOP, 8 OP; + 0x10 error */
    uint16_t al_code;            /* AL status code as last read */
    bool lost;                   /* does not answer at its station address */
    unsigned losses, recoveries; /* how often it was lost, and brought back to OP */
    unsigned axes; /* CiA 402 axes found in its mapping (0x6040, 0x6840 ...); 0 for terminals */
    unsigned input_bits, output_bits; /* process data lengths */
    bool has_clock;                   /* takes part in the distributed clock */
};

/* What went over the wire since bus_open(). */
struct bus_statistics {
    uint64_t sent, received; /* frames of the master */
    int64_t reference_ns;    /* time of the reference clock, as the last exchange brought it */
};

/* Place of one mapped object (or of raw terminal bits) in the process image. */
struct bus_entry {
    uint8_t *byte; /* first byte */
    uint8_t bit;   /* first bit in it */
    uint8_t bits;  /* length, 1..64; 0 = not mapped */
};

enum bus_direction { BUS_OUTPUT, BUS_INPUT }; /* seen from the master */

/* Builds the segment, lets SOEM scan and configure it up to SAFEOP. 0, or negative errno with the
 * reason in `why`: -EINVAL configuration, -ENOMEM, -EIO a slave refused (which, state, AL code),
 * -EOVERFLOW process image or mapping too large. config->devices may go away afterwards, the
 * stimuli they point to may not. */
int bus_open(struct bus **out, const struct bus_config *config, char why[BUS_WHY]);
void bus_close(struct bus *bus);

uint64_t bus_now(const struct bus *bus);
size_t bus_slave_count(const struct bus *bus);
const struct bus_slave *bus_slave(const struct bus *bus, size_t index);

/* Finds the object in the mapping that was read over CoE; for terminals without CoE, in the SII
 * PDOs. */
struct bus_entry bus_find(const struct bus *bus, size_t slave, enum bus_direction direction,
                          uint16_t index, uint8_t subindex);
/* All process data bits of a slave, for terminals: bit n of its inputs or outputs. */
struct bus_entry bus_bits(const struct bus *bus, size_t slave, enum bus_direction direction,
                          unsigned first, unsigned count);

/* What is mapped: entry n of a slave in the order of its process data, gaps left out. False past the
 * end. `place.bits` is 0 for an entry longer than 64 bits. */
struct bus_mapped {
    uint16_t index;
    uint8_t subindex;
    uint32_t first; /* bit within the slave's process data of that direction */
    struct bus_entry place;
};
bool bus_entry_at(const struct bus *bus, size_t slave, enum bus_direction direction, unsigned n,
                  struct bus_mapped *entry);
/* Where the process data of a slave begin in the logical address space. */
uint32_t bus_logical_address(const struct bus *bus, size_t slave, enum bus_direction direction);

/* Raw value, zero extended; sign extension by the caller (bus_entry_sign). Inline cost, no checks
 * beyond bits == 0 (reads 0, writes nothing). */
uint64_t bus_entry_get(struct bus_entry entry);
int64_t bus_entry_sign(struct bus_entry entry);
void bus_entry_set(struct bus_entry entry, uint64_t value);

/* Asks all slaves for OP. They go there while process data flows; drives want outputs first. A
 * slave whose state shows an error (al_state as last read) is asked with an acknowledge. */
void bus_request_op(struct bus *bus);

/* One exchange: send queues the outputs at that time, receive takes what came back. receive returns
 * the working counter, or -1 when no frame came; inputs then stay as they were. Outputs may be
 * written at any time and leave with the next send. A frame not received before the next send is
 * dropped. A frame needs its time on the wire (some microseconds): a receive earlier than that
 * waits for it, up to one cycle, and bus_now() moves along. No allocation. */
void bus_send(struct bus *bus, uint64_t now_ns);
int bus_receive(struct bus *bus, uint64_t now_ns);
int bus_expected_wkc(const struct bus *bus);
struct bus_statistics bus_statistics(const struct bus *bus);

/* Asks for the AL states of all slaves, beside the process data; bus_slave() has them after one of
 * the next exchanges. State and code become 0, and the slave is lost, when it does not answer. */
void bus_poll_states(struct bus *bus);

/* From now on slaves that are lost, or below OP, are brought back beside the process data: found
 * again by their place and identity, configured as at the start, acknowledged and sent to OP. What
 * happened is counted in bus_slave(). */
void bus_supervise(struct bus *bus, bool on);

/*
 * Something that takes several frames and happens beside the process data, one after the other in
 * the order in which they were started: an SDO, or an access to registers of the slave controller.
 * The job belongs to the caller and must stay until it is done, or until bus_close().
 */
enum bus_job_kind { BUS_SDO_READ, BUS_SDO_WRITE, BUS_REGISTER_READ, BUS_REGISTER_WRITE };

#define BUS_JOB_DATA 512

struct bus_job {
    enum bus_job_kind kind;
    size_t slave;
    uint16_t index; /* of the object; address of the register */
    uint8_t subindex;
    bool complete; /* SDO: all subindexes from this one (0 or 1) on */
    size_t size;   /* bytes to write; room, then bytes read */
    uint8_t data[BUS_JOB_DATA];

    bool done;
    int result;           /* as of bus_sdo_read(); registers: -ETIMEDOUT when nobody answered */
    uint32_t abort;       /* with -EPROTO */
    struct bus_job *next; /* of the bus */
};

void bus_job_start(struct bus *bus, struct bus_job *job);

/* CoE upload/download, blocking in virtual time: bus_now() is some milliseconds later afterwards,
 * and the caller goes on from there; no process data flows meanwhile, jobs do. 0, or negative
 * errno: -EPROTO abort (code in *abort, which may be NULL), -ETIMEDOUT no answer, -EBADMSG not an
 * answer, -ENOSPC data larger than *size, -EOPNOTSUPP slave without CoE, -EINVAL no such slave. */
int bus_sdo_read(struct bus *bus, size_t slave, uint16_t index, uint8_t subindex, void *data,
                 size_t *size, uint32_t *abort);
int bus_sdo_write(struct bus *bus, size_t slave, uint16_t index, uint8_t subindex, const void *data,
                  size_t size, uint32_t *abort);

/* The outside world sets input `channel` of a slave from now on, instead of its stimuli: digital
 * inputs 0 or 1, analog inputs their raw value. -EINVAL: no such slave or channel. */
int bus_set_input(struct bus *bus, size_t slave, unsigned channel, int64_t value);
/* Whether the slave has that input. */
bool bus_has_input(const struct bus *bus, size_t slave, unsigned channel);
/* The channel of the input whose value begins in bit `bit` of a terminal's input process data; -1:
 * there is none. */
int bus_input_at(const struct bus *bus, size_t slave, unsigned bit);

/* Time 0 of the fault script, and frame number 0, are now. Nothing of it happens before, except what
 * it has for the start of the bus. */
void bus_faults_begin(struct bus *bus, uint64_t now_ns);
/* One fault now: "unplug after 2", "mailbox 1 silent for 20ms". 0, -EINVAL or -ENOSPC with a reason.
 */
int bus_fault(struct bus *bus, const char *text, uint64_t now_ns, char why[BUS_WHY]);
/* Whether it would be one. 0, or -EINVAL with "PLACE:column: what; expected ..." in `why`. */
int bus_fault_check(const struct bus *bus, const char *text, const char *place, char why[BUS_WHY]);
/* What was applied so far, numbered from 0. False: not yet. Only the latest are remembered: the text
 * of an older one is empty. */
bool bus_fault_log(const struct bus *bus, uint64_t number, struct bus_fault_event *event);

/*
 * A copy of everything that moves: master, slaves, devices, faults. bus_rewind() makes the bus what
 * it was when the copy was made, time included: what follows is the same to the last bit. Between
 * jobs only (-EBUSY); jobs that are waiting at a rewind are forgotten. The capture is no part of it.
 * Without allocation, bus_keep() excepted.
 */
struct bus_copy;
int bus_keep(struct bus *bus, struct bus_copy **out);
void bus_rewind(struct bus *bus, const struct bus_copy *copy);
void bus_copy_free(struct bus_copy *copy);

/* The device table: name and one-line description by index, NULL past the end. */
const char *bus_device_type(size_t index, const char **description);

#endif
