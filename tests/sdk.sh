#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# What the SDK refuses to link, and how it says so: symbol and source line.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
root=$PWD
tgm=$root/${BUILD:-build}/tgm
template=$root/templates/c/shuttle.c

mkdir "$work/m"
cat >"$work/m/Makefile" <<EOF
SDK := $root/sdk
MODULE := sin
SOURCES := sin.c
TGM := $tgm
include \$(SDK)/mk/module.mk
EOF

# refused NAME TEXT...: sin.c does not become a module; the messages hold the texts
refused() {
    name=$1
    shift
    rm -rf "$work/m/build"
    run make -C "$work/m"
    if [ -e "$work/m/build/sin.tgm" ]; then
        fail "$name: a module was made"
    else
        expect "$name" 2 "$@"
    fi
}
with() { # text: the template and this behind it
    { cat "$template"; printf '%s\n' "$1"; } >"$work/m/sin.c"
}
last=$(($(wc -l <"$template") + 1))

for cc in gcc clang; do
    cp "$template" "$work/m/sin.c"
    rm -rf "$work/m/build"
    run make -C "$work/m" CC=$cc
    expect "the template builds with $cc" 0
    run "$tgm" check "$work/m/build/sin.tgm" --cycles 200
    expect "and passes when built with $cc" 0 "RESULT: PASS"
done
rm -rf "$work/m/build"
run make -C "$work/m" CC=clang MODULE_LDFLAGS=-fuse-ld=lld
expect "the template builds with lld" 0
run "$tgm" check "$work/m/build/sin.tgm" --cycles 200
expect "and passes when linked with lld" 0 "RESULT: PASS"

# A module without any data of its own.
cat >"$work/m/sin.c" <<'EOF'
#include <tgm_plc.h>
long Program_Ini(PLC_DATA *pData) { return pData != NULL; }
long Program_01(PLC_DATA *pData) { (void)pData; return 1; }
long Program_02(PLC_DATA *pData) { (void)pData; return 1; }
long Program_03(PLC_DATA *pData) { (void)pData; return 1; }
long Program_04(PLC_DATA *pData) { (void)pData; return 1; }
long Program_05(PLC_DATA *pData) { (void)pData; return 1; }
EOF
rm -rf "$work/m/build"
run make -C "$work/m" check CHECK_FLAGS='--cycles 20'
expect "a module without data is read, and judged" 2 "file      22 passed" "FAIL  ini-body"

# What is built follows what it is built with.
cp "$template" "$work/m/sin.c"
run make -C "$work/m"
before=$(cksum <"$work/m/build/sin.tgm")
run make -C "$work/m"
lacks "nothing changed, nothing is done" "CC "
run make -C "$work/m" MODULE_CFLAGS=-O0
[ "$before" != "$(cksum <"$work/m/build/sin.tgm")" ] && pass "other flags build anew" || fail "other flags build anew"
run make -C "$work/m" TGM_GENERATION=5
[ "$before" != "$(cksum <"$work/m/build/sin.tgm")" ] && pass "another generation builds anew" || fail "another generation builds anew"
run make -C "$work/m" TGM_GENERATION=5 check
expect "generation 5 is judged as what it is" 0 "RESULT: PASS" "profile=pc5"
for target in pe64 pe32 tgmmini tgmcontroller; do
    profile=pc4
    case $target in tgm*) profile=$target ;; esac
    run make -C "$work/m" TARGET=$target check
    expect "the template is judged as built for $target" 0 "RESULT: PASS" "profile=$profile"
done
run make -C "$work/m" TARGET=pe64 debug
expect "a debugger has nothing to do with another target" 2 "debug is for TARGET=elf64"

line=$(grep -n '^long Program_01' "$template" | cut -d: -f1)
sed 's/^long Program_01/long program_01/' "$template" >"$work/m/sin.c"
refused "wrong letter case" "sin.c:$line: error: program_01" "Program_01"
run make -C "$work/m" check
expect "wrong letter case: make check says so" 2 "FAIL  export-names" "program_01" "sin.c:$line" "RESULT: FAIL" "Error 1"

