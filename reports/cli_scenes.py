"""The commands about scenes and this machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from reports.application import Out, SceneName, app


@app.command(sort_key=4, help_epilogue="")
def scenes(
    name: Annotated[str, Parameter(help="Show this scene in detail: a name of the library, or a .toml or .json file.")] = "",
    /,
    *,
    tag: Annotated[tuple[str, ...], Parameter(help="Only scenes that have this tag; again for scenes that have all of them.")] = (),
    json: Annotated[bool, Parameter(negative="", help="As JSON.")] = False,
) -> int:
    """The library of scenes, with a small sketch each: the bodies (a flat gap exaggerated), and Q over P."""
    from reports import commands_scenes

    return commands_scenes.scenes(name, tag, json)


@app.command(sort_key=5, help_epilogue="")
def init(
    file: Annotated[Path, Parameter(help="New file, ending in .toml.")],
    *,
    start: Annotated[
        str, Parameter("--from", help="Copy this library scene, with the files it reads, instead of the commented example.")
    ] = "",
    bodies: Annotated[bool, Parameter(negative="", help="The example with a block and a pad in place of half-planes.")] = False,
) -> int:
    """Write a commented scene to start from; never over a file that exists."""
    from reports import commands_scenes

    return commands_scenes.init(file, start, bodies)


@app.command(sort_key=6, help_epilogue="")
def check(scene: SceneName) -> int:
    """Read a scene, and see whether its loads stay clear of gross sliding and separation."""
    from reports import commands_scenes

    return commands_scenes.check(scene)


@app.command(sort_key=7, help_epilogue="")
def schema() -> int:
    """The JSON schema of a scene file, for editors."""
    from reports import commands_scenes

    return commands_scenes.schema()


@app.command(sort_key=8, help_epilogue="")
def doctor(*, out: Out = None) -> int:
    """Can this machine do the work?"""
    from reports import commands_machine

    return commands_machine.doctor(out)
