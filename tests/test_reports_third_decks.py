"""Third solver: decks read by a strict parser, a script in CalculiX' place, and (slow) CalculiX
itself on the decks.
"""

from __future__ import annotations

import json
import math
import shutil
import signal
import subprocess
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from refusals import refused_for
from reports import cli
from reports.console import Stages
from reports.studies.third.calculix import (
    ThirdSolver,
    calculix_version,
    find_calculix,
    run_calculix,
    solve_with_calculix,
)
from reports.studies.third.deck import Deck, DeckSettings, build_deck, deck_text
from scenes import ConvergenceError, InputError, load_scene, scene_names

COARSE = DeckSettings(
    element_size=1 / 8, edge_element_size=1 / 16, far_radius=20.0, growth=0.6, steps_per_cycle=16
)
SCENES = (
    "hertz-paper",
    "cattaneo-mindlin",
    "pad-on-block",
    "layer",
    "cylinder-roller-frictionless",
)

# Every keyword that a deck may have: parameters needed and allowed ("?"), and the kinds of the
# entries of a data line: i integer, f number with a point, w word, "+" any count of the one before;
# none: no data line.
KEYWORDS: dict[str, tuple[str, str | None]] = {
    "HEADING": ("", None),
    "NODE": ("NSET", "ifff"),
    "ELEMENT": ("TYPE ELSET", "iiiii"),
    "NSET": ("NSET", "i+"),
    "SURFACE": ("NAME TYPE", "iw"),
    "MATERIAL": ("NAME", ""),
    "ELASTIC": ("", "ff"),
    "SOLID SECTION": ("ELSET MATERIAL", "f"),
    "SURFACE BEHAVIOR": ("PRESSURE-OVERCLOSURE", "f"),
    "CONTACT PAIR": ("INTERACTION TYPE", "ww"),
    "EQUATION": ("", "i|iifiif|iifiifiif|iifiifiifiif"),
    "DLOAD": ("AMPLITUDE", "iwf"),
    "AMPLITUDE": ("NAME TIME", "f+"),
    "STEP": ("NLGEOM INC", ""),
    "STATIC": ("", "ffff"),
    "BOUNDARY": ("?OP ?AMPLITUDE", "ii|iiif"),
    "CLOAD": ("AMPLITUDE", "iif"),
    "END STEP": ("", ""),
    "SURFACE INTERACTION": ("NAME", ""),
    "FRICTION": ("", "ff"),
    "CONTROLS": ("PARAMETERS", "n+"),
    "CONTACT FILE": ("FREQUENCY", "w+"),
    "CONTACT PRINT": ("SLAVE MASTER FREQUENCY", "w+"),
    "NODE PRINT": ("NSET FREQUENCY", "w+"),
}
IN_STEP = {"STATIC", "CLOAD", "DLOAD", "CONTROLS", "END STEP"}
BEFORE_STEPS = {
    "NODE",
    "ELEMENT",
    "NSET",
    "SURFACE",
    "MATERIAL",
    "ELASTIC",
    "EQUATION",
    "AMPLITUDE",
    "CONTACT PAIR",
}

Card = tuple[str, dict[str, str], list[list[str]]]


