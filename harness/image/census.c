/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "image/census.h"

#include <stdlib.h>
#include <string.h>

#include "image/stack.h"

#define MAX_FOUND (1u << 20)

void census_add(struct census *census, const struct image_special *special)
{
    if (census->special_count < CENSUS_SPECIALS)
        census->specials[census->special_count++] = *special;
}

static void lose(struct census_search *search, uint64_t where)
{
    if (!search->census->complete)
        return;
    search->census->complete = false;
    search->census->lost = where;
}

static void reach(struct census_search *search, uint64_t vaddr, bool thumb)
{
    const uint64_t key = vaddr << 1 | thumb;
    uint32_t known;
    if (search->exhausted || code_map_get(&search->seen, key, &known) ||
        !code_is_code(&search->stack->code, vaddr))
        return;
    if (search->found_count == MAX_FOUND || !code_map_put(&search->seen, key, 0) ||
        !image_make_room(&search->waiting, search->waiting_count, sizeof search->waiting[0]) ||
        !image_make_room(&search->found, search->found_count, sizeof search->found[0])) {
        search->exhausted = true;
        lose(search, vaddr);
        return;
    }
    search->waiting[search->waiting_count++] = key;
    search->found[search->found_count++] = key;
}

static void note_special(struct census_search *search, const struct code_insn *insn)
{
    struct image_special special = { .vaddr = insn->vaddr,
                                     .from = search->root,
                                     .kind = (enum image_special_kind)insn->special,
                                     .how = search->how };
    code_text(&search->stack->code, insn->vaddr, insn->thumb, special.text, sizeof special.text);
    census_add(search->census, &special);
}

/* ---- jumps through registers and tables ---- */

static int compare_jumps(const void *left, const void *right)
{
    const struct stack_jump *a = left, *b = right;
    if (a->where != b->where)
        return a->where > b->where ? 1 : -1;
    if (a->target != b->target)
        return a->target > b->target ? 1 : -1;
    return (int)a->kind - (int)b->kind;
}

