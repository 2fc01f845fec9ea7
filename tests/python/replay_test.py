"""replay() is `host-sim replay`, and the Estimator, to the bit."""

import csv
import warnings

import numpy as np
import pandas
import pytest
import smaservo
from places import TRACES, UNIT_A, bits, host_sim

WIRE = smaservo.Wire.load(UNIT_A)
LOST = {('disturbed', 'open-loop'), ('unknown-start', 'open-loop')}


def fixed(value, decimals):
    """A number as host-sim writes it: rounded to nearest, the half upwards."""
    scaled = abs(value) * 10.0**decimals
    digits = int(scaled)
    digits += scaled - digits >= 0.5
    sign = '-' if value < 0 and digits else ''
    text = str(digits).rjust(decimals + 1, '0')
    return f'{sign}{text[:-decimals]}.{text[-decimals:]}'


def rows_of(estimate):
    """The estimate as the lines of host-sim's file."""
    e = estimate
    rows = zip(
        e.time_s.tolist(),
        e.strain.tolist(),
        e.strain_sd.tolist(),
        e.temperature_K.tolist(),
        e.martensite.tolist(),
        e.r_phase.tolist(),
        e.resistance_ohm.tolist(),
        e.resistance_model_ohm.tolist(),
        e.valid.tolist(),
    )
    for time_s, strain, sd, kelvin, martensite, r_phase, ohm, model_ohm, valid in rows:
        yield {
            'time_s': fixed(time_s, 6),
            'strain': fixed(strain, 7),
            'strain_sd': fixed(sd, 7) if sd == sd else '',
            'wire_temperature_degC': fixed(kelvin - 273.15, 3),
            'martensite': fixed(martensite, 5),
            'r_phase': fixed(r_phase, 5),
            'austenite': fixed(1 - martensite - r_phase, 5),
            'resistance_ohm': fixed(ohm, 6) if ohm == ohm else '',
            'resistance_model_ohm': fixed(model_ohm, 6) if model_ohm == model_ohm else '',
            'valid': '1' if valid else '0',
        }


@pytest.mark.parametrize('name', ['150MPa', 'disturbed', 'unknown-start', 'varying', 'spring'])
@pytest.mark.parametrize('observer', ['kalman', 'open-loop', 'line'])
def test_every_digit_of_host_sim(tmp_path, name, observer):
    out = tmp_path / 'estimate.csv'
    # 3: the observer was lost, and the file has been written all the same.
    lost = 3 if (name, observer) in LOST else 0
    host_sim(
        *('replay', '--wire', UNIT_A, '--observer', observer, '--out', out, '--allow', 'alloy'),
        TRACES / f'{name}.csv',
        status=lost,
    )
    with open(out, newline='') as file:
        expected = list(csv.DictReader(file))
    with warnings.catch_warnings():
        warnings.simplefilter('ignore', smaservo.DataWarning)
        estimate = smaservo.replay(WIRE, smaservo.read(TRACES / f'{name}.csv'), observer=observer, allow=['alloy'])
    assert len(expected) == len(estimate.strain) > 1000
    for got, wanted in zip(rows_of(estimate), expected):
        assert got.items() <= wanted.items()


def test_settings_ambient_and_load_as_host_sim(tmp_path):
    recording = smaservo.read(TRACES / '150MPa.csv')
    trace, out = tmp_path / 'trace.csv', tmp_path / 'estimate.csv'
    with open(trace, 'w') as file:
        file.write('time_ms,current_mA,voltage_V\n')
        for time_s, current_A, voltage_V in zip(recording.time_s, recording.current_A, recording.voltage_V):
            file.write(f'{1e3 * time_s:.3f},{1e3 * current_A:.3f},{voltage_V:.5f}\n')
    host_sim(
        *('replay', '--wire', UNIT_A, '--observer', 'kalman', '--load-N', '0.68', '--ambient-degC', '22', '--out', out),
        *('--set', 'observer.strain_model_sd=0.01', '--set', 'measurement.min_current_mA=20', trace),
    )
    with open(out, newline='') as file:
        expected = list(csv.DictReader(file))
    settings = {'observer.strain_model_sd': 0.01, 'measurement.min_current_mA': 20}
    estimate = smaservo.replay(WIRE, smaservo.read(trace), load_N=0.68, ambient_K=295.15, settings=settings)
    assert not estimate.valid.all()
    for got, wanted in zip(rows_of(estimate), expected, strict=True):
        assert got.items() <= wanted.items()


