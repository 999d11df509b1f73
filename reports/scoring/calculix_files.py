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
from scenes.files import require_readable_size

Integers = NDArray[np.int64]

# bytes; a path along the surface needs no more, and the whole of a larger file would not fit beside
# the engines
MOST_BYTES_OF_FILE = 2**29
_LARGEST_COORDINATE = 1e100  # the square of a larger coordinate would be none
_CHARACTERS_OF_NUMBER = 12  # characters a number, with no blank kept between two
# of a node's number, in the short and in the long form
_CHARACTERS_OF_LABEL = {0: 5, 1: 10}
# Fortran drops the E before an exponent of three digits: 1.46685-100.
_DECIMAL_NUMBER = re.compile(
    r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[EeDd]?([+-]\d+)|[EeDd](\d+))?", re.ASCII
)
_WHOLE_NUMBER = re.compile(r" *[+-]?\d{1,18} *", re.ASCII)


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
        """Values (n_records,) of a component; KeyError where the block has no such component."""
        column_by_name = {name: number for number, name in enumerate(self.components)}
        return self.values[:, column_by_name[component]]


@dataclass(frozen=True, eq=False)
class FrdFile:
    """What a .frd file holds."""

    path: Path
    version: str  # of the program, such as "CalculiX Version 2.20"
    nodes: Integers  # (n_nodes,), numbers
    points: Array  # (n_nodes, 3), before deformation [length]
    elements: tuple[FrdElement, ...]
    times: tuple[float, ...]  # of all frames in the file's order, whatever they hold
    blocks: tuple[FrdBlock, ...]  # those that were read, in the file's order
    names: tuple[str, ...]  # of all blocks that the file has
    has_end_mark: bool  # whether the file has its end (9999), which CalculiX writes last


def read_frd(
    path: str | Path, names: Collection[str] = ("CONTACT",), substitutes: Collection[str] = ()
) -> FrdFile:
    """Nodes, elements, and chosen result blocks of a .frd file of CalculiX, with the times of all
    blocks. A result block holds values at nodes at one time.

    Parameters
    ----------
    path
        the file
    names
        names of the result blocks that are read, such as CONTACT
    substitutes
        names of the result blocks that are read where the file has none of `names`

    Raises
    ------
    InputError
        With file, line and what was expected there: for a binary block, a file that breaks off, a
        record that is not of fixed width, a number that is none, fewer or more records than
        announced. Without a line: for a file without nodes, of more than half a GB, or that cannot
        be read.
    """
    path = Path(path)
    _check_size(path)
    version: list[str] = []
    nodes = np.empty(0, np.int64)
    points = np.empty((0, 3))
    elements: list[FrdElement] = []
    results = _FrdResults(names, substitutes)
    has_end_mark = False
    with path.open(encoding="ascii", errors="replace", newline="\n") as stream:
        lines = _Lines(path, stream)
        for line in lines:
            # the key at the begin of a line: 1U the program, 2C nodes, 3C elements, 100C a result
            # block, 9999 the end
            match line[:6].strip():
                case "1U":
                    version += _program_and_version(line)
                case "2C":
                    nodes, points = lines.nodes_below(line)
                case "3C":
                    elements += lines.elements_below(line)
                case "100C":
                    results.read_block(lines, line)
                case "9999":
                    has_end_mark = True
                    break
    if not len(nodes):
        raise InputError(
            f"{path}: no block of nodes (a line that begins with 2C): this is not a result file of"
            " CalculiX"
        )
    return FrdFile(
        path=path,
        version=" ".join(version),
        nodes=nodes,
        points=points,
        elements=tuple(elements),
        times=tuple(results.times),
        blocks=tuple(results.blocks),
        names=tuple(results.block_names),  # of all blocks, also of those not read
        has_end_mark=has_end_mark,
    )


def _program_and_version(line: str) -> list[str]:
    """Name or version of the program that a line with the key 1U of a .frd file states; nothing
    where the line states something else, such as the date.
    """
    text = line[5:].strip()
    return [
        text.removeprefix(keyword).strip()
        for keyword in ("UPGM", "UVERSION")
        if text.startswith(keyword)
    ]


