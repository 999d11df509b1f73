"""Readers of foreign results: every form gives the same fields with our signs, every spoilt file
one sentence that says where.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Sequence
from functools import partial
from importlib import resources
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshes import write_pvd
from meshes.files import PvdEntry
from refusals import refused_for, require_facts
from reports.comparison.words import verdict_in_sentences
from reports.scoring import calculix_files, field_files, vtk_files
from reports.scoring.against import report_with_diagnoses, score_file
from reports.scoring.calculix import CalculixMesh
from reports.scoring.calculix_files import read_dat, read_frd
from reports.scoring.field_files import FieldPart, joined_mesh, read_frames
from reports.scoring.mapping import Mapping, load_mapping
from scenes import InputError
from score_results import (
    DATA,
    HALF,
    bodies,
    check,
    edited,
    exact,
    fields,
    mesh,
    pressure_at,
    result,
    rows,
    shear_at,
    tractions,
    written,
)

Make = Callable[[Path], Path]


def file(content: Any, name: str = "result.vtu") -> Make:
    """Writes what is a text, a table, a mesh or makes one of these."""

    def make(folder: Path) -> Path:
        content_made = content() if callable(content) else content
        path = folder / name
        if isinstance(content_made, str):
            path.write_text(content_made, encoding="utf-8")
        else:
            content_made.write(path) if isinstance(content_made, meshio.Mesh) else written(
                content_made, path
            )
        return path

    return make


def same(surface: Any, names: tuple[str, ...], rtol: float = 0.0) -> None:
    for name in names:
        np.testing.assert_allclose(
            getattr(surface, name), getattr(exact(), name), rtol=rtol, atol=rtol, err_msg=name
        )


# ------------------------------------------------------------------------------------------- tables
LONG = rows(exact())
NAMES = {
    "time": "Step Time",
    "x": "COORD1 [mm]",
    "pressure": "CPRESS",
    "shear": "CSHEAR1",
    "slip": "CSLIP1",
}
LAYOUTS = {
    "long": LONG,
    "shuffled": LONG.sample(frac=1, random_state=1),
    "renamed": LONG.rename(columns=NAMES),
    "framed": LONG.drop(columns=["time"]).assign(Frame=np.repeat(np.arange(25), 105)),
    "by loads": LONG.drop(columns=["time"]),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_layout_of_rows_gives_the_same_fields(layout: str, tmp_path: Path) -> None:
    surface = result(written(LAYOUTS[layout], tmp_path / "result.csv"))
    same(
        surface,
        (
            "x",
            "pressure",
            "shear",
            "slip",
            "normal_load",
            *(["time"] if "time" in LAYOUTS[layout] else []),
        ),
    )
    assert any("sorted" in note for note in surface.notes) == (layout == "shuffled")


@pytest.mark.parametrize(
    "tag", ["", " Frame {k}", "_{k}", " t={time!r}", " (Step Time = {time!r})", "own places"]
)
def test_frames_beside_each_other(tag: str, tmp_path: Path) -> None:
    columns = [] if tag == "own places" else [("X", exact().x)]
    for k, time in enumerate(exact().time):
        end = "" if tag == "own places" else tag.format(k=k, time=float(time))
        columns += [("X", exact().x)] if tag == "own places" else []
        columns += [(f"CPRESS{end}", exact().pressure[k]), (f"CSHEAR1{end}", exact().shear[k])]
    lines = [",".join(name for name, _ in columns)]
    table = np.column_stack([values for _, values in columns])
    lines += [",".join(map(repr, row)) for row in table.tolist()]
    path = file("\n".join(lines) + "\n", "paths.csv")(tmp_path)
    surface = result(path)
    same(surface, ("x", "pressure", "shear", *(["time"] if "time" in tag else [])))
    assert any("25 frames" in note for note in surface.notes)
    assert (surface.time is None) == ("time" not in tag)
    np.testing.assert_array_equal(result(path, times=exact().time.tolist()).time, exact().time)


def test_places_that_move_a_little_are_averaged_and_named(tmp_path: Path) -> None:
    table = LONG.assign(x=LONG["x"] + np.repeat(1e-3 * np.sin(np.arange(25)), 105))
    surface = result(written(table, tmp_path / "r.csv"))
    assert any("its mean was taken" in note for note in surface.notes)
    np.testing.assert_allclose(surface.x, exact().x, atol=1e-3)


def test_a_pressure_without_a_shear_is_scored_for_what_it_has(tmp_path: Path) -> None:
    """Its stick edges, states, slip and work are not in the result, and no instant is found by a
    load that is not there.
    """
    solution = exact(steps=9, points=53)
    path = tmp_path / "pressure.csv"
    columns = {
        f"CPRESS t={time!r}": row
        for time, row in zip(solution.time.tolist(), solution.pressure, strict=True)
    }
    frames = result(written(pd.DataFrame({"X": solution.x} | columns), path))
    table = rows(solution)[["time", "x", "pressure"]]
    alone = result(written(table, path))
    assert (frames.has_shear, alone.has_shear) == (False, False)
    np.testing.assert_array_equal(frames.pressure, alone.pressure)
    report = score_file(path, Mapping(), solution.scene)
    comparison = report.comparison
    for key in ("peak_pressure", "pressure", "contact_edge"):
        assert abs(comparison.metric(key).value) < 1e-9, key
    for key in (
        "shear",
        "stick_edge",
        "state",
        "permanent_stick",
        "dissipation",
        "resultant_tangential",
    ):
        assert comparison.metric(key).value is None, key
        assert "not in the result" in comparison.metric(key).note
    # Not passed: shear, stick and dissipation have tolerances and no values.
    assert not comparison.passed
    assert "outside" not in {metric.verdict for metric in comparison.metrics}
    assert report_with_diagnoses(report).diagnoses == ()
    assert [check.name for check in comparison.result_certificates] == ["tension"]
    require_facts(verdict_in_sentences(report.comparison), "No law of contact is violated", "shear")
    written(table[["x", "pressure"]].iloc[:53], path)
    with refused_for("without a shear", "which instant is which"):
        score_file(path, Mapping(), solution.scene)


@pytest.mark.slow
def test_a_wrong_pressure_without_a_shear_is_diagnosed(tmp_path: Path) -> None:
    solution = exact(steps=9, points=53)
    path = written(rows(solution)[["time", "x", "pressure"]], tmp_path / "pressure.csv")
    mapping = Mapping(times=solution.time.tolist(), factors={"stress": 1.1})
    report = report_with_diagnoses(score_file(path, mapping, solution.scene))
    assert report.diagnoses[0].fault in ("traction_factor", "pressure_factor", "units")


# ------------------------------------------------------------------------------------------ mapping
def _mapping(folder: Path, text: str) -> Mapping:
    return load_mapping(file(text, "mapping.toml")(folder))


def test_the_mapping_scales_turns_and_shifts_and_the_example_changes_nothing(
    tmp_path: Path,
) -> None:
    factors = {"pressure": -1e6, "shear": -1e6, "slip": -1e-3, "P": 25.0, "Q": 25.0}
    table = LONG.assign(
        x=(LONG["x"] + 7) / 1e3, **{name: factor * LONG[name] for name, factor in factors.items()}
    )
    text = (
        'code = "mine 1"\nx_offset = 7.0\nthickness = 25.0\n[factors]\nlength = 1000\nstress ='
        ' 1e-6\n[signs]\npressure = "compression negative"\nshear = "on upper"\nslip = "lower over'
        ' upper"\n'
    )
    surface = result(
        written(table, tmp_path / "r.csv"),
        **_mapping(tmp_path, text).model_dump(exclude_unset=True),
    )
    same(surface, ("x", "pressure", "shear", "slip", "normal_load"), 1e-13)
    assert surface.code == "mine 1"
    text = (resources.files("reports") / "templates" / "mapping.toml").read_text("utf-8")
    assert _mapping(tmp_path, text) == Mapping()
    every = re.sub(r"(?m)^# ([\w\"].*=.*|\[element_sizes\])$", r"\1", text)
    assert _mapping(tmp_path, every).columns.pressure == "CPRESS"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("colums = 1\n", "unknown key colums = 1; did you mean columns?"),
        ('[signs]\npressure = "up"\n', "signs.pressure = 'up' is refused"),
        ("thickness = -1\n", "thickness = -1 is refused"),
        ("x = [\n", "not valid TOML"),
        (pd.DataFrame(), "the mapping file can't be read"),
    ],
    ids=str,
)
def test_faults_of_a_mapping(text: Any, words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=re.escape(words)):
        _mapping(tmp_path, text) if isinstance(text, str) else load_mapping(tmp_path / "none.toml")


# ---------------------------------------------------------------------------------- files of fields
def stress(count: int, yy: int, xy: list[int]) -> meshio.Mesh:
    def at(points: np.ndarray) -> np.ndarray:
        p, q = fields(points)
        values = np.full((len(points), count), 7.0)
        values[:, yy] = -p
        values[:, xy] = q[:, None]
        return values

    return mesh(stress=at)


def traction(points: np.ndarray) -> np.ndarray:
    """On the lower body."""
    p, q = fields(points)
    return np.column_stack([q, -p, 0 * p])


def upper_alone() -> meshio.Mesh:
    points, cells = bodies()
    return meshio.Mesh(
        points, [("quad", cells[0][1][40:])], {"contact_traction": -traction(points)}
    )


X = np.linspace(-HALF, HALF, 41)
CHAIN = [("line", np.column_stack([np.arange(40), np.arange(1, 41)]))]
CURVED = np.column_stack([X, 0.3 * X**2, 0 * X])
FACE = np.concatenate([CURVED, CURVED + np.array([0, 0, 0.5])])
QUADS = [("quad", np.array([(k, k + 1, k + 42, k + 41) for k in range(40)]))]


def own_places(points: np.ndarray, cells: list[Any]) -> meshio.Mesh:
    """Nothing decays away from y = 0: all of it is the surface."""
    return meshio.Mesh(
        points, cells, {"pressure": pressure_at(points[:, 0]), "shear": shear_at(points[:, 0])}
    )


def marked() -> meshio.Mesh:
    points, cells = bodies()
    face = np.flatnonzero((points[:, 1] == 0) & np.isin(np.arange(len(points)), cells[0][1][:40]))
    face = face[np.argsort(points[face, 0])]
    lines = ("line", np.column_stack([face[:-1], face[1:]]))
    # as meshio writes a set of points
    outside = np.where(np.isin(np.arange(len(points)), face), 0.0, -1.0)
    point_fields = tractions(points) | {"face": outside, "both": (points[:, 1] == 0).astype(float)}
    return meshio.Mesh(
        points, [*cells, lines], point_fields, {"tag": [np.full(80, 3), np.full(40, 12)]}
    )


def raised() -> meshio.Mesh:
    full_mesh = mesh()
    full_mesh.points[:, 1] += 5.0
    return full_mesh


def collection(folder: Path, times: tuple[float, ...] = (0.0, 0.5, 2.0)) -> Path:
    """Instants scaled by 1, 2, 3, the last first in the file; the two bodies in files of their
    own.
    """
    points, cells = bodies()
    entries = []
    for k, time in reversed(list(enumerate(times))):
        for part in (0, 1):
            quads = cells[0][1][40 * part : 40 * part + 40]
            name = f"body{part}_{k}.vtu"
            meshio.Mesh(points, [("quad", quads)], tractions(points, k + 1)).write(folder / name)
            entries.append(PvdEntry(time, part, f"body {part}", name))
    write_pvd(folder / "result.pvd", entries)
    return folder / "result.pvd"


def spoilt_instant(name: str, change: Callable[[Any], object] | None, folder: Path) -> Path:
    path = collection(folder)
    spoilt = meshio.read(folder / name)
    (folder / name).unlink()
    if change is not None:
        change(spoilt)
        spoilt.write(folder / name)
    return path


POINTS, CELLS = bodies()
WHOLE = tractions(POINTS)
BARE = {name: WHOLE[name] for name in ("CPRESS", "CSHEAR1")}
LOWER = np.isin(np.arange(len(POINTS)), CELLS[0][1][:40]) & (POINTS[:, 1] == 0)


def parts(*fields_of_parts: dict[str, np.ndarray]) -> Make:
    """The two bodies of one instant in files of their own, each with its fields."""

    def make(folder: Path) -> Path:
        for part, point_fields in enumerate(fields_of_parts):
            meshio.Mesh(
                POINTS, [("quad", CELLS[0][1][40 * part : 40 * part + 40])], point_fields
            ).write(folder / f"body{part}.vtu")
        write_pvd(
            folder / "result.pvd",
            [PvdEntry(1.0, part, f"body {part}", f"body{part}.vtu") for part in (0, 1)],
        )
        return folder / "result.pvd"

    return make


ORDERS = [
    (6, 1, [3], "xx, yy, zz, xy, yz, xz"),
    (9, 4, [1, 3], "rows of 3 x 3"),
    (3, 1, [2], "xx, yy, xy"),
    (4, 1, [3], "xx, yy, zz, xy"),
    (4, 3, [1, 2], "rows of 2 x 2"),
]
UPPER = {"signs": {"shear": "on upper"}}
LEFT = "has no 'CPRESS', 'CSHEAR1': left out"
FORCE = {
    "columns": {"pressure": "force:1", "shear": "force:0"},
    "signs": {"pressure": "compression negative"},
}
SLIP = {"columns": {"slip": "CSLIP1", "pressure": "CPRESS", "shear": "CSHEAR1"}}
# What is written, the mapping, the factor of the tractions that are read (of the last instant),
# parts of the notes.
READ: dict[str, tuple[Make, dict[str, Any], float, list[str]]] = {
    **{
        f"{suffix}, {deep} deep": (
            file(partial(mesh, deep), f"result{suffix}"),
            {},
            1.0,
            [
                "the surface is the lower body's face, found at y = 0",
                *(["the model is 0.25 thick"] if deep else []),
            ],
        )
        for suffix in (".vtu", ".vtk")
        for deep in (0.0, 0.25)
    },
    **{
        f"stress, {order[-1]}": (
            file(partial(stress, *order[:-1])),
            {},
            1.0,
            ["p = -sigma_yy and q = sigma_xy of the lower body", order[-1]],
        )
        for order in ORDERS
    },
    "stress in other units": (
        file(partial(stress, *ORDERS[0][:-1])),
        {"factors": {"stress": 1e-6}},
        1e-6,
        [],
    ),
    "a vector on the lower body": (file(partial(mesh, contact_traction=traction)), {}, 1.0, []),
    "a vector said to be on the upper": (
        file(partial(mesh, contact_traction=traction)),
        UPPER,
        -1.0,
        [],
    ),
    "a slip beside a vector": (
        file(partial(mesh, contact_traction=traction, glide=lambda points: points[:, 0])),
        {"columns": {"slip": "glide"}},
        1.0,
        ["columns.slip = 'glide' is not read beside a vector: state columns.pressure"],
    ),
    "a vector on the upper body": (file(upper_alone), {}, 1.0, ["taken to act on the upper body"]),
    "a vector said to be on the lower": (
        file(upper_alone),
        {"signs": {"shear": "on lower"}},
        -1.0,
        [],
    ),
    "components by name": (file(partial(mesh, force=traction)), FORCE, 1.0, []),
    "a path": (file(partial(own_places, CURVED, CHAIN)), {}, 1.0, []),
    "a curved face": (file(partial(own_places, FACE, QUADS)), {}, 1.0, []),
    **{
        f"what {mark} marks": (
            file(marked),
            {"surface": mark, "y_offset": 99.0},
            1.0,
            [f"the surface is what {mark} marks"],
        )
        for mark in ("tag=12", "face")
    },
    "what both bodies have": (
        file(marked),
        {"surface": "both", "y_offset": 99.0},
        1.0,
        [
            "the surface is what both marks",
            "points of both bodies: those of the lower one were taken",
        ],
    ),
    "at another y": (file(raised), {"y_offset": 5.0}, 1.0, []),
    "a collection": (collection, {}, 3.0, []),
    "fields of the lower part alone": (
        parts(WHOLE, {}),
        {},
        1.0,
        [f"body1.vtu {LEFT}", "the surface is the lower body's face"],
    ),
    "fields of the upper part alone": (
        parts({}, WHOLE),
        {},
        1.0,
        [f"body0.vtu {LEFT}", "the surface is the upper body's face"],
    ),
    "slip of one part": (
        parts(BARE, WHOLE),
        {},
        1.0,
        ["CSLIP1 is not in all of the files"],
    ),
    "slip of one part, asked for": (
        parts(BARE, WHOLE),
        SLIP,
        1.0,
        ["body0.vtu has no 'CSLIP1': left out"],
    ),
    "a mark in one part": (
        parts(WHOLE | {"face": 1.0 * LOWER}, WHOLE),
        {"surface": "face"},
        1.0,
        ["body1.vtu has no 'face': left out"],
    ),
}


def read_here(paths: Sequence[Path]) -> bytes:
    """What the process of a reader would write, without the second that it takes to start."""
    content = io.BytesIO()
    arrays: dict[str, Any] = dict(vtk_files.numbered_arrays([str(path) for path in paths]))
    np.savez(content, **arrays)
    return content.getvalue()


@pytest.mark.parametrize("case", READ)
def test_every_file_of_fields_gives_the_tractions_of_the_surface_and_says_how(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make, mapping, scale, notes = READ[case]
    # these in the process that users have
    if case not in (".vtu, 0.0 deep", ".vtk, 0.25 deep", "a collection"):
        monkeypatch.setattr(field_files, "_read_in_process", read_here)
    surface = result(make(tmp_path), **mapping)
    check(surface, scale)
    all_notes = " ".join(surface.notes)
    assert not [words for words in notes if words not in all_notes]
    if " deep" in case or "asked for" in case:
        np.testing.assert_allclose(surface.slip[0], 1e-3 * surface.x, atol=1e-15)
    assert case != "slip of one part" or surface.slip is None
    if " deep" in case:
        assert surface.time is None
        assert ("thick" in all_notes) == ("0.25" in case)


def test_instants_come_in_the_order_of_time_and_mapping_shifts_and_scales(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(field_files, "_read_in_process", read_here)
    path = collection(tmp_path)
    surface = result(path)
    np.testing.assert_array_equal(surface.time, [0.0, 0.5, 2.0])
    np.testing.assert_allclose(surface.pressure[0] * 2, surface.pressure[1])
    np.testing.assert_array_equal(result(path, times=[1, 2, 3]).time, [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(result(path, factors={"time": 2.0}).time, [0.0, 1.0, 4.0])
    surface = result(
        file(raised)(tmp_path), y_offset=5000.0, x_offset=500.0, factors={"length": 1e3}
    )
    np.testing.assert_allclose(surface.x, 1e3 * X - 500.0)


# What the process of the reader does -> words of the refusal.
ENDS = {
    "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)": (
        "of another form (VTK's reader ended with code -11)"
    ),
    "import time; time.sleep(60)": "reading takes longer than 2 s, which is the limit",
    "raise MemoryError": "more than 2.15 GB of memory",
}


@pytest.mark.parametrize("script", ENDS)
def test_a_reader_that_dies_hangs_or_grows_is_one_sentence_that_names_the_file(
    script: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second file of a collection is what it was reading."""
    path = collection(tmp_path, (0.0, 1.0))
    (tmp_path / "reader.py").write_text(
        f"""print('{{"file": 1}}', file=__import__("sys").stderr, flush=True)\n{script}\n"""
    )
    monkeypatch.setattr(vtk_files, "__file__", str(tmp_path / "reader.py"))
    monkeypatch.setattr(field_files, "MOST_SECONDS_OF_READING", 2)
    with pytest.raises(InputError, match=re.escape(ENDS[script])) as caught:
        read_frames(path)
    assert str(caught.value).startswith(str(tmp_path / "body1_1.vtu"))


