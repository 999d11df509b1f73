"""The page in a real browser: quiet, offline, moved by one slider and by keys, nothing over anything else, at every size."""

import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import halfplane_fe
import semi_analytic
from problems import COARSE, FEW_STEPS
from reports import Comparison, compare, write
from scenes import Scene, load_scene
from test_reports_synthetic import cattaneo_mindlin, with_fields

sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: pip install -e .[browser]")
CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine: apt-get install chromium")

NASTY = "</script><script>window.pwned = 1</script><img src=x onerror='window.pwned = 2'>\"'&"
DESKTOP: dict[str, Any] = {"viewport": {"width": 1280, "height": 900}}
PHONE: dict[str, Any] = {"viewport": {"width": 390, "height": 844}, "device_scale_factor": 2, "is_mobile": True, "has_touch": True}
SIZES = {"desktop": DESKTOP, "dark": DESKTOP | {"color_scheme": "dark"}, "phone": PHONE}


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A page of half-planes whose every word from outside is an attack, and one of real bodies with meshes."""
    bodies = {"lower": {"kind": "block", "width": 20.0, "height": 12.0}, "upper": {"kind": "pad", "width": 10.0, "height": 8.0}}
    real = Scene.model_validate(load_scene("cattaneo-mindlin").model_dump() | {"bodies": bodies})
    fe = halfplane_fe.solve(real, COARSE, FEW_STEPS)
    pages = {"nasty": nasty(), "bodies": compare(semi_analytic.solve(real, x=fe.x, time=fe.time), fe)}
    found = {}
    for name, comparison in pages.items():
        out = tmp_path_factory.mktemp("page") / name
        write(comparison, out, command=f"halfplane run {NASTY}", seconds={NASTY: 1.5})
        found[name] = out
    return found


def nasty() -> Comparison:
    truth = cattaneo_mindlin(steps_per_leg=12, points=61)
    words = dict.fromkeys(("name", "title", "purpose", "source"), NASTY)
    scene = truth.scene.vary(**(words | {"units": f"{NASTY.replace(',', '')}, {NASTY}, MPa"}))
    truth = replace(truth, scene=scene)
    result = with_fields(truth, pressure=1.01 * truth.pressure, shear=0.99 * truth.shear, slip=truth.slip + 1e-4, engine=NASTY)
    return compare(truth, result, polygon_reference=truth)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with sync_api.sync_playwright() as play:
        started = play.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"])
        yield started
        started.close()


@pytest.fixture
def visit(browser: Any, folders: dict[str, Path]) -> Iterator[Callable[..., Any]]:
    """Opens a page; at the end nothing may have been said on the console and nothing asked of any network."""
    opened, heard, asked = [], [], []

    def open_page(name: str, **options: Any) -> Any:
        context = browser.new_context(**(DESKTOP | options))
        page = context.new_page()
        page.on("console", lambda message: heard.append(message.text))
        page.on("pageerror", lambda error: heard.append(str(error)))
        page.on("request", lambda request: asked.append(request.url))
        page.goto(f"file://{folders[name]}/report.html")
        opened.append(context)
        return page

    yield open_page
    for context in opened:
        context.close()
    assert heard == []
    assert [url for url in asked if not url.startswith(("file://", "data:", "blob:"))] == []
    assert [url for url in asked if url.startswith("file://") and not url.endswith("report.html")] == []


# What the slider moves, as text: lines, strips, rings, cursors.
MOVING = """() => ({
  lines: [...document.querySelectorAll("path[data-field]")].map((e) => e.getAttribute("d")),
  strips: [...document.querySelectorAll("g.strip")].map((e) => e.innerHTML),
  rings: [...document.querySelectorAll("circle.follow")].map((e) => e.getAttribute("cx") + " " + e.getAttribute("cy")),
  cursors: [...document.querySelectorAll("line.cursor")].map((e) => ["x1", "y1"].map((n) => e.getAttribute(n)).join(" ")),
})"""
# Figures without a single mark that has a size.
EMPTY = """() => [...document.querySelectorAll("figure")].filter((figure) => ![...figure.querySelectorAll(
  "svg:not(.legend svg) :is(.marks *, .body, .strip rect)")].some((mark) => {
    const box = mark.getBoundingClientRect(); return box.width > 1 || box.height > 1; })).map((figure) => figure.id)"""
# Pairs of texts of one drawing of which more than a hair's breadth lies over another.
OVERLAPS = """() => [...document.querySelectorAll("svg.panel, svg.sketch")].flatMap((svg) => {
  const texts = [...svg.querySelectorAll("text")].map((e) => [e.textContent, e.getBoundingClientRect()]);
  return texts.flatMap(([a, p], k) => texts.slice(k + 1).filter(([, q]) =>
    Math.min(p.right, q.right) - Math.max(p.left, q.left) > 1.5 && Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top) > 3
  ).map(([b]) => `${svg.id}: ${a} / ${b}`)); })"""
CUT_OFF = """() => [...document.querySelectorAll("svg.panel, svg.sketch")].flatMap((svg) => {
  const box = svg.getBoundingClientRect();
  return [...svg.querySelectorAll("text")].filter((e) => { const t = e.getBoundingClientRect();
    return t.left < box.left - 1 || t.right > box.right + 1 || t.top < box.top - 1 || t.bottom > box.bottom + 1;
  }).map((e) => `${svg.id || "sketch"}: ${e.textContent}`); })"""


@pytest.mark.parametrize("size", SIZES)
def test_every_figure_is_drawn_and_nothing_is_cut_off(visit: Callable[..., Any], tmp_path: Path, size: str) -> None:
    page = visit("bodies", **SIZES[size])
    assert page.evaluate(EMPTY) == []
    assert page.evaluate(OVERLAPS) == []
    assert page.evaluate(CUT_OFF) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= SIZES[size]["viewport"]["width"]
    picture = page.screenshot(path=tmp_path / f"{size}.png")
    assert len(picture) > 20_000


@pytest.mark.parametrize("name", ["bodies", "nasty"])
def test_the_slider_moves_every_linked_figure(visit: Callable[..., Any], name: str) -> None:
    page = visit(name)
    slider = page.locator("#instant")
    slider.fill("0")
    before = page.evaluate(MOVING)
    slider.fill(str(int(slider.get_attribute("max")) // 3))
    after = page.evaluate(MOVING)
    counts = {kind: len(marks) for kind, marks in before.items()}
    assert counts["lines"] == 6
    assert counts["strips"] == 2
    assert counts["rings"] == 5
    assert counts["cursors"] >= 7
    # p does not move where P is constant, nor p's difference: that is this scene's truth, not the slider's fault.
    still = {(kind, k) for kind in before for k, mark in enumerate(before[kind]) if after[kind][k] == mark}
    fields = page.evaluate('[...document.querySelectorAll("path[data-field]")].map((e) => e.dataset.field)')
    assert {fields[k] for kind, k in still if kind == "lines"} <= ({"p0", "p1", "dp"} if name == "nasty" else {"p0"})
    assert not [kind for kind, _ in still if kind != "lines"]
    assert "P " in page.locator("#readout").inner_text()


def test_keys_step_jump_and_play(visit: Callable[..., Any]) -> None:
    page = visit("nasty")
    slider = page.locator("#instant")
    last = int(slider.get_attribute("max"))

    def pressed(key: str) -> int:
        page.keyboard.press(key)
        return int(slider.input_value())

    slider.focus()
    assert pressed("Home") == 0
    assert [pressed("ArrowRight"), pressed("ArrowRight"), pressed("ArrowLeft")] == [1, 2, 1]
    assert [pressed("End"), pressed("ArrowRight")] == [last, last]
    assert pressed("Home") == 0
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") != "none"
    assert slider.get_attribute("aria-valuetext")
    page.keyboard.press("Space")
    assert page.locator("#play").get_attribute("aria-pressed") == "true"
    for _ in range(100):  # the page's own policy forbids wait_for_function, which evaluates text
        if int(slider.input_value()):
            break
        page.wait_for_timeout(50)
    assert int(slider.input_value())
    page.keyboard.press("Space")
    stopped = int(slider.input_value())
    page.wait_for_timeout(250)
    assert int(slider.input_value()) == stopped
    page.evaluate("document.activeElement.blur()")
    assert pressed("ArrowRight") == stopped + 1


def test_the_slider_stays_in_sight_beside_what_it_moves(visit: Callable[..., Any]) -> None:
    page = visit("nasty")
    for figure in ("state_map", "slip_history", "errors"):
        page.locator(f"#{figure}").evaluate("(e) => e.scrollIntoView()")
        box = page.locator("#controls").bounding_box()
        assert 0 <= box["y"] < 100


def test_chosen_instants_have_buttons(visit: Callable[..., Any]) -> None:
    page = visit("nasty")
    chips = page.locator("#events button")
    assert chips.count() >= 3
    chips.nth(2).click()
    assert chips.nth(2).get_attribute("aria-pressed") == "true"
    assert page.locator(".cell.here").count() == 1


def test_a_click_chooses_a_point_and_a_pointer_reads_numbers(visit: Callable[..., Any]) -> None:
    page = visit("bodies")
    curves = page.locator("#panel-slip .marks path.curve")
    before = curves.count()
    page.locator("#panel-map-result").click(position={"x": 140, "y": 100})
    assert curves.count() == before + 2
    assert page.locator("#slip_history .legend li").count() == before // 2 + 1
    page.locator("#clear").click()
    assert curves.count() == before
    page.locator("#place").fill("0.5")
    page.locator("#choose button[type=submit]").click()
    assert curves.count() == before + 2
    page.locator("#panel-now").hover(position={"x": 300, "y": 120})
    assert "half-plane theory: " in page.locator("#hint").inner_text()
    page.locator("#panel-map-reference").hover(position={"x": 170, "y": 100})
    assert "finite elements: " in page.locator("#hint").inner_text()


def test_words_from_outside_do_nothing(visit: Callable[..., Any]) -> None:
    page = visit("nasty")
    assert page.evaluate("window.pwned") is None
    assert page.locator("h1").inner_text() == NASTY
    assert page.locator("img").count() == 0
    for panel in ("now", "map-result"):
        page.locator(f"#panel-{panel}").hover(position={"x": 200, "y": 100})
        assert NASTY in page.locator("#hint").inner_text()
    assert page.evaluate("window.pwned") is None


def test_no_other_script_may_run(browser: Any, folders: dict[str, Path]) -> None:
    """The page's own policy refuses a script that is not its own, and any request, even where words were not escaped."""
    page = browser.new_page()
    page.goto(f"file://{folders['nasty']}/report.html")
    page.evaluate("const s = document.createElement('script'); s.textContent = 'window.pwned = 3'; document.body.append(s)")
    assert page.evaluate("window.pwned") is None
    assert page.evaluate("fetch('https://example.org').then(() => 'reached', () => 'refused')") == "refused"
    page.close()


