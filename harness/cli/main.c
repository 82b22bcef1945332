/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <string.h>

#include "cli/cli.h"

static const struct command commands[] = {
    { "check", "MODULE.tgm [options]",
      "Judges a module by every rule of the profile; the last line is the verdict.",
      command_check },
    { "run", "MODULE.tgm [options]",
      "Runs a module on the simulated machine and shows what its axes do.", command_run },
    { "plot", "FILE.csv --to FILE.png|svg", "A recording as a picture.", command_plot },
    { "bus", "--interface NAME FILE.bus | DEVICE...",
      "The simulated bus on a network interface, for any EtherCAT master.", command_bus },
    { "new", "NAME [options]", "Makes a project from a template, in a new folder.", command_new },
    { "inspect", "MODULE.tgm [--json FILE]",
      "Says what is inside a module file; runs nothing of it.", command_inspect },
    { "config", "FILE.ini [options]",
      "Checks a configuration file of TG Motion and says what it means.", command_config },
    { "registers", "[PATTERN]", "Lists registers by name, memory or offset.", command_registers },
    { "device", "[FILE...] [--convert SOURCE]",
      "Lists device types of the bus; checks device files and ESI.", command_device },
    { "selftest", "[options]", "Proves every rule on modules that break it.", command_selftest },
    { "rules", "[--book]", "Lists the rules.", command_rules },
    { "certify", "MODULE.tgm --key FILE [options]",
      "Judges a module by the frozen suite and signs that it passed.", command_certify },
    { "verify", "CERTIFICATE MODULE.tgm --key FILE [--evidence DIR]",
      "Verifies a certificate, offline.", command_verify },
    { "keygen", "NAME", "Makes a pair of keys for certificates: NAME.key and NAME.pub.",
      command_keygen },
    { "explain", "RULE", "Explains one rule: what must hold, why, and what to do.",
      command_explain },
};
#define COMMAND_COUNT (sizeof commands / sizeof *commands)

static void usage(FILE *stream)
{
    fprintf(stream, "tgm %s - conformance harness for TG Motion PLC modules\n\n", TGM_VERSION_TEXT);
    for (size_t i = 0; i < COMMAND_COUNT; i++)
        fprintf(stream, "  tgm %s %s\n      %s\n", commands[i].name, commands[i].usage,
                commands[i].summary);
    fprintf(stream, "\ntgm COMMAND --help lists the options. Exit status: 0 PASS, 1 FAIL, 3 "
                    "INCOMPLETE, 2 a wrong call or\n"
                    "trouble of the harness itself.\n");
}

static int unknown_command(const char *word)
{
    const char *names[COMMAND_COUNT];
    char all[256] = "";
    for (size_t i = 0, at = 0; i < COMMAND_COUNT; i++) {
        names[i] = commands[i].name;
        at += (size_t)snprintf(all + at, sizeof all - at, " %s", names[i]);
    }
    const char *close = nearest(word, names, COMMAND_COUNT);
    if (close != NULL)
        return complain(NULL, "unknown command '%s' (did you mean %s?)", word, close);
    return complain(NULL, "unknown command '%s'; allowed:%s help version", word, all);
}

/* A closed standard stream must not become the next file that is opened. */
static bool streams_are_open(void)
{
    for (int fd = 0; fd < 3; fd++)
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", fd == 0 ? O_WRONLY : O_RDONLY) != fd)
            return false;
    return true;
}

/* A verdict that could not be written was not given. A reader that went away on purpose has seen
 * enough. */
static int finish(int status)
{
    errno = 0;
    if ((fflush(stdout) == 0 && !ferror(stdout)) || errno == EPIPE)
        return status;
    return complain(NULL, "cannot write to standard output: %s",
                    errno != 0 ? strerror(errno) : "write error");
}

int main(int argc, char **argv)
{
    /* A reader that closes its end early (head, grep -q) is no reason to die without a status. */
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    if (!streams_are_open())
        return EXIT_CALL;
    if (argc < 2) {
        usage(stderr);
        return EXIT_CALL;
    }
    const char *word = argv[1];
    if (strcmp(word, "help") == 0 || strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0) {
        usage(stdout);
        return finish(EXIT_OK);
    }
    if (strcmp(word, "version") == 0 || strcmp(word, "--version") == 0) {
        printf("tgm %s\n", TGM_VERSION_TEXT);
        return EXIT_OK;
    }
    for (size_t i = 0; i < COMMAND_COUNT; i++)
        if (strcmp(commands[i].name, word) == 0)
            return finish(commands[i].run(&commands[i], argc - 2, argv + 2));
    return unknown_command(word);
}
