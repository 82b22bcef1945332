/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * TGM_General of generation 5: slaves that are neither servos nor I/O units (C8).
 *
 * On a controller the PLC sets sync managers and FMMUs of such a device itself and says which
 * logical addresses the host shall exchange. Here every slave has been configured by the bus, up to
 * OP; User_PDO_Output and User_PDO_Input are those of its process data as its own mapping has them.
 * What the PLC writes to sync managers and FMMUs by the register block reaches the slave and takes
 * effect there; the logical addresses in the registers are read by nobody.
 */
#include "host/host_parts.h"

#if TGM_GENERATION == 5

#include <string.h>

enum { SYNC_MANAGERS = 0x0800, SYNC_MANAGER_SIZE = 8 };
/* bUseLRW; the headers of 5.00 do not name them */
enum {
    USE_LRW = 0x01,
    ALSO_IN_SAFEOP = 0x02,
    OUT_LOCK = 0x04,
    IN_LOCK = 0x08,
    COMPLETE_SDO = 0x10,
    RATE_SHIFT = 16
};
enum { WKC_READ = 1, WKC_WRITE = 1, WKC_BOTH = 3 };

static GENERAL_DEVICE *register_of(const struct host *host, const struct general *general)
{
    GENERAL_MEMORY *memory = host->memory[SHARED_MEMORY_GENERAL];
    return &memory->general_devices[general - host->generals];
}

static uint8_t *place(const struct host *host, size_t slave, enum bus_direction direction,
                      unsigned bits, size_t *bytes)
{
    const struct bus_entry first = bus_bits(host->bus, slave, direction, 0, 1);
    /* Bits in the middle of a byte are those of a terminal with a few channels: not for us. */
    *bytes = first.bits == 0 || first.bit != 0 ? 0 : bits / 8;
    if (*bytes > GENERAL_PDO_MAX)
        *bytes = GENERAL_PDO_MAX;
    return first.byte;
}

static void read_managers(struct host *host, struct general *general)
{
    general->managers = (struct bus_job){ .kind = BUS_REGISTER_READ,
                                          .slave = general->slave,
                                          .index = SYNC_MANAGERS,
                                          .size = 2 * SYNC_MANAGER_SIZE };
    bus_job_start(host->bus, &general->managers);
}

static void device_open(struct host *host, size_t slave)
{
    const struct bus_slave *seen = bus_slave(host->bus, slave);
    struct general *general = &host->generals[host->general_count++];
    GENERAL_DEVICE *reg = register_of(host, general);
    general->slave = slave;
    general->outputs = place(host, slave, BUS_OUTPUT, seen->output_bits, &general->output_bytes);
    general->inputs = place(host, slave, BUS_INPUT, seen->input_bits, &general->input_bytes);
    general->sdo = (struct channel){ .kind = CHANNEL_SDO,
                                     .words = &reg->CompleteSDO.Control,
                                     .most = GENERAL_SDO_MAX,
                                     .slave = slave };
    general->block = (struct channel){
        .kind = CHANNEL_REGISTER, .words = &reg->Control, .most = GENERAL_DATA_MAX, .slave = slave
    };
    reg->VendorID = seen->vendor;
    reg->ProductID = seen->product;
    reg->DeviceIndex = (uint32_t)(general - host->generals);
    reg->ECATBusPosition = (uint32_t)slave;
    reg->logicalWriteAddress = bus_logical_address(host->bus, slave, BUS_OUTPUT);
    reg->logicalReadAddress = bus_logical_address(host->bus, slave, BUS_INPUT);
    reg->logicalReadWriteAddress = reg->logicalWriteAddress;
    read_managers(host, general);
}

static int general_open(struct host *host, char why[HOST_WHY])
{
    (void)why;
    for (size_t slave = 0; host->bus != NULL && slave < bus_slave_count(host->bus); slave++) {
        const struct bus_slave *seen = bus_slave(host->bus, slave);
        const bool silent = seen->input_bits + seen->output_bits == 0;
        if (host->general_count < GENERAL_DEVICES && !silent && !host->taken[slave])
            device_open(host, slave);
    }
    return 0;
}

/* --- process data --- */

/* In this cycle, by the divider of the PLC. */
static bool due(const struct host *host, const GENERAL_DEVICE *reg)
{
    const uint32_t divider = reg->bUseLRW >> RATE_SHIFT;
    return divider <= 1 || host->cycle % divider == 0;
}

static bool exchanges(const struct host *host, const struct general *general,
                      const GENERAL_DEVICE *reg)
{
    const unsigned state = bus_slave(host->bus, general->slave)->al_state & 0x0Fu;
    if (!host->exchanged || (reg->User_PDO_Output_Size == 0 && reg->User_PDO_Input_Size == 0))
        return false;
    if ((reg->bUseLRW & USE_LRW) != 0 && reg->User_PDO_Output_Size != reg->User_PDO_Input_Size)
        return false; /* one datagram has one length */
    return state == ETHERCAT_STATE_OP ||
           (state == ETHERCAT_STATE_SAFEOP && (reg->bUseLRW & ALSO_IN_SAFEOP) != 0);
}

