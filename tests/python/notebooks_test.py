"""The notebooks run, and what is stored in them is what they print and draw."""

import ast
import base64
import getpass
import io
import json
import os
import re
import socket
import subprocess
import sys

import pytest
from places import SOURCE

FOLDER = SOURCE / 'host-sim/python/notebooks'
NOTEBOOKS = sorted(FOLDER.glob('*.ipynb'))
METADATA = {
    'kernelspec': {'display_name': 'Python 3', 'language': 'python', 'name': 'python3'},
    'language_info': {'name': 'python'},
}
NUMBER = re.compile(r'\d+(?:\.\d+)?')
each = pytest.mark.parametrize('path', NOTEBOOKS, ids=[path.stem for path in NOTEBOOKS])


def code_of(path):
    return [cell for cell in json.loads(path.read_text())['cells'] if cell['cell_type'] == 'code']


def printed(cell):
    """All text of a cell, in order; what goes with a figure is only its size."""
    texts = []
    for output in cell['outputs']:
        if output['output_type'] == 'stream':
            texts += output['text']
        elif 'image/png' not in output['data']:
            texts += output['data']['text/plain']
    return ''.join(texts)


def figures(cell):
    data = [output['data'] for output in cell['outputs'] if 'data' in output]
    return [base64.b64decode(''.join(one['image/png'])) for one in data if 'image/png' in one]


def same_text(text, wanted):
    """Whether words are the same, and numbers but for one in their last digit, which another compiler may decide."""
    if NUMBER.sub('#', text) != NUMBER.sub('#', wanted):
        return False
    for number, other in zip(NUMBER.findall(text), NUMBER.findall(wanted)):
        digits = {len(one.partition('.')[2]) for one in (number, other)}
        if len(digits) > 1 or abs(float(number) - float(other)) > 1.001 * 10.0 ** -digits.pop():
            return False
    return True


def test_these_are_all():
    assert [path.name for path in NOTEBOOKS] == [
        '1_estimate_my_recording.ipynb',
        '2_calibrate.ipynb',
        '3_design_a_controller.ipynb',
    ]
    assert [path.name for path in FOLDER.iterdir() if path.suffix != '.ipynb'] in ([], ['.ipynb_checkpoints'])


def test_texts_are_compared():
    assert same_text('a 1.20 ± 0.5, 7\n', 'a 1.21 ± 0.4, 8\n')
    for other in ('a 1.22 ± 0.5, 7\n', 'a 1.20 ± 0.5, 9\n', 'b 1.20 ± 0.5, 7\n', 'a 1.2 ± 0.5, 7\n', 'a 1.20 ± 0.5\n'):
        assert not same_text('a 1.20 ± 0.5, 7\n', other)
    assert not same_text('-0.5', '+0.5')


@each
def test_says_the_same_again(path, tmp_path):
    program = [sys.executable, str(SOURCE / 'tests/python/notebooks.py'), '--into', str(tmp_path), str(path)]
    run = subprocess.run(program, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    stored, now = code_of(path), code_of(tmp_path / path.name)
    assert [cell['source'] for cell in stored] == [cell['source'] for cell in now]
    for was, cell in zip(stored, now):
        again = 'once the difference is reviewed: toolchain/dev figures notebooks'
        assert same_text(printed(cell), printed(was)), f'{printed(cell)}\nstored is:\n{printed(was)}\n{again}'
        assert len(figures(cell)) == len(figures(was))
        for picture in figures(cell):
            check_picture(picture)


def check_picture(data):
    """A figure has a size that can be read, and lines and letters on a ground."""
    from PIL import Image

    with Image.open(io.BytesIO(data)) as picture:
        assert picture.format == 'PNG'
        assert 600 <= picture.width <= 1000 and 200 <= picture.height <= 1000
        assert not picture.info.keys() - {'transparency'}
        grey = picture.convert('RGB').convert('L').histogram()
    assert sum(1 for count in grey if count > 0) > 20
    assert 0.01 < 1 - max(grey) / sum(grey) < 0.5


@each
def test_was_stored_by_a_whole_run(path):
    cells = code_of(path)
    assert [cell['execution_count'] for cell in cells] == list(range(1, len(cells) + 1))
    assert sum(len(figures(cell)) for cell in cells) in (3, 4)
    for cell in cells:
        ast.parse(''.join(cell['source']))
        assert cell['source'] and cell['metadata'] == {}
        for output in cell['outputs']:
            assert output.get('name', 'stdout') == 'stdout' and output['output_type'] != 'error'
        for picture in figures(cell):
            check_picture(picture)


@each
def test_is_stored_in_a_stable_form(path):
    text = path.read_text()
    notebook = json.loads(text)
    assert text == json.dumps(notebook, indent=1, sort_keys=True, ensure_ascii=False) + '\n'
    assert notebook['metadata'] == METADATA
    assert [cell['id'] for cell in notebook['cells']] == [f'cell-{n}' for n in range(1, len(notebook['cells']) + 1)]


@each
def test_names_no_machine(path):
    notebook = json.loads(path.read_text())
    for cell in notebook['cells']:
        for output in cell.get('outputs', []):
            output.get('data', {}).pop('image/png', None)
    outputs = json.dumps([cell.get('outputs') for cell in notebook['cells']], ensure_ascii=False)
    everything = json.dumps(notebook, ensure_ascii=False)
    assert not re.search(r'(?<![\w.)/])(/|~/|[A-Z]:\\\\)\w+/', outputs)
    for name in {getpass.getuser(), socket.gethostname(), str(SOURCE), os.path.expanduser('~')} - {'root'}:
        assert not re.search(rf'\b{re.escape(name)}\b', everything), name


@each
def test_reads_as_one_text(path):
    """It begins with a heading and what one has at its end, and no line is wider than a browser shows."""
    cells = json.loads(path.read_text())['cells']
    first = ' '.join(''.join(cells[0]['source']).split())
    assert cells[0]['cell_type'] == 'markdown' and first.startswith('# ') and 'At its end one has' in first
    for cell in cells:
        for line in ''.join(cell['source']).splitlines() + printed_lines(cell):
            assert len(line) <= 120 and line == line.rstrip() and '\t' not in line, line


def printed_lines(cell):
    return printed(cell).splitlines() if cell['cell_type'] == 'code' else []


def test_the_package_does_not_need_matplotlib():
    code = 'import sys, smaservo; smaservo.simulate("smartflex-76um", [0, 1], 0, 1); print("matplotlib" in sys.modules)'
    run = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert run.stdout == 'False\n'
