#!/bin/sh
# SPDX-License-Identifier: MIT
#
# fpc.sh COMPILER [FLAG...] SOURCE - Free Pascal, whose messages are said in a module author's words.
#
# Free Pascal reports what a module must not use by the name of the run-time function that it misses. Here
# this becomes "file:line:column: error: what is wrong; what to do". Exit 1 when there is any error.
# Expects -vr (messages in gcc's form) and -vb (with folders) among the flags; sdk/mk/pascal.mk passes them.
set -u
LC_ALL=C
export LC_ALL

for source in "$@"; do :; done
log=$(mktemp) || exit 2
trap 'rm -f "$log"' EXIT

if ! command -v "$1" >/dev/null 2>&1; then
    echo "fpc.sh: no Free Pascal compiler '$1': install Debian's fp-compiler, or set FPC" >&2
    exit 1
fi
"$@" >"$log" 2>&1
status=$?

# Some messages have no place. It can be but a variable whose type needs clean-up, or the file's first word.
dynamic=$(awk 'tolower($0) ~ /array[ \t]+of/ && !/\(/ {print FNR; exit}' "$source" 2>/dev/null)
first=$(awk 'tolower($0) ~ /^[ \t]*(library|program)[ \t]/ {print FNR; exit}' "$source" 2>/dev/null)

awk -v source="$source" -v dynamic="$dynamic" -v first="$first" -v here="$PWD/" '
    function told(text) {
        print place "error: " text
        errors++
    }
    function reason(name) {
        if (name ~ /thread/)
            return "a threadvar needs an operating system; use a plain variable"
        if (name ~ /rangeerror|overflow|stackcheck/)
            return "run-time checks ({$R+}, {$S+}) need a run-time library to report to; check the value yourself"
        if (name ~ /str|char|concat|lstr|val_|copy$/)
            return "a string needs a heap and a run-time library, a module has neither; use PWideChar or array of WideChar"
        if (name ~ /dynarray|finalize|initialize|addref|decref|setlength/)
            return "a dynamic array or a string needs a heap, a module has none; use an array of fixed length"
        if (name ~ /getmem|freemem|new|help_|dispose/)
            return "there is no heap; declare a variable of the size you need"
        if (name ~ /write|read|output|input|iocheck|reset|rewrite|close|text|assert/)
            return "there is no console and no file; build text with tgm_sdk and print it with pRtWprintf_String of pData^.functions"
        if (name ~ /except|raise|catch|setjmp|done|safecall/)
            return "exceptions need a run-time library; return a value that says what went wrong"
        if (name ~ /variant|olevar|dispatch/)
            return "a variant needs a heap and an operating system, a module has neither"
        if (name ~ /class|obj|intf|vmt|is$|as$/)
            return "a class needs a heap and a run-time library; use a record and procedures"
        return "it needs the run-time library of Free Pascal (" name "), a module is linked to nothing"
    }
    {
        sub(/\r$/, "")
        place = ""
        if (match($0, /^[^ ]+\.(pas|pp|inc|lpr|dpr):[0-9]*(:[0-9]+)?: /)) {
            place = substr($0, 1, RLENGTH)
            if (index(place, here) == 1)
                place = substr(place, length(here) + 1)
            rest = substr($0, RLENGTH + 1)
        } else {
            rest = $0
        }
    }
    rest ~ /Symbol ".*" is deprecated: "module: / {
        split(rest, q, "\"")
        sub(/^module: /, "", q[4])
        told(q[2] ": " q[4])
        next
    }
    rest ~ /Unknown compilerproc "|Cannot find system type "|Internal type "/ {
        split(rest, q, "\"")
        name = tolower(q[2])
        if (place == "")
            place = source ":" (name ~ /finalize|initialize|dynarray/ && dynamic != "" ? dynamic ":" : "") " "
        if (name == "tvmt" || name == "tobject")
            told(reason("class"))
        else if (name == "trelocatethreadvarhandler")
            told(reason("thread"))
        else
            told(reason(name))
        next
    }
    rest ~ /Can.t find unit (fpintres|fpextres|sysinit|si_[a-z0-9]+|sysinit[a-z0-9]+) used by/ {
        place = source ":" (first == "" ? "" : first ":") " "
        told("a module is a unit, not a library or program: begin it with unit, export with public name \047Program_01\047")
        next
    }
    rest ~ /Identifier not found "(TOBJECT|EXCEPTION)"/ { told(reason("class")); next }
    rest ~ /DWARF debug information cannot be used with smart linking/ { next } # sections it has all the same
    rest ~ /^error: Compilation aborted|There were [0-9]+ errors compiling|returned an error exitcode/ { aborted = rest; next }
    rest ~ /^(fatal|error): / { print place rest; errors++; next }
    rest ~ /^(warning|note): / { print place rest; next }
    /^[^ ]*[Ee]rror/ { print; errors++ }
    END { exit errors > 0 }' "$log" >&2
said=$?

if [ "$status" != 0 ] && [ "$said" = 0 ]; then
    cat "$log" >&2
fi
[ "$status" = 0 ] && [ "$said" = 0 ]
