/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/profile.h"

#include <string.h>

static const char *const six_exports[] = { "Program_Ini", "Program_01", "Program_02", "Program_03",
                                           "Program_04",  "Program_05", NULL };

static const char *const five_exports[] = { "Program_Ini", "Program_01", "Program_02",
                                            "Program_03",  "Program_04", NULL };

/* The manual gives the controllers' modules 8 MiB at a fixed address, and no figure elsewhere, nor
 * one for the stack: those are ours (docs/decisions.md, H18). */
#define REGION_CONTROLLER IMAGE_FLAT_REGION
#define REGION_OPEN       (64u << 20)
#define STACK_ALL         (64u << 10)

static const struct profile profiles[] = {
#define PROFILE(...) { __VA_ARGS__ },
#include "conformance/profiles/pc4.def"
#include "conformance/profiles/pc500.def"
#include "conformance/profiles/pc5.def"
#include "conformance/profiles/tgmmini.def"
#include "conformance/profiles/tgmcontroller.def"
#include "conformance/profiles/tgzmotion.def"
#undef PROFILE
};

const struct profile *profile_at(size_t index)
{
    return index < sizeof profiles / sizeof *profiles ? &profiles[index] : NULL;
}

const struct profile *profile_find(const char *name)
{
    for (size_t i = 0; profile_at(i) != NULL; i++)
        if (strcmp(profiles[i].name, name) == 0)
            return &profiles[i];
    return NULL;
}
