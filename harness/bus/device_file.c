/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Device files: one statement a line, one function a statement (docs/device-files.md). */
#include "bus/description.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

enum within { NOTHING, PDO, OBJECT };

struct reader {
    struct scan scan;
    struct description *d;
    enum within within; /* what an `entry` line belongs to */
    unsigned seen;      /* bit per row of `statements`: stands once only */
};

static bool keep(struct reader *r, const char *text, const char **kept)
{
    *kept = description_text(r->d, text, strlen(text));
    return *kept ||
           scan_fail(&r->scan, "too much text; expected at most %d characters in all", DESC_TEXT);
}

static bool text(struct reader *r, const char *what, const char **kept)
{
    const char *word;

    return scan_text(&r->scan, what, &word) && keep(r, word, kept);
}

static bool full(struct reader *r, unsigned count, unsigned most, const char *what)
{
    return count < most || scan_fail(&r->scan, "too many %s; expected at most %u", what, most);
}

static bool number16(struct reader *r, const char *what, uint16_t *to)
{
    int64_t value;

    if (!scan_number(&r->scan, what, 0, 0xffff, &value))
        return false;
    *to = (uint16_t)value;
    return true;
}

static bool number8(struct reader *r, const char *what, uint8_t *to)
{
    int64_t value;

    if (!scan_number(&r->scan, what, 0, 0xff, &value))
        return false;
    *to = (uint8_t)value;
    return true;
}

static bool device(struct reader *r)
{
    r->d->place = scan_start(&r->scan);
    return text(r, "a type name", &r->d->type) && text(r, "a description", &r->d->about);
}

static bool identity(struct reader *r)
{
    static const char *const words[] = { "vendor", "product", "revision" };
    uint32_t *const to[] = { &r->d->vendor, &r->d->product, &r->d->revision };
    unsigned n;
    int64_t value;

    /* The line starts with one of these: it is read again, as the first of them. */
    r->scan.next = 0;
    do {
        if (!scan_choice(&r->scan, "vendor, product or revision", words, 3, &n) ||
            !scan_number(&r->scan, "an id", 0, 0xffffffff, &value))
            return false;
        *to[n] = (uint32_t)value;
    } while (scan_more(&r->scan));
    return true;
}

static bool name(struct reader *r)
{
    return text(r, "the name", &r->d->name);
}

static bool order(struct reader *r)
{
    return text(r, "the order code", &r->d->order);
}

static bool group(struct reader *r)
{
    return text(r, "the group", &r->d->group);
}

static bool pdi(struct reader *r)
{
    static const char *const words[] = { "config", "extended", "pulse" };
    uint16_t *const to[] = { &r->d->pdi_config, &r->d->pdi_config_ext, &r->d->sync_pulse };
    unsigned n;

    if (!number16(r, "the PDI control word", &r->d->pdi_control))
        return false;
    while (scan_more(&r->scan)) {
        if (!scan_choice(&r->scan, "config, extended or pulse", words, 3, &n) ||
            !number16(r, "a word", to[n]))
            return false;
    }
    return true;
}

static bool emulation(struct reader *r)
{
    r->d->emulation = true;
    return true;
}

static bool dc(struct reader *r)
{
    static const char *const words[] = { "none", "delay", "full" };
    unsigned n;

    if (!scan_choice(&r->scan, "none, delay or full", words, 3, &n))
        return false;
    r->d->dc = (enum desc_dc)n;
    return !scan_is(&r->scan, "assign") || number16(r, "AssignActivate", &r->d->dc_assign);
}

static bool ports(struct reader *r)
{
    static const char *const words[] = { "none", "mii", "ebus", "fast" };
    static const uint16_t nibble[] = { 0, 1, 3, 4 };
    unsigned n;

    r->d->ports = 0;
    for (unsigned port = 0; port == 0 || scan_more(&r->scan); port++) {
        if (port == 4)
            return scan_end(&r->scan);
        if (!scan_choice(&r->scan, "the kind of a port", words, 4, &n))
            return false;
        r->d->ports = (uint16_t)(r->d->ports | nibble[n] << (4 * port));
    }
    return true;
}

