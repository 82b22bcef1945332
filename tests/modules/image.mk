# SPDX-License-Identifier: GPL-2.0-or-later
#
# The modules that test_image.c reads. Needs: BUILD. Gives: IMAGE_MODULES (all of them).
# gcc, clang, mingw, lld and bfd on purpose: they lay files out differently.

IMAGE_DIR := $(BUILD)/modules
IMAGE_MODULE_SRC := tests/modules
IMAGE_CFLAGS := -O2 -g -ffreestanding -fPIC -fvisibility=hidden -fno-stack-protector \
	-fno-asynchronous-unwind-tables -fshort-wchar -ffile-prefix-map=$(CURDIR)=.
IMAGE_LINK := -nostdlib -shared -Wl,--build-id=none
IMAGE_GCC := gcc $(IMAGE_CFLAGS) $(IMAGE_LINK) -fuse-ld=bfd
IMAGE_CLANG := clang $(IMAGE_CFLAGS) $(IMAGE_LINK) -fuse-ld=lld

IMAGE_MODULES := $(addprefix $(IMAGE_DIR)/,six.so six_lld.so six_stripped.so six_sysv.so six_both.so \
	six_relr.so six_relr_lld.so six_plain.so six_libc.so six_dwarf4.so six_gz.so six_execstack.so \
	six_nostack.so six_filter.so six.o six_exec six_pie six_i386.so six_arm.so six.dll \
	start.so start_lld.so start_null.so old.so libc.so libc_lld.so \
	six_arm_lld.so six_thumb.so six_arm_relr.so start_arm.so flat.elf flat.tgm.bin \
	census.so census_arm.so census_stripped.so census_sizeless.so census.dll \
	entry_idle.dll entry_writes.dll entry_calls.dll entry_loops.dll entry_asks.dll \
	stack.so stack_back.so stack_i386.dll stack_arm.so six_pdata.dll \
	$(foreach m,x86_64 i686,six_mingw_$m.dll six_mingw_$(m)_stripped.dll six_lld_$m.dll \
	pe_mingw_$m.dll pe_lld_$m.dll pe_delay_$m.dll pe_ctors_$m.dll pe_exe_$m.exe))

$(IMAGE_MODULES): | $(IMAGE_DIR)
$(IMAGE_DIR):
	mkdir -p $@

IMAGE_SIX := $(IMAGE_MODULE_SRC)/image_six.c
$(IMAGE_DIR)/six.so: $(IMAGE_SIX)
	$(IMAGE_GCC) -Wl,-z,defs $< -o $@
$(IMAGE_DIR)/six_lld.so: $(IMAGE_SIX)
	$(IMAGE_CLANG) -Wl,-z,defs $< -o $@
$(IMAGE_DIR)/six_stripped.so: $(IMAGE_SIX)
	$(IMAGE_GCC) -s $< -o $@
$(IMAGE_DIR)/six_sysv.so: $(IMAGE_SIX)
	$(IMAGE_GCC) -Wl,--hash-style=sysv $< -o $@
$(IMAGE_DIR)/six_both.so: $(IMAGE_SIX)
	$(IMAGE_GCC) -Wl,--hash-style=both $< -o $@
$(IMAGE_DIR)/six_relr.so: $(IMAGE_SIX)
	$(IMAGE_GCC) -Wl,-z,pack-relative-relocs $< -o $@
$(IMAGE_DIR)/six_relr_lld.so: $(IMAGE_SIX)
	$(IMAGE_CLANG) -Wl,--pack-dyn-relocs=relr $< -o $@
$(IMAGE_DIR)/six_plain.so: $(IMAGE_SIX)
	gcc -shared -fPIC -nostdlib $< -o $@
$(IMAGE_DIR)/six_libc.so: $(IMAGE_SIX)
	gcc -shared -fPIC $< -o $@
$(IMAGE_DIR)/six_dwarf4.so: $(IMAGE_SIX)
	$(IMAGE_GCC) -gdwarf-4 $< -o $@
$(IMAGE_DIR)/six_gz.so: $(IMAGE_SIX)
	$(IMAGE_GCC) -gz $< -o $@
