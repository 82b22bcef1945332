/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/scenario_play.h"

#include <math.h>
#include <string.h>

/* The moment of a cycle. */
struct moment {
    uint64_t cycle, now_ns;
};

struct scenario_value play_value(const struct play *play,
                                 const struct scenario_expression *expression)
{
    const struct scenario *scenario = play->scenario;
    struct scenario_value stack[SCENARIO_STACK];
    size_t top = 0;
    for (size_t i = 0; i < expression->count; i++) {
        const struct scenario_code *code = &scenario->code[expression->first + i];
        if (code->op == SCENARIO_NUMBER) {
            stack[top++] = code->value;
        } else if (code->op == SCENARIO_REGISTER) {
            stack[top++] =
                scenario_load(scenario->registers[code->index].reg.type, play->at[code->index]);
        } else if (code->op < SCENARIO_MIN) {
            stack[top - 1] = scenario_unary(code->op, stack[top - 1], code->index);
        } else {
            top--;
            stack[top - 1] = scenario_binary(code->op, stack[top - 1], stack[top]);
        }
    }
    return stack[0];
}

static struct evidence_failure *failure_of(struct evidence *evidence, size_t statement,
                                           enum evidence_failure_kind kind)
{
    for (unsigned i = 0; i < evidence->failure_count; i++)
        if (evidence->failures[i].statement == statement && evidence->failures[i].kind == kind)
            return &evidence->failures[i];
    if (evidence->failure_count == EVIDENCE_FAILURES)
        return NULL;
    struct evidence_failure *failure = &evidence->failures[evidence->failure_count];
    memset(failure, 0, sizeof *failure);
    failure->statement = (uint32_t)statement;
    failure->kind = kind;
    evidence->failure_count++;
    return failure;
}

/* `value`: what did not fit or stay; of an expectation, NULL: the registers it looked at count. */
static void fail(struct play *play, size_t statement, enum evidence_failure_kind kind,
                 const struct moment *m, const struct scenario_value *value)
{
    const struct scenario_expression *expression =
        &play->scenario->statements[statement].expression;
    struct evidence_failure *failure = failure_of(play->evidence, statement, kind);
    unsigned registers[EVIDENCE_VALUES];
    play->evidence->failed++;
    if (failure == NULL || failure->count++ > 0)
        return;
    failure->cycle = m->cycle;
    failure->time_ns = m->now_ns;
    if (value != NULL) {
        failure->values[failure->value_count++] = *value;
        return;
    }
    const size_t count = scenario_reads(play->scenario, expression, registers, EVIDENCE_VALUES);
    for (size_t i = 0; i < count; i++)
        failure->values[failure->value_count++] =
            scenario_load(play->scenario->registers[registers[i]].reg.type, play->at[registers[i]]);
}

/* --- what acts --- */

static void act_set(struct play *play, size_t statement, const struct moment *m)
{
    const struct scenario_statement *st = &play->scenario->statements[statement];
    const struct catalogue_register *reg = &play->scenario->registers[st->reg].reg;
    const struct scenario_value value = play_value(play, &st->expression);
    if (!scenario_store(reg->type, play->at[st->reg], value)) {
        fail(play, statement, FAILURE_NO_FIT, m, &value);
        return;
    }
    if (strcmp(reg->memory->type, "-") == 0)
        return; /* nobody but PLC and scenario writes there */
    play->set_by[st->reg] = (uint32_t)statement + 1;
    play->set_to[st->reg] = scenario_load(reg->type, play->at[st->reg]);
    play->set_count++;
}

/* A whole number of the range that inputs have; false: it is none. */
static bool input_value(struct scenario_value value, int64_t *whole)
{
    return scenario_store(I64, whole, value);
}

static void act_input(struct play *play, size_t statement, const struct moment *m)
{
    const struct play_route *route = &play->route[statement];
    const struct scenario_value value =
        play_value(play, &play->scenario->statements[statement].expression);
    int64_t whole = 0;
    int r = 0;
    if (!input_value(value, &whole) ||
        (route->word && route->channels < 63 && (uint64_t)whole >> route->channels != 0)) {
        fail(play, statement, FAILURE_NO_FIT, m, &value);
        return;
    }
    for (unsigned i = 0; i < route->channels && r == 0; i++)
        r = bus_set_input(play->bus, route->slave, route->channel + i,
                          route->word ? whole >> i & 1 : whole);
    if (r != 0)
        fail(play, statement, FAILURE_REFUSED, m, &value);
}

