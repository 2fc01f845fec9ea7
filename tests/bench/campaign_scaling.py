#!/usr/bin/env python3
"""campaign_scaling.py BUILD [TRIALS [ROUNDS]] | computed: how campaigns scale with processes, threads and ranks of MPI.

Prints, as Markdown, trials per second of a small plan of random scenarios by one and two of each, what a chunk
costs besides its trials, and a table computed from that for machines with more processors. All are measured in turn,
ROUNDS times, and the best of each counts. Times say something only on a machine that does nothing else.
`computed` prints the last table alone.
"""

import csv
import math
import os
from pathlib import Path
import random
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = Path(__file__).resolve().parents[2]

# Of the computed table; the README of campaigns says them, too.
TRIAL_S = 0.12  # of a random scenario, on one core
SPREAD = 1.8  # standard deviation of that time by its mean
CHUNK_TRIALS = 1200  # that `chunk = 0` chooses for scenarios
CHUNK_S = 0.007  # of a chunk besides its trials, on a local disk
ROW_S = 2e-6  # joining a row and its statistics; files in memory
START_S = 2  # of mpirun, of reading plan and wires


def timed(*commands):
    """Runs commands at the same time; seconds, processor seconds, and the greatest memory of a process in MB."""
    begin, processes = time.monotonic(), []
    for command in commands:
        processes.append(subprocess.Popen(command, stdout=subprocess.DEVNULL))
    processor_s, memory_MB = 0.0, 0.0
    for process in processes:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            sys.exit(f'failed: {" ".join(map(str, process.args))}')
        processor_s += usage.ru_utime + usage.ru_stime
        memory_MB = max(memory_MB, usage.ru_maxrss / 1024)
    return time.monotonic() - begin, processor_s, memory_MB


class Bench:
    def __init__(self, build, work):
        self.plain = build / 'host-sim/host-sim'
        self.with_mpi = build / 'tests/host-sim/host-sim-mpi'
        self.work = work

    def plan(self, name, text):
        path = self.work / f'{name}.toml'
        path.write_text(text)
        return path

    def campaign(self, plan, *options, program=None, before=()):
        return [*before, program or self.plain, 'campaign', plan, '--out', self.work / 'out', *options]

    def run(self, *parts):
        """Parts one after the other, each some commands at the same time; into a new folder."""
        shutil.rmtree(self.work / 'out', ignore_errors=True)
        results = [timed(*commands) for commands in parts]
        return sum(r[0] for r in results), sum(r[1] for r in results), max(r[2] for r in results)

    def ranks(self, plan, count):
        before = ['mpirun', '--oversubscribe', '--bind-to', 'none', '-np', str(count)]
        return self.run([self.campaign(plan, program=self.with_mpi, before=before)])


def best(rounds, measures):
    """The quickest run of each, all measured in turn."""
    found = {}
    for _ in range(rounds):
        for name, measure in measures.items():
            result = measure()
            found[name] = min(found.get(name, result), result)
    return found


def ways(bench, plan):
    def shards():
        parts = [bench.campaign(plan, '--threads', '1', '--shard', f'{k}/2') for k in range(2)]
        return bench.run(parts, [bench.campaign(plan, '--merge')])

    measures = {
        '1 process': lambda: bench.run([bench.campaign(plan, '--threads', '1')]),
        '2 processes (`--shard`), and `--merge`': shards,
        '1 process, 2 threads': lambda: bench.run([bench.campaign(plan, '--threads', '2')]),
    }
    if bench.with_mpi.exists() and shutil.which('mpirun'):
        measures['1 rank (2 threads, as without MPI)'] = lambda: bench.ranks(plan, 1)
        measures['2 ranks'] = lambda: bench.ranks(plan, 2)
    else:
        print('host-sim-mpi or mpirun is missing: no ranks', file=sys.stderr)
    return measures


def scaling(bench, trials, rounds):
    plan = bench.plan('scenarios', f"kind = 'scenarios'\ntrials = {trials}\nseed = 1\nchunk = {max(1, trials // 20)}\n"
                      f"[scenarios]\nunits = 1\nwires = '{ROOT}/tests/golden/evaluate'\n")
    found = best(rounds, ways(bench, plan))
    one_s = found['1 process'][0]
    print(f'{trials} random scenarios in 20 chunks, {os.cpu_count()} processors:\n')
    print('| by | s | trials/s | ratio | processor s | MB of a process |')
    print('|---|--:|--:|--:|--:|--:|')
    for name, (seconds, processor_s, memory_MB) in found.items():
        print(f'| {name} | {seconds:.1f} | {trials / seconds:.1f} | {one_s / seconds:.2f} | {processor_s:.1f} | '
              f'{memory_MB:.0f} |')
    with (bench.work / 'out/trials.csv').open() as rows:
        durations = [float(row['duration_s']) for row in csv.DictReader(rows)]
    spread = statistics.pstdev(durations) / statistics.mean(durations)
    print(f'\nThe simulated time of a trial varies by {100 * spread:.0f} % (standard deviation), so that of a chunk of '
          f'{CHUNK_TRIALS} by {100 * spread / math.sqrt(CHUNK_TRIALS):.1f} %.\n')


