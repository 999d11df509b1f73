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

from reports.scoring.mapping import Mapping, converted_values, name_of_column, names_in_words
from reports.units import load_unit, units
from scenes import InputError, Scene
from scenes.array_types import Array
from scenes.column_names import ALIASES, normalised_name
from scenes.measured import ReadAs, layout_in_words, unit_of_column
from scenes.text_tables import TableKind, TextTable, text_table

_DISPLACEMENT_NAMES = (
    "U",
    "u",
    "displacement",
    "relative displacement",
    "tangential displacement",
    "shift",
    "slip",
    "U1",
)
_KEYS_BY_NUMBER = "columns.slip = 1 and columns.tangential_load = 2 of a mapping"
# Rows, from the first on, that show with how many digits numbers are written.
_MOST_ROWS_FOR_DIGITS = 1000
_FEWEST_ROWS = 20


@dataclass(frozen=True, eq=False)
class MeasuredLoop:
    """Rows of a rig, as they were read from a file (`source`).

    displacement, load : (n,) relative displacement U and tangential load Q in the units of the
        scene
    time : (n,) in any unit
    read_as : how the file was read: each column with its heading, unit and factor
    resolution : step of U and of Q that the digits of the rows resolve, 0 where they hold all
        digits
    """

    source: str
    displacement: Array
    load: Array
    time: Array
    read_as: ReadAs = ()
    resolution: tuple[float, float] = (0.0, 0.0)


def read_loop(path: Path, mapping: Mapping, scene: Scene) -> MeasuredLoop:
    """Read a measured loop of Q over U from a text table: relative displacement U and tangential
    load Q in the units of the scene, time as the file has it, with words on how each column was
    read. Without a column of time the rows follow each other evenly. `mapping` states columns,
    units and signs where the file does not.

    Raises
    ------
    InputError
        For a file that is no table of numbers; for a column that is missing, constant, or in a unit
        that can't be turned into the scene's; for fewer than 20 rows; for a time that does not
        ascend.
    """
    # names of columns, values (n_rows, n_columns), line of each row in the file; TableKind: which
    # headings are expected, and words for messages
    table = text_table(
        path,
        kind=TableKind(
            is_expected_heading=_is_known_heading,
            example="U,Q",
            keys_by_number=_KEYS_BY_NUMBER,
            may_lack_headings=_takes_columns_by_number(mapping),
        ),
    )
    file_name = str(path)
    displacement_name, load_name = _names_of_columns(table, mapping, file_name)
    time_name = name_of_column(mapping, "time", table.names, file_name)
    n_rows = len(table.values)
    if n_rows < _FEWEST_ROWS:
        raise InputError(
            f"{file_name}: {n_rows} rows are too few for a loop: at least {_FEWEST_ROWS} are needed"
        )
    # values in the scene's unit, step of their last digit, and how they were read
    displacement_column = _column_of_loop(
        file_name, table, mapping, scene, displacement_name, "slip"
    )
    load_column = _column_of_loop(file_name, table, mapping, scene, load_name, "tangential_load")
    for column in (displacement_column, load_column):
        if not np.ptp(column.values) > 0:
            raise InputError(
                f"{file_name}: {column.name} is the same in every row: there is no loop"
            )
    times, time_in_words = _ascending_times(file_name, table, time_name)
    # pairs (subject, words), first on the layout of the table
    read_as = layout_in_words(path, table)
    read_as.append(("relative displacement U", displacement_column.reading_words))
    read_as.append(("tangential load Q", load_column.reading_words))
    read_as.append(("time", time_in_words))
    return MeasuredLoop(
        source=file_name,
        displacement=displacement_column.values,
        load=load_column.values,
        time=times - times[0],
        read_as=tuple(read_as),
        resolution=(displacement_column.digit_step, load_column.digit_step),
    )


