"""smaservo.Estimator: copies, pickles, threads, failed readings."""

import copy
import math
import pickle
import threading

import pytest
import smaservo
from places import TRACES, UNIT_A, bits_of

WIRE = smaservo.Wire.load(UNIT_A)
RECORDING = smaservo.read(TRACES / '150MPa.csv')
READINGS = list(zip(RECORDING.current_A[:4000].tolist(), RECORDING.voltage_V.tolist(), RECORDING.load_N.tolist()))


def run(estimator, readings):
    return [bits_of(estimator.update(*reading, 1e-3)) for reading in readings]


def test_copies_and_pickles_go_on_alike_and_by_themselves():
    estimator = smaservo.Estimator(WIRE)
    run(estimator, READINGS[:2000])
    others = [estimator.copy(), copy.copy(estimator), copy.deepcopy(estimator), pickle.loads(pickle.dumps(estimator))]
    rest = run(estimator, READINGS[2000:])
    for other in others:
        assert run(other, READINGS[2000:]) == rest


def test_two_threads_give_what_one_after_the_other_gives():
    pressures = ['100MPa.csv', '200MPa.csv']
    recordings = [smaservo.read(TRACES / name) for name in pressures]
    alone = [smaservo.replay(WIRE, recording).strain.tobytes() for recording in recordings]
    steps = [run(smaservo.Estimator(WIRE), READINGS), run(smaservo.Estimator(WIRE), READINGS[1000:])]
    together, by_steps = [None, None], [None, None]

    def work(i):
        together[i] = smaservo.replay(WIRE, recordings[i]).strain.tobytes()
        by_steps[i] = run(smaservo.Estimator(WIRE), READINGS[1000 * i :])

    threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert together == alone and by_steps == steps


def test_a_failed_reading_is_not_used():
    estimator = smaservo.Estimator(WIRE)
    assert not estimator.started
    unknown = estimator.update(0.1, 2.0, math.nan, 1e-3)
    assert math.isnan(unknown.strain) and unknown.health == 'doubtful' and not estimator.started
    run(estimator, READINGS[:100])
    assert estimator.started
    for reading in ((math.nan, 2.0, 0.7), (0.1, math.nan, 0.7), (0.1, 2.0, math.nan)):
        assert math.isfinite(estimator.update(*reading, 1e-3).strain)


def test_time_must_go_on():
    estimator = smaservo.Estimator(WIRE)
    estimator.update(*READINGS[0], 0.0)
    for dt_s in (0.0, -1.0, math.nan):
        with pytest.raises(ValueError, match=f'^dt_s = {dt_s:g}: must be greater than 0$'):
            estimator.update(*READINGS[1], dt_s)
    other = smaservo.Estimator(WIRE)
    other.update(*READINGS[0], 1.0)
    assert run(estimator, READINGS[1:200]) == run(other, READINGS[1:200])
    estimator.restart()
    assert not estimator.started


def test_settings_are_those_of_replay():
    plain = run(smaservo.Estimator(WIRE), READINGS[:300])
    assert run(smaservo.Estimator(WIRE, settings={'measurement.lead_resistance_ohm': 1.0}), READINGS[:300]) != plain
    with pytest.raises(smaservo.ConfigError, match='observer.heat_eror'):
        smaservo.Estimator(WIRE, settings={'observer.heat_eror': 1})
    with pytest.raises(ValueError, match='^ambient_K = 0'):
        smaservo.Estimator(WIRE, ambient_K=0)


def test_an_estimate_is_pickled_to_the_bit():
    estimate = smaservo.Estimator(WIRE).update(*READINGS[0], 1e-3)
    assert bits_of(pickle.loads(pickle.dumps(estimate))) == bits_of(estimate)
    with pytest.raises(AttributeError):
        estimate.strain = 0
