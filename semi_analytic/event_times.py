"""The instants of a history that have a name: where slip starts, stops and turns, where the loads are extreme.

The paper's letters (figure 2) belong to an ellipse that is gone round anticlockwise, Q lagging behind P by 0 < phase < 180 degrees:

    A  the first cycle starts (Q least)      E  forward slip ends: u = Q - f P largest    I  full stick ends: u least
    B  full stick ends: u least              F  P least                                   J  the front passes what G left
    C  P largest                             G  reverse slip ends: v = Q + f P least      K  P largest
    D  Q largest                             H  Q least                                   L  Q largest, M  as E

A to D are of the first cycle, E to M of the steady state; E to H follow on the first forward slip, I to M on the second. J
comes before or after K: in the paper's own example after it. Clockwise loops are the mirror image, Q for -Q. S and T, Y and Z are
loads on the memory curve, not instants: `front_load` gives them.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from scenes import InputError, LoadSegment, Scene
from scenes.frozen import validated
from semi_analytic.history import History, Span, history_of, is_plain_ellipse
from semi_analytic.legs import NORMAL_LOAD, Combination, change, level, phasor, stationary
from semi_analytic.memory import Curve

# Time, over itself or 1, within which two events are one.
_SAME = 1e-9
LETTERS = "ABCDEFGHIJKLM"


@dataclass(frozen=True)
class Event:
    """An instant of the load path that has a name.

    Attributes
    ----------
    letter : the paper's letter, "" where it has none
    name : what happens
    time : the instant, in the time of the scene's path
    normal_load, tangential_load : P and Q
    front_load : P_c, the load at the front of slip (P itself in full stick); where slip ends, the last
    """

    letter: str
    name: str
    time: float
    normal_load: float
    tangential_load: float
    front_load: float


def events(scene: Scene) -> tuple[Event, ...]:
    """Every event of the way in and of the cycles up to the first steady one, in the order of time.

    Events are the ends of the spans in which the memory keeps its structure, and the extreme loads. An ellipse with an area gets
    the paper's letters, mirrored for a clockwise one.

    Raises
    ------
    InadmissibleLoadError
        Gross sliding or separation somewhere in the path.

    >>> from scenes import load_scene
    >>> "".join(event.letter for event in events(load_scene("hertz-paper")))
    'ABCDEFGHIKJLM'
    """
    scene = validated(scene, Scene)
    route = history_of(scene.load.path(), scene.friction.coefficient, scene.cycles)
    plain = _merged(sorted(_plain(route), key=lambda event: event.time))
    return tuple(_lettered(plain, route))


def event(scene: Scene, letter: str) -> Event:
    """The event that the paper calls `letter`.

    Raises
    ------
    InputError
        Where the scene has none of that letter.

    >>> from scenes import load_scene
    >>> found = event(load_scene("hertz-paper"), "G")
    >>> round(found.time / math.pi, 12), round(found.front_load / found.normal_load, 6)
    (3.25, 0.69161)
    """
    for found in events(scene):
        if letter and found.letter == letter:
            return found
    raise InputError(f"events: the scene {scene.name!r} has no event {letter!r} among {LETTERS}")


def _plain(route: History) -> Iterator[Event]:
    """Events without letters, several at one instant perhaps."""
    groups: list[tuple[str, Sequence[Span]]] = [("way in", route.loading)] if route.loading else []
    groups += [(f"cycle {number}", cycle) for number, cycle in enumerate(route.cycles, 1)]
    for label, spans in groups:
        for before, span in zip([None, *spans[:-1]], spans, strict=True):
            name = _change_of_state(before, span) or f"{label} starts"
            yield _at(span, span.begin.time, name)
            if before is not None:
                yield _at(before, before.end.time, name)
            for name, time in _extremes(span):
                yield _at(span, time, name)
    last = route.spans[-1]
    yield _at(last, last.end.time, "the path ends" if route.period is None else "the last cycle ends")


def _change_of_state(before: Span | None, span: Span) -> str:
    if before is None:
        return ""
    names = {0: "full stick", 1: "forward slip", -1: "reverse slip"}
    if before.direction != span.direction:
        return f"{names[before.direction]} ends, {names[span.direction]} starts"
    if span.direction and not _same_piece(before.active, span.active):
        return f"the front of {names[span.direction]} passes a piece of the memory"
    return f"{names[span.direction]} goes on"


def _same_piece(one: Curve, other: Curve) -> bool:
    """Whether two pieces are parts of one."""
    if one is None or other is None:
        return one is other
    if one.arc is not None and other.arc is not None and one.anchor.leg is other.anchor.leg:
        return True  # an arc that a cycle starts in comes in two pieces
    return one.anchor[1:] == other.anchor[1:] and one.slope == other.slope


def _extremes(span: Span) -> Iterator[tuple[str, float]]:
    """Extreme loads at the beginning of a span or inside it."""
    for what, word in ((NORMAL_LOAD, "P"), (Combination(0.0, 1.0), "Q")):
        for time in _turning(span, what):
            if span.begin.time - _SAME <= time < span.end.time - _SAME:
                yield f"{word} {'largest' if _bend(span.leg, what, time) < 0 else 'least'}", time


def _bend(leg: LoadSegment, what: Combination, time: float) -> float:
    """Sign of the second derivative."""
    width = 1e-3 * (leg.end - leg.start)
    return float(change(leg, what, time + width, time)) + float(change(leg, what, time - width, time))


def _turning(span: Span, what: Combination) -> list[float]:
    """Times at which the combination turns, the ends of the leg among them where the leg is smooth beyond."""
    if not is_plain_ellipse(span.leg):
        return stationary(span.leg, what)
    return stationary(replace(span.leg, start=span.leg.start - 0.1, end=span.leg.end + 0.1), what)


def _at(span: Span, time: float, name: str) -> Event:
    inside = min(max(time, span.begin.time), span.end.time)
    normal, tangential = (float(load) for load in span.leg.loads(inside))
    front = normal - float(span.slipped(inside))
    return Event("", name, inside + span.delay, normal, tangential, front)


def _merged(found: Sequence[Event]) -> list[Event]:
    """One event for each instant, its names joined."""
    merged: list[Event] = []
    for one in found:
        if merged and abs(merged[-1].time - one.time) <= _SAME * max(abs(one.time), 1.0):
            known = merged[-1]
            names = [name for name in (known.name, one.name) if not name.endswith("goes on")] or [known.name]
            front = min(known.front_load, one.front_load)
            merged[-1] = Event("", "; ".join(dict.fromkeys(names)), known.time, known.normal_load, known.tangential_load, front)
        else:
            merged.append(one)
    return [one for one in merged if not one.name.endswith("goes on")]


def _lettered(plain: Sequence[Event], route: History) -> Iterator[Event]:
    """The same events with letters, where the cycle is an ellipse with an area."""
    times = _letter_times(route)
    for one in plain:
        letters = [letter for letter, time in times.items() if abs(time - one.time) <= 1e-7]
        yield Event("".join(letters), one.name, one.time, one.normal_load, one.tangential_load, one.front_load)


def _letter_times(route: History) -> dict[str, float]:
    """When the paper's letters are, for an ellipse; C and D fall together, as K and L do, only on a line."""
    if route.loop is None or route.steady_from is None or not route.spans:
        return {}
    leg, friction, ellipse = route.loop, route.spans[0].friction, route.loop.ellipse
    assert ellipse is not None  # for the type checker: `loop` is one
    area = ellipse.amplitude[0] * ellipse.amplitude[1] * math.sin(ellipse.phase)
    if abs(area) <= 1e-12 * ellipse.amplitude[0] * ellipse.amplitude[1]:
        return {}
    sense = 1 if area > 0 else -1
    force = Combination(0.0, float(sense))
    first = _times_of(leg, {"u": level(sense, friction), "v": level(-sense, friction), "P": NORMAL_LOAD, "Q": force})
    start, turn = leg.start, 2 * math.pi
    times = {"A": start}
    for letter, key in zip("BCDEFGHIKLM", ("u-", "P+", "Q+", "u+", "P-", "v-", "Q-", "u-", "P+", "Q+", "u+"), strict=True):
        after = max(times.values())
        times[letter] = first[key] + turn * math.ceil((after - first[key]) / turn - 1e-12)
    return times | {"J": 2 * times["I"] - times["G"]}


def _times_of(leg: LoadSegment, combinations: dict[str, Combination]) -> dict[str, float]:
    """A time of the largest and of the least value of each combination, keyed with + and -; the combination of v is -v."""
    times: dict[str, float] = {}
    for key, what in combinations.items():
        largest = -cmath.phase(phasor(leg, what))
        signs = "-+" if key == "v" else "+-"
        times |= {key + signs[0]: largest, key + signs[1]: largest + math.pi}
    return times
