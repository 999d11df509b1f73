"""Elements of a foreign mesh that are turned inside out are named, in every kind of file that holds a mesh; sound ones are not."""

import meshio
import numpy as np
import pytest

from calculix_files import DATA, edited
from calculix_files import result as calculix_result
from field_files import mesh, result, scalars
from reports.scoring.surface import inside_out

WORDS = "turned inside out"
RING = [[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]
SQUARE = [(0.0, 0), (1, 0), (1, 1), (0, 1)]


def stack(corners):
    """Three layers of a prism over the corners: points, and the element of each layer."""
    n = len(corners)
    return np.array([[x, y, z] for z in range(4) for x, y in corners]), np.arange(2 * n) + n * np.arange(3)[:, None]


def bodies():
    """Shape -> points and three sound elements that hang together."""
    around = [[0, k, k + 1] for k in (1, 2, 3)]
    return {
        "triangle": (np.array([[0.0, 0, 0], *RING]), np.array(around)),
        "quad": (np.array([[x, y, 0.0] for y in (0, 1) for x in range(4)]), np.array([[k, k + 1, k + 5, k + 4] for k in range(3)])),
        "tetra": (np.array([[0.0, 0, 0], *RING, [0, 0, 1]]), np.array([[*one, 5] for one in around])),
        "wedge": stack(SQUARE[:3]),
        "hexahedron": stack(SQUARE),
    }


@pytest.mark.parametrize("shape", bodies())
def test_an_element_with_its_corners_counted_the_other_way_is_seen_in_every_shape(shape):
    points, rows = bodies()[shape]
    mirrored = points * (-1.0, 1, 1)
    assert inside_out(points, [(shape, rows)]) == []
    assert inside_out(mirrored, [(shape, rows)]) == []  # all of a body the other way round is a convention
    turned = rows.copy()
    turned[1] = (
        np.roll(rows[1], len(rows[1]) // 2) if shape in {"wedge", "hexahedron"} else rows[1][[1, 0, *range(2, rows.shape[1])]]
    )
    for places in (points, mirrored):
        (said,) = inside_out(places, [(shape, turned)])
        assert said.startswith(f"1 element is {WORDS}, of 3 (a corner with a negative Jacobian; the first lies around x = ")


def test_a_corner_pushed_through_its_element_is_seen_and_a_flat_one_is_none():
    points, rows = bodies()["quad"]
    points[5, :2] = 0.5, 0.5  # the two elements beside it have a straight corner there, or a wide one
    assert inside_out(points, [("quad8", np.hstack([rows, rows]))]) == []
    points[5, :2] = 0.4, 0.4
    (said,) = inside_out(points, [("quad8", np.hstack([rows, rows]))])
    assert said.startswith("1 element is")
    assert "x = 0.35, y = 0.35" in said


def test_the_surface_of_a_thick_body_looks_either_way_and_lines_have_no_sense():
    points, rows = bodies()["hexahedron"]
    faces = np.array([[0, 1, 2, 3], [12, 13, 14, 15], [3, 2, 1, 0]])
    assert inside_out(points, [("hexahedron", rows), ("quad", faces), ("line", rows[:, :2]), ("vertex", rows[:, :1])]) == []
    assert inside_out(points, [("quad", faces)]) == []
    assert inside_out(points, [("hexahedron", rows[:, :5])]) == []  # a spoilt file may have fewer nodes than its kind


@pytest.mark.parametrize("deep", [0.0, 0.4])
@pytest.mark.parametrize("suffix", [".vtu", ".vtk", ".xdmf"])
def test_field_files(tmp_path, suffix, deep):
    whole, path = mesh(deep, **scalars()), tmp_path / f"result{suffix}"
    meshio.write(path, whole)
    assert not [note for note in result(path).notes if WORDS in note]
    rows = whole.cells[0].data
    rows[7] = np.roll(rows[7], 4) if deep else rows[7][::-1]
    meshio.write(path, whole)
    (said,) = [note for note in result(path).notes if WORDS in note]
    assert "1 element is" in said
    assert "it is scored as it is" in said


@pytest.mark.parametrize("name", ["node-to-surface.frd", "surface-to-surface.dat", "mortar.frd"])
def test_what_calculix_solved_is_sound(name):
    assert not [note for note in calculix_result(name).notes if WORDS in note]


def test_calculix_files(tmp_path):
    """The nodes of one quadrangle of the real run, counted backwards: in contact values, stress and printed values alike."""
    lines = (DATA / "surface-to-surface.frd").read_text().splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith(" -2"))
    nodes = lines[at].split()[1:]
    change = (f"{lines[at - 1]}\n{lines[at]}\n", f"{lines[at - 1]}\n -2{''.join(f'{int(node):10d}' for node in nodes[::-1])}\n")
    path = edited(tmp_path, "surface-to-surface.frd", change)
    path.with_suffix(".dat").write_bytes((DATA / "surface-to-surface.dat").read_bytes())
    stress = edited(tmp_path, "surface-to-surface.frd", change, (" -4  CONTACT ", " -4  CONTAXT "))
    for found in (calculix_result(path), calculix_result(path.with_suffix(".dat")), calculix_result(stress)):
        (said,) = [note for note in found.notes if WORDS in note]
        assert said.startswith("1 element is")
