"""CalculiX' files: .frd, nodes, elements and chosen result blocks of every frame; .dat, its printed
tables and resultants.

The form of .frd is that of the manual of CalculiX GraphiX ("Result Format"). A line begins with a
key: `2C` nodes, `3C` elements, `100C` a result block, ` -4` its name, ` -5` a component of it, `
-1` a record, ` -2` its continuation, ` -3` the end of a block.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes import InputError
from scenes.array_types import Array
from scenes.files import check_size

Integers = NDArray[np.int64]

# bytes; a path along the surface needs no more, and the whole of a larger file would not fit beside
# the engines
LARGEST = 2**29
_FARTHEST = 1e100  # the square of a larger coordinate would be none
_WIDTH = 12  # characters a number, with no blank kept between two
_LABELS = {0: 5, 1: 10}  # characters of a node's number in the short and in the long form
# Fortran drops the E before an exponent of three digits: 1.46685-100.
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[EeDd]?([+-]\d+)|[EeDd](\d+))?", re.ASCII)
_INTEGER = re.compile(r" *[+-]?\d{1,18} *", re.ASCII)


class FrdElement(NamedTuple):
    """One element: its number, its kind as the .frd form counts them (1 brick of 8 nodes, 9
    quadrangle of 4, ...), its nodes.
    """

    number: int
    kind: int
    nodes: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class FrdBlock:
    """One result block of one frame."""

    name: str  # DISP, STRESS, CONTACT, ...
    time: float  # that its header states: total time of the step
    # of the columns, such as COPEN, CSLIP1, CSLIP2, CPRESS, CSHEAR1, CSHEAR2
    components: tuple[str, ...]
    nodes: Integers  # (n_records,), numbers
    values: Array  # (n_records, n_components)
    line: int  # of its header in the file

    def column(self, component: str) -> Array:
        """(n_records,); KeyError where the block has no such component."""
        place_of = {name: place for place, name in enumerate(self.components)}
        return self.values[:, place_of[component]]


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


def read_frd(
    path: str | Path, names: Collection[str] = ("CONTACT",), instead: Collection[str] = ()
) -> FrdFile:
    """Nodes, elements, and result blocks of a .frd file of CalculiX.

    Parameters
    ----------
    names
        names of the result blocks that are read, such as CONTACT
    instead
        names of those that are read where the file has none of `names`

    Raises
    ------
    InputError
        File, line and what was expected there: not ASCII, broken off, a record that is not of fixed
        width, a number that is none, fewer records than announced; or a file of more than half a
        GB.
    """
    path = Path(path)
    _check_size(path)
    version: list[str] = []
    nodes = np.empty(0, np.int64)
    coordinates = np.empty((0, 3))
    elements: list[FrdElement] = []
    # in the order of the file, each once
    times: dict[float, None] = {}
    block_names: dict[str, None] = {}
    blocks: list[FrdBlock] = []
    has_end_mark = False
    with path.open(encoding="ascii", errors="replace", newline="\n") as stream:
        lines = _Lines(path, stream)
        for line in lines:
            match line[:6].strip():
                case "1U":
                    text = line[5:].strip()
                    version += [
                        text.removeprefix(keyword).strip()
                        for keyword in ("UPGM", "UVERSION")
                        if text.startswith(keyword)
                    ]
                case "2C":
                    nodes, coordinates = lines.nodes(line)
                case "3C":
                    elements += lines.elements(line)
                case "100C":
                    header_line = lines.number
                    time = lines.float(line[12:24], "the time of a frame in columns 13 to 24")
                    name, components = lines.components()
                    times[time] = None
                    block_names[name] = None
                    has_first_choice = bool(blocks) and blocks[0].name in names
                    label_width, records = lines.records(
                        line, f"records of block {name}", header_line
                    )
                    if name in names and not has_first_choice:
                        blocks.clear()
                    if name in names or (name in instead and not has_first_choice):
                        node_numbers, values = lines.table(records, label_width, len(components))
                        blocks.append(
                            FrdBlock(name, time, components, node_numbers, values, header_line)
                        )
                case "9999":
                    has_end_mark = True
                    break
    if not len(nodes):
        raise InputError(
            f"{path}: no block of nodes (a line that begins with 2C): this is not a result file of"
            " CalculiX"
        )
    return FrdFile(
        path,
        " ".join(version),
        nodes,
        coordinates,
        tuple(elements),
        tuple(times),
        tuple(blocks),
        tuple(block_names),
        has_end_mark,
    )


def _check_size(path: Path) -> None:
    """InputError for a file that is too large or can't be read."""
    try:
        check_size(path, "the result", LARGEST, "write fewer sets or frames into it")
    except OSError as reason:
        raise InputError(f"{path}: the result can't be read: {reason.strerror}") from reason


