/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The line that shows a finding again. */
#include "conformance/check_parts.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* A file name as a shell takes it. */
static void shell_word(const char *text, char *out, size_t size)
{
    static const char harmless[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./+=:,@%";
    if (text[0] != '\0' && text[strspn(text, harmless)] == '\0') {
        snprintf(out, size, "%s", text);
        return;
    }
    size_t at = 0;
    out[at++] = '\'';
    for (; *text != '\0' && at + 6 < size; text++)
        if (*text == '\'')
            at += (size_t)snprintf(out + at, size - at, "'\\''");
        else
            out[at++] = *text;
    out[at++] = '\'';
    out[at] = '\0';
}

/* All of them, or no line: half of it would be another call. */
static void add_scenarios(const struct check_options *options, struct finding *finding, size_t at)
{
    char path[FINDING_TEXT];
    for (size_t i = 0; i < options->scenario_count; i++) {
        const char *given = options->scenarios[i].path;
        shell_word(given, path, sizeof path);
        if (strlen(given) * 4 + 8 > sizeof path ||
            at + strlen(path) + 12 >= sizeof finding->again) {
            finding->again[0] = '\0';
            return;
        }
        at += (size_t)snprintf(finding->again + at, sizeof finding->again - at, " --scenario %s",
                               path);
    }
}

void check_add_reproduction(const struct check_options *options, const struct rule *rule,
                            struct finding *finding)
{
    char path[FINDING_TEXT / 2];
    if (rule->experiments == NO_EXPERIMENT)
        return;
    char dashed[FINDING_TEXT / 2];
    if (strlen(options->path) * 4 + 8 > sizeof path)
        return; /* a path that does not fit would name another file */
    snprintf(dashed, sizeof dashed, "%s%s", options->path[0] == '-' ? "./" : "", options->path);
    shell_word(dashed, path, sizeof path);
    int at = snprintf(finding->again, sizeof finding->again,
                      "tgm check %s --rule %s --seed 0x%" PRIx64, path, rule->id, options->seed);
    if (strcmp(options->profile->name, "pc4") != 0 && at < FINDING_TEXT)
        at += snprintf(finding->again + at, (size_t)(FINDING_TEXT - at), " --profile %s",
                       options->profile->name);
    if (options->around_path != NULL && at < FINDING_TEXT) {
        if (strlen(options->around_path) * 4 + 8 > sizeof path) {
            finding->again[0] = '\0';
            return;
        }
        shell_word(options->around_path, path, sizeof path);
        at += snprintf(finding->again + at, (size_t)(FINDING_TEXT - at), " --config %s", path);
    }
    if (rule->experiments == ON_SCENARIOS) {
        add_scenarios(options, finding, (size_t)at);
        return;
    }
    if (finding->has_cycle && at < FINDING_TEXT)
        snprintf(finding->again + at, (size_t)(FINDING_TEXT - at), " --cycles %" PRIu64,
                 finding->cycle + 1);
}
