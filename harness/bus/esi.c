/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * ESI (EtherCAT Slave Information, XML) into descriptions. libxml2 parses; nothing is fetched, no
 * entity of the file is expanded. Read is what a terminal has: identity, mailbox, sync managers,
 * FMMUs, PDOs, distributed clock, EEPROM configuration, dictionary. Modules and slots are not.
 */
#include "bus/esi_parts.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include <libxml/parser.h>

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
        return esi_fail(esi, node, "too many <Sm>; expected at most %d", SII_MAX_SM);
    esi_content(node, text);
    while (strcmp(kinds[k].text, text) != 0) {
        if (++k == sizeof kinds / sizeof *kinds)
            return esi_fail(esi, node,
                            "<Sm> is \"%.40s\"; expected MBoxOut, MBoxIn, Outputs or Inputs", text);
    }
    control = kinds[k].control;
    if (esi_may_attribute(esi, node, "StartAddress", "an address", 0xffff, &start) ||
        esi_may_attribute(esi, node, "DefaultSize", "a length", 0xffff, &length) ||
        esi_may_attribute(esi, node, "ControlByte", "a control byte", 0xff, &control) ||
        esi_may_attribute(esi, node, "Enable", "an enable byte", 0x0f, &enable))
        return -EINVAL;
    if (esi_flag(node, "Virtual"))
        enable |= 4;
    if (esi_flag(node, "OpOnly"))
        enable |= 8;
    *sm = (struct desc_sm){ esi_place_of(node), (uint16_t)start, (uint16_t)length,
                            (uint8_t)control,   (uint8_t)enable, kinds[k].type };
    d->sm_count++;
    return 0;
}

static int read_fmmu(struct esi *esi, xmlNode *node)
{
    static const char *const uses[] = { "", "Outputs", "Inputs", "MBoxState" };
    struct description *d = esi->d;
    char text[ESI_TEXT];

    esi_content(node, text);
    if (d->fmmu_count == SII_MAX_FMMU)
        return esi_fail(esi, node, "too many <Fmmu>; expected at most %d", SII_MAX_FMMU);
    for (uint8_t i = 0; i < 4; i++) {
        if (strcmp(text, uses[i]) != 0)
            continue;
        d->fmmu[d->fmmu_count++] = i;
        return 0;
    }
    return esi_fail(esi, node, "<Fmmu> is \"%.40s\"; expected Outputs, Inputs or MBoxState", text);
}

