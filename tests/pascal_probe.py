#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes FOLDER/probe.pas and FOLDER/rows.h of one generation: what tests/pascal.sh compares by running.

  tests/pascal_probe.py gen4|gen5_905|gen5_906 FOLDER

probe.pas fills a table with offset and size of every member and the size of every structure as Free Pascal
has them, with the records of tgm_sdk.pas; rows.h gives the same rows as C has them.
"""
import os
import re
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "tools"))
import layout  # noqa: E402
import layout_pascal  # noqa: E402


def sdk_records():
    """Name and members of every record of tgm_sdk.pas."""
    with open(os.path.join(layout.ROOT, "sdk", "pascal", "tgm_sdk.pas"), encoding="utf-8") as stream:
        for name, body in re.findall(r"^  (tgm_\w+) = record$(.*?)^  end;$", stream.read(), re.M | re.S):
            yield name, re.findall(r"^    (\w+):", body, re.M)


def main(name, folder):
    g = next(g for g in layout.GENERATIONS.values() if g["name"] == name)
    structs = layout.load_structs(g["tables"])
    pas = ["unit probe;", "interface", "uses tgm_%s, tgm_sdk;" % name,
           "procedure pascal_probe(at: PLongWord); cdecl; public name 'pascal_probe';", "implementation",
           "var row: PLongWord;",
           "procedure put(offset, size: PtrUInt);", "begin", "  row[0] := offset;", "  row[1] := size;", "  Inc(row, 2);", "end;"]
    calls, rows = [], []
    for i, struct in enumerate(structs.values()):
        pas += ["procedure s%d(r: P%s);" % (i, struct.name), "begin"]
        for member in struct.members:
            field = "r^." + layout_pascal.pascal_name(member["member"])
            pas.append("  put(PtrUInt(@%s) - PtrUInt(r), SizeOf(%s));" % (field, field))
            rows.append("ROW(%s, %s)" % (struct.name, member["member"]))
        pas += ["  put(SizeOf(r^), SizeOf(%s));" % layout_pascal.type_name(struct.name), "end;"]
        rows.append("END(%s)" % struct.name)
        calls.append("  s%d(Pointer(PtrUInt(65536)));" % i)
    for record, members in sdk_records():
        c_name = record if record == "tgm_text" else "struct " + record
        calls.append("  %s_rows(Pointer(PtrUInt(65536)));" % record)
        pas += ["type P_%s = ^%s;" % (record, record), "procedure %s_rows(r: P_%s);" % (record, record), "begin"]
        for member in members:
            pas.append("  put(PtrUInt(@r^.%s) - PtrUInt(r), SizeOf(r^.%s));" % (member, member))
            rows.append("ROW(%s, %s)" % (c_name, member))
        pas += ["  put(SizeOf(r^), SizeOf(r^));", "end;"]
        rows.append("END(%s)" % c_name)
    pas += ["procedure pascal_probe(at: PLongWord); cdecl;", "begin", "  row := at;"] + calls + ["end;", "end.", ""]
    with open(os.path.join(folder, "probe.pas"), "w", encoding="utf-8") as stream:
        stream.write("\n".join(pas))
    with open(os.path.join(folder, "rows.h"), "w", encoding="utf-8") as stream:
        stream.write("\n".join(rows + [""]))
    print(len(rows))


main(sys.argv[1], sys.argv[2])
