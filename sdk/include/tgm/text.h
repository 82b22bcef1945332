/* SPDX-License-Identifier: MIT */
/*
 * text.h - building text without a C library: UTF-16, as TG Motion on a PC speaks, and UTF-8.
 *
 *     static tgm_wchar line[80];
 *     struct tgm_text16 t;
 *     tgm_text16_init(&t, line, 80);
 *     tgm_text16_utf8(&t, "axis ");
 *     tgm_text16_unsigned(&t, axis, 2, '0');
 *     tgm_text16_utf8(&t, ": ");
 *     tgm_text16_fixed(&t, position, 3, 10, ' ');
 *     pData->functions.pRtWprintf_String(line);              "axis 07:    -12.500"
 *
 * The builder belongs to the caller, and so does the buffer; the builder only points to it. What holds after
 * every call, also after tgm_text16_init alone:
 * - The buffer ends with 0 and nothing at or behind buffer[capacity] was touched. A capacity of 0 (or a
 *   NULL buffer) is allowed: nothing is written at all.
 * - The text is valid UTF-16 (UTF-8): what is not valid in the input becomes U+FFFD.
 * - What does not fit is left out and `truncated` is set. A string is cut between two characters, never
 *   inside a surrogate pair or a UTF-8 sequence. A number is appended whole or not at all, since half a
 *   number reads like another one. Once truncated, nothing more is appended: the text is always
 *   a beginning of what was meant.
 *
 * Each append function returns 1 when everything fitted, 0 when the text is truncated; checking `truncated`
 * once at the end is as good.
 *
 * Context: any of the six functions. Nothing is allocated and nothing is shared between builders; one
 * builder must not be used from two of the six functions, which interrupt each other. Formatting a number
 * takes well under a microsecond on a PC; still, texts belong into Program_01.
 */
#ifndef TGM_TEXT_H
#define TGM_TEXT_H

#include <tgm_plc.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Largest width of a number; a larger one is taken as this. */
#define TGM_TEXT_WIDTH_MAX 48
/* Most digits behind the decimal point; more are taken as this. */
#define TGM_TEXT_DECIMALS_MAX 17

/* Text in 16-bit units. All members may be read, none written, between init and the last append. */
struct tgm_text16 {
    tgm_wchar *buffer; /* the text, ends with 0 */
    size_t capacity;   /* units of the buffer, the final 0 included */
    size_t length;     /* units of the text, the final 0 not included */
    int truncated;     /* 1: something did not fit */
};

/* Text in bytes. */
struct tgm_text8 {
    char *buffer;
    size_t capacity; /* bytes of the buffer, the final 0 included */
    size_t length;   /* bytes of the text, the final 0 not included */
    int truncated;
};

/* Begins an empty text. capacity counts units (bytes) of the buffer; 0 or a NULL buffer: nothing is
 * ever written, and whatever is appended, but for an empty string, counts as truncated. */
void tgm_text16_init(struct tgm_text16 *t, tgm_wchar *buffer, size_t capacity);
void tgm_text8_init(struct tgm_text8 *t, char *buffer, size_t capacity);

/* Appends a UTF-16 string up to its 0, or at most max units of it (for a field of fixed size that may lack
 * the 0, such as MAIN.PLC_Name). An unpaired surrogate becomes U+FFFD. NULL is an empty string. The string must
 * not lie in the buffer. */
int tgm_text16_utf16(struct tgm_text16 *t, const tgm_wchar *string);
int tgm_text16_utf16_max(struct tgm_text16 *t, const tgm_wchar *string, size_t max);
int tgm_text8_utf16(struct tgm_text8 *t, const tgm_wchar *string);
int tgm_text8_utf16_max(struct tgm_text8 *t, const tgm_wchar *string, size_t max);

/* Appends a UTF-8 string up to its 0, or at most max bytes of it. Each longest piece that could have begun
 * a character but does not continue as one becomes one U+FFFD (Unicode, "maximal subpart"): overlong
 * forms, surrogates, values above U+10FFFF and stray bytes. NULL is an empty string. */
