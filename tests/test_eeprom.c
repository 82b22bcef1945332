/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The EEPROM area of TGM_System: load, save, and what the run hands back. */
#include "tests/host_rig.h"

#define CONTROL "SYSTEM.Eeprom.ctrl.Control"
#define STATUS  "SYSTEM.Eeprom.ctrl.Status"
#define WORD(n) "SYSTEM.Eeprom.Data[" #n "]"

static const char *const products[] = { "pc4", "pc5" };

#define EACH_PRODUCT(p) for (size_t p = 0; p < 2; p++)

static struct rig *open_with(size_t p, const void *content, size_t size)
{
    const struct host_config config = { .product = product_find(products[p]),
                                        .eeprom = content,
                                        .eeprom_size = size };
    struct rig *rig = rig_open("idle", &config);
    rig_start(rig);
    return rig;
}

static void demand(struct rig *rig, int control, int status)
{
    rig_set(rig, CONTROL, control);
    rig_cycles(rig, 1);
    for (unsigned i = 0; rig_get(rig, CONTROL) != 0; i++) {
        assert_true(rig_get(rig, STATUS) == 1);
        assert_true(i < 100);
        rig_cycles(rig, 1);
    }
    assert_true(rig_get(rig, STATUS) == status);
}

static void the_file_comes_with_a_load_and_not_before(void **state)
{
    const uint32_t content[] = { 0x11223344, 7 };
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_with(p, content, sizeof content);
        rig_cycles(rig, 10);
        assert_true(rig_get(rig, WORD(0)) == 0);
        rig_set(rig, WORD(2), 99);
        demand(rig, 1, 0);
        assert_true(rig_get(rig, WORD(0)) == 0x11223344);
        assert_true(rig_get(rig, WORD(1)) == 7);
        assert_true(rig_get(rig, WORD(2)) == 0); /* behind the end of a short file */
        assert_false(rig->evidence.eeprom.saved);
        rig_close(rig);
    }
}

static void what_was_saved_is_loaded_and_handed_back(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_with(p, NULL, 0);
        const int32_t saved[2] = { 12345, 0 };
        demand(rig, 1, -1); /* never saved */
        rig_set(rig, WORD(0), 12345);
        rig_set(rig, WORD(687), 6);
        demand(rig, 2, 0);
        rig_set(rig, WORD(0), 1);
        demand(rig, 1, 0);
        assert_true(rig_get(rig, WORD(0)) == 12345);
        assert_true(rig->evidence.eeprom.saved);
        assert_int_equal(rig->evidence.eeprom.size, 2752);
        assert_memory_equal(rig->evidence.eeprom.data, saved, sizeof saved);
        assert_int_equal(rig->evidence.eeprom.data[2748], 6);
        rig_close(rig);
    }
}

static void another_control_is_an_error(void **state)
{
    (void)state;
    struct rig *rig = open_with(1, NULL, 0);
    demand(rig, 3, -1);
    assert_false(rig->evidence.eeprom.saved);
    rig_close(rig);
}

/* Size_EEPROM_Memory is R; a module that wrote it gets no more than there is. */
static void the_announced_size_is_what_is_stored(void **state)
{
    (void)state;
    struct rig *rig = open_with(1, NULL, 0);
    assert_true(rig_get(rig, "MAIN.Size_EEPROM_Memory") == 2752);
    rig_set(rig, "MAIN.Size_EEPROM_Memory", 0); /* stands for 512 */
    rig_set(rig, WORD(127), 5);
    rig_set(rig, WORD(128), 6);
    demand(rig, 2, 0);
    assert_int_equal(rig->evidence.eeprom.size, 512);
    assert_int_equal(rig->evidence.eeprom.data[508], 5);
    assert_int_equal(rig->evidence.eeprom.data[512], 0);
    rig_set(rig, "MAIN.Size_EEPROM_Memory", 0xFFFFFFFF);
    demand(rig, 2, 0);
    assert_int_equal(rig->evidence.eeprom.size, 2752);
    rig_close(rig);
}

static void what_a_worker_hands_back_is_clamped(void **state)
{
    static struct evidence evidence;
    (void)state;
    memset(&evidence, 0xFF, sizeof evidence);
    evidence_clean(&evidence);
    assert_int_equal(evidence.eeprom.size, EVIDENCE_EEPROM);
    unsigned char saved;
    memcpy(&saved, &evidence.eeprom.saved, 1);
    assert_int_equal(saved, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_file_comes_with_a_load_and_not_before),
        cmocka_unit_test(what_was_saved_is_loaded_and_handed_back),
        cmocka_unit_test(another_control_is_an_error),
        cmocka_unit_test(the_announced_size_is_what_is_stored),
        cmocka_unit_test(what_a_worker_hands_back_is_clamped),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
