"""What commands share: options as frozen values, of which one that is left out keeps the engine's own default; `--json`, one
envelope for every command, and its schema."""

# Annotations are evaluated here, and not by name where a class of another module inherits them: no `from __future__`.
import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from importlib import resources
from json import dumps, loads
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter, Token

if TYPE_CHECKING:
    from halfplane_fe import SolverSettings
    from meshes import MeshSettings

SceneName = Annotated[str, Parameter(name="scene", help="Name of a library scene, or a .toml or .json file.")]

_MESH = Group("Mesh (lengths over the contact half-width; what is left out is the engine's own)", sort_key=2)
_SOLVER = Group("Solver (what is left out is the engine's own)", sort_key=3)


def _mesh(words: str) -> Parameter:
    return Parameter(group=_MESH, help=words)


def _solver(words: str) -> Parameter:
    return Parameter(group=_SOLVER, help=words)


def _whole(_: type, tokens: Sequence[Token]) -> int:
    try:
        return int(tokens[0].value)
    except ValueError:
        raise ValueError(f"{tokens[0].value!r} is no whole number") from None  # what reads options would round it


# A number of things: nothing is rounded.
Count = Annotated[int, Parameter(converter=_whole)]


def flag(words: str) -> Parameter:
    """A switch that has no opposite."""
    return Parameter(negative="", help=words)


def several(words: str) -> Parameter:
    """An option with one value or many: `--vtu 1 2`, or the option again."""
    return Parameter(consume_multiple=True, negative="", help=words)


Silent = Annotated[bool, flag("Print nothing: the exit code is the answer.")]
Json = Annotated[bool, flag("As JSON on stdout, and nothing else there.")]
Tolerance = Annotated[tuple[str, ...], several("5%: of dissipation, peak pressure and both half-widths; KEY=VALUE: of one metric.")]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Output:
    """Where the results go, and what is printed."""

    out: Annotated[Path | None, Parameter(help="Folder for the results; out/<scene name> if left out.")] = None
    json: Json = False
    quiet: Annotated[bool, flag("No progress on stderr.")] = False

    def command(self, name: str, operand: str, out: Path) -> str:
        """The command line that repeats this: every option that differs from its default but --json and --quiet.

        >>> FiniteElements(order=1, quiet=True).command("run", "hertz-paper", Path("out/first"))
        'halfplane run hertz-paper --order 1 --out out/first'
        """
        words = ["halfplane", name, *([operand] if operand else [])]
        for one in fields(self):
            value, option = getattr(self, one.name), one.name.replace("_", "-")
            if value == one.default or one.name in ("out", "json", "quiet"):
                continue
            if isinstance(value, bool):
                words.append(f"--{option}" if value else f"--no-{option}")
            else:
                words += [f"--{option}", *(map(str, value) if isinstance(value, tuple) else [str(value)])]
        return shlex.join([*words, "--out", str(out)])


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class FiniteElements(Output):
    """How the finite-element side is meshed and iterated; None leaves the preset's."""

    preset: Annotated[
        Literal["default", "coarse", "fine"],
        _mesh("Mesh to start from: coarse for a first look, fine for a result to rely on."),
    ] = "default"
    element_size: Annotated[float | None, _mesh("Surface elements where the tractions are smooth.")] = None
    edge_element_size: Annotated[float | None, _mesh("Surface elements where the contact and stick edges travel.")] = None
    far_radius: Annotated[float | None, _mesh("Radius of the half-disc that stands for a half-plane.")] = None
    growth: Annotated[float | None, _mesh("Growth of the elements away from the contact.")] = None
    order: Annotated[Count | None, _mesh("Order of the elements, 1 or 2.")] = None
    method: Annotated[
        Literal["augmented_lagrangian", "penalty"] | None,
        _solver("The contact law met exactly, or an elastic layer between the faces."),
    ] = None
    steps_per_cycle: Annotated[Count | None, _solver("Steps of a revolution; turning points come on top.")] = None
    step_tolerance: Annotated[float | None, _solver("Error of a revolution's steps over W above which steps are halved.")] = None
    normal_stiffness: Annotated[float | None, _solver("Of the penalty layer, over E*/h; without one no answer depends on it.")] = (
        None
    )
    tangential_stiffness: Annotated[
        float | None, _solver("Of the penalty layer, over E*/h; without one no answer depends on it.")
    ] = None
    max_iterations: Annotated[Count | None, _solver("Of one step, before it counts as not converged.")] = None

    def settings(self) -> "tuple[MeshSettings, SolverSettings]":
        """The settings objects; InputError for a value out of range.

        >>> mesh, _ = FiniteElements(preset="coarse", growth=0.2).settings()
        >>> mesh.edge_element_size, mesh.growth
        (0.03125, 0.2)
        """
        from halfplane_fe import SolverSettings
        from meshes import MeshSettings

        given = {one.name: value for one in fields(FiniteElements) if (value := getattr(self, one.name)) is not None}
        mesh = {name: given[name] for name in given if name in MeshSettings.__dataclass_fields__}
        solver = {name: given[name] for name in given if name in SolverSettings.__dataclass_fields__}
        return replace(MeshSettings.preset(self.preset), **mesh), SolverSettings(**solver)


