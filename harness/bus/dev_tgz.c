/* SPDX-License-Identifier: GPL-2.0-or-later */
/* tgz-1, tgz-2: the TG Drives TGZ with one and two axes; and the same with the native maps stored
 * in it. See tgz.h. */
#include "bus/identity.h"
#include "bus/registers.h"
#include "bus/tgz.h"

#include <errno.h>
#include <string.h>

enum { MISMATCHES = 8 }; /* of the cycle against SYNC before it is an error */

static void set_up(struct tgz_device *tgz)
{
    unsigned alias = tgz->drive.setup.alias;

    for (unsigned i = 0; i < DRIVE_AXES; i++) {
        struct drive *axis = &tgz->drive.axis[i];

        /* Position unit: 2^32 per revolution, divided by this. */
        axis->o.encoder[0] = 4096;
        axis->o.encoder[1] = 1;
        axis->o.options = (struct cia402_options){ .quick_stop = 2, .disable = 1 };
        axis->o.position_window = 512;
        axis->o.max_profile_velocity = UINT32_MAX;
        axis->modes = tgz_allowed_modes(tgz->reg[i].d_mode);
    }
    tgz->node_id = alias ? alias : 1; /* zero is not allowed */
}

static void init(void *device, const struct device_setup *setup)
{
    drive_device_init(device, setup);
    set_up(device);
}

static void power_on(void *device, uint64_t now_ns)
{
    struct tgz_device *tgz = device;
    uint8_t inputs = tgz->inputs;
    uint16_t analog[DRIVE_AXES] = { tgz->reg[0].analog, tgz->reg[1].analog };

    drive_device_power_on(device, now_ns);
    set_up(tgz);
    for (unsigned i = 0; i < DRIVE_AXES; i++) {
        tgz->reg[i].guard_due_ns = 0;
        tgz->reg[i].analog = analog[i];
    }
    tgz->inputs = inputs;
}

static void forget_periods(struct tgz_device *tgz)
{
    memset(tgz->pulse_ns, 0, sizeof tgz->pulse_ns);
    memset(tgz->period_ns, 0, sizeof tgz->period_ns);
    tgz->outputs_ns = 0;
    tgz->wrong_periods = 0;
}

static void state(void *device, unsigned al_state, uint64_t now_ns)
{
    if (al_state != AL_OP)
        forget_periods(device);
    drive_device_state(device, al_state, now_ns);
    tgz_watch(device);
}

static void step(void *device, uint64_t now_ns)
{
    tgz_pass(device, now_ns);
}

static void sync_pulse(void *device, unsigned signal, uint64_t now_ns)
{
    struct tgz_device *tgz = device;

    if (signal > 1)
        return;
    if (tgz->pulse_ns[signal])
        tgz->period_ns[signal] = now_ns - tgz->pulse_ns[signal];
    tgz->pulse_ns[signal] = now_ns;
    /* The period that counts is that of SYNC1, where it is in use. */
    tgz->sync_us = (uint32_t)(tgz->period_ns[tgz->pulse_ns[1] != 0] / 1000);
}

static void watch_period(struct tgz_device *tgz, uint64_t now_ns)
{
    uint64_t sync = tgz->period_ns[tgz->pulse_ns[1] != 0];
    uint64_t packet = tgz->outputs_ns ? now_ns - tgz->outputs_ns : 0;
    uint64_t away = packet > sync ? packet - sync : sync - packet;

    tgz->outputs_ns = now_ns;
    tgz->packet_us = (uint32_t)(packet / 1000);
    if (!sync || !packet || away <= sync / 4) {
        tgz->wrong_periods = 0;
        return;
    }
    if (++tgz->wrong_periods < MISMATCHES)
        return;
    tgz->wrong_periods = 0;
    for (unsigned i = 0; i < tgz->drive.kind->axes; i++)
        drive_fault(&tgz->drive.axis[i], TGZ_CODE_HOST);
}

