# SPDX-License-Identifier: MIT
#
# What the Makefile of a module in Pascal includes:
#
#     MODULE  := gantry
#     SOURCES := gantry.pas          # units (.pas) below the Makefile's own folder
#     include path/to/sdk/mk/pascal.mk
#
#   make         build/gantry.tgm, linked and verified
#   make check   the verdict of the conformance suite and of the folder's own *.scenario files
#   make run     run it on the simulated machine (RUN_FLAGS='--for 2s')
#   make clean
#   V=1 with any of them shows the commands
#
# May be set before the include, or on the command line:
#   TARGET          elf64 (default) or pe64: docs/targets.md. TG Motion takes Pascal on a PC only
#   CONFIG          configuration of TG Motion for check and run; default: controller.ini, where it is
#   TGM_GENERATION  4 (default) or 5; TGM_MEMORY_ID 905 or 906 (default) of generation 5. The sources see
#                   TGM_GENERATION_4, or TGM_GENERATION_5 and TGM_MEMORY_905 or TGM_MEMORY_906, and choose
#                   their units by them: uses {$ifdef TGM_GENERATION_4} tgm_gen4 {$else} tgm_gen5_906 {$endif}
#   FPC             the compiler driver, default fpc (Debian: fp-compiler); Free Pascal 3.2
#   MODULE_FPCFLAGS, MODULE_LDFLAGS   added last
#   MATH            yes: links the functions of tgm_math.pas
#   SCENARIOS       what make check plays; default: every *.scenario beside the Makefile
#   BUILD           default build, build/TARGET for other targets than elf64
#   TGM             the harness program; default: the one of this SDK's tree, else tgm on the PATH
# MODULE and the sources' names must not contain spaces.
#
# The sources are units, so Free Pascal adds no start-up code. Its objects, with the units of sdk/pascal that
# they use, become one object, in which only names an author chose (public name) stay visible; from there on a
# module in Pascal is linked and verified as one in C.

TGM_SDK := $(patsubst %/,%,$(dir $(patsubst %/,%,$(dir $(abspath $(lastword $(MAKEFILE_LIST)))))))
TARGET  ?= elf64
BUILD   ?= $(if $(filter elf64,$(TARGET)),build,build/$(TARGET))
TGM     ?= $(firstword $(wildcard $(TGM_SDK)/../build/tgm $(TGM_SDK)/../../../bin/tgm) tgm)
FPC     ?= fpc

ifeq ($(strip $(MODULE)),)
$(error set MODULE to the name of the module, as in MODULE := gantry)
endif
ifeq ($(strip $(SOURCES)),)
$(error set SOURCES to the Pascal units of the module, as in SOURCES := $(MODULE).pas)
endif

# Android is Free Pascal's name for the ABI of x86-64 ELF with constants in read-only sections; nothing of
# Android is used, and its symbols are undefined again. The assembler: the compiler's own writes sections
# that the linkers refuse (PE) or that are writable (ELF).
tgm_fpc_elf64 := -Px86_64 -Tandroid -Cg -Aas -XP -uANDROID -uLINUX -uUNIX
tgm_fpc_pe64  := -Px86_64 -Twin64 -Aas -XPx86_64-w64-mingw32-
ifeq ($(tgm_fpc_$(TARGET)),)
$(error TARGET is '$(TARGET)'; allowed for Pascal: elf64 pe64$(if $(filter pe32,$(TARGET)), (for 32 bits Free Pascal computes in 80-bit registers only; use C)))
endif

TGM_GENERATION ?= 4
ifeq ($(filter 4 5,$(TGM_GENERATION)),)
$(error TGM_GENERATION is '$(TGM_GENERATION)'; allowed: 4 5)
endif
ifeq ($(TGM_GENERATION),5)
TGM_MEMORY_ID ?= 906
ifeq ($(filter 905 906,$(TGM_MEMORY_ID)),)
$(error TGM_MEMORY_ID is '$(TGM_MEMORY_ID)'; allowed: 905 906)
endif
tgm_memory := -dTGM_MEMORY_$(TGM_MEMORY_ID)
endif