static size_t first_jump(const struct stack *stack, uint64_t where)
{
    size_t low = 0, high = stack->jump_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (stack->jumps[middle].where < where)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* The end of the function that holds the address, 0 when the file does not say. */
static uint64_t function_end(const struct image *image, uint64_t vaddr)
{
    for (size_t i = 0; i < image->symbol_count && image->symbols[i].vaddr <= vaddr; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        if (symbol->kind == IMAGE_SYMBOL_FUNC && symbol->executable &&
            vaddr - symbol->vaddr < symbol->size)
            return symbol->vaddr + symbol->size;
    }
    return 0;
}

/* Nobody knows where the jump leads: within its function, it is taken to lead everywhere. */
static void sweep(struct census_search *search, const struct code_insn *insn)
{
    const bool arm = search->stack->code.machine.link_register != CODE_NONE;
    const bool thumb = insn->thumb;
    const uint64_t where = insn->vaddr, end = function_end(search->stack->code.image, where);
    uint64_t at = where + insn->size;
    if (end == 0)
        lose(search, where);
    while (at < end && !search->exhausted) {
        const struct code_insn *next = code_at(&search->stack->code, at, thumb);
        if (next != NULL)
            reach(search, at, thumb);
        at += next != NULL ? next->size : !arm ? 1 : thumb ? 2 : 4;
    }
}

/* Reaches the places that are known; false when there are others. */
static bool reach_known(struct census_search *search, uint64_t where)
{
    const struct stack *stack = search->stack;
    size_t i = first_jump(stack, where);
    bool lost = i == stack->jump_count || stack->jumps[i].where != where;
    for (; i < stack->jump_count && stack->jumps[i].where == where; i++) {
        lost |= stack->jumps[i].kind == STACK_JUMP_LOST;
        if (stack->jumps[i].kind == STACK_JUMP_TO)
            reach(search, stack->jumps[i].target, stack->jumps[i].thumb);
    }
    return !lost;
}

/* ---- control ---- */

static void follow(struct census_search *search, const struct code_insn *insn)
{
    const struct code_insn copy = *insn;
    const uint64_t next = copy.vaddr + copy.size;
    if (copy.condition != CODE_ALWAYS || copy.flow == CODE_NEXT || copy.flow == CODE_CALL_VALUE)
        reach(search, next, copy.thumb);
    switch ((enum code_flow)copy.flow) {
    case CODE_JUMP:
        reach(search, copy.target, copy.target_thumb);
        break;
    case CODE_JUMP_VALUE:
        if (!reach_known(search, copy.vaddr))
            sweep(search, &copy);
        break;
    case CODE_CALL:
        reach(search, copy.target, copy.target_thumb);
        if (stack_returns(search->stack, copy.target, copy.target_thumb) != STACK_NO_RETURN)
            reach(search, next, copy.thumb);
        break;
    case CODE_STOP: /* what raises an exception may come back */
        if (copy.special == IMAGE_SPECIAL_SYSTEM || copy.special == IMAGE_SPECIAL_PRIVILEGED)
            reach(search, next, copy.thumb);
        break;
    case CODE_CALL_VALUE: /* the rest comes with the functions that the module has addresses of */
        reach_known(search, copy.vaddr);
        break;
    case CODE_NEXT:
    case CODE_RETURN:
        break;
    }
}

static void flood(struct census_search *search, uint64_t root, bool thumb,
                  enum image_special_how how)
{
    search->root = root;
    search->how = how;
    reach(search, root, thumb);
    while (search->waiting_count != 0) {
        const uint64_t key = search->waiting[--search->waiting_count];
        const struct code_insn *insn = code_at(&search->stack->code, key >> 1, (key & 1) != 0);
        if (insn == NULL) {
            if (search->stack->code.exhausted && how != IMAGE_SPECIAL_UNREACHED)
                lose(search, key >> 1);
            continue;
        }
        if (insn->special != IMAGE_SPECIAL_NONE)
            note_special(search, insn);
        follow(search, insn);
    }
}

static void flood_taken(struct census_search *search)
{
    const struct stack *stack = search->stack;
    for (size_t i = 0; i < stack->taken_function_count; i++) {
        const struct stack_function *function = &stack->functions[stack->taken_functions[i]];
        flood(search, function->vaddr, function->thumb, IMAGE_SPECIAL_POINTER);
    }
}

/* Functions of the file that nothing was seen to lead to. What is lost in them is no matter. */
static void flood_rest(struct census_search *search)
{
    const struct image *image = search->stack->code.image;
    const bool complete = search->census->complete;
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        if (symbol->kind == IMAGE_SYMBOL_FUNC && symbol->executable)
            flood(search, symbol->vaddr, symbol->thumb, IMAGE_SPECIAL_UNREACHED);
    }
    for (size_t i = 0; i < image->initialiser_count; i++)
        if (image->initialisers[i].vaddr != 0)
            flood(search, image->initialisers[i].vaddr,
                  stack_is_thumb(image, image->initialisers[i].vaddr), IMAGE_SPECIAL_UNREACHED);
    search->census->complete = complete;
}

static int compare_specials(const void *left, const void *right)
{
    const struct image_special *a = left, *b = right;
    if (a->how != b->how)
        return (int)a->how - (int)b->how;
    return (a->vaddr > b->vaddr) - (a->vaddr < b->vaddr);
}

void census_take(struct stack *stack, const struct image_routine *routines, size_t count,
                 struct census *census)
{
    const struct image *image = stack->code.image;
    struct census_search search = { .stack = stack, .census = census };
    census->complete = true;
    if (stack->jump_count != 0)
        qsort(stack->jumps, stack->jump_count, sizeof stack->jumps[0], compare_jumps);
    for (size_t i = 0; i < count; i++)
        flood(&search, routines[i].vaddr, stack_is_thumb(image, routines[i].vaddr),
              IMAGE_SPECIAL_REACHED);
    flood_taken(&search);
    flood_rest(&search);
    census_users(&search);
    census_bytes(&search);
    census->entry_idle = image->has_entry_point && census_is_idle(stack, image->entry_point);
    if (census->special_count != 0)
        qsort(census->specials, census->special_count, sizeof census->specials[0],
              compare_specials);
    free(search.waiting);
    free(search.found);
    code_map_free(&search.seen);
}
