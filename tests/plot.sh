#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# TG Motion's oscilloscope from the command line, and recordings as pictures. BUILD names the tree.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
build=${BUILD:-build}
tgm=$build/tgm
module=$build/template/shuttle.tgm
five=$build/template5/shuttle.tgm

${MAKE:-make} --no-print-directory -C templates/c TGM_GENERATION=5 BUILD="$PWD/$build/template5" >"$work/make" 2>&1 ||
    cat "$work/make"

# rows NAME AWK: a condition that every row of $work/osc.csv keeps; $1 is the time, $2 the first register
rows() {
    if awk -F, 'NR > 1 && !('"$2"') {bad = 1} {before = $0; tick = $2; at = $1} END {exit bad || NR < 3}' "$work/osc.csv"; then
        pass "$1"
    else
        head -n 5 "$work/osc.csv" >"$out"
        fail "$1"
    fi
}

# --- the oscilloscope -----------------------------------------------------------------------------
run "$tgm" run "$module" --for 2s --osc 'MAIN.Servo_Tick,DIO[0].In0' --osc-trigger 'DIO[0].In0 rising 0.5' \
    --osc-every 4 --csv "$work/osc.csv"
expect "run --osc" 0 "cycle 4000 of 4000" "oscilloscope: 9" " samples, 0 s to 1.9" "of the trigger"
head -n 2 "$work/osc.csv" >"$out"
expect "its first sample is the trigger's cycle" 0 "time_s,MAIN.Servo_Tick,DIO[0].In0" "0.000000,1"
rows "one sample every four cycles" 'NR == 2 || ($2 - tick == 4 && $1 - at > 0.0019 && $1 - at < 0.0021)'
run "$tgm" run "$module" --for 2s --osc 'MAIN.Servo_Tick' --osc-trigger 'DIO[0].In0 falling 0.5' --csv "$work/fall.csv"
expect "a falling edge" 0 "of the trigger"
first=$(sed -n 2p "$work/fall.csv") rise=$(sed -n 2p "$work/osc.csv" | cut -d, -f2)
[ "$((${first#*,} - rise))" = 400 ] && pass "comes 200 ms behind the rising one" || fail "comes 200 ms behind the rising one"
run "$tgm" run "$module" --for 100ms --osc 'MAIN.Servo_Tick' --csv "$work/osc.csv"
expect "without a trigger it begins at once" 0 "oscilloscope: 200 samples, 0 s to 0.0995 s"
rows "and takes every cycle" 'NR == 2 ? $1 == 0 && $2 == 1 : $2 - tick == 1'
lacks "no word of a trigger" "of the trigger"
run "$tgm" run "$module" --for 100ms --osc 'MAIN.Servo_Tick' --osc-trigger 'DIO[0].Out7 rising 0.5' --csv "$work/osc.csv"
expect "a trigger that does not come" 0 "oscilloscope: the trigger did not come; nothing was recorded"
[ "$(cat "$work/osc.csv")" = "time_s,MAIN.Servo_Tick" ] && pass "leaves a head without rows" || fail "leaves a head without rows"
run "$tgm" run "$module" --for 2s --osc "$(printf 'SERVO[0].Position,%.0s' $(seq 31))SERVO[0].Position" --csv "$work/osc.csv"
expect "32 channels fill 4.21's memory" 0 "oscilloscope: 4000 samples"
run "$tgm" run "$module" --for 2100ms --osc "$(printf 'SERVO[0].Position,%.0s' $(seq 31))SERVO[0].Position" --csv "$work/osc.csv"
expect "and when it is full, it stops by itself" 0 "oscilloscope: 4096 samples, 0 s to 2.0475 s"

run "$tgm" run "$five" --profile pc5 --for 300ms --osc 'MAIN.Servo_Tick' --osc-trigger 'DIO[0].In[0] rising 0.5' \
    --osc-pretrigger 10 --csv "$work/osc.csv"
expect "5.02 keeps samples from before the trigger" 0 "samples, -0.005 s to 0.2"
rows "in one row with the others" 'NR == 2 ? $1 == "-0.005000" : $2 - tick == 1 && $1 - at > 0.00049 && $1 - at < 0.00051'

