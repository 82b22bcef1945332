/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/console.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "host/host_parts.h"
#include "host/text16.h"

_Static_assert(sizeof(struct console_slot) == CONSOLE_SLOT, "slots of the ring");

/* A message on its way: the text as it came, of one kind or the other. */
struct text {
    const void *units;
    bool wide;
};

static uint32_t unit_of(struct text text, size_t at)
{
    return text.wide ? ((const uint16_t *)text.units)[at] : ((const uint8_t *)text.units)[at];
}

static void ring_open(struct host *host)
{
    const struct catalogue_memory *memory =
        catalogue_memory(host->catalogue, (size_t)SHARED_MEMORY_ODS);
    struct console_head *head = host->memory[SHARED_MEMORY_ODS];
    head->slots = (uint32_t)(memory->size / CONSOLE_SLOT) - 1;
    head->slot_size = CONSOLE_SLOT;
    head->unit_size = host->config.product->text8 ? 1 : 2;
    host->console_slots = head->slots;
}

/* The memory is the module's, too: what the head says is written here and not read. */
static void ring_put(struct host *host, uint32_t id_and_severity, struct text text)
{
    unsigned char *memory = host->memory[SHARED_MEMORY_ODS];
    const bool wide = !host->config.product->text8;
    const uint32_t number = ++host->console_written;
    if (host->console_slots == 0)
        return;
    struct console_slot *slot =
        (void *)(memory + (size_t)CONSOLE_SLOT * (1 + (number - 1) % host->console_slots));
    const size_t room = sizeof slot->text / (wide ? 2 : 1) - 1;
    size_t count = 0;
    *(volatile uint32_t *)&slot->number = 0;
    for (uint32_t unit; count < room && (unit = unit_of(text, count)) != 0; count++)
        if (wide)
            ((uint16_t *)(void *)slot->text)[count] = (uint16_t)unit;
        else
            slot->text[count] = (unsigned char)unit;
    memset(slot->text + count * (wide ? 2 : 1), 0, wide ? 2 : 1);
    slot->tick = host->system->Main.Servo_Tick;
    slot->id_and_severity = id_and_severity;
    slot->units = (uint32_t)count;
    *(volatile uint32_t *)&slot->number = number;
    ((struct console_head *)(void *)memory)->written = number;
}

static void trim(struct evidence_message *message, size_t length)
{
    while (length > 0 && (message->text[length - 1] == '\n' || message->text[length - 1] == '\r'))
        message->text[--length] = '\0';
}

/* The whole text is read, as the real console does: a module that forgot its end is found. */
static void to_utf8(struct evidence_message *message, struct text text)
{
    if (text.wide) {
        trim(message, text16_to_utf8(message->text, sizeof message->text, text.units));
        return;
    }
    const size_t length = strlen(text.units);
    const size_t room = sizeof message->text - 1;
    const size_t count = length < room ? length : room;
    memcpy(message->text, text.units, count);
    message->text[count] = '\0';
    trim(message, count);
}

static void measure(struct text text)
{
    for (size_t i = 0; unit_of(text, i) != 0; i++)
        __asm__ volatile("" : : : "memory");
}

/* Where there is no room any more the message is counted, and its end looked for all the same. */
static void put(struct host *host, uint32_t id_and_severity, bool of_host, struct text text)
{
    struct evidence *evidence = host->evidence;
    const uint64_t at = evidence->message_count++;
    if (!of_host)
        evidence->audit.functions[evidence->entry].messages++;
    if (at < EVIDENCE_MESSAGES) {
        struct evidence_message *message = &evidence->messages[at];
        message->entry = evidence->entry;
        message->cycle = evidence->cycle;
        message->severity =
            (int32_t)(id_and_severity >> CONSOLE_SEVERITY_SHIFT & CONSOLE_SEVERITY_MASK);
        message->of_host = of_host;
        message->source = id_and_severity & CONSOLE_ID_MASK;
        to_utf8(message, text);
    } else {
        measure(text);
    }
    ring_put(host, id_and_severity, text);
}

void console_text16(struct host *host, uint32_t id_and_severity, const uint16_t *text)
{
    put(host, id_and_severity, false, (struct text){ text, true });
}

void console_text8(struct host *host, uint32_t id_and_severity, const char *text)
{
    put(host, id_and_severity, false, (struct text){ text, false });
}

void console_log(struct host *host, uint32_t log, enum console_source source,
                 enum console_severity severity, const char *format, ...)
{
    char text[EVIDENCE_TEXT];
    va_list arguments;
    if ((host->system->Main.Log_Ctrl & log) == 0)
        return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    put(host, (uint32_t)source | (uint32_t)severity << CONSOLE_SEVERITY_SHIFT, true,
        (struct text){ text, false });
}

static int console_open(struct host *host, char why[HOST_WHY])
{
    (void)why;
    ring_open(host);
    return 0;
}

const struct host_part host_console = { .name = "console", .open = console_open };
