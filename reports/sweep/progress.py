"""How far a sweep is, in words: while it runs, and from outside while another process runs it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from reports.console import Stages, complain
from reports.sweep.claims import running
from reports.sweep.executing import Tally
from reports.sweep.index import Reader, Table
from reports.sweep.store import Store

# Without a terminal a line every so many seconds; the first estimate once so many points are done.
_LINE_EVERY = 10.0
_ENOUGH = 4
_LATEST = 40


def duration(seconds: float) -> str:
    """Seconds in words.

    >>> duration(0.4), duration(75), duration(7300)
    ('under a second', '75 s', '2.0 h')
    """
    if seconds < 1:
        return "under a second"
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def time_left(tally: Tally, seconds_each: float | None = None) -> float | None:
    """Wall time for the points without a result, from what the others took; None where nothing is known yet."""
    if tally.done:
        seconds_each = tally.seconds / tally.done
    if seconds_each is None:
        return None
    return seconds_each * max(0, tally.total - tally.finished) / max(1, tally.workers)


def words(tally: Tally) -> str:
    """The tally in a few words."""
    parts = [f"{tally.failed} failed", f"{tally.running} handed out"]
    if tally.elsewhere:
        parts.append(f"{tally.elsewhere} done by another sweep")
    left = time_left(tally)
    return ", ".join([*parts, *([f"{duration(left)} left"] if left is not None else [])]) + "; points done"


def teller(stages: Stages, report: Callable[[int, int | None, str], None], quiet: bool) -> Callable[[Tally], None]:
    """What shows a tally: a bar on a terminal, else a line now and then; what happened besides, at once."""
    shown, told, estimated = 0.0, 0, False

    def tell(tally: Tally) -> None:
        nonlocal shown, told, estimated
        for note in tally.notes[told:]:
            complain(f"sweep: {note}")
        told = len(tally.notes)
        if not estimated and tally.done >= _ENOUGH and (left := time_left(tally)) is not None and tally.total > tally.finished:
            estimated = True
            if not quiet:
                each = duration(tally.seconds / tally.done)
                complain(
                    f"sweep: about {duration(left)} for {tally.total - tally.finished} points more, from {tally.done} ({each} each)"
                )
        if stages.console.is_terminal or time.monotonic() - shown > _LINE_EVERY:
            shown = time.monotonic()
            report(tally.finished, tally.total, words(tally))

    return tell


@dataclass(frozen=True)
class State:
    """A stored sweep, seen from outside.

    Attributes
    ----------
    title, total, done, failed, running, waiting : points; running ones have the claim of a sweep that lives
    damaged : names of results that were set aside
    rate : results a second, of late; None where there are fewer than two
    failures : (number, reason) of failed points
    notes : (note, number of points) of what is noted on points
    """

    title: str
    total: int
    done: int
    failed: int
    running: int
    waiting: int
    damaged: tuple[str, ...]
    rate: float | None
    failures: tuple[tuple[int, str], ...]
    notes: tuple[tuple[str, int], ...]

    @property
    def left(self) -> float | None:
        """Seconds for what is waiting or running, at the rate of late; None where no sweep is at work or no rate is known."""
        return (self.waiting + self.running) / self.rate if self.running and self.rate else None


def state_of(store: Store) -> tuple[State, Table]:
    """What the store holds now.

    Raises
    ------
    InputError
        Where the folder holds no sweep.
    """
    study, points = store.read_plan()
    table = Reader(store).table(points)
    failures = tuple((row["number"], row["reason"]) for row in table.rows if row["status"] != "done")
    known = {row["address"] for row in table.rows}
    at_work = running(store) & {point.address for point in points} - known
    times = sorted(filter(None, map(store.stored_at, known)))[-_LATEST:]
    rate = (len(times) - 1) / (times[-1] - times[0]) if len(times) > 1 and times[-1] > times[0] else None
    done = len(table.rows) - len(failures)
    state = State(
        study.get("title", ""),
        len(points),
        done,
        len(failures),
        len(at_work),
        table.waiting - len(at_work),
        tuple(store.damaged()),
        rate,
        failures,
        tuple(table.notes()),
    )
    return state, table
