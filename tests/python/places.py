"""Where the tests find things."""

import os
import subprocess
from pathlib import Path

SOURCE = Path(os.environ['SMASERVO_SOURCE'])
BUILD = Path(os.environ['SMASERVO_BUILD'])
HOST_SIM = os.environ['HOST_SIM']
TRACES = SOURCE / 'host-sim/traces'
UNIT_A = TRACES / 'units/a.toml'


def host_sim(*arguments, status=0):
    """Runs host-sim, and returns its two outputs."""
    run = subprocess.run([HOST_SIM, *map(str, arguments)], capture_output=True, text=True, cwd=SOURCE)
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
