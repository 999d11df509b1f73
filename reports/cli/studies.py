"""The commands of many runs: sweeps, how far one is, its page; and the maps of the idealisation error, which are made of them."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Group, Parameter

from reports.cli.options import Count, Json, Output, answer, flag
from reports.cli.process import INTERRUPTED, NOT_CONVERGED, WITHIN
from reports.console import Stages, complain, say, show_table

if TYPE_CHECKING:
    from reports.sweep.running import Prepared
    from reports.sweep.store import Store

_SHOWN, _NOTES = 20, 3

sweep_app = App(name="sweep", help_epilogue="", group_commands=Group("Of a sweep that is there"))
_Folder = Annotated[Path, Parameter(help="Folder of a sweep.")]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class SweepOptions(Output):
    """Who computes the points of a study, and where they are stored."""

    out: Annotated[Path | None, Parameter(help="Folder of the store; out/<study file> if left out.")] = None
    executor: Annotated[Literal["processes", "dask"], Parameter(help="Processes of this machine, or a dask cluster.")] = "processes"
    scheduler: Annotated[str, Parameter(help="Address of your dask scheduler; without one a cluster starts on this machine.")] = ""
    workers: Annotated[Count | None, Parameter(help="Processes, or tasks at once; all cores if left out.")] = None
    tls_ca_file: Annotated[Path | None, Parameter(help="Certificates trusted, of a tls:// scheduler (PEM).")] = None
    tls_cert: Annotated[Path | None, Parameter(help="Our own certificate (PEM).")] = None
    tls_key: Annotated[Path | None, Parameter(help="Its private key (PEM).")] = None
    resume: Annotated[bool, flag("What every run does: the results that the folder holds are used.")] = False


_SWEEP = SweepOptions()


@sweep_app.default
def sweep(
    study: Annotated[str, Parameter(help="A study file, .toml or .json; see docs/sweeps.md.")], *, options: SweepOptions = _SWEEP
) -> int:
    """Every point of a scene's axes, into a store; run it again to resume it; 3 where a point failed."""
    code, _ = _swept(study, options, tell=True)
    return code


def _swept(source: str, options: SweepOptions, *, tell: bool) -> tuple[int, dict[str, Any] | None]:
    """Run a study, or resume it: the exit code, and how far it is. Without `tell` nothing is printed on stdout."""
    from reports.folder import claim, default_folder
    from reports.sweep.running import prepare, work, workers_of
    from reports.sweep.store import StoreError
    from reports.sweep.study import described

    stages = Stages(options.quiet)
    folder = claim(options.out or default_folder(Path(source).stem))
    workers = {name: getattr(options, name) for name in ("executor", "scheduler", "workers", "tls_ca_file", "tls_cert", "tls_key")}
    workers_of(**workers)
    with stages.stage("checking the study", "points") as report:
        prepared = prepare(source, folder, lambda count: report(count, None, f"{count} points checked"))
    if tell and not options.json:
        _announce(prepared)
    again = replace(options, resume=False).command("sweep", source, folder)

    def stored() -> str:
        known = prepared.store.addresses()
        return f"{sum(point.address in known for point in prepared.points)} of {len(prepared.points)} points are stored"

    try:
        with stages.stage("sweep", "points") as report:
            table = work(prepared, report=report, **workers)
    except KeyboardInterrupt:
        complain(f"halfplane: interrupted; {stored()}; resume with: {again}")
        return INTERRUPTED, None
    except StoreError as fault:
        raise StoreError(f"{fault}; {stored()}; once there is room resume with: {again}") from fault
    failed = table[table["status"] != "done"]
    code, state, index = NOT_CONVERGED if len(failed) else WITHIN, _content(prepared.store), prepared.store.folder / "index.csv"
    if tell and options.json:
        answer("sweep", code, state | {"file": str(index)}, prepared.study.scene.name)
    elif tell:
        if len(failed):
            at = [described(prepared.points[number].coordinates) for number in failed["number"][:_SHOWN]]
            rows = list(zip(map(str, failed["number"]), at, failed["reason"], strict=False))
            show_table(f"{len(failed)} of {len(table)} points failed", ("point", "at", "reason"), rows)
        say(f"{len(table) - len(failed)} points done, {len(failed)} failed; `halfplane sweep report {folder}` draws them")
        for one in state["notes"][:_NOTES]:
            say(f"note on {one['points']} of {len(table)} points: {one['note']}")
        if (more := len(state["notes"]) - _NOTES) > 0:
            say(f"... and {more} other notes; see index.csv")
        say(str(index))
    return code, state


def _announce(prepared: Prepared) -> None:
    study, points, waiting = prepared.study, len(prepared.points), len(prepared.waiting)
    say(f"{study.title or study.scene.name}: {points} points, {' and '.join(study.engines)}; {', '.join(study.figures)}")
    if waiting < points:
        say(f"{points - waiting} points have results already, {waiting} are left")
    if damaged := prepared.store.damaged():
        say(f"{len(damaged)} damaged results were set aside and are made again: {', '.join(damaged[:3])}")


def _content(store: Store) -> dict[str, Any]:
    """How far a sweep is, for programs; `seconds_left` is null where no sweep is at work or no rate is known."""
    from reports.sweep.page import state_of

    return {name: value for name, value in state_of(store).items() if name != "table"}


@sweep_app.command(help_epilogue="")
def status(folder: _Folder, /, *, json: Json = False) -> int:
    """How far a sweep is: done, failed, running, time left."""
    from reports.sweep.store import Store

    state = _content(Store(folder))
    if json:
        return answer("sweep status", WITHIN, state)
    show_table(state["title"] or str(folder), ("points", "number"), [(k, str(n)) for k, n in state["points"].items()], right=(1,))
    for name in state["damaged"]:
        say(f"damaged and set aside: results/{name}; the next sweep makes it again")
    for one in state["failures"][:_SHOWN]:
        say(f"point {one['point']} failed: {one['reason']}")
    if (more := len(state["failures"]) - _SHOWN) > 0:
        say(f"... and {more} more failed; see index.csv")
    if state["seconds_left"] is not None:
        say(f"about {state['seconds_left']:.0f} s left")
    elif state["points"]["waiting"] and not state["points"]["running"]:
        say("no sweep is at work here")
    return WITHIN


@sweep_app.command(help_epilogue="")
def report(folder: _Folder, /, *, json: Json = False) -> int:
    """The page of a sweep: its table and a figure of each quantity, also while it runs."""
    from reports.sweep.page import write_page
    from reports.sweep.store import Store

    page = write_page(Store(folder))
    if json:
        return answer("sweep report", WITHIN, _content(Store(folder)) | {"page": str(page)})
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
    workers: Annotated[Count | None, Parameter(help="Processes; all cores if left out.")] = None
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
    from reports.folder import replace_text
    from reports.maps.laws import MAPS, PUBLISHED, STUDIES, as_csv, map_named
    from reports.maps.pages import require_free, write
    from reports.sweep import read_index
    from scenes import InputError

    if options.out is None and not (PUBLISHED / "README.md").exists():
        raise InputError("the published maps are those of a checkout, and this is an installed copy: name a folder by --out")
    folder, code, states = options.out or PUBLISHED, WITHIN, dict[str, Any]()
    wanted = list(MAPS.values()) if name == "all" else [map_named(name)]
    require_free(folder)
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
        states[study] = state
    write(folder)
    page = folder / "README.md"
    if options.json:
        for state in states.values():
            state.pop("title")
        return answer("map", code, {"passed": code == WITHIN, "studies": states, "page": str(page)})
    say(str(page))
    return code
