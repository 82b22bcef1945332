/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_six.c - an ordinary module: six entries, one function of each visibility, data that needs
 * relocating, data that is zero. test_image.c looks for the lines marked LINE by their text.
 */
#define EXPORT __attribute__((visibility("default")))

static int zeroed[1000];
static int counter = 7;
static int *const table[] = { &counter, zeroed, &zeroed[1], &zeroed[2], &zeroed[3] };

static __attribute__((noinline, used)) long local_function(const void *data)
{
    zeroed[5] += data != 0; /* LINE local */
    return *table[zeroed[5] % 5];
}

__attribute__((visibility("hidden"), noinline, used)) long hidden_function(const void *data)
{
    return local_function(data) + 2; /* LINE hidden */
}

EXPORT long Program_Ini(void *data);
EXPORT long Program_01(void *data);
EXPORT long Program_02(void *data);
EXPORT long Program_03(void *data);
EXPORT long Program_04(void *data);
EXPORT long Program_05(void *data);

long Program_Ini(void *data)
{
    return hidden_function(data) & 1;
}

long Program_01(void *data)
{
    return local_function(data) & 3;
}

long Program_02(void *data)
{
    return data != 0;
}

long Program_03(void *data)
{
    return data == 0;
}

long Program_04(void *data)
{
    (void)data;
    return ++counter; /* LINE Program_04 */
}

long Program_05(void *data)
{
    (void)data;
    return counter;
}
