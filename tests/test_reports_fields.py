"""Fields on disk and in pictures: ParaView's collection, the record, what pyvista draws, the command and its refusals."""

import json
import re
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import pyvista
from matplotlib import image

import halfplane_fe
from halfplane_fe import FiniteElementSolution
from meshes import MeshSettings
from problems import COARSE, FEW_STEPS, PROBLEMS, fe_run
from reports.charts.style import style_of
from reports.cli import main
from reports.fields import NO_PEAK, Instant, instant_of, instants_of, peak, tension, write_fields
from reports.figures_mesh import BOUNDARIES, look, stress
from reports.rendering import Skin, Window, picture, sides, surface
from scenes import InputError, Scene, load_scene, scene_text
from test_cli_commands import refused

ROUGH = ("--order", "1", "--element-size", "0.25", "--edge-element-size", "0.25", "--steps-per-cycle", "8")
QUADRILATERALS = MeshSettings(element_size=1 / 8, edge_element_size=1 / 8, far_radius=4, growth=0.5, cells="quadrilaterals")
BODIES = {
    "lower": {"kind": "block", "width": 20.0, "height": 12.0},
    "upper": {"kind": "pad", "width": 10.0, "height": 8.0, "sides": "guided"},
}
TOML = """
[bodies.lower]
kind = "block"
width = 20.0
height = 12.0

[bodies.upper]
kind = "pad"
width = 10.0
height = 8.0
sides = "guided"
"""


def blocks() -> Scene:
    return Scene.model_validate(load_scene("cattaneo-mindlin").model_dump() | {"bodies": BODIES})


def answer_of(kind: str) -> FiniteElementSolution:
    if kind == "blocks":
        return fe_run(blocks(), COARSE, FEW_STEPS)
    return fe_run(load_scene("cattaneo-mindlin"), COARSE if kind == "triangles" else QUADRILATERALS, FEW_STEPS)


@pytest.mark.parametrize("kind", ["triangles", "quadrilaterals", "blocks"])
def test_elements_of_both_bodies_go_round_counter_clockwise_and_fill_the_body(kind: str) -> None:
    """Areas by pyvista, signed by the corners: a reflected body must not have negative ones, nor a node that is none."""
    answer = answer_of(kind)
    (snapshot,) = halfplane_fe.fields(answer, [answer.time[-1]])
    for body, mesh in zip(snapshot.bodies, answer.bodies, strict=True):
        corners = body.points[body.cells[:, : mesh.mesh.refdom.nfacets]]
        ahead = np.roll(corners, -1, axis=1)
        areas = (corners[..., 0] * ahead[..., 1] - ahead[..., 0] * corners[..., 1]).sum(axis=1) / 2
        assert areas.min() > 0
        skin = Skin(body.points, body.cells)
        assert surface(skin).area == pytest.approx(areas.sum(), rel=0.02)  # mid-side nodes of arcs bulge
        assert np.isfinite(body.von_mises).all()
        np.testing.assert_array_equal(np.unique(body.cells), np.arange(len(body.points)))
        edges = sides(skin)
        per_side = 2 if body.cells.shape[1] in (6, 9) else 1
        assert edges.n_cells == per_side * mesh.mesh.facets.shape[1]


def test_collection_is_read_back_with_times_parts_and_fields(tmp_path: Path) -> None:
    """By VTK's own reader of PVD, the one in ParaView."""
    answer = answer_of("blocks")
    times = answer.time[[3, 7, -1]]
    snapshots = halfplane_fe.fields(answer, times)
    names = write_fields(answer, snapshots, tmp_path / "fields")
    assert set(names) == {path.name for path in (tmp_path / "fields").iterdir()}
    reader = pyvista.get_reader(str(tmp_path / "fields" / names[0]))
    assert reader.time_values == sorted(set(times))
    for snapshot in snapshots:
        reader.set_active_time_value(snapshot.time)
        found = reader.read()
        assert [data.part for data in reader.active_datasets] == [0, 1, 2]
        for block, body in zip(list(found)[:2], snapshot.bodies, strict=True):
            np.testing.assert_array_equal(block.points[:, :2], body.points)
            np.testing.assert_array_equal(block["von_mises"], body.von_mises)
            np.testing.assert_array_equal(block["displacement"][:, :2], body.displacement)
            xx, yy, zz, xy, yz, xz = block["stress"].T
            np.testing.assert_array_equal(np.stack([xx, yy, xy, zz], axis=1), body.stress)
            assert not yz.any()
            assert not xz.any()


