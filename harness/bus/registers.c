/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/slave_parts.h"

#include <string.h>

enum { R = 1, W = 2, RW = R | W, DC = 4, DC_TIME = 8, DC_SYNC = 16 };

enum { PROTECT_REGISTERS = 1, PROTECT_ALL = 2, REGISTERS_END = 0x0f10 };

typedef bool (*write_hook)(struct slave *, uint16_t, const uint8_t *, size_t);
typedef void (*read_hook)(struct slave *, uint16_t, size_t);

static bool clear_rx_errors(struct slave *slave, uint16_t address, const uint8_t *data,
                            size_t length)
{
    (void)address, (void)data, (void)length;
    memset(slave->memory + REG_RX_ERRORS, 0, 12);
    return true;
}

static bool clear_byte(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    (void)data;
    memset(slave->memory + address, 0, length);
    return true;
}

static bool clear_lost_links(struct slave *slave, uint16_t address, const uint8_t *data,
                             size_t length)
{
    (void)address, (void)data, (void)length;
    memset(slave->memory + REG_LOST_LINK, 0, 4);
    return true;
}

static void clear_event(struct slave *slave, unsigned event)
{
    uint8_t *r = slave->memory + REG_ECAT_EVENT;
    unsigned events = get_u16(r);

    if (!(events & event))
        return;
    put_u16(r, events & ~event);
    slave_changed(slave);
}

static void read_dl_status(struct slave *slave, uint16_t address, size_t length)
{
    (void)address, (void)length;
    clear_event(slave, EVENT_DL_STATUS);
}

static void read_al_status(struct slave *slave, uint16_t address, size_t length)
{
    (void)address, (void)length;
    clear_event(slave, EVENT_AL_STATUS);
}

/* Sync managers, one bit each, that ask for the attention of a side: the other side has written
 * what this one reads, or has read what this one writes. */
static unsigned sm_asking(const struct slave *slave, uint8_t irq, bool master)
{
    unsigned asking = 0;

    for (unsigned n = 0; n < slave->sm_end; n++) {
        const uint8_t *r = slave->memory + REG_SM + n * SM_SIZE;
        bool writes = slave->sm[n].master_writes == master;

        if (slave->sm[n].enabled && (r[SM_CONTROL] & irq) &&
            (r[SM_STATUS] & (writes ? SM_STATUS_READ : SM_STATUS_WRITTEN)))
            asking |= 1u << n;
    }
    return asking;
}

static unsigned sm_events(const struct slave *slave)
{
    return sm_asking(slave, SM_CONTROL_ECAT_IRQ, true) * EVENT_SM0;
}

/* What the application has not attended to yet. It is quick: clock, watchdog and sync manager
 * changes are dealt with at once. */
static void read_al_events(struct slave *slave, uint16_t address, size_t length)
{
    uint8_t *m = slave->memory;
    unsigned events = sm_asking(slave, SM_CONTROL_AL_IRQ, false) * AL_EVENT_SM0;

    (void)address, (void)length;
    sync_run(slave);
    for (unsigned signal = 0; signal < 2; signal++)
        events |= (m[REG_DC_SYNC_STATUS + signal] & 1u) * ((unsigned)AL_EVENT_SYNC0 << signal);
    if (slave->al.pending)
        events |= AL_EVENT_CONTROL;
    put_u32(m + REG_AL_EVENT, events);
}

static void read_events(struct slave *slave, uint16_t address, size_t length)
{
    uint8_t *r = slave->memory + REG_ECAT_EVENT;

    (void)address, (void)length;
    put_u16(r, (get_u16(r) & (EVENT_SM0 - 1u)) | sm_events(slave));
}

uint16_t slave_irq(struct slave *slave)
{
    unsigned mask = get_u16(slave->memory + REG_ECAT_EVENT_MASK);
    unsigned events;

    /* Link events come from outside, all others may come with the time. */
    if (mask & ~(unsigned)EVENT_DL_STATUS)
        slave_catch_up(slave);
    events = get_u16(slave->memory + REG_ECAT_EVENT) & (EVENT_SM0 - 1u);
    if (mask >= EVENT_SM0)
        events |= sm_events(slave);
    return (uint16_t)(events & mask);
}

