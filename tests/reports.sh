#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# The forms of a report, held against what others say they are. BUILD names the tree.
set -u
cd "$(dirname "$0")/.."
. tests/lib.sh
build=${BUILD:-build}
tgm=$build/tgm
module=$build/template/shuttle.tgm
fixtures=$build/fixtures
schema=third_party/sarif/sarif-2.1.0-rtm.4.json

# --- one check, every form ------------------------------------------------------------------------
run "$tgm" check "$module" --cycles 100 --json "$work/good.json" --junit "$work/good.xml" \
    --sarif "$work/good.sarif" --html "$work/good.html"
expect "every form at once" 0 "RESULT: PASS"
run "$tgm" check "$fixtures/no-fault/bad.tgm" --cycles 60 --json "$work/bad.json" --junit "$work/bad.xml" \
    --sarif "$work/bad.sarif" --html "$work/bad.html"
expect "and of a module that fails" 1 "RESULT: FAIL"
run "$tgm" check "$fixtures/file-format/bad.tgm" --cycles 60 --junit "$work/none.xml" --sarif "$work/none.sarif" \
    --html "$work/none.html"
expect "and of a file that is no module" 1 "RESULT: FAIL"

run python3 - "$work" <<'EOF'
import json, sys
import xml.etree.ElementTree as tree
work = sys.argv[1]
for name, verdict in ("good", "PASS"), ("bad", "FAIL"):
    report = json.load(open(f"{work}/{name}.json"))
    suites = tree.parse(f"{work}/{name}.xml").getroot()
    sarif = json.load(open(f"{work}/{name}.sarif"))
    html = open(f"{work}/{name}.html", encoding="utf-8").read()
    assert report["verdict"] == verdict
    assert sarif["runs"][0]["properties"]["verdict"] == verdict
    assert f"<b>{verdict}</b>" in html
    ids = [rule["id"] for rule in report["rules"]]
    assert sorted(ids) == sorted(case.get("name") for case in suites.iter("testcase"))
    assert [rule["id"] for rule in sarif["runs"][0]["tool"]["driver"]["rules"]] == ids
    assert all(f">{rule}</td>" in html for rule in ids)
    wrong = [rule["id"] for rule in report["rules"] if rule["outcome"] != "pass"]
    assert sorted(wrong) == sorted(case.get("name") for case in suites.iter("testcase") if len(case))
    assert int(suites.get("tests")) == len(ids) and int(suites.get("failures")) == len(wrong)
EOF
expect "all forms say the same of every rule" 0
run python3 - "$work/good.json" <<'EOF'
import json, sys
report = json.load(open(sys.argv[1]))
coverage = {row["name"]: row for row in report["coverage"]}
for name in "Program_Ini", "Program_01", "Program_04":
    assert 0 < coverage[name]["executed"] <= coverage[name]["total"], coverage[name]
assert coverage["Program_05"]["executed"] == coverage["Program_05"]["total"]
assert "missed" not in coverage["Program_05"]
assert coverage["Program_04"]["missed"].split(":")[0].endswith("shuttle.c")
budgets = {row["name"]: row for row in report["budgets"]}
assert 0 < budgets["Program_04"]["worst"] < budgets["Program_04"]["allowed"], budgets
runs = {run["name"]: run for run in report["runs"]}
assert any(event["text"].endswith("is in OP") for event in runs["cycle-500"]["events"])
EOF
expect "budgets, coverage and runs are in the report" 0
run python3 - "$work/bad.sarif" <<'EOF'
import json, sys
run = json.load(open(sys.argv[1]))["runs"][0]
found = [result for result in run["results"] if result["kind"] == "fail"]
place = found[0]["locations"][0]["physicalLocation"]
assert found[0]["ruleId"] == "no-fault" and found[0]["level"] == "error"
assert place["artifactLocation"]["uri"].endswith("no-fault/bad.c") and place["region"]["startLine"] > 1
assert place["address"]["relativeAddress"] > 0
EOF
expect "SARIF leads to the line" 0

# --- the official schema --------------------------------------------------------------------------
run sh third_party/fetch.sh sarif
if [ "$status" != 0 ]; then
    echo "SKIP  SARIF against its schema: it could not be fetched"
elif ! python3 -c 'import jsonschema' 2>/dev/null; then
    fail "python3-jsonschema is installed (tools/deps.sh test)"
else
    for document in "$work/good.sarif" "$work/bad.sarif" "$work/none.sarif" "$build/reports/rich.sarif"; do
        run python3 - "$schema" "$document" <<'EOF'
