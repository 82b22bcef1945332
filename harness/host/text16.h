/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * text16.h - UTF-16 text of the module API: formatting as Windows does it, conversion to UTF-8.
 *
 * The format language is that of the wide functions of Windows' C library (docs/decisions.md, R20):
 *
 *   %d %i %u %x %X %o                  whole numbers
 *   %f %F %e %E %g %G %a %A            reals; inf, nan, -nan(ind); %a has 13 digits unless said
 *   %s %ls %ws, %c %lc %wc             UTF-16
 *   %hs %S, %hc %C                     bytes, each the character of that number; %lS %lC: UTF-16
 *   %p %%                              all digits of a pointer; a per cent sign
 *   - + space # 0, width, precision    either a number or *; 0 fills texts, too
 *   hh h l ll I32 I64 I j z t w        sizes
 *
 * Arguments are as wide as in the module's convention (arguments.h): `long` has 64 bits in ELF
 * modules for x86-64 only, pointers have 32 on 32-bit targets. %n is refused: it writes through a
 * pointer and Windows has it switched off.
 */
#ifndef HARNESS_HOST_TEXT16_H
#define HARNESS_HOST_TEXT16_H

#include <stddef.h>
#include <stdint.h>

#include "machine/arguments.h"

/* Formats into out, at most capacity units with the final 0, which is always written when capacity
 * > 0. Returns the units written without the final 0, or -1 when the text did not fit or a
 * conversion is unknown (what came before it is in out). */
int text16_vformat(uint16_t *out, size_t capacity, const uint16_t *format,
                   struct arguments *arguments);
/* With arguments of the host's own. */
int text16_format(uint16_t *out, size_t capacity, const uint16_t *format, ...);

/* UTF-16 to UTF-8 with a final 0, never past capacity bytes (cut between characters); unpaired
 * surrogates become U+FFFD, control characters but for line ends and tabs become '?'. Reads text
 * only up to its 0. Returns the bytes written without the 0.
 */
size_t text16_to_utf8(char *out, size_t capacity, const uint16_t *text);

/* The other way, at most capacity units with the terminator, the rest of `out` zeroed. What is no
 * UTF-8 becomes U+FFFD, a byte at a time. */
void text16_from_utf8(uint16_t *out, size_t capacity, const char *text);

#endif
