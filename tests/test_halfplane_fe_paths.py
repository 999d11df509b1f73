"""Where increments end, which paths have no solution, named troubles of bodies, and pairs turned
upside down.
"""

from __future__ import annotations

import dataclasses
import importlib
import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import halfplane_fe
from halfplane_fe import check_admissible, scales
from halfplane_fe.path import stretches, time_of_zero, turning_points
from halfplane_fe.scales import largest_load
from meshes import MeshSettings, solids
from refusals import require_facts
from reports.checking import nearest_to_sliding
from reports.cli import main
from scenes import (
    EllipseLoad,
    HarmonicLoad,
    InadmissibleLoadError,
    InputError,
    PolygonLoad,
    ellipse_segment,
    load_scene,
)

TURN = 2 * math.pi


def looped(phase=90.0, **changed):
    values = {
        "mean_normal_load": 3,
        "normal_amplitude": 1,
        "mean_tangential_load": 0.2,
        "tangential_amplitude": 1,
    }
    return EllipseLoad(**(values | {"phase_degrees": phase} | changed))


# ----------------------------------------------------------------------------------- turning points


@pytest.mark.parametrize("steepness", [0.0, 2.0, 3.0])
def test_secants_find_a_zero_without_scipy_optimize(steepness, monkeypatch):
    """To import it takes a tenth of a second; bent functions took more secants than were allowed,
    in `hertz-paper` twice.
    """
    monkeypatch.setattr("scipy.optimize.brentq", None)

    def bent(time):
        return math.expm1(steepness * (time - 0.5)) if steepness else time - 0.5

    assert time_of_zero(bent, 0.0, 1.0, 0.1, bent(0.0)) == pytest.approx(0.5, abs=1e-15)


def test_where_secants_leave_the_range_a_bracket_finds_the_zero():
    def steep(time):
        return math.atan(20 * (time - 0.9))

    assert time_of_zero(steep, 0.0, 1.0, 0.1, steep(0.0)) == pytest.approx(0.9, abs=1e-15)


def test_a_load_that_rests_at_first_has_its_zero_later_or_not_at_all():
    """The first secant is flat; the instant that was tried first was returned."""

    def resting(time):
        return max(time - 0.5, 0.0) - 0.3

    assert time_of_zero(resting, 0.0, 1.0, 0.4, resting(0.0)) == pytest.approx(0.8, abs=1e-14)
    assert time_of_zero(lambda _: 1.0, 0.0, 1.0, 0.4, 1.0) == 1.0


@given(phase=st.floats(10, 170), friction=st.floats(0.3, 2), start=st.floats(0, TURN))
def test_turning_points_of_an_ellipse(phase, friction, start):
    """P turns at 0 and pi; Q -+ f P, sinusoids too, where their rates vanish: six in a revolution,
    two half a turn apart each.
    """
    leg = ellipse_segment(start, start + TURN, (3, 0.2), (1, 0.7), math.radians(phase))
    tangential = 0.7 * np.exp(-1j * math.radians(phase))
    phases = [-np.angle(tangential - sign * friction) for sign in (1, -1)] + [0.0]
    expected = np.sort(
        start + (np.array([p + half for p in phases for half in (0, math.pi)]) - start) % TURN
    )
    turns = np.array(turning_points(leg, friction))
    distances = np.diff(np.append(expected, expected[0] + TURN))
    if distances.min() > 1e-3 and min(expected[0] - start, start + TURN - expected[-1]) > 1e-3:
        np.testing.assert_allclose(turns, expected, atol=1e-11)
    for time in turns:
        p, q = leg.rates(time)
        assert min(abs(p), abs(q - friction * p), abs(q + friction * p)) < 1e-9


def test_every_turn_of_a_high_harmonic_is_found():
    """Q = 10 sin t + 30 sin(k t): its rate has a zero next to each of cos(k t), however few samples
    an ellipse would need.
    """
    order = 300
    leg = (
        HarmonicLoad(
            mean_normal_load=90, tangential_harmonics=[(10, 90), *[(0, 0)] * (order - 2), (30, 90)]
        )
        .path()
        .cycle[0]
    )
    turns = np.array(turning_points(leg, 0.5))
    np.testing.assert_allclose(
        turns, (np.arange(2 * order) + 0.5) * math.pi / order, atol=1 / (2 * order**2)
    )


