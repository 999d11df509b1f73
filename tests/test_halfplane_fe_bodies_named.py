"""Named troubles of blocks, pads and cylinders, each with its sentence and exit code; and pairs turned upside down."""

import dataclasses
import importlib
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import halfplane_fe
from halfplane_fe import interface as pairs
from halfplane_fe.interface import couple
from halfplane_fe.mortar import Side, mortar
from meshes import MeshSettings, SurfaceGrading, solids
from reports.cli import main
from scenes import InadmissibleLoadError, InputError, load_scene

solving = importlib.import_module("halfplane_fe.solve")  # the package has a function of that name
ROOT = Path(__file__).parents[1]
COARSE = ("--order", "1", "--element-size", "0.25", "--edge-element-size", "0.125", "--growth", "1.0", "--steps-per-cycle", "8")
STEEL, ALUMINIUM = "{ young_modulus = 210e3, poisson_ratio = 0.3 }", "{ young_modulus = 70e3, poisson_ratio = 0.33 }"
HERTZ = '{ kind = "hertz", radius = 50.0 }'
FLAT = '{ kind = "flat_rounded", radius = 50.0, flat_half_length = 0.3 }'
BLOCK, PAD = '{ kind = "block", width = 12.0, height = 6.0 }', '{ kind = "pad", width = 6.0, height = 4.0 }'
LOOSE = '{ kind = "block", width = 12.0, height = 6.0, base = "rollers" }'
SHEARED = "[[500.0, 0.0], [500.0, 60.0]]"


def written(folder, lower=BLOCK, upper=PAD, initial_loading=SHEARED, profile=HERTZ, materials=(STEEL, STEEL)):
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


def scene(folder, *arguments, **others):
    return load_scene(written(folder, *arguments, **others))


