#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# Modules in Pascal: the template against C's, every member's place, and what is refused in which words.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
root=$PWD
tgm=$root/${BUILD:-build}/tgm
template=$root/templates/pascal/shuttle.pas

if ! command -v fpc >/dev/null 2>&1; then
    echo "SKIP    Pascal: no Free Pascal compiler here (Debian: fp-compiler); nothing of it was tested"
    finish
    exit
fi
targets=elf64
if command -v x86_64-w64-mingw32-gcc >/dev/null 2>&1; then
    targets='elf64 pe64'
else
    echo "SKIP    Pascal for pe64: no x86_64-w64-mingw32-gcc (Debian: gcc-mingw-w64-x86-64-win32)"
fi

# same NAME FILE FILE: byte for byte
same() {
    if cmp "$2" "$3" >"$out" 2>"$err" && [ -s "$2" ]; then pass "$1"; else fail "$1"; fi
}

# --- the template ----------------------------------------------------------------------------------

run make -C templates/c BUILD="$work/c" "$work/c/shuttle.tgm"
expect "the C template builds" 0
for target in $targets; do
    run make -C templates/pascal BUILD="$work/$target" TARGET=$target
    expect "the template builds for $target" 0 "FPC" "LINK" "VERIFY"
    lacks "without a warning ($target)" warning
done
for id in 905 906; do
    run make -C templates/c BUILD="$work/c-$id" TGM_GENERATION=5 TGM_MEMORY_ID=$id
    expect "the C template builds for memory id $id" 0
    for target in $targets; do
        run make -C templates/pascal BUILD="$work/$target-$id" TARGET=$target TGM_GENERATION=5 TGM_MEMORY_ID=$id
        expect "the template builds for $target, memory id $id" 0 "FPC" "LINK" "VERIFY"
        lacks "without a warning ($target, $id)" warning
        run "$tgm" inspect "$work/$target-$id/shuttle.tgm"
        expect "six exports and no import ($target, $id)" 0 "exports       6" "imports       none" "initialisers  none"
    done
done
run make -C templates/pascal BUILD="$work/elf64-906" TGM_GENERATION=5 TGM_MEMORY_ID=906
lacks "nothing changed, nothing is done" FPC
run make -C templates/pascal BUILD="$work/elf64-906" TGM_GENERATION=5 check
expect "generation 5 is judged as what it is" 0 "RESULT: PASS" "profile=pc5"
run make -C templates/pascal BUILD="$work/elf64-906" TGM_GENERATION=4
expect "another generation builds anew" 0 "FPC" "CC" "start.c"
run make -C templates/pascal BUILD="$work/elf64-906" TGM_GENERATION=5
expect "and back" 0 "FPC"
run make -C templates/pascal BUILD="$work/none" TGM_GENERATION=6
expect "an unknown generation" 2 "TGM_GENERATION is '6'; allowed: 4 5"
run make -C templates/pascal BUILD="$work/none" TGM_GENERATION=5 TGM_MEMORY_ID=904
expect "an unknown memory id" 2 "TGM_MEMORY_ID is '904'; allowed: 905 906"
module=$work/elf64/shuttle.tgm
printf '%s\n' Program_01 Program_02 Program_03 Program_04 Program_05 Program_Ini >"$work/six"

readelf --dyn-syms -W "$module" | awk '$1 ~ /^[0-9]+:$/ && $8 != "" {print $8}' | sort >"$work/exports"
same "elf64: exactly the six exports" "$work/six" "$work/exports"
run nm -u "$module"
lacks "elf64: nothing undefined" " U "
run readelf -dW "$module"
expect "elf64: a dynamic section" 0 "GNU_HASH"
for tag in NEEDED INIT FINI TEXTREL; do lacks "elf64: no $tag" "$tag"; done
run readelf -rW "$module"
expect "elf64: no relocation" 0 "no relocations"
run "$tgm" check "$module"
expect "elf64: passes" 0 "RESULT: PASS"

