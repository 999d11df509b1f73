"""CalculiX' ASCII result file .frd, as far as surface tractions need it: nodes, elements, and chosen result blocks of every frame.

The form is that of the manual of CalculiX GraphiX ("Result Format"). A line begins with a key: `2C` nodes, `3C` elements, `100C` a
result block, ` -4` its name, ` -5` a component of it, ` -1` a record, ` -2` its continuation, ` -3` the end of a block.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from reports.scoring.calculix_records import Array, Integers, Lines, expect_count, integer_in, number_in, shown, table
from scenes import InputError, files

LARGEST = 2**29  # bytes; a path along the surface needs no more, and the whole of a larger file would not fit beside the engines
FARTHEST = 1e100  # the square of a larger coordinate would be none
_LABELS = {0: 5, 1: 10}  # characters of a node's number in the short and in the long form


class FrdElement(NamedTuple):
    """One element: its number, its kind as the .frd form counts them (1 brick of 8 nodes, 9 quadrangle of 4, ...), its nodes."""

    number: int
    kind: int
    nodes: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class FrdBlock:
    """One result block of one frame.

    Attributes
    ----------
    name : DISP, STRESS, CONTACT, ...
    time : the value that the block's header states: total time of the step
    components : names of the columns, such as COPEN, CSLIP1, CSLIP2, CPRESS, CSHEAR1, CSHEAR2
    nodes : (n_records,), numbers of the nodes
    values : (n_records, n_components)
    line : of its header in the file
    """

    name: str
    time: float
    components: tuple[str, ...]
    nodes: Integers
    values: Array
    line: int

    def column(self, component: str) -> Array:
        """(n_records,); KeyError where the block has no such component."""
        if component not in self.components:
            raise KeyError(component)
        return self.values[:, self.components.index(component)]


@dataclass(frozen=True, eq=False)
class FrdFile:
    """What a .frd file holds.

    Attributes
    ----------
    path : where it was read
    version : what its header says of the program, such as "CalculiX Version 2.20"
    nodes : (n_nodes,), numbers
    points : (n_nodes, 3), coordinates before deformation [length]
    elements : with their nodes
    times : (n_frames,), of all frames in the file's order, whatever they hold
    blocks : those of the names asked for, in the file's order
    names : of all blocks that the file has
    ended : whether the file has its end (9999), which CalculiX writes last
    """

    path: Path
    version: str
    nodes: Integers
    points: Array
    elements: tuple[FrdElement, ...]
    times: tuple[float, ...]
    blocks: tuple[FrdBlock, ...]
    names: tuple[str, ...]
    ended: bool


def read_frd(path: str | Path, names: Collection[str] = ("CONTACT",), instead: Collection[str] = ()) -> FrdFile:
    """Nodes, elements, and the result blocks of the `names`; where there is none, those of the names `instead`.

    Raises
    ------
    InputError
        File, line and what was expected there: not ASCII, broken off, a record that is not of fixed width, a number that is none,
        fewer records than announced; or a file of more than half a GB.
    """
    path = Path(path)
    check_size(path)
    found = _Found(frozenset(names), frozenset(instead))
    with path.open("rb") as stream:
        lines = Lines(path, enumerate(stream, start=1))
        for line in lines:
            read = _KEYS.get(line[:6])
            if read is not None:
                read(lines, line, found)
            elif line[:6].strip() == b"9999":
                found.ended = True
                break
    if not len(found.nodes):
        raise InputError(f"{path}: no block of nodes (a line that begins with 2C): this is not a result file of CalculiX")
    return FrdFile(
        path,
        " ".join(found.version),
        found.nodes,
        found.points,
        tuple(found.elements),
        tuple(dict.fromkeys(found.times)),
        tuple(found.blocks or [block() for block in found.instead]),
        tuple(dict.fromkeys(found.names)),
        found.ended,
    )


def check_size(path: Path) -> None:
    """InputError where the file is too large to be read whole."""
    try:
        files.check_size(path, "the result", LARGEST, "write fewer sets or frames into it")
    except OSError as reason:
        raise InputError(f"{path}: the result can't be read: {reason.strerror}") from reason


@dataclass
class _Found:
    """What has been read so far."""

    wanted: frozenset[str]
    second_best: frozenset[str]
    version: list[str] = field(default_factory=list)
    nodes: Integers = field(default_factory=lambda: np.empty(0, np.int64))
    points: Array = field(default_factory=lambda: np.empty((0, 3)))
    elements: list[FrdElement] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    blocks: list[FrdBlock] = field(default_factory=list)
    instead: list[Callable[[], FrdBlock]] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    ended: bool = False


def _user_header(_lines: Lines, line: bytes, found: _Found) -> None:
    text = line[5:].decode("ascii", errors="replace").strip()
    if text.startswith(("UPGM", "UVERSION")):
        found.version.append(text.removeprefix("UPGM").removeprefix("UVERSION").strip())


def _nodes(lines: Lines, header: bytes, found: _Found) -> None:
    announced, label = _announced(lines, header, 24, 36, "nodes"), _label(lines, header, 73)
    start = lines.number + 1
    found.nodes, found.points = table(lines, lines.records("nodes"), label, 3, start)
    expect_count(lines, announced, len(found.nodes), "nodes", start - 1)
    if len(np.unique(found.nodes)) < len(found.nodes):
        raise lines.refusal("every node once: a number comes twice", start)
    if not (np.abs(found.points) <= FARTHEST).all():
        raise lines.refusal("finite coordinates", start)


def _elements(lines: Lines, header: bytes, found: _Found) -> None:
    label, at = _label(lines, header, 73), lines.number
    announced = _announced(lines, header, 24, 36, "elements")
    heads: list[tuple[int, int]] = []
    nodes: list[list[int]] = []
    for number, line in enumerate(lines.records("elements"), start=at + 1):
        fields = [line[3 : 3 + label], line[3 + label : 8 + label]]
        if line.startswith(b" -1"):
            heads.append(
                (integer_in(lines, fields[0], "an element's number", number), integer_in(lines, fields[1], "its kind", number))
            )
            nodes.append([])
        elif not heads:
            raise lines.refusal("the head of an element (-1) before its nodes (-2)", number)
        else:
            nodes[-1] += [
                integer_in(lines, line[k : k + label], "a node's number", number) for k in range(3, len(line.rstrip()), label)
            ]
    expect_count(lines, announced, len(heads), "elements", at)
    if bare := [head[0] for head, own in zip(heads, nodes, strict=True) if not own]:
        raise lines.refusal(f"nodes (-2) of every element, found none of element {bare[0]}", at)
    found.elements += [FrdElement(*head, tuple(own)) for head, own in zip(heads, nodes, strict=True)]


def _results(lines: Lines, header: bytes, found: _Found) -> None:
    at = lines.number
    time = number_in(lines, header[12:24], "the time of a frame in columns 13 to 24", at)
    announced = _announced(lines, header, 24, 36, "records")
    label = _label(lines, header, 74)
    name, n_components = _block_name(lines)
    components = _components(lines, n_components)
    found.times.append(time)
    found.names.append(name)
    start = lines.number + 1
    records = lines.records(f"block {name}")

    def block() -> FrdBlock:
        nodes, values = table(lines, records, label, len(components), start)
        expect_count(lines, announced, len(nodes), f"records of block {name}", at)
        return FrdBlock(name, time, components, nodes, values, at)

    if name in found.wanted:
        found.blocks.append(block())
        found.instead.clear()
    elif name in found.second_best and not found.blocks:
        found.instead.append(block)


def _block_name(lines: Lines) -> tuple[str, int]:
    line = next(lines, b"")
    if not line.startswith(b" -4"):
        raise lines.refusal(f"the name of a result block (-4), found {shown(line)}")
    return line[5:13].decode("ascii", errors="replace").strip(), integer_in(lines, line[13:18], "how many components the block has")


def _components(lines: Lines, announced: int) -> tuple[str, ...]:
    """Names of the components that are in the file: ALL, which a viewer works out, is announced and is not."""
    names = []
    for _ in range(announced):
        line = next(lines, b"")
        if not line.startswith(b" -5"):
            raise lines.refusal(f"the name of a component (-5), {announced} in all, found {shown(line)}")
        if line[33:38].strip() != b"1":
            names.append(line[5:13].decode("ascii", errors="replace").strip())
    return tuple(names)


def _announced(lines: Lines, header: bytes, start: int, end: int, what: str) -> int:
    return integer_in(lines, header[start:end], f"the count of {what} in columns {start + 1} to {end}")


def _label(lines: Lines, header: bytes, at: int) -> int:
    """Characters of a node's number; refuses the binary forms."""
    form = integer_in(lines, header[at:].strip()[:1] or b"1", "the form of the block (0 or 1)")
    if form not in _LABELS:
        raise InputError(
            f"{lines.path}: line {lines.number}: the file is binary (form {form}), and only the ASCII forms are read; "
            "write *NODE FILE, *EL FILE and *CONTACT FILE in place of *NODE OUTPUT, *ELEMENT OUTPUT and *CONTACT OUTPUT"
        )
    return _LABELS[form]


_KEYS: dict[bytes, Callable[[Lines, bytes, _Found], None]] = {
    b"    1U": _user_header,
    b"    2C": _nodes,
    b"    3C": _elements,
    b"  100C": _results,
}
