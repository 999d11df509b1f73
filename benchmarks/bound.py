"""Does the uncertainty that `halfplane advise` states of its change of the dissipation hold, on
random bodies, and how wide is it?

    python benchmarks/bound.py [COUNT] [SEED]     (60 cases: ten minutes)

Drawn are flat bodies of like materials, one kind after the other: blocks, layers, T-shapes,
unequal pairs; shouldered pads, whose faces are curved and which are refused. The least height is 3
to 20 half-widths. Each meets one of the load cycles in turn: the paper's, Cattaneo and Mindlin's
and an ellipse at 40 degrees.

Truth is finite elements on two meshes. What advice leaves, |finite elements/theory - 1 - change|,
must not exceed the stated uncertainty plus the difference of the two meshes. Where advice says that
it gives a size alone (uncertainty above 1 %, tilt and bulk strain above 5 %) it is not held to
that, and counts as declined.

Constants of `reports.advising_by_numbers` were fixed on seeds 49 to 51. benchmarks/bound.json has
the cases of another seed, drawn after that, as many as were solved: docs/maps.md shows them. Exit
code 1 where less than 95 % of those not declined are covered, or more than a third is declined.

Solved cases are stored in .cache/bound by scene and mesh, so that the form of the bound can be
changed without solving them again; delete the folder after a change of the finite elements.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import halfplane_fe
import semi_analytic
from meshes import MeshSettings
from reports.advising_by_numbers import advise_by_numbers
from scenes import ConvergenceError, InputError, Scene

ROOT = Path(__file__).parents[1]
STORE = ROOT / "benchmarks" / "bound.json"
SOLVED = ROOT / ".cache" / "bound"
COUNT = 26
SEED = 51
COVERED = 0.95
"""Share of the cases that the uncertainty must cover."""
MOST_DECLINED = 1 / 3
"""Share that may be declined."""

# Bases far from the contact have small elements too: they are what the bodies add.
FINE = MeshSettings(element_size=1 / 16, edge_element_size=1 / 80, growth=0.1)
COARSE = MeshSettings(element_size=1 / 10, edge_element_size=1 / 40, growth=0.15)
# Half-width 1 mm at the mean load: P0 = pi E* a^2/(4 R), steel on steel, R = 1 m.
RADIUS = 1000.0
MEAN_LOAD = 90.62286500739786
STEEL = {"young_modulus": 210e3, "poisson_ratio": 0.3}
HALF_PLANE = {"kind": "half_plane"}


class Case(NamedTuple):
    """One drawn scene.

    Attributes
    ----------
    bodies, load
        what was drawn, in words
    height
        least height of a body over the half-width at the mean load
    """

    scene: Scene
    bodies: str
    load: str
    height: float


# ------------------------------------------------------------------------------------ what is drawn
def block(random: np.random.Generator, height: float) -> dict[str, Any]:
    """A block 0.7 to 3 times as wide as high, and at least 4 half-widths wide."""
    width = max(height * float(np.exp(random.uniform(np.log(0.7), np.log(3)))), 4.0)
    return {"kind": "block", "width": width, "height": height}


def layer(random: np.random.Generator, height: float) -> dict[str, Any]:
    """A layer: fixed and ten times as wide as high, or between walls on rollers."""
    if random.random() < 0.5:
        return {"kind": "block", "width": 10 * height, "height": height}
    width = max(height * float(random.uniform(2, 4)), 8.0)
    walls = {"base": "rollers", "sides": "guided"}
    return {"kind": "block", "width": width, "height": height, **walls}


def t_shape(random: np.random.Generator, height: float) -> dict[str, Any]:
    """A T-shape with a flange of this height."""
    width = height * float(random.uniform(2, 4))
    return {
        "kind": "t_shape",
        "width": width,
        "flange_height": height,
        "stem_width": width * float(random.uniform(0.4, 0.8)),
        "height": height * float(random.uniform(1.5, 3)),
    }


def shouldered_pad(random: np.random.Generator, height: float) -> dict[str, Any]:
    """A pad on a shoulder."""
    width = height * float(random.uniform(1, 2))
    return {
        "kind": "shouldered_pad",
        "width": width,
        "shoulder_depth": height,
        "shoulder_width": 1.5 * width,
        "height": 1.5 * height,
    }


SHAPES = {"block": block, "layer": layer, "t_shape": t_shape, "shouldered_pad": shouldered_pad}
KINDS = (
    ("block", "half_plane"),
    ("block", "equal"),
    ("layer", "half_plane"),
    ("t_shape", "half_plane"),
    ("block", "block"),
    ("layer", "equal"),
    ("t_shape", "block"),
    ("block", "half_plane"),
    ("block", "equal"),
    ("layer", "half_plane"),
    ("t_shape", "equal"),
    ("block", "t_shape"),
    ("half_plane", "shouldered_pad"),
)
"""Lower and upper body; equal: the upper one is the lower one's mirror image."""


def load_of(name: str, friction: float) -> dict[str, Any]:
    """The table of a load cycle of the mean load."""
    ellipse = {
        "kind": "ellipse",
        "mean_normal_load": MEAN_LOAD,
        "normal_amplitude": MEAN_LOAD / 3,
        "mean_tangential_load": 0.0,
        "initial_loading": "straight",
    }
    if name == "paper":
        return ellipse | {
            "mean_tangential_load": 1.1 * MEAN_LOAD / 3,
            "tangential_amplitude": MEAN_LOAD / 3,
            "phase_degrees": 90.0,
            "initial_loading": "parabola",
        }
    if name == "ellipse":
        amplitude = 0.5 * friction * MEAN_LOAD
        return ellipse | {"tangential_amplitude": amplitude, "phase_degrees": 40.0}
    force = float(name.split()[1]) * friction * MEAN_LOAD
    return {
        "kind": "polygon",
        "initial_loading": [[MEAN_LOAD, 0.0]],
        "cycle": [[MEAN_LOAD, force], [MEAN_LOAD, -force]],
    }


