/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * soem_walk INTERFACE TYPE... - SOEM with its own port for Linux, unmodified, walks over a bus of
 * simulated slaves: scan, SII, mapping, object dictionaries, SDO, OP, process data, an axis that
 * moves, a slave that is brought back. Prints what it finds and, last, "N passed, M failed".
 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "ethercat.h"

#define MAX_SLAVES 32
#define CYCLE_US   1000

struct expectation {
    const char *type, *name;
    uint32_t product;
    unsigned output_bits, input_bits;
    int coe, dc;
    unsigned pdo_entries; /* mapped objects of both directions, gaps included */
};

static const struct expectation expectations[] = {
    { "drive-cia402", "Simulated servo drive CiA 402", 0x04020001, 64, 160, 1, 1, 11 },
    { "dio-8x8", "Simulated DIO 8 in 8 out", 0x00d10808, 8, 8, 0, 0, 0 },
};

static const char hardware[] =
    "simulation: an inertia of one revolution per revolution between two hard stops, with "
    "friction, a home switch, and 2^20 increments; no mains, no motor, no heat";

static const struct expectation *expected[MAX_SLAVES + 1]; /* from 1, as SOEM counts */
static int slaves, passed, failed;
static uint8 iomap[4096];

static ec_slavet slave_list[MAX_SLAVES + 1];
static ec_groupt groups[EC_MAXGROUP];
static int64 dc_time;

/* What SOEM works on; everything it needs room for is ours. */
static ecx_contextt context = {
    .port = &(ecx_portt){ 0 },
    .slavelist = slave_list,
    .slavecount = &(int){ 0 },
    .maxslave = MAX_SLAVES + 1,
    .grouplist = groups,
    .maxgroup = EC_MAXGROUP,
    .esibuf = (uint8[EC_MAXEEPBUF]){ 0 },
    .esimap = (uint32[EC_MAXEEPBITMAP]){ 0 },
    .elist = &(ec_eringt){ 0 },
    .idxstack = &(ec_idxstackT){ 0 },
    .ecaterror = &(boolean){ FALSE },
    .DCtime = &dc_time,
    .SMcommtype = (ec_SMcommtypet[EC_MAX_MAPT]){ 0 },
    .PDOassign = (ec_PDOassignt[EC_MAX_MAPT]){ 0 },
    .PDOdesc = (ec_PDOdesct[EC_MAX_MAPT]){ 0 },
    .eepSM = &(ec_eepromSMt){ 0 },
    .eepFMMU = &(ec_eepromFMMUt){ 0 },
};

static void check(int good, const char *what, int slave)
{
    if (good) {
        passed++;
        return;
    }
    failed++;
    if (slave)
        printf("not ok  slave %d: %s\n", slave, what);
    else
        printf("not ok  %s\n", what);
}

static int32_t sdo_get(int slave, uint16 index, uint8 subindex, int *size)
{
    int32_t value = 0;

    *size = sizeof value;
    if (ecx_SDOread(&context, (uint16)slave, index, subindex, FALSE, size, &value, EC_TIMEOUTRXM) <=
        0)
        *size = 0;
    return value;
}

static int32_t last_abort(void)
{
    ec_errort error;
    int32_t code = 0;

    while (ecx_poperror(&context, &error))
        if (error.Etype == EC_ERR_TYPE_SDO_ERROR)
            code = error.AbortCode;
    return code;
}

/* --- who is there -------------------------------------------------------------------------------
 */

static void walk_sii(int slave)
{
    const struct expectation *e = expected[slave];
    char group[EC_MAXNAME + 1] = "";
    int16 general = ecx_siifind(&context, (uint16)slave, ECT_SII_GENERAL);

    check(strcmp(slave_list[slave].name, e->name) == 0, "name", slave);
    check(slave_list[slave].eep_man == 0x5447534d, "vendor", slave);
    check(slave_list[slave].eep_id == e->product, "product", slave);
    check(slave_list[slave].configadr == 0x1000 + slave, "station address", slave);
    check(ecx_readeeprom(&context, (uint16)slave, ECT_SII_MANUF, EC_TIMEOUTEEP) == 0x5447534d,
          "vendor in the EEPROM", slave);
    check(ecx_readeeprom(&context, (uint16)slave, ECT_SII_ID, EC_TIMEOUTEEP) == e->product,
          "product in the EEPROM", slave);
    check(general > 0, "general category", slave);
    ecx_siistring(&context, group, (uint16)slave,
                  ecx_siigetbyte(&context, (uint16)slave, (uint16)(general + 2)));
    check(strncmp(group, "Simulated ", 10) == 0, "group", slave);
    check((slave_list[slave].hasdc != 0) == e->dc, "distributed clock", slave);
    check(((slave_list[slave].mbx_proto & ECT_MBXPROT_COE) != 0) == e->coe, "CoE", slave);
    printf("%2d  %-32s %08x:%08x:%08x  \"%s\"  0x%04x\n", slave, slave_list[slave].name,
           slave_list[slave].eep_man, slave_list[slave].eep_id, slave_list[slave].eep_rev, group,
           slave_list[slave].configadr);
}

