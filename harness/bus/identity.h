/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * identity.h - who the simulated devices say they are. These are not identities of real products:
 * the vendor id is outside what the EtherCAT Technology Group has given out. Whoever needs the
 * identity of a real device for a master's configuration sets it in a bus file or device file.
 */
#ifndef HARNESS_BUS_IDENTITY_H
#define HARNESS_BUS_IDENTITY_H

#ifndef BUS_VENDOR
#define BUS_VENDOR 0x5447534du /* "TGSM" */
#endif
#ifndef BUS_PRODUCT_DRIVE
#define BUS_PRODUCT_DRIVE 0x04020001u
#endif
#ifndef BUS_PRODUCT_DRIVE_X2
#define BUS_PRODUCT_DRIVE_X2 0x04020002u
#endif
#ifndef BUS_PRODUCT_DRIVE_HEAVY
#define BUS_PRODUCT_DRIVE_HEAVY 0x04020011u
#endif
#ifndef BUS_PRODUCT_DRIVE_ROTARY
#define BUS_PRODUCT_DRIVE_ROTARY 0x04020012u
#endif
#ifndef BUS_PRODUCT_DRIVE_IDEAL
#define BUS_PRODUCT_DRIVE_IDEAL 0x04020013u
#endif
#ifndef BUS_PRODUCT_TGZ
#define BUS_PRODUCT_TGZ 0x04020021u
#endif
#ifndef BUS_REVISION
#define BUS_REVISION 0x00010000u
#endif

#endif