static bool current(struct reader *r)
{
    int64_t value;

    if (!scan_number(&r->scan, "the E-bus current in mA", INT16_MIN, INT16_MAX, &value))
        return false;
    r->d->current = (int16_t)value;
    return true;
}

static bool coe(struct reader *r)
{
    static const char *const words[] = { "sdo", "info", "assign", "config", "upload", "complete" };
    unsigned n;

    r->d->coe_place = scan_start(&r->scan);
    r->d->coe_details = 0x01;
    while (scan_more(&r->scan)) {
        if (!scan_choice(&r->scan, "a CoE service", words, 6, &n))
            return false;
        r->d->coe_details = (uint8_t)(r->d->coe_details | 1u << n);
    }
    return true;
}

static bool sm(struct reader *r)
{
    static const char *const types[] = { "unused", "mailbox-out", "mailbox-in", "outputs",
                                         "inputs" };
    static const uint8_t control[] = { 0, 0x26, 0x22, 0x64, 0x20 };
    struct desc_sm *to = &r->d->sm[r->d->sm_count];
    unsigned type;
    int64_t n;

    if (!full(r, r->d->sm_count, SII_MAX_SM, "sync managers") ||
        !scan_number(&r->scan, "the number of the sync manager", 0, SII_MAX_SM - 1, &n))
        return false;
    if (n != r->d->sm_count)
        return scan_fail(&r->scan, "sync manager %d; expected %u, in ascending order", (int)n,
                         r->d->sm_count);
    to->place = scan_start(&r->scan);
    if (!number16(r, "the start address", &to->start) || !number16(r, "the length", &to->length) ||
        !scan_choice(&r->scan, "the type of the sync manager", types, 5, &type))
        return false;
    to->type = (uint8_t)type;
    to->control = control[type];
    to->enable = type != SII_SM_UNUSED;
    if (scan_is(&r->scan, "control") && !number8(r, "the control byte", &to->control))
        return false;
    if (scan_is(&r->scan, "enable") && !number8(r, "the enable byte", &to->enable))
        return false;
    r->d->sm_count++;
    return true;
}

static bool fmmu(struct reader *r)
{
    static const char *const words[] = { "none", "outputs", "inputs", "mailbox-state" };
    unsigned use;

    do {
        if (!full(r, r->d->fmmu_count, SII_MAX_FMMU, "FMMUs") ||
            !scan_choice(&r->scan, "the use of an FMMU", words, 4, &use))
            return false;
        r->d->fmmu[r->d->fmmu_count++] = (uint8_t)use;
    } while (scan_more(&r->scan));
    return true;
}

static bool pdo(struct reader *r)
{
    static const char *const directions[] = { "rx", "tx" };
    static const char *const words[] = { "mandatory", "fixed", "default" };
    static const uint16_t flag[] = { 0x01, 0x10, 0x02 };
    struct desc_pdo *to = &r->d->pdo[r->d->pdo_count];
    unsigned n;

    if (!full(r, r->d->pdo_count, DESC_PDOS, "PDOs") ||
        !scan_choice(&r->scan, "rx or tx", directions, 2, &n))
        return false;
    *to = (struct desc_pdo){ .place = scan_start(&r->scan),
                             .direction = (enum pdo_direction)n,
                             .sm = DESC_NO_SM,
                             .first = r->d->entry_count };
    if (!number16(r, "the index of the PDO", &to->index))
        return false;
    if (scan_is(&r->scan, "sm") && !number8(r, "the number of its sync manager", &to->sm))
        return false;
    while (scan_more(&r->scan) && !r->scan.token[r->scan.next].quoted) {
        if (!scan_choice(&r->scan, "mandatory, fixed, default or a name in quotes", words, 3, &n))
            return false;
        to->flags |= flag[n];
    }
    r->within = PDO;
    r->d->pdo_count++;
    return text(r, "the name of the PDO", &to->name);
}

static bool type(struct reader *r, uint8_t *to)
{
    static const char *const names[] = { "bool",   "i8",     "i16",  "i32",  "i64",
                                         "u8",     "u16",    "u32",  "u64",  "real32",
                                         "real64", "string", "bit1", "bit2", "bit3",
                                         "bit4",   "bit5",   "bit6", "bit7", "bit8" };
    unsigned n;

    if (!scan_choice(&r->scan, "a data type", names, sizeof names / sizeof *names, &n))
        return false;
    *to = description_type(names[n]);
    return true;
}

