/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/audit.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/evidence.h"

/* Whose registers are the machine's. */
static const struct {
    const char *root;
    bool order; /* the manual's order, inputs before outputs, is about them */
} machine_roots[] = {
    { "SERVO[n]", true }, { "DIO[n]", true }, { "GENERAL[n]", true }, { "INTERPOLATOR[n]", false }
};

/* Parts of them that are neither inputs nor outputs of the machine: what does not change while it
 * runs, and requests that are answered cycles later. */
static const char *const asides[] = { "Number",
                                      "Node",
                                      "Axis",
                                      "Type",
                                      "Resolution",
                                      "ResolutionBits",
                                      "SerialNumber",
                                      "ECATBusPosition",
                                      "FeedbackType",
                                      "Revision",
                                      "MaxCurrent",
                                      "ExtEncoderResolution",
                                      "NumberIn",
                                      "NumberOut",
                                      "NumberAI",
                                      "NumberAO",
                                      "VendorID",
                                      "ProductID",
                                      "DeviceIndex",
                                      "Number_MeasureAmpl",
                                      "Sdo",
                                      "sdoResponseTries",
                                      "CompleteSDO",
                                      "ecatRegister",
                                      "Capture",
                                      "RxBuffer",
                                      "TxBuffer",
                                      "RxPointerWrite",
                                      "RxPointerRead",
                                      "TxPointerWrite",
                                      "TxPointerRead",
                                      "PLC_Send_Lock_Value",
                                      "TGM_Send_Lock_Value",
                                      "TGM_Recv_Lock_Value",
                                      "PLC_Recv_Lock_Value" };

/* The register's own part: "Pg" of "SERVO[n].Pg.Acc". */
static bool is_aside(const char *part)
{
    const size_t length = strcspn(part, ".[");
    for (size_t i = 0; i < sizeof asides / sizeof *asides; i++)
        if (strlen(asides[i]) == length && strncmp(asides[i], part, length) == 0)
            return true;
    return false;
}

static unsigned classify(const struct catalogue_line *line)
{
    const bool read_only = strcmp(line->access, "R") == 0;
    const size_t length = strcspn(line->name, ".");
    unsigned classes = read_only ? AUDIT_READ_ONLY : 0;
    for (size_t i = 0; i < sizeof machine_roots / sizeof *machine_roots; i++) {
        if (strlen(machine_roots[i].root) != length ||
            strncmp(machine_roots[i].root, line->name, length) != 0)
            continue;
        if (machine_roots[i].order && !is_aside(line->name + length + 1))
            classes |= read_only ? AUDIT_INPUT : AUDIT_OUTPUT;
        if (!read_only && line->type == F64)
            classes |= AUDIT_DOUBLE;
        if (!read_only && line->type == F32)
            classes |= AUDIT_SINGLE;
    }
    return classes;
}

/* --- tables ---------------------------------------------------------------------------------- */

struct build {
    struct audit *audit;
    const struct catalogue *catalogue;
    uint16_t counts[AUDIT_MEMORIES]; /* lines so far */
    bool count_only;
    int result;
};

static size_t index_of(const struct catalogue *catalogue, const struct catalogue_memory *memory)
{
    size_t index = 0;
    while (catalogue_memory(catalogue, index) != memory)
        index++;
    return index;
}

/* Every element of the arrays of structures that the line lies in. */
static void mark(struct audit_memory *memory, const struct catalogue_line *line, size_t level,
                 size_t offset, uint16_t number)
{
    if (level < line->array_count) {
        for (size_t i = 0; i < line->arrays[level].count; i++)
            mark(memory, line, level + 1, offset + i * line->arrays[level].stride, number);
        return;
    }
    for (size_t i = 0; i < line->size && offset + i < memory->stride; i++)
        memory->line[offset + i] = number;
}

static void take_line(void *argument, const struct catalogue_line *line)
{
    struct build *build = argument;
    const size_t index = index_of(build->catalogue, line->memory);
    if (index >= AUDIT_MEMORIES)
        return;
    const uint16_t number = ++build->counts[index];
    if (build->count_only)
        return;
    struct audit_memory *memory = &build->audit->memories[index];
    memory->classes[number] = (uint8_t)classify(line);
    mark(memory, line, 0, line->offset, number);
}

static int tables_open(struct audit *audit, struct build *build)
{
    for (size_t i = 0; i < audit->memory_count; i++) {
        const struct catalogue_memory *from = catalogue_memory(build->catalogue, i);
        struct audit_memory *memory = &audit->memories[i];
        memory->bytes = from->size;
        memory->stride = from->size / from->count;
        if (build->counts[i] == 0)
            continue;
        memory->line = calloc(memory->stride, sizeof *memory->line);
        memory->classes = calloc(build->counts[i] + 1u, 1);
        build->counts[i] = 0;
        if (memory->line == NULL || memory->classes == NULL)
            return -ENOMEM;
    }
    build->count_only = false;
    catalogue_walk(build->catalogue, take_line, build);
    return 0;
}

