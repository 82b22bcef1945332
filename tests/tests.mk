# SPDX-License-Identifier: GPL-2.0-or-later
# Test programs and the modules they need; included by the Makefile.

FIXTURE_DIR := $(BUILD)/fixtures
FIXTURES := $(patsubst conformance/fixtures/%.c,$(FIXTURE_DIR)/%.tgm,$(wildcard conformance/fixtures/*/*.c))

MODULE_CFLAGS := -std=c11 -O2 -g -ffreestanding -fPIC -fvisibility=hidden -fshort-wchar -fno-stack-protector \
    -fno-asynchronous-unwind-tables -Wall -Wextra -Werror -Isdk/include -ffile-prefix-map=$(CURDIR)/=
FIXTURE_LDFLAGS := -nostdlib -shared -Wl,-Bsymbolic -Wl,-e,0 -Wl,--hash-style=gnu -Wl,-z,noexecstack \
    -Wl,--build-id=none

# A fixture may say "flags: ..." in its second line: added to compiler and linker; -r: linked no further.
$(FIXTURE_DIR)/%.tgm: conformance/fixtures/%.c conformance/fixtures/base.h sdk/include/tgm_plc.h \
    sdk/include/tgm/layout_gen4.h sdk/src/mem.c | $(BUILD)/.deps
	@mkdir -p $(@D)
	@echo "  MODULE $<"
	$(Q)flags=$$(sed -n '2s/.*flags: \(.*\) \*\/$$/\1/p' $<); link="$(FIXTURE_LDFLAGS)"; \
	    [ "$$flags" != -r ] || link=-nostdlib; \
	    gcc $(MODULE_CFLAGS) -fno-builtin -o $@ $< sdk/src/mem.c $$link $$flags -Wl,-w

# Each test program: its own source and what of the rooms it needs (all of them: they are small).
UNIT_TESTS := test_text16 test_catalogue test_fixtures
IMAGE_TESTS := test_image test_image_real test_image_bad test_image_damage test_image_memory
MACHINE_TESTS := test_machine test_machine_call test_machine_load test_machine_seal test_worker
BUS_TESTS := test_segment test_slave test_coe test_drive test_bus

$(addprefix $(BUILD)/obj/tests/,$(BUS_TESTS:=.o) bench_bus.o): ALL_CFLAGS += -Itests $(BUS_CFLAGS)

MACHINE_MODULE_DIR := $(BUILD)/machine_modules
MACHINE_MODULES := $(addprefix $(MACHINE_MODULE_DIR)/,faults.so abi.so hostile.so data.so)

$(MACHINE_MODULE_DIR)/%.so: tests/machine_modules/%.S | $(BUILD)/.deps
	@mkdir -p $(@D)
	@echo "  MODULE $<"
	$(Q)gcc -shared -nostdlib -Wl,-Bsymbolic -Wl,-z,noexecstack -o $@ $<

$(MACHINE_MODULE_DIR)/%.so: tests/machine_modules/%.c | $(BUILD)/.deps
	@mkdir -p $(@D)
	@echo "  MODULE $<"
	$(Q)gcc -std=gnu11 -O1 -g -ffreestanding -fPIC -fno-stack-protector -fno-asynchronous-unwind-tables -shared \
	    -nostdlib -Wl,-Bsymbolic -Wl,-z,relro -Wl,-z,noexecstack -o $@ $<

$(addprefix $(BUILD)/obj/tests/,$(MACHINE_TESTS:=.o)): ALL_CFLAGS += -Itests \
    -DTEST_MACHINE_MODULES_DIR='"$(MACHINE_MODULE_DIR)"'
$(addprefix $(BUILD)/test/,$(MACHINE_TESTS)): | $(MACHINE_MODULES)

include tests/modules/image.mk
$(addprefix $(BUILD)/obj/tests/,$(IMAGE_TESTS:=.o) image_support.o): ALL_CFLAGS += -DTEST_MODULES_DIR='"$(BUILD)/modules"'
$(addprefix $(BUILD)/test/,$(IMAGE_TESTS)): $(BUILD)/obj/tests/image_support.o | $(IMAGE_MODULES)

$(BUILD)/test/%: $(BUILD)/obj/tests/%.o $(ROOM_OBJ)
	@mkdir -p $(@D)
	@echo "  LINK   $@"
	$(Q)$(CC) $(OPT) $(CFLAGS) -o $@ $^ $(LDFLAGS) $(LIBS) -lcmocka

$(BUILD)/obj/tests/test_fixtures.o: ALL_CFLAGS += -DFIXTURE_DIR='"$(FIXTURE_DIR)"'

.PHONY: test-programs fixtures
fixtures: $(FIXTURES) ## build the rules' fixture modules
test-programs: $(addprefix $(BUILD)/test/,$(UNIT_TESTS) $(IMAGE_TESTS) $(MACHINE_TESTS) $(BUS_TESTS)) $(FIXTURES)
