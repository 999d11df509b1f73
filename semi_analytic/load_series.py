"""Load series: paths of straight steps, two or a million of them, and the memory curve as a chain
of straight lines (Masing rule).

# notation: (P, Q) loads; M(eta) memory curve, tangential force of the flat punches up to the load
#           eta; s direction of slip; P_c load at the stick edge; level s Q - f P, which grows in
#           slip

A step loads in full stick and adds a line; or it slips, and its stick edge goes down through the
lines; or it unloads, on one side of the curve or along it. Every line is put on once and taken off
once. A line keeps its own length and rise, so that P - P_c is a sum of lengths and keeps its
digits, however little slips.

A step leaves one record for each line that it goes through. A record is a portion of the step; in
it P, P_c, Q and the level are linear in one another. Rows are taken a block at a time: what stays
in memory is what was asked for, and the lines of the curve.
"""

from __future__ import annotations

import gc
from array import array
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes import (
    InadmissibleLoadError,
    InputError,
    LoadedInstant,
    LoadPath,
    LoadSegment,
    Scene,
    StraightSegment,
    TimeSeriesLoad,
)
from scenes.array_types import Array
from semi_analytic.history import (
    INSTANT_SLACK_SHARE,
    cycles_to_follow,
    evenly_spaced_times,
    require_admissible,
    time_in_followed_path,
)
from semi_analytic.memory import Snapshot, repeat_tolerance

Indices = NDArray[np.int64]

# Share of the rates of P and Q below which growth of a level is rounding.
_RATE_ROUNDOFF_SHARE = 1e-14
# Share of f P by which a stick edge may miss the end of a line that it meets.
_STICK_EDGE_ROUNDOFF_SHARE = 4e-15
# Share of f P within which a path runs along the curve that it unloads, and share within which a
# line goes straight on.
_ON_CURVE_FORCE_SHARE = 8e-15
_SLOPE_ROUNDOFF_SHARE = 1e-15
# Steps that are followed at a time.
_STEPS_AT_ONCE = 10_000
# Rows of a measured series beyond which it is answered at its own rows, with pointwise fields at
# about so many of them.
_ROWS_OF_SHORT_SERIES = 1000
_ROWS_OF_THINNED_ANSWER = 400
# Share of a step within which an instant of the user is a row, and has the row's loads. These must
# be those of the instant to the 1e-9 of the admissibility check. Or, where that is more, so
# many times the distance between neighbouring floating-point numbers there.
_STEP_SHARE_AT_ROW = 1e-10
_FLOAT_SPACINGS_AT_ROW = 8


# --------------------------------------------------------------------------- the curve and one step
class Line(NamedTuple):
    """A memory curve M(eta), held by its uppermost straight line. Each line holds the one below it,
    down to eta = 0. None in place of the uppermost line stands for bodies out of contact.

    M(eta) is the tangential force of the flat punches up to the load eta, from 0 to P. Each line is
    a straight `memory.CurvePart`.

    Attributes
    ----------
    curve_below
        the line under this one, None if this one begins at eta = 0
    top_load, top_force
        eta and M at its upper end [force per thickness]
    load_length, force_rise
        growth of eta and of M along the line
    line_count
        number of lines of the curve up to this one
    """

    curve_below: Line | None
    top_load: float
    top_force: float
    load_length: float
    force_rise: float
    line_count: int

    @property
    def bottom_load(self) -> float:
        """eta at the lower end."""
        return self.curve_below.top_load if self.curve_below is not None else 0.0

    @property
    def bend(self) -> float:
        """0: along a line the slope of the memory does not change."""
        return 0.0

    @property
    def arc_times(self) -> None:
        """None: a line is no arc of a curved load path."""
        return

    @property
    def straight_slope(self) -> float:
        """dM/d eta."""
        return self.force_rise / self.load_length

    def slope_at(self, eta: Array) -> Array:
        """dM/d eta at loads (n,): (n,)."""
        return np.full(eta.shape, self.straight_slope)


_new_tuple = tuple.__new__  # half the time of the class, a million times
_LINE_OUT_OF_CONTACT = Line(None, 0.0, 0.0, 1.0, 0.0, 0)  # in place of a line where nothing touches
Station = tuple[float, float, float]
"""A point of a load step: P, Q and the share of the step that is over."""

# Kinds of a step: slip in either direction, full stick, unloading within the Coulomb limit.
_SLIPS_FORWARD = 1
_SLIPS_IN_REVERSE = -1
_STICKS = 0
_UNLOADS = 2


class Records(NamedTuple):
    """The records of the steps of a load path. A record is a portion of a step in which the stick
    edge moves along one line of the memory curve.

    Attributes
    ----------
    direction
        (m,) of slip: 1 forward, -1 in reverse, 0 none
    load_at_begin, load_at_end
        (m,) P at the start and at the end of the portion [force per thickness]
    slip_zone_load_at_begin, slip_zone_load_at_end
        (m,) P - P_c there, P_c the load at the stick edge
    level_rise
        (m,) growth in the portion of s Q - f P, s the direction
    step_share_at_end
        (m,) share of the step that is over at the end of the portion
    step_number
        (m,) number of the step, which is that of the row at its start
    """

    direction: Array
    load_at_begin: Array
    load_at_end: Array
    slip_zone_load_at_begin: Array
    slip_zone_load_at_end: Array
    level_rise: Array
    step_share_at_end: Array
    step_number: Indices

    def take(self, numbers: NDArray[np.bool_] | Indices | slice) -> Records:
        """The records of these numbers, of a mask or of a slice."""
        return Records._make(column[numbers] for column in self)

    def with_stick_edge_in_contact(self) -> Records:
        """These records with P_c >= 0. In a contact that slips throughout the sum of lengths of
        lines may be a last digit more than P.
        """
        return self._replace(
            slip_zone_load_at_begin=np.minimum(self.slip_zone_load_at_begin, self.load_at_begin),
            slip_zone_load_at_end=np.minimum(self.slip_zone_load_at_end, self.load_at_end),
        )

    def slipping(self) -> Records:
        """The records with slip in one direction."""
        return self.take(self.direction != 0)


class LineTable(NamedTuple):
    """The line of the memory curve M(eta) that the stick edge moves along in each of some records.

    Attributes
    ----------
    top_load, top_force
        (m,) eta and M at its upper end [force per thickness]
    load_length, force_rise
        (m,) growth of eta and of M along it
    """

    top_load: Array
    top_force: Array
    load_length: Array
    force_rise: Array

    @property
    def slope(self) -> Array:
        """dM/d eta."""
        return self.force_rise / self.load_length


_COUNT_OF_RECORD_NUMBERS = len(Records._fields) - 1  # the row is added later
_COUNT_OF_RECORD_AND_LINE_NUMBERS = _COUNT_OF_RECORD_NUMBERS + len(LineTable._fields)


