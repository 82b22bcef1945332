/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/terminal.h"
#include "bus/bytes.h"
#include "bus/registers.h"
#include "bus/stimulus.h"

#include <errno.h>
#include <string.h>

enum { STATUS_UNDER = 0x01, STATUS_OVER = 0x02, STATUS_ERROR = 0x40 };

static uint8_t *at(struct terminal *terminal, uint32_t offset)
{
    return (uint8_t *)terminal + offset;
}

static struct terminal_input *inputs_of(struct terminal *terminal)
{
    return (struct terminal_input *)(void *)at(terminal, terminal->type->held);
}

static struct terminal_move *moves_of(struct terminal *terminal, enum pdo_direction direction)
{
    return (struct terminal_move *)(void *)at(terminal, terminal->type->direction[direction].moves);
}

static const struct terminal_pdo *find_pdo(const struct terminal_direction *direction,
                                           uint16_t index)
{
    for (unsigned i = 0; i < direction->pdo_count; i++) {
        if (direction->pdos[i].index == index)
            return &direction->pdos[i];
    }
    return NULL;
}

/* False: more than the type has altogether, or than its sync manager holds. */
static bool append(struct terminal *terminal, enum pdo_direction d, const struct terminal_pdo *pdo)
{
    struct terminal_move *moves = moves_of(terminal, d);

    for (unsigned i = 0; i < pdo->count; i++) {
        const struct terminal_entry *e = &pdo->entries[i];

        if (e->cell != TERMINAL_NO_CELL) {
            if (terminal->move_count[d] == terminal->type->direction[d].entry_count)
                return false;
            moves[terminal->move_count[d]++] =
                (struct terminal_move){ e->cell, terminal->mapped[d].bits, e->bits, e->bytes };
        }
        terminal->mapped[d].bits = (uint16_t)(terminal->mapped[d].bits + e->bits);
        if (terminal->mapped[d].bits > terminal->type->direction[d].max_bytes * 8u)
            return false;
    }
    return true;
}

static bool append_assigned(struct terminal *terminal, enum pdo_direction d)
{
    const struct terminal_direction *direction = &terminal->type->direction[d];
    const uint8_t *list = at(terminal, direction->assign_pdos);
    unsigned count = *at(terminal, direction->assign_count);

    for (unsigned i = 0; i < count; i++) {
        uint64_t index = od_load(list + 2 * i, 2);
        const struct terminal_pdo *pdo = find_pdo(direction, (uint16_t)index);

        for (unsigned k = 0; k < i; k++) {
            if (od_load(list + 2 * k, 2) == index)
                return false;
        }
        if (!pdo || !append(terminal, d, pdo))
            return false;
    }
    return true;
}

static bool append_default(struct terminal *terminal, enum pdo_direction d)
{
    const struct terminal_direction *direction = &terminal->type->direction[d];

    for (unsigned i = 0; i < direction->pdo_count; i++) {
        if (direction->pdos[i].assigned && !append(terminal, d, &direction->pdos[i]))
            return false;
    }
    return true;
}

static uint16_t resolve(void *device, enum pdo_direction d)
{
    struct terminal *terminal = device;
    uint16_t refusal = d == PDO_RX ? AL_CODE_OUTPUT_MAPPING : AL_CODE_INPUT_MAPPING;

    terminal->move_count[d] = 0;
    memset(&terminal->mapped[d], 0, sizeof terminal->mapped[d]);
    memset(at(terminal, terminal->type->image), 0, terminal->type->direction[PDO_TX].max_bytes);
    terminal->stale = true;
    if (terminal->type->direction[d].assign_count != TERMINAL_NO_CELL)
        return append_assigned(terminal, d) ? 0 : refusal;
    return append_default(terminal, d) ? 0 : refusal;
}

static void outputs_safe(struct terminal *terminal)
{
    const struct terminal_type *type = terminal->type;

    if (type->hold)
        return;
    for (unsigned i = 0; i < type->output_count; i++)
        od_store(at(terminal, type->outputs[i].cell), type->outputs[i].bytes,
                 (uint64_t)type->outputs[i].safe);
}

static void terminal_init(void *device, const struct device_setup *setup)
{
    struct terminal *terminal = device;

    terminal->type = setup->type->model;
    terminal->identity = setup->identity;
    terminal->serial = setup->serial;
    terminal->seed = setup->seed;
    terminal->stimuli = setup->stimuli;
    terminal->stimulus_count = setup->stimulus_count;
    outputs_safe(terminal);
    resolve(device, PDO_RX);
    resolve(device, PDO_TX);
}

static void terminal_power_on(void *device, uint64_t now_ns)
{
    (void)now_ns;
    outputs_safe(device);
    resolve(device, PDO_RX);
    resolve(device, PDO_TX);
}

