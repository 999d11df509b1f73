"""CycleView: what the figures of the last cycle share, its axes, instants, points and legend."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from reports.charts.plate import Axis, Key, Mark, Panel, Rule, axis_limits
from reports.comparison import Comparison, words
from reports.comparison.cycles import Cycle, events, index_of_first_row
from reports.comparison.pairs import engine_in_words
from reports.units import minus
from scenes import ContactSolution
from scenes.array_types import Array

X_OVER_A = "x / a_ref"

# Looks of lines, one after the other, then from the first again.
LINE_LOOKS = tuple(f"line-{k}" for k in range(7)) * 3

ZERO = Rule(0.0, "zero")


class EngineView(NamedTuple):
    """One engine in the figures: class of its lines in the style sheet, last cycle, and name."""

    line_css: str
    cycle: Cycle
    name: str


class CycleView:
    """The last cycle of a comparison, as the figures of the page draw it.

    Attributes
    ----------
    reference_cycle, result_cycle
        the last cycle of each solution, on the points of the result
    engines
        class of lines, cycle and name of the reference and of the result
    keys
        their entries of a legend
    chosen_events
        the instants that every figure marks, by one number each
    shown_instant
        index of the one that a page shows first: that with most points slipping, of equal ones
        that of the largest P
    time, time_words
        the axis of figures through the last cycle
    part_of_path, noun
        what the values are of, "last cycle", "whole record" or "whole path", and its last word
    x, largest_x
        points over a_ref; the largest of them that is drawn, a little more than the largest
        contact of either
    """

    def __init__(self, comparison: Comparison) -> None:
        """Take the last cycle of both solutions of a comparison. Choose the instants that figures
        mark by numbers, the one of them that is shown first (most points slipping), and the range
        of x that is drawn. Times are shares of the period where the loads repeat.
        """
        self.comparison = comparison
        self.scene = comparison.scene
        self.scales = comparison.scales
        # "last cycle", "whole record" or "whole path", and the last word alone
        self.part_of_path = words.part_of_path(comparison.scene)
        self.noun = self.part_of_path.split()[-1]
        self.reference_cycle = comparison.reference_cycle
        self.result_cycle = comparison.result_cycle
        # "r" and "f" (finite elements): the classes of the style sheet for reference and result
        self.engines = (
            EngineView("r", self.reference_cycle, engine_in_words(comparison.reference.engine)),
            EngineView("f", self.result_cycle, engine_in_words(comparison.result.engine)),
        )
        # entries of a legend: class of the line, name of the engine
        self.keys = [
            Key(f"{engine_view.line_css} p", engine_view.name) for engine_view in self.engines
        ]
        # at most six instants, such as those of the largest P and Q, from the first on the rows of
        # a table of loads
        self.chosen_events = events(
            self.result_cycle,
            self.scene.friction.coefficient,
            index_of_first_row(self.result_cycle, self.scene),
        )
        chosen_instants = [event.index for event in self.chosen_events]
        self.shown_instant = max(chosen_instants, key=self._slip_points_and_load)
        # (k,) times on the axes of figures, and the words of such an axis
        self.time = self.result_cycle.time
        self.time_words = "time"
        if self.scene.load.path().period is not None and self.result_cycle.is_whole:
            self.time = self.result_cycle.fraction
            self.time_words = "time / period"
        # points over a_ref, (n,), and the largest that is drawn
        self.x = self.result_cycle.x / self.scales.half_width
        self.largest_x = self._largest_distance() / self.scales.half_width

    def _slip_points_and_load(self, instant: int) -> tuple[int, float]:
        """How many points slip at the instant of that index (states 2 and 3), and P there."""
        n_slipping = int((self.result_cycle.state[instant] >= 2).sum())
        return n_slipping, float(self.result_cycle.normal_load[instant])

    def _largest_distance(self) -> float:
        """The largest |x| that is drawn [length]; every point where nothing touches."""
        edges = (self.reference_cycle.contact_edges, self.result_cycle.contact_edges)
        outer_distance = (
            max(float(np.nanmax(np.abs(edge), initial=0.0)) for edge in edges) or np.inf
        )
        return min(1.12 * outer_distance, float(np.abs(self.result_cycle.x).max()))

    def over_time(self, n_ticks: int = 5) -> Axis:
        """The axis of time."""
        return Axis(*axis_limits(self.time, margin=0), self.time_words, n_ticks=n_ticks)

    def over_x(self, words: str = X_OVER_A) -> Axis:
        """The axis of x."""
        return Axis(-self.largest_x, self.largest_x, words)

    def difference_over_time(self, difference: Array, unit: str) -> str:
        """Root mean square and largest value of a difference (k,) over time, in words, with the
        time of the largest; `unit` follows each value.
        """
        words_of_place = "t/T = {}" if "period" in self.time_words else "t = {}"
        return difference_in_words(difference, self.time, words_of_place, unit)


def difference_in_words(
    difference: Array,
    positions: Array,
    position_template: str,
    unit: str = "",
    is_compared: NDArray[np.bool_] | None = None,
) -> str:
    """The size of a difference along x or time, in words: its root mean square, its largest value,
    and where that is.

    Parameters
    ----------
    difference, positions
        (n,) the difference, and the x or times at which it is given
    position_template
        text of a position, with {} for its number
    unit
        written behind each value of the difference
    is_compared
        (n,) False where the difference is left out; None: it counts everywhere

    Examples
    --------

    >>> difference_in_words(
    ...     np.array([0.0, -3.0, 0.0]), np.array([0.0, 1.0, 2.0]), "x = {} a_ref", " %"
    ... )
    'rms 1.7 %, largest −3 % at x = 1 a_ref'
    """
    # NaN: nothing to compare at that place
    is_known = np.isfinite(difference) & (True if is_compared is None else is_compared)
    if not is_known.any():
        return "nothing to compare"
    # (n,) length of x or time that belongs to each position
    lengths = np.gradient(positions) if len(positions) > 1 else np.ones(1)
    weights = np.maximum(lengths[is_known], 1e-300)
    rms = np.sqrt(np.average(difference[is_known] ** 2, weights=weights))
    worst_index = int(np.argmax(np.where(is_known, np.abs(difference), -1.0)))
    # `minus`: with a real minus sign
    worst_position = position_template.format(minus(f"{positions[worst_index] + 0.0:.3g}"))
    largest_difference = difference[worst_index] + 0.0  # no "-0"
    rms_text = f"rms {_two_digits(rms)}{unit}"
    largest_text = f"largest {_two_digits(largest_difference)}{unit}"
    return minus(f"{rms_text}, {largest_text} at ") + worst_position


def _two_digits(value: float) -> str:
    """Two digits, or all before the point."""
    return f"{value:.2g}" if abs(value) < 100 else f"{value:.0f}"


def broad_panel(
    name: str,
    x: Axis,
    y: Axis,
    marks: Sequence[Mark],
    alt: str,
    height: float = 280.0,
    **panel_options: Any,
) -> Panel:
    """A panel as wide as the page, with the axes `x` and `y`. `alt` says what it shows, for readers
    who can't see it; `height` is in pixels; `panel_options` are further fields of `Panel`.
    """
    return Panel(name, x, y, marks, alt, 900.0, height, css="broad", **panel_options)


def permanent_edges(solution: ContactSolution) -> Array:
    """(2,) ends of what sticks through the whole last cycle [length]; NaN if nothing does."""
    if solution.permanent_stick_edges is not None:
        return solution.permanent_stick_edges
    return solution.permanent_stick_half_width * np.array([-1.0, 1.0])


def slip_points(comparison: Comparison, n_points: int = 4) -> list[int]:
    """Indices of up to `n_points` points of the result at which the page shows slip over time. They
    lie evenly from the right edge of the permanent stick zone (or the middle) to just inside the
    right edge of the largest contact. `may_tilt`: whether tilt, moment or unequal sides make the
    contact unsymmetric. `contact_edges` are (k instants, 2) [length].
    """
    contact_edges = comparison.reference_cycle.contact_edges
    x = comparison.result_cycle.x
    # Turned by a tilt, a moment or unequal sides the contact may lie on one side of x = 0.
    if comparison.may_tilt:
        outer_edge = float(np.nanmax(contact_edges, initial=float(x[0])))
    else:
        outer_edge = float(np.nanmax(np.abs(contact_edges), initial=0.0)) or float(np.abs(x).max())
    # right end of what sticks through the whole cycle
    stick_edge = float(permanent_edges(comparison.reference)[1])
    if not np.isfinite(stick_edge) or stick_edge >= outer_edge:
        stick_edge = min(0.0, outer_edge)
    x_wanted = stick_edge + np.linspace(0.12, 0.97, n_points) * (outer_edge - stick_edge)
    return sorted({int(np.abs(x - x_of_point).argmin()) for x_of_point in x_wanted})


def sheared_displacement(cycle: Cycle) -> Array:
    """V = U - k Q minus its mean, (k,) [length]: the displacement without its elastic part, k being
    the compliance dU/dQ of the loop. Q over V encloses the area of Q over U, in an open loop.
    """
    elastic_part = loop_compliance(cycle) * cycle.tangential_load
    displacement = cycle.tangential_displacement - elastic_part
    return np.asarray(displacement - displacement.mean())


def loop_compliance(cycle: Cycle) -> float:
    """Slope dU/dQ of the straight line through the loop by least squares; 0 where Q is constant."""
    load_about_mean = cycle.tangential_load - cycle.tangential_load.mean()
    sum_of_squares = float(load_about_mean @ load_about_mean)
    if sum_of_squares > 0:
        return float(load_about_mean @ cycle.tangential_displacement) / sum_of_squares
    return 0.0
