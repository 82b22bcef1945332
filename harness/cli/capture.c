/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "cli/capture.h"

#include <errno.h>

static int to_file(void *argument, const void *data, size_t size)
{
    struct capture *capture = argument;
    errno = 0;
    if (fwrite(data, 1, size, capture->output.stream) == size &&
        fflush(capture->output.stream) == 0)
        return 0;
    return errno != 0 ? -errno : -EIO;
}

int capture_open(struct capture *capture, const char *path, uint64_t epoch_ns)
{
    const int r = output_open(&capture->output, path);
    if (r != 0)
        return r;
    capture->path = path;
    pcap_open(&capture->pcap, PCAP_FILE, to_file, capture, epoch_ns);
    return 0;
}

int capture_close(struct capture *capture)
{
    if (capture->path == NULL)
        return 0;
    capture->path = NULL;
    const int written = pcap_close(&capture->pcap);
    const int closed = output_close(&capture->output, true);
    return written != 0 ? written : closed;
}

struct pcap *capture_pcap(struct capture *capture)
{
    return capture->path != NULL ? &capture->pcap : NULL;
}