static void terminal_state(void *device, unsigned state, uint64_t now_ns)
{
    struct terminal *terminal = device;

    (void)now_ns;
    terminal->stale = true;
    if (state != AL_OP)
        outputs_safe(terminal);
}

static void take(struct terminal *terminal, unsigned channel, int64_t value)
{
    struct terminal_input *input = &inputs_of(terminal)[channel];

    if (input->value == value)
        return;
    input->value = value;
    terminal->stale = true;
}

static void stimulate(struct terminal *terminal, unsigned channel, uint64_t now_ns)
{
    bool digital = terminal->type->inputs[channel].digital, any = false;
    int64_t sum = 0;

    if (inputs_of(terminal)[channel].held)
        return;
    for (size_t i = 0; i < terminal->stimulus_count; i++) {
        const struct bus_stimulus *s = &terminal->stimuli[i];

        if (s->bit != channel)
            continue;
        any = true;
        if (digital)
            sum |= stimulus_high(s, terminal->seed, now_ns);
        else
            sum += stimulus_value(s, terminal->seed, now_ns);
    }
    if (any)
        take(terminal, channel, sum);
}

static void terminal_step(void *device, uint64_t now_ns)
{
    struct terminal *terminal = device;

    if (now_ns < terminal->next_ns)
        return;
    for (unsigned i = 0; i < terminal->type->input_count; i++)
        stimulate(terminal, i, now_ns);
    terminal->next_ns = STIMULUS_NEVER;
    for (size_t i = 0; i < terminal->stimulus_count; i++) {
        uint64_t next = stimulus_next(&terminal->stimuli[i], now_ns);

        if (next < terminal->next_ns)
            terminal->next_ns = next;
    }
}

static void terminal_outputs(void *device, const uint8_t *data, size_t length, uint64_t now_ns)
{
    struct terminal *terminal = device;
    const struct terminal_move *move = moves_of(terminal, PDO_RX);

    (void)now_ns;
    for (unsigned i = 0; i < terminal->move_count[PDO_RX]; i++, move++) {
        if (move->bit + move->bits <= length * 8)
            od_store(at(terminal, move->cell), move->bytes, get_bits(data, move->bit, move->bits));
    }
}

static void set_flag(struct terminal *terminal, uint32_t cell, unsigned value)
{
    if (cell != TERMINAL_NO_CELL)
        *at(terminal, cell) = (uint8_t)value;
}

/* A value beyond the converter saturates, and the channel says so. */
static void publish(struct terminal *terminal, unsigned n)
{
    const struct terminal_channel *channel = &terminal->type->inputs[n];
    int64_t value = inputs_of(terminal)[n].value;
    bool under = value<channel->least, over = value> channel->most;

    value = under ? channel->least : over ? channel->most : value;
    od_store(at(terminal, channel->cell), channel->bytes, (uint64_t)value);
    set_flag(terminal, channel->flag[TERMINAL_STATUS],
             (under ? STATUS_UNDER : 0u) | (over ? STATUS_OVER : 0u) |
                 (under || over ? STATUS_ERROR : 0u));
    set_flag(terminal, channel->flag[TERMINAL_UNDER], under);
    set_flag(terminal, channel->flag[TERMINAL_OVER], over);
    set_flag(terminal, channel->flag[TERMINAL_ERROR], under || over);
}

static void terminal_inputs(void *device, uint8_t *data, size_t length)
{
    struct terminal *terminal = device;
    const struct terminal_move *move = moves_of(terminal, PDO_TX);
    uint8_t *image = at(terminal, terminal->type->image);
    size_t room = terminal->type->direction[PDO_TX].max_bytes;

    if (terminal->stale) {
        terminal->stale = false;
        for (unsigned i = 0; i < terminal->type->input_count; i++)
            publish(terminal, i);
        for (unsigned i = 0; i < terminal->move_count[PDO_TX]; i++, move++)
            put_bits(image, move->bit, move->bits, od_load(at(terminal, move->cell), move->bytes));
    }
    memcpy(data, image, length < room ? length : room);
}

static void terminal_watchdog(void *device, uint64_t now_ns)
{
    (void)now_ns;
    outputs_safe(device);
}

static uint32_t terminal_pins(const void *device)
{
    const struct terminal *terminal = device;
    uint32_t pins = 0;

    for (unsigned i = 0; i < terminal->type->output_count && i < 32; i++) {
        const struct terminal_channel *channel = &terminal->type->outputs[i];

        if (channel->digital && *((const uint8_t *)device + channel->cell))
            pins |= 1u << i;
    }
    return pins;
}

