"""The cycle as a film and as a series: instants, what the exaggeration keeps true, GIF and MP4 as they are read back."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence

from halfplane_fe import FiniteElementSolution
from problems import COARSE, FEW_STEPS, fe_run
from reports import film
from reports.animation import close_ups, frames_of
from reports.animation_stage import CloseUps, colours, places
from reports.cli import main
from reports.cli.field_output import FieldsOptions, require_series, series_of, shortfall, snapshots_of
from scenes import InputError, load_scene
from test_cli_commands import everything, refused
from test_reports_fields import ROUGH, blocks

KINDS = ["half-planes", "true faces"]
FRAMES = 4


def answer_of(kind: str) -> FiniteElementSolution:
    return fe_run(load_scene("cattaneo-mindlin") if kind == "half-planes" else blocks(), COARSE, FEW_STEPS)


def shots_of(answer: FiniteElementSolution) -> CloseUps:
    return close_ups(answer, snapshots_of(answer, series_of(answer, None, FRAMES)))


@pytest.fixture(scope="module")
def frames() -> list[np.ndarray]:
    answer = answer_of("half-planes")
    return list(frames_of(answer, shots_of(answer)))


class TestSeries:
    def test_frames_lie_evenly_in_the_last_cycle_and_its_end_is_its_start(self) -> None:
        answer = answer_of("half-planes")
        cycle = answer.time[answer.last_cycle]
        found = [instant.time for instant in series_of(answer, None, 8)]
        assert set(found) <= set(cycle[:-1])
        wanted = np.linspace(cycle[0], cycle[-1], 9)[:-1]
        assert np.abs(np.array(found) - wanted).max() <= np.diff(cycle).max() / 2 + 1e-12

    def test_every_step_or_every_third(self) -> None:
        answer = answer_of("half-planes")
        cycle = answer.time[answer.last_cycle]
        assert [instant.time for instant in series_of(answer, 1, None)] == cycle[:-1].tolist()
        assert [instant.time for instant in series_of(answer, 3, None)] == cycle[:-1:3].tolist()

    def test_more_frames_than_steps_are_told(self) -> None:
        answer = answer_of("half-planes")
        found = series_of(answer, None, 1000)
        assert len({one.time for one in found}) == len(found) < len(answer.last_cycle)
        assert f"{len(found)} instants instead of 1000" in shortfall(1000, len(found))
        assert shortfall(len(found), len(found)) == ""

    @pytest.mark.parametrize(
        ("every", "frames", "sentence"), [(1, 9, "leave one"), (0, None, "--every 0"), (None, 1, "--frames 1")]
    )
    def test_what_makes_no_series_is_refused(self, every: int | None, frames: int | None, sentence: str) -> None:
        with pytest.raises(InputError, match=sentence):
            require_series(every, frames)

    def test_stills_are_drawn_only_where_instants_are_named(self) -> None:
        assert FieldsOptions().named == ("events",)
        assert FieldsOptions(frames=5).named == ()
        assert FieldsOptions(at=("2",), frames=5).named == ("2",)
        assert FieldsOptions(animate=True).named == ("events",)


@pytest.mark.parametrize("kind", KINDS)
def test_exaggerated_faces_touch_where_they_do_and_nowhere_else(kind: str) -> None:
    """Gap and displacements share one factor: the drawn gap is that factor times the true one, so 0 under pressure."""
    answer = answer_of(kind)
    shots = shots_of(answer)
    assert shots.factor > 1
    for view in shots.views:
        lower, upper = (places(body, moved, shots)[body.face] for body, moved in zip(shots.bodies, view.displacement, strict=True))
        own = [body.points[body.face, 0] for body in shots.bodies]
        x = answer.x
        drawn = np.interp(x, own[1], upper[:, 1]) - np.interp(x, own[0], lower[:, 1])
        carries = answer.pressure[view.step] > 1e-3 * answer.pressure[view.step].max()
        size = np.ptp(np.interp(x, own[1], shots.bodies[1].shape[shots.bodies[1].face])) * shots.factor
        assert np.abs(drawn[carries]).max() < 0.02 * size
        assert drawn[[0, -1]].min() > 0.1 * size


def test_scales_hold_for_every_instant() -> None:
    """The largest values of the colour scales are those of all instants; no colour is clipped."""
    shots = shots_of(answer_of("half-planes"))
    assert shots.largest[0] == max(values.max() for view in shots.views for values in view.von_mises)
    assert shots.largest[1] == max(np.abs(values).max() for view in shots.views for values in view.shear)


def test_frames_differ_only_where_something_moves(frames: list[np.ndarray]) -> None:
    """And what does not, the title and the axes' words, is the same to the pixel."""
    assert [frame.shape for frame in frames] == [(720, 1280, 3)] * FRAMES
    for frame in frames[1:]:
        assert (frame != frames[0]).any(axis=2).mean() > 0.02
        np.testing.assert_array_equal(frame[:50], frames[0][:50])
        np.testing.assert_array_equal(frame[-40:], frames[0][-40:])