# What a tolerance without a key is for: W, p0, a and c.
_COMMON = ("dissipation", "largest_pressure", "largest_half_width", "permanent_stick")


def share_of(text: str) -> float:
    """The share that a user writes as 5% or 0.05; NaN where it is no number."""
    try:
        return float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        return math.nan


def tolerances_of(words: Sequence[str]) -> dict[str, float]:
    """Metric key -> tolerance, of `--tolerance 5%` (W, p0, a and c together) and `--tolerance KEY=VALUE`, the last of a key.

    Raises
    ------
    InputError
        For a key that is none, for what is no share above 0, and for 1 or more without the sign %: 5 may be meant as 5 %.

    >>> tolerances_of(["5%", "dissipation=0.03"])
    {'dissipation': 0.03, 'largest_pressure': 0.05, 'largest_half_width': 0.05, 'permanent_stick': 0.05}
    """
    if not words:
        return {}
    from reports.comparison.metrics import METRICS
    from scenes import InputError
    from scenes.frozen import did_you_mean

    found: dict[str, float] = {}
    for word in words:
        key, equals, text = word.rpartition("=")
        if equals and key not in METRICS:
            known = list(METRICS)
            raise InputError(f"--tolerance {word}: unknown metric {key!r};{did_you_mean(key, known)} there are {', '.join(known)}")
        value = share_of(text)
        if not 0 < value < math.inf:
            raise InputError(f"--tolerance {word}: write a share above 0, such as 5% or 0.05, or one of a metric: dissipation=3%")
        if value >= 1 and not text.endswith("%"):
            ways = f"{key}{equals}{value:g}%, or {key}{equals}{100 * value:g}%"
            raise InputError(f"--tolerance {word}: a number without % is a share, and this is {100 * value:g} %; write {ways}")
        found |= dict.fromkeys([key] if equals else _COMMON, value)
    return found


# ------------------------------------------------------------------------------------------------------------- answers
FORMAT = "halfplane answer 2"


def answer(command: str, code: int, result: Mapping[str, Any], scene: str | None = None) -> int:
    """Print the answer of a command as the one JSON document on stdout, and give its exit code.

    What is not finite in `result` becomes null. `scene` is the name of the scene; None where a command is about none.
    """
    from reports.comparison.words import strict
    from reports.console import say

    content = {"format": FORMAT, "command": command, "exit_code": code, "scene": scene, "result": result}
    say(dumps(strict(content), allow_nan=False, indent=1, ensure_ascii=False))
    return code


def answer_schema() -> dict[str, Any]:
    """The JSON schema of every answer: the envelope, and for each command what `result` holds."""
    found: dict[str, Any] = loads((resources.files("reports") / "templates" / "answer.schema.json").read_text("utf-8"))
    return found
