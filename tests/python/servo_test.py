"""smaservo.Settings and smaservo.Servo"""

import copy
import math
import pickle
import re

import pytest
import smaservo
from places import SOURCE, bits

WIRE = smaservo.Wire.load('smartflex-76um')
FASTER = SOURCE / 'host-sim/scenarios/devices/smartflex-76um.toml'
DEVICE = SOURCE / 'host-sim/scenarios/devices/sublayers-1000.toml'


def row(out):
    return bits(out.drive_current_A, out.setpoint, out.reference, out.estimate.strain, out.time_s) + (
        out.state,
        out.mode,
        out.latched,
        out.warnings,
        out.blocks,
        out.limit_reasons,
        out.first_cause,
    )


def loop(servo, plant, steps, mode='strain', setpoint=0.03, load_N=0.5):
    """Runs a servo on a simulated wire."""
    rows, current_A = [], servo.last.drive_current_A
    for _ in range(steps):
        voltage_V = current_A * plant.output().resistance_ohm
        out = servo.update(current_A, voltage_V, load_N, mode=mode, setpoint=setpoint, dt_s=1e-3)
        current_A = out.drive_current_A
        plant.update(current_A, load_N, 1e-3)
        rows.append(row(out))
    return rows


def test_settings_keep_what_is_set():
    settings = smaservo.Settings.load(DEVICE)
    read = smaservo.Settings.parse(settings.to_toml())
    for other in (pickle.loads(pickle.dumps(settings)), settings.copy(), copy.copy(settings), read):
        assert other == settings and other.parameters() == settings.parameters()
    other = settings.copy()
    for path, value in settings.parameters().items():
        assert settings[path] == value
        other[path] = value
    assert other == settings
    other['limits.current_A'] = 0.5 * settings['limits.current_A']
    assert other != settings and settings['limits.current_A'] == 2 * other['limits.current_A']
    with pytest.raises(TypeError, match='unhashable'):
        hash(settings)


def test_ranges_are_those_of_the_device():
    settings = smaservo.Settings.for_wire(WIRE)
    before = settings.parameters()
    for path, bad in [
        ('limits.current_A', -1),
        ('limits.current_A', math.nan),
        ('limits.current_A', 'much'),
        ('limits.current_A', True),
        ('limits.current_A', 1e300),
        ('drive.kind', 'steam'),
        ('measurement.has_load_cell', 1),
        ('identity.node_id', 1000),
        ('identity.node_id', -1),
        ('identity.node_id', 2**40),
        ('identity.node_id', 1.5),
    ]:
        with pytest.raises(smaservo.ConfigError, match='^' + re.escape(f'{path} = {bad}: must be ')):
            settings[path] = bad
    assert settings.parameters() == before
    with pytest.raises(KeyError, match='did you mean limits.current_A'):
        settings['limits.curent_A'] = 1


def test_contradictions_are_found_before_the_device_runs():
    settings = smaservo.Settings.for_wire(WIRE)
    settings['trips.current_A'] = settings['limits.current_A'] / 2
    assert pickle.loads(pickle.dumps(settings)) == settings
    for use in (settings.check, lambda: smaservo.Servo(settings)):
        with pytest.raises(smaservo.ConfigError, match='limits.current_A must be below trips.current_A'):
            use()
    with pytest.raises(smaservo.ConfigError, match='limits.current_A must be below trips.current_A'):
        smaservo.Settings.for_wire(WIRE).replace({'limits.current_mA': 9000})


def test_holds_a_strain_and_copies_go_on_alike():
    settings = smaservo.Settings.load(FASTER)
    servo, plant = smaservo.Servo(settings), smaservo.Plant(settings.wire, load_N=0.5)
    loop(servo, plant, 2000)
    others = [servo.copy(), copy.copy(servo), copy.deepcopy(servo), pickle.loads(pickle.dumps(servo))]
    plants = [plant.copy() for _ in others]
    rows = loop(servo, plant, 2000)
    assert servo.last.state == 'running' and servo.last.latched == ()
    assert abs(plant.output().strain - 0.03) < 1e-3
    assert pickle.loads(pickle.dumps(servo.last)).drive_current_A == servo.last.drive_current_A
    for other, its_plant in zip(others, plants):
        assert loop(other, its_plant, 2000) == rows


def test_a_broken_wire_ends_heat_until_the_fault_is_cleared():
    settings = smaservo.Settings.load(FASTER)
    servo, plant = smaservo.Servo(settings), smaservo.Plant(settings.wire, load_N=0.5)
    loop(servo, plant, 2000)
    out = servo.last
    for i in range(500):
        voltage_V = 4.0 if out.drive_current_A > 0 else 0.0
        out = servo.update(1e-6 * (i % 2), voltage_V, 0.5, mode='strain', setpoint=0.03, dt_s=1e-3)
    assert out.state == 'fault' and out.drive_current_A == 0
    assert out.first_cause == 'wire_open' and 'wire_open' in out.latched
    for i in range(5):
        out = servo.update(1e-6 * (i % 2), 0.0, 0.5, mode='off', setpoint=0.0, dt_s=1e-3, clear_faults=True)
    assert out.latched == () and out.first_cause is None and out.drive_current_A == 0


def test_what_is_not_allowed_is_named_and_computes_nothing():
    servo = smaservo.Servo(smaservo.Settings.for_wire(WIRE))
    good = dict(current_A=0.0, voltage_V=0.0, load_N=0.5, mode='strain', setpoint=0.03, dt_s=1e-3)
    before = row(servo.update(**good))
    for name, bad in [
        ('mode', 'strian'),
        ('setpoint', math.nan),
        ('setpoint', math.inf),
        ('dt_s', 0.0),
        ('dt_s', -1.0),
        ('dt_s', math.nan),
        ('dt_s', math.inf),
    ]:
        with pytest.raises(ValueError, match=f"^{name} = '?{bad if isinstance(bad, str) else f'{bad:g}'}'?: must be "):
            servo.update(**{**good, name: bad})
    assert row(servo.last) == before
    # A reading that is NaN is a sensor that has failed; it is not refused.
    assert servo.update(**{**good, 'current_A': math.nan}).drive_current_A == 0
