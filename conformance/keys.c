/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/keys.h"

#include <errno.h>
#include <fcntl.h>
#include <sodium.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "image/sha256.h"

_Static_assert(KEY_PUBLIC == crypto_sign_PUBLICKEYBYTES, "Ed25519");
_Static_assert(KEY_SECRET == crypto_sign_SECRETKEYBYTES, "Ed25519");
_Static_assert(KEY_ID == 2 * crypto_hash_sha256_BYTES + 1, "SHA-256");

/* What stands before the 32 bytes of an Ed25519 key in DER (RFC 8410): always the same. */
struct pem {
    const char *label;
    const unsigned char *head;
    size_t head_size;
};
static const unsigned char secret_head[] = { 0x30, 0x2E, 0x02, 0x01, 0x00, 0x30, 0x05, 0x06,
                                             0x03, 0x2B, 0x65, 0x70, 0x04, 0x22, 0x04, 0x20 };
static const unsigned char public_head[] = { 0x30, 0x2A, 0x30, 0x05, 0x06, 0x03,
                                             0x2B, 0x65, 0x70, 0x03, 0x21, 0x00 };
static const struct pem secret_pem = { "PRIVATE KEY", secret_head, sizeof secret_head };
static const struct pem public_pem = { "PUBLIC KEY", public_head, sizeof public_head };

#define KEY_BYTES 32
#define DER_MOST  (sizeof secret_head + KEY_BYTES)
#define PEM_MOST  256

/* The only text that such a key has: whatever differs from it is none. */
static size_t write_pem(const struct pem *pem, const unsigned char key[KEY_BYTES],
                        char text[PEM_MOST])
{
    unsigned char der[DER_MOST];
    char base64[sodium_base64_ENCODED_LEN(DER_MOST, sodium_base64_VARIANT_ORIGINAL)];
    memcpy(der, pem->head, pem->head_size);
    memcpy(der + pem->head_size, key, KEY_BYTES);
    sodium_bin2base64(base64, sizeof base64, der, pem->head_size + KEY_BYTES,
                      sodium_base64_VARIANT_ORIGINAL);
    const int length = snprintf(text, PEM_MOST, "-----BEGIN %s-----\n%s\n-----END %s-----\n",
                                pem->label, base64, pem->label);
    sodium_memzero(der, sizeof der);
    sodium_memzero(base64, sizeof base64);
    return (size_t)length;
}

static bool read_pem(const struct pem *pem, const char *text, size_t size,
                     unsigned char key[KEY_BYTES])
{
    unsigned char der[DER_MOST];
    char again[PEM_MOST], begin[40];
    size_t length;
    bool good = false;
    const size_t at = (size_t)snprintf(begin, sizeof begin, "-----BEGIN %s-----\n", pem->label);
    const size_t der_size = pem->head_size + KEY_BYTES;
    const size_t encoded = sodium_base64_encoded_len(der_size, sodium_base64_VARIANT_ORIGINAL) - 1;
    if (size >= at + encoded && memcmp(text, begin, at) == 0 &&
        sodium_base642bin(der, der_size, text + at, encoded, NULL, &length, NULL,
                          sodium_base64_VARIANT_ORIGINAL) == 0 &&
        length == der_size) {
        memcpy(key, der + pem->head_size, KEY_BYTES);
        good = write_pem(pem, key, again) == size && sodium_memcmp(again, text, size) == 0;
    }
    sodium_memzero(der, sizeof der);
    sodium_memzero(again, sizeof again);
    return good;
}

static void name_key(struct public_key *key)
{
    sha256_text(key->bytes, sizeof key->bytes, key->id);
}

bool keys_parse_public(struct public_key *key, const char *text, size_t size)
{
    if (!read_pem(&public_pem, text, size, key->bytes))
        return false;
    name_key(key);
    return true;
}

bool keys_parse_secret(struct secret_key *key, const char *text, size_t size)
{
    unsigned char seed[KEY_BYTES];
    const bool good = read_pem(&secret_pem, text, size, seed);
    if (good) {
        crypto_sign_seed_keypair(key->public_half.bytes, key->bytes, seed);
        name_key(&key->public_half);
    }
    sodium_memzero(seed, sizeof seed);
    return good;
}

