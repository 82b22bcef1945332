/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The parser of the fault script: when, which verb, its arguments by the grammar of its row. Every
 * row of the name is tried; the message speaks of the place that the best of them got to. */
#include "bus/fault_words.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

/* --- grammar --- */

/* The next word of a grammar; an empty one at its end. */
static const char *next_word(const char **grammar, char word[24])
{
    size_t length;

    *grammar += strspn(*grammar, " ");
    length = strcspn(*grammar + (**grammar == '['), " ]") + (**grammar == '[');
    snprintf(word, 24, "%.*s", (int)length, *grammar);
    *grammar += length;
    return word;
}

static bool is_argument(const char *word)
{
    return word[0] >= 'A' && word[0] <= 'Z';
}

static bool match_word(struct fault_line *line, size_t *n, const char *word,
                       struct fault_action *action)
{
    if (is_argument(word))
        return fault_argument(line, n, word, action);
    if (!fault_want(line, *n, word))
        return false;
    ++*n;
    return true;
}

/* An optional part is there when its first word is. */
static bool optional_there(struct fault_line *line, size_t n, const char *word)
{
    if (is_argument(word))
        return n < line->count && !fault_word_is(line, n, "for");
    return fault_want(line, n, word);
}

static bool match(struct fault_line *line, size_t *n, const char *grammar,
                  struct fault_action *action)
{
    unsigned option = 0;
    char buffer[24];

    for (;;) {
        const char *word = next_word(&grammar, buffer);

        if (!word[0])
            return true;
        if (word[0] == '[') {
            option++;
            if (!optional_there(line, *n, word + 1)) {
                grammar += strcspn(grammar, "]") + 1;
                continue;
            }
            action->given |= 1u << (option - 1);
            word++;
        }
        if (!match_word(line, n, word, action))
            return false;
        grammar += *grammar == ']';
    }
}

static bool match_for(struct fault_line *line, size_t *n, struct fault_action *action)
{
    if (action->verb->kind == FAULT_MOMENT || !fault_want(line, *n, "for"))
        return true;
    ++*n;
    if (!fault_time(line, *n, &action->lasts_ns) || !action->lasts_ns)
        return fault_fail(line, *n, NULL, FAULT_TIME_WANTED);
    ++*n;
    return true;
}

/* What can be known only from all of the words. */
static bool check_action(struct fault_line *line, struct fault_action *action)
{
    const struct slave *slave = &line->segment->slaves[action->place ? action->place - 1 : 0];
    char what[FAULTS_WHY / 2];
    const char *wanted;

    if (!action->axis)
        action->axis = 1;
    if (!action->place || !action->verb->refuse)
        return true;
    wanted = action->verb->refuse(action, slave);
    if (!wanted)
        return true;
    snprintf(what, sizeof what, "slave %zu (%s) cannot have this fault", action->place,
             slave->type->name);
    fault_start_over(line, line->place_at);
    return fault_fail(line, line->place_at, what, wanted);
}

static void keep_text(const struct fault_line *line, size_t first, struct fault_action *action)
{
    size_t at = 0;

    for (size_t i = first; i < line->count; i++) {
        char word[48];
        int more = snprintf(action->text + at, sizeof action->text - at, "%s%s",
                            i > first ? " " : "", fault_word_text(line, i, word));

        if ((size_t)more >= sizeof action->text - at)
            return;
        at += (size_t)more;
    }
}

/* Edit distance, for words of ordinary length. */
static unsigned distance(const char *a, const char *b)
{
    unsigned row[48];
    size_t width = strlen(b);

    for (unsigned k = 0; k <= width; k++)
        row[k] = k;
    for (unsigned i = 0; a[i]; i++) {
        unsigned diagonal = row[0];

        row[0] = i + 1;
        for (size_t k = 0; k < width; k++) {
            unsigned above = row[k + 1], best = diagonal + (a[i] != b[k]);

            best = best < above + 1 ? best : above + 1;
            row[k + 1] = best < row[k] + 1 ? best : row[k] + 1;
            diagonal = above;
        }
    }
    return row[width];
}

