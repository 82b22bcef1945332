#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# deps.sh [build|test] - installs what is missing from Debian's packages, saying what and why.
set -eu

packages() {
    cat <<'EOF'
build gcc            the compiler of harness and modules
build libc6-dev      its C library
build binutils       linker and readelf, nm for the checks of a module
build libelf-dev     reads ELF modules
build libdw-dev      source lines of a module, from its debug information
build libcapstone-dev disassembles modules: how much stack they take
build libunicorn-dev emulates CPUs: instrumented runs and modules of other targets
build libseccomp-dev confines the reading of debug information and code
build libsodium-dev  SHA-256 of modules
build libjansson-dev JSON reports
build libinih-dev    reads the configuration files of TG Motion
build libxml2-dev   device descriptions (ESI)
build python3        generates layouts and fetches SOEM
build python3-pip    fetches SOEM's source archive by name
build ca-certificates lets the fetch verify its source
test  libcmocka-dev  unit tests
test  clang          second compiler, sanitizers
test  libclang-rt-dev run-time of the sanitizers
test  llvm           names in sanitizer reports
test  lld            second linker for modules
test  fp-compiler    modules in Pascal
test  gcc-mingw-w64-x86-64-win32 modules for 64-bit Windows
test  gcc-mingw-w64-i686-win32 modules for 32-bit Windows
test  g++-mingw-w64-x86-64-win32 modules in C++ for 64-bit Windows
test  g++-mingw-w64-i686-win32 modules in C++ for 32-bit Windows
test  g++            modules in C++
test  gcc-arm-linux-gnueabihf modules for TGMmini
test  g++-arm-linux-gnueabihf modules in C++ for TGMmini
test  gcc-arm-none-eabi modules for TGMcontroller and TGZ+Motion
test  valgrind       memory checks
test  libmpfr-dev    the reference for the SDK's mathematics
test  gdb            make debug
test  gnuplot-nox    pictures of recordings (tgm run --plot)
test  tshark         dissects captures
test  iproute2       virtual cables between the simulated bus and other masters
test  python3-jsonschema holds SARIF reports against their schema
test  python3-venv   pysoem, one of those masters
test  openssl        holds keys and signatures of certificates against another implementation
test  procps         looks for processes that a hostile module left behind
EOF
}

level=${1:-build}
missing=
if ! command -v dpkg-query >/dev/null 2>&1; then
    echo "deps: this is not a Debian system; needed are:"
    packages | sed 's/^/  /'
    exit 0
fi
while read -r when name why; do
    [ "$when" = build ] || [ "$level" = test ] || continue
    if ! dpkg-query -W -f='${Status}' "$name" 2>/dev/null | grep -q 'ok installed'; then
        echo "deps: $name is missing: $why"
        missing="$missing $name"
    fi
done <<EOF
$(packages)
EOF
[ -n "$missing" ] || exit 0

as_root=
if [ "$(id -u)" != 0 ]; then
    if ! command -v sudo >/dev/null 2>&1; then
        echo "deps: neither root nor sudo; please install:$missing" >&2
        exit 1
    fi
    as_root=sudo
fi
echo "deps: installing$missing"
# Package lists may be missing or stale on a fresh machine: fetch them when the first try fails.
install() {
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing
}
if ! install >/dev/null 2>&1; then
    $as_root apt-get update -qq
    install >/dev/null
fi
