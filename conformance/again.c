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

/* Where gdb is to stop when the module does not by itself: at the line, else at the function. False
 * when neither is known. */
static bool break_at(const struct finding *finding, char out[128])
{
    static const char harmless[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.+";
    const char *slash = strrchr(finding->file, '/');
    const char *name = slash != NULL ? slash + 1 : finding->file;
    out[0] = '\0';
    if (finding->stops)
        return true;
    if (name[0] != '\0' && name[strspn(name, harmless)] == '\0' && strlen(name) < 64)
        snprintf(out, 128, " -ex 'b %s:%d'", name, finding->line);
    else if (finding->function != NULL)
        snprintf(out, 128, " -ex 'b %s'", finding->function);
    return out[0] != '\0';
}

/* What gdb is told before the run. It reads modules of this SDK's own target, once it knows where
 * they are; of other formats it sees where a fault stops them. False: it can do nothing. */
static bool gdb_words(const struct image *image, const struct finding *finding, char *out,
                      size_t size)
{
    char stop[128];
    const bool known = break_at(finding, stop);
    if (image->target != IMAGE_TARGET_X86_64 || !known)
        return false;
    if (image->format == IMAGE_FORMAT_ELF64)
        snprintf(out, size,
                 "gdb -q -ex 'set confirm off' -ex 'handle SIGALRM nostop noprint' -ex 'b "
                 "tgm_debug_module_loaded' -ex r -ex 'eval \"add-symbol-file %%s -o "
                 "%%lu\",path,offset'%s -ex c",
                 stop);
    else if (finding->stops)
        snprintf(out, size, "gdb -q -ex 'handle SIGALRM nostop noprint' -ex r");
    else
        return false;
    return true;
}

/* Where a debugger can be at it: the run itself, in one process, up to the cycle. */
static void add_debugger(const struct check_options *options, const struct image *image,
                         const char *module, struct finding *finding)
{
    char path[FINDING_TEXT / 2] = "", words[FINDING_TEXT];
    const uint64_t cycles = finding->has_cycle ? finding->cycle + 1 : 1;
    if (finding->plain_us == 0 || !gdb_words(image, finding, words, sizeof words) ||
        (options->around_path != NULL && strlen(options->around_path) * 4 + 8 > sizeof path))
        return;
    if (options->around_path != NULL)
        shell_word(options->around_path, path, sizeof path);
    else
        snprintf(path, sizeof path, "%" PRIu32, finding->plain_us);
    const int length = snprintf(
        finding->debug, sizeof finding->debug,
        "%s --args tgm run %s --in-process --seed 0x%" PRIx64 " --for %" PRIu64 "us %s %s%s%s",
        words, module, options->seed, cycles * finding->plain_us,
        options->around_path != NULL ? "--config" : "--cycle", path,
        strcmp(options->profile->name, "pc4") != 0 ? " --profile " : "",
        strcmp(options->profile->name, "pc4") != 0 ? options->profile->name : "");
    if ((size_t)length >= sizeof finding->debug)
        finding->debug[0] = '\0'; /* half of it would be another call */
}

void check_add_reproduction(const struct check_options *options, const struct image *image,
                            const struct rule *rule, struct finding *finding)
{
    char path[FINDING_TEXT / 2];
    char dashed[FINDING_TEXT / 2];
    const char *const module = options->again_path != NULL ? options->again_path : options->path;
    if (strlen(module) * 4 + 8 > sizeof path)
        return; /* a path that does not fit would name another file */
    snprintf(dashed, sizeof dashed, "%s%s", module[0] == '-' ? "./" : "", module);
    shell_word(dashed, path, sizeof path);
    add_debugger(options, image, path, finding);
    int at =
        snprintf(finding->again, sizeof finding->again, "tgm check %s --rule %s", path, rule->id);
    if (rule->experiments != NO_EXPERIMENT && at < FINDING_TEXT)
        at += snprintf(finding->again + at, (size_t)(FINDING_TEXT - at), " --seed 0x%" PRIx64,
                       options->seed);
    if (strcmp(options->profile->name, "pc4") != 0 && at < FINDING_TEXT)
        at += snprintf(finding->again + at, (size_t)(FINDING_TEXT - at), " --profile %s",
                       options->profile->name);
    if (rule->experiments == NO_EXPERIMENT)
        return; /* the file alone shows it */
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
    if (!finding->has_cycle && options->cycles != 0 && at < FINDING_TEXT)
        snprintf(finding->again + at, (size_t)(FINDING_TEXT - at), " --cycles %" PRIu64,
                 options->cycles);
    if (finding->has_cycle && at < FINDING_TEXT)
        snprintf(finding->again + at, (size_t)(FINDING_TEXT - at), " --cycles %" PRIu64,
                 finding->cycles_needed != 0 ? finding->cycles_needed : finding->cycle + 1);
}
