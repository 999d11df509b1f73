"""Field files, written and read back."""

import meshio
import numpy as np
import pytest

from meshes import write_vtu

POINTS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
TRIANGLES = np.array([[0, 1, 2], [1, 3, 2]])
SIX_POINTS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]])
SIX = np.array([[0, 1, 2, 3, 4, 5]])


def test_linear_triangles_come_back(tmp_path):
    fields = {"pressure": np.array([1.0, 2.0, 3.0, 4.5]), "displacement": POINTS * 1e-3, "stress": np.arange(16.0).reshape(4, 4)}
    write_vtu(tmp_path / "body.vtu", POINTS, TRIANGLES, fields)
    found = meshio.read(tmp_path / "body.vtu")
    np.testing.assert_array_equal(found.points, np.column_stack([POINTS, np.zeros(4)]))
    assert [block.type for block in found.cells] == ["triangle"]
    np.testing.assert_array_equal(found.cells[0].data, TRIANGLES)
    np.testing.assert_array_equal(found.point_data["pressure"], fields["pressure"])
    np.testing.assert_array_equal(found.point_data["stress"], fields["stress"])
    np.testing.assert_array_equal(found.point_data["displacement"], np.column_stack([POINTS * 1e-3, np.zeros(4)]))


def test_six_node_triangles_come_back(tmp_path):
    write_vtu(str(tmp_path / "body.vtu"), SIX_POINTS, SIX, {"x": SIX_POINTS[:, 0]})
    found = meshio.read(tmp_path / "body.vtu")
    assert [block.type for block in found.cells] == ["triangle6"]
    np.testing.assert_array_equal(found.cells[0].data, SIX)
    np.testing.assert_array_equal(found.point_data["x"], SIX_POINTS[:, 0])


def test_other_elements_are_refused(tmp_path):
    with pytest.raises(KeyError):
        write_vtu(tmp_path / "body.vtu", POINTS, np.array([[0, 1, 3, 2, 0]]), {})
    assert not list(tmp_path.iterdir())