$(IMAGE_DIR)/six_execstack.so: $(IMAGE_SIX)
	$(IMAGE_GCC) -Wl,-z,execstack $< -o $@
$(IMAGE_DIR)/six_nostack.so: $(IMAGE_SIX)
	$(IMAGE_CLANG) -Wl,-z,nognustack $< -o $@
$(IMAGE_DIR)/six_filter.so: $(IMAGE_SIX)
	$(IMAGE_GCC) -Wl,-F,front.so -Wl,-f,aside.so $< -o $@
$(IMAGE_DIR)/six.o: $(IMAGE_SIX)
	gcc $(IMAGE_CFLAGS) -c $< -o $@
$(IMAGE_DIR)/six_exec: $(IMAGE_SIX)
	gcc $(IMAGE_CFLAGS) -static -no-pie -nostdlib -Wl,-e,Program_01 $< -o $@
$(IMAGE_DIR)/six_pie: $(IMAGE_SIX)
	gcc $(IMAGE_CFLAGS) -pie -nostdlib -Wl,-e,Program_01 $< -o $@
$(IMAGE_DIR)/six_i386.so: $(IMAGE_SIX)
	clang --target=i386-linux-gnu $(IMAGE_CFLAGS) $(IMAGE_LINK) -fuse-ld=lld $< -o $@
$(IMAGE_DIR)/six.dll: $(IMAGE_SIX)
	clang --target=x86_64-pc-windows-msvc -O2 -ffreestanding -c $< -o $@.obj
	lld-link /DLL /NOENTRY /NODEFAULTLIB /EXPORT:Program_01 /OUT:$@ $@.obj

IMAGE_START := $(IMAGE_MODULE_SRC)/image_start.c
$(IMAGE_DIR)/start.so: $(IMAGE_START)
	$(IMAGE_GCC) $< -o $@
$(IMAGE_DIR)/start_lld.so: $(IMAGE_START)
	$(IMAGE_CLANG) $< -o $@
$(IMAGE_DIR)/start_null.so: $(IMAGE_START)
	$(IMAGE_GCC) -Wl,-z,nodynamic-undefined-weak $< -o $@
$(IMAGE_DIR)/old.so: $(IMAGE_MODULE_SRC)/image_old.c
	$(IMAGE_CLANG) $< -o $@
$(IMAGE_DIR)/libc.so: $(IMAGE_MODULE_SRC)/image_libc.c
	gcc -O2 -g -shared -fPIC $< -o $@
$(IMAGE_DIR)/libc_lld.so: $(IMAGE_MODULE_SRC)/image_libc.c
	clang -O2 -g -shared -fPIC -fuse-ld=lld $< -o $@

# --- functions of known depth --------------------------------------------------------------------
$(IMAGE_DIR)/stack.so: tests/machine_modules/stack.S
	gcc -shared -nostdlib -Wl,-Bsymbolic -Wl,-z,noexecstack $< -o $@
$(IMAGE_DIR)/stack_back.so: tests/machine_modules/stack.S
	gcc -DBACK -shared -nostdlib -Wl,-Bsymbolic -Wl,-z,noexecstack $< -o $@
$(IMAGE_DIR)/stack_i386.dll: $(IMAGE_MODULE_SRC)/stack_i386.S
	i686-w64-mingw32-gcc -nostdlib -shared -Wl,-e,0 -Wl,--no-insert-timestamp -Wl,--dynamicbase,--nxcompat $< -o $@
$(IMAGE_DIR)/stack_arm.so: $(IMAGE_MODULE_SRC)/stack_arm.S
	arm-linux-gnueabihf-gcc -shared -nostdlib -Wl,-z,notext -Wl,-Bsymbolic $< -o $@
$(IMAGE_DIR)/six_pdata.dll: $(IMAGE_SIX)
	x86_64-w64-mingw32-gcc $(filter-out -fno-asynchronous-unwind-tables,$(IMAGE_MINGW_FLAGS)) -Wl,-e,0 \
	    -Wl,--dynamicbase,--nxcompat $< sdk/link/pe64.def -o $@

# --- instructions, and ways to them ---------------------------------------------------------------
$(IMAGE_DIR)/census.so: $(IMAGE_MODULE_SRC)/census.S
	gcc -shared -nostdlib -Wl,-Bsymbolic -Wl,-z,noexecstack $< -o $@
