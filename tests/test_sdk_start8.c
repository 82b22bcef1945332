/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The start checks in generation 5 where text is bytes: TGMmini, TGMcontroller, TGZ+Motion. */
#define TGM_GENERATION 5
#define TGM_TEXT8
#include "test_sdk_start.c"
