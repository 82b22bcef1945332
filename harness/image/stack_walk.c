/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * stack_walk.c - one function along its control flow.
 *
 * What is known at an instruction is kept for each of them; where ways meet, what holds on both
 * stays, and of two stack pointers the deeper one. A stack pointer that gets deeper at the same
 * instruction again and again grows with each turn of a loop. Jumps into other functions are
 * followed like all others: that is what a tail call is.
 */
#include "image/stack.h"

#include <stdlib.h>

#define MAX_STEPS     (1u << 21) /* instructions executed, for a whole module */
#define MAX_NODES     (1u << 16) /* instructions of one function */
#define MAX_FUNCTIONS (1u << 14)
#define MAX_RISES     32u
#define MAX_JUMPS     (1u << 20)
#define MAX_PADDING   32u /* bytes between two parts of a function that nothing reaches */

struct node {
    struct stack_state state;
    uint64_t vaddr;
    bool thumb, waiting;
    uint8_t rises;
};

struct walk {
    struct stack *stack;
    struct stack_function *function;
    struct node *nodes;
    size_t node_count;
    struct code_map node_of;
    uint32_t *waiting;
    size_t waiting_count;
    struct stack_range *ranges; /* of the function's code and of constants that it reads */
    size_t range_count;
    struct stack_edge *edges;
    size_t edge_count;
};

/* ---- what the module is made of ---- */

uint32_t stack_function_at(struct stack *stack, uint64_t vaddr, bool thumb, uint8_t given)
{
    const uint64_t key = vaddr << 5 | (uint64_t)thumb << 4 | given;
    uint32_t index;
    if (code_map_get(&stack->function_of, key, &index))
        return index;
    if (stack->function_count == MAX_FUNCTIONS ||
        !image_make_room(&stack->functions, stack->function_count, sizeof stack->functions[0]) ||
        !code_map_put(&stack->function_of, key, (uint32_t)stack->function_count)) {
        stack->exhausted = true;
        return STACK_POINTER;
    }
    stack->functions[stack->function_count] =
        (struct stack_function){ .vaddr = vaddr, .thumb = thumb, .given = given };
    return (uint32_t)stack->function_count++;
}

void stack_take(struct stack *stack, uint64_t vaddr)
{
    uint32_t known;
    if (code_map_get(&stack->is_taken, vaddr, &known))
        return;
    if (stack->taken_count == MAX_FUNCTIONS ||
        !image_make_room(&stack->taken, stack->taken_count, sizeof stack->taken[0]) ||
        !code_map_put(&stack->is_taken, vaddr, 0)) {
        stack->exhausted = true;
        return;
    }
    stack->taken[stack->taken_count++] = vaddr;
}

static void give_up(struct walk *walk, enum image_stack_limit limit, uint64_t where)
{
    if (walk->function->limit != IMAGE_STACK_BOUNDED)
        return;
    walk->function->limit = limit;
    walk->function->where = where;
}

static void out_of_memory(struct walk *walk, uint64_t where)
{
    walk->stack->exhausted = true;
    give_up(walk, IMAGE_STACK_LARGE, where);
}

static void add_range(struct walk *walk, uint64_t begin, uint64_t size)
{
    if (image_make_room(&walk->ranges, walk->range_count, sizeof walk->ranges[0]))
        walk->ranges[walk->range_count++] = (struct stack_range){ begin, begin + size };
}

static void add_edge(struct walk *walk, uint32_t callee, uint64_t depth, uint64_t where)
{
    for (size_t i = 0; i < walk->edge_count; i++) {
        struct stack_edge *edge = &walk->edges[i];
        if (edge->callee != callee)
            continue;
        if (depth > edge->depth)
            *edge = (struct stack_edge){ callee, depth, where };
        return;
    }
    if (!image_make_room(&walk->edges, walk->edge_count, sizeof walk->edges[0])) {
        out_of_memory(walk, where);
        return;
    }
    walk->edges[walk->edge_count++] = (struct stack_edge){ callee, depth, where };
}

/* ---- ways ---- */

static void wait_for(struct walk *walk, uint32_t index)
{
    if (walk->nodes[index].waiting)
        return;
    if (!image_make_room(&walk->waiting, walk->waiting_count, sizeof walk->waiting[0])) {
        out_of_memory(walk, walk->nodes[index].vaddr);
        return;
    }
    walk->nodes[index].waiting = true;
    walk->waiting[walk->waiting_count++] = index;
}

static void arrive_again(struct walk *walk, uint32_t index, const struct stack_state *state)
{
    struct node *node = &walk->nodes[index];
    bool deeper;
    if (!stack_join(walk->stack, &node->state, state, &deeper))
        return;
    if (deeper && ++node->rises > MAX_RISES)
        give_up(walk, IMAGE_STACK_LOOP, node->vaddr);
    else
        wait_for(walk, index);
}

