/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What TG Motion does for a module beside the process data: handshakes, I/O units, general devices,
 * system registers, the console's memory. */
#include "tests/host_rig.h"

#include "host/channel.h"
#include "host/console.h"
#include "host/drive_error.h"

#define PRODUCTS 3

/* The three layouts. */
static const struct product *product(size_t p)
{
    static const char *const names[PRODUCTS] = { "pc4", "pc500", "pc5" };
    return product_find(names[p]);
}

#define EACH_PRODUCT(p) for (size_t p = 0; p < PRODUCTS; p++)

static struct rig *open_plant(size_t p, const char *module, const struct plant *plant,
                              const char *faults)
{
    const struct host_config config = {
        .product = product(p), .plant = plant, .faults = faults, .faults_name = "faults"
    };
    return rig_open(module, &config);
}

static void go_to_op(struct rig *rig)
{
    rig_start(rig);
    for (unsigned i = 0; i < 2000; i++) {
        if (rig->evidence.all_op)
            return;
        rig_cycles(rig, 1);
    }
    fail_msg("the bus does not reach OP");
}

/* --- SDO and register channels --- */

static void a_module_reads_and_writes_objects_by_sdo(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_plant(p, "asks", NULL, NULL);
        go_to_op(rig);
        rig_until(rig, "DATA.I32[0]", 5, 2000);
        assert_true(rig_get(rig, "DATA.I32[4]") == rig_get(rig, "SERVO[0].Resolution"));
        assert_true(rig_get(rig, "DATA.I32[8]") == -1);
        assert_true((uint32_t)rig_get(rig, "DATA.I32[12]") == 0x06020000 ||
                    rig_get(rig, "DATA.I32[12]") == 0x06020000);
        assert_true(rig_get(rig, "DATA.I32[16]") == 12345);
        rig_close(rig);
    }
}

static void ask(struct rig *rig, const char *group, int control, int index, int subindex,
                int length)
{
    char name[64];
    const struct {
        const char *member;
        int value;
    } words[] = { { "NumberByte", length },
                  { "Index", index },
                  { "SubIndex", subindex },
                  { "Control", control } };
    for (size_t i = 0; i < 4; i++) {
        snprintf(name, sizeof name, "%s.%s", group, words[i].member);
        if (subindex >= 0 || i != 2)
            rig_set(rig, name, words[i].value);
    }
}

static double word(struct rig *rig, const char *group, const char *member)
{
    char name[64];
    snprintf(name, sizeof name, "%s.%s", group, member);
    return rig_get(rig, name);
}

/* Status is 1 from when a request is taken until Control is 0 again. */
static unsigned wait_sdo(struct rig *rig, const char *group, unsigned most)
{
    rig_cycles(rig, 1);
    for (unsigned i = 1; i < most; i++) {
        if (word(rig, group, "Control") == 0)
            return i;
        assert_true(word(rig, group, "Status") == 1);
        rig_cycles(rig, 1);
    }
    fail_msg("%s is not answered in %u cycles", group, most);
    return 0;
}

static void a_request_is_busy_until_control_is_zero(void **state)
{
    (void)state;
    struct rig *rig = open_plant(0, "idle", NULL, NULL);
    go_to_op(rig);
    rig_set(rig, "SERVO[0].Sdo.Data", -1);
    ask(rig, "SERVO[0].Sdo", 2, 0x6041, 0, 2);
    assert_true(wait_sdo(rig, "SERVO[0].Sdo", 200) > 1);
    assert_true(word(rig, "SERVO[0].Sdo", "Status") == 0);
    /* A value of two bytes is a number of four: nothing of the old one is left. */
    assert_true(word(rig, "SERVO[0].Sdo", "Data") == rig_get(rig, "SERVO[0].StatusWord"));
    rig_close(rig);
}

static void what_cannot_be_asked_ends_with_a_code(void **state)
{
    static const struct {
        int control, index, subindex, length;
        uint32_t code;
    } rows[] = {
        { 3, 0x6041, 0, 2, CHANNEL_BAD_COMMAND },   { 2, 0x16041, 0, 2, CHANNEL_NO_OBJECT },
        { 2, 0x6041, 256, 2, CHANNEL_NO_SUBINDEX }, { 2, 0x6041, 0, 3, CHANNEL_BAD_LENGTH },
        { 2, 0x6041, 0, 0, CHANNEL_BAD_LENGTH },    { 1, 0x6041, 0, 128, CHANNEL_BAD_LENGTH },
        { 2, 0x6064, 0, 1, CHANNEL_TOO_LONG },
    };
    (void)state;
    struct rig *rig = open_plant(0, "idle", NULL, NULL);
    go_to_op(rig);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        ask(rig, "SERVO[0].Sdo", rows[i].control, rows[i].index, rows[i].subindex, rows[i].length);
        wait_sdo(rig, "SERVO[0].Sdo", 200);
        assert_true(word(rig, "SERVO[0].Sdo", "Status") == -1);
        assert_true(word(rig, "SERVO[0].Sdo", "Data") == (double)(int32_t)rows[i].code);
    }
    rig_close(rig);
}

