/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Any bytes as a certificate, as what a certificate signs, as the parts of an envelope, and as a
 * key file; the first byte chooses. What is accepted must be what writing it again gives.
 *
 * Signing takes a hundred times as long as all the rest: a quick hash stands in for it, so that
 * what lies behind a signature that holds is looked at as often as what lies in front.
 */
#include <sodium.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "conformance/certificate.h"
#include "fuzz_json.h"

#define TYPE "application/vnd.in-toto+json"

static struct secret_key key;
static struct certificate certificate;
static unsigned long long inputs, certificates, keys;

/* --- signatures that are none ----------------------------------------------------------------- */

static void mark(unsigned char out[crypto_sign_BYTES], const unsigned char *bytes,
                 unsigned long long size, const unsigned char *public_half)
{
    uint64_t hash = UINT64_C(0xcbf29ce484222325) ^ public_half[0];
    for (unsigned long long i = 0; i < size; i++)
        hash = (hash ^ bytes[i]) * UINT64_C(0x100000001b3);
    for (size_t i = 0; i < crypto_sign_BYTES; i++)
        out[i] = (unsigned char)(hash >> 8 * (i % 8)) ^ (unsigned char)i;
}

int crypto_sign_detached(unsigned char *signature, unsigned long long *length,
                         const unsigned char *bytes, unsigned long long size,
                         const unsigned char *secret)
{
    mark(signature, bytes, size, secret + crypto_sign_SEEDBYTES);
    if (length != NULL)
        *length = crypto_sign_BYTES;
    return 0;
}

int crypto_sign_verify_detached(const unsigned char *signature, const unsigned char *bytes,
                                unsigned long long size, const unsigned char *public_half)
{
    unsigned char right[crypto_sign_BYTES];
    mark(right, bytes, size, public_half);
    return memcmp(right, signature, sizeof right) == 0 ? 0 : -1;
}

/* --- inputs ----------------------------------------------------------------------------------- */

static void make_key(void)
{
    static const unsigned char seed[crypto_sign_SEEDBYTES] = "a key that everybody knows";
    unsigned char hash[crypto_hash_sha256_BYTES];
    struct public_key *half = &key.public_half;
    crypto_sign_seed_keypair(half->bytes, key.bytes, seed);
    crypto_hash_sha256(hash, half->bytes, sizeof half->bytes);
    sodium_bin2hex(half->id, sizeof half->id, hash, sizeof hash);
}

static void open_any(const char *text, size_t size)
{
    char why[CERTIFICATE_WHY] = "";
    const int r = certificate_open(&certificate, text, size, &key.public_half, why);
    if ((r == 0) != (why[0] == '\0') || strlen(why) >= sizeof why)
        abort();
    if (r != 0)
        return;
    char *again = certificate_sign(&certificate, &key);
    if (again == NULL || strlen(again) != size || memcmp(again, text, size) != 0)
        abort();
    free(again);
    certificates++;
}

static void open_sealed(const char *type, const char *payload, size_t size,
                        const struct secret_key *by)
{
    char *text = envelope_seal(type, payload, size, by);
    if (text != NULL)
        open_any(text, strlen(text));
    free(text);
}

/* Past the signature: the key's owner signs anything. */
static void open_signed(const char *payload, size_t size)
{
    open_sealed(TYPE, payload, size, &key);
}

/* Up to the next line end, without it. */
static void take_line(const char **text, size_t *size, char *line, size_t room)
{
    const char *end = memchr(*text, '\n', *size);
    const size_t whole = end != NULL ? (size_t)(end - *text) : *size;
    const size_t length = whole < room ? whole : room - 1;
    memcpy(line, *text, length);
    line[length] = '\0';
    *text += whole + (end != NULL);
    *size -= whole + (end != NULL);
}

/* A line that is its type, one that names the key, and what is signed. */
static void open_parts(const char *text, size_t size)
{
    struct secret_key by = key;
    char type[64];
    take_line(&text, &size, type, sizeof type);
    take_line(&text, &size, by.public_half.id, sizeof by.public_half.id);
    open_sealed(type, text, size, &by);
}

static void parse_keys(const char *text, size_t size)
{
    struct public_key public_half;
    struct secret_key secret;
    keys += keys_parse_public(&public_half, text, size);
    keys += keys_parse_secret(&secret, text, size);
}

static void say_what_was_seen(void)
{
    fprintf(stderr, "%llu inputs: %llu certificates, %llu keys\n", inputs, certificates, keys);
}

int LLVMFuzzerInitialize(int *argument_count, char ***arguments);
int LLVMFuzzerInitialize(int *argument_count, char ***arguments)
{
    (void)argument_count;
    (void)arguments;
    make_key();
    return atexit(say_what_was_seen);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static void (*const ways[])(const char *, size_t) = { open_any, open_signed, open_parts,
                                                          parse_keys };
    inputs++;
    if (size > 0)
        ways[data[0] % 4]((const char *)data + 1, size - 1);
    return 0;
}
