"""Huge files and absurd meshes: refused with the limit named, before the memory is taken, in a process that has little of it."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tomllib
import tracemalloc
import zlib
from base64 import b64encode
from pathlib import Path

import h5py
import numpy as np
import pytest

from fuzzing import DOORS, outcome
from halfplane_fe import SolverSettings
from meshes import MeshSettings, SurfaceGrading, foreign, half_disc, read_frames
from meshes.bodies import body_nodes, check_count, contact_nodes
from reports.cli import findings
from reports.scoring.against import own_solution
from scenes import InputError, load_scene, scene_text
from scenes.files import parsed_toml
from score_results import exact
from test_cli_commands import environment

# Files of our own that no user names: their doors take them for lost and go on.
OWN = ("stored.json", "sweep.json", "manifest.json")
ROOM = 3 * 2**30  # bytes of address space, libraries included: VTK, gmsh and BLAS reserve one and a half


def limited(folder: Path, *arguments: str, room: int = ROOM) -> str:
    """The sentence of a command that must be refused though it may take no more than `room` of memory."""

    def little() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (room, room))

    command = [sys.executable, "-m", "reports", *arguments]
    done = subprocess.run(
        command, cwd=folder, env=environment(), capture_output=True, text=True, timeout=120, check=False, preexec_fn=little
    )
    assert done.returncode == 2, done
    assert "Traceback" not in done.stderr
    sentences = [line for line in done.stderr.splitlines() if line.startswith("halfplane: ")]
    assert len(sentences) == 1, done.stderr
    return sentences[0]


def huge(path: Path, size: int) -> None:
    """A file that takes no room on the disk."""
    path.touch()
    os.truncate(path, size)


LIMITS = {
    ".toml": "1.05 MB",
    ".json": "268 MB",
    ".csv": "268 MB",
    ".frd": "537 MB",
    ".dat": "537 MB",
    ".nc": "2.15 GB",
} | dict.fromkeys((".vtu", ".vtk", ".pvd", ".series", ".xdmf"), "537 MB")


@pytest.mark.parametrize("name", [name for name in DOORS if Path(name).suffix in LIMITS and name not in OWN])
def test_a_file_beyond_the_limit_is_refused(name: str, tmp_path: Path) -> None:
    path, limit = tmp_path / name, LIMITS[Path(name).suffix]
    huge(path, 3 * 10**9 if name.endswith(".nc") else 10**9)
    sentence = outcome(DOORS[name], path)
    assert name in sentence
    assert f"at most {limit} are read" in sentence


DOTS = "a." * 6000 + "b"
NESTED = {
    "a key": f"{DOTS} = 1\n",
    "a key in quotes": DOTS.replace("a", "'a'").replace("b", '"b"') + " = 1\n",
    "a key with blanks": DOTS.replace(".", " . ") + " = 1\n",
    "the head of a table": f"[{DOTS}]\n",
    "the head of a list of tables": f"[[{DOTS}]]\n",
    "an inline table": f"x = {{ {DOTS} = 1 }}\n",
    "tables in tables": "x = " + "{a = " * 6000,
    "behind words": f'r = "\'\'\'"\ns = \'"""\'\nt = """\\"""\n# \'\'\'\n""""\n{DOTS} = 1\n',
}


@pytest.mark.parametrize("text", NESTED.values(), ids=NESTED)
@pytest.mark.parametrize("name", [name for name in DOORS if name.endswith(".toml")])
def test_toml_is_bounded_before_it_is_parsed(name: str, text: str, tmp_path: Path) -> None:
    """The parser takes memory with the square of the dots: 150 MB for each of these, 2 GB for 45 kB."""
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    tracemalloc.start()
    try:
        sentence = outcome(DOORS[name], path)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert "not valid TOML: Tables nested deeper than 8 (at line" in sentence
    assert peak < 2e7


def test_forty_five_kilobytes_of_dots_take_no_gigabytes(tmp_path: Path) -> None:
    (tmp_path / "deep.toml").write_text("a." * 22_500 + "a = 1\n", encoding="utf-8")
    assert "Tables nested deeper than 8" in limited(tmp_path, "check", "deep.toml")


