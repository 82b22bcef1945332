# SPDX-License-Identifier: MIT
#
# What a module's own Makefile includes:
#
#     MODULE  := gantry
#     SOURCES := gantry.c            # C (.c) and C++ (.cpp) files below the Makefile's own folder
#     include path/to/sdk/mk/module.mk
#
#   make         build/gantry.tgm, linked and verified
#   make check   the verdict of the conformance suite and of the folder's own *.scenario files
#   make run     run it on the simulated machine (RUN_FLAGS='--for 2s')
#   make debug   run it under gdb: break Program_04, run (TARGET=elf64)
#   make clean
#   V=1 with any of them shows the commands
#
# May be set before the include, or on the command line:
#   TARGET          elf64 (default), pe64, pe32, tgmmini, tgmcontroller, tgzmotion: docs/targets.md
#   TGM_GENERATION  4 or 5 (default: 4 on elf64, pe64, pe32; 5 on the others); TGM_MEMORY_ID 905 or 906
#   TGM_PROFILE     which TG Motion judges and runs it: the one of the target; on elf64, pe64 and pe32 pc4, pc500 or
#                   pc5 by the generation; on elf64 also tgmmini, tgmcontroller, tgzmotion (a rebuild with their
#                   text: docs/targets.md)
#   CONFIG          configuration of TG Motion for check and run; default: controller.ini, where it is
#   CC, CXX         on elf64: gcc (default) or clang, g++ or clang++
#   MATH            yes: link the mathematics of <tgm/math.h>
#   MODULE_CFLAGS, MODULE_LDFLAGS   added last
#   SCENARIOS       what make check plays; default: every *.scenario beside the Makefile
#   BUILD           default build, build/TARGET for other targets than elf64
#   TGM             the harness program; default: the one of this SDK's tree, else tgm on the PATH
# MODULE and the sources' names must not contain spaces.

TGM_SDK := $(patsubst %/,%,$(dir $(patsubst %/,%,$(dir $(abspath $(lastword $(MAKEFILE_LIST)))))))
TARGET  ?= elf64
BUILD   ?= $(if $(filter elf64,$(TARGET)),build,build/$(TARGET))
TGM     ?= $(firstword $(wildcard $(TGM_SDK)/../build/tgm $(TGM_SDK)/../../../bin/tgm) tgm)

ifeq ($(strip $(MODULE)),)
$(error set MODULE to the name of the module, as in MODULE := gantry)
endif
ifeq ($(strip $(SOURCES)),)
$(error set SOURCES to the C or C++ files of the module, as in SOURCES := $(MODULE).c)
endif
ifneq ($(filter-out yes no,$(MATH)),)
$(error MATH is '$(MATH)'; allowed: yes)
endif
ifneq ($(findstring -flto,$(MODULE_CFLAGS) $(MODULE_LDFLAGS)),)
$(error -flto hides the symbols that verify.sh looks at; leave it out)
endif
tgm_targets := $(patsubst $(TGM_SDK)/mk/target-%.mk,%,$(wildcard $(TGM_SDK)/mk/target-*.mk))
ifeq ($(filter $(TARGET),$(tgm_targets)),)
$(error TARGET is '$(TARGET)'; allowed: $(tgm_targets))
endif

include $(TGM_SDK)/mk/target-$(TARGET).mk

# Products whose text is UTF-8.
tgm_text8 := $(filter tgmmini tgmcontroller tgzmotion,$(TGM_PROFILE))
ifeq ($(origin TGM_GENERATION),undefined)
TGM_GENERATION := $(if $(tgm_text8)$(filter pc5 pc500,$(TGM_PROFILE)),5,4)
endif
ifneq ($(filter pc500,$(TGM_PROFILE)),)
TGM_MEMORY_ID ?= 905
endif
ifeq ($(TARGET),elf64)
tgm_cflags += $(if $(tgm_text8),-DTGM_TEXT8)
endif
ifneq ($(tgm_prefix),)
tgm_cc  := $(tgm_prefix)gcc
tgm_cxx := $(tgm_prefix)g++
else
tgm_cc  := $(if $(filter default,$(origin CC)),gcc,$(CC))
tgm_cxx := $(if $(filter default,$(origin CXX)),$(if $(findstring clang,$(tgm_cc)),clang++,g++),$(CXX))
endif