static void go_to(struct walk *walk, uint64_t vaddr, bool thumb, const struct stack_state *state)
{
    const uint64_t key = vaddr << 1 | thumb;
    uint32_t index;
    if (code_map_get(&walk->node_of, key, &index)) {
        arrive_again(walk, index, state);
        return;
    }
    if (walk->node_count == MAX_NODES ||
        !image_make_room(&walk->nodes, walk->node_count, sizeof walk->nodes[0]) ||
        !code_map_put(&walk->node_of, key, (uint32_t)walk->node_count)) {
        out_of_memory(walk, vaddr);
        return;
    }
    walk->nodes[walk->node_count] =
        (struct node){ .state = *state, .vaddr = vaddr, .thumb = thumb };
    wait_for(walk, (uint32_t)walk->node_count++);
}

static int64_t depth_of(const struct walk *walk, const struct stack_state *state)
{
    return state->reg[walk->stack->code.machine.stack_register].n;
}

static void deepen(struct walk *walk, uint64_t depth)
{
    if (depth > walk->function->own)
        walk->function->own = depth;
}

static void call(struct walk *walk, const struct code_insn *insn, const struct stack_state *state,
                 uint32_t callee, unsigned call_bytes)
{
    const uint64_t depth = (uint64_t)depth_of(walk, state) + call_bytes;
    deepen(walk, depth);
    add_edge(walk, callee, depth, insn->vaddr);
}

/* The address of a function that is called or jumped to, with the Thumb bit on Arm. */
static uint64_t without_thumb(const struct walk *walk, uint64_t vaddr, bool *thumb)
{
    *thumb = walk->stack->code.machine.link_register != CODE_NONE && (vaddr & 1) != 0;
    return *thumb ? vaddr & ~(uint64_t)1 : vaddr;
}

/*
 * `mov eax, SIZE; call ___chkstk_ms; sub rsp, rax`: the compiler asks for so much stack at once. No
 * other function is called that keeps rax.
 */
static bool is_stack_probe(struct walk *walk, const struct code_insn *insn,
                           const struct stack_state *state)
{
    struct code *code = &walk->stack->code;
    const int sp = code->machine.stack_register;
    if (code->machine.call_bytes == 0 || state->reg[0].kind != STACK_NUMBER)
        return false;
    const struct code_insn *next = code_at(code, insn->vaddr + insn->size, insn->thumb);
    for (uint32_t i = 0; next != NULL && i < next->op_count; i++) {
        const struct code_op *op = &code->ops[next->first_op + i];
        if (op->kind == CODE_DIFF && op->dst == sp && op->a == sp && op->b == 0)
            return true;
    }
    return false;
}

static void after_call(struct walk *walk, const struct code_insn *insn, struct stack_state *state,
                       uint32_t pops)
{
    const struct code_insn copy = *insn;
    struct stack_value *sp = &state->reg[walk->stack->code.machine.stack_register];
    stack_called(walk->stack, state, is_stack_probe(walk, &copy, state));
    sp->n -= pops;
    if (sp->n < 0)
        give_up(walk, IMAGE_STACK_UNBALANCED, copy.vaddr);
    else
        go_to(walk, copy.vaddr + copy.size, copy.thumb, state);
}

static void call_function(struct walk *walk, const struct code_insn *insn,
                          struct stack_state *state, uint64_t vaddr, bool thumb)
{
    struct stack *stack = walk->stack;
    const unsigned call_bytes = stack->code.machine.call_bytes;
    if (!code_is_code(&stack->code, vaddr)) {
        give_up(walk, IMAGE_STACK_CODE, insn->vaddr);
        return;
    }
    if (call_bytes != 0 && vaddr == insn->vaddr + insn->size) { /* to learn where it is */
        state->reg[stack->code.machine.stack_register].n += call_bytes;
        deepen(walk, (uint64_t)depth_of(walk, state));
        go_to(walk, vaddr, thumb, state);
        return;
    }
    const size_t self = (size_t)(walk->function - stack->functions);
    const uint32_t callee = stack_function_at(stack, vaddr, thumb, stack_given(stack, state));
    walk->function = &stack->functions[self];
    if (callee == STACK_POINTER) {
        out_of_memory(walk, insn->vaddr);
        return;
    }
    call(walk, insn, state, callee, call_bytes);
    const struct code_insn copy = *insn;
    const uint32_t pops = stack_returns(stack, vaddr, thumb);
    if (pops != STACK_NO_RETURN)
        after_call(walk, &copy, state, pops);
}

