"""The contact law at a point and the active set of one increment: laws on any path, history as a
value, factors, mirrored faces.
"""

import functools
import itertools
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import halfplane_fe
from halfplane_fe import SolverSettings, scales, systems
from halfplane_fe.contact import ContactProblem, nodal_values
from halfplane_fe.elasticity import condense
from halfplane_fe.energy import increment_energies, law_violations
from halfplane_fe.interface import Interface, couple
from halfplane_fe.law import project, slip_sign, violations
from halfplane_fe.mirror import is_mirrored
from halfplane_fe.systems import Layer, SingularSet, Systems
from meshes import MeshSettings, SurfaceGrading, half_disc
from problems import fe_run
from scenes import ConvergenceError, Elastic, SurfaceState, load_scene

# ------------------------------------------------------------------------------- the law at a point


number = st.floats(-1e3, 1e3).map(lambda value: 0.0 if abs(value) < 1e-6 else value)
# products stay normal numbers
friction = st.floats(0, 3).map(lambda value: 0.0 if value < 1e-6 else value)
trials = arrays(float, 6, elements=number)
OPEN, STICK, FORWARD, REVERSE = SurfaceState


@given(trials, trials, friction)
def test_projection_is_the_nearest_pressure_and_the_shear_cut_off_at_f_p(pressure, shear, f):
    """So the laws hold in what it gives, and it is idempotent, its own mirror image, the same in
    any unit.

    p, q = project(p - r g, q + r ds) where, and only where, Signorini's and Coulomb's laws hold;
    on the cone counts as sticking.
    """
    p, q, state = project(pressure, shear, f)
    limit = f * np.maximum(pressure, 0.0)
    np.testing.assert_array_equal(p, np.maximum(pressure, 0.0))
    np.testing.assert_array_equal(q, np.minimum(np.maximum(shear, -limit), limit))
    for name, holds in ((OPEN, pressure <= 0), (FORWARD, shear > limit), (REVERSE, shear < -limit)):
        np.testing.assert_array_equal(state == name, holds & ((pressure > 0) | (name == OPEN)))
    np.testing.assert_array_equal(
        slip_sign(state), np.sign(shear) * (np.abs(shear) > limit) * (pressure > 0)
    )
    assert state.dtype == np.int8
    assert [values.tolist() for values in project([1.0, 1.0], [[0.0], [0.3]], 0.0)] == [
        [1.0, 1.0],
        [[0.0, 0.0], [0.0, 0.0]],
        [[STICK, STICK], [FORWARD, FORWARD]],
    ]


# An answer in which all is well: open, sticking, sliding forward, sliding in reverse.
GOOD = {
    "gap": np.array([0.5, 0.0, 0.0, 0.0]),
    "pressure": np.array([0.0, 2.0, 2.0, 4.0]),
    "shear": np.array([0.0, 0.4, 1.0, -2.0]),
    "slip_increment": np.array([0.3, 0.0, 0.1, -0.2]),
}
PLANTED = {
    "tension": ("pressure", 0, -0.25, {"tension": 0.25, "gap_pressure": 0.125, "cone": 0.125}),
    "penetration": ("gap", 1, -0.25, {"penetration": 0.25, "gap_pressure": 0.5}),
    "gap_pressure": ("gap", 3, 0.25, {"gap_pressure": 1.0}),
    "cone": ("shear", 2, 1.25, {"cone": 0.25}),
    "slip_sign": ("slip_increment", 3, 0.25, {"slip_sign": 0.5}),
    "creep": ("slip_increment", 1, -0.25, {"creep": 0.25, "slip_sign": 0.1}),
}


@pytest.mark.parametrize("name", [None, *PLANTED])
def test_planted_violation_is_seen_with_its_size_and_nothing_else_is(name):
    field, place, value, expected_laws = PLANTED.get(name, ("gap", 0, GOOD["gap"][0], {}))
    values = GOOD[field].copy()
    values[place] = value
    broken_laws = violations(**(GOOD | {field: values}), friction=0.5)
    assert broken_laws == pytest.approx(
        {figure: expected_laws.get(figure, 0.0) for figure in PLANTED}, abs=1e-15
    )


