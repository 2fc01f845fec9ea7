#!/usr/bin/env python3
"""`toolchain/dev test`: runs parts (parts.py), two rows of them side by side, and says how each went.

A part is a list of steps, a command each; a row is a list of parts; the two rows run at the same time. At most one step
is at normal priority: a step of tests in real time, which waits until it can be that one, or else the first row's. All
others are at idle priority: they get what that one leaves of the processors. A step that finds normal priority taken
stays at idle priority to its end.
"""

import datetime
import os
from pathlib import Path
import signal
import subprocess
import sys
import textwrap
import threading
import time
import xml.etree.ElementTree as xml

from parts import KEPT, PARTS, ROOT, Part, Step, build, ctest, dev, key, not_in_inputs

LOGS = ROOT / 'build/logs'
ROWS = [['board', 'can', 'mcu', 'package'], ['texts', 'sanitize', 'tidy', 'odr', 'tsan', 'arm64', 'fuzz']]

PARTS['quick'] = Part(
    'for before each commit',
    [build('release'), ctest('quick'), Step('syntax', [str(ROOT / 'toolchain/lib/tidy.py'), '--syntax']),
     Step('texts', dev('check_all_texts'))])
PARTS['dev'] = Part('each source by itself, with assertions and debug symbols', [build('dev'), ctest('dev')])


def say(words):
    screen.clear()
    print(words, flush=True)


def seconds(value):
    return f'{int(value) // 60}:{int(value) % 60:02d}'


def idle():
    """Linux divides processors between sessions first (sched_autogroup), and only within one by priority. A browser of a
    live test has its own session, too, and is to get all that it wants."""
    os.setsid()
    try:
        Path('/proc/self/autogroup').write_text('19')
    except OSError:
        pass  # the kernel has none
    os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))


def end_of(log):
    """Where a log says why: from the first error on, and its last lines."""
    lines = log.read_text(errors='replace').splitlines()
    marks = ('error: ', 'CMake Error', 'FAILED', '***')
    first = next((k for k, line in enumerate(lines) if any(mark in line for mark in marks)), len(lines))
    if len(lines) - first > 60:
        lines = [*lines[first:first + 40], '[...]', *lines[-15:]]
    else:
        lines = lines[-60:]
    return '\n'.join(lines)


def progress(log):
    """How far a step is: the last "[3/17]" of ninja or "3/17 Test" of ctest in its log."""
    try:
        with log.open('rb') as file:
            file.seek(max(0, log.stat().st_size - 4000))
            lines = file.read().decode(errors='replace').splitlines()
    except OSError:
        return ''
    for line in reversed(lines):
        word = line.strip().split(' ')[0].strip('[]')
        if word.count('/') == 1 and word.replace('/', '').isdigit():
            return ' ' + word
    return ''


def counts(report):
    """Of JUnit's report: tests that ran, and names of those that were skipped. One entry of ctest may be many of
    GoogleTest's."""
    ran, skipped = 0, []
    for case in xml.parse(report).getroot().iter('testcase'):
        output = case.findtext('system-out') or ''
        inner = output.count('[       OK ]') if '.' in case.get('name') and 'GTEST_SHARD' in output else 0
        if case.get('status') in ('notrun', 'disabled') or case.find('skipped') is not None:
            skipped.append(case.get('name'))
        else:
            ran += inner or 1
    return ran, skipped


class Normal:
    """Normal priority, which one step has at a time. Tests in real time wait for it, and come before other steps."""

    def __init__(self):
        self.free, self.taken, self.waiting = threading.Condition(), False, 0

    def take(self, step):
        """Whether this step has it."""
        with self.free:
            if step.live:
                self.waiting += 1
                self.free.wait_for(lambda: not self.taken)
                self.waiting -= 1
            elif self.taken or self.waiting:
                return False
            self.taken = True
            return True

    def give_back(self):
        with self.free:
            self.taken = False
            self.free.notify()


