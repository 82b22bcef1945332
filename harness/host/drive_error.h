/* SPDX-License-Identifier: GPL-2.0-or-later */
/* drive_error.h - error codes of CiA 402 drives (0x603F) as bits of SERVO.Error (M13). */
#ifndef HARNESS_HOST_DRIVE_ERROR_H
#define HARNESS_HOST_DRIVE_ERROR_H

#include <stdint.h>

#define DRIVE_ERROR_OTHER UINT32_C(0x80000000)

/* The bit of the fault; DRIVE_ERROR_OTHER when the documented bits have none for it. */
uint32_t drive_error_bit(uint16_t code);

#endif
