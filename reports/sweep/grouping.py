"""Points that can share their condensed bodies, and the tasks they are handed out in."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass

from reports.sweep.points import Point
from reports.sweep.study import Study

# Half-plane theory alone takes some milliseconds a point: that many at once make the cost of handing them out small.
_EXACT_AT_ONCE = 50
_FE_AT_ONCE = 4


@dataclass(frozen=True)
class Plan:
    """What a sweep is going to do.

    Attributes
    ----------
    points : all of them
    groups : each of points that share their condensed bodies
    condensations : how many bodies are condensed on the meshes that answers come from, coarser ones of an uncertainty left out;
        where nothing is shared at most so many
    """

    points: tuple[Point, ...]
    groups: tuple[tuple[Point, ...], ...]
    condensations: int


def plan(study: Study, points: tuple[Point, ...]) -> Plan:
    """The points in groups that share their condensed bodies."""
    if "fe" not in study.engines:
        return Plan(points, (points,), 0)
    groups: dict[str, list[Point]] = defaultdict(list)
    for point in points:
        groups[_key(point)].append(point)
    found = tuple(tuple(group) for group in groups.values())
    bodies = [1 if _alike(group[0]) else 2 for group in found]
    if not study.share_condensations:
        bodies = [count * len(group) for count, group in zip(bodies, found, strict=True)]
    return Plan(points, found, sum(bodies))


def tasks(study: Study, groups: Iterable[Sequence[Point]], workers: int) -> list[list[Point]]:
    """Parts of groups small enough that all workers have some to do until the end."""
    groups = list(groups)
    at_once = _EXACT_AT_ONCE if "fe" not in study.engines else _FE_AT_ONCE
    total = sum(len(group) for group in groups)
    size = max(1, min(at_once, -(-total // (4 * workers))))
    return [list(group[k : k + size]) for group in groups for k in range(0, len(group), size)]


def _key(point: Point) -> str:
    """Everything that a condensed body, cut for all of a group, depends on."""
    from halfplane_fe.scales import largest_load

    scene = point.scene
    parts = {name: getattr(scene, name).model_dump(mode="json") for name in ("bodies", "material", "profile")}
    return json.dumps(parts | {"mesh": asdict(point.mesh), "load": largest_load(scene)}, sort_keys=True)


def _alike(point: Point) -> bool:
    scene = point.scene
    return scene.material.alike and scene.bodies.lower == scene.bodies.upper and point.mesh.upper_ratio == 1
