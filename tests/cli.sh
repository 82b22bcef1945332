#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# The program as a user meets it: verdicts, bad input, wrong calls, hostile modules. BUILD names the tree.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
build=${BUILD:-build}
tgm=$build/tgm
module=$build/template/shuttle.tgm
fixtures=$build/fixtures

# --- a module that conforms -----------------------------------------------------------------------
run "$tgm" check "$module" --json "$work/report.json"
expect "the template passes" 0 "profile pc4 (TG Motion 4.21, ids 4033/904)"
last_line "the last line is the verdict" "^RESULT: PASS ([0-9]* passed, 0 failed, 0 not judged) profile=pc4 seed=0x1d2f sha256=[0-9a-f]\{64\}$"
lacks "no colours on a pipe" "$(printf '\033')"
script "$work/report.json" "$module" <<'EOF'
import hashlib, json, sys
r = json.load(open(sys.argv[1]))
assert r["schema"] == "tgm-check/1" and r["tool"].startswith("tgm "), r
assert r["module"]["path"] == sys.argv[2]
assert r["module"]["sha256"] == hashlib.sha256(open(sys.argv[2], "rb").read()).hexdigest()
assert (r["module"]["format"], r["module"]["target"]) == ("ELF64", "x86-64")
assert (r["profile"], r["seed"], r["verdict"]) == ("pc4", "0x1d2f", "PASS")
assert r["counts"] == {"passed": len(r["rules"]), "failed": 0, "not_judged": 0, "noted": 0, "waived": 0}, r["counts"]
for rule in r["rules"]:
    assert rule["severity"] in ("must", "should", "note") and rule["outcome"] == "pass" and rule["findings"] == [], rule
EOF
expect "the JSON report follows tgm-check/1" 0

run "$tgm" check "$fixtures/no-fault/bad.tgm" --cycles 60 --json -
cp "$out" "$work/stdout.json"
run python3 -c '
import json, sys
r = json.load(open(sys.argv[1]))
f = [x for x in r["rules"] if x["outcome"] == "fail"]
assert r["verdict"] == "FAIL" and [x["id"] for x in f] == ["no-fault"], f
one = f[0]["findings"][0]
assert one["function"] == "Program_04" and one["cycle"] == 19 and one["count"] == 3, one
assert "no-fault/bad.c:" in one["place"] and "--rule no-fault" in one["again"], one
' "$work/stdout.json"
expect "--json - gives JSON alone on standard output" 0

run "$tgm" check "$fixtures/no-fault/bad.tgm" --cycles 60
expect "a finding names function, cycle, place, clause, advice and how to see it again" 1 \
    "FAIL  no-fault" "manual: Functions PLC" "Program_04 divided by zero" "in cycle 19 at Cycle_Time 250 us" \
    "bad.tgm+0x" "(Program_04)" "no-fault/bad.c:" "again: tgm check" "more:  tgm explain no-fault"
again=$(sed -n 's/.*again: tgm //p' "$out")
# shellcheck disable=SC2086
run "$tgm" $again
expect "the reproduction line reproduces" 1 "Program_04 divided by zero"

# --- files that are no modules --------------------------------------------------------------------
for case in "$work/missing:No such file" "$work:is a directory"; do
    run "$tgm" check "${case%%:*}"
    expect "no file: ${case#*:}" 2 "${case#*:}"
    [ "$(cat "$out" "$err" | wc -l)" = 1 ] && pass "in one line" || fail "in one line"
done
mkfifo "$work/fifo"
run timeout 5 "$tgm" check "$work/fifo"
expect "a pipe is refused, not waited for" 2 "fifo"
if [ "$(id -u)" != 0 ]; then
    cp "$module" "$work/secret" && chmod 000 "$work/secret"
    run "$tgm" check "$work/secret"
    expect "an unreadable file" 2 "ermission"
fi

