/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/slave_parts.h"

#include <string.h>

static void publish(struct slave *slave, unsigned status, uint16_t code)
{
    uint8_t *event = slave->memory + REG_ECAT_EVENT;

    /* Code before status: a master that sees the error bit must find its reason. */
    put_u16(slave->memory + REG_AL_STATUS_CODE, code);
    put_u16(slave->memory + REG_AL_STATUS, status);
    put_u16(event, get_u16(event) | EVENT_AL_STATUS);
}

static bool has_mailbox(const struct slave *slave)
{
    return slave->type->sii->mailbox.out_size != 0;
}

static void enter(struct slave *slave, unsigned state)
{
    unsigned from = slave->state;

    slave->state = (uint8_t)state;
    slave->al.wait_outputs = false;
    if (has_mailbox(slave) && from == AL_INIT && state != AL_INIT)
        mailbox_start(slave);
    if (state == AL_INIT)
        mailbox_stop(slave);
    if (state <= AL_PREOP)
        slave->al.outputs_seen = false;
    if (from == AL_OP && state != AL_OP) {
        slave->watchdog.running = false;
        slave->watchdog.deadline_ns = SLAVE_NEVER;
    }
    if (slave->type->state && from != state)
        slave->type->state(slave->device, state, slave->now_ns);
}

static bool sm_is(const struct slave *slave, unsigned n, uint16_t start, uint16_t length,
                  unsigned control)
{
    const struct syncman *sm = &slave->sm[n];
    unsigned set = slave->memory[REG_SM + n * SM_SIZE + SM_CONTROL];
    unsigned mask = SM_CONTROL_MODE | SM_CONTROL_WRITE;

    return sm->enabled && sm->usable && sm->start == start && sm->length == length &&
           (set & mask) == (control & mask);
}

static uint16_t check_preop(struct slave *slave)
{
    const struct sii_mailbox *m = &slave->type->sii->mailbox;

    if (!has_mailbox(slave))
        return AL_CODE_NONE;
    if (!sm_is(slave, 0, m->out_start, m->out_size, SM_CONTROL_MAILBOX | SM_CONTROL_WRITE) ||
        !sm_is(slave, 1, m->in_start, m->in_size, SM_CONTROL_MAILBOX))
        return AL_CODE_MAILBOX_CONFIG;
    return AL_CODE_NONE;
}

static bool process_sm_fits(const struct slave *slave, int n, unsigned bits)
{
    const struct sii_sm *want;
    unsigned bytes = (bits + 7) / 8;

    if (n < 0)
        return bytes == 0;
    want = &slave->type->sii->sm[n];
    if (!bytes)
        return !slave->sm[n].enabled;
    return sm_is(slave, (unsigned)n, want->start, (uint16_t)bytes, want->control);
}

/* Without a dictionary the SII says how long the process image is: the PDOs of the sync manager, or
 * its own length. */
static unsigned sii_bits(const struct sii_info *sii, int n, const struct sii_pdo *pdos,
                         unsigned count)
{
    unsigned bits = 0;

    for (unsigned i = 0; i < count; i++) {
        if (pdos[i].sm != n)
            continue;
        for (unsigned k = 0; k < pdos[i].entry_count; k++)
            bits += pdos[i].entries[k].bits;
    }
    return bits || n < 0 ? bits : sii->sm[n].length * 8u;
}

static unsigned image_bits(const struct slave *slave, enum pdo_direction direction)
{
    const struct sii_info *sii = slave->type->sii;

    if (slave->type->od)
        return pdo_image(slave->type->od, slave->device, direction)->bits;
    return direction == PDO_RX ? sii_bits(sii, slave->output_sm, sii->rx, sii->rx_count)
                               : sii_bits(sii, slave->input_sm, sii->tx, sii->tx_count);
}

static uint16_t check_process_sms(const struct slave *slave)
{
    if (!process_sm_fits(slave, slave->output_sm, image_bits(slave, PDO_RX)))
        return AL_CODE_OUTPUT_CONFIG;
    if (!process_sm_fits(slave, slave->input_sm, image_bits(slave, PDO_TX)))
        return AL_CODE_INPUT_CONFIG;
    return AL_CODE_NONE;
}

/* Both sides must mean the same process image, or the drive would take a velocity for a position.
 */
static uint16_t check_safeop(struct slave *slave)
{
    const struct od *od = slave->type->od;
    uint8_t dc = slave->memory[REG_DC_ACTIVATION];
    uint16_t code;

    if (od) {
        for (unsigned d = PDO_RX; d <= PDO_TX; d++) {
            code = pdo_resolve(od, slave->device, (enum pdo_direction)d);
            if (code)
                return code;
        }
    }
    code = check_process_sms(slave);
    if (code)
        return code;
    /* Cyclic operation without a period, or SYNC pulses without the cyclic unit. */
    if (((dc & 1) && get_u32(slave->memory + REG_DC_CYCLE0) == 0) || ((dc & 6) && !(dc & 1)))
        return AL_CODE_DC_CONFIG;
    return AL_CODE_NONE;
}

