#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# What may be asked of `tgm check`: some rules, strictness, waivers, evidence; wrong values. A few rules a run. BUILD names
# the tree.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
build=${BUILD:-build}
tgm=$build/tgm
fixtures=$build/fixtures
good=$fixtures/no-fault/good.tgm
bad=$fixtures/no-fault/bad.tgm

check() { # module, options: few cycles
    run "$tgm" check "$@" --cycles 60
}

# --- which rules ----------------------------------------------------------------------------------
check "$good" --rule 'no-t*' --rule returns
expect "several patterns add up" 0 "RESULT: PASS (5 passed"
check "$good" --rule 'no-t*,returns'
expect "commas, too" 0 "RESULT: PASS (5 passed" "rules=no-t*,returns"
check "$good" --rule 'no-t*' --rule '!no-tls' --rule '!*block'
expect "a pattern with ! takes away" 0 "RESULT: PASS (2 passed"
check "$good" --rule '!no-fault' --rule '!*[!t]'
last_line "alone it means all but those" "^RESULT: PASS ([0-9]* passed, 0 failed, 0 not judged) profile=pc4 rules=!no-fault,!\*\[!t\] cycles=60"
for patterns in "no-falt" "no-fault,no-falt" "no-fault,!no-falt" "" "no-fault," "!"; do
    check "$good" --rule "$patterns"
    expect "a pattern that fits no rule: '$patterns'" 2 "no rule matches '" "tgm rules"
done
check "$good" --rule no-fault --rule '!no-*'
expect "patterns that leave nothing" 2 "'no-fault,!no-*' leaves no rule to judge by"
run "$tgm" check "$good" --rule
expect "a pattern that is missing" 2 "--rule needs a value"

# --- strict ---------------------------------------------------------------------------------------
should=$fixtures/inputs-first/bad.tgm
check "$should" --rule inputs-first
expect "a should does not decide" 0 "warn  inputs-first" "RESULT: PASS (0 passed, 1 failed"
check "$should" --rule inputs-first --strict
expect "with --strict it does" 1 "FAIL  inputs-first" "profile=pc4 rules=inputs-first strict cycles=60 seed=0x1d2f"
check "$fixtures/debug-information/bad.tgm" --rule debug-information --strict
expect "a note never does" 0 "note  debug-information"

# --- waivers --------------------------------------------------------------------------------------
waive() { # name status module lines text...: judged with a file of waivers
    name=$1
    want=$2
    module=$3
    printf '%s\n' "$4" >"$work/waivers"
    shift 4
    run "$tgm" check "$module" --rule no-fault --rule returns --cycles 60 --waive "$work/waivers" --junit "$work/junit.xml"
    expect "$name" "$want" "$@"
}
answer="by jana@example.com: the next release has it"
waive "a waived failure passes, and says so" 0 "$bad" "no-fault until 2999-12-31 $answer" \
    "waived  no-fault " "Program_04 divided by zero" "waived  no-fault until 2999-12-31 $answer" \
    "RESULT: PASS (1 passed, 1 failed, 0 not judged)"
grep -q ' failures="0" errors="0" skipped="1"' "$work/junit.xml" && pass "and a CI stays green" || fail "and a CI stays green"
waive "a waiver that is out of date fails" 1 "$bad" "no-fault until 2020-12-31 $answer" "FAIL  no-fault" "out of date" "RESULT: FAIL"
waive "also when it is not needed" 1 "$good" "no-fault until 2020-12-31 $answer" "out of date: it fails the module" "RESULT: FAIL (2 passed"
grep -q ' tests="3" failures="1"' "$work/junit.xml" && pass "and turns a CI red" || fail "and turns a CI red"
waive "one that is not needed is told" 0 "$good" "no-fault until 2999-12-31 $answer" "not needed: the rule did not fail"
waive "one for a rule that is not asked for is not looked at" 0 "$good" "no-imports until 2020-12-31 $answer" "RESULT: PASS"
waive "other failures are not waived" 1 "$bad" "returns until 2999-12-31 $answer" "FAIL  no-fault"
waive "comments, empty lines and several waivers" 0 "$bad" "# ours

  no-fault until 2999-12-31 $answer
