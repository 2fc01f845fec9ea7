#!/usr/bin/python3
"""train.py RUN.csv ... --set wire.length_mm=100.6 --out gru.json: trains the recurrent network (GRU) that `host-sim
compare --gru gru.json` sets beside the other systems, on the runs that these are identified on.

The network's inputs are the resistance, divided by the run's first one, the electrical power and the stress; its
output is the strain. Runs are read by the Python package smaservo (host-sim/python), so that formats, units and names
of columns are those of host-sim. Gradients are computed here, by numpy alone.

The result is the same for the same runs, options and seed, on one machine: another library of linear algebra may round
otherwise.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

# More threads than one only slow down products of matrices as small as these. Read when numpy is loaded.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

import numpy as np
import numpy.typing as npt
import smaservo

Floats = npt.NDArray[np.float64]
Parameters = dict[str, Floats]

VERSION = 1
STEP_S = 0.01
FILTER_S = 0.023  # of the stress; the observer's, which compare applies for all systems without feedback
SMALLEST_CURRENT = 0.03  # of a run's largest; below it no resistance is measured (host-sim/checks/record.cpp)
LONGEST_GAP_S = 10.0  # from row to row; host-sim starts the network anew behind a longer one
LARGEST_HIDDEN = 256  # that host-sim takes
DIGITS = 6  # of the weights in the file
INPUTS = ('resistance', 'power', 'stress')
UNITS = ('of the first', 'W', 'MPa')

Shape = tuple[int, ...]


class Refused(Exception):
    """What this program cannot use; the message is for a person."""


@dataclass
class Course:
    """A run at the network's steps."""

    name: str
    rows: int
    checksum: str
    inputs: Floats  # steps x 3, in the units above
    strain_percent: Floats  # of the nominal stroke; NaN where the run has none


@dataclass
class Network:
    """The weights, and the scales of what goes in and comes out."""

    parameters: Parameters
    input_mean: Floats
    input_scale: Floats
    strain_mean: float
    strain_scale: float

    @property
    def hidden(self) -> int:
        return int(self.parameters['output'].size)


# ---- runs


def checksum(values: Floats) -> str:
    """FNV-1a with 128 bits over the numbers' bytes, as host-sim/hash.hpp."""
    state = 0x6C62272E07BB014262B821756295C58D
    for byte in values.astype('<f8').tobytes():
        state = (state ^ byte) * 0x0000000001000000000000000000013B % (1 << 128)
    return f'{state:032x}'


def column(run: smaservo.Recording, name: str) -> Floats | None:
    return np.asarray(run[name], dtype=np.float64) if name in run else None


def resistance(run: smaservo.Recording) -> Floats:
    """As host-sim/checks/record.cpp: the column, otherwise voltage per current; NaN where the current is too small."""
    own = column(run, 'resistance_ohm')
    if own is not None:
        return own
    current_A = run.current_A
    measured = np.abs(current_A) >= SMALLEST_CURRENT * np.max(np.abs(current_A))
    measured &= current_A != 0
    return np.where(measured, run.voltage_V / np.where(measured, current_A, 1.0), np.nan)


def strain(run: smaservo.Recording, wire: smaservo.Wire) -> Floats | None:
    """Elongation; of a displacement with a zero of its own, from the greatest length."""
    absolute = column(run, 'strain_ref')
    moved_m = column(run, 'displacement_m')
    if absolute is None and moved_m is not None:
        absolute = (np.min(moved_m) - moved_m) / wire.length_m
    return absolute


def at_rest(strains: Floats, stress_Pa: Floats, wire: smaservo.Wire, ambient_K: float) -> Floats:
    """Moves a strain that has a zero of its own so that the longest wire is as long as this one at rest under that
    load, as compare does in training. An extreme of exactly 0 is such a zero (host-sim/identify/runs/run.cpp)."""
    if min(abs(np.nanmin(strains)), abs(np.nanmax(strains))) > 1e-7:
        return strains
    longest = int(np.nanargmax(strains))
    rest = smaservo.Plant(wire, float(stress_Pa[longest] * wire.area_m2), ambient_K).output().strain
    moved: Floats = strains + (rest - strains[longest])
    return moved