# ------------------------------------------------------------------------------------ one increment


FRICTION = 0.5
MATERIALS = {
    "like": (Elastic(young_modulus=1.82, poisson_ratio=0.3),) * 2,
    "unlike": (
        Elastic(young_modulus=1.82, poisson_ratio=0.3),
        Elastic(young_modulus=0.6, poisson_ratio=0.33),
    ),
}


# f, P in the units of the largest load; each a path from rest, without gross sliding.
PATH = ((0.5, 0.0), (1.0, 0.2), (0.9, 0.38), (0.7, -0.1), (0.95, -0.4), (0.6, 0.05))


@functools.cache
def interface(pair="like"):
    body = half_disc("body", SurfaceGrading(0.0, 1.2, 1 / 10, 1 / 10, 6.0), 0.4, 2)
    lower, upper = MATERIALS[pair]
    below = condense(body, lower, 1.0)
    above = below if upper is lower else condense(body, upper, 1.0)
    return couple(below, above)


def problem(pair="like", layer=0.0, friction=FRICTION, max_iterations=100):
    """Scaled so that E* = 1 and the contact reaches |x| = 1 at P = 1, or thereabouts."""
    sides = interface(pair)
    soft = np.full_like(sides.x, layer)
    modulus = 1 / sum((1 - body.poisson_ratio**2) / body.young_modulus for body in MATERIALS[pair])
    height = 2 / np.pi / modulus * np.square(sides.x)
    return ContactProblem(sides, height, friction, Layer(soft, soft), max_iterations=max_iterations)


def walk(contact, path=PATH):
    """States along a path, the untouched one first."""
    states = [contact.unloaded_state()]
    for time, loads in enumerate(path, start=1):
        states.append(contact.equilibrium(states[-1], float(time), loads)[0])
    return states


def bits(state):
    """All of a state as bytes."""
    return (
        state.values.tobytes()
        + state.node_states.tobytes()
        + np.array([state.time, *state.loads]).tobytes()
    )


loads = st.tuples(st.floats(0.3, 1.0), st.floats(-0.97, 0.97)).map(
    lambda point: (point[0], FRICTION * point[0] * point[1])
)


