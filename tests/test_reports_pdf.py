"""The PDF: made where typst is, refused in a sentence where it is not, words from outside as data and never as typst's language."""

import importlib.util
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import pytest

from reports import Report, compare, pdf, write
from reports.page.writing import draw
from scenes import InputError
from test_reports_synthetic import cattaneo_mindlin, with_fields

TRUTH = cattaneo_mindlin(steps_per_leg=12, points=61)
NASTY = '#panic("typst read this") $x$ *b* `code` <label> @ref \\ // </text>'


def test_without_typst_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pdf, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"--pdf: it needs typst.*halfplane\[pdf\]"):
        pdf.require_typst("--pdf")


@pytest.mark.skipif(importlib.util.find_spec("typst") is None, reason="typst is not installed: pip install -e .[pdf]")
def test_a_pdf_is_written_beside_the_page_whatever_the_words(tmp_path: Path) -> None:
    scene = TRUTH.scene.vary(name=NASTY, title=NASTY, purpose=NASTY)
    truth = replace(TRUTH, scene=scene)
    comparison = compare(truth, with_fields(truth, shear=0.99 * truth.shear, engine=NASTY))
    write(comparison, tmp_path / "out", command=NASTY, pdf=True)
    content = (tmp_path / "out" / "report.pdf").read_bytes()
    assert content.startswith(b"%PDF-")
    assert len(content) > 50_000
    write(comparison, tmp_path / "plain")
    assert not (tmp_path / "plain" / "report.pdf").exists()


def test_a_figure_stands_alone() -> None:
    """No variable of the page, no class of it, nothing of other figures, and XML that any reader takes."""
    for plate in draw(Report(compare(TRUTH, TRUTH))):
        alone = plate.svg()
        assert ET.fromstring(alone).tag.endswith("svg")
        assert not [word for word in ("var(", "<use", "class=", "data-", "{{") if word in alone.replace("data:image/png", "")]
