# SPDX-License-Identifier: MIT
#
# What a module's own Makefile includes:
#
#     MODULE  := gantry
#     SOURCES := gantry.c
#     include path/to/sdk/mk/module.mk
#
#   make         build/gantry.tgm, linked and verified
#   make check   the verdict of the conformance suite
#   make run     run it on the simulated machine (RUN_FLAGS='--for 2s')
#   make clean
#   V=1 with any of them shows the commands
#
# May be set before the include: BUILD (default build), CC (gcc, clang), MODULE_CFLAGS (added last),
# TGM (the harness program, default: the one of this SDK's tree, else tgm on the PATH).
# MODULE must not contain spaces; sources are C files below the Makefile's own folder.

TGM_SDK := $(patsubst %/,%,$(dir $(patsubst %/,%,$(dir $(abspath $(lastword $(MAKEFILE_LIST)))))))
BUILD   ?= build
TGM     ?= $(firstword $(wildcard $(TGM_SDK)/../build/tgm $(TGM_SDK)/../../bin/tgm) tgm)

ifeq ($(strip $(MODULE)),)
$(error set MODULE to the name of the module, as in MODULE := gantry)
endif
ifeq ($(strip $(SOURCES)),)
$(error set SOURCES to the C files of the module, as in SOURCES := $(MODULE).c)
endif

TGM_CFLAGS := -std=c11 -O2 -g -ffreestanding -fPIC -fvisibility=hidden -fshort-wchar -fno-stack-protector \
    -fno-asynchronous-unwind-tables -ffunction-sections -fdata-sections -fno-math-errno \
    -Wall -Wextra -I$(TGM_SDK)/include
TGM_LDFLAGS := -nostdlib -shared -Wl,-T,$(TGM_SDK)/link/elf64.ld -Wl,--version-script=$(TGM_SDK)/link/elf64.map \
    -Wl,-z,defs -Wl,-z,noexecstack -Wl,-Bsymbolic -Wl,-e,0 -Wl,--hash-style=gnu -Wl,-z,norelro \
    -Wl,-z,max-page-size=4096 -Wl,--build-id=none -Wl,--fatal-warnings -Wl,--orphan-handling=error \
    -Wl,--gc-sections
ifeq ($(findstring lld,$(MODULE_LDFLAGS)),)
TGM_LDFLAGS += -Wl,-z,nodynamic-undefined-weak
endif
TGM_SDK_SOURCES := mem.c
TGM_SDK_CFLAGS  := $(TGM_CFLAGS) -fno-builtin $(if $(findstring clang,$(CC)),,-fno-tree-loop-distribute-patterns)

tgm_objects     := $(addprefix $(BUILD)/obj/,$(SOURCES:.c=.o))
tgm_sdk_objects := $(addprefix $(BUILD)/obj/sdk/,$(TGM_SDK_SOURCES:.c=.o))
tgm_file        := $(BUILD)/$(MODULE).tgm
tgm_linked      := $(BUILD)/unverified/$(MODULE).tgm

ifeq ($(V),1)
tgm_say = @:
else
tgm_q   := @
tgm_say = @printf '  %-6s %s\n'
endif

.PHONY: all check run clean
all: $(tgm_file)

$(BUILD)/obj/%.o: %.c
	@mkdir -p $(@D)
	$(tgm_say) CC $<
	$(tgm_q)$(CC) $(TGM_CFLAGS) $(MODULE_CFLAGS) -MMD -MP -c -o $@ $<

$(BUILD)/obj/sdk/%.o: $(TGM_SDK)/src/%.c
	@mkdir -p $(@D)
	$(tgm_say) CC $(<F)
	$(tgm_q)$(CC) $(TGM_SDK_CFLAGS) -MMD -MP -c -o $@ $<

# When the link fails, verify.sh says which symbol and which source line, where the linker may not.
$(tgm_linked): $(tgm_objects) $(tgm_sdk_objects) $(TGM_SDK)/link/elf64.ld $(TGM_SDK)/link/elf64.map
	@mkdir -p $(@D)
	@rm -f $@
	$(tgm_say) LINK $@
	$(tgm_q)$(CC) $(TGM_LDFLAGS) $(MODULE_LDFLAGS) -o $@ $(tgm_objects) $(tgm_sdk_objects) -lgcc || \
	    { $(TGM_SDK)/mk/verify.sh $@ $(tgm_objects) $(tgm_sdk_objects); rm -f $@; exit 1; }

$(tgm_file): $(tgm_linked) $(TGM_SDK)/mk/verify.sh
	@rm -f $@
	$(tgm_say) VERIFY $@
	$(tgm_q)$(TGM_SDK)/mk/verify.sh $(tgm_linked) $(tgm_objects) $(tgm_sdk_objects)
	@cp $(tgm_linked) $@

# The verdict covers what verify.sh refuses, too, and says it with clause and line: so it is asked
# about the module as linked.
check: $(tgm_linked)
	$(TGM) check $(CHECK_FLAGS) $(tgm_linked)

run: $(tgm_file)
	$(TGM) run $(RUN_FLAGS) $(tgm_file)

clean:
	rm -rf $(BUILD)

-include $(tgm_objects:.o=.d) $(tgm_sdk_objects:.o=.d)
