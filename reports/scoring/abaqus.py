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

import numpy as np
from numpy.typing import NDArray

from reports.scoring.mapping import Mapping, Quantity, converted, find_column, listed
from scenes import InputError
from scenes.errors import shown
from scenes.files import TEXT, check_size
from scenes.text_tables import plain

Array = NDArray[np.float64]

_TITLE = "Field Output Report"
_SAID = re.compile(
    r"\s*(?:Step:\s*(?P<step>.+?)|Frame:\s*(?P<frame>.+?)|Field Output reported at (?P<where>.+?)"
    r" for "
    r"(?:part|region|element set|node set|set|surface):\s*(?P<region>.+?))\s*$"
)
_TIME = re.compile(r"(?:Step )?Time\s*=\s*(?P<time>[-+]?\d+\.?\d*(?:[eE][-+]?\d{1,2})?)(?!\S)")
_LONGEST, _MOST_ROWS = 100_000, 2_000_000
# Of the extent in x: what the height of a flat face may be written with, and the least that this
# is.
_FLAT, _ZERO = 1e-6, 1e-9


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
        return self.values[:, self.names.index(name)]


def is_field_report(path: Path) -> bool:
    """Whether a file begins as a report of field output does."""
    with path.open("rb") as stream:
        return _TITLE.encode() in stream.read(4096)