/* dio-8x8 has no mailbox; its failures are counted. */
static void a_slave_without_mailbox_refuses_and_counts(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_plant(p, "idle", NULL, NULL);
        go_to_op(rig);
        for (int i = 1; i <= 3; i++) {
            ask(rig, "DIO[0].Sdo", 2, 0x1018, 1, 4);
            wait_sdo(rig, "DIO[0].Sdo", 200);
            assert_true(word(rig, "DIO[0].Sdo", "Data") == CHANNEL_NO_MAILBOX);
            assert_true(rig_get(rig, "DIO[0].sdoResponseTries") == i);
        }
        rig_close(rig);
    }
}

static void registers_of_the_slave_controller_are_read_and_written(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_plant(p, "idle", NULL, NULL);
        go_to_op(rig);
        ask(rig, "DIO[0].ecatRegister", 2, 0x0130, -1, 7); /* AL status; 7 becomes 4 */
        rig_cycles(rig, 1);
        assert_true(word(rig, "DIO[0].ecatRegister", "Control") == 4);
        assert_true(word(rig, "DIO[0].ecatRegister", "NumberByte") == 4);
        rig_until(rig, "DIO[0].ecatRegister.Control", 0, 100);
        assert_true(((int)word(rig, "DIO[0].ecatRegister", "Data") & 0xFFFF) == 8);

        /* Watchdog divider */
        rig_set(rig, "SERVO[0].ecatRegister.Data", 0x1234);
        ask(rig, "SERVO[0].ecatRegister", 1, 0x0400, -1, 2);
        rig_until(rig, "SERVO[0].ecatRegister.Control", 0, 100);
        rig_set(rig, "SERVO[0].ecatRegister.Data", 0);
        ask(rig, "SERVO[0].ecatRegister", 2, 0x0400, -1, 2);
        rig_until(rig, "SERVO[0].ecatRegister.Control", 0, 100);
        assert_true(word(rig, "SERVO[0].ecatRegister", "Data") == 0x1234);
        rig_close(rig);
    }
}

static void a_bad_register_is_an_error_and_the_next_request_is_taken(void **state)
{
    (void)state;
    struct rig *rig = open_plant(2, "idle", NULL, NULL);
    go_to_op(rig);
    rig_set(rig, "SERVO[0].ecatRegister.Data", 77);
    ask(rig, "SERVO[0].ecatRegister", 2, 0x10000, -1, 1);
    rig_cycles(rig, 1);
    assert_true(word(rig, "SERVO[0].ecatRegister", "Control") == 3);
    assert_true(word(rig, "SERVO[0].ecatRegister", "Data") == 0);
    ask(rig, "SERVO[0].ecatRegister", 2, 0x0130, -1, 1);
    rig_until(rig, "SERVO[0].ecatRegister.Control", 0, 100);
    assert_true(((int)word(rig, "SERVO[0].ecatRegister", "Data") & 0x0F) == 8);
    rig_close(rig);
}

static void all_channels_at_once_are_answered(void **state)
{
    (void)state;
    struct rig *rig = open_plant(2, "idle", NULL, NULL);
    go_to_op(rig);
    ask(rig, "SERVO[0].Sdo", 2, 0x1018, 1, 4);
    ask(rig, "SERVO[0].ecatRegister", 2, 0x0000, -1, 1);
    ask(rig, "DIO[0].Sdo", 2, 0x1018, 1, 4);
    ask(rig, "DIO[0].ecatRegister", 2, 0x0000, -1, 1);
    rig_until(rig, "SERVO[0].Sdo.Control", 0, 200);
    rig_until(rig, "SERVO[0].ecatRegister.Control", 0, 200);
    rig_until(rig, "DIO[0].Sdo.Control", 0, 200);
    rig_until(rig, "DIO[0].ecatRegister.Control", 0, 200);
    assert_true(word(rig, "SERVO[0].Sdo", "Status") == 0);
    assert_true(word(rig, "SERVO[0].Sdo", "Data") != 0);
    assert_true(word(rig, "DIO[0].Sdo", "Status") == -1);
    rig_close(rig);
}

