"""Every metric sees its own planted fault, in the amount known by hand, and no other sees it; so
does every law of contact.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import semi_analytic
from halfplane_fe.solution import FiniteElementSolution
from problems import COARSE, FEW_STEPS, fe_run
from reports import compare, write
from reports.charts.plate import Plate
from reports.comparison import Comparison
from reports.comparison.cycles import events, index_of_first_row, interpolated_cycle, last_cycle
from reports.comparison.datum import effects_between
from reports.comparison.metrics import METRICS, markdown
from reports.page.writing import draw
from reports.report import Report
from scenes import (
    SLIP_FORWARD,
    BodyEffects,
    ContactSolution,
    Estimate,
    InputError,
    Materials,
    Record,
    SurfaceState,
    TimeSeriesLoad,
    load_scene,
    read_only_copy,
)
from scenes.scene import OWN_TOLERANCES
from test_reports_synthetic import LOAD_RATIO, cattaneo_mindlin, with_fields

TRUTH = cattaneo_mindlin()
X = TRUTH.x
TIME = TRUTH.time
SPACING = float(X[1] - X[0])
STEPS = len(TIME) - 1
INSIDE = TRUTH.state != SurfaceState.OPEN
FRICTION = TRUTH.scene.friction.coefficient
STROKE = float(np.ptp(TRUTH.tangential_displacement))
W = TRUTH.dissipation
SCALES = compare(TRUTH, TRUTH).scales
# What the closed form itself leaves of a metric that should be 0.
ROUNDING = 1e-12
# An instant soon after Q turned at its largest, when q has both signs, and one on the way up.
AFTER_TURN = 50
ON_THE_WAY = 30


def changed(**fields: Any) -> ContactSolution:
    return with_fields(TRUTH, **fields)


def at(step: int | slice, values: np.ndarray, factor: float = 1.0, new: Any = None) -> np.ndarray:
    """`values` with one instant multiplied, or replaced."""
    out = values.copy()
    out[step] = out[step] * factor if new is None else new
    return out


# ---------------------------------------------------------------------------- amounts known by hand
def shear_norm(step: int) -> float:
    """||q||/(f ||p||) of an instant, by plain sums (even spacing)."""
    return float(
        np.sqrt((TRUTH.shear[step] ** 2).sum() / (TRUTH.pressure[step] ** 2).sum()) / FRICTION
    )


def by_rule(values: np.ndarray, step: int) -> float:
    """int values dx / P of an instant by the trapezoidal rule, on points that are evenly spaced and
    carry nothing at their ends.
    """
    return float(values[step].sum() * SPACING / TRUTH.normal_load[step])


def slipping_share() -> float:
    """Mean over the cycle of the slipping share of the contact."""
    share = (TRUTH.state >= SurfaceState.SLIP_FORWARD).sum(axis=1) / INSIDE.sum(axis=1)
    return float(np.trapezoid(share, TIME) / 3)


def slipping_points(points: int, instants: int) -> float:
    """Mean over the cycle of the share of some points of the contact at some instants, by plain
    counting.
    """
    return points * instants / (int(INSIDE[0].sum()) * STEPS)


def in_reverse() -> float:
    """Mean over the cycle of the share of the contact in reverse slip."""
    share = (TRUTH.state == SurfaceState.SLIP_REVERSE).sum(axis=1) / INSIDE.sum(axis=1)
    return float(np.trapezoid(share, TIME) / 3)


# -------------------------------------------------------------------------------- planted solutions
def edges(name: str, left: float, right: float) -> ContactSolution:
    return changed(**{name: getattr(TRUTH, name) + np.array([left, right])})


def swapped() -> ContactSolution:
    """Forward and reverse slip exchanged."""
    return changed(state=np.choose(TRUTH.state, [0, 1, 3, 2]).astype(np.int8))


def full_stick(*runs: tuple[int, int]) -> ContactSolution:
    """The whole contact sticking from the first to the last step of each run."""
    stick_edges = TRUTH.stick_edges
    for first, last in runs:
        stick_edges = at(
            slice(first, last + 1), stick_edges, new=TRUTH.contact_edges[first : last + 1]
        )
    return changed(stick_edges=stick_edges)


def to_and_fro(late: int) -> ContactSolution:
    """Slip all over the contact, its sense changing every 20 of the 120 steps, the first time at
    step 1 + `late`.
    """
    forward = ((np.arange(STEPS + 1) - 1 - late) % STEPS // 20 % 2 == 0)[:, None]
    return changed(state=np.where(INSIDE, np.where(forward, 2, 3), 0).astype(np.int8))


def begins(late: int) -> ContactSolution:
    """Reverse slip beginning five steps and `late` after its true beginning, sticking from Q's
    maximum until then.
    """
    step = (
        5
        + late
        + int(
            np.flatnonzero((TIME > 2) & (TRUTH.state == SurfaceState.SLIP_REVERSE).any(axis=1))[0]
        )
    )
    state = TRUTH.state.copy()
    state[41:step][state[41:step] > 1] = SurfaceState.STICK
    return changed(state=state)


def slipping(factor: float = 1.0, outside: float = 0.0, offset: float = 0.0) -> ContactSolution:
    """s = 3 x sin(turn) in contact, so its range is 6; anything out of contact."""
    slip = factor * 3 * X / np.abs(X[INSIDE[0]]).max() * np.sin(2 * np.pi * (TIME - 1) / 3)[:, None]
    return changed(slip=np.where(INSIDE, slip, outside) + offset)


def bell(points: int = 0) -> ContactSolution:
    return changed(dissipation_density=np.roll(np.exp(-(((X - 0.5) / 0.1) ** 2)), points))


def half_shear(points: int = 0) -> ContactSolution:
    """Only where one half of q is taken away can the peak of the other half not count as its mirror
    image.
    """
    return changed(shear=np.roll(np.where(X > 0, TRUTH.shear, 0.0), points, axis=1))


def twins(factor: float = 1.0, mirrored: bool = False) -> ContactSolution:
    """Two peaks of pressure, the left one 2 % lower, times `factor`."""
    twin = np.exp(-(((X - 0.6) / 0.1) ** 2)) + 0.98 * np.exp(-(((X + 0.6) / 0.1) ** 2))
    twin = np.where(X < 0, factor, 1.0) * twin
    return changed(pressure=np.tile(twin[::-1] if mirrored else twin, (STEPS + 1, 1)))


def recorded(value: float) -> ContactSolution:
    """With an energy balance that is not closed at instant 9."""
    series = read_only_copy(at(9, np.zeros(STEPS + 1), new=value))
    return changed(
        record=Record(
            True,
            "steady",
            "",
            read_only_copy(np.ones(STEPS + 1), np.int64),
            {"energy_balance": series},
        )
    )


# The same contact, pulled in phase with Q and tilted in phase too: numbers alone, whose integrals
# are known by hand.
TURN = np.sin(2 * np.pi * (TIME - 1) / 3)
STRESS = 0.1 * SCALES.pressure
STRAIN = STRESS * SCALES.compliance / 2 / 2  # of one of two like bodies: A/2 = 2/E'
PULLED = changed(
    scene=TRUTH.scene.vary(load={"bulk_stress_lower": 1.0, "tilt": 0.1}),
    bulk_stress_lower=STRESS * np.cos(2 * np.pi * (TIME - 1) / 3),
    bulk_stress_upper=0 * TIME,
    tilt=1e-3 + 0 * TIME,
    moment=-0.05 * SCALES.normal_load * TRUTH.tangential_load / np.max(TRUTH.tangential_load),
    shear_moment=0.3 * SCALES.normal_load * TURN,
    permanent_stick_edges=np.array([-0.5, 0.7]),
    contact_edges=TRUTH.contact_edges - 0.1,
    cycle_dissipation=np.array([1.1 * W, W]),
    dissipation=W,
    steady_from=None,
)
# -closed integral of m_q d(eps), by the trapezoidal rule on even instants: exact of waves but for
# sin(h)/h.
BULK = float(
    0.3 * SCALES.normal_load * STRAIN * np.pi * np.sin(2 * np.pi / STEPS) / (2 * np.pi / STEPS)
)


MOMENT = (
    float(np.abs(PULLED.moment).max() / SCALES.normal_load) if PULLED.moment is not None else 0.0
)


def pulled(**fields: Any) -> ContactSolution:
    return with_fields(PULLED, **fields)


def equal(value: float, *keys: str) -> dict[str, float]:
    return dict.fromkeys(keys, value)


# fault -> (result, metric -> amount, metrics that see it in an amount of no interest, reference);
# no other metric sees it.
FAULTS: dict[str, tuple[Callable[[], ContactSolution], dict[str, float], str, ContactSolution]] = {
    "none": (lambda: TRUTH, {}, "", TRUTH),
    "pressure 1 % high": (
        lambda: changed(pressure=1.01 * TRUTH.pressure),
        equal(
            0.01,
            "largest_pressure",
            "peak_pressure",
            "pressure",
        )
        | {"resultant_normal": 0.01 * by_rule(TRUTH.pressure, 0)},
        "",
        TRUTH,
    ),
    "pressure 1 % low at one instant": (
        lambda: changed(pressure=at(17, TRUTH.pressure, 0.99)),
        {
            "peak_pressure": -0.01,
            "pressure": 0.01,
            "resultant_normal": -0.01 * by_rule(TRUTH.pressure, 17),
        },
        "",
        TRUTH,
    ),
    "pressure three points to the left": (
        lambda: changed(pressure=np.roll(TRUTH.pressure, -3, axis=1)),
        {},
        "pressure",
        TRUTH,
    ),
    "pressure four points to the right": (
        lambda: changed(pressure=np.roll(TRUTH.pressure, 4, axis=1)),
        {},
        "pressure",
        TRUTH,
    ),
    "two peaks on the wrong sides": (lambda: twins(mirrored=True), {}, "pressure", twins()),
    "unlike peaks": (
        lambda: twins(mirrored=True),
        {},
        "pressure resultant_normal",
        twins(0.9),
    ),
    "shear flipped at one instant": (
        lambda: changed(shear=at(AFTER_TURN, TRUTH.shear, -1)),
        {
            "shear": 2 * shear_norm(AFTER_TURN),
            "resultant_tangential": -2 * by_rule(TRUTH.shear, AFTER_TURN),
        },
        "",
        TRUTH,
    ),
    "shear 1 % high at one instant": (
        lambda: changed(shear=at(ON_THE_WAY, TRUTH.shear, 1.01)),
        {
            "shear": 0.01 * shear_norm(ON_THE_WAY),
            "resultant_tangential": 0.01 * by_rule(TRUTH.shear, ON_THE_WAY),
        },
        "",
        TRUTH,
    ),
    "shear two points to the right": (
        lambda: half_shear(2),
        {},
        "shear",
        half_shear(),
    ),
    "right contact edge 0.02 a out": (
        lambda: edges("contact_edges", 0, 0.02),
        {"largest_half_width": 0.01, "contact_edge": 0.02},
        "",
        TRUTH,
    ),
    "left contact edge 0.02 a in": (
        lambda: edges("contact_edges", 0.02, 0),
        {"largest_half_width": -0.01, "contact_edge": -0.02},
        "",
        TRUTH,
    ),
    "left stick edge 0.01 a out": (
        lambda: edges("stick_edges", -0.01, 0),
        {"stick_edge": 0.01},
        "",
        TRUTH,
    ),
    "right stick edge 0.03 a in": (
        lambda: edges("stick_edges", 0, -0.03),
        {"stick_edge": -0.03},
        "",
        TRUTH,
    ),
    "forward and reverse exchanged": (swapped, {"state": slipping_share()}, "", TRUTH),
    "reverse slip taken for forward": (
        lambda: changed(state=np.minimum(TRUTH.state, 2).astype(np.int8)),
        {"state": in_reverse()},
        "",
        TRUTH,
    ),
    "five points slip for 20 instants": (
        lambda: changed(
            state=at(
                slice(20, 40),
                TRUTH.state,
                new=np.where(abs(X) < 2.5 * SPACING, 2, TRUTH.state[20:40]),
            )
        ),
        {"state": slipping_points(5, 20)},
        "",
        TRUTH,
    ),
    "stick and slip exchanged": (
        lambda: changed(state=np.where(TRUTH.state == 1, 2, 1).astype(np.int8)),
        {},
        "state",
        TRUTH,
    ),
    "full stick starts late and ends early": (
        lambda: full_stick((52, 57)),
        {},
        "stick_edge",
        full_stick((50, 58)),
    ),
    "full stick starts early and ends late": (
        lambda: full_stick((48, 60)),
        {},
        "stick_edge",
        full_stick((50, 58)),
    ),
    # From step 110 of one cycle to step 5 of the next.
    "full stick across the end of the cycle": (
        lambda: full_stick((0, 2)),
        {},
        "stick_edge",
        full_stick((110, STEPS), (0, 5)),
    ),
    "full stick one step late": (lambda: full_stick((51, 58)), {}, "", full_stick((50, 58))),
    "full stick at a single instant left out": (
        lambda: full_stick((50, 58)),
        {},
        "stick_edge",
        full_stick((50, 58), (90, 90)),
    ),
    "reverse slip begins 2 steps early": (lambda: begins(-2), {}, "state", begins(0)),
    "reverse slip begins 3 steps late": (lambda: begins(3), {}, "state", begins(0)),
    # Six reversals in a cycle, the whole contact in the wrong sense for some steps after each.
    "every reversal 2 steps early": (
        lambda: to_and_fro(-2),
        {"state": 6 * 2 / STEPS},
        "",
        to_and_fro(0),
    ),
    "every reversal 3 steps late": (
        lambda: to_and_fro(3),
        {"state": 6 * 3 / STEPS},
        "",
        to_and_fro(0),
    ),
    "slip 2 % high": (
        lambda: slipping(1.02),
        equal(0.02, "largest_slip", "largest_slip_common")
        | {"slip": 0.01 * float(np.sqrt(np.mean(X[INSIDE[0]] ** 2)) / np.abs(X[INSIDE[0]]).max())},
        "",
        slipping(),
    ),
    "slip low by a constant": (
        lambda: slipping(offset=-0.06),
        {"slip": 0.01},
        "",
        slipping(),
    ),
    "slip high by a constant": (
        lambda: slipping(offset=0.06),
        {"slip": 0.01},
        "",
        slipping(),
    ),
    "slip out of contact is nothing": (lambda: slipping(outside=7.0), {}, "", slipping()),
    "tangential displacement off by a constant": (
        lambda: changed(tangential_displacement=TRUTH.tangential_displacement + 0.04 * STROKE),
        {"tangential_displacement": 0.04},
        "",
        TRUTH,
    ),
    "loop 2 % wider": (
        lambda: changed(tangential_displacement=1.02 * TRUTH.tangential_displacement),
        {"hysteresis": 0.02},
        "tangential_displacement",
        TRUTH,
    ),
    "dissipation 1 % low": (
        lambda: changed(dissipation=0.99 * W),
        equal(-0.01, "dissipation", "dissipation_polygon"),
        "",
        TRUTH,
    ),
    "dissipation density 5 % high": (
        lambda: changed(dissipation_density=1.05 * TRUTH.dissipation_density),
        equal(0.05, "dissipation_density", "dissipation_density_peak"),
        "",
        TRUTH,
    ),
    "peak of the density to the left": (
        lambda: bell(-4),
        {},
        "dissipation_density",
        bell(),
    ),
    "peak of the density to the right": (
        lambda: bell(4),
        {},
        "dissipation_density",
        bell(),
    ),
    "permanent stick 0.01 a too small": (
        lambda: changed(permanent_stick_half_width=TRUTH.permanent_stick_half_width - 0.01),
        {"permanent_stick": -0.01},
        "",
        TRUTH,
    ),
    "energy balance not closed": (lambda: recorded(3e-4), {"energy_balance": 3e-4}, "", TRUTH),
    "nothing wrong under bulk stress and tilt": (lambda: PULLED, {}, "", PULLED),
    "stick zone on the other side": (
        lambda: pulled(permanent_stick_edges=np.array([-0.7, 0.5])),
        {"stick_eccentricity": -0.2},
        "",
        PULLED,
    ),
    "bulk term left out": (
        lambda: pulled(shear_moment=0 * TIME),
        {"bulk_work": -BULK / W},
        "",
        PULLED,
    ),
    "bulk stress turned against its shear": (
        lambda: pulled(bulk_stress_lower=-PULLED.bulk_stress_lower),
        {"bulk_work": -2 * BULK / W},
        "",
        PULLED,
    ),
    "tilt turned": (
        lambda: pulled(
            tilt=-PULLED.tilt, moment=-PULLED.moment, contact_edges=TRUTH.contact_edges + 0.1
        ),
        {
            "moment": 2 * MOMENT,
            "tilt": -2e-3 * SCALES.half_width / (SCALES.compliance * SCALES.normal_load),
        },
        "contact_edge",
        PULLED,
    ),
    "a cycle that drifts": (
        lambda: pulled(cycle_dissipation=np.array([1.2 * W, W])),
        {"dissipation_drift": -0.1},
        "",
        PULLED,
    ),
}


def seen(comparison: Comparison) -> set[str]:
    """The metrics that are not 0."""
    return {
        metric.key
        for metric in comparison.metrics
        if metric.value is not None and not abs(metric.value) < ROUNDING
    }


@pytest.mark.parametrize("name", FAULTS)
def test_fault_is_seen_by_its_metrics_alone(name: str) -> None:
    plant, amounts, also, reference = FAULTS[name]
    comparison = compare(
        reference, plant(), polygon_reference=TRUTH if reference is TRUTH else None
    )
    assert seen(comparison) == {*amounts, *also.split()}
    for key, value in amounts.items():
        assert comparison.metric(key).value == pytest.approx(value, rel=1e-9, abs=ROUNDING), key
    assert all(metric.value is not None or metric.note for metric in comparison.metrics)


NAN = float("nan")
NO_EDGES = changed(stick_edges=at(slice(40, 43), TRUTH.stick_edges, new=NAN))
LARGEST_SLIP_ZONE = int(np.argmin(TRUTH.stick_half_width))
LONG_STICK = full_stick((50, 58))
TWO_STICKS = full_stick((50, 58), (90, 93))
# Of the stick edge at the four instants of full stick that one lacks.
JUMP = float(np.max(1 - TRUTH.stick_half_width[90:94]))
LITTLE, LESS = (changed(dissipation=part * SCALES.dissipation) for part in (1e-6, 1e-6 - 1e-3))
# reference, result, metric, value (NaN: not a number; None: there is none), how its note begins
NOTED: dict[str, tuple[ContactSolution, ContactSolution, str, float | None, str]] = {
    "full slip in both": (NO_EDGES, NO_EDGES, "stick_edge", 0.0, ""),
    "full slip in one": (TRUTH, NO_EDGES, "stick_edge", 0.0, f"3 of {STEPS + 1} instants differ"),
    "full stick against partial slip": (
        TRUTH,
        full_stick((LARGEST_SLIP_ZONE, LARGEST_SLIP_ZONE)),
        "stick_edge",
        1 - np.sqrt(1 - LOAD_RATIO),
        f"1 of {STEPS + 1} instants differ",
    ),
    "full stick that the result lacks": (
        TWO_STICKS,
        LONG_STICK,
        "stick_edge",
        -JUMP,
        f"4 of {STEPS + 1} instants differ",
    ),
    "full stick that the reference lacks": (
        LONG_STICK,
        TWO_STICKS,
        "stick_edge",
        JUMP,
        f"4 of {STEPS + 1} instants differ",
    ),
    "no permanent stick": (
        TRUTH,
        changed(permanent_stick_half_width=NAN),
        "permanent_stick",
        None,
        "none in closed form",
    ),
    "no dissipation": (
        changed(dissipation=0.0),
        changed(dissipation=1e-3),
        "dissipation",
        1e-3 / SCALES.dissipation,
        "the reference dissipates nothing",
    ),
    "hardly any dissipation": (LITTLE, LESS, "dissipation", -1e3, ""),
    "no slip": (
        TRUTH,
        changed(slip=0 * TRUTH.slip + 1e-3),
        "slip",
        1e-3 / (SCALES.compliance / 2 * SCALES.shear * SCALES.half_width),
        "",
    ),
}


@pytest.mark.parametrize("case", NOTED)
def test_what_one_of_them_lacks_is_said(case: str) -> None:
    reference, solution, key, value, note = NOTED[case]
    metric = compare(reference, solution).metric(key)
    assert metric.value == (value if value is None else pytest.approx(value, nan_ok=True))
    assert note in metric.note if note else not metric.note or metric.absolute
    assert metric.absolute is (case in ("no dissipation", "no slip"))


def test_a_displacement_without_a_judged_instant_states_that_the_load_is_too_light() -> None:
    heavy = changed(normal_load=100 * TRUTH.normal_load)
    metric = compare(TRUTH, TRUTH, scales_from=heavy).metric("tangential_displacement")
    assert metric.value is None
    assert metric.note == "no instant carries enough load to be judged"


def test_maps_count_both_ways_and_a_stick_edge_that_is_never_there_fails() -> None:
    """Too little contact as too much of it, over what touches in either."""
    half = changed(state=np.where(X > 0, 0, TRUTH.state).astype(np.int8))
    lost = compare(TRUTH, half).metric("state").value
    gained = compare(half, TRUTH).metric("state").value
    assert lost == pytest.approx(gained, rel=1e-12)
    assert lost == pytest.approx(0.5, abs=0.02)
    never = changed(stick_edges=np.full_like(TRUTH.stick_edges, NAN))
    assert compare(TRUTH, never).metric("stick_edge").accurate is False


def test_stick_edges_of_several_zones_are_left_out_and_counted() -> None:
    """Of three sticking parts with slip between the reference states the outer ends, a result may
    state those of the middle one.
    """
    row = int(np.flatnonzero(np.isfinite(TRUTH.stick_edges[:, 0]))[-1])
    left, right = TRUTH.stick_edges[row]
    between = (left < X) & (right > X)
    outer_part = between & (np.abs(X - (left + right) / 2) > 0.3 * (right - left))
    rim = between & (np.abs(X - (left + right) / 2) > 0.45 * (right - left))
    state_of_row = np.where(outer_part & ~rim, SLIP_FORWARD, TRUTH.state[row])
    state = TRUTH.state.copy()
    state[row] = state_of_row
    stick_edges_of_middle = TRUTH.stick_edges.copy()
    stick_edges_of_middle[row] = [left + 0.2 * (right - left), right - 0.2 * (right - left)]
    of_middle = changed(stick_edges=stick_edges_of_middle)
    assert abs(compare(TRUTH, of_middle).metric("stick_edge").value) > 0.01
    metric = compare(changed(state=state), of_middle).metric("stick_edge")
    assert metric.value == 0
    assert "instants have several stick zones" in metric.note


# --------------------------------------------------------------------------------------- resultants
def weighted(angle: float, factor: float = 1.0, shear: float = 0.0) -> FiniteElementSolution:
    """Nodes whose weights make the forces of the closed form exact, on a surface that leans by
    `angle`.
    """
    fields: dict[str, Any] = dict.fromkeys(
        field.name for field in dataclasses.fields(FiniteElementSolution)
    )
    fields |= {
        field.name: getattr(TRUTH, field.name) for field in dataclasses.fields(ContactSolution)
    }
    fields |= {
        "engine": "halfplane_fe",
        "pressure": factor * TRUTH.pressure,
        "shear": shear * TRUTH.pressure,
        "face_lengths": np.full(len(X), TRUTH.normal_load[0] / TRUTH.pressure[0].sum()),
        "face_normals": np.tile([[-np.sin(angle)], [np.cos(angle)]], len(X)),
    }
    return FiniteElementSolution(**fields)


def test_resultants_are_those_of_the_results_own_weights_and_need_no_reference() -> None:
    """A pressure of resultant 1.01 P that leans by 0.1: 1.01 cos 0.1 P up and 1.01 sin 0.1 P
    sideways, less Q. Shear lifts.
    """
    comparison = compare(TRUTH, weighted(0.1, 1.01))
    assert comparison.metric("resultant_normal").value == pytest.approx(
        1.01 * np.cos(0.1) - 1, rel=1e-9
    )
    sideways = 1.01 * np.sin(0.1) - TRUTH.tangential_load / TRUTH.normal_load
    assert comparison.metric("resultant_tangential").value == pytest.approx(
        sideways.max(), rel=1e-9
    )
    assert not comparison.metric("resultant_normal").note
    lifted = 0.5 * (np.cos(0.1) - np.sin(0.1)) - 1
    for reference in (TRUTH, changed(pressure=2 * TRUTH.pressure)):
        assert compare(reference, weighted(0.1, 0.5, 0.5)).metric(
            "resultant_normal"
        ).value == pytest.approx(lifted, rel=1e-9)


# ------------------------------------------------------------------------------------- not a number
POISON = {
    "pressure": "pressure peak_pressure largest_pressure resultant_normal",
    "shear": "shear resultant_tangential",
    "slip": "slip",
    "contact_edges": "contact_edge",
    "tangential_displacement": "tangential_displacement hysteresis",
    "dissipation_density": "dissipation_density dissipation_density_peak",
    "dissipation": "dissipation",
}


@pytest.mark.parametrize("name", POISON)
def test_what_is_not_a_number_fails(name: str) -> None:
    """One NaN in the middle of the data of either: the metrics of that field are not finite and
    fail, without a tolerance too.
    """
    values = getattr(TRUTH, name)
    poisoned: Any = NAN
    if isinstance(values, np.ndarray):
        place = (17, -1) if values.shape[-1] == 2 else (len(values) // 3, len(X) // 2)
        poisoned = at(place[: values.ndim], values, new=NAN)
    bad = changed(**{name: poisoned})
    for comparison in (compare(bad, TRUTH), compare(TRUTH, bad)):
        for key in POISON[name].split():
            assert not np.isfinite(comparison.metric(key).value or 0.0), key
            assert comparison.metric(key).accurate is False, key
        assert not comparison.passed


# -------------------------------------------------------------------------------------------- units
def in_other_units(solution: ContactSolution, stress: float, length: float) -> ContactSolution:
    """The same solution in other units of stress and length."""
    force = stress * length
    energy = stress * length**2
    material = solution.scene.material
    stiffer = {
        b: m.vary(young_modulus=m.young_modulus * stress)
        for b, m in material
        if b in ("upper", "lower")
    }
    scene = solution.scene.vary(material=Materials.model_construct(**(dict(material) | stiffer)))
    factors = dict.fromkeys(("pressure", "shear"), stress) | dict.fromkeys(
        ("normal_load", "tangential_load"), force
    )
    lengths = (
        "x",
        "slip",
        "contact_edges",
        "stick_edges",
        "contact_half_width",
        "tangential_displacement",
    )
    factors |= dict.fromkeys((*lengths, "permanent_stick_half_width"), length)
    factors |= {
        "dissipation": energy,
        "dissipation_density": energy / length,
        "cycle_dissipation": energy,
    }
    if solution.tilt is not None:
        factors |= dict.fromkeys(("bulk_stress_lower", "bulk_stress_upper"), stress) | {
            "permanent_stick_edges": length
        }
        factors |= dict.fromkeys(("moment", "shear_moment"), energy)
    return with_fields(
        solution,
        scene=scene,
        **{name: factor * getattr(solution, name) for name, factor in factors.items()},
    )


STILL = changed(dissipation=0.0, dissipation_density=0 * X, slip=0 * TRUTH.slip)
UNITS = {name: (reference, plant) for name, (plant, _, _, reference) in FAULTS.items()} | {
    "nothing in the reference": (
        STILL,
        lambda: with_fields(
            STILL, dissipation=1e-3, dissipation_density=1e-3 + 0 * X, slip=1e-3 + 0 * TRUTH.slip
        ),
    )
}


@pytest.mark.parametrize(("stress", "length"), [(1e9, 1.0), (1.0, 1e9)])
def test_units_do_not_matter(stress: float, length: float) -> None:
    for name, (reference, plant) in UNITS.items():
        solution = plant()
        before = compare(reference, solution)
        after = compare(
            in_other_units(reference, stress, length), in_other_units(solution, stress, length)
        )
        absolute = [metric.key for metric in after.metrics if metric.absolute]
        assert absolute == [metric.key for metric in before.metrics if metric.absolute]
        for metric in after.metrics:
            value = before.metric(metric.key).value
            expected = (
                None if value is None else pytest.approx(value, rel=1e-9, abs=1e-12, nan_ok=True)
            )
            assert metric.value == expected, (name, metric.key)
    assert {
        "dissipation",
        "dissipation_density",
        "slip",
    } <= set(absolute)


# ----------------------------------------------------------------------------- verdict and question
def test_verdict_against_the_tolerances_of_the_scene() -> None:
    tolerance = OWN_TOLERANCES["dissipation"]
    assert compare(TRUTH, changed(dissipation=W * (1 + 0.99 * tolerance))).passed
    outside = compare(TRUTH, changed(dissipation=W * (1 - 1.01 * tolerance)))
    assert (outside.accurate, outside.admissible) == (False, True)
    assert [metric.key for metric in outside.metrics if metric.accurate is False] == ["dissipation"]
    renamed = TRUTH.scene.vary(title="renamed", name="other")
    assert compare(TRUTH, changed(scene=renamed)).passed
    solution = changed(scene=TRUTH.scene.vary(friction=0.505))
    with pytest.raises(InputError, match=r"different questions: friction is .*0\.5.* and .*0\.505"):
        compare(TRUTH, solution)


def test_scales_and_frictionless_shear() -> None:
    assert SCALES.normal_load == TRUTH.normal_load[0]
    assert SCALES.half_width == pytest.approx(1.0)
    assert SCALES.pressure == pytest.approx(TRUTH.pressure.max(), rel=1e-9)
    assert SCALES.dissipation == pytest.approx(SCALES.compliance * (0.5 * SCALES.normal_load) ** 2)
    # f = 0: a shear that should not be there still counts, over ||p||.
    smooth = changed(
        scene=TRUTH.scene.vary(friction=0.0),
        shear=0 * TRUTH.shear,
        dissipation=0.0,
        dissipation_density=0 * X,
    )
    comparison = compare(smooth, with_fields(smooth, shear=0.01 * TRUTH.pressure))
    assert comparison.metric("shear").value == pytest.approx(0.01)
    assert any("Frictionless" in note for note in comparison.notes)


def test_nothing_sticks_without_friction() -> None:
    cycle = {"initial_loading": [(50.0, 0.0)], "cycle": [(90.0, 0.0), (20.0, 0.0)]}
    scene = TRUTH.scene.vary(friction=0.0, load=cycle)
    answer = semi_analytic.solve(scene, x=X)
    metric = compare(answer, answer).metric("permanent_stick")
    assert metric.amounts is None
    assert metric.note == "frictionless: nothing sticks and nothing resists slip"


OF_BODIES = {"displacement_amplitude", "approach_amplitude"}
NAMES_OF_BULK_SERIES = {"stick_eccentricity", "bulk_work", "dissipation_drift", "moment", "tilt"}


def test_every_metric_has_its_row_in_the_table_on_the_page_and_a_planted_fault() -> None:
    comparison = compare(PULLED, PULLED, polygon_reference=PULLED)
    assert [metric.key for metric in comparison.metrics] == sorted(
        [key for key in METRICS if key not in OF_BODIES], key=lambda key: not METRICS[key].headline
    )
    assert [*comparison.headlines, *comparison.others] == list(comparison.metrics)
    plain = compare(TRUTH, TRUTH, polygon_reference=TRUTH)
    assert {metric.key for metric in comparison.metrics} - {
        metric.key for metric in plain.metrics
    } == NAMES_OF_BULK_SERIES
    assert (len(plain.headlines), len(comparison.headlines)) == (7, 8)
    assert (len(plain.metrics), len(comparison.metrics)) == (23, 28)
    unsigned = {"pressure", "shear", "state", "slip", "energy_balance"}
    assert {row.key for row in METRICS.values() if not row.signed} == unsigned
    page = (Path(__file__).parents[1] / "docs" / "metrics.md").read_text(encoding="utf-8")
    assert markdown() in page
    planted = {key for _, amounts, also, _ in FAULTS.values() for key in (*amounts, *also.split())}
    # See test_step_error_stands_apart, test_tension_at_the_trailing_edge,
    # test_displacements_of_bodies_compare_with_what_the_bodies_add.
    assert set(METRICS) - planted == {"dissipation_step", "edge_tension"} | OF_BODIES


def without(effects: BodyEffects, name: str) -> BodyEffects:
    """The effects with one number dropped."""
    return dataclasses.replace(effects, **{name: Estimate(0.0)})


@cache
def both_engines_on_blocks() -> tuple[ContactSolution, ContactSolution, BodyEffects]:
    """Theory, finite elements on a coarse mesh, and what the two blocks add to theory."""
    scene = load_scene("blocks")
    fe = fe_run(scene)
    theory = semi_analytic.solve(scene, x=fe.x, time=fe.time)
    effects = effects_between(theory, fe)
    assert effects is not None
    return theory, fe, effects


def test_displacements_of_bodies_compare_with_what_the_bodies_add() -> None:
    """Two blocks: c_t and c_n take the amplitudes to 0.3 and 0.5 % on a coarse mesh; without them
    they are half as large again and more.
    """
    theory, fe, effects = both_engines_on_blocks()
    known = compare(theory, fe, effects=effects)
    for key, limit in (
        ("tangential_displacement", 5e-3),
        ("displacement_amplitude", 4e-3),
        ("approach_amplitude", 6e-3),
    ):
        metric = known.metric(key)
        assert abs(metric.value) < limit, key
        assert metric.note == "with c_t, c_n of these bodies"
    assert any("U + c_t Q and approach + c_n P" in note for note in known.notes)
    # which solution is the reference is no matter
    turned = compare(fe, theory, effects=effects).metric("displacement_amplitude").value
    assert (1 + turned) * (1 + known.metric("displacement_amplitude").value) == pytest.approx(1)
    # The area of the loop knows no datum.
    plain = compare(theory, fe)
    area = plain.metric("hysteresis").value
    assert known.metric("hysteresis").value == pytest.approx(area, rel=1e-6)

    dropped = {
        "tangential_compliance": "displacement_amplitude",
        "normal_compliance": "approach_amplitude",
    }
    for name, key in dropped.items():
        assert abs(compare(theory, fe, effects=without(effects, name)).metric(key).value) > 0.2

    assert not OF_BODIES & {metric.key for metric in plain.metrics}
    assert plain.metric("tangential_displacement").value is None
    assert plain.metric("tangential_displacement").note.startswith("no datum")
    assert any(note.startswith("No datum") for note in plain.notes)
    # of finite elements with each other, and of corrected theory, there is nothing to add
    assert effects_between(fe, fe) is None
    corrected = semi_analytic.solve(fe.scene, x=fe.x, time=fe.time, effects=effects)
    own_datum = compare(corrected, fe, effects=effects)
    assert own_datum.effects is None
    assert abs(own_datum.metric("tangential_displacement").value) < 5e-3
    # its largest values are its own, and not those of half-planes
    amounts = own_datum.metric("largest_pressure").amounts
    assert amounts[0] == own_datum.reference_cycle.pressure.max()
    assert own_datum.metric("edge_tension").value is None
    assert compare(theory, corrected).metric("edge_tension").value is None


def loop_of(comparison: Comparison) -> Plate:
    """The loop of Q over U."""
    return {plate.name: plate for plate in draw(Report(comparison))}["hysteresis"]


def test_the_loop_on_the_page_says_what_half_planes_count_from() -> None:
    theory, fe, effects = both_engines_on_blocks()
    known = loop_of(compare(theory, fe, effects=effects))
    assert "that of half-planes with c_t, c_n of these bodies" in known.caption
    unknown = loop_of(compare(theory, fe))
    assert "no datum: that of half-planes" in unknown.caption
    # Without a datum the difference of U is the distance of two places.
    for plate, loops_with_numbers in ((known, ["stroke", "width"]), (unknown, ["width"])):
        notes = [note for panel in plate.panels for note in panel.notes]
        assert [note.rpartition(" ")[2] for note in notes] == loops_with_numbers


def test_bodies_whose_compliance_is_not_known_have_no_datum() -> None:
    scene = load_scene("two-cylinders")
    theory = semi_analytic.solve(scene, x=[0.0], time=[1.0])
    assert effects_between(theory, dataclasses.replace(theory, engine="halfplane_fe")) is None


# ---------------------------------------------------------------------------------- laws of contact
LAWS = {
    "none": (lambda: TRUTH, set()),
    "tension": (
        lambda: changed(pressure=at((5, 0), TRUTH.pressure, new=-1e-6 * TRUTH.pressure.max())),
        {"tension (fields)"},
    ),
    "cone": (lambda: changed(shear=1.0001 * TRUTH.shear), {"cone (fields)", "slip (fields)"}),
    "cone, negative shear": (
        lambda: changed(shear=np.where(TRUTH.shear < 0, 1.0001, 1.0) * TRUTH.shear),
        {"cone (fields)", "slip (fields)"},
    ),
    "slip short of friction": (lambda: changed(shear=0.9999 * TRUTH.shear), {"slip (fields)"}),
    "slip with friction": (swapped, {"slip (fields)"}),
    "loads": (lambda: changed(tangential_load=TRUTH.tangential_load + 1e-6), {"loads (fields)"}),
    "record": (lambda: recorded(1e-6), {"energy balance (record)"}),
    "record of no number": (lambda: recorded(NAN), {"energy balance (record)"}),
}


@pytest.mark.parametrize("law", LAWS)
def test_each_law_broken_is_seen_by_its_own_certificate(law: str) -> None:
    plant, broken = LAWS[law]
    comparison = compare(TRUTH, plant())
    failed = {
        check.label: check.time for check in comparison.result_certificates if not check.holds
    }
    assert set(failed) == broken or (law == "tension" and broken <= set(failed))
    assert comparison.passed is (law == "none")
    if "record" in law:
        assert failed == {"energy balance (record)": TIME[9]}
        assert comparison.accurate is (law == "record")


# --------------------------------------- one solution on the points and instants of another; events
ROUGH = cattaneo_mindlin(steps_per_leg=20, points=81)
FINE = cattaneo_mindlin(steps_per_leg=40, points=321)


def test_stated_interpolation_error_is_honest() -> None:
    """The truth is known here: of 107 spacings, the edge falling anywhere in an interval, one in a
    hundred at most errs by more.
    """
    like = last_cycle(ROUGH)
    smaller = 0
    for points in range(100, 420, 3):
        sampled = interpolated_cycle(
            last_cycle(cattaneo_mindlin(steps_per_leg=20, points=points)), like, "closed form"
        )
        if sampled.interpolation_errors:
            error = np.max(np.abs(sampled.pressure - like.pressure)) / np.max(like.pressure)
            smaller += error > sampled.interpolation_errors["pressure"]
    assert smaller <= 1


def test_interpolation_in_time_and_space_is_said() -> None:
    comparison = compare(cattaneo_mindlin(steps_per_leg=31, points=150), ROUGH)
    for name in ("pressure", "shear"):
        truth = getattr(ROUGH, name)
        error = np.max(np.abs(getattr(comparison.reference_cycle, name) - truth)) / np.max(
            np.abs(truth)
        )
        assert 0 < error <= comparison.reference_cycle.interpolation_errors[name] < 0.5
    assert any("was interpolated" in note for note in comparison.notes)


@pytest.mark.parametrize("fields", [("pressure", "shear"), semi_analytic.FIELDS])
def test_a_cycle_that_does_not_repeat_is_said_whatever_fields_a_solution_has(
    fields: tuple[str, ...],
) -> None:
    """An external result, of which nobody knows it, says nothing."""
    once = load_scene("hertz-paper").vary(expected=(), tolerances={}, cycles=1)
    theory = semi_analytic.solve(once, x=np.linspace(-1.2, 1.2, 21), fields=fields)
    read_from_file = dataclasses.replace(
        theory, engine="some code", settings={**theory.settings, "source": "result.csv"}
    )
    notes = [note for note in compare(theory, read_from_file).notes if "no cycle repeats" in note]
    assert [note.partition(":")[0] for note in notes] == ["half-plane theory"]


def test_instants_are_matched_by_phase_not_by_revolution() -> None:
    """The same cycle one revolution later: nothing to interpolate, nothing to tell apart. Less than
    a cycle is refused.
    """
    comparison = compare(ROUGH, with_fields(ROUGH, time=ROUGH.time + 3.0))
    assert not comparison.reference_cycle.interpolation_errors
    assert not any("interpolated" in note for note in comparison.notes)
    assert all(not metric.value for metric in comparison.metrics)
    names = (
        "pressure",
        "shear",
        "slip",
        "state",
        "contact_edges",
        "stick_edges",
        "normal_load",
        "tangential_load",
    )
    names += (
        "contact_half_width",
        "stick_half_width",
        "tangential_displacement",
        "normal_approach",
        "time",
    )
    with pytest.raises(InputError, match="holds no whole cycle"):
        compare(ROUGH, with_fields(ROUGH, **{name: getattr(ROUGH, name)[:1] for name in names}))


@pytest.mark.parametrize("least", [0.4, 0.0])
def test_a_reference_that_ends_inside_the_contact_is_refused(least: float) -> None:
    """Far inside, and at the last point that carries anything: 7 % of the largest pressure."""
    largest = FINE.pressure.max(axis=0)
    inner = largest > least * largest.max()
    assert least < largest[inner][0] / largest.max() < least + 0.1
    cut = {name: getattr(FINE, name)[:, inner] for name in ("pressure", "shear", "slip", "state")}
    short = with_fields(
        FINE, x=FINE.x[inner], dissipation_density=FINE.dissipation_density[inner], **cut
    )
    with pytest.raises(InputError, match="still carries pressure"):
        compare(short, ROUGH)


def test_events_of_a_cycle_under_constant_pressure_are_spread_over_time_not_over_increments() -> (
    None
):
    """P stands still: only Q has extremes; the rest of the six are as far from all others as can
    be, wherever an engine landed.
    """
    cycle = last_cycle(ROUGH)
    marked = events(cycle, ROUGH.scene.friction.coefficient)
    labels = {event.label: cycle.time[event.index] for event in marked}
    assert (len(marked), labels["Q largest"], labels["Q least"]) == (6, 2.0, 3.0)
    assert not any(label.startswith("P ") for label in labels)
    assert [event.index for event in marked] == sorted({event.index for event in marked})
    # Nine tenths of the instants in the first hundredth of the cycle.
    time = np.concatenate(
        [
            np.linspace(0, 0.01, 9 * len(cycle.time) * 2),
            np.linspace(0.01, 1, 2 * len(cycle.time) + 1)[1:],
        ]
    )
    flat = np.ones(len(time))
    crowded = dataclasses.replace(
        cycle, time=time, fraction=time, normal_load=flat, tangential_load=0 * flat
    )
    chosen = [time[event.index] for event in events(crowded, 0.5)]
    assert (len(chosen), min(np.diff(chosen)) > 0.1) == (6, True)


def test_events_of_a_record_are_its_rows() -> None:
    """The path leads from no load to the first row: no row has P = 0."""
    rows = [[0.0, 3.0, 0.0], [1.0, 4.0, 1.0], [2.0, 2.0, -0.5], [3.0, 3.0, 0.5]]
    scene = ROUGH.scene.vary(load={"kind": "time_series", "rows": rows})
    answer = semi_analytic.solve(scene)
    cycle = last_cycle(answer)
    assert cycle.normal_load[0] == 0
    first = index_of_first_row(cycle, scene)
    marked = events(cycle, scene.friction.coefficient, first)
    labels = {event.label: cycle.normal_load[event.index] for event in marked}
    assert (labels["P least"], labels["P largest"]) == (2.0, 4.0)
    assert min(event.index for event in marked) >= first > 0
    assert index_of_first_row(last_cycle(ROUGH), ROUGH.scene) == 0


def test_events_of_the_papers_ellipse() -> None:
    """H, the largest P, the largest Q, E (forward slip ends at 5/8), the least P, G (reverse slip
    ends at 7/8).
    """
    scene = load_scene("hertz-paper")
    path = scene.load.path()
    time = path.cycle_start + np.linspace(0, 2 * np.pi, 81)
    normal, tangential = path.at(time)
    steps = {"time": time, "normal_load": normal, "tangential_load": tangential}
    blank = {name: np.zeros((81, 81)) for name in ("pressure", "shear", "slip")}
    edges = {name: np.zeros((81, 2)) for name in ("contact_edges", "stick_edges")}
    series = {name: np.zeros(81) for name in ("tangential_displacement", "normal_approach")}
    state = np.zeros((81, 81), np.int8)
    cycle = last_cycle(
        with_fields(ROUGH, scene=scene, state=state, **steps, **blank, **edges, **series)
    )
    marked = events(cycle, 1.0)
    labels = [
        "Q least",
        "P largest",
        "Q largest",
        "forward slip ends",
        "P least",
        "reverse slip ends",
    ]
    assert [event.label for event in marked] == labels
    assert cycle.fraction[[event.index for event in marked]] == pytest.approx(
        [0, 0.25, 0.5, 0.625, 0.75, 0.875]
    )


# ------------------------------------------------------------------------------------- real answers
def test_a_contact_that_dissipates_nothing_or_is_only_pressed_has_fewer_figures(
    tmp_path: Path,
) -> None:
    """No loop, no work, no cycle; and instants too light to be judged, which is said."""
    stuck, pressed = (
        compare(solution, solution)
        for solution in map(semi_analytic.solve, ("full-stick", "hertz-normal"))
    )
    assert (stuck.metric("dissipation").absolute, stuck.metric("dissipation").value) == (True, 0)
    assert not stuck.metric("stick_edge").note
    drawn = {drawing.name for drawing in draw(Report(stuck))}
    fewer = {drawing.name for drawing in draw(Report(pressed))}
    assert {"tractions", "hysteresis"} <= drawn - {"dissipation_density"} == drawn
    assert not {"hysteresis", "dissipation_density"} & fewer
    page = write(pressed, tmp_path / "out").read_text(encoding="utf-8")
    assert "Nothing slips under load" in page
    assert "less than 0.1 P<sub>ref</sub>" in page


def test_report_of_both_engines_its_fields_when_asked_and_its_stored_solutions(
    tmp_path: Path,
) -> None:
    """Values of ten comparisons are frozen in test_contract.py; limits of each metric stand in
    test_halfplane_fe_accuracy.py.
    """
    fe = fe_run(load_scene("hertz-paper"), COARSE, FEW_STEPS)
    out = tmp_path / "out"
    exact, polygon = (
        semi_analytic.solve(fe.scene, x=fe.x, time=fe.time, straight_steps=straight)
        for straight in (False, True)
    )
    paper = compare(exact, fe, polygon_reference=polygon)
    total, fresh_solver, step = (
        paper.metric(f"dissipation{part}").value for part in ("", "_polygon", "_step")
    )
    assert (1 + step) * (1 + fresh_solver) == pytest.approx(1 + total, rel=1e-13)
    page = write(
        paper,
        out,
        command="halfplane run hertz-paper",
        vtu_instants=paper.result_cycle.time[[0, 5]],
    )
    assert {"mesh.csv"} <= {path.name for path in (out / "figures").iterdir()}
    names = {path.name for path in (out / "fields").iterdir()}
    assert names == {
        "fields.pvd",
        *(
            f"{part}_{number:03d}.vtu"
            for part in ("lower", "upper", "contact")
            for number in (0, 1)
        ),
    }
    assert page.stat().st_size < 8e6
    assert f"All metrics ({len(paper.metrics)})" in page.read_text(encoding="utf-8")
    stored = json.loads((out / "comparison.json").read_text(encoding="utf-8"))
    assert stored["result"]["skipped"]["condensations"]["count"] == 1
    assert stored["result"]["versions"]["numpy"] == np.__version__
    reference, solution = (
        ContactSolution.load(out / f"{name}.nc") for name in ("reference", "result")
    )
    comparison = compare(reference, solution, polygon_reference=polygon)
    # The file holds no nodal weights, so the resultants of what was stored go by another rule,
    # which they say.
    by_weights = {"resultant_normal", "resultant_tangential"}
    for metric, fresh in zip(comparison.metrics, paper.metrics, strict=True):
        assert metric.value == fresh.value or fresh.key in by_weights, fresh.key
    assert all("states no weights" in comparison.metric(key).note for key in by_weights)
    with pytest.raises(InputError, match="semi_analytic has no bodies"):
        write(compare(exact, exact), tmp_path / "none", vtu_instants=[exact.time[0]])
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize("repeats", [False, True])
def test_no_instant_before_the_first_row_of_a_record_is_judged(repeats: bool) -> None:
    """Rows that start loaded are reached from P = Q = 0 on a line that nobody measured. Here the
    result errs most on that line; of a record that repeats the last cycle holds none of it.
    """
    rows = [(1.0, 90.0, 10.0), (2.0, 100.0, 30.0), (3.0, 80.0, -10.0), (4.0, 90.0, 10.0)]
    scene = load_scene("cattaneo-mindlin").vary(load=TimeSeriesLoad(rows=rows, repeats=repeats))
    exact = semi_analytic.solve(scene)
    factor = np.where(exact.time < 1 - 1e-9, 1.2, 1.01)[:, None]
    comparison = compare(exact, dataclasses.replace(exact, pressure=factor * exact.pressure))
    assert comparison.metric("pressure").value == pytest.approx(0.01)
    assert comparison.metric("pressure").time >= 1 - 1e-9
