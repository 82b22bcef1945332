/* SPDX-License-Identifier: GPL-2.0-or-later */
/* PDO assignment (0x1C12/0x1C13) and mapping (0x16xx/0x1Axx): write rules, and their resolution
 * into a list of moves that the cyclic exchange walks. */
#include "bus/bytes.h"
#include "bus/od.h"
#include "bus/registers.h"

#include <string.h>

static struct pdo_assign *assign_of(const struct od_pdo *pdo, void *device)
{
    return (struct pdo_assign *)((uint8_t *)device + pdo->assign_offset);
}

static struct pdo_map *map_of(const struct od_pdo *pdo, void *device, uint16_t index)
{
    struct pdo_map *maps = (struct pdo_map *)((uint8_t *)device + pdo->map_offset);

    for (unsigned i = 0; i < pdo->map_count; i++) {
        if (index == (pdo->map_list ? pdo->map_list[i] : pdo->map_first + i))
            return &maps[i];
    }
    return NULL;
}

static uint32_t check_mapped(const struct od *od, const struct od_pdo *pdo, uint32_t entry,
                             const struct od_entry **found)
{
    const struct od_object *object = od_find(od, (uint16_t)(entry >> 16));

    *found = NULL;
    if (entry >> 16 == 0)
        return (entry & 0xff) % 8 ? SDO_PDO_LENGTH : SDO_OK;
    if (!object)
        return SDO_NO_OBJECT;
    *found = od_entry(object, (uint8_t)(entry >> 8));
    if (!*found)
        return SDO_NO_SUBINDEX;
    if (!((*found)->access & pdo->mappable))
        return SDO_NOT_MAPPABLE;
    return od_type_bits((*found)->type) == (entry & 0xff) ? SDO_OK : SDO_PDO_LENGTH;
}

/* Count first to zero, then the entries, then the count: what masters do, and the only order in
 * which a half-written list is never taken for a whole one. */
static uint32_t check_list(uint8_t count, uint8_t subindex, uint8_t room, int64_t value)
{
    if (subindex == 0)
        return value <= room ? SDO_OK : SDO_RANGE;
    return count ? SDO_SUB0_NOT_ZERO : SDO_OK;
}

static uint32_t check_direction(const struct od *od, const struct od_pdo *pdo, void *device,
                                uint16_t index, uint8_t subindex, int64_t value)
{
    const struct pdo_map *map = map_of(pdo, device, index);
    const struct od_entry *unused;
    uint32_t abort;

    if (index == pdo->assign_index) {
        abort = check_list(assign_of(pdo, device)->count, subindex, PDO_MAX_ASSIGN, value);
        if (!abort && subindex && !map_of(pdo, device, (uint16_t)value))
            abort = SDO_RANGE;
        return abort;
    }
    if (!map)
        return SDO_OK;
    abort = check_list(map->count, subindex, PDO_MAX_ENTRIES, value);
    if (!abort && subindex)
        abort = check_mapped(od, pdo, (uint32_t)value, &unused);
    return abort;
}

uint32_t pdo_check(const struct od *od, void *device, uint16_t index, uint8_t subindex,
                   int64_t value)
{
    uint32_t abort = check_direction(od, &od->pdo[PDO_RX], device, index, subindex, value);

    return abort ? abort : check_direction(od, &od->pdo[PDO_TX], device, index, subindex, value);
}

static struct pdo_image *image_of(const struct od *od, void *device, enum pdo_direction direction)
{
    return (struct pdo_image *)((uint8_t *)device + od->pdo[direction].image_offset);
}

const struct pdo_image *pdo_image(const struct od *od, const void *device,
                                  enum pdo_direction direction)
{
    return (const struct pdo_image *)((const uint8_t *)device + od->pdo[direction].image_offset);
}

static uint32_t append(const struct od *od, const struct od_pdo *pdo, uint32_t entry,
                       struct pdo_image *image)
{
    const struct od_entry *found;
    uint32_t abort = check_mapped(od, pdo, entry, &found);
    struct pdo_copy *copy = &image->copy[image->count];

    if (abort)
        return abort;
    if (found) {
        copy->image = image->bits / 8;
        copy->bytes = (uint8_t)((entry & 0xff) / 8);
        copy->object = (uint16_t)(found->offset +
                                  ((entry >> 8 & 0xff) - found->first) * (uint32_t)copy->bytes);
        image->count++;
    }
    image->bits = (uint16_t)(image->bits + (entry & 0xff));
    return SDO_OK;
}

/* Large ones first, and otherwise in order: of an object mapped twice the last value counts. */
static void sort_by_size(struct pdo_image *image)
{
    for (unsigned i = 1; i < image->count; i++) {
        struct pdo_copy copy = image->copy[i];
        unsigned at = i;

        for (; at && image->copy[at - 1].bytes < copy.bytes; at--)
            image->copy[at] = image->copy[at - 1];
        image->copy[at] = copy;
    }
    for (unsigned i = 0; i < image->count; i++) {
        if (image->copy[i].bytes == 4)
            image->fours = (uint8_t)(i + 1);
        if (image->copy[i].bytes >= 2)
            image->twos = (uint8_t)(i + 1);
    }
}

uint16_t pdo_resolve(const struct od *od, void *device, enum pdo_direction direction)
{
    const struct od_pdo *pdo = &od->pdo[direction];
    const struct pdo_assign *assign = assign_of(pdo, device);
    struct pdo_image *image = image_of(od, device, direction);
    uint16_t refusal = direction == PDO_RX ? AL_CODE_OUTPUT_MAPPING : AL_CODE_INPUT_MAPPING;

    if (pdo->resolve)
        return pdo->resolve(device, direction);
    memset(image, 0, sizeof *image);
    for (unsigned i = 0; i < assign->count; i++) {
        const struct pdo_map *map = map_of(pdo, device, assign->pdo[i]);

        if (!map)
            return refusal;
        for (unsigned k = 0; k < map->count; k++) {
            if (append(od, pdo, map->entry[k], image))
                return refusal;
        }
    }
    sort_by_size(image);
    return image->bits / 8 > pdo->max_bytes ? refusal : 0;
}

static void move(uint8_t *to, const uint8_t *from, unsigned bytes)
{
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    memcpy(to, from, bytes);
#else
    for (unsigned i = 0; i < bytes; i++)
        to[i] = from[bytes - 1 - i];
#endif
}

void pdo_outputs_to_objects(const struct od *od, void *device, const uint8_t *data)
{
    const struct pdo_image *image = pdo_image(od, device, PDO_RX);
    const struct pdo_copy *c = image->copy;

    /* Fixed sizes compile to single moves. */
    for (; c < image->copy + image->fours; c++)
        move((uint8_t *)device + c->object, data + c->image, 4);
    for (; c < image->copy + image->twos; c++)
        move((uint8_t *)device + c->object, data + c->image, 2);
    for (; c < image->copy + image->count; c++)
        move((uint8_t *)device + c->object, data + c->image, 1);
}

void pdo_objects_to_inputs(const struct od *od, const void *device, uint8_t *data)
{
    const struct pdo_image *image = pdo_image(od, device, PDO_TX);
    const struct pdo_copy *c = image->copy;

    for (; c < image->copy + image->fours; c++)
        move(data + c->image, (const uint8_t *)device + c->object, 4);
    for (; c < image->copy + image->twos; c++)
        move(data + c->image, (const uint8_t *)device + c->object, 2);
    for (; c < image->copy + image->count; c++)
        move(data + c->image, (const uint8_t *)device + c->object, 1);
}