static void requests_to_a_slave_that_is_gone_end_with_an_error(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_plant(p, "idle", NULL, "at 600ms power off 1");
        rig_start(rig);
        rig_cycles(rig, 1198);
        ask(rig, "SERVO[0].Sdo", 2, 0x1018, 1, 4); /* on its way when the power goes */
        rig_until(rig, "SERVO[0].Sdo.Control", 0, 3000);
        assert_true(word(rig, "SERVO[0].Sdo", "Status") == -1 ||
                    word(rig, "SERVO[0].Sdo", "Status") == 0);
        rig_until(rig, "SERVO[0].EtherCATState", 0, 3000);
        ask(rig, "SERVO[0].Sdo", 2, 0x1018, 1, 4);
        ask(rig, "SERVO[0].ecatRegister", 2, 0x0130, -1, 2);
        rig_cycles(rig, 1); /* known to be gone: at once */
        assert_true(word(rig, "SERVO[0].Sdo", "Control") == 0);
        assert_true(word(rig, "SERVO[0].Sdo", "Data") == CHANNEL_TIMEOUT);
        assert_true(word(rig, "SERVO[0].ecatRegister", "Control") == 3);
        rig_close(rig);
    }
}

static void a_silent_mailbox_ends_with_a_timeout(void **state)
{
    (void)state;
    struct rig *rig = open_plant(0, "idle", NULL, "at 500ms mailbox 1 silent for 900ms");
    rig_start(rig);
    rig_cycles(rig, 1001);
    ask(rig, "SERVO[0].Sdo", 2, 0x1018, 1, 4);
    const unsigned cycles = wait_sdo(rig, "SERVO[0].Sdo", 3000);
    assert_true(cycles > 1000);
    assert_true(word(rig, "SERVO[0].Sdo", "Status") == -1);
    assert_true(word(rig, "SERVO[0].Sdo", "Data") == CHANNEL_TIMEOUT);
    assert_true(rig_get(rig, "SERVO[0].EtherCATState") == 8); /* process data went on */
    rig_cycles(rig, 1000);
    ask(rig, "SERVO[0].Sdo", 2, 0x1018, 1, 4);
    wait_sdo(rig, "SERVO[0].Sdo", 3000);
    assert_true(word(rig, "SERVO[0].Sdo", "Status") == 0);
    rig_close(rig);
}

/* --- SERVO.Error --- */

static void the_code_of_a_fault_becomes_a_bit(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_plant(p, "idle", NULL, "at 600ms drive 1 fault 0x3210");
        go_to_op(rig);
        rig_until(rig, "SERVO[0].Status", 1, 2000);
        assert_true(rig_get(rig, "SERVO[0].Error") == (double)DRIVE_ERROR_OTHER);
        rig_until(rig, "SERVO[0].Error", 0x8, 100);
        rig_set(rig, "SERVO[0].Control", 1);
        rig_until(rig, "SERVO[0].Status", 2, 1000);
        assert_true(rig_get(rig, "SERVO[0].Error") == 0);
        rig_close(rig);
    }
}

static void codes_map_to_the_documented_bits(void **state)
{
    static const struct {
        uint16_t code;
        uint32_t bit;
    } rows[] = { { 0x7305, 0x1 },     { 0x7306, 0x2 },      { 0x3220, 0x4 },     { 0x3211, 0x8 },
                 { 0x4210, 0x80 },    { 0x4310, 0x40 },     { 0x8611, 0x10000 }, { 0x8130, 0x400 },
                 { 0x2320, 0x40000 }, { 0x2350, 0x800 },    { 0x6100, 0x80000 }, { 0x5530, 0x200 },
                 { 0x5430, 0x40000 }, { 0xFF01, 1u << 31 }, { 0x0000, 1u << 31 } };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        assert_int_equal(drive_error_bit(rows[i].code), rows[i].bit);
}

/* --- I/O units --- */

static const struct bus_device analog_devices[] = {
    { .type = "drive-cia402" }, { .type = "ai-2" },  { .type = "ao-2" },
    { .type = "strain-1" },     { .type = "di-16" }, { .type = "do-16" },
};
static const struct plant analog_plant = {
    .devices = analog_devices, .device_count = 6, .servos = 1, .dios = 5
};

static const struct bus_stimulus level = { .bit = 1, .kind = BUS_CONSTANT, .offset = -1234 };
static const struct bus_stimulus weight = { .bit = 0, .kind = BUS_CONSTANT, .offset = 700000 };
static const struct bus_stimulus contact = { .bit = 9, .kind = BUS_CONSTANT, .offset = 1 };

