"""CalculiX files with a fault in them: refused in a sentence, or read with the fault said."""

import numpy as np
import pytest

from calculix_files import DATA, edited, result
from reports.scoring.calculix_files import read_frd
from scenes import InputError


def test_a_run_that_was_stopped_is_said(tmp_path):
    text = (DATA / "mortar.frd").read_text()
    second = [k for k in range(len(text)) if text.startswith("    1PSTEP", k)][2]
    path = tmp_path / "cut.frd"
    path.write_text(text[:second])
    found = result(path)
    np.testing.assert_array_equal(found.time, [1.0])
    assert "the file has no end (9999)" in found.notes[-1]
    assert not any("9999" in note for note in result("mortar.frd").notes)


def test_neither_contact_nor_stress_is_refused(tmp_path):
    path = edited(tmp_path, "mortar.frd", (" -4  CONTACT ", " -4  CONTAXT "))
    with pytest.raises(InputError, match=r"no block CONTACT and none STRESS; it has DISP, CONTAXT.*CONTACT FILE"):
        result(path)


def test_a_frame_without_contact_values_is_left_out_and_said(tmp_path):
    text = (DATA / "mortar.frd").read_text()
    at = text.rindex(" -4  CONTACT ")
    path = tmp_path / "mortar.frd"
    path.write_text(text[:at] + " -4  CONTAXT " + text[at + len(" -4  CONTACT ") :])
    found = result(path)
    assert len(found.time) == 1
    assert "left out: 1 frames without contact values (first at time 2)" in found.notes[0]


def test_nodes_without_coordinates_are_refused(tmp_path):
    # What CalculiX writes for plane elements without OUTPUT=3D: contact values under numbers that the file does not have.
    text = (DATA / "node-to-surface.frd").read_text()
    head, tail = text[: text.index(" -4  CONTACT ")], text[text.index(" -4  CONTACT ") :]
    node = read_frd(DATA / "node-to-surface.frd").blocks[0].nodes[0]
    path = tmp_path / "plane.frd"
    path.write_text(head + tail.replace(f" -1{node:10d}", f" -1{node + 90000:10d}"))
    with pytest.raises(InputError, match=f"node {node + 90000} has a result.*OUTPUT=3D"):
        result(path)


def test_bodies_that_do_not_touch_are_refused(tmp_path):
    lines = (DATA / "mortar.frd").read_text().splitlines(keepends=True)
    inside = False
    for k, line in enumerate(lines):
        inside = (inside or line.startswith(" -4  CONTACT")) and not line.startswith(" -3")
        if inside and line.startswith(" -1"):
            lines[k] = line[:13] + 6 * " 0.00000E+00" + "\n"
    path = tmp_path / "open.frd"
    path.write_text("".join(lines))
    with pytest.raises(InputError, match="the bodies do not touch"):
        result(path)


def test_contact_values_that_are_no_numbers_are_refused(tmp_path):
    block = read_frd(DATA / "mortar.frd").blocks[0]
    row = next(line for line in (DATA / "mortar.frd").read_text().splitlines()[block.line :] if line.startswith(" -1"))
    path = edited(tmp_path, "mortar.frd", (row, row[:13] + "         NaN" + row[25:]))
    with pytest.raises(InputError, match=f"line {block.line}: block CONTACT holds numbers that are not finite"):
        result(path)


def test_a_component_that_is_missing_is_named(tmp_path):
    path = edited(tmp_path, "mortar.frd", (" -5  CSHEAR1 ", " -5  CSHEARX "))
    with pytest.raises(InputError, match="block CONTACT has no CSHEAR1"):
        result(path)


def test_contact_values_on_both_faces_are_refused(tmp_path):
    # One slave node of the upper body gets the number of a node of the block's face.
    file = read_frd(DATA / "mortar.frd")
    block = file.blocks[0]
    touched = block.nodes[block.column("CPRESS") > 0][0]
    on_face = file.nodes[(file.points[:, 1] == 0) & (np.abs(file.points[:, 0] - 1.0) < 0.5)][0]
    text = (DATA / "mortar.frd").read_text()
    head, tail = text[: text.index(" -4  CONTACT ")], text[text.index(" -4  CONTACT ") :]
    path = tmp_path / "both.frd"
    path.write_text(head + tail.replace(f" -1{touched:10d}", f" -1{on_face:10d}"))
    with pytest.raises(InputError, match="nodes of both bodies"):
        result(path)


def test_a_dat_file_needs_its_frd_file(tmp_path):
    path = tmp_path / "alone.dat"
    path.write_bytes((DATA / "node-to-surface.dat").read_bytes())
    with pytest.raises(InputError, match=r"no alone\.frd beside it"):
        result(path)


def test_a_dat_file_with_elements_that_the_frd_has_not_is_refused(tmp_path):
    path = tmp_path / "run.dat"
    path.with_suffix(".frd").write_bytes((DATA / "surface-to-surface.frd").read_bytes())
    text = (DATA / "surface-to-surface.dat").read_text()
    row = next(line for line in text.splitlines() if line.strip().startswith("1") and len(line.split()) == 5)
    element, face = row.split()[:2]
    for own, said in (
        (f"{90000:10d} {face:>10}", "element 90000 is not in it"),
        (f"{element:>10} {1:10d}", "of kind 9 has no face 1"),
    ):
        path.write_text(text.replace(row[:21], own))
        with pytest.raises(InputError, match=said):
            result(path)


def test_a_dat_file_without_contact_stress_is_refused(tmp_path):
    path = edited(tmp_path, "node-to-surface.dat", (" contact stress (", " contact strain ("))
    with pytest.raises(InputError, match="no contact stress is printed in it"):
        result(path)
