"""Each metric sees its own planted fault, in the right amount, and no other metric sees it."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from reports import compare
from scenes import ContactSolution, InputError, SurfaceState, freeze
from test_reports_synthetic import LOAD_RATIO, cattaneo_mindlin, with_fields

TRUTH = cattaneo_mindlin()
KEYS = tuple(metric.key for metric in compare(TRUTH, TRUTH, polygon_reference=TRUTH).metrics)
LAST = len(TRUTH.time) - 1

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


def shear_norm() -> float:
    """Largest ||q||/(f ||p||) of the cycle, by plain sums (even spacing)."""
    f = TRUTH.scene.friction.coefficient
    return float(np.max(np.sqrt((TRUTH.shear**2).sum(1) / (TRUTH.pressure**2).sum(1)) / f))


STROKE = float(np.ptp(TRUTH.rigid_shift))
W = TRUTH.dissipation

# fault -> (solution, metric -> value); every metric that is not named must be 0.
FAULTS: dict[str, tuple[Callable[[], ContactSolution], dict[str, float]]] = {
    "none": (lambda: TRUTH, {}),
    "pressure 1 % high": (
        lambda: changed(pressure=1.01 * TRUTH.pressure),
        {"peak_pressure": 0.01, "pressure": 0.01},
    ),
    "pressure 1 % low at one instant": (
        lambda: changed(pressure=one_instant(TRUTH.pressure, 17, 0.99)),
        {"peak_pressure": -0.01, "pressure": 0.01},
    ),
    "shear flipped": (lambda: changed(shear=-TRUTH.shear), {"shear": 2 * shear_norm()}),
    "shear 1 % high": (lambda: changed(shear=1.01 * TRUTH.shear), {"shear": 0.01 * shear_norm()}),
    "right contact edge 0.02 a out": (
        lambda: changed(contact_edges=shifted_edges(TRUTH.contact_edges, 0, 0.02)),
        {"contact_edge": 0.02},
    ),
    "left stick edge 0.01 a out": (
        lambda: changed(stick_edges=shifted_edges(TRUTH.stick_edges, -0.01, 0)),
        {"stick_edge": 0.01},
    ),
    "right stick edge 0.03 a in": (
        lambda: changed(stick_edges=shifted_edges(TRUTH.stick_edges, 0, -0.03)),
        {"stick_edge": -0.03},
    ),
    "forward and reverse exchanged": (swapped_state, {"state": slipping_share()}),
    "rigid shift off by a constant": (
        lambda: changed(rigid_shift=TRUTH.rigid_shift + 0.04 * STROKE),
        {"rigid_shift": 0.04},
    ),
    "dissipation 1 % low": (
        lambda: changed(dissipation=0.99 * W),
        {"dissipation": -0.01, "dissipation_polygon": -0.01},
    ),
    "dissipation density 5 % high": (
        lambda: changed(dissipation_density=1.05 * TRUTH.dissipation_density),
        {"dissipation_density": 0.05},
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
    found = compare(TRUTH, changed(rigid_shift=1.02 * TRUTH.rigid_shift))
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
    tolerance = TRUTH.scene.tolerances.dissipation
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
    scene = TRUTH.scene.model_copy(update={"friction": TRUTH.scene.friction.model_copy(update={"coefficient": 0.0})})
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
    friction = TRUTH.scene.friction.model_copy(update={"coefficient": 0.505})
    other = changed(scene=TRUTH.scene.model_copy(update={"friction": friction}))
    with pytest.raises(InputError, match=r"different questions: friction is .*0\.5.* and .*0\.505"):
        compare(TRUTH, other)


def test_another_title_or_tolerance_is_the_same_question() -> None:
    renamed = TRUTH.scene.model_copy(update={"title": "renamed", "name": "other"})
    assert compare(TRUTH, changed(scene=renamed)).passed


class TestCertificates:
    """Each law, broken by hand, is seen by its own certificate."""

    def names(self, **fields: Any) -> set[str]:
        return {check.label for check in compare(TRUTH, changed(**fields)).result_certificates if not check.holds}

    def test_none_broken(self) -> None:
        assert self.names() == set()

    def test_tension(self) -> None:
        pressure = TRUTH.pressure.copy()
        pressure[5, 0] = -1e-6 * pressure.max()
        assert "tension (fields)" in self.names(pressure=pressure)

    def test_cone(self) -> None:
        assert self.names(shear=1.0001 * TRUTH.shear) == {"cone (fields)", "slip (fields)"}

    def test_cone_on_the_side_of_negative_shear(self) -> None:
        outside = np.where(TRUTH.shear < 0, 1.0001, 1.0) * TRUTH.shear
        assert "cone (fields)" in self.names(shear=outside)

    def test_slip_short_of_friction(self) -> None:
        assert self.names(shear=0.9999 * TRUTH.shear) == {"slip (fields)"}

    def test_slip_with_friction_instead_of_against_it(self) -> None:
        assert self.names(state=swapped_state().state) == {"slip (fields)"}

    def test_loads(self) -> None:
        assert self.names(tangential_load=TRUTH.tangential_load + 1e-6) == {"loads (fields)"}

    @pytest.mark.parametrize("value", [1e-6, float("nan")])
    def test_record(self, value: float) -> None:
        series = np.zeros(len(TRUTH.time))
        series[9] = value
        record = type(TRUTH.record)(
            True, "steady", "", freeze(np.ones(len(TRUTH.time)), np.int64), {"energy_balance": freeze(series)}
        )
        found = compare(TRUTH, changed(record=record))
        broken = [check for check in found.result_certificates if not check.holds]
        assert [(check.label, check.time) for check in broken] == [("energy balance (record)", TRUTH.time[9])]
        assert found.accurate
        assert not found.passed
