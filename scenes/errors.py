"""What can go wrong, as exceptions whose text is the one sentence that the user reads."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenes.solution import ContactSolution


_LONGEST = 2000


class InputError(ValueError):
    """Bad input: one clear sentence naming file, key, value, rule and what to do (exit code 2).

    What stands in a file may be a megabyte long or steer a terminal: the middle of a long sentence is left out, and what is not
    printable is written as its escape.

    >>> str(InputError("a" + chr(27) + "b")).isprintable(), len(str(InputError("x" * 10**6)))
    (True, 2005)
    """

    def __init__(self, sentence: str = "") -> None:
        short = sentence if len(sentence) <= _LONGEST else f"{sentence[: _LONGEST // 2]} ... {sentence[-_LONGEST // 2 :]}"
        super().__init__("".join(c if c.isprintable() or c == "\n" else ascii(c)[1:-1] for c in short))


class InadmissibleLoadError(InputError):
    """The load path leaves the region where a solution exists: gross sliding or separation under load control.

    Attributes
    ----------
    time, normal_load, tangential_load : float
        The instant and the loads at which it happens.
    """

    def __init__(self, reason: str, time: float, normal_load: float, tangential_load: float) -> None:
        self.time, self.normal_load, self.tangential_load = time, normal_load, tangential_load
        super().__init__(f"{reason} at time {time:.6g}: normal load {normal_load:.6g}, tangential load {tangential_load:.6g}")


class ConvergenceError(RuntimeError):
    """An iteration did not converge (exit code 3); the steps solved so far are kept.

    Attributes
    ----------
    partial : ContactSolution or None
        The solution up to the last accepted step.
    """

    def __init__(self, message: str, partial: ContactSolution | None = None) -> None:
        self.partial = partial
        super().__init__(message)


class NotFoundError(ConvergenceError, ArithmeticError):
    """A number of the answer was not found, so that the answer can't be trusted (exit code 3)."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C while something was solved (exit code 130); what was solved before is kept.

    Attributes
    ----------
    partial : ContactSolution or None
        The solution up to the last accepted step, or the whole of one that later work was interrupted on.
    """

    def __init__(self, message: str = "", partial: ContactSolution | None = None) -> None:
        self.partial = partial
        super().__init__(message)
