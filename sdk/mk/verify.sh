#!/bin/sh
# SPDX-License-Identifier: MIT
#
# verify.sh MODULE OBJECT... - what the linker cannot refuse, or refuses without naming the line.
#
# Reads the objects that a module was (or is to be) linked from, and the module itself when it exists.
# Every finding is one line "file:line: error: symbol: what is wrong; what to do". Exit 1 when there
# is any. TARGET as in module.mk; needs binutils of the target (NM, READELF, OBJDUMP, ADDR2LINE).
set -u
LC_ALL=C
export LC_ALL
NM=${NM:-nm}
READELF=${READELF:-readelf}
OBJDUMP=${OBJDUMP:-objdump}
ADDR2LINE=${ADDR2LINE:-addr2line}
TARGET=${TARGET:-elf64}
ENTRIES='Program_Ini Program_01 Program_02 Program_03 Program_04 Program_05'

case $TARGET in
pe*) format=pe ;;
tgmcontroller | tgzmotion) format=flat ;;
*) format=elf ;;
esac

module=$1
shift
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
: >"$work/findings"

finding() { # place symbol text
    printf '%s: error: %s: %s\n' "${1:-$module}" "$2" "$3" | sed "s|^$PWD//*||" >>"$work/findings"
}

# The C name of a linker symbol: 32-bit Windows puts an underscore before it.
plain() {
    if [ "$TARGET" = pe32 ]; then sed 's/\(^\|[ \t]\)_\([^ \t]*\)$/\1\2/'; else cat; fi
}

# type bind visibility section name, of every named symbol of an object. COFF has no visibility: what is
# exported is the business of the .def file, so nothing counts as visible there.
symbols() {
    if [ $format = pe ]; then
        # Not every compiler gives its functions a function's type: what lies in code is one.
        code=$("$OBJDUMP" -h "$1" | awk '$1 ~ /^[0-9]+$/ {n = $1 + 1} /CODE/ {printf " %d ", n}')
        "$OBJDUMP" -t "$1" | sed -n 's/^\[ *[0-9]*\](sec *\(-*[0-9]*\))(fl 0x[0-9a-f]*)(ty *\([0-9a-f]*\))(scl *\([0-9]*\)) (nx [0-9]*) 0x[0-9a-f]* \(.*\)$/\1 \2 \3 \4/p' |
            awk -v code="$code" '$1 == -2 || $4 ~ /^\./ {next}
                 {print ($2 == "20" || index(code, " " $1 " ") ? "FUNC" : "OBJECT"), ($3 == 105 ? "WEAK" : $3 == 2 ? "GLOBAL" : "LOCAL"), "HIDDEN", ($1 == 0 ? "UND" : $1), $4}' | plain
    else
        "$READELF" -sW "$1" | awk '$1 ~ /^[0-9]+:$/ && $8 != "" {print $4, $5, $6, $7, $8}'
    fi
}

# "name<TAB>file:line" of every symbol of an object; for an undefined one, the first line that uses it.
places() {
    "$NM" -l "$1" 2>/dev/null | awk -F'\t' '{n = split($1, w, " "); print $2 "\t" w[n]}' | plain | awk -F'\t' '{print $2 "\t" $1}'
}

place_of() { # object symbol; without line information, the source file that the object was made from
    found=$(places "$1" | awk -F'\t' -v s="$2" '$1 == s && $2 != "" {print $2; exit}')
    [ -n "$found" ] || [ $format = pe ] || found=$("$READELF" -sW "$1" | awk '$4 == "FILE" {print $8; exit}')
    printf '%s' "${found:-$1}"
}

