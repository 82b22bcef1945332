/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * tgm new - a project from a template.
 *
 * The files come from templates/<language>/ and templates/project/ beside the program's SDK. In
 * them and in their names, "shuttle" becomes the project's name; in the project files, @SDK@,
 * @GENERATION@, @PROFILE@ and @TGM@ are filled in. Nothing is ever overwritten: the folder must not
 * exist.
 */
#define _GNU_SOURCE 1
#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/cli.h"

#define NAME_MAX_LENGTH 40
#define FILE_MAX        (1 << 20)
#define STEM            "shuttle"

static const struct {
    const char *name, *suffix;
} languages[] = { { "c", "c" }, { "cpp", "cpp" }, { "pascal", "pas" } };
#define LANGUAGES (sizeof languages / sizeof *languages)

struct project {
    const struct command *command;
    const char *name;
    char share[PATH_MAX]; /* holds sdk/ and templates/ */
    char program[PATH_MAX];
    char generation[8];
};

/* The name becomes an identifier: words of the languages and names of the SDK cannot be one. */
static bool is_taken(const char *name)
{
    static const char *const words[] = {
        "int",    "long",      "char",      "class",    "struct",    "union",  "enum",
        "void",   "double",    "float",     "short",    "signed",    "static", "extern",
        "const",  "return",    "if",        "else",     "for",       "while",  "do",
        "switch", "case",      "default",   "new",      "delete",    "this",   "auto",
        "public", "private",   "program",   "unit",     "begin",     "end",    "system",
        "objpas", "uses",      "interface", "function", "procedure", "record", "type",
        "var",    "array",     "object",    "library",  "plc_data",  "servo",  "dio",
        "header", "main",      "osc",       "line",     "state",     "status", "profile",
        "inputs", "namespace", "template",  "register", "volatile",  "inline", "using",
        "string",
    };
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strcasecmp(words[i], name) == 0)
            return true;
    return strncasecmp(name, "tgm_", 4) == 0 || strncasecmp(name, "program_", 8) == 0;
}

/* Identifier characters only: the name becomes file names, a make variable and comments. */
static bool name_is_good(const char *name)
{
    if (is_taken(name))
        return false;
    const size_t length = strlen(name);
    if (length == 0 || length > NAME_MAX_LENGTH || !isalpha((unsigned char)name[0]))
        return false;
    for (const char *c = name; *c != '\0'; c++)
        if (!isalnum((unsigned char)*c) && *c != '_')
            return false;
    return true;
}

/* Beside the program: in the source tree and where it is installed. */
static bool find_share(struct project *project)
{
    static const char *const places[] = { "/..", "/../share/tgm", "/../..", "/../../.." };
    char folder[PATH_MAX], candidate[PATH_MAX + 64];
    const ssize_t length = readlink("/proc/self/exe", folder, sizeof folder - 1);
    if (length <= 0)
        return false;
    folder[length] = '\0';
    snprintf(project->program, sizeof project->program, "%s", folder);
    *strrchr(folder, '/') = '\0';
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        snprintf(candidate, sizeof candidate, "%s%s/sdk/mk/module.mk", folder, places[i]);
        if (access(candidate, R_OK) != 0)
            continue;
        snprintf(candidate, sizeof candidate, "%s%s", folder, places[i]);
        return realpath(candidate, project->share) != NULL;
    }
    return false;
}

/* Copies text, with every `from` become `to`. */
static char *replaced(const char *text, const char *from, const char *to)
{
    const size_t step = strlen(from), grown = strlen(to);
    size_t count = 0;
    for (const char *at = text; (at = strstr(at, from)) != NULL; at += step)
        count++;
    char *out = malloc(strlen(text) + count * grown + 1), *end = out;
    if (out == NULL)
        return NULL;
    for (const char *at; (at = strstr(text, from)) != NULL; text = at + step) {
        end = (char *)mempcpy(end, text, (size_t)(at - text));
        end = (char *)mempcpy(end, to, grown);
    }
    strcpy(end, text);
    return out;
}

