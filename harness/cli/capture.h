/* SPDX-License-Identifier: GPL-2.0-or-later */
/* capture.h - --pcap of every command that has a bus. */
#ifndef HARNESS_CLI_CAPTURE_H
#define HARNESS_CLI_CAPTURE_H

#include "bus/pcap.h"
#include "cli/cli.h"

struct capture {
    const char *path; /* NULL: no capture */
    struct output output;
    struct pcap pcap;
};

/* 0, or negative errno when the file cannot be made. epoch_ns: wall time of time 0, 0 when time is
 * simulated. */
int capture_open(struct capture *capture, const char *path, uint64_t epoch_ns);
/* Writes what is left. 0, or the first error of all the writing. Nothing happens when it is not
 * open. */
int capture_close(struct capture *capture);
/* For struct host_config and struct wire: NULL when it is not open. */
struct pcap *capture_pcap(struct capture *capture);

#endif
