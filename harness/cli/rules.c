/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <string.h>

#include "cli/cli.h"
#include "conformance/rule_book.h"
#include "conformance/rules.h"

#define RULES_MAX 256

int command_rules(const struct command *command, int argc, char **argv)
{
    bool book = false;
    const struct option table[] = {
        { "--book", OPTION_FLAG, NULL,
          "the rule book whose SHA-256 reports and certificates name: rules, profiles, experiments",
          &book, 0, 0 },
        { 0 },
    };
    int words, status;
    if (!options_read(command, table, argc, argv, NULL, 0, &words, &status))
        return status;
    if (book) {
        rule_book_write(stdout);
        return EXIT_OK;
    }
    for (size_t i = 0; rule_at(i) != NULL; i++)
        printf("%-25s %-9s %-6s %s\n", rule_at(i)->id, rule_group_name(rule_at(i)->group),
               severity_name(rule_at(i)->severity), rule_at(i)->title);
    return EXIT_OK;
}

/* Code that breaks the rule and code that keeps it: what follows its advice in docs/rules.md. */
static void explain_code(const struct rule *rule)
{
    size_t length;
    const char *section = rule_section(rule, &length), *at = strstr(section, rule->advice);
    if (at == NULL || at >= section + length)
        return;
    at += strlen(rule->advice);
    at += strspn(at, "\n");
    for (const char *end; at < section + length; at = end + 1) {
        end = memchr(at, '\n', (size_t)(section + length - at));
        if (end == NULL)
            end = section + length;
        if (strncmp(at, "```", 3) != 0)
            printf("%s%.*s\n", end > at ? "  " : "", (int)(end - at), at);
    }
}

int command_explain(const struct command *command, int argc, char **argv)
{
    const struct option table[] = { { 0 } };
    const char *id = NULL;
    int words, status;
    if (!options_read(command, table, argc, argv, &id, 1, &words, &status))
        return status;
    if (words == 0)
        return complain(command, "which rule? `tgm rules` lists them");
    const struct rule *rule = rule_find(id);
    if (rule == NULL) {
        const char *names[RULES_MAX];
        size_t count = 0;
        for (; rule_at(count) != NULL && count < RULES_MAX; count++)
            names[count] = rule_at(count)->id;
        const char *close = nearest(id, names, count);
        return close != NULL ? complain(command, "no rule '%s' (did you mean %s?)", id, close)
                             : complain(command, "no rule '%s'; `tgm rules` lists them", id);
    }
    printf("%s (%s, %s)\n  %s\n\n  %s\n\n  %s\n\n", rule->id, rule_group_name(rule->group),
           severity_name(rule->severity), rule->clause, rule->title, rule->advice);
    explain_code(rule);
    return EXIT_OK;
}