static char *filled_in(const struct project *project, const char *text)
{
    char sdk[PATH_MAX + 8], include[64];
    snprintf(include, sizeof include, "%s%s%sinclude $(SDK)",
             strcmp(project->generation, "4") == 0 ? "" : "TGM_GENERATION := ",
             strcmp(project->generation, "4") == 0 ? "" : project->generation,
             strcmp(project->generation, "4") == 0 ? "" : "\n");
    snprintf(sdk, sizeof sdk, "%s/sdk", project->share);
    const char *const pairs[][2] = { { "../../sdk", sdk },
                                     { "@SDK@", sdk },
                                     { "@TGM@", project->program },
                                     { "@GENERATION@", project->generation },
                                     { "@PROFILE@",
                                       strcmp(project->generation, "4") == 0 ? "pc4" : "pc5" },
                                     { "include $(SDK)", include },
                                     { STEM, project->name } };
    char *now = strdup(text);
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs && now != NULL; i++) {
        char *next = replaced(now, pairs[i][0], pairs[i][1]);
        free(now);
        now = next;
    }
    return now;
}

static char *template_text(const char *path)
{
    FILE *file = fopen(path, "re");
    char *text = malloc(FILE_MAX + 1);
    size_t size = 0;
    if (file != NULL && text != NULL) {
        size = fread(text, 1, FILE_MAX, file);
        text[size] = '\0';
    }
    if (file != NULL)
        fclose(file);
    if (file == NULL || text == NULL) {
        free(text);
        return NULL;
    }
    return text;
}

/* Behind the comment or string that begins here, or NULL when none does. */
static const char *behind_aside(const char *at, bool pascal)
{
    static const struct {
        const char *begin, *end;
        bool pascal_only;
    } asides[] = { { "//", "\n", false },
                   { "/*", "*/", false },
                   { "\"", "\"", false },
                   { "'", "'", false },
                   { "{", "}", true } };
    for (size_t i = 0; i < sizeof asides / sizeof *asides; i++) {
        const size_t length = strlen(asides[i].begin);
        if (strncmp(at, asides[i].begin, length) != 0 || (asides[i].pascal_only && !pascal))
            continue;
        const char *end = strstr(at + length, asides[i].end);
        return end != NULL ? end + strlen(asides[i].end) : at + strlen(at);
    }
    return NULL;
}

/* Whether the code, comments and strings apart, has the name as a word of its own. */
static bool has_word(const char *code, const char *name, bool pascal)
{
    const size_t length = strlen(name);
    while (*code != '\0') {
        const char *behind = behind_aside(code, pascal);
        if (behind != NULL) {
            code = behind;
            continue;
        }
        size_t word = 0;
        while (isalnum((unsigned char)code[word]) || code[word] == '_')
            word++;
        if (word == length && strncasecmp(code, name, length) == 0)
            return true;
        code += word > 0 ? word : 1;
    }
    return false;
}

static int write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "wxe");
    if (file == NULL)
        return -errno;
    const bool good = fputs(text, file) >= 0;
    return fclose(file) == 0 && good ? 0 : -EIO;
}

static int copy_file(const struct project *project, const char *from, const char *to)
{
    char *text = template_text(from);
    char *full = text != NULL ? filled_in(project, text) : NULL;
    const int r = full != NULL ? write_text(to, full) : -EIO;
    free(text);
    free(full);
    return r;
}

/* What a build left in a template's folder is no part of the template. */
static bool is_left_over(const char *name)
{
    return strcmp(name, ".") == 0 || strcmp(name, "..") == 0 || strcmp(name, "build") == 0;
}

