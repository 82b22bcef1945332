/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The object dictionary of ESI: types by name, defaults beside them. */
#include "bus/esi_parts.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static xmlNode *data_type(const struct esi *esi, const char *name)
{
    char text[ESI_TEXT];

    for (xmlNode *t = esi_child(esi->types, "DataType"); t; t = esi_next(t, "DataType")) {
        if (strcmp(esi_content(esi_child(t, "Name"), text), name) == 0)
            return t;
    }
    return NULL;
}

static uint16_t access_of(xmlNode *node, uint16_t otherwise)
{
    xmlNode *access = esi_child(esi_child(node, "Flags"), "Access");
    char text[ESI_TEXT];

    if (!access)
        return otherwise;
    esi_content(access, text);
    if (strcmp(text, "rw") == 0)
        return OD_RW;
    return strcmp(text, "wo") == 0 ? OD_RW & ~OD_RO : OD_RO;
}

/* DefaultData are bytes in wire order, DefaultValue a number, DefaultString a text. */
static int read_default(struct esi *esi, xmlNode *info, struct desc_row *row)
{
    xmlNode *data = esi_child(info, "DefaultData"), *value = esi_child(info, "DefaultValue");
    xmlNode *string = esi_child(info, "DefaultString");
    uint8_t bytes[ESI_TEXT / 2];
    char text[ESI_TEXT];
    int64_t least, most;
    uint64_t raw = 0;
    uint32_t small;
    int count;

    row->text = "";
    if (row->type == OD_STRING && string)
        return esi_keep(esi, string, esi_content(string, text), &row->text);
    if (data) {
        count = esi_bytes_of(esi_content(data, text), bytes, sizeof bytes);
        if (count < 0 || (row->type != OD_STRING && count > 8))
            return esi_fail(esi, data, "<DefaultData> is \"%.40s\"; expected bytes in hexadecimal",
                            text);
        if (row->type == OD_STRING) {
            snprintf(text, sizeof text, "%.*s", count, (const char *)bytes);
            for (char *c = text; *c; c++) {
                if ((unsigned char)*c < 0x20)
                    *c = ' ';
            }
            return esi_keep(esi, data, text, &row->text);
        }
        while (count--)
            raw = raw << 8 | bytes[count];
    } else if (value && row->type != OD_STRING) {
        if (esi_need(esi, value, esi_content(value, text), "a default value", UINT32_MAX, &small))
            return -EINVAL;
        raw = small;
    }
    row->initial = (int64_t)raw;
    description_limits(row->type, &least, &most);
    if (od_type_signed(row->type) && row->initial > most && od_type_bits(row->type) < 64)
        row->initial -= (int64_t)1 << od_type_bits(row->type);
    if (row->initial < least || row->initial > most)
        return esi_fail(esi, data ? data : value,
                        "a default value that its type cannot hold; expected "
                        "%u bits",
                        od_type_bits(row->type));
    return 0;
}

/* Types that a terminal cannot hold are left out. */
static int add_row(struct esi *esi, xmlNode *node, xmlNode *info, uint16_t index, uint32_t subindex,
                   const char *type, uint32_t bits, uint16_t access, const char *object)
{
    struct esi_row *to = &esi->rows[esi->row_count];
    xmlNode *definition = data_type(esi, type);
    char base[ESI_TEXT];
    uint8_t kind;

    /* An enumeration or a bit field says what it is made of. */
    if (definition && esi_child(definition, "BaseType"))
        type = esi_content(esi_child(definition, "BaseType"), base);
    kind = esi_type_of(type, bits);
    if (!kind || subindex > 255)
        return 0;
    if (esi->row_count == DESC_ROWS)
        return esi_fail(esi, node, "too many objects; expected at most %d entries", DESC_ROWS);
    *to = (struct esi_row){ .index = index,
                            .object = object,
                            .row = { .place = esi_place_of(node),
                                     .subindex = (uint8_t)subindex,
                                     .type = kind,
                                     .access = kind == OD_STRING ? OD_RO : access } };
    esi->row_count++;
    if (esi_keep_name(esi, node, ESI_TEXT - 1, &to->row.name))
        return -EINVAL;
    return read_default(esi, info, &to->row);
}

/* An array inside a type: one subindex an element, all alike. */
static int add_array(struct esi *esi, xmlNode *item, xmlNode *array, xmlNode **info, uint16_t index,
                     uint16_t access, const char *object)
{
    xmlNode *bounds = esi_child(array, "ArrayInfo");
    uint32_t first, count, bits = 0;
    char type[ESI_TEXT];

    if (esi_need_child(esi, bounds, "LBound", "the first subindex", 255, &first) ||
        esi_need_child(esi, bounds, "Elements", "a number of elements", 255, &count) ||
        esi_need_child(esi, array, "BitSize", "a length in bits", UINT32_MAX, &bits))
        return -EINVAL;
    esi_content(esi_child(array, "BaseType"), type);
    for (uint32_t i = 0; i < count; i++) {
        uint16_t may = access_of(*info, access);

        if (add_row(esi, *info && esi_child(*info, "Name") ? *info : item, esi_child(*info, "Info"),
                    index, first + i, type, bits / count, may, object))
            return -EINVAL;
        if (*info)
            *info = esi_next(*info, "SubItem");
    }
    return 0;
}

