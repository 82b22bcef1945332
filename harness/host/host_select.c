/* SPDX-License-Identifier: GPL-2.0-or-later */
/* host.h's functions: each leads to the host that was compiled for the product's layout. */
#include "host/host_ops.h"

#include <errno.h>
#include <stdio.h>

static const struct host_ops *const all[] = { &host_gen4, &host_gen5_905, &host_gen5_906 };

static const struct host_ops *ops(const struct host *host)
{
    return *(const struct host_ops *const *)(const void *)host;
}

int host_open(struct host **out, const struct host_config *config, struct machine *machine,
              const struct image *image, struct evidence *evidence, char why[HOST_WHY])
{
    const struct product *product = config->product;
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (all[i]->generation == product->generation && all[i]->memory_id == product->memory_id)
            return all[i]->open(out, config, machine, image, evidence, why);
    snprintf(why, HOST_WHY, "%s: no host for generation %d, memory id %u", product->title,
             product->generation, product->memory_id);
    return -ENOTSUP;
}

void host_close(struct host *host)
{
    if (host != NULL)
        ops(host)->close(host);
}

bool host_start(struct host *host)
{
    return ops(host)->start(host);
}

bool host_cycle(struct host *host)
{
    return ops(host)->cycle(host);
}

bool host_played(const struct host *host)
{
    return ops(host)->played(host);
}

void host_run(struct host *host)
{
    ops(host)->run(host);
}

void host_stop(struct host *host)
{
    ops(host)->stop(host);
}

void host_pause(struct host *host, bool paused)
{
    ops(host)->pause(host, paused);
}

void host_reset(struct host *host)
{
    ops(host)->reset(host);
}

enum host_plc host_plc(const struct host *host)
{
    return ops(host)->plc(host);
}

uint64_t host_run_time(const struct host *host)
{
    return ops(host)->run_time(host);
}

void host_on_sample(struct host *host, host_sample *sample, void *argument)
{
    ops(host)->on_sample(host, sample, argument);
}

int host_osc_arm(struct host *host, const struct host_osc *wanted, char why[HOST_WHY])
{
    return ops(host)->osc_arm(host, wanted, why);
}

size_t host_osc_samples(const struct host *host)
{
    return ops(host)->osc_samples(host);
}

void host_osc_row(const struct host *host, size_t index, double *row)
{
    ops(host)->osc_row(host, index, row);
}

uint64_t host_cycles(const struct host *host)
{
    return ops(host)->cycles(host);
}

uint64_t host_time(const struct host *host)
{
    return ops(host)->time(host);
}

const void *host_register(const struct host *host, const struct catalogue_register *reg)
{
    return ops(host)->register_at(host, reg);
}

int host_interpolator_load(struct host *host, unsigned number, const struct interp_path *path,
                           bool append, char why[HOST_WHY])
{
    return ops(host)->interpolator_load(host, number, path, append, why);
}

bool host_interpolator_start(struct host *host, unsigned number)
{
    return ops(host)->interpolator_start(host, number);
}

void host_interpolator_stop(struct host *host, unsigned number, bool emergency, bool drop)
{
    ops(host)->interpolator_stop(host, number, emergency, drop);
}
