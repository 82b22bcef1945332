/* SPDX-License-Identifier: GPL-2.0-or-later */
/* dio-8x8: a digital terminal without a processor. Eight inputs follow the stimuli; eight outputs
 * drive their pins in OP while the process data watchdog is fed, and are low otherwise. What the
 * pins really do can be read at register 0x0F10. */
#include "bus/device.h"
#include "bus/identity.h"
#include "bus/registers.h"

#include <errno.h>

enum { CHANNELS = 8, OUTPUTS_AT = REG_DIGITAL_OUT, INPUTS_AT = REG_RAM, TYPE_BOOL = 1 };

struct dio {
    const struct bus_stimulus *stimuli;
    size_t stimulus_count;
    uint8_t inputs, pins;
    uint8_t held, levels; /* inputs that no longer follow the stimuli, and what they are held at */
};

static void dio_init(void *device, const struct device_setup *setup)
{
    struct dio *dio = device;

    dio->stimuli = setup->stimuli;
    dio->stimulus_count = setup->stimulus_count;
}

static void dio_state(void *device, unsigned state, uint64_t now_ns)
{
    struct dio *dio = device;

    (void)now_ns;
    if (state != AL_OP)
        dio->pins = 0;
}

static bool high(const struct bus_stimulus *s, uint64_t now_ns)
{
    return now_ns >= s->phase_ns && s->period_ns &&
           (now_ns - s->phase_ns) % s->period_ns < s->period_ns / 2;
}

static void dio_step(void *device, uint64_t now_ns)
{
    struct dio *dio = device;

    dio->inputs = 0;
    for (size_t i = 0; i < dio->stimulus_count; i++) {
        const struct bus_stimulus *s = &dio->stimuli[i];

        if (s->bit < CHANNELS && high(s, now_ns))
            dio->inputs |= (uint8_t)(1u << s->bit);
    }
    dio->inputs = (uint8_t)((dio->inputs & ~dio->held) | dio->levels);
}

static int dio_set_input(void *device, unsigned channel, int64_t value)
{
    struct dio *dio = device;
    uint8_t mask = (uint8_t)(1u << channel % CHANNELS);

    if (channel >= CHANNELS || value < 0 || value > 1)
        return -EINVAL;
    dio->held |= mask;
    dio->levels = (uint8_t)((dio->levels & ~mask) | (value ? mask : 0));
    return 0;
}

static int dio_get_input(const void *device, unsigned channel, int64_t *value)
{
    const struct dio *dio = device;

    if (channel >= CHANNELS)
        return -EINVAL;
    *value = dio->inputs >> channel & 1;
    return 0;
}

static void dio_free_input(void *device, unsigned channel)
{
    struct dio *dio = device;
    uint8_t mask = (uint8_t)(1u << channel % CHANNELS);

    dio->held &= (uint8_t)~mask;
    dio->levels &= (uint8_t)~mask;
}

static void dio_outputs(void *device, const uint8_t *data, size_t length, uint64_t now_ns)
{
    struct dio *dio = device;

    (void)now_ns;
    if (length)
        dio->pins = data[0];
}

static void dio_inputs(void *device, uint8_t *data, size_t length)
{
    const struct dio *dio = device;

    if (length)
        data[0] = dio->inputs;
}

static void dio_watchdog(void *device, uint64_t now_ns)
{
    struct dio *dio = device;

    (void)now_ns;
    dio->pins = 0;
}

static uint32_t dio_pins(const void *device)
{
    const struct dio *dio = device;

    return dio->pins;
}

#define CHANNEL(base, n)                                                                           \
    (const struct sii_entry[])                                                                     \
    {                                                                                              \
        {                                                                                          \
            .index = (base) + 0x10 * (n), .subindex = 1, .type = TYPE_BOOL, .bits = 1              \
        }                                                                                          \
    }
#define PDO(map, base, n, manager)                                                                 \
    {                                                                                              \
        .index = (map) + (n), .sm = (manager), .flags = 0x11, .entries = CHANNEL(base, n),         \
        .entry_count = 1                                                                           \
    }
#define PDOS(map, base, manager)                                                                   \
    PDO(map, base, 0, manager), PDO(map, base, 1, manager), PDO(map, base, 2, manager),            \
        PDO(map, base, 3, manager), PDO(map, base, 4, manager), PDO(map, base, 5, manager),        \
        PDO(map, base, 6, manager), PDO(map, base, 7, manager)

static const struct sii_pdo outputs[] = { PDOS(0x1600, 0x7000, 0) };
static const struct sii_pdo inputs[] = { PDOS(0x1a00, 0x6000, 1) };

static const struct sii_info dio_sii = {
    .vendor = BUS_VENDOR,
    .product = BUS_PRODUCT_DIO,
    .revision = BUS_REVISION,
    .pdi_control = 0x0104, /* digital I/O, device emulation */
    .pdi_config_ext = 0x00ff,
    .name = "Simulated DIO 8 in 8 out",
    .order = "dio-8x8",
    .group = "Simulated terminals",
    .ebus_current = 120,
    .ports = 0x0011,
    .sm = { { OUTPUTS_AT, 1, 0x44, 0x09, SII_SM_OUTPUTS },
            { INPUTS_AT, 1, 0x00, 0x01, SII_SM_INPUTS } },
    .sm_count = 2,
    .fmmu = { 1, 2 },
    .fmmu_count = 2,
    .rx = outputs,
    .rx_count = CHANNELS,
    .tx = inputs,
    .tx_count = CHANNELS,
};

const struct device_type dev_dio_8x8 = {
    .name = "dio-8x8",
    .description = "digital terminal, 8 inputs and 8 outputs, no mailbox",
    .sii = &dio_sii,
    .size = sizeof(struct dio),
    .al_emulation = true,
    .init = dio_init,
    .state = dio_state,
    .step = dio_step,
    .outputs = dio_outputs,
    .inputs = dio_inputs,
    .watchdog = dio_watchdog,
    .pins = dio_pins,
    .set_input = dio_set_input,
    .get_input = dio_get_input,
    .free_input = dio_free_input,
};
