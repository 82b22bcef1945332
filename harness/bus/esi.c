/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * ESI (EtherCAT Slave Information, XML) into descriptions. libxml2 parses; nothing is fetched, no
 * entity of the file is expanded. Read is what a terminal has: identity, mailbox, sync managers,
 * FMMUs, PDOs, distributed clock, EEPROM configuration, dictionary. Modules and slots are not.
 */
#include "bus/description.h"
#include "bus/library.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include <libxml/parser.h>
#include <libxml/tree.h>

enum { ESI_TEXT = 256 };

/* A row of the dictionary before its place is known: files are not always sorted. */
struct esi_row {
    uint16_t index;
    const char *object;
    struct desc_row row;
};

struct esi {
    const char *file;
    char *why;
    xmlNode *types; /* DataTypes of the device being read, may be NULL */
    struct description *d;
    struct esi_row *rows; /* DESC_ROWS */
    unsigned row_count;
    uint32_t vendor;
};

static struct place place_of(xmlNode *node)
{
    long line = xmlGetLineNo(node);

    return (struct place){ line > 0 ? (unsigned)line : 0, 0 };
}

static int fail(const struct esi *esi, xmlNode *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static int fail(const struct esi *esi, xmlNode *node, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    why_at_v(esi->why, esi->file, place_of(node), format, arguments);
    va_end(arguments);
    return -EINVAL;
}

static bool is(const xmlNode *node, const char *name)
{
    return node->type == XML_ELEMENT_NODE && strcmp((const char *)node->name, name) == 0;
}

static xmlNode *from(xmlNode *node, const char *name)
{
    while (node && !is(node, name))
        node = node->next;
    return node;
}

static xmlNode *child(xmlNode *node, const char *name)
{
    return node ? from(node->children, name) : NULL;
}

static xmlNode *next(xmlNode *node, const char *name)
{
    return from(node->next, name);
}

static xmlNode *down(xmlNode *node, const char *const *path)
{
    for (; node && *path; path++)
        node = child(node, *path);
    return node;
}

/* Without the blanks around it, cut at ESI_TEXT; control characters become blanks. */
static const char *clean(xmlChar *content, char to[ESI_TEXT])
{
    const char *text = content ? (const char *)content : "";
    size_t length;

    while (*text && strchr(" \t\r\n", *text))
        text++;
    length = strlen(text);
    if (length >= ESI_TEXT)
        length = ESI_TEXT - 1;
    while (length && strchr(" \t\r\n", text[length - 1]))
        length--;
    memcpy(to, text, length);
    to[length] = '\0';
    for (char *c = to; *c; c++) {
        if ((unsigned char)*c < 0x20)
            *c = ' ';
    }
    xmlFree(content);
    return to;
}

static const char *content(xmlNode *node, char to[ESI_TEXT])
{
    return clean(node ? xmlNodeGetContent(node) : NULL, to);
}

static const char *attribute(xmlNode *node, const char *name, char to[ESI_TEXT])
{
    return clean(xmlGetNoNsProp(node, (const xmlChar *)name), to);
}

static bool flag(xmlNode *node, const char *name)
{
    char text[ESI_TEXT];

    attribute(node, name, text);
    return strcmp(text, "1") == 0 || strcmp(text, "true") == 0;
}

/* "#x1A00", "0x1A00" or decimal. */
static bool number(const char *text, uint32_t *value)
{
    bool hexadecimal = strncmp(text, "#x", 2) == 0 || strncmp(text, "0x", 2) == 0;
    const char *digits = text + (hexadecimal ? 2 : 0);
    unsigned long long read;
    char *end;

    if (!*digits || !strchr(hexadecimal ? "0123456789abcdefABCDEF" : "0123456789", *digits))
        return false;
    errno = 0;
    read = strtoull(digits, &end, hexadecimal ? 16 : 10);
    *value = (uint32_t)read;
    return !errno && !*end && read <= UINT32_MAX;
}

static int need(const struct esi *esi, xmlNode *node, const char *text, const char *what,
                uint32_t most, uint32_t *value)
{
    if (!number(text, value))
        return fail(esi, node, "\"%.40s\" is not a number; expected %s, #x and hexadecimal digits",
                    text, what);
    if (*value > most)
        return fail(esi, node, "%.40s is out of range; expected %s up to 0x%X", text, what, most);
    return 0;
}

static int need_child(const struct esi *esi, xmlNode *node, const char *name, const char *what,
                      uint32_t most, uint32_t *value)
{
    xmlNode *found = child(node, name);
    char text[ESI_TEXT];

    if (!found)
        return fail(esi, node, "<%s> without <%s>; expected %s", (const char *)node->name, name,
                    what);
    return need(esi, found, content(found, text), what, most, value);
}

/* Absent: stays as it is. */
static int may_attribute(const struct esi *esi, xmlNode *node, const char *name, const char *what,
                         uint32_t most, uint32_t *value)
{
    char text[ESI_TEXT];

    if (!*attribute(node, name, text))
        return 0;
    return need(esi, node, text, what, most, value);
}

static int keep(const struct esi *esi, xmlNode *node, const char *text, const char **to)
{
    *to = description_text(esi->d, text, strlen(text));
    return *to ? 0 : fail(esi, node, "too much text; expected at most %d characters", DESC_TEXT);
}

/* The English one of several names, or the first. */
static xmlNode *name_of(xmlNode *node)
{
    xmlNode *first = child(node, "Name");
    char text[ESI_TEXT];

    for (xmlNode *n = first; n; n = next(n, "Name")) {
        if (strcmp(attribute(n, "LcId", text), "1033") == 0)
            return n;
    }
    return first;
}

static int keep_name(const struct esi *esi, xmlNode *node, size_t most, const char **to)
{
    char text[ESI_TEXT];

    content(name_of(node), text);
    if (strlen(text) > most)
        text[most] = '\0';
    return keep(esi, node, text, to);
}

/* The name decides when it fits the length, else the length does: enumerations and bit fields have
 * names of their own. 0: nothing fits. */
static uint8_t type_of(const char *name, uint32_t bits)
{
    static const struct {
        const char *name;
        uint8_t type;
    } types[] = {
        { "BOOL", OD_BOOL }, { "BIT", OD_BOOL },  { "SINT", OD_I8 },     { "INT", OD_I16 },
        { "DINT", OD_I32 },  { "LINT", OD_I64 },  { "USINT", OD_U8 },    { "UINT", OD_U16 },
        { "UDINT", OD_U32 }, { "ULINT", OD_U64 }, { "REAL", OD_REAL32 }, { "LREAL", OD_REAL64 },
    };

    if (strncmp(name, "STRING", 6) == 0)
        return OD_STRING;
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        if (strcmp(types[i].name, name) == 0 && (!bits || od_type_bits(types[i].type) == bits))
            return types[i].type;
    }
    if (bits >= 1 && bits <= 7)
        return (uint8_t)(OD_BIT1 + bits - 1);
    return bits == 8 ? OD_U8 : bits == 16 ? OD_U16 : bits == 32 ? OD_U32 : bits == 64 ? OD_U64 : 0;
}