@pytest.mark.parametrize("kind", ["triangles", "quadrilaterals", "blocks"])
def test_the_contact_line_carries_the_answer_where_the_lower_face_is(kind: str, tmp_path: Path) -> None:
    """Its points are the answer's x on the lower body, its pressure adds up to P, and warped it lies on the warped body."""
    answer = answer_of(kind)
    step = answer.last_cycle[0]
    (snapshot,) = halfplane_fe.fields(answer, answer.time[[step]])
    write_fields(answer, [snapshot], tmp_path / "fields")
    line = pyvista.read(tmp_path / "fields" / "contact_000.vtu")
    np.testing.assert_allclose(line.points[:, 0], answer.x, rtol=0, atol=1e-12)
    assert not line.points[:, 1:].any()
    for name in ("pressure", "shear", "slip", "state"):
        np.testing.assert_array_equal(line[name], getattr(answer, name)[step])
    assert np.trapezoid(line["pressure"], line.points[:, 0]) == pytest.approx(answer.normal_load[step], rel=0.01)
    assert line.n_cells == len(answer.x) - 1
    assert line.length == pytest.approx(np.ptp(answer.x))
    lower = snapshot.bodies[0]
    nearest = np.linalg.norm(lower.points[:, None] - line.points[None, :, :2], axis=2).argmin(axis=0)
    np.testing.assert_array_equal(line["displacement"][:, :2], lower.displacement[nearest])


def test_peak_is_the_largest_of_both_bodies() -> None:
    answer = answer_of("blocks")
    (snapshot,) = halfplane_fe.fields(answer, [answer.time[-1]])
    found = peak(snapshot)
    assert found.value == max(body.von_mises.max() for body in snapshot.bodies) == look([snapshot]).largest
    body = snapshot.bodies[found.body == "upper"]
    place = np.argmin(np.linalg.norm(body.points - found.place, axis=1))
    assert body.von_mises[place] == found.value
    drawn = peak(snapshot, tension)
    lower = snapshot.bodies[0].stress
    tensors = np.array(
        [
            [lower[:, 0], lower[:, 2], 0 * lower[:, 0]],
            [lower[:, 2], lower[:, 1], 0 * lower[:, 0]],
            [0 * lower[:, 0], 0 * lower[:, 0], lower[:, 3]],
        ]
    )
    np.testing.assert_allclose(
        tension(snapshot.bodies[0]), np.linalg.eigvalsh(tensors.transpose(2, 0, 1))[:, 2], atol=1e-12 * found.value
    )
    assert drawn.value == max(tension(body).max() for body in snapshot.bodies) > 0


def test_nodes_miss_the_peak_at_the_trailing_edge_by_what_is_said() -> None:
    """Of theory's 2 f p0 sqrt(Q/(f P)) on the default mesh, to a per cent or so, as it stands beside every largest stress."""
    answer = fe_run(load_scene("cattaneo-mindlin"), MeshSettings(), FEW_STEPS)
    said = re.search(r"nodes give about (\d+) % of it at Q = 0\.6 f P and about (\d+) % at 0\.1 f P", NO_PEAK)
    assert said
    friction, p0 = answer.scene.friction.coefficient, PROBLEMS["mindlin, Q largest"].exact["peak_pressure"]
    for ratio, share in zip((0.6, 0.1), said.groups(), strict=True):
        step = int(np.argmin(np.abs(answer.tangential_load / (friction * answer.normal_load.max()) - ratio)))
        (snapshot,) = halfplane_fe.fields(answer, [answer.time[step]])
        found = peak(snapshot, tension).value / (2 * friction * p0 * np.sqrt(ratio))
        assert 100 * found == pytest.approx(float(share), abs=1.5)


def test_the_figure_of_the_page_says_that_nodes_miss_the_peak() -> None:
    answer = answer_of("blocks")
    snapshots = halfplane_fe.fields(answer, [2.0])
    drawn = stress(answer, snapshots, [Instant(2.0, "Q largest")], look(snapshots))
    assert NO_PEAK in drawn.caption
    assert "largest nodal value [MPa]" in drawn.csv().splitlines()[0]


def test_instants_are_times_of_the_path_or_events() -> None:
    answer = answer_of("blocks")
    chosen = instants_of(["0.5", "events"], answer, "--at")
    assert [instant.time for instant in chosen] == sorted({instant.time for instant in chosen})
    labels = {instant.label for instant in chosen}
    assert {"asked for 0.5", "Q largest", "Q least"} <= labels
    largest = next(instant for instant in chosen if instant.label == "Q largest")
    last = answer.last_cycle
    assert np.interp(largest.time, answer.time, answer.tangential_load) == pytest.approx(answer.tangential_load[last].max())
    with pytest.raises(InputError, match="--at 99: the instant lies outside the path, which goes from time 0 to"):
        instants_of(["99"], answer, "--at")
    with pytest.raises(InputError, match="--at soon: give times"):
        instant_of("soon", "--at", 0, 1)
    for word in ("nan", "inf"):
        with pytest.raises(InputError, match="outside the path"):
            instant_of(word, "--at", 0, 1)


