/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * stack_state.c - what is known at an instruction: at the beginning of a function, behind a branch,
 * where ways meet, after a call.
 */
#include "image/stack.h"

static const struct stack_value any = { .kind = STACK_ANY };

void stack_begin(const struct stack *stack, struct stack_state *state, uint8_t given)
{
    const struct code_machine *machine = &stack->code.machine;
    const struct stack_value outside = { .kind = STACK_OUTSIDE };
    *state = (struct stack_state){ .compared = CODE_NONE };
    state->reg[machine->stack_register].kind = STACK_FRAME;
    if (machine->link_register != CODE_NONE)
        state->reg[machine->link_register].kind = STACK_RETURN;
    for (int i = 0; i < 4; i++) {
        if ((given >> i & 1) == 0)
            continue;
        if (machine->first_arguments[i] != CODE_NONE)
            state->reg[machine->first_arguments[i]] = outside;
        else /* above the return address */
            state->slot[state->slot_count++] =
                (struct stack_slot){ .depth = -(int64_t)machine->word * (i + 1), .value = outside };
    }
}

const struct stack_value *stack_slot(const struct stack_state *state, uint8_t base, int64_t depth)
{
    for (unsigned i = 0; i < state->slot_count; i++) {
        if (state->slot[i].depth == depth && state->slot[i].base == base)
            return &state->slot[i].value;
    }
    return NULL;
}

void stack_refine(struct stack_state *state, enum code_condition condition, bool holds)
{
    if (state->compared == CODE_NONE)
        return;
    struct stack_value *value = &state->reg[state->compared];
    int64_t most = state->compared_with;
    if (condition == (holds ? CODE_BELOW : CODE_ABOVE_EQUAL))
        most--;
    else if (condition != (holds ? CODE_BELOW_EQUAL : CODE_ABOVE))
        return;
    if (most < 0 || most > STACK_MAX_INDEX)
        return;
    if (value->kind == STACK_ANY || (value->kind == STACK_UP_TO && value->n > most) ||
        value->kind == STACK_TABLED)
        *value = (struct stack_value){ .kind = STACK_UP_TO, .n = most };
}

/* ---- ways that meet ---- */

static bool same(const struct stack_value *a, const struct stack_value *b)
{
    return a->kind == b->kind && a->base == b->base && a->shift == b->shift &&
           a->width == b->width && a->stride == b->stride && a->is_signed == b->is_signed &&
           a->n == b->n && a->plus == b->plus && a->table == b->table;
}

static struct stack_value meet(const struct stack_value *a, const struct stack_value *b)
{
    if (a->kind == STACK_TABLED || b->kind == STACK_TABLED || a->kind == STACK_ENTRY ||
        b->kind == STACK_ENTRY)
        return (struct stack_value){ .kind = STACK_TABLED };
    return any;
}

/* Of two stack pointers the deeper one. */
static bool join_depth(struct stack_value *into, const struct stack_value *from, bool *deeper)
{
    const struct stack_value before = *into;
    if (into->base != from->base)
        into->base = 2;
    if (from->n > into->n) {
        into->n = from->n;
        *deeper = true;
    }
    return !same(&before, into);
}

static bool join_slots(struct stack_state *into, const struct stack_state *from)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < into->slot_count; i++) {
        const struct stack_slot slot = into->slot[i];
        const struct stack_value *other = stack_slot(from, slot.base, slot.depth);
        if (other != NULL && same(other, &slot.value))
            into->slot[kept++] = slot;
    }
    const bool changed = kept != into->slot_count;
    into->slot_count = kept;
    return changed;
}

bool stack_join(const struct stack *stack, struct stack_state *into, const struct stack_state *from,
                bool *deeper)
{
    bool changed = join_slots(into, from);
    *deeper = false;
    for (int i = 0; i < CODE_REGISTERS; i++) {
        if (i == stack->code.machine.stack_register) {
            changed |= join_depth(&into->reg[i], &from->reg[i], deeper);
        } else if (!same(&into->reg[i], &from->reg[i])) {
            const struct stack_value both = meet(&into->reg[i], &from->reg[i]);
            changed |= !same(&both, &into->reg[i]);
            into->reg[i] = both;
        }
    }
    if (into->compared != CODE_NONE &&
        (into->compared != from->compared || into->compared_with != from->compared_with)) {
        into->compared = CODE_NONE;
        changed = true;
    }
    return changed;
}

/* ---- calls ---- */

void stack_called(const struct stack *stack, struct stack_state *state, bool keep_first)
{
    const struct code_machine *machine = &stack->code.machine;
    for (int i = 0; i < CODE_TEMP; i++) {
        if ((machine->destroyed >> i & 1) != 0 && !(i == 0 && keep_first))
            state->reg[i] = any;
    }
    state->reg[CODE_TEMP] = any;
    state->compared = CODE_NONE;
}

uint8_t stack_given(const struct stack *stack, const struct stack_state *state)
{
    const struct code_machine *machine = &stack->code.machine;
    const struct stack_value *sp = &state->reg[machine->stack_register];
    unsigned given = 0;
    for (unsigned i = 0; i < 4; i++) {
        const int reg = machine->first_arguments[i];
        const struct stack_value *value =
            reg != CODE_NONE ? &state->reg[reg]
                             : stack_slot(state, sp->base, sp->n - (int64_t)machine->word * i);
        if (value != NULL && value->kind == STACK_OUTSIDE)
            given |= 1u << i;
    }
    return (uint8_t)given;
}
