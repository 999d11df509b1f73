"""The metrics of the second table: planted differences whose size is known by hand, signs, units, and what does not apply."""

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import semi_analytic
from reports import compare
from reports.comparison import Comparison
from reports.comparison.content import as_json
from reports.comparison.metrics import METRICS, markdown
from reports.comparison.words import unit_of
from scenes import ContactSolution, Materials, Record, freeze, load_scene
from test_reports_metrics import FAULTS, TRUTH, changed
from test_reports_synthetic import with_fields

SPACING = float(TRUTH.x[1] - TRUTH.x[0])
STEPS = len(TRUTH.time) - 1


def seen(found: Comparison) -> set[str]:
    """The metrics that are not 0."""
    return {metric.key for metric in found.metrics if metric.value is not None and not abs(metric.value) < 1e-12}


def value(reference: ContactSolution, result: ContactSolution, key: str) -> float:
    found = compare(reference, result).metric(key).value
    assert found is not None
    return found


class TestPlaces:
    @pytest.mark.parametrize("points", [-3, 4])
    def test_pressure_moved_sideways(self, points: int) -> None:
        """By whole points, so that the peak is as high as before and nothing but its place and what follows from it differs."""
        found = compare(TRUTH, changed(pressure=np.roll(TRUTH.pressure, points, axis=1)))
        metric = found.metric("pressure_peak_place")
        assert metric.value == pytest.approx(points * SPACING, rel=1e-9)
        assert metric.place == pytest.approx(points * SPACING, rel=1e-9)
        assert metric.uncertainty == pytest.approx(SPACING, rel=1e-9)
        assert seen(found) == {"pressure", "pressure_maximum", "pressure_peak_place"}

    def test_place_of_the_worst_pressure(self) -> None:
        planted = TRUTH.pressure.copy()
        planted[33, 50] -= 0.07 * planted[33].max()
        metric = compare(TRUTH, changed(pressure=planted)).metric("pressure_maximum")
        assert (metric.value, metric.time, metric.place) == pytest.approx((-0.07, TRUTH.time[33], TRUTH.x[50]))

    def test_peak_shear_moves(self) -> None:
        """Only where one half of q is taken away can the peak of the other half not count as its mirror image."""
        half = changed(shear=np.where(TRUTH.x > 0, TRUTH.shear, 0.0))
        found = compare(half, with_fields(half, shear=np.roll(half.shear, 2, axis=1)))
        assert found.metric("shear_peak_place").value == pytest.approx(2 * SPACING, rel=1e-9)
        assert {"shear", "shear_maximum", "shear_peak_place"} == seen(found)

    def test_of_two_like_peaks_the_nearest_counts(self) -> None:
        """Of a flat and rounded face: the left one 2 % lower in the reference and 2 % higher in the result is no move by 1.2 a."""
        twin = np.exp(-(((TRUTH.x - 0.6) / 0.1) ** 2)) + 0.98 * np.exp(-(((TRUTH.x + 0.6) / 0.1) ** 2))
        reference = changed(pressure=np.tile(twin, (STEPS + 1, 1)))
        mirrored = with_fields(reference, pressure=reference.pressure[:, ::-1])
        assert value(reference, mirrored, "pressure_peak_place") == pytest.approx(0.0, abs=1e-12)
        lower = np.where(TRUTH.x < 0, 0.9, 1.0) * reference.pressure
        far = value(with_fields(reference, pressure=lower), mirrored, "pressure_peak_place")
        assert far == pytest.approx(-1.2, abs=2 * SPACING)


class TestWork:
    def test_loop_wider_by_two_per_cent(self) -> None:
        """About its mean: U is as far from it on the one side as on the other."""
        shift = TRUTH.tangential_displacement
        mean = np.trapezoid(shift, TRUTH.time) / 3
        found = compare(TRUTH, changed(tangential_displacement=1.02 * shift + 5 * np.ptp(shift)))
        off = 0.02 * (shift - mean) / np.ptp(shift)
        assert abs(found.metric("hysteresis_distance").value or 0.0) == pytest.approx(np.max(np.abs(off)), rel=1e-9)
        assert seen(found) == {"hysteresis_distance", "hysteresis", "tangential_displacement"}

    @pytest.mark.parametrize("points", [-4, 4])
    def test_peak_of_the_pointwise_dissipation_moves(self, points: int) -> None:
        bell = changed(dissipation_density=np.exp(-(((TRUTH.x - 0.5) / 0.1) ** 2)))
        found = compare(bell, with_fields(bell, dissipation_density=np.roll(bell.dissipation_density, points)))
        metric = found.metric("dissipation_density_peak_place")
        assert metric.value == pytest.approx(points * SPACING, rel=1e-9)
        assert metric.place == pytest.approx(TRUTH.x[np.argmax(bell.dissipation_density)] + points * SPACING)
        assert seen(found) == {"dissipation_density", "dissipation_density_norm", "dissipation_density_peak_place"}

    def test_absolute_dissipation_stays_of_use_where_the_relative_explodes(self) -> None:
        """W_ref = 1e-6 of the scale, the result 1e-3 of it off: 1e3 relative, 1e-3 absolute, with its sign."""
        scale = compare(TRUTH, TRUTH).scales.dissipation
        found = compare(changed(dissipation=1e-6 * scale), changed(dissipation=(1e-6 - 1e-3) * scale))
        assert found.metric("dissipation").value == pytest.approx(-1e3)
        assert found.metric("dissipation_absolute").value == pytest.approx(-1e-3)

    def test_energy_balance_of_the_record(self) -> None:
        series = np.zeros(STEPS + 1)
        series[9] = 3e-4
        record = Record(True, "steady", "", freeze(np.ones(STEPS + 1), np.int64), {"energy_balance": freeze(series)})
        metric = compare(TRUTH, changed(record=record)).metric("energy_balance")
        assert (metric.value, metric.time) == (3e-4, TRUTH.time[9])
        assert compare(changed(record=record), TRUTH).metric("energy_balance").note == "the result records none"


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Weighted(ContactSolution):
    """A solution with nodal weights and normals, as finite elements give."""

    weights: np.ndarray
    normals: np.ndarray
    stick_edge_uncertainty: np.ndarray


