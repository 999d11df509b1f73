"""Decks without CalculiX: read by a strict parser, sets, orientation, gap, supports, and loads that are the scene's."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from deck_parser import ABAQUS, CALCULIX, Card, DeckError, by_name, parse
from reports.third.abaqus import abaqus_deck, elastic_slip
from reports.third.blocks import number
from reports.third.calculix import calculix_deck
from reports.third.deck import Deck, build_deck
from reports.third.settings import DeckSettings
from scenes import InputError, load_scene, scene_names

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))
import roller  # noqa: E402

sys.path.remove(str(BENCHMARKS))

COARSE = DeckSettings(element_size=1 / 8, edge_element_size=1 / 16, far_radius=20.0, growth=0.6, steps_per_cycle=16)
SCENES = ("hertz-paper", "cattaneo-mindlin", "pad-on-block", "layer", "cylinder-roller-frictionless")


@cache
def deck_of(name: str) -> Deck:
    return build_deck(load_scene(name), COARSE)


@cache
def cards_of(name: str, dialect: str) -> list[Card]:
    write, keywords = (calculix_deck, CALCULIX) if dialect == "calculix" else (abaqus_deck, ABAQUS)
    return parse(write(deck_of(name), "halfplane export", {"halfplane": "0"}), keywords)


def nodes_of(cards: list[Card]) -> dict[int, np.ndarray]:
    return {int(row[0]): np.array([float(v) for v in row[1:3]]) for c in cards if c.keyword == "NODE" for row in c.data}


@pytest.mark.parametrize("dialect", ["calculix", "abaqus"])
@pytest.mark.parametrize("name", SCENES)
def test_every_name_and_number_that_a_deck_refers_to_is_there(name: str, dialect: str) -> None:
    cards = cards_of(name, dialect)
    nodes = nodes_of(cards)
    elements = [[int(w) for w in row] for c in cards if c.keyword == "ELEMENT" for row in c.data]
    assert sorted(row[0] for row in elements) == list(range(1, len(elements) + 1))
    used = {node for row in elements for node in row[1:]}
    reference = deck_of(name).reference
    assert used | {reference} == set(nodes) == set(range(1, reference + 1))
    sets = by_name(cards, "NSET", "NSET")
    assert set(sets) == {"LOWER_FACE_NODES", "UPPER_FACE_NODES"}
    for card in sets.values():
        members = [int(w) for row in card.data for w in row]
        assert len(members) > 10
        assert set(members) <= used
    faces = by_name(cards, "SURFACE", "NAME")
    pair = next(c for c in cards if c.keyword == "CONTACT PAIR")
    assert set(pair.data[0]) == set(faces)
    assert pair.parameters["INTERACTION"] in by_name(cards, "SURFACE INTERACTION", "NAME")
    held = {int(row[0]) for c in cards if c.keyword == "BOUNDARY" for row in c.data}
    assert held <= set(nodes)
    assert any(int(row[1]) == 2 for c in cards if c.keyword == "BOUNDARY" for row in c.data)


@pytest.mark.parametrize("name", SCENES)
def test_elements_go_round_anticlockwise_and_fill_the_bodies(name: str) -> None:
    deck = deck_of(name)
    for body in (deck.lower, deck.upper):
        areas = body.areas()
        assert areas.min() > 0
        x, y = body.nodes[body.elements - body.first_node].mean(1).T
        assert (y.max() < 0) if body is deck.lower else (y.min() > 0)
        assert abs((areas * x).sum() / areas.sum()) < 1e-9 * np.abs(body.nodes).max()
    turned = deck.lower.elements[:, ::-1]
    x, y = deck.lower.nodes[turned - 1].transpose(2, 0, 1)
    assert ((x * (np.roll(y, -1, 1) - np.roll(y, 1, 1))).sum(1) < 0).all(), "the check sees elements that go round the other way"


@pytest.mark.parametrize("name", SCENES)
def test_contact_faces_are_one_chain_of_sides_along_the_face(name: str) -> None:
    for body in (deck_of(name).lower, deck_of(name).upper):
        cells = body.elements[body.contact_faces[:, 0] - body.first_element]
        side = body.contact_faces[:, 1] - 1
        rows = np.arange(len(side))
        first, last = cells[rows, side], cells[rows, (side + 1) % 4]
        x = body.nodes[:, 0]
        left = np.where(body.name == "LOWER", last, first)  # anticlockwise: the lower body's face is run through to the left
        right = np.where(body.name == "LOWER", first, last)
        assert (x[right - body.first_node] > x[left - body.first_node]).all()
        assert np.array_equal(np.unique([left, right]), np.unique(body.contact_nodes))
        assert len(side) == len(body.contact_nodes) - 1


def test_the_gap_between_the_faces_is_the_scenes_profile() -> None:
    deck = deck_of("hertz-paper")
    x, y = deck.upper.nodes[deck.upper.contact_nodes - deck.upper.first_node].T
    assert np.allclose(y, deck.scene.profile.height(x), rtol=0, atol=1e-15)
    far = np.abs(deck.upper.nodes[:, 0]) > 3 * x.max()
    assert deck.upper.nodes[far, 1].min() < 4 * y.max(), "the continuation of the gap stays bounded"


def test_true_faces_stay_as_they_are_made() -> None:
    deck = deck_of("cylinder-roller-frictionless")
    x, y = deck.upper.nodes[deck.upper.contact_nodes - deck.upper.first_node].T
    radius = 50.0
    assert np.allclose(y, radius - np.sqrt(radius**2 - x**2), rtol=0, atol=1e-9)


def test_the_roller_benchmark_mirrors_the_half_cylinder_and_loads_its_top() -> None:
    half = deck_of("cylinder-roller-frictionless")
    whole = roller.whole_cylinder(half)
    assert whole.upper.areas().min() > 0
    assert whole.upper.areas().sum() == pytest.approx(2 * half.upper.areas().sum(), rel=1e-12)
    assert len(np.unique(whole.upper.nodes.round(9), axis=0)) == len(whole.upper.nodes) == whole.reference - whole.upper.first_node
    loaded = whole.upper.nodes[whole.upper.held[2] - whole.upper.first_node]
    assert loaded[:, 1].max() == pytest.approx(100.0)
    assert np.abs(loaded[:, 0]).max() <= half.scales.half_width
    assert roller.two_increments(half).time.tolist() == [0.0, 0.5, 1.0]
    assert set(roller.kept()) == set(roller.cases())


@pytest.mark.parametrize("dialect", ["calculix", "abaqus"])
@pytest.mark.parametrize("name", SCENES)
def test_amplitudes_are_the_scenes_loads_at_the_instants_of_output(name: str, dialect: str) -> None:
    cards, deck, scene = cards_of(name, dialect), deck_of(name), load_scene(name)
    path = scene.load.path()
    tables = {key: np.reshape(card.numbers(), (-1, 2)) for key, card in by_name(cards, "AMPLITUDE", "NAME").items()}
    time = tables["NORMAL_LOAD"][:, 0] + path.start
    normal, tangential = path.at(np.minimum(time, deck.time[-1]))
    scale = np.abs(normal).max()
    assert np.allclose(tables["NORMAL_LOAD"][:, 1], normal, rtol=0, atol=1e-10 * scale)
    assert np.allclose(tables["TANGENTIAL_LOAD"][:, 1], tangential, rtol=0, atol=1e-10 * scale)
    ends = np.cumsum([c.numbers()[1] for c in cards if c.keyword == "STATIC"])
    assert np.allclose(ends[1:], tables["NORMAL_LOAD"][1:, 0], rtol=1e-10), "a step ends at every instant; the first is the touch"
    assert 0 < ends[0] < ends[1]
    signs = {c.parameters["AMPLITUDE"]: (c.data[0][0], c.data[0][1], float(c.data[0][2])) for c in cards if c.keyword == "CLOAD"}
    assert signs["NORMAL_LOAD"] == (str(deck.reference), "2", -1.0)
    assert ("TANGENTIAL_LOAD" in signs) == (scene.friction.coefficient > 0)


def test_the_cycle_closes_and_its_turning_points_are_instants() -> None:
    deck, path = deck_of("hertz-paper"), load_scene("hertz-paper").load.path()
    begin = int(np.argmin(np.abs(deck.time - path.cycle_start)))
    assert np.isclose(deck.normal_load[begin], deck.normal_load[-1])
    assert np.isclose(deck.tangential_load[begin], deck.tangential_load[-1])
    assert np.isclose(deck.time[-1] - deck.time[begin], 2 * path.period), "two revolutions"
    load = deck.scene.load
    assert np.isclose(deck.normal_load[begin:].max(), load.mean_normal_load + load.normal_amplitude, rtol=1e-12)
    polygon = deck_of("cattaneo-mindlin")
    assert np.isclose(polygon.tangential_load.max(), 27.186859502219357, rtol=1e-12), "corners of a polygon are instants"


@pytest.mark.parametrize("name", SCENES)
def test_upper_plane_carries_every_node_of_its_support(name: str) -> None:
    deck, cards = deck_of(name), cards_of(name, "calculix")
    tied = [tuple(map(float, row)) for c in cards if c.keyword == "EQUATION" for row in c.data[1::2]]
    assert len(tied) == len({row[:2] for row in tied}) == sum(len(nodes) for nodes in deck.upper.held.values())
    assert all(row[3] == deck.reference and row[1] == row[4] and row[2] == -row[5] for row in tied)
    assert {row[1] for row in tied} == {1.0, 2.0}


def test_stiffness_and_elastic_slip_are_what_the_settings_say() -> None:
    deck = deck_of("hertz-paper")
    size = deck.scales.half_width / 16
    assert np.isclose(deck.stiffness, 50 * deck.scales.modulus / size, rtol=1e-12)
    friction = next(c for c in cards_of("hertz-paper", "calculix") if c.keyword == "FRICTION")
    assert np.allclose(friction.numbers(), [1.0, 10 * deck.scales.modulus / size], rtol=1e-11)
    theirs = next(c for c in cards_of("hertz-paper", "abaqus") if c.keyword == "FRICTION")
    assert np.isclose(float(theirs.parameters["ELASTIC SLIP"]), elastic_slip(deck), rtol=1e-11)
    mean = deck.scales.load / (2 * deck.scales.half_width)
    assert np.isclose(elastic_slip(deck) * deck.stick_slope, mean, rtol=1e-12)


@pytest.mark.parametrize(
    ("planted", "words"),
    [
        (("*NODE PRINT", "*NODE PRNT"), "unknown keyword"),
        (("NLGEOM=NO", "NLGEOMETRY=NO"), "lacks"),
        (("*CONTACT PAIR, ", "*CONTACT PAIR, ADJUST=0.1, "), "no parameter"),
        (("*END STEP\n", ""), "step inside a step"),
        (("*CLOAD, AMPLITUDE=NORMAL_LOAD\n", "*CLOAD, AMPLITUDE=NORMAL_LOAD\n1, 2\n"), "entries"),
        (("*ELASTIC\n", "*ELASTIC\n**\n1, 0.3\n"), "is no f"),
    ],
)
def test_the_parser_refuses(planted: tuple[str, str], words: str) -> None:
    text = calculix_deck(deck_of("hertz-paper"))
    assert planted[0] in text
    with pytest.raises(DeckError, match=words):
        parse(text.replace(*planted), CALCULIX)


def test_an_abaqus_deck_says_that_it_was_never_run_there() -> None:
    head = abaqus_deck(deck_of("hertz-paper"))[:2000]
    assert "NOT run in Abaqus" in head
    assert "(a/L)^2" in head


def test_settings_out_of_range_are_refused() -> None:
    for known in ({"steps_per_cycle": 2}, {"cycles": 0}, {"normal_stiffness": 0.0}):
        with pytest.raises(InputError, match="refused"):
            DeckSettings(**known)


def test_numbers_fit_into_what_calculix_reads() -> None:
    values = [1 / 3, -1e-7 / 3, 123456789.123456789, -2e300 / 3, 5e-324, 0.0]
    assert all(len(number(v)) <= 20 and "." in number(v) for v in values)
    assert np.allclose([float(number(v)) for v in values], values, rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", scene_names())
def test_every_scene_of_the_library_makes_a_deck_in_both_dialects(name: str) -> None:
    deck = build_deck(load_scene(name), COARSE)
    assert min(deck.lower.areas().min(), deck.upper.areas().min()) > 0
    assert parse(calculix_deck(deck), CALCULIX)
    assert parse(abaqus_deck(deck), ABAQUS)
