/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The start checks in generation 5 on a PC. */
#define TGM_GENERATION 5
#include "test_sdk_start.c"