class _Record(NamedTuple):
    """One record of a block: the number of its line, that line from the node's number on, and its
    continuations.
    """

    line: int
    text: str
    continuations: list[str]


class _Lines(Iterator[str]):
    """Lines of a file without their ends, the number of the last one taken, and what is made of
    them.
    """

    def __init__(self, path: Path, lines: Iterable[str]) -> None:
        self.path = path
        self._numbered = enumerate(lines, start=1)
        self.number = 0

    def __next__(self) -> str:
        self.number, line = next(self._numbered)
        return line.rstrip()

    def refusal(self, expected: str, number: int = 0) -> InputError:
        """The sentence to raise, with file and line."""
        return InputError(f"{self.path}: line {number or self.number}: expected {expected}")

    def records(self, header: str, noun: str, header_line: int) -> tuple[int, list[_Record]]:
        """Width of a node's number in characters, and the records of a block of a .frd file.

        Parameters
        ----------
        header
            header of the block, which announces how many records follow
        noun
            what the records are called in messages
        header_line
            number of the header's line

        Raises
        ------
        InputError
            For a binary block, and for more or fewer records than announced.
        """
        n_announced = self.integer(
            header[24:36], "the count of records in columns 25 to 36", header_line
        )
        format_number = self.integer(
            header[73:].strip()[:1] or "1", "the form of the block (0 or 1)", header_line
        )
        if format_number not in _LABELS:
            raise InputError(
                f"{self.path}: line {header_line}: the file is binary (form {format_number}), and"
                " only the ASCII forms are read; write *NODE FILE, *EL FILE and *CONTACT FILE in"
                " place of *NODE OUTPUT, *ELEMENT OUTPUT and *CONTACT OUTPUT"
            )
        records: list[_Record] = []
        for line in self:
            if line.startswith(" -1"):
                records.append(_Record(self.number, line[3:], []))
            elif line.startswith(" -2") and records:
                records[-1].continuations.append(line[3:])
            elif line.startswith(" -3"):
                if len(records) != n_announced:
                    raise self.refusal(
                        f"{n_announced} {noun} as announced here, found {len(records)}", header_line
                    )
                return _LABELS[format_number], records
            else:
                raise self.refusal(
                    "the head of a record (-1), then its rest (-2), or the end of the block (-3),"
                    f" found {line[:40]!r}"
                )
        raise self.refusal(
            f"the end of the block (-3): the file breaks off after {len(records)} of {n_announced}"
            f" {noun}"
        )

    def nodes(self, header: str) -> tuple[Integers, Array]:
        """Numbers (n,) and places (n, 3) of the nodes in the block of this header."""
        at = self.number
        label, records = self.records(header, "nodes", at)
        nodes, points = self.table(records, label, 3)
        if len(np.unique(nodes)) < len(nodes):
            raise self.refusal("every node once: a number comes twice", at + 1)
        if not (np.abs(points) <= _FARTHEST).all():
            raise self.refusal("finite coordinates", at + 1)
        return nodes, points

    def elements(self, header: str) -> Iterator[FrdElement]:
        """Number, kind and node numbers of each element of a .frd file, in the block below
        `header`. InputError for an element without nodes.
        """
        header_line = self.number
        label_width, records = self.records(header, "elements", header_line)
        for line, head, continuations in records:
            number = self.integer(head[:label_width], "an element's number", line)
            kind = self.integer(head[label_width:][:5], "its kind", line)
            number_texts = [
                node_text[k : k + label_width]
                for node_text in continuations
                for k in range(0, len(node_text), label_width)
            ]
            nodes = tuple(self.integer(word, "a node's number", line + 1) for word in number_texts)
            if not nodes:
                raise self.refusal(
                    f"nodes (-2) of every element, found none of element {number}", header_line
                )
            yield FrdElement(number, kind, nodes)

    def components(self) -> tuple[str, tuple[str, ...]]:
        """Name of a result block and the names of its components, from the lines below its
        header.
        """
        line = next(self, "")
        if not line.startswith(" -4"):
            raise self.refusal(f"the name of a result block (-4), found {line[:40]!r}")
        name = line[5:13].strip()
        components = []
        count = self.integer(line[13:18], "how many components the block has")
        for _ in range(count):
            line = next(self, "")
            if not line.startswith(" -5"):
                raise self.refusal(
                    f"the name of a component (-5), {count} in all, found {line[:40]!r}"
                )
            # ALL, which a viewer works out, is announced and is not in the file
            if line[33:38].strip() != "1":
                components.append(line[5:13].strip())
        return name, tuple(components)

    def table(
        self, records: list[_Record], label_width: int, n_columns: int
    ) -> tuple[Integers, Array]:
        """Node numbers (n,) and values (n, n_columns) of the records of a result block, in columns
        of fixed width. `label_width` is how many characters a node's number has. InputError for a
        record of another length.
        """
        nodes: list[int] = []
        number_texts: list[str] = []
        for line, record_text, continuations in records:
            numbers_in_text = record_text[label_width:] + "".join(
                continuation[label_width:] for continuation in continuations
            )
            if len(numbers_in_text) != _WIDTH * n_columns:
                # a record begins with a key of three characters
                expected_length = 3 + label_width + _WIDTH * n_columns
                record_length = 3 + label_width + len(numbers_in_text)
                raise self.refusal(
                    f"{n_columns} numbers of {_WIDTH} characters, {expected_length} in all, found"
                    f" {record_length}: {record_text[:40]!r}",
                    line,
                )
            nodes.append(self.integer(record_text[:label_width], "a node's number", line))
            number_texts += [
                numbers_in_text[begin : begin + _WIDTH]
                for begin in range(0, len(numbers_in_text), _WIDTH)
            ]
        try:
            values = np.array(number_texts, f"S{_WIDTH}").astype(float)
        except ValueError:  # one of them is not as Python writes it
            numbers = []
            for number_index, number_text in enumerate(number_texts):
                line = records[number_index // n_columns].line
                numbers.append(self.float(number_text, "a number", line))
            values = np.array(numbers)
        return np.array(nodes, np.int64), values.reshape(len(nodes), n_columns)

    def float(self, text: str, noun: str = "a number", line: int = 0) -> float:
        """The number that the text states, also as Fortran writes it."""
        try:
            return float(text)
        except ValueError:
            match = _NUMBER.fullmatch(text.strip())
        if match is None:
            raise self.refusal(f"{noun}, found {text[:40]!r}", line)
        mantissa = match[1]
        exponent = match[2] or match[3] or 0
        return float(f"{mantissa}e{exponent}")

    def integer(self, text: str, noun: str, line: int = 0) -> int:
        """The whole number that the text states."""
        if not _INTEGER.fullmatch(text):
            raise self.refusal(f"{noun}, found {text[:40]!r}", line)
        return int(text)


# ----------------------------------------------------------------------------------- printed tables
# The titles: " what (columns) for scope and time 0.5E+00" and " statistics for slave set A, master
# set B and time 0.5E+00".
_TITLE = re.compile(
    r" ?(?P<what>[a-z][^()]*?) ?\((?P<columns>[^)]*)\) for (?P<scope>.*?) and"
    r" time\s*(?P<time>\S+)\s*"
)
_STATISTICS = re.compile(
    r" ?statistics for slave set (?P<slave>[^,]+), ?master set (?P<master>.+?) and"
    r" time\s*(?P<time>\S+)\s*"
)
# Words that stand for the numbers of what a row belongs to, and how many numbers they are; other
# tables name their values alone.
_IDS = {"slave node": 1, "slave element+face": 2}


@dataclass(frozen=True, eq=False)
class DatTable:
    """One printed table."""

    kind: str  # such as "contact stress", "relative contact displacement", "total force"
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
    """Read a .dat file of CalculiX: every table whose title states a time, and the resultant force
    of each contact pair at each time.

    Raises
    ------
    InputError
        File, line and what was expected: a row that is no row of its table, resultants that break
        off; a file of over half a GB.
    """
    path = Path(path)
    _check_size(path)
    lines = path.read_text(encoding="ascii", errors="replace").split("\n")
    reader = _Lines(path, ())  # for its words and numbers
    tables: list[DatTable] = []
    pair_forces: list[PairForce] = []
    for title_line_number, line in enumerate(lines, start=1):
        if " time" not in line:
            continue
        pair_title = _STATISTICS.fullmatch(line)
        if pair_title:
            pair_forces.append(_pair_force(reader, lines, title_line_number, pair_title))
            continue
        title = _TITLE.fullmatch(line)
        if title:
            tables.append(_printed_table(reader, lines, title_line_number, title))
    if not tables and not pair_forces:
        raise InputError(
            f"{path}: no table of CalculiX in it (a title that ends with 'and time ...'); *CONTACT"
            " PRINT writes them"
        )
    return DatFile(path, tuple(tables), tuple(pair_forces))


def _pair_force(
    file: _Lines, lines: Sequence[str], title_line: int, title: re.Match[str]
) -> PairForce:
    """The resultant force of a contact pair and its mean normal, from the statistics that CalculiX
    prints below a title.

    Parameters
    ----------
    file
        the .dat file, for messages
    lines
        the lines below the title
    title_line
        number of the title's line
    title
        match of the title with the names of the pair
    """

    def numbers_below(heading: str) -> Array:
        """Six numbers on the line after next of a heading."""
        for line_number, line in enumerate(
            lines[title_line : title_line + 19], start=title_line + 1
        ):
            if line.strip().startswith(heading) and line_number + 1 < len(lines):
                number_texts = lines[line_number + 1].split()
                if len(number_texts) != 6:
                    raise file.refusal(
                        f"6 numbers under {heading!r}, found {len(number_texts)}", line_number + 2
                    )
                return np.array([file.float(word, line=line_number + 2) for word in number_texts])
        raise file.refusal(f"{heading!r} below this title: the file breaks off", title_line)

    force_and_moment = numbers_below("total surface force")
    centre_and_normal = numbers_below("center of gravity and mean normal")
    return PairForce(
        title["slave"].strip(),
        title["master"].strip(),
        file.float(title["time"], line=title_line),
        force=force_and_moment[:3],
        normal=centre_and_normal[3:],
    )


def _printed_table(
    file: _Lines, lines: Sequence[str], title_line: int, title: re.Match[str]
) -> DatTable:
    """A table printed in a .dat file: numbers of nodes, elements or faces (n, n_ids), and values
    (n, n_values).

    It begins below the title in line `title_line` and blank lines, and ends before the next blank
    line or title. InputError for a row of another length.
    """
    first_line = title_line
    while first_line < len(lines) and not lines[first_line].strip():
        first_line += 1
    end_line = first_line
    while end_line < len(lines) and lines[end_line].strip() and " time" not in lines[end_line]:
        end_line += 1
    table_rows = [words_of_row.split() for words_of_row in lines[first_line:end_line]]
    column_names = title["columns"].split(",")
    first_name = column_names[0].strip()
    n_values = len(column_names)
    if first_name in _IDS:
        n_values -= 1
        n_ids = _IDS[first_name]
    else:
        n_ids = max(len(table_rows[0]) - n_values, 0) if table_rows else 0
    ids = []
    values = []
    for line_number, words_of_row in enumerate(table_rows, start=first_line + 1):
        if len(words_of_row) != n_ids + n_values:
            raise file.refusal(
                f"{n_ids + n_values} numbers ({title['columns']}), found {len(words_of_row)}",
                line_number,
            )
    for line_number, words_of_row in enumerate(table_rows, start=first_line + 1):
        noun = "the number of a node, element or face"
        ids.append([file.integer(word, noun, line_number) for word in words_of_row[:n_ids]])
        values.append([file.float(word, line=line_number) for word in words_of_row[n_ids:]])
    return DatTable(
        title["what"],
        title["scope"].strip(),
        file.float(title["time"], line=title_line),
        np.array(ids, np.int64).reshape(len(table_rows), n_ids),
        np.array(values, float).reshape(len(table_rows), n_values),
    )
