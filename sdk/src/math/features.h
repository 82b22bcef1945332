/* SPDX-License-Identifier: MIT */
/* features.h - compiler features, by the names that musl's sources use. Not for authors. */
#ifndef TGM_SRC_MATH_FEATURES_H
#define TGM_SRC_MATH_FEATURES_H

#ifdef __ELF__
#define hidden __attribute__((__visibility__("hidden")))
#else
#define hidden
#endif

/* Second names (drem for remainder) are not part of the library. */
#define weak_alias(old, new) _Static_assert(1, "")

#endif
