#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Templates and fixtures on every target, as the tables of docs/targets.md.

  tools/targets.py [--build DIR] [--jobs N] [--whole] [RULE...]

Every template is built, judged and recorded for every target; every fixture that names no target of its own
is built for each and has to be judged there as on elf64: a bad one trips its rule, a good one does not. With
--whole no other rule may be tripped either; for elf64 and the fixtures made for one target `tgm selftest` shows
that. What cannot be built, what cannot be judged and what is judged otherwise is told with its reason; a
difference without one makes the exit status 1. With RULE only those fixtures, and nothing is written. What was
built and judged before is taken from BUILD/targets_report.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import re
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PAGE = os.path.join(ROOT, "docs", "targets.md")
BEGIN, END = "<!-- make targets-report: begin -->", "<!-- make targets-report: end -->"
FIXTURES = os.path.join(ROOT, "conformance", "fixtures")

# Name, what fixture.sh calls it, profile, ending.
TARGETS = [("elf64", "elf64", "pc4", ".tgm"), ("pe64", "pe64", "pc4", ".tgm"), ("pe32", "pe32", "pc4", ".tgm"),
           ("tgmmini", "arm", "tgmmini", ".tgm"), ("tgmcontroller", "flat", "tgmcontroller", ".tgm.bin")]
TEMPLATES = [("c", "C"), ("cpp", "C++"), ("pascal", "Pascal")]
PASCAL_TARGETS = ("elf64", "pe64")
RECORD = ",".join("SERVO[0]." + name for name in ("Position", "WritePosition", "WriteSpeed", "Status", "Control", "ControlWord", "Mode"))
CYCLES, SECONDS = "60", 4

FIXTURE_CFLAGS = ("-O2 -g -ffreestanding -fPIC -fvisibility=hidden -fshort-wchar -fno-stack-protector "
                  "-fno-asynchronous-unwind-tables -Wall -Wextra -Werror -Isdk/include -Iconformance/fixtures")

# (rule, fixture, target): why no file of it can be made there.
NOT_BUILT = [
    ("data-not-executable", "bad", "pe64|pe32", "headers, tables and code of a PE file lie apart always"),
    ("data-not-executable", "bad-table", "pe64|pe32", "symbols of a PE file do not say what is data"),
    ("export-code", "bad-declared", "pe64|pe32", "symbols of a PE file do not say what is data"),
    ("export-code", "bad-indirect", "pe64|pe32|tgmcontroller", "only ELF has indirect functions"),
    ("relative-relocations", "bad", "pe64|pe32|tgmcontroller", "only ELF has indirect functions"),
    ("export-names", "bad|bad-hidden|bad-mangled|bad-missing|bad-pascal|bad-underscore", "pe64|pe32",
     "the linker refuses: the SDK's .def file exports a function that is not there"),
    ("export-names", "bad", "tgmcontroller", "the linker refuses: GetProcAddress of the SDK returns a function that is not there"),
    ("export-names", "bad-twice", "pe32", "_Program_05 is how every compiler for i386 names Program_05"),
    ("fits-memory", "bad", "tgmcontroller", "the linker refuses: it does not fit into the SDK's flat.ld"),
    ("no-executable-stack", "bad|bad-unstated", "pe64|pe32", "a PE file says it by another mark: bad-windows, bad-pe32"),
    ("no-executable-stack", "bad-unstated", "tgmmini|tgmcontroller", "the linkers for Arm that are used here always say it"),
    ("no-imports", "bad|bad-sin|bad-pointer", "pe64|pe32|tgmcontroller", "the linker refuses what is undefined"),
    ("no-imports", "bad-library", "tgmcontroller", "a flat image cannot name a library"),
    ("no-initialisers", "bad|bad-fini", "tgmcontroller", "the linker refuses: the SDK's flat.ld has no place for initialisers"),
    ("no-initialisers", "bad-init", "pe64|pe32", "only ELF has DT_INIT"),
    ("no-text-relocations", "bad", "pe64", "the rule is about ELF: a PE file's code may be relocated"),
    ("no-tls", "bad", "pe64|pe32", "mingw has thread-local variables by a library, which the linker refuses: bad-pe64"),
    ("no-tls", "bad", "tgmcontroller", "the linker refuses: the SDK's flat.ld has no place for thread-local storage"),
    ("no-writable-code", "bad|bad-function|good", "pe64|pe32", "sets the flags of a section as ELF names them: bad-windows, bad-msvc64"),
]
# What holds of every fixture with this in its source, when the assembler refuses it.
MACHINE_CODE = r"__asm__|hidden\.h"
PROCESSORS = {"pe64": "is in machine code for ELF", "pe32": "is in machine code of x86-64"}
OTHER_PROCESSOR = "is in machine code of x86"
# (rule, fixture, target): why it is judged otherwise there.
DIFFERENCES = [
    ("data-size", "bad-larger", "tgmcontroller",
     "writes past its array, but not past the 8 MiB that a controller gives the module: no other's memory is harmed"),
    ("export-code|budget-program-05", "bad|bad-declared", "tgmcontroller",
     "sins in Program_05, which GetProcAddress does not return"),
    ("no-sleep", "bad-05", "tgmcontroller", "sins in Program_05, which GetProcAddress does not return"),
    ("budget-background", "bad", "tgmcontroller", "the controllers have no budget for Program_01 to Program_03"),
    ("globals-independent", "bad.*", "tgmcontroller",
     "variables with a value are part of the image, and GetProcAddress clears the others"),
    ("restart", "bad.*", "tgmcontroller", "GetProcAddress, which each start calls, clears the variable"),
    ("no-stray-write", "bad-constant", "tgmcontroller", "a flat image does not say what of it is constant"),
    ("no-executable-stack", "bad", "tgmcontroller", "a flat image says nothing about its stack"),
    ("no-imports", "bad-library", "pe64|pe32", "a PE file names no library of which it calls nothing"),
    ("no-imports", "bad-weak", "pe64|pe32|tgmcontroller", "the linker settles a weak name that is not there: it is 0"),
    ("no-initialisers", "bad-init", "tgmcontroller", "only ELF has DT_INIT"),
    ("no-privileged-instruction", "bad-halt", "tgmmini|tgmcontroller", "hlt is no instruction of a Cortex-A9"),
    ("no-runtime-library", "bad.*", "tgmcontroller", "a flat image has no names by which a library is known"),
    ("no-writable-code", "bad|bad-function", "tgmcontroller", "a flat image has no sections with flags"),
    ("relative-relocations", "bad-symbolic", "pe64|pe32|tgmcontroller", "only ELF looks up a file's own names when it is loaded"),
    ("export-names", "bad-.*", "pe64|pe32", "what is exported is what the SDK's .def file lists, whatever the source says"),
    ("export-names", "bad-.*", "tgmcontroller", "a flat image has no names: its functions are those that GetProcAddress returns"),
]

