"""Every example of the docstrings and of the README runs, and everything public has a docstring."""

import doctest
import inspect
import re
from pathlib import Path

import pytest
import smaservo
from places import SOURCE

README = SOURCE / 'host-sim/python/README.md'


def documents():
    """Names and docstrings of all that is public."""
    yield 'smaservo', smaservo.__doc__
    for name in smaservo.__all__:
        thing = getattr(smaservo, name)
        if isinstance(thing, (type, type(smaservo.read))) or callable(thing):
            yield name, thing.__doc__
        if isinstance(thing, type) and thing.__module__ == 'smaservo':
            for member, value in vars(thing).items():
                if not member.startswith('_') and (callable(value) or isinstance(value, staticmethod)):
                    yield f'{name}.{member}', getattr(thing, member).__doc__


def test_everything_public_has_a_docstring():
    names = dict(documents())
    assert len(names) > 50 and 'Plant.update' in names and 'Wire.load' in names
    assert [name for name, text in names.items() if not text or len(text) < 20] == []


def test_results_of_objects_are_described_by_their_class():
    for kind in (smaservo.PlantState, smaservo.Estimate, smaservo.ServoOutput):
        attributes = [name for name, value in vars(kind).items() if isinstance(value, property)]
        assert len(attributes) >= 5 and [name for name in attributes if name not in kind.__doc__] == []


def run(name, text):
    test = doctest.DocTestParser().get_doctest(text, {}, name, None, 0)
    said = []
    runner = doctest.DocTestRunner(verbose=False)
    runner.run(test, out=said.append)
    assert runner.failures == 0, ''.join(said)
    return len(test.examples)


EXAMPLES = [(name, text) for name, text in documents() if '>>>' in (text or '')]


@pytest.mark.parametrize('name, text', EXAMPLES, ids=[name for name, _ in EXAMPLES])
def test_examples_of_docstrings(name, text, monkeypatch):
    monkeypatch.chdir(SOURCE)
    assert run(name, inspect.cleandoc(text)) > 0


def test_examples_of_the_readme(monkeypatch):
    monkeypatch.chdir(SOURCE)
    assert run('README.md', README.read_text()) > 15


def test_blocks_that_are_not_run_say_so():
    text = README.read_text()
    blocks = re.split(r'^```', text, flags=re.MULTILINE)
    for before, block in zip(blocks[::2], blocks[1::2]):
        if '>>>' not in block:
            assert 'Not run by the tests' in before.split('\n\n')[-2], block
            compile(block.removeprefix('python\n'), 'README.md', 'exec')


def test_the_readme_names_everything():
    text = README.read_text()
    hidden = {'__version__', 'Columns', 'Estimates', 'Recording', 'Simulation', 'Identification', 'PlantState'}
    hidden |= {'Estimate', 'ServoOutput', 'observers', 'evaluation_rows'}
    assert [name for name in smaservo.__all__ if name not in hidden and name not in text] == []


def test_versions_agree():
    project = re.search(r'project\(smaservo VERSION ([0-9.]+)', (SOURCE / 'CMakeLists.txt').read_text())
    assert smaservo.__version__ == project[1]
    assert not list(Path(smaservo.__file__).parent.glob('*.pyc'))
