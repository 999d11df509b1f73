"""The page in a real browser: quiet, offline, moved by one slider and by keys, nothing over
anything else, at every size.
"""

import shutil
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import halfplane_fe
import semi_analytic
from problems import COARSE, FEW_STEPS
from reports import compare, write
from reports.console import Stages
from reports.studies.paper import page as paper
from scenes import Scene, load_scene
from test_reports_synthetic import EVIL, evil

sync_api = pytest.importorskip(
    "playwright.sync_api", reason="playwright is not installed: pip install -e .[browser]"
)
CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(
    CHROMIUM is None, reason="no chromium on this machine: apt-get install chromium"
)

DESKTOP: dict[str, Any] = {"viewport": {"width": 1280, "height": 900}}
PHONE: dict[str, Any] = {
    "viewport": {"width": 390, "height": 844},
    "device_scale_factor": 2,
    "is_mobile": True,
    "has_touch": True,
}
LONG = 600_000  # ms that a busy machine may take
SIZES = {"desktop": DESKTOP, "dark": DESKTOP | {"color_scheme": "dark"}, "phone": PHONE}


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A page of half-planes whose every word from outside is an attack, and one of real bodies with
    meshes.
    """
    bodies = {
        "lower": {"kind": "block", "width": 20.0, "height": 12.0},
        "upper": {"kind": "pad", "width": 10.0, "height": 8.0},
    }
    real = Scene.model_validate(load_scene("cattaneo-mindlin").model_dump() | {"bodies": bodies})
    fe = halfplane_fe.solve(real, COARSE, FEW_STEPS)
    pages = {
        "nasty": evil(),
        "bodies": compare(semi_analytic.solve(real, x=fe.x, time=fe.time), fe),
    }
    places = {}
    for name, comparison in pages.items():
        out = tmp_path_factory.mktemp("page") / name
        write(comparison, out, command=f"halfplane run {EVIL}", seconds={EVIL: 1.5})
        places[name] = out
    return places


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with sync_api.sync_playwright() as play:
        started = play.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        yield started
        started.close()


def downloaded(page: Any, button: Any) -> tuple[str, bytes]:
    """Name and content of the file that a click saves."""
    with page.expect_download() as waiting:
        button.click()
    return waiting.value.suggested_filename, Path(waiting.value.path()).read_bytes()


UNFOLD = "() => document.querySelectorAll('details').forEach((fold) => { fold.open = true; })"


@pytest.fixture
def visit(browser: Any, folders: dict[str, Path]) -> Iterator[Callable[..., Any]]:
    """Opens a page, by default with all that is folded on it; at the end nothing may have been said
    on the console and nothing asked of any network.
    """
    opened = []
    heard = []
    requests = []

    def open_page(name: str | Path, *, folded: bool = False, **options: Any) -> Any:
        context = browser.new_context(**(DESKTOP | options))
        context.set_default_timeout(LONG)
        page = context.new_page()
        page.on("console", lambda message: heard.append(message.text))
        page.on("pageerror", lambda error: heard.append(str(error)))
        page.on("request", lambda request: requests.append(request.url))
        page.goto(f"file://{name if isinstance(name, Path) else folders[name]}/report.html")
        if not folded:
            page.evaluate(UNFOLD)
        opened.append(context)
        return page

    yield open_page
    for context in opened:
        context.close()
    assert heard == []
    assert [url for url in requests if not url.startswith(("file://", "data:", "blob:"))] == []
    assert [
        url for url in requests if url.startswith("file://") and not url.endswith("report.html")
    ] == []


# What the slider moves, as text: lines, strips, rings, cursors.
MOVING = """() => ({
  lines: [...document.querySelectorAll("path[data-field]")].map((e) => e.getAttribute("d")),
  strips: [...document.querySelectorAll("g.strip")].map((e) => e.innerHTML),
  rings: [...document.querySelectorAll("circle.follow")].map(
    (e) => e.getAttribute("cx") + " " + e.getAttribute("cy")),
  cursors: [...document.querySelectorAll("line.cursor")].map(
    (e) => ["x1", "y1"].map((n) => e.getAttribute(n)).join(" ")),
})"""
# Figures without a single mark that has a size.
EMPTY = """() => [...document.querySelectorAll("figure")].filter(
  (figure) => ![...figure.querySelectorAll(
    "svg:not(.legend svg) :is(.marks *, .body, .strip rect)")].some((mark) => {
    const box = mark.getBoundingClientRect(); return box.width > 1 || box.height > 1; })
  ).map((figure) => figure.id)"""
# Pairs of texts of one drawing of which more than a hair's breadth lies over another.
OVERLAPS = """() => [...document.querySelectorAll("svg.panel, svg.sketch")].flatMap((svg) => {
  const texts = [...svg.querySelectorAll("text")].map(
    (e) => [e.textContent, e.getBoundingClientRect()]);
  return texts.flatMap(([a, p], k) => texts.slice(k + 1).filter(([, q]) =>
    Math.min(p.right, q.right) - Math.max(p.left, q.left) > 1.5 &&
    Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top) > 3
  ).map(([b]) => `${svg.id}: ${a} / ${b}`)); })"""
# Whatever reaches beyond the window, or scrolls sideways in a box of its own; code in the manual
# may, and side bars that are away.
WIDER = """(but) => [...document.querySelectorAll("body *:not(svg *)")].filter((e) => {
  if (!e.getClientRects().length || e.closest(but)) return false;
  const box = e.getBoundingClientRect();
  return (e.clientWidth > 1 && e.scrollWidth > e.clientWidth + 1
      && getComputedStyle(e).overflowX !== "visible")
    || (box.width > 1 && box.right > innerWidth + 1);
}).map((e) => `${e.tagName}#${e.id}.${e.className} ${e.scrollWidth} > ${e.clientWidth}`)"""
MANUAL = Path(__file__).parents[1] / "docs" / "_build" / "html"
CUT_OFF = """() => [...document.querySelectorAll("svg.panel, svg.sketch")].flatMap((svg) => {
  const box = svg.getBoundingClientRect();
  return [...svg.querySelectorAll("text")].filter((e) => { const t = e.getBoundingClientRect();
    return t.left < box.left - 1 || t.right > box.right + 1
      || t.top < box.top - 1 || t.bottom > box.bottom + 1;
  }).map((e) => `${svg.id || "sketch"}: ${e.textContent}`); })"""


def fits(page: Any, wide: str = ".none", cut: bool = True) -> None:
    """Nothing is wider than its column or cut off, from a small phone to a large screen, but for
    what matches `wide`.
    """
    for width in (360, 390, 768, 1024, 1440):
        page.set_viewport_size({"width": width, "height": 900})
        page.evaluate(
            "() => new Promise((drawn) => requestAnimationFrame(() =>"
            " requestAnimationFrame(drawn)))"
        )
        assert page.evaluate(WIDER, wide) == [], width
        assert not cut or page.evaluate(CUT_OFF) == [], width


@pytest.mark.parametrize("size", SIZES)
def test_every_figure_is_drawn_and_nothing_is_cut_off(
    visit: Callable[..., Any], tmp_path: Path, size: str
) -> None:
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
    # p does not move where P is constant, nor p's difference: that is this scene's truth, not the
    # slider's fault.
    unmoved = {
        (kind, k)
        for kind in before
        for k, mark in enumerate(before[kind])
        if after[kind][k] == mark
    }
    fields = page.evaluate(
        '[...document.querySelectorAll("path[data-field]")].map((e) => e.dataset.field)'
    )
    assert {fields[k] for kind, k in unmoved if kind == "lines"} <= (
        {"p0", "p1", "dp"} if name == "nasty" else {"p0"}
    )
    assert not [kind for kind, _ in unmoved if kind != "lines"]
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
    for _ in range(2400):  # the page's own policy forbids wait_for_function, which evaluates text
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


def test_the_slider_stays_in_sight_and_chosen_instants_have_buttons(
    visit: Callable[..., Any],
) -> None:
    page = visit("nasty")
    for figure in ("state_map", "slip_history", "errors"):
        page.locator(f"#{figure}").evaluate("(e) => e.scrollIntoView()")
        assert 0 <= page.locator("#controls").bounding_box()["y"] < 100
    chips = page.locator("#events button")
    assert chips.count() >= 3
    chips.nth(2).click()
    assert chips.nth(2).get_attribute("aria-pressed") == "true"
    assert page.locator(".cell.here").count() == 1


def test_a_click_chooses_a_point_and_a_pointer_reads_numbers(visit: Callable[..., Any]) -> None:
    page = visit("bodies")
    words = page.evaluate(
        '[...document.querySelectorAll("figure, nav.contents")].map((e) => e.textContent)'
    )
    assert len(words) >= 12
    assert not [text for text in words if "_" in text]
    assert page.locator("#tractions svg .sub").count() >= 12
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
    assert "_" not in page.locator("#hint").inner_text()
    page.locator("#panel-map-reference").hover(position={"x": 170, "y": 100})
    assert "finite elements: " in page.locator("#hint").inner_text()


@pytest.mark.parametrize("name", ["bodies", "nasty"])
def test_nothing_is_wider_than_its_column(visit: Callable[..., Any], name: str) -> None:
    page = visit(name)
    for details in page.locator("details").all():
        details.locator("summary").click()
    fits(page, cut=name == "bodies")  # words of an attack have no place to break


@pytest.mark.skipif(not MANUAL.is_dir(), reason="the manual is not built: make docs")
@pytest.mark.parametrize(
    "name", ["index", "report", "verification", "theory", "metrics", "score", "published/blocks"]
)
def test_no_page_of_the_manual_is_wider_than_its_column(browser: Any, name: str) -> None:
    page = browser.new_page()
    page.set_default_timeout(LONG)
    page.goto((MANUAL / f"{name}.html").as_uri())
    fits(page, "pre, .formula, .wide, .toc-drawer, .sidebar-drawer")
    page.close()


@pytest.mark.parametrize(("width", "tallest"), [(1400, 5500), (390, 11_000)])
def test_a_page_is_short_until_it_is_unfolded(
    visit: Callable[..., Any], width: int, tallest: int
) -> None:
    page = visit("bodies", folded=True, viewport={"width": width, "height": 900})
    height = "document.documentElement.scrollHeight"
    folded_height = page.evaluate(height)
    assert folded_height <= tallest
    page.evaluate(UNFOLD)
    assert page.evaluate(height) > 1.3 * folded_height


def test_a_link_to_a_folded_section_opens_it(visit: Callable[..., Any]) -> None:
    page = visit("bodies", folded=True)
    table = page.locator("#verdict-table")
    assert not table.is_visible()
    page.locator('nav a[href="#verdicts"]').click()
    table.wait_for(state="visible")


def test_on_a_phone_every_verdict_is_in_sight(visit: Callable[..., Any]) -> None:
    cells = visit("bodies", **PHONE).locator("#amounts td:last-child")
    assert cells.count() == 7
    for box in (cell.bounding_box() for cell in cells.all()):
        assert 0 <= box["x"] <= 390 - box["width"]


def test_a_click_on_the_legend_hides_its_curves_and_shows_them_again(
    visit: Callable[..., Any],
) -> None:
    page = visit("bodies")
    curves = page.locator("#tractions .panel .curve.f.q")
    entry = page.locator("#tractions .legend li", has_text="q, finite elements")
    assert curves.first.is_visible()
    entry.click()
    assert entry.get_attribute("aria-pressed") == "false"
    assert not any(curve.is_visible() for curve in curves.all())
    assert page.locator("#tractions .panel .curve.r.q").first.is_visible()
    entry.press("Enter")
    assert curves.first.is_visible()
    page.locator("#cycle-figure .legend li", has_text="p, finite elements").click()
    page.keyboard.press("End")  # the slider moves what is hidden, too, and does not bring it back
    assert not page.locator("#panel-now .curve.f.p").is_visible()


def test_a_drag_zooms_a_double_click_and_keys_show_it_whole(visit: Callable[..., Any]) -> None:
    page = visit("bodies")
    panel = page.locator("#panel-edges")
    ticks = page.locator("#panel-edges .tick.across")
    panel.scroll_into_view_if_needed()
    path = panel.locator(".curve").first
    before = None
    labels = ticks.all_text_contents()
    before = path.get_attribute("d")
    box = panel.bounding_box()

    def drag(x: float, y: float) -> None:
        page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 0.3 * box["height"])
        page.mouse.down()
        page.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"], steps=4)
        page.mouse.up()

    drag(0.6, 0.6)
    assert path.get_attribute("d") != before
    zoomed = [float(text.replace("−", "-")) for text in ticks.all_text_contents()]
    assert max(zoomed) - min(zoomed) < 0.5  # of a period
    back = page.locator("#half_widths button", has_text="Whole view")
    assert back.is_visible()
    panel.dblclick(position={"x": 0.5 * box["width"], "y": 0.5 * box["height"]})
    assert path.get_attribute("d") == before
    assert ticks.all_text_contents() == labels
    assert not back.is_visible()
    panel.focus()
    page.keyboard.press("+")
    assert path.get_attribute("d") != before
    now = page.locator("#instant").input_value()
    page.keyboard.press("Shift+ArrowRight")
    assert page.locator("#instant").input_value() == now
    page.keyboard.press("0")
    assert path.get_attribute("d") == before
    # What the slider moves, and a point that is chosen, follow a zoom.
    page.locator("#panel-now").scroll_into_view_if_needed()
    page.locator("#panel-now").focus()
    page.keyboard.press("+")
    path_of_curve = page.locator("#panel-now .curve.f.p").get_attribute("d")
    page.locator("#instant").fill("3")
    assert page.locator("#panel-now .curve.f.p").get_attribute("d") != path_of_curve
    page.keyboard.press("0")


def test_every_figure_can_be_saved_as_svg_and_png(visit: Callable[..., Any]) -> None:
    page = visit("bodies")
    names = page.evaluate('[...document.querySelectorAll("figure")].map((e) => e.id)')
    for name in names:
        for kind in ("SVG", "PNG"):
            assert page.locator(f"#{name} .files button", has_text=kind).count() == 1, name
        assert page.locator(f"#{name} .files a[data-csv]").count() == 1
    for name in ("tractions", "mesh", "state_map"):
        for kind, start in (("SVG", b"<svg"), ("PNG", b"\x89PNG")):
            file, content = downloaded(page, page.locator(f"#{name} .files button", has_text=kind))
            assert file == f"{name}.{kind.lower()}"
            assert content.startswith(start)
            assert len(content) > 20_000
            if kind == "SVG":
                assert not [word for word in (b"<use", b"var(", b'class="') if word in content]
                assert ET.fromstring(content).tag.endswith("svg")


@pytest.mark.slow
def test_the_paper_s_page_is_as_interactive(visit: Callable[..., Any], tmp_path: Path) -> None:
    page = visit(paper.write(tmp_path / "out", Stages(quiet=True)).page.parent)
    entry = page.locator("#figure_07a .legend li", has_text="f = 0.6")
    entry.click()
    assert not page.locator("#figure_07a .panel .curve.c2").is_visible()
    page.locator("#panel-figure_07a").hover(position={"x": 500, "y": 200})
    assert "f = 1: " in page.locator("#hint").inner_text()
    page.locator("#panel-figure_07a").focus()
    page.keyboard.press("+")
    assert page.locator("#figure_07a button", has_text="Whole view").is_visible()
    assert (
        len(downloaded(page, page.locator("#figure_02 .files button", has_text="PNG"))[1]) > 20_000
    )
    fits(page)


def test_words_from_outside_do_nothing(visit: Callable[..., Any]) -> None:
    page = visit("nasty")
    assert page.title() != "run"
    assert page.locator("h1").inner_text() == EVIL
    assert page.locator("img").count() == 0
    for panel in ("now", "map-result"):
        page.locator(f"#panel-{panel}").hover(position={"x": 200, "y": 100})
        assert EVIL in page.locator("#hint").inner_text()
    assert page.title() != "run"


def test_no_other_script_may_run(browser: Any, folders: dict[str, Path]) -> None:
    """The page's own policy refuses a script that is not its own, and any request, even where words
    were not escaped.
    """
    page = browser.new_page()
    page.set_default_timeout(LONG)
    page.goto(f"file://{folders['nasty']}/report.html")
    page.evaluate(
        "const s = document.createElement('script'); s.textContent = 'window.pwned = 3';"
        " document.body.append(s)"
    )
    assert page.evaluate("window.pwned") is None
    assert (
        page.evaluate("fetch('https://example.org').then(() => 'reached', () => 'refused')")
        == "refused"
    )
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
        page.evaluate(f"document.querySelector('#verdict-table'){of}")
        for of in (".scrollWidth", ".parentNode.clientWidth")
    )
    assert table <= room
    assert (
        page.evaluate("getComputedStyle(document.querySelector('svg.panel text')).fill")
        == "rgb(89, 89, 89)"
    )


def test_tables_in_the_page_are_those_beside_it(
    visit: Callable[..., Any], folders: dict[str, Path]
) -> None:
    page = visit("nasty")
    for name in ("tractions", "state_map", "load_path"):
        _, text = downloaded(page, page.locator(f"a[data-csv={name}]"))
        assert text == (folders["nasty"] / "figures" / f"{name}.csv").read_bytes()
