# SPDX-License-Identifier: MIT
# pe64: Windows PE32+ image, the .tgm of a 64-bit PC controller.
tgm_prefix  := x86_64-w64-mingw32-
tgm_cflags  := -fno-asynchronous-unwind-tables
tgm_script  := $(TGM_SDK)/link/pe64.def
tgm_ldflags := -nostdlib -shared -static -Wl,-e,0 -Wl,--no-insert-timestamp -Wl,--dynamicbase,--nxcompat,--high-entropy-va \
    -Wl,--fatal-warnings -Wl,--gc-sections -Wl,--exclude-all-symbols $(TGM_SDK)/link/pe64.def