static void read_pins(struct slave *slave, uint16_t address, size_t length)
{
    (void)address, (void)length;
    if (slave->type->pins)
        put_u32(slave->memory + REG_GPO, slave->type->pins(slave->device));
}

/* Three consecutive writes of 'R', 'E', 'S' reset the controller and its application, as switching
 * it off and on does. The register shows the progress. */
static bool write_reset(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    static const char word[] = "RES";
    uint8_t *progress = slave->memory + REG_ECAT_RESET;

    (void)address, (void)length;
    *progress = (uint8_t)(data[0] == (uint8_t)word[*progress] ? *progress + 1 : data[0] == 'R');
    if (*progress == 3)
        slave_power_on(slave, slave->now_ns);
    return true;
}

static uint8_t protection_of(uint16_t address)
{
    return address < REG_ESC_WRITE_ENABLE ? PROTECT_REGISTERS : PROTECT_ALL;
}

/* Any value opens what is protected until the end of the frame. */
static bool write_enable(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    (void)data, (void)length;
    slave->unlocked |= protection_of(address);
    return true;
}

static bool write_protection(struct slave *slave, uint16_t address, const uint8_t *data,
                             size_t length)
{
    uint8_t bit = protection_of(address);

    (void)length;
    slave->memory[address] = data[0] & 1;
    slave->protected = (uint8_t)((slave->protected & ~bit) | (data[0] & 1 ? bit : 0));
    return true;
}

bool registers_writable(const struct slave *slave, uint32_t address)
{
    uint8_t closed = slave->protected & (uint8_t)~slave->unlocked;

    if (!closed || address == REG_WRITE_ENABLE || address == REG_ESC_WRITE_ENABLE)
        return true;
    return !(closed & PROTECT_ALL) && address >= REGISTERS_END;
}

void registers_count(struct slave *slave, unsigned address)
{
    if (slave->memory[address] < 0xff)
        slave->memory[address]++;
}

