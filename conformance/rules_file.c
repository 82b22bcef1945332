/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Rules that the file alone decides. */
#include <ctype.h>
#include <inttypes.h>
#include <string.h>
#include <strings.h>

#include "conformance/rules.h"

/* A file that is no module has no exports or segments to judge. */
static bool unreadable(const struct case_file *file, struct findings *findings)
{
    if (file->image->defect[0] == '\0' && profile_loads(file->profile, file->image))
        return false;
    finding_not_judged(findings,
                       "the file is not a module that this profile loads (rule file-format)");
    return true;
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

static bool is_wanted(const struct profile *profile, const char *name)
{
    for (const char *const *wanted = profile->exports; *wanted != NULL; wanted++)
        if (strcmp(*wanted, name) == 0)
            return true;
    return profile->optional != NULL && strcmp(profile->optional, name) == 0;
}

/* The wanted name that a name comes close to: other letter case, a leading underscore, an @suffix.
 */
static const char *meant(const struct profile *profile, const char *name)
{
    while (*name == '_')
        name++;
    const size_t length = strcspn(name, "@");
    for (const char *const *wanted = profile->exports; *wanted != NULL; wanted++)
        if (strlen(*wanted) == length && strncasecmp(*wanted, name, length) == 0)
            return *wanted;
    return NULL;
}

static const char *how_many(const struct profile *profile)
{
    size_t count = 0;
    while (profile->exports[count] != NULL)
        count++;
    return count == 5 ? "five" : "six";
}

/* A symbol of the module that was probably meant to be `wanted`. */
static const struct image_symbol *near_miss(const struct case_file *file, const char *wanted)
{
    for (size_t i = 0; i < file->image->symbol_count; i++) {
        const char *close = meant(file->profile, file->image->symbols[i].name);
        if (close != NULL && strcmp(close, wanted) == 0)
            return &file->image->symbols[i];
    }
    return NULL;
}

static void export_missing(const struct case_file *file, const char *wanted,
                           struct findings *findings)
{
    const struct image_symbol *near = near_miss(file, wanted);
    if (near == NULL) {
        finding_add(findings,
                    "%s is missing: all %s functions must exist, even those that do nothing",
                    wanted, how_many(file->profile));
        return;
    }
    struct finding *finding;
    if (strcmp(near->name, wanted) == 0)
        finding = finding_add(
            findings, "%s exists but is not exported: it must be visible outside the module",
            wanted);
    else if (strcasecmp(near->name, wanted) == 0)
        finding = finding_add(findings,
                              "%s is %s, %s is not there: TG Motion looks names up with their case",
                              near->name, near->exported ? "exported" : "defined", wanted);
    else
        finding = finding_add(findings,
                              "%s is %s, %s is not there: TG Motion looks for the undecorated name",
                              near->name, near->exported ? "exported" : "defined", wanted);
    finding_place(finding, file, near->vaddr);
}

void check_export_names(const struct case_file *file, struct findings *findings)
{
    if (unreadable(file, findings))
        return;
    for (const char *const *wanted = file->profile->exports; *wanted != NULL; wanted++)
        if (image_export(file->image, *wanted) == NULL)
            export_missing(file, *wanted, findings);
    for (size_t i = 0; i < file->image->symbol_count; i++) {
        const struct image_symbol *symbol = &file->image->symbols[i];
        if (!symbol->exported || is_wanted(file->profile, symbol->name) ||
            meant(file->profile, symbol->name) != NULL)
            continue;
        finding_place(
            finding_add(
                findings,
                "%s is exported as well: a module exports the %s functions and nothing else",
                symbol->name, how_many(file->profile)),
            file, symbol->vaddr);
    }
}

void check_export_code(const struct case_file *file, struct findings *findings)
{
    if (unreadable(file, findings))
        return;
    for (const char *const *wanted = file->profile->exports; *wanted != NULL; wanted++) {
        const struct image_symbol *symbol = image_export(file->image, *wanted);
        if (symbol == NULL)
            continue;
        if (symbol->kind == IMAGE_SYMBOL_IFUNC)
            finding_place(
                finding_add(
                    findings,
                    "%s is an indirect function: its address would have to be computed at load",
                    *wanted),
                file, symbol->vaddr);
        else if (!symbol->executable || symbol->kind == IMAGE_SYMBOL_OBJECT ||
                 symbol->kind == IMAGE_SYMBOL_TLS)
            finding_place(
                finding_add(findings, "%s is exported but is %s", *wanted,
                            symbol->executable ? "declared as data" : "not in executable memory"),
                file, symbol->vaddr);
    }
}

void check_no_imports(const struct case_file *file, struct findings *findings)
{
    if (unreadable(file, findings))
        return;
    for (size_t i = 0; i < file->image->import_count; i++) {
        const struct image_import *import = &file->image->imports[i];
        struct finding *finding = NULL;
        switch (import->kind) {
        case IMAGE_IMPORT_SYMBOL:
            finding = finding_add(findings, "%s is not defined in the module", import->name);
            break;
        case IMAGE_IMPORT_WEAK:
            finding = finding_add(findings,
                                  "%s is weak and not defined in the module: it is a null pointer",
                                  import->name);
            break;
        case IMAGE_IMPORT_LIBRARY:
            finding = finding_add(findings, "the module needs the library %s", import->name);
            break;
        case IMAGE_IMPORT_FILTER:
            finding = finding_add(findings, "the module refers to the library %s as a filter",
                                  import->name);
            break;
        }
        if (import->has_user)
            finding_place(finding, file, import->user);
    }
}

void check_no_initialisers(const struct case_file *file, struct findings *findings)
{
    if (unreadable(file, findings))
        return;
    for (size_t i = 0; i < file->image->initialiser_count; i++) {
        const struct image_initialiser *initialiser = &file->image->initialisers[i];
        struct finding *finding =
            finding_add(findings, "%s entry %u would have to run around the module's life",
                        initialiser->what, initialiser->index);
        if (initialiser->vaddr != 0)
            finding_place(finding, file, initialiser->vaddr);
    }
}

void check_no_tls(const struct case_file *file, struct findings *findings)
{
    if (unreadable(file, findings))
        return;
    bool named = false;
    for (size_t i = 0; i < file->image->symbol_count; i++)
        if (file->image->symbols[i].kind == IMAGE_SYMBOL_TLS) {
            finding_add(findings, "%s is thread-local", file->image->symbols[i].name);
            named = true;
        }
    for (size_t i = 0; i < file->image->reloc_count && !named; i++)
        if (file->image->relocs[i].kind == IMAGE_RELOC_TLS)
            finding_add(findings, "relocation %s asks for thread-local storage",
                        file->image->relocs[i].type_name);
    if (file->image->has_tls && !named)
        finding_add(findings, "the module has %" PRIu64 " bytes of thread-local storage",
                    file->image->tls_size);
}

/* What an import needs is the matter of no-imports, what TLS needs that of no-tls. */
static bool judged_elsewhere(const struct image *image, const struct image_reloc *reloc)
{
    if (reloc->kind == IMAGE_RELOC_TLS)
        return true;
    for (size_t i = 0; i < image->import_count && reloc->symbol != NULL; i++)
        if (strcmp(image->imports[i].name, reloc->symbol) == 0)
            return true;
    return false;
}

void check_relative_relocations(const struct case_file *file, struct findings *findings)
{
    if (unreadable(file, findings))
        return;
    for (size_t i = 0; i < file->image->reloc_count; i++) {
        const struct image_reloc *reloc = &file->image->relocs[i];
        if (reloc->kind == IMAGE_RELOC_RELATIVE || judged_elsewhere(file->image, reloc))
            continue;
        struct finding *finding = finding_add(findings, "relocation %s%s%s", reloc->type_name,
                                              reloc->symbol != NULL ? " for " : "",
                                              reloc->symbol != NULL ? reloc->symbol : "");
        const struct image_symbol *symbol =
            reloc->symbol != NULL ? image_export(file->image, reloc->symbol) : NULL;
        finding_place(finding, file, symbol != NULL ? symbol->vaddr : reloc->vaddr);
    }
}

void check_no_writable_code(const struct case_file *file, struct findings *findings)
{
    if (unreadable(file, findings))
        return;
    for (size_t i = 0; i < file->image->segment_count; i++) {
        const struct image_segment *segment = &file->image->segments[i];
        if ((segment->perm & IMAGE_WRITE) != 0 && (segment->perm & IMAGE_EXEC) != 0)
            finding_add(findings,
                        "segment %zu (0x%" PRIx64 ", %" PRIu64 " bytes) is writable and executable",
                        i, segment->vaddr, segment->mem_size);
    }
}

void check_no_executable_stack(const struct case_file *file, struct findings *findings)
{
    if (unreadable(file, findings))
        return;
    if (file->image->exec_stack)
        finding_add(
            findings,
            file->image->exec_stack_stated
                ? "the file asks for an executable stack (PT_GNU_STACK has the execute flag)"
                : "the file does not rule out an executable stack (it has no PT_GNU_STACK)");
}