static int terminal_set_input(void *device, unsigned channel, int64_t value)
{
    struct terminal *terminal = device;

    if (channel >= terminal->type->input_count)
        return -EINVAL;
    if (terminal->type->inputs[channel].digital && (value < 0 || value > 1))
        return -EINVAL;
    inputs_of(terminal)[channel].held = true;
    take(terminal, channel, value);
    return 0;
}

static int terminal_get_input(const void *device, unsigned channel, int64_t *value)
{
    const struct terminal *terminal = device;
    const struct terminal_channel *c;
    const struct terminal_input *input;

    if (channel >= terminal->type->input_count)
        return -EINVAL;
    c = &terminal->type->inputs[channel];
    input = (const struct terminal_input *)(const void *)((const uint8_t *)device +
                                                          terminal->type->held) +
            channel;
    *value = input->value < c->least ? c->least : input->value > c->most ? c->most : input->value;
    return 0;
}

static void terminal_free_input(void *device, unsigned channel)
{
    struct terminal *terminal = device;

    if (channel >= terminal->type->input_count)
        return;
    inputs_of(terminal)[channel].held = false;
    take(terminal, channel, 0);
    terminal->next_ns = 0;
}

static uint32_t check_assignment(struct terminal *terminal,
                                 const struct terminal_direction *direction, uint8_t subindex,
                                 int64_t value)
{
    if (subindex == 0)
        return value <= (int64_t)direction->pdo_count ? SDO_OK : SDO_RANGE;
    if (*at(terminal, direction->assign_count))
        return SDO_SUB0_NOT_ZERO;
    return find_pdo(direction, (uint16_t)value) ? SDO_OK : SDO_RANGE;
}

static uint32_t check(void *device, uint16_t index, uint8_t subindex, int64_t value)
{
    struct terminal *terminal = device;
    const struct terminal_type *type = terminal->type;

    for (unsigned d = PDO_RX; d <= PDO_TX; d++) {
        const struct terminal_direction *direction = &type->direction[d];

        if (direction->assign_count != TERMINAL_NO_CELL && index == direction->assign_index)
            return check_assignment(terminal, direction, subindex, value);
    }
    for (unsigned i = 0; i < type->range_count; i++) {
        const struct terminal_range *r = &type->ranges[i];

        if (r->index == index && r->subindex == subindex)
            return value < r->least || value > r->most ? SDO_RANGE : SDO_OK;
    }
    return SDO_OK;
}

static void refresh(void *device)
{
    struct terminal *terminal = device;
    const struct terminal_type *type = terminal->type;
    const uint32_t identity[] = { terminal->identity.vendor, terminal->identity.product,
                                  terminal->identity.revision, terminal->serial };

    for (unsigned i = 0; i < 4 && type->identity != TERMINAL_NO_CELL; i++)
        od_store(at(terminal, type->identity + 4 * i), 4, identity[i]);
    for (unsigned i = 0; i < type->input_count; i++)
        publish(terminal, i);
}

static void written(void *device, uint16_t index, uint8_t subindex)
{
    struct terminal *terminal = device;

    (void)index, (void)subindex;
    terminal->stale = true;
}

void terminal_type_wire(struct terminal_type *type)
{
    struct device_type *device = &type->type;

    device->sii = &type->sii;
    device->model = type;
    device->init = terminal_init;
    device->power_on = terminal_power_on;
    device->state = terminal_state;
    device->step = terminal_step;
    device->outputs = terminal_outputs;
    device->inputs = terminal_inputs;
    device->watchdog = terminal_watchdog;
    device->pins = terminal_pins;
    if (type->input_count) {
        device->set_input = terminal_set_input;
        device->get_input = terminal_get_input;
        device->free_input = terminal_free_input;
    }
    device->input_count = type->input_count;
    for (unsigned d = PDO_RX; d <= PDO_TX; d++)
        type->od.pdo[d] = (struct od_pdo){
            .image_offset =
                (uint32_t)(offsetof(struct terminal, mapped) + d * sizeof(struct pdo_image)),
            .resolve = resolve,
        };
    type->od.check = check;
    type->od.refresh = refresh;
    type->od.written = written;
}

bool terminal_is(const struct device_type *type)
{
    return type->init == terminal_init;
}

static int input_in_cell(const struct terminal_type *type, uint32_t cell)
{
    for (unsigned i = 0; i < type->input_count; i++) {
        if (type->inputs[i].cell == cell)
            return (int)i;
    }
    return -1;
}

int terminal_input_at(const void *device, unsigned bit)
{
    const struct terminal *terminal = device;
    const struct terminal_type *type = terminal->type;
    const struct terminal_move *moves =
        (const void *)((const uint8_t *)device + type->direction[PDO_TX].moves);

    for (unsigned i = 0; i < terminal->move_count[PDO_TX]; i++) {
        if (moves[i].bit == bit)
            return input_in_cell(type, moves[i].cell);
    }
    return -1;
}
