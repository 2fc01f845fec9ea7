"""Wires of shape-memory alloy: their strain from resistance and load, models, and a whole servo.

    import smaservo
    wire = smaservo.Wire.load("smartflex-76um", {"wire.length_mm": 120})
    recording = smaservo.read("run.csv")
    estimate = smaservo.replay(wire, recording)
    print(estimate.strain)

All numbers are in the SI unit that ends their name. README.md in host-sim/python of the project has
the conventions.
"""

from __future__ import annotations

import os
import warnings as _warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from . import _core, _tables
from ._core import (
    ConfigError,
    Error,
    Estimate,
    Estimator,
    NoResult,
    Plant,
    PlantState,
    Servo,
    ServoOutput,
    Settings,
    TraceError,
    UserError,
    Wire,
    __version__,
    wire_presets,
)
from ._tables import HEALTH, Columns, Estimates, Recording, Simulation

if TYPE_CHECKING:
    import numpy.typing as npt
    import pandas as pd  # type: ignore[import]

    from ._core import Overrides

    Path = str | os.PathLike[str]

__all__ = [
    'HEALTH',
    'Columns',
    'ConfigError',
    'DataWarning',
    'Error',
    'Estimate',
    'Estimates',
    'Estimator',
    'Identification',
    'NoResult',
    'Plant',
    'PlantState',
    'Recording',
    'Servo',
    'ServoOutput',
    'Settings',
    'Simulation',
    'TraceError',
    'UserError',
    'Wire',
    '__version__',
    'evaluate',
    'evaluation_rows',
    'identify',
    'inspect',
    'observers',
    'read',
    'replay',
    'simulate',
    'simulate_scenario',
    'wire_presets',
]


class DataWarning(UserWarning):
    """What a recording shows that may be a mistake, or that makes an estimate worse."""


def _warn(texts: Iterable[str]) -> None:
    for text in texts:
        _warnings.warn(text, DataWarning, stacklevel=3)


def _wire(wire: Wire | Path) -> Wire:
    return wire if isinstance(wire, Wire) else Wire.load(wire)


def _require(name: str, value: float | None, low: float, high: float) -> None:
    if value is not None and not low <= value <= high:
        raise ValueError(f'{name} = {value}: must be {low:g} to {high:g}')


def replay(
    wire: Wire | Path,
    time_s: npt.ArrayLike | Mapping[str, npt.ArrayLike] | pd.DataFrame,
    current_A: npt.ArrayLike | None = None,
    voltage_V: npt.ArrayLike | None = None,
    load_N: npt.ArrayLike | None = None,
    *,
    stress_Pa: float | None = None,
    observer: str = 'kalman',
    ambient_K: float | None = None,
    settings: Overrides | None = None,
    columns: Iterable[str] = (),
    allow: Iterable[str] = (),
) -> Estimates:
    """Estimates the strain for a whole recording, as `host-sim replay` does, to the same bits.

    The data are arrays of equal length (load_N may be one number), or in the place of time_s a dict or
    DataFrame of columns by the names that a file may have: "current_A", "current_mA", "I [mA]"; load_N
    or stress_Pa is then the load where the data have none. Times must rise. After a gap of more than
    60 s the observer starts again.

    ambient_K is the first guess of the air; by default the data's first ambient temperature, or 25 degC.
    settings are those of `--set`, with the keys observer.* and measurement.*; columns are renames, as
    `--column`; allow are checks that may fail, as `--allow`. observer is one of observers().

    Raises ValueError or TypeError for arrays that cannot be used, and UserError for data that show a
    mistake such as a wrong unit; what may be one is a DataWarning.

    >>> import smaservo
    >>> wire = smaservo.Wire.load("smartflex-76um")
    >>> time_s = [0.001 * i for i in range(2000)]
    >>> run = smaservo.simulate(wire, time_s, current_A=[0.19] * 2000, load_N=0.68)
    >>> estimate = smaservo.replay(wire, run.time_s, run.current_A, run.voltage_V, run.load_N)
    >>> bool(abs(estimate.strain[-1] - run.strain[-1]) < 0.002)
    True
    """
    load: float | None = None
    if _tables.is_table(time_s):
        if current_A is not None or voltage_V is not None:
            raise TypeError('current_A and voltage_V: must not be given beside a table, which has them')
        names, arrays = _tables.table(time_s)
        if load_N is not None:
            load = float(load_N)  # type: ignore[arg-type]
    else:
        if current_A is None or voltage_V is None:
            raise TypeError('current_A and voltage_V: must be given beside time_s')
        first = _tables.numbers('time_s', time_s)
        rows = len(first)
        given = {'time_s': first, 'current_A': current_A, 'voltage_V': voltage_V}
        if load_N is not None:
            given['load_N'] = load_N
        names = list(given)
        arrays = [_tables.numbers(name, given[name], rows if name == 'load_N' else None) for name in names]
        for name, array in zip(names, arrays):
            if len(array) != rows:
                raise ValueError(f'{name}: has {len(array)} values, time_s has {rows}')
    _require('load_N', load, 0, 1e5)
    _require('stress_Pa', stress_Pa, 0, 1e10)
    _require('ambient_K', ambient_K, 173.15, 473.15)
    result = _core.replay_rows(
        _wire(wire),
        names,
        arrays,
        _tables.texts('columns', columns),
        observer,
        load,
        stress_Pa,
        ambient_K,
        settings,
        _tables.texts('allow', allow),
    )
    _warn(result['warnings'])
    estimates: Estimates = _tables.columns_of(Estimates, result['columns'])
    estimates.restarts = result['restarts']
    return estimates


