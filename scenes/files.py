"""Files: read only up to a stated size, written whole or not at all. Text, tables of keys (TOML,
JSON), source files.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import stat
import sys
import tempfile
import tomllib
from collections.abc import Generator, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, cast

from scenes.errors import InputError, in_words, shortened_repr

# None where the system has no such thing; the sizes that files state are checked all the same.
resource = import_module("resource") if find_spec("resource") else None

# Largest files that are read [bytes]. A TOML file is written by hand, and its parser is slow;
# tables of numbers go to CSV, answers to NetCDF.
LARGEST_TOML_BYTES = 2**20
LARGEST_TEXT_BYTES = 2**28
# Of TOML beside its size: scenes and studies nest 4 tables, and have some hundred keys; a key takes
# up to 1 kB for each of its parts. A number of so many hexadecimal digits is still a float.
_LARGEST_NESTING_DEPTH = 8
_MOST_KEYS = 10_000
_MOST_CHARACTERS_OF_NAME = 250
# Only repeats of single characters are possessive: those of groups match wrongly before Python
# 3.11.5 (Debian 12 has 3.11.2).
_KEY_PART = r"""(?:[A-Za-z0-9_-]++|"[^"\\\n]*+(?:\\[^\n][^"\\\n]*+)*"?|'[^'\n]*+'?)"""
# What is not closed ends with its line or the text: nothing behind it is read by the parser either.
_TOML_TOKENS = re.compile(
    rf"""\#[^\n]*+                                                     # a comment
    | "{{3}}[^"\\]*+(?:(?:\\.|"(?!""))[^"\\]*+)*(?:"{{3,5}}|\\?\Z)     # strings of several lines
    | '{{3}}[^']*+(?:'(?!'')[^']*+)*(?:'{{3,5}}|\Z)
    # keys, and numbers, which look like them
    | (?P<deep>{_KEY_PART}(?:[ \t]*+\.[ \t]*+{_KEY_PART}){{{_LARGEST_NESTING_DEPTH},}})
    | (?P<long>[A-Za-z0-9_-]{{{_MOST_CHARACTERS_OF_NAME},}}+)
    | {_KEY_PART}
    | (?P<sign>[][{{}}=])""",
    re.DOTALL | re.VERBOSE,
)


def text_of(path: Path, role: str, most_bytes: int = LARGEST_TEXT_BYTES, advice: str = "") -> str:
    """Read a text file in UTF-8, after a check of its kind and size; without a byte-order mark.

    Parameters
    ----------
    path
        of the file
    role
        what the file is to the user, as in "the scene file", for the message
    most_bytes
        largest size that is read
    advice
        what to do about a larger one, for the message

    Raises
    ------
    InputError
        One sentence: the file can't be read, is a pipe or a device, is too large (with the limit),
        or is not UTF-8 text.
    """
    try:
        # A folder, a pipe, a device or a larger file raises.
        require_readable_size(path, role, most_bytes, advice)
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as reason:
        raise InputError(f"{path}: {role} can't be read: it is not UTF-8 text") from reason
    except (OSError, ValueError) as reason:  # ValueError: a name with a null character in it
        if isinstance(reason, InputError):
            raise
        # The system's own words for the error (`strerror`), where it has any.
        cause = (reason.strerror if isinstance(reason, OSError) else None) or str(reason)
        raise InputError(f"{path}: {role} can't be read: {cause}") from reason


def require_readable_size(path: Path, role: str, most_bytes: int, advice: str = "") -> None:
    """Refuse to read a file that is a folder, a pipe or a device, or larger than `most_bytes`.

    Parameters
    ----------
    path
        of the file
    role
        what the file is to the user, as in "the scene file", for the message
    most_bytes
        largest size that is read
    advice
        what to do about one that is too large, for the message

    Raises
    ------
    InputError
        For the kind or the size of the file.
    OSError
        Where there is no such file, or no right to read it.
    """
    # Kind (`st_mode`) and size in bytes of the file.
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise InputError(f"{path}: {role} can't be read: Is a directory")
    if not stat.S_ISREG(status.st_mode):
        raise InputError(
            f"{path}: {role} can't be read: it is no regular file but a pipe or a device; write it"
            " to a file first"
        )
    if status.st_size > most_bytes:
        remark = f"; {advice}" if advice else ""
        raise InputError(
            f"{path}: {role} has {in_words(status.st_size)}, and at most {in_words(most_bytes)} are"
            f" read{remark}"
        )


def parsed_json(text: str) -> Any:
    """The content of a JSON text. ValueError for every fault of it, such as brackets nested by the
    thousand, or integers beyond every float.

    >>> parsed_json('{"n": 3}')
    {'n': 3}
    """
    try:
        return json.loads(text, parse_int=_whole_number)
    except RecursionError as reason:
        raise ValueError("it is nested too deeply") from reason


def parsed_toml(text: str) -> dict[str, Any]:
    """Parse a TOML text into a table of keys; ValueError for every fault of it, with its line.

    Depth of tables (8), number of keys (10,000) and length of names (249 characters) are limited.
    They are counted before the parser sees the text, since its memory grows with the square of the
    number of parts of a key such as a.b.c.

    >>> parsed_toml("a.b = 3")
    {'a': {'b': 3}}
    >>> parsed_toml("a." * 1000 + "b = 3")
    Traceback (most recent call last):
    ValueError: Tables nested deeper than 8 (at line 1, column 1)
    """
    n_open_brackets = 0
    n_keys = 0
    previous_symbol = ""
    # Tokens: comments, strings, keys and numbers, brackets. "deep" is a key of too many parts,
    # "long" a word with too many characters.
    # `_TOML_TOKENS`: the pattern of a token
    for token in _TOML_TOKENS.finditer(text):
        symbol = token["sign"] or ""  # a bracket, or the equals sign between key and value
        is_table_heading = symbol == "[" and n_open_brackets == 0 and previous_symbol != "="
        n_keys += symbol == "=" or is_table_heading
        if symbol in ("[", "{"):
            n_open_brackets += 1
        elif symbol in ("]", "}"):
            n_open_brackets -= 1
        previous_symbol = symbol
        # _LARGEST_NESTING_DEPTH: 8 tables within each other
        is_too_deep = bool(token["deep"]) or n_open_brackets > _LARGEST_NESTING_DEPTH
        if is_too_deep or token["long"] or n_keys > _MOST_KEYS:
            if is_too_deep:
                fault = f"Tables nested deeper than {_LARGEST_NESTING_DEPTH}"
            elif token["long"]:
                fault = f"A key or a number of {_MOST_CHARACTERS_OF_NAME} characters or more"
            else:
                fault = f"More than {_MOST_KEYS:,} keys"
            line = text.count("\n", 0, token.start()) + 1
            column = token.start() - text.rfind("\n", 0, token.start())
            raise ValueError(f"{fault} (at line {line}, column {column})")
    return tomllib.loads(text)


def keys_of(path: Path, role: str, advice: str = "") -> dict[str, Any]:
    """Read a file of keys and values that a user has written, such as a scene: JSON where its name
    ends in .json, else TOML. An empty file has no keys.

    Parameters
    ----------
    path
        of the file
    role
        what the file is to the user, as in "the scene file", for the message
    advice
        what to do about one that is too large, for the message

    Raises
    ------
    InputError
        One sentence: the file can't be read, is too large or no UTF-8 text; is no valid TOML or
        JSON, with the line; or holds a list.
    """
    is_json = path.suffix == ".json"
    # The text of the file; limits are 268 MB for JSON, 1 MB for TOML.
    text = text_of(path, role, LARGEST_TEXT_BYTES if is_json else LARGEST_TOML_BYTES, advice)
    if not text.strip():
        return {}
    try:
        keys = parsed_json(text) if is_json else parsed_toml(text)
    except (ValueError, RecursionError) as reason:
        # Errors of the parsers, and numbers of thousands of digits.
        fault = f"not valid JSON: {reason}" if is_json else _fault_of_toml(text, str(reason))
        raise InputError(f"{path}: {fault}") from reason
    if not isinstance(keys, dict):
        raise InputError(f"{path}: {role} is a table of keys, not a {type(keys).__name__}")
    return cast(dict[str, Any], keys)


def _fault_of_toml(text: str, reason: str) -> str:
    """Message on a fault of a TOML text: the parser's reason, the line of the text that it names,
    and advice where a decimal comma stands in that line.
    """
    fault = f"not valid TOML: {reason}"
    place_in_message = re.search(r"\(at line (\d+), column \d+\)", reason)
    text_lines = text.split("\n")
    if place_in_message and 0 < int(place_in_message[1]) <= len(text_lines):
        line = text_lines[int(place_in_message[1]) - 1].strip()
        has_decimal_comma = re.search(r"=\s*[-+]?\d+,\d", line) is not None
        advice = "; write a decimal point, not a comma" if has_decimal_comma else ""
        fault += f", in {shortened_repr(line)}{advice}"
    return fault


def _whole_number(digits: str) -> int:
    """A whole number of a JSON text; ValueError for one beyond every float."""
    number = int(digits)
    if abs(number) > sys.float_info.max:
        raise ValueError(f"it holds a whole number of {len(digits)} digits")
    return number


@contextmanager
def within_memory(path: Path, most_bytes: int) -> Generator[None, None, None]:
    """Context manager in which the memory of this process may grow by `most_bytes` and no more,
    while a library unpacks a file from elsewhere (POSIX only).

    A terabyte of zeros is a megabyte when compressed, and shows its size only while it is unpacked.
    With the limit the allocation fails, not the machine. Systems without such limits have none.

    Raises
    ------
    InputError
        Where the file needs more; `path` is named in the message.
    """
    if resource is None:
        yield
        return
    # RLIMIT_AS: limit of the address space of this process.
    soft_limit, hard_limit = resource.getrlimit(resource.RLIMIT_AS)
    try:  # the address space of this process, in pages
        n_pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        used_bytes = n_pages * int(resource.getpagesize())
    except OSError:  # no Linux: its largest use so far, in kB
        used_bytes = int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) * 1024
    bytes_allowed = used_bytes + most_bytes

    finite_limits = [
        limit
        for limit in (soft_limit, hard_limit, bytes_allowed)
        if limit != resource.RLIM_INFINITY
    ]
    # The lowest limit holds while the file is unpacked.
    resource.setrlimit(resource.RLIMIT_AS, (min(finite_limits), hard_limit))
    try:
        yield
    except MemoryError as reason:
        raise InputError(
            f"{path}: unpacked it takes more than {in_words(most_bytes)} of memory, which is the"
            " limit; write the contact surface alone"
        ) from reason
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft_limit, hard_limit))


