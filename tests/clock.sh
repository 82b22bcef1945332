#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# tgm run on the wall clock, with interrupts, with a second start, and with other programs on its memories. Nothing here
# depends on how fast or how punctual the machine is. BUILD names the tree.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
build=${BUILD:-build}
tgm=$build/tgm
module=$build/template/shuttle.tgm
control=$build/host_modules/control_4.tgm
race=$build/host_modules/race_4.tgm
prefix=tgm-test-$$-
trap 'rm -rf "$work" /dev/shm/"$prefix"*' EXIT

# --- the wall clock -------------------------------------------------------------------------------
for cycle in 250 500 1000; do
    run "$tgm" run "$module" --for 400ms --cycle $cycle --clock real
    expect "real clock at $cycle us" 0 "shuttle 1.00 started" " of $((400000 / cycle))" " overruns, " " missed, " \
        " dropped" "empty loop" "slots"
    # An interrupted call of the last cycle is finished, in the cycles it takes.
    cycles=$(sed -n 's/.*real clock: \([0-9]*\) cycles,.*/\1/p' "$out")
    [ "${cycles:-0}" -ge $((400000 / cycle)) ] && pass "its cycles" || fail "$cycles cycles of $cycle us in 400 ms"
done
began=$(date +%s%N)
run "$tgm" run "$module" --for 1s --clock real
took=$((($(date +%s%N) - began) / 1000000))
[ "$took" -ge 1000 ] && pass "a second takes a second" || fail "a second took $took ms"
run "$tgm" run "$module" --for 1s --clock real --record MAIN.Servo_Tick,MAIN.Act_Timer_CycleTime,MAIN.ECAT_ElapsedTime,MAIN.Max_ECAT_ElapsedTime --csv "$work/real.csv"
expect "real clock with a recording" 0
script "$work/real.csv" <<'EOF'
import sys
rows = [line.split(",") for line in open(sys.argv[1]).read().split()[1:]]
assert [int(r[1]) for r in rows][:2000] == list(range(1, 2001)), "a tick a cycle"
assert any(int(r[2]) > 0 for r in rows), "measured periods"
assert any(int(r[3]) > 0 for r in rows), "measured bus"
assert int(rows[-1][4]) >= max(int(r[3]) for r in rows), "its maximum"
EOF
expect "every cycle is there, and measured" 0
run "$tgm" run "$build/fixtures/no-fault/bad.tgm" --clock real --for 200ms
expect "a fault on the real clock" 1 "Program_04 divided by zero"

# Program_01 that never returns: the rest goes on, and it is found out.
cat >"$work/endless.c" <<'EOF'
#include <tgm_plc.h>
long Program_Ini(PLC_DATA *p) { (void)p; return 1; }
long Program_01(PLC_DATA *p) { volatile long go = 1; (void)p; while (go) ; return 1; }
long Program_02(PLC_DATA *p) { (void)p; return 1; }
long Program_03(PLC_DATA *p) { (void)p; return 1; }
long Program_04(PLC_DATA *p) { (void)p; return 1; }
long Program_05(PLC_DATA *p) { (void)p; return 1; }
EOF
gcc -std=c11 -O1 -g -ffreestanding -fPIC -fvisibility=hidden -fshort-wchar -fno-stack-protector -Isdk/include -nostdlib \
    -shared -Wl,-Bsymbolic -Wl,-e,0 -Wl,-z,noexecstack -o "$work/endless.tgm" "$work/endless.c"
run "$tgm" run "$work/endless.tgm" --clock real --for 3s
expect "a function that never returns on the real clock" 1 "Program_01" "Program_01 at +0x" "by Program_05, Program_04"

