/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/rules.h"

#include <fnmatch.h>
#include <stdio.h>
#include <string.h>

static const struct rule rules[] = {
#define RULE(symbol, id, group, severity, experiments, clause, title, advice)                      \
    { id, clause, title, advice, GROUP_##group, SEVERITY_##severity, experiments, check_##symbol },
#include "conformance/rules.def"
#undef RULE
};

static const char *const group_names[GROUP_COUNT] = { "file",      "start",     "cycle",
                                                      "disturbed", "preempted", "machine" };

const struct rule *rule_at(size_t index)
{
    return index < sizeof rules / sizeof *rules ? &rules[index] : NULL;
}

const struct rule *rule_find(const char *id)
{
    for (size_t i = 0; rule_at(i) != NULL; i++)
        if (strcmp(rules[i].id, id) == 0)
            return &rules[i];
    return NULL;
}

const char *rule_group_name(enum rule_group group)
{
    return group_names[group];
}

bool rule_selected(const char *patterns, const char *id)
{
    bool fits = false, any = false;
    for (const char *at = patterns; at != NULL && *at != '\0';) {
        char pattern[128];
        const size_t length = strcspn(at, ",");
        const bool without = *at == '!';
        snprintf(pattern, sizeof pattern, "%.*s", (int)(length - without), at + without);
        const bool match = fnmatch(pattern, id, 0) == 0;
        if (without && match)
            return false;
        any = any || !without;
        fits = fits || (!without && match);
        at += length + (at[length] == ',');
    }
    return fits || !any;
}

const char *rule_section(const struct rule *rule, size_t *length)
{
    char heading[80];
    snprintf(heading, sizeof heading, "\n## %s\n", rule->id);
    const char *begin = strstr(rulebook_text, heading);
    *length = 0;
    if (begin == NULL)
        return "";
    begin += strlen(heading);
    const char *end = strstr(begin, "\n## ");
    *length = end != NULL ? (size_t)(end - begin) : strlen(begin);
    return begin;
}
