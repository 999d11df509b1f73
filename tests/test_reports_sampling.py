"""Putting one solution on the points and instants of another: exact where it is exact, stated where it is not."""

from dataclasses import replace

import numpy as np
import pytest

from reports import compare
from reports.comparison.cycles import events, last_cycle, sample
from scenes import InputError, load_scene
from test_reports_synthetic import cattaneo_mindlin, with_fields

COARSE = cattaneo_mindlin(steps_per_leg=20, points=81)
FINE = cattaneo_mindlin(steps_per_leg=40, points=321)


def test_stated_interpolation_error_is_honest() -> None:
    """The truth is known here: of 320 spacings, the edge falling anywhere in an interval, one in a hundred at most errs by more."""
    like = last_cycle(COARSE)
    smaller = 0
    for points in range(100, 420):
        found = sample(last_cycle(cattaneo_mindlin(steps_per_leg=20, points=points)), like, "closed form")
        if found.interpolation:
            error = np.max(np.abs(found.pressure - like.pressure)) / np.max(like.pressure)
            smaller += error > found.interpolation["pressure"]
    assert smaller <= 3


def test_interpolation_in_time_and_space_is_said() -> None:
    found = compare(cattaneo_mindlin(steps_per_leg=31, points=150), COARSE)
    for name in ("pressure", "shear"):
        truth = getattr(COARSE, name)
        error = np.max(np.abs(getattr(found.expected, name) - truth)) / np.max(np.abs(truth))
        assert 0 < error <= found.expected.interpolation[name] < 0.5
    assert any("was interpolated" in note for note in found.notes)


@pytest.mark.parametrize("later", [0.0, 3.0])
def test_instants_are_matched_by_phase_not_by_revolution(later: float) -> None:
    """The same cycle, at once or one revolution later: nothing to interpolate, nothing to tell apart."""
    found = compare(COARSE, with_fields(COARSE, time=COARSE.time + later))
    assert not found.expected.interpolation
    assert not any("interpolated" in note for note in found.notes)
    assert all(not metric.value for metric in found.metrics)


@pytest.mark.parametrize("least", [0.4, 0.0])
def test_a_reference_that_ends_inside_the_contact_is_refused(least: float) -> None:
    """Far inside, and at the last point that carries anything: 7 % of the largest pressure."""
    largest = FINE.pressure.max(axis=0)
    inner = largest > least * largest.max()
    assert least < largest[inner][0] / largest.max() < least + 0.1
    cut = {name: getattr(FINE, name)[:, inner] for name in ("pressure", "shear", "slip", "state")}
    short = with_fields(FINE, x=FINE.x[inner], dissipation_density=FINE.dissipation_density[inner], **cut)
    with pytest.raises(InputError, match="still carries pressure"):
        compare(short, COARSE)


def test_less_than_a_cycle_is_refused() -> None:
    names = ("pressure", "shear", "slip", "state", "contact_edges", "stick_edges", "normal_load", "tangential_load")
    names += ("contact_half_width", "stick_half_width", "tangential_displacement", "normal_approach", "time")
    half = with_fields(COARSE, **{name: getattr(COARSE, name)[:1] for name in names})
    with pytest.raises(InputError, match="holds no whole cycle"):
        compare(COARSE, half)


def test_events_of_a_cycle_under_constant_pressure() -> None:
    """P stands still: only Q has extremes; the rest of the six are the middles of the widest gaps."""
    cycle = last_cycle(COARSE)
    found = events(cycle, COARSE.scene.friction.coefficient)
    labels = {event.label: cycle.time[event.index] for event in found}
    assert len(found) == 6
    assert labels["Q largest"] == 2.0
    assert labels["Q least"] == 3.0
    assert not any(label.startswith("P ") for label in labels)
    assert [event.index for event in found] == sorted({event.index for event in found})


def test_events_between_others_are_spread_over_time_not_over_increments() -> None:
    """Nine tenths of the instants in the first hundredth of the cycle, where an engine would land on many touches."""
    cycle = last_cycle(COARSE)
    time = np.concatenate([np.linspace(0, 0.01, 9 * len(cycle.time) * 2), np.linspace(0.01, 1, 2 * len(cycle.time) + 1)[1:]])
    flat = np.ones(len(time))
    crowded = replace(cycle, time=time, normal_load=flat, tangential_load=0 * flat)
    found = [time[event.index] for event in events(crowded, 0.5)]
    assert (len(found), min(np.diff(found)) > 0.1) == (6, True)


def test_events_of_the_papers_ellipse() -> None:
    """H, the largest P, the largest Q, E (forward slip ends at 5/8), the least P, G (reverse slip ends at 7/8)."""
    scene = load_scene("hertz-paper")
    path = scene.load.path()
    time = path.cycle_start + np.linspace(0, 2 * np.pi, 81)
    normal, tangential = path.at(time)
    steps = {"time": time, "normal_load": normal, "tangential_load": tangential}
    blank = {name: np.zeros((81, 81)) for name in ("pressure", "shear", "slip")}
    edges = {name: np.zeros((81, 2)) for name in ("contact_edges", "stick_edges")}
    series = {name: np.zeros(81) for name in ("tangential_displacement", "normal_approach")}
    state = np.zeros((81, 81), np.int8)
    cycle = last_cycle(with_fields(COARSE, scene=scene, state=state, **steps, **blank, **edges, **series))
    found = events(cycle, 1.0)
    labels = ["Q least", "P largest", "Q largest", "forward slip ends", "P least", "reverse slip ends"]
    assert [event.label for event in found] == labels
    assert cycle.fraction[[event.index for event in found]] == pytest.approx([0, 0.25, 0.5, 0.625, 0.75, 0.875])