static int read_sm(struct esi *esi, xmlNode *node)
{
    static const struct {
        const char *text;
        uint8_t type, control;
    } kinds[] = { { "MBoxOut", SII_SM_MBX_OUT, 0x26 },
                  { "MBoxIn", SII_SM_MBX_IN, 0x22 },
                  { "Outputs", SII_SM_OUTPUTS, 0x64 },
                  { "Inputs", SII_SM_INPUTS, 0x20 },
                  { "", SII_SM_UNUSED, 0 } };
    struct description *d = esi->d;
    struct desc_sm *sm = &d->sm[d->sm_count];
    uint32_t start = 0, length = 0, control, enable = 1;
    char text[ESI_TEXT];
    size_t k = 0;

    if (d->sm_count == SII_MAX_SM)
        return fail(esi, node, "too many <Sm>; expected at most %d", SII_MAX_SM);
    content(node, text);
    while (strcmp(kinds[k].text, text) != 0) {
        if (++k == sizeof kinds / sizeof *kinds)
            return fail(esi, node, "<Sm> is \"%.40s\"; expected MBoxOut, MBoxIn, Outputs or Inputs",
                        text);
    }
    control = kinds[k].control;
    if (may_attribute(esi, node, "StartAddress", "an address", 0xffff, &start) ||
        may_attribute(esi, node, "DefaultSize", "a length", 0xffff, &length) ||
        may_attribute(esi, node, "ControlByte", "a control byte", 0xff, &control) ||
        may_attribute(esi, node, "Enable", "an enable byte", 0x0f, &enable))
        return -EINVAL;
    if (flag(node, "Virtual"))
        enable |= 4;
    if (flag(node, "OpOnly"))
        enable |= 8;
    *sm = (struct desc_sm){ place_of(node),   (uint16_t)start, (uint16_t)length,
                            (uint8_t)control, (uint8_t)enable, kinds[k].type };
    d->sm_count++;
    return 0;
}