static void note_jump(struct walk *walk, uint64_t where, enum stack_jump_kind kind, uint64_t target,
                      bool thumb)
{
    struct stack *stack = walk->stack;
    if (stack->jump_count < MAX_JUMPS &&
        image_make_room(&stack->jumps, stack->jump_count, sizeof stack->jumps[0]))
        stack->jumps[stack->jump_count++] =
            (struct stack_jump){ .where = where, .target = target, .kind = kind, .thumb = thumb };
    else
        stack->exhausted = true;
}

/* Through a pointer: one of TG Motion's functions, or one whose address the module has. */
static void call_pointer(struct walk *walk, const struct code_insn *insn,
                         const struct stack_state *state, const struct stack_value *value,
                         unsigned call_bytes)
{
    walk->function->outside = true;
    deepen(walk, (uint64_t)depth_of(walk, state) + call_bytes);
    if (value->kind == STACK_OUTSIDE)
        return;
    walk->stack->pointers = true;
    call(walk, insn, state, STACK_POINTER, call_bytes);
}

static void call_value(struct walk *walk, const struct code_insn *insn, struct stack_state *state)
{
    const struct stack_value value = state->reg[insn->value];
    bool thumb;
    if (value.kind == STACK_PLACE) {
        const uint64_t vaddr = without_thumb(walk, (uint64_t)value.n, &thumb);
        note_jump(walk, insn->vaddr, STACK_JUMP_TO, vaddr, thumb);
        call_function(walk, insn, state, vaddr, thumb);
        return;
    }
    call_pointer(walk, insn, state, &value, walk->stack->code.machine.call_bytes);
    after_call(walk, insn, state, 0);
}

static void jump(struct walk *walk, const struct code_insn *insn, const struct stack_state *state,
                 uint64_t vaddr, bool thumb)
{
    if (code_is_code(&walk->stack->code, vaddr))
        go_to(walk, vaddr, thumb, state);
    else
        give_up(walk, IMAGE_STACK_CODE, insn->vaddr);
}

static void note_table(struct walk *walk, const struct stack_value *value)
{
    struct stack *stack = walk->stack;
    const uint64_t size = ((uint64_t)value->n << value->stride) + value->width;
    add_range(walk, value->table, size);
    if (image_make_room(&stack->tables, stack->table_count, sizeof stack->tables[0]))
        stack->tables[stack->table_count++] =
            (struct stack_range){ value->table, value->table + size };
}

static void lose_jump(struct walk *walk, uint64_t where)
{
    note_jump(walk, where, STACK_JUMP_LOST, 0, false);
    give_up(walk, IMAGE_STACK_JUMP, where);
}

static void jump_table(struct walk *walk, const struct code_insn *insn,
                       const struct stack_state *state, const struct stack_value *value)
{
    const struct code_insn copy = *insn;
    if (value->kind == STACK_ENTRY)
        note_table(walk, value);
    for (uint64_t i = 0; i <= (uint64_t)value->n; i++) {
        uint64_t vaddr;
        if (!stack_place(walk->stack, value, i, &vaddr)) {
            lose_jump(walk, copy.vaddr);
            return;
        }
        if (copy.thumb)
            vaddr &= ~(uint64_t)1;
        if (!code_is_code(&walk->stack->code, vaddr)) {
            lose_jump(walk, copy.vaddr);
            return;
        }
        note_jump(walk, copy.vaddr, STACK_JUMP_TO, vaddr, copy.thumb);
        go_to(walk, vaddr, copy.thumb, state);
    }
}

static void jump_value(struct walk *walk, const struct code_insn *insn,
                       const struct stack_state *state)
{
    const struct stack_value *value = &state->reg[insn->value];
    bool thumb;
    switch (value->kind) {
    case STACK_RETURN:
        note_jump(walk, insn->vaddr, STACK_JUMP_OUT, 0, false);
        return;
    case STACK_PLACE: {
        const uint64_t vaddr = without_thumb(walk, (uint64_t)value->n, &thumb);
        note_jump(walk, insn->vaddr, STACK_JUMP_TO, vaddr, thumb || insn->thumb);
        jump(walk, insn, state, vaddr, thumb || insn->thumb);
        return;
    }
    case STACK_STEPS:
    case STACK_ENTRY:
        jump_table(walk, insn, state, value);
        return;
    case STACK_OUTSIDE:
        note_jump(walk, insn->vaddr, STACK_JUMP_OUT, 0, false);
        call_pointer(walk, insn, state, value, 0);
        return;
    default:
        break;
    }
    /* With nothing of its own left on the stack, it is the last call of a function. */
    if (value->kind == STACK_TABLED || depth_of(walk, state) != 0) {
        lose_jump(walk, insn->vaddr);
        return;
    }
    note_jump(walk, insn->vaddr, STACK_JUMP_OUT, 0, false);
    call_pointer(walk, insn, state, value, 0);
}

