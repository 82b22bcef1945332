/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * inspect_text.c - a module for people: one line a fact, a list below it where there is one.
 */
#include <inttypes.h>
#include <string.h>

#include "cli/inspect.h"

#define LABEL      "  %-14s"
#define INDENT     "                "
#define TYPES_MAX  64
#define NAME_WIDTH 11 /* of Program_Ini */

/* Names are the file's own bytes: nothing in them may steer a terminal. */
static int put_name(FILE *out, const char *name)
{
    int width = 0;
    for (const unsigned char *c = (const unsigned char *)name; *c != '\0'; c++) {
        bool plain = *c >= 0x20 && *c <= 0x7e && *c != '\\';
        if (plain)
            fputc(*c, out);
        else
            fprintf(out, "\\x%02x", *c);
        width += plain ? 1 : 4;
    }
    return width;
}

static void put_path(FILE *out, const char *path)
{
    const char *slash = strrchr(path, '/');
    const char *base = slash != NULL && slash[1] != '\0' ? slash + 1 : path;
    for (const unsigned char *c = (const unsigned char *)base; *c != '\0'; c++) {
        if (*c < 0x20 || *c == 0x7f)
            fprintf(out, "\\x%02x", *c);
        else
            fputc(*c, out);
    }
}

static void put_size(FILE *out, uint64_t size)
{
    if (size < 10240)
        fprintf(out, "%" PRIu64 " bytes", size);
    else
        fprintf(out, "%.1f KiB", (double)size / 1024);
}

static void head(const struct image *image, FILE *out)
{
    put_path(out, image->path);
    if (image->format_name[0] != '\0')
        fprintf(out, "  %s %s", image->format_name, image->target_name);
    fputs("  ", out);
    put_size(out, image->size);
    fprintf(out, "\n" LABEL "%s\n", "sha256", image->sha256);
}

static void put_place(FILE *out, const struct image *image, uint64_t vaddr, bool with_function)
{
    struct image_place place;
    image_where(image, vaddr, &place);
    if (with_function && place.function != NULL) {
        fputs("  ", out);
        put_name(out, place.function);
        if (place.offset != 0)
            fprintf(out, "+0x%" PRIx64, place.offset);
    }
    if (place.file != NULL) {
        fputs("  ", out);
        put_name(out, place.file);
        fprintf(out, ":%d", place.line);
    }
}

static void export_line(const struct image *image, const struct image_symbol *symbol, FILE *out)
{
    const uint64_t size = inspect_size(image, symbol);
    if (symbol->forwarder != NULL)
        fprintf(out, INDENT "%-10s  %8s  %-17s ", "", "", inspect_symbol_kind(symbol));
    else if (size != 0)
        fprintf(out, INDENT "0x%08" PRIx64 "  %8" PRIu64 "  %-17s ", symbol->vaddr, size,
                inspect_symbol_kind(symbol));
    else
        fprintf(out, INDENT "0x%08" PRIx64 "  %8s  %-17s ", symbol->vaddr, "?",
                inspect_symbol_kind(symbol));
    int width = put_name(out, symbol->name);
    if (symbol->forwarder != NULL) {
        fputs(" -> ", out);
        put_name(out, symbol->forwarder);
    }
    if (symbol->executable && image->has_debug_lines) {
        fprintf(out, "%*s", width < NAME_WIDTH ? NAME_WIDTH - width : 0, "");
        put_place(out, image, symbol->vaddr, false);
    }
    fputc('\n', out);
}

static void exports(const struct image *image, FILE *out)
{
    size_t count = 0;
    for (size_t i = 0; i < image->symbol_count; i++)
        count += image->symbols[i].exported;
    if (image->format == IMAGE_FORMAT_FLAT && count == 0) {
        fprintf(out, LABEL "not known: this flat image has no table of them\n", "exports");
        return;
    }
    fprintf(out, count == 0 ? LABEL "none\n" : LABEL "%zu\n", "exports", count);
    for (size_t i = 0; i < image->symbol_count; i++)
        if (image->symbols[i].exported)
            export_line(image, &image->symbols[i], out);
}

static void imports(const struct image *image, FILE *out)
{
    fprintf(out, image->import_count == 0 ? LABEL "none\n" : LABEL "%zu\n", "imports",
            image->import_count);
    for (size_t i = 0; i < image->import_count; i++) {
        fprintf(out, INDENT "%-15s ", inspect_import_kind(&image->imports[i]));
        put_name(out, image->imports[i].name);
        if (image->imports[i].has_user)
            put_place(out, image, image->imports[i].user, true);
        fputc('\n', out);
    }
}

static void initialisers(const struct image *image, FILE *out)
{
    if (image->has_entry_point) {
        fprintf(out, LABEL "0x%08" PRIx64, "entry point", image->entry_point);
        put_place(out, image, image->entry_point, true);
        fputc('\n', out);
    } else {
        fprintf(out, LABEL "none\n", "entry point");
    }
    fprintf(out, image->initialiser_count == 0 ? LABEL "none\n" : LABEL "%zu\n", "initialisers",
            image->initialiser_count);
    for (size_t i = 0; i < image->initialiser_count; i++) {
        const struct image_initialiser *initialiser = &image->initialisers[i];
        fprintf(out, INDENT "%-17s %3u  ", initialiser->what, initialiser->index);
        if (initialiser->vaddr != 0)
            fprintf(out, "0x%08" PRIx64, initialiser->vaddr);
        else
            fputs("unknown", out);
        put_place(out, image, initialiser->vaddr, true);
        fputc('\n', out);
    }
    if (image->has_tls)
        fprintf(out, LABEL "%" PRIu64 " bytes\n", "thread-local", image->tls_size);
    else
        fprintf(out, LABEL "none\n", "thread-local");
}

