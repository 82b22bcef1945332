/* SPDX-License-Identifier: MIT */
/* fp_arch.h - musl's libm.h asks for it; no target of the SDK needs anything special here. */
