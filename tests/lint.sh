#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# Rules of the house that no compiler knows.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
: >"$err"

# none NAME COMMAND...: the command prints nothing
none() {
    name=$1
    shift
    "$@" >"$out" 2>/dev/null
    if [ -s "$out" ]; then fail "$name"; else pass "$name"; fi
}
outside() { # header pattern, files that may include it
    grep -rlE "#include [<\"]($1)" harness conformance sdk templates | grep -vE "$2"
}
uses() { # room pattern of what it must not include
    grep -rnE "#include \"($2)/" "$1"
}

none "only image/elf*.c includes libelf" outside '(libelf|gelf)\.h' '^harness/image/(elf|lines)'
none "only image/lines*.c includes libdw" outside '(elfutils|dwarf|libdw)' '^harness/image/lines'
none "only image/code*.c includes Capstone" outside 'capstone' '^harness/image/code'
none "only machine/instrumented* and cpu_* include Unicorn" outside 'unicorn/.*' '^harness/machine/(instrumented|cpu_)'
none "only host/config.c includes inih" outside 'ini\.h' '^harness/host/config\.c'
none "only bus/ includes SOEM" outside 'ethercat|osal|oshw|nicdrv' '^harness/bus/'
none "only bus/esi*.c includes libxml2" outside 'libxml/.*' '^harness/bus/esi'
none "image stands alone" uses harness/image 'machine|host|bus|report|cli|conformance'
none "machine knows image only" uses harness/machine 'host|bus|report|cli|conformance'
none "bus knows no other room" uses harness/bus 'image|machine|host|report|cli|conformance'
none "host does not look up" uses harness/host 'report|cli|conformance'
none "report is a leaf" uses harness/report 'image|machine|host|bus|cli|conformance'
none "conformance does not know the command line" uses conformance 'cli'
none "the sdk knows nothing of the harness" grep -rnE 'harness/|conformance/' sdk/include sdk/src sdk/link sdk/mk
none "every source names its licence" sh -c "git ls-files '*.c' '*.h' '*.S' '*.sh' '*.mk' '*.py' '*.def' '*.ld' '*.map' | xargs grep -L SPDX-License-Identifier"
none "rules have both fixtures" sh -c '
    sed -n "s/^RULE([a-z_]*, \"\([a-z-]*\)\".*/\1/p" conformance/rules.def | while read -r id; do
        ls conformance/fixtures/$id/bad.c conformance/fixtures/$id/good.c >/dev/null 2>&1 || echo "$id"
    done'
none "docs/rules.md is what the rule book says" tools/rules.py --check
none "no path of a machine in the tree" sh -c "git ls-files | xargs grep -nIE '(/home|/root|/work)/' | grep -v '^tests/lint.sh'"
none "nothing foreign is committed" git ls-files third_party/soem third_party/download

finish