int audit_open(struct audit *audit, const struct catalogue *catalogue, struct audit_record *record)
{
    struct build build = { .audit = audit, .catalogue = catalogue, .count_only = true };
    memset(audit, 0, sizeof *audit);
    audit->record = record;
    while (audit->memory_count < AUDIT_MEMORIES &&
           catalogue_memory(catalogue, audit->memory_count) != NULL)
        audit->memory_count++;
    catalogue_walk(catalogue, take_line, &build);
    const int r = tables_open(audit, &build);
    if (r != 0)
        audit_close(audit);
    return r;
}

void audit_close(struct audit *audit)
{
    for (size_t i = 0; i < audit->memory_count; i++) {
        free(audit->memories[i].line);
        free(audit->memories[i].classes);
    }
    audit->memory_count = 0;
}

/* --- accesses -------------------------------------------------------------------------------- */

/* What identifies a row besides function and direction. */
struct place {
    uint8_t memory, classes;
    uint16_t line;
    uint32_t offset;
};

static struct place place_of(const struct audit *audit, const struct trace_access *access)
{
    struct place place = { .memory = (uint8_t)access->region, .offset = (uint32_t)access->offset };
    if (access->region == TRACE_CODE) {
        place.memory = AUDIT_CODE;
        return place;
    }
    const struct audit_memory *memory = &audit->memories[access->region];
    if (memory->line != NULL && access->offset >= 0 && (uint64_t)access->offset < memory->bytes) {
        place.line = memory->line[(uint64_t)access->offset % memory->stride];
        place.classes = memory->classes[place.line];
    }
    return place;
}

static uint64_t hash(uint64_t pc, uint64_t key)
{
    uint64_t h = (pc ^ key << 32 ^ key >> 7) * UINT64_C(0x9E3779B97F4A7C15);
    return h ^ h >> 29;
}

/* The line of a row is that of its first offset. */
static uint16_t line_of(const struct audit *audit, const struct audit_access *row)
{
    if (row->memory == AUDIT_CODE)
        return 0;
    const struct audit_memory *memory = &audit->memories[row->memory];
    return memory->line != NULL && row->offset < memory->bytes
               ? memory->line[row->offset % memory->stride]
               : 0;
}

/* The row for such an access, NULL when all are taken. A new one has count 0. */
static struct audit_access *row_of(struct audit *audit, enum entry entry,
                                   const struct trace_access *access, const struct place *place)
{
    struct audit_record *record = audit->record;
    const uint64_t key = (uint64_t)place->line << 17 | (uint64_t)place->memory << 9 |
                         (uint64_t)entry << 1 | access->write;
    for (uint64_t slot = hash(access->pc, key) % AUDIT_SLOTS;; slot = (slot + 1) % AUDIT_SLOTS) {
        if (audit->slots[slot] == 0) {
            if (record->access_count >= AUDIT_ACCESSES)
                return NULL;
            audit->slots[slot] = (uint16_t)(record->access_count + 1);
            return &record->accesses[record->access_count++];
        }
        struct audit_access *row = &record->accesses[audit->slots[slot] - 1];
        if (row->pc == access->pc && row->entry == (uint8_t)entry && row->memory == place->memory &&
            row->write == access->write && line_of(audit, row) == place->line)
            return row;
    }
}

/* NaN and infinity have all bits of the exponent set; the high half of a double has them all. */
static bool is_odd(const struct place *place, const struct trace_access *access)
{
    const uint64_t exponent = UINT64_C(0x7FF) << 52;
    if ((place->classes & AUDIT_SINGLE) && access->size == 4)
        return (access->value & 0x7F800000) == 0x7F800000;
    if ((place->classes & AUDIT_DOUBLE) == 0 || access->size < 4)
        return false;
    if (access->size == 8)
        return access->offset % 8 == 0 && (access->value & exponent) == exponent;
    return access->offset % 8 == 4 && (access->value << 32 & exponent) == exponent;
}

static void note_order(struct audit_record *record, struct audit_call *call,
                       const struct trace_access *access, const struct place *place)
{
    struct audit_order *order = &record->functions[call->entry].order;
    if (call->entry == ENTRY_INI)
        return;
    if (access->write && (place->classes & AUDIT_OUTPUT) && !call->written) {
        call->written = true;
        call->pc = access->pc;
        call->offset = place->offset;
        call->memory = place->memory;
    }
    if (access->write || (place->classes & AUDIT_INPUT) == 0 || !call->written || call->told)
        return;
    call->told = true;
    if (order->count++ > 0)
        return;
    order->cycle = call->cycle;
    order->output_pc = call->pc;
    order->output_offset = call->offset;
    order->output_memory = call->memory;
    order->input_pc = access->pc;
    order->input_offset = place->offset;
    order->input_memory = place->memory;
}

