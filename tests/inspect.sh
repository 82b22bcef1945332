#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# tgm inspect, for every format: what is inside, and what it says of files that are no modules. BUILD names the tree.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
build=${BUILD:-build}
tgm=$build/tgm
modules=$build/modules

# --- every format ---------------------------------------------------------------------------------
run "$tgm" inspect "$modules/six.so"
expect "ELF64" 0 "six.so  ELF64 x86-64" "exports       6" "function          Program_04   tests/modules/image_six.c:50" \
    "imports       none" "entry point   none" "R_X86_64_RELATIVE" "load address  any" "r-x" \
    "at most" "source lines  yes" \
    "$(sha256sum "$modules/six.so" | cut -d' ' -f1)"
lacks "no colours" "$(printf '\033')"
run "$tgm" inspect "$modules/six_stripped.so"
expect "a stripped module" 0 "source lines  none"
run "$tgm" inspect "$modules/start.so"
expect "what a loader would have to do" 0 "weak symbol     perhaps" "DT_INIT_ARRAY" "constructor" "thread-local  16 bytes" \
    "indirect function"
run "$tgm" inspect "$modules/six_arm.so"
expect "ELF32" 0 "ELF32 Arm" "R_ARM_RELATIVE"
run "$tgm" inspect "$modules/six_thumb.so"
expect "Thumb code" 0 "Thumb function    Program_01"
for machine in x86_64:x86-64:DIR64 i686:i386:HIGHLOW; do
    file=${machine%%:*}
    target=${machine#*:}
    run "$tgm" inspect "$modules/pe_mingw_$file.dll"
    expect "PE $file" 0 "PE ${target%:*}" "forwarded         Program_03 -> OTHER.by_name" "#9" "library         OTHER.dll" \
        "symbol          OTHER.dll!#7" "TLS callback        1" "DllMain" "IMAGE_REL_BASED_${target#*:}" \
        "any, linked for 0x" "tests/modules/image_pe.c:"
    run "$tgm" inspect "$modules/pe_delay_$file.dll"
    expect "PE $file, delay import" 0 "delayed library OTHER.dll" "delayed symbol  OTHER.dll!by_name"
    run "$tgm" check "$modules/six_mingw_$file.dll" --cycles 20
    expect "the profile pc4 loads PE $file" 1 "PE ${target%:*}" "FAIL  no-fault"
done
run "$tgm" inspect "$modules/flat.tgm.bin"
expect "a flat image" 0 "flat Arm" "not known: this flat image has no table of them" "entry point   0x07800000" \
    "0x07800000 only" "1 segment"
run "$tgm" check "$modules/flat.tgm.bin" --cycles 20
expect "the profile pc4 does not load a flat image" 1 "flat Arm; the profile pc4 loads"
run "$tgm" check "$modules/six_arm.so" --cycles 20
expect "the profile pc4 does not load Arm" 1 "ELF32 Arm; the profile pc4 loads"

# --- how much stack -------------------------------------------------------------------------------
run "$tgm" inspect "$modules/stack_i386.dll"
expect "a bound for each function, and why there is none" 0 \
    "at least 136 bytes of the module's own; services of TG Motion add theirs" "      48              straight" \
    "      12  + services  service" \
    "and more    recursive    a function is called again before it has returned:  recursive+0x1" \
    "and more    alloca       the stack pointer moves by an amount computed at run time:  alloca+0x3"
run "$tgm" inspect "$modules/stack.so" --json "$work/stack.json"
script "$work/stack.json" <<'EOF'
import json, sys
r = json.load(open(sys.argv[1]))
s = {e["name"]: e["stack"] for e in r["exports"]}
assert s["nested"] == {"bytes": 72, "limit": "bounded", "services": False}, s["nested"]
assert s["recursive"]["limit"] == "recursion" and s["recursive"]["function"] == "recursive_call", s["recursive"]
assert r["stack"]["limit"] == "loop" and r["stack"]["bytes"] == 272, r["stack"]
EOF
expect "and in JSON" 0

# --- what the templates become, for every target --------------------------------------------------
run "${MAKE:-make}" --no-print-directory templates BUILD="$build"
expect "the templates build for every target" 0
for kind in c:elf64 c:pe64 c:pe32 c:tgmmini c:tgmcontroller c:tgzmotion cpp:elf64 cpp:pe64 cpp:pe32 cpp:tgmmini \
    cpp:tgmcontroller cpp:tgzmotion pascal:elf64 pascal:pe64; do
    count=6 lines=yes file=$build/templates/${kind%:*}-${kind#*:}/shuttle.tgm
    case $kind in *:tgmcontroller | *:tgzmotion) count=5 lines=none file=$file.bin ;; esac
    run "$tgm" inspect "$file" --json "$work/template.json"
    expect "$kind" 0 "exports       $count" "imports       none" "stack         at most" "source lines  $lines" \
        "$(sha256sum "$file" | cut -d' ' -f1)"
    lacks "$kind: nothing is unknown" "not known"
    lacks "$kind: every size is there" " ? "
    script "$work/template.json" "$count" <<'EOF'
import json, sys
r = json.load(open(sys.argv[1]))
names = ["Program_01", "Program_02", "Program_03", "Program_04", "Program_05", "Program_Ini"]
if int(sys.argv[2]) == 5:
    names.remove("Program_05")
assert sorted(e["name"] for e in r["exports"]) == names and r["imports"] == [] and r["segments"], r
assert all(e["size"] > 0 and e["stack"]["limit"] == "bounded" for e in r["exports"]), r["exports"]
assert r["stack"]["limit"] == "bounded" and 50 < r["stack"]["bytes"] < 2000, r["stack"]
assert type(r["source_lines"]) is bool and not r["executable_stack"], r
EOF
    expect "$kind in JSON" 0
done

# --- JSON -----------------------------------------------------------------------------------------
run "$tgm" inspect "$modules/pe_mingw_x86_64.dll" --json "$work/pe.json"
expect "--json FILE still prints the text" 0 "exports       6"
run "$tgm" inspect "$modules/six.so" --json -
cp "$out" "$work/elf.json"
run "$tgm" inspect --json - "$modules/flat.tgm.bin"
cp "$out" "$work/flat.json"
"$tgm" inspect "$modules/six_i386.so" --json "$work/bad.json" >/dev/null
script "$work" "$modules" <<'EOF'
import hashlib, json, sys
work, modules = sys.argv[1:]
pe, elf, flat, bad = (json.load(open(f"{work}/{n}.json")) for n in ("pe", "elf", "flat", "bad"))
for r, name in (pe, "pe_mingw_x86_64.dll"), (elf, "six.so"), (flat, "flat.tgm.bin"), (bad, "six_i386.so"):
    b = open(f"{modules}/{name}", "rb").read()
    assert r["schema"] == "tgm-inspect/1" and r["tool"].startswith("tgm "), r
    assert r["module"]["sha256"] == hashlib.sha256(b).hexdigest() and r["module"]["size"] == len(b), r
assert (pe["module"]["format"], pe["module"]["target"]) == ("PE", "x86-64")
by_name = {e["name"]: e for e in pe["exports"]}
assert by_name["Program_03"]["forwarder"] == "OTHER.by_name" and "address" not in by_name["Program_03"]
assert by_name["#9"]["ordinal"] == 9 and by_name["Program_01"]["file"] == "tests/modules/image_pe.c"
assert [i["name"] for i in pe["imports"] if i["kind"] == "symbol"] == ["OTHER.dll!by_name", "OTHER.dll!#7"]
assert [i["what"] for i in pe["initialisers"]] == ["TLS callback"] * 2 and pe["thread_local"] == 40
assert int(pe["base"], 16) % 65536 == 0 and pe["fixed"] is False and pe["entry_point"] is not None
assert {r["type"]: r["count"] for r in elf["relocations"]} == {"R_X86_64_RELATIVE": 5}
assert [e["size"] > 0 for e in elf["exports"]] == [True] * 6 and elf["stack"]["limit"] == "bounded" and elf["source_lines"]
assert [e["size_from"] for e in elf["exports"]] == ["file"] * 6 and by_name["Program_01"]["size_from"] == "code"
assert max(e["stack"]["bytes"] for e in elf["exports"]) == elf["stack"]["bytes"]
assert flat["exports"] is None and flat["fixed"] and flat["segments"][0]["permissions"] == "r-x"
assert "i386" in bad["defect"] and "exports" not in bad
EOF
expect "the JSON follows tgm-inspect/1" 0

# --- hostile names --------------------------------------------------------------------------------
python3 - "$modules/pe_mingw_x86_64.dll" "$work/hostile.dll" <<'EOF'
import sys
b = bytearray(open(sys.argv[1], "rb").read())
at = b.index(b"OTHER.other\0")
b[at + 6:at + 11] = b"\x1b[2J\n"
open(sys.argv[2], "wb").write(b)
EOF
run "$tgm" inspect "$work/hostile.dll" --json "$work/hostile.json"
expect "a forwarder with escapes in its name" 0 'Program_04 -> OTHER.\x1b[2J\x0a'
lacks "its escapes do not reach the terminal" "$(printf '\033')"
run python3 -c 'import json, sys; assert json.load(open(sys.argv[1]))["imports"][-1]["name"] == "OTHER.\x1b[2J\n"' \
    "$work/hostile.json"
expect "and stand in the JSON as they are" 0
evil=$work/$(printf 'a\033[2Jb.so')
cp "$modules/six.so" "$evil"
run "$tgm" inspect "$evil"
expect "a path with escapes" 0 'a\x1b[2Jb.so  ELF64'
lacks "its escapes do not reach the terminal either" "$(printf '\033')"

# --- files that are no modules --------------------------------------------------------------------
run "$tgm" inspect "$modules/six_i386.so"
expect "an i386 shared object" 1 "no module     a 32-bit little-endian ELF file for i386"
run "$tgm" inspect "$modules/pe_exe_x86_64.exe"
expect "a Windows program" 1 "a program, not a module"
cp "$modules/flat.tgm.bin" "$work/plc.tgm_controller"
run "$tgm" inspect "$work/plc.tgm_controller"
expect "a stamped image" 1 "the vendor's stamp is not documented"
: >"$work/empty"
run "$tgm" inspect "$work/empty"
expect "an empty file" 1 "the file is empty"
run "$tgm" inspect "$work/missing"
expect "a missing file" 2 "No such file"
run "$tgm" inspect "$work"
expect "a directory" 2 "is a directory"

# --- wrong calls ----------------------------------------------------------------------------------
run "$tgm" inspect
expect "no module named" 2 "which module?"
run "$tgm" inspect a b
expect "two modules" 2 "unexpected 'b'"
run "$tgm" inspect --jsn x "$modules/six.so"
expect "unknown option" 2 "did you mean --json?"
run "$tgm" inspect --json "$work/no/such/dir.json" "$modules/six.so"
expect "unwritable JSON" 2 "cannot write"
run "$tgm" inspect --help
expect "help" 0 "--json FILE"

finish