TGM_FLAGS := -O2 -g -ffreestanding -fno-stack-protector -ffunction-sections -fdata-sections -fno-math-errno \
    -Wall -Wextra -I$(TGM_SDK)/include -DTGM_GENERATION=$(TGM_GENERATION) \
    $(if $(TGM_MEMORY_ID),-DTGM_MEMORY_ID=$(TGM_MEMORY_ID)) $(tgm_cflags)
TGM_CFLAGS   := -std=c11 $(TGM_FLAGS)
TGM_CXXFLAGS := -std=c++17 -fno-exceptions -fno-rtti -fno-threadsafe-statics -fno-use-cxa-atexit $(TGM_FLAGS) \
    $(if $(filter elf64 tgmmini,$(TARGET)),-fvisibility-inlines-hidden)
TGM_SDK_SOURCES := mem.c text16.c text8.c number.c motion.c move.c start.c $(tgm_sources) $(if $(filter %.cpp,$(SOURCES)),cxx.cpp)
TGM_SDK_CFLAGS  := -fno-builtin $(if $(findstring clang,$(tgm_cc)),,-fno-tree-loop-distribute-patterns)

tgm_objects     := $(addprefix $(BUILD)/obj/,$(addsuffix .o,$(basename $(SOURCES))))
tgm_sdk_objects := $(addprefix $(BUILD)/sdk/,$(addsuffix .o,$(basename $(TGM_SDK_SOURCES))))
tgm_math        := $(if $(filter yes,$(MATH)),$(BUILD)/sdk/libtgm_math.a)
tgm_file        := $(BUILD)/$(MODULE).tgm$(if $(tgm_flat),.bin)
tgm_linked      := $(BUILD)/unverified/$(MODULE).tgm
tgm_verify      := TARGET=$(TARGET) NM=$(tgm_prefix)nm READELF=$(tgm_prefix)readelf OBJDUMP=$(tgm_prefix)objdump \
    ADDR2LINE=$(tgm_prefix)addr2line $(TGM_SDK)/mk/verify.sh $(tgm_linked) $(tgm_objects) $(tgm_sdk_objects)

ifeq ($(V),1)
tgm_say = @:
else
tgm_q   := @
tgm_say = @printf '  %-6s %s\n'
endif

.PHONY: all check run debug clean
all: $(tgm_file)

# Everything is made anew when what it is made from or with has changed, not only when a file has.
tgm_state := $(BUILD)/obj/.state
define tgm_state_text
$(CURDIR) $(MODULE) $(SOURCES) $(TARGET) $(TGM_SDK) $(MATH)
$(tgm_cc) $(TGM_CFLAGS) $(MODULE_CFLAGS)
$(tgm_cxx) $(TGM_CXXFLAGS)
$(tgm_ldflags) $(MODULE_LDFLAGS)
endef
export tgm_state_text
.PHONY: tgm_force
tgm_force:
$(tgm_state): tgm_force
	@mkdir -p $(@D)
	@printf '%s\n' "$$tgm_state_text" | cmp -s - $@ || printf '%s\n' "$$tgm_state_text" >$@
$(tgm_objects) $(tgm_sdk_objects) $(tgm_math): $(tgm_state)

$(BUILD)/sdk/%.o: $(TGM_SDK)/src/%.c
	@mkdir -p $(@D)
	$(tgm_say) CC $(<F)
	$(tgm_q)$(tgm_cc) $(TGM_CFLAGS) $(TGM_SDK_CFLAGS) -MMD -MP -c -o $@ $<

