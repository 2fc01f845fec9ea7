"""The parts of `toolchain/dev test`: what each reads, and what it does.

A part's key is a number over the content of all that the part reads, its scripts and flags among them, and over
the versions of the tools. When a part passes, its key is kept on this machine, outside the clone; as long as the
key is the same, the part is not run again. After a build, the files that it has read, as ninja knows them, are
compared with the part's inputs: a file that is missing there fails the part.
"""

from dataclasses import dataclass, field
from functools import cache
import hashlib
import os
from pathlib import Path
import re
import subprocess

ROOT = Path(__file__).resolve().parents[2]
KEPT = Path(os.environ.get('XDG_CACHE_HOME') or Path.home() / '.cache') / 'smaservo'


@dataclass
class Step:
    name: str
    command: list
    live: bool = False  # in real time
    beside: 'Step | None' = None  # at idle priority, at the same time


@dataclass
class Part:
    what: str
    steps: list
    inputs: list = field(default_factory=list)  # git's path patterns; none: it is always run
    built: dict = field(default_factory=dict)  # a tree and its targets


def dev(*words):
    """A function of the scripts beside this file."""
    return [str(ROOT / 'toolchain/dev'), 'do', *words]


def build(tree, *targets):
    return Step(f'{tree}-build', dev('build_tree', tree, *targets))


def ctest(preset, **options):
    report = ROOT / f'build/logs/{preset}.xml'
    return Step(f'{preset}-test', ['ctest', '--preset', preset, '--output-junit', str(report)], **options)


def scripts(*names):
    return [f'toolchain/lib/{name}' for name in ('build.sh', 'parts.py', 'setup.sh', *names)]


# How everything is built, and the lists of sources.
MADE_BY = ['CMakeLists.txt', '*/CMakeLists.txt', 'CMakePresets.json', 'toolchain/cmake', 'toolchain/library',
           'toolchain/packages.txt']
CORE = ['model', 'observer', 'hal', 'firmware']
# The pages are a tree of npm's, which only what is shipped holds. The notebooks are shipped by nothing.
PROGRAMS = [*CORE, 'host-sim', ':!host-sim/python/notebooks', 'toolchain/package', 'LICENSE']
NO_PAGES = [':!host-sim/page/front']
# Nothing is built from these. Tests compare them with the programs; all of these run with the release, and one with CAN.
NO_TEXTS = [*(f':!{folder}/*README.md' for folder in CORE), ':!firmware/SAFETY.md', ':(exclude,glob)host-sim/README.md',
            ':(exclude,glob)host-sim/*/README.md']
# Of the tests, what is compiled, and what compiled tests read; those in Python run with the release alone, or with
# sanitizers, too.
TESTS_AND_PYTHON = ['tests', ':!tests/*.js', ':!tests/*.sh', ':!tests/*.md', ':!tests/*.json']
TESTS = [*TESTS_AND_PYTHON, ':!tests/*.py']
OF_RELEASE = [f':!tests/{name}' for name in (
    'library/*.py', 'bench/*.py', 'host-sim/campaign/cluster/*.py', 'python/notebooks*.py', 'python/types_test.py', 'python/wheel_test.py')]
CAN_PROGRAMS = ['host-sim', 'smaservod', 'can_socket_tests']
GUESTS = ['tests/board', 'tests/can/device.toml', 'host-sim/scenarios', 'toolchain/board', 'toolchain/can/uml']

