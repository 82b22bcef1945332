/* SPDX-License-Identifier: MIT */
/*
 * motion.h - the small helpers of every machine: edges, debouncing, timers, ramps, a positioning profile, bits
 * of I/O units.
 *
 *     static struct tgm_ton lubrication;                      no initial value: TG Motion gives none
 *     tgm_ton_init(&lubrication, 1500000);                    in Program_Ini: 1.5 s
 *     out = tgm_ton_step(&lubrication, in, cycle_us);         in Program_04
 *
 * Each helper is a struct of the caller's and a pair of functions: x_init gives every member a value,
 * x_step is called once in each cycle of the one program that owns it. Members may be read at any time;
 * those marked "may be written" may be changed between two calls.
 *
 * Time is in whole microseconds throughout, since a thousand times 250 us is exactly 250 ms and a thousand
 * times 0.00025 is not. elapsed_us is the time since the previous call: the period of the program in
 * Program_02 to Program_04 (SYSTEM.Main.Servo_SetCycleTime in Program_04); in a program without a fixed
 * period it comes from a counter through tgm_tick_elapsed. Positions are in any unit the caller
 * likes (increments, millimetres), speeds in that unit per second, accelerations in unit per second squared.
 *
 * A level is an int: 0 is off, everything else on; functions return 0 or 1.
 *
 * Context: any of the six functions; made for Program_04 and Program_05: no loop depends on
 * the data, no call takes more than about 100 ns on a PC. A struct must not be used from two programs, which
 * interrupt each other. Pointers must not be NULL.
 */
#ifndef TGM_MOTION_H
#define TGM_MOTION_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Edges ---------------------------------------------------------------------------------------- */

struct tgm_edge {
    int level; /* at the last call */
};

enum tgm_edge_kind { TGM_EDGE_FALLING = -1, TGM_EDGE_NONE = 0, TGM_EDGE_RISING = 1 };

/* level: what counts as the level before the first call. With 0, an input that is on from the start is
 * a rising edge at the first call (as R_TRIG of IEC 61131-3); with the input's level it is none. */
void tgm_edge_init(struct tgm_edge *e, int level);

/* What happened since the last call. */
enum tgm_edge_kind tgm_edge_step(struct tgm_edge *e, int level);

/* ---- Elapsed time from a counter -------------------------------------------------------------------- */

struct tgm_tick {
    uint32_t last;
};

/* now: the counter, such as SYSTEM.Main.Servo_Tick or one of the counting-up timers (1 ms). */
void tgm_tick_init(struct tgm_tick *t, uint32_t now);

/* Counts since the last call; right across the wrap of the counter at 2^32, as long as less than
 * 2^32 counts lie between two calls. Multiply by what one count is worth to get microseconds. */
uint32_t tgm_tick_elapsed(struct tgm_tick *t, uint32_t now);

/* ---- Debouncing ------------------------------------------------------------------------------------- */

struct tgm_debounce {
    int level;           /* the accepted level */
    int differs;         /* the input was different from it at the last call */
    uint64_t elapsed_us; /* for how long */
    uint64_t hold_us;    /* how long it must be; may be written */
};

void tgm_debounce_init(struct tgm_debounce *d, int level, uint64_t hold_us);

/* The accepted level: follows the input once that has kept the other level for hold_us in every call. The
 * call that first sees the other level counts as the beginning; a hold time of 0 follows at once. */
int tgm_debounce_step(struct tgm_debounce *d, int input, uint32_t elapsed_us);

/* ---- Timers of IEC 61131-3 ---------------------------------------------------------------------------
 *
 * preset_us is PT, elapsed_us ET (0 .. PT), output Q, the result of the step is Q. Time begins with the call
 * that sees the edge: in that call ET is 0. ET stops at PT, so nothing wraps, however long a timer stands.
 * 64 bits, because 32 bits of microseconds end after 71 minutes. preset_us may be written; it counts
 * from the next call on. A preset of 0: TON and TOF follow the input, TP gives no pulse.
 */

/* On-delay: on when the input has been on for PT, off with the input. */
struct tgm_ton {
    uint64_t preset_us;
    uint64_t elapsed_us;
    int input; /* at the last call */
    int output;
};
void tgm_ton_init(struct tgm_ton *t, uint64_t preset_us);
int tgm_ton_step(struct tgm_ton *t, int input, uint32_t elapsed_us);

/* Off-delay: on with the input, off when the input has been off for PT. Begins off. */
struct tgm_tof {
    uint64_t preset_us;
    uint64_t elapsed_us;
    int input;
    int output;
};
void tgm_tof_init(struct tgm_tof *t, uint64_t preset_us);
int tgm_tof_step(struct tgm_tof *t, int input, uint32_t elapsed_us);

/* Pulse: a rising edge of the input gives one pulse of length PT, whatever the input does meanwhile; an edge
 * during the pulse, the call that ends it included, is lost. ET keeps PT until the input is off. */
struct tgm_tp {
    uint64_t preset_us;
    uint64_t elapsed_us;
    int input;
    int output;
};
void tgm_tp_init(struct tgm_tp *t, uint64_t preset_us);
int tgm_tp_step(struct tgm_tp *t, int input, uint32_t elapsed_us);

