#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# fixture.sh SOURCE OUTPUT - builds one module of a rule's fixtures. In its first lines the source may say
#   flags: ...     added to compiler and linker; -r: linked no further
#   target: ...    elf64 (default), pe64, pe32 (mingw), msvc64, msvc32 (clang and lld-link), arm, flat
# V=1 shows the command. Needs FIXTURE_CFLAGS.
set -eu

source=$1
output=$2
field() { sed -n "2,4s/.*$1: \(.*\) \*\/\$/\1/p" "$source" | head -n 1; }
flags=$(field flags)
target=$(field target)

run() {
    [ -z "${V:-}" ] || echo "$*"
    "$@"
}

case $source in
*.cpp) language="-std=c++17 -fno-exceptions -fno-rtti -fno-threadsafe-statics -fno-use-cxa-atexit" ;;
*) language=-std=c11 ;;
esac
case $source in
*.cpp) suffix=++ ;;
*) suffix= ;;
esac
compiler() { [ -n "$suffix" ] && echo "$1" | sed 's/gcc$/g++/; s/clang$/clang++/' || echo "$1"; }

mingw() {
    # shellcheck disable=SC2086
    run "$(compiler "$1-w64-mingw32-gcc")" $language $common -fno-builtin -mno-stack-arg-probe -o "$output" "$source" \
        -nostdlib -shared -static -Wl,-e,0 -Wl,--no-insert-timestamp -Wl,--dynamicbase,--nxcompat "$2" $flags -lgcc
}

msvc() {
    compile=
    link=
    for flag in $flags; do
        case $flag in
        /*) link="$link $flag" ;;
        *) compile="$compile $flag" ;;
        esac
    done
    # shellcheck disable=SC2086
    run "$(compiler clang)" --target="$1"-pc-windows-msvc $language $common -gcodeview -fno-builtin $compile -c -o "$output.obj" "$source"
    # shellcheck disable=SC2086
    run lld-link /DLL /NOENTRY /NODEFAULTLIB /Brepro /DEBUG /PDB:"$output.pdb" /DEF:sdk/link/pe64.def /OUT:"$output" "$output.obj" $link
}

# shellcheck disable=SC2153
common=$FIXTURE_CFLAGS
link="-nostdlib -shared -Wl,-Bsymbolic -Wl,-e,0 -Wl,--hash-style=gnu -Wl,-z,noexecstack -Wl,--build-id=none"
case $flags in
-r) link=-nostdlib ;;
*lld*) ;;
*) link="$link -Wl,-w -Wl,--no-warn-rwx-segments" ;;
esac
case ${target:-elf64} in
elf64)
    # shellcheck disable=SC2086
    case $source in
    *.cpp) # the library is C
        run gcc -std=c11 $common -fno-builtin -c -o "$output.mem.o" sdk/src/mem.c
        run g++ $language $common -fno-builtin -o "$output" "$source" "$output.mem.o" $link $flags ;;
    *) run gcc $language $common -fno-builtin -o "$output" "$source" sdk/src/mem.c $link $flags ;;
    esac
    ;;
pe64) mingw x86_64 sdk/link/pe64.def ;;
pe32) mingw i686 sdk/link/pe32.def ;;
msvc64) msvc x86_64 ;;
msvc32) msvc i686 ;;
*)
    echo "$source: no target $target" >&2
    exit 1
    ;;
esac