def valid(ohm: Floats) -> npt.NDArray[np.bool_]:
    return np.isfinite(ohm) & (ohm > 0)


def held(values: Floats) -> Floats:
    """A resistance that is not valid becomes the last valid one before it; those at the beginning the first one."""
    known = np.flatnonzero(valid(values))
    last = np.searchsorted(known, np.arange(values.size), side='right') - 1
    held_values: Floats = values[known[np.maximum(last, 0)]]
    return held_values


def filtered(values: Floats, time_s: Floats) -> Floats:
    """A first-order low-pass from row to row, which begins at the first value."""
    dt_s = np.diff(time_s, prepend=2 * time_s[0] - time_s[1])
    weights = dt_s / (dt_s + FILTER_S)
    result = np.empty_like(values)
    last = values[0]
    for i, weight in enumerate(weights):
        last += weight * (values[i] - last)
        result[i] = last
    return result


def inputs_at_steps(time_s: Floats, ohm: Floats, power_W: Floats, stress_Pa: Floats) -> tuple[Floats, Floats]:
    """Times of the network's steps from the first row on, and its inputs there. Resistance and stress are interpolated;
    the power is the mean over the step, so that no energy is lost, however fast or slowly the rows follow."""
    steps = int(np.floor((time_s[-1] - time_s[0]) / STEP_S + 1e-6)) + 1
    at_s = time_s[0] + STEP_S * np.arange(steps)
    known = held(ohm)
    energy_J = np.concatenate([[0.0], np.cumsum(0.5 * (power_W[1:] + power_W[:-1]) * np.diff(time_s))])
    mean_W = np.diff(np.interp(at_s, time_s, energy_J), prepend=0.0) / STEP_S
    mean_W[0] = power_W[0]
    columns = [np.interp(at_s, time_s, known) / known[0], mean_W,
               np.interp(at_s, time_s, filtered(stress_Pa, time_s)) / 1e6]
    return at_s, np.stack(columns, axis=1)


def stress(run: smaservo.Recording, wire: smaservo.Wire, constant_Pa: float | None) -> Floats | None:
    own = column(run, 'stress_Pa')
    if own is not None:
        return own
    loads_N = column(run, 'load_N')
    if loads_N is not None:
        return loads_N / wire.area_m2
    return None if constant_Pa is None else np.full(len(run.time_s), constant_Pa)


def course(path: str, run: smaservo.Recording, wire: smaservo.Wire, constant_Pa: float | None = None) -> Course:
    """`constant_Pa` is the stress of a run without one. Raises Refused for a run that the network cannot learn from."""
    missing = [name for name in ('time_s', 'current_A', 'voltage_V') if name not in run]
    if missing:
        raise Refused(f'{path}: has no {" and no ".join(missing)}; a run must be of Joule heating')
    ohm, strains, stress_Pa = resistance(run), strain(run, wire), stress(run, wire, constant_Pa)
    if strains is None or not np.isfinite(strains).any():
        raise Refused(f'{path}: has no strain_ref or displacement')
    if stress_Pa is None:
        raise Refused(f'{path}: has neither load_N nor stress_MPa; give --load-N or --stress-MPa')
    if not valid(ohm).any():
        raise Refused(f'{path}: no row has a resistance')
    gap_s = float(np.max(np.diff(run.time_s), initial=0.0))
    if len(run.time_s) < 20 or gap_s > LONGEST_GAP_S:
        raise Refused(f'{path}: has {len(run.time_s)} rows and a gap of {gap_s:g} s between them; '
                      f'at least 20 rows are needed, at most {LONGEST_GAP_S:g} s apart')
    at_s, inputs = inputs_at_steps(run.time_s, ohm, run.current_A * run.voltage_V, stress_Pa)
    air_K = column(run, 'ambient_K')
    placed = at_rest(strains, stress_Pa, wire, 298.15 if air_K is None else float(air_K[0]))
    percent = 100 / wire.nominal_stroke * placed
    return Course(Path(path).name, len(strains), checksum(strains), inputs, np.interp(at_s, run.time_s, percent))


# ---- the network