def parse(text: str) -> list[Card]:
    """(keyword, parameters, data lines) of a deck; ValueError at the first line outside the closed
    set.
    """
    cards: list[Card] = []
    inside = False
    for line in text.splitlines():
        words = [word.strip() for word in line.lstrip("*").split(",")]
        if len(line) > 132:
            raise ValueError(f"{len(line)} characters: {line}")
        if line.startswith("**"):
            continue
        if not line.startswith("*"):
            cards[-1][2].append(words)
            continue
        if words[0] not in KEYWORDS:
            raise ValueError(f"unknown keyword {words[0]}")
        pairs = [word.partition("=") for word in words[1:]]
        parameters = {key: value for key, _, value in pairs}
        # Parameters are separated by blanks, but the one that has a blank in it.
        known = KEYWORDS[words[0]][0].split()
        needed = {name.replace("_", " ") for name in known if name[0] != "?"}
        if missing := needed - set(parameters):
            raise ValueError(f"*{words[0]} lacks {missing}")
        if unknown := set(parameters) - needed - {name[1:] for name in known}:
            raise ValueError(f"*{words[0]} has no parameter {unknown}")
        if words[0] == "STEP" and inside:
            raise ValueError("a step inside a step")
        if (words[0] in IN_STEP and not inside) or (words[0] in BEFORE_STEPS and inside):
            raise ValueError(f"*{words[0]} on the wrong side of *STEP")
        inside = (inside or words[0] == "STEP") and words[0] != "END STEP"
        cards.append((words[0], parameters, []))
    if inside:
        raise ValueError("the last step does not end")
    for keyword, _, lines_of_data in cards:
        kinds = KEYWORDS[keyword][1]
        if kinds is not None and bool(lines_of_data) != bool(kinds):
            raise ValueError(f"*{keyword} with {len(lines_of_data)} data lines")
        for row in lines_of_data if kinds is not None else []:
            check_row(keyword, row, kinds or "")
    return cards


def check_row(keyword: str, row: list[str], kinds: str) -> None:
    lengths = {len(form): form for form in kinds.split("|")}
    form = kinds[0] * len(row) if kinds.endswith("+") else lengths.get(len(row))
    if form is None:
        raise ValueError(f"*{keyword}: {len(row)} entries in {row}")
    for word, kind in zip(row, form, strict=True):
        good = len(word) <= 20
        if kind == "w":
            good &= word.replace("_", "A").isupper()
        elif kind == "i":
            good &= word.isdigit()
        else:
            good &= math.isfinite(float(word)) and (kind == "n" or "." in word)
        if not good:
            raise ValueError(f"*{keyword}: {word!r} is no {kind} of at most 20 characters")


@cache
def deck_of(name: str) -> Deck:
    return build_deck(load_scene(name), COARSE)


@cache
def cards_of(name: str) -> list[Card]:
    return parse(deck_text(deck_of(name), "halfplane export", {"halfplane": "0"}))


def data_of(cards: list[Card], keyword: str) -> list[list[str]]:
    return [row for name, _, lines_of_data in cards if name == keyword for row in lines_of_data]


def amplitudes(cards: list[Card]) -> dict[str, np.ndarray]:
    """(n, 2) time and value of each."""
    tables = {}
    for keyword, parameters, lines_of_data in cards:
        if keyword == "AMPLITUDE":
            words = [word for row in lines_of_data for word in row]
            tables[parameters["NAME"]] = np.array(words, float).reshape(-1, 2)
    return tables


@pytest.mark.parametrize("name", SCENES)
class TestText:
    def test_every_name_and_number_that_a_deck_refers_to_is_there(self, name: str) -> None:
        cards = cards_of(name)
        reference = deck_of(name).reference_node
        nodes = {int(row[0]) for row in data_of(cards, "NODE")}
        elements = [list(map(int, row)) for row in data_of(cards, "ELEMENT")]
        assert [row[0] for row in elements] == list(range(1, len(elements) + 1))
        used = {node for row in elements for node in row[1:]}
        assert used | {reference} == nodes == set(range(1, reference + 1))
        sets = {
            parameters["NSET"]: lines_of_data
            for keyword, parameters, lines_of_data in cards
            if keyword == "NSET"
        }
        assert set(sets) == {"LOWER_FACE_NODES", "UPPER_FACE_NODES"}
        for lines_of_data in sets.values():
            members = [int(word) for row in lines_of_data for word in row]
            assert len(members) > 10
            assert set(members) <= used
        names = {
            parameters["NAME"]
            for keyword, parameters, _ in cards
            if keyword.startswith("SURFACE") and "NAME" in parameters
        }
        pair = next(card for card in cards if card[0] == "CONTACT PAIR")
        assert {*pair[2][0], pair[1]["INTERACTION"]} == names
        held = data_of(cards, "BOUNDARY")
        assert {int(row[0]) for row in held} <= nodes
        assert any(row[1] == "2" for row in held)

    def test_amplitudes_are_the_scenes_loads_and_a_step_ends_at_every_instant(
        self, name: str
    ) -> None:
        cards = cards_of(name)
        deck = deck_of(name)
        scene = load_scene(name)
        tables = amplitudes(cards)
        path = scene.load.path()
        time = tables["NORMAL_LOAD"][:, 0] + path.start
        loads = dict(
            zip(
                ("NORMAL_LOAD", "TANGENTIAL_LOAD"),
                path.at(np.minimum(time, deck.time[-1])),
                strict=True,
            )
        )
        for key, values in loads.items():
            assert np.allclose(
                tables[key][:, 1], values, rtol=0, atol=1e-10 * loads["NORMAL_LOAD"].max()
            )
        ends = np.cumsum([float(row[1]) for row in data_of(cards, "STATIC")])
        assert np.allclose(ends[1:], tables["NORMAL_LOAD"][1:, 0], rtol=1e-10), (
            "the first step is the touch"
        )
        assert 0 < ends[0] < ends[1]
        signs = {
            parameters["AMPLITUDE"]: lines_of_data[0]
            for keyword, parameters, lines_of_data in cards
            if keyword == "CLOAD"
        }
        assert signs["NORMAL_LOAD"] == [str(deck.reference_node), "2", "-1."]
        assert ("TANGENTIAL_LOAD" in signs) == (scene.friction.coefficient > 0)


