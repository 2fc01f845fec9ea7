#!/usr/bin/python3
"""`toolchain/dev figures`: the pictures and the measured tables of the READMEs, and the command that makes each.

FIGURES is the list. A figure is one of these:

- picture: the command makes the file. From what it was made stands in toolchain/figures.made, by which old_figures.py
  finds those that are older than what they show.
- table: what the command prints is put between the marks of a README, `<!-- NAME: -->` and `<!-- end of NAME -->`.
- written: the command writes the file itself, and a test or a mark of its own guards it.
- copied: the command prints more than the README shows, or less. A person copies it.
"""

from dataclasses import dataclass, field
import difflib
import re
import signal
import subprocess
import sys
import textwrap

from parts import ROOT, dev

MADE = 'toolchain/figures.made'
HOST_SIM = 'build/release/host-sim/host-sim'
NPM = 'tests/npm.sh tests/host-sim/page/node build/page-clients'
FRONT = 'host-sim/page/front/src'
LONGEST_S = 180  # of those that are made when none is named


@dataclass
class Figure:
    kind: str
    shows: str
    files: list
    command: str
    seconds: int
    builds: list = field(default_factory=list)  # targets of the release that the command uses
    alone: bool = False  # measures time: nothing else may run
    named: bool = False  # another machine makes another one, so it is made only where it is named
    tables: dict = field(default_factory=dict)  # by file: its marks, and what makes the table of what is printed
    drawn_by: list = field(default_factory=list)  # of a picture: the style and the drawing of what it shows
    curves: str = ''  # of a picture: a file with the numbers of its curves

    @property
    def usual(self):
        return self.kind != 'copied' and self.seconds <= LONGEST_S and not self.alone and not self.named


def rows_of_traces(printed):
    return '\n'.join(line for line in printed.splitlines() if line.startswith('|')) + '\n'


def how_good(printed):
    """The table of the first README: a line each for one trace or several."""
    found = {row[1]: row[2:4] for row in (re.split(r' *\| *', line) for line in printed.splitlines()) if len(row) > 3}
    lines = {
        'under 150 MPa': ['150MPa'],
        '100 MPa': ['100MPa'],
        '200 MPa': ['200MPa'],
        '400 MPa': ['400MPa'],
        'against a spring, 100 to 250 MPa': ['spring'],
        'under a load that varies': ['varying'],
        'warm, draughty, aged, a load cell that is off': ['disturbed'],
        'from an unknown start': ['unknown-start'],
        '50, 25, 10 MPa': ['50MPa', '25MPa', '10MPa'],
    }
    text = '| | mean | 95 % |\n|---|--:|--:|\n'
    for title, traces in lines.items():
        mean, p95 = (', '.join(found[trace][k] for trace in traces) for k in (0, 1))
        text += f'| {title} | {mean} | {p95} |\n'
    return text


