/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Evidence from a file, which may be anything: whoever judges from it finds nothing in it that is
 * not allowed. Every fourth is written again, and what was taken once comes back the same. Limits
 * are smaller than in earnest (the Makefile's FUZZ_LIMITS), the form is the same.
 *
 * The first byte chooses: the values as they are, which lets every byte reach its member; the
 * squeezed values behind a head that is right; a whole file; lines of a waivers file.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "conformance/rules.h"
#include "conformance/waivers.h"
#include "host/evidence_file.h"

enum { HEAD = 28, PIECE = 8 }; /* bytes in front of the values, of each piece of them */

int LLVMFuzzerInitialize(int *argument_count, char ***arguments);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static unsigned long long inputs, taken, waived;
static uint8_t *head; /* of evidence in which there is nothing */
static size_t values_size;

static void must_be(bool holds, const char *what)
{
    if (holds)
        return;
    fprintf(stderr, "not so: %s\n", what);
    abort();
}
#define must(what) must_be(what, #what)

/* Stands in for the rule book, which would bring everything else with it. */
const struct rule *rule_find(const char *id)
{
    static const struct rule any = { .id = "any" };
    return id[0] == 'r' ? &any : NULL;
}

/* --- what is allowed -------------------------------------------------------------------------- */

static unsigned char bits_of(const bool *flag)
{
    unsigned char byte;
    memcpy(&byte, flag, 1);
    return byte;
}

#define is_flag(flag) must(bits_of(flag) <= 1)
#define ENDS(text)    must(memchr(text, '\0', sizeof(text)) != NULL)

static void fault_is_allowed(const struct machine_fault *fault)
{
    must((unsigned)fault->access <= MACHINE_ACCESS_EXECUTE && fault->service == NULL);
    is_flag(&fault->in_module);
    is_flag(&fault->has_pc);
    is_flag(&fault->syscall_i386);
    ENDS(fault->region);
}

static void call_is_allowed(const struct evidence *e)
{
    must((unsigned)e->stage <= EVIDENCE_FINISHED && (unsigned)e->entry < ENTRY_COUNT);
    for (unsigned i = 0; i < ENTRY_COUNT; i++)
        is_flag(&e->calls[i].disabled);
    must(e->incident_count <= EVIDENCE_INCIDENTS);
    for (unsigned i = 0; i < EVIDENCE_INCIDENTS; i++) {
        must((unsigned)e->incidents[i].entry < ENTRY_COUNT);
        must((unsigned)e->incidents[i].kind <= MACHINE_UNSUPPORTED);
        fault_is_allowed(&e->incidents[i].fault);
        ENDS(e->incidents[i].service);
    }
    for (unsigned i = 0; i < EVIDENCE_MESSAGES; i++) {
        must((unsigned)e->messages[i].entry < ENTRY_COUNT);
        is_flag(&e->messages[i].of_host);
        ENDS(e->messages[i].text);
        must(evidence_speaker(&e->messages[i]) != NULL);
    }
    for (unsigned i = 0; i < EVIDENCE_INTERRUPTS; i++)
        must((unsigned)e->interrupts[i].entry < ENTRY_COUNT);
}

static void races_are_allowed(const struct evidence *e)
{
    must(e->race_count <= EVIDENCE_RACES);
    for (unsigned i = 0; i < EVIDENCE_RACES; i++) {
        const struct evidence_race *race = &e->races[i];
        must((unsigned)race->kind <= RACE_FAILED && (unsigned)race->outcome <= MACHINE_HANG);
        must((unsigned)race->entry < ENTRY_COUNT && (unsigned)race->by < ENTRY_COUNT &&
             (unsigned)race->failed < ENTRY_COUNT);
        is_flag(&race->has_by_pc);
        is_flag(&race->by_writes);
        fault_is_allowed(&race->fault);
    }
}

static void play_is_allowed(const struct evidence *e)
{
    must((unsigned)e->play <= PLAY_GIVEN_UP && e->failure_count <= EVIDENCE_FAILURES);
    for (unsigned i = 0; i < EVIDENCE_FAILURES; i++) {
        must((unsigned)e->failures[i].kind <= FAILURE_REFUSED);
        must(e->failures[i].value_count <= EVIDENCE_VALUES);
        for (unsigned k = 0; k < EVIDENCE_VALUES; k++)
            is_flag(&e->failures[i].values[k].is_double);
    }
    for (unsigned i = 0; i < EVIDENCE_LINES; i++)
        is_flag(&e->lines[i].value.is_double);
}

static void rest_is_allowed(const struct evidence *e)
{
    must(e->axis_count <= EVIDENCE_AXES && e->eeprom.size <= EVIDENCE_EEPROM);
    must(e->digest.state_count <= DIGEST_STATES && e->coverage.size <= COVERAGE_MOST);
    must(e->sketch.used <= SKETCH_BUCKETS && (e->sketch.used == 0 || e->sketch.per_bucket > 0));
    is_flag(&e->all_op);
    is_flag(&e->eeprom.saved);
    is_flag(&e->instrumented);
    is_flag(&e->lookup.asked);
    is_flag(&e->lookup.found);
    is_flag(&e->clock.used);
    is_flag(&e->clock.priority);
    is_flag(&e->clock.pinned);
    is_flag(&e->clock.locked);
    for (unsigned i = 0; i < EVIDENCE_AXES; i++)
        is_flag(&e->unable[i].fault);
    for (unsigned i = 0; i < EVIDENCE_FAULTS; i++)
        ENDS(e->faults[i].text);
    ENDS(e->clock.notice);
    ENDS(e->trouble);
}

static void audit_is_allowed(const struct audit_record *audit)
{
    is_flag(&audit->traced);
    must(audit->access_count <= AUDIT_ACCESSES);
    for (unsigned i = 0; i < AUDIT_ACCESSES; i++) {
        const struct audit_access *access = &audit->accesses[i];
        is_flag(&access->write);
        is_flag(&access->before_op);
        must(access->entry < ENTRY_COUNT);
        must(access->memory < AUDIT_MEMORIES || access->memory == AUDIT_CODE);
    }
}

static void is_allowed(const struct experiment_result *result)
{
    call_is_allowed(&result->evidence);
    races_are_allowed(&result->evidence);
    play_is_allowed(&result->evidence);
    rest_is_allowed(&result->evidence);
    audit_is_allowed(&result->evidence.audit);
    must((unsigned)result->worker.end <= WORKER_TIMEOUT);
    ENDS(result->worker.reason);
}

/* --- inputs ----------------------------------------------------------------------------------- */

static void read_file(const uint8_t *bytes, size_t size)
{
    static struct experiment_result read, again;
    char why[EVIDENCE_WHY] = "";
    uint8_t *first, *second;
    size_t first_size, second_size;
    const int r = evidence_decode(&read, bytes, size, why);
    must((r == 0) == (why[0] == '\0'));
    if (r != 0)
        return;
    taken++;
    is_allowed(&read);
    if (size % 4 != 0)
        return;
    must(evidence_encode(&read, &first, &first_size) == 0);
    must(evidence_decode(&again, first, first_size, why) == 0);
    must(evidence_encode(&again, &second, &second_size) == 0);
    must(first_size == second_size && memcmp(first, second, first_size) == 0);
    free(first);
    free(second);
}

static void put(uint8_t *to, size_t value)
{
    for (int i = 0; i < 4; i++)
        to[i] = (uint8_t)(value >> 8 * i);
}

/* The first members, or the last ones: the others are zero. */
static void read_values(const uint8_t *data, size_t size)
{
    if (size < 2)
        return;
    const size_t offset = (data[0] | (size_t)data[1] << 8) % values_size;
    const size_t most = values_size - offset;
    const size_t count = size - 2 < most ? size - 2 : most, rest = most - count;
    uint8_t *file = malloc(HEAD + PIECE + count + PIECE);
    must(file != NULL);
    memcpy(file, head, HEAD);
    put(file + HEAD, offset);
    put(file + HEAD + 4, count);
    memcpy(file + HEAD + PIECE, data + 2, count);
    put(file + HEAD + PIECE + count, rest);
    put(file + HEAD + PIECE + count + 4, 0);
    read_file(file, HEAD + PIECE + count + (rest > 0 ? PIECE : 0));
    free(file);
}

static size_t get(const uint8_t *from)
{
    return from[0] | (size_t)from[1] << 8 | (size_t)from[2] << 16 | (size_t)from[3] << 24;
}

/* What pieces leave out is filled up with zeros: how many there are, the fuzzer could only guess.
 */
static void read_pieces(const uint8_t *data, size_t size)
{
    size_t at = 0, total = 0;
    uint8_t *file = malloc(HEAD + size + PIECE);
    must(file != NULL);
    memcpy(file, head, HEAD);
    memcpy(file + HEAD, data, size);
    while (at + PIECE <= size && total < values_size) {
        total += get(data + at) + get(data + at + 4);
        at += PIECE + get(data + at + 4);
    }
    if (at == size && total < values_size) {
        put(file + HEAD + size, values_size - total);
        put(file + HEAD + size + 4, 0);
        size += PIECE;
    }
    read_file(file, HEAD + size);
    free(file);
}

/* Any bytes; zeros where the head is mean the right ones. */
static void read_any(const uint8_t *data, size_t size)
{
    uint8_t *file = malloc(size + 1);
    must(file != NULL);
    memcpy(file, data, size);
    for (size_t i = 0; i < HEAD && i < size; i++)
        file[i] ^= head[i];
    read_file(file, size);
    free(file);
}

static void read_waivers(const uint8_t *data, size_t size)
{
    static struct waivers waivers;
    char why[WAIVERS_WHY] = "";
    const int r = waivers_read(&waivers, (const char *)data, size, "fuzz", why);
    must((r == 0) == (why[0] == '\0') && waivers.count <= WAIVERS_MOST);
    for (size_t i = 0; i < waivers.count; i++)
        waived += waiver_expired(&waivers.list[i], "2026-11-27");
}

static void say_what_was_seen(void)
{
    fprintf(stderr, "%llu inputs: %llu of evidence, %llu expired waivers\n", inputs, taken, waived);
    free(head);
}

int LLVMFuzzerInitialize(int *argument_count, char ***arguments)
{
    static const struct experiment_result nothing;
    size_t size;
    (void)argument_count;
    (void)arguments;
    must(evidence_encode(&nothing, &head, &size) == 0);
    for (int i = 3; i >= 0; i--)
        values_size = values_size << 8 | head[HEAD - 8 + i];
    return atexit(say_what_was_seen);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static void (*const ways[])(const uint8_t *, size_t) = { read_values, read_pieces, read_any,
                                                             read_waivers };
    inputs++;
    if (size > 0)
        ways[data[0] % 4](data + 1, size - 1);
    return 0;
}