static bool unknown_verb(struct fault_line *line, size_t n)
{
    const char *nearest = NULL;
    char word[48], what[FAULTS_WHY / 2];
    unsigned best;

    fault_word_text(line, n, word);
    best = (unsigned)strlen(word) / 3 + 2;
    for (size_t i = 0; fault_verb(i); i++) {
        unsigned d = distance(word, fault_verb(i)->name);

        if (d < best) {
            best = d;
            nearest = fault_verb(i)->name;
        }
    }
    if (nearest)
        snprintf(what, sizeof what, "unknown fault '%s' (did you mean '%s'?)", word, nearest);
    else
        snprintf(what, sizeof what, "unknown fault '%s'", word);
    for (size_t i = 0; fault_verb(i); i++)
        fault_fail(line, n, line->count > n ? what : NULL, fault_verb(i)->name);
    return false;
}

/* Words from n to the end of the line. */
static bool read_action(struct fault_line *line, size_t n, struct fault_action *action)
{
    bool known = false;

    for (size_t i = 0; fault_verb(i); i++) {
        struct fault_action attempt = { .verb = fault_verb(i) };
        size_t at = n + 1;

        if (!fault_word_is(line, n, attempt.verb->name))
            continue;
        known = true;
        if (!match(line, &at, attempt.verb->grammar, &attempt) || !match_for(line, &at, &attempt))
            continue;
        if (at < line->count) {
            fault_fail(line, at, NULL, "the end of the line");
            continue;
        }
        keep_text(line, n, &attempt);
        *action = attempt;
        return check_action(line, action);
    }
    return known ? false : unknown_verb(line, n);
}

/* --- when --- */

static bool read_time(struct fault_line *line, size_t *n, bool *start, uint64_t *ns)
{
    if (start && fault_word_is(line, *n, "start")) {
        *start = true;
        *ns = 0;
    } else if (!fault_time(line, *n, ns)) {
        return fault_fail(line, *n, NULL, FAULT_TIME_WANTED);
    }
    ++*n;
    return true;
}

static bool read_to(struct fault_line *line, size_t *n, struct fault_schedule *when)
{
    if (!fault_want(line, *n, "to"))
        return false;
    ++*n;
    if (!read_time(line, n, NULL, &when->to_ns))
        return false;
    if (when->to_ns <= when->at_ns && !when->from_start)
        return fault_fail(line, *n - 1, "the end is not behind the begin", "a later time");
    return true;
}

static bool read_every(struct fault_line *line, size_t *n, struct fault_schedule *when)
{
    if (!fault_time(line, *n, &when->every_ns) || !when->every_ns)
        return fault_fail(line, *n, NULL, FAULT_TIME_WANTED);
    ++*n;
    when->at_ns = when->every_ns;
    if (!fault_want(line, *n, "from"))
        return true;
    ++*n;
    return read_time(line, n, NULL, &when->at_ns) && read_to(line, n, when);
}

static bool read_when(struct fault_line *line, size_t *n, struct fault_schedule *when)
{
    static const char *const words[] = { "at", "from", "every", "frame" };
    size_t which = 0;

    *when = (struct fault_schedule){ .to_ns = FAULT_NEVER };
    while (which < 4 && !fault_word_is(line, *n, words[which]))
        fault_fail(line, *n, NULL, words[which++]);
    ++*n;
    switch (which) {
    case 0:
        return read_time(line, n, &when->from_start, &when->at_ns);
    case 1:
        return read_time(line, n, &when->from_start, &when->at_ns) && read_to(line, n, when);
    case 2:
        return read_every(line, n, when);
    case 3:
        if (!fault_number(line, *n, UINT64_MAX / 2, &when->frame) || !when->frame)
            return fault_fail(line, *n, NULL, "a frame's number, from 1");
        ++*n;
        return true;
    default:
        return false;
    }
}

