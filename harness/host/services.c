/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The functions that a module finds in PLC_DATA. */
#include "host/host_parts.h"

#include <stdarg.h>
#include <string.h>

#include "host/text16.h"

#define SERVICE_TEXT 1024 /* UTF-16 units of one console message; the rest is cut */

/* Services have no context argument: they act for the one host of this worker process. */
static struct host *service_host;

#if TGM_GENERATION == 5
static int32_t service_string(uint32_t id_and_severity, const tgm_char *text)
{
    machine_service_enter(service_host->machine, "pRtWprintf_String_Severity",
                          __builtin_return_address(0));
    if (service_host->config.product->text8)
        console_text8(service_host, id_and_severity, (const char *)text);
    else
        console_text16(service_host, id_and_severity, text);
    machine_service_leave(service_host->machine);
    return 0;
}
#else

static void print(int32_t severity, const tgm_wchar *text)
{
    console_text16(service_host,
                   CONSOLE_PLC | ((uint32_t)severity & CONSOLE_SEVERITY_MASK)
                                     << CONSOLE_SEVERITY_SHIFT,
                   text);
}

static int32_t service_string(const tgm_wchar *text)
{
    machine_service_enter(service_host->machine, "pRtWprintf_String", __builtin_return_address(0));
    int32_t length = 0;
    while (text[length] != 0)
        length++;
    print(0, text);
    machine_service_leave(service_host->machine);
    return length;
}

static int32_t service_long(const tgm_wchar *format, int32_t value)
{
    tgm_wchar text[SERVICE_TEXT];
    machine_service_enter(service_host->machine, "pRtWprintf_Long", __builtin_return_address(0));
    int32_t length = text16_format(text, SERVICE_TEXT, format, value);
    print(0, text);
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
    print(severity, text);
    machine_service_leave(service_host->machine);
    return length;
}

#endif

/* Every function runs to completion on the simulated clock, so a wait lets nothing else run (R17).
 */
static void service_sleep(GENERATION(TGM_LARGE_INTEGER, PLC_LARGE_INTEGER) * pause)
{
    machine_service_enter(service_host->machine, "pSleepFt", __builtin_return_address(0));
    (void)*(volatile int64_t *)&pause->QuadPart;
    watch_sleep(service_host, __builtin_return_address(0));
    machine_service_leave(service_host->machine);
}

static int32_t service_can(uint32_t number, uint32_t id, uint32_t dlc, uint8_t *data)
{
    machine_service_enter(service_host->machine, "pCAN_Transmit", __builtin_return_address(0));
    const int32_t sent = can_send(service_host, number, id, dlc, data, false);
    machine_service_leave(service_host->machine);
    return sent;
}

static int32_t service_can_remote(uint32_t number, uint32_t id, uint32_t dlc, uint8_t *data)
{
    (void)data;
    machine_service_enter(service_host->machine, "pCAN_TransmitRemote",
                          __builtin_return_address(0));
    const int32_t sent = can_send(service_host, number, id, dlc, NULL, true);
    machine_service_leave(service_host->machine);
    return sent;
}

#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
static const char *device_info(void)
{
    return service_host->config.product->device_name;
}

static intptr_t service_info(const char *name, uint32_t opmode)
{
    machine_service_enter(service_host->machine, "pGetFunctionOrInfo", __builtin_return_address(0));
    const bool known = opmode == 0 && strcmp(name, "pcGetDeviceInfo_v") == 0;
    machine_service_leave(service_host->machine);
    return known ? (intptr_t)device_info : 0;
}
#endif

void services_bind(struct host *host, PLC_DATA *data)
{
    PLC_IMPORT_FUNCTIONS *functions = &data->functions;
    service_host = host;
#if TGM_GENERATION == 4
    functions->pRtWprintf_String = service_string;
    functions->pRtWprintf_Long = service_long;
    functions->pswprintf = service_swprintf;
    functions->pRtWprintf_Ex = service_ex;
#else
    functions->pRtWprintf_String_Severity = service_string;
#endif
    functions->pSleepFt = service_sleep;
    functions->pCAN_Transmit = service_can;
    functions->pCAN_TransmitRemote = service_can_remote;
#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
    data->pGetFunctionOrInfo = service_info;
#endif
}
