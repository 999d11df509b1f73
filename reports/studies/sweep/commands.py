"""The commands of a sweep: run or resume it, how far it is, its page."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.cli.application import (
    EXIT_INTERRUPTED,
    EXIT_NOT_CONVERGED,
    EXIT_WITHIN,
    WORKERS,
    Answer,
    Options,
)
from reports.console import Part, Sheet, Stages, complain, say

if TYPE_CHECKING:
    from pandas import DataFrame

    from reports.studies.sweep.running import PreparedSweep
    from reports.studies.sweep.store import Store

# Points and failures, and notes, that the terminal lists; all are in index.csv.
_MOST_ROWS = 20
_MOST_NOTES = 3


def sweep(study: str, options: Options) -> Answer:
    """The command `sweep`: solve a scene for all values on the axes of a study, into a store; run
    it again to resume it. Exit code 3 where a point failed.
    """
    return solve_study(study, options, with_opening_lines=not options.json)


def solve_study(source: str, options: Options, *, with_opening_lines: bool = False) -> Answer:
    """The command `sweep`: solve the points of a study that have no stored result, and list all.

    `source` names the study's file. With `with_opening_lines` the command first prints how many
    points the study has, and how many are stored. Of the command's `options`, `out` is the folder
    of the store, `quiet` stands for no progress, and those named in `WORKERS` state who solves.

    Returns the exit code (0 all points are solved, 3 one failed, 130 the user interrupted), sheets
    (printed tables) and lines for the terminal, and the content of the JSON output.
    """
    from reports.folder import default_folder, usable_folder
    from reports.studies.sweep.running import prepare, worker_pool

    stages = Stages(options.quiet)
    folder = usable_folder(options.out or default_folder(Path(source).stem))
    worker_options = {name: getattr(options, name) for name in WORKERS}
    worker_pool(**worker_options)  # refuses options that do not go together, before any work

    # read the study and check all its points
    with stages.stage("checking the study", "points") as report_progress:
        prepared_sweep = prepare(
            source,
            folder,
            lambda n_checked: report_progress(n_checked, None, f"{n_checked} points checked"),
        )
    if with_opening_lines:
        for line in _opening_lines(prepared_sweep):
            say(line)

    # The command line that resumes an interrupted sweep, for messages. It needs no --resume:
    # every run uses the results in the store.
    command_to_resume = replace(options, resume=False).command("sweep", source, folder)
    table = _table_of_solved_points(prepared_sweep, stages, worker_options, command_to_resume)
    if table is None:
        return Answer(EXIT_INTERRUPTED)  # exit code 130

    # how far the sweep is, for JSON: counts, failures, notes
    table_path = prepared_sweep.store.folder / "index.csv"
    json_content = _content(prepared_sweep.store) | {"file": str(table_path)}
    # EXIT_WITHIN, EXIT_NOT_CONVERGED: exit codes 0 and 3
    exit_code = EXIT_WITHIN if (table["status"] == "done").all() else EXIT_NOT_CONVERGED
    return Answer(
        exit_code,
        _result_parts(prepared_sweep, table, json_content),
        lambda: json_content,
        prepared_sweep.study.scene.name,
    )


def _table_of_solved_points(
    prepared_sweep: PreparedSweep,
    stages: Stages,
    worker_options: dict[str, Any],
    command_to_resume: str,
) -> DataFrame | None:
    """Solve the points of a sweep that have no stored result: a table with a row for each point.
    None, with a message on the terminal, where the user interrupted. StoreError where a result
    can't be written. Both messages state how many points are stored, and `command_to_resume`.

    `stages` shows the progress; `worker_options` are the options that state who solves.
    """
    from reports.studies.sweep.running import solve_waiting_points
    from reports.studies.sweep.store import StoreError

    try:
        with stages.stage("sweep", "points") as report_progress:
            return solve_waiting_points(prepared_sweep, report=report_progress, **worker_options)
    except KeyboardInterrupt:
        stored_in_words = _stored_in_words(prepared_sweep)
        complain(f"halfplane: interrupted; {stored_in_words}; resume with: {command_to_resume}")
        return None
    except StoreError as fault:
        raise StoreError(
            f"{fault}; {_stored_in_words(prepared_sweep)}; once there is room resume with:"
            f" {command_to_resume}"
        ) from fault


def _stored_in_words(prepared_sweep: PreparedSweep) -> str:
    """How many points of a sweep are stored now, as a sentence without its end."""
    stored_addresses = prepared_sweep.store.addresses()
    n_stored = sum(point.address in stored_addresses for point in prepared_sweep.points)
    return f"{n_stored} of {len(prepared_sweep.points)} points are stored"


def _opening_lines(sweep: PreparedSweep) -> Iterator[str]:
    """Lines printed before a sweep: how many points it has, which engines and quantities
    (`figures`), how many points have results already, and which stored results were damaged.
    """
    study = sweep.study
    n_points = len(sweep.points)
    n_waiting_points = len(sweep.waiting_points)
    yield (
        f"{study.title or study.scene.name}: {n_points} points, {' and '.join(study.engines)};"
        f" {', '.join(study.figures)}"
    )
    if n_waiting_points < n_points:
        yield (
            f"{n_points - n_waiting_points} points have results already, {n_waiting_points} are"
            " left"
        )
    if damaged_files := sweep.store.damaged():
        yield (
            f"{len(damaged_files)} damaged results were set aside and are made again:"
            f" {', '.join(damaged_files[:3])}"
        )


def _result_parts(
    sweep: PreparedSweep, table: DataFrame, json_content: dict[str, Any]
) -> Iterator[Part]:
    """Sheets (printed tables) and lines that the terminal shows of a sweep. The sheets are of the
    points with their values, and of those that failed with the reason. The lines are counts, notes,
    and the path of the file index.csv with all points.

    `sweep` is the study with its points and its store; `table` has a row for each point, with
    "status", "number" and "reason". `json_content` holds the notes ("notes": each a text and how
    many points have it) and that path ("file"). At most 20 points (`_MOST_ROWS`) and three notes
    (`_MOST_NOTES`) are shown.
    """
    from reports.studies.sweep.page import table_in_words
    from reports.studies.sweep.study import coordinates_in_words

    # points with their values; `is_short`: without status and seconds
    # Sheet: title, heads, rows and indices of right-aligned columns
    solved_rows = table[table["status"] == "done"]
    failed_rows = table[table["status"] != "done"]
    study = sweep.study
    heads, rows = table_in_words(solved_rows[:_MOST_ROWS], study.axes, study.scene, is_short=True)
    if rows:
        yield Sheet(study.title or study.scene.name, heads, rows, range(len(heads)))
    if len(solved_rows) > _MOST_ROWS:
        yield f"... and {len(solved_rows) - _MOST_ROWS} other points; see index.csv"

    # points that failed, with their coordinates as text
    if len(failed_rows):
        first_failures = failed_rows[:_MOST_ROWS]
        failures = []
        for number, reason in zip(first_failures["number"], first_failures["reason"], strict=True):
            failures.append(
                (str(number), coordinates_in_words(sweep.points[number].coordinates), reason)
            )
        title = f"{len(failed_rows)} of {len(table)} points failed"
        yield Sheet(title, ("point", "at", "reason"), failures)

    # counts, notes and path
    folder = sweep.store.folder
    yield (
        f"{len(solved_rows)} points done, {len(failed_rows)} failed; `halfplane sweep report"
        f" {folder}` draws them"
    )
    notes = json_content["notes"]
    for note in notes[:_MOST_NOTES]:
        yield f"note on {note['points']} of {len(table)} points: {note['note']}"
    n_further_notes = len(notes) - _MOST_NOTES
    if n_further_notes > 0:
        yield f"... and {n_further_notes} other notes; see index.csv"
    yield json_content["file"]


def _content(store: Store) -> dict[str, Any]:
    """How far the sweep in a store is, as content of the JSON output. It has title, numbers of
    points done, failed and waiting, failures, notes, damaged files, and seconds left. The seconds
    are None where nothing waits or no rate is known.
    """
    from reports.studies.sweep.page import sweep_state

    return {name: value for name, value in sweep_state(store).items() if name != "table"}


def status(folder: Path, _: Options) -> Answer:
    """The command `sweep status`: how far the sweep stored in `folder` is: points done, failed and
    waiting, time left. Returns exit code 0, what the terminal shows, and the content of the JSON
    output.
    """
    from reports.studies.sweep.store import Store

    # by name: title, numbers of points, failures, damaged files, seconds left
    json_content = _content(Store(folder))

    def terminal_output() -> Iterator[Part]:
        """What the terminal shows of a sweep: a table of the numbers of its points, then damaged
        files, failures (at most 20, `_MOST_ROWS`), and the time left. `json_content` has all of it.
        """
        # Sheet: a table of title, heads, rows and indices of right-aligned columns
        counts = [(state, str(count)) for state, count in json_content["points"].items()]
        title = json_content["title"] or str(folder)
        yield Sheet(title, ("points", "number"), counts, (1,))
        yield from (
            f"damaged and set aside: results/{name}; the next sweep makes it again"
            for name in json_content["damaged"]
        )
        failures = json_content["failures"]
        yield from (
            f"point {failure['point']} failed: {failure['reason']}"
            for failure in failures[:_MOST_ROWS]
        )
        n_further_failures = len(failures) - _MOST_ROWS
        if n_further_failures > 0:
            yield f"... and {n_further_failures} more failed; see index.csv"
        seconds_left = json_content["seconds_left"]
        if seconds_left is not None:
            yield f"about {seconds_left:.0f} s of work left at the rate of the last results"

    # EXIT_WITHIN: exit code 0
    return Answer(EXIT_WITHIN, terminal_output(), lambda: json_content)


def report(folder: Path, _: Options) -> Answer:
    """The command `sweep report`: write the page of the sweep stored in `folder`, with its table
    and a figure of each quantity, also while it runs.
    """
    from reports.studies.sweep.page import write_page
    from reports.studies.sweep.store import Store

    page = str(write_page(Store(folder)))
    return Answer(EXIT_WITHIN, [page], lambda: _content(Store(folder)) | {"page": page})