/* ---- Ramp ------------------------------------------------------------------------------------------- */

/* A value that follows another no faster than given: an override, a torque limit, a speed reference. */
struct tgm_ramp {
    double value; /* may be written: jumps there */
    double up;    /* largest growth, unit per second; may be written */
    double down;  /* largest decline, unit per second, as a positive number; may be written */
};
void tgm_ramp_init(struct tgm_ramp *r, double value, double up, double down);

/* The next value; exactly the target once it is in reach, never beyond it. A rate that is 0, negative or no
 * number stops that direction, an infinite one follows at once; a target that is no number leaves
 * the value as it is. */
double tgm_ramp_step(struct tgm_ramp *r, double target, uint32_t elapsed_us);

/* ---- Positioning ------------------------------------------------------------------------------------ */

/*
 * A set-point that moves to a target with limited speed, acceleration and deceleration, for
 * SERVO.WritePosition in Program_04 (SERVO_MODE_POSITION).
 *
 * The profile is exact in discrete time: within a cycle the speed changes linearly, from one cycle to the
 * next by at most acceleration (deceleration) * cycle, and the brake point is computed for whole cycles.
 * So the set-point stops on the target to the last bit, with speed 0, without creeping and without going
 * past it. A new target, new limits or a stop may come at any time, also in motion and for the other
 * direction; only then, when the new target is nearer than the way to brake, or the deceleration
 * was made smaller on the way, the set-point has to pass the target: it brakes as hard as allowed and comes
 * back. Where the speed limit is lowered below the speed, it is reached with the deceleration.
 *
 * Numbers must be finite and not above 1e300 in size ("usable" below); others are refused.
 */
struct tgm_move {
    double position;     /* unit; the set-point of this cycle */
    double speed;        /* unit/s, with sign, at the end of this cycle */
    double target;       /* unit; after a stop, where it came to rest */
    double speed_limit;  /* unit/s, > 0 */
    double acceleration; /* unit/s2, > 0 */
    double deceleration; /* unit/s2, > 0 */
    double cycle;        /* s */
    int stopping;        /* 1 from tgm_move_stop to the rest */
};

/* Stands at position (0 when that is not usable), which is also the target. cycle_us: the period of the
 * program that calls tgm_move_step; 0 makes a profile that never moves. Limits are 1 each until
 * tgm_move_limits. */
void tgm_move_init(struct tgm_move *m, double position, uint32_t cycle_us);

/* Stands at position at once, without a ramp: to follow a drive that is not enabled. Returns 1, or 0, changing
 * nothing, when position is not usable. */
int tgm_move_set(struct tgm_move *m, double position);

/* All > 0 and usable; returns 1, or 0, changing nothing. */
int tgm_move_limits(struct tgm_move *m, double speed_limit, double acceleration, double deceleration);

/* A new target, from the next step on; also ends a stop. Returns 1, or 0, changing nothing, when target
 * is not usable. */
int tgm_move_to(struct tgm_move *m, double target);

/* Brakes to a standstill, from the next step on, and forgets the target. */
void tgm_move_stop(struct tgm_move *m);

/* One cycle; returns the new set-point. */
double tgm_move_step(struct tgm_move *m);

/* 1: stands on the target (after a stop: stands). */
int tgm_move_done(const struct tgm_move *m);

/* ---- Bits of I/O units ------------------------------------------------------------------------------
 *
 * Bit 0 is the first input or output of the unit. Generation 4 keeps 8 of them in each word, generation
 * 5 keeps 32; the words lie in sequence, whatever their members are called:
 *
 *     tgm_dio4_get(TGM_DIO4_IN(dio), 9)            DIO.In1, bit 1
 *     tgm_dio4_set(TGM_DIO4_OUT(dio), 64, on)      DIO.Ext_Out0, bit 0
 *     tgm_dio5_get(dio->In, 33)                    DIO.In[1], bit 1
 *
 * A bit outside the range reads as 0 and is not written. Setting reads the word, changes it and writes it
 * back: outputs of one word must be set from one program only. Outputs may be read back, too.
 */
#define TGM_DIO4_BITS 128 /* 16 words of 8 bits */
#define TGM_DIO5_BITS 512 /* 16 words of 32 bits */

/* The words of a DIO of generation 4 as an array. */
#define TGM_DIO4_IN(dio)  ((const int32_t *)(const void *)((const char *)(dio) + offsetof(DIO, In0)))
#define TGM_DIO4_OUT(dio) ((int32_t *)(void *)((char *)(dio) + offsetof(DIO, Out0)))

int tgm_dio4_get(const int32_t *words, uint32_t bit);
/* The upper 24 bits of the word, which TG Motion does not use, are kept. */
void tgm_dio4_set(int32_t *words, uint32_t bit, int level);

int tgm_dio5_get(const uint32_t *words, uint32_t bit);
void tgm_dio5_set(uint32_t *words, uint32_t bit, int level);

#ifdef __cplusplus
}
#endif

#endif
