"""What can go wrong, as exceptions whose text is the one sentence that the user reads."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenes.solution import ContactSolution


class InputError(ValueError):
    """Bad input: one clear sentence naming file, key, value, rule and what to do (exit code 2)."""


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