registers='SERVO[0].Position,SERVO[0].WritePosition,SERVO[0].Mode,SERVO[0].Control,SERVO[0].Status,SERVO[0].EtherCATState,DIO[0].In0,DIO[0].Out0'
for cycle in 250 500 1000; do
    for language in c elf64; do
        run "$tgm" run "$work/$language/shuttle.tgm" --for 5s --cycle $cycle --record "$registers" --csv "$work/$language.csv"
        expect "it runs: $language, $cycle us" 0
        grep -v 'real time' "$out" >"$work/$language.said"
    done
    same "the same recording as in C, $cycle us" "$work/c.csv" "$work/elf64.csv"
    same "the same console messages as in C, $cycle us" "$work/c.said" "$work/elf64.said"
done
[ "$(wc -l <"$work/c.csv")" -gt 5000 ] && pass "a recording of 5000 cycles" || fail "a recording of 5000 cycles"

# Without the harness, so that PE modules and generation 5 run, too; with a drive fault in it.
for layout in 4: 5:905 5:906; do
    id=${layout#*:}
    run gcc -std=gnu11 -O1 -Wall -Wextra -Werror -I sdk/include -DTGM_GENERATION="${layout%%:*}" ${id:+-DTGM_MEMORY_ID=$id} \
        -o "$work/rig${id:+-$id}" tests/pascal_rig.c
    expect "the rig builds, generation $layout" 0
    for language in c $targets; do
        "$work/rig${id:+-$id}" machine "$work/$language${id:+-$id}/shuttle.tgm" >"$work/$language${id:+-$id}.bits" 2>&1
    done
    for text in 'not started: compiled for TG Motion compatibility id' 'one servo and one I/O unit are needed' \
        'shuttle 1.00 started, cycle 500 us' 'drive fault' '^9999 '; do
        grep -q "$text" "$work/c${id:+-$id}.bits" && pass "$layout: $text" || fail "$layout: $text"
    done
    for target in $targets; do
        same "$target, generation $layout: 10000 set-points and the console are C's to the last bit" \
            "$work/c${id:+-$id}.bits" "$work/$target${id:+-$id}.bits"
    done
done

case $targets in *pe64*)
    module=$work/pe64/shuttle.tgm
    x86_64-w64-mingw32-objdump -p "$module" >"$work/pe"
    awk '/\[Ordinal\/Name Pointer\] Table/ {on = 1; next} on && /^\t\[/ {print $NF; next} on && NF == 0 {on = 0}' "$work/pe" |
        sort >"$work/exports"
    same "pe64: exactly the six exports" "$work/six" "$work/exports"
    run grep "DLL Name" "$work/pe"
    expect "pe64: nothing imported" 1
    run awk '/^Entry 9 / {print $3}' "$work/pe"
    expect "pe64: no thread-local storage" 0 00000000
    run x86_64-w64-mingw32-objdump -h "$module"
    expect "pe64: constants are read-only" 0 " .rdata"
    lacks "pe64: no writable data with a value" " .data "
    lacks "pe64: no section of the compiler's own" ".rodata"
    ;;
esac

# --- every member of every structure, by running both ----------------------------------------------

mkdir "$work/probe"
cat >"$work/probe/Makefile" <<EOF
SDK := $root/sdk
MODULE := probe
SOURCES := probe.pas
include \$(SDK)/mk/pascal.mk
EOF
printf 'EXPORTS\n    pascal_probe\n' >"$work/probe/probe.def"
for generation in gen4:4:0 gen5_905:5:905 gen5_906:5:906; do
    unit=${generation%%:*}
    id=${generation##*:}
    run tests/pascal_probe.py "$unit" "$work/probe"
    rows=$(cat "$out")
    run gcc -std=gnu11 -Werror -I sdk/include -DTGM_GENERATION="$(echo "$generation" | cut -d: -f2)" \
        $([ "$id" = 0 ] || echo "-DTGM_MEMORY_ID=$id") -DROWS="\"$work/probe/rows.h\"" -o "$work/probe/rig" tests/pascal_rig.c
    expect "$unit: C's rows" 0
    for target in $targets; do
        run make -C "$work/probe" BUILD="$work/probe/$target" TARGET=$target "$work/probe/$target/obj/probe.o"
        expect "$unit: Pascal's rows, $target" 0
        case $target in
        elf64) gcc -shared -nostdlib -o "$work/probe/probe.bin" "$work/probe/$target/obj/probe.o" ;;
        pe64) x86_64-w64-mingw32-gcc -shared -nostdlib -Wl,-e,0 -Wl,--gc-sections -o "$work/probe/probe.bin" "$work/probe/$target/obj/probe.o" \
            "$work/probe/probe.def" ;;
        esac
        run "$work/probe/rig" probe "$work/probe/probe.bin"
        expect "$unit, $target: every offset and size is C's" 0 "$rows rows, 0 differ"
    done