# In a section that the linker keeps: what nobody calls is dropped together with what it calls.
keep='__attribute__((used, section(".text.Program_kept"))) static'
with "int printf(const char *, ...); $keep"' void f(void) { printf("x"); }'
refused "undefined symbol" "sin.c:$last: error: printf: defined nowhere"
with "double sin(double); $keep"' double f(double x) { return sin(x); }'
refused "mathematics without MATH" "sin.c:$last: error: sin: not in the module; set MATH := yes"
sed 's/^long Program_05/long Program_5/' "$template" >"$work/m/sin.c"
refused "a name that comes near" "error: Program_5: not one of the six names"
with 'extern int maybe(void) __attribute__((weak)); __attribute__((used)) static int f(void) { return maybe ? maybe() : 0; }'
refused "weak undefined symbol" "sin.c:$last: error: maybe: weak and defined nowhere"
with 'static volatile int k; __attribute__((constructor)) static void boot(void) { k = 1; }'
refused "constructor" "sin.c:$last: error: boot: constructor"
with '__thread int tl; __attribute__((used)) static int f(void) { return tl; }'
refused "thread-local storage" "sin.c" "error: tl: thread-local"
with 'static int g(void) { return 1; } static int (*r(void))(void) { return g; } int i(void) __attribute__((ifunc("r"))); __attribute__((used)) static int f(void) { return i(); }'
refused "indirect function" "sin.c:$last: error: i: indirect function"
with 'TGM_EXPORT long Program_06(PLC_DATA *p); long Program_06(PLC_DATA *p) { (void)p; return 1; }'
refused "seventh export" "sin.c:$last: error: Program_06: is visible outside"
sed 's/^long Program_05/static __attribute__((used)) long other/' "$template" >"$work/m/sin.c"
refused "missing function" "error: Program_05: missing"

# C++: a global that only code can initialise, on every target, whichever way its format keeps the code.
start='__attribute__((noinline)) static int start() { int n; __asm__ volatile("" : "=r"(n)); return n; }'
cpp_last=$(($(wc -l <templates/cpp/shuttle.cpp) + 1))
sed 's/sin\.c$/sin.cpp/' "$work/m/Makefile" >"$work/m/Makefile.cpp"
rm "$work/m/sin.c" # both would become sin.o
for target in elf64:g++ pe64:x86_64-w64-mingw32-g++ pe32:i686-w64-mingw32-g++ tgmmini:arm-linux-gnueabihf-g++ \
    tgmcontroller:arm-none-eabi-g++; do
    command -v "${target#*:}" >/dev/null || continue
    target=${target%%:*}
    for variable in 'speed:static volatile int speed = start();' 'shared_speed:extern int shared_speed; int shared_speed = start();' \
        'gear:namespace { struct Gear { int teeth; Gear() : teeth(start()) {} }; } static volatile Gear gear;'; do
        { cat templates/cpp/shuttle.cpp; printf '%s %s\n' "$start" "${variable#*:}"; } >"$work/m/sin.cpp"
        run make -C "$work/m" -f Makefile.cpp TARGET="$target" BUILD="b-$target"
        expect "$target: a global initialised by code, ${variable%%:*}" 2 \
            "sin.cpp:$cpp_last: error: ${variable%%:*}: initialised by code that TG Motion never runs"
        ls "$work/m/b-$target"/sin.tgm* >/dev/null 2>&1 && fail "$target: a module was made" || pass "$target: no module is made"
    done
done

# The header alone, in every dialect that an author may use.
cat >"$work/alone.c" <<'EOF'
#include <tgm_plc.h>
long Program_Ini(PLC_DATA *pData)
{
    HEADER *pHeader = (HEADER *)pData->PSystem_Memory;
    return pHeader->Compatibility_Id == ID_COMPATIBILITY;
}
EOF
printf '#include <tgm_plc.h>\n' >"$work/alone5.c"
for compiler in "gcc -std=c11" "gcc -std=c17" "clang -std=c11" "clang -std=c17" "gcc -x c++ -std=c++17" "clang -x c++ -std=c++17" \
    "clang -target i686-pc-windows-msvc -std=c11 -fms-extensions" "clang -target armv7a-none-eabi -std=c11"; do
    # shellcheck disable=SC2086
    run $compiler -fsyntax-only -ffreestanding -fshort-wchar -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror \
        -I sdk/include "$work/alone.c"
    expect "the header alone: $compiler" 0
