#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# Modules of every target from the outside: judged, run, recorded, drawn, under a scenario, certified; the layout on
# which 32 bits rely. BUILD names the tree.
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

scenario=templates/project/acceptance.scenario
run "$tgm" keygen "$work/plant"
expect "a pair of keys" 0

same() { # NAME FILE FILE
    if [ -s "$2" ] && cmp "$2" "$3" >"$out" 2>"$err"; then pass "$1"; else fail "$1"; fi
}

# What was said, seen and drawn, without how far it was when, and without the name of the file.
played() { # FILE PROFILE NAME
    run "$tgm" run "$1" --profile "$2" --scenario $scenario --record "$record" --csv "$work/$3.csv" --plot "$work/made.svg"
    expect "$3 plays the scenario" 0 "played to its end, " " 0 failed" "the drive breaks at"
    cat "$out" "$err" | sed '/run on the emulated CPU/d; / real time/d' >"$work/$3.said"
    sed 's/tgm\.bin/tgm/' "$work/made.svg" >"$work/$3.svg"
}

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
    # shellcheck disable=SC2086 # $as is one word or none
    run make -C templates/c BUILD="$work/elf64-$target" $as
    expect "and for elf64, as $profile" 0 "VERIFY"
    recorded "$work/elf64-$target/shuttle.tgm" $profile "$work/a.csv"
    expect "elf64 runs as $profile" 0
    recorded "$file" $profile "$work/b.csv"
    expect "$target runs" 0
    same "$target: the same recording" "$work/a.csv" "$work/b.csv"
    played "$work/elf64-$target/shuttle.tgm" $profile reference
    played "$file" $profile $target
    for kind in said csv svg; do
        same "$target: the same scenario, the same $kind" "$work/$target.$kind" "$work/reference.$kind"
    done
    if [ $target = pe64 ]; then
        recorded "$file" $profile "$work/c.csv" --machine instrumented
        expect "pe64 runs on the emulated CPU" 0 "PE x86-64, run on the emulated CPU"
        same "the same there" "$work/a.csv" "$work/c.csv"
    else
        recorded "$file" $profile "$work/c.csv" --machine native
        expect "$target does not run natively" 2 "--machine native: "
    fi
    run "$tgm" check "$file" --profile $profile --cycles 100 --scenario $scenario --evidence "$work/evidence-$target"
    expect "$target is judged" 0 "RESULT: PASS" " 0 failed, " "1 scenario, "
    tail -n 1 "$out" >"$work/verdict"
    run "$tgm" check --from-evidence "$work/evidence-$target"
    expect "$target is judged again by what was seen" 0
    tail -n 1 "$out" >"$work/again"
    same "$target: the same verdict" "$work/verdict" "$work/again"
    case $target in
    pe64 | tgmcontroller)
        run "$tgm" certify "$file" --profile $profile --key "$work/plant.key" -o "$work/cert" --evidence "$work/certified-$target"
        expect "$target is certified" 0 "RESULT: PASS" "signed for cert-1/$profile"
        run "$tgm" verify "$work/cert" "$file" --key "$work/plant.pub" --evidence "$work/certified-$target"
        expect "and its certificate verified" 0 "judged again: PASS"
        ;;
    esac
    run make -C templates/cpp TARGET=$target BUILD="$work/cpp-$target"
    expect "the template in C++ is built for $target" 0 "VERIFY"
    run make -C templates/cpp BUILD="$work/cpp-elf64-$target" $as
    expect "and for elf64" 0 "VERIFY"
    recorded "$work/cpp-elf64-$target/shuttle.tgm" $profile "$work/a.csv"
    recorded "$work/cpp-$target/${file##*/}" $profile "$work/b.csv"
    expect "C++ for $target runs" 0
    same "C++ for $target: the same recording" "$work/a.csv" "$work/b.csv"
done

# --- a new project's own configuration and scenario -------------------------------------------------------
run sh -c 'cd "$1" && "$2" new gantry && cd gantry && make TARGET=tgmcontroller check CHECK_FLAGS="--cycles 60"' sh "$work" "$tgm"
expect "a new project is judged for tgmcontroller" 0 "RESULT: PASS" "1 scenario, "

run "$tgm" check "$work/tgmmini/shuttle.tgm" --profile pc4
expect "a profile says what it loads" 1 "ELF32 Arm; the profile pc4 loads" \
    "an ELF64 x86-64 shared object, a PE32+ DLL for x86-64 or a PE32 DLL for i386"
run "$tgm" run "$work/pe64/shuttle.tgm" --machine fast
expect "there are two machines" 2 "--machine must be native or instrumented, not 'fast'"

finish
