/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A description as a whole: what must hold before it becomes a device type. */
#include "bus/description.h"
#include "bus/mailbox.h"
#include "bus/slave.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

struct description *description_new(const char *file)
{
    struct description *d = calloc(1, sizeof *d);

    if (!d)
        return NULL;
    d->file = file;
    d->type = d->about = d->name = d->order = d->group = "";
    d->ports = 0x0033;
    return d;
}

const char *description_text(struct description *d, const char *text, size_t length)
{
    char *copy = d->text + d->text_used;

    if (length >= DESC_TEXT - d->text_used)
        return NULL;
    memcpy(copy, text, length);
    copy[length] = '\0';
    d->text_used += length + 1;
    return copy;
}

static const struct {
    uint8_t type;
    const char *name;
} types[] = {
    { OD_BOOL, "bool" },     { OD_I8, "i8" },         { OD_I16, "i16" },
    { OD_I32, "i32" },       { OD_I64, "i64" },       { OD_U8, "u8" },
    { OD_U16, "u16" },       { OD_U32, "u32" },       { OD_U64, "u64" },
    { OD_REAL32, "real32" }, { OD_REAL64, "real64" }, { OD_STRING, "string" },
    { OD_BIT1, "bit1" },     { OD_BIT1 + 1, "bit2" }, { OD_BIT1 + 2, "bit3" },
    { OD_BIT1 + 3, "bit4" }, { OD_BIT1 + 4, "bit5" }, { OD_BIT1 + 5, "bit6" },
    { OD_BIT1 + 6, "bit7" }, { OD_BIT1 + 7, "bit8" },
};
#define TYPES (sizeof types / sizeof *types)

uint8_t description_type(const char *name)
{
    for (size_t i = 0; i < TYPES; i++) {
        if (strcmp(types[i].name, name) == 0)
            return types[i].type;
    }
    return 0;
}

const char *description_type_name(uint8_t type)
{
    for (size_t i = 0; i < TYPES; i++) {
        if (types[i].type == type)
            return types[i].name;
    }
    return NULL;
}

void description_limits(uint8_t type, int64_t *least, int64_t *most)
{
    unsigned bits = od_type_bits(type);

    *least = INT64_MIN;
    *most = INT64_MAX;
    if (bits == 0 || bits == 64)
        return;
    *most = (int64_t)((UINT64_C(1) << (od_type_signed(type) ? bits - 1 : bits)) - 1);
    *least = od_type_signed(type) ? -*most - 1 : 0;
}

bool description_coe(const struct description *d)
{
    return d->coe_details != 0;
}

int description_sm(const struct description *d, uint8_t type)
{
    for (unsigned n = 0; n < d->sm_count; n++) {
        if (d->sm[n].type == type)
            return (int)n;
    }
    return -1;
}

bool description_generates(const struct description *d, uint16_t index)
{
    return index == 0x1018 || (index >= 0x1600 && index < 0x1c00) || index == 0x1c00 ||
           (index >= 0x1c10 && index < 0x1c10 + d->sm_count);
}

const struct desc_entry *description_entry(const struct description *d,
                                           enum pdo_direction direction, uint16_t index,
                                           uint8_t subindex)
{
    for (unsigned i = 0; i < d->pdo_count; i++) {
        const struct desc_pdo *pdo = &d->pdo[i];

        for (unsigned k = pdo->first; pdo->direction == direction && k < pdo->first + pdo->count;
             k++) {
            if (index && d->entry[k].index == index && d->entry[k].subindex == subindex)
                return &d->entry[k];
        }
    }
    return NULL;
}

unsigned description_image_bits(const struct description *d, enum pdo_direction direction)
{
    unsigned bits = 0;

    for (unsigned i = 0; i < d->pdo_count; i++) {
        const struct desc_pdo *pdo = &d->pdo[i];

        if (pdo->direction != direction || pdo->sm == DESC_NO_SM)
            continue;
        for (unsigned k = pdo->first; k < pdo->first + pdo->count; k++)
            bits += d->entry[k].bits;
    }
    return bits;
}

static unsigned sm_bytes(const struct description *d, const struct desc_sm *sm)
{
    if (sm->type == SII_SM_OUTPUTS)
        return (description_image_bits(d, PDO_RX) + 7) / 8;
    if (sm->type == SII_SM_INPUTS)
        return (description_image_bits(d, PDO_TX) + 7) / 8;
    return sm->length;
}

