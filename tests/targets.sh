#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# Modules of every target from the outside: judged, run, recorded; the layout on which 32 bits rely.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
tgm=$PWD/${BUILD:-build}/tgm
record='SERVO[0].Position,SERVO[0].WritePosition,SERVO[0].ControlWord'

# Only PLC_DATA and its functions depend on the width of pointers, and there everything is a word.
for table in sdk/layout/tgm*.tsv; do
    run awk -F '\t' 'NR > 1 && $1 !~ /^PLC_(DATA|IMPORT_FUNCTIONS)$/ && $5 != $6 {print; bad = 1}
        NR > 1 && $1 ~ /^PLC_(DATA|IMPORT_FUNCTIONS)$/ && $5 != 2 * $6 {print; bad = 1} END {exit bad}' "$table"
    expect "$table: memories are alike on 32 and 64 bits, PLC_DATA is half as large" 0
done

recorded() { # FILE PROFILE CSV [OPTION...]
    module=$1
    as_product=$2
    csv=$3
    shift 3
    run "$tgm" run "$module" --profile "$as_product" --for 1s --record "$record" --csv "$csv" "$@"
}

for target in pe64 pe32 tgmmini tgmcontroller; do
    file=$work/$target/shuttle.tgm
    profile=pc4
    as=
    case $target in
    tgm*) profile=$target as="TGM_PROFILE=$target" ;;
    esac
    [ $target != tgmcontroller ] || file=$file.bin
    run make -C templates/c TARGET=$target BUILD="$work/$target"
    expect "the template is built for $target" 0 "VERIFY"
    # shellcheck disable=SC2086
    run make -C templates/c BUILD="$work/elf64-$target" $as
    expect "and for elf64, as $profile" 0 "VERIFY"
    recorded "$work/elf64-$target/shuttle.tgm" $profile "$work/a.csv"
    expect "elf64 runs as $profile" 0
    recorded "$file" $profile "$work/b.csv"
    expect "$target runs" 0
    if cmp -s "$work/a.csv" "$work/b.csv"; then pass "$target: the same recording"; else fail "$target: the same recording"; fi
    if [ $target = pe64 ]; then
        recorded "$file" $profile "$work/c.csv" --machine instrumented
        expect "pe64 runs on the emulated CPU" 0 "PE x86-64, run on the emulated CPU"
        if cmp -s "$work/a.csv" "$work/c.csv"; then pass "the same there"; else fail "the same there"; fi
    else
        recorded "$file" $profile "$work/c.csv" --machine native
        expect "$target does not run natively" 2 "--machine native: "
    fi
    run "$tgm" check "$file" --profile $profile --cycles 100
    expect "$target is judged" 0 "RESULT: PASS" " 0 failed, "
done

run "$tgm" check "$work/tgmmini/shuttle.tgm" --profile pc4
expect "a profile says what it loads" 1 "ELF32 Arm; the profile pc4 loads" \
    "an ELF64 x86-64 shared object, a PE32+ DLL for x86-64 or a PE32 DLL for i386"
run "$tgm" run "$work/pe64/shuttle.tgm" --machine fast
expect "there are two machines" 2 "--machine must be native or instrumented, not 'fast'"

finish
