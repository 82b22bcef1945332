/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * A module that uses everything in which targets differ under the hood: functions of TG Motion with
 * arguments of every kind, text, arithmetic of 64 bits and of doubles, initialised and constant
 * data, calls through pointers. What comes of it goes to TGM_Data (text from 4096 on, 512 bytes
 * each) and to the console; it is the same on every target.
 */
#include <tgm_plc.h>

#if TGM_GENERATION == 4
#define DATA(data) ((unsigned char *)(data)->PData_Memory)
#else
#define DATA(data) ((unsigned char *)(data)->pData_Memory)
#endif

enum { WORDS = 8, TEXTS = 4096, TEXT = 512 };

struct state {
    int64_t whole[WORDS];
    double real[WORDS];
    uint32_t cycle;
};

typedef double step(double x, int64_t n);

static double shrink(double x, int64_t n)
{
    return x / (double)n + 0.1;
}

static double grow(double x, int64_t n)
{
    return x * 1.0000001 + (double)(n % 7) * 1e-3;
}

static double root(double x, int64_t n)
{
    return __builtin_sqrt(x < 0 ? -x : x) + (double)(int32_t)n * 1e-9;
}

static step *const steps[] = { shrink, grow, root };

static struct state *state_of(PLC_DATA *pData)
{
    return (struct state *)(void *)DATA(pData);
}

static void count(struct state *state)
{
    static const int64_t divisors[WORDS] = { 3, -7, 10, 1000003, -11, 127, 65537, 4294967311 };
    for (int i = 0; i < WORDS; i++) {
        const int64_t n = divisors[i];
        const uint64_t mixed = (uint64_t)state->whole[i] * UINT64_C(6364136223846793005) + 1;
        state->whole[i] = (int64_t)mixed / n + (int64_t)mixed % (n * 1048576) + i;
        state->real[i] = steps[(state->cycle + (uint32_t)i) % 3](state->real[i], n);
    }
    state->cycle++;
}

#if TGM_GENERATION == 4
static tgm_wchar *text_of(PLC_DATA *pData, int number)
{
    return (tgm_wchar *)(void *)(DATA(pData) + TEXTS + number * TEXT);
}

#define W(literal) ((const tgm_wchar *)u##literal)

static void tell(PLC_DATA *pData, const struct state *state)
{
    const PLC_IMPORT_FUNCTIONS *f = &pData->functions;
    int32_t *lengths = (int32_t *)(void *)(DATA(pData) + 2048);
    lengths[0] =
        f->pswprintf(text_of(pData, 0), TEXT / 2, W("%d %u %lld %llx %.17g|%s|%hs|%c"), -1,
                     4000000000u, (long long)state->whole[0], (unsigned long long)state->whole[1],
                     state->real[0], W("\u0159\u010d"), "bytes", (int)u'\u20ac');
    lengths[1] = f->pswprintf(text_of(pData, 1), TEXT / 2, W("%ld %lu %*d %.*f %g %d %g"), -5l, 6ul,
                              8, 42, 3, state->real[1], 0.25, 7, -1e300);
    lengths[2] = f->pswprintf(text_of(pData, 2), TEXT / 2, W("%f %f %f %f %f %f %f %f %f %d"), 1.0,
                              2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, state->real[2], 9);
    lengths[3] = f->pswprintf(text_of(pData, 3), 8, W("%s"), W("does not fit"));
    lengths[4] = f->pRtWprintf_Long(W("value %ld\n"), (int32_t)state->whole[2]);
    lengths[5] = f->pRtWprintf_String(text_of(pData, 1));
    lengths[6] = f->pRtWprintf_Ex(2, W("%g %lld %hd\n"), state->real[3], (long long)state->whole[3],
                                  (short)-3);
}
#else

static void tell(PLC_DATA *pData, const struct state *state)
{
    static const tgm_char text[] =
#ifdef TGM_TEXT8
        "\xc5\x99\xc4\x8d \xe2\x82\xac\n";
#else
        u"\u0159\u010d \u20ac\n";
#endif
    int32_t *lengths = (int32_t *)(void *)(DATA(pData) + 2048);
    (void)state;
    lengths[0] = pData->functions.pRtWprintf_String_Severity(6 | 1 << 8, text);
#if TGM_MEMORY_ID == 906
    if (pData->pGetFunctionOrInfo != NULL) {
        lengths[1] = pData->pGetFunctionOrInfo("nothing", 0) != 0;
        lengths[2] = pData->pGetFunctionOrInfo("pcGetDeviceInfo_v", 0) != 0;
        const char *(*info)(void) =
            (const char *(*)(void))pData->pGetFunctionOrInfo("pcGetDeviceInfo_v", 0);
        for (int i = 0; info()[i] != 0; i++)
            DATA(pData)[TEXTS + i] = (unsigned char)info()[i];
    }
#endif
}
#endif

long Program_Ini(PLC_DATA *pData)
{
    if (pData == NULL || pData->structSize != sizeof(PLC_DATA))
        return 0;
    for (int i = 0; i < WORDS; i++)
        state_of(pData)->real[i] = 1.0 / (i + 3);
    return 1;
}

long Program_01(PLC_DATA *pData)
{
    struct state *state = state_of(pData);
    if (state->cycle % 64 == 3)
        tell(pData, state);
    return 1;
}

long Program_02(PLC_DATA *pData)
{
#if TGM_GENERATION == 4
    TGM_LARGE_INTEGER pause = { .QuadPart = 12345 };
#else
    PLC_LARGE_INTEGER pause = { .QuadPart = 12345 };
#endif
    pData->functions.pSleepFt(&pause);
    return 1;
}

long Program_03(PLC_DATA *pData)
{
    uint8_t bytes[8] = { 1, 2, 3, 4, 5, 6, 7, 8 };
    int32_t *sent = (int32_t *)(void *)(DATA(pData) + 3072);
    sent[0] = pData->functions.pCAN_Transmit(1, 0x123, 8, bytes);
    sent[1] = pData->functions.pCAN_TransmitRemote(1, 0x7ff, 0, bytes);
    return 1;
}

long Program_04(PLC_DATA *pData)
{
    count(state_of(pData));
    return 1;
}

long Program_05(PLC_DATA *pData)
{
    return pData != NULL;
}
