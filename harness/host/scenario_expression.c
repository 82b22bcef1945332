/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Expressions to code for a stack: operators wait in a list until what follows binds less tightly,
 * so nothing here recurses, however deep the brackets of a text are.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/scan.h"
#include "host/scenario_parts.h"

enum type { WHOLE, REAL };

enum { NOT_AN_OPERATOR, LEVEL_OR, LEVEL_AND, LEVEL_COMPARE, LEVEL_UNARY = 9 };

/* C's operators; but & ^ | bind more tightly than comparisons. */
static const struct {
    const char *sign;
    enum scenario_op op;
    int level;
    bool whole; /* both operands must be */
} binaries[] = {
    { "||", SCENARIO_OR, LEVEL_OR, false },
    { "&&", SCENARIO_AND, LEVEL_AND, false },
    { "==", SCENARIO_EQUAL, LEVEL_COMPARE, false },
    { "!=", SCENARIO_UNEQUAL, LEVEL_COMPARE, false },
    { "<", SCENARIO_BELOW, LEVEL_COMPARE, false },
    { "<=", SCENARIO_AT_MOST, LEVEL_COMPARE, false },
    { ">", SCENARIO_ABOVE, LEVEL_COMPARE, false },
    { ">=", SCENARIO_AT_LEAST, LEVEL_COMPARE, false },
    { "|", SCENARIO_BITS_OR, 4, true },
    { "^", SCENARIO_BITS_XOR, 5, true },
    { "&", SCENARIO_BITS_AND, 6, true },
    { "+", SCENARIO_PLUS, 7, false },
    { "-", SCENARIO_LESS_BY, 7, false },
    { "*", SCENARIO_TIMES, 8, false },
    { "/", SCENARIO_DIVIDED, 8, false },
    { "%", SCENARIO_REST, 8, true },
};

static const struct {
    const char *sign;
    enum scenario_op op;
    bool whole;
} unaries[] = { { "-", SCENARIO_MINUS, false },
                { "!", SCENARIO_NOT, false },
                { "~", SCENARIO_FLIP, true } };

static const struct {
    const char *name;
    enum scenario_op op;
    unsigned arguments;
} functions[] = { { "abs", SCENARIO_ABS, 1 },
                  { "min", SCENARIO_MIN, 2 },
                  { "max", SCENARIO_MAX, 2 } };

#define COUNT(array) (sizeof(array) / sizeof *(array))

enum waiting_kind { OPERATOR, BRACKET, FUNCTION };

struct waiting {
    enum waiting_kind kind;
    enum scenario_op op;
    int level;
    bool unary, whole;
    unsigned arguments, commas; /* FUNCTION */
    const char *at;
};

struct compiler {
    struct reader *r;
    struct waiting waiting[SCENARIO_STACK];
    size_t waiting_count;
    enum type types[SCENARIO_STACK]; /* of the operands as they will lie on the stack */
    size_t type_count;
};

static bool too_much(struct compiler *c, const char *at)
{
    return reader_fail(c->r, at,
                       "the expression is too deep; expected at most %d open brackets "
                       "and operands",
                       SCENARIO_STACK);
}

static bool emit(struct compiler *c, const char *at, struct scenario_code code)
{
    struct scenario *s = c->r->scenario;
    if (s->code_count == SCENARIO_CODE)
        return reader_fail(c->r, at, "more operands and operators than a scenario may have");
    s->code[s->code_count++] = code;
    return true;
}

static bool operand(struct compiler *c, const char *at, enum type type, struct scenario_code code)
{
    if (c->type_count == SCENARIO_STACK)
        return too_much(c, at);
    c->types[c->type_count++] = type;
    return emit(c, at, code);
}

static bool wait_with(struct compiler *c, struct waiting waiting)
{
    if (c->waiting_count == SCENARIO_STACK)
        return too_much(c, waiting.at);
    c->waiting[c->waiting_count++] = waiting;
    return true;
}

static enum type type_of(enum scenario_op op, enum type a, enum type b)
{
    switch (op) {
    case SCENARIO_NOT:
    case SCENARIO_EQUAL:
    case SCENARIO_UNEQUAL:
    case SCENARIO_BELOW:
    case SCENARIO_AT_MOST:
    case SCENARIO_ABOVE:
    case SCENARIO_AT_LEAST:
    case SCENARIO_AND:
    case SCENARIO_OR:
        return WHOLE;
    default:
        return a == REAL || b == REAL ? REAL : WHOLE;
    }
}

