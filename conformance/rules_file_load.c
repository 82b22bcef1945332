/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What somebody would have to do before the module can be called: nothing but move it. */
#include <inttypes.h>
#include <string.h>

#include "conformance/rules_file.h"

/* ---- imports ---- */

/* What people want who import this, and what there is instead. */
static const struct {
    const char *names; /* between spaces */
    const char *instead;
} hints[] = {
    { " memcpy memmove memset memcmp ", "the SDK has it: link sdk/src/mem.c" },
    { " sin cos tan asin acos atan atan2 sinh cosh tanh sqrt pow exp log log10 floor ceil fmod "
      "round lround fabs hypot sinf cosf sqrtf atan2f powf fmodf ",
      "the SDK has it: MATH := yes and <tgm/math.h>" },
    { " malloc calloc realloc free _Znwm _Znam _ZdlPv _ZdlPvm _Znwj _Znaj HeapAlloc HeapFree "
      "VirtualAlloc ??2@YAPEAX_K@Z ??3@YAXPEAX@Z ",
      "a module allocates nothing: use static variables" },
    { " printf sprintf snprintf swprintf wprintf puts putchar fprintf OutputDebugStringA "
      "OutputDebugStringW ",
      "TG Motion prints with pRtWprintf_String, and pswprintf or the SDK's tgm_format make text" },
    { " __stack_chk_fail __stack_chk_guard __security_check_cookie __security_cookie ",
      "leave out the stack protector: -fno-stack-protector, /GS-" },
    { " __tls_get_addr _tls_index __emutls_get_address ",
      "there is no thread-local storage: use plain static variables" },
    { " __chkstk _chkstk ___chkstk_ms __chkstk_ms ",
      "the stack is small: make large local arrays static" },
    { " Sleep usleep nanosleep sleep ", "TG Motion sleeps with pSleepFt" },
    { " __aeabi_ldivmod __aeabi_uldivmod __divdi3 __udivdi3 __moddi3 __umoddi3 __aeabi_idiv "
      "__aeabi_uidiv __aeabi_idivmod __aeabi_uidivmod _alldiv _aulldiv __udivti3 __divti3 ",
      "the compiler's own library has it: link -lgcc" },
    { " __cxa_atexit __cxa_guard_acquire __cxa_guard_release __gxx_personality_v0 __cxa_throw "
      "_Unwind_Resume __cxa_pure_virtual __dso_handle ",
      "compile C++ as the SDK does: -fno-exceptions -fno-rtti -fno-threadsafe-statics "
      "-fno-use-cxa-atexit" },
};

/* The part of a PE import's name behind its library. */
static const char *bare(const char *name)
{
    const char *mark = strchr(name, '!');
    return mark != NULL ? mark + 1 : name;
}

static const char *hint(const char *name)
{
    const size_t length = strlen(bare(name));
    for (size_t i = 0; i < sizeof hints / sizeof hints[0]; i++)
        for (const char *at = hints[i].names + 1; *at != '\0'; at += strcspn(at, " ") + 1)
            if (strcspn(at, " ") == length && memcmp(at, bare(name), length) == 0)
                return hints[i].instead;
    return NULL;
}

static struct finding *import_finding(const struct image_import *import, struct findings *findings)
{
    const char *instead = hint(import->name), *colon = instead != NULL ? "; " : "";
    if (instead == NULL)
        instead = "";
    switch (import->kind) {
    case IMAGE_IMPORT_SYMBOL:
        if (strchr(import->name, '!') != NULL)
            return finding_add(findings, "%s is imported%s%s%s", import->name,
                               import->delayed ? " at its first call (delay import)" : "", colon,
                               instead);
        return finding_add(findings, "%s is not defined in the module%s%s", import->name, colon,
                           instead);
    case IMAGE_IMPORT_WEAK:
        return finding_add(findings,
                           "%s is weak and not defined in the module: it is a null pointer%s%s",
                           import->name, colon, instead);
    case IMAGE_IMPORT_LIBRARY:
        return finding_add(findings, "the module needs the library %s%s", import->name,
                           import->delayed ? ", loaded at the first call (delay import)" : "");
    case IMAGE_IMPORT_FILTER:
        break;
    }
    return finding_add(findings, "the module refers to the library %s as a filter", import->name);
}

void check_no_imports(const struct case_file *file, struct findings *findings)
{
    const struct image *image = file->image;
    if (file_unreadable(file, findings))
        return;
    const struct image_code *code = image->import_count > 0 ? image_code(image) : NULL;
    for (size_t i = 0; i < image->import_count; i++) {
        const struct image_import *import = &image->imports[i];
        /* A forwarded export is a matter of the rules for exports. */
        if (import->kind == IMAGE_IMPORT_FILTER && image->format == IMAGE_FORMAT_PE)
            continue;
        struct finding *finding = import_finding(import, findings);
        if (code->known && code->users[i].found)
            finding_place(finding, file, code->users[i].vaddr);
        else if (import->has_user)
            finding_place(finding, file, import->user);
    }
}

/* ---- code that would have to run first ---- */

