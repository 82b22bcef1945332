/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The verbs of the fault script: one row each, with what it does at its begin and its end. */
#include "bus/fault_parts.h"
#include "bus/spread.h"

enum { JITTER_MOST_NS = 1000000 };

/* --- frames --- */

static void lose(const struct fault_action *action, struct fault_fate *fate)
{
    *(action->given ? &fate->lose_back : &fate->lose) = true;
}

static void delay(const struct fault_action *action, struct fault_fate *fate)
{
    fate->delay_ns += action->time_ns;
}

static void duplicate(const struct fault_action *action, struct fault_fate *fate)
{
    *(action->given ? &fate->duplicate_back : &fate->duplicate) = true;
}

/* Damaged twice on its way, a frame is dead from the first place on. */
static void damage(const struct fault_action *action, struct fault_fate *fate)
{
    if (!fate->damage || action->place < fate->damage_behind)
        fate->damage_behind = action->place;
    fate->damage = true;
}

/* --- cables, power, working counter --- */

static void unplug(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    segment_cable(faults->segment, st->action.place, false, now_ns);
}

static void plug_again(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    if (!faults_still(faults, st))
        segment_cable(faults->segment, st->action.place, true, now_ns);
}

static void plug(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    faults_finish(faults, FAULT_CABLE, st->action.place, now_ns);
    segment_cable(faults->segment, st->action.place, true, now_ns);
}

static void power_off(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    faults_slave(faults, st, now_ns);
    segment_power(faults->segment, st->action.place - 1, false, now_ns);
}

static void power_again(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    if (!faults_still(faults, st))
        segment_power(faults->segment, st->action.place - 1, true, now_ns);
}

static void power_on(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    faults_finish(faults, FAULT_POWER, st->action.place, now_ns);
    segment_power(faults->segment, st->action.place - 1, true, now_ns);
}

static void mute(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    faults_slave(faults, st, now_ns)->mute = true;
}

static void count_again(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    faults_slave(faults, st, now_ns)->mute = faults_still(faults, st) != NULL;
}

/* --- moments --- */

static void mend(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    faults_mend(faults, st->action.place, now_ns);
}

static void remark(struct faults *faults, const struct fault_statement *st, uint64_t now_ns,
                   const char *text)
{
    faults_note(faults, now_ns, st->action.text, text);
}

static void drop(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    struct slave *slave = faults_slave(faults, st, now_ns);

    if (!slave->powered)
        remark(faults, st, now_ns, ": nothing happens, it is switched off");
    else if (!slave_drop(slave, st->action.al_state, (uint16_t)st->action.code))
        remark(faults, st, now_ns, ": nothing happens, its state is lower");
}

static const char *refuse_drop(const struct fault_action *action, const struct slave *slave)
{
    return action->code && slave->type->al_emulation ? "a slave whose processor gives AL codes"
                                                     : NULL;
}

static void expire(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    struct slave *slave = faults_slave(faults, st, now_ns);

    if (!slave->powered || !slave_expire(slave))
        remark(faults, st, now_ns, ": nothing happens, it does not run");
}

static const char *refuse_expire(const struct fault_action *action, const struct slave *slave)
{
    (void)action;
    return slave->output_sm < 0 ? "a slave with outputs" : NULL;
}

static void drive_fault(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    struct slave *slave = faults_slave(faults, st, now_ns);

    if (!slave->powered)
        remark(faults, st, now_ns, ": nothing happens, it is switched off");
    else if (slave->type->fault(slave->device, st->action.axis - 1, (uint16_t)st->action.code,
                                slave->now_ns))
        remark(faults, st, now_ns, ": the drive refuses");
}

/* Axes are told by their controlwords: 0x6040, 0x6840 ... */
static const char *refuse_drive(const struct fault_action *action, const struct slave *slave)
{
    uint32_t controlword = 0x6040 + (action->axis - 1) * 0x800;

    if (!slave->type->fault)
        return "a drive";
    if (slave->type->od && (action->axis > 8 || !od_find(slave->type->od, (uint16_t)controlword)))
        return "an axis that it has";
    return NULL;
}

/* --- mailbox, EEPROM, clock --- */

static void silent(const struct fault_action *action, struct slave_faults *sum)
{
    (void)action;
    sum->mailbox_silent = true;
}

static void malformed(const struct fault_action *action, struct slave_faults *sum)
{
    (void)action;
    sum->mailbox_malformed = true;
}

static void abort_sdo(const struct fault_action *action, struct slave_faults *sum)
{
    if (sum->abort_count < SLAVE_ABORTS)
        sum->aborts[sum->abort_count++] = (struct slave_abort){ .code = action->code,
                                                                .index = action->index,
                                                                .subindex = action->subindex };
}

static const char *refuse_mailbox(const struct fault_action *action, const struct slave *slave)
{
    (void)action;
    return slave->type->od ? NULL : "a slave with a CoE mailbox";
}