static void analog_values_and_gauges_have_their_own_registers(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct bus_device devices[6];
        struct plant plant = analog_plant;
        memcpy(devices, analog_devices, sizeof devices);
        devices[1].stimuli = &level, devices[1].stimulus_count = 1;
        devices[3].stimuli = &weight, devices[3].stimulus_count = 1;
        devices[4].stimuli = &contact, devices[4].stimulus_count = 1;
        plant.devices = devices;
        struct rig *rig = open_plant(p, "idle", &plant, NULL);
        go_to_op(rig);
        rig_cycles(rig, 20);
        assert_true(rig_get(rig, "DIO[0].NumberAI") == 2);
        assert_true(rig_get(rig, "DIO[0].NumberIn") == 0); /* its status bytes are none */
        assert_true(rig_get(rig, "DIO[0].AI[0]") == 0);
        assert_true(rig_get(rig, "DIO[0].AI[1]") == -1234);
        assert_true(rig_get(rig, "DIO[1].NumberAO") == 2);
        assert_true(rig_get(rig, "DIO[2].Number_MeasureAmpl") == 1);
        assert_true(rig_get(rig, "DIO[2].NumberAI") == 0);
        assert_true(rig_get(rig, "DIO[2].Ext_MeasureAmpl[0]") == 700000);
        assert_true(rig_get(rig, "DIO[3].NumberIn") == 2);
        assert_true(rig_get(rig, "DIO[4].NumberOut") == 2);
        if (p == 0) {
            assert_true(rig_get(rig, "DIO[3].In0") == 0);
            assert_true(rig_get(rig, "DIO[3].In1") == 2);
        } else {
            assert_true(rig_get(rig, "DIO[3].In[0]") == 0x200);
        }
        /* Analog outputs stand at the clamps: the terminal tells by SDO. */
        rig_set(rig, "DIO[1].AO[1]", -321);
        rig_cycles(rig, 4);
        ask(rig, "DIO[1].Sdo", 2, 0x3002, 1, 2);
        wait_sdo(rig, "DIO[1].Sdo", 200);
        assert_true(word(rig, "DIO[1].Sdo", "Status") == 0);
        assert_true((int16_t)(int)word(rig, "DIO[1].Sdo", "Data") == -321);
        rig_close(rig);
    }
}

static void a_fault_of_an_io_unit_stays_until_it_is_reset(void **state)
{
    (void)state;
    struct rig *rig =
        open_plant(2, "idle", &analog_plant,
                   "at 600ms drop 2 to SAFEOP code 0x001B\nat 800ms drop 2 to SAFEOP code 0x001D");
    go_to_op(rig);
    rig_set(rig, "DIO[0].Control", 1); /* nothing to reset: taken back */
    rig_cycles(rig, 2);
    assert_true(rig_get(rig, "DIO[0].Control") == 0);
    rig_until(rig, "DIO[0].Error", 0x1B, 2000);
    rig_until(rig, "DIO[0].Status", 1, 2000); /* brought back */
    rig_until(rig, "DIO[0].Status", 0, 2000); /* and down again */
    rig_until(rig, "DIO[0].Status", 1, 2000);
    assert_true(rig_get(rig, "DIO[0].Error") == 0x1B);
    rig_set(rig, "DIO[0].Control", 1);
    rig_cycles(rig, 1);
    assert_true(rig_get(rig, "DIO[0].Error") == 0);
    assert_true(rig_get(rig, "DIO[0].Control") == 0);
    rig_close(rig);
}

/* --- general devices --- */

#define GENERAL(member) "GENERAL.general_devices[0]." member

/* No I/O units are announced: the terminals are general devices. */
static const struct bus_device general_devices[] = { { .type = "dio-8x8" }, { .type = "ai-2" } };
static const struct plant general_plant = { .devices = general_devices, .device_count = 2 };

static void set_sizes(struct rig *rig, int out, int in, int options)
{
    rig_set(rig, GENERAL("bUseLRW"), options);
    rig_set(rig, GENERAL("User_PDO_Output_Size"), out);
    rig_set(rig, GENERAL("User_PDO_Input_Size"), in);
}

static void what_is_no_io_unit_is_a_general_device(void **state)
{
    (void)state;
    for (size_t p = 1; p < PRODUCTS; p++) {
        struct rig *rig = open_plant(p, "idle", &general_plant, NULL);
        go_to_op(rig);
        rig_cycles(rig, 1);
        assert_true(rig_get(rig, GENERAL("VendorID")) != 0);
        assert_true(rig_get(rig, GENERAL("EtherCATState")) == 8);
        assert_true(rig_get(rig, "GENERAL.general_devices[1].ProductID") == 0x00A10200);
        assert_true(rig_get(rig, "GENERAL.general_devices[1].DeviceIndex") == 1);
        assert_true(rig_get(rig, "GENERAL.general_devices[1].ECATBusPosition") == 1);
        /* The inputs of both come behind the one byte of outputs. */
        assert_true(rig_get(rig, GENERAL("logicalWriteAddress")) == 0);
        assert_true(rig_get(rig, GENERAL("logicalReadAddress")) == 1);
        assert_true(rig_get(rig, "GENERAL.general_devices[1].logicalReadAddress") == 2);
        assert_true(rig_get(rig, "GENERAL.general_devices[2].VendorID") == 0);
        rig_close(rig);
    }
}