static bool is_tls_callback(const struct image_initialiser *initialiser)
{
    return strcmp(initialiser->what, "TLS callback") == 0;
}

void check_no_initialisers(const struct case_file *file, struct findings *findings)
{
    const struct image *image = file->image;
    if (file_unreadable(file, findings))
        return;
    for (size_t i = 0; i < image->initialiser_count; i++) {
        const struct image_initialiser *initialiser = &image->initialisers[i];
        if (is_tls_callback(initialiser)) /* rule no-tls */
            continue;
        struct finding *finding =
            finding_add(findings, "%s entry %u would have to run around the module's life",
                        initialiser->what, initialiser->index);
        if (initialiser->vaddr != 0)
            finding_place(finding, file, initialiser->vaddr);
    }
}

/* GetProcAddress of a flat image is what the controller calls. */
void check_no_entry_point(const struct case_file *file, struct findings *findings)
{
    const struct image *image = file->image;
    if (file_unreadable(file, findings) || image->format == IMAGE_FORMAT_FLAT ||
        !image->has_entry_point)
        return;
    if (!image_code(image)->known) {
        finding_not_judged(findings, "the code of the entry point could not be read: no process "
                                     "could be made for it");
        return;
    }
    if (image_code(image)->entry_idle)
        return;
    finding_place(finding_add(findings,
                              "the entry point (DllMain or a library's start-up code) does "
                              "something, and nothing says that TG Motion calls it"),
                  file, image->entry_point);
}

void check_no_tls(const struct case_file *file, struct findings *findings)
{
    const struct image *image = file->image;
    if (file_unreadable(file, findings))
        return;
    bool named = false;
    for (size_t i = 0; i < image->initialiser_count; i++)
        if (is_tls_callback(&image->initialisers[i])) {
            finding_place(finding_add(findings,
                                      "TLS callback %u would have to run at every thread's start",
                                      image->initialisers[i].index),
                          file, image->initialisers[i].vaddr);
            named = true;
        }
    for (size_t i = 0; i < image->symbol_count; i++)
        if (image->symbols[i].kind == IMAGE_SYMBOL_TLS) {
            finding_add(findings, "%s is thread-local", image->symbols[i].name);
            named = true;
        }
    for (size_t i = 0; i < image->reloc_count && !named; i++)
        if (image->relocs[i].kind == IMAGE_RELOC_TLS)
            finding_place(finding_add(findings, "relocation %s asks for thread-local storage",
                                      image->relocs[i].type_name),
                          file, image->relocs[i].vaddr);
    if (image->has_tls && !named)
        finding_add(findings, "the module has %" PRIu64 " bytes of thread-local storage",
                    image->tls_size);
}

/* ---- relocations ---- */

/* What an import needs is the matter of no-imports, what TLS needs that of no-tls. */
static bool judged_elsewhere(const struct image *image, const struct image_reloc *reloc)
{
    if (reloc->kind == IMAGE_RELOC_TLS || reloc->type == IMAGE_RELOC_IAT)
        return true;
    for (size_t i = 0; i < image->import_count && reloc->symbol != NULL; i++)
        if (strcmp(image->imports[i].name, reloc->symbol) == 0)
            return true;
    return false;
}

void check_relative_relocations(const struct case_file *file, struct findings *findings)
{
    const struct image *image = file->image;
    if (file_unreadable(file, findings))
        return;
    if (image->format == IMAGE_FORMAT_PE && image->fixed)
        finding_add(findings,
                    "the file is stripped of its relocations: it runs at 0x%" PRIx64
                    " only, and TG Motion decides where a module lies",
                    image->base);
    for (size_t i = 0; i < image->reloc_count; i++) {
        const struct image_reloc *reloc = &image->relocs[i];
        if (reloc->kind == IMAGE_RELOC_RELATIVE || judged_elsewhere(image, reloc))
            continue;
        struct finding *finding = finding_add(findings, "relocation %s%s%s", reloc->type_name,
                                              reloc->symbol != NULL ? " for " : "",
                                              reloc->symbol != NULL ? reloc->symbol : "");
        const struct image_symbol *symbol =
            reloc->symbol != NULL ? image_export(image, reloc->symbol) : NULL;
        finding_place(finding, file, symbol != NULL ? symbol->vaddr : reloc->vaddr);
    }
}

/* Windows' format has code patched as a matter of course, where it is for i386. */
void check_no_text_relocations(const struct case_file *file, struct findings *findings)
{
    const struct image *image = file->image;
    if (file_unreadable(file, findings) || !file_is_elf(image))
        return;
    for (size_t i = 0; i < image->reloc_count; i++) {
        const struct image_reloc *reloc = &image->relocs[i];
        const struct image_segment *segment = image_segment_at(image, reloc->vaddr, 1);
        if (reloc->kind == IMAGE_RELOC_RELATIVE && segment != NULL &&
            (segment->perm & IMAGE_EXEC) != 0)
            finding_place(
                finding_add(findings, "relocation %s patches executable memory", reloc->type_name),
                file, reloc->vaddr);
    }
}