# (rule, fixture, target, rule that is tripped as well): why, when it is judged by every rule (--whole).
OTHERS = [
    ("no-imports", "bad-weak", "pe64|pe32", "stack-bounded", "the weak name that it calls is 0: the stack cannot be followed there"),
    ("no-privileged-instruction", "bad-halt", "tgmmini|tgmcontroller", "stack-bounded",
     "hlt is no instruction of a Cortex-A9: the stack cannot be followed beyond it"),
    ("set-point-steps", "bad", "tgmcontroller", "no-jump-on-enable",
     "the controllers send what Program_04 writes in the same cycle: the first step is there when the axis is enabled"),
    ("waits-for-bus", "bad", "tgmmini", "inputs-first", "the compiler for Arm writes Mode before it reads Position"),
]


def run(command, **more):
    return subprocess.run(command, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, errors="replace", **more)


def first_error(text):
    for line in text.splitlines():
        if re.search(r"error|Error|undefined|unrecogni", line):
            return re.sub(r"^\S*/", "", line.strip())
    return (text.strip().splitlines() or ["no message"])[-1]


def reason_of(table, cell):
    for rule, name, target, reason in table:
        if re.fullmatch(rule, cell.rule) and re.fullmatch(name, cell.name) and re.fullmatch(target, cell.target):
            return reason
    return None


def why_not_built(cell, source, text):
    reason = reason_of(NOT_BUILT, cell)
    if reason is None and re.search(r"Error: |asm|unrecognized command-line option|register", text):
        with open(os.path.join(ROOT, source), encoding="utf-8") as stream:
            if re.search(MACHINE_CODE, stream.read()):
                return PROCESSORS.get(cell.target, OTHER_PROCESSOR)
    return reason


def digest(words, *paths):
    found = hashlib.sha256("\0".join(words).encode())
    for path in paths:
        if path:
            with open(path, "rb") as stream:
                found.update(hashlib.sha256(stream.read()).digest())
    return found.hexdigest()


