/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * stack_values.c - what instructions make of registers and of the stack.
 */
#include "image/stack.h"

#define MAX_DEPTH ((int64_t)1 << 30)

static const struct stack_value any = { .kind = STACK_ANY };

static struct stack_value number(const struct stack *stack, uint64_t n)
{
    uint64_t vaddr;
    if (stack->code.machine.word == 4)
        n = (uint32_t)n;
    if (code_is_absolute(&stack->code, n, &vaddr))
        return (struct stack_value){ .kind = STACK_PLACE, .n = (int64_t)vaddr };
    return (struct stack_value){ .kind = STACK_NUMBER, .n = (int64_t)n };
}

static struct stack_value place(const struct stack *stack, uint64_t vaddr)
{
    if (stack->code.machine.word == 4)
        vaddr = (uint32_t)vaddr;
    return (struct stack_value){ .kind = STACK_PLACE, .n = (int64_t)vaddr };
}

static struct stack_value up_to(int64_t n)
{
    return (struct stack_value){ .kind = STACK_UP_TO, .n = n };
}

static int64_t plus(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a + (uint64_t)b);
}

static int64_t shifted(int64_t a, unsigned shift)
{
    return (int64_t)((uint64_t)a << shift);
}

/* ---- the stack's words ---- */

static void forget_slots(struct stack_state *state, uint8_t base, int64_t depth, int64_t width,
                         int64_t word)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < state->slot_count; i++) {
        const struct stack_slot *slot = &state->slot[i];
        const bool over =
            slot->base == base && slot->depth > depth - width && slot->depth - word < depth;
        if (!over)
            state->slot[kept++] = *slot;
    }
    state->slot_count = kept;
}

static void remember(struct stack_state *state, uint8_t base, int64_t depth,
                     const struct stack_value *value)
{
    const struct stack_slot slot = { .depth = depth, .base = base, .value = *value };
    if (state->slot_count < STACK_SLOTS)
        state->slot[state->slot_count++] = slot;
    else
        state->slot[state->next_slot++ % STACK_SLOTS] = slot;
}

static bool worth_keeping(const struct stack_value *value)
{
    return value->kind == STACK_FRAME || value->kind == STACK_OUTSIDE ||
           value->kind == STACK_RETURN || value->kind == STACK_TABLED;
}

/* ---- memory ---- */

static const struct image_reloc *reloc_at(const struct image *image, uint64_t vaddr)
{
    size_t low = 0, high = image->reloc_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (image->relocs[middle].vaddr < vaddr)
            low = middle + 1;
        else
            high = middle;
    }
    return low < image->reloc_count && image->relocs[low].vaddr == vaddr ? &image->relocs[low]
                                                                         : NULL;
}

/* Nobody writes there once the module is loaded. A flat image does not say what is writable. */
static bool is_constant(const struct stack *stack, uint64_t vaddr, unsigned width, bool literal)
{
    const struct image *image = stack->code.image;
    const struct image_segment *segment = image_segment_at(image, vaddr, width);
    if (segment == NULL)
        return false;
    if (image->format == IMAGE_FORMAT_FLAT)
        return literal;
    return (segment->perm & IMAGE_WRITE) == 0 ||
           (vaddr >= image->relro_begin && vaddr < image->relro_end);
}

static struct stack_value constant(const struct stack *stack, uint64_t vaddr, unsigned width,
                                   bool literal)
{
    const struct image *image = stack->code.image;
    const struct image_reloc *reloc = reloc_at(image, vaddr);
    uint64_t offset;
    if (reloc != NULL && reloc->kind != IMAGE_RELOC_RELATIVE)
        return (struct stack_value){ .kind = STACK_OUTSIDE };
    if (!is_constant(stack, vaddr, width, literal) || width > STACK_WIDEST)
        return any;
    if (reloc != NULL)
        return place(stack, (uint64_t)reloc->addend);
    if (!image_file_range(image, vaddr, width, &offset))
        return any;
    return number(stack, image_word(image, vaddr, width));
}

