/* SPDX-License-Identifier: GPL-2.0-or-later */
/* program.h - hashes of files, this program's own among them. */
#ifndef HARNESS_CLI_PROGRAM_H
#define HARNESS_CLI_PROGRAM_H

#define FILE_HASH 65

/* SHA-256 of the file as lower-case hexadecimal. 0 or negative errno. */
int file_hash(const char *path, char hash[FILE_HASH]);
/* Of the program that runs. */
int program_hash(char hash[FILE_HASH]);

#endif
