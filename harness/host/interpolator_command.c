/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * INTERPOLATOR.Command: parameters first, Command last; the host puts it back to 0. What is refused
 * leaves Command_Status at -1 until the next command (docs/decisions.md, M15).
 */
#include "host/host_parts.h"

#include <math.h>

#define MILLIONTH 1e-6
#define SETTLED   1e-6 /* mm: so near are the filters when they have settled */

enum result { DONE, RUNS, REFUSED };

/* Stands, and with it what is behind the filters. */
static enum result stands(const struct interpolator *in)
{
    if (interp_run_is_active(&in->run))
        return REFUSED;
    for (unsigned axis = 0; axis < INTERP_AXES; axis++)
        if (fabs(in->position[axis] - in->run.position[axis]) > SETTLED)
            return RUNS;
    return DONE;
}

static enum result set_ratio(const struct host *host, struct interpolator *in, int32_t command)
{
    const int32_t *par = in->reg->Command_Parametr;
    (void)host;
    (void)command;
    if (par[0] < 0 || par[0] >= INTERP_AXES || par[2] == 0)
        return REFUSED;
    in->reg->Ratio[par[0]] = (double)par[1] / par[2];
    return DONE;
}

static double coordinate(const INTERPOLATOR *reg, int32_t command, unsigned axis)
{
#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
    if (command >= INTERPOLATOR_COMMANDS_SET_COORDS_ON_TRAJ_DOUBLE_2050)
        return reg->Command_Parameter_Double[axis];
#endif
    (void)command;
    return reg->Command_Parametr[axis];
}

static enum result set_position(const struct host *host, struct interpolator *in, int32_t command)
{
    const INTERPOLATOR *reg = in->reg;
    const enum result still = stands(in);
    double position[INTERP_AXES];
    (void)host;
    if (still != DONE)
        return still;
    for (unsigned axis = 0; axis < INTERP_AXES; axis++) {
        position[axis] = axis < reg->Number_Axes ? coordinate(reg, command, axis) / reg->Ratio[axis]
                                                 : in->run.position[axis];
        if (!(fabs(position[axis]) <= INTERP_LARGEST))
            return REFUSED;
    }
    interpolator_place(in, position);
    if ((command & 1) != 0)
        interp_run_drop(&in->run);
    return DONE;
}

static enum result set_filter(const struct host *host, struct interpolator *in, int32_t command)
{
    const int32_t *par = in->reg->Command_Parametr;
    const enum result still = stands(in);
    (void)command;
    if (still != DONE)
        return still;
    return interp_iir_set(&in->iir, par[0] * MILLIONTH, par[1] * MILLIONTH, par[2] * MILLIONTH,
                          (uint32_t)par[3], interpolator_step_us(host) * 1e-6, in->run.position)
               ? DONE
               : REFUSED;
}

static enum result set_spline(const struct host *host, struct interpolator *in, int32_t command)
{
    const int32_t *par = in->reg->Command_Parametr;
    const enum result still = stands(in);
    (void)host;
    (void)command;
    if (par[0] != 0 && (par[0] < INTERP_SPLINE_LEAST || par[0] > INTERP_SPLINE_MOST || par[1] < 0))
        return REFUSED;
    if (still != DONE)
        return still;
    in->jerk = par[1];
    interp_spline_set(&in->spline, (unsigned)par[0], in->run.position);
    return DONE;
}

/* 4, 5, 8, 9: bit 2 or 3 says which ramp, bit 0 that the trajectory is left. */
static enum result stop(const struct host *host, struct interpolator *in, int32_t command)
{
    (void)host;
    if (in->command != command)
        interp_run_stop(&in->run, (command & 4) != 0, (command & 1) != 0);
    return interp_run_is_active(&in->run) ? RUNS : DONE;
}

static const struct command {
    int32_t number;
    enum result (*carry_out)(const struct host *host, struct interpolator *in, int32_t command);
} commands[] = {
    { INTERPOLATOR_COMMANDS_SET_AXIS_RATIO_1024, set_ratio },
    { INTERPOLATOR_COMMANDS_SET_COORDS_ON_TRAJ_2048, set_position },
    { INTERPOLATOR_COMMANDS_SET_COORDS_OUT_TRAJ_2049, set_position },
    { INTERPOLATOR_COMMANDS_EMERGENCY_STOP_04, stop },
    { INTERPOLATOR_COMMANDS_EMERGENCY_STOP_OUT_TRAJ_05, stop },
    { INTERPOLATOR_COMMANDS_NORMAL_STOP_08, stop },
    { INTERPOLATOR_COMMANDS_NORMAL_STOP_OUT_TRAJ_09, stop },
    { INTERPOLATOR_COMMANDS_SET_FILTER_PARAMETERS_M1, set_filter },
    { INTERPOLATOR_COMMANDS_SET_SPLINE_PARAMETERS_M2, set_spline },
#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
    { INTERPOLATOR_COMMANDS_SET_COORDS_ON_TRAJ_DOUBLE_2050, set_position },
    { INTERPOLATOR_COMMANDS_SET_COORDS_OUT_TRAJ_DOUBLE_2051, set_position },
#endif
};

static enum result carry_out(const struct host *host, struct interpolator *in, int32_t command)
{
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
        if (commands[i].number == command)
            return commands[i].carry_out(host, in, command);
    return REFUSED;
}

/* What Command shows while the command runs. */
static int32_t shown(int32_t command)
{
#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
    if (command >= INTERPOLATOR_COMMANDS_EMERGENCY_STOP_04 &&
        command <= INTERPOLATOR_COMMANDS_NORMAL_STOP_OUT_TRAJ_09)
        return (command & 4) != 0 ? INTERPOLATOR_COMMANDS_EMERGENCY_STOP_WAIT_M04
                                  : INTERPOLATOR_COMMANDS_NORMAL_STOP_WAIT_M08;
#endif
    return command;
}

void interpolator_command(const struct host *host, struct interpolator *in)
{
    static const int32_t outcomes[] = { [DONE] = INTERPOLATOR_COMMAND_STATUS_DONE,
                                        [RUNS] = INTERPOLATOR_COMMAND_STATUS_RUNNING,
                                        [REFUSED] = INTERPOLATOR_COMMAND_STATUS_ERROR };
    INTERPOLATOR *reg = in->reg;
    int32_t command = reg->Command;
    if (in->command != 0 && command == shown(in->command))
        command = in->command;
    if (command == INTERPOLATOR_COMMANDS_NONE_00) {
        in->command = 0;
        return;
    }
    const enum result result = carry_out(host, in, command);
    in->command = result == RUNS ? command : 0;
    reg->Command_Status = outcomes[result];
    reg->Command = result == RUNS ? shown(command) : INTERPOLATOR_COMMANDS_NONE_00;
}
