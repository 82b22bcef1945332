/* SPDX-License-Identifier: GPL-2.0-or-later */
/* client.h - the inside of struct bus, shared by the client's source files. */
#ifndef HARNESS_BUS_CLIENT_H
#define HARNESS_BUS_CLIENT_H

#include "bus/bus.h"
#include "bus/faults.h"
#include "bus/port/clock.h"
#include "bus/rack.h"
#include "bus/wire.h"

#include "oshw.h"
#include "osal.h"
#include "ethercattype.h"
#include "ethercatbase.h"
#include "ethercatmain.h"
#include "ethercatdc.h"
#include "ethercatcoe.h"
#include "ethercatconfig.h"
#include "ethercatprint.h"

#define CLIENT_ENTRIES   64    /* mapped entries of one slave and direction */
#define CLIENT_IMAGE_MAX 65536 /* SOEM's logical space of one group */

#define CLIENT_APART 1024

struct client_entry {
    uint16_t index;
    uint8_t subindex, bits;
    uint32_t first; /* bit within the slave's process data of that direction */
};

struct client_map {
    unsigned count;
    struct client_entry entry[CLIENT_ENTRIES];
};

struct bus {
    struct bus_clock clock;
    uint32_t cycle_ns;
    bool dc_sync;
    size_t slave_count;
    struct bus_slave slave[BUS_MAX_SLAVES];
    struct client_map map[BUS_MAX_SLAVES][2]; /* by enum bus_direction */

    struct rack rack;
    struct wire wire;

    /* Beside the process data: one thing at a time, on the fiber (client_jobs.c). */
    struct bus_job *job_first, *job_last;
    bool poll;                        /* states are to be read */
    unsigned silent;                  /* polls in a row that no frame answered */
    uint64_t care_ns[BUS_MAX_SLAVES]; /* not before: next try to bring a slave back */
    bool supervise;
    struct bus_startup *startup;
    size_t startup_count;
    struct faults *faults; /* at the wire from the first fault on */

    ecx_contextt context;
    ecx_portt port;
    ecx_redportt second_port;
    ec_slavet slavelist[BUS_MAX_SLAVES + 1];
    int slavecount;
    ec_groupt grouplist[EC_MAXGROUP];
    uint8 esibuf[EC_MAXEEPBUF];
    uint32 esimap[EC_MAXEEPBITMAP];
    ec_eringt elist;
    ec_idxstackT idxstack;
    boolean ecaterror;
    int64 dctime;
    ec_SMcommtypet smcommtype[EC_MAX_MAPT];
    ec_PDOassignt pdoassign[EC_MAX_MAPT];
    ec_PDOdesct pdodesc[EC_MAX_MAPT];
    ec_eepromSMt eepsm;
    ec_eepromFMMUt eepfmmu;
    uint8 iomap[CLIENT_IMAGE_MAX];
    /* Copies between places that are nearly a multiple of 4 KiB apart are many times slower. */
    uint8_t apart[CLIENT_APART];

    /* What the user of bus.h reads and writes, laid out like iomap. SOEM copies a returning LRW
     * over outputs and inputs alike; outputs written since the send must survive that. */
    uint8_t *image; /* = image_bytes: writable for those who hold a const bus, too */
    uint8_t image_bytes[CLIENT_IMAGE_MAX];
};

/* client_jobs.c: the fiber's life, and what is due on it up to now. */
void client_jobs(void *bus);
void client_run_jobs(struct bus *bus, uint64_t now_ns);
/* One SDO, blocking, where the caller stands. */
int client_sdo(struct bus *bus, struct bus_job *job);
/* client_watch.c: looks after states. True when it did something. */
bool client_watch(struct bus *bus);
/* The way from PREOP to SAFEOP of slave `index` (from 0): its startup values. 0, or negative errno
 * with the value that was refused. */
int client_startup(struct bus *bus, size_t index, const struct bus_startup **refused,
                   uint32_t *abort);
/* Gives the clock of a slave that was away its offset and delay, and SYNC0, again. */
int client_restore_clock(struct bus *bus, size_t index);

/* Reads the mapping of slave `index` (from 0) over CoE or from the SII. 0 or negative errno. */
int client_map_read(struct bus *bus, size_t index);

#endif
