"""smaservo.Wire"""

import copy
import pickle
import random

import pytest
import smaservo
from places import SOURCE, UNIT_A, host_sim


def test_every_preset_is_what_host_sim_describes():
    names = smaservo.wire_presets()
    assert names == sorted(names) and len(names) > 10
    for name in names:
        wire = smaservo.Wire.load(name)
        assert wire.name == name
        printed, _ = host_sim('wires', name)
        assert smaservo.Wire.parse(printed) == wire


@pytest.mark.parametrize('name', [*smaservo.wire_presets(), str(UNIT_A)])
def test_pickle_copy_and_text_keep_the_bits(name):
    wire = smaservo.Wire.load(name)
    read = smaservo.Wire.parse(wire.to_toml())
    for other in (pickle.loads(pickle.dumps(wire)), copy.copy(wire), copy.deepcopy(wire), read):
        assert other == wire and hash(other) == hash(wire)
        assert other.name == wire.name and other.sources == wire.sources
        assert other.parameters() == wire.parameters()


def test_random_changes_survive_pickle_and_are_seen():
    rng = random.Random(1)
    wire = smaservo.Wire.load('smartflex-76um')
    for _ in range(50):
        numbers = {'wire.length_m': rng.uniform(0.01, 1), 'wire.heat.density_kg_m3': rng.uniform(6000, 7000)}
        changed = wire.replace(numbers)
        assert changed != wire and pickle.loads(pickle.dumps(changed)) == changed
        assert {wire: 1, changed: 2}[changed] == 2


def test_a_wire_is_its_numbers():
    wire = smaservo.Wire.load('smartflex-76um', {'wire.length_mm': 120})
    assert wire['wire.length_m'] == wire.length_m == 0.12
    assert wire == smaservo.Wire.load('smartflex-76um', {'wire.length_m': 0.12})
    assert wire != smaservo.Wire.load('smartflex-76um', {'wire.length_m': 0.12 * (1 + 2.3e-16)})
    assert wire != 'smartflex-76um' and (wire == 1) is False
    assert wire.area_m2 == pytest.approx(3.14159265 / 4 * wire.diameter_m**2)
    assert wire['wire.memory'] in ('plain', 'return-point') and wire['wire.separate_r2a'] in (True, False)
    for path, value in wire.parameters().items():
        assert wire[path] == value
    assert wire.max_current_A == wire['wire.limits.current_A']
    assert wire.max_stress_Pa == wire['wire.limits.stress_Pa']
    assert wire.max_temperature_K == wire['wire.limits.temperature_K']
    assert 1 < wire.cold_resistance_ohm < 100 and 'smartflex-76um' in repr(wire)


def test_settings_take_numbers_of_any_kind():
    numpy = pytest.importorskip('numpy')
    for length in (120, 120.0, '120', numpy.float64(120), numpy.float32(120), numpy.int32(120)):
        assert smaservo.Wire.load('smartflex-76um', {'wire.length_mm': length}).length_m == 0.12
    assert smaservo.Wire.load('smartflex-76um', {'wire.memory': 'plain'})['wire.memory'] == 'plain'


def message_of_host_sim(*arguments):
    _, text = host_sim(*arguments, status=1)
    return text.strip().removeprefix('host-sim: ')


def test_messages_are_those_of_host_sim():
    trace = SOURCE / 'host-sim/traces/150MPa.csv'
    for name, settings in [
        ('smartflex-76mm', {}),
        ('nothing.toml', {}),
        ('smartflex-76um', {'wire.length_mm': -3}),
        ('smartflex-76um', {'wire.lenght_mm': 120}),
        ('smartflex-76um', {'wire.memory': 'none'}),
    ]:
        with pytest.raises(smaservo.ConfigError if 'toml' not in name else smaservo.UserError) as error:
            smaservo.Wire.load(name, settings)
        given = [part for key, value in settings.items() for part in ('--set', f'{key}={value}')]
        assert str(error.value) == message_of_host_sim('replay', '--wire', name, *given, trace)
        assert isinstance(error.value, (smaservo.Error, ValueError))


def test_mistakes_of_type_and_name():
    wire = smaservo.Wire.load('smartflex-76um')
    with pytest.raises(KeyError, match='wire.length_m'):
        wire['wire.lenght_m']
    for settings in ([], 3, 'wire.length_mm=1', {1: 2}, {'wire.length_mm': None}, {'wire.length_mm': 1j}):
        with pytest.raises(TypeError, match='settings'):
            wire.replace(settings)
    with pytest.raises(TypeError):
        smaservo.Wire.load(3)
    with pytest.raises(TypeError, match='No constructor'):
        smaservo.Wire()
    with pytest.raises(AttributeError):
        wire.length_m = 3


def test_text_from_outside_is_escaped(tmp_path):
    with pytest.raises(smaservo.Error) as error:
        smaservo.Wire.load(str(tmp_path / 'a\x1b[2Jb.toml'))
    assert '\x1b' not in str(error.value) and 'x1B' in str(error.value)