FIGURES = {
    'report': Figure(
        'picture', 'the plot of the strain in the report of a replay', ['host-sim/report.png'],
        f'{HOST_SIM} replay --wire host-sim/traces/units/a.toml --report build/figures/report.html '
        'host-sim/traces/150MPa.csv && '
        f'{NPM} node tests/host-sim/report/picture.js build/figures/report.html host-sim/report.png',
        10, ['host-sim'],
        drawn_by=[*(f'{FRONT}/plot/{name}' for name in ('axes.ts', 'chart.ts', 'legend.ts', 'plot.css', 'theme.ts')),
                  *(f'{FRONT}/report/{name}' for name in (
                      'along_plot.ts', 'colours.ts', 'panel_plot.ts', 'report.css')),
                  'tests/host-sim/report/picture.js'],
        curves='tests/golden/replay_150MPa.csv'),
    'moving': Figure(
        'picture', 'a simulated weight that follows set-points, and its curves', ['host-sim/simulate/moving.svg'],
        f'{HOST_SIM} simulate host-sim/scenarios/steps.toml --out build/figures/steps.csv && '
        'toolchain/lib/moving_picture.py build/figures/steps.csv host-sim/simulate/moving.svg',
        2, ['host-sim'], drawn_by=['toolchain/lib/moving_picture.py', 'host-sim/scenarios/steps.toml']),
    'page': Figure(
        'picture', 'the live view of a simulated servo that moves in loops', ['host-sim/page/picture.png'],
        f'SERVO_BUS=udp:239.74.163.5%lo {NPM} tests/can/own_network.sh node tests/host-sim/page/browser/picture.js '
        f'{HOST_SIM} build/release/firmware/daemon/smaservod . host-sim/page/picture.png',
        40, ['host-sim', 'smaservod'],
        drawn_by=[*(f'{FRONT}/page/{name}' for name in (
                      'style.css', 'header.tsx', 'live/drive_card.tsx', 'live/favourites_card.tsx',
                      'live/live_view.tsx', 'live/panels.ts', 'live/plot_panel.tsx', 'parameters/parameter_row.tsx')),
                  f'{FRONT}/plot/legend.ts', f'{FRONT}/plot/plot.css', 'tests/host-sim/page/browser/picture.js']),
    'traces': Figure(
        'table', "errors on the project's traces", ['observer/README.md', 'README.md'],
        f'mkdir -p build/replay && toolchain/dev do replay_all {HOST_SIM} build/replay', 5, ['host-sim'],
        tables={'observer/README.md': ('traces', rows_of_traces), 'README.md': ('traces', how_good)}),
    'bench': Figure(
        'table', 'times and instructions of each step', ['tests/bench/README.md'], 'toolchain/dev bench tables', 180,
        alone=True, tables={'tests/bench/README.md': ('bench', lambda printed: printed.rstrip() + '\n')}),
    'examples': Figure(
        'written', 'what the examples print', ['host-sim/examples/README.md'],
        "ctest --test-dir build/release -R '^(Library[.]Install|Examples[.]Build)$' && "
        'for source in host-sim/examples/*.cpp; do program=${source##*/}; '
        'tests/library/examples.sh build/release/library-examples/examples/${program%.cpp} '
        f'{HOST_SIM} --write || exit; done',
        60, ['host-sim', 'smaservo_library', 'smaservo-table']),
    'notebooks': Figure(
        'written', 'what the notebooks print and draw',
        [f'host-sim/python/notebooks/{name}.ipynb' for name in
         ('1_estimate_my_recording', '2_calibrate', '3_design_a_controller')],
        'PYTHONPATH=build/release/host-sim/python /usr/bin/python3 tests/python/notebooks.py', 45,
        ['smaservo_python']),
    'reference': Figure(
        'written', 'parameters, faults and objects of the device',
        [f'firmware/reference/{name}' for name in
         ('PARAMETERS.md', 'FAULTS.md', 'OBJECTS.md', 'smaservo.eds', 'smaservo.dbc')],
        'cd firmware/reference && for page in parameters:PARAMETERS.md faults:FAULTS.md objects:OBJECTS.md '
        'eds:smaservo.eds dbc:smaservo.dbc; do '
        f'../../{HOST_SIM} describe ${{page%:*}} >${{page#*:}}; done',
        1, ['host-sim']),
    'gru': Figure(
        'written', "compare's recurrent network, trained on four of the project's traces",
        ['host-sim/papers/gru/traces.json', 'tests/golden/gru_strains.csv'],
        'export PYTHONPATH=build/release/host-sim/python && traces=host-sim/traces && '
        '/usr/bin/python3 host-sim/papers/gru/train.py --set wire.length_mm=100.6 '
        '--out host-sim/papers/gru/traces.json '
        '$traces/10MPa.csv $traces/50MPa.csv $traces/150MPa.csv $traces/400MPa.csv && '
        "SMASERVO_REWRITE_GOLDEN=1 ctest --test-dir build/release -R '^Python[.]Gru$'",
        80, ['host-sim', 'smaservo_python'], named=True),
    'random': Figure(
        'written', 'temperature in 10 000 random scenarios', ['firmware/README.md'],
        f'{HOST_SIM} evaluate --closed-loop --units 1 --wires tests/golden/evaluate --random 10000 '
        '--random-from 9000000 --markdown firmware/README.md', 720, ['host-sim']),
    'evaluate': Figure(
        'written', 'errors of the observers on random wires', ['observer/README.md'],
        f'{HOST_SIM} evaluate --markdown observer/README.md', 7200, ['host-sim']),
    'families': Figure(
        'written', 'the same on families that nothing was chosen with', ['observer/README.md'],
        f'{HOST_SIM} evaluate --family free-energy,smooth-hardening '
        '--row standard,disturbed,light,uncalibrated,unknown-start,hold,gust,coarse '
        '--markdown observer/README.md', 7200, ['host-sim']),
    'closed-loop': Figure(
        'written', 'how well the device holds a strain', ['firmware/README.md'],
        f'{HOST_SIM} evaluate --closed-loop --random 0 --markdown firmware/README.md', 7200, ['host-sim']),
    'bench-mcu': Figure(
        'copied', 'instructions and bytes on Cortex-M', ['hal/cortex-m/README.md'], 'toolchain/dev bench-mcu', 600),
    'bench-identify': Figure(
        'copied', 'how long an identification takes', ['host-sim/identify/README.md'],
        'toolchain/dev bench identify', 600, alone=True),
    'operations': Figure(
        'copied', 'ranges and operations of the scalars', ['model/scalar/FIXED.md'],
        'build/release/tests/bench/operations', 60, ['operations']),
    'plan': Figure(
        'copied', 'parameters that planned runs determine', ['host-sim/plan/README.md'],
        'for wire in smartflex-76um flexinol-lt-0.15mm; do '
        f'{HOST_SIM} calibrate-plan $wire --out build/figures/plan.csv; done', 30, ['host-sim']),
    'identify': Figure(
        'copied', "the project's traces with an identified wire", ['host-sim/identify/README.md'],
        f'cd host-sim/traces && ../../{HOST_SIM} identify --set wire.length_mm=100.6 --out ../../build/figures/a.toml '
        '10MPa.csv 50MPa.csv 150MPa.csv 400MPa.csv && for trace in 150MPa spring disturbed; do '
        f'../../{HOST_SIM} replay --wire ../../build/figures/a.toml $trace.csv; done', 120, ['host-sim']),
    'preisach': Figure(
        'copied', "the papers' figures, among them errors of Preisach", ['model/README.md'],
        f'{HOST_SIM} figures --paper 003 --out build/figures/papers', 30, ['host-sim']),
    'long-report': Figure(
        'copied', 'size and time of a report of 6 million rows', ['host-sim/report/README.md'],
        'tests/bench/long_report.sh build/release', 60, ['host-sim'], alone=True),
    'bridge': Figure(
        'copied', "what the page's server costs", ['host-sim/page/README.md'],
        f'{NPM} node tests/host-sim/page/measure.js build/release/tests/host-sim/page/test_bridge', 120,
        ['test_bridge'], alone=True),
    'front': Figure(
        'copied', 'what the page costs a browser', ['host-sim/page/front/README.md'],
        f'toolchain/dev do page_is_built build/page && {NPM} node tests/host-sim/page/measure_front.js '
        'build/page/page.html 300 600', 400, alone=True),
    'test-times': Figure(
        'copied', 'how long the test takes', ['toolchain/README.md'], 'toolchain/dev test all --fresh', 2500,
        alone=True),
}