def test_is_an_estimator_and_starts_again_after_a_minute():
    recording = smaservo.read(TRACES / '150MPa.csv')
    time_s = recording.time_s.copy()
    time_s[3000:] += 70
    time_s[4000:] += 50
    estimate = smaservo.replay(WIRE, time_s, recording.current_A, recording.voltage_V, recording.load_N)
    assert estimate.restarts == 1
    estimator = smaservo.Estimator(WIRE)
    ns = np.rint(time_s * 1e9).astype(np.int64)
    for i in range(len(time_s)):
        dt_s = float(ns[i] - ns[i - 1]) * 1e-9 if i else 0.0
        now = estimator.update(recording.current_A[i], recording.voltage_V[i], recording.load_N[i], dt_s)
        row = (estimate.strain[i], estimate.strain_sd[i], estimate.temperature_K[i], estimate.resistance_model_ohm[i])
        assert bits(*row) == bits(now.strain, now.strain_sd, now.temperature_K, now.resistance_model_ohm), i
        assert smaservo.HEALTH[estimate.health[i]] == now.health


def test_tables_of_any_kind_are_the_same_data():
    recording = smaservo.read(TRACES / '150MPa.csv')
    wanted = smaservo.replay(WIRE, recording)
    frame = recording.to_dataframe()
    assert isinstance(frame, pandas.DataFrame)
    frame['note'] = 'text'
    frame['when, exactly'] = pandas.Timestamp('2026-01-01')
    tables = [
        frame,
        dict(recording),
        {name: recording[name].tolist() for name in ('time_s', 'current_A', 'voltage_V', 'load_N')},
        frame.rename(columns={'current_A': 'I [A]', 'voltage_V': 'U [V]'}),
        frame.sample(frac=1, random_state=1).sort_values('time_s'),
    ]
    for table in tables:
        got = smaservo.replay(WIRE, table)
        for name, column in wanted.items():
            assert got[name].tobytes() == column.tobytes(), name
    renamed = frame.rename(columns={'current_A': 'I'})
    got = smaservo.replay(WIRE, renamed, columns=['current=I:A'])
    assert got.strain.tobytes() == wanted.strain.tobytes()
    got = smaservo.replay(WIRE, frame.drop(columns='load_N').assign(stress_Pa=recording.load_N / WIRE.area_m2))
    assert np.allclose(got.strain, wanted.strain, atol=1e-9)


def test_the_form_of_arrays_does_not_count():
    recording = smaservo.read(TRACES / '150MPa.csv')
    wanted = smaservo.replay(WIRE, recording).strain.tobytes()
    columns = [recording[name] for name in ('time_s', 'current_A', 'voltage_V', 'load_N')]
    wide = np.column_stack(columns)
    for column in columns:
        column.flags.writeable = False
    lists = [column.tolist() for column in columns]
    swapped = [column.astype('>f8') for column in columns]
    for arrays in (columns, [wide[:, i] for i in range(4)], lists, swapped):
        assert smaservo.replay(WIRE, *arrays).strain.tobytes() == wanted
    assert len(smaservo.replay(WIRE, *(column[:1] for column in columns)).strain) == 1
    assert smaservo.replay(WIRE, *columns[:3], load_N=0.68).strain.shape == columns[0].shape


def test_a_result_is_columns():
    estimate = smaservo.replay(WIRE, smaservo.read(TRACES / '150MPa.csv'))
    assert estimate.strain is estimate['strain'] and 'rows of time_s' in repr(estimate)
    frame = estimate.to_dataframe()
    assert list(frame.columns) == list(estimate) and frame['strain'].to_numpy().tobytes() == estimate.strain.tobytes()
    with pytest.raises(AttributeError, match='there is no column strian; there are: time_s'):
        estimate.strian
    import copy
    import pickle

    for other in (pickle.loads(pickle.dumps(estimate)), copy.deepcopy(estimate)):
        assert type(other) is smaservo.Estimates and other.restarts == estimate.restarts
        assert other.strain.tobytes() == estimate.strain.tobytes()
