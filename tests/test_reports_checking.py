"""Before anything is solved: how near gross sliding, and where; the largest contact; measured
loads, their cycles and noise.
"""

from __future__ import annotations

import json
import math
import re
import shutil
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rainflow import count_cycles

import halfplane_fe
import reports
import semi_analytic
from command_line import COARSE, ROOT, halfplane, refused, require_schema
from halfplane_fe import scales
from halfplane_fe.scales import estimate_room, find_scales
from refusals import refused_for, require_facts
from reports import checking
from reports.checking import (
    bulk_and_tilt,
    bulk_in_words,
    engine_refusals,
    largest_contact,
    largest_normal_load,
    nearest_to_sliding,
    remarks_on_input,
    require_admissible,
)
from reports.measured import (
    check_record,
    cycles_with_work,
    load_cycles,
    rainflow_cycles,
    record_in_words,
    sigma_of_noise,
)
from reports.record_parts import record_parts
from reports.scoring.against import score_file
from reports.scoring.loops import MeasuredLoop, score_loop
from reports.scoring.mapping import Mapping
from reports.scoring.reading import read_result
from scenes import (
    Block,
    Bodies,
    ContactSolution,
    EllipseLoad,
    EvenPolynomial,
    Hertz,
    InputError,
    Materials,
    Pad,
    PolygonLoad,
    PowerLaw,
    Scene,
    Tabulated,
    TimeSeriesLoad,
    load_scene,
    scene_names,
)

BASE = load_scene("hertz-paper")


def scene(load: EllipseLoad | PolygonLoad, friction: float = 0.5) -> Scene:
    return BASE.vary(load=load, friction=friction)


def fault_of(scene: Scene) -> BaseException | None:
    """Why a path is refused."""
    try:
        require_admissible(scene, "my.toml")
    except InputError as fault:
        return fault.__cause__
    return None