def shapes(hidden: int) -> dict[str, Shape]:
    """Of the reset gate, of the update gate, of the candidate for the next state, and of the output."""
    found: dict[str, Shape] = {}
    for gate in ('reset', 'update', 'candidate'):
        found[f'{gate}_input'] = (hidden, len(INPUTS))
        found[f'{gate}_state'] = (hidden, hidden)
        found[f'{gate}_bias'] = (hidden,)
    return found | {'output': (hidden,), 'output_bias': ()}


def beginning(hidden: int, random: np.random.Generator) -> Parameters:
    """Uniform within 1/sqrt(hidden); biases are 0, but for the update gate, which begins with a long memory."""
    parameters: Parameters = {}
    for name, shape in shapes(hidden).items():
        parameters[name] = random.uniform(-1, 1, shape) / np.sqrt(hidden)
        if name.endswith('bias'):
            parameters[name] = np.full(shape, 1.0 if name.startswith('update') else 0.0)
    return parameters


def sigmoid(x: Floats) -> Floats:
    share: Floats = 0.5 * (1 + np.tanh(0.5 * x))
    return share


@dataclass
class Gates:
    """The weights as the steps use them: those of both gates side by side, each column a neuron."""

    input: Floats
    bias: Floats
    state: Floats
    candidate_state: Floats

    @staticmethod
    def of(p: Parameters) -> Gates:
        names = ('reset', 'update', 'candidate')
        return Gates(np.concatenate([p[f'{name}_input'] for name in names]).T.copy(),
                     np.concatenate([p[f'{name}_bias'] for name in names]),
                     np.concatenate([p['reset_state'], p['update_state']]).T.copy(), p['candidate_state'].T.copy())


def advanced(gates: Gates, fed: Floats, state: Floats) -> tuple[Floats, Floats, Floats]:
    """Both gates, the candidate, and the next state. `fed` is what the inputs give to the three."""
    hidden = state.shape[1]
    both = sigmoid(fed[:, :2 * hidden] + state @ gates.state)
    reset, update = both[:, :hidden], both[:, hidden:]
    candidate = np.tanh(fed[:, 2 * hidden:] + (reset * state) @ gates.candidate_state)
    return both, candidate, candidate + update * (state - candidate)


def states_of(p: Parameters, inputs: Floats) -> Floats:
    """The states before each step, and behind the last. Inputs are steps x courses x 3, scaled; begins with 0."""
    gates = Gates.of(p)
    fed = inputs @ gates.input + gates.bias
    states = np.zeros((len(inputs) + 1, inputs.shape[1], p['output'].size))
    for t, now in enumerate(fed):
        states[t + 1] = advanced(gates, now, states[t])[2]
    return states


def loss_and_gradient(p: Parameters, inputs: Floats, wanted: Floats, weights: Floats,
                      start: Floats) -> tuple[float, Parameters]:
    """Half of the weighed squares of the errors, and its derivatives. Inputs are steps x windows x 3, wanted strains
    and weights steps x windows, all scaled; start is windows x hidden and counts as constant."""
    gates = Gates.of(p)
    hidden = start.shape[1]
    fed = inputs @ gates.input + gates.bias
    states = np.empty((len(inputs) + 1, *start.shape))
    both, candidates = np.empty((len(inputs), len(start), 2 * hidden)), np.empty((len(inputs), *start.shape))
    states[0] = start
    for t, now in enumerate(fed):
        both[t], candidates[t], states[t + 1] = advanced(gates, now, states[t])
    errors = states[1:] @ p['output'] + p['output_bias'] - wanted
    loss = 0.5 * float(np.sum(weights * errors ** 2))
    errors *= weights

    # Derivatives by what enters the sigmoids and the tanh, from the last step to the first.
    by_fed = np.empty_like(fed)
    by_state = np.zeros_like(start)
    for t in range(len(inputs) - 1, -1, -1):
        reset, update = both[t, :, :hidden], both[t, :, hidden:]
        by_state = by_state + errors[t, :, None] * p['output']
        candidate = by_state * (1 - update) * (1 - candidates[t] ** 2)
        by_shown = candidate @ gates.candidate_state.T  # by the state that the reset gate lets through
        by_fed[t, :, :hidden] = by_shown * states[t] * reset * (1 - reset)
        by_fed[t, :, hidden:2 * hidden] = by_state * (states[t] - candidates[t]) * update * (1 - update)
        by_fed[t, :, 2 * hidden:] = candidate
        by_state = by_state * update + by_shown * reset + by_fed[t, :, :2 * hidden] @ gates.state.T

    flat = by_fed.reshape(-1, 3 * hidden)
    before = states[:-1].reshape(-1, hidden)
    shown = (both[:, :, :hidden] * states[:-1]).reshape(-1, hidden)
    by_input, by_bias = flat.T @ inputs.reshape(-1, inputs.shape[2]), flat.sum(axis=0)
    gradient: Parameters = {'output': np.tensordot(errors, states[1:], 2), 'output_bias': np.asarray(np.sum(errors))}
    for i, gate in enumerate(('reset', 'update', 'candidate')):
        part = slice(i * hidden, (i + 1) * hidden)
        gradient[f'{gate}_input'], gradient[f'{gate}_bias'] = by_input[part], by_bias[part]
        gradient[f'{gate}_state'] = flat[:, part].T @ (shown if gate == 'candidate' else before)
    return loss, gradient


