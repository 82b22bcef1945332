/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image.h - a module as data: bytes in, one bounds-checked description out.
 *
 * image_open() is the only place in the harness that parses module files. It reads the file once;
 * what is hashed is what is later mapped and run. Everything in `struct image` has been checked
 * against the size of the file: a reader of the struct never needs to check again. A file that is
 * readable but is no module is not an error of the call: the image says so in `defect` and has no
 * contents, and the rules report it.
 *
 * Formats: ELF64 for x86-64, ELF32 for Arm (little-endian shared objects), PE32 for i386 and PE32+
 * for x86-64 (DLLs), and the flat Arm image of TGMcontroller and TGZ+Motion. A flat image has no
 * header: it is told by its name (.bin) and by its beginning, and what it exports is not known. The
 * vendor's stamped form of it (.tgm_controller, .tgz_motion) is refused: the stamp is documented
 * nowhere.
 *
 * Nothing here is guessed from tables that a loader would not read: segments, exports, imports,
 * relocations and initialisers come from an ELF file's program headers and dynamic table, and from
 * a PE file's section table and data directories. Only names of local symbols, undefined symbols
 * that the linker resolved to null, .ctors and debug information come from an ELF file's sections
 * or a PE file's COFF symbols; they are there when the module was not stripped.
 *
 * Limits, beyond which a file is defective: 256 MiB of memory, 2^18 symbols, 2^18 imports, 2^20
 * relocations, 2^16 initialisers, names of 1024 bytes. Anything that two readers could understand
 * differently is a defect, too: overlapping segments or relocations, a name exported twice or not
 * found through the hash table or by halves, a dynamic tag stated twice, a PE directory with a size
 * and no place.
 *
 * Addresses (vaddr) are virtual addresses inside the module, as the file states them (usually from
 * 0). In memory an address is load address + vaddr. PE: vaddr is the relative virtual address
 * (RVA); where the file itself states addresses that count on its ImageBase, that has been taken
 * off.
 *
 * All strings and arrays are owned by the image and live until image_close(). Names are the file's
 * own bytes up to a zero byte: escape them before they reach a terminal, a page or a report.
 */
#ifndef HARNESS_IMAGE_H
#define HARNESS_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define IMAGE_WHY 512

/* Where a flat image has to lie, and how much memory there is for it (manual: TGMcontroller, PLC
 * project). What the file does not fill is the module's memory, too, with unknown contents. */
#define IMAGE_FLAT_BASE   0x07800000u
#define IMAGE_FLAT_REGION 0x00800000u

enum image_format {
    IMAGE_FORMAT_NONE,
    IMAGE_FORMAT_ELF64,
    IMAGE_FORMAT_ELF32,
    IMAGE_FORMAT_PE, /* PE32 on i386, PE32+ on x86-64 */
    IMAGE_FORMAT_FLAT
};
enum image_target { IMAGE_TARGET_NONE, IMAGE_TARGET_X86_64, IMAGE_TARGET_I386, IMAGE_TARGET_ARM };

enum { IMAGE_READ = 1, IMAGE_WRITE = 2, IMAGE_EXEC = 4 };

/* One range of the module that is mapped into memory. */
struct image_segment {
    uint64_t vaddr;       /* first address, as in the file: not necessarily page aligned */
    uint64_t mem_size;    /* bytes in memory; bytes past file_size start as zero */
    uint64_t file_size;   /* bytes taken from the file, <= mem_size */
    uint64_t file_offset; /* where they are; file_offset + file_size <= image.size */
    unsigned perm;        /* IMAGE_READ | IMAGE_WRITE | IMAGE_EXEC */
};

enum image_symbol_kind {
    IMAGE_SYMBOL_NONE, /* no type stated */
    IMAGE_SYMBOL_FUNC,
    IMAGE_SYMBOL_OBJECT,
    IMAGE_SYMBOL_IFUNC, /* indirect function: its address is computed by code at load time */
    IMAGE_SYMBOL_TLS,
    IMAGE_SYMBOL_OTHER
};

