/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * config.h - TG Motion's configuration file: TGMotion4xx.ini, TgMotion5xx.ini, TGM.INI.
 *
 * config_read() reads a file for a product by a table of keys (config_keys.c); a key is a row, and
 * docs/configuration.md is held against the rows. Every problem is collected, not only the first:
 * syntax, unknown keys and sections, keys of other products, values out of range, keys that stand
 * there twice, and what does not fit together. What the documents leave open is decided in
 * docs/decisions.md: C1 (syntax), C2 (names of our own keys), C5 (Resolution), C6 (FeedbackType).
 *
 * A key that is missing has its default. config_apply() puts what was read into a host_config,
 * config_plant() makes the bus that the list of servos asks for.
 */
#ifndef HARNESS_HOST_CONFIG_H
#define HARNESS_HOST_CONFIG_H

#include "host/host.h"

#define CONFIG_SERVOS        256
#define CONFIG_INTERPOLATORS 3
#define CONFIG_PROBLEMS      64
#define CONFIG_TEXT          320
#define CONFIG_VALUE         192 /* longest value that is a text */
#define CONFIG_KEYS          64
#define CONFIG_WHY           512

struct config_problem {
    unsigned line; /* 0: of no single line */
    bool warning;  /* the file can be used nevertheless */
    char text[CONFIG_TEXT];
};

/* Values as they stand in the file, or the defaults. */
struct config_servo {
    int64_t type, node, axis, feedback, resolution;
};

struct config {
    const struct product *product;
    int64_t cycle_us, period_us[3], autostart, log;
    struct config_servo servos[CONFIG_SERVOS];
    unsigned servo_count;
    int64_t interpolator_items[CONFIG_INTERPOLATORS];
    int64_t mode_off, mode_position, mode_pg, mode_gear, mode_pg_gear, mode_interpolator, mode_user;
    int64_t distributed_clock, redundancy;
    int64_t data_bytes, osc_mib, eeprom_bytes, can_kbit;
    int64_t dhcp, ip, mask, gateway, dns; /* addresses: first number in the highest byte */
    int64_t profinet, modbus, modbus_offset, modbus_multiplier;
    int64_t remote_access, led;
    char mac[CONFIG_VALUE];
    char bus[CONFIG_VALUE], faults[CONFIG_VALUE]; /* "" when not given; relative to the file */

    /* In which line a key stands, 0: it does not. Second index: the n of Servo[n]. */
    unsigned line[CONFIG_KEYS][CONFIG_SERVOS];
    struct config_problem problems[CONFIG_PROBLEMS]; /* in order of lines */
    size_t problem_count;                            /* kept; all of them when not more than room */
    unsigned errors, warnings;                       /* all */
};

/* Reads a file; what is wrong in it is among the problems. 0, or negative errno with a reason when
 * it cannot be read at all. */
int config_read(struct config *config, const struct product *product, const char *path,
                char why[CONFIG_WHY]);
/* The same from memory. */
void config_parse(struct config *config, const struct product *product, const char *text,
                  size_t length);

/* What the host of this configuration needs. Members of servos and modes are stored in `store`,
 * which must live as long as the host. What the file does not say is left as it is. */
struct config_store {
    struct host_servo servos[CONFIG_SERVOS];
    struct servo_modes modes;
    struct bus_device devices[BUS_MAX_SLAVES];
    struct plant plant;
};
void config_apply(const struct config *config, struct config_store *store,
                  struct host_config *host);

/* The bus that the list of servos asks for, where no bus file says what stands on it: one drive for
 * every Node, and the terminal of plant_default behind them. Needs config_apply() first. */
const struct plant *config_plant(const struct config *config, struct config_store *store);

/* --- the table --- */

enum config_kind {
    CONFIG_CYCLE,      /* one of the product's Cycle_Times */
    CONFIG_PERIOD,     /* of Program_01 + least */
    CONFIG_NUMBER,     /* least..most, a multiple of step when that is not 0 */
    CONFIG_LIST,       /* one of the values of list */
    CONFIG_TYPE,       /* of a servo, as the product knows them */
    CONFIG_RESOLUTION, /* bits or increments (C5) */
    CONFIG_OSC,        /* MiB, as the product allows */
    CONFIG_ADDRESS,    /* IPv4 */
    CONFIG_MAC,
    CONFIG_FILE
};

/* How many there are of a key with [n] in its name. */
enum config_each { CONFIG_ONE, CONFIG_EACH_SERVO, CONFIG_EACH_INTERPOLATOR };

struct config_key {
    const char *section, *name; /* "Servo_Configuration", "Servo[n].Type" */
    enum config_kind kind;
    enum config_each each;
    unsigned products; /* bit n: row n of product.c */
    int64_t least, most, step;
    const int64_t *list; /* ends with -1 */
    size_t offset;       /* in struct config, of element 0 */
    int64_t fallback;
    const char *source; /* "manual", "headers" or "ours" (decision C2) */
    const char *meaning;
};

/* NULL past the end. */
const struct config_key *config_key(size_t index);
/* Whether the product has the key. */
bool config_key_is_for(const struct config_key *key, const struct product *product);
/* "TGMcontroller, TGZ+Motion"; "all" */
void config_key_products(const struct config_key *key, char *out, size_t size);
/* What it takes on a product, in words: "0 or 1", "1 to 64". */
void config_key_range(const struct config_key *key, const struct product *product, char *out,
                      size_t size);
/* Its default on a product, in words. */
void config_key_default(const struct config_key *key, const struct product *product, char *out,
                        size_t size);
/* Takes a value into its place. False: it is not allowed. */
bool config_key_take(const struct config_key *key, struct config *config, unsigned n,
                     const char *value);
/* Number of elements on the product; 1 for a key without [n]. */
unsigned config_key_count(const struct config_key *key, const struct product *product);
/* Defaults of all keys. */
void config_defaults(struct config *config, const struct product *product);

/* config_check.c: what does not fit together; counts the servos. */
void config_check(struct config *config);
void config_add_problem(struct config *config, unsigned line, bool warning, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

#endif