def test_files_too_large_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(field_files, "MOST_BYTES_OF_FILE", 100)
    monkeypatch.setattr(calculix_files, "MOST_BYTES_OF_FILE", 100)
    with pytest.raises(InputError, match="write the contact surface alone"):
        read_frames(file(mesh())(tmp_path))
    for reader, kind in ((read_frd, "frd"), (read_dat, "dat")):
        with pytest.raises(InputError, match="at most 100 bytes are read"):
            reader(DATA / f"surface-to-surface.{kind}")


# ------------------------------------------------------------------ what CalculiX 2.20 really wrote
P = 400.0
Q = 60.0
FRICTION = 0.3
MORTAR, SURFACE = ((DATA / f"{name}.frd").read_text() for name in ("mortar", "surface-to-surface"))
BLOCK = read_frd(DATA / "mortar.frd").blocks[0]
FORCE_HEAD = "total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)"
# What trapezia over the file's values lose or gain of P, measured, and twice that: edges fall
# within an element of 0.1 a/0.66.
ADDS_UP = {
    "node-to-surface.frd": 1e-3,  # 5.2e-4
    "node-to-surface.dat": 2e-3,  # 7.7e-4
    "mortar.frd": 1e-3,  # 4.8e-4
    # 0.021: nodal values of the linear face are extrapolated from its integration points
    "surface-to-surface.frd": 0.05,
    "surface-to-surface.dat": 0.02,  # 0.010
}


