/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "cli/eeprom.h"

#include <errno.h>
#include <string.h>

int eeprom_read(const struct command *command, struct eeprom_file *file, struct host_config *host)
{
    if (file->path == NULL)
        return 0;
    FILE *stream = fopen(file->path, "rb");
    if (stream == NULL && errno == ENOENT)
        return 0;
    if (stream == NULL)
        return complain(command, "cannot read EEPROM '%s': %s", file->path, strerror(errno));
    const size_t size = fread(file->data, 1, sizeof file->data, stream);
    const bool more = fgetc(stream) != EOF, failed = ferror(stream) != 0;
    fclose(stream);
    if (failed)
        return complain(command, "cannot read EEPROM '%s'", file->path);
    if (size == 0 || more)
        return complain(command, "EEPROM '%s' must have 1 to %d bytes", file->path,
                        EVIDENCE_EEPROM);
    host->eeprom = file->data;
    host->eeprom_size = size;
    return 0;
}

int eeprom_write(const struct command *command, const struct eeprom_file *file,
                 const struct evidence *evidence)
{
    struct output output = { 0 };
    if (file->path == NULL || !evidence->eeprom.saved)
        return 0;
    int r = output_open(&output, file->path);
    if (r == 0) {
        const size_t size = evidence->eeprom.size;
        const bool written = fwrite(evidence->eeprom.data, 1, size, output.stream) == size;
        r = output_close(&output, written);
        if (r == 0 && !written)
            r = -EIO;
    }
    return r == 0 ? 0 : complain(command, "cannot write EEPROM '%s': %s", file->path, strerror(-r));
}
