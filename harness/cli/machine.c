/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "cli/machine.h"

#include <string.h>

static bool asks_for_native(const char *text)
{
    return text != NULL && strcmp(text, "native") == 0;
}

int machine_read(const struct command *command, const char *text, struct experiment *experiment)
{
    experiment->instrumented = text != NULL && strcmp(text, "instrumented") == 0;
    if (text == NULL || experiment->instrumented || asks_for_native(text))
        return 0;
    return complain(command, "--machine must be native or instrumented, not '%s'", text);
}

int machine_check(const struct command *command, const char *text, const struct image *image,
                  const struct experiment *experiment)
{
    char why[MACHINE_WHY];
    if (asks_for_native(text) && machine_fits(image, MACHINE_NATIVE, why) != 0)
        return complain(command, "--machine native: %s", why);
    if (experiment->instrumented && machine_fits(image, MACHINE_INSTRUMENTED, why) != 0)
        return complain(command, "--machine instrumented: %s", why);
    return 0;
}
