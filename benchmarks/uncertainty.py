"""Whether the uncertainty that finite elements state for their dissipation covers its error, on random scenes.

    python benchmarks/uncertainty.py [SEED] [COUNT] [FILE] [MINUTES]

Half of the COUNT scenes are half-planes, whose true dissipation is that of theory; half are blocks, against a mesh of a/320 with
a tenth of the step tolerance, whose error is a sixth of that of the default mesh. None is taken out; scenes that are refused, and
those that hardly slip (W below 1e-4 A f^2 P^2, P the largest load), are counted apart.

Rows go to FILE, one a line. A second call with the same FILE goes on after them; it stops after MINUTES at the next scene.
"""

from __future__ import annotations

import json
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from scenes import ConvergenceError, InputError, Scene, load_scene

KINDS = ("hertz", "flat_rounded", "power_law", "compound", "polynomial")
MEAN = 90.0
LITTLE = 1e-4


def profile(kind: str, draw: np.random.Generator) -> dict[str, Any]:
    """Parameters of a profile [mm], such that contacts are about a millimetre wide."""
    match kind:
        case "flat_rounded":
            own: dict[str, Any] = {"radius": 1000.0, "flat_half_length": draw.uniform(0.2, 2.8)}
        case "power_law":
            own = {"exponent": draw.uniform(1.6, 5), "length": 1.0, "rise": 5e-4}
        case "compound":
            own = {"inner_radius": 1000.0, "outer_radius": draw.uniform(300, 3000), "inner_half_length": draw.uniform(0.3, 1.0)}
        case "polynomial":
            own = {"length": 1.0, "rises": [5e-4, draw.uniform(1e-4, 1e-3)]}
        case _:
            own = {"radius": 1000.0}
    return {"kind": kind, **own}


def scene(number: int, draw: np.random.Generator, real: bool) -> Scene:
    """An ellipse that stays away from gross sliding by a share of 1e-3 to 0.9 of f P; f from 0.05 to 1.5."""
    kind = KINDS[number % len(KINDS)]
    f, swing, phase = np.exp(draw.uniform(np.log(0.05), np.log(1.5))), draw.uniform(0, 0.95), draw.uniform(0, 180)
    offset = draw.random()
    away = np.exp(draw.uniform(np.log(1e-3), np.log(0.9)))
    angle = np.linspace(0, 2 * np.pi, 4001)
    wave = offset + (1 - offset) * np.cos(angle - np.radians(phase))
    most = (1 - away) / np.max(np.abs(wave) / (f * MEAN * (1 + swing * np.cos(angle))))
    block = {"kind": "block", "width": draw.uniform(8, 30), "height": draw.uniform(4, 30)}
    made = {
        "name": f"random-{number}",
        "material": load_scene("hertz-paper").model_dump(mode="json")["material"],
        "profile": profile(kind, draw),
        "friction": {"coefficient": float(f)},
        "load": {
            "kind": "ellipse",
            "mean_normal_load": MEAN,
            "normal_amplitude": MEAN * swing,
            "mean_tangential_load": most * offset,
            "tangential_amplitude": most * (1 - offset),
            "phase_degrees": phase,
        },
    }
    return Scene.model_validate(made | ({"bodies": {"lower": block, "upper": block}} if real else {}))


def solved(one: Scene, real: bool) -> dict[str, Any]:
    """W over A f^2 P^2, error and stated uncertainty over W, CPU seconds of the answer; or why there is none."""
    begun = time.process_time()
    try:
        found = halfplane_fe.solve(one)
        took = time.process_time() - begun
        if real:
            finer, tight = MeshSettings(edge_element_size=1 / 320), SolverSettings(step_tolerance=5e-5)
            true = halfplane_fe.solve(one, finer, tight, scales=found.scales).dissipation
        else:
            true = semi_analytic.solve(one, x=[0.0], fields=("dissipation",)).dissipation
    except (InputError, ConvergenceError) as reason:
        return {"refused": str(reason)}
    unit = 2 / found.scales.modulus * (one.friction.coefficient * found.scales.load) ** 2
    each = max(true, 1e-300)
    return {
        "work": true / unit,
        "error": (found.dissipation - true) / each,
        "stated": found.dissipation_uncertainty / each,
        "seconds": took,
    }


def main(seed: int = 2, count: int = 60, file: str = "", minutes: float = float("inf")) -> None:
    """One line a scene, then the counts."""
    draw, ratios, outcome, begun = np.random.default_rng(seed), [], Counter[str](), time.monotonic()
    rows: dict[str, dict[str, Any]] = {}
    if file and Path(file).exists():
        rows = {row["scene"]: row for row in map(json.loads, Path(file).read_text(encoding="utf-8").splitlines())}
    print(f"seed {seed}, {count} scenes")
    for number in range(count):
        real = number >= count // 2
        one = scene(number, draw, real)
        name = f"{seed}/{count}/{number}"
        if name not in rows:
            if time.monotonic() - begun > 60 * minutes:
                outcome["left"] += 1
                continue
            rows[name] = {"scene": name, **solved(one, real)}
            if file:
                with Path(file).open("a", encoding="utf-8") as stream:
                    stream.write(json.dumps(rows[name]) + "\n")
        row, head = rows[name], f"{number:3d} {one.profile.kind:13s} {'blocks' if real else 'half-planes':11s}"
        if "refused" in row:
            outcome["refused or not converged"] += 1
            print(f"{head} {row['refused']}", flush=True)
            continue
        little = row["work"] < LITTLE
        outcome["hardly slips: " * little + ("covered" if abs(row["error"]) <= row["stated"] else "not covered")] += 1
        if not little:
            ratios.append(row["stated"] / max(abs(row["error"]), 1e-300))
        words = f"W {row['work']:.1e} of A f^2 P^2, error {row['error']:+.1e}, stated {row['stated']:.1e}, {row['seconds']:.1f} s"
        print(f"{head} {words}", flush=True)
    print(dict(outcome), f"stated over true error, median {np.median(ratios) if ratios else np.nan:.3g}")


if __name__ == "__main__":
    given = zip((int, int, str, float), sys.argv[1:], strict=False)
    main(*(kind(word) for kind, word in given))  # type: ignore[arg-type]