def _ascending_times(file_name: str, table: TextTable, time_name: str | None) -> tuple[Array, str]:
    """Times of the rows of a loop, (n_rows,), from the column `time_name`, and words on how they
    were read. Where that is None they are the numbers of the rows, from 0 on. InputError, naming
    the file and the line, where a time does not ascend.
    """
    if time_name is None:
        times = np.arange(len(table.values), dtype=float)
        return times, "no column: rows follow each other evenly"
    times = table.column(time_name)
    rows_before_fall = np.flatnonzero(np.diff(times) <= 0)
    if len(rows_before_fall):
        row_of_fall = int(rows_before_fall[0]) + 1
        raise InputError(
            f"{file_name}, line {table.line_numbers[row_of_fall]}: {time_name} ="
            f" {times[row_of_fall]:.6g} does not ascend: rows stand in the order of time"
        )
    return times, f"{time_name!r}, as it stands: no result depends on its unit"


class _ColumnOfLoop(NamedTuple):
    """A column by its name in the file: its `values` (n,) and the step of their last digit, both in
    the unit of the scene; how it was read, in words.
    """

    name: str
    values: Array
    digit_step: float
    reading_words: str


def _names_of_columns(table: TextTable, mapping: Mapping, file_name: str) -> tuple[str, str]:
    """Names of the columns of U and of Q in the table of a loop: by the mapping, or by known names.
    Where the mapping states one of two columns without headings, the other quantity has the other
    column.

    Raises
    ------
    InputError
        Where there is no column for U or Q, or one for both.

    # notation: Q tangential load, U relative tangential displacement
    """
    names = table.names
    has_two_nameless_columns = not table.heading_line_number and len(names) == 2
    load_name = name_of_column(
        mapping, "tangential_load", names, file_name, is_needed=not has_two_nameless_columns
    )
    stated_displacement_name = (
        name_of_column(mapping, "slip", names, file_name)
        if mapping.columns.slip is not None
        else None
    )
    if has_two_nameless_columns and load_name is None and stated_displacement_name is not None:
        load_name = names[1 - names.index(stated_displacement_name)]
    # normalised: spellings of one name compare equal
    known_names = [
        name
        for alias in _DISPLACEMENT_NAMES
        for name in names
        if normalised_name(name) == normalised_name(alias)
    ]
    displacement_name = stated_displacement_name or next(iter(known_names), None)
    if has_two_nameless_columns and displacement_name is None and load_name is not None:
        displacement_name = names[1 - names.index(load_name)]
    if displacement_name is None or load_name is None:
        raise InputError(
            f"{file_name}: no column for the relative displacement (looked for"
            f" {', '.join(_DISPLACEMENT_NAMES[:4])} ...) among {names_in_words(names)}; name it by"
            " columns.slip of a mapping"
        )
    if displacement_name == load_name:
        raise InputError(
            f"{file_name}: the mapping takes {displacement_name!r} for U and for Q; state"
            " columns.slip and columns.tangential_load"
        )
    return displacement_name, load_name


def _column_of_loop(
    file_name: str,
    table: TextTable,
    mapping: Mapping,
    scene: Scene,
    name: str,
    quantity: Literal["slip", "tangential_load"],
) -> _ColumnOfLoop:
    """One column of the table of a measured loop, U or Q: its values in the unit of the scene, the
    step of their last digit, and in words how it was read: factor, thickness and sign, by the
    mapping or by the unit in its heading.

    Parameters
    ----------
    file_name
        for messages
    name
        name of the column in the table
    quantity
        "slip" for U, "tangential_load" for Q, as a mapping calls them

    Raises
    ------
    InputError
        For a unit that is not understood, for forces without a thickness, and for forces per length
        with one.

    # notation: Q tangential load, U relative tangential displacement
    """
    # which factor of the mapping holds for the quantity, None where it states none
    factor_name: Literal["length", "load"] = "length" if quantity == "slip" else "load"
    stated_factor = getattr(mapping.factors, factor_name)
    if stated_factor is not None:
        unit_factor = 1.0
        words_on_unit = f"times {stated_factor:.9g} (factors.{factor_name} of the mapping)"
    else:
        unit_factor, words_on_unit = _factor_by_heading(
            file_name, table, mapping, scene, name, factor_name
        )
    reading_words = [repr(name), words_on_unit]
    if _states_thickness(mapping, factor_name):
        reading_words.append(f"over the thickness {mapping.thickness:.9g}")
    # 1, or -1 where the file has the opposite sign
    if mapping.sign(quantity) < 0:
        reading_words.append("sign turned")
    file_values = table.values[:, table.names.index(name)]
    # the mapping's factor, thickness and sign hold for the values and for the step of their digits
    values = converted_values(mapping, quantity, unit_factor * file_values)
    digit_step = unit_factor * np.array([_step_of_digits(file_values)])
    return _ColumnOfLoop(
        name=name,
        values=values,
        digit_step=abs(float(converted_values(mapping, quantity, digit_step)[0])),
        reading_words=", ".join(reading_words),
    )


