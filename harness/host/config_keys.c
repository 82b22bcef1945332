/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The keys of the configuration file: one row each. */
#include "host/config.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* By row of product.c. */
enum { PC4 = 1, PC500 = 2, PC5 = 4, MINI = 8, CONTROLLER = 16, TGZ = 32 };
enum {
    ALL = PC4 | PC500 | PC5 | MINI | CONTROLLER | TGZ,
    SINCE_5 = ALL & ~PC4,
    SINCE_502 = SINCE_5 & ~PC500,
    BOTH = CONTROLLER | TGZ
};

#define AT(member) .offset = offsetof(struct config, member)
#define OURS       .source = "ours"

static const int64_t can_rates[] = { 10, 20, 50, 100, 125, 250, 500, 800, 1000, -1 };

#define ADDRESS(a, b, c, d) ((int64_t)(a) << 24 | (b) << 16 | (c) << 8 | (d))

static const struct config_key keys[] = {
    { "System", "Cycle_Time", CONFIG_CYCLE, .products = ALL, AT(cycle_us), .source = "manual",
      .meaning = "period of servo loop and EtherCAT, us" },
    { "System", "Log", CONFIG_NUMBER, .products = ALL, .most = UINT32_MAX, AT(log),
      .source = "headers; section ours",
      .meaning = "what MAIN.Log_Ctrl is at the start: bits of what is logged" },
    { "PLC_Configuration", "Cycle_Time_Program_01", CONFIG_PERIOD, .products = ALL,
      AT(period_us[0]), .least = 0, .source = "manual", .meaning = "period of Program_01, us" },
    { "PLC_Configuration", "Cycle_Time_Program_02", CONFIG_PERIOD, .products = ALL,
      AT(period_us[1]), .least = 1, .source = "manual", .meaning = "period of Program_02, us" },
    { "PLC_Configuration", "Cycle_Time_Program_03", CONFIG_PERIOD, .products = ALL,
      AT(period_us[2]), .least = 2, .source = "manual", .meaning = "period of Program_03, us" },
    { "PLC_Configuration", "Autostart_PLC", CONFIG_NUMBER, .products = BOTH, .most = 1,
      AT(autostart), .source = "manual",
      .meaning = "1 starts the PLC after boot; the harness always starts it" },
    { "Servo_Configuration", "Servo[n].Type", CONFIG_TYPE, CONFIG_EACH_SERVO, ALL,
      AT(servos[0].type), .fallback = -1, .source = "manual",
      .meaning = "kind of drive; 0 is a virtual servo" },
    { "Servo_Configuration", "Servo[n].Node", CONFIG_NUMBER, CONFIG_EACH_SERVO, ALL, .least = 1,
      .most = 64, AT(servos[0].node), .source = "manual",
      .meaning =
          "station alias, otherwise place on the bus; drives inside the controller have none" },
    { "Servo_Configuration", "Servo[n].Axis", CONFIG_NUMBER, CONFIG_EACH_SERVO, ALL, .least = 1,
      .most = 2, AT(servos[0].axis), .fallback = 1, .source = "manual",
      .meaning = "axis of a drive with two" },
    { "Servo_Configuration", "Servo[n].FeedbackType", CONFIG_NUMBER, CONFIG_EACH_SERVO, CONTROLLER,
      .least = 1, .most = 3, AT(servos[0].feedback), .fallback = 1, .source = "manual",
      .meaning = "of type 92: 1 DSL, 2 EnDat 2.2 (axis 1), 3 SSI (axis 2)" },
    { "Servo_Configuration", "Servo[n].Resolution", CONFIG_RESOLUTION, CONFIG_EACH_SERVO, ALL,
      AT(servos[0].resolution), .source = "manual",
      .meaning = "SERVO.Resolution: up to 64 in bits, otherwise in inc/rev (C5)" },
    { "Interpolator_Configuration", "Interpolator[n].Buffer_Size", CONFIG_NUMBER,
      CONFIG_EACH_INTERPOLATOR, SINCE_5, .least = 500, .most = 50000, AT(interpolator_items[0]),
      .fallback = 2000, .source = "headers; section ours", .meaning = "items of the buffer" },
    { "Interpolator_Configuration", "Interpolator[n].Buffer_Size", CONFIG_NUMBER,
      CONFIG_EACH_INTERPOLATOR, PC4, .least = 1000, .most = 100000, AT(interpolator_items[0]),
      .fallback = 2000, .source = "manual; section ours", .meaning = "items of the buffer" },
    { "Servo_Modes", "Off", CONFIG_NUMBER, .products = ALL, .least = INT32_MIN, .most = INT32_MAX,
      AT(mode_off), .fallback = 0, OURS, .meaning = "SERVO.Mode of an axis that is off" },
    { "Servo_Modes", "Position", CONFIG_NUMBER, .products = ALL, .least = INT32_MIN,
      .most = INT32_MAX, AT(mode_position), .fallback = 1, OURS,
      .meaning = "SERVO.Mode: WritePosition is the set-point" },
    { "Servo_Modes", "PG", CONFIG_NUMBER, .products = ALL, .least = INT32_MIN, .most = INT32_MAX,
      AT(mode_pg), .fallback = 2, OURS, .meaning = "SERVO.Mode: the profile generator" },
    { "Servo_Modes", "Gear", CONFIG_NUMBER, .products = ALL, .least = INT32_MIN, .most = INT32_MAX,
      AT(mode_gear), .fallback = 3, OURS, .meaning = "SERVO.Mode: gear or cam" },
    { "Servo_Modes", "PG_Gear", CONFIG_NUMBER, .products = ALL, .least = INT32_MIN,
      .most = INT32_MAX, AT(mode_pg_gear), .fallback = 4, OURS,
      .meaning = "SERVO.Mode: both together" },
    { "Servo_Modes", "Interpolator", CONFIG_NUMBER, .products = ALL, .least = INT32_MIN,
      .most = INT32_MAX, AT(mode_interpolator), .fallback = 5, OURS,
      .meaning = "SERVO.Mode: the axis of an interpolator" },
    { "Servo_Modes", "User", CONFIG_NUMBER, .products = ALL, .least = INT32_MIN, .most = INT32_MAX,
      AT(mode_user), .fallback = 9, OURS, .meaning = "SERVO.Mode: TransformedPosition" },
    { "EtherCAT", "Distributed_Clock", CONFIG_NUMBER, .products = ALL, .most = 1,
      AT(distributed_clock), .fallback = 1, OURS,
      .meaning = "1: drives are synchronised by SYNC0; MAIN.Distributed_Clock" },
    { "EtherCAT", "Redundancy", CONFIG_NUMBER, .products = ALL, .most = 1, AT(redundancy), OURS,
      .meaning = "1: a second port closes the ring" },
    { "Memory", "Data_Bytes", CONFIG_NUMBER, .products = ALL, .least = DATA_LEAST,
      .most = DATA_MOST, .step = 4096, AT(data_bytes), .fallback = DATA_BYTES, OURS,
      .meaning = "size of TGM_Data" },
    { "Memory", "Oscilloscope_MB", CONFIG_OSC, .products = ALL, AT(osc_mib), OURS,
      .meaning = "size of TGM_Oscilloscope, MiB" },
    { "Memory", "EEPROM_Bytes", CONFIG_NUMBER, .products = ALL, .least = 512, .most = 2752,
      .step = 8, AT(eeprom_bytes), .fallback = 2752, OURS, .meaning = "MAIN.Size_EEPROM_Memory" },
    { "CAN", "BaudRate", CONFIG_LIST, .products = ALL, .list = can_rates, AT(can_kbit),
      .fallback = 500, OURS, .meaning = "MAIN.PLC_CAN_BaudRate, kbit/s" },
    { "Simulation", "Bus", CONFIG_FILE, .products = ALL, AT(bus), OURS,
      .meaning = "what stands on the bus (docs/bus-files.md); default: what the servos ask for" },
    { "Simulation", "Faults", CONFIG_FILE, .products = ALL, AT(faults), OURS,
      .meaning = "what goes wrong on the bus (docs/faults.md)" },
    { "DHCP", "Enable", CONFIG_NUMBER, .products = BOTH, .most = 1, AT(dhcp), .source = "manual",
      .meaning = "1: the address comes by DHCP; no effect here" },
    { "DHCP", "IPAddress", CONFIG_ADDRESS, .products = BOTH, AT(ip),
      .fallback = ADDRESS(192, 168, 1, 188), .source = "manual",
      .meaning = "static address; no effect here" },
    { "DHCP", "Mask", CONFIG_ADDRESS, .products = BOTH, AT(mask),
      .fallback = ADDRESS(255, 255, 255, 0), .source = "manual", .meaning = "no effect here" },
    { "DHCP", "Gateway", CONFIG_ADDRESS, .products = BOTH, AT(gateway),
      .fallback = ADDRESS(192, 168, 1, 1), .source = "manual",
      .meaning = "in the segment of the address; no effect here" },
    { "DHCP", "DNS", CONFIG_ADDRESS, .products = BOTH, AT(dns), .fallback = ADDRESS(8, 8, 8, 8),
      .source = "manual", .meaning = "no effect here" },
    { "DHCP", "MacAddress", CONFIG_MAC, .products = CONTROLLER, AT(mac), .source = "manual",
      .meaning = "no effect here" },
    { "Profinet", "Enable", CONFIG_NUMBER, .products = BOTH, .most = 1, AT(profinet),
      .source = "manual", .meaning = "no effect here" },
    { "Modbus", "Enable", CONFIG_NUMBER, .products = BOTH, .most = 1, AT(modbus),
      .source = "manual", .meaning = "no effect here" },
    { "Modbus", "Offset", CONFIG_NUMBER, .products = BOTH, .most = DATA_MOST - 1, AT(modbus_offset),
      .source = "manual",
      .meaning = "of register 0 in TGM_Data, bytes; divisible by 4 advised; no effect here" },
    { "Modbus", "Multiplier", CONFIG_NUMBER, .products = BOTH, .least = 1, .most = 256,
      AT(modbus_multiplier), .fallback = 4, .source = "manual",
      .meaning = "bytes from one register to the next; no effect here" },
    { "Server", "Enabled", CONFIG_NUMBER, .products = MINI, .most = 1, AT(remote_access),
      .fallback = 1, .source = "manual",
      .meaning = "of tgm_xeno_service.ini: remote access; no effect here" },
    { "LED", "Control", CONFIG_NUMBER, .products = MINI, .most = 1, AT(led), .fallback = 1,
      .source = "manual", .meaning = "of tgm_xeno_service.ini: status LED; no effect here" },
};

