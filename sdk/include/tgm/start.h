/* SPDX-License-Identifier: MIT */
/*
 * start.h - the checks that the manual advises for the beginning of Program_Ini, in one call:
 *
 *     long Program_Ini(PLC_DATA *pData)
 *     {
 *         if (!tgm_check_start(pData))
 *             return 0;
 *         ...
 *
 * A module is compiled against one layout of the shared memories and has no other protection against a TG
 * Motion that has another one. (manual: "Program_Ini", source code sample)
 *
 * The sample then stores the PLC's own version in TGM_Data. Where a screen looks for it is the module's choice, so
 * this one line is left to it: plc.status->version = SHUTTLE_VERSION in the templates.
 *
 * Context: Program_Ini. Nothing is kept: the functions may be called again.
 */
#ifndef TGM_START_H
#define TGM_START_H

#include <tgm_plc.h>

#ifdef __cplusplus
extern "C" {
#endif

/* One name for each layout, so that parts of a module compiled for different ones do not link. */
#if TGM_GENERATION == 4
#define tgm_start_reason tgm_start_reason_4
#define tgm_check_start  tgm_check_start_4
#elif TGM_MEMORY_ID == 905
#define tgm_start_reason tgm_start_reason_5_905
#define tgm_check_start  tgm_check_start_5_905
#else
#define tgm_start_reason tgm_start_reason_5_906
#define tgm_check_start  tgm_check_start_5_906
#endif

/* In the order of the checks: what is read in one is known to be there from those before it. */
enum tgm_start {
    TGM_START_OK = 0,
    TGM_START_NO_DATA,          /* pData is NULL */
    TGM_START_STRUCT_SIZE,      /* structSize is not the size of the PLC_DATA this was compiled for */
    TGM_START_NO_FUNCTION,      /* a function pointer is NULL; generation 4: pRtWprintf_Long,
                                   pRtWprintf_String, pswprintf, pSleepFt; 5: pRtWprintf_String_Severity, pSleepFt */
    TGM_START_NO_SYSTEM_MEMORY, /* no pointer to TGM_System, where the ids are; not in the manual's list */
    TGM_START_COMPATIBILITY,    /* HEADER.Compatibility_Id is not ID_COMPATIBILITY */
    TGM_START_MEMORY            /* generation 5: HEADER.CompatibilityMem_Id is not ID_MEMORY_COMPATIBILITY */
};

/* The first check that fails, or TGM_START_OK. Prints nothing. */
enum tgm_start tgm_start_reason(const PLC_DATA *pData);

/*
 * 1 when everything is as it should be; else 0, and Program_Ini has to return 0.
 *
 * When an id differs, both are printed, since the user has to know what to install:
 *     "PLC not started: compiled for TG Motion compatibility id 4033, running is 4034\n"
 * (in generation 5 as an error of the PLC). Before that point nothing is printed: a PLC_DATA of the wrong size
 * or without functions gives no function that could be trusted to print.
 */
int tgm_check_start(const PLC_DATA *pData);

#ifdef __cplusplus
}
#endif

#endif