# One that never stops sleeping, and one that does.
cat >"$work/sleeper.c" <<'EOF'
#include <tgm_plc.h>
static void nap(PLC_DATA *p, int64_t units) { TGM_LARGE_INTEGER t; t.QuadPart = units; p->functions.pSleepFt(&t); }
static int *count(PLC_DATA *p) { return p->PData_Memory; }
long Program_Ini(PLC_DATA *p) { nap(p, 200000); return 1; }
long Program_01(PLC_DATA *p) { for (;;) { nap(p, 50000); count(p)[0]++; } return 1; }
long Program_02(PLC_DATA *p) { nap(p, 50000); count(p)[1]++; return 1; }
long Program_03(PLC_DATA *p) { (void)p; return 1; }
long Program_04(PLC_DATA *p) { count(p)[2]++; return 1; }
long Program_05(PLC_DATA *p) { (void)p; return 1; }
EOF
gcc -std=c11 -O1 -g -ffreestanding -fPIC -fvisibility=hidden -fshort-wchar -fno-stack-protector -Isdk/include -nostdlib \
    -shared -Wl,-Bsymbolic -Wl,-e,0 -Wl,-z,noexecstack -o "$work/sleeper.tgm" "$work/sleeper.c"
for clock in virtual real; do
    run "$tgm" run "$work/sleeper.tgm" --clock $clock --for 2s --record DATA.I32[0],DATA.I32[4],DATA.I32[8] --csv "$work/s.csv"
    expect "sleep without end on the $clock clock" 1 "Program_01 did not return within a second, all of which it slept" pSleepFt
    # On the real clock a busy machine may drop a cycle; who waited for the sleeper would be called 200 times.
    script "$work/s.csv" $clock <<'EOF'
import sys
rows = [line.split(",") for line in open(sys.argv[1]).read().split()[1:]]
one, two, four = (int(n) for n in rows[-1][1:])
assert four == 4000 if sys.argv[2] == "virtual" else 2000 <= four <= 4000, "nobody waits for who sleeps: %d" % four
assert 1 <= one <= 200 and 1 <= two <= 400, (one, two)
EOF
    expect "who sleeps wakes again, on the $clock clock" 0
done

# --- interrupts -----------------------------------------------------------------------------------
run "$tgm" run "$race" --for 1s --preempt seeded
expect "seeded interrupts" 0 "calls were interrupted; the first:" "Program_03 at +0x" " by Program_05"
run "$tgm" run "$race" --for 100ms --preempt at=3
expect "interrupts at an instruction" 0 "after 3 instructions by Program_05, Program_04"
run "$tgm" run "$race" --for 100ms
lacks "run to completion" "interrupted"
for seed in 1 1 2; do
    run "$tgm" run "$module" --for 1s --preempt seeded --seed $seed --record DATA.F64[16] --csv "$work/$seed.csv"
    grep -A99 interrupted "$out" >"$work/now.$seed"
    if [ -e "$work/seen.$seed" ]; then
        cmp -s "$work/seen.$seed" "$work/now.$seed" && pass "the same seed interrupts alike" || fail "the same seed"
    fi
    cp "$work/now.$seed" "$work/seen.$seed"
done
cmp -s "$work/seen.1" "$work/seen.2" && fail "another seed interrupts alike" || pass "another seed interrupts elsewhere"
run "$tgm" run "$module" --preempt sometimes
expect "no such way to interrupt" 2 "--preempt must be seeded, or at=N"
run "$tgm" run "$module" --preempt seeded --clock real
expect "interrupts on the real clock are its own" 2 "--preempt is for the virtual clock"
run "$tgm" run "$module" --clock wall
expect "no such clock" 2 "--clock must be virtual or real"

# --- a second start -------------------------------------------------------------------------------
run "$tgm" run "$module" --for 2s --reload-at 1s
expect "a reload" 0 "shuttle 1.00 started" "cycle 4000 of 4000"
[ "$(grep -c "shuttle 1.00 started" "$out")" = 2 ] && pass "Program_Ini was called twice" || fail "Program_Ini twice"
run "$tgm" run "$module" --for 1s --reload-at 500ms --clock real
expect "a reload on the real clock" 0 "shuttle 1.00 started"
[ "$(grep -c "shuttle 1.00 started" "$out")" = 2 ] && pass "twice on the real clock" || fail "twice on the real clock"

