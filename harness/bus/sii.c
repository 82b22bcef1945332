/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/slave_parts.h"

#include <string.h>

enum {
    STATUS_64_BIT = 0x40, /* eight bytes a read */
    STATUS_WRITE = 0x01,
    COMMAND = 0x07, /* in the second byte */
    COMMAND_READ = 1,
    COMMAND_WRITE = 2,
    COMMAND_RELOAD = 4,
    ERROR_CHECKSUM = 0x08,
    ERROR_LOAD = 0x10,
    ERROR_COMMAND = 0x20,
    ERROR_WRITE = 0x40,
    ERRORS = ERROR_CHECKSUM | ERROR_COMMAND | ERROR_WRITE, /* that any command clears */
    BUSY = 0x80,

    OWNER_PDI = 0x01,
    OWNER_FORCE = 0x02,
};

enum category {
    CAT_STRINGS = 10,
    CAT_GENERAL = 30,
    CAT_FMMU = 40,
    CAT_SM,
    CAT_TX = 50,
    CAT_RX,
    CAT_DC = 60
};

uint8_t sii_crc(const uint8_t *bytes, size_t length)
{
    uint8_t crc = 0xff;

    while (length--) {
        crc ^= *bytes++;
        for (int bit = 0; bit < 8; bit++)
            crc = (uint8_t)(crc & 0x80 ? crc << 1 ^ 0x07 : crc << 1);
    }
    return crc;
}

/* Appends within the image; once it does not fit, nothing more is written and the build fails. */
struct writer {
    uint8_t *image;
    size_t at;
    bool full;
};

static void add(struct writer *w, const void *bytes, size_t count)
{
    if (w->full || count > SII_SIZE - w->at) {
        w->full = true;
        return;
    }
    memcpy(w->image + w->at, bytes, count);
    w->at += count;
}

static void add_u8(struct writer *w, unsigned value)
{
    uint8_t byte = (uint8_t)value;

    add(w, &byte, 1);
}

static void add_u16(struct writer *w, unsigned value)
{
    uint8_t bytes[2];

    put_u16(bytes, value);
    add(w, bytes, 2);
}

static size_t begin(struct writer *w, enum category category)
{
    add_u16(w, category);
    add_u16(w, 0);
    return w->at;
}

/* Categories are counted in words; an odd one is padded. */
static void end(struct writer *w, size_t body, uint8_t pad)
{
    if ((w->at - body) & 1)
        add_u8(w, pad);
    if (!w->full)
        put_u16(w->image + body - 2, (uint32_t)(w->at - body) / 2);
}

/* String numbers used below; SOEM takes number 1 for the device's name, others go by `general`. */
enum string { STRING_NAME = 1, STRING_ORDER, STRING_GROUP };

static void add_strings(struct writer *w, const struct sii_info *info)
{
    const char *strings[] = { info->name, info->order, info->group };
    size_t body = begin(w, CAT_STRINGS);

    add_u8(w, 3);
    for (unsigned i = 0; i < 3; i++) {
        size_t length = strlen(strings[i]);

        add_u8(w, (unsigned)length);
        add(w, strings[i], length);
    }
    end(w, body, 0);
}

static void add_general(struct writer *w, const struct sii_info *info)
{
    uint8_t general[32] = { STRING_GROUP, 0, STRING_ORDER, STRING_NAME };
    size_t body = begin(w, CAT_GENERAL);

    general[5] = info->coe_details;
    general[11] = info->flags;
    put_u16(general + 12, (uint16_t)info->ebus_current);
    put_u16(general + 16, info->ports);
    add(w, general, sizeof general);
    end(w, body, 0);
}