@pytest.mark.parametrize("order", [512, 720])
def test_sliding_between_the_samples_of_a_slow_path_is_refused(order):
    """512 and 720 samples of a turn all fall where sin(k t) is nothing."""
    load = HarmonicLoad(
        mean_normal_load=90, tangential_harmonics=[*[(0, 0)] * (order - 1), (50, 90)]
    )
    with pytest.raises(InadmissibleLoadError, match="gross sliding"):
        check_admissible(load.path(), 0.5)
    paper = load_scene("hertz-paper")
    scene = paper.vary(load=load, friction=0.5)
    assert nearest_to_sliding(scene).ratio == pytest.approx(50 / 45, rel=1e-9)


@given(phase=st.floats(10, 170), increments=st.floats(4, 200))
def test_stretches_cut_at_the_turning_points_and_leave_nothing_out(phase, increments):
    leg = ellipse_segment(1.0, 1.0 + TURN, (3, 0.2), (1, 0.7), math.radians(phase))
    pieces = stretches(leg, 0.8, increments)
    ends = [end for piece in pieces for end in piece.ends]
    assert np.all(np.diff(ends) > 0)
    assert ends[-1] == pytest.approx(leg.end, abs=1e-14)
    assert set(turning_points(leg, 0.8)) <= set(ends)
    assert [piece.start for piece in pieces[1:]] == [piece.ends[-1] for piece in pieces[:-1]]
    assert increments <= len(ends) <= increments + 2 * len(pieces)
    assert max(np.diff([leg.start, *ends])) <= TURN / increments * (1 + 1e-9)


@settings(max_examples=30)
@given(phase=st.floats(0, 360), number=st.integers(1, 40))
def test_the_largest_load_is_where_it_turns_round_not_at_a_sample(phase, number):
    """P0 + P_k, of a single harmonic of the normal load with any phase."""
    harmonics = ((0.0, 0.0),) * (number - 1) + ((20.0, phase),)
    load = HarmonicLoad(
        mean_normal_load=90.0,
        mean_tangential_load=0.0,
        normal_harmonics=harmonics,
        tangential_harmonics=((8.0, 0.0),),
    )
    assert largest_load(load_scene("harmonics").vary(load=load)) == pytest.approx(110.0, rel=1e-13)


# ------------------------------------------------------------------------------------ admissibility


ADMISSIBLE = {
    "the paper's": (looped(mean_tangential_load=1.1, initial_loading="parabola"), 1.0),
    "short of sliding": (PolygonLoad(initial_loading=[(1, 0), (1, 0.999999)]), 1.0),
    "no friction, no shear": (PolygonLoad(initial_loading=[(1, 0), (3, 0)]), 0.0),
    "unloaded almost": (PolygonLoad(initial_loading=[(1, 0)], cycle=[(1e-6, 0)]), 0.5),
    "down and up": (PolygonLoad(initial_loading=[(2, 0.5), (1, -0.4), (3, 1.4)]), 0.5),
}
REFUSED = {
    "sliding at a corner": (
        PolygonLoad(initial_loading=[(1, 0), (1, 0.6), (2, 0)]),
        0.5,
        "gross sliding",
        2.0,
        (1.0, 0.6),
    ),
    "exactly f P": (
        PolygonLoad(initial_loading=[(1, 0), (1, 0.5)]),
        0.5,
        "gross sliding",
        2.0,
        (1.0, 0.5),
    ),
    "sliding backwards": (
        PolygonLoad(initial_loading=[(1, 0), (1, -0.6)]),
        0.5,
        "gross sliding",
        2.0,
        (1.0, -0.6),
    ),
    "sliding on the initial loading": (
        PolygonLoad(initial_loading=[(1, 0.7), (2, 0)]),
        0.5,
        "gross sliding",
        1.0,
        (1.0, 0.7),
    ),
    "shear without friction": (
        PolygonLoad(initial_loading=[(1, 0), (1, 0.1)]),
        0.0,
        "gross sliding",
        2.0,
        (1.0, 0.1),
    ),
    "separation": (
        PolygonLoad(initial_loading=[(1, 0)], cycle=[(-0.5, 0)]),
        0.5,
        "separation",
        2.0,
        (-0.5, 0.0),
    ),
    "full unloading": (
        PolygonLoad(initial_loading=[(1, 0)], cycle=[(0, 0)]),
        0.5,
        "separation",
        2.0,
        (0.0, 0.0),
    ),
    "ellipse lifts off": (looped(normal_amplitude=4), 5.0, "separation", 3 * math.pi, (-1.0, 0.2)),
    "ellipse slides": (
        looped(normal_amplitude=0, tangential_amplitude=1.6),
        0.5,
        "gross sliding",
        math.pi / 2 + TURN,
        (3.0, 1.8),
    ),
}


