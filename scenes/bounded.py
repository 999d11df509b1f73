"""Files from outside, taken whole only up to a stated size: a huge file, a device or a pipe is refused before memory is taken."""

from __future__ import annotations

import json
import re
import stat
import sys
import tomllib
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
TOML, TEXT, SOLUTION = 2**20, 2**28, 2**31
_SHOWN = 120
# Of TOML beside its size: scenes and studies nest 4 tables, and have some hundred keys; a key takes up to 1 kB for each of its
# parts. A number of so many hexadecimal digits is still a float.
_DEEPEST, _MOST_KEYS, _LONGEST = 8, 10_000, 250
_PART = r"""(?:[A-Za-z0-9_-]++|"(?:[^"\\\n]|\\[^\n])*+"?|'[^'\n]*+'?)"""
# What is not closed ends with its line or the text: nothing behind it is read by the parser either.
_TOML = re.compile(
    rf"""\#[^\n]*+                                                     # a comment
    | "{{3}}(?:[^"\\]|\\.|"(?!""))*+(?:"{{3,5}}|\\?\Z)                 # strings of several lines
    | '{{3}}(?:[^']|'(?!''))*+(?:'{{3,5}}|\Z)
    | (?P<deep>{_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{_DEEPEST},}})     # keys; numbers and words look like them
    | (?P<long>[A-Za-z0-9_-]{{{_LONGEST},}}+)
    | {_PART}
    | (?P<sign>[][{{}}=])""",
    re.DOTALL | re.VERBOSE,
)


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


def parsed_toml(text: str) -> dict[str, Any]:
    """What the TOML text says; ValueError for every fault of it, among them tables nested too deeply and too many keys.

    These are counted before the parser sees the text: it takes memory with the square of the dots in a key.

    >>> parsed_toml("a.b = 3")
    {'a': {'b': 3}}
    >>> parsed_toml("a." * 1000 + "b = 3")
    Traceback (most recent call last):
    ValueError: Tables nested deeper than 8 (at line 1, column 1)
    """
    depth, keys, before = 0, 0, ""
    for found in _TOML.finditer(text):
        sign = found["sign"] or ""
        keys += sign == "=" or (sign == "[" and depth == 0 and before != "=")  # the latter: the head of a table
        depth += (sign in "[{") - (sign in "]}") if sign else 0
        before = sign
        if found["deep"] or found["long"] or depth > _DEEPEST or keys > _MOST_KEYS:
            what = f"Tables nested deeper than {_DEEPEST}"
            if not found["deep"] and depth <= _DEEPEST:
                what = f"A key or a number of {_LONGEST} characters or more" if found["long"] else f"More than {_MOST_KEYS:,} keys"
            line, column = text.count("\n", 0, found.start()) + 1, found.start() - text.rfind("\n", 0, found.start())
            raise ValueError(f"{what} (at line {line}, column {column})")
    return tomllib.loads(text)


def not_toml(text: str, reason: Exception) -> str:
    """Why TOML was refused, with the line at fault; a comma within a number is pointed at.

    >>> not_toml("a = 1\\nb = 0,4", ValueError("Expected newline (at line 2, column 6)"))
    "not valid TOML: Expected newline (at line 2, column 6), in 'b = 0,4'; write a decimal point, not a comma"
    """
    found = re.search(r"\(at line (\d+), column \d+\)", str(reason))
    lines = text.split("\n")
    if not found or not 0 < int(found[1]) <= len(lines):
        return f"not valid TOML: {reason}"
    line = lines[int(found[1]) - 1].strip()
    comma = "; write a decimal point, not a comma" if re.search(r"=\s*[-+]?\d+,\d", line) else ""
    return f"not valid TOML: {reason}, in {shown(line)}{comma}"


def keys_of(path: Path, what: str, advice: str = "") -> dict[str, Any]:
    """The table of keys in a file, JSON where its name says so, else TOML: the door of every file that a user writes by hand.

    Raises
    ------
    InputError
        One sentence: for what `text_of` refuses (`what`, `advice` as there), for a fault with its line, for a list.
    """
    is_json = path.suffix == ".json"
    text = text_of(path, what, TEXT if is_json else TOML, advice)
    if not text.strip():
        return {}
    try:
        data = parsed_json(text) if is_json else parsed_toml(text)
    except (ValueError, RecursionError) as reason:  # the parsers' own errors, numbers of thousands of digits
        why = f"not valid JSON: {reason}" if is_json else not_toml(text, reason)
        raise InputError(f"{path}: {why}") from reason
    if not isinstance(data, dict):
        raise InputError(f"{path}: {what} is a table of keys, not a {type(data).__name__}")
    return data


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
