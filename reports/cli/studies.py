"""The commands of many runs: sweeps, how far one is, its page; and the maps of the idealisation error, which are made of them."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Group, Parameter

from reports.cli.answers import answer
from reports.cli.options import Output, flag
from reports.cli.process import INTERRUPTED, NOT_CONVERGED, WITHIN
from reports.console import Stages, complain, say, show_table

if TYPE_CHECKING:
    from reports.sweep.progress import State
    from reports.sweep.running import Prepared

_SHOWN, _NOTES = 20, 3

sweep_app = App(name="sweep", help_epilogue="", group_commands=Group("Of a sweep that is there"))
Folder = Annotated[Path, Parameter(help="Folder of a sweep.")]
Json = Annotated[bool, flag("As JSON on stdout, and nothing else there.")]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class SweepOptions(Output):
    """Who computes the points of a study, and where they are stored."""

    out: Annotated[Path | None, Parameter(help="Folder of the store; out/<study file> if left out.")] = None
    executor: Annotated[Literal["processes", "dask"], Parameter(help="Processes of this machine, or a dask cluster.")] = "processes"
    scheduler: Annotated[str, Parameter(help="Address of the dask scheduler, such as tcp://node1:8786.")] = ""
    workers: Annotated[int | None, Parameter(help="Processes, or tasks at once; all cores if left out.")] = None
    resume: Annotated[bool, flag("Use the results that the folder holds.")] = False


_SWEEP = SweepOptions()


@sweep_app.default
def sweep(
    study: Annotated[str, Parameter(help="A study file, .toml or .json; see docs/sweeps.md.")], *, options: SweepOptions = _SWEEP
) -> int:
    """Every point of a scene's axes, into a store; 3 where a point failed."""
    code, _ = _swept(study, options, tell=True)
    return code


def _swept(source: str, options: SweepOptions, *, tell: bool) -> tuple[int, State | None]:
    """Run a study, or resume it: the exit code, and how far it is. Without `tell` nothing is printed on stdout."""
    from reports.folder import claim, default_folder
    from reports.sweep.crews import available_cores, crew_of
    from reports.sweep.points import described
    from reports.sweep.progress import state_of, teller
    from reports.sweep.running import prepare, work
    from reports.sweep.store import StoreError

    stages = Stages(options.quiet)
    folder = claim(options.out or default_folder(Path(source).stem))
    executor, scheduler, workers = options.executor, options.scheduler, options.workers
    crew_of(executor, scheduler, workers)
    with stages.stage("checking the study") as report:
        prepared = prepare(source, folder, resume=options.resume, report=lambda count: report(count, None, "points checked"))
    if tell and not options.json:
        _announce(prepared, workers or available_cores(), executor)
    again = replace(options, resume=True).command("sweep", source, folder)

    def stored() -> str:
        known = prepared.store.addresses()
        return f"{sum(p.address in known for p in prepared.plan.points)} of {len(prepared.plan.points)} points are stored"

    try:
        with stages.stage("sweep") as report:
            told = teller(stages, report, options.quiet)
            table = work(prepared, executor=executor, scheduler=scheduler, workers=workers, report=told)
    except KeyboardInterrupt:
        complain(f"halfplane: interrupted; {stored()}; go on with: {again}")
        return INTERRUPTED, None
    except StoreError as fault:
        raise StoreError(f"{fault}; {stored()}; once there is room go on with: {again}") from fault
    failed = [row for row in table.rows if row["status"] != "done"]
    code, state, index = NOT_CONVERGED if failed else WITHIN, state_of(prepared.store)[0], prepared.store.folder / "index.csv"
    if tell and options.json:
        answer("sweep", code, _content(state) | {"file": str(index)}, prepared.study.scene.name)
    elif tell:
        if failed:
            rows = [
                (str(row["number"]), described({name: row[name] for name in table.axes}), row["reason"]) for row in failed[:_SHOWN]
            ]
            show_table(f"{len(failed)} of {len(table.rows)} points failed", ("point", "at", "reason"), rows)
        say(f"{len(table.rows) - len(failed)} points done, {len(failed)} failed; `halfplane sweep report {folder}` draws them")
        notes = table.notes()
        for note, count in notes[:_NOTES]:
            say(f"note on {count} of {len(table.rows)} points: {note}")
        if len(notes) > _NOTES:
            say(f"... and {len(notes) - _NOTES} other notes; see index.csv")
        say(str(index))
    return code, state


def _announce(prepared: Prepared, workers: int, executor: str) -> None:
    from reports.sweep.executing import Tally
    from reports.sweep.progress import duration, time_left

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
        say(f"{len(damaged)} damaged results were set aside and are computed again: {', '.join(damaged[:3])}")
    tally = Tally(points, skipped=points - len(prepared.waiting), workers=workers)
    left = time_left(tally, prepared.seconds_each)
    if prepared.waiting and executor == "processes":
        known = f"about {duration(left)}, from the stored results" if left is not None else "told once the first points are done"
        say(f"time: {known}; {workers} process{'es' if workers > 1 else ''}")


