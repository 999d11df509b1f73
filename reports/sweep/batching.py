"""Points of half-plane theory that one call serves: the dissipation of ellipses."""

from __future__ import annotations

import json
import math
import platform
import time
from collections.abc import Mapping
from typing import Any

from reports.sweep.evaluating import Asked
from scenes import EllipseLoad, Scene


def in_one_call(asked: Asked, jobs: list[dict[str, Any]]) -> dict[int, dict[str, Any]]:
    """Number -> answer of the points that ask theory for the dissipation of an ellipse alone, in one call for all of one
    profile and material;
    points that the batch has no value for are left to `solve`, which says why.
    """
    if asked.engines != ("exact",) or asked.figures != ("exact.dissipation",):
        return {}
    begun = time.perf_counter()
    scenes = {number: Scene.model_validate_json(json.dumps(job["scene"])) for number, job in enumerate(jobs)}
    kinds: dict[str, list[int]] = {}
    for number, scene in scenes.items():
        if isinstance(scene.load, EllipseLoad) and scene.friction.coefficient > 0:
            kinds.setdefault(scene.profile.model_dump_json() + scene.material.model_dump_json(), []).append(number)
    found = {number: value for numbers in kinds.values() for number, value in _works({n: scenes[n] for n in numbers}).items()}
    seconds = (time.perf_counter() - begun) / max(1, len(found))
    return {
        number: {"address": jobs[number]["address"], "status": "done", "reason": "", "seconds": seconds, "host": platform.node()}
        | {"figures": {"exact.dissipation": value}, "notes": {}, "record": {"message": "a member of a batch", "notes": notes}}
        for number, (value, notes) in found.items()
    }


def _works(scenes: Mapping[int, Scene]) -> dict[int, tuple[float, tuple[str, ...]]]:
    """Dissipation of ellipses on one profile and material, where the batch has a value, with the notes of the batch."""
    import semi_analytic

    first, loads = next(iter(scenes.values())), [scene.load for scene in scenes.values() if isinstance(scene.load, EllipseLoad)]
    batch = semi_analytic.dissipation(
        profile=first.profile,
        material=first.material,
        friction_coefficient=[scene.friction.coefficient for scene in scenes.values()],
        mean_normal_load=[load.mean_normal_load for load in loads],
        normal_amplitude=[load.normal_amplitude for load in loads],
        mean_tangential_load=[load.mean_tangential_load for load in loads],
        tangential_amplitude=[load.tangential_amplitude for load in loads],
        phase=[load.phase for load in loads],
    )
    values = zip(scenes, batch.value, strict=True)
    return {number: (float(value), batch.notes) for number, value in values if math.isfinite(value)}
