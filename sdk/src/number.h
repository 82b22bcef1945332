/* SPDX-License-Identifier: MIT */
/*
 * number.h - numbers as ASCII digits; what text16.c and text8.c share. Not for authors: they include
 * <tgm/text.h>, which says what width, pad and decimals mean.
 *
 * Each function writes at most NUMBER_SIZE characters, without a final 0, and returns how many. The names
 * carry the prefix although they are not public: a module's own functions share the link with them.
 */
#ifndef TGM_SRC_NUMBER_H
#define TGM_SRC_NUMBER_H

#include <stdint.h>

#define NUMBER_SIZE 48 /* TGM_TEXT_WIDTH_MAX; the longest number has 1 + 19 + 1 + 17 */

unsigned tgm_number_signed(char *out, int64_t value, unsigned width, char pad);
unsigned tgm_number_unsigned(char *out, uint64_t value, unsigned width, char pad);
unsigned tgm_number_hex(char *out, uint64_t value, unsigned width, char pad);
unsigned tgm_number_fixed(char *out, double value, unsigned decimals, unsigned width, char pad);

#endif