static int add_record(struct esi *esi, xmlNode *object, xmlNode *type, uint16_t index,
                      const char *name)
{
    xmlNode *info = esi_child(esi_child(object, "Info"), "SubItem");
    uint16_t otherwise = access_of(object, OD_RO);

    for (xmlNode *item = esi_child(type, "SubItem"); item; item = esi_next(item, "SubItem")) {
        uint32_t subindex = 0, bits;
        char item_type[ESI_TEXT];
        xmlNode *inner = data_type(esi, esi_content(esi_child(item, "Type"), item_type));
        uint16_t access = access_of(item, otherwise);

        if (inner && esi_child(inner, "ArrayInfo")) {
            if (add_array(esi, item, inner, &info, index, access, name))
                return -EINVAL;
            continue;
        }
        if ((esi_child(item, "SubIdx") &&
             esi_need_child(esi, item, "SubIdx", "a subindex", 255, &subindex)) ||
            esi_need_child(esi, item, "BitSize", "a length in bits", UINT32_MAX, &bits) ||
            add_row(esi, item, esi_child(info, "Info"), index, subindex, item_type, bits, access,
                    name))
            return -EINVAL;
        if (info)
            info = esi_next(info, "SubItem");
    }
    return 0;
}

static int read_object(struct esi *esi, xmlNode *object)
{
    uint32_t index, bits;
    char text[ESI_TEXT];
    const char *name;
    xmlNode *type;

    if (esi_need_child(esi, object, "Index", "an index", 0xffff, &index) ||
        esi_need_child(esi, object, "BitSize", "a length in bits", UINT32_MAX, &bits))
        return -EINVAL;
    if (!index || description_generates(esi->d, (uint16_t)index))
        return 0;
    if (esi_keep_name(esi, object, ESI_TEXT - 1, &name))
        return -EINVAL;
    type = data_type(esi, esi_content(esi_child(object, "Type"), text));
    if (type && esi_child(type, "SubItem"))
        return add_record(esi, object, type, (uint16_t)index, name);
    return add_row(esi, object, esi_child(object, "Info"), (uint16_t)index, 0, text, bits,
                   access_of(object, OD_RO), name);
}

static bool has_row(const struct esi *esi, uint16_t index, uint8_t subindex)
{
    for (unsigned i = 0; i < esi->row_count; i++) {
        if (esi->rows[i].index == index && esi->rows[i].row.subindex == subindex)
            return true;
    }
    return false;
}

/* Many files have PDOs and no dictionary: what is mapped exists. */
static int add_mapped(struct esi *esi, xmlNode *device)
{
    for (unsigned i = 0; i < esi->d->entry_count; i++) {
        const struct desc_entry *e = &esi->d->entry[i];

        if (!e->index || has_row(esi, e->index, e->subindex))
            continue;
        if (esi->row_count == DESC_ROWS)
            return esi_fail(esi, device, "too many objects; expected at most %d entries",
                            DESC_ROWS);
        esi->rows[esi->row_count++] = (struct esi_row){ .index = e->index,
                                                        .object = e->name,
                                                        .row = { .place = e->place,
                                                                 .subindex = e->subindex,
                                                                 .type = e->type,
                                                                 .access = OD_RO,
                                                                 .name = e->name,
                                                                 .text = "" } };
    }
    return 0;
}

static int by_place(const void *a, const void *b)
{
    const struct esi_row *x = a, *y = b;

    if (x->index != y->index)
        return x->index < y->index ? -1 : 1;
    return (x->row.subindex > y->row.subindex) - (x->row.subindex < y->row.subindex);
}

static int gather_objects(struct esi *esi, xmlNode *device)
{
    struct description *d = esi->d;
    struct desc_object *object = NULL;

    qsort(esi->rows, esi->row_count, sizeof *esi->rows, by_place);
    for (unsigned i = 0; i < esi->row_count; i++) {
        const struct esi_row *row = &esi->rows[i];

        if (!object || object->index != row->index) {
            if (d->object_count == DESC_OBJECTS)
                return esi_fail(esi, device, "too many objects; expected at most %d", DESC_OBJECTS);
            object = &d->object[d->object_count++];
            *object = (struct desc_object){ .place = row->row.place,
                                            .index = row->index,
                                            .code = row->row.subindex ? OD_RECORD : OD_VAR,
                                            .first = d->row_count,
                                            .name = row->object };
        } else if (d->row[d->row_count - 1].subindex == row->row.subindex) {
            continue;
        } else {
            object->code = OD_RECORD;
        }
        d->row[d->row_count++] = row->row;
        object->count++;
    }
    return 0;
}

int esi_read_dictionary(struct esi *esi, xmlNode *device)
{
    static const char *const path[] = { "Profile", "Dictionary", NULL };
    xmlNode *dictionary = esi_down(device, path);

    if (!description_coe(esi->d))
        return 0;
    esi->types = esi_child(dictionary, "DataTypes");
    for (xmlNode *o = esi_child(esi_child(dictionary, "Objects"), "Object"); o;
         o = esi_next(o, "Object")) {
        if (read_object(esi, o))
            return -EINVAL;
    }
    if (add_mapped(esi, device))
        return -EINVAL;
    return gather_objects(esi, device);
}
