#!/usr/bin/env python3
"""fmu_files.py HOST_SIM SOURCES COMPILER...: what `host-sim export-fmu` writes, as a simulator sees it that knows
nothing of this project: the archive, the model description by rules of the standard, the library through a driver in
C, and the library that each compiler makes of the sources inside, which gives the same digits."""

import math
import platform
import random
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree
import zipfile
from pathlib import Path

host_sim, sources = (Path(argument).resolve() for argument in sys.argv[1:3])
compilers = sys.argv[3:]

# Of FMI 2.0, section 2.2.7, and FMI 3.0, section 2.4.7.4: which variability a causality may have, and by both what
# `initial` may be; None is a variable that must not say it. A start value stands exactly where initial is "exact",
# and at inputs.
ALLOWED = {
    ('parameter', 'fixed'): {'exact'},
    ('parameter', 'tunable'): {'exact'},
    ('input', 'discrete'): {None},
    ('input', 'continuous'): {None},
    ('output', 'constant'): {'exact'},
    ('output', 'discrete'): {'calculated', 'exact', 'approx'},
    ('output', 'continuous'): {'calculated', 'exact', 'approx'},
    ('independent', 'continuous'): {None},
}
TYPES = {'Real': 'real', 'Float64': 'real', 'Integer': 'whole', 'Int32': 'whole', 'Enumeration': 'choice',
         'Boolean': 'flag'}
X86 = platform.machine() == 'x86_64'
PLATFORM = {'2': 'linux64' if X86 else 'aarch64-linux', '3': 'x86_64-linux' if X86 else 'aarch64-linux'}
failures = []


def expect(condition, *what):
    if not condition:
        failures.append(' '.join(str(part) for part in what))


class Variable:
    """What both versions say of a variable."""

    def __init__(self, element):
        value = element[0] if element.tag == 'ScalarVariable' else element
        self.name = element.get('name')
        self.reference = int(element.get('valueReference'))
        self.causality = element.get('causality')
        self.variability = element.get('variability')
        self.initial = element.get('initial')
        self.type = TYPES[value.tag]
        self.attributes = value.attrib
        start = value.get('start')
        self.start = None if start is None else {'true': 1.0, 'false': 0.0}.get(start)
        if start is not None and self.start is None:
            self.start = float(start)


