"""Tractions of problems that the suite does not solve are said to be that: closed forms of
textbooks, with and without noise; none is named on results of the suite's own problem.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import semi_analytic
from reports import score
from reports.scoring.against import score_surface
from reports.scoring.discrepancy import discrepancy_of
from reports.scoring.mapping import Mapping
from reports.scoring.other_problems import other_problems
from reports.scoring.surface import surface_result
from reports.scoring.traces import WORDS, Diagnosis
from reports.scoring.variants import scene_with_modulus_factor
from scenes import SLIP_FORWARD, SLIP_REVERSE, load_scene
from semi_analytic.profiles import contact_of

CATTANEO = load_scene("cattaneo-mindlin")
X = np.linspace(-1.3, 1.3, 79)
PATH = CATTANEO.load.path()
TIME = PATH.cycle_start + PATH.period * (2 + np.array([0.25, 0.35, 0.7]))
P, Q = (np.asarray(load) for load in PATH.at(TIME))
CONTACT = contact_of(CATTANEO.profile, CATTANEO.material)
F = CATTANEO.friction.coefficient
P0 = float(CONTACT.pressure(0.0, P[0]))
THEORY = semi_analytic.solve(CATTANEO, x=X, time=TIME, fields=("pressure", "shear", "state"))
Tractions = tuple[np.ndarray, np.ndarray]


def ellipse(x: np.ndarray, half_width: float) -> np.ndarray:
    return np.sqrt(np.maximum(1 - (x / half_width) ** 2, 0.0))


def repeated(row: np.ndarray) -> np.ndarray:
    return np.tile(row, (len(TIME), 1))


def adhesion() -> Tractions:
    """Johnson (1985), 5.5: an ellipse minus a flat punch, of which P is the sum."""
    a = 1.08
    p0 = 1.4 * P0
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(1 - (X / a) ** 2)
        p1 = (np.pi * a * p0 / 2 - P[0]) / (np.pi * a)
        row = np.where(np.abs(X) < a, p0 * root - p1 / root, 0.0)
    return repeated(np.nan_to_num(row)), 0 * THEORY.shear


def sharp_punch() -> Tractions:
    a = 0.97
    with np.errstate(invalid="ignore", divide="ignore"):
        row = np.where(np.abs(X) < a, P[0] / (np.pi * np.sqrt(a**2 - X**2)), 0.0)
    return repeated(np.nan_to_num(row)), 0 * THEORY.shear


def sphere() -> Tractions:
    """A force that makes a contact as wide as 0.95 of the scene's."""
    a = 0.95
    p0 = 4 / np.pi * P0 * a
    p = repeated(p0 * ellipse(X, a))
    force = 2 / 3 * np.pi * a**2 * p0
    share = np.abs(Q) / (F * force)
    c = a * (1 - share) ** (1 / 3)
    q = [
        np.sign(load) * F * p0 * (ellipse(X, a) - stick / a * ellipse(X, stick))
        for load, stick in zip(Q, c, strict=True)
    ]
    return p, np.array(q)


def limit_of_pressure() -> Tractions:
    """Sum P with a limit of 0.8 p0."""
    limit = 0.8 * P0
    loads = P[0] * np.linspace(1, 2, 400)
    rows = np.minimum(CONTACT.pressure(X, loads[:, None]), limit)
    row = rows[np.argmin(np.abs(np.trapezoid(rows, X, axis=1) - P[0]))]
    return repeated(row), THEORY.shear


def several_zones() -> Tractions:
    """Ridges three points wide with gaps of two points between them, which carry the load."""
    p = np.where(np.arange(len(X)) % 5 < 3, THEORY.pressure, 0.0)
    p *= np.trapezoid(THEORY.pressure, X, axis=1)[:, None] / np.trapezoid(p, X, axis=1)[:, None]
    return p, F * 0.3 * np.sign(Q)[:, None] * p


def not_elastic() -> Tractions:
    """Under the same P wider by a tenth, and lower, at the last instant."""
    p = THEORY.pressure.copy()
    p[-1] = P[-1] * 2 / (np.pi * 1.1) * ellipse(X, 1.1)
    return p, THEORY.shear


def rolling() -> Tractions:
    """Johnson (1985), 8.3: Carter's shear with its stick zone at the right edge."""
    q = np.zeros_like(THEORY.shear)
    for k, load in enumerate(Q):
        c = np.sqrt(1 - abs(load) / (F * P[k]))
        q[k] = np.sign(load) * F * P0 * (ellipse(X, 1.0) - c * ellipse(X - (1 - c), c))
    return THEORY.pressure, q


def law_of_friction() -> Tractions:
    """A shear strength of 0.2 f p0 beside half of f."""
    state = semi_analytic.solve(CATTANEO, x=X, time=TIME).state
    law = np.sign(THEORY.shear) * (0.2 * F * P0 + 0.5 * F * THEORY.pressure)
    return THEORY.pressure, np.where(
        np.isin(state, (SLIP_FORWARD, SLIP_REVERSE)), law, THEORY.shear
    )


