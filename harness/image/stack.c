/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * stack.c - which functions are looked at, and what comes out of it.
 *
 * A call through a pointer reaches a function of TG Motion or one of the module whose address the
 * module has: relocations and code say which those are, and in a flat image, which has no
 * relocations, its words. Not every address of code is a function: one that does not read like one
 * is left out, unless a symbol says so.
 */
#include "image/stack.h"

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#define MAX_ROUTINES 4096u

/* Written by the child, untrusted; the addresses of the routines are the parent's. */
struct block {
    uint32_t complete;
    size_t count;
    struct image_routine routines[MAX_ROUTINES];
    struct census census; /* its users[] follow */
};

/* ---- functions whose address the module has ---- */

static bool in_table(const struct stack *stack, uint64_t vaddr)
{
    for (size_t i = 0; i < stack->table_count; i++) {
        if (vaddr >= stack->tables[i].begin && vaddr < stack->tables[i].end)
            return true;
    }
    return false;
}

static const struct image_symbol *function_symbol(const struct image *image, uint64_t vaddr)
{
    size_t low = 0, high = image->symbol_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (image->symbols[middle].vaddr < vaddr)
            low = middle + 1;
        else
            high = middle;
    }
    for (; low < image->symbol_count && image->symbols[low].vaddr == vaddr; low++) {
        const struct image_symbol *symbol = &image->symbols[low];
        if (symbol->executable && (symbol->kind == IMAGE_SYMBOL_FUNC || symbol->exported))
            return symbol;
    }
    return NULL;
}

static bool is_arm(const struct stack *stack)
{
    return stack->code.image->target == IMAGE_TARGET_ARM;
}

static void take_relocated(struct stack *stack)
{
    const struct image *image = stack->code.image;
    for (size_t i = 0; i < image->reloc_count; i++) {
        const uint64_t vaddr = (uint64_t)image->relocs[i].addend;
        if (image->relocs[i].kind == IMAGE_RELOC_RELATIVE &&
            code_is_code(&stack->code, is_arm(stack) ? vaddr & ~1ull : vaddr) &&
            !in_table(stack, image->relocs[i].vaddr))
            stack_take(stack, vaddr);
    }
}

/* What a flat image hands out is called by TG Motion. */
static void take_words(struct stack *stack)
{
    const struct image *image = stack->code.image;
    for (uint64_t at = 0; at + 4 <= image->size; at += 4) {
        const uint64_t vaddr = image_word(image, IMAGE_FLAT_BASE + at, 4);
        const struct image_symbol *symbol;
        if (!code_is_code(&stack->code, vaddr & ~1ull) || in_table(stack, IMAGE_FLAT_BASE + at))
            continue;
        symbol = function_symbol(image, vaddr & ~1ull);
        if (symbol == NULL || !symbol->exported)
            stack_take(stack, vaddr);
    }
}

/* An Arm function begins unconditionally, text does not. */
static bool may_begin(const struct stack *stack, uint64_t vaddr)
{
    if (in_table(stack, vaddr & ~1ull))
        return false;
    return !is_arm(stack) || (vaddr & 1) != 0 ||
           (vaddr % 4 == 0 && image_word(stack->code.image, vaddr, 4) >> 28 == 0xe);
}

static bool reads_like_one(const struct stack *stack, const struct stack_function *function)
{
    return function_symbol(stack->code.image, function->vaddr) != NULL ||
           (function->limit != IMAGE_STACK_CODE && function->limit != IMAGE_STACK_UNBALANCED &&
            function->limit != IMAGE_STACK_VARIABLE);
}

static void add_taken_function(struct stack *stack, uint32_t index)
{
    if (!image_make_room(&stack->taken_functions, stack->taken_function_count,
                         sizeof stack->taken_functions[0])) {
        stack->exhausted = true;
        return;
    }
    stack->taken_functions[stack->taken_function_count++] = index;
}

/* ---- the whole ---- */

