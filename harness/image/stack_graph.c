/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * stack_graph.c - the longest way through the calls.
 *
 * A call that leads back into a function that has not returned yet is recursion; through a pointer
 * it is one that cannot be ruled out. Neither has a bound: what is below counts without that call,
 * and the reason goes up to all callers.
 */
#include "image/stack.h"

#include <stdlib.h>

enum { NEW, OPEN, DONE };

static void limit(struct stack_function *function, enum image_stack_limit why, uint64_t where)
{
    if (function->limit != IMAGE_STACK_BOUNDED)
        return;
    function->limit = why;
    function->where = where;
}

/* The next function that is called from here, and at what depth; false when there are no more. */
static bool next_call(const struct stack *stack, struct stack_function *function,
                      const struct stack_edge **edge, uint32_t *callee)
{
    while (function->next_edge < function->edge_count) {
        *edge = &function->edges[function->next_edge];
        *callee = (*edge)->callee;
        if (*callee != STACK_POINTER) {
            function->next_edge++;
            return true;
        }
        if (function->next_taken < stack->taken_function_count) {
            *callee = stack->taken_functions[function->next_taken++];
            return true;
        }
        function->next_taken = 0;
        function->next_edge++;
    }
    return false;
}

static void add_below(struct stack_function *function, const struct stack_edge *edge,
                      const struct stack_function *callee)
{
    const uint64_t depth = edge->depth + callee->total;
    if (depth > function->total)
        function->total = depth;
    function->outside |= callee->outside;
    if (callee->limit != IMAGE_STACK_BOUNDED)
        limit(function, callee->limit, callee->where);
}

void stack_graph(struct stack *stack, size_t root)
{
    struct open {
        uint32_t function;
        const struct stack_edge *edge; /* that the function below it was called by */
    } *open = calloc(stack->function_count, sizeof *open);
    size_t depth = 0;
    if (open == NULL) {
        stack->exhausted = true;
        limit(&stack->functions[root], IMAGE_STACK_LARGE, stack->functions[root].vaddr);
        return;
    }
    if (stack->functions[root].visit == NEW)
        open[depth++].function = (uint32_t)root;
    while (depth != 0) {
        struct open *top = &open[depth - 1];
        struct stack_function *function = &stack->functions[top->function];
        uint32_t callee;
        if (function->visit == NEW) {
            function->visit = OPEN;
            function->total = function->own;
        }
        if (!next_call(stack, function, &top->edge, &callee)) {
            function->visit = DONE;
            if (--depth != 0)
                add_below(&stack->functions[open[depth - 1].function], open[depth - 1].edge,
                          function);
            continue;
        }
        if (stack->functions[callee].visit == NEW)
            open[depth++].function = callee;
        else if (stack->functions[callee].visit == DONE)
            add_below(function, top->edge, &stack->functions[callee]);
        else
            limit(function,
                  top->edge->callee == STACK_POINTER ? IMAGE_STACK_POINTER : IMAGE_STACK_RECURSION,
                  top->edge->where);
    }
    free(open);
}
