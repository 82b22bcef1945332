/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules.h"

/* Length of the UTF-8 character there, 0 when it is none; its number in *number. */
static size_t utf8(const unsigned char *at, uint32_t *number)
{
    static const uint32_t least[] = { 0, 0, 0x80, 0x800, 0x10000 };
    const size_t length = at[0] < 0x80             ? 1
                          : (at[0] & 0xE0) == 0xC0 ? 2
                          : (at[0] & 0xF0) == 0xE0 ? 3
                          : (at[0] & 0xF8) == 0xF0 ? 4
                                                   : 0;
    *number = length < 2 ? at[0] : at[0] & (0x7Fu >> length);
    for (size_t i = 1; i < length; i++) {
        if ((at[i] & 0xC0) != 0x80)
            return 0;
        *number = *number << 6 | (at[i] & 0x3Fu);
    }
    const bool surrogate = *number >= 0xD800 && *number < 0xE000;
    return *number < least[length] || *number > 0x10FFFF || surrogate ? 0 : length;
}

/* Moves the cursor, ends the line, or has what follows read in another order. */
static bool is_control(uint32_t number)
{
    return number < 0x20 || (number >= 0x7F && number < 0xA0) || number == 0x61C ||
           (number >= 0x200B && number <= 0x200F) || (number >= 0x2028 && number <= 0x202E) ||
           (number >= 0x2060 && number <= 0x206F) || number == 0xFEFF;
}

/* Names from a file may hold line ends, escape sequences or no text at all: they must not write
 * lines of the report, nor have it read otherwise than it is. */
static void clean(char *text)
{
    uint32_t number;
    for (size_t length; *text != '\0'; text += length) {
        length = utf8((unsigned char *)text, &number);
        if (length != 0 && !is_control(number))
            continue;
        length = length != 0 ? length : 1;
        memset(text, '?', length);
    }
}

static struct finding *slot(struct findings *findings, const char *what)
{
    for (size_t i = 0; i < findings->count; i++)
        if (strcmp(findings->list[i].what, what) == 0) {
            findings->list[i].count++;
            return &findings->scratch;
        }
    if (findings->count == FINDINGS_KEPT) {
        findings->dropped++;
        return &findings->scratch;
    }
    struct finding *finding = &findings->list[findings->count++];
    memset(finding, 0, sizeof *finding);
    snprintf(finding->what, sizeof finding->what, "%s", what);
    finding->count = 1;
    return finding;
}

struct finding *finding_add(struct findings *findings, const char *format, ...)
{
    char what[FINDING_TEXT];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    clean(what);
    return slot(findings, what);
}

void finding_not_judged(struct findings *findings, const char *format, ...)
{
    if (findings->reason[0] != '\0')
        return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(findings->reason, sizeof findings->reason, format, arguments);
    va_end(arguments);
    clean(findings->reason);
}

void finding_place(struct finding *finding, const struct case_file *file, uint64_t vaddr)
{
    struct image_place place;
    image_where(file->image, vaddr, &place);
    int at = snprintf(finding->place, sizeof finding->place, "%s+0x%" PRIx64, file->name, vaddr);
    if (place.function != NULL && at < FINDING_TEXT)
        at += snprintf(finding->place + at, (size_t)(FINDING_TEXT - at), " (%s)", place.function);
    finding->has_address = true;
    finding->address = vaddr;
    if (place.file != NULL) {
        snprintf(finding->file, sizeof finding->file, "%s", place.file);
        finding->line = place.line;
    }
    clean(finding->file);
    if (place.file != NULL && at < FINDING_TEXT)
        snprintf(finding->place + at, (size_t)(FINDING_TEXT - at), " %s:%d", place.file,
                 place.line);
    clean(finding->place);
}
