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

/* Where a debugger can be at it: the run itself, in one process, up to the cycle. */
static void add_debugger(const struct check_options *options, const char *module,
                         struct finding *finding)
{
    char path[FINDING_TEXT / 2] = "";
    const uint64_t cycles = finding->has_cycle ? finding->cycle + 1 : 1;
    if (finding->plain_us == 0 ||
        (options->around_path != NULL && strlen(options->around_path) * 4 + 8 > sizeof path))
        return;
    if (options->around_path != NULL)
        shell_word(options->around_path, path, sizeof path);
    else
        snprintf(path, sizeof path, "%" PRIu32, finding->plain_us);
    const int length =
        snprintf(finding->debug, sizeof finding->debug,
                 "gdb -ex run --args tgm run %s --in-process --seed 0x%" PRIx64 " --for %" PRIu64
                 "us %s %s%s%s",
                 module, options->seed, cycles * finding->plain_us,
                 options->around_path != NULL ? "--config" : "--cycle", path,
                 strcmp(options->profile->name, "pc4") != 0 ? " --profile " : "",
                 strcmp(options->profile->name, "pc4") != 0 ? options->profile->name : "");
    if ((size_t)length >= sizeof finding->debug)
        finding->debug[0] = '\0'; /* half of it would be another call */
}

void check_add_reproduction(const struct check_options *options, const struct rule *rule,
                            struct finding *finding)
{
    char path[FINDING_TEXT / 2];
    if (rule->experiments == NO_EXPERIMENT)
        return;
    char dashed[FINDING_TEXT / 2];
    const char *const module = options->again_path != NULL ? options->again_path : options->path;
    if (strlen(module) * 4 + 8 > sizeof path)
        return; /* a path that does not fit would name another file */
    snprintf(dashed, sizeof dashed, "%s%s", module[0] == '-' ? "./" : "", module);
    shell_word(dashed, path, sizeof path);
    add_debugger(options, path, finding);
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
