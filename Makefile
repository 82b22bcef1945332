# SPDX-License-Identifier: GPL-2.0-or-later
# One flat Makefile: explicit lists of sources, one rule a kind. `make help` lists the targets.

MAKEFLAGS += --no-builtin-rules
.SUFFIXES:

BUILD   ?= build
ifeq ($(origin CC),default)
CC      := gcc
endif
PREFIX  ?= /usr/local
MODULE  ?= $(BUILD)/template/shuttle.tgm
Q       ?= $(if $(V),,@)

WARN    := -Wall -Wextra -Wshadow -Wconversion -Werror
INCLUDE := -I. -Iharness -Isdk/include
OPT     ?= -O2 -g
# No fused multiply-add: recordings are the same to the last bit on every processor.
ALL_CFLAGS = -std=gnu11 $(OPT) -ffp-contract=off $(WARN) $(INCLUDE) -MMD -MP $(CFLAGS)
XML     := -isystem /usr/include/libxml2
BUS_CFLAGS = -DEC_VER2 -Iharness/bus/port -isystem third_party/soem/soem -isystem third_party/soem/osal $(XML)
SOEM_CFLAGS = -std=gnu11 -O2 -g -w -DEC_VER2 -Iharness -Iharness/bus/port -Ithird_party/soem/soem -Ithird_party/soem/osal $(CFLAGS)
LIBS    := -lelf -ldw -lcapstone -lunicorn -lsodium -lseccomp -ljansson -linih -lxml2 -lm

# --- sources -------------------------------------------------------------------------------------

IMAGE_SRC := image.c image_sort.c image_text.c elf.c elf_kinds.c elf_header.c elf_segments.c elf_dynamic.c elf_hash.c \
    elf_symbols.c elf_symtab.c elf_lookup.c elf_relocs.c elf_initialisers.c pe.c pe_headers.c pe_sections.c pe_exports.c \
    pe_imports.c pe_relocs.c pe_initialisers.c pe_symbols.c pe_debug.c flat.c lines.c lines_extract.c \
    image_child.c \
    pe_unwind.c \
    code.c \
    code_step.c \
    code_arm.c \
    code_map.c \
    code_x86.c \
    code_operands.c \
    code_special.c \
    census.c \
    census_bytes.c \
    census_users.c \
    stack.c \
    stack_graph.c \
    stack_returns.c \
    stack_state.c \
    stack_values.c \
    stack_walk.c
MACHINE_SRC := load.c poison.c regions.c call.c fault.c attribute.c watchdog.c sandbox.c filter.c confine.c worker.c \
    interrupt.c \
    arguments.c \
    serve.c \
    reload.c \
    aside.c \
    rehearse.c \
    system_call.c \
    machine.c \
    instrumented.c \
    instrumented_call.c \
    instrumented_fault.c \
    instrumented_hooks.c \
    instrumented_rehearse.c \
    cpu_x86.c \
    cpu_arm.c \
    native.c \
    thread_block.c
BUS_SRC := client.c client_cycle.c client_jobs.c client_map.c client_watch.c client_rewind.c fiber.c segment.c slave.c registers.c sii.c syncman.c fmmu.c al.c dc.c \
    watchdog.c mailbox.c coe.c coe_info.c od.c pdo.c cia402.c axis.c devices.c dev_drive.c drive.c drive_cyclic.c \
    drive_homing.c drive_od.c drive_profile.c wire.c \
    faults.c \
    fault_arguments.c \
    fault_script.c \
    fault_verbs.c \
    fault_words.c \
    drive_device.c \
    dev_tgz.c \
    tgz_errors.c \
    tgz_native.c \
    tgz_od.c \
    plan.c \
    drive_cruise.c \
    drive_rest.c \
    topology.c \
    ports.c \
    sync.c \
    pcap.c rack.c view.c live.c live_socket.c \
    port/clock.c port/port.c \
    scan.c \
    stimulus.c \
    terminal.c \
    description.c \
    description_build.c \
    device_file.c \
    device_write.c \
    library.c \
    esi.c \
    esi_dictionary.c \
    esi_xml.c \
    busfile.c
