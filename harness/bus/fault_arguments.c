/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The arguments of the fault script's grammar: word *n, and what belongs to it, into the action. */
#include "bus/fault_words.h"

#include <stdio.h>
#include <string.h>

#define AXES_MAX    8
#define PERCENT_ONE 10000   /* of a million */
#define DRIFT_MAX   1000000 /* ppb */

typedef bool take(struct fault_line *line, size_t *n, struct fault_action *action);

static bool take_place(struct fault_line *line, size_t *n, struct fault_action *action,
                       uint64_t least, uint64_t most)
{
    char what[64], expected[48], word[48];
    uint64_t place;

    snprintf(expected, sizeof expected, "a slave from %u to %u", (unsigned)least, (unsigned)most);
    if (!fault_number(line, *n, UINT32_MAX, &place))
        return fault_fail(line, *n, NULL, expected);
    if (place == line->segment->count)
        snprintf(what, sizeof what, "no cable leads away from the last slave");
    else
        snprintf(what, sizeof what, "there is no slave %s", fault_word_text(line, *n, word));
    if (place < least || place > most)
        return fault_fail(line, *n, what, expected);
    action->place = place;
    line->place_at = *n;
    ++*n;
    return true;
}

static bool take_slave(struct fault_line *line, size_t *n, struct fault_action *action)
{
    return take_place(line, n, action, 1, line->segment->count);
}

/* The one behind the last slave leads to the master's second port, if it has one. */
static bool take_cable(struct fault_line *line, size_t *n, struct fault_action *action)
{
    return take_place(line, n, action, 0, line->segment->count - !line->segment->ring);
}

static bool take_channel(struct fault_line *line, size_t *n, struct fault_action *action)
{
    static const char wanted[] = "an input such as 2.0: slave, channel from 0";
    struct fault_line part = *line;
    struct fault_word *word = &part.words[*n];
    const char *point = memchr(word->at, '.', word->length);
    size_t length = word->length, at = *n;
    uint64_t channel;

    if (!point)
        return fault_fail(line, *n, NULL, wanted);
    *word = (struct fault_word){ point + 1, length - (size_t)(point + 1 - word->at), 0 };
    if (!fault_number(&part, at, UINT16_MAX, &channel))
        return fault_fail(line, *n, NULL, wanted);
    action->channel = (unsigned)channel;
    *word = (struct fault_word){ line->words[at].at, (size_t)(point - line->words[at].at), 0 };
    line->place_at = at;
    if (take_slave(&part, n, action))
        return true;
    return fault_fail(line, at, part.failed_at == at && part.what[0] ? part.what : NULL, wanted);
}

static bool take_time(struct fault_line *line, size_t *n, struct fault_action *action)
{
    if (!fault_time(line, *n, &action->time_ns) || !action->time_ns)
        return fault_fail(line, *n, NULL, FAULT_TIME_WANTED);
    ++*n;
    return true;
}

static bool take_code(struct fault_line *line, size_t *n, struct fault_action *action)
{
    uint64_t code;

    if (!fault_number(line, *n, UINT16_MAX, &code) || !code)
        return fault_fail(line, *n, NULL, "a code such as 0x001B");
    action->code = (uint32_t)code;
    ++*n;
    return true;
}

static bool take_abort(struct fault_line *line, size_t *n, struct fault_action *action)
{
    uint64_t code;

    if (!fault_number(line, *n, UINT32_MAX, &code) || !code)
        return fault_fail(line, *n, NULL, "an abort code such as 0x06090011");
    action->code = (uint32_t)code;
    action->index = 0;
    action->subindex = -1;
    ++*n;
    return true;
}

static bool take_object(struct fault_line *line, size_t *n, struct fault_action *action)
{
    static const char wanted[] = "an object such as 0x6060 or 0x6060:0";
    struct fault_line part = *line;
    struct fault_word *word = &part.words[*n];
    const char *colon = memchr(word->at, ':', word->length);
    size_t length = word->length;
    uint64_t index, subindex;

    if (colon) {
        *word = (struct fault_word){ colon + 1, length - (size_t)(colon + 1 - word->at), 0 };
        if (!fault_number(&part, *n, 255, &subindex))
            return fault_fail(line, *n, NULL, wanted);
        action->subindex = (int16_t)subindex;
        *word = (struct fault_word){ line->words[*n].at, (size_t)(colon - line->words[*n].at), 0 };
    }
    if (!fault_number(&part, *n, UINT16_MAX, &index) || !index)
        return fault_fail(line, *n, NULL, wanted);
    action->index = (uint16_t)index;
    ++*n;
    return true;
}

static bool take_axis(struct fault_line *line, size_t *n, struct fault_action *action)
{
    uint64_t axis;

    if (!fault_number(line, *n, AXES_MAX, &axis) || !axis)
        return fault_fail(line, *n, NULL, "an axis from 1 to 8");
    action->axis = (unsigned)axis;
    ++*n;
    return true;
}

