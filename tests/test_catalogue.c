/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#define TGM_HOST
#include <tgm_plc.h>

#include "host/catalogue.h"
#include "host/schedule.h"

static char why[CATALOGUE_WHY];

static struct catalogue_register resolved(const char *name)
{
    struct catalogue_register reg;
    if (catalogue_resolve(name, &reg, why) != 0)
        fail_msg("%s: %s", name, why);
    return reg;
}

static const char *refused(const char *name)
{
    struct catalogue_register reg;
    assert_int_not_equal(catalogue_resolve(name, &reg, why), 0);
    return why;
}

static void names_lead_to_the_offsets_of_the_header(void **state)
{
    (void)state;
    struct catalogue_register reg = resolved("SERVO[3].Position");
    assert_string_equal(reg.memory->name, "TGM_Servo");
    assert_int_equal(reg.offset, 3 * sizeof(SERVO) + offsetof(SERVO, Position));
    assert_int_equal(reg.type, F64);
    assert_string_equal(reg.unit, "inc");
    assert_string_equal(reg.access, "R");
    assert_int_equal(resolved("SERVO[0].Pg.Acc").offset, offsetof(SERVO, Pg.Acc));
    assert_int_equal(resolved("SERVO[0].Command.Par[14]").offset, offsetof(SERVO, Command.Par[14]));
    assert_int_equal(resolved("SYSTEM.Osc.Channel[31].Offset").offset, 5272);
    assert_int_equal(resolved("DIO[15].Ext_Out7").offset,
                     15 * sizeof(DIO) + offsetof(DIO, Ext_Out7));
    assert_int_equal(resolved("INTERPOLATOR[2].LookAheadBuffer[7].buf.radius").offset,
                     2 * sizeof(INTERPOLATOR) +
                         offsetof(INTERPOLATOR, LookAheadBuffer[7].buf.radius));
}

static void parts_of_system_go_by_their_own_names(void **state)
{
    (void)state;
    assert_int_equal(resolved("HEADER.Compatibility_Id").offset,
                     offsetof(SYSTEM, Header.Compatibility_Id));
    assert_int_equal(resolved("MAIN.Servo_Tick").offset, resolved("SYSTEM.Main.Servo_Tick").offset);
    assert_int_equal(resolved("TIMERS.Timer_Down[63]").offset,
                     offsetof(SYSTEM, Timers.Timer_Down[63]));
    assert_int_equal(resolved("OSC.Control").offset, 4736);
}

static void flat_memories_are_named_by_type_and_offset(void **state)
{
    (void)state;
    assert_int_equal(resolved("DATA.F64[16]").offset, 16);
    assert_int_equal(resolved("DATA.F64[524280]").offset, 524280);
    assert_non_null(strstr(refused("DATA.F64[524281]"), "past its end"));
    assert_non_null(strstr(refused("DATA.X[0]"), "by type and byte offset"));
}

static void a_wrong_name_is_answered_with_what_is_allowed(void **state)
{
    (void)state;
    assert_non_null(strstr(refused("SERVO[0].position"), "did you mean Position?"));
    assert_non_null(strstr(refused("SERVO[0].Nonsense"), "it has Number"));
    assert_non_null(strstr(refused("SERVO.Position"), "use SERVO[0] to SERVO[255]"));
    assert_non_null(strstr(refused("SERVO[256].Position"), "use SERVO[0] to SERVO[255]"));
    assert_non_null(strstr(refused("SERVO[0].Pg"), "group of registers"));
    assert_non_null(strstr(refused("SERVO[0].Position.x"), "single register"));
    assert_non_null(strstr(refused("SERVO[0].Position[1]"), "is no array"));
    assert_non_null(strstr(refused("TIMERS.Timer_Up"), "is an array"));
    assert_non_null(strstr(refused("GEARBOX.x"), "allowed: SYSTEM"));
    refused("");
    refused("SERVO[");
    refused("SERVO[x].Position");
    refused("SERVO[0]Position");
    refused("SERVO[99999999999999999999999].Position");
    refused("SERVO[0]..Position");
    refused("SERVO[0]");
}

static void scalars_are_read_by_type(void **state)
{
    (void)state;
    const int16_t i16 = -2;
    const uint64_t u64 = UINT64_C(1) << 40;
    const float f32 = 0.5f;
    assert_true(scalar_get(I16, &i16) == -2);
    assert_true(scalar_get(U16, &i16) == 65534);
    assert_true(scalar_get(U64, &u64) == (double)u64);
    assert_true(scalar_get(F32, &f32) == 0.5);
}

/* The tables against the manual's text: slots are equal, each action has its place, Program_05
 * everywhere. */
static void each_schedule_is_the_manuals(void **state)
{
    (void)state;
    static const struct {
        uint32_t cycle, step;
        size_t slots;
    } wanted[] = { { 250, 50, 5 }, { 500, 100, 5 }, { 1000, 100, 10 } };
    for (size_t i = 0; i < 3; i++) {
        const struct schedule *s = schedule_find(wanted[i].cycle);
        assert_non_null(s);
        assert_int_equal(s->slot_count, wanted[i].slots);
        for (size_t k = 0; k < s->slot_count; k++) {
            assert_int_equal(s->slots[k].at_us, k * wanted[i].step);
            assert_true(s->slots[k].actions & SLOT_PROGRAM_05);
            assert_int_equal((s->slots[k].actions & SLOT_RECEIVE) != 0, k == 0);
            assert_int_equal((s->slots[k].actions & SLOT_SEND) != 0, k == 1);
            assert_int_equal((s->slots[k].actions & SLOT_PROFILE) != 0, k == 2);
            assert_int_equal((s->slots[k].actions & SLOT_PROGRAM_04) != 0, k == 3);
            assert_int_equal((s->slots[k].actions & SLOT_OSCILLOSCOPE) != 0, k == 3);
        }
    }
    assert_null(schedule_find(750));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_lead_to_the_offsets_of_the_header),
        cmocka_unit_test(parts_of_system_go_by_their_own_names),
        cmocka_unit_test(flat_memories_are_named_by_type_and_offset),
        cmocka_unit_test(a_wrong_name_is_answered_with_what_is_allowed),
        cmocka_unit_test(scalars_are_read_by_type),
        cmocka_unit_test(each_schedule_is_the_manuals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