class _FrdResults:
    """Result blocks of a .frd file, as they are read one after the other. A result block holds
    values at nodes at one time.

    Attributes
    ----------
    times, block_names
        times and names of all blocks so far, each once and in the order of the file (keys of a
        dictionary without values)
    blocks
        the blocks with one of the wanted names; those with the name of a substitute as long as
        there is none
    """

    def __init__(self, names: Collection[str], substitutes: Collection[str]) -> None:
        """`names` are those of the wanted blocks; `substitutes` those of the blocks that are taken
        where the file has none of `names`.
        """
        self._names = names
        self._substitutes = substitutes
        self.times: dict[float, None] = {}
        self.block_names: dict[str, None] = {}
        self.blocks: list[FrdBlock] = []

    def read_block(self, lines: _Lines, header: str) -> None:
        """Read the block below its `header`, the last line taken of `lines`. Of a block that is not
        wanted the name and the time are kept alone. InputError where it is not as announced.
        """
        header_line_number = lines.line_number
        time = lines.decimal_number(header[12:24], "the time of a frame in columns 13 to 24")
        name, components = lines.components_below()
        self.times[time] = None
        self.block_names[name] = None
        # characters of a node's number; records with their continuations
        label_width, records = lines.records_below(
            header, f"records of block {name}", header_line_number
        )
        has_named_block = bool(self.blocks) and self.blocks[0].name in self._names
        if name in self._names and not has_named_block:
            self.blocks.clear()  # of substitutes
        if name in self._names or (name in self._substitutes and not has_named_block):
            nodes, values = lines.table_of_records(records, label_width, len(components))
            self.blocks.append(FrdBlock(name, time, components, nodes, values, header_line_number))


def _check_size(path: Path) -> None:
    """InputError for a file of more than half a GB, or one that can't be read."""
    try:
        require_readable_size(
            path, "the result", MOST_BYTES_OF_FILE, "write fewer sets or frames into it"
        )
    except OSError as reason:
        raise InputError(f"{path}: the result can't be read: {reason.strerror}") from reason


class _DataLine(NamedTuple):
    """One record of a block: the number of its line, the text of that line from the number of the
    node or element on, and that of its continuations.
    """

    line_number: int
    text: str
    continuations: list[str]