done
# All headers of the SDK, on all compilers, in every dialect and layout.
for header in start text motion math; do printf '#include <tgm/%s.h>\n' $header; done >"$work/all.c"
cp "$work/all.c" "$work/all.cpp"
for compiler in "gcc -fshort-wchar" "clang -fshort-wchar" x86_64-w64-mingw32-gcc i686-w64-mingw32-gcc "arm-none-eabi-gcc -DTGM_TEXT8" \
    "arm-linux-gnueabihf-gcc -DTGM_TEXT8" "gcc -m32 -fshort-wchar" "clang -target i686-pc-windows-msvc -fms-extensions" \
    "clang -target armv7a-none-eabi -DTGM_TEXT8"; do
    : >"$work/refused"
    for dialect in "-std=c11 $work/all.c" "-std=c17 $work/all.c" "-x c++ -std=c++17 $work/all.cpp"; do
        for layout in 4 "5 -DTGM_MEMORY_ID=905" "5 -DTGM_MEMORY_ID=906"; do
            # shellcheck disable=SC2086
            run $compiler -DTGM_GENERATION=$layout -ffreestanding -fsyntax-only -Wall -Wextra -Wpedantic -Wconversion -Wshadow \
                -Werror -I sdk/include $dialect
            [ "$status" = 0 ] || { echo "$compiler $dialect $layout"; head -n 3 "$err"; } >>"$work/refused"
        done
    done
    cp "$work/refused" "$err"
    [ ! -s "$err" ] && pass "every header, dialect and layout: $compiler" || fail "every header, dialect and layout: $compiler"
done
run gcc -std=c11 -fsyntax-only -I sdk/include "$work/alone.c"
expect "without -fshort-wchar the header says what to do" 1 "compile with -fshort-wchar"
# Sources in the manual's idiom, unchanged.
cat >"$work/idiom.c" <<'EOF'
#include <tgm_plc.h>
#define SIZE_INFO 100
static wchar_t info[SIZE_INFO];
static HEADER *pHeader;
long Program_Ini(PLC_DATA *pData)
{
    if (pData == NULL || pData->structSize != sizeof(PLC_DATA)) return 0;
    if (pData->functions.pRtWprintf_Long == NULL) return 0;
    if (pData->functions.pRtWprintf_String == NULL) return 0;
    if (pData->functions.pswprintf == NULL) return 0;
    if (pData->functions.pSleepFt == NULL) return 0;
    pHeader = (HEADER *)pData->PSystem_Memory;
    if (pHeader->Compatibility_Id != ID_COMPATIBILITY)
    {
        pData->functions.pswprintf(info, SIZE_INFO, L"PLC id = %d TGM id = %d\n", ID_COMPATIBILITY, pHeader->Compatibility_Id);
        pData->functions.pRtWprintf_String(info);
        return 0;
    }
    return 1;
}
long Program_02(PLC_DATA *pData)
{
    pData->functions.pRtWprintf_Long(L"%d\n", 5);
    return 1;
}
EOF
cat >"$work/names.c" <<'EOF'
#include <tgm_plc.h>
static LPCWSTR text = L"waiting\n";
static int _cdecl helper(PUCHAR bytes, ULONG count) { return count > 0 ? bytes[0] : FALSE; }
long Program_01(PLC_DATA *pData)
{
    LARGE_INTEGER pause;
    PLARGE_INTEGER p = &pause;
    UCHAR octet = 1;
    BOOL sent;
    p->QuadPart = 1000;
    pData->functions.pSleepFt(p);
    sent = pData->functions.pCAN_Transmit(1, 2, 1, &octet);
    pData->functions.pRtWprintf_String(text);
    return helper(&octet, 1) && sent == TRUE;
}
EOF
printf '#include <windows.h>\n#include <tgm_plc.h>\n' >"$work/before.c"
printf '#include <tgm_plc.h>\n#include <windows.h>\n' >"$work/after.c"
strict="-fsyntax-only -Wall -Wextra -Wshadow -Werror -I sdk/include"
for compiler in "gcc -std=c11 -ffreestanding -fshort-wchar" "clang -std=c17 -ffreestanding -fshort-wchar" \
    "x86_64-w64-mingw32-gcc -std=c11" "i686-w64-mingw32-gcc -std=c11" "gcc -x c++ -std=c++17 -ffreestanding -fshort-wchar"; do
    # shellcheck disable=SC2086
    run $compiler $strict "$work/idiom.c"
    expect "the manual's idiom: $compiler" 0
    # shellcheck disable=SC2086
    run $compiler $strict -DTGM_WINDOWS_NAMES "$work/names.c"
    expect "the manual's Windows names when asked for: $compiler" 0
