/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the module hands out: six functions, under their plain names. */
#include <string.h>

#include "conformance/rules_file.h"

static bool is_wanted(const struct profile *profile, const char *name)
{
    for (const char *const *wanted = profile->exports; *wanted != NULL; wanted++)
        if (strcmp(*wanted, name) == 0)
            return true;
    return profile->optional != NULL && strcmp(profile->optional, name) == 0;
}

static const char *how_many(const struct profile *profile)
{
    size_t count = 0;
    while (profile->exports[count] != NULL)
        count++;
    return count == 5 ? "five" : "six";
}

static const char *const style_texts[] = {
    [NAME_PLAIN] = "",
    [NAME_CASE] = "TG Motion looks names up with their case",
    [NAME_UNDERSCORE] =
        "TG Motion looks for the undecorated name, and the underscore is what 32-bit Windows puts "
        "before a cdecl function: name the export in a .def file",
    [NAME_STDCALL] = "TG Motion looks for the undecorated name, and @ with a number says __stdcall "
                     "or WINAPI: the functions are cdecl",
    [NAME_FASTCALL] = "TG Motion looks for the undecorated name, and the @ before it says "
                      "__fastcall: the functions are cdecl",
    [NAME_VECTORCALL] = "TG Motion looks for the undecorated name, and @@ with a number says "
                        "__vectorcall: the functions are cdecl",
    [NAME_CPP] = "TG Motion looks for the undecorated name, and this is how C++ writes it: declare "
                 "the function extern \"C\"",
    [NAME_PASCAL] = "TG Motion looks for the undecorated name, and this is how Free Pascal writes "
                    "it: export it under its plain name"
};

/* A symbol of the module that was probably meant to be `wanted`: exported ones first, then the one
 * whose name is spelled most like it. A compiler writes both its own name and the author's for one
 * function. */
static const struct image_symbol *near_miss(const struct image *image, const char *wanted,
                                            enum name_style *style)
{
    const struct image_symbol *best = NULL;
    enum name_style seen;
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        if (!name_is_meant(symbol->name, wanted, &seen))
            continue;
        if (best != NULL && (best->exported != symbol->exported ? best->exported : *style <= seen))
            continue;
        best = symbol;
        *style = seen;
    }
    return best;
}

static void export_missing(const struct case_file *file, const char *wanted,
                           struct findings *findings)
{
    enum name_style style = NAME_PLAIN;
    const struct image_symbol *near = near_miss(file->image, wanted, &style);
    struct finding *finding;
    if (near == NULL) {
        finding_add(findings,
                    "%s is missing: all %s functions must exist, even those that do nothing",
                    wanted, how_many(file->profile));
        return;
    }
    if (style == NAME_PLAIN)
        finding = finding_add(
            findings, "%s exists but is not exported: it must be visible outside the module",
            wanted);
    else
        finding = finding_add(findings, "%s is %s, %s is not there: %s", near->name,
                              near->exported ? "exported" : "defined", wanted, style_texts[style]);
    if (near->vaddr != 0) /* what is forwarded has no address here */
        finding_place(finding, file, near->vaddr);
}

/* What stands in for a missing one has been named with it. */
static bool stands_in(const struct case_file *file, const struct image_symbol *symbol)
{
    enum name_style style;
    for (const char *const *wanted = file->profile->exports; *wanted != NULL; wanted++)
        if (image_export(file->image, *wanted) == NULL &&
            near_miss(file->image, *wanted, &style) == symbol)
            return true;
    return false;
}

static void export_extra(const struct case_file *file, const struct image_symbol *symbol,
                         struct findings *findings)
{
    struct finding *finding = finding_add(
        findings, "%s is exported as well%s%s: a module exports the %s functions and nothing else",
        symbol->name, symbol->forwarder != NULL ? ", forwarded to " : "",
        symbol->forwarder != NULL ? symbol->forwarder : "", how_many(file->profile));
    if (symbol->forwarder == NULL)
        finding_place(finding, file, symbol->vaddr);
}

