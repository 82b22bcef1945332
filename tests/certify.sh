#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# Certificates: keys, signing, verifying, tampering. BUILD names the tree.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
build=${BUILD:-build}
tgm=$build/tgm
fixtures=$build/fixtures
cp "$build/template/shuttle.tgm" "$work/shuttle.tgm"
module=$work/shuttle.tgm

# --- keys -----------------------------------------------------------------------------------------
run "$tgm" keygen "$work/plant"
expect "a pair of keys" 0 "plant.key" "plant.pub" "key id "
[ "$(stat -c %a "$work/plant.key")" = 600 ] && pass "the secret one is its owner's" || fail "the secret one is its owner's"
cp "$work/plant.key" "$work/before"
run "$tgm" keygen "$work/plant"
expect "keys are never overwritten" 2 "plant.key: File exists"
cmp -s "$work/before" "$work/plant.key" && pass "not a byte" || fail "not a byte"
rm "$work/before"
mv "$work/plant.key" "$work/moved"
run "$tgm" keygen "$work/plant"
expect "nor is a public one" 2 "plant.pub: File exists"
[ ! -e "$work/plant.key" ] && pass "and no half of a pair is left" || fail "and no half of a pair is left"
mv "$work/moved" "$work/plant.key"
run "$tgm" keygen "$work/other"
expect "another pair" 0
run "$tgm" keygen
expect "a pair without a name" 2 "which name?"
if command -v openssl >/dev/null 2>&1; then
    run openssl pkey -in "$work/plant.key" -pubout
    cmp -s "$out" "$work/plant.pub" && pass "openssl reads our keys" || fail "openssl reads our keys"
    openssl genpkey -algorithm ed25519 -out "$work/theirs.key" 2>/dev/null
    openssl pkey -in "$work/theirs.key" -pubout -out "$work/theirs.pub" 2>/dev/null
    chmod 600 "$work/theirs.key"
else
    echo "SKIP  openssl is not installed: keys and signatures are not held against it"
fi

# --- signing --------------------------------------------------------------------------------------
run "$tgm" certify "$module" --key "$work/plant.key"
expect "the template is certified" 0 "RESULT: PASS" "shuttle.tgm.cert  signed for cert-1/pc4"
cert=$work/shuttle.tgm.cert
evidence=$work/shuttle.tgm.evidence

refused() { # name status module text: nothing is signed
    run "$tgm" certify "$3" --key "$work/plant.key" -o "$work/no.cert" --evidence "$work/no.evidence"
    expect "$1" "$2" "$4"
    [ ! -e "$work/no.cert" ] && pass "$1: no certificate" || fail "$1: no certificate"
}
refused "a module that fails" 1 "$fixtures/no-fault/bad.tgm" "the module does not conform; nothing was signed"
refused "a file that is no module" 1 "$fixtures/file-format/bad.tgm" "nothing was signed"
refused "a missing file" 2 "$work/missing.tgm" "No such file"

chmod 644 "$work/other.key"
run "$tgm" certify "$module" --key "$work/other.key"
expect "a key that others can read" 2 "chmod 600"
chmod 600 "$work/other.key"
run "$tgm" certify "$module" --key "$work/plant.pub"
expect "the public half cannot sign" 2 "plant.pub"
run "$tgm" certify "$module"
expect "no key" 2 "which --key?"
for option in --seed=1 --rule=no-imports --cycles=9 --waive=x --scenario=x --config=x; do
    run "$tgm" certify "$module" --key "$work/plant.key" "$option"
    expect "nothing can be left out: ${option%%=*}" 2 "unknown option ${option%%=*}"
done
run "$tgm" certify "$module" --key "$work/plant.key" -o "$module"
expect "the module is not overwritten" 2 "is the module or the key itself"
run "$tgm" certify "$module" --key "$work/plant.key" -o "$work/plant.key"
expect "nor is the key" 2 "is the module or the key itself"