static void walk_mapping(int slave)
{
    unsigned entries = 0, bits[2] = { 0, 0 };

    for (int direction = 0; direction < 2; direction++) {
        uint16 assign = (uint16)(direction ? 0x1c13 : 0x1c12);
        int size, pdos = sdo_get(slave, assign, 0, &size) & 0xff;

        check(size == 1 && pdos == 1, "one PDO a direction", slave);
        for (int i = 1; i <= pdos; i++) {
            uint16 pdo = (uint16)sdo_get(slave, assign, (uint8)i, &size);
            int count = sdo_get(slave, pdo, 0, &size) & 0xff;

            for (int k = 1; k <= count; k++, entries++) {
                uint32_t entry = (uint32_t)sdo_get(slave, pdo, (uint8)k, &size);

                check(size == 4, "mapping entry", slave);
                bits[direction] += entry & 0xff;
                printf("      %s 0x%04x:%d  0x%04x:%02x  %u bits\n", direction ? "in " : "out", pdo,
                       k, entry >> 16, entry >> 8 & 0xff, entry & 0xff);
            }
        }
    }
    check(entries == expected[slave]->pdo_entries, "number of mapped objects", slave);
    check(bits[0] == expected[slave]->output_bits, "mapped output bits", slave);
    check(bits[1] == expected[slave]->input_bits, "mapped input bits", slave);
}

static void walk_object(int slave, ec_ODlistt *list, uint16 item, unsigned *read, unsigned *refused)
{
    static ec_OElistt entries;

    check(ecx_readODdescription(&context, item, list) > 0 && list->Name[item][0] != '\0',
          "object description", slave);
    memset(&entries, 0, sizeof entries);
    check(ecx_readOE(&context, item, list, &entries) > 0, "entry descriptions", slave);
    for (unsigned sub = 0; sub <= list->MaxSub[item]; sub++) {
        char value[512];
        int size = sizeof value;

        if (entries.DataType[sub] == 0 || !(entries.ObjAccess[sub] & 0x3f))
            continue;
        if (ecx_SDOread(&context, (uint16)slave, list->Index[item], (uint8)sub, FALSE, &size, value,
                        EC_TIMEOUTRXM) <= 0) {
            ++*refused;
            continue;
        }
        ++*read;
        check(size * 8 == entries.BitLength[sub] || entries.DataType[sub] == ECT_VISIBLE_STRING,
              "a value as long as its entry says", slave);
    }
    printf("      0x%04x  %-28s max sub %d\n", list->Index[item], list->Name[item],
           list->MaxSub[item]);
}

static void walk_dictionary(int slave)
{
    static ec_ODlistt list;
    unsigned read = 0, refused = 0;

    memset(&list, 0, sizeof list);
    check(ecx_readODlist(&context, (uint16)slave, &list) > 0, "object list", slave);
    check(list.Entries >= 40, "length of the object list", slave);
    for (uint16 i = 0; i < list.Entries; i++)
        walk_object(slave, &list, i, &read, &refused);
    check(read > 100, "values read", slave);
    check(refused == 0, "no value refused", slave);
    printf("      %d objects, %u values\n", list.Entries, read);
}

static void walk_sdo(int slave)
{
    struct {
        uint8 count, pad;
        uint32_t value[4];
    } __attribute__((packed)) identity = { 0 };
    char text[512] = "";
    int size = sizeof identity;
    uint32_t velocity = 123456, rubbish = 1;

    check(ecx_SDOread(&context, (uint16)slave, 0x1018, 0, TRUE, &size, &identity, EC_TIMEOUTRXM) >
                  0 &&
              size == sizeof identity && identity.count == 4 &&
              identity.value[0] == slave_list[slave].eep_man &&
              identity.value[1] == slave_list[slave].eep_id,
          "identity by complete access", slave);
    size = sizeof text;
    check(ecx_SDOread(&context, (uint16)slave, 0x1009, 0, FALSE, &size, text, EC_TIMEOUTRXM) > 0 &&
              size == (int)sizeof hardware - 1 && memcmp(text, hardware, sizeof hardware - 1) == 0,
          "a text in segments", slave);
    check(ecx_SDOwrite(&context, (uint16)slave, 0x6081, 0, FALSE, 4, &velocity, EC_TIMEOUTRXM) >
                  0 &&
              sdo_get(slave, 0x6081, 0, &size) == 123456 && size == 4,
          "a value written and read back", slave);
    last_abort();
    check(ecx_SDOwrite(&context, (uint16)slave, 0x6041, 0, FALSE, 2, &rubbish, EC_TIMEOUTRXM) <=
                  0 &&
              last_abort() == 0x06010002,
          "a write to a read-only object is aborted", slave);
    sdo_get(slave, 0x5fff, 0, &size);
    check(size == 0 && last_abort() == 0x06020000, "a missing object is aborted", slave);
    sdo_get(slave, 0x1018, 9, &size);
    check(size == 0 && last_abort() == 0x06090011, "a missing subindex is aborted", slave);
}

