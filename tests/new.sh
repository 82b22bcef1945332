#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# tgm new: projects that build and pass untouched; wrong calls that change nothing.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
root=$PWD
tgm=$root/${BUILD:-build}/tgm
cd "$work" || exit 1

for lang in c cpp pascal; do
    if [ $lang = pascal ] && ! command -v fpc >/dev/null; then
        echo "SKIP  tgm new --lang pascal: fpc is not installed"
        continue
    fi
    run "$tgm" new "gantry_$lang" --lang $lang
    expect "new --lang $lang" 0 "gantry_$lang/ is a project"
    for file in Makefile README.md .gitignore .vscode/tasks.json .vscode/launch.json ci-example.yml controller.ini acceptance.scenario; do
        [ -s "gantry_$lang/$file" ] && pass "$lang has $file" || fail "$lang has $file"
    done
    if grep -rqE 'shuttle|@[A-Z]+@|\.\./\.\./sdk' "gantry_$lang"; then
        grep -rnE 'shuttle|@[A-Z]+@|\.\./\.\./sdk' "gantry_$lang" >"$out"
        fail "$lang: nothing is left to fill in"
    else
        pass "$lang: nothing is left to fill in"
    fi
    python3 -c 'import json, sys; [json.load(open(f)) for f in sys.argv[1:]]' "gantry_$lang/.vscode/tasks.json" \
        "gantry_$lang/.vscode/launch.json" && pass "$lang: editor files are JSON" || fail "$lang: editor files are JSON"
    run make -C "gantry_$lang" check CHECK_FLAGS='--cycles 200' TGM="$tgm"
    expect "$lang: the new project passes, and its scenario is played" 0 "RESULT: PASS" "machine   1 passed" "1 scenario,"
    printf 'wait until DATA.U32[4] == 99 within 5ms "it never comes"\n' >"gantry_$lang/second.scenario"
    run make -C "gantry_$lang" check CHECK_FLAGS='--cycles 200' TGM="$tgm"
    expect "$lang: every scenario of the folder is played" 2 "2 scenarios," "second.scenario:1:12: it never comes: DATA.U32[4] == 99 not within 5ms: it was 2" "Error 1"
    rm "gantry_$lang/second.scenario"
done
for lang in c cpp pascal; do
    if [ $lang = pascal ] && ! command -v fpc >/dev/null; then
        echo "SKIP  tgm new --lang pascal --generation 5: fpc is not installed"
        continue
    fi
    run "$tgm" new "five_$lang" --lang $lang --generation 5
    expect "new --lang $lang --generation 5" 0 "generation 5"
    run make -C "five_$lang" TGM="$tgm"
    expect "$lang: a project for generation 5 builds" 0
    grep -q '^TGM_GENERATION := 5$' "five_$lang/Makefile" && pass "$lang: and says so in its Makefile" || fail "$lang: and says so in its Makefile"
    run "$tgm" inspect "five_$lang/build/five_$lang.tgm"
    expect "$lang: six exports and no import" 0 "exports       6" "imports       none"
    run make -C "five_$lang" check CHECK_FLAGS='--cycles 200' TGM="$tgm"
    expect "$lang: it passes as a module of 5.02" 0 "RESULT: PASS" "profile=pc5" "machine   1 passed"
    [ $lang = pascal ] || for product in tgmmini tgmcontroller tgzmotion; do
        run make -C "five_$lang" check TGM_PROFILE=$product CONFIG= CHECK_FLAGS='--cycles 200' TGM="$tgm"
        expect "$lang: a rebuild for $product passes" 0 "RESULT: PASS" "profile=$product"
    done
    run make -C "five_$lang" TGM="$tgm" TARGET=pe64
    expect "$lang: generation 5 for a PC" 0 "VERIFY"
    run make -C "five_$lang" TGM="$tgm" TGM_MEMORY_ID=905
    expect "$lang: TG Motion 5.00" 0 "VERIFY"
    run make -C "five_$lang" check CHECK_FLAGS='--cycles 200' TGM="$tgm" TGM_MEMORY_ID=905
    expect "$lang: it passes as a module of 5.00" 0 "RESULT: PASS" "profile=pc500"
done

before=$(find . | sort | cksum)
run "$tgm" new gantry_c
expect "an existing folder" 2 "exists already"
run "$tgm" new ../escape
expect "a bad name" 2 "is no project name"
run "$tgm" new "two words"
expect "a name with a blank" 2 "is no project name"
run "$tgm" new 9lives
expect "a name that begins with a digit" 2 "is no project name"
run "$tgm" new ''
expect "an empty name" 2 "is no project name"
run "$tgm" new while
expect "a word of the language" 2 "is no project name"
for lang in c cpp pascal; do
    run "$tgm" new Follow --lang $lang
    expect "a name that the $lang template uses" 2 "'Follow' is the name of something else in the template"
done
touch gantry
run "$tgm" new gantry
expect "an existing file" 2 "exists already"
rm gantry
run "$tgm" new x --lang rust
expect "an unknown language" 2 "allowed: c, cpp, pascal"
run "$tgm" new x --generation 6
expect "an unknown generation" 2 "4 to 5"
run "$tgm" new
expect "no name" 2 "what shall it be called?"
[ "$before" = "$(find . | sort | cksum)" ] && pass "wrong calls change nothing" || fail "wrong calls change nothing"

# Source-level debugging: gdb knows the module's functions and variables.
if command -v gdb >/dev/null; then
    printf 'break Program_04\nrun\nprint plc.state\ndelete\ncontinue\n' >commands
    make -C gantry_c TGM="$tgm" >/dev/null 2>&1
    run gdb -q -batch -x "$root/sdk/gdb/tgm.gdb" -x commands --args "$tgm" run --in-process --for 100ms gantry_c/build/gantry_c.tgm
    expect "make debug: breakpoints and variables" 0 "gantry_c.c:" "WAIT_FOR_BUS"
else
    echo "SKIP  make debug: gdb is not installed"
fi

finish