/* The operator that waits on top takes its operands. */
static bool apply(struct compiler *c)
{
    const struct waiting *w = &c->waiting[--c->waiting_count];
    const size_t wanted = w->kind == FUNCTION ? w->arguments : w->unary ? 1 : 2;
    enum type *top = &c->types[c->type_count - wanted];
    const enum type second = wanted == 2 ? top[1] : top[0];
    if (w->whole && (top[0] == REAL || second == REAL))
        return reader_fail(c->r, w->at, "'%c' of a floating-point number; expected whole numbers",
                           *w->at);
    top[0] = type_of(w->op, top[0], second);
    c->type_count -= wanted - 1;
    return emit(c, w->at, (struct scenario_code){ .op = w->op });
}

/* --- operands --- */

static bool constant(struct compiler *c, const struct token *token)
{
    struct reader *r = c->r;
    const char *names[1024], *close;
    char word[64];
    int64_t value;
    size_t count = 0;
    snprintf(word, sizeof word, "%.*s", (int)(token->length < 63 ? token->length : 63), token->at);
    if (token->length < sizeof word && catalogue_constant(r->catalogue, word, &value))
        return operand(c, token->at, WHOLE,
                       (struct scenario_code){ .op = SCENARIO_NUMBER,
                                               .value = { .is_double = false, .i = value } });
    while (count < COUNT(names) && (names[count] = catalogue_constant_name(r->catalogue, count)))
        count++;
    close = scan_nearest(word, names, count);
    if (close != NULL)
        return reader_fail(r, token->at,
                           "unknown name '%s' (did you mean %s?); expected a "
                           "register, a number or a constant",
                           word, close);
    return reader_fail(r, token->at,
                       "unknown name '%s'; expected a register such as SERVO[0].Status, a number "
                       "or a constant",
                       word);
}

static bool bit(struct compiler *c, unsigned index)
{
    struct reader *r = c->r;
    const struct catalogue_register *reg = &r->scenario->registers[index].reg;
    const size_t bits = scalar_size(reg->type) * 8;
    reader_next(r); /* the bracket */
    if (r->token.kind != TOKEN_NUMBER || r->token.value.is_double)
        return reader_unexpected(r, "the number of a bit");
    if (reg->type == F32 || reg->type == F64)
        return reader_fail(r, r->token.at, "a floating-point register has no bits");
    if ((uint64_t)r->token.value.i >= bits)
        return reader_fail(r, r->token.at, "there is no such bit; expected 0 to %zu", bits - 1);
    if (!emit(c, r->token.at,
              (struct scenario_code){ .op = SCENARIO_BIT, .index = (unsigned)r->token.value.i }))
        return false;
    reader_next(r);
    return reader_take(r, ")") || reader_unexpected(r, "')'");
}

static bool register_operand(struct compiler *c, const struct token *token)
{
    struct reader *r = c->r;
    size_t length = token->length;
    unsigned index;
    const bool has_bit =
        length > 4 && memcmp(token->at + length - 4, ".bit", 4) == 0 && reader_is(r, "(");
    length -= has_bit ? 4 : 0;
    if (!reader_register(r, token->at, length, &index))
        return false;
    const enum scalar type = r->scenario->registers[index].reg.type;
    return operand(c, token->at, type == F32 || type == F64 ? REAL : WHOLE,
                   (struct scenario_code){ .op = SCENARIO_REGISTER, .index = index }) &&
           (!has_bit || bit(c, index));
}

static bool function(struct compiler *c, const struct token *token, bool *known)
{
    for (size_t i = 0; i < COUNT(functions); i++)
        if (strlen(functions[i].name) == token->length &&
            memcmp(functions[i].name, token->at, token->length) == 0) {
            *known = true;
            return wait_with(c, (struct waiting){ .kind = FUNCTION,
                                                  .op = functions[i].op,
                                                  .arguments = functions[i].arguments,
                                                  .at = token->at });
        }
    *known = false;
    return false;
}

/* A word: function, register or constant. `more`: an operand must still follow. */
static bool word(struct compiler *c, bool *more)
{
    struct reader *r = c->r;
    const struct token token = r->token;
    const bool path =
        memchr(token.at, '.', token.length) != NULL || memchr(token.at, '[', token.length) != NULL;
    reader_next(r);
    *more = false;
    if (!path && reader_is(r, "(")) {
        if (!function(c, &token, more))
            return reader_fail(r, token.at, "there is no function '%.*s'; expected abs, min or max",
                               (int)(token.length < 40 ? token.length : 40), token.at);
        reader_next(r);
        return true;
    }
    return path ? register_operand(c, &token) : constant(c, &token);
}

