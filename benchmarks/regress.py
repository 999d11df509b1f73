"""Regression of the half-plane engine by itself, without FE: every scene of P and Q of the library,
in seconds.

    make regress                             (python benchmarks/regress.py)
    make regress ACCEPT="hertz-paper ..."    take the new values of the named scenes for frozen ones
    make regress REFERENCES=1                evaluate the references again

Dissipation has a reference in every scene, W(x) at three places of the slip zone in the Hertz
scenes POINTWISE. At one time of the last cycle, which is no event, the tangential displacement U,
the stick edge, the shear at three points and the slip at one are frozen; they have references in
Hertz scenes with friction, but for rows. The root-mean-square of p, q, s and U over ten instants of
the last cycle and nine points is frozen as well: it moves with an error of any part of a field, an
arc of the memory curve too.

Two columns, kept apart: *accurate* is the difference from a closed form or a stored 30-digit value,
of another making; *frozen* is the difference from our own value of last time. A change of either is
shown as old, new and difference, and is accepted by name only. Exit code 1 where something changed
or is not accurate.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import claims
import mpmath as mp
import numpy as np
from claims import write_json
from regress_truth import DIGITS, FIELDS, density_truth, field_truth, truth

import semi_analytic
from scenes import ContactSolution, Scene, load_scene, scene_names

FILE = Path(__file__).with_suffix(".json")
# Relative; the frozen values were made by this very code, so only round-off may differ (another
# order of sums, another library).
ACCURATE, SAME = 1e-12, 1e-13
DENSE = 1e-11  # of the largest of W(x), of f times the largest pressure, of a slip
# Scenes with bulk stress or tilt have their references in `[[expected]]`.
NAMES = tuple(name for name in scene_names() if not load_scene(name).load.has_bulk_or_tilt)
POINTWISE = ("cattaneo-mindlin", "harmonics", "near-sliding", "time-series")
PLACES = (0.25, 0.6, 0.9)  # of a slip zone, at which W(x) has references
_TIMES, _PART = 20, 0.37  # equal parts of the last cycle, and where in each: at no event
# over the largest half-width
_PLACES = np.array([-0.83, -0.31, 0.0, 0.17, 0.42, 0.61, 0.78, 0.89, 0.97])
MEANS = {
    "pressure": "pressure",
    "shear": "shear",
    "slip": "slip",
    "displacement": "tangential_displacement",
}


class Line(NamedTuple):
    """One quantity of one scene: value now, frozen value, and the reference where there is one.

    `scale` is what the error is relative to, None for the value itself.
    """

    scene: str
    quantity: str
    value: float
    frozen: float | None
    reference: str | None
    scale: float | None = None

    @property
    def drift(self) -> float | None:
        """Relative difference from the frozen value."""
        return None if self.frozen is None else self._off(self.frozen)

    @property
    def error(self) -> float | None:
        """Relative difference from the reference."""
        return None if self.reference is None else self._off(mp.mpf(self.reference))

    def _off(self, other: float | mp.mpf) -> float:
        if self.value == other or (math.isnan(self.value) and mp.isnan(other)):
            return 0.0
        return float(abs(self.value - other) / (self.scale or max(abs(self.value), abs(other))))

    @property
    def good(self) -> bool:
        limit = DENSE if self.scale else ACCURATE
        return (
            (self.error is None or self.error <= limit)
            and self.drift is not None
            and self.drift <= SAME
        )


def times_of(full: ContactSolution) -> np.ndarray:
    """Twenty times of the last cycle, at no event."""
    first, last = full.time[full.last_cycle[[0, -1]]].tolist()
    return np.array([first + (k + _PART) / _TIMES * (last - first) for k in range(_TIMES)])


def measure(scene: Scene) -> dict[str, float]:
    """The quantities of a scene by the engine."""
    full = semi_analytic.solve(scene)
    largest, shift = float(full.contact_half_width.max()), full.tangential_displacement
    some = semi_analytic.solve(
        scene, x=largest * _PLACES, time=times_of(full)[::2], fields=tuple(MEANS.values())
    )
    answer = semi_analytic.solve(scene, x=[0.0, 1e-3, 1.0])
    found = {
        "dissipation": answer.dissipation,
        "permanent_stick_half_width": answer.permanent_stick_half_width,
        "largest_half_width": largest,
        "largest_pressure": float(answer.pressure.max()),
        "stroke": float(shift.max() - shift.min()),
    }
    return found | {
        f"rms {name}": float(np.sqrt(np.mean(np.square(getattr(some, field)))))
        for name, field in MEANS.items()
    }


def instant_of(scene: Scene) -> dict[str, Any]:
    """The time of twenty at which c is least, and three points: one that always sticks, two that
    slip.
    """
    full = semi_analytic.solve(scene, x=[0.0], fields=())
    times = times_of(full)
    edges = semi_analytic.solve(scene, x=[0.0], time=times, fields=())
    which = int(np.argmin(np.nan_to_num(edges.stick_half_width, nan=math.inf)))
    outer, inner = float(edges.contact_half_width[which]), float(edges.stick_half_width[which])
    inner = inner if inner < 0.99999 * outer else 0.8 * outer
    always = 0.3 * min(np.nan_to_num(full.permanent_stick_half_width, nan=inner), inner)
    at = [float(always), inner + 0.4 * (outer - inner), inner + 0.9 * (outer - inner)]
    return {"time": float(times[which]), "at": at}


def references(names: list[str], stored: dict[str, dict]) -> None:
    """Evaluate the references of the named scenes again and store each; a stored one that agrees
    has more digits and stays.
    """
    mp.mp.dps = DIGITS + 10
    for name in names:
        scene, kept = load_scene(name), stored.setdefault(name, {})
        (kept["reference"],), *apart = renewed(
            [kept.get("reference")], [mp.nstr(truth(scene), DIGITS)]
        )
        if name in POINTWISE:
            kept["x"] = kept.get("x") or places(scene)
            kept["density"], off = renewed(kept.get("density"), density_truth(scene, kept["x"]))
            apart.append(off)
        fields = kept["fields"] = kept.get("fields") or instant_of(scene)
        if known := field_truth(scene, fields["time"], fields["at"]):
            fields["references"], off = renewed(fields.get("references"), known)
            apart.append(off)
        print(
            f"{name}: {float(kept['reference']):.15g}, stored and evaluated again differ by"
            f" {max(apart):.1e}",
            flush=True,
        )
        write_json(FILE, dict(sorted(stored.items())))


def renewed(old: list[str | None] | None, new: list[str]) -> tuple[list[str], float]:
    """The old values where the new ones agree with them, else the new ones; the largest relative
    difference.
    """
    if not np.isfinite([float(value) for value in new]).all():
        raise ArithmeticError(f"a reference is no number: {', '.join(new)}")
    pairs = list(zip(old or [None] * len(new), new, strict=True))
    lines = [Line("", "", float(value), None, before) for before, value in pairs]
    good = [
        before is not None and (line.error or 0.0) <= ACCURATE
        for (before, _), line in zip(pairs, lines, strict=True)
    ]
    values = [
        str(before) if same else value for (before, value), same in zip(pairs, good, strict=True)
    ]
    return values, max(line.error or 0.0 for line in lines)


def places(scene: Scene) -> list[float]:
    """Three places of the slip zone."""
    answer = semi_analytic.solve(scene, x=[0.0], fields=())
    inner, outer = answer.permanent_stick_half_width, float(answer.contact_half_width.max())
    return [inner + (outer - inner) * part for part in PLACES]


def lines(stored: dict[str, dict]) -> list[Line]:
    """Every quantity of every scene, beside what is stored."""
    return [line for name in NAMES for line in lines_of(load_scene(name), stored.get(name, {}))]


def lines_of(scene: Scene, kept: dict[str, Any]) -> Iterator[Line]:
    """Every quantity of a scene, beside what is stored of it."""

    def line(
        quantity: str, value: float, reference: str | None = None, scale: float | None = None
    ) -> Line:
        return Line(
            scene.name,
            quantity,
            float(value),
            kept.get("frozen", {}).get(quantity),
            reference,
            scale,
        )

    for quantity, value in measure(scene).items():
        yield line(quantity, value, kept.get("reference") if quantity == "dissipation" else None)
    if fields := kept.get("fields"):
        answer = semi_analytic.solve(scene, x=fields["at"], time=[fields["time"]])
        top = scene.friction.coefficient * float(answer.pressure.max())
        values = [
            answer.tangential_displacement[0],
            answer.stick_half_width[0],
            *answer.shear[0],
            answer.slip[0, -1],
        ]
        known, scales = (
            fields.get("references", [None] * len(FIELDS)),
            [
                None,
                None,
                top,
                top,
                top,
                None,
            ],
        )
        yield from map(line, FIELDS, values, known, scales)
    if "x" in kept:
        density = semi_analytic.solve(
            scene, x=kept["x"], fields=("dissipation_density",)
        ).dissipation_density
        scale = max(map(float, kept["density"]))
        yield from map(
            line,
            (f"density at {part}" for part in PLACES),
            density,
            kept["density"],
            [scale] * len(PLACES),
        )


def show(found: list[Line]) -> None:
    """Print the table; a changed value as old, new and difference."""
    print(f"{'scene':24} {'quantity':28} {'value':>24}  {'accurate':>9}  {'frozen':>9}")
    for line in found:
        error = "-" if line.error is None else f"{line.error:.1e}"
        drift = "new" if line.drift is None else f"{line.drift:.1e}"
        print(
            f"{line.scene:24} {line.quantity:28} {line.value:24.17g}  {error:>9}  {drift:>9} "
            f" {'' if line.good else '<<'}"
        )
        if line.drift is not None and line.drift > SAME:
            print(
                f"    old {line.frozen!r}, new {line.value!r}, difference"
                f" {line.value - (line.frozen or 0.0):.3g}"
            )


def main() -> int:
    arguments = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    arguments.add_argument(
        "--accept",
        nargs="*",
        default=[],
        metavar="SCENE",
        help="scenes whose new values become the frozen ones",
    )
    arguments.add_argument(
        "--references",
        nargs="*",
        metavar="SCENE",
        help="evaluate the references again, of all or of these",
    )
    asked = arguments.parse_args()
    if unknown := {*asked.accept, *(asked.references or ())} - set(NAMES):
        print(f"regress: no such scene: {', '.join(sorted(unknown))}", file=sys.stderr)
        return 2
    stored = claims.stored(FILE)
    if asked.references is not None:
        references(asked.references or list(NAMES), stored)
    mp.mp.dps = DIGITS + 10
    found = lines(stored)
    for name in asked.accept:
        stored.setdefault(name, {})["frozen"] = {
            line.quantity: line.value for line in found if line.scene == name
        }
    if asked.accept:
        write_json(FILE, dict(sorted(stored.items())))
        found = lines(stored)
    show(found)
    bad = [line for line in found if not line.good]
    print(f"{len(found)} values of {len(NAMES)} scenes, {len(bad)} changed or not accurate")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
