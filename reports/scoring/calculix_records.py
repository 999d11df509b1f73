"""Records of fixed width as CalculiX' .frd file has them: lines with their number, blocks up to their end, tables of numbers."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scenes import InputError

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

WIDTH = 12  # characters a number, with no blank kept between two
_END = b" -3"
# Fortran drops the E before an exponent of three digits: 1.46685-100.
_NUMBER = re.compile(rb"([+-]?(?:\d+\.?\d*|\.\d+))(?:[EeDd]?([+-]\d+)|[EeDd](\d+))?")
_INTEGER = re.compile(rb" *[+-]?\d+ *")


class Lines(Iterator[bytes]):
    """Lines of a file without their ends, and the number of the last one taken."""

    def __init__(self, path: Path, numbered: Iterator[tuple[int, bytes]]) -> None:
        self.path, self._numbered, self.number = path, numbered, 0

    def __next__(self) -> bytes:
        self.number, line = next(self._numbered)
        return line.rstrip(b"\r\n")

    def refusal(self, expected: str, number: int = 0) -> InputError:
        """The error to raise, with file and line."""
        return InputError(f"{self.path}: line {number or self.number}: expected {expected}")

    def records(self, of: str) -> list[bytes]:
        """The lines of a block up to its end."""
        found: list[bytes] = []
        for line in self:
            if line.startswith(_END):
                return found
            if line[:3] not in {b" -1", b" -2"}:
                raise self.refusal(f"a record of {of} (-1, -2) or the end of the block (-3), found {shown(line)}")
            found.append(line)
        raise self.refusal(f"more of {of}: the file breaks off, {len(found)} lines into the block and without its end (-3)")


def table(lines: Lines, records: list[bytes], label: int, columns: int, start: int) -> tuple[Integers, Array]:
    """Node numbers (n_records,) and values (n_records, columns) of ` -1` records and their ` -2` continuations, six numbers a line.

    Parameters
    ----------
    records : the lines
    label : characters of a node's number
    start : number of the first line in the file
    """
    per_record = max(1, -(-columns // 6))
    if len(records) % per_record:
        raise lines.refusal(f"{per_record} lines a record, found {len(records)} lines in the block")
    parts = []
    for k in range(per_record):
        places = range(start + k, start + len(records), per_record)
        share = min(6, columns - 6 * k)
        key = b" -2" if k else b" -1"
        parts.append(_numbers(lines, records[k::per_record], key, label, share, places))
    heads = enumerate(records[::per_record])
    nodes = [integer_in(lines, line[3 : 3 + label], "a node's number", start + per_record * at) for at, line in heads]
    return np.array(nodes, np.int64), np.concatenate(parts, axis=1)


def _numbers(lines: Lines, records: list[bytes], key: bytes, label: int, columns: int, places: range) -> Array:
    """(n_records, columns): all lines at once; number by number where one is not as Python writes it."""
    width = 3 + label + WIDTH * columns
    trimmed = [line if len(line) == width else line.rstrip() for line in records]
    for line, place in zip(trimmed, places, strict=True):
        if len(line) != width or line[:3] != key:
            raise lines.refusal(
                f"{key.decode().strip()} and {columns} numbers of {WIDTH} characters, {width} in all, "
                f"found {len(line)}: {shown(line)}",
                place,
            )
    if not trimmed:
        return np.empty((0, columns))
    letters = np.frombuffer(b"".join(trimmed), "S1").reshape(-1, width)[:, 3 + label :]
    words = np.ascontiguousarray(letters).view(f"S{WIDTH}")
    try:
        return words.astype(float)
    except ValueError:
        rows = zip(words.tolist(), places, strict=True)
        return np.array([[number_in(lines, word, "a number", place) for word in row] for row, place in rows])


def number_in(lines: Lines, text: bytes, what: str, number: int = 0) -> float:
    """The number that the text states, also as Fortran writes it.

    >>> number_in(Lines(Path("x.frd"), iter(())), b" 1.46685-100", "a number")
    1.46685e-100
    """
    bare = text.strip()
    try:
        return float(bare)
    except ValueError:
        found = _NUMBER.fullmatch(bare)
    if found is None:
        raise lines.refusal(f"{what}, found {shown(text)}", number)
    return float(found[1] + b"e" + (found[2] or found[3] or b"0"))


def integer_in(lines: Lines, text: bytes, what: str, number: int = 0) -> int:
    """The integer that the text states, blanks beside it."""
    if not _INTEGER.fullmatch(text):
        raise lines.refusal(f"{what}, found {shown(text)}", number)
    return int(text)


def expect_count(lines: Lines, announced: int, found: int, what: str, number: int) -> None:
    """Refuse a block whose header announces another count than it has."""
    if announced != found:
        raise lines.refusal(f"{announced} {what} as announced here, found {found}", number)


def shown(line: bytes) -> str:
    """The beginning of a line, in a sentence."""
    return repr(line[:40].decode("ascii", errors="replace"))