TERMINALS := $(wildcard harness/bus/terminals/*.device)
HOST_SRC := realtime.c shm.c product.c schedule.c extent.c servo_wire.c \
    servo_select.c \
    audit.c \
    config.c config_keys.c config_check.c \
    coverage.c \
    digest.c \
    evidence_file.c \
    evidence_rows.c \
    catalogue.c text16.c evidence.c plant.c host_select.c osc.c experiment.c \
    profile_shape.c \
    profile_motion.c \
    sketch.c \
    scenario_read.c \
    scenario_words.c \
    scenario_expression.c \
    scenario_value.c \
    scenario_play.c \
    scenario_tell.c \
    gear_motion.c \
    channel.c \
    drive_error.c \
    can.c \
    can_script.c \
    angle.c \
    interp_path.c \
    interp_run.c \
    interp_filter.c \
    interp_file.c
# What touches registers: once for each layout of the shared memories.
LAYOUT_SRC := measure.c \
    watch.c \
    digest_take.c \
    plc.c \
    preempt.c \
    sleep.c \
    races.c \
    races_judge.c \
    races_state.c \
    unable.c \
    rewind.c \
    host.c host_rows.c memories.c services.c timers.c servo.c dio.c \
    motion.c \
    scope.c \
    command.c \
    scene.c \
    capture.c \
    console.c \
    channels.c \
    general.c \
    servo_error.c \
    servo_outputs.c \
    safety.c \
    statistics.c \
    eeprom.c \
    can_memory.c \
    entries.c \
    interpolator.c \
    interpolator_command.c
LAYOUTS := gen4 gen5_905 gen5_906
REPORT_SRC := text.c json.c \
    curves.c \
    json_text.c \
    markup.c \
    report.c \
    junit.c \
    sarif.c \
    html.c \
    html_axis.c \
    html_bars.c \
    html_parts.c \
    html_plots.c \
    html_runs.c \
    picture.c
CLI_SRC := main.c options.c output.c check.c run.c inspect.c inspect_text.c inspect_json.c rules.c new.c registers.c \
    clock.c \
    config.c \
    configuration.c \
    certify.c \
    keygen.c \
    program.c \
    verify.c \
    capture.c bus.c plot.c scope.c \
    record.c \
    reports.c \
    selftest.c \
    machine.c \
    scenario.c \
    device.c \
    eeprom.c \
    path.c
CONFORMANCE_SRC := profile.c rules.c findings.c incidents.c rules_file.c rules_start.c rules_cycle.c \
    rules_cycle_calls.c \
    rules_cycle_motion.c \
    rules_cycle_access.c \
    budgets.c \
    rules_same.c \
    rules_file_code.c \
    rules_file_exports.c \
    rules_file_load.c \
    rules_file_memory.c \
    rules_file_names.c \
    rules_file_runtime.c \
    rules_machine.c \
    rules_preempted.c \
    rules_disturbed.c \
    again.c \
    archive_open.c \
    archive_read.c \
    archive_save.c \
    waivers.c \
    selftest.c \
    cases.c \
    certificate.c \
    chronicle.c \
    chronicle_coverage.c \
    chronicle_plot.c \
    envelope.c \
    expected.c \
    keys.c \
    judge.c \
    plan.c \
    rule_book.c \
    runs.c \
    suite.c \
    check.c
SOEM_SRC := ethercatbase.c ethercatcoe.c ethercatconfig.c ethercatdc.c ethercatmain.c ethercatprint.c ethercatsoe.c

ROOM_OBJ := $(addprefix $(BUILD)/obj/harness/image/,$(IMAGE_SRC:.c=.o)) \
    $(addprefix $(BUILD)/obj/harness/machine/,$(MACHINE_SRC:.c=.o)) $(BUILD)/obj/harness/machine/trampoline.o \
    $(BUILD)/obj/harness/machine/thunks.o \
    $(addprefix $(BUILD)/obj/harness/bus/,$(BUS_SRC:.c=.o)) $(BUILD)/obj/harness/bus/fiber_switch.o \
    $(BUILD)/obj/harness/bus/terminals.o \
    $(BUILD)/obj/harness/report/style.o \
    $(BUILD)/obj/conformance/rulebook.o \
    $(addprefix $(BUILD)/obj/harness/host/,$(HOST_SRC:.c=.o)) $(LAYOUTS:%=$(BUILD)/obj/harness/host_%.o) \
    $(addprefix $(BUILD)/obj/harness/report/,$(REPORT_SRC:.c=.o)) \
    $(addprefix $(BUILD)/obj/conformance/,$(CONFORMANCE_SRC:.c=.o)) \
    $(BUILD)/obj/conformance/faults.o \
    $(addprefix $(BUILD)/obj/soem/,$(SOEM_SRC:.c=.o))
CLI_OBJ  := $(addprefix $(BUILD)/obj/harness/cli/,$(CLI_SRC:.c=.o))

# --- everyday ------------------------------------------------------------------------------------

.PHONY: all
all: $(BUILD)/tgm ## build everything into build/ (the program is build/tgm)

SCENARIOS ?= $(if $(filter $(BUILD)/template/shuttle.tgm,$(MODULE)),templates/project/acceptance.scenario)
.PHONY: check
check: $(BUILD)/tgm $(if $(filter $(BUILD)/template/shuttle.tgm,$(MODULE)),template-linked) ## judge MODULE=path/to.tgm, by default the C template's module
	$(Q)$(BUILD)/tgm check $(addprefix --scenario ,$(SCENARIOS)) $(CHECK_FLAGS) $(MODULE)

# The template's module as linked: the verdict covers what the SDK's own check would refuse, too.
.PHONY: template-linked
template-linked:
	$(Q)$(MAKE) --no-print-directory -C templates/c BUILD=$(abspath $(BUILD))/template-build \
	    $(abspath $(BUILD))/template-build/unverified/shuttle.tgm
	@mkdir -p $(BUILD)/template
	@cp $(BUILD)/template-build/unverified/shuttle.tgm $(BUILD)/template/shuttle.tgm

.PHONY: run
run: $(BUILD)/tgm template-linked ## run the template's module for two seconds of machine time
	$(Q)$(BUILD)/tgm run $(RUN_FLAGS) $(MODULE)

TEMPLATE_TARGETS := elf64 pe64 pe32 tgmmini tgmcontroller tgzmotion
.PHONY: templates
templates: $(BUILD)/tgm | $(BUILD)/.deps-test ## build every template for every target it has
	$(Q)for target in $(TEMPLATE_TARGETS); do for lang in c cpp; do \
	    $(MAKE) --no-print-directory -C templates/$$lang TARGET=$$target BUILD=$(abspath $(BUILD))/templates/$$lang-$$target || exit 1; \
	done; done
	$(Q)for target in elf64 pe64; do \
	    $(MAKE) --no-print-directory -C templates/pascal TARGET=$$target BUILD=$(abspath $(BUILD))/templates/pascal-$$target || exit 1; \
	done

.PHONY: test
test: | $(BUILD)/.deps-test ## every test; 10 minutes on two cores, 13 from nothing
	$(Q)MAKE=$(MAKE) tests/run.sh

.PHONY: test-sanitizers
test-sanitizers: | $(BUILD)/.deps-test ## unit tests again, with the address and undefined behaviour sanitizers; clang
	$(Q)MAKE=$(MAKE) tests/run.sh sanitizers

.PHONY: bench
bench: $(BUILD)/tgm $(BUILD)/test/bench $(BUILD)/test/bench_bus $(BUILD)/test/bench_machine template-linked ## figures of one run, on this machine
	$(Q)$(BUILD)/test/bench $(BUILD)/template/shuttle.tgm
	$(Q)TGM=$(BUILD)/tgm BUILD=$(BUILD) sh tests/bench_targets.sh
	$(Q)$(BUILD)/test/bench_bus
	$(Q)$(BUILD)/test/bench_machine

.PHONY: targets-report
targets-report: $(BUILD)/tgm | $(BUILD)/.deps-test ## templates and fixtures on every target: the tables of docs/targets.md
	$(Q)tools/targets.py --build $(BUILD)

FUZZ_SECONDS ?= 300
FUZZERS := fuzz_image fuzz_text \
    fuzz_image_deep \
    fuzz_segment \
    fuzz_faults \
    fuzz_code \
    fuzz_scenario \
    fuzz_device \
    fuzz_certificate \
    fuzz_config \
    fuzz_text16 \
    fuzz_evidence \
    fuzz_manifest \
    fuzz_path
.PHONY: fuzz
fuzz: $(addprefix $(BUILD)/fuzz/,$(FUZZERS)) ## fuzz the readers of module files and fault scripts, the SDK's text and the bus segment for FUZZ_SECONDS each (default 300)
	$(Q)for fuzzer in $(FUZZERS); do mkdir -p $(BUILD)/fuzz/corpus-$$fuzzer; seeds=tests/corpus/$${fuzzer#fuzz_}; \
	    if [ -d $$seeds ]; then seeds="-dict=$$seeds.dict $$seeds"; else seeds=; fi; \
	    $(BUILD)/fuzz/$$fuzzer -max_total_time=$(FUZZ_SECONDS) -artifact_prefix=$(BUILD)/fuzz/$$fuzzer- \
	    $(BUILD)/fuzz/corpus-$$fuzzer $$seeds || exit 1; done

.PHONY: layouts
layouts: ## regenerate what follows from sdk/layout/
	$(Q)tools/layout.py

.PHONY: rules
rules: ## regenerate docs/rules.md from the rule book and its fixtures
	$(Q)tools/rules.py

.PHONY: mutation
mutation: $(BUILD)/tgm fixtures ## break one line of the rules' code at a time; tgm selftest must notice (docs/testing.md)
	$(Q)tools/mutate.py $(MUTATE_FLAGS)

.PHONY: deps
deps: $(BUILD)/.deps ## install missing Debian packages, saying what and why

.PHONY: fetch
fetch: third_party/soem/.from third_party/musl/.from ## fetch SOEM's and musl's sources, pinned by hash

.PHONY: install
install: $(BUILD)/tgm fixtures third_party/musl/.from ## install the program and the SDK under PREFIX (default /usr/local)
	install -d $(DESTDIR)$(PREFIX)/bin $(DESTDIR)$(PREFIX)/share/tgm/third_party
	install -m 755 $(BUILD)/tgm $(DESTDIR)$(PREFIX)/bin/tgm
	cp -R sdk templates $(DESTDIR)$(PREFIX)/share/tgm/
	cp -R third_party/musl $(DESTDIR)$(PREFIX)/share/tgm/third_party/
	rm -rf $(DESTDIR)$(PREFIX)/share/tgm/templates/*/build
	rm -rf $(DESTDIR)$(PREFIX)/share/tgm/fixtures
	cd $(FIXTURE_DIR) && find . -name '*.tgm' -o -name '*.tgm.bin' -o -name '*.scenario' -o -name expected | while read -r file; do \
	    install -D -m 644 "$$file" "$(abspath $(DESTDIR)$(PREFIX))/share/tgm/fixtures/$$file" || exit 1; done
	cp -R docs LICENSES $(DESTDIR)$(PREFIX)/share/tgm/
	install -m 644 LICENSE $(DESTDIR)$(PREFIX)/share/tgm/

.PHONY: clean
clean: ## remove what was built (not what was fetched)
	rm -rf $(BUILD) templates/*/build

.PHONY: help
help: ## this list
	@awk -F':.*## ' '/^[a-z-]+:.*## / {printf "  make %-10s %s\n", $$1, $$2}' $(MAKEFILE_LIST)
	@echo "  V=1 shows the commands; CC=clang, CFLAGS=..., BUILD=dir as usual"

# --- rules ---------------------------------------------------------------------------------------

$(BUILD)/.deps: tools/deps.sh
	@mkdir -p $(@D)
	@tools/deps.sh build
	@touch $@

$(BUILD)/.deps-test: tools/deps.sh
	@mkdir -p $(@D)
	@tools/deps.sh test
	@touch $@

third_party/soem/.from: third_party/soem.lock third_party/fetch.sh | $(BUILD)/.deps
	@third_party/fetch.sh
	@touch $@

third_party/musl/.from: third_party/musl.lock third_party/fetch.sh | $(BUILD)/.deps
	@third_party/fetch.sh musl
	@touch $@

$(BUILD)/tgm: $(CLI_OBJ) $(ROOM_OBJ)
	@echo "  LINK   $@"
	$(Q)$(CC) $(OPT) $(CFLAGS) -o $@ $^ $(LDFLAGS) $(LIBS)

$(BUILD)/obj/harness/bus/%.o: harness/bus/%.c | third_party/soem/.from
	@mkdir -p $(@D)
	@echo "  CC     $<"
	$(Q)$(CC) $(ALL_CFLAGS) $(BUS_CFLAGS) -c -o $@ $<

$(BUILD)/obj/soem/%.o: third_party/soem/.from $(wildcard harness/bus/port/*.h)
	@mkdir -p $(@D)
	@echo "  CC     third_party/soem/soem/$*.c"
	$(Q)$(CC) $(SOEM_CFLAGS) -c -o $@ third_party/soem/soem/$*.c

gen4_FLAGS     := -DTGM_GENERATION=4 -DHOST_OPS=host_gen4
gen5_905_FLAGS := -DTGM_GENERATION=5 -DTGM_MEMORY_ID=905 -DHOST_OPS=host_gen5_905
gen5_906_FLAGS := -DTGM_GENERATION=5 -DTGM_MEMORY_ID=906 -DHOST_OPS=host_gen5_906
LAYOUT_OBJ := $(foreach layout,$(LAYOUTS),$(addprefix $(BUILD)/obj/harness/host_$(layout)/,$(LAYOUT_SRC:.c=.o)))

define layout_rules
$(BUILD)/obj/harness/host_$(1)/%.o: harness/host/%.c | $(BUILD)/.deps
	@mkdir -p $$(@D)
	@echo "  CC     $$< ($(1))"
	$$(Q)$$(CC) $$(ALL_CFLAGS) $$($(1)_FLAGS) -c -o $$@ $$<

# One object of each layout, of which only the table is seen from outside.
$(BUILD)/obj/harness/host_$(1).o: $(addprefix $(BUILD)/obj/harness/host_$(1)/,$(LAYOUT_SRC:.c=.o))
	@echo "  LAYOUT $(1)"
	$$(Q)ld -r -o $$@ $$^
	$$(Q)objcopy --keep-global-symbol=host_$(1) $$@
endef
$(foreach layout,$(LAYOUTS),$(eval $(call layout_rules,$(layout))))

$(BUILD)/obj/%.o: %.c | $(BUILD)/.deps
	@mkdir -p $(@D)
	@echo "  CC     $<"
	$(Q)$(CC) $(ALL_CFLAGS) -c -o $@ $<

$(BUILD)/obj/harness/bus/terminals.o: $(TERMINALS)
$(BUILD)/obj/conformance/rulebook.o: docs/rules.md
$(BUILD)/obj/conformance/faults.o: $(wildcard conformance/faults/*.faults)

$(BUILD)/obj/harness/report/style.o: harness/report/report.css

$(BUILD)/obj/%.o: %.S | $(BUILD)/.deps
	@mkdir -p $(@D)
	@echo "  AS     $<"
	$(Q)$(CC) $(INCLUDE) -MMD -MP $(CFLAGS) -c -o $@ $<

FUZZ_CC := clang -std=gnu11 -g -O2 $(INCLUDE) -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all
# For readers whose words stand in a dictionary (tests/corpus/NAME.dict): looking on at every comparison takes most of the time.
FUZZ_WORDS := -fno-sanitize-coverage=trace-cmp
$(addprefix $(BUILD)/fuzz/,$(FUZZERS)): $(wildcard harness/*/*.h conformance/*.h tests/*.h)

# Headers with small limits, which an input of some hundred bytes reaches, and with structures that are cleared and
# looked through ten thousand times a second: evidence has 4 kB instead of 360.
FUZZ_SMALL := $(BUILD)/fuzz/small
FUZZ_LIMITS := SCENARIO_STATEMENTS=24 SCENARIO_REGISTERS=8 SCENARIO_CODE=96 \
    EVIDENCE_INCIDENTS=2 EVIDENCE_MESSAGES=3 EVIDENCE_TEXT=24 EVIDENCE_FAULTS=3 EVIDENCE_FAILURES=4 EVIDENCE_LINES=4 \
    EVIDENCE_EEPROM=32 EVIDENCE_INTERRUPTS=3 EVIDENCE_RACES=2 \
    AUDIT_ACCESSES=4 DIGEST_STATES=4 DIGEST_TRAILS=4 DIGEST_MEMORIES=2 COVERAGE_MOST=64 SKETCH_BUCKETS=4 LATENCY_BINS=8
FUZZ_LIMIT_HEADERS := scenario_parts.h evidence.h audit.h digest.h coverage.h sketch.h realtime.h
$(FUZZ_SMALL)/.made: Makefile $(addprefix harness/host/,$(FUZZ_LIMIT_HEADERS))
	@mkdir -p $(FUZZ_SMALL)/host
	$(Q)for header in $(FUZZ_LIMIT_HEADERS); do \
	    sed $(foreach limit,$(FUZZ_LIMITS),-e 's/^#define $(firstword $(subst =, ,$(limit))) .*/#define $(subst =, ,$(limit))/') \
	        harness/host/$$header >$(FUZZ_SMALL)/host/$$header || exit 1; done
	@touch $@

$(BUILD)/fuzz/fuzz_image: tests/fuzz_image.c tests/image_support.c tests/image_support_pe.c $(addprefix harness/image/,$(IMAGE_SRC)) | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  FUZZ   $@"
	$(Q)$(FUZZ_CC) -O2 -o $@ $(filter %.c,$^) $(LIBS)

$(BUILD)/fuzz/fuzz_image_deep: tests/fuzz_image.c tests/image_support.c tests/image_support_pe.c $(addprefix harness/image/,$(IMAGE_SRC)) | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  FUZZ   $@"
	$(Q)$(FUZZ_CC) -DFUZZ_DEEP -o $@ $(filter %.c,$^) $(LIBS)

$(BUILD)/fuzz/fuzz_code: tests/fuzz_code.c $(addprefix harness/image/,$(IMAGE_SRC)) | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  FUZZ   $@"
	$(Q)$(FUZZ_CC) -o $@ $(filter %.c,$^) $(LIBS)

$(BUILD)/fuzz/fuzz_text: tests/fuzz_text.c sdk/src/number.c sdk/src/text16.c sdk/src/text8.c | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  FUZZ   $@"
	$(Q)$(FUZZ_CC) -DTGM_HOST -o $@ $(filter %.c,$^) -lm

$(BUILD)/fuzz/fuzz_config: tests/fuzz_config.c $(addprefix harness/host/,config.c config_keys.c config_check.c product.c plant.c servo_select.c) harness/bus/scan.c | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  FUZZ   $@"
	$(Q)$(FUZZ_CC) $(FUZZ_WORDS) -o $@ $(filter %.c,$^) -linih

$(BUILD)/fuzz/fuzz_certificate: tests/fuzz_certificate.c tests/fuzz_json.h $(addprefix conformance/,certificate.c envelope.c keys.c) harness/report/report.c | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  FUZZ   $@"
	$(Q)$(FUZZ_CC) -Itests -o $@ $(filter %.c,$^) -ljansson -lsodium

$(BUILD)/fuzz/fuzz_text16: tests/fuzz_text16.c harness/host/text16.c harness/machine/arguments.c | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  FUZZ   $@"
	$(Q)$(FUZZ_CC) -o $@ $(filter %.c,$^) -lm

$(BUILD)/fuzz/fuzz_evidence: tests/fuzz_evidence.c $(addprefix harness/host/,evidence.c evidence_file.c evidence_rows.c audit.c coverage.c sketch.c product.c catalogue.c) conformance/waivers.c $(FUZZ_SMALL)/.made | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  FUZZ   $@"
	$(Q)$(FUZZ_CC) -iquote $(FUZZ_SMALL) $(FUZZ_WORDS) -o $@ $(filter %.c,$^) -lm

# The manifest of saved evidence; the fuzzer has the folder.
$(BUILD)/fuzz/fuzz_manifest: tests/fuzz_manifest.c tests/fuzz_json.h $(addprefix conformance/,archive_open.c again.c profile.c waivers.c) $(addprefix harness/host/,$(filter-out scenario_play.c,$(filter scenario_%,$(HOST_SRC))) product.c catalogue.c) harness/bus/scan.c $(FUZZ_SMALL)/.made | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  FUZZ   $@"
	$(Q)$(FUZZ_CC) -Itests -iquote $(FUZZ_SMALL) $(FUZZ_WORDS) -o $@ $(filter %.c,$^) -ljansson -lsodium -lm

# The arithmetic of an interpolator and the text it reads.
$(BUILD)/fuzz/fuzz_path: tests/fuzz_path.c $(addprefix harness/host/,interp_file.c interp_path.c interp_run.c interp_filter.c angle.c profile_shape.c) | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  FUZZ   $@"
	$(Q)$(FUZZ_CC) -ffp-contract=off -o $@ $(filter %.c,$^) -lm

# The simulated bus alone, without the SOEM client.
$(BUILD)/fuzz/fuzz_faults: tests/fuzz_faults.c $(addprefix harness/bus/,$(filter-out client% port/% view.c live% rack.c fiber.c,$(BUS_SRC))) harness/bus/terminals.S | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  FUZZ   $@"
	$(Q)$(FUZZ_CC) $(XML) -o $@ $(filter %.c %.S,$^) -lxml2 -lm

# The segment without the master above it: what of the room does not know SOEM.
SEGMENT_SRC := $(filter-out client%.c wire.c port/%.c view.c live%.c rack.c fiber.c,$(BUS_SRC))
$(BUILD)/fuzz/fuzz_segment: tests/fuzz_segment.c $(addprefix harness/bus/,$(SEGMENT_SRC)) harness/bus/terminals.S | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  FUZZ   $@"
	$(Q)$(FUZZ_CC) -Itests -ffp-contract=off $(XML) -o $@ $(filter %.c %.S,$^) -lxml2 -lm

DEVICE_FILE_SRC := scan.c description.c description_build.c device_file.c device_write.c esi.c esi_dictionary.c esi_xml.c terminal.c stimulus.c od.c sii.c

$(BUILD)/fuzz/fuzz_device: tests/fuzz_device.c $(addprefix harness/bus/,$(DEVICE_FILE_SRC)) | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  FUZZ   $@"
	$(Q)$(FUZZ_CC) $(XML) -o $@ $(filter %.c,$^) -lxml2

# Scenarios without a host and without a bus: the fuzzer has the two functions that they want.
SCENARIO_SRC := $(addprefix harness/host/,$(filter scenario_%,$(HOST_SRC)) catalogue.c) harness/bus/scan.c
$(BUILD)/fuzz/fuzz_scenario: tests/fuzz_scenario.c $(SCENARIO_SRC) $(FUZZ_SMALL)/.made | $(BUILD)/.deps-test
	@mkdir -p $(@D)
	@echo "  FUZZ   $@"
	$(Q)$(FUZZ_CC) -iquote $(FUZZ_SMALL) $(FUZZ_WORDS) -ffp-contract=off -o $@ $(filter %.c,$^) -lm

-include tests/tests.mk
-include $(filter-out $(BUILD)/obj/soem/%,$(ROOM_OBJ:.o=.d)) $(CLI_OBJ:.o=.d) $(LAYOUT_OBJ:.o=.d)