#define KEYS (sizeof keys / sizeof *keys)
_Static_assert(KEYS <= CONFIG_KEYS, "struct config has a line for every key");

/* Servo types by the products that know them (motion.md 2). */
static const struct {
    int64_t type;
    unsigned products;
} types[] = {
    { 0, ALL },        { 3, ALL },        { 5, ALL },         { 9, ALL },
    { 51, SINCE_502 }, { 52, SINCE_502 }, { 91, TGZ },        { 92, CONTROLLER },
    { 93, SINCE_502 }, { 94, TGZ },       { 95, CONTROLLER }, { 99, SINCE_502 },
};
#define TYPES (sizeof types / sizeof *types)

const struct config_key *config_key(size_t index)
{
    return index < KEYS ? &keys[index] : NULL;
}

static unsigned product_bit(const struct product *product)
{
    for (unsigned i = 0; product_at(i) != NULL; i++)
        if (product_at(i) == product)
            return 1u << i;
    return 0;
}

bool config_key_is_for(const struct config_key *key, const struct product *product)
{
    return (key->products & product_bit(product)) != 0;
}

unsigned config_key_count(const struct config_key *key, const struct product *product)
{
    switch (key->each) {
    case CONFIG_EACH_SERVO:
        return product->max_servo;
    case CONFIG_EACH_INTERPOLATOR:
        return product->max_interpolator;
    default:
        return 1;
    }
}