/* A defined symbol. */
struct image_symbol {
    const char *name;
    uint64_t vaddr; /* IMAGE_SYMBOL_TLS: offset in the thread's block; IMAGE_SYMBOL_OTHER: may be
                       an absolute number */
    uint64_t size;  /* 0 when the file does not say; else inside the segment that holds vaddr */
    enum image_symbol_kind kind;
    bool exported;   /* visible to whoever loads the module (dynamic symbol, global or weak) */
    bool executable; /* a place in the module, in a segment with IMAGE_EXEC */
    bool thumb;      /* Arm: Thumb code; vaddr is even, a call sets bit 0 of the address */

    /* PE only. An export without a name is called "#7" after its ordinal. A forwarded export is no
     * place in this module (vaddr 0, IMAGE_SYMBOL_OTHER): it stands for "OTHER.Name" or "OTHER.#7",
     * which is an IMAGE_IMPORT_FILTER as well. */
    bool by_ordinal;
    uint32_t ordinal;
    const char *forwarder; /* NULL when none */
};

enum image_import_kind {
    IMAGE_IMPORT_SYMBOL,  /* undefined symbol: the loader would have to find it */
    IMAGE_IMPORT_WEAK,    /* weak undefined symbol: null unless somebody happens to provide it;
                             without a user the linker has made it null for good */
    IMAGE_IMPORT_LIBRARY, /* another file that has to be loaded first (DT_NEEDED, import DLL) */
    IMAGE_IMPORT_FILTER /* DT_FILTER, DT_AUXILIARY and the like, PE export forwarders: another file
                           by the back door */
};

struct image_import {
    enum image_import_kind kind;
    const char *name; /* PE, IMAGE_IMPORT_SYMBOL: "DLL!name" or "DLL!#7" */
    bool has_user; /* a relocation refers to the symbol; user is the place that it patches. PE: the
                      symbol's slot in the import address table */
    uint64_t user;
    bool delayed; /* PE delay import: the module's own code would load it at the first call */
};

enum image_reloc_kind {
    IMAGE_RELOC_RELATIVE, /* add the load address: the only kind a TG Motion loader can satisfy */
    IMAGE_RELOC_SYMBOLIC, /* needs the address of a named symbol */
    IMAGE_RELOC_INDIRECT, /* runs code of the module to learn an address (IRELATIVE) */
    IMAGE_RELOC_TLS,      /* thread-local storage */
    IMAGE_RELOC_OTHER
};

struct image_reloc {
    uint64_t vaddr; /* the word that is patched; for RELATIVE, width bytes in a segment's memory */
    /*
     * For RELATIVE, what to add to the load address, also when it stands in the word itself
     * (DT_REL, DT_RELR, PE): the word becomes load address + addend, modulo 2^(8 * width).
     *
     * A PE file's word holds ImageBase + addend, right for a module that lies at ImageBase; a
     * Windows loader adds the distance from there instead, with the same result.
     */
    int64_t addend;
    enum image_reloc_kind kind;
    uint32_t type;         /* the file format's own number; IMAGE_RELOC_IAT has none */
    const char *type_name; /* "R_X86_64_RELATIVE"; "?" when unknown */
    const char *symbol;    /* NULL when none */
    unsigned width;        /* bytes patched, 0: unknown */
};

/* A slot of a PE import address table, which a loader fills with the address of the symbol. */
#define IMAGE_RELOC_IAT UINT32_MAX

/* Code that a dynamic linker would run before anybody calls the module. */
struct image_initialiser {
    const char *what; /* "DT_PREINIT_ARRAY", "DT_INIT", "DT_INIT_ARRAY", "DT_FINI_ARRAY", "DT_FINI",
                         ".ctors", ".dtors"; "TLS callback" (PE); e_entry of an ELF shared object is
                         none, no loader calls it; for PE and flat images see entry_point */
    uint64_t vaddr;   /* the function; 0 when the array cannot be resolved; Thumb bit taken off */
    unsigned index;   /* position in its array */
};

struct image {
    char *path;     /* as given */
    uint8_t *bytes; /* the whole file */
    size_t size;
    char sha256[65]; /* lower-case hexadecimal of bytes */