static int read_entry(struct esi *esi, xmlNode *node, struct desc_pdo *pdo)
{
    struct description *d = esi->d;
    struct desc_entry *e = &d->entry[d->entry_count];
    uint32_t index, subindex = 0, bits;
    char text[ESI_TEXT];

    if (d->entry_count == DESC_ENTRIES)
        return esi_fail(esi, node, "too many <Entry>; expected at most %d", DESC_ENTRIES);
    if (esi_need_child(esi, node, "Index", "an index", 0xffff, &index) ||
        esi_need_child(esi, node, "BitLen", "a length in bits", 255, &bits))
        return -EINVAL;
    if (index && esi_child(node, "SubIndex") &&
        esi_need_child(esi, node, "SubIndex", "a subindex", 255, &subindex))
        return -EINVAL;
    *e = (struct desc_entry){ .place = esi_place_of(node),
                              .index = (uint16_t)index,
                              .bits = (uint8_t)bits,
                              .subindex = (uint8_t)subindex,
                              .name = "" };
    if (index) {
        e->type = esi_type_of(esi_content(esi_child(node, "DataType"), text), bits);
        if (!e->type || e->type == OD_STRING || !bits)
            return esi_fail(esi, node, "an entry of %u bits; expected 1 to 8, 16, 32 or 64", bits);
        if (esi_keep_name(esi, node, ESI_TEXT - 1, &e->name))
            return -EINVAL;
    } else if (!bits) {
        return esi_fail(esi, node, "a gap of no bits; expected 1 to 255");
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
        return esi_fail(esi, node, "too many PDOs; expected at most %d", DESC_PDOS);
    if (esi_need_child(esi, node, "Index", "the index of the PDO", 0xffff, &index) ||
        esi_may_attribute(esi, node, "Sm", "a sync manager", SII_MAX_SM - 1, &sm))
        return -EINVAL;
    *pdo = (struct desc_pdo){ .place = esi_place_of(node),
                              .direction = esi_is(node, "RxPdo") ? PDO_RX : PDO_TX,
                              .index = (uint16_t)index,
                              .sm = (uint8_t)sm,
                              .flags = (uint16_t)((esi_flag(node, "Mandatory") ? 0x01 : 0) |
                                                  (esi_flag(node, "Fixed") ? 0x10 : 0)),
                              .first = d->entry_count };
    if (esi_keep_name(esi, node, ESI_TEXT - 1, &pdo->name))
        return -EINVAL;
    for (xmlNode *e = esi_child(node, "Entry"); e; e = esi_next(e, "Entry")) {
        if (read_entry(esi, e, pdo))
            return -EINVAL;
    }
    d->pdo_count++;
    return 0;
}

static int read_mailbox(struct esi *esi, xmlNode *device)
{
    xmlNode *coe = esi_child(esi_child(device, "Mailbox"), "CoE");

    if (!coe)
        return 0;
    /* PDO configuration is left out: the mapping objects of a terminal cannot be written. */
    esi->d->coe_place = esi_place_of(coe);
    esi->d->coe_details = (uint8_t)(0x01 | (esi_flag(coe, "SdoInfo") ? 0x02 : 0) |
                                    (esi_flag(coe, "PdoAssign") ? 0x04 : 0) |
                                    (esi_flag(coe, "PdoUpload") ? 0x10 : 0) |
                                    (esi_flag(coe, "CompleteAccess") ? 0x20 : 0));
    return 0;
}

static int read_dc(struct esi *esi, xmlNode *device)
{
    xmlNode *dc = esi_child(device, "Dc");
    uint32_t assign = 0;

    if (!dc)
        return 0;
    esi->d->dc = DESC_DC_FULL;
    for (xmlNode *m = esi_child(dc, "OpMode"); m && !assign; m = esi_next(m, "OpMode")) {
        if (esi_child(m, "AssignActivate") &&
            esi_need_child(esi, m, "AssignActivate", "AssignActivate", 0xffff, &assign))
            return -EINVAL;
    }
    esi->d->dc_assign = (uint16_t)assign;
    return 0;
}

static int read_eeprom(struct esi *esi, xmlNode *device)
{
    static const char *const path[] = { "Eeprom", "ConfigData", NULL };
    xmlNode *node = esi_down(device, path);
    struct description *d = esi->d;
    bool mailbox = description_sm(d, SII_SM_MBX_OUT) >= 0;
    uint8_t config[32] = { 0 };
    char text[ESI_TEXT];

    d->emulation = !mailbox;
    d->pdi_control = mailbox ? 0x0c08 : 0x0104;
    if (!node)
        return 0;
    if (esi_bytes_of(esi_content(node, text), config, sizeof config) < 2)
        return esi_fail(esi, node,
                        "<ConfigData> is \"%.40s\"; expected 2 to 32 bytes in hexadecimal", text);
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

    esi_attribute(device, "Physics", text);
    for (unsigned i = 0; i < 4 && text[i]; i++)
        ports |= (text[i] == 'Y' ? 1u : text[i] == 'K' ? 3u : text[i] == 'H' ? 4u : 0u) << (4 * i);
    if (ports)
        esi->d->ports = (uint16_t)ports;
}

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
    xmlNode *type = esi_child(device, "Type");
    char text[ESI_TEXT], name[ESI_TEXT + 16];

    if (!type)
        return esi_fail(esi, device,
                        "<Device> without <Type>; expected ProductCode and RevisionNo");
    if (esi_need(esi, type, esi_attribute(type, "ProductCode", text), "a product code", UINT32_MAX,
                 &d->product) ||
        esi_may_attribute(esi, type, "RevisionNo", "a revision", UINT32_MAX, &d->revision))
        return -EINVAL;
    d->vendor = esi->vendor;
    d->place = esi_place_of(device);
    esi_content(type, text);
    snprintf(name, sizeof name, newest ? "%s" : "%s@0x%08X", text, d->revision);
    if (esi_keep(esi, type, name, &d->type) || esi_keep(esi, type, text, &d->order) ||
        esi_keep_name(esi, device, DESC_NAME, &d->name))
        return -EINVAL;
    d->about = d->name;
    return esi_keep(esi, device, esi_content(esi_child(device, "GroupType"), text), &d->group);
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
        for (xmlNode *n = esi_child(device, parts[i].name); n; n = esi_next(n, parts[i].name)) {
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
        esi_read_dictionary(esi, device))
        return -EINVAL;
    read_ports(esi, device);
    add_channels(esi->d);
    return 0;
}

