/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "cli/scope.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int scope_read_trigger(const struct command *command, const struct catalogue *catalogue,
                       const char *text, struct host_osc *osc)
{
    char name[128], edge[16], level[64], rest[2], why[CATALOGUE_WHY], *end;
    if (sscanf(text, "%127s %15s %63s %1s", name, edge, level, rest) != 3)
        return complain(command,
                        "--osc-trigger needs register, rising or falling, and level, as in "
                        "'DIO[0].In0 rising 0.5', not '%s'",
                        text);
    if (catalogue_resolve(catalogue, name, &osc->trigger, why) != 0)
        return complain(command, "--osc-trigger: %s", why);
    osc->falling = strcmp(edge, "falling") == 0;
    if (!osc->falling && strcmp(edge, "rising") != 0)
        return complain(command, "--osc-trigger: the edge is rising or falling, not '%s'", edge);
    osc->level = strtod(level, &end);
    if (*end != '\0' || !isfinite(osc->level))
        return complain(command, "--osc-trigger: the level is a number, not '%s'", level);
    osc->triggered = true;
    return 0;
}
