/* SPDX-License-Identifier: GPL-2.0-or-later */
/* host_ops.h - one host for each layout of the shared memories: what host.h's functions lead to. */
#ifndef HARNESS_HOST_OPS_H
#define HARNESS_HOST_OPS_H

#include "host/host.h"

struct host_ops {
    int generation;
    uint32_t memory_id;
    int (*open)(struct host **out, const struct host_config *config, struct machine *machine,
                const struct image *image, struct evidence *evidence, char why[HOST_WHY]);
    void (*close)(struct host *host);
    bool (*start)(struct host *host);
    bool (*cycle)(struct host *host);
    bool (*played)(const struct host *host);
    void (*run)(struct host *host);
    void (*stop)(struct host *host);
    void (*pause)(struct host *host, bool paused);
    void (*reset)(struct host *host);
    enum host_plc (*plc)(const struct host *host);
    uint64_t (*run_time)(const struct host *host);
    void (*on_sample)(struct host *host, host_sample *sample, void *argument);
    int (*osc_arm)(struct host *host, const struct host_osc *wanted, char why[HOST_WHY]);
    size_t (*osc_samples)(const struct host *host);
    void (*osc_row)(const struct host *host, size_t index, double *row);
    uint64_t (*cycles)(const struct host *host);
    uint64_t (*time)(const struct host *host);
    const void *(*register_at)(const struct host *host, const struct catalogue_register *reg);
    int (*interpolator_load)(struct host *host, unsigned number, const struct interp_path *path,
                             bool append, char why[HOST_WHY]);
    bool (*interpolator_start)(struct host *host, unsigned number);
    void (*interpolator_stop)(struct host *host, unsigned number, bool emergency, bool drop);
};

extern const struct host_ops host_gen4, host_gen5_905, host_gen5_906;

#endif