/* Outputs 1..6 from both axes' control words: each has every other one. */
static uint8_t native_outputs(const struct tgz_device *tgz)
{
    unsigned outputs = 0;

    for (unsigned axis = 0; axis < DRIVE_AXES; axis++) {
        for (unsigned i = 0; i < 3; i++)
            outputs |= (tgz->reg[axis].control >> (TGZ_CONTROL_OUTPUTS + i) & 1u) << (2 * i + axis);
    }
    return (uint8_t)outputs;
}

static uint8_t profile_outputs(const struct tgz_device *tgz)
{
    const uint32_t *o = tgz->drive.axis[0].o.user_outputs;

    return (uint8_t)((o[0] & o[1]) >> 16 & 0x3f);
}

static void limit_current(struct drive *axis, uint16_t limit)
{
    int left = limit < TGZ_FULL_SCALE ? TGZ_FULL_SCALE - limit : 0;

    axis->o.max_torque = (uint16_t)(left * axis->axis.peak * 1000.0 / TGZ_FULL_SCALE);
}

static void outputs(void *device, const uint8_t *data, size_t length, uint64_t now_ns)
{
    struct tgz_device *tgz = device;
    bool native = tgz_is_native(tgz);

    (void)length;
    pdo_outputs_to_objects(&tgz_od, device, data);
    for (unsigned i = 0; i < tgz->drive.kind->axes; i++) {
        struct drive *axis = &tgz->drive.axis[i];

        limit_current(axis, tgz->reg[i].current_limit);
        if (native) {
            tgz_native_command(tgz, i, now_ns);
        } else {
            axis->fine = false;
            drive_command(axis, now_ns);
        }
    }
    tgz->outputs = native ? native_outputs(tgz) : profile_outputs(tgz);
    watch_period(tgz, now_ns);
    tgz_watch(tgz);
}

void tgz_refresh(void *device)
{
    drive_device_refresh(device);
    tgz_publish(device);
}

static void inputs(void *device, uint8_t *data, size_t length)
{
    (void)length;
    tgz_refresh(device);
    pdo_objects_to_inputs(&tgz_od, device, data);
}

/* --- the outside world --- */

enum { CHANNEL_INPUTS = 16, INPUTS = 8, CHANNEL_ANALOG = 64 };

static void set_digital(struct tgz_device *tgz, unsigned input, bool value)
{
    tgz->inputs = (uint8_t)drive_with_bit(tgz->inputs, input, value);
    for (unsigned i = 0; i < tgz->drive.kind->axes; i++) {
        tgz->drive.axis[i].user_inputs = (uint32_t)tgz->inputs << CHANNEL_INPUTS;
        tgz->drive.axis[i].stale = true;
    }
}

static int set_input(void *device, unsigned channel, int64_t value)
{
    struct tgz_device *tgz = device;
    int error = 0;

    if (channel >= CHANNEL_ANALOG) {
        if (channel - CHANNEL_ANALOG >= DRIVE_AXES || value < 0 || value > TGZ_FULL_SCALE)
            return -EINVAL;
        tgz->reg[channel - CHANNEL_ANALOG].analog = (uint16_t)value;
    } else if (channel >= CHANNEL_INPUTS && channel < CHANNEL_INPUTS + INPUTS) {
        if (value < 0 || value > 1)
            return -EINVAL;
        set_digital(tgz, channel - CHANNEL_INPUTS, value);
    } else if (channel % DRIVE_INPUTS >= CHANNEL_INPUTS) {
        return -EINVAL;
    } else {
        error = drive_device_set_input(device, channel, value);
    }
    tgz_watch(tgz);
    return error;
}

static int get_input(const void *device, unsigned channel, int64_t *value)
{
    const struct tgz_device *tgz = device;

    if (channel >= CHANNEL_ANALOG && channel < CHANNEL_ANALOG + DRIVE_AXES)
        *value = tgz->reg[channel - CHANNEL_ANALOG].analog;
    else if (channel >= CHANNEL_INPUTS && channel < CHANNEL_INPUTS + INPUTS)
        *value = tgz->inputs >> (channel - CHANNEL_INPUTS) & 1;
    else if (channel < CHANNEL_ANALOG && channel % DRIVE_INPUTS < CHANNEL_INPUTS)
        return drive_device_get_input(device, channel, value);
    else
        return -EINVAL;
    return 0;
}

