# SPDX-License-Identifier: GPL-2.0-or-later
# lib.sh - counted assertions for the shell tests; sourced. Ends with "N passed, M failed".

passed=0
failed=0
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
out=$work/out
err=$work/err

# run COMMAND...: output to $out, errors to $err, status to $status
run() {
    status=0
    "$@" >"$out" 2>"$err" </dev/null || status=$?
}

# script ARGUMENT...: the Python program on standard input, run in the same way
script() {
    cat >"$work/script.py"
    run python3 "$work/script.py" "$@"
}

pass() {
    passed=$((passed + 1))
    [ -z "${VERBOSE:-}" ] || echo "ok      $1"
}

fail() {
    failed=$((failed + 1))
    echo "not ok  $1"
    sed 's/^/        /' "$out" | tail -n 15
    sed 's/^/        /' "$err" | tail -n 15
}

# expect NAME STATUS [TEXT...]: status of the last run, and texts that output or errors must hold
expect() {
    name=$1
    want=$2
    shift 2
    if [ "$status" != "$want" ]; then
        fail "$name (exit $status, not $want)"
        return 0
    fi
    for text in "$@"; do
        if ! cat "$out" "$err" | grep -qF -- "$text"; then
            fail "$name (no '$text')"
            return 0
        fi
    done
    pass "$name"
}

# lacks NAME TEXT: the last run must not have said it
lacks() {
    if cat "$out" "$err" | grep -qF -- "$2"; then fail "$1"; else pass "$1"; fi
}

# last_line NAME PATTERN: the last line of the output matches
last_line() {
    if tail -n 1 "$out" | grep -q -- "$2"; then pass "$1"; else fail "$1"; fi
}

finish() {
    echo "$passed passed, $failed failed"
    [ "$failed" = 0 ]
}