$(IMAGE_DIR)/census_arm.so: $(IMAGE_MODULE_SRC)/census_arm.S
	arm-linux-gnueabihf-gcc -shared -nostdlib -Wl,-Bsymbolic $< -o $@
$(IMAGE_DIR)/census_stripped.so: $(IMAGE_DIR)/census.so
	strip $< -o $@
$(IMAGE_DIR)/census_sizeless.so: $(IMAGE_MODULE_SRC)/census.S
	sed 's/\.size .*//' $< > $@.S
	gcc -shared -nostdlib -Wl,-Bsymbolic -Wl,-z,noexecstack $@.S -o $@
$(IMAGE_DIR)/census.dll: $(IMAGE_MODULE_SRC)/census.S
	sed 's/\.size .*//; s/\.type .*//; s/, @progbits//; s/^ *\.section .note.*//' $< > $@.S
	x86_64-w64-mingw32-gcc -nostdlib -shared -Wl,-e,0 -Wl,--no-insert-timestamp $@.S -o $@
census_entry_idle := nop
census_entry_writes := mov [rip + word], ecx
census_entry_calls := call 1f
census_entry_loops := loop DllMain
census_entry_asks := syscall
$(IMAGE_DIR)/entry_%.dll: $(IMAGE_MODULE_SRC)/census_entry.S
	x86_64-w64-mingw32-gcc -nostdlib -shared -Wl,-e,DllMain -Wl,--no-insert-timestamp \
	    '-DDEED=$(census_entry_$*)' $< -o $@

# --- Arm -----------------------------------------------------------------------------------------
IMAGE_ARM := arm-linux-gnueabihf-gcc -marm -march=armv7-a -mfpu=vfpv3-d16 $(IMAGE_CFLAGS) $(IMAGE_LINK)
$(IMAGE_DIR)/six_arm.so: $(IMAGE_SIX)
	$(IMAGE_ARM) $< -o $@
$(IMAGE_DIR)/six_arm_lld.so: $(IMAGE_SIX)
	clang --target=arm-linux-gnueabihf -march=armv7-a $(IMAGE_CFLAGS) $(IMAGE_LINK) -fuse-ld=lld $< -o $@
$(IMAGE_DIR)/six_arm_relr.so: $(IMAGE_SIX)
	clang --target=arm-linux-gnueabihf -march=armv7-a $(IMAGE_CFLAGS) $(IMAGE_LINK) -fuse-ld=lld \
	    -Wl,--pack-dyn-relocs=relr $< -o $@
$(IMAGE_DIR)/six_thumb.so: $(IMAGE_SIX)
	$(IMAGE_ARM) -mthumb -Wl,--hash-style=both $< -o $@
$(IMAGE_DIR)/start_arm.so: $(IMAGE_START)
	$(IMAGE_ARM) $< -o $@
$(IMAGE_DIR)/flat.elf: $(IMAGE_MODULE_SRC)/image_flat.c
	arm-none-eabi-gcc -marm -mcpu=cortex-a9 -mfpu=vfpv3 -mfloat-abi=hard -O2 -g -ffreestanding -fno-common -nostdlib \
	    -static -Wl,--build-id=none -Wl,-Ttext=0x07800000 -Wl,-e,GetProcAddress $< -o $@
$(IMAGE_DIR)/flat.tgm.bin: $(IMAGE_DIR)/flat.elf
	arm-none-eabi-objcopy -O binary $< $@

# --- Windows: mingw, and clang with lld for the shape of Microsoft's linker ----------------------
IMAGE_PE := $(IMAGE_MODULE_SRC)/image_pe.c
IMAGE_PE_DEF := $(IMAGE_MODULE_SRC)/image_pe.def
IMAGE_OTHER_DEF := $(IMAGE_MODULE_SRC)/image_other.def
IMAGE_MINGW_FLAGS := -O2 -g -ffreestanding -fno-stack-protector -fno-asynchronous-unwind-tables -nostdlib -shared \
	-Wl,--no-insert-timestamp -ffile-prefix-map=$(CURDIR)=.