/* Memory a sync manager takes: process data of more than a byte has three buffers. */
static unsigned sm_span(const struct description *d, const struct desc_sm *sm)
{
    unsigned bytes = sm_bytes(d, sm);
    bool process = sm->type == SII_SM_OUTPUTS || sm->type == SII_SM_INPUTS;

    return process && bytes > 1 ? 3 * bytes : bytes;
}

static const char *const sm_names[] = { "unused", "mailbox-out", "mailbox-in", "outputs",
                                        "inputs" };

static int check_sm(const struct description *d, unsigned n, char why[SCAN_WHY])
{
    const struct desc_sm *sm = &d->sm[n];
    unsigned span = sm_span(d, sm);
    bool mailbox = sm->type == SII_SM_MBX_OUT || sm->type == SII_SM_MBX_IN;

    if (sm->start < REG_DIGITAL_OUT || sm->start + span > SLAVE_MEMORY)
        return why_at(why, d->file, sm->place,
                      "sync manager %u covers 0x%04X to 0x%04X; expected to stay in the memory "
                      "0x%04X to 0x%04X (%s)",
                      n, sm->start, sm->start + span - (span > 0), REG_DIGITAL_OUT,
                      SLAVE_MEMORY - 1, mailbox ? "mailbox" : "process data, three buffers");
    if (sm->type != SII_SM_UNUSED && description_sm(d, sm->type) != (int)n)
        return why_at(why, d->file, sm->place,
                      "sync manager %u is a second one for %s; expected one of each", n,
                      sm_names[sm->type]);
    if (mailbox && (sm->length < 16 || sm->length > MAILBOX_MAX))
        return why_at(why, d->file, sm->place, "a mailbox of %u bytes; expected 16 to %d",
                      sm->length, MAILBOX_MAX);
    if (mailbox && n != sm->type - 1u)
        return why_at(why, d->file, sm->place, "%s is sync manager %u; expected %u",
                      sm_names[sm->type], n, sm->type - 1u);
    for (unsigned other = 0; other < n; other++) {
        const struct desc_sm *o = &d->sm[other];

        if (sm->start < o->start + sm_span(d, o) && o->start < sm->start + span)
            return why_at(why, d->file, sm->place,
                          "sync managers %u and %u overlap: 0x%04X + %u and 0x%04X + %u bytes "
                          "(process data counts three times); expected apart",
                          other, n, o->start, sm_span(d, o), sm->start, span);
    }
    return 0;
}

static int check_managers(const struct description *d, char why[SCAN_WHY])
{
    int out = description_sm(d, SII_SM_MBX_OUT), in = description_sm(d, SII_SM_MBX_IN);

    for (unsigned n = 0; n < d->sm_count; n++) {
        if (check_sm(d, n, why))
            return -EINVAL;
    }
    if ((out < 0) != (in < 0))
        return why_at(why, d->file, d->sm[out < 0 ? in : out].place,
                      "half a mailbox; expected both mailbox-out and mailbox-in");
    if (description_coe(d) && out < 0)
        return why_at(why, d->file, d->coe_place,
                      "CoE without a mailbox; expected sync managers mailbox-out and mailbox-in");
    if (d->emulation && out >= 0)
        return why_at(why, d->file, d->sm[out].place,
                      "a mailbox without a processor to serve it; expected no mailbox beside "
                      "\"emulation\"");
    return 0;
}

static const struct desc_row *find_row(const struct description *d, uint16_t index,
                                       uint8_t subindex)
{
    for (unsigned i = 0; i < d->object_count; i++) {
        const struct desc_object *o = &d->object[i];

        for (unsigned k = o->first; o->index == index && k < o->first + o->count; k++) {
            if (d->row[k].subindex == subindex)
                return &d->row[k];
        }
    }
    return NULL;
}