static void free_input(void *device, unsigned channel)
{
    if (channel < CHANNEL_ANALOG && channel % DRIVE_INPUTS < CHANNEL_INPUTS)
        drive_device_free_input(device, channel);
    else
        set_input(device, channel, 0);
}

static int fault(void *device, unsigned axis, uint16_t code, uint64_t now_ns)
{
    struct tgz_device *tgz = device;
    int bit = tgz_error_bit(code);

    (void)now_ns;
    if (axis >= tgz->drive.kind->axes || bit < 0)
        return -EINVAL;
    /* Further errors join the first. */
    if (tgz->reg[axis].errors && !(tgz->reg[axis].errors >> bit & 1))
        drive_device_remember(&tgz->drive, tgz_history_entry(axis, code));
    if (tgz->reg[axis].errors)
        tgz->reg[axis].errors |= 1u << bit;
    else
        drive_fault(&tgz->drive.axis[axis], code);
    tgz_watch(tgz);
    return 0;
}

/* --- object dictionary --- */

/* Axis of a register: groups 0x23 and 0x24, 0x31 and 0x32, 0x33 and 0x34. */
static unsigned register_axis(uint16_t index)
{
    return !(index >> 8 & 1);
}

static uint32_t check_resolution(const struct tgz_device *tgz, uint16_t index, uint8_t subindex,
                                 int64_t value)
{
    const struct drive *axis = &tgz->drive.axis[drive_object_axis(index)];

    if (cia402_powered(&axis->machine))
        return SDO_DEVICE_STATE;
    if (value < 1 || (subindex == 1 && value < axis->o.encoder[1]) ||
        (subindex == 2 && value > axis->o.encoder[0]))
        return SDO_RANGE;
    return SDO_OK;
}

uint32_t tgz_check(void *device, uint16_t index, uint8_t subindex, int64_t value)
{
    if ((index == 0x1c12 || index == 0x1c13) && subindex == 0 && value > 1)
        return SDO_RANGE; /* one map each */
    if (index == 0x2303 || index == 0x2403)
        return tgz_allowed_modes((uint32_t)value) ? SDO_OK : SDO_RANGE;
    if (index < 0x6000)
        return index == 0x1003 && value ? SDO_RANGE : SDO_OK;
    if (drive_object_base(index) == 0x608f)
        return check_resolution(device, index, subindex, value);
    return drive_device_check(device, index, subindex, value);
}

static void written_register(struct tgz_device *tgz, uint16_t index)
{
    unsigned n = register_axis(index);
    struct drive *axis = &tgz->drive.axis[n];

    switch (index - 0x100u * n) {
    case 0x2303:
        axis->modes = tgz_allowed_modes(tgz->reg[n].d_mode);
        if (!axis->o.mode_display || !(axis->modes & DRIVE_MODE(axis->o.mode_display)))
            axis->o.mode_display = 0;
        drive_command(axis, axis->next_ns);
        break;
    case 0x2317: /* an emergency stop always takes its own ramp */
        axis->o.error_mask |= 1u << TGZ_ERROR_EMERGENCY;
        break;
    case 0x2319:
        tgz_guard_start(tgz, n);
        break;
    case 0x310d:
        if (tgz->reg[n].guard_reset == TGZ_GUARD_KEY)
            tgz_guard_start(tgz, n);
        break;
    }
}

void tgz_written(void *device, uint16_t index, uint8_t subindex)
{
    struct tgz_device *tgz = device;
    struct drive *axis = &tgz->drive.axis[drive_object_axis(index)];

    if (index >= 0x2100 && index < 0x4000)
        written_register(tgz, index);
    else if (index >= 0x6000 && drive_object_base(index) == 0x608f)
        drive_resolution(axis, 4294967296.0 * axis->o.encoder[1] / axis->o.encoder[0]);
    else if (index >= 0x6000)
        drive_device_written(device, index, subindex);
    tgz_watch(tgz);
}

