"""The training of compare's recurrent network, host-sim/papers/gru/train.py"""

import json
import os
import sys

import numpy as np
import pytest
import smaservo
from places import SOURCE, TRACES, run_program

FOLDER = SOURCE / 'host-sim/papers/gru'
sys.path.insert(0, str(FOLDER))
import train  # noqa: E402  (from that folder)

GOLDEN = SOURCE / 'tests/golden/gru_strains.csv'
REWRITE = 'SMASERVO_REWRITE_GOLDEN=1 ctest --test-dir build/release -R Python.Gru'


def wire():
    return smaservo.Wire.load('smartflex-76um', {'wire.length_mm': 100.6})


def shipped_course(name):
    return train.course(f'{name}.csv', smaservo.read(TRACES / f'{name}.csv'), wire())


def shipped_network():
    file = json.loads((FOLDER / 'traces.json').read_text())
    assert file['version'] == train.VERSION and file['step_s'] == train.STEP_S
    return train.Network(
        {name: np.array(file['weights'][name], dtype=float) for name in train.shapes(file['hidden'])},
        np.array([one['mean'] for one in file['inputs']]), np.array([one['scale'] for one in file['inputs']]),
        file['output']['mean'], file['output']['scale'])


def test_gradients_are_those_of_finite_differences():
    random = np.random.default_rng(3)
    parameters = train.beginning(4, random)
    given = (random.normal(size=(7, 3, 3)), random.normal(size=(7, 3)), random.uniform(size=(7, 3)),
             0.5 * random.normal(size=(3, 4)))
    _, gradient = train.loss_and_gradient(parameters, *given)
    assert list(parameters) == list(train.shapes(4))
    step = 1e-6
    for name, values in parameters.items():
        assert gradient[name].shape == values.shape == train.shapes(4)[name]
        for at in np.ndindex(values.shape):
            losses = []
            for change in (step, -step):
                moved = {other: array.copy() for other, array in parameters.items()}
                moved[name][at] += change
                losses.append(train.loss_and_gradient(moved, *given)[0])
            assert abs((losses[0] - losses[1]) / (2 * step) - gradient[name][at]) < 1e-7, (name, at)


def test_a_pass_gives_the_states_that_windows_begin_with():
    random = np.random.default_rng(4)
    parameters = train.beginning(5, random)
    inputs = random.normal(size=(20, 2, 3))
    states = train.states_of(parameters, inputs)
    wanted, weights = np.zeros((20, 2)), np.ones((20, 2))
    whole, _ = train.loss_and_gradient(parameters, inputs, wanted, weights, states[0])
    parts = [train.loss_and_gradient(parameters, inputs[a:b], wanted[a:b], weights[a:b], states[a])[0]
             for a, b in ((0, 7), (7, 20))]
    assert abs(whole - sum(parts)) < 1e-12 * whole


def test_energy_is_kept_and_readings_are_held():
    time_s = np.array([0.0, 0.004, 0.013, 0.020, 0.050])
    ohm = np.array([np.nan, 20.0, np.nan, 0.0, 21.0])
    power_W = np.array([1.0, 3.0, 2.0, 0.0, 4.0])
    at_s, inputs = train.inputs_at_steps(time_s, ohm, power_W, np.full(5, 150e6))
    assert at_s.tolist() == pytest.approx([0, 0.01, 0.02, 0.03, 0.04, 0.05])
    assert inputs[1:, 1].sum() * 0.01 == pytest.approx(0.5 * np.sum((power_W[1:] + power_W[:-1]) * np.diff(time_s)))
    assert inputs[:3, 0].tolist() == [1, 1, 1] and inputs[-1, 0] == pytest.approx(21 / 20)
    assert inputs[:, 2].tolist() == pytest.approx([150] * 6)


def test_the_same_seed_gives_the_same_file(tmp_path):
    for name in ('10MPa', '400MPa'):
        lines = (TRACES / f'{name}.csv').read_text().splitlines(keepends=True)
        (tmp_path / f'{name}.csv').write_text(''.join(lines[:1500]))

    def trained(out, *more):
        done = run_program(sys.executable, FOLDER / 'train.py', tmp_path / '10MPa.csv', tmp_path / '400MPa.csv',
                           '--set', 'wire.length_mm=100.6', '--hidden', '3', '--epochs', '3',
                           '--out', tmp_path / out, *more)
        assert done.returncode == 0, done.stderr
        return (tmp_path / out).read_text()

    text = trained('a.json')
    assert trained('b.json') == text and trained('c.json', '--seed', '2') != text
    assert sorted(file.name for file in tmp_path.glob('*.json')) == ['a.json', 'b.json', 'c.json']
    file = json.loads(text)
    assert file['hidden'] == 3 and [run['rows'] for run in file['runs']] == [1499, 1499]