static size_t walk_new(struct stack *stack, size_t walked)
{
    while (walked < stack->function_count)
        stack_walk(stack, walked++);
    return walked;
}

static void walk_taken(struct stack *stack, size_t walked)
{
    take_relocated(stack);
    if (stack->code.image->format == IMAGE_FORMAT_FLAT)
        take_words(stack);
    for (size_t i = 0; i < stack->taken_count; i++) {
        const uint64_t vaddr = stack->taken[i];
        const bool thumb = is_arm(stack) && (vaddr & 1) != 0;
        if (!may_begin(stack, vaddr))
            continue;
        const uint32_t index = stack_function_at(stack, thumb ? vaddr & ~1ull : vaddr, thumb, 0);
        walked = walk_new(stack, walked);
        if (index != STACK_POINTER && reads_like_one(stack, &stack->functions[index]))
            add_taken_function(stack, index);
    }
}

bool stack_is_thumb(const struct image *image, uint64_t vaddr)
{
    const struct image_symbol *symbol = function_symbol(image, vaddr);
    return symbol != NULL && symbol->thumb;
}

static void describe(struct stack *stack, struct image_routine *routine, uint32_t index)
{
    if (index == STACK_POINTER)
        return;
    const uint64_t word = stack->code.machine.word;
    stack_graph(stack, index);
    const struct stack_function *function = &stack->functions[index];
    routine->size = function->size;
    routine->stack = function->total + stack->code.machine.call_bytes;
    routine->stack = (routine->stack + word - 1) & ~(word - 1);
    routine->limit = function->limit;
    routine->where = function->where;
    routine->outside = function->outside;
    if (stack->exhausted && routine->limit == IMAGE_STACK_BOUNDED) {
        routine->limit = IMAGE_STACK_LARGE;
        routine->where = routine->vaddr;
    }
}

static void free_stack(struct stack *stack)
{
    for (size_t i = 0; i < stack->function_count; i++)
        free(stack->functions[i].edges);
    free(stack->functions);
    free(stack->taken);
    free(stack->taken_functions);
    free(stack->tables);
    free(stack->jumps);
    code_map_free(&stack->function_of);
    code_map_free(&stack->returns);
    code_map_free(&stack->is_taken);
    code_close(&stack->code);
}

void stack_measure(const struct image *image, struct image_routine *routines, size_t count,
                   struct census *census)
{
    struct stack stack = { 0 };
    uint32_t *roots = calloc(count + 1, sizeof roots[0]);
    if (roots == NULL || !code_open(&stack.code, image)) {
        free(roots);
        return;
    }
    for (size_t i = 0; i < count; i++)
        roots[i] = stack_function_at(&stack, routines[i].vaddr,
                                     stack_is_thumb(image, routines[i].vaddr), 1);
    const size_t walked = walk_new(&stack, 0);
    if (stack.pointers)
        walk_taken(&stack, walked);
    for (size_t i = 0; i < count; i++)
        describe(&stack, &routines[i], roots[i]);
    census_take(&stack, routines, count, census);
    free_stack(&stack);
    free(roots);
}

/* ---- in the parent ---- */

struct stack_routines {
    bool tried;
    struct image_routine *routines; /* ascending */
    size_t count;
    struct image_code code;
    struct image_special *specials;
    struct image_user *users;
};

struct stack_routines *stack_new(void)
{
    return calloc(1, sizeof(struct stack_routines));
}

void stack_free(struct stack_routines *routines)
{
    if (routines == NULL)
        return;
    free(routines->routines);
    free(routines->specials);
    free(routines->users);
    free(routines);
}

static void in_child(const struct image *image, void *shared)
{
    struct block *block = shared;
    stack_measure(image, block->routines, block->count, &block->census);
    block->complete = 1;
}

