/* SPDX-License-Identifier: MIT */
#include "number.h"

#include "tgm/text.h"

TGM_STATIC_ASSERT(NUMBER_SIZE == TGM_TEXT_WIDTH_MAX, "every width must fit");
TGM_STATIC_ASSERT(NUMBER_SIZE >= 1 + 19 + 1 + TGM_TEXT_DECIMALS_MAX, "every number must fit");

#define DECIMALS_MAX TGM_TEXT_DECIMALS_MAX

static const uint64_t powers_of_ten[DECIMALS_MAX + 1] = {
    1u,
    10u,
    100u,
    1000u,
    10000u,
    100000u,
    1000000u,
    10000000u,
    100000000u,
    1000000000u,
    UINT64_C(10000000000),
    UINT64_C(100000000000),
    UINT64_C(1000000000000),
    UINT64_C(10000000000000),
    UINT64_C(100000000000000),
    UINT64_C(1000000000000000),
    UINT64_C(10000000000000000),
    UINT64_C(100000000000000000),
};

/* Digits are made from the last to the first, behind which `text` points when they are done. */
struct digits {
    char store[NUMBER_SIZE];
    char *text;
    unsigned count;
};

static void begin(struct digits *d)
{
    d->text = d->store + NUMBER_SIZE;
    d->count = 0;
}

static void push(struct digits *d, char c)
{
    *--d->text = c;
    d->count++;
}

/* At least `least` digits. The 32-bit loop is not only for speed: 64-bit division is a library call
 * on 32-bit machines, and most numbers never need it. */
static void push_decimal(struct digits *d, uint64_t value, unsigned least)
{
    const unsigned end = d->count + least;
    for (; value > UINT32_MAX; value /= 10)
        push(d, (char)('0' + (int)(value % 10)));
    for (uint32_t small = (uint32_t)value; small != 0 || d->count < end; small /= 10)
        push(d, (char)('0' + (int)(small % 10)));
}

static unsigned finish(char *out, const struct digits *d, int negative, unsigned width, char pad)
{
    const unsigned sign = negative ? 1 : 0;
    unsigned n = 0;

    if (width > NUMBER_SIZE)
        width = NUMBER_SIZE;
    const unsigned fill = width > d->count + sign ? width - d->count - sign : 0;
    if (negative && pad == '0')
        out[n++] = '-';
    while (n < fill + (pad == '0' ? sign : 0))
        out[n++] = pad == '0' ? '0' : ' ';
    if (negative && pad != '0')
        out[n++] = '-';
    for (unsigned i = 0; i < d->count; i++)
        out[n++] = d->text[i];
    return n;
}

unsigned tgm_number_unsigned(char *out, uint64_t value, unsigned width, char pad)
{
    struct digits d;
    begin(&d);
    push_decimal(&d, value, 1);
    return finish(out, &d, 0, width, pad);
}

unsigned tgm_number_signed(char *out, int64_t value, unsigned width, char pad)
{
    struct digits d;
    begin(&d);
    push_decimal(&d, value < 0 ? 0 - (uint64_t)value : (uint64_t)value, 1);
    return finish(out, &d, value < 0, width, pad);
}

unsigned tgm_number_hex(char *out, uint64_t value, unsigned width, char pad)
{
    struct digits d;
    begin(&d);
    do
        push(&d, "0123456789ABCDEF"[value & 15]);
    while ((value >>= 4) != 0);
    return finish(out, &d, 0, width, pad);
}

struct wide {
    uint64_t high, low;
};

static struct wide multiply(uint64_t a, uint64_t b)
{
    const uint64_t a0 = (uint32_t)a, a1 = a >> 32, b0 = (uint32_t)b, b1 = b >> 32;
    const uint64_t middle = a1 * b0 + (a0 * b0 >> 32);
    const uint64_t other = a0 * b1 + (uint32_t)middle;
    const struct wide product = { a1 * b1 + (middle >> 32) + (other >> 32), a * b };
    return product;
}

/* value / 2^shift to the nearest whole number, a half to the even one; `even` says whether 0 counts as
 * even here, which it does not when it stands behind an odd digit. value < 2^127, shift >= 1, and
 * the result fits 64 bits. */
static uint64_t shift_and_round(struct wide value, unsigned shift, int even)
{
    uint64_t whole, rest_high = value.high, rest_low = value.low, half_high = 0, half_low = 0;

    if (shift > 127)
        return 0; /* less than a half */
    if (shift >= 64) {
        whole = shift == 64 ? value.high : value.high >> (shift - 64);
        rest_high = shift == 64 ? 0 : value.high & ((UINT64_C(1) << (shift - 64)) - 1);
    } else {
        whole = value.high << (64 - shift) | value.low >> shift;
        rest_high = 0;
        rest_low = value.low & ((UINT64_C(1) << shift) - 1);
    }
    if (shift > 64)
        half_high = UINT64_C(1) << (shift - 65);
    else
        half_low = UINT64_C(1) << (shift - 1);
    if (rest_high != half_high)
        return whole + (rest_high > half_high);
    if (rest_low != half_low)
        return whole + (rest_low > half_low);
    return whole + ((whole & 1) != 0 || !even);
}

static unsigned finish_word(char *out, const char *word, unsigned width)
{
    struct digits d;
    unsigned length = 0;
    while (word[length] != 0)
        length++;
    begin(&d);
    while (length > 0)
        push(&d, word[--length]);
    return finish(out, &d, 0, width, ' ');
}

/*
 * All in integers, since a double times a power of ten is rounded before it could be looked at.
 * |value| = mantissa * 2^exponent is split into whole and fraction / 2^shift; fraction * 10^decimals has
 * at most 53 + 57 bits.
 */
unsigned tgm_number_fixed(char *out, double value, unsigned decimals, unsigned width, char pad)
{
    const union {
        double value;
        uint64_t bits;
    } u = { value };
    const int negative = (int)(u.bits >> 63);
    const int exponent = (int)(u.bits >> 52 & 0x7FF);
    uint64_t whole, fraction = 0, mantissa = u.bits & ((UINT64_C(1) << 52) - 1);

    if (exponent == 0x7FF)
        return finish_word(out, mantissa != 0 ? "nan" : negative ? "-inf" : "inf", width);
    if (value >= 1e18 || value <= -1e18)
        return finish_word(out, negative ? "<=-1e18" : ">=1e18", width);
    if (exponent != 0)
        mantissa |= UINT64_C(1) << 52;
    if (decimals > DECIMALS_MAX)
        decimals = DECIMALS_MAX;

    const int shift = 1075 - (exponent != 0 ? exponent : 1); /* value = mantissa / 2^shift */
    if (shift <= 0) {
        whole = mantissa << -shift;
    } else {
        whole = shift < 64 ? mantissa >> shift : 0;
        fraction = shift < 64 ? mantissa & ((UINT64_C(1) << shift) - 1) : mantissa;
        fraction = shift_and_round(multiply(fraction, powers_of_ten[decimals]), (unsigned)shift,
                                   decimals > 0 || whole % 2 == 0);
        if (fraction == powers_of_ten[decimals]) {
            fraction = 0;
            whole++;
        }
    }

    struct digits d;
    begin(&d);
    if (decimals > 0) {
        push_decimal(&d, fraction, decimals);
        push(&d, '.');
    }
    push_decimal(&d, whole, 1);
    return finish(out, &d, negative && (whole | fraction) != 0, width, pad);
}
