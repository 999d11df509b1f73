"""The whole answer: closed forms of every field, where it is evaluated, what is skipped, what is refused."""

import math

import numpy as np
import pytest

from scenes import ContactSolution, Elastic, InadmissibleLoadError, InputError, Materials, SurfaceState, load_scene, scene_names
from semi_analytic import FIELDS, solve
from semi_analytic.hertz import HertzContact
from semi_analytic_cases import ellipse, make_scene, polygon

P = 90.62286500739786  # a = 1 in the library's Hertz scenes
P0 = 2 * P / math.pi
MODULUS = 210e3 / (2 * 0.91)
X = np.array([-1.2, -1.0, -0.9, -0.3, 0.0, 0.3, 0.632, 0.633, 0.9, 0.999, 1.0, 1.2])


def cattaneo(x, load, share, friction):
    """q under first loading to Q = share f P, constant P: f p less the same at P - Q/f (misprint of equation (2) mended)."""
    stick = math.sqrt(1 - share)
    return friction * P0 * (np.sqrt(np.maximum(1 - x**2, 0)) - np.sqrt(np.maximum(stick**2 - x**2, 0)))


def test_hertz_pressed_once():
    solution = solve(load_scene("hertz-normal"), x=X, time=[0.25, 1.0])
    np.testing.assert_allclose(solution.contact_half_width, [0.5, 1.0], rtol=1e-15)
    np.testing.assert_allclose(solution.pressure[1], P0 * np.sqrt(np.maximum(1 - X**2, 0)), atol=1e-13 * P0)
    np.testing.assert_allclose(solution.pressure[0], P0 * np.sqrt(np.maximum(0.25 - X**2, 0)), atol=1e-13 * P0)
    assert np.all(solution.shear == 0)
    assert solution.steady_from is None
    assert solution.record.termination == "end of path"
    # A/pi int_0^P ln(2 L/a) d eta = (2 P/(pi E*)) (ln(2 L/a) + 1/2), L = R = 1000
    assert solution.normal_approach[1] == pytest.approx(2 * P / (math.pi * MODULUS) * (math.log(2000) + 0.5), rel=1e-14)


def test_cattaneo_mindlin_first_loading_and_reversal():
    scene = load_scene("cattaneo-mindlin")
    friction, share = 0.5, 0.6
    solution = solve(scene, x=X, time=[2.0, 2.5, 3.0])
    np.testing.assert_allclose(solution.shear[0], cattaneo(X, P, share, friction), atol=1e-13 * P0)
    np.testing.assert_allclose(solution.shear[2], -solution.shear[0], atol=1e-13 * P0)
    reversal = cattaneo(X, P, share, friction) - 2 * cattaneo(X, P, share / 2, friction)
    np.testing.assert_allclose(solution.shear[1], reversal, atol=1e-13 * P0)
    np.testing.assert_allclose(solution.stick_half_width, np.sqrt([1 - share, 1 - share / 2, 1 - share]), rtol=1e-14)
    np.testing.assert_allclose(solution.stick_edges[:, 0], -solution.stick_half_width)
    assert solution.permanent_stick_half_width == pytest.approx(math.sqrt(0.4), rel=1e-14)
    slipping = np.where(np.abs(X) > 1, SurfaceState.OPEN, np.where(np.abs(X) > math.sqrt(0.4), SurfaceState.SLIP_FORWARD, 1))
    inside = np.abs(np.abs(X) - 1) > 1e-9
    np.testing.assert_array_equal(solution.state[0, inside], slipping[inside])


def test_slip_is_the_elastic_mismatch_and_vanishes_where_it_sticks():
    """Cattaneo-Mindlin at the edge: s(a) = (A/pi) f int_{P_c}^P arccosh(a/a(eta)) d eta, here done by Gauss' rule."""
    solution = solve(load_scene("cattaneo-mindlin"), x=X, time=[2.0])
    node, weight = np.polynomial.legendre.leggauss(60)
    a = 1 - (1 - math.sqrt(0.4)) * ((1 - node) / 2) ** 2  # graded towards a = 1
    jacobian = (1 - math.sqrt(0.4)) * (1 - node) / 2
    exact = 2 / (math.pi * MODULUS) * 0.5 * np.sum(weight * jacobian * 2 * P * a * np.arccosh(1 / a))
    assert solution.slip[0, 10] == pytest.approx(exact, rel=1e-12)
    assert np.all(solution.slip[0, 3:7] == 0)
    assert np.all(np.diff(solution.slip[0, 6:11]) > 0)