def strain_percent(network: Network, inputs: Floats) -> Floats:
    """The strain at each step of a course, in % of the nominal stroke."""
    scaled = (inputs - network.input_mean) / network.input_scale
    states = states_of(network.parameters, scaled[:, None, :])[1:, 0]
    result: Floats = states @ network.parameters['output'] + network.parameters['output_bias']
    return network.strain_mean + network.strain_scale * result


# ---- training


@dataclass
class Options:
    hidden: int = 32
    seed: int = 1
    epochs: int = 200
    window_s: float = 2.0
    updates: int = 4  # for each pass through the runs
    rate: float = 0.01  # of Adam, at the beginning; it falls to a hundredth along a cosine


@dataclass
class Adam:
    """Adam (Kingma and Ba, 2015) with the usual decays, and a limit of the gradient's norm."""

    parameters: Parameters
    first: Parameters = field(default_factory=dict)
    second: Parameters = field(default_factory=dict)
    updates: int = 0

    def update(self, gradient: Parameters, rate: float) -> None:
        self.updates += 1
        norm = float(np.sqrt(sum(np.sum(g ** 2) for g in gradient.values())))
        limit = min(1.0, 1.0 / max(norm, 1e-300))
        for name, steepest in gradient.items():
            g = limit * steepest
            m = self.first[name] = 0.9 * self.first.get(name, np.zeros_like(g)) + 0.1 * g
            v = self.second[name] = 0.999 * self.second.get(name, np.zeros_like(g)) + 0.001 * g ** 2
            mean, square = m / (1 - 0.9 ** self.updates), v / (1 - 0.999 ** self.updates)
            self.parameters[name] = self.parameters[name] - rate * mean / (np.sqrt(square) + 1e-8)


@dataclass
class Lesson:
    """All runs side by side, scaled. Shorter ones are filled up with rows that do not count."""

    inputs: Floats  # steps x courses x 3
    wanted: Floats
    weights: Floats

    @staticmethod
    def of(courses: Sequence[Course], network: Network) -> Lesson:
        steps = max(len(one.inputs) for one in courses)
        lesson = Lesson(np.zeros((steps, len(courses), len(INPUTS))), np.zeros((steps, len(courses))),
                        np.zeros((steps, len(courses))))
        for i, one in enumerate(courses):
            n = len(one.inputs)
            known = np.isfinite(one.strain_percent)
            lesson.inputs[:n, i] = (one.inputs - network.input_mean) / network.input_scale
            lesson.wanted[:n, i][known] = (one.strain_percent[known] - network.strain_mean) / network.strain_scale
            lesson.weights[:n, i] = known / max(1, np.count_nonzero(known)) / len(courses)
        return lesson


def untrained(courses: Sequence[Course], hidden: int, random: np.random.Generator) -> Network:
    inputs = np.concatenate([one.inputs for one in courses])
    wanted = np.concatenate([one.strain_percent for one in courses])
    scales = inputs.std(axis=0)
    return Network(beginning(hidden, random), inputs.mean(axis=0), np.where(scales > 1e-9, scales, 1.0),
                   float(np.nanmean(wanted)), max(float(np.nanstd(wanted)), 1e-9))