# --- verifying ------------------------------------------------------------------------------------
verify() { # certificate module key evidence
    run "$tgm" verify "$1" "$2" --key "$3" --evidence "$4"
}
verify "$cert" "$module" "$work/plant.pub" "$evidence"
expect "it verifies" 0 "judged by    tgm " "profile      cert-1/pc4" "unchanged; judged again: PASS"
last_line "and says so last" "^VERIFIED: this module passed cert-1/pc4, and nothing was changed since$"
run "$tgm" verify "$cert" "$module" --key "$work/plant.pub"
expect "without its evidence" 0 "not looked at (--evidence DIR)" "VERIFIED"
program=$(sha256sum "$tgm" | cut -d' ' -f1)
run "$tgm" verify "$cert" "$module" --key "$work/plant.pub"
expect "the program is named by its hash" 0 "$program"

verify "$cert" "$module" "$work/other.pub" "$evidence"
expect "another key" 1 "NOT VERIFIED" "names another key as its signer"
verify "$cert" "$module" "$work/plant.key" "$evidence"
expect "a secret key to verify with" 2 "is a secret key"
cp "$module" "$work/changed.tgm"
printf 'x' | dd of="$work/changed.tgm" bs=1 seek=4000 conv=notrunc 2>/dev/null
verify "$cert" "$work/changed.tgm" "$work/plant.pub" "$evidence"
expect "a changed module" 1 "NOT VERIFIED: $work/changed.tgm is not the module that was certified"
run "$tgm" verify "$work/missing" "$module" --key "$work/plant.pub"
expect "a missing certificate" 2 "cannot read"
run "$tgm" verify "$cert" "$work/missing" --key "$work/plant.pub"
expect "a missing module" 2 "cannot read"
run "$tgm" verify "$cert" "$work" --key "$work/plant.pub"
expect "a folder as module" 2 "Is a directory"
run "$tgm" verify "$cert"
expect "no module" 2 "which module?"
run "$tgm" verify "$cert" "$module"
expect "no key to verify with" 2 "whose --key?"
run "$tgm" verify "$module" "$cert" --key "$work/plant.pub"
expect "a module as certificate" 1 "NOT VERIFIED" "no signed statement"

# every 29th byte of the certificate here; tests/test_certificate.c takes every bit
script "$tgm" "$cert" "$module" "$work/plant.pub" "$work/tampered" <<'EOF'
import subprocess, sys
tgm, cert, module, key, tampered = sys.argv[1:]
original = open(cert, "rb").read()
def verdict(data):
    open(tampered, "wb").write(data)
    return subprocess.run([tgm, "verify", tampered, module, "--key", key], stdout=subprocess.PIPE)
assert verdict(original).returncode == 0
for i in range(0, len(original), 29):
    answer = verdict(original[:i] + bytes([original[i] ^ 1]) + original[i + 1:])
    assert answer.returncode == 1 and answer.stdout.startswith(b"NOT VERIFIED: "), (i, answer)
for data in b"", original[:-1], original + b"\n", original + original, original.replace(b"\n", b"\r\n"):
    assert verdict(data).returncode == 1, data[-20:]
EOF
expect "tampering with the certificate is seen" 0

