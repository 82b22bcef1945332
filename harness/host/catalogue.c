/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/catalogue.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

struct member {
    const char *owner, *name;
    enum scalar type;
    const char *type_name; /* structure when type is STRUCT */
    size_t count, offset, size;
    const char *access;
    enum access_by access_by;
    const char *unit, *note;
};

struct constant {
    const char *name;
    int64_t value;
};

struct catalogue {
    int generation, memory_id;
    const char *reference; /* the document with all registers */
    const struct catalogue_memory *memories;
    size_t memory_count;
    const struct member *members;
    size_t member_count;
    const struct constant *constants;
    size_t constant_count;
};

#define CATALOGUE_MEMORY(number, name, root, type, count, size, pointer)                           \
    { number, name, root, type, count, size, pointer },
#define CATALOGUE_MEMBER(...)
#define CATALOGUE_CONSTANT(...)
static const struct catalogue_memory memories_gen4[] = {
#include "host/catalogue_gen4.inc"
};
static const struct catalogue_memory memories_gen5_905[] = {
#include "host/catalogue_gen5_905.inc"
};
static const struct catalogue_memory memories_gen5_906[] = {
#include "host/catalogue_gen5_906.inc"
};
#undef CATALOGUE_MEMORY
#undef CATALOGUE_MEMBER

#define CATALOGUE_MEMORY(...)
#define CATALOGUE_MEMBER(owner, name, type, type_name, count, offset, size, access, by, unit,      \
                         note)                                                                     \
    { owner, name, type, type_name, count, offset, size, access, by, unit, note },
static const struct member members_gen4[] = {
#include "host/catalogue_gen4.inc"
};
static const struct member members_gen5_905[] = {
#include "host/catalogue_gen5_905.inc"
};
static const struct member members_gen5_906[] = {
#include "host/catalogue_gen5_906.inc"
};
#undef CATALOGUE_MEMBER
#undef CATALOGUE_CONSTANT

#define CATALOGUE_MEMBER(...)
#define CATALOGUE_CONSTANT(name, value) { name, value },
static const struct constant constants_gen4[] = {
#include "host/catalogue_gen4.inc"
};
static const struct constant constants_gen5_905[] = {
#include "host/catalogue_gen5_905.inc"
};
static const struct constant constants_gen5_906[] = {
#include "host/catalogue_gen5_906.inc"
};
#undef CATALOGUE_MEMORY
#undef CATALOGUE_MEMBER
#undef CATALOGUE_CONSTANT

#define COUNT(array) (sizeof(array) / sizeof *(array))
#define TABLES(name)                                                                               \
    memories_##name, COUNT(memories_##name), members_##name, COUNT(members_##name),                \
        constants_##name, COUNT(constants_##name)

/* The newest of a generation comes first: it is what memory id 0 stands for. */
static const struct catalogue catalogues[] = {
    { 4, 904, "docs/registers-gen4.md", TABLES(gen4) },
    { 5, 906, "docs/registers-gen5-906.md", TABLES(gen5_906) },
    { 5, 905, "docs/registers-gen5-905.md", TABLES(gen5_905) },
};

/* Parts of TGM_System that the manual names without their memory. */
static const struct {
    const char *alias, *path;
} aliases[] = { { "HEADER", "SYSTEM.Header" }, { "MAIN", "SYSTEM.Main" },
                { "TIMERS", "SYSTEM.Timers" }, { "OSC", "SYSTEM.Osc" },
                { "OSC_EX", "SYSTEM.Osc_Ex" }, { "ETH", "SYSTEM.Eth" },
                { "EEPROM", "SYSTEM.Eeprom" } };

static const char *const scalar_names[] = { "I8",  "U8",  "I16", "U16", "I32",   "U32",
                                            "I64", "U64", "F32", "F64", "STRUCT" };
static const size_t scalar_sizes[] = { 1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 0 };

const struct catalogue *catalogue_find(int generation, int memory_id)
{
    for (size_t i = 0; i < COUNT(catalogues); i++)
        if (catalogues[i].generation == generation &&
            (memory_id == 0 || catalogues[i].memory_id == memory_id))
            return &catalogues[i];
    return NULL;
}

const struct catalogue_memory *catalogue_memory(const struct catalogue *catalogue, size_t index)
{
    return index < catalogue->memory_count ? &catalogue->memories[index] : NULL;
}