/* --- rows --- */

static const struct drive_model model = {
    .axis = &axis_servo,
    .modes = TGZ_MODES,
    .error_communication = TGZ_CODE_HOST,
    .error_following = TGZ_CODE_FOLLOWING,
    .error_step = TGZ_CODE_STEP,
    .error_bit = tgz_error_bit,
};

/* One SII for all: variants differ in what the drive has stored as its mapping. */
#define SII(map_, bytes_)                                                                          \
    {                                                                                              \
        .vendor = BUS_VENDOR, .product = BUS_PRODUCT_TGZ, .revision = BUS_REVISION,                \
        .pdi_control = 0x0c08, .name = "TGZ Drive V5", .order = "TGZ", .group = "TGZ-Drives",      \
        .mailbox = { 0x1800, 32, 0x1c00, 32 }, .protocols = 0x0004,                                \
        .coe_details = 0x07, /* SDO, info, PDO assign */                                           \
            .ports = 0x0011,                                                                       \
        .sm = { { 0x1800, 32, 0x26, 0x01, SII_SM_MBX_OUT },                                        \
                { 0x1c00, 32, 0x22, 0x01, SII_SM_MBX_IN },                                         \
                { 0x1000, bytes_, 0x64, 0x01, SII_SM_OUTPUTS },                                    \
                { 0x1400, bytes_, 0x20, 0x01, SII_SM_INPUTS } },                                   \
        .sm_count = 4, .fmmu = { 1, 2 }, .fmmu_count = 2, .rx = tgz_rx_##map_,                     \
        .rx_count = TGZ_RX_MAPS, .tx = tgz_tx_##map_, .tx_count = TGZ_TX_MAPS,                     \
        .dc_assign = 0x0700, /* SYNC0 and SYNC1 */                                                 \
    }

static const struct sii_info sii_coe = SII(coe, TGZ_COE_BYTES);
static const struct sii_info sii_native = SII(native, TGZ_NATIVE_BYTES);

#define TGZ(symbol_, type_, text_, map_, axes_)                                                    \
    static const struct drive_kind symbol_##_kind = {                                              \
        .od = &tgz_od,                                                                             \
        .sii = &sii_##map_,                                                                        \
        .axes = axes_,                                                                             \
        .history = DRIVE_HISTORY,                                                                  \
        .model = { &model, &model },                                                               \
        .error_register = tgz_error_register,                                                      \
        .history_entry = tgz_history_entry,                                                        \
    };                                                                                             \
    const struct device_type dev_##symbol_ = {                                                     \
        .name = type_,                                                                             \
        .description = text_,                                                                      \
        .sii = &sii_##map_,                                                                        \
        .size = sizeof(struct tgz_device),                                                         \
        .dc = true,                                                                                \
        .od = &tgz_od,                                                                             \
        .model = &symbol_##_kind,                                                                  \
        .init = init,                                                                              \
        .power_on = power_on,                                                                      \
        .state = state,                                                                            \
        .step = step,                                                                              \
        .outputs = outputs,                                                                        \
        .inputs = inputs,                                                                          \
        .sync = sync_pulse,                                                                        \
        .set_input = set_input,                                                                    \
        .get_input = get_input,                                                                    \
        .free_input = free_input,                                                                  \
        .fault = fault,                                                                            \
    }

TGZ(tgz_1, "tgz-1", "TG Drives TGZ, one axis, CiA 402 maps (1701, 1B01)", coe, 1);
TGZ(tgz_2, "tgz-2", "TG Drives TGZ, two axes, CiA 402 maps (1701, 1B01)", coe, 2);
TGZ(tgz_1_native, "tgz-1-native", "TG Drives TGZ, one axis, native maps (1721, 1B21)", native, 1);
TGZ(tgz_2_native, "tgz-2-native", "TG Drives TGZ, two axes, native maps (1721, 1B21)", native, 2);