@pytest.mark.parametrize(
    "text",
    [
        f"# {DOTS}\ns = '{DOTS} = 1'\n",
        f's = "\\"{DOTS} = 1"\n',
        f's = """\\""""\nt = """\n{DOTS} = 1\n[{DOTS}]\n"""""\nu = 1\n',
        f"s = ''''\n{DOTS} = 1\n'''''\n",
        "a.b.c.d.e.f.g.h = [[1.5, -2.5e-3], [0.25, 1e5]] # 1.2.3.4.5.6.7.8.9\n",
        "[[a.'b.b'.c]]\nd = [{e = {f = [1979-05-27T07:32:00.5Z]}}]\n",
        "".join(f"k{number} = 1\n" for number in range(10_000)),
        "rows = [" + "[0.5, 1.5],\n" * 20_000 + "]\n",
    ],
)
def test_what_is_not_nested_is_read(text: str) -> None:
    assert parsed_toml(text) == tomllib.loads(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("".join(f"k{number} = 1\n" for number in range(10_001)), r"More than 10,000 keys \(at line 10001, column 8\)"),
        ("".join(f"[k{number}]\n" for number in range(10_001)), r"More than 10,000 keys \(at line 10001, column 1\)"),
        ("a = 1\ncycles = 0x" + "f" * 5000, r"A key or a number of 250 characters or more \(at line 2, column 10\)"),
    ],
)
def test_keys_and_numbers_have_an_end(text: str, said: str) -> None:
    """A hexadecimal number of any length was read, and no JSON could be written of it."""
    with pytest.raises(ValueError, match=said):
        parsed_toml(text)


def test_a_gigabyte_is_refused_where_there_is_little_memory(tmp_path: Path) -> None:
    huge(tmp_path / "a.csv", 10**9)
    assert "at most 268 MB are read" in limited(tmp_path, "score", "a.csv", "--scene", "hertz-paper")


def scene_with_table(folder: Path, name: str) -> Path:
    path = folder / "scene.toml"
    path.write_text(scene_text("time-series").replace("time-series.csv", name), encoding="utf-8")
    return path


def test_ten_million_rows_are_refused_in_both_places(tmp_path: Path) -> None:
    (tmp_path / "many.csv").write_bytes(b"1,2,3\n" * 10**7)
    with pytest.raises(InputError, match="more than 2,000,000 lines"):
        load_scene(scene_with_table(tmp_path, "many.csv"))
    assert "more than 2,000,000 lines" in limited(tmp_path, "score", "many.csv", "--scene", "hertz-paper")


def test_a_table_of_one_line_without_end_is_refused(tmp_path: Path) -> None:
    (tmp_path / "long.csv").write_bytes(b"1," * 10**7)
    with pytest.raises(InputError, match="line 1: more than 100,000 characters are no row"):
        load_scene(scene_with_table(tmp_path, "long.csv"))


@pytest.mark.parametrize("device", ["/dev/zero", "a pipe"])
def test_devices_and_pipes_are_refused_at_once(device: str, tmp_path: Path) -> None:
    path = tmp_path / "pipe.toml"
    if device == "a pipe":
        os.mkfifo(path)
    else:
        path.symlink_to(device)
    with pytest.raises(InputError, match="no regular file but a pipe or a device"):
        load_scene(path)
    with pytest.raises(InputError, match="no regular file but a pipe or a device"):
        load_scene(scene_with_table(tmp_path, path.name))


def bomb(path: Path, shape: tuple[int, int]) -> Path:
    """An answer of ours in which one array says that it is enormous, and takes a few kilobytes packed."""
    exact(steps=3, points=5).save(path)
    with h5py.File(path, "a") as file:
        del file["pressure"]
        file.create_dataset("pressure", shape, "f8", chunks=(1, 2**17), compression="gzip", fillvalue=0.0)
        for axis, name in enumerate(("time", "x")):
            file["pressure"].dims[axis].label = name
    assert path.stat().st_size < 10**6
    return path


def test_an_answer_that_unpacks_to_terabytes_is_refused(tmp_path: Path) -> None:
    path = bomb(tmp_path / "bomb.nc", (2**20, 2**20))
    with pytest.raises(InputError, match=r"takes 8.8e\+03 GB once unpacked, and at most 2\.15 GB are read"):
        own_solution(path, load_scene("hertz-paper"))
    limited(tmp_path, "score", "bomb.nc", "--scene", "hertz-paper")


def compressed_vtu(path: Path, blocks: int) -> None:
    """Points of `blocks` times 17 MB of zeros, as VTK packs them: 1,000 to 1."""
    size = 2**24
    packed = zlib.compress(bytes(size), 9)
    head = np.array([blocks, size, size, *([len(packed)] * blocks)], np.uint32).tobytes()
    text = (b64encode(head) + b64encode(packed * blocks)).decode()
    path.write_text(
        '<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian" '
        'compressor="vtkZLibDataCompressor"><UnstructuredGrid><Piece NumberOfPoints="100" NumberOfCells="1"><Points>'
        f'<DataArray type="Float64" Name="Points" NumberOfComponents="3" format="binary">{text}</DataArray></Points>'
        "</Piece></UnstructuredGrid></VTKFile>",
        encoding="utf-8",
    )


