# SPDX-License-Identifier: GPL-2.0-or-later
"""The Pascal unit of one generation, from the same tables as the C header; used by tools/layout.py.

Names are those of the tables. Pascal does not tell letter cases apart and has other reserved words, hence:
  - a member that is a reserved word is written &Type, &In, &Out (that is how Free Pascal quotes a name)
  - the structure SYSTEM is TGM_SYSTEM, because every Pascal unit already knows a unit of that name
  - a type that TG Motion passes by address has a pointer type with a P in front: PSERVO = ^SERVO
"""
import re

from layout_words import MEMBER_LINES, place_text

SCALARS = {
    "int8_t": "ShortInt", "uint8_t": "Byte", "int16_t": "SmallInt", "uint16_t": "Word",
    "int32_t": "LongInt", "uint32_t": "LongWord", "int64_t": "Int64", "uint64_t": "QWord",
    "float": "Single", "double": "Double", "char": "AnsiChar", "size_t": "SizeUInt", "void *": "Pointer",
}
RENAMED = {"SYSTEM": "TGM_SYSTEM"}
RESERVED = set("""absolute and array as asm begin case class const constructor destructor dispinterface div do downto
    else end except exports file finalization finally for function goto if implementation in inherited
    initialization inline interface is label library mod nil not object of on operator or out packed procedure
    program property raise record reintroduce repeat resourcestring self set shl shr string then threadvar to
    try type unit until uses var while with xor""".split())

# Diagnostic functions, which tgm_plc.h declares by hand for C: comment, then name and signature.
FUNCTIONS_GEN4 = [
    ("Writes text to the console of TG Motion. The result's meaning is not documented.",
     "RTWPRINTF_STRING", "function(text: PWideChar): LongInt; cdecl"),
    ("Writes one 32-bit number to the console; format holds one integer conversion, as in '%d'.",
     "RTWPRINTF_LONG", "function(format: PWideChar; value: LongInt): LongInt; cdecl"),
    ("Writes formatted text to buffer, at most size wide characters with the final #0; returns their number\n"
     "without the final #0, or a negative value when they do not fit. What follows format: LongInt, LongWord,\n"
     "Int64, Double, PWideChar (a literal as PWideChar('...')), Pointer.",
     "SWPRINTF", "function(buffer: PWideChar; size: SizeUInt; format: PWideChar): LongInt; cdecl; varargs"),
    ("Waits; interval^ is a number of 100 ns. Forbidden in Program_04 and Program_05.",
     "SLEEPFT", "procedure(interval: PInt64); cdecl"),
    ("Reserved by the manual: CAN telegram Number with identifier Id and Dlc (0..8) data bytes.",
     "CAN_TRANSMIT", "function(Number, Id, Dlc: LongWord; Tx_Data: PByte): LongInt; cdecl"),
    (None, "CAN_TRANSMITREMOTE", "function(Number, Id, Dlc: LongWord; Tx_Data: PByte): LongInt; cdecl"),
    ("Writes formatted text with a severity (0 information, 1 warning, 2 error) to the console.",
     "RTWPRINTF_EX", "function(severity: LongInt; format: PWideChar): LongInt; cdecl; varargs"),
]
FUNCTIONS_GEN5 = [
    ("Writes finished text to the console. id_and_severity: source (ODS_ID_...) or severity (ODS_SEVERITY_...) shl\n"
     "ODS_SEVERITY_SHIFT. Returns 0.",
     "RTWPRINTF_STRING_SEVERITY", "function(id_and_severity: LongWord; text: PWideChar): LongInt; cdecl"),
    ("Waits; interval^.QuadPart is a number of 100 ns. Forbidden in Program_04.",
     "SLEEPFT", "procedure(interval: %LARGE%); cdecl"),
    ("Sends a CAN telegram with identifier id and dlc (0..8) data bytes. The meanings of number and of the\n"
     "result are not documented.",
     "CAN_TRANSMIT", "function(number, id, dlc: LongWord; data: PByte): LongInt; cdecl"),
    (None, "CAN_TRANSMITREMOTE", "function(number, id, dlc: LongWord; data: PByte): LongInt; cdecl"),
    ("5.02: address of a function or information by name, 0 when there is none; opmode is 0. The one name that\n"
     "is documented is 'pcGetDeviceInfo_v', a GET_DEVICE_INFO.",
     "GET_FUNCTION_OR_INFO", "function(name: PAnsiChar; opmode: LongWord): PtrInt; cdecl"),
    ("Name of the controller: 'PC-realtime', 'PC-demo', 'TGMmini', 'TGMcontroller', 'TGZ+Motion' ...",
     "GET_DEVICE_INFO", "function: PAnsiChar; cdecl"),
]


