/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * The members of evidence, for files. Who adds one to struct evidence or to what it is made of adds
 * its row; a test looks for bytes that are in no row. Not written: pointers, and what only a
 * running worker needs (stop).
 */
#include "host/evidence_file.h"

#define MEMBER(type, member) (((struct type *)0)->member)
#define COUNT(type, member)  (sizeof MEMBER(type, member) / sizeof *MEMBER(type, member))
/* A plain value; an array of them, in one dimension or two; a structure; an array of structures. */
#define VALUE(type, member)                                                                        \
#member, offsetof(struct type, member), sizeof MEMBER(type, member), 1, NULL
#define VALUES(type, member)                                                                       \
#member, offsetof(struct type, member), sizeof *MEMBER(type, member), COUNT(type, member), NULL
#define GRID(type, member)                                                                         \
#member, offsetof(struct type, member), sizeof **MEMBER(type, member),                         \
        sizeof MEMBER(type, member) / sizeof **MEMBER(type, member), NULL
#define PART(type, member, rows)                                                                   \
#member, offsetof(struct type, member), sizeof MEMBER(type, member), 1, rows
#define PARTS(type, member, rows)                                                                  \
#member, offsetof(struct type, member), sizeof *MEMBER(type, member), COUNT(type, member), rows

static const struct evidence_row calls[] = {
    { VALUE(evidence_calls, count) },
    { VALUE(evidence_calls, last_value) },
    { VALUE(evidence_calls, disabled) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row fault[] = {
    { VALUE(machine_fault, signal) },
    { VALUE(machine_fault, access) },
    { VALUE(machine_fault, address) },
    { VALUE(machine_fault, in_module) },
    { VALUE(machine_fault, pc) },
    { VALUE(machine_fault, has_pc) },
    { VALUE(machine_fault, ip) },
    { VALUE(machine_fault, syscall) },
    { VALUE(machine_fault, syscall_i386) },
    { VALUE(machine_fault, syscall_arm) },
    { VALUES(machine_fault, region) },
    { VALUE(machine_fault, region_offset) },
    { VALUE(machine_fault, region_size) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row incident[] = {
    { VALUE(evidence_incident, entry) },    { VALUE(evidence_incident, cycle) },
    { VALUE(evidence_incident, kind) },     { PART(evidence_incident, fault, fault) },
    { VALUES(evidence_incident, service) }, { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row message[] = {
    { VALUE(evidence_message, entry) },
    { VALUE(evidence_message, cycle) },
    { VALUE(evidence_message, severity) },
    { VALUE(evidence_message, of_host) },
    { VALUE(evidence_message, source) },
    { VALUES(evidence_message, text) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row interrupt[] = {
    { VALUE(evidence_interrupt, entry) },        { VALUE(evidence_interrupt, by) },
    { VALUE(evidence_interrupt, cycle) },        { VALUE(evidence_interrupt, pc) },
    { VALUE(evidence_interrupt, instructions) }, { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row disturbance[] = {
    { VALUE(evidence_fault, time_ns) },
    { VALUES(evidence_fault, text) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row value[] = {
    { VALUE(scenario_value, is_double) },
    { VALUE(scenario_value, i) }, /* or d: the same bits */
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row failure[] = {
    { VALUE(evidence_failure, statement) },     { VALUE(evidence_failure, kind) },
    { VALUE(evidence_failure, cycle) },         { VALUE(evidence_failure, time_ns) },
    { VALUE(evidence_failure, count) },         { VALUE(evidence_failure, value_count) },
    { PARTS(evidence_failure, values, value) }, { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row line[] = {
    { VALUE(evidence_line, statement) },
    { VALUE(evidence_line, time_ns) },
    { PART(evidence_line, value, value) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row eeprom[] = {
    { VALUE(evidence_eeprom, saved) },
    { VALUE(evidence_eeprom, size) },
    { VALUES(evidence_eeprom, data) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row lookup[] = {
    { VALUE(evidence_lookup, asked) }, { VALUE(evidence_lookup, found) },
    { VALUE(evidence_lookup, table) }, { VALUES(evidence_lookup, functions) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row latency[] = {
    { VALUE(latency, count) },
    { VALUE(latency, max_ns) },
    { VALUES(latency, bins) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row clock_rows[] = {
    { VALUE(evidence_clock, used) },          { VALUE(evidence_clock, priority) },
    { VALUE(evidence_clock, pinned) },        { VALUE(evidence_clock, locked) },
    { VALUES(evidence_clock, notice) },       { PART(evidence_clock, empty, latency) },
    { PART(evidence_clock, slots, latency) }, { VALUE(evidence_clock, cycles) },
    { VALUE(evidence_clock, overruns) },      { VALUE(evidence_clock, missed) },
    { VALUE(evidence_clock, dropped) },       { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row state[] = {
    { VALUE(digest_state, sum) },
    { VALUE(digest_state, where) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row digest[] = {
    { VALUE(digest, state_count) }, { PARTS(digest, states, state) }, { VALUES(digest, trails) },
    { VALUES(digest, memories) },   { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row access_rows[] = {
    { VALUE(audit_access, pc) },
    { VALUE(audit_access, count) },
    { VALUE(audit_access, first_cycle) },
    { VALUE(audit_access, first_value) },
    { VALUE(audit_access, offset) },
    { VALUE(audit_access, odd_offset) },
    { VALUE(audit_access, odd_count) },
    { VALUE(audit_access, odd_cycle) },
    { VALUE(audit_access, entry) },
    { VALUE(audit_access, memory) },
    { VALUE(audit_access, size) },
    { VALUE(audit_access, classes) },
    { VALUE(audit_access, write) },
    { VALUE(audit_access, before_op) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row order[] = {
    { VALUE(audit_order, count) },
    { VALUE(audit_order, cycle) },
    { VALUE(audit_order, output_pc) },
    { VALUE(audit_order, input_pc) },
    { VALUE(audit_order, output_offset) },
    { VALUE(audit_order, input_offset) },
    { VALUE(audit_order, output_memory) },
    { VALUE(audit_order, input_memory) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row function[] = {
    { VALUE(audit_function, calls) },
    { VALUE(audit_function, instructions) },
    { VALUE(audit_function, worst_instructions) },
    { VALUE(audit_function, worst_cycle) },
    { VALUE(audit_function, stack_bytes) },
    { VALUE(audit_function, looked) },
    { VALUE(audit_function, abi_broken) },
    { VALUE(audit_function, abi_cycle) },
    { VALUE(audit_function, sleeps) },
    { VALUE(audit_function, sleep_cycle) },
    { VALUE(audit_function, sleep_pc) },
    { VALUE(audit_function, messages) },
    { PART(audit_function, order, order) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row motion[] = {
    { VALUE(audit_motion, count) }, { VALUE(audit_motion, cycle) }, { VALUE(audit_motion, axis) },
    { VALUE(audit_motion, value) }, { VALUE(audit_motion, limit) }, { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row audit[] = {
    { VALUE(audit_record, traced) },
    { VALUE(audit_record, access_count) },
    { VALUE(audit_record, access_dropped) },
    { PARTS(audit_record, accesses, access_rows) },
    { PARTS(audit_record, functions, function) },
    { PARTS(audit_record, motion, motion) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row unable[] = {
    { VALUE(evidence_unable, cycles) },
    { VALUE(evidence_unable, driven) },
    { VALUE(evidence_unable, cycle) },
    { VALUE(evidence_unable, al_state) },
    { VALUE(evidence_unable, fault) },
    { VALUE(evidence_unable, distance) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row word[] = {
    { VALUE(evidence_word, memory) }, { VALUE(evidence_word, bit) },
    { VALUE(evidence_word, offset) }, { VALUE(evidence_word, first) },
    { VALUE(evidence_word, second) }, { VALUE(evidence_word, found) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row race[] = {
    { VALUE(evidence_race, kind) },         { VALUE(evidence_race, entry) },
    { VALUE(evidence_race, by) },           { VALUE(evidence_race, cycle) },
    { VALUE(evidence_race, count) },        { VALUE(evidence_race, pc) },
    { VALUE(evidence_race, instructions) }, { PARTS(evidence_race, words, word) },
    { VALUE(evidence_race, has_by_pc) },    { VALUE(evidence_race, by_pc) },
    { VALUE(evidence_race, by_writes) },    { PART(evidence_race, shared, word) },
    { VALUE(evidence_race, failed) },       { VALUE(evidence_race, outcome) },
    { PART(evidence_race, fault, fault) },  { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row sketch[] = {
    { VALUE(sketch, cycles) }, { VALUE(sketch, per_bucket) }, { VALUE(sketch, used) },
    { VALUES(sketch, now) },   { GRID(sketch, least) },       { GRID(sketch, greatest) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row coverage[] = {
    { VALUE(coverage, begin) },
    { VALUE(coverage, size) },
    { VALUES(coverage, bits) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row evidence[] = {
    { VALUE(evidence, stage) },
    { VALUE(evidence, entry) },
    { VALUE(evidence, cycle) },
    { VALUE(evidence, cycles_done) },
    { VALUE(evidence, time_ns) },
    { VALUE(evidence, servo_count) },
    { VALUE(evidence, axis_count) },
    { VALUES(evidence, axis_position) },
    { VALUE(evidence, all_op) },
    { PARTS(evidence, calls, calls) },
    { VALUES(evidence, called_cycle) },
    { PARTS(evidence, unable, unable) },
    { VALUE(evidence, incident_count) },
    { PARTS(evidence, incidents, incident) },
    { VALUE(evidence, message_count) },
    { PARTS(evidence, messages, message) },
    { VALUE(evidence, fault_count) },
    { PARTS(evidence, faults, disturbance) },
    { VALUE(evidence, play) },
    { VALUE(evidence, checked) },
    { VALUE(evidence, failed) },
    { VALUE(evidence, failure_count) },
    { PARTS(evidence, failures, failure) },
    { VALUE(evidence, line_count) },
    { PARTS(evidence, lines, line) },
    { PART(evidence, eeprom, eeprom) },
    { VALUE(evidence, interrupt_count) },
    { PARTS(evidence, interrupts, interrupt) },
    { VALUE(evidence, tried_calls) },
    { VALUE(evidence, tried_points) },
    { VALUE(evidence, race_total) },
    { VALUE(evidence, race_count) },
    { PARTS(evidence, races, race) },
    { VALUE(evidence, loads) },
    { VALUE(evidence, instrumented) },
    { PART(evidence, lookup, lookup) },
    { PART(evidence, clock, clock_rows) },
    { VALUE(evidence, op_cycle) },
    { VALUE(evidence, wkc_errors) },
    { VALUE(evidence, stack_used) },
    { VALUE(evidence, slaves) },
    { PART(evidence, digest, digest) },
    { PART(evidence, audit, audit) },
    { PART(evidence, coverage, coverage) },
    { PART(evidence, sketch, sketch) },
    { VALUES(evidence, trouble) },
    { NULL, 0, 0, 0, NULL },
};

static const struct evidence_row worker[] = {
    { VALUE(worker_result, end) },     { VALUE(worker_result, value) },
    { VALUE(worker_result, wall_ns) }, { VALUES(worker_result, reason) },
    { VALUE(worker_result, lacks) },   { NULL, 0, 0, 0, NULL },
};

const struct evidence_row evidence_result_rows[] = {
    { PART(experiment_result, evidence, evidence) },
    { PART(experiment_result, worker, worker) },
    { NULL, 0, 0, 0, NULL },
};
