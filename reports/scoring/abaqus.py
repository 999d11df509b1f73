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

from reports.scoring.mapping import Mapping, Quantity, converted, find_column, listed
from scenes import InputError
from scenes.array_types import Array
from scenes.column_names import plain
from scenes.errors import shown
from scenes.files import TEXT, check_size

if TYPE_CHECKING:
    import pandas as pd

_TITLE = "Field Output Report"
_HEADER = re.compile(
    r"\s*(?:Step:\s*(?P<step>.+?)|Frame:\s*(?P<frame>.+?)|Field Output reported at (?P<where>.+?)"
    r" for "
    r"(?:part|region|element set|node set|set|surface):\s*(?P<region>.+?))\s*$"
)
_TIME = re.compile(r"(?:Step )?Time\s*=\s*(?P<time>[-+]?\d+\.?\d*(?:[eE][-+]?\d{1,2})?)(?!\S)")
_LONGEST = 100_000  # characters of a line
_MOST_ROWS = 2_000_000
# Rounding of the height of a flat face: a share of the extent in x, and at least this [length].
_FLAT = 1e-6
_ZERO = 1e-9


@dataclass(frozen=True, eq=False)
class _Block:
    """Nodal values of one region at one frame, (n_rows, n_columns), below the dashes of a line."""

    step: str
    frame: str
    where: str
    region: str
    names: list[str]
    values: Array
    line: int

    def column(self, name: str) -> Array:
        """(n_rows,) of one quantity."""
        return self.values[:, self.names.index(name)]


def is_field_report(path: Path) -> bool:
    """Whether a file begins as a report of field output does."""
    with path.open("rb") as stream:
        return _TITLE.encode() in stream.read(4096)


def read_field_report(path: Path, mapping: Mapping) -> tuple[dict[Quantity, Array], list[str]]:
    """Quantities of an Abaqus field report, one row for each frame and node of the contact surface,
    in the scene's units and our signs; and notes.

    Nodes of both bodies, or within them, carry no pressure: those that ever do are taken, and those
    beside them on the same face where the report has y. `mapping` states columns, units and signs
    of the file.

    Raises
    ------
    InputError
        One sentence with file, line, value and rule: for values that are not nodal, no places,
        several surfaces in contact.
    """
    check_size(path, "the result", TEXT, "write the contact surface alone, and fewer frames")
    blocks = list(_blocks(path))
    if not blocks:
        raise InputError(
            f"{path}: the report holds no table of values below a line of dashes; report CPRESS,"
            " CSHEAR and COORD"
        )
    for block in blocks:
        if "node" not in block.where:
            raise InputError(
                f"{path}, line {block.line}: its values are reported at {block.where}; report them"
                " at unique nodal positions"
            )
    region = _region_with_pressure(path, blocks, mapping)
    blocks_of_region = [block for block in blocks if block.region == region]
    frames = {(block.step, block.frame) for block in blocks_of_region}
    notes = [f"the nodal values of {region} were taken, at {len(frames)} frames"]
    return _columns(path, blocks_of_region, mapping, notes), notes


def _region_with_pressure(path: Path, blocks: Sequence[_Block], mapping: Mapping) -> str:
    """Name of the one region (surface) of an Abaqus report that carries pressure; where several do,
    the one that the mapping names. `blocks` are the report's tables.
    """
    regions = {block.region for block in blocks}
    if mapping.surface is not None and mapping.surface not in regions:
        raise InputError(
            f"{path}: the mapping says surface = {mapping.surface!r}, and it reports"
            f" {listed(sorted(regions))}"
        )
    loaded_regions = set()
    for block in blocks:
        name = find_column(mapping, "pressure", block.names, str(path))
        is_chosen = mapping.surface in (None, block.region)
        if is_chosen and name is not None and np.any(block.column(name)):
            loaded_regions.add(block.region)
    if not loaded_regions:
        names = listed(list(dict.fromkeys(name for block in blocks for name in block.names)))
        raise InputError(
            f"{path}: no pressure that is not zero everywhere (looked for CPRESS) among {names}"
        )
    if len(loaded_regions) > 1:
        raise InputError(
            f"{path}: {listed(sorted(loaded_regions))} carry pressure, master and slave perhaps:"
            " say which by surface of a mapping"
        )
    (region,) = loaded_regions
    return region


