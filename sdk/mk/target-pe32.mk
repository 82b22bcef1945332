# SPDX-License-Identifier: MIT
# pe32: Windows PE32 image, the .tgm of a 32-bit PC controller.
tgm_prefix  := i686-w64-mingw32-
tgm_cflags  := -fno-asynchronous-unwind-tables -mstackrealign -msse2 -mfpmath=sse
tgm_script  := $(TGM_SDK)/link/pe32.def
tgm_ldflags := -nostdlib -shared -static -Wl,-e,0 -Wl,--no-insert-timestamp -Wl,--dynamicbase,--nxcompat \
    -Wl,--fatal-warnings -Wl,--gc-sections -Wl,--exclude-all-symbols $(TGM_SDK)/link/pe32.def
