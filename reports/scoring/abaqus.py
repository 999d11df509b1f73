"""Abaqus `Report > Field Output` files (.rpt): blocks of nodal values, one a part and frame, to one
row for each instant and node.

Laid out after reports that users of Abaqus have published; no Abaqus was run here. Reports of XY
data are plain tables: `reading`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from reports.scoring.mapping import (
    ColumnQuantity,
    Mapping,
    converted_values,
    name_of_column,
    names_in_words,
)
from scenes import InputError
from scenes.array_types import Array
from scenes.column_names import normalised_name
from scenes.errors import shortened_repr
from scenes.files import LARGEST_TEXT_BYTES, require_readable_size

if TYPE_CHECKING:
    import pandas as pd

_TITLE = "Field Output Report"
_HEADER = re.compile(
    r"\s*(?:Step:\s*(?P<step>.+?)|Frame:\s*(?P<frame>.+?)"
    r"|Field Output reported at (?P<location>.+?) for "
    r"(?:part|region|element set|node set|set|surface):\s*(?P<region>.+?))\s*$"
)
_TIME_IN_FRAME = re.compile(
    r"(?:Step )?Time\s*=\s*(?P<time>[-+]?\d+\.?\d*(?:[eE][-+]?\d{1,2})?)(?!\S)"
)
_MOST_CHARACTERS_OF_LINE = 100_000  # of a line
_MOST_ROWS = 2_000_000
# Nodes of a flat face differ in height by round-off: by at most this fraction of the extent in x,
# plus this length.
_RELATIVE_TOLERANCE_OF_FLATNESS = 1e-6
_LEAST_TOLERANCE_OF_FLATNESS = 1e-9


@dataclass(frozen=True, eq=False)
class _ReportTable:
    """A table of a report: values of one region (a part or a surface) at one frame (an instant).

    Attributes
    ----------
    step, frame
        texts of the report that name the frame
    location
        where in elements the values were taken: nodes, centroids, ...
    region
        name of the part or surface
    names
        names of the columns
    values
        (n_rows, n_columns)
    line
        number of the line of dashes above the table
    """

    step: str
    frame: str
    location: str
    region: str
    names: list[str]
    values: Array
    line: int

    def column(self, name: str) -> Array:
        """The values of one column, (n_rows,)."""
        return self.values[:, self.names.index(name)]


def is_field_report(path: Path) -> bool:
    """Whether a file begins as a report of field output does."""
    with path.open("rb") as stream:
        return _TITLE.encode() in stream.read(4096)


def read_field_report(
    path: Path, mapping: Mapping
) -> tuple[dict[ColumnQuantity, Array], list[str]]:
    """Pressure, shear, slip, x, frame and time of an Abaqus field report, one row for each frame
    (instant) and node of the contact surface, in the scene's units and this program's signs; and
    notes.

    A report may hold nodes within the bodies. The contact surface is that of the nodes with a
    pressure in some frame and, where the report has y, of all nodes on the same flat face.
    `mapping` states columns, units and signs of the file.

    Raises
    ------
    InputError
        One sentence with file, line, value and rule: for values that are not nodal, no places,
        several surfaces in contact.
    """
    # InputError for a file that is too large
    require_readable_size(
        path, "the result", LARGEST_TEXT_BYTES, "write the contact surface alone, and fewer frames"
    )
    # tables, each of one region (part or surface) and one frame
    blocks = list(_tables_of_report(path))
    if not blocks:
        raise InputError(
            f"{path}: the report holds no table of values below a line of dashes; report CPRESS,"
            " CSHEAR and COORD"
        )
    for block in blocks:
        if "node" not in block.location:
            raise InputError(
                f"{path}, line {block.line}: its values are reported at {block.location}; report"
                " them at unique nodal positions"
            )
    # the one part or surface that carries pressure
    region = _region_with_pressure(path, blocks, mapping)
    blocks_of_region = [block for block in blocks if block.region == region]
    frames = {(block.step, block.frame) for block in blocks_of_region}
    notes = [f"the nodal values of {region} were taken, at {len(frames)} frames"]
    return _surface_columns(path, blocks_of_region, mapping, notes), notes


def _region_with_pressure(path: Path, blocks: Sequence[_ReportTable], mapping: Mapping) -> str:
    """Name of the one region (part or surface) of an Abaqus report that carries pressure; where
    several do, the one that the mapping names (`mapping.surface`, else None). `blocks` are the
    report's tables, each of one `region`. InputError where none does, where several do and the
    mapping names none, or where it names one that is not there.
    """
    regions = {block.region for block in blocks}
    if mapping.surface is not None and mapping.surface not in regions:
        raise InputError(
            f"{path}: the mapping says surface = {mapping.surface!r}, and it reports"
            f" {names_in_words(sorted(regions))}"
        )
    loaded_regions = set()
    for block in blocks:
        # name of the column of the pressure, None where the table has none
        name = name_of_column(mapping, "pressure", block.names, str(path))
        is_chosen = mapping.surface in (None, block.region)
        if is_chosen and name is not None and np.any(block.column(name)):
            loaded_regions.add(block.region)
    if not loaded_regions:
        columns_in_words = names_in_words(
            list(dict.fromkeys(name for block in blocks for name in block.names))
        )
        raise InputError(
            f"{path}: no pressure that is not zero everywhere (looked for CPRESS) among"
            f" {columns_in_words}"
        )
    if len(loaded_regions) > 1:
        raise InputError(
            f"{path}: {names_in_words(sorted(loaded_regions))} carry pressure, master and slave"
            " perhaps: say which by surface of a mapping"
        )
    (region,) = loaded_regions
    return region


def _surface_columns(
    path: Path, blocks: Sequence[_ReportTable], mapping: Mapping, notes: list[str]
) -> dict[ColumnQuantity, Array]:
    """Pressure, shear, slip, x, frame and time of an Abaqus report, as far as it has them: one row
    for each frame and each node on the contact surface, in the scene's units and this program's
    signs.

    Parameters
    ----------
    blocks
        the report's tables, each of one frame (an instant), which the texts `step` and `frame` name
    mapping
        columns, units and signs that are stated of the file
    notes
        list to which sentences are added, on what was left out
    """
    frames = list(dict.fromkeys((block.step, block.frame) for block in blocks))
    # pandas table: a row for each frame and node with a pressure; "frame": index of the frame
    rows = _rows_of_nodes(path, blocks, mapping, frames)
    is_in_first_frame = rows["frame"] == rows["frame"].iloc[0]
    is_on_surface = _is_on_contact_surface(rows)
    n_left_out = int(np.sum(~is_on_surface & is_in_first_frame))
    if n_left_out:
        notes.append(f"{n_left_out} nodes that do not lie on the contact surface were left out")
    surface_quantities: tuple[ColumnQuantity, ...] = ("x", "pressure", "shear", "slip", "frame")
    surface_columns = {
        name: converted_values(mapping, name, rows[name][is_on_surface].to_numpy())
        for name in surface_quantities
        if name in rows
    }
    times = _times_of_frames(frames)
    if times is not None:
        frame_index_of_row = surface_columns["frame"].astype(int)
        surface_columns["time"] = converted_values(mapping, "time", times)[frame_index_of_row]
    elif len(frames) > 1:
        n_steps = len({step for step, _ in frames})
        notes.append(
            f"its frames are of {n_steps} steps, whose times start again: they were numbered in"
            " the order of the report"
        )
    return surface_columns


def _times_of_frames(frames: Sequence[tuple[str, str]]) -> Array | None:
    """Times that the texts of the frames of an Abaqus report state, in the file's unit. None where
    a text states none, or where frames are of several steps, in each of which time starts again.
    `frames` are texts of the step and of the frame.
    """
    has_one_step = len({step for step, _ in frames}) == 1
    time_matches = [_TIME_IN_FRAME.search(frame_text) for _, frame_text in frames]
    if not (has_one_step and all(time_matches)):
        return None
    return np.array([float(match["time"]) for match in time_matches if match])


def _rows_of_nodes(
    path: Path, blocks: Sequence[_ReportTable], mapping: Mapping, frames: Sequence[tuple[str, str]]
) -> pd.DataFrame:
    """One table of an Abaqus report with a row for each frame and each node that has a pressure.
    Its columns are pressure, x, as far as reported shear, slip and y, and "frame", the index of the
    frame in `frames`. Its index is the node's label, or where the report has none the number of the
    row in its table.

    `blocks` are the report's tables, each of one frame. Coordinates may stand in tables of their
    own, once for all frames. InputError where a node has none. `mapping` states the names of
    columns.
    """
    import pandas as pd

    # NaN in the columns that a block lacks, and nowhere else
    all_values = pd.concat(
        [
            _values_of_block(path, block, mapping).assign(
                frame=float(frames.index((block.step, block.frame)))
            )
            for block in blocks
        ]
    )
    if "x" not in all_values:
        raise InputError(
            f"{path}: the nodes of {blocks[0].region} have no places: report COORD with COORD1"
            " beside CPRESS"
        )
    # the last coordinates of each node are taken for all its frames
    coordinates = all_values[all_values.columns.intersection(["x", "y"])].groupby(level=0).last()
    rows_with_pressure = all_values.drop(columns=coordinates.columns).dropna(subset="pressure")
    rows = rows_with_pressure.dropna(axis=1).join(coordinates)
    nodes_without_x = rows.index[rows["x"].isna()]
    if len(nodes_without_x):
        raise InputError(
            f"{path}: node {nodes_without_x[0]:.0f} has a pressure and no place; report COORD"
            " for the same nodes"
        )
    return rows


def _values_of_block(path: Path, block: _ReportTable, mapping: Mapping) -> pd.DataFrame:
    """One table of an Abaqus report with a row for each node, and the columns x, y, pressure, shear
    and slip, as far as it has them. Its index is the node's label, or where the report has none the
    number of the row. `mapping` states the names of columns.
    """
    import pandas as pd

    quantities: tuple[ColumnQuantity, ...] = ("x", "y", "pressure", "shear", "slip")
    columns = {}
    for quantity in quantities:
        # column that holds the quantity, None where the table has none
        name = name_of_column(mapping, quantity, block.names, str(path))
        if name is not None:
            columns[quantity] = block.column(name)
    node_labels = np.arange(float(len(block.values)))
    for name in block.names:
        if normalised_name(name) == "nodelabel":
            node_labels = block.column(name)
            break
    table_of_nodes = pd.DataFrame(columns)
    table_of_nodes.index = pd.Index(node_labels)
    return table_of_nodes


def _is_on_contact_surface(rows: pd.DataFrame) -> pd.Series[bool]:
    """Whether each row of an Abaqus report, of a node and frame, is of a node on the contact
    surface.

    These are the nodes with a pressure in some frame. If those lie on one flat face, they are all
    nodes of that face. Without y they are all nodes, if no two of them have the same x: then the
    surface alone was reported. `rows` has the columns pressure, frame, x and maybe y.
    """
    is_on_surface = (rows["pressure"] != 0).groupby(level=0).transform("any")
    is_in_first_frame = rows["frame"] == rows["frame"].iloc[0]
    if "y" in rows:
        # a millionth of the extent in x, plus 1e-9
        tolerance = _LEAST_TOLERANCE_OF_FLATNESS + _RELATIVE_TOLERANCE_OF_FLATNESS * np.ptp(
            rows["x"]
        )
        heights = rows["y"][is_on_surface]
        is_flat = np.ptp(heights) <= tolerance
        if is_flat:
            return np.abs(rows["y"] - heights.median()) <= tolerance
    elif rows["x"][is_in_first_frame].is_unique:
        return is_on_surface | True
    return is_on_surface


def _tables_of_report(path: Path) -> Iterator[_ReportTable]:
    """The tables of an Abaqus report that have rows, in its order; each with its step, its frame,
    the location of its values (nodes, centroids) and its region, from the lines above it.

    A table begins below a line of dashes and ends at an empty line. Its columns are named by the
    headings above the dashes.
    """
    header_values = dict.fromkeys(("step", "frame", "location", "region"), "")
    lines_above: list[str] = []  # lines since the last empty one: headings, if dashes come
    names: list[str] = []
    rows: list[list[float]] = []
    line_number_of_dashes = 0  # 0 while none has been passed
    row_count = 0
    for line_number, line in _numbered_lines(path):
        if line_number_of_dashes and line:  # a row of the table
            row_count += 1
            if row_count > _MOST_ROWS:
                raise InputError(
                    f"{path}: more than {_MOST_ROWS:,} rows; report the contact surface alone"
                )
            names = names or _column_names_above(line, lines_above)
            rows.append(_numbers_in_row(f"{path}, line {line_number}", line, names))
        elif rows:  # the end of the table
            yield _ReportTable(
                **header_values, names=names, values=np.array(rows), line=line_number_of_dashes
            )
            lines_above = []
            names = []
            rows = []
            line_number_of_dashes = 0
        elif not line:
            lines_above = lines_above if line_number_of_dashes else []
        elif re.fullmatch(r"\s*-{12,}", line) and lines_above:
            line_number_of_dashes = line_number
        else:
            lines_above.append(line)
            # a line that states step, frame, location or region
            header_match = _HEADER.match(line)
            if header_match:
                header_words = header_match.groupdict()
                header_values |= {
                    key: value for key, value in header_words.items() if value is not None
                }


def _numbered_lines(path: Path) -> Iterator[tuple[int, str]]:
    """The lines of a report, numbered from 1, without blanks at their ends; then an empty one.
    InputError for a line that is too long for a report, of more than 100,000 characters.
    """
    with path.open(encoding="utf-8", errors="replace") as stream:
        lines = iter(lambda: stream.readline(_MOST_CHARACTERS_OF_LINE + 1), "")
        for line_number, line in enumerate(chain(lines, [""]), 1):
            if len(line) > _MOST_CHARACTERS_OF_LINE:
                raise InputError(
                    f"{path}, line {line_number}: more than {_MOST_CHARACTERS_OF_LINE:,} characters"
                    " are no row of a report"
                )
            yield line_number, line.rstrip()


def _column_names_above(row: str, lines_above: list[str]) -> list[str]:
    """The names of the columns of a table in an Abaqus report, from the `lines_above` it: each
    heading ends where the numbers of its column end in the first `row`.
    """
    ends = [0, *(cell.end() for cell in re.finditer(r"\S+", row))]
    names = []
    for begin, end in pairwise(ends):
        words_in_column = [line[begin:end].strip() for line in lines_above]
        words = [word for word in words_in_column if word and not word.startswith("@Loc")]
        names.append(_name_in_heading(" ".join(words)))
    return names


def _numbers_in_row(place: str, row: str, names: list[str]) -> list[float]:
    """The numbers in a `row` of an Abaqus report, one for each of the columns `names`. InputError
    for another count and for a number that is not finite; its message begins with `place`, file and
    line.
    """
    cells = row.split()
    if len(cells) != len(names):
        raise InputError(
            f"{place}: {len(names)} values ({', '.join(names[:6])}) are needed, not"
            f" {shortened_repr(row)}"
        )
    numbers = []
    for name, cell in zip(names, cells, strict=True):
        try:
            number = float(cell)
        except ValueError:
            number = np.nan
        if not np.isfinite(number):
            raise InputError(f"{place}: {name} = {shortened_repr(cell)} is not a finite number")
        numbers.append(number)
    return numbers


def _name_in_heading(heading: str) -> str:
    """The name of the quantity in a heading of a report, without the field and the region.

    >>> (
    ...     _name_in_heading("COORD.COORD1"),
    ...     _name_in_heading("CPRESS   ASSEMBLY_PAD/ASSEMBLY_BLOCK"),
    ...     _name_in_heading("Node Label"),
    ...     _name_in_heading("S.S22"),
    ... )
    ('COORD1', 'CPRESS', 'Node Label', 'S22')
    """
    if heading.lower().startswith("node"):
        return heading
    first_word = (heading.split() or [""])[0]
    return first_word.rpartition(".")[2]
