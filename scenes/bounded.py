"""Files from outside, taken whole only up to a stated size: a huge file, a device or a pipe is refused before memory is taken."""

from __future__ import annotations

import json
import stat
import sys
from collections.abc import Generator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

from scenes.errors import InputError

# None where the system has no such thing; the sizes that files state are checked all the same.
resource = import_module("resource") if find_spec("resource") else None

# Bytes. A TOML file is written by hand, and its parser is slow; tables of numbers go to CSV, answers to NetCDF.
TOML, TEXT, SOLUTION = 2**22, 2**28, 2**31
_SHOWN = 120


def text_of(path: Path, what: str, most: int = TEXT, advice: str = "") -> str:
    """The text of a regular file of at most `most` bytes, without a byte-order mark.

    Parameters
    ----------
    what : what the file is to the user, as in "the scene file"
    advice : what to do about one that is too large

    Raises
    ------
    InputError
        One sentence: it can't be read, is no regular file, is too large (with the limit), or is not UTF-8 text.
    """
    try:
        check_size(path, what, most, advice)
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as reason:
        raise InputError(f"{path}: {what} can't be read: it is not UTF-8 text") from reason
    except (OSError, ValueError) as reason:  # ValueError: a name with a null character in it
        if isinstance(reason, InputError):
            raise
        why = (reason.strerror if isinstance(reason, OSError) else None) or str(reason)
        raise InputError(f"{path}: {what} can't be read: {why}") from reason


def check_size(path: Path, what: str, most: int, advice: str = "") -> None:
    """InputError where `path` is no regular file, or one of more than `most` bytes; OSError where it can't be looked at."""
    found = path.stat()
    if stat.S_ISDIR(found.st_mode):
        raise InputError(f"{path}: {what} can't be read: Is a directory")
    if not stat.S_ISREG(found.st_mode):
        raise InputError(f"{path}: {what} can't be read: it is no regular file but a pipe or a device; write it to a file first")
    if found.st_size > most:
        more = f"; {advice}" if advice else ""
        raise InputError(f"{path}: {what} has {in_words(found.st_size)}, and at most {in_words(most)} are read{more}")


def parsed_json(text: str) -> Any:
    """What the JSON text says; ValueError for every fault of it: brackets nested by the thousand, integers beyond every float.

    >>> parsed_json('{"n": 3}')
    {'n': 3}
    """
    try:
        return json.loads(text, parse_int=_whole_number)
    except RecursionError as reason:
        raise ValueError("it is nested too deeply") from reason


def _whole_number(digits: str) -> int:
    number = int(digits)
    if abs(number) > sys.float_info.max:
        raise ValueError(f"it holds a whole number of {len(digits)} digits")
    return number


def in_words(size: int) -> str:
    """Bytes for a reader.

    >>> in_words(2**28), in_words(2_000), in_words(7)
    ('268 MB', '2 kB', '7 bytes')
    """
    for name, unit in (("GB", 10**9), ("MB", 10**6), ("kB", 10**3)):
        if size >= unit:
            return f"{size / unit:.3g} {name}"
    return f"{size} bytes"


def shown(value: object) -> str:
    """A value of a file in a sentence: as Python writes it, its beginning where it is long.

    >>> shown([0.5]), len(shown("x" * 10**6))
    ('[0.5]', 124)
    """
    try:
        text = repr(value)
    except RecursionError:
        return "something nested too deeply"
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]} ..."


@contextmanager
def within_memory(path: Path, most: int) -> Generator[None, None, None]:
    """While a foreign file is unpacked by a library, the process may grow by `most` bytes and no more (POSIX only).

    What compresses a terabyte into a megabyte shows its size only while it is unpacked: then the allocation fails, not the machine.

    Raises
    ------
    InputError
        Where it wanted more.
    """
    if resource is None:
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    room = _taken(resource) + most
    allowed = [limit for limit in (soft, hard, room) if limit != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_AS, (min(allowed), hard))
    try:
        yield
    except MemoryError as reason:
        raise InputError(
            f"{path}: unpacked it takes more than {in_words(most)} of memory, which is the limit; write the contact surface alone"
        ) from reason
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _taken(resource: ModuleType) -> int:
    """Address space of this process [bytes]."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    except OSError:
        return int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) * 1024
    return pages * int(resource.getpagesize())
