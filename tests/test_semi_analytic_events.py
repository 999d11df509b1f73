"""Events: the paper's letters at the places that the geometry of its circle gives, the mirror image, and paths without letters."""

import math

import pytest

from scenes import InputError, TimeSeriesLoad, load_scene
from semi_analytic import event, events
from semi_analytic_cases import ellipse, make_scene, polygon

PAPER = make_scene(ellipse(3.0, 1.0, 1.1, 1.0, 90.0, "parabola"))
ROOT = math.sqrt(0.5)
# P = 3 + cos t, Q = 1.1 + sin t, f = 1: u = Q - P turns at 3 pi/4 and 7 pi/4, v = Q + P at pi/4 and 5 pi/4.
PLACES = {
    "A": (3.0, 0.1),
    "B": (3 + ROOT, 1.1 - ROOT),
    "C": (4.0, 1.1),
    "D": (3.0, 2.1),
    "E": (3 - ROOT, 1.1 + ROOT),
    "F": (2.0, 1.1),
    "G": (3 - ROOT, 1.1 - ROOT),
    "H": (3.0, 0.1),
    "I": (3 + ROOT, 1.1 - ROOT),
    "J": (3 + ROOT, 1.1 + ROOT),
    "K": (4.0, 1.1),
    "L": (3.0, 2.1),
    "M": (3 - ROOT, 1.1 + ROOT),
}


@pytest.mark.parametrize("letter", PLACES)
def test_letters_stand_where_the_circle_says(letter):
    found = event(PAPER, letter)
    assert (found.normal_load, found.tangential_load) == pytest.approx(PLACES[letter], abs=1e-13)
    assert PAPER.load.path().at(found.time) == pytest.approx(PLACES[letter], abs=1e-12)


def test_letters_come_once_and_j_after_k():
    """The paper names J before K; 2 t_I - t_G = 9 pi/4 comes after the largest load at 2 pi in its own example."""
    letters = "".join(one.letter for one in events(PAPER))
    assert letters == "ABCDEFGHIKJLM"
    times = [one.time for one in events(PAPER)]
    assert times == sorted(times)


def test_front_loads_are_those_of_the_paper():
    """At E the transient front (its Z); at G and M the permanent stick load T; at J the load of G; in full stick P itself."""
    permanent = 3 - math.sqrt(2)
    assert event(PAPER, "G").front_load == event(PAPER, "M").front_load == pytest.approx(permanent, rel=1e-14)
    assert permanent < event(PAPER, "L").front_load < 3 - ROOT
    assert event(PAPER, "E").front_load < permanent
    assert event(PAPER, "J").front_load == pytest.approx(3 - ROOT)
    assert event(PAPER, "H").front_load == event(PAPER, "H").normal_load


def test_clockwise_loops_are_the_mirror_image():
    mirrored = make_scene(ellipse(3.0, 1.0, -1.1, 1.0, -90.0))
    for letter, (normal, tangential) in PLACES.items():
        found = event(mirrored, letter)
        assert (found.normal_load, -found.tangential_load) == pytest.approx((normal, tangential), abs=1e-12), letter


def test_names_say_what_happens():
    assert event(PAPER, "B").name == "full stick ends, forward slip starts"
    assert event(PAPER, "E").name == "forward slip ends, reverse slip starts"
    assert "Q least" in event(PAPER, "A").name
    assert "P largest" in event(PAPER, "C").name


def test_lines_and_polygons_have_events_without_letters():
    for scene in (load_scene("full-stick"), make_scene(polygon([(1.0, 0.0)], [(1.0, 0.4), (1.0, -0.4)]))):
        assert all(one.letter == "" for one in events(scene))
        with pytest.raises(InputError, match="no event 'A'"):
            event(scene, "A")


def test_a_series_that_is_followed_from_its_first_row_on_has_events_too():
    load = TimeSeriesLoad(rows=[[0.0, 0.0, 0.0], [1.0, 1.0, 0.2], [2.0, 0.5, -0.1]])
    assert [one.time for one in events(make_scene(load))] == [0.0, 1.0, 2.0]