/* Of several revisions of a type the highest has the plain name; of equal ones the first. */
static bool is_newest(xmlNode *device)
{
    char mine[ESI_TEXT], other[ESI_TEXT], text[ESI_TEXT];
    xmlNode *type = esi_child(device, "Type");
    uint32_t revision = 0, theirs;
    bool behind = false;

    if (!type)
        return true;
    esi_content(type, mine);
    esi_number(esi_attribute(type, "RevisionNo", text), &revision);
    for (xmlNode *n = esi_from(device->parent->children, "Device"); n; n = esi_next(n, "Device")) {
        xmlNode *t = esi_child(n, "Type");

        if (n == device) {
            behind = true;
            continue;
        }
        theirs = 0;
        if (!t || strcmp(esi_content(t, other), mine) != 0)
            continue;
        esi_number(esi_attribute(t, "RevisionNo", text), &theirs);
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
    xmlNode *type = esi_child(device, "Type");
    uint32_t wanted, product, revision = 0;

    if (!select)
        return SELECTED_EXACTLY;
    if (!type)
        return NOT_SELECTED;
    esi_number(esi_attribute(type, "RevisionNo", text), &revision);
    esi_content(type, text);
    snprintf(name, sizeof name, "%s@0x%08X", text, revision);
    if (strcmp(name, select) == 0)
        return SELECTED_EXACTLY;
    if (strcmp(text, select) == 0)
        return SELECTED;
    return esi_number(select, &wanted) &&
                   esi_number(esi_attribute(type, "ProductCode", text), &product) &&
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
    xmlNode *vendor = root ? esi_child(root, "Vendor") : NULL, *devices;
    unsigned found = 0;
    int error = 0;

    if (!root || !esi_is(root, "EtherCATInfo"))
        return esi_fail(esi, root, "<%.40s>; expected <EtherCATInfo>",
                        root ? (const char *)root->name : "");
    if (!vendor)
        return esi_fail(esi, root, "no <Vendor>; expected it with an <Id>");
    if (esi_need_child(esi, vendor, "Id", "the vendor id", UINT32_MAX, &esi->vendor))
        return -EINVAL;
    devices = esi_down(root, to_devices);
    if (!esi_child(devices, "Device"))
        return esi_fail(esi, devices ? devices : root,
                        "no devices; expected <Descriptions>, <Devices>, <Device>");
    for (xmlNode *n = esi_child(devices, "Device"); !error && n; n = esi_next(n, "Device")) {
        enum selection selection = selected(n, select);

        if (selection == NOT_SELECTED)
            continue;
        found++;
        error = give(esi, n, selection, take, argument);
    }
    if (!error && !found)
        return esi_fail(esi, devices, "no device \"%.60s\"; expected a <Type> or its ProductCode",
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
        error = esi_fail(&esi, (xmlNode *)document->intSubset,
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
