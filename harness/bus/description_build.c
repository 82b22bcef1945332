/* SPDX-License-Identifier: GPL-2.0-or-later */
/* From a checked description to a device type: one piece of memory, sized before, filled once. */
#include "bus/description.h"
#include "bus/slave.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* Objects and rows that come on top of those described: 1000, 1008, 1018, 1C00 and 1C10 and
 * following, each with at most one row a PDO, sync manager or entry, and subindex 0. */
enum { EXTRA_OBJECTS = 4 + SII_MAX_SM, ALIGN = 16 };

struct build {
    const struct description *d;
    struct terminal_type *type;
    uint8_t *memory;
    size_t used, size;
    uint32_t instance; /* bytes of an instance so far */
    struct od_object *objects;
    struct od_entry *rows;
    size_t object_count, row_count;
    uint32_t *cells; /* by number of d->entry; only while building */
};

static void *take(struct build *b, size_t count, size_t size)
{
    void *at = b->memory + b->used;

    b->used += (count * size + ALIGN - 1) / ALIGN * ALIGN;
    return at;
}

static size_t arena_size(const struct description *d)
{
    size_t objects = d->object_count + d->pdo_count + EXTRA_OBJECTS;
    size_t rows = d->row_count + objects + d->entry_count + 3 * (size_t)d->pdo_count + 32;

    return sizeof(struct terminal_type) + d->text_used +
           d->pdo_count * (sizeof(struct sii_pdo) + sizeof(struct terminal_pdo)) +
           d->entry_count * (sizeof(struct sii_entry) + sizeof(struct terminal_entry)) +
           objects * sizeof(struct od_object) + rows * sizeof(struct od_entry) +
           (d->input_count + d->output_count) * sizeof(struct terminal_channel) +
           d->row_count * sizeof(struct terminal_range) + 16 * ALIGN;
}

static uint32_t cell(struct build *b, size_t bytes, size_t align)
{
    uint32_t at = (uint32_t)((b->instance + align - 1) / align * align);

    b->instance = at + (uint32_t)bytes;
    return at;
}

/* Texts move over as they are: same offsets, another block. */
static const char *moved(const struct build *b, const char *block, const char *text)
{
    const char *from = b->d->text;

    return text && text >= from && text < from + b->d->text_used ? block + (text - from) : text;
}

/* An entry that is in several PDOs has one cell. */
static void give_cells(struct build *b)
{
    const struct description *d = b->d;

    for (unsigned i = 0; i < d->entry_count; i++) {
        const struct desc_entry *e = &d->entry[i];

        b->cells[i] = TERMINAL_NO_CELL;
        for (unsigned k = 0; e->index && k < i; k++) {
            if (d->entry[k].index == e->index && d->entry[k].subindex == e->subindex)
                b->cells[i] = b->cells[k];
        }
        if (e->index && b->cells[i] == TERMINAL_NO_CELL)
            b->cells[i] = cell(b, 8, 8);
    }
}

static uint32_t cell_of(const struct build *b, uint16_t index, uint8_t subindex)
{
    for (unsigned i = 0; i < b->d->entry_count; i++) {
        const struct desc_entry *e = &b->d->entry[i];

        if (index && e->index == index && e->subindex == subindex)
            return b->cells[i];
    }
    return TERMINAL_NO_CELL;
}

static void build_pdos(struct build *b)
{
    const struct description *d = b->d;
    struct terminal_entry *entries = take(b, d->entry_count, sizeof *entries);
    struct sii_entry *sii_entries = take(b, d->entry_count, sizeof *sii_entries);
    struct terminal_pdo *pdos = take(b, d->pdo_count, sizeof *pdos);
    struct sii_pdo *sii = take(b, d->pdo_count, sizeof *sii);

    for (unsigned i = 0; i < d->entry_count; i++) {
        const struct desc_entry *e = &d->entry[i];

        entries[i] =
            (struct terminal_entry){ b->cells[i], e->bits, (uint8_t)od_type_bytes(e->type) };
        sii_entries[i] = (struct sii_entry){ e->index, e->subindex, e->type, e->bits };
    }
    for (unsigned direction = PDO_RX; direction <= PDO_TX; direction++) {
        struct terminal_direction *to = &b->type->direction[direction];
        uint8_t *count = direction == PDO_RX ? &b->type->sii.rx_count : &b->type->sii.tx_count;

        *(direction == PDO_RX ? &b->type->sii.rx : &b->type->sii.tx) = sii;
        to->pdos = pdos;
        for (unsigned i = 0; i < d->pdo_count; i++) {
            const struct desc_pdo *p = &d->pdo[i];

            if (p->direction != direction)
                continue;
            *pdos++ = (struct terminal_pdo){ p->index, p->sm != DESC_NO_SM, entries + p->first,
                                             p->count };
            *sii++ = (struct sii_pdo){ p->index, p->sm, p->flags, sii_entries + p->first,
                                       (uint8_t)p->count };
            to->pdo_count++;
            to->entry_count += p->count;
            ++*count;
        }
    }
}