def read_field_report(path: Path, mapping: Mapping) -> tuple[dict[Quantity, Array], list[str]]:
    """Columns of one row for each instant and node, in the scene's units and our signs, and what a
    reader must not miss.

    Nodes of both bodies, or within them, carry no pressure: those that ever do are taken, and those
    beside them on the same face where the report has y.

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
    if wrong := next((block for block in blocks if "node" not in block.where), None):
        raise InputError(
            f"{path}, line {wrong.line}: its values are reported at {wrong.where}; report them at"
            " unique nodal positions"
        )
    stated = mapping.surface
    if stated is not None and not any(stated == block.region for block in blocks):
        raise InputError(
            f"{path}: the mapping says surface = {stated!r}, and it reports"
            f" {listed(sorted({b.region for b in blocks}))}"
        )
    source = str(path)
    pressures = [(block, find_column(mapping, "pressure", block.names, source)) for block in blocks]
    known = {
        b.region
        for b, name in pressures
        if stated in (None, b.region) and name is not None and np.any(b.column(name))
    }
    if not known:
        have = listed(list(dict.fromkeys(name for block in blocks for name in block.names)))
        raise InputError(
            f"{path}: no pressure that is not zero everywhere (looked for CPRESS) among {have}"
        )
    if len(known) > 1:
        raise InputError(
            f"{path}: {listed(sorted(known))} carry pressure, master and slave perhaps: say which"
            " by surface of a mapping"
        )
    (region,) = known
    chosen = [block for block in blocks if block.region == region]
    notes = [
        f"the nodal values of {region} were taken, at {len({(b.step, b.frame) for b in chosen})}"
        " frames"
    ]
    return _columns(path, chosen, mapping, notes), notes


def _columns(
    path: Path, blocks: Sequence[_Block], mapping: Mapping, notes: list[str]
) -> dict[Quantity, Array]:
    """One row for each frame and node that lies on the contact surface."""
    import pandas as pd

    frames = list(dict.fromkeys((block.step, block.frame) for block in blocks))
    tables = []
    for block in blocks:
        quantities: tuple[Quantity, ...] = ("x", "y", "pressure", "shear", "slip")
        found = {
            quantity: find_column(mapping, quantity, block.names, str(path))
            for quantity in quantities
        }
        label = next((name for name in block.names if plain(name) == "nodelabel"), None)
        table = pd.DataFrame(
            {quantity: block.column(name) for quantity, name in found.items() if name is not None}
        )
        table.index = pd.Index(
            np.arange(float(len(block.values))) if label is None else block.column(label)
        )
        tables.append(table.assign(frame=float(frames.index((block.step, block.frame)))))
    whole = pd.concat(tables)  # every value is finite: NaN is what a table lacks
    if "x" not in whole:
        raise InputError(
            f"{path}: the nodes of {blocks[0].region} have no places: report COORD with COORD1"
            " beside CPRESS"
        )
    # Places may stand in tables of their own, and once for all frames.
    places = whole[whole.columns.intersection(["x", "y"])].groupby(level=0).last()
    rows = whole.drop(columns=places.columns).dropna(subset="pressure").dropna(axis=1).join(places)
    if len(lacking := rows.index[rows["x"].isna()]):
        raise InputError(
            f"{path}: node {lacking[0]:.0f} has a pressure and no place; report COORD for the same"
            " nodes"
        )
    on, first = (
        (rows["pressure"] != 0).groupby(level=0).transform("any"),
        rows["frame"] == rows["frame"].iloc[0],
    )
    if "y" in rows:
        span = _ZERO + _FLAT * np.ptp(rows["x"])
        if np.ptp(rows["y"][on]) <= span:  # a flat face: its nodes outside the contact too
            on = np.abs(rows["y"] - rows["y"][on].median()) <= span
    elif rows["x"][first].is_unique:  # no two nodes at one x: the surface alone was reported
        on = on | True
    if left := int(np.sum(~on & first)):
        notes.append(f"{left} nodes that do not lie on the contact surface were left out")
    kept: tuple[Quantity, ...] = ("x", "pressure", "shear", "slip", "frame")
    every = {
        name: converted(mapping, name, rows[name][on].to_numpy()) for name in kept if name in rows
    }
    steps, times = {step for step, _ in frames}, [_TIME.search(frame) for _, frame in frames]
    if len(steps) == 1 and all(times):
        stated = np.array([float(found["time"]) for found in times if found])
        every["time"] = converted(mapping, "time", stated)[every["frame"].astype(int)]
    elif len(frames) > 1:
        notes.append(
            f"its frames are of {len(steps)} steps, whose times start again: they were numbered in"
            " the order of the report"
        )
    return every


def _blocks(path: Path) -> Iterator[_Block]:
    """The tables of a report that have rows, in its order."""
    said = dict.fromkeys(("step", "frame", "where", "region"), "")
    above: list[str] = []  # lines since the last empty one: headings, if dashes come
    names: list[str] = []
    rows: list[list[float]] = []
    dashes = count = 0
    with path.open(encoding="utf-8", errors="replace") as stream:
        for number, line in enumerate(
            chain(iter(lambda: stream.readline(_LONGEST + 1), ""), [""]), 1
        ):
            if len(line) > _LONGEST:
                raise InputError(
                    f"{path}, line {number}: more than {_LONGEST:,} characters are no row of a"
                    " report"
                )
            text = line.rstrip()
            if dashes and text:
                count += 1
                if count > _MOST_ROWS:
                    raise InputError(
                        f"{path}: more than {_MOST_ROWS:,} rows; report the contact surface alone"
                    )
                names = names or _names(text, above)
                rows.append(_numbers(f"{path}, line {number}", text, names))
            elif rows:
                yield _Block(**said, names=names, values=np.array(rows), line=dashes)
                above, names, rows, dashes = [], [], [], 0
            elif not text:
                above = above if dashes else []
            elif re.fullmatch(r"\s*-{12,}", text) and above:
                dashes = number
            else:
                above.append(text)
                if found := _SAID.match(text):
                    said |= {
                        key: value for key, value in found.groupdict().items() if value is not None
                    }


def _names(row: str, above: list[str]) -> list[str]:
    """The names of the columns, which end where the numbers of the first row do, in the lines above
    it.
    """
    ends = [0, *(cell.end() for cell in re.finditer(r"\S+", row))]
    parts = ([heading[first:last].strip() for heading in above] for first, last in pairwise(ends))
    return [
        _name(" ".join(part for part in own if part and not part.startswith("@Loc")))
        for own in parts
    ]


def _numbers(where: str, row: str, names: list[str]) -> list[float]:
    """The numbers of a row, one for each name."""
    cells = row.split()
    if len(cells) != len(names):
        raise InputError(
            f"{where}: {len(names)} values ({', '.join(names[:6])}) are needed, not {shown(row)}"
        )
    found = []
    for name, cell in zip(names, cells, strict=True):
        try:
            found.append(float(cell))
        except ValueError:
            found.append(np.nan)
        if not np.isfinite(found[-1]):
            raise InputError(f"{where}: {name} = {shown(cell)} is not a finite number")
    return found


def _name(heading: str) -> str:
    """The quantity in a heading of a report.

    >>> (
    ...     _name("COORD.COORD1"),
    ...     _name("CPRESS   ASSEMBLY_PAD/ASSEMBLY_BLOCK"),
    ...     _name("Node Label"),
    ...     _name("S.S22"),
    ... )
    ('COORD1', 'CPRESS', 'Node Label', 'S22')
    """
    return (
        heading
        if heading.lower().startswith("node")
        else (heading.split() or [""])[0].rpartition(".")[2]
    )
