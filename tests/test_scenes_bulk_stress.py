"""Bulk stresses and tilt of a load: each kind of load, each way to state them, what is refused, two unequal sides of a profile."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import semi_analytic
from scenes import (
    EllipseLoad,
    HarmonicLoad,
    InputError,
    LoadPath,
    PolygonLoad,
    Scene,
    Tabulated,
    TimeSeriesLoad,
    load_scene,
)
from scenes.loads import CallableLoad

PAPER = {"mean_normal_load": 3, "normal_amplitude": 1, "mean_tangential_load": 1.1, "tangential_amplitude": 1}
WAVES: dict[str, Any] = {
    "mean_normal_load": 3,
    "normal_harmonics": [(1, 0), (0.2, 30)],
    "mean_tangential_load": 0.1,
    "tangential_harmonics": [(1, 90), (0.3, 0)],
}
CORNERS: dict[str, Any] = {"initial_loading": [(2, 0), (3, 0.3)], "cycle": [(3, 1.8), (2.5, -1.8)]}
ROWS = [[0, 2, 0.2], [1, 2, 1], [3, 1, 0], [4, 2, 0.2]]
FUNCTIONS: dict[str, Any] = {"normal_load": lambda t: 3 + math.cos(t), "tangential_load": math.sin, "duration": 2 * math.pi}
Q_OF_WAVES = {"mean": 0.05, "harmonics": [(0.5, 90), (0.15, 0)], "initial_loading": [0.05]}
# Loads whose stress below is half of Q, whose stress above is twice P, whose tilt is 0.1 P, stated in each kind's own way.
STATED = {
    "ellipse": EllipseLoad(
        **PAPER,
        bulk_stress_lower={"mean": 0.55, "amplitude": 0.5, "phase_degrees": 90},
        bulk_stress_upper={"mean": 6, "amplitude": 2},
        tilt={"mean": 0.3, "amplitude": 0.1},
    ),
    "harmonics": HarmonicLoad(
        **WAVES,
        initial_loading=[(1, 0.1)],
        bulk_stress_lower=Q_OF_WAVES,
        bulk_stress_upper={"mean": 6, "harmonics": [(2, 0), (0.4, 30)]},
        tilt={"mean": 0.3, "harmonics": [(0.1, 0), (0.02, 30)]},
    ),
    "polygon": PolygonLoad(
        **CORNERS, bulk_stress_lower=(0, 0.15, 0.9, -0.9), bulk_stress_upper=(4, 6, 6, 5), tilt=(0.2, 0.3, 0.3, 0.25)
    ),
    "rows": TimeSeriesLoad(
        rows=ROWS, repeats=True, bulk_stress_lower=(0.1, 0.5, 0, 0.1), bulk_stress_upper=(4, 4, 2, 4), tilt=(0.2, 0.2, 0.1, 0.2)
    ),
    "functions": CallableLoad(
        **FUNCTIONS,
        repeats=True,
        bulk_stress_lower=lambda t: math.sin(t) / 2,
        bulk_stress_upper=lambda t: 6 + 2 * math.cos(t),
        tilt=lambda t: 0.3 + 0.1 * math.cos(t),
    ),
}


@pytest.mark.parametrize("kind", STATED)
def test_stresses_and_tilt_follow_the_loads_in_every_cycle(kind: str) -> None:
    """P and Q are those of the load without them."""
    plain = STATED[kind].vary(bulk_stress_lower=None, bulk_stress_upper=None, tilt=None).path()
    path = STATED[kind].path()
    assert (path.has_bulk_or_tilt, path.moment_given, plain.has_bulk_or_tilt) == (True, False, False)
    for leg, bare in zip(path.legs(3), plain.legs(3), strict=True):
        time = np.linspace(leg.start, leg.end, 7)
        assert leg.bulk is not None
        assert leg.turning is not None
        assert (leg.bulk.start, leg.bulk.end) == (leg.start, leg.end)
        p, q = leg.loads(time)
        assert np.array_equal((p, q), bare.loads(time))
        assert bare.bulk is bare.turning is None
        np.testing.assert_allclose(leg.bulk.loads(time), (q / 2, 2 * p), rtol=0, atol=3e-14)
        np.testing.assert_allclose(leg.turning.loads(time), (0.1 * p, 0 * p), rtol=0, atol=3e-15)
        np.testing.assert_allclose(leg.bulk.rates(time), (leg.rates(time)[1] / 2, 2 * leg.rates(time)[0]), rtol=0, atol=3e-11)


NUMBERS = {"ellipse": PAPER, "harmonics": WAVES, "polygon": CORNERS, "functions": FUNCTIONS | {"repeats": True}}


@pytest.mark.parametrize("kind", NUMBERS)
def test_a_number_grows_with_p_then_stays_and_a_line_of_action_makes_the_moment(kind: str) -> None:
    load = type(STATED[kind])(**NUMBERS[kind], bulk_stress_upper=50.0, line_of_action={"x": 0.2, "height": 3.0})
    path: LoadPath = load.path()
    assert path.moment_given
    end = float(path.initial_loading[-1].loads(path.cycle_start)[0])
    for leg in path.legs(2):
        assert leg.bulk is not None
        assert leg.turning is not None
        time = np.linspace(leg.start, leg.end, 5)
        p, q = leg.loads(time)
        stress = 50 * p / end if leg.end <= path.cycle_start else np.full(5, 50.0)
        np.testing.assert_allclose(leg.bulk.loads(time), (0 * p, stress), rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(leg.turning.loads(time), (0 * p, 0.2 * p + 3 * q), rtol=1e-12, atol=1e-12)


# Corners where P and Q stand still.
STILL: dict[str, Any] = {"initial_loading": [(2, 0), (2, 0)], "cycle": [(2, 1), (2, 1), (2, -1)]}


@pytest.mark.parametrize(
    ("values", "counts"), [((0, 1, 1, 3, -1), True), ((0.5, 1, 1, 1, 1), False), ((1, 1, 1, 3, 1), False), (None, False)], ids=str
)
@pytest.mark.parametrize("key", ["bulk_stress_lower", "bulk_stress_upper", "tilt", "moment"])
def test_a_corner_counts_at_which_only_bulk_stress_or_tilt_changes(
    key: str, values: tuple[float, ...] | None, counts: bool
) -> None:
    """As rows of a record that state the same; a point that stands twice with nothing else is refused."""
    if not counts:
        place = "2.0, 0.0" if values is None or values[0] == values[1] else "2.0, 1.0"
        beside = "" if values is None else " with the same bulk stress and tilt"
        with pytest.raises(ValueError, match=rf"the point \[{place}\] stands twice in a row{beside}: leave one out"):
            PolygonLoad(**STILL, **{key: values})
        return
    found = PolygonLoad(**STILL, **{key: values}).path()
    points = [*STILL["initial_loading"], *STILL["cycle"]]
    rows = [[k + 1, *point] for k, point in enumerate(points)]
    same = TimeSeriesLoad(rows=rows, **{key: values}).path()
    assert found.moment_given == same.moment_given
    for one, other in zip((*found.initial_loading, *found.cycle), same.initial_loading, strict=False):
        for part in (lambda leg: leg, lambda leg: leg.turning if key in ("tilt", "moment") else leg.bulk):
            ends = [np.array(part(leg).loads(np.array([leg.start, leg.end]))) for leg in (one, other)]
            assert np.array_equal(*ends)


def test_a_tilt_that_changes_while_the_load_stands_still_moves_the_contact_and_nothing_else() -> None:
    """Hertz: a tilt shifts the contact by -R tilt; W, p and a are those without it (Johnson 1985)."""
    load = {"initial_loading": [(3.0, 0.0), (3.0, 0.0), (3.0, 0.3)], "cycle": [(3.0, -0.3)]}
    soft = {"young_modulus": 2.0, "poisson_ratio": 0.0}
    turned = PolygonLoad(**load, tilt=(0.0, 0.1, 0.1, 0.1))
    plain = PolygonLoad(initial_loading=[(3.0, 0.0), (3.0, 0.3)], cycle=[(3.0, -0.3)])
    answers = [
        semi_analytic.solve(
            Scene.model_validate({"material": soft, "profile": {"kind": "hertz", "radius": 1.0}, "friction": 0.5, "load": one}),
            x=[0.0],
        )
        for one in (turned, plain)
    ]
    assert answers[0].dissipation == pytest.approx(answers[1].dissipation, rel=1e-12)
    assert np.mean(answers[0].contact_edges[-1]) == pytest.approx(-0.1, rel=1e-12)


REFUSED = {
    "two ways to turn": ({"tilt": 0.1, "moment": 2.0}, "tilt and moment say the same thing: state one of them"),
    "a list too short": ({"bulk_stress_lower": (1.0, 2.0)}, "has 2 values, and 4 are needed, one for each point"),
    "a word": ({"bulk_stress_lower": "much"}, "should be a valid number"),
    "not finite": ({"tilt": math.inf}, "should be a finite number"),
    "a wave beside a polygon": ({"tilt": {"amplitude": 1.0}}, "tilt"),
    "a key of no line": ({"line_of_action": {"y": 1.0}}, "unknown key line_of_action.y = 1.0"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_cannot_be_meant_is_refused(what: str) -> None:
    changes, words = REFUSED[what]
    with pytest.raises(InputError, match=words.replace("(", r"\(")):
        PolygonLoad(**CORNERS).vary(**changes)


def test_columns_of_a_record_are_read_where_they_are_named(tmp_path: Path) -> None:
    text = load_scene("time-series").model_dump_json(exclude_none=True)
    assert "bulk" not in text
    table = "time,P,Q,S [ksi],A [deg]\n0,2,0,1,0\n1,2,1,2,3\n3,2,0,1,0\n"
    (tmp_path / "rows.csv").write_text(table, encoding="utf-8")
    (tmp_path / "mine.toml").write_text(
        'material = {young_modulus = 1000.0, poisson_ratio = 0.3}\nprofile = {kind = "hertz", radius = 10.0}\nfriction = 0.8\n'
        '[load]\nkind = "time_series"\nfile = "rows.csv"\nrepeats = true\ncolumns = {bulk_stress_lower = "S", tilt = "A"}\n',
        encoding="utf-8",
    )
    load = load_scene(tmp_path / "mine.toml").load
    assert isinstance(load, TimeSeriesLoad)
    np.testing.assert_allclose(load.bulk_stress_lower, [6.894757293, 13.789514586, 6.894757293], rtol=1e-9)
    np.testing.assert_allclose(load.tilt, np.radians([0, 3, 0]))
    assert load.rows.values.shape == (3, 3)
    assert dict(load.read_as or ())["bulk_stress_lower"] == "'S [ksi]', ksi (in its heading), times 6.89475729"
    load_scene(tmp_path / "mine.toml").save(tmp_path / "copy.toml")
    copy = load_scene(tmp_path / "copy.toml").load
    assert isinstance(copy, TimeSeriesLoad)
    assert copy.bulk_stress_lower == load.bulk_stress_lower
    # Other rows have no such columns; a reduced record would lose theirs.
    assert load.vary(rows=ROWS).bulk_stress_lower is None
    with pytest.raises(InputError, match="average and reduce go with records of P and Q alone"):
        load.vary(reduce="turning_points")
    (tmp_path / "mine.toml").write_text((tmp_path / "mine.toml").read_text().replace('"rows.csv"', '"rows.csv"\ntilt = 0.1'))
    with pytest.raises(InputError, match="tilt is a column of the file and stated beside it: leave one out"):
        load_scene(tmp_path / "mine.toml")


def test_a_table_keeps_its_two_sides() -> None:
    x = np.linspace(-1.0, 2.0, 31)
    rows = np.stack([x, np.where(x < 0, 2.0, 0.5) * x**2], axis=1)
    with pytest.raises(ValueError, match="has no partner on the other side"):
        Tabulated(points=rows)
    profile = Tabulated(points=rows, symmetric=False)
    assert not profile.symmetric
    at = np.array([-0.85, -0.3, 0.0, 0.3, 1.95])
    np.testing.assert_allclose(profile.height(at), np.where(at < 0, 2.0, 0.5) * at**2, atol=1e-12)
    with pytest.raises(InputError, match="take `sides`"):
        profile.spline()
    mirrored = Tabulated(points=(rows * [-1.0, 1.0])[::-1], symmetric=False)
    assert np.array_equal(mirrored.height(-at), profile.height(at))
    rows[3, 1] = 9.0
    with pytest.raises(ValueError, match="row 3: left side, x counted to the left"):
        Tabulated(points=rows, symmetric=False)
