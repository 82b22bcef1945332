/* SPDX-License-Identifier: MIT */
/*
 * shuttle.cpp - the machine of the C template in C++17: one carriage on one servo, one I/O unit.
 *
 * What C++ has to respect here: TG Motion does not initialise globals and runs no constructors, so the
 * machine lives in raw memory and Program_Ini builds it there; no exceptions, no RTTI, no new and delete.
 * A global that code would have to initialise does not link, and the message names it.
 */
#include <tgm_plc.h>
#include <tgm/start.h>
#include <tgm/text.h>

inline void *operator new(size_t, void *place) noexcept
{
    return place;
}

namespace
{

constexpr uint32_t version = 100; /* 1.00 */

/* The machine, in revolutions of the motor and seconds. */
constexpr double homing_speed = 1.0;  /* rev/s, towards the home switch */
constexpr double travel_speed = 8.0;  /* rev/s */
constexpr double acceleration = 40.0; /* rev/s2 */
constexpr double stroke_from = 1.0;   /* rev from the home switch */
constexpr double stroke_to = 6.0;
constexpr double fault_pause = 1.0;      /* s between a drive fault and the attempt to reset it */
constexpr uint32_t home_switch = 0x04u;  /* bit of SERVO.DigitalIn; CiA 402 object 0x60FD, bit 2 */

/* What differs between the generations of TG Motion. */
#if TGM_GENERATION == 4
SYSTEM *system_of(const PLC_DATA &data) { return static_cast<SYSTEM *>(data.PSystem_Memory); }
SERVO *servo_of(const PLC_DATA &data) { return static_cast<SERVO *>(data.PServo_Memory); }
DIO *dio_of(const PLC_DATA &data) { return static_cast<DIO *>(data.PDio_Memory); }
void *data_of(const PLC_DATA &data) { return data.PData_Memory; }
int32_t inputs_of(const DIO &dio) { return dio.In0; }
void set_outputs(DIO &dio, int32_t value) { dio.Out0 = value; }
void say(const PLC_DATA &data, const tgm_char *text) { data.functions.pRtWprintf_String(text); }
#else
SYSTEM *system_of(const PLC_DATA &data) { return data.pSystem_Memory; }
SERVO *servo_of(const PLC_DATA &data) { return data.pServo_Memory; }
DIO *dio_of(const PLC_DATA &data) { return data.pDio_Memory; }
void *data_of(const PLC_DATA &data) { return data.pData_Memory; }
int32_t inputs_of(const DIO &dio) { return static_cast<int32_t>(dio.In[0]); }
void set_outputs(DIO &dio, int32_t value) { dio.Out[0] = static_cast<uint32_t>(value); }
void say(const PLC_DATA &data, const tgm_char *text) { data.functions.pRtWprintf_String_Severity(ODS_ID_PLC, text); }
#endif

enum class State : uint32_t { wait_for_bus, enable, homing, homing_stop, moving, fault };

/* At offset 0 of TGM_Data, for visualisation. Written by Program_04 only. */
struct Status {
    uint32_t version, state, strokes, faults;
    double position; /* rev from the home switch; 0 before homing */
    double speed;    /* commanded, rev/s */
};
static_assert(sizeof(Status) == 32, "the screen reads it by offset");

/* A line of the console. */
class Line
{
  public:
    explicit Line(const char *begin)
    {
        tgm_text_init(&text, buffer, sizeof buffer / sizeof *buffer);
        add(begin);
    }
    Line &add(const char *more)
    {
        tgm_text_utf8(&text, more);
        return *this;
    }
    Line &add(uint32_t number, unsigned width = 0)
    {
        tgm_text_unsigned(&text, number, width, '0');
        return *this;
    }
    void say_to(const PLC_DATA &data)
    {
        add("\n");
        say(data, buffer);
    }

  private:
    tgm_char buffer[80];
    tgm_text text;
};

/* A point that moves to a target and never exceeds the speed and acceleration given. */
struct Profile {
    double position = 0; /* inc */
    double speed = 0;    /* inc/s */

    /* One cycle: the fastest speed from which it can still stop at the target. */
    void step(double target, double top, double acc, double cycle)
    {
        const double distance = target - position;
        const double size = distance < 0 ? -distance : distance;
        const double change = acc * cycle;
        double wanted = change * (__builtin_sqrt(0.25 + 2.0 * size / (change * cycle)) - 0.5);
        if (wanted > top)
            wanted = top;
        if (distance < 0)
            wanted = -wanted;
        if (wanted > speed + change)
            wanted = speed + change;
        if (wanted < speed - change)
            wanted = speed - change;
        speed = wanted;
        position += wanted * cycle;
    }
};

/* What the machine sees in a cycle. */
struct Inputs {
    bool bus_ready, enabled, fault, home;
    double position; /* inc */
    int32_t in;
};

class Shuttle
{
  public:
    explicit Shuttle(const PLC_DATA &data)
        : servo(*servo_of(data)), dio(*dio_of(data)), status(*static_cast<Status *>(data_of(data))),
          cycle(system_of(data)->Main.Servo_SetCycleTime * 1e-6), rev(servo.Resolution)
    {
        status.version = version;
    }

