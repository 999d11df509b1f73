"""Synthetic profilometer traces through a scene's `fit`: is W within what is stated?

    python benchmarks/measured_profiles.py TRACES [SEED]     (the seed is drawn, and printed)

Each draw takes a shape, a fit that can describe it, rows, ends that differ, a tilt of up to 5 mrad,
noise of 1 to 100 nm, spikes, and units in words at random, and writes the file that an instrument
would write. W is that of an ellipse of loads under which the contact is 1 mm wide on each side.

# notation: b half-length of a flat, h height, R radius, W dissipation, x place
"""

from __future__ import annotations

import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.profile_fit import fit_uncertainty
from scenes import FlatRounded, Hertz, InputError, Scene, load_scene
from semi_analytic.profiles import contact_of

Array = NDArray[np.float64]

SEEDS = 2**32
FITS = (
    ("hertz", "hertz"),
    ("flat_rounded", "flat_rounded"),
    ("hertz", "even_polynomial"),
    ("hertz", "smoothing_spline"),
)
HALF_WIDTH = 1.0  # mm, of the largest contact
# Ends of the trace, mm from the middle; the shorter one is beyond the contact.
ENDS = (1.2, 2.2)
LARGEST_TILT = 5e-3
LEAST_NOISE = 1e-6  # mm
MOST_NOISE = 100e-6
# Of the rows; times the noise.
MOST_SPIKES = 0.02
SPIKES = (8.0, 200.0)
LENGTHS = {"mm": 1.0, "Millimeter": 1.0, "millimètres": 1.0, "microns": 1e-3, "µm": 1e-3}
HEIGHTS = {"nm": 1e-6, "Nanometer": 1e-6, "nanometri": 1e-6, "microns": 1e-3, "mm": 1.0}
HEADINGS = (("x", "h"), ("Position", "Profile height"), ("Abstand", "Höhe"), ("X", "hauteur"))
# Of W: what the fit of an exact trace leaves.
EXACT = 1e-5


@dataclass(frozen=True)
class Outcome:
    """One trace: what it was, W over its true value − 1, what is stated of it, or the refusal."""

    words: str
    kind: str
    has_spikes: bool
    error: float = 0.0
    stated: float = 0.0
    refusal: str = ""
    seconds: float = 0.0

    @property
    def covered(self) -> bool:
        """Whether W lies within what is stated."""
        return abs(self.error) <= self.stated + EXACT


def trace_of(random: np.random.Generator, number: int, folder: Path) -> tuple[Scene, str, str, str]:
    """The true scene; writes the file trace.csv; the key `fit` of the scene, words for the draw,
    and the kinds of shape and fit.
    """
    shape, kind = FITS[number % len(FITS)]
    radius = float(random.uniform(500, 2000))
    truth: Hertz | FlatRounded = Hertz(radius=radius)
    if shape == "flat_rounded":
        truth = FlatRounded(radius=radius / 3, flat_half_length=float(random.uniform(0.2, 0.7)))
    rows = int(np.exp(random.uniform(np.log(61), np.log(1001.5))))
    noise = float(np.exp(random.uniform(np.log(LEAST_NOISE), np.log(MOST_NOISE))))
    tilt = float(random.uniform(-LARGEST_TILT, LARGEST_TILT))
    ends = random.uniform(*ENDS, 2)
    middle = float(random.uniform(-0.3, 0.3))
    x = middle + np.linspace(-ends[0], ends[1], rows)
    x += (x[1] - x[0]) * random.uniform(-0.4, 0.4, rows)
    h = np.asarray(truth.height(x - middle)) + tilt * x + random.uniform(-1e-3, 1e-3)
    h += noise * random.standard_normal(rows)
    n_spikes = int(random.integers(0, round(MOST_SPIKES * rows) + 1)) if number % 8 >= 4 else 0
    places = random.choice(rows, n_spikes, replace=False)
    signs = random.choice([-1.0, 1.0], n_spikes)
    h[places] += noise * signs * random.uniform(*SPIKES, n_spikes)

    length = str(random.choice(list(LENGTHS)))
    height = str(random.choice(list(HEIGHTS)))
    heads = HEADINGS[int(random.integers(len(HEADINGS)))]
    lines = [f"{heads[0]} ({length});{heads[1]} ({height})"]
    for place, gap in zip(
        (x / LENGTHS[length]).tolist(), (h / HEIGHTS[height]).tolist(), strict=True
    ):
        lines.append(f"{place:.9g};{gap:.9g}")
    (folder / "trace.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")

    base = load_scene("hertz-paper")
    share = float(random.uniform(0.0, 0.6))
    mean = float(contact_of(truth, base.material).load(HALF_WIDTH)) / (1 + share)
    largest = base.friction.coefficient * mean * (1 - share)
    load = {
        "mean_normal_load": mean,
        "normal_amplitude": share * mean,
        "mean_tangential_load": 0.0,
        "tangential_amplitude": float(random.uniform(0.2, 0.9)) * largest,
        "phase_degrees": float(random.uniform(30, 150)),
        "initial_loading": "straight",
    }
    stated = f", noise = {noise!r}" if random.random() < 0.5 else ""
    words = (
        f"{shape} by {kind}, {rows} rows from {-ends[0]:.2f} to {ends[1]:.2f} mm, tilt"
        f" {1e3 * tilt:+.2f} mrad, noise {1e6 * noise:.3g} nm{' (stated)' if stated else ''},"
        f" {n_spikes} spikes, {length}, {height}"
    )
    return (
        base.vary(load=load, profile=truth),
        f'{{kind = "{kind}"{stated}}}',
        words,
        f"{shape} by {kind}",
    )


