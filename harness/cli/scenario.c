/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "cli/scenario.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

struct scenario *scenario_from_file(const struct command *command, const char *path,
                                    const struct product *product)
{
    const struct catalogue *catalogue =
        catalogue_find(product->generation, (int)product->memory_id);
    struct scenario *scenario = NULL;
    char why[SCENARIO_WHY];
    char *text = read_text(command, "scenario", path);
    if (text == NULL)
        return NULL;
    if (scenario_read(&scenario, text, strlen(text), path, catalogue, why) != 0)
        complain(command, "%s", why);
    free(text);
    return scenario;
}

int scenario_conclude(FILE *stream, const struct scenario *scenario, const char *path,
                      const struct evidence *evidence)
{
    static const char *const ends[] = { [PLAY_NONE] = "not begun",
                                        [PLAY_RUNNING] = "not played to its end",
                                        [PLAY_DONE] = "played to its end",
                                        [PLAY_GIVEN_UP] = "given up, the rest was not played" };
    char text[SCENARIO_TEXT];
    uint64_t told = 0;
    for (unsigned i = 0; i < evidence->failure_count; i++) {
        scenario_tell(scenario, &evidence->failures[i], text);
        fprintf(stream, "%s (cycle %" PRIu64 ")", text, evidence->failures[i].cycle);
        if (evidence->failures[i].count > 1)
            fprintf(stream, ", %" PRIu64 " times", evidence->failures[i].count);
        fputc('\n', stream);
        told += evidence->failures[i].count;
    }
    if (told < evidence->failed)
        fprintf(stream, "and %" PRIu64 " failures more\n", evidence->failed - told);
    fprintf(stream, "  scenario %s: %s, %" PRIu64 " checks, %" PRIu64 " failed\n", path,
            ends[evidence->play], evidence->checked, evidence->failed);
    return evidence->failed > 0          ? EXIT_MODULE
           : evidence->play == PLAY_DONE ? EXIT_OK
                                         : EXIT_INCOMPLETE;
}
