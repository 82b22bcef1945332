#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# Every test, as `make test` runs it: builds with gcc, clang, and clang with sanitizers, runs the unit tests of the
# first and the last, then the shell tests. Prints what failed and, last, "N passed, M failed".
set -u
cd "$(dirname "$0")/.."
MAKE=${MAKE:-make}
jobs=$(nproc 2>/dev/null || echo 2)
passed=0
failed=0
log=build/test-log
mkdir -p build
: >"$log"

step() {
    printf '%-58s' "$1"
    shift
    began=$(date +%s)
    if "$@" >build/step-log 2>&1; then verdict=ok; else verdict=FAILED; fi
    cat build/step-log >>"$log"
    n=$(sed -n 's/^\[  PASSED  \] \([0-9]*\) test.*/\1/p; s/^\([0-9]*\) passed, [0-9]* failed$/\1/p' build/step-log | awk '{s += $1} END {print s + 0}')
    m=$(sed -n 's/^\[  FAILED  \] \([0-9]*\) test.*/\1/p; s/^[0-9]* passed, \([0-9]*\) failed$/\1/p' build/step-log | awk '{s += $1} END {print s + 0}')
    [ "$verdict" = ok ] || [ "$m" -gt 0 ] || m=1
    passed=$((passed + n))
    failed=$((failed + m))
    echo "$verdict  $n passed, $m failed  $(($(date +%s) - began)) s"
    grep '^SKIP' build/step-log || true
    [ "$verdict" = ok ] || grep -vE '^  (CC|AS|LINK|MODULE) |RUN  |   OK \]' build/step-log | tail -n 60
}

# Two programs at a time; what each prints stays together.
units() { # build folder
    ls "$1"/test/test_* 2>/dev/null | grep -v '\.d$' | xargs -P "$jobs" -I {} sh -c '
        "$1" >"$1.log" 2>&1 || touch "$1.failed"
        { echo "== $1"; cat "$1.log"; } >"$1.out"' sh {}
    cat "$1"/test/*.out
    status=0
    for mark in "$1"/test/*.failed; do
        [ ! -e "$mark" ] || status=1
    done
    rm -f "$1"/test/*.out "$1"/test/*.log "$1"/test/*.failed
    return $status
}

san='-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer'
step "build with gcc" "$MAKE" -j"$jobs" all test-programs template-linked build/test/math_accuracy
step "house rules" sh tests/lint.sh
step "unit tests, gcc" units build
step "build with clang" "$MAKE" -j"$jobs" BUILD=build/clang CC=clang all
step "build with sanitizers" "$MAKE" -j"$jobs" BUILD=build/san CC=clang OPT='-O1 -g' CFLAGS="$san" all test-programs
step "unit tests, clang, address and undefined sanitizers" units build/san
step "tgm selftest: every rule proves itself" sh -c 'build/tgm selftest >build/selftest && echo "1 passed, 0 failed" || { cat build/selftest; false; }'
step "SDK: what it refuses and how it says so" sh tests/sdk.sh
step "SDK: support library in real modules" sh tests/sdk_support.sh
step "SDK: mathematics against a high-precision reference" build/test/math_accuracy 100000
step "Pascal: template, layouts, what is refused" sh tests/pascal.sh
step "modules for the 64-bit PC, against elf64" sh tests/windows.sh
step "tgm new: projects that pass untouched" sh tests/new.sh
step "what is inside a module: tgm inspect" sh tests/inspect.sh
step "the program from the outside" sh tests/cli.sh
step "reports in every form, against their schemas" sh tests/reports.sh
step "modules of every target: judged, run, recorded" sh tests/targets.sh
step "certificates: signing, verifying, tampering" sh tests/certify.sh
step "readers of files, each with 20000 inputs" sh tests/fuzz.sh
step "clocks, interrupts, reloads, shared memory" sh tests/clock.sh
step "the oscilloscope, and recordings as pictures" sh tests/plot.sh
step "other people's masters on the simulated bus; captures" sh tests/strangers.sh

echo
echo "$passed passed, $failed failed"
[ "$failed" = 0 ]