done

# --- what is refused, and how it is said ------------------------------------------------------------

mkdir "$work/m"
sed 's/probe/wrong/' "$work/probe/Makefile" >"$work/m/Makefile"
last=$(grep -n '^implementation' "$template" | cut -d: -f1)

# body TEXT: the template with a procedure of one line, which Program_02 calls; the line is number $line
body() {
    awk -v text="$1" '/^unit shuttle/ {print "unit wrong;"; next}
        /^function Program_Ini/ && seen++ {print text}
        {gsub(/shuttle\.ACCELERATION/, "wrong.ACCELERATION"); print}
        /^function Program_02/ && begun++ {getline; print; print "  Extra;"}' "$template" >"$work/m/wrong.pas"
    line=$(grep -nF -- "$1" "$work/m/wrong.pas" | head -n 1 | cut -d: -f1)
}

# refused NAME TEXT...: wrong.pas does not become a module; the messages hold the texts
refused() {
    name=$1
    shift
    rm -rf "$work/m/build"
    run make -C "$work/m"
    if [ -e "$work/m/build/wrong.tgm" ]; then
        fail "$name: a module was made"
    else
        expect "$name" 2 "$@"
    fi
}

body 'procedure Extra; begin Inc(plc.strokes, Round(Int(Frac(Double(7.5)) * 4)) + Trunc(Sqrt(Double(16)))); Dec(plc.strokes, 6); end;'
run make -C "$work/m"
expect "numbers work" 0
run "$tgm" run "$work/m/build/wrong.tgm" --for 5s --record "$registers" --csv "$work/numbers.csv"
"$tgm" run "$work/c/shuttle.tgm" --for 5s --record "$registers" --csv "$work/c.csv" >/dev/null 2>&1
same "and change nothing" "$work/c.csv" "$work/numbers.csv"

if [ -f third_party/musl/src/math/sin.c ]; then
    body 'procedure Extra; begin if (Abs(Sin(Double(0.5)) - Double(0.47942553860420300027)) > Double(1e-15)) or (Power(2, 10) <> 1024) or (ArcTan2(1, -1) < Double(2.35619449)) or (Floor(Double(-2.5)) <> -3) then plc.dio^.Out0 := 77; end;'
    sed -i 's/^  tgm_sdk;/  tgm_sdk, tgm_math;/; s/^  WriteOutputs(now);/&\n  Extra;/' "$work/m/wrong.pas"
    for target in $targets; do
        run make -C "$work/m" MATH=yes BUILD="$work/m/math-$target" TARGET=$target
        expect "Sin, Power and their kind link ($target)" 0 "MATH"
        "$work/rig" machine "$work/m/math-$target/wrong.tgm" >"$work/math.bits" 2>&1
        same "and compute ($target)" "$work/c.bits" "$work/math.bits"
    done
else
    echo "SKIP    Pascal's tgm_math: no musl sources (third_party/fetch.sh musl)"
fi

# The support library: bits of I/O units, a timer, an edge, a ramp, a move, text, each with what it gives.
body 'procedure Extra; var ton: tgm_ton; e: tgm_edge; r: tgm_ramp; m: tgm_move; t: tgm_text; b: array[0..15] of WideChar; w: array[0..15] of LongInt; good: Boolean; i: LongInt; begin FillChar(w, SizeOf(w), 0); tgm_dio4_set(@w[0], 9, 1); tgm_ton_init(ton, 1000); tgm_edge_init(e, 0); tgm_ramp_init(r, 0, 10, 10); tgm_move_init(m, 0, 1000); good := (w[1] = 2) and (tgm_dio4_get(@w[0], 9) = 1) and (tgm_ton_step(ton, 1, 500) = 0) and (tgm_ton_step(ton, 1, 500) = 0) and (tgm_ton_step(ton, 1, 500) = 1) and (tgm_edge_step(e, 1) = TGM_EDGE_RISING) and (tgm_ramp_step(r, 5, 500000) = 5) and (tgm_move_limits(m, 100, 1000, 1000) = 1) and (tgm_move_to(m, 7) = 1); for i := 1 to 1000 do tgm_move_step(m); good := good and (m.position = 7) and (tgm_move_done(m) = 1); tgm_text_init(t, b, 16); tgm_text_fixed(t, Double(-12.5), 3, 8, PAD); good := good and (t.length = 8) and (b[1] = #45) and (t.truncated = 0); if not good then plc.dio^.Out0 := 77; end;'
sed -i "s/ PAD)/ ' ')/; s/^  WriteOutputs(now);/&\n  Extra;/" "$work/m/wrong.pas"
for target in $targets; do
    run make -C "$work/m" BUILD="$work/m/sdk-$target" TARGET=$target
    expect "the support library links ($target)" 0
    "$work/rig" machine "$work/m/sdk-$target/wrong.tgm" >"$work/sdk.bits" 2>&1
    same "and works ($target)" "$work/c.bits" "$work/sdk.bits"