def train(courses: Sequence[Course], options: Options,
          watch: Callable[[int, Network], None] | None = None) -> Network:
    """Backpropagation through windows of the runs. An epoch begins with a pass through the runs, which gives the states
    that the windows begin with, so that they know what has happened before them."""
    random = np.random.default_rng(options.seed)
    network = untrained(courses, options.hidden, random)
    lesson = Lesson.of(courses, network)
    adam = Adam(network.parameters)
    steps, runs = lesson.wanted.shape
    length = min(steps, max(1, round(options.window_s / STEP_S)))
    for epoch in range(options.epochs):
        states = states_of(network.parameters, lesson.inputs)
        # Windows begin elsewhere in each epoch, so that no place is always the last that learns from what follows.
        firsts = np.arange(int(random.integers(min(length, steps - length + 1))), steps - length + 1, length)
        windows = random.permutation([(first, run) for first in firsts for run in range(runs)
                                      if lesson.weights[first:first + length, run].any()])
        rate = options.rate * (0.01 + 0.99 * 0.5 * (1 + np.cos(np.pi * epoch / options.epochs)))
        for part in np.array_split(windows, min(options.updates, len(windows))):
            at = part[:, 0] + np.arange(length)[:, None]
            weights = lesson.weights[at, part[:, 1]]
            _, gradient = loss_and_gradient(network.parameters, lesson.inputs[at, part[:, 1]],
                                            lesson.wanted[at, part[:, 1]], weights / max(weights.sum(), 1e-300),
                                            states[part[:, 0], part[:, 1]])
            adam.update(gradient, float(rate))
        if watch:
            watch(epoch, network)
    return network


# ---- the file


def rounded(value: Floats | float) -> list[object] | float:
    """Numbers with the digits that the file has, in lists as deep as the array."""
    array = np.asarray(value)
    return [rounded(one) for one in array] if array.ndim else float(f'{float(array):.{DIGITS}g}')


def scales(name: str, unit: str, mean: float, scale: float) -> dict[str, object]:
    return {'name': name, 'unit': unit, 'mean': rounded(mean), 'scale': rounded(scale)}


def text_of(network: Network, courses: Sequence[Course], nominal_stroke: float, options: Options) -> str:
    """The file: JSON, with a line for each list of numbers."""
    document = {
        'format': 'smaservo-gru',
        'version': VERSION,
        'hidden': network.hidden,
        'step_s': STEP_S,
        'nominal_stroke': nominal_stroke,
        'seed': options.seed,
        'epochs': options.epochs,
        'runs': [{'name': one.name, 'rows': one.rows, 'checksum': one.checksum} for one in courses],
        'inputs': [scales(name, unit, float(mean), float(scale)) for name, unit, mean, scale
                   in zip(INPUTS, UNITS, network.input_mean, network.input_scale)],
        'output': scales('strain', '% of the nominal stroke', network.strain_mean, network.strain_scale),
        'weights': {name: rounded(network.parameters[name]) for name in shapes(network.hidden)},
    }
    text = json.dumps(document, indent=1, allow_nan=False)
    return re.sub(r'\[([^][{}"]*)]', lambda numbers: '[' + ' '.join(numbers[1].split()) + ']', text) + '\n'


def check_output(path: Path, runs: Sequence[str]) -> None:
    """Before the training, which takes minutes."""
    for one in runs:
        if path.resolve() == Path(one).resolve():
            raise Refused(f'--out {path}: is one of the runs')
    if path.exists() and not path.is_file():
        raise Refused(f'--out {path}: is a folder or a device; give the name of a file')
    if not path.parent.is_dir():
        raise Refused(f'{path}: cannot be written: there is no folder {path.parent}')


def write(path: Path, text: str) -> None:
    """The file appears under its name when it is complete."""
    beside = path.with_name(f'.{path.name}.{os.getpid()}')
    try:
        beside.write_text(text)
        beside.replace(path)
    except OSError as error:
        raise Refused(f'{path}: cannot be written: {error.strerror}') from None
    finally:
        beside.unlink(missing_ok=True)


# ---- the command