class Recorder:
    """Collects the records of load steps while these are followed. A record is a portion of a step
    in which the stick edge moves along one line of the memory curve.

    All numbers go into one array: an object for each record would take three times as long. The
    lines themselves, and with them the memory curves, are stored only where `stores_curves`.

    Attributes
    ----------
    lines
        the line of each record; empty unless `stores_curves`
    numbers
        eleven of each record, one record after the other, in the order of `Recorder.add`
    """

    def __init__(self, stores_curves: bool) -> None:
        self.lines: list[Line | None] = []
        self.numbers = array("d")
        # how many numbers there were before the first step and after each step
        self._counts_of_numbers = [0]
        self._add_line = self.lines.append if stores_curves else None
        self._add_numbers = self.numbers.extend

    def add(
        self,
        line: Line | None,
        direction: int,
        begin_station: Station,
        end_station: Station,
        slip_zone_loads_at_ends: tuple[float, float] = (0.0, 0.0),
        level_rise: float = 0.0,
    ) -> None:
        """Store one record: a portion of a load step in which the stick edge moves along one line
        of the memory curve.

        It is stored as numbers: those of `Records` without the number of the step, then those of
        `LineTable`.

        Parameters
        ----------
        line
            the uppermost straight line of the memory curve (tangential force of the flat punches up
            to each load) that still sticks at the start; None for bodies out of contact
        direction
            of slip: s = 1 forward, -1 in reverse, 0 for none
        begin_station, end_station
            P, Q and the share of the step that is over, at both ends of the portion
        slip_zone_loads_at_ends
            P - P_c at both ends, P_c the load at the stick edge
        level_rise
            growth of s Q - f P in the portion, >= 0; 0 without slip
        """
        if self._add_line is not None:
            self._add_line(line)
        # line: eta and M at its upper end, growth of both along it; of None zeros and a length 1
        _, top_load, top_force, load_length, force_rise, _ = line or _LINE_OUT_OF_CONTACT
        load_at_begin, _, _ = begin_station
        load_at_end, _, step_share_at_end = end_station
        self._add_numbers(
            (
                direction,
                load_at_begin,
                load_at_end,
                *slip_zone_loads_at_ends,
                level_rise,
                step_share_at_end,
                top_load,
                top_force,
                load_length,
                force_rise,
            )
        )

    def end_step(self) -> None:
        """State that the records that come next belong to the next load step."""
        self._counts_of_numbers.append(len(self.numbers))

    def _columns(self) -> Array:
        """The numbers of all m records as columns, (11, m).

        Rows 0 to 6 are those of `Records`, without the number of the step: direction, P at start
        and end, P - P_c at start and end, level rise, share of the step. Rows 7 to 10 are those of
        `LineTable`: eta and M at the upper end, growth of eta and of M.
        """
        return np.frombuffer(self.numbers).reshape(-1, _COUNT_OF_RECORD_AND_LINE_NUMBERS).T

    def records(self) -> Records:
        """The records of all steps, with the number of the step that each belongs to."""
        n_records_of_steps = np.diff(self._counts_of_numbers) // _COUNT_OF_RECORD_AND_LINE_NUMBERS
        step_of_record = np.repeat(np.arange(len(n_records_of_steps)), n_records_of_steps)
        return Records._make([*self._columns()[:_COUNT_OF_RECORD_NUMBERS], step_of_record])

    def line_table(self) -> LineTable:
        """The line of the memory curve that each record goes through."""
        return LineTable(*self._columns()[_COUNT_OF_RECORD_NUMBERS:])


def kinds_of_steps(rows: Array, friction: float) -> NDArray[np.int8]:
    """Kind of each straight load step between rows (n + 1, 2) of P and Q, by Coulomb's law with f =
    `friction`, (n,).

    1 is slip forward, -1 slip in reverse, 0 full stick, 2 unloading. Where P does not fall a step
    slips if |dQ| > f dP, and sticks if not. Where P falls a step slips if |dQ| >= f |dP|. If not,
    or if dQ = 0 without friction, it is of kind 2. Its direction of slip then depends on the memory
    curve, the tangential force of the flat punches up to each load.
    """
    # dP and dQ of each step
    load_growth, tangential_growth = np.diff(rows, axis=0).T
    coulomb_limit_growth = friction * load_growth
    # _RATE_ROUNDOFF_SHARE: 1e-14
    force_roundoff = _RATE_ROUNDOFF_SHARE * (
        np.abs(tangential_growth) + np.abs(coulomb_limit_growth)
    )
    slips_forward = tangential_growth - coulomb_limit_growth > force_roundoff
    slips_in_reverse = -tangential_growth - coulomb_limit_growth > force_roundoff
    kinds = np.full(len(load_growth), _STICKS, dtype=np.int8)
    kinds[slips_in_reverse] = _SLIPS_IN_REVERSE
    kinds[slips_forward] = _SLIPS_FORWARD
    kinds[(load_growth < 0) & (slips_forward == slips_in_reverse)] = _UNLOADS
    return kinds


def _without_upper_share(curve: Line, cut_share: float) -> Line | None:
    """The memory curve without the upper share `cut_share` of its uppermost line, from 1 on without
    the whole line; None if nothing is left.

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta. A line
    has eta and M at its upper end, its growth `load_length` of eta and `force_rise` of M, which
    both shrink, and the lines below. `line_count` is the number of lines of the curve. The lowest
    line begins at eta = 0.
    """
    line_below, top_load, top_force, load_length, force_rise, line_count = curve
    if cut_share >= 1:
        return line_below
    remaining_length = (1 - cut_share) * load_length
    remaining_rise = (1 - cut_share) * force_rise
    # `_new_tuple` makes a line without the checks of the class
    if line_below is None:
        return _new_tuple(
            Line,
            (None, remaining_length, remaining_rise, remaining_length, remaining_rise, line_count),
        )
    return _new_tuple(
        Line,
        (
            line_below,
            top_load - cut_share * load_length,
            top_force - cut_share * force_rise,
            remaining_length,
            remaining_rise,
            line_count,
        ),
    )


def _curve_after_step(
    curve: Line | None,
    kind: int,
    begin_station: Station,
    end_station: Station,
    friction: float,
    recorder: Recorder,
) -> Line | None:
    """The memory curve after a straight load step; None for bodies out of contact.

    The memory curve M(eta) is the tangential force of the flat punches up to the normal load eta,
    for 0 <= eta <= P: a chain of straight lines. A `Line` is its uppermost line, and by
    `curve_below` the whole curve.

    Parameters
    ----------
    curve
        the memory curve before the step; None for bodies out of contact
    kind
        of the step: 1 slip forward, -1 slip in reverse, 0 full stick, 2 unloading, where P falls
        and |dQ| <= f |dP|
    begin_station, end_station
        P, Q and the share of the step that is over, at both ends
    friction
        f, coefficient of friction
    recorder
        takes a record for each line that the step goes through: slip, P and P - P_c at its start
        and end, P_c the load at the stick edge
    """
    if kind == _UNLOADS:
        return _curve_after_unloading(curve, begin_station, end_station, friction, recorder)
    if kind != _STICKS:
        return _curve_after_slip(curve, kind, begin_station, end_station, friction, recorder)
    load_at_begin, _, _ = begin_station
    load_at_end, _, _ = end_station
    # in full stick the curve changes only where P grows
    if load_at_end > load_at_begin:
        curve = _curve_after_loading_in_stick(curve, begin_station, end_station)
    recorder.add(curve, _STICKS, begin_station, end_station)
    return curve


def _curve_after_loading_in_stick(
    curve: Line | None, begin_station: Station, end_station: Station
) -> Line:
    """The memory curve after a step of growing P in full stick: a line of length dP in eta and of
    rise dQ is added on top.

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta. Where
    the line below has the slope of the step, both become one line.

    Parameters
    ----------
    curve
        uppermost line of the curve before the step: its growth `load_length` of eta and
        `force_rise` of M, the lines below and their number; None for bodies out of contact
    begin_station, end_station
        P, Q and the share of the step that is over, at both ends; only P and Q matter here
    """
    begin_load, begin_force, _ = begin_station
    end_load, end_force, _ = end_station
    line_length = end_load - begin_load
    line_rise = end_force - begin_force
    curve_below = curve
    if curve is not None:
        # The slopes of the line below and of the step, both times both lengths.
        slope_below_times_lengths = curve.force_rise * line_length
        step_slope_times_lengths = line_rise * curve.load_length
        # equal to 1e-15
        tolerance = _SLOPE_ROUNDOFF_SHARE * (
            abs(slope_below_times_lengths) + abs(step_slope_times_lengths)
        )
        if abs(slope_below_times_lengths - step_slope_times_lengths) <= tolerance:
            curve_below = curve.curve_below
            line_length += curve.load_length
            line_rise += curve.force_rise
    # The lowest line begins at P = 0: its length is the load, without the round-off of a sum.
    if curve_below is None:
        return _new_tuple(Line, (None, end_load, end_force, end_load, line_rise, 1))
    return _new_tuple(
        Line,
        (
            curve_below,
            end_load,
            end_force,
            line_length,
            line_rise,
            curve_below.line_count + 1,
        ),
    )