def _columns(
    path: Path, blocks: Sequence[_Block], mapping: Mapping, notes: list[str]
) -> dict[Quantity, Array]:
    """Pressure, shear, slip, x, frame and time of a report, one row for each frame and each node on
    the contact surface, in the scene's units and signs.

    Parameters
    ----------
    mapping
        stated columns, units and signs of the file
    blocks
        the report's tables, each of one frame
    notes
        gets a sentence on what was left out
    """
    frames = list(dict.fromkeys((block.step, block.frame) for block in blocks))
    rows = _rows_of_nodes(path, blocks, mapping, frames)
    is_in_first_frame = rows["frame"] == rows["frame"].iloc[0]
    is_on_surface = _lies_on_surface(rows)
    n_left_out = int(np.sum(~is_on_surface & is_in_first_frame))
    if n_left_out:
        notes.append(f"{n_left_out} nodes that do not lie on the contact surface were left out")
    surface_quantities: tuple[Quantity, ...] = ("x", "pressure", "shear", "slip", "frame")
    surface_columns = {
        name: converted(mapping, name, rows[name][is_on_surface].to_numpy())
        for name in surface_quantities
        if name in rows
    }
    steps = {step for step, _ in frames}
    matches = [_TIME.search(frame) for _, frame in frames]
    if len(steps) == 1 and all(matches):
        times = np.array([float(match["time"]) for match in matches if match])
        frame_of_row = surface_columns["frame"].astype(int)
        surface_columns["time"] = converted(mapping, "time", times)[frame_of_row]
    elif len(frames) > 1:
        notes.append(
            f"its frames are of {len(steps)} steps, whose times start again: they were numbered in"
            " the order of the report"
        )
    return surface_columns


def _rows_of_nodes(
    path: Path, blocks: Sequence[_Block], mapping: Mapping, frames: Sequence[tuple[str, str]]
) -> pd.DataFrame:
    """A table of an Abaqus report with a row for each frame and each node that has a pressure,
    indexed by the node's label: pressure, shear, slip, x, y where there are any, and the number of
    the frame in `frames`.

    `blocks` are the report's tables, each of one frame; places may stand in tables of their own.
    InputError where a node has no place. `mapping` states columns, units and signs of the file.
    """
    import pandas as pd

    tables = []
    for block in blocks:
        quantities: tuple[Quantity, ...] = ("x", "y", "pressure", "shear", "slip")
        columns = {}
        for quantity in quantities:
            name = find_column(mapping, quantity, block.names, str(path))
            if name is not None:
                columns[quantity] = block.column(name)
        node_labels = np.arange(float(len(block.values)))
        for name in block.names:
            if plain(name) == "nodelabel":
                node_labels = block.column(name)
                break
        table = pd.DataFrame(columns)
        table.index = pd.Index(node_labels)
        tables.append(table.assign(frame=float(frames.index((block.step, block.frame)))))
    all_values = pd.concat(tables)  # every value is finite: NaN is what a table lacks
    if "x" not in all_values:
        raise InputError(
            f"{path}: the nodes of {blocks[0].region} have no places: report COORD with COORD1"
            " beside CPRESS"
        )
    # Places may stand in tables of their own, and once for all frames.
    places = all_values[all_values.columns.intersection(["x", "y"])].groupby(level=0).last()
    tractions = all_values.drop(columns=places.columns).dropna(subset="pressure").dropna(axis=1)
    rows = tractions.join(places)
    nodes_without_place = rows.index[rows["x"].isna()]
    if len(nodes_without_place):
        raise InputError(
            f"{path}: node {nodes_without_place[0]:.0f} has a pressure and no place; report COORD"
            " for the same nodes"
        )
    return rows


