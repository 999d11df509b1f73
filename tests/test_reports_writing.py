"""The folder of a report: whole or not at all, strict JSON, a page that needs no network, files of others left alone."""

import csv
import json
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from reports import Report, compare, write
from reports.comparison import Comparison
from reports.comparison.words import value_of
from reports.folder import MANIFEST, claim, default_folder, filled
from reports.page.writing import draw
from scenes import ContactSolution, InputError
from test_reports_synthetic import cattaneo_mindlin, with_fields

TRUTH = cattaneo_mindlin(steps_per_leg=12, points=61)
FIGURES = {
    "bodies",
    "cycle",
    "slip_history",
    "tractions",
    "load_path",
    "hysteresis",
    "half_widths",
    "state_map",
    "dissipation_density",
    "errors",
    "certificates_reference",
    "certificates_result",
}


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    """A result 1 % high in pressure, with an engine's name and a note that a page must escape."""
    result = with_fields(TRUTH, pressure=1.01 * TRUTH.pressure, engine="somebody's <b>code</b>")
    return compare(TRUTH, result, polygon_reference=TRUTH)


@pytest.fixture(scope="module")
def folder(comparison: Comparison, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("report") / "deep" / "out"
    page = write(comparison, out, command="halfplane run 'my scene.toml'", seconds={"finite elements": 1.5})
    assert page == out / "report.html"
    return out


def refuse(word: str) -> None:
    raise AssertionError(f"{word} is not JSON")


def read_json(path: Path) -> dict:
    """Strict: the words NaN and Infinity, which Python's reader takes, are refused."""
    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


def test_everything_is_there(folder: Path) -> None:
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    tables = {f"figures/{name}.csv" for name in FIGURES}
    assert tables <= files
    assert files - tables == {"report.html", "comparison.json", "reference.nc", "result.nc", "scene.json", MANIFEST}
    assert set(read_json(folder / MANIFEST)["files"]) == files


def test_json_holds_the_verdict(folder: Path, comparison: Comparison) -> None:
    stored = read_json(folder / "comparison.json")
    assert stored["verdict"]["passed"] is False
    assert stored["metrics"]["peak_pressure"]["value"] == pytest.approx(0.01)
    assert stored["metrics"]["peak_pressure"]["accurate"] is False
    assert set(stored["metrics"]) == {metric.key for metric in comparison.metrics}
    assert len(stored["metrics"]["shear"]["series"]) == len(stored["instants"])
    assert stored["command"] == "halfplane run 'my scene.toml'"


def test_what_is_not_finite_becomes_null_and_is_said(tmp_path: Path) -> None:
    pressure = TRUTH.pressure.copy()
    pressure[3, 30] = np.nan
    write(compare(TRUTH, with_fields(TRUTH, pressure=pressure, dissipation=np.inf)), tmp_path / "out")
    stored = read_json(tmp_path / "out" / "comparison.json")
    for key in ("pressure", "dissipation"):
        assert stored["metrics"][key]["value"] is None
        assert stored["metrics"][key]["finite"] is False
        assert stored["metrics"][key]["accurate"] is False
    assert stored["metrics"]["shear"]["finite"] is True


def test_solutions_and_scene_can_be_read_back(folder: Path) -> None:
    stored = ContactSolution.load(folder / "reference.nc")
    assert np.array_equal(stored.shear, TRUTH.shear)
    assert compare(stored, TRUTH).passed
    assert (folder / "scene.json").read_text(encoding="utf-8").startswith("{")


def test_tables_hold_what_the_figures_draw(folder: Path, comparison: Comparison) -> None:
    for drawing in draw(Report(comparison)):
        with (folder / "figures" / f"{drawing.name}.csv").open(encoding="utf-8", newline="") as stream:
            rows = list(csv.DictReader(stream))
        assert list(rows[0]) == list(drawing.table)
        for name, column in drawing.table.items():
            if not isinstance(column[0], str):
                found = [float(row[name]) if row[name] else np.nan for row in rows]
                assert np.array_equal(found, np.asarray(column, dtype=float), equal_nan=True), name


def test_state_map_table_keeps_the_states(folder: Path) -> None:
    with (folder / "figures" / "state_map.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    heading = "state_reference (0 open, 1 stick, 2 forward slip, 3 reverse slip)"
    stored = np.array([int(row[heading]) for row in rows]).reshape(len(TRUTH.time), -1)
    inside = np.abs(TRUTH.x) <= 1.12
    assert np.array_equal(stored, TRUTH.state[:, inside])


def test_the_map_of_states_and_the_table_say_one_share() -> None:
    sticks = np.where((TRUTH.state > 1) & (TRUTH.x > 0), 1, TRUTH.state).astype(TRUTH.state.dtype)
    found = compare(TRUTH, with_fields(TRUTH, state=sticks), polygon_reference=TRUTH)
    assert found.metric("state").value
    captions = {plate.name: plate.caption for plate in draw(Report(found))}
    assert f" They differ over {value_of(found.metric('state'))} of the length in contact" in captions["state_map"]


class Tags(HTMLParser):
    """Every tag with its attributes, and the text."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.text.append(data)


@pytest.fixture(scope="module")
def page(folder: Path) -> Tags:
    tags = Tags()
    tags.feed((folder / "report.html").read_text(encoding="utf-8"))
    return tags


def addresses(page: Tags) -> Iterator[str]:
    for _, attributes in page.found:
        for name in ("src", "href", "action", "data", "poster", "srcset"):
            if value := attributes.get(name):
                yield value


def test_page_needs_no_network(page: Tags, folder: Path) -> None:
    """Figures are inside; every other address is a file of the folder or a place on the page."""
    places = {attributes["id"] for _, attributes in page.found if "id" in attributes}
    for address in addresses(page):
        if address.startswith("#"):
            assert address[1:] in places
        elif not address.startswith("data:image/png;base64,"):
            assert (folder / address).is_file(), address
    assert not {tag for tag, _ in page.found} & {"link", "iframe", "object", "embed"}
    assert len([tag for tag, _ in page.found if tag == "script"]) == 2  # the data and the page's own
    assert "@import" not in (folder / "report.html").read_text(encoding="utf-8")
    assert (folder / "report.html").stat().st_size < 8e6


def test_page_says_what_it_is_and_is_not(page: Tags) -> None:
    text = " ".join(" ".join(page.text).split())
    assert "two codes agreeing is not validation" in text
    assert "Not within tolerance." in text
    assert "halfplane run 'my scene.toml'" in text
    assert "not assessed" in text
    for heading in ("Through the cycle", "Stick and slip", "Dissipation of a cycle", "Admissible", "Work"):
        assert any(heading in part for part in page.text)


def test_page_has_every_figure_with_words_for_it(page: Tags) -> None:
    figures = [attributes for tag, attributes in page.found if tag == "figure"]
    assert len(figures) == len(FIGURES)
    panels = [attributes for tag, attributes in page.found if tag == "svg" and attributes.get("role") == "img"]
    assert len(panels) > len(FIGURES)
    assert all(attributes["aria-label"] for attributes in (*figures, *panels))
    identities = [attributes["id"] for _, attributes in page.found if "id" in attributes]
    assert len(identities) == len(set(identities))


def test_words_from_outside_are_escaped(page: Tags, folder: Path) -> None:
    assert "b" not in {tag for tag, attributes in page.found if tag == "code"}
    assert "<b>code</b>" not in (folder / "report.html").read_text(encoding="utf-8")
    assert any("<b>code</b>" in part for part in page.text)


def test_figures_are_the_same_for_the_same_data(comparison: Comparison) -> None:
    first, second = (draw(Report(comparison))[0].svg() for _ in range(2))
    assert first == second


def fill(out: Path, text: str, error: BaseException | None = None, name: str = "report.html") -> None:
    """Write a page (and `name`), then fail with `error`."""
    with filled(out) as folder:
        (folder / "report.html").write_text(text)
        (folder / name).write_text(text)
        if error:
            raise error


class TestFolder:
    """Whole or not at all."""

    def names(self, folder: Path) -> set[str]:
        return {path.name for path in folder.iterdir()}

    def test_nothing_is_left_after_an_error(self, tmp_path: Path) -> None:
        with pytest.raises(RuntimeError, match="half-way"):
            fill(tmp_path / "out", "half", RuntimeError("half-way"))
        assert self.names(tmp_path) == set()

    def test_an_error_leaves_the_earlier_report_alone(self, tmp_path: Path) -> None:
        with filled(tmp_path / "out") as folder:
            (folder / "report.html").write_text("first")
        with pytest.raises(KeyboardInterrupt):
            fill(tmp_path / "out", "second", KeyboardInterrupt())
        assert (tmp_path / "out" / "report.html").read_text() == "first"
        assert self.names(tmp_path) == {"out"}

    def test_own_files_are_replaced_and_stale_ones_removed(self, tmp_path: Path) -> None:
        with filled(tmp_path / "out") as folder:
            (folder / "report.html").write_text("first")
            (folder / "fields").mkdir()
            (folder / "fields" / "old.vtu").write_text("old")
        (tmp_path / "out" / "mine.txt").write_text("kept")
        with filled(tmp_path / "out") as folder:
            (folder / "report.html").write_text("second")
        assert (tmp_path / "out" / "report.html").read_text() == "second"
        assert self.names(tmp_path / "out") == {"report.html", "mine.txt", MANIFEST}

    def test_a_lesser_run_keeps_the_report(self, tmp_path: Path) -> None:
        with filled(tmp_path / "out") as folder:
            (folder / "report.html").write_text("first")
        with filled(tmp_path / "out", fresh=()) as folder:
            (folder / "semi_analytic.nc").write_text("alone")
        assert self.names(tmp_path / "out") == {"report.html", "semi_analytic.nc", MANIFEST}
        with filled(tmp_path / "out") as folder:
            (folder / "report.html").write_text("third")
        assert self.names(tmp_path / "out") == {"report.html", MANIFEST}

    @pytest.mark.parametrize("name", ["report.html", "scene.json", "manifest.json"])
    def test_files_of_others_are_never_replaced(self, tmp_path: Path, name: str) -> None:
        (tmp_path / name).write_text("mine")
        with pytest.raises(InputError, match=f"{name} is there already"):
            claim(tmp_path)
        assert self.names(tmp_path) == {name}

    def test_a_name_that_only_the_writer_knows_is_not_replaced_either(self, tmp_path: Path) -> None:
        (tmp_path / "odd.csv").write_text("mine")
        with pytest.raises(InputError, match=r"odd\.csv is there already"):
            fill(tmp_path, "ours", name="odd.csv")
        assert (tmp_path / "odd.csv").read_text() == "mine"
        assert self.names(tmp_path) == {"odd.csv"}

    def test_a_manifest_can_not_reach_outside(self, tmp_path: Path) -> None:
        (tmp_path / "precious.txt").write_text("precious")
        out = tmp_path / "out"
        out.mkdir()
        listed = ["../precious.txt", str(tmp_path / "precious.txt"), MANIFEST]
        (out / MANIFEST).write_text(json.dumps({"written by": "halfplane", "files": listed}))
        with filled(out) as folder:
            (folder / "report.html").write_text("new")
        assert (tmp_path / "precious.txt").read_text() == "precious"

    @pytest.mark.parametrize("place", ["file", "file/below", "/proc/halfplane"])
    def test_a_folder_that_can_not_be_made_is_refused(self, tmp_path: Path, place: str) -> None:
        (tmp_path / "file").write_text("a file")
        with pytest.raises(InputError, match=r"--out .*(is a file|can't be written to)"):
            claim(tmp_path / place)
        assert self.names(tmp_path) == {"file"}

    def test_nothing_is_made_by_claiming(self, tmp_path: Path) -> None:
        assert claim(tmp_path / "a" / "b") == tmp_path / "a" / "b"
        assert self.names(tmp_path) == set()

    def test_default_folder_stays_in_out(self) -> None:
        for name in ("../../etc", "/abs", "..", "", "a b/c"):
            folder = default_folder(name)
            assert folder.parent == Path("out")
            assert folder.name not in ("", ".", "..")