def test_without_scripts_the_page_is_whole(visit: Callable[..., Any]) -> None:
    page = visit("bodies", java_script_enabled=False)
    assert not page.locator("#controls").is_visible()
    assert not page.locator("#choose").is_visible()
    for name in page.locator("figure").all():
        assert name.locator("svg .marks > *, svg.sketch path").count() > 0


def test_in_print_controls_are_gone_and_tables_whole(visit: Callable[..., Any]) -> None:
    page = visit("bodies", color_scheme="dark", viewport={"width": 700, "height": 900})
    page.emulate_media(media="print")
    assert not page.locator("#controls").is_visible()
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    table, room = (
        page.evaluate(f"document.querySelector('#verdict-table'){of}") for of in (".scrollWidth", ".parentNode.clientWidth")
    )
    assert table <= room
    assert page.evaluate("getComputedStyle(document.querySelector('svg.panel text')).fill") == "rgb(89, 89, 89)"


def test_tables_in_the_page_are_those_beside_it(visit: Callable[..., Any], folders: dict[str, Path]) -> None:
    page = visit("nasty")
    for name in ("tractions", "state_map", "load_path"):
        with page.expect_download() as waiting:
            page.locator(f"a[data-csv={name}]").click()
        text = Path(waiting.value.path()).read_bytes()
        assert text == (folders["nasty"] / "figures" / f"{name}.csv").read_bytes()
