"""Field files of other programs: the surface is found, fields under any of their names and forms become p and q with our signs."""

from pathlib import Path

import meshio
import numpy as np
import pytest

from meshes import foreign, read_frames, write_pvd
from meshes.files import PvdEntry
from reports.score.calculix_frd import read_frd
from reports.score.calculix_mesh import CalculixMesh
from reports.score.mapping import Mapping
from reports.score.reading import read
from scenes import InputError

DATA = Path(__file__).parent / "data"
HALF = 2.0


def pressure_at(x):
    return 300 * np.sqrt(np.maximum(1 - x**2, 0.0))


def shear_at(x):
    return 0.25 * pressure_at(x) * (1 + 0.5 * x)


def bodies(deep=0.0):
    """A block below y = 0 and a pad above, of quadrangles or, where deep, of one layer of bricks; nodes shuffled."""
    x, heights = np.linspace(-HALF, HALF, 41), np.array([-0.5, 0.0])
    points, cells = [], []
    for bottom in (heights, heights + 0.5):
        grid = {}
        for z in (0.0, deep)[: 2 if deep else 1]:
            for k, y in enumerate(bottom):
                for i, place in enumerate(x):
                    grid[i, k, z] = len(points)
                    points.append((place, y, z))
        for i in range(40):
            corners = [(i, 0), (i + 1, 0), (i + 1, 1), (i, 1)]
            cells.append([grid[*c, z] for z in (0.0, deep)[: 2 if deep else 1] for c in corners])
    order = np.random.default_rng(1).permutation(len(points))
    return np.array(points)[np.argsort(order)], [("hexahedron" if deep else "quad", order[np.array(cells)])]


def fields(points, scale=1.0):
    """At every point, wherever it lies: what is not the surface must not be taken."""
    x, y = points[:, 0], points[:, 1]
    decay = scale * np.exp(-3 * np.abs(y))
    return pressure_at(x) * decay, shear_at(x) * decay


def mesh(deep=0.0, **named):
    points, cells = bodies(deep)
    return meshio.Mesh(points, cells, point_data={name: make(points) for name, make in named.items()})


def result(path, **mapping):
    return read(Path(path), Mapping.model_validate(mapping), None)


def check(found, scale=1.0, rtol=1e-12):
    assert len(found.x) == 41
    np.testing.assert_allclose(found.x, np.linspace(-HALF, HALF, 41), atol=1e-12)
    np.testing.assert_allclose(found.pressure[-1], scale * pressure_at(found.x), rtol=rtol, atol=1e-9)
    np.testing.assert_allclose(found.shear[-1], scale * shear_at(found.x), rtol=rtol, atol=1e-9)


def stress(order):
    """sigma_yy = -p and sigma_xy = q at the given places among the components; 7 elsewhere."""

    def make(points):
        p, q = fields(points)
        values = np.full((len(points), order["n"]), 7.0)
        values[:, order["yy"]] = -p
        values[:, order["xy"]] = q[:, None] if isinstance(order["xy"], list) else q
        return values

    return make


def scalars():
    return {"CPRESS": lambda x: fields(x)[0], "CSHEAR1": lambda x: fields(x)[1], "CSLIP1": lambda x: 1e-3 * x[:, 0]}


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


def series_of(tmp_path, kind, times=(0.0, 0.5, 2.0)):
    """Instants scaled by 1, 2, 3; the two bodies in files of their own."""
    points, cells = bodies()
    entries = []
    for k, time in reversed(list(enumerate(times))):
        p, q = fields(points, k + 1)
        if kind == "series":
            name = f"all_{k}.vtu"
            meshio.Mesh(points, cells, {"CPRESS": p, "CSHEAR1": q}).write(tmp_path / name)
            entries.append((time, 0, name))
            continue
        for part in (0, 1):
            name = f"body{part}_{k}.vtu"
            own = meshio.Mesh(points, [("quad", cells[0][1][40 * part : 40 * part + 40])], {"CPRESS": p, "CSHEAR1": q})
            own.write(tmp_path / name)
            entries.append((time, part, name))
    if kind == "series":
        listed = ",".join(f'{{"name": "{name}", "time": {time}}}' for time, _, name in entries)
        path = tmp_path / "result.vtu.series"
        path.write_text(f'{{"file-series-version": "1.0", "files": [{listed}]}}')
        return path
    path = tmp_path / "result.pvd"
    write_pvd(path, [PvdEntry(time, part, f"body {part}", name) for time, part, name in entries])
    return path