/* Exports and what a loader calls, ascending. */
static size_t list_routines(const struct image *image, struct image_routine *routines)
{
    const struct image_routine unknown = { .limit = IMAGE_STACK_UNKNOWN };
    size_t count = 0;
    for (size_t i = 0; i < image->symbol_count && count < MAX_ROUTINES - 1; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        if (!symbol->exported || !symbol->executable ||
            (count > 0 && routines[count - 1].vaddr == symbol->vaddr))
            continue;
        routines[count] = unknown;
        routines[count++].vaddr = symbol->vaddr;
    }
    size_t at = 0;
    while (at < count && routines[at].vaddr < image->entry_point)
        at++;
    if (image->has_entry_point && (at == count || routines[at].vaddr != image->entry_point)) {
        memmove(routines + at + 1, routines + at, (count - at) * sizeof routines[0]);
        routines[at] = unknown;
        routines[at].vaddr = image->entry_point;
        count++;
    }
    return count;
}

/* The child's answers; the addresses are not asked back. */
static void take_over(struct image_routine *own, const struct image_routine *answers, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const uint64_t vaddr = own[i].vaddr;
        if ((unsigned)answers[i].limit > IMAGE_STACK_UNKNOWN)
            continue;
        own[i] = answers[i];
        own[i].vaddr = vaddr;
    }
}

static bool is_special(const struct image *image, const struct image_special *special)
{
    return special->vaddr >= image->span_begin && special->vaddr < image->span_end &&
           (unsigned)special->kind <= IMAGE_SPECIAL_MACHINE &&
           (unsigned)special->how <= IMAGE_SPECIAL_BYTES;
}

static void make_printable(char *text, size_t size)
{
    text[size - 1] = '\0';
    for (; *text != '\0'; text++)
        if (*text < 0x20 || *text > 0x7e)
            *text = '?';
}

static void take_census(const struct image *image, struct stack_routines *routines,
                        const struct census *census)
{
    struct image_code *code = &routines->code;
    const size_t count =
        census->special_count < CENSUS_SPECIALS ? census->special_count : CENSUS_SPECIALS;
    routines->specials = calloc(count + 1, sizeof routines->specials[0]);
    routines->users = calloc(image->import_count + 1, sizeof routines->users[0]);
    if (routines->specials == NULL || routines->users == NULL)
        return;
    for (size_t i = 0; i < count; i++) {
        struct image_special *special = &routines->specials[code->special_count];
        *special = census->specials[i];
        make_printable(special->text, sizeof special->text);
        code->special_count += is_special(image, special);
    }
    memcpy(routines->users, census->users, image->import_count * sizeof routines->users[0]);
    code->known = true;
    code->complete = census->complete;
    code->lost = census->lost;
    code->entry_idle = census->entry_idle;
    code->specials = routines->specials;
    code->users = routines->users;
}

static void load(const struct image *image, struct stack_routines *routines)
{
    const size_t size = sizeof(struct block) + image->import_count * sizeof(struct image_user);
    struct block *block =
        mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    routines->tried = true;
    if (block == MAP_FAILED)
        return;
    const size_t count = block->count = list_routines(image, block->routines);
    routines->routines = calloc(count + 1, sizeof routines->routines[0]);
    if (routines->routines != NULL) {
        routines->count = count;
        memcpy(routines->routines, block->routines, count * sizeof block->routines[0]);
        if (image_in_child(in_child, image, block) && block->complete == 1) {
            take_over(routines->routines, block->routines, count);
            take_census(image, routines, &block->census);
        }
    }
    munmap(block, size);
}

const struct image_code *image_code(const struct image *image)
{
    struct stack_routines *routines = image->routines;
    if (!routines->tried)
        load(image, routines);
    return &routines->code;
}

const struct image_routine *image_routine(const struct image *image, uint64_t vaddr)
{
    struct stack_routines *routines = image->routines;
    if (!routines->tried)
        load(image, routines);
    for (size_t i = 0; i < routines->count; i++) {
        if (routines->routines[i].vaddr == vaddr)
            return &routines->routines[i];
    }
    return NULL;
}
