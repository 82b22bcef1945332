/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * console.h - messages of the module and of the host itself: to the evidence and to TGM_ODS.
 *
 * TGM_ODS is a ring (docs/decisions.md, R14). Its first 512 bytes are the head, then come slots of
 * 512 bytes. Message n (from 1) is in slot (n - 1) modulo `slots`; `number` is written last, so a
 * reader that finds the number it waits for has a whole message. Nothing but the newest `slots`
 * messages is kept.
 */
#ifndef HARNESS_HOST_CONSOLE_H
#define HARNESS_HOST_CONSOLE_H

#include <stdint.h>

#define CONSOLE_SLOT 512

struct console_head {
    uint32_t written;   /* messages so far */
    uint32_t slots;     /* in the ring */
    uint32_t slot_size; /* bytes */
    uint32_t unit_size; /* bytes of a unit of text: 2 UTF-16, 1 UTF-8 */
};

struct console_slot {
    uint32_t number;          /* of the message, from 1; 0: never written */
    uint32_t tick;            /* MAIN.Servo_Tick */
    uint32_t id_and_severity; /* as pRtWprintf_String_Severity has it in generation 5 */
    uint32_t units;           /* of text, without the final 0 */
    unsigned char text[CONSOLE_SLOT - 16];
};

/* Who speaks; the numbers of generation 5 (ODS_ID_...). */
enum console_source {
    CONSOLE_MAIN = 0,
    CONSOLE_SERVO = 4,
    CONSOLE_PLC = 6,
    CONSOLE_EEPROM = 8,
    CONSOLE_MASTER = 17,
    CONSOLE_SLAVES = 18
};

#define CONSOLE_ID_MASK        0xFFu
#define CONSOLE_SEVERITY_MASK  0x03u
#define CONSOLE_SEVERITY_SHIFT 8

enum console_severity { CONSOLE_INFO, CONSOLE_WARNING, CONSOLE_ERROR };

#endif