no_module() { # name file text
    run "$tgm" check "$2" --cycles 20
    expect "no module: $1" 1 "file-format" "$3"
    last_line "no module: $1: FAIL" "^RESULT: FAIL"
}
: >"$work/empty"
no_module "empty file" "$work/empty" "empty"
echo "This is a letter, not a machine." >"$work/letter"
no_module "text" "$work/letter" "text"
dd if=/dev/urandom of="$work/noise" bs=1024 count=64 2>/dev/null
no_module "random bytes" "$work/noise" "FAIL"
no_module "an object file" "$fixtures/file-format/bad.tgm" "link it first"
no_module "another architecture" "$build/modules/six_i386.so" "i386"
run "$tgm" check "$build/modules/six.dll" --cycles 20
expect "a Windows module without its functions" 1 "FAIL  export-names" "Program_04 is missing"
last_line "a Windows module without its functions: FAIL" "^RESULT: FAIL"
no_module "a program" /bin/true "FAIL"
python3 - "$module" "$work/core" <<'EOF'
import sys
b = bytearray(open(sys.argv[1], "rb").read())
b[16] = 4 # e_type ET_CORE
open(sys.argv[2], "wb").write(b)
EOF
no_module "a core file" "$work/core" "core"

size=$(wc -c <"$module")
crashed=0
tried=0
at=0
while [ "$at" -lt "$size" ]; do
    head -c "$at" "$module" >"$work/cut"
    run "$tgm" check "$work/cut" --cycles 5
    case $status in 0 | 1 | 3) ;; *) crashed=$((crashed + 1)) ;; esac
    tried=$((tried + 1))
    at=$((at + 397))
done
[ "$crashed" = 0 ] && pass "truncated at $tried places" || fail "truncated at $tried places: $crashed ended the harness"

# --- wrong calls ----------------------------------------------------------------------------------
run "$tgm"
expect "no command" 2 "tgm check"
run "$tgm" chekc
expect "unknown command" 2 "did you mean check?"
run "$tgm" frobnicate
expect "unknown command, nothing near" 2 "allowed: check run"
run "$tgm" check --profle pc4 "$module"
expect "unknown option" 2 "unknown option --profle (did you mean --profile?)"
run "$tgm" check --zzz "$module"
expect "unknown option, nothing near" 2 "allowed: --profile"
run "$tgm" check
expect "no module named" 2 "which module?"
run "$tgm" check a b
expect "two modules" 2 "unexpected 'b'"
run "$tgm" check --profile pc9 "$module"
expect "unknown profile" 2 "allowed: pc4"
run "$tgm" check --rule 'nothing*' "$module"
expect "no such rule" 2 "no rule matches"
run "$tgm" check --seed twelve "$module"
expect "no number" 2 "--seed needs a number"
run "$tgm" check --cycles 0 "$module"
expect "number out of range" 2 "--cycles must be 1 to"
run "$tgm" check --json "$work/no/such/dir.json" "$module"
expect "unwritable report" 2 "cannot write"
cp "$module" "$work/self.tgm"
run "$tgm" check --json "$work/self.tgm" "$work/self.tgm"
expect "a report over the module itself" 2 "is the module itself"
run "$tgm" run --record 'SERVO[0].Position' --csv "$work/self.tgm" "$work/self.tgm"
expect "a recording over the module itself" 2 "is the module itself"
cmp -s "$module" "$work/self.tgm" && pass "and the module is as it was" || fail "and the module is as it was"
run "$tgm" run --record 'SERVO[0].Position,' --csv "$work/x.csv" "$module"
expect "a register list that ends in a comma" 2 "--record needs register names"
status=0
"$tgm" rules >/dev/full 2>"$err" || status=$?
expect "output that cannot be written" 2 "cannot write to standard output"
status=0
"$tgm" run "$module" --for 50ms --record 'SERVO[0].Position' --csv "$work/closed.csv" >&- 2>"$err" || status=$?
head -n 1 "$work/closed.csv" | grep -qxF 'time_s,SERVO[0].Position' && pass "a closed standard output spoils no recording" ||
    fail "a closed standard output spoils no recording"
