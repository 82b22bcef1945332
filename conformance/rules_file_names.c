/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Names as compilers decorate them. */
#include <ctype.h>
#include <string.h>
#include <strings.h>

#include "conformance/rules_file.h"

/* A stretch of a name. */
struct part {
    const char *at;
    size_t length;
};

static bool is_wanted(struct part part, const char *wanted)
{
    return part.length == strlen(wanted) && strncasecmp(part.at, wanted, part.length) == 0;
}

static bool all_digits(const char *text)
{
    return *text != '\0' && text[strspn(text, "0123456789")] == '\0';
}

/* "10Program_01": the length, then so much of the name. */
static bool counted_part(const char **at, struct part *part)
{
    size_t length = 0;
    while (isdigit((unsigned char)**at) && length < 1000)
        length = 10 * length + (size_t)(*(*at)++ - '0');
    *part = (struct part){ *at, length };
    if (length == 0 || strnlen(*at, length) < length)
        return false;
    *at += length;
    return true;
}

/* _Z10Program_01P8PLC_DATA, _ZN7machine10Program_01EP8PLC_DATA: the last part is the name. */
static bool is_itanium(const char *name, const char *wanted)
{
    struct part part, last = { name, 0 };
    name += strspn(name, "_");
    if (*name++ != 'Z')
        return false;
    if (*name == 'L')
        name++;
    if (*name != 'N')
        return counted_part(&name, &part) && is_wanted(part, wanted);
    for (name++; counted_part(&name, &part);)
        last = part;
    return is_wanted(last, wanted);
}

/* ?Program_01@@YAJ..., ?Program_01@machine@@YAJ... */
static bool is_microsoft(const char *name, const char *wanted)
{
    const char *end = name[0] == '?' ? strchr(name, '@') : NULL;
    return end != NULL && is_wanted((struct part){ name + 1, (size_t)(end - name - 1) }, wanted);
}

/* GANTRY_$$_PROGRAM_01$PPLC_DATA$$LONGINT */
static bool is_pascal(const char *name, const char *wanted)
{
    const char *at = strstr(name, "_$$_");
    if (at == NULL)
        return false;
    at += 4;
    return is_wanted((struct part){ at, strcspn(at, "$") }, wanted);
}

static bool is_c(const char *name, const char *wanted, enum name_style *style)
{
    const bool fast = name[0] == '@';
    const char *begin = name + (fast ? 1 : strspn(name, "_"));
    const char *end = begin + strcspn(begin, "@");
    const char *suffix = end + strspn(end, "@");
    if (!is_wanted((struct part){ begin, (size_t)(end - begin) }, wanted))
        return false;
    if (*end == '@' && !all_digits(suffix))
        return false;
    if (*end == '@')
        *style = fast ? NAME_FASTCALL : suffix - end == 2 ? NAME_VECTORCALL : NAME_STDCALL;
    else
        *style = begin != name ? NAME_UNDERSCORE : NAME_CASE;
    if (strcmp(name, wanted) == 0)
        *style = NAME_PLAIN;
    return true;
}

bool name_is_meant(const char *name, const char *wanted, enum name_style *style)
{
    if (is_c(name, wanted, style))
        return true;
    *style = NAME_CPP;
    if (is_itanium(name, wanted) || is_microsoft(name, wanted))
        return true;
    *style = NAME_PASCAL;
    return is_pascal(name, wanted);
}
