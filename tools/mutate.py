#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Breaks one line of the rules' code at a time and looks whether `tgm selftest` notices.

  tools/mutate.py [--jobs N] [--sample N] [--seed N] [--minutes N] [--fresh] [FILE[:LINE] ...]

Rules judge evidence, and a broken rule changes none of it: what the fixtures do is run and kept once, in
build/evidence (minutes; --fresh: anew), and each mutant judges that. Each is one object compiled anew, and one
program linked, in a folder of its own. Judged are first the fixtures of the rules that the line belongs to, by
their own rule; if nothing is noticed, all fixtures by every rule of the file. A mutant that does not compile, or
whose object is the same, is none. EQUIVALENT lists those that cannot be noticed, each with the reason.
Ends with a table a file, for docs/testing.md, and the lines that nobody noticed. Status 1 below 95 %.
"""
import argparse
import atexit
import concurrent.futures
import functools
import glob
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BUILD = os.path.join(ROOT, "build")
WORK = os.path.join(BUILD, "mutation-%d" % os.getpid())
# What links fastest, if it is there.
LINKER = next((" -fuse-ld=" + name for name in ("lld", "gold") if shutil.which("ld." + name)), "")

# What can be wrong in a line: pattern and what becomes of it.
SWAPS = [
    (r" == ", " != "), (r" != ", " == "), (r" < ", " >= "), (r" > ", " <= "), (r" <= ", " > "), (r" >= ", " < "),
    (r" && ", " || "), (r" \|\| ", " && "), (r"\bif \((?!!)", "if (!"), (r"\btrue\b", "false"),
    (r"\bfalse\b", "true"), (r" \+ 1\b", " + 2"), (r"\breturn ([^;]+);", r"return 0;"), (r"\bcontinue;", ";"),
    (r"\+=", "-="), (r" & ", " | "),
]
STATEMENT = re.compile(r"^    +[a-z_]+\([^{}]*\);$")  # a call alone on its line: left out
SKIP = re.compile(r"^\s*(/?\*|//|#|static const char|_Static_assert)")


# File, line as it is, line as it would be; why no module can tell one from the other.
EQUIVALENT = {
    ("conformance/rules_cycle.c", "return CLASS_HANG;", "return 0;"): "CLASS_HANG is 0",
}


def sources():
    names = sorted(glob.glob(os.path.join(ROOT, "conformance", "rules_*.c")))
    names += [os.path.join(ROOT, "conformance", n) for n in ("incidents.c", "cases.c")]  # budgets.c: the report's
    return [os.path.relpath(n, ROOT) for n in names]


def mutants(path):
    """(line number, new text) of every way to break a line; one a line and kind."""
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        lines = file.read().split("\n")
    for number, line in enumerate(lines):
        if SKIP.match(line) or '"' in line and "finding" in line:
            continue
        for pattern, new in SWAPS:
            changed = re.sub(pattern, new, line, count=1)
            if changed == line or (pattern.startswith(r"\breturn") and re.search(r"return (0|false|true|NULL|\"\");", line)):
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


def wanted(names):
    """(file, line or None for all of them) from FILE and FILE:LINE."""
    for name in names or sources():
        path, _, line = name.partition(":")
        yield path, int(line) - 1 if line else None


def functions(path):
    """(first line, last line, name, whether others can call it, text) of the functions of a file."""
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        lines = file.read().split("\n")
    first = 0
    for number, line in enumerate(lines):
        if line == "}":
            text = "\n".join(lines[first:number + 1])
            head = re.search(r"^(static |)[a-z][\w *]*?\b(\w+)\([^;{}]*\)\n\{", text, flags=re.M)
            if head:
                yield first, number, head.group(2), not head.group(1), text
            first = number + 1


@functools.lru_cache(maxsize=None)
def all_functions():
    return [(file,) + function for file in sources() for function in functions(file)]


@functools.lru_cache(maxsize=None)
def calls(name):
    return [f for f in all_functions() if re.search(r"\b%s\b" % name, f[5])]


@functools.lru_cache(maxsize=None)
def rules_of(path, number=None):
    """Ids of the rules that need the file, or that line of it: those that call, and so on, what stands there."""
    with open(os.path.join(ROOT, "conformance", "rules.def"), encoding="utf-8") as file:
        ids = dict(re.findall(r"^RULE\((\w+),\s*\"([a-z0-9-]+)\"", file.read(), flags=re.M))
    users = [f for f in all_functions() if f[0] == path and (number is None or f[1] <= number <= f[2])]
    for file, _, _, name, shared, _ in users:
        users += [f for f in calls(name) if f not in users and (shared or f[0] == file)]
    names = {f[3][6:] for f in users if f[3].startswith("check_")}
    return [ident for symbol, ident in ids.items() if symbol in names]


def key(path, number, changed):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return path, file.read().split("\n")[number].strip(), changed.strip()


class Runner:
    def __init__(self, options, jobs):
        self.compile_line, self.link_line = commands()
        self.evidence = os.path.join(BUILD, "evidence")
        self.fixtures = os.path.join(BUILD, "fixtures")
        os.makedirs(WORK, exist_ok=True)
        sound = os.path.join(BUILD, "tgm")
        if options.fresh or not os.path.exists(self.evidence):
            shutil.rmtree(self.evidence, ignore_errors=True)
            subprocess.run([sound, "selftest", "--evidence", self.evidence], stdout=subprocess.DEVNULL, check=False)
        if not self.is_right(sound, [], 3600):
            sys.exit("the program that is not broken does not pass on %s: --fresh" % self.evidence)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.seconds = int(5 + 2 * (used.ru_utime + used.ru_stime))  # of the processor; what takes longer does not end
        self.rest = {path: self.link_rest(path) for path in {job[1] for job in jobs}}
        self.deadline = time.time() + options.minutes * 60

    def link_rest(self, path):
        """Everything but the file's object as one: no more is linked for a mutant than has to be."""
        rest = os.path.join(WORK, os.path.basename(path) + ".rest.o")
        objects = [o for o in self.link_line.split() if o.startswith("build/obj/") and o != "build/obj/%s.o" % path[:-2]]
        subprocess.run(["ld", "-r", "-S", "-o", rest] + objects, cwd=ROOT, check=True)
        return rest

    def is_right(self, program, arguments, seconds):
        call = [program, "selftest", "--fixtures", self.fixtures, "--from-evidence", self.evidence, "--first",
                "--jobs", "1"]
        done = subprocess.run(["sh", "-c", 'ulimit -t %d; exec "$@"' % seconds, "sh"] + call + arguments, cwd=ROOT,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        return done.returncode == 0

    def compile(self, path, source, out, optimised):
        line = self.compile_line.replace("build/obj/harness/cli/main.o", out).replace("harness/cli/main.c", source)
        line = re.sub(r" -MMD -MP| -Werror| -W\w+| -g\b", "", line).replace(" -O2", " " + optimised)
        line += " -w -I" + os.path.dirname(path)
        # What a mutant leaves unset must not hold what happens to lie there from the call before.
        line += " -ftrivial-auto-var-init=pattern"
        return subprocess.run(line, shell=True, cwd=ROOT, capture_output=True).returncode == 0

    def is_same(self, path, folder):
        """Whether the compiler makes the same of the mutant as of what is not broken."""
        objects = []
        for source in (path, os.path.join(folder, os.path.basename(path))):
            out = os.path.join(folder, "optimised.o")
            if not self.compile(path, source, out, "-O2"):
                return False
            with open(out, "rb") as file:
                objects.append(file.read())
        return objects[0] == objects[1]

    def build(self, path, number, changed, folder):
        """The mutant's program; None when it is no mutant."""
        with open(os.path.join(ROOT, path), encoding="utf-8") as file:
            lines = file.read().split("\n")
        lines[number] = changed
        os.makedirs(folder, exist_ok=True)
        source, mutant, program = (os.path.join(folder, n) for n in (os.path.basename(path), "mutant.o", "tgm"))
        with open(source, "w", encoding="utf-8") as file:
            file.write("\n".join(lines))
        if not self.compile(path, source, mutant, "-O0"):
            return None
        libraries = [word for word in self.link_line.split() if word.startswith("-l")]
        line = " ".join(["gcc", LINKER, "-o", program, mutant, self.rest[path]] + libraries)
        done = subprocess.run(line, shell=True, cwd=ROOT, capture_output=True)
        return program if done.returncode == 0 else None

    def judge(self, job):
        """A job and what became of it: noticed, missed, none, equivalent, or left for want of time."""
        index, path, number, changed = job
        if time.time() > self.deadline:
            return job, "left"
        if key(path, number, changed) in EQUIVALENT:
            return job, "equivalent"
        folder = os.path.join(WORK, str(index))
        program = self.build(path, number, changed, folder)
        verdict = "none" if program is None else "noticed"
        if program and self.is_unnoticed(program, path, number):
            verdict = "none" if self.is_same(path, folder) else "missed"
        shutil.rmtree(folder, ignore_errors=True)
        return job, verdict

    def is_unnoticed(self, program, path, number):
        near, all_of = rules_of(path, number), rules_of(path)
        if near and not self.is_right(program, ["--own", "--rule", ",".join(near)], self.seconds):
            return False
        if all_of == ["scenario"]:  # other rules' fixtures have none
            return True
        return self.is_right(program, ["--by", ",".join(all_of)] if all_of else [], self.seconds)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("files", nargs="*")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--sample", type=int, default=0, help="so many of all mutants")
    parser.add_argument("--fresh", action="store_true", help="run the fixtures anew")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=600)
    options = parser.parse_args()
    jobs = [(path, number, changed) for path, line in wanted(options.files) for number, changed in mutants(path)
            if line is None or number == line]
    if options.sample or options.minutes < 600:  # what is not reached stays a fair sample
        random.Random(options.seed).shuffle(jobs)
    jobs = [(i,) + job for i, job in enumerate(jobs[:options.sample or None])]
    runner = Runner(options, jobs)
    tally, missed = {}, []
    atexit.register(shutil.rmtree, WORK, ignore_errors=True)
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for done in concurrent.futures.as_completed([pool.submit(runner.judge, job) for job in jobs]):
            (_, path, number, changed), verdict = done.result()
            tally.setdefault(path, {}).setdefault(verdict, 0)
            tally[path][verdict] += 1
            if verdict == "missed":
                missed.append("%s:%d: %s" % (path, number + 1, changed.strip()))
                print("missed  " + missed[-1], flush=True)
            elif verdict == "equivalent":
                print("        %s:%d: %s" % (path, number + 1, EQUIVALENT[key(path, number, changed)]), flush=True)
    print("\n| file | mutants | noticed | missed | equivalent |\n|---|---|---|---|---|")
    rows = [(path, [t.get(v, 0) for v in ("noticed", "missed", "equivalent", "left")]) for path, t in sorted(tally.items())]
    rows.append(("all", [sum(column) for column in zip(*(counts for _, counts in rows))]))
    for path, (noticed, unnoticed, equivalent, left) in rows:
        judged = noticed + unnoticed
        print("| `%s` | %d | %d (%.1f %%) | %d | %d |%s" % (path, judged, noticed, 100.0 * noticed / max(judged, 1), unnoticed,
                                                      equivalent, " %d not reached" % left if left else ""))
    return 0 if noticed >= 0.95 * max(judged, 1) else 1


if __name__ == "__main__":
    sys.exit(main())
