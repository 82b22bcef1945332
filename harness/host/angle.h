/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * angle.h - angles in half turns (1 is 180 degrees): sine, cosine and the angle of a direction.
 *
 * Only + - * / sqrt of doubles and our own sine: the same to the last bit on every machine. Half
 * turns, because whole ones are then taken out without rounding.
 */
#ifndef HARNESS_HOST_ANGLE_H
#define HARNESS_HOST_ANGLE_H

#define ANGLE_PI 3.14159265358979323846

/* Of any angle, within 4e-16; a quarter turn gives 0 and 1 to within as much. */
double angle_sine(double h);
double angle_cosine(double h);

/* -1 < it <= 1, counted from x towards y, within 3e-16; 0 where there is no direction. */
double angle_of(double x, double y);

#endif
