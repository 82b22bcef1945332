/* SPDX-License-Identifier: MIT */
/*
 * A module that uses all of the SDK's support library: start checks, text, timers, a positioning profile,
 * I/O bits and every function of <tgm/math.h>. Built by tests/sdk_support.sh for every target.
 */
#include <tgm_plc.h>

#include <tgm/math.h>
#include <tgm/motion.h>
#include <tgm/start.h>
#include <tgm/text.h>

#define LINE 120

static struct {
    SYSTEM *system;
    SERVO *servo;
    DIO *dio;
    uint32_t cycle_us;
    struct tgm_move move;
    struct tgm_ton ready;
    struct tgm_edge input;
    struct tgm_ramp override;
    struct tgm_tick tick;
    uint32_t ends, told;
    double check;
    tgm_char text[LINE];
} plc;

/* The two generations name things differently; the rest of the module does not care. */
#if TGM_GENERATION == 4
#define MEMORY(letter_p, name) letter_p->P##name
static void print(PLC_DATA *pData)
{
    pData->functions.pRtWprintf_String(plc.text);
}
static int input_bit(uint32_t bit)
{
    return tgm_dio4_get(TGM_DIO4_IN(plc.dio), bit);
}
static void output_bit(uint32_t bit, int level)
{
    tgm_dio4_set(TGM_DIO4_OUT(plc.dio), bit, level);
}
#else
#define MEMORY(letter_p, name) letter_p->p##name
static void print(PLC_DATA *pData)
{
    pData->functions.pRtWprintf_String_Severity(ODS_ID_PLC, plc.text);
}
static int input_bit(uint32_t bit)
{
    return tgm_dio5_get(plc.dio->In, bit);
}
static void output_bit(uint32_t bit, int level)
{
    tgm_dio5_set(plc.dio->Out, bit, level);
}
#endif

/* One of everything; 0 but for rounding when the library is right. */
static double mathematics(double x)
{
    double sine, cosine, whole;
    int exponent;
    sincos(x, &sine, &cosine);
    double sum = sin(x) - sine + cos(x) - cosine + tan(x) - sine / cosine;
    sum += asin(sine) - x + acos(cosine) - x + atan(tan(x)) - x + atan2(sine, cosine) - x;
    sum += sinh(x) + cosh(x) - exp(x) + tanh(x) - sinh(x) / cosh(x);
    sum += exp2(log2(x)) - x + expm1(log1p(x)) - x + pow(10, log10(x)) - x + log(exp(x)) - x;
    sum += hypot(3 * x, 4 * x) - 5 * x + cbrt(x * x * x) - x + sqrt(x * x) - x;
    sum += fabs(-x) - x + floor(x) - trunc(x) + ceil(-x) + floor(x) + round(x) - rint(x);
    sum += (double)lround(x) - (double)llround(x) + fmod(x, 1) - modf(x, &whole) + remainder(x, 1) - (x - rint(x));
    sum += fmin(x, 2 * x) - x + fmax(x, 2 * x) - 2 * x + copysign(x, -1) + x;
    const double fraction = frexp(x, &exponent);
    sum += ldexp(fraction, exponent) - scalbn(x, 0) + fma(x, x, -x * x);
    return sum;
}

long Program_Ini(PLC_DATA *pData)
{
    if (!tgm_check_start(pData))
        return 0;
    memset(&plc, 0, sizeof plc);
    plc.system = MEMORY(pData, System_Memory);
    plc.servo = MEMORY(pData, Servo_Memory);
    plc.dio = MEMORY(pData, Dio_Memory);
    plc.cycle_us = (uint32_t)plc.system->Main.Servo_SetCycleTime;

    tgm_move_init(&plc.move, 0, plc.cycle_us);
    if (!tgm_move_limits(&plc.move, 5e6, 5e7, 2e7) || !tgm_move_to(&plc.move, 1e5))
        return 0;
    tgm_ton_init(&plc.ready, 20000);
    tgm_edge_init(&plc.input, 0);
    tgm_ramp_init(&plc.override, 0, 1, 2);
    tgm_tick_init(&plc.tick, (uint32_t)plc.system->Main.Servo_Tick);
    plc.check = mathematics(0.7);

    tgm_text t;
    tgm_text_init(&t, plc.text, LINE);
    tgm_text_utf8(&t, "sdk_support: mathematics off by ");
    tgm_text_fixed(&t, plc.check * 1e12, 3, 0, ' ');
    tgm_text_utf8(&t, "e-12, version 0x");
    tgm_text_hex(&t, 0x0104u, 4, '0');
    tgm_text_character(&t, '\n');
    print(pData);
    return t.truncated == 0 && fabs(plc.check) < 1e-12;
}

long Program_01(PLC_DATA *pData)
{
    tgm_text t;
    if (plc.told == plc.ends)
        return 1;
    plc.told = plc.ends;
    tgm_text_init(&t, plc.text, LINE);
    tgm_text_utf8(&t, "sdk_support: ends ");
    tgm_text_unsigned(&t, plc.told, 0, ' ');
    tgm_text_column(&t, 30);
    tgm_text_fixed(&t, plc.move.position, 2, 14, ' ');
    tgm_text_signed(&t, -1, 4, ' ');
    tgm_text_utf8(&t, "\n");
    print(pData);
    return 1;
}

long Program_02(PLC_DATA *pData)
{
    (void)pData;
    return 1;
}

long Program_03(PLC_DATA *pData)
{
    (void)pData;
    return 1;
}

long Program_04(PLC_DATA *pData)
{
    (void)pData;
    const int enabled = plc.servo->Status == SERVO_READY_ENABLE;
    const int rising = tgm_edge_step(&plc.input, input_bit(0)) == TGM_EDGE_RISING;
    const double position = plc.servo->Position;

    if (!enabled)
        tgm_move_set(&plc.move, position);
    else if (tgm_ton_step(&plc.ready, enabled, plc.cycle_us)) {
        if (tgm_move_done(&plc.move)) {
            plc.ends++;
            tgm_move_to(&plc.move, plc.move.target > 5e4 ? 0 : 1e5);
        }
        tgm_move_step(&plc.move);
    }
    const uint32_t ticks = tgm_tick_elapsed(&plc.tick, (uint32_t)plc.system->Main.Servo_Tick);
    tgm_ramp_step(&plc.override, enabled, ticks * plc.cycle_us);

    plc.servo->Mode = SERVO_MODE_POSITION;
    plc.servo->WritePosition = plc.move.position;
    output_bit(0, rising || (plc.ends & 1) != 0);
    return 1;
}

long Program_05(PLC_DATA *pData)
{
    (void)pData;
    return 1;
}
