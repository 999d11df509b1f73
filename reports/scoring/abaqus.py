"""Abaqus `Report > Field Output` files (.rpt): blocks of nodal values, one a part and frame, to one row for each instant and node.

Laid out after reports that users of Abaqus have published; no Abaqus was run here. Reports of XY data are plain tables: `reading`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from reports.scoring.mapping import Mapping, Quantity, converted, find_column, listed
from scenes import InputError
from scenes.errors import shown
from scenes.files import TEXT, check_size
from scenes.text_tables import plain

Array = NDArray[np.float64]

TITLE = "Field Output Report"
_STEP = re.compile(r"\s*Step:\s*(?P<step>.+?)\s*$")
_FRAME = re.compile(r"\s*Frame:\s*(?P<frame>.+?)\s*$")
_TIME = re.compile(r"(?:Step )?Time\s*=\s*(?P<time>[-+]?\d+\.?\d*(?:[eE][-+]?\d{1,2})?)(?!\S)")
_REGION = re.compile(
    r"\s*Field Output reported at (?P<where>.+?) for (?:part|region|element set|node set|set|surface):\s*(?P<name>.+?)\s*$"
)
_LONGEST, _MOST_ROWS = 100_000, 2_000_000
# Of the largest pressure: what a node beside the contact may be written with.
_ZERO = 1e-9


@dataclass
class _Block:
    """Nodal values of one region at one frame; `lines` are where the rows stand."""

    step: str
    frame: str
    where: str
    region: str
    names: list[str]
    rows: list[list[float]] = field(default_factory=list)
    line: int = 0

    def column(self, name: str) -> Array:
        return np.array([row[self.names.index(name)] for row in self.rows])


def is_field_report(path: Path) -> bool:
    """Whether a file begins as a report of field output does."""
    with path.open("rb") as stream:
        return TITLE.encode() in stream.read(4096)


def read_field_report(path: Path, mapping: Mapping) -> tuple[dict[Quantity, Array], list[str]]:
    """Columns of one row for each instant and node, in the scene's units and our signs, and what a reader must not miss.

    Nodes of both bodies, or within them, carry no pressure: those that ever do are taken, and those beside them on the same face
    where the report has y.

    Raises
    ------
    InputError
        One sentence with file, line, value and rule: for values that are not nodal, no places, several surfaces in contact.
    """
    check_size(path, "the result", TEXT, "write the contact surface alone, and fewer frames")
    blocks = [block for block in _blocks(path) if block.rows]
    if not blocks:
        raise InputError(f"{path}: the report holds no table of values below a line of dashes; report CPRESS, CSHEAR and COORD")
    if wrong := next((block for block in blocks if "node" not in block.where), None):
        raise InputError(
            f"{path}, line {wrong.line}: its values are reported at {wrong.where}; report them at unique nodal positions"
        )
    stated = mapping.surface
    if stated is not None and not any(stated == block.region for block in blocks):
        raise InputError(
            f"{path}: the mapping says surface = {stated!r}, and it reports {listed(sorted({b.region for b in blocks}))}"
        )
    source = str(path)
    known: dict[str, list[_Block]] = {}  # by region
    for block in blocks:
        pressure = find_column(mapping, "pressure", block.names, source)
        if stated == block.region or (stated is None and pressure is not None and np.any(block.column(pressure))):
            known.setdefault(block.region, []).append(block)
    if not known:
        have = listed(list(dict.fromkeys(name for block in blocks for name in block.names)))
        raise InputError(f"{path}: no pressure that is not zero everywhere (looked for CPRESS) among {have}")
    if len(known) > 1:
        raise InputError(
            f"{path}: {listed(sorted(known))} carry pressure, master and slave perhaps: say which by surface of a mapping"
        )
    ((region, _),) = known.items()
    chosen = [block for block in blocks if block.region == region]
    notes = [f"the nodal values of {region} were taken, at {len({(b.step, b.frame) for b in chosen})} frames"]
    return _columns(path, chosen, mapping, notes), notes


def _columns(path: Path, blocks: Sequence[_Block], mapping: Mapping, notes: list[str]) -> dict[Quantity, Array]:
    """One row for each frame and node that lies on the contact surface."""
    source = str(path)
    names = blocks[0].names
    label = next((name for name in names if plain(name) == "nodelabel"), None)
    frames = list(dict.fromkeys((block.step, block.frame) for block in blocks))
    tables: list[dict[Quantity, Array]] = []
    places: dict[Quantity, dict[float, float]] = {"x": {}, "y": {}}
    for block in blocks:
        found: dict[Quantity, Array] = {}
        for quantity in ("x", "y", "pressure", "shear", "slip"):
            name = find_column(mapping, quantity, block.names, source)
            if name is not None:
                found[quantity] = block.column(name)
        labels = block.column(label) if label is not None else np.arange(float(len(block.rows)))
        for quantity in ("x", "y"):
            if quantity in found:
                places[quantity].update(zip(labels.tolist(), found[quantity].tolist(), strict=True))
        found["frame"] = np.full(len(labels), float(frames.index((block.step, block.frame))))
        found["time"] = labels  # until all places are known
        tables.append(found)
    if not places["x"]:
        raise InputError(f"{path}: the nodes of {blocks[0].region} have no places: report COORD with COORD1 beside CPRESS")
    whole = [table for table in tables if "pressure" in table]
    every: dict[Quantity, Array] = {
        quantity: np.concatenate([table[quantity] for table in whole])
        for quantity in ("pressure", "shear", "slip", "frame", "time")
        if all(quantity in table for table in whole)
    }
    labels = every.pop("time")
    if lacking := [node for node in labels.tolist() if node not in places["x"]]:
        raise InputError(f"{path}: node {lacking[0]:.0f} has a pressure and no place; report COORD for the same nodes")
    every["x"] = np.array([places["x"][node] for node in labels.tolist()])
    loaded = {node for node, p in zip(labels.tolist(), every["pressure"].tolist(), strict=True) if p}
    on = np.array([node in loaded for node in labels.tolist()])
    if places["y"]:
        heights = np.array([places["y"].get(node, np.nan) for node in labels.tolist()])
        span = _ZERO + 1e-6 * float(np.ptp(every["x"]))
        if np.ptp(heights[on]) <= span:  # a flat face: its nodes outside the contact too
            on = np.abs(heights - np.median(heights[on])) <= span
    elif len(np.unique(every["x"][every["frame"] == every["frame"][0]])) == np.sum(every["frame"] == every["frame"][0]):
        on = np.ones(len(on), dtype=bool)  # no two nodes at one x: the surface alone was reported
    if left := int(np.sum(~on[every["frame"] == every["frame"][0]])):
        notes.append(f"{left} nodes that do not lie on the contact surface were left out")
    every = {quantity: converted(mapping, quantity, values[on]) for quantity, values in every.items()}
    steps, times = {step for step, _ in frames}, [_TIME.search(frame) for _, frame in frames]
    if len(steps) == 1 and all(times):
        stated = np.array([float(found["time"]) for found in times if found])
        every["time"] = converted(mapping, "time", stated)[every["frame"].astype(int)]
    elif len(frames) > 1:
        notes.append(
            f"its frames are of {len(steps)} steps, whose times start again: they were numbered in the order of the report"
        )
    return every


def _blocks(path: Path) -> Iterator[_Block]:
    """The tables of a report, in its order."""
    step = frame = where = region = ""
    above: list[tuple[int, str]] = []  # lines since the last empty one: headings, if dashes come
    block: _Block | None = None
    count = 0
    with path.open(encoding="utf-8", errors="replace") as stream:
        for number, line in enumerate(iter(lambda: stream.readline(_LONGEST + 1), ""), 1):
            if len(line) > _LONGEST:
                raise InputError(f"{path}, line {number}: more than {_LONGEST:,} characters are no row of a report")
            text = line.rstrip()
            if block is not None and text.strip():
                count += 1
                if count > _MOST_ROWS:
                    raise InputError(f"{path}: more than {_MOST_ROWS:,} rows; report the contact surface alone")
                block.rows.append(_row(path, number, text, block, above))
            elif not text.strip():
                if block is not None and block.rows:
                    yield block
                    block, above = None, []
                elif block is None:
                    above = []
            elif re.fullmatch(r"\s*-{12,}\s*", text) and above:
                block = _Block(step, frame, where, region, [], line=number)
            else:
                above.append((number, text))
                if found := _STEP.match(text):
                    step = found["step"]
                elif found := _FRAME.match(text):
                    frame = found["frame"]
                elif found := _REGION.match(text):
                    where, region = found["where"], found["name"]
    if block is not None:
        yield block


def _row(path: Path, line: int, text: str, block: _Block, above: list[tuple[int, str]]) -> list[float]:
    """The numbers of a row; the first of a block gives its columns their names, which end where its numbers do."""
    cells = list(re.finditer(r"\S+", text))
    if not block.names:
        ends = [0, *(cell.end() for cell in cells)]
        heads = [heading for _, heading in above]
        for first, last in pairwise(ends):
            parts = [heading[first:last].strip() for heading in heads]
            block.names.append(_name(" ".join(part for part in parts if part and not part.startswith("@Loc"))))
    if len(cells) != len(block.names):
        raise InputError(
            f"{path}, line {line}: {len(block.names)} values ({', '.join(block.names[:6])}) are needed, not {shown(text)}"
        )
    found = []
    for name, cell in zip(block.names, cells, strict=True):
        try:
            found.append(float(cell[0]))
        except ValueError:
            found.append(np.nan)
        if not np.isfinite(found[-1]):
            raise InputError(f"{path}, line {line}: {name} = {shown(cell[0])} is not a finite number")
    return found


def _name(heading: str) -> str:
    """The quantity in a heading of a report.

    >>> _name("COORD.COORD1"), _name("CPRESS   ASSEMBLY_PAD/ASSEMBLY_BLOCK"), _name("Node Label"), _name("S.S22")
    ('COORD1', 'CPRESS', 'Node Label', 'S22')
    """
    return heading if heading.lower().startswith("node") else (heading.split() or [""])[0].rpartition(".")[2]