static int read_fmmu(struct esi *esi, xmlNode *node)
{
    static const char *const uses[] = { "", "Outputs", "Inputs", "MBoxState" };
    struct description *d = esi->d;
    char text[ESI_TEXT];

    content(node, text);
    if (d->fmmu_count == SII_MAX_FMMU)
        return fail(esi, node, "too many <Fmmu>; expected at most %d", SII_MAX_FMMU);
    for (uint8_t i = 0; i < 4; i++) {
        if (strcmp(text, uses[i]) != 0)
            continue;
        d->fmmu[d->fmmu_count++] = i;
        return 0;
    }
    return fail(esi, node, "<Fmmu> is \"%.40s\"; expected Outputs, Inputs or MBoxState", text);
}

static int read_entry(struct esi *esi, xmlNode *node, struct desc_pdo *pdo)
{
    struct description *d = esi->d;
    struct desc_entry *e = &d->entry[d->entry_count];
    uint32_t index, subindex = 0, bits;
    char text[ESI_TEXT];

    if (d->entry_count == DESC_ENTRIES)
        return fail(esi, node, "too many <Entry>; expected at most %d", DESC_ENTRIES);
    if (need_child(esi, node, "Index", "an index", 0xffff, &index) ||
        need_child(esi, node, "BitLen", "a length in bits", 255, &bits))
        return -EINVAL;
    if (index && child(node, "SubIndex") &&
        need_child(esi, node, "SubIndex", "a subindex", 255, &subindex))
        return -EINVAL;
    *e = (struct desc_entry){ .place = place_of(node),
                              .index = (uint16_t)index,
                              .bits = (uint8_t)bits,
                              .subindex = (uint8_t)subindex,
                              .name = "" };
    if (index) {
        e->type = type_of(content(child(node, "DataType"), text), bits);
        if (!e->type || e->type == OD_STRING || !bits)
            return fail(esi, node, "an entry of %u bits; expected 1 to 8, 16, 32 or 64", bits);
        if (keep_name(esi, node, ESI_TEXT - 1, &e->name))
            return -EINVAL;
    } else if (!bits) {
        return fail(esi, node, "a gap of no bits; expected 1 to 255");
    }
    d->entry_count++;
    pdo->count++;
    return 0;
}

