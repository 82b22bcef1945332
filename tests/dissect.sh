# SPDX-License-Identifier: GPL-2.0-or-later
# dissect.sh - tshark over every capture that tests made; sourced by strangers.sh.

# fields CAPTURE FILTER FIELD...: the fields of all frames that match, tab between, one frame a line
fields() {
    file=$captures/$1.pcap
    filter=$2
    shift 2
    tshark -r "$file" -Y "$filter" -T fields $(printf -- ' -e %s' "$@") 2>>"$err"
}

for capture in "$captures"/*.pcap; do
    name=${capture##*/}
    tshark -r "$capture" -Y '_ws.malformed || _ws.expert.severity == error' >"$out" 2>"$err" ||
        fail "tshark reads $name"
    if [ -s "$out" ]; then fail "no malformed frame in $name"; else pass "no malformed frame in $name"; fi
    tshark -r "$capture" -Y '!ecat' >"$out" 2>"$err"
    if [ -s "$out" ]; then fail "all of $name is EtherCAT"; else pass "all of $name is EtherCAT"; fi
done

# has_frame CAPTURE TEXT FILTER: at least one frame
has_frame() {
    fields "$1" "$3" frame.number >"$out"
    if [ -s "$out" ]; then pass "$1: $2"; else fail "$1: $2"; fi
}

for capture in mailbox walk-soem; do
    [ -e "$captures/$capture.pcap" ] || continue
    has_frame $capture "identity or name is asked for" 'ecat_mailbox.coe.sdoidx == 0x1008 || ecat_mailbox.coe.sdoidx == 0x1018'
    has_frame $capture "uploads in segments" 'ecat_mailbox.coe.sdoreq == 3'
    has_frame $capture "complete access" 'ecat_mailbox.coe.sdoccsid.complete == 1'
    has_frame $capture "object lists" 'ecat_mailbox.coe.sdoinfoopcode == 2'
    has_frame $capture "object descriptions" 'ecat_mailbox.coe.sdoinfoopcode == 4'
    has_frame $capture "entry descriptions" 'ecat_mailbox.coe.sdoinfoopcode == 6'
    has_frame $capture "aborts" 'ecat_mailbox.coe.abortcode'
done
has_frame mailbox "downloads in segments" 'ecat_mailbox.coe.sdoreq == 0'

# The first frame of SOEM, sent and come back: both slaves have written.
fields soem 'frame.number <= 2' ecat.cmd ecat.adp ecat.ado ecat.cnt eth.src >"$out"
printf '0x08\t0x0000\t0x0103\t0\t01:01:01:01:01:01\n0x08\t0x0002\t0x0103\t2\t03:01:01:01:01:01\n' >"$work/want"
cmp -s "$out" "$work/want" && pass "soem: command, address and counter as sent" ||
    fail "soem: command, address and counter as sent"
# Process data: the logical command goes out with counter 0 and comes back with 2 * outputs + inputs; the clock
# is read at the first drive and written to nobody.
fields soem 'ecat.cmd == 12 && frame.number > 500' ecat.cmd ecat.cnt | sort -u >"$out"
printf '0x0c,0x0e\t0,0\n0x0c,0x0e\t6,1\n' >"$work/want"
cmp -s "$out" "$work/want" && pass "soem: working counters of process data" ||
    fail "soem: working counters of process data"
