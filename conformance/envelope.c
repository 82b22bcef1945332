/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/envelope.h"

#include <jansson.h>
#include <sodium.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BASE64 sodium_base64_VARIANT_ORIGINAL

struct signature {
    unsigned char bytes[crypto_sign_BYTES];
};

/* What is signed: type and payload with their lengths, so that neither can be taken for a part of
 * the other ("PAE" of DSSE). To be freed. */
static char *signed_bytes(const char *type, const void *payload, size_t size, size_t *total)
{
    const size_t head_most = strlen(type) + 64;
    char *bytes = malloc(head_most + size);
    if (bytes == NULL)
        return NULL;
    const size_t head =
        (size_t)snprintf(bytes, head_most, "DSSEv1 %zu %s %zu ", strlen(type), type, size);
    memcpy(bytes + head, payload, size);
    *total = head + size;
    return bytes;
}

static json_t *base64(const void *data, size_t size)
{
    const size_t room = sodium_base64_encoded_len(size, BASE64);
    char *text = malloc(room);
    if (text == NULL)
        return NULL;
    json_t *string = json_string(sodium_bin2base64(text, room, data, size, BASE64));
    free(text);
    return string;
}

/* The one text. */
static char *write_envelope(const char *type, const void *payload, size_t size, const char *key_id,
                            const struct signature *signature)
{
    json_t *root = json_pack("{s:o, s:s, s:[{s:s, s:o}]}", "payload", base64(payload, size),
                             "payloadType", type, "signatures", "keyid", key_id, "sig",
                             base64(signature->bytes, sizeof signature->bytes));
    char *compact = json_dumps(root, JSON_COMPACT | JSON_SORT_KEYS);
    json_decref(root);
    if (compact == NULL)
        return NULL;
    const size_t length = strlen(compact);
    char *text = realloc(compact, length + 2);
    if (text == NULL) {
        free(compact);
        return NULL;
    }
    memcpy(text + length, "\n", 2);
    return text;
}

char *envelope_seal(const char *type, const void *payload, size_t size,
                    const struct secret_key *key)
{
    struct signature signature;
    size_t total;
    char *bytes = signed_bytes(type, payload, size, &total);
    if (bytes == NULL)
        return NULL;
    crypto_sign_detached(signature.bytes, NULL, (unsigned char *)bytes, total, key->bytes);
    free(bytes);
    return write_envelope(type, payload, size, key->public_half.id, &signature);
}

/* The bytes of a base64 string, to be freed; NULL when it is none. */
static void *unpack(const json_t *string, size_t *size)
{
    const char *text = json_string_value(string);
    const size_t length = json_string_length(string);
    unsigned char *bytes = text != NULL ? malloc(length + 1) : NULL;
    if (bytes == NULL)
        return NULL;
    if (sodium_base642bin(bytes, length + 1, text, length, NULL, size, NULL, BASE64) != 0) {
        free(bytes);
        return NULL;
    }
    bytes[*size < length ? *size : length] = 0;
    return bytes;
}

static bool read_signature(const json_t *entry, struct signature *signature)
{
    size_t size = 0;
    void *bytes = unpack(json_object_get(entry, "sig"), &size);
    const bool good = bytes != NULL && size == sizeof signature->bytes;
    if (good)
        memcpy(signature->bytes, bytes, size);
    free(bytes);
    return good;
}

static bool is_signed(const char *type, const void *payload, size_t size,
                      const struct signature *signature, const struct public_key *key)
{
    size_t total;
    char *bytes = signed_bytes(type, payload, size, &total);
    const bool good =
        bytes != NULL && crypto_sign_verify_detached(signature->bytes, (unsigned char *)bytes,
                                                     total, key->bytes) == 0;
    free(bytes);
    return good;
}

/* A sentence when the envelope does not hold, NULL when it does. */
static const char *fault_of(const char *type, const json_t *root, const char *text, size_t size,
                            const struct public_key *key, const void *payload, size_t payload_size)
{
    const json_t *entry = json_array_get(json_object_get(root, "signatures"), 0);
    const char *stated = json_string_value(json_object_get(root, "payloadType"));
    const char *key_id = json_string_value(json_object_get(entry, "keyid"));
    struct signature signature;
    if (stated == NULL || key_id == NULL || payload == NULL || !read_signature(entry, &signature))
        return "it is no signed statement";
    if (strcmp(stated, type) != 0)
        return "what it signs is of another kind";
    if (strcmp(key_id, key->id) != 0)
        return "it names another key as its signer";
    if (!is_signed(type, payload, payload_size, &signature, key))
        return "the signature does not fit: something in it was changed, or another key signed it";
    char *only = write_envelope(type, payload, payload_size, key->id, &signature);
    const bool same = only != NULL && strlen(only) == size && memcmp(only, text, size) == 0;
    free(only);
    return same ? NULL : "it was changed after it was signed";
}

char *envelope_open(const char *type, const char *text, size_t size, const struct public_key *key,
                    size_t *payload_size, char why[ENVELOPE_WHY])
{
    json_error_t error;
    *payload_size = 0;
    json_t *root =
        size <= ENVELOPE_MOST ? json_loadb(text, size, JSON_REJECT_DUPLICATES, &error) : NULL;
    if (root == NULL) {
        snprintf(why, ENVELOPE_WHY, "it is no signed statement");
        return NULL;
    }
    char *payload = unpack(json_object_get(root, "payload"), payload_size);
    const char *fault = fault_of(type, root, text, size, key, payload, *payload_size);
    json_decref(root);
    if (fault == NULL)
        return payload;
    free(payload);
    snprintf(why, ENVELOPE_WHY, "%s", fault);
    return NULL;
}
