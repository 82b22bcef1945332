/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * stack_returns.c - does a function return, and how much of its arguments does it take with it
 * (stdcall)? Whoever calls it has to know before the function itself has been walked.
 */
#include "image/stack.h"

#include <stdlib.h>

#define MAX_LOOKED_AT 4096u /* instructions of one function; after that it is taken to return */

struct search {
    struct stack *stack;
    struct code_map seen;
    uint64_t *waiting; /* address << 1 | Thumb bit */
    size_t waiting_count, looked_at;
    bool maybe; /* control goes where it is not followed here */
};

static void look_at_later(struct search *search, uint64_t vaddr, bool thumb)
{
    const uint64_t key = vaddr << 1 | thumb;
    uint32_t known;
    if (code_map_get(&search->seen, key, &known))
        return;
    if (!code_map_put(&search->seen, key, 0) ||
        !image_make_room(&search->waiting, search->waiting_count, sizeof search->waiting[0])) {
        search->maybe = true;
        return;
    }
    search->waiting[search->waiting_count++] = key;
}

/* True at a return. */
static bool look_at(struct search *search, uint64_t vaddr, bool thumb, uint32_t *pops)
{
    const struct code_insn *insn = code_at(&search->stack->code, vaddr, thumb);
    uint32_t known;
    if (insn == NULL)
        return false;
    *pops = insn->pops;
    if (insn->flow == CODE_RETURN)
        return true;
    const uint64_t callee = insn->target << 1 | insn->target_thumb;
    const bool ends = insn->flow == CODE_CALL &&
                      code_map_get(&search->stack->returns, callee, &known) &&
                      known == STACK_NO_RETURN;
    if (insn->flow == CODE_JUMP_VALUE)
        search->maybe = true;
    if (insn->flow == CODE_JUMP)
        look_at_later(search, insn->target, insn->target_thumb);
    if (insn->condition != CODE_ALWAYS || insn->flow == CODE_NEXT ||
        insn->flow == CODE_CALL_VALUE || (insn->flow == CODE_CALL && !ends))
        look_at_later(search, insn->vaddr + insn->size, thumb);
    return false;
}

uint32_t stack_returns(struct stack *stack, uint64_t vaddr, bool thumb)
{
    const uint64_t key = vaddr << 1 | thumb;
    struct search search = { .stack = stack };
    uint32_t pops = 0;
    bool found = false;
    if (code_map_get(&stack->returns, key, &pops))
        return pops;
    look_at_later(&search, vaddr, thumb);
    while (!found && search.waiting_count != 0 && search.looked_at++ < MAX_LOOKED_AT) {
        const uint64_t next = search.waiting[--search.waiting_count];
        found = look_at(&search, next >> 1, (next & 1) != 0, &pops);
    }
    if (!found)
        pops = search.maybe || search.waiting_count != 0 ? 0 : STACK_NO_RETURN;
    if (!code_map_put(&stack->returns, key, pops))
        stack->exhausted = true;
    free(search.waiting);
    code_map_free(&search.seen);
    return pops;
}
