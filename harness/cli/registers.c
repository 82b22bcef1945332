/* SPDX-License-Identifier: GPL-2.0-or-later */
/* tgm registers - the register reference at hand: by part of a name, by memory, by offset.
 * "(L5)" behind the access: no document states it, decision L5 does. */
#define _GNU_SOURCE 1
#include <stdlib.h>
#include <string.h>

#include "cli/cli.h"
#include "host/catalogue.h"

struct search {
    const char *pattern; /* part of a name or of a memory's name; NULL: everything */
    bool by_offset;      /* "TGM_Servo+472": the register that holds this byte */
    char memory[64];
    uint64_t offset;
    size_t found;
};

static bool read_offset(struct search *search)
{
    const char *plus = search->pattern != NULL ? strchr(search->pattern, '+') : NULL;
    char *end;
    if (plus == NULL || (size_t)(plus - search->pattern) >= sizeof search->memory)
        return false;
    memcpy(search->memory, search->pattern, (size_t)(plus - search->pattern));
    search->offset = strtoull(plus + 1, &end, 0);
    return plus[1] != '\0' && *end == '\0';
}

static bool matches(const struct search *search, const struct catalogue_line *line)
{
    if (search->by_offset)
        return (strcasecmp(search->memory, line->memory->name) == 0 ||
                strcasecmp(search->memory, line->memory->root) == 0) &&
               catalogue_line_holds(line, search->offset);
    return search->pattern == NULL || strcasestr(line->name, search->pattern) != NULL ||
           strcasecmp(line->memory->name, search->pattern) == 0;
}

static void show(void *argument, const struct catalogue_line *line)
{
    struct search *search = argument;
    char access[16];
    if (!matches(search, line))
        return;
    if (search->found++ == 0)
        printf("%-44s %-18s %7s  %-4s %-8s %-8s meaning\n", "register", "memory", "offset", "type",
               "access", "unit");
    snprintf(access, sizeof access, "%s%s", line->access,
             line->access_by == ACCESS_OURS ? " (L5)" : "");
    printf("%-44s %-18s %7zu  %-4s %-8s %-8s %s\n", line->name, line->memory->name, line->offset,
           scalar_name(line->type), access, line->unit, line->note);
}

int command_registers(const struct command *command, int argc, char **argv)
{
    uint64_t generation = 4, memory_id = 0;
    const struct option table[] = {
        { "--generation", OPTION_NUMBER, "N", "of TG Motion: 4 (default) or 5", &generation, 4, 5 },
        { "--memory-id", OPTION_NUMBER, "ID",
          "layout: 904; 905 (5.00), 906 (5.02, the default of 5)", &memory_id, 904, 906 },
        { 0 },
    };
    struct search search = { 0 };
    int words, status;
    if (!options_read(command, table, argc, argv, &search.pattern, 1, &words, &status))
        return status;
    const struct catalogue *catalogue = catalogue_find((int)generation, (int)memory_id);
    if (catalogue == NULL)
        return complain(command, "generation %d has no memory id %d; allowed: %s", (int)generation,
                        (int)memory_id, generation == 4 ? "904" : "905, 906");
    search.by_offset = read_offset(&search);
    catalogue_walk(catalogue, show, &search);
    if (search.found > 0)
        return EXIT_OK;
    return complain(command,
                    "nothing matches '%s'; give a part of a name, a memory such as TGM_Servo, or "
                    "TGM_Servo+472",
                    search.pattern);
}
