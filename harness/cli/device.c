/* SPDX-License-Identifier: GPL-2.0-or-later */
/* tgm device - device types: lists them, checks device files and ESI, turns either into a device
 * file. */
#include <errno.h>
#include <string.h>

#include "bus/library_open.h"
#include "cli/cli.h"

#define FILES_MAX 64

static void list(const struct bus_library *library)
{
    struct library_entry entry;
    for (size_t i = 0; library_get(library, i, &entry); i++)
        printf("%-16s %s\n", entry.name, entry.description);
}

static void show(const struct library_entry *entry)
{
    printf("%s  \"%s\"\n", entry->name, entry->description);
    printf("  identity   vendor 0x%08X product 0x%08X revision 0x%08X\n", entry->vendor,
           entry->product, entry->revision);
    printf("  name       %s, order code %s\n", entry->device_name, entry->order);
    printf("  outputs    %u bits, %u channels\n", entry->output_bits, entry->outputs);
    printf("  inputs     %u bits, %u channels\n", entry->input_bits, entry->inputs);
    if (entry->mailbox > 0)
        printf("  mailbox    %u bytes\n", entry->mailbox);
    if (entry->objects > 0)
        printf("  CoE        %u objects\n", entry->objects);
}

static bool find_built_in(const struct bus_library *library, const char *name,
                          struct library_entry *entry)
{
    for (size_t i = library_file_types(library); library_get(library, i, entry); i++)
        if (strcmp(entry->name, name) == 0)
            return true;
    return false;
}

static int show_one(const struct command *command, struct bus_library *library, const char *word)
{
    const size_t before = library_file_types(library);
    struct library_entry entry;
    char why[LIBRARY_WHY];
    if (find_built_in(library, word, &entry)) {
        show(&entry);
        return EXIT_OK;
    }
    if (library_load(library, word, why) != 0) {
        complain(command, "%s", why);
        return EXIT_MODULE;
    }
    for (size_t i = before; i < library_file_types(library) && library_get(library, i, &entry); i++)
        show(&entry);
    return EXIT_OK;
}

static int convert(const struct command *command, const char *source, const char *path)
{
    char why[LIBRARY_WHY];
    struct output output;
    int r = output_open(&output, path);
    if (r != 0)
        return complain(command, "cannot write %s: %s", path, strerror(-r));
    r = library_convert(source, output.stream, why);
    const int closed = output_close(&output, r == 0);
    if (r != 0) {
        complain(command, "%s", why);
        return EXIT_MODULE;
    }
    return closed == 0 ? EXIT_OK
                       : complain(command, "cannot write %s: %s", path, strerror(-closed));
}

int command_device(const struct command *command, int argc, char **argv)
{
    const char *words[FILES_MAX], *source = NULL, *to = "-";
    struct bus_library *library;
    int count, status;
    const struct option table[] = {
        { "--convert", OPTION_TEXT, "SOURCE",
          "writes a device file of it: FILE.xml#TYPE, FILE.device or a built-in terminal", &source,
          0, 0 },
        { "--to", OPTION_TEXT, "FILE", "where --convert writes to (default: standard output)", &to,
          0, 0 },
        { 0 },
    };
    if (!options_read(command, table, argc, argv, words, FILES_MAX, &count, &status))
        return status;
    if (source != NULL && count > 0)
        return complain(command, "--convert takes one source; '%s' is too much", words[0]);
    if (source != NULL)
        return convert(command, source, to);
    if (library_open(&library) != 0)
        return complain(command, "no memory");
    status = EXIT_OK;
    for (int i = 0; i < count; i++)
        if (show_one(command, library, words[i]) != EXIT_OK)
            status = EXIT_MODULE;
    if (count == 0)
        list(library);
    library_close(library);
    return status;
}
