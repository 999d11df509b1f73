"""The loop that hands tasks to a crew, stores what comes back, and loses no point: whatever dies, tasks go out again.

A task whose worker died goes out once more, its points one by one and nothing beside them, so that the one that kills workers is
found; lost again, it becomes a failure with that reason. What a lost scheduler held goes out again without being blamed.
"""

from __future__ import annotations

import json
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from typing import Any

from reports.sweep.claims import Claims
from reports.sweep.crews import Crew, Loss
from reports.sweep.index import Reader
from reports.sweep.points import Point
from reports.sweep.store import Store
from reports.sweep.versions import code_versions
from scenes import InputError

_POLL = 0.5
# Points that another sweep has are looked at again every so many seconds.
_LOOK_AGAIN = 2.0
_SCHEDULERS = 5


@dataclass
class Tally:
    """What happened so far, points all of them."""

    total: int
    skipped: int = 0
    done: int = 0
    failed: int = 0
    running: int = 0
    elsewhere: int = 0
    seconds: float = 0.0
    workers: int = 1
    notes: list[str] = field(default_factory=list)

    @property
    def finished(self) -> int:
        """With a result, from this sweep or before."""
        return self.skipped + self.done + self.failed


@dataclass
class Sweep:
    """One sweep at work: see `go`; it ends early once `signals` holds one."""

    store: Store
    reader: Reader
    claims: Claims
    crew: Crew
    asked: Mapping[str, Any]
    tally: Tally
    report: Callable[[Tally], None]
    signals: Sequence[int] = ()

    def __post_init__(self) -> None:
        self._pending: deque[list[Point]] = deque()
        self._suspects: deque[Point] = deque()
        self._elsewhere: list[Point] = []
        self._flying: dict[Future[str], list[Point]] = {}
        self._alone = False
        self._looked = time.monotonic()
        self._schedulers = 0

    def go(self, tasks: list[list[Point]]) -> None:
        """Work until every point has a result, or a signal asks to end.

        Raises
        ------
        StoreError, InputError
            Where results can't be stored, where workers run other code, where no scheduler comes back.
        """
        self._pending.extend(tasks)
        while (self._pending or self._suspects or self._elsewhere or self._flying) and not self.signals:
            self._hand_out()
            done, _ = wait(self._flying, timeout=_POLL, return_when=FIRST_COMPLETED) if self._flying else (set(), set())
            if not self._flying:
                time.sleep(_POLL if self._elsewhere else 0.0)
            self._take_in(done)
            if self._flying and self.crew.broken():
                self._renew([], Loss.SCHEDULER)
            self.claims.renew()
            self._tell()

    def _hand_out(self) -> None:
        """Keep every worker busy, and one task ready; a suspect goes alone."""
        if self._suspects and not self._flying:
            self._submit([self._suspects.popleft()], alone=True)
        while not self._suspects and not self._alone and self._pending and len(self._flying) <= self.crew.width:
            self._submit(self._claimed(self._pending.popleft()))
        if self._elsewhere and (time.monotonic() - self._looked > _LOOK_AGAIN or not (self._flying or self._pending)):
            self._looked = time.monotonic()
            points, self._elsewhere = self._elsewhere, []
            for point in points:
                if mine := self._claimed([point]):
                    self._pending.append(mine)

    def _submit(self, points: list[Point], alone: bool = False) -> None:
        if points:
            self._alone = alone
            try:
                self._flying[self.crew.submit(json.dumps({**self.asked, "points": [point.job() for point in points]}))] = points
            except (RuntimeError, OSError) as fault:  # a pool that broke, or a client that closed, between two tasks
                loss = self.crew.loss(fault)
                if loss is None:
                    raise
                self._renew([points], loss)

    def _claimed(self, points: list[Point]) -> list[Point]:
        """Those that have no result and that no other sweep is at work on; the others are noted."""
        mine = []
        for point in points:
            if not self.claims.take(point.address):
                self._elsewhere.append(point)
            elif (found := self.reader.result(point.address)) is not None and is_final(found):
                self.claims.drop(point.address)
                self._count(found, skipped=True)
            else:
                mine.append(point)
        return mine

    def _take_in(self, done: set[Future[str]]) -> None:
        """Store the answers; tasks that were lost go out again."""
        lost: list[list[Point]] = []
        why = None
        for future in done:
            points = self._flying.pop(future)
            fault = future.exception() if not future.cancelled() else None
            if fault is None and not future.cancelled():
                self._store(json.loads(future.result()), points)
                continue
            loss = Loss.SCHEDULER if fault is None else self.crew.loss(fault)
            if loss is None and fault is not None:
                raise fault
            lost.append(points)
            why = loss
        if why is not None:
            self._renew(lost, why)

    def _store(self, answer: Mapping[str, Any], points: list[Point]) -> None:
        if answer["mismatch"]:
            raise InputError(
                f"{answer['mismatch']}: results of different code are not to be mixed; install the same on all workers"
            )
        numbers = {point.address: point for point in points}
        for result in answer["answers"]:
            point = numbers[result["address"]]
            self._keep(point, {**result, "versions": code_versions()})
        self._alone = False

    def _keep(self, point: Point, result: dict[str, Any]) -> None:
        result["scene"] = point.scene.model_dump(mode="json")
        result["settings"] = {name: value for name, value in point.job().items() if name in ("mesh", "solver")}
        self.store.write(result)
        self.claims.drop(point.address)
        self.reader.keep(result)
        self._count(result)

    def _renew(self, lost: list[list[Point]], why: Loss) -> None:
        """New workers; lost tasks go out again, those of a dead worker point by point and alone."""
        alone, self._alone = self._alone, False
        if why is Loss.SCHEDULER or self.crew.shared_fate:
            # They are lost too, also those whose futures don't know it yet.
            lost = [*lost, *self._flying.values()]
            self._flying.clear()
        points = [point for task in lost for point in task]
        self.tally.notes.append(f"{why.value}: {len(points)} points go out again")
        if why is Loss.SCHEDULER:
            self._schedulers += 1
            if self._schedulers > _SCHEDULERS:
                raise InputError(f"the scheduler was lost {self._schedulers} times; see to it, then go on with --resume")
            self._pending.extendleft(lost)
        elif alone and len(points) == 1:
            reason = "the worker that solved it died twice (killed, or out of memory): see its memory, then go on with --resume"
            answer = {"address": points[0].address, "status": "failed", "reason": reason, "figures": {}, "notes": {}, "record": {}}
            self._keep(points[0], answer | {"seconds": 0.0, "host": "", "again": True, "versions": code_versions()})
        else:
            self._suspects.extend(points)
        self.crew.renew(self.signals)

    def _count(self, result: Mapping[str, Any], skipped: bool = False) -> None:
        if skipped:
            self.tally.skipped += 1
        elif result["status"] == "done":
            self.tally.done += 1
            self.tally.seconds += result["seconds"]
        else:
            self.tally.failed += 1

    def _tell(self) -> None:
        self.tally.running = sum(len(points) for points in self._flying.values())
        self.tally.elsewhere = len(self._elsewhere)
        self.report(self.tally)


def is_final(result: Mapping[str, Any]) -> bool:
    """Whether a result stands: not one that says that a worker died, which is tried again by the next sweep."""
    return not result.get("again", False)