/* Room of a process image: up to the next sync manager, divided among three buffers. */
static uint16_t room(const struct description *d, int n)
{
    unsigned end = SLAVE_MEMORY;

    if (n < 0)
        return 0;
    for (unsigned i = 0; i < d->sm_count; i++) {
        if (d->sm[i].start > d->sm[n].start && d->sm[i].start < end)
            end = d->sm[i].start;
    }
    end -= d->sm[n].start;
    return (uint16_t)(end < 3 ? 1 : end / 3);
}

static uint16_t all_bytes(const struct description *d, enum pdo_direction direction)
{
    unsigned bits = 0;

    for (unsigned i = 0; i < d->pdo_count; i++) {
        for (unsigned k = d->pdo[i].first; k < d->pdo[i].first + d->pdo[i].count; k++)
            bits += d->pdo[i].direction == direction ? d->entry[k].bits : 0;
    }
    return (uint16_t)((bits + 7) / 8);
}

static void build_directions(struct build *b)
{
    const struct description *d = b->d;

    for (unsigned direction = PDO_RX; direction <= PDO_TX; direction++) {
        struct terminal_direction *to = &b->type->direction[direction];

        to->max_bytes =
            room(d, description_sm(d, direction == PDO_RX ? SII_SM_OUTPUTS : SII_SM_INPUTS));
        if (to->max_bytes > all_bytes(d, (enum pdo_direction)direction))
            to->max_bytes = all_bytes(d, (enum pdo_direction)direction);
        to->moves = cell(b, to->entry_count * sizeof(struct terminal_move), 8);
    }
    b->type->held = cell(b, d->input_count * sizeof(struct terminal_input), 8);
    b->type->image = cell(b, b->type->direction[PDO_TX].max_bytes, 8);
}

static void build_channels(struct build *b, const struct desc_channel *from, unsigned count,
                           enum pdo_direction direction, const struct terminal_channel **out)
{
    struct terminal_channel *to = take(b, count, sizeof *to);

    *out = to;
    for (unsigned i = 0; i < count; i++, to++, from++) {
        const struct desc_entry *e =
            description_entry(b->d, direction, from->value.index, from->value.subindex);

        to->cell = cell_of(b, e->index, e->subindex);
        to->bytes = (uint8_t)od_type_bytes(e->type);
        to->digital = e->bits == 1;
        to->safe = from->safe;
        description_limits(e->type, &to->least, &to->most);
        for (unsigned f = 0; f < TERMINAL_FLAGS; f++)
            to->flag[f] = cell_of(b, from->flag[f].index, from->flag[f].subindex);
    }
}

static struct od_object *add_object(struct build *b, uint16_t index, uint8_t code, uint8_t type,
                                    const char *name)
{
    struct od_object *object = &b->objects[b->object_count++];

    *object = (struct od_object){ index, code, type, 0, b->rows + b->row_count, name };
    return object;
}

static struct od_entry *add_row(struct build *b, struct od_object *object, unsigned subindex,
                                uint8_t type, int64_t value, const char *name)
{
    struct od_entry *row = &b->rows[b->row_count++];

    *row = (struct od_entry){
        (uint8_t)subindex, (uint8_t)subindex, type, OD_RO, OD_CONST, value, name, NULL
    };
    object->count++;
    return row;
}

static void add_count(struct build *b, struct od_object *object, unsigned count)
{
    add_row(b, object, 0, OD_U8, (int64_t)count, "number of entries");
}

static int64_t safe_of(const struct build *b, uint16_t index, uint8_t subindex, int64_t otherwise)
{
    for (unsigned i = 0; i < b->d->output_count; i++) {
        const struct desc_channel *c = &b->d->output[i];

        if (c->value.index == index && c->value.subindex == subindex)
            return c->safe;
    }
    return otherwise;
}

static void add_described_row(struct build *b, struct od_object *object,
                              const struct desc_row *from, const char *texts)
{
    struct od_entry *row =
        add_row(b, object, from->subindex, from->type, from->initial, moved(b, texts, from->name));
    uint16_t index = object->index;

    row->access = from->access;
    row->text = moved(b, texts, from->text);
    if (description_entry(b->d, PDO_RX, index, from->subindex))
        row->access |= OD_RX_MAP;
    if (description_entry(b->d, PDO_TX, index, from->subindex))
        row->access |= OD_TX_MAP;
    row->initial = safe_of(b, index, from->subindex, from->initial);
    if (row->access & (OD_RX_MAP | OD_TX_MAP))
        row->offset = cell_of(b, index, from->subindex);
    else if (from->type != OD_STRING && (from->access & (OD_RW & ~OD_RO)))
        row->offset = cell(b, 8, 8);
}

