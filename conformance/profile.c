/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/profile.h"

#include <stdio.h>
#include <string.h>

static const char *const six_exports[] = { "Program_Ini", "Program_01", "Program_02", "Program_03",
                                           "Program_04",  "Program_05", NULL };

static const char *const five_exports[] = { "Program_Ini", "Program_01", "Program_02",
                                            "Program_03",  "Program_04", NULL };

#define ELF64                                                                                      \
    {                                                                                              \
        IMAGE_FORMAT_ELF64, IMAGE_TARGET_X86_64, "an ELF64 x86-64 shared object"                   \
    }
#define ELF64_TEXT8                                                                                \
    {                                                                                              \
        IMAGE_FORMAT_ELF64, IMAGE_TARGET_X86_64,                                                   \
            "an ELF64 x86-64 shared object built with TGM_TEXT8"                                   \
    }
#define PE64                                                                                       \
    {                                                                                              \
        IMAGE_FORMAT_PE, IMAGE_TARGET_X86_64, "a PE32+ DLL for x86-64"                             \
    }
#define PE32                                                                                       \
    {                                                                                              \
        IMAGE_FORMAT_PE, IMAGE_TARGET_I386, "a PE32 DLL for i386"                                  \
    }
#define ELF32_ARM                                                                                  \
    {                                                                                              \
        IMAGE_FORMAT_ELF32, IMAGE_TARGET_ARM, "an ELF32 Arm shared object"                         \
    }
#define FLAT_ARM                                                                                   \
    {                                                                                              \
        IMAGE_FORMAT_FLAT, IMAGE_TARGET_ARM, "a flat Arm image (.bin)"                             \
    }

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

bool profile_loads(const struct profile *profile, const struct image *image)
{
    for (size_t i = 0; i < PROFILE_FORMATS; i++)
        if (profile->formats[i].format != IMAGE_FORMAT_NONE &&
            profile->formats[i].format == image->format &&
            profile->formats[i].target == image->target)
            return true;
    return false;
}

const struct profile *profile_of_image(const struct image *image)
{
    for (size_t i = 0; profile_at(i) != NULL; i++)
        if (profile_loads(profile_at(i), image))
            return profile_at(i);
    return NULL;
}

const char *profile_wanted(const struct profile *profile, char text[PROFILE_WANTED])
{
    size_t count = 0, at = 0;
    while (count < PROFILE_FORMATS && profile->formats[count].format != IMAGE_FORMAT_NONE)
        count++;
    text[0] = '\0';
    for (size_t i = 0; i < count && at < PROFILE_WANTED; i++)
        at += (size_t)snprintf(text + at, PROFILE_WANTED - at, "%s%s",
                               i == 0           ? ""
                               : i + 1 == count ? " or "
                                                : ", ",
                               profile->formats[i].title);
    return text;
}
