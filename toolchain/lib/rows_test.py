#!/usr/bin/env python3
"""Two rows of random parts, whose steps write down when they begin and end, and at which priority they run. Fails
where another step was at normal priority while one in real time ran, or where a part whose log cannot be written is
not a failure. Run by ctest."""

import contextlib
import io
import os
from pathlib import Path
import random
import sys
import tempfile

import test
from parts import Part, Step

# Writes its lines in one call each, so that the file has them in the order in which things happened.
STEP = r"""
import os, sys, time
file = os.open(sys.argv[1], os.O_WRONLY | os.O_APPEND)
idle = 'ROWS_TEST_IDLE' in os.environ
os.write(file, f'begin {sys.argv[2]} {"idle" if idle else "normal"}\n'.encode())
time.sleep(float(sys.argv[3]))
os.write(file, f'end {sys.argv[2]}\n'.encode())
"""


def random_rows(draw, record):
    """Two rows of names of parts, and the names of their live steps."""
    live, rows = set(), []

    def step(name, is_live, beside=None):
        if is_live:
            live.add(name)
        return Step(name, [sys.executable, '-c', STEP, str(record), name, f'{draw.uniform(0, 0.05):.3f}'],
                    live=is_live, beside=beside)

    for row in range(2):
        names = [f'{row}-{k}' for k in range(draw.randint(1, 4))]
        for name in names:
            steps = []
            for k in range(draw.randint(1, 3)):
                beside = step(f'{name}-{k}-beside', False) if draw.random() < 0.4 else None
                steps.append(step(f'{name}-{k}', draw.random() < 0.4, beside))
            test.PARTS[name] = Part('', steps)
        rows.append(names)
    return rows, live


def disturbed(record, live):
    """What ran at normal priority beside a live step, or a live step that did not; and steps without an end."""
    running, found, steps = {}, [], 0
    for line in record.read_text().splitlines():
        what, name, *priority = line.split()
        if what == 'end':
            del running[name]
            continue
        steps += 1
        running[name] = priority[0]
        if name in live and priority[0] != 'normal':
            found.append(f'{name}: at idle priority')
        normal = [one for one, at in running.items() if at == 'normal']
        if len(normal) > 1 and live & set(normal):
            found.append(f'{" and ".join(normal)} at the same time')
    return found + [f'{name} has no end' for name in running], steps


def without_a_log():
    """A step whose log cannot be written, as on a full disk, alone, beside another, and in real time."""
    (test.LOGS / 'full.log').mkdir()
    good, live_good = Step('good', ['true']), Step('good-live', ['true'], live=True)
    failures = []
    for kind, step in (('alone', Step('full', ['true'])), ('in real time', Step('full', ['true'], live=True)),
                       ('beside', Step('good', ['true'], beside=Step('full', ['true'])))):
        test.PARTS.update(full=Part('', [step]), good=Part('', [good, live_good]))
        with contextlib.redirect_stdout(io.StringIO()) as said, contextlib.redirect_stderr(io.StringIO()):
            code = test.test([['full', 'good'], ['good']], True)
        lines = said.getvalue().splitlines()
        if code != 1 or sum(line.startswith('good ') and 'passed' in line for line in lines) != 2:
            failures.append(f'a log that cannot be written, {kind}: ended with {code}:\n{said.getvalue()}')
    return failures


def main(folder):
    test.KEPT = test.LOGS = Path(folder)
    # ctest may run this test at idle priority itself, and what begins at it stays there.
    test.idle = lambda: os.environ.update(ROWS_TEST_IDLE='1')
    failures, total, expected = [], 0, 0
    for seed in range(10):
        draw, record = random.Random(seed), test.LOGS / f'record-{seed}'
        record.touch()
        rows, live = random_rows(draw, record)
        with contextlib.redirect_stdout(io.StringIO()) as said:
            code = test.test(rows, True)
        found, steps = disturbed(record, live)
        total += steps
        expected += sum(1 + bool(step.beside) for row in rows for name in row for step in test.PARTS[name].steps)
        failures += [f'seed {seed}: {line}' for line in found]
        if code != 0:
            failures.append(f'seed {seed}: ended with {code}:\n{said.getvalue()}')
    failures += without_a_log()
    if total != expected:
        failures.append(f'{total} of {expected} steps ran')
    print('\n'.join(failures) or f'{total} steps, and none in real time was disturbed')
    return 1 if failures else 0


if __name__ == '__main__':
    with tempfile.TemporaryDirectory() as own:
        sys.exit(main(own))