class Run:
    """A part as it runs, and its result."""

    def __init__(self, name, fresh):
        self.name, self.part = name, PARTS[name]
        self.result, self.clock_s, self.processor_s, self.said = '', 0.0, 0.0, ''
        self.steps = []  # name, seconds of processors and of the clock
        self.tests, self.skipped = 0, []
        self.active = {}
        self.fresh = fresh
        self.record = None

    def usual_s(self):
        try:
            return float((KEPT / 'took' / self.name).read_text())
        except (OSError, ValueError):
            return 0

    def is_good(self):
        return self.result in ('passed', 'before')

    def run(self, is_idle):
        try:
            self.all_steps(is_idle)
        except (OSError, subprocess.SubprocessError) as error:  # a full disk, ninja
            self.result = 'FAILED'
            say(f'{self.name}: FAILED: {error}')

    def all_steps(self, is_idle):
        self.began = time.monotonic()
        # Of the files as they are now: who changes one meanwhile has not tested it.
        self.record = KEPT / 'passed' / f'{self.name}-{key(self.part)}' if self.part.inputs else None
        if self.record and not self.fresh and self.record.is_file():
            self.result, self.said = 'before', self.record.read_text().strip()
            say(f'{self.name}: passed before, {self.said}')
            return
        usual = self.usual_s()
        say(f'{self.name}: begins' + (f', it took {seconds(usual)} before' if usual else ''))
        ok = all(self.step(step, is_idle) for step in self.part.steps) and self.knows_inputs()
        self.clock_s = time.monotonic() - self.began
        self.result = 'passed' if ok else 'FAILED'
        if self.tests:
            self.said = f'{self.tests} tests' + (f', {len(self.skipped)} skipped' if self.skipped else '')
        say(f'{self.name}: {self.result}, {seconds(self.clock_s)}')
        if ok:
            self.keep()

    def keep(self):
        for folder in ('passed', 'took'):
            (KEPT / folder).mkdir(parents=True, exist_ok=True)
        (KEPT / 'took' / self.name).write_text(f'{self.clock_s:.0f}\n')
        if self.record:
            when = datetime.datetime.now().strftime('%Y-%m-%d %H:%M')
            self.record.write_text(f'{when}, in {seconds(self.clock_s)}\n')

    def step(self, step, is_idle):
        beside, passed = None, []
        if step.beside:
            beside = threading.Thread(target=lambda: passed.append(self.step(step.beside, True)))
            beside.start()
        is_normal = (step.live or not is_idle) and normal.take(step)
        try:
            ok = self.one(step, not is_normal)
        finally:
            if is_normal:
                normal.give_back()
            if beside:
                beside.join()
        return ok and (not beside or passed == [True])

    def one(self, step, is_idle):
        log, began = LOGS / f'{step.name}.log', time.monotonic()
        self.active[step.name] = log
        with log.open('w') as file:
            child = subprocess.Popen(step.command, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=file,
                                     stderr=subprocess.STDOUT, preexec_fn=idle if is_idle else os.setsid)
            sessions.add(child.pid)
            _, status, usage = os.wait4(child.pid, 0)
            sessions.discard(child.pid)
            child.returncode = code = os.waitstatus_to_exitcode(status)
        del self.active[step.name]
        used = usage.ru_utime + usage.ru_stime
        self.processor_s += used
        self.steps.append((step.name, used, time.monotonic() - began))
        report = LOGS / f"{step.name.removesuffix('-test')}.xml"
        if step.name.endswith('-test') and report.is_file() and code == 0:
            ran, skipped = counts(report)
            self.tests += ran
            self.skipped += skipped
        if code != 0:
            say(f'{self.name}: {step.name} failed. From {log.relative_to(ROOT)}:\n{end_of(log)}\n---')
        return code == 0

    def knows_inputs(self):
        missing = not_in_inputs(self.part)
        if missing:
            say(f'{self.name}: its builds have read what is not among its inputs in toolchain/lib/parts.py:\n  '
                + '\n  '.join(missing[:20]))
        return not missing

    def now(self):
        steps = ', '.join(f'{name}{progress(log)}' for name, log in list(self.active.items()))
        usual = self.usual_s()
        of = f' of {seconds(usual)}' if usual else ''
        return f'{self.name} {seconds(time.monotonic() - self.began)}{of}: {steps}'


class Screen:
    """One line that moves, on a terminal."""

    def __init__(self):
        self.runs, self.shown, self.lock = [], False, threading.Lock()
        self.moves = sys.stdout.isatty()

    def clear(self):
        with self.lock:
            if self.shown:
                print('\r\033[K', end='')
                self.shown = False

    def draw(self):
        with self.lock:
            line = ' | '.join(run.now() for run in self.runs if run.active)
            width = os.get_terminal_size().columns if self.moves else 80
            if line:
                print('\r\033[K' + line[:width - 1], end='', flush=True)
                self.shown = True

    def keep_moving(self):
        while self.moves:
            self.draw()
            time.sleep(1)


