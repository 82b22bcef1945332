/* SPDX-License-Identifier: GPL-2.0-or-later */
/* tgm config: checks a configuration file and says what it means; lists the keys. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "cli/cli.h"
#include "cli/configuration.h"
#include "conformance/profile.h"
#include "host/servo_wire.h"

/* The profile whose product has a configuration file of that name; several have: the newest PC. */
static const char *profile_for(const char *path)
{
    static const struct {
        const char *begins, *profile;
    } names[] = { { "TGMotion4", "pc4" },
                  { "TgMotion5", "pc5" },
                  { "TGMotion5", "pc5" },
                  { "TGM.INI", "tgmcontroller" } };
    const char *slash = strrchr(path, '/');
    const char *name = slash != NULL ? slash + 1 : path;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strncmp(name, names[i].begins, strlen(names[i].begins)) == 0)
            return names[i].profile;
    return "pc4";
}

static void show_period(const struct config *config, int which)
{
    const int64_t period = config->period_us[which];
    printf("  Program_%02d       ", which + 1);
    if (period != 0)
        printf("every %" PRId64 " us\n", period);
    else
        printf("%s\n", config->product->periods[which].may_be_off ? "off" : "as fast as possible");
}

static const char *device_of(const struct configuration *c, const struct host_servo *servo)
{
    const size_t slave = wire_slave(&c->store.plant, servo);
    return slave == NO_SLAVE ? "nothing on the bus" : c->store.plant.devices[slave].type;
}

static void show_servos(const struct configuration *c)
{
    if (c->config.servo_count == 0)
        printf("  servos           every drive axis on the bus, in bus order\n");
    for (unsigned n = 0; n < c->config.servo_count; n++) {
        const struct host_servo *servo = &c->store.servos[n];
        if (servo->type == 0)
            printf("  SERVO[%u]         virtual\n", n);
        else
            printf("  SERVO[%u]         type %u, node %u, axis %u: %s\n", n, servo->type,
                   servo->node, servo->axis, device_of(c, servo));
    }
}

static void show(const struct configuration *c, const char *path)
{
    const struct config *config = &c->config;
    printf("%s for %s\n", path, config->product->title);
    printf("  Cycle_Time       %" PRId64 " us\n", config->cycle_us);
    for (int i = 0; i < 3; i++)
        show_period(config, i);
    show_servos(c);
    printf("  bus             ");
    for (size_t i = 0; i < c->store.plant.device_count; i++)
        printf(" %s", c->store.plant.devices[i].type);
    printf("%s\n", config->bus[0] == '\0' ? "" : "  (file)");
    printf("  TGM_Data         %" PRId64 " bytes\n", config->data_bytes);
    printf("  TGM_Oscilloscope %" PRId64 " MiB\n", config->osc_mib);
    if (config->faults[0] != '\0')
        printf("  faults           %s\n", c->faults_path);
}

static int list_keys(const struct product *product)
{
    char range[160], fallback[64];
    const char *section = "";
    for (size_t i = 0; config_key(i) != NULL; i++) {
        const struct config_key *key = config_key(i);
        if (!config_key_is_for(key, product))
            continue;
        if (strcmp(section, key->section) != 0)
            printf("%s[%s]\n", section[0] != '\0' ? "\n" : "", key->section);
        section = key->section;
        config_key_range(key, product, range, sizeof range);
        config_key_default(key, product, fallback, sizeof fallback);
        printf("%-30s %s; default %s\n%-30s   %s\n", key->name, range, fallback, "", key->meaning);
    }
    return EXIT_OK;
}

int command_config(const struct command *command, int argc, char **argv)
{
    static struct configuration c;
    struct host_config host = { 0 };
    const char *path = NULL, *name = NULL;
    bool keys = false;
    const struct option table[] = {
        { "--profile", OPTION_TEXT, "NAME",
          "whose configuration it is (default: as the file's name says, otherwise pc4)", &name, 0,
          0 },
        { "--keys", OPTION_FLAG, NULL, "list the keys instead: what they take, and mean", &keys, 0,
          0 },
        { 0 },
    };
    int words, status;
    if (!options_read(command, table, argc, argv, &path, 1, &words, &status))
        return status;
    if (words == 0 && !keys)
        return complain(command, "which file? usage: tgm config %s", command->usage);
    if (name == NULL)
        name = words > 0 ? profile_for(path) : "pc4";
    const struct profile *profile = profile_or_complain(command, name);
    if (profile == NULL)
        return EXIT_CALL;
    if (keys)
        return list_keys(product_find(profile->product));
    status = configuration_open(&c, command, path, product_find(profile->product), &host);
    if (status != 0)
        return status;
    show(&c, path);
    configuration_close(&c);
    return EXIT_OK;
}
