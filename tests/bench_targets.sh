#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# The template in C on every target: how much faster than real time it runs at 500 us, on this machine, in this run.
# The best of three: the machine is shared. elf64 and pe64 run natively, and for comparison on the emulated CPU.
set -eu
cd "$(dirname "$0")/.."
build=${BUILD:-build}
tgm=${TGM:-$build/tgm}
seconds=4
case $build in /*) ;; *) build=$PWD/$build ;; esac

now() { date +%s%N; }

speed() { # TARGET MACHINE PROFILE FILE
    best=
    for round in 1 2 3; do
        begin=$(now)
        "$tgm" run "$4" --machine "$2" --profile "$3" --cycle 500 --for ${seconds}s >/dev/null
        took=$(($(now) - begin))
        [ -n "$best" ] && [ "$best" -le "$took" ] || best=$took
    done
    awk -v target="$1" -v machine="$2" -v s="$seconds" -v ns="$best" \
        'BEGIN { printf "  %-14s %-14s %10.1f\n", target, machine, s / (ns / 1e9) }'
}

printf 'template in C at 500 us, %s s of machine time, start included\n' "$seconds"
printf '  %-14s %-14s %10s\n' target machine 'simulated s / wall s'
for target in elf64 pe64 pe32 tgmmini tgmcontroller; do
    out=$build/targets_bench/$target
    make -s --no-print-directory -C templates/c TARGET=$target BUILD="$out" >/dev/null
    case $target in
    tgmmini) speed $target instrumented tgmmini "$out/shuttle.tgm" ;;
    tgmcontroller) speed $target instrumented tgmcontroller "$out/shuttle.tgm.bin" ;;
    pe32) speed $target instrumented pc4 "$out/shuttle.tgm" ;;
    *)
        speed $target native pc4 "$out/shuttle.tgm"
        speed $target instrumented pc4 "$out/shuttle.tgm"
        ;;
    esac
done