done

body 'procedure Extra; var s: AnsiString; begin s := '"'x'"'; end;'
refused "AnsiString" "wrong.pas:$line:" "error: AnsiString: a string needs a heap" "use PWideChar"
body 'procedure Extra; var s: string; begin s := '"'x'"'; end;'
refused "string" "wrong.pas:$line:" "error: a string needs a heap and a run-time library"
body '{$H+} procedure Extra; var s, t: string; begin s := s + t; end;'
refused "long strings" "wrong.pas:$line:" "error: a string needs a heap and a run-time library"
body 'procedure Extra; var p: Pointer; begin GetMem(p, 10); end;'
refused "GetMem" "wrong.pas:$line:" "error: GetMem: there is no heap"
body 'procedure Extra; var p: ^LongInt; begin New(p); end;'
refused "New" "wrong.pas:$line:" "error: New: there is no heap"
body 'procedure Extra; var a: array of LongInt; begin SetLength(a, 3); end;'
refused "dynamic array" "wrong.pas:$line:" "error: a dynamic array or a string needs a heap"
body 'procedure Extra; begin WriteLn(1); end;'
refused "WriteLn" "wrong.pas:$line:" "error: there is no console and no file; build text with tgm_sdk"
body 'procedure Extra; begin try plc.pause := 0; except end; end;'
refused "try and except" "wrong.pas:$line:" "error: exceptions need a run-time library"
body 'type C = class end; procedure Extra; begin end;'
refused "class" "wrong.pas:$line:" "error: a class needs a heap"
body 'threadvar t: LongInt; procedure Extra; begin t := 1; end;'
refused "threadvar" "error: a threadvar needs an operating system"
body 'procedure Extra; var e: Extended; begin e := 1; plc.pause := e; end;'
refused "Extended" "wrong.pas:$line:" "error: Extended: 80 bits exist on one target only; use Double"
body 'procedure Extra; begin plc.pause := plc.pause * 0.1; end;'
refused "a constant that makes it 80 bits" "wrong.pas:$line: error: extended: computed in 80 bits" "Double(0.1)"
body 'var start: LongInt = 5; procedure Extra; begin Inc(start); end;'
refused "initial value" "wrong.pas:$line: error: start: has an initial value" "Program_Ini"
body '{$J+} const count: LongInt = 5; procedure Extra; begin Inc(count); end;'
refused "writable constant" "wrong.pas:$line: error: count: has an initial value"
body 'const table: array[0..2] of Double = (1, 2, 3); procedure Extra; begin plc.pause := table[plc.strokes mod 3]; end;'
run make -C "$work/m"
expect "a table of constants is allowed" 0
run "$tgm" check "$work/m/build/wrong.tgm" --cycles 200
expect "and is read-only, so that it keeps its values" 0 "RESULT: PASS"
body '{$R+} procedure Extra; begin plc.told := plc.told * plc.strokes; end;'
refused "range checks" "wrong.pas:$line:" "error: run-time checks ({\$R+}, {\$S+}) need a run-time library"
body '{$Q+} procedure Extra; begin Inc(plc.strokes, plc.told); plc.told := plc.told * plc.strokes; end;'
refused "overflow checks" "wrong.pas:$line: error: {\$Q+}: overflow checks need a run-time library"
body 'procedure Extra; var big: array[0..99999] of Byte; i: LongInt; begin for i := 0 to 99999 do big[i] := i and 255; plc.pause := plc.pause + 0 * big[plc.strokes]; end;'
for target in $targets; do
    run make -C "$work/m" BUILD="$work/m/big-$target" TARGET=$target
    expect "100000 bytes of stack need no helper of the compiler ($target)" 0
