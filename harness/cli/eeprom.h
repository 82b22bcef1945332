/* SPDX-License-Identifier: GPL-2.0-or-later */
/* eeprom.h - the EEPROM of TG Motion as a file (Eeprom.bin): bytes of EEPROM.Data, no head. */
#ifndef HARNESS_CLI_EEPROM_H
#define HARNESS_CLI_EEPROM_H

#include "cli/cli.h"
#include "host/host.h"

struct eeprom_file {
    const char *path; /* NULL: none */
    unsigned char data[EVIDENCE_EEPROM];
};

/* What is in the file goes to the host; a file that does not exist is one that was never saved. 0,
 * or EXIT_CALL with the reason said: not readable, empty or longer than the area. */
int eeprom_read(const struct command *command, struct eeprom_file *file, struct host_config *host);

/* Writes the file anew if the module saved something. 0, or EXIT_CALL with the reason said. */
int eeprom_write(const struct command *command, const struct eeprom_file *file,
                 const struct evidence *evidence);

#endif
