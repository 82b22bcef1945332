/* SPDX-License-Identifier: GPL-2.0-or-later */
/* drive-cia402: a single-axis servo drive with CoE. */
#include "bus/device.h"
#include "bus/drive.h"
#include "bus/identity.h"

#include <errno.h>

static void init(void *device, const struct device_setup *setup)
{
    struct drive_device *drive = device;

    drive_od_defaults(drive);
    drive->serial = setup->serial;
    drive_init(&drive->axis, setup->seed);
}

static void power_on(void *device, uint64_t now_ns)
{
    struct drive_device *drive = device;

    drive_od_defaults(drive);
    drive_power_on(&drive->axis, now_ns);
}

/* CiA 301: bit 0 any error, 4 communication, 5 device profile. */
static uint8_t error_register(uint16_t error_code)
{
    switch (error_code) {
    case 0:
        return 0;
    case DRIVE_ERROR_COMMUNICATION:
        return 0x11;
    default:
        return 0x21;
    }
}

void drive_refresh(void *device)
{
    struct drive_device *drive = device;

    drive_publish(&drive->axis);
    drive->error_register = error_register(drive->axis.o.error_code);
}

static void state(void *device, unsigned al_state, uint64_t now_ns)
{
    struct drive_device *drive = device;

    (void)now_ns;
    drive_al_state(&drive->axis, al_state);
}

static void step(void *device, uint64_t now_ns)
{
    struct drive_device *drive = device;

    drive_step(&drive->axis, now_ns);
}

static void outputs(void *device, const uint8_t *data, size_t length, uint64_t now_ns)
{
    struct drive_device *drive = device;

    (void)length; /* the sync manager has the length of the mapping since SAFEOP */
    pdo_outputs_to_objects(&drive_od, device, data);
    drive_command(&drive->axis, now_ns);
}

static void inputs(void *device, uint8_t *data, size_t length)
{
    (void)length;
    drive_refresh(device);
    pdo_objects_to_inputs(&drive_od, device, data);
}

static int fault(void *device, unsigned axis, uint16_t code, uint64_t now_ns)
{
    struct drive_device *drive = device;

    (void)now_ns;
    if (axis)
        return -EINVAL;
    drive_fault(&drive->axis, code);
    drive->axis.stale = true;
    return 0;
}

/* A controlword or mode by SDO works like one by PDO; in OP the next process data overrules it. */
void drive_written(void *device, uint16_t index, uint8_t subindex)
{
    struct drive_device *drive = device;

    (void)subindex;
    if (index == 0x6040 || index == 0x6060)
        drive_command(&drive->axis, drive->axis.next_ns);
}

static const struct sii_info drive_sii = {
    .vendor = BUS_VENDOR,
    .product = BUS_PRODUCT_DRIVE,
    .revision = BUS_REVISION,
    .pdi_control = 0x0c08, /* 16-bit processor interface, SYNC and latch units */
    .name = DRIVE_NAME,
    .order = "drive-cia402",
    .group = "Simulated drives",
    .mailbox = { 0x1000, 128, 0x1080, 128 },
    .protocols = 0x0004,
    .coe_details = 0x2f, /* SDO, info, PDO assign, PDO config, complete access */
    .ports = 0x0011,
    .sm = { { 0x1000, 128, 0x26, 0x01, SII_SM_MBX_OUT },
            { 0x1080, 128, 0x22, 0x01, SII_SM_MBX_IN },
            { 0x1100, 8, 0x64, 0x01, SII_SM_OUTPUTS },
            { 0x1200, 20, 0x20, 0x01, SII_SM_INPUTS } },
    .sm_count = 4,
    .fmmu = { 1, 2, 3 },
    .fmmu_count = 3,
    .rx = drive_rx_pdos,
    .rx_count = DRIVE_RX_MAPS,
    .tx = drive_tx_pdos,
    .tx_count = DRIVE_TX_MAPS,
    .dc_assign = 0x0300,
};

const struct device_type dev_drive_cia402 = {
    .name = "drive-cia402",
    .description = "servo drive, one axis, CoE with CiA 402 (PP, PV, HM, CSP, CSV, CST)",
    .sii = &drive_sii,
    .size = sizeof(struct drive_device),
    .dc = true,
    .od = &drive_od,
    .init = init,
    .power_on = power_on,
    .state = state,
    .step = step,
    .outputs = outputs,
    .inputs = inputs,
    .fault = fault,
};
