/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#define TGM_HOST
#include <tgm_plc.h>

#include "host/catalogue.h"

static char why[CATALOGUE_WHY];

static struct catalogue_register resolved_in(int generation, int memory_id, const char *name)
{
    struct catalogue_register reg;
    if (catalogue_resolve(catalogue_find(generation, memory_id), name, &reg, why) != 0)
        fail_msg("%s: %s", name, why);
    return reg;
}

static const char *refused_in(int generation, int memory_id, const char *name)
{
    struct catalogue_register reg;
    const struct catalogue *catalogue = catalogue_find(generation, memory_id);
    assert_int_not_equal(catalogue_resolve(catalogue, name, &reg, why), 0);
    return why;
}

static struct catalogue_register resolved(const char *name)
{
    return resolved_in(4, 904, name);
}

static const char *refused(const char *name)
{
    return refused_in(4, 904, name);
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

static void each_generation_has_its_own_catalogue(void **state)
{
    (void)state;
    assert_non_null(catalogue_find(4, 904));
    assert_ptr_equal(catalogue_find(4, 0), catalogue_find(4, 904));
    assert_ptr_equal(catalogue_find(5, 0), catalogue_find(5, 906));
    assert_ptr_not_equal(catalogue_find(5, 905), catalogue_find(5, 906));
    assert_null(catalogue_find(4, 905));
    assert_null(catalogue_find(5, 904));
    assert_null(catalogue_find(6, 0));

    assert_int_equal(resolved_in(5, 906, "DIO[1].Out[0]").offset, 2048 + 96);
    assert_non_null(strstr(refused_in(5, 906, "DIO[1].Out0"), "it has Number"));
    assert_non_null(strstr(why, "docs/registers-gen5-906.md"));
    assert_non_null(strstr(refused("DIO[1].Out[0]"), "docs/registers-gen4.md"));
    /* What moved between 5.00 and 5.02. */
    assert_int_equal(resolved_in(5, 905, "GENERAL.general_devices[1].User_PDO_Output_Size").offset,
                     1024 + 504);
    assert_int_equal(resolved_in(5, 906, "GENERAL.general_devices[1].User_PDO_Output_Size").offset,
                     1024 + 488);
    assert_int_equal(resolved_in(5, 906, "OSC_EX.Trigger[2].Level").offset, 3072 + 8 + 2 * 24 + 16);
    assert_int_equal(resolved_in(5, 906, "ETH.conn[3].Command").offset, 3200 + 3 * 64 + 44);
    assert_int_equal(resolved_in(5, 905, "EEPROM.Data[0]").offset, 5440);
    refused_in(5, 905, "OSC_EX.Function");
    assert_null(strstr(refused_in(5, 905, "GEARBOX.x"), "OSC_EX"));
    assert_non_null(strstr(refused_in(5, 906, "GEARBOX.x"), "OSC_EX"));
    assert_non_null(strstr(why, "GENERAL"));
}

static void memories_of_each_generation_have_their_numbers_and_pointers(void **state)
{
    (void)state;
    const struct catalogue_memory *memory =
        catalogue_memory_named(catalogue_find(4, 904), "TGM_Interpolator");
    assert_int_equal(memory->number, 6);
    assert_int_equal(memory->pointer, offsetof(PLC_DATA, PInterpolator_Memory));
    memory = catalogue_memory_named(catalogue_find(5, 906), "TGM_Interpolator");
    assert_int_equal(memory->number, 7);
    assert_null(catalogue_memory_named(catalogue_find(4, 904), "TGM_General"));
    assert_int_equal(catalogue_memory_named(catalogue_find(5, 905), "TGM_General")->number, 6);
    assert_null(catalogue_memory(catalogue_find(4, 904), 12));
    assert_non_null(catalogue_memory(catalogue_find(5, 906), 12));
    assert_null(catalogue_memory(catalogue_find(5, 906), 13));
}

struct survey {
    size_t lines, reads, ours, without;
};

static void survey_line(void *argument, const struct catalogue_line *line)
{
    struct survey *survey = argument;
    const char *access = line->access;
    const bool known =
        strcmp(access, "R") == 0 || strcmp(access, "W") == 0 || strcmp(access, "RW") == 0;
    survey->lines++;
    survey->reads += strcmp(access, "R") == 0;
    survey->ours += line->access_by == ACCESS_OURS;
    survey->without += !known || line->unit[0] == '\0' || line->note[0] == '\0';
    assert_true(line->offset + line->size <= line->stride);
}

/* What the audit of writes and the plots go by. */
static void every_register_says_its_access_unit_and_meaning(void **state)
{
    (void)state;
    static const int layouts[][2] = { { 4, 904 }, { 5, 905 }, { 5, 906 } };
    for (size_t i = 0; i < 3; i++) {
        struct survey survey = { 0 };
        catalogue_walk(catalogue_find(layouts[i][0], layouts[i][1]), survey_line, &survey);
        assert_true(survey.lines > 300 && survey.reads > 100 && survey.ours > 0);
        assert_int_equal(survey.without, 0);
    }
    struct catalogue_register reg = resolved("SERVO[0].WritePosition");
    assert_string_equal(reg.access, "RW");
    assert_int_equal(reg.access_by, ACCESS_STATED);
    reg = resolved("MAIN.Servo_Tick");
    assert_string_equal(reg.access, "R");
    assert_int_equal(reg.access_by, ACCESS_OURS);
    reg = resolved_in(5, 906, "SERVO[0].Status");
    assert_string_equal(reg.access, "R");
    assert_int_equal(reg.access_by, ACCESS_STATED);
}

struct place {
    uint64_t offset;
    const char *memory;
    size_t found;
    char name[160];
};

static void place_line(void *argument, const struct catalogue_line *line)
{
    struct place *place = argument;
    if (strcmp(line->memory->name, place->memory) == 0 &&
        catalogue_line_holds(line, place->offset)) {
        place->found++;
        strcpy(place->name, line->name);
    }
}

/* Resolving and looking up are each other's inverse, wherever a register lies. */
static void the_register_at_an_offset_is_found_in_every_element(void **state)
{
    (void)state;
    static const struct {
        const char *name, *line;
    } wanted[] = {
        { "SERVO[255].Position", "SERVO[n].Position" },
        { "SERVO[1].Command.Par[14]", "SERVO[n].Command.Par[15]" },
        { "SYSTEM.Osc.Channel[0].Offset", "SYSTEM.Osc.Channel[32].Offset" },
        { "SYSTEM.Osc.Channel[31].Type_Value", "SYSTEM.Osc.Channel[32].Type_Value" },
        { "SYSTEM.Osc.Number_Samples", "SYSTEM.Osc.Number_Samples" },
        { "INTERPOLATOR[2].LookAheadBuffer[7].buf.endPos[9]",
          "INTERPOLATOR[n].LookAheadBuffer[8].buf.endPos[10]" },
        { "GENERAL.general_devices[15].CompleteSDO.Data[31]",
          "GENERAL.general_devices[16].CompleteSDO.Data[32]" },
        { "CNC.core[2].base.func.base.GCodeParameters.motion[7].dec",
          "CNC.core[3].base.func.base.GCodeParameters.motion[8].dec" },
    };
    const struct catalogue *catalogue = catalogue_find(5, 906);
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        const struct catalogue_register reg = resolved_in(5, 906, wanted[i].name);
        for (size_t byte = 0; byte < scalar_size(reg.type); byte++) {
            struct place place = { .offset = reg.offset + byte, .memory = reg.memory->name };
            catalogue_walk(catalogue, place_line, &place);
            assert_int_equal(place.found, 1);
            assert_string_equal(place.name, wanted[i].line);
        }
    }
    struct place past = { .offset = 524288, .memory = "TGM_Servo" };
    catalogue_walk(catalogue, place_line, &past);
    assert_int_equal(past.found, 0);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_lead_to_the_offsets_of_the_header),
        cmocka_unit_test(parts_of_system_go_by_their_own_names),
        cmocka_unit_test(flat_memories_are_named_by_type_and_offset),
        cmocka_unit_test(a_wrong_name_is_answered_with_what_is_allowed),
        cmocka_unit_test(each_generation_has_its_own_catalogue),
        cmocka_unit_test(memories_of_each_generation_have_their_numbers_and_pointers),
        cmocka_unit_test(every_register_says_its_access_unit_and_meaning),
        cmocka_unit_test(the_register_at_an_offset_is_found_in_every_element),
        cmocka_unit_test(scalars_are_read_by_type),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