def test_a_run_of_a_second_is_enough(tmp_path):
    lines = (TRACES / '150MPa.csv').read_text().splitlines(keepends=True)
    short, out = tmp_path / 'short.csv', tmp_path / 'short.json'
    short.write_text(''.join(lines[:102]))
    words = [FOLDER / 'train.py', short, '--hidden', '2', '--epochs', '5', '--out']
    done = run_program(sys.executable, *words, out)
    assert done.returncode == 0 and out.exists(), done.stderr
    before = short.read_text()
    done = run_program(sys.executable, *words, short)
    assert done.returncode == 1 and 'is one of the runs' in done.stderr and short.read_text() == before
    os.mkfifo(tmp_path / 'pipe')
    done = run_program(sys.executable, *words, tmp_path / 'pipe')
    assert done.returncode == 1 and 'is a folder or a device' in done.stderr and (tmp_path / 'pipe').is_fifo()


def test_a_displacement_is_placed_by_its_air_and_by_rows_that_have_one():
    strains, stress_Pa = np.array([np.nan, 0.0, -0.01, -0.03]), np.full(4, 150e6)
    rest = [smaservo.Plant(wire(), 150e6 * wire().area_m2, air_K).output().strain for air_K in (293.15, 343.15)]
    for strain, air_K in zip(rest, (293.15, 343.15)):
        placed = train.at_rest(strains, stress_Pa, wire(), air_K)
        assert np.isnan(placed[0]) and placed[1:].tolist() == pytest.approx([strain, strain - 0.01, strain - 0.03])
    assert rest[0] > rest[1] + 0.001


@pytest.mark.parametrize('words, said', [
    (['none.csv', '--out', 'x.json'], 'none.csv'),
    ([TRACES / 'bath.csv', '--out', 'x.json'], 'bath.csv: has no time_s and no current_A and no voltage_V'),
    ([TRACES / '10MPa.csv'] * 2 + ['--out', 'x.json'], 'a run is given twice'),
    ([TRACES / '10MPa.csv', '--leave-one-out'], 'needs at least two runs'),
    ([TRACES / '10MPa.csv', '--set', 'wire.length_mm', '--out', 'x.json'], 'must be KEY=VALUE'),
    ([TRACES / '10MPa.csv', '--set', 'wire.colour=3', '--out', 'x.json'], 'wire.colour'),
    ([TRACES / '10MPa.csv', '--epochs', '1', '--out', 'none/x.json'], 'none/x.json: cannot be written'),
    ([TRACES / '10MPa.csv', '--out', '.'], '--out .: is a folder or a device'),
])
def test_what_cannot_be_used_is_named(words, said):
    done = run_program(sys.executable, FOLDER / 'train.py', *words)
    assert done.returncode == 1 and done.stderr.startswith('train.py: ') and said in done.stderr, done.stderr
    assert not (SOURCE / 'x.json').exists()


def test_strains_of_the_shipped_network():
    """The numbers that the C++ of compare has to give, too. They change with the network."""
    network = shipped_network()
    lines = ['load_MPa,row,strain\n']
    for name, load_MPa, every in (('spring', 0, 97), ('150MPa', 150, 333)):
        recording = smaservo.read(TRACES / f'{name}.csv')
        course = shipped_course(name)
        steps_s = recording.time_s[0] + train.STEP_S * np.arange(len(course.inputs))
        strain = np.interp(recording.time_s, steps_s, train.strain_percent(network, course.inputs) / 100 * 0.04)
        lines += [f'{load_MPa},{row},{strain[row]:.12f}\n' for row in range(0, len(strain), every)]
    if 'SMASERVO_REWRITE_GOLDEN' in os.environ:
        GOLDEN.write_text(''.join(lines))
        pytest.skip(f'{GOLDEN} is written anew')
    golden, now = (np.array([line.split(',') for line in text[1:]], dtype=float)
                   for text in (GOLDEN.read_text().splitlines(), lines))
    message = f'if the network was trained anew, run\n  {REWRITE}\nand commit the difference of {GOLDEN}'
    assert golden.shape == now.shape and np.abs(golden - now).max() < 1e-9, message


def test_the_shipped_network_is_of_these_runs():
    file = json.loads((FOLDER / 'traces.json').read_text())
    courses = [shipped_course(name) for name in ('10MPa', '50MPa', '150MPa', '400MPa')]
    assert file['runs'] == [{'name': one.name, 'rows': one.rows, 'checksum': one.checksum} for one in courses]
    errors = [train.mean_error(shipped_network(), one) for one in courses]
    assert 0.1 < min(errors) and max(errors) < 2, errors