def judge(tgm, path, profile, scenario, cycles=CYCLES, rule=None):
    """The report of one module, by all rules or by one. It is kept under the hash of all that it depends on, so that
    a second run is quick; one by all rules serves for any."""
    command = [tgm, "check", path, "--profile", profile, "--json", "-", "--jobs", "1", "--cycles", cycles]
    if scenario:
        command += ["--scenario", scenario]
    kept = kept_at(command, tgm, path, scenario)
    if rule and not os.path.exists(kept):
        command += ["--rule", rule]
        kept = kept_at(command, tgm, path, scenario)
    if os.path.exists(kept):
        with open(kept, encoding="utf-8") as stream:
            return json.load(stream), ""
    result = run(command, timeout=600)
    text = result.stdout
    try:
        report, _ = json.JSONDecoder().raw_decode(text[text.index("{"):])
    except ValueError:
        return None, (result.stderr or text).strip()[-200:]
    os.makedirs(os.path.dirname(kept), exist_ok=True)
    with open(kept + ".new", "w", encoding="utf-8") as stream:
        json.dump(report, stream)
    os.replace(kept + ".new", kept)
    return report, ""


def kept_at(command, tgm, path, scenario):
    return os.path.join(os.path.dirname(tgm), "targets_report", "verdicts", digest(command[2:], tgm, path, scenario) + ".json")


class Cell:
    """One fixture on one target."""

    def __init__(self, rule, name, target):
        self.rule, self.name, self.target = rule, name, target
        self.kind, self.reason = "", ""  # same, not built, not judged, explained, UNEXPLAINED

    def settle(self, kind, reason=""):
        self.kind, self.reason = kind, reason
        return self


def compare(cell, report):
    failed = {r["id"] for r in report["rules"] if r["outcome"] == "fail"}
    open_ = {r["id"]: r.get("reason", "") for r in report["rules"] if r["outcome"] == "not judged"}
    wanted = {cell.rule} if cell.name.startswith("bad") else set()
    if failed == wanted:
        return cell.settle("same")
    reason = reason_of([row[:3] + row[4:] for row in OTHERS if failed - wanted == {row[3]}], cell)
    if reason is not None:
        return cell.settle("explained", reason)
    if failed - wanted:
        return cell.settle("UNEXPLAINED", "fails %s" % ", ".join(sorted(failed)))
    reason = reason_of(DIFFERENCES, cell)
    if reason is not None:
        return cell.settle("explained", reason)
    if cell.rule in open_:
        return cell.settle("not judged", open_[cell.rule])
    return cell.settle("UNEXPLAINED", "fails nothing")


def common_sources():
    """Everything that fixtures are made of besides their own folder."""
    yield os.path.join(ROOT, "tests", "fixture.sh")
    for folder in (FIXTURES, *(os.path.join(ROOT, "sdk", name) for name in ("include", "include/tgm", "src", "link"))):
        for name in sorted(os.listdir(folder)):
            if os.path.isfile(os.path.join(folder, name)):
                yield os.path.join(folder, name)


def build_fixture(source, out, kind, common):
    """None when there is a file, else what compiler and linker said. Nothing is made twice of the same."""
    flags = "-include conformance/fixtures/generation5.h" if kind in ("arm", "flat") else ""
    folder = os.path.join(ROOT, os.path.dirname(source))
    own = [os.path.join(folder, name) for name in sorted(os.listdir(folder))]
    key, said = digest([common, kind, FIXTURE_CFLAGS, flags, source], *own), out + ".said"
    if os.path.exists(said):
        with open(said, encoding="utf-8") as stream:
            made_of, text = stream.read().split("\n", 1)
        if made_of == key:
            return None if os.path.exists(out) else text
    os.makedirs(os.path.dirname(out), exist_ok=True)
    if os.path.exists(out):
        os.remove(out)
    environment = dict(os.environ, FIXTURE_CFLAGS=FIXTURE_CFLAGS, FIXTURE_TARGET=kind, FIXTURE_FLAGS=flags, MAKEFLAGS="")
    built = run(["sh", "tests/fixture.sh", source, out], env=environment)
    text = built.stderr + built.stdout
    if built.returncode != 0 and os.path.exists(out):
        os.remove(out)
    with open(said, "w", encoding="utf-8") as stream:
        stream.write(key + "\n" + text)
    return None if os.path.exists(out) else text