const struct catalogue_memory *catalogue_memory_named(const struct catalogue *catalogue,
                                                      const char *name)
{
    for (size_t i = 0; i < catalogue->memory_count; i++)
        if (strcmp(catalogue->memories[i].name, name) == 0)
            return &catalogue->memories[i];
    return NULL;
}

bool catalogue_constant(const struct catalogue *catalogue, const char *name, int64_t *value)
{
    for (size_t i = 0; i < catalogue->constant_count; i++)
        if (strcmp(catalogue->constants[i].name, name) == 0) {
            *value = catalogue->constants[i].value;
            return true;
        }
    return false;
}

const char *catalogue_constant_name(const struct catalogue *catalogue, size_t index)
{
    return index < catalogue->constant_count ? catalogue->constants[index].name : NULL;
}

size_t scalar_size(enum scalar type)
{
    return scalar_sizes[type];
}

const char *scalar_name(enum scalar type)
{
    return scalar_names[type];
}

double scalar_get(enum scalar type, const void *at)
{
    union {
        int8_t i8;
        uint8_t u8;
        int16_t i16;
        uint16_t u16;
        int32_t i32;
        uint32_t u32;
        int64_t i64;
        uint64_t u64;
        float f32;
        double f64;
    } v = { 0 };
    memcpy(&v, at, scalar_sizes[type]);
    switch (type) {
    case I8:
        return v.i8;
    case U8:
        return v.u8;
    case I16:
        return v.i16;
    case U16:
        return v.u16;
    case I32:
        return v.i32;
    case U32:
        return v.u32;
    case I64:
        return (double)v.i64;
    case U64:
        return (double)v.u64;
    case F32:
        return (double)v.f32;
    case F64:
        return v.f64;
    case STRUCT:
        break;
    }
    return 0;
}

/* One part of a path: name and optional index; rest points behind it and its dot. */
struct part {
    char name[64];
    bool indexed;
    size_t index;
    const char *rest;
};

static int part_read(const char *text, struct part *part, char why[CATALOGUE_WHY])
{
    size_t length = strcspn(text, ".[");
    if (length == 0 || length >= sizeof part->name) {
        snprintf(why, CATALOGUE_WHY, "'%s' has no register name where one is expected", text);
        return -EINVAL;
    }
    memcpy(part->name, text, length);
    part->name[length] = '\0';
    text += length;
    part->indexed = *text == '[';
    part->index = 0;
    if (part->indexed) {
        char *end;
        errno = 0;
        unsigned long value = strtoul(text + 1, &end, 0);
        if (!isdigit((unsigned char)text[1]) || *end != ']' || errno != 0) {
            snprintf(why, CATALOGUE_WHY, "'%s' needs an index such as %s[0]", part->name,
                     part->name);
            return -EINVAL;
        }
        part->index = value;
        text = end + 1;
    }
    if (*text != '\0' && *text != '.') {
        snprintf(why, CATALOGUE_WHY, "unexpected '%s' after %s", text, part->name);
        return -EINVAL;
    }
    part->rest = *text == '.' ? text + 1 : text;
    return 0;
}

static const struct member *member_find(const struct catalogue *catalogue, const char *owner,
                                        const char *name)
{
    for (size_t i = 0; i < catalogue->member_count; i++) {
        const struct member *member = &catalogue->members[i];
        if (strcmp(member->owner, owner) == 0 && strcmp(member->name, name) == 0)
            return member;
    }
    return NULL;
}

/* What could be meant: same letters in another case, else the first names of the structure. */
static void member_unknown(const struct catalogue *catalogue, const char *owner, const char *name,
                           char why[CATALOGUE_WHY])
{
    const struct member *members = catalogue->members;
    int at = snprintf(why, CATALOGUE_WHY, "%s has no register '%s'", owner, name);
    for (size_t i = 0; i < catalogue->member_count; i++)
        if (strcmp(members[i].owner, owner) == 0 && strcasecmp(members[i].name, name) == 0) {
            snprintf(why + at, (size_t)(CATALOGUE_WHY - at), "; did you mean %s?", members[i].name);
            return;
        }
    at += snprintf(why + at, (size_t)(CATALOGUE_WHY - at), "; it has");
    for (size_t i = 0; i < catalogue->member_count && at < CATALOGUE_WHY - 80; i++)
        if (strcmp(members[i].owner, owner) == 0 && strcmp(members[i].access, "reserved") != 0)
            at += snprintf(why + at, (size_t)(CATALOGUE_WHY - at), " %s", members[i].name);
    snprintf(why + at, (size_t)(CATALOGUE_WHY - at), " ... (%s)", catalogue->reference);
}