@pytest.mark.parametrize("name", SCENES)
class TestBodies:
    def test_elements_fill_the_bodies_and_the_face_is_one_chain_of_their_sides(
        self, name: str
    ) -> None:
        deck = deck_of(name)
        for body in (deck.lower, deck.upper):
            areas = body.areas()
            assert areas.min() > 0
            x, y = body.nodes[body.elements - body.first_node].mean(1).T
            assert (y.max() < 0) if body is deck.lower else (y.min() > 0)
            assert abs((areas * x).sum() / areas.sum()) < 1e-9 * np.abs(body.nodes).max()
            cells = body.elements[body.contact_faces[:, 0] - body.first_element]
            side = body.contact_faces[:, 1] - 1
            rows = np.arange(len(cells))
            # Anticlockwise: the lower body's face is passed through from right to left, the upper
            # one's from left to right.
            ends = [cells[rows, side], cells[rows, (side + 1) % 4]]
            left, right = ends[::-1] if body is deck.lower else ends
            assert (
                body.nodes[right - body.first_node, 0] > body.nodes[left - body.first_node, 0]
            ).all()
            assert np.array_equal(np.unique([left, right]), np.unique(body.contact_nodes))
            assert len(side) == len(body.contact_nodes) - 1


def test_the_gap_is_the_scenes_profile_and_true_faces_stay_as_they_are_made() -> None:
    """Unequal sides are cut as they are."""
    at = np.linspace(-4.0, 4.0, 161)
    points = np.stack([at, np.where(at < 0, 2e-3, 5e-4) * at**2], axis=1).tolist()
    unequal = load_scene("hertz-paper").vary(
        profile={"kind": "tabulated", "points": points, "symmetric": False}
    )
    for deck, close in (
        (deck_of("hertz-paper"), 1e-15),
        (build_deck(unequal, COARSE, deck_of("hertz-paper").scales), 1e-9),
    ):
        x, y = deck.upper.nodes[deck.upper.contact_nodes - deck.upper.first_node].T
        assert np.allclose(y, deck.scene.profile.height(x), rtol=0, atol=close)
        far = np.abs(deck.upper.nodes[:, 0]) > 3 * x.max()
        assert deck.upper.nodes[far, 1].min() < 4 * y.max(), (
            "the continuation of the gap stays bounded"
        )
    deck = deck_of("cylinder-roller-frictionless")
    x, y = deck.upper.nodes[deck.upper.contact_nodes - deck.upper.first_node].T
    assert np.allclose(y, 50 - np.sqrt(50**2 - x**2), rtol=0, atol=1e-9)