@pytest.mark.parametrize("pair", MATERIALS)
def test_the_same_history_gives_the_same_bits_whatever_was_tried_in_between(pair):
    """History is a value: read-only, and it matters to the shear, not to the pressure of like
    bodies.
    """
    contact = problem(pair)
    states = walk(contact)
    for before, after, load in zip(states[:-1], states[1:], PATH, strict=True):
        contact.equilibrium(before, 99.0, (0.8, 0.3))  # a step that is thrown away
        contact.state_following(before, 99.0, (0.3, -0.1), before.node_states)
        assert bits(contact.equilibrium(before, after.time, load)[0]) == bits(after)
    assert [bits(state) for state in walk(problem(pair))] == [bits(state) for state in states]
    for name in ("pressure", "shear", "gap", "slip", "node_states"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(states[-1], name)[0] = 1
    forgetful, _ = contact.equilibrium(contact.unloaded_state(), 6.0, PATH[-1])
    assert np.abs(forgetful.shear - states[-1].shear).max() > 0.1 * np.abs(states[-1].shear).max()
    if pair == "like":
        np.testing.assert_allclose(forgetful.pressure, states[-1].pressure, atol=1e-12)


@pytest.mark.parametrize("pair", MATERIALS)
@settings(max_examples=8)
@given(st.lists(loads, min_size=1, max_size=5))
def test_every_law_holds_along_any_path(pair, path):
    """Laws, energy, friction that only takes; and Q -> -Q: p(x) -> p(-x), q(x) -> -q(-x), s(x) ->
    -s(-x).
    """
    contact = problem(pair)
    states = walk(contact, path)
    mirrored = walk(contact, [(p, -q) for p, q in path])
    for before, after in itertools.pairwise(states):
        assert max(law_violations(contact, [before, after]).values()) < 1e-9
        energy = increment_energies(contact, [before, after], [after.node_states])
        assert energy.external == pytest.approx(energy.elastic + energy.interface, abs=1e-12)
        assert np.all(energy.dissipation >= 0)
        assert float(after.shear @ (after.slip - before.slip)) >= -1e-12
    for state, mirror_state in zip(states, mirrored, strict=True):
        closed = state.node_states != SurfaceState.OPEN
        for name, sign in (("pressure", 1), ("shear", -1), ("gap", 1)):
            np.testing.assert_allclose(
                getattr(mirror_state, name), sign * getattr(state, name)[::-1], atol=1e-10
            )
        np.testing.assert_allclose(mirror_state.slip[::-1][closed], -state.slip[closed], atol=1e-10)
        assert mirror_state.shift == pytest.approx(-state.shift, abs=1e-10)


@pytest.mark.parametrize("layer", [1e-1, 1e-3])
def test_penalty_is_the_law_with_a_layer_between_the_faces(layer):
    """The inner faces keep the law exactly; the bodies overlap by layer times force, and creep by
    it.
    """
    contact = problem(layer=layer)
    states = walk(contact)
    for before, after in itertools.pairwise(states):
        assert max(law_violations(contact, [before, after]).values()) < 1e-9
    last = states[-1]
    sides = contact.interface
    bodies_gap = contact.initial_gap - last.approach + sides.normal_compliance @ last.pressure
    np.testing.assert_allclose(
        bodies_gap[last.is_closed], -layer * last.pressure[last.is_closed], atol=1e-12
    )
    bodies_slip = last.shift - sides.tangential_compliance @ last.shear
    np.testing.assert_allclose(bodies_slip, last.slip + layer * last.shear, atol=1e-12)


def test_too_few_iterations_raise_with_instant_loads_and_count(monkeypatch):
    # no second way out
    monkeypatch.setattr(
        ContactProblem, "_alternate_pressure_and_shear", lambda self, *rest: (None, 1, 1)
    )
    contact = problem(max_iterations=1)
    pressed, _ = problem().equilibrium(contact.unloaded_state(), 1.0, (1.0, 0.0))
    with pytest.raises(
        ConvergenceError,
        match=r"nodes still change state after \d+ iterations at time 2, normal load 1, tangential",
    ):
        contact.equilibrium(pressed, 2.0, (1.0, 0.45))


# ------------------------------------------------------------------------------ sets of node states


N = 30
SLIDING = 0.7
RNG = np.random.default_rng(7)


def random_systems(pair: str = "unlike", n: int = N, work: Counter[str] | None = None) -> Systems:
    """Two bodies of random compliance: flat and alike, or coupled on a face of random slopes."""
    normal, tangential = (half @ half.T / n + np.eye(n) for half in RNG.standard_normal((2, n, n)))
    coupling, slope = (
        (0.1 * RNG.standard_normal((n, n)), RNG.uniform(-0.2, 0.2, n))
        if pair == "unlike"
        else (None, np.zeros(n))
    )
    normals = np.stack([-slope, np.ones(n)]) / np.hypot(1, slope)
    none = np.zeros(n)
    faces = Interface(
        np.linspace(-1, 1, n), np.ones(n), normals, none, normal, tangential, coupling
    )
    return Systems(faces, Layer(none, none), SLIDING, Counter() if work is None else work)


def sets(count: int, n: int = N, every: int = 7, changes: int = 3) -> list[np.ndarray]:
    """States that go on from each other, a few nodes at a time, and now and then a jump."""
    states = np.full(n, STICK, dtype=np.int8)
    state_sets = []
    for number in range(count):
        changed = RNG.choice(n, changes if number % every else n, replace=False)
        states = states.copy()
        states[changed] = RNG.integers(0, 4, len(changed))
        states[n // 2] = STICK
        state_sets.append(states)
    return state_sets


def residual(
    set_systems: Systems,
    states: np.ndarray,
    loads: tuple[float, float],
    rows: np.ndarray,
    fixed: np.ndarray,
) -> float:
    """Worst violation of the equations that the states name, written out afresh, `given` being what
    some rows are to have.
    """
    values = set_systems.value_derivatives(states, 2, rows, fixed).T @ [*loads, 1.0]
    faces = set_systems.interface
    n = len(states)
    slip, p, q, gap = nodal_values(values)
    approach, shift, tilt = values[:3]
    n_x, n_y = faces.face_normals
    coupling = np.zeros((n, n)) if faces.coupling is None else faces.coupling
    found_gap = n_x * shift - n_y * approach + faces.normal_compliance @ p - coupling.T @ q
    found_slip = n_y * shift + n_x * approach + coupling @ p - faces.tangential_compliance @ q
    sign = np.select([states == FORWARD, states == REVERSE], [1.0, -1.0])
    expected = np.zeros(2 * n)
    expected[rows] = fixed
    normal = np.where(states == OPEN, p, gap)
    tangential = np.where(states == STICK, slip, q - sign * SLIDING * p)
    balance = [n_y @ p + n_x @ q - loads[0], n_y @ q - n_x @ p - loads[1], tilt]
    equations = [
        found_gap - gap,
        found_slip - slip,
        normal - expected[:n],
        tangential - expected[n:],
        balance,
    ]
    return float(np.abs(np.concatenate(equations)).max())


@pytest.mark.parametrize("pair", ["like", "unlike"])
def test_every_set_is_solved_to_rounding_and_few_are_factorised(pair: str) -> None:
    work: Counter[str] = Counter()
    set_systems = random_systems(pair, work=work)
    for number, states in enumerate(sets(40)):
        rows = RNG.choice(2 * N, number % 5 * 12, replace=False)
        assert (
            residual(set_systems, states, (1.0, 0.3), rows, RNG.standard_normal(len(rows))) < 1e-11
        )
    assert work["linear solves"] == 40
    assert 0 < work["factorisations"] < 12


@pytest.mark.parametrize("rows_apart", [2 * N, 25, 0])
def test_answers_of_a_base_are_updates_of_another_one_to_rounding(
    rows_apart: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As are those by factors of its own; of bases that are near enough one alone is factorised."""
    monkeypatch.setattr(systems, "_MOST_UPDATED_EQUATIONS", 12)
    monkeypatch.setattr(systems, "_MOST_EQUATIONS_FROM_ORIGIN", rows_apart)
    monkeypatch.setattr(systems, "_N_NEIGHBOURS", 2)
    set_systems = random_systems()
    for number, states in enumerate(sets(40)):
        rows = RNG.choice(2 * N, number % 5 * 12, replace=False)
        assert (
            residual(set_systems, states, (1.0, 0.3), rows, RNG.standard_normal(len(rows))) < 1e-11
        )
    n_factorised = set_systems.work_counts["factorisations"]
    assert sum(base.origin is None for base in set_systems._bases) == n_factorised
    n_bases = len(set_systems._bases)
    assert n_bases > 6
    assert {2 * N: n_factorised == 1, 25: 1 < n_factorised < n_bases, 0: n_factorised == n_bases}[
        rows_apart
    ]


def test_bodies_that_nothing_holds_are_no_answer():
    set_systems = random_systems()
    slides = np.full(N, FORWARD, dtype=np.int8)
    near = slides.copy()
    near[3] = STICK
    with pytest.raises(SingularSet):
        set_systems.value_derivatives(slides, 2)
    set_systems.value_derivatives(near, 2)  # a base from which the set above is one row away
    with pytest.raises(SingularSet):
        set_systems.value_derivatives(slides, 2)
    with pytest.raises(SingularSet):
        set_systems.value_derivatives(np.full(N, OPEN, dtype=np.int8), 2)


def test_a_compliance_that_is_not_positive_definite_is_refused() -> None:
    set_systems = random_systems("like")
    with pytest.raises(ConvergenceError, match="not positive definite"):
        Systems(
            replace(
                set_systems.interface,
                tangential_compliance=-set_systems.interface.tangential_compliance,
            ),
            set_systems.layer,
            SLIDING,
        )
    Systems(
        replace(
            set_systems.interface,
            tangential_compliance=-set_systems.interface.tangential_compliance,
        ),
        set_systems.layer,
        SLIDING,
        has_shear=False,
    )


@pytest.mark.parametrize("rows_apart", [0, 60])
@pytest.mark.parametrize("every", [40, 8])
def test_bytes_kept_stay_within_the_bound(
    every: int, rows_apart: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Room for two bases or three, with their answers; none suffers."""
    n = 60
    base_bytes = 8 * (122**2 + 120 * (3 + 2 * n))  # of a base all of whose answers are there
    monkeypatch.setattr(systems, "_MOST_BASE_BYTES", bound := 3 * base_bytes)
    monkeypatch.setattr(systems, "_FEWEST_BASES", 2)
    monkeypatch.setattr(systems, "_MOST_UPDATED_EQUATIONS", 40)
    monkeypatch.setattr(systems, "_MOST_EQUATIONS_FROM_ORIGIN", rows_apart)
    set_systems = random_systems(n=n)
    reached = []
    for states in sets(300, n, every):
        assert residual(set_systems, states, (1.0, 0.1), np.arange(2), np.ones(2)) < 1e-10
        factors = [base.factors for base in set_systems._bases if base.origin is None]
        matrices = [
            matrix for each in factors for matrix in (each.held_by_held[0], each.free_by_held)
        ]
        responses = [base.responses for base in set_systems._bases]
        reached.append(sum(array.nbytes for array in matrices + responses))
        # an origin stays as long as what has come from it
        assert all(
            base.origin is None or base.origin in set_systems._bases for base in set_systems._bases
        )
    assert max(reached) <= bound
    assert set_systems.work_counts["factorisations"] > (2 if rows_apart else 6)
    assert max(reached) > bound / 2  # or the bound was never met


# ----------------------------------------------------------------------- one half of mirrored faces


COARSER = MeshSettings(element_size=1 / 6, edge_element_size=1 / 10, far_radius=6.0, growth=0.5)
SHORT = SolverSettings(steps_per_cycle=16, step_tolerance=np.inf)
PENALTY = SolverSettings(
    steps_per_cycle=16,
    step_tolerance=np.inf,
    method="penalty",
    normal_stiffness=5.0,
    tangential_stiffness=5.0,
)


@pytest.mark.parametrize(
    ("name", "settings"), [("flat-rounded-paper", SHORT), ("hertz-paper", PENALTY)]
)
def test_half_the_nodes_give_the_answer_of_all(name, settings, monkeypatch):
    scene = load_scene(name)
    halved = halfplane_fe.solve(scene, COARSER, settings)
    assert "contact nodes" in halved.work.skipped
    monkeypatch.setattr(scales, "is_mirrored", lambda *_: False)
    full = halfplane_fe.solve(scene, COARSER, settings)
    for field in (
        "time",
        "pressure",
        "shear",
        "slip",
        "contact_edges",
        "stick_edges",
        "dissipation_density",
        "tangential_displacement",
    ):
        expected = getattr(full, field)
        half_value = getattr(halved, field)
        np.testing.assert_allclose(
            half_value, expected, rtol=0, atol=1e-8 * np.nanmax(np.abs(expected)), err_msg=field
        )
    np.testing.assert_array_equal(halved.state, full.state)
    assert halved.dissipation == pytest.approx(full.dissipation, rel=1e-11)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda sides: {"x": sides.x + 1e-3},
        lambda sides: {"gap": sides.gap + sides.x},
        lambda sides: {"face_normals": np.stack([0.1 * sides.x, np.ones_like(sides.x)])},
        lambda sides: {"face_lengths": sides.face_lengths * (1 + 0.1 * (sides.x > 0))},
        lambda sides: {"normal_compliance": sides.normal_compliance * (1 + 1e-6 * (sides.x > 0))},
        lambda sides: {"coupling": sides.normal_compliance},
    ],
    ids=["places", "gap", "slope", "weights", "compliance", "coupling"],
)
def test_faces_that_are_no_mirror_images_are_left_alone(spoil):
    interface = couple(*fe_run(load_scene("hertz-paper")).condensed_bodies)
    assert is_mirrored(interface, has_tangential_load=False)
    assert not is_mirrored(replace(interface, **spoil(interface)), has_tangential_load=False)
