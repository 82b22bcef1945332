/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Any bytes as a configuration file, for the product that the first byte chooses. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/config.h"
#include "host/servo_wire.h"

int LLVMFuzzerInitialize(int *argument_count, char ***arguments);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static unsigned long long inputs, good, buses;

static void say_what_was_seen(void)
{
    fprintf(stderr, "%llu inputs: %llu without errors, %llu of them with servos\n", inputs, good,
            buses);
}

int LLVMFuzzerInitialize(int *argument_count, char ***arguments)
{
    (void)argument_count;
    (void)arguments;
    return atexit(say_what_was_seen);
}

/* A file without errors gives a host and a bus that fit. */
static void whole_or_nothing(const struct config *config)
{
    static struct config_store store;
    struct host_config host = { 0 };
    if (config->errors > 0)
        return;
    config_apply(config, &store, &host);
    const struct plant *plant = config_plant(config, &store);
    if (plant->device_count > BUS_MAX_SLAVES ||
        !product_allows_cycle(config->product, host.cycle_us) ||
        host.servo_count > config->product->max_servo)
        abort();
    for (unsigned i = 0; i < host.servo_count; i++)
        if (host.servos[i].type != 0 && wire_slave(plant, &host.servos[i]) >= plant->device_count)
            abort();
    good++;
    buses += host.servo_count > 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct config config;
    size_t products = 0;
    if (size == 0)
        return 0;
    inputs++;
    while (product_at(products) != NULL)
        products++;
    config_parse(&config, product_at(data[0] % products), (const char *)data + 1, size - 1);
    for (size_t i = 0; i < config.problem_count; i++)
        if (strpbrk(config.problems[i].text, "\n\r\x1B") != NULL)
            abort();
    whole_or_nothing(&config);
    return 0;
}
