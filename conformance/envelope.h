/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * envelope.h - signed bytes: a DSSE envelope (Dead Simple Signing Envelope, version 1) with one
 * Ed25519 signature.
 *
 * There is exactly one text for a payload, a type and a signature; what differs from it in a single
 * byte is no envelope, also where the difference would not touch the signature.
 */
#ifndef CONFORMANCE_ENVELOPE_H
#define CONFORMANCE_ENVELOPE_H

#include <stddef.h>

#include "conformance/keys.h"

#define ENVELOPE_WHY  512
#define ENVELOPE_MOST 1048576 /* bytes of an envelope */

/* The envelope as a string, to be freed; NULL when there is no memory. */
char *envelope_seal(const char *type, const void *payload, size_t size,
                    const struct secret_key *key);

/* The payload of an envelope of this type that the key has signed, to be freed, a zero byte behind
 * it; NULL with a sentence in why. The text may be anything. */
char *envelope_open(const char *type, const char *text, size_t size, const struct public_key *key,
                    size_t *payload_size, char why[ENVELOPE_WHY]);

#endif