run "$tgm" run "$module" --osc 'MAIN.Servo_Tick' --osc-trigger 'DIO[0].In0 rising 1' --osc-pretrigger 5 --csv "$work/osc.csv"
expect "a pre-trigger needs 5.02" 2 "samples before the trigger need TG Motion 5.02 and a trigger"
run "$tgm" run "$module" --osc 'MAIN.Servo_Tick' --osc-trigger 'DIO[0].In0 upwards 1' --csv "$work/osc.csv"
expect "a wrong edge" 2 "the edge is rising or falling, not 'upwards'"
run "$tgm" run "$module" --osc 'MAIN.Servo_Tick' --osc-trigger 'DIO[0].In0 rising' --csv "$work/osc.csv"
expect "half a trigger" 2 "--osc-trigger needs register, rising or falling, and level" "not 'DIO[0].In0 rising'"
run "$tgm" run "$module" --osc 'MAIN.Servo_Tick' --osc-trigger 'DIO[0].In0 rising high' --csv "$work/osc.csv"
expect "a level that is no number" 2 "the level is a number, not 'high'"
run "$tgm" run "$five" --profile tgmcontroller --osc 'MAIN.Servo_Tick' --osc-trigger 'SERVO[100].Position rising 1' --csv "$work/osc.csv"
expect "a trigger past the end" 2 "--osc-trigger: 'SERVO[100].Position rising 1' is past the end of TGM_Servo on TGMcontroller"
run "$tgm" run "$module" --osc 'SERVO[0].Positon' --csv "$work/osc.csv"
expect "a register that is not there" 2 "--osc: SERVO has no register 'Positon'"
run "$tgm" run "$module" --osc "$(printf 'SERVO[0].Position,%.0s' $(seq 32))SERVO[0].Position" --csv "$work/osc.csv"
expect "33 channels" 2 "--osc takes at most 32 registers"
run "$tgm" run "$module" --osc 'DATA.U16[0]' --csv "$work/osc.csv"
expect "a type that is not recorded" 2 "the oscilloscope does not record registers of type"
run "$tgm" run "$module" --osc 'MAIN.Servo_Tick'
expect "and where to" 2 "--osc and --csv or --plot go together"
run "$tgm" run "$module" --osc 'MAIN.Servo_Tick' --record 'MAIN.Servo_Tick' --csv "$work/osc.csv"
expect "one kind of recording" 2 "--osc and --record exclude each other"
run "$tgm" run "$module" --record 'MAIN.Servo_Tick' --osc-every 2 --csv "$work/osc.csv"
expect "what belongs to the oscilloscope" 2 "--osc-every belong to --osc"

# --- pictures -------------------------------------------------------------------------------------
run "$tgm" run "$module" --plot "$work/axis.bmp"
expect "a picture of another kind" 2 "a picture ends in .png or .svg, not"
mkdir "$work/bin"
run env PATH="$work/bin" "$tgm" run "$module" --plot "$work/axis.png"
expect "without gnuplot" 2 "gnuplot draws the pictures and is not installed: apt-get install gnuplot-nox"
lacks "it is said before the run" "cycle"
if ! command -v gnuplot >/dev/null 2>&1; then
    echo "SKIP pictures: gnuplot is not installed"
    finish
    exit
fi

# is_png FILE LEAST: by its signature, and at least so many bytes
is_png() {
    [ "$(head -c 8 "$1" | od -An -tx1 | tr -d ' ')" = 89504e470d0a1a0a ] && [ "$(wc -c <"$1")" -ge "$2" ]
}

run "$tgm" run "$module" --for 2s --plot "$work/axis.png"
expect "run --plot" 0 "cycle 4000 of 4000"
is_png "$work/axis.png" 10000 && pass "draws a PNG" || fail "draws a PNG"
[ ! -s "$err" ] && pass "gnuplot has nothing to say" || fail "gnuplot has nothing to say"
printf 'drive-cia402\ndrive-cia402\ndi-8\n' >"$work/two.bus"
run "$tgm" run "$module" --for 1s --bus "$work/two.bus" --plot "$work/two.svg" --csv "$work/two.csv"
expect "run --plot of two servos" 0 "cycle 2000 of 2000"
cp "$work/two.svg" "$out"
expect "shows where both are and are to be" 0 "<svg" ">SERVO[0].WritePosition<" ">SERVO[0].Position<" \
    ">SERVO[1].WritePosition<" ">SERVO[1].Position<" ">inc<" ">time (s)<" "shuttle.tgm on TG Motion 4.21, Cycle_Time 500 us" \
    "0 s to 0.9995 s, 2000 samples"
lacks "and none that is not there" "SERVO[2]"
[ "$(head -n 1 "$work/two.csv")" = "time_s,SERVO[0].WritePosition,SERVO[0].Position,SERVO[1].WritePosition,SERVO[1].Position" ] &&
    [ "$(tail -n 1 "$work/two.csv" | tr -cd , | wc -c)" = 4 ] && pass "so does the recording" || fail "so does the recording"

names='SERVO[0].WritePosition,SERVO[0].Position,SERVO[0].Speed,DIO[0].In0,DIO[0].Out0,MAIN.Servo_Tick'
"$tgm" run "$module" --for 1s --record "$names" --plot "$work/all.svg" --csv - 2>"$err" >"$work/all.csv"
status=$?
cp "$work/all.svg" "$out"
expect "units come from the layouts, names from the registers" 0 ">inc<" ">Speed (inc/s)<" ">Servo_Tick<" ">DIO[0].In0<" \
    ">DIO[0].Out0<" ">SERVO[0].Speed<" ">SERVO[0].WritePosition<" ">time (s)<"
