/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "cli/program.h"

#include <errno.h>
#include <sodium.h>
#include <stdbool.h>
#include <stdio.h>
#include <sys/stat.h>

int file_hash(const char *path, char hash[FILE_HASH])
{
    unsigned char block[65536], digest[crypto_hash_sha256_BYTES];
    crypto_hash_sha256_state state;
    struct stat s;
    if (stat(path, &s) != 0)
        return -errno;
    if (!S_ISREG(s.st_mode))
        return S_ISDIR(s.st_mode) ? -EISDIR : -EINVAL;
    FILE *file = fopen(path, "rb");
    if (file == NULL)
        return -errno;
    crypto_hash_sha256_init(&state);
    for (size_t size; (size = fread(block, 1, sizeof block, file)) > 0;)
        crypto_hash_sha256_update(&state, block, size);
    const bool bad = ferror(file);
    fclose(file);
    crypto_hash_sha256_final(&state, digest);
    sodium_bin2hex(hash, FILE_HASH, digest, sizeof digest);
    return bad ? -EIO : 0;
}

int program_hash(char hash[FILE_HASH])
{
    return file_hash("/proc/self/exe", hash);
}