def test_gif_is_read_back_with_all_frames_in_their_colours(frames: list[np.ndarray], tmp_path: Path) -> None:
    found = film.write_film(frames, colours(), tmp_path, "cycle")
    assert found.size == (1280, 720)
    assert (tmp_path / "cycle.gif").stat().st_size < film.LARGEST_GIF
    with Image.open(tmp_path / "cycle.gif") as picture:
        assert (picture.n_frames, picture.size, picture.info["loop"]) == (FRAMES, (1280, 720), 0)
        shown = [np.asarray(each.convert("RGB")).astype(int) for each in ImageSequence.Iterator(picture)]
    for k, (seen, frame) in enumerate(zip(shown, frames, strict=True)):
        assert np.abs(seen - frame).mean() < 4
        assert (seen[:10] == 255).all()
        if k:
            assert (seen != shown[k - 1]).any()


def test_a_large_gif_is_made_smaller_and_that_is_told(
    frames: list[np.ndarray], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(film, "LARGEST_GIF", 150_000)
    monkeypatch.setitem(sys.modules, "imageio", None)
    found = film.write_film(frames, colours(), tmp_path, "cycle")
    assert (tmp_path / "cycle.gif").stat().st_size <= 150_000
    with Image.open(tmp_path / "cycle.gif") as picture:
        assert picture.size == found.size < (1280, 720)
    assert f"{found.size[0]} x {found.size[1]} pixels instead of 1280 x 720" in found.notes[-1]


def test_a_gif_that_is_too_large_at_every_size_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At a width of two pixels three quarters of it were two again, for ever."""
    monkeypatch.setattr(film, "LARGEST_GIF", 10)
    monkeypatch.setitem(sys.modules, "imageio", None)
    written, calls = film._write_gif, []

    def counted(*arguments: object) -> int:
        calls.append(arguments)
        assert len(calls) < 100, "a loop without end"
        return written(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(film, "_write_gif", counted)
    with pytest.raises(InputError, match=r"cycle\.gif: 2 frames take more than 8 MB at every size"):
        film.write_film([np.full((40, 60, 3), 255, dtype=np.uint8)] * 2, colours(), tmp_path, "cycle")


def test_without_ffmpeg_there_is_a_gif_and_a_sentence(
    frames: list[np.ndarray], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio", None)
    found = film.write_film(frames, colours(), tmp_path, "cycle")
    assert found.files == ["cycle.gif"]
    assert "pip install halfplane[animation]" in found.notes[0]
    assert {path.name for path in tmp_path.iterdir()} == {"cycle.gif"}


def test_mp4_is_read_back(frames: list[np.ndarray], tmp_path: Path) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="the extra halfplane[animation] is not installed")
    pytest.importorskip("imageio", reason="the extra halfplane[animation] is not installed")
    assert film.write_film(frames, colours(), tmp_path, "cycle").files == ["cycle.gif", "cycle.mp4"]
    command = [ffmpeg.get_ffmpeg_exe(), "-i", str(tmp_path / "cycle.mp4"), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run(command, capture_output=True, check=True)
    stream = next(line for line in done.stderr.decode().splitlines() if "Video: h264" in line)
    assert "yuv420p" in stream
    assert "1280x720, " in stream
    assert f" {film.RATE} fps" in stream
    shown = np.frombuffer(done.stdout, dtype=np.uint8).reshape(-1, 720, 1280, 3).astype(int)
    assert max(np.abs(seen - frame).mean() for seen, frame in zip(shown, frames, strict=True)) < 3


class TestCommand:
    def test_a_series_and_its_film(self, tmp_path: Path) -> None:
        out = tmp_path / "out"
        arguments = ["fields", "cattaneo-mindlin", "--frames", "3", "--animate", "--out", str(out), "--quiet", *ROUGH]
        assert main(arguments) == 0
        assert sorted(path.name for path in (out / "fields").glob("contact_*")) == [f"contact_00{k}.vtu" for k in range(3)]
        assert not (out / "pictures").exists()
        with Image.open(out / "animation" / "cycle.gif") as picture:
            assert picture.n_frames == 3

    def test_interrupted_while_frames_are_drawn_it_leaves_nothing(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        """At the second frame, with the MP4 open and the field files written."""
        drawn = []

        def draw(*arguments: object) -> None:
            drawn.append(arguments)
            if len(drawn) == 2:
                raise KeyboardInterrupt

        monkeypatch.setattr("reports.animation_stage.draw", draw)
        monkeypatch.chdir(tmp_path)
        assert main(["fields", "cattaneo-mindlin", "--frames", "3", "--animate", "--quiet", *ROUGH]) == 130
        assert len(drawn) == 2
        assert everything(tmp_path) == set()

    def test_refused_before_anything_is_solved(self, tmp_path: Path) -> None:
        assert "--frames 1: a series has 2 instants" in refused(tmp_path, "fields", "cattaneo-mindlin", "--frames", "1")
        assert "leave one of the two out" in refused(tmp_path, "fields", "cattaneo-mindlin", "--frames", "9", "--every", "2")
