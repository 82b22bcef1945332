/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * pascal_rig.c - runs what Free Pascal compiled, without the harness: ELF by dlopen, PE32+ by mapping it.
 *
 *   pascal_rig probe   MODULE   offset and size of every member, C's and Pascal's; differences at the end
 *   pascal_rig machine MODULE   drives the shuttle against an ideal carriage, prints every set-point's bits and
 *                               what the module says
 */
#include <dlfcn.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#define TGM_HOST
#include <tgm_plc.h>
#include <tgm/motion.h>
#include <tgm/text.h>

typedef __attribute__((ms_abi)) long ms_entry(void *);
typedef long sysv_entry(void *);

static uint8_t *image; /* PE: where it is mapped; ELF: NULL */
static void *library;

static uint32_t u32(const uint8_t *at)
{
    uint32_t value;
    memcpy(&value, at, sizeof value);
    return value;
}

/* Adds to every 64-bit address the distance between where the image is and where it was linked to be. */
static void relocate(const uint8_t *optional)
{
    uint64_t linked, word;
    const uint8_t *block = image + u32(optional + 112 + 5 * 8), *end = block + u32(optional + 112 + 5 * 8 + 4);

    memcpy(&linked, optional + 24, 8);
    for (; block < end; block += u32(block + 4))
        for (uint32_t i = 8; i < u32(block + 4); i += 2) {
            const uint32_t entry = block[i] | block[i + 1] << 8;
            uint8_t *at = image + u32(block) + (entry & 0xfff);

            if (entry >> 12 != 10) /* IMAGE_REL_BASED_DIR64 */
                continue;
            memcpy(&word, at, 8);
            word += (uintptr_t)image - linked;
            memcpy(at, &word, 8);
        }
}