def weighted(angle: float, factor: float = 1.0) -> Weighted:
    """Nodes whose weights make the forces of the closed form exact, on a surface that leans by `angle`."""
    load = TRUTH.normal_load[0]
    weights = np.full(len(TRUTH.x), load / TRUTH.pressure[0].sum())
    normals = np.tile([[-np.sin(angle)], [np.cos(angle)]], len(TRUTH.x))
    fields = {field.name: getattr(TRUTH, field.name) for field in dataclasses.fields(ContactSolution)}
    fields |= {"pressure": factor * TRUTH.pressure, "shear": 0 * TRUTH.shear}
    return Weighted(**fields, weights=weights, normals=normals, stick_edge_uncertainty=np.full((STEPS + 1, 2), 0.005))


class TestResultants:
    def test_of_the_results_own_weights(self) -> None:
        """A pressure of resultant 1.01 P that leans by 0.1: 1.01 cos 0.1 P up and 1.01 sin 0.1 P sideways, less Q."""
        found = compare(TRUTH, weighted(0.1, 1.01))
        assert found.metric("resultant_normal").value == pytest.approx(1.01 * np.cos(0.1) - 1, rel=1e-9)
        sideways = 1.01 * np.sin(0.1) - TRUTH.tangential_load / TRUTH.normal_load
        assert found.metric("resultant_tangential").value == pytest.approx(sideways.max(), rel=1e-9)
        assert not found.metric("resultant_normal").note

    def test_shear_on_a_leaning_surface_lifts(self) -> None:
        """p / 2 along the normal and as much again across it, on a surface that leans by 0.1."""
        sheared = weighted(0.1, 0.5)
        found = compare(TRUTH, dataclasses.replace(sheared, shear=sheared.pressure))
        assert found.metric("resultant_normal").value == pytest.approx(0.5 * (np.cos(0.1) - np.sin(0.1)) - 1, rel=1e-9)

    def test_need_no_reference(self) -> None:
        values = [value(other, weighted(0.1), "resultant_normal") for other in (TRUTH, changed(pressure=2 * TRUTH.pressure))]
        assert values[0] == values[1] != 0.0

    def test_uncertainty_of_a_stick_edge_is_the_results(self) -> None:
        assert compare(TRUTH, weighted(0.0)).metric("stick_edge_left").uncertainty == pytest.approx(0.005)
        assert compare(TRUTH, TRUTH).metric("stick_edge_left").uncertainty is None


def test_edge_in_local_spacings() -> None:
    edges = TRUTH.contact_edges + np.array([-0.01, 0.0])
    metric = compare(TRUTH, changed(contact_edges=edges)).metric("contact_edge_left")
    assert metric.spacings == pytest.approx(0.01 / SPACING)
    assert unit_of(metric) == f"of a_ref (+{0.01 / SPACING:.3g} h)"
    assert metric.place == pytest.approx(-1.01)


POISON = {
    "pressure": {"pressure_maximum", "pressure_peak_place", "resultant_normal"},
    "shear": {"shear_maximum", "peak_shear", "shear_peak_place", "resultant_tangential"},
    "slip": {"slip", "slip_maximum"},
    "contact_edges": {"contact_edge_right"},
    "tangential_displacement": {"tangential_displacement", "hysteresis_distance", "hysteresis"},
    "dissipation_density": {"dissipation_density_norm", "dissipation_density_peak", "dissipation_density_peak_place"},
    "dissipation": {"dissipation_absolute"},
}