evil="$work/a
RESULT: PASS (19 passed, 0 failed, 0 not judged)"
cp "$fixtures/no-fault/bad.tgm" "$evil"
run "$tgm" check "$evil" --cycles 30
[ "$(grep -c '^RESULT: ' "$out")" = 1 ] && pass "a file name cannot forge a verdict" || fail "a file name cannot forge a verdict"
run "$tgm" check "$module" --rule no-tls --cycles 7
last_line "the verdict says what was left out" "rules=no-tls cycles=7 seed="
run "$tgm" run --cycle 300 "$module"
expect "no such Cycle_Time" 2 "250, 500 or 1000"
run "$tgm" run --record 'SERVO[0].position' --csv "$work/x.csv" "$module"
expect "no such register" 2 "did you mean Position?"
[ ! -e "$work/x.csv" ] && pass "a wrong call leaves no file" || fail "a wrong call leaves no file"
run "$tgm" run --record 'SERVO[0].Position' "$module"
expect "--record without --csv" 2 "go together"
run "$tgm" run --for 10 "$module"
expect "time without unit" 2 "2s, 500ms or 250us"
run "$tgm" explain no-falt
expect "no such rule to explain" 2 "did you mean no-fault?"
run "$tgm" explain no-fault
expect "explain" 0 "No function faults"
run "$tgm" rules
expect "rules" 0 "export-names" "no-stray-write"
run "$tgm" registers writepos
expect "registers by a part of the name" 0 "SERVO[n].WritePosition" "464" "inc"
run "$tgm" registers TGM_Servo+2520
expect "registers by offset, in any element" 0 "SERVO[n].Position" "472"
run "$tgm" registers nothing-like-it
expect "no such register to list" 2 "TGM_Servo+472"
run "$tgm" device
expect "device types are listed" 0 "ek1100" "strain gauge" "drive-cia402"
run "$tgm" device tests/devices/pressure.device tests/devices/example.xml
expect "device files and ESI are described" 0 "pressure sensor with a valve" "40 bits, 2 channels" "XA-1"
printf 'device "a" "b"\nvendr 1\n' >"$work/bad.device"
run "$tgm" device "$work/bad.device"
expect "a damaged device file" 1 "bad.device:2:1: unknown word \"vendr\" (did you mean \"vendor\"?)"
run "$tgm" device --convert 'tests/devices/example.xml#XA-1' --to "$work/xa.device"
expect "ESI becomes a device file" 0
run "$tgm" device "$work/xa.device"
expect "which describes the same" 0 "XA-1" "0x00E20001" "11 objects"
run "$tgm" check --help
expect "help" 0 "--json FILE"

# --- hostile modules ------------------------------------------------------------------------------
hostile() { # name file text
    run timeout 600 "$tgm" check "$2" --cycles 60
    expect "hostile: $1" 1 "$3"
    last_line "hostile: $1: FAIL" "^RESULT: FAIL"
    if pgrep -f "$2" >/dev/null; then fail "hostile: $1: a process is left"; else pass "hostile: $1: nothing is left"; fi
}
hostile "kills its parent" "$fixtures/no-system-call/bad.tgm" "system call 110"
hostile "claims PASS and exits" "$fixtures/no-system-call/bad-exit.tgm" "system call 1)"
lacks "the claim is not printed" "(19 passed, 0 failed, 0 not judged)"
hostile "never returns" "$fixtures/returns/bad.tgm" "did not return"

# --- run ------------------------------------------------------------------------------------------
names='SERVO[0].Position,SERVO[0].WritePosition'
run "$tgm" run "$module" --for 2s --record "$names" --csv "$work/a.csv"
expect "run" 0 "shuttle 1.00 started" "cycle 4000 of 4000"
run "$tgm" run "$module" --for 2s --record "$names" --csv "$work/b.csv"
cmp -s "$work/a.csv" "$work/b.csv" && pass "equal seeds give equal recordings" || fail "equal seeds give equal recordings"
run "$tgm" run "$module" --for 2s --record "$names" --csv "$work/c.csv" --seed 7
cmp -s "$work/a.csv" "$work/c.csv" && fail "another seed gives another recording" || pass "another seed gives another recording"
[ "$(wc -l <"$work/a.csv")" = 4001 ] && pass "one row a cycle" || fail "one row a cycle"
head -n 1 "$work/a.csv" | grep -qxF "time_s,$names" && pass "the recording names its columns" || fail "the recording names its columns"
for cycle in 250 1000; do
    run "$tgm" run "$module" --for 1s --cycle $cycle
    expect "run at $cycle us" 0 "cycle $((1000000 / cycle)) of"