def outcome_of(seed: int, number: int, folder: Path) -> Outcome:
    """What is answered to one trace."""
    random = np.random.default_rng([seed, number])
    true, fit, words, kind = trace_of(random, number, folder)
    load = "\n".join(
        f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value!r}"
        for key, value in true.load.model_dump(include=set(LOAD_KEYS)).items()
    )
    material = true.material.lower
    text = (
        f"[material]\nyoung_modulus = {material.young_modulus!r}\n"
        f'poisson_ratio = {material.poisson_ratio!r}\n[profile]\nkind = "tabulated"\n'
        f'file = "trace.csv"\nfit = {fit}\n[friction]\n'
        f'coefficient = {true.friction.coefficient!r}\n[load]\nkind = "ellipse"\n{load}\n'
    )
    (folder / "trace.toml").write_text(text, encoding="utf-8")
    begin = time.process_time()
    has_spikes = ", 0 spikes" not in words
    try:
        stated = fit_uncertainty(load_scene(folder / "trace.toml")).dissipation
    except InputError as fault:
        return Outcome(words, kind, has_spikes, refusal=str(fault).replace(str(folder), ""))
    assert stated is not None
    truth = semi_analytic.solve(true, x=[0.0], fields=("dissipation",)).dissipation
    return Outcome(
        words,
        kind,
        has_spikes,
        error=stated.value / truth - 1,
        stated=stated.uncertainty / truth,
        seconds=time.process_time() - begin,
    )


LOAD_KEYS = (
    "mean_normal_load",
    "normal_amplitude",
    "mean_tangential_load",
    "tangential_amplitude",
    "phase_degrees",
    "initial_loading",
)


def report(outcomes: list[Outcome]) -> None:
    """The table of all."""
    groups: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        groups.setdefault(outcome.kind, []).append(outcome)
    groups["with spikes"] = [o for o in outcomes if o.has_spikes]
    groups["all"] = outcomes
    print(f"\n{'':30}   n refused answered  W covered %  |error| %  stated %  seconds  (medians)")
    for name, group in groups.items():
        answered = [o for o in group if not o.refusal]
        if not answered:
            print(f"{name:30}{len(group):4}{len(group):8}")
            continue
        covered = 100 * np.mean([o.covered for o in answered])
        error = 100 * np.median([abs(o.error) for o in answered])
        stated = 100 * np.median([o.stated for o in answered])
        seconds = np.median([o.seconds for o in answered])
        print(
            f"{name:30}{len(group):4}{len(group) - len(answered):8}{len(answered):9}"
            f"{covered:13.1f}{error:11.2g}{stated:10.2g}{seconds:9.2f}"
        )


def main() -> None:
    """Draw, fit, print."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else int(np.random.default_rng().integers(SEEDS))
    print(f"{count} traces, seed {seed}")
    outcomes = []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            outcome = outcome_of(seed, number, Path(folder))
            answer = outcome.refusal or (
                f"W {100 * outcome.error:+.3g} % ± {100 * outcome.stated:.2g} %"
                f"{'' if outcome.covered else '  OUTSIDE'}"
            )
            print(f"{number:4} {outcome.words}\n     {answer}", flush=True)
            outcomes.append(outcome)
    report(outcomes)


if __name__ == "__main__":
    main()
