/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The way back: a description as a device file, for people to edit. */
#include "bus/description.h"

#include <string.h>

static void quoted(FILE *stream, const char *text)
{
    fputc('"', stream);
    for (; *text; text++) {
        if (*text == '"' || *text == '\\')
            fputc('\\', stream);
        fputc((unsigned char)*text < 0x20 ? ' ' : *text, stream);
    }
    fputc('"', stream);
}

static void named(FILE *stream, const char *word, const char *text)
{
    if (!text[0])
        return;
    fprintf(stream, "%s ", word);
    quoted(stream, text);
    fputc('\n', stream);
}

static void write_controller(const struct description *d, FILE *stream)
{
    static const char *const dc[] = { "none", "delay", "full" };
    static const char *const port[16] = { "none", "mii", "none", "ebus", "fast" };
    static const char *const services[] = {
        "sdo", "info", "assign", "config", "upload", "complete"
    };

    fprintf(stream, "vendor 0x%08X product 0x%08X revision 0x%08X\n", d->vendor, d->product,
            d->revision);
    named(stream, "name", d->name);
    named(stream, "order", d->order);
    named(stream, "group", d->group);
    fprintf(stream, "pdi 0x%04X config 0x%04X extended 0x%04X pulse %u\n", d->pdi_control,
            d->pdi_config, d->pdi_config_ext, d->sync_pulse);
    if (d->emulation)
        fprintf(stream, "emulation\n");
    fprintf(stream, "dc %s", dc[d->dc]);
    if (d->dc_assign)
        fprintf(stream, " assign 0x%04X", d->dc_assign);
    fprintf(stream, "\nports");
    for (unsigned i = 0; i < 4 && (i == 0 || d->ports >> (4 * i)); i++) {
        const char *kind = port[d->ports >> (4 * i) & 0x0f];

        fprintf(stream, " %s", kind ? kind : "none");
    }
    fprintf(stream, "\n");
    if (d->current)
        fprintf(stream, "current %d\n", d->current);
    if (!description_coe(d))
        return;
    fprintf(stream, "coe");
    for (unsigned i = 0; i < 6; i++) {
        if (d->coe_details >> i & 1)
            fprintf(stream, " %s", services[i]);
    }
    fprintf(stream, "\n");
}

static void write_managers(const struct description *d, FILE *stream)
{
    static const char *const types[] = { "unused", "mailbox-out", "mailbox-in", "outputs",
                                         "inputs" };
    static const char *const uses[] = { "none", "outputs", "inputs", "mailbox-state" };

    for (unsigned n = 0; n < d->sm_count; n++)
        fprintf(stream, "sm %u 0x%04X %u %s control 0x%02X enable 0x%02X\n", n, d->sm[n].start,
                d->sm[n].length, types[d->sm[n].type], d->sm[n].control, d->sm[n].enable);
    for (unsigned n = 0; n < d->fmmu_count; n++)
        fprintf(stream, "%s %s", n ? "" : "fmmu", uses[d->fmmu[n] & 3]);
    if (d->fmmu_count)
        fprintf(stream, "\n");
}

static void write_pdos(const struct description *d, FILE *stream)
{
    for (unsigned i = 0; i < d->pdo_count; i++) {
        const struct desc_pdo *pdo = &d->pdo[i];

        fprintf(stream, "\npdo %s 0x%04X ", pdo->direction == PDO_RX ? "rx" : "tx", pdo->index);
        if (pdo->sm != DESC_NO_SM)
            fprintf(stream, "sm %u ", pdo->sm);
        fprintf(stream, "%s%s%s", pdo->flags & 0x01 ? "mandatory " : "",
                pdo->flags & 0x10 ? "fixed " : "", pdo->flags & 0x02 ? "default " : "");
        quoted(stream, pdo->name);
        fprintf(stream, "\n");
        for (unsigned k = pdo->first; k < pdo->first + pdo->count; k++) {
            const struct desc_entry *e = &d->entry[k];

            if (!e->index) {
                fprintf(stream, "  gap %u\n", e->bits);
                continue;
            }
            fprintf(stream, "  entry 0x%04X:%02X %s ", e->index, e->subindex,
                    description_type_name(e->type));
            quoted(stream, e->name);
            fprintf(stream, "\n");
        }
    }
}

static const char *access_name(uint16_t access)
{
    if (!(access & (OD_RW & ~OD_RO)))
        return "ro";
    if (!(access & OD_RO))
        return "wo";
    return access & (OD_WR_SAFEOP | OD_WR_OP) ? "rw" : "rw-preop";
}

static void write_objects(const struct description *d, FILE *stream)
{
    for (unsigned i = 0; i < d->object_count; i++) {
        const struct desc_object *object = &d->object[i];

        fprintf(stream, "\nobject 0x%04X %s", object->index,
                object->code == OD_ARRAY ? "array " : "");
        quoted(stream, object->name);
        fprintf(stream, "\n");
        for (unsigned k = object->first; k < object->first + object->count; k++) {
            const struct desc_row *row = &d->row[k];

            fprintf(stream, "  entry 0x%04X:%02X %s %s ", object->index, row->subindex,
                    description_type_name(row->type), access_name(row->access));
            if (row->type == OD_STRING)
                quoted(stream, row->text);
            else
                fprintf(stream, "%lld", (long long)row->initial);
            if (row->ranged)
                fprintf(stream, " range %lld..%lld", (long long)row->least, (long long)row->most);
            fprintf(stream, " ");
            quoted(stream, row->name);
            fprintf(stream, "\n");
        }
    }
}

static void write_channels(const struct description *d, FILE *stream)
{
    static const char *const flags[TERMINAL_FLAGS] = { "status", "under", "over", "error" };

    if (d->input_count + d->output_count)
        fprintf(stream, "\n");
    for (unsigned i = 0; i < d->input_count; i++) {
        const struct desc_channel *c = &d->input[i];

        fprintf(stream, "input 0x%04X:%02X", c->value.index, c->value.subindex);
        for (unsigned f = 0; f < TERMINAL_FLAGS; f++) {
            if (c->flag[f].index)
                fprintf(stream, " %s 0x%04X:%02X", flags[f], c->flag[f].index, c->flag[f].subindex);
        }
        fprintf(stream, "\n");
    }
    for (unsigned i = 0; i < d->output_count; i++) {
        const struct desc_channel *c = &d->output[i];

        fprintf(stream, "output 0x%04X:%02X", c->value.index, c->value.subindex);
        if (c->safe)
            fprintf(stream, " safe %lld", (long long)c->safe);
        fprintf(stream, "\n");
    }
    if (d->output_count)
        fprintf(stream, "watchdog %s\n", d->hold ? "hold" : "safe");
}

void device_file_write(const struct description *d, FILE *stream)
{
    fprintf(stream, "device ");
    quoted(stream, d->type);
    fprintf(stream, " ");
    quoted(stream, d->about);
    fprintf(stream, "\n");
    write_controller(d, stream);
    fprintf(stream, "\n");
    write_managers(d, stream);
    write_pdos(d, stream);
    write_objects(d, stream);
    write_channels(d, stream);
}
