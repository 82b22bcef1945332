/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/coverage.h"

#include <stdbool.h>
#include <string.h>

void coverage_take(struct coverage *coverage, const uint8_t *bits, uint64_t begin, uint64_t end)
{
    coverage->begin = begin;
    coverage->size = end - begin < COVERAGE_MOST ? end - begin : COVERAGE_MOST;
    memcpy(coverage->bits, bits, (coverage->size + 7) / 8);
}

void coverage_add(struct coverage *all, const struct coverage *one)
{
    if (one->size == 0)
        return;
    if (all->size == 0) {
        all->begin = one->begin;
        all->size = one->size;
    }
    if (one->begin != all->begin || one->size != all->size)
        return; /* of another module */
    for (uint64_t i = 0; i < (all->size + 7) / 8; i++)
        all->bits[i] |= one->bits[i];
}

static bool executed(const struct coverage *coverage, uint64_t address)
{
    const uint64_t bit = address - coverage->begin;
    return address >= coverage->begin && bit < coverage->size &&
           (coverage->bits[bit / 8] >> bit % 8 & 1) != 0;
}

uint64_t coverage_count(const struct coverage *coverage, uint64_t address, uint64_t size)
{
    uint64_t count = 0;
    for (uint64_t i = 0; i < size && i < COVERAGE_MOST; i++)
        count += executed(coverage, address + i);
    return count;
}

uint64_t coverage_gap(const struct coverage *coverage, uint64_t address, uint64_t size)
{
    for (uint64_t i = 0; i < size && i < COVERAGE_MOST; i++)
        if (!executed(coverage, address + i))
            return address + i;
    return address + size;
}

void coverage_clean(struct coverage *coverage)
{
    if (coverage->size > COVERAGE_MOST)
        coverage->size = COVERAGE_MOST;
}