@pytest.mark.parametrize("name", [*ADMISSIBLE, *REFUSED])
def test_inadmissible_paths_are_named_with_instant_and_loads(name):
    if name in ADMISSIBLE:
        load, friction = ADMISSIBLE[name]
        check_admissible(load.path(), friction)
        return
    load, friction, reason, time, loads = REFUSED[name]
    with pytest.raises(InadmissibleLoadError, match=reason) as caught:
        check_admissible(load.path(), friction)
    refusal = caught.value
    assert (refusal.time, refusal.normal_load, refusal.tangential_load) == pytest.approx(
        (time, *loads), abs=1e-9
    )
    assert (
        f"at time {refusal.time:.6g} with P = {refusal.normal_load:.6g}, Q ="
        f" {refusal.tangential_load:.6g}" in str(refusal)
    )
    assert "\n" not in str(refusal)


@pytest.mark.parametrize("loads", [(-0.5, 0.0), (0.0, 0.1)])
def test_the_sentence_on_separation_is_true_of_the_loads_that_it_names(loads):
    """P below 0, or P = 0 beside a tangential load."""
    load = PolygonLoad(initial_loading=[(1, 0)], cycle=[loads])
    with pytest.raises(
        InadmissibleLoadError,
        match="P is negative there, or 0 where Q is not 0, so the bodies part",
    ):
        check_admissible(load.path(), 0.5)


# ------------------------------------------------------------------------- named troubles of bodies


solving = importlib.import_module(
    "halfplane_fe.solution"
)  # the package has a function of that name
COARSE = (
    "--order",
    "1",
    "--element-size",
    "0.25",
    "--edge-element-size",
    "0.125",
    "--growth",
    "1.0",
    "--steps-per-cycle",
    "8",
)
STEEL = "{ young_modulus = 210e3, poisson_ratio = 0.3 }"


HERTZ = '{ kind = "hertz", radius = 50.0 }'
BLOCK = '{ kind = "block", width = 12.0, height = 6.0 }'
PAD = '{ kind = "pad", width = 6.0, height = 4.0 }'
LOOSE = '{ kind = "block", width = 12.0, height = 6.0, base = "rollers" }'
SHEARED = "[[500.0, 0.0], [500.0, 60.0]]"


def written(
    folder, lower=BLOCK, upper=PAD, initial_loading=SHEARED, profile=HERTZ, materials=(STEEL, STEEL)
):
    """A scene file: material of the lower body first."""
    text = [
        f"material = {{ lower = {materials[0]}, upper = {materials[1]} }}",
        f"profile = {profile}",
        "friction = { coefficient = 0.4 }",
        f'load = {{ kind = "polygon", initial_loading = {initial_loading} }}',
        f"bodies.lower = {lower}",
        f"bodies.upper = {upper}",
    ]
    path = folder / "scene.toml"
    path.write_text("\n".join(text), encoding="utf-8")
    return path


def bodies(folder, *arguments, **options):
    return load_scene(written(folder, *arguments, **options))


