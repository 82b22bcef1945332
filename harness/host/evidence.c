/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/evidence.h"

#include "host/console.h"

static void end_text(char *text, size_t size)
{
    text[size - 1] = '\0';
    for (char *c = text; *c != '\0'; c++)
        if ((unsigned char)*c < 0x20 && *c != '\t')
            *c = ' ';
}

/* Enumerations and bools of the block may hold any bits: they are made valid before they are read.
 */
static void clean_bool(bool *flag)
{
    unsigned char *byte = (unsigned char *)flag;
    *byte = *byte != 0;
}

static void clean_entry(enum entry *entry)
{
    if ((unsigned)*entry >= ENTRY_COUNT)
        *entry = ENTRY_INI;
}

static void clean_incident(struct evidence_incident *incident)
{
    clean_entry(&incident->entry);
    if ((unsigned)incident->kind > MACHINE_UNSUPPORTED)
        incident->kind = MACHINE_FAULT;
    if ((unsigned)incident->fault.access > MACHINE_ACCESS_EXECUTE)
        incident->fault.access = MACHINE_ACCESS_NONE;
    clean_bool(&incident->fault.in_module);
    clean_bool(&incident->fault.has_pc);
    clean_bool(&incident->fault.syscall_i386);
    clean_bool(&incident->fault.syscall_arm);
    incident->fault.service = NULL;
    end_text(incident->fault.region, sizeof incident->fault.region);
    end_text(incident->service, sizeof incident->service);
}

static void clean_race(struct evidence_race *race)
{
    if ((unsigned)race->kind > RACE_FAILED)
        race->kind = RACE_NEITHER;
    clean_entry(&race->entry);
    clean_entry(&race->by);
    clean_entry(&race->failed);
    clean_bool(&race->has_by_pc);
    clean_bool(&race->by_writes);
    if ((unsigned)race->outcome > MACHINE_HANG)
        race->outcome = MACHINE_FAULT;
    if ((unsigned)race->fault.access > MACHINE_ACCESS_EXECUTE)
        race->fault.access = MACHINE_ACCESS_NONE;
    clean_bool(&race->fault.in_module);
    clean_bool(&race->fault.has_pc);
    clean_bool(&race->fault.syscall_i386);
    clean_bool(&race->fault.syscall_arm);
    race->fault.service = NULL;
    end_text(race->fault.region, sizeof race->fault.region);
}

static void clean_value(struct scenario_value *value)
{
    clean_bool(&value->is_double);
}

static void clean_play(struct evidence *evidence)
{
    if ((unsigned)evidence->play > PLAY_GIVEN_UP)
        evidence->play = PLAY_RUNNING;
    if (evidence->failure_count > EVIDENCE_FAILURES)
        evidence->failure_count = EVIDENCE_FAILURES;
    for (unsigned i = 0; i < EVIDENCE_FAILURES; i++) {
        struct evidence_failure *failure = &evidence->failures[i];
        if ((unsigned)failure->kind > FAILURE_REFUSED)
            failure->kind = FAILURE_EXPECTATION;
        if (failure->value_count > EVIDENCE_VALUES)
            failure->value_count = EVIDENCE_VALUES;
        for (unsigned k = 0; k < EVIDENCE_VALUES; k++)
            clean_value(&failure->values[k]);
    }
    for (unsigned i = 0; i < EVIDENCE_LINES; i++)
        clean_value(&evidence->lines[i].value);
}

void evidence_clean(struct evidence *evidence)
{
    if ((unsigned)evidence->stage > EVIDENCE_FINISHED)
        evidence->stage = EVIDENCE_NOTHING;
    clean_entry(&evidence->entry);
    for (unsigned i = 0; i < ENTRY_COUNT; i++)
        clean_bool(&evidence->calls[i].disabled);
    for (unsigned i = 0; i < EVIDENCE_AXES; i++)
        clean_bool(&evidence->unable[i].fault);
    clean_bool(&evidence->all_op);
    clean_bool(&evidence->eeprom.saved);
    clean_bool(&evidence->instrumented);
    clean_bool(&evidence->lookup.asked);
    clean_bool(&evidence->lookup.found);
    if (evidence->eeprom.size > EVIDENCE_EEPROM)
        evidence->eeprom.size = EVIDENCE_EEPROM;
    if (evidence->axis_count > EVIDENCE_AXES)
        evidence->axis_count = EVIDENCE_AXES;
    if (evidence->race_count > EVIDENCE_RACES)
        evidence->race_count = EVIDENCE_RACES;
    for (unsigned i = 0; i < EVIDENCE_RACES; i++)
        clean_race(&evidence->races[i]);
    if (evidence->incident_count > EVIDENCE_INCIDENTS)
        evidence->incident_count = EVIDENCE_INCIDENTS;
    for (unsigned i = 0; i < EVIDENCE_INCIDENTS; i++)
        clean_incident(&evidence->incidents[i]);
    for (unsigned i = 0; i < EVIDENCE_MESSAGES; i++) {
        clean_entry(&evidence->messages[i].entry);
        clean_bool(&evidence->messages[i].of_host);
        end_text(evidence->messages[i].text, EVIDENCE_TEXT);
    }
    for (unsigned i = 0; i < EVIDENCE_FAULTS; i++)
        end_text(evidence->faults[i].text, sizeof evidence->faults[i].text);
    clean_play(evidence);
    audit_clean(&evidence->audit);
    for (unsigned i = 0; i < EVIDENCE_INTERRUPTS; i++)
        clean_entry(&evidence->interrupts[i].entry);
    if (evidence->digest.state_count > DIGEST_STATES)
        evidence->digest.state_count = DIGEST_STATES;
    coverage_clean(&evidence->coverage);
    sketch_clean(&evidence->sketch);
    clean_bool(&evidence->clock.used);
    clean_bool(&evidence->clock.priority);
    clean_bool(&evidence->clock.pinned);
    clean_bool(&evidence->clock.locked);
    end_text(evidence->clock.notice, sizeof evidence->clock.notice);
    end_text(evidence->trouble, sizeof evidence->trouble);
}

const char *evidence_speaker(const struct evidence_message *message)
{
    if (!message->of_host)
        return entry_name(message->entry);
    switch (message->source) {
    case CONSOLE_SERVO:
        return "servo";
    case CONSOLE_EEPROM:
        return "EEPROM";
    case CONSOLE_MASTER:
        return "EtherCAT";
    case CONSOLE_SLAVES:
        return "slave";
    default:
        return "TG Motion";
    }
}
