/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "report/curves.h"

#include <math.h>
#include <stdlib.h>

struct point {
    double time, value;
};

/* What a bucket keeps of one curve; nothing when no value was finite. */
struct part {
    struct point first, least, greatest, last;
    bool any;
};

struct curves {
    size_t count;
    uint64_t rows, rows_per_bucket;
    size_t buckets; /* in use; the last one may be filling */
    double begin, end;
    struct {
        double least, greatest;
        bool any, other; /* has it values, and is one of them neither 0 nor 1 */
    } * curve;
    double *opened;     /* time of a bucket's first row */
    struct part *parts; /* [bucket * count + curve] */
};

struct curves *curves_new(size_t count)
{
    struct curves *c = calloc(1, sizeof *c);
    if (c == NULL)
        return NULL;
    c->count = count;
    c->rows_per_bucket = 1;
    c->curve = calloc(count, sizeof *c->curve);
    c->opened = calloc(CURVES_BUCKETS, sizeof *c->opened);
    c->parts = calloc(count * CURVES_BUCKETS, sizeof *c->parts);
    if (c->curve != NULL && c->opened != NULL && c->parts != NULL)
        return c;
    curves_free(c);
    return NULL;
}

void curves_free(struct curves *c)
{
    if (c == NULL)
        return;
    free(c->curve);
    free(c->opened);
    free(c->parts);
    free(c);
}

static void part_add(struct part *to, const struct part *from)
{
    if (!from->any)
        return;
    if (!to->any) {
        *to = *from;
        return;
    }
    if (from->least.value < to->least.value)
        to->least = from->least;
    if (from->greatest.value > to->greatest.value)
        to->greatest = from->greatest;
    to->last = from->last;
}

/* Every two buckets become one. */
static void halve(struct curves *c)
{
    for (size_t i = 0; i < CURVES_BUCKETS / 2; i++) {
        c->opened[i] = c->opened[2 * i];
        for (size_t k = 0; k < c->count; k++) {
            struct part both = c->parts[2 * i * c->count + k];
            part_add(&both, &c->parts[(2 * i + 1) * c->count + k]);
            c->parts[i * c->count + k] = both;
        }
    }
    c->buckets = CURVES_BUCKETS / 2;
    c->rows_per_bucket *= 2;
}

static void open_bucket(struct curves *c, double time)
{
    if (c->buckets == CURVES_BUCKETS)
        halve(c);
    for (size_t k = 0; k < c->count; k++)
        c->parts[c->buckets * c->count + k].any = false;
    c->opened[c->buckets++] = time;
}

static void note_value(struct curves *c, size_t k, double value)
{
    if (!c->curve[k].any || value < c->curve[k].least)
        c->curve[k].least = value;
    if (!c->curve[k].any || value > c->curve[k].greatest)
        c->curve[k].greatest = value;
    c->curve[k].any = true;
    c->curve[k].other |= value != 0 && value != 1;
}

void curves_add(struct curves *c, const double *row)
{
    if (c->rows == 0)
        c->begin = row[0];
    if (c->rows % c->rows_per_bucket == 0)
        open_bucket(c, row[0]);
    for (size_t k = 0; k < c->count; k++) {
        const struct point p = { row[0], row[1 + k] };
        const struct part one = { p, p, p, p, true };
        if (!isfinite(p.value))
            continue;
        note_value(c, k, p.value);
        part_add(&c->parts[(c->buckets - 1) * c->count + k], &one);
    }
    c->end = row[0];
    c->rows++;
}

uint64_t curves_rows(const struct curves *c)
{
    return c->rows;
}

double curves_begin(const struct curves *c)
{
    return c->begin;
}

double curves_end(const struct curves *c)
{
    return c->end;
}

bool curves_range(const struct curves *c, size_t k, double *least, double *greatest)
{
    *least = c->curve[k].least;
    *greatest = c->curve[k].greatest;
    return c->curve[k].any;
}

bool curves_binary(const struct curves *c, size_t k)
{
    return c->curve[k].any && !c->curve[k].other;
}

/* In the order of their times, each once. */
static void walk_part(const struct part *part, curves_visit *visit, void *argument)
{
    const bool falls = part->greatest.time < part->least.time;
    const struct point *order[] = { &part->first, falls ? &part->greatest : &part->least,
                                    falls ? &part->least : &part->greatest, &part->last };
    for (size_t i = 0; i < sizeof order / sizeof *order; i++)
        if (i == 0 || order[i]->time > order[i - 1]->time)
            visit(argument, order[i]->time, order[i]->value);
}

void curves_walk(const struct curves *c, size_t k, curves_visit *visit, void *argument)
{
    for (size_t i = 0; i < c->buckets; i++) {
        const struct part *part = &c->parts[i * c->count + k];
        if (part->any)
            walk_part(part, visit, argument);
        else
            visit(argument, c->opened[i], NAN);
    }
}
