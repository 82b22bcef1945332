# SPDX-License-Identifier: GPL-2.0-or-later
# bus.sh - `tgm bus` on an interface, from the outside; sourced by strangers.sh in its namespace.

run "$tgm" bus --interface tgm2 dio-8x8
expect "an interface that is down" 2 "tgm2 is down: ip link set tgm2 up"
ip link set tgm2 up
ip link set tgm3 up
if ip link add tgmbr type bridge 2>/dev/null && ip link set tgm3 master tgmbr 2>/dev/null; then
    run "$tgm" bus --interface tgm3 dio-8x8
    expect "a port of a bridge" 2 "tgm3 is a port of a bridge" "--on-a-real-network"
    run "$tgm" bus --interface tgm2 dio-8x8
    expect "a cable that ends in a bridge" 2 "the other end of tgm2 is a port of a bridge"
    run "$tgm" bus --interface tgmbr dio-8x8
    expect "a bridge" 2 "tgmbr (bridge) may lead to a real network"
    run "$tgm" bus --interface tgm2 --on-a-real-network --for 100ms dio-8x8
    expect "what was said is done" 0 "1 slave on tgm2"
    ip link set tgm3 nomaster
else
    echo "SKIP bus: this kernel makes no bridges"
fi
if setpriv --bounding-set -net_raw --inh-caps -net_raw true 2>/dev/null; then
    run setpriv --bounding-set -net_raw --inh-caps -net_raw "$tgm" bus --interface tgm2 dio-8x8
    expect "without the right to raw frames" 2 "CAP_NET_RAW"
fi

run "$tgm" bus --interface tgm2 --for 300ms drive-cia402 dio-8x8
expect "a bus that nobody asks anything" 0 "2 slaves on tgm2, waiting for a master" "0 frames, 0 answered, 0.3 s"
[ "$(wc -l <"$out")" = 2 ] && pass "says no more" || fail "says no more"
for signal in INT TERM; do
    start_bus "signal-$signal" dio-8x8
    kill "-$signal" "$bus"
    wait "$bus"
    status=$?
    bus=
    cp "$work/bus" "$out"
    expect "SIG$signal ends it well" 0 "0 frames, 0 answered"
done
"$tgm" bus --interface tgm2 --for 20s dio-8x8 >"$out" 2>"$err" &
bus=$!
sleep 0.5
ip link set tgm2 down
wait "$bus"
status=$?
bus=
expect "an interface that is taken down" 2 "tgm2 is gone or was taken down"