static int read_pdo(struct esi *esi, xmlNode *node)
{
    struct description *d = esi->d;
    struct desc_pdo *pdo = &d->pdo[d->pdo_count];
    uint32_t index, sm = DESC_NO_SM;

    if (d->pdo_count == DESC_PDOS)
        return fail(esi, node, "too many PDOs; expected at most %d", DESC_PDOS);
    if (need_child(esi, node, "Index", "the index of the PDO", 0xffff, &index) ||
        may_attribute(esi, node, "Sm", "a sync manager", SII_MAX_SM - 1, &sm))
        return -EINVAL;
    *pdo = (struct desc_pdo){ .place = place_of(node),
                              .direction = is(node, "RxPdo") ? PDO_RX : PDO_TX,
                              .index = (uint16_t)index,
                              .sm = (uint8_t)sm,
                              .flags = (uint16_t)((flag(node, "Mandatory") ? 0x01 : 0) |
                                                  (flag(node, "Fixed") ? 0x10 : 0)),
                              .first = d->entry_count };
    if (keep_name(esi, node, ESI_TEXT - 1, &pdo->name))
        return -EINVAL;
    for (xmlNode *e = child(node, "Entry"); e; e = next(e, "Entry")) {
        if (read_entry(esi, e, pdo))
            return -EINVAL;
    }
    d->pdo_count++;
    return 0;
}

static int read_mailbox(struct esi *esi, xmlNode *device)
{
    xmlNode *coe = child(child(device, "Mailbox"), "CoE");

    if (!coe)
        return 0;
    /* PDO configuration is left out: the mapping objects of a terminal cannot be written. */
    esi->d->coe_place = place_of(coe);
    esi->d->coe_details =
        (uint8_t)(0x01 | (flag(coe, "SdoInfo") ? 0x02 : 0) | (flag(coe, "PdoAssign") ? 0x04 : 0) |
                  (flag(coe, "PdoUpload") ? 0x10 : 0) | (flag(coe, "CompleteAccess") ? 0x20 : 0));
    return 0;
}

static int read_dc(struct esi *esi, xmlNode *device)
{
    xmlNode *dc = child(device, "Dc");
    uint32_t assign = 0;

    if (!dc)
        return 0;
    esi->d->dc = DESC_DC_FULL;
    for (xmlNode *m = child(dc, "OpMode"); m && !assign; m = next(m, "OpMode")) {
        if (child(m, "AssignActivate") &&
            need_child(esi, m, "AssignActivate", "AssignActivate", 0xffff, &assign))
            return -EINVAL;
    }
    esi->d->dc_assign = (uint16_t)assign;
    return 0;
}

/* Bytes from hexadecimal digits; -1 when they are none, or too many. */
static int bytes_of(const char *text, uint8_t *bytes, size_t room)
{
    size_t length = strlen(text);

    if (length % 2 || length / 2 > room || strspn(text, "0123456789abcdefABCDEF") != length)
        return -1;
    for (size_t i = 0; i < length / 2; i++) {
        char two[3] = { text[2 * i], text[2 * i + 1], '\0' };

        bytes[i] = (uint8_t)strtoul(two, NULL, 16);
    }
    return (int)(length / 2);
}

static int read_eeprom(struct esi *esi, xmlNode *device)
{
    static const char *const path[] = { "Eeprom", "ConfigData", NULL };
    xmlNode *node = down(device, path);
    struct description *d = esi->d;
    bool mailbox = description_sm(d, SII_SM_MBX_OUT) >= 0;
    uint8_t config[32] = { 0 };
    char text[ESI_TEXT];

    d->emulation = !mailbox;
    d->pdi_control = mailbox ? 0x0c08 : 0x0104;
    if (!node)
        return 0;
    if (bytes_of(content(node, text), config, sizeof config) < 2)
        return fail(esi, node, "<ConfigData> is \"%.40s\"; expected 2 to 32 bytes in hexadecimal",
                    text);
    d->pdi_control = (uint16_t)(config[0] | config[1] << 8);
    d->pdi_config = (uint16_t)(config[2] | config[3] << 8);
    d->sync_pulse = (uint16_t)(config[4] | config[5] << 8);
    d->pdi_config_ext = (uint16_t)(config[6] | config[7] << 8);
    return 0;
}

static void read_ports(struct esi *esi, xmlNode *device)
{
    char text[ESI_TEXT];
    unsigned ports = 0;

    attribute(device, "Physics", text);
    for (unsigned i = 0; i < 4 && text[i]; i++)
        ports |= (text[i] == 'Y' ? 1u : text[i] == 'K' ? 3u : text[i] == 'H' ? 4u : 0u) << (4 * i);
    if (ports)
        esi->d->ports = (uint16_t)ports;
}