static void add_managers(struct writer *w, const struct sii_info *info)
{
    size_t body = begin(w, CAT_FMMU);

    add(w, info->fmmu, info->fmmu_count);
    end(w, body, 0xff);
    body = begin(w, CAT_SM);
    for (unsigned i = 0; i < info->sm_count; i++) {
        const struct sii_sm *sm = &info->sm[i];

        add_u16(w, sm->start);
        add_u16(w, sm->length);
        add_u8(w, sm->control);
        add_u8(w, 0);
        add_u8(w, sm->enable);
        add_u8(w, sm->type);
    }
    end(w, body, 0);
}

static void add_pdos(struct writer *w, enum category category, const struct sii_pdo *pdo,
                     unsigned count)
{
    size_t body;

    if (!count)
        return;
    body = begin(w, category);
    for (; count--; pdo++) {
        add_u16(w, pdo->index);
        add_u8(w, pdo->entry_count);
        add_u8(w, pdo->sm);
        add_u16(w, 0);
        add_u16(w, pdo->flags);
        for (unsigned i = 0; i < pdo->entry_count; i++) {
            const struct sii_entry *e = &pdo->entries[i];

            add_u16(w, e->index);
            add_u8(w, e->subindex);
            add_u8(w, 0);
            add_u8(w, e->type);
            add_u8(w, e->bits);
            add_u16(w, 0);
        }
    }
    end(w, body, 0);
}

static void add_dc(struct writer *w, const struct sii_info *info)
{
    uint8_t dc[24] = { 0 };
    size_t body;

    if (!info->dc_assign)
        return;
    body = begin(w, CAT_DC);
    put_u16(dc + 14, info->dc_assign);
    add(w, dc, sizeof dc);
    end(w, body, 0);
}

static void put_header(uint8_t *image, const struct sii_info *info, uint32_t serial, uint16_t alias)
{
    put_u16(image + 0x00, info->pdi_control);
    put_u16(image + 0x02, info->pdi_config);
    put_u16(image + 0x04, info->sync_pulse);
    put_u16(image + 0x06, info->pdi_config_ext);
    put_u16(image + 0x08, alias);
    put_u16(image + 0x0e, sii_crc(image, 14));
    put_u32(image + 0x10, info->vendor);
    put_u32(image + 0x14, info->product);
    put_u32(image + 0x18, info->revision);
    put_u32(image + 0x1c, serial);
    put_u16(image + 0x30, info->mailbox.out_start);
    put_u16(image + 0x32, info->mailbox.out_size);
    put_u16(image + 0x34, info->mailbox.in_start);
    put_u16(image + 0x36, info->mailbox.in_size);
    put_u16(image + 0x38, info->protocols);
    put_u16(image + 0x7c, SII_SIZE / 128 - 1); /* kbit - 1 */
    put_u16(image + 0x7e, 1);
}

size_t sii_build(const struct sii_info *info, uint32_t serial, uint16_t alias,
                 uint8_t image[SII_SIZE])
{
    struct writer w = { image, 0x80, false };

    memset(image, 0, 0x80);
    memset(image + 0x80, 0xff, SII_SIZE - 0x80);
    put_header(image, info, serial, alias);
    add_strings(&w, info);
    add_general(&w, info);
    add_managers(&w, info);
    add_pdos(&w, CAT_TX, info->tx, info->tx_count);
    add_pdos(&w, CAT_RX, info->rx, info->rx_count);
    add_dc(&w, info);
    add_u16(&w, 0xffff);
    return w.full ? 0 : w.at;
}

static bool checksum_good(const uint8_t *image)
{
    return get_u16(image + 14) == 0x88a4 || sii_crc(image, 14) == image[14];
}