static size_t fewer(size_t a, size_t b)
{
    return a < b ? a : b;
}

#if TGM_MEMORY_ID == 906
/* True when the outputs are whole; they are then taken as sent. */
static bool outputs_offered(GENERAL_DEVICE *reg)
{
    if ((reg->bUseLRW & OUT_LOCK) == 0)
        return true;
    return reg->PLC_Send_Lock_Value != reg->TGM_Send_Lock_Value;
}

static void outputs_taken(GENERAL_DEVICE *reg)
{
    if ((reg->bUseLRW & OUT_LOCK) != 0)
        reg->TGM_Send_Lock_Value = reg->PLC_Send_Lock_Value;
}

static bool inputs_wanted(const GENERAL_DEVICE *reg)
{
    return (reg->bUseLRW & IN_LOCK) == 0 || reg->TGM_Recv_Lock_Value == reg->PLC_Recv_Lock_Value;
}

static void inputs_given(GENERAL_DEVICE *reg)
{
    if ((reg->bUseLRW & IN_LOCK) != 0)
        reg->TGM_Recv_Lock_Value++;
}
#else
static bool outputs_offered(const GENERAL_DEVICE *reg)
{
    (void)reg;
    return true;
}

static void outputs_taken(GENERAL_DEVICE *reg)
{
    (void)reg;
}

static bool inputs_wanted(const GENERAL_DEVICE *reg)
{
    (void)reg;
    return true;
}

static void inputs_given(GENERAL_DEVICE *reg)
{
    (void)reg;
}
#endif

/* A frame that came back whole had every slave behind it: what this one added is known. */
static void count(GENERAL_DEVICE *reg, bool good)
{
    const bool both = (reg->bUseLRW & USE_LRW) != 0;
    reg->read_write_wkc = good && both ? WKC_BOTH : 0;
    reg->read_wkc = good && !both && reg->User_PDO_Input_Size > 0 ? WKC_READ : 0;
    reg->write_wkc = good && !both && reg->User_PDO_Output_Size > 0 ? WKC_WRITE : 0;
}

static void device_receive(struct host *host, struct general *general)
{
    GENERAL_DEVICE *reg = register_of(host, general);
    if (!due(host, reg))
        return;
    const bool good = host->frame_back && exchanges(host, general, reg);
    count(reg, good);
    if (!good || !inputs_wanted(reg))
        return;
    memcpy(reg->User_PDO_Input, general->inputs,
           fewer(reg->User_PDO_Input_Size, general->input_bytes));
    inputs_given(reg);
}

static void device_send(struct host *host, struct general *general)
{
    GENERAL_DEVICE *reg = register_of(host, general);
    if (!due(host, reg) || !exchanges(host, general, reg) || !outputs_offered(reg))
        return;
    memcpy(general->outputs, reg->User_PDO_Output,
           fewer(reg->User_PDO_Output_Size, general->output_bytes));
    outputs_taken(reg);
}

/* --- channels --- */

static uint16_t word(const uint8_t *at)
{
    return (uint16_t)(at[0] | at[1] << 8);
}

static void note_mailboxes(struct general *general)
{
    const uint8_t *data = general->managers.data;
    if (general->mailboxes.known || !general->managers.done || general->managers.result != 0)
        return;
    general->mailboxes = (struct general_mailboxes){
        .out = word(data),
        .out_size = word(data + 2),
        .in = word(data + SYNC_MANAGER_SIZE),
        .in_size = word(data + SYNC_MANAGER_SIZE + 2),
        .known = true,
    };
}

/* With other addresses the request would never reach the slave's mailbox. */
static bool mailboxes_wrong(const struct general *general, const GENERAL_DEVICE *reg)
{
    const struct general_mailboxes *m = &general->mailboxes;
    return m->known && (reg->mailBoxOutAddress != m->out || reg->mailBoxInAddress != m->in ||
                        reg->mailBoxSize != m->out_size || reg->mailBoxSize != m->in_size);
}

static void device_channels(struct host *host, struct general *general)
{
    GENERAL_DEVICE *reg = register_of(host, general);
    note_mailboxes(general);
    general->sdo.complete = (reg->bUseLRW & COMPLETE_SDO) != 0;
    if (channel_asked(&general->sdo) && mailboxes_wrong(general, reg))
        channel_log(host, &general->sdo, channel_refuse(&general->sdo));
    else if (general->managers.done)
        channel_log(host, &general->sdo, channel_step(&general->sdo, host->bus));
    channel_step(&general->block, host->bus);
}

static void general_receive(struct host *host)
{
    for (size_t i = 0; i < host->general_count; i++) {
        struct general *general = &host->generals[i];
        register_of(host, general)->EtherCATState =
            bus_slave(host->bus, general->slave)->al_state & 0x0F;
        device_receive(host, general);
        device_channels(host, general);
    }
}

static void general_send(struct host *host)
{
    for (size_t i = 0; i < host->general_count; i++)
        device_send(host, &host->generals[i]);
}

const struct host_part host_general = {
    .name = "general", .open = general_open, .receive = general_receive, .send = general_send
};

#else
const struct host_part host_general = { .name = "general" };
#endif
