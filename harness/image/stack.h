/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * stack.h - how deep the stack gets, from the machine code; private to stack*.c.
 *
 * Each function is walked along its control flow with what is known of the registers at each
 * instruction; calls make a graph of functions, and the longest way through it is the answer
 * (docs/decisions.md, I11). A depth is counted in bytes from the stack pointer at a function's
 * first instruction downwards; a depth that is kept is never too small.
 *
 * What is taken for granted, because a module that breaks it is broken anyway: who is called gives
 * the stack pointer and the registers that the calling convention saves back as they were, and
 * nobody changes a saved register where it is saved.
 */
#ifndef HARNESS_IMAGE_STACK_H
#define HARNESS_IMAGE_STACK_H

#include "image/census.h"
#include "image/code.h"

enum stack_kind {
    STACK_ANY,
    STACK_NUMBER,  /* n */
    STACK_PLACE,   /* the address n of the module (Arm: with the Thumb bit) */
    STACK_FRAME,   /* an address in the stack, at most n deep */
    STACK_OUTSIDE, /* given by TG Motion, or read through what it gave */
    STACK_RETURN,  /* the function's own return address */
    STACK_UP_TO,   /* 0 to n */
    STACK_STEPS,   /* plus + (k << shift), k from 0 to n */
    STACK_ENTRY,   /* plus + (the k-th item of a constant table << shift), k from 0 to n */
    STACK_TABLED   /* came out of some table */
};

struct stack_value {
    uint8_t kind;
    uint8_t base; /* STACK_FRAME: 0 counted from the entry, 1 from an aligned address, 2 either */
    uint8_t shift;
    uint8_t width, stride; /* STACK_ENTRY: bytes of an item, log2 of their distance */
    bool is_signed;
    int64_t n, plus;
    uint64_t table;
};

enum { STACK_SLOTS = 12, STACK_WIDEST = 8, STACK_MAX_INDEX = 65535 };

/* Words in the stack that hold something worth knowing. */
struct stack_slot {
    int64_t depth; /* of its lowest byte */
    uint8_t base;
    struct stack_value value;
};

struct stack_state {
    struct stack_value reg[CODE_REGISTERS];
    struct stack_slot slot[STACK_SLOTS];
    unsigned slot_count, next_slot;
    int compared; /* register that the flags tell of, CODE_NONE */
    int64_t compared_with;
};

/* callee: index of a function; STACK_POINTER: any that the module has the address of. */
#define STACK_POINTER UINT32_MAX
struct stack_edge {
    uint32_t callee;
    uint64_t depth; /* at the callee's first instruction */
    uint64_t where; /* the calling instruction */
};

/* A function, as called with certain arguments that TG Motion gave. */
struct stack_function {
    uint64_t vaddr;
    bool thumb;
    uint8_t given; /* bit k: argument k is STACK_OUTSIDE */
    struct stack_edge *edges;
    size_t edge_count;
    uint64_t own;                 /* depth without what is called */
    uint64_t size;                /* of its code */
    enum image_stack_limit limit; /* first reason why own and the edges are not all */
    uint64_t where;
    bool outside; /* calls what is not in the module */

    uint8_t visit; /* stack_graph.c */
    size_t next_edge, next_taken;
    uint64_t total;
};

struct stack_range {
    uint64_t begin, end;
};

/* Where a jump or call through a register or table leads, as far as the walks know. */
enum stack_jump_kind {
    STACK_JUMP_TO,  /* target; a call may lead elsewhere, too */
    STACK_JUMP_OUT, /* a return, or a last call through a pointer */
    STACK_JUMP_LOST /* and elsewhere, too */
};
struct stack_jump {
    uint64_t where; /* the instruction */
    uint64_t target;
    enum stack_jump_kind kind;
    bool thumb; /* target is Thumb code */
};

struct stack {
    struct code code;
    struct stack_function *functions;
    size_t function_count;
    struct code_map function_of; /* address, Thumb bit, given -> index */
    struct code_map returns;     /* address and Thumb bit -> see stack_returns() */
    uint64_t *taken;             /* addresses of code that the module has, with the Thumb bit */
    size_t taken_count;
    struct code_map is_taken;
    uint32_t *taken_functions; /* those of them that are functions */
    size_t taken_function_count;
    struct stack_range *tables; /* jump tables */
    size_t table_count;
    struct stack_jump *jumps;
    size_t jump_count;
    bool pointers; /* there are calls through a pointer that may reach the module's own functions */
    uint64_t steps;
    bool exhausted; /* memory, or a limit of this analysis */
};

/* stack.c: whether the function there is Thumb code, as far as symbols say. */
bool stack_is_thumb(const struct image *image, uint64_t vaddr);

/* stack_values.c */
/* Executes the operations of an instruction. *own grows with what they reach. False when the stack
 * pointer is lost: *limit says why. */
bool stack_execute(struct stack *stack, struct stack_state *state, const struct code_insn *insn,
                   uint64_t *own, enum image_stack_limit *limit);
/* The index-th place that a STEPS or ENTRY value stands for. */
bool stack_place(const struct stack *stack, const struct stack_value *value, uint64_t index,
                 uint64_t *vaddr);

/* stack_state.c */
void stack_begin(const struct stack *stack, struct stack_state *state, uint8_t given);
/* The word of the stack there, NULL when nothing is known of it. */
const struct stack_value *stack_slot(const struct stack_state *state, uint8_t base, int64_t depth);
/* What the flags tell when the condition holds, or does not. */
void stack_refine(struct stack_state *state, enum code_condition condition, bool holds);
/* False when nothing in *into changed. *deeper: the stack pointer did. */
bool stack_join(const struct stack *stack, struct stack_state *into, const struct stack_state *from,
                bool *deeper);
/* What a call leaves unknown; keep_first: not register 0. */
void stack_called(const struct stack *stack, struct stack_state *state, bool keep_first);
/* Which arguments are STACK_OUTSIDE, as for stack_begin(). */
uint8_t stack_given(const struct stack *stack, const struct stack_state *state);

/* stack_walk.c */
void stack_walk(struct stack *stack, size_t index);
/* Index of a function, added when it is new; STACK_POINTER when memory ran out. */
uint32_t stack_function_at(struct stack *stack, uint64_t vaddr, bool thumb, uint8_t given);
/* The module has the address of this code. */
void stack_take(struct stack *stack, uint64_t vaddr);

/* stack_returns.c: bytes of arguments that the function takes off the stack, STACK_NO_RETURN when
 * it never returns. */
#define STACK_NO_RETURN (UINT32_MAX - 1)
uint32_t stack_returns(struct stack *stack, uint64_t vaddr, bool thumb);

/* stack_graph.c: fills total of one function and all below it, and where it has none, limit. */
void stack_graph(struct stack *stack, size_t root);

#endif
