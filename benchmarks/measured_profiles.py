"""Noisy profilometer rows: is W answered, and does it lie within its stated uncertainty?

    python benchmarks/measured_profiles.py [--cases 200] [--seed 1]

Each case draws a true profile (a parabola of radius 500 to 2,000 mm, or a flat of half-length 0.2 to 0.7 mm with rounded edges),
31 to 1,001 uneven rows over 3 mm with the middle up to 0.3 mm off, noise of 1 to 50 nm, an ellipse of loads whose largest
contact is a = 1 mm, and a kind of fit that can describe the truth. The stated uncertainty is that of `reports.profile_fit`. Exit
code 1 where a case has no answer or W lies within its uncertainty in less than 95 % of all cases.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from reports.profile_fit import fit_uncertainty
from scenes import FlatRounded, Hertz, InputError, Scene, load_scene
from semi_analytic import dissipation
from semi_analytic.profiles import contact_of

HALF_WIDTH, SPAN = 1.0, 3.0  # mm
SHARE = 0.95
# Of W: what the engine promises of any W, which is all that is uncertain where W does not depend on the fitted numbers.
PROMISED = 1e-9
KINDS = (("hertz", "hertz"), ("hertz", "even_polynomial"), ("hertz", "smoothing_spline"))
KINDS += (("flat_rounded", "flat_rounded"), ("flat_rounded", "smoothing_spline"))


@dataclass(frozen=True)
class Case:
    """A truth, its noisy rows, and the scene with the fit."""

    truth: Hertz | FlatRounded
    kind: str
    rows: int
    noise: float
    scene: Scene


def case(random: np.random.Generator, number: int) -> Case:
    """A random case; InputError where the fit has no answer."""
    shape, kind = KINDS[number % len(KINDS)]
    radius = float(random.uniform(500, 2000))
    truth: Hertz | FlatRounded = Hertz(radius=radius)
    if shape == "flat_rounded":
        truth = FlatRounded(radius=radius / 3, flat_half_length=float(random.uniform(0.2, 0.7)))
    rows, noise = (
        int(np.exp(random.uniform(np.log(31), np.log(1001.5)))),
        float(np.exp(random.uniform(np.log(1e-6), np.log(50e-6)))),
    )
    # Uneven, but never two rows in one place.
    x = np.linspace(-SPAN / 2, SPAN / 2, rows) + SPAN / rows * random.uniform(-0.4, 0.4, rows)
    middle = float(random.uniform(-0.3, 0.3))
    h = truth.height(x - middle) + noise * random.standard_normal(rows) + random.uniform(-1e-3, 1e-3)
    base = load_scene("hertz-paper")
    most = float(contact_of(truth, base.material).load(HALF_WIDTH))
    share = float(random.uniform(0.0, 0.6))
    mean = most / (1 + share)
    friction = base.friction.coefficient
    load = {"mean_normal_load": mean, "normal_amplitude": share * mean, "mean_tangential_load": 0.0}
    load |= {"tangential_amplitude": float(random.uniform(0.2, 0.9)) * friction * mean * (1 - share)}
    load |= {"phase_degrees": float(random.uniform(30, 150))}
    rows_and_fit = {"kind": "tabulated", "points": np.column_stack([x, h]), "fit": {"kind": kind, "noise": noise}}
    return Case(truth, kind, rows, noise, base.vary(name=f"case {number}", load=load, profile=rows_and_fit))


def true_dissipation(found: Case) -> float:
    """W of the true profile."""
    load = found.scene.load
    names = ("mean_normal_load", "normal_amplitude", "mean_tangential_load", "tangential_amplitude", "phase")
    friction = found.scene.friction.coefficient
    loads = {name: getattr(load, name) for name in names}
    batch = dissipation(profile=found.truth, material=found.scene.material, friction_coefficient=friction, **loads)
    return float(batch.value)


def main(arguments: list[str]) -> int:
    """Draw, fit, compare, print."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--cases", type=int, default=200)
    options.add_argument("--seed", type=int, default=1)
    given = options.parse_args(arguments)
    random, outcomes, failures = np.random.default_rng(given.seed), defaultdict(list), 0
    for number in range(given.cases):
        label = " fitted by ".join(KINDS[number % len(KINDS)])
        try:
            one = case(random, number)
            found = fit_uncertainty(one.scene)
        except InputError as fault:
            failures += 1
            print(f"case {number}, {label}: {fault}")
            continue
        assert found.dissipation is not None
        truth = true_dissipation(one)
        error = found.dissipation.value / truth - 1
        stated = found.dissipation.uncertainty / truth + PROMISED
        outcomes[label].append((error, stated))
    print(f"seed {given.seed}: {given.cases - failures} of {given.cases} answered")
    covered = []
    for label, rows in outcomes.items():
        error, stated = np.abs(np.array(rows)).T
        covered.append(float(np.mean(error <= stated)))
        rms = np.sqrt(np.mean(error**2))
        print(
            f"{label}: W within its uncertainty in {100 * covered[-1]:.1f} % of {len(rows)}; error rms {100 * rms:.2g} %, "
            f"largest {100 * error.max():.2g} %; stated, median {100 * np.median(stated):.2g} %"
        )
    every = np.abs(np.array([row for rows in outcomes.values() for row in rows]))
    share = float(np.mean(every[:, 0] <= every[:, 1]))
    print(f"all: W within its uncertainty in {100 * share:.1f} %")
    return 1 if failures or share < SHARE else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