/* --- process data --------------------------------------------------------------------------------
 */

static int lost, short_counters;

static void cycle(void)
{
    int wkc;

    ecx_send_processdata(&context);
    wkc = ecx_receive_processdata(&context, EC_TIMEOUTRET);
    if (wkc < 0)
        lost++;
    else if (wkc != groups[0].outputsWKC * 2 + groups[0].inputsWKC)
        short_counters++;
    osal_usleep(CYCLE_US);
}

static uint16_t statusword(int slave)
{
    return (uint16_t)(slave_list[slave].inputs[0] | slave_list[slave].inputs[1] << 8);
}

static int32_t actual(int slave)
{
    int32_t value;

    memcpy(&value, slave_list[slave].inputs + 4, sizeof value);
    return value;
}

static void command(int slave, uint16_t controlword, int32_t target)
{
    uint8 *out = slave_list[slave].outputs;

    memcpy(out, &controlword, sizeof controlword);
    out[2] = 8; /* CSP */
    memcpy(out + 4, &target, sizeof target);
}

static void to_op(void)
{
    int tries = 4000;

    cycle();
    slave_list[0].state = EC_STATE_OPERATIONAL;
    ecx_writestate(&context, 0);
    do {
        cycle();
        if (tries % 20 == 0)
            ecx_readstate(&context);
    } while (slave_list[0].state != EC_STATE_OPERATIONAL && --tries > 0);
    for (int i = 1; i <= slaves; i++)
        check(slave_list[i].state == EC_STATE_OPERATIONAL, "OP", i);
}

static void enable(int slave)
{
    static const struct {
        uint16_t control, mask, status;
    } steps[] = { { 6, 0x6f, 0x21 }, { 7, 0x6f, 0x23 }, { 15, 0x6f, 0x27 } };

    for (unsigned i = 0; i < 3; i++) {
        int tries = 500;

        do {
            command(slave, steps[i].control, actual(slave));
            cycle();
        } while ((statusword(slave) & steps[i].mask) != steps[i].status && --tries > 0);
        check(tries > 0, "a step of enabling", slave);
    }
}

static void move(int slave)
{
    int32_t begin = actual(slave), target = begin;

    for (int i = 0; i < 500; i++) {
        target += 500;
        command(slave, 15, target);
        cycle();
    }
    for (int i = 0; i < 300; i++)
        cycle();
    check(actual(slave) - begin > 500 * 500 - 300 && actual(slave) - begin < 500 * 500 + 300,
          "the axis is where it was sent", slave);
    check((statusword(slave) & 0x6f) == 0x27, "still enabled", slave);
    printf("    axis of slave %d moved from %d to %d\n", slave, begin, actual(slave));
}

static void exchange_bits(int slave)
{
    unsigned seen = 0;

    for (int i = 0; i < 500; i++) {
        slave_list[slave].outputs[0] = (uint8)(i < 499 ? i : 0xa5);
        cycle();
        seen |= 1u << (slave_list[slave].inputs[0] & 1);
        check((slave_list[slave].inputs[0] & 0xfe) == 0, "inputs that nobody drives", slave);
    }
    check(seen == 3, "input 0 goes on and off", slave);
    cycle();
    uint8 pins = 0;
    check(ecx_FPRD(context.port, slave_list[slave].configadr, 0x0f10, 1, &pins, EC_TIMEOUTRET) == 1 &&
              pins == 0xa5,
          "the pins do what was sent", slave);
}

