"""python -m smaservo inspect is host-sim inspect; smaservo.inspect() is its JSON."""

import json
import sys

import pytest
import smaservo
from places import HOST_SIM, TRACES, run_program


def both(*arguments):
    """What host-sim and the package do with the same arguments: status and both outputs."""
    runs = [
        run_program(*program, 'inspect', *arguments)
        for program in ([HOST_SIM], [sys.executable, '-m', 'smaservo'])
    ]
    return [(run.returncode, run.stdout, run.stderr) for run in runs]


@pytest.mark.parametrize(
    'arguments',
    [
        [TRACES / '150MPa.csv'],
        [TRACES / '150MPa.csv', '--wire', TRACES / 'units/a.toml'],
        [TRACES / '150MPa.csv', '--set', 'wire.length_mm=120'],
        [TRACES / '150MPa.csv', '--json'],
        [TRACES / '150MPa.csv', TRACES / 'bath.csv'],
        [TRACES / '150MPa.csv', TRACES / 'bath.csv', '--json'],
        [TRACES / 'bath.csv', '--period-s', '1'],
        [TRACES / 'none.csv'],
        [TRACES / '150MPa.csv', '--set', 'wire'],
        [TRACES / '150MPa.csv', '--wire', 'none'],
        [TRACES / '150MPa.csv', '--column', 'current=17:A'],
        [TRACES / '150MPa.csv', '--wire', 'flexinol-lt-0.15mm'],
    ],
    ids=str,
)
def test_the_same_text_and_status(arguments):
    host_sim, package = both(*arguments)
    assert package == host_sim


def test_a_wrong_command_line_ends_with_2():
    assert [status for status, _, _ in both()] == [2, 2]
    assert [status for status, _, _ in both('--nothing')] == [2, 2]


def test_facts_are_the_json():
    facts = smaservo.inspect(TRACES / '150MPa.csv')
    host_sim, _ = both(TRACES / '150MPa.csv', '--json')
    assert [facts] == json.loads(host_sim[1])
