"""The types of the package: a user's program by mypy --strict, and the stub against the module."""

import os
import subprocess
import sys
from pathlib import Path

import smaservo
from places import BUILD, SOURCE, TRACES, UNIT_A

HERE = Path(__file__).parent
PACKAGE = Path(smaservo.__file__).parent


def mypy(folder, *arguments):
    # The package is found by MYPYPATH, since mypy does not look in PYTHONPATH.
    environment = {**os.environ, 'MYPYPATH': str(PACKAGE.parent), 'MYPY_CACHE_DIR': str(BUILD / 'mypy')}
    command = [sys.executable, '-m', *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment)


def test_a_users_program_runs_and_has_no_wrong_type(tmp_path):
    done = mypy(tmp_path, 'mypy', '--strict', str(HERE / 'user.py'))
    assert done.returncode == 0, done.stdout + done.stderr
    command = [sys.executable, HERE / 'user.py', TRACES / '150MPa.csv', UNIT_A]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


WRONG = [
    'smaservo.Wire.load("smartflex-76um").length_mm',
    'smaservo.Plant("smartflex-76um")',
    'smaservo.Servo(smaservo.Settings.parse("")).update(0.0, 0.0, 0.0, "strian", 0.0, 1e-3)',
    'smaservo.replay("smartflex-76um", [0.0], [0.1], [0.1], observers="kalman")',
    'smaservo.read("x").notes = 3',
    'smaservo.Estimator(smaservo.Wire.load("x")).update(0.0, 0.0, 0.0)',
    'smaservo.Settings.load(3)',
    'smaservo.identify(["a.csv"], progress=lambda stage: True)',
]


def test_wrong_types_are_found(tmp_path):
    program = tmp_path / 'program.py'
    program.write_text('import smaservo\n' + '\n'.join(WRONG) + '\n')
    done = mypy(tmp_path, 'mypy', '--strict', str(program))
    for i, mistake in enumerate(WRONG, 2):
        assert f'program.py:{i}: error' in done.stdout, mistake + done.stdout + done.stderr


def test_the_package_itself(tmp_path):
    done = mypy(tmp_path, 'mypy', '--strict', '-p', 'smaservo')
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_training_of_a_network(tmp_path):
    done = mypy(tmp_path, 'mypy', '--strict', str(SOURCE / 'host-sim/papers/gru/train.py'))
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_stub_is_the_module(tmp_path):
    # Names of the stub alone, for types; the metaclass of pybind11; classes that no program constructs.
    names = ['Setting', 'Overrides', 'Path', 'Health', 'Mode', 'State', 'Floats']
    names += ['Wire', 'Plant', 'PlantState', 'Estimator', 'Estimate', 'Settings', 'Servo', 'ServoOutput']
    names += [f'{name}.__init__' for name in ('Wire', 'PlantState', 'Estimate', 'Settings', 'ServoOutput')]
    allowed = tmp_path / 'allowed'
    allowed.write_text('\n'.join(f'smaservo._core.{name}' for name in names))
    done = mypy(tmp_path, 'mypy.stubtest', 'smaservo._core', '--ignore-unused-allowlist', '--allowlist', str(allowed))
    assert done.returncode == 0, done.stdout + done.stderr
