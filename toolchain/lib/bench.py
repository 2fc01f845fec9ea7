#!/usr/bin/env python3
"""Measures the speed of a release that is built, and prints it as Markdown: `toolchain/dev bench [tables | identify]`.

Times come from Google Benchmark, instructions from callgrind. What they print is in build/bench.
"""

from concurrent.futures import ThreadPoolExecutor
import json
import os
from pathlib import Path
import re
import subprocess
import sys

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = ROOT / 'build/release/tests/bench'
OUT = ROOT / 'build/bench'
CALLGRIND = ['valgrind', '--tool=callgrind']

# What the table calls a kind of step, and the most instructions that it may take.
STEPS = {
    'ihyp_inverse': ('ihyp inverse', None),
    'ihyp_inverse_cardano': ("ihyp inverse by Cardano's formula", None),
    'ihyp_inverse_newton': ("ihyp inverse by Newton's method", None),
    'cosine_step': ('two-phase cosine step, 20..110 °C', None),
    'cosine_step_converting': ('two-phase cosine step, only while it converts', None),
    'model_step_cut': ('model step, constant stress', 250),
    'model_step_cut:heating': ('- its heating half', None),
    'model_step_cut:cooling': ('- its cooling half', None),
    'model_step_constant_stress': ('model step, constant stress, surfaces not cut before', None),
    'model_step_varying_stress': ('model step, varying stress', None),
    'duhem_step': ('Duhem step (001)', None),
    'liang_rogers_step': ('Liang-Rogers step (002)', None),
    'preisach_step': ('Preisach step (003), constant stress', None),
    'preisach_step_varying_stress': ('Preisach step (003), varying stress', None),
    'plant_step': ('plant step (model and heat balance)', None),
    'wire_step_ihyp': ('simulated wire, ihyp: 1 ms, strain and resistance', None),
    'wire_step_sublayers': ('simulated wire, sublayers: the same', None),
    'wire_step_free-energy': ('simulated wire, free energy: the same', None),
    'wire_step_smooth-hardening': ('simulated wire, smooth hardening: the same', None),
    'observer_step': ('observer step', 1500),
    'observer_step_ordered': ('observer step, calibrated wire: order, tapers, R2A of its own', 2200),
    'multiple_model_step': ('observer step of the multiple-model filter', None),
    'control_step': ("controller's step, closed loop in strain", 700),
    'device_step': ('whole step of the device', 4000),
    'strain_resistance_step': ('stress-strain-resistance step (002)', None),
}


def say(words):
    print(words, file=sys.stderr, flush=True)


def run(words, output, errors=None, **more):
    """A program whose output goes into a file; its end is shown where it fails."""
    log = errors or output
    with output.open('w') as out, log.open('w') if errors else output.open('a') as err:
        code = subprocess.run(words, stdout=out, stderr=err, stdin=subprocess.DEVNULL, **more).returncode
    if code:
        say(log.read_text(errors='replace')[-4000:])
        sys.exit(f'bench: {words[0]} has failed ({code}); all that it said is in {log}')


def table(heads, rows):
    """The first column is text, and so is the last one where it has a target."""
    ends = ['---', *['--:'] * (len(heads) - 1)]
    for row in [heads, ends, *rows]:
        print(f'|{"|".join(row)}|' if row is ends else f'| {" | ".join(row)} |')
    print(flush=True)


def measured(*benches):
    """What Google Benchmark has measured, by the name of the benchmark and of the figure."""
    found = {}
    for bench in benches:
        say(f'running {bench}')
        file = OUT / f'{bench}.json'
        run([PROGRAMS / bench, f'--benchmark_out={file}', '--benchmark_out_format=json'], OUT / f'{bench}.log')
        for one in json.loads(file.read_text())['benchmarks']:
            name = re.sub(r'/(iterations|real_time).*', '', one['name'])
            found.update({(name, figure): value for figure, value in one.items()})
    return found


def instructions_of(kind, part):
    """Of one step of a kind, 'observer_step/float', or of its half in which the wire heats or cools."""
    file = OUT / f'count-{kind.replace("/", "-")}-{part}'
    steps, log = file.with_suffix('.steps'), file.with_suffix('.log')
    run([*CALLGRIND, '--callgrind-out-file=/dev/null', '--toggle-collect=counted_steps',
         PROGRAMS / 'count_steps', kind, part], steps, log)
    collected = re.search(r'Collected : (\d+)', log.read_text())
    return int(collected[1]) / int(steps.read_text())


def instructions():
    kinds = subprocess.run([PROGRAMS / 'count_steps'], check=True, capture_output=True, text=True).stdout.split()
    jobs = {}
    for kind in kinds:
        name, scalar = kind.split('/')
        jobs[name, scalar] = kind, 'all'
        if name in ('model_step_cut', 'empty'):
            jobs.update({(f'{name}:{part}', scalar): (kind, part) for part in ('heating', 'cooling')})
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return dict(zip(jobs, pool.map(lambda job: instructions_of(*job), jobs.values())))


