#!/bin/sh
# SPDX-License-Identifier: MIT
#
# verify_pascal.sh SOURCE OBJECT [SOURCE OBJECT]... - what Free Pascal compiles although TG Motion does not
# provide for it. Beside verify.sh, which looks at the module whatever its language.
#
# Every finding is one line "file:line: error: name: what is wrong; what to do". Exit 1 when there is any.
# Needs binutils of the target (NM, OBJDUMP).
set -u
LC_ALL=C
export LC_ALL
NM=${NM:-nm}
OBJDUMP=${OBJDUMP:-objdump}

work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
: >"$work/findings"

finding() { # place name text
    printf '%s: error: %s: %s\n' "$1" "$2" "$3" | sed "s|^$PWD/||" >>"$work/findings"
}

# The first line of a source where a pattern (lower case) stands outside a // comment, as ":line" or nothing.
line_of() { # source pattern
    awk -v want="$2" '{s = tolower($0); sub(/\/\/.*/, "", s)} s ~ want {print ":" FNR; exit}' "$1"
}

# A variable with an initial value, and a typed constant that $J+ made one: a section of its own each,
# named after it: .data.n_TC_$UNIT_$$_NAME, .data.rel.n_TC_... ; real constants are in .rodata and .data.rel.ro.
check_initial_values() { # source object
    "$OBJDUMP" -h "$2" | sed -n 's/.* \.data\(\.rel\)\{0,1\}\.n_\(TC_[^ ]*\).*/\2/p' | sed 's/.*_\$\$_//' | sort -u >"$work/values"
    while read -r upper; do
        name=$(printf '%s' "$upper" | tr 'A-Z' 'a-z')
        finding "$1$(line_of "$1" "(^|[^a-z0-9_])$name[ \\t]*:[^=]*=")" "$name" \
            'has an initial value, which TG Motion does not give it; assign it in Program_Ini (a constant: const, without {$J+})'
    done <"$work/values"
}

check_sections() { # source object
    "$NM" "$2" | awk '{print $NF}' >"$work/names"
    if grep -q '^INIT\$_\$' "$work/names"; then
        finding "$1$(line_of "$1" '^[ \t]*initialization')" initialization \
            'TG Motion never runs this section; do it in Program_Ini'
    fi
    if grep -q '^FINALIZE\$_\$' "$work/names"; then
        finding "$1$(line_of "$1" '^[ \t]*finalization')" finalization \
            'TG Motion never runs this section, and there is no clean-up of strings and dynamic arrays'
    fi
}

# A function with the right name that was not given it for the linker.
check_exports() { # source object
    "$NM" "$2" | awk '{print $NF}' >"$work/names"
    for entry in Program_Ini Program_01 Program_02 Program_03 Program_04 Program_05; do
        lower=$(printf '%s' "$entry" | tr 'A-Z' 'a-z')
        grep -qi "^$entry\$" "$work/names" ||
            ! grep -qi "_\\\$\\\$_$entry\(\\\$\|\$\)" "$work/names" ||
            finding "$1$(line_of "$1" "function[ \\t]+$lower([^a-z0-9_]|\$)")" "$entry" \
                "not exported; declare it in the interface with: cdecl; public name '$entry'"
    done
}

# 80-bit arithmetic: another result than on the 64-bit PC, and slow.
check_extended() { # source object
    "$OBJDUMP" -d -l --no-show-raw-insn "$2" | awk '
        /^[^ ].*:[0-9]+( \(discriminator.*)?$/ { place = $1 }
        /^ +[0-9a-f]+:\t/ { split($0, p, "\t"); if (p[2] ~ /^f(ld|ild|st|ist|add|sub|mul|div|com|ucom|sqrt|abs|chs|xch|rnd|sin|cos|pat|y)/) print place }' |
        sort -u >"$work/places"
    while read -r place; do
        finding "${place:-$1}" extended 'computed in 80 bits, on pe64 in 64; a constant that a Double cannot hold exactly is 80 bits wide: write Double(0.1), not 0.1'
    done <"$work/places"
}

# {$Q+}: the compiler checks, and calls the run-time library when it finds something.
check_overflow() { # source object
    "$NM" -l "$2" 2>/dev/null | awk -F'\t' '$1 ~ / U FPC_OVERFLOW$/ {print $2}' >"$work/places"
    while read -r place; do
        finding "${place:-$1}" '{$Q+}' 'overflow checks need a run-time library to report to; compare before you compute'
    done <"$work/places"
}

while [ $# -ge 2 ]; do
    check_initial_values "$1" "$2"
    check_sections "$1" "$2"
    check_exports "$1" "$2"
    check_overflow "$1" "$2"
    check_extended "$1" "$2"
    shift 2
done

sort -u "$work/findings" >&2
[ ! -s "$work/findings" ]
