"""Fields on disk, and in pictures: ParaView's collection, the record, what is drawn, the
command.
"""

import json
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
import pyvista

import halfplane_fe
import semi_analytic
from command_line import everything
from halfplane_fe import FiniteElementSolution
from meshes import MeshSettings
from problems import COARSE, FEW_STEPS, fe_run
from reports.cli import main
from reports.field_output import fatigue
from reports.field_output.files import (
    NO_PEAK,
    edge_tension,
    peak,
    series_of,
    tension,
    write_fields,
)
from reports.field_output.pictures import Skin, picture
from scenes import Scene, load_scene, scene_text

ROUGH = (
    "--order",
    "1",
    "--element-size",
    "0.25",
    "--edge-element-size",
    "0.25",
    "--steps-per-cycle",
    "8",
)
QUADRILATERALS = MeshSettings(
    element_size=1 / 8, edge_element_size=1 / 8, far_radius=4, growth=0.5, cells="quadrilaterals"
)
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
KINDS = ["triangles", "quadrilaterals", "blocks"]


def blocks() -> Scene:
    return Scene.model_validate(load_scene("cattaneo-mindlin").model_dump() | {"bodies": BODIES})


def answer_of(kind: str) -> FiniteElementSolution:
    if kind == "blocks":
        return fe_run(blocks(), COARSE, FEW_STEPS)
    return fe_run(
        load_scene("cattaneo-mindlin"), COARSE if kind == "triangles" else QUADRILATERALS, FEW_STEPS
    )


@pytest.mark.parametrize("kind", KINDS)
class TestFiles:
    def test_elements_of_both_bodies_go_round_counter_clockwise_and_fill_the_body(
        self, kind: str
    ) -> None:
        """Areas by pyvista, signed by the corners: a reflected body must not have negative ones,
        nor a node that is none.
        """
        answer = answer_of(kind)
        (snapshot,) = halfplane_fe.fields(answer, [answer.time[-1]])
        for body, mesh in zip(snapshot.bodies, answer.bodies, strict=True):
            corners = body.points[body.cells[:, : mesh.mesh.refdom.nfacets]]
            ahead = np.roll(corners, -1, axis=1)
            areas = (corners[..., 0] * ahead[..., 1] - ahead[..., 0] * corners[..., 1]).sum(
                axis=1
            ) / 2
            assert areas.min() > 0
            skin = Skin(body.points, body.cells, body.von_mises)
            # mid-side nodes of arcs bulge
            assert skin.grid().area == pytest.approx(areas.sum(), rel=0.02)
            assert np.isfinite(body.von_mises).all()
            np.testing.assert_array_equal(np.unique(body.cells), np.arange(len(body.points)))
            per_side = 2 if body.cells.shape[1] in (6, 9) else 1
            assert skin.grid().extract_all_edges().n_cells == per_side * mesh.mesh.facets.shape[1]

    def test_collection_is_read_back_with_times_parts_and_fields(
        self, kind: str, tmp_path: Path
    ) -> None:
        """By VTK's own reader of PVD, the one in ParaView. The contact line adds up to P, and
        warped lies on the warped body.
        """
        answer = answer_of(kind)
        steps = answer.last_cycle[[0, 3]]
        snapshots = halfplane_fe.fields(answer, answer.time[steps])
        names = write_fields(answer, snapshots, tmp_path / "fields")
        assert set(names) == {path.name for path in (tmp_path / "fields").iterdir()}
        reader = pyvista.get_reader(str(tmp_path / "fields" / names[0]))
        assert reader.time_values == answer.time[steps].tolist()
        for step, snapshot in zip(steps, snapshots, strict=True):
            reader.set_active_time_value(snapshot.time)
            table = reader.read()
            assert [active_dataset.part for active_dataset in reader.active_datasets] == [0, 1, 2]
            for block, body in zip(list(table)[:2], snapshot.bodies, strict=True):
                np.testing.assert_array_equal(block.points[:, :2], body.points)
                np.testing.assert_array_equal(block["von_mises"], body.von_mises)
                np.testing.assert_array_equal(block["displacement"][:, :2], body.displacement)
                xx, yy, zz, xy, yz, xz = block["stress"].T
                np.testing.assert_array_equal(np.stack([xx, yy, xy, zz], axis=1), body.stress)
                assert not yz.any()
                assert not xz.any()
            line = table[2]
            np.testing.assert_allclose(line.points[:, 0], answer.x, rtol=0, atol=1e-12)
            assert not line.points[:, 1:].any()
            for name in ("pressure", "shear", "slip", "state"):
                np.testing.assert_array_equal(line[name], getattr(answer, name)[step])
            assert np.trapezoid(line["pressure"], line.points[:, 0]) == pytest.approx(
                answer.normal_load[step], rel=0.01
            )
            assert line.n_cells == len(answer.x) - 1
            assert line.length == pytest.approx(np.ptp(answer.x))
            lower = snapshot.bodies[0]
            nearest = np.linalg.norm(
                lower.points[:, None] - line.points[None, :, :2], axis=2
            ).argmin(axis=0)
            np.testing.assert_array_equal(line["displacement"][:, :2], lower.displacement[nearest])