def steps_table(figures, counts):
    unnamed = sorted({kind for kind, _ in counts if kind not in STEPS and not kind.startswith('empty')})
    if unnamed:
        sys.exit(f'bench: {", ".join(unnamed)}: has no name in {Path(__file__).name}')

    def ns(kind, scalar):
        time = figures.get((f'{kind}/{scalar}', 'cpu_time'))
        return '' if time is None else f'{time:.1f} ns'

    def count(kind, scalar):
        own = counts.get((kind, scalar))
        return '' if own is None else f'{own - counts["empty", scalar]:.0f}'

    def both(name, form, of):
        return [name, *(form.format(of(scalar)) for scalar in ('float', 'double')), '', '']

    def cpu_time(name):
        return figures[name, 'cpu_time']

    rows = [[title, ns(kind, 'float'), ns(kind, 'double'), count(kind, 'float'), count(kind, 'double'),
             f'<= {most} instructions' if most else ''] for kind, (title, most) in STEPS.items()]
    rows.append([*both('473 000 model points', '{:.1f} ms', lambda s: cpu_time(f'ModelPoints473000/{s}')), '< 25 ms'])
    rows.append([*both('model step by converting cosine step', '{:.1f}',
                       lambda s: cpu_time(f'model_step_cut/{s}') / cpu_time(f'cosine_step_converting/{s}')), '<= 3'])
    table(['step', 'float', 'double', 'instructions, float', 'double', 'target'], rows)


def print_steps(figures):
    def million(name):
        return f'{figures[name, "items_per_second"] / 1e6:.2f} M'

    def error(name, scalar):
        return f'{figures[f"{name}_error/{scalar}", "worst_relative_error"]:.1e}'

    table(['ihyp inverse, worst relative error of the smaller of x and 1 - x in 20 000 cases', 'float', 'double'],
          [[title, error(name, 'float'), error(name, 'double')] for title, name in (
              ('ours', 'ihyp_inverse'), ('Cardano', 'ihyp_inverse_cardano'), ('Newton', 'ihyp_inverse_newton'))])
    table(['1 000 000 rows', 'rows/s', 'MB/s', 'target'],
          [[title, million(name), f'{figures[name, "bytes_per_second"] / 1e6:.0f}', target] for title, name, target in (
              ('replay, Kalman filter, all columns written', 'replay/kalman', '>= 1.5 M rows/s'),
              ('the same, written as MCAP', 'replay/mcap', ''),
              ('replay, straight line, all columns written', 'replay/line', ''),
              ('bare read of the same file', 'bare_read', ''))])
    table(['1 000 000 rows of five columns', 'written, rows/s', 'read, rows/s', 'file, MB'],
          [[title, million(f'write/{name}'), million(f'read/{name}'),
            f'{figures[f"write/{name}", "file_bytes"] / 1e6:.1f}'] for title, name in (
                ('CSV', 'csv'), ('MCAP', 'mcap'))])
    table(['the device closed on a simulated wire, 1 kHz, one core', 'times real time', 'target'],
          [[plant, f'{figures[f"closed_loop/{plant}", "times_real_time"]:.0f}', target] for plant, target in (
              ('lumped', '>= 2000'), ('ihyp', '>= 500'), ('sublayers', '>= 500'))])


def print_worst():
    """Single steps: the times of all of them, and the instructions of those that took longest."""
    costliest, counted = OUT / 'costliest', OUT / 'costliest.callgrind'
    subprocess.run([PROGRAMS / 'worst_steps', costliest], check=True)
    counted.unlink(missing_ok=True)
    # Without what the loader does at the first call of a function.
    run([*CALLGRIND, '--toggle-collect=counted_step', '--dump-after=counted_step', '--combine-dumps=yes',
         f'--callgrind-out-file={counted}', PROGRAMS / 'worst_steps', 'count', costliest],
        OUT / 'costliest.log', env={**os.environ, 'LD_BIND_NOW': '1'})
    totals = sorted(int(total) for total in re.findall(r'^totals: (\d+)', counted.read_text(), re.MULTILINE))
    totals = [total for total in totals if total > 0]
    print()
    table(['instructions of those that took longest, beyond the first sample', 'least', 'median', 'most'],
          [[f'{len(totals)} steps', str(totals[0]), str(totals[(len(totals) - 1) // 2]), str(totals[-1])]])


def print_identify():
    figures = measured('identify_bench')

    def time(runs, threads):
        return f'{figures[f"identify/runs:{runs}/threads:{threads}", "real_time"] / 1e3:.1f} s'

    many = (1, 2, 4, 8)
    table(['identification of a wire, runs of 60 s at 1 kHz', *map(str, many), 'target'],
          [[title, *(time(runs, threads) for runs in many), target] for title, threads, target in (
              ('1 thread', 1, ''), ('2 threads', 2, '8 runs < 60 s'))])


def model_name():
    found = re.search(r'^model name\s*: (.*)', Path('/proc/cpuinfo').read_text(), re.MULTILINE)
    return found[1] if found else os.uname().machine


def main(what):
    OUT.mkdir(parents=True, exist_ok=True)
    if what == 'identify':
        return print_identify()
    figures = measured('model_bench', 'replay_bench', 'closed_loop_bench')
    say('counting instructions')
    counts = instructions()
    compiler = subprocess.run(['g++', '--version'], check=True, capture_output=True, text=True).stdout.splitlines()[0]
    print(f'Time, and instructions per step by callgrind. {model_name()}, {compiler}:\n')
    steps_table(figures, counts)
    print_steps(figures)
    if what != 'tables':
        print_worst()


if __name__ == '__main__':
    main(*sys.argv[1:] or [''])