static void act_fault(struct play *play, size_t statement, const struct moment *m)
{
    char why[BUS_WHY];
    const struct scenario_value none = { 0 };
    if (bus_fault(play->bus, play->scenario->statements[statement].text, play->bus_zero + m->now_ns,
                  why) != 0)
        fail(play, statement, FAILURE_REFUSED, m, &none);
}

static void act_log(struct play *play, size_t statement, const struct moment *m)
{
    struct evidence *evidence = play->evidence;
    const struct scenario_expression *expression =
        &play->scenario->statements[statement].expression;
    if (evidence->line_count < EVIDENCE_LINES) {
        struct evidence_line *line = &evidence->lines[evidence->line_count];
        line->statement = (uint32_t)statement;
        line->time_ns = m->now_ns;
        if (expression->count > 0)
            line->value = play_value(play, expression);
    }
    evidence->line_count++;
}

/* --- the order of things --- */

static void activate(struct play *play, size_t statement, uint64_t due_ns, uint64_t until_ns)
{
    play->state[statement] = (struct play_state){ true, due_ns, until_ns };
    play->active_count++;
}

static void settle(struct play *play, size_t statement)
{
    play->state[statement].active = false;
    play->active_count--;
}

/* Something between two statements, the borders not included, is not over yet. What has no end of
 * its own does not count. */
static bool pending(const struct play *play, size_t begin, size_t end)
{
    for (size_t i = begin; i < end && play->active_count > 0; i++)
        if (play->state[i].active && play->state[i].until_ns != SCENARIO_FOREVER)
            return true;
    return false;
}

static void start_every(struct play *play, size_t statement)
{
    const struct scenario_statement *st = &play->scenario->statements[statement];
    const uint64_t from = play->origin_ns + st->from_ns, first = play->last_ns + st->every_ns;
    activate(play, statement, st->from_given ? from : first,
             st->to_ns == SCENARIO_FOREVER ? SCENARIO_FOREVER : play->origin_ns + st->to_ns);
}

static void start_block(struct play *play, size_t statement, const struct moment *m)
{
    play->blocks[play->depth++] =
        (struct play_block){ statement, play->scenario->statements[statement].rounds, m->now_ns };
    play->origin_ns = play->last_ns;
}

/* A round takes a cycle at least. False: it is not over yet. */
static bool end_round(struct play *play, const struct moment *m)
{
    struct play_block *block = &play->blocks[play->depth - 1];
    if (block->began_ns == m->now_ns || pending(play, block->statement + 1, play->next))
        return false;
    play->origin_ns = play->last_ns = m->now_ns;
    block->began_ns = m->now_ns;
    if (--block->left > 0) {
        play->next = block->statement + 1;
    } else {
        play->depth--;
        play->next++;
    }
    return true;
}

/* The statement that is due. False: it holds up those behind it. */
static bool step(struct play *play, const struct moment *m)
{
    const size_t statement = play->next;
    const struct scenario_statement *st = &play->scenario->statements[statement];
    switch (st->kind) {
    case SCENARIO_SET:
        if (play->route[statement].slave != PLAY_NO_SLAVE)
            act_input(play, statement, m);
        else
            act_set(play, statement, m);
        break;
    case SCENARIO_INPUT:
        act_input(play, statement, m);
        break;
    case SCENARIO_FAULT:
        act_fault(play, statement, m);
        break;
    case SCENARIO_PLC:
        if (play->control != NULL)
            play->control(play->control_argument, st->control);
        break;
    case SCENARIO_LOG:
        act_log(play, statement, m);
        break;
    case SCENARIO_EXPECT:
        activate(play, statement, m->now_ns, play->last_ns + st->within_ns);
        break;
    case SCENARIO_EVERY:
        start_every(play, statement);
        break;
    case SCENARIO_WAIT:
        if (!play->state[statement].active)
            activate(play, statement, m->now_ns, play->last_ns + st->within_ns);
        return false;
    case SCENARIO_REPEAT:
        start_block(play, statement, m);
        break;
    case SCENARIO_END:
        return end_round(play, m);
    case SCENARIO_STOP:
        break;
    }
    play->next++;
    return true;
}

