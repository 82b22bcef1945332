#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# A module that uses all of the SDK's support library, as an author builds it: for every target whose compiler is
# here; on elf64 with both compilers and both linkers, and judged.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
root=$PWD
sdk=${SDK:-$root/sdk}
tgm=${TGM:-$root/${BUILD:-build}/tgm}

mkdir "$work/m"
cp tests/modules/sdk_support.c "$work/m/"
cat >"$work/m/Makefile" <<END
MODULE := sdk_support
SOURCES := sdk_support.c
MATH := yes
TGM := $tgm
include $sdk/mk/module.mk
END

# facts NAME MODULE: six exports, relative relocations only, no thread segment (fs, gs), no system call
facts() {
    run readelf --dyn-syms -W "$2"
    exports=$(awk '$1 ~ /^[0-9]+:$/ && $7 != "UND" {print $8}' "$out" | sort | tr '\n' ' ')
    if [ "$exports" = "Program_01 Program_02 Program_03 Program_04 Program_05 Program_Ini " ]; then
        pass "$1: six exports"
    else
        fail "$1: six exports"
    fi
    run readelf -rW "$2"
    if awk '$3 ~ /^R_/ && $3 !~ /_RELATIVE$/ {exit 1}' "$out"; then
        pass "$1: relative relocations only"
    else
        fail "$1: relative relocations only"
    fi
    run objdump -d "$2"
    if grep -qE '%[fg]s:|\bsyscall\b' "$out"; then
        fail "$1: no thread segment, no system call"
    else
        pass "$1: no thread segment, no system call"
    fi
}

for cc in gcc clang; do
    for ld in bfd lld; do
        rm -rf "$work/m/build"
        run make -C "$work/m" CC=$cc MODULE_CFLAGS='-Werror -Wconversion' MODULE_LDFLAGS="-fuse-ld=$ld"
        expect "$cc and $ld: builds" 0
        facts "$cc and $ld" "$work/m/build/sdk_support.tgm"
        run "$tgm" check "$work/m/build/sdk_support.tgm" --cycles 400
        expect "$cc and $ld: passes" 0 "RESULT: PASS"
    done
done
run "$tgm" run "$work/m/build/sdk_support.tgm" --for 100ms
expect "runs and prints" 0 "mathematics off by" "version 0x0104"

for target in pe64:x86_64-w64-mingw32-gcc pe32:i686-w64-mingw32-gcc tgmmini:arm-linux-gnueabihf-gcc \
    tgmcontroller:arm-none-eabi-gcc tgzmotion:arm-none-eabi-gcc; do
    if command -v "${target#*:}" >/dev/null 2>&1; then
        run make -C "$work/m" TARGET="${target%%:*}" MODULE_CFLAGS='-Werror -Wconversion'
        expect "${target%%:*}: builds and verifies" 0
    else
        echo "skipped ${target%%:*}: ${target#*:} is not installed"
    fi
done
run make -C "$work/m" BUILD=build/g5 TGM_GENERATION=5 MODULE_CFLAGS=-Werror
expect "generation 5: builds and verifies" 0

# What is not used is not in the module.
printf '%s\n' '#include <tgm/start.h>' 'long Program_Ini(PLC_DATA *p) { return tgm_check_start(p); }' \
    >"$work/m/sdk_support.c"
for n in 01 02 03 04 05; do
    printf 'long Program_%s(PLC_DATA *p) { (void)p; return 1; }\n' $n >>"$work/m/sdk_support.c"
done
rm -rf "$work/m/build"
run make -C "$work/m"
expect "the smallest module: builds" 0
run nm "$work/m/build/sdk_support.tgm"
lacks "unused functions are dropped" "tgm_move_step"
lacks "unused mathematics is dropped" "__rem_pio2"

# Fetching musl: a wrong hash stops, an unpacked tree needs no network, an unknown name is refused.
mkdir -p "$work/third_party/download" && cp third_party/fetch.sh third_party/musl.lock "$work/third_party/"
echo "not an archive" >"$work/third_party/download/musl_1.2.3.orig.tar.gz"
run "$work/third_party/fetch.sh" musl
expect "an archive of musl with a wrong hash is refused" 1 "is not the one that musl.lock pins" "expected sha256 7d5b0b60"
mkdir "$work/third_party/musl" && cp third_party/musl/.from "$work/third_party/musl/" && rm -rf "$work/third_party/download"
run env PATH=/usr/bin:/bin "$work/third_party/fetch.sh" musl
expect "an unpacked tree of musl works offline" 0
run "$work/third_party/fetch.sh" lua
expect "an unknown name is refused" 2 "not known here"
run env MUSL=/nonexistent "$sdk/mk/math.sh" "$work/math" gcc
expect "without musl the message says what to do" 1 "third_party/fetch.sh musl"

finish