static void output_reaches_the_device(struct rig *rig, int value, bool expected)
{
    /* Digital outputs are at 0x0F00 of this slave controller. */
    rig_cycles(rig, 4);
    rig_set(rig, GENERAL("NumberByte"), 1);
    rig_set(rig, GENERAL("RegisterIndex"), 0x0F00);
    rig_set(rig, GENERAL("Control"), 2);
    rig_until(rig, GENERAL("Control"), 0, 100);
    assert_int_equal((int)rig_get(rig, GENERAL("Data[0]")) == value, expected);
}

static void process_data_go_by_the_options(void **state)
{
    (void)state;
    for (size_t p = 1; p < PRODUCTS; p++) {
        struct bus_device devices[2];
        struct plant plant = general_plant;
        memcpy(devices, general_devices, sizeof devices);
        static const struct bus_stimulus on = { .bit = 3, .kind = BUS_CONSTANT, .offset = 1 };
        devices[0].stimuli = &on, devices[0].stimulus_count = 1;
        plant.devices = devices;
        struct rig *rig = open_plant(p, "idle", &plant, NULL);
        go_to_op(rig);
        rig_cycles(rig, 3);
        assert_true(rig_get(rig, GENERAL("read_wkc")) == 0); /* no sizes: nothing is exchanged */
        assert_true(rig_get(rig, GENERAL("User_PDO_Input[0]")) == 0);
        set_sizes(rig, 1, 1, 0);
        rig_cycles(rig, 3);
        assert_true(rig_get(rig, GENERAL("read_wkc")) == 1);
        assert_true(rig_get(rig, GENERAL("write_wkc")) == 1);
        assert_true(rig_get(rig, GENERAL("read_write_wkc")) == 0);
        assert_true(rig_get(rig, GENERAL("User_PDO_Input[0]")) == 8);
        set_sizes(rig, 1, 1, 1);
        rig_cycles(rig, 3);
        assert_true(rig_get(rig, GENERAL("read_wkc")) == 0);
        assert_true(rig_get(rig, GENERAL("read_write_wkc")) == 3);
        set_sizes(rig, 1, 2, 1); /* one datagram has one length */
        rig_cycles(rig, 3);
        assert_true(rig_get(rig, GENERAL("read_write_wkc")) == 0);
        set_sizes(rig, 1, 1, 0);
        rig_set(rig, GENERAL("User_PDO_Output[0]"), 0x5A);
        output_reaches_the_device(rig, 0x5A, true);
        rig_close(rig);
    }
}

static void locks_hand_process_data_over(void **state)
{
    (void)state;
    struct rig *rig = open_plant(2, "idle", &general_plant, NULL);
    go_to_op(rig);
    set_sizes(rig, 1, 1, 0x0C);
    rig_set(rig, GENERAL("User_PDO_Output[0]"), 0x11);
    rig_cycles(rig, 5);
    output_reaches_the_device(rig, 0x11, false); /* not handed over */
    rig_set(rig, GENERAL("PLC_Send_Lock_Value"), 1);
    rig_cycles(rig, 1);
    assert_true(rig_get(rig, GENERAL("TGM_Send_Lock_Value")) == 1);
    output_reaches_the_device(rig, 0x11, true);

    const double given = rig_get(rig, GENERAL("TGM_Recv_Lock_Value"));
    assert_true(given == 1); /* one, and no more until the PLC has it */
    rig_set(rig, GENERAL("PLC_Recv_Lock_Value"), given);
    rig_cycles(rig, 3);
    assert_true(rig_get(rig, GENERAL("TGM_Recv_Lock_Value")) == 2);
    rig_close(rig);
}

static void a_divider_exchanges_every_nth_cycle(void **state)
{
    (void)state;
    struct rig *rig = open_plant(2, "idle", &general_plant, NULL);
    unsigned given = 0;
    go_to_op(rig);
    set_sizes(rig, 1, 1, 5 << 16 | 0x08);
    for (unsigned i = 0; i < 50; i++) {
        const double before = rig_get(rig, GENERAL("TGM_Recv_Lock_Value"));
        rig_set(rig, GENERAL("PLC_Recv_Lock_Value"), before);
        rig_cycles(rig, 1);
        given += rig_get(rig, GENERAL("TGM_Recv_Lock_Value")) != before;
    }
    assert_int_equal(given, 10);
    rig_close(rig);
}

#define SECOND(member) "GENERAL.general_devices[1]." member