static bool take_state(struct fault_line *line, size_t *n, struct fault_action *action)
{
    static const struct {
        const char *name;
        unsigned state;
    } states[] = { { "INIT", AL_INIT }, { "PREOP", AL_PREOP }, { "SAFEOP", AL_SAFEOP } };

    for (size_t i = 0; i < sizeof states / sizeof *states; i++) {
        if (fault_word_is(line, *n, states[i].name)) {
            action->al_state = states[i].state;
            ++*n;
            return true;
        }
        fault_fail(line, *n, NULL, states[i].name);
    }
    return false;
}

static bool take_value(struct fault_line *line, size_t *n, struct fault_action *action)
{
    if (!fault_signed(line, *n, &action->value))
        return fault_fail(line, *n, NULL, "a number such as 12, -5 or 0x1f");
    ++*n;
    return true;
}

static bool take_amplitude(struct fault_line *line, size_t *n, struct fault_action *action)
{
    uint64_t value;

    if (!fault_number(line, *n, INT32_MAX, &value) || !value)
        return fault_fail(line, *n, NULL, "an amplitude such as 100");
    action->value = (int64_t)value;
    ++*n;
    return true;
}

static bool take_seed(struct fault_line *line, size_t *n, struct fault_action *action)
{
    if (!fault_number(line, *n, UINT64_MAX, &action->seed))
        return fault_fail(line, *n, NULL, "a seed such as 7");
    action->seeded = true;
    ++*n;
    return true;
}

static bool take_ppm(struct fault_line *line, size_t *n, struct fault_action *action)
{
    const struct fault_word *word = &line->words[*n];

    if (!fault_decimal(word->at, word->length, 3, true, &action->value) ||
        action->value > DRIFT_MAX || action->value < -DRIFT_MAX)
        return fault_fail(line, *n, NULL, "ppm from -1000 to 1000");
    ++*n;
    return true;
}

static bool take_share(struct fault_line *line, size_t *n, struct fault_action *action)
{
    const struct fault_word *word = &line->words[*n];
    int64_t share;

    if (!fault_decimal(word->at, word->length - 1, 4, false, &share) || share == 0 ||
        share > 100 * PERCENT_ONE)
        return fault_fail(line, *n, NULL, "a share such as 0.5%, up to 100%");
    action->pick = FAULT_PICK_SHARE;
    action->pick_number = (uint64_t)share;
    if (!fault_want(line, ++*n, "frames"))
        return false;
    if (!fault_want(line, ++*n, "seed"))
        return true;
    ++*n;
    return take_seed(line, n, action);
}

/* frame | frame N | frames | N frames | P% frames [seed S]; nothing: the next frame. */
static bool take_frames(struct fault_line *line, size_t *n, struct fault_action *action)
{
    const struct fault_word *word = &line->words[*n];

    action->pick = FAULT_PICK_NEXT;
    if (word->length && word->at[word->length - 1] == '%')
        return take_share(line, n, action);
    if (fault_word_is(line, *n, "frames")) {
        action->pick = FAULT_PICK_ALL;
        ++*n;
    } else if (fault_word_is(line, *n, "frame")) {
        ++*n;
        if (fault_number(line, *n, UINT64_MAX / 2, &action->pick_number) && action->pick_number) {
            action->pick = FAULT_PICK_NUMBER;
            ++*n;
        } else {
            action->pick_number = 1;
            fault_fail(line, *n, NULL, "a frame's number");
        }
    } else if (fault_number(line, *n, UINT64_MAX / 2, &action->pick_number) &&
               action->pick_number) {
        action->pick = FAULT_PICK_COUNT;
        ++*n;
        if (!fault_word_is(line, *n, "frame") && !fault_want(line, *n, "frames"))
            return false;
        ++*n;
    } else {
        action->pick_number = 0;
        fault_want(line, *n, "frame");
        fault_want(line, *n, "frames");
        fault_fail(line, *n, NULL, "'N frames'");
        fault_fail(line, *n, NULL, "'P% frames'");
    }
    return true;
}

static const struct {
    const char *name;
    take *take;
} arguments[] = {
    { "SLAVE", take_slave },         { "CABLE", take_cable },   { "CHANNEL", take_channel },
    { "TIME", take_time },           { "CODE", take_code },     { "ABORT", take_abort },
    { "OBJECT", take_object },       { "AXIS", take_axis },     { "STATE", take_state },
    { "VALUE", take_value },         { "SEED", take_seed },     { "PPM", take_ppm },
    { "AMPLITUDE", take_amplitude }, { "FRAMES", take_frames },
};

bool fault_argument(struct fault_line *line, size_t *n, const char *name,
                    struct fault_action *action)
{
    for (size_t i = 0; i < sizeof arguments / sizeof *arguments; i++) {
        if (strcmp(arguments[i].name, name) == 0)
            return arguments[i].take(line, n, action);
    }
    return fault_fail(line, *n, NULL, name);
}