def _lies_on_surface(rows: pd.DataFrame) -> pd.Series[bool]:
    """Which rows are of nodes on the contact surface: those that carry pressure in any frame, and
    all on the same flat face; all rows where no two nodes have one x.
    """
    is_on_surface = (rows["pressure"] != 0).groupby(level=0).transform("any")
    is_in_first_frame = rows["frame"] == rows["frame"].iloc[0]
    if "y" in rows:
        tolerance = _ZERO + _FLAT * np.ptp(rows["x"])
        heights = rows["y"][is_on_surface]
        if np.ptp(heights) <= tolerance:  # a flat face: its nodes outside the contact too
            return np.abs(rows["y"] - heights.median()) <= tolerance
    elif rows["x"][is_in_first_frame].is_unique:
        # no two nodes at one x: the surface alone was reported
        return is_on_surface | True
    return is_on_surface


def _blocks(path: Path) -> Iterator[_Block]:
    """The tables of an Abaqus report that have rows, in its order; each with its step, its frame,
    where its values were taken (nodes, centroids), and its region, from the lines above it.

    A table begins below a line of dashes and ends at an empty line.
    """
    header_values = dict.fromkeys(("step", "frame", "where", "region"), "")
    lines_above: list[str] = []  # lines since the last empty one: headings, if dashes come
    names: list[str] = []
    rows: list[list[float]] = []
    line_of_dashes = 0  # 0 while none has been passed
    row_count = 0
    with path.open(encoding="utf-8", errors="replace") as stream:
        for line_number, line in enumerate(
            chain(iter(lambda: stream.readline(_LONGEST + 1), ""), [""]), 1
        ):
            if len(line) > _LONGEST:
                raise InputError(
                    f"{path}, line {line_number}: more than {_LONGEST:,} characters are no row of a"
                    " report"
                )
            stripped_line = line.rstrip()
            if line_of_dashes and stripped_line:
                row_count += 1
                if row_count > _MOST_ROWS:
                    raise InputError(
                        f"{path}: more than {_MOST_ROWS:,} rows; report the contact surface alone"
                    )
                names = names or _names(stripped_line, lines_above)
                rows.append(_numbers(f"{path}, line {line_number}", stripped_line, names))
            elif rows:
                yield _Block(
                    **header_values, names=names, values=np.array(rows), line=line_of_dashes
                )
                lines_above = []
                names = []
                rows = []
                line_of_dashes = 0
            elif not stripped_line:
                lines_above = lines_above if line_of_dashes else []
            elif re.fullmatch(r"\s*-{12,}", stripped_line) and lines_above:
                line_of_dashes = line_number
            else:
                lines_above.append(stripped_line)
                match = _HEADER.match(stripped_line)
                if match:
                    header_words = match.groupdict()
                    header_values |= {
                        key: value for key, value in header_words.items() if value is not None
                    }


def _names(row: str, lines_above: list[str]) -> list[str]:
    """The names of the columns, which end where the numbers of the first row do, in the lines above
    it.
    """
    ends = [0, *(cell.end() for cell in re.finditer(r"\S+", row))]
    names = []
    for begin, end in pairwise(ends):
        parts = [heading[begin:end].strip() for heading in lines_above]
        words = [part for part in parts if part and not part.startswith("@Loc")]
        names.append(_name(" ".join(words)))
    return names


def _numbers(where: str, row: str, names: list[str]) -> list[float]:
    """The numbers of a row of a report, one for each of `names`; InputError, beginning with
    `where`, for anything else.
    """
    cells = row.split()
    if len(cells) != len(names):
        raise InputError(
            f"{where}: {len(names)} values ({', '.join(names[:6])}) are needed, not {shown(row)}"
        )
    numbers = []
    for name, cell in zip(names, cells, strict=True):
        try:
            number = float(cell)
        except ValueError:
            number = np.nan
        if not np.isfinite(number):
            raise InputError(f"{where}: {name} = {shown(cell)} is not a finite number")
        numbers.append(number)
    return numbers


def _name(heading: str) -> str:
    """The name of the quantity in a heading of a report, without the field and the region.

    >>> (
    ...     _name("COORD.COORD1"),
    ...     _name("CPRESS   ASSEMBLY_PAD/ASSEMBLY_BLOCK"),
    ...     _name("Node Label"),
    ...     _name("S.S22"),
    ... )
    ('COORD1', 'CPRESS', 'Node Label', 'S22')
    """
    if heading.lower().startswith("node"):
        return heading
    first_word = (heading.split() or [""])[0]
    return first_word.rpartition(".")[2]