def check_description(root, version, where):
    two = version == '2'
    expect(root.get('fmiVersion') == version + '.0', where, 'version')
    expect(re.fullmatch(r'[A-Za-z_]\w*', root.find('CoSimulation').get('modelIdentifier')), where, 'identifier')
    for flag in ('canHandleVariableCommunicationStepSize', 'canSerializeFMUstate', 'canGetAndSetFMUstate'):
        name = flag if two else flag.replace('FMUstate', 'FMUState')
        expect(root.find('CoSimulation').get(name) == 'true', where, name)
    units = {unit.get('name'): unit for unit in root.find('UnitDefinitions')}
    expect(len(units) == len(root.find('UnitDefinitions')), where, 'units are unique')
    variables = [Variable(element) for element in root.find('ModelVariables')]
    names = [variable.name for variable in variables]
    expect(len(set(names)) == len(names), where, 'names are unique')
    expect([variable.reference for variable in variables] == list(range(len(variables))), where, 'references')
    types = {}
    for element in root.find('TypeDefinitions'):
        items = element[0] if two else element
        types[element.get('name')] = [int(item.get('value')) for item in items]
        expect(len({item.get('name') for item in items}) == len(items), where, 'items of', element.get('name'))
    expect(len(types) == len(root.find('TypeDefinitions')), where, 'types are unique')
    expect(not set(types) & set(names), where, 'types are called unlike variables')
    used = set()
    for variable in variables:
        what = (where, variable.name)
        expect(re.fullmatch(r'[A-Za-z_]\w*(\.[A-Za-z_]\w*)*', variable.name), *what, 'structured name')
        allowed = ALLOWED.get((variable.causality, variable.variability), set())
        expect(variable.initial in allowed, *what, 'initial', variable.initial)
        has_start = variable.causality == 'input' or variable.initial in ('exact', 'approx')
        expect((variable.start is not None) == has_start, *what, 'start')
        if variable.type != 'real':
            expect(variable.variability != 'continuous', *what, 'only reals are continuous')
            expect('unit' not in variable.attributes, *what, 'unit')
        else:
            unit = units.get(variable.attributes.get('unit'))
            used.add(variable.attributes.get('unit'))
            expect(unit is not None, *what, 'unit')
            display = variable.attributes.get('displayUnit')
            expect(display is None or display in [u.get('name') for u in unit.findall('DisplayUnit')], *what, display)
        if variable.type == 'choice':
            values = types.get(variable.attributes.get('declaredType'), [])
            expect(values and (variable.start is None or variable.start in values), *what, 'declaredType')
        low = float(variable.attributes.get('min', '-inf'))
        high = float(variable.attributes.get('max', 'inf'))
        expect(low <= high and (variable.start is None or low <= variable.start <= high), *what, 'range')
        if variable.type == 'whole':
            expect(abs(high) == math.inf or abs(high) < 2**31, *what, '32 bits')
    expect(used == set(units), where, 'units that are not used:', set(units) - used)
    expect([v.name for v in variables if v.causality == 'independent'] == ['time'], where, 'time')
    outputs = [i for i, variable in enumerate(variables) if variable.causality == 'output']
    structure = root.find('ModelStructure')
    if two:
        listed = [int(unknown.get('index')) - 1 for unknown in structure.find('Outputs')]
        initial = [int(unknown.get('index')) - 1 for unknown in structure.find('InitialUnknowns')]
    else:
        listed = [int(unknown.get('valueReference')) for unknown in structure.findall('Output')]
        initial = [int(unknown.get('valueReference')) for unknown in structure.findall('InitialUnknown')]
    expect(listed == outputs and initial == outputs, where, 'outputs')
    return variables


def course(variables, kind):
    """Lines for the driver: a random course with all outputs now and then, a state saved and restored."""
    random.seed(3)
    by_name = {variable.name: variable for variable in variables}
    reads = [f'get {v.type} {v.reference}' for v in variables if v.causality == 'output']

    def setting(name, value):
        return f'set {by_name[name].type} {by_name[name].reference} {value!r}'

    lines = [setting('wire.length_m', 0.125), 'enter 0.5', *reads, 'exit']
    for i in range(250):
        lines.append(setting('load_N', random.uniform(0.3, 0.6)))
        if kind == 'wire':
            lines.append(setting('current_A', random.uniform(0, 0.2)))
        elif i % 50 == 0:
            lines += [setting('mode', 5), setting('setpoint', random.uniform(0.01, 0.038))]
        if i == 100:
            lines.append('save')
        lines.append(f'step {random.uniform(1e-4, 2e-2)!r}')
        if i % 25 == 24:
            lines += reads
    return [*lines, 'restore', *reads, 'step 0.01', *reads, 'end']


def run_driver(driver, library, version, root, folder, lines):
    resources = (folder / 'resources').as_uri() if version == '2' else str(folder / 'resources')
    token = root.get('guid' if version == '2' else 'instantiationToken')
    done = subprocess.run([driver, library, version, token, resources], input='\n'.join(lines) + '\n',
                          capture_output=True, text=True)
    expect(done.returncode == 0, library, done.stderr)
    return done.stdout


def compiled(compiler, files, folder, library, *options):
    """The library that a compiler makes with nothing but what the FMU says."""
    done = subprocess.run(
        [compiler, '-std=c++20', *options, '-ffp-contract=off', '-fPIC', '-shared', '-Wall', '-I', folder,
         *(folder / file for file in files), '-o', library], capture_output=True, text=True)
    expect(done.returncode == 0 and not done.stderr, compiler, done.stderr)


