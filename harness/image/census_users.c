/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * census_users.c - the instruction that uses an import. The relocation only names the slot that a
 * loader fills; code reads the slot, or calls a stub of the linker's that jumps through it.
 */
#include <stdlib.h>

#include "image/census.h"
#include "image/stack.h"

enum { ENDBR = 4 }; /* bytes of an endbr64, with which a stub may begin */

struct users {
    struct census_search *search;
    struct code_map slots; /* address of the slot -> import */
    struct code_map stubs; /* address of a stub's beginning -> import */
};

static bool slot_of(const struct users *users, const struct code_op *op, uint32_t *import)
{
    const bool memory = op->kind == CODE_LOAD || op->kind == CODE_STORE;
    if (op->kind == CODE_PLACE || (memory && op->a == CODE_NONE && op->b == CODE_NONE))
        return code_map_get(&users->slots, (uint64_t)op->imm, import);
    return false;
}

static void note_user(struct census *census, uint32_t import, uint64_t vaddr)
{
    struct image_user *user = &census->users[import];
    if (!user->found || vaddr < user->vaddr)
        *user = (struct image_user){ true, vaddr };
}

static void note_stub(struct users *users, const struct code_insn *insn, uint32_t import)
{
    uint32_t known;
    if (!code_map_get(&users->stubs, insn->vaddr, &known))
        code_map_put(&users->stubs, insn->vaddr, import);
    if (!code_map_get(&users->stubs, insn->vaddr - ENDBR, &known))
        code_map_put(&users->stubs, insn->vaddr - ENDBR, import);
}

static const struct code_insn *found(struct census_search *search, size_t i)
{
    const uint64_t key = search->found[i];
    return code_at(&search->stack->code, key >> 1, (key & 1) != 0);
}

static void look_for_slots(struct users *users)
{
    struct census_search *search = users->search;
    for (size_t i = 0; i < search->found_count; i++) {
        const struct code_insn *insn = found(search, i);
        for (uint32_t k = 0; insn != NULL && k < insn->op_count; k++) {
            uint32_t import;
            if (!slot_of(users, &search->stack->code.ops[insn->first_op + k], &import))
                continue;
            if (insn->flow == CODE_JUMP_VALUE)
                note_stub(users, insn, import);
            else
                note_user(search->census, import, insn->vaddr);
        }
    }
}

static void look_for_callers(struct users *users)
{
    struct census_search *search = users->search;
    for (size_t i = 0; i < search->found_count; i++) {
        const struct code_insn *insn = found(search, i);
        uint32_t import;
        if (insn != NULL && (insn->flow == CODE_CALL || insn->flow == CODE_JUMP) &&
            code_map_get(&users->stubs, insn->target, &import))
            note_user(search->census, import, insn->vaddr);
    }
}

void census_users(struct census_search *search)
{
    const struct image *image = search->stack->code.image;
    struct users users = { .search = search };
    for (size_t i = 0; i < image->import_count; i++) {
        uint32_t known;
        if (image->imports[i].has_user &&
            !code_map_get(&users.slots, image->imports[i].user, &known))
            code_map_put(&users.slots, image->imports[i].user, (uint32_t)i);
    }
    if (users.slots.count != 0) {
        look_for_slots(&users);
        look_for_callers(&users);
    }
    code_map_free(&users.slots);
    code_map_free(&users.stubs);
}

/* ---- an entry point that does nothing ---- */

enum { IDLE_MOST = 64, X86_BP = 5, ARM_FP = 11 };

static bool is_own_stack(const struct code *code, int reg)
{
    return reg == code->machine.stack_register ||
           reg == (code->machine.link_register == CODE_NONE ? X86_BP : ARM_FP);
}

static bool writes(const struct code *code, const struct code_insn *insn)
{
    for (uint32_t i = 0; i < insn->op_count; i++) {
        const struct code_op *op = &code->ops[insn->first_op + i];
        if (op->kind == CODE_STORE && !is_own_stack(code, op->a))
            return true;
    }
    return false;
}

/* One straight way from the first instruction to a return that changes nothing but registers and
 * its own stack. */
bool census_is_idle(struct stack *stack, uint64_t vaddr)
{
    for (unsigned i = 0; i < IDLE_MOST; i++) {
        const struct code_insn *insn = code_at(&stack->code, vaddr, false);
        if (insn == NULL || insn->special != IMAGE_SPECIAL_NONE || writes(&stack->code, insn))
            return false;
        if (insn->flow == CODE_RETURN && insn->condition == CODE_ALWAYS)
            return true;
        if (insn->flow == CODE_JUMP && insn->condition == CODE_ALWAYS && insn->target > insn->vaddr)
            vaddr = insn->target;
        else if (insn->flow == CODE_NEXT)
            vaddr += insn->size;
        else
            return false;
    }
    return false;
}
