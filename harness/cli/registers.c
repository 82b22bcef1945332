/* SPDX-License-Identifier: GPL-2.0-or-later */
/* tgm registers - the register reference at hand: by part of a name, by memory, by offset. */
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
    if (search->by_offset) {
        const uint64_t in_element = search->offset % line->stride;
        return (strcasecmp(search->memory, line->memory->name) == 0 ||
                strcasecmp(search->memory, line->memory->root) == 0) &&
               search->offset < line->memory->size && in_element >= line->offset &&
               in_element < line->offset + line->size;
    }
    return search->pattern == NULL || strcasestr(line->name, search->pattern) != NULL ||
           strcasecmp(line->memory->name, search->pattern) == 0;
}

static void show(void *argument, const struct catalogue_line *line)
{
    struct search *search = argument;
    if (!matches(search, line))
        return;
    if (search->found++ == 0)
        printf("%-44s %-18s %7s  %-4s %-6s %-8s meaning\n", "register", "memory", "offset", "type",
               "access", "unit");
    printf("%-44s %-18s %7zu  %-4s %-6s %-8s %s\n", line->name, line->memory->name, line->offset,
           scalar_name(line->type), strcmp(line->access, "?") == 0 ? "-" : line->access, line->unit,
           line->note);
}

int command_registers(const struct command *command, int argc, char **argv)
{
    const struct option table[] = { { 0 } };
    struct search search = { 0 };
    int words, status;
    if (!options_read(command, table, argc, argv, &search.pattern, 1, &words, &status))
        return status;
    search.by_offset = read_offset(&search);
    catalogue_walk(show, &search);
    if (search.found > 0)
        return EXIT_OK;
    return complain(command,
                    "nothing matches '%s'; give a part of a name, a memory such as TGM_Servo, or "
                    "TGM_Servo+472",
                    search.pattern);
}
