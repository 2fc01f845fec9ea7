"""read(), simulate_scenario()"""

import gzip

import numpy as np
import pytest
import smaservo
from places import SOURCE, TRACES, host_sim


def test_numbers_of_any_dialect_are_in_si(tmp_path):
    file = tmp_path / 'logger.csv'
    file.write_text('Logger 7;;;\nZeit [ms];I [mA];U [V];Kraft/N;note\n0;100,5;2,25;0,5;a\n10;101;2,5;0,5;b\n')
    recording = smaservo.read(file)
    assert recording.time_s.tolist() == [0, 0.01] and recording.current_A.tolist() == [0.1005, 0.101]
    assert recording.load_N.tolist() == [0.5, 0.5] and recording.note.tolist() == ['a', 'b']
    assert 'separated by semicolons' in recording.notes['read_as']


def test_other_columns_are_numbers_or_texts(tmp_path):
    file = tmp_path / 'run.csv'
    file.write_text('time_s,current_A,voltage_V,other,text,none\n0,0.1,2,1.5,x,\n1,0.1,2,,2,\n')
    recording = smaservo.read(file)
    assert recording.other[0] == 1.5 and np.isnan(recording.other[1])
    assert recording.text.tolist() == ['x', '2'] and recording.none.tolist() == ['', '']
    packed = tmp_path / 'run.csv.gz'
    packed.write_bytes(gzip.compress(file.read_bytes()))
    assert smaservo.read(packed).current_A.tolist() == [0.1, 0.1]


def test_options(tmp_path):
    file = tmp_path / 'run.csv'
    file.write_text('current_mA,U,load_N\n100,2,1\n1e9,2,1\n100,2,1\n')
    with pytest.raises(smaservo.TraceError, match='line 3'):
        smaservo.read(file, columns=['voltage=U:V'], period_s=0.5)
    recording = smaservo.read(file, columns=['voltage=U:V'], period_s=0.5, lenient=True)
    assert recording.current_A.tolist() == [0.1, 0.1] and recording.notes['skipped'] == 1
    assert recording.voltage_V.tolist() == [2, 2] and len(recording.time_s) == 2
    with pytest.raises(ValueError, match='^period_s = 0'):
        smaservo.read(file, period_s=0)
    with pytest.raises(TypeError, match='^columns: must be a list of texts'):
        smaservo.read(file, columns='voltage=U:V')


def test_the_voltage_of_a_resistance(tmp_path):
    file = tmp_path / 'run.csv'
    file.write_text('time_s,current_A,resistance_ohm,load_N\n0,0.1,20,0.5\n1,0.2,21,0.5\n')
    recording = smaservo.read(file)
    assert recording.voltage_V.tolist() == [0.1 * 20, 0.2 * 21] and recording.resistance_ohm.tolist() == [20, 21]


def test_messages_are_those_of_host_sim(tmp_path):
    empty, bad = tmp_path / 'empty.csv', tmp_path / 'bad.csv'
    empty.write_text('')
    bad.write_text('time_s,current_A,voltage_V,load_N\n0,0.1,2,1\n0,0.1,2,1\n')
    for file in (tmp_path / 'none.csv', empty, bad):
        with pytest.raises(smaservo.Error) as error:
            smaservo.read(file)
        _, text = host_sim('replay', file, status=1)
        assert text.strip().removeprefix('host-sim: ') == str(error.value)


CLOSED_LOOP = SOURCE / 'host-sim/scenarios/wire-break.toml'


@pytest.mark.parametrize('scenario', [TRACES / '150MPa.toml', TRACES / 'bath.toml', CLOSED_LOOP])
def test_a_scenario_gives_what_host_sim_writes(tmp_path, scenario):
    out = tmp_path / 'trace.csv'
    host_sim('simulate', scenario, '--out', out)
    got, wanted = smaservo.simulate_scenario(scenario), smaservo.read(out)
    assert list(got) == list(wanted) and len(got) >= 3
    for name in wanted:
        assert np.array_equal(got[name], wanted[name], equal_nan=got[name].dtype.kind == 'f'), name