check_names() { # object
    symbols "$1" | awk -v entries="$ENTRIES" '
        BEGIN { n = split(entries, e, " "); for (i = 1; i <= n; i++) { exact[e[i]] = 1; lower[tolower(e[i])] = e[i] } }
        $4 == "UND" || $1 == "SECTION" || $1 == "FILE" { next }
        $5 in exact { if ($1 != "FUNC") print "data", $5, $5; next }
        {
            bare = tolower($5); sub(/^_+/, "", bare); sub(/@.*/, "", bare)
            if (bare in lower) print "case", $5, lower[bare]
            else if ($5 ~ /^_Z[0-9]+[Pp][Rr][Oo][Gg][Rr][Aa][Mm]_/) print "mangled", $5, "-"
            else if ($1 == "FUNC" && $2 == "GLOBAL" && bare ~ /^program_?[0-9i]/ && $3 != "DEFAULT") print "near", $5, "-"
            else if ($3 == "DEFAULT" && $2 != "LOCAL" && $5 != "GetProcAddress" && $5 !~ /^_Zd[la]Pv/ && ($1 == "FUNC" || $1 == "OBJECT")) print "extra", $5, "-"
        }' >"$work/names"
    while read -r what name right; do
        case $what in
        case) finding "$(place_of "$1" "$name")" "$name" \
            "not a name TG Motion looks up, letter case and decoration count; it must be $right" ;;
        near) finding "$(place_of "$1" "$name")" "$name" "not one of the six names: $ENTRIES" ;;
        mangled) finding "$(place_of "$1" "$name")" "$name" \
            "a C++ name; declare the function extern \"C\" (tgm_plc.h does for the six names)" ;;
        data) finding "$(place_of "$1" "$name")" "$name" "is data; TG Motion calls it as a function" ;;
        extra) [ $format = flat ] || finding "$(place_of "$1" "$name")" "$name" \
            "is visible outside, a module exports exactly $ENTRIES; make it static or compile with -fvisibility=hidden" ;;
        esac
    done <"$work/names"
}

check_weak() { # object; a weak undefined symbol links silently and is null at run time
    symbols "$1" | awk '$4 == "UND" && $2 == "WEAK" {print $5}' | sort -u >"$work/weak"
    while read -r name; do
        grep -qxF "$name" "$work/defined" ||
            finding "$(place_of "$1" "$name")" "$name" \
                "weak and defined nowhere: a module imports nothing, at run time it is a null pointer"
    done <"$work/weak"
}

check_undefined() { # object; only before the link: afterwards the linker has said it
    symbols "$1" | awk '$4 == "UND" && $2 == "GLOBAL" {print $5}' | sort -u >"$work/undefined"
    while read -r name; do
        case $name in
        Program_Ini | Program_0[1-5]) continue ;; # said by name below
        sin | cos | tan | asin | acos | atan | atan2 | sinh | cosh | tanh | exp | exp2 | expm1 | log | log2 | log10 | log1p | pow | \
            sqrt | hypot | cbrt | floor | ceil | round | trunc | rint | fmod | remainder | fma | lround | llround)
            grep -qxF "$name" "$work/defined" || finding "$(place_of "$1" "$name")" "$name" \
                "not in the module; set MATH := yes in the Makefile to link the SDK's mathematics"
            continue
            ;;
        _GLOBAL_OFFSET_TABLE_ | tgm_bss_begin | tgm_bss_end | __aeabi_* | __*di3 | __*ti3 | __udivmod* | __divmod*) continue ;;
        esac
        grep -qxF "$name" "$work/defined" ||
            finding "$(place_of "$1" "$name")" "$name" "defined nowhere: a module is linked to nothing, write it yourself"
    done <"$work/undefined"
}

check_kinds() { # object
    if [ $format = pe ]; then
        "$OBJDUMP" -h "$1" | awk '$2 ~ /^\.tls/ {print "tls", $2}' | sort -u >"$work/kinds"
    else
        symbols "$1" | awk '$1 == "TLS" && $4 != "UND" {print "tls", $5} $1 == "IFUNC" {print "ifunc", $5}' >"$work/kinds"
    fi
    while read -r what name; do
        case $what in
        tls) finding "$(place_of "$1" "$name")" "$name" "thread-local; TG Motion has no threads to offer, use a static variable" ;;
        ifunc) finding "$(place_of "$1" "$name")" "$name" "indirect function; TG Motion resolves nothing at load" ;;
        esac
    done <"$work/kinds"
}

