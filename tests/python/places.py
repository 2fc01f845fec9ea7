"""Where the tests find things."""

import os
import subprocess
import sys
from pathlib import Path

SOURCE = Path(os.environ['SMASERVO_SOURCE'])
BUILD = Path(os.environ['SMASERVO_BUILD'])
HOST_SIM = os.environ['HOST_SIM']
TRACES = SOURCE / 'host-sim/traces'
UNIT_A = TRACES / 'units/a.toml'
# The runtime of a sanitizer, which the interpreter needs and host-sim has of its own.
PRELOADED = os.environ.pop('LD_PRELOAD', None)


def run_program(*command):
    """Runs a program in the project's folder."""
    environment = dict(os.environ)
    if PRELOADED and command[0] == sys.executable:
        environment['LD_PRELOAD'] = PRELOADED
    command = [str(part) for part in command]
    return subprocess.run(command, capture_output=True, text=True, cwd=SOURCE, env=environment)


def host_sim(*arguments, status=0):
    """Runs host-sim, and returns its two outputs."""
    run = run_program(HOST_SIM, *arguments)
    assert run.returncode == status, run.stderr
    return run.stdout, run.stderr


def bits(*numbers):
    """Numbers, or arrays, as something that is equal only to the same bits."""
    import numpy as np

    return tuple(np.asarray(number).tobytes() for number in numbers)


def bits_of(estimate):
    return bits(
        estimate.strain,
        estimate.strain_sd,
        estimate.temperature_K,
        estimate.martensite,
        estimate.r_phase,
        estimate.resistance_model_ohm,
    ) + (estimate.health,)
