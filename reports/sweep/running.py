"""A whole sweep: the study checked, the store opened, the work done, the table returned."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from meshes.interrupts import interrupts_wait
from reports.sweep.claims import Claims
from reports.sweep.crews import Crew, crew_of
from reports.sweep.executing import Sweep, Tally, is_final
from reports.sweep.grouping import Plan, plan, tasks
from reports.sweep.index import Reader, Table, write_index, write_parquet
from reports.sweep.points import Point, expand
from reports.sweep.store import Planned, Store
from reports.sweep.study import Study, load_study
from reports.sweep.versions import code_versions
from scenes import InputError
from scenes.frozen import validated

_INDEX_EVERY = 15.0


@dataclass(frozen=True)
class Prepared:
    """A study that was checked, and the store that it goes to.

    Attributes
    ----------
    study, plan, store, reader : what is asked, and where results are
    waiting : points without a result
    seconds_each : CPU time of a point, from the results that are there; None where there are none
    """

    study: Study
    plan: Plan
    store: Store
    reader: Reader
    waiting: tuple[Point, ...]
    seconds_each: float | None


def prepare(
    study: Study | str | Path, folder: str | Path, *, resume: bool = True, report: Callable[[int], None] | None = None
) -> Prepared:
    """Check the whole study and look at what is stored already; nothing is written.

    Raises
    ------
    InputError
        For a study that is refused, and for a folder with results in it unless `resume`.
    """
    asked = validated(study, Study) if isinstance(study, Study) else load_study(study)
    where = "study" if isinstance(study, Study) else str(study)
    store = Store(Path(folder))
    if store.folder.exists() and not store.folder.is_dir():
        raise InputError(f"--out {folder}: this is a file; results go to a folder, so name another")
    if not resume and store.addresses():
        raise InputError(f"--out {folder}: results are there already; go on with them by --resume, or name another folder")
    try:
        points = expand(asked, report)
    except InputError as fault:
        raise InputError(f"{where}: {fault}") from fault
    reader = Reader(store)
    stored = store.addresses()
    known = {point.address: reader.result(point.address) for point in points if point.address in stored}
    whole = {address: result for address, result in known.items() if result is not None and is_final(result)}
    seconds = [result["seconds"] for result in whole.values() if result["status"] == "done"]
    waiting = tuple(point for point in points if point.address not in whole)
    return Prepared(asked, plan(asked, points), store, reader, waiting, sum(seconds) / len(seconds) if seconds else None)


def work(
    prepared: Prepared,
    *,
    executor: str = "processes",
    scheduler: str = "",
    workers: int | None = None,
    report: Callable[[Tally], None] = lambda _tally: None,
) -> Table:
    """Solve every point that has no result; returns the table of all.

    Raises
    ------
    InputError
        Where no crew can be had, its code differs from ours, or results can't be stored.
    """
    hire = crew_of(executor, scheduler, workers)
    prepared.store.prepare()
    planned = tuple(Planned(p.number, p.address, p.coordinates) for p in prepared.plan.points)
    prepared.store.write_plan(json.loads(prepared.study.model_dump_json()), planned)
    if prepared.waiting:
        with _indexing(prepared, planned, report) as tell, _claims(prepared.store) as claims:
            _work(prepared, hire, claims, tell)
    table = prepared.reader.table(planned)
    write_index(prepared.store, table)
    write_parquet(prepared.store, table)
    return table


def _work(prepared: Prepared, hire: Callable[[], Crew], claims: Claims, tell: Callable[[Tally], None]) -> None:
    study, waiting = prepared.study, {point.address for point in prepared.waiting}
    groups = [[point for point in group if point.address in waiting] for group in prepared.plan.groups]
    asked = {
        "versions": code_versions(),
        "engines": study.engines,
        "figures": study.figures,
        "uncertainty": study.uncertainty,
        "share": study.share_condensations,
    }
    tally = Tally(len(prepared.plan.points), skipped=len(prepared.plan.points) - len(waiting))
    # Ctrl-C amid the locks of a pool may leave one locked for ever: it waits for a round, and until the workers are gone.
    with interrupts_wait() as signals:
        crew = hire()
        tally.workers, at_once = crew.width, True
        try:
            sweep = Sweep(prepared.store, prepared.reader, claims, crew, asked, tally, tell, signals)
            sweep.go(tasks(study, groups, crew.width))
            at_once = bool(signals)
        finally:
            crew.dismiss(at_once=at_once)


@contextmanager
def _claims(store: Store) -> Generator[Claims, None, None]:
    claims = Claims(store)
    try:
        yield claims
    finally:
        claims.drop_all()


@contextmanager
def _indexing(
    prepared: Prepared, planned: tuple[Planned, ...], report: Callable[[Tally], None]
) -> Generator[Callable[[Tally], None], None, None]:
    """Passes the tally on, and renews index.csv now and then and at the end, whatever the end is."""
    written = time.monotonic()

    def tell(tally: Tally) -> None:
        nonlocal written
        if time.monotonic() - written > _INDEX_EVERY:
            write_index(prepared.store, prepared.reader.table(planned))
            written = time.monotonic()
        report(tally)

    try:
        yield tell
    except KeyboardInterrupt:
        write_index(prepared.store, prepared.reader.table(planned))
        raise


def run(
    study: Study | str | Path,
    folder: str | Path,
    *,
    executor: str = "processes",
    scheduler: str = "",
    workers: int | None = None,
    report: Callable[[Tally], None] = lambda _tally: None,
) -> Table:
    """Run a study into a folder, or go on where an earlier run of it was left; returns the table.

    Called from a script, it stands under `if __name__ == "__main__":`, for the workers are processes that read the script anew.

    Raises
    ------
    InputError
        For a study that is refused, and where results can't be stored.
    """
    return work(prepare(study, folder), executor=executor, scheduler=scheduler, workers=workers, report=report)