done
script "$tgm" "$module" <<'EOF'
import subprocess, sys
# The carriage must have homed and travelled between 1 and 6 revolutions from the home switch.
rows = subprocess.run([sys.argv[1], "run", sys.argv[2], "--for", "10s", "--record",
                       "DATA.U32[4],DATA.F64[16],DATA.U32[8],DIO[0].In0,DIO[0].Out0,SERVO[0].PositionError", "--csv", "-"],
                      capture_output=True, text=True, check=True).stdout.splitlines()[1:]
rows = [[float(x) for x in r.split(",")] for r in rows]
moving = [r for r in rows if r[1] == 4]
assert len(moving) > 10000, len(moving)
positions = [r[2] for r in moving]
assert 0.9 < min(positions) < 1.1 and 5.9 < max(positions) < 6.1, (min(positions), max(positions))
assert rows[-1][3] >= 5, rows[-1]
assert all(b[5] == a[4] for a, b in zip(moving, moving[1:]) if a[4] == b[4]), "output 0 does not follow input 0"
assert {r[4] for r in moving} == {0.0, 1.0}, "input 0 never changed"
assert max(abs(r[6]) for r in moving) < 1048576 * 0.2, max(abs(r[6]) for r in moving)
EOF
expect "the template's machine homes, shuttles and mirrors its input" 0
run "$tgm" run "$fixtures/no-fault/bad.tgm"
expect "run tells of a fault" 1 "Program_04 divided by zero" "no-fault/bad.c:"
run "$tgm" run "$fixtures/ini-returns-one/bad.tgm"
expect "run tells of a refused start" 1 "Program_Ini returned 0: the start is aborted"
run "$tgm" run "$work/letter"
expect "run of no module" 1 "text"

# --- bus files ------------------------------------------------------------------------------------
printf 'drive-cia402\nek1100\ndi-8 input 0 square 400ms phase 100ms\ndo-16\ndrive-ideal\nring\n' >"$work/line.bus"
run "$tgm" run "$module" --for 200ms --bus "$work/line.bus" --record 'MAIN.Number_Servos,MAIN.Number_Dios,SERVO[1].EtherCATState' --csv "$work/line.csv"
expect "run --bus" 0 "bus OP" "SERVO[1]"
tail -n 1 "$work/line.csv" >"$out"
: >"$err"
status=0
expect "as many servos and terminals as the file has" 0 "0.199500,2,2,8"
printf 'drive-cia402\ndrive-cia42\n' >"$work/line.bus"
run "$tgm" run "$module" --bus "$work/line.bus"
expect "a bus file with a mistake" 2 "line.bus:2:1: no device type \"drive-cia42\""

# --- a path for an interpolator -------------------------------------------------------------------
printf 'line X 10 F 6000\nm 1005\nline X 10 Y 5\n' >"$work/good.path"
run "$tgm" run "$module" --for 1s --path "$work/good.path" --path-start 100ms \
    --record "INTERPOLATOR[0].Position[0],INTERPOLATOR[0].Position[1],INTERPOLATOR[0].Last_ContMFunc,INTERPOLATOR[0].Status" \
    --csv "$work/path.csv"
expect "a path runs" 0 "bus OP"
grep -q "^0.099500,0,0,0,4$" "$work/path.csv" && pass "not before its time" || fail "not before its time"
[ "$(tail -1 "$work/path.csv")" = "0.999500,10,5,1005,3" ] && pass "to its end" || fail "to its end: $(tail -1 "$work/path.csv")"
printf 'line X 10 F 6000\nline X ten\n' >"$work/bad.path"
run "$tgm" run "$module" --path "$work/bad.path"
expect "a path with a fault is refused with a place" 2 "bad.path:2:8: unexpected 'ten'; expected a number"
{ echo 'corner 5'; i=0; while [ $i -lt 2001 ]; do echo "line X $i F 60"; i=$((i + 1)); done; } >"$work/long.path"
run "$tgm" run "$module" --path "$work/long.path"
expect "a path that is longer than the buffer is refused" 2 "the path has 2001 parts, the buffer of interpolator 0 takes 2000"
run "$tgm" run "$module" --path "$work/none.path"
expect "a path that is not there" 2 "none.path': No such file"
# --- configuration files --------------------------------------------------------------------------
mkdir "$work/machine"
printf '[System]\nCycle_Time=1000\n[Servo_Configuration]\nServo[00].Type=9\nServo[00].Node=7\nServo[00].Resolution=16\nServo[01].Type=0\n[Memory]\nData_Bytes=65536\n[Simulation]\nFaults=bad.faults\n' >"$work/machine/TGMotion4xx.ini"
printf 'at 20ms unplug after 1 for 10ms\n' >"$work/machine/bad.faults"
run "$tgm" config "$work/machine/TGMotion4xx.ini"
expect "tgm config says what a file means" 0 "for TG Motion 4.21" "Cycle_Time       1000 us" "type 9, node 7, axis 1: tgz-1" \
    "virtual" "bus              tgz-1 dio-8x8" "65536 bytes" "$work/machine/bad.faults"