class TestStress:
    def test_what_is_stated_at_the_edge_is_the_tension_that_nodes_miss(self) -> None:
        """With its uncertainty, body and place; no node has as much."""
        answer = answer_of("triangles")
        step = int(np.argmax(answer.tangential_load))
        (snapshot,) = halfplane_fe.fields(answer, [answer.time[step]])
        at_edge = edge_tension(snapshot)
        assert at_edge is not None
        body = snapshot.bodies[at_edge["body"] == "upper"]
        edge = int(np.argmax(body.edge_tension))
        assert (at_edge["value"], at_edge["uncertainty"]) == (
            body.edge_tension[edge],
            body.edge_tension_uncertainty[edge],
        )
        assert at_edge["x"] == pytest.approx(answer.contact_edges[step, edge], abs=0.1)
        assert (
            max(other_body.edge_tension.max() for other_body in snapshot.bodies)
            == at_edge["value"]
            > peak(snapshot, tension)["value"]
        )


TURN = 2 * np.pi * np.arange(73) / 72


def history(xx: Any = 0.0, yy: Any = 0.0, xy: Any = 0.0, zz: Any = 0.0) -> np.ndarray:
    """Stress (73, 1, 4) through a turn from its components."""
    return np.stack([np.broadcast_to(part, TURN.shape) for part in (xx, yy, xy, zz)], axis=-1)[
        :, None
    ]


# Stress s along one axis, to and fro about 0, pulled alone and pressed alone; t of pure shear, and
# of shear that turns round: xx - yy and xy a quarter of a turn apart, of one size.
S = 150.0
T = 120.0
K = 0.3
LIMIT = 400.0
E = 200e3
NU = 0.3
AXIS, PULLED, PRESSED = (history(xx=S * (np.cos(TURN) + mean)) for mean in (0, 1, -1))
SHEARED = history(xy=T * np.cos(TURN))
ROUND = history(xx=T * np.cos(TURN), yy=-T * np.cos(TURN), xy=T * np.sin(TURN))
# of the critical plane of Fatemi and Socie, k = 1
SINE = (np.sqrt(1 + 8 * (T / LIMIT) ** 2) - 1) / (4 * T / LIMIT)
MEASURES = {
    "principal": "largest principal stress",
    "shear": "largest shear stress",
    "range": "range of von Mises stress",
    "SWT": "Smith-Watson-Topper",
    "Crossland": "Crossland, amplitude of sqrt(J2)",
    "hydrostatic": "Crossland, largest hydrostatic stress",
}
# Measure, stress, closed value, how close.
CLOSED: list[tuple[str, np.ndarray, float, float]] = [
    ("principal", AXIS, S, 1e-6),
    ("shear", AXIS, S / 2, 1e-6),
    ("range", AXIS, 2 * S, 1e-6),
    ("SWT", AXIS, S**2 / E, 1e-6),
    ("Findley", AXIS, S / 2 * (K + np.sqrt(1 + K**2)), 1e-3),
    ("Crossland", AXIS, S / np.sqrt(3), 2e-3),
    ("hydrostatic", AXIS, S / 3, 1e-6),
    ("SWT", PULLED, 2 * S**2 / E, 1e-6),
    ("SWT", PRESSED, 0.0, 1e-9),
    ("range", PULLED, 2 * S, 1e-6),
    ("Crossland", PULLED, S / np.sqrt(3), 2e-3),
    (
        "Fatemi-Socie",
        SHEARED,
        T / (E / (2 * (1 + NU))) * np.sqrt(1 - SINE**2) * (1 + T / LIMIT * SINE),
        1e-3,
    ),
    ("SWT", SHEARED, T**2 * (1 + NU) / E, 1e-6),  # at 45 degrees
    ("range", SHEARED, 2 * np.sqrt(3) * T, 1e-6),
    ("Crossland", SHEARED, T, 2e-3),
    ("hydrostatic", SHEARED, 0.0, 1e-12),
    ("Crossland", ROUND, T, 2e-3),  # the path is a circle
    ("Findley", ROUND, T * (1 + K), 1e-3),
    ("shear", ROUND, T, 1e-6),
    # Half the longest chord is less than the radius where three corners of a triangle are all there
    # is.
    ("Crossland", ROUND[[0, 24, 48]], T, 2e-3),
]