/* What answers at all. Sorted; an address without a row gives no working counter. */
static const struct row {
    uint16_t first, last;
    uint8_t access;
    write_hook write;
    read_hook refresh;
} rows[] = {
    { 0x0000, 0x0009, R, NULL, NULL },
    { 0x0010, 0x0011, RW, NULL, NULL },
    { 0x0012, 0x0013, R, NULL, NULL },
    { 0x0020, 0x0020, RW, write_enable, NULL },
    { 0x0021, 0x0021, RW, write_protection, NULL },
    { 0x0030, 0x0030, RW, write_enable, NULL },
    { 0x0031, 0x0031, RW, write_protection, NULL },
    { 0x0040, 0x0040, RW, write_reset, NULL },
    { 0x0041, 0x0041, R, NULL, NULL },
    { 0x0100, 0x0103, RW, ports_write_control, NULL },
    { 0x0108, 0x0109, RW, NULL, NULL },
    { 0x0110, 0x0111, R, NULL, read_dl_status },
    { 0x0120, 0x0121, RW, al_write_control, NULL },
    { 0x0130, 0x0131, R, NULL, read_al_status },
    { 0x0132, 0x0133, R, NULL, NULL },
    { 0x0134, 0x0135, R, NULL, NULL },
    { 0x0138, 0x0139, R, NULL, NULL },
    { 0x0140, 0x0141, R, NULL, NULL },
    { 0x0150, 0x0153, R, NULL, NULL },
    { 0x0200, 0x0201, RW, NULL, NULL },
    { 0x0204, 0x0207, R, NULL, NULL },
    { 0x0210, 0x0211, R, NULL, read_events },
    { 0x0220, 0x0223, R, NULL, read_al_events },
    { 0x0300, 0x030b, RW, clear_rx_errors, NULL },
    { 0x030c, 0x030d, RW, clear_byte, NULL },
    { 0x030e, 0x030e, R, NULL, NULL },
    { 0x0310, 0x0313, RW, clear_lost_links, NULL },
    { 0x0400, 0x0401, RW, watchdog_write_registers, NULL },
    { 0x0410, 0x0411, RW, watchdog_write_registers, NULL },
    { 0x0420, 0x0421, RW, watchdog_write_registers, NULL },
    { 0x0440, 0x0441, R, NULL, NULL },
    { 0x0442, 0x0443, RW, watchdog_clear_counters, NULL },
    { 0x0500, 0x0500, RW, sii_write, NULL },
    { 0x0501, 0x0501, R, NULL, NULL },
    { 0x0502, 0x050f, RW, sii_write, sii_refresh },
    { 0x0600, 0x067f, RW, fmmu_write_registers, NULL },
    { 0x0800, 0x083f, RW, syncman_write_registers, NULL },
    { 0x0900, 0x090f, RW | DC, dc_latch_ports, NULL },
    { 0x0910, 0x0917, RW | DC_TIME, dc_write_time, dc_refresh },
    { 0x0918, 0x091f, R | DC_TIME, NULL, NULL },
    { 0x0920, 0x0927, RW | DC_TIME, dc_write_offset, NULL },
    { 0x0928, 0x092b, RW | DC_TIME, NULL, NULL },
    { 0x092c, 0x092f, R | DC_TIME, NULL, dc_refresh },
    { 0x0930, 0x0931, RW | DC_TIME, dc_write_speed, NULL },
    { 0x0932, 0x0933, R | DC_TIME, NULL, dc_refresh_speed },
    { 0x0934, 0x0935, RW | DC_TIME, NULL, NULL },
    { 0x0980, 0x0980, RW | DC_TIME, NULL, NULL },
    { 0x0981, 0x0981, RW | DC_SYNC, sync_write_activation, NULL },
    { 0x0982, 0x0983, R | DC_TIME, NULL, NULL },
    { 0x0984, 0x0984, R | DC_TIME, NULL, sync_refresh },
    { 0x098e, 0x098f, R | DC_TIME, NULL, sync_refresh },
    { 0x0990, 0x0997, RW | DC_SYNC, sync_write_start, sync_refresh },
    { 0x0998, 0x099f, R | DC_TIME, NULL, sync_refresh },
    { 0x09a0, 0x09a7, RW | DC_SYNC, sync_write_cycle, NULL },
    /* Latch inputs: none of our devices has anything connected to them. */
    { 0x09a8, 0x09a9, RW | DC_TIME, NULL, NULL },
    { 0x09ae, 0x09af, R | DC_TIME, NULL, NULL },
    { 0x09b0, 0x09cf, R | DC_TIME, NULL, NULL },
    { 0x0f00, 0x0f03, RW, NULL, NULL },
    { 0x0f10, 0x0f13, R, NULL, read_pins },
    { 0x0f18, 0x0f1f, R, NULL, NULL },
};
#define ROWS (sizeof rows / sizeof *rows)