/* --- dictionary ----------------------------------------------------------------------------------
 */

static xmlNode *data_type(const struct esi *esi, const char *name)
{
    char text[ESI_TEXT];

    for (xmlNode *t = child(esi->types, "DataType"); t; t = next(t, "DataType")) {
        if (strcmp(content(child(t, "Name"), text), name) == 0)
            return t;
    }
    return NULL;
}

static uint16_t access_of(xmlNode *node, uint16_t otherwise)
{
    xmlNode *access = child(child(node, "Flags"), "Access");
    char text[ESI_TEXT];

    if (!access)
        return otherwise;
    content(access, text);
    if (strcmp(text, "rw") == 0)
        return OD_RW;
    return strcmp(text, "wo") == 0 ? OD_RW & ~OD_RO : OD_RO;
}

/* DefaultData are bytes in wire order, DefaultValue a number, DefaultString a text. */
static int read_default(struct esi *esi, xmlNode *info, struct desc_row *row)
{
    xmlNode *data = child(info, "DefaultData"), *value = child(info, "DefaultValue");
    xmlNode *string = child(info, "DefaultString");
    uint8_t bytes[ESI_TEXT / 2];
    char text[ESI_TEXT];
    int64_t least, most;
    uint64_t raw = 0;
    uint32_t small;
    int count;

    row->text = "";
    if (row->type == OD_STRING && string)
        return keep(esi, string, content(string, text), &row->text);
    if (data) {
        count = bytes_of(content(data, text), bytes, sizeof bytes);
        if (count < 0 || (row->type != OD_STRING && count > 8))
            return fail(esi, data, "<DefaultData> is \"%.40s\"; expected bytes in hexadecimal",
                        text);
        if (row->type == OD_STRING) {
            snprintf(text, sizeof text, "%.*s", count, (const char *)bytes);
            for (char *c = text; *c; c++) {
                if ((unsigned char)*c < 0x20)
                    *c = ' ';
            }
            return keep(esi, data, text, &row->text);
        }
        while (count--)
            raw = raw << 8 | bytes[count];
    } else if (value && row->type != OD_STRING) {
        if (need(esi, value, content(value, text), "a default value", UINT32_MAX, &small))
            return -EINVAL;
        raw = small;
    }
    row->initial = (int64_t)raw;
    description_limits(row->type, &least, &most);
    if (od_type_signed(row->type) && row->initial > most && od_type_bits(row->type) < 64)
        row->initial -= (int64_t)1 << od_type_bits(row->type);
    if (row->initial < least || row->initial > most)
        return fail(esi, data ? data : value,
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
    if (definition && child(definition, "BaseType"))
        type = content(child(definition, "BaseType"), base);
    kind = type_of(type, bits);
    if (!kind || subindex > 255)
        return 0;
    if (esi->row_count == DESC_ROWS)
        return fail(esi, node, "too many objects; expected at most %d entries", DESC_ROWS);
    *to = (struct esi_row){ .index = index,
                            .object = object,
                            .row = { .place = place_of(node),
                                     .subindex = (uint8_t)subindex,
                                     .type = kind,
                                     .access = kind == OD_STRING ? OD_RO : access } };
    esi->row_count++;
    if (keep_name(esi, node, ESI_TEXT - 1, &to->row.name))
        return -EINVAL;
    return read_default(esi, info, &to->row);
}

/* An array inside a type: one subindex an element, all alike. */
static int add_array(struct esi *esi, xmlNode *item, xmlNode *array, xmlNode **info, uint16_t index,
                     uint16_t access, const char *object)
{
    xmlNode *bounds = child(array, "ArrayInfo");
    uint32_t first, count, bits = 0;
    char type[ESI_TEXT];

    if (need_child(esi, bounds, "LBound", "the first subindex", 255, &first) ||
        need_child(esi, bounds, "Elements", "a number of elements", 255, &count) ||
        need_child(esi, array, "BitSize", "a length in bits", UINT32_MAX, &bits))
        return -EINVAL;
    content(child(array, "BaseType"), type);
    for (uint32_t i = 0; i < count; i++) {
        uint16_t may = access_of(*info, access);

        if (add_row(esi, *info && child(*info, "Name") ? *info : item, child(*info, "Info"), index,
                    first + i, type, bits / count, may, object))
            return -EINVAL;
        if (*info)
            *info = next(*info, "SubItem");
    }
    return 0;
}

static int add_record(struct esi *esi, xmlNode *object, xmlNode *type, uint16_t index,
                      const char *name)
{
    xmlNode *info = child(child(object, "Info"), "SubItem");
    uint16_t otherwise = access_of(object, OD_RO);

    for (xmlNode *item = child(type, "SubItem"); item; item = next(item, "SubItem")) {
        uint32_t subindex = 0, bits;
        char item_type[ESI_TEXT];
        xmlNode *inner = data_type(esi, content(child(item, "Type"), item_type));
        uint16_t access = access_of(item, otherwise);

        if (inner && child(inner, "ArrayInfo")) {
            if (add_array(esi, item, inner, &info, index, access, name))
                return -EINVAL;
            continue;
        }
        if ((child(item, "SubIdx") &&
             need_child(esi, item, "SubIdx", "a subindex", 255, &subindex)) ||
            need_child(esi, item, "BitSize", "a length in bits", UINT32_MAX, &bits) ||
            add_row(esi, item, child(info, "Info"), index, subindex, item_type, bits, access, name))
            return -EINVAL;
        if (info)
            info = next(info, "SubItem");
    }
    return 0;
}

static int read_object(struct esi *esi, xmlNode *object)
{
    uint32_t index, bits;
    char text[ESI_TEXT];
    const char *name;
    xmlNode *type;

    if (need_child(esi, object, "Index", "an index", 0xffff, &index) ||
        need_child(esi, object, "BitSize", "a length in bits", UINT32_MAX, &bits))
        return -EINVAL;
    if (!index || description_generates(esi->d, (uint16_t)index))
        return 0;
    if (keep_name(esi, object, ESI_TEXT - 1, &name))
        return -EINVAL;
    type = data_type(esi, content(child(object, "Type"), text));
    if (type && child(type, "SubItem"))
        return add_record(esi, object, type, (uint16_t)index, name);
    return add_row(esi, object, child(object, "Info"), (uint16_t)index, 0, text, bits,
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
            return fail(esi, device, "too many objects; expected at most %d entries", DESC_ROWS);
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
                return fail(esi, device, "too many objects; expected at most %d", DESC_OBJECTS);
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

static int read_dictionary(struct esi *esi, xmlNode *device)
{
    static const char *const path[] = { "Profile", "Dictionary", NULL };
    xmlNode *dictionary = down(device, path);

    if (!description_coe(esi->d))
        return 0;
    esi->types = child(dictionary, "DataTypes");
    for (xmlNode *o = child(child(dictionary, "Objects"), "Object"); o; o = next(o, "Object")) {
        if (read_object(esi, o))
            return -EINVAL;
    }
    if (add_mapped(esi, device))
        return -EINVAL;
    return gather_objects(esi, device);
}

/* --- devices -------------------------------------------------------------------------------------
 */

/* Every entry that is transferred by default is a channel. */
static void add_channels(struct description *d)
{
    for (unsigned i = 0; i < d->pdo_count; i++) {
        const struct desc_pdo *pdo = &d->pdo[i];
        bool tx = pdo->direction == PDO_TX;
        struct desc_channel *channels = tx ? d->input : d->output;
        unsigned *count = tx ? &d->input_count : &d->output_count;

        for (unsigned k = pdo->first; k < pdo->first + pdo->count && pdo->sm != DESC_NO_SM; k++) {
            const struct desc_entry *e = &d->entry[k];
            unsigned n = 0;

            while (n < *count && (channels[n].value.index != e->index ||
                                  channels[n].value.subindex != e->subindex))
                n++;
            if (!e->index || n < *count || *count == DESC_CHANNELS)
                continue;
            channels[(*count)++].value = (struct desc_ref){ e->place, e->index, e->subindex };
        }
    }
}

static int read_identity(struct esi *esi, xmlNode *device, bool newest)
{
    struct description *d = esi->d;
    xmlNode *type = child(device, "Type");
    char text[ESI_TEXT], name[ESI_TEXT + 16];

    if (!type)
        return fail(esi, device, "<Device> without <Type>; expected ProductCode and RevisionNo");
    if (need(esi, type, attribute(type, "ProductCode", text), "a product code", UINT32_MAX,
             &d->product) ||
        may_attribute(esi, type, "RevisionNo", "a revision", UINT32_MAX, &d->revision))
        return -EINVAL;
    d->vendor = esi->vendor;
    d->place = place_of(device);
    content(type, text);
    snprintf(name, sizeof name, newest ? "%s" : "%s@0x%08X", text, d->revision);
    if (keep(esi, type, name, &d->type) || keep(esi, type, text, &d->order) ||
        keep_name(esi, device, DESC_NAME, &d->name))
        return -EINVAL;
    d->about = d->name;
    return keep(esi, device, content(child(device, "GroupType"), text), &d->group);
}

static int read_parts(struct esi *esi, xmlNode *device)
{
    static const struct {
        const char *name;
        int (*read)(struct esi *, xmlNode *);
    } parts[] = {
        { "Sm", read_sm }, { "Fmmu", read_fmmu }, { "RxPdo", read_pdo }, { "TxPdo", read_pdo }
    };

    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        for (xmlNode *n = child(device, parts[i].name); n; n = next(n, parts[i].name)) {
            if (parts[i].read(esi, n))
                return -EINVAL;
        }
    }
    return 0;
}

static int read_device(struct esi *esi, xmlNode *device, bool newest)
{
    esi->row_count = 0;
    if (read_identity(esi, device, newest) || read_parts(esi, device) ||
        read_mailbox(esi, device) || read_eeprom(esi, device) || read_dc(esi, device) ||
        read_dictionary(esi, device))
        return -EINVAL;
    read_ports(esi, device);
    add_channels(esi->d);
    return 0;
}

/* Of several revisions of a type the highest has the plain name; of equal ones the first. */
static bool is_newest(xmlNode *device)
{
    char mine[ESI_TEXT], other[ESI_TEXT], text[ESI_TEXT];
    xmlNode *type = child(device, "Type");
    uint32_t revision = 0, theirs;
    bool behind = false;

    if (!type)
        return true;
    content(type, mine);
    number(attribute(type, "RevisionNo", text), &revision);
    for (xmlNode *n = from(device->parent->children, "Device"); n; n = next(n, "Device")) {
        xmlNode *t = child(n, "Type");

        if (n == device) {
            behind = true;
            continue;
        }
        theirs = 0;
        if (!t || strcmp(content(t, other), mine) != 0)
            continue;
        number(attribute(t, "RevisionNo", text), &theirs);
        if (theirs > revision || (theirs == revision && !behind))
            return false;
    }
    return true;
}

enum selection { NOT_SELECTED, SELECTED, SELECTED_EXACTLY };

/* By type or product code the highest revision is meant; TYPE@0xREVISION names one of the others.
 */
static enum selection selected(xmlNode *device, const char *select)
{
    char text[ESI_TEXT], name[ESI_TEXT + 16];
    xmlNode *type = child(device, "Type");
    uint32_t wanted, product, revision = 0;

    if (!select)
        return SELECTED_EXACTLY;
    if (!type)
        return NOT_SELECTED;
    number(attribute(type, "RevisionNo", text), &revision);
    content(type, text);
    snprintf(name, sizeof name, "%s@0x%08X", text, revision);
    if (strcmp(name, select) == 0)
        return SELECTED_EXACTLY;
    if (strcmp(text, select) == 0)
        return SELECTED;
    return number(select, &wanted) && number(attribute(type, "ProductCode", text), &product) &&
                   product == wanted
               ? SELECTED
               : NOT_SELECTED;
}

static int give(struct esi *esi, xmlNode *device, enum selection selection, description_taker *take,
                void *argument)
{
    bool newest = is_newest(device);
    int error;

    if (selection == SELECTED && !newest)
        return 0;
    esi->d = description_new(esi->file);
    if (!esi->d) {
        snprintf(esi->why, LIBRARY_WHY, "%.200s: no memory", esi->file);
        return -ENOMEM;
    }
    error = read_device(esi, device, newest);
    if (!error)
        error = take(argument, esi->d, esi->why);
    free(esi->d);
    return error;
}

static int read_info(struct esi *esi, xmlNode *root, const char *select, description_taker *take,
                     void *argument)
{
    static const char *const to_devices[] = { "Descriptions", "Devices", NULL };
    xmlNode *vendor = root ? child(root, "Vendor") : NULL, *devices;
    unsigned found = 0;
    int error = 0;

    if (!root || !is(root, "EtherCATInfo"))
        return fail(esi, root, "<%.40s>; expected <EtherCATInfo>",
                    root ? (const char *)root->name : "");
    if (!vendor)
        return fail(esi, root, "no <Vendor>; expected it with an <Id>");
    if (need_child(esi, vendor, "Id", "the vendor id", UINT32_MAX, &esi->vendor))
        return -EINVAL;
    devices = down(root, to_devices);
    if (!child(devices, "Device"))
        return fail(esi, devices ? devices : root,
                    "no devices; expected <Descriptions>, <Devices>, <Device>");
    for (xmlNode *n = child(devices, "Device"); !error && n; n = next(n, "Device")) {
        enum selection selection = selected(n, select);

        if (selection == NOT_SELECTED)
            continue;
        found++;
        error = give(esi, n, selection, take, argument);
    }
    if (!error && !found)
        return fail(esi, devices, "no device \"%.60s\"; expected a <Type> or its ProductCode",
                    select ? select : "");
    return error;
}

static int complain(const struct esi *esi, const xmlError *error)
{
    struct place place = { error && error->line > 0 ? (unsigned)error->line : 1,
                           error && error->int2 > 0 ? (unsigned)error->int2 : 0 };
    const char *message = error && error->message ? error->message : "it is none";

    return why_at(esi->why, esi->file, place, "%.*s; expected well-formed XML",
                  (int)strcspn(message, "\n"), message);
}

static void silent(void *context, const char *message, ...)
{
    (void)context, (void)message;
}

int esi_read(const char *file, const char *text, size_t length, const char *select,
             description_taker *take, void *argument, char why[LIBRARY_WHY])
{
    struct esi esi = { .file = file, .why = why };
    xmlParserCtxt *context = length <= INT_MAX ? xmlNewParserCtxt() : NULL;
    xmlDoc *document = NULL;
    int error = -ENOMEM;

    esi.rows = calloc(DESC_ROWS, sizeof *esi.rows);
    snprintf(why, LIBRARY_WHY, "%.200s: no memory", file);
    if (!context || !esi.rows)
        goto out;
    xmlSetGenericErrorFunc(NULL, silent);
    document = xmlCtxtReadMemory(context, text, (int)length, file, NULL,
                                 XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING |
                                     XML_PARSE_NOCDATA | XML_PARSE_BIG_LINES);
    if (!document)
        error = complain(&esi, xmlCtxtGetLastError(context));
    else if (document->intSubset)
        error = fail(&esi, (xmlNode *)document->intSubset,
                     "a document type definition; expected none in ESI");
    else
        error = read_info(&esi, xmlDocGetRootElement(document), select, take, argument);
out:
    if (!error)
        why[0] = '\0';
    xmlFreeDoc(document);
    xmlFreeParserCtxt(context);
    free(esi.rows);
    return error;
}
