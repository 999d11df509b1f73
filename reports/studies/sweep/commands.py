"""The commands of a sweep: run or resume it, how far it is, its page."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.cli.application import INTERRUPTED, NOT_CONVERGED, WITHIN, WORKERS, Answer, Options
from reports.console import Part, Sheet, Stages, complain, say

if TYPE_CHECKING:
    from pandas import DataFrame

    from reports.studies.sweep.running import Prepared
    from reports.studies.sweep.store import Store

# Points and failures, and notes, that the terminal lists; all are in index.csv.
_SHOWN = 20
_NOTES = 3


def sweep(study: str, options: Options) -> Answer:
    """Every point of a scene's axes, into a store; run it again to resume it; 3 where a point
    failed.
    """
    return swept(study, options, announced=not options.json)


def swept(source: str, options: Options, *, announced: bool = False) -> Answer:
    """The command `sweep`: solve the points of a study that have no stored result, and list all.

    `source` names the study's file. With `announced` the command first prints how many points it
    has, and how many are stored.
    """
    from reports.folder import claim, default_folder
    from reports.studies.sweep.running import prepare, work, workers_of
    from reports.studies.sweep.store import StoreError

    stages = Stages(options.quiet)
    folder = claim(options.out or default_folder(Path(source).stem))
    workers = {name: getattr(options, name) for name in WORKERS}
    workers_of(**workers)
    with stages.stage("checking the study", "points") as report:
        prepared = prepare(
            source, folder, lambda count: report(count, None, f"{count} points checked")
        )
    for line in _announced(prepared) if announced else ():
        say(line)
    command_again = replace(options, resume=False).command("sweep", source, folder)

    def stored_in_words() -> str:
        known_addresses = prepared.store.addresses()
        return (
            f"{sum(point.address in known_addresses for point in prepared.points)} of"
            f" {len(prepared.points)} points are stored"
        )

    try:
        with stages.stage("sweep", "points") as report:
            table = work(prepared, report=report, **workers)
    except KeyboardInterrupt:
        complain(f"halfplane: interrupted; {stored_in_words()}; resume with: {command_again}")
        return Answer(INTERRUPTED)
    except StoreError as fault:
        raise StoreError(
            f"{fault}; {stored_in_words()}; once there is room resume with: {command_again}"
        ) from fault
    json_content = _content(prepared.store) | {"file": str(prepared.store.folder / "index.csv")}
    code = WITHIN if (table["status"] == "done").all() else NOT_CONVERGED
    return Answer(
        code,
        _points(prepared, table, json_content),
        lambda: json_content,
        prepared.study.scene.name,
    )


def _announced(prepared: Prepared) -> Iterator[str]:
    """Lines printed before a sweep: how many points it has, which engines and quantities, how many
    points have results already, and which stored results were damaged.
    """
    study = prepared.study
    n_points = len(prepared.points)
    n_waiting = len(prepared.waiting_points)
    yield (
        f"{study.title or study.scene.name}: {n_points} points, {' and '.join(study.engines)};"
        f" {', '.join(study.figures)}"
    )
    if n_waiting < n_points:
        yield f"{n_points - n_waiting} points have results already, {n_waiting} are left"
    if damaged := prepared.store.damaged():
        yield (
            f"{len(damaged)} damaged results were set aside and are made again:"
            f" {', '.join(damaged[:3])}"
        )


def _points(prepared: Prepared, table: DataFrame, state: dict[str, Any]) -> Iterator[Part]:
    """What the terminal shows of a sweep: the points with their values, those that failed with the
    reason, and notes. `prepared` is the study with its store; `state` holds the notes and the path
    of the table of all points.
    """
    from reports.studies.sweep.page import table_in_words
    from reports.studies.sweep.study import described

    solved_rows = table[table["status"] == "done"]
    failed_rows = table[table["status"] != "done"]
    study = prepared.study
    heads, rows = table_in_words(solved_rows[:_SHOWN], study.axes, study.scene, in_short=True)
    if rows:
        yield Sheet(study.title or study.scene.name, heads, rows, range(len(heads)))
    if len(solved_rows) > _SHOWN:
        yield f"... and {len(solved_rows) - _SHOWN} other points; see index.csv"
    if len(failed_rows):
        rows_shown = failed_rows[:_SHOWN]
        failures = []
        for number, reason in zip(rows_shown["number"], rows_shown["reason"], strict=True):
            failures.append((str(number), described(prepared.points[number].coordinates), reason))
        title = f"{len(failed_rows)} of {len(table)} points failed"
        yield Sheet(title, ("point", "at", "reason"), failures)
    folder = prepared.store.folder
    yield (
        f"{len(solved_rows)} points done, {len(failed_rows)} failed; `halfplane sweep report"
        f" {folder}` draws them"
    )
    for note in state["notes"][:_NOTES]:
        yield f"note on {note['points']} of {len(table)} points: {note['note']}"
    if (n_left_out := len(state["notes"]) - _NOTES) > 0:
        yield f"... and {n_left_out} other notes; see index.csv"
    yield state["file"]


def _content(store: Store) -> dict[str, Any]:
    """How far a sweep is, for programs; `seconds_left` is null where nothing waits or no rate is
    known.
    """
    from reports.studies.sweep.page import state_of

    return {name: value for name, value in state_of(store).items() if name != "table"}


def status(folder: Path, _: Options) -> Answer:
    """The command `sweep status`: how far a sweep is: points done, failed and waiting, time
    left.
    """
    from reports.studies.sweep.store import Store

    state = _content(Store(folder))

    def parts() -> Iterator[Part]:
        counts = [(status, str(count)) for status, count in state["points"].items()]
        yield Sheet(state["title"] or str(folder), ("points", "number"), counts, (1,))
        yield from (
            f"damaged and set aside: results/{name}; the next sweep makes it again"
            for name in state["damaged"]
        )
        yield from (
            f"point {failure['point']} failed: {failure['reason']}"
            for failure in state["failures"][:_SHOWN]
        )
        if (n_left_out := len(state["failures"]) - _SHOWN) > 0:
            yield f"... and {n_left_out} more failed; see index.csv"
        if state["seconds_left"] is not None:
            yield (
                f"about {state['seconds_left']:.0f} s of work left at the rate of the last results"
            )

    return Answer(WITHIN, parts(), lambda: state)


def report(folder: Path, _: Options) -> Answer:
    """The page of a sweep: its table and a figure of each quantity, also while it runs."""
    from reports.studies.sweep.page import write_page
    from reports.studies.sweep.store import Store

    page = str(write_page(Store(folder)))
    return Answer(WITHIN, [page], lambda: _content(Store(folder)) | {"page": page})
