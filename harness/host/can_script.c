/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "host/can.h"

#define WORDS 24 /* of a line: "every 5ms from 2ms send 0x124" and eight bytes */
#define WORD  32
#define KBIT  500

struct line {
    unsigned number, count, at; /* at: the next word */
    char word[WORDS][WORD];
};

struct reader {
    struct can *can;
    const char *name;
    struct line line;
    unsigned channel;
    char *why;
};

static int wrong(struct reader *r, const char *what)
{
    const char *word = r->line.at < r->line.count ? r->line.word[r->line.at] : NULL;
    if (word == NULL)
        snprintf(r->why, CAN_WHY, "%s:%u: %s expected at the end of the line", r->name,
                 r->line.number, what);
    else
        snprintf(r->why, CAN_WHY, "%s:%u: %s expected, not '%s'", r->name, r->line.number, what,
                 word);
    return -EINVAL;
}

static bool next_is(struct reader *r, const char *word)
{
    if (r->line.at >= r->line.count || strcmp(r->line.word[r->line.at], word) != 0)
        return false;
    r->line.at++;
    return true;
}

static int digit_of(char c)
{
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : 99;
}

/* Digits up to something else; false without any, or past `most`. */
static bool digits(const char **text, int base, uint64_t most, uint64_t *value)
{
    const char *begin = *text;
    for (*value = 0; digit_of(**text) < base; ++*text) {
        *value = *value * (unsigned)base + (unsigned)digit_of(**text);
        if (*value > most)
            return false;
    }
    return *text > begin;
}

/* Decimal, or hexadecimal behind 0x (always, with hex). */
static int number(struct reader *r, const char *what, bool hex, uint64_t most, uint64_t *value)
{
    if (r->line.at >= r->line.count)
        return wrong(r, what);
    const char *text = r->line.word[r->line.at];
    const bool prefixed = text[0] == '0' && (text[1] == 'x' || text[1] == 'X');
    if (prefixed)
        text += 2;
    if (!digits(&text, hex || prefixed ? 16 : 10, most, value) || *text != '\0')
        return wrong(r, what);
    r->line.at++;
    return 0;
}

static int duration(struct reader *r, uint64_t *ns)
{
    static const struct unit {
        const char *name;
        uint64_t ns;
    } units[] = { { "us", 1000 }, { "ms", 1000000 }, { "s", 1000000000 } };
    const char *text = r->line.at < r->line.count ? r->line.word[r->line.at] : "";
    uint64_t value;
    if (digits(&text, 10, 1000000000, &value))
        for (size_t i = 0; i < sizeof units / sizeof *units; i++)
            if (strcmp(text, units[i].name) == 0) {
                *ns = value * units[i].ns;
                r->line.at++;
                return 0;
            }
    return wrong(r, "a time, as in 10ms");
}

static int frame(struct reader *r, struct can_frame *out)
{
    uint64_t value;
    int error = number(r, "an identifier up to 0x7FF", false, CAN_IDS - 1, &value);
    if (error != 0)
        return error;
    *out = (struct can_frame){ .id = (uint32_t)value };
    while (r->line.at < r->line.count) {
        if (out->length == sizeof out->data)
            return wrong(r, "no more than eight bytes");
        error = number(r, "a byte in hexadecimal", true, 0xFF, &value);
        if (error != 0)
            return error;
        out->data[out->length++] = (uint8_t)value;
    }
    return 0;
}

static int read_send(struct reader *r, struct can_rule *rule)
{
    return next_is(r, "send") ? frame(r, &rule->frame) : wrong(r, "send");
}

static int read_at(struct reader *r, struct can_rule *rule)
{
    rule->kind = CAN_ONCE;
    int error = duration(r, &rule->next_ns);
    return error != 0 ? error : read_send(r, rule);
}

static int read_every(struct reader *r, struct can_rule *rule)
{
    rule->kind = CAN_EVERY;
    int error = duration(r, &rule->period_ns);
    rule->next_ns = rule->period_ns;
    if (error == 0 && rule->period_ns == 0) {
        r->line.at--;
        error = wrong(r, "a period above 0");
    }
    if (error == 0 && next_is(r, "from"))
        error = duration(r, &rule->next_ns);
    return error != 0 ? error : read_send(r, rule);
}