/* --- words --- */

/* Adds to a text, ", " or " or " before all but the first. */
static void enumerate(char *out, size_t size, bool last, const char *word)
{
    const size_t at = strlen(out);
    snprintf(out + at, size - at, "%s%s", at == 0 ? "" : last ? " or " : ", ", word);
}

void config_key_products(const struct config_key *key, char *out, size_t size)
{
    out[0] = '\0';
    if (key->products == ALL) {
        snprintf(out, size, "all");
        return;
    }
    for (size_t i = 0; product_at(i) != NULL; i++)
        if (config_key_is_for(key, product_at(i)))
            enumerate(out, size, false, product_at(i)->title);
}

static void types_text(const struct product *product, char *out, size_t size)
{
    size_t last = 0;
    for (size_t i = 0; i < TYPES; i++)
        if (types[i].products & product_bit(product))
            last = i;
    for (size_t i = 0; i < TYPES; i++) {
        char number[24];
        snprintf(number, sizeof number, "%lld", (long long)types[i].type);
        if (types[i].products & product_bit(product))
            enumerate(out, size, i == last, number);
    }
}

static void list_text(const int64_t *list, char *out, size_t size)
{
    for (; *list != -1; list++) {
        char number[24];
        snprintf(number, sizeof number, "%lld", (long long)*list);
        enumerate(out, size, list[1] == -1, number);
    }
}

