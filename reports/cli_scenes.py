"""The commands about scenes and this machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from reports.application import Out, SceneName, app


@app.command(sort_key=4, help_epilogue="")
def scenes() -> int:
    """The library of scenes."""
    from reports import commands

    return commands.scenes()


@app.command(sort_key=5, help_epilogue="")
def init(
    file: Annotated[Path, Parameter(help="New file, ending in .toml.")],
    *,
    like: Annotated[str, Parameter(help="Start from this library scene instead of the commented example.")] = "",
    bodies: Annotated[bool, Parameter(negative="", help="The example with a block and a pad in place of half-planes.")] = False,
) -> int:
    """Write a commented scene to start from; never over a file that exists."""
    from reports import commands

    return commands.init(file, like, bodies)


@app.command(sort_key=6, help_epilogue="")
def check(scene: SceneName) -> int:
    """Read a scene, and see whether its loads stay clear of gross sliding and separation."""
    from reports import commands

    return commands.check(scene)


@app.command(sort_key=7, help_epilogue="")
def schema() -> int:
    """The JSON schema of a scene file, for editors."""
    from reports import commands

    return commands.schema()


@app.command(sort_key=8, help_epilogue="")
def doctor(*, out: Out = None) -> int:
    """Can this machine do the work?"""
    from reports import commands

    return commands.doctor(out)
