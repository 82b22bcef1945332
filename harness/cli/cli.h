/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * cli.h - the command line: words in, words out, no logic.
 *
 * Exit status of every subcommand: 0 all is well (check: PASS), 1 the module is at fault (FAIL),
 * 3 something could not be judged (INCOMPLETE), 2 a wrong call or trouble of the harness itself.
 */
#ifndef HARNESS_CLI_CLI_H
#define HARNESS_CLI_CLI_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define TGM_VERSION_TEXT "0.1.0"

enum { EXIT_OK = 0, EXIT_MODULE = 1, EXIT_CALL = 2, EXIT_INCOMPLETE = 3 };

enum option_kind {
    OPTION_FLAG,     /* no value; target: bool */
    OPTION_TEXT,     /* target: const char * */
    OPTION_TEXTS,    /* may be given again; target: struct option_texts */
    OPTION_NUMBER,   /* decimal or 0x..., range below; target: uint64_t */
    OPTION_DURATION, /* 2s, 500ms, 250us; target: uint64_t, nanoseconds */
};

#define OPTION_TEXTS_MAX 32

struct option_texts {
    const char *texts[OPTION_TEXTS_MAX];
    size_t count;
};

struct option {
    const char *name; /* "--seed" */
    enum option_kind kind;
    const char *value; /* how the value is called in help: "N"; NULL for flags */
    const char *help;
    void *target;
    uint64_t least, most; /* OPTION_NUMBER: allowed range; both 0: any */
};

struct command {
    const char *name;
    const char *usage;   /* "MODULE.tgm" */
    const char *summary; /* one line */
    int (*run)(const struct command *command, int argc, char **argv);
};

/*
 * Reads argv (behind the subcommand) by a table that ends with name NULL. Options may stand
 * anywhere;
 * "--" ends them; "--help" prints the table and sets *status 0. Words that are no options go to
 * words (at most max_words). False: the call is over, exit with *status; what was wrong has been
 * said.
 */
bool options_read(const struct command *command, const struct option *options, int argc,
                  char **argv, const char **words, int max_words, int *word_count, int *status);

/* "tgm check: ..." on standard error. Returns EXIT_CALL. */
int complain(const struct command *command, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Seed of check and run unless --seed says otherwise. */
#define DEFAULT_SEED 0x1d2f

/* --rule, given several times, as check_options has it: with commas between them, NULL for none.
 * False, and the reason said, when they are too long together. */
#define PATTERNS_MAX (OPTION_TEXTS_MAX * 128)
bool patterns_join(const struct command *command, const struct option_texts *patterns,
                   char out[PATTERNS_MAX], const char **joined);

struct profile;
/* The profile of that name; NULL, and the allowed names said, when there is none. */
const struct profile *profile_or_complain(const struct command *command, const char *name);

/* The entry of names (count of them) closest to word, NULL when none is close. */
const char *nearest(const char *word, const char *const *names, size_t count);

/* A file that appears under its name only when it is complete, and of which nothing is left when
 * this process is ended; "-" is standard output. */
struct output {
    FILE *stream;
    char *path, *temporary; /* temporary is NULL when the stream writes to its place directly */
    bool nameless;          /* the file has no name yet; temporary is a pattern for one */
};

/* The whole text file, to be freed; NULL, and the reason said, when that is not possible. `what` is
 * what messages call it. */
char *read_text(const struct command *command, const char *what, const char *path);

/* Both names lead to one existing file. */
bool same_file(const char *a, const char *b);

/* 0 or negative errno. */
int output_open(struct output *output, const char *path);
/* What another program of this user can write it by while it is open. */
#define OUTPUT_FILE 4352
void output_file(const struct output *output, char name[OUTPUT_FILE]);
/* Closes and puts the file in its place (keep), or removes it. 0 or negative errno. */
int output_close(struct output *output, bool keep);

int command_check(const struct command *command, int argc, char **argv);
int command_run(const struct command *command, int argc, char **argv);
int command_bus(const struct command *command, int argc, char **argv);
int command_inspect(const struct command *command, int argc, char **argv);
int command_rules(const struct command *command, int argc, char **argv);
int command_new(const struct command *command, int argc, char **argv);
int command_plot(const struct command *command, int argc, char **argv);
int command_registers(const struct command *command, int argc, char **argv);
int command_device(const struct command *command, int argc, char **argv);
int command_config(const struct command *command, int argc, char **argv);
int command_keygen(const struct command *command, int argc, char **argv);
int command_certify(const struct command *command, int argc, char **argv);
int command_verify(const struct command *command, int argc, char **argv);
int command_selftest(const struct command *command, int argc, char **argv);
int command_explain(const struct command *command, int argc, char **argv);

#endif