@pytest.mark.parametrize("name", [*scene_names()])
def test_every_library_scene_is_admissible_at_every_point(name):
    """Inside the cone, at the limit where it slips, forces carried, edges in order."""
    scene = load_scene(name)
    edge = np.max(solve(scene, x=[0.0], fields=()).contact_half_width)
    solution = solve(scene, x=edge * np.linspace(0, 1.05, 15), fields=("pressure", "shear", "state"))
    friction = scene.friction.coefficient
    limit = friction * solution.pressure
    size = np.max(limit)
    assert np.all(solution.pressure >= 0)
    assert np.all(np.abs(solution.shear) <= limit + 1e-13 * size)
    forward, reverse = (solution.state == state for state in (SurfaceState.SLIP_FORWARD, SurfaceState.SLIP_REVERSE))
    np.testing.assert_allclose(solution.shear[forward], limit[forward], atol=3e-13 * size)
    np.testing.assert_allclose(solution.shear[reverse], -limit[reverse], atol=3e-13 * size)
    assert np.all(solution.pressure[solution.state == SurfaceState.OPEN] == 0)
    assert np.nanmax(solution.stick_half_width - solution.contact_half_width) <= 1e-15 * edge
    assert max(np.max(values) for values in solution.record.certificates.values()) < 1e-12
    assert solution.time.shape == solution.tangential_displacement.shape == solution.pressure.shape[:1]


@pytest.mark.parametrize("name", ["hertz-paper", "cattaneo-mindlin", "motor"])
def test_slip_goes_with_the_shear_and_stick_stands_still(name):
    """Between neighbouring instants of one span: slip grows where q = f p, falls where q = -f p, rests where it sticks."""
    solution = solve(load_scene(name))
    scale = np.max(np.abs(solution.slip))
    step = np.diff(solution.slip, axis=0)
    same = solution.state[1:] == solution.state[:-1]
    assert np.all(step[same & (solution.state[1:] == SurfaceState.SLIP_FORWARD)] >= -1e-14 * scale)
    assert np.all(step[same & (solution.state[1:] == SurfaceState.SLIP_REVERSE)] <= 1e-14 * scale)
    np.testing.assert_allclose(step[same & (solution.state[1:] == SurfaceState.STICK)], 0, atol=1e-13 * scale)


@pytest.mark.parametrize("name", ["hertz-paper", "motor"])
def test_tractions_carry_the_loads(name):
    """int p dx = P and int q dx = Q, from 4000 points in x = a sin(angle)."""
    scene = load_scene(name)
    own = solve(scene, fields=())
    number = np.array([150, 333, 470, 600, 811])
    for k in number:
        angle = (np.arange(4000) + 0.5) / 4000 * np.pi - np.pi / 2
        half = own.contact_half_width[k]
        at = solve(scene, x=half * np.sin(angle), time=[own.time[k]], fields=("pressure", "shear"))
        weight = half * np.cos(angle) * np.pi / 4000
        assert np.sum(weight * at.pressure[0]) == pytest.approx(own.normal_load[k], rel=1e-6)
        assert np.sum(weight * at.shear[0]) == pytest.approx(own.tangential_load[k], abs=2e-5 * own.normal_load[k])


def test_tangential_displacement_follows_the_flat_punches():
    """Full stick along a line: U = (Q/P) times the normal approach, A being the same for both."""
    solution = solve(load_scene("full-stick"))
    np.testing.assert_allclose(solution.tangential_displacement, 0.4 * solution.normal_approach, rtol=1e-12)


@pytest.mark.parametrize("name", ["hertz-paper", "motor"])
def test_mirrored_path_mirrors_everything(name):
    scene = load_scene(name)
    load = scene.load.vary(
        mean_tangential_load=-scene.load.mean_tangential_load,
        phase_degrees=scene.load.phase_degrees - 180,
        initial_loading="straight",
    )
    one = solve(scene.vary(load={"initial_loading": "straight"}), x=1.0071 * X)
    two = solve(
        scene.vary(load=load),
        x=1.0071 * X,
        time=one.time - one.scene.load.path().cycle_start + load.path().cycle_start,
    )
    scale = np.max(np.abs(one.shear))
    np.testing.assert_allclose(two.shear, -one.shear, atol=1e-12 * scale)
    np.testing.assert_allclose(two.slip, -one.slip, atol=1e-12 * np.max(np.abs(one.slip)))
    np.testing.assert_allclose(two.pressure, one.pressure, atol=1e-12 * scale)
    np.testing.assert_allclose(two.dissipation_density, one.dissipation_density, atol=1e-12 * np.max(one.dissipation_density))
    swapped = np.array([0, 1, 3, 2])[one.state]
    assert np.mean(two.state != swapped) < 2e-3  # instants exactly between two spans may fall to either