static int resolve_member(const struct catalogue *catalogue, const char *owner, const char *path,
                          struct catalogue_register *out, char why[CATALOGUE_WHY])
{
    struct part part;
    int r = part_read(path, &part, why);
    if (r != 0)
        return r;
    const struct member *member = member_find(catalogue, owner, part.name);
    if (member == NULL) {
        member_unknown(catalogue, owner, part.name, why);
        return -EINVAL;
    }
    if (part.index >= member->count || (member->count > 1 && !part.indexed) ||
        (member->count == 1 && part.indexed)) {
        if (member->count > 1)
            snprintf(why, CATALOGUE_WHY, "%s.%s is an array: use %s[0] to %s[%zu]", owner,
                     part.name, part.name, part.name, member->count - 1);
        else
            snprintf(why, CATALOGUE_WHY, "%s.%s is no array", owner, part.name);
        return -EINVAL;
    }
    out->offset += member->offset + part.index * (member->size / member->count);
    if (member->type == STRUCT) {
        if (*part.rest == '\0') {
            snprintf(why, CATALOGUE_WHY,
                     "%s.%s is a group of registers: name one of them, as in %s.%s", owner,
                     part.name, part.name, "<register>");
            return -EINVAL;
        }
        return resolve_member(catalogue, member->type_name, part.rest, out, why);
    }
    if (*part.rest != '\0') {
        snprintf(why, CATALOGUE_WHY, "%s.%s is a single register, '.%s' cannot follow", owner,
                 part.name, part.rest);
        return -EINVAL;
    }
    out->type = member->type;
    out->unit = member->unit;
    out->access = member->access;
    out->access_by = member->access_by;
    return 0;
}

static int resolve_flat(const struct catalogue_memory *memory, const char *path,
                        struct catalogue_register *out, char why[CATALOGUE_WHY])
{
    struct part part;
    int r = part_read(path, &part, why);
    if (r != 0)
        return r;
    for (enum scalar type = I8; type < STRUCT; type++)
        if (strcmp(part.name, scalar_names[type]) == 0 && part.indexed && *part.rest == '\0') {
            if (part.index > memory->size - scalar_sizes[type]) {
                snprintf(why, CATALOGUE_WHY, "%s has %zu bytes, offset %zu is past its end",
                         memory->name, memory->size, part.index);
                return -EINVAL;
            }
            out->offset = part.index;
            out->type = type;
            out->unit = "-";
            out->access = "RW";
            out->access_by = ACCESS_STATED;
            return 0;
        }
    snprintf(why, CATALOGUE_WHY,
             "%s is named by type and byte offset, as in %s.F64[16]; types: I8 U8 I16 U16 I32 "
             "U32 I64 U64 F32 F64",
             memory->root, memory->root);
    return -EINVAL;
}

/* "'GEARBOX' is no memory; allowed: SYSTEM HEADER ... SERVO[n] ... DATA" */
static void root_unknown(const struct catalogue *catalogue, const char *name,
                         char why[CATALOGUE_WHY])
{
    int at = snprintf(why, CATALOGUE_WHY, "'%s' is no memory of generation %d; allowed:", name,
                      catalogue->generation);
    for (size_t i = 0; i < catalogue->memory_count && at < CATALOGUE_WHY; i++) {
        const struct catalogue_memory *memory = &catalogue->memories[i];
        if (strcmp(memory->root, "-") != 0)
            at += snprintf(why + at, (size_t)(CATALOGUE_WHY - at), " %s%s", memory->root,
                           memory->count > 1 ? "[n]" : "");
    }
    for (size_t i = 0; i < COUNT(aliases) && at < CATALOGUE_WHY; i++)
        if (member_find(catalogue, "SYSTEM", strchr(aliases[i].path, '.') + 1) != NULL)
            at += snprintf(why + at, (size_t)(CATALOGUE_WHY - at), " %s", aliases[i].alias);
}

