"""The commands about scenes, this machine and its shell."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from reports.answers import SceneAnswers
from reports.application import MACHINE, SCENES, Json, SceneName, Silent, app

_NO_ANSWERS = SceneAnswers()


@app.command(group=SCENES, sort_key=3, help_epilogue="")
def scenes(
    name: Annotated[str, Parameter(help="Show this scene in detail: a name of the library, or a .toml or .json file.")] = "",
    /,
    *,
    tag: Annotated[tuple[str, ...], Parameter(help="Only scenes that have this tag; again for scenes that have all of them.")] = (),
    json: Json = False,
) -> int:
    """The library of scenes, with a small sketch each: the bodies (a flat gap exaggerated), and Q over P."""
    from reports import commands_scenes

    return commands_scenes.scenes(name, tag, json)


@app.command(group=SCENES, sort_key=1, help_epilogue="")
def init(
    file: Annotated[Path, Parameter(help="New file, ending in .toml.")],
    *,
    start: Annotated[
        str, Parameter("--from", help="Copy this library scene, with the files it reads, instead of the commented example.")
    ] = "",
    bodies: Annotated[bool, Parameter(negative="", help="The example with a block and a pad in place of half-planes.")] = False,
    quiet: Annotated[bool, Parameter(negative="", help="Ask and say nothing.")] = False,
    answers: SceneAnswers = _NO_ANSWERS,
) -> int:
    """Write a commented scene to start from, never over a file that exists; on a terminal without options it asks."""
    from reports import commands_scenes

    return commands_scenes.init(file, start, bodies, answers, quiet)


@app.command(group=SCENES, sort_key=2, help_epilogue="")
def check(scene: SceneName, *, json: Json = False, quiet: Silent = False) -> int:
    """Refuse what `run` would refuse; say how large the contact gets and how near gross sliding comes."""
    from reports import commands_scenes

    return commands_scenes.check(scene, json, quiet)


@app.command(group=SCENES, sort_key=4, help_epilogue="")
def schema() -> int:
    """The JSON schema of a scene file, for editors."""
    from reports import commands_scenes

    return commands_scenes.schema()


@app.command(group=MACHINE, sort_key=1, help_epilogue="")
def doctor(
    *,
    out: Annotated[Path | None, Parameter(help="Folder whose disk and rights are looked at; out if left out.")] = None,
    json: Json = False,
    quiet: Silent = False,
) -> int:
    """Can this machine do the work?"""
    from reports import commands_machine

    return commands_machine.doctor(out, json, quiet)


@app.command(group=MACHINE, sort_key=2, help_epilogue="")
def completion(shell: Annotated[Literal["bash", "zsh", "fish"], Parameter(help="The shell that is to complete words.")]) -> int:
    """A script that completes commands and options: eval "$(halfplane completion bash)" in ~/.bashrc."""
    from reports import commands_machine

    return commands_machine.completion(shell)