def simulate(
    wire: Wire | Path,
    time_s: npt.ArrayLike,
    current_A: npt.ArrayLike,
    load_N: npt.ArrayLike,
    *,
    ambient_K: npt.ArrayLike = 298.15,
    draught: npt.ArrayLike = 1.0,
) -> Simulation:
    """A simulated wire under currents and loads: a Plant, in one call.

    At the first instant the wire rests. What an instant has of current, load, air and draught acts until
    the next one, at most 60 s later. Each may be one number for all instants.

    >>> import smaservo
    >>> run = smaservo.simulate("smartflex-76um", [0.0, 0.5, 1.0], current_A=0.2, load_N=0.68)
    >>> bool(run.strain[2] < run.strain[0])
    True
    """
    first = _tables.numbers('time_s', time_s)
    rows = len(first)
    others = {'current_A': current_A, 'load_N': load_N, 'ambient_K': ambient_K, 'draught': draught}
    arrays = [_tables.numbers(name, values, rows) for name, values in others.items()]
    simulation: Simulation = _tables.columns_of(Simulation, _core.simulate_rows(_wire(wire), first, *arrays))
    return simulation


def read(
    path: Path,
    *,
    columns: Iterable[str] = (),
    period_s: float | None = None,
    lenient: bool = False,
    device: bool = False,
) -> Recording:
    """Reads a recording as host-sim does: CSV, tables of other programs, MCAP, compressed files.

    columns are renames, as `--column`; period_s is the time between rows where no column has it;
    lenient skips bad rows; device reads the columns that only a device's log has, and takes an empty
    field for a reading that has failed. Raises TraceError, which names file, line and column.
    """
    result = _core.read_file(os.fspath(path), lenient, period_s, _tables.texts('columns', columns), device)
    recording: Recording = _tables.columns_of(Recording, result['columns'])
    recording.notes = result['notes']
    return recording


