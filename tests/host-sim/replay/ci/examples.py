#!/usr/bin/env python3
"""examples.py HOST_SIM SOURCES: each line with host-sim of host-sim/examples/ci, as a shell runs it, in a
folder with two traces: it passes with bounds that are kept, and ends with 1 and its files written where one
is missed. The workflows are YAML."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree
from pathlib import Path

host_sim, sources = (Path(argument).resolve() for argument in sys.argv[1:])
examples = sources / "host-sim/examples/ci"
traces = sources / "host-sim/traces"


def check_yaml(text, name):
    """The few forms of YAML that the workflows keep to: keys with values, lists, blocks of text. Where
    Python has a parser, that one decides as well."""
    block = None
    depths = [0]
    for number, line in enumerate(text.splitlines(), 1):
        place = f"{name}:{number}: {line}"
        depth = len(line) - len(line.lstrip(" "))
        if not line.strip() or (block is not None and depth > block):
            continue
        block = None
        assert depth % 2 == 0 and "\t" not in line, place
        if line.lstrip().startswith("#"):
            continue
        assert depth <= depths[-1] + 2, place
        depths = [d for d in depths if d < depth] + [depth]
        item = re.fullmatch(r"(- )?(?:([\w-]+):(?: (.+))?|([^:].*))", line.strip())
        assert item and (item[2] or item[1]), place
        # A value that begins with a sign of YAML, or has a comment or a second key in it, needs quotes.
        value = item[3] or item[4] or ""
        assert not re.search(r": |:$| #", value) and not value.startswith(tuple("`@%&*!'\"{")), place
        assert value == "|" or not value.startswith(("|", ">")), place
        if item[1]:
            depths.append(depth + 2)
        if value == "|":
            block = depth
    try:
        import yaml
    except ImportError:
        return
    assert isinstance(yaml.safe_load(text), dict), name


def commands(name):
    text = (examples / name).read_text()
    found = re.findall(r"^ *(?:- )?(host-sim .*)$", text, re.MULTILINE)
    assert found, f"{name} has no line with host-sim"
    # Every mention of a run is one of those lines.
    assert len(found) == len(re.findall(r"host-sim replay --", text)), name
    return found


def run(line, work):
    environment = {
        "PATH": f"{host_sim.parent}:/usr/bin:/bin",
        "LC_ALL": "C.UTF-8",
        "GITHUB_STEP_SUMMARY": str(work / "step.md"),
    }
    return subprocess.run(["bash", "-ec", line], cwd=work, env=environment, capture_output=True, text=True)


def prepare(work, expect):
    recordings = work / "recordings"
    recordings.mkdir()
    for pressure in (100, 200):
        rows = (traces / f"{pressure}MPa.csv").read_text().splitlines(keepends=True)[:3001]
        (recordings / f"run-{pressure}MPa.csv").write_text("".join(rows))
    shutil.copy(traces / "units/b.toml", recordings / "wire.toml")
    (recordings / "expect.toml").write_text(expect)


def check(name, line, expect, status, failed):
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        prepare(work, expect)
        done = run(line, work)
        about = f"{name}: {line}: {done.returncode}\n{done.stdout}{done.stderr}"
        wanted = status if "--expect" in line else 0
        assert done.returncode == wanted, about
        if "--junit replay.xml" in line:
            suite = xml.etree.ElementTree.parse(work / "replay.xml").getroot()
            assert suite.get("tests") == "2" and suite.get("failures") == str(failed), about
        if "--summary" in line:
            summary = work / ("step.md" if "GITHUB_STEP_SUMMARY" in line else "replay.md")
            rows = summary.read_text().splitlines()
            assert len(rows) == 4 and all(row.startswith("|") for row in rows), about
            assert sum("failed" in row for row in rows) == failed, about
        # Whatever the artifacts of a workflow name has been written.
        for path in re.findall(r"replay\.(?:xml|md)", line):
            assert (work / path).exists(), about


def main():
    for name in ("github.yml", "gitlab-ci.yml"):
        text = (examples / name).read_text()
        check_yaml(text, name)
        assert "SMASERVO_DEB_URL: https://example.org/" in text, name
        kept = set(re.findall(r"(?:path: |junit: |- )(replay\.\w+)$", text, re.MULTILINE))
        written = set(re.findall(r"replay\.(?:xml|md)", " ".join(commands(name))))
        assert kept == written, f"{name}: keeps {kept}, and the program writes {written}"
    broken = ["a:\n   b: 1", "a: b: c", "a:\n\tb: 1", "a: 'b", "a", "a: *b"]
    for text in broken:
        try:
            check_yaml(text, "broken")
        except AssertionError:
            continue
        raise AssertionError(f"is taken for YAML: {text!r}")
    shipped = (examples / "expect.toml").read_text()
    missed = shipped.replace("mean = 0.5\n", "mean = 0.0001\n")
    assert missed != shipped
    for name in ("github.yml", "gitlab-ci.yml", "README.md"):
        for line in commands(name):
            check(name, line, shipped, 0, 0)
            check(name, line, missed, 1, 1)
    instructions = re.findall(r"^([A-Z]+) ", (examples / "Containerfile").read_text(), re.MULTILINE)
    assert instructions == ["FROM", "COPY", "RUN"], instructions


main()
