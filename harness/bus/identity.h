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
#ifndef BUS_REVISION
#define BUS_REVISION 0x00010000u
#endif

#endif
