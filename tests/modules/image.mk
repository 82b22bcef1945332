# SPDX-License-Identifier: GPL-2.0-or-later
#
# The modules that test_image.c reads. Needs: BUILD. Gives: IMAGE_MODULES (all of them).
# gcc, clang, lld and bfd on purpose: they lay files out differently.

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
	start.so start_lld.so start_null.so old.so libc.so libc_lld.so)

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
$(IMAGE_DIR)/six_arm.so: $(IMAGE_SIX)
	clang --target=arm-linux-gnueabihf $(IMAGE_CFLAGS) $(IMAGE_LINK) -fuse-ld=lld $< -o $@
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
