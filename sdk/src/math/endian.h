/* SPDX-License-Identifier: MIT */
/* endian.h - byte order, by the names that musl's libm.h uses. Not for authors. */
#ifndef TGM_SRC_MATH_ENDIAN_H
#define TGM_SRC_MATH_ENDIAN_H

#define __LITTLE_ENDIAN __ORDER_LITTLE_ENDIAN__
#define __BIG_ENDIAN    __ORDER_BIG_ENDIAN__
#define __BYTE_ORDER    __BYTE_ORDER__

#endif