def _curve_after_slip(
    curve: Line | None,
    direction: int,
    begin_station: Station,
    end_station: Station,
    friction: float,
    recorder: Recorder,
) -> Line | None:
    """The memory curve after a straight load step with slip in one direction: its part above the
    stick edge is replaced by a line at the Coulomb limit, of slope s f up to (P, Q).

    # notation: P, Q normal and tangential load; f coefficient of friction; P_c load at the stick
    #           edge; s direction of slip; level s Q - f P, which grows in slip

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta, a chain
    of straight lines. The stick edge goes down through the lines while the level grows. A line of
    length l in eta and rise r in M is passed when the level has grown by f l - s r. P - P_c is the
    growth of P in the step plus the lengths of all lines passed. Where that is not above 0 no line
    is added.

    Parameters
    ----------
    curve
        the uppermost line of the memory curve before the step, which holds the lines below; None
        for bodies out of contact
    direction
        s, 1 of forward and -1 of reverse slip
    begin_station, end_station
        P, Q and the share of the step that is over, at both ends
    friction
        f, coefficient of friction
    recorder
        takes a record for each line that the stick edge goes through: slip, P and P - P_c at its
        start and end
    """
    begin_load, begin_force, step_share_at_begin = begin_station
    end_load, end_force, step_share_at_end = end_station
    load_growth = end_load - begin_load
    level_growth = direction * (end_force - begin_force) - friction * load_growth
    remaining_level_growth = level_growth
    # 4e-15 of f P
    level_roundoff = (
        _STICK_EDGE_ROUNDOFF_SHARE * friction * (begin_load if begin_load > end_load else end_load)
    )
    length_of_passed_lines = 0.0
    # the line of the memory curve in which the stick edge is
    line_at_stick_edge = curve
    # where the next record begins, and P - P_c there
    record_begin_station = begin_station
    slip_zone_load_at_record_begin = 0.0
    # A line at the limit slips already: the stick edge begins below it.
    if (
        line_at_stick_edge is not None
        and line_at_stick_edge.curve_below is not None
        and friction * line_at_stick_edge.load_length <= direction * line_at_stick_edge.force_rise
    ):
        length_of_passed_lines = line_at_stick_edge.load_length
        slip_zone_load_at_record_begin = line_at_stick_edge.load_length
        line_at_stick_edge = line_at_stick_edge.curve_below

    # The lines that the stick edge passes, from the top down.
    level_growth_to_pass_line = 0.0
    while line_at_stick_edge is not None:
        line_below, _, _, line_length, line_rise, _ = line_at_stick_edge
        level_growth_to_pass_line = friction * line_length - direction * line_rise
        # A stick edge that meets a knot at the very end of the step, to round-off, has not passed
        # it: what lies below may be at the limit already, and the edge would jump through it.
        if (
            remaining_level_growth <= level_growth_to_pass_line + level_roundoff
            or line_below is None
        ):
            break
        length_of_passed_lines += line_length
        if level_growth_to_pass_line > 0:
            remaining_level_growth -= level_growth_to_pass_line
            # of the way from `begin_station` to `end_station`
            fraction_at_knot = 1 - remaining_level_growth / level_growth
            slip_zone_load_at_knot = length_of_passed_lines + fraction_at_knot * load_growth
            # Q of a station inside a step is not recorded.
            record_end_station = (
                begin_load + fraction_at_knot * load_growth,
                begin_force,
                step_share_at_begin + fraction_at_knot * (step_share_at_end - step_share_at_begin),
            )
            recorder.add(
                line_at_stick_edge,
                direction,
                record_begin_station,
                record_end_station,
                (slip_zone_load_at_record_begin, slip_zone_load_at_knot),
                level_growth_to_pass_line,
            )
            record_begin_station = record_end_station
            slip_zone_load_at_record_begin = slip_zone_load_at_knot
        else:
            slip_zone_load_at_record_begin += line_length
        line_at_stick_edge = line_below

    # The stick edge ends within this line, whose upper part slips too.
    sticking_curve = line_at_stick_edge
    if (
        line_at_stick_edge is not None
        and level_growth_to_pass_line > 0
        and remaining_level_growth > 0
    ):
        # |Q| <= f P was checked: a level growth beyond the lowest line is round-off.
        share_of_line = min(remaining_level_growth / level_growth_to_pass_line, 1.0)
        length_of_passed_lines += share_of_line * line_at_stick_edge.load_length
        sticking_curve = _without_upper_share(line_at_stick_edge, share_of_line)
    slip_zone_load_at_end = length_of_passed_lines + load_growth
    recorder.add(
        line_at_stick_edge,
        direction,
        record_begin_station,
        end_station,
        (
            slip_zone_load_at_record_begin,
            slip_zone_load_at_end if slip_zone_load_at_end > 0 else 0.0,
        ),
        remaining_level_growth if remaining_level_growth > 0 else 0.0,
    )
    if not slip_zone_load_at_end > 0:
        return sticking_curve
    return _with_line_at_limit(
        sticking_curve, end_load, end_force, slip_zone_load_at_end, direction * friction
    )


def _with_line_at_limit(
    sticking_curve: Line | None, load: float, force: float, slip_zone_load: float, slope: float
) -> Line:
    """The memory curve after slip: the part that still sticks, and on top of it a line at the
    Coulomb limit that ends at P = `load`, Q = `force`.

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta. Where
    nothing sticks, the line begins at eta = 0.

    Parameters
    ----------
    sticking_curve
        uppermost line of the part that sticks, which holds the lines below and their number
        (`line_count`); None where nothing sticks
    slip_zone_load
        P - P_c, P_c the load at the stick edge: length of the line in eta
    slope
        of the line, +f or -f
    """
    if sticking_curve is None:
        return _new_tuple(Line, (None, load, force, load, slope * load, 1))
    line_count = sticking_curve.line_count + 1
    return _new_tuple(
        Line, (sticking_curve, load, force, slip_zone_load, slope * slip_zone_load, line_count)
    )


def _curve_after_unloading(
    curve: Line | None,
    begin_station: Station,
    end_station: Station,
    friction: float,
    recorder: Recorder,
) -> Line | None:
    """The memory curve after a step in which P falls and |dQ| <= f |dP|; None where the step ends
    out of contact.

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta. The step
    slips forward where the path runs above the memory curve M(P) in the P-Q plane: without slip the
    contact would carry M(P) alone, and forward slip carries the rest of Q. Below the curve it slips
    in reverse. Where the path crosses the curve the step is cut into parts. Each later point lies
    inside the Coulomb limits |dQ| <= f |dP| of the earlier ones, so that a cut does not change the
    memory curve.

    Parameters
    ----------
    curve
        uppermost line of the memory curve before the step
    begin_station, end_station
        P, Q and the share of the step that is over, at both ends
    friction
        f
    recorder
        takes a record for each line of the curve that the step goes through
    """
    begin_load, begin_force, step_share_at_begin = begin_station
    end_load, end_force, step_share_at_end = end_station
    load_drop = begin_load - end_load
    path_slope = (end_force - begin_force) / (end_load - begin_load)
    force_tolerance = _ON_CURVE_FORCE_SHARE * friction * begin_load
    # Each part has its direction of slip, and the fall of P from the start of the step to its end.
    *earlier_parts, last_part = _parts_of_unloading(curve, load_drop, path_slope, force_tolerance)
    part_begin_station = begin_station
    for part in earlier_parts:
        step_share_at_part_end = step_share_at_begin + part.load_drop_at_end / load_drop * (
            step_share_at_end - step_share_at_begin
        )
        part_end_station = (
            begin_load - part.load_drop_at_end,
            begin_force - path_slope * part.load_drop_at_end,
            step_share_at_part_end,
        )
        curve = _curve_after_unloading_part(
            curve, part.direction, part_begin_station, part_end_station, friction, recorder
        )
        part_begin_station = part_end_station
    curve = _curve_after_unloading_part(
        curve, last_part.direction, part_begin_station, end_station, friction, recorder
    )
    return curve if end_load > 0 else None


