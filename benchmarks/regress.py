"""Half-plane theory at a few instants and places of every scene of P and Q in the library, without
finite elements: the quick part of `make cases`.

Each scene has its dissipation, the largest half-width, stroke and the root-mean-squares of p, q, s
and U over ten instants of the last cycle and nine places, which move with an error of any part of a
field. At one instant that is no event there are U, the stick edge, the shear at three places and
the slip at one; in the scenes `POINTWISE` the work W(x) at three places of the slip zone.

References: dissipation in `[[expected]]` of the scene; of the others those of `regress_truth`,
which shares no code with the engine. They have 30 digits or come from brute force.
"""

from __future__ import annotations

import math
from typing import Any

import case_table
import mpmath as mp
import numpy as np
from case_table import THEORY, Sheet
from regress_truth import DIGITS, density_truth, field_truth, truth

import semi_analytic
from scenes import ContactSolution, Scene, load_scene, scene_names

# Scenes with bulk stress or tilt have no values by brute force.
NAMES = tuple(name for name in scene_names() if not load_scene(name).load.has_bulk_or_tilt)
POINTWISE = ("cattaneo-mindlin", "harmonics", "near-sliding", "time-series")
ACCURATE = 1e-12  # within this a reference that is evaluated again is the stored one
_SOURCE = "brute force in extended precision: benchmarks/regress_truth.py"
_SLIP_ZONE_PARTS = (0.25, 0.6, 0.9)  # of a slip zone, at which W(x) has references
# equal parts of the last cycle, and where in each: at no event
_TIMES = 20
_PART = 0.37
# over the largest half-width
_PLACES = np.array([-0.83, -0.31, 0.0, 0.17, 0.42, 0.61, 0.78, 0.89, 0.97])
MEANS = {
    "pressure": "pressure",
    "shear": "shear",
    "slip": "slip",
    "displacement": "tangential_displacement",
}
CENTRE = "centre"
SLIP_ZONE = "slip zone"
INSTANT = "instant"
SLIPPING = "slipping place"
# What has references at the instant: quantity, points, tolerance as a share of the largest number.
FIELDS = (
    ("tangential_displacement", INSTANT, 1e-12),
    ("stick_half_width", INSTANT, 1e-12),
    ("shear", INSTANT, 1e-11),
    ("slip", SLIPPING, 1e-12),
)


# -------------------------------------------------------------------------------------- the values
def measure(scene: Scene, points: dict[str, Any]) -> dict[case_table.Key, Any]:
    """The values of a scene now.

    Parameters
    ----------
    points : of the scene's sheet, name -> {"time": instants, "x": places}

    Returns
    -------
    (run, quantity, points) -> number or lists of numbers, None for NaN
    """
    values = _of_cycle(scene)
    centre = semi_analytic.solve(scene, x=points[CENTRE]["x"])
    values["dissipation", ""] = centre.dissipation
    values["permanent_stick_half_width", ""] = centre.permanent_stick_half_width
    values["largest_pressure", CENTRE] = float(centre.pressure.max())

    instant = semi_analytic.solve(scene, x=points[INSTANT]["x"], time=points[INSTANT]["time"])
    values["tangential_displacement", INSTANT] = instant.tangential_displacement
    values["stick_half_width", INSTANT] = instant.stick_half_width
    values["shear", INSTANT] = instant.shear
    values["slip", SLIPPING] = instant.slip[:, -1:]

    if SLIP_ZONE in points:
        answer = semi_analytic.solve(
            scene, x=points[SLIP_ZONE]["x"], fields=("dissipation_density",)
        )
        values["dissipation_density", SLIP_ZONE] = answer.dissipation_density
    return {
        (THEORY, quantity, at): case_table.plain(value) for (quantity, at), value in values.items()
    }


def _of_cycle(scene: Scene) -> dict[tuple[str, str], Any]:
    """Largest half-width, stroke of U, and the root-mean-squares of the fields."""
    path = semi_analytic.solve(scene)
    largest = float(path.contact_half_width.max())
    shift = path.tangential_displacement
    sampled = semi_analytic.solve(
        scene, x=largest * _PLACES, time=times_of(path)[::2], fields=tuple(MEANS.values())
    )
    values: dict[tuple[str, str], Any] = {
        ("largest_half_width", ""): largest,
        ("stroke", ""): float(shift.max() - shift.min()),
    }
    for name, field in MEANS.items():
        mean_square = np.mean(np.square(getattr(sampled, field)))
        values[f"rms {name}", ""] = float(np.sqrt(mean_square))
    return values