@pytest.mark.parametrize("name", ADDS_UP)
def test_equilibrium_holds_every_sign_of_calculix(name: str) -> None:
    surface = result(name)
    normal, tangential = (
        np.trapezoid(field, surface.x, axis=1) for field in (surface.pressure, surface.shear)
    )
    np.testing.assert_allclose(normal, [P, P], rtol=ADDS_UP[name])
    # Shear is loaded to half of sliding: the same edges, on a part of the pressure.
    np.testing.assert_allclose(tangential, [0.0, Q], atol=ADDS_UP[name] * P * FRICTION * 1.5)
    np.testing.assert_array_equal(surface.time, [1.0, 2.0])
    assert np.all(np.diff(surface.x) > 0)
    # Friction holds the Coulomb limit (1e-5 of the peak: six digits in the file); the upper body
    # slips along the pull.
    assert np.all(
        np.abs(surface.shear) <= FRICTION * np.abs(surface.pressure) + 1e-5 * surface.pressure.max()
    )
    slides = (np.abs(surface.shear[1]) > 0.999 * FRICTION * surface.pressure[1]) & (
        surface.pressure[1] > 1.0
    )
    assert np.count_nonzero(slides) >= 2
    assert np.all((surface.slip[1] - surface.slip[0])[slides] > 0)
    assert np.all(surface.shear[1][slides] > 0)
    if name.startswith("surface"):
        np.testing.assert_allclose(surface.normal_load, [P, P], rtol=1e-4)
        np.testing.assert_allclose(surface.tangential_load, [0.0, Q], atol=1e-4 * Q)
        require_facts("\n".join(surface.notes), "in surface-to-surface.dat", "thickness, 1")


