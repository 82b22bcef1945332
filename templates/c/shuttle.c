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
#include <tgm/start.h>
#include <tgm/text.h>

#define SHUTTLE_VERSION 100 /* 1.00 */
#define LINE_SIZE       80

/* The machine, in revolutions of the motor and seconds. */
#define HOMING_SPEED 1.0  /* rev/s, towards the home switch */
#define TRAVEL_SPEED 8.0  /* rev/s */
#define ACCELERATION 40.0 /* rev/s2 */
#define STROKE_FROM  1.0  /* rev from the home switch */
#define STROKE_TO    6.0
#define FAULT_PAUSE  1.0  /* s between a drive fault and the attempt to reset it */
#define HOME_SWITCH  0x04u /* bit of SERVO.DigitalIn; CiA 402 object 0x60FD, bit 2 */

/* What differs between the generations of TG Motion: names, the words of an I/O unit, the console. */
#if TGM_GENERATION == 4
#define SYSTEM_OF(pData) ((SYSTEM *)(pData)->PSystem_Memory)
#define SERVO_OF(pData)  ((SERVO *)(pData)->PServo_Memory)
#define DIO_OF(pData)    ((DIO *)(pData)->PDio_Memory)
#define DATA_OF(pData)   ((pData)->PData_Memory)
#define INPUTS(dio)      ((dio)->In0)  /* the first octet */
#define OUTPUTS(dio)     ((dio)->Out0)
#define SAY(pData, text) ((pData)->functions.pRtWprintf_String(text))
#else
#define SYSTEM_OF(pData) ((pData)->pSystem_Memory)
#define SERVO_OF(pData)  ((pData)->pServo_Memory)
#define DIO_OF(pData)    ((pData)->pDio_Memory)
#define DATA_OF(pData)   ((pData)->pData_Memory)
#define INPUTS(dio)      ((dio)->In[0]) /* the first 32 inputs */
#define OUTPUTS(dio)     ((dio)->Out[0])
#define SAY(pData, text) ((pData)->functions.pRtWprintf_String_Severity(ODS_ID_PLC, text))
#endif

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
    tgm_char line[LINE_SIZE];
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

static const char *state_name(uint32_t state)
{
    switch (state) {
    case WAIT_FOR_BUS: return "waiting for EtherCAT";
    case ENABLE: return "enabling the servo";
    case HOMING: return "looking for the home switch";
    case HOMING_STOP: return "home switch found";
    case MOVING: return "moving";
    default: return "drive fault";
    }
}

/* "shuttle: moving": begins a line of the console in plc.line. */
static void line_begin(tgm_text *text, const char *begin)
{
    tgm_text_init(text, plc.line, LINE_SIZE);
    tgm_text_utf8(text, begin);
}

static void line_say(PLC_DATA *pData, tgm_text *text)
{
    tgm_text_utf8(text, "\n");
    SAY(pData, plc.line);
}

/* What this machine needs beyond the checks that the manual advises (tgm_check_start). */
static int machine_is_there(PLC_DATA *pData)
{
    const SYSTEM *system = SYSTEM_OF(pData);
    tgm_text text;
    if (system->Main.Number_Servos >= 1 && system->Main.Number_Dios >= 1 &&
        system->Header.Mem_Size_Data >= sizeof(struct shuttle_status))
        return 1;
    line_begin(&text, "shuttle: not started: one servo and one I/O unit are needed");
    line_say(pData, &text);
    return 0;
}

long Program_Ini(PLC_DATA *pData)
{
    tgm_text text;
    if (!tgm_check_start(pData) || !machine_is_there(pData))
        return 0;

    memset(&plc, 0, sizeof plc);
    plc.system = SYSTEM_OF(pData);
    plc.servo = SERVO_OF(pData);
    plc.dio = DIO_OF(pData);
    plc.status = DATA_OF(pData);
    plc.cycle = plc.system->Main.Servo_SetCycleTime * 1e-6;
    plc.rev = plc.servo->Resolution;
    plc.state = WAIT_FOR_BUS;
    plc.told = ~0u;
    plc.status->version = SHUTTLE_VERSION;

    line_begin(&text, "shuttle ");
    tgm_text_unsigned(&text, SHUTTLE_VERSION / 100, 0, ' ');
    tgm_text_utf8(&text, ".");
    tgm_text_unsigned(&text, SHUTTLE_VERSION % 100, 2, '0');
    tgm_text_utf8(&text, " started, cycle ");
    tgm_text_unsigned(&text, plc.system->Main.Servo_SetCycleTime, 0, ' ');
    tgm_text_utf8(&text, " us");
    line_say(pData, &text);
    return 1;
}

/* Lowest priority: tell the console what the machine is doing. */
long Program_01(PLC_DATA *pData)
{
    const uint32_t state = plc.status->state;
    if (state != plc.told) {
        tgm_text text;
        plc.told = state;
        line_begin(&text, "shuttle: ");
        tgm_text_utf8(&text, state_name(state));
        line_say(pData, &text);
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
        .in = (int32_t)INPUTS(plc.dio),
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
    OUTPUTS(plc.dio) = in->in & 1;

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