bool stack_place(const struct stack *stack, const struct stack_value *value, uint64_t index,
                 uint64_t *vaddr)
{
    *vaddr = (uint64_t)plus(value->plus, shifted((int64_t)index, value->shift));
    if (value->kind == STACK_STEPS)
        return true;
    const struct stack_value item =
        constant(stack, value->table + (index << value->stride), value->width, true);
    if (item.kind != STACK_NUMBER && item.kind != STACK_PLACE)
        return false;
    int64_t n = item.n;
    if (value->is_signed && value->width < 8) {
        const unsigned spare = 64u - 8u * value->width;
        n = (int64_t)((uint64_t)n << spare) >> spare;
    }
    *vaddr = (uint64_t)plus(value->plus, shifted(n, value->shift));
    if (stack->code.machine.word == 4)
        *vaddr = (uint32_t)*vaddr;
    return true;
}

/* The item of a table at an index that is known to be small. */
static struct stack_value entry(const struct stack *stack, uint64_t table,
                                const struct stack_value *index, const struct code_op *op,
                                unsigned stride)
{
    const struct stack_value tabled = { .kind = STACK_TABLED };
    const uint64_t last = table + ((uint64_t)index->n << stride);
    if (op->width == 0 || op->width > STACK_WIDEST || last < table ||
        !is_constant(stack, table, op->width, true) || !is_constant(stack, last, op->width, true))
        return tabled;
    return (struct stack_value){ .kind = STACK_ENTRY,
                                 .n = index->n,
                                 .table = table,
                                 .width = op->width,
                                 .stride = (uint8_t)stride,
                                 .is_signed = op->is_signed };
}

static void reach(int64_t depth, uint64_t *own)
{
    if (depth > 0 && depth <= MAX_DEPTH && (uint64_t)depth > *own)
        *own = (uint64_t)depth;
}

static struct stack_value load(const struct stack *stack, struct stack_state *state,
                               const struct code_op *op, uint64_t *own)
{
    const unsigned word = stack->code.machine.word;
    const struct stack_value a =
        op->a == CODE_NONE ? place(stack, (uint64_t)op->imm) : state->reg[op->a];
    const struct stack_value *b = op->b == CODE_NONE ? NULL : &state->reg[op->b];
    const int64_t imm = op->a == CODE_NONE ? 0 : op->imm;
    if (a.kind == STACK_FRAME) {
        reach(a.n - imm, own);
        const struct stack_value *slot =
            b == NULL && op->width == word ? stack_slot(state, a.base, a.n - imm) : NULL;
        return slot != NULL ? *slot : any;
    }
    if (a.kind == STACK_OUTSIDE)
        return op->width == word ? a : any;
    if (a.kind == STACK_PLACE && b == NULL)
        return constant(stack, (uint64_t)plus(a.n, imm), op->width, op->a == CODE_NONE);
    if (a.kind == STACK_PLACE && b->kind == STACK_UP_TO)
        return entry(stack, (uint64_t)plus(a.n, imm), b, op, op->shift);
    /* i386: an index register without scale, the table as displacement. */
    if (a.kind == STACK_UP_TO && b == NULL && is_constant(stack, (uint64_t)imm, op->width, true))
        return entry(stack, (uint64_t)imm, &a, op, 0);
    if (b != NULL && op->width >= 4)
        return (struct stack_value){ .kind = STACK_TABLED };
    if (op->width <= 2 && !op->is_signed)
        return up_to(op->width == 1 ? 255 : 65535);
    return any;
}

static void store(const struct stack *stack, struct stack_state *state, const struct code_op *op,
                  uint64_t *own)
{
    const unsigned word = stack->code.machine.word;
    if (op->a == CODE_NONE || state->reg[op->a].kind != STACK_FRAME)
        return;
    const struct stack_value *to = &state->reg[op->a];
    const int64_t depth = to->n - op->imm;
    reach(depth, own);
    if (op->b != CODE_NONE)
        return;
    forget_slots(state, to->base, depth, op->width, word);
    if (op->dst != CODE_NONE && op->width == word && worth_keeping(&state->reg[op->dst]))
        remember(state, to->base, depth, &state->reg[op->dst]);
}

/* ---- arithmetic ---- */

