"""The instants of a history that have a name: where slip starts, stops and turns, where the loads
are extreme.

The paper's letters (figure 2) belong to an ellipse that is gone round anticlockwise, Q lagging
behind P by 0 < phase < 180 degrees:

    A  the first cycle starts (Q least)
    B  full stick ends: u least
    C  P largest
    D  Q largest
    E  forward slip ends: u = Q - f P largest
    F  P least
    G  reverse slip ends: v = Q + f P least
    H  Q least
    I  full stick ends: u least
    J  the front passes what G left
    K  P largest
    L  Q largest
    M  as E

A to D are of the first cycle, E to M of the steady state; E to H follow on the first forward slip,
I to M on the second. J comes before or after K: in the paper's own example after it. Clockwise
loops are the mirror image, Q for -Q. S and T, Y and Z are loads on the memory curve, not instants:
`front_load` gives them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from scenes import NORMAL_LOAD, Combination, InputError, Scene
from scenes.frozen import validated
from semi_analytic.bulk_and_tilt import followed_path
from semi_analytic.history import History, Span, history_of, is_plain_ellipse
from semi_analytic.memory import Curve, level

# Time, over itself or 1, within which two events are one.
_SAME = 1e-9
LETTERS = "ABCDEFGHIJKLM"
# End of the name of an event at which nothing happens: two spans of one kind meet.
_ON = " goes on"


@dataclass(frozen=True)
class Event:
    """An instant of the load path that has a name.

    Attributes
    ----------
    letter
        the paper's letter, "" where it has none
    name
        what happens
    time
        the instant, in the time of the scene's path
    normal_load, tangential_load
        P and Q [force per thickness]
    front_load
        P_c [force per thickness], the load at the edge of slip (P itself in full stick); where
        slip ends, the last
    """

    letter: str
    name: str
    time: float
    normal_load: float
    tangential_load: float
    front_load: float


def events(scene: Scene) -> tuple[Event, ...]:
    """Every event of the initial loading and of the cycles up to the first steady one, in the order
    of time.

    Events are the ends of the spans in which the memory keeps its structure, and the extreme loads.
    An ellipse with an area gets the paper's letters, mirrored for a clockwise one.

    Raises
    ------
    InadmissibleLoadError
        Gross sliding or separation somewhere in the path.
    InputError
        Bulk stress or tilt under which the memory is not one curve.

    Examples
    --------
    >>> from scenes import load_scene
    >>> "".join(event.letter for event in events(load_scene("hertz-paper")))
    'ABCDEFGHIKJLM'
    """
    scene = validated(scene, Scene)
    history = history_of(followed_path(scene), scene.friction.coefficient, scene.cycles)
    times = _letter_times(history)
    merged: list[Event] = []
    for one in sorted(_named(history), key=lambda event: event.time):
        known = merged[-1] if merged else None
        if known is not None and abs(known.time - one.time) <= _SAME * max(abs(one.time), 1.0):
            names = [name for name in (known.name, one.name) if not name.endswith(_ON)] or [
                known.name
            ]
            front = min(known.front_load, one.front_load)
            merged[-1] = replace(known, name="; ".join(dict.fromkeys(names)), front_load=front)
        else:
            merged.append(one)
    return tuple(
        replace(
            one,
            letter="".join(
                letter for letter, time in times.items() if abs(time - one.time) <= 1e-7
            ),
        )
        for one in merged
        if not one.name.endswith(_ON)
    )


def event(scene: Scene, letter: str) -> Event:
    """The event that the paper calls `letter`.

    Raises
    ------
    InputError
        Where the scene has none of that letter.

    Examples
    --------
    >>> from scenes import load_scene
    >>> found = event(load_scene("hertz-paper"), "G")
    >>> round(found.time / math.pi, 12), round(found.front_load / found.normal_load, 6)
    (3.25, 0.691609)
    """
    for found in events(scene):
        if letter and found.letter == letter:
            return found
    raise InputError(f"events: the scene {scene.name!r} has no event {letter!r} among {LETTERS}")


def _named(history: History) -> Iterator[Event]:
    """Events without letters, several at one instant perhaps."""
    states = {0: "full stick", 1: "forward slip", -1: "reverse slip"}
    groups = [(f"cycle {number}", cycle) for number, cycle in enumerate(history.cycles, 1)]
    for label, spans in [("initial loading", history.loading), *groups]:
        before: Span | None = None
        for span in spans:
            if before is None:
                name = f"{label} starts"
            elif before.direction != span.direction:
                name = f"{states[before.direction]} ends, {states[span.direction]} starts"
            elif span.direction and not _same_piece(before.active, span.active):
                name = f"the front of {states[span.direction]} passes a piece of the memory"
            else:
                name = states[span.direction] + _ON
            yield _at(span, span.begin.time, name)
            if before is not None:
                yield _at(before, before.end.time, name)
            yield from _extremes(span)
            before = span
    last = history.spans[-1]
    yield _at(
        last, last.end.time, "the path ends" if history.period is None else "the last cycle ends"
    )


def _same_piece(one: Curve, other: Curve) -> bool:
    """Whether two pieces are parts of one."""
    if one is None or other is None:
        return one is other
    if one.arc is not None and other.arc is not None and one.anchor.leg is other.anchor.leg:
        return True  # an arc that a cycle starts in comes in two pieces
    return one.anchor[1:] == other.anchor[1:] and one.slope == other.slope


def _extremes(span: Span) -> Iterator[Event]:
    """Extreme loads at the beginning of a span or inside it, also at the ends of an ellipse, which
    is smooth beyond.
    """
    leg, width = span.leg, 1e-3 * (span.leg.end - span.leg.start)
    wider = replace(leg, start=leg.start - 0.1, end=leg.end + 0.1) if is_plain_ellipse(leg) else leg
    for what, word in ((NORMAL_LOAD, "P"), (Combination(0.0, 1.0), "Q")):
        for time in wider.turning_points(what):
            if span.begin.time - _SAME <= time < span.end.time - _SAME:
                bend = float(leg.change_of(what, time + width, time)) + float(
                    leg.change_of(what, time - width, time)
                )
                yield _at(span, time, f"{word} {'largest' if bend < 0 else 'least'}")


def _at(span: Span, time: float, name: str) -> Event:
    inside = min(max(time, span.begin.time), span.end.time)
    normal, tangential = (float(load) for load in span.leg.loads(inside))
    return Event(
        "", name, inside + span.delay, normal, tangential, normal - float(span.slipped(inside))
    )


def _letter_times(history: History) -> dict[str, float]:
    """When the paper's letters are, for an ellipse with an area; C and D fall together, as K and L
    do, only on a line.
    """
    if history.loop is None or history.steady_from is None:
        return {}
    leg, friction, ellipse = history.loop, history.spans[0].friction, history.loop.ellipse
    assert ellipse is not None  # for the type checker: `loop` is one
    area = ellipse.amplitude[0] * ellipse.amplitude[1] * math.sin(ellipse.phase)
    if abs(area) <= 1e-12 * ellipse.amplitude[0] * ellipse.amplitude[1]:
        return {}
    sense, turn = (1 if area > 0 else -1), 2 * math.pi
    what = {
        "u": level(sense, friction),
        "-v": level(-sense, friction),
        "P": NORMAL_LOAD,
        "Q": Combination(0.0, float(sense)),
    }
    times = {"A": leg.start}
    # What is largest (+) or least (-) at each letter; v is least where -v is largest.
    order = zip(
        "BCDEFGHIKLM",
        ("u-", "P+", "Q+", "u+", "P-", "-v+", "Q-", "u-", "P+", "Q+", "u+"),
        strict=True,
    )
    for letter, key in order:
        first = ellipse.largest_at(what[key[:-1]]) + (math.pi if key[-1] == "-" else 0.0)
        times[letter] = first + turn * math.ceil((max(times.values()) - first) / turn - 1e-12)
    return times | {"J": 2 * times["I"] - times["G"]}