static void count(struct audit_access *row, const struct audit_call *call,
                  const struct trace_access *access, const struct place *place)
{
    if (row->count++ == 0) {
        row->pc = access->pc;
        row->first_cycle = call->cycle;
        row->first_value = access->value;
        row->offset = place->offset;
        row->entry = (uint8_t)call->entry;
        row->memory = place->memory;
        row->size = (uint8_t)access->size;
        row->classes = place->classes;
        row->write = access->write;
        row->before_op = !call->op;
    }
    if (access->write && is_odd(place, access) && row->odd_count++ == 0) {
        row->odd_cycle = call->cycle;
        row->odd_offset = place->offset;
    }
}

void audit_access(void *argument, const struct trace_access *access)
{
    struct audit *audit = argument;
    if (audit->depth == 0)
        return;
    struct audit_call *call = &audit->calls[audit->depth - 1];
    if (access->region != TRACE_CODE && access->region >= audit->memory_count) {
        audit->record->functions[call->entry].looked++; /* behind the memories lies PLC_DATA */
        return;
    }
    const struct place place = place_of(audit, access);
    note_order(audit->record, call, access, &place);
    struct audit_access *row = row_of(audit, call->entry, access, &place);
    if (row != NULL)
        count(row, call, access, &place);
    else
        audit->record->access_dropped++;
}

/* --- calls ----------------------------------------------------------------------------------- */

void audit_begin(struct audit *audit, enum entry entry, uint64_t cycle, bool op)
{
    if (audit->depth < MACHINE_LEVELS)
        audit->calls[audit->depth++] =
            (struct audit_call){ .entry = entry, .cycle = cycle, .op = op };
}

void audit_pause(struct audit *audit)
{
    if (audit->depth > 0)
        audit->depth--;
}

void audit_end(struct audit *audit, bool returned, uint64_t instructions, uint64_t stack_bytes)
{
    if (audit->depth == 0)
        return;
    const struct audit_call *call = &audit->calls[--audit->depth];
    struct audit_function *function = &audit->record->functions[call->entry];
    audit->record->traced = audit->record->traced || instructions > 0;
    if (!returned)
        return;
    function->calls++;
    function->instructions += instructions;
    if (instructions > function->worst_instructions) {
        function->worst_instructions = instructions;
        function->worst_cycle = call->cycle;
    }
    if (stack_bytes > function->stack_bytes)
        function->stack_bytes = stack_bytes;
}

void audit_motion(struct audit_record *record, enum audit_motion_kind kind, uint64_t cycle,
                  size_t axis, double value, double limit)
{
    struct audit_motion *motion = &record->motion[kind];
    if (motion->count++ > 0)
        return;
    motion->cycle = cycle;
    motion->axis = (uint32_t)axis;
    motion->value = value;
    motion->limit = limit;
}

/* --- for the judge --------------------------------------------------------------------------- */

static void clean_bool(bool *flag)
{
    unsigned char *byte = (unsigned char *)flag;
    *byte = *byte != 0;
}

void audit_clean(struct audit_record *record)
{
    clean_bool(&record->traced);
    if (record->access_count > AUDIT_ACCESSES)
        record->access_count = AUDIT_ACCESSES;
    for (size_t i = 0; i < AUDIT_ACCESSES; i++) {
        struct audit_access *row = &record->accesses[i];
        clean_bool(&row->write);
        clean_bool(&row->before_op);
        if (row->entry >= ENTRY_COUNT)
            row->entry = ENTRY_INI;
        if (row->memory >= AUDIT_MEMORIES && row->memory != AUDIT_CODE)
            row->memory = 0;
    }
}

struct search {
    const struct catalogue_memory *memory;
    uint32_t offset;
    struct catalogue_line *line;
    bool found;
};

static void match(void *argument, const struct catalogue_line *line)
{
    struct search *search = argument;
    if (search->found || line->memory != search->memory ||
        !catalogue_line_holds(line, search->offset))
        return;
    *search->line = *line;
    search->found = true;
}

bool audit_line(const struct catalogue *catalogue, unsigned memory, uint32_t offset,
                struct catalogue_line *line)
{
    struct search search = { catalogue_memory(catalogue, memory), offset, line, false };
    if (search.memory != NULL)
        catalogue_walk(catalogue, match, &search);
    return search.found;
}

void audit_name(const struct catalogue *catalogue, unsigned memory, uint32_t offset,
                char name[AUDIT_NAME])
{
    struct catalogue_line line;
    const struct catalogue_memory *whose = catalogue_memory(catalogue, memory);
    if (audit_line(catalogue, memory, offset, &line))
        catalogue_line_name(&line, offset, name, AUDIT_NAME);
    else
        snprintf(name, AUDIT_NAME, "byte %u of %s", offset,
                 whose != NULL ? whose->name : "no memory");
}