def text_of(file):
    return (ROOT / file).read_text()


def between(text, marks, file):
    """What stands before a table, the table, and what stands behind it."""
    found = re.fullmatch(rf'(.*\n<!-- {marks}:[^\n]*-->\n\n)(.*?)(\n<!-- end of {marks} -->\n.*)', text, re.DOTALL)
    if found is None:
        raise LookupError(f'{file}: needs a line "<!-- {marks}: ... -->", an empty one, and "<!-- end of {marks} -->"')
    return found.groups()


def hash_of(file):
    """As git names this content."""
    return subprocess.run(['git', 'hash-object', file], cwd=ROOT, check=True, capture_output=True,
                          text=True).stdout.strip()


def recorded():
    """By figure: from which content of which files it was made, and what it was then."""
    found = {}
    for line in text_of(MADE).splitlines():
        if line and not line.startswith('#'):
            name, file, content = line.split()
            found.setdefault(name, {})[file] = content
    return found


def record(name):
    figure, found = FIGURES[name], recorded()
    files = [*figure.files, *figure.drawn_by, *([figure.curves] if figure.curves else [])]
    found[name] = {file: hash_of(file) for file in files}
    head = [line for line in text_of(MADE).splitlines() if line.startswith('#')]
    lines = [f'{one} {file} {content}' for one in sorted(found) for file, content in found[one].items()]
    (ROOT / MADE).write_text('\n'.join([*head, *lines]) + '\n')


