#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Generates everything that follows from sdk/layout/*.tsv.

  tools/layout.py          write the generated files
  tools/layout.py --check  write nothing; fail and name the file when one is out of date

One row of a layout table is one member of one structure; the row "@end" carries the structure's size
and says what the structure is. The generated files are committed so that they can be read and used
without this script.
"""
import csv
import os
import sys

sys.dont_write_bytecode = True  # no __pycache__ beside the sources
from layout_pascal import NameClash, pascal_text
from layout_words import MEMBER_LINES, access_is_ours, access_text, note_fault, place_text, row_fault, unit_text

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LAYOUT = os.path.join(ROOT, "sdk", "layout")

GENERATIONS = {
    "4": dict(tables="tgm4.tsv", name="gen4", select="TGM_GENERATION=4",
              title="TG Motion 4.21 (ids 4033/904/121)"),
    "5.00": dict(tables="tgm5-905.tsv", name="gen5_905",
                 select="TGM_GENERATION=5 and TGM_MEMORY_ID=905", title="TG Motion 5.00 (ids 4034/905/123)"),
    "5.02": dict(tables="tgm5-906.tsv", name="gen5_906",
                 select="TGM_GENERATION=5 and TGM_MEMORY_ID=906", title="TG Motion 5.02 (ids 4034/906/126)"),
}
SCALARS = {
    "int8_t": ("I8", 1), "uint8_t": ("U8", 1), "int16_t": ("I16", 2), "uint16_t": ("U16", 2),
    "int32_t": ("I32", 4), "uint32_t": ("U32", 4), "int64_t": ("I64", 8), "uint64_t": ("U64", 8),
    "float": ("F32", 4), "double": ("F64", 8), "char": ("I8", 1),
}


def fail(message):
    sys.exit("tools/layout.py: " + message)


def rows_of(name):
    path = os.path.join(LAYOUT, name)
    with open(path, newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream, delimiter="\t", quoting=csv.QUOTE_NONE))


def number(row, column, table):
    try:
        return int(row[column], 0)
    except ValueError:
        fail("%s: %s.%s: column %s is '%s', a number is needed"
             % (table, row["struct"], row["member"], column, row[column]))


class Struct:
    def __init__(self, name):
        self.name, self.members, self.end = name, [], None


def load_structs(table):
    structs = {}
    for row in rows_of(table):
        for column in ("count", "offset", "offset_ilp32", "offset_i386", "size"):
            row[column] = number(row, column, table)
        struct = structs.setdefault(row["struct"], Struct(row["struct"]))
        if struct.end is not None:
            fail("%s: %s has rows after its @end" % (table, struct.name))
        if row["member"] == "@end":
            struct.end = row
        else:
            struct.members.append(row)
    for struct in structs.values():
        if struct.end is None:
            fail("%s: %s has no @end row" % (table, struct.name))
        check_struct(struct, structs, table)
    return structs


def bare(c_type):
    return c_type.replace("volatile ", "")


def check_struct(struct, structs, table):
    at = 0
    for row in struct.members:
        where = "%s: %s.%s" % (table, struct.name, row["member"])
        kind = bare(row["c_type"])
        if row["offset"] < at:
            fail("%s: offset %d overlaps what ends at %d" % (where, row["offset"], at))
        if kind in SCALARS and SCALARS[kind][1] * row["count"] != row["size"]:
            fail("%s: %d x %s is not %d bytes" % (where, row["count"], kind, row["size"]))
        if kind in structs and structs[kind].end["offset"] * row["count"] != row["size"]:
            fail("%s: %d x %s is not %d bytes" % (where, row["count"], kind, row["size"]))
        if kind not in SCALARS and kind not in structs and kind != "size_t" and not kind.endswith("*"):
            fail("%s: unknown type %s" % (where, kind))
        if row_fault(row, kind in structs):
            fail("%s: %s" % (where, row_fault(row, kind in structs)))
        at = row["offset"] + row["size"]
    if at > struct.end["offset"]:
        fail("%s: %s: members end at %d, @end says %d" % (table, struct.name, at, struct.end["offset"]))


def in_order(structs):
    """Every structure after the ones it contains or points to."""
    done, order = set(), []

    def visit(struct):
        if struct.name in done:
            return
        done.add(struct.name)
        for row in struct.members:
            pointed = bare(row["c_type"]).replace("const ", "").rstrip(" *")
            if pointed in structs:
                visit(structs[pointed])
        order.append(struct)

    for struct in structs.values():
        visit(struct)
    return order


def constants_of(generation):
    rows = [row for row in rows_of("constants.tsv") if generation in row["generations"].split(",")]
    for row in rows:
        if note_fault(row["note"]):
            fail("constants.tsv: %s: %s" % (row["name"], note_fault(row["note"])))
    return rows


def memories_of(generation):
    return [row for row in rows_of("memories.tsv") if row["generation"] == generation]


def literal(value):
    try:
        n = int(value, 0)
    except ValueError:
        pass
    else:
        if n < 0:
            return "(%s)" % value
        return value + "u" if value.startswith("0x") else value
    try:
        float(value)
        return value
    except ValueError:
        return '"%s"' % value


NOTICE = "Generated by tools/layout.py from sdk/layout/; edit the tables, then run `make layouts`."


def header_text(generation, structs, constants):
    g = GENERATIONS[generation]
    guard = "TGM_LAYOUT_%s_H" % g["name"].upper()
    out = ["/* SPDX-License-Identifier: MIT */",
           "/*",
           " * layout_%s.h - shared memories and PLC_DATA of %s." % (g["name"], g["title"]),
           " * " + NOTICE,
           " *",
           " * Include <tgm_plc.h> with %s, not this file." % g["select"]]
    out += [" * " + line for line in MEMBER_LINES]
    if generation == "4":
        out += [" * \"(5.00)\" behind the offset: no document gives the generation 4 position, the one of generation",
                " * 5.00 is assumed (docs/decisions.md, L1)."]
    out += [" */",
           "#ifndef " + guard, "#define " + guard, ""]
    out += constants_text(constants)
    for struct in in_order(structs):
        out += struct_text(struct, structs)
    out += ["#endif", ""]
    return "\n".join(out)


def constants_text(constants):
    out = ["/* Constants. \"(g5)\": documented for generation 5 and taken for this one too (L2). */"]
    for row in constants:
        mark = {"documented": "", "generation 5": " (g5)"}.get(row["evidence"], " (ours: %s)" % row["evidence"])
        out.append("#define %-44s %-14s /* %s%s */" % (row["name"], literal(row["value"]), row["note"], mark))
    return out + [""]


def counts_of(row, structs):
    """Array length on the three kinds of target: a filler at the end is as long as the rest leaves it."""
    struct = structs[row["struct"]]
    kind = bare(row["c_type"])
    if row is not struct.members[-1] or kind not in SCALARS or row["count"] == 1:
        return (row["count"],) * 3
    room = struct.end["offset_i386"] - row["offset_i386"]
    return row["count"], row["count"], room // SCALARS[kind][1]


def sizes_of(row, structs):
    """Bytes of a member on the three kinds of target."""
    inner = structs.get(bare(row["c_type"]))
    if inner is None:
        return row["size"], row["size"], row["size"] * counts_of(row, structs)[2] // row["count"]
    return tuple(inner.end[column] * row["count"] for column in ("offset", "offset_ilp32", "offset_i386"))


def struct_text(struct, structs):
    out = ["/* %s: %s; %d bytes. */" % (struct.name, struct.end["note"], struct.end["offset"]),
           "typedef struct _%s {" % struct.name]
    for row in struct.members:
        counts = counts_of(row, structs)
        array = "[%d]" % row["count"] if row["count"] != 1 else ""
        if len(set(counts)) > 1:
            array = "[TGM_LAYOUT_PICK(%d, %d, %d)]" % counts
        c_type = row["c_type"]
        gap = "" if c_type.endswith("*") else " "
        out.append("    %s%s%s%s; /* %s: %s */" % (c_type, gap, row["member"], array, place_text(row), row["note"]))
    out += ["} %s;" % struct.name, ""]
    for row in struct.members:
        out.append("TGM_LAYOUT_OFFSET(%s, %s, %d, %d, %d);"
                   % (struct.name, row["member"], row["offset"], row["offset_ilp32"], row["offset_i386"]))
    for row in struct.members:
        if not row["c_type"].endswith("*") and row["c_type"] != "size_t":
            out.append("TGM_LAYOUT_MEMBER_SIZE(%s, %s, %d, %d, %d);"
                       % ((struct.name, row["member"]) + sizes_of(row, structs)))
    end = struct.end
    out += ["TGM_LAYOUT_SIZE(%s, %d, %d, %d);"
            % (struct.name, end["offset"], end["offset_ilp32"], end["offset_i386"]), ""]
    return out


def whole_number(text):
    try:
        return int(text, 0)
    except ValueError:
        return None


def catalogue_text(generation, structs, memories, constants):
    """Rows for harness/host/catalogue.c: macros, so that the table's shape stays that file's business."""
    out = ["/* SPDX-License-Identifier: GPL-2.0-or-later */", "/* " + NOTICE + " */", "",
           "/* CATALOGUE_MEMORY(number, name, root, struct, count, size, pointer offset in PLC_DATA or -1) */"]
    pointers = {row["member"]: row["offset"] for row in structs["PLC_DATA"].members}
    for m in memories:
        if m["pointer"] != "-" and m["pointer"] not in pointers:
            fail("memories.tsv: %s: PLC_DATA has no member %s" % (m["name"], m["pointer"]))
        out.append('CATALOGUE_MEMORY(%s, "%s", "%s", "%s", %s, %s, %d)'
                   % (m["number"], m["name"], m["root"], m["struct"], m["count"], m["size"],
                      pointers.get(m["pointer"], -1)))
    out += ["", "/* CATALOGUE_MEMBER(struct, member, type, struct of the member, count, offset, size, access, who says so, unit, note) */"]
    for struct in in_order(structs):
        if struct.name in ("PLC_DATA", "PLC_IMPORT_FUNCTIONS"):
            continue
        for row in struct.members:
            kind = bare(row["c_type"])
            scalar = SCALARS[kind][0] if kind in SCALARS else "STRUCT"
            by = "ACCESS_OURS" if access_is_ours(row) else "ACCESS_STATED"
            out.append('CATALOGUE_MEMBER("%s", "%s", %s, "%s", %d, %d, %d, "%s", %s, "%s", "%s")'
                       % (struct.name, row["member"], scalar, "" if kind in SCALARS else kind, row["count"],
                          row["offset"], row["size"], row["access"], by, row["unit"], row["note"]))
    out += ["", "/* CATALOGUE_CONSTANT(name, value): those that are whole numbers */"]
    out += ['CATALOGUE_CONSTANT("%s", %d)' % (c["name"], whole_number(c["value"])) for c in constants
            if whole_number(c["value"]) is not None]
    return "\n".join(out + [""])


def asserts_text(generation, structs):
    """One _Static_assert for each row of the table, apart from those of the header."""
    g = GENERATIONS[generation]
    out = ["/* SPDX-License-Identifier: MIT */", "/* " + NOTICE, " * Compile with %s. */" % g["select"],
           "#include <stddef.h>", "#include <tgm_plc.h>", "",
           "#if UINTPTR_MAX > 0xFFFFFFFFu", "#define AT(p8, p4, i386) p8",
           "#elif defined(__i386__) && !defined(_WIN32) && !defined(TGM_ALIGN_DOUBLE)", "#define AT(p8, p4, i386) i386",
           "#else", "#define AT(p8, p4, i386) p4", "#endif", ""]
    for struct in structs.values():
        for row in struct.members:
            out.append('_Static_assert(offsetof(%s, %s) == AT(%d, %d, %d), "");'
                       % (struct.name, row["member"], row["offset"], row["offset_ilp32"], row["offset_i386"]))
        end = struct.end
        out.append('_Static_assert(sizeof(%s) == AT(%d, %d, %d), "");'
                   % (struct.name, end["offset"], end["offset_ilp32"], end["offset_i386"]))
    return "\n".join(out + [""])


def doc_text(generation, structs, memories, constants):
    g = GENERATIONS[generation]
    out = ["# Registers of " + g["title"], "", NOTICE, "",
           "In C: `#include <tgm_plc.h>` with `%s`." % g["select"], "",
           "Names as `tgm run --record` takes them, for example `SERVO[0].Position` or `SYSTEM.Main.Servo_Tick`.",
           "Access is the PLC's: R reads, W writes, RW both, parts: the structure's own members say it; (L5): no document",
           "states it, decision L5 of `docs/decisions.md` does. Offsets are bytes inside the structure, the same on every",
           "target for everything that lies in a shared memory.", "",
           "## Shared memories", "", "| number | name | PLC_DATA member | elements | bytes | evidence | content |",
           "|---|---|---|---|---|---|---|"]
    for m in memories:
        element = "%s x %s" % (m["struct"], m["count"]) if m["struct"] != "-" else "-"
        out.append("| %s | %s | %s | %s | %s | %s | %s |" % (m["number"], m["name"], m["pointer"], element,
                                                         m["size"], m["evidence"], m["note"]))
    for struct in in_order(structs):
        out += ["", "## %s" % struct.name, "", "%s; %d bytes." % (struct.end["note"], struct.end["offset"]), "",
                "| offset | member | type | access | unit | evidence | meaning |", "|---|---|---|---|---|---|---|"]
        for row in struct.members:
            array = "[%d]" % row["count"] if row["count"] != 1 else ""
            out.append("| %d | `%s%s` | %s | %s | %s | %s | %s |"
                       % (row["offset"], row["member"], array, row["c_type"].replace("*", "\\*"), access_text(row),
                          unit_text(row), row["evidence"], row["note"]))
    out += ["", "## Constants", "", "| name | value | evidence | meaning |", "|---|---|---|---|"]
    out += ["| `%s` | %s | %s | %s |" % (c["name"], c["value"], c["evidence"], c["note"]) for c in constants]
    return "\n".join(out + [""])


def pascal_unit(generation, structs):
    g = GENERATIONS[generation]
    try:
        return pascal_text(g["name"], g["title"], NOTICE, in_order(structs), structs, constants_of(generation),
                           generation == "4")
    except NameClash as clash:
        fail("%s: %s" % (g["tables"], clash))


def outputs():
    for generation, g in GENERATIONS.items():
        structs = load_structs(g["tables"])
        memories = memories_of(generation)
        constants = constants_of(generation)
        yield "sdk/include/tgm/layout_%s.h" % g["name"], header_text(generation, structs, constants)
        yield "sdk/pascal/tgm_%s.pas" % g["name"], pascal_unit(generation, structs)
        yield "tests/layouts/asserts_%s.c" % g["name"], asserts_text(generation, structs)
        reference = doc_text(generation, structs, memories, constants)
        yield "docs/registers-%s.md" % g["name"].replace("_", "-"), reference
        yield "harness/host/catalogue_%s.inc" % g["name"], catalogue_text(generation, structs, memories, constants)


def main():
    check = sys.argv[1:] == ["--check"]
    if sys.argv[1:] and not check:
        fail("unknown argument '%s'; allowed: --check" % sys.argv[1])
    stale = []
    for name, text in outputs():
        path = os.path.join(ROOT, name)
        old = open(path, encoding="utf-8").read() if os.path.exists(path) else None
        if old == text:
            continue
        if check:
            stale.append(name)
        else:
            with open(path, "w", encoding="utf-8") as stream:
                stream.write(text)
            print("wrote " + name)
    if stale:
        fail("out of date: %s; run `make layouts` and commit the result" % ", ".join(stale))


if __name__ == "__main__":
    main()