include $(TGM_SDK)/mk/target-$(TARGET).mk

tgm_cc       := $(if $(tgm_prefix),$(tgm_prefix)gcc,$(if $(filter default,$(origin CC)),gcc,$(CC)))
tgm_fpcflags := -n $(tgm_fpc_$(TARGET)) -dTGM -O2 -gw2 -CX -Si -Sj- -vr -vb -vwnh- -FcUTF-8 \
    -dTGM_GENERATION_$(TGM_GENERATION) $(tgm_memory)
tgm_out      := $(BUILD)/obj/pascal
tgm_fpc      := $(TGM_SDK)/mk/fpc.sh $(FPC) $(tgm_fpcflags)
tgm_units    := $(wildcard $(TGM_SDK)/pascal/*.pas)
tgm_object   := $(BUILD)/obj/$(MODULE).o
tgm_sdk_objects := $(addprefix $(BUILD)/sdk/,mem.o text16.o number.o motion.o move.o start.o)
tgm_sdk_cflags  := -std=c11 -O2 -g -ffreestanding -fno-builtin -fno-stack-protector -ffunction-sections -fdata-sections \
    -fno-math-errno -Wall -Wextra -I$(TGM_SDK)/include -DTGM_GENERATION=$(TGM_GENERATION) \
    $(if $(TGM_MEMORY_ID),-DTGM_MEMORY_ID=$(TGM_MEMORY_ID)) $(tgm_cflags) \
    $(if $(findstring clang,$(tgm_cc)),,-fno-tree-loop-distribute-patterns)
tgm_file     := $(BUILD)/$(MODULE).tgm
tgm_linked   := $(BUILD)/unverified/$(MODULE).tgm
tgm_tools    := TARGET=$(TARGET) NM=$(tgm_prefix)nm READELF=$(tgm_prefix)readelf OBJDUMP=$(tgm_prefix)objdump \
    ADDR2LINE=$(tgm_prefix)addr2line LD=$(tgm_prefix)ld OBJCOPY=$(tgm_prefix)objcopy
tgm_verify   := $(tgm_tools) $(TGM_SDK)/mk/verify_pascal.sh \
    $(foreach source,$(SOURCES),$(source) $(tgm_out)/$(basename $(notdir $(source))).o) && \
    $(tgm_tools) $(TGM_SDK)/mk/verify.sh $(tgm_linked) $(tgm_object) $(tgm_sdk_objects)
ifeq ($(MATH),yes)
tgm_math     := $(BUILD)/obj/math/libtgm_math.a
endif

ifeq ($(V),1)
tgm_say = @:
else
tgm_q   := @
tgm_say = @printf '  %-6s %s\n'
endif

.PHONY: all check run debug clean
all: $(tgm_file)

# Everything is made anew when what it is made with has changed, not only when a file has.
tgm_state := $(BUILD)/obj/.state
define tgm_state_text
$(CURDIR) $(MODULE) $(SOURCES) $(TARGET) $(TGM_SDK) $(MATH)
$(tgm_fpc) $(MODULE_FPCFLAGS)
$(tgm_cc) $(tgm_sdk_cflags) $(tgm_ldflags) $(MODULE_LDFLAGS)
endef
export tgm_state_text
.PHONY: tgm_force
tgm_force:
$(tgm_state): tgm_force
	@mkdir -p $(@D)
	@printf '%s\n' "$$tgm_state_text" | cmp -s - $@ || printf '%s\n' "$$tgm_state_text" >$@
$(tgm_object) $(tgm_sdk_objects) $(tgm_math): $(tgm_state)

$(BUILD)/sdk/%.o: $(TGM_SDK)/src/%.c
	@mkdir -p $(@D)
	$(tgm_say) CC $(<F)
	$(tgm_q)$(tgm_cc) $(tgm_sdk_cflags) -MMD -MP -c -o $@ $<

# All at once and from nothing: Free Pascal takes a fraction of a second, and no unit is ever stale.
$(tgm_object): $(SOURCES) $(tgm_units) $(TGM_SDK)/mk/fpc.sh \
    $(TGM_SDK)/mk/join_pascal.sh $(MAKEFILE_LIST)
	@rm -rf $(tgm_out) $@
	@mkdir -p $(tgm_out)
	$(tgm_q)$(tgm_fpc) -g- -Us -FU$(tgm_out) $(TGM_SDK)/pascal/system.pas
	$(tgm_say) FPC "$(SOURCES)"
	$(tgm_q)for source in $(SOURCES); do \
	    $(tgm_fpc) -Mobjfpc -Sh -FU$(tgm_out) -Fu$(TGM_SDK)/pascal $(patsubst %,-Fu%,$(sort $(dir $(SOURCES)))) \
	        $(MODULE_FPCFLAGS) $$source || exit 1; \
	done
	$(tgm_q)$(tgm_tools) $(TGM_SDK)/mk/join_pascal.sh $@ $(tgm_out)/*.o

$(BUILD)/obj/math/libtgm_math.a: $(TGM_SDK)/mk/math.sh
	$(tgm_say) MATH $@
	$(tgm_q)$< $(@D) $(tgm_cc) $(tgm_cflags)

# When the link fails, the checks say which symbol and which source line, where the linker may not.
$(tgm_linked): $(tgm_object) $(tgm_sdk_objects) $(tgm_math) $(tgm_script)
	@mkdir -p $(@D)
	@rm -f $@
	$(tgm_say) LINK $@
	$(tgm_q)$(tgm_cc) -o $@ $(tgm_object) $(tgm_sdk_objects) $(tgm_math) $(tgm_ldflags) $(MODULE_LDFLAGS) -lgcc || \
	    { rm -f $@; $(tgm_verify); exit 1; }

$(tgm_file): $(tgm_linked) $(TGM_SDK)/mk/verify.sh $(TGM_SDK)/mk/verify_pascal.sh
	@rm -f $@
	$(tgm_say) VERIFY $@
	$(tgm_q)$(tgm_verify)
	@cp $(tgm_linked) $@

# The verdict covers most of what the checks refuse, too, and says it with clause and line: so it is asked
# about the module as linked.
TGM_PROFILE ?= $(if $(filter 4,$(TGM_GENERATION)),pc4,$(if $(filter 905,$(TGM_MEMORY_ID)),pc500,pc5))
CONFIG      ?= $(wildcard controller.ini)
tgm_played  := --profile $(TGM_PROFILE) $(if $(strip $(CONFIG)),--config $(CONFIG))
tgm_need = @command -v $(TGM) >/dev/null || \
    { echo "$(TGM) is not there: build the harness first (make in its own folder) or set TGM=path/to/tgm" >&2; exit 2; }

SCENARIOS ?= $(wildcard *.scenario)
check: $(tgm_linked)
	$(tgm_need)
	$(TGM) check $(tgm_played) $(addprefix --scenario ,$(SCENARIOS)) $(CHECK_FLAGS) $(tgm_linked)

run: $(tgm_file)
	$(tgm_need)
	$(TGM) run $(tgm_played) $(RUN_FLAGS) $(tgm_file)

debug: $(tgm_file)
	@[ $(TARGET) = elf64 ] || { echo "debug is for TARGET=elf64: gdb reads no module of $(TARGET)" >&2; exit 2; }
	$(tgm_need)
	gdb -q -x $(TGM_SDK)/gdb/tgm.gdb --args $(TGM) run --in-process $(tgm_played) $(RUN_FLAGS) $(abspath $(tgm_file))

clean:
	rm -rf $(BUILD)

-include $(tgm_sdk_objects:.o=.d)
