/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * sii.h - the slave information interface: what a device says about itself in its EEPROM, the
 * builder that turns it into the image, and the register interface through which masters read it.
 */
#ifndef HARNESS_BUS_SII_H
#define HARNESS_BUS_SII_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SII_SIZE     2048 /* 16 kbit, the common size */
#define SII_MAX_SM   8
#define SII_MAX_FMMU 8

enum sii_sm_type { SII_SM_UNUSED, SII_SM_MBX_OUT, SII_SM_MBX_IN, SII_SM_OUTPUTS, SII_SM_INPUTS };

struct sii_sm {
    uint16_t start, length;
    uint8_t control;
    uint8_t enable; /* bit 0 enable, 1 fixed, 2 virtual, 3 OP only */
    uint8_t type;   /* enum sii_sm_type */
};

struct sii_entry {
    uint16_t index; /* 0: gap */
    uint8_t subindex, type, bits;
};

struct sii_pdo {
    uint16_t index;
    uint8_t sm;     /* 0xff: not assigned by default */
    uint16_t flags; /* 0x01 mandatory, 0x02 default, 0x10 content fixed */
    const struct sii_entry *entries;
    uint8_t entry_count;
};

struct sii_mailbox {
    uint16_t out_start, out_size, in_start, in_size;
};

struct sii_info {
    uint32_t vendor, product, revision;
    uint16_t pdi_control, pdi_config, sync_pulse, pdi_config_ext; /* words 0..3 */
    const char *name, *order, *group;
    struct sii_mailbox mailbox; /* zero: none */
    uint16_t protocols;         /* 0x04 CoE */
    uint8_t coe_details;
    uint8_t flags;        /* of the general category: 0x08 device id by AL status */
    int16_t ebus_current; /* mA */
    uint16_t ports;       /* nibble per port, lowest first: 1 MII, 3 EBUS */
    struct sii_sm sm[SII_MAX_SM];
    uint8_t sm_count;
    uint8_t fmmu[SII_MAX_FMMU]; /* 1 outputs, 2 inputs, 3 mailbox state */
    uint8_t fmmu_count;
    const struct sii_pdo *tx, *rx;
    uint8_t tx_count, rx_count;
    uint16_t dc_assign; /* AssignActivate; 0: no DC category */
};

/* CRC-8 over the configuration area (words 0..6): polynomial 0x07, start 0xFF, not reflected. */
uint8_t sii_crc(const uint8_t *bytes, size_t length);

/* Fills image[SII_SIZE]. Returns the bytes used, 0 when the content does not fit. */
size_t sii_build(const struct sii_info *info, uint32_t serial, uint16_t alias,
                 uint8_t image[SII_SIZE]);

struct slave;

/* Takes the configuration area over into the registers, as at power-on. */
void sii_load(struct slave *slave, bool power_on);
/* Register block 0x0500..0x050F. */
bool sii_write(struct slave *slave, uint16_t address, const uint8_t *data, size_t length);
void sii_refresh(struct slave *slave, uint16_t address, size_t length);

#endif
