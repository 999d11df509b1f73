"""What can go wrong, as exceptions whose text is the one sentence that the user reads; and values
in sentences.
"""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from pathlib import PurePath
from typing import Any, NamedTuple

# Characters of a sentence, of a value in it.
_MOST_CHARACTERS_OF_MESSAGE = 2000
_MOST_CHARACTERS_OF_VALUE = 120
# Plain data, which a sentence states as they are; of other objects it states the class.
_PLAIN_DATA = (bool, int, float, complex, str, bytes, list, tuple, dict, set, PurePath)


class InputError(ValueError):
    """Bad input: one clear sentence naming file, key, value, rule and what to do (exit code 2).

    What stands in a file may be a megabyte long or steer a terminal: the middle of a long sentence
    is left out, and what is not printable is written as its escape.

    >>> str(InputError("a" + chr(27) + "b")).isprintable(), len(str(InputError("x" * 10**6)))
    (True, 2005)
    """

    def __init__(self, sentence: str = "") -> None:
        shortened_sentence = sentence
        if len(sentence) > _MOST_CHARACTERS_OF_MESSAGE:
            half_length = _MOST_CHARACTERS_OF_MESSAGE // 2
            shortened_sentence = f"{sentence[:half_length]} ... {sentence[-half_length:]}"
        super().__init__(
            "".join(
                c if c.isprintable() or c == "\n" else ascii(c)[1:-1] for c in shortened_sentence
            )
        )


class ProfileDataError(InputError):
    """Rows or a function that do not say what the profile is where the bodies touch: no engine has
    an answer to that.
    """


class RowError(ValueError):
    """A fault in one row of a table: `row` counts the rows of numbers from 0."""

    def __init__(self, row: int, rule: str) -> None:
        self.row = row
        self.rule = rule
        super().__init__(f"row {row + 1}: {rule}")

    @classmethod
    def refuse(cls, is_bad: Any, rule: Callable[[int], str], first_number: int = 0) -> None:
        """Raise for the first row that is `is_bad` (n,), the rows being counted from
        `first_number` on; `rule` is given its number.
        """
        if is_bad.any():
            row = first_number + int(is_bad.argmax())
            raise cls(row, rule(row))


_SENTENCES_BY_REASON = {
    "gross sliding": (
        "|Q| exceeds f P, so the bodies slide as a whole and have no equilibrium under load"
        " control; lower the tangential load, raise the normal load or friction.coefficient"
    ),
    "separation": (
        "P is negative there, or 0 where Q is not 0, so the bodies part; keep P > 0 after the start"
    ),
}


class LoadedInstant(NamedTuple):
    """An instant with its loads [force per thickness]."""

    time: float
    normal_load: float
    tangential_load: float


class InadmissibleLoadError(InputError):
    """The load path leaves the region where a solution exists: gross sliding or separation under
    load control.

    Parameters
    ----------
    reason
        "gross sliding" or "separation"
    begin
        instant and loads from which on it happens
    worst_instant
        those at which it is worst, if not there: a path that slides from the unloaded state on
        begins to do so at P = Q = 0
    friction
        f
    where
        words on the worst instant, such as "worst in the cycle"
    rule
        what is violated and what to do, in place of the words for `reason`

    Examples
    --------
    >>> print(
    ...     InadmissibleLoadError("separation", LoadedInstant(1.5, 0, 0), LoadedInstant(2, -3, 0))
    ... )
    load: separation from time 1.5 on, at time 2 with P = -3, Q = 0: P is negative there, or 0 where
    Q is not 0, so the bodies part; keep P > 0 after the start
    """

    def __init__(
        self,
        reason: str,
        begin: LoadedInstant,
        worst_instant: LoadedInstant | None = None,
        *,
        friction: float | None = None,
        where: str = "",
        rule: str = "",
    ) -> None:
        """Compose the message for a load path on which the bodies slide as a whole or separate:
        times, loads, and what to do.

        Parameters
        ----------
        reason
            "gross sliding" or "separation"
        begin, worst_instant
            time and loads P, Q [force per thickness] at which sliding or separation begins, and
            those at which it is worst; None: the same
        friction
            coefficient f, which the message on gross sliding names
        where
            part of the load path in words, such as "worst in the cycle"
        rule
            what is violated and what to do; "": the usual sentence for the reason
        """
        if worst_instant is None:
            worst_instant = begin
        # Loads and time of the begin stay with the error, and the time at which it is worst.
        self.time = begin.time
        self.normal_load = begin.normal_load
        self.tangential_load = begin.tangential_load
        self.worst_time = worst_instant.time
        onset_text = f" from time {begin.time:.6g} on," if worst_instant.time != begin.time else ""
        place_text = f" {where}" if where else ""
        loads_text = f"P = {worst_instant.normal_load:.6g}, Q = {worst_instant.tangential_load:.6g}"
        if reason == "gross sliding" and friction is not None:
            loads_text += f", f = {friction:g}"
        # _SENTENCES_BY_REASON: for each reason what is violated, and what to do
        super().__init__(
            f"load: {reason}{onset_text}{place_text} at time {worst_instant.time:.6g} with"
            f" {loads_text}: {rule or _SENTENCES_BY_REASON[reason]}"
        )


