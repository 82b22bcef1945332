/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "report/markup.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

struct range {
    uint32_t first, last;
};

/* What is valid UTF-8, and still not for a report. */
static const struct range unwanted[] = {
    { 0x01, 0x1F },     { 0x7F, 0x9F },     /* control characters */
    { 0x061C, 0x061C }, { 0x200B, 0x200F }, /* without width; marks of direction */
    { 0x2028, 0x202E }, { 0x2060, 0x206F }, /* line ends; embeddings and overrides */
    { 0xD800, 0xDFFF }, { 0xFEFF, 0xFEFF }, /* halves of UTF-16 */
    { 0xFFFE, 0xFFFF },                     /* no characters, and not allowed in XML */
};

static bool wanted(uint32_t c)
{
    for (size_t i = 0; i < sizeof unwanted / sizeof *unwanted; i++)
        if (c >= unwanted[i].first && c <= unwanted[i].last)
            return false;
    return c <= 0x10FFFF;
}

static size_t length_of(unsigned char lead)
{
    return lead < 0x80                   ? 1
           : lead >= 0xC2 && lead < 0xE0 ? 2
           : lead >= 0xE0 && lead < 0xF0 ? 3
           : lead >= 0xF0 && lead < 0xF5 ? 4
                                         : 0;
}

uint32_t markup_next(const char **text)
{
    static const uint32_t least[] = { 0, 0, 0x80, 0x800, 0x10000 };
    const unsigned char *byte = (const unsigned char *)*text;
    const size_t length = length_of(*byte);
    uint32_t c = length < 2 ? *byte : *byte & (0x7Fu >> length);
    for (size_t i = 1; i < length; i++) {
        if ((byte[i] & 0xC0) != 0x80) {
            ++*text;
            return MARKUP_REPLACEMENT;
        }
        c = c << 6 | (byte[i] & 0x3F);
    }
    if (length == 0 || c < least[length]) {
        ++*text;
        return MARKUP_REPLACEMENT;
    }
    *text += length;
    return wanted(c) ? c : MARKUP_REPLACEMENT;
}

static const char *entity(uint32_t c)
{
    switch (c) {
    case '&':
        return "&amp;";
    case '<':
        return "&lt;";
    case '>':
        return "&gt;";
    case '"':
        return "&quot;";
    case '\'':
        return "&#39;";
    default:
        return NULL;
    }
}

void markup_text(FILE *out, const char *text)
{
    while (*text != '\0') {
        const char *begin = text;
        const uint32_t c = markup_next(&text);
        if (entity(c) != NULL)
            fputs(entity(c), out);
        else if (c == MARKUP_REPLACEMENT)
            fputs("\xEF\xBF\xBD", out);
        else
            fwrite(begin, 1, (size_t)(text - begin), out);
    }
}

void markup_plain(FILE *out, const char *text)
{
    while (*text != '\0') {
        const char *begin = text;
        if (markup_next(&text) == MARKUP_REPLACEMENT)
            fputc('?', out);
        else
            fwrite(begin, 1, (size_t)(text - begin), out);
    }
}

void markup_uri(const char *text, char *out, size_t size)
{
    static const char harmless[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~/";
    size_t at = 0;
    for (; *text != '\0' && at + 4 <= size; text++)
        if (strchr(harmless, *text) != NULL)
            out[at++] = *text;
        else
            at += (size_t)snprintf(out + at, size - at, "%%%02X", (unsigned char)*text);
    out[at] = '\0';
}