class _UnloadingPart(NamedTuple):
    """A part of an unloading step on one side of the memory curve.

    Attributes
    ----------
    load_drop_at_end
        how far P has fallen at its end since the start of the step [force per thickness]
    direction
        of slip: 1 forward, -1 in reverse, 0 none
    """

    load_drop_at_end: float
    direction: int


def _parts_of_unloading(
    curve: Line | None, load_drop: float, path_slope: float, force_tolerance: float
) -> list[_UnloadingPart]:
    """The parts of an unloading step, one at least, by the side of the memory curve M(P) on which
    the path runs: slip forward where Q > M(P), in reverse below it, none along it.

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta. The
    excess Q - M(P) is followed line by line of the curve, from the top down.

    Parameters
    ----------
    curve
        uppermost line of the curve, with its length in eta and its rise in M; `curve_below` is the
        next one
    load_drop, path_slope
        fall of P in the step; dQ/dP along it
    force_tolerance
        |Q - M(P)| up to which the path runs along the curve at the end of a line [force per
        thickness]
    """
    parts: list[_UnloadingPart] = []
    line = curve
    # fall of P from the start of the step to the upper end of the line; Q - M(P) there, and its
    # sign: 1, -1 or 0
    drop_above_line = 0.0
    excess_at_top = 0.0
    side_at_top = 0
    side_of_unfinished_part = 0
    while line is not None and drop_above_line < load_drop:
        # fall of P that remains of the step, and on this line
        remaining_drop = load_drop - drop_above_line
        drop_on_line = line.load_length if line.load_length < remaining_drop else remaining_drop
        # where the path leaves the line
        excess_at_bottom = (
            excess_at_top
            + line.force_rise * (drop_on_line / line.load_length)
            - path_slope * drop_on_line
        )
        side_at_bottom = 1 if excess_at_bottom > 0 else -1
        if abs(excess_at_bottom) <= force_tolerance:
            side_at_bottom = 0
        # The path crosses the curve within the line, or leaves it at a knot.
        if side_at_bottom * side_at_top < 0:
            drop_at_crossing = drop_above_line + drop_on_line * excess_at_top / (
                excess_at_top - excess_at_bottom
            )
            parts.append(_UnloadingPart(drop_at_crossing, side_at_top))
        elif drop_above_line > 0 and (side_at_bottom or side_at_top) != side_of_unfinished_part:
            parts.append(_UnloadingPart(drop_above_line, side_of_unfinished_part))
        side_of_unfinished_part = side_at_bottom or side_at_top
        drop_above_line += drop_on_line
        excess_at_top = excess_at_bottom
        side_at_top = side_at_bottom
        line = line.curve_below
    return [*parts, _UnloadingPart(load_drop, side_of_unfinished_part)]


def _curve_after_unloading_part(
    curve: Line | None,
    direction: int,
    begin_station: Station,
    end_station: Station,
    friction: float,
    recorder: Recorder,
) -> Line | None:
    """The memory curve after a part of an unloading step with slip in one direction, 1 or -1, or
    without slip, 0, down along the curve.

    The memory curve is the tangential force of the flat punches up to each load. `begin_station`
    and `end_station` are P, Q and the share of the step that is over, at both ends of the part.
    `recorder` takes a record for each straight line of the curve that the part goes through.
    """
    if direction:
        return _curve_after_slip(curve, direction, begin_station, end_station, friction, recorder)
    return _curve_after_retracing(curve, begin_station, end_station, recorder)


def _curve_after_retracing(
    curve: Line | None, begin_station: Station, end_station: Station, recorder: Recorder
) -> Line | None:
    """The memory curve after unloading along it, Q = M(P), without slip: its part above the new P
    is removed. None if nothing is left.

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta.

    Parameters
    ----------
    curve
        the memory curve, held by its uppermost straight line; `curve_below` is all under that line
    begin_station, end_station
        P, Q and the share of the step that is over
    recorder
        takes a record for each line that P passes: the line, direction 0, stations at both ends
    """
    begin_load, begin_force, step_share_at_begin = begin_station
    end_load, _, step_share_at_end = end_station
    load_drop = begin_load - end_load
    drop_below_line_top = load_drop  # from the upper end of the uppermost line to the new P
    record_begin_station = begin_station
    while curve is not None and drop_below_line_top > 0 and record_begin_station is not end_station:
        # over the line's length: above 1 if P passes the whole line
        removed_share_of_line = drop_below_line_top / curve.load_length
        drop_below_line_top -= curve.load_length
        if curve.curve_below is None or drop_below_line_top <= 0:
            record_end_station = end_station
        else:
            # part of the fall of P that is over where P leaves this line
            share_of_drop = 1 - drop_below_line_top / load_drop
            # Q of a station inside a step is not recorded: Q at the start holds its place.
            record_end_station = (
                begin_load - share_of_drop * load_drop,
                begin_force,
                step_share_at_begin + share_of_drop * (step_share_at_end - step_share_at_begin),
            )
        recorder.add(curve, 0, record_begin_station, record_end_station)
        record_begin_station = record_end_station
        curve = _without_upper_share(curve, removed_share_of_line)
    if record_begin_station is not end_station:
        recorder.add(curve, 0, record_begin_station, end_station)
    return curve


class StepBlock(NamedTuple):
    """The friction history of load steps between rows of P and Q.

    Attributes
    ----------
    rows
        (n + 1, 2) P and Q at the ends of the steps
    records
        of m portions of the steps, in each of which the stick edge moves along one line of the
        memory curve
    line_table, lines
        the line of each record, as numbers, and, where wanted, as a `Line`
    curve_at_end
        the memory curve at the last row, None out of contact
    largest_line_count
        the largest number of lines that the memory curve had
    """

    rows: Array
    records: Records
    line_table: LineTable
    lines: list[Line | None]
    curve_at_end: Line | None
    largest_line_count: int

    @property
    def largest_slip_zone_load(self) -> float:
        """The largest P - P_c [force per thickness], P_c the load at the stick edge; 0 where
        nothing slips.
        """
        loads_at_ends = np.maximum(
            self.records.slip_zone_load_at_begin, self.records.slip_zone_load_at_end
        )
        return float(np.max(loads_at_ends, initial=0.0))


def line_count_of(curve: Line | None) -> int:
    """Number of straight lines of a memory curve; 0 for None, bodies out of contact."""
    return curve.line_count if curve is not None else 0


def follow(
    curve: Line | None, rows: Array, friction: float, stores_curves: bool = False
) -> StepBlock:
    """Friction history of straight load steps between `rows` of P and Q, (n + 1, 2), from a given
    memory curve on: slip in each portion of a step, and the memory curve at the last row.

    The memory curve is the tangential force of the flat punches up to each load, a chain of
    straight lines. Its uppermost line holds the lines below and their number. `curve` is that at
    the first row, None for bodies out of contact.

    A record is a portion of a step in which the stick edge moves along one line. It holds the load
    P - P_c of the slip zones, P_c that at the stick edge. Where `stores_curves` the memory curve of
    each record is stored too. The loads must be admissible, |Q| <= f P and P >= 0. f is the
    friction.

    >>> block = follow(None, np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [2.0, -0.5]]), 0.5)
    >>> (
    ...     block.records.slip_zone_load_at_end.tolist(),
    ...     block.largest_line_count,
    ... )  # P - P_c = Q/f, then dQ/(2 f)
    ([0.0, 1.0, 1.0], 2)
    """
    recorder = Recorder(stores_curves)
    # A path that unloads fully may end below 0 by round-off.
    clipped_rows = np.stack([np.maximum(rows[:, 0], 0.0), rows[:, 1]], axis=1)
    with _garbage_collector_off():
        curve_at_end, largest_line_count = _follow_rows(curve, clipped_rows, friction, recorder)
    return StepBlock(
        rows=clipped_rows,
        records=recorder.records().with_stick_edge_in_contact(),
        line_table=recorder.line_table(),
        lines=recorder.lines,
        curve_at_end=curve_at_end,
        largest_line_count=largest_line_count,
    )