BLOCK = {"kind": "block", "width": 20.0, "height": 8.0}
WAVE = {"mean": 3.0, "amplitude": 20.0, "phase_degrees": 90.0}


def imposed(bodies: dict[str, Any] | None = None, **load: Any) -> Deck:
    """A deck of hertz-paper with bulk stress or tilt; the size of the contact is that without."""
    base = load_scene("hertz-paper")
    scene = base.vary(load=load) if bodies is None else base.vary(load=load, bodies=bodies)
    return build_deck(scene, COARSE, deck_of("hertz-paper").scales)


def moved(
    deck: Deck, text: str, nodes: dict[tuple[int, int], float]
) -> dict[tuple[int, int], float]:
    """What the equations make of (node, direction) by the movements of the nodes that drive
    them.
    """
    movements = {}
    for row in data_of(parse(text), "EQUATION")[1::2]:
        terms = [
            (int(a), int(b), float(c))
            for a, b, c in zip(row[::3], row[1::3], row[2::3], strict=True)
        ]
        first = terms[0]
        movements[first[:2]] = (
            -sum(factor * nodes[node, way] for node, way, factor in terms[1:]) / first[2]
        )
    return movements


@pytest.mark.parametrize(
    "turn",
    [{"tilt": 1e-3}, {"moment": 4.0}, {"line_of_action": {"x": 0.1, "height": 2.0}}, {}],
    ids=str,
)
def test_half_planes_under_bulk_stress_move_by_its_strain_and_the_upper_one_turns(
    turn: dict[str, Any],
) -> None:
    deck = imposed(bulk_stress_lower=WAVE, bulk_stress_upper=-7.0, **turn)
    path = deck.scene.load.path()
    size = deck.scales.half_width
    last = len(deck.time) - 1
    text = deck_text(deck)
    cards = parse(text)
    tables = amplitudes(cards)
    # u = eps (x, -nu/(1 - nu) y) of a uniform stress along x in plane strain, and a turn that opens
    # the gap at x > 0.
    nu = 0.3
    young = 210e3
    time = deck.time[last]
    stresses = 3 + 20 * math.cos(time - math.pi / 2), -7.0
    strains = [stress * (1 - nu**2) / young for stress in stresses]
    for name, strain in zip(("LOWER", "UPPER"), strains, strict=True):
        assert tables[f"{name}_STRAIN"][last, 1] == pytest.approx(strain * size, rel=1e-9)
    nodes = {
        (deck.strain_node, way): strain * size for way, strain in zip((1, 2), strains, strict=True)
    }
    alpha = 1e-3 if "tilt" in turn else 2e-3
    nodes |= {
        (deck.tilt_node, 1): alpha * size * bool(turn),
        (deck.reference_node, 1): 0.02,
        (deck.reference_node, 2): -0.05,
    }
    movements = moved(deck, text, nodes)
    for body, strain, plane, turned in (
        (deck.lower, strains[0], (0.0, 0.0), 0.0),
        (deck.upper, strains[1], (0.02, -0.05), alpha),
    ):
        for way, numbers in body.held.items():
            x, y = body.nodes[numbers - body.first_node].T
            stretched = strain * (x if way == 1 else -nu / (1 - nu) * y)
            expected = (
                plane[way - 1] + stretched + (turned if turn else 0.0) * (-y if way == 1 else x)
            )
            # On the lower arc nothing moves the node at x = 0 along x, which is held.
            by_equation = [movements.get((node, way), 0.0) for node in numbers.tolist()]
            assert by_equation == pytest.approx(expected, rel=1e-9, abs=1e-15)
    assert ("TILT" in tables) == ("tilt" in turn)
    if "tilt" in turn:
        assert tables["TILT"][last, 1] == pytest.approx(1e-3 * size)
    elif turn:
        p, q = path.at(time)
        moment = 4.0 if "moment" in turn else 0.1 * p + 2 * q
        assert tables["MOMENT"][last, 1] == pytest.approx(moment / size, rel=1e-9)
        pushes = [
            row
            for k, parameters, lines_of_data in cards
            if k == "CLOAD" and parameters["AMPLITUDE"] == "MOMENT"
            for row in lines_of_data
        ]
        assert pushes == [[str(deck.tilt_node), "1", "-1."]]  # what M does on -alpha
    # A node that an equation moves is not held as well, and what drives it is.
    held = {(int(row[0]), int(row[1])) for row in data_of(cards, "BOUNDARY")}
    assert {
        (node, way) for way, numbers in deck.lower.held.items() for node in numbers.tolist()
    } <= held | movements.keys()
    assert not held & movements.keys()
    assert {(deck.strain_node, 1), (deck.strain_node, 2)} <= held


