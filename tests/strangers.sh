#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# Masters of other people against `tgm bus`, over a pair of virtual cables in a network namespace that ends
# with this script: SOEM with its own Linux port, pysoem, ethercrab. Every capture then goes through tshark.
# What a machine cannot run is skipped, saying why. Nothing leaves the namespace but what pip and cargo
# fetch before it is entered.
set -u
cd "$(dirname "$0")/.."
build=${BUILD:-build}
strangers=$build/strangers
captures=$build/captures
tgm=$build/tgm

# --- outside: what has to be fetched or built ------------------------------------------------------

skip() {
    echo "SKIP strangers: $1"
}

prepare_soem() {
    ${MAKE:-make} --no-print-directory BUILD="$build" "$strangers/soem_walk" >"$strangers/soem-log" 2>&1
}

prepare_pysoem() {
    [ ! -e "$strangers/venv/.done" ] || [ tests/strangers/pysoem.txt -nt "$strangers/venv/.done" ] || return 0
    rm -rf "$strangers/venv"
    {
        python3 -m venv "$strangers/venv" &&
            timeout 300 "$strangers/venv/bin/pip" install --quiet --disable-pip-version-check --no-deps \
                --require-hashes -r tests/strangers/pysoem.txt &&
            touch "$strangers/venv/.done"
    } >"$strangers/pysoem-log" 2>&1
}

# The oldest cargo that the crates in Cargo.lock take.
cargo_is_new() {
    wanted=$(sed -n 's/^rust-version = "1\.\([0-9]*\).*/\1/p' tests/strangers/ethercrab/Cargo.toml)
    found=$(cargo --version 2>/dev/null | sed -n 's/^cargo 1\.\([0-9]*\).*/\1/p')
    [ -n "$found" ] && [ "$found" -ge "$wanted" ]
}

prepare_ethercrab() {
    timeout 900 cargo build --quiet --release --locked --manifest-path tests/strangers/ethercrab/Cargo.toml \
        --target-dir "$strangers/ethercrab" >"$strangers/ethercrab-log" 2>&1
}

if [ -z "${STRANGERS_INSIDE:-}" ]; then
    mkdir -p "$strangers" "$captures"
    [ -x "$tgm" ] || { echo "strangers: $tgm is not built" >&2; exit 2; }
    command -v ip >/dev/null 2>&1 || { skip "no ip command (Debian package iproute2)"; exit 0; }
    enter="unshare --net"
    [ "$(id -u)" = 0 ] || enter="unshare --user --map-root-user --net"
    if ! $enter sh -c 'ip link add tgm0 type veth peer name tgm1' 2>/dev/null; then
        skip "this machine lets nobody make a network namespace with a veth pair"
        exit 0
    fi
    STRANGERS_INSIDE=soem
    prepare_soem || { cat "$strangers/soem-log"; exit 1; }
    if prepare_pysoem; then
        STRANGERS_INSIDE="$STRANGERS_INSIDE pysoem"
    else
        skip "pysoem does not install: $(tail -n 1 "$strangers/pysoem-log")"
    fi
    if ! cargo_is_new; then
        skip "no cargo, or one older than 1.$wanted: no ethercrab"
    elif prepare_ethercrab; then
        STRANGERS_INSIDE="$STRANGERS_INSIDE ethercrab"
    else
        skip "ethercrab does not build: $(tail -n 1 "$strangers/ethercrab-log")"
    fi
    if command -v tshark >/dev/null 2>&1; then
        STRANGERS_INSIDE="$STRANGERS_INSIDE tshark"
    else
        skip "no tshark: captures are not looked at"
    fi
    export STRANGERS_INSIDE BUILD="$build"
    exec $enter sh "$0"
fi

# --- inside -----------------------------------------------------------------------------------------

. tests/lib.sh
bus=
trap 'stop_bus; rm -rf "$work"' EXIT
trap 'exit 1' INT TERM
: >"$err"

has() {
    case " $STRANGERS_INSIDE " in *" $1 "*) return 0 ;; esac
    return 1
}

