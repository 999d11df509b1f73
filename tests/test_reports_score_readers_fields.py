"""Field files of other programs: the surface is found, fields under any of their names and forms become p and q with our signs."""

from pathlib import Path

import meshio
import numpy as np
import pytest

from field_files import HALF, bodies, check, fields, mesh, pressure_at, result, scalars, shear_at
from reports.scoring.calculix import CalculixMesh
from reports.scoring.calculix_files import read_frd
from scenes import InputError

DATA = Path(__file__).parent / "data"


def stress(order):
    """sigma_yy = -p and sigma_xy = q at the given places among the components; 7 elsewhere."""

    def make(points):
        p, q = fields(points)
        values = np.full((len(points), order["n"]), 7.0)
        values[:, order["yy"]] = -p
        values[:, order["xy"]] = q[:, None] if isinstance(order["xy"], list) else q
        return values

    return make


@pytest.mark.parametrize("suffix", [".vtu", ".vtk", ".xdmf"])
@pytest.mark.parametrize("deep", [0.0, 0.25])
def test_scalars_at_the_lower_face_of_every_form(tmp_path, suffix, deep):
    path = tmp_path / f"result{suffix}"
    mesh(deep, **scalars()).write(path)
    found = result(path)
    check(found)
    np.testing.assert_allclose(found.slip[0], 1e-3 * found.x, atol=1e-15)
    assert found.time is None
    notes = " ".join(found.notes)
    assert "the surface is the lower body's face, found at y = 0" in notes
    assert ("the model is 0.25 thick" in notes) == (deep > 0)


@pytest.mark.parametrize(
    ("order", "said"),
    [
        ({"n": 6, "yy": 1, "xy": 3}, "xx, yy, zz, xy, yz, xz"),
        ({"n": 9, "yy": 4, "xy": [1, 3]}, "rows of 3 x 3"),
        ({"n": 3, "yy": 1, "xy": 2}, "xx, yy, xy"),
        ({"n": 4, "yy": 1, "xy": 3}, "xx, yy, zz, xy"),
        ({"n": 4, "yy": 3, "xy": [1, 2]}, "rows of 2 x 2"),
    ],
)
def test_stress_in_each_order_of_components(tmp_path, order, said):
    path = tmp_path / "result.vtu"
    mesh(stress=stress(order)).write(path)
    found = result(path)
    check(found)
    assert any("p = -sigma_yy and q = sigma_xy of the lower body" in note and said in note for note in found.notes)
    check(result(path, factors={"stress": 1e-6}), 1e-6)


def upper_only(make):
    points, cells = bodies()
    return meshio.Mesh(points, [("quad", cells[0][1][40:])], point_data={"contact_traction": make(points)})


def traction(points):
    """On the lower body."""
    p, q = fields(points)
    return np.column_stack([q, -p, 0 * p])


def test_a_vector_acts_on_the_body_whose_face_it_is_at(tmp_path):
    path = tmp_path / "result.vtu"
    mesh(contact_traction=traction).write(path)
    check(result(path))
    check(result(path, signs={"shear": "on upper"}), -1.0)
    upper_only(lambda points: -traction(points)).write(path)
    found = result(path)
    check(found)
    assert any("taken to act on the upper body" in note for note in found.notes)
    check(result(path, signs={"shear": "on lower"}), -1.0)


def test_components_of_a_vector_by_name(tmp_path):
    path = tmp_path / "result.vtu"
    mesh(force=traction).write(path)
    found = result(path, columns={"pressure": "force:1", "shear": "force:0"}, signs={"pressure": "compression negative"})
    check(found)
    with pytest.raises(InputError, match="neither contact pressure, nor contact traction, nor stress at points among 'force'"):
        result(path)


def surface_line(cell_data=None, point_data=None, extra=()):
    x = np.linspace(-HALF, HALF, 41)
    points = np.column_stack([x, 0 * x, 0 * x])
    return meshio.Mesh(
        points, [("line", np.column_stack([np.arange(40), np.arange(1, 41)])), *extra], point_data or {}, cell_data or {}
    )


def test_a_path_along_the_surface_is_taken_whole(tmp_path):
    path = tmp_path / "path.vtu"
    whole = surface_line()
    p, q = fields(whole.points)
    whole.points[:, 1] = 0.3 * whole.points[:, 0] ** 2  # the face of a curved body
    whole.point_data = {"pressure": p, "shear": q}
    whole.write(path)
    check(result(path))


def test_a_curved_face_cut_out_of_a_solid_is_taken_whole(tmp_path):
    path = tmp_path / "face.vtu"
    x = np.linspace(-HALF, HALF, 41)
    points = np.array([(place, 0.3 * place**2, z) for z in (0.0, 0.5) for place in x])
    cells = np.array([(k, k + 1, k + 42, k + 41) for k in range(40)])
    meshio.Mesh(points, [("quad", cells)], {"pressure": pressure_at(points[:, 0]), "shear": shear_at(points[:, 0])}).write(path)
    check(result(path))


