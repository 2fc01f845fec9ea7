#!/usr/bin/env python3
"""The installed library as programs outside of the tree use it.

library_test.py install BUILD STAGE                  installs the component `library` into an empty folder
library_test.py cmake STAGE SOURCES COMPILER [TABLE]  user/ by find_package(); TABLE: the program smaservo-table
library_test.py pkgconfig STAGE SOURCES COMPILER     user/main.cpp by pkg-config, without CMake
library_test.py headers STAGE SOURCES COMPILER FLAG... each public header by itself, with these warnings
library_test.py readme STAGE SOURCES                 the program of toolchain/library/README.md
library_test.py missing STAGE SOURCES                what is said of a wrong version and of what is missing
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

WARNINGS = '-Wall -Wextra -Werror -Wconversion'
USER = Path(__file__).resolve().parent / 'user'
PRINTED = '''heated: 144 degC, strain 0.51 %
replayed: strain 0.9 %, reference 0.9 %
held: running, strain 2.0 %, faults ''
wire: flexinol-lt-0.16mm: no such wire (did you mean flexinol-lt-0.10mm'''


def run(*words, code=0, **options):
    """What a command prints; it must end with this code."""
    environment = {name: value for name, value in os.environ.items()
                   if name not in ('CXXFLAGS', 'CPPFLAGS', 'LDFLAGS', 'CMAKE_PREFIX_PATH', 'PKG_CONFIG_PATH')}
    environment.update(options.pop('env', {}))
    done = subprocess.run([str(word) for word in words], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, env=environment, **options)
    if code is not None and done.returncode != code:
        sys.exit(f'{" ".join(map(str, words))}\nended with {done.returncode}, not {code}:\n{done.stdout}')
    return done.stdout


def demand(text, *parts):
    for part in parts:
        if part not in text:
            sys.exit(f'wanted:\n{part}\nis not in:\n{text}')


def install(build, stage):
    shutil.rmtree(stage, ignore_errors=True)
    run('cmake', '--install', build, '--component', 'library', '--prefix', stage)
    # Of the programs nothing, and nothing that names the folders that it was built in.
    found = {path.name for path in Path(stage).iterdir()}
    if found != {'lib', 'include'}:
        sys.exit(f'the component installs {found}')
    for path in Path(stage).rglob('*'):
        if path.is_file() and os.fsencode(Path(build).resolve().parent) in path.read_bytes():
            sys.exit(f'{path} names the folder of the build')


def run_program(program, sources, work, table=None):
    """What the user's program computes. Where smaservo-table is not beside it, nor installed, that is said."""
    spreadsheet = work / 'broken.xlsx'
    spreadsheet.write_bytes(b'PK\x03\x04 is no archive')
    arguments = (sources / 'host-sim/traces/150MPa.csv', sources / 'host-sim/traces/units/a.toml', spreadsheet)
    said = run(program, *arguments)
    demand(said, PRINTED)
    places = [Path(prefix, 'lib/smaservo/smaservo-table') for prefix in ('/usr/local', '/usr')]
    unknown = 'it belongs to the package smaservo'
    if not any(place.exists() for place in places):
        demand(said, f'spreadsheet: {spreadsheet}: is read by the program smaservo-table, which cannot be started '
                     f'({program.parent.parent}/lib/smaservo/smaservo-table: No such file or directory); {unknown}')
    if table:
        beside = program.parent.parent / 'lib/smaservo'
        beside.mkdir(parents=True)
        (beside / 'smaservo-table').symlink_to(table)
        said = run(program, *arguments)
        demand(said, f'spreadsheet: {spreadsheet}: ')
        if unknown in said:
            sys.exit(f'the program beside it was not found:\n{said}')


def by_cmake(stage, sources, compiler, table=None):
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder).resolve()
        shutil.copytree(USER, work / 'user')
        said = run('cmake', '-S', work / 'user', '-B', work / 'build', f'-DCMAKE_PREFIX_PATH={stage}',
                   f'-DCMAKE_CXX_COMPILER={compiler}', f'-DCMAKE_CXX_FLAGS={WARNINGS}')
        if 'Warning' in said:
            sys.exit(said)
        run('cmake', '--build', work / 'build', '-j2')
        run(work / 'build/model_alone')
        run_program(work / 'build/program', sources, work, table)


