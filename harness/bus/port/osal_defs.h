/* SPDX-License-Identifier: GPL-2.0-or-later */
/* osal_defs.h - what SOEM's osal.h asks of a platform. No threads, no debug output. */
#ifndef HARNESS_BUS_PORT_OSAL_DEFS_H
#define HARNESS_BUS_PORT_OSAL_DEFS_H

#define EC_PRINT(...)                                                                              \
    do {                                                                                           \
    } while (0)

#define PACKED_BEGIN
#define PACKED __attribute__((__packed__))
#define PACKED_END

#define OSAL_THREAD_HANDLE  void *
#define OSAL_THREAD_FUNC    void
#define OSAL_THREAD_FUNC_RT void

#endif
