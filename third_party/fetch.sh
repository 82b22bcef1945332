#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# fetch.sh [soem|musl|sarif] - foreign files as soem.lock, musl.lock or sarif.lock pins them, unpacked to
# third_party/soem/ (the default), third_party/musl/ or third_party/sarif/.
#
# Does nothing when the tree is there and belongs to the lock. Otherwise takes the archive from
# third_party/download/ when it is there, else by name from the Python package index (SOEM, SARIF) or from
# Debian's package pool (musl); checks its hash before anything of it is unpacked or run; stops with a
# message when the hash differs.
set -eu
cd "$(dirname "$0")"

what=${1:-soem}
case $what in
soem | musl | sarif) ;;
*)
    echo "third_party: '$what' is not known here; fetch.sh [soem|musl|sarif]" >&2
    exit 2
    ;;
esac
read -r name version hash <<END
$(grep -v '^#' "$what.lock")
END
stamp=$what/.from

if [ "$(cat "$stamp" 2>/dev/null)" = "$hash" ]; then
    exit 0
fi

mismatch() { # what was found
    echo "third_party: $name $version: the archive is not the one that $what.lock pins" >&2
    echo "  expected sha256 $hash" >&2
    echo "  got      sha256 $1" >&2
    echo "  Nothing was unpacked. If the change is wanted, review the new archive and update $what.lock." >&2
    exit 1
}

# fetch_NAME: brings the archive to $archive or says in download/log why not.

fetch_python() {
    python=${PYTHON:-/usr/bin/python3}
    [ -x "$python" ] || python=python3
    printf '%s==%s --hash=sha256:%s\n' "$name" "$version" "$hash" >download/requirements.txt
    "$python" -m pip download --quiet --disable-pip-version-check --no-deps --no-binary "$name" \
        --require-hashes --dest download --requirement download/requirements.txt >download/log 2>&1 && return
    got=$(sed -n 's/^ *Got *\([0-9a-f]\{64\}\).*/\1/p' download/log | head -n 1)
    [ -z "$got" ] || mismatch "$got"
    return 1
}

fetch_soem() {
    fetch_python
}

fetch_sarif() {
    fetch_python
}

# A source archive lies in Debian's pool beside the packages that are built from it: apt knows the place.
pool_of() { # package, apt options...: the folder it is downloaded from
    package=$1
    shift
    apt-get "$@" download --print-uris "$package" 2>>download/log |
        sed -n "s|^'\(.*/\)${package}_[^/]*\.deb' .*|\1|p" | head -n 1
}

fetch_musl() {
    : >download/log
    pool=$(pool_of musl)
    if [ -z "$pool" ]; then # no package lists on this machine: own ones, /var stays as it is
        lists=$PWD/download/apt
        mkdir -p "$lists/partial"
        apt-get -o Dir::State::lists="$lists" update >>download/log 2>&1 || true
        pool=$(pool_of musl -o Dir::State::lists="$lists")
    fi
    [ -n "$pool" ] || return 1
    /usr/lib/apt/apt-helper download-file "$pool${archive#download/}" "$PWD/$archive.part" \
        >>download/log 2>&1 && mv "$archive.part" "$archive"
}

case $what in
soem)
    archive=download/$name-$version.tar.gz
    title="SOEM's source"
    label=SOEM
    parts=$name-$version/soem
    strip=2
    ;;
musl)
    archive=download/${name}_$version.orig.tar.gz
    title="mathematical functions"
    label=musl
    parts="$name-$version/COPYRIGHT $name-$version/src/math $name-$version/src/internal"
    strip=1
    ;;
sarif)
    archive=download/$name-$version.tar.gz
    title="the schema of SARIF"
    label="the schema of SARIF"
    parts="$name-$version/sarif-2.1.0-rtm.4.json $name-$version/LICENSE"
    strip=1
    ;;
esac

mkdir -p download
if [ ! -f "$archive" ]; then
    echo "third_party: fetching $name $version ($title)"
    if ! "fetch_$what"; then
        cat download/log >&2
        echo "third_party: could not fetch $name $version; without a network, put ${archive#download/} into" >&2
        echo "  $PWD/download/ and run make again" >&2
        exit 1
    fi
fi

got=$(sha256sum "$archive" | cut -d' ' -f1)
[ "$got" = "$hash" ] || mismatch "$got"

rm -rf "$what" "$what.new"
mkdir "$what.new"
# shellcheck disable=SC2086 # parts are words
tar -xzf "$archive" -C "$what.new" --strip-components=$strip $parts
echo "$hash" >"$what.new/.from"
mv "$what.new" "$what"
echo "third_party: $label is in third_party/$what"
