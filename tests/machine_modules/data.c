/* SPDX-License-Identifier: GPL-2.0-or-later */
/* data.c - one of each kind of data, for what the loader does to it. */

int plain = 0x11223344;
int zeroed[1000];
char bytes[3] = { 1, 2, 3 };
int *pointer = &plain;
const char *const constant_text = "kept";

struct pair {
    int *where;
    long number;
};
const struct pair protected_pairs[2] = { { &plain, 77 }, { &zeroed[5], 88 } };
struct pair pairs[2] = { { &plain, 99 }, { &zeroed[5], 111 } };

long read_plain(void *unused)
{
    (void)unused;
    return *pointer;
}

long write_plain(void *unused)
{
    (void)unused;
    *pointer = 5;
    return plain;
}

long read_protected(void *unused)
{
    (void)unused;
    return protected_pairs[1].number + constant_text[0];
}

long write_protected(void *unused)
{
    struct pair *pair = (struct pair *)&protected_pairs[0];

    (void)unused;
    __asm__ volatile("" : "+r"(pair));
    pair->number = 1;
    return 0;
}
