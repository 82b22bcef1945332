#!/bin/sh
# SPDX-License-Identifier: MIT
#
# verify.sh MODULE OBJECT... - what the linker cannot refuse, or refuses without naming the line.
#
# Reads the objects that a module was (or is to be) linked from, and the module itself when it exists.
# Every finding is one line "file:line: error: symbol: what is wrong; what to do". Exit 1 when there
# is any. Needs binutils (NM, READELF, ADDR2LINE).
set -u
LC_ALL=C
export LC_ALL
NM=${NM:-nm}
READELF=${READELF:-readelf}
ADDR2LINE=${ADDR2LINE:-addr2line}
ENTRIES='Program_Ini Program_01 Program_02 Program_03 Program_04 Program_05'

module=$1
shift
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
: >"$work/findings"

finding() { # place symbol text
    printf '%s: error: %s: %s\n' "${1:-$module}" "$2" "$3" | sed "s|^$PWD/||" >>"$work/findings"
}

# "name<TAB>file:line" of every symbol of an object; for an undefined one, the first line that uses it.
places() {
    "$NM" -l "$1" 2>/dev/null | awk -F'\t' '{n = split($1, w, " "); print w[n] "\t" $2}'
}

place_of() { # object symbol; without line information, the source file that the object was made from
    found=$(places "$1" | awk -F'\t' -v s="$2" '$1 == s && $2 != "" {print $2; exit}')
    [ -n "$found" ] || found=$("$READELF" -sW "$1" | awk '$4 == "FILE" {print $8; exit}')
    printf '%s' "${found:-$1}"
}

# type bind visibility section name, of every named symbol of an object
symbols() {
    "$READELF" -sW "$1" | awk '$1 ~ /^[0-9]+:$/ && $8 != "" {print $4, $5, $6, $7, $8}'
}

check_names() { # object
    symbols "$1" | awk -v entries="$ENTRIES" '
        BEGIN { n = split(entries, e, " "); for (i = 1; i <= n; i++) { exact[e[i]] = 1; lower[tolower(e[i])] = e[i] } }
        $4 == "UND" || $1 == "SECTION" || $1 == "FILE" { next }
        $5 in exact { if ($1 != "FUNC") print "data", $5, $5; next }
        {
            bare = tolower($5); sub(/^_+/, "", bare); sub(/@.*/, "", bare)
            if (bare in lower) print "case", $5, lower[bare]
            else if ($3 == "DEFAULT" && $2 != "LOCAL" && $1 == "FUNC") print "extra", $5, "-"
            else if ($3 == "DEFAULT" && $2 != "LOCAL" && $1 == "OBJECT") print "extra", $5, "-"
        }' >"$work/names"
    while read -r what name right; do
        case $what in
        case) finding "$(place_of "$1" "$name")" "$name" \
            "not a name TG Motion looks up, letter case and decoration count; it must be $right" ;;
        data) finding "$(place_of "$1" "$name")" "$name" "is data; TG Motion calls it as a function" ;;
        extra) finding "$(place_of "$1" "$name")" "$name" \
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
        grep -qxF "$name" "$work/defined" || [ "$name" = _GLOBAL_OFFSET_TABLE_ ] ||
            finding "$(place_of "$1" "$name")" "$name" "defined nowhere: a module is linked to nothing, write it yourself"
    done <"$work/undefined"
}

check_kinds() { # object
    symbols "$1" | awk '$1 == "TLS" && $4 != "UND" {print "tls", $5} $1 == "IFUNC" {print "ifunc", $5}' >"$work/kinds"
    while read -r what name; do
        case $what in
        tls) finding "$(place_of "$1" "$name")" "$name" "thread-local; TG Motion has no threads to offer, use a static variable" ;;
        ifunc) finding "$(place_of "$1" "$name")" "$name" "indirect function; TG Motion resolves nothing at load" ;;
        esac
    done <"$work/kinds"
}

check_constructors() { # object; section + offset of each function in an initialiser array -> name and line
    "$READELF" -rW "$1" | awk '
        /^Relocation section/ { on = ($3 ~ /\.(preinit_array|init_array|fini_array|ctors|dtors)/) }
        on && $1 ~ /^[0-9a-f]+$/ { print $5, ($7 == "" ? "0" : $7) }' >"$work/ctors"
    while read -r name addend; do
        case $name in
        .*)
            where=$("$ADDR2LINE" -f -e "$1" -j "$name" "0x$addend" 2>/dev/null)
            name=$(printf '%s\n' "$where" | sed -n 1p)
            finding "$(printf '%s\n' "$where" | sed -n 's/ (discriminator.*//; 2p')" "$name" \
                "constructor or destructor; TG Motion never runs it, call it from Program_Ini"
            ;;
        *) finding "$(place_of "$1" "$name")" "$name" \
            "constructor or destructor; TG Motion never runs it, call it from Program_Ini" ;;
        esac
    done <"$work/ctors"
}

check_module() {
    symbols_dyn=$("$READELF" --dyn-syms -W "$module" | awk '$1 ~ /^[0-9]+:$/ && $8 != "" {print $4, $5, $7, $8}')
    for name in $ENTRIES; do
        printf '%s\n' "$symbols_dyn" | grep -qE "^FUNC GLOBAL [0-9]+ $name\$" ||
            finding "$module" "$name" "missing: TG Motion needs all six functions, even those that do nothing"
    done
    printf '%s\n' "$symbols_dyn" | awk '$3 == "UND" {print $4}' >"$work/imports"
    while read -r name; do
        finding "$module" "$name" "imported: a module is linked to nothing"
    done <"$work/imports"
    "$READELF" -dW "$module" | awk '$2 ~ /NEEDED|INIT|FINI|TEXTREL/ {print $2, $NF}' >"$work/dynamic"
    while read -r tag name; do
        finding "$module" "$tag $name" "must not be in a module: TG Motion loads no library and runs no initialiser"
    done <"$work/dynamic"
    "$READELF" -rW "$module" | awk '$3 ~ /^R_/ && $3 != "R_X86_64_RELATIVE" && $3 != "R_386_RELATIVE" && $3 != "R_ARM_RELATIVE" {print $3, $5}' >"$work/relocs"
    while read -r type name; do
        finding "$module" "${name:-?}" "relocation $type: a TG Motion loader knows relative relocations only"
    done <"$work/relocs"
    "$READELF" -lW "$module" | awk '$1 == "LOAD" && / RWE / {print "W+X"} $1 == "GNU_STACK" && /RWE/ {print "stack"} $1 == "TLS" {print "tls"}' >"$work/segments"
    while read -r what; do
        finding "$module" "$what" "segment that is writable and executable, or thread-local"
    done <"$work/segments"
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
[ -e "$module" ] && check_module

sort -u "$work/findings" >&2
[ ! -s "$work/findings" ]