FAULTS = {
    "slides off": (
        {"lower": LOOSE},
        "bodies.lower|slides off|on rollers|base = 'fixed' or sides = 'guided'",
    ),
    "contact past the end of the face": (
        {"upper": '{ kind = "pad", width = 0.9, height = 4.0 }'},
        "bodies: the contact|past the end of the narrower face|= 0.45",
    ),
    "contact past the end of the face, sheared": (
        {
            "lower": '{ kind = "block", width = 0.9, height = 10.0 }',
            "upper": '{ kind = "pad", width = 0.9, height = 5.0 }',
        },
        "bodies: the contact|past the end of the narrower face|= 0.45",
    ),
    "pad too low": (
        {"upper": '{ kind = "pad", width = 11.0, height = 0.3 }'},
        "bodies.upper.height = 0.3|pad's face|make it higher",
    ),
    # with the loads and the instant, as for half-planes
    "separation": ({"initial_loading": "[[500.0, 0.0], [0.0, 0.0]]"}, "separation|time 2"),
    "gross sliding": (
        {"initial_loading": "[[500.0, 0.0], [500.0, -210.0]]"},
        "gross sliding|time 2",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_of_input_end_in_one_sentence_and_exit_code_2(name, tmp_path, monkeypatch, capsys):
    changed, words = FAULTS[name]
    path = written(tmp_path, **changed)
    monkeypatch.chdir(tmp_path)
    assert main(["fe", path.name, "--quiet", *COARSE]) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith("halfplane: scene.toml: ")
    require_facts(printed.err, *words.split("|"))
    assert printed.out == ""
    assert [file.name for file in tmp_path.iterdir()] == ["scene.toml"]


def test_without_a_tangential_load_rollers_hold(tmp_path):
    mesh = MeshSettings(element_size=1 / 4, edge_element_size=1 / 8, growth=1.0, order=1)
    pressed = halfplane_fe.solve(
        bodies(tmp_path, lower=LOOSE, initial_loading="[[500.0, 0.0]]"), mesh
    )
    # Elastically the block spreads on its rollers and the pad does not: friction bears that, and
    # nothing is left over.
    assert float(np.abs(pressed.tangential_load).max()) == 0
    assert pressed.pressure[-1] == pytest.approx(pressed.pressure[-1][::-1], rel=1e-8)


def too_small(find_scales):
    """A coarse run that takes the contact for half as large as it is."""

    def planted(question, work):
        scales = find_scales(question, work)
        return dataclasses.replace(
            scales, half_width=0.5 * scales.half_width, reach=0.5 * scales.reach, inner=0.0
        )

    return planted


def test_contact_that_reaches_the_end_of_the_meshed_side_is_not_converged(
    tmp_path, monkeypatch, capsys
):
    path = written(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(solving, "find_scales", too_small(solving.find_scales))
    assert main(["fe", path.name, "--quiet", *COARSE]) == 3
    require_facts(
        capsys.readouterr().err,
        "halfplane: scene: not converged",
        "end of the meshed side at |x| = 0.",
        "the coarse run took it for smaller, 0.",
    )
    assert list(tmp_path.rglob("partial*")), "what was solved is kept"


def humped(depth):
    """A pad whose face comes up again by `depth` beyond its point of first contact."""

    def planted(shape, profile):
        face = FACE_OF(shape, profile)
        if face.is_flat:
            return face
        return dataclasses.replace(
            face, depth=lambda x: face.depth(x) - depth * (np.abs(x) > 0.2), arc=None
        )

    return planted


FACE_OF = solids.face_of


@pytest.mark.parametrize("turned", [False, True])
def test_faces_that_overlap_before_any_load_are_refused(turned, tmp_path, monkeypatch):
    order = (PAD, BLOCK) if turned else (BLOCK, PAD)
    monkeypatch.setattr(solids, "face_of", humped(0.002))
    with pytest.raises(InputError, match=r"^bodies: .* overlap by 0\.00[12]\d* at x = -?0\.\d+$"):
        halfplane_fe.solve(bodies(tmp_path, *order), MeshSettings.coarse())


def test_linear_sides_that_do_not_match_are_no_penetration(tmp_path):
    """The weighted gap of a linear side is -h^2/6R at the middle: it was taken for an overlap and
    refused.
    """
    question = bodies(tmp_path, initial_loading="[[500.0, 0.0]]")
    mesh = MeshSettings(
        element_size=1 / 6, edge_element_size=1 / 12, order=1, upper_ratio=0.25, growth=1.0
    )
    answer = halfplane_fe.solve(question, mesh)
    matching = halfplane_fe.solve(question, dataclasses.replace(mesh, upper_ratio=1.0))
    assert answer.contact_half_width[-1] == pytest.approx(matching.contact_half_width[-1], rel=0.05)


def test_an_estimate_enlarges_the_side_that_the_contact_fills(monkeypatch):
    """A contact 1.5 wide on a side that was taken for 1 wide: how far it goes is not known yet."""
    monkeypatch.setattr(scales, "_half_width_on_half_planes", lambda pair: 1.0)
    monkeypatch.setattr(scales, "_contact_fraction", lambda pair, size: min(1.5 / size, 1.0))
    assert scales._zone_half_width(SimpleNamespace(largest_face_half_width=100.0)) == 2.0