class TestFatigue:
    @pytest.mark.parametrize(("measure", "stress", "value", "close"), CLOSED)
    def test_each_measure_has_its_closed_value(
        self, measure: str, stress: np.ndarray, value: float, close: float
    ) -> None:
        measured = fatigue.measures(stress, fatigue.Criteria((1.0, LIMIT), K), E, NU)[
            MEASURES.get(measure, measure)
        ]
        assert measured[0] == pytest.approx(value, rel=close, abs=0.0 if value else close)

    @pytest.mark.slow
    def test_both_engines_at_the_edge_of_a_known_contact(self) -> None:
        """The largest principal stress is the tension at the trailing edge, and pushing equals
        pulling: SWT is its square over E'.

        Along the face alone and in plane strain e = s (1 - nu^2)/E. On a coarse mesh every measure
        is theory's to half a per cent.
        """
        scene = load_scene("cattaneo-mindlin")
        answer = fe_run(scene, MeshSettings(edge_element_size=0.025), FEW_STEPS)
        peak = semi_analytic.edge_tension(scene, 2.0)[0].max()
        largest_measures = fatigue.largest(
            fatigue.survey(answer, fatigue.Criteria((1.0, 400.0), 0.3))
        )
        assert len(largest_measures) == 16
        for row in largest_measures:
            assert row["finite_elements"]["value"] == pytest.approx(
                row["theory"]["value"], rel=5e-3
            ), row["measure"]
            material = getattr(scene.material, row["body"])
            if row["measure"] == "largest principal stress":
                assert row["theory"]["value"] == pytest.approx(peak, rel=1e-6)
            if row["measure"] == "Smith-Watson-Topper":
                # At the least the edge is pressed by as much: the range is twice the tension.
                expected = peak**2 * (1 - material.poisson_ratio**2) / material.young_modulus
                assert row["theory"]["value"] == pytest.approx(expected, rel=1e-4)
                assert abs(row["theory"]["x"]) == pytest.approx(1.0, abs=1e-9)
        tables = [
            fatigue.survey(answer, fatigue.Criteria(critical_distance=distance))
            for distance in (1e-6, 0.1)
        ]
        largest = [fatigue.largest(table)[0]["theory"]["value"] for table in tables]
        assert largest[0] == pytest.approx(peak, rel=5e-3)
        assert 0.3 * peak < largest[1] < 0.8 * peak


class TestInstants:
    def test_a_series_lies_evenly_in_the_last_cycle_whose_end_is_its_start(self) -> None:
        answer = answer_of("triangles")
        cycle = answer.time[answer.last_cycle]
        series, notes = series_of(answer, None, 8)
        assert not notes
        times = np.array([instant.time for instant in series])
        assert set(times) <= set(cycle[:-1])
        assert (
            np.abs(times - np.linspace(cycle[0], cycle[-1], 9)[:-1]).max()
            <= np.diff(cycle).max() / 2 + 1e-12
        )
        for every in (1, 3):
            assert [instant.time for instant in series_of(answer, every, None)[0]] == cycle[
                :-1:every
            ].tolist()
        series, notes = series_of(answer, None, 1000)
        assert len({snapshot.time for snapshot in series}) == len(series) < len(cycle)
        assert f"{len(series)} instants instead of 1000" in notes[0]