static void an_sdo_needs_the_right_mailboxes(void **state)
{
    (void)state;
    for (size_t p = 1; p < PRODUCTS; p++) {
        struct rig *rig = open_plant(p, "idle", &general_plant, NULL);
        go_to_op(rig);
        rig_cycles(rig, 50);
        ask(rig, SECOND("CompleteSDO"), 2, 0x1008, 0, 128);
        wait_sdo(rig, SECOND("CompleteSDO"), 200);
        assert_true(word(rig, SECOND("CompleteSDO"), "Status") == -1);
        assert_true(word(rig, SECOND("CompleteSDO"), "Data[0]") == CHANNEL_TIMEOUT);
        rig_set(rig, SECOND("mailBoxSize"), 246);
        rig_set(rig, SECOND("mailBoxOutAddress"), 0x1800);
        rig_set(rig, SECOND("mailBoxInAddress"), 0x18F6);
        /* 0x1018 as a whole: the number of entries, a byte of nothing, four numbers. */
        ask(rig, SECOND("CompleteSDO"), 2, 0x1018, 0, 128);
        wait_sdo(rig, SECOND("CompleteSDO"), 400);
        assert_true(word(rig, SECOND("CompleteSDO"), "Status") == 0);
        assert_true(word(rig, SECOND("CompleteSDO"), "Data[0]") == (4u | 0x534D0000u));
        ask(rig, SECOND("CompleteSDO"), 2, 0x1018, 2, 4);
        wait_sdo(rig, SECOND("CompleteSDO"), 400);
        assert_true(word(rig, SECOND("CompleteSDO"), "Data[0]") == 0x00A10200);
        ask(rig, SECOND("CompleteSDO"), 2, 0x1018, 2, 129);
        wait_sdo(rig, SECOND("CompleteSDO"), 400);
        assert_true(word(rig, SECOND("CompleteSDO"), "Data[0]") == CHANNEL_BAD_LENGTH);
        rig_close(rig);
    }
}

static void a_block_of_registers_goes_up_to_256_bytes(void **state)
{
    (void)state;
    struct rig *rig = open_plant(1, "idle", &general_plant, NULL);
    go_to_op(rig);
    rig_set(rig, GENERAL("RegisterIndex"), 0x0000);
    rig_set(rig, GENERAL("NumberByte"), 256);
    rig_set(rig, GENERAL("Control"), 2);
    rig_until(rig, GENERAL("Control"), 0, 100);
    assert_true(((unsigned)rig_get(rig, GENERAL("Data[4]")) & 0xFFFF) == 0x1001); /* 0x0010 */
    rig_set(rig, GENERAL("NumberByte"), 257);
    rig_set(rig, GENERAL("Control"), 2);
    rig_cycles(rig, 20);
    assert_true(rig_get(rig, GENERAL("Control")) == 3); /* until the PLC takes it back */
    assert_true(rig_get(rig, GENERAL("Data[0]")) == 0);
    rig_close(rig);
}

/* --- system registers --- */

static void the_main_loop_keeps_its_period(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_plant(p, "idle", NULL, NULL);
        go_to_op(rig);
        assert_true(rig_get(rig, "MAIN.Act_Timer_CycleTime") == 500);
        assert_true(rig_get(rig, "MAIN.Min_Timer_CycleTime") == 500);
        assert_true(rig_get(rig, "MAIN.Max_Timer_CycleTime") == 500);
        rig_set(rig, "MAIN.Max_Timer_CycleTime", 0);
        rig_cycles(rig, 1);
        assert_true(rig_get(rig, "MAIN.Max_Timer_CycleTime") == 500);
        assert_true(rig_get(rig, "MAIN.PLC_MaxCycleTime_Prg4") == 0);
        rig_close(rig);
    }
}

static void execution_times_are_measured_where_calls_are_timed(void **state)
{
    (void)state;
    struct rig *rig = open_plant(2, "idle", NULL, NULL);
    machine_timing(rig->machine, true);
    rig_start(rig);
    rig_set(rig, "MAIN.PLC_MaxCycleTime_Prg4", 123456789);
    rig_cycles(rig, 10);
    assert_true(rig_get(rig, "MAIN.PLC_MaxCycleTime_Prg4") == 123456789);
    assert_true(rig_get(rig, "MAIN.PLC_CycleTime_Prg4") < 1000000);
    rig_close(rig);
}

static void frames_are_counted_and_their_loss_is_an_error(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_plant(p, "idle", NULL, "at 600ms lose 5 frames");
        go_to_op(rig);
        const double sent = rig_get(rig, "SYSTEM.Ecat_Driver[0].nPacketsSent");
        assert_true(sent > 100);
        assert_true(rig_get(rig, "SYSTEM.Ecat_Driver[0].nPacketsRecv") == sent);
        rig_cycles(rig, 1300);
        assert_true(rig_get(rig, "SYSTEM.Ecat_Driver[0].errRcv") == 5);
        assert_true(rig_get(rig, "MAIN.EthPacketErrorCounter") == 5);
        assert_true(rig_get(rig, "SYSTEM.Ecat_Driver[0].nPacketsSent") > sent + 1300);
        rig_close(rig);
    }
}

