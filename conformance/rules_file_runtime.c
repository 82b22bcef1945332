/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Libraries that were linked into the module although they count on an operating system. They are
 * told by the names of their functions, and in a stripped module by texts that they carry along:
 * those of allocators about broken heaps, those of start-up code about what it misses.
 */
#define _GNU_SOURCE /* memmem() */

#include <string.h>

#include "conformance/rules_file.h"

static const struct {
    const char *names; /* between spaces */
    const char *what;
} libraries[] = {
    { " malloc calloc realloc aligned_alloc memalign posix_memalign _int_malloc __libc_malloc "
      "_malloc_r _sbrk_r sbrk _sbrk brk __brk dlmalloc mspace_malloc je_malloc mi_malloc "
      "__malloc_hook _nl_C_locobj HeapAlloc RtlAllocateHeap _malloc_base _callnewh ",
      "an allocator" },
    { " _Znwm _Znam _Znwj _Znaj _ZnwmRKSt9nothrow_t ??2@YAPEAX_K@Z ??2@YAPAXI@Z ??_U@YAPEAX_K@Z ",
      "the allocator of C++" },
    { " fpc_getmem FPC_GETMEM fpc_reallocmem SYSTEM_$$_SYSGETMEM$QWORD$$POINTER "
      "SYSTEM_$$_SYSGETMEM$LONGWORD$$POINTER SYSTEM_$$_SYSOSALLOC$QWORD$$POINTER ",
      "the allocator of Free Pascal" },
    { " _start __libc_start_main __libc_start_call_main __libc_csu_init __libc_init_first "
      "__libc_setup_tls _dl_relocate_static_pie __libc_init_secure _init_first "
      "register_tm_clones deregister_tm_clones __do_global_dtors_aux frame_dummy "
      "__libc_init_array _mainCRTStartup mainCRTStartup WinMainCRTStartup _DllMainCRTStartup "
      "_DllMainCRTStartup@12 DllMainCRTStartup DllMainCRTStartup@12 __DllMainCRTStartup "
      "__tmainCRTStartup _CRT_INIT _CRT_INIT@12 __do_global_ctors __main ___main "
      "__security_init_cookie __scrt_initialize_crt dllmain_crt_process_attach "
      "FPC_SYSTEMMAIN SYSTEM_$$_INITIALIZEUNITS _FPC_shared_lib_start ",
      "start-up code" },
    { " __libc_exit_fini _exit __libc_fatal _Exit __assert_fail __stack_chk_fail "
      "__fortify_fail __chk_fail ",
      "code that ends a process" },
};

static const char *listed(const char *name)
{
    const size_t length = strlen(name);
    for (size_t i = 0; length > 0 && i < sizeof libraries / sizeof libraries[0]; i++)
        for (const char *at = libraries[i].names + 1; *at != '\0'; at += strcspn(at, " ") + 1)
            if (strcspn(at, " ") == length && memcmp(at, name, length) == 0)
                return libraries[i].what;
    return NULL;
}

const char *runtime_symbol(const char *name)
{
    const char *what = listed(name);
    return what == NULL && name[0] == '_' ? listed(name + 1) : what;
}

/* Texts that no controller program has a reason to carry. */
static const struct {
    const char *text, *what;
} traces[] = {
    { "malloc(): corrupted top size", "the allocator of the GNU C library" },
    { "free(): invalid pointer", "the allocator of the GNU C library" },
    { "*** %s ***: terminated", "the GNU C library" },
    { "stack smashing detected", "the GNU C library" },
    { "FATAL: kernel too old", "start-up code of the GNU C library" },
    { "GLIBC_TUNABLES", "start-up code of the GNU C library" },
    { "MALLOC_TOP_PAD_", "the allocator of the GNU C library" },
    { "Mingw-w64 runtime failure:", "start-up code of mingw-w64" },
    { "Microsoft Visual C++ Runtime Library", "Microsoft's C library" },
    { "<program name unknown>", "start-up code of Microsoft's C library" },
    { "An unhandled exception occurred at $", "the run-time library of Free Pascal" },
    { "Heap dump by heaptrc unit", "the run-time library of Free Pascal" },
    { "pure virtual method called", "the library of GNU C++" },
    { "terminate called ", "the library of GNU C++" },
    { "St9bad_alloc", "the library of GNU C++" },
};

static void look_for_traces(const struct case_file *file, struct findings *findings)
{
    const struct image *image = file->image;
    for (size_t i = 0; i < image->segment_count; i++) {
        const struct image_segment *segment = &image->segments[i];
        for (size_t k = 0; k < sizeof traces / sizeof traces[0]; k++) {
            const uint8_t *begin = image->bytes + segment->file_offset;
            const uint8_t *at =
                memmem(begin, segment->file_size, traces[k].text, strlen(traces[k].text));
            if (at != NULL)
                finding_place(finding_add(findings, "%s is in the module: it holds the text \"%s\"",
                                          traces[k].what, traces[k].text),
                              file, segment->vaddr + (uint64_t)(at - begin));
        }
    }
}

void check_no_runtime_library(const struct case_file *file, struct findings *findings)
{
    const struct image *image = file->image;
    if (file_unreadable(file, findings))
        return;
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        const char *what = symbol->executable ? runtime_symbol(symbol->name) : NULL;
        if (what != NULL && symbol->kind == IMAGE_SYMBOL_FUNC)
            finding_place(finding_add(findings, "%s is in the module: %s", symbol->name, what),
                          file, symbol->vaddr);
    }
    look_for_traces(file, findings);
}