class ConvergenceError(RuntimeError):
    """An iteration did not converge (exit code 3); the steps solved so far are kept.

    Attributes
    ----------
    partial
        the ContactSolution up to the last accepted step, or None
    """

    def __init__(self, message: str, partial: Any = None) -> None:
        self.partial = partial
        super().__init__(message)


class NotFoundError(ConvergenceError, ArithmeticError):
    """A number of the answer was not found, so that the answer can't be trusted (exit code 3)."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C while something was solved (exit code 130); what was solved before is kept.

    Attributes
    ----------
    partial
        the ContactSolution up to the last accepted step, or the whole of one that later work was
        interrupted on; or None
    """

    def __init__(self, message: str = "", partial: Any = None) -> None:
        self.partial = partial
        super().__init__(message)


def in_words(size: int) -> str:
    """Bytes for a reader.

    >>> in_words(2**28), in_words(2_000), in_words(7)
    ('268 MB', '2 kB', '7 bytes')
    """
    for name, unit in (("GB", 10**9), ("MB", 10**6), ("kB", 10**3)):
        if size >= unit:
            return f"{size / unit:.3g} {name}"
    return f"{size} bytes"


def shortened_repr(value: object) -> str:
    """Text of a value in a sentence: as Python writes it; of a long one the first 120 characters.

    >>> shortened_repr([0.5]), len(shortened_repr("x" * 10**6))
    ('[0.5]', 124)
    """
    try:
        text = repr(value)
    except RecursionError:
        return "something nested too deeply"
    return (
        text
        if len(text) <= _MOST_CHARACTERS_OF_VALUE
        else f"{text[:_MOST_CHARACTERS_OF_VALUE]} ..."
    )


def value_or_class(value: object) -> str:
    """What stands in the place of an object that is needed, for a sentence: plain data as Python
    writes them, of anything else its class, whose text may have many lines.

    >>> value_or_class("hertz-paper"), value_or_class(InputError("load: P < 0"))
    ("'hertz-paper'", 'an InputError')
    """
    if value is None or isinstance(value, _PLAIN_DATA):
        return shortened_repr(value)
    return _with_article(type(value))


def _with_article(named_class: type) -> str:
    """Name of a class behind its indefinite article, for a sentence: "an InputError"."""
    name = named_class.__name__
    return f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"


def require_class(value: object, needed: type | tuple[type, ...], caller: str, maker: str) -> None:
    """Raise InputError, one sentence, where a Python caller passes an object of another class than
    the `needed` one (or of several, the first of which the sentence names).

    `caller` is the name of the public function, `maker` states what returns such an object.

    >>> require_class(7, InputError, "explain", "solve raises it")
    Traceback (most recent call last):
    scenes.errors.InputError: explain: an InputError is needed, not 7; solve raises it
    """
    if not isinstance(value, needed):
        needed_class = _with_article(needed[0] if isinstance(needed, tuple) else needed)
        raise InputError(
            f"{caller}: {needed_class} is needed, not {value_or_class(value)}; {maker}"
        )


def require_path(source: object, caller: str, needed: str = "the path of a file") -> None:
    """Raise InputError, one sentence, where a Python caller passes neither a text nor a path to the
    public function `caller`. `needed` is what is needed, in words.

    >>> require_path(7, "load_scene")
    Traceback (most recent call last):
    scenes.errors.InputError: load_scene: the path of a file is needed, not 7
    """
    if not isinstance(source, str | PathLike):
        raise InputError(f"{caller}: {needed} is needed, not {value_or_class(source)}")


def first_line(reason: BaseException) -> str:
    """The first line of an error's text, its beginning; its kind where it says nothing."""
    lines = str(reason).splitlines()
    return shortened_repr(lines[0])[1:-1] if lines and lines[0] else type(reason).__name__