static int check_entry(const struct description *d, const struct desc_pdo *pdo, unsigned k,
                       char why[SCAN_WHY])
{
    const struct desc_entry *e = &d->entry[k];
    const struct desc_row *row;

    if (!e->index)
        return 0;
    for (unsigned i = pdo->first; i < k; i++) {
        if (d->entry[i].index == e->index && d->entry[i].subindex == e->subindex)
            return why_at(why, d->file, e->place,
                          "0x%04X:%02X is in this PDO already; expected each entry once", e->index,
                          e->subindex);
    }
    if (!od_type_bits(e->type))
        return why_at(why, d->file, e->place, "a string in a PDO; expected a type of fixed size");
    if (!description_coe(d))
        return 0;
    row = find_row(d, e->index, e->subindex);
    if (!row)
        return why_at(why, d->file, e->place,
                      "0x%04X:%02X is not in the object dictionary; expected an object with this "
                      "entry",
                      e->index, e->subindex);
    if (od_type_bits(row->type) != e->bits)
        return why_at(why, d->file, e->place,
                      "0x%04X:%02X has %u bits here and %u in the object dictionary; expected the "
                      "same type",
                      e->index, e->subindex, e->bits, od_type_bits(row->type));
    return 0;
}

static int check_pdo(const struct description *d, unsigned n, char why[SCAN_WHY])
{
    const struct desc_pdo *pdo = &d->pdo[n];
    bool rx = pdo->direction == PDO_RX;
    unsigned first = rx ? 0x1600 : 0x1a00, wanted = rx ? SII_SM_OUTPUTS : SII_SM_INPUTS;
    int error = 0;

    if (pdo->index < first || pdo->index >= first + 0x200)
        return why_at(why, d->file, pdo->place, "%s PDO 0x%04X; expected 0x%04X to 0x%04X",
                      rx ? "rx" : "tx", pdo->index, first, first + 0x1ff);
    for (unsigned i = 0; i < n; i++) {
        if (d->pdo[i].index == pdo->index)
            return why_at(why, d->file, pdo->place,
                          "PDO 0x%04X stands in line %u already; "
                          "expected each once",
                          pdo->index, d->pdo[i].place.line);
        if (d->pdo[i].direction == pdo->direction && d->pdo[i].index > pdo->index)
            return why_at(why, d->file, pdo->place,
                          "PDO 0x%04X behind 0x%04X; expected ascending indices", pdo->index,
                          d->pdo[i].index);
    }
    if (pdo->sm == DESC_NO_SM && !description_coe(d))
        return why_at(why, d->file, pdo->place,
                      "PDO 0x%04X is in no sync manager; expected \"sm N\" (only CoE can assign it "
                      "later)",
                      pdo->index);
    if (pdo->sm != DESC_NO_SM && (pdo->sm >= d->sm_count || d->sm[pdo->sm].type != wanted))
        return why_at(why, d->file, pdo->place,
                      "PDO 0x%04X is in sync manager %u; expected one of type %s", pdo->index,
                      pdo->sm, sm_names[wanted]);
    if (pdo->count > 254)
        return why_at(why, d->file, pdo->place, "%u entries; expected at most 254", pdo->count);
    for (unsigned k = pdo->first; !error && k < pdo->first + pdo->count; k++)
        error = check_entry(d, pdo, k, why);
    return error;
}

static int check_row(const struct description *d, const struct desc_object *object, unsigned k,
                     char why[SCAN_WHY])
{
    const struct desc_row *row = &d->row[k];
    int64_t least, most;

    if (k > object->first && row->subindex <= row[-1].subindex)
        return why_at(why, d->file, row->place,
                      "subindex %u behind %u; expected ascending subindices", row->subindex,
                      row[-1].subindex);
    if (row->type == OD_STRING && (row->access & (OD_RW & ~OD_RO)))
        return why_at(why, d->file, row->place, "a string that can be written; expected ro");
    description_limits(row->type, &least, &most);
    if (row->ranged && (row->least < least || row->most > most))
        return why_at(why, d->file, row->place,
                      "the range %lld..%lld; expected within %lld..%lld "
                      "of %s",
                      (long long)row->least, (long long)row->most, (long long)least,
                      (long long)most, description_type_name(row->type));
    if (row->ranged) {
        least = row->least;
        most = row->most;
    }
    if (row->type != OD_STRING && (row->initial < least || row->initial > most))
        return why_at(why, d->file, row->place, "the initial value %lld; expected %lld to %lld",
                      (long long)row->initial, (long long)least, (long long)most);
    return 0;
}

