/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/interp_filter.h"

#include <math.h>
#include <string.h>

void interp_spline_set(struct interp_spline *spline, unsigned points,
                       const double position[INTERP_AXES])
{
    spline->points = points;
    spline->next = 0;
    spline->stood = points;
    for (unsigned axis = 0; axis < INTERP_AXES; axis++) {
        spline->reference[axis] = position[axis];
        spline->sum[axis] = 0;
        for (unsigned i = 0; i < points; i++)
            spline->ring[axis][i] = position[axis];
    }
}

static void take_reference(struct interp_spline *spline, unsigned axis, double reference)
{
    spline->reference[axis] = reference;
    spline->sum[axis] = 0;
    for (unsigned i = 0; i < spline->points; i++)
        spline->sum[axis] += spline->ring[axis][i] - reference;
}

void interp_spline_step(struct interp_spline *spline, double position[INTERP_AXES])
{
    if (spline->points == 0)
        return;
    const unsigned last = (spline->next > 0 ? spline->next : spline->points) - 1;
    bool stands = true;
    for (unsigned axis = 0; axis < INTERP_AXES; axis++) {
        double *oldest = &spline->ring[axis][spline->next];
        const double reference = spline->reference[axis], now = position[axis];
        stands = stands && now == spline->ring[axis][last];
        spline->sum[axis] += (now - reference) - (*oldest - reference);
        *oldest = now;
        if (spline->next == 0)
            take_reference(spline, axis, now);
        position[axis] = spline->reference[axis] + spline->sum[axis] / spline->points;
    }
    spline->stood = stands ? spline->stood + (spline->stood < spline->points) : 0;
    if (spline->stood + 1 >= spline->points) /* all points are the same */
        for (unsigned axis = 0; axis < INTERP_AXES; axis++)
            position[axis] = spline->ring[axis][spline->next];
    spline->next = spline->next + 1 < spline->points ? spline->next + 1 : 0;
}

static void multiply(double out[2][2], double a[2][2], double b[2][2])
{
    double product[2][2];
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++)
            product[i][k] = a[i][0] * b[0][k] + a[i][1] * b[1][k];
    memcpy(out, product, sizeof product);
}

/* The exponential of a matrix: its series for a part of it, squared up again. */
static void exponential(double out[2][2], double matrix[2][2])
{
    double size = 0, term[2][2] = { { 1, 0 }, { 0, 1 } }, small[2][2];
    unsigned squares = 0;
    for (int i = 0; i < 4; i++)
        size = fmax(size, fabs(matrix[i / 2][i % 2]));
    for (double part = size; part > 0.25; part /= 2)
        squares++;
    memcpy(small, matrix, sizeof small);
    for (unsigned n = 0; n < squares; n++)
        for (int i = 0; i < 4; i++)
            small[i / 2][i % 2] /= 2;
    memcpy(out, term, sizeof term);
    for (int n = 1; n <= 16; n++) {
        multiply(term, term, small);
        for (int i = 0; i < 4; i++) {
            term[i / 2][i % 2] /= n;
            out[i / 2][i % 2] += term[i / 2][i % 2];
        }
    }
    while (squares-- > 0)
        multiply(out, out, out);
}

void interp_iir_place(struct interp_iir *iir, const double position[INTERP_AXES])
{
    memset(iir->distance, 0, sizeof iir->distance);
    memset(iir->rate, 0, sizeof iir->rate);
    memcpy(iir->input, position, sizeof iir->input);
}

bool interp_iir_set(struct interp_iir *iir, double p, double q, double f, uint32_t axes,
                    double step, const double position[INTERP_AXES])
{
    if (axes != 0) {
        if (!(p > 0 && q > 0 && f > 0))
            return false;
        /* The state is the distance and f times its rate. */
        double matrix[2][2] = { { 0, step / f }, { -q * step / f, -p * step / f } };
        exponential(iir->transition, matrix);
    }
    iir->axes = axes & ((1u << INTERP_AXES) - 1);
    interp_iir_place(iir, position);
    return true;
}

void interp_iir_step(struct interp_iir *iir, double position[INTERP_AXES])
{
    for (unsigned axis = 0; axis < INTERP_AXES; axis++) {
        if ((iir->axes & 1u << axis) == 0)
            continue;
        const double distance = iir->distance[axis] + (iir->input[axis] - position[axis]);
        const double rate = iir->rate[axis];
        iir->distance[axis] = iir->transition[0][0] * distance + iir->transition[0][1] * rate;
        iir->rate[axis] = iir->transition[1][0] * distance + iir->transition[1][1] * rate;
        /* Far below what a position can show: no numbers that slow the processor down. */
        if (fabs(iir->distance[axis]) < 1e-200 && fabs(iir->rate[axis]) < 1e-200)
            iir->distance[axis] = iir->rate[axis] = 0;
        iir->input[axis] = position[axis];
        position[axis] += iir->distance[axis];
    }
}
