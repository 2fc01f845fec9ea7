"""A program of a user, for mypy --strict. It runs as well."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import smaservo


def estimate(trace: Path, wire: str) -> float:
    recording = smaservo.read(trace, columns=[], lenient=True)
    result = smaservo.replay(smaservo.Wire.load(wire, {'wire.length_mm': 100.6}), recording, load_N=0.5)
    worst: np.float64 = np.max(np.abs(result.strain))
    return float(worst)


def hold(settings: smaservo.Settings, setpoint: float) -> smaservo.ServoOutput:
    settings['limits.current_A'] = 0.1
    servo = smaservo.Servo(settings)
    plant = smaservo.Plant(settings.wire, load_N=0.5, ambient_K=295.0)
    out = servo.last
    for _ in range(10):
        ohm: float = plant.output().resistance_ohm
        out = servo.update(out.drive_current_A, ohm * out.drive_current_A, 0.5, 'strain', setpoint, 1e-3)
        plant.update(out.drive_current_A, 0.5, 1e-3)
    return out


def handle() -> str:
    try:
        smaservo.Wire.load('none')
    except smaservo.ConfigError as error:
        return str(error)
    return ''


if __name__ == '__main__':
    print(estimate(Path(sys.argv[1]), sys.argv[2]))
    print(hold(smaservo.Settings.for_wire(smaservo.Wire.load('smartflex-76um')), 0.03).state)
    run = smaservo.simulate('smartflex-76um', np.arange(3.0), current_A=0.1, load_N=[0.5, 0.5, 0.5])
    print(run.strain.shape, handle())