def test_the_ends_of_blocks_are_pulled_and_those_on_rollers_hold_the_tangential_load() -> None:
    bodies = {"lower": BLOCK | {"base": "rollers"}, "upper": BLOCK | {"base": "fixed"}}
    deck = imposed(bodies, bulk_stress_lower=WAVE, bulk_stress_upper=5.0)
    cards = parse(deck_text(deck))
    places = np.concatenate([deck.lower.nodes, deck.upper.nodes])
    corners = {int(row[0]): list(map(int, row[1:])) for row in data_of(cards, "ELEMENT")}
    forces = {}
    for keyword, parameters, lines_of_data in cards:
        if keyword == "DLOAD" and parameters["AMPLITUDE"] not in forces:
            total = np.zeros(2)
            for element, face, factor in lines_of_data:
                k = int(face[1:]) - 1
                start, end = (places[corners[int(element)][n] - 1] for n in (k, (k + 1) % 4))
                # corners go round anticlockwise
                inward = np.array([-(end - start)[1], (end - start)[0]])
                total += float(factor) * inward
            forces[parameters["AMPLITUDE"]] = total
    tables = {name: rows[:, 1] for name, rows in amplitudes(cards).items()}
    height = BLOCK["height"]
    for name, force in forces.items():
        side = height if "RIGHT" in name else -height
        # The gap is cut into the upper block, also at its ends.
        assert force == pytest.approx([side, 0.0], rel=1e-9 if "LOWER" in name else 1e-3, abs=1e-12)
    assert set(forces) == {
        f"{body}_{side}_END" for body in ("LOWER", "UPPER") for side in ("LEFT", "RIGHT")
    }
    left, right = (tables[f"LOWER_{side}_END"] for side in ("LEFT", "RIGHT"))
    q = tables["TANGENTIAL_LOAD"]
    stress = deck.bulk_stress[0]
    assert (right - left) * height + q == pytest.approx(0 * q, abs=1e-9), (
        "nothing is left for what keeps it from drifting"
    )
    assert (left + right) / 2 == pytest.approx(stress, abs=1e-9)
    assert tables["UPPER_LEFT_END"] == pytest.approx(tables["UPPER_RIGHT_END"])