static bool pdo_entry(struct reader *r)
{
    struct desc_entry *to = &r->d->entry[r->d->entry_count];

    *to = (struct desc_entry){ .place = scan_start(&r->scan) };
    if (!full(r, r->d->entry_count, DESC_ENTRIES, "PDO entries") ||
        !scan_object(&r->scan, "the object", &to->index, &to->subindex) || !type(r, &to->type) ||
        !text(r, "the name of the entry", &to->name))
        return false;
    to->bits = (uint8_t)od_type_bits(to->type);
    r->d->entry_count++;
    r->d->pdo[r->d->pdo_count - 1].count++;
    return true;
}

static bool gap(struct reader *r)
{
    struct desc_entry *to = &r->d->entry[r->d->entry_count];
    int64_t bits;

    if (r->within != PDO)
        return scan_fail(&r->scan, "a gap outside of a PDO; expected it behind \"pdo\"");
    *to = (struct desc_entry){ .place = scan_start(&r->scan), .name = "" };
    if (!full(r, r->d->entry_count, DESC_ENTRIES, "PDO entries") ||
        !scan_number(&r->scan, "the bits of the gap", 1, 255, &bits))
        return false;
    to->bits = (uint8_t)bits;
    r->d->entry_count++;
    r->d->pdo[r->d->pdo_count - 1].count++;
    return true;
}

static bool object(struct reader *r)
{
    struct desc_object *to = &r->d->object[r->d->object_count];

    if (!full(r, r->d->object_count, DESC_OBJECTS, "objects"))
        return false;
    *to = (struct desc_object){ .place = scan_start(&r->scan),
                                .code = OD_RECORD,
                                .first = r->d->row_count };
    if (!number16(r, "the index of the object", &to->index))
        return false;
    if (scan_is(&r->scan, "array"))
        to->code = OD_ARRAY;
    r->within = OBJECT;
    r->d->object_count++;
    return text(r, "the name of the object", &to->name);
}

static bool value(struct reader *r, struct desc_row *to)
{
    if (to->type == OD_STRING)
        return text(r, "the text", &to->text);
    to->initial = 0;
    if (scan_more(&r->scan) && !r->scan.token[r->scan.next].quoted &&
        strcmp(r->scan.token[r->scan.next].text, "range") != 0 &&
        !scan_number(&r->scan, "the initial value", INT64_MIN, INT64_MAX, &to->initial))
        return false;
    if (!scan_is(&r->scan, "range"))
        return true;
    to->ranged = true;
    return scan_range(&r->scan, &to->least, &to->most);
}

static bool object_entry(struct reader *r)
{
    static const char *const words[] = { "ro", "rw", "wo", "rw-preop" };
    static const uint16_t access[] = { OD_RO, OD_RW, OD_RW & ~OD_RO, OD_RW_PREOP };
    struct desc_object *in = &r->d->object[r->d->object_count - 1];
    struct desc_row *to = &r->d->row[r->d->row_count];
    uint16_t index;
    unsigned n;

    *to = (struct desc_row){ .place = scan_start(&r->scan) };
    if (!full(r, r->d->row_count, DESC_ROWS, "entries of objects") ||
        !scan_object(&r->scan, "the entry", &index, &to->subindex))
        return false;
    if (index != in->index)
        return scan_fail(&r->scan, "an entry of 0x%04X; expected one of object 0x%04X", index,
                         in->index);
    if (!type(r, &to->type) || !scan_choice(&r->scan, "the access", words, 4, &n))
        return false;
    to->access = access[n];
    if (!value(r, to) || !text(r, "the name of the entry", &to->name))
        return false;
    if (in->count == 0 && to->subindex == 0)
        in->code = OD_VAR;
    else if (in->code == OD_VAR)
        in->code = OD_RECORD;
    r->d->row_count++;
    in->count++;
    return true;
}

static bool entry(struct reader *r)
{
    if (r->within == PDO)
        return pdo_entry(r);
    if (r->within == OBJECT)
        return object_entry(r);
    return scan_fail(&r->scan, "an entry of nothing; expected it behind \"pdo\" or \"object\"");
}