static void busy(const struct fault_action *action, struct slave_faults *sum)
{
    (void)action;
    sum->eeprom_busy = true;
}

static void nack(const struct fault_action *action, struct slave_faults *sum)
{
    (void)action;
    sum->eeprom_nack = true;
}

static void drift(const struct fault_action *action, struct slave_faults *sum)
{
    sum->drift_ppb += action->value;
}

static void jitter(const struct fault_action *action, struct slave_faults *sum)
{
    if (action->time_ns >= sum->jitter_ns) {
        sum->jitter_ns = (uint32_t)action->time_ns;
        sum->jitter_seed = spread(action->seed);
    }
}

static const char *refuse_dc(const struct fault_action *action, const struct slave *slave)
{
    if (action->time_ns > JITTER_MOST_NS)
        return "jitter up to 1ms";
    return slave->type->dc ? NULL : "a slave with a distributed clock";
}

/* --- inputs --- */

static void set(struct slave *slave, const struct fault_statement *st, int64_t value)
{
    slave->type->set_input(slave->device, st->action.channel, value);
}

static void look(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    struct slave *slave = faults_slave(faults, st, now_ns);

    if (slave->type->get_input)
        slave->type->get_input(slave->device, st->action.channel, &st->before);
    st->base = st->before;
}

static void show(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    struct slave *slave = faults_slave(faults, st, now_ns);

    look(faults, st, now_ns);
    st->base = st->action.value;
    if (slave->type->set_input(slave->device, st->action.channel, st->base))
        remark(faults, st, now_ns, ": the device refuses the value");
}

static void hold(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    if (st->action.given) {
        show(faults, st, now_ns);
        return;
    }
    look(faults, st, now_ns);
    set(faults_slave(faults, st, now_ns), st, st->base);
}

/* What another fault still holds goes on; otherwise the input is the outside world's again. */
static void let_go(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    struct slave *slave = faults_slave(faults, st, now_ns);
    const struct fault_statement *other = faults_still(faults, st);

    if (other)
        set(slave, other, other->base);
    else if (slave->type->free_input)
        slave->type->free_input(slave->device, st->action.channel);
    else
        set(slave, st, st->before);
}

/* A value that the device refuses (an input of one bit has two) is tried on the other side. */
static void shake(struct faults *faults, struct fault_statement *st, uint64_t now_ns)
{
    struct slave *slave = faults_slave(faults, st, now_ns);
    uint64_t width = 2 * (uint64_t)st->action.value + 1;
    int64_t off = (int64_t)(spread_next(&st->random) % width) - st->action.value;

    if (slave->type->set_input(slave->device, st->action.channel, st->base + off))
        set(slave, st, st->base - off);
}

static const char *refuse_input(const struct fault_action *action, const struct slave *slave)
{
    int64_t value;

    if (!slave->type->set_input)
        return "a slave with inputs";
    if (slave->type->get_input && slave->type->get_input(slave->device, action->channel, &value))
        return "an input that it has";
    return NULL;
}

/* For faults that start from what the input shows. */
static const char *refuse_noise(const struct fault_action *action, const struct slave *slave)
{
    const char *why = refuse_input(action, slave);

    return why || slave->type->get_input ? why : "a slave that tells what its inputs show";
}

static const char *refuse_stuck(const struct fault_action *action, const struct slave *slave)
{
    return action->given ? refuse_input(action, slave) : refuse_noise(action, slave);
}

/* --- the language --- */

#define VERB(word, words, what) .name = word, .grammar = words, .help = what