int catalogue_resolve(const struct catalogue *catalogue, const char *name,
                      struct catalogue_register *out, char why[CATALOGUE_WHY])
{
    struct part part;
    int r = part_read(name, &part, why);
    if (r != 0)
        return r;
    memset(out, 0, sizeof *out);
    for (size_t i = 0; i < COUNT(aliases); i++)
        if (strcmp(aliases[i].alias, part.name) == 0 && !part.indexed) {
            char path[CATALOGUE_WHY];
            snprintf(path, sizeof path, "%s.%s", aliases[i].path, part.rest);
            return catalogue_resolve(catalogue, path, out, why);
        }
    for (size_t i = 0; i < catalogue->memory_count; i++) {
        const struct catalogue_memory *memory = &catalogue->memories[i];
        if (strcmp(memory->root, "-") == 0 || strcmp(memory->root, part.name) != 0)
            continue;
        if (part.index >= memory->count || (memory->count > 1 && !part.indexed)) {
            snprintf(why, CATALOGUE_WHY, "use %s[0] to %s[%zu]", part.name, part.name,
                     memory->count - 1);
            return -EINVAL;
        }
        out->memory = memory;
        if (strcmp(memory->type, "-") == 0)
            return resolve_flat(memory, part.rest, out, why);
        out->offset = part.index * (memory->size / memory->count);
        return resolve_member(catalogue, memory->type, part.rest, out, why);
    }
    root_unknown(catalogue, part.name, why);
    return -EINVAL;
}

bool catalogue_line_holds(const struct catalogue_line *line, uint64_t offset)
{
    if (offset >= line->memory->size || offset % line->stride < line->offset)
        return false;
    uint64_t behind = offset % line->stride - line->offset;
    for (size_t i = 0; i < line->array_count; i++) {
        if (behind / line->arrays[i].stride >= line->arrays[i].count)
            return false;
        behind %= line->arrays[i].stride;
    }
    return behind < line->size;
}

/* The index in each pair of brackets of a line's name, from the outermost on. */
static size_t line_indices(const struct catalogue_line *line, uint64_t offset, uint64_t index[6])
{
    size_t count = 0;
    uint64_t rest = offset % line->stride - line->offset;
    if (line->memory->count > 1)
        index[count++] = offset / line->stride;
    for (size_t i = 0; i < line->array_count; i++) {
        index[count++] = rest / line->arrays[i].stride;
        rest %= line->arrays[i].stride;
    }
    if (line->count > 1)
        index[count++] = rest / (line->size / line->count);
    return count;
}

void catalogue_line_name(const struct catalogue_line *line, uint64_t offset, char *out, size_t size)
{
    uint64_t index[6];
    const size_t count = line_indices(line, offset, index);
    size_t used = 0, at = 0;
    for (const char *c = line->name; *c != '\0' && at + 24 < size; c++) {
        out[at++] = *c;
        if (*c != '[' || used == count)
            continue;
        at += (size_t)snprintf(out + at, size - at, "%llu", (unsigned long long)index[used++]);
        while (c[1] != ']' && c[1] != '\0')
            c++;
    }
    out[at] = '\0';
}

static void walk_members(const struct catalogue *catalogue, const char *owner,
                         struct catalogue_line *line, catalogue_visit *visit, void *argument)
{
    const size_t length = strlen(line->name), offset = line->offset;
    for (size_t i = 0; i < catalogue->member_count; i++) {
        const struct member *member = &catalogue->members[i];
        if (strcmp(member->owner, owner) != 0 || strcmp(member->access, "reserved") == 0)
            continue;
        int at = snprintf(line->name + length, sizeof line->name - length, ".%s", member->name);
        if (member->count > 1)
            snprintf(line->name + length + at, sizeof line->name - length - (size_t)at, "[%zu]",
                     member->count);
        line->offset = offset + member->offset;
        if (member->type == STRUCT) {
            const size_t outer = line->array_count;
            if (member->count > 1) {
                line->arrays[outer].count = member->count;
                line->arrays[outer].stride = member->size / member->count;
                line->array_count++;
            }
            walk_members(catalogue, member->type_name, line, visit, argument);
            line->array_count = outer;
        } else {
            line->size = member->size;
            line->count = member->count;
            line->type = member->type;
            line->access = member->access;
            line->access_by = member->access_by;
            line->unit = member->unit;
            line->note = member->note;
            visit(argument, line);
        }
    }
    line->name[length] = '\0';
    line->offset = offset;
}

void catalogue_walk(const struct catalogue *catalogue, catalogue_visit *visit, void *argument)
{
    for (size_t i = 0; i < catalogue->memory_count; i++) {
        const struct catalogue_memory *memory = &catalogue->memories[i];
        struct catalogue_line line = { .memory = memory, .stride = memory->size / memory->count };
        if (strcmp(memory->type, "-") == 0)
            continue;
        snprintf(line.name, sizeof line.name, "%s%s", memory->root, memory->count > 1 ? "[n]" : "");
        walk_members(catalogue, memory->type, &line, visit, argument);
    }
}