@pytest.mark.parametrize("side", ["reference", "result"])
@pytest.mark.parametrize("field", POISON)
def test_what_is_not_a_number_fails(field: str, side: str) -> None:
    """One NaN in the middle of the data of either: the metrics of that field are not finite and fail, without a tolerance too."""
    data = getattr(TRUTH, field)
    poisoned: Any = float("nan")
    if isinstance(data, np.ndarray):
        poisoned = data.copy()
        poisoned[(17, -1)[: data.ndim] if data.shape[-1] == 2 else (len(data) // 3, len(TRUTH.x) // 2)[: data.ndim]] = np.nan
    bad = changed(**{field: poisoned})
    found = compare(bad, TRUTH) if side == "reference" else compare(TRUTH, bad)
    for key in POISON[field]:
        assert not np.isfinite(found.metric(key).value or 0.0), key
        assert found.metric(key).accurate is False, key
    assert not found.passed


def in_other_units(solution: ContactSolution, stress: float, length: float) -> ContactSolution:
    """The same solution in other units of stress and length."""
    force, energy = stress * length, stress * length**2
    material = solution.scene.material
    stiffer = {b: m.vary(young_modulus=m.young_modulus * stress) for b, m in material if b in ("upper", "lower")}
    scene = solution.scene.vary(material=Materials.model_construct(**(dict(material) | stiffer)))
    factors = dict.fromkeys(("pressure", "shear"), stress) | dict.fromkeys(("normal_load", "tangential_load"), force)
    lengths = (
        "x",
        "slip",
        "contact_edges",
        "stick_edges",
        "contact_half_width",
        "tangential_displacement",
        "permanent_stick_half_width",
    )
    factors |= dict.fromkeys(lengths, length) | {"dissipation": energy, "dissipation_density": energy / length}
    return with_fields(solution, scene=scene, **{name: factor * getattr(solution, name) for name, factor in factors.items()})


@pytest.mark.parametrize(("stress", "length"), [(1e9, 1.0), (1.0, 1e9), (1e-9, 1e3)])
@pytest.mark.parametrize("fault", FAULTS)
def test_units_do_not_matter(fault: str, stress: float, length: float) -> None:
    result = FAULTS[fault][0]()
    before = compare(TRUTH, result)
    after = compare(in_other_units(TRUTH, stress, length), in_other_units(result, stress, length))
    assert [m.absolute for m in after.metrics] == [m.absolute for m in before.metrics]
    for metric in after.metrics:
        expected = before.metric(metric.key)
        if metric.value is None or expected.value is None:
            assert metric.value is expected.value, metric.key
        else:
            assert metric.value == pytest.approx(expected.value, rel=1e-9, abs=1e-12), metric.key


def test_units_do_not_matter_where_the_reference_does_nothing() -> None:
    """No work, no slip: absolute figures, of a result with a constant density of work and slip."""
    still = changed(dissipation=0.0, dissipation_density=0 * TRUTH.x, slip=0 * TRUTH.slip)
    result = with_fields(still, dissipation=1e-3, dissipation_density=1e-3 + 0 * TRUTH.x, slip=1e-3 + 0 * TRUTH.slip)
    before, after = compare(still, result), compare(in_other_units(still, 1e9, 1e3), in_other_units(result, 1e9, 1e3))
    for key in (
        "dissipation",
        "dissipation_density",
        "dissipation_density_norm",
        "dissipation_density_peak",
        "slip",
        "slip_maximum",
    ):
        assert before.metric(key).absolute, key
        assert after.metric(key).value == pytest.approx(before.metric(key).value, rel=1e-9), key


@pytest.mark.parametrize(
    "name", ["hertz-paper", "flat-rounded-paper", "full-stick", "hertz-normal", "cylinder-roller-frictionless"]
)
def test_half_plane_theory_against_itself(name: str) -> None:
    """Every metric is exactly 0 or says in words why it does not apply."""
    exact = semi_analytic.solve(load_scene(name))
    found = compare(exact, exact)
    assert seen(found) == set()
    for metric in found.metrics:
        assert metric.value is not None or metric.note, metric.key


def test_frictionless_says_so() -> None:
    exact = semi_analytic.solve(load_scene("cylinder-roller-frictionless"))
    notes = {metric.key for metric in compare(exact, exact).metrics if metric.note.startswith("frictionless")}
    assert notes >= {"stick_set", "slip", "slip_reversal", "full_stick_start"}


def test_every_metric_has_its_row_and_every_row_its_metric() -> None:
    found = compare(TRUTH, TRUTH, polygon_reference=TRUTH)
    assert [metric.key for metric in found.metrics] == list(METRICS)
    assert [*found.headlines, *found.others] == list(found.metrics)
    assert len(found.headlines) == 6
    assert {row.key for row in METRICS.values() if not row.signed} == {
        *("pressure", "shear", "state", "stick_set", "slip", "dissipation_density_norm", "energy_balance")
    }


def test_json_holds_unit_norm_region_and_place() -> None:
    stored = json.loads(as_json(compare(TRUTH, FAULTS["right contact edge 0.02 a out"][0]())))["metrics"]["contact_edge_right"]
    assert stored["value"] == pytest.approx(0.02)
    assert (stored["unit"], stored["region"], stored["signed"]) == ("of a_ref", "judged instants", True)
    assert stored["worst_at_x_over_a_ref"] == pytest.approx(1.02)
    assert len(stored["series"]) == STEPS + 1


def test_docs_say_what_the_code_says() -> None:
    page = (Path(__file__).parents[1] / "docs" / "metrics.md").read_text(encoding="utf-8")
    assert markdown() in page
