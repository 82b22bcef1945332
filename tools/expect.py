#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes what is said of the rules' bad fixtures down: conformance/fixtures/RULE/expected.

  tools/expect.py [RULE ...] [--from-evidence DIR]

Read what it changed before it is committed: from then on `tgm selftest` demands it. What another
compiler makes otherwise becomes a star. The form is that of conformance/expected.h.
"""
import argparse
import json
import os
import re
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FIXTURES = os.path.join(ROOT, "conformance", "fixtures")
HEAD = "# What `tgm selftest` expects of the bad modules; written by tools/expect.py.\n"

# Where code and data lie, how many instructions and bytes of stack a compiler makes of a function.
STARS = [
    (r"/[^ |]*/([\w-]+\.scenario)", r"*/\1"), (r"\+0x[0-9a-f]+", "+0x*"), (r"(\(\w+)\.cold\)", r"\1*)"),
    (r"[\d.]+ us of ([\d.]+ us) \(\d+ instructions", r"* us of \1 (* instructions"),
    (r"  \d+ bytes\b", "  * bytes"), (r"takes \d+ bytes", "takes * bytes"),
    (r"byte \d+ of the module's own memory, which has \d+", "byte * of the module's own memory, which has *"),
    (r"byte \d+ of the module's own memory", "byte * of the module's own memory"),
    (r"^(Program_0\d interrupted by .*\|)\d+$", r"\1*"),
    (r"\(0x[0-9a-f]+, \d+ bytes\)", "(0x*, * bytes)"), (r"\b(PointerToRawData|file of) [0-9a-fx]+", r"\1 *"),
]


def general(line):
    for pattern, star in STARS:
        line = re.sub(pattern, star, line)
    return line


def section(fixture):
    lines = [general(line) for line in fixture["findings"].split("\n") if line]
    reasons = {}
    for line in fixture["not_judged"].split("\n"):
        reason, _, rule = line.rpartition("|")
        if rule:
            reasons.setdefault(general(reason), []).append(rule)
    lines += ["not judged: %s|%s" % (reason, " ".join(rules)) for reason, rules in reasons.items()]
    return fixture["name"] + "\n" + "".join("  %s\n" % line for line in lines)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("rules", nargs="*")
    parser.add_argument("--from-evidence", metavar="DIR")
    options = parser.parse_args()
    call = [os.path.join(ROOT, "build", "tgm"), "selftest", "--json"]
    if options.rules:
        call += ["--rule", ",".join(options.rules)]
    if options.from_evidence:
        call += ["--from-evidence", options.from_evidence]
    said = json.loads(subprocess.run(call, stdout=subprocess.PIPE, check=False).stdout)
    for rule in said["rules"]:
        bad = [fixture for fixture in rule["fixtures"] if fixture["bad"]]
        with open(os.path.join(FIXTURES, rule["id"], "expected"), "w", encoding="utf-8") as file:
            file.write(HEAD + "".join(section(fixture) for fixture in bad))


if __name__ == "__main__":
    main()
