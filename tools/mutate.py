#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Breaks one line of the rules' code at a time and looks whether `tgm selftest` notices.

  tools/mutate.py [--jobs N] [--sample N] [--seed N] [--minutes N] [--quick] [FILE ...]

Each mutant is one object compiled anew and one program linked, in a folder of its own. Run are first the
fixtures of the rules that the file judges, each by its own rule; if they notice nothing, and unless --quick says
so, all fixtures by all rules. A mutant that does not compile, or whose object is the same, is none.
Ends with a table a file, for docs/testing.md, and the lines that nobody noticed. Status 1 below 95 %.
"""
import argparse
import concurrent.futures
import glob
import os
import random
import re
import shutil
import subprocess
import sys
import threading
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BUILD = os.path.join(ROOT, "build")
WORK = os.path.join(BUILD, "mutation")

# What can be wrong in a line: pattern and what becomes of it.
SWAPS = [
    (r" == ", " != "), (r" != ", " == "), (r" < ", " >= "), (r" > ", " <= "), (r" <= ", " > "), (r" >= ", " < "),
    (r" && ", " || "), (r" \|\| ", " && "), (r"\bif \((?!!)", "if (!"), (r"\btrue\b", "false"),
    (r"\bfalse\b", "true"), (r" \+ 1\b", " + 2"), (r"\breturn ([^;]+);", r"return 0;"), (r"\bcontinue;", ";"),
    (r"\+=", "-="), (r" & ", " | "),
]
STATEMENT = re.compile(r"^    +[a-z_]+\([^{}]*\);$")  # a call alone on its line: left out
SKIP = re.compile(r"^\s*(/?\*|//|#|static const char|_Static_assert)")


def sources():
    names = sorted(glob.glob(os.path.join(ROOT, "conformance", "rules_*.c")))
    names += [os.path.join(ROOT, "conformance", n) for n in ("incidents.c", "cases.c", "budgets.c")]
    names += [os.path.join(ROOT, "harness", "host", n) for n in ("audit.c", "digest.c")]
    return [os.path.relpath(n, ROOT) for n in names if os.path.exists(n)]


def mutants(path):
    """(line number, new text) of every way to break a line; one a line and kind."""
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        lines = file.read().split("\n")
    for number, line in enumerate(lines):
        if SKIP.match(line) or '"' in line and "finding" in line:
            continue
        for pattern, new in SWAPS:
            changed = re.sub(pattern, new, line, count=1)
            if changed == line or (pattern.startswith(r"\breturn") and "return 0;" in line):
                continue
            if pattern.startswith(r"\bif"):
                changed = re.sub(r"\bif \((.*)\)(.*)$", r"if (!(\1))\2", line) if line.rstrip().endswith(")") else line
            if changed != line:
                yield number, changed
        if STATEMENT.match(line):
            yield number, ";"


def commands():
    """How the program is linked and an object compiled, as make would."""
    out = subprocess.run(["make", "-n", "-W", "harness/cli/main.c", "V=1", "build/tgm"], cwd=ROOT,
                         capture_output=True, text=True, check=True).stdout
    compile_line = next(l for l in out.split("\n") if "-o build/obj/harness/cli/main.o" in l)
    link_line = next(l for l in out.split("\n") if "-o build/tgm " in l)
    return compile_line, link_line


def rules_of(path):
    """Ids of the rules whose judgement stands in the file; for other files none: all of them are run."""
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        symbols = set(re.findall(r"^void check_(\w+)\(", file.read(), flags=re.M))
    with open(os.path.join(ROOT, "conformance", "rules.def"), encoding="utf-8") as file:
        pairs = re.findall(r"^RULE\((\w+),\s*\"([a-z0-9-]+)\"", file.read(), flags=re.M)
    return [ident for symbol, ident in pairs if symbol in symbols]


class Runner:
    def __init__(self, options):
        self.compile_line, self.link_line = commands()
        self.quick = options.quick
        self.lock, self.said = threading.Lock(), {}
        # As it is now, whatever becomes of the sources meanwhile.
        self.program = os.path.join(WORK, "tgm")
        os.makedirs(WORK, exist_ok=True)
        shutil.copy2(os.path.join(BUILD, "tgm"), self.program)
        self.deadline = time.time() + options.minutes * 60

    def selftest(self, program, rules, own, seconds):
        call = [program, "selftest", "--json", "--fixtures", os.path.join(BUILD, "fixtures"), "--jobs", "1"]
        if rules:
            call += ["--rule", ",".join(rules)]
        if own:
            call.append("--own")
        try:
            done = subprocess.run(call, cwd=ROOT, capture_output=True, timeout=seconds)
        except subprocess.TimeoutExpired:
            return -1, ""
        return done.returncode, done.stdout

    def sound(self, rules, own):
        """What the program that is not broken says of the same fixtures."""
        key = (tuple(rules), own)
        with self.lock:
            if key not in self.said:
                begin = time.time()
                status, said = self.selftest(self.program, rules, own, 3600)
                self.said[key] = status, said, 20 + 4 * (time.time() - begin)
        return self.said[key]

    def notices(self, program, rules, own):
        """'noticed' by selftest itself, 'text' by what its findings say, or 'missed'."""
        sound_status, sound_said, seconds = self.sound(rules, own)
        status, said = self.selftest(program, rules, own, seconds)  # one that does not end is noticed
        return "noticed" if status != sound_status else "text" if said != sound_said else "missed"

    def build(self, path, number, changed, folder):
        """The mutant's program; None when it is no mutant."""
        with open(os.path.join(ROOT, path), encoding="utf-8") as file:
            lines = file.read().split("\n")
        lines[number] = changed
        os.makedirs(folder, exist_ok=True)
        source, mutant, program = (os.path.join(folder, n) for n in (os.path.basename(path), "mutant.o", "tgm"))
        with open(source, "w", encoding="utf-8") as file:
            file.write("\n".join(lines))
        obj = "build/obj/" + path[:-2] + ".o"
        line = self.compile_line.replace("build/obj/harness/cli/main.o", mutant).replace("harness/cli/main.c", source)
        line = line.replace("-MMD -MP", "").replace("-Werror", "") + " -I" + os.path.dirname(path)
        if subprocess.run(line, shell=True, cwd=ROOT, capture_output=True).returncode != 0:
            return None
        line = self.link_line.replace("-o build/tgm ", "-o %s " % program).replace(" %s " % obj, " %s " % mutant)
        done = subprocess.run(line, shell=True, cwd=ROOT, capture_output=True)
        return program if done.returncode == 0 else None

    def judge(self, job):
        index, path, number, changed = job
        if time.time() > self.deadline:
            return job, "left"
        folder = os.path.join(WORK, str(index))
        program = self.build(path, number, changed, folder)
        verdict = "none"
        if program:
            own = rules_of(path)
            verdict = self.notices(program, own, True) if own else "missed"
            if verdict == "missed" and not (own and self.quick):
                verdict = self.notices(program, [], False)
        subprocess.run(["rm", "-rf", folder], check=False)
        return job, verdict


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("files", nargs="*")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--sample", type=int, default=0, help="so many of all mutants")
    parser.add_argument("--quick", action="store_true", help="only the fixtures of the rules that the file judges")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=600)
    options = parser.parse_args()
    jobs = [(path, number, changed) for path in options.files or sources() for number, changed in mutants(path)]
    random.Random(options.seed).shuffle(jobs)
    jobs = [(i,) + job for i, job in enumerate(jobs[:options.sample or None])]
    runner = Runner(options)
    tally, missed = {}, []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for done in concurrent.futures.as_completed([pool.submit(runner.judge, job) for job in jobs]):
            (_, path, number, changed), verdict = done.result()
            tally.setdefault(path, {}).setdefault(verdict, 0)
            tally[path][verdict] += 1
            if verdict == "missed":
                missed.append("%s:%d: %s" % (path, number + 1, changed.strip()))
                print("missed  " + missed[-1], flush=True)
    outcome = sum(t.get("noticed", 0) for t in tally.values())
    noticed = outcome + sum(t.get("text", 0) for t in tally.values())
    judged = noticed + len(missed)
    print("\n| file | mutants | noticed by outcome | by what a finding says |\n|---|---|---|---|")
    for path in sorted(tally):
        by, text = tally[path].get("noticed", 0), tally[path].get("text", 0)
        print("| `%s` | %d | %d | %d |" % (path, by + text + tally[path].get("missed", 0), by, text))
    left = sum(t.get("left", 0) for t in tally.values())
    print("| all | %d | %d | %d (together %.1f %%) |%s" % (judged, outcome, noticed - outcome,
                                         100.0 * noticed / judged if judged else 0,
                                         " %d were not reached" % left if left else ""))
    return 0 if judged and noticed >= 0.95 * judged else 1


if __name__ == "__main__":
    sys.exit(main())
