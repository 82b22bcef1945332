/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What ESI is written in: elements, attributes, numbers, names of types. */
#include "bus/esi_parts.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

struct place esi_place_of(xmlNode *node)
{
    long line = xmlGetLineNo(node);

    return (struct place){ line > 0 ? (unsigned)line : 0, 0 };
}

int esi_fail(const struct esi *esi, xmlNode *node, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    why_at_v(esi->why, esi->file, esi_place_of(node), format, arguments);
    va_end(arguments);
    return -EINVAL;
}

bool esi_is(const xmlNode *node, const char *name)
{
    return node->type == XML_ELEMENT_NODE && strcmp((const char *)node->name, name) == 0;
}

xmlNode *esi_from(xmlNode *node, const char *name)
{
    while (node && !esi_is(node, name))
        node = node->next;
    return node;
}

xmlNode *esi_child(xmlNode *node, const char *name)
{
    return node ? esi_from(node->children, name) : NULL;
}

xmlNode *esi_next(xmlNode *node, const char *name)
{
    return esi_from(node->next, name);
}

xmlNode *esi_down(xmlNode *node, const char *const *path)
{
    for (; node && *path; path++)
        node = esi_child(node, *path);
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

const char *esi_content(xmlNode *node, char to[ESI_TEXT])
{
    return clean(node ? xmlNodeGetContent(node) : NULL, to);
}

const char *esi_attribute(xmlNode *node, const char *name, char to[ESI_TEXT])
{
    return clean(xmlGetNoNsProp(node, (const xmlChar *)name), to);
}

bool esi_flag(xmlNode *node, const char *name)
{
    char text[ESI_TEXT];

    esi_attribute(node, name, text);
    return strcmp(text, "1") == 0 || strcmp(text, "true") == 0;
}

/* "#x1A00", "0x1A00" or decimal. */
bool esi_number(const char *text, uint32_t *value)
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

int esi_need(const struct esi *esi, xmlNode *node, const char *text, const char *what,
             uint32_t most, uint32_t *value)
{
    if (!esi_number(text, value))
        return esi_fail(esi, node,
                        "\"%.40s\" is not a number; expected %s, #x and hexadecimal digits", text,
                        what);
    if (*value > most)
        return esi_fail(esi, node, "%.40s is out of range; expected %s up to 0x%X", text, what,
                        most);
    return 0;
}

int esi_need_child(const struct esi *esi, xmlNode *node, const char *name, const char *what,
                   uint32_t most, uint32_t *value)
{
    xmlNode *found = esi_child(node, name);
    char text[ESI_TEXT];

    if (!found)
        return esi_fail(esi, node, "<%s> without <%s>; expected %s", (const char *)node->name, name,
                        what);
    return esi_need(esi, found, esi_content(found, text), what, most, value);
}

/* Absent: stays as it is. */
int esi_may_attribute(const struct esi *esi, xmlNode *node, const char *name, const char *what,
                      uint32_t most, uint32_t *value)
{
    char text[ESI_TEXT];

    if (!*esi_attribute(node, name, text))
        return 0;
    return esi_need(esi, node, text, what, most, value);
}

int esi_keep(const struct esi *esi, xmlNode *node, const char *text, const char **to)
{
    *to = description_text(esi->d, text, strlen(text));
    return *to ? 0
               : esi_fail(esi, node, "too much text; expected at most %d characters", DESC_TEXT);
}

/* The English one of several names, or the first. */
static xmlNode *name_of(xmlNode *node)
{
    xmlNode *first = esi_child(node, "Name");
    char text[ESI_TEXT];

    for (xmlNode *n = first; n; n = esi_next(n, "Name")) {
        if (strcmp(esi_attribute(n, "LcId", text), "1033") == 0)
            return n;
    }
    return first;
}

int esi_keep_name(const struct esi *esi, xmlNode *node, size_t most, const char **to)
{
    char text[ESI_TEXT];

    esi_content(name_of(node), text);
    if (strlen(text) > most)
        text[most] = '\0';
    return esi_keep(esi, node, text, to);
}

/* The name decides when it fits the length, else the length does: enumerations and bit fields have
 * names of their own. 0: nothing fits. */
uint8_t esi_type_of(const char *name, uint32_t bits)
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

int esi_bytes_of(const char *text, uint8_t *bytes, size_t room)
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
