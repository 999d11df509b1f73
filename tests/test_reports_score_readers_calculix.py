"""What CalculiX 2.20 really wrote (tests/data/README.md), read as tractions: equilibrium decides every sign."""

from pathlib import Path

import numpy as np
import pytest

from calculix_files import DATA, edited, result
from reports.scoring.guesses import oddities
from reports.scoring.surface import free_face, tension, unbalanced
from scenes import InputError, load_scene

P, Q, FRICTION = 400.0, 60.0, 0.3
# What trapezia over the file's values lose or gain of P, measured, and twice that: edges fall within an element of 0.1 a/0.66.
ADDS_UP = {
    "node-to-surface.frd": 1e-3,  # 5.2e-4
    "node-to-surface.dat": 2e-3,  # 7.7e-4
    "mortar.frd": 1e-3,  # 4.8e-4
    "surface-to-surface.frd": 0.05,  # 0.021: nodal values of the linear face are extrapolated from its integration points
    "surface-to-surface.dat": 0.02,  # 0.010
}


def resultants(found):
    return np.trapezoid(found.pressure, found.x, axis=1), np.trapezoid(found.shear, found.x, axis=1)


@pytest.mark.parametrize("name", ADDS_UP)
def test_the_tractions_carry_the_loads_with_their_signs(name):
    found = result(name)
    normal, tangential = resultants(found)
    np.testing.assert_allclose(normal, [P, P], rtol=ADDS_UP[name])
    # Shear is loaded to half of sliding: the same edges, on a part of the pressure.
    np.testing.assert_allclose(tangential, [0.0, Q], atol=ADDS_UP[name] * P * FRICTION * 1.5)
    np.testing.assert_array_equal(found.time, [1.0, 2.0])
    assert np.all(np.diff(found.x) > 0)


@pytest.mark.parametrize("name", ADDS_UP)
def test_the_upper_body_slips_along_the_pull_and_friction_holds_the_cone(name):
    found = result(name)
    # 1e-5 of the peak: six digits in the file.
    assert np.all(np.abs(found.shear) <= FRICTION * np.abs(found.pressure) + 1e-5 * found.pressure.max())
    step = found.slip[1] - found.slip[0]
    slides = (np.abs(found.shear[1]) > 0.999 * FRICTION * found.pressure[1]) & (found.pressure[1] > 1.0)
    assert np.count_nonzero(slides) >= 2
    assert np.all(step[slides] > 0)
    assert np.all(found.shear[1][slides] > 0)


def test_either_body_as_slave_gives_the_same_tractions():
    lower, upper = result("node-to-surface.frd"), result("mortar.frd")
    peak = lower.pressure.max()
    inside = np.abs(lower.x) < 0.45
    for of in ("pressure", "shear"):
        other = np.array([np.interp(lower.x, upper.x, row) for row in getattr(upper, of)])
        # Measured 4.2 % of the peak for p, at x = 0 where node-to-surface dips; 2.0 % for q, stick edge between nodes.
        np.testing.assert_allclose(getattr(lower, of)[:, inside], other[:, inside], atol=0.06 * peak)
    assert "that of the lower body" in lower.notes[0]
    assert "that of the upper body" in upper.notes[0]


def test_the_pressure_is_that_of_hertz():
    found = result("mortar.frd")
    modulus, radius = 210000 / (1 - 0.3**2) / 2, 100.0
    half_width = np.sqrt(4 * P * radius / (np.pi * modulus))
    hertz = 2 * P / (np.pi * half_width**2) * np.sqrt(np.maximum(half_width**2 - found.x**2, 0.0))
    # Measured 0.045 of the peak: six elements a half-width, bodies of 3 mm. A wrong thickness is far off.
    inside = np.abs(found.x) < 0.8 * half_width
    assert np.max(np.abs(found.pressure[0] - hertz)[inside]) < 0.07 * hertz.max()