void sii_load(struct slave *slave, bool power_on)
{
    const uint8_t *image = slave->image;
    uint8_t *m = slave->memory;
    uint8_t *status = m + REG_EEPROM_CONTROL;
    bool good = checksum_good(image);

    status[0] = STATUS_64_BIT;
    status[1] = good ? 0 : ERROR_CHECKSUM | ERROR_LOAD;
    m[REG_DL_STATUS] = (uint8_t)((m[REG_DL_STATUS] & ~DL_STATUS_PDI) | (good ? DL_STATUS_PDI : 0));
    if (!good)
        return;
    m[REG_PDI_CONTROL] = image[0];
    memcpy(m + REG_PDI_CONFIG, image + 2, 2);
    memcpy(m + REG_PDI_CONFIG_EXT, image + 6, 2);
    memcpy(m + REG_DC_PULSE, image + 4, 2);
    /* Alias and controller configuration change at power-on only. */
    if (power_on) {
        m[REG_ESC_CONFIG] = image[1];
        memcpy(m + REG_STATION_ALIAS, image + 8, 2);
    }
}

static void read_words(struct slave *slave)
{
    uint32_t at = get_u32(slave->memory + REG_EEPROM_ADDRESS);

    for (unsigned i = 0; i < 8; i++) {
        uint64_t byte = (uint64_t)at * 2 + i;

        slave->memory[REG_EEPROM_DATA + i] = byte < SII_SIZE ? slave->image[byte] : 0xff;
    }
}

static void write_word(struct slave *slave)
{
    uint64_t at = (uint64_t)get_u32(slave->memory + REG_EEPROM_ADDRESS) * 2;

    if (at < SII_SIZE)
        memcpy(slave->image + at, slave->memory + REG_EEPROM_DATA, 2);
}

static void command(struct slave *slave, uint8_t low, uint8_t high)
{
    uint8_t *status = slave->memory + REG_EEPROM_CONTROL;
    uint64_t takes = SLAVE_SII_READ_NS;

    status[1] &= (uint8_t) ~(ERRORS | COMMAND);
    if (slave->faults.eeprom_nack && (high & COMMAND)) {
        status[1] |= ERROR_COMMAND;
        return;
    }
    switch (high & COMMAND) {
    case 0:
        return;
    case COMMAND_READ:
        read_words(slave);
        break;
    case COMMAND_WRITE:
        if (!(low & STATUS_WRITE)) {
            status[1] |= ERROR_WRITE;
            return;
        }
        write_word(slave);
        takes = SLAVE_SII_WRITE_NS;
        break;
    case COMMAND_RELOAD:
        sii_load(slave, false);
        break;
    default:
        status[1] |= ERROR_COMMAND;
        return;
    }
    status[1] |= (uint8_t)(BUSY | (high & COMMAND));
    slave->sii_busy_until = slave->now_ns + takes;
}

static void finish(struct slave *slave)
{
    if (slave->faults.eeprom_busy)
        slave->memory[REG_EEPROM_CONTROL + 1] |= BUSY;
    else if (slave->now_ns >= slave->sii_busy_until)
        slave->memory[REG_EEPROM_CONTROL + 1] &= (uint8_t) ~(BUSY | COMMAND);
}

/* Address and data may come in the same write as the command, or before it. */
bool sii_write(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    uint8_t *m = slave->memory;
    uint8_t status[2];
    bool commanded = false;

    if (address == REG_EEPROM_OWNER) {
        m[REG_EEPROM_OWNER] = data[0] & OWNER_FORCE ? 0 : (uint8_t)(data[0] & OWNER_PDI);
        return true;
    }
    finish(slave);
    if ((m[REG_EEPROM_OWNER] & OWNER_PDI) || (m[REG_EEPROM_CONTROL + 1] & BUSY))
        return false;
    memcpy(status, m + REG_EEPROM_CONTROL, 2);
    for (size_t i = 0; i < length; i++) {
        unsigned at = address + (unsigned)i;

        if (at == REG_EEPROM_CONTROL || at == REG_EEPROM_CONTROL + 1) {
            status[at - REG_EEPROM_CONTROL] = data[i];
            commanded |= at == REG_EEPROM_CONTROL + 1;
        } else {
            m[at] = data[i];
        }
    }
    if (commanded)
        command(slave, status[0], status[1]);
    return true;
}

void sii_refresh(struct slave *slave, uint16_t address, size_t length)
{
    (void)address, (void)length;
    finish(slave);
}