void keys_forget(struct secret_key *key)
{
    sodium_memzero(key, sizeof *key);
}

static int refuse(char why[KEYS_WHY], const char *path, int error, const char *what)
{
    snprintf(why, KEYS_WHY, "%s: %s", path, what);
    return error;
}

/* -1 and errno, or a new file that did not exist. */
static int write_new(const char *path, const char *text, size_t size, mode_t mode)
{
    const int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode);
    if (fd < 0)
        return -1;
    const bool written = write(fd, text, size) == (ssize_t)size && fsync(fd) == 0;
    const int error = errno != 0 ? errno : EIO;
    if (close(fd) == 0 && written)
        return 0;
    unlink(path);
    errno = error;
    return -1;
}

int keys_make(const char *secret_path, const char *public_path, struct public_key *made,
              char why[KEYS_WHY])
{
    struct secret_key key;
    char secret_text[PEM_MOST], public_text[PEM_MOST];
    if (sodium_init() < 0)
        return refuse(why, secret_path, -EIO, "no source of randomness");
    crypto_sign_keypair(key.public_half.bytes, key.bytes);
    name_key(&key.public_half);
    *made = key.public_half;
    const size_t secret_size = write_pem(&secret_pem, key.bytes, secret_text);
    const size_t public_size = write_pem(&public_pem, made->bytes, public_text);
    keys_forget(&key);
    int r = 0;
    errno = 0;
    if (write_new(secret_path, secret_text, secret_size, 0600) != 0) {
        r = refuse(why, secret_path, -errno, strerror(errno));
    } else if (write_new(public_path, public_text, public_size, 0644) != 0) {
        r = refuse(why, public_path, -errno, strerror(errno));
        unlink(secret_path);
    }
    sodium_memzero(secret_text, sizeof secret_text);
    return r;
}

/* The whole file, and what it is; at most PEM_MOST bytes of it, more than any key has. */
static int read_file(const char *path, char text[PEM_MOST], size_t *size, struct stat *s,
                     char why[KEYS_WHY])
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    ssize_t got = -1;
    if (fd < 0)
        return refuse(why, path, -errno, strerror(errno));
    if (fstat(fd, s) == 0 && S_ISREG(s->st_mode))
        got = read(fd, text, PEM_MOST);
    close(fd);
    if (got < 0)
        return refuse(why, path, -EINVAL, "is no file that can be read");
    *size = (size_t)got;
    return 0;
}

int keys_read_secret(struct secret_key *key, const char *path, char why[KEYS_WHY])
{
    char text[PEM_MOST];
    size_t size = 0;
    struct stat s;
    int r = sodium_init() < 0 ? refuse(why, path, -EIO, "no source of randomness")
                              : read_file(path, text, &size, &s, why);
    if (r == 0 && (s.st_mode & (S_IRWXG | S_IRWXO)) != 0)
        r = refuse(why, path, -EPERM,
                   "others than its owner may use this secret key; chmod 600 it, and make a new "
                   "one if it ever lay open");
    if (r == 0 && !keys_parse_secret(key, text, size))
        r = refuse(why, path, -EINVAL, "is no secret key (tgm keygen makes one)");
    sodium_memzero(text, sizeof text);
    return r;
}

int keys_read_public(struct public_key *key, const char *path, char why[KEYS_WHY])
{
    char text[PEM_MOST];
    size_t size = 0;
    struct stat s;
    const int r = read_file(path, text, &size, &s, why);
    if (r != 0)
        return r;
    if (keys_parse_public(key, text, size))
        return 0;
    struct secret_key secret;
    const bool wrong_half = keys_parse_secret(&secret, text, size);
    keys_forget(&secret);
    return refuse(why, path, -EINVAL,
                  wrong_half ? "is a secret key; --key takes the public one here"
                             : "is no public key (tgm keygen makes one)");
}