static void load_address(const struct image *image, FILE *out)
{
    uint64_t linked = image->base + (image->fixed ? image->span_begin : 0);
    if (image->fixed)
        fprintf(out, LABEL "0x%08" PRIx64 " only\n", "load address", linked);
    else if (image->base != 0)
        fprintf(out, LABEL "any, linked for 0x%08" PRIx64 "\n", "load address", linked);
    else
        fprintf(out, LABEL "any\n", "load address");
}

static void memory(const struct image *image, FILE *out)
{
    fprintf(out, LABEL "", "memory");
    put_size(out, image->span_end - image->span_begin);
    fprintf(out, " in %zu segment%s\n", image->segment_count, image->segment_count == 1 ? "" : "s");
    for (size_t i = 0; i < image->segment_count; i++) {
        const struct image_segment *segment = &image->segments[i];
        fprintf(out, INDENT "0x%08" PRIx64 "  %8" PRIu64 "  %s", segment->vaddr, segment->mem_size,
                inspect_permissions(segment->perm));
        if (segment->file_size < segment->mem_size)
            fprintf(out, "  %" PRIu64 " of them zero", segment->mem_size - segment->file_size);
        fputc('\n', out);
    }
    if (image->relro_begin != image->relro_end)
        fprintf(out, INDENT "0x%08" PRIx64 "  %8" PRIu64 "  read-only after relocation\n",
                image->relro_begin, image->relro_end - image->relro_begin);
}

static void relocations(const struct image *image, FILE *out)
{
    struct inspect_relocs types[TYPES_MAX];
    size_t count = inspect_count_relocs(image, types, TYPES_MAX);
    fprintf(out, count == 0 ? LABEL "none\n" : LABEL "%zu\n", "relocations", image->reloc_count);
    for (size_t i = 0; i < count; i++)
        fprintf(out, INDENT "%8zu  %-25s %s\n", types[i].count, types[i].type_name,
                inspect_reloc_kind(types[i].kind));
}

static void routine_line(const struct image *image, const struct image_routine *routine,
                         const char *name, FILE *out)
{
    if (routine == NULL)
        return;
    const bool bounded = routine->limit == IMAGE_STACK_BOUNDED;
    fprintf(out, INDENT "%8" PRIu64 "  %-10s  ", routine->stack,
            !bounded           ? "and more"
            : routine->outside ? "+ services"
                               : "");
    int width = put_name(out, name);
    if (!bounded) {
        fprintf(out, "%*s  %s:", width < NAME_WIDTH ? NAME_WIDTH - width : 0, "",
                inspect_limit(routine->limit));
        put_place(out, image, routine->where, true);
    }
    fputc('\n', out);
}

static bool calls_services(const struct image *image)
{
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        const struct image_routine *routine =
            symbol->exported && symbol->executable ? image_routine(image, symbol->vaddr) : NULL;
        if (routine != NULL && routine->outside)
            return true;
    }
    return false;
}

static void stack(const struct image *image, FILE *out)
{
    const char *executable = image->exec_stack ? ", executable" : "";
    const char *name;
    const struct image_routine *deepest = inspect_deepest(image, &name);
    if (deepest == NULL || deepest->limit == IMAGE_STACK_UNKNOWN) {
        fprintf(out, LABEL "not known: %s%s\n", "stack",
                deepest == NULL ? "no exported code" : inspect_limit(IMAGE_STACK_UNKNOWN),
                executable);
        return;
    }
    fprintf(out, LABEL "at %s %" PRIu64 " bytes of the module's own%s%s\n", "stack",
            deepest->limit == IMAGE_STACK_BOUNDED ? "most" : "least", deepest->stack,
            calls_services(image) ? "; services of TG Motion add theirs" : "", executable);
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        if (symbol->exported && symbol->executable)
            routine_line(image, image_routine(image, symbol->vaddr), symbol->name, out);
    }
    if (image->has_entry_point)
        routine_line(image, image_routine(image, image->entry_point), "entry point", out);
}

void inspect_text(const struct image *image, FILE *out)
{
    head(image, out);
    if (image->defect[0] != '\0') {
        fprintf(out, LABEL "%s\n", "no module", image->defect);
        return;
    }
    exports(image, out);
    imports(image, out);
    initialisers(image, out);
    load_address(image, out);
    memory(image, out);
    relocations(image, out);
    stack(image, out);
    fprintf(out, LABEL "%s", "source lines", image->has_debug_lines ? "yes" : "none");
    if (!image->has_debug_lines && image->debug_file != NULL) {
        fputs("; they are in ", out);
        put_name(out, image->debug_file);
        fputs(", which is not read", out);
    }
    fputc('\n', out);
}