static bool ref(struct reader *r, const char *what, struct desc_ref *to)
{
    to->place = scan_place(&r->scan);
    return scan_object(&r->scan, what, &to->index, &to->subindex);
}

static bool input(struct reader *r)
{
    static const char *const flags[TERMINAL_FLAGS] = { "status", "under", "over", "error" };
    struct desc_channel *to = &r->d->input[r->d->input_count];
    unsigned n;

    if (!full(r, r->d->input_count, DESC_CHANNELS, "inputs") ||
        !ref(r, "an entry of a tx PDO", &to->value))
        return false;
    while (scan_more(&r->scan)) {
        if (!scan_choice(&r->scan, "status, under, over or error", flags, TERMINAL_FLAGS, &n) ||
            !ref(r, "an entry of a tx PDO", &to->flag[n]))
            return false;
    }
    r->d->input_count++;
    return true;
}

static bool output(struct reader *r)
{
    struct desc_channel *to = &r->d->output[r->d->output_count];

    if (!full(r, r->d->output_count, DESC_CHANNELS, "outputs") ||
        !ref(r, "an entry of an rx PDO", &to->value))
        return false;
    if (scan_is(&r->scan, "safe") &&
        !scan_number(&r->scan, "the safe value", INT64_MIN, INT64_MAX, &to->safe))
        return false;
    r->d->output_count++;
    return true;
}

static bool watchdog(struct reader *r)
{
    static const char *const words[] = { "safe", "hold" };
    unsigned n;

    if (!scan_choice(&r->scan, "what outputs do: safe or hold", words, 2, &n))
        return false;
    r->d->hold = n;
    return true;
}

static const struct statement {
    const char *word;
    bool (*read)(struct reader *);
    bool once;
} statements[] = {
    { "device", device, true },
    { "vendor", identity, true },
    { "product", identity, true },
    { "revision", identity, true },
    { "name", name, true },
    { "order", order, true },
    { "group", group, true },
    { "pdi", pdi, true },
    { "emulation", emulation, true },
    { "dc", dc, true },
    { "ports", ports, true },
    { "current", current, true },
    { "coe", coe, true },
    { "sm", sm, false },
    { "fmmu", fmmu, true },
    { "pdo", pdo, false },
    { "object", object, false },
    { "entry", entry, false },
    { "gap", gap, false },
    { "input", input, false },
    { "output", output, false },
    { "watchdog", watchdog, true },
};
#define STATEMENTS (sizeof statements / sizeof *statements)

static bool statement(struct reader *r)
{
    const char *words[STATEMENTS];
    unsigned n;

    for (size_t i = 0; i < STATEMENTS; i++)
        words[i] = statements[i].word;
    if (!scan_choice(&r->scan, "a statement", words, STATEMENTS, &n))
        return false;
    if (!r->d->place.line && n != 0)
        return scan_fail(&r->scan, "\"%s\" comes first; expected \"device\" as the first statement",
                         words[n]);
    if (statements[n].once && r->seen & 1u << n)
        return scan_fail(&r->scan, "a second \"%s\"; expected one", words[n]);
    r->seen |= 1u << n;
    return statements[n].read(r) && scan_end(&r->scan);
}

int device_file_read(struct description *d, const char *file_text, size_t length,
                     char why[SCAN_WHY])
{
    struct reader *r = calloc(1, sizeof *r);
    int error = 0;

    if (!r) {
        snprintf(why, SCAN_WHY, "%.200s: no memory", d->file);
        return -ENOMEM;
    }
    r->d = d;
    scan_init(&r->scan, d->file, file_text, length, why);
    while (scan_line(&r->scan) && statement(r))
        continue;
    if (!r->scan.failed && !d->place.line)
        scan_fail_at(&r->scan, (struct place){ r->scan.line + (r->scan.line == 0), 1 },
                     "the file describes nothing; expected device \"name\" \"description\"");
    if (r->scan.failed)
        error = -EINVAL;
    if (!error && !d->name[0])
        d->name = d->about;
    if (!error && !d->order[0])
        d->order = d->type;
    free(r);
    return error;
}