static int read_on(struct reader *r, struct can_rule *rule)
{
    uint64_t id;
    rule->kind = CAN_REPLY;
    int error = number(r, "an identifier up to 0x7FF", false, CAN_IDS - 1, &id);
    if (error != 0)
        return error;
    rule->on_id = (uint32_t)id;
    rule->on_remote = next_is(r, "remote");
    if (next_is(r, "after"))
        error = duration(r, &rule->period_ns);
    if (error != 0)
        return error;
    return next_is(r, "reply") ? frame(r, &rule->frame) : wrong(r, "reply");
}

static int read_rule(struct reader *r, int (*read)(struct reader *, struct can_rule *))
{
    struct can_rule rule = { .channel = r->channel };
    if (r->can->rule_count == CAN_RULES) {
        snprintf(r->why, CAN_WHY, "%s:%u: more than %d statements", r->name, r->line.number,
                 CAN_RULES);
        return -EINVAL;
    }
    int error = read(r, &rule);
    if (error == 0)
        r->can->rules[r->can->rule_count++] = rule;
    return error;
}

static int read_line(struct reader *r)
{
    uint64_t value;
    int error = 0;
    if (r->line.count == 0)
        return 0;
    if (next_is(r, "at"))
        error = read_rule(r, read_at);
    else if (next_is(r, "every"))
        error = read_rule(r, read_every);
    else if (next_is(r, "on"))
        error = read_rule(r, read_on);
    else if (next_is(r, "loopback"))
        r->can->loopback[r->channel] = true;
    else if (next_is(r, "baud")) {
        error = number(r, "a speed of 1 to 1000 kbit/s", false, 1000, &value);
        if (error == 0 && value == 0) {
            r->line.at--;
            error = wrong(r, "a speed of 1 to 1000 kbit/s");
        }
        if (error == 0)
            r->can->kbit[r->channel] = (uint32_t)value;
    } else if (next_is(r, "channel")) {
        error = number(r, "channel 1 or 2", false, CAN_CHANNELS, &value);
        if (error == 0 && value == 0) {
            r->line.at--;
            error = wrong(r, "channel 1 or 2");
        }
        r->channel = error == 0 ? (unsigned)value - 1 : 0;
    } else
        error = wrong(r, "at, every, on, baud, loopback or channel");
    return error == 0 && r->line.at < r->line.count ? wrong(r, "nothing more") : error;
}

/* One line in words, without its comment. */
static int split(struct reader *r, const char *text, size_t length)
{
    struct line *line = &r->line;
    line->count = line->at = 0;
    for (size_t i = 0; i < length && text[i] != '#';) {
        size_t end = i;
        while (end < length && text[end] != '#' && !isspace((unsigned char)text[end]))
            end++;
        if (end == i) {
            i++;
            continue;
        }
        if (line->count == WORDS || end - i >= WORD) {
            snprintf(r->why, CAN_WHY, "%s:%u: the line is no statement", r->name, line->number);
            return -EINVAL;
        }
        memcpy(line->word[line->count], text + i, end - i);
        for (size_t k = 0; k < end - i; k++)
            if (!isprint((unsigned char)line->word[line->count][k]))
                line->word[line->count][k] = '?';
        line->word[line->count++][end - i] = '\0';
        i = end;
    }
    return 0;
}

int can_open(struct can *can, const char *script, const char *name, unsigned buffer,
             char why[CAN_WHY])
{
    struct reader r = { .can = can, .name = name, .why = why };
    memset(can, 0, sizeof *can);
    can->buffer = buffer > 0 ? buffer : 1;
    for (unsigned i = 0; i < CAN_CHANNELS; i++)
        can->kbit[i] = KBIT;
    while (*script != '\0') {
        const size_t length = strcspn(script, "\n");
        r.line.number++;
        int error = split(&r, script, length);
        if (error == 0)
            error = read_line(&r);
        if (error != 0)
            return error;
        script += length + (script[length] == '\n');
    }
    return 0;
}
