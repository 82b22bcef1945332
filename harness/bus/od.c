/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/od.h"
#include "bus/bytes.h"
#include "bus/registers.h"

#include <string.h>

const struct od_object *od_find(const struct od *od, uint16_t index)
{
    size_t low = 0, high = od->count;

    while (low < high) {
        size_t middle = (low + high) / 2;

        if (od->objects[middle].index == index)
            return &od->objects[middle];
        if (od->objects[middle].index < index)
            low = middle + 1;
        else
            high = middle;
    }
    return NULL;
}

const struct od_entry *od_entry(const struct od_object *object, uint8_t subindex)
{
    for (unsigned i = 0; i < object->count; i++) {
        const struct od_entry *e = &object->entries[i];

        if (subindex >= e->first && subindex <= e->last)
            return e;
    }
    return NULL;
}

uint8_t od_max_subindex(const struct od_object *object)
{
    return object->entries[object->count - 1].last;
}

unsigned od_type_bits(uint8_t type)
{
    if (type >= OD_BIT1 && type <= OD_BIT8)
        return type - OD_BIT1 + 1u;
    switch (type) {
    case OD_BOOL:
        return 1;
    case OD_I8:
    case OD_U8:
        return 8;
    case OD_I16:
    case OD_U16:
        return 16;
    case OD_I32:
    case OD_U32:
    case OD_REAL32:
        return 32;
    case OD_I64:
    case OD_U64:
    case OD_REAL64:
        return 64;
    default:
        return 0;
    }
}

unsigned od_type_bytes(uint8_t type)
{
    return (od_type_bits(type) + 7) / 8;
}

bool od_type_signed(uint8_t type)
{
    return type == OD_I8 || type == OD_I16 || type == OD_I32 || type == OD_I64;
}

static uint8_t *value_at(void *device, const struct od_entry *e, uint8_t subindex)
{
    return (uint8_t *)device + e->offset + (size_t)(subindex - e->first) * od_type_bytes(e->type);
}

uint64_t od_load(const uint8_t *at, unsigned bytes)
{
    uint16_t word;
    uint32_t half;
    uint64_t value;

    switch (bytes) {
    case 1:
        return *at;
    case 2:
        memcpy(&word, at, sizeof word);
        return word;
    case 4:
        memcpy(&half, at, sizeof half);
        return half;
    default:
        memcpy(&value, at, sizeof value);
        return value;
    }
}

void od_store(uint8_t *at, unsigned bytes, uint64_t value)
{
    uint16_t word = (uint16_t)value;
    uint32_t half = (uint32_t)value;

    switch (bytes) {
    case 1:
        *at = (uint8_t)value;
        break;
    case 2:
        memcpy(at, &word, sizeof word);
        break;
    case 4:
        memcpy(at, &half, sizeof half);
        break;
    default:
        memcpy(at, &value, sizeof value);
    }
}

void od_reset(const struct od *od, void *device)
{
    for (size_t i = 0; i < od->count; i++) {
        const struct od_object *object = &od->objects[i];

        for (unsigned k = 0; k < object->count; k++) {
            const struct od_entry *e = &object->entries[k];

            if (e->type == OD_STRING || e->offset == OD_CONST)
                continue;
            for (unsigned sub = e->first; sub <= e->last; sub++)
                od_store(value_at(device, e, (uint8_t)sub), od_type_bytes(e->type),
                         (uint64_t)e->initial);
        }
    }
}

static uint32_t find(const struct od *od, uint16_t index, uint8_t subindex,
                     const struct od_entry **entry)
{
    const struct od_object *object = od_find(od, index);

    if (!object)
        return SDO_NO_OBJECT;
    *entry = od_entry(object, subindex);
    return *entry ? SDO_OK : SDO_NO_SUBINDEX;
}

static unsigned state_bit(unsigned state, unsigned preop)
{
    return state == AL_OP ? preop << 2 : state == AL_SAFEOP ? preop << 1 : preop;
}

static uint32_t access_abort(uint16_t access, unsigned state, unsigned first, unsigned all,
                             uint32_t never)
{
    if (!(access & all))
        return never;
    return access & state_bit(state, first) ? SDO_OK : SDO_DEVICE_STATE;
}

uint32_t od_read(const struct od *od, void *device, unsigned state, uint16_t index,
                 uint8_t subindex, uint8_t *data, size_t *size)
{
    const struct od_entry *e;
    uint32_t abort = find(od, index, subindex, &e);
    uint8_t bytes[8];
    const void *from = bytes;
    size_t length;

    if (!abort)
        abort = access_abort(e->access, state, OD_RD_PREOP, OD_RO, SDO_WRITE_ONLY);
    if (abort)
        return abort;
    if (od->refresh)
        od->refresh(device);
    length = od_type_bytes(e->type);
    if (length) {
        put_u64(bytes, e->offset == OD_CONST
                           ? (uint64_t)e->initial
                           : od_load(value_at(device, e, subindex), (unsigned)length));
    } else {
        from = e->text;
        length = strlen(e->text);
    }
    if (length > *size)
        return SDO_MEMORY;
    memcpy(data, from, length);
    *size = length;
    return SDO_OK;
}

static int64_t signed_value(uint8_t type, uint64_t raw)
{
    switch (type) {
    case OD_I8:
        return (int8_t)raw;
    case OD_I16:
        return (int16_t)raw;
    case OD_I32:
        return (int32_t)raw;
    default:
        return (int64_t)raw;
    }
}

uint32_t od_write(const struct od *od, void *device, unsigned state, uint16_t index,
                  uint8_t subindex, const uint8_t *data, size_t size)
{
    const struct od_entry *e;
    uint32_t abort = find(od, index, subindex, &e);
    uint8_t bytes[8] = { 0 };
    size_t length;
    uint64_t raw;

    if (!abort)
        abort = access_abort(e->access, state, OD_WR_PREOP, OD_WR_PREOP | OD_WR_SAFEOP | OD_WR_OP,
                             SDO_READ_ONLY);
    if (abort)
        return abort;
    length = od_type_bytes(e->type);
    if (size != length)
        return size > length ? SDO_TOO_LONG : SDO_TOO_SHORT;
    memcpy(bytes, data, size);
    raw = get_u64(bytes);
    if (od_type_bits(e->type) < 8 && raw >> od_type_bits(e->type))
        return SDO_RANGE;
    abort = pdo_check(od, device, index, subindex, signed_value(e->type, raw));
    if (!abort && od->check)
        abort = od->check(device, index, subindex, signed_value(e->type, raw));
    if (abort)
        return abort;
    od_store(value_at(device, e, subindex), (unsigned)length, raw);
    if (od->written)
        od->written(device, index, subindex);
    return SDO_OK;
}
