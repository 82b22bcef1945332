/* SPDX-License-Identifier: GPL-2.0-or-later */
/* frame.h - an EtherCAT frame as it travels: offsets, masks and commands. */
#ifndef HARNESS_BUS_FRAME_H
#define HARNESS_BUS_FRAME_H

enum {
    ETHER_TYPE = 12,
    ETHER_HEADER = 14,
    ETHER_ECAT = 0xa488, /* 0x88A4 is big-endian on the wire */
    ETHER_OVERHEAD = 24, /* preamble, FCS, gap: bytes on the wire, not in the frame */
    SOURCE_MAC = 6,
    LOCAL_BIT = 2,
    ECAT_HEADER = 2,
    ECAT_LENGTH = 0x07ff,
    ECAT_DATAGRAMS = 1,
    DG_HEADER = 10,
    DG_WKC = 2,
    DG_LENGTH = 0x07ff,
    DG_CIRCULATING = 0x4000,
    DG_MORE = 0x8000,
    BYTE_NS = 80,
};

enum command { NOP, APRD, APWR, APRW, FPRD, FPWR, FPRW, BRD, BWR, BRW, LRD, LWR, LRW, ARMW, FRMW };

#endif
