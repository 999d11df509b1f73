"""What a notebook shows: well-formed HTML in which every word from outside is escaped."""

from xml.etree import ElementTree as ET

import numpy as np
import pytest

import semi_analytic
from reports import compare
from scenes import load_scene, scene_names
from test_reports_synthetic import cattaneo_mindlin, with_fields

NASTY = "<script>alert(1)</script>\"'&"


def read(html: str) -> ET.Element:
    """Well-formed, or this fails."""
    return ET.fromstring(html.replace("&nbsp;", " "))


@pytest.mark.parametrize("name", scene_names())
def test_every_scene_of_the_library(name: str) -> None:
    scene = load_scene(name)
    shown = read(scene._repr_html_())
    assert scene.title in "".join(shown.itertext())
    assert len(shown.findall(".//tr")) == 10
    assert shown.find(".//polyline") is not None


def test_a_solution_with_its_loop() -> None:
    solution = semi_analytic.solve(load_scene("hertz-paper"))
    words = "".join(read(solution._repr_html_()).itertext())
    assert f"{solution.dissipation:.6g}" in words
    assert "semi_analytic" in words


def test_a_comparison_with_its_verdict() -> None:
    truth = cattaneo_mindlin(steps_per_leg=12, points=61)
    comparison = compare(truth, with_fields(truth, pressure=1.01 * truth.pressure))
    words = "".join(read(comparison._repr_html_()).itertext())
    assert "Not within tolerance." in words
    assert "outside" in words
    assert len(read(comparison._repr_html_()).findall(".//tr")) == 1 + len(comparison.headlines)


def test_words_from_outside_are_escaped() -> None:
    truth = cattaneo_mindlin(steps_per_leg=12, points=61)
    scene = truth.scene.vary(name=NASTY, title=NASTY, units=NASTY)
    truth = with_fields(
        truth, scene=scene, engine=NASTY, tangential_displacement=np.full_like(truth.tangential_displacement, np.nan)
    )
    for shown in (scene, truth, compare(truth, truth)):
        html = shown._repr_html_()
        assert NASTY in "".join(read(html).itertext())
        assert "<script" not in html
