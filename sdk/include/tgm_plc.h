/* SPDX-License-Identifier: MIT */
/*
 * tgm_plc.h - everything a TG Motion virtual PLC module needs; the one header an author includes.
 *
 * A module is one .tgm file that exports exactly six functions, is linked to nothing, allocates
 * nothing and calls no operating system. It sees the machine through the PLC_DATA it is handed:
 * pointers to shared memories and to a few diagnostic functions.
 * (manual: Virtual PLC, "Making of a PLC")
 *
 *     #include <tgm_plc.h>
 *     long Program_Ini(PLC_DATA *pData) { ...check versions...; return 1; }
 *     long Program_01(PLC_DATA *pData) { (void)pData; return 1; }
 *     ... all six, letter case included
 *
 * Which TG Motion: -DTGM_GENERATION=4 (the default: 4.21, ids 4033/904) or 5; for generation 5,
 * -DTGM_MEMORY_ID=905 (5.00) or 906 (5.02, the default).
 *
 * Strings are UTF-16: compile with -fshort-wchar (sdk/mk/module.mk does), so that L"..." is what
 * TG Motion expects. Global variables have no initial values and constructors do not run: whatever
 * must have a value gets it in Program_Ini (manual: "Program_Ini", warning).
 *
 * The Windows names that the manual uses (LPCWSTR, PLARGE_INTEGER, ULONG, BOOL, PUCHAR, _cdecl ...) exist when
 * TGM_WINDOWS_NAMES is defined; on Windows they then come from <windows.h>, elsewhere from here. Without it
 * nothing of the kind is defined, and <windows.h> may be included before or after this header.
 *
 * Programs that are not modules (the harness, tools) define TGM_HOST before including this header:
 * then wide text is uint16_t and the six entry functions are not declared.
 */
#ifndef TGM_PLC_H
#define TGM_PLC_H

#include <stddef.h>
#include <stdint.h>

#if defined(TGM_WINDOWS_NAMES) && defined(_WIN32)
#include <windows.h>
#endif

#ifndef TGM_GENERATION
#define TGM_GENERATION 4
#endif

#ifdef __cplusplus
#define TGM_STATIC_ASSERT(condition, text) static_assert(condition, text)
#else
#define TGM_STATIC_ASSERT(condition, text) _Static_assert(condition, text)
#endif

/*
 * Layout checks. The three numbers are for targets with 8-byte pointers, with 4-byte pointers and
 * 8-byte alignment of double (Windows i386, Arm EABI), and for System V i386. A failed check means
 * that the compiler's packing options do not fit TG Motion; never change the structures.
 */
