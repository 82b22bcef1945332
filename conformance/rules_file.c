/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Rules that the file alone decides. */
#include "conformance/rules_file.h"

/* A file that is no module has no exports or segments to judge. */
bool file_unreadable(const struct case_file *file, struct findings *findings)
{
    if (file->image->defect[0] == '\0' && profile_loads(file->profile, file->image))
        return false;
    finding_not_judged(findings,
                       "the file is not a module that this profile loads (rule file-format)");
    return true;
}

bool file_is_elf(const struct image *image)
{
    return image->format == IMAGE_FORMAT_ELF64 || image->format == IMAGE_FORMAT_ELF32;
}

void check_file_format(const struct case_file *file, struct findings *findings)
{
    const struct image *image = file->image;
    char wanted[PROFILE_WANTED];
    if (image->defect[0] != '\0')
        finding_add(findings, "%s", image->defect);
    else if (!profile_loads(file->profile, image))
        finding_add(findings, "%s %s; the profile %s loads %s", image->format_name,
                    image->target_name, file->profile->name, profile_wanted(file->profile, wanted));
}