done
run gcc -std=c11 -ffreestanding -fshort-wchar -fsyntax-only -I sdk/include "$work/names.c"
expect "and not when nobody asked" 1 "LPCWSTR"
# Such sources become modules, and what they print is what the manual's sample prints.
mkdir "$work/idiom"
cat >"$work/idiom/Makefile" <<EOF
SDK := $root/sdk
MODULE := idiom
SOURCES := idiom.c names.c
MODULE_CFLAGS := -DTGM_WINDOWS_NAMES
TGM := $tgm
include \$(SDK)/mk/module.mk
EOF
cp "$work/idiom.c" "$work/names.c" "$work/idiom/"
cat >>"$work/idiom/idiom.c" <<'EOF'
long Program_03(PLC_DATA *pData)
{
    pHeader = (HEADER *)pData->PSystem_Memory;
    pData->functions.pswprintf(info, SIZE_INFO, L"PLC id = %d TGM id = %d\n", ID_COMPATIBILITY, pHeader->Compatibility_Id);
    pData->functions.pRtWprintf_String(info);
    return 1;
}
long _cdecl Program_04(PLC_DATA *pData) { (void)pData; return 1; }
long _cdecl Program_05(PLC_DATA *pData) { (void)pData; return 1; }
EOF
for target in elf64 pe64 pe32; do
    run make -C "$work/idiom" TARGET=$target
    expect "the manual's idiom becomes a module: $target" 0 "VERIFY"
    lacks "without a warning: $target" warning
done
run "$tgm" run "$work/idiom/build/idiom.tgm" --for 20ms
expect "and prints what the manual's sample prints" 0 "PLC id = 4033 TGM id = 4033"
for compiler in "gcc -fshort-wchar" "clang -fshort-wchar" x86_64-w64-mingw32-gcc i686-w64-mingw32-gcc; do
    for file in idiom names; do
        # shellcheck disable=SC2086
        run $compiler -x c++ -std=c++17 $strict -DTGM_WINDOWS_NAMES "$work/$file.c"
        expect "$file in C++: $compiler" 0
    done
done
for order in before after; do
    { cat "$work/$order.c"; sed 's/^#include.*//' "$work/names.c"; } >"$work/both.c"
    for compiler in x86_64-w64-mingw32-gcc i686-w64-mingw32-gcc; do
        # shellcheck disable=SC2086
        run $compiler -std=c11 $strict -DTGM_WINDOWS_NAMES "$work/both.c"
        expect "the manual's names with windows.h $order: $compiler" 0
    done
done
for compiler in x86_64-w64-mingw32-gcc i686-w64-mingw32-gcc x86_64-w64-mingw32-g++ i686-w64-mingw32-g++; do
    for order in before after; do
        # shellcheck disable=SC2086
        run $compiler $strict "$work/$order.c"
        expect "windows.h $order: $compiler" 0
        # shellcheck disable=SC2086
        run $compiler $strict -DTGM_WINDOWS_NAMES "$work/$order.c"
        expect "windows.h $order, with the names: $compiler" 0
    done
done

