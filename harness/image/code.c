/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * code.c - the boundary to Capstone: each instruction of a module is asked for once.
 */
#include "image/code.h"

#include <capstone/capstone.h>
#include <stdlib.h>

#define MAX_INSNS  (1u << 18)
#define MAX_OPS    (1u << 21)
#define MAX_LENGTH 15u /* of an x86 instruction */
#define MAX_BLOCK  18u /* of a Thumb IT with the four instructions behind it */

enum {
    X86_AX = 1 << 0,
    X86_CX = 1 << 1,
    X86_DX = 1 << 2,
    X86_SI_DI = 3 << 6,
    X86_R8_R11 = 15 << 8
};

static const struct code_machine system_v = {
    4, 8, 8, X86_AX | X86_CX | X86_DX | X86_SI_DI | X86_R8_R11, { 7, 6, 2, 1 }, CODE_NONE
};
static const struct code_machine windows_64 = {
    4, 8, 8, X86_AX | X86_CX | X86_DX | X86_R8_R11, { 1, 2, 8, 9 }, CODE_NONE
};
static const struct code_machine i386 = {
    4, 4, 4, X86_AX | X86_CX | X86_DX, { CODE_NONE, CODE_NONE, CODE_NONE, CODE_NONE }, CODE_NONE
};
static const struct code_machine arm = { 13, 4, 0, 0xf | 1 << 12 | 1 << 14, { 0, 1, 2, 3 }, 14 };

static const struct code_machine *machine_of(const struct image *image)
{
    switch (image->target) {
    case IMAGE_TARGET_X86_64:
        return image->format == IMAGE_FORMAT_PE ? &windows_64 : &system_v;
    case IMAGE_TARGET_I386:
        return &i386;
    case IMAGE_TARGET_ARM:
        return &arm;
    case IMAGE_TARGET_NONE:
        break;
    }
    return NULL;
}

static bool open_handle(cs_arch arch, cs_mode mode, size_t *handle)
{
    return cs_open(arch, mode, handle) == CS_ERR_OK &&
           cs_option(*handle, CS_OPT_DETAIL, CS_OPT_ON) == CS_ERR_OK;
}

static bool open_handles(struct code *code)
{
    switch (code->image->target) {
    case IMAGE_TARGET_X86_64:
        return open_handle(CS_ARCH_X86, CS_MODE_64, &code->handle);
    case IMAGE_TARGET_I386:
        return open_handle(CS_ARCH_X86, CS_MODE_32, &code->handle);
    case IMAGE_TARGET_ARM:
        return open_handle(CS_ARCH_ARM, CS_MODE_ARM, &code->handle) &&
               open_handle(CS_ARCH_ARM, CS_MODE_THUMB, &code->thumb_handle);
    case IMAGE_TARGET_NONE:
        break;
    }
    return false;
}

bool code_open(struct code *code, const struct image *image)
{
    const struct code_machine *machine = machine_of(image);
    *code = (struct code){ .image = image };
    if (machine == NULL)
        return false;
    code->machine = *machine;
    if (open_handles(code))
        code->scratch = cs_malloc(code->handle);
    if (code->scratch != NULL)
        return true;
    code_close(code);
    return false;
}

void code_close(struct code *code)
{
    if (code->scratch != NULL)
        cs_free(code->scratch, 1);
    if (code->handle != 0)
        cs_close(&code->handle);
    if (code->thumb_handle != 0)
        cs_close(&code->thumb_handle);
    code_map_free(&code->known);
    free(code->insns);
    free(code->ops);
    *code = (struct code){ 0 };
}

bool code_is_absolute(const struct code *code, uint64_t number, uint64_t *vaddr)
{
    const struct image *image = code->image;
    *vaddr = number - image->base;
    /* Elsewhere small numbers look like addresses, and addresses come with a relocation. */
    return (image->base != 0 || image->fixed) && *vaddr >= image->span_begin &&
           *vaddr < image->span_end;
}

/* The file's bytes from there on, none when no code lies there. */
static const uint8_t *bytes_at(const struct code *code, uint64_t vaddr, size_t *size)
{
    const struct image_segment *segment = image_segment_at(code->image, vaddr, 1);
    *size = 0;
    if (segment == NULL || (segment->perm & IMAGE_EXEC) == 0 ||
        vaddr - segment->vaddr >= segment->file_size)
        return NULL;
    *size = (size_t)(segment->file_size - (vaddr - segment->vaddr));
    return code->image->bytes + segment->file_offset + (vaddr - segment->vaddr);
}