def beside(folder: Path, force: list[tuple[float, float]], normal: tuple[float, ...]) -> Path:
    """The mortar run (0.5 thick) with resultants printed beside it, as CalculiX would."""
    text = ""
    for time, resultant in ((1.0, force[0]), (2.0, force[1])):
        text += f" statistics for slave set SUPPER, master set SLOWER and time  {time:.7E}\n\n"
        for head, row in (
            (FORCE_HEAD, (*resultant, 0, 0, 0, 0)),
            ("center of gravity and mean normal", (0, 0, 0, *normal)),
        ):
            text += f"   {head}\n\n" + "".join(f"{v:14.6E}" for v in row) + "\n\n"
    (folder / "mortar.dat").write_text(text)
    return edited(folder, "mortar.frd")


def test_resultants_beside_the_file_are_turned_divided_named_and_checked(tmp_path: Path) -> None:
    path = beside(tmp_path, [(0.0, 200.0), (-30.0, 200.0)], (0.0, -1.0, 0.0))
    surface = result(path)
    np.testing.assert_allclose([surface.normal_load, surface.tangential_load], [[P, P], [0.0, Q]])
    assert any("the mesh's thickness, 0.5" in note for note in surface.notes)
    np.testing.assert_allclose(result(path, thickness=1.0).normal_load, [200.0, 200.0])
    text = path.with_suffix(".dat").read_text()
    path.with_suffix(".dat").write_text(
        text + text.replace("SUPPER", "OTHER").replace("2.000000E+02", "9.000000E+02")
    )
    with pytest.raises(InputError, match=r"several contact pairs \(slave faces OTHER, SUPPER\)"):
        result(path)
    np.testing.assert_allclose(result(path, surface="SUPPER").normal_load, [P, P])
    surface = result(beside(tmp_path, [(0.0, 0.0), (0.0, 0.0)], (np.nan,) * 3))
    assert surface.normal_load is None
    assert any("states the pair's resultant at 0 of 2 times" in note for note in surface.notes)


def test_units_times_offset_and_stated_signs_of_calculix() -> None:
    plain = result("mortar.frd")
    signs = {"shear": "on upper", "slip": "lower over upper"}
    factors = {"length": 1e-3, "stress": 1e6, "time": 2.0}
    turned = result("mortar.frd", factors=factors, x_offset=1e-4, signs=signs, code="mine")
    # With the upper body as slave CSHEAR1 counts as we do; the mapping says it does not.
    for name, expected in (
        ("x", plain.x * 1e-3 - 1e-4),
        ("pressure", plain.pressure * 1e6),
        ("shear", -plain.shear * 1e6),
        ("slip", -plain.slip * 1e-3),
        ("time", [2.0, 4.0]),
    ):
        np.testing.assert_allclose(getattr(turned, name), expected, err_msg=name)
    np.testing.assert_array_equal(result("mortar.frd", times=[0.25, 0.5]).time, [0.25, 0.5])
    assert (plain.code, turned.code) == ("CalculiX Version 2.20", "mine")
    # A stated sign replaces that of the slave face.
    derived = result("node-to-surface.frd")
    np.testing.assert_array_equal(
        result("node-to-surface.frd", signs={"shear": "on upper"}).shear, derived.shear
    )
    np.testing.assert_array_equal(
        result("node-to-surface.frd", signs={"shear": "on lower"}).shear, -derived.shear
    )