def chunk_cost(bench, rounds):
    """The same short trials in chunks of one, and in one chunk."""
    trials = 400
    scenarios = ROOT / 'host-sim/scenarios'
    shutil.copytree(scenarios / 'devices', bench.work / 'devices')
    text = (scenarios / 'steps.toml').read_text()
    bench.plan('short', text.replace('for_s = 20\n', 'for_s = 1\n'))
    measures = {}
    for chunk in (1, trials):
        plan = bench.plan(f'chunk-{chunk}', f"kind = 'gains'\ntrials = {trials}\nchunk = {chunk}\n"
                          "[gains]\nscenario = 'short.toml'\n")
        measures[chunk] = lambda plan=plan: bench.run([bench.campaign(plan, '--threads', '1')])
    found = best(rounds, measures)
    ms = [1000 * (many - one) / (trials - 1) for many, one in zip(found[1], found[trials])]
    print(f'A chunk besides its trials: {ms[0]:.1f} ms, of which the processor {ms[1]:.1f} ms '
          f'({trials} trials of {1000 * found[trials][0] / trials:.1f} ms in chunks of one, and in one chunk).\n')


def makespan_s(trials, cores, chunk):
    """Core k computes the chunks k, k + cores, ...; their times are drawn from a normal distribution."""
    draw, busy_s = random.Random(1), [0.0] * min(cores, math.ceil(trials / chunk))
    for k, first in enumerate(range(0, trials, chunk)):
        count = min(chunk, trials - first)
        # A trial takes 20 ms at least.
        busy_s[k % cores] += CHUNK_S + max(0.02 * count, draw.gauss(TRIAL_S * count, SPREAD * TRIAL_S * count**0.5))
    return START_S + max(busy_s) + ROW_S * trials


def clock(seconds):
    if seconds < 600:
        return f'{seconds:.0f} s'
    return f'{seconds / 60:.0f} min' if seconds < 7200 else f'{seconds / 3600:.1f} h'


def computed():
    print(f'Computed, not measured: scenarios of {TRIAL_S} s +- {100 * SPREAD:.0f} %, shards of `chunk = 0` ({CHUNK_TRIALS} '
          f'trials), {START_S} s to start, {1000 * CHUNK_S:.0f} ms for a chunk\nbesides its trials, {1e6 * ROW_S:.0f} us to '
          "join a row; in brackets the share of the cores' time that is spent in trials, and the\n`chunk` that gives each "
          'core eight, where that is better.\n')
    cores = (64, 256, 1024, 4096)
    print('| trials | ' + ' | '.join(f'{n} cores' for n in cores) + ' |')
    print('|--:|' + '--:|' * len(cores))
    for exponent in (4, 6, 8):
        trials, cells = 10 ** exponent, []
        for n in cores:
            own = max(1, trials // (8 * n))
            texts = []
            for chunk in (CHUNK_TRIALS, own):
                total_s = makespan_s(trials, n, chunk)
                share = 100 * trials * TRIAL_S / (n * total_s)
                given = '' if chunk == CHUNK_TRIALS else f', `chunk = {chunk}`'
                texts.append((total_s, f'{clock(total_s)} ({share:.0f} %{given})'))
            better = own < CHUNK_TRIALS and texts[1][0] < 0.95 * texts[0][0]
            cells.append('; '.join(text for _, text in texts[:2 if better else 1]))
        print(f'| 10{"⁰¹²³⁴⁵⁶⁷⁸"[exponent]} | ' + ' | '.join(cells) + ' |')


def main(words):
    if words == ['computed']:
        computed()
        return
    if not words:
        sys.exit(__doc__)
    build = Path(words[0]).resolve()
    trials = int(words[1]) if len(words) > 1 else 120
    rounds = int(words[2]) if len(words) > 2 else 3
    if os.geteuid() == 0:
        os.environ.update(OMPI_ALLOW_RUN_AS_ROOT='1', OMPI_ALLOW_RUN_AS_ROOT_CONFIRM='1')
    with tempfile.TemporaryDirectory() as work:
        bench = Bench(build, Path(work))
        scaling(bench, trials, rounds)
        chunk_cost(bench, rounds)
    computed()


if __name__ == '__main__':
    main(sys.argv[1:])
