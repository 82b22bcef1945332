/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * A module whose Program_05 modifies what the first interpolator gives out: by the first double of
 * TGM_Data times the position of its Y axis it shifts the X axis, in PositionInc; the second is
 * added to Offset[1] once.
 */
#include <tgm_plc.h>

#if TGM_GENERATION == 4
#define INTERPOLATORS(data) ((INTERPOLATOR *)(data)->PInterpolator_Memory)
#define DOUBLES(data)       ((double *)(data)->PData_Memory)
#else
#define INTERPOLATORS(data) ((data)->pInterpolator_Memory)
#define DOUBLES(data)       ((double *)(data)->pData_Memory)
#endif

long Program_Ini(PLC_DATA *pData)
{
    return pData != 0;
}

#define IDLE(name)                                                                                 \
    long name(PLC_DATA *pData)                                                                     \
    {                                                                                              \
        return pData != 0;                                                                         \
    }

IDLE(Program_01)
IDLE(Program_02)
IDLE(Program_03)
IDLE(Program_04)

long Program_05(PLC_DATA *pData)
{
    INTERPOLATOR *interpolator = INTERPOLATORS(pData);
    double *data = DOUBLES(pData);

    interpolator->PositionInc[0] += data[0] * interpolator->Position[1];
    interpolator->Offset[1] += data[1];
    data[1] = 0;
    return 0;
}