def times_of(solution: ContactSolution) -> np.ndarray:
    """Twenty times of the last cycle, at no event."""
    first, last = solution.time[solution.last_cycle[[0, -1]]].tolist()
    return np.array([first + (k + _PART) / _TIMES * (last - first) for k in range(_TIMES)])


# -------------------------------------------------------------------------------------- the points
def points_of(scene: Scene) -> dict[str, dict[str, list[float]]]:
    """Points of a scene that is new in the table."""
    instant = instant_of(scene)
    slipping = {"time": instant["time"], "x": instant["x"][-1:]}
    points = {CENTRE: {"x": [0.0, 1e-3, 1.0]}, INSTANT: instant, SLIPPING: slipping}
    if scene.name in POINTWISE:
        points[SLIP_ZONE] = {"x": places(scene)}
    return points


def instant_of(scene: Scene) -> dict[str, list[float]]:
    """The time of twenty at which c is least, and three places: one that always sticks, two that
    slip.
    """
    path = semi_analytic.solve(scene, x=[0.0], fields=())
    times = times_of(path)
    edges = semi_analytic.solve(scene, x=[0.0], time=times, fields=())
    instant = int(np.argmin(np.nan_to_num(edges.stick_half_width, nan=math.inf)))
    outer = float(edges.contact_half_width[instant])
    inner = float(edges.stick_half_width[instant])
    if not inner < 0.99999 * outer:
        inner = 0.8 * outer
    always = 0.3 * min(np.nan_to_num(path.permanent_stick_half_width, nan=inner), inner)
    at = [float(always), inner + 0.4 * (outer - inner), inner + 0.9 * (outer - inner)]
    return {"time": [float(times[instant])], "x": at}


def places(scene: Scene) -> list[float]:
    """Three places of the slip zone."""
    answer = semi_analytic.solve(scene, x=[0.0], fields=())
    inner = answer.permanent_stick_half_width
    outer = float(answer.contact_half_width.max())
    return [inner + (outer - inner) * part for part in _SLIP_ZONE_PARTS]


# ---------------------------------------------------------------------------------- the references
def references(known: Sheet) -> tuple[Sheet, float, str]:
    """The references of a scene evaluated again.

    Returns
    -------
    The sheet with those that are missing or that differ by more than `ACCURATE`; the largest
    relative difference of the others; and the dissipation, which belongs into the scene's file.
    """
    mp.mp.dps = DIGITS + 10
    scene = load_scene(known.scene)
    stored = {(case.quantity, case.at): case for case in known.references(THEORY)}
    work = mp.nstr(truth(scene), DIGITS)
    differences_met = [0.0]
    if ("dissipation", "") in stored:  # a new scene has it from here
        differences_met.append(difference_of(stored["dissipation", ""].value, work))
    cases = list(known.cases)
    for (quantity, at), (value, tolerance) in evaluated(scene, known).items():
        old = stored.get((quantity, at))
        if old is not None:
            pairs = zip(case_table.entries(old.value), case_table.entries(value), strict=True)
            differences = [difference_of(before, after) for before, after in pairs]
            if max(differences) <= ACCURATE:
                differences_met += differences
                continue
            cases.remove(old)
        row = {"run": THEORY, "quantity": quantity, "at": at, "value": value}
        row |= {"tolerance": tolerance, "source": _SOURCE}
        cases.append(case_table.case_of_row(known.scene, row))
    changed = Sheet(known.scene, known.keys, known.points, tuple(cases))
    return changed, max(differences_met), work


def evaluated(scene: Scene, known: Sheet) -> dict[tuple[str, str], tuple[Any, float]]:
    """(quantity, points) -> value as text by other means than the engine's, tolerance."""
    values: dict[tuple[str, str], tuple[Any, float]] = {}
    if SLIP_ZONE in known.points:
        density = density_truth(scene, known.points[SLIP_ZONE]["x"])
        values["dissipation_density", SLIP_ZONE] = (density, 1e-11)
    instant = known.points[INSTANT]
    fields = field_truth(scene, instant["time"][0], instant["x"])
    if fields:
        shift, stick, *shear, slip = fields
        nested = ([shift], [stick], [shear], [[slip]])
        for (quantity, at, tolerance), value in zip(FIELDS, nested, strict=True):
            values[quantity, at] = (value, tolerance)
    for value, _ in values.values():
        numbers = [float(entry) for entry in case_table.entries(value)]
        if not np.isfinite(numbers).all():
            raise ArithmeticError(f"a reference is no number: {value}")
    return values


def difference_of(stored: str, renewed: str) -> float:
    """Relative difference of two numbers given by their digits."""
    a = mp.mpf(stored)
    b = mp.mpf(renewed)
    return 0.0 if a == b else float(abs(a - b) / max(abs(a), abs(b)))
