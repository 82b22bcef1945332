/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * trampoline.h - what trampoline.S and the C around it share: offsets into struct machine_state
 * (machine_private.h asserts them).
 */
#ifndef HARNESS_MACHINE_TRAMPOLINE_H
#define HARNESS_MACHINE_TRAMPOLINE_H

#define STATE_HOST_RSP     0
#define STATE_STACK_TOP    8
#define STATE_SERIAL       16
#define STATE_SENTINEL     24
#define STATE_SEEN         72
#define STATE_SEEN_STACK   120
#define STATE_SEEN_FLAGS   128
#define STATE_SEEN_MXCSR   136
#define STATE_SEEN_X87     144
#define STATE_SEEN_FS      152
#define STATE_SEEN_X87TAG  160
#define STATE_HOST_FS      168
#define STATE_HOST_MXCSR   176
#define STATE_MODULE_MXCSR 180
#define STATE_HOST_X87     184
#define STATE_MODULE_X87   186
#define STATE_ACTIVE       188
#define STATE_HAS_FSGSBASE 192
#define STATE_ENTER_FLAGS  200

/* Only where the Windows convention is spoken. */
#define STATE_THREAD_BLOCK     208
#define STATE_WINDOWS_SENTINEL 216
#define STATE_WINDOWS_XMM      232
#define STATE_WINDOWS_SEEN     392
#define STATE_SEEN_DI          400
#define STATE_SEEN_SI          408
#define STATE_SEEN_XMM         416
#define STATE_SEEN_GS          424
#define STATE_SEEN_WINDOWS_X87 432
#define STATE_WINDOWS_X87      440

/* Flags of rflags that must be clear when a function returns. */
#define FLAG_TRAP      0x100
#define FLAG_DIRECTION 0x400
#define FLAG_NESTED    0x4000
#define FLAG_ALIGNMENT 0x40000
#define FLAGS_CHECKED  (FLAG_TRAP | FLAG_DIRECTION | FLAG_NESTED | FLAG_ALIGNMENT)
#define FLAGS_CLEAN    0x202

/* MXCSR without its sticky exception flags. */
#define MXCSR_CONTROL 0xffc0

/* What fxam says of st(0): C3 and C0 without C2 is "empty". */
#define FXAM_MASK  0x4500
#define FXAM_EMPTY 0x4100

/* How machine_enter() came back (second return register). */
#define LEFT_CLEAN     0
#define LEFT_BROKEN    1
#define LEFT_ABANDONED 2
#define LEFT_ASIDE     3

#endif