# Every row of every table, on every target, in every dialect.
rows() { # what compiler...
    what=$1
    shift
    for layout in gen4: gen5_905:905 gen5_906:906; do
        id=${layout#*:}
        flags="-DTGM_GENERATION=4"
        [ -z "$id" ] || flags="-DTGM_GENERATION=5 -DTGM_MEMORY_ID=$id"
        # shellcheck disable=SC2086
        run "$@" $flags -fsyntax-only -ffreestanding -Wall -Wextra -Werror -I sdk/include "tests/layouts/asserts_${layout%%:*}.c"
        expect "every row of ${layout%%:*}: $what" 0
    done
}
rows "x86-64 gcc C11" gcc -std=c11 -fshort-wchar
rows "x86-64 clang C17" clang -std=c17 -fshort-wchar
rows "x86-64 g++ C++17" gcc -x c++ -std=c++17 -fshort-wchar -D_Static_assert=static_assert
rows "x86-64 clang++ C++17" clang -x c++ -std=c++17 -fshort-wchar -D_Static_assert=static_assert
rows "x86-64 Windows mingw" x86_64-w64-mingw32-gcc -std=c11
rows "i386 Windows mingw" i686-w64-mingw32-gcc -std=c11
rows "i386 Windows mingw C++17" i686-w64-mingw32-g++ -x c++ -std=c++17 -D_Static_assert=static_assert
rows "Arm bare metal" arm-none-eabi-gcc -std=c11 -DTGM_TEXT8
rows "Arm Linux" arm-linux-gnueabihf-gcc -std=c17 -DTGM_TEXT8
rows "Arm Linux C++17" arm-linux-gnueabihf-g++ -x c++ -std=c++17 -DTGM_TEXT8 -D_Static_assert=static_assert
rows "i386 System V" gcc -m32 -std=c11 -fshort-wchar
[ "$(grep -c _Static_assert tests/layouts/asserts_gen5_906.c)" = "$(($(wc -l <sdk/layout/tgm5-906.tsv) - 1))" ] &&
    pass "one assert a row" || fail "one assert a row"
# The support library keeps nothing: no variables, no errno, no heap, nothing from outside but its own functions.
for target in elf64 pe64 pe32 tgmmini tgmcontroller; do
    case $target in
    pe64) prefix=x86_64-w64-mingw32- ;;
    pe32) prefix=i686-w64-mingw32- ;;
    tgmmini) prefix=arm-linux-gnueabihf- ;;
    tgmcontroller) prefix=arm-none-eabi- ;;
    *) prefix= ;;
    esac
    run make -C templates/c TARGET=$target BUILD="$work/own/$target"
    expect "the support library is built for $target" 0 "VERIFY"
    for object in mem text16 text8 number motion move start; do
        "${prefix}nm" "$work/own/$target/sdk/$object.o"
    done >"$work/symbols"
    awk '{kind = $(NF - 1); name = $NF}
        kind ~ /^[BbCDdGgSsVvWw]$/ && name !~ /^\.(data|bss)/ {print kind, name}
        kind == "U" && name !~ /^_?(tgm_|mem(cpy|move|set|cmp)$|_?_(aeabi_|udiv|umod|div|mod)|_GLOBAL_OFFSET_TABLE_$)/ {print kind, name}' \
        "$work/symbols" >"$out"
    [ -s "$work/symbols" ] && [ ! -s "$out" ] && pass "the support library has no variables and needs nothing: $target" ||
        fail "the support library has no variables and needs nothing: $target"
done
run grep -rnE '\b(errno|malloc|calloc|realloc|free) *[(=;]' sdk/src --include=*.c --include=*.h --include=*.cpp
expect "no errno and no heap in its source" 1

