"""A file of the first revolution, which starts where the initial loading ends: scored as the steady one, or as its times say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import semi_analytic
from reports.scoring.against import score_file
from reports.scoring.diagnosis import diagnose
from reports.scoring.mapping import Mapping
from scenes import load_scene

SCENE = load_scene("cattaneo-mindlin")  # (P, 0) at time 1, corners at 2 and 3
TIMES = np.concatenate([np.linspace(1.0, 2.0, 7), np.linspace(2.0, 3.0, 13)[1:], np.linspace(3.0, 4.5, 13)[1:]])


@pytest.fixture
def first_cycle(tmp_path: Path) -> Path:
    """A table with loads and without times, as another code writes it."""
    exact = semi_analytic.solve(SCENE, x=np.linspace(-1.2, 1.2, 121), time=TIMES)
    lines = ["frame,P,Q,x,p,q"]
    for k, (normal, tangential) in enumerate(zip(exact.normal_load, exact.tangential_load, strict=True)):
        rows = zip(exact.x, exact.pressure[k], exact.shear[k], strict=True)
        lines.extend(f"{k},{normal:.9g},{tangential:.9g},{x:.9g},{p:.9g},{q:.9g}" for x, p, q in rows)
    path = tmp_path / "first.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_it_is_taken_for_steady_and_told_what_it_is_and_what_would_say_so(first_cycle: Path) -> None:
    found = score_file(first_cycle, Mapping(), SCENE)
    assert not found.passed
    first = diagnose(found.comparison)[0]
    assert first.fault == "not_steady"
    assert "state its times on the scene's path (times of a mapping)" in first.sentence


def test_with_its_times_it_is_right(first_cycle: Path) -> None:
    found = score_file(first_cycle, Mapping(times=tuple(TIMES.tolist())), SCENE)
    assert found.passed
    assert not diagnose(found.comparison)
    off = found.metric("shear").value
    assert off is not None
    assert off < 1e-6
