/* SPDX-License-Identifier: MIT */
/*
 * shuttle.c - a small machine to start from: one carriage on one servo, one I/O unit.
 *
 * It waits for the bus, enables the servo, looks for the home switch, and then moves the carriage
 * back and forth with a trapezoidal speed profile that it computes itself, set-point by set-point,
 * in Program_04. Input 0 of the I/O unit is mirrored to its output 0. What a screen wants to show
 * lies in TGM_Data as `struct shuttle_status`.
 *
 * Every function keeps the order the manual asks for: read inputs, compute, write outputs.
 */
#include <tgm_plc.h>

#define SHUTTLE_VERSION 100 /* 1.00 */
#define INFO_SIZE       160

/* The machine, in revolutions of the motor and seconds. */
#define HOMING_SPEED 1.0  /* rev/s, towards the home switch */
#define TRAVEL_SPEED 8.0  /* rev/s */
#define ACCELERATION 40.0 /* rev/s2 */
#define STROKE_FROM  1.0  /* rev from the home switch */
#define STROKE_TO    6.0
#define FAULT_PAUSE  1.0  /* s between a drive fault and the attempt to reset it */
#define HOME_SWITCH  0x04u /* bit of SERVO.DigitalIn; CiA 402 object 0x60FD, bit 2 */

enum state { WAIT_FOR_BUS, ENABLE, HOMING, HOMING_STOP, MOVING, FAULT };

/* At offset 0 of TGM_Data, for visualisation. Written by Program_04 only. */
struct shuttle_status {
    uint32_t version;
    uint32_t state;
    uint32_t strokes;    /* ends reached since homing */
    uint32_t faults;     /* drive faults seen */
    double position;     /* rev from the home switch; 0 before homing */
    double speed;        /* commanded, rev/s */
};
TGM_STATIC_ASSERT(sizeof(struct shuttle_status) == 32, "the screen reads it by offset");

/* A point that moves to a target and never exceeds the speed and acceleration given. */
struct profile {
    double position; /* inc */
    double speed;    /* inc/s */
};

/* Nothing here has a value before Program_Ini gave it one: TG Motion does not initialise globals. */
static struct {
    SYSTEM *system;
    SERVO *servo;
    DIO *dio;
    struct shuttle_status *status;
    double cycle; /* s */
    double rev;   /* inc per revolution */
    enum state state;
    double pause;
    double home; /* inc */
    double target;
    struct profile profile;
    uint32_t strokes;
    uint32_t faults;
    uint32_t told; /* state last reported by Program_01 */
    wchar_t info[INFO_SIZE];
} plc;

/* One step of a trapezoidal profile: the fastest speed from which it can still stop at the target. */
static void profile_step(struct profile *p, double target, double top_speed, double acceleration, double cycle)
{
    const double distance = target - p->position;
    const double size = distance < 0 ? -distance : distance;
    const double step = acceleration * cycle; /* largest change of speed in one cycle */
    double wanted = step * (__builtin_sqrt(0.25 + 2.0 * size / (step * cycle)) - 0.5);

    if (wanted > top_speed)
        wanted = top_speed;
    if (distance < 0)
        wanted = -wanted;
    if (wanted > p->speed + step)
        wanted = p->speed + step;
    if (wanted < p->speed - step)
        wanted = p->speed - step;
    p->speed = wanted;
    p->position += wanted * cycle;
}

static const wchar_t *state_name(uint32_t state)
{
    switch (state) {
    case WAIT_FOR_BUS: return L"waiting for EtherCAT";
    case ENABLE: return L"enabling the servo";
    case HOMING: return L"looking for the home switch";
    case HOMING_STOP: return L"home switch found";
    case MOVING: return L"moving";
    default: return L"drive fault";
    }
}

/* The checks the manual advises, in its order. */
static int conditions_are_met(PLC_DATA *pData)
{
    if (pData == NULL || pData->structSize != sizeof(PLC_DATA))
        return 0;
    if (pData->functions.pRtWprintf_Long == NULL || pData->functions.pRtWprintf_String == NULL ||
        pData->functions.pswprintf == NULL || pData->functions.pSleepFt == NULL)
        return 0;

    const SYSTEM *system = pData->PSystem_Memory;
    if (system->Header.Compatibility_Id != ID_COMPATIBILITY) {
        pData->functions.pswprintf(plc.info, INFO_SIZE,
                                   L"shuttle: not started: made for compatibility id %d, TG Motion has %d\n",
                                   ID_COMPATIBILITY, (int)system->Header.Compatibility_Id);
        pData->functions.pRtWprintf_String(plc.info);
        return 0;
    }
    if (system->Main.Number_Servos < 1 || system->Main.Number_Dios < 1 ||
        system->Header.Mem_Size_Data < sizeof(struct shuttle_status)) {
        pData->functions.pRtWprintf_String(L"shuttle: not started: one servo and one I/O unit are needed\n");
        return 0;
    }
    return 1;
}