# Other packing: generation 4 has every member at a multiple of its size, so that packing changes nothing; in
# generation 5 (CNC) it does, and does not compile. Other alignment never does.
for pack in 1 2 4 8; do
    for layout in "4" "5 -DTGM_MEMORY_ID=905" "5 -DTGM_MEMORY_ID=906"; do
        { echo "#pragma pack($pack)"; cat "$work/alone5.c"; } >"$work/packed.c"
        for compiler in gcc clang; do
            # shellcheck disable=SC2086
            run $compiler -DTGM_GENERATION=$layout -std=c11 -fsyntax-only -ffreestanding -fshort-wchar -I sdk/include "$work/packed.c"
            case "$layout $pack" in
            4* | *8) expect "packed to $pack is the same layout ($compiler, generation $layout)" 0 ;;
            *) expect "packed to $pack does not compile ($compiler, generation $layout)" 1 "Pxx is not where TG Motion has it" ;;
            esac
        done
    done
done
run gcc -m32 -malign-double -std=c11 -fsyntax-only -ffreestanding -fshort-wchar -DTGM_GENERATION=5 -I sdk/include "$work/alone5.c"
expect "other alignment does not compile" 1 "is not where TG Motion has it"

sed 's/double Position;/float Position;/' sdk/include/tgm/layout_gen4.h >"$work/layout.h"
mkdir -p "$work/inc/tgm" && cp sdk/include/tgm_plc.h "$work/inc/" && cp "$work/layout.h" "$work/inc/tgm/layout_gen4.h"
run gcc -std=c11 -fsyntax-only -fshort-wchar -I "$work/inc" "$work/alone.c"
expect "a field of the wrong size does not compile" 1 "SERVO.Position does not have TG Motion"

# Generated files follow the tables.
run tools/layout.py --check
expect "generated layouts are up to date" 0
mkdir "$work/tree" && cp -R sdk tools docs "$work/tree/" && mkdir -p "$work/tree/harness/host" "$work/tree/tests" &&
    cp harness/host/catalogue_*.inc "$work/tree/harness/host/" && cp -R tests/layouts "$work/tree/tests/"
run "$work/tree/tools/layout.py" --check
expect "and so they are in a copy of the tree" 0
sed -i '/^SERVO\tWritePosition\t/d' "$work/tree/sdk/layout/tgm4.tsv"
run "$work/tree/tools/layout.py" --check
expect "a row that was taken away is noticed" 1 "out of date" "layout_gen4.h"
sed -i 's/^SERVO\tPosition\tdouble\t1\t472\t/SERVO\tPosition\tdouble\t1\t460\t/' "$work/tree/sdk/layout/tgm4.tsv"
run "$work/tree/tools/layout.py" --check
expect "a row that overlaps is refused by name" 1 "SERVO.Position" "overlaps"

