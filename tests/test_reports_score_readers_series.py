"""Collections and series of field files, and files that are none."""

import meshio
import numpy as np
import pytest

from field_files import bodies, check, fields, mesh, result, scalars
from meshes import foreign, read_frames, write_pvd
from meshes.files import PvdEntry
from scenes import InputError


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


def parts_of(tmp_path, *fields_of):
    """The two bodies of one instant in files of their own, each with the fields that are made for its points."""
    points, cells = bodies()
    entries = []
    for part, made in enumerate(fields_of):
        own = meshio.Mesh(points, [("quad", cells[0][1][40 * part : 40 * part + 40])], made(points))
        own.write(tmp_path / f"body{part}.vtu")
        entries.append(PvdEntry(1.0, part, f"body {part}", f"body{part}.vtu"))
    write_pvd(tmp_path / "result.pvd", entries)
    return tmp_path / "result.pvd"


def tractions(points):
    p, q = fields(points)
    return {"CPRESS": p, "CSHEAR1": q, "CSLIP1": 1e-3 * points[:, 0]}


def only(*names):
    return lambda points: {name: values for name, values in tractions(points).items() if name in names}


@pytest.mark.parametrize("part", [0, 1])
def test_a_field_of_one_body_alone_is_read_there_and_the_other_is_named(tmp_path, part):
    made = [only(), only()]
    made[part] = tractions
    found = result(parts_of(tmp_path, *made))
    check(found)
    np.testing.assert_allclose(found.slip[0], 1e-3 * found.x, atol=1e-15)
    assert f"body{1 - part}.vtu has no 'CPRESS', 'CSHEAR1': left out" in found.notes
    assert any(f"the surface is the {('lower', 'upper')[part]} body's face" in note for note in found.notes)


def test_slip_of_one_body_alone_is_left_out_and_said_unless_the_mapping_asks_for_it(tmp_path):
    path = parts_of(tmp_path, only("CPRESS", "CSHEAR1"), tractions)
    found = result(path)
    check(found)
    assert found.slip is None
    assert "CSLIP1 is not in all of the files that hold CPRESS and CSHEAR1, and was left out" in found.notes
    asked = result(path, columns={"slip": "CSLIP1", "pressure": "CPRESS", "shear": "CSHEAR1"})
    np.testing.assert_allclose(asked.slip[0], 1e-3 * asked.x, atol=1e-15)
    assert "body0.vtu has no 'CSLIP1': left out" in asked.notes


def test_tractions_that_no_part_has_whole_are_refused_with_what_each_lacks(tmp_path):
    path = parts_of(tmp_path, only("CPRESS"), only("CSHEAR1"))
    with pytest.raises(InputError, match=r"body0\.vtu has no 'CSHEAR1'; body1\.vtu has no 'CPRESS'"):
        result(path)


def test_a_marker_of_one_part_alone_chooses_it(tmp_path):
    lower = np.isin(np.arange(len(bodies()[0])), bodies()[1][0][1][:40])
    path = parts_of(tmp_path, lambda at: tractions(at) | {"face": 1.0 * (lower & (at[:, 1] == 0))}, tractions)
    found = result(path, surface="face")
    check(found)
    assert "body1.vtu has no 'face': left out" in found.notes


def test_a_field_of_another_form_in_another_part_is_refused(tmp_path):
    path = parts_of(tmp_path, tractions, lambda at: tractions(at) | {"CPRESS": np.column_stack([at[:, 0]] * 3)})
    with pytest.raises(InputError, match=r"body0\.vtu: CPRESS has another number of components than in body1\.vtu"):
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


def test_cells_of_points_that_are_not_there_are_refused(tmp_path):
    path = tmp_path / "a.vtk"
    mesh(**scalars()).write(path, file_format="vtk42", binary=False)
    text = path.read_text()
    cells = text.index("CELLS")
    path.write_text(text[:cells] + text[cells:].replace("\n4 ", "\n4 9", 1).replace("\n4\n", "\n4\n9", 1))
    with pytest.raises(InputError, match="names a point that is not there"):
        result(path)


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