def test_loads_are_the_resultants_of_the_pair():
    for name in ("surface-to-surface.frd", "surface-to-surface.dat"):
        found = result(name)
        np.testing.assert_allclose(found.normal_load, [P, P], rtol=1e-4)
        np.testing.assert_allclose(found.tangential_load, [0.0, Q], atol=1e-4 * Q)
        assert any(
            "resultants of the contact pair in surface-to-surface.dat, divided by the mapping's thickness, 1" in n
            for n in found.notes
        )


def test_pressures_that_do_not_add_up_are_named():
    notes = result("surface-to-surface.frd").notes
    assert any("add up to 1.021 of the contact pair's resultant" in note for note in notes)
    assert not any("add up" in note for note in result("surface-to-surface.dat").notes)


def beside(tmp_path, force, normal):
    """The mortar run (0.5 thick) with resultants printed beside it, as CalculiX would."""
    text = ""
    for time, own in ((1.0, force[0]), (2.0, force[1])):
        rows = [(*own, 0, 0, 0, 0), (0, 0, 0, *normal)]
        heads = ("total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)", "center of gravity and mean normal")
        text += f" statistics for slave set SUPPER, master set SLOWER and time  {time:.7E}\n\n"
        for head, row in zip(heads, rows, strict=True):
            text += f"   {head}\n\n" + "".join(f"{v:14.6E}" for v in row) + "\n\n"
    path = tmp_path / "mortar.frd"
    path.write_bytes((DATA / "mortar.frd").read_bytes())
    path.with_suffix(".dat").write_text(text)
    return path


def test_the_force_on_the_upper_body_is_turned_and_divided_by_the_mesh_thickness(tmp_path):
    path = beside(tmp_path, [(0.0, 200.0), (-30.0, 200.0)], (0.0, -1.0, 0.0))
    found = result(path)
    np.testing.assert_allclose(found.normal_load, [P, P])
    np.testing.assert_allclose(found.tangential_load, [0.0, Q])
    assert any("the mesh's thickness, 0.5" in note for note in found.notes)
    np.testing.assert_allclose(result(path, thickness=1.0).normal_load, [200.0, 200.0])
    with pytest.raises(InputError, match="times and the file has 2 instants"):
        result(path, times=[1.0])


def test_resultants_without_contact_are_not_used_and_said(tmp_path):
    found = result(beside(tmp_path, [(0.0, 0.0), (0.0, 0.0)], (np.nan,) * 3))
    assert found.normal_load is None
    assert any("states the pair's resultant at 0 of 2 times" in note for note in found.notes)


def test_units_times_offset_and_stated_signs():
    plain, turned = (
        result("mortar.frd"),
        result(
            "mortar.frd",
            factors={"length": 1e-3, "stress": 1e6, "time": 2.0},
            x_offset=1e-4,
            signs={"shear": "on upper", "slip": "lower over upper"},
        ),
    )
    np.testing.assert_allclose(turned.x, plain.x * 1e-3 - 1e-4)
    np.testing.assert_allclose(turned.pressure, plain.pressure * 1e6)
    # With the upper body as slave CSHEAR1 counts as we do; the mapping says it does not.
    np.testing.assert_allclose(turned.shear, -plain.shear * 1e6)
    np.testing.assert_allclose(turned.slip, -plain.slip * 1e-3)
    np.testing.assert_allclose(turned.time, [2.0, 4.0])
    np.testing.assert_array_equal(result("mortar.frd", times=[0.25, 0.5]).time, [0.25, 0.5])
    assert plain.code == "CalculiX Version 2.20"
    assert result("mortar.frd", code="mine").code == "mine"


def test_a_stated_sign_replaces_that_of_the_slave_face():
    derived = result("node-to-surface.frd")
    np.testing.assert_array_equal(result("node-to-surface.frd", signs={"shear": "on upper"}).shear, derived.shear)
    np.testing.assert_array_equal(result("node-to-surface.frd", signs={"shear": "on lower"}).shear, -derived.shear)


def test_what_was_chosen_and_found_is_said():
    notes = " ".join(result("node-to-surface.frd").notes)
    assert "the model is 1 thick: the tractions are those of its plane z = -0.5, one of 2" in notes
    assert "the slave face is curved" in " ".join(result("mortar.frd").notes)