# Every member says unit, access and meaning, every constant its meaning: a row that does not is refused.
# broken NAME TABLE ROW COLUMN VALUE TEXT...: the table with another value in a column of a row
broken() {
    what=$1
    table=$2
    cp sdk/layout/*.tsv "$work/tree/sdk/layout/"
    awk -F'\t' -v OFS='\t' -v row="$3" -v column="$4" -v value="$5" 'index($0, row "\t") == 1 {$column = value} {print}' \
        "sdk/layout/$table" >"$work/tree/sdk/layout/$table"
    shift 5
    run "$work/tree/tools/layout.py" --check
    expect "$what" 1 "$@"
}
servo=$(printf 'SERVO\tSpeed')
broken "a member without access" tgm4.tsv "$servo" 9 '?' "tgm4.tsv: SERVO.Speed: access is '?'"
broken "a member without unit" tgm5-905.tsv "$servo" 10 '' "tgm5-905.tsv: SERVO.Speed: no unit"
broken "a member without meaning" tgm5-906.tsv "$servo" 12 '' "tgm5-906.tsv: SERVO.Speed: '' is no meaning"
broken "a member with the name of a chapter for a meaning" tgm5-906.tsv "$servo" 12 'the osc chapter' "is no meaning"
broken "a structure with an access of its own" tgm4.tsv "$(printf 'SERVO\tPg')" 9 'R' "SERVO.Pg: access 'parts' is for"
broken "a constant without meaning" constants.tsv PLC_CTRL_LOAD_BIT 5 '-' "PLC_CTRL_LOAD_BIT: '-' is no meaning"
broken "a constant with the name of a register for a meaning" constants.tsv PLC_CTRL_LOAD_BIT 5 'MAIN.PLC_Ctrl' "is no meaning"
cp sdk/layout/*.tsv "$work/tree/sdk/layout/"
for header in gen4 gen5_905 gen5_906; do
    awk '/^typedef struct _/ {on = 1; next} /^}/ {on = 0} on' sdk/include/tgm/layout_$header.h >"$out"
    grep -vE '; /\* @[0-9]+( \(5\.00\))? (R|W|RW|reserved|parts)( \(L5\))?, [^:]+: .+ \*/$' "$out" >"$err"
    rows=$(wc -l <"$out")
    [ "$rows" -gt 300 ] && [ ! -s "$err" ] && pass "$header.h: all $rows members say unit, access and meaning" ||
        fail "$header.h: all $rows members say unit, access and meaning"
    grep -E '^#define ' sdk/include/tgm/layout_$header.h | grep -vE '/\* .*[^ ] [^ ].* \*/$' | grep -vE '^#define TGM_LAYOUT_[A-Z0-9_]+_H$' >"$err"
    [ ! -s "$err" ] && pass "$header.h: all constants say what they mean" || fail "$header.h: all constants say what they mean"
done

# The register reference at hand, for every layout.
run "$tgm" registers User_PDO_Output_Size --generation 5
expect "registers of 5.02" 0 "GENERAL.general_devices[16].User_PDO_Output_Size" " 488 " "byte"
run "$tgm" registers User_PDO_Output_Size --generation 5 --memory-id 905
expect "registers of 5.00" 0 " 504 "
run "$tgm" registers TGM_General+1512 --generation 5
expect "registers by offset inside an array of structures" 0 "User_PDO_Output_Size"
run "$tgm" registers Servo_Tick --generation 5
expect "an access that is ours is marked" 0 "R (L5)"
run "$tgm" registers x --memory-id 905
expect "a memory id of another generation" 2 "generation 4 has no memory id 905; allowed: 904"

# Fetching: a wrong hash stops, an unpacked tree needs no network.
mkdir -p "$work/third_party/download" && cp third_party/fetch.sh third_party/soem.lock "$work/third_party/"
echo "not an archive" >"$work/third_party/download/pysoem-1.1.13.tar.gz"
run "$work/third_party/fetch.sh"
expect "an archive with a wrong hash is refused" 1 "is not the one that soem.lock pins" "expected sha256 4be98d85"
mkdir "$work/third_party/soem" && cp third_party/soem/.from "$work/third_party/soem/" && rm -rf "$work/third_party/download"
run env PATH=/usr/bin:/bin PYTHON=/nonexistent "$work/third_party/fetch.sh"
expect "an unpacked tree works offline" 0

# Installing: program and SDK, and a template that builds from there.
run make install PREFIX="$work/prefix" BUILD="$root/${BUILD:-build}"
expect "make install" 0
cp -R "$work/prefix/share/tgm/templates/c" "$work/mine"
run make -C "$work/mine" SDK="$work/prefix/share/tgm/sdk" TGM="$work/prefix/bin/tgm" check CHECK_FLAGS='--cycles 200'
expect "the installed template builds and passes" 0 "RESULT: PASS"
cd "$work" && run "$work/prefix/bin/tgm" new fresh
expect "tgm new from where it is installed" 0 "fresh/ is a project"
run make -C "$work/fresh" check CHECK_FLAGS='--cycles 200'
expect "and its project passes" 0 "RESULT: PASS"
run find "$work/prefix/share/tgm/fixtures" -type f ! -name '*.tgm' ! -name '*.tgm.bin' ! -name '*.scenario' ! -name expected
[ ! -s "$out" ] && pass "nothing but modules, scenarios and expectations is among the fixtures" || fail "nothing but modules, scenarios and expectations is among the fixtures"
run "$work/prefix/bin/tgm" selftest --own --rule 'ini-returns-one,no-imports,scenario'
expect "tgm selftest proves rules where it is installed" 0 "RESULT: PASS (3 rules, 0 of them not proven"

finish