static int copy_folder(const struct project *project, const char *from, const char *to)
{
    int r = 0;
    DIR *dir = opendir(from);
    if (dir == NULL)
        return -errno;
    for (struct dirent *entry; r == 0 && (entry = readdir(dir)) != NULL;) {
        char source[PATH_MAX], target[PATH_MAX];
        struct stat info;
        if (is_left_over(entry->d_name))
            continue;
        char *name = replaced(entry->d_name, STEM, project->name);
        if (name == NULL ||
            snprintf(source, sizeof source, "%s/%s", from, entry->d_name) >= PATH_MAX ||
            snprintf(target, sizeof target, "%s/%s", to,
                     strcmp(name, "gitignore") == 0 ? ".gitignore" : name) >= PATH_MAX)
            r = -ENAMETOOLONG;
        else if (stat(source, &info) != 0 ||
                 (S_ISDIR(info.st_mode) && mkdir(target, 0777) != 0 && errno != EEXIST))
            r = -errno;
        else
            r = S_ISDIR(info.st_mode) ? copy_folder(project, source, target)
                                      : copy_file(project, source, target);
        free(name);
    }
    closedir(dir);
    return r;
}

/* A name that the template's source gives to something else would make one name of two. */
static bool is_in_template(const struct project *project, size_t language)
{
    char path[PATH_MAX + 64];
    snprintf(path, sizeof path, "%s/templates/%s/" STEM ".%s", project->share,
             languages[language].name, languages[language].suffix);
    char *code = template_text(path);
    const bool found =
        code != NULL && strcasecmp(project->name, STEM) != 0 &&
        has_word(code, project->name, strcmp(languages[language].name, "pascal") == 0);
    free(code);
    return found;
}

static int create(const struct project *project, const char *language)
{
    char from[PATH_MAX + 64];
    if (mkdir(project->name, 0777) != 0)
        return errno == EEXIST ? complain(project->command,
                                          "'%s' exists already; nothing was changed", project->name)
                               : complain(project->command, "cannot make the folder '%s': %s",
                                          project->name, strerror(errno));
    snprintf(from, sizeof from, "%s/templates/%s", project->share, language);
    int r = copy_folder(project, from, project->name);
    snprintf(from, sizeof from, "%s/templates/project", project->share);
    if (r == 0)
        r = copy_folder(project, from, project->name);
    if (r != 0)
        return complain(project->command, "the project in '%s' is not complete: %s", project->name,
                        strerror(-r));
    printf("%s/ is a project for generation %s. Next:\n  cd %s\n  make check\n", project->name,
           project->generation, project->name);
    return EXIT_OK;
}

int command_new(const struct command *command, int argc, char **argv)
{
    struct project project = { .command = command };
    const char *language = "c";
    uint64_t generation = 4;
    const struct option table[] = {
        { "--lang", OPTION_TEXT, "LANGUAGE", "c (default), cpp or pascal", &language, 0, 0 },
        { "--generation", OPTION_NUMBER, "N", "of TG Motion: 4 (default) or 5", &generation, 4, 5 },
        { 0 },
    };
    int words, status;
    if (!options_read(command, table, argc, argv, &project.name, 1, &words, &status))
        return status;
    if (words == 0)
        return complain(command, "what shall it be called? usage: tgm new %s", command->usage);
    if (!name_is_good(project.name))
        return complain(command,
                        "'%s' is no project name: a letter, then letters, digits or _, at most %d, "
                        "and no word of "
                        "the language",
                        project.name, NAME_MAX_LENGTH);
    size_t i = 0;
    while (i < LANGUAGES && strcmp(languages[i].name, language) != 0)
        i++;
    if (i == LANGUAGES)
        return complain(command, "no template in '%s'; allowed: c, cpp, pascal", language);
    if (!find_share(&project))
        return complain(command,
                        "the SDK is not beside this program; run it from its tree or install it");
    if (is_in_template(&project, i))
        return complain(command,
                        "'%s' is the name of something else in the template; choose another",
                        project.name);
    snprintf(project.generation, sizeof project.generation, "%" PRIu64, generation);
    return create(&project, language);
}
