"""The rows of a rig's loop, read from a table: columns of U, Q and time, their units, and the step
that their digits resolve.

# notation: U relative displacement, Q tangential load
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from reports.scoring.mapping import Mapping, converted, find_column, listed
from reports.units import load_unit, units
from scenes import InputError, Scene
from scenes.array_types import Array
from scenes.column_names import ALIASES, plain
from scenes.measured import ReadAs, layout_in_words, unit_of_column
from scenes.text_tables import TableKind, TextTable, text_table

_SHIFT_NAMES = (
    "U",
    "u",
    "displacement",
    "relative displacement",
    "tangential displacement",
    "shift",
    "slip",
    "U1",
)
_BY_NUMBER = "columns.slip = 1 and columns.tangential_load = 2 of a mapping"
# Rows that show with how many digits numbers are written.
_DIGITS_SEEN = 1000
_FEWEST = 20


@dataclass(frozen=True, eq=False)
class MeasuredLoop:
    """Rows of a rig: `shift` U and `load` Q, (n,) in the units of the scene, `time` (n,) in any.

    `read_as` is how the file was read: each column with its heading, unit and factor. `resolution`
    is the step of U and of Q that the digits of the rows resolve, 0 where they hold every digit.
    """

    source: str
    shift: Array
    load: Array
    time: Array
    read_as: ReadAs = ()
    resolution: tuple[float, float] = (0.0, 0.0)


def read_loop(path: Path, mapping: Mapping, scene: Scene) -> MeasuredLoop:
    """The columns U and Q of a table, and its time if there is one.

    Raises
    ------
    InputError
        As the reader of tables; for a column that is missing or in a unit that can't be turned into
        the scene's, for too few rows.
    """
    table = text_table(
        path,
        kind=TableKind(
            is_known=_is_of_loops,
            example="U,Q",
            keys_by_number=_BY_NUMBER,
            numbered=_is_numbered(mapping),
        ),
    )
    names = table.names
    where = str(path)
    alone = not table.head and len(names) == 2  # the other of two columns without names
    force = find_column(mapping, "tangential_load", names, where, needed=not alone)
    stated = (
        find_column(mapping, "slip", names, where) if mapping.columns.slip is not None else None
    )
    if alone and force is None and stated is not None:
        force = names[1 - names.index(stated)]
    shifts = [name for alias in _SHIFT_NAMES for name in names if plain(name) == plain(alias)]
    shift = stated or next(iter(dict.fromkeys(shifts)), None)
    if alone and shift is None and force is not None:
        shift = names[1 - names.index(force)]
    if shift is None or force is None:
        raise InputError(
            f"{where}: no column for the relative displacement (looked for"
            f" {', '.join(_SHIFT_NAMES[:4])} ...) among {listed(names)}; name it by columns.slip of"
            " a mapping"
        )
    if shift == force:
        raise InputError(
            f"{where}: the mapping takes {shift!r} for U and for Q; state columns.slip and"
            " columns.tangential_load"
        )
    time = find_column(mapping, "time", names, where)
    count = len(table.values)
    if count < _FEWEST:
        raise InputError(
            f"{where}: {count} rows are too few for a loop: at least {_FEWEST} are needed"
        )
    shifts_read = _column_of_loop(where, table, mapping, scene, shift, "slip")
    loads_read = _column_of_loop(where, table, mapping, scene, force, "tangential_load")
    for column in (shifts_read, loads_read):
        if not np.ptp(column.values) > 0:
            raise InputError(f"{where}: {column.name} is the same in every row: there is no loop")
    instants = np.arange(count, dtype=float)
    time_in_words = "no column: rows follow each other evenly"
    if time is not None:
        instants = table.column(time)
        time_in_words = f"{time!r}, as it stands: no result depends on its unit"
    back = np.flatnonzero(np.diff(instants) <= 0)
    if len(back):
        k = int(back[0]) + 1
        raise InputError(
            f"{where}, line {table.lines[k]}: {time} = {instants[k]:.6g} does not ascend: rows"
            " stand in the order of time"
        )
    read_as = layout_in_words(path, table)
    read_as.append(("relative displacement U", shifts_read.words))
    read_as.append(("tangential load Q", loads_read.words))
    read_as.append(("time", time_in_words))
    return MeasuredLoop(
        source=where,
        shift=shifts_read.values,
        load=loads_read.values,
        time=instants - instants[0],
        read_as=tuple(read_as),
        resolution=(shifts_read.step, loads_read.step),
    )


class _ColumnOfLoop(NamedTuple):
    """A column by its name in the file: `values` (n,) and the `step` of its last digit, both in the
    unit of the scene; how it was read, in words.
    """

    name: str
    values: Array
    step: float
    words: str


def _column_of_loop(
    where: str,
    table: TextTable,
    mapping: Mapping,
    scene: Scene,
    name: str,
    quantity: Literal["slip", "tangential_load"],
) -> _ColumnOfLoop:
    """U or Q of a table in the unit of the scene.

    Raises
    ------
    InputError
        For a unit that is not understood, for forces without a thickness, and for forces per length
        with one.
    """
    kind: Literal["length", "load"] = "length" if quantity == "slip" else "load"
    unit_of_scene = units(scene)[1] if kind == "length" else load_unit(scene)
    number = table.names.index(name)
    thickness_stated = kind == "load" and "thickness" in mapping.model_fields_set
    factor_stated = getattr(mapping.factors, kind)
    unit_factor = 1.0
    words = [repr(name)]
    if factor_stated is not None:
        words.append(f"times {factor_stated:.9g} (factors.{kind} of the mapping)")
    else:
        unit = unit_of_column(table, number, kind, scene.units)
        if unit.word == unit_of_scene:  # whatever words the scene has for its units
            in_words = f"{unit.word} (in its heading), times 1"
            unit = replace(unit, factor=1.0, per_length=kind == "load", fault="", words=in_words)
        if thickness_stated and "/" in unit.word:
            raise InputError(
                f"{where}: the column {name!r} is in {unit.word}, a force per length, and the"
                " mapping states a thickness, by which forces are divided: take thickness out of"
                " the mapping, or state factors.load"
            )
        force_alone = kind == "load" and unit.known and not unit.per_length
        if unit.fault or (force_alone and not thickness_stated):
            or_thickness = ""
            if force_alone:
                or_thickness = ", or the thickness of the contact, by which it is divided"
            raise InputError(
                f"{where}: the column {name!r} is in {unit.word}, and the scene in"
                f" {unit_of_scene}: state factors.{kind} in a mapping, by which it is"
                f" multiplied{or_thickness}"
            )
        unit_factor = unit.factor
        words.append(unit.words)
    if thickness_stated:
        words.append(f"over the thickness {mapping.thickness:.9g}")
    if mapping.sign(quantity) < 0:
        words.append("sign turned")
    step = unit_factor * np.array([_step_of_digits(table.values[:, number])])
    return _ColumnOfLoop(
        name=name,
        values=converted(mapping, quantity, unit_factor * table.values[:, number]),
        step=abs(float(converted(mapping, quantity, step)[0])),
        words=", ".join(words),
    )


def _is_of_loops(heading: str) -> bool:
    """Whether a heading is one that a loop's table may have."""
    known = (*_SHIFT_NAMES, *ALIASES["tangential_load"], *ALIASES["time"])
    return plain(heading) in {plain(alias) for alias in known}


def _is_numbered(mapping: Mapping) -> bool:
    """Whether the mapping takes U or Q by the number of its column."""
    return isinstance(mapping.columns.slip, int) or isinstance(mapping.columns.tangential_load, int)


def _step_of_digits(values: Array) -> float:
    """The step of the last digit that rows (n,) are written with; of most of them, since zeros at
    the end do not show.

    >>> (
    ...     _step_of_digits(np.array([0.25, 0.3, -0.17])),
    ...     _step_of_digits(np.array([12.0, 1500.0, 7.0])),
    ... )
    (0.01, 1.0)
    """
    places = [
        int(Decimal(repr(value)).normalize().as_tuple().exponent)
        for value in values[:_DIGITS_SEEN].tolist()
    ]
    return float(10.0 ** int(np.floor(np.median(places)))) if places else 0.0