def test_straight_steps_converge_on_the_smooth_path_with_order_two():
    scene = load_scene("hertz-paper")
    exact = solve(scene, fields=("dissipation",))
    start = scene.load.path().start
    errors = []
    for count in (200, 400, 800):
        time = np.linspace(start, start + np.pi + 4 * np.pi, 5 * count // 2 + 1)
        rough = solve(scene, x=[0.0], time=time, fields=("dissipation",), straight_steps=True)
        assert rough.steady_from == 1
        errors.append(rough.dissipation / exact.dissipation - 1)
    ratios = np.array(errors[:-1]) / errors[1:]
    assert np.all((ratios > 3.5) & (ratios < 4.5)), errors


def test_straight_steps_of_a_polygon_change_nothing():
    scene = load_scene("cattaneo-mindlin")
    time = np.arange(0.125, 7.01, 0.125)
    one, two = solve(scene, x=X, time=time), solve(scene, x=X, time=time, straight_steps=True)
    for name in ("shear", "slip", "tangential_displacement", "stick_half_width", "dissipation_density", "cycle_dissipation"):
        np.testing.assert_allclose(getattr(one, name), getattr(two, name), rtol=1e-11, atol=1e-13 * P0, err_msg=name)


def test_instants_in_any_order_and_far_ahead():
    scene = load_scene("hertz-paper")
    start = scene.load.path().cycle_start
    time = np.array([9.0, 2.0, 30.0, start, 16.0])
    mixed = solve(scene, x=X, time=time)
    for k, instant in enumerate(time):
        np.testing.assert_allclose(solve(scene, x=X, time=[instant]).shear[0], mixed.shear[k], atol=1e-12 * P0)
    ahead = solve(scene, x=X, time=[16.0, 16.0 + 200 * np.pi])
    np.testing.assert_allclose(ahead.shear[1], ahead.shear[0], atol=1e-10 * P0)


def test_only_what_is_asked_for_is_computed():
    scene = load_scene("hertz-paper")
    solution = solve(scene, fields=("dissipation",), cycles="steady")
    for name in ("pressure", "shear", "slip", "dissipation_density", "tangential_displacement"):
        assert np.all(np.isnan(getattr(solution, name)))
        assert solution.work.skipped[name] == (len(solution.time), "not asked for")
    assert solution.cycle_dissipation.shape == (1,)
    assert solution.work.counts["slip_quadratures"] == 5
    assert solution.work.skipped["cycles"][0] == 4
    assert solution.time[0] == pytest.approx(scene.load.path().cycle_start + 2 * np.pi)
    everything = solve(scene)
    assert set(FIELDS).isdisjoint(everything.work.skipped)
    assert solution.dissipation == everything.dissipation


def test_full_stick_takes_no_quadrature_and_the_figure_alone_no_field(monkeypatch):
    """Nothing slips: no slip area is asked of the profile. The global figure alone: no pointwise kernel is."""
    stuck = load_scene("full-stick")
    monkeypatch.setattr(HertzContact, "dissipation_kernel", None)
    counts = solve(stuck, x=X, fields=("dissipation", "dissipation_density")).work.counts
    assert counts["slip_quadratures"] == counts["quadrature_nodes"] == 0
    monkeypatch.undo()
    for kernel in ("pressure", "slip_integral", "arccosh_ratio", "inverse_root"):
        monkeypatch.setattr(HertzContact, kernel, None)
    assert solve(load_scene("hertz-paper"), fields=("dissipation",)).dissipation > 0


@pytest.mark.parametrize(("time", "lost"), [(0.5, 0.5 * P), (2.0, 0.7 * P)], ids=["contact", "front"])
def test_a_half_width_that_was_not_found_stops_the_answer(monkeypatch, time, lost):
    """An inverse that leaves NaN behind for some load, of the contact or of the front of slip alone, goes no further."""
    found = HertzContact.half_width

    def missing(self, load):
        return np.where(np.abs(np.asarray(load) - lost) < 1e-6, np.nan, found(self, load))

    scene = make_scene(polygon([(P, 0.0), (P, 0.3 * P)]))
    assert np.isfinite(solve(scene, time=[time]).stick_half_width.item())
    monkeypatch.setattr(HertzContact, "half_width", missing)
    with pytest.raises(ArithmeticError, match="no half-width was found for the normal load"):
        solve(scene, time=[time])


def test_paper_scene_effort_is_bounded():
    """Effort as a number, not a time: two cycles solved of six, five pieces alive at most."""
    counts = solve(load_scene("hertz-paper")).work.counts
    assert counts["cycles_solved"] == 2
    assert counts["spans"] == 15
    assert counts["pieces_alive"] <= 5
    assert counts["points_evaluated"] == 100


def test_solution_survives_the_file(tmp_path):
    solution = solve(load_scene("hertz-paper"), x=X)
    solution.save(tmp_path / "solution.nc")
    again = ContactSolution.load(tmp_path / "solution.nc")
    np.testing.assert_array_equal(again.shear, solution.shear)
    assert again.record.notes == solution.record.notes
    assert not solution.shear.flags.writeable


def test_unlike_bodies_come_with_a_note():
    scene = load_scene("hertz-paper")
    pair = Materials(upper=Elastic(young_modulus=70e3, poisson_ratio=0.33), lower=Elastic(young_modulus=210e3, poisson_ratio=0.3))
    notes = solve(scene.vary(material=pair), x=[0.0], fields=()).record.notes
    assert "Dundurs' beta = " in notes[0]
    assert not any("Dundurs" in note for note in solve(scene, x=[0.0], fields=()).record.notes)


@pytest.mark.parametrize(
    ("load", "friction", "reason", "time", "normal", "tangential"),
    [
        (polygon([(2.0, 0.0)], [(2.0, 1.5), (2.0, -1.5)]), 0.5, "gross sliding", 1 + 2 / 3, 2.0, 1.0),
        (polygon([(2.0, 0.0), (2.0, -3.0)]), 0.5, "gross sliding", 1 + 1 / 3, 2.0, -1.0),
        (polygon([(2.0, 0.0), (-2.0, 0.0)]), 0.5, "separation", 1.5, 0.0, 0.0),
        (polygon([(1.0, 0.8)]), 0.5, "gross sliding", 0.0, 0.0, 0.0),
        (ellipse(1.0, 1.5, 0.0, 0.0, 0.0), 0.5, "separation", math.pi, -0.5, 0.0),
        (ellipse(3.0, 0.0, 0.0, 2.0, 90.0), 0.5, "gross sliding", None, None, None),
        (polygon([(2.0, 0.1)]), 0.0, "gross sliding", 0.0, 0.0, 0.0),
    ],
)
def test_inadmissible_paths_name_the_instant_and_the_loads(load, friction, reason, time, normal, tangential):
    with pytest.raises(InadmissibleLoadError, match=reason) as caught:
        solve(make_scene(load, friction))
    if time is not None and reason != "separation":
        assert (caught.value.time, caught.value.normal_load, caught.value.tangential_load) == pytest.approx(
            (time, normal, tangential), abs=1e-7
        )


def test_the_ellipse_of_the_paper_slides_where_equation_25_mended_says():
    """P0/P1 > sqrt(1 + f^2)/f for a circle with Q0 = 0: just above it a solution, just below none, at f = 0.5."""
    least = math.sqrt(1.25) / 0.5
    assert solve(make_scene(ellipse(least * (1 + 1e-12), 1.0, 0.0, 1.0), 0.5), x=[0.0], fields=("dissipation",)).dissipation > 0
    with pytest.raises(InadmissibleLoadError):
        solve(make_scene(ellipse(least * (1 - 1e-9), 1.0, 0.0, 1.0), 0.5))


def test_sliding_just_reached_is_admitted():
    """|Q| = f P: all of Hertz slips, of a flat face only the edges."""
    load = polygon([(2.0, 0.0)], [(2.0, 1.0), (2.0, -1.0)])
    hertz = solve(make_scene(load, 0.5), time=[2.0])
    assert np.isnan(hertz.stick_half_width[0]) or hertz.stick_half_width[0] < 1e-7
    np.testing.assert_allclose(hertz.shear, 0.5 * hertz.pressure, atol=1e-15)
    flat = solve(make_scene(load, 0.5, flat=0.3), time=[2.0])
    assert flat.stick_half_width[0] == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"fields": ("presure",)}, "'presure' is not among"),
        ({"cycles": "last"}, "neither 'all' nor 'steady'"),
        ({"straight_steps": True}, "give the times"),
        ({"time": [-5.0]}, "outside the load path"),
        ({"time": [[1.0]]}, "a list of finite numbers"),
        ({"x": [float("nan")]}, "a list of finite numbers"),
        ({"time": [2.0, 2.0], "straight_steps": True}, "must ascend"),
        ({"time": [load_scene("hertz-paper").load.path().start], "straight_steps": True}, "no time is after the start"),
    ],
)
def test_bad_questions_are_refused_in_a_sentence(options, words):
    with pytest.raises(InputError, match=words):
        solve(load_scene("hertz-paper"), **options)
