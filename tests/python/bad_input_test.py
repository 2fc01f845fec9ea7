"""Arrays that cannot be used are refused by name, index and value, and nothing else happens."""

import math
import random

import numpy as np
import pytest
import smaservo
from places import TRACES, UNIT_A

WIRE = smaservo.Wire.load(UNIT_A)
RECORDING = smaservo.read(TRACES / '150MPa.csv')
# Of the beginning, in which the wire is cold, there would be a warning.
pytestmark = pytest.mark.filterwarnings('ignore::smaservo.DataWarning')
NAMES = ('time_s', 'current_A', 'voltage_V', 'load_N')
GOOD = {name: RECORDING[name][:200].copy() for name in NAMES}


def replay(**changes):
    return smaservo.replay(WIRE, **{**GOOD, **changes})


def replay_table(**changes):
    return smaservo.replay(WIRE, {**GOOD, **changes})


def simulate(**changes):
    given = {name: values for name, values in {**GOOD, **changes}.items() if name != 'voltage_V'}
    return smaservo.simulate(WIRE, **given)


CALLS = [replay, replay_table, simulate]


def names_of(call):
    return [name for name in NAMES if call is not simulate or name != 'voltage_V']


@pytest.mark.parametrize('call', CALLS)
def test_a_bad_number_anywhere(call):
    rng = random.Random(1)
    for _ in range(200):
        name, i = rng.choice(names_of(call)), rng.randrange(200)
        bad = rng.choice([math.nan, math.inf, -math.inf])
        values = GOOD[name].copy()
        values[i] = bad
        with pytest.raises(ValueError, match=rf"^{name}\[{i}\](: '| = ){bad}"):
            call(**{name: values})


@pytest.mark.parametrize('call', CALLS)
def test_times_that_do_not_rise(call):
    rng = random.Random(2)
    for _ in range(100):
        i = rng.randrange(1, 200)
        times = GOOD['time_s'].copy()
        times[i] = times[i - 1] - rng.choice([0, 1e-6, 1.0])
        with pytest.raises(ValueError, match=rf'^time_s\[{i}\] = .*: must be '):
            call(time_s=times)


@pytest.mark.parametrize('call', CALLS)
def test_shapes_and_types(call):
    for name in names_of(call):
        good = GOOD[name]
        for bad in (good[:-1], np.append(good, 1.0)):
            with pytest.raises(ValueError, match=r'has (199|200|201) values, \w+ has (199|200|201)$'):
                call(**{name: bad})
        with pytest.raises(ValueError, match=f'^{name}: is empty$'):
            call(**{name: good[:0]})
        with pytest.raises(ValueError, match=f'^{name}: must have one dimension, and has 2$'):
            call(**{name: good.reshape(2, -1)})
        for bad in (good.astype(complex), good.astype(str), good.astype(object), good.astype('M8[s]')):
            with pytest.raises(TypeError, match=f'^{name}: must be numbers, and is '):
                call(**{name: bad})


def test_out_of_range_says_the_range():
    for name, bad in [('current_A', 2000.0), ('voltage_V', -2e4), ('load_N', 2e5), ('time_s', 1e10)]:
        values = GOOD[name].copy()
        values[7] = bad
        for call in (replay, replay_table):
            with pytest.raises(ValueError, match=rf"^{name}\[7\]: '.*' is out of range"):
                call(**{name: values})


def test_what_is_missing_or_too_much():
    with pytest.raises(ValueError, match='^load_N: is missing'):
        smaservo.replay(WIRE, GOOD['time_s'], GOOD['current_A'], GOOD['voltage_V'])
    with pytest.raises(TypeError, match='^current_A and voltage_V: must be given'):
        smaservo.replay(WIRE, GOOD['time_s'], GOOD['current_A'])
    with pytest.raises(TypeError, match='^current_A and voltage_V: must not'):
        smaservo.replay(WIRE, GOOD, GOOD['current_A'])
    for name in ('time_s', 'current_A', 'voltage_V'):
        with pytest.raises(ValueError, match=f'^{name}: is missing'):
            smaservo.replay(WIRE, {other: GOOD[other] for other in NAMES if other != name})
    with pytest.raises(ValueError, match='^data: has no columns'):
        smaservo.replay(WIRE, {})
    with pytest.raises(smaservo.UserError, match='there is another column for current'):
        replay_table(current_mA=GOOD['current_A'])
    for name, bad in [('ambient_K', 25.0), ('stress_Pa', -1.0), ('ambient_K', math.nan)]:
        with pytest.raises(ValueError, match=f'^{name} = {bad}: must be'):
            replay(**{name: bad})
    with pytest.raises(smaservo.UserError, match='there are: kalman, open-loop, line'):
        replay(observer='kalmann')
    with pytest.raises(smaservo.UserError, match='there is no such check'):
        replay(allow=['everything'])
    with pytest.raises(smaservo.ConfigError, match='observer.none'):
        replay(settings={'observer.none': 1})


def test_a_unit_that_is_wrong_is_a_mistake_of_the_data():
    with pytest.raises(smaservo.UserError, match='--allow'):
        smaservo.replay(WIRE, {**RECORDING, 'current_A': 0.01 * RECORDING.current_A})


def test_a_gap_of_more_than_a_minute_is_no_step_of_a_plant():
    with pytest.raises(ValueError, match=r'^time_s\[2\] = 62: must be later than the 1.* by at most 60 s'):
        smaservo.simulate(WIRE, [0.0, 1.0, 62.0], 0.1, 0.5)


def test_inputs_are_not_changed():
    before = {name: values.tobytes() for name, values in GOOD.items()}
    for call in CALLS:
        call()
    assert {name: values.tobytes() for name, values in GOOD.items()} == before