static void number_text(const struct config_key *key, char *out, size_t size)
{
    if (key->least == 0 && key->most == 1)
        snprintf(out, size, "0 or 1");
    else if (key->step != 0)
        snprintf(out, size, "%lld to %lld in steps of %lld", (long long)key->least,
                 (long long)key->most, (long long)key->step);
    else
        snprintf(out, size, "%lld to %lld", (long long)key->least, (long long)key->most);
}

#define MIB 1048576u

void config_key_range(const struct config_key *key, const struct product *product, char *out,
                      size_t size)
{
    out[0] = '\0';
    switch (key->kind) {
    case CONFIG_CYCLE:
        product_cycles_text(product, out, size);
        break;
    case CONFIG_PERIOD:
        product_periods_text(product, (unsigned)key->least, out, size);
        break;
    case CONFIG_NUMBER:
        number_text(key, out, size);
        break;
    case CONFIG_LIST:
        list_text(key->list, out, size);
        break;
    case CONFIG_TYPE:
        types_text(product, out, size);
        break;
    case CONFIG_RESOLUTION:
        snprintf(out, size, "1 to 31 (bits) or 65 to 4294967295 (inc/rev)");
        break;
    case CONFIG_OSC:
        if (product->osc_least == product->osc_most)
            snprintf(out, size, "only %u", product->osc_most / MIB);
        else
            snprintf(out, size, "%u to %u", product->osc_least / MIB, product->osc_most / MIB);
        break;
    case CONFIG_ADDRESS:
        snprintf(out, size, "an address such as 192.168.1.188");
        break;
    case CONFIG_MAC:
        snprintf(out, size,
                 "six or seven hexadecimal numbers with dots between them, the first 00");
        break;
    case CONFIG_FILE:
        snprintf(out, size, "the name of a file");
        break;
    }
}

static int64_t default_of(const struct config_key *key, const struct product *product)
{
    switch (key->kind) {
    case CONFIG_CYCLE:
        return product->default_cycle_us;
    case CONFIG_PERIOD:
        return product->program_period_us[key->least];
    case CONFIG_OSC:
        return product->osc_bytes / MIB;
    default:
        return key->fallback;
    }
}

void config_key_default(const struct config_key *key, const struct product *product, char *out,
                        size_t size)
{
    const int64_t value = default_of(key, product);
    if (key->kind == CONFIG_ADDRESS)
        snprintf(out, size, "%d.%d.%d.%d", (int)(value >> 24 & 255), (int)(value >> 16 & 255),
                 (int)(value >> 8 & 255), (int)(value & 255));
    else if (key->kind == CONFIG_FILE || key->kind == CONFIG_TYPE)
        snprintf(out, size, "none");
    else if (key->kind == CONFIG_MAC)
        snprintf(out, size, "automatic");
    else if (key->kind == CONFIG_RESOLUTION)
        snprintf(out, size, "the drive's own");
    else if (key->each == CONFIG_EACH_SERVO && value == 0)
        snprintf(out, size, "n + 1");
    else
        snprintf(out, size, "%lld", (long long)value);
}

/* --- values --- */

static bool read_integer(const char *text, int64_t *value)
{
    char *end;
    const char *digits = text + (*text == '-' || *text == '+');
    const bool hex = digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X');
    if (*digits < '0' || *digits > '9')
        return false;
    errno = 0;
    *value = strtoll(text, &end, hex ? 16 : 10);
    return errno == 0 && *end == '\0';
}

