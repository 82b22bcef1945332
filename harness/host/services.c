/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The diagnostic functions that a module of generation 4 finds in PLC_DATA. */
#include "host/host_parts.h"

#include <stdarg.h>
#include <string.h>

#include "host/text16.h"

#define SERVICE_TEXT 1024 /* UTF-16 units of one console message; the rest is cut */

/* Services have no context argument: they act for the one host of this worker process. */
static struct host *service_host;

static void record_message(int32_t severity, const uint16_t *text)
{
    struct evidence *evidence = service_host->evidence;
    const uint64_t at = evidence->message_count++;
    if (at >= EVIDENCE_MESSAGES)
        return;
    struct evidence_message *message = &evidence->messages[at];
    message->entry = evidence->entry;
    message->cycle = evidence->cycle;
    message->severity = severity;
    size_t length = text16_to_utf8(message->text, sizeof message->text, text);
    while (length > 0 && (message->text[length - 1] == '\n' || message->text[length - 1] == '\r'))
        message->text[--length] = '\0';
}

static int32_t service_string(const tgm_wchar *text)
{
    machine_service_enter(service_host->machine, "pRtWprintf_String", __builtin_return_address(0));
    int32_t length = 0;
    while (text[length] != 0)
        length++;
    record_message(0, text);
    machine_service_leave(service_host->machine);
    return length;
}

static int32_t service_long(const tgm_wchar *format, int32_t value)
{
    tgm_wchar text[SERVICE_TEXT];
    machine_service_enter(service_host->machine, "pRtWprintf_Long", __builtin_return_address(0));
    int32_t length = text16_format(text, SERVICE_TEXT, format, value);
    record_message(0, text);
    machine_service_leave(service_host->machine);
    return length;
}

static int32_t service_swprintf(tgm_wchar *buffer, size_t size, const tgm_wchar *format, ...)
{
    va_list arguments;
    machine_service_enter(service_host->machine, "pswprintf", __builtin_return_address(0));
    va_start(arguments, format);
    int32_t length = text16_vformat(buffer, size, format, arguments);
    va_end(arguments);
    machine_service_leave(service_host->machine);
    return length;
}

static int32_t service_ex(int32_t severity, const tgm_wchar *format, ...)
{
    tgm_wchar text[SERVICE_TEXT];
    va_list arguments;
    machine_service_enter(service_host->machine, "pRtWprintf_Ex", __builtin_return_address(0));
    va_start(arguments, format);
    int32_t length = text16_vformat(text, SERVICE_TEXT, format, arguments);
    va_end(arguments);
    record_message(severity, text);
    machine_service_leave(service_host->machine);
    return length;
}

/* Every function runs to completion on the simulated clock, so a wait lets nothing else run (R17).
 */
static void service_sleep(TGM_LARGE_INTEGER *pause)
{
    machine_service_enter(service_host->machine, "pSleepFt", __builtin_return_address(0));
    (void)*(volatile int64_t *)&pause->QuadPart;
    const enum entry entry = service_host->evidence->entry;
    if (entry == ENTRY_04 || entry == ENTRY_05)
        service_host->evidence->sleeps_in_04_05++;
    machine_service_leave(service_host->machine);
}

/* Reserved by the manual: nothing is connected, so nothing is sent (R9). */
static int32_t service_can(uint32_t number, uint32_t id, uint32_t dlc, uint8_t *data)
{
    (void)number, (void)id, (void)dlc, (void)data;
    return 0;
}

void services_bind(struct host *host, PLC_IMPORT_FUNCTIONS *functions)
{
    service_host = host;
    functions->pRtWprintf_String = service_string;
    functions->pRtWprintf_Long = service_long;
    functions->pswprintf = service_swprintf;
    functions->pSleepFt = service_sleep;
    functions->pCAN_Transmit = service_can;
    functions->pCAN_TransmitRemote = service_can;
    functions->pRtWprintf_Ex = service_ex;
}
