/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * keys.h - Ed25519 keys in files, in the form that other tools (openssl) read and write, too: PEM
 * of PKCS #8 for the secret one, of SubjectPublicKeyInfo for the public one.
 */
#ifndef CONFORMANCE_KEYS_H
#define CONFORMANCE_KEYS_H

#include <stdbool.h>
#include <stddef.h>

#define KEYS_WHY 256

/* Sizes of libsodium's Ed25519, in bytes. */
#define KEY_PUBLIC 32
#define KEY_SECRET 64 /* seed and public half */

/* SHA-256 of the public half, as a string: what a certificate names its key by. */
#define KEY_ID 65

struct public_key {
    unsigned char bytes[KEY_PUBLIC];
    char id[KEY_ID];
};

struct secret_key {
    unsigned char bytes[KEY_SECRET];
    struct public_key public_half;
};

/* All return 0 or negative errno with a sentence in why. */

/* A new pair in two new files, the secret one for its owner's eyes only. -EEXIST when one of the
 * files is there already; then, as after any other error, neither is written. */
int keys_make(const char *secret_path, const char *public_path, struct public_key *made,
              char why[KEYS_WHY]);

/* -EPERM when others than the owner may read the file. Forget it with keys_forget(). */
int keys_read_secret(struct secret_key *key, const char *path, char why[KEYS_WHY]);
int keys_read_public(struct public_key *key, const char *path, char why[KEYS_WHY]);
void keys_forget(struct secret_key *key);

/* The same from bytes: false when they are no such key, to the byte. */
bool keys_parse_secret(struct secret_key *key, const char *text, size_t size);
bool keys_parse_public(struct public_key *key, const char *text, size_t size);

#endif