[ "$(wc -l <"$work/all.csv")" = 2001 ] && pass "--csv - and --plot go together" || fail "--csv - and --plot go together"
"$tgm" run "$module" --for 1s --record "$names" --plot "$work/again.svg" >"$out" 2>"$err"
cmp -s "$work/all.svg" "$work/again.svg" && pass "equal runs give equal pictures" || fail "equal runs give equal pictures"

run "$tgm" run "$five" --profile pc5 --for 300ms --osc 'MAIN.Servo_Tick,DIO[0].In[0]' \
    --osc-trigger 'DIO[0].In[0] rising 0.5' --osc-pretrigger 20 --plot "$work/osc.svg"
expect "the oscilloscope's samples as a picture" 0 "of the trigger"
cp "$work/osc.svg" "$out"
expect "in milliseconds when it is short" 0 ">time (ms)<" "-10 ms to 2" "TG Motion 5.02" ">DIO[0].In[0]<"
run "$tgm" run "$module" --for 100ms --osc 'MAIN.Servo_Tick' --osc-trigger 'DIO[0].Out7 rising 0.5' --plot "$work/none.png"
expect "nothing to draw" 2 "the trigger did not come" "nothing was recorded: there is nothing to draw in"
[ ! -e "$work/none.png" ] && pass "and no file" || fail "and no file"
printf 'di-8\n' >"$work/none.bus"
run "$tgm" run "$build/fixtures/no-fault/good.tgm" --for 100ms --bus "$work/none.bus" --plot "$work/none.png"
expect "no servo to draw" 2 "there is no servo to draw; --record says what else"
run "$tgm" run "$build/fixtures/ini-returns-one/bad.tgm" --plot "$work/none.png"
expect "a module that does not start is at fault, not the picture" 1 "Program_Ini returned 0: the start is aborted"
run "$tgm" run "$module" --for 100ms --plot "$work/nowhere/axis.png"
expect "nowhere to draw to" 2 "cannot write '$work/nowhere/axis.png': No such file"

# --- tgm plot -------------------------------------------------------------------------------------
run "$tgm" plot "$work/all.csv" --to "$work/all.png"
expect "tgm plot" 0
is_png "$work/all.png" 20000 && pass "draws a PNG of a recording" || fail "draws a PNG of a recording"
run "$tgm" plot "$work/all.csv" --to "$work/titled.svg" --title "Gantry's <first> axis & door"
expect "tgm plot --title" 0
cp "$work/titled.svg" "$out"
expect "the title is text" 0 "Gantry's &lt;first> axis &amp; door" ">Speed (inc/s)<"
(
    cd "$work" || exit
    cp all.csv '|touch pwned;.csv'
    "$OLDPWD/$tgm" plot '|touch pwned;.csv' --to '|touch pwned;.svg' >"$out" 2>"$err"
)
[ -s "$work/|touch pwned;.svg" ] && [ ! -e "$work/pwned" ] && pass "a name is no command" || fail "a name is no command"
run "$tgm" plot "$work/all.csv" --to "$work/all.csv"
expect "a recording is no picture" 2 "a picture ends in .png or .svg"
printf 'a,b\n1,2\n' >"$work/other.csv"
run "$tgm" plot "$work/other.csv" --to "$work/other.png"
expect "a file that is no recording" 2 "other.csv:1: not a recording of tgm run"
printf 'time_s,SERVO[0].Position\n0,1\n0.1,2,3\n' >"$work/other.csv"
run "$tgm" plot "$work/other.csv" --to "$work/other.png"
expect "a row that does not fit" 2 "other.csv:3: expected 2 numbers with commas between them"
printf 'time_s,SERVO[0].Position\n0.2,1\n0.1,2\n' >"$work/other.csv"
run "$tgm" plot "$work/other.csv" --to "$work/other.png"
expect "a time that goes back" 2 "other.csv:3: the time must not go back"
printf 'time_s,SERVO[0].Position\n' >"$work/other.csv"
run "$tgm" plot "$work/other.csv" --to "$work/other.png"
expect "a recording without rows" 2 "nothing was recorded"
: >"$work/other.csv"
run "$tgm" plot "$work/other.csv" --to "$work/other.png"
expect "an empty file" 2 "is empty"
run "$tgm" plot "$work/missing.csv" --to "$work/other.png"
expect "no file" 2 "cannot read" "No such file"
run "$tgm" plot "$work/all.csv"
expect "where to" 2 "usage: tgm plot FILE.csv --to FILE.png|svg"

finish
