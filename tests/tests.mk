# SPDX-License-Identifier: GPL-2.0-or-later
# Test programs and the modules they need; included by the Makefile.

FIXTURE_DIR := $(BUILD)/fixtures
FIXTURE_SOURCES := $(foreach suffix,c cpp S,$(wildcard conformance/fixtures/*/*.$(suffix)))
FIXTURE_NAMES := $(patsubst conformance/fixtures/%,$(FIXTURE_DIR)/%,$(basename $(FIXTURE_SOURCES)))
FIXTURES := $(foreach name,$(FIXTURE_NAMES),$(name).tgm$(if $(findstring flat,$(notdir $(name))),.bin))

MODULE_CFLAGS := -std=c11 -O2 -g -ffreestanding -fPIC -fvisibility=hidden -fshort-wchar -fno-stack-protector \
    -fno-asynchronous-unwind-tables -Wall -Wextra -Werror -Isdk/include -ffile-prefix-map=$(CURDIR)/=
FIXTURE_LDFLAGS := -nostdlib -shared -Wl,-Bsymbolic -Wl,-e,0 -Wl,--hash-style=gnu -Wl,-z,noexecstack \
    -Wl,--build-id=none

# tests/fixture.sh says what a fixture's first lines may ask for.
FIXTURE_MADE_WITH := tests/fixture.sh $(wildcard conformance/fixtures/*.h) sdk/include/tgm_plc.h \
    sdk/include/tgm/layout_gen4.h sdk/src/mem.c
define fixture_rule
$(FIXTURE_DIR)/%$(2): conformance/fixtures/%.$(1) $(FIXTURE_MADE_WITH) | $(BUILD)/.deps-test
	@mkdir -p $$(@D)
	@echo "  MODULE $$<"
	$$(Q)V=$$(V) FIXTURE_CFLAGS="$$(filter-out -std=%,$$(MODULE_CFLAGS))" tests/fixture.sh $$< $$@
endef
$(foreach suffix,c cpp S,$(foreach ending,.tgm .tgm.bin,$(eval $(call fixture_rule,$(suffix),$(ending)))))

# A rule has what its findings must say beside its modules, and a scenario where it needs one.
FIXTURE_EXPECTED := $(patsubst conformance/fixtures/%,$(FIXTURE_DIR)/%,$(wildcard conformance/fixtures/*/expected))
$(FIXTURE_DIR)/%/expected: conformance/fixtures/%/expected
	@mkdir -p $(@D)
	@cp $< $@