static void add_described(struct build *b, const char *texts, struct terminal_range *ranges)
{
    const struct description *d = b->d;

    for (unsigned i = 0; i < d->object_count; i++) {
        const struct desc_object *from = &d->object[i];
        const struct desc_row *rows = &d->row[from->first];
        struct od_object *object = add_object(
            b, from->index, from->code, rows[from->count - 1].type, moved(b, texts, from->name));

        if (rows[0].subindex)
            add_count(b, object, rows[from->count - 1].subindex);
        for (unsigned k = 0; k < from->count; k++) {
            add_described_row(b, object, &rows[k], texts);
            if (rows[k].ranged)
                ranges[b->type->range_count++] =
                    (struct terminal_range){ from->index, rows[k].subindex, rows[k].least,
                                             rows[k].most };
        }
    }
}

static bool described(const struct description *d, uint16_t index)
{
    for (unsigned i = 0; i < d->object_count; i++) {
        if (d->object[i].index == index)
            return true;
    }
    return false;
}

static void add_identity(struct build *b)
{
    static const char *const names[] = { "vendor id", "product code", "revision", "serial number" };
    struct od_object *object;

    if (!described(b->d, 0x1000))
        add_row(b, add_object(b, 0x1000, OD_VAR, OD_U32, "device type"), 0, OD_U32, 0,
                "device type");
    if (!described(b->d, 0x1008))
        add_row(b, add_object(b, 0x1008, OD_VAR, OD_STRING, "device name"), 0, OD_STRING, 0,
                "device name")
            ->text = b->type->sii.name;
    object = add_object(b, 0x1018, OD_RECORD, OD_IDENTITY, "identity");
    add_count(b, object, 4);
    b->type->identity = cell(b, 16, 4);
    for (unsigned i = 0; i < 4; i++)
        add_row(b, object, i + 1, OD_U32, 0, names[i])->offset = b->type->identity + 4 * i;
}

static void add_mapping(struct build *b, const char *texts)
{
    const struct description *d = b->d;

    for (unsigned i = 0; i < d->pdo_count; i++) {
        const struct desc_pdo *pdo = &d->pdo[i];
        const char *name = moved(b, texts, pdo->name);
        struct od_object *object = add_object(b, pdo->index, OD_RECORD, OD_PDO_MAPPING, name);

        add_count(b, object, pdo->count);
        for (unsigned k = 0; k < pdo->count; k++) {
            const struct desc_entry *e = &d->entry[pdo->first + k];

            add_row(b, object, k + 1, OD_U32,
                    (int64_t)((uint32_t)e->index << 16 | (uint32_t)e->subindex << 8 | e->bits),
                    "entry");
        }
    }
}

static void add_assignment(struct build *b, unsigned sm, struct terminal_direction *direction)
{
    struct od_object *object =
        add_object(b, (uint16_t)(0x1c10 + sm), OD_ARRAY, OD_U16, "PDO assignment");
    struct od_entry *count, *row;
    unsigned assigned = 0;

    direction->assign_index = object->index;
    direction->assign_count = cell(b, 1, 1);
    direction->assign_pdos = cell(b, 2 * direction->pdo_count, 2);
    count = add_row(b, object, 0, OD_U8, 0, "number of PDOs");
    count->access = OD_RW_PREOP;
    count->offset = direction->assign_count;
    for (unsigned i = 0; i < direction->pdo_count; i++) {
        row = add_row(b, object, i + 1, OD_U16, 0, "PDO");
        row->access = OD_RW_PREOP;
        row->offset = direction->assign_pdos + 2 * i;
    }
    for (unsigned i = 0; i < direction->pdo_count; i++) {
        if (direction->pdos[i].assigned)
            count[++assigned].initial = direction->pdos[i].index;
    }
    count->initial = assigned;
}

static void add_managers(struct build *b)
{
    const struct description *d = b->d;
    struct od_object *object = add_object(b, 0x1c00, OD_ARRAY, OD_U8, "sync manager type");

    add_count(b, object, d->sm_count);
    for (unsigned n = 0; n < d->sm_count; n++)
        add_row(b, object, n + 1, OD_U8, d->sm[n].type, "type");
    for (unsigned n = 0; n < d->sm_count; n++) {
        if (d->sm[n].type == SII_SM_OUTPUTS)
            add_assignment(b, n, &b->type->direction[PDO_RX]);
        else if (d->sm[n].type == SII_SM_INPUTS)
            add_assignment(b, n, &b->type->direction[PDO_TX]);
    }
}

