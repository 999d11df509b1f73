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
    J  the stick edge passes where it was at G
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

from scenes import NORMAL_LOAD, TANGENTIAL_LOAD, Combination, InputError, Scene
from scenes.frozen import validated
from semi_analytic.bulk_and_tilt import followed_path
from semi_analytic.history import History, Span, history_of, is_plain_ellipse
from semi_analytic.memory import Curve, slip_combination

# Events that are nearer to each other than this are one: a share of their time, or of 1.
_SAME_TIME_SHARE = 1e-9
# Time within which an event has a letter of the paper, which is found by other formulas.
_LETTER_TOLERANCE = 1e-7
LETTERS = "ABCDEFGHIJKLM"
# End of the name of an event at which nothing happens: two spans of one kind meet.
_CONTINUATION_ENDING = " goes on"


@dataclass(frozen=True)
class Event:
    """An instant of the load path that has a name.

    Attributes
    ----------
    letter
        the paper's letter, "" where it has none; several, such as "KJ", where events coincide
    name
        what happens
    time
        the instant, in the time of the scene's path
    normal_load, tangential_load
        P and Q [force per thickness]
    front_load
        P_c [force per thickness], the normal load whose contact is the stick zone (P itself in
        full stick); where slip ends, the last
    """

    letter: str
    name: str
    time: float
    normal_load: float
    tangential_load: float
    front_load: float