# start_bus CAPTURE ARGUMENTS...: tgm bus on one end of the cable, listening
start_bus() {
    capture=$captures/$1.pcap
    rm -f "$capture"
    shift
    "$tgm" bus --interface tgm0 --for 120s --pcap "$capture" "$@" >"$work/bus" 2>&1 &
    bus=$!
    for _ in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20; do
        grep -q 'waiting for a master' "$work/bus" 2>/dev/null && return 0
        sleep 0.1
    done
    cat "$work/bus"
    return 1
}

stop_bus() {
    [ -z "$bus" ] || kill -INT "$bus" 2>/dev/null
    [ -z "$bus" ] || wait "$bus"
    status=$?
    bus=
    return $status
}

# stranger NAME COMMAND...: runs a master; its "N passed, M failed" counts, and so does an early end
stranger() {
    name=$1
    shift
    began=$(date +%s)
    run timeout -k 5 60 "$@"
    counts=$(sed -n 's/^\([0-9]*\) passed, \([0-9]*\) failed$/\1 \2/p' "$out" | tail -n 1)
    if [ -z "$counts" ]; then
        fail "$name (ended early, exit $status)"
    else
        passed=$((passed + ${counts% *}))
        failed=$((failed + ${counts#* }))
        [ "${counts#* }" = 0 ] || { echo "not ok  $name"; grep -a '^not ok' "$out"; tail -n 15 "$work/bus"; }
    fi
    stop_bus && grep -q ' answered, ' "$work/bus" && pass "$name: the bus ends when told" ||
        { cp "$work/bus" "$out"; fail "$name: the bus ends when told"; }
    echo "$name: ${counts:-0 1}  $(($(date +%s) - began)) s"
}

ip link add tgm0 type veth peer name tgm1 && ip link set tgm0 up && ip link set tgm1 up || exit 1
ip link add tgm2 type veth peer name tgm3 || exit 1
. tests/bus.sh

start_bus frames-by-hand --timing real drive-cia402 dio-8x8 && stranger "frames by hand" python3 tests/strangers/frames.py tgm1
rm -f "$captures/frames-by-hand.pcap" # malformed on purpose

# A bad day on the bus of a module, for the dissector: what comes back is still well-formed.
cat >"$work/day.faults" <<'EOT'
at 100ms lose 3 frames
at 150ms duplicate 2 frames
at 200ms delay frames by 50us for 10ms
at 250ms damage 5 frames after 1
at 300ms unplug after 1 for 50ms
at 600ms power cycle 2 for 20ms
at 900ms drive 1 fault 0x3210
at 1s drop 1 to SAFEOP code 0x001B
EOT
if [ -e "$build/template/shuttle.tgm" ]; then
    if "$tgm" run "$build/template/shuttle.tgm" --for 2s --faults "$work/day.faults" --pcap "$captures/faults.pcap" >"$out" 2>&1
    then pass "a capture of a bad day"; else fail "a capture of a bad day"; fi
fi

line="drive-cia402 dio-8x8 drive-cia402 dio-8x8"
# shellcheck disable=SC2086
start_bus walk-soem $line && stranger "SOEM over its own port" "$strangers/soem_walk" tgm1 $line
# shellcheck disable=SC2086
start_bus walk-soem-real --timing real $line &&
    stranger "SOEM, answers taking their time" "$strangers/soem_walk" tgm1 $line

if has pysoem; then
    # shellcheck disable=SC2086
    start_bus pysoem $line && stranger "pysoem" "$strangers/venv/bin/python" tests/strangers/pysoem_walk.py tgm1
fi

if has ethercrab; then
    for count in 1 4 16; do
        line=drive-cia402
        while [ "$(echo $line | wc -w)" -lt "$count" ]; do line="$line dio-8x8 drive-cia402 drive-cia402"; done
        # shellcheck disable=SC2086
        start_bus "ethercrab-$count" $line &&
            stranger "ethercrab, $count" "$strangers/ethercrab/release/ethercrab-walk" tgm1 $line
    done
fi

if has tshark; then
    . tests/dissect.sh
fi

finish
