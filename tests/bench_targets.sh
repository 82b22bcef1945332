#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# The template in C on every target: how much faster than real time it runs at 500 us, on this machine, in this run.
# The best of three, by the clock and by the processor time it took: the machine is shared. elf64 and pe64 run natively, and
# for comparison on the emulated CPU.
set -eu
cd "$(dirname "$0")/.."
build=${BUILD:-build}
tgm=${TGM:-$build/tgm}
seconds=20
case $build in /*) ;; *) build=$PWD/$build ;; esac

now() { date +%s%N; }

# Processor time of a command and of all that it starts, in seconds.
cpu() {
    sh -c '"$@" >/dev/null && times' sh "$@" |
        awk 'NR == 2 { gsub(/[ms]/, " "); print $1 * 60 + $2 + $3 * 60 + $4 }'
}

speed() { # TARGET MACHINE PROFILE FILE
    best= least=
    for round in 1 2 3; do
        begin=$(now)
        used=$(cpu "$tgm" run "$4" --machine "$2" --profile "$3" --cycle 500 --for ${seconds}s)
        took=$(($(now) - begin))
        [ -n "$best" ] && [ "$best" -le "$took" ] || best=$took
        least=$(printf '%s\n' $least "$used" | sort -g | head -n 1)
    done
    awk -v target="$1" -v machine="$2" -v s="$seconds" -v ns="$best" -v cpu="$least" \
        'BEGIN { printf "  %-14s %-14s %10.1f %10.1f\n", target, machine, s / (ns / 1e9), s / cpu }'
}

printf 'template in C at 500 us, %s s of machine time, start included\n' "$seconds"
printf '  %-14s %-14s %10s %10s\n' target machine 's / wall s' 's / CPU s'
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
