/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The generic CiA 402 drives: rows that differ in axes, machines and limits. */
#include "bus/drive_device.h"
#include "bus/drive_rows.h"
#include "bus/identity.h"

static const struct drive_model servo = {
    .axis = &axis_servo,
    .modes = DRIVE_MODES,
    .error_communication = DRIVE_ERROR_COMMUNICATION,
    .error_following = DRIVE_ERROR_FOLLOWING,
};

/* As the servo, but its limit switches stop it. */
static const struct drive_model guarded = {
    .axis = &axis_servo,
    .modes = DRIVE_MODES,
    .error_communication = DRIVE_ERROR_COMMUNICATION,
    .error_following = DRIVE_ERROR_FOLLOWING,
    .stops_at_switches = true,
};

static const struct drive_model heavy = {
    .axis = &axis_heavy,
    .modes = DRIVE_MODES,
    .error_communication = DRIVE_ERROR_COMMUNICATION,
    .error_following = DRIVE_ERROR_FOLLOWING,
    .stops_at_switches = true,
};

static const struct drive_model rotary = {
    .axis = &axis_rotary,
    .modes = DRIVE_MODES,
    .error_communication = DRIVE_ERROR_COMMUNICATION,
    .error_following = DRIVE_ERROR_FOLLOWING,
};

static const struct drive_model ideal = {
    .axis = &axis_ideal,
    .modes = DRIVE_MODES,
    .error_communication = DRIVE_ERROR_COMMUNICATION,
    .error_following = DRIVE_ERROR_FOLLOWING,
};

#define SII(product_, name_, order_, axes_)                                                        \
    {                                                                                              \
        .vendor = BUS_VENDOR, .product = product_, .revision = BUS_REVISION,                       \
        .pdi_control = 0x0c08, /* 16-bit processor interface, SYNC and latch units */              \
            .name = name_, .order = order_, .group = "Simulated drives",                           \
        .mailbox = { 0x1000, 128, 0x1080, 128 }, .protocols = 0x0004,                              \
        .coe_details = 0x2f, /* SDO, info, PDO assign, PDO config, complete access */              \
            .ports = 0x0011,                                                                       \
        .sm = { { 0x1000, 128, 0x26, 0x01, SII_SM_MBX_OUT },                                       \
                { 0x1080, 128, 0x22, 0x01, SII_SM_MBX_IN },                                        \
                { 0x1100, 8 * (axes_), 0x64, 0x01, SII_SM_OUTPUTS },                               \
                { 0x1200, 20 * (axes_), 0x20, 0x01, SII_SM_INPUTS } },                             \
        .sm_count = 4, .fmmu = { 1, 2, 3 }, .fmmu_count = 3, .rx = drive_rx_pdos,                  \
        .rx_count = DRIVE_RX_MAPS / DRIVE_AXES * (axes_), .tx = drive_tx_pdos,                     \
        .tx_count = DRIVE_TX_MAPS / DRIVE_AXES * (axes_), .dc_assign = 0x0300,                     \
    }

/* One device type: its SII, its kind and its row. */
#define DRIVE(symbol_, type_, text_, product_, name_, od_, axes_, one_, two_)                      \
    static const struct sii_info symbol_##_sii = SII(product_, name_, type_, axes_);               \
    static const struct drive_kind symbol_##_kind = {                                              \
        .od = &od_,                                                                                \
        .sii = &symbol_##_sii,                                                                     \
        .axes = axes_,                                                                             \
        .history = 8,                                                                              \
        .model = { one_, two_ },                                                                   \
        .error_register = drive_error_register,                                                    \
        .history_entry = drive_history_entry,                                                      \
    };                                                                                             \
    const struct device_type dev_##symbol_ = {                                                     \
        .name = type_,                                                                             \
        .description = text_,                                                                      \
        .sii = &symbol_##_sii,                                                                     \
        .size = sizeof(struct drive_device),                                                       \
        .dc = true,                                                                                \
        .od = &od_,                                                                                \
        .model = &symbol_##_kind,                                                                  \
        .init = drive_device_init,                                                                 \
        .power_on = drive_device_power_on,                                                         \
        .state = drive_device_state,                                                               \
        .step = drive_device_step,                                                                 \
        .step_four = drive_device_step_four,                                                       \
        .outputs = drive_device_outputs,                                                           \
        .inputs = drive_device_inputs,                                                             \
        .set_input = drive_device_set_input,                                                       \
        .get_input = drive_device_get_input,                                                       \
        .free_input = drive_device_free_input,                                                     \
        .fault = drive_device_fault,                                                               \
    }

DRIVE(drive_cia402, "drive-cia402",
      "servo drive, one axis, CoE with CiA 402 (PP, PV, HM, CSP, CSV, CST)", BUS_PRODUCT_DRIVE,
      DRIVE_NAME, drive_od, 1, &servo, NULL);
DRIVE(drive_cia402x2, "drive-cia402x2",
      "servo drive, two axes, as drive-cia402; limit switches stop an axis", BUS_PRODUCT_DRIVE_X2,
      DRIVE_NAME_X2, drive_od_x2, 2, &guarded, &guarded);
DRIVE(drive_heavy, "drive-heavy", "servo drive, one axis with a heavy load; limit switches stop it",
      BUS_PRODUCT_DRIVE_HEAVY, DRIVE_NAME, drive_od, 1, &heavy, NULL);
DRIVE(drive_rotary, "drive-rotary", "servo drive, one endless rotary axis without stops",
      BUS_PRODUCT_DRIVE_ROTARY, DRIVE_NAME, drive_od, 1, &rotary, NULL);
DRIVE(drive_ideal, "drive-ideal",
      "servo drive without friction and following error: at its set point one cycle later",
      BUS_PRODUCT_DRIVE_IDEAL, DRIVE_NAME, drive_od, 1, &ideal, NULL);
