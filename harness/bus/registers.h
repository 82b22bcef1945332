/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * registers.h - addresses and bits of the EtherCAT slave controller's register file, as far as the
 * simulated controller has them. Names are those of the Beckhoff register description; the facts
 * and their sources stand in the EtherCAT reference, section 3.
 */
#ifndef HARNESS_BUS_REGISTERS_H
#define HARNESS_BUS_REGISTERS_H

enum {
    REG_TYPE = 0x0000,
    REG_REVISION = 0x0001,
    REG_BUILD = 0x0002,
    REG_FMMU_COUNT = 0x0004,
    REG_SM_COUNT = 0x0005,
    REG_RAM_SIZE = 0x0006,
    REG_PORTS = 0x0007,
    REG_FEATURES = 0x0008,
    REG_STATION_ADDRESS = 0x0010,
    REG_STATION_ALIAS = 0x0012,
    REG_WRITE_ENABLE = 0x0020,
    REG_WRITE_PROTECTION = 0x0021,
    REG_ESC_WRITE_ENABLE = 0x0030,
    REG_ESC_WRITE_PROTECTION = 0x0031,
    REG_ECAT_RESET = 0x0040,
    REG_DL_CONTROL = 0x0100,
    REG_PHYSICAL_OFFSET = 0x0108,
    REG_DL_STATUS = 0x0110,
    REG_AL_CONTROL = 0x0120,
    REG_AL_STATUS = 0x0130,
    REG_AL_STATUS_CODE = 0x0134,
    REG_PDI_CONTROL = 0x0140,
    REG_ESC_CONFIG = 0x0141,
    REG_PDI_CONFIG = 0x0150,
    REG_PDI_CONFIG_EXT = 0x0152,
    REG_ECAT_EVENT_MASK = 0x0200,
    REG_ECAT_EVENT = 0x0210,
    REG_AL_EVENT = 0x0220,
    REG_RX_ERRORS = 0x0300,
    REG_FORWARDED_ERRORS = 0x0308,
    REG_PU_ERRORS = 0x030c,
    REG_PDI_ERRORS = 0x030d,
    REG_LOST_LINK = 0x0310,
    REG_WD_DIVIDER = 0x0400,
    REG_WD_PDI = 0x0410,
    REG_WD_SM = 0x0420,
    REG_WD_STATUS = 0x0440,
    REG_WD_COUNT = 0x0442,
    REG_EEPROM_OWNER = 0x0500,
    REG_EEPROM_PDI = 0x0501,
    REG_EEPROM_CONTROL = 0x0502,
    REG_EEPROM_ADDRESS = 0x0504,
    REG_EEPROM_DATA = 0x0508,
    REG_FMMU = 0x0600,
    REG_SM = 0x0800,
    REG_DC_PORT_TIME = 0x0900,
    REG_DC_SYSTEM_TIME = 0x0910,
    REG_DC_RECEIVE_TIME = 0x0918,
    REG_DC_OFFSET = 0x0920,
    REG_DC_DELAY = 0x0928,
    REG_DC_DIFFERENCE = 0x092c,
    REG_DC_SPEED_START = 0x0930,
    REG_DC_SPEED_DIFF = 0x0932,
    REG_DC_FILTER = 0x0934,
    REG_DC_CUC = 0x0980,
    REG_DC_ACTIVATION = 0x0981,
    REG_DC_PULSE = 0x0982,
    REG_DC_ACTIVATION_STATUS = 0x0984,
    REG_DC_SYNC_STATUS = 0x098e,
    REG_DC_START = 0x0990,
    REG_DC_NEXT1 = 0x0998,
    REG_DC_CYCLE0 = 0x09a0,
    REG_DC_CYCLE1 = 0x09a4,
    REG_DIGITAL_OUT = 0x0f00,
    REG_GPO = 0x0f10,
    REG_RAM = 0x1000,
};

enum {
    FEATURE_DC = 1 << 2,
    FEATURE_DC_64 = 1 << 3,
    FEATURE_DC_SYNC = 1 << 8, /* 0x0981 bits 3 to 7 */

    DL_CONTROL_FORWARDING = 1 << 0, /* in byte 0: destroy non-EtherCAT frames, mark source */
    DL_CONTROL_ALIAS = 1 << 0,      /* in byte 3: station alias usable in FP* */
    DL_STATUS_PDI = 1 << 0,
    DL_STATUS_WD_PDI = 1 << 1,

    AL_INIT = 1,
    AL_PREOP = 2,
    AL_BOOT = 3,
    AL_SAFEOP = 4,
    AL_OP = 8,
    AL_STATE = 0x0f,
    AL_ERROR = 0x10,     /* in AL status; acknowledge in AL control */
    AL_DEVICE_ID = 0x20, /* asked for in AL control, answered in AL status */

    EVENT_DC_LATCH = 1 << 0,
    EVENT_DL_STATUS = 1 << 2,
    EVENT_AL_STATUS = 1 << 3,
    EVENT_SM0 = 1 << 4, /* and the following: in the ECAT event request */

    AL_EVENT_CONTROL = 1 << 0,
    AL_EVENT_SYNC0 = 1 << 2,
    AL_EVENT_SM0 = 1 << 8,

    SM_LENGTH = 2,
    SM_CONTROL = 4,
    SM_STATUS = 5,
    SM_ACTIVATE = 6,
    SM_PDI_CONTROL = 7,
    SM_SIZE = 8,

    SM_CONTROL_MODE = 0x03,
    SM_CONTROL_MAILBOX = 0x02,
    SM_CONTROL_WRITE = 0x04, /* the master writes */
    SM_CONTROL_ECAT_IRQ = 0x10,
    SM_CONTROL_AL_IRQ = 0x20,
    SM_CONTROL_WATCHDOG = 0x40,
    SM_STATUS_WRITTEN = 0x01, /* interrupt on write */
    SM_STATUS_READ = 0x02,    /* interrupt on read */
    SM_STATUS_FULL = 0x08,
    SM_STATUS_BUFFER = 0x30,
    SM_STATUS_READING = 0x40, /* the master is in the middle of a buffer */
    SM_STATUS_WRITING = 0x80,
    SM_ACTIVATE_ENABLE = 0x01,
    SM_ACTIVATE_REPEAT = 0x02,
    SM_PDI_DEACTIVATE = 0x01,
    SM_PDI_REPEAT_ACK = 0x02,

    FMMU_SIZE = 16,
};

/* AL status codes the controller model gives itself (ETG.1020). */
enum {
    AL_CODE_NONE = 0x0000,
    AL_CODE_INVALID_CHANGE = 0x0011,
    AL_CODE_UNKNOWN_STATE = 0x0012,
    AL_CODE_NO_BOOT = 0x0013,
    AL_CODE_MAILBOX_CONFIG = 0x0016,
    AL_CODE_NO_OUTPUTS = 0x0019,
    AL_CODE_WATCHDOG = 0x001b,
    AL_CODE_OUTPUT_CONFIG = 0x001d,
    AL_CODE_INPUT_CONFIG = 0x001e,
    AL_CODE_WATCHDOG_CONFIG = 0x001f,
    AL_CODE_INPUT_MAPPING = 0x0024,
    AL_CODE_OUTPUT_MAPPING = 0x0025,
    AL_CODE_DC_CONFIG = 0x0030,
};

#endif