def scenario_for(source, out, kind):
    """Its own, or the one for all beside the fixture; generation 5 has In[0] and Out[0] for what generation 4 calls In0 and Out0."""
    path = os.path.splitext(source)[0] + ".scenario"
    if not os.path.exists(os.path.join(ROOT, path)):
        path = os.path.join(os.path.dirname(source), "machine.scenario")
    if not os.path.exists(os.path.join(ROOT, path)) or kind not in ("arm", "flat"):
        return path if os.path.exists(os.path.join(ROOT, path)) else None
    with open(os.path.join(ROOT, path), encoding="utf-8") as stream:
        text = re.sub(r"\.(In|Out)([01])\b", r".\1[\2]", stream.read())
    with open(out + ".scenario", "w", encoding="utf-8") as stream:
        stream.write(text)
    return out + ".scenario"


def try_fixture(arguments):
    build, tgm, source, target, common, whole = arguments
    name, kind, profile, ending = target
    rule = os.path.basename(os.path.dirname(source))
    stem = os.path.splitext(os.path.basename(source))[0]
    cell = Cell(rule, stem, name)
    out = os.path.join(build, "targets_report", name, rule, stem + ending)
    text = build_fixture(source, out, kind, common)
    if text is not None:
        reason = why_not_built(cell, source, text)
        if reason is None:
            return cell.settle("UNEXPLAINED", "is not built: " + first_error(text))
        return cell.settle("not built", reason)
    report, trouble = judge(tgm, out, profile, scenario_for(source, out, kind), rule=None if whole else rule)
    return compare(cell, report) if report else cell.settle("UNEXPLAINED", trouble)


def fixture_sources(rules):
    for rule in sorted(os.listdir(FIXTURES)):
        folder = os.path.join(FIXTURES, rule)
        if not os.path.isdir(folder) or (rules and rule not in rules):
            continue
        for name in sorted(os.listdir(folder)):
            path = os.path.join(folder, name)
            if re.fullmatch(r"(bad|good).*\.(c|cpp|S)", name):
                with open(path, encoding="utf-8") as stream:
                    head = [next(stream, "") for _ in range(4)]
                if not any("target: " in line for line in head):
                    yield os.path.relpath(path, ROOT)


# --- templates ---------------------------------------------------------------------------------------------


def build_template(build, language, target, profile, rebuild):
    out = os.path.join(build, "targets_report", "templates", "%s-%s%s" % (language, target, "-as-" + profile if rebuild else ""))
    command = ["make", "-s", "--no-print-directory", "-C", "templates/" + language, "TARGET=" + target, "BUILD=" + out]
    if rebuild:
        command.append("TGM_PROFILE=" + profile)
    result = run(command)
    if result.returncode != 0:
        sys.exit("tools/targets.py: %s for %s: %s" % (language, target, first_error(result.stderr)))
    return os.path.join(out, "shuttle.tgm" + (".bin" if target == "tgmcontroller" else ""))


def record(build, tgm, path, profile):
    csv = os.path.join(build, "targets_report", "recording.csv")
    best = None
    for _ in range(2):
        begin = time.monotonic()
        result = run([tgm, "run", path, "--profile", profile, "--cycle", "500", "--for", "%ds" % SECONDS,
                      "--record", RECORD, "--csv", csv])
        took = time.monotonic() - begin
        if result.returncode != 0:
            sys.exit("tools/targets.py: %s: %s" % (path, result.stderr or result.stdout))
        best = took if best is None or took < best else best
    with open(csv, "rb") as stream:
        return hashlib.sha256(stream.read()).hexdigest(), SECONDS / best


def template_rows(build, tgm):
    unexplained = 0
    for language, title in TEMPLATES:
        cells, speeds = [], []
        for target, _, profile, _ in TARGETS:
            if language == "pascal" and target not in PASCAL_TARGETS:
                cells.append("–")
                speeds.append("–")
                continue
            path = build_template(build, language, target, profile, False)
            rebuild = target.startswith("tgm")
            reference = build_template(build, language, "elf64", profile, rebuild)
            report, trouble = judge(tgm, path, profile, None, "400")
            if report is None:
                sys.exit("tools/targets.py: %s: %s" % (path, trouble))
            same = record(build, tgm, reference, profile)[0]
            found, speed = record(build, tgm, path, profile)
            counts = report["counts"]
            good = report["verdict"] == "PASS" and counts["failed"] == 0 and same == found
            unexplained += not good
            cells.append("%s (%d passed), %s" % (report["verdict"], counts["passed"], "recorded" if target == "elf64" else
                                                 "same recording" if same == found else "**another recording**"))
            speeds.append("%.0f" % speed)
        yield title, cells, speeds
    if unexplained:
        print("%d templates are not as they should be" % unexplained, file=sys.stderr)
        template_rows.unexplained = unexplained