def write_keys(path: Path, keys: Mapping[str, Any]) -> None:
    """Write a table of keys and values, such as a scene, to the .toml or .json file at `path`,
    whole or not at all.

    Raises
    ------
    InputError
        One sentence: for another suffix, for more bytes than can be read back, for a place where
        nothing can be written.
    """
    if path.suffix not in (".toml", ".json"):
        raise InputError(
            f"{path}: a scene file ends in .toml or .json, not in {path.suffix or 'nothing'!r}"
        )
    is_json = path.suffix == ".json"
    content = (
        json.dumps(keys, ensure_ascii=False, indent=1) if is_json else toml_text(keys)
    ).encode()
    # What `keys_of` would read again: 268 MB of JSON, 1 MB of TOML.
    most_bytes = LARGEST_TEXT_BYTES if is_json else LARGEST_TOML_BYTES
    if len(content) > most_bytes:
        remark = "" if is_json else "; save it as .json"
        raise InputError(
            f"{path}: the scene takes {in_words(len(content))}, and at most {in_words(most_bytes)}"
            f" would be read{remark}"
        )
    try:
        replace_file(path, content)
    except OSError as reason:
        raise InputError(
            f"{path}: the scene can't be written: {reason.strerror or reason}"
        ) from reason


def replace_file(
    path: str | Path, content: bytes | memoryview, temporary_path: Path | None = None
) -> None:
    """Replace a file in one go: a reader, or the disk after a crash, has the whole old file or the
    whole new one.

    The content goes to a temporary file in the same folder, which is then renamed to `path`.

    Parameters
    ----------
    path
        of the file; a symbolic link stays one
    content
        bytes of the new file
    temporary_path
        an existing, empty temporary file in the same folder, with a name of the caller's; None: one
        is made

    Raises
    ------
    OSError
        Where it can't be written; the old one stays.
    """
    target = Path(os.path.realpath(path))  # a link stays one
    if temporary_path is None:
        # Zeros in place of a machine and a process: what a killed process leaves is removed once it
        # is old (`reports.folder.remove_left_behind`).
        handle, name = tempfile.mkstemp(prefix=".halfplane-000000-", dir=target.parent)
        os.close(handle)
        temporary_path = Path(name)
    try:
        with temporary_path.open("r+b") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())  # some disks say only now that they are full
        # A temporary file is private; the new file gets the rights of any file of this user. The
        # mask can only be read by setting it.
        rights_mask = os.umask(0)
        os.umask(rights_mask)
        os.chmod(temporary_path, 0o666 & ~rights_mask)
        os.replace(temporary_path, target)
    finally:
        temporary_path.unlink(missing_ok=True)