static bool is_number(const struct stack_value *value)
{
    return value->kind == STACK_NUMBER || value->kind == STACK_PLACE;
}

static struct stack_value add(const struct stack *stack, struct stack_value a, int64_t imm)
{
    switch (a.kind) {
    case STACK_NUMBER:
        return number(stack, (uint64_t)plus(a.n, imm));
    case STACK_PLACE:
        return place(stack, (uint64_t)plus(a.n, imm));
    case STACK_FRAME:
        if (stack->code.machine.word == 4)
            imm = (int32_t)imm;
        a.n = plus(a.n, (int64_t) - (uint64_t)imm);
        return a.n >= -2 * MAX_DEPTH && a.n <= 2 * MAX_DEPTH ? a : any;
    case STACK_STEPS:
    case STACK_ENTRY:
        a.plus = plus(a.plus, imm);
        return a;
    case STACK_OUTSIDE:
    case STACK_TABLED:
        return a;
    default:
        return imm == 0 ? a : any;
    }
}

/* a << shift */
static struct stack_value scale(const struct stack *stack, struct stack_value a, unsigned shift)
{
    if (shift == 0)
        return a;
    switch (a.kind) {
    case STACK_NUMBER:
        return number(stack, (uint64_t)shifted(a.n, shift));
    case STACK_UP_TO:
        return (struct stack_value){ .kind = STACK_STEPS, .n = a.n, .shift = (uint8_t)shift };
    case STACK_ENTRY:
        if (a.plus != 0 || a.shift + shift > 8)
            return any;
        a.shift = (uint8_t)(a.shift + shift);
        return a;
    case STACK_TABLED:
        return a;
    default:
        return any;
    }
}

static struct stack_value sum(const struct stack *stack, const struct stack_value *a,
                              const struct stack_value *b)
{
    /* An index without scale counts bytes. */
    if (is_number(a) && is_number(b)) {
        if (a->kind == STACK_PLACE || b->kind == STACK_PLACE)
            return place(stack, (uint64_t)plus(a->n, b->n));
        return number(stack, (uint64_t)plus(a->n, b->n));
    }
    if (is_number(b))
        return add(stack, *a, b->n);
    if (is_number(a) && b->kind != STACK_UP_TO)
        return add(stack, *b, a->n);
    if (a->kind == STACK_OUTSIDE || b->kind == STACK_OUTSIDE)
        return (struct stack_value){ .kind = STACK_OUTSIDE };
    if (a->kind == STACK_TABLED || b->kind == STACK_TABLED)
        return (struct stack_value){ .kind = STACK_TABLED };
    return any;
}

static struct stack_value difference(const struct stack *stack, const struct stack_value *a,
                                     const struct stack_value *b)
{
    if (b->kind != STACK_NUMBER)
        return any;
    return add(stack, *a, (int64_t) - (uint64_t)b->n);
}

/* Aligning an address takes it down by less than the alignment. */
static struct stack_value align(const struct stack *stack, struct stack_state *state,
                                struct stack_value a, int64_t mask)
{
    const int64_t alignment = (int64_t) - (uint64_t)mask;
    const int64_t word = stack->code.machine.word;
    if (alignment <= 0 || alignment > 65536 || (alignment & (alignment - 1)) != 0)
        return any;
    const int64_t grain = a.n % word == 0 ? (word < alignment ? word : alignment) : 1;
    unsigned kept = 0;
    for (unsigned i = 0; i < state->slot_count; i++) {
        if (state->slot[i].base != 1)
            state->slot[kept++] = state->slot[i];
    }
    state->slot_count = kept;
    a.n += alignment - grain;
    a.base = 1;
    return a;
}

static struct stack_value mask(const struct stack *stack, struct stack_state *state,
                               const struct stack_value *a, int64_t bits)
{
    if (a->kind == STACK_FRAME)
        return align(stack, state, *a, bits);
    if (a->kind == STACK_NUMBER)
        return number(stack, (uint64_t)(a->n & bits));
    if (bits >= 0 && bits <= STACK_MAX_INDEX)
        return up_to(bits);
    return a->kind == STACK_TABLED ? *a : any;
}

