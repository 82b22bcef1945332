#!/bin/sh
# SPDX-License-Identifier: MIT
#
# join_pascal.sh RESULT OBJECT... - makes one object of Free Pascal's, as if a C compiler had written it:
# what the compiler named is local, so that only names an author chose (public name '...') are left to look at, and
# constants are in read-only sections. Needs binutils of the target (LD, OBJCOPY, OBJDUMP).
set -eu
LC_ALL=C
export LC_ALL

result=$1
shift
"${LD:-ld}" -r -o "$result.joined" "$@"

# Constants of a PE object are writable, in sections that the linker does not know. A function whose name is
# nearly right has to survive the linker's clean-up, so that the harness can say what is wrong with it; the linker
# script keeps .text.program_*.
"${OBJDUMP:-objdump}" -h "$result.joined" | awk -v target="${TARGET:-elf64}" '
    target ~ /^pe/ && $2 ~ /^\.rodata\.n_/ {
        print "--rename-section " $2 "=.rdata$" substr($2, 11) ",alloc,load,readonly,data,contents"
    }
    target == "elf64" && $2 ~ /^\.text\.n_.*_\$\$_program_/ {
        print "--rename-section " $2 "=.text." substr($2, index($2, "_$$_") + 4)
    }' >"$result.options"

# Names that hold a $ or begin with fpc are the compiler's. In a PE object nothing is visible but what the
# .def file names, so that they may stay as they are.
case ${TARGET:-elf64} in
pe*) ;;
*) printf '%s\n' --wildcard "--localize-symbol=*\$*" '--localize-symbol=fpc_*' '--localize-symbol=FPC_*' >>"$result.options" ;;
esac
"${OBJCOPY:-objcopy}" "@$result.options" "$result.joined" "$result"
rm -f "$result.joined" "$result.options"