def test_fields_of_cells_stand_at_the_middles(tmp_path):
    path = tmp_path / "path.vtu"
    middles = np.linspace(-HALF, HALF, 41)[:-1] + 0.05
    own = {"CPRESS": [pressure_at(middles)], "CSHEAR1": [shear_at(middles)], "CSLIP": [middles]}
    surface_line(own).write(path)
    found = result(path)
    np.testing.assert_allclose(found.x, middles, atol=1e-12)
    np.testing.assert_allclose(found.pressure[0], pressure_at(middles))
    np.testing.assert_allclose(found.shear[0], shear_at(middles))
    np.testing.assert_allclose(found.slip[0], middles)
    assert "of cells, at their middles" in found.notes[0]


def test_fields_of_the_bodies_cells_are_refused(tmp_path):
    path = tmp_path / "result.vtu"
    points, cells = bodies()
    meshio.Mesh(points, cells, cell_data={"CPRESS": [np.ones(80)], "CSHEAR1": [np.ones(80)]}).write(path)
    with pytest.raises(InputError, match="no cell lies in the surface; average it to points"):
        result(path)


def marked(**point_data):
    """Bodies with the lines of the face among the cells; the marker of the quadrangles is 0."""
    points, cells = bodies()
    rows = np.flatnonzero(points[:, 1] == 0)
    rows = rows[np.isin(rows, cells[0][1][:40])]
    rows = rows[np.argsort(points[rows, 0])]
    lines = np.column_stack([rows[:-1], rows[1:]])
    p, q = fields(points)
    data = {"CPRESS": p, "CSHEAR1": q} | {name: make(points) for name, make in point_data.items()}
    return meshio.Mesh(points, [*cells, ("line", lines)], data, {"tag": [np.full(80, 3), np.full(40, 12)]}), rows


def test_a_tag_marks_the_surface(tmp_path):
    path = tmp_path / "result.vtu"
    marked()[0].write(path)
    found = result(path, surface="tag=12", y_offset=99.0)
    check(found)
    assert any("the surface is what tag=12 marks" in note for note in found.notes)
    for surface, said in (("tag=5", "marks nothing"), ("tag=x", "'x' is no number"), ("top", "names no field of it")):
        with pytest.raises(InputError, match=said):
            result(path, surface=surface)


def test_a_point_set_marks_the_surface_as_meshio_writes_it(tmp_path):
    path = tmp_path / "result.vtu"
    whole, rows = marked()
    flags = np.full(len(whole.points), -1.0)
    flags[rows] = 0.0
    whole.point_data["face"] = flags
    whole.write(path)
    check(result(path, surface="face"))


def test_a_mask_over_both_faces_gives_the_lower_one(tmp_path):
    path = tmp_path / "result.vtu"
    whole, _ = marked(face=lambda points: (points[:, 1] == 0).astype(float))
    whole.cells = whole.cells[:1]
    whole.cell_data = {}
    whole.write(path)
    found = result(path, surface="face")
    check(found)
    assert any("points of both bodies: those of the lower one were taken" in note for note in found.notes)


def test_the_face_lies_where_the_mapping_says(tmp_path):
    path = tmp_path / "result.vtu"
    whole = mesh(**scalars())
    whole.points[:, 1] += 5.0
    whole.write(path)
    with pytest.raises(InputError, match=r"no point of a face at y = 0 \(y goes from 4.5 to 5.5\); say where it lies by y_offset"):
        result(path)
    check(result(path, y_offset=5.0))
    found = result(path, y_offset=5000.0, x_offset=500.0, factors={"length": 1e3})
    np.testing.assert_allclose(found.x, 1e3 * np.linspace(-HALF, HALF, 41) - 500.0)


def test_what_calculix_wrote_as_stress_reads_alike_from_its_own_file_and_from_a_field_file(tmp_path):
    """The load of the real run, through another form: equilibrium holds the signs."""
    file = read_frd(DATA / "surface-to-surface.frd", ("STRESS",))
    own = CalculixMesh(file)
    block = file.blocks[-1]
    values = np.zeros((len(own.numbers), 6))
    values[own.rows(block.nodes)] = block.values
    path = tmp_path / "result.vtu"
    meshio.Mesh(own.points, [("quad", own.cells[0][1])], {"stress": values}).write(path)
    found = result(path)
    assert np.trapezoid(found.pressure[0], found.x) == pytest.approx(400.0, rel=0.12)
    assert np.trapezoid(found.shear[0], found.x) == pytest.approx(60.0, rel=0.12)