static int check_object(const struct description *d, unsigned n, char why[SCAN_WHY])
{
    const struct desc_object *object = &d->object[n];
    int error = 0;

    if (!description_coe(d))
        return why_at(why, d->file, object->place,
                      "objects of a device without CoE; expected a \"coe\" line");
    if (description_generates(d, object->index))
        return why_at(why, d->file, object->place,
                      "object 0x%04X follows from identity, PDOs and sync managers; expected "
                      "another one",
                      object->index);
    if (n && object->index <= object[-1].index)
        return why_at(why, d->file, object->place,
                      "object 0x%04X behind 0x%04X; expected ascending indices", object->index,
                      object[-1].index);
    if (!object->count)
        return why_at(why, d->file, object->place, "object 0x%04X is empty; expected entries",
                      object->index);
    for (unsigned k = object->first; !error && k < object->first + object->count; k++)
        error = check_row(d, object, k, why);
    return error;
}

/* Bits 0: any number of them. */
static int check_ref(const struct description *d, enum pdo_direction direction,
                     const struct desc_ref *ref, unsigned bits, char why[SCAN_WHY])
{
    const struct desc_entry *e = description_entry(d, direction, ref->index, ref->subindex);

    if (!e)
        return why_at(why, d->file, ref->place, "0x%04X:%02X is in no %s PDO; expected an entry",
                      ref->index, ref->subindex, direction == PDO_RX ? "rx" : "tx");
    if (bits && e->bits != bits)
        return why_at(why, d->file, ref->place, "0x%04X:%02X has %u bits; expected %u", ref->index,
                      ref->subindex, e->bits, bits);
    return 0;
}

static int check_channel(const struct description *d, enum pdo_direction direction,
                         const struct desc_channel *channels, unsigned n, char why[SCAN_WHY])
{
    const struct desc_channel *c = &channels[n];
    int64_t least, most;

    if (check_ref(d, direction, &c->value, 0, why))
        return -EINVAL;
    for (unsigned i = 0; i < n; i++) {
        if (channels[i].value.index == c->value.index &&
            channels[i].value.subindex == c->value.subindex)
            return why_at(why, d->file, c->value.place,
                          "0x%04X:%02X is channel %u already; expected each once", c->value.index,
                          c->value.subindex, i);
    }
    for (unsigned f = 0; f < TERMINAL_FLAGS; f++) {
        if (c->flag[f].index &&
            check_ref(d, direction, &c->flag[f], f == TERMINAL_STATUS ? 8 : 1, why))
            return -EINVAL;
    }
    description_limits(description_entry(d, direction, c->value.index, c->value.subindex)->type,
                       &least, &most);
    if (c->safe < least || c->safe > most)
        return why_at(why, d->file, c->value.place, "the safe value %lld; expected %lld to %lld",
                      (long long)c->safe, (long long)least, (long long)most);
    return 0;
}

static int check_names(const struct description *d, char why[SCAN_WHY])
{
    const char *texts[] = { d->name, d->order, d->group };

    if (!d->type[0] || strlen(d->type) > DESC_NAME)
        return why_at(why, d->file, d->place, "a type name of %zu characters; expected 1 to %d",
                      strlen(d->type), DESC_NAME);
    for (unsigned i = 0; i < 3; i++) {
        if (strlen(texts[i]) > DESC_NAME)
            return why_at(why, d->file, d->place,
                          "name, order or group of %zu characters; expected at most %d",
                          strlen(texts[i]), DESC_NAME);
    }
    if (!d->vendor || !d->product)
        return why_at(why, d->file, d->place,
                      "no identity; expected a vendor and a product other than 0");
    return 0;
}

int description_check(const struct description *d, char why[SCAN_WHY])
{
    int error = check_names(d, why);

    if (!error)
        error = check_managers(d, why);
    for (unsigned n = 0; !error && n < d->object_count; n++)
        error = check_object(d, n, why);
    for (unsigned n = 0; !error && n < d->pdo_count; n++)
        error = check_pdo(d, n, why);
    for (unsigned n = 0; !error && n < d->input_count; n++)
        error = check_channel(d, PDO_TX, d->input, n, why);
    for (unsigned n = 0; !error && n < d->output_count; n++)
        error = check_channel(d, PDO_RX, d->output, n, why);
    return error;
}
