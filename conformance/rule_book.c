/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/rule_book.h"

#include <inttypes.h>
#include <sodium.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules.h"

/* The tables as they stand in their files, white space aside. */
static const char *const lines[] = {
#define RULE(...) "RULE " #__VA_ARGS__,
#include "conformance/rules.def"
#undef RULE
#define EXPERIMENT(...) "EXPERIMENT " #__VA_ARGS__,
#include "conformance/experiments.def"
#undef EXPERIMENT
#define PROFILE(...) "PROFILE " #__VA_ARGS__,
#include "conformance/profiles/pc4.def"
#include "conformance/profiles/pc500.def"
#include "conformance/profiles/pc5.def"
#include "conformance/profiles/tgmmini.def"
#include "conformance/profiles/tgmcontroller.def"
#include "conformance/profiles/tgzmotion.def"
#undef PROFILE
};

static void add(crypto_hash_sha256_state *state, const char *text)
{
    crypto_hash_sha256_update(state, (const unsigned char *)text, strlen(text) + 1);
}

void rule_book_hash(char hash[RULE_BOOK_HASH])
{
    crypto_hash_sha256_state state;
    unsigned char digest[crypto_hash_sha256_BYTES];
    char set[32];
    crypto_hash_sha256_init(&state);
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++)
        add(&state, lines[i]);
    /* The sets that rules name are made in rules.h. */
    for (size_t i = 0; rule_at(i) != NULL; i++) {
        snprintf(set, sizeof set, "%" PRIx64, rule_at(i)->experiments);
        add(&state, set);
    }
    crypto_hash_sha256_final(&state, digest);
    sodium_bin2hex(hash, RULE_BOOK_HASH, digest, sizeof digest);
}
