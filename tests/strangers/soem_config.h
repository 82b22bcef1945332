/* SPDX-License-Identifier: GPL-2.0-or-later */
/* soem_config.h - SOEM's time-outs, in us, for a machine that is busy with other tests. */
#define EC_TIMEOUTRET   50000
#define EC_TIMEOUTRET3  (EC_TIMEOUTRET * 3)
#define EC_TIMEOUTSAFE  100000
#define EC_TIMEOUTEEP   100000
#define EC_TIMEOUTTXM   200000
#define EC_TIMEOUTRXM   1000000
#define EC_TIMEOUTSTATE 4000000
