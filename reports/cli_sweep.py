"""The commands of sweeps."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, Group, Parameter

from reports.application import SOLVE, Json, Quiet, app

_sweep = App(
    name="sweep",
    help="Run a study: a scene over axes of its keys, into a store that a later run goes on with.",
    group=SOLVE,
    sort_key=5,
    help_epilogue="",
    group_commands=Group("Of a sweep that is there"),
)
app.command(_sweep)
Folder = Annotated[Path, Parameter(help="Folder of a sweep.")]


@_sweep.default
def sweep(
    study: Annotated[str, Parameter(help="A study file, .toml or .json; see docs/sweeps.md.")],
    *,
    executor: Annotated[
        Literal["processes", "dask"], Parameter(help="Processes of this machine, or a dask cluster.")
    ] = "processes",
    scheduler: Annotated[str, Parameter(help="Address of the dask scheduler, such as tcp://node1:8786.")] = "",
    workers: Annotated[int | None, Parameter(help="Processes, or tasks at once; all cores if left out.")] = None,
    resume: Annotated[bool, Parameter(negative="", help="Go on with the results that the folder holds.")] = False,
    out: Annotated[Path | None, Parameter(help="Folder of the store; out/<study file> if left out.")] = None,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run a study: every point of a scene's axes, into a store that a later run goes on with."""
    from reports.sweep import command

    return command.sweep(study, out, executor, scheduler, workers, resume, quiet, as_json=json)


@_sweep.command(help_epilogue="")
def status(folder: Folder, /, *, json: Json = False) -> int:
    """How far a sweep is: done, failed, running, time left."""
    from reports.sweep import command

    return command.status(folder, json)


@_sweep.command(help_epilogue="")
def report(folder: Folder, /, *, json: Json = False) -> int:
    """The page of a sweep: its table and a figure of each quantity, also while it runs."""
    from reports.sweep import command

    return command.report(folder, json)