def test_a_pull_is_named_once():
    """By the guesses, which know its place; the reader's note is for pulls too small for them."""
    found = result("node-to-surface.frd")
    said = [*found.notes, *oddities(found, np.zeros(2), load_scene("hertz-paper"))]
    assert len([sentence for sentence in said if "pulls" in sentence or "tension" in sentence]) == 1
    assert len(tension(np.array([[1000.0, -0.5]]))) == 1
    assert tension(np.array([[1000.0, -1.5]])) == []


def test_a_flat_slave_face_is_read_whole():
    found = result("surface-to-surface.frd")
    assert found.x[0] == -4.0
    assert found.x[-1] == 4.0
    assert not np.any(found.pressure[:, np.abs(found.x) > 1.0])


def test_stress_stands_in_for_contact_values(tmp_path, monkeypatch):
    path = edited(tmp_path, "surface-to-surface.frd", (" -4  CONTACT ", " -4  CONTAXT "))
    found = result(path)
    normal, tangential = resultants(found)
    # Extrapolated nodal stress of linear elements: 7 % of P, 2 % of Q measured.
    np.testing.assert_allclose(normal, [P, P], rtol=0.12)
    np.testing.assert_allclose(tangential, [0.0, Q], atol=0.1 * Q)
    assert found.slip is None
    opened, own = [], Path.open
    monkeypatch.setattr(Path, "open", lambda path, *how, **more: opened.append(path) or own(path, *how, **more))
    result(path)
    assert opened == [path]  # read once, although it has no contact values
    assert "p = -SYY and q = SXY of the lower body" in found.notes[0]
    # Resultants still come from the .dat file, whichever body was the slave.
    path.with_suffix(".dat").write_bytes((DATA / "surface-to-surface.dat").read_bytes())
    np.testing.assert_allclose(result(path).tangential_load, [0.0, Q], atol=1e-4 * Q)
    np.testing.assert_allclose(result(path, factors={"stress": 2.0}).shear, 2 * found.shear)
    with pytest.raises(InputError, match=r"no node of a lower body's face at y = 0\.5; .*y_offset"):
        result(path, y_offset=0.5)


def test_frames_without_stress_and_doubles_are_said(tmp_path):
    text = (DATA / "surface-to-surface.frd").read_text().replace(" -4  CONTACT ", " -4  CONTAXT ")
    path = tmp_path / "run.frd"
    at = text.rindex(" -4  STRESS ")
    path.write_text(text[:at] + " -4  STRESX " + text[at + len(" -4  STRESS ") :])
    found = result(path)
    assert len(found.time) == 1
    assert any("left out: 1 frames without stress (first at time 2)" in note for note in found.notes)
    path.write_text(text.replace("  102 2.000000000", "  102 1.000000000"))
    found = result(path)
    assert len(found.time) == 1
    assert any("1 blocks of stress share a time with a later one" in note for note in found.notes)


def test_resultants_within_two_per_cent_need_no_word():
    x = np.linspace(-1.0, 1.0, 41)
    flat = np.ones((1, 41))
    assert unbalanced(x, flat, np.array([2.0 / 1.019])) == []
    assert "add up to 1.021 of" in unbalanced(x, flat, np.array([2.0 / 1.021]))[0]
    assert unbalanced(x, flat, None) == []
    assert free_face(x, flat, flat) == []
    assert free_face(x, flat, 0 * flat) == []


def test_several_contact_pairs_need_a_name(tmp_path):
    path = beside(tmp_path, [(0.0, 200.0), (-30.0, 200.0)], (0.0, -1.0, 0.0))
    printed = path.with_suffix(".dat")
    text = printed.read_text()
    printed.write_text(text + text.replace("SUPPER", "OTHER").replace("2.000000E+02", "9.000000E+02"))
    with pytest.raises(InputError, match=r"several contact pairs \(slave faces OTHER, SUPPER\)"):
        result(path)
    np.testing.assert_allclose(result(path, surface="SUPPER").normal_load, [P, P])