run "$tgm" config --profile tgmcontroller "$work/machine/TGMotion4xx.ini"
expect "of another product, too" 0 "for TGMcontroller" "as fast as possible"
run "$tgm" run "$module" --config "$work/machine/TGMotion4xx.ini" --for 100ms --csv "$work/config.csv" \
    --record 'MAIN.Servo_SetCycleTime,SERVO[0].Resolution,SERVO[0].Node,MAIN.Number_Servos,HEADER.Mem_Size_Data,SERVO[1].EtherCATState'
expect "run --config" 0 "bus fault    unplug"
[ "$(tail -1 "$work/config.csv")" = 0.099000,1000,65536,7,2,65536,8 ] && pass "everything is as configured" || fail "everything is as configured"
printf 'drive-cia402\ndio-8x8\n' >"$work/line.bus"
run "$tgm" run "$module" --config "$work/machine/TGMotion4xx.ini" --for 100ms --cycle 250 --bus "$work/line.bus" --faults /dev/null
expect "the command line wins over the bus" 2 "node 7 of the bus has no axis 1"
run "$tgm" run "$module" --config "$work/machine/TGMotion4xx.ini" --for 100ms --cycle 250 --faults /dev/null
expect "the command line wins" 0 "cycle 400 of 400"
lacks "and over the faults" "bus fault"
run "$tgm" check "$module" --config "$work/machine/TGMotion4xx.ini" --cycles 50
expect "check --config judges at its Cycle_Time" 0 "1000 us, 50 cycles each" "RESULT: PASS"
run "$tgm" run "$module" --record 'DATA.U8[65536]' --csv "$work/config.csv" --config "$work/machine/TGMotion4xx.ini"
expect "a register past the configured end" 2 "past the end of TGM_Data"
printf '[System]\nCycle_Time=300\nCycle_Tme=1\n[Servo_Modes]\nPG=4\n' >"$work/machine/TGM.INI"
run "$tgm" config "$work/machine/TGM.INI"
expect "every problem is said, with file and line" 2 "TGM.INI:2: Cycle_Time=300 in [System]: TGMcontroller takes 100, 200, 250" \
    "TGM.INI:3: warning: Cycle_Tme in [System] is unknown (did you mean Cycle_Time?)" "TGM.INI:5: PG and PG_Gear" "2 problems"
run "$tgm" check "$module" --config "$work/machine/TGM.INI"
expect "and nothing is judged under it" 2 "cannot be used"
run "$tgm" config "$work/machine/none.ini"
expect "no such configuration" 2 "none.ini: No such file"
run "$tgm" config --keys --profile tgmcontroller
expect "the keys of a product" 0 "Autostart_PLC" "Servo[n].FeedbackType"
run "$tgm" config --keys
lacks "and of no other" "Autostart_PLC"
run "$tgm" config
expect "config without a file" 2 "which file?"
for product in pc500 pc5 tgmmini tgmcontroller tgzmotion; do
    run "$tgm" run --profile $product "$module" --for 10ms --cycle 123
    expect "$product has its own Cycle_Times" 2 "--cycle must be"
done

# --- faults on the bus ----------------------------------------------------------------------------
printf 'at start dc 1 jitter 100ns\nat 20ms unplug after 1 for 10ms\n' >"$work/day.faults"
run "$tgm" run "$module" --for 50ms --faults "$work/day.faults"
expect "faults are told with their times" 0 "before the cycles  bus fault    dc 1 jitter 100ns" \
    "0.020000 s         bus fault    unplug after 1 for 10ms" "0.030000 s         bus fault    unplug after 1 for 10ms ends"
