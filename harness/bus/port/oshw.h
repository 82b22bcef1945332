/* SPDX-License-Identifier: GPL-2.0-or-later */
/* oshw.h - the network side of SOEM's platform interface. */
#ifndef HARNESS_BUS_PORT_OSHW_H
#define HARNESS_BUS_PORT_OSHW_H

#include "ethercattype.h"
#include "nicdrv.h"
#include "ethercatmain.h"

uint16 oshw_htons(uint16 hostshort);
uint16 oshw_ntohs(uint16 networkshort);
ec_adaptert *oshw_find_adapters(void);
void oshw_free_adapters(ec_adaptert *adapter);

#endif