long Program_Ini(PLC_DATA *pData)
{
    if (!conditions_are_met(pData))
        return 0;

    memset(&plc, 0, sizeof plc);
    plc.system = pData->PSystem_Memory;
    plc.servo = pData->PServo_Memory;
    plc.dio = pData->PDio_Memory;
    plc.status = pData->PData_Memory;
    plc.cycle = plc.system->Main.Servo_SetCycleTime * 1e-6;
    plc.rev = plc.servo->Resolution;
    plc.state = WAIT_FOR_BUS;
    plc.told = ~0u;
    plc.status->version = SHUTTLE_VERSION;

    pData->functions.pswprintf(plc.info, INFO_SIZE, L"shuttle %d.%02d started, cycle %d us\n",
                               SHUTTLE_VERSION / 100, SHUTTLE_VERSION % 100,
                               (int)plc.system->Main.Servo_SetCycleTime);
    pData->functions.pRtWprintf_String(plc.info);
    return 1;
}

/* Lowest priority: tell the console what the machine is doing. */
long Program_01(PLC_DATA *pData)
{
    const uint32_t state = plc.status->state;
    if (state != plc.told) {
        plc.told = state;
        pData->functions.pswprintf(plc.info, INFO_SIZE, L"shuttle: %ls\n", state_name(state));
        pData->functions.pRtWprintf_String(plc.info);
    }
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

/* What the machine sees in this cycle. */
struct inputs {
    int bus_ready, enabled, fault, home_switch;
    double position; /* inc */
    int32_t in;
};

static struct inputs read_inputs(void)
{
    const struct inputs in = {
        .bus_ready = plc.servo->EtherCATState == ETHERCAT_STATE_OP && plc.dio->EtherCATState == ETHERCAT_STATE_OP,
        .enabled = plc.servo->Status == SERVO_READY_ENABLE,
        .fault = plc.servo->Status == SERVO_FAULT,
        .home_switch = (plc.servo->DigitalIn & HOME_SWITCH) != 0,
        .position = plc.servo->Position,
        .in = plc.dio->In0,
    };
    return in;
}

/* While the servo is not enabled, the set-point follows the carriage, so that enabling never jumps. */
static void follow(const struct inputs *in)
{
    plc.profile.position = in->position;
    plc.profile.speed = 0;
}

static void home_step(const struct inputs *in)
{
    const double top = HOMING_SPEED * plc.rev, acceleration = ACCELERATION * plc.rev;

    if (plc.state == HOMING && in->home_switch) {
        plc.home = in->position;
        plc.target = plc.home + STROKE_TO * plc.rev;
        plc.state = HOMING_STOP;
    }
    if (plc.state == HOMING) { /* a target that is always one revolution ahead */
        profile_step(&plc.profile, plc.profile.position - plc.rev, top, acceleration, plc.cycle);
        return;
    }
    profile_step(&plc.profile, plc.home + STROKE_FROM * plc.rev, top, acceleration, plc.cycle);
    if (plc.profile.position - plc.home >= 0.999 * STROKE_FROM * plc.rev)
        plc.state = MOVING;
}

static void move_step(void)
{
    const double near = plc.home + STROKE_FROM * plc.rev, far = plc.home + STROKE_TO * plc.rev;
    const double left = plc.target - plc.profile.position;

    if (left < 1.0 && left > -1.0) { /* within one increment: turn round */
        plc.strokes++;
        plc.target = plc.target == far ? near : far;
    }
    profile_step(&plc.profile, plc.target, TRAVEL_SPEED * plc.rev, ACCELERATION * plc.rev, plc.cycle);
}

static void compute(const struct inputs *in)
{
    if (!in->bus_ready)
        plc.state = WAIT_FOR_BUS;
    else if (in->fault && plc.state != FAULT) {
        plc.state = FAULT;
        plc.pause = FAULT_PAUSE;
        plc.faults++;
    }

    switch (plc.state) {
    case WAIT_FOR_BUS:
        follow(in);
        if (in->bus_ready)
            plc.state = ENABLE;
        break;
    case ENABLE:
        follow(in);
        if (in->enabled)
            plc.state = HOMING;
        break;
    case HOMING:
    case HOMING_STOP: home_step(in); break;
    case MOVING: move_step(); break;
    case FAULT:
        follow(in);
        plc.pause -= plc.cycle;
        if (plc.pause <= -0.1 && !in->fault)
            plc.state = ENABLE;
        break;
    }
}

static void write_outputs(const struct inputs *in)
{
    const int run = plc.state == ENABLE || plc.state == HOMING || plc.state == HOMING_STOP || plc.state == MOVING;
    const int reset = plc.state == FAULT && plc.pause <= 0;

    plc.servo->Mode = run ? SERVO_MODE_POSITION : SERVO_MODE_OFF;
    plc.servo->Control = reset ? SERVO_RESET_FAULT_BIT0 : 0;
    plc.servo->WritePosition = plc.profile.position;
    plc.dio->Out0 = in->in & 1;

    plc.status->state = plc.state;
    plc.status->strokes = plc.strokes;
    plc.status->faults = plc.faults;
    plc.status->position =
        plc.state == MOVING || plc.state == HOMING_STOP ? (in->position - plc.home) / plc.rev : 0;
    plc.status->speed = plc.profile.speed / plc.rev;
}

/* Once in every Cycle_Time, never interrupted: the machine itself. */
long Program_04(PLC_DATA *pData)
{
    (void)pData;
    const struct inputs in = read_inputs();
    compute(&in);
    write_outputs(&in);
    return 1;
}

long Program_05(PLC_DATA *pData)
{
    (void)pData;
    return 1;
}
