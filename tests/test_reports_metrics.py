"""Each metric sees its own planted fault, in the right amount, and no other metric sees it."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from reports import compare
from scenes import ContactSolution, InputError, SurfaceState
from scenes.scene import OWN_TOLERANCES
from test_reports_synthetic import LOAD_RATIO, cattaneo_mindlin, with_fields

TRUTH = cattaneo_mindlin()
KEYS = tuple(metric.key for metric in compare(TRUTH, TRUTH, polygon_reference=TRUTH).metrics)
# The contact never sticks throughout and the closed form keeps no energies: these say so in words.
EMPTY = {"full_stick_start", "full_stick_end", "energy_balance"}

# What the closed form itself leaves of a metric that should be 0.
ROUNDING = 1e-12


def shifted_edges(edges: np.ndarray, left: float, right: float) -> np.ndarray:
    return edges + np.array([left, right])


def changed(**fields: Any) -> ContactSolution:
    return with_fields(TRUTH, **fields)


def one_instant(values: np.ndarray, step: int, factor: float) -> np.ndarray:
    scaled = values.copy()
    scaled[step] *= factor
    return scaled


def swapped_state() -> ContactSolution:
    """Forward and reverse slip exchanged: the share of the contact that slips, in the mean over the cycle, is wrong."""
    forward, reverse = (TRUTH.state == s for s in (SurfaceState.SLIP_FORWARD, SurfaceState.SLIP_REVERSE))
    return changed(state=np.where(forward, 3, np.where(reverse, 2, TRUTH.state)).astype(np.int8))


def slipping_share() -> float:
    """Mean over the cycle of the slipping share of the contact."""
    slips = TRUTH.state >= SurfaceState.SLIP_FORWARD
    share = slips.sum(axis=1) / (TRUTH.state != SurfaceState.OPEN).sum(axis=1)
    return float(np.trapezoid(share, TRUTH.time) / 3)


def shear_norm(step: int) -> float:
    """||q||/(f ||p||) of an instant, by plain sums (even spacing)."""
    f = TRUTH.scene.friction.coefficient
    return float(np.sqrt((TRUTH.shear[step] ** 2).sum() / (TRUTH.pressure[step] ** 2).sum()) / f)


def between_reversals() -> float:
    """From the first reverse slip after time 2 (Q largest) to the first forward slip after 3 (Q least), over the period of 3."""
    to_reverse = np.flatnonzero((TRUTH.time > 2) & (TRUTH.state == SurfaceState.SLIP_REVERSE).any(axis=1))[0]
    to_forward = np.flatnonzero((TRUTH.time > 3) & (TRUTH.state == SurfaceState.SLIP_FORWARD).any(axis=1))[0]
    return float(TRUTH.time[to_forward] - TRUTH.time[to_reverse]) / 3


def by_rule(values: np.ndarray, step: int) -> float:
    """int values dx / P of an instant by the trapezoidal rule, on points that are evenly spaced and carry nothing at their ends."""
    return float(values[step].sum() * (TRUTH.x[1] - TRUTH.x[0]) / TRUTH.normal_load[step])


def largest_shear(step: int) -> float:
    """The q of largest size of an instant over f max p."""
    q, f = TRUTH.shear[step], TRUTH.scene.friction.coefficient
    return float(q[np.argmax(np.abs(q))] / (f * TRUTH.pressure[step].max()))


STROKE = float(np.ptp(TRUTH.tangential_displacement))
W = TRUTH.dissipation
W_SCALE = compare(TRUTH, TRUTH).scales.dissipation
# An instant soon after Q turned at its largest, when q has both signs, and one on the way up.
AFTER_TURN, ON_THE_WAY = 50, 30

# fault -> (solution, metric -> value); every metric that is not named must be 0, or have nothing to compare before and after.
FAULTS: dict[str, tuple[Callable[[], ContactSolution], dict[str, float]]] = {
    "none": (lambda: TRUTH, {}),
    "pressure 1 % high": (
        lambda: changed(pressure=1.01 * TRUTH.pressure),
        {
            "largest_pressure": 0.01,
            "peak_pressure": 0.01,
            "pressure": 0.01,
            "pressure_maximum": 0.01,
            "resultant_normal": 0.01 * by_rule(TRUTH.pressure, 0),
        },
    ),
    "pressure 1 % low at one instant": (
        lambda: changed(pressure=one_instant(TRUTH.pressure, 17, 0.99)),
        {
            "peak_pressure": -0.01,
            "pressure": 0.01,
            "pressure_maximum": -0.01,
            "resultant_normal": -0.01 * by_rule(TRUTH.pressure, 17),
        },
    ),
    "shear flipped at one instant": (
        lambda: changed(shear=one_instant(TRUTH.shear, AFTER_TURN, -1)),
        {
            "shear": 2 * shear_norm(AFTER_TURN),
            "shear_maximum": -2 * largest_shear(AFTER_TURN),
            "resultant_tangential": -2 * by_rule(TRUTH.shear, AFTER_TURN),
        },
    ),
    "shear 1 % high at one instant": (
        lambda: changed(shear=one_instant(TRUTH.shear, ON_THE_WAY, 1.01)),
        {
            "shear": 0.01 * shear_norm(ON_THE_WAY),
            "shear_maximum": 0.01 * largest_shear(ON_THE_WAY),
            "peak_shear": 0.01 * abs(largest_shear(ON_THE_WAY)),
            "resultant_tangential": 0.01 * by_rule(TRUTH.shear, ON_THE_WAY),
        },
    ),
    "right contact edge 0.02 a out": (
        lambda: changed(contact_edges=shifted_edges(TRUTH.contact_edges, 0, 0.02)),
        {"largest_half_width": 0.01, "contact_edge": 0.02, "contact_edge_right": 0.02},
    ),
    "left contact edge 0.02 a in": (
        lambda: changed(contact_edges=shifted_edges(TRUTH.contact_edges, 0.02, 0)),
        {"largest_half_width": -0.01, "contact_edge": -0.02, "contact_edge_left": -0.02},
    ),
    "left stick edge 0.01 a out": (
        lambda: changed(stick_edges=shifted_edges(TRUTH.stick_edges, -0.01, 0)),
        {"stick_edge": 0.01, "stick_edge_left": 0.01},
    ),
    "right stick edge 0.03 a in": (
        lambda: changed(stick_edges=shifted_edges(TRUTH.stick_edges, 0, -0.03)),
        {"stick_edge": -0.03, "stick_edge_right": -0.03},
    ),
    # Each reversal is where the other one was: the one to reverse is late by their distance, the one to forward early.
    "forward and reverse exchanged": (swapped_state, {"state": slipping_share(), "slip_reversal": -between_reversals()}),
    "tangential displacement off by a constant": (
        lambda: changed(tangential_displacement=TRUTH.tangential_displacement + 0.04 * STROKE),
        {"tangential_displacement": 0.04},
    ),
    "dissipation 1 % low": (
        lambda: changed(dissipation=0.99 * W),
        {"dissipation": -0.01, "dissipation_polygon": -0.01, "dissipation_absolute": -0.01 * W / W_SCALE},
    ),
    "dissipation density 5 % high": (
        lambda: changed(dissipation_density=1.05 * TRUTH.dissipation_density),
        {"dissipation_density": 0.05, "dissipation_density_norm": 0.05, "dissipation_density_peak": 0.05},
    ),
    "permanent stick 0.01 a too small": (
        lambda: changed(permanent_stick_half_width=TRUTH.permanent_stick_half_width - 0.01),
        {"permanent_stick": -0.01},
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_fault_is_seen_by_its_metrics_alone(fault: str) -> None:
    plant, expected = FAULTS[fault]
    found = compare(TRUTH, plant(), polygon_reference=TRUTH)
    assert set(expected) <= set(KEYS)
    for metric in found.metrics:
        if metric.key in EMPTY:
            assert metric.value is None, metric.key
        else:
            assert metric.value == pytest.approx(expected.get(metric.key, 0.0), rel=1e-9, abs=ROUNDING), metric.key


def test_worst_instant_is_named() -> None:
    found = compare(TRUTH, FAULTS["pressure 1 % low at one instant"][0]())
    assert found.metric("peak_pressure").time == TRUTH.time[17]


def test_step_error_stands_apart() -> None:
    """The polygon's answer 3 % off the smooth one, the result 1 % off the polygon's."""
    polygon, result = changed(dissipation=1.03 * W), changed(dissipation=1.03 * 1.01 * W)
    found = compare(TRUTH, result, polygon_reference=polygon)
    assert found.metric("dissipation_step").value == pytest.approx(0.03)
    assert found.metric("dissipation_polygon").value == pytest.approx(0.01)
    assert found.metric("dissipation").value == pytest.approx(0.0403)
    assert "dissipation_polygon" not in {metric.key for metric in compare(TRUTH, result).metrics}


def test_hysteresis_sees_the_loop_and_not_the_dissipation() -> None:
    found = compare(TRUTH, changed(tangential_displacement=1.02 * TRUTH.tangential_displacement))
    assert found.metric("hysteresis").value == pytest.approx(0.02)
    assert found.metric("dissipation").value == 0.0


def test_peak_is_not_biased_by_where_the_points_lie() -> None:
    """Points that miss the true peak by half a spacing: reference and result miss it alike."""
    x = TRUTH.x[:-1] + np.diff(TRUTH.x) / 2
    middle = {name: (getattr(TRUTH, name)[:, 1:] + getattr(TRUTH, name)[:, :-1]) / 2 for name in ("pressure", "shear", "slip")}
    off = changed(x=x, state=TRUTH.state[:, :-1], dissipation_density=TRUTH.dissipation_density[:-1], **middle)
    assert off.pressure.max() < TRUTH.pressure.max()
    assert compare(TRUTH, off).metric("peak_pressure").value == pytest.approx(0.0, abs=ROUNDING)


@pytest.mark.parametrize("field", ["pressure", "shear", "contact_edges", "dissipation"])
def test_not_a_number_fails(field: str) -> None:
    """A NaN anywhere in the data must come out as a failed metric, never as one that was left out."""
    value = getattr(TRUTH, field)
    poisoned: Any = float("nan")
    if isinstance(value, np.ndarray):
        poisoned = value.copy()
        poisoned[17, -1] = np.nan
    found = compare(TRUTH, changed(**{field: poisoned}))
    failed = {metric.key for metric in found.metrics if metric.accurate is False}
    expected = {"contact_edges": "contact_edge"}.get(field, field)
    assert expected in failed
    assert not found.passed


def test_verdict_against_the_tolerances_of_the_scene() -> None:
    tolerance = OWN_TOLERANCES["dissipation"]
    assert compare(TRUTH, changed(dissipation=W * (1 + 0.99 * tolerance))).passed
    outside = compare(TRUTH, changed(dissipation=W * (1 - 1.01 * tolerance)))
    assert not outside.accurate
    assert outside.admissible
    assert [metric.key for metric in outside.metrics if metric.accurate is False] == ["dissipation"]


def test_without_dissipation_the_discrepancy_is_absolute() -> None:
    still = changed(dissipation=0.0)
    found = compare(still, changed(dissipation=1e-3)).metric("dissipation")
    scales = compare(still, still).scales
    assert found.absolute
    assert found.value == pytest.approx(1e-3 / scales.dissipation)
    assert "dissipates nothing" in found.note


def test_frictionless_shear_is_measured_over_pressure() -> None:
    """f = 0: a shear that should not be there still counts, over ||p||."""
    scene = TRUTH.scene.vary(friction=0.0)
    still = changed(scene=scene, shear=0 * TRUTH.shear, dissipation=0.0, dissipation_density=0 * TRUTH.x)
    found = compare(still, with_fields(still, shear=0.01 * TRUTH.pressure))
    assert found.metric("shear").value == pytest.approx(0.01)
    assert any("Frictionless" in note for note in found.notes)


def test_scales() -> None:
    scales = compare(TRUTH, TRUTH).scales
    assert scales.normal_load == TRUTH.normal_load[0]
    assert scales.half_width == pytest.approx(1.0)
    assert scales.pressure == pytest.approx(TRUTH.pressure.max(), rel=1e-9)
    assert scales.dissipation == pytest.approx(scales.compliance * (0.5 * scales.normal_load) ** 2)


class TestStickEdges:
    """Full stick, partial slip and full slip are not the same thing with different numbers."""

    def test_full_slip_in_both_is_nothing_to_compare(self) -> None:
        edges = TRUTH.stick_edges.copy()
        edges[40] = np.nan
        both = changed(stick_edges=edges)
        metric = compare(both, both).metric("stick_edge")
        assert metric.value == 0.0
        assert not metric.note

    def test_full_slip_in_one_is_counted(self) -> None:
        edges = TRUTH.stick_edges.copy()
        edges[40:43] = np.nan
        metric = compare(TRUTH, changed(stick_edges=edges)).metric("stick_edge")
        assert metric.value == 0.0
        assert metric.note.startswith(f"3 of {len(TRUTH.time)} instants differ")

    def test_never_a_stick_edge_in_one_fails(self) -> None:
        metric = compare(TRUTH, changed(stick_edges=np.full_like(TRUTH.stick_edges, np.nan))).metric("stick_edge")
        assert metric.accurate is False

    def test_full_stick_against_partial_slip_is_an_error_of_the_edge(self) -> None:
        """At the end of the way down the stick edge is at sqrt(0.4); full stick would put it at 1."""
        edges = TRUTH.stick_edges.copy()
        step = int(np.argmin(TRUTH.stick_half_width))
        edges[step] = TRUTH.contact_edges[step]
        metric = compare(TRUTH, changed(stick_edges=edges)).metric("stick_edge")
        assert metric.value == pytest.approx(1 - np.sqrt(1 - LOAD_RATIO))
        assert metric.note.startswith(f"1 of {len(TRUTH.time)} instants differ")

    def test_in_elements(self) -> None:
        wide = changed(stick_edges=shifted_edges(TRUTH.stick_edges, 0, 0.01), settings={"element_size": 0.02})
        assert compare(TRUTH, wide).metric("stick_edge").elements == pytest.approx(0.5)
        assert compare(TRUTH, TRUTH).metric("stick_edge").elements is None


def test_light_instants_are_shown_and_not_judged() -> None:
    """An instant at 5 % of P_ref with half its pressure missing: in the series, not in the verdict, and said so."""
    load = TRUTH.normal_load.copy()
    load[17] *= 0.05
    light = changed(normal_load=load)
    found = compare(light, with_fields(light, pressure=one_instant(TRUTH.pressure, 17, 0.5)))
    metric = found.metric("pressure")
    assert metric.value == 0.0
    assert metric.series is not None
    assert metric.series[17] == pytest.approx(0.5)
    assert any("1 of 121 instants carry less than 0.1 P_ref" in note for note in found.notes)


def test_no_permanent_stick_in_one_is_said() -> None:
    metric = compare(TRUTH, changed(permanent_stick_half_width=float("nan"))).metric("permanent_stick")
    assert metric.value is None
    assert metric.note == "none in closed form"


def test_another_question_is_refused() -> None:
    friction = TRUTH.scene.friction.vary(coefficient=0.505)
    other = changed(scene=TRUTH.scene.vary(friction=friction))
    with pytest.raises(InputError, match=r"different questions: friction is .*0\.5.* and .*0\.505"):
        compare(TRUTH, other)


def test_another_title_or_tolerance_is_the_same_question() -> None:
    renamed = TRUTH.scene.vary(title="renamed", name="other")
    assert compare(TRUTH, changed(scene=renamed)).passed