def events(scene: Scene) -> tuple[Event, ...]:
    """Every event of a load path, in the order of time: start and end of slip and stick, extreme
    loads, and when the stick edge passes a point at which slip ended before.

    Initial loading and cycles up to the first steady one are covered. On an ellipse of loads with
    an area, events get the letters A to M of figure 2 of Davies, Barber and Hills (2012). For a
    clockwise one that figure is mirrored. The friction history is a sequence of times of stick, or
    of slip in one direction.

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
    # initial loading, and cycles up to the first steady one
    history = history_of(followed_path(scene), scene.friction.coefficient, scene.cycles)
    # without times at which stick or slip merely goes on
    named_events = [
        named_event
        for named_event in _events_by_time(history)
        if not named_event.name.endswith(_CONTINUATION_ENDING)
    ]
    return _with_letters(named_events, _time_by_letter(history))


def _events_by_time(history: History) -> list[Event]:
    """Events of a load path in the order of time, without the letters of the paper. Events of one
    instant, within 1e-9 of the time, are merged into one.
    """
    merged_events: list[Event] = []
    for later_event in sorted(_unlettered_events(history), key=lambda event: event.time):
        former_event = merged_events[-1] if merged_events else None
        # _SAME_TIME_SHARE: 1e-9
        tolerance = _SAME_TIME_SHARE * max(abs(later_event.time), 1.0)
        if former_event is not None and abs(former_event.time - later_event.time) <= tolerance:
            merged_events[-1] = _merged_event(former_event, later_event)
        else:
            merged_events.append(later_event)
    return merged_events


def _with_letters(named_events: list[Event], time_by_letter: dict[str, float]) -> tuple[Event, ...]:
    """The same events, each letter of the paper at the event nearest to its time, if that is within
    1e-7; events near no letter keep "". Without an ellipse of loads there are no letters.
    """
    letters_of_events = [""] * len(named_events)
    for letter, time in time_by_letter.items():
        time_differences = [abs(named_event.time - time) for named_event in named_events]
        number_of_nearest_event = time_differences.index(min(time_differences))
        # _LETTER_TOLERANCE: 1e-7
        if time_differences[number_of_nearest_event] <= _LETTER_TOLERANCE:
            letters_of_events[number_of_nearest_event] += letter
    return tuple(
        replace(named_event, letter=letters)
        for named_event, letters in zip(named_events, letters_of_events, strict=True)
    )


def _merged_event(first_event: Event, second_event: Event) -> Event:
    """Two events of one instant as one, with both names and the lower of their loads P_c at the
    stick edge, `front_load`. A name that ends in " goes on" is left out, since nothing happens
    then.
    """
    names = [
        name
        for name in (first_event.name, second_event.name)
        if not name.endswith(_CONTINUATION_ENDING)
    ]
    if not names:
        names = [first_event.name]
    return replace(
        first_event,
        name="; ".join(dict.fromkeys(names)),
        front_load=min(first_event.front_load, second_event.front_load),
    )


def event(scene: Scene, letter: str) -> Event:
    """The event of a scene's load path that the paper calls `letter`, such as "G", the end of
    reverse slip. Where events coincide they are one, which has the letters of all, such as "KJ".

    Raises
    ------
    InputError
        Where the scene has none of that letter.

    Examples
    --------
    >>> from scenes import load_scene
    >>> end_of_slip = event(load_scene("hertz-paper"), "G")
    >>> round(end_of_slip.time / math.pi, 12)
    3.25
    >>> round(end_of_slip.front_load / end_of_slip.normal_load, 6)
    0.691609
    """
    # all events of the path, with the letters A to M where they have one
    for candidate in events(scene):
        if letter and letter in candidate.letter:
            return candidate
    raise InputError(f"events: the scene {scene.name!r} has no event {letter!r} among {LETTERS}")


def _unlettered_events(history: History) -> Iterator[Event]:
    """Events of a load path, without the letters A to M that the paper gives to those of an ellipse
    of loads: starts and ends of stick and slip, extreme loads, the end of the path, and each
    passage of the stick edge from one piece of the memory curve to the next.

    A span is a time in full stick, 0, or with slip in one direction, 1 or -1. The memory curve is
    M(eta), the tangential force of the flat punches up to the load eta. A slip zone lies between
    the stick edge, at the load P_c, and the edge of contact, at P. As it grows, the stick edge
    moves inwards and erases M above P_c. In a span the stick edge stays on one piece of the curve,
    its `sticking_piece`.

    The border of two spans comes twice, as the start of a span and as the end of the span before.
    `events` merges all events of one instant. It drops those whose name ends in " goes on".
    """
    state_names = {0: "full stick", 1: "forward slip", -1: "reverse slip"}
    spans_of_cycles = [
        (f"cycle {cycle_number}", spans_of_cycle)
        for cycle_number, spans_of_cycle in enumerate(history.cycles, 1)
    ]
    for part_name, spans_of_part in [("initial loading", history.loading), *spans_of_cycles]:
        span_before: Span | None = None
        for span in spans_of_part:
            if span_before is None:
                event_name = f"{part_name} starts"
            elif span_before.direction != span.direction:
                event_name = (
                    f"{state_names[span_before.direction]} ends, {state_names[span.direction]}"
                    " starts"
                )
            elif span.direction and not _is_same_piece(
                span_before.sticking_piece, span.sticking_piece
            ):
                event_name = (
                    f"the stick edge of {state_names[span.direction]} passes a vertex of the memory"
                    " curve"
                )
            else:
                event_name = state_names[span.direction] + _CONTINUATION_ENDING
            yield _event_at(span, span.begin.time, event_name)
            if span_before is not None:
                yield _event_at(span_before, span_before.end.time, event_name)
            yield from _load_extremes(span)
            span_before = span
    last_span = history.spans[-1]
    yield _event_at(
        last_span,
        last_span.end.time,
        "the path ends" if history.period is None else "the last cycle ends",
    )


def _is_same_piece(first_piece: Curve, second_piece: Curve) -> bool:
    """Whether two pieces of memory curves continue each other smoothly: both come from growth in
    stick along one curved segment of the load path, or they have equal anchor and slope.

    A memory curve M(eta) is the tangential force of the flat punches up to the load eta. The anchor
    of a piece is the instant of the load path through whose P and Q it passes. None: nothing
    sticks. An arc is a piece that is a curved part of the load path itself, on which the contact
    grew in full stick; only arcs have `arc_times`, of their ends.
    """
    if first_piece is None or second_piece is None:
        return first_piece is second_piece
    if (
        first_piece.arc_times is not None
        and second_piece.arc_times is not None
        and first_piece.anchor.segment is second_piece.anchor.segment
    ):
        return True  # where a cycle starts within an arc, the arc is two pieces
    return (
        # time, P and Q of the anchor; its first value, the load segment, may differ
        first_piece.anchor[1:] == second_piece.anchor[1:]
        and first_piece.slope == second_piece.slope
    )


def _load_extremes(span: Span) -> Iterator[Event]:
    """Events at which P or Q has a maximum or minimum in time, at the start of a span or inside it;
    a span is a time in full stick or with slip in one direction.

    The turning points of an ellipse are sought 0.1 rad beyond its ends too: the loads may turn
    smoothly at an end. One within 1e-9 before the start belongs to the span, one within 1e-9 before
    the end does not.
    """
    segment = span.segment
    time_difference = 1e-3 * (segment.end - segment.start)
    searched_segment = segment
    if is_plain_ellipse(segment):  # the cycle of an `EllipseLoad`
        searched_segment = replace(segment, start=segment.start - 0.1, end=segment.end + 0.1)
    for load_combination, load_name in ((NORMAL_LOAD, "P"), (TANGENTIAL_LOAD, "Q")):
        for turning_time in searched_segment.turning_points(load_combination):
            if (
                span.begin.time - _SAME_TIME_SHARE
                <= turning_time
                < span.end.time - _SAME_TIME_SHARE
            ):
                # Changes of the load from the turning point to just after, and to just before it.
                change_to_later_time = float(
                    segment.change_of(
                        load_combination, turning_time + time_difference, turning_time
                    )
                )
                change_to_earlier_time = float(
                    segment.change_of(
                        load_combination, turning_time - time_difference, turning_time
                    )
                )
                is_largest = change_to_later_time + change_to_earlier_time < 0
                extreme_name = "largest" if is_largest else "least"
                yield _event_at(span, turning_time, f"{load_name} {extreme_name}")


def _event_at(span: Span, time: float, name: str) -> Event:
    """An event with its `name` and loads, at a `time` of the segment of the load path in which a
    span lies; times outside the span are moved to its nearer end.

    A span is a time in full stick or with slip in one direction. It is later than the segment's own
    time by its `delay`; the event has the time of the path. The `front_load` of the event is P_c:
    the load that the flat punches up to the stick edge carry. The span gives the rest, the load P -
    P_c of the slip zones.
    """
    time_in_segment = min(max(time, span.begin.time), span.end.time)
    normal_load, tangential_load = (float(load) for load in span.segment.loads(time_in_segment))
    return Event(
        letter="",
        name=name,
        time=time_in_segment + span.delay,
        normal_load=normal_load,
        tangential_load=tangential_load,
        front_load=normal_load - float(span.slip_zone_load(time_in_segment)),
    )


def _time_by_letter(history: History) -> dict[str, float]:
    """Times of the events A to M of figure 2 of Davies, Barber and Hills (2012) on a steady ellipse
    of loads; empty without such an ellipse.

    At most of them P, Q, u = Q - f P or v = Q + f P (f friction) is largest or least, for the first
    time after the events before it. A is the start of the cycle. Full stick ends at B and I,
    forward slip at E and M, reverse slip at G. J is as long after I as I is after G: the stick edge
    is then where it was at G. A clockwise ellipse is mirrored, Q for -Q; times are in rad. Loads on
    a straight line, an ellipse of no area, have no letters: C and D would coincide.
    """
    if history.ellipse_of_cycle is None or history.steady_from is None:
        return {}
    friction_coefficient = history.spans[0].friction
    # amplitudes of P and of Q, and the lag of Q behind P
    ellipse = history.ellipse_of_cycle.ellipse
    assert ellipse is not None  # for the type checker: `ellipse_of_cycle` is one
    # positive for an anticlockwise ellipse
    signed_area_over_pi = (
        ellipse.amplitude[0] * ellipse.amplitude[1] * math.sin(ellipse.phase_radians)
    )
    if abs(signed_area_over_pi) <= 1e-12 * ellipse.amplitude[0] * ellipse.amplitude[1]:
        return {}
    rotation_sign = 1 if signed_area_over_pi > 0 else -1
    # `slip_combination`: Q - f P for 1, -Q - f P for -1
    load_combinations = {
        "u": slip_combination(rotation_sign, friction_coefficient),
        "-v": slip_combination(-rotation_sign, friction_coefficient),
        "P": NORMAL_LOAD,
        "Q": Combination(0.0, float(rotation_sign)),
    }
    # Which combination is largest (+) or least (-) at the event; v is least where -v is largest.
    extreme_by_letter = {
        "B": "u-",
        "C": "P+",
        "D": "Q+",
        "E": "u+",
        "F": "P-",
        "G": "-v+",
        "H": "Q-",
        "I": "u-",
        "K": "P+",
        "L": "Q+",
        "M": "u+",
    }
    revolution = 2 * math.pi
    time_of_event = {"A": history.ellipse_of_cycle.start}
    for letter, extreme_code in extreme_by_letter.items():
        # on the ellipse, up to whole revolutions
        time = ellipse.time_of_largest(load_combinations[extreme_code[:-1]])
        if extreme_code.endswith("-"):
            time += math.pi  # half a revolution from the maximum to the minimum
        revolutions_needed = math.ceil((max(time_of_event.values()) - time) / revolution - 1e-12)
        time_of_event[letter] = time + revolution * revolutions_needed
    return time_of_event | {"J": 2 * time_of_event["I"] - time_of_event["G"]}