def test_stress_stands_in_for_contact_values_in_either_form(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = edited(tmp_path, "surface-to-surface.frd", (" -4  CONTACT ", " -4  CONTAXT "))
    surface = result(path)
    file = read_frd(path, ("STRESS",))
    grid = CalculixMesh(file)
    block = file.blocks[-1]
    values = np.zeros((len(grid.numbers), 6))
    values[grid.rows_of_nodes(block.nodes)] = block.values
    quads = grid.rows_of_nodes(np.array([element.nodes for element in file.elements]))
    meshio.Mesh(grid.points, [("quad", quads)], {"stress": values}).write(tmp_path / "result.vtu")
    for surface_read in (surface, result(tmp_path / "result.vtu")):
        # Extrapolated nodal stress of linear elements: 7 % of P, 2 % of Q measured.
        np.testing.assert_allclose(
            np.trapezoid(surface_read.pressure[-1], surface_read.x), P, rtol=0.12
        )
        np.testing.assert_allclose(
            np.trapezoid(surface_read.shear[-1], surface_read.x), Q, rtol=0.12
        )
        assert surface_read.slip is None
    opened = []
    plainly = Path.open
    monkeypatch.setattr(
        Path,
        "open",
        lambda path, *how, **keywords: opened.append(path) or plainly(path, *how, **keywords),
    )
    result(path)
    assert opened == [path]  # read once, although it has no contact values
    assert "p = -SYY and q = SXY of the lower body" in surface.notes[0]
    # Resultants still come from the .dat file, whichever body was the slave.
    path.with_suffix(".dat").write_bytes((DATA / "surface-to-surface.dat").read_bytes())
    np.testing.assert_allclose(result(path).tangential_load, [0.0, Q], atol=1e-4 * Q)
    np.testing.assert_allclose(result(path, factors={"stress": 2.0}).shear, 2 * surface.shear)
    with pytest.raises(InputError, match=r"no node of a lower body's face at y = 0\.5; .*y_offset"):
        result(path, y_offset=0.5)


# -------------------------------------------------------------------------- CalculiX files at fault


def _last(text: str, old: str, new: str) -> str:
    at = text.rindex(old)
    return text[:at] + new + text[at + len(old) :]


def _contact(text: str, old: str, new: str) -> str:
    """Replaced in the contact blocks alone."""
    at = text.index(" -4  CONTACT ")
    return text[:at] + text[at:].replace(old, new)


def _touched_on_the_other_face() -> str:
    """One slave node of the upper body gets the number of a node of the block's face."""
    file = read_frd(DATA / "mortar.frd")
    touched = BLOCK.nodes[BLOCK.column("CPRESS") > 0][0]
    on_face = file.nodes[(file.points[:, 1] == 0) & (np.abs(file.points[:, 0] - 1.0) < 0.5)][0]
    return _contact(MORTAR, f" -1{touched:10d}", f" -1{on_face:10d}")


NODE = BLOCK.nodes[0]
FIRST = next(line for line in MORTAR.splitlines()[BLOCK.line :] if line.startswith(" -1"))
OPEN = re.sub(
    r"(?m)^( -1 {7}.{3})(?:.{12}){6}$",
    r"\1" + 6 * " 0.00000E+00",
    MORTAR[MORTAR.index(" -4  CONTACT") :],
)
STRESS = SURFACE.replace(" -4  CONTACT ", " -4  CONTAXT ")
SHORT = {
    "stopped": (
        MORTAR[: [m.start() for m in re.finditer("    1PSTEP", MORTAR)][2]],
        "the file has no end (9999)",
    ),
    "no last contact": (
        _last(MORTAR, " -4  CONTACT ", " -4  CONTAXT "),
        "left out: 1 frames without contact values (first at time 2)",
    ),
    "no last stress": (
        _last(STRESS, " -4  STRESS ", " -4  STRESX "),
        "left out: 1 frames without stress (first at time 2)",
    ),
    "one time twice": (
        STRESS.replace("  102 2.000000000", "  102 1.000000000"),
        "1 blocks of stress share a time with a later one",
    ),
}


def _set(row: int, name: str, value: object) -> Callable[[Any], Any]:
    return lambda table: table.assign(
        **{name: [value if k == row else old for k, old in enumerate(table[name])]}
    )


def table(change: Callable[[Any], Any]) -> Make:
    return file(lambda: change(LONG.astype(object)), "result.csv")


def calculix(name: str, text: str, *neighbours: str) -> Make:
    """A file of CalculiX, and others that lie beside it."""

    def make(folder: Path) -> Path:
        for neighbour in neighbours:
            (folder / name).with_suffix(".frd").write_text(neighbour)
        return file(text, name)(folder)

    return make


PRINTED = (DATA / "surface-to-surface.dat").read_text()
PLACE = next(
    line for line in PRINTED.splitlines() if line.strip().startswith("1") and len(line.split()) == 5
)
ELEMENT = PLACE.split()[0]
CELL_OF_NOTHING = """# vtk DataFile Version 3.0
two cells, one without points
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 3 double
0 0 0 1 0 0 0 1 0
CELLS 2 5
3 0 1 2
0
CELL_TYPES 2
5
0
"""
CELL_OF_LESS = CELL_OF_NOTHING.replace("0 1 2\n0\n", "0 1 2\n-1\n")
PVD = "<VTKFile type='Collection'><DataSet {}file='a.pvd'/></VTKFile>"
AVERAGE = meshio.Mesh(POINTS, CELLS, cell_data={"CPRESS": [np.ones(80)], "CSHEAR1": [np.ones(80)]})


def no_such_point(folder: Path) -> Path:
    path = folder / "a.vtk"
    mesh().write(path, file_format="vtk42", binary=False)
    head, cells, tail = path.read_text().partition("CELLS")
    path.write_text(head + cells + tail.replace("\n4 ", "\n4 9", 1).replace("\n4\n", "\n4\n9", 1))
    return path


# What is read, words of the sentence, the mapping.
FAULTS: dict[str, tuple[Any, ...]] = {
    "no pressure": (
        table(lambda t: t.drop(columns="pressure")),
        "no column for pressure (looked for pressure, p, CPRESS",
    ),
    "nearly a pressure": (
        table(lambda t: t.rename(columns={"pressure": "CPRES [Pa]"})),
        "if 'CPRES [Pa]' is it, write the lines [columns] and pressure = \"CPRES [Pa]\"",
    ),
    "no x": (table(lambda t: t.drop(columns="x")), "no column for x"),
    "word in a cell": (
        table(_set(7, "pressure", "n/a")),
        "line 9: pressure = 'n/a' is not a finite number",
    ),
    "a point twice": (
        table(_set(8, "x", float(exact().x[7]))),
        "stands there twice in one instant",
    ),
    "a ragged instant": (table(lambda t: t.drop(index=3)), "every instant needs the same points"),
    "P within an instant": (table(_set(5, "P", 1.0)), "normal_load goes from"),
    "places of another mesh": (
        table(_set(5, "x", -1.19)),
        "the points are not the same at every instant",
    ),
    "two shears": (
        table(lambda t: t.rename(columns={"shear": "cshear"}).assign(CSHEAR=0.0)),
        "could each be shear; say which by columns.shear",
    ),
    "no names": (
        file("0,1,2\n1,2,3\n", "result.csv"),
        "line 1: the first line must name the columns",
    ),
    "two points": (
        file("x,pressure,shear\n0,1,0\n1,1,0\n", "result.csv"),
        "2 points are no surface",
    ),
    "two pressures": (
        file("x,pressure,CPRESS,shear\n0,1,1,0\n", "result.csv"),
        "frame 1 has no shear, or no pressure",
    ),
    "half a frame": (
        file("x,p_1,q_1,p_2\n0,1,0,1\n1,1,0,1\n2,1,0,1\n", "result.csv"),
        "frame 2 has no shear, or no pressure",
    ),
    "other times": (
        table(lambda t: t.drop(columns="time").assign(Frame=np.repeat(np.arange(25), 105))),
        "times and the file has 25 ",
        {"times": [0.0, 1.0]},
    ),
    "a column that is none": (
        file(LONG, "result.csv"),
        "columns.pressure = 'presure'",
        {"columns": {"pressure": "presure"}},
    ),
    "another program's": (file("x", "a.odb"), "no reader for '.odb'; it reads .csv"),
    "an empty collection": (
        file("<VTKFile type='Collection'><Collection/></VTKFile>", "a.pvd"),
        "the collection is empty",
    ),
    "no collection": (
        file("<VTKFile type='UnstructuredGrid'/>", "a.pvd"),
        "type Collection is expected",
    ),
    "no time": (file(PVD.format(""), "a.pvd"), "has no time"),
    "within itself": (file(PVD.format("timestep='1' "), "a.pvd"), "no reader for '.pvd' within"),
    "broken off": (file("<VTKFile", "a.pvd"), "can't be read as a .pvd file: it is broken off"),
    "empty VTU": (file("", "a.vtu"), "can't be read as a .vtu file"),
    "no VTK": (file("no\nvtk\nat all\n", "a.vtk"), "can't be read as a .vtk file"),
    "XDMF": (file("<Xdmf Version='3.0'></Xdmf>", "a.xdmf"), "no reader for '.xdmf'; it reads .csv"),
    "no such point": (no_such_point, "names a point that is not there"),
    "cell of nothing": (file(CELL_OF_NOTHING, "a.vtk"), "a cell has no points"),
    "cell of less": (file(CELL_OF_LESS, "a.vtk"), "a cell has no points"),
    "no field": (
        file(partial(mesh, force=traction)),
        "among 'force'",
    ),
    "no such field": (
        file(lambda: mesh(CPRESS=lambda p: fields(p)[0])),
        "columns.shear = 'CSHEAR1', which is not there",
        {"columns": {"shear": "CSHEAR1"}},
    ),
    "values of cells": (
        file(AVERAGE),
        "values of cells, 'CPRESS', 'CSHEAR1', are not read",
    ),
    "no face": (
        file(raised),
        "y = 0 (y goes from 4.5 to 5.5)",
    ),
    "a mark of nothing": (file(marked), "marks nothing", {"surface": "tag=5"}),
    "a mark by a word": (file(marked), "'x' is no number", {"surface": "tag=x"}),
    "a mark that is none": (file(marked), "names no field of it", {"surface": "top"}),
    "no part has it whole": (
        parts(*({name: WHOLE[name]} for name in BARE)),
        "body0.vtu has no 'CSHEAR1'; body1.vtu has no 'CPRESS'",
    ),
    "parts unlike": (
        parts(WHOLE, WHOLE | {"CPRESS": POINTS}),
        "body0.vtu: CPRESS has another number of components",
    ),
    **{
        fact: (partial(spoilt_instant, name, change), fact)
        for name, change, fact in (
            (
                "body0_1.vtu",
                lambda m: m.point_data.pop("CSHEAR1"),
                "instant 2 has no field 'CSHEAR1'",
            ),
            (
                "body0_2.vtu",
                lambda m: m.points.__setitem__((0, 0), 9.0),
                "the points of instant 3 are not those of the first",
            ),
            ("body0_2.vtu", None, "it names body0_2.vtu, which is not there"),
        )
    },
    "neither contact nor stress": (
        calculix("run.frd", MORTAR.replace(" -4  CONTACT ", " -4  CONTAXT ")),
        "no block CONTACT and none STRESS; it has DISP",
    ),
    "a node without coordinates": (
        calculix("run.frd", _contact(MORTAR, f" -1{NODE:10d}", f" -1{NODE + 90000:10d}")),
        "has a result or an element and no coordinates",
    ),
    "no contact": (
        calculix("run.frd", MORTAR[: MORTAR.index(" -4  CONTACT")] + OPEN),
        "the bodies do not touch",
    ),
    "NaN": (
        calculix("run.frd", MORTAR.replace(FIRST, FIRST[:13] + "         NaN" + FIRST[25:])),
        f"line {BLOCK.line}: block CONTACT holds numbers that are not",
    ),
    "no shear": (
        calculix("run.frd", MORTAR.replace(" -5  CSHEAR1 ", " -5  CSHEARX ")),
        "block CONTACT has no CSHEAR1",
    ),
    "both faces": (calculix("run.frd", _touched_on_the_other_face()), "nodes of both bodies"),
    "other instants": (
        calculix("run.frd", MORTAR),
        "times and the file has 2 instants",
        {"times": [1.0]},
    ),
    "no places": (
        calculix("alone.dat", (DATA / "node-to-surface.dat").read_text()),
        "no alone.frd beside it",
    ),
    "no such element": (
        calculix(
            "run.dat", PRINTED.replace(PLACE[:21], f"{90000:10d} {PLACE.split()[1]:>10}"), SURFACE
        ),
        "element 90000 is not in it",
    ),
    "no such side": (
        calculix("run.dat", PRINTED.replace(PLACE[:21], f"{ELEMENT:>10} {1:10d}"), SURFACE),
        "of kind 9 has no face 1",
    ),
    "no stress printed": (
        calculix("run.dat", PRINTED.replace(" contact stress (", " contact strain ("), SURFACE),
        "no contact stress is printed in it",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_of_a_file_is_one_sentence(
    fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make, fact, *mapping = FAULTS[fault]
    if fault not in ("empty VTU", "no VTK", "no such point", "cell of nothing", "cell of less"):
        monkeypatch.setattr(field_files, "_read_in_process", read_here)
    path = make(tmp_path)
    with pytest.raises(InputError, match=re.escape(fact)) as caught:
        result(path, **(mapping[0] if mapping else {}))
    assert "\n" not in str(caught.value)
    place = {
        "no such element": tmp_path,
        "no such side": tmp_path,
        "parts unlike": "body0.vtu",
    }.get(fault, path)
    assert str(caught.value).startswith(str(place))


@pytest.mark.parametrize("fault", SHORT)
def test_a_calculix_file_that_lacks_an_instant_is_read_and_says_so(
    tmp_path: Path, fault: str
) -> None:
    text, fact = SHORT[fault]
    (tmp_path / "run.frd").write_text(text)
    surface = result(tmp_path / "run.frd")
    np.testing.assert_array_equal(surface.time, [1.0])
    assert any(fact in note for note in surface.notes)


# -------------------------------------------------------------------------- the forms .frd and .dat
NODES = ((1, 0.0, 0.0, 0.0), (2, 1.0, 0.0, 0.0), (3, 1.0, 1.0, 0.0), (40, 0.0, 1.0, 0.0))
CONTACT = ("COPEN", "CSLIP1", "CSLIP2", "CPRESS", "CSHEAR1", "CSHEAR2")


def number(value: float) -> str:
    """Twelve characters, as CalculiX prints a float: %12.5E."""
    return f"{value:12.5E}"


def record(node: int, values: tuple[float, ...], label: int = 10, key: str = "-1") -> str:
    return f" {key}{node:{label}d}" + "".join(map(number, values)) + "\n"


def frd(
    table: list[Any],
    name: str = "CONTACT",
    components: tuple[str, ...] = CONTACT,
    form: int = 1,
    time: float = 0.5,
) -> str:
    """A file of four nodes, one quadrangle and one result block."""
    label = {0: 5, 1: 10}[form]
    text = "    1C\n    1UPGM               CalculiX\n    1UVERSION           Version 2.20\n"
    text += (
        f"    2C{'':18}{len(NODES):12d}{'':37}{form}\n"
        + "".join(record(n, place, label) for n, *place in NODES)
        + " -3\n"
    )
    text += f"    3C{'':18}{1:12d}{'':37}{form}\n -1{1:{label}d}{9:5d}{0:5d}{1:5d}\n -2"
    text += "".join(f"{n:{label}d}" for n, *_ in NODES) + "\n -3\n"
    text += (
        f"    1PSTEP{1:26d}{1:12d}{1:12d}\n  100CL "
        f" 101{number(time)}{len(table):12d}{'':20}{0:2d}{1:5d}{'':10}{form:2d}\n"
    )
    text += f" -4  {name:8}{len(components):5d}{1:5d}\n"
    text += "".join(
        f" -5  {component:8}{1:5d}{4:5d}{k + 1:5d}{0:5d}\n"
        for k, component in enumerate(components)
    )
    for node, *values in table:
        text += record(node, values[:6], label)
        for k in range(6, len(values), 6):
            text += record(node, values[k : k + 6], label, "-2").replace(
                f"{node:{label}d}", " " * label
            )
    return text + " -3\n 9999\n"


def frd_of(folder: Path, text: str, **how: Any) -> calculix_files.FrdFile:
    (folder / "case.frd").write_text(text, **how)
    return read_frd(folder / "case.frd", ("CONTACT", "DISP"))


# Six digits and two of the exponent is all that twelve characters hold.
SIX_DIGITS = st.builds(
    lambda m, e: float(f"{m:.5f}E{e}"), st.floats(-9.99999, 9.99999), st.integers(-90, 90)
)


@settings(max_examples=40)
@given(
    columns=st.integers(1, 20),
    count=st.integers(1, 4),
    draws=st.data(),
    form=st.sampled_from([0, 1]),
)
def test_numbers_of_fixed_width_come_back_exactly(
    tmp_path_factory: pytest.TempPathFactory,
    columns: int,
    count: int,
    draws: st.DataObject,
    form: int,
) -> None:
    """Over several lines where there are more than six."""
    values = draws.draw(
        st.lists(
            st.lists(SIX_DIGITS, min_size=columns, max_size=columns), min_size=count, max_size=count
        )
    )
    names = tuple(f"C{k}" for k in range(columns))
    text = frd(
        [(k + 1, *row) for k, row in enumerate(values)], components=names, form=form, time=0.25
    )
    (block,) = frd_of(tmp_path_factory.mktemp("frd"), text).blocks
    np.testing.assert_array_equal(block.values, values)
    np.testing.assert_array_equal(block.nodes, np.arange(count) + 1)
    np.testing.assert_array_equal(block.column(names[-1]), block.values[:, -1])
    assert (block.time, block.components) == (0.25, names)


def test_what_else_is_in_a_frd_file(tmp_path: Path) -> None:
    frd_file = frd_of(tmp_path, frd([(1, *range(6))]))
    assert (frd_file.version, frd_file.names, frd_file.times) == (
        "CalculiX Version 2.20",
        ("CONTACT",),
        (0.5,),
    )
    np.testing.assert_array_equal(frd_file.nodes, [1, 2, 3, 40])
    np.testing.assert_array_equal(frd_file.points, [row[1:] for row in NODES])
    assert [(e.number, e.kind, e.nodes) for e in frd_file.elements] == [(1, 9, (1, 2, 3, 40))]
    with pytest.raises(KeyError):
        frd_file.blocks[0].column("CPRES")
    frd_file = frd_of(tmp_path, frd([(1, 1.0)], "PEEQ", ("PE",)))  # not asked for: passed over
    assert (frd_file.blocks, frd_file.names, frd_file.times) == ((), ("PEEQ",), (0.5,))
    # ALL, which viewers work out, is not in the file
    text = frd([(1, 1.0, 2.0, 3.0)], "DISP", ("D1", "D2", "D3", "ALL"))
    text = text.replace(
        f" -5  ALL     {1:5d}{4:5d}{4:5d}{0:5d}", f" -5  ALL     {1:5d}{2:5d}{0:5d}{0:5d}{1:5d}ALL"
    )
    assert frd_of(tmp_path, text).blocks[0].components == ("D1", "D2", "D3")
    # an exponent of three digits
    text = frd([(1, 1.5, 2, 3, 4, 5, 6)]).replace(number(1.5), " 1.46685-100")
    assert frd_of(tmp_path, text, newline="\r\n").blocks[0].values[0, 0] == 1.46685e-100


ROWS: list[Any] = [(1, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5), (40, 0, 0, 0, 0, 0, 0)]
GOOD = frd(ROWS)
LINE = {line: k for k, line in enumerate(GOOD.splitlines(), start=1)}  # the last of equal lines
ROW = record(1, ROWS[0][1:]).rstrip("\n")
HEAD = next(line for line in LINE if line.startswith("  100C"))


PRINTOUT = """
 forces (fx,fy,fz) for set ALL and time  0.5000000E+00

         1  1.000000E+00 -2.000000E+00  3.000000E+00
         7  0.000000E+00  0.000000E+00  0.000000E+00

 contact stress (slave node,press,tang1,tang2) for all contact elements and time 0.5000000E+00

        12  1.000000E+00  2.000000E+00  3.000000E+00
 statistics for slave set A, master set B and time  0.5000000E+00

   total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)

    1.0 2.0 3.0 0.0 0.0 0.0

   center of gravity and mean normal

    0.0 0.0 0.0 0.0 1.0 0.0
"""


FRD_FAULTS = [
    (number(2.5), "  2.5OOOE+00", LINE[ROW], "a number, found"),
    (ROW, ROW[:-3], LINE[ROW], r"6 numbers of 12 characters, 85 in all, found 82"),
    (ROW, ROW + "E-100", LINE[ROW], "85 in all, found 90"),
    (
        f" -1{40:10d}{number(0)}{number(0)}",
        f" -1{'4O':>10}{number(0)}{number(0)}",
        LINE[ROW] + 1,
        "a node's number",
    ),
    (" -4  CONTACT", " -5  CONTACT", LINE[HEAD] + 1, "the name of a result block"),
    (" -5  CSHEAR2", " -1  CSHEAR2", LINE[HEAD] + 7, "the name of a component"),
    (HEAD, HEAD[:12] + "      second" + HEAD[24:], LINE[HEAD], "the time of a frame"),
    (
        HEAD,
        HEAD[:24] + f"{7:12d}" + HEAD[36:],
        LINE[HEAD],
        "7 records of block CONTACT as announced here, found 2",
    ),
    (HEAD, HEAD[:24] + "            " + HEAD[36:], LINE[HEAD], "the count of records"),
    (f"{4:12d}{'':37}1\n", f"{5:12d}{'':37}1\n", 4, "5 nodes as announced here, found 4"),
    (f"{1:12d}{'':37}1\n", f"{2:12d}{'':37}1\n", 10, "2 elements as announced here, found 1"),
    (
        f" -1{40:10d}{number(0)}{number(1)}",
        f" -1{3:10d}{number(0)}{number(1)}",
        5,
        "every node once",
    ),
    (
        f" -1{40:10d}{number(0)}{number(1)}",
        f" -1{40:10d}{number(np.nan)}{number(1)}",
        5,
        "finite coordinates",
    ),
    (f" -2{1:10d}{2:10d}", f" -2{1:10d}{'':10}", 12, "a node's number"),
    (f" -1{1:10d}{9:5d}", f" -2{1:10d}{9:5d}", 11, "the head of a record"),
    (
        f" -2{1:10d}{2:10d}{3:10d}{40:10d}\n",
        "",
        10,
        "nodes .-2. of every element, found none of element 1",
    ),
    (
        GOOD[GOOD.rindex(" -3") :],
        "",
        28,
        "breaks off after 2 of 2 records of block CONTACT",
    ),
    (f"{4:12d}{'':37}1\n", f"{4:12d}{'':37}3\n", 4, r"the file is binary \(form 3\).*\*NODE FILE"),
    (GOOD, "x,p,q\n0,1,2\n", 0, "no block of nodes"),
]
DAT_FAULTS = [
    ("-2.000000E+00  3", "************* 3", 4, r"a number"),
    (" 0.000000E+00\n", "\n", 5, r"4 numbers \(fx,fy,fz\), found 3"),
    ("        12 ", "       1.2 ", 9, "the number of a node"),
    ("        12 ", "", 9, "4 numbers"),
    ("    1.0 2.0 3.0 0.0", "    1.0 2.0 0.0", 14, "6 numbers"),
    (
        "   center of gravity",
        "   centre of gravity",
        10,
        "'center of gravity and mean normal' below",
    ),
    (
        PRINTOUT[PRINTOUT.index("   center") :],
        "",
        10,
        "'center of gravity and mean normal' below.*breaks off",
    ),
    (PRINTOUT, "nothing\n", 0, "no table of CalculiX in it"),
]


@pytest.mark.parametrize(
    ("name", "good_text", "old", "new", "line", "fact"),
    [
        *(("case.frd", GOOD, *row) for row in FRD_FAULTS),
        *(("case.dat", PRINTOUT, *row) for row in DAT_FAULTS),
    ],
)
def test_a_fault_in_a_file_of_calculix_is_refused_with_its_line(
    tmp_path: Path, name: str, good_text: str, old: str, new: str, line: int, fact: str
) -> None:
    assert old in good_text
    (tmp_path / name).write_text(good_text.replace(old, new, 1))
    with pytest.raises(InputError, match=fact) as caught:
        (
            read_frd(tmp_path / name, ("CONTACT", "DISP"))
            if name == "case.frd"
            else read_dat(tmp_path / name)
        )
    assert (
        "expected" not in str(caught.value)
        or "breaks off" in fact
        or f"{name}: line {line}: expected" in str(caught.value)
    )


def test_of_three_parts_the_one_that_differs_is_named() -> None:
    parts_of_instant = [
        FieldPart(name, np.zeros((2, 3)), (), {"CPRESS": np.zeros(shape)}, {})
        for name, shape in (("a.vtu", (2,)), ("b.vtu", (2,)), ("c.vtu", (2, 3)))
    ]
    with pytest.raises(InputError, match=r"a\.vtu: CPRESS .* components than in c\.vtu"):
        joined_mesh(parts_of_instant)
