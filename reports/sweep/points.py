"""From a study to its points: every scene built, checked and given the address of its result, before anything is solved."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from reports.checking import require_admissible
from reports.sweep.axes import Coordinates, Value, grid
from reports.sweep.expressions import evaluate
from reports.sweep.study import Study
from reports.sweep.versions import code_versions
from scenes import InputError, Scene
from scenes.frozen import neglected, refusal
from scenes.scene import WORDS

if TYPE_CHECKING:
    from halfplane_fe import SolverSettings
    from meshes import MeshSettings

_MOST = 1_000_000
_KINDS = {int: "a whole number", float: "a number", str: "a word", bool: "true or false"}


@dataclass(frozen=True, eq=False)
class Point:
    """One point of a study.

    Attributes
    ----------
    number : counted from 0, the last axis first
    coordinates : column -> value
    scene, mesh, solver : what is solved
    address : of its result: sha256 of the question, the settings, the figures asked for, and the code
    """

    number: int
    coordinates: Mapping[str, Value]
    scene: Scene
    mesh: MeshSettings
    solver: SolverSettings
    address: str

    def job(self) -> dict[str, Any]:
        """The point as it travels to a worker: JSON, and nothing else."""
        return {
            "address": self.address,
            "scene": self.scene.model_dump(mode="json"),
            "mesh": asdict(self.mesh),
            "solver": asdict(self.solver),
        }


def expand(study: Study, report: Callable[[int], None] | None = None) -> tuple[Point, ...]:
    """All points of a study, checked; `report` is called with the number of points so far.

    Raises
    ------
    InputError
        Naming the point, its coordinates and the rule, for the first that is no scene, slides or separates, or is there twice.
    """
    from halfplane_fe.interface import check_supports
    from halfplane_fe.scales import sheared

    points: list[Point] = []
    seen: dict[str, int] = {}
    raw = json.loads(study.scene.model_dump_json())
    for number, coordinates in enumerate(grid(study.axes, study.samples, study.seed)):
        if number == _MOST:
            raise InputError(f"the study has more than {_MOST} points; take fewer values on its axes")
        where = f"point {number} ({described(coordinates)})"
        try:
            point = _point(study, raw, number, coordinates)
            require_admissible(point.scene, where)
            if "fe" in study.engines:
                check_supports(point.scene, sheared(point.scene))
        except InputError as fault:
            raise InputError(str(fault) if str(fault).startswith(where) else f"{where}: {fault}") from fault
        if point.address in seen:
            raise InputError(f"{where} asks the same as point {seen[point.address]}: an axis has a value twice, or moves nothing")
        seen[point.address] = number
        points.append(point)
        if report is not None:
            report(number + 1)
    return tuple(points)


def described(coordinates: Mapping[str, Any]) -> str:
    """The coordinates in words.

    >>> described({"height": 4.0, "base": "fixed"})
    'height = 4, base = fixed'
    """
    return ", ".join(
        f"{name} = {value:.6g}" if isinstance(value, float) else f"{name} = {value}" for name, value in coordinates.items()
    )


def _point(study: Study, raw: Mapping[str, Any], number: int, coordinates: Coordinates) -> Point:
    values = _assignments(study, coordinates)
    data = json.loads(json.dumps(raw))
    settings: dict[str, dict[str, Any]] = {"mesh": {}, "solver": {}}
    for key, value in values.items():
        head, _, rest = key.partition(".")
        if head in settings:
            settings[head][rest] = value
        else:
            _place(data, key, value)
    scene = _scene(data)
    mesh, solver = _settings(study.preset, settings["mesh"], settings["solver"])
    return Point(number, coordinates, scene, mesh, solver, _address(study, scene, mesh, solver))


def _assignments(study: Study, coordinates: Coordinates) -> dict[str, Value]:
    """Dotted key -> value of one point."""
    found: dict[str, Value] = dict(study.set)
    names: dict[str, Value] = dict(coordinates)
    for axis in study.axes:
        found |= {key: coordinates[column] for key, column in axis.targets}
    for name, text in study.derived.items():
        value = float(text) if isinstance(text, int | float) else evaluate(text, names)
        if "." in name:
            found[name] = value
        else:
            names[name] = value
    return found


def _place(data: dict[str, Any], key: str, value: Value) -> None:
    """Set a dotted key; the parts before the last must be there, the last is judged by the scene."""
    *path, last = key.split(".")
    level: Any = data
    for depth, part in enumerate(path):
        if isinstance(level, list) and part.isdigit() and int(part) < len(level):
            level = level[int(part)]
        elif isinstance(level, dict) and part in level:
            level = level[part]
        else:
            known = (
                ", ".join(level)
                if isinstance(level, dict)
                else f"numbers up to {len(level) - 1}"
                if isinstance(level, list)
                else "none"
            )
            why = neglected(part) or f" known there: {known}"
            raise InputError(f"{key}: the scene has no {'.'.join(path[: depth + 1])};{why}")
    if isinstance(level, list) and last.isdigit() and int(last) < len(level):
        level[int(last)] = value
    elif isinstance(level, dict):
        level[last] = value
        if last == "file":  # the rows that are there are those of another file
            for rows in ("rows", "points"):
                level.pop(rows, None)
    else:
        raise InputError(f"{key}: {'.'.join(path)} is no table of keys")


def _scene(data: dict[str, Any]) -> Scene:
    try:
        return Scene.model_validate_json(json.dumps(data), strict=True)
    except ValidationError as faults:
        raise InputError(refusal(faults, data, Scene)) from faults


def _settings(preset: str, mesh: dict[str, Any], solver: dict[str, Any]) -> tuple[MeshSettings, SolverSettings]:
    from dataclasses import replace

    from halfplane_fe import SolverSettings
    from meshes import MeshSettings

    start = {"default": MeshSettings, "coarse": MeshSettings.coarse, "fine": MeshSettings.fine}[preset]()
    made: list[Any] = []
    for name, base, given in (("mesh", start, mesh), ("solver", SolverSettings(), solver)):
        if unknown := sorted(set(given) - set(asdict(base))):
            raise InputError(f"{name}.{unknown[0]}: there is no such setting; known: {', '.join(asdict(base))}")
        for key, value in given.items():
            wanted = type(getattr(base, key))
            if not (type(value) is wanted or (wanted is float and type(value) is int)):
                raise InputError(f"{name}.{key} = {value!r} is refused: it is {_KINDS[wanted]}")
        made.append(replace(base, **given))
    return made[0], made[1]


def _address(study: Study, scene: Scene, mesh: MeshSettings, solver: SolverSettings) -> str:
    # Points that differ in words alone have one result.
    question = {key: value for key, value in scene.model_dump(mode="json").items() if key not in WORDS}
    content: dict[str, Any] = {
        "scene": question,
        "engines": sorted(study.engines),
        "figures": sorted(study.figures),
        "versions": code_versions(),
    }
    if "fe" in study.engines:
        content |= {
            "mesh": asdict(mesh),
            "solver": asdict(solver),
            "uncertainty": study.uncertainty,
            "share_condensations": study.share_condensations,
        }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