static void refuse(struct slave *slave, uint16_t code)
{
    publish(slave, slave->state | (unsigned)AL_ERROR, code);
}

static void grant(struct slave *slave, unsigned state)
{
    enter(slave, state);
    publish(slave, state, AL_CODE_NONE);
}

static void start_op(struct slave *slave)
{
    if (slave->output_sm < 0 || !slave->sm[slave->output_sm].enabled || slave->al.outputs_seen) {
        grant(slave, AL_OP);
        return;
    }
    slave->al.wait_outputs = true;
    slave->al.due_ns = slave->now_ns + SLAVE_FIRST_OUTPUT_NS;
}

/* One row per allowed step up; steps down and to the same state are always allowed. */
static void request_up(struct slave *slave, unsigned to)
{
    uint16_t code;

    switch ((unsigned)slave->state << 4 | to) {
    case AL_INIT << 4 | AL_PREOP:
        code = check_preop(slave);
        break;
    case AL_PREOP << 4 | AL_SAFEOP:
        code = check_safeop(slave);
        break;
    case AL_SAFEOP << 4 | AL_OP:
        start_op(slave);
        return;
    default:
        code = AL_CODE_INVALID_CHANGE;
    }
    if (code)
        refuse(slave, code);
    else
        grant(slave, to);
}

/* The alias names the device; the answer stands where an error would have its code. */
static void identify(struct slave *slave)
{
    if (!(get_u16(slave->memory + REG_AL_STATUS) & AL_ERROR))
        publish(slave, slave->state | (unsigned)AL_DEVICE_ID,
                get_u16(slave->memory + REG_STATION_ALIAS));
}

static void request_state(struct slave *slave, unsigned to)
{
    slave->al.wait_outputs = false;
    if (to == AL_BOOT)
        refuse(slave, AL_CODE_NO_BOOT);
    else if (to != AL_INIT && to != AL_PREOP && to != AL_SAFEOP && to != AL_OP)
        refuse(slave, AL_CODE_UNKNOWN_STATE);
    else if (to <= slave->state)
        grant(slave, to);
    else
        request_up(slave, to);
}

static void request(struct slave *slave, unsigned control)
{
    unsigned status = get_u16(slave->memory + REG_AL_STATUS);
    unsigned to = control & AL_STATE;

    if (status & AL_ERROR) {
        if (!(control & AL_ERROR) && to != AL_INIT)
            return;
        publish(slave, slave->state, AL_CODE_NONE);
    } else if (status & AL_DEVICE_ID) {
        publish(slave, slave->state, AL_CODE_NONE);
    }
    request_state(slave, to);
    if (control & AL_DEVICE_ID)
        identify(slave);
}

static void emulate(struct slave *slave, unsigned control)
{
    unsigned to = control & AL_STATE;

    if (to == AL_INIT || to == AL_PREOP || to == AL_SAFEOP || to == AL_OP)
        enter(slave, to);
    publish(slave, control & (AL_STATE | AL_ERROR), AL_CODE_NONE);
}

/* Masters write one or two bytes. With an application behind it the register is a mailbox: until
 * the application has read the request, a further write is not accepted. */
bool al_write_control(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    struct al *al = &slave->al;

    if (al->pending && slave->now_ns < al->read_ns)
        return false;
    /* It has been read and is on its way: the next one comes behind it. */
    if (al->pending)
        request(slave, al->request);
    memcpy(slave->memory + address, data, length);
    if (address != REG_AL_CONTROL)
        return true;
    if (slave->type->al_emulation) {
        emulate(slave, data[0]);
        return true;
    }
    al->pending = true;
    al->wait_outputs = false;
    al->request = data[0];
    al->read_ns = slave->now_ns + SLAVE_AL_READ_NS;
    al->due_ns = slave->now_ns + SLAVE_AL_NS;
    if (al->due_ns < slave->due_ns)
        slave->due_ns = al->due_ns;
    return true;
}

void al_run(struct slave *slave)
{
    struct al *al = &slave->al;

    if (al->wait_outputs && al->outputs_seen) {
        grant(slave, AL_OP);
    } else if (al->wait_outputs && slave->now_ns >= al->due_ns) {
        al->wait_outputs = false;
        refuse(slave, AL_CODE_NO_OUTPUTS);
    }
    if (al->pending && slave->now_ns >= al->due_ns) {
        al->pending = false;
        request(slave, al->request);
    }
}

void al_fall(struct slave *slave, unsigned state, uint16_t code)
{
    slave->al.pending = false;
    enter(slave, state);
    publish(slave, state | (code ? (unsigned)AL_ERROR : 0u), code);
}

void al_check_running(struct slave *slave)
{
    uint16_t code;

    if (slave->type->al_emulation || slave->state == AL_INIT)
        return;
    if (check_preop(slave)) {
        al_fall(slave, AL_INIT, AL_CODE_MAILBOX_CONFIG);
        return;
    }
    if (slave->state < AL_SAFEOP)
        return;
    code = check_process_sms(slave);
    if (code)
        al_fall(slave, AL_PREOP, code);
}