def _states_thickness(mapping: Mapping, factor_name: Literal["length", "load"]) -> bool:
    """Whether a mapping states a thickness by which the values of a column are divided: only loads
    are. `model_fields_set` are the keys that the mapping file states.
    """
    return factor_name == "load" and "thickness" in mapping.model_fields_set


def _factor_by_heading(
    file_name: str,
    table: TextTable,
    mapping: Mapping,
    scene: Scene,
    name: str,
    factor_name: Literal["length", "load"],
) -> tuple[float, str]:
    """Factor from the unit in the heading of a column to that of the scene, and words on it.

    Parameters
    ----------
    file_name
        for messages
    table, name
        the table of the loop, and the name of its column
    factor_name
        "length" for a displacement, "load" for a load, as factors of a mapping are called

    Raises
    ------
    InputError
        For a unit that is not understood, for forces without a thickness, and for forces per length
        with one.
    """
    is_load = factor_name == "load"
    has_thickness = _states_thickness(mapping, factor_name)
    _, unit_of_length, _ = units(scene)
    unit_of_scene = load_unit(scene) if is_load else unit_of_length
    # unit: word in the heading, factor to the scene's unit, whether it is per length, what is
    # wrong with it (`fault`), and a phrase on it (`remark`)
    unit = unit_of_column(table, table.names.index(name), factor_name, scene.units)
    if unit.word == unit_of_scene:  # whatever words the scene has for its units
        words_on_unit = f"{unit.word} (in its heading), times 1"
        unit = replace(unit, factor=1.0, is_per_length=is_load, fault="", remark=words_on_unit)
    if has_thickness and "/" in unit.word:
        raise InputError(
            f"{file_name}: the column {name!r} is in {unit.word}, a force per length, and the"
            " mapping states a thickness, by which forces are divided: take thickness out of"
            " the mapping, or state factors.load"
        )
    is_plain_force = is_load and unit.is_known and not unit.is_per_length
    if unit.fault or (is_plain_force and not has_thickness):
        hint_on_thickness = ""
        if is_plain_force:
            hint_on_thickness = ", or the thickness of the contact, by which it is divided"
        raise InputError(
            f"{file_name}: the column {name!r} is in {unit.word}, and the scene in"
            f" {unit_of_scene}: state factors.{factor_name} in a mapping, by which it is"
            f" multiplied{hint_on_thickness}"
        )
    return unit.factor, unit.remark


def _is_known_heading(heading: str) -> bool:
    """Whether a heading is one that a loop's table may have."""
    aliases = (*_DISPLACEMENT_NAMES, *ALIASES["tangential_load"], *ALIASES["time"])
    return normalised_name(heading) in {normalised_name(alias) for alias in aliases}


def _takes_columns_by_number(mapping: Mapping) -> bool:
    """Whether the mapping takes U or Q by the number of its column."""
    return isinstance(mapping.columns.slip, int) or isinstance(mapping.columns.tangential_load, int)


def _step_of_digits(values: Array) -> float:
    """The step of the last decimal digit with which numbers (n,) were written, 0.01 for 0.25; 0 for
    no numbers. The median of the first 1,000 counts, since zeros at the end do not show; where it
    lies between two digits, the finer one.

    >>> (
    ...     _step_of_digits(np.array([0.25, 0.3, -0.17])),
    ...     _step_of_digits(np.array([12.0, 1500.0, 7.0])),
    ... )
    (0.01, 1.0)
    """
    exponents = [
        int(Decimal(repr(value)).normalize().as_tuple().exponent)
        for value in values[:_MOST_ROWS_FOR_DIGITS].tolist()
    ]
    if not exponents:
        return 0.0
    return float(10.0 ** int(np.floor(np.median(exponents))))
