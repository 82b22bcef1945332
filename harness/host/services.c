/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The functions that a module finds in PLC_DATA. */
#include "host/host_parts.h"

#include <string.h>

#include "host/text16.h"

#define SERVICE_TEXT 1024 /* UTF-16 units of one console message; the rest is cut */

#if TGM_GENERATION == 5
static int64_t service_string(void *context, struct arguments *arguments)
{
    struct host *host = context;
    const uint32_t id_and_severity = arguments_u32(arguments);
    const void *text = arguments_pointer(arguments);
    if (host->config.product->text8)
        console_text8(host, id_and_severity, text);
    else
        console_text16(host, id_and_severity, text);
    return 0;
}
#else

static void print(struct host *host, uint32_t severity, const uint16_t *text)
{
    console_text16(host, CONSOLE_PLC | (severity & CONSOLE_SEVERITY_MASK) << CONSOLE_SEVERITY_SHIFT,
                   text);
}

static int64_t service_string(void *context, struct arguments *arguments)
{
    const uint16_t *text = arguments_pointer(arguments);
    int32_t length = 0;
    while (text[length] != 0)
        length++;
    print(context, 0, text);
    return length;
}

static int64_t service_long(void *context, struct arguments *arguments)
{
    uint16_t text[SERVICE_TEXT];
    struct arguments only;
    const uint16_t *format = arguments_pointer(arguments);
    const uint64_t value = (uint64_t)(int64_t)(int32_t)arguments_u32(arguments);
    arguments_from_values(&only, &value, 1);
    const int32_t length = text16_vformat(text, SERVICE_TEXT, format, &only);
    print(context, 0, text);
    return length;
}

static int64_t service_swprintf(void *context, struct arguments *arguments)
{
    (void)context;
    uint16_t *buffer = arguments_pointer(arguments);
    const size_t size = arguments_size(arguments);
    const uint16_t *format = arguments_pointer(arguments);
    return text16_vformat(buffer, size, format, arguments);
}

static int64_t service_ex(void *context, struct arguments *arguments)
{
    uint16_t text[SERVICE_TEXT];
    const uint32_t severity = arguments_u32(arguments);
    const uint16_t *format = arguments_pointer(arguments);
    const int32_t length = text16_vformat(text, SERVICE_TEXT, format, arguments);
    print(context, severity, text);
    return length;
}

#endif

static int64_t service_sleep(void *context, struct arguments *arguments)
{
    int64_t units;
    memcpy(&units, arguments_pointer(arguments), sizeof units);
    watch_sleep(context);
    sleep_wanted(context, units);
    return 0;
}

static int64_t send(struct host *host, struct arguments *arguments, bool remote)
{
    const uint32_t number = arguments_u32(arguments);
    const uint32_t id = arguments_u32(arguments);
    const uint32_t length = arguments_u32(arguments);
    const uint8_t *data = arguments_pointer(arguments);
    return can_send(host, number, id, length, remote ? NULL : data, remote);
}

static int64_t service_can(void *context, struct arguments *arguments)
{
    return send(context, arguments, false);
}

static int64_t service_can_remote(void *context, struct arguments *arguments)
{
    return send(context, arguments, true);
}

#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
static int64_t device_info(void *context, struct arguments *arguments)
{
    (void)arguments;
    return (int64_t)(intptr_t)((struct host *)context)->device_name;
}

static int64_t service_info(void *context, struct arguments *arguments)
{
    const char *name = arguments_pointer(arguments);
    const uint32_t opmode = arguments_u32(arguments);
    const bool known = opmode == 0 && strcmp(name, "pcGetDeviceInfo_v") == 0;
    return known ? (int64_t)(intptr_t)((struct host *)context)->device_info : 0;
}

/* The text that the second function returns lies where the module can read it. */
static int open_device_info(struct host *host, char why[HOST_WHY])
{
    const char *name = host->config.product->device_name;
    void *own;
    int r = machine_map(host->machine, "device name", strlen(name) + 1, MACHINE_REGION_READ, &own,
                        &host->device_name, why);
    if (r != 0)
        return r;
    memcpy(own, name, strlen(name) + 1);
    return machine_service(host->machine, "pcGetDeviceInfo_v", device_info, host,
                           &host->device_info, why);
}
#else
static int open_device_info(struct host *host, char why[HOST_WHY])
{
    (void)host;
    (void)why;
    return 0;
}
#endif

static const struct {
    const char *name;
    machine_function *function;
    size_t at; /* in a PLC_DATA of 64 bits */
} services[] = {
#define IMPORT(member, function)                                                                   \
    {                                                                                              \
#member, function, offsetof(PLC_DATA, functions) + offsetof(PLC_IMPORT_FUNCTIONS, member)  \
    }
#if TGM_GENERATION == 4
    IMPORT(pRtWprintf_String, service_string),
    IMPORT(pRtWprintf_Long, service_long),
    IMPORT(pswprintf, service_swprintf),
    IMPORT(pRtWprintf_Ex, service_ex),
#else
    IMPORT(pRtWprintf_String_Severity, service_string),
#endif
    IMPORT(pSleepFt, service_sleep),
    IMPORT(pCAN_Transmit, service_can),
    IMPORT(pCAN_TransmitRemote, service_can_remote),
#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
    { "pGetFunctionOrInfo", service_info, offsetof(PLC_DATA, pGetFunctionOrInfo) },
#endif
};

int services_open(struct host *host, char why[HOST_WHY])
{
    int r = open_device_info(host, why);
    for (size_t i = 0; i < sizeof services / sizeof *services && r == 0; i++) {
        void *function;
        r = machine_service(host->machine, services[i].name, services[i].function, host, &function,
                            why);
        for (int entry = 0; entry < ENTRY_COUNT && r == 0; entry++)
            plc_data_put(host, (enum entry)entry, services[i].at, (uintptr_t)function);
    }
    return r;
}
