/* SPDX-License-Identifier: GPL-2.0-or-later */
/* thunks.h - what thunks.S and the C around it share. */
#ifndef HARNESS_MACHINE_THUNKS_H
#define HARNESS_MACHINE_THUNKS_H

#define MACHINE_SERVICES 32 /* that a machine can be given */
#define THUNK_BYTES      16

#endif
