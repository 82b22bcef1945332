# SPDX-License-Identifier: MIT
# tgmcontroller: flat image for the Cortex-A9 of TGMcontroller (generation 5, UTF-8 text), linked at 0x07800000
# within 0x00800000 bytes. The vendor's stamper, which turns .tgm.bin into .tgm_controller, is closed and its stamp
# is not documented: the build ends at the .tgm.bin.
TGM_GENERATION ?= 5
tgm_prefix  := arm-none-eabi-
tgm_flat    := yes
tgm_cflags  := -DTGM_TEXT8 -DTGM_FLAT -marm -mcpu=cortex-a9 -mfpu=vfpv3 -mfloat-abi=hard -fno-common
tgm_script  := $(TGM_SDK)/link/flat.ld
tgm_sources := flat.c arm.c
tgm_ldflags := -nostdlib -static -marm -mcpu=cortex-a9 -mfpu=vfpv3 -mfloat-abi=hard -Wl,-T,$(TGM_SDK)/link/flat.ld \
    -Wl,--build-id=none -Wl,--fatal-warnings -Wl,--orphan-handling=error -Wl,--gc-sections -Wl,-z,max-page-size=4096
