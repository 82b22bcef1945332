/* SPDX-License-Identifier: MIT */
#include "tgm/start.h"

#include "tgm/text.h"

#define LINE_SIZE 120

#if TGM_GENERATION == 4

/* The manual of generation 4 asks for the compatibility id alone. */
#define MEMORY_ID_COUNTS 0

static const HEADER *header_of(const PLC_DATA *pData)
{
    return pData->PSystem_Memory != NULL ? &((const SYSTEM *)pData->PSystem_Memory)->Header : NULL;
}

static int functions_are_there(const PLC_IMPORT_FUNCTIONS *f)
{
    return f->pRtWprintf_String != NULL && f->pRtWprintf_Long != NULL && f->pswprintf != NULL && f->pSleepFt != NULL;
}

static void print(const PLC_DATA *pData, const tgm_char *line)
{
    pData->functions.pRtWprintf_String(line);
}

#else

#define MEMORY_ID_COUNTS 1

static const HEADER *header_of(const PLC_DATA *pData)
{
    return pData->pSystem_Memory != NULL ? &pData->pSystem_Memory->Header : NULL;
}

static int functions_are_there(const PLC_IMPORT_FUNCTIONS *f)
{
    return f->pRtWprintf_String_Severity != NULL && f->pSleepFt != NULL;
}

static void print(const PLC_DATA *pData, const tgm_char *line)
{
    pData->functions.pRtWprintf_String_Severity(ODS_ID_PLC | ODS_SEVERITY_ERROR_02 << ODS_SEVERITY_SHIFT, line);
}

#endif

enum tgm_start tgm_start_reason(const PLC_DATA *pData)
{
    if (pData == NULL)
        return TGM_START_NO_DATA;
    if (pData->structSize != sizeof(PLC_DATA))
        return TGM_START_STRUCT_SIZE;
    if (!functions_are_there(&pData->functions))
        return TGM_START_NO_FUNCTION;
    const HEADER *header = header_of(pData);
    if (header == NULL)
        return TGM_START_NO_SYSTEM_MEMORY;
    if (header->Compatibility_Id != ID_COMPATIBILITY)
        return TGM_START_COMPATIBILITY;
    if (MEMORY_ID_COUNTS && header->CompatibilityMem_Id != ID_MEMORY_COMPATIBILITY)
        return TGM_START_MEMORY;
    return TGM_START_OK;
}

static void report(const PLC_DATA *pData, const char *kind, uint32_t own, uint32_t found)
{
    tgm_char line[LINE_SIZE];
    tgm_text t;

    tgm_text_init(&t, line, LINE_SIZE);
    tgm_text_utf8(&t, "PLC not started: compiled for TG Motion ");
    tgm_text_utf8(&t, kind);
    tgm_text_utf8(&t, " id ");
    tgm_text_unsigned(&t, own, 0, ' ');
    tgm_text_utf8(&t, ", running is ");
    tgm_text_unsigned(&t, found, 0, ' ');
    tgm_text_utf8(&t, "\n");
    print(pData, line);
}

int tgm_check_start(const PLC_DATA *pData)
{
    const enum tgm_start reason = tgm_start_reason(pData);

    if (reason == TGM_START_COMPATIBILITY)
        report(pData, "compatibility", ID_COMPATIBILITY, header_of(pData)->Compatibility_Id);
    else if (reason == TGM_START_MEMORY)
        report(pData, "memory", ID_MEMORY_COMPATIBILITY, header_of(pData)->CompatibilityMem_Id);
    return reason == TGM_START_OK;
}
