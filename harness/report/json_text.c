/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "report/json_text.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "report/markup.h"

json_t *json_text(const char *value)
{
    if (value == NULL)
        return json_null();
    json_t *string = json_string(value);
    if (string != NULL)
        return string;
    char *clean = malloc(strlen(value) * 3 + 1);
    size_t at = 0;
    if (clean == NULL)
        return NULL;
    while (*value != '\0') {
        const char *begin = value;
        const uint32_t c = markup_next(&value);
        const size_t length = c == MARKUP_REPLACEMENT ? 3 : (size_t)(value - begin);
        memcpy(clean + at, c == MARKUP_REPLACEMENT ? "\xEF\xBF\xBD" : begin, length);
        at += length;
    }
    string = json_stringn(clean, at);
    free(clean);
    return string;
}

json_t *json_hex(uint64_t value)
{
    char buffer[24];
    snprintf(buffer, sizeof buffer, "0x%" PRIx64, value);
    return json_string(buffer);
}

int json_document(json_t *root, FILE *stream)
{
    const int bad = json_dumpf(root, stream, JSON_INDENT(2) | JSON_REAL_PRECISION(12));
    json_decref(root);
    if (bad != 0 || fputc('\n', stream) == EOF || fflush(stream) != 0)
        return errno != 0 ? -errno : -EIO;
    return 0;
}