# ---------------------------------------------------------------------------------------------------------- faults of input
FAULTS = {
    "slides off": (
        {"lower": LOOSE},
        "bodies.lower: nothing holds the block against the tangential load, it slides off: its base is on rollers and its sides "
        "are free; take base = 'fixed' or sides = 'guided'",
    ),
    "pad wider than its block": (
        {"upper": '{ kind = "pad", width = 13.0, height = 4.0 }'},
        "bodies is refused: the upper body, a pad of width 13, is wider than the block that it faces, of width 12: make the "
        "pad narrower or the block wider",
    ),
    "contact past the end of the face": (
        {"upper": '{ kind = "pad", width = 0.9, height = 4.0 }'},
        "bodies: the contact at the largest load reaches past the end of the narrower face, at |x| = 0.45: make the bodies wider, "
        "or the load less",
    ),
    "contact past the end of the face, sheared": (
        {"lower": '{ kind = "block", width = 0.9, height = 10.0 }', "upper": '{ kind = "pad", width = 0.9, height = 5.0 }'},
        "bodies: the contact at the largest load reaches past the end of the narrower face, at |x| = 0.45: make the bodies wider, "
        "or the load less",
    ),
    "pad too low": (
        {"upper": '{ kind = "pad", width = 11.0, height = 0.3 }'},
        "bodies.upper.height = 0.3 is refused: the pad's face goes as deep at its sides; make it higher",
    ),
    "separation": ({"initial_loading": "[[500.0, 0.0], [0.0, 0.0]]"}, "separation"),
    "gross sliding": ({"initial_loading": "[[500.0, 0.0], [500.0, -210.0]]"}, "gross sliding"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_of_input_end_in_one_sentence_and_exit_code_2(name, tmp_path, monkeypatch, capsys):
    changed, words = FAULTS[name]
    path = written(tmp_path, **changed)
    monkeypatch.chdir(tmp_path)
    assert main(["fe", path.name, "--quiet", *COARSE]) == 2
    printed = capsys.readouterr()
    told = " ".join(printed.err.split())
    if name in ("separation", "gross sliding"):  # with the loads and the instant, as for half-planes
        assert told.startswith("halfplane: scene.toml: ")
        assert words in told
        assert "time 2" in told
    else:
        assert told == f"halfplane: scene.toml: {words}"
    assert printed.out == ""
    assert [file.name for file in tmp_path.iterdir()] == ["scene.toml"]


def test_as_a_process_of_its_own_in_an_empty_folder(tmp_path):
    written(tmp_path, lower=LOOSE)
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-m", "reports", "run", "scene.toml", "--quiet", *COARSE]
    surroundings = os.environ | {"PYTHONPATH": path, "NO_COLOR": "1"}
    done = subprocess.run(command, cwd=tmp_path, env=surroundings, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 2, done
    assert "slides off" in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""


def test_without_a_tangential_load_rollers_hold(tmp_path):
    mesh = MeshSettings(element_size=1 / 4, edge_element_size=1 / 8, growth=1.0, order=1)
    pressed = halfplane_fe.solve(scene(tmp_path, lower=LOOSE, initial_loading="[[500.0, 0.0]]"), mesh)
    # Elastically the block spreads on its rollers and the pad does not: friction bears that, and nothing is left over.
    assert float(np.abs(pressed.tangential_load).max()) == 0
    assert pressed.pressure[-1] == pytest.approx(pressed.pressure[-1][::-1], rel=1e-8)


# ------------------------------------------------------------------------------------------------------------ not converged
def too_small(find_scales):
    """A coarse run that takes the contact for half as large as it is."""

    def planted(question, work):
        found = find_scales(question, work)
        return dataclasses.replace(found, half_width=0.5 * found.half_width, reach=0.5 * found.reach, inner=0.0)

    return planted


def test_contact_that_reaches_the_end_of_the_meshed_side_is_not_converged(tmp_path, monkeypatch, capsys):
    path = written(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(solving, "find_scales", too_small(solving.find_scales))
    assert main(["fe", path.name, "--quiet", *COARSE]) == 3
    complaint = " ".join(capsys.readouterr().err.split())
    assert complaint.startswith("halfplane: scene: not converged: the contact reached the end of the meshed side at |x| = 0.")
    assert "the coarse run took it for smaller, 0." in complaint
    assert list(tmp_path.rglob("partial*")), "what was solved is kept"


# ------------------------------------------------------------------------------------------------------- initial penetration
def humped(depth):
    """A pad whose face comes up again by `depth` beyond its point of first contact."""

    def planted(shape, profile):
        face = FACE_OF(shape, profile)
        if face.flat:
            return face
        return dataclasses.replace(face, depth=lambda x: face.depth(x) - depth * (np.abs(x) > 0.2), arc=None)

    return planted


FACE_OF = solids.face_of


@pytest.mark.parametrize("turned", [False, True])
def test_faces_that_overlap_before_any_load_are_refused(turned, tmp_path, monkeypatch):
    bodies = (PAD, BLOCK) if turned else (BLOCK, PAD)
    monkeypatch.setattr(solids, "face_of", humped(0.002))
    with pytest.raises(InputError, match=r"^bodies: initial penetration: the faces overlap by 0\.00[12]\d* at x = -?0\.\d+$"):
        halfplane_fe.solve(scene(tmp_path, *bodies), MeshSettings.coarse())


@pytest.mark.parametrize("overlap", [0.0, 1e-7, 1e-4])
def test_an_overlap_is_told_where_it_is_and_how_much(overlap, tmp_path):
    """Sides made by hand, 2.5e-3 high at their ends: an overlap of 1e-7 is the sag of an element, 1e-4 is not."""
    x = np.linspace(-0.5, 0.5, 41)
    coupled = mortar(Side(x, 0 * x, 2), Side(x, x**2 / 100 - overlap, 2))
    question = scene(tmp_path)
    faces = dataclasses.replace(interface_of(question), x=x, gap=coupled.gap, nearest=coupled.nearest)
    if overlap < 1e-5:
        np.testing.assert_allclose(pairs.initial_gap(question, faces), x**2 / 100 - overlap, atol=1e-6)
    else:
        with pytest.raises(InputError, match=r"the faces overlap by 9\.9\d*e-05 at x = -?0\.00\d*$"):
            pairs.initial_gap(question, faces)


def interface_of(question):
    settings = MeshSettings(order=1, growth=1.0)
    bodies = pairs.meshed_pair(question, settings, lambda ratio: SurfaceGrading(0.0, 1.0, 0.2 * ratio, 0.2 * ratio))
    return couple(*pairs.condensed_pair(question, bodies, 1.0, Counter()))


@pytest.mark.parametrize(("profile", "ratio"), [(HERTZ, 0.25), pytest.param(FLAT, 2 / 3, marks=pytest.mark.slow)])
def test_linear_sides_that_do_not_match_are_no_penetration(profile, ratio, tmp_path):
    """The weighted gap of a linear side is -h^2/6R at the middle: it was taken for an overlap and refused."""
    question = scene(tmp_path, profile=profile, initial_loading="[[500.0, 0.0]]")
    mesh = MeshSettings(element_size=1 / 8, edge_element_size=1 / 16, order=1, upper_ratio=ratio, growth=1.0)
    found = halfplane_fe.solve(question, mesh)
    matching = halfplane_fe.solve(question, dataclasses.replace(mesh, upper_ratio=1.0))
    assert found.contact_half_width[-1] == pytest.approx(matching.contact_half_width[-1], rel=0.05)


# -------------------------------------------------------------------------------------------------------------- gross sliding
def test_just_short_of_gross_sliding_every_node_but_a_few_slips(tmp_path):
    """Q = 0.999 f P on real bodies: the stick zone has all but gone, the law holds, the resultants too."""
    question = scene(tmp_path, initial_loading="[[500.0, 0.0], [500.0, 199.8]]")
    found = halfplane_fe.solve(question, MeshSettings.coarse())
    state = found.states[-1]
    assert found.tangential_load[-1] == pytest.approx(199.8)
    assert found.stick_half_width[-1] < 0.1 * found.contact_half_width[-1]
    assert np.all(np.abs(state.shear) <= 0.4 * state.pressure + 1e-10)


def test_sliding_is_refused_at_the_very_limit(tmp_path):
    with pytest.raises(InadmissibleLoadError, match="gross sliding") as caught:
        halfplane_fe.solve(scene(tmp_path, initial_loading="[[500.0, 0.0], [500.0, 200.0]]"), MeshSettings.coarse())
    assert (caught.value.time, caught.value.normal_load, caught.value.tangential_load) == (2.0, 500.0, 200.0)


# ------------------------------------------------------------------------------------------------------------ turned upside down
SMALL, LARGE = '{ kind = "cylinder", radius = 60.0 }', '{ kind = "cylinder", radius = 120.0 }'
TURNED = {
    "pad and block, like": (BLOCK, PAD, (STEEL, STEEL), HERTZ),
    "pad and block, unlike": (BLOCK, PAD, (STEEL, ALUMINIUM), HERTZ),
    "flat pad and block, unlike": (
        BLOCK,
        PAD,
        (ALUMINIUM, STEEL),
        '{ kind = "flat_rounded", radius = 50.0, flat_half_length = 0.3 }',
    ),
    "two cylinders, unlike": (SMALL, LARGE, (STEEL, ALUMINIUM), '{ kind = "hertz", radius = 40.0 }'),
}
LOOP = "[[500.0, 0.0], [500.0, 100.0], [500.0, -60.0]]"


def differences(one, other, turned):
    """Of p and q (L2 at the last instant) and of W, relative; `turned`: x -> -x between the two."""

    def at(solution, name):
        x, values = solution.x, getattr(solution, name)[-1]
        return np.interp(one.x, -x[::-1], values[::-1]) if turned else np.interp(one.x, x, values)

    apart = []
    for name in ("pressure", "shear"):
        plain = getattr(one, name)[-1]
        apart.append(float(np.linalg.norm(at(other, name) - plain) / np.linalg.norm(plain)))
    return np.array([*apart, abs(other.dissipation / one.dissipation - 1)])


def solved(name, folder, turned=False, size=1 / 10, ratio=1.0):
    lower, upper, materials, profile = TURNED[name]
    pair = (upper, lower, LOOP, profile, materials[::-1]) if turned else (lower, upper, LOOP, profile, materials)
    mesh = MeshSettings(element_size=size, edge_element_size=size / 2, growth=0.5, upper_ratio=ratio)
    return halfplane_fe.solve(scene(folder, *pair), mesh)


ONE_PLAIN = [pytest.param(name, marks=[] if name == "pad and block, unlike" else [pytest.mark.slow]) for name in TURNED]


@pytest.mark.parametrize("name", ONE_PLAIN)
def test_turned_upside_down_on_matching_sides_nothing_changes(name, tmp_path):
    """Half a turn takes p(x), q(x) to p(-x), q(-x) and leaves W: to rounding, for the middle line knows neither body's name."""
    plain, other = solved(name, tmp_path), solved(name, tmp_path, turned=True)
    assert np.all(differences(plain, other, turned=True) < 1e-8)
    assert differences(plain, other, turned=False)[1] > 0.1  # left unturned it would be another answer


@pytest.mark.slow
@pytest.mark.parametrize("name", TURNED)
def test_turned_upside_down_on_sides_that_do_not_match_changes_less_than_the_mesh_error(name, tmp_path):
    """Ratio 3 : 2 with the multipliers on one side and the other; mesh error: twice what halving every element changes (p and q
    converge to first order), of either."""
    size, ratio = 1 / 10, 1.5
    plain, other = solved(name, tmp_path, False, size, ratio), solved(name, tmp_path, True, size * ratio, 1 / ratio)
    mesh_error = differences(plain, solved(name, tmp_path, False, size / 2, ratio), turned=False)
    mesh_error += differences(other, solved(name, tmp_path, True, size * ratio / 2, 1 / ratio), turned=False)
    assert np.all(differences(plain, other, turned=True) < 2 * mesh_error)
    assert np.all(2 * mesh_error < [0.1, 0.6, 0.08])  # an error large enough would hide anything