static struct stack_value low(const struct stack *stack, const struct stack_value *a,
                              unsigned width)
{
    const int64_t most = width >= 4 ? UINT32_MAX : ((int64_t)1 << (8 * width)) - 1;
    switch (a->kind) {
    case STACK_NUMBER:
        return number(stack, (uint64_t)(a->n & most));
    case STACK_UP_TO:
        return a->n <= most ? *a : up_to(most);
    case STACK_STEPS:
    case STACK_ENTRY:
    case STACK_TABLED:
        return width >= 4 ? *a : any;
    default:
        return width < 4 ? up_to(most) : any;
    }
}

static struct stack_value high(const struct stack *stack, const struct stack_value *a, int64_t bits)
{
    return is_number(a) ? number(stack, ((uint64_t)a->n & 0xffff) | (uint64_t)bits << 16) : any;
}

/* ---- execution ---- */

static struct stack_value result(struct stack *stack, struct stack_state *state,
                                 const struct code_op *op, uint64_t *own)
{
    const struct stack_value *a = op->a >= 0 ? &state->reg[op->a] : NULL;
    struct stack_value scaled, base;
    switch (op->kind) {
    case CODE_NUMBER:
        return number(stack, (uint64_t)op->imm);
    case CODE_PLACE:
        return place(stack, (uint64_t)op->imm);
    case CODE_HIGH:
        return high(stack, &state->reg[op->dst], op->imm);
    case CODE_ADD:
        return add(stack, *a, op->imm);
    case CODE_SUM:
        base = a == NULL ? place(stack, (uint64_t)op->imm) : add(stack, *a, op->imm);
        scaled = scale(stack, state->reg[op->b], op->shift);
        return sum(stack, &base, &scaled);
    case CODE_DIFF:
        return difference(stack, a, &state->reg[op->b]);
    case CODE_MASK:
        return mask(stack, state, a, op->imm);
    case CODE_LOW:
        return low(stack, a, op->width);
    case CODE_LOAD:
        return load(stack, state, op, own);
    default:
        return any;
    }
}

static bool sets_register(const struct code_op *op)
{
    return op->kind < CODE_STORE;
}

/* False: the stack pointer is nowhere that is known. */
static bool check_depth(const struct stack_value *sp, uint64_t *own, enum image_stack_limit *limit)
{
    if (sp->kind != STACK_FRAME) {
        *limit = IMAGE_STACK_VARIABLE;
        return false;
    }
    if (sp->n < 0) {
        *limit = IMAGE_STACK_UNBALANCED;
        return false;
    }
    if (sp->n > MAX_DEPTH) {
        *limit = IMAGE_STACK_LARGE;
        return false;
    }
    reach(sp->n, own);
    return true;
}

static void note_address(struct stack *stack, const struct stack_value *value)
{
    const bool arm = stack->code.machine.link_register != CODE_NONE;
    const uint64_t vaddr = (uint64_t)value->n;
    if (value->kind == STACK_PLACE && code_is_code(&stack->code, arm ? vaddr & ~1ull : vaddr))
        stack_take(stack, vaddr);
}

bool stack_execute(struct stack *stack, struct stack_state *state, const struct code_insn *insn,
                   uint64_t *own, enum image_stack_limit *limit)
{
    const int sp = stack->code.machine.stack_register;
    for (uint32_t i = 0; i < insn->op_count; i++) {
        const struct code_op op = stack->code.ops[insn->first_op + i];
        if (op.kind == CODE_STORE) {
            store(stack, state, &op, own);
        } else if (op.kind == CODE_COMPARE) {
            state->compared = op.a;
            state->compared_with = op.imm;
        } else if (op.kind == CODE_FLAGS) {
            state->compared = CODE_NONE;
        } else if (sets_register(&op)) {
            state->reg[op.dst] = result(stack, state, &op, own);
            if (state->compared == op.dst)
                state->compared = CODE_NONE;
            if (op.dst == sp && !check_depth(&state->reg[sp], own, limit))
                return false;
            if (op.dst != CODE_TEMP)
                note_address(stack, &state->reg[op.dst]);
        }
    }
    return true;
}
