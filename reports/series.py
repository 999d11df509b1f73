"""What `fields` is asked for, and series of instants over the last cycle: every so many steps, or so many evenly in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reports.fields import Instant
from scenes import ContactSolution, InputError

# Frames of an animation if nothing is said: five seconds at twelve a second.
FRAMES = 60


@dataclass(frozen=True)
class Wish:
    """What is wanted: instants by name or time, a series over the cycle, stills at the named instants, an animation."""

    at: tuple[str, ...] = ()
    every: int | None = None
    frames: int | None = None
    pictures: bool = True
    animate: bool = False

    @property
    def series(self) -> bool:
        """Whether files for ParaView are wanted over the whole cycle."""
        return self.every is not None or self.frames is not None

    @property
    def named(self) -> tuple[str, ...]:
        """Words of --at; the events where neither a series nor times are asked for."""
        return self.at or (() if self.series else ("events",))

    def words(self) -> tuple[tuple[str, ...], ...]:
        """The options that say it on the command line."""
        counts = (("--every", self.every), ("--frames", self.frames))
        series = [(word, str(value)) for word, value in counts if value is not None]
        switches = [(word,) for word, there in (("--animate", self.animate), ("--no-pictures", not self.pictures)) if there]
        return (*([("--at", *self.named)] if self.named else []), *series, *switches)


def check_series(every: int | None, frames: int | None) -> None:
    """InputError for both at once, and for counts that make no series."""
    if every is not None and frames is not None:
        raise InputError("--every and --frames: both say how many instants of the cycle there are; leave one of the two out")
    if every is not None and every < 1:
        raise InputError(f"--every {every}: every how many stored steps, so 1 at least")
    if frames is not None and frames < 2:
        raise InputError(f"--frames {frames}: a series has 2 instants at least")


def series_of(solution: ContactSolution, every: int | None, frames: int | None) -> tuple[Instant, ...]:
    """Stored instants of the last whole cycle (the whole path, where it does not repeat), in order of time.

    Parameters
    ----------
    every : each so-manieth stored step of the cycle
    frames : the stored steps nearest to so many times at equal distances; fewer where the cycle has fewer steps

    The end of a cycle that repeats is left out, since it is its start.
    """
    check_series(every, frames)
    steps, repeats = solution.last_cycle, solution.scene.load.path().period is not None
    if repeats:
        steps = steps[:-1]
    if frames is not None:
        first, last = solution.time[steps[0]], solution.time[solution.last_cycle[-1]]
        wanted = np.linspace(first, last, frames, endpoint=not repeats)
        steps = np.unique(steps[np.abs(solution.time[steps] - wanted[:, None]).argmin(axis=1)])
    elif every is not None:
        steps = steps[::every]
    return tuple(Instant(float(solution.time[step]), f"{number + 1} of {len(steps)}") for number, step in enumerate(steps))


def shortfall(frames: int | None, found: int) -> str:
    """A sentence where a series has fewer instants than were asked for; empty otherwise."""
    if frames is None or found >= frames:
        return ""
    return f"{found} instants instead of {frames}: the cycle has no more stored steps that far apart; --steps-per-cycle gives more"
