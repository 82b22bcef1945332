/* SPDX-License-Identifier: GPL-2.0-or-later */
#define _GNU_SOURCE 1
#include "host/shm.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <unistd.h>

static void name_of(char name[SHM_NAME], const char *prefix, const struct catalogue_memory *memory)
{
    snprintf(name, SHM_NAME, "/%.*s%.48s", SHM_PREFIX, prefix, memory->name);
}

/* A new object, locked; -EEXIST when there is one of that name. */
static int create(const char *name)
{
    const int fd = shm_open(name, O_RDWR | O_CREAT | O_EXCL, 0600);
    if (fd < 0)
        return -errno;
    flock(fd, LOCK_EX | LOCK_NB);
    return fd;
}

/* An object without a lock belongs to a run that was killed. */
static bool remove_stale(const char *name)
{
    const int fd = shm_open(name, O_RDWR, 0);
    const bool stale = fd >= 0 && flock(fd, LOCK_EX | LOCK_NB) == 0 && shm_unlink(name) == 0;
    if (fd >= 0)
        close(fd);
    return stale;
}

static int make_one(struct shm *shm, const char *name, size_t size)
{
    int fd = create(name);
    if (fd == -EEXIST && remove_stale(name))
        fd = create(name);
    if (fd < 0)
        return fd;
    memcpy(shm->objects[shm->count].name, name, SHM_NAME);
    shm->objects[shm->count++].fd = fd;
    return ftruncate(fd, (off_t)size) != 0 ? -errno : 0;
}

int shm_make(struct shm *shm, const struct host_config *config, char why[SHM_WHY])
{
    const struct catalogue *catalogue =
        catalogue_find(config->product->generation, (int)config->product->memory_id);
    const struct catalogue_memory *memory;
    *shm = (struct shm){ .count = 0 };
    if (catalogue == NULL)
        return -EINVAL;
    for (size_t i = 0; (memory = catalogue_memory(catalogue, i)) != NULL; i++) {
        char name[SHM_NAME] = "";
        name_of(name, config->shm, memory);
        const int r =
            i < SHM_MOST ? make_one(shm, name, host_memory_bytes(config, memory)) : -E2BIG;
        if (r == 0)
            continue;
        snprintf(why, SHM_WHY, "shared memory %s: %s%s", name, strerror(-r),
                 r == -EEXIST ? " (another run? --shm-prefix gives this one names of its own)"
                              : "");
        shm_remove(shm);
        return r;
    }
    return 0;
}

void shm_unlink_names(const struct shm *shm)
{
    for (size_t i = 0; i < shm->count; i++)
        shm_unlink(shm->objects[i].name);
}

void shm_remove(struct shm *shm)
{
    shm_unlink_names(shm);
    for (size_t i = 0; i < shm->count; i++)
        close(shm->objects[i].fd);
    shm->count = 0;
}

int shm_attach(const char *prefix, const struct catalogue_memory *memory)
{
    char name[SHM_NAME];
    name_of(name, prefix, memory);
    const int fd = shm_open(name, O_RDWR, 0);
    return fd < 0 ? -errno : fd;
}