# "symbol addend" of every word in an initialiser array.
initialisers() {
    if [ $format = pe ]; then
        "$OBJDUMP" -r "$1" | awk '/^RELOCATION RECORDS FOR/ {on = ($4 ~ /\.(ctors|dtors|init_array|CRT)/)}
            on && $1 ~ /^[0-9a-f]+$/ {n = split($3, p, "[+]0x"); print p[1], (n > 1 ? p[2] : "0")}'
    else
        "$READELF" -rW "$1" | awk '/^Relocation section/ {on = ($3 ~ /\.(preinit_array|init_array|fini_array|ctors|dtors)/)}
            on && $1 ~ /^[0-9a-f]+$/ {print $5, ($7 == "" ? "0" : $7)}'
    fi
}

# Name of the function at an offset of a section of an object, as the linker knows it.
function_at() { # object section offset
    if [ $format = pe ]; then
        index=$("$OBJDUMP" -h "$1" | awk -v s="$2" '$2 == s {print $1 + 1; exit}')
        "$OBJDUMP" -t "$1" | awk -v s="$index" -v v="$(printf '%x' "0x$3")" \
            'NF > 3 {gsub(/[()]/, " "); value = $(NF - 1); sub(/^0x0*/, "", value); if (value == "") value = "0"
              for (i = 1; i < NF; i++) if ($i == "sec" && $(i + 1) == s && value == v && $NF !~ /^\./) {print $NF; exit}}'
        return
    fi
    index=$("$READELF" -SW "$1" | sed -n 's/^ *\[ *\([0-9]*\)\] \([^ ]*\) .*/\1 \2/p' | awk -v s="$2" '$2 == s {print $1; exit}')
    "$READELF" -sW "$1" | awk -v s="$index" -v v="$(printf '%016x' "0x$3")" \
        '$4 == "FUNC" && $7 == s && substr("0000000000000000" $2, length($2) + 1) == v {print $8; exit}'
}

# The variables that the initialiser of a C++ file writes: what its code refers to and is no function. A static
# one goes by its section's name (-fdata-sections): .bss.NAME, in COFF .data$NAME. One inside a function (_ZZ) is
# initialised there.
initialised() { # object function
    "$OBJDUMP" -dr --no-show-raw-insn --disassemble="$2" "$1" 2>/dev/null |
        sed -n 's/.*R_[A-Z0-9_]*[ \t]*\([^ \t]*\)$/\1/p; t
            s/.*IMAGE_REL_[A-Z0-9_]*[ \t]*\([^ \t]*\)$/\1/p; t
            s/.*[ \t]\(dir32\|DISP32\|secrel32\)[ \t]*\([^ \t]*\)$/\2/p' |
        sed 's/[-+]0x[0-9a-f]*$//' | plain | sed 's/^\.\(bss\|data\)[.$]//' | grep -v '^_ZZ' | c++filt | sed 's/(anonymous namespace):://g' |
        grep -vE '^\.|\(|^vtable|^$' | sort -u | tr '\n' ' '
}

check_constructors() { # object; section + offset of each function in an initialiser array -> name and line
    initialisers "$1" >"$work/ctors"
    while read -r name addend; do
        case $name in
        .*)
            place=$("$ADDR2LINE" -i -e "$1" -j "$name" "0x$addend" 2>/dev/null | sed 's/ (discriminator.*//' | grep -v ':?$' | tail -n 1)
            name=$(function_at "$1" "$name" "$addend")
            ;;
        *)
            name=$(printf '%s' "$name" | plain)
            place=$(place_of "$1" "$name")
            ;;
        esac
        case $name in
        *_GLOBAL__sub_I_* | __cxx_global_var_init*)
            variables=$(initialised "$1" "$name" | sed 's/ $//')
            finding "${place:-$1}" "${variables:-a global of this file}" \
                "initialised by code that TG Motion never runs; make it constexpr or constinit, or set it in Program_Ini"
            ;;
        *) finding "$place" "$name" "constructor or destructor; TG Motion never runs it, call it from Program_Ini" ;;
        esac
    done <"$work/ctors"
}