int tgm_text16_utf8(struct tgm_text16 *t, const char *string);
int tgm_text16_utf8_max(struct tgm_text16 *t, const char *string, size_t max);
int tgm_text8_utf8(struct tgm_text8 *t, const char *string);
int tgm_text8_utf8_max(struct tgm_text8 *t, const char *string, size_t max);

/* Appends one character by its Unicode number; a surrogate or a number above 0x10FFFF becomes U+FFFD.
 * 0 would end the text and becomes U+FFFD, too. */
int tgm_text16_character(struct tgm_text16 *t, uint32_t code_point);
int tgm_text8_character(struct tgm_text8 *t, uint32_t code_point);

/*
 * Numbers. width: least number of characters, filled from the left with pad: ' ', or '0', which goes between
 * the sign and the digits; any other pad is taken as ' '. Width 0: as long as the number is. All integers
 * of 32 and 64 bits go through the same functions.
 */

/* Decimal, with '-' when negative. */
int tgm_text16_signed(struct tgm_text16 *t, int64_t value, unsigned width, char pad);
int tgm_text8_signed(struct tgm_text8 *t, int64_t value, unsigned width, char pad);

/* Decimal. */
int tgm_text16_unsigned(struct tgm_text16 *t, uint64_t value, unsigned width, char pad);
int tgm_text8_unsigned(struct tgm_text8 *t, uint64_t value, unsigned width, char pad);

/* Hexadecimal in capitals without a prefix; width 8 and pad '0' for a 32-bit register. */
int tgm_text16_hex(struct tgm_text16 *t, uint64_t value, unsigned width, char pad);
int tgm_text8_hex(struct tgm_text8 *t, uint64_t value, unsigned width, char pad);

/*
 * Decimal fraction with a point and exactly `decimals` digits behind it (0: no point), rounded
 * correctly: the digits are those of the exact value of the double, halves go to the even digit (0.125
 * with 2 decimals is 0.12; 0.3 with 17 is 0.29999999999999999). A value that shows as zero has no minus
 * sign. |value| >= 1e18 shows as ">=1e18" or "<=-1e18", an infinity as "inf" or "-inf", no number as
 * "nan"; these are filled with ' ' whatever pad says.
 */
int tgm_text16_fixed(struct tgm_text16 *t, double value, unsigned decimals, unsigned width, char pad);
int tgm_text8_fixed(struct tgm_text8 *t, double value, unsigned decimals, unsigned width, char pad);

/* Appends ' ' until the text is `column` units (bytes) long, to align what follows; longer text stays. */
int tgm_text16_column(struct tgm_text16 *t, size_t column);
int tgm_text8_column(struct tgm_text8 *t, size_t column);

/* Text of the module API: the builder for the tgm_char of tgm_plc.h. */
#ifdef TGM_TEXT8
typedef struct tgm_text8 tgm_text;
#define tgm_text_init      tgm_text8_init
#define tgm_text_utf8      tgm_text8_utf8
#define tgm_text_utf16     tgm_text8_utf16
#define tgm_text_character tgm_text8_character
#define tgm_text_signed    tgm_text8_signed
#define tgm_text_unsigned  tgm_text8_unsigned
#define tgm_text_hex       tgm_text8_hex
#define tgm_text_fixed     tgm_text8_fixed
#define tgm_text_column    tgm_text8_column
#else
typedef struct tgm_text16 tgm_text;
#define tgm_text_init      tgm_text16_init
#define tgm_text_utf8      tgm_text16_utf8
#define tgm_text_utf16     tgm_text16_utf16
#define tgm_text_character tgm_text16_character
#define tgm_text_signed    tgm_text16_signed
#define tgm_text_unsigned  tgm_text16_unsigned
#define tgm_text_hex       tgm_text16_hex
#define tgm_text_fixed     tgm_text16_fixed
#define tgm_text_column    tgm_text16_column
#endif

#ifdef __cplusplus
}
#endif

#endif