static void map_pe(const uint8_t *file)
{
    const uint8_t *pe = file + u32(file + 0x3c), *optional = pe + 24;
    const unsigned sections = pe[6] | pe[7] << 8, optional_size = pe[20] | pe[21] << 8;

    image = mmap(NULL, u32(optional + 56), PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    for (unsigned i = 0; i < sections; i++) {
        const uint8_t *section = optional + optional_size + 40 * i;
        uint32_t size = u32(section + 16) < u32(section + 8) ? u32(section + 16) : u32(section + 8);
        memcpy(image + u32(section + 12), file + u32(section + 20), size);
    }
    relocate(optional);
    memcpy(image, file, 0x400); /* headers, for entry() */
}

static void *entry(const char *name)
{
    if (image == NULL)
        return dlsym(library, name);
    const uint8_t *table = image + u32(image + u32(image + 0x3c) + 24 + 112);
    const uint8_t *names = image + u32(table + 32), *ordinals = image + u32(table + 36), *code = image + u32(table + 28);
    for (uint32_t i = 0; i < u32(table + 24); i++)
        if (strcmp((const char *)image + u32(names + 4 * i), name) == 0)
            return image + u32(code + 4 * (ordinals[2 * i] | ordinals[2 * i + 1] << 8));
    return NULL;
}

static void load(const char *path)
{
    static uint8_t file[1 << 22];
    FILE *stream = fopen(path, "rb");
    if (stream == NULL || fread(file, 1, sizeof file, stream) < 64) {
        printf("%s: cannot be read\n", path);
        exit(2);
    }
    fclose(stream);
    if (file[0] == 'M')
        map_pe(file);
    else if ((library = dlopen(path, RTLD_NOW)) == NULL)
        puts(dlerror()), exit(2);
}

static int32_t call(const char *name, void *argument)
{
    void *function = entry(name);
    if (function == NULL)
        printf("%s: not exported\n", name), exit(2);
    return (int32_t)(image ? ((ms_entry *)function)(argument) : ((sysv_entry *)function)(argument));
}

static const struct row {
    const char *structure, *member;
    uint32_t offset, size;
} rows[] = {
#define ROW(s, m) {#s, #m, offsetof(s, m), sizeof(((s *)0)->m)},
#define END(s)    {#s, "@end", sizeof(s), sizeof(s)},
#ifdef ROWS
#include ROWS
#else
    {"", "", 0, 0},
#endif
};

static int probe(void)
{
    const size_t count = sizeof rows / sizeof rows[0];
    uint32_t *pascal = calloc(count + 1, 2 * sizeof *pascal);
    int differences = 0;

    call("pascal_probe", pascal);
    for (size_t i = 0; i < count; i++) {
        const struct row *c = &rows[i];
        const int differs = pascal[2 * i] != c->offset || pascal[2 * i + 1] != c->size;
        differences += differs;
        if (differs)
            printf("%s.%s: offset %u, size %u in C; %u, %u in Pascal\n", c->structure, c->member, c->offset, c->size,
                   pascal[2 * i], pascal[2 * i + 1]);
    }
    printf("%zu rows, %d differ\n", count, differences);
    return differences != 0;
}

/* What differs between the generations. */
#if TGM_GENERATION == 4
#define SYSTEM_POINTER PSystem_Memory
#define SERVO_POINTER  PServo_Memory
#define DIO_POINTER    PDio_Memory
#define DATA_POINTER   PData_Memory
#define INPUTS(dio)    (dio).In0
#define OUTPUTS(dio)   (dio).Out0
#define PRINT          pRtWprintf_String
#define PRINT_ARGUMENTS const tgm_wchar *text
#else
#define SYSTEM_POINTER pSystem_Memory
#define SERVO_POINTER  pServo_Memory
#define DIO_POINTER    pDio_Memory
#define DATA_POINTER   pData_Memory
#define INPUTS(dio)    (dio).In[0]
#define OUTPUTS(dio)   (dio).Out[0]
#define PRINT          pRtWprintf_String_Severity
#define PRINT_ARGUMENTS uint32_t id, const tgm_wchar *text
#endif

static int32_t says(uint32_t id, const tgm_wchar *text)
{
    printf("says %" PRIu32 ": ", id);
    for (; *text != 0; text++)
        putchar(*text < 127 ? (int)*text : '?');
    return 0;
}

#if TGM_GENERATION == 4
static __attribute__((ms_abi)) int32_t ms_print(PRINT_ARGUMENTS) { return says(0, text); }
static int32_t sysv_print(PRINT_ARGUMENTS) { return says(0, text); }
#else
static __attribute__((ms_abi)) int32_t ms_print(PRINT_ARGUMENTS) { return says(id, text); }
static int32_t sysv_print(PRINT_ARGUMENTS) { return says(id, text); }
#endif

static void never(void)
{
    abort();
}

static int machine(void)
{
    static SYSTEM system;
    static SERVO servo;
    static DIO dio;
    static double data[64];
    PLC_DATA plc = {.structSize = sizeof plc, .SYSTEM_POINTER = &system, .SERVO_POINTER = &servo,
                    .DIO_POINTER = &dio, .DATA_POINTER = (void *)data};
    void *const print = image ? (void *)ms_print : (void *)sysv_print;

    memcpy(&plc.functions.PRINT, &print, sizeof print);
#if TGM_GENERATION == 4
    plc.functions.pswprintf = (void *)never;
    plc.functions.pRtWprintf_Long = (void *)never;
#endif
    plc.functions.pSleepFt = (void *)never;
    system.Header.Compatibility_Id = ID_COMPATIBILITY + 1;
    system.Header.CompatibilityMem_Id = ID_MEMORY_COMPATIBILITY;
    system.Header.Mem_Size_Data = sizeof data;
    system.Main.Number_Servos = system.Main.Number_Dios = 1;
    system.Main.Servo_SetCycleTime = 500;
    servo.Resolution = 262144;
    servo.Position = 300000.25;
    printf("Program_Ini %d\n", call("Program_Ini", &plc)); /* another TG Motion */
    system.Header.Compatibility_Id = ID_COMPATIBILITY;
    system.Main.Number_Dios = 0;
    printf("Program_Ini %d\n", call("Program_Ini", &plc)); /* no I/O unit */
    system.Main.Number_Dios = 1;
    printf("Program_Ini %d\n", call("Program_Ini", &plc));
    for (int cycle = 0; cycle < 10000; cycle++) {
        uint64_t bits[2];

        servo.EtherCATState = dio.EtherCATState = cycle < 10 ? 4 : 8;
        servo.Status = cycle == 7000 ? SERVO_FAULT : servo.Mode ? SERVO_READY_ENABLE : 2;
        servo.DigitalIn = servo.Position < 1000.125 ? 4 : 0;
        INPUTS(dio) = cycle >> 4;
        call("Program_04", &plc);
        call("Program_01", &plc);
        servo.Position = servo.Mode ? servo.WritePosition : servo.Position;
        memcpy(bits, &servo.WritePosition, 8);
        memcpy(bits + 1, &data[3], 8);
        printf("%d %016" PRIx64 " %016" PRIx64 " %d %d %d\n", cycle, bits[0], bits[1], (int)servo.Mode, (int)servo.Control,
               (int)OUTPUTS(dio));
    }
    fwrite(data, 8, 4, stdout);
    return 0;
}

int main(int argc, char **argv)
{
    if (argc != 3)
        return 2;
    load(argv[2]);
    return strcmp(argv[1], "probe") == 0 ? probe() : machine();
}
