"""identify() and evaluate()"""

import os
import signal
import threading
import warnings

import pytest
import smaservo
from places import SOURCE, TRACES, UNIT_A, host_sim

BATH = TRACES / 'bath.csv'


def test_is_host_sim_identify(tmp_path):
    out = tmp_path / 'fitted.toml'
    given = ('--from', 'smartflex-76um', '--set', 'wire.length_mm=100.6')
    host_sim('identify', *given, '--out', out, '--threads', '2', BATH)
    wanted = smaservo.Wire.load(out)
    start = smaservo.Wire.load('smartflex-76um', {'wire.length_mm': 100.6})
    seen = []
    got = smaservo.identify([BATH], start, threads=2, progress=lambda *at: seen.append(at))
    assert got.wire == wanted and got.wire.name == 'fitted' and got.converged and not got.interrupted
    by_table = smaservo.identify([smaservo.read(BATH)], start, threads=2)
    assert by_table.wire == wanted
    assert by_table.runs[0]['name'] == 'runs[0]' and got.runs[0]['kind'] == 'bath'
    assert 0 < got.strain_rms < 0.1 and 0 < got.runs[0]['strain']['rms'] < 0.1
    moved = {p['key'] for p in got.parameters if p['determined']}
    assert moved and all(p['sd'] > 0 for p in got.parameters)
    assert len(seen) > 3 and all(0 <= share <= 1 for _, share, _ in seen)


def test_progress_may_end_it_or_raise():
    class Enough(Exception):
        pass

    def stop(stage, share, cost):
        raise Enough

    with pytest.raises(Enough):
        smaservo.identify([BATH], UNIT_A, threads=1, progress=stop)
    got = smaservo.identify([BATH], UNIT_A, threads=1, progress=lambda *at: False)
    assert got.interrupted


def test_ctrl_c_ends_it():
    def interrupt(stage, share, cost):
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        smaservo.identify([BATH], UNIT_A, threads=2, progress=interrupt)


def test_runs_that_cannot_be_used(tmp_path):
    file = tmp_path / 'run.csv'
    file.write_text('time_s,current_A\n' + ''.join(f'{i},0.2\n' for i in range(30)))
    _, text = host_sim('identify', '--out', tmp_path / 'x.toml', file, status=1)
    with pytest.raises(smaservo.UserError) as error:
        smaservo.identify([file])
    assert str(error.value) == text.strip().removeprefix('host-sim: ')
    for runs, kind in [([], ValueError), ('run.csv', TypeError), ({}, TypeError), ([3], TypeError)]:
        with pytest.raises(kind, match='^runs'):
            smaservo.identify(runs)
    with pytest.raises(ValueError, match=r'^time_s\[1\] = '):
        smaservo.identify([{'time_s': [1.0, 1.0], 'current_A': [1.0, 1.0], 'voltage_V': [1.0, 1.0]}])
    with pytest.raises(ValueError, match='^load_N = -1'):
        smaservo.identify([file], load_N=-1)


def test_evaluates_calibrated_wires():
    # The two wires that the project keeps for a small version of the table.
    kept = SOURCE / 'tests/golden/evaluate'
    seen = []
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        table = smaservo.evaluate(
            units=1,
            runs=2,
            rows=['standard'],
            observers=['kalman', 'line'],
            wires=kept,
            threads=2,
            progress=lambda *at: seen.append(at),
        )
    judged = [(row['observer'], row['row'], row['runs']) for row in table]
    assert judged == [('kalman', 'standard', 2), ('line', 'standard', 2)]
    assert table[0]['mean_percent'] < table[1]['mean_percent'] and 'missed' in table[0]
    # A run of each family, and the row's mean between both.
    own = table[0]['families']
    assert sorted(own) == ['ihyp', 'sublayers'] and all(each['runs'] == 1 for each in own.values())
    assert min(each['mean_percent'] for each in own.values()) <= table[0]['mean_percent']
    assert max(each['mean_percent'] for each in own.values()) >= table[0]['mean_percent']
    assert own['ihyp']['mean_percent'] != own['sublayers']['mean_percent']
    assert seen and all(done <= total for _, done, total in seen)


def test_evaluate_is_ended_by_what_progress_raises():
    class Enough(Exception):
        pass

    def stop(stage, done, total):
        if done > 0:
            raise Enough

    for threads in (1, 3):
        with pytest.raises(Enough):
            kept = SOURCE / 'tests/golden/evaluate'
            smaservo.evaluate(units=1, runs=6, rows=['standard'], wires=kept, threads=threads, progress=stop)
    assert threading.active_count() == 1


@pytest.mark.parametrize('name, bad', [('rows', ['none']), ('observers', ['kalmann']), ('units', 0), ('runs', -1)])
def test_evaluate_names_what_is_wrong(name, bad):
    with pytest.raises(ValueError, match=f'^{name}'):
        smaservo.evaluate(**{name: bad})
