#!/usr/bin/python3
"""Measures the Python package: PYTHONPATH=build/release/host-sim/python tests/bench/python_speed.py

Prints a Markdown table: the time of an import, rows a second of whole traces, and single steps; the best of five.
"""

import subprocess
import sys
import time


def best(work, times=5):
    """Seconds that the quickest of some runs takes."""
    least = float('inf')
    for _ in range(times):
        begin = time.perf_counter()
        work()
        least = min(least, time.perf_counter() - begin)
    return least


def started(code):
    return best(lambda: subprocess.run([sys.executable, '-c', code], check=True))


def main():
    bare = started('pass')
    print('| what | time |\n|---|--:|')
    print(f'| `import smaservo` | {1e3 * (started("import smaservo") - bare):.0f} ms |')
    print(f'| `import numpy`, for comparison | {1e3 * (started("import numpy") - bare):.0f} ms |')

    import numpy as np
    import smaservo

    rows = 1_000_000
    wire = smaservo.Wire.load('smartflex-76um')
    time_s = 1e-3 * np.arange(rows)
    current_A = 0.1 + 0.1 * np.sin(time_s)
    took = best(lambda: smaservo.simulate(wire, time_s, current_A, 0.68), 3)
    print(f'| `simulate`, a row | {1e9 * took / rows:.0f} ns, {1e-6 * rows / took:.1f} million rows/s |')
    run = smaservo.simulate(wire, time_s, current_A, 0.68)
    voltage_V = run.voltage_V
    took = best(lambda: smaservo.replay(wire, time_s, current_A, voltage_V, 0.68), 3)
    print(f'| `replay`, a row | {1e9 * took / rows:.0f} ns, {1e-6 * rows / took:.1f} million rows/s |')

    steps = range(20_000)
    plant, estimator = smaservo.Plant(wire), smaservo.Estimator(wire)
    servo = smaservo.Servo(smaservo.Settings.for_wire(wire))
    for name, step in [
        ('Plant.update', lambda: [plant.update(0.05, 0.5, 1e-3) for _ in steps]),
        ('Estimator.update', lambda: [estimator.update(0.05, 1.2, 0.5, 1e-3) for _ in steps]),
        ('Servo.update', lambda: [servo.update(0.0, 0.0, 0.5, 'off', 0.0, 1e-3) for _ in steps]),
    ]:
        print(f'| `{name}` | {1e9 * best(step) / len(steps):.0f} ns |')


if __name__ == '__main__':
    main()