static bool read_address(const char *text, int64_t *value)
{
    *value = 0;
    for (int i = 0; i < 4; i++) {
        unsigned part = 0, digits = 0;
        for (; *text >= '0' && *text <= '9' && digits < 4; text++, digits++)
            part = part * 10 + (unsigned)(*text - '0');
        if (digits == 0 || part > 255 || *text != (i < 3 ? '.' : '\0'))
            return false;
        text += i < 3;
        *value = *value << 8 | part;
    }
    return true;
}

static bool is_mac(const char *text)
{
    static const char hex[] = "0123456789abcdefABCDEF";
    unsigned groups = 0;
    if (strncmp(text, "00.", 3) != 0)
        return false;
    for (;; text++) {
        const size_t digits = strspn(text, hex);
        if (digits < 1 || digits > 2)
            return false;
        groups++;
        text += digits;
        if (*text != '.')
            break;
    }
    return *text == '\0' && (groups == 6 || groups == 7);
}

static bool is_listed(const int64_t *list, int64_t value)
{
    for (; *list != -1; list++)
        if (*list == value)
            return true;
    return false;
}

static bool is_type(const struct product *product, int64_t value)
{
    for (size_t i = 0; i < TYPES; i++)
        if (types[i].type == value)
            return (types[i].products & product_bit(product)) != 0;
    return false;
}

static bool is_allowed(const struct config_key *key, const struct product *product, int64_t value)
{
    const bool fits = value >= 0 && value <= UINT32_MAX;
    switch (key->kind) {
    case CONFIG_CYCLE:
        return fits && product_allows_cycle(product, (uint32_t)value);
    case CONFIG_PERIOD:
        return fits && value != PERIOD_OFF &&
               product_allows_period(product, (unsigned)key->least, (uint32_t)value);
    case CONFIG_NUMBER:
        return value >= key->least && value <= key->most &&
               (key->step == 0 || value % key->step == 0);
    case CONFIG_LIST:
        return is_listed(key->list, value);
    case CONFIG_TYPE:
        return is_type(product, value);
    case CONFIG_RESOLUTION:
        return (value >= 1 && value <= 31) || (value > 64 && value <= UINT32_MAX);
    case CONFIG_OSC:
        return value >= product->osc_least / MIB && value <= product->osc_most / MIB;
    case CONFIG_ADDRESS:
    case CONFIG_MAC:
    case CONFIG_FILE:
        break;
    }
    return true;
}

static void *place_of(const struct config_key *key, struct config *config, unsigned n)
{
    static const size_t strides[] = { [CONFIG_ONE] = 0,
                                      [CONFIG_EACH_SERVO] = sizeof(struct config_servo),
                                      [CONFIG_EACH_INTERPOLATOR] = sizeof(int64_t) };
    return (char *)config + key->offset + n * strides[key->each];
}

bool config_key_take(const struct config_key *key, struct config *config, unsigned n,
                     const char *value)
{
    int64_t number = 0;
    if (key->kind == CONFIG_MAC || key->kind == CONFIG_FILE) {
        if (*value == '\0' || strlen(value) >= CONFIG_VALUE ||
            (key->kind == CONFIG_MAC && !is_mac(value)))
            return false;
        strcpy(place_of(key, config, n), value);
        return true;
    }
    if (!(key->kind == CONFIG_ADDRESS ? read_address(value, &number)
                                      : read_integer(value, &number)) ||
        !is_allowed(key, config->product, number))
        return false;
    memcpy(place_of(key, config, n), &number, sizeof number);
    return true;
}

void config_defaults(struct config *config, const struct product *product)
{
    memset(config, 0, sizeof *config);
    config->product = product;
    for (size_t i = 0; i < KEYS; i++) {
        const struct config_key *key = &keys[i];
        const int64_t value = default_of(key, product);
        if (key->kind == CONFIG_MAC || key->kind == CONFIG_FILE)
            continue;
        const unsigned count = config_key_count(key, product);
        for (unsigned n = 0; n < count; n++) {
            const int64_t node = n + 1;
            memcpy(place_of(key, config, n),
                   key->offset == offsetof(struct config, servos[0].node) ? &node : &value,
                   sizeof value);
        }
    }
}