printf '# late\nat 1s drive 2 fault 0x3210\n' >"$work/bad.faults"
run "$tgm" run "$module" --faults "$work/bad.faults"
expect "a fault that cannot be is an error with its place" 2 \
    "bad.faults:2:13: slave 2 (dio-8x8) cannot have this fault; expected a drive"
printf 'at 1s mend\0 ' >"$work/bad.faults"
run "$tgm" run "$module" --faults "$work/bad.faults"
expect "a script with binary in it" 2 "it is no text"
run "$tgm" run "$module" --faults "$work/none.faults"
expect "a script that is not there" 2 "none.faults': No such file"
# --- scenarios ------------------------------------------------------------------------------------
run "$tgm" run "$module" --scenario templates/project/acceptance.scenario
expect "the template does what its scenario wants" 0 "the drive breaks at" "played to its end" ", 0 failed"
cat >"$work/day.scenario" <<'EOF'
wait until SERVO[0].Status == SERVO_READY_ENABLE within 500ms
at 10ms input DIO[0] channel 0 = 1
expect DIO[0].Out0.bit(0) within 5ms "the lamp"
at 30ms expect SERVO[0].Status == 2 within 20ms
every 1ms from 31ms to 40ms expect DIO[0].In0 == 7
at 50ms fault unplug after 1 for 20ms
at 60ms log "where it is" SERVO[0].Position
at 150ms reload
end at 700ms
EOF
names='SERVO[0].Position,DIO[0].Out0,SERVO[0].PositionError'
run "$tgm" run "$module" --scenario "$work/day.scenario" --record "$names" --csv "$work/day1.csv" --pcap "$work/day1.pcap"
expect "what failed is told with line, column, value and cycle" 1 \
    "$work/day.scenario:4:16: SERVO[0].Status == 2 not within 20ms: it was 3 (cycle " \
    "$work/day.scenario:5:36: DIO[0].In0 == 7 is not so: it was 1 (cycle " "), 10 times" \
    "scenario     where it is " "played to its end, 13 checks, 11 failed"
run "$tgm" run "$module" --scenario "$work/day.scenario" --record "$names" --csv "$work/day2.csv" --pcap "$work/day2.pcap"
cmp -s "$work/day1.csv" "$work/day2.csv" && cmp -s "$work/day1.pcap" "$work/day2.pcap" &&
    pass "the same scenario gives the same recording and capture, byte for byte" ||
    fail "the same scenario gives the same recording and capture, byte for byte"
tail -n 1 "$work/day1.csv" | grep -q '^0\.70' && pass "which goes on behind the reload" || fail "which goes on behind the reload"
run "$tgm" run "$module" --scenario "$work/day.scenario" --in-process
expect "--in-process plays it, too" 1 "played to its end, 13 checks, 11 failed"
run "$tgm" run "$module" --scenario "$work/day.scenario" --for 20ms
expect "a scenario that was cut off is not passed" 3 "not played to its end" "cycle 40 of 40"
run "$tgm" run "$module" --scenario templates/project/acceptance.scenario --for 5s
expect "--for may be longer" 0 "cycle 10000 of 10000"
run "$tgm" run "$fixtures/ini-returns-one/bad.tgm" --scenario "$work/day.scenario"
expect "a module that refuses to start plays nothing" 1 "Program_Ini returned 0: the start is aborted" "not played to its end"
printf 'at 1ms expect SERVO[0].Stauts == 3\n' >"$work/bad.scenario"
run "$tgm" run "$module" --scenario "$work/bad.scenario"
expect "a scenario that cannot be read is a wrong call" 2 "bad.scenario:1:15: SERVO has no register 'Stauts'; it has"
printf '\nat 1ms fault unplug after 9\n' >"$work/bad.scenario"
run "$tgm" run "$module" --scenario "$work/bad.scenario"
expect "a fault that cannot be, too" 2 "bad.scenario:2:27: there is no slave 9"
run "$tgm" check "$module" --cycles 20 --scenario "$work/bad.scenario"
expect "also for check" 2 "bad.scenario:2:27: there is no slave 9"
run "$tgm" run "$module" --scenario "$work/none.scenario"
expect "a scenario that is not there" 2 "none.scenario': No such file"