tampered=0
total=0
for file in "$evidence"/*; do
    name=$(basename "$file")
    cp "$file" "$work/kept"
    size=$(stat -c %s "$file")
    places=$((size / 2))
    [ "$name" != manifest.json ] || places="0 $places $((size - 1))"
    for at in $places; do
        python3 -c 'import sys
data = bytearray(open(sys.argv[1], "rb").read())
data[int(sys.argv[2])] ^= 1
open(sys.argv[1], "wb").write(data)' "$file" "$at"
        verify "$cert" "$module" "$work/plant.pub" "$evidence"
        total=$((total + 1))
        if [ "$status" = 1 ] && grep -q "^NOT VERIFIED: .*$name" "$out"; then tampered=$((tampered + 1)); else
            echo "        $name at $at: exit $status: $(cat "$out" "$err")"
        fi
        cp "$work/kept" "$file"
    done
    case $name in manifest.json | module | start.evidence) ;; *) continue ;; esac
    rm "$file"
    verify "$cert" "$module" "$work/plant.pub" "$evidence"
    total=$((total + 1))
    case $status in 1 | 2) tampered=$((tampered + 1)) ;; *) echo "        $name is missing: exit $status" ;; esac
    cp "$work/kept" "$file"
done
[ "$tampered" = "$total" ] && pass "$total changes of the evidence are seen and named" ||
    fail "$((total - tampered)) of $total changes of the evidence are not seen"
verify "$cert" "$module" "$work/plant.pub" "$evidence"
expect "and put back it verifies" 0 "VERIFIED"
verify "$cert" "$module" "$work/plant.pub" "$work"
expect "a folder without evidence" 2 "manifest.json"

# --- what others make of it -----------------------------------------------------------------------
script "$cert" "$work" "$module" "$evidence" <<'EOF'
import base64, hashlib, json, sys
cert, work, module, evidence = sys.argv[1:]
sha256 = lambda path: hashlib.sha256(open(path, "rb").read()).hexdigest()
envelope = json.load(open(cert))
assert envelope["payloadType"] == "application/vnd.in-toto+json" and len(envelope["signatures"]) == 1
payload = base64.b64decode(envelope["payload"], validate=True)
kind = envelope["payloadType"].encode()
open(f"{work}/signed", "wb").write(b"DSSEv1 %d %s %d %s" % (len(kind), kind, len(payload), payload))
open(f"{work}/signature", "wb").write(base64.b64decode(envelope["signatures"][0]["sig"], validate=True))
statement = json.loads(payload)
assert statement["_type"] == "https://in-toto.io/Statement/v1"
assert statement["predicateType"] == "https://in-toto.io/attestation/test-result/v0.1"
assert statement["subject"] == [{"name": "shuttle.tgm", "digest": {"sha256": sha256(module)}}]
predicate = statement["predicate"]
assert predicate["result"] in ("PASSED", "WARNED") and predicate["failedTests"] == []
assert "no-imports" in predicate["passedTests"]
parts = {part["name"]: part for part in predicate["configuration"]}
assert parts["evidence"]["digest"]["sha256"] == sha256(f"{evidence}/manifest.json")
assert parts["rule-book"]["annotations"]["profile"] == "cert-1/pc4"
EOF
expect "it is an in-toto test result in a DSSE envelope" 0
if command -v openssl >/dev/null 2>&1; then
    run openssl pkeyutl -verify -pubin -inkey "$work/plant.pub" -rawin -in "$work/signed" -sigfile "$work/signature"
    expect "openssl verifies the signature" 0 "Signature Verified Successfully"
    run "$tgm" certify "$module" --key "$work/theirs.key" -o "$work/theirs.cert" --evidence "$work/theirs.evidence"
    expect "a key that openssl made signs" 0
    run "$tgm" verify "$work/theirs.cert" "$module" --key "$work/theirs.pub"
    expect "and verifies" 0 "VERIFIED"
    script "$cert" "$work/theirs.cert" <<'EOF'
import base64, json, sys
def statement(path):
    parts = json.loads(base64.b64decode(json.load(open(path))["payload"]))
    for part in parts["predicate"]["configuration"]:
        if part["name"] == "evidence":
            del part["digest"]
    return parts
first, second = statement(sys.argv[1]), statement(sys.argv[2])
# On a busy computer a rule that does not decide may not be judged in time.
for parts in first, second:
    parts["predicate"].pop("result")
    parts["predicate"]["tests"] = sorted(parts["predicate"].pop("passedTests") + parts["predicate"].pop("warnedTests"))
assert first == second, (first, second)
EOF
    expect "who certifies again states the same" 0
fi

finish
