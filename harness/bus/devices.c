/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What is built in: drives, which have code of their own, and terminals, which are device files
 * that came along with the program (terminals.S). */
#include "bus/description.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

extern const struct device_type dev_drive_cia402;
extern const struct device_type dev_drive_cia402x2;
extern const struct device_type dev_drive_heavy;
extern const struct device_type dev_drive_rotary;
extern const struct device_type dev_drive_ideal;
extern const struct device_type dev_tgz_1;
extern const struct device_type dev_tgz_2;
extern const struct device_type dev_tgz_1_native;
extern const struct device_type dev_tgz_2_native;

static const struct device_type *const drives[] = {
    &dev_drive_cia402, &dev_drive_cia402x2, &dev_drive_heavy,  &dev_drive_rotary, &dev_drive_ideal,
    &dev_tgz_1,        &dev_tgz_2,          &dev_tgz_1_native, &dev_tgz_2_native,
};
#define DRIVES (sizeof drives / sizeof *drives)

extern const char terminal_dio_8x8[], terminal_ek1100[], terminal_di_8[], terminal_di_16[],
    terminal_do_8[], terminal_do_16[], terminal_ai_2[], terminal_ao_2[], terminal_strain_1[];

static const char *const texts[] = {
    terminal_dio_8x8, terminal_ek1100, terminal_di_8, terminal_di_16,    terminal_do_8,
    terminal_do_16,   terminal_ai_2,   terminal_ao_2, terminal_strain_1,
};
#define TERMINALS (sizeof texts / sizeof *texts)

static const struct terminal_type *terminals[TERMINALS]; /* for the life of the program */
static pthread_once_t built = PTHREAD_ONCE_INIT;

static const struct terminal_type *build(const char *text, char why[SCAN_WHY])
{
    struct description *d = description_new("built in");
    struct terminal_type *type = NULL;

    if (d && device_file_read(d, text, strlen(text), why) == 0)
        description_build(d, &type, why);
    free(d);
    return type;
}

/* Our own files are read like anybody's. One that is wrong cannot be hidden: nothing works. */
static void build_all(void)
{
    for (size_t i = 0; i < TERMINALS; i++) {
        char why[SCAN_WHY] = "no memory";

        terminals[i] = build(texts[i], why);
        if (!terminals[i]) {
            fprintf(stderr, "terminal %zu: %s\n", i, why);
            abort();
        }
    }
}

const struct device_type *device_type(size_t index)
{
    if (index < DRIVES)
        return drives[index];
    pthread_once(&built, build_all);
    return index - DRIVES < TERMINALS ? &terminals[index - DRIVES]->type : NULL;
}

const struct device_type *device_type_find(const char *name)
{
    const struct device_type *type;

    for (size_t i = 0; (type = device_type(i)); i++) {
        if (strcmp(type->name, name) == 0)
            return type;
    }
    return NULL;
}

const char *device_text(const char *name)
{
    for (size_t i = 0; i < TERMINALS; i++) {
        if (strcmp(device_type(DRIVES + i)->name, name) == 0)
            return texts[i];
    }
    return NULL;
}

const char *bus_device_type(size_t index, const char **description)
{
    const struct device_type *type = device_type(index);

    if (description)
        *description = type ? type->description : NULL;
    return type ? type->name : NULL;
}
