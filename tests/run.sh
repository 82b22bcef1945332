#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
#   tests/run.sh             every test, as `make test` runs it: builds with gcc, runs the unit tests, then the shell tests
#   tests/run.sh sanitizers  as `make test-sanitizers`: builds with clang, and with clang's address and undefined
#                            behaviour sanitizers, and runs the unit tests with those
#
# Prints what failed and, last, "N passed, M failed".
set -u
cd "$(dirname "$0")/.."
MAKE=${MAKE:-make}
jobs=$(nproc 2>/dev/null || echo 2)
passed=0
failed=0
log=build/test-log${1:+-$1}
mkdir -p build
: >"$log"

# "N passed, M failed" of what a step printed: of cmocka's programs and of the shell tests.
count() { # word of cmocka, word of the shell tests, file
    sed -n "s/^\\[  $1  \\] \\([0-9]*\\) test.*/\\1/p; s/^$2\$/\\1/p" "$3" | awk '{s += $1} END {print s + 0}'
}

# One line for a step that is over, and what it printed if it failed.
report() { # name, verdict, seconds, output
    n=$(count PASSED '\([0-9]*\) passed, [0-9]* failed' "$4")
    m=$(count FAILED '[0-9]* passed, \([0-9]*\) failed' "$4")
    cat "$4" >>"$log"
    [ "$2" = ok ] || [ "$m" -gt 0 ] || m=1
    passed=$((passed + n))
    failed=$((failed + m))
    printf '%-58s%s\n' "$1" "$2  $n passed, $m failed  $3 s"
    grep '^SKIP' "$4" || true
    [ "$2" = ok ] || grep -vE '^  (CC|AS|LINK|MODULE) |RUN  |   OK \]' "$4" | tail -n 60
}

step() { # name, command
    name=$1
    shift
    began=$(date +%s)
    if "$@" >build/step-log 2>&1; then verdict=ok; else verdict=FAILED; fi
    report "$name" "$verdict" $(($(date +%s) - began)) build/step-log
}

# Steps that do not touch what others of them need, as many at a time as there are processors: lines of a command
# and a name on standard input, the longest first.
steps() {
    rm -rf build/steps
    mkdir -p build/steps
    cat >build/steps/list
    awk '{print NR "\t" $0}' build/steps/list | tr '\n' '\0' | xargs -0 -P "$jobs" -I {} sh -c '
        number=${1%%"	"*}
        command=${1#*"	"}
        began=$(date +%s)
        verdict=ok
        sh -c "${command%%"	"*}" >build/steps/$number.out 2>&1 || verdict=FAILED
        echo "$verdict $(($(date +%s) - began))" >build/steps/$number.verdict' sh {}
    number=0
    while IFS='	' read -r command name; do
        number=$((number + 1))
        verdict='FAILED to run'
        seconds=0
        read -r verdict seconds <build/steps/$number.verdict
        report "$name" "$verdict" "$seconds" build/steps/$number.out
    done <build/steps/list
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

sanitizers() {
    san='-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer'
    step "build with clang" "$MAKE" -j"$jobs" BUILD=build/clang CC=clang all
    step "build with sanitizers" "$MAKE" -j"$jobs" BUILD=build/san CC=clang OPT='-O1 -g' CFLAGS="$san" all test-programs
    step "unit tests, clang, address and undefined sanitizers" units build/san
}

everything() {
    step "build with gcc" "$MAKE" -j"$jobs" all test-programs template-linked build/test/math_accuracy
    step "house rules" sh tests/lint.sh
    step "unit tests, gcc" units build
    step "tgm selftest: every rule proves itself" sh -c 'build/tgm selftest >build/selftest && echo "1 passed, 0 failed" || { cat build/selftest; false; }'
    steps <<'LIST'
sh tests/sdk.sh	SDK: what it refuses and how it says so
sh tests/fuzz.sh	readers of files, each with 20000 inputs
sh tests/pascal.sh	Pascal: template, layouts, what is refused
sh tests/sdk_support.sh	SDK: support library in real modules
sh tests/new.sh	tgm new: projects that pass untouched
sh tests/cli_check.sh	what may be asked of tgm check
sh tests/cli.sh	the program from the outside
sh tests/windows.sh	modules for the 64-bit PC, against elf64
sh tests/certify.sh	certificates: signing, verifying, tampering
sh tests/inspect.sh	what is inside a module: tgm inspect
sh tests/targets.sh	modules of every target: judged, run, recorded
build/test/math_accuracy 100000	SDK: mathematics against a high-precision reference
sh tests/reports.sh	reports in every form, against their schemas
sh tests/plot.sh	the oscilloscope, and recordings as pictures
LIST
    # What looks at the wall clock has the machine to itself.
    step "other people's masters on the simulated bus; captures" sh tests/strangers.sh
    step "clocks, interrupts, reloads, shared memory" sh tests/clock.sh
}

case ${1:-} in
sanitizers) sanitizers ;;
*) everything ;;
esac

echo
echo "$passed passed, $failed failed"
[ "$failed" = 0 ]
