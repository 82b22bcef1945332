#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# Modules for the 64-bit PC, of mingw, of the shape that Microsoft's tools make, and of Free Pascal: judged, run,
# and held against the same sources built for elf64, to the last bit.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
tgm=${BUILD:-build}/tgm
registers='SERVO[0].Position,SERVO[0].WritePosition,SERVO[0].WriteSpeed,SERVO[0].Status,SERVO[0].Control,SERVO[0].ControlWord'

# same NAME FILE FILE: byte for byte
same() {
    if cmp "$2" "$3" >"$out" 2>"$err" && [ -s "$2" ]; then pass "$1"; else fail "$1"; fi
}
have() { # COMMAND PACKAGE
    command -v "$1" >/dev/null 2>&1 && return
    echo "SKIP    no $1 (Debian: $2); nothing of it was tested"
    return 1
}

# msvc OUTPUT SOURCE...: as Visual Studio links a module, and nothing of its library
msvc() {
    output=$1
    shift
    mkdir -p "$output.d"
    for source; do
        clang --target=x86_64-pc-windows-msvc -std=c11 -O2 -g -gcodeview -ffreestanding -fno-stack-protector -fno-math-errno \
            -fno-builtin -Wall -Wextra -Werror -Isdk/include -DTGM_GENERATION=4 -c \
            -o "$output.d/$(basename "$source" .c).obj" "$source" || return 1
    done
    lld-link /DLL /NOENTRY /NODEFAULTLIB /Brepro /DEBUG /PDB:"$output.pdb" /DEF:sdk/link/pe64.def /OUT:"$output" "$output.d"/*.obj
}

run make -C templates/c BUILD="$work/elf64"
expect "the template for elf64" 0
run make -C templates/c TARGET=pe64 BUILD="$work/mingw"
expect "the template of mingw" 0
have fpc fp-compiler && {
    run make -C templates/pascal TARGET=pe64 BUILD="$work/pascal"
    expect "the template of Free Pascal" 0
}
have lld-link lld && {
    mkdir -p "$work/msvc"
    support=$(for name in mem text16 text8 number motion move start windows; do echo "sdk/src/$name.c"; done)
    # shellcheck disable=SC2086
    run msvc "$work/msvc/shuttle.tgm" templates/c/shuttle.c $support
    expect "the template of clang and lld-link" 0
}

record() { # NAME MODULE ARGUMENT...
    name=$1
    module=$2
    shift 2
    run "$tgm" run "$module" --record "$registers" --csv "$work/$name.csv" "$@"
}
record "reference" "$work/elf64/shuttle.tgm" --for 4s
record "reference-preempted" "$work/elf64/shuttle.tgm" --for 500ms --preempt seeded
record "reference-reloaded" "$work/elf64/shuttle.tgm" --for 3s --reload-at 1s
for kind in mingw msvc pascal; do
    module=$work/$kind/shuttle.tgm
    [ -e "$module" ] || continue
    run "$tgm" inspect "$module"
    expect "$kind: six exports and no import" 0 "PE x86-64" "exports       6" "imports       none" "initialisers  none"
    run "$tgm" check --scenario templates/project/acceptance.scenario "$module"
    expect "$kind: the verdict" 0 "RESULT: PASS" "0 not judged"
    record "$kind" "$module" --for 4s
    same "$kind: four seconds are those of elf64" "$work/$kind.csv" "$work/reference.csv"
    record "$kind-preempted" "$module" --for 500ms --preempt seeded
    [ "$kind" = pascal ] || expect "$kind: interrupted between its instructions" 0
    record "$kind-reloaded" "$module" --for 3s --reload-at 1s
    same "$kind: loaded again in between, too" "$work/$kind-reloaded.csv" "$work/reference-reloaded.csv"
    run "$tgm" run "$module" --for 500ms --in-process
    expect "$kind: in the program's own process" 0
done

# --- other generations --------------------------------------------------------------------------------
for id in 905 906; do
    run make -C templates/c TARGET=pe64 BUILD="$work/mingw-$id" TGM_GENERATION=5 TGM_MEMORY_ID=$id
    expect "the template of mingw for memory id $id" 0
    profile=$([ $id = 905 ] && echo pc500 || echo pc5)
    run "$tgm" check --profile $profile "$work/mingw-$id/shuttle.tgm"
    expect "its verdict" 0 "RESULT: PASS" "0 not judged" "profile=$profile"
done

# --- findings name lines ------------------------------------------------------------------------------
cat >"$work/sin.c" <<'END'
#define OWN_04
#include "conformance/fixtures/base.h"

static long *volatile nowhere;
static unsigned turns;

long Program_04(PLC_DATA *pData)
{
    (void)pData;
    nowhere = (long *)0;
    if (++turns > 0)
        *nowhere = 1;
    return 1;
}
END
mingw="x86_64-w64-mingw32-gcc -std=c11 -O2 -g -ffreestanding -fno-stack-protector -fno-builtin -I. -Isdk/include"
# shellcheck disable=SC2086
run $mingw -nostdlib -shared -Wl,-e,0 -Wl,--dynamicbase,--nxcompat -o "$work/sin.tgm" "$work/sin.c" sdk/src/mem.c sdk/link/pe64.def -lgcc
expect "a module with a fault" 0
run "$tgm" check --rule no-stray-write "$work/sin.tgm"
expect "the line of a fault" 1 "(Program_04)" "sin.c:12" "wrote"

finish
