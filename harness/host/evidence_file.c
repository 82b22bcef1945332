/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/evidence_file.h"

#include <errno.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FORM       UINT32_C(1)
#define HEAD_BYTES 28 /* magic, form, hash of the rows, bytes of the values */

static const uint8_t magic[8] = { 'T', 'G', 'M', 'E', 'V', 'I', 'D', '\n' };

static void put(uint8_t *to, uint64_t value, size_t size)
{
    for (size_t i = 0; i < size; i++)
        to[i] = (uint8_t)(value >> 8 * i);
}

static uint64_t get(const uint8_t *from, size_t size)
{
    uint64_t value = 0;
    for (size_t i = 0; i < size; i++)
        value |= (uint64_t)from[i] << 8 * i;
    return value;
}

/* FNV-1a over everything that says what the bytes mean. */
static uint64_t hash_bytes(uint64_t hash, const void *data, size_t size)
{
    const uint8_t *bytes = data;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ bytes[i]) * UINT64_C(0x100000001b3);
    return hash;
}

static uint64_t hash_rows(uint64_t hash, const struct evidence_row *rows)
{
    for (; rows->name != NULL; rows++) {
        uint8_t numbers[12];
        hash = hash_bytes(hash, rows->name, strlen(rows->name) + 1);
        put(numbers, rows->of != NULL ? 0 : rows->size, 4);
        put(numbers + 4, rows->count, 8);
        hash = hash_bytes(hash, numbers, sizeof numbers);
        if (rows->of != NULL)
            hash = hash_rows(hash, rows->of);
    }
    return hash;
}

static size_t bytes_of(const struct evidence_row *rows)
{
    size_t bytes = 0;
    for (; rows->name != NULL; rows++)
        bytes += rows->count * (rows->of != NULL ? bytes_of(rows->of) : rows->size);
    return bytes;
}

/* Values stand in the structure as they do in the file, one behind the other. */
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the file's order of bytes");

static uint8_t *values_out(const struct evidence_row *rows, const char *base, uint8_t *to)
{
    for (; rows->name != NULL; rows++) {
        if (rows->of == NULL) {
            memcpy(to, base + rows->offset, rows->count * rows->size);
            to += rows->count * rows->size;
            continue;
        }
        for (size_t i = 0; i < rows->count; i++)
            to = values_out(rows->of, base + rows->offset + i * rows->size, to);
    }
    return to;
}

static const uint8_t *values_in(const struct evidence_row *rows, char *base, const uint8_t *from)
{
    for (; rows->name != NULL; rows++) {
        if (rows->of == NULL) {
            memcpy(base + rows->offset, from, rows->count * rows->size);
            from += rows->count * rows->size;
            continue;
        }
        for (size_t i = 0; i < rows->count; i++)
            from = values_in(rows->of, base + rows->offset + i * rows->size, from);
    }
    return from;
}

static size_t run_of_zeros(const uint8_t *at, size_t left)
{
    size_t count = 0;
    while (count < left && at[count] == 0)
        count++;
    return count;
}

/* Up to the next eight zeros. */
static size_t run_of_others(const uint8_t *at, size_t left)
{
    size_t count = 0;
    while (count < left && run_of_zeros(at + count, left - count < 8 ? left - count : 8) < 8)
        count++;
    return count;
}

/* Pieces of a number of zeros and a number of bytes that follow. At most as long as the values and
 * 8 bytes for each 8 of them. */
static size_t squeeze(const uint8_t *values, size_t size, uint8_t *to)
{
    const uint8_t *const begin = to;
    for (size_t at = 0; at < size;) {
        const size_t zeros = run_of_zeros(values + at, size - at);
        const size_t others = run_of_others(values + at + zeros, size - at - zeros);
        put(to, zeros, 4);
        put(to + 4, others, 4);
        memcpy(to + 8, values + at + zeros, others);
        to += 8 + others;
        at += zeros + others;
    }
    return (size_t)(to - begin);
}

static bool stretch(const uint8_t *from, size_t left, uint8_t *values, size_t size)
{
    size_t at = 0;
    while (left >= 8) {
        const uint64_t zeros = get(from, 4), others = get(from + 4, 4);
        from += 8;
        left -= 8;
        if (zeros + others == 0 || zeros + others > size - at || others > left)
            return false;
        memset(values + at, 0, zeros);
        memcpy(values + at + zeros, from, others);
        at += zeros + others;
        from += others;
        left -= others;
    }
    return left == 0 && at == size;
}

int rows_encode(const struct evidence_row *rows, const void *from, uint8_t **bytes, size_t *size)
{
    const size_t values_size = bytes_of(rows);
    uint8_t *values = malloc(values_size), *out = malloc(HEAD_BYTES + 2 * values_size + 16);
    if (values == NULL || out == NULL) {
        free(values);
        free(out);
        return -ENOMEM;
    }
    values_out(rows, from, values);
    memcpy(out, magic, sizeof magic);
    put(out + 8, FORM, 4);
    put(out + 12, hash_rows(UINT64_C(0xcbf29ce484222325), rows), 8);
    put(out + 20, values_size, 8);
    *size = HEAD_BYTES + squeeze(values, values_size, out + HEAD_BYTES);
    *bytes = out;
    free(values);
    return 0;
}

static void clean_worker(struct worker_result *worker)
{
    if ((unsigned)worker->end > WORKER_TIMEOUT)
        worker->end = WORKER_FAILED;
    worker->reason[sizeof worker->reason - 1] = '\0';
    for (char *c = worker->reason; *c != '\0'; c++)
        if (*c < ' ' || *c > '~')
            *c = '?';
}

static int refuse(char why[EVIDENCE_WHY], const char *reason)
{
    snprintf(why, EVIDENCE_WHY, "%s", reason);
    return -EINVAL;
}

int rows_decode(const struct evidence_row *rows, void *to, const uint8_t *bytes, size_t size,
                char why[EVIDENCE_WHY])
{
    const size_t values_size = bytes_of(rows);
    if (size < HEAD_BYTES || memcmp(bytes, magic, sizeof magic) != 0)
        return refuse(why, "this is no evidence of tgm");
    if (get(bytes + 8, 4) != FORM ||
        get(bytes + 12, 8) != hash_rows(UINT64_C(0xcbf29ce484222325), rows) ||
        get(bytes + 20, 8) != values_size)
        return refuse(why,
                      "another version of tgm wrote it, in a form that this one does not read");
    uint8_t *values = malloc(values_size);
    if (values == NULL)
        return refuse(why, "no memory");
    const bool whole = stretch(bytes + HEAD_BYTES, size - HEAD_BYTES, values, values_size);
    if (whole)
        values_in(rows, to, values);
    free(values);
    return whole ? 0 : refuse(why, "it is cut short or damaged");
}

int evidence_encode(const struct experiment_result *result, uint8_t **bytes, size_t *size)
{
    return rows_encode(evidence_result_rows, result, bytes, size);
}

int evidence_decode(struct experiment_result *result, const uint8_t *bytes, size_t size,
                    char why[EVIDENCE_WHY])
{
    memset(result, 0, sizeof *result);
    const int r = rows_decode(evidence_result_rows, result, bytes, size, why);
    if (r != 0)
        return r;
    evidence_clean(&result->evidence);
    clean_worker(&result->worker);
    return 0;
}
