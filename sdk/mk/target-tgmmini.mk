# SPDX-License-Identifier: MIT
# tgmmini: ELF shared object for 32-bit Arm Linux (TGMmini, generation 5, UTF-8 text).
TGM_GENERATION ?= 5
tgm_prefix  := arm-linux-gnueabihf-
tgm_cflags  := -fPIC -fvisibility=hidden -fno-asynchronous-unwind-tables -DTGM_TEXT8 -marm -march=armv7-a -mfpu=vfpv3-d16
tgm_script  := $(TGM_SDK)/link/arm32.ld $(TGM_SDK)/link/elf64.map
tgm_sources := arm.c
tgm_ldflags := -nostdlib -shared -Wl,-T,$(TGM_SDK)/link/arm32.ld -Wl,--version-script=$(TGM_SDK)/link/elf64.map \
    -Wl,-z,defs -Wl,-z,noexecstack -Wl,-Bsymbolic -Wl,-e,0 -Wl,--hash-style=gnu -Wl,-z,norelro \
    -Wl,-z,max-page-size=4096 -Wl,--build-id=none -Wl,--fatal-warnings -Wl,--orphan-handling=error -Wl,--gc-sections
