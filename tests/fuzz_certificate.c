/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Any bytes as a certificate, as what a certificate signs, and as a key file. The first byte
 * chooses. What is accepted must be what writing it again gives.
 */
#include <sodium.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "conformance/certificate.h"

static struct secret_key key;
static struct certificate certificate;

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
}

/* Past the signature: the key's owner signs anything. */
static void open_signed(const char *payload, size_t size)
{
    char *text = envelope_seal("application/vnd.in-toto+json", payload, size, &key);
    if (text != NULL)
        open_any(text, strlen(text));
    free(text);
}

static void parse_keys(const char *text, size_t size)
{
    struct public_key public_half;
    struct secret_key secret;
    keys_parse_public(&public_half, text, size);
    keys_parse_secret(&secret, text, size);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static void (*const ways[])(const char *, size_t) = { open_any, open_signed, parse_keys };
    if (key.public_half.id[0] == '\0')
        make_key();
    if (size > 0)
        ways[data[0] % 3]((const char *)data + 1, size - 1);
    return 0;
}
