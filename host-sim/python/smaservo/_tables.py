"""Columns of numbers: what the functions for whole traces take and give."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    import pandas as pd  # type: ignore[import]

    Floats = npt.NDArray[np.float64]

# Health of an estimate by its number in the column `health`.
HEALTH = ('good', 'searching', 'doubtful')


class Columns(dict[str, Any]):
    """A dict of columns, which are attributes as well: `result.strain` is `result["strain"]`."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f'there is no column {name}; there are: {", ".join(self)}') from None

    def to_dataframe(self) -> pd.DataFrame:
        """The columns as a pandas DataFrame."""
        import pandas

        return pandas.DataFrame(dict(self))

    def __repr__(self) -> str:
        rows = len(next(iter(self.values()), ()))
        return f'<smaservo.{type(self).__name__}: {rows} rows of {", ".join(self)}>'


class Estimates(Columns):
    """What replay() gives: an observer's estimate for each row.

    `resistance_ohm` is the measured one, NaN where `valid` is false; `health` is an index into
    smaservo.HEALTH. `restarts` counts how often the observer started again, after gaps of more than a
    minute.
    """

    time_s: Floats
    strain: Floats
    strain_sd: Floats
    temperature_K: Floats
    martensite: Floats
    r_phase: Floats
    resistance_ohm: Floats
    resistance_model_ohm: Floats
    valid: npt.NDArray[np.bool_]
    health: npt.NDArray[np.uint8]

    restarts: int = 0


class Simulation(Columns):
    """What simulate() gives: the wire at each instant, and the voltage over it."""

    time_s: Floats
    current_A: Floats
    voltage_V: Floats
    load_N: Floats
    strain: Floats
    resistance_ohm: Floats
    temperature_K: Floats
    martensite: Floats
    r_phase: Floats


class Recording(Columns):
    """What read() gives: the columns of a file, in SI, by the names that replay() takes.

    Columns that are not understood keep their name; they are numbers (NaN where a field is empty) or
    texts. The attribute `notes` says how the file was read: `read_as`, `hints`, `skipped` (rows, if
    lenient), `complaints`, `clock_notes`, `repeated_headers`, `strays`.
    """

    notes: Mapping[str, Any] = {}


def is_table(data: object) -> bool:
    """Whether this is columns by name: a dict, a DataFrame."""
    return hasattr(data, 'keys') and hasattr(data, '__getitem__')


def described(values: object) -> str:
    return f'{type(values).__name__}'


def numbers(name: str, values: object, rows: int | None = None) -> Floats:
    """The values as contiguous float64; a scalar is repeated `rows` times, where rows are given."""
    import numpy as np

    array = np.asarray(values)
    if array.dtype.kind not in 'iuf':
        raise TypeError(f'{name}: must be numbers, and is {described(values)} of {array.dtype}')
    if array.ndim == 0 and rows is not None:
        array = np.broadcast_to(array, rows)
    if array.ndim != 1:
        raise ValueError(f'{name}: must have one dimension, and has {array.ndim}')
    if array.size == 0:
        raise ValueError(f'{name}: is empty')
    if rows is not None and array.size != rows:
        raise ValueError(f'{name}: has {array.size} values, time_s has {rows}')
    return np.ascontiguousarray(array, dtype=np.float64)


def table(data: Any) -> tuple[list[str], list[Floats]]:
    """Names and arrays of columns; a column that is no numbers becomes an empty array."""
    import numpy as np

    names: list[str] = []
    arrays: list[Floats] = []
    rows: tuple[str, int] | None = None
    for key in data.keys():
        array = np.asarray(data[key])
        if array.ndim != 1:
            raise ValueError(f'{key}: must have one dimension, and has {array.ndim}')
        if array.size == 0:
            raise ValueError(f'{key}: is empty')
        rows = rows or (str(key), array.size)
        if array.size != rows[1]:
            raise ValueError(f'{key}: has {array.size} values, {rows[0]} has {rows[1]}')
        names.append(str(key))
        is_number = array.dtype.kind in 'biuf'
        arrays.append(np.ascontiguousarray(array if is_number else array[:0].astype('U'), dtype=np.float64))
    if not names:
        raise ValueError('data: has no columns')
    return names, arrays


def texts(name: str, values: object) -> list[str]:
    """A list of texts; one text by itself is a mistake that would be taken letter by letter."""
    if isinstance(values, str) or not hasattr(values, '__iter__'):
        raise TypeError(f'{name}: must be a list of texts, and is {values!r}')
    return [str(value) for value in values]


def columns_of(kind: type[Columns], columns: dict[str, Any]) -> Any:
    """The columns that the extension module gives; its lists of texts become arrays."""
    import numpy as np

    return kind({name: np.array(values) if isinstance(values, list) else values for name, values in columns.items()})