/* At a place where an operand belongs; `more`: it still does afterwards. */
static bool read_operand(struct compiler *c, bool *more)
{
    static const char expected[] = "a register, a number or '('";
    struct reader *r = c->r;
    const struct token token = r->token;
    *more = true;
    if (token.kind == TOKEN_WORD)
        return word(c, more);
    if (token.kind == TOKEN_NUMBER) {
        *more = false;
        reader_next(r);
        return operand(c, token.at, token.value.is_double ? REAL : WHOLE,
                       (struct scenario_code){ .op = SCENARIO_NUMBER, .value = token.value });
    }
    if (reader_take(r, "("))
        return wait_with(c, (struct waiting){ .kind = BRACKET, .at = token.at });
    for (size_t i = 0; i < COUNT(unaries); i++)
        if (reader_take(r, unaries[i].sign))
            return wait_with(c, (struct waiting){ .op = unaries[i].op,
                                                  .level = LEVEL_UNARY,
                                                  .unary = true,
                                                  .whole = unaries[i].whole,
                                                  .at = token.at });
    return reader_unexpected(r, expected);
}

/* --- what stands behind operands --- */

/* Operators that bind at least so tightly, down to a bracket or function. */
static bool apply_down_to(struct compiler *c, int level)
{
    while (c->waiting_count > 0 && c->waiting[c->waiting_count - 1].kind == OPERATOR &&
           c->waiting[c->waiting_count - 1].level >= level)
        if (!apply(c))
            return false;
    return true;
}

static bool read_binary(struct compiler *c, size_t i)
{
    struct reader *r = c->r;
    const struct token token = r->token;
    const int level = binaries[i].level;
    if (!apply_down_to(c, level + 1))
        return false;
    const struct waiting *top = c->waiting_count > 0 ? &c->waiting[c->waiting_count - 1] : NULL;
    if (level == LEVEL_COMPARE && top != NULL && top->kind == OPERATOR && top->level == level)
        return reader_fail(r, token.at, "a comparison of a comparison; expected && between two");
    if (!apply_down_to(c, level))
        return false;
    reader_next(r);
    return wait_with(
        c, (struct waiting){
               .op = binaries[i].op, .level = level, .whole = binaries[i].whole, .at = token.at });
}

static bool read_close(struct compiler *c)
{
    struct reader *r = c->r;
    if (!apply_down_to(c, NOT_AN_OPERATOR))
        return false;
    struct waiting *top = &c->waiting[c->waiting_count - 1];
    if (top->kind == FUNCTION && top->commas + 1 != top->arguments)
        return reader_unexpected(r, "',' and another argument");
    reader_next(r);
    if (top->kind == FUNCTION)
        return apply(c);
    c->waiting_count--;
    return true;
}

static bool read_comma(struct compiler *c)
{
    if (!apply_down_to(c, NOT_AN_OPERATOR))
        return false;
    struct waiting *top = &c->waiting[c->waiting_count - 1];
    if (top->kind != FUNCTION || top->commas + 1 == top->arguments)
        return reader_unexpected(c->r, "')'");
    top->commas++;
    reader_next(c->r);
    return true;
}

static bool is_inside(const struct compiler *c)
{
    for (size_t i = 0; i < c->waiting_count; i++)
        if (c->waiting[i].kind != OPERATOR)
            return true;
    return false;
}

/* Behind an operand. `more`: an operand must follow; `over`: the expression ends here. */
static bool read_behind(struct compiler *c, bool *more, bool *over)
{
    struct reader *r = c->r;
    *more = *over = false;
    for (size_t i = 0; i < COUNT(binaries); i++)
        if (reader_is(r, binaries[i].sign)) {
            *more = true;
            return read_binary(c, i);
        }
    if (reader_is(r, "="))
        return reader_unexpected(r, "'==', which compares");
    if (is_inside(c) && reader_is(r, ")"))
        return read_close(c);
    if (is_inside(c) && reader_is(r, ",")) {
        *more = true;
        return read_comma(c);
    }
    if (is_inside(c))
        return reader_unexpected(r, "an operator or ')'");
    *over = true;
    return true;
}

bool reader_expression(struct reader *r, struct scenario_expression *expression)
{
    struct compiler c = { .r = r };
    const char *begin = r->token.at, *end = begin;
    bool more = true, over = false;
    expression->first = r->scenario->code_count;
    expression->column = reader_column(r, begin);
    while (!over) {
        if (more ? !read_operand(&c, &more) : !read_behind(&c, &more, &over))
            return false;
        if (!over)
            end = r->token.at;
    }
    while (c.waiting_count > 0)
        if (!apply(&c))
            return false;
    while (end > begin && (end[-1] == ' ' || end[-1] == '\t' || end[-1] == '\r'))
        end--;
    expression->count = r->scenario->code_count - expression->first;
    expression->text = reader_keep(r, begin, (size_t)(end - begin));
    return r->why[0] == '\0';
}
