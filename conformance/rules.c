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

/* One of several. */
struct pattern {
    char text[RULE_PATTERN];
    bool without;
};

/* *at: what is left, NULL at the end. What is too long fits no rule. */
static bool next_pattern(const char **at, struct pattern *pattern)
{
    if (*at == NULL)
        return false;
    const size_t length = strcspn(*at, ",");
    pattern->without = **at == '!';
    const size_t size = length - pattern->without;
    snprintf(pattern->text, sizeof pattern->text, "%.*s", size < RULE_PATTERN ? (int)size : 0,
             *at + pattern->without);
    *at = (*at)[length] == ',' ? *at + length + 1 : NULL;
    return true;
}

bool rule_selected(const char *patterns, const char *id)
{
    bool fits = false, any = false;
    struct pattern pattern;
    for (const char *at = patterns; next_pattern(&at, &pattern);) {
        const bool match = fnmatch(pattern.text, id, 0) == 0;
        if (pattern.without && match)
            return false;
        any = any || !pattern.without;
        fits = fits || (!pattern.without && match);
    }
    return fits || !any;
}

bool rule_pattern_idle(const char *patterns, char idle[RULE_PATTERN])
{
    struct pattern pattern;
    for (const char *at = patterns; next_pattern(&at, &pattern);) {
        size_t i = 0;
        while (rule_at(i) != NULL && fnmatch(pattern.text, rule_at(i)->id, 0) != 0)
            i++;
        if (rule_at(i) != NULL)
            continue;
        snprintf(idle, RULE_PATTERN, "%s", pattern.text);
        return true;
    }
    return false;
}

bool rule_pattern_needs_scenario(const char *patterns, char lone[RULE_PATTERN])
{
    struct pattern pattern;
    for (const char *at = patterns; next_pattern(&at, &pattern);) {
        bool plays = false, more = pattern.without;
        for (size_t i = 0; rule_at(i) != NULL; i++)
            if (fnmatch(pattern.text, rule_at(i)->id, 0) == 0) {
                plays = plays || rule_at(i)->experiments == ON_SCENARIOS;
                more = more || rule_at(i)->experiments != ON_SCENARIOS;
            }
        if (!plays || more)
            continue;
        snprintf(lone, RULE_PATTERN, "%s", pattern.text);
        return true;
    }
    return false;
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