/* Only the SDK's flat images have a table of what GetProcAddress hands out. */
static bool names_nothing(const struct image *image)
{
    return image->format == IMAGE_FORMAT_FLAT && image->symbol_count == 0;
}

/* What one of the functions that GetProcAddress returned is not. */
static void judge_looked_up(const struct case_file *file, const char *name, uint32_t function,
                            struct findings *findings)
{
    const struct image_symbol *symbol = image_export(file->image, name);
    if (image_segment_at(file->image, function & ~1u, 1) == NULL)
        finding_add(findings, "GetProcAddress returns 0x%08x for %s, which is not in the image",
                    function, name);
    else if (symbol != NULL && (symbol->vaddr | symbol->thumb) != function)
        finding_place(finding_add(findings,
                                  "GetProcAddress returns 0x%08x for %s, the table TGM-EXPORTS-1 "
                                  "says 0x%08x",
                                  function, name, (unsigned)(symbol->vaddr | symbol->thumb)),
                      file, function & ~1u);
}

/* A flat image has no table of its exports: GetProcAddress returns one (decision C4). */
static void judge_lookup(const struct case_file *file, struct findings *findings)
{
    const struct evidence *evidence = case_loaded(file, EXPERIMENT_START, findings);
    if (evidence == NULL)
        return;
    const struct evidence_lookup *lookup = &evidence->lookup;
    if (!lookup->found) {
        struct finding *finding = finding_add(
            findings,
            "GetProcAddress hands out no table of the %s functions: it did not return, or "
            "0x%08x, where the image has none",
            how_many(file->profile), lookup->table);
        if (evidence->incident_count > 0)
            incident_place(&evidence->incidents[0], finding, file);
        return;
    }
    for (size_t i = 0; file->profile->exports[i] != NULL; i++)
        judge_looked_up(file, file->profile->exports[i], lookup->functions[i], findings);
}

void check_export_names(const struct case_file *file, struct findings *findings)
{
    const struct image *image = file->image;
    if (file_unreadable(file, findings))
        return;
    if (image->format == IMAGE_FORMAT_FLAT)
        judge_lookup(file, findings);
    if (names_nothing(image))
        return;
    for (const char *const *wanted = file->profile->exports; *wanted != NULL; wanted++)
        if (image_export(image, *wanted) == NULL)
            export_missing(file, *wanted, findings);
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        if (symbol->exported && !is_wanted(file->profile, symbol->name) && !stands_in(file, symbol))
            export_extra(file, symbol, findings);
    }
}

static void judge_export(const struct case_file *file, const struct image_symbol *symbol,
                         struct findings *findings)
{
    const struct image_segment *segment = image_segment_at(file->image, symbol->vaddr, 1);
    if (symbol->forwarder != NULL)
        finding_add(findings, "%s is forwarded to %s: TG Motion loads no other file for a module",
                    symbol->name, symbol->forwarder);
    else if (symbol->kind == IMAGE_SYMBOL_IFUNC)
        finding_place(finding_add(findings,
                                  "%s is an indirect function: its address would have to be "
                                  "computed at load",
                                  symbol->name),
                      file, symbol->vaddr);
    else if (symbol->kind == IMAGE_SYMBOL_TLS)
        finding_add(findings, "%s is exported but is a thread-local variable", symbol->name);
    else if (segment == NULL)
        finding_add(findings, "%s is exported but lies nowhere in the module", symbol->name);
    else if (!symbol->executable)
        finding_place(
            finding_add(findings, "%s is exported but is not in executable memory", symbol->name),
            file, symbol->vaddr);
    else if (symbol->kind == IMAGE_SYMBOL_OBJECT)
        finding_place(finding_add(findings, "%s is exported but is declared as data", symbol->name),
                      file, symbol->vaddr);
}

void check_export_code(const struct case_file *file, struct findings *findings)
{
    const struct profile *profile = file->profile;
    if (file_unreadable(file, findings))
        return;
    for (size_t i = 0; i < file->image->symbol_count; i++)
        if (file->image->symbols[i].exported && is_wanted(profile, file->image->symbols[i].name))
            judge_export(file, &file->image->symbols[i], findings);
}