/* Whether such a fault can happen at such a time. */
static bool check_when(struct fault_line *line, size_t verb_at, const struct fault_schedule *when,
                       const struct fault_action *action)
{
    bool moment = action->verb->kind == FAULT_MOMENT, interval = when->to_ns != FAULT_NEVER;
    bool frames = action->verb->kind == FAULT_FRAMES;
    bool counted = frames && (action->pick == FAULT_PICK_NEXT || action->pick == FAULT_PICK_COUNT);
    uint64_t lasts_ns = action->lasts_ns ? action->lasts_ns : action->verb->lasts_ns;

    fault_start_over(line, verb_at);
    if (interval && !when->every_ns && moment)
        return fault_fail(line, verb_at, "this is over at once", "'at' and a time in front of it");
    if (interval && !when->every_ns && lasts_ns)
        return fault_fail(line, verb_at, "this lasts by itself", "'at' and a time in front of it");
    if (frames && action->pick == FAULT_PICK_NEXT && !action->pick_number &&
        ((interval && !when->every_ns) || action->lasts_ns))
        return fault_fail(line, verb_at, "which frames",
                          "'frame', 'frames', 'N frames' or 'P% frames'");
    if ((when->every_ns || when->frame) && frames && action->pick == FAULT_PICK_NUMBER)
        return fault_fail(line, verb_at, "two times for one fault", "'N frames'");
    if (when->every_ns && !moment && !counted && !lasts_ns)
        return fault_fail(line, verb_at, "how long each time is open",
                          "'for' and a time at the end of the line");
    if (when->every_ns && lasts_ns >= when->every_ns)
        return fault_fail(line, verb_at, "this lasts until it begins again", "a shorter time");
    return true;
}

/* --- texts --- */

static int told(const struct fault_line *line, const char *place, char why[FAULTS_WHY])
{
    int at = snprintf(why, FAULTS_WHY, "%s%u: ", place, line->words[line->failed_at].column);

    fault_line_tell(line, why + at, FAULTS_WHY - (size_t)at);
    return -EINVAL;
}

static bool read_statement(struct fault_line *line, struct fault_statement *st)
{
    size_t n = 0;

    memset(st, 0, sizeof *st);
    return read_when(line, &n, &st->when) && read_action(line, n, &st->action) &&
           check_when(line, n, &st->when, &st->action);
}

static int parse(struct fault_action *action, const char *text, const struct segment *segment,
                 const char *place, char why[FAULTS_WHY])
{
    struct fault_line line;

    why[0] = '\0';
    if (fault_line_split(&line, segment, text, strlen(text)) && read_action(&line, 0, action))
        return 0;
    return told(&line, place, why);
}

int fault_parse(struct fault_action *action, const char *text, const struct segment *segment,
                char why[FAULTS_WHY])
{
    return parse(action, text, segment, "column ", why);
}

int fault_check(const char *text, const struct segment *segment, const char *place,
                char why[FAULTS_WHY])
{
    struct fault_action unused;
    char before[FAULTS_WHY / 2];

    snprintf(before, sizeof before, "%.120s:", place);
    return parse(&unused, text, segment, before, why);
}

int fault_script_read(const char *text, size_t length, const char *name,
                      const struct segment *segment, struct fault_statement *rows, size_t *count,
                      char why[FAULTS_WHY])
{
    const char *end = text + length;
    char place[FAULTS_WHY / 2];

    why[0] = '\0';
    *count = 0;
    for (unsigned number = 1; text < end; number++) {
        const char *newline = memchr(text, '\n', (size_t)(end - text));
        size_t size = (size_t)((newline ? newline : end) - text);
        struct fault_statement unused;
        struct fault_line line;
        bool good = fault_line_split(&line, segment, text, size);

        text += size + (newline != NULL);
        if (good && !line.count)
            continue;
        if (*count == FAULTS_STATEMENTS)
            good = fault_fail(&line, 0, "too many statements", "1000 at most");
        snprintf(place, sizeof place, "%.100s:%u:", name, number);
        if (!good || !read_statement(&line, rows ? &rows[*count] : &unused))
            return told(&line, place, why);
        ++*count;
    }
    return 0;
}
