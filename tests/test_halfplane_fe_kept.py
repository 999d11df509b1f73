"""What is kept of factorisations: bounds of bytes hold, the longest unused gives way, and a tiny bound changes no answer."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import halfplane_fe
from halfplane_fe import active_subsets
from halfplane_fe.active_subsets import Kept
from halfplane_fe.interface import Interface
from meshes import MeshSettings
from scenes import Block, Bodies, EllipseLoad, Hertz, Materials, Pad, SurfaceState, load_scene

BOUND = 100
PUTS = st.lists(st.tuples(st.sampled_from("abcdefgh"), st.integers(0, 60), st.booleans()), max_size=60)


def held(kept: Kept[int]) -> dict[bytes, int]:
    return dict(kept.items())


@given(PUTS)
def test_the_bound_holds_and_the_longest_unused_gives_way(puts: list[tuple[str, int, bool]]) -> None:
    """Against a list in the order of use, the plainest thing that could be right."""
    kept: Kept[int] = Kept(BOUND)
    by_use: list[tuple[bytes, int]] = []
    for name, size, asked in puts:
        key = name.encode()
        known = next((pair for pair in by_use if pair[0] == key), None)
        if asked:
            assert kept.get(key) == (None if known is None else known[1])
        if known is not None:
            if asked:
                by_use.remove(known)
                by_use.append(known)
            continue  # a value that is there is not put again
        kept.put(key, size, size)
        by_use.append((key, size))
        while sum(size for _, size in by_use) > BOUND and len(by_use) > 1:
            by_use.pop(0)
        assert held(kept) == dict(by_use)
    assert sum(held(kept).values()) <= BOUND


def test_a_value_larger_than_the_bound_is_kept_alone() -> None:
    kept: Kept[str] = Kept(10)
    assert kept.put(b"small", "small", 6) == "small"
    assert kept.put(b"large", "large", 60) == "large"
    assert dict(kept.items()) == {b"large": "large"}
    kept.put(b"next", "next", 6)
    assert dict(kept.items()) == {b"next": "next"}


def test_put_again_counts_its_new_bytes_alone() -> None:
    kept: Kept[int] = Kept(10)
    for number in range(20):
        kept.put(b"same", number, 6)
    kept.put(b"other", 1, 4)
    assert dict(kept.items()) == {b"same": 19, b"other": 1}


SCENE = load_scene("hertz-paper").vary(
    profile=Hertz(radius=50.0),
    bodies=Bodies(lower=Block(width=12.0, height=6.0), upper=Pad(width=6.0, height=4.0)),
    material=Materials.model_validate(
        {"lower": {"young_modulus": 210e3, "poisson_ratio": 0.3}, "upper": {"young_modulus": 70e3, "poisson_ratio": 0.33}}
    ),
    load=EllipseLoad(
        mean_normal_load=600.0, normal_amplitude=200.0, mean_tangential_load=20.0, tangential_amplitude=70.0, phase_degrees=90.0
    ),
    friction=load_scene("hertz-paper").friction.vary(coefficient=0.4),
    cycles=1,
)
MESH = MeshSettings(element_size=1 / 8, edge_element_size=1 / 16, growth=0.5)


def unlike_factor(n: int) -> active_subsets.CoupledFactor:
    """A coupled system of n nodes with nothing special about it."""
    rng, zero = np.random.default_rng(5), np.zeros(n)
    normal, tangential = (half @ half.T / n + np.eye(n) for half in rng.standard_normal((2, n, n)))
    coupling = 0.1 * rng.standard_normal((n, n))
    flat = np.stack([zero, zero + 1])
    faces = Interface(np.linspace(-1, 1, n), zero + 1, flat, zero, normal, tangential, coupling)
    return active_subsets.CoupledFactor(faces, normal, tangential, coupling, 0.5, Counter())


@pytest.fixture(scope="module")
def plain() -> halfplane_fe.FiniteElementSolution:
    return halfplane_fe.solve(SCENE, MESH)


def test_a_tiny_bound_changes_no_answer(plain: halfplane_fe.FiniteElementSolution, monkeypatch: pytest.MonkeyPatch) -> None:
    """With room for one base and one change the same sets are met and the same forces found, by more work."""
    monkeypatch.setattr(active_subsets, "_COUPLED_BYTES", 1)
    tight = halfplane_fe.solve(SCENE, MESH)
    assert tight.work.counts["factor updates"] > 1.2 * plain.work.counts["factor updates"]
    np.testing.assert_array_equal(tight.state, plain.state)
    for name in ("pressure", "shear", "slip"):
        one, other = getattr(plain, name), getattr(tight, name)
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-9 * np.nanmax(np.abs(one)))
    assert tight.dissipation == pytest.approx(plain.dissipation, rel=1e-9)


def test_factors_are_updated_far_more_often_than_made(plain: halfplane_fe.FiniteElementSolution) -> None:
    counts = plain.work.counts
    assert counts["factor updates"] > 5 * counts["factorisations"]
    assert counts["linear solves"] > counts["factor updates"]


def bytes_reached(factor: active_subsets.CoupledFactor) -> tuple[int, int]:
    """Bytes of all bases with their columns, and of all changes, that the caches reach in fact, not what they were told."""
    changes = [change for _, change in factor._changes.items()]
    bases = {id(base): base for base in [*(base for _, base in factor._bases.items()), *(change.base for change in changes)]}
    by_bases = sum(base.factors[0].nbytes + sum(column.nbytes for column in base.columns.values()) for base in bases.values())
    return by_bases, sum(change.columns.nbytes for change in changes)


@pytest.mark.parametrize(("every", "few"), [(40, 3), (8, 2)])
def test_bytes_kept_stay_within_the_bound(every: int, few: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Room for two bases or three: columns count, and no change keeps a base that was forgotten."""
    factor, rng = unlike_factor(60), np.random.default_rng(3)
    bound = 3 * 8 * 2 * 122**2
    monkeypatch.setattr(active_subsets, "_COUPLED_BYTES", bound)
    factor.__post_init__()
    reached, states = [], np.full(60, SurfaceState.STICK, dtype=np.int8)
    for number in range(300):
        changed = rng.choice(60, 60 if number % every == 0 else few, replace=False)
        states = states.copy()
        states[changed] = rng.integers(0, 4, len(changed))
        states[30] = SurfaceState.STICK
        factor.solve(states, np.zeros(60), np.zeros(60), (1.0, 0.1))
        reached.append(bytes_reached(factor))
    most = np.max(reached, axis=0)
    assert np.all(most <= bound), most / bound
    assert factor.work["factorisations"] > 6
    assert most[0] > bound / 5  # or the bound was never met
