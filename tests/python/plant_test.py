"""smaservo.Plant and simulate()"""

import copy
import math
import pickle
import random

import numpy as np
import pytest
import smaservo
from places import bits

WIRE = smaservo.Wire.load('smartflex-76um')


def numbers(state):
    return bits(state.strain, state.resistance_ohm, state.temperature_K, state.martensite, state.r_phase)


def random_step(rng):
    return dict(current_A=rng.uniform(0, 0.3), load_N=rng.uniform(0.2, 1.0), dt_s=rng.uniform(1e-4, 0.02))


def test_copies_and_pickles_go_on_alike_and_by_themselves():
    rng = random.Random(1)
    plant = smaservo.Plant(WIRE, load_N=0.5)
    for _ in range(500):
        plant.update(**random_step(rng))
    saved = numbers(plant.output())
    others = [plant.copy(), copy.copy(plant), copy.deepcopy(plant), pickle.loads(pickle.dumps(plant))]
    steps = [random_step(rng) for _ in range(300)]
    ends = [numbers(plant.update(**step)) for step in steps]
    for other in others:
        assert numbers(other.output()) == saved
        assert [numbers(other.update(**step)) for step in steps] == ends
    state = plant.output()
    assert numbers(pickle.loads(pickle.dumps(state))) == numbers(state)


def test_after_does_not_change_the_wire():
    plant = smaservo.Plant(WIRE, load_N=0.5)
    now = numbers(plant.output())
    step = dict(current_A=0.25, load_N=0.6, dt_s=0.1)
    coming = numbers(plant.after(**step))
    assert numbers(plant.output()) == now != coming
    assert numbers(plant.update(**step)) == coming
    plant.rest(0.5)
    assert numbers(plant.output()) == now


@pytest.mark.parametrize('bad', [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize('name', ['current_A', 'load_N', 'dt_s', 'ambient_K', 'draught'])
def test_what_is_no_number_is_named_and_changes_nothing(name, bad):
    plant = smaservo.Plant(WIRE, load_N=0.5)
    before = numbers(plant.output())
    for call in (plant.update, plant.after):
        with pytest.raises(ValueError, match=f'^{name} = {bad}: must be '):
            call(**{'current_A': 0.1, 'load_N': 0.5, 'dt_s': 1e-3, name: bad})
    assert numbers(plant.output()) == before


def test_ranges():
    plant = smaservo.Plant(WIRE)
    for name, bad in [('dt_s', 0.0), ('dt_s', -1e-3), ('dt_s', 60.1), ('ambient_K', 0.0), ('draught', 0.0)]:
        with pytest.raises(ValueError, match=f'^{name} = {bad:g}'):
            plant.update(**{'current_A': 0.1, 'load_N': 0.5, 'dt_s': 1e-3, name: bad})
    with pytest.raises(ValueError, match='stays as it was'):
        plant.update(current_A=1e300, load_N=0.5, dt_s=1e-3)
    for arguments in ({'load_N': math.nan}, {'ambient_K': -3.0}):
        with pytest.raises(ValueError, match=next(iter(arguments))):
            smaservo.Plant(WIRE, **arguments)


def test_simulate_is_a_plant_to_the_bit():
    rng = np.random.default_rng(1)
    rows = 2000
    time_s = np.cumsum(rng.uniform(1e-4, 2e-2, rows))
    current_A, load_N = rng.uniform(0, 0.3, rows), rng.uniform(0.2, 1, rows)
    ambient_K, draught = rng.uniform(290, 300, rows), rng.uniform(0.5, 2, rows)
    run = smaservo.simulate(WIRE, time_s, current_A, load_N, ambient_K=ambient_K, draught=draught)
    plant = smaservo.Plant(WIRE, load_N[0], ambient_K[0])
    for i in range(rows):
        if i > 0:
            k = i - 1
            plant.update(current_A[k], load_N[k], time_s[i] - time_s[k], ambient_K[k], draught[k])
        now = plant.output()
        row = (run.strain[i], run.resistance_ohm[i], run.temperature_K[i], run.martensite[i], run.r_phase[i])
        assert bits(*row) == numbers(now)
        assert run.voltage_V[i] == current_A[i] * now.resistance_ohm


def test_a_pickled_state_of_another_version_is_refused():
    version, size, content = smaservo.Plant(WIRE).__getstate__()
    others = [('0.0.0', size, content), (version, size + 1, content)]
    others += [(version, size, content[1:]), (version, size, 'x')]
    for other in others:
        with pytest.raises(ValueError, match='another version'):
            smaservo.Plant.__new__(smaservo.Plant).__setstate__(other)
