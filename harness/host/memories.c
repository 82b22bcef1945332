/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The shared memories and the six PLC_DATA, as a controller has them before Program_Ini is called.
 */
#include "host/host_parts.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "host/shm.h"

static size_t memory_size(const struct host *host, const char *name)
{
    const struct catalogue_memory *memory = catalogue_memory_named(host->catalogue, name);
    return memory != NULL ? host_memory_bytes(&host->config, memory) : 0;
}

static void fill_header(struct host *host)
{
    const struct product *product = host->config.product;
    HEADER *h = &host->system->Header;
    size_t count = 0;
    while (catalogue_memory(host->catalogue, count) != NULL)
        count++;
    h->Compatibility_Id = product->compatibility_id;
    h->CompatibilityMem_Id = product->memory_id;
    h->CompatibilityCnc_Id = product->cnc_id;
    h->Mem_Number = (uint32_t)count;
    h->Mem_Size_System = (uint32_t)memory_size(host, "TGM_System");
    h->Mem_Size_Data = (uint32_t)memory_size(host, "TGM_Data");
    h->Mem_Size_Cam = (uint32_t)memory_size(host, "TGM_Cam_Profile");
    h->Mem_Size_Osc = (uint32_t)memory_size(host, "TGM_Oscilloscope");
    h->Mem_Size_Servo = (uint32_t)memory_size(host, "TGM_Servo");
    h->Mem_Size_Dio = (uint32_t)memory_size(host, "TGM_Dio");
    h->Mem_Size_Interpolator = (uint32_t)memory_size(host, "TGM_Interpolator");
    h->Mem_Size_InterpolatorWrite = (uint32_t)memory_size(host, "InterpolatorWriteMemory");
    h->Mem_Size_InterpolatorRead = (uint32_t)memory_size(host, "InterpolatorReadMemory");
    h->Mem_Size_Ods = (uint32_t)memory_size(host, "TGM_ODS");
    h->Mem_Size_CncEx = (uint32_t)memory_size(host, "TGM_CNCEX");
#if TGM_GENERATION == 5
    h->Mem_Size_General = (uint32_t)memory_size(host, "TGM_General");
    h->Mem_Size_CncOds = (uint32_t)memory_size(host, "TGM_CNCODS");
#if TGM_MEMORY_ID == 906
    h->Product_Id = product->product_id;
#endif
#endif
}

static void fill_main(struct host *host)
{
    const struct product *product = host->config.product;
    const uint32_t *period = host->config.program_period_us;
    MAIN *m = &host->system->Main;
    m->TGMotion_Version = product->version;
    m->Size_EEPROM_Memory = host->config.eeprom_bytes != 0 ? host->config.eeprom_bytes
                                                           : sizeof host->system->Eeprom.Data;
    m->PLC_CAN_BaudRate = host->config.can_kbit;
    m->Log_Ctrl = host->config.log_ctrl;
    m->Number_Servos = host_servos(host);
    m->Number_Dios = host->config.plant->dios;
    m->Servo_SetCycleTime = host->config.cycle_us;
    m->PLC_SetCycleTime_Prg1 = period[0];
    m->PLC_SetCycleTime_Prg2 = period[1];
    m->PLC_SetCycleTime_Prg3 = period[2];
    m->PLC_SetCycleTime_Prg4 = host->config.cycle_us;
    m->Interpolator_SetCycleTime = host->schedule->interpolator_us;
}

_Static_assert(sizeof(PLC_DATA) % sizeof(void *) == 0, "words and nothing else");

void plc_data_put(struct host *host, enum entry entry, size_t offset, uint64_t value)
{
    const size_t width = host->word_bytes; /* little-endian, as all targets are */
    memcpy(host->plc_data[entry] + offset / sizeof(void *) * width, &value, width);
}

/* Each instance ends at a guard page, so that reading past it faults, and is read-only to the
 * module. */
