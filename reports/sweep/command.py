"""What `halfplane sweep` does: check, say what it costs, work, and say how to go on where it ends early."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path

from reports.application import INTERRUPTED, NOT_CONVERGED, WITHIN
from reports.console import Stages, complain, say, show_table
from reports.folder import claim, default_folder
from reports.sweep.executing import Tally
from reports.sweep.index import Table
from reports.sweep.points import described
from reports.sweep.progress import State, duration, state_of, teller, time_left
from reports.sweep.running import Prepared, prepare, work
from reports.sweep.store import Store, StoreError

_SHOWN, _NOTES = 20, 3


def sweep(
    source: str,
    out: Path | None,
    executor: str,
    scheduler: str,
    workers: int | None,
    resume: bool,
    quiet: bool,
    *,
    tell: bool = True,
    as_json: bool = False,
) -> int:
    """Run a study, or go on with it; 3 where a point failed. Without `tell` nothing is said on stdout."""
    from reports.sweep.crews import available_cores, crew_of

    stages = Stages(quiet)
    folder = claim(out or default_folder(Path(source).stem))
    crew_of(executor, scheduler, workers)
    with stages.stage("checking the study") as report:
        prepared = prepare(source, folder, resume=resume, report=lambda count: report(count, None, "points checked"))
    if tell and not as_json:
        _announce(prepared, workers or available_cores(), executor)
    again = _command(source, folder, executor, scheduler, workers)
    try:
        with stages.stage("sweep") as report:
            told = teller(stages, report, quiet)
            table = work(prepared, executor=executor, scheduler=scheduler, workers=workers, report=told)
    except KeyboardInterrupt:
        complain(f"halfplane: interrupted; {_stored(prepared)}; go on with: {again}")
        return INTERRUPTED
    except StoreError as fault:
        raise StoreError(f"{fault}; {_stored(prepared)}; once there is room go on with: {again}") from fault
    code = NOT_CONVERGED if any(row["status"] != "done" for row in table.rows) else WITHIN
    if as_json:
        from reports.machine import sweep_json

        say(sweep_json(state_of(prepared.store)[0], code, file=prepared.store.folder / "index.csv"))
    elif tell:
        _summary(prepared.store, table)
    return code


def _announce(prepared: Prepared, workers: int, executor: str) -> None:
    points, plan = len(prepared.plan.points), prepared.plan
    study = prepared.study
    say(f"{study.title or study.scene.name}: {points} points, {' and '.join(study.engines)}; {', '.join(study.figures)}")
    if "fe" in study.engines:
        shared = "at most " if not study.share_condensations else ""
        cut = "cut alike in each" if study.share_condensations else "each point cut for itself"
        groups = f"{len(plan.groups)} groups of points with bodies, materials and largest load in common"
        say(f"{shared}{plan.condensations} condensed bodies for {groups}, {cut}")
    if stored := points - len(prepared.waiting):
        say(f"{stored} points have results already, {len(prepared.waiting)} are left")
    if damaged := prepared.store.damaged():
        say(f"{len(damaged)} damaged results were set aside and are made anew: {', '.join(damaged[:3])}")
    tally = Tally(points, skipped=points - len(prepared.waiting), workers=workers)
    left = time_left(tally, prepared.seconds_each)
    if prepared.waiting and executor == "processes":
        told = (
            "time: told once the first points are done"
            if left is None
            else f"time: about {duration(left)}, from the stored results"
        )
        say(f"{told}; {workers} process{'es' if workers > 1 else ''}")


def _command(source: str, folder: Path, executor: str, scheduler: str, workers: int | None) -> str:
    words = ["halfplane", "sweep", source, "--out", str(folder), "--resume"]
    words += ["--executor", executor, "--scheduler", scheduler] if executor != "processes" else []
    return shlex.join([*words, *(["--workers", str(workers)] if workers else [])])


def _stored(prepared: Prepared) -> str:
    known = prepared.store.addresses()
    return f"{sum(p.address in known for p in prepared.plan.points)} of {len(prepared.plan.points)} points are stored"


def _summary(store: Store, table: Table) -> None:
    failed = [row for row in table.rows if row["status"] != "done"]
    if failed:
        rows = [(str(row["number"]), described({name: row[name] for name in table.axes}), row["reason"]) for row in failed[:_SHOWN]]
        show_table(f"{len(failed)} of {len(table.rows)} points failed", ("point", "at", "reason"), rows)
    say(f"{len(table.rows) - len(failed)} points done, {len(failed)} failed; `halfplane sweep report {store.folder}` draws them")
    notes = table.notes()
    for note, count in notes[:_NOTES]:
        say(f"note on {count} of {len(table.rows)} points: {note}")
    if len(notes) > _NOTES:
        say(f"... and {len(notes) - _NOTES} other notes; see index.csv")
    say(str(store.folder / "index.csv"))


def status(folder: Path, as_json: bool = False) -> int:
    """How far a sweep is, from outside."""
    state, _ = state_of(Store(folder))
    if as_json:
        from reports.machine import sweep_json

        say(sweep_json(state))
        return WITHIN
    show_table(state.title or str(folder), ("points", "number"), _counts(state), right=(1,))
    for name in state.damaged:
        say(f"damaged and set aside: results/{name}; the next sweep makes it anew")
    for number, reason in state.failures[:_SHOWN]:
        say(f"point {number} failed: {reason}")
    if len(state.failures) > _SHOWN:
        say(f"... and {len(state.failures) - _SHOWN} more failed; see index.csv")
    if state.left is not None:
        say(f"about {duration(state.left)} left")
    elif state.waiting:
        say("no sweep is at work here" if not state.running else "time left: told once two points are done")
    return WITHIN


def _counts(state: State) -> Sequence[tuple[str, str]]:
    names = ("done", "failed", "running", "waiting", "total")
    return [(name, str(getattr(state, name))) for name in names]


def report(folder: Path, as_json: bool = False) -> int:
    """The page of what is there so far."""
    from reports.sweep.page import write_page

    store = Store(folder)
    page = write_page(store)
    if as_json:
        from reports.machine import sweep_json

        say(sweep_json(state_of(store)[0], page=page))
    else:
        say(str(page))
    return WITHIN
