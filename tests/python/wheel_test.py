"""The wheel: pip builds and installs it without a network, and the README's first lines run with it."""

import os
import re
import subprocess

from places import BUILD, SOURCE

# As CMakePresets.json has it, so that ccache knows what the build of the release has compiled.
COMPILER = {
    'CXX': 'g++',
    'CMAKE_CXX_COMPILER_LAUNCHER': 'ccache',
    'CCACHE_BASEDIR': str(SOURCE),
    'CCACHE_NOHASHDIR': '1',
    'CCACHE_DEPEND': '1',
    'CMAKE_BUILD_PARALLEL_LEVEL': '2',
}


def run(*arguments, **options):
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_a_venv_gets_it_by_pip(tmp_path):
    environment = {name: value for name, value in os.environ.items() if name != 'PYTHONPATH'}
    # The folder of the build stays, so that the next time compiles what has changed. It is as deep as that of the
    # release: so ccache knows the sources.
    venv, tree = tmp_path / 'env', BUILD.parent / f'wheel-{BUILD.name}'
    run('/usr/bin/python3', '-m', 'venv', '--system-site-packages', venv, env=environment)
    run(
        *(venv / 'bin/pip', 'install', '--no-build-isolation', '--no-index', '--no-deps'),
        *(f'--config-settings=build-dir={tree}', SOURCE / 'host-sim/python'),
        env={**environment, **COMPILER},
    )
    block = re.search(r'```python\n(.*?)```', (SOURCE / 'host-sim/python/README.md').read_text(), re.DOTALL)[1]
    lines = [line.removeprefix('>>> ') for line in block.splitlines() if line.startswith('>>> ')]
    wanted = [line for line in block.splitlines() if line and not line.startswith('>>> ')]
    assert len(lines) == 5
    printed = run(venv / 'bin/python', '-c', '\n'.join(lines), cwd=SOURCE, env=environment)
    assert printed.splitlines() == wanted
    where = run(venv / 'bin/python', '-c', 'import smaservo; print(smaservo.__file__)', cwd=tmp_path, env=environment)
    assert where.startswith(str(venv))
    files = run(venv / 'bin/pip', 'show', '-f', 'smaservo', env=environment)
    for name in ('smaservo/py.typed', 'smaservo/_core.pyi', 'smaservo/_tables.py', 'Version: '):
        assert name in files
    # Nothing else of the project is installed with it.
    installed = [line.strip() for line in files.split('Files:')[1].splitlines() if line.strip()]
    assert all(line.startswith(('smaservo/', 'smaservo-')) for line in installed), installed