class TestPictures:
    SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])

    def test_what_is_drawn_lies_where_it_is(self) -> None:
        """A unit square in a window of 4 by 2: a quarter of the width, half of the height, at the lower left."""
        skin = Skin(self.SQUARE, np.array([[0, 1, 2, 3]]), colour="#0000ff")
        found = picture([skin], Window(-1.0, 3.0, 0.0, 2.0), 200)
        assert found.shape == (100, 200, 3)
        blue = (found[..., 0] < 50) & (found[..., 2] > 200)
        rows, columns = np.nonzero(blue)
        assert (rows.min(), rows.max() + 1) == pytest.approx((50, 100), abs=1)
        assert (columns.min(), columns.max() + 1) == pytest.approx((50, 100), abs=1)

    def test_values_take_the_colours_of_the_scale(self) -> None:
        skin = Skin(self.SQUARE, np.array([[0, 1, 2, 3]]), values=self.SQUARE[:, 1], limits=(0.0, 1.0))
        found = picture([skin], Window(0.0, 1.0, 0.0, 1.0), 64).astype(int)
        for row in (2, 20, 40, 61):
            wanted = 255 * np.array(mpl.colormaps["viridis"](1 - (row + 0.5) / 64)[:3])
            assert np.abs(found[row, 32] - wanted).max() < 8

    def test_edges_are_seen_only_where_asked(self) -> None:
        plain, with_edges = (
            picture([Skin(self.SQUARE, np.array([[0, 1, 2, 3]]), "#ffffff", edges=edges)], Window(-1, 2, -1, 2), 90)
            for edges in (0.0, 1.0)
        )
        assert plain.min() > 240
        assert with_edges.min() < 150  # a line of one pixel, half on each of two


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `halfplane fields` leaves of a block and a pad; whether it can draw is the doctor's own test."""
    place = tmp_path_factory.mktemp("fields")
    (place / "pads.toml").write_text(scene_text("cattaneo-mindlin").split("[[expected]]")[0] + TOML, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("reports.cli.machine._SCREEN", "print('drawn')")
        assert main(["fields", str(place / "pads.toml"), "--at", "2", "--out", str(place / "out"), "--quiet", *ROUGH]) == 0
    return place


FILES = {"fields.pvd", "fields.json", "lower_000.vtu", "upper_000.vtu", "contact_000.vtu"}


class TestCommand:
    def test_files_and_record_agree(self, folder: Path) -> None:
        out = folder / "out"
        record = json.loads((out / "fields" / "fields.json").read_text(encoding="utf-8"))
        assert all((out / name).is_file() for name in [*record["files"], *record["pictures"]])
        assert record["pictures"] == [f"pictures/{name}.png" for name in ("mesh", "von_mises_000")]
        assert [instant["label"] for instant in record["instants"]] == ["asked for 2"]
        for name in ("largest_nodal_von_mises", "largest_nodal_tension"):
            assert all(instant[name]["value"] > 0 for instant in record["instants"])
        assert record["largest nodal stresses"] == NO_PEAK
        assert record["bodies"]["upper"]["supports"] == {"base": "fixed", "sides": "guided"}
        assert record["gap"] == "in the shape of the faces"
        assert "--at 2" in record["command"]

    def test_pictures_show_both_bodies_and_every_boundary(self, folder: Path) -> None:
        """Colours of the boundaries that the two bodies have, and none of the far field that they have not."""
        found = (image.imread(folder / "out" / "pictures" / "mesh.png")[..., :3] * 255).round().astype(int)
        shown = {tuple(colour) for colour in np.unique(found.reshape(-1, 3), axis=0)}
        colours = {name: style_of(f"curve side-{name}")["stroke"] for name in BOUNDARIES}
        wanted = {name: tuple(int(colour[k : k + 2], 16) for k in (1, 3, 5)) for name, colour in colours.items()}
        assert {name for name, colour in wanted.items() if colour in shown} == {"contact", "free", "sides", "base"}

    def test_a_second_run_leaves_no_picture_of_the_first(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        """And no field file, while what other commands wrote stays."""
        out = folder / "again"
        scene = str(folder / "pads.toml")
        assert main(["fe", scene, "--out", str(out), "--quiet", *ROUGH]) == 0
        for times in (("1.5", "2"), ("2",)):
            assert main(["fields", scene, "--at", *times, "--no-pictures", "--out", str(out), "--quiet", *ROUGH]) == 0
            assert NO_PEAK in capsys.readouterr().out
        assert {path.name for path in (out / "fields").iterdir()} == FILES
        assert (out / "halfplane_fe.nc").is_file()
        assert not (out / "pictures").exists()

    def test_refusals_come_first_and_alone(self, tmp_path: Path) -> None:
        (tmp_path / "file").write_text("mine", encoding="utf-8")
        assert "--at soon: give times" in refused(tmp_path, "fields", "cattaneo-mindlin", "--at", "soon")
        assert "--at 99: the instant lies outside" in refused(tmp_path, "fields", "cattaneo-mindlin", "--at", "99")
        assert "--out file: this is a file" in refused(tmp_path, "fields", "cattaneo-mindlin", "--out", "file")

    def test_where_nothing_can_be_drawn_it_is_said_before_solving(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr("reports.cli.machine._SCREEN", "raise SystemExit('no screen here')")
        assert main(["fields", "cattaneo-mindlin", "--quiet"]) == 2
        assert "pictures can't be drawn here: no screen here" in capsys.readouterr().err
        assert not list(tmp_path.iterdir())