/* First row that ends at or behind `address`. */
static size_t first_row(uint32_t address)
{
    size_t low = 0, high = ROWS;

    while (low < high) {
        size_t middle = (low + high) / 2;

        if (rows[middle].last < address)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Clocks come whole, as port times only, or not at all; SYNC settings are the side's that has the
 * unit. */
static bool clock_allows(const struct slave *slave, unsigned row, unsigned access)
{
    if ((row & (DC | DC_TIME | DC_SYNC)) && !slave->type->dc)
        return false;
    if ((row & (DC_TIME | DC_SYNC)) && slave->type->dc_delay_only)
        return false;
    return !((row & DC_SYNC) && (access & W) && (slave->memory[REG_DC_CUC] & 1));
}

struct part {
    uint16_t address;
    size_t offset, length;
};

static bool part_of(const struct slave *slave, const struct row *row, unsigned access,
                    uint32_t address, size_t length, struct part *part)
{
    uint32_t first = row->first > address ? row->first : address;
    uint32_t last = (uint32_t)(address + length - 1);

    if (last > row->last)
        last = row->last;
    if (first > last || !(row->access & access))
        return false;
    if (!clock_allows(slave, row->access, access))
        return false;
    part->address = (uint16_t)first;
    part->offset = first - address;
    part->length = last - first + 1;
    return true;
}

bool registers_read(struct slave *slave, uint32_t address, uint8_t *data, size_t length)
{
    bool any = false;

    for (size_t i = first_row(address); i < ROWS && rows[i].first < address + length; i++) {
        struct part p;

        if (!part_of(slave, &rows[i], R, address, length, &p))
            continue;
        if (rows[i].refresh)
            rows[i].refresh(slave, p.address, p.length);
        memcpy(data + p.offset, slave->memory + p.address, p.length);
        any = true;
    }
    return any;
}

bool registers_write(struct slave *slave, uint32_t address, const uint8_t *data, size_t length)
{
    bool any = false;

    if (address < REG_DC_PORT_TIME)
        slave_changed(slave);
    for (size_t i = first_row(address); i < ROWS && rows[i].first < address + length; i++) {
        struct part p;

        if (!part_of(slave, &rows[i], W, address, length, &p))
            continue;
        if (slave->protected && !registers_writable(slave, p.address))
            continue;
        if (rows[i].write) {
            any |= rows[i].write(slave, p.address, data + p.offset, p.length);
        } else {
            memcpy(slave->memory + p.address, data + p.offset, p.length);
            any = true;
        }
    }
    return any;
}

/* Two bits a port (0 none, 2 EBUS, 3 MII) from the nibbles of the SII. */
static uint8_t port_descriptor(unsigned ports)
{
    static const uint8_t kind[16] = { [1] = 3, [3] = 2, [4] = 3 };
    unsigned descriptor = 0;

    for (unsigned port = 0; port < 4; port++)
        descriptor |= (unsigned)kind[ports >> (4 * port) & 0x0f] << (2 * port);
    return (uint8_t)descriptor;
}

static uint16_t features(const struct device_type *type)
{
    if (!type->dc)
        return 0;
    return FEATURE_DC | FEATURE_DC_64 | (type->dc_delay_only ? 0 : FEATURE_DC_SYNC);
}

void registers_reset(struct slave *slave)
{
    static const struct {
        uint16_t address, value;
    } initial[] = {
        { REG_TYPE, 0x11 },
        { REG_BUILD, 0x0002 },
        { REG_FMMU_COUNT, SLAVE_FMMUS | SLAVE_SMS << 8 },
        { REG_RAM_SIZE, SLAVE_RAM_KIB },
        { REG_DL_CONTROL, DL_CONTROL_FORWARDING },
        { REG_DL_CONTROL + 2, 0x0007 },
        { REG_AL_CONTROL, AL_INIT },
        { REG_AL_STATUS, AL_INIT },
        { REG_ECAT_EVENT, EVENT_DL_STATUS },
        { REG_WD_DIVIDER, 0x09c2 },
        { REG_WD_PDI, 0x03e8 },
        { REG_WD_SM, 0x03e8 },
        { REG_DC_SPEED_START, 0x1000 },
        { REG_DC_FILTER, 0x0c04 },
    };

    memset(slave->memory, 0, REG_RAM);
    for (size_t i = 0; i < sizeof initial / sizeof *initial; i++)
        put_u16(slave->memory + initial[i].address, initial[i].value);
    put_u16(slave->memory + REG_FEATURES, features(slave->type));
    slave->memory[REG_PORTS] = port_descriptor(slave->type->sii->ports);
    slave->protected = slave->unlocked = 0;
    memset(slave->sm, 0, sizeof slave->sm);
    memset(slave->fmmu, 0, sizeof slave->fmmu);
    slave->sm_end = slave->fmmu_end = 0;
    slave_changed(slave);
    watchdog_configure(slave);
    sync_reset(slave);
    ports_reset(slave);
}
