/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Evidence from a file, which may be anything: read, and written again. What was taken once comes
 * back the same. Inputs are the squeezed values behind a head that is right (so that they get past
 * it), or, where the first byte is odd, the whole file. The lines of waivers files as well.
 */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "conformance/rules.h"
#include "conformance/waivers.h"
#include "host/evidence_file.h"

enum { HEAD = 28 }; /* bytes in front of the values */

/* Stands in for the rule book, which would bring everything else with it. */
const struct rule *rule_find(const char *id)
{
    static const struct rule any = { .id = "any" };
    return id[0] == 'r' ? &any : NULL;
}

/* As evidence has them, but few: the reader is the same. */
struct small {
    uint64_t wide[3];
    uint32_t word;
    char text[7];
    uint16_t half;
    struct inner {
        uint8_t byte;
        uint64_t long_word;
    } inner[2];
};

static const struct evidence_row inner_rows[] = {
    { "byte", offsetof(struct inner, byte), 1, 1, NULL },
    { "long_word", offsetof(struct inner, long_word), 8, 1, NULL },
    { NULL, 0, 0, 0, NULL },
};
static const struct evidence_row small_rows[] = {
    { "wide", offsetof(struct small, wide), 8, 3, NULL },
    { "word", offsetof(struct small, word), 4, 1, NULL },
    { "text", offsetof(struct small, text), 1, 7, NULL },
    { "half", offsetof(struct small, half), 2, 1, NULL },
    { "inner", offsetof(struct small, inner), sizeof(struct inner), 2, inner_rows },
    { NULL, 0, 0, 0, NULL },
};

static void read_and_write(const uint8_t *bytes, size_t size)
{
    char why[EVIDENCE_WHY];
    struct small read, again;
    uint8_t *first, *second;
    size_t first_size, second_size;
    if (rows_decode(small_rows, &read, bytes, size, why) != 0)
        return;
    if (rows_encode(small_rows, &read, &first, &first_size) != 0 ||
        rows_decode(small_rows, &again, first, first_size, why) != 0 ||
        rows_encode(small_rows, &again, &second, &second_size) != 0)
        abort();
    if (first_size != second_size || memcmp(first, second, first_size) != 0)
        abort();
    free(first);
    free(second);
}

/* All of it, now and then: it is some hundred kilobytes. */
static void read_whole_evidence(const uint8_t *data, size_t size)
{
    static struct experiment_result result;
    char why[EVIDENCE_WHY];
    uint8_t *whole;
    size_t whole_size;
    if (evidence_encode(&result, &whole, &whole_size) != 0)
        return;
    for (size_t i = 0; i < size && HEAD + i < whole_size; i++)
        whole[HEAD + i] = data[i];
    evidence_decode(&result, whole, whole_size, why);
    memset(&result, 0, sizeof result);
    free(whole);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct waivers waivers;
    static const struct small zero;
    static unsigned turn;
    char why[WAIVERS_WHY];
    uint8_t *head, *input;
    size_t head_size;
    if (size == 0 || size > 65536)
        return 0;
    waivers_read(&waivers, (const char *)data, size, "fuzz", why);
    if (data[0] & 1) {
        read_and_write(data + 1, size - 1);
        return 0;
    }
    if (++turn % 4096 == 0)
        read_whole_evidence(data + 1, size - 1);
    if (rows_encode(small_rows, &zero, &head, &head_size) != 0)
        return 0;
    input = malloc(HEAD + size);
    if (input != NULL) {
        memcpy(input, head, HEAD);
        memcpy(input + HEAD, data + 1, size - 1);
        read_and_write(input, HEAD + size - 1);
    }
    free(input);
    free(head);
    return 0;
}
