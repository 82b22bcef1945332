#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# What the SDK refuses to link, and how it says so: symbol and source line.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
root=$PWD
tgm=$root/${BUILD:-build}/tgm
template=$root/templates/c/shuttle.c

mkdir "$work/m"
cat >"$work/m/Makefile" <<EOF
SDK := $root/sdk
MODULE := sin
SOURCES := sin.c
TGM := $tgm
include \$(SDK)/mk/module.mk
EOF

# refused NAME TEXT...: sin.c does not become a module; the messages hold the texts
refused() {
    name=$1
    shift
    rm -rf "$work/m/build"
    run make -C "$work/m"
    if [ -e "$work/m/build/sin.tgm" ]; then
        fail "$name: a module was made"
    else
        expect "$name" 2 "$@"
    fi
}
with() { # text: the template and this behind it
    { cat "$template"; printf '%s\n' "$1"; } >"$work/m/sin.c"
}
last=$(($(wc -l <"$template") + 1))

for cc in gcc clang; do
    cp "$template" "$work/m/sin.c"
    rm -rf "$work/m/build"
    run make -C "$work/m" CC=$cc
    expect "the template builds with $cc" 0
    run "$tgm" check "$work/m/build/sin.tgm" --cycles 200
    expect "and passes when built with $cc" 0 "RESULT: PASS"
done
rm -rf "$work/m/build"
run make -C "$work/m" CC=clang MODULE_LDFLAGS=-fuse-ld=lld
expect "the template builds with lld" 0
run "$tgm" check "$work/m/build/sin.tgm" --cycles 200
expect "and passes when linked with lld" 0 "RESULT: PASS"

line=$(grep -n '^long Program_01' "$template" | cut -d: -f1)
sed 's/^long Program_01/long program_01/' "$template" >"$work/m/sin.c"
refused "wrong letter case" "sin.c:$line: error: program_01" "Program_01"
run make -C "$work/m" check
expect "wrong letter case: make check says so" 2 "FAIL  export-names" "program_01" "sin.c:$line" "RESULT: FAIL" "Error 1"

# In a section that the linker keeps: what nobody calls is dropped together with what it calls.
keep='__attribute__((used, section(".text.Program_kept"))) static'
with "int printf(const char *, ...); $keep"' void f(void) { printf("x"); }'
refused "undefined symbol" "sin.c:$last: error: printf: defined nowhere"
with 'extern int maybe(void) __attribute__((weak)); __attribute__((used)) static int f(void) { return maybe ? maybe() : 0; }'
refused "weak undefined symbol" "sin.c:$last: error: maybe: weak and defined nowhere"
with 'static volatile int k; __attribute__((constructor)) static void boot(void) { k = 1; }'
refused "constructor" "sin.c:$last: error: boot: constructor"
with '__thread int tl; __attribute__((used)) static int f(void) { return tl; }'
refused "thread-local storage" "sin.c" "error: tl: thread-local"
with 'static int g(void) { return 1; } static int (*r(void))(void) { return g; } int i(void) __attribute__((ifunc("r"))); __attribute__((used)) static int f(void) { return i(); }'
refused "indirect function" "sin.c:$last: error: i: indirect function"
with 'TGM_EXPORT long Program_06(PLC_DATA *p); long Program_06(PLC_DATA *p) { (void)p; return 1; }'
refused "seventh export" "sin.c:$last: error: Program_06: is visible outside"
sed 's/^long Program_05/static __attribute__((used)) long other/' "$template" >"$work/m/sin.c"
refused "missing function" "error: Program_05: missing"

# The header alone, in every dialect that an author may use.
cat >"$work/alone.c" <<'EOF'
#include <tgm_plc.h>
long Program_Ini(PLC_DATA *pData)
{
    HEADER *pHeader = (HEADER *)pData->PSystem_Memory;
    return pHeader->Compatibility_Id == ID_COMPATIBILITY;
}
EOF
for compiler in "gcc -std=c11" "gcc -std=c17" "clang -std=c11" "clang -std=c17" "gcc -x c++ -std=c++17" "clang -x c++ -std=c++17" \
    "clang -target i686-pc-windows-msvc -std=c11 -fms-extensions" "clang -target armv7a-none-eabi -std=c11"; do
    # shellcheck disable=SC2086
    run $compiler -fsyntax-only -ffreestanding -fshort-wchar -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror \
        -I sdk/include "$work/alone.c"
    expect "the header alone: $compiler" 0
done
run gcc -std=c11 -fsyntax-only -I sdk/include "$work/alone.c"
expect "without -fshort-wchar the header says what to do" 1 "compile with -fshort-wchar"
sed 's/double Position;/float Position;/' sdk/include/tgm/layout_gen4.h >"$work/layout.h"
mkdir -p "$work/inc/tgm" && cp sdk/include/tgm_plc.h "$work/inc/" && cp "$work/layout.h" "$work/inc/tgm/layout_gen4.h"
run gcc -std=c11 -fsyntax-only -fshort-wchar -I "$work/inc" "$work/alone.c"
expect "a field of the wrong size does not compile" 1 "SERVO.Position does not have TG Motion"

# Generated files follow the tables.
run tools/layout.py --check
expect "generated layouts are up to date" 0
mkdir "$work/tree" && cp -R sdk tools docs "$work/tree/" && mkdir -p "$work/tree/harness/host" &&
    cp harness/host/catalogue_gen4.inc "$work/tree/harness/host/"
sed -i '/^SERVO\tWritePosition\t/d' "$work/tree/sdk/layout/tgm4.tsv"
run "$work/tree/tools/layout.py" --check
expect "a row that was taken away is noticed" 1 "out of date" "layout_gen4.h"
sed -i 's/^SERVO\tPosition\tdouble\t1\t472\t/SERVO\tPosition\tdouble\t1\t460\t/' "$work/tree/sdk/layout/tgm4.tsv"
run "$work/tree/tools/layout.py" --check
expect "a row that overlaps is refused by name" 1 "SERVO.Position" "overlaps"

# Fetching: a wrong hash stops, an unpacked tree needs no network.
mkdir -p "$work/third_party/download" && cp third_party/fetch.sh third_party/soem.lock "$work/third_party/"
echo "not an archive" >"$work/third_party/download/pysoem-1.1.13.tar.gz"
run "$work/third_party/fetch.sh"
expect "an archive with a wrong hash is refused" 1 "is not the one that soem.lock pins" "expected sha256 4be98d85"
mkdir "$work/third_party/soem" && cp third_party/soem/.from "$work/third_party/soem/" && rm -rf "$work/third_party/download"
run env PATH=/usr/bin:/bin PYTHON=/nonexistent "$work/third_party/fetch.sh"
expect "an unpacked tree works offline" 0

# Installing: program and SDK, and a template that builds from there.
run make install PREFIX="$work/prefix" BUILD="$root/${BUILD:-build}"
expect "make install" 0
cp -R "$work/prefix/share/tgm/templates/c" "$work/mine"
run make -C "$work/mine" SDK="$work/prefix/share/tgm/sdk" TGM="$work/prefix/bin/tgm" check CHECK_FLAGS='--cycles 200'
expect "the installed template builds and passes" 0 "RESULT: PASS"

finish
