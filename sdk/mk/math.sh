#!/bin/sh
# SPDX-License-Identifier: MIT
#
# math.sh FOLDER COMPILER [FLAG...] - builds FOLDER/libtgm_math.a, the functions of <tgm/math.h>.
#
#   math.sh build/math gcc -fPIC -fvisibility=hidden
#   math.sh build/math-mini arm-none-eabi-gcc -mcpu=cortex-a9 -mfpu=vfpv3 -mfloat-abi=hard
#
# The sources are musl's (MIT licence): MUSL names an unpacked source tree, by default third_party/musl beside
# the SDK. Flags that musl's code relies on are put behind the caller's, so that neither -ffast-math
# nor a language standard of the module reaches it. AR, NM, READELF/OBJDUMP: by default those of the compiler.
#
# A library that is not self-contained is not kept: every symbol defined (but for the compiler's own
# helpers, from -lgcc), no writable data, nothing thread-local.
set -eu
LC_ALL=C
export LC_ALL

if [ $# -lt 2 ]; then
    echo "usage: math.sh FOLDER COMPILER [FLAG...]" >&2
    exit 2
fi
sdk=$(cd "$(dirname "$0")/.." && pwd)
musl=${MUSL:-$sdk/../third_party/musl}
folder=$1
compiler=$2
shift 2

if [ ! -f "$musl/src/math/sin.c" ]; then
    echo "math.sh: no musl sources in $musl; third_party/fetch.sh musl brings them, MUSL= names another place" >&2
    exit 1
fi
musl=$(cd "$musl" && pwd)

functions='sqrt sin cos tan sincos asin acos atan atan2 sinh cosh tanh exp exp2 expm1 log log2 log10 log1p
    pow hypot cbrt fabs floor ceil round trunc rint lround llround fmod remainder remquo fmin fmax copysign
    scalbn ldexp frexp modf fma'
helpers='__cos __sin __tan __rem_pio2 __rem_pio2_large __math_divzero __math_invalid __math_oflow __math_uflow
    __math_xflow exp_data log_data log2_data pow_data sqrt_data'

# Intel, 32 bits: not the x87 unit. Windows sets it to 53 bits, where musl's general code expects 64 and gets
# floor and sin wrong; and the host may call with a stack that is not aligned for SSE.
macros=$(echo | "$compiler" "$@" -dM -E -x c -)
case $macros in
*"#define __i386__ "*) set -- "$@" -msse2 -mfpmath=sse -mstackrealign ;;
esac

# A file of the SDK goes before musl's for the machine, and that before the general one.
machine=$(printf '%s\n' "$macros" | sed -n 's/^#define __x86_64__ .*/x86_64/p; s/^#define __aarch64__ .*/aarch64/p
    s/^#define __arm__ .*/arm/p')
source_of() {
    for candidate in "$sdk/src/math/$1.c" "$musl/src/math/$machine/$1.c" "$musl/src/math/$1.c"; do
        if [ -f "$candidate" ]; then
            printf '%s' "$candidate"
            return
        fi
    done
}

tool() { # name: the one that belongs to the compiler
    "$compiler" -print-prog-name="$1" 2>/dev/null || echo "$1"
}
ar=${AR:-$(tool ar)}
nm=${NM:-$(tool nm)}
objdump=${OBJDUMP:-$(tool objdump)}

mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
(
    cd "$work"
    for name in $functions $helpers; do
        "$compiler" "$@" -std=c99 -O2 -g0 -w -ffreestanding -fbuiltin -fno-math-errno -fno-fast-math \
            -frounding-math -ffp-contract=off -fno-strict-aliasing -fno-stack-protector \
            -fno-asynchronous-unwind-tables -fno-unwind-tables -ffunction-sections -fdata-sections \
            -I"$sdk/src/math" -I"$musl/src/internal" -I"$musl/src/math" -c -o "$name.o" "$(source_of "$name")"
    done
    "$ar" rcsD libtgm_math.a ./*.o
    "$nm" -u ./*.o | sed -n 's/^ *[Uw] //p' | sort -u >undefined
    "$nm" --defined-only -g ./*.o | awk 'NF == 3 {print $3}' | sort -u >defined
    comm -23 undefined defined | grep -vE '^_?_(aeabi_|GLOBAL_OFFSET_TABLE_|[a-z]+[sdtx][if][0-9]?$)' >missing || true
    "$objdump" -h ./*.o | awk '$2 ~ /^\.(data|bss|tdata|tbss)/ && $3 !~ /^0+$/ {print $2}' | sort -u >writable
)
if [ -s "$work/missing" ] || [ -s "$work/writable" ]; then
    echo "math.sh: the library is not self-contained:" $(cat "$work/missing" "$work/writable") >&2
    exit 1
fi
mv "$work/libtgm_math.a" "$folder/libtgm_math.a"