done
body 'procedure nowhere; cdecl; external name '"'nowhere'"'; procedure Extra; begin nowhere; end;'
refused "undefined symbol" "error: nowhere: defined nowhere"

body 'procedure Extra; begin end;'
sed -i "s/public name 'Program_01'/public name 'program_01'/" "$work/m/wrong.pas"
line=$(grep -n '^function Program_01' "$work/m/wrong.pas" | tail -n 1 | cut -d: -f1)
refused "wrong letter case" "wrong.pas:$((line + 4)): error: program_01" "it must be Program_01"
run make -C "$work/m" check CHECK_FLAGS='--cycles 200'
expect "wrong letter case: make check says so" 2 "FAIL  export-names" "program_01" "RESULT: FAIL"
body 'procedure Extra; begin end;'
sed -i "s/ public name 'Program_01';//" "$work/m/wrong.pas"
line=$(grep -n '^function Program_01' "$work/m/wrong.pas" | head -n 1 | cut -d: -f1)
refused "not exported" "wrong.pas:$line: error: Program_01: not exported" "public name 'Program_01'"
body 'procedure Extra; begin end;'
sed -i "s/^implementation/procedure Seventh; cdecl; public name 'Program_06';\n&/; s/^procedure Extra;/procedure Seventh; cdecl; begin end;\n&/" "$work/m/wrong.pas"
refused "seventh export" "error: Program_06: is visible outside"
body 'procedure Extra; begin end;'
sed -i '$d' "$work/m/wrong.pas"
printf 'initialization\n  plc.pause := 0;\nend.\n' >>"$work/m/wrong.pas"
line=$(grep -n '^initialization' "$work/m/wrong.pas" | cut -d: -f1)
refused "initialization section" "wrong.pas:$line: error: initialization: TG Motion never runs this section"
body 'procedure Extra; begin end;'
sed -i 's/^unit wrong;/library wrong;/; /^interface$/d; /^implementation$/d; s/ public name .Program_0*.;//' "$work/m/wrong.pas"
awk '/^function Program_/ && !seen[$2]++ {next} {print}' "$work/m/wrong.pas" >"$work/m/x" && mv "$work/m/x" "$work/m/wrong.pas"
sed -i '$d' "$work/m/wrong.pas"
printf 'exports Program_Ini;\nbegin\nend.\n' >>"$work/m/wrong.pas"
refused "library instead of unit" "wrong.pas:12: error: a module is a unit, not a library"
run make -C "$work/m" TARGET=pdp11
expect "an unknown target" 2 "TARGET is 'pdp11'; allowed for Pascal: elf64 pe64"
run make -C "$work/m" clean
run make -C "$work/m" FPC=no-such-compiler
expect "no compiler: what to install" 2 "no Free Pascal compiler 'no-such-compiler'" "fp-compiler"

# --- the generated units -----------------------------------------------------------------------------

run tools/layout.py --check
expect "the generated units are up to date" 0
mkdir "$work/tree" && cp -R sdk tools docs "$work/tree/" && mkdir -p "$work/tree/harness/host" "$work/tree/tests" &&
    cp harness/host/catalogue_*.inc "$work/tree/harness/host/" && cp -R tests/layouts "$work/tree/tests/"
sed -i 's/Position: Double; \/\/ @472/Position: Single; \/\/ @472/' "$work/tree/sdk/pascal/tgm_gen4.pas"
run "$work/tree/tools/layout.py" --check
expect "a unit edited by hand is noticed" 1 "out of date: sdk/pascal/tgm_gen4.pas;"
sed -i 's/^SERVO\tPositionReserve\t/&/; s/^SERVO\tWritePosition\t/SERVO\tPOSITION\t/' "$work/tree/sdk/layout/tgm4.tsv"
run "$work/tree/tools/layout.py" --check
expect "two names that are one in Pascal are refused" 1 "are one name in Pascal"

finish
