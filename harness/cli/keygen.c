/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "cli/cli.h"
#include "conformance/keys.h"

#define PATH_MOST 4096

int command_keygen(const struct command *command, int argc, char **argv)
{
    const struct option table[] = { { 0 } };
    const char *name = NULL;
    char secret[PATH_MOST], half[PATH_MOST], why[KEYS_WHY];
    struct public_key made;
    int words, status;
    if (!options_read(command, table, argc, argv, &name, 1, &words, &status))
        return status;
    if (words == 0)
        return complain(command, "which name? usage: tgm keygen %s", command->usage);
    if (snprintf(secret, sizeof secret, "%s.key", name) >= (int)sizeof secret ||
        snprintf(half, sizeof half, "%s.pub", name) >= (int)sizeof half)
        return complain(command, "the name is too long");
    if (keys_make(secret, half, &made, why) != 0)
        return complain(command, "%s", why);
    printf("%s  the secret key: whoever has it can sign; keep it off the network, and a copy in a "
           "safe\n"
           "%s  the public key: give it to everybody who verifies\n"
           "key id %s\n",
           secret, half, made.id);
    return EXIT_OK;
}