def _content(state: State) -> dict[str, Any]:
    """How far a sweep is, for programs; `seconds_left` is null where no sweep is at work or no rate is known."""
    return {
        "title": state.title,
        "points": {name: getattr(state, name) for name in ("done", "failed", "running", "waiting", "total")},
        "seconds_left": state.left,
        "damaged": state.damaged,
        "failures": [{"point": number, "reason": reason} for number, reason in state.failures],
        "notes": [{"note": note, "points": count} for note, count in state.notes],
    }


@sweep_app.command(help_epilogue="")
def status(folder: Folder, /, *, json: Json = False) -> int:
    """How far a sweep is: done, failed, running, time left."""
    from reports.sweep.progress import duration, state_of
    from reports.sweep.store import Store

    state, _ = state_of(Store(folder))
    if json:
        return answer("sweep status", WITHIN, _content(state))
    counts = [(name, str(count)) for name, count in _content(state)["points"].items()]
    show_table(state.title or str(folder), ("points", "number"), counts, right=(1,))
    for name in state.damaged:
        say(f"damaged and set aside: results/{name}; the next sweep computes it again")
    for number, reason in state.failures[:_SHOWN]:
        say(f"point {number} failed: {reason}")
    if len(state.failures) > _SHOWN:
        say(f"... and {len(state.failures) - _SHOWN} more failed; see index.csv")
    if state.left is not None:
        say(f"about {duration(state.left)} left")
    elif state.waiting:
        say("no sweep is at work here" if not state.running else "time left: told once two points are done")
    return WITHIN


@sweep_app.command(help_epilogue="")
def report(folder: Folder, /, *, json: Json = False) -> int:
    """The page of a sweep: its table and a figure of each quantity, also while it runs."""
    from reports.sweep.page import write_page
    from reports.sweep.progress import state_of
    from reports.sweep.store import Store

    store = Store(folder)
    page = write_page(store)
    if json:
        return answer("sweep report", WITHIN, _content(state_of(store)[0]) | {"page": str(page)})
    say(str(page))
    return WITHIN


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class MapOptions(Output):
    """Where a map's tables, pages and sweeps are."""

    out: Annotated[Path | None, Parameter(help="Folder of tables and pages; a checkout's reports/published/maps if left out.")] = (
        None
    )
    stores: Annotated[Path, Parameter(help="Folder of the sweeps' stores.")] = Path("out/maps")
    workers: Annotated[int | None, Parameter(help="Processes; all cores if left out.")] = None
    remake: Annotated[bool, flag("Start afresh: drop the sweeps' results first.")] = False
    pages: Annotated[bool, flag("Laws, figures and pages alone, from the tables that are there.")] = False


_MAP = MapOptions()


def make_map(name: Annotated[str, Parameter(help="Name of a map (docs/maps.md), or all.")], *, options: MapOptions = _MAP) -> int:
    """Run the studies of a map, or of all, and write tables and pages; 3 where a point failed.

    Raises
    ------
    InputError
        Where `out` is left out in an installed copy, whose tables `halfplane advise` reads.
    """
    from reports.maps.atlas import MAPS, PUBLISHED, STUDIES, map_named
    from reports.maps.laws import as_csv
    from reports.maps.pages import present, write
    from reports.staging import replace_text
    from reports.sweep import read_index
    from scenes import InputError

    if options.out is None and not (PUBLISHED / "README.md").exists():
        raise InputError("the published maps are those of a checkout, and this is an installed copy: name a folder by --out")
    folder, code, states = options.out or PUBLISHED, WITHIN, dict[str, Any]()
    wanted = list(MAPS.values()) if name == "all" else [map_named(name)]
    folder.mkdir(parents=True, exist_ok=True)
    for study in [study for one in wanted for study in one.studies] if not options.pages else ():
        store = options.stores / study
        if options.remake and store.exists():
            shutil.rmtree(store)
        how = SweepOptions(out=store, workers=options.workers, resume=True, quiet=options.quiet)
        one_code, state = _swept(str(STUDIES / f"{study}.toml"), how, tell=not options.json)
        code = max(code, one_code)
        replace_text(folder / f"{study}.csv", as_csv(read_index(store)))
        if code > NOT_CONVERGED or state is None:
            return code
        states[study] = _content(state)
    write(folder, present(folder))
    page = folder / "README.md"
    if options.json:
        for state in states.values():
            state.pop("title")
        return answer("map", code, {"passed": code == WITHIN, "studies": states, "page": str(page)})
    say(str(page))
    return code