class NameClash(Exception):
    """Two names of the tables are one name in Pascal."""


def pascal_name(name):
    return "&" + name if name.lower() in RESERVED else name


def type_name(struct):
    return RENAMED.get(struct, struct)


def type_of(row, structs, functions):
    kind = row["c_type"].replace("volatile ", "").replace("const ", "")
    if kind in SCALARS:
        return SCALARS[kind]
    bare = kind.rstrip(" *")
    if kind.endswith("*"):
        return bare if bare in functions else "P" + bare
    return type_name(bare)


def literal(value):
    if re.fullmatch(r"0x[0-9A-Fa-f]+", value):
        return "$" + value[2:]
    if re.fullmatch(r"-?[0-9]+", value):
        return value
    try:
        float(value)
    except ValueError:
        return "'%s'" % value.replace("'", "''")
    return "Double(%s)" % value


def comment(text, indent=""):
    return [indent + "// " + line for line in text.split("\n")]


def check_names(structs, constants, functions):
    seen = {}
    for name in [type_name(s) for s in structs] + ["P" + s for s in structs] + list(functions) + \
            [row["name"] for row in constants]:
        if name.lower() in seen:
            raise NameClash("%s and %s are one name in Pascal" % (name, seen[name.lower()]))
        seen[name.lower()] = name
    for struct in structs.values():
        members = {}
        for row in struct.members:
            if row["member"].lower() in members:
                raise NameClash("%s: %s and %s are one name in Pascal"
                                % (struct.name, row["member"], members[row["member"].lower()]))
            members[row["member"].lower()] = row["member"]


def constants_text(constants):
    out = comment("Constants. \"(g5)\": documented for generation 5 and taken for this one too (L2).") + ["const"]
    for row in constants:
        mark = {"documented": "", "generation 5": " (g5)"}.get(row["evidence"], " (ours: %s)" % row["evidence"])
        out.append("  %-44s = %-18s // %s%s" % (row["name"], literal(row["value"]) + ";", row["note"], mark))
    return out + [""]


def functions_text(table, large):
    out = comment("Diagnostic functions (manual: \"Definition of diagnostic functions\"). TG Motion owns them; they are\n"
                  "valid as long as the module is loaded. Text ends with #0.", "  ")
    for text, name, signature in table:
        out += comment(text, "  ") if text else []
        out.append("  %s = %s;" % (name, signature.replace("%LARGE%", large)))
    return out + [""]


def struct_text(struct, structs, functions):
    name = type_name(struct.name)
    out = ["  // %s: %s; %d bytes." % (name, struct.end["note"], struct.end["offset"]), "  %s = record" % name]
    for row in struct.members:
        kind = type_of(row, structs, functions)
        if row["count"] != 1:
            kind = "array[0..%d] of %s" % (row["count"] - 1, kind)
        volatile = "; changes at any time, read it once" if row["c_type"].startswith("volatile") else ""
        out.append("    %s: %s; // %s: %s%s" % (pascal_name(row["member"]), kind, place_text(row), row["note"], volatile))
    return out + ["  end;", ""]


def pascal_text(name, title, notice, order, structs, constants, is_gen4):
    """name: gen4 ...; order: the structures, every one after those it contains or points to."""
    table = FUNCTIONS_GEN4 if is_gen4 else FUNCTIONS_GEN5
    functions = {row[1] for row in table}
    check_names(structs, constants, functions)
    large = "PPLC_LARGE_INTEGER" if "PLC_LARGE_INTEGER" in structs else "PInt64"
    out = comment("SPDX-License-Identifier: MIT\n"
                  "\n"
                  "tgm_%s.pas - shared memories and PLC_DATA of %s.\n"
                  "%s\n"
                  "\n" % (name, title, notice) + "\n".join(MEMBER_LINES) +
                  "\n&Type is the member Type: Pascal reserves the word.")
    if is_gen4:
        out += comment("\"(5.00)\" behind the offset: no document gives the generation 4 position, the one of generation\n"
                       "5.00 is assumed (docs/decisions.md, L1).")
    out = [line.rstrip() for line in out]
    out += ["{$mode objfpc}", "{$packrecords C}", "{$packenum 4}", "unit tgm_%s;" % name, "", "interface", ""]
    out += constants_text(constants)
    out += ["type"]
    out += ["  P%s = ^%s;" % (s.name, type_name(s.name)) for s in order] + [""]
    out += functions_text(table, large)
    for struct in order:
        out += struct_text(struct, structs, functions)
    return "\n".join(out + ["implementation", "", "end.", ""])