    enum image_format format;
    enum image_target target;
    const char *format_name; /* "ELF64", "ELF32", "PE", "flat", "" */
    const char *target_name; /* "x86-64", "i386", "Arm", "AArch64", ... "unknown machine", "" */

    /* Why the file cannot be a module at all, "" when it can: one sentence that names the field,
     * its value and what is allowed; one line, printable ASCII. When set, everything below is
     * empty. */
    char defect[IMAGE_WHY];

    /* A flat image states no permissions; its one segment is called readable and executable, and it
     * holds the module's data, too: whoever runs it has to let it write there. */
    struct image_segment *segments; /* ascending, none empty, no two overlap; two that share a page
                                       have the same permissions */
    size_t segment_count;
    uint64_t span_begin, span_end; /* page-aligned hull of all segments, at most 256 MiB */
    uint64_t align; /* the load address has to be a multiple: power of two, at least 4096 */
    /* The load address that the file was linked for: PE ImageBase, else 0. fixed: it runs nowhere
     * else (a flat image, whose vaddr are its addresses in memory; PE marked as stripped of its
     * relocations: without that mark a PE file without relocations claims to run anywhere). */
    uint64_t base;
    bool fixed;

    /*
     * Code that the format has a loader call once, before any export. PE: AddressOfEntryPoint
     * (DllMain), called by Windows; the manual does not say that TG Motion calls it, only that
     * constructors, which such code would run, are not run. Flat: GetProcAddress, which the
     * controller calls. ELF: none.
     */
    bool has_entry_point;
    uint64_t entry_point;

    struct image_symbol *symbols; /* defined ones, exported or not, sorted by vaddr, then name; no
                                     name is exported twice */
    size_t symbol_count;
    struct image_import *imports;
    size_t import_count;
    struct image_reloc *relocs; /* ascending by vaddr, no two patch the same byte */
    size_t reloc_count;
    struct image_initialiser *initialisers;
    size_t initialiser_count;

    bool has_tls;
    uint64_t tls_size;
    bool exec_stack; /* the file asks for an executable stack (or does not rule it out). PE: it is
                        not marked NX compatible. Flat: false, there is nothing to ask */
    bool exec_stack_stated; /* false: the file has no statement about its stack */
    /* Read-only after relocation (PT_GNU_RELRO), as stated: not rounded to pages. Equal when none.
     */
    uint64_t relro_begin, relro_end;
    bool has_debug_lines;
    /* The file that this one says its debug information is in (PE: a .pdb), NULL when none. It is
     * not read and need not be there. */
    const char *debug_file;

    void *lines;    /* private to lines.c */
    void *routines; /* private to stack.c */
    void *texts;    /* private to image_text.c: names that do not stand in the file as they are */
};

/* A place in the module as a person wants to read it. */
struct image_place {
    const char *function; /* nearest symbol at or below the address, NULL when none */
    uint64_t offset;      /* bytes past its start */
    const char *file; /* source file as the compiler recorded it, NULL without line information */
    int line;
};

/*
 * Reads and describes a file. Returns 0 and an image (look at defect), or a negative errno with a
 * one-line reason in why: the file is missing, a directory, unreadable, or larger than 1 GiB.
 */
int image_open(struct image **out, const char *path, char why[IMAGE_WHY]);

/* The same for bytes already in memory; path is only remembered. The bytes are copied. */
int image_open_memory(struct image **out, const char *path, const void *bytes, size_t size,
                      char why[IMAGE_WHY]);
void image_close(struct image *image);

/* Exported symbol of that exact name, NULL when there is none. */
const struct image_symbol *image_export(const struct image *image, const char *name);

/* Segment holding [vaddr, vaddr + size), NULL when none holds all of it. */
const struct image_segment *image_segment_at(const struct image *image, uint64_t vaddr,
                                             uint64_t size);

/*
 * Function and source line of an address of the module; fields are NULL where unknown. A function
 * is the one that holds the address; where the file does not say how long functions are, the
 * nearest symbol below it.
 *
 * The first call for an image with debug information reads it in a short-lived child process that
 * can do nothing but compute (debug information is hostile input, too). Where no process can be
 * made (in a sealed machine, without seccomp) there are functions but no lines. Not for two threads
 * at once, not for cyclic use.
 */