static void clocks_follow_the_reference(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_plant(p, "idle", NULL, NULL);
        go_to_op(rig);
        rig_cycles(rig, 2000);
        assert_true(rig_get(rig, "MAIN.StateDistributedClock") == 1);
        const double master = rig_get(rig, "MAIN.MasterClock");
        const double reference = rig_get(rig, "MAIN.ReferenceClock");
        assert_true(master >= 1e9);
        assert_true(reference > master - 1e6 && reference < master + 1e6);
        assert_true(rig_get(rig, "MAIN.MasterClockToReferenceClockDifference") ==
                    master - reference);
        rig_close(rig);
    }
}

static void a_lost_link_is_a_safety_event_until_it_is_back(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_plant(p, "idle", NULL, "at 600ms unplug after 0 for 200ms");
        go_to_op(rig);
        assert_true(rig_get(rig, "MAIN.SafetyEvent") == 0);
        rig_until(rig, "MAIN.SafetyEvent", 0x2A2A2A2A, 2000);
        assert_true(rig_get(rig, "MAIN.Servo_Tick") < 1200 + 10);
        rig_until(rig, "MAIN.SafetyEvent", 0, 4000);
        rig_close(rig);
    }
}

static void run_at_speed(struct rig *rig, double *target, double step)
{
    go_to_op(rig);
    rig_cycles(rig, 10);
    *target = rig_get(rig, "SERVO[0].Position");
    rig_set(rig, "SERVO[0].WritePosition", *target);
    rig_set(rig, "SERVO[0].Mode", 1);
    rig_until(rig, "SERVO[0].Status", 3, 100);
    for (unsigned i = 0; i < 400; i++) {
        rig_set(rig, "SERVO[0].WritePosition", *target += step);
        rig_cycles(rig, 1);
    }
}

static void a_controlled_stop_ramps_down_and_takes_outputs_away(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        const char *out = p == 0 ? "DIO[0].Out0" : "DIO[0].Out[0]";
        struct rig *rig = open_plant(p, "idle", NULL, NULL);
        double target;
        run_at_speed(rig, &target, 500);
        rig_set(rig, out, 0xFF);
        rig_set(rig, "SERVO[0].Pg.Dec", 1e7); /* 1e6 inc/s: a tenth of a second */
        rig_set(rig, "MAIN.SafetyEvent", 0x4E4E4E4E);
        rig_cycles(rig, 101);
        assert_true(rig_get(rig, "SERVO[0].WriteSpeed") > 4.8e5);
        assert_true(rig_get(rig, "SERVO[0].WriteSpeed") < 5.2e5);
        assert_true(rig_get(rig, out) == 0);
        rig_cycles(rig, 200);
        assert_true(rig_get(rig, "SERVO[0].WriteSpeed") == 0);
        assert_true(rig_get(rig, "MAIN.SafetyEvent") == 0x4E4E4E4E);
        rig_set(rig, "SERVO[0].WritePosition", rig_get(rig, "SERVO[0].Position"));
        rig_set(rig, "MAIN.SafetyEvent", 0);
        rig_cycles(rig, 20);
        assert_true(rig_get(rig, "SERVO[0].Status") == 3);
        rig_close(rig);
    }
}

static void a_stop_at_once_holds_the_place(void **state)
{
    (void)state;
    struct rig *rig = open_plant(2, "idle", NULL, NULL);
    double target;
    run_at_speed(rig, &target, 20);
    rig_set(rig, "MAIN.SafetyEvent", 0x36363636);
    rig_cycles(rig, 1);
    const double held = rig_get(rig, "SERVO[0].Position");
    rig_set(rig, "SERVO[0].WritePosition", target + 1e6);
    rig_cycles(rig, 200);
    assert_true(rig_get(rig, "SERVO[0].WriteSpeed") == 0);
    assert_true(rig_get(rig, "SERVO[0].Position") > held - 200 &&
                rig_get(rig, "SERVO[0].Position") < held + 200);
    rig_close(rig);
}

static const unsigned char *ods(const struct rig *rig)
{
    const struct catalogue_register reg = { .memory =
                                                catalogue_memory_named(rig->catalogue, "TGM_ODS") };
    return host_register(rig->host, &reg);
}