PROBLEMS: dict[str, Callable[[], Tractions]] = {
    make.__name__: make
    for make in (
        adhesion,
        sharp_punch,
        sphere,
        limit_of_pressure,
        several_zones,
        not_elastic,
        rolling,
        law_of_friction,
    )
}


def noisy(values: np.ndarray, size: float, seed: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    noise = size * np.abs(values).max() * random.standard_normal(values.shape)
    return np.where(values != 0, values + noise, 0.0)


def shortened_repr(p: np.ndarray, q: np.ndarray) -> list[Diagnosis]:
    """The problems that rows show, where no cause of the suite is known."""
    fields = {"pressure": p, "shear": q}
    surface = surface_result("arrays", "", X, fields, {"time": TIME})
    discrepancy = discrepancy_of(score_surface(surface, Mapping(), CATTANEO).comparison)
    assert discrepancy is not None
    return list(other_problems(discrepancy, None))


@pytest.mark.parametrize("noise", [0.0, 0.02])
@pytest.mark.parametrize("key", PROBLEMS)
def test_the_rows_of_a_problem_show_that_problem(key: str, noise: float) -> None:
    p, q = PROBLEMS[key]()
    (diagnosis,) = shortened_repr(noisy(p, noise, 1), noisy(q, noise, 2))
    assert diagnosis.fault == key
    assert diagnosis.sentence.startswith(WORDS["other_problem"])
    assert "{" not in diagnosis.sentence
    assert diagnosis.evidence


@pytest.mark.parametrize(
    ("key", "noise"),
    [
        ("rolling", 0.02),
        *(
            pytest.param(key, noise, marks=pytest.mark.slow)
            for key in PROBLEMS
            for noise in (0.0, 0.02)
        ),
    ],
)
def test_a_score_says_that_the_suite_does_not_solve_it(key: str, noise: float) -> None:
    p, q = PROBLEMS[key]()
    report = score(X, noisy(p, noise, 1), noisy(q, noise, 2), scene=CATTANEO, time=TIME)
    assert [diagnosis.fault for diagnosis in report.diagnoses] == [key]
    assert "which the suite does not solve" in report.first_sentence


# ----------------------------------------------------------------------------- what is none of them
def with_holes() -> Tractions:
    """Rows of the table that are 0: their load is gone with them."""
    p, q = several_zones()
    return np.where(p > 0, THEORY.pressure, 0.0), np.where(p > 0, q, 0.0)


def corner_nodes() -> Tractions:
    """Corners of quadratic elements that carry nothing, mid-side nodes that carry all."""
    return THEORY.pressure * (2.0 * (np.arange(len(X)) % 2)), THEORY.shear


def tension_of_one_node() -> Tractions:
    """Stress extrapolated beyond the edges."""
    p = THEORY.pressure.copy()
    outside = np.flatnonzero(p[0] == 0)
    left, right = outside[outside < len(X) // 2][-1], outside[outside > len(X) // 2][0]
    p[:, [left, right]] = -0.1 * P0
    return p, THEORY.shear


def stiffer_cylinder(factor: float = 4 / np.pi) -> Tractions:
    """As steep as a sphere's pressure, with P for its sum."""
    answer = semi_analytic.solve(
        scene_with_modulus_factor(CATTANEO, factor), x=X, time=TIME, fields=("pressure", "shear")
    )
    return answer.pressure, answer.shear


def shear_of_another_pressure() -> Tractions:
    """Of the right pressure, where the pressure itself is wrong: no law of friction is shown."""
    return stiffer_cylinder(1.2)[0], THEORY.shear


def more_friction() -> Tractions:
    more = semi_analytic.solve(
        CATTANEO.vary(friction=1.3 * F), x=X, time=TIME, fields=("pressure", "shear")
    )
    return more.pressure, more.shear


def odd_in_x() -> Tractions:
    """Bodies that tilt back and forth under the same P."""
    return THEORY.pressure * (1 + 0.2 * np.sign(Q)[:, None] * X), THEORY.shear


OTHERS = (
    with_holes,
    corner_nodes,
    tension_of_one_node,
    more_friction,
    shear_of_another_pressure,
    odd_in_x,
)


@pytest.mark.parametrize("noise", [0.0, 0.02])
@pytest.mark.parametrize("make", OTHERS)
def test_a_fault_or_a_mesh_is_no_problem_of_its_own(
    make: Callable[[], Tractions], noise: float
) -> None:
    p, q = make()
    assert shortened_repr(noisy(p, noise, 1), noisy(q, noise, 2)) == []


def test_a_cause_of_the_suite_goes_before_another_problem() -> None:
    """A cylinder 4/pi times as stiff has the slope of a sphere, and P for the sum of its rows."""
    p, q = stiffer_cylinder()
    assert [diagnosis.fault for diagnosis in shortened_repr(p, q)] == ["sphere"]
    report = score(X, p, q, scene=CATTANEO, time=TIME)
    assert [diagnosis.fault for diagnosis in report.diagnoses] == ["stiffness"]


def test_noise_alone_shows_no_problem() -> None:
    for seed in range(5):
        p, q = THEORY.pressure, THEORY.shear
        assert shortened_repr(noisy(p, 0.05, seed), noisy(q, 0.05, seed + 100)) == []