def mean_error(network: Network, one: Course) -> float:
    """In % of the nominal stroke."""
    return float(np.nanmean(np.abs(strain_percent(network, one.inputs) - one.strain_percent)))


def leave_one_out(courses: Sequence[Course], options: Options) -> None:
    """By what the options are chosen: the error in each run of a network that was trained on all others."""
    errors = []
    for left_out in courses:
        network = train([one for one in courses if one is not left_out], options)
        errors.append(mean_error(network, left_out))
        print(f'{left_out.name}: {errors[-1]:.2f} % of the stroke when it is left out', flush=True)
    print(f'mean: {np.mean(errors):.2f} %')


def arguments(words: Sequence[str]) -> argparse.Namespace:
    def whole(low: int, high: int) -> Callable[[str], int]:
        def number(text: str) -> int:
            value = int(text)
            if not low <= value <= high:
                raise argparse.ArgumentTypeError(f'{value}: must be {low} to {high}')
            return value
        return number

    usual = Options()
    parser = argparse.ArgumentParser(prog='train.py', description=(__doc__ or '').split('\n\n', maxsplit=1)[0])
    parser.add_argument('runs', nargs='+', metavar='RUN', help='a recording of Joule heating with a strain')
    parser.add_argument('--out', type=Path, help='the file of the network')
    parser.add_argument('--from', dest='start', default='smartflex-76um', metavar='NAME|FILE.toml',
                        help='the wire: a preset or a file (default: %(default)s)')
    parser.add_argument('--set', action='append', default=[], metavar='KEY=VALUE', help='of the wire; repeatable')
    parser.add_argument('--column', action='append', default=[], metavar='NAME=COLUMN',
                        help='as of host-sim; repeatable')
    parser.add_argument('--load-N', dest='load_N', type=float, help='load of runs without a load')
    parser.add_argument('--stress-MPa', dest='stress_MPa', type=float, help='the same as a stress')
    parser.add_argument('--hidden', type=whole(1, LARGEST_HIDDEN), default=usual.hidden,
                        help='number of units (default: %(default)s)')
    parser.add_argument('--seed', type=whole(0, 2 ** 32), default=usual.seed, help='default: %(default)s')
    parser.add_argument('--epochs', type=whole(1, 100_000), default=usual.epochs, help='default: %(default)s')
    parser.add_argument('--leave-one-out', action='store_true',
                        help='print the error in each run of a network trained on the others; writes nothing')
    found = parser.parse_args(words)
    if (found.out is None) != found.leave_one_out:
        parser.error('give either --out or --leave-one-out')
    if found.load_N is not None and found.stress_MPa is not None:
        parser.error('give either --load-N or --stress-MPa')
    return found


def settings_of(words: Sequence[str]) -> dict[str, float | str]:
    settings: dict[str, float | str] = {}
    for word in words:
        key, equals, value = word.partition('=')
        if not equals:
            raise Refused(f'--set {word}: must be KEY=VALUE')
        try:
            settings[key] = float(value)
        except ValueError:
            settings[key] = value
    return settings


def run(found: argparse.Namespace) -> None:
    wire = smaservo.Wire.load(found.start, settings_of(found.set))
    if found.out:
        check_output(found.out, found.runs)
    constant_Pa = 1e6 * found.stress_MPa if found.stress_MPa is not None else None
    constant_Pa = found.load_N / wire.area_m2 if found.load_N is not None else constant_Pa
    courses = [course(path, smaservo.read(path, columns=found.column), wire, constant_Pa) for path in found.runs]
    if len({one.checksum for one in courses}) < len(courses):
        raise Refused('a run is given twice')
    options = Options(found.hidden, found.seed, found.epochs)
    if found.leave_one_out:
        if len(courses) < 2:
            raise Refused('--leave-one-out: needs at least two runs')
        leave_one_out(courses, options)
        return
    network = train(courses, options)
    write(found.out, text_of(network, courses, wire.nominal_stroke, options))
    for one in courses:
        print(f'{one.name}: {mean_error(network, one):.2f} % of the stroke, in training')


def main(words: Sequence[str]) -> int:
    try:
        run(arguments(words))
    except (Refused, smaservo.Error, ValueError) as error:
        print(f'train.py: {error}', file=sys.stderr)
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