@contextmanager
def _garbage_collector_off() -> Iterator[None]:
    """Context without Python's garbage collector, for millions of lines of memory curves.

    None of these objects refers to itself. The collector would look at all of them again and again,
    for half of the time.
    """
    was_collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_collecting:
            gc.enable()


def _follow_rows(
    curve: Line | None, rows: Array, friction: float, recorder: Recorder
) -> tuple[Line | None, int]:
    """The memory curve at the last of `rows` of P and Q, (n + 1, 2), and the largest number of
    straight lines that it had on the way.

    The memory curve is the tangential force of the flat punches up to each load, a chain of lines.
    `curve` is that at the first row, None for bodies out of contact. `recorder` takes a record for
    each line that a step goes through; f is `friction`.
    """
    largest_line_count = 0
    load, force = rows[0].tolist()
    # of each step by Coulomb's law: slip forward or in reverse, full stick, or unloading
    kinds = kinds_of_steps(rows, friction).tolist()
    for (next_load, next_force), kind in zip(rows[1:].tolist(), kinds, strict=True):
        # P, Q and the share of the step that is over
        begin_station = (load, force, 0.0)
        end_station = (next_load, next_force, 1.0)
        curve = _curve_after_step(curve, kind, begin_station, end_station, friction, recorder)
        if next_load == 0:
            curve = None  # unloaded: a line left by round-off has no length
        load = next_load
        force = next_force
        recorder.end_step()
        if curve is not None and curve.line_count > largest_line_count:
            largest_line_count = curve.line_count
    return curve, largest_line_count


def _knots_of(curve: Line | None) -> Array:
    """eta and M(eta) at the knots of a memory curve, the ends of its lines, (2, n), ascending from
    (0, 0), the one knot of None, bodies out of contact. M(eta) is the tangential force of the flat
    punches up to the load eta.
    """
    knots = []
    while curve is not None:
        knots.append((curve.top_load, curve.top_force))
        curve = curve.curve_below
    knots.append((0.0, 0.0))
    return np.array(knots[::-1]).T


def _is_same_memory(
    first_curve: Line | None, second_curve: Line | None, friction: float, tolerance: float
) -> bool:
    """Whether two memory curves M(eta), tangential force of the flat punches up to the load eta,
    agree, so that a cycle between them is steady.

    Their largest eta must agree within `tolerance` times the larger one. M at the ends of the lines
    of both must agree within `tolerance` times f P, P the larger of these loads. f is the friction.
    """
    # eta and M at the ends of the lines, ascending from (0, 0)
    first_loads, first_forces = _knots_of(first_curve)
    second_loads, second_forces = _knots_of(second_curve)
    loads_of_knots = np.union1d(first_loads, second_loads)
    largest_load = loads_of_knots[-1]
    force_differences = np.abs(
        np.interp(loads_of_knots, first_loads, first_forces)
        - np.interp(loads_of_knots, second_loads, second_forces)
    )
    if abs(first_loads[-1] - second_loads[-1]) > tolerance * largest_load:
        return False
    return bool(np.all(force_differences <= tolerance * friction * largest_load))


# ----------------------------------------------------------------------------------- the whole path
class PathPart(NamedTuple):
    """A part of a load path, its initial loading or one cycle.

    Attributes
    ----------
    rows
        (m + 1, 3) time, P and Q at the ends of its steps
    delay
        how much later the part is than the times of its rows
    curve_at_begin
        memory curve at its first row, None out of contact
    """

    rows: Array
    delay: float
    curve_at_begin: Line | None = None

    @property
    def largest_load(self) -> float:
        """The largest P [force per thickness]."""
        return float(np.max(self.rows[:, 1]))


def share_of_largest_load(load: float, part: PathPart) -> float:
    """A load, such as P - P_c, over the largest P of a part of the path; 0 where it has no load."""
    largest_load = part.largest_load
    return load / largest_load if largest_load > 0 else 0.0