# --- other programs on the memories ---------------------------------------------------------------
cat >"$work/watch.py" <<'EOF'
"""Watches and writes the shared memories of a run: watch.py PREFIX WHAT"""
import mmap, os, struct, sys, time

def memory(name):
    path = "/dev/shm/" + sys.argv[1] + name
    end = time.time() + 20
    while not os.path.exists(path) or os.path.getsize(path) == 0:
        assert time.time() < end, path
        time.sleep(0.01)
    assert os.stat(path).st_mode & 0o777 == 0o600, "only its owner"
    with open(path, "r+b") as f:
        return mmap.mmap(f.fileno(), 0)

def wait(what, ready):
    end = time.time() + 20
    while not ready():
        assert time.time() < end, what
        time.sleep(0.01)

system, cam = memory("TGM_System"), memory("TGM_Cam_Profile")
tick = lambda: struct.unpack_from("<I", system, 1216)[0]
starts = lambda: struct.unpack_from("<I", cam, 0)[0]
wait("Servo_Tick rises", lambda: tick() > 10)
wait("the module has started", lambda: starts() == 1)
if sys.argv[2] == "run":          # MAIN.PLC_Ctrl: load
    struct.pack_into("<I", system, 156, 1)
    wait("it starts again", lambda: starts() == 2)
if sys.argv[2] == "fault":        # the module sees what is written
    struct.pack_into("<I", cam, 8, 1)
if sys.argv[2] == "leave":        # MAIN.TGM_TgMotionCmd: exit
    struct.pack_into("<I", system, 132, 0x4C4C494B)
EOF
beside() { # WHAT SECONDS: a run with the watcher beside it
    python3 "$work/watch.py" "$prefix" "$1" >"$work/watch" 2>&1 &
    watcher=$!
    run "$tgm" run "$control" --for "$2" --clock real --shm-prefix "$prefix"
    wait $watcher || { cat "$work/watch"; fail "watcher: $1"; }
    ls /dev/shm/"$prefix"* >/dev/null 2>&1 && fail "memories left behind: $1" || pass "no memory is left: $1"
}
beside run 3s
expect "another program runs the PLC" 0
beside fault 3s
expect "the module sees what another program writes" 1 "Program_04 read through a null pointer"
beside leave 60s
expect "another program ends TG Motion" 0

"$tgm" run "$control" --for 60s --clock real --shm-prefix "$prefix" >"$work/first" 2>&1 &
first=$!
python3 "$work/watch.py" "$prefix" see
run "$tgm" run "$control" --for 100ms --shm-prefix "$prefix"
expect "memories that somebody else has" 2 "TGM_System" "--shm-prefix"
run "$tgm" run "$control" --for 100ms --shm-prefix "${prefix}b-"
expect "two at once with a prefix" 0
kill -INT $first
status=0
wait $first || status=$?
cp "$work/first" "$out"
expect "an interrupt from the keyboard ends the run in good order" 0 "real clock: "
ls /dev/shm/"$prefix"* >/dev/null 2>&1 && fail "memories left after an interrupt" || pass "none left after an interrupt"

"$tgm" run "$control" --for 60s --clock real --shm-prefix "$prefix" >"$work/first" 2>&1 &
first=$!
python3 "$work/watch.py" "$prefix" see
kill -KILL $first
wait $first 2>/dev/null
ls /dev/shm/"$prefix"TGM_System >/dev/null 2>&1 && pass "a killed run leaves its memories" || fail "nothing left"
run "$tgm" run "$control" --for 100ms --shm-prefix "$prefix"
expect "what a killed run left is replaced" 0
ls /dev/shm/"$prefix"* >/dev/null 2>&1 && fail "left again" || pass "and taken away"
run "$tgm" run "$control" --shm-prefix a/b
expect "a prefix with a slash" 2 "--shm-prefix must be"
run "$tgm" run "$control" --shm --in-process
expect "no shared memory without a worker" 2 "--in-process has no"

finish
