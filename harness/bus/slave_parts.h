/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * slave_parts.h - what the parts of a slave controller owe each other; nobody outside the slave
 * includes this. Register hooks take the place of the plain store (write) or run just before the
 * plain load (refresh) of the register block they are named for in registers.c.
 */
#ifndef HARNESS_BUS_SLAVE_PARTS_H
#define HARNESS_BUS_SLAVE_PARTS_H

#include "bus/bytes.h"
#include "bus/slave.h"

/* registers.c */
void registers_reset(struct slave *slave);
bool registers_read(struct slave *slave, uint32_t address, uint8_t *data, size_t length);
bool registers_write(struct slave *slave, uint32_t address, const uint8_t *data, size_t length);

/* May the master write there, as write protection stands? */
bool registers_writable(const struct slave *slave, uint32_t address);
/* Counts an error; counters stay at 0xFF. */
void registers_count(struct slave *slave, unsigned address);

/* ports.c */
void ports_reset(struct slave *slave);
void ports_link(struct slave *slave, unsigned port, bool link);
/* A frame from behind finds port 0 closed for want of a link, rather than by order. */
bool ports_turn_round(const struct slave *slave);
/* A frame came in at a closed port. True: it has opened. */
bool ports_knock(struct slave *slave, unsigned port);
bool ports_write_control(struct slave *slave, uint16_t address, const uint8_t *data, size_t length);
/* Temporary loop settings end. */
void ports_run(struct slave *slave, uint64_t now_ns);

/* syncman.c */
bool syncman_write_registers(struct slave *slave, uint16_t address, const uint8_t *data,
                             size_t length);
/* The sync manager that owns `address`, or NULL; *span: bytes from there of one owner. */
struct syncman *syncman_at(struct slave *slave, uint32_t address, size_t limit, size_t *span);
bool syncman_master_read(struct slave *slave, struct syncman *sm, uint32_t address, uint8_t *data,
                         size_t length);
bool syncman_master_write(struct slave *slave, struct syncman *sm, uint32_t address,
                          const uint8_t *data, size_t length);
/* What a master write at `address` would meet, without side effects: for bit-wise FMMUs. */
uint8_t syncman_peek(const struct slave *slave, uint32_t address);
/* Device side, mailbox; process data: slave_cycle.h. */
bool syncman_device_take(struct slave *slave, unsigned n, uint8_t *data, size_t room, size_t *size);
bool syncman_device_put(struct slave *slave, unsigned n, const uint8_t *data, size_t length);
/* Forgets what a mailbox holds. */
void syncman_device_clear(struct slave *slave, unsigned n);
void syncman_repeat_done(struct slave *slave);

/* fmmu.c */
bool fmmu_write_registers(struct slave *slave, uint16_t address, const uint8_t *data,
                          size_t length);

/* al.c */
bool al_write_control(struct slave *slave, uint16_t address, const uint8_t *data, size_t length);
void al_run(struct slave *slave);
/* Falls to `state` with the error bit and a code. */
void al_fall(struct slave *slave, unsigned state, uint16_t code);
/* A sync manager's registers changed under a running state. */
void al_check_running(struct slave *slave);

/* watchdog.c */
bool watchdog_write_registers(struct slave *slave, uint16_t address, const uint8_t *data,
                              size_t length);
bool watchdog_clear_counters(struct slave *slave, uint16_t address, const uint8_t *data,
                             size_t length);
void watchdog_configure(struct slave *slave);
void watchdog_run(struct slave *slave);

/* dc.c */
void dc_init(struct slave *slave, uint64_t seed);
void dc_power_on(struct slave *slave);
int64_t dc_local_time(const struct slave *slave);
/* To be called before the rate of the clock changes. */
void dc_rebase(struct slave *slave);
/* Local time with the offset of register 0x0920. */
uint64_t dc_system_time(const struct slave *slave);
/* Virtual time at which system time gets there; at most a little too early. */
uint64_t dc_when(const struct slave *slave, uint64_t system_time);
void dc_refresh(struct slave *slave, uint16_t address, size_t length);
bool dc_latch_ports(struct slave *slave, uint16_t address, const uint8_t *data, size_t length);
bool dc_write_time(struct slave *slave, uint16_t address, const uint8_t *data, size_t length);
/* As a write of the whole system time whose low half is `received`. */
void dc_follow(struct slave *slave, uint32_t received);
bool dc_write_speed(struct slave *slave, uint16_t address, const uint8_t *data, size_t length);
void dc_refresh_speed(struct slave *slave, uint16_t address, size_t length);
bool dc_write_offset(struct slave *slave, uint16_t address, const uint8_t *data, size_t length);

/* sync.c: registers 0x0980 to 0x09A7 */
bool sync_write_activation(struct slave *slave, uint16_t address, const uint8_t *data,
                           size_t length);
bool sync_write_start(struct slave *slave, uint16_t address, const uint8_t *data, size_t length);
bool sync_write_cycle(struct slave *slave, uint16_t address, const uint8_t *data, size_t length);
void sync_refresh(struct slave *slave, uint16_t address, size_t length);
void sync_reset(struct slave *slave);
/* Pulses up to now; also when the clock was set or changed its rate. */
void sync_run(struct slave *slave);
void sync_schedule(struct slave *slave);

#include "bus/slave_cycle.h"

#endif
