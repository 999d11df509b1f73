"""The commands of the maps of the idealisation error."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from reports.application import JUDGE, Json, Quiet, SceneName, app


@app.command(name="map", group=JUDGE, sort_key=4, help_epilogue="")
def map_(
    name: Annotated[str, Parameter(help="Name of a map (docs/maps.md), or all.")],
    *,
    out: Annotated[
        Path | None, Parameter(help="Folder of tables and pages; a checkout's reports/published/maps if left out.")
    ] = None,
    stores: Annotated[Path, Parameter(help="Folder of the sweeps' stores.")] = Path("out/maps"),
    workers: Annotated[int | None, Parameter(help="Processes; all cores if left out.")] = None,
    remake: Annotated[bool, Parameter(negative="", help="Start afresh: drop the sweeps' results first.")] = False,
    pages: Annotated[bool, Parameter(negative="", help="Laws, figures and pages alone, from the tables that are there.")] = False,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run the studies of a map of the idealisation error, going on where they were left, and write its page."""
    from reports.maps import command

    return command.make(name, out, stores, workers, remake=remake, pages_only=pages, quiet=quiet, as_json=json)


@app.command(group=JUDGE, sort_key=3, help_epilogue="")
def advise(
    scene: SceneName,
    *,
    limit: Annotated[float, Parameter(help="Error of dissipation up to which half-plane theory may be used, a share.")] = 0.05,
    json: Json = False,
) -> int:
    """May half-plane theory be used? Read off the published maps, without finite elements; exit code 1: better not."""
    from reports.maps import advice

    return advice.tell(scene, limit, json)
