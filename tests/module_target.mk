# SPDX-License-Identifier: GPL-2.0-or-later
# A module of one C source for one target, without what the SDK refuses, for tests that run one source everywhere:
#   make -f tests/module_target.mk TARGET=pe32 SOURCE=m.c OUT=build/m.tgm FLAGS=-DTGM_GENERATION=5
TGM_SDK := sdk
include sdk/mk/target-$(TARGET).mk

warn  := -Wall -Wextra -Werror
lax   := $(filter-out -Wl$(comma)--fatal-warnings -Wl$(comma)--orphan-handling=error,$(tgm_ldflags))
comma := ,
own   := $(if $(tgm_flat),$(OUT).elf,$(OUT))

$(OUT): $(SOURCE)
	$(tgm_prefix)gcc -std=c11 -O2 -g -ffreestanding -fno-builtin -fno-stack-protector -fno-math-errno $(warn) -Isdk/include \
	    $(tgm_cflags) $(FLAGS) -o $(own) $(SOURCE) sdk/src/mem.c \
	    $(addprefix sdk/src/,$(tgm_sources)) $(lax) -lgcc
	$(if $(tgm_flat),$(tgm_prefix)objcopy -O binary $(own) $(OUT))
