#!/usr/bin/python3
"""notebooks.py [--into FOLDER] [NOTEBOOK ...]: runs notebooks of host-sim/python/notebooks (all by default), and stores
them with their outputs: in place, or in FOLDER.

`toolchain/dev figures notebooks` calls it; notebooks_test.py does so with a FOLDER, and compares. A notebook runs in a
kernel of its own, in a temporary copy of its folder with the project's traces; nothing is written into the folder of the
user. What is stored is the same bytes in each run on one machine: figures have a palette and no metadata, cells have
their number as id, and there are no times.
"""

import argparse
import base64
import io
import os
import shutil
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / 'host-sim/python/notebooks'
METADATA = {
    'kernelspec': {'display_name': 'Python 3', 'language': 'python', 'name': 'python3'},
    'language_info': {'name': 'python'},
}


def at_home_in(folder):
    """Lets Jupyter, IPython and matplotlib keep their files in this folder; a kernel works in another one."""
    paths = os.environ.get('PYTHONPATH', '').split(os.pathsep)
    os.environ |= {
        'PYTHONPATH': os.pathsep.join(os.path.abspath(path) for path in paths if path),
        'HOME': str(folder),
        'IPYTHONDIR': str(folder / 'ipython'),
        'JUPYTER_CONFIG_DIR': str(folder / 'config'),
        'JUPYTER_DATA_DIR': str(folder / 'data'),
        'JUPYTER_RUNTIME_DIR': str(folder / 'runtime'),
        'MPLCONFIGDIR': str(folder / 'matplotlib'),
        'PYTHONDONTWRITEBYTECODE': '1',
        'PYDEVD_DISABLE_FILE_VALIDATION': '1',  # else the kernel warns of a debugger that nobody uses
    }
    (folder / 'runtime').mkdir()


def small(png):
    """A figure with a palette, as base64: no metadata, a third of the size."""
    from PIL import Image

    with Image.open(io.BytesIO(base64.b64decode(png))) as picture:
        few = picture.convert('RGB').quantize(128, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    data = io.BytesIO()
    few.save(data, 'PNG', optimize=True)
    return base64.b64encode(data.getvalue()).decode()


def stable_outputs(outputs):
    """Streams in one piece, whichever pieces they came in, and small figures."""
    stable = []
    for output in outputs:
        before = stable[-1] if stable else {}
        if output['output_type'] == 'stream' and before.get('name') == output['name']:
            before['text'] += output['text']
            continue
        if 'image/png' in output.get('data', {}):
            output['data']['image/png'] = small(output['data']['image/png'])
        stable.append(output)
    return stable


def run(path, home):
    """The notebook with the outputs of a clean kernel."""
    import nbclient
    import nbformat

    notebook = nbformat.read(path, as_version=4)
    copy = home / path.stem / FOLDER.relative_to(ROOT)
    copy.mkdir(parents=True)
    shutil.copytree(ROOT / 'host-sim/traces', copy.parents[1] / 'traces')
    client = nbclient.NotebookClient(
        notebook, timeout=600, kernel_name='python3', record_timing=False, resources={'metadata': {'path': str(copy)}}
    )
    client.execute()
    notebook.metadata = nbformat.from_dict(METADATA)
    notebook.nbformat, notebook.nbformat_minor = 4, 5
    for number, cell in enumerate(notebook.cells, 1):
        cell.id = f'cell-{number}'
        cell.metadata = nbformat.from_dict({})
        if cell.cell_type == 'code':
            cell.outputs = stable_outputs(cell.outputs)
    nbformat.validate(notebook)
    return nbformat.writes(notebook).rstrip('\n') + '\n'


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--into', type=Path)
    parser.add_argument('notebooks', nargs='*', type=Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        at_home_in(Path(folder))
        for path in given.notebooks or sorted(FOLDER.glob('*.ipynb')):
            text = run(path, Path(folder))
            to = (given.into or path.parent) / path.name
            to.with_suffix('.new').write_text(text)
            to.with_suffix('.new').replace(to)


if __name__ == '__main__':
    sys.exit(main())
