/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules.h"

/* Names from a file may hold line ends or escape sequences: they must not write lines of the
 * report. */
static void clean(char *text)
{
    for (; *text != '\0'; text++)
        if ((unsigned char)*text < 0x20 || *text == 0x7F)
            *text = '?';
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
