/* SPDX-License-Identifier: MIT */
/*
 * unicode.h - reading UTF-16 and UTF-8 character by character; what text16.c and text8.c share. Not for
 * authors: they include <tgm/text.h>, which says how invalid input is replaced.
 */
#ifndef TGM_SRC_UNICODE_H
#define TGM_SRC_UNICODE_H

#include <tgm_plc.h>

#define UNICODE_REPLACEMENT 0xFFFDu

/* What is still to be read; ends at a 0 or when nothing is left. */
struct unicode_source16 {
    const tgm_wchar *at;
    size_t left;
};
struct unicode_source8 {
    const char *at;
    size_t left;
};

static inline int unicode_is_character(uint32_t code_point)
{
    return code_point != 0 && code_point <= 0x10FFFFu && (code_point & 0xFFFFF800u) != 0xD800u;
}

/* The next character, 0 at the end. */
static inline uint32_t unicode_next16(struct unicode_source16 *s)
{
    if (s->left == 0 || *s->at == 0)
        return 0;
    const uint32_t first = *s->at++;
    s->left--;
    if ((first & 0xFFFFF800u) != 0xD800u)
        return first;
    if (first >= 0xDC00u || s->left == 0 || ((uint32_t)*s->at & 0xFFFFFC00u) != 0xDC00u)
        return UNICODE_REPLACEMENT;
    s->left--;
    return 0x10000u + ((first - 0xD800u) << 10) + ((uint32_t)*s->at++ - 0xDC00u);
}

/* What may follow a first byte: how many bytes, and the narrower range of the first of them, which
 * excludes overlong forms, surrogates and numbers above U+10FFFF. (The Unicode Standard, table 3-7.) */
struct unicode_lead {
    unsigned char from, to, more, low, high;
};

static inline const struct unicode_lead *unicode_lead_of(unsigned char byte)
{
    static const struct unicode_lead leads[] = {
        { 0x00, 0x7F, 0, 0x00, 0x00 }, { 0xC2, 0xDF, 1, 0x80, 0xBF }, { 0xE0, 0xE0, 2, 0xA0, 0xBF },
        { 0xE1, 0xEC, 2, 0x80, 0xBF }, { 0xED, 0xED, 2, 0x80, 0x9F }, { 0xEE, 0xEF, 2, 0x80, 0xBF },
        { 0xF0, 0xF0, 3, 0x90, 0xBF }, { 0xF1, 0xF3, 3, 0x80, 0xBF }, { 0xF4, 0xF4, 3, 0x80, 0x8F },
    };
    for (unsigned i = 0; i < sizeof leads / sizeof leads[0]; i++)
        if (byte >= leads[i].from && byte <= leads[i].to)
            return &leads[i];
    return NULL;
}

/* The next character, 0 at the end. */
static inline uint32_t unicode_next8(struct unicode_source8 *s)
{
    if (s->left == 0 || *s->at == 0)
        return 0;
    const unsigned char first = (unsigned char)*s->at++;
    s->left--;
    const struct unicode_lead *lead = unicode_lead_of(first);
    if (lead == NULL)
        return UNICODE_REPLACEMENT;

    uint32_t code_point = lead->more == 0 ? first : first & (0x3Fu >> lead->more);
    unsigned char low = lead->low, high = lead->high;
    for (unsigned more = lead->more; more > 0; more--) {
        const unsigned char byte = s->left > 0 ? (unsigned char)*s->at : 0;
        if (byte < low || byte > high)
            return UNICODE_REPLACEMENT;
        code_point = code_point << 6 | (byte & 0x3Fu);
        low = 0x80;
        high = 0xBF;
        s->at++;
        s->left--;
    }
    return code_point;
}

#endif