@pytest.mark.parametrize(
    ("bodies", "load", "words"),
    [
        (
            {"lower": BLOCK, "upper": BLOCK | {"base": "rollers"}},
            {"bulk_stress_upper": 5.0},
            "a deck holds Q by the rigid plane",
        ),
        (
            {"lower": BLOCK | {"sides": "guided"}},
            {"bulk_stress_lower": 5.0},
            "nothing pulls the ends of the lower body",
        ),
        (
            {"upper": {"kind": "pad", "width": 6.0, "height": 8.0}},
            {"bulk_stress_upper": 5.0},
            "nothing pulls the ends of the",
        ),
    ],
    ids=["upper on rollers", "guided sides", "pad"],
)
def test_what_a_deck_can_not_pull_is_refused(
    bodies: dict[str, Any], load: dict[str, Any], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        imposed(bodies, **load)


def test_stiffness_stick_slope_and_header_are_what_the_settings_say() -> None:
    deck = deck_of("hertz-paper")
    unit = deck.scales.modulus / (deck.scales.half_width / 16)
    assert np.isclose(deck.stiffness, 50 * unit, rtol=1e-12)
    [friction] = data_of(cards_of("hertz-paper"), "FRICTION")
    assert np.allclose([float(word) for word in friction], [1.0, 10 * unit], rtol=1e-11)
    head = deck_text(deck)[:2000]
    assert "dialect: CalculiX" in head
    assert "(a/L)^2" in head
    # the nodes of the meshes, and none of those that move a plane, a strain or a tilt
    elements = data_of(cards_of("hertz-paper"), "ELEMENT")
    node_count = len({node for row in elements for node in row[1:]})
    assert f"** size: {node_count} nodes, " in head
    third = ThirdSolver("CalculiX", deck, head, failure="it stopped")
    assert f"({node_count} nodes, " in third.sentences[0]
    for known in ({"steps_per_cycle": 2}, {"cycles": 0}, {"normal_stiffness": 0.0}):
        with pytest.raises(InputError, match="refused"):
            DeckSettings(**known)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("planted", "instead", "words"),
    [
        ("*NODE PRINT", "*NODE PRNT", "unknown keyword"),
        ("NLGEOM=NO", "NLGEOMETRY=NO", "lacks"),
        ("*CONTACT PAIR, ", "*CONTACT PAIR, ADJUST=0.1, ", "no parameter"),
        ("*END STEP\n", "", "step inside a step"),
        ("*CLOAD, AMPLITUDE=NORMAL_LOAD\n", "*CLOAD, AMPLITUDE=NORMAL_LOAD\n1, 2\n", "entries"),
        ("*ELASTIC\n", "*ELASTIC\n**\n1, 0.3\n", "is no f"),
    ],
)
def test_the_parser_refuses(planted: str, instead: str, words: str) -> None:
    text = deck_text(deck_of("hertz-paper"))
    assert planted in text
    with pytest.raises(ValueError, match=words):
        parse(text.replace(planted, instead))


STA = """ SUMMARY OF JOB INFORMATION
  STEP      INC     ATT  ITRS     TOT TIME     STEP TIME      INC TIME
     1          1     1U   60  0.000000E+00  0.000000E+00  0.625000E-01
     1          1     2     9  0.625000E-01  0.625000E-01  0.625000E-01
     2          1     1    15  0.250000E+00  0.187500E+00  0.187500E+00
"""


def stand_in(folder: Path, body: str) -> Path:
    """A program that does `body`, beside a status file of the job `deck`."""
    (folder / "deck.sta").write_text(STA, encoding="utf-8")
    program = folder / "ccx"
    program.write_text(f"#!/bin/sh\n{body}\n", encoding="utf-8")
    program.chmod(0o755)
    return program


def test_a_run_that_reaches_its_end_counts_increments_and_iterations(tmp_path: Path) -> None:
    """It ends when its progress was seen."""
    states: list[tuple[int, int | None, str]] = []

    def report(*state: Any) -> None:
        states.append(state)
        (tmp_path / "seen").touch()

    outcome = run_calculix(
        stand_in(tmp_path, "until [ -e seen ]; do sleep 0.05; done"),
        tmp_path,
        "deck",
        0.25,
        300.0,
        report,
    )
    assert (outcome.n_increments, outcome.n_iterations) == (2, 84)
    assert states[-1][:2] == (100, 100)


def interrupted(*_: object) -> None:
    raise KeyboardInterrupt


class Stop(NamedTuple):
    """A run that stops early: what the program does, and how the run is reported."""

    body: str
    end: float = 1.0  # of the deck
    limit: float = 300.0  # seconds
    report: Any = None
    fault: type[BaseException] = ConvergenceError
    facts: Sequence[str] = ()


STOPS = {
    "failed": Stop("echo '*ERROR: cutbacks'; exit 201", 0.25, facts=("exit code 201", "cutbacks")),
    "short": Stop(
        "echo 'Job finished'; exit 0",
        facts=(
            "exit code 0",
            "time 0.25 of 1, in increment 3 after 3 attempts",
            "Job finished",
        ),
    ),
    "late": Stop("exec sleep 20", limit=0.5, facts=("limit of 0.5 s", "time 0.25 of 1")),
    "interrupted": Stop("exec sleep 20", report=interrupted, fault=KeyboardInterrupt),
}