class TestPictures:
    SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    CELL = np.array([[0, 1, 2, 3]])

    def test_what_is_drawn_lies_where_it_is(self) -> None:
        """A unit square in a window of 4 by 2: a quarter of the width, half of the height, at the
        lower left.
        """
        image = picture([Skin(self.SQUARE, self.CELL, np.zeros(4))], (-1.0, 3.0, 0.0, 2.0), 200)
        assert image.shape == (100, 200, 3)
        rows, columns = np.nonzero(image.min(axis=2) < 100)
        assert (rows.min(), rows.max() + 1) == pytest.approx((50, 100), abs=1)
        assert (columns.min(), columns.max() + 1) == pytest.approx((50, 100), abs=1)

    def test_values_take_the_colours_of_the_scale(self) -> None:
        image = picture(
            [Skin(self.SQUARE, self.CELL, self.SQUARE[:, 1])], (0.0, 1.0, 0.0, 1.0), 64
        ).astype(int)
        for row in (2, 20, 40, 61):
            colour = 255 * np.array(mpl.colormaps["viridis"](1 - (row + 0.5) / 64)[:3])
            assert np.abs(image[row, 32] - colour).max() < 8


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `halfplane fields` leaves of a block and a pad; whether it can draw is the doctor's own
    test.
    """
    place = tmp_path_factory.mktemp("fields")
    (place / "pads.toml").write_text(
        scene_text("cattaneo-mindlin").split("[[expected]]")[0] + TOML, encoding="utf-8"
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("reports.cli.machine._SCREEN", "print('drawn')")
        patch.setattr(
            fatigue, "_PLACES_OVER_HALF_WIDTH", np.array([-1.25, -1.0, -0.5, 0.0, 0.5, 1.0, 1.25])
        )
        arguments = [
            "fields",
            str(place / "pads.toml"),
            "--at",
            "2",
            "--frames",
            "2",
            "--fatigue",
            "--quiet",
            *ROUGH,
        ]
        assert main([*arguments, "--out", str(place / "out")]) == 0
    return place


class TestCommand:
    def test_files_and_record_agree(self, folder: Path) -> None:
        out = folder / "out"
        record = json.loads((out / "fields" / "fields.json").read_text(encoding="utf-8"))
        assert all((out / name).is_file() for name in [*record["files"], *record["pictures"]])
        assert record["pictures"] == [f"pictures/{name}.svg" for name in ("mesh", "von_mises_000")]
        assert "asked for 2" in [instant["label"] for instant in record["instants"]]
        assert (
            sum(name.startswith("fields/contact_") for name in record["files"])
            == len(record["instants"])
            == 3
        )
        for name in ("largest_nodal_von_mises", "largest_nodal_tension"):
            assert all(instant[name]["value"] > 0 for instant in record["instants"])
        assert record["largest nodal stresses"] == NO_PEAK
        assert "fields/fatigue.csv" in record["files"]
        assert {row["body"] for row in record["fatigue"]} == {"lower", "upper"}
        table = (out / "fields" / "fatigue.csv").read_text(encoding="utf-8").splitlines()
        assert table[0].startswith("body,")
        assert len(table) == 1 + 2 * 5 * 7
        assert record["bodies"]["upper"]["supports"] == {"base": "fixed", "sides": "guided"}
        assert record["gap"] == "in the shape of the faces"
        assert "--at 2" in record["command"]

    def test_without_a_screen_nothing_is_solved(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr("reports.cli.machine._SCREEN", "raise SystemExit('no screen here')")
        assert main(["fields", "cattaneo-mindlin", "--quiet"]) == 2
        assert "pictures can't be drawn here: no screen here" in capsys.readouterr().err
        assert everything(tmp_path) == set()