static void follow(struct walk *walk, const struct code_insn *insn, struct stack_state *state)
{
    switch ((enum code_flow)insn->flow) {
    case CODE_NEXT:
        go_to(walk, insn->vaddr + insn->size, insn->thumb, state);
        break;
    case CODE_JUMP:
        jump(walk, insn, state, insn->target, insn->target_thumb);
        break;
    case CODE_JUMP_VALUE:
        jump_value(walk, insn, state);
        break;
    case CODE_CALL:
        call_function(walk, insn, state, insn->target, insn->target_thumb);
        break;
    case CODE_CALL_VALUE:
        call_value(walk, insn, state);
        break;
    case CODE_RETURN:
    case CODE_STOP:
        break;
    }
}

static void note_constants(struct walk *walk, const struct code_insn *insn)
{
    for (uint32_t i = 0; i < insn->op_count; i++) {
        const struct code_op *op = &walk->stack->code.ops[insn->first_op + i];
        if (op->kind == CODE_LITERAL)
            add_range(walk, (uint64_t)op->imm, op->width);
    }
}

static void step(struct walk *walk, uint32_t index)
{
    struct node *node = &walk->nodes[index];
    struct stack_state state = node->state, other = node->state;
    node->waiting = false;
    const struct code_insn *found = code_at(&walk->stack->code, node->vaddr, node->thumb);
    if (found == NULL) {
        give_up(walk, walk->stack->code.exhausted ? IMAGE_STACK_LARGE : IMAGE_STACK_CODE,
                node->vaddr);
        return;
    }
    const struct code_insn insn = *found;
    enum image_stack_limit limit;
    note_constants(walk, &insn);
    stack_refine(&state, insn.condition, true);
    if (insn.condition != CODE_ALWAYS) {
        stack_refine(&other, insn.condition, false);
        go_to(walk, insn.vaddr + insn.size, insn.thumb, &other);
    }
    if (stack_execute(walk->stack, &state, &insn, &walk->function->own, &limit))
        follow(walk, &insn, &state);
    else
        give_up(walk, limit, insn.vaddr);
}

/* ---- the size of its code (docs/decisions.md, I12) ---- */

static int compare_ranges(const void *left, const void *right)
{
    const struct stack_range *a = left, *b = right;
    return a->begin != b->begin ? (a->begin > b->begin ? 1 : -1)
                                : (a->end > b->end) - (a->end < b->end);
}

/* Where the next function begins, as far as the file says. */
static uint64_t next_function(const struct image *image, uint64_t vaddr)
{
    size_t low = 0, high = image->symbol_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (image->symbols[middle].vaddr <= vaddr)
            low = middle + 1;
        else
            high = middle;
    }
    for (; low < image->symbol_count; low++) {
        const struct image_symbol *symbol = &image->symbols[low];
        if (symbol->executable && (symbol->kind == IMAGE_SYMBOL_FUNC || symbol->exported))
            return symbol->vaddr;
    }
    return UINT64_MAX;
}

static void measure(struct walk *walk)
{
    const uint64_t begin = walk->function->vaddr;
    const uint64_t last = next_function(walk->stack->code.image, begin);
    uint64_t end = begin;
    for (size_t i = 0; i < walk->node_count; i++) {
        const struct code_insn *insn =
            code_at(&walk->stack->code, walk->nodes[i].vaddr, walk->nodes[i].thumb);
        if (insn != NULL)
            add_range(walk, insn->vaddr, insn->size);
    }
    if (walk->range_count != 0)
        qsort(walk->ranges, walk->range_count, sizeof walk->ranges[0], compare_ranges);
    for (size_t i = 0; i < walk->range_count; i++) {
        const struct stack_range *range = &walk->ranges[i];
        if (range->begin < begin || range->end <= end)
            continue;
        if (range->begin >= last || range->begin - end > MAX_PADDING)
            break;
        end = range->end;
    }
    walk->function->size = end - begin;
}

void stack_walk(struct stack *stack, size_t index)
{
    struct walk walk = { .stack = stack, .function = &stack->functions[index] };
    struct stack_state state;
    stack_begin(stack, &state, walk.function->given);
    go_to(&walk, walk.function->vaddr, walk.function->thumb, &state);
    while (walk.waiting_count != 0) {
        if (++stack->steps > MAX_STEPS) {
            out_of_memory(&walk, walk.nodes[walk.waiting[0]].vaddr);
            break;
        }
        step(&walk, walk.waiting[--walk.waiting_count]);
    }
    measure(&walk);
    walk.function->edges = walk.edges;
    walk.function->edge_count = walk.edge_count;
    free(walk.nodes);
    free(walk.waiting);
    free(walk.ranges);
    code_map_free(&walk.node_of);
}