image_entry_x86_64 := DllMain
image_entry_i686 := _DllMain@12
image_lld_x86_64 := X64
image_lld_i686 := X86
image_dlltool_x86_64 := i386:x86-64
image_dlltool_i686 := i386

define image_pe_rules
$(IMAGE_DIR)/six_mingw_$(1).dll: $(IMAGE_SIX)
	$(1)-w64-mingw32-gcc $(IMAGE_MINGW_FLAGS) -Wl,-e,0 -Wl,--dynamicbase,--nxcompat $$< \
	    sdk/link/pe$(if $(filter i686,$(1)),32,64).def -o $$@
$(IMAGE_DIR)/six_mingw_$(1)_stripped.dll: $(IMAGE_DIR)/six_mingw_$(1).dll
	$(1)-w64-mingw32-strip $$< -o $$@
$(IMAGE_DIR)/pe_exe_$(1).exe: $(IMAGE_SIX)
	$(1)-w64-mingw32-gcc $(filter-out -shared,$(IMAGE_MINGW_FLAGS)) -Wl,-e,0 $$< -o $$@
$(IMAGE_DIR)/pe_ctors_$(1).dll: $(IMAGE_MODULE_SRC)/image_ctors.c
	$(1)-w64-mingw32-gcc $(IMAGE_MINGW_FLAGS) -Wl,-e,0 $$< -o $$@
$(IMAGE_DIR)/other_$(1).a: $(IMAGE_OTHER_DEF) | $(IMAGE_DIR)
	$(1)-w64-mingw32-dlltool -d $$< -l $$@ -D OTHER.dll
$(IMAGE_DIR)/resource_$(1).o: $(IMAGE_MODULE_SRC)/image_pe.rc | $(IMAGE_DIR)
	$(1)-w64-mingw32-windres $$< $$@
$(IMAGE_DIR)/pe_mingw_$(1).dll: $(IMAGE_PE) $(IMAGE_DIR)/resource_$(1).o $(IMAGE_PE_DEF) $(IMAGE_DIR)/other_$(1).a
	$(1)-w64-mingw32-gcc $(IMAGE_MINGW_FLAGS) -Wl,-e,$(image_entry_$(1)) $$^ -o $$@
$(IMAGE_DIR)/other_$(1).lib: $(IMAGE_OTHER_DEF) | $(IMAGE_DIR)
	llvm-dlltool -m $(image_dlltool_$(1)) -d $$< -l $$@ -D OTHER.dll
$(IMAGE_DIR)/six_lld_$(1).dll: $(IMAGE_SIX)
	clang --target=$(1)-pc-windows-msvc -O2 -ffreestanding -c $$< -o $$@.obj
	lld-link /DLL /MACHINE:$(image_lld_$(1)) /NOENTRY /NODEFAULTLIB /DEF:sdk/link/pe64.def /OUT:$$@ $$@.obj
$(IMAGE_DIR)/pe_lld_$(1).dll: $(IMAGE_PE) $(IMAGE_DIR)/other_$(1).lib $(IMAGE_PE_DEF)
	clang --target=$(1)-pc-windows-msvc -O2 -ffreestanding -c $$< -o $$@.obj
	lld-link /DLL /MACHINE:$(image_lld_$(1)) /ENTRY:DllMain /NODEFAULTLIB /DEF:$(IMAGE_PE_DEF) /OUT:$$@ \
	    $$@.obj $(IMAGE_DIR)/other_$(1).lib
$(IMAGE_DIR)/pe_delay_$(1).dll: $(IMAGE_PE) $(IMAGE_DIR)/other_$(1).lib $(IMAGE_PE_DEF)
	clang --target=$(1)-pc-windows-msvc -O2 -ffreestanding -DDELAYED -c $$< -o $$@.obj
	lld-link /DLL /MACHINE:$(image_lld_$(1)) /NOENTRY /NODEFAULTLIB /DEF:$(IMAGE_PE_DEF) /DELAYLOAD:OTHER.dll \
	    /OUT:$$@ $$@.obj $(IMAGE_DIR)/other_$(1).lib
endef
$(foreach m,x86_64 i686,$(eval $(call image_pe_rules,$m)))