@pytest.mark.parametrize("case", STOPS)
def test_a_run_that_stops_early_is_reported_with_the_end_of_its_log_and_its_process_is_gone(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stop = STOPS[case]
    started = []
    popen = subprocess.Popen

    def start(*arguments: Any, **options: Any) -> Any:
        started.append(popen(*arguments, **options))
        return started[0]

    monkeypatch.setattr(subprocess, "Popen", start)
    program = stand_in(tmp_path, stop.body)
    with refused_for(*stop.facts, error=stop.fault):
        run_calculix(program, tmp_path, "deck", stop.end, stop.limit, stop.report)
    code = 201 if case == "failed" else -signal.SIGKILL
    assert started[0].returncode == (0 if case == "short" else code)


def test_the_program_is_found_with_its_version_or_named_with_make_peers(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)  # the stand-in leaves files where it is called
    assert calculix_version(stand_in(tmp_path, "echo 'This is Version 2.20'")) == "2.20"
    assert calculix_version(stand_in(tmp_path, "true")) == "of unknown version"
    monkeypatch.setenv("PATH", str(tmp_path / "none"))
    with pytest.raises(InputError, match="make peers"):
        find_calculix()


@pytest.mark.slow
@pytest.mark.parametrize("name", scene_names())
def test_every_scene_of_the_library_makes_a_deck(name: str) -> None:
    deck = build_deck(load_scene(name), COARSE)
    assert min(deck.lower.areas().min(), deck.upper.areas().min()) > 0
    assert parse(deck_text(deck))


@pytest.mark.slow
@pytest.mark.skipif(
    shutil.which("ccx") is None, reason="ccx is not on PATH: make peers installs it"
)
class TestCalculix:
    # Measured with CalculiX 2.20 beside each figure; the limit is half as much again.
    @pytest.mark.parametrize(
        ("name", "limits"),
        [
            ("hertz-normal", {"peak_pressure": 0.0018, "pressure": 0.08}),  # 0.0012, 0.052
            (
                "cattaneo-mindlin",
                {"dissipation": 0.03, "peak_pressure": 0.006, "pressure": 0.026, "shear": 0.075},
            ),
        ],
    )
    def test_tractions_and_work_are_those_of_theory(
        self, name: str, limits: dict[str, float]
    ) -> None:
        third = solve_with_calculix(load_scene(name), DeckSettings(cycles=1), Stages(quiet=True))
        assert not third.failure
        comparison: Any = third.comparison
        for key, limit in limits.items():
            assert abs(comparison.metric(key).value) < limit, key
        solution = comparison.result
        assert np.allclose(
            solution.normal_load[1:],
            comparison.scene.load.path().at(solution.time[1:])[0],
            rtol=2e-3,
        )

    def test_run_leaves_three_columns_and_a_time_limit_the_rest(
        self, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        out = tmp_path / "out"
        words = ["run", "hertz-normal", "--third", "calculix", "--out", str(out), "--quiet"]
        assert cli.main(words) in (0, 1)
        printed = capsys.readouterr().out
        assert "A third solver" in printed
        assert "penalty" in printed
        stored = json.loads((out / "third.json").read_text(encoding="utf-8"))
        assert stored["failure"] is None
        assert stored["code"].startswith("CalculiX")
        assert abs(stored["metrics"]["peak_pressure"]["third"]) < 0.0018
        assert "A third solver" in (out / "report.html").read_text(encoding="utf-8")
        assert (out / "third.nc").exists()
        late = tmp_path / "late"
        monkeypatch.setattr("reports.studies.third.calculix.TIME_LIMIT", 1.0)
        assert cli.main([*words[:-2], str(late), "--quiet"]) == 3
        assert "time limit of 1 s" in capsys.readouterr().err.replace("\n", " ")
        assert (
            "time limit" in json.loads((late / "third.json").read_text(encoding="utf-8"))["failure"]
        )
        assert not (late / "third.nc").exists()