def toml_text(keys: Mapping[str, Any]) -> str:
    """Text of a TOML file for a table of keys: numbers, words and lists first, then tables and
    lists of tables under headings.

    >>> print(
    ...     toml_text({"load": {"initial_loading": [[1.0, 0.0]], "kind": "polygon"}, "cycles": 6})
    ... )
    cycles = 6
    <BLANKLINE>
    [load]
    initial_loading = [[1.0, 0.0]]
    kind = "polygon"
    <BLANKLINE>
    """
    # `_toml_lines`: the lines of the tables, here without a heading of their own.
    return "\n".join(_toml_lines(keys, "")).lstrip("\n") + "\n"


def _toml_lines(keys: Mapping[str, Any], heading_begin: str) -> Iterator[str]:
    """Lines of a TOML file for a table of keys: first the keys with plain values, then the tables
    in it, each under a heading [name] or, for a list of tables, [[name]].

    `heading_begin` is the full name of this table with a dot behind it, as in "load.", and ""
    at the top.
    """
    inner_tables = {
        key: value if isinstance(value, list) else [value]
        for key, value in keys.items()
        if _is_table(value)
    }

    # Plain values first: behind a heading they would belong to its table.
    for key in keys:
        if key not in inner_tables:
            # Words, numbers and lists of JSON are those of TOML, but for one control character.
            yield f"{key} = {json.dumps(keys[key], ensure_ascii=False)}".replace("\x7f", "\\u007f")
    for key, tables_of_key in inner_tables.items():
        for table in tables_of_key:
            if isinstance(keys[key], list):
                yield from ("", f"[[{heading_begin}{key}]]")
            # A table that holds nothing but tables needs no heading of its own.
            elif not table or not all(map(_is_table, table.values())):
                yield from ("", f"[{heading_begin}{key}]")
            yield from _toml_lines(table, f"{heading_begin}{key}.")