run "$tgm" check "$module" --cycles 20 --scenario templates/project/acceptance.scenario
expect "check judges a scenario" 0 "machine   1 passed" "1 scenario, "
run "$tgm" check "$module" --rule scenario --scenario templates/project/acceptance.scenario --scenario "$work/day.scenario"
expect "check judges two and tells what failed" 1 "FAIL  scenario" "2 scenarios, " \
    "$work/day.scenario:4:16: SERVO[0].Status == 2 not within 20ms: it was 3 in cycle " "seen 10 times" "again: tgm check"
again=$(sed -n 's/.*again: tgm //p' "$out")
# shellcheck disable=SC2086
run "$tgm" $again
expect "the reproduction line plays both" 1 "$work/day.scenario:4:16:" "2 scenarios, "
printf 'at 1ms log "nothing"\n' >"$work/idle.scenario"
run "$tgm" check "$module" --rule scenario --scenario "$work/idle.scenario"
expect "a scenario that expects nothing proves nothing" 3 "not judged: scenario" "it expects nothing of the module"
printf 'at 1ms expect 1\nend at 50ms\n' >"$work/idle.scenario"
run "$tgm" check "$fixtures/no-fault/bad.tgm" --rule scenario --scenario "$work/idle.scenario"
expect "a fault while a scenario is played fails it" 1 "idle.scenario: Program_04 divided by zero"
run "$tgm" check "$fixtures/no-system-call/bad-exit.tgm" --rule scenario --scenario "$work/idle.scenario"
expect "so does a module that calls the operating system" 1 "idle.scenario: Program_"
run "$tgm" check "$work/letter" --rule scenario --scenario "$work/idle.scenario"
expect "what cannot be run is not judged" 3 "not a module that this profile loads"
run "$tgm" check "$module" --rule scenario
expect "the rule needs a scenario" 2 "needs --scenario FILE"
run "$tgm" check "$module" --rule returns --rule 'scen*'
expect "beside others, too" 2 "the rule that matches 'scen*' needs --scenario FILE"
run "$tgm" check "$module" --cycles 20
lacks "without a scenario there is no such rule" "machine  "
run "$tgm" explain scenario
expect "explain scenario" 0 "tgm run MODULE --scenario FILE"

# --- captures and the bus on an interface ----------------------------------------------------------
run "$tgm" run "$module" --for 200ms --pcap "$work/a.pcap"
expect "run --pcap" 0 "cycle 400 of 400"
run "$tgm" run "$module" --for 200ms --pcap "$work/b.pcap"
cmp -s "$work/a.pcap" "$work/b.pcap" && pass "equal seeds give equal captures" || fail "equal seeds give equal captures"
script "$work/a.pcap" <<'EOF'
import struct, sys
data = open(sys.argv[1], "rb").read()
magic, major, minor, zone, sigfigs, snap, link = struct.unpack_from("<IHHiIII", data)
assert (magic, major, minor, link) == (0xA1B23C4D, 2, 4, 1)
at, last, frames, cyclic = 24, -1, 0, {}
while at < len(data):
    s, ns, size, whole = struct.unpack_from("<IIII", data, at)
    frame = data[at + 16:at + 16 + size]
    assert len(frame) == size == whole >= 60 and frame[12:14] == b"\x88\xa4", at
    assert s * 10**9 + ns >= last, "time goes back"
    last, at, frames = s * 10**9 + ns, at + 16 + size, frames + 1
    if frame[16] == 12:  # LRW: sent with counter 0, back with 2 * outputs + inputs
        length = struct.unpack_from("<H", frame, 22)[0] & 0x7FF
        wkc = struct.unpack_from("<H", frame, 26 + length)[0]
        cyclic[wkc] = cyclic.get(wkc, 0) + 1
assert frames > 1600 and set(cyclic) == {0, 6} and cyclic[0] == cyclic[6] >= 399, (frames, cyclic)
EOF
expect "a capture holds every frame twice, in the order of time, counters as they came back" 0
run "$tgm" run "$module" --for 100ms --in-process --pcap "$work/c.pcap"
cmp -s -n 20000 "$work/a.pcap" "$work/c.pcap" && pass "--in-process captures the same" ||
    fail "--in-process captures the same"