FIXTURE_SCENARIOS := $(patsubst conformance/fixtures/%,$(FIXTURE_DIR)/%,$(wildcard conformance/fixtures/*/*.scenario))
$(FIXTURE_DIR)/%.scenario: conformance/fixtures/%.scenario
	@mkdir -p $(@D)
	@cp $< $@
FIXTURES += $(FIXTURE_SCENARIOS) $(FIXTURE_EXPECTED)

# Each test program: its own source and what of the rooms it needs (all of them: they are small).
UNIT_TESTS := test_osc test_text16 test_catalogue \
    test_scenario \
    test_certificate \
    test_suite \
    test_chronicle \
    test_report \
    test_audit \
    test_rules_same \
    test_rules_cycle \
    test_rules_ends \
    test_budgets \
    test_profile \
    test_curves \
    test_schedule \
    test_interp_path \
    test_evidence \
    test_selftest \
    test_hostile_evidence \
    test_rules_file \
    test_config
SDK_TESTS := test_sdk_mem test_sdk_text test_sdk_motion test_sdk_start test_sdk_start5 test_sdk_start8
IMAGE_TESTS := test_image test_image_real test_image_bad test_image_damage test_image_memory \
    test_image_pe test_image_pe_bad test_image_arm test_image_flat \
    test_bad_files \
    test_stack \
    test_census
MACHINE_TESTS := test_machine test_machine_call test_machine_load test_machine_seal test_worker \
    test_machine_stack \
    test_machine_preempt \
    test_machine_rehearse \
    test_machine_windows \
    test_instrumented \
    test_instrumented_targets \
    test_arguments
BUS_TESTS := test_segment test_slave test_coe test_drive test_bus test_client \
    test_drive2 \
    test_tgz \
    test_topology \
    test_plan \
    test_cruise \
    test_bus_alloc \
    test_controller \
    test_dc
BUS_TESTS += test_faults
BUS_TESTS += test_pcap
BUS_TESTS += test_faults_bus
BUS_TESTS += test_terminals
BUS_TESTS += test_device_file
BUS_TESTS += test_esi
BUS_TESTS += test_busfile

$(addprefix $(BUILD)/obj/tests/,$(BUS_TESTS:=.o) bench_bus.o soak_segment.o): ALL_CFLAGS += -Itests $(BUS_CFLAGS)
$(addprefix $(BUILD)/obj/tests/,$(BUS_TESTS:=.o) bench_bus.o soak_segment.o): | third_party/soem/.from

# Reports that tests/reports.sh holds against their schemas.
$(BUILD)/obj/tests/test_report.o: ALL_CFLAGS += -Itests $(XML) -DTEST_REPORTS_DIR='"$(BUILD)/reports"'

# Captures that tests/captures.sh lets tshark dissect.
$(BUILD)/obj/tests/test_pcap.o: ALL_CFLAGS += -DTEST_CAPTURES_DIR='"$(BUILD)/captures"'
# Counts what the allocator is asked for.
comma := ,
ALLOCATOR := malloc calloc realloc aligned_alloc posix_memalign strdup free
$(BUILD)/test/test_bus_alloc: LDFLAGS += $(addprefix -Wl$(comma)--wrap=,$(ALLOCATOR))

# The bench takes the port away from under SOEM.
$(BUILD)/test/bench_bus: LDFLAGS += -Wl,--wrap=ecx_outframe_red -Wl,--wrap=ecx_waitinframe

# The SDK's support library as native code: the same sources that modules are linked from.
SDK_OBJ := $(addprefix $(BUILD)/obj/sdk-host/,number.o text16.o text8.o motion.o move.o)
$(BUILD)/obj/sdk-host/%.o: sdk/src/%.c | $(BUILD)/.deps
	@mkdir -p $(@D)
	@echo "  CC     $<"
	$(Q)$(CC) $(ALL_CFLAGS) -DTGM_HOST -c -o $@ $<

$(addprefix $(BUILD)/test/,$(SDK_TESTS)): $(SDK_OBJ)

$(BUILD)/test/math_accuracy: tests/math_accuracy.c $(BUILD)/math/libtgm_math.a
	@mkdir -p $(@D)
	@echo "  LINK   $@"
	$(Q)$(CC) -std=gnu11 -O2 -g -fno-builtin -Isdk/include -o $@ $^ -lmpfr -lgmp

$(BUILD)/math/libtgm_math.a: sdk/mk/math.sh $(wildcard sdk/src/math/*) third_party/musl/.from
	@mkdir -p $(@D)
	@echo "  MATH   $@"
	$(Q)sdk/mk/math.sh $(@D) gcc -fPIC

MACHINE_MODULE_DIR := $(BUILD)/machine_modules
MACHINE_MODULES := $(addprefix $(MACHINE_MODULE_DIR)/,faults.so abi.so hostile.so data.so stack.so interrupt.so)

$(MACHINE_MODULE_DIR)/%.so: tests/machine_modules/%.S | $(BUILD)/.deps
	@mkdir -p $(@D)
	@echo "  MODULE $<"
	$(Q)gcc -shared -nostdlib -Wl,-Bsymbolic -Wl,-z,noexecstack -o $@ $<

$(MACHINE_MODULE_DIR)/%.so: tests/machine_modules/%.c | $(BUILD)/.deps
	@mkdir -p $(@D)
	@echo "  MODULE $<"
	$(Q)gcc -std=gnu11 -O1 -g -ffreestanding -fPIC -fno-stack-protector -fno-asynchronous-unwind-tables -shared \
	    -nostdlib -Wl,-Bsymbolic -Wl,-z,relro -Wl,-z,noexecstack -o $@ $<

# Code that can be written.
MACHINE_MODULES += $(addprefix $(MACHINE_MODULE_DIR)/,traced.so traced_open.so)
$(MACHINE_MODULE_DIR)/traced_open.so: tests/machine_modules/traced.S | $(BUILD)/.deps
	@mkdir -p $(@D)
	@echo "  MODULE $@"
	$(Q)gcc -shared -nostdlib -Wl,-Bsymbolic -Wl,-z,noexecstack -Wl,--omagic -Wl,-z,max-page-size=4096 -o $@ $<

# Modules for other processors.
MACHINE_MODULES += $(addprefix $(MACHINE_MODULE_DIR)/,i386.dll arm.so flat.bin)
$(MACHINE_MODULE_DIR)/i386.dll: tests/machine_modules/i386.S | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  MODULE $@"
	$(Q)i686-w64-mingw32-gcc -shared -nostdlib -Wl,-e,0 -Wl,--no-insert-timestamp -o $@ $<

$(MACHINE_MODULE_DIR)/arm.so: tests/machine_modules/arm.S | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  MODULE $@"
	$(Q)arm-linux-gnueabihf-gcc -shared -nostdlib -Wl,-Bsymbolic -Wl,-z,noexecstack -o $@ $<

$(MACHINE_MODULE_DIR)/flat.bin: tests/machine_modules/arm.S | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  MODULE $@"
	$(Q)arm-none-eabi-gcc -DFLAT -nostdlib -Wl,-Ttext=0x07800000 -Wl,-e,0 -o $@.elf $<
	$(Q)arm-none-eabi-objcopy -O binary $@.elf $@

# PE modules, of mingw and of the shape that Microsoft's tools make.
MACHINE_MODULES += $(addprefix $(MACHINE_MODULE_DIR)/,windows.dll windows_fixed.dll windows_frames.dll)
MACHINE_MINGW := x86_64-w64-mingw32-gcc -shared -nostdlib -Wl,-e,0 -Wl,--no-insert-timestamp

$(MACHINE_MODULE_DIR)/windows.dll: tests/machine_modules/windows.S | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  MODULE $@"
	$(Q)$(MACHINE_MINGW) -o $@ $<

$(MACHINE_MODULE_DIR)/windows_fixed.dll: tests/machine_modules/windows.S | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  MODULE $@"
	$(Q)clang --target=x86_64-pc-windows-msvc -c -o $@.obj $<
	$(Q)lld-link /DLL /NOENTRY /NODEFAULTLIB /Brepro /FIXED /BASE:0x60000000 /EXPORT:read_plain /OUT:$@ $@.obj

$(MACHINE_MODULE_DIR)/%.dll: tests/machine_modules/%.c | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  MODULE $@"
	$(Q)clang --target=x86_64-pc-windows-msvc -O2 -g -ffreestanding -fno-stack-protector -c -o $@.obj $<
	$(Q)lld-link /DLL /NOENTRY /NODEFAULTLIB /Brepro /OUT:$@ $@.obj

$(addprefix $(BUILD)/obj/tests/,$(MACHINE_TESTS:=.o)): ALL_CFLAGS += -Itests \
    -DTEST_MACHINE_MODULES_DIR='"$(MACHINE_MODULE_DIR)"'
$(addprefix $(BUILD)/test/,$(MACHINE_TESTS)): | $(MACHINE_MODULES)
$(BUILD)/obj/tests/bench_machine.o: ALL_CFLAGS += -DTEST_MACHINE_MODULES_DIR='"$(MACHINE_MODULE_DIR)"'
$(BUILD)/test/bench_machine: | $(MACHINE_MODULES)
$(BUILD)/obj/tests/test_machine_stack.o: ALL_CFLAGS += -DTEST_TEMPLATE='"$(BUILD)/template/shuttle.tgm"'
$(BUILD)/test/test_machine_stack: | template-linked

# Modules for tests of the host: every source of tests/host_modules for each layout, and with the text of the controllers.
HOST_MODULE_DIR := $(BUILD)/host_modules
HOST_MODULES := $(foreach layout,4 905 906 906_text8,$(patsubst tests/host_modules/%.c,$(HOST_MODULE_DIR)/%_$(layout).tgm,$(wildcard tests/host_modules/*.c)))
HOST_TESTS := test_scope test_host \
    test_scenario_host \
    test_plc \
    test_preempt \
    test_sleep \
    test_races \
    test_motion \
    test_gear \
    test_interpolator
HOST_TESTS += test_services
HOST_TESTS += test_digest
HOST_TESTS += test_watch
HOST_TESTS += test_can
HOST_TESTS += test_eeprom
HOST_TESTS += test_targets
host_module_4 := -DTGM_GENERATION=4
host_module_905 := -DTGM_GENERATION=5 -DTGM_MEMORY_ID=905
host_module_906 := -DTGM_GENERATION=5 -DTGM_MEMORY_ID=906
host_module_906_text8 := $(host_module_906) -DTGM_TEXT8

define host_module_rule
$(HOST_MODULE_DIR)/%_$(1).tgm: tests/host_modules/%.c $(wildcard sdk/include/*.h sdk/include/tgm/*.h) sdk/src/mem.c | $(BUILD)/.deps
	@mkdir -p $$(@D)
	@echo "  MODULE $$< ($(1))"
	$$(Q)gcc $$(MODULE_CFLAGS) $$(host_module_$(1)) -fno-builtin -o $$@ $$< sdk/src/mem.c $$(FIXTURE_LDFLAGS) -Wl,-w
endef
$(foreach layout,4 905 906 906_text8,$(eval $(call host_module_rule,$(layout))))

# The same for the targets that are not this machine's own.
TARGET_MODULE_DIR := $(BUILD)/target_modules
host_module_names := $(basename $(notdir $(wildcard tests/host_modules/*.c)))
TARGET_MODULES := $(TARGET_MODULE_DIR)/pe32/tells_4_x87.tgm \
    $(foreach target,pe64 pe32,$(foreach layout,4 905 906,$(patsubst %,$(TARGET_MODULE_DIR)/$(target)/%_$(layout).tgm,$(filter-out five,$(host_module_names))))) \
    $(patsubst %,$(TARGET_MODULE_DIR)/tgmmini/%_906_text8.tgm,$(filter-out five,$(host_module_names))) \
    $(patsubst %,$(TARGET_MODULE_DIR)/tgmcontroller/%_906_text8.tgm.bin,$(host_module_names))

define target_module_rule
$(TARGET_MODULE_DIR)/$(1)/%_$(2).tgm$(3): tests/host_modules/%.c tests/module_target.mk sdk/mk/target-$(1).mk \
    $(wildcard sdk/include/*.h sdk/include/tgm/*.h) sdk/src/mem.c | $(BUILD)/.deps-test
	@mkdir -p $$(@D)
	@echo "  MODULE $$< ($(1) $(2))"
	$$(Q)$$(MAKE) -s --no-print-directory -f tests/module_target.mk TARGET=$(1) SOURCE=$$< OUT=$$@ FLAGS='$$(host_module_$(2))'
endef
host_module_4_x87 := $(host_module_4) -mfpmath=387 -fexcess-precision=fast
$(eval $(call target_module_rule,pe32,4_x87))
$(foreach layout,4 905 906,$(foreach target,pe64 pe32,$(eval $(call target_module_rule,$(target),$(layout)))))
$(eval $(call target_module_rule,tgmmini,906_text8))
$(eval $(call target_module_rule,tgmcontroller,906_text8,.bin))

$(BUILD)/obj/tests/test_targets.o: ALL_CFLAGS += -DTEST_TARGETS_DIR='"$(TARGET_MODULE_DIR)"'
$(BUILD)/test/test_targets: | $(TARGET_MODULES)

$(addprefix $(BUILD)/obj/tests/,$(HOST_TESTS:=.o)): ALL_CFLAGS += -DTEST_HOST_MODULES_DIR='"$(HOST_MODULE_DIR)"'
$(addprefix $(BUILD)/test/,$(HOST_TESTS)): | $(HOST_MODULES)
$(BUILD)/obj/tests/test_plc.o: ALL_CFLAGS += -DTEST_TEMPLATE='"$(BUILD)/template/shuttle.tgm"'
$(BUILD)/test/test_plc: | template-linked
# Counts what the allocator is asked for.
$(BUILD)/test/test_interpolator: LDFLAGS += $(addprefix -Wl$(comma)--wrap=,malloc calloc realloc)

include tests/modules/image.mk
$(addprefix $(BUILD)/obj/tests/,$(IMAGE_TESTS:=.o) image_support.o image_support_pe.o): ALL_CFLAGS += -DTEST_MODULES_DIR='"$(BUILD)/modules"'
$(addprefix $(BUILD)/test/,$(IMAGE_TESTS)): $(BUILD)/obj/tests/image_support.o $(BUILD)/obj/tests/image_support_pe.o | $(IMAGE_MODULES)

# Real modules of every format for the fuzzers to begin with.
.PHONY: fuzz-seeds
fuzz: fuzz-seeds
fuzz-seeds: $(IMAGE_MODULES)
	$(Q)for fuzzer in fuzz_image fuzz_image_deep; do mkdir -p $(BUILD)/fuzz/corpus-$$fuzzer && \
	    cp -u $(IMAGE_MODULES) $(BUILD)/fuzz/corpus-$$fuzzer/ || exit 1; done

# A hundred programs of all rooms each: with the linker that is twice as quick, where it is there.
TEST_LINKER := $(if $(shell command -v ld.lld),-fuse-ld=lld)
$(BUILD)/test/%: $(BUILD)/obj/tests/%.o $(ROOM_OBJ)
	@mkdir -p $(@D)
	@echo "  LINK   $@"
	$(Q)$(CC) $(OPT) $(CFLAGS) $(TEST_LINKER) -o $@ $^ $(LDFLAGS) $(LIBS) -lcmocka

$(BUILD)/obj/tests/test_evidence.o $(BUILD)/obj/tests/test_hostile_evidence.o: ALL_CFLAGS += -DFIXTURE_DIR='"$(FIXTURE_DIR)"'
$(BUILD)/obj/tests/test_evidence.o $(BUILD)/obj/tests/test_hostile_evidence.o: ALL_CFLAGS += -DTEST_EVIDENCE_DIR='"$(BUILD)/test-evidence"'
$(BUILD)/test/test_evidence $(BUILD)/test/test_hostile_evidence: | $(FIXTURES)
$(BUILD)/obj/tests/test_selftest.o: ALL_CFLAGS += -DFIXTURE_DIR='"$(FIXTURE_DIR)"'
$(BUILD)/obj/tests/test_selftest.o: ALL_CFLAGS += -DTEST_SELFTEST_DIR='"$(BUILD)/test-selftest"'
$(BUILD)/test/test_selftest: | $(FIXTURES)
$(BUILD)/test/test_rules_file: | $(FIXTURES) $(IMAGE_MODULES)
$(BUILD)/obj/tests/test_rules_file.o: ALL_CFLAGS += -DTEST_MODULES_DIR='"$(BUILD)/modules"'
$(BUILD)/obj/tests/test_rules_file.o: ALL_CFLAGS += -DFIXTURE_DIR='"$(FIXTURE_DIR)"'

.PHONY: test-programs fixtures
fixtures: $(FIXTURES) ## build the rules' fixture modules
test-programs: $(addprefix $(BUILD)/test/,$(UNIT_TESTS) $(SDK_TESTS) $(IMAGE_TESTS) $(MACHINE_TESTS) $(BUS_TESTS) $(HOST_TESTS)) $(FIXTURES)

-include $(wildcard $(FIXTURE_DIR)/*/*.d)
-include $(wildcard $(BUILD)/obj/tests/*.d $(BUILD)/obj/sdk-host/*.d)

# SOEM's own sources with its own port for Linux, as its users build them, under a walker of ours.
SOEM_STOCK := third_party/soem
SOEM_STOCK_CFLAGS := -std=gnu11 -O2 -g -DEC_VER2 -DUSE_SOEM_CONFIG_H -Itests/strangers -isystem $(SOEM_STOCK)/soem \
    -isystem $(SOEM_STOCK)/osal -isystem $(SOEM_STOCK)/osal/linux -isystem $(SOEM_STOCK)/oshw/linux
$(BUILD)/strangers/soem_walk: tests/strangers/soem_walk.c tests/strangers/soem_config.h third_party/soem/.from
	@mkdir -p $(@D)
	@echo "  CC     $@"
	$(Q)$(CC) $(SOEM_STOCK_CFLAGS) -Wall -Wextra -Werror -c -o $@.o $<
	$(Q)$(CC) $(SOEM_STOCK_CFLAGS) -w -o $@ $@.o $(SOEM_STOCK)/soem/*.c $(SOEM_STOCK)/osal/linux/*.c \
	    $(SOEM_STOCK)/oshw/linux/*.c -lpthread