def by_pkg_config(stage, sources, compiler):
    where = next(stage.rglob('smaservo.pc')).parent
    flags = run('pkg-config', '--cflags', '--libs', 'smaservo', env={'PKG_CONFIG_PATH': str(where)})
    # Eigen's own headers have what -Wconversion finds.
    flags = flags.replace('-I/usr/include/eigen3', '-isystem /usr/include/eigen3').split()
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder).resolve()
        (work / 'bin').mkdir()
        run(compiler, '-std=c++20', *WARNINGS.split(), USER / 'main.cpp', f'-I{USER}', *flags,
            '-o', work / 'bin/program', cwd=work)
        run_program(work / 'bin/program', sources, work)


def headers_alone(stage, sources, compiler, *flags):
    """Not as system headers, so that a warning in one of them is an error. Twice, since a header may be."""
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(sources / 'toolchain/library'))
    import api
    eigen = run('pkg-config', '--cflags', 'eigen3').replace('-I', '-isystem').split()
    warnings = [flag for flag in flags if flag.startswith('-W')] + ['-Wno-unknown-warning-option'] * (
        'clang' in compiler)

    def check(header):
        line = f'#include <smaservo/{header}>\n'
        run(compiler, '-std=c++20', '-fsyntax-only', *warnings, f'-I{stage}/include', *eigen, '-x', 'c++', '-',
            input=line + line)

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(check, api.listed_headers()))


def readme(stage, sources):
    """Its blocks below the marks `program: FILE` make a program, which prints what the text says."""
    text = (sources / 'toolchain/library/README.md').read_text()
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder).resolve()
        for name, block in re.findall(r'<!-- program: (\S+);[^\n]*-->\n\n((?:(?:    [^\n]*)?\n)+)', text):
            (work / name).write_text(textwrap.dedent(block))
        run('cmake', '-S', work, '-B', work / 'build', f'-DCMAKE_PREFIX_PATH={stage}',
            f'-DCMAKE_CXX_FLAGS={WARNINGS}')
        run('cmake', '--build', work / 'build')
        printed = re.search(r'It prints `([^`]+)`', text).group(1)
        said = run(work / 'build/program')
        if said != printed + '\n':
            sys.exit(f'README.md says {printed!r}, and it prints {said!r}')


def missing(stage, sources):
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder).resolve()

        def configure(wanted, *flags, code=1, env=()):
            source = work / 'source'
            shutil.rmtree(work, ignore_errors=True)
            source.mkdir(parents=True)
            (source / 'CMakeLists.txt').write_text(
                f'cmake_minimum_required(VERSION 3.25)\nproject(user LANGUAGES CXX)\nfind_package({wanted})\n')
            return ' '.join(run('cmake', '-S', source, '-B', work / 'build', f'-DCMAKE_PREFIX_PATH={stage}', *flags,
                                code=code, env=dict(env)).split())

        configure('smaservo 0.1 REQUIRED', code=0)
        demand(configure('smaservo 0.2 REQUIRED'),
               'compatible with requested version "0.2"', 'smaservo-config.cmake, version: 0.1')
        demand(configure('smaservo REQUIRED COMPONENTS models'),
               'smaservo has no component models; it has model, observer, device, files')
        configure('smaservo REQUIRED COMPONENTS model OPTIONAL_COMPONENTS models', code=0)
        demand(configure('smaservo REQUIRED', '-DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON'), 'Eigen3')
        demand(configure('smaservo REQUIRED', '-DCMAKE_DISABLE_FIND_PACKAGE_fmt=ON'), 'fmt')
        demand(configure('smaservo REQUIRED', env={'PKG_CONFIG_LIBDIR': '/nowhere'}),
               'smaservo::files needs tomlplusplus, which pkg-config does not find (its file tomlplusplus.pc)')
        # Headers alone need no more than they say.
        nothing = [f'-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON' for name in ('fmt', 'PkgConfig')]
        configure('smaservo REQUIRED COMPONENTS observer device', *nothing, code=0)
        configure('smaservo REQUIRED COMPONENTS model', *nothing, '-DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON', code=0)


def main():
    what, *arguments = sys.argv[1:]
    if what == 'install':
        install(*arguments)
        return
    stage, sources = (Path(argument).resolve() for argument in arguments[:2])
    {'cmake': by_cmake, 'pkgconfig': by_pkg_config, 'headers': headers_alone, 'readme': readme,
     'missing': missing}[what](
        stage, sources, *arguments[2:])


if __name__ == '__main__':
    main()