import json, sys
import jsonschema
schema = json.load(open(sys.argv[1]))
document = json.load(open(sys.argv[2]))
jsonschema.Draft4Validator.check_schema(schema)
validator = jsonschema.Draft4Validator(schema)
validator.validate(document)
# The validator can refuse: each of these is one fault.
for spoil in (lambda d: d.update(version="2.0.0"),
              lambda d: d["runs"][0].update(surprise=1),
              lambda d: d["runs"][0]["results"][0].update(kind="skipped"),
              lambda d: d["runs"][0]["results"][0].pop("message")):
    spoiled = json.loads(json.dumps(document))
    spoil(spoiled)
    assert not validator.is_valid(spoiled)
EOF
        expect "$(basename "$document") is SARIF 2.1.0 by its official schema" 0
    done
fi

# --- hostile names --------------------------------------------------------------------------------
evil="$work/<img src=x onerror=alert(1)>\"& \$(id) .tgm"
cp "$fixtures/export-names/bad.tgm" "$evil"
run "$tgm" check "$evil" --cycles 20 --junit "$work/evil.xml" --html "$work/evil.html" --sarif "$work/evil.sarif"
expect "a file name made of markup" 1 "RESULT: FAIL"
run python3 - "$work" <<'EOF'
import html.parser, json, sys
import xml.etree.ElementTree as tree
work = sys.argv[1]
class Page(html.parser.HTMLParser):
    elements, said = set(), ""
    def handle_starttag(self, tag, attributes):
        self.elements.add(tag)
        for name, value in attributes:
            assert not name.startswith("on") and name not in ("src", "href"), (tag, name)
            assert name != "style"
    def handle_data(self, data):
        self.said += data
page = Page()
page.feed(open(f"{work}/evil.html", encoding="utf-8").read())
assert not page.elements & {"script", "img", "iframe", "object", "a", "link", "form"}, page.elements
assert "<img src=x onerror=alert(1)>\"& $(id) .tgm" in page.said
assert "<img src=x onerror=alert(1)>" in tree.parse(f"{work}/evil.xml").getroot().get("name")
uri = json.load(open(f"{work}/evil.sarif"))["runs"][0]["artifacts"][0]["location"]["uri"]
assert uri.endswith("/%3Cimg%20src%3Dx%20onerror%3Dalert%281%29%3E%22%26%20%24%28id%29%20.tgm"), uri
EOF
expect "is a name in every form" 0

# --- where they go --------------------------------------------------------------------------------
for form in json junit sarif html; do
    run "$tgm" check "$module" --rule no-imports "--$form" -
    cp "$out" "$work/stdout"
    expect "--$form - prints to standard output" 0
    if grep -q RESULT: "$err" && [ "$(grep -c '^RESULT:' "$work/stdout")" = 0 ]; then
        pass "--$form -: it alone, the text on standard error"
    else
        fail "--$form -: it alone, the text on standard error"
    fi
done
run "$tgm" check "$module" --rule no-imports --html - --json -
expect "two forms on one standard output" 2 "--json and --html cannot both go to '-'"
run "$tgm" check "$module" --rule no-imports --html "$work/x" --junit "$work/x"
expect "two forms in one file" 2 "--junit and --html cannot both go to"
cp "$module" "$work/module.tgm"
run "$tgm" check "$work/module.tgm" --rule no-imports --html "$work/module.tgm"
expect "the module is not overwritten" 2 "is the module itself"
cmp -s "$module" "$work/module.tgm" && pass "not a byte of it" || fail "not a byte of it"
run "$tgm" check "$module" --rule no-imports --json "$work/first" --html "$work/no/such/folder"
expect "a folder that is not there" 2 "cannot write" "No such file"
[ ! -e "$work/first" ] && pass "nothing half-done is left" || fail "nothing half-done is left"
run "$tgm" check "$module" --rule no-imports --html /dev/full
expect "a full disk" 2 "cannot write '/dev/full'"

# --- the same again -------------------------------------------------------------------------------
run "$tgm" check "$fixtures/no-fault/bad.tgm" --cycles 60 --sarif "$work/again.sarif" --html "$work/again.html"
cmp -s "$work/bad.html" "$work/again.html" && cmp -s "$work/bad.sarif" "$work/again.sarif" &&
    pass "the same check gives the same bytes" || fail "the same check gives the same bytes"

finish