template_rows.unexplained = 0


# --- the page ----------------------------------------------------------------------------------------------


def mark(cells):
    """What became of the fixtures of one rule on one target."""
    same = sum(c.kind == "same" for c in cells)
    parts = ["%d" % same] if same else []
    for kind, sign in (("not built", "–"), ("not judged", "?"), ("explained", "≠"), ("UNEXPLAINED", "!")):
        count = sum(c.kind == kind for c in cells)
        if count:
            parts.append("%s%d" % (sign, count))
    return " ".join(parts)


def fixture_lines(cells):
    names = [t[0] for t in TARGETS]
    yield "| rule | " + " | ".join(names) + " |"
    yield "|---" * (len(names) + 1) + "|"
    for rule in sorted({c.rule for c in cells}):
        yield "| `%s` | " % rule + " | ".join(mark([c for c in cells if c.rule == rule and c.target == n]) for n in names) + " |"
    yield "| **all** | " + " | ".join(mark([c for c in cells if c.target == n]) for n in names) + " |"


def reason_lines(cells):
    for kind, title in (("not built", "Not built (–)"), ("not judged", "Not judged (?)"), ("explained", "Judged otherwise (≠)"),
                        ("UNEXPLAINED", "Unexplained (!)")):
        found = [c for c in cells if c.kind == kind]
        if not found:
            continue
        yield ""
        yield title + ":"
        yield ""
        for reason in sorted({c.reason for c in found}):
            places = {}
            for c in found:
                if c.reason == reason:
                    places.setdefault("%s/%s" % (c.rule, c.name), []).append(c.target)
            yield "- %s: %s" % (reason, "; ".join("`%s` (%s)" % (k, ", ".join(v)) for k, v in sorted(places.items())))


def page(templates, cells):
    yield BEGIN
    yield ""
    yield "Made by `make targets-report`. Recordings are compared byte by byte with those of the same source for `elf64`"
    yield "(on the controllers: of its rebuild under their profile), %d s at 500 us of every register a template's axis has." % SECONDS
    yield ""
    names = [t[0] for t in TARGETS]
    yield "| template | " + " | ".join(names) + " |"
    yield "|---" * (len(names) + 1) + "|"
    for title, row, _ in templates:
        yield "| %s | " % title + " | ".join(row) + " |"
    yield ""
    yield "Fixtures that are made for no one target, and are judged on a target as on `elf64`: a bad one trips its rule, a good one"
    yield "does not. Besides: – cannot be built for it, ? its rule cannot be judged there, ≠ judged otherwise for a stated reason."
    yield "Fixtures made for one target (damaged files, machine code) are judged by `tgm selftest`."
    yield ""
    yield from fixture_lines(cells)
    yield from reason_lines(cells)
    yield ""
    yield END


def write_page(lines):
    with open(PAGE, encoding="utf-8") as stream:
        text = stream.read()
    block = "\n".join(lines)
    if BEGIN in text:
        text = text[:text.index(BEGIN)] + block + text[text.index(END) + len(END):]
    else:
        text = text.rstrip("\n") + "\n\n## The same on every target\n\n" + block + "\n"
    with open(PAGE, "w", encoding="utf-8") as stream:
        stream.write(text)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", default="build")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--whole", action="store_true", help="judge each fixture by all rules, not by its own alone")
    parser.add_argument("rules", nargs="*")
    options = parser.parse_args()
    build = os.path.join(ROOT, options.build)
    tgm = os.path.join(build, "tgm")
    common = digest([], *common_sources())
    work = [(build, tgm, source, target, common, options.whole) for source in fixture_sources(options.rules) for target in TARGETS]
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        cells = list(pool.map(try_fixture, work))
    bad = [c for c in cells if c.kind == "UNEXPLAINED"]
    if options.rules:
        print("\n".join(list(fixture_lines(cells)) + list(reason_lines(cells))))
    else:
        write_page(page(list(template_rows(build, tgm)), cells))
    for c in bad:
        print("unexplained: %s/%s on %s: %s" % (c.rule, c.name, c.target, c.reason), file=sys.stderr)
    return 1 if bad or template_rows.unexplained else 0


if __name__ == "__main__":
    sys.exit(main())