@pytest.mark.parametrize("kind", ["pvd", "series"])
def test_a_collection_is_read_in_the_order_of_time(tmp_path, kind):
    found = result(series_of(tmp_path, kind))
    np.testing.assert_array_equal(found.time, [0.0, 0.5, 2.0])
    check(found, 3.0)
    np.testing.assert_allclose(found.pressure[0] * 2, found.pressure[1])
    np.testing.assert_array_equal(result(series_of(tmp_path, kind), times=[1, 2, 3]).time, [1.0, 2.0, 3.0])


def test_an_xdmf_series(tmp_path):
    points, cells = bodies()
    path = tmp_path / "result.xdmf"
    with meshio.xdmf.TimeSeriesWriter(path, data_format="XML") as writer:
        writer.write_points_cells(points, cells)
        for k, time in enumerate((0.5, 1.5)):
            p, q = fields(points, k + 1)
            writer.write_data(time, point_data={"CPRESS": p, "CSHEAR1": q})
    found = result(path, factors={"time": 2.0})
    np.testing.assert_array_equal(found.time, [1.0, 3.0])
    check(found, 2.0)


def test_what_calculix_wrote_as_stress_reads_alike_from_its_own_file_and_from_a_field_file(tmp_path):
    """The load of the real run, through another form: equilibrium holds the signs."""
    file = read_frd(DATA / "surface-to-surface.frd", ("STRESS",))
    own = CalculixMesh.of(file)
    block = file.blocks[-1]
    values = np.zeros((len(own.numbers), 6))
    values[own.rows(block.nodes)] = block.values
    path = tmp_path / "result.vtu"
    meshio.Mesh(own.points, [("quad", own.cells[0])], {"stress": values}).write(path)
    found = result(path)
    assert np.trapezoid(found.pressure[0], found.x) == pytest.approx(400.0, rel=0.12)
    assert np.trapezoid(found.shear[0], found.x) == pytest.approx(60.0, rel=0.12)


def test_a_series_whose_mesh_changes_is_refused(tmp_path):
    path = series_of(tmp_path, "series")
    moved = meshio.read(tmp_path / "all_2.vtu")
    moved.points[0, 0] += 0.1
    moved.write(tmp_path / "all_2.vtu")
    with pytest.raises(InputError, match="the points of instant 3 are not those of the first"):
        result(path)


def test_a_series_that_loses_a_field_is_refused(tmp_path):
    path = series_of(tmp_path, "series")
    moved = meshio.read(tmp_path / "all_1.vtu")
    del moved.point_data["CSHEAR1"]
    moved.write(tmp_path / "all_1.vtu")
    with pytest.raises(InputError, match="instant 2 has no field 'CSHEAR1'"):
        result(path)


def test_a_file_of_the_collection_that_is_missing_is_named(tmp_path):
    path = series_of(tmp_path, "pvd")
    (tmp_path / "body1_2.vtu").unlink()
    with pytest.raises(InputError, match=r"it names body1_2\.vtu, which is not there"):
        result(path)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.pvd", "<VTKFile type='Collection'><Collection/></VTKFile>", "the collection is empty"),
        ("a.pvd", "<VTKFile type='UnstructuredGrid'/>", "type Collection is expected"),
        ("a.pvd", "<VTKFile type='Collection'><DataSet file='a.pvd'/></VTKFile>", "has no time"),
        ("a.pvd", "<VTKFile type='Collection'><DataSet timestep='1' file='a.pvd'/></VTKFile>", "no reader for '.pvd' within"),
        ("a.pvd", "<VTKFile", "can't be read as a .pvd file: it is broken off"),
        ("a.series", '{"files": 3', "can't be read as a .series file"),
        ("a.vtu", "", "can't be read as a .vtu file"),
        ("a.vtk", "no\nvtk\nat all\n", "can't be read as a .vtk file"),
        ("a.xdmf", "<Xdmf Version='3.0'></Xdmf>", "can't be read as a .xdmf file"),
    ],
)
def test_a_file_that_is_none_is_refused(tmp_path, name, text, said):
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=said):
        result(tmp_path / name)


@pytest.mark.parametrize("suffix", [".vtu", ".vtk", ".xdmf"])
def test_a_file_that_breaks_off_anywhere_is_refused(tmp_path, suffix):
    path, cut = tmp_path / f"whole{suffix}", tmp_path / f"cut{suffix}"
    mesh(**scalars()).write(path)
    whole = path.read_bytes()
    for end in np.linspace(0, len(whole) - 30, 25).astype(int):
        cut.write_bytes(whole[:end])
        with pytest.raises(InputError):
            result(cut)


def test_a_file_that_is_too_large_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "result.vtu"
    mesh(**scalars()).write(path)
    monkeypatch.setattr(foreign, "LARGEST", 100)
    with pytest.raises(InputError, match="write the contact surface alone"):
        read_frames(path)