def simulate_scenario(path: Path) -> Recording:
    """Runs a scenario file, as `host-sim simulate` does, and gives the columns of the trace."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        trace = os.path.join(folder, 'trace.csv')
        _core.write_scenario(os.fspath(path), trace)
        return read(trace)


class Identification:
    """What identify() gives.

    wire is the fitted wire. parameters is a list of dicts (key, unit, value, sd, prior, prior_sd,
    determined), runs another with the errors of each run. strain_rms is the error over all runs as a
    share of the stroke, or None. summary is the text of `host-sim identify`. If interrupted or not
    converged, the wire is the best so far.
    """

    def __init__(self, result: Mapping[str, Any]) -> None:
        self.wire: Wire = result['wire']
        self.parameters: list[dict[str, Any]] = result['parameters']
        self.runs: list[dict[str, Any]] = result['runs']
        self.strain_rms: float | None = result['strain_rms']
        self.converged: bool = result['converged']
        self.interrupted: bool = result['interrupted']
        self.iterations: int = result['iterations']
        self.summary: str = result['summary']

    def __repr__(self) -> str:
        return f'<smaservo.Identification {self.wire.name}: {len(self.runs)} runs, strain_rms={self.strain_rms}>'


def identify(
    runs: Sequence[Path | Mapping[str, npt.ArrayLike] | pd.DataFrame],
    start: Wire | Path = 'smartflex-76um',
    *,
    name: str = 'fitted',
    load_N: float | None = None,
    stress_Pa: float | None = None,
    columns: Iterable[str] = (),
    allow: Iterable[str] = (),
    lenient: bool = False,
    threads: int = 0,
    circuit: bool = False,
    structure: str = 'auto',
    imposed_strain: bool = False,
    progress: Callable[[str, float, float], bool | None] | None = None,
) -> Identification:
    """Fits a wire's parameters to measured runs, as `host-sim identify` does. It takes minutes.

    A run is a file, or columns by name as for replay(). start is the nearest wire; its length and
    diameter must be right. load_N or stress_Pa is the load of runs that have none. threads is 0 for all
    cores. structure is 'auto', 'paper-000' or 'ordered', as of the command. imposed_strain says that a
    test frame set the strain of the runs in time, so that their stress is fitted; the errors of their
    stress are in pascals. progress is called with the stage, the share that is done and the cost; the fit ends with what it has if the answer is False.
    Ctrl-C raises KeyboardInterrupt.

    Raises UserError for runs that cannot be used, and where the fit explains too little of them.
    """
    if isinstance(runs, (str, os.PathLike)) or _tables.is_table(runs):
        raise TypeError('runs: must be a list of files or tables')
    if structure not in ('auto', 'paper-000', 'ordered'):
        raise ValueError(f"structure: must be 'auto', 'paper-000' or 'ordered', and is {structure!r}")
    _require('load_N', load_N, 0, 1e5)
    _require('stress_Pa', stress_Pa, 0, 1e10)
    sources: list[tuple[str, str, list[str], list[Any]]] = []
    for i, run in enumerate(runs):
        if isinstance(run, (str, os.PathLike)):
            sources.append((os.fspath(run), os.fspath(run), [], []))
        elif _tables.is_table(run):
            sources.append((f'runs[{i}]', '', *_tables.table(run)))
        else:
            raise TypeError(f'runs[{i}]: must be a file or a table, and is {_tables.described(run)}')
    if not sources:
        raise ValueError('runs: is empty')
    result = _core.identify_runs(
        _wire(start),
        sources,
        name,
        load_N,
        stress_Pa,
        _tables.texts('columns', columns),
        _tables.texts('allow', allow),
        lenient,
        threads,
        circuit,
        structure,
        imposed_strain,
        progress,
    )
    _warn(result['warnings'])
    return Identification(result)


def observers() -> list[str]:
    """The names of the observers that replay() and evaluate() take.

    >>> import smaservo
    >>> smaservo.observers()
    ['kalman', 'open-loop', 'line']
    """
    return _core.observer_names()


def evaluation_rows() -> list[str]:
    """The names of the rows that evaluate() takes."""
    return _core.evaluation_row_names()


def evaluate(
    *,
    units: int = 3,
    runs: int = 0,
    rows: Iterable[str] = (),
    observers: Iterable[str] = ('kalman',),
    programs: Iterable[Path] = (),
    wires: Path | None = None,
    settings: Overrides | None = None,
    seed: int = 1000,
    threads: int = 0,
    progress: Callable[[str, int, int], object] | None = None,
) -> list[dict[str, Any]]:
    """Judges observers by many simulated runs of wires that none knows, as `host-sim evaluate` does.

    Each dict has observer, row, runs, the figures of that row ("mean_percent": error in % of the stroke),
    `missed`, the figures that miss their target, and `families`: a dict for each family of wires
    ("ihyp", "sublayers") with the runs, figures and `missed` of its wires alone. A unit takes a minute to
    calibrate on one core, a run 0.25 s; wires is a folder that keeps calibrated ones. rows is empty for all.
    programs are observers of yours, as `--observer-program`. progress is called
    with the stage, and how much of how much is done. Ctrl-C raises KeyboardInterrupt.
    """
    return _core.evaluate_rows(
        units,
        runs,
        _tables.texts('rows', rows),
        _tables.texts('observers', observers),
        _tables.texts('programs', programs),
        '' if wires is None else os.fspath(wires),
        settings,
        seed,
        threads,
        progress,
    )


def inspect(
    path: Path,
    wire: Path | None = None,
    *,
    settings: Overrides | None = None,
    columns: Iterable[str] = (),
    period_s: float | None = None,
) -> dict[str, Any]:
    """What a file of measurements holds, its mistakes, and what can be done with it, as a dict.

    `python -m smaservo inspect FILE` prints the same as a text. Only with a wire are length, diameter,
    load and power judged.
    """
    import json

    name = None if wire is None else os.fspath(wire)
    _, text, _ = _core.inspect_file(os.fspath(path), name, settings, _tables.texts('columns', columns), period_s)
    facts: list[dict[str, Any]] = json.loads(text)
    return facts[0]