returns until 2999-12-31 $answer" "waived  returns until"
waive "an unknown rule" 2 "$bad" "no-falt until 2999-12-31 $answer" "waivers:1: 'no-falt' is no rule"
waive "no day" 2 "$bad" "no-fault $answer" "waivers:1: 'until' and a day"
waive "a day that there is not" 2 "$bad" "no-fault until 2999-02-29 $answer" "waivers:1: 'until' and a day"
waive "nobody who answers for it" 2 "$bad" "no-fault until 2999-12-31: later" "waivers:1: 'until' and a day"
waive "no owner" 2 "$bad" "no-fault until 2999-12-31 by : later" "waivers:1: 'by', who answers for it"
waive "no reason" 2 "$bad" "
no-fault until 2999-12-31 by me:" "waivers:2: the reason is missing"
waive "two for one rule" 2 "$bad" "no-fault until 2999-12-31 $answer
no-fault until 2999-12-30 $answer" "waivers:2: a second waiver for no-fault"
check "$bad" --waive "$work/none"
expect "a file that is not there" 2 "cannot read waivers" "No such file"
check "$bad" --waive "$work"
expect "a folder in its place" 2 "cannot read waivers" "Is a directory"
printf 'at 1ms expect 1\nend at 20ms\n' >"$work/idle.scenario"
printf 'scenario until 2999-12-31 by me: not yet\n' >"$work/waivers"
printf 'letter' >"$work/letter"
run "$tgm" check "$work/letter" --rule scenario --scenario "$work/idle.scenario" --waive "$work/waivers"
expect "what was not judged cannot be waived" 3 "RESULT: INCOMPLETE"

# --- evidence -------------------------------------------------------------------------------------
verdict() { # of the last run
    tail -n 1 "$out"
}
for module in "$good" "$bad"; do
    rm -rf "$work/saved"
    check "$module" --rule 'no-*' --rule returns --evidence "$work/saved"
    was=$status
    verdict >"$work/was"
    run "$tgm" check --from-evidence "$work/saved" --json "$work/again.json"
    verdict | cmp -s - "$work/was" && [ "$status" = "$was" ] && pass "saved evidence gives the same verdict ($was)" ||
        fail "saved evidence gives the same verdict ($was)"
    python3 -c '
import hashlib, json, sys
manifest = open(sys.argv[1] + "/manifest.json", "rb").read()
assert json.load(open(sys.argv[2]))["evidence"] == hashlib.sha256(manifest).hexdigest()
for name, entry in json.loads(manifest)["files"].items():
    data = open(sys.argv[1] + "/" + name, "rb").read()
    assert (entry["size"], entry["sha256"]) == (len(data), hashlib.sha256(data).hexdigest()), name
' "$work/saved" "$work/again.json" && pass "whose manifest has the hash of every file" || fail "whose manifest has the hash of every file"
done
printf 'no-fault until 2999-12-31 %s\n' "$answer" >"$work/waivers"
run "$tgm" check --from-evidence "$work/saved" --waive "$work/waivers"
expect "a waiver may be given anew" 0 "RESULT: PASS" "waived  no-fault"
run "$tgm" check --from-evidence "$work/saved" --rule returns
expect "so may rules" 0 "RESULT: PASS (1 passed" "rules=returns"
run "$tgm" check --from-evidence "$work/saved" --rule restart
expect "what no run was made for is not judged" 3 "not judged: restart" "the saved evidence does not have what this rule needs"
for option in --seed=3 "--seed 3" --cycles=5 "--profile pc5" --jobs=2 "--evidence $work/other"; do
    # shellcheck disable=SC2086
    run "$tgm" check --from-evidence "$work/saved" $option
    expect "what belongs to a run cannot: $option" 2 "is settled: --from-evidence runs nothing"