static int by_index(const void *a, const void *b)
{
    const struct od_object *x = a, *y = b;

    return (x->index > y->index) - (x->index < y->index);
}

static void build_dictionary(struct build *b, const char *texts)
{
    const struct description *d = b->d;
    size_t objects = d->object_count + d->pdo_count + EXTRA_OBJECTS;
    size_t rows = d->row_count + objects + d->entry_count + 3 * (size_t)d->pdo_count + 32;
    struct terminal_range *ranges = take(b, d->row_count, sizeof *ranges);

    b->objects = take(b, objects, sizeof *b->objects);
    b->rows = take(b, rows, sizeof *b->rows);
    b->type->ranges = ranges;
    add_described(b, texts, ranges);
    add_identity(b);
    add_mapping(b, texts);
    add_managers(b);
    qsort(b->objects, b->object_count, sizeof *b->objects, by_index);
    b->type->od.objects = b->objects;
    b->type->od.count = b->object_count;
    b->type->type.od = &b->type->od;
}

static void build_sii(struct build *b, const char *texts)
{
    const struct description *d = b->d;
    struct sii_info *sii = &b->type->sii;
    int out = description_sm(d, SII_SM_MBX_OUT), in = description_sm(d, SII_SM_MBX_IN);

    *sii = (struct sii_info){ .vendor = d->vendor,
                              .product = d->product,
                              .revision = d->revision,
                              .pdi_control = d->pdi_control,
                              .pdi_config = d->pdi_config,
                              .sync_pulse = d->sync_pulse,
                              .pdi_config_ext = d->pdi_config_ext,
                              .name = moved(b, texts, d->name),
                              .order = moved(b, texts, d->order),
                              .group = moved(b, texts, d->group),
                              .coe_details = d->coe_details,
                              .ebus_current = d->current,
                              .ports = d->ports,
                              .dc_assign = d->dc_assign,
                              .sm_count = (uint8_t)d->sm_count,
                              .fmmu_count = (uint8_t)d->fmmu_count };
    memcpy(sii->fmmu, d->fmmu, sizeof sii->fmmu);
    for (unsigned n = 0; n < d->sm_count; n++)
        sii->sm[n] = (struct sii_sm){ d->sm[n].start, d->sm[n].length, d->sm[n].control,
                                      d->sm[n].enable, d->sm[n].type };
    if (out >= 0) {
        sii->mailbox = (struct sii_mailbox){ d->sm[out].start, d->sm[out].length, d->sm[in].start,
                                             d->sm[in].length };
        sii->protocols = description_coe(d) ? 0x0004 : 0;
    }
}

static int check_sii(const struct description *d, const struct terminal_type *type,
                     char why[SCAN_WHY])
{
    uint8_t image[SII_SIZE];

    if (sii_build(&type->sii, 1, 0, image))
        return 0;
    return why_at(why, d->file, d->place,
                  "names and PDOs do not fit into the SII; expected at most %d bytes", SII_SIZE);
}

int description_build(const struct description *d, struct terminal_type **out, char why[SCAN_WHY])
{
    struct build b = { .d = d, .instance = sizeof(struct terminal), .size = arena_size(d) };
    struct device_type *device;
    char *texts;
    int error = description_check(d, why);

    *out = NULL;
    if (error)
        return error;
    b.memory = calloc(1, b.size);
    b.cells = calloc(d->entry_count + 1u, sizeof *b.cells);
    if (!b.memory || !b.cells) {
        free(b.memory);
        free(b.cells);
        snprintf(why, SCAN_WHY, "%.200s: no memory", d->file);
        return -ENOMEM;
    }
    b.type = take(&b, 1, sizeof *b.type);
    texts = take(&b, 1, d->text_used);
    memcpy(texts, d->text, d->text_used);
    give_cells(&b);
    build_sii(&b, texts);
    build_pdos(&b);
    build_directions(&b);
    build_channels(&b, d->input, d->input_count, PDO_TX, &b.type->inputs);
    build_channels(&b, d->output, d->output_count, PDO_RX, &b.type->outputs);
    b.type->input_count = d->input_count;
    b.type->output_count = d->output_count;
    b.type->hold = d->hold;
    if (description_coe(d))
        build_dictionary(&b, texts);
    device = &b.type->type;
    device->name = moved(&b, texts, d->type);
    device->description = moved(&b, texts, d->about);
    device->al_emulation = d->emulation;
    device->dc = d->dc != DESC_DC_NONE;
    device->dc_delay_only = d->dc == DESC_DC_DELAY;
    device->size = (b.instance + 7u) / 8 * 8;
    terminal_type_wire(b.type);
    free(b.cells);
    error = check_sii(d, b.type, why);
    if (error)
        free(b.memory);
    else
        *out = b.type;
    return error;
}