status=0
"$tgm" run "$module" --for 100ms --pcap - >"$work/d.pcap" 2>"$err" || status=$?
: >"$out"
expect "--pcap - leaves standard output to the capture" 0 "cycle 200 of 200"
cmp -s "$work/c.pcap" "$work/d.pcap" && pass "and nothing else" || fail "and nothing else"
run "$tgm" check "$module" --cycles 50 --pcap "$work/captures"
expect "check --pcap" 0 "RESULT: PASS"
# Not of those that only call Program_Ini.
captured=$(cd "$work/captures" && echo *)
wanted='counters-from-afar counters-from-zero counters-wrap cycle-1000 cycle-250 cycle-500 data-larger data-smaller'
wanted="$wanted $(cd conformance/faults && ls *.faults | sed 's/\.faults$//; s/^/faults-/' | tr '\n' ' ')"
wanted="$wanted globals-inverted globals-zero other-places preempted restart the-same-again traced-1000 traced-250 traced-500"
[ "$captured" = "$(printf '%s.pcap ' $wanted | sed 's/ $//')" ] &&
    pass "one capture an experiment that has a bus" || fail "one capture an experiment that has a bus: $captured"
run "$tgm" run "$fixtures/no-system-call/bad-exit.tgm" --for 100ms --pcap "$work/exit.pcap"
expect "a module that ends its process leaves a capture" 1
[ "$(head -c 4 "$work/exit.pcap" | od -An -tx1 | tr -d ' ')" = 4d3cb2a1 ] && pass "that is one" || fail "that is one"
run "$tgm" run "$module" --pcap "$work/no/such.pcap"
expect "a capture that cannot be written" 2 "cannot write '$work/no/such.pcap'"
run "$tgm" run "$module" --for 100ms --pcap /dev/full
expect "a capture on a full disk is no success" 2 "cannot write '/dev/full': No space left"
run "$tgm" check "$module" --cycles 20 --rule returns --pcap "$work/a.pcap"
expect "captures into a file" 2 "a.pcap/"
run "$tgm" run "$work/self.tgm" --pcap "$work/self.tgm"
expect "a capture over the module itself" 2 "is the module itself"
run "$tgm" run "$module" --pcap - --csv - --record 'SERVO[0].Position'
expect "two things to standard output" 2 "cannot both"

# --- EEPROM and CAN -------------------------------------------------------------------------------
run "$tgm" run "$module" --for 20ms --eeprom "$work/Eeprom.bin"
expect "an EEPROM that nobody saves" 0
[ ! -e "$work/Eeprom.bin" ] && pass "leaves no file" || fail "leaves no file"
: >"$work/Eeprom.bin"
run "$tgm" run "$module" --eeprom "$work/Eeprom.bin"
expect "an empty EEPROM file" 2 "must have 1 to 2752 bytes"
run "$tgm" run "$module" --eeprom "$work"
expect "a folder as EEPROM" 2 "cannot read EEPROM"
run "$tgm" run "$work/self.tgm" --eeprom "$work/self.tgm"
expect "the module itself as EEPROM" 2
printf 'loopback\nat 1ms send 0x800\n' >"$work/bad.can"
run "$tgm" run "$module" --can "$work/bad.can"
expect "a CAN script that is refused" 2 "bad.can:2: an identifier up to 0x7FF expected, not '0x800'"
printf 'every 1ms send 0x7FF\n' >"$work/good.can"
run "$tgm" run "$module" --for 20ms --can "$work/good.can"
expect "a CAN script that is played" 0

run "$tgm" bus
expect "bus without devices" 2 "which devices?" "drive-cia402"
run "$tgm" bus dio-8x8
expect "bus without an interface" 2 "which interface?"
run "$tgm" bus --interface lo dio-8x9
expect "no such device" 2 "did you mean dio-8x8?"
run "$tgm" bus --interface nosuch0 dio-8x8
expect "no such interface" 2 "no interface 'nosuch0'; there are"
run "$tgm" bus --interface lo --on-a-real-network dio-8x8
expect "the loopback interface has no far end" 2 "lo has one end"
run "$tgm" bus --interface lo --timing slow dio-8x8
expect "no such timing" 2 "instant or real"
run "$tgm" bus --help
expect "bus --help" 0 "--on-a-real-network"

finish
