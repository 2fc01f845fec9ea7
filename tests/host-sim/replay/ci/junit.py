#!/usr/bin/env python3
"""junit.py HOST_SIM SOURCES: what `host-sim replay --junit` writes, read by Python's XML parser and held
against exit status and messages, for traces with hostile names and random bounds. Elements and attributes
are those that both schemas in use allow: that of Ant, and that of Jenkins's xUnit plugin."""

import os
import random
import subprocess
import sys
import tempfile
import xml.etree.ElementTree
from datetime import datetime, timedelta, timezone
from pathlib import Path

host_sim, sources = (Path(argument).resolve() for argument in sys.argv[1:])

# By element: its children in their order, and its attributes, all of which stand.
SCHEMA = {
    "testsuite": (
        ["properties", "testcase", "system-out", "system-err"],
        {"name", "tests", "failures", "errors", "skipped", "time", "timestamp", "hostname"},
    ),
    "properties": (["property"], set()),
    "property": ([], {"name", "value"}),
    "testcase": (["error", "failure"], {"classname", "name", "time"}),
    "failure": ([], {"message", "type"}),
    "error": ([], {"message", "type"}),
    "system-out": ([], set()),
    "system-err": ([], set()),
}

NAMES = [
    b"plain.csv",
    b"]]> & <failure> \"quoted\" 'too'.csv",
    b"bell\x07 escape\x1b[31m newline\n tab\t return\r.csv",
    b"not utf-8 \xff\xc3.csv",
    "\ufffe \uffff \ufeff \u2028 \u202e \x85 \U0001f9f5 stra\u00dfe.csv".encode(),
    b"surrogate \xed\xa0\x80 | `code` ${HOME}.csv",
    b"<!-- -- --> <![CDATA[ &#0; &amp; %s {}.csv",
]


def check_schema(element):
    children, attributes = SCHEMA[element.tag]
    assert set(element.attrib) == attributes, element.tag
    places = [children.index(child.tag) for child in element]
    assert places == sorted(places), element.tag
    if element.tag == "testcase":
        assert len(element) <= 1, "some readers know one problem of a case"
    for child in element:
        check_schema(child)


def check(suite, done, traces, began):
    check_schema(suite)
    cases = suite.findall("testcase")
    assert len(cases) == len(traces) == int(suite.get("tests"))
    for problem in ("failure", "error"):
        with_it = [case for case in cases if case.find(problem) is not None]
        assert int(suite.get(problem + "s")) == len(with_it)
    time = datetime.strptime(suite.get("timestamp"), "%Y-%m-%dT%H:%M:%S").replace(tzinfo=timezone.utc)
    assert abs(time - began) < timedelta(minutes=10)
    assert abs(sum(float(case.get("time")) for case in cases) - float(suite.get("time"))) < 0.001 * len(cases)
    # Each line of standard error about a trace is a line of its case, and the other way round.
    said = done.stderr.decode()
    for forbidden in "\ufffe\uffff":  # a terminal may see these, XML must not
        said = said.replace(forbidden, "".join(f"\\x{byte:02X}" for byte in forbidden.encode()))
    said = said.splitlines()
    lines = []
    for case in cases:
        for problem in case:
            lines += [
                # A miss is said with the name before it; an error names the file itself.
                line if problem.tag == "error" else f"{case.get('name')}: {line}"
                for line in problem.text.split("\n")
            ]
            assert problem.get("message").startswith(problem.text.split("\n")[0])
    assert sorted(f"host-sim: {line}" for line in lines) == sorted(said), (lines, said)
    assert done.returncode == (1 if lines else 0)


def replay(folder, arguments):
    return subprocess.run([os.fsencode(host_sim), b"replay", *arguments], cwd=folder, capture_output=True)


def main():
    rng = random.Random(7)
    header, *rows = (sources / "host-sim/traces/200MPa.csv").read_text().splitlines(keepends=True)[:301]
    good = header + "".join(rows)
    unjudged = "".join(line.rsplit(",", 1)[0] + "\n" for line in good.splitlines())
    with tempfile.TemporaryDirectory() as folder:
        for name in NAMES:
            Path(os.fsdecode(os.path.join(os.fsencode(folder), name))).write_text(good)
        Path(folder, "no-reference.csv").write_text(unjudged)
        Path(folder, "broken.csv").write_text("time_s,current_A,voltage_V,load_N\n<&\x01>,1,2,3\n")
        wire = [b"--wire", os.fsencode(sources / "host-sim/traces/units/b.toml")]
        others = [b"missing <&>\x02.csv", b"broken.csv", b"no-reference.csv"]
        kinds = set()
        for turn in range(40):
            some = rng.sample(NAMES, rng.randint(1, len(NAMES)))
            some += rng.sample(others, 0 if turn % 2 == 0 else rng.randint(1, 3))
            rng.shuffle(some)
            bounds = {key: rng.choice([0, 0.05, 0.4, 2, 10, 999]) for key in rng.sample(["mean", "p95", "max"], rng.randint(1, 3))}
            fail_above = ",".join(f"{key}={value}" for key, value in bounds.items())
            began = datetime.now(timezone.utc)
            done = replay(folder, [*wire, b"--fail-above", fail_above.encode(), b"--junit", b"j.xml", b"--summary", b"s.md", *some])
            suite = xml.etree.ElementTree.parse(Path(folder, "j.xml")).getroot()
            check(suite, done, some, began)
            kinds |= {problem.tag for case in suite for problem in case} | {done.returncode}
            summary = Path(folder, "s.md").read_text().splitlines()
            assert len(summary) == 2 + len(some)
        assert {"failure", "error", 0, 1} <= kinds, kinds
        leftover = set(os.listdir(os.fsencode(folder))) - set(NAMES) - {b"no-reference.csv", b"broken.csv"}
        assert leftover == {b"j.xml", b"s.md"}, leftover


main()
