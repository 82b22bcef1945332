# SPDX-License-Identifier: GPL-2.0-or-later
"""What the tables' columns access, unit, evidence and note may say, and how it is put into words.

access    R: TG Motion writes, the PLC reads; W: the PLC writes; RW: both; reserved: nobody uses it;
          parts: the member is a structure, whose own members say it
unit      "-": the value has none (a number of something, a bit, a code); "?": it has one that no
          document states
evidence  where the row is from, and after "; " what is ours in it: "access: ours" (decision L5)
note      the meaning
"""
import re

ACCESS = {"R", "W", "RW", "reserved", "parts"}
ASSUMED = {"assumed-5.00", "none"}
UNIT_WORDS = {"-": "no unit", "?": "unit not stated"}
# A meaning is more than a word, or than the place where somebody may look for it.
NO_MEANING = re.compile(r"\S*|.*\bchapter|(?:low|high) half|field text")

MEMBER_LINES = [
    "Each member states its offset in bytes (64-bit target), its access from the PLC's side (R: TG",
    "Motion writes, the PLC reads; W: the PLC writes; RW: both; parts: its own members say it), its",
    "unit and its meaning. \"(L5)\" behind the access: no document states it, docs/decisions.md does.",
]


def evidence_of(row):
    return row["evidence"].split("; ")


def is_assumed(row):
    """The offset is that of another generation."""
    return evidence_of(row)[0] in ASSUMED


def access_is_ours(row):
    return "access: ours" in evidence_of(row)


def access_text(row):
    return row["access"] + (" (L5)" if access_is_ours(row) else "")


def unit_text(row):
    return UNIT_WORDS.get(row["unit"], row["unit"])


def place_text(row):
    """What stands in front of a member's meaning: "@1220 (5.00) R (L5), us"."""
    return "@%d%s %s, %s" % (row["offset"], " (5.00)" if is_assumed(row) else "", access_text(row), unit_text(row))


def row_fault(row, is_structure):
    """What a row of a structure does not say, or None."""
    if row["access"] not in ACCESS:
        return "access is '%s'; allowed: R, W, RW, reserved, parts" % row["access"]
    if (row["access"] == "parts") != is_structure:
        return "access 'parts' is for members that are structures, and for no others"
    if not row["unit"].strip():
        return "no unit; - when it has none, ? when no document states it"
    if not row["evidence"].strip():
        return "no evidence"
    if row["access"] == "reserved" and row["note"] == "unused":
        return None
    return note_fault(row["note"])


def note_fault(note):
    if NO_MEANING.fullmatch(note.strip()):
        return "'%s' is no meaning" % note
    if "*/" in note or '"' in note or "\\" in note:
        return "note '%s' does not fit into a comment and a string" % note
    return None