def test_a_field_file_that_unpacks_to_gigabytes_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compressed_vtu(tmp_path / "bomb.vtu", 160)  # 2.7 GB in 4 MB
    assert (tmp_path / "bomb.vtu").stat().st_size < 5 * 10**6
    monkeypatch.setattr(foreign, "UNPACKED", 2**27)  # the time goes with what is unpacked before the limit is met
    with pytest.raises(InputError, match=r"unpacked it takes more than 134 MB of memory, which is the limit"):
        read_frames(tmp_path / "bomb.vtu")


BILLION = "<?xml version='1.0'?><!DOCTYPE a [<!ENTITY a0 'lol'>{}]><VTKFile>&a9;</VTKFile>".format(
    "".join(f"<!ENTITY a{k} '{f'&a{k - 1};' * 10}'>" for k in range(1, 10))
)


@pytest.mark.parametrize("suffix", [".vtu", ".pvd", ".xdmf"])
def test_entities_that_grow_by_themselves_are_refused(suffix: str, tmp_path: Path) -> None:
    (tmp_path / f"lol{suffix}").write_text(BILLION)
    with pytest.raises(InputError, match="broken off or of another form"):
        read_frames(tmp_path / f"lol{suffix}")


@pytest.mark.parametrize(
    ("options", "rule"),
    [
        (("--element-size", "1e-4", "--edge-element-size", "1e-4"), "nodes on its contact, and the limit is 8,000"),
        (("--edge-element-size", "5e-4", "--growth", "0.02", "--far-radius", "1000"), "nodes, and the limit is 500,000"),
    ],
)
def test_absurd_meshes_are_refused(options: tuple[str, ...], rule: str, tmp_path: Path) -> None:
    assert rule in limited(tmp_path, "fe", "hertz-paper", "--quiet", *options)


def test_absurd_settings_are_refused() -> None:
    with pytest.raises(InputError, match=r"element_size = 1e-09 is refused: it lies in \[0.0001, 0.25\]"):
        MeshSettings(element_size=1e-9)
    with pytest.raises(InputError, match=r"it lies in \[4, 100000\]"):
        SolverSettings(steps_per_cycle=10**9)


GRADINGS: dict[str, tuple[SurfaceGrading, float, int]] = {
    "default": (SurfaceGrading(0.7, 1.06, 1 / 24, 1 / 160, 10.0), 0.2, 2),
    "no inner part": (SurfaceGrading(0.0, 1.06, 1 / 24, 1 / 40, 10.0), 0.2, 2),
    "far and slow growth": (SurfaceGrading(0.7, 1.06, 1 / 24, 1 / 80, 300.0), 0.06, 1),
}


@pytest.mark.parametrize("name", GRADINGS)
def test_the_count_taken_before_meshing_is_right(name: str) -> None:
    """Within a factor of 1.5 (measured: 0.83 to 1.33)."""
    grading, growth, order = GRADINGS[name]
    mesh = half_disc("lower", grading, growth, order).mesh
    assert 1 / 1.5 < body_nodes(grading, growth, order) / mesh.p.shape[1] < 1.5
    on_contact = (len(mesh.boundaries["contact"])) * order + 1
    assert abs(contact_nodes(grading, order) - on_contact) <= 4


def test_the_finest_of_the_project_are_not_refused() -> None:
    for mesh in (MeshSettings.fine(), MeshSettings(edge_element_size=1 / 1280), MeshSettings(far_radius=1000.0)):
        check_count("lower", SurfaceGrading(0.7, 1.06, mesh.element_size, mesh.edge_element_size, mesh.far_radius), mesh.growth, 2)


def test_the_limit_on_memory_is_lifted_again(tmp_path: Path) -> None:
    from scenes.files import within_memory

    before = resource.getrlimit(resource.RLIMIT_AS)
    with pytest.raises(InputError, match="takes more than 1 MB"), within_memory(tmp_path, 10**6):
        np.ones(10**8)
    assert resource.getrlimit(resource.RLIMIT_AS) == before
    assert np.ones(10**6).sum() == 10**6


@pytest.mark.parametrize("number", ["1" + 400 * "0", "-1" + 400 * "0"])
def test_a_whole_number_beyond_every_float_is_a_fault_of_the_file(number: str, tmp_path: Path) -> None:
    """JSON has whole numbers without end, and Python reads them: it was an OverflowError where one was used."""
    (tmp_path / "baseline.json").write_text(f'{{"format": "halfplane baseline 1", "tolerances": {{"metric.peak": {number}}}}}')
    with pytest.raises(InputError, match=rf"it holds a whole number of {len(number)} digits"):
        findings.read_findings(tmp_path / "baseline.json")
