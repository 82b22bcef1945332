/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * shm.h - the shared memories as POSIX shared memory, for programs beside the harness.
 *
 * Each memory is an object under the name TG Motion gives it ("/TGM_System"), with a prefix when
 * two runs are to go on at once ("/line2_TGM_System"); register offsets are offsets in the object.
 * Only its owner may open it (0600). The parent makes the objects and takes them away, whatever
 * becomes of the worker; what a killed parent left behind is recognised, because nobody holds its
 * lock, and replaced.
 */
#ifndef HARNESS_HOST_SHM_H
#define HARNESS_HOST_SHM_H

#include "host/host.h"

#define SHM_WHY    256
#define SHM_NAME   128
#define SHM_PREFIX 64
#define SHM_MOST   16

struct shm {
    size_t count;
    struct {
        char name[SHM_NAME];
        int fd; /* holds the lock */
    } objects[SHM_MOST];
};

/* All memories of the product so configured. 0, or negative errno with a reason; -EEXIST: somebody
 * else has them. */
int shm_make(struct shm *shm, const struct host_config *config, char why[SHM_WHY]);
void shm_remove(struct shm *shm);
/* Only the names; fit for signal handlers. */
void shm_unlink_names(const struct shm *shm);

/* In the worker: a descriptor of one memory, or negative errno. */
int shm_attach(const char *prefix, const struct catalogue_memory *memory);

#endif