def _is_table(value: Any) -> bool:
    """Whether the value of a key is a table, or a list of tables."""
    return isinstance(value, dict) or (
        isinstance(value, list) and bool(value) and isinstance(value[0], dict)
    )


@cache
def source_digest(*names: str) -> str:
    """SHA-256 hash of the source code of modules, or of packages with all files in them. It ties a
    cached result to the code that made it.

    It is computed once in each process. `names` are dotted module names, such as "scenes.files".

    Raises
    ------
    InputError
        Where a module is missing, or is there without its source.

    Examples
    --------
    >>> len(source_digest("scenes.files"))
    64
    """
    digest = hashlib.sha256()
    for name in names:
        try:
            # Where the module lies: file (`origin`), and folders of a package.
            spec = find_spec(name)
        except ModuleNotFoundError:
            spec = None
        # A module is one file; a package has all files in its folders.
        files = [] if spec is None or spec.origin is None else [Path(spec.origin)]
        for folder in (spec and spec.submodule_search_locations) or ():
            files = sorted(Path(folder).rglob("*.py"))
        if not files or any(file.suffix != ".py" or not file.is_file() for file in files):
            raise InputError(
                f"{name}: this installation lacks the module's source file; install halfplane again"
            )
        for path in files:
            content = path.read_bytes()
            digest.update(f"{path.name}\0{len(content)}\0".encode() + content)
    return digest.hexdigest()
