/* SPDX-License-Identifier: GPL-2.0-or-later */
/* live_socket.h - the network interface of a live bus: which one, whether it may be, its socket. */
#ifndef HARNESS_BUS_LIVE_SOCKET_H
#define HARNESS_BUS_LIVE_SOCKET_H

#include "bus/live.h"

/* A non-blocking raw socket for EtherCAT frames that does not see what it sends itself, or negative
 * errno with a sentence in `why`. */
int live_socket(const char *interface, bool real_network, char why[LIVE_WHY]);

/* vsnprintf into `why`; returns error. */
int live_fail(char why[LIVE_WHY], int error, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