static const struct fault_verb verbs[] = {
    { VERB("lose", "FRAMES [back]",
           "frames vanish in front of the slaves; back: on the way home, when all have seen them"),
      .example = "from 1s to 2s lose 1% frames seed 7", .kind = FAULT_FRAMES, .strike = lose },
    { VERB("delay", "FRAMES by TIME", "frames come back that much later"),
      .example = "at 1s delay 3 frames by 1.5ms", .kind = FAULT_FRAMES, .strike = delay },
    { VERB("duplicate", "FRAMES [back]",
           "frames pass the slaves twice and come back twice; back: only come back twice"),
      .example = "frame 4000 duplicate", .kind = FAULT_FRAMES, .strike = duplicate },
    { VERB("damage", "FRAMES [after CABLE]",
           "frames lose bits on the cable behind a slave (0, or nothing: the master's): slaves "
           "behind count an error, nothing comes back"),
      .example = "every 100ms damage 1 frame after 1", .kind = FAULT_FRAMES, .strike = damage },
    { VERB("short", "wkc at SLAVE",
           "the slave takes no part in process data, as one whose sync managers are off; registers "
           "answer"),
      .example = "at 500ms short wkc at 2 for 10ms", .kind = FAULT_MUTE, .begin = mute,
      .end = count_again },
    { VERB("unplug", "after CABLE",
           "the cable behind a slave is pulled (0: the master's); what is behind is out of reach"),
      .example = "at 1s unplug after 1 for 300ms", .kind = FAULT_CABLE, .begin = unplug,
      .end = plug_again },
    { VERB("plug", "after CABLE", "the cable is plugged in again"), .example = "at 2s plug after 1",
      .begin = plug },
    { VERB("power", "off SLAVE", "the slave is switched off, and with it the way to those behind"),
      .example = "at 1s power off 2", .kind = FAULT_POWER, .begin = power_off, .end = power_again },
    { VERB("power", "on SLAVE", "the slave is switched on: address 0, INIT"),
      .example = "at 2s power on 2", .begin = power_on },
    { VERB("power", "cycle SLAVE", "off and on again, after 100 ms unless `for` says otherwise"),
      .example = "at 1s power cycle 2 for 250ms", .kind = FAULT_POWER, .lasts_ns = FAULT_CYCLE_NS,
      .begin = power_off, .end = power_again },
    { VERB("drop", "SLAVE to STATE [code CODE]",
           "the slave falls to INIT, PREOP or SAFEOP by itself, with an AL status code or without"),
      .example = "at 1s drop 1 to SAFEOP code 0x001B", .refuse = refuse_drop, .begin = drop },
    { VERB("mailbox", "SLAVE silent", "requests are taken and never answered"),
      .example = "at 1s mailbox 1 silent for 2s", .kind = FAULT_SLAVE, .refuse = refuse_mailbox,
      .effect = silent },
    { VERB("mailbox", "SLAVE malformed", "replies have every bit of their content inverted"),
      .example = "at 1s mailbox 1 malformed for 2s", .kind = FAULT_SLAVE, .refuse = refuse_mailbox,
      .effect = malformed },
    { VERB("mailbox", "SLAVE abort ABORT [object OBJECT]",
           "SDO requests are aborted with that code; only for one object, or one of its "
           "subindices"),
      .example = "at start mailbox 1 abort 0x06090011 object 0x6060:0", .kind = FAULT_SLAVE,
      .refuse = refuse_mailbox, .most = SLAVE_ABORTS, .effect = abort_sdo },
    { VERB("eeprom", "SLAVE busy", "the EEPROM never gets ready"),
      .example = "from start to 1s eeprom 1 busy", .kind = FAULT_SLAVE, .effect = busy },
    { VERB("eeprom", "SLAVE nack", "the EEPROM acknowledges no command"),
      .example = "at start eeprom 2 nack", .kind = FAULT_SLAVE, .effect = nack },
    { VERB("drive", "SLAVE [axis AXIS] fault CODE",
           "an axis (the first unless said) goes into fault with that error code, 0x603F"),
      .example = "at 1s drive 1 fault 0x3210", .refuse = refuse_drive, .begin = drive_fault },
    { VERB("input", "CHANNEL stuck [at VALUE]",
           "input C of slave K, written K.C, C from 0, stays as it is, or at a value"),
      .example = "at 1s input 2.0 stuck for 2s", .kind = FAULT_INPUT, .refuse = refuse_stuck,
      .begin = hold, .end = let_go },
    { VERB("input", "CHANNEL noise AMPLITUDE [seed SEED]",
           "the input goes up and down around what it showed, by at most that much, with every "
           "frame"),
      .example = "from 1s to 3s input 2.1 noise 1 seed 3", .kind = FAULT_INPUT,
      .refuse = refuse_noise, .begin = look, .end = let_go, .shake = shake },
    { VERB("input", "CHANNEL value VALUE", "the input shows that value, in range or not"),
      .example = "at 1s input 2.3 value 1", .kind = FAULT_INPUT, .refuse = refuse_input,
      .begin = show, .end = let_go },
    { VERB("dc", "SLAVE drift PPM [ppm]", "the slave's clock runs that much faster (+) or slower"),
      .example = "at 1s dc 1 drift -50 ppm", .kind = FAULT_SLAVE, .refuse = refuse_dc,
      .effect = drift },
    { VERB("dc", "SLAVE jitter TIME [seed SEED]",
           "the slave stamps passing frames up to that much early or late"),
      .example = "at 1s dc 1 jitter 200ns", .kind = FAULT_SLAVE, .refuse = refuse_dc,
      .effect = jitter },
    { VERB("watchdog", "SLAVE expire", "the process data watchdog expires"),
      .example = "at 1s watchdog 1 expire", .refuse = refuse_expire, .begin = expire },
    { VERB("mend", "[SLAVE]", "every fault that lasts is over, everywhere or at one slave"),
      .example = "at 5s mend 1", .begin = mend },
};

const struct fault_verb *fault_verb(size_t index)
{
    return index < sizeof verbs / sizeof *verbs ? &verbs[index] : NULL;
}

bool fault_verb_text(size_t index, struct fault_verb_text *text)
{
    const struct fault_verb *verb = fault_verb(index);

    if (!verb)
        return false;
    *text = (struct fault_verb_text){ verb->name, verb->grammar, verb->help, verb->example };
    return true;
}