@dataclass(frozen=True, eq=False)
class LoadSeries:
    """A path of straight steps that has been followed.

    Attributes
    ----------
    friction
        f
    parts
        initial loading, where the path has a period, and each solved cycle; the whole path
        where it has none
    first_cycle_part
        number of the first cycle among the parts
    steady_from
        index of the first cycle that ends in the state it started from, None if none did; a path
        without a period counts as one cycle
    period
        duration of a cycle, None for a path that does not repeat
    covered
        for each whole cycle that the answer covers, the index of the solved cycle that it is or
        is a copy of
    repeats
        whether cycles after the steady one are copies
    is_long_measurement
        whether it is a measured series of more than 1,000 rows, which is answered at its rows
    """

    friction: float
    parts: tuple[PathPart, ...]
    first_cycle_part: int
    steady_from: int | None
    period: float | None = None
    covered: tuple[int, ...] = (0,)
    repeats: bool = False
    is_long_measurement: bool = False

    @property
    def cycles(self) -> tuple[PathPart, ...]:
        """The solved cycles."""
        return self.parts[self.first_cycle_part :]

    @property
    def covered_parts(self) -> list[int]:
        """For each whole cycle that the answer covers, its number among the parts."""
        return [cycle + self.first_cycle_part for cycle in self.covered]

    @property
    def largest_load(self) -> float:
        """The largest P [force per thickness]."""
        return max(part.largest_load for part in self.parts)

    @cached_property
    def times(self) -> Array:
        """Times of all rows, (n,) ascending."""
        first_row = self.parts[0].rows[:1, 0]
        return np.concatenate([first_row, *(part.rows[1:, 0] + part.delay for part in self.parts)])

    @cached_property
    def first_steps(self) -> Indices:
        """Number of the first step of each part, and behind them the number of all steps."""
        return np.cumsum([0, *(len(part.rows) - 1 for part in self.parts)])

    def default_times(self, last_cycle_only: bool, thins_rows: bool) -> tuple[Array, int]:
        """Instants of the answer where the user gives none, ascending, and the number of rows that
        are left out of them.

        Of a measured path of more than 1,000 rows the instants are all rows, or about 400 of them
        if `thins_rows`. Else they are about 400 a cycle and 100 of the initial loading, evenly
        spread over the records, portions of the load steps. With `last_cycle_only` only the last
        part of the path counts.
        """
        first_part_number = len(self.parts) - 1 if last_cycle_only else 0
        if self.is_long_measurement:
            # The first step of a part begins at the row of the same number.
            row_times = self.times[self.first_steps[first_part_number] :]
            stride = max(len(row_times) // _ROWS_OF_THINNED_ANSWER, 1) if thins_rows else 1
            instants = np.unique(np.append(row_times[::stride], row_times[-1]))
            return instants, len(row_times) - len(instants)
        instants_of_parts = [
            self._even_times_of_part(part_number)
            for part_number in range(first_part_number, len(self.parts))
        ]
        return np.unique(np.concatenate(instants_of_parts)), 0

    def _even_times_of_part(self, part_number: int) -> Array:
        """Ascending instants of one part of the path: about 400 of a cycle, 100 of the initial
        loading, evenly spread over each record, with both its ends.

        A record is a portion of a load step in which the stick edge moves along one line of the
        memory curve (tangential force of the flat punches up to each load). The part has its rows
        of time, P and Q and the memory curve at its first row.
        """
        part = self.parts[part_number]
        records = follow(part.curve_at_begin, part.rows[:, 1:], self.friction).records
        row_times = self.times[self.first_steps[part_number] :]
        step_begin_time = row_times[records.step_number]
        step_end_time = row_times[records.step_number + 1]
        # A record ends at the share `step_share_at_end` of its step.
        time_inside_step = step_begin_time + records.step_share_at_end * (
            step_end_time - step_begin_time
        )
        record_end_times = np.where(records.step_share_at_end == 1, step_end_time, time_inside_step)
        sorted_end_times = np.unique(np.append(row_times[0], record_end_times))
        return evenly_spaced_times(
            sorted_end_times, is_initial_loading=part_number < self.first_cycle_part
        )

    def locate(self, time: Array) -> tuple[Indices, Array, Array]:
        """Position of instants (n,) in the load path: number of the load step, share of that step
        that is over, and share of it within which two instants count as one, (n,) each.

        Step k goes from row k of the path to row k + 1. An instant at a row belongs to the step
        that ends there. A time beyond the followed path is reduced by whole periods. InputError for
        a time outside the path.
        """
        row_times = self.times
        step_durations = np.diff(row_times)
        # times within the followed path, and how far outside they may be by round-off
        path_time, time_slack = time_in_followed_path(
            time, float(row_times[0]), float(row_times[-1]), self.period
        )
        # Slack as a share of each step: eight spacings of floating-point numbers or 1e-10 of the
        # step, but never more than the time by which an instant may miss the whole path.
        roundoff_share = (
            _FLOAT_SPACINGS_AT_ROW * np.spacing(np.max(np.abs(row_times))) / step_durations
        )
        slack_share_of_each_step = np.minimum(
            time_slack / step_durations, np.maximum(_STEP_SHARE_AT_ROW, roundoff_share)
        )
        row_number_at_end = np.clip(
            np.searchsorted(row_times, path_time, side="left"), 1, len(row_times) - 1
        )
        # An instant that misses a row by round-off is still at the row.
        row_number_at_begin = row_number_at_end - 1
        is_at_begin_of_step = (row_number_at_end > 1) & (
            path_time - row_times[row_number_at_begin]
            <= slack_share_of_each_step[row_number_at_begin] * step_durations[row_number_at_begin]
        )
        step_number = row_number_at_begin - is_at_begin_of_step
        share_of_step = (path_time - row_times[step_number]) / step_durations[step_number]
        slack_share_at_instant = slack_share_of_each_step[step_number]
        share_of_step = np.where(
            share_of_step > 1 - slack_share_at_instant, 1.0, np.maximum(share_of_step, 0.0)
        )
        return step_number, share_of_step, slack_share_at_instant

    def cycles_beyond(self, time: Array) -> Indices:
        """Number of whole cycles by which instants lie beyond the path that was followed, (n,); 0
        without a period.

        The cycles beyond are copies of the last one that was followed, which is steady.
        """
        if self.period is None:
            return np.zeros(len(time), dtype=int)
        # reduced by whole periods, into the followed path
        path_time, _ = time_in_followed_path(
            time, float(self.times[0]), float(self.times[-1]), self.period
        )
        return np.rint((time - path_time) / self.period).astype(int)


def series_of(scene: Scene, time: Array | None) -> LoadSeries:
    """Friction history of a scene whose load path is straight from each row of time, P and Q to the
    next.

    As many cycles are followed as the instants `time` (n,) need; without them, until a cycle ends
    in the state of friction in which it began, `scene.cycles` at most.

    Raises
    ------
    InadmissibleLoadError
        For gross sliding or separation, with the instant and the loads.
    """
    friction_coefficient = scene.friction.coefficient
    loading_rows, cycle_rows = _rows_of_loading_and_cycle(scene)
    # _ROWS_OF_SHORT_SERIES: 1000 rows of a measured series
    is_long_measurement = (
        isinstance(scene.load, TimeSeriesLoad)
        and len(scene.load.kept_rows()) > _ROWS_OF_SHORT_SERIES
    )
    # InadmissibleLoadError at the first bad instant
    require_admissible_rows(loading_rows, friction_coefficient)
    if not len(cycle_rows):
        load_series = _one_way_series(friction_coefficient, loading_rows)
        return replace(load_series, is_long_measurement=is_long_measurement)
    require_admissible_rows(cycle_rows, friction_coefficient)

    # number of cycles to follow at most, and of whole cycles up to the last instant
    cycle_start = float(cycle_rows[0, 0])
    period = float(cycle_rows[-1, 0] - cycle_rows[0, 0])
    most_cycles, n_whole_cycles = cycles_to_follow(cycle_start, period, scene.cycles, time)
    cycle_parts = (
        PathPart(cycle_rows, cycle_number * period) for cycle_number in range(most_cycles)
    )
    load_series = _follow_cycles(
        friction_coefficient, PathPart(loading_rows, 0.0), cycle_parts, period, n_whole_cycles
    )
    return replace(load_series, is_long_measurement=is_long_measurement)


def _rows_of_loading_and_cycle(scene: Scene) -> tuple[Array, Array]:
    """Rows of time, P and Q of the initial loading, (n, 3), and of one cycle, (m, 3), of a scene
    whose load path is straight between them; (0, 3) where it has none.

    A measured series gives its rows as they are, since a load segment for each of a million would
    take a gigabyte. A series that repeats is loaded from the first row to the second, where the
    cycle begins.
    """
    scene_load = scene.load
    if isinstance(scene_load, TimeSeriesLoad):
        rows = scene_load.series()
        return (rows[:2], rows[1:]) if scene_load.repeats else (rows, rows[:0])
    path = scene_load.path()
    return _rows_of(path.initial_loading), _rows_of(path.cycle)


def _rows_of(segments: Sequence[LoadSegment]) -> Array:
    """Time, P and Q at the ends of m load segments, one after the other: (m + 1, 3), or (0, 3) of
    none.
    """
    instants = [(segment.start, segment) for segment in segments[:1]]
    instants += [(segment.end, segment) for segment in segments]
    rows = []
    for time, segment in instants:
        normal_load, tangential_load = segment.loads(time)
        rows.append([time, float(normal_load), float(tangential_load)])
    return np.array(rows).reshape(-1, 3)


def straight_series(path: LoadPath, friction: float, time: Array) -> LoadSeries:
    """Friction history of straight load steps between the loads of a path at `time`, (n,)
    ascending, in place of the path itself; `friction` is f.

    The first step begins at the start of the path, where P and Q of the path are taken too. A cycle
    that begins between two of the times begins on the straight line between their loads. Cycles
    need not be alike: all up to the last time are followed.

    Raises
    ------
    InputError
        For paths with bulk stress or tilt, and for times that do not ascend; the message names the
        option `straight_steps`.
    """
    if path.has_bulk_or_tilt:
        raise InputError("straight_steps: not with bulk stress or tilt")
    if np.any(np.diff(time) <= 0):
        raise InputError("straight_steps: the times must ascend, no two of them equal")
    row_times = np.concatenate([[path.start], time]) if float(time[0]) > path.start else time
    if len(row_times) < 2:
        raise InputError(
            f"straight_steps: no time is after the start of the load path, {path.start:.6g}"
        )
    normal_load, tangential_load = path.at(row_times)
    rows = np.stack([row_times, normal_load, tangential_load], axis=1)
    require_admissible_rows(rows, friction)
    # 1e-9 of a period
    time_slack = INSTANT_SLACK_SHARE * (path.period or 0.0)
    if path.period is None or row_times[-1] <= path.cycle_start + time_slack:
        return _one_way_series(friction, rows)

    _, n_whole_cycles = cycles_to_follow(path.cycle_start, path.period, 1, time)
    cycle_starts = np.asarray(
        path.cycle_start + path.period * np.arange(n_whole_cycles + 1), dtype=np.float64
    )
    loading_part, *cycle_parts = _parts_between_cycle_starts(rows, cycle_starts, time_slack)
    return _follow_cycles(
        friction, loading_part, cycle_parts, path.period, n_whole_cycles, repeats=False
    )


def _parts_between_cycle_starts(
    rows: Array, cycle_starts: Array, time_slack: float
) -> Iterator[PathPart]:
    """The parts of a load path of straight steps: initial loading, then one cycle after the other.
    The last row of one part is the first row of the next.

    A cycle that starts between two rows gets a row of its own, on the straight line between them.

    Parameters
    ----------
    rows
        (n, 3) time, P and Q
    cycle_starts
        (c,) times at which cycles start
    time_slack
        a row that is nearer to the start of a cycle than this time is at it
    """
    times = rows[:, 0]
    is_among_times = (np.abs(times[:, None] - cycle_starts) <= time_slack).any(axis=0)
    missing_cycle_starts = cycle_starts[~is_among_times & (cycle_starts < times[-1])]
    all_times = np.sort(np.concatenate([times, missing_cycle_starts]))
    all_rows = np.stack(
        [
            all_times,
            np.interp(all_times, times, rows[:, 1]),
            np.interp(all_times, times, rows[:, 2]),
        ],
        axis=1,
    )
    # of each step, 0 for the initial loading
    cycle_number = np.searchsorted(cycle_starts - time_slack, all_times[:-1], side="right")
    first_row_numbers_of_cycles = np.flatnonzero(np.diff(cycle_number, prepend=0)).tolist()
    boundary_row_numbers = [0, *first_row_numbers_of_cycles, len(all_times) - 1]
    for first_row_number, last_row_number in pairwise(boundary_row_numbers):
        yield PathPart(all_rows[first_row_number : last_row_number + 1], 0.0)


def require_admissible_rows(rows: Array, friction: float) -> None:
    """Refuse a load path on which the contact slides as a whole, |Q| > f P, or separates, P < 0:
    InadmissibleLoadError at the first such instant, with its loads.

    `rows` (n, 3) are time, P and Q; f is `friction`. The admissible loads are a convex set, so that
    loads on a straight line between two admissible rows are admissible.
    """
    normal_load = rows[:, 1]
    tangential_load = rows[:, 2]
    # 1e-14 of the largest load
    load_slack = _RATE_ROUNDOFF_SHARE * float(np.max(np.abs(normal_load)))
    is_separated = normal_load < -load_slack
    is_sliding = np.abs(tangential_load) > friction * (normal_load + load_slack)
    bad_row_numbers = np.flatnonzero(is_separated | is_sliding)
    if not len(bad_row_numbers):
        return
    bad_row_number = bad_row_numbers[0]
    time_of_row_before, *loads_of_row_before = rows[max(int(bad_row_number) - 1, 0)].tolist()
    bad_time, *bad_loads = rows[bad_row_number].tolist()
    segment_to_bad_row = StraightSegment(
        time_of_row_before, bad_time, tuple(loads_of_row_before), tuple(bad_loads)
    )
    # It raises with the instant between the rows at which the limit is passed. Where that is within
    # round-off it does not raise: then the row itself is named.
    require_admissible([segment_to_bad_row], friction)
    reason = "separation" if is_separated[bad_row_number] else "gross sliding"
    raise InadmissibleLoadError(reason, LoadedInstant(bad_time, *bad_loads), friction=friction)


def _one_way_series(friction: float, rows: Array) -> LoadSeries:
    """The series of a path that does not repeat, rows (n, 3) of time, P and Q. It ends in the state
    in which it began where it ends unloaded.
    """
    last_load = rows[-1, 1]
    steady_from = 0 if last_load <= 0 else None
    return LoadSeries(friction, (PathPart(rows, 0.0),), first_cycle_part=0, steady_from=steady_from)


def _follow_cycles(
    friction: float,
    loading_part: PathPart,
    cycle_parts: Iterable[PathPart],
    period: float,
    n_whole_cycles: int,
    *,
    repeats: bool = True,
) -> LoadSeries:
    """Friction history of an initial loading and of cycles of straight steps, up to the first cycle
    that ends in the state in which it began; f is `friction`.

    Parameters
    ----------
    loading_part, cycle_parts
        rows of time, P and Q of the initial loading and of the cycles that are followed at most
    period
        duration of a cycle
    n_whole_cycles
        number of whole cycles that the answer covers; 0 for all that are followed, or for the
        first one where they do not repeat
    repeats
        whether all cycles have the same loads, as in a path that repeats. Those after a steady one
        are then copies and are not followed. Else all are followed.
    """
    followed_cycles: list[PathPart] = []
    steady_from = None  # number of the first steady cycle
    # memory curve M(eta), the tangential force of the flat punches up to each load eta
    curve = None
    for _, block in blocks_of_part(loading_part, friction):
        curve = block.curve_at_end
    for cycle_part in cycle_parts:
        curve_at_begin = curve
        followed_cycle = cycle_part._replace(curve_at_begin=curve_at_begin)
        followed_cycles.append(followed_cycle)
        largest_slip_zone_load = 0.0
        for _, block in blocks_of_part(followed_cycle, friction):
            curve = block.curve_at_end
            largest_slip_zone_load = max(largest_slip_zone_load, block.largest_slip_zone_load)
        # Where less slips in a cycle its memory curves must agree more closely: the tolerance
        # follows from the largest P - P_c over the largest P, P_c the load at the stick edge.
        slip_zone_share = share_of_largest_load(largest_slip_zone_load, cycle_part)
        tolerance = repeat_tolerance(slip_zone_share)
        if steady_from is None and _is_same_memory(curve_at_begin, curve, friction, tolerance):
            steady_from = len(followed_cycles) - 1
            if repeats:
                break

    # for each cycle that the answer covers, the followed cycle that it is or is a copy of
    n_covered_cycles = n_whole_cycles
    if not n_whole_cycles:
        n_covered_cycles = len(followed_cycles) if repeats else 1
    followed_cycle_number_of_covered_cycle = tuple(
        min(cycle_number, len(followed_cycles) - 1) for cycle_number in range(n_covered_cycles)
    )
    return LoadSeries(
        friction,
        (loading_part, *followed_cycles),
        first_cycle_part=1,
        steady_from=steady_from,
        period=period,
        covered=followed_cycle_number_of_covered_cycle,
        repeats=repeats,
    )


def blocks_of_part(
    part: PathPart, friction: float, stores_curves: bool = False
) -> Iterator[tuple[int, StepBlock]]:
    """Number of the first step, and friction history, of each block of at most 10,000 load steps of
    a `part` of the path, f = `friction`.

    The part holds its rows of time, P and Q and the memory curve at its first row. The memory curve
    is the tangential force of the flat punches up to each load. Each block begins with the memory
    curve at the end of the block before. Where `stores_curves`, blocks also hold the memory curve
    of each record, a portion of a step in which the stick edge moves along one line of it.
    """
    curve = part.curve_at_begin
    for first_row_number in range(0, len(part.rows) - 1, _STEPS_AT_ONCE):
        block = follow(
            curve,
            part.rows[first_row_number : first_row_number + _STEPS_AT_ONCE + 1, 1:],
            friction,
            stores_curves,
        )
        yield first_row_number, block
        curve = block.curve_at_end


class _StateColumns(NamedTuple):
    """Friction states at n instants, (n,) each.

    Attributes
    ----------
    load, force
        P and Q [force per thickness]
    slip_zone_load
        P - P_c, P_c the load at the stick edge
    direction
        of slip: 1 forward, -1 in reverse, 0 none
    piece_number
        number of the memory curve's line at the stick edge
    force_error
        M(P) - Q, the error of the tangential force, 0 but for round-off
    """

    load: Array
    force: Array
    slip_zone_load: Array
    direction: Array
    piece_number: Indices
    force_error: Array


class States:
    """Friction states at the instants of a request, collected block by block of load steps; where
    `stores_curves` also their memory curves.
    """

    def __init__(self, friction: float, stores_curves: bool) -> None:
        self.friction = friction
        self.stores_curves = stores_curves
        self._columns: list[_StateColumns] = []
        self._lines: list[Line | None] = []

    def add(
        self, block: StepBlock, step_number: Indices, share_of_step: Array, slack_share: Array
    ) -> None:
        """Add the friction state at instants (n,) within a block of load steps: P, Q, P - P_c,
        direction of slip, and the line of the memory curve at the stick edge.

        The memory curve M(eta) is the tangential force of the flat punches up to the load eta. M(P)
        - Q, zero but for round-off, is stored as a check. The lines themselves are stored only
        where `stores_curves`.

        Parameters
        ----------
        block
            rows of P and Q, records of the steps, and the line of each record (`line_table` as
            numbers, `lines`). A step has a record for each line of the memory curve that it goes
            through.
        step_number, share_of_step
            (n,) number within the block of the load step in which each instant lies, and share of
            that step that is over
        slack_share
            (n,) share of the step by which an instant may be beyond the end of a record and count
            as that end
        """
        if not len(step_number):
            return
        records = block.records
        record_number = _record_at(records, step_number, share_of_step - slack_share)
        # An instant that counts as the end of a record has the loads of that end.
        share_up_to_record_end = np.minimum(share_of_step, records.step_share_at_end[record_number])
        normal_load, tangential_load = _loads_at(block.rows, step_number, share_up_to_record_end)
        line_of_instant = LineTable(*(column[record_number] for column in block.line_table))
        direction = records.direction[record_number]
        slip_zone_load = _slip_zone_load_at(
            records, record_number, share_up_to_record_end, normal_load, line_of_instant
        )
        # M at the stick edge, which lies on the line; M(P) by slope f or -f from there
        stick_edge_load = normal_load - slip_zone_load
        force_at_stick_edge = line_of_instant.top_force - line_of_instant.slope * (
            line_of_instant.top_load - stick_edge_load
        )
        force_in_slip_zone = direction * self.friction * slip_zone_load
        force_error = force_at_stick_edge + force_in_slip_zone - tangential_load

        # Each line that is needed is stored once.
        number_among_new_lines = np.zeros(len(step_number), dtype=np.intp)
        n_lines_before = len(self._lines)
        if self.stores_curves:
            record_numbers_with_instants, number_among_new_lines = np.unique(
                record_number, return_inverse=True
            )
            self._lines += [
                block.lines[record_number_with_instants]
                for record_number_with_instants in record_numbers_with_instants.tolist()
            ]
        self._columns.append(
            _StateColumns(
                normal_load,
                tangential_load,
                slip_zone_load,
                direction,
                number_among_new_lines + n_lines_before,
                force_error,
            )
        )

    def snapshot(self, time: Array, number_of_instant: Indices) -> tuple[Snapshot, Array]:
        """Friction states at all instants that were added, in the order of `time` (n,), and M(P) -
        Q of each, which is 0 but for round-off [force per thickness].

        M(P) is the tangential force that the memory curve carries. A state is P, Q, the load
        P - P_c of the slip zones, the direction of slip and the line of the memory curve at the
        stick edge; P_c is the load there. In the `Snapshot` lines are pieces of the memory curve.
        `number_of_instant` (n,) is, for each of the times, the number of its instant among those
        that were added.
        """
        columns_of_blocks = zip(*self._columns, strict=True)
        states = _StateColumns._make(
            np.concatenate(column)[number_of_instant] for column in columns_of_blocks
        )
        snapshot = Snapshot(
            time=time,
            load=states.load,
            force=states.force,
            slip_zone_load=states.slip_zone_load,
            direction=states.direction.astype(np.int64),
            piece_number=states.piece_number,
            sticking_pieces=tuple(self._lines) or (None,),
            friction=self.friction,
        )
        return snapshot, states.force_error


def _record_at(records: Records, step: Indices, share_of_step: Array) -> Indices:
    """Number of the record that holds each instant, (n,), given by the number of its step and the
    share of the step that is over. A step has one record or more, each up to its
    `step_share_at_end`.
    """
    record_number = np.searchsorted(
        records.step_number + records.step_share_at_end, step + share_of_step, side="left"
    )
    record_number = np.minimum(record_number, len(records.step_number) - 1)
    return record_number + (records.step_number[record_number] < step)


def _slip_zone_load_at(
    records: Records,
    record_number: Indices,
    share_of_step: Array,
    load: Array,
    line_of_instant: LineTable,
) -> Array:
    """P - P_c at n instants, (n,), P_c the load at the stick edge; 0 where nothing slips.

    In a record, a portion of a load step, it changes in proportion to the share of the record that
    is over. The stick edge stays on the record's line of the memory curve.

    Parameters
    ----------
    records, record_number
        records of the load steps, and (n,) the number of the one that holds each instant
    share_of_step, load
        (n,) share of the step that is over, and P
    line_of_instant
        (n,) eta at the upper end of the record's line, and its growth along it
    """
    slip_zone_load_at_begin = records.slip_zone_load_at_begin[record_number]
    slip_zone_growth = (records.slip_zone_load_at_end - records.slip_zone_load_at_begin)[
        record_number
    ]
    share_of_record = _share_of_record(records, record_number, share_of_step)
    slip_zone_load = slip_zone_load_at_begin + share_of_record * slip_zone_growth
    least_slip_zone_load = np.maximum(load - line_of_instant.top_load, 0.0)
    largest_slip_zone_load = np.maximum(
        load - (line_of_instant.top_load - line_of_instant.load_length), 0.0
    )
    return np.where(
        records.direction[record_number] != 0,
        np.clip(slip_zone_load, least_slip_zone_load, largest_slip_zone_load),
        0.0,
    )


def _share_of_record(records: Records, record_number: Indices, share_of_step: Array) -> Array:
    """Share of a record that is over at each of n instants, (n,), 0 at its start and 1 at its end.
    It follows from the share of its load step that is over then.

    A record is a portion of a load step. A step has one record or more. Each ends where the share
    `step_share_at_end` of the step is over; the next one begins there.

    Parameters
    ----------
    records, record_number
        records of the load steps, and (n,) the number of the one that holds each instant
    share_of_step
        (n,) share of the step that is over
    """
    is_first_record_of_step = np.diff(records.step_number, prepend=-1) > 0
    step_share_at_end_of_record_before = np.append(0.0, records.step_share_at_end[:-1])
    step_share_at_begin = np.where(
        is_first_record_of_step, 0.0, step_share_at_end_of_record_before
    )[record_number]
    # share of the step that the whole record takes
    step_share_of_record = np.maximum(
        records.step_share_at_end[record_number] - step_share_at_begin, np.finfo(float).tiny
    )
    return np.clip((share_of_step - step_share_at_begin) / step_share_of_record, 0.0, 1.0)


def _loads_at(rows: Array, step: Indices, share_of_step: Array) -> tuple[Array, Array]:
    """P and Q, (n,) each, at shares of straight load steps between rows (m + 1, 2) of P and Q,
    counted from the nearer row.
    """
    change_of_loads = rows[step + 1] - rows[step]
    loads_from_begin = rows[step] + share_of_step[:, None] * change_of_loads
    loads_from_end = rows[step] + change_of_loads - (1 - share_of_step)[:, None] * change_of_loads
    load, force = np.where(share_of_step[:, None] > 0.5, loads_from_end, loads_from_begin).T
    return np.maximum(load, 0.0), force  # a path that unloads fully may end below 0 by rounding