static void check_clock(void)
{
    int64 before, after;
    uint32_t difference = 0;
    int slave = 1;

    while (slave <= slaves && !slave_list[slave].hasdc)
        slave++;
    if (slave > slaves)
        return;
    before = dc_time;
    for (int i = 0; i < 100; i++)
        cycle();
    after = dc_time;
    check(after - before > 100 * CYCLE_US * 1000, "the reference clock goes", slave);
    for (int i = slave + 1; i <= slaves; i++) {
        if (!slave_list[i].hasdc)
            continue;
        check(ecx_FPRD(context.port, slave_list[i].configadr, 0x092c, 4, &difference,
                       EC_TIMEOUTRET) == 1 &&
                  (difference & 0x7fffffff) < 100000,
              "its clock follows the reference", i);
    }
}

static void reconfigure(int slave)
{
    int tries = 500;

    slave_list[slave].state = EC_STATE_INIT;
    ecx_writestate(&context, (uint16)slave);
    check(ecx_statecheck(&context, (uint16)slave, EC_STATE_INIT, EC_TIMEOUTSTATE) == EC_STATE_INIT,
          "INIT", slave);
    check(ecx_reconfig_slave(&context, (uint16)slave, EC_TIMEOUTSTATE) == EC_STATE_SAFE_OP,
          "configured again up to SAFEOP", slave);
    slave_list[slave].state = EC_STATE_OPERATIONAL;
    ecx_writestate(&context, (uint16)slave);
    do {
        cycle();
        if (tries % 20 == 0)
            ecx_readstate(&context);
    } while (slave_list[slave].state != EC_STATE_OPERATIONAL && --tries > 0);
    check(tries > 0, "OP again", slave);
    check(ecx_recover_slave(&context, (uint16)slave, EC_TIMEOUTRET3) > 0, "it is where it was",
          slave);
    short_counters = 0;
    for (int i = 0; i < 100; i++)
        cycle();
}

static void process_data(void)
{
    int bytes = ecx_config_map_group(&context, iomap, 0);
    unsigned bits = 0;

    for (int i = 1; i <= slaves; i++) {
        check(slave_list[i].Obits == expected[i]->output_bits, "output bits", i);
        check(slave_list[i].Ibits == expected[i]->input_bits, "input bits", i);
        bits += expected[i]->output_bits + expected[i]->input_bits;
    }
    check(bytes == (int)bits / 8, "size of the process image", 0);
    check(ecx_configdc(&context) == TRUE, "distributed clocks", 0);
    check(ecx_statecheck(&context, 0, EC_STATE_SAFE_OP, EC_TIMEOUTSTATE) == EC_STATE_SAFE_OP,
          "SAFEOP", 0);
    to_op();
    short_counters = lost = 0;
    check_clock();
    for (int i = 1; i <= slaves; i++) {
        if (expected[i]->coe) {
            enable(i);
            move(i);
        } else {
            exchange_bits(i);
        }
    }
    check(short_counters == 0, "every working counter as expected", 0);
    reconfigure(1);
    check(short_counters == 0, "every working counter as expected, afterwards", 0);
    printf("    wkc %d, %d frames late\n", groups[0].outputsWKC * 2 + groups[0].inputsWKC, lost);
    check(lost < 20, "frames come back", 0);
}

static int expect_types(int count, char **types)
{
    for (int i = 0; i < count && i < MAX_SLAVES; i++) {
        for (size_t k = 0; k < sizeof expectations / sizeof *expectations; k++)
            if (strcmp(expectations[k].type, types[i]) == 0)
                expected[i + 1] = &expectations[k];
        if (!expected[i + 1])
            return 0;
    }
    return count > 0 && count <= MAX_SLAVES;
}

int main(int argc, char **argv)
{
    if (argc < 3 || !expect_types(argc - 2, argv + 2)) {
        fprintf(stderr, "usage: soem_walk INTERFACE TYPE...\n");
        return 2;
    }
    if (!ecx_init(&context, argv[1])) {
        fprintf(stderr, "soem_walk: no socket on %s\n", argv[1]);
        return 2;
    }
    slaves = ecx_config_init(&context, FALSE);
    check(slaves == argc - 2, "number of slaves", 0);
    if (slaves == argc - 2) {
        check(ecx_statecheck(&context, 0, EC_STATE_PRE_OP, EC_TIMEOUTSTATE) == EC_STATE_PRE_OP,
              "PREOP", 0);
        for (int i = 1; i <= slaves; i++) {
            walk_sii(i);
            if (!expected[i]->coe)
                continue;
            walk_mapping(i);
            walk_sdo(i);
            if (i == 1)
                walk_dictionary(i);
        }
        process_data();
        slave_list[0].state = EC_STATE_INIT;
        ecx_writestate(&context, 0);
    }
    ecx_close(&context);
    printf("%d passed, %d failed\n", passed, failed);
    return failed != 0;
}