static int plc_data_open(struct host *host, char why[HOST_WHY])
{
    const size_t size = sizeof(PLC_DATA) / sizeof(void *) * host->word_bytes;
    for (int entry = 0; entry < ENTRY_COUNT; entry++) {
        char name[MACHINE_REGION_NAME];
        void *own, *module;
        snprintf(name, sizeof name, "PLC_DATA of %s", entry_name((enum entry)entry));
        int r = machine_map(host->machine, name, size, MACHINE_REGION_READ, &own, &module, why);
        if (r != 0)
            return r;
        host->plc_data[entry] = own;
        host->plc_data_module[entry] = module;
        memset(own, 0, size);
        plc_data_put(host, (enum entry)entry, offsetof(PLC_DATA, structSize), size);
        for (size_t i = 0; catalogue_memory(host->catalogue, i) != NULL; i++)
            if (catalogue_memory(host->catalogue, i)->pointer >= 0)
                plc_data_put(host, (enum entry)entry,
                             (size_t)catalogue_memory(host->catalogue, i)->pointer,
                             (uintptr_t)host->memory[i]);
    }
    return services_open(host, why);
}

static int memory_open(struct host *host, const struct catalogue_memory *memory, size_t bytes,
                       void **at, char why[HOST_WHY])
{
    void *module;
    if (host->config.shm == NULL)
        return machine_map(host->machine, memory->name, bytes, MACHINE_REGION_READ_WRITE, at,
                           &module, why);
    const int fd = shm_attach(host->config.shm, memory);
    if (fd < 0) {
        snprintf(why, HOST_WHY, "shared memory %s%s: %s", host->config.shm, memory->name,
                 strerror(-fd));
        return fd;
    }
    const int r = machine_map_shared(host->machine, memory->name, bytes, fd, at, why);
    close(fd);
    return r;
}

int memories_open(struct host *host, char why[HOST_WHY])
{
    const struct product *product = host->config.product;
    host->word_bytes = machine_pointer_size(host->machine);
    host->catalogue = catalogue_find(product->generation, (int)product->memory_id);
    if (host->catalogue == NULL) {
        snprintf(why, HOST_WHY, "no layout for generation %d, memory id %u", product->generation,
                 product->memory_id);
        return -EINVAL;
    }
    for (size_t i = 0; catalogue_memory(host->catalogue, i) != NULL; i++) {
        const struct catalogue_memory *memory = catalogue_memory(host->catalogue, i);
        if (i >= HOST_MEMORIES) {
            snprintf(why, HOST_WHY, "more than %d shared memories in the catalogue", HOST_MEMORIES);
            return -E2BIG;
        }
        const size_t bytes = host_memory_bytes(&host->config, memory);
        int r = memory_open(host, memory, bytes, &host->memory[i], why);
        if (r != 0)
            return r;
        host->memory_bytes[i] = bytes;
        if (strcmp(memory->name, "TGM_System") == 0)
            host->system = host->memory[i];
    }
    fill_header(host);
    fill_main(host);
    return plc_data_open(host, why);
}

static void take_function_away(struct host *host, enum plc_function which)
{
#define FUNCTION(member) (offsetof(PLC_DATA, functions) + offsetof(PLC_IMPORT_FUNCTIONS, member))
    static const size_t functions[] = {
        [PLC_STRING] = FUNCTION(GENERATION(pRtWprintf_String, pRtWprintf_String_Severity)),
        [PLC_SLEEP] = FUNCTION(pSleepFt),
#if TGM_GENERATION == 4
        [PLC_LONG] = FUNCTION(pRtWprintf_Long),
        [PLC_SWPRINTF] = FUNCTION(pswprintf),
#endif
    };
    if (functions[which] != 0) /* this generation has it */
        plc_data_put(host, ENTRY_INI, functions[which], 0);
}

void memories_mutate(struct host *host)
{
    const struct mutation *m = &host->config.mutation;
    switch (m->kind) {
    case MUTATION_NONE:
        break;
    case MUTATION_NULL_DATA:
        host->plc_data_module[ENTRY_INI] = NULL;
        break;
    case MUTATION_STRUCT_SIZE:
        plc_data_put(host, ENTRY_INI, offsetof(PLC_DATA, structSize),
                     m->value / (sizeof(void *) / host->word_bytes));
        break;
    case MUTATION_NULL_FUNCTION:
        take_function_away(host, (enum plc_function)m->value);
        break;
    case MUTATION_COMPATIBILITY:
        host->system->Header.Compatibility_Id = (uint32_t)m->value;
        break;
    }
}