screen = Screen()
normal = Normal()
sessions = set()  # of the steps that run, each its own, which no Ctrl-C reaches


def end(signal_number, _frame):
    for stat in Path('/proc').glob('[0-9]*/stat'):
        try:
            session = stat.read_text().rpartition(')')[2].split()[3]
            if int(session) in sessions:
                os.kill(int(stat.parent.name), signal.SIGTERM)
        except OSError:
            pass  # it has ended
    os._exit(128 + signal_number)


def run_row(runs, is_idle):
    for run in runs:
        screen.runs.append(run)
        run.run(is_idle)


def summary(runs):
    steps = sorted((step for run in runs for step in run.steps), key=lambda step: -step[1])[:10]
    print('\nThe most expensive steps, in seconds of processors and of the clock:')
    for name, used, clock in steps:
        print(f'{used:6.0f} {clock:6.0f}  {name}')
    print('\npart       result   clock  processors')
    for run in runs:
        figures = '' if run.result == 'before' else f'{seconds(run.clock_s):>6} {run.processor_s:8.0f} s'
        print(f'{run.name:10} {run.result:7} {figures:17}  {run.said}')
        for name in run.skipped:
            print(f'           skipped: {name}')


def test(rows, fresh, first=()):
    """What `first` fetches is there before anything else begins; without it nothing else does."""
    LOGS.mkdir(parents=True, exist_ok=True)
    threading.Thread(target=screen.keep_moving, daemon=True).start()
    fetched = [Run(name, fresh) for name in first]
    run_row(fetched, False)
    if not all(run.is_good() for run in fetched):
        rows = []
    runs = [[Run(name, fresh) for name in row] for row in rows]
    threads = [threading.Thread(target=run_row, args=(row, k > 0)) for k, row in enumerate(runs)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    screen.clear()
    everything = fetched + [run for row in runs for run in row]
    summary(everything)
    if not all(run.is_good() for run in everything):
        print(f"Logs are in {os.path.relpath(LOGS, os.environ.get('here', '.'))}.")
        return 1
    return 0


def steady(times):
    """Tests without time as often, beside eight loops that do nothing; then those in real time, alone."""
    LOGS.mkdir(parents=True, exist_ok=True)
    loops = []
    failed = []
    PARTS['steady'] = Part('', [build('release')])
    built = Run('steady', True)
    built.run(False)
    if built.result == 'FAILED':
        return 1
    for preset in ('still', 'live'):
        if preset == 'still':
            loops = [subprocess.Popen([sys.executable, '-c', 'while True: pass']) for _ in range(8)]
        began = time.monotonic()
        code = subprocess.run(['ctest', '--preset', preset, '--repeat', f'until-fail:{times}',
                               *(['--parallel', '8'] if loops else [])],
                              cwd=ROOT, stdin=subprocess.DEVNULL, stdout=(LOGS / f'steady-{preset}.log').open('w'),
                              stderr=subprocess.STDOUT).returncode
        for loop in loops:
            loop.kill()
        loops = []
        say(f'{preset}, {times} times: {"FAILED" if code else "passed"}, {seconds(time.monotonic() - began)}')
        if code:
            failed.append(preset)
            print(end_of(LOGS / f'steady-{preset}.log'))
    return 1 if failed else 0


def main(words):
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    fresh = '--fresh' in words
    words = [word for word in words if word != '--fresh']
    what = words[0] if words else ''
    if what == '--parts':
        for name, part in PARTS.items():
            if name not in ('downloads', 'fetch', 'quick', 'dev'):
                print(textwrap.fill(f'  {name:11} {part.what}', 80, subsequent_indent=' ' * 14))
        return 0
    if what == 'steady' and len(words) <= 2:
        times = words[1] if len(words) == 2 else '3'
        if not times.isdigit() or int(times) < 1:
            sys.exit(f'toolchain/dev: test steady: how often must be a whole number above 0: {times}')
        return steady(int(times))
    if len(words) > 1:
        sys.exit(f'toolchain/dev: test: one part at a time, not {" ".join(words)}')
    if not what:
        return test([['release'], ['texts']], fresh, ['downloads'])
    if what == 'all':
        return test([['release', *ROWS[0]], ROWS[1]], fresh, ['downloads', 'fetch'])
    if what in PARTS:
        return test([[what]], True)
    sys.exit(f'toolchain/dev: test: unknown part: {what} (all, steady, {", ".join(PARTS)})')


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