done
run "$tgm" check "$bad" --from-evidence "$work/saved"
expect "nor a module" 2 "--from-evidence has its module with it"
for file in "$work"/saved/*; do
    name=$(basename "$file")
    cp "$file" "$work/kept"
    python3 -c 'import sys
data = bytearray(open(sys.argv[1], "rb").read())
data[len(data) // 2] ^= 1
open(sys.argv[1], "wb").write(data)' "$file"
    run "$tgm" check --from-evidence "$work/saved"
    # Of the manifest itself a report can only say the hash: a certificate holds it.
    [ "$name" = manifest.json ] || expect "a changed byte is seen: $name" 2 "$name' is not what was written: its SHA-256 is"
    cp "$work/kept" "$file"
done
run "$tgm" check --from-evidence "$work/saved"
expect "put back it is taken again" 1 "RESULT: FAIL"
rm "$work/saved/manifest.json"
run "$tgm" check --from-evidence "$work/saved"
expect "no manifest" 2 "manifest.json': No such file"
run "$tgm" check --from-evidence "$work/none"
expect "no folder" 2 "No such file"
mkdir "$work/mine"
echo "{}" >"$work/mine/manifest.json"
check "$good" --rule no-fault --evidence "$work/mine"
expect "other people's folders are left alone" 2 "is not empty, and no evidence of tgm"
[ "$(cat "$work/mine/manifest.json")" = "{}" ] && pass "to the byte" || fail "to the byte"
check "$good" --rule no-fault --evidence "$work/no/such"
expect "a folder that cannot be made" 2 "cannot make the folder"

# --- showing it again -----------------------------------------------------------------------------
said() { # the first finding of the last run
    sed -n '/^FAIL\|^warn\|^note/{n;p;q}' "$out"
}
for fixture in no-imports/bad no-fault/bad write-read-only/bad globals-independent/bad waits-for-bus/bad disturbed-finite/bad; do
    rule=${fixture%/*}
    check "$fixtures/$fixture.tgm" --rule "$rule" --seed 0x7e57
    said >"$work/first"
    printf '%s\n' "$tgm $(sed -n 's/^ *again: tgm //p' "$out")" >"$work/again.sh"
    sed -n 's/^ *debug: gdb //p' "$out" >"$work/debug"
    run sh "$work/again.sh"
    said | cmp -s - "$work/first" && [ -s "$work/first" ] && pass "its line shows it again: $rule" || fail "its line shows it again: $rule"
    case $rule in
    no-fault) stops="bad.c:10" ;;
    write-read-only) stops="bad.c:11" ;;
    *) continue ;;
    esac
    command -v gdb >/dev/null || continue
    sed "s|^|gdb -batch |; s|--args tgm |--args $tgm |" "$work/debug" >"$work/debug.sh"
    run timeout 60 sh "$work/debug.sh"
    expect "gdb stops where it is: $rule" 0 "Program_04 (" "$rule/$stops"
done
command -v gdb >/dev/null || echo "SKIP  gdb is not installed: debug lines are not tried"
check "$fixtures/no-system-call/bad.tgm" --rule no-system-call
lacks "no line runs without a sandbox what called the system" "debug:"

# --- where reports go -----------------------------------------------------------------------------
mkdir "$work/there" "$work/here"
ln -s ../there/target.json "$work/here/link.json"
for time in first second; do
    check "$good" --rule no-fault --json "$work/here/link.json"
    [ -L "$work/here/link.json" ] && grep -q '"verdict": "PASS"' "$work/there/target.json" &&
        pass "a link stays one, the $time time" || fail "a link stays one, the $time time"
    [ "$time" = second ] || echo "old" >"$work/there/target.json"
done
"$tgm" check "$good" --json "$work/here/killed.json" --html "$work/here/killed.html" >/dev/null 2>&1 &
sleep 0.3
kill -9 $!
wait $! 2>/dev/null
[ "$(ls "$work/here")" = link.json ] && pass "who is killed leaves nothing half-written" || fail "who is killed leaves nothing half-written"

# --- values ---------------------------------------------------------------------------------------
wrong() { # options text: a wrong call
    # shellcheck disable=SC2086
    run "$tgm" check "$good" --rule no-fault $1
    expect "wrong: $1" 2 "$2"
}
wrong "--jobs 0" "--jobs must be 1 to 64, not 0"
wrong "--jobs 65" "--jobs must be 1 to 64, not 65"
wrong "--jobs two" "--jobs needs a number"
wrong "--cycles 0" "--cycles must be 1 to 100000000, not 0"
wrong "--cycles -5" "--cycles needs a number"
wrong "--cycles 1e6" "--cycles needs a number"
wrong "--seed 0x" "--seed needs a number"
wrong "--seed 99999999999999999999" "--seed needs a number"
wrong "--seed" "--seed needs a value: --seed N"
wrong "--strict=yes" "--strict takes no value"
wrong "--profile pc6" "unknown profile 'pc6'; allowed: pc4"
wrong "--waived x" "unknown option --waived (did you mean --waive?)"
wrong "--scenario $work/none" "cannot read"
wrong "--config $work/none" "No such file"
run "$tgm" check --help
expect "help names a page that is there" 0 "docs/checking.md"
for page in $(sed -n 's/.*\(docs\/[a-z-]*\.md\).*/\1/p' "$out"); do
    [ -e "$page" ] && pass "$page" || fail "$page"
done
check "$good" --rule no-fault --seed 18446744073709551615 --jobs 64
expect "the greatest values" 0 "seed=0xffffffffffffffff"

finish