def check_fmu(kind, version, folder, driver):
    where = kind + version
    archive = folder / 'a.fmu'
    done = subprocess.run([host_sim, 'export-fmu', '--wire', 'smartflex-76um', '--kind', kind, '--fmi', version,
                           '--out', archive], capture_output=True, text=True)
    expect(done.returncode == 0, done.stderr)
    with zipfile.ZipFile(archive) as zipped:
        expect(zipped.testzip() is None, where, 'archive')
        zipped.extractall(folder)
    root = xml.etree.ElementTree.parse(folder / 'modelDescription.xml').getroot()
    variables = check_description(root, version, where)
    identifier = root.find('CoSimulation').get('modelIdentifier')
    library = folder / 'binaries' / PLATFORM[version] / (identifier + '.so')
    reads = ['enter 0', *(f'get {v.type} {v.reference}' for v in variables), 'exit', 'end']
    values = run_driver(driver, library, version, root, folder, reads).split()
    expect(len(values) == len(variables), where, 'every reference can be read')
    for variable, value in zip(variables, values):
        if variable.start is not None:
            expect(float(value) == variable.start, where, variable.name, value, variable.start)
        expect(math.isfinite(float(value)), where, variable.name, value)
    lines = course(variables, kind)
    said = run_driver(driver, library, version, root, folder, lines)
    expect(len(set(said.split())) > 50, where, 'the course moves')
    # The functions of the standard, and nothing else.
    shown = subprocess.run(['nm', '-D', '--defined-only', library], check=True, capture_output=True, text=True).stdout
    listed = (sources / 'tests/host-sim/fmu/functions.txt').read_text().splitlines()
    differing = {line.split()[2] for line in shown.splitlines()} ^ {name for name in listed if name[0] != '#'}
    expect(not differing, where, 'only the library or only the standard has', differing)
    # Its sources.
    if version == '2':
        files = [file.get('name') for file in root.find('CoSimulation/SourceFiles')]
    else:
        build = xml.etree.ElementTree.parse(folder / 'sources/buildDescription.xml').getroot()
        files = [file.get('name') for file in build.iter('SourceFile')]
    for i, compiler in enumerate(compilers):
        # A servo takes half a minute with each; so each version takes one of them.
        if kind == 'wire' or str(i % 2 + 2) == version or len(compilers) == 1 and version == '2':
            built = folder / f'built{i}.so'
            compiled(compiler, files, folder / 'sources', built, '-O0' if kind == 'servo' else '-O2')
            again = run_driver(driver, built, version, root, folder, lines)
            same_bits = compiler == compilers[0]
            pairs = list(zip(said.split(), again.split()))
            worst = max(abs(float(a) - float(b)) / max(abs(float(a)), 1e-3) for a, b in pairs)
            expect(len(again.split()) == len(said.split()) and (again == said if same_bits else worst < 1e-6),
                   where, compiler, 'gives other values, by up to', worst)
            print(f'{where}: {len(pairs)} values of the library that {compiler} makes: '
                  f'{"the same digits" if again == said else f"equal to {worst:.1g}"}')
    if kind == 'wire' and version == '3':
        subprocess.run(['cmake', '-S', folder / 'sources', '-B', folder / 'build',
                        f'-DCMAKE_CXX_COMPILER={compilers[0]}'], check=True, capture_output=True)
        subprocess.run(['cmake', '--build', folder / 'build'], check=True, capture_output=True)
        again = run_driver(driver, folder / 'build' / (identifier + '.so'), version, root, folder, lines)
        expect(again == said, where, 'what CMake builds gives other values')


with tempfile.TemporaryDirectory() as scratch:
    # An escape in the URI of the resources.
    scratch = Path(scratch) / 'a folder, 100 %'
    scratch.mkdir()
    driver = scratch / 'driver'
    subprocess.run([compilers[0], '-x', 'c', '-std=c11', '-Wall', '-Wextra', '-Wpedantic', '-Werror', '-I', sources,
                    sources / 'tests/host-sim/fmu/driver.c', '-o', driver, '-ldl'], check=True)
    for kind in ('wire', 'servo'):
        for version in '23':
            folder = scratch / (kind + version)
            folder.mkdir()
            check_fmu(kind, version, folder, driver)
print('\n'.join(failures))
sys.exit(1 if failures else 0)