PARTS = {
    'release': Part(
        'all tests with g++, the page in two browsers, the lines of the README',
        [build('release'), ctest('live', live=True, beside=ctest('still')),
         Step('replay', [str(ROOT / 'toolchain/dev'), 'replay'])]),
    'downloads': Part('packages of npm for the tests', [Step('downloads', dev('fetch_for_test'))]),
    'texts': Part('formatting, shellcheck, Biome, house rules, rooms, figures', [Step('texts', dev('check_all_texts'))]),
    'fetch': Part(
        'kernels, libraries of other architectures and clients for the parts below',
        [Step('fetch', dev('fetch_for_parts'))]),
    'board': Part(
        'the daemon on emulated boards: kernels with CAN, IIO, PWM and GPIO',
        [build('release', 'board_programs'), ctest('board', live=True)],
        [*MADE_BY, *CORE, *GUESTS, 'tests/model', *scripts('board.sh', 'board_kernel.sh'), *NO_TEXTS],
        {'release': ['board_programs']}),
    'can': Part(
        "CAN clients of others, the page's bridge and our own sockets on a kernel's CAN, in a guest",
        [build('release', *CAN_PROGRAMS), ctest('can', live=True)],
        [*MADE_BY, *PROGRAMS, 'tests/can', 'tests/npm.sh', 'tests/patience.*', 'toolchain/can',
         *(f'tests/host-sim/page/{name}' for name in ('node', 'bridge.js', 'on_vcan.js', 'browser/world.js')),
         *scripts('can.sh', 'board.sh')],
        {'release': CAN_PROGRAMS}),
    'mcu': Part(
        'the core on Cortex-M in QEMU, within its budget',
        [Step('mcu', dev('test_mcu'))],
        [*MADE_BY, *CORE, 'tests/mcu', 'tests/model', 'tests/firmware', 'tests/places.*', 'host-sim/scenarios',
         'host-sim/traces', 'toolchain/mcu', 'tests/bench', *scripts('mcu.sh'), *NO_TEXTS],
        {'release': ['write_steps', 'answer_steps', 'hold_strain', 'count_operations'],
         **{f'mcu-{core}': ['all'] for core in ('m0plus', 'm3', 'm4f', 'm7', 'm33')}}),
    'package': Part(
        'Debian packages for three architectures; their service in a Debian system',
        [Step('packages', dev('test_package')),
         build('release', 'board_programs'), ctest('package', live=True)],
        [*MADE_BY, *PROGRAMS, *GUESTS, 'CHANGELOG.md', 'tests/model', 'tests/library', 'tests/python',
         'tests/firmware/daemon/setup_test.sh',
         *scripts('package.sh', 'sysroot.sh', 'board.sh', 'board_kernel.sh', 'board_root.sh'), *NO_TEXTS],
        {'release': ['package_contents', 'board_programs'], 'arm64': ['package_contents'],
         'armhf': ['package_contents']}),
    'sanitize': Part(
        'clang++ with address and undefined-behaviour sanitizers: what reads foreign bytes or has threads',
        [build('sanitize'), ctest('sanitize-live', live=True, beside=ctest('sanitize-still'))],
        [*MADE_BY, *PROGRAMS, *TESTS_AND_PYTHON, *OF_RELEASE, *NO_PAGES, *NO_TEXTS],
        {'sanitize': ['all']}),
    'tidy': Part(
        'clang-tidy over every source',
        [Step('tidy', [str(ROOT / 'toolchain/lib/tidy.py')])],
        [*MADE_BY, *PROGRAMS, *TESTS, '*.clang-tidy', *NO_PAGES, *scripts('tidy.py'), *NO_TEXTS]),
    'odr': Part(
        'one definition for each name',
        [build('odr')],
        [*MADE_BY, *PROGRAMS, *NO_PAGES, *scripts(), *NO_TEXTS],
        {'odr': ['one_definition']}),
    'tsan': Part(
        "clang++ with the thread sanitizer: the daemon's threads",
        [build('tsan'), ctest('tsan-live', live=True, beside=ctest('tsan-still'))],
        [*MADE_BY, *CORE, 'tests/firmware', 'tests/hal', 'tests/model', 'tests/places.*', 'tests/patience.hpp',
         'tests/bench/convert.hpp', 'host-sim/scenarios', *scripts(), *NO_TEXTS],
        {'tsan': ['daemon_tests', 'daemon_live_tests', 'hal_tests', 'hal_live_tests', 'smaservod']}),
    'arm64': Part(
        'cross compiled; replays in qemu what the release has simulated',
        [build('release', 'host-sim'), build('arm64', 'host-sim', 'smaservod'), ctest('arm64')],
        [*MADE_BY, *PROGRAMS, 'tests/elsewhere', *scripts('sysroot.sh'), *NO_TEXTS],
        {'release': ['host-sim'], 'arm64': ['host-sim', 'smaservod']}),
    'fuzz': Part(
        'random frames, datagrams and files, with sanitizers',
        [Step('fuzz', dev('fuzz_all', '10'))],
        [*MADE_BY, *PROGRAMS, *TESTS, *NO_PAGES, *scripts('fuzz.sh'), *NO_TEXTS],
        {'sanitize': ['fuzz_targets']}),
}


