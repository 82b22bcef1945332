#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# fixture.sh SOURCE OUTPUT - builds one module of a rule's fixtures. In its first lines the source may say
#   flags: ...     added to compiler and linker; -r: linked no further
#   target: ...    elf64 (default), pe64, pe32 (mingw), msvc64 (clang and lld-link), arm (for TGMmini), flat (for
#                  TGMcontroller), bytes (what the assembler makes of .text, and nothing around it)
# Sources whose name has "flat" in it give a file .tgm.bin: what has no header is told by its name.
# V=1 shows the command. Needs FIXTURE_CFLAGS. FIXTURE_TARGET is built for instead, with FIXTURE_FLAGS as well.
set -eu

source=$1
output=$2
field() { sed -n "2,4s/.*$1: \(.*\) \*\/\$/\1/p" "$source" | head -n 1; }
flags=$(field flags)${FIXTURE_FLAGS:+ $FIXTURE_FLAGS}
target=${FIXTURE_TARGET:-$(field target)}

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

# library COMMAND SOURCE...: what the linker is given for the SDK's sources, which are C: objects beside a fixture in C++
library() {
    compile=$1
    shift
    for file; do
        if [ -z "$suffix" ]; then
            echo "$file"
            continue
        fi
        object=$output.$(basename "$file" .c).o
        # shellcheck disable=SC2086
        run $compile -std=c11 $common -fno-builtin -c -o "$object" "$file" >&2
        echo "$object"
    done
}

# The .def file that exports the six functions, unless the fixture brings its own.
definitions() {
    case $flags in
    *.def*) ;;
    *) echo "$1" ;;
    esac
}

mingw() {
    # shellcheck disable=SC2086,SC2046
    case $flags in
    -r*)
        run "$1-w64-mingw32-gcc" $language $common -fno-builtin -o "$output" sdk/src/mem.c "$source" -nostdlib -r
        return
        ;;
    esac
    # shellcheck disable=SC2086,SC2046
    run $(compiler "$1-w64-mingw32-gcc") $language $common -fno-builtin -mno-stack-arg-probe -o "$output" \
        $(library "$1-w64-mingw32-gcc" sdk/src/mem.c) "$source" -nostdlib -shared -static -Wl,-e,0 -Wl,--no-insert-timestamp -Wl,--dynamicbase,--nxcompat \
        -Wl,--exclude-all-symbols $(definitions "$2") $flags -lgcc
}

# Import library for a flag like kernel32.lib: with the one function that fixtures import.
import_library() {
    printf 'LIBRARY %s.dll\nEXPORTS\n    Sleep\n' "${1%.lib}" >"$output.def"
    run llvm-dlltool -m "$2" -d "$output.def" -l "$output.lib"
}

# What begins with a slash is the linker's.
msvc() {
    compile=
    link="/DEF:sdk/link/pe64.def "
    for flag in $flags; do
        case $flag in
        *.def) link="/DEF:$flag ${link#/DEF:* }" ;;
        /*) link="$link $flag" ;;
        *.lib)
            import_library "$flag" "$2"
            link="$link $output.lib"
            ;;
        *) compile="$compile $flag" ;;
        esac
    done
    # shellcheck disable=SC2086,SC2046
    run $(compiler clang) --target="$1-pc-windows-msvc" $language $common -gdwarf-4 -fno-builtin $compile -c -o "$output.obj" "$source"
    # shellcheck disable=SC2086
    run lld-link /DLL /NOENTRY /NODEFAULTLIB /Brepro /DEBUG:DWARF $link /OUT:"$output" "$output.obj"
}

# TGMmini and the controllers: generation 5, text of bytes.
arm_flags="-DTGM_GENERATION=5 -DTGM_TEXT8 -marm"
armv7="-march=armv7-a -mfpu=vfpv3-d16"
cortex="-fno-pic -DTGM_FLAT -mcpu=cortex-a9 -mfpu=vfpv3 -mfloat-abi=hard -fno-common"

# Not by the SDK's linker script, which refuses much of what fixtures do.
arm() {
    gnu=arm-linux-gnueabihf-gcc
    case $flags in
    -r*)
        # shellcheck disable=SC2086
        run $gnu $language $common $arm_flags $armv7 -fno-builtin -o "$output" sdk/src/mem.c "$source" -nostdlib $flags
        return
        ;;
    esac
    # shellcheck disable=SC2086,SC2046
    run $(compiler $gnu) $language $common $arm_flags $armv7 -fno-builtin -o "$output" \
        $(library "$gnu $arm_flags $armv7" sdk/src/mem.c sdk/src/arm.c) "$source" -nostdlib -shared -Wl,-Bsymbolic -Wl,-e,0 -Wl,--hash-style=gnu -Wl,-z,noexecstack \
        -Wl,--build-id=none -Wl,-z,separate-code -Wl,-z,max-page-size=4096 -Wl,-w -Wl,--no-warn-rwx-segments $flags -lgcc
}

flat() {
    bare=arm-none-eabi-gcc
    case $flags in
    -r*) # left as it is: no flat image can be made of it
        # shellcheck disable=SC2086
        run $bare $language $common $arm_flags $cortex -fno-builtin -o "$output" sdk/src/mem.c "$source" -nostdlib $flags
        return
        ;;
    esac
    lookup=sdk/src/flat.c
    ! grep -q '^#include .*flat\.[ch]' "$source" || lookup=
    # shellcheck disable=SC2086,SC2046
    run $(compiler $bare) $language $common $arm_flags $cortex -fno-builtin -o "$output.elf" \
        $(library "$bare $arm_flags $cortex" sdk/src/mem.c $lookup sdk/src/arm.c) "$source" -nostdlib -static \
        -Wl,-T,sdk/link/flat.ld -Wl,--build-id=none -Wl,-z,max-page-size=4096 $flags -lgcc
    run arm-none-eabi-objcopy -O binary "$output.elf" "$output"
}

bytes() {
    run gcc -MMD -MP -MT "$output" -MF "$output.d" -c -o "$output.o" "$source"
    run objcopy -O binary -j .text "$output.o" "$output"
}

# Of several sources the last one's dependencies are kept.
# shellcheck disable=SC2153
common="$FIXTURE_CFLAGS -MMD -MP -MT $output -MF $output.d"
case $target in
pe64 | pe32 | msvc64)
    common=$(echo "$common" | sed 's/-fPIC//; s/-fvisibility=hidden//; s/-fshort-wchar//')
    ;;
esac
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
    *) run gcc $language $common -fno-builtin -o "$output" sdk/src/mem.c "$source" $link $flags ;;
    esac
    ;;
pe64) mingw x86_64 sdk/link/pe64.def ;;
pe32) mingw i686 sdk/link/pe32.def ;;
msvc64) msvc x86_64 i386:x86-64 ;;
arm) arm ;;
flat) flat ;;
bytes) bytes ;;
*)
    echo "$source: no target $target" >&2
    exit 1
    ;;
esac
