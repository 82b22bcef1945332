/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The line that shows a finding again. */
#include "conformance/check_parts.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* What a shell takes as it is. */
#define HARMLESS "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.+"

/* All of it or none: half of a line would be another call. */
struct line {
    char *text;
    size_t size, length;
};

static struct line begin(char *text, size_t size)
{
    text[0] = '\0';
    return (struct line){ text, size, 0 };
}

__attribute__((format(printf, 2, 3))) static void add(struct line *line, const char *format, ...)
{
    const size_t left = line->size - line->length;
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(line->text + line->length, left, format, arguments);
    va_end(arguments);
    line->length += (size_t)length < left ? (size_t)length : left - 1; /* full: see end() */
}

static void end(const struct line *line)
{
    if (line->length == line->size - 1)
        line->text[0] = '\0';
}

/* A file name as a shell takes it, and no command as an option. */
static void add_file(struct line *line, const char *name)
{
    const char *here = name[0] == '-' ? "./" : "";
    if (name[0] != '\0' && name[strspn(name, HARMLESS "/=:,@%")] == '\0') {
        add(line, " %s%s", here, name);
        return;
    }
    add(line, " '%s", here);
    for (; *name != '\0'; name++)
        if (*name == '\'')
            add(line, "'\\''");
        else
            add(line, "%c", *name);
    add(line, "'");
}

/* Where gdb is to stop when the module does not by itself: at the line, else at the function. False
 * when neither is known. */
static bool break_at(const struct finding *finding, char out[128])
{
    const char *slash = strrchr(finding->file, '/');
    const char *name = slash != NULL ? slash + 1 : finding->file;
    out[0] = '\0';
    if (finding->stops)
        return true;
    if (name[0] != '\0' && name[strspn(name, HARMLESS)] == '\0' && strlen(name) < 64)
        snprintf(out, 128, " -ex 'b %s:%d'", name, finding->line);
    else if (finding->function != NULL)
        snprintf(out, 128, " -ex 'b %s'", finding->function);
    return out[0] != '\0';
}

/* What gdb is told before the run. It reads modules of this SDK's own target, once it knows where
 * they are; of other formats it sees where a fault stops them. False: it can do nothing. */
static bool add_gdb(struct line *line, const struct image *image, const struct finding *finding)
{
    char stop[128];
    const bool known = break_at(finding, stop);
    if (image->target != IMAGE_TARGET_X86_64 || !known)
        return false;
    if (image->format == IMAGE_FORMAT_ELF64)
        add(line,
            "gdb -q -ex 'set confirm off' -ex 'handle SIGALRM nostop noprint' -ex 'b "
            "tgm_debug_module_loaded' -ex r -ex 'eval \"add-symbol-file %%s -o "
            "%%lu\",path,offset'%s -ex c",
            stop);
    else if (finding->stops)
        add(line, "gdb -q -ex 'handle SIGALRM nostop noprint' -ex r");
    else
        return false;
    return true;
}

static void add_profile(struct line *line, const struct check_options *options)
{
    if (strcmp(options->profile->name, "pc4") != 0)
        add(line, " --profile %s", options->profile->name);
}

/* Where a debugger can be at it: the run itself, in one process, up to the cycle. */
static void add_debugger(const struct check_options *options, const struct image *image,
                         const char *module, struct finding *finding)
{
    const uint64_t cycles = finding->has_cycle ? finding->cycle + 1 : 1;
    struct line line = begin(finding->debug, sizeof finding->debug);
    if (finding->plain_us == 0 || !add_gdb(&line, image, finding))
        return;
    add(&line, " --args tgm run");
    add_file(&line, module);
    add(&line, " --in-process --seed 0x%" PRIx64 " --for %" PRIu64 "us", options->seed,
        cycles * finding->plain_us);
    if (options->around_path != NULL) {
        add(&line, " --config");
        add_file(&line, options->around_path);
    } else {
        add(&line, " --cycle %" PRIu32, finding->plain_us);
    }
    add_profile(&line, options);
    end(&line);
}

static void add_cycles(struct line *line, const struct check_options *options,
                       const struct finding *finding)
{
    if (finding->has_cycle)
        add(line, " --cycles %" PRIu64,
            finding->cycles_needed != 0 ? finding->cycles_needed : finding->cycle + 1);
    else if (options->cycles != 0)
        add(line, " --cycles %" PRIu64, options->cycles);
}

/* The seed, the profile, and what was around the module. */
static void add_circumstances(struct line *line, const struct check_options *options,
                              const struct rule *rule, const struct finding *finding)
{
    const bool runs = rule->experiments != NO_EXPERIMENT; /* else the file alone shows it */
    if (runs)
        add(line, " --seed 0x%" PRIx64, options->seed);
    add_profile(line, options);
    if (runs && options->around_path != NULL) {
        add(line, " --config");
        add_file(line, options->around_path);
    }
    for (size_t i = 0; rule->experiments == ON_SCENARIOS && i < options->scenario_count; i++) {
        add(line, " --scenario");
        add_file(line, options->scenarios[i].path);
    }
    if (runs && rule->experiments != ON_SCENARIOS)
        add_cycles(line, options, finding);
}

void check_add_reproduction(const struct check_options *options, const struct image *image,
                            const struct rule *rule, struct finding *finding)
{
    const char *const module = options->again_path != NULL ? options->again_path : options->path;
    struct line line = begin(finding->again, sizeof finding->again);
    add(&line, "tgm check");
    add_file(&line, module);
    add(&line, " --rule %s", rule->id);
    add_circumstances(&line, options, rule, finding);
    end(&line);
    add_debugger(options, image, module, finding);
}