@cache
def git_files(*patterns):
    """Files of the project that match, tracked or new."""
    found = subprocess.run(
        ['git', 'ls-files', '-z', '--cached', '--others', '--exclude-standard', '--', *patterns],
        cwd=ROOT, check=True, capture_output=True).stdout
    return sorted({name for name in found.decode().split('\0') if name and (ROOT / name).is_file()})


@cache
def digest(name):
    path = ROOT / name
    executable = b'x' if os.access(path, os.X_OK) else b'-'
    return executable + hashlib.sha256(path.read_bytes()).digest()


def listed_packages():
    text = (ROOT / 'toolchain/packages.txt').read_text()
    return [line.split()[0] for line in text.splitlines() if line.split('#')[0].strip() not in ('', 'all:')]


@cache
def tools():
    """Versions of the listed packages and of all that they need, as dpkg knows them; node and npm may be another's."""
    asked = '${Package}\t${Version}\t${Pre-Depends}, ${Depends}\t${Provides}\n'
    installed, providers = {}, {}
    for line in subprocess.run(['dpkg-query', '-W', '-f', asked], capture_output=True, text=True).stdout.splitlines():
        name, version, needs, provides = line.split('\t')
        installed[name] = (version, re.findall(r'[a-z0-9][a-z0-9+.-]+(?=[ ,|:(]|$)', needs))
        for other in re.findall(r'[a-z0-9][a-z0-9+.-]+', provides):
            providers.setdefault(other, []).append(name)
    wanted, seen = listed_packages(), {}
    while wanted:
        name = wanted.pop()
        for real in [name] if name in installed else providers.get(name, []):
            if real not in seen:
                seen[real], needs = installed[real]
                wanted += needs
    for tool in ('node', 'npm'):
        found = subprocess.run(f'{tool} --version', shell=True, capture_output=True, text=True)
        seen[tool] = found.stdout.strip()
    for name in ('CXXFLAGS', 'LDFLAGS', 'SMASERVO_LOAD_S'):
        seen[name] = os.environ.get(name, '')
    return '\n'.join(f'{name} {seen[name]}' for name in sorted(seen))


@cache
def shared():
    """The content of others' measured data, which tests read where they are."""
    folder = Path(os.environ.get('SMASERVO_SHARED') or ROOT / '../shared') / 'data'
    total = hashlib.sha256()
    for path in sorted(folder.rglob('*')) if folder.is_dir() else []:
        if path.is_file():
            total.update(str(path.relative_to(folder)).encode() + path.read_bytes())
    return total.hexdigest()


def key(part):
    total = hashlib.sha256(f'{tools()}\n{shared()}\n'.encode())
    for name in git_files(*part.inputs):
        total.update(name.encode() + digest(name))
    return total.hexdigest()[:32]


def ninja(tree, *words):
    return subprocess.run(['ninja', '-C', str(ROOT / 'build' / tree), *words], check=True, capture_output=True,
                          text=True).stdout.splitlines()


def files_read(tree, targets):
    """Files of the project, but for build/, that these targets were made from: sources and what these include, as
    the compilers have said, and CMake's lists."""
    folder = ROOT / 'build' / tree
    inputs = ninja(tree, '-t', 'inputs', *targets)
    objects = [name for name in inputs if name.endswith('.o')]
    included = [line.strip() for line in ninja(tree, '-t', 'deps', *objects) if line.startswith('    ')]
    read = set()
    for name in {*inputs, *included, *ninja(tree, '-t', 'inputs', 'build.ninja')}:
        path = Path(os.path.normpath(folder / name))
        if path.is_relative_to(ROOT) and not path.is_relative_to(ROOT / 'build') and path.is_file():
            read.add(str(path.relative_to(ROOT)))
    return read


def not_in_inputs(part):
    """Lines "tree: file": what the part's builds have read and its key does not know."""
    known = set(git_files(*part.inputs))
    return sorted(f'{tree}: {name}' for tree, targets in part.built.items()
                  for name in files_read(tree, targets) - known)
