/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Evidence from a file, which may be anything: read, and written again. What was taken once comes
 * back the same. Inputs are the squeezed values behind a head that is right (so that they get past
 * it), or, where the first byte is odd, the whole file. The lines of waivers files as well.
 */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "conformance/rules.h"
#include "conformance/waivers.h"
#include "host/evidence_file.h"

static struct experiment_result result, again;

/* Stands in for the rule book, which would bring everything else with it. */
const struct rule *rule_find(const char *id)
{
    static const struct rule any = { .id = "any" };
    return id[0] == 'r' ? &any : NULL;
}

static void read_and_write(const uint8_t *bytes, size_t size)
{
    char why[EVIDENCE_WHY];
    uint8_t *first, *second;
    size_t first_size, second_size;
    if (evidence_decode(&result, bytes, size, why) != 0)
        return;
    if (evidence_encode(&result, &first, &first_size) != 0 ||
        evidence_decode(&again, first, first_size, why) != 0 ||
        evidence_encode(&again, &second, &second_size) != 0)
        abort();
    if (first_size != second_size || memcmp(first, second, first_size) != 0)
        abort();
    free(first);
    free(second);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct waivers waivers;
    char why[WAIVERS_WHY];
    enum { HEAD = 28 };
    uint8_t *whole, *input;
    size_t whole_size;
    if (size == 0 || size > 65536)
        return 0;
    waivers_read(&waivers, (const char *)data, size, "fuzz", why);
    if (data[0] & 1) {
        read_and_write(data + 1, size - 1);
        return 0;
    }
    memset(&result, 0, sizeof result);
    if (evidence_encode(&result, &whole, &whole_size) != 0)
        return 0;
    input = malloc(HEAD + size);
    if (input != NULL) {
        memcpy(input, whole, HEAD);
        memcpy(input + HEAD, data + 1, size - 1);
        read_and_write(input, HEAD + size - 1);
    }
    free(input);
    free(whole);
    return 0;
}
