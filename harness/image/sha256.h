/* SPDX-License-Identifier: GPL-2.0-or-later */
/* sha256.h - SHA-256 as reports, certificates and evidence write it. */
#ifndef HARNESS_IMAGE_SHA256_H
#define HARNESS_IMAGE_SHA256_H

#include <sodium.h>
#include <stddef.h>

/* 64 hexadecimal digits and a zero. */
#define SHA256_TEXT (2 * crypto_hash_sha256_BYTES + 1)

static inline void sha256_text(const void *bytes, size_t size, char text[SHA256_TEXT])
{
    unsigned char digest[crypto_hash_sha256_BYTES];
    crypto_hash_sha256(digest, bytes, size);
    sodium_bin2hex(text, SHA256_TEXT, digest, sizeof digest);
}

#endif