LOADS = (
    ("paper", 1.0),
    ("Cattaneo 0.6", 0.8),
    ("ellipse", 0.3),
    ("Cattaneo 0.9", 0.3),
    ("ellipse", 0.8),
    ("Cattaneo 0.3", 0.8),
)
"""Load cycles and their coefficients of friction."""


def drawn(count: int, seed: int) -> Iterator[Case]:
    """So many cases of a seed."""
    random = np.random.default_rng(seed)
    order = random.permutation(len(LOADS))
    for number in range(count):
        lower_kind, upper_kind = KINDS[number % len(KINDS)]
        load_name, friction = LOADS[order[number % len(LOADS)]]
        shapes: dict[str, dict[str, Any]] = {}
        heights = []
        for side, kind in (("lower", lower_kind), ("upper", upper_kind)):
            if kind in SHAPES:
                height = float(np.exp(random.uniform(np.log(3), np.log(20))))
                heights.append(height)
                shapes[side] = SHAPES[kind](random, height)
        lower = shapes.get("lower", HALF_PLANE)
        upper = lower if upper_kind == "equal" else shapes.get("upper", HALF_PLANE)
        scene = Scene.model_validate(
            {
                "title": f"case {number} of seed {seed}",
                "material": STEEL,
                "profile": {"kind": "hertz", "radius": RADIUS},
                "friction": {"coefficient": friction},
                "bodies": {"lower": lower, "upper": upper},
                "load": load_of(load_name, friction),
            }
        )
        words = f"{lower_kind}, {upper_kind}".replace("_", " ")
        yield Case(scene, words, f"{load_name}, f = {friction:g}", min(heights))


# ------------------------------------------------------------------------------------ what is known
def dissipation(scene: Scene, mesh: MeshSettings) -> float:
    """By finite elements; read where it was solved before."""
    address = hashlib.sha256(f"{scene.model_dump_json()} {mesh}".encode()).hexdigest()[:16]
    path = SOLVED / f"{address}.json"
    if path.is_file():
        return float(json.loads(path.read_text("utf-8")))
    work = float(halfplane_fe.solve(scene, mesh).dissipation)
    SOLVED.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(work), "utf-8")
    return work


def judged(case: Case) -> dict[str, Any]:
    """Change of the dissipation by finite elements and by advice, and what is left."""
    row: dict[str, Any] = {
        "bodies": case.bodies,
        "load": case.load,
        "height": case.height,
    }
    try:
        advice = advise_by_numbers(case.scene)
    except InputError as refusal:
        return row | {"refused": str(refusal)}
    theory = semi_analytic.solve(case.scene, fields=("dissipation",)).dissipation
    try:
        fine = dissipation(case.scene, FINE) / theory - 1
        coarse = dissipation(case.scene, COARSE) / theory - 1
    except ConvergenceError as failure:
        return row | {"refused": f"finite elements: {failure}"}
    left = fine - advice.work.value
    mesh = abs(fine - coarse)
    return row | {
        "finite_elements": fine,
        "mesh": mesh,
        "advised": advice.work.value,
        "bound": advice.work.uncertainty,
        "declined": advice.reason_for_size_alone,
        "left": left,
        "covered": bool(abs(left) <= advice.work.uncertainty + mesh),
    }


def summary(rows: list[dict[str, Any]]) -> dict[str, float]:
    """Share covered, medians of what is left and of the bound over it, of the cases that were not
    declined; shares declined, and refused because faces are curved.
    """
    held = [row for row in rows if "left" in row and not row["declined"]]
    left = np.array([abs(row["left"]) for row in held])
    bound = np.array([row["bound"] for row in held])
    return {
        "cases": len(rows),
        "covered": sum(row["covered"] for row in held) / len(held),
        "left": float(np.median(left)),
        "most_left": float(np.max(left)),
        "bound_over_left": float(np.median(bound / left)),
        "declined": sum(bool(row.get("declined")) for row in rows) / len(rows),
        "refused": sum("refused" in row for row in rows) / len(rows),
    }


def write(seed: int, rows: list[dict[str, Any]]) -> None:
    """The cases that were solved so far, with their totals."""
    if any("left" in row and not row["declined"] for row in rows):
        content = {"seed": seed, **summary(rows), "rows": rows}
        STORE.write_text(json.dumps(content, indent=1) + "\n", "utf-8")


def main(arguments: list[str]) -> int:
    count = int(arguments[0]) if arguments else COUNT
    seed = int(arguments[1]) if len(arguments) > 1 else SEED
    print(f"seed {seed}")
    rows = []
    for case in drawn(count, seed):
        row = judged(case)
        rows.append(row)
        if seed != SEED:
            write(seed, rows)
        words = f"{row['bodies']:28s} {row['height']:5.1f} a  {row['load']:22s}"
        if "refused" in row:
            print(words, row["refused"][:80], flush=True)
            continue
        shares = [row[name] for name in ("finite_elements", "mesh", "advised", "left", "bound")]
        numbers = " ".join(f"{100 * share:9.3f}" for share in shares)
        verdict = "declined" if row["declined"] else "" if row["covered"] else "NOT COVERED"
        print(words, numbers, verdict, flush=True)
    totals = summary(rows)
    print(json.dumps(totals, indent=1))
    return int(totals["covered"] < COVERED or totals["declined"] > MOST_DECLINED)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
