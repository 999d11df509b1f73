"""CalculiX' printed file .dat: its tables, as *CONTACT PRINT, *NODE PRINT and their like write them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from reports.scoring.calculix_frd import check_size
from scenes import InputError

Array = NDArray[np.float64]

# The titles: " what (columns) for scope and time 0.5E+00" and " statistics for slave set A, master set B and time 0.5E+00".
_TITLE = re.compile(r" ?(?P<what>[a-z][^()]*?) ?\((?P<columns>[^)]*)\) for (?P<scope>.*?) and time\s*(?P<time>\S+)\s*")
_STATISTICS = re.compile(r" ?statistics for slave set (?P<slave>[^,]+), ?master set (?P<master>.+?) and time\s*(?P<time>\S+)\s*")
# Words that stand for the numbers of what a row belongs to, and how many numbers they are; other tables name their values alone.
_IDS = {"slave node": 1, "slave element+face": 2}


@dataclass(frozen=True, eq=False)
class DatTable:
    """One printed table.

    Attributes
    ----------
    what : such as "contact stress", "relative contact displacement", "total force"
    columns : as the title names them, such as "slave node", "press", "tang1", "tang2"
    scope : what it was printed for, such as "set BOTTOM", "all contact elements"
    time : total time
    ids : (n_rows, k), numbers of node, or of element and face; k = 0 for totals
    values : (n_rows, n_values)
    line : of its title in the file
    """

    what: str
    columns: tuple[str, ...]
    scope: str
    time: float
    ids: NDArray[np.int64]
    values: Array
    line: int


@dataclass(frozen=True, eq=False)
class PairForce:
    """Resultant on the slave face of one contact pair at one time (*CONTACT PRINT, CF).

    Attributes
    ----------
    slave, master : names of the faces
    time : total time
    force : (3,), on the slave face [force]
    normal : (3,), mean outward normal of the slave face; NaN where nothing touches
    """

    slave: str
    master: str
    time: float
    force: Array
    normal: Array


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
    check_size(path)
    lines = path.read_text(encoding="ascii", errors="replace").split("\n")
    tables: list[DatTable] = []
    pairs: list[PairForce] = []
    for at, line in enumerate(lines):
        # Titles begin with a letter; nearly all other lines begin with a number, and are passed over quickly.
        if " time" not in line:
            continue
        if title := _STATISTICS.fullmatch(line):
            pairs.append(_pair(path, lines, at, title))
        elif title := _TITLE.fullmatch(line):
            tables.append(_table(path, lines, at, title))
    if not tables and not pairs:
        raise InputError(f"{path}: no table of CalculiX in it (a title that ends with 'and time ...'); *CONTACT PRINT writes them")
    return DatFile(path, tuple(tables), tuple(pairs))


def _table(path: Path, lines: list[str], at: int, title: re.Match[str]) -> DatTable:
    columns = tuple(word.strip() for word in title["columns"].split(","))
    n_ids, n_values = (_IDS[columns[0]], len(columns) - 1) if columns[0] in _IDS else (None, len(columns))
    rows, first = _rows(lines, at + 1)
    width = len(rows[0]) if rows else (n_ids or 0) + n_values
    n_ids = width - n_values if n_ids is None else n_ids
    for number, row in enumerate(rows, start=first):
        if len(row) != n_ids + n_values or n_ids < 0:
            raise _refusal(path, number, f"{max(n_ids, 0) + n_values} numbers ({title['columns']}), found {len(row)}")
    ids = [[_integer(path, first + k, word) for word in row[:n_ids]] for k, row in enumerate(rows)]
    values = [[_number(path, first + k, word) for word in row[n_ids:]] for k, row in enumerate(rows)]
    return DatTable(
        title["what"],
        columns,
        title["scope"].strip(),
        _number(path, at + 1, title["time"]),
        np.array(ids, np.int64).reshape(len(rows), n_ids),
        np.array(values, float).reshape(len(rows), n_values),
        at + 1,
    )


def _rows(lines: list[str], start: int) -> tuple[list[list[str]], int]:
    """Words of the rows below a title, up to the next blank line or title; and the number of the first row's line."""
    first = start
    while first < len(lines) and not lines[first].strip():
        first += 1
    rows = []
    for line in lines[first:]:
        if not line.strip() or " time" in line:
            break
        rows.append(line.split())
    return rows, first + 1


def _pair(path: Path, lines: list[str], at: int, title: re.Match[str]) -> PairForce:
    force = _after(path, lines, at, "total surface force", 6)[:3]
    normal = _after(path, lines, at, "center of gravity and mean normal", 6)[3:]
    return PairForce(title["slave"].strip(), title["master"].strip(), _number(path, at + 1, title["time"]), force, normal)


def _after(path: Path, lines: list[str], at: int, heading: str, count: int) -> Array:
    """Numbers on the line after next of a heading among the statistics that begin at line `at` (from 0)."""
    for k in range(at + 1, min(at + 20, len(lines) - 2)):
        if lines[k].strip().startswith(heading):
            words = lines[k + 2].split()
            if len(words) != count:
                raise _refusal(path, k + 3, f"{count} numbers under {heading!r}, found {len(words)}")
            return np.array([_number(path, k + 3, word) for word in words])
    raise _refusal(path, at + 1, f"{heading!r} below this title: the file breaks off")


def _number(path: Path, number: int, word: str) -> float:
    try:
        return float(word)
    except ValueError as reason:
        raise _refusal(path, number, f"a number, found {word[:40]!r}") from reason


def _integer(path: Path, number: int, word: str) -> int:
    try:
        return int(np.int64(int(word)))
    except (ValueError, OverflowError) as reason:
        raise _refusal(path, number, f"the number of a node, element or face, found {word[:40]!r}") from reason


def _refusal(path: Path, number: int, expected: str) -> InputError:
    return InputError(f"{path}: line {number}: expected {expected}")
