"""Findings with a trace of their own in the rows of a result: no theory with the fault is needed.

# notation: p pressure, q shear, f friction coefficient, h spacing, a half-width
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.comparison import Comparison
from reports.scoring.discrepancy import PRESSURE, SHEAR, Discrepancy, Tractions, pair
from scenes import STICK

NOISE = "noise"
UNKNOWN = "unknown"
OWN_BODIES = "own_bodies"
WORDS: dict[str, Any] = tomllib.loads(
    (resources.files("reports") / "templates" / "faults.toml").read_text("utf-8")
)
"""Sentences of each fault, of other findings, and quotients of E*/R with a likely cause."""
FAULTS: dict[str, str] = WORDS["faults"]

# Of f p, below which a point sticks for certain; of the largest step of the slip, below which it
# rests.
_STICKS = 0.9
_AT_REST = 1e-3
# Share of the creep that is proportional to the change of the shear, where a penalty makes it: a
# third of its norm is left; over the largest step of slip, below which nobody need know; fewest
# points and instants that show it.
_PROPORTIONAL = 8 / 9
_NO_CREEP = 3e-3
# Square of the gain over its standard deviation: noise alone gives one as large once in 10^11.
_GAIN = 45.0
_FEWEST_CREEPING = 20
# Share of the points that should stick and lie on the Coulomb limit, where nothing sticks; of f p,
# how near to the limit is on it: shear beyond it is another fault.
_ALL_SLIP = 0.9
_ON_LIMIT = 0.01
# Standard deviations of the noise by which a point may exceed the Coulomb limit and the contact law
# still be kept.
_BY_NOISE = 5.0
# Standard deviation of the noise of the shear over that of the pressure, at most: few points may
# look like noise by chance; of both scales, below which there is no noise.
NOISIER = 5.0
_EXACT = 1e-10
# Of the norm of a difference that alternates from node to node, what means over three leave;
# standard deviations by which its ratio of von Neumann exceeds that of noise.
_LEFT_OF_ALTERNATION = 1 / 3
_ALTERNATES = 5.0
# Spacings to each side of an edge that a mesh can get wrong: the element with the edge in it, and
# its neighbour.
_REACH = 2.0
# A traction that leaves the edge as a root has an error of about sqrt(2 h/a) of its peak over the
# element with the edge: shear, at stick edges, up to 1.2 of that on meshes of a/5 to a/24, pressure
# up to 0.36, its edge being found to a part of an element. A soft layer or a short body moves the
# pressure's edge by 0.7 to 1.5 of that.
_MOST = (0.4, 1.0)
# Of the points in contact that lie near an edge, where "near" still means something.
_MOST_NEAR = 0.6


@dataclass(frozen=True)
class Diagnosis:
    """One finding on a result.

    Attributes
    ----------
    fault
        its key, of `FAULTS` or of the other findings in templates/faults.toml
    sentence
        the cause, and what to do
    evidence
        measured values, in words
    strength
        0 to 1: 1 minus the share of the difference that a result with just this fault leaves
    size
        how large the fault is, in a few words; empty of faults without a size
    """

    fault: str
    sentence: str
    evidence: tuple[str, ...]
    strength: float
    size: str = ""

    @property
    def name(self) -> str:
        """The finding in a few words."""
        return str(WORDS["names"][self.fault])

    @property
    def name_and_size(self) -> str:
        """The same, with its size."""
        return f"{self.name} ({self.size})" if self.size else self.name


def outliers(comparison: Comparison) -> list[Diagnosis]:
    """Single values that stand out of all others, the first with its place."""
    found = comparison.found
    words = [
        f"{name} {getattr(found, name)[k, i]:.6g} at instant {k + 1} of the last cycle (time"
        f" {found.time[k]:.6g}), x = {found.x[i]:.6g}"
        for name, mask in comparison.isolated.items()
        for k, i in np.argwhere(mask)
    ]
    if not words:
        return []
    sentence = WORDS["others"]["outlier"].format(count=len(words), first=words[0])
    return [Diagnosis("outlier", sentence, tuple(words[1:6]), 1.0)]


def full_slip(discrepancy: Discrepancy) -> Iterator[Diagnosis]:
    """A result that lies on the Coulomb limit at the points that stick in the reference."""
    comparison = discrepancy.comparison
    friction = discrepancy.comparison.scene.friction.coefficient
    if not friction or not discrepancy.sheared:
        return
    found = comparison.found
    expected = comparison.expected
    pressed = (found.pressure > 0.01 * comparison.scales.pressure) & comparison.judged[:, None]
    should_stick = (
        pressed
        & (expected.state == STICK)
        & (np.abs(expected.shear) < _STICKS * friction * expected.pressure)
    )
    limit = friction * found.pressure
    at_limit = np.abs(np.abs(found.shear) - limit) <= _ON_LIMIT * limit
    count = int(should_stick.sum())
    if not count or at_limit[pressed].mean() < _ALL_SLIP:
        return
    share = float((should_stick & at_limit).sum()) / count
    if share < _ALL_SLIP:
        return
    width = float(np.nanmax(np.diff(expected.stick_edges, axis=1))) / 2
    sentence = WORDS["others"]["full_slip"].format(width=width / comparison.scales.half_width)
    evidence = (
        f"|q| is f p at {share:.0%} of the {count} points and instants at which the reference"
        " sticks"
    )
    yield Diagnosis("full_slip", sentence, (evidence,), 1.0)


def elastic_slip(discrepancy: Discrepancy, *, shear_sign: float = 1.0) -> Iterator[Diagnosis]:
    """Creep of points that stick, in proportion to the shear: a penalty of stiffness k moves them
    by dq/k.

    Points that stick from one instant to the next are those with |q| < 0.9 f p at both, in the
    result and in the reference, whose slip rests in the reference. `shear_sign` is -1 where the
    file is known to have a shear of the wrong sign.
    """
    comparison = discrepancy.comparison
    friction = discrepancy.comparison.scene.friction.coefficient
    found = comparison.found
    expected = comparison.expected
    if not friction or not discrepancy.sheared or len(found.time) < 2:
        return
    if not (np.isfinite(found.slip).all() and np.isfinite(expected.slip).all()):
        return
    pressed = comparison.judged[:, None] & ~comparison.isolated["shear"]
    for side in (found, expected):
        pressed &= side.pressure > 0.01 * comparison.scales.pressure
        pressed &= np.abs(side.shear) < _STICKS * friction * side.pressure
    moved = np.diff(found.slip, axis=0)
    moved_in_reference = np.diff(expected.slip, axis=0)
    sheared = shear_sign * np.diff(found.shear, axis=0)
    touching = (found.pressure[1:] > 0) & (found.pressure[:-1] > 0)
    largest = float(np.max(np.abs(moved), where=touching, initial=0.0))
    sticks = pressed[1:] & pressed[:-1] & (np.abs(moved_in_reference) <= _AT_REST * largest)
    creep = moved[sticks]
    change = sheared[sticks]
    if len(creep) < _FEWEST_CREEPING or not change.any() or not creep.any():
        return
    compliance = float(creep @ change / (change @ change))
    left = moved - compliance * sheared
    beside = sticks[:, 1:] & sticks[:, :-1]
    noise = float(np.mean(np.diff(left, axis=1)[beside] ** 2)) / 2 if beside.any() else 0.0
    square = float(np.mean(creep**2))
    square_left = float(np.mean(left[sticks] ** 2))
    noise = min(noise, square_left)
    if square <= noise:
        return
    proportional = 1 - (square_left - noise) / (square - noise)
    gain = (square - square_left) / max(square_left, 1e-300) * len(creep)
    size = float(np.sqrt(square - noise)) / largest
    if compliance <= 0 or proportional < _PROPORTIONAL or size < _NO_CREEP or gain < _GAIN:
        return
    scales = comparison.scales
    stiffness = scales.compliance * scales.half_width / (2 * compliance)  # over E*/a, E* = 2/A
    evidence = (
        (
            f"{len(creep)} steps of points that stick: the slip moves by {size:.2g} of the largest"
            f" step, {proportional:.0%} of it in proportion to the shear"
        ),
        f"a tangential stiffness of {stiffness:.2g} E*/a_ref",
    )
    yield Diagnosis("elastic_slip", FAULTS["elastic_slip"], evidence, proportional)


def alternating_nodes(discrepancy: Discrepancy) -> Iterator[Diagnosis]:
    """Pressures that alternate from node to node: nodal forces or extrapolated stresses of corner
    and mid-side nodes of quadratic elements.

    The mean (1, 2, 1)/4 over neighbours takes out what alternates. The ratio of von Neumann is 2
    where all does, and 1 for white noise, about which it scatters by 1/sqrt(n).
    """
    residual = discrepancy.residual(discrepancy.expected, PRESSURE)
    inside = residual.inside
    three = inside[:, :-2] & inside[:, 1:-1] & inside[:, 2:]
    # Of one instant: a mesh errs alike at all.
    count = int(three.sum(axis=1).max())
    if not count or discrepancy.is_within(PRESSURE):
        return
    values = residual.values
    smooth = (values[:, :-2] + 2 * values[:, 1:-1] + values[:, 2:])[three] / 4
    steps = np.diff(values, axis=1)[inside[:, 1:] & inside[:, :-1]]
    size = float(np.mean(values[:, 1:-1][three] ** 2))
    ratio = float(np.mean(steps**2)) / 2 / size
    left = float(np.sqrt(np.mean(smooth**2) / size))
    if left > _LEFT_OF_ALTERNATION or (ratio - 1) * np.sqrt(count) < _ALTERNATES:
        return
    evidence = (
        f"{count} points of an instant have both neighbours in contact; their means over three"
        f" points leave {left:.0%} of the difference",
    )
    yield Diagnosis("alternating", WORDS["others"]["alternating"], evidence, 1 - left)


def scatter(discrepancy: Discrepancy) -> Iterator[Diagnosis]:
    """Tractions that scatter from point to point, where that is the discrepancy; how many exceed
    the Coulomb limit.
    """
    scales = discrepancy.comparison.scales
    channels = [PRESSURE]
    if discrepancy.sheared and scales.friction > 0:
        channels.append(SHEAR)
    residuals = [discrepancy.residual(discrepancy.expected, channel) for channel in channels]
    differing = [residual for residual in residuals if residual.square > 0]
    if not differing or not all(residual.is_noise for residual in differing):
        return
    sigma = [min(residual.noise, residual.square) ** 0.5 for residual in residuals]
    if len(sigma) > 1 and scales.friction * sigma[SHEAR] > NOISIER * max(sigma[PRESSURE], _EXACT):
        return  # one code, one file: a shear alone does not scatter
    share = sum(value**2 for value in sigma) / sum(residual.square for residual in residuals)
    evidence = [f"noise from point to point makes {share:.0%} of the square of the discrepancy"]
    words = f"{sigma[0]:.2g} in p/p_ref"
    if len(sigma) > 1:
        words += f" and {sigma[1]:.2g} in q/(f p_ref)"
        found = discrepancy.comparison.found  # at all instants
        touching = discrepancy.comparison.expected.pressure > 1e-3 * scales.pressure
        beyond = np.abs(found.shear) / scales.shear - found.pressure / scales.pressure
        count = int(np.sum(beyond[touching] > 0))
        most = float(np.max(beyond[touching]))
        limit = _BY_NOISE * sum(value**2 for value in sigma) ** 0.5
        how_much = "more than noise alone makes"
        if most <= limit:
            how_much = "no more than noise makes: no fault of the contact law"
        evidence.insert(
            0,
            f"{count} of {int(touching.sum())} points in contact exceed the Coulomb limit, by"
            f" {most:.2g} of f p_ref at most: {how_much}",
        )
    sentence = WORDS["others"][NOISE].format(size=words)
    yield Diagnosis(NOISE, sentence, tuple(evidence), share)


def long_steps_by_work(comparison: Comparison) -> Iterator[Diagnosis]:
    """Steps too long where the tractions show nothing: the dissipation is off, and that of the
    polygon of the instants is not.

    Exact steps cut corners of the path alone, and tractions at their ends are right as soon as the
    corner is left behind.
    """
    values = {metric.key: metric.value for metric in comparison.metrics}
    error = values.get("dissipation")
    error_on_lines = values.get("dissipation_polygon")
    limit = comparison.scene.tolerances.limit("dissipation") or 0.0
    if error is None or error_on_lines is None:
        return
    if not abs(error) > limit or not abs(error_on_lines) < abs(error) / 2:
        return
    steps = len(comparison.found.time) - 1
    evidence = (
        (
            f"error of the dissipation {error:.2g}; against that of the straight lines between the"
            f" {steps} steps {error_on_lines:.2g}"
        ),
        "the tractions are within their tolerances",
    )
    yield Diagnosis(
        "steps", FAULTS["steps"].format(steps=steps), evidence, 1 - abs(error_on_lines / error)
    )


def coarse_edge(discrepancy: Discrepancy) -> tuple[Tractions, NDArray[np.bool_]] | None:
    """What a mesh too coarse at the edges would give: the part of the discrepancy within two
    spacings of an edge, as far as the spacing can account for its size; and which points these
    are, (k, n). None where the points tell no edge from the rest.

    An elastic traction leaves the edge of contact as (1 - x/a)^(1/2), and q the stick edge
    likewise. Interpolated on elements of length h its error is of the order of p_ref sqrt(2 h/a)
    over the element with the edge. What goes beyond that is not the mesh's. The edges are those of
    the instant, and those of the smallest stick zone: what a mesh gets wrong there stays locked in.
    """
    x = discrepancy.x
    scales = discrepancy.comparison.scales
    cycle = discrepancy.comparison.expected
    steps = np.diff(x)
    spacing = np.maximum(np.append(steps, steps[-1]), np.insert(steps, 0, steps[0]))
    places = [
        edge
        for edges in (cycle.contact_edges, cycle.stick_edges)
        for edge in edges[discrepancy.rows].T[:, :, None]
    ]
    if np.isfinite(cycle.stick_edges).any():
        least = np.nanmin(np.abs(cycle.stick_edges))
        inner = np.nanmax(cycle.stick_edges[:, 0]), np.nanmin(cycle.stick_edges[:, 1])
        places += inner if discrepancy.unsymmetric else (-least, least)
    with np.errstate(invalid="ignore"):
        near = np.any(
            [
                np.broadcast_to(np.abs(x - edge) <= _REACH * spacing, discrepancy.expected[0].shape)
                for edge in places
            ],
            axis=0,
        )
    contact = discrepancy.in_contact(discrepancy.expected)
    if not near.any() or np.mean(near[contact]) > _MOST_NEAR:
        return None
    most = pair(*_MOST) * np.sqrt(2 * spacing / scales.half_width) * discrepancy.units
    difference = np.clip(discrepancy.found - discrepancy.expected, -most, most)
    return discrepancy.expected + np.where(near, difference, 0.0), near