    void run()
    {
        const Inputs in = read();
        compute(in);
        write(in);
    }

    void tell(const PLC_DATA &data)
    {
        const uint32_t now = status.state;
        if (now == told)
            return;
        told = now;
        Line("shuttle: ").add(name_of(static_cast<State>(now))).say_to(data);
    }

  private:
    SERVO &servo;
    DIO &dio;
    Status &status;
    double cycle; /* s */
    double rev;   /* inc per revolution */
    State state = State::wait_for_bus;
    Profile profile;
    double pause = 0, home = 0, target = 0;
    uint32_t strokes = 0, faults = 0, told = ~0u;

    static const char *name_of(State state)
    {
        switch (state) {
        case State::wait_for_bus: return "waiting for EtherCAT";
        case State::enable: return "enabling the servo";
        case State::homing: return "looking for the home switch";
        case State::homing_stop: return "home switch found";
        case State::moving: return "moving";
        case State::fault: break;
        }
        return "drive fault";
    }

    Inputs read() const
    {
        return { servo.EtherCATState == ETHERCAT_STATE_OP && dio.EtherCATState == ETHERCAT_STATE_OP,
                 servo.Status == SERVO_READY_ENABLE,
                 servo.Status == SERVO_FAULT,
                 (servo.DigitalIn & home_switch) != 0,
                 servo.Position,
                 inputs_of(dio) };
    }

    /* While the servo is not enabled, the set-point follows the carriage: enabling never jumps. */
    void follow(const Inputs &in)
    {
        profile.position = in.position;
        profile.speed = 0;
    }

    void find_home(const Inputs &in)
    {
        if (state == State::homing && in.home) {
            home = in.position;
            target = home + stroke_to * rev;
            state = State::homing_stop;
        }
        const double aim = state == State::homing ? profile.position - rev : home + stroke_from * rev;
        profile.step(aim, homing_speed * rev, acceleration * rev, cycle);
        if (state == State::homing_stop && profile.position - home >= 0.999 * stroke_from * rev)
            state = State::moving;
    }

    void move()
    {
        const double near = home + stroke_from * rev, far = home + stroke_to * rev;
        const double left = target - profile.position;
        if (left < 1.0 && left > -1.0) { /* within one increment: turn round */
            strokes++;
            target = target == far ? near : far;
        }
        profile.step(target, travel_speed * rev, acceleration * rev, cycle);
    }

    void compute(const Inputs &in)
    {
        if (!in.bus_ready) {
            state = State::wait_for_bus;
        } else if (in.fault && state != State::fault) {
            state = State::fault;
            pause = fault_pause;
            faults++;
        }
        switch (state) {
        case State::wait_for_bus:
            follow(in);
            if (in.bus_ready)
                state = State::enable;
            break;
        case State::enable:
            follow(in);
            if (in.enabled)
                state = State::homing;
            break;
        case State::homing:
        case State::homing_stop: find_home(in); break;
        case State::moving: move(); break;
        case State::fault:
            follow(in);
            pause -= cycle;
            if (pause <= -0.1 && !in.fault)
                state = State::enable;
            break;
        }
    }

    void write(const Inputs &in)
    {
        const bool run = state != State::wait_for_bus && state != State::fault;
        const bool placed = state == State::moving || state == State::homing_stop;
        servo.Mode = run ? SERVO_MODE_POSITION : SERVO_MODE_OFF;
        servo.Control = state == State::fault && pause <= 0 ? SERVO_RESET_FAULT_BIT0 : 0;
        servo.WritePosition = profile.position;
        set_outputs(dio, in.in & 1);

        status.state = static_cast<uint32_t>(state);
        status.strokes = strokes;
        status.faults = faults;
        status.position = placed ? (in.position - home) / rev : 0;
        status.speed = profile.speed / rev;
    }
};

alignas(Shuttle) unsigned char room[sizeof(Shuttle)];
Shuttle *shuttle;

} // namespace

long Program_Ini(PLC_DATA *pData)
{
    if (!tgm_check_start(pData))
        return 0;
    const SYSTEM &system = *system_of(*pData);
    if (system.Main.Number_Servos < 1 || system.Main.Number_Dios < 1 || system.Header.Mem_Size_Data < sizeof(Status)) {
        Line("shuttle: not started: one servo and one I/O unit are needed").say_to(*pData);
        return 0;
    }
    shuttle = new (room) Shuttle(*pData);
    Line("shuttle ")
        .add(version / 100)
        .add(".")
        .add(version % 100, 2)
        .add(" started, cycle ")
        .add(system.Main.Servo_SetCycleTime)
        .add(" us")
        .say_to(*pData);
    return 1;
}

/* Lowest priority: tell the console what the machine is doing. */
long Program_01(PLC_DATA *pData)
{
    shuttle->tell(*pData);
    return 1;
}

long Program_02(PLC_DATA *)
{
    return 1;
}

long Program_03(PLC_DATA *)
{
    return 1;
}

/* Once in every Cycle_Time, never interrupted: the machine itself. */
long Program_04(PLC_DATA *)
{
    shuttle->run();
    return 1;
}

long Program_05(PLC_DATA *)
{
    return 1;
}