$(BUILD)/sdk/%.o: $(TGM_SDK)/src/%.cpp
	@mkdir -p $(@D)
	$(tgm_say) CXX $(<F)
	$(tgm_q)$(tgm_cxx) $(TGM_CXXFLAGS) $(TGM_SDK_CFLAGS) -MMD -MP -c -o $@ $<

$(BUILD)/sdk/libtgm_math.a: $(TGM_SDK)/mk/math.sh $(wildcard $(TGM_SDK)/src/math/*)
	@mkdir -p $(@D)
	$(tgm_say) MATH $@
	$(tgm_q)$(TGM_SDK)/mk/math.sh $(@D) $(tgm_cc) $(tgm_cflags)

$(BUILD)/obj/%.o: %.c
	@mkdir -p $(@D)
	$(tgm_say) CC $<
	$(tgm_q)$(tgm_cc) $(TGM_CFLAGS) $(MODULE_CFLAGS) -MMD -MP -c -o $@ $<

$(BUILD)/obj/%.o: %.cpp
	@mkdir -p $(@D)
	$(tgm_say) CXX $<
	$(tgm_q)$(tgm_cxx) $(TGM_CXXFLAGS) $(MODULE_CFLAGS) -MMD -MP -c -o $@ $<

# When the link fails, verify.sh says which symbol and which source line, where the linker may not.
$(tgm_linked): $(tgm_objects) $(tgm_sdk_objects) $(tgm_math) $(tgm_script) $(tgm_state)
	@mkdir -p $(@D)
	@rm -f $@
	$(tgm_say) LINK $@
	$(tgm_q)$(tgm_cc) -o $@ $(tgm_objects) $(tgm_sdk_objects) $(tgm_math) $(tgm_ldflags) $(MODULE_LDFLAGS) -lgcc || \
	    { rm -f $@; $(tgm_verify); exit 1; }

$(tgm_file): $(tgm_linked) $(TGM_SDK)/mk/verify.sh
	@rm -f $@
	$(tgm_say) VERIFY $@
	$(tgm_q)$(tgm_verify)
ifneq ($(tgm_flat),)
	$(tgm_q)$(tgm_prefix)objcopy -O binary $(tgm_linked) $@
else
	@cp $(tgm_linked) $@
endif

# The verdict covers what verify.sh refuses, too, and says it with clause and line: so it is asked
# about the module as linked (a flat image is what verify.sh has let through).
tgm_judged  := $(if $(tgm_flat),$(tgm_file),$(tgm_linked))
TGM_PROFILE ?= $(or $(filter tgmmini tgmcontroller tgzmotion,$(TARGET)),$(if $(filter 4,$(TGM_GENERATION)),pc4,$(if \
    $(filter 905,$(TGM_MEMORY_ID)),pc500,pc5)))
CONFIG      ?= $(wildcard controller.ini)
tgm_played  := --profile $(TGM_PROFILE) $(if $(strip $(CONFIG)),--config $(CONFIG))
tgm_need = @command -v $(TGM) >/dev/null || \
    { echo "$(TGM) is not there: build the harness first (make in its own folder) or set TGM=path/to/tgm" >&2; exit 2; }

SCENARIOS ?= $(wildcard *.scenario)
check: $(tgm_judged)
	$(tgm_need)
	$(TGM) check $(tgm_played) $(addprefix --scenario ,$(SCENARIOS)) $(CHECK_FLAGS) $(tgm_judged)

run: $(tgm_file)
	$(tgm_need)
	$(TGM) run $(tgm_played) $(RUN_FLAGS) $(tgm_file)

debug: $(tgm_file)
	@[ $(TARGET) = elf64 ] || { echo "debug is for TARGET=elf64: gdb reads no module of $(TARGET)" >&2; exit 2; }
	$(tgm_need)
	gdb -q -x $(TGM_SDK)/gdb/tgm.gdb --args $(TGM) run --in-process $(tgm_played) $(RUN_FLAGS) $(abspath $(tgm_file))

clean:
	rm -rf $(BUILD)

-include $(tgm_objects:.o=.d) $(tgm_sdk_objects:.o=.d)