bool code_is_code(const struct code *code, uint64_t vaddr)
{
    size_t size;
    return bytes_at(code, vaddr, &size) != NULL;
}

static bool make_room(void **array, uint32_t *room, uint32_t count, uint32_t most, size_t item)
{
    if (count < *room)
        return true;
    const uint32_t wanted = *room == 0 ? 1024 : 2 * *room;
    void *larger = wanted <= most ? reallocarray(*array, wanted, item) : NULL;
    if (larger == NULL)
        return false;
    *array = larger;
    *room = wanted;
    return true;
}

void code_op(struct code *code, struct code_insn *insn, struct code_op op)
{
    void *ops = code->ops;
    if (!make_room(&ops, &code->op_room, code->op_count, MAX_OPS, sizeof op)) {
        code->exhausted = true;
        return;
    }
    code->ops = ops;
    code->ops[code->op_count++] = op;
    insn->op_count++;
}

static bool keep(struct code *code, const struct code_insn *insn)
{
    void *insns = code->insns;
    const uint64_t key = insn->vaddr << 1 | insn->thumb;
    uint32_t index;
    if (code_map_get(&code->known, key, &index))
        return true;
    if (code->exhausted ||
        !make_room(&insns, &code->insn_room, code->insn_count, MAX_INSNS, sizeof *insn)) {
        code->exhausted = true;
        return false;
    }
    code->insns = insns;
    code->insns[code->insn_count] = *insn;
    if (!code_map_put(&code->known, key, code->insn_count)) {
        code->exhausted = true;
        return false;
    }
    code->insn_count++;
    return true;
}

/* The next instruction from *bytes on; false when there is none. */
static bool decode(struct code *code, const uint8_t **bytes, size_t *size, uint64_t *vaddr,
                   bool thumb, unsigned *id)
{
    cs_insn *scratch = code->scratch;
    struct code_insn insn = { .vaddr = *vaddr,
                              .thumb = thumb,
                              .target_thumb = thumb,
                              .value = CODE_NONE,
                              .first_op = code->op_count };
    if (!cs_disasm_iter(thumb ? code->thumb_handle : code->handle, bytes, size, vaddr, scratch) ||
        scratch->size == 0)
        return false;
    insn.size = (uint8_t)scratch->size;
    *id = scratch->id;
    insn.special = (uint8_t)code_special(code, scratch, thumb);
    if (code->image->target == IMAGE_TARGET_ARM)
        code_arm(code, &insn, scratch);
    else
        code_x86(code, &insn, scratch);
    return keep(code, &insn);
}

/* Capstone remembers how many instructions a Thumb IT makes conditional, so these are read with it.
 * When one of them is invalid, it has to forget. */
static void decode_it_block(struct code *code, const uint8_t *bytes, size_t size, uint64_t vaddr,
                            unsigned count)
{
    unsigned id;
    size_t room = size < MAX_BLOCK ? size : MAX_BLOCK;
    for (unsigned i = 0; i < count; i++) {
        if (decode(code, &bytes, &room, &vaddr, true, &id))
            continue;
        cs_close(&code->thumb_handle);
        if (!open_handle(CS_ARCH_ARM, CS_MODE_THUMB, &code->thumb_handle))
            code->exhausted = true;
        return;
    }
}

/* Instructions behind an IT: the lowest bit set in its mask says where it ends. */
static unsigned it_length(const uint8_t *bytes)
{
    unsigned count = 4, mask = bytes[0] & 15u;
    while (count > 1 && (mask & 1) == 0) {
        mask >>= 1;
        count--;
    }
    return count;
}

const struct code_insn *code_at(struct code *code, uint64_t vaddr, bool thumb)
{
    const uint64_t key = vaddr << 1 | thumb;
    uint32_t index;
    if (code_map_get(&code->known, key, &index))
        return &code->insns[index];
    size_t size;
    unsigned id;
    const uint8_t *bytes = bytes_at(code, vaddr, &size), *next = bytes;
    uint64_t end = vaddr;
    if (bytes == NULL || code->exhausted)
        return NULL;
    size_t room = size < MAX_LENGTH ? size : MAX_LENGTH, rest = room;
    if (!decode(code, &next, &rest, &end, thumb, &id))
        return NULL;
    if (thumb && id == ARM_INS_IT)
        decode_it_block(code, next, size - (size_t)(next - bytes), end, it_length(bytes));
    return code_map_get(&code->known, key, &index) ? &code->insns[index] : NULL;
}