static void messages_of_the_host_come_with_log_ctrl_and_lie_in_the_ring(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_plant(p, "idle", NULL, "at 600ms drop 1 to SAFEOP code 0x001B");
        const struct console_head *head = (const void *)ods(rig);
        const struct console_slot *first = (const void *)(ods(rig) + CONSOLE_SLOT);
        go_to_op(rig);
        assert_int_equal(rig->evidence.message_count, 0);
        assert_int_equal(head->written, 0);
        assert_int_equal(head->slots, 2047);
        rig_set(rig, "MAIN.Log_Ctrl", 0x400);
        rig_cycles(rig, 1300);
        assert_int_equal(rig->evidence.message_count, 1);
        const struct evidence_message *message = &rig->evidence.messages[0];
        assert_true(message->of_host);
        assert_int_equal(message->severity, CONSOLE_WARNING);
        assert_string_equal(evidence_speaker(message), "slave");
        assert_non_null(strstr(message->text, "AL state 0x14, before 0x08, code 0x001B"));
        assert_int_equal(head->written, 1);
        assert_int_equal(first->number, 1);
        assert_int_equal(first->id_and_severity, CONSOLE_SLAVES | CONSOLE_WARNING << 8);
        assert_int_equal(first->units, strlen(message->text));
        assert_memory_equal(first->text, "s\0l\0a\0v\0e\0", 10);
        rig_close(rig);
    }
}

static void sdo_requests_are_told_with_log_ctrl(void **state)
{
    (void)state;
    struct rig *rig = open_plant(2, "idle", NULL, NULL);
    go_to_op(rig);
    rig_set(rig, "MAIN.Log_Ctrl", 0x200);
    ask(rig, "SERVO[0].Sdo", 2, 0x5FFF, 3, 4);
    wait_sdo(rig, "SERVO[0].Sdo", 200);
    assert_int_equal(rig->evidence.message_count, 1);
    assert_string_equal(rig->evidence.messages[0].text,
                        "slave 1: SDO read 0x5FFF:03 failed: 0x06020000");
    rig_close(rig);
}

static void nobody_touches_the_lock_of_the_data_memory(void **state)
{
    (void)state;
    struct rig *rig = open_plant(2, "idle", NULL, NULL);
    assert_true(rig_get(rig, "MAIN.Data_Memory_Access_Lock") == 0);
    go_to_op(rig);
    rig_set(rig, "MAIN.Data_Memory_Access_Lock", 1);
    rig_cycles(rig, 100);
    assert_true(rig_get(rig, "MAIN.Data_Memory_Access_Lock") == 1);
    rig_close(rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_module_reads_and_writes_objects_by_sdo),
        cmocka_unit_test(a_request_is_busy_until_control_is_zero),
        cmocka_unit_test(what_cannot_be_asked_ends_with_a_code),
        cmocka_unit_test(a_slave_without_mailbox_refuses_and_counts),
        cmocka_unit_test(registers_of_the_slave_controller_are_read_and_written),
        cmocka_unit_test(a_bad_register_is_an_error_and_the_next_request_is_taken),
        cmocka_unit_test(all_channels_at_once_are_answered),
        cmocka_unit_test(requests_to_a_slave_that_is_gone_end_with_an_error),
        cmocka_unit_test(a_silent_mailbox_ends_with_a_timeout),
        cmocka_unit_test(the_code_of_a_fault_becomes_a_bit),
        cmocka_unit_test(codes_map_to_the_documented_bits),
        cmocka_unit_test(analog_values_and_gauges_have_their_own_registers),
        cmocka_unit_test(a_fault_of_an_io_unit_stays_until_it_is_reset),
        cmocka_unit_test(what_is_no_io_unit_is_a_general_device),
        cmocka_unit_test(process_data_go_by_the_options),
        cmocka_unit_test(locks_hand_process_data_over),
        cmocka_unit_test(a_divider_exchanges_every_nth_cycle),
        cmocka_unit_test(an_sdo_needs_the_right_mailboxes),
        cmocka_unit_test(a_block_of_registers_goes_up_to_256_bytes),
        cmocka_unit_test(the_main_loop_keeps_its_period),
        cmocka_unit_test(execution_times_are_measured_where_calls_are_timed),
        cmocka_unit_test(frames_are_counted_and_their_loss_is_an_error),
        cmocka_unit_test(clocks_follow_the_reference),
        cmocka_unit_test(a_lost_link_is_a_safety_event_until_it_is_back),
        cmocka_unit_test(a_controlled_stop_ramps_down_and_takes_outputs_away),
        cmocka_unit_test(a_stop_at_once_holds_the_place),
        cmocka_unit_test(messages_of_the_host_come_with_log_ctrl_and_lie_in_the_ring),
        cmocka_unit_test(sdo_requests_are_told_with_log_ctrl),
        cmocka_unit_test(nobody_touches_the_lock_of_the_data_memory),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