missing() { # file with the names that are there
    for name in $ENTRIES; do
        grep -qxF "$name" "$1" && continue
        finding "$module" "$name" "missing: TG Motion needs all six functions, even those that do nothing"
    done
}

check_module_elf() {
    "$READELF" --dyn-syms -W "$module" | awk '$1 ~ /^[0-9]+:$/ && $8 != "" {print $4, $5, $7, $8}' >"$work/dynamic_symbols"
    awk '$1 == "FUNC" && $2 == "GLOBAL" && $3 != "UND" {print $4}' "$work/dynamic_symbols" >"$work/exports"
    missing "$work/exports"
    awk '$3 == "UND" {print $4}' "$work/dynamic_symbols" >"$work/imports"
    while read -r name; do
        finding "$module" "$name" "imported: a module is linked to nothing"
    done <"$work/imports"
    "$READELF" -dW "$module" | awk '$2 ~ /NEEDED|INIT|FINI|TEXTREL/ {print $2, $NF}' >"$work/dynamic"
    while read -r tag name; do
        finding "$module" "$tag $name" "must not be in a module: TG Motion loads no library and runs no initialiser"
    done <"$work/dynamic"
    "$READELF" -rW "$module" | awk '$3 ~ /^R_/ && $3 != "R_X86_64_RELATIVE" && $3 != "R_ARM_RELATIVE" {print $3, $5}' >"$work/relocs"
    while read -r type name; do
        finding "$module" "${name:-?}" "relocation $type: a TG Motion loader knows relative relocations only"
    done <"$work/relocs"
    "$READELF" -lW "$module" | awk '$1 == "LOAD" && / RWE / {print "W+X"} $1 == "GNU_STACK" && /RWE/ {print "stack"} $1 == "TLS" {print "tls"}' >"$work/segments"
    while read -r what; do
        finding "$module" "$what" "segment that is writable and executable, or thread-local"
    done <"$work/segments"
}

check_module_pe() {
    "$OBJDUMP" -p "$module" >"$work/headers" 2>/dev/null
    awk '/\[Ordinal\/Name Pointer\] Table/ {on = 1; next} on && /^\t\[/ {print $NF; next} on && NF == 0 {on = 0}' "$work/headers" >"$work/exports"
    missing "$work/exports"
    while read -r name; do
        case " $ENTRIES " in
        *" $name "*) ;;
        *) finding "$module" "$name" "exported: a module exports exactly $ENTRIES" ;;
        esac
    done <"$work/exports"
    sed -n 's/^[ \t]*DLL Name: *//p' "$work/headers" >"$work/imports"
    while read -r name; do
        finding "$module" "$name" "a library is needed: a module is linked to nothing"
    done <"$work/imports"
    if awk '/^Entry 9 / && $3 !~ /^0+$/ {found = 1} END {exit !found}' "$work/headers"; then
        finding "$module" "TLS directory" "thread-local storage or callbacks: TG Motion has none"
    fi
}

check_module_flat() {
    "$READELF" -sW "$module" | awk '$4 == "FUNC" && $5 == "GLOBAL" && $7 != "UND" {print $8}' >"$work/exports"
    missing "$work/exports"
    grep -qxF GetProcAddress "$work/exports" || finding "$module" GetProcAddress "missing: the controller calls it first"
    "$READELF" -sW "$module" | awk '$7 == "UND" && $8 != "" {print $8}' >"$work/imports"
    while read -r name; do
        finding "$module" "$name" "defined nowhere: a module is linked to nothing"
    done <"$work/imports"
}

for object in "$@"; do
    symbols "$object" | awk '$4 != "UND" {print $5}'
done | sort -u >"$work/defined"
for object in "$@"; do
    check_names "$object"
    check_weak "$object"
    [ -e "$module" ] || check_undefined "$object"
    check_kinds "$object"
    check_constructors "$object"
done
if [ -e "$module" ]; then check_module_$format; else missing "$work/defined"; fi

sort -u "$work/findings" >&2
[ ! -s "$work/findings" ]