class _Lines(Iterator[str]):
    """Lines of a CalculiX file, one after the other, and readers of the blocks and numbers in them.

    Attributes
    ----------
    path
        the file, for messages
    line_number
        number of the last line taken, counted from 1
    """

    def __init__(self, path: Path, lines: Iterable[str]) -> None:
        self.path = path
        self._numbered = enumerate(lines, start=1)
        self.line_number = 0

    def __next__(self) -> str:
        self.line_number, line = next(self._numbered)
        return line.rstrip()

    def error_expecting(self, expected: str, number: int = 0) -> InputError:
        """The InputError to raise, with file and line; the last line taken where no `number` of a
        line is given.
        """
        return InputError(f"{self.path}: line {number or self.line_number}: expected {expected}")

    def records_below(
        self, header: str, noun: str, header_line: int
    ) -> tuple[int, list[_DataLine]]:
        """Width of a node's or an element's number in characters, and the records of a block of a
        .frd file, from the lines below its header.

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
        n_announced = self.whole_number(
            header[24:36], "the count of records in columns 25 to 36", header_line
        )
        form_number = self.whole_number(
            header[73:].strip()[:1] or "1", "the form of the block (0 or 1)", header_line
        )
        # forms whose node numbers have 5 characters (0) or 10 (1)
        if form_number not in _CHARACTERS_OF_LABEL:
            raise InputError(
                f"{self.path}: line {header_line}: the file is binary (form {form_number}), and"
                " only the ASCII forms are read; write *NODE FILE, *EL FILE and *CONTACT FILE in"
                " place of *NODE OUTPUT, *ELEMENT OUTPUT and *CONTACT OUTPUT"
            )
        records: list[_DataLine] = []
        for line_text in self:
            # key -1: a record; -2: its continuation; -3: the end of the block
            if line_text.startswith(" -1"):
                records.append(_DataLine(self.line_number, line_text[3:], []))
            elif line_text.startswith(" -2") and records:
                records[-1].continuations.append(line_text[3:])
            elif line_text.startswith(" -3"):
                if len(records) != n_announced:
                    raise self.error_expecting(
                        f"{n_announced} {noun} as announced here, found {len(records)}", header_line
                    )
                return _CHARACTERS_OF_LABEL[form_number], records
            else:
                raise self.error_expecting(
                    "the head of a record (-1), then its rest (-2), or the end of the block (-3),"
                    f" found {line_text[:40]!r}"
                )
        raise self.error_expecting(
            f"the end of the block (-3): the file breaks off after {len(records)} of {n_announced}"
            f" {noun}"
        )

    def nodes_below(self, header: str) -> tuple[Integers, Array]:
        """Numbers (n,) and coordinates (n, 3) of the nodes in the block below `header` [length].
        InputError where a number comes twice, or a coordinate is not finite.
        """
        header_line_number = self.line_number
        # characters of a node's number; records with their continuations
        label_width, records = self.records_below(header, "nodes", header_line_number)
        nodes, points = self.table_of_records(records, label_width, 3)
        if len(np.unique(nodes)) < len(nodes):
            raise self.error_expecting(
                "every node once: a number comes twice", header_line_number + 1
            )
        # 1e100: the square of a larger coordinate would be infinite
        if not (np.abs(points) <= _LARGEST_COORDINATE).all():
            raise self.error_expecting("finite coordinates", header_line_number + 1)
        return nodes, points

    def elements_below(self, header: str) -> Iterator[FrdElement]:
        """Number, kind and node numbers of each element of a .frd file, in the block below
        `header`. InputError for an element without nodes.
        """
        header_line_number = self.line_number
        # characters of a node's or element's number; records with their continuations
        label_width, records = self.records_below(header, "elements", header_line_number)
        for line_number, record_text, continuations in records:
            number = self.whole_number(
                record_text[:label_width], "an element's number", line_number
            )
            kind = self.whole_number(record_text[label_width:][:5], "its kind", line_number)
            texts_of_nodes = [
                continuation[begin : begin + label_width]
                for continuation in continuations
                for begin in range(0, len(continuation), label_width)
            ]
            nodes = tuple(
                self.whole_number(text, "a node's number", line_number + 1)
                for text in texts_of_nodes
            )
            if not nodes:
                raise self.error_expecting(
                    f"nodes (-2) of every element, found none of element {number}",
                    header_line_number,
                )
            yield FrdElement(number, kind, nodes)

    def components_below(self) -> tuple[str, tuple[str, ...]]:
        """Name of a result block of a .frd file and the names of its components, from the lines
        below its header. InputError where these lines are not there.
        """
        line = next(self, "")
        if not line.startswith(" -4"):
            raise self.error_expecting(f"the name of a result block (-4), found {line[:40]!r}")
        name = line[5:13].strip()
        components = []
        # key -4: name of the block; -5: a component
        n_announced = self.whole_number(line[13:18], "how many components the block has")
        for _ in range(n_announced):
            line = next(self, "")
            if not line.startswith(" -5"):
                raise self.error_expecting(
                    f"the name of a component (-5), {n_announced} in all, found {line[:40]!r}"
                )
            # ALL, which a viewer works out, is announced and is not in the file
            if line[33:38].strip() != "1":
                components.append(line[5:13].strip())
        return name, tuple(components)

    def table_of_records(
        self, records: list[_DataLine], label_width: int, n_columns: int
    ) -> tuple[Integers, Array]:
        """Node numbers (n,) and values (n, n_columns), one row for each record of a block of a .frd
        file. A record is the number of a node and values of 12 characters each, without blanks
        between them. InputError for a record of another length.

        Parameters
        ----------
        records
            of each record: number of its first line in the file (`line_number`); text of that line
            from the node's number on; texts of the lines that continue it, which begin with
            `label_width` blanks in place of a node's number
        label_width
            number of characters of a node's number
        n_columns
            number of values of each record
        """
        nodes: list[int] = []
        value_texts: list[str] = []
        for line_number, record_text, continuations in records:
            text_of_values = record_text[label_width:] + "".join(
                continuation[label_width:] for continuation in continuations
            )
            if len(text_of_values) != _CHARACTERS_OF_NUMBER * n_columns:
                # the key of three characters before the node's number is not in `record_text`
                expected_length = 3 + label_width + _CHARACTERS_OF_NUMBER * n_columns
                record_length = 3 + label_width + len(text_of_values)
                raise self.error_expecting(
                    f"{n_columns} numbers of {_CHARACTERS_OF_NUMBER} characters, {expected_length}"
                    f" in all, found {record_length}: {record_text[:40]!r}",
                    line_number,
                )
            nodes.append(
                self.whole_number(record_text[:label_width], "a node's number", line_number)
            )
            value_texts += [
                text_of_values[begin : begin + _CHARACTERS_OF_NUMBER]
                for begin in range(0, len(text_of_values), _CHARACTERS_OF_NUMBER)
            ]
        try:
            values = np.array(value_texts, f"S{_CHARACTERS_OF_NUMBER}").astype(float)
        except ValueError:  # Fortran writes 1.5-120, without E: read one by one
            values = np.array(
                [
                    self.decimal_number(text, "a number", records[index // n_columns].line_number)
                    for index, text in enumerate(value_texts)
                ]
            )
        return np.array(nodes, np.int64), values.reshape(len(nodes), n_columns)

    def decimal_number(self, text: str, noun: str = "a number", line: int = 0) -> float:
        """The number that the text states, also as Fortran writes it, without E before an exponent
        of three digits. InputError with `noun` and the number of the `line`, 0 for the last line
        taken.
        """
        try:
            return float(text)
        except ValueError:
            # mantissa, then an exponent with or without its letter
            match = _DECIMAL_NUMBER.fullmatch(text.strip())
        if match is None:
            raise self.error_expecting(f"{noun}, found {text[:40]!r}", line)
        mantissa = match[1]
        exponent = match[2] or match[3] or 0
        return float(f"{mantissa}e{exponent}")

    def whole_number(self, text: str, noun: str, line: int = 0) -> int:
        """The whole number that the text states."""
        if not _WHOLE_NUMBER.fullmatch(text):
            raise self.error_expecting(f"{noun}, found {text[:40]!r}", line)
        return int(text)


# ----------------------------------------------------------------------------------- printed tables
# The titles: " quantity (columns) for scope and time 0.5E+00" and " statistics for slave set A,
# master set B and time 0.5E+00".
_TITLE = re.compile(
    r" ?(?P<quantity>[a-z][^()]*?) ?\((?P<columns>[^)]*)\) for (?P<scope>.*?) and"
    r" time\s*(?P<time>\S+)\s*"
)
_TITLE_OF_PAIR = re.compile(
    r" ?statistics for slave set (?P<slave>[^,]+), ?master set (?P<master>.+?) and"
    r" time\s*(?P<time>\S+)\s*"
)
# Words that stand for the numbers of what a row belongs to, and how many numbers they are; other
# tables name their values alone.
_N_IDS_BY_NAME = {"slave node": 1, "slave element+face": 2}


@dataclass(frozen=True, eq=False)
class DatTable:
    """One printed table."""

    quantity: str  # such as "contact stress", "relative contact displacement", "total force"
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
        # " statistics for slave set A, master set B and time ..."
        pair_title = _TITLE_OF_PAIR.fullmatch(line)
        if pair_title:
            pair_forces.append(_pair_force(reader, lines, title_line_number, pair_title))
            continue
        # " quantity (columns) for scope and time ..."
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
    reader: _Lines, lines: Sequence[str], title_line: int, title: re.Match[str]
) -> PairForce:
    """The resultant force of a contact pair and its mean normal, from the statistics that CalculiX
    prints below a title.

    Parameters
    ----------
    reader
        reads numbers, and has the file's path for messages
    lines
        all lines of the file
    title_line
        number of the title's line, counted from 1
    title
        match of the title with the names of the pair
    """

    def six_numbers_under(heading: str) -> Array:
        """The six numbers two lines below the line that begins with `heading`, in the statistics
        that CalculiX prints for a contact pair. The heading comes within 19 lines of the title.

        `lines` are all lines of the file, `title_line` is the number of the title's line, counted
        from 1; `reader` reads numbers and makes errors with file and line.
        """
        lines_of_statistics = lines[title_line : title_line + 19]
        for heading_line_number, line_text in enumerate(lines_of_statistics, start=title_line + 1):
            if line_text.strip().startswith(heading) and heading_line_number + 1 < len(lines):
                number_texts = lines[heading_line_number + 1].split()
                if len(number_texts) != 6:
                    raise reader.error_expecting(
                        f"6 numbers under {heading!r}, found {len(number_texts)}",
                        heading_line_number + 2,
                    )
                return np.array(
                    [
                        reader.decimal_number(text, line=heading_line_number + 2)
                        for text in number_texts
                    ]
                )
        raise reader.error_expecting(
            f"{heading!r} below this title: the file breaks off", title_line
        )

    force_and_moment = six_numbers_under("total surface force")
    centre_and_normal = six_numbers_under("center of gravity and mean normal")
    return PairForce(
        title["slave"].strip(),
        title["master"].strip(),
        reader.decimal_number(title["time"], line=title_line),
        force=force_and_moment[:3],
        normal=centre_and_normal[3:],
    )


def _printed_table(
    reader: _Lines, lines: Sequence[str], title_line: int, title: re.Match[str]
) -> DatTable:
    """A table printed in a .dat file: ids (n, n_ids), which are CalculiX's numbers of nodes,
    elements or element faces; and values (n, n_values).

    It begins below the title and blank lines, and ends before the next blank line or title.
    InputError for a row of another length.

    Parameters
    ----------
    reader
        reads numbers, and has the file's path for messages
    lines
        all lines of the file
    title_line
        number of the title's line, counted from 1
    title
        match of the title: what is printed, its columns, for which set and at which time
    """
    begin, end = _lines_of_table(lines, title_line)
    rows = [line.split() for line in lines[begin:end]]
    column_names = title["columns"].split(",")
    first_name = column_names[0].strip()
    n_values = len(column_names)
    # columns "slave node" or "slave element+face": one id or two, then values
    if first_name in _N_IDS_BY_NAME:
        n_values -= 1
        n_ids = _N_IDS_BY_NAME[first_name]
    else:
        n_ids = max(len(rows[0]) - n_values, 0) if rows else 0
    for line_number, row in enumerate(rows, start=begin + 1):
        if len(row) != n_ids + n_values:
            raise reader.error_expecting(
                f"{n_ids + n_values} numbers ({title['columns']}), found {len(row)}", line_number
            )
    ids = []
    values = []
    noun = "the number of a node, element or face"
    for line_number, row in enumerate(rows, start=begin + 1):
        ids.append([reader.whole_number(text, noun, line_number) for text in row[:n_ids]])
        values.append([reader.decimal_number(text, line=line_number) for text in row[n_ids:]])
    return DatTable(
        title["quantity"],
        title["scope"].strip(),
        reader.decimal_number(title["time"], line=title_line),
        np.array(ids, np.int64).reshape(len(rows), n_ids),
        np.array(values, float).reshape(len(rows), n_values),
    )


def _lines_of_table(lines: Sequence[str], title_line: int) -> tuple[int, int]:
    """Index of the first line of a printed table, and of the line behind its last one, both counted
    from 0. The table begins below its title and blank lines, and ends before the next blank line or
    title. `title_line` is the number of the title's line, counted from 1.
    """
    begin = title_line  # the line below the title
    while begin < len(lines) and not lines[begin].strip():
        begin += 1
    end = begin
    while end < len(lines) and lines[end].strip() and " time" not in lines[end]:
        end += 1
    return begin, end