void image_where(const struct image *image, uint64_t vaddr, struct image_place *place);

/* Why a stack figure is no bound. */
enum image_stack_limit {
    IMAGE_STACK_BOUNDED,
    IMAGE_STACK_RECURSION,  /* a function is called again before it has returned */
    IMAGE_STACK_POINTER,    /* so may one be by a call through a pointer */
    IMAGE_STACK_JUMP,       /* a jump through a pointer or table that could not be followed */
    IMAGE_STACK_VARIABLE,   /* the stack pointer moves by what is computed at run time */
    IMAGE_STACK_LOOP,       /* the stack grows with each turn of a loop */
    IMAGE_STACK_UNBALANCED, /* more is taken off the stack than was put on */
    IMAGE_STACK_CODE,       /* control reaches what is no instruction of the file */
    IMAGE_STACK_LARGE,      /* more code, or more stack, than is looked at */
    IMAGE_STACK_UNKNOWN     /* nothing is known: no process, or the analysis did not end well */
};

/* An exported function (or the entry point) as its machine code shows it. */
struct image_routine {
    uint64_t vaddr;
    uint64_t
        size; /* bytes from its first instruction to the end of the last one that control reaches
                 without a gap, constants among and behind them included; 0: not known */
    uint64_t stack; /* bytes (whole words) that a call takes at most, return address and all
                       functions of the module that it calls included, TG Motion's functions not.
                       With a limit, what is known of it: it may take more */
    enum image_stack_limit limit;
    uint64_t where; /* with a limit: the instruction that it is about */
    bool outside;   /* it calls functions of TG Motion, whose stack comes on top */
};

/*
 * NULL for what is neither exported code nor the entry point. Taken for granted is that the
 * module's functions keep to the calling convention with each other. The first call for an image
 * reads its code in a short-lived child process, as image_where() does; where none can be made, the
 * limit is IMAGE_STACK_UNKNOWN.
 */
const struct image_routine *image_routine(const struct image *image, uint64_t vaddr);

/* Instructions that no computation needs. */
enum image_special_kind {
    IMAGE_SPECIAL_NONE,
    IMAGE_SPECIAL_SYSTEM,     /* asks an operating system, monitor or debugger: syscall, int, svc */
    IMAGE_SPECIAL_PRIVILEGED, /* commands the processor or the machine: in, out, hlt, cli, wfi, mcr
                               */
    IMAGE_SPECIAL_THREAD,     /* reads or writes an operating system's thread block: fs:, gs: */
    IMAGE_SPECIAL_MACHINE     /* its answer depends on machine and moment: rdtsc, cpuid, rdrand */
};

/* How it was come by. */
enum image_special_how {
    IMAGE_SPECIAL_REACHED,   /* control reaches it from an export or the entry point */
    IMAGE_SPECIAL_POINTER,   /* from a function that the module has the address of */
    IMAGE_SPECIAL_UNREACHED, /* it is in a function that nothing was seen to lead to */
    IMAGE_SPECIAL_BYTES /* bytes like it in executable memory, outside all code that was seen */
};

struct image_special {
    uint64_t vaddr;
    uint64_t from; /* the export, entry point or function that led there first; BYTES: vaddr */
    enum image_special_kind kind;
    enum image_special_how how;
    char text[48]; /* "mov eax, dword ptr fs:[0x28]", printable */
};

/* Where an import is used. */
struct image_user {
    bool found;
    uint64_t vaddr; /* the first instruction that uses it, itself and not a linker's stub */
};

/* What the module's code consists of. */
struct image_code {
    bool known; /* false: there could be no process to look in, or it did not end well */
    /* Everything that control can reach has been seen, supposing that pointers to functions point
     * to functions. Else lost is the first jump that could not be followed. */
    bool complete;
    uint64_t lost;
    bool entry_idle;                      /* the entry point returns at once and changes nothing */
    const struct image_special *specials; /* by how, then vaddr; 256 at most */
    size_t special_count;
    const struct image_user *users; /* by import */
};

/* Never NULL. The work is that of image_routine(), done once for both. */
const struct image_code *image_code(const struct image *image);

#endif