def fewer_colours(file):
    """A picture of a screen has few colours: with a palette it takes a third of the bytes, and no pixel differs by more
    than 10 of 255."""
    from PIL import Image
    with Image.open(ROOT / file) as picture:
        small = picture.convert('RGB').quantize(256, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    small.save(ROOT / file, optimize=True)


def printed_by(figure):
    done = subprocess.run(['bash', '-euo', 'pipefail', '-c', figure.command], cwd=ROOT, text=True,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE if figure.tables else None)
    return done.returncode, done.stdout


def tables(figure, printed):
    """By file: its text with what is printed now."""
    texts = {}
    for file, (marks, table) in figure.tables.items():
        before, _, behind = between(text_of(file), marks, file)
        texts[file] = before + table(printed) + behind
    return texts


def make(name):
    """Whether it worked."""
    figure = FIGURES[name]
    say(f'{name}: {figure.shows}')
    (ROOT / 'build/figures').mkdir(parents=True, exist_ok=True)
    # The pages are a part of host-sim.
    if figure.builds and subprocess.run(dev('build', 'release', *figure.builds)).returncode:
        return False
    code, printed = printed_by(figure)
    if code:
        say(f'{name}: its command has failed ({code})')
        return False
    for file, text in tables(figure, printed).items():
        (ROOT / file).write_text(text)
    if figure.kind == 'picture':
        if figure.files[0].endswith('.png'):
            fewer_colours(figure.files[0])
        record(name)
    if figure.kind == 'copied':
        say(f'{name}: what of this {", ".join(figure.files)} shows has to be copied')
    return True


def say(words):
    print(words, file=sys.stderr, flush=True)


def how_long(seconds):
    for unit, length in (('h', 3600), ('min', 60)):
        if seconds >= length:
            return f'{seconds / length:.0f} {unit}'
    return f'{seconds} s'


def show_list():
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # where only the beginning is read, as by head
    for name, figure in FIGURES.items():
        notes = [how_long(figure.seconds), *(['nothing else may run'] if figure.alone else []),
                 *([] if figure.usual else ['only if named']), *(['copied by hand'] if figure.kind == 'copied' else [])]
        print(f'{name}: {figure.shows} ({", ".join(notes)})')
        print(textwrap.fill(' '.join(figure.files), 76, initial_indent='  ', subsequent_indent='  ',
                            break_on_hyphens=False))
        words = textwrap.wrap(figure.command, 72, break_long_words=False, break_on_hyphens=False)
        print('    ' + ' \\\n      '.join(words) + '\n')


def numbers_apart(text):
    return re.sub(r'\d+(\.\d+)?', '#', text), [float(number[0]) for number in re.finditer(r'\d+(\.\d+)?', text)]


def compare(name):
    """Whether the tables show what the command prints now, but for the last digit, which a compiler may decide. Nothing
    is built."""
    figure = FIGURES[name]
    code, printed = printed_by(figure)
    if code:
        return False
    same = True
    for file, text in tables(figure, printed).items():
        marks = figure.tables[file][0]
        was, now = between(text_of(file), marks, file)[1], between(text, marks, file)[1]
        (words_were, were), (words_are, are) = numbers_apart(was), numbers_apart(now)
        if words_were != words_are or any(abs(a - b) > 0.0101 for a, b in zip(were, are)):
            same = False
            print('\n'.join(difflib.unified_diff(was.splitlines(), now.splitlines(), file, 'now', lineterm='')))
    if not same:
        print(f'once that is reviewed: toolchain/dev figures {name}')
    return same


def main(words):
    if words == ['--list']:
        show_list()
        return 0
    if words[:1] == ['--compare']:
        return 0 if all([compare(name) for name in words[1:]]) else 1
    unknown = [name for name in words if name not in FIGURES]
    if unknown:
        sys.exit(f'figures: unknown: {", ".join(unknown)} (one of {", ".join(FIGURES)}, or --list)')
    names = words or [name for name, figure in FIGURES.items() if figure.usual]
    failed = [name for name in names if not make(name)]
    if failed:
        say(f'figures failed: {", ".join(failed)}')
    return 1 if failed else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
