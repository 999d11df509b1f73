"""The sign of a shear that is the only witness of its own instants."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import semi_analytic
from reports.scoring.against import score_file
from reports.scoring.mapping import Mapping, Signs
from scenes import load_scene

TOLD = "the shear acts on the lower body: its instants were found from the shear itself"


def table(folder: Path, name: str, *, sign: float = 1.0, loads: bool = False) -> Path:
    """The steady cycle of a scene on 121 points and 25 instants as a table, with or without P and Q."""
    scene = load_scene(name)
    path = scene.load.path()
    assert path.period is not None
    time = path.cycle_start + (scene.cycles - 1) * path.period + np.linspace(0, path.period, 25)
    exact = semi_analytic.solve(scene, x=np.linspace(-1.2, 1.2, 121), time=time)
    lines = ["frame,x,p,q" + (",P,Q" if loads else "")]
    for k in range(len(time)):
        beside = f",{exact.normal_load[k]:.9g},{exact.tangential_load[k]:.9g}" if loads else ""
        rows = zip(exact.x, exact.pressure[k], exact.shear[k], strict=True)
        lines.extend(f"{k},{x:.9g},{p:.9g},{sign * q:.9g}{beside}" for x, p, q in rows)
    file = folder / "result.csv"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_cycle_that_is_its_own_mirror_image_can_not_tell_and_says_so(tmp_path: Path, sign: float) -> None:
    found = score_file(table(tmp_path, "cattaneo-mindlin", sign=sign), Mapping(), load_scene("cattaneo-mindlin"))
    assert found.passed  # -q is +q half a period on
    assert any(TOLD in sentence for sentence in found.guesses)


def test_nothing_is_said_where_the_sign_is_stated_or_told(tmp_path: Path) -> None:
    scene = load_scene("cattaneo-mindlin")
    stated = score_file(table(tmp_path, "cattaneo-mindlin"), Mapping(signs=Signs(shear="on lower")), scene)
    by_loads = score_file(table(tmp_path, "cattaneo-mindlin", loads=True), Mapping(), scene)
    # Q of the paper's cycle has a mean: turned round it is another path.
    by_path = score_file(table(tmp_path, "hertz-paper"), Mapping(), load_scene("hertz-paper"))
    for found in (stated, by_loads, by_path):
        assert not any(TOLD in sentence for sentence in found.guesses)