/* Whether the next statement is due; then its time is that of "the statement before". */
static bool due(struct play *play, const struct moment *m)
{
    const struct scenario_statement *st = &play->scenario->statements[play->next];
    const uint64_t at = st->when == SCENARIO_AT      ? play->origin_ns + st->when_ns
                        : st->when == SCENARIO_AFTER ? play->last_ns + st->when_ns
                                                     : play->last_ns;
    if (at > m->now_ns)
        return false;
    play->last_ns = at; /* a wait that goes on counts anew when it is over */
    return true;
}

void play_begin(struct play *play, uint64_t bus_zero)
{
    play->bus_zero = bus_zero;
    play->next = play->depth = play->active_count = play->set_count = 0;
    play->origin_ns = play->last_ns = 0;
    memset(play->state, 0, sizeof play->state);
    memset(play->set_by, 0, sizeof play->set_by);
    play->evidence->play = PLAY_RUNNING;
}

void play_before(struct play *play, uint64_t cycle, uint64_t now_ns)
{
    const struct moment m = { cycle, now_ns };
    if (play->evidence->play != PLAY_RUNNING)
        return;
    while (play->next < play->scenario->statement_count && due(play, &m) && step(play, &m))
        ;
}

static bool same(struct scenario_value a, struct scenario_value b)
{
    return a.is_double == b.is_double && memcmp(&a.i, &b.i, sizeof a.i) == 0;
}

void play_received(struct play *play, uint64_t cycle, uint64_t now_ns)
{
    const struct moment m = { cycle, now_ns };
    const struct scenario *scenario = play->scenario;
    for (size_t i = 0; i < scenario->register_count && play->set_count > 0; i++) {
        if (play->set_by[i] == 0)
            continue;
        if (!same(scenario_load(scenario->registers[i].reg.type, play->at[i]), play->set_to[i]))
            fail(play, play->set_by[i] - 1, FAILURE_OVERWRITTEN, &m, &play->set_to[i]);
        play->set_by[i] = 0;
    }
    play->set_count = 0;
}

/* --- what is judged --- */

static void judge_every(struct play *play, size_t statement, const struct moment *m)
{
    const struct scenario_statement *st = &play->scenario->statements[statement];
    struct play_state *state = &play->state[statement];
    if (m->now_ns >= state->due_ns && m->now_ns <= state->until_ns) {
        play->evidence->checked++;
        if (!scenario_true(play_value(play, &st->expression)))
            fail(play, statement, FAILURE_EXPECTATION, m, NULL);
        state->due_ns += ((m->now_ns - state->due_ns) / st->every_ns + 1) * st->every_ns;
    }
    if (m->now_ns + play->cycle_ns > state->until_ns)
        settle(play, statement);
}

/* The times behind a wait count from the next cycle on. */
static void wait_is_over(struct play *play, const struct moment *m, bool came)
{
    play->origin_ns = play->last_ns = m->now_ns + play->cycle_ns;
    play->next++;
    if (!came)
        play->evidence->play = PLAY_GIVEN_UP;
}

static void judge(struct play *play, size_t statement, const struct moment *m)
{
    const struct scenario_statement *st = &play->scenario->statements[statement];
    const bool came = scenario_true(play_value(play, &st->expression));
    if (!came && m->now_ns + play->cycle_ns <= play->state[statement].until_ns)
        return;
    play->evidence->checked++;
    settle(play, statement);
    if (!came)
        fail(play, statement, FAILURE_EXPECTATION, m, NULL);
    if (st->kind == SCENARIO_WAIT)
        wait_is_over(play, m, came);
}

void play_after(struct play *play, uint64_t cycle, uint64_t now_ns)
{
    const struct moment m = { cycle, now_ns };
    const size_t count = play->scenario->statement_count;
    if (play->evidence->play != PLAY_RUNNING)
        return;
    for (size_t i = 0; i < count && play->active_count > 0; i++) {
        if (!play->state[i].active)
            continue;
        if (play->scenario->statements[i].kind == SCENARIO_EVERY)
            judge_every(play, i, &m);
        else
            judge(play, i, &m);
    }
    if (play->evidence->play == PLAY_RUNNING && play->next == count && !pending(play, 0, count))
        play->evidence->play = PLAY_DONE;
}
