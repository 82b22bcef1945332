#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# fuzz.sh [READER...] - the fuzzers of everything that reads what strangers have written, each with so many inputs:
# first its seeds (tests/corpus/READER: what a crash was found with is one), then FUZZ_RUNS of its own making, always the
# same (20000 unless set; `FUZZ_RUNS=10000000 tests/fuzz.sh config` is a long run). What breaks one is left in build/fuzz.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
fuzz=build/fuzz
runs=${FUZZ_RUNS:-20000}
# Where the time went otherwise: backtraces of allocations, and memory that is kept from being used again.
export ASAN_OPTIONS=malloc_context_size=0:quarantine_size_mb=1:max_malloc_fill_size=0

# reader NAME PROGRAM LONGEST SEEDS
reader() {
    mkdir -p "$work/$1"
    words=
    [ ! -e "tests/corpus/$1.dict" ] || words="-dict=tests/corpus/$1.dict"
    FUZZ_FORMAT=$1 run "$fuzz/$2" -runs="$runs" -seed=1 -entropic=0 -max_len="$3" -timeout=600 $words \
        -artifact_prefix="$fuzz/$1-" "$work/$1" $4
    expect "$1: $runs inputs" 0 "Done "
    [ "$runs" -le 20000 ] || tail -n 3 "$err"
}

one() {
    case $1 in
    elf | pe | flat) reader "$1" fuzz_image 16384 "$(ls -d build/modules 2>/dev/null)" ;;
    config) reader config fuzz_config 400 tests/corpus/config ;;
    scenario) reader scenario fuzz_scenario 384 tests/corpus/scenario ;;
    evidence) reader evidence fuzz_evidence 512 tests/corpus/evidence ;;
    manifest) reader manifest fuzz_manifest 900 tests/corpus/manifest ;;
    certificate) reader certificate fuzz_certificate 1400 tests/corpus/certificate ;;
    *) fail "there is no reader $1" ;;
    esac
}

: >"$out"
if ! ${MAKE:-make} --no-print-directory -j"$(nproc 2>/dev/null || echo 2)" $fuzz/fuzz_image $fuzz/fuzz_config \
    $fuzz/fuzz_scenario $fuzz/fuzz_evidence $fuzz/fuzz_manifest $fuzz/fuzz_certificate >"$out" 2>"$err"; then
    fail "the fuzzers are built"
    finish
    exit
fi
[ $# -gt 0 ] || set -- elf pe flat config scenario evidence manifest certificate
for name; do one "$name"; done
finish
