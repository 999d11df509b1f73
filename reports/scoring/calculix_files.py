"""CalculiX' files: .frd, nodes, elements and chosen result blocks of every frame; .dat, its printed tables and resultants.

The form of .frd is that of the manual of CalculiX GraphiX ("Result Format"). A line begins with a key: `2C` nodes, `3C` elements,
`100C` a result block, ` -4` its name, ` -5` a component of it, ` -1` a record, ` -2` its continuation, ` -3` the end of a block.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes import InputError
from scenes.files import check_size

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

LARGEST = 2**29  # bytes; a path along the surface needs no more, and the whole of a larger file would not fit beside the engines
FARTHEST = 1e100  # the square of a larger coordinate would be none
WIDTH = 12  # characters a number, with no blank kept between two
_LABELS = {0: 5, 1: 10}  # characters of a node's number in the short and in the long form
# Fortran drops the E before an exponent of three digits: 1.46685-100.
_NUMBER = re.compile(rb"([+-]?(?:\d+\.?\d*|\.\d+))(?:[EeDd]?([+-]\d+)|[EeDd](\d+))?")
_INTEGER = re.compile(rb" *[+-]?\d+ *")


class FrdElement(NamedTuple):
    """One element: its number, its kind as the .frd form counts them (1 brick of 8 nodes, 9 quadrangle of 4, ...), its nodes."""

    number: int
    kind: int
    nodes: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class FrdBlock:
    """One result block of one frame."""

    name: str  # DISP, STRESS, CONTACT, ...
    time: float  # that its header states: total time of the step
    components: tuple[str, ...]  # of the columns, such as COPEN, CSLIP1, CSLIP2, CPRESS, CSHEAR1, CSHEAR2
    nodes: Integers  # (n_records,), numbers
    values: Array  # (n_records, n_components)
    line: int  # of its header in the file

    def column(self, component: str) -> Array:
        """(n_records,); KeyError where the block has no such component."""
        if component not in self.components:
            raise KeyError(component)
        return self.values[:, self.components.index(component)]


@dataclass(frozen=True, eq=False)
class FrdFile:
    """What a .frd file holds."""

    path: Path
    version: str  # of the program, such as "CalculiX Version 2.20"
    nodes: Integers  # (n_nodes,), numbers
    points: Array  # (n_nodes, 3), before deformation [length]
    elements: tuple[FrdElement, ...]
    times: tuple[float, ...]  # of all frames in the file's order, whatever they hold
    blocks: tuple[FrdBlock, ...]  # those of the names asked for, in the file's order
    names: tuple[str, ...]  # of all blocks that the file has
    ended: bool  # whether the file has its end (9999), which CalculiX writes last


def read_frd(path: str | Path, names: Collection[str] = ("CONTACT",), instead: Collection[str] = ()) -> FrdFile:
    """Nodes, elements, and the result blocks of the `names`; where there is none, those of the names `instead`.

    Raises
    ------
    InputError
        File, line and what was expected there: not ASCII, broken off, a record that is not of fixed width, a number that is none,
        fewer records than announced; or a file of more than half a GB.
    """
    path = Path(path)
    _check_size(path)
    version: list[str] = []
    nodes, points = np.empty(0, np.int64), np.empty((0, 3))
    elements: list[FrdElement] = []
    times: list[float] = []
    named: list[str] = []
    blocks: list[FrdBlock] = []
    second_best: list[Callable[[], FrdBlock]] = []
    ended = False
    with path.open("rb") as stream:
        lines = _Lines(path, enumerate(stream, start=1))
        for line in lines:
            key = line[:6].strip()
            if key == b"1U":
                text = line[5:].decode("ascii", errors="replace").strip()
                version += [text.removeprefix(own).strip() for own in ("UPGM", "UVERSION") if text.startswith(own)]
            elif key == b"2C":
                nodes, points = lines.nodes(line)
            elif key == b"3C":
                elements += lines.elements(line)
            elif key == b"100C":
                name, time, block = lines.block(line)
                times.append(time)
                named.append(name)
                if name in names:
                    blocks.append(block())
                    second_best.clear()
                elif name in instead and not blocks:
                    second_best.append(block)
            elif key == b"9999":
                ended = True
                break
    if not len(nodes):
        raise InputError(f"{path}: no block of nodes (a line that begins with 2C): this is not a result file of CalculiX")
    blocks = blocks or [block() for block in second_best]
    told = tuple(dict.fromkeys(times)), tuple(blocks), tuple(dict.fromkeys(named))
    return FrdFile(path, " ".join(version), nodes, points, tuple(elements), *told, ended)


def _check_size(path: Path) -> None:
    try:
        check_size(path, "the result", LARGEST, "write fewer sets or frames into it")
    except OSError as reason:
        raise InputError(f"{path}: the result can't be read: {reason.strerror}") from reason


class _Lines(Iterator[bytes]):
    """Lines of a .frd file without their ends, the number of the last one taken, and what is made of them."""

    def __init__(self, path: Path, numbered: Iterator[tuple[int, bytes]]) -> None:
        self.path, self._numbered, self.number = path, numbered, 0

    def __next__(self) -> bytes:
        self.number, line = next(self._numbered)
        return line.rstrip(b"\r\n")

    def refusal(self, expected: str, number: int = 0) -> InputError:
        """The sentence to raise, with file and line."""
        return InputError(f"{self.path}: line {number or self.number}: expected {expected}")

    def records(self, of: str) -> list[bytes]:
        """The lines of a block up to its end."""
        found: list[bytes] = []
        for line in self:
            if line.startswith(b" -3"):
                return found
            if line[:3] not in {b" -1", b" -2"}:
                raise self.refusal(f"a record of {of} (-1, -2) or the end of the block (-3), found {_shown(line)}")
            found.append(line)
        raise self.refusal(f"more of {of}: the file breaks off, {len(found)} lines into the block and without its end (-3)")

    def header(self, line: bytes, what: str, form_at: int) -> tuple[int, int]:
        """How many records a header announces, and the characters of a node's number; refuses the binary forms."""
        announced = self.integer(line[24:36], f"the count of {what} in columns 25 to 36")
        form = self.integer(line[form_at:].strip()[:1] or b"1", "the form of the block (0 or 1)")
        if form not in _LABELS:
            raise InputError(
                f"{self.path}: line {self.number}: the file is binary (form {form}), and only the ASCII forms are read; "
                "write *NODE FILE, *EL FILE and *CONTACT FILE in place of *NODE OUTPUT, *ELEMENT OUTPUT and *CONTACT OUTPUT"
            )
        return announced, _LABELS[form]

    def expect(self, announced: int, found: int, what: str, number: int) -> None:
        if announced != found:
            raise self.refusal(f"{announced} {what} as announced here, found {found}", number)

    def nodes(self, header: bytes) -> tuple[Integers, Array]:
        (announced, label), start = self.header(header, "nodes", 73), self.number + 1
        nodes, points = self.table(self.records("nodes"), label, 3, start)
        self.expect(announced, len(nodes), "nodes", start - 1)
        if len(np.unique(nodes)) < len(nodes):
            raise self.refusal("every node once: a number comes twice", start)
        if not (np.abs(points) <= FARTHEST).all():
            raise self.refusal("finite coordinates", start)
        return nodes, points

    def elements(self, header: bytes) -> list[FrdElement]:
        (announced, label), at = self.header(header, "elements", 73), self.number
        found: list[tuple[int, int, list[int]]] = []
        for number, line in enumerate(self.records("elements"), start=at + 1):
            if line.startswith(b" -1"):
                own = self.integer(line[3 : 3 + label], "an element's number", number)
                found.append((own, self.integer(line[3 + label : 8 + label], "its kind", number), []))
            elif not found:
                raise self.refusal("the head of an element (-1) before its nodes (-2)", number)
            else:
                words = [line[k : k + label] for k in range(3, len(line.rstrip()), label)]
                found[-1][2].extend(self.integer(word, "a node's number", number) for word in words)
        self.expect(announced, len(found), "elements", at)
        if bare := [number for number, _, nodes in found if not nodes]:
            raise self.refusal(f"nodes (-2) of every element, found none of element {bare[0]}", at)
        return [FrdElement(number, kind, tuple(nodes)) for number, kind, nodes in found]

    def block(self, header: bytes) -> tuple[str, float, Callable[[], FrdBlock]]:
        """Name and time of a result block, and what reads its numbers."""
        at, time = self.number, self.float(header[12:24], "the time of a frame in columns 13 to 24")
        announced, label = self.header(header, "records", 74)
        line = next(self, b"")
        if not line.startswith(b" -4"):
            raise self.refusal(f"the name of a result block (-4), found {_shown(line)}")
        name = line[5:13].decode("ascii", errors="replace").strip()
        count = self.integer(line[13:18], "how many components the block has")
        components = []
        for _ in range(count):
            line = next(self, b"")
            if not line.startswith(b" -5"):
                raise self.refusal(f"the name of a component (-5), {count} in all, found {_shown(line)}")
            if line[33:38].strip() != b"1":  # ALL, which a viewer works out, is announced and is not in the file
                components.append(line[5:13].decode("ascii", errors="replace").strip())
        start, records = self.number + 1, self.records(f"block {name}")

        def read() -> FrdBlock:
            nodes, values = self.table(records, label, len(components), start)
            self.expect(announced, len(nodes), f"records of block {name}", at)
            return FrdBlock(name, time, tuple(components), nodes, values, at)

        return name, time, read

    def table(self, records: list[bytes], label: int, columns: int, start: int) -> tuple[Integers, Array]:
        """Node numbers (n,) and values (n, columns) of ` -1` records and their ` -2` continuations, six numbers a line.

        `start`: number of the first line in the file.
        """
        per_record = max(1, -(-columns // 6))
        if len(records) % per_record:
            raise self.refusal(f"{per_record} lines a record, found {len(records)} lines in the block")
        nodes, words, first = list[int](), list[bytes](), 3 + label
        for place, record in enumerate(records, start=start):
            k = (place - start) % per_record
            share, key = min(6, columns - 6 * k), b" -2" if k else b" -1"
            width = first + WIDTH * share
            line = record if len(record) == width else record.rstrip()
            if len(line) != width or line[:3] != key:
                raise self.refusal(
                    f"{key.decode().strip()} and {share} numbers of {WIDTH} characters, {width} in all, "
                    f"found {len(line)}: {_shown(line)}",
                    place,
                )
            if not k:
                nodes.append(self.integer(line[3:first], "a node's number", place))
            words += [line[at : at + WIDTH] for at in range(first, width, WIDTH)]
        try:
            values = np.array(words, f"S{WIDTH}").astype(float)
        except ValueError:  # one of them is not as Python writes it
            lines = (start + k // columns * per_record + k % columns // 6 for k in range(len(words)))
            values = np.array([self.float(word, "a number", line) for word, line in zip(words, lines, strict=True)])
        return np.array(nodes, np.int64), values.reshape(len(nodes), columns)

    def float(self, text: bytes, what: str, number: int = 0) -> float:
        """The number that the text states, also as Fortran writes it."""
        try:
            return float(text)
        except ValueError:
            found = _NUMBER.fullmatch(text.strip())
        if found is None:
            raise self.refusal(f"{what}, found {_shown(text)}", number)
        return float(found[1] + b"e" + (found[2] or found[3] or b"0"))

    def integer(self, text: bytes, what: str, number: int = 0) -> int:
        if not _INTEGER.fullmatch(text):
            raise self.refusal(f"{what}, found {_shown(text)}", number)
        return int(text)


def _shown(line: bytes) -> str:
    return repr(line[:40].decode("ascii", errors="replace"))


# ------------------------------------------------------------------------------------------------------------- printed tables
# The titles: " what (columns) for scope and time 0.5E+00" and " statistics for slave set A, master set B and time 0.5E+00".
_TITLE = re.compile(r" ?(?P<what>[a-z][^()]*?) ?\((?P<columns>[^)]*)\) for (?P<scope>.*?) and time\s*(?P<time>\S+)\s*")
_STATISTICS = re.compile(r" ?statistics for slave set (?P<slave>[^,]+), ?master set (?P<master>.+?) and time\s*(?P<time>\S+)\s*")
# Words that stand for the numbers of what a row belongs to, and how many numbers they are; other tables name their values alone.
_IDS = {"slave node": 1, "slave element+face": 2}


@dataclass(frozen=True, eq=False)
class DatTable:
    """One printed table."""

    what: str  # such as "contact stress", "relative contact displacement", "total force"
    scope: str  # what it was printed for, such as "set BOTTOM", "all contact elements"
    time: float  # total time
    ids: Integers  # (n_rows, k), numbers of node, or of element and face; k = 0 for totals
    values: Array  # (n_rows, n_values)


@dataclass(frozen=True, eq=False)
class PairForce:
    """Resultant on the slave face of one contact pair at one time (*CONTACT PRINT, CF)."""

    slave: str
    master: str
    time: float  # total time
    force: Array  # (3,), on the slave face [force]
    normal: Array  # (3,), mean outward normal of the slave face; NaN where nothing touches


@dataclass(frozen=True)
class DatFile:
    """All tables and resultants of a .dat file in its order."""

    path: Path
    tables: tuple[DatTable, ...]
    pairs: tuple[PairForce, ...]


def read_dat(path: str | Path) -> DatFile:
    """Every table of the file whose title states a time.

    Raises
    ------
    InputError
        File, line and what was expected: a row that is no row of its table, resultants that break off; a file of over half a GB.
    """
    path = Path(path)
    _check_size(path)
    lines = path.read_text(encoding="ascii", errors="replace").split("\n")
    tables: list[DatTable] = []
    pairs: list[PairForce] = []

    def refusal(number: int, expected: str) -> InputError:
        return InputError(f"{path}: line {number}: expected {expected}")

    def number_of(kind: type, word: str, number: int, what: str = "a number") -> float:
        try:
            return float(np.int64(kind(word))) if kind is int else float(word)
        except (ValueError, OverflowError) as reason:
            raise refusal(number, f"{what}, found {word[:40]!r}") from reason

    def table(at: int, title: re.Match[str]) -> DatTable:
        """Rows below the title, up to the next blank line or title."""
        columns = [word.strip() for word in title["columns"].split(",")]
        first = next((k for k in range(at + 1, len(lines)) if lines[k].strip()), len(lines))
        last = next((k for k in range(first, len(lines)) if not lines[k].strip() or " time" in lines[k]), len(lines))
        rows = [line.split() for line in lines[first:last]]
        n_values = len(columns) - (columns[0] in _IDS)
        n_ids = _IDS.get(columns[0], max(len(rows[0]) - n_values, 0) if rows else 0)
        for number, row in enumerate(rows, start=first + 1):
            if len(row) != n_ids + n_values:
                raise refusal(number, f"{n_ids + n_values} numbers ({title['columns']}), found {len(row)}")
        id_words = "the number of a node, element or face"
        ids = [[number_of(int, w, first + 1 + k, id_words) for w in row[:n_ids]] for k, row in enumerate(rows)]
        values = [[number_of(float, word, first + 1 + k) for word in row[n_ids:]] for k, row in enumerate(rows)]
        time = number_of(float, title["time"], at + 1)
        shaped = np.array(ids, np.int64).reshape(len(rows), n_ids), np.array(values, float).reshape(len(rows), n_values)
        return DatTable(title["what"], title["scope"].strip(), time, *shaped)

    def after(at: int, heading: str) -> Array:
        """Six numbers on the line after next of a heading among the statistics that begin at line `at` (from 0)."""
        for k in range(at + 1, min(at + 20, len(lines) - 2)):
            if lines[k].strip().startswith(heading):
                words = lines[k + 2].split()
                if len(words) != 6:
                    raise refusal(k + 3, f"6 numbers under {heading!r}, found {len(words)}")
                return np.array([number_of(float, word, k + 3) for word in words])
        raise refusal(at + 1, f"{heading!r} below this title: the file breaks off")

    for at, line in enumerate(lines):
        # Titles begin with a letter; nearly all other lines begin with a number, and are passed over quickly.
        if " time" not in line:
            continue
        if title := _STATISTICS.fullmatch(line):
            force, normal = after(at, "total surface force")[:3], after(at, "center of gravity and mean normal")[3:]
            time = number_of(float, title["time"], at + 1)
            pairs.append(PairForce(title["slave"].strip(), title["master"].strip(), time, force, normal))
        elif title := _TITLE.fullmatch(line):
            tables.append(table(at, title))
    if not tables and not pairs:
        raise InputError(f"{path}: no table of CalculiX in it (a title that ends with 'and time ...'); *CONTACT PRINT writes them")
    return DatFile(path, tuple(tables), tuple(pairs))
