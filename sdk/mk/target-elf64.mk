# SPDX-License-Identifier: MIT
# elf64: ELF shared object for x86-64 Linux, what the harness runs natively.
tgm_cflags  := -fPIC -fvisibility=hidden -fshort-wchar -fno-asynchronous-unwind-tables
tgm_script  := $(TGM_SDK)/link/elf64.ld $(TGM_SDK)/link/elf64.map
tgm_ldflags := -nostdlib -shared -Wl,-T,$(TGM_SDK)/link/elf64.ld -Wl,--version-script=$(TGM_SDK)/link/elf64.map \
    -Wl,-z,defs -Wl,-z,noexecstack -Wl,-Bsymbolic -Wl,-e,0 -Wl,--hash-style=gnu -Wl,-z,norelro \
    -Wl,-z,max-page-size=4096 -Wl,--build-id=none -Wl,--fatal-warnings -Wl,--orphan-handling=error -Wl,--gc-sections
