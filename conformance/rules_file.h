/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * rules_file.h - what the rules that the file alone decides share; private to rules_file*.c.
 */
#ifndef CONFORMANCE_RULES_FILE_H
#define CONFORMANCE_RULES_FILE_H

#include "conformance/rules.h"

/* A file that is no module of the profile has no exports or segments to judge: says so. */
bool file_unreadable(const struct case_file *file, struct findings *findings);

/* ELF of either width. */
bool file_is_elf(const struct image *image);

/* How a compiler writes down a name, beyond the name itself. */
enum name_style {
    NAME_PLAIN,      /* Program_01 */
    NAME_CASE,       /* program_01 */
    NAME_UNDERSCORE, /* _Program_01: 32-bit Windows, cdecl */
    NAME_STDCALL,    /* _Program_01@4, Program_01@4 */
    NAME_FASTCALL,   /* @Program_01@4 */
    NAME_VECTORCALL, /* Program_01@@4 */
    NAME_CPP,        /* _Z10Program_01P8PLC_DATA, ?Program_01@@YAJPEAUPLC_DATA@@@Z */
    NAME_PASCAL      /* P$GANTRY_$$_PROGRAM_01$PPLC_DATA$$LONGINT */
};

/* True when the name, undecorated and in whatever case, is the wanted one. */
bool name_is_meant(const char *name, const char *wanted, enum name_style *style);

/* What stands in a library that wants an operating system; NULL: nothing known. */
const char *runtime_symbol(const char *name);

#endif
