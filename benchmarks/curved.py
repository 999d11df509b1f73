"""Does the uncertainty hold that `halfplane advise` states of bodies with curved faces, on random
ones?

    python benchmarks/curved.py [COUNT] [SEED]     (24 cases: five minutes)

Drawn are round pads, cylinders and flat pads with rounded edges, on half-planes and blocks of the
same or another material. The radius is 6 to 40 half-widths, the flat .15 to .85 of the half-width.
Each meets one of the load cycles of `bound` in turn.

Truth is finite elements of the bodies on a mesh that is finer than that of `advise`. What the
kernel solve leaves of the dissipation, the largest pressure and half-width must not exceed what is
stated, plus what the finite elements state. Constants of `reports.advising_by_kernels` were fixed
on seed 401. benchmarks/curved.json has the totals of another seed, drawn after that: docs/maps.md
shows them. Exit code 1 where less than 95 % of the values are covered.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from bound import LOADS, MEAN_LOAD, STEEL, load_of

import halfplane_fe
from meshes import MeshSettings
from reports.advising_by_kernels import advise_by_kernels, changes_of
from scenes import ConvergenceError, InputError, Scene
from semi_analytic.profiles import contact_of

STORE = Path(__file__).with_name("curved.json")
COUNT = 24
SEED = 401
COVERED = 0.95
"""Share of the values that the uncertainty must cover."""
FINE = MeshSettings(element_size=1 / 32, edge_element_size=1 / 160, growth=0.1)
QUANTITIES = ("dissipation", "peak_pressure", "half_width")
KINDS = ("pad", "cylinder", "flat_pad")
OTHER = {"young_modulus": 70e3, "poisson_ratio": 0.33}


def drawn(count: int, seed: int) -> Iterator[tuple[str, Scene]]:
    """So many scenes of a seed, in words."""
    random = np.random.default_rng(seed)
    for number in range(count):
        kind = KINDS[number % len(KINDS)]
        load_name, friction = LOADS[number // len(KINDS) % len(LOADS)]
        radius = float(np.exp(random.uniform(np.log(6), np.log(40))))
        flat = float(random.uniform(0.15, 0.85))
        profile: dict[str, Any] = {"kind": "hertz", "radius": radius}
        size = {"width": float(random.uniform(1, 2)) * radius, "height": radius}
        upper: dict[str, Any] = {"kind": "pad", **size}
        if kind == "cylinder":
            upper = {"kind": "cylinder", "radius": radius}
        elif kind == "flat_pad":
            profile |= {"kind": "flat_rounded", "flat_half_length": flat}
            upper["width"] += 2 * flat
        lower: dict[str, Any] = {"kind": "half_plane"}
        if random.random() < 0.5:
            # wider than the upper body
            width = 2 * radius * float(random.uniform(1.2, 2)) + 2 * flat
            lower = {"kind": "block", "width": width, "height": width / 2}
        lower_material = OTHER if random.random() < 0.25 else STEEL
        scene = Scene.model_validate(
            {
                "title": f"case {number} of seed {seed}",
                "material": {"lower": lower_material, "upper": STEEL},
                "profile": profile,
                "friction": {"coefficient": friction},
                "bodies": {"lower": lower, "upper": upper},
                "load": load_of(load_name, friction),
            }
        )
        # a = 1 at the mean load
        heavier = float(contact_of(scene.profile, scene.material).load(1.0)) / MEAN_LOAD
        load = times(load_of(load_name, friction), heavier)
        words = f"{kind} on {lower['kind']}, R = {radius:.1f} a"
        if kind == "flat_pad":
            words += f", b = {flat:.2f} a"
        yield f"{words}, {load_name}, f = {friction:g}", scene.vary(load=load)


def times(load: dict[str, Any], factor: float) -> dict[str, Any]:
    """The table of a load cycle with all loads so many times as large."""
    heavier = dict(load)
    for name, value in load.items():
        if name.endswith("_load") or name.endswith("_amplitude"):
            heavier[name] = factor * value
        elif name in ("initial_loading", "cycle") and not isinstance(value, str):
            heavier[name] = [[factor * force for force in corner] for corner in value]
    return heavier


class Judged(NamedTuple):
    """A value of a case: error of theory by finite elements, what these and `advise` state to be
    uncertain by, and what is left between the two; shares of theory's value.
    """

    quantity: str
    truth: float
    of_elements: float
    stated: float
    left: float

    @property
    def covered(self) -> bool:
        """Whether what is left is within what is stated."""
        return self.left <= self.stated + self.of_elements


def judged(scene: Scene) -> list[Judged]:
    """The values of a case."""
    by_kernels = advise_by_kernels(scene, 0.05, "").changes
    by_elements = changes_of(halfplane_fe.solve(scene, FINE))
    values = []
    for quantity in QUANTITIES:
        change, stated = by_kernels[quantity].relative_change
        truth, of_elements = by_elements[quantity].relative_change
        values.append(Judged(quantity, truth, of_elements, stated, abs(truth - change)))
    return values


def write(seed: int, values: list[Judged]) -> None:
    """The totals: how many values are covered, and the largest rests, to three digits."""
    most_left = dict.fromkeys(QUANTITIES, 0.0)
    for value in values:
        most_left[value.quantity] = max(most_left[value.quantity], value.left)
    totals = {
        "seed": seed,
        "values": len(values),
        "covered": sum(value.covered for value in values) / len(values),
        "most_left": {quantity: float(f"{left:.3g}") for quantity, left in most_left.items()},
    }
    STORE.write_text(json.dumps(totals, indent=1) + "\n", "utf-8")


def main(arguments: list[str]) -> int:
    count = int(arguments[0]) if arguments else COUNT
    seed = int(arguments[1]) if len(arguments) > 1 else SEED
    values: list[Judged] = []
    for words, scene in drawn(count, seed):
        try:
            of_case = judged(scene)
        except (InputError, ConvergenceError) as failure:
            print(words, str(failure)[:100], flush=True)
            continue
        print(words, flush=True)
        for value in of_case:
            shares = " ".join(f"{100 * share:9.4f}" for share in value[1:])
            verdict = "" if value.covered else "  NOT COVERED"
            print(f"    {value.quantity:15s}{shares}{verdict}")
        values += of_case
        if seed != SEED:
            write(seed, values)
    covered = sum(value.covered for value in values) / len(values)
    print(f"seed {seed}: {len(values)} values, {100 * covered:.0f} % covered")
    return int(covered < COVERED)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