#if UINTPTR_MAX > 0xFFFFFFFFu
#define TGM_LAYOUT_PICK(p8, p4, i386) (p8)
#elif defined(__i386__) && !defined(_WIN32) && !defined(__ALIGN_DOUBLE__) && !defined(TGM_ALIGN_DOUBLE)
#define TGM_LAYOUT_PICK(p8, p4, i386) (i386)
#else
#define TGM_LAYOUT_PICK(p8, p4, i386) (p4)
#endif
#define TGM_LAYOUT_OFFSET(type, member, p8, p4, i386)                                              \
    TGM_STATIC_ASSERT(offsetof(type, member) == TGM_LAYOUT_PICK(p8, p4, i386),                     \
                      #type "." #member " is not where TG Motion has it")
#define TGM_LAYOUT_MEMBER_SIZE(type, member, p8, p4, i386)                                         \
    TGM_STATIC_ASSERT(sizeof(((type *)0)->member) == TGM_LAYOUT_PICK(p8, p4, i386),                \
                      #type "." #member " does not have TG Motion's size")
#define TGM_LAYOUT_SIZE(type, p8, p4, i386)                                                        \
    TGM_STATIC_ASSERT(sizeof(type) == TGM_LAYOUT_PICK(p8, p4, i386),                               \
                      #type " does not have TG Motion's size")

/* Wide characters of the module API are 16 bits, `long` of its prototypes is 32 bits. */
#ifdef TGM_HOST
typedef uint16_t tgm_wchar;
#elif defined(TGM_TEXT8)
typedef uint16_t tgm_wchar; /* the controller's text is UTF-8; UTF-16 is for register contents only */
#else
typedef wchar_t tgm_wchar;
TGM_STATIC_ASSERT(sizeof(wchar_t) == 2, "compile with -fshort-wchar: TG Motion's text is UTF-16");
#endif

#if defined(_WIN32) && !defined(__GNUC__)
#define TGM_CALL __cdecl
#else
#define TGM_CALL
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* 64-bit number of SleepFt, with the members that Windows gives it. */
#ifdef _WINNT_
typedef LARGE_INTEGER TGM_LARGE_INTEGER;
#else
typedef union _TGM_LARGE_INTEGER {
    int64_t QuadPart;
    __extension__ struct {
        uint32_t LowPart;
        int32_t HighPart;
    };
    struct {
        uint32_t LowPart;
        int32_t HighPart;
    } u;
} TGM_LARGE_INTEGER;
#endif

#if defined(TGM_WINDOWS_NAMES) && !defined(_WIN32)
typedef const tgm_wchar *LPCWSTR;
typedef tgm_wchar *LPWSTR, WCHAR;
typedef TGM_LARGE_INTEGER LARGE_INTEGER, *PLARGE_INTEGER;
typedef uint32_t ULONG, DWORD, *PULONG;
typedef int32_t BOOL, LONG, *PLONG;
typedef uint8_t UCHAR, BYTE, *PUCHAR;
typedef uint16_t USHORT, WORD;
typedef void *PVOID;
#ifndef TRUE
#define TRUE  1
#define FALSE 0
#endif
#ifndef __cdecl
#define __cdecl
#endif
#endif
#if defined(TGM_WINDOWS_NAMES) && !defined(_cdecl) && !defined(_MSC_VER)
#define _cdecl __cdecl
#endif

/*
 * Diagnostic functions (manual: "Definition of diagnostic functions"). TG Motion owns them; they are
 * valid as long as the module is loaded. Text ends with 0.
 */
#if TGM_GENERATION == 4

typedef tgm_wchar tgm_char; /* text of the module API */

/* Writes text to the console of TG Motion. The result's meaning is not documented. */
typedef int32_t TGM_CALL RTWPRINTF_STRING(const tgm_wchar *text);
/* Writes one 32-bit number to the console; format holds one integer conversion, as in L"%d". */
typedef int32_t TGM_CALL RTWPRINTF_LONG(const tgm_wchar *format, int32_t value);
/* Writes formatted text to buffer, at most size wide characters with the final 0; returns their number
 * without the final 0, or a negative value when they do not fit. Size is in wide characters. */
typedef int32_t TGM_CALL SWPRINTF(tgm_wchar *buffer, size_t size, const tgm_wchar *format, ...);
/* Waits; Pause->QuadPart is a number of 100 ns. Forbidden in Program_04 and Program_05. */
typedef void TGM_CALL SLEEPFT(TGM_LARGE_INTEGER *Pause);
/* Reserved by the manual: CAN telegram number Number with identifier Id and Dlc (0..8) data bytes. */
typedef int32_t TGM_CALL CAN_TRANSMIT(uint32_t Number, uint32_t Id, uint32_t Dlc, uint8_t *Tx_Data);
typedef int32_t TGM_CALL CAN_TRANSMITREMOTE(uint32_t Number, uint32_t Id, uint32_t Dlc, uint8_t *Tx_Data);
/* Writes formatted text with a severity (0 information, 1 warning, 2 error) to the console. */
typedef int32_t TGM_CALL RTWPRINTF_EX(int32_t severity, const tgm_wchar *format, ...);

#include "tgm/layout_gen4.h"

#elif TGM_GENERATION == 5

#ifndef TGM_MEMORY_ID
#define TGM_MEMORY_ID 906
#endif

/* Text of the module API: UTF-16 on a PC; on TGMmini, TGMcontroller and TGZ+Motion, where TGM_TEXT8 is
 * defined (module.mk does), bytes in UTF-8. */
#ifdef TGM_TEXT8
typedef char tgm_char;
#else
typedef tgm_wchar tgm_char;
#endif

/* Writes finished text to the console. id_and_severity: source (ODS_ID_...) | severity (ODS_SEVERITY_...) <<
 * ODS_SEVERITY_SHIFT. Returns 0. */
typedef int32_t TGM_CALL RTWPRINTF_STRING_SEVERITY(uint32_t id_and_severity, const tgm_char *text);
/* Waits; interval->QuadPart is a number of 100 ns. Forbidden in Program_04. */
typedef struct _PLC_LARGE_INTEGER PLC_LARGE_INTEGER;
typedef void TGM_CALL SLEEPFT(PLC_LARGE_INTEGER *interval);
/* Sends a CAN telegram with identifier id and dlc (0..8) data bytes. The meanings of number and of the
 * result are not documented. */
typedef int32_t TGM_CALL CAN_TRANSMIT(uint32_t number, uint32_t id, uint32_t dlc, uint8_t *data);
typedef int32_t TGM_CALL CAN_TRANSMITREMOTE(uint32_t number, uint32_t id, uint32_t dlc, uint8_t *data);
/* 5.02: address of a function or information by name, 0 when there is none; opmode is 0. The one name that
 * is documented is "pcGetDeviceInfo_v", a GET_DEVICE_INFO. */
typedef intptr_t TGM_CALL GET_FUNCTION_OR_INFO(const char *name, uint32_t opmode);
/* Name of the controller: "PC-realtime", "PC-demo", "TGMmini", "TGMcontroller", "TGZ+Motion" ... */
typedef const char *TGM_CALL GET_DEVICE_INFO(void);

#if TGM_MEMORY_ID == 905
#include "tgm/layout_gen5_905.h"
#elif TGM_MEMORY_ID == 906
#include "tgm/layout_gen5_906.h"
#else
#error "TGM_MEMORY_ID must be 905 (TG Motion 5.00) or 906 (5.02)"
#endif

#else
#error "TGM_GENERATION must be 4 or 5"
#endif

typedef PLC_DATA *PPLC_DATA;

#ifndef TGM_HOST
/*
 * The six entry functions. All must exist; each returns a value. Program_Ini: 1 = go on, 0 = stop the
 * start. The others return 1. (manual: "Functions PLC")
 *   Program_Ini  once, before any cycle; its length is not limited
 *   Program_01   lowest priority, own period, should stay below 20 % of it
 *   Program_02   low priority, own period, interrupts Program_01
 *   Program_03   medium priority, own period, interrupts Program_01 and 02
 *   Program_04   every Cycle_Time, never interrupted, at most 10 % of it
 *   Program_05   with every interpolator step, never interrupted, at most 10 microseconds
 */
#if defined(_WIN32)
#define TGM_EXPORT
#else
#define TGM_EXPORT __attribute__((visibility("default")))
#endif
TGM_EXPORT long Program_Ini(PLC_DATA *pData);
TGM_EXPORT long Program_01(PLC_DATA *pData);
TGM_EXPORT long Program_02(PLC_DATA *pData);
TGM_EXPORT long Program_03(PLC_DATA *pData);
TGM_EXPORT long Program_04(PLC_DATA *pData);
TGM_EXPORT long Program_05(PLC_DATA *pData);

/* Freestanding memory functions of the SDK (sdk/src/mem.c); the usual contracts of ISO C. Compilers
 * call them on their own, so every module is linked with them. */
void *memcpy(void *to, const void *from, size_t size);
void *memmove(void *to, const void *from, size_t size);
void *memset(void *at, int value, size_t size);
int memcmp(const void *a, const void *b, size_t size);
#endif

#ifdef __cplusplus
}
#endif

#endif