def test_the_library_is_admissible_has_room_and_is_remarked_on_where_it_is_odd(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Only a steep face and a rigid body are; the rule for room meshes nothing."""
    monkeypatch.setattr(halfplane_fe, "require_solvable", lambda _scene: None)
    remarked = []
    for name in scene_names():
        scene = load_scene(name)
        assert fault_of(scene) is None
        assert nearest_to_sliding(scene).ratio < 1
        engine_refusals(scene, name)
        if remarks_on_input(scene, largest_contact(scene, name)):
            remarked.append(name)
    assert remarked == ["large-pad-steep", "layer"]


@pytest.mark.parametrize("sign", [1, -1])
def test_largest_ratio_of_an_ellipse(sign: int) -> None:
    """P = 3 + cos t, Q = +-(1.1 + sin t), f = 1: the tangent from the origin to a circle of radius
    1 about (3, 1.1).

    Its angle is atan(1.1/3) + asin(1/sqrt(3^2 + 1.1^2)).
    """
    load = EllipseLoad(
        mean_normal_load=3,
        normal_amplitude=1,
        mean_tangential_load=1.1 * sign,
        tangential_amplitude=1,
        phase_degrees=90.0 * sign,
    )
    check = nearest_to_sliding(scene(load, friction=1.0))
    expected = math.tan(math.atan(1.1 / 3) + math.asin(1 / math.hypot(3, 1.1)))
    assert check.ratio == pytest.approx(expected, rel=1e-12)
    assert check.part == "cycle"
    assert check.tangential_load / check.normal_load == pytest.approx(sign * expected, rel=1e-7)


# points of the initial loading, of the cycle, friction, reason, where it starts
PATHS = [
    # Q grows from 0 to 60 beside P = 100 during the second unit of time; f P = 50 is passed at 1 +
    # 5/6.
    ([(100, 0), (100, 60)], [], 0.5, "gross sliding", 1 + 5 / 6),
    ([(100, 0), (100, -60)], [], 0.5, "gross sliding", 1 + 5 / 6),
    ([(100, 0), (-20, 0)], [], 0.5, "separation", 1 + 100 / 120),
    ([(100, 50), (100, -50)], [], 0.5, "", None),  # on the brink
    ([(100, 0)], [(0, 0)], 0.5, "", None),  # unloading to nothing
    ([(100, 1)], [], 0.0, "gross sliding", 0.0),
    ([(100, 0)], [], 0.0, "", None),
]


@pytest.mark.parametrize(("way", "cycle", "friction", "reason", "start"), PATHS)
def test_gross_sliding_and_separation_are_found_where_they_start(
    way: list[tuple[float, float]],
    cycle: list[tuple[float, float]],
    friction: float,
    reason: str,
    start: float | None,
) -> None:
    path = scene(PolygonLoad(initial_loading=way, cycle=cycle), friction)
    fault = fault_of(path)
    near = nearest_to_sliding(path)
    assert (f"load: {reason} " in str(fault), getattr(fault, "time", None)) == (
        start is not None,
        start and pytest.approx(start),
    )
    if abs(way[-1][1]) == 60:
        assert (near.ratio, near.time, near.part) == (pytest.approx(1.2), 2.0, "path")
        with refused_for("my.toml: load: ", "gross sliding", "1.83333", "time 2", "P = 100"):
            require_admissible(path, "my.toml")


@pytest.mark.parametrize(("mean", "hint"), [(-20.0, True), (90.0, False)])
def test_an_initial_loading_that_is_alone_at_fault_is_named(mean: float, hint: bool) -> None:
    """The parabola is tangent to the ellipse, so it leaves zero as steeply as it must; a cycle
    outside the limit has none.
    """
    with pytest.raises(InputError) as fault:
        require_admissible(BASE.vary(load={"mean_tangential_load": mean}), "my.toml")
    assert ('or write load.initial_loading = "straight"' in str(fault.value)) == hint


def test_a_record_in_which_compression_is_negative_is_told_so() -> None:
    rows = [[0.0, -80.0, 0.0], [1.0, -90.0, 20.0], [2.0, -100.0, -20.0], [3.0, -80.0, 0.0]]
    record = scene(PolygonLoad(initial_loading=[(100, 0)])).vary(
        load=TimeSeriesLoad(rows=rows, repeats=True)
    )
    with pytest.raises(
        InputError, match=r"my\.toml: load: P is never positive; .* turn its sign if"
    ):
        require_admissible(record, "my.toml")


@pytest.mark.parametrize(("repeats", "block"), [(False, 7), (True, 7), (True, 100)])
def test_a_record_is_judged_as_the_legs_between_its_rows(
    repeats: bool, block: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rows of random loads, some outside the cone, some with P < 0: worst ratio, first instant and
    largest P of the legs.
    """
    monkeypatch.setattr(checking, "_ROWS_PER_BLOCK", block)
    chance = np.random.default_rng(16)
    for trial in range(30):
        normal = 100 + 60 * chance.standard_normal(30)
        rows = np.stack(
            [
                np.cumsum(chance.uniform(0.1, 1, 30)),
                normal,
                0.1 * (1 + trial % 3) * normal * chance.standard_normal(30),
            ],
            axis=1,
        )
        rows[:, 1] = np.abs(rows[:, 1]) if trial % 2 else rows[:, 1]
        rows[-1, 1:] = rows[0, 1:]
        friction = BASE.friction.model_copy(update={"coefficient": 0.3})
        record = BASE.model_copy(
            update={"load": TimeSeriesLoad(rows=rows, repeats=repeats), "friction": friction}
        )
        path = record.load.path()
        nearest = nearest_to_sliding(record)
        legs = [*path.initial_loading, *path.cycle]
        ends = np.array([leg.loads([leg.start, leg.end]) for leg in legs])
        p = ends[:, 0]
        q = ends[:, 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(p < 0, np.inf, np.where(q == 0, 0.0, np.abs(q) / (0.3 * p)))
        worst = int(np.argmax(ratio.max(axis=1)))
        assert nearest.ratio == ratio.max()
        assert legs[worst].start <= nearest.time <= legs[worst].end
        part = "cycle" if worst else "initial loading"
        assert nearest.part == (part if repeats else "path")
        outside = np.flatnonzero(ratio.max(axis=1) > 1 + 1e-12)
        fault = fault_of(record)
        assert (fault is None) == (len(outside) == 0)
        if fault is not None:
            assert legs[outside[0]].start <= fault.time <= legs[outside[0]].end
        assert largest_normal_load(record) == p.max()


# ------------------------------------------------------------------------------ the largest contact
def steel(modulus: float = 210e3) -> Materials:
    return Materials.model_validate({"young_modulus": modulus, "poisson_ratio": 0.3})


def pressed(load: float, **changes: object) -> Scene:
    return BASE.model_copy(
        update={"load": PolygonLoad(initial_loading=[(load, 0.0), (load, 0.1 * load)]), **changes}
    )


def test_numbers_of_the_largest_contact_are_those_of_hertz() -> None:
    """a = sqrt(4 P R/(pi E*)), p0 = E* a/(2 R)."""
    bodies = Bodies(lower=Block(width=20.0, height=8.0), upper=Pad(width=12.0, height=6.0))
    contact = largest_contact(pressed(80.0, bodies=bodies), "mine")
    modulus = 210e3 / (2 * (1 - 0.3**2))
    half = math.sqrt(4 * 80 * 1000 / (math.pi * modulus))
    assert contact.normal_load == 80
    assert contact.half_width == pytest.approx(half, rel=1e-14)
    assert contact.peak_pressure == pytest.approx(modulus * half / 2000, rel=1e-12)
    assert contact.strain == pytest.approx(half / 2000, rel=1e-12)
    assert contact.edge_slope == pytest.approx(half / 1000, rel=1e-8)
    sizes = {"lower width/a": 20, "lower height/a": 8, "upper width/a": 12, "upper height/a": 6}
    assert contact.ratios == pytest.approx(
        {"a/R": half / 1000} | {name: size / half for name, size in sizes.items()}
    )


# E* = R = f = 1, P = 3, Q = +-1.8: a, and the bulk strain up to which both ends slip one way.
A3 = math.sqrt(12 / math.pi)
LIMIT = 2 * 1.8 / (math.pi * A3)
NONE: dict[str, Any] = {"bulk_stress_upper": None, "tilt": None, "line_of_action": None}


@pytest.mark.parametrize(
    ("keys", "eccentricity", "moderate", "centre", "words"),
    [
        (
            {"bulk_stress_lower": (0.0, 0.4, -0.4)},
            0.2 / A3,
            0.2 / LIMIT,
            0.0,
            "moderate: where it goes with Q both ends",
        ),
        (
            {"bulk_stress_upper": (0.0, 2.0, -2.0)},
            1.0 / A3,
            1.0 / LIMIT,
            0.0,
            "large: the ends of the contact slip opposite ways",
        ),
        (
            {"bulk_stress_lower": 0.4, "tilt": 0.1},
            0.0,
            None,
            -0.1 / A3,
            "Tilt moves the middle of the contact by −0.0512 a",
        ),
        (
            {"line_of_action": {"x": 0.3}},
            None,
            None,
            0.3 / A3,
            "Tilt moves the middle of the contact by 0.153 a",
        ),
    ],
    ids=["moderate", "large, above", "constant, with tilt", "a line of action"],
)
def test_check_states_the_eccentricity_and_whether_bulk_is_moderate(
    keys: dict[str, Any],
    eccentricity: float | None,
    moderate: float | None,
    centre: float,
    words: str,
) -> None:
    load = {
        "kind": "polygon",
        "initial_loading": [(3.0, 0.0), (3.0, 1.8)],
        "cycle": [(3.0, -1.8)],
        **keys,
    }
    soft = {"young_modulus": 2.0, "poisson_ratio": 0.0}
    pulled = Scene.model_validate(
        {
            "material": soft,
            "profile": {"kind": "hertz", "radius": 1.0},
            "friction": 1.0,
            "load": load,
        }
    )
    turning = bulk_and_tilt(pulled)
    assert turning.eccentricity == (
        None if eccentricity is None else pytest.approx(eccentricity, rel=1e-9)
    )
    assert turning.share_of_moderate == (
        None if moderate is None else pytest.approx(moderate, rel=1e-9)
    )
    assert turning.centre == pytest.approx(centre, rel=1e-9)
    strains = [
        np.max(np.abs(stress or 0.0)) / 2
        for stress in (keys.get("bulk_stress_lower"), keys.get("bulk_stress_upper"))
    ]
    assert turning.strain == pytest.approx(sum(strains), rel=1e-9)
    assert words in bulk_in_words(turning)
    assert bulk_and_tilt(load_scene("cattaneo-mindlin")) is None
    at_rest = pulled.vary(
        load={
            "initial_loading": [(3.0, 0.0)],
            "cycle": [(2.0, 0.0)],
            "bulk_stress_lower": (0.0, 0.4),
            **NONE,
        }
    )
    without = bulk_and_tilt(at_rest)
    assert "a Q that does not move" in bulk_in_words(without)


def test_check_says_how_large_the_contact_gets_and_infinity_is_null_for_programs(
    tmp_path: Path,
) -> None:
    stdout = halfplane(tmp_path, "check", "blocks").stdout
    contact = largest_contact(load_scene("blocks"), "blocks")
    cells = {
        name.strip(): value.strip() for name, _, value in re.findall(r"│(.*?)(│)(.*?)│", stdout)
    }
    assert cells["half-width a there [mm]"] == f"{contact.half_width:.4g}"
    assert cells["peak pressure p0 there [MPa]"] == f"{contact.peak_pressure:.4g}"
    assert cells["p0/E*"] == f"{contact.strain:.4g}"
    assert {name: cells[name] for name in contact.ratios} == {
        name: f"{ratio:.4g}" for name, ratio in contact.ratios.items()
    }
    words = ("a block 20 mm wide", "a finding about the idealisation")
    assert not [word for word in words if word not in stdout]
    answer = json.loads(halfplane(tmp_path, "check", "blocks", "--json").stdout)["result"]
    assert (answer["largest_contact"], answer["remarks"]) == (
        {**vars(contact), "ratios": contact.ratios},
        [],
    )
    wedge = pressed(80.0, profile=PowerLaw(exponent=1.0, length=1.0, rise=0.01))
    assert math.isinf(largest_contact(wedge, "mine").peak_pressure)
    wedge.save(tmp_path / "wedge.json")
    assert "infinite at the tip" in halfplane(tmp_path, "check", "wedge.json").stdout
    answer = json.loads(halfplane(tmp_path, "check", "wedge.json", "--json").stdout)["result"]
    assert answer["largest_contact"]["peak_pressure"] is None


SPOKEN = ("blocks", "dovetail-out-of-phase", "time-series", "row-of-contacts")


@pytest.mark.parametrize("name", SPOKEN)
def test_check_speaks_in_sentences_of_at_most_25_words(name: str, tmp_path: Path) -> None:
    lines = halfplane(tmp_path, "check", name).stdout.splitlines()
    title = "By half-plane theory"
    prose = "\n".join(line for line in lines if line[:1] not in "┏┃┡│└" and line.strip() != title)
    sentences = re.split(r"(?<=[.?!])\s", prose)
    assert len(sentences) > 8
    assert not [sentence for sentence in sentences if len(sentence.split()) > 25]


REMARKED = {
    "E in GPa": (
        {"material": steel(210.0)},
        ["young_modulus = 210 MPa is as soft as", "steel has 210000 MPa. Is E in GPa?"],
    ),
    "E in Pa": (
        {"material": steel(210e9)},
        ["young_modulus = 2.1e+11 MPa is stiffer than diamond"],
    ),
    "rubber": (
        {"material": Materials.model_validate({"young_modulus": 5.0, "poisson_ratio": 0.49})},
        [],
    ),
    "steel": ({}, []),
    "E in psi": ({"material": steel(30e6), "units": "lbf, in, psi"}, []),
    "units of one's own": ({"material": steel(1.0), "units": "F, L, S"}, []),
    "a small roller": (
        {"profile": Hertz(radius=0.01)},
        ["p0/E* = 0.149", "slope at the edge 0.297", "Are the loads N per mm"],
    ),
}


@pytest.mark.parametrize("case", REMARKED)
def test_what_looks_like_a_slip_of_units_is_remarked_and_not_refused(case: str) -> None:
    changes, words = REMARKED[case]
    scene = pressed(8e-5 if case in ("rubber", "units of one's own") else 80.0, **changes)
    remarks_made = remarks_on_input(scene, largest_contact(scene, "mine"))
    assert len(remarks_made) == bool(words), remarks_made
    assert all(word in remarks_made[0] for word in words)


BLOCK = Block(width=20.0, height=8.0)
REFUSED = {
    "a pad narrower than its contact": (
        pressed(8.0, bodies=Bodies(lower=BLOCK, upper=Pad(width=0.1, height=8.0))),
        "the end of the narrower face, at |x| = 0.05",
    ),
    "a pad as deep as it is high": (
        pressed(
            8.0,
            profile=Hertz(radius=6.0),
            bodies=Bodies(lower=BLOCK, upper=Pad(width=11.0, height=3.0)),
        ),
        "bodies.upper.height = 3 is refused: the pad's face goes as deep at its sides",
    ),
    "rollers and nothing else": (
        pressed(
            8.0, bodies=Bodies(lower=BLOCK, upper=Block(width=20.0, height=8.0, base="rollers"))
        ),
        "bodies.upper: nothing holds the block against the tangential load",
    ),
    "rows that end in the contact": (
        pressed(80.0, profile=Tabulated(points=[[0, 0], [0.1, 5e-6], [0.2, 2e-5]])),
        "needs a contact wider than the table",
    ),
    "rows in steps": (
        pressed(
            80.0,
            profile=Tabulated(
                points=[[0.03 * k, round(9e-4 * k * k / 2000, 5)] for k in range(101)]
            ),
        ),
        "the contact would split near a half-width of",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_check_refuses_what_run_refuses_in_the_same_sentence(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And run does before it solves anything."""
    scene, words = REFUSED[case]
    scene.save(tmp_path / "mine.json")
    if "rows" in case:
        monkeypatch.setattr(
            "halfplane_fe.solve", lambda *_, **__: pytest.fail("finite elements were solved first")
        )
    refusals = [
        refused(tmp_path, "check", "mine.json"),
        refused(tmp_path, "run", "mine.json", "--quiet"),
    ]
    assert words in refusals[0]
    assert refusals[0] == refusals[1]
    assert ("`halfplane exact mine.json` gives half-plane theory's answer" in refusals[0]) == (
        "rows" not in case
    )


CORNERS = {
    "kind": "polygon",
    "initial_loading": [(90.0, 0.0), (90.0, 25.0)],
    "cycle": [(90.0, 0.0), (90.0, -25.0), (90.0, 0.0)],
}
OUT_OF_PHASE = CORNERS | {"bulk_stress_lower": (0.0, 0.0, 20.0, 0.0, -20.0)}


DENTED = EvenPolynomial(length=1.0, rises=(5e-4, -2.4e-4, 5e-5))
ALONE = {
    "a tilt of what bends down": (
        "fe",
        {"load": CORNERS | {"tilt": 1e-4}, "profile": DENTED},
        "profile: it bends down near x = 0.979796",
    ),
    "nearly no load": (
        "exact",
        {
            "load": {
                "mean_normal_load": 1.0,
                "normal_amplitude": 1 - 1e-12,
                "mean_tangential_load": 0.0,
                "tangential_amplitude": 0,
            }
        },
        "finite elements can't tell from separation",
    ),
}


@pytest.mark.parametrize("case", ALONE)
def test_a_scene_that_one_engine_alone_takes_is_checked_and_gets_its_answer(
    case: str, tmp_path: Path
) -> None:
    """`check` says which, why and by which command; `run` gives that answer with the sentence, and
    no comparison.
    """
    command, changes, words = ALONE[case]
    BASE.vary(**changes, name="mine", expected=()).save(tmp_path / "mine.toml")
    checked = halfplane(tmp_path, "check", "mine.toml")
    alone = next(line[8:-1] for line in checked.stdout.splitlines() if "alone take" in line)
    assert (checked.returncode, words in alone, f"`halfplane {command} mine.toml`" in alone) == (
        0,
        True,
        True,
    )
    answer_of_check = json.loads(halfplane(tmp_path, "check", "mine.toml", "--json").stdout)[
        "result"
    ]
    refusing, taking = (
        ("half_plane", "finite_elements") if command == "fe" else ("finite_elements", "half_plane")
    )
    assert words in answer_of_check["engines"][refusing]
    assert answer_of_check["engines"][taking] == ""
    # Bulk stress moves no pressure; nor does theory know a pressure under a tilt that it does not
    # take.
    assert (answer_of_check["largest_contact"] is None) == ("tilt" in case or "moment" in case)
    refusal = refused(tmp_path, "run", "mine.toml", "--quiet", "--budget")
    assert refusal.endswith(
        f"mine.toml: --budget goes with a comparison of both engines: leave it out. {alone}"
    )
    outcome = halfplane(tmp_path, "run", "mine.toml", "--json", "--quiet", *COARSE)
    answer = json.loads(outcome.stdout)
    require_schema(answer)
    assert (outcome.returncode, outcome.stderr) == (0, f"halfplane: mine: no comparison. {alone}\n")
    assert (answer["command"], answer["exit_code"]) == (command, 0)
    assert alone in answer["result"]["notes"]
    assert answer["result"]["dissipation"] >= 0
    assert ContactSolution.load(tmp_path / answer["result"]["file"]).record.notes[-1] == alone


def test_what_neither_engine_takes_is_refused_with_both_reasons(tmp_path: Path) -> None:
    held = Bodies(lower=Block(width=20.0, height=8.0, sides="guided"))
    BASE.vary(load=OUT_OF_PHASE, profile=DENTED, bodies=held, name="mine").save(
        tmp_path / "mine.toml"
    )
    refusal = refused(tmp_path, "check", "mine.toml")
    assert "nothing pulls the ends of the lower body" in refusal
    require_facts(refusal, "half-plane theory refuses", "profile: it bends down near x = 0.979796")
    assert refused(tmp_path, "run", "mine.toml", "--quiet") == refusal


def test_a_record_too_long_for_finite_elements_is_checked_without_them(tmp_path: Path) -> None:
    time = np.arange(10_001.0)
    rows = np.stack([time, 80 + 8 * np.cos(time), 8 * np.sin(time)], axis=1)
    BASE.vary(load=TimeSeriesLoad(rows=rows)).save(tmp_path / "mine.json")
    outcome = halfplane(tmp_path, "check", "mine.json")
    assert outcome.returncode == 0
    require_facts(outcome.stdout, "Remark: ", "10001 rows", "finite elements")


ROWS = MeasuredLoop("rig", np.zeros(1), np.zeros(1), np.zeros(1))
KNOW_P_AND_Q_ALONE = {
    "a measured loop": (
        lambda scene: score_loop(ROWS, scene),
        "no measured loop is scored with bulk stress",
    ),
    "friction_from": (
        lambda scene: semi_analytic.friction_from(0.1, scene=scene),
        "without bulk stress and tilt",
    ),
    "hysteresis": (
        lambda scene: semi_analytic.hysteresis(semi_analytic.solve(scene, x=[0.0])),
        "is not the dissipation",
    ),
}


@pytest.mark.parametrize("caller", KNOW_P_AND_Q_ALONE)
def test_what_knows_p_and_q_alone_refuses_bulk_stress_in_a_sentence(caller: str) -> None:
    call, words = KNOW_P_AND_Q_ALONE[caller]
    load = {
        "kind": "polygon",
        "initial_loading": [(90.0, 0.0), (90.0, 25.0)],
        "cycle": [(90.0, -25.0)],
    }
    with pytest.raises(InputError, match=words):
        call(BASE.vary(load=load | {"bulk_stress_lower": (0.0, 10.0, -10.0)}))


# ------- measured loads: cycles of the standard, work that adds up, noise that is seen and measured
SCRIPT = ROOT / "docs" / "examples" / "measured" / "make.py"
RIG = load_scene("hertz-paper").vary(friction=0.6)
# ASTM E1049-85, 5.4.4, figure 6: the history and the table of counts.
HISTORY = [-2.0, 1, -3, 5, -1, 3, -4, 4, -2]
COUNTS = {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


def of_rows(rows: Any, **keys: Any) -> Scene:
    return RIG.vary(load=TimeSeriesLoad(rows=np.asarray(rows).tolist(), **keys))


def test_cycles_are_those_of_the_standard_and_lie_within_one_another() -> None:
    assert dict(count_cycles(HISTORY)) == COUNTS
    # a work of 1 for each unit of the way
    time = np.arange(9.0)
    so_far = np.abs(np.diff(HISTORY, prepend=-2.0)).cumsum()
    rows = list(cycles_with_work(rainflow_cycles(time, np.array(HISTORY)), time, so_far))
    counts: dict[float, float] = {}
    for cycle in rows:
        counts[cycle.range] = counts.get(cycle.range, 0.0) + cycle.count
        # there and back for a closed one
        assert cycle.dissipation == pytest.approx(2 * cycle.count * cycle.range)
    assert counts == COUNTS
    (closed,) = [cycle for cycle in rows if cycle.count == 1]
    # from -1 to 3 and back to -1 on the way to -4
    assert (closed.start, closed.end) == (4.0, 5 + 4 / 7)


def test_the_work_of_a_closed_cycle_is_that_of_the_cycle_alone() -> None:
    """At constant P: the memory of the outer swing does not change what a swing within it
    dissipates (Masing).
    """
    rows = [
        [0, 90, 0],
        [1, 90, 30],
        [2, 90, -25],
        [3, 90, 20],
        [4, 90, -5],
        [5, 90, 25],
        [6, 90, -25],
    ]
    cycles = load_cycles(semi_analytic.solve(of_rows(rows)))
    (inner,) = [cycle for cycle in cycles.cycles if cycle.count == 1 and cycle.range == 25]
    alone = RIG.vary(
        load=PolygonLoad(initial_loading=[(90, 0), (90, 30), (90, 20)], cycle=[(90, -5)])
    )
    assert inner.dissipation == pytest.approx(semi_analytic.solve(alone).dissipation, rel=1e-9)
    assert (inner.start, inner.end) == (3.0, pytest.approx(4 + 25 / 30))


def test_a_record_that_repeats_has_the_cycles_of_its_last_round() -> None:
    rows = [[0, 90, 0], [1, 90, 30], [2, 90, 10], [3, 90, 20], [4, 90, -30], [5, 90, 0]]
    solution = semi_analytic.solve(of_rows(rows, repeats=True))
    cycles = load_cycles(solution)
    assert cycles.cumulative[-1] == pytest.approx(solution.dissipation, rel=1e-12)
    # All are closed: the largest from peak to peak, and the one within it.
    assert sorted((cycle.range, cycle.count) for cycle in cycles.cycles) == [(10, 1), (60, 1)]
    assert cycles.per_cycle == pytest.approx(solution.dissipation / 2, rel=1e-12)
    assert cycles.last_whole is None
    assert load_cycles(semi_analytic.solve("hertz-paper")) is None


@pytest.mark.parametrize("revolutions", [2, 3, 7])
def test_a_record_answered_at_more_revolutions_than_it_needs_has_the_same_cycle(
    revolutions: int,
) -> None:
    """As beside finite elements that settle later."""
    rows = [[0, 90, 0], [1, 90, 30], [2, 90, 10], [3, 90, 20], [4, 90, -30], [5, 90, 0]]
    scene = of_rows(rows, repeats=True)
    own = load_cycles(semi_analytic.solve(scene))
    time = np.linspace(0.0, 5.0 * revolutions, 11 * revolutions + 1)
    cycles = load_cycles(semi_analytic.solve(scene, time=time))
    assert np.min(np.diff(cycles.cumulative)) >= 0
    np.testing.assert_allclose(cycles.cumulative, own.cumulative, rtol=1e-12, atol=1e-18)
    assert cycles.counted == own.counted


def test_a_record_that_does_not_repeat_states_the_work_of_its_last_whole_cycle() -> None:
    """Steady cycles after a quarter of the first: their own W, not the mean of all counted ones."""
    steady = semi_analytic.solve(
        RIG.vary(load=PolygonLoad(initial_loading=[(90, 0), (90, 30)], cycle=[(90, -30)]))
    )
    rows = [[0, 90, 0], [1, 90, 30], [2, 90, -30], [3, 90, 30], [4, 90, -30], [5, 90, 0]]
    cycles = load_cycles(semi_analytic.solve(of_rows(rows)))
    last = cycles.last_whole
    assert (last.start, last.end, last.range, last.mean) == (2.0, 4.0, 60.0, 0.0)
    assert last.dissipation == pytest.approx(steady.dissipation, rel=1e-12)
    assert cycles.per_cycle < 0.9 * last.dissipation
    assert load_cycles(semi_analytic.solve(of_rows(rows[:3]))).last_whole is None


def noisy(size: float, rows: int = 4000, seed: int = 1) -> np.ndarray:
    time = np.linspace(0, 10, rows)
    loads = np.column_stack(
        [90 + 10 * np.sin(2 * np.pi * time + 0.4), 20 * np.sin(2 * np.pi * time)]
    )
    return np.column_stack(
        [time, loads + size * np.random.default_rng(seed).normal(size=(rows, 2))]
    )


@pytest.mark.parametrize(
    ("size", "warned"), [(0.0, False), (0.02, False), (0.2, True), (0.5, True)]
)
def test_what_noise_makes_of_the_work_is_found_and_warned_of(size: float, warned: bool) -> None:
    """Against the same record without noise; the share is that of the means, so a little less than
    all of it.
    """

    def work(rows: np.ndarray) -> float:
        return semi_analytic.solve(
            of_rows(rows), x=[0.0], time=rows[[0, -1], 0], fields=("dissipation",)
        ).dissipation

    scene = of_rows(noisy(size))
    check = check_record(scene)
    true = work(noisy(size)) / work(noisy(0.0)) - 1
    if size:
        assert check.noise == (pytest.approx(size, rel=0.1), pytest.approx(size, rel=0.1))
        assert check.noise_share == pytest.approx(true, rel=0.25, abs=2e-3)
    else:
        assert (check.noise, check.noise_share) == ((0.0, 0.0), None)
    assert any(warning for _, warning in record_in_words(scene, check)) is warned
    if warned:
        mended = check_record(scene.vary(load={"average": check.rows_per_mean}))
        assert mended.work_of_path == pytest.approx(work(noisy(0.0)), rel=0.02)
        assert not any(
            warning
            for _, warning in record_in_words(
                scene.vary(load={"average": check.rows_per_mean}), mended
            )
        )


def test_coarse_or_clean_rows_are_not_taken_for_noise() -> None:
    time = np.arange(400.0)
    for clean in (
        np.sin(0.05 * time),
        np.sin(2.5 * time),
        np.sign(np.sin(0.3 * time)),
        0.0 * time,
        np.round(np.sin(0.05 * time), 2),
    ):
        assert sigma_of_noise(clean) <= 0.01  # a little of rounded rows: their step


def rig_record(slide: float = 1.0) -> TimeSeriesLoad:
    """50 rows a cycle: no load, rest, four cycles that grow, twelve that are alike and drift, rest;
    cycles 8 and 9 are `slide` times as large.
    """
    time = np.arange(1300) / 50
    random = np.random.default_rng(1)
    normal = np.where(time < 2, 0.5, 100.0) + 0.2 * random.standard_normal(len(time))
    cycle = time - 4
    amplitude = np.clip(0.4 + 0.15 * np.floor(cycle), 0.0, 1.0) * np.where(
        (cycle >= 8) & (cycle < 10), slide, 1.0
    )
    moves = (cycle >= 0) & (cycle < 16)
    wave = 30 * amplitude * np.sin(2 * np.pi * cycle) + 0.5 * np.maximum(cycle - 4, 0.0)
    tangential = np.where(moves, wave, 0.0) + 0.1 * random.standard_normal(len(time))
    return TimeSeriesLoad(rows=np.column_stack([time, normal, tangential]), least_normal_load=5.0)


def test_parts_of_a_record_that_are_no_cycle_are_named_with_their_rows() -> None:
    scene = load_scene("hertz-paper").vary(load=rig_record(), friction=0.6)
    parts = {part.kind: part for part in record_parts(scene)}
    places = {"no load": (1, 100), "other cycles": (230, 412), "alike": (412, 988)}
    places |= {"drift": (412, 988), "rest": (1001, 1300)}
    for kind, place in places.items():
        assert (parts[kind].first_row, parts[kind].last_row) == pytest.approx(place, abs=30), kind
    said = " ".join(sentence.text for sentence in record_in_words(scene, check_record(scene)))
    require_facts(said, "run-in", "at rest", "12 cycles that are alike", "load.start = {row = ")
    # means of many rows would take the noise out of P, and Q with it
    assert check_record(scene).rows_per_mean <= 2
    # the part alone has no other parts
    alike = parts["alike"]
    cut = scene.vary(load={"start": {"row": alike.first_row}, "end": {"row": alike.last_row}})
    assert {part.kind for part in record_parts(cut)} == {"alike", "drift"}


def test_cycles_that_slide_as_a_whole_are_named_with_rows_and_cures() -> None:
    scene = load_scene("hertz-paper").vary(load=rig_record(slide=2.2), friction=0.6)
    with pytest.raises(InputError) as caught:
        require_admissible(scene, "mine")
    require_facts(
        str(caught.value), "slide as a whole, in 4 strokes", "tangential_displacement = true"
    )
    end = int(re.search(r"load\.end = \{row = (\d+)\}", str(caught.value))[1])
    start = int(re.search(r"load\.start = \{row = (\d+)\}", str(caught.value))[1])
    assert 600 <= end < start <= 701
    for cut in ({"end": {"row": end}}, {"start": {"row": start}}):
        require_admissible(scene.vary(load=cut), "mine")


def test_a_threshold_that_changes_the_work_is_warned_of() -> None:
    scene = of_rows(noisy(0.0), reduce="tolerance", threshold={"P": 3, "Q": 3})
    check = check_record(scene)
    warnings = dict(record_in_words(scene, check))
    first, second = warnings
    assert (
        f"The path goes through {check.n_path_rows:,} of 4,000 rows: by half-plane theory W = "
        in first
    )
    assert second.startswith("With half the threshold W changes by +")
    assert list(warnings.values()) == [True, True]
    fine = of_rows(noisy(0.0), reduce="tolerance", threshold={"P": 0.01, "Q": 0.01})
    record = check_record(fine)
    assert not any(warning for _, warning in record_in_words(fine, record))


def examples() -> Any:
    """What the script that made the example files holds."""
    return SimpleNamespace(**run_path(str(SCRIPT)))


def test_check_says_how_each_column_of_a_loop_is_read(tmp_path: Path) -> None:
    """And refuses what `score --as loop` would refuse."""
    angle = 0.1 * np.arange(200)
    rows = "\n".join(f"{2 * s:.5f};{96 * s:.5f}".replace(".", ",") for s in np.sin(angle).tolist())
    (tmp_path / "loop.csv").write_text(f"Displacement [µm];Force [N]\n{rows}\n", encoding="utf-8")
    (tmp_path / "map.toml").write_text(
        "thickness = 8.0\n[columns]\ntangential_load = 'Force [N]'\n", encoding="utf-8"
    )
    loop = ("--loop", "loop.csv")
    words = ("check", "cattaneo-mindlin", "--json", *loop, "--mapping", "map.toml")
    answer = json.loads(halfplane(tmp_path, *words).stdout)["result"]
    assert dict(answer["read_as"]["loop.csv"]) == {
        "file": "loop.csv: 200 rows from line 2 on",
        "columns separated by": "semicolon",
        "decimal sign": "comma",
        "relative displacement U": "'Displacement [µm]', µm (in its heading), times 0.001",
        "tangential load Q": "'Force [N]', N (in its heading), times 1, over the thickness 8",
        "time": "no column: rows follow each other evenly",
    }
    (note,) = [note for note in answer["notes"] if "as it was read" in note]
    assert "Tangential load Q: 'Force [N]', N (in its heading)" in note
    (tmp_path / "map.toml").write_text("[columns]\ntangential_load = 'Force [N]'\n")
    refused = halfplane(tmp_path, *words)
    assert refused.returncode == 2
    assert "or the thickness of the contact" in refused.stderr
    alone = halfplane(tmp_path, "check", "cattaneo-mindlin", "--mapping", "map.toml")
    assert alone.returncode == 2
    assert "name the loop by --loop" in alone.stderr
    no_cycle = halfplane(tmp_path, "check", "hertz-normal", *loop)
    assert "its loads do not repeat" in no_cycle.stderr


def test_every_example_file_is_read_as_the_record_that_it_holds(tmp_path: Path) -> None:
    makers = examples()
    makers.main(tmp_path)
    shutil.copy(ROOT / "scenes" / "library" / "time-series.csv", tmp_path)
    text = (ROOT / "scenes" / "library" / "time-series.toml").read_text("utf-8")
    for name, keys in makers.SCENES.items():
        table = "profile" if "tabulated" in keys else "load"
        start = text.index(f"[{table}]")
        end = text.find("\n[", start + 1)
        text_of_scene = (
            f'{text[:start]}[{table}]\nfile = "{name}"\n{keys}\n{text[end:] if end > 0 else ""}'
        )
        (tmp_path / "scene.toml").write_text(
            text_of_scene.partition("\n[[expected]]")[0], encoding="utf-8"
        )
        scene = load_scene(tmp_path / "scene.toml")
        if table == "profile":
            x = np.linspace(-1.5, 1.5, 61)
            np.testing.assert_allclose(
                scene.profile.points.values, np.column_stack([x, x**2 / 2000]), atol=1e-9
            )
        elif name == "noisy.csv":
            assert np.std(scene.load.rows.values - makers.record(2000), axis=0)[
                1:
            ] == pytest.approx([0.3, 0.3], rel=0.05)
        else:
            np.testing.assert_allclose(
                scene.load.rows.values, makers.record(161), atol=6e-3, err_msg=name
            )
        assert dict(getattr(scene, table).read_as)["file"].startswith(name)


def test_reports_of_abaqus_are_scored_as_the_theory_that_they_hold(tmp_path: Path) -> None:
    """One made like those of its users: both parts, nodes within them, three frames."""
    makers = examples()
    makers.main(tmp_path)
    scene = load_scene(makers.RESULT)
    x = np.linspace(-1.2, 1.2, 61)
    exact = semi_analytic.solve(scene, x=x, time=makers.TIMES, fields=("pressure", "shear"))
    for name in makers.REPORTS:
        table = read_result(tmp_path / name, Mapping(times=makers.TIMES))
        for quantity in ("x", "time", "pressure", "shear"):
            np.testing.assert_allclose(
                getattr(table, quantity),
                getattr(exact, quantity),
                rtol=1e-5,
                atol=1e-5,
                err_msg=name,
            )
        report = score_file(tmp_path / name, Mapping(times=makers.TIMES), scene)
        # Three instants hold no cycle: the dissipation has a tolerance and no value, so the whole
        # has not passed.
        assert "outside" not in {metric.verdict for metric in report.comparison.metrics}
        assert report.comparison.admissible
        assert abs(report.metric("peak_pressure").value) < 1e-5
    field = read_result(tmp_path / "field.rpt", Mapping())
    assert field.time.tolist() == list(makers.TIMES)
    assert field.notes[:2] == (
        "the nodal values of BLOCK-1 were taken, at 3 frames",
        "61 nodes that do not lie on the contact surface were left out",
    )


REPORTED = {
    "two surfaces": (
        ("PAD-1", "BLOCK-1"),
        "'BLOCK-1', 'PAD-1' carry pressure",
    ),
    "elements": (
        ("at nodes for part", "at integration points for part"),
        "its values are reported at integration points",
    ),
    "no places": (
        ("COORD.COORD1", "S.S11"),
        "the nodes of BLOCK-1 have no places",
    ),
    "no pressure": (
        ("CPRESS", "S.S22"),
        "(looked for CPRESS)",
    ),
    "a word": (("-1.16000", "NoValue"), "COORD1 = 'NoValue' is not a finite number"),
    "a short row": (
        ("          -1.16000", ""),
        "5 values (Node Label, COORD1, COORD2, CPRESS, CSHEAR1)",
    ),
    "no table": (("-" * 90, "="), "no table of values"),
}


@pytest.mark.parametrize("fault", REPORTED)
def test_each_fault_of_a_report_is_one_sentence(fault: str, tmp_path: Path) -> None:
    examples().main(tmp_path)
    path = tmp_path / "field.rpt"
    (old, new), words = REPORTED[fault]
    text = path.read_text("utf-8")
    # Of two surfaces: what is the block's at the first frame is the pad's.
    path.write_text(
        text.replace(new, old, 1) if fault == "two surfaces" else text.replace(old, new),
        encoding="utf-8",
    )
    with pytest.raises(InputError) as caught:
        read_result(path, Mapping())
    assert words in str(caught.value)
    assert str(caught.value).startswith(str(path))


def test_check_exact_json_and_page_say_how_a_record_was_read_and_what_its_cycles_dissipate(
    tmp_path: Path,
) -> None:
    scene = of_rows(noisy(0.5, 800), reduce="turning_points", threshold={"P": 1, "Q": 1})
    path = tmp_path / "noisy.json"
    rows = "\n".join(
        f"{t:.4f};{p:.4f};{q:.4f}".replace(".", ",") for t, p, q in scene.load.rows.values
    )
    (tmp_path / "noisy.csv").write_text(f"Time [s];FN [N/mm];FT [N/mm]\n{rows}\n", encoding="utf-8")
    keys = json.loads(
        scene.vary(load={"rows": [[0, 1, 0], [1, 1, 0]]}).model_dump_json(exclude_none=True)
    )
    keys["load"] = {
        "kind": "time_series",
        "file": "noisy.csv",
        "reduce": "turning_points",
        "threshold": {"P": 1, "Q": 1},
    }
    path.write_text(json.dumps(keys), encoding="utf-8")
    answer = json.loads(halfplane(tmp_path, "check", str(path), "--json").stdout)["result"]
    (read,) = [note for note in answer["notes"] if "as it was read" in note]
    assert (
        "Columns separated by: semicolon. Decimal sign: comma. Time: 'Time [s]', s (in its"
        " heading), times 1." in read
    )
    assert any("The path goes through" in words for words in answer["remarks"])
    answer = json.loads(
        halfplane(
            tmp_path, "exact", str(path), "--json", "--quiet", "--out", str(tmp_path / "exact")
        ).stdout
    )["result"]
    cycles = answer["load_cycles"]
    assert cycles["cumulative"]["dissipation"][-1] == pytest.approx(
        answer["dissipation"], rel=1e-12
    )
    assert cycles["dissipation_per_cycle"] * cycles["counted"] == pytest.approx(
        answer["dissipation"], rel=1e-12
    )
    loaded = load_scene(path)
    exact = semi_analytic.solve(
        loaded, x=np.linspace(-1.2, 1.2, 41), time=loaded.load.series()[::40, 0]
    )
    page = reports.write(reports.compare(exact, exact), tmp_path / "out")
    html = page.read_text("utf-8")
    content = json.loads((page.parent / "comparison.json").read_text("utf-8"))
    assert 'id="measured"' in html
    assert "Dissipation of each load cycle" in html
    drawn = (page.parent / "figures" / "cumulative_work.csv").read_text("utf-8").splitlines()
    last_work = float(drawn[-1].split(",")[1])
    assert last_work == pytest.approx(load_cycles(exact).cumulative[-1], rel=1e-6)
    assert content["measured"]["read_as"]["load.file"][1] == ["columns separated by", "semicolon"]
    assert content["measured"]["loads"]["kept"] == len(loaded.load.kept_rows())
    assert content["reference"]["load_cycles"]["counted"] == cycles["counted"]


# ------------------------------------------------------------------------------ units beside bodies
UNITS = {
    "E in GPa": (
        {"material": {"young_modulus": 210.0}},
        20.0,
        "young_modulus = 210 MPa is as soft as a weak plastic",
    ),
    "loads in N": (
        {"load": {"mean_normal_load": 9000.0, "normal_amplitude": 3000.0}},
        20.0,
        "Check the units first",
    ),
    "width in m": (
        {},
        20e-3,
        "loads are in N per mm of thickness, E is in MPa, sizes are in mm",
    ),
}


@pytest.mark.parametrize("case", UNITS)
def test_a_slip_of_units_beside_bodies_is_remarked_first_and_nothing_is_meshed(case, monkeypatch):
    """And the sentence says by how much the contact is too wide; no finite element is made for
    it.
    """
    changes, width, words = UNITS[case]
    scene = load_scene("hertz-paper").vary(
        material={"young_modulus": 210e3, "poisson_ratio": 0.3},
        load={
            "kind": "ellipse",
            "mean_normal_load": 90.0,
            "normal_amplitude": 30.0,
            "tangential_amplitude": 30.0,
        },
        bodies=Bodies(lower=Block(width=40.0, height=20.0), upper=Pad(width=width, height=15.0)),
        expected=(),
    )
    scene = scene.vary(**changes)
    meshed = []
    monkeypatch.setattr(halfplane_fe, "require_solvable", meshed.append)
    with pytest.raises(InputError) as fault:
        engine_refusals(scene, "mine.toml")
    sentence = str(fault.value)
    assert not meshed
    assert sentence.startswith("mine.toml: ")
    assert words in sentence
    ratio = largest_contact(scene, "").half_width / (width / 2)
    assert f"which is {ratio:.3g} times that" in sentence
    assert sentence.index("units first") < sentence.index("make the bodies wider")


def test_a_friction_coefficient_in_per_cent_is_remarked():
    scene = pressed(80.0).vary(friction=60.0)
    assert "60 % is 0.6" in remarks_on_input(scene, largest_contact(scene, ""))[0]
    assert not remarks_on_input(scene.vary(friction=1.5), largest_contact(scene, ""))


# ------------------------------------------------------------------ room for the contact, estimated
LAYERS = [
    # upper body, base of the layer, h over a of half-planes, width of the faces, unlike materials
    ("half_plane", "fixed", 0.1, 20.0, False),
    ("pad", "rollers", 1.0, 6.0, True),
]
MORE_LAYERS = [
    pytest.param((upper, base, height, width, unlike), marks=pytest.mark.slow)
    for upper in ("half_plane", "block", "pad")
    for base in ("fixed", "rollers")
    for height in (0.1, 0.2, 0.5, 1.0, 2.0)
    for width in (3.0, 6.0, 20.0)
    for unlike in (False, True)
]


def layer(upper: str, base: str, height: float, width: float, unlike: bool) -> Scene:
    """A parabola on a layer under shear; a = 1 on half-planes of the upper material."""
    steel = {"young_modulus": 210e3, "poisson_ratio": 0.3}
    polymer = {"young_modulus": 3e3, "poisson_ratio": 0.45}
    lower = Block(
        width=width, height=height, base=base, sides="guided" if base == "rollers" else "free"
    )
    bodies = {
        "half_plane": Bodies(lower=lower),
        "block": Bodies(lower=lower, upper=Block(width=width, height=10.0)),
        "pad": Bodies(lower=lower, upper=Pad(width=width, height=10.0)),
    }
    largest = np.pi * 210e3 / (2 * (1 - 0.3**2)) / 400.0
    return load_scene("hertz-paper").vary(
        material={"upper": steel, "lower": polymer if unlike else steel},
        profile={"kind": "hertz", "radius": 100.0},
        friction=0.5,
        load={
            "kind": "ellipse",
            "mean_normal_load": 0.75 * largest,
            "normal_amplitude": 0.25 * largest,
            "mean_tangential_load": 0.0,
            "tangential_amplitude": 0.25 * largest,
            "phase_degrees": 60.0,
            "initial_loading": "straight",
        },
        bodies=bodies[upper],
        expected=(),
    )


def half_width_and_reach(of: Callable[..., Any], scene: Scene) -> tuple[float, float] | str:
    """The sentence where the contact is refused."""
    try:
        size_of_contact = of(scene, Counter())
    except InputError as fault:
        return str(fault)
    sizes = getattr(size_of_contact, "scales", size_of_contact)
    return sizes.half_width, sizes.reach


@pytest.mark.parametrize("case", [*LAYERS, *MORE_LAYERS])
def test_the_estimate_of_the_room_is_near_what_the_coarse_run_finds(case) -> None:
    estimate = half_width_and_reach(estimate_room, layer(*case))
    coarse = half_width_and_reach(find_scales, layer(*case))
    if isinstance(coarse, str):
        assert estimate == coarse
        assert "reaches past the end of the narrower face" in coarse
    else:
        assert estimate[0] == pytest.approx(coarse[0], rel=0.01)
        assert estimate[1] == pytest.approx(coarse[1], rel=0.05)


@pytest.mark.parametrize("bulk", [{}, {"bulk_stress_lower": [*range(400)]}])
def test_of_a_long_record_the_rows_of_extreme_loads_count(bulk) -> None:
    """The largest and the smallest P, Q, Q/P and bulk stress; the path starts and ends as ever."""
    time = np.arange(400.0)
    normal = 60 + 30 * np.sin(0.11 * time)
    rows = np.column_stack([time, normal, 0.3 * normal * np.sin(0.23 * time)])
    scene = load_scene("pad-on-block").vary(load=TimeSeriesLoad(rows=rows, **bulk), expected=())
    load = scales._with_extreme_rows(scene).load
    short = load.rows.values
    assert len(short) <= 10
    for values, extremes in (
        (rows[:, 1], short[:, 1]),
        (rows[:, 2], short[:, 2]),
        (rows[:, 2] / rows[:, 1], short[:, 2] / short[:, 1]),
    ):
        assert (extremes.min(), extremes.max()) == (values.min(), values.max())
    assert short[[0, -1]].tolist() == rows[[0, -1]].tolist()
    if bulk:
        assert load.bulk_stress_lower == tuple(short[:, 0].tolist())
    assert scales._with_extreme_rows(load_scene("pad-on-block")) == load_scene("pad-on-block")
