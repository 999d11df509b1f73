"""The answer where the frictional state is one memory curve, as `Findings`: fields at the points
and instants that are asked for, and friction work, exact to round-off.

A memory curve M(eta) is the tangential force of the flat punches up to the normal load eta. A path
is followed by `load_series` where all of it is straight, else by `history`. Either leaves a
`PathAnswer`: friction states at the instants and work of the cycles.

Errors are estimates from above. A field is a sum over the straight pieces of M: slope M' times the
difference of a kernel at both ends. Its error is f times the kernel's error for each end. Integrals
along arcs, curved pieces of M, come with their error. The friction work W of a steady cycle is
found as f (A/pi) int Lam dw and as the closed integral of Q dU; the difference counts as error. Of
long series a sample of the kernel Lam counts. Closed forms keep 1e-13 of their value against forty
digits. They have no entry but for what arcs lose beyond 1e-12.

# notation: |M'| <= f; Lam = integral of ln(a/c) over the loads from P_c to P, a and c half-widths
#           of contact and of stick; w = +-Q - f P, the sign that of slip; A = 2/E*
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes import (
    OPEN,
    SLIP_FORWARD,
    SLIP_REVERSE,
    STICK,
    InputError,
    LoadSegment,
    NotFoundError,
    Scene,
    TimeSeriesLoad,
    read_only_copy,
)
from scenes.array_types import Array
from semi_analytic.answer import (
    Findings,
    Question,
    StopWatch,
    is_between_edges,
    mirrored_points,
    neglected_coupling,
)
from semi_analytic.bulk_and_tilt import OneCurve
from semi_analytic.elasticity import composite_modulus
from semi_analytic.fields import KernelIntegrals
from semi_analytic.friction_work import (
    LoopWork,
    LoopWorkOfSeries,
    closed_integral,
    density_of_records,
    global_dissipation,
    pointwise_dissipation,
    slip_work,
    work_error,
)
from semi_analytic.history import History, Span, history_of, slip_zone_share
from semi_analytic.load_series import (
    LoadSeries,
    PathPart,
    Records,
    States,
    StepBlock,
    blocks_of_part,
    line_count_of,
    series_of,
    share_of_largest_load,
    straight_series,
)
from semi_analytic.memory import (
    LAST_DIGITS,
    PROMISED_ERROR,
    Piece,
    Snapshot,
    force_on_piece,
    pieces,
)
from semi_analytic.opposite_slip import OppositeSlip
from semi_analytic.profiles import Contact, SymmetricContact, contact_of
from semi_analytic.quadrature import GRADED_NODE_COUNT
from semi_analytic.stated_errors import (
    LoopIntegral,
    SumsOfKernels,
    error_of_displacement,
    error_of_work,
    errors_of_sums,
    roundoff_error_of_little_slip,
)
from semi_analytic.steady_ellipse import (
    Ellipses,
    ellipses_of,
    error_by_digits_of_loads,
    works_over_time,
)
from semi_analytic.tilted_profile import TiltedProfile

Indices = NDArray[np.int64]

# Instants of a sample at which the errors of fields are estimated.
_SAMPLED_INSTANTS = 7
_SMALLEST_FLOAT = float(np.finfo(float).tiny)
# Round-off of the closed integral of Q dU over the friction work, above which the two are not
# compared: less than two digits are left.
_LARGEST_ERROR_SHARE_OF_LOOP = 1e-2
# Relative errors above which the notes of an answer state them.
_DOUBTFUL_RELATIVE_ERROR = 1e-9

_FIELDS_OF_FRICTION = frozenset(
    ("shear", "slip", "tangential_displacement", "dissipation", "dissipation_density")
)
"""Fields that bulk strain and tilt change in the first order."""


# --------------------------------------------------------------------------------- the whole answer
@dataclass(frozen=True, eq=False)
class Request:
    """What is to be evaluated.

    Attributes
    ----------
    contact, modulus
        normal contact, E* [stress]
    time
        (n,) instants of the answer
    x
        (m,) points of the answer [length]
    distance
        (k,) different |x| of the points; different x of an unsymmetric contact [length]
    distance_index
        (m,) index in `distance` of each point
    wanted_fields
        names of the fields that are wanted
    bulk_tilt_path
        contact and loads of a path with bulk stress and tilt; None without these
    """

    contact: Contact
    modulus: float
    time: Array
    x: Array
    distance: Array
    distance_index: Indices
    wanted_fields: frozenset[str]
    bulk_tilt_path: OneCurve | None = None

    @property
    def unit_compliance(self) -> float:
        """A/pi, with A = 2/E*."""
        return 2 / (math.pi * self.modulus)

    def wants(self, *names: str) -> bool:
        """Whether one of these fields is wanted."""
        return not self.wanted_fields.isdisjoint(names)


def findings_by_memory(question: Question, bulk_tilt_path: OneCurve | None) -> Findings:
    """Half-plane answer where the frictional state is one memory curve: loads, fields, friction
    work of the cycles, their errors and notes.

    The memory curve is the tangential force of the flat punches up to each normal load.

    Parameters
    ----------
    question
        scene, wanted fields, and points and instants, None where theory chooses them
    bulk_tilt_path
        path and tilted contact of a scene with bulk stress or tilt, for which one curve is enough
        on some paths alone; None without these

    Raises
    ------
    InputError, InadmissibleLoadError
        For a time outside the load path, straight steps without times; gross sliding, separation.
    NotFoundError
        Where a value of a field, a half-width or an error is not a number.
    """
    stop_watch = StopWatch("history", "fields", "dissipation")
    # the friction history, the instants, and what is evaluated at them
    followed_path, time, n_rows_left_out = _path_and_instants(question, bulk_tilt_path)
    # contact, points, and which fields are wanted
    request = _request_of(question, bulk_tilt_path, followed_path, time)
    stop_watch.add_lap("history")
    # friction states, works of cycles, friction work per area W(x) at the different |x|
    path_answer = answer_along_path(followed_path, request)
    stop_watch.add_lap("dissipation")
    # values over time, fields at the points, and their errors
    answer_fields = _fields_of_answer(request, path_answer.snapshot)
    stop_watch.add_lap("fields")
    # closed integral of Q dU of the last cycle, U the relative tangential displacement
    loop_work = _loop_work_of(path_answer.friction_work)
    errors = _relative_errors(request, path_answer, answer_fields, loop_work)
    termination, message = _termination_and_message(followed_path)
    permanent_stick = _permanent_stick(request.contact, path_answer, followed_path.largest_load)
    works = _works_by_name(path_answer.friction_work, request, loop_work)
    stop_watch.add_lap("dissipation")
    return Findings(
        time=time,
        x=request.x,
        # `steady_from`: index of the first steady cycle; `cycles`: those that were solved
        values=answer_fields.over_time
        | answer_fields.at_points
        | permanent_stick
        | works
        | {"steady_from": followed_path.steady_from},
        termination=termination,
        message=message,
        notes=(
            *neglected_coupling(question.scene.material),
            *_neglected_loads(bulk_tilt_path),
            *_notes_of_path(question, followed_path, len(time), n_rows_left_out),
            *_notes_of_errors(errors),
        ),
        errors=errors,
        certificates=_admissibility_checks(request, path_answer, answer_fields.at_points),
        energy=path_answer.friction_work.increments_by_name,
        counts={
            "points_evaluated": len(request.distance),
            "cycles_solved": len(followed_path.cycles),
        }
        | path_answer.counts,
        skipped=_skipped_computations(question.scene, followed_path, path_answer),
        seconds=stop_watch.seconds,
    )


def _path_and_instants(
    question: Question, bulk_tilt_path: OneCurve | None
) -> tuple[LoadSeries | History, Array, int]:
    """The followed load path of a question, its instants (n,), and how many rows of a long
    measurement are left out of these.

    Where the question has no times, theory chooses the instants. They are those of the last cycle
    alone where only that is wanted, and the path then covers this cycle alone. A long measurement
    gets fewer instants where fields at points are wanted. `bulk_tilt_path` has the loads to follow
    with bulk stress or tilt; None without these.

    Raises
    ------
    InputError, InadmissibleLoadError
        For straight steps without times; for gross sliding or separation somewhere in the path.
    """
    followed_path = path_of_question(question, bulk_tilt_path)
    if question.time is not None:
        return followed_path, question.time, 0
    wants_steady_cycle_alone = question.cycles == "steady"
    time, n_rows_left_out = followed_path.default_times(
        wants_steady_cycle_alone, question.wants_pointwise
    )
    if wants_steady_cycle_alone:
        followed_path = replace(followed_path, covered=followed_path.covered[-1:])
    return followed_path, time, n_rows_left_out


def _works_by_name(
    friction_work: WorkOfPath, request: Request, loop_work: float
) -> dict[str, float | Array]:
    """Works by their names in a solution: friction work of the last cycle and of each cycle, closed
    integral of Q dU of the last one, and work per area W(x).

    Works are in [energy per thickness], W(x) in [energy per area].

    W(x) is given at the m points of a request. `density` of the friction work is W(x) at the
    different |x|, `distance_index` (m,) of the request the index of each point among these. U is
    the relative tangential displacement.
    """
    return {
        "dissipation": friction_work.of_last_cycle,
        "loop_work": loop_work,
        "cycle_dissipation": friction_work.of_cycles,
        "dissipation_density": friction_work.density[request.distance_index],
    }


def path_of_question(question: Question, bulk_tilt_path: OneCurve | None) -> LoadSeries | History:
    """The load path of a question, followed with its friction history. It is the path of the scene,
    or straight steps between its loads at the times asked for where the question wants these.

    With bulk stress or tilt `bulk_tilt_path` has the P and Q to follow, and the tilted contact;
    None without these. A path comes as a `LoadSeries` where it is all straight, else as a
    `History`. `cycles` of the scene is the largest number of cycles to follow where no times are
    asked for.

    Raises
    ------
    InputError, InadmissibleLoadError
        For straight steps without times; for gross sliding or separation somewhere in the path.
    """
    scene = question.scene
    friction_coefficient = scene.friction.coefficient
    if question.straight_steps:
        if question.time is None:
            raise InputError("straight_steps: give the times between which the steps are straight")
        load_path = scene.load.path() if bulk_tilt_path is None else bulk_tilt_path.path
        return straight_series(load_path, friction_coefficient, question.time)
    if bulk_tilt_path is not None:
        return history_of(bulk_tilt_path.path, friction_coefficient, scene.cycles, question.time)
    return _path_of(scene, question.time)


def _path_of(scene: Scene, time: Array | None) -> LoadSeries | History:
    """The load path of a scene with its friction history. It is followed by straight steps where
    all its load segments are straight, else by times of stick and of slip in one direction.

    A segment is curved where a weighted sum of P and Q may have a turning point inside of it.
    """
    if not isinstance(scene.load, TimeSeriesLoad):
        path = scene.load.path()
        if any(segment.most_turning_points for segment in (*path.initial_loading, *path.cycle)):
            return history_of(path, scene.friction.coefficient, scene.cycles, time)
    return series_of(scene, time)


def _request_of(
    question: Question,
    bulk_tilt_path: OneCurve | None,
    followed_path: LoadSeries | History,
    time: Array,
) -> Request:
    """What is to be evaluated along a followed load path: contact, fields, instants `time` (n,) and
    points x [length].

    The question holds scene, fields and points; `wants_pointwise` tells whether a field at points
    and instants is among them. A question without points gets them across the contact at the
    largest P. On a long measurement with no field that needs points it gets x = 0 alone. A
    symmetric contact is evaluated at the different |x| only, the `distance` (k,); `distance_index`
    is that of each point. `largest_load` of the path is its largest P. `bulk_tilt_path` has the
    tilted contact; None without bulk stress and tilt.
    """
    scene = question.scene
    if bulk_tilt_path is not None:
        contact: Contact = bulk_tilt_path.contact
    else:
        contact = contact_of(scene.profile, scene.material)
    x = question.x
    if x is None:
        needs_points = question.wants_pointwise or question.wants("dissipation_density")
        x = (
            _points_of(contact, followed_path.largest_load)
            if needs_points or not followed_path.is_long_measurement
            else np.zeros(1)
        )
    if bulk_tilt_path is None:
        distance, distance_index = distances_and_indices(x)
    else:
        distance, distance_index = np.unique(x, return_inverse=True)
    # E*
    modulus = composite_modulus(scene.material)
    return Request(
        contact, modulus, time, x, distance, distance_index, question.fields, bulk_tilt_path
    )


def distances_and_indices(x: Array) -> tuple[Array, Indices]:
    """Different |x| (k,), ascending, and for each point (m,) the index of its own among them.
    Distances that differ by at most two last digits of the largest count as one.

    >>> distances_and_indices(np.array([-1.0, 0.0, 1.0 + 2.3e-16]))
    (array([0., 1.]), array([1, 0, 1]))
    """
    distances, index_of_distance = np.unique(np.abs(x), return_inverse=True)
    is_distinct = np.diff(distances, prepend=-np.inf) > 2 * np.finfo(float).eps * distances[-1]
    return distances[is_distinct], (np.cumsum(is_distinct) - 1)[index_of_distance]


def _points_of(contact: Contact, largest_load: float) -> Array:
    """Points across the contact at the largest P and a little beyond [length]; mirrored about x =
    0, or about the centre of a tilted contact.
    """
    points = mirrored_points(1.05 * float(contact.half_width(largest_load)))
    return (
        points + float(contact.centre(largest_load))
        if isinstance(contact, TiltedProfile)
        else points
    )


def memory_at(scene: Scene, time: Array) -> tuple[SymmetricContact, Snapshot]:
    """Normal contact of a scene, and its friction states at instants (n,) of the load path, each
    with its memory curve. That is the tangential force of the flat punches up to each normal load.

    Raises
    ------
    InputError, InadmissibleLoadError
        For what half-plane theory cannot solve: gross sliding, separation, a profile under which
        the contact splits.
    """
    contact = contact_of(scene.profile, scene.material)
    followed_path = _path_of(scene, time)
    if isinstance(followed_path, History):
        return contact, followed_path.snapshot(time)
    # A load series stores memory curves only where a field needs them: shear does, at whichever
    # point.
    middle_point, middle_index = distances_and_indices(np.zeros(1))
    # E*
    modulus = composite_modulus(scene.material)
    request = Request(
        contact, modulus, time, middle_point, middle_point, middle_index, frozenset({"shear"})
    )
    return contact, answer_along_path(followed_path, request).snapshot


# --------------------------------------------------------------- states at instants, work of cycles
@dataclass(frozen=True, eq=False)
class WorkOfPath:
    """Friction work along a followed path.

    Attributes
    ----------
    of_cycles
        (n_cycles,) of the cycles that the answer covers, NaN where it was not wanted [energy per
        thickness]
    relative_errors
        (n_cycles,) of these
    density
        (k,) work per area W(x) of the last cycle at the different |x|, NaN where it was not wanted
    density_error
        its error over its largest value
    loop_integral
        closed integral of Q dU of the last cycle, U the relative tangential displacement; None
        where that cycle is not steady, or the integral is neither asked for nor needed for the
        error of the work
    increments
        (n,) friction work since the instant before, empty where instants lie between rows or the
        work was not wanted
    """

    of_cycles: Array
    relative_errors: Array
    density: Array
    density_error: float
    loop_integral: LoopWork | None
    increments: Array

    @property
    def increments_by_name(self) -> dict[str, Array]:
        """`increments` as "dissipation", read-only; nothing where they are empty."""
        return {"dissipation": read_only_copy(self.increments)} if len(self.increments) else {}

    @property
    def of_last_cycle(self) -> float:
        """Friction work of the last cycle [energy per thickness]."""
        return float(self.of_cycles[-1])


@dataclass(frozen=True, eq=False)
class PathAnswer:
    """What a followed path leaves for an answer, whichever way it was followed. P_c is the load at
    the stick edge: the normal load whose contact half-width is that of the stick zone.

    Attributes
    ----------
    snapshot
        friction states at the instants with their memory curves; without curves where no field
        needs them
    force_error
        (n,) M(P) - Q there: what the memory curve carries, minus Q [force per thickness]
    least_stick_load
        least P_c of the last cycle [force per thickness]
    largest_slip_zone_share
        largest P - P_c of all that was followed, over its largest P; of straight steps the largest
        of these shares of a part of the path, initial loading or cycle
    friction_work
        friction work of the cycles, W(x) and the closed integral of Q dU of the last one
    spans
        times of stick, or of slip in one direction, of the last cycle; none for straight steps
    counts
        numbers of spans, pieces of memory curves, quadratures and their nodes, by name
    n_skipped_in_stick
        how many quadratures were not done, since nothing slips
    """

    snapshot: Snapshot
    force_error: Array
    least_stick_load: float
    largest_slip_zone_share: float
    friction_work: WorkOfPath
    spans: Sequence[Span]
    counts: dict[str, int]
    n_skipped_in_stick: int


def answer_along_path(path: LoadSeries | History, request: Request) -> PathAnswer:
    """Friction states at the instants of a request, and friction work of the cycles, along a
    followed path.

    Raises
    ------
    InputError
        For a time outside the path.
    """
    if isinstance(path, History):
        return _answer_of_history(path, request)
    return _answer_of_series(path, request)


class _InstantsOnPath(NamedTuple):
    """Where the instants of a request are on a path of straight load steps, in the order of the
    path, (n,) each.

    Attributes
    ----------
    step
        number of the load step
    share_of_step
        share of that step that is over
    share_tolerance
        share within which two instants count as one
    place_in_path
        of each instant of the request, its place in the order of the path
    """

    step: Indices
    share_of_step: Array
    share_tolerance: Array
    place_in_path: Indices

    @classmethod
    def along(cls, series: LoadSeries, time: Array) -> _InstantsOnPath:
        """The instants `time` (n,) on the path of a load series."""
        # number of the load step, share of it that is over, tolerance of that share
        step, share_of_step, share_tolerance = series.locate(time)
        order_in_path = np.lexsort((share_of_step, step))
        return cls(
            step[order_in_path],
            share_of_step[order_in_path],
            share_tolerance[order_in_path],
            np.argsort(order_in_path),
        )

    @property
    def all_at_rows(self) -> bool:
        """Whether each instant is a row of the series: the end of a step, or the start of all."""
        is_start_of_path = (self.share_of_step == 0) & (self.step == 0)
        return bool(np.all((self.share_of_step == 1) | is_start_of_path))

    def within(self, first_step: int, n_steps: int) -> tuple[Indices, Array, Array]:
        """The instants within `n_steps` load steps from number `first_step` on, (k,) each: number
        of the step, counted from `first_step`; share of the step that is over; tolerance of that
        share.

        `step`, `share_of_step` and `share_tolerance` are those of all instants, in the order of the
        path.
        """
        begin_and_end_numbers = np.searchsorted(self.step, [first_step, first_step + n_steps])
        instants = slice(*begin_and_end_numbers.tolist())
        return (
            self.step[instants] - first_step,
            self.share_of_step[instants],
            self.share_tolerance[instants],
        )


class _WantedIntegrals(NamedTuple):
    """Which integrals over slip are wanted along a whole path, or in one part of it, the initial
    loading or a cycle.

    Attributes
    ----------
    wants_work
        friction work
    wants_work_of_steps
        friction work of each load step
    wants_density
        friction work per area W(x)
    """

    wants_work: bool
    wants_work_of_steps: bool
    wants_density: bool

    @classmethod
    def of_request(cls, request: Request, instants: _InstantsOnPath) -> _WantedIntegrals:
        """Integrals along a whole path that the fields of a request need. The work of each step is
        wanted where each instant is a row of the path.
        """
        wants_work = request.wants("dissipation")
        return cls(
            wants_work=wants_work,
            wants_work_of_steps=wants_work and instants.all_at_rows,
            wants_density=request.wants("dissipation_density"),
        )

    def in_part(self, part_number: int, covered_parts: Sequence[int]) -> _WantedIntegrals:
        """Those in one part of the path. `covered_parts` are the numbers of the cycles that the
        answer covers: the work of another part is wanted by steps only, W(x) in the last one only.
        """
        return _WantedIntegrals(
            wants_work=self.wants_work
            and (self.wants_work_of_steps or part_number in covered_parts),
            wants_work_of_steps=self.wants_work_of_steps,
            wants_density=self.wants_density and part_number == covered_parts[-1],
        )

    @property
    def count_per_record(self) -> int:
        """How many integrals are taken over each record with slip, a portion of a load step."""
        return int(self.wants_work) + int(self.wants_density)


@dataclass(eq=False)
class _SeriesSums:
    """Sums over the blocks of load steps of a load series. P_c is the load at the stick edge.

    Attributes
    ----------
    works, work_errors, slip_zone_shares
        (parts,) friction work of each part of the path, its error [energy per thickness], and its
        largest P - P_c over its largest P
    step_works
        (steps + 1,) a 0, then the friction work of each step; (1,) where it is not wanted
    density
        (k,) W(x) of the last cycle
    loop_integral
        closed integral of Q dU of the last cycle, U the relative tangential displacement; None
        where it is not wanted
    least_stick_load
        least P_c of the last cycle
    n_skipped_in_stick
        integrals that were not taken, since nothing slips
    counts
        by name: records ("spans"), records with slip ("slips"), pieces of memory curves alive and
        dropped, quadratures over slip and their nodes
    """

    works: Array
    work_errors: Array
    slip_zone_shares: Array
    step_works: Array
    density: Array
    loop_integral: LoopWorkOfSeries | None
    least_stick_load: float = math.inf
    n_skipped_in_stick: int = 0
    counts: dict[str, int] = field(
        default_factory=lambda: dict.fromkeys(
            (
                "spans",
                "slips",
                "pieces_alive",
                "pieces_dropped",
                "slip_quadratures",
                "quadrature_nodes",
            ),
            0,
        )
    )

    @classmethod
    def without_blocks(
        cls, series: LoadSeries, request: Request, wants_work_of_steps: bool
    ) -> _SeriesSums:
        """Sums over no block yet, for all parts of a load series and the different |x| of a
        request, `distance`. `first_steps` of the series ends with the number of its steps.
        """
        n_parts = len(series.parts)
        return cls(
            works=np.zeros(n_parts),
            work_errors=np.zeros(n_parts),
            slip_zone_shares=np.zeros(n_parts),
            step_works=np.zeros(1 + (series.first_steps[-1] if wants_work_of_steps else 0)),
            density=np.zeros(len(request.distance)),
            loop_integral=_empty_loop_integral(series, request),
        )

    def add_block_of_last_cycle(self, block: StepBlock) -> None:
        """Update what is found in the last cycle alone by a block of its load steps.

        They are the least load at the stick edge, and the closed integral of Q dU where it is
        wanted; U is the relative tangential displacement.
        """
        self.update_least_stick_load(block)
        if self.loop_integral is not None:
            self.loop_integral.add_block(block)

    def count_block(self, block: StepBlock, integrals_per_record: int, pieces_before: int) -> None:
        """Count what a block of load steps took: records, integrals over slip, straight pieces of
        the memory curve.

        A record is a portion of a step, with slip in one direction or in full stick. The memory
        curve M(eta) is the tangential force of the flat punches up to the load eta. Each step adds
        one straight piece to it, and slip drops those that it passes. Pieces alive are those of a
        curve at one time, the most of all blocks. A block holds its rows, records, and the curve at
        its end.

        Parameters
        ----------
        integrals_per_record
            integrals that are taken over each record with slip, of the friction work and of its
            density W(x)
        pieces_before
            pieces of the memory curve before the block
        """
        n_records = len(block.records.step_number)
        n_slips = int(np.count_nonzero(block.records.direction))
        n_steps = len(block.rows) - 1
        # pieces of the curve at the end of the block
        pieces_after = line_count_of(block.curve_at_end)
        self.counts["spans"] += n_records
        self.counts["slips"] += n_slips
        self.counts["slip_quadratures"] += integrals_per_record * n_slips
        self.n_skipped_in_stick += integrals_per_record * (n_records - n_slips)
        self.counts["pieces_dropped"] += n_steps + pieces_before - pieces_after
        self.counts["pieces_alive"] = max(self.counts["pieces_alive"], block.largest_line_count)

    def add_block(
        self,
        block: StepBlock,
        part_number: int,
        first_step: int,
        wanted_integrals: _WantedIntegrals,
        request: Request,
        friction: float,
    ) -> None:
        """Add the friction work of a block of load steps, and W(x), its density, where they are
        wanted [energy per thickness, and per area].

        A record is a portion of a load step, in full stick or with slip in one direction.

        Parameters
        ----------
        part_number, first_step
            number of the part of the path (initial loading or a cycle), and number of the block's
            first step in the whole path
        request
            holds the contact, A/pi as `unit_compliance`, and the points |x| of W(x), `distance`
        friction
            f
        wanted_integrals
            whether the work, the work of each step and W(x) are wanted
        """
        contact = request.contact
        work_per_integral = request.unit_compliance * friction
        # the records with slip
        slipping_records = block.records.slipping()
        if wanted_integrals.wants_work:
            # of each record: int Lam dw, w = +-Q - f P, Lam the integral of ln(a/c) over the loads
            # from P_c to P; a half-width of contact, c that of stick, P_c the load at the stick
            # edge
            integrals = self.add_work(part_number, contact, slipping_records, work_per_integral)
            if wanted_integrals.wants_work_of_steps:
                n_steps = len(block.rows) - 1
                rows_after_steps = slice(first_step + 1, first_step + 1 + n_steps)
                self.step_works[rows_after_steps] = work_per_integral * np.bincount(
                    slipping_records.step_number, integrals, n_steps
                )
        if wanted_integrals.wants_density:
            # `density_of_records`: the sum of int p arccosh(|x|/c) dw over the records, p the
            # pressure at x
            self.density += work_per_integral * density_of_records(
                contact, slipping_records, request.distance
            )

    def add_work(
        self,
        part_number: int,
        contact: Contact,
        slipping_records: Records,
        work_per_integral: float,
    ) -> Array:
        """Add the friction work of a block, and its error, to part `part_number` of the path.
        Returns the integral of each record, (m,); a record is a portion of a load step with slip.

        Work is f A/pi = `work_per_integral` times int Lam dw, A = 2/E*. Here w = +-Q - f P, the
        sign that of slip. Lam is the integral of ln(a/c) over the loads from P_c to P, with a and c
        the half-widths of contact and of stick. P_c is the load at the stick edge.
        """
        # int Lam dw of each record, and number of quadrature nodes
        integrals, n_nodes = slip_work(contact, slipping_records)
        self.works[part_number] += work_per_integral * float(np.sum(integrals))
        self.work_errors[part_number] += work_per_integral * work_error(contact, slipping_records)
        self.counts["quadrature_nodes"] += n_nodes
        return integrals

    def roundoff_errors_of_parts(self) -> Array:
        """Relative error by round-off of the friction work of each part of the path, (parts,). It
        grows as the largest share (P - P_c)/P of a part falls; P_c is the load at the stick edge.
        """
        return np.array(
            [
                roundoff_error_of_little_slip("dissipation", share)
                for share in self.slip_zone_shares.tolist()
            ]
        )

    def quadrature_errors_of_parts(self) -> Array:
        """Relative error by quadrature of the friction work of each part, (parts,); 0 of none."""
        no_work = np.zeros(len(self.works))
        return np.divide(self.work_errors, self.works, out=no_work, where=self.works > 0)

    def works_and_errors(self, part_numbers: Sequence[int]) -> tuple[Array, Array]:
        """Friction work of some parts of the path [energy per thickness], and its relative error,
        by rounding and by quadrature, (n,) each.
        """
        relative_errors = self.quadrature_errors_of_parts() + self.roundoff_errors_of_parts()
        parts = list(part_numbers)
        return self.works[parts], relative_errors[parts]

    def update_slip_zone_share(self, block: StepBlock, part_number: int, part: PathPart) -> None:
        """Update the largest P - P_c over the largest P of a `part` of the path by a block of it.
        `part_number` is the number of the part; P_c is the load at the stick edge.
        """
        share_of_block = share_of_largest_load(block.largest_slip_zone_load, part)
        self.slip_zone_shares[part_number] = max(self.slip_zone_shares[part_number], share_of_block)

    def update_least_stick_load(self, block: StepBlock) -> None:
        """Update the least load P_c at the stick edge of the last cycle by a block of its load
        steps. The slip zones carry P - P_c.
        """
        records = block.records
        stick_loads = records.load_at_begin - records.slip_zone_load_at_begin
        stick_loads_at_end = records.load_at_end - records.slip_zone_load_at_end
        least_load_of_block = min(float(np.min(stick_loads)), float(np.min(stick_loads_at_end)))
        self.least_stick_load = min(self.least_stick_load, least_load_of_block)


def _answer_of_series(series: LoadSeries, request: Request) -> PathAnswer:
    """Friction states at the instants of a request, and friction work of the cycles, along a load
    path of straight steps, a load `series`.

    The path was followed once to find its cycles. Now the parts of it that the answer needs, its
    initial loading or cycles, are followed again, and their work and states are gathered. `times`
    of the series are those of all rows, the ends of steps. A request holds the normal contact, the
    instants `time`, which fields it wants, and `bulk_tilt_path`, None without bulk stress and tilt.
    """
    instants = _InstantsOnPath.along(series, request.time)
    wanted_integrals = _WantedIntegrals.of_request(request, instants)
    # With bulk stress and tilt the moment of the shear is in every answer.
    needs_curves = request.bulk_tilt_path is not None or request.wants(
        "shear", "slip", "tangential_displacement"
    )
    # where friction states and sums are gathered
    states = States(series.friction, needs_curves)
    path_sums = _SeriesSums.without_blocks(series, request, wanted_integrals.wants_work_of_steps)
    for part_number in _parts_needed(series, instants.step):
        _follow_part(series, part_number, instants, request, states, path_sums)

    # friction states at the instants, and M(P) - Q of each: carried tangential force minus Q
    snapshot, force_error = states.snapshot(request.time, instants.place_in_path)
    return PathAnswer(
        snapshot=snapshot,
        force_error=force_error,
        least_stick_load=path_sums.least_stick_load,
        largest_slip_zone_share=float(np.max(path_sums.slip_zone_shares)),
        friction_work=_work_of_series(series, request, instants, path_sums),
        spans=(),
        counts={
            "rows": len(series.times),
            **path_sums.counts,
            "curves": len(snapshot.sticking_pieces) if states.stores_curves else 0,
        },
        n_skipped_in_stick=path_sums.n_skipped_in_stick,
    )


def _work_of_series(
    series: LoadSeries, request: Request, instants: _InstantsOnPath, path_sums: _SeriesSums
) -> WorkOfPath:
    """Friction work along a load series, from the sums over all blocks of its load steps.

    `covered_parts` of the series are the numbers of the parts of the path, one for each cycle that
    the answer covers. The request holds the times `time` (n,) of the instants, and which fields are
    wanted; `instants` where they are on the path.
    """
    wanted_integrals = _WantedIntegrals.of_request(request, instants)
    covered_parts = series.covered_parts
    last_part = covered_parts[-1]
    works_of_covered_cycles = np.full(len(covered_parts), math.nan)
    relative_errors = np.zeros(len(covered_parts))
    if wanted_integrals.wants_work:
        works_of_covered_cycles, relative_errors = path_sums.works_and_errors(covered_parts)
    increments_of_work = np.empty(0)
    if wanted_integrals.wants_work_of_steps:
        # of the copies of the last cycle by which instants lie beyond the followed path
        work_of_later_cycles = series.cycles_beyond(request.time) * path_sums.works[last_part]
        increments_of_work = _increments_of_work(path_sums, instants, work_of_later_cycles)
    work_density = path_sums.density
    density_error = 0.0
    if wanted_integrals.wants_density:
        density_error = path_sums.roundoff_errors_of_parts()[last_part]
    else:
        work_density = np.full(len(work_density), math.nan)
    loop_integral = path_sums.loop_integral
    return WorkOfPath(
        of_cycles=works_of_covered_cycles,
        relative_errors=relative_errors,
        density=work_density,
        density_error=density_error,
        loop_integral=loop_integral.work if loop_integral is not None else None,
        increments=increments_of_work,
    )


def _follow_part(
    series: LoadSeries,
    part_number: int,
    instants: _InstantsOnPath,
    request: Request,
    states: States,
    path_sums: _SeriesSums,
) -> None:
    """Follow one part of a load series again, its initial loading or a cycle. Gather the friction
    states at the instants in it, and the sums over its slip.

    The part is followed in blocks of at most ten thousand load steps.

    Parameters
    ----------
    series
        load path of straight steps; `first_steps` are the numbers of the first step of each part,
        `covered_parts` the numbers of those that the answer covers
    part_number
        number of the part
    instants
        the instants of the answer on the path
    request
        which fields are wanted, and the different |x|
    states
        gathers the friction states at the instants, each with its memory curve where one is needed
    path_sums
        gathers friction work and counts
    """
    path_part: PathPart = series.parts[part_number]
    covered_parts = series.covered_parts
    wanted_integrals = _WantedIntegrals.of_request(request, instants).in_part(
        part_number, covered_parts
    )
    # pieces of the memory curve, the tangential force carried up to each load
    pieces_before = line_count_of(path_part.curve_at_begin)
    for first_row, step_block in blocks_of_part(path_part, series.friction, states.stores_curves):
        first_step = series.first_steps[part_number] + first_row
        states.add(step_block, *instants.within(first_step, len(step_block.rows) - 1))
        path_sums.update_slip_zone_share(step_block, part_number, path_part)
        path_sums.count_block(step_block, wanted_integrals.count_per_record, pieces_before)
        pieces_before = line_count_of(step_block.curve_at_end)
        path_sums.add_block(
            step_block, part_number, first_step, wanted_integrals, request, series.friction
        )
        if part_number == covered_parts[-1]:
            path_sums.add_block_of_last_cycle(step_block)


def _empty_loop_integral(series: LoadSeries, request: Request) -> LoopWorkOfSeries | None:
    """A sum for the closed integral of Q dU over the last cycle, without any block of its load
    steps yet; U is the relative tangential displacement.

    None where the integral is not asked for, or the cycle is not steady or has no load.
    `covered` are the cycles that the answer covers, `covered_parts` their numbers among the parts
    of the path; `steady_from` is the first steady cycle, None without one.
    """
    is_steady = series.steady_from is not None and series.covered[-1] >= series.steady_from
    if not (request.wants("loop_work") and is_steady):
        return None
    last_cycle = series.parts[series.covered_parts[-1]]
    if not last_cycle.largest_load > 0:
        return None
    # takes contact, E*, f and the largest P
    return LoopWorkOfSeries(
        request.contact, request.modulus, series.friction, last_cycle.largest_load
    )


def _increments_of_work(
    path_sums: _SeriesSums, instants: _InstantsOnPath, work_of_later_cycles: Array
) -> Array:
    """Friction work between successive instants of a request, (n,), 0 for the first one [energy per
    thickness]. All instants are ends of load steps, or the start of the path.

    Parameters
    ----------
    path_sums
        with the work of each step of the path, after a 0 for its start
    instants
        in the order of the path: the load step that each instant ends, and, for each instant of the
        request, its place in that order
    work_of_later_cycles
        (n,) work of the whole cycles by which instants lie beyond the path that was followed
    """
    # An instant that is not at the end of its step is the start of the path, before any step.
    is_at_end_of_step = instants.share_of_step == 1
    n_steps_done = (instants.step + is_at_end_of_step)[instants.place_in_path]
    # up to each instant
    work_so_far = np.cumsum(path_sums.step_works)[n_steps_done]
    work_so_far += work_of_later_cycles
    return np.diff(work_so_far, prepend=work_so_far[:1])


def _parts_needed(series: LoadSeries, step: Indices) -> list[int]:
    """Numbers of the parts of a path, initial loading or cycles, to be followed. They are the parts
    that the answer covers, and all from the part of the first instant to that of the last.

    `step` (n,), ascending, are the load steps of the instants. `first_steps` are the numbers of the
    first step of each part.
    """
    first_part, last_part = np.searchsorted(series.first_steps, step[[0, -1]], side="right") - 1
    return sorted({*series.covered_parts, *range(int(first_part), int(last_part) + 1)})


class _WorkOfCycle(NamedTuple):
    """Friction work of a cycle [energy per thickness], and its relative error."""

    work: float
    error: float


def _answer_of_history(history: History, request: Request) -> PathAnswer:
    """Friction states at the instants of a request, and friction work of the cycles, along a curved
    load path. The path is divided into spans: times of full stick, or of slip in one direction.

    `covered` are the solved cycles that the answer covers; W(x), the work per area, is that of the
    last one. The request holds the instants `time` and which fields are wanted.
    """
    last_spans = history.cycles[history.covered[-1]]
    snapshot = history.snapshot(request.time)
    works_of_cycles = _works_of_cycles(history, request) if request.wants("dissipation") else {}
    # the spans over which work was integrated
    integrated_spans = [
        span for cycle_number in works_of_cycles for span in history.cycles[cycle_number]
    ]
    if request.wants("dissipation_density"):
        integrated_spans.extend(last_spans)
    n_slipping_spans = sum(span.direction != 0 for span in integrated_spans)
    return PathAnswer(
        snapshot=snapshot,
        force_error=_force_error(snapshot),
        least_stick_load=_least_stick_load(last_spans),
        largest_slip_zone_share=slip_zone_share(history.spans),
        friction_work=_work_of_history(history, request, works_of_cycles),
        spans=last_spans,
        counts={
            "spans": len(history.spans),
            # `sticking_piece`: the piece of the memory curve of a span in which the stick edge is;
            # it holds the pieces below. The curve is the tangential force carried up to each load.
            "pieces_alive": max(len(list(pieces(span.sticking_piece))) for span in history.spans),
            "slip_quadratures": n_slipping_spans,
            # 193 nodes of the rule for singular ends in each
            "quadrature_nodes": n_slipping_spans * GRADED_NODE_COUNT,
        },
        n_skipped_in_stick=len(integrated_spans) - n_slipping_spans,
    )


def _work_of_history(
    history: History, request: Request, works_of_cycles: Mapping[int, _WorkOfCycle]
) -> WorkOfPath:
    """Friction work along a curved load path, with W(x) and the closed integral of Q dU of the last
    cycle that the answer covers; U is the relative tangential displacement.

    `works_of_cycles` is the work of each covered cycle by its index, empty where it is not wanted.
    `covered` of the history are the indices of these cycles, `cycles` the spans of each: times of
    full stick, or of slip in one direction. The request holds the normal contact, the different |x|
    (`distance`) and which fields are wanted.
    """
    works_of_covered_cycles = np.full(len(history.covered), math.nan)
    relative_errors = np.zeros(len(history.covered))
    if works_of_cycles:
        works_of_covered_cycles = np.array(
            [works_of_cycles[cycle_number].work for cycle_number in history.covered]
        )
        relative_errors = np.array(
            [works_of_cycles[cycle_number].error for cycle_number in history.covered]
        )
    work_density: Array = np.full(len(request.distance), np.nan)
    density_error = 0.0
    if request.wants("dissipation_density"):
        last_spans = history.cycles[history.covered[-1]]
        work_density, density_error = _density_of_spans(last_spans, request)
    loop_integral = None
    if works_of_cycles:
        loop_integral = _loop_integral_of_history(
            history, request, float(works_of_covered_cycles[-1])
        )
    return WorkOfPath(
        of_cycles=works_of_covered_cycles,
        relative_errors=relative_errors,
        density=work_density,
        density_error=density_error,
        loop_integral=loop_integral,
        increments=np.empty(0),
    )


def _loop_integral_of_history(
    history: History, request: Request, work_of_last_cycle: float
) -> LoopWork | None:
    """Closed integral of Q dU over the last covered cycle of a curved load path, with its round-off
    error; 0 where nothing is dissipated. U is the relative tangential displacement.

    None where that cycle is not steady, or the integral is not needed. It is needed where it is
    wanted, and where the friction work is no closed form: their difference is an error of the work
    then. `steady_from` is the first steady cycle, None without one. The request holds the normal
    contact and E* as `modulus`.
    """
    last_cycle = history.covered[-1]
    is_needed = request.wants("loop_work") or not request.contact.has_closed_form
    is_steady = history.steady_from is not None and last_cycle >= history.steady_from
    if not (is_steady and is_needed):
        return None
    if not work_of_last_cycle:
        return LoopWork(0.0, 0.0)
    return closed_integral(request.contact, request.modulus, history.cycles[last_cycle])


def _density_of_spans(spans: Sequence[Span], request: Request) -> tuple[Array, float]:
    """Friction work per area W(x) of a cycle at the distances of a request, (k,), and its error
    over the largest W(x).

    `spans` are the times of stick, or of slip in one direction, of the cycle. A request holds the
    normal contact, E* as `modulus` and the different |x|, `distance`.
    """
    # by the direction of slip, with the error of the sum, (k,) each
    density_parts = pointwise_dissipation(request.contact, request.modulus, spans, request.distance)
    density = density_parts.total
    relative_error = 0.0
    largest_error_of_points = float(np.max(density_parts.error))
    if largest_error_of_points:
        relative_error = largest_error_of_points / float(np.max(density))
    # by the last digits of P_c, the load at the stick edge, where little slips
    relative_error += roundoff_error_of_little_slip("dissipation_density", slip_zone_share(spans))
    return density, relative_error


def _least_stick_load(spans: Sequence[Span]) -> float:
    """The least load P_c at the stick edge of a cycle [force per thickness]; P where nothing slips.

    P_c is the normal load whose contact half-width is that of the stick zone. `spans` are the times
    of stick, or of slip in one direction; P_c is taken at their ends.
    """
    least_load = math.inf
    for span in spans:
        end_times = np.array([span.begin.time, span.end.time])
        load, _ = span.segment.loads(end_times)
        # `slip_zone_load_at` is P - P_c.
        least_load_of_span = float(np.min(load - span.slip_zone_load_at(end_times, load)))
        least_load = min(least_load, least_load_of_span)
    return least_load


def _force_error(snapshot: Snapshot) -> Array:
    """Error of tangential equilibrium at the instants of a curved path, M(P) - Q, (n,): the
    tangential force that the memory curve carries, minus Q [force per thickness].

    It is 0 but for round-off. The snapshot holds P, Q and the load P - P_c of the slip zones. It
    also holds the pieces of memory curves in which the stick edge P_c is, with the indices of their
    instants.
    """
    slope_of_slip = snapshot.direction * snapshot.friction
    force_error = slope_of_slip * snapshot.slip_zone_load - snapshot.force
    stick_edge_load = snapshot.load - snapshot.slip_zone_load
    for memory_piece, instants in snapshot.pieces_with_instants:
        assert isinstance(memory_piece, Piece)  # for the type checker: a history has no others
        # M at the stick edge, P_c
        force_error[instants] += force_on_piece(memory_piece, stick_edge_load[instants])
    return force_error


def _works_of_cycles(history: History, request: Request) -> dict[int, _WorkOfCycle]:
    """Friction work of each cycle of a curved load path that the answer covers, with its relative
    error, by the index of the cycle [energy per thickness].

    A steady ellipse of P and Q has formulas that keep their digits, however small the slip. Other
    cycles are integrated over the times of slip. `covered` are the cycles of the answer,
    `steady_from` is the first steady one, None without one. The request holds the normal contact
    and E*, the composite modulus.
    """
    friction = history.spans[0].friction
    # loads and angles of the ellipse
    ellipses = None
    # `ellipse_of_cycle` is the load segment of the ellipse, where that is the whole cycle.
    if friction > 0 and history.ellipse_of_cycle is not None:
        ellipses = _ellipse_of_segment(history.ellipse_of_cycle, friction)
    works_of_cycles: dict[int, _WorkOfCycle] = {}
    for cycle_number in set(history.covered):
        is_steady = history.steady_from is not None and cycle_number >= history.steady_from
        if ellipses is not None and is_steady:
            works_of_cycles[cycle_number] = _work_of_ellipse(ellipses, friction, request)
        else:
            works_of_cycles[cycle_number] = _work_of_spans(history.cycles[cycle_number], request)
    return works_of_cycles


def _work_of_ellipse(ellipses: Ellipses, friction: float, request: Request) -> _WorkOfCycle:
    """Friction work of a steady ellipse of P and Q [energy per thickness], and its relative error
    by round-off; 0 where that error is within what closed forms promise, 1e-12.

    `ellipses` is an array of this one. `unit_compliance` is A/pi, A = 2/E*; f is `friction`.
    """
    roundoff_error = float(error_by_digits_of_loads(ellipses)[0])
    work_forward, work_reverse = works_over_time(ellipses, request.contact)  # times pi E*/(2 f^2)
    scaled_work = float(work_forward[0] + work_reverse[0])
    work = request.unit_compliance * friction**2 * scaled_work
    return _WorkOfCycle(work, roundoff_error if roundoff_error > PROMISED_ERROR else 0.0)


def _work_of_spans(spans: Sequence[Span], request: Request) -> _WorkOfCycle:
    """Friction work of a cycle by quadrature, and its relative error. `spans` are its times of
    stick, or of slip in one direction. The request holds the normal contact and E* as `modulus`.
    """
    work_parts = global_dissipation(request.contact, request.modulus, spans)
    error = float(work_parts.error / work_parts.total) if work_parts.error else 0.0
    error += roundoff_error_of_little_slip("dissipation", slip_zone_share(spans))
    return _WorkOfCycle(float(work_parts.total), error)


def _ellipse_of_segment(segment: LoadSegment, friction: float) -> Ellipses | None:
    """The load ellipse that a segment of the load path describes, as the formulas of steady
    ellipses take it, in arrays of one; None where the segment is no ellipse.

    It is P = P0 + P1 cos t, Q = Q0 + Q1 cos(t - phase), with the means and amplitudes of P and Q.
    """
    ellipse = segment.ellipse
    if ellipse is None:
        return None
    mean_normal_load, _ = ellipse.mean
    amplitude_of_normal_load, amplitude_of_tangential_load = ellipse.amplitude
    return ellipses_of(
        np.array([mean_normal_load]),
        np.array([amplitude_of_normal_load]),
        np.array([amplitude_of_tangential_load]),
        np.array([ellipse.phase_radians]),
        np.array([friction]),
    )


def _loop_work_of(friction_work: WorkOfPath) -> float:
    """Closed integral of Q dU of the last cycle, U the relative tangential displacement [energy per
    thickness]; 0 where nothing is dissipated.

    NaN where there is no integral, or where its round-off is 0.01 of the work or more. Then less
    than two digits are left, too few to compare the friction work with. `loop_integral` holds the
    integral and its round-off, None where there is none.
    """
    loop_integral = friction_work.loop_integral
    if loop_integral is None:
        return math.nan
    work_of_last_cycle = friction_work.of_last_cycle
    if not work_of_last_cycle:
        return 0.0
    # _LARGEST_ERROR_SHARE_OF_LOOP: 0.01
    is_precise = loop_integral.roundoff < _LARGEST_ERROR_SHARE_OF_LOOP * work_of_last_cycle
    return loop_integral.value if is_precise else math.nan


# ------------------------------------------------------------------------------- fields at instants
class _AnswerFields(NamedTuple):
    """Loads, edges and fields of an answer, by their names in a solution.

    Attributes
    ----------
    over_time
        loads, displacements and half-widths (n,), edges (n, 2) at n instants
    at_points
        pressure, shear, slip and state at n instants and m points, (n, m) each
    arc_errors
        errors of the integrals of "shear" and "slip" along arcs, curved pieces of the memory curve
    """

    over_time: dict[str, Array]
    at_points: dict[str, NDArray[Any]]
    arc_errors: dict[str, float]


def _fields_of_answer(request: Request, snapshot: Snapshot) -> _AnswerFields:
    """Loads, edges and fields at the instants and points of a request, from the friction states at
    the instants, each with its memory curve.

    Raises
    ------
    NotFoundError
        Where a half-width or a value of a field is not a number.
    """
    loads_and_edges = _values_over_time(request, snapshot)
    fields_at_points, arc_errors = _fields_at_points(request, snapshot, loads_and_edges)
    return _AnswerFields(loads_and_edges, fields_at_points, arc_errors)


def _values_over_time(request: Request, snapshot: Snapshot) -> dict[str, Array]:
    """Loads, displacements, half-widths (n,) and edges (n, 2) at the instants of a request, by the
    names of a ContactSolution [force per thickness, length].

    With bulk stress and tilt also these, and the moments of the tractions; edges are then those of
    the tilted contact. Displacements that were not asked for are NaN, and so are the edges of no
    stick zone. Under a flat face the stick zone is no narrower than the flat, at the very limit |Q|
    = f P too.

    Parameters
    ----------
    request
        instants `time` (n,), wanted fields, A/pi as `unit_compliance`, A = 2/E*; `bulk_tilt_path`,
        the tilted contact with its loads, None without bulk stress and tilt
    snapshot
        friction states at the instants: P as `load`; as `force` Q, or a load in its place where
        bulk strain alone shears the contact

    Raises
    ------
    NotFoundError
        Where no half-width was found for a load.
    """
    contact = request.contact
    # a(P); NotFoundError where none is found
    half_width = _half_width(contact, snapshot.load)
    stick_half_width = _stick_half_width(contact, snapshot, half_width)
    # U over A/pi, U the tangential displacement, and normal approach: NaN unless asked for
    displacement_over_compliance = np.full(len(request.time), np.nan)
    approach = displacement_over_compliance
    # the integral of ln(2 L/a) over the memory curve (tangential force carried up to each load).
    # a(P) is the contact half-width, L the datum length; the point x has no effect.
    if request.wants("tangential_displacement"):
        displacement_over_compliance = KernelIntegrals(
            contact, np.zeros(1), "shift"
        ).over_memory_curves(snapshot)[:, 0]
    if request.wants("normal_approach"):
        # A/pi int_0^P ln(2 L/a) d eta
        approach = request.unit_compliance * contact.approach_integral(snapshot.load)
    signs_of_edges = np.array([-1.0, 1.0])
    values = {
        "normal_load": snapshot.load,
        "tangential_load": snapshot.force,
        "tangential_displacement": request.unit_compliance * displacement_over_compliance,
        "normal_approach": approach,
        "contact_half_width": half_width,
        "stick_half_width": stick_half_width,
        "contact_edges": half_width[:, None] * signs_of_edges,
        "stick_edges": stick_half_width[:, None] * signs_of_edges,
    }
    if request.bulk_tilt_path is not None:
        values |= _values_with_bulk_and_tilt(request, request.bulk_tilt_path, snapshot, values)
    return values


def _values_with_bulk_and_tilt(
    request: Request,
    bulk_tilt_path: OneCurve,
    snapshot: Snapshot,
    values_without_tilt: Mapping[str, Array],
) -> dict[str, Array]:
    """Values over time that bulk stress and tilt add or change, by name. They are bulk stresses,
    tilt, moments of pressure and of shear, half-width, Q and approach (n,), and edges (n, 2).

    The memory curve is the tangential force, or the bulk strain, locked in up to each load.

    Parameters
    ----------
    request
        instants `time` (n,), and the fields that are wanted
    bulk_tilt_path
        loads over time, and the contact under any tilt
    snapshot
        friction states at the instants: P as `load`, P - P_c of the slip zones, P_c the load at the
        stick edge. `force` is Q, or a load in its place where bulk strain alone shears the contact;
        `tangential_fraction`, 1 or 0, is the rise of Q over that of `force`
    values_without_tilt
        those of a contact centred at x = 0; a stick half-width is NaN where nothing sticks
    """
    tilted_contact = bulk_tilt_path.contact
    tilted_values = bulk_tilt_path.values_over_time(request.time, snapshot.load)
    # The curve may be locked-in bulk strain in terms of a load: the fraction of Q is then 0.
    tilted_values["tangential_load"] = snapshot.force * tilted_contact.tangential_fraction
    # the same contact, whose kernel is the moment of the shear
    moment_contact = replace(tilted_contact, kernel_quantity="shear_moment")
    # integrated over the memory curve
    shear_moment = KernelIntegrals(moment_contact, np.zeros(1), "shift").over_memory_curves(
        snapshot
    )[:, 0]
    tilted_values["shear_moment"] = shear_moment
    contact_edges = tilted_values["contact_edges"]
    tilted_values["contact_half_width"] = np.diff(contact_edges)[:, 0] / 2
    has_slip_zones = (snapshot.slip_zone_load > 0) | np.isnan(
        values_without_tilt["stick_half_width"]
    )
    # the stick zone has the middle of a contact under P_c
    stick_edge_load = snapshot.load - snapshot.slip_zone_load
    stick_centre = tilted_contact.centre(stick_edge_load)
    stick_edges = stick_centre[:, None] + values_without_tilt["stick_edges"]
    tilted_values["stick_edges"] = np.where(has_slip_zones[:, None], stick_edges, contact_edges)
    if not request.wants("normal_approach"):
        tilted_values["normal_approach"] = values_without_tilt["normal_approach"]
    return tilted_values


def _half_width(contact: Contact, load: Array) -> Array:
    """Half-widths a(P) of contact under normal loads, (n,) [length]; NotFoundError, rather than a
    NaN in the answer, where none was found.
    """
    half_width = contact.half_width(load)
    numbers_not_found = np.flatnonzero(~np.isfinite(half_width))
    if len(numbers_not_found):
        raise NotFoundError(
            f"no half-width was found for the normal load {float(load[numbers_not_found[0]]):.17g}"
        )
    return half_width


def _stick_half_width(contact: Contact, snapshot: Snapshot, half_width: Array) -> Array:
    """Half-widths of the stick zone at n instants, (n,) [length]: a(P_c), with P_c the load at the
    stick edge; `half_width` (n,), that of contact, in full stick; NaN where nothing sticks.

    `snapshot` has P as `load`, and P - P_c as `slip_zone_load`. A flat face sticks over its flat at
    least, however small P_c. NotFoundError where no half-width is found.
    """
    stick_edge_load = snapshot.load - snapshot.slip_zone_load
    instants_with_slip = np.flatnonzero(snapshot.slip_zone_load)
    stick_half_width = half_width.copy()
    stick_half_width[instants_with_slip] = _half_width(contact, stick_edge_load[instants_with_slip])
    # no stick zone: all of the contact slips, and the face has no flat
    stick_half_width[(stick_edge_load <= 0) & (stick_half_width == 0)] = np.nan
    return stick_half_width


def _fields_at_points(
    request: Request, snapshot: Snapshot, loads_and_edges: Mapping[str, Array]
) -> tuple[dict[str, NDArray[Any]], dict[str, float]]:
    """Pressure, shear, slip and state of contact at the n instants and m points of a request, (n,
    m) each, read-only. Second: the errors of shear and slip by integration along arcs.

    An arc is a curved piece of the memory curve M(eta), the tangential force of the flat punches up
    to the load eta. A field that was not asked for is NaN, or open, without storage. Fields are
    computed at the different |x| of the request, `distance` (k,); `distance_index` (m,) is that of
    each point. Tractions are infinite at the tip of a sharp wedge.

    Parameters
    ----------
    snapshot
        friction states at the instants, P among them, with the memory curve of each
    loads_and_edges
        half-widths and edges at each instant, by name

    Raises
    ------
    NotFoundError
        Where a value of a field is not a number.
    """
    shape_of_fields = (len(request.time), len(request.distance_index))
    # for fields that were not asked for
    fields: dict[str, NDArray[Any]] = {
        name: np.broadcast_to(np.nan, shape_of_fields) for name in ("pressure", "shear", "slip")
    }
    fields["state"] = np.broadcast_to(np.int8(OPEN), shape_of_fields)

    fields_at_distances: dict[str, NDArray[Any]] = {}
    if request.wants("pressure"):
        fields_at_distances["pressure"] = _pressure_of(request, snapshot, loads_and_edges)
    # integrals over memory curves: of the shear, and of slip over A/pi, A = 2/E*
    shear_integrals = KernelIntegrals(request.contact, request.distance, "shear")
    slip_integrals = KernelIntegrals(request.contact, request.distance, "slip")
    if request.wants("shear"):
        fields_at_distances["shear"] = shear_integrals.over_memory_curves(snapshot)
    if request.wants("slip"):
        fields_at_distances["slip"] = request.unit_compliance * slip_integrals.over_memory_curves(
            snapshot
        )
    if request.wants("state"):
        fields_at_distances["state"] = _state_of(request, snapshot, loads_and_edges)

    for name, field_at_distances in fields_at_distances.items():
        _require_finite(name, field_at_distances, request)
        field_at_points = field_at_distances.take(request.distance_index, axis=1)
        field_at_points.flags.writeable = False
        fields[name] = field_at_points
    return fields, {"shear": shear_integrals.arc_error, "slip": slip_integrals.arc_error}


def _pressure_of(
    request: Request, snapshot: Snapshot, loads_and_edges: Mapping[str, Array]
) -> Array:
    """Contact pressure at the instants and distances of a request, (n, k) [stress].

    With bulk stress and tilt it follows from the edges and half-widths of the tilted contact, in
    `loads_and_edges`; `bulk_tilt_path` is None without these. `distance` (k,) are the different
    |x|, or x with bulk stress and tilt; `snapshot.load` (n,) is P.
    """
    if request.bulk_tilt_path is None:
        return request.contact.pressure(request.distance, snapshot.load[:, None])
    contact_centre = np.mean(loads_and_edges["contact_edges"], axis=1)
    half_width = loads_and_edges["contact_half_width"]
    tilted_contact = request.bulk_tilt_path.contact
    return tilted_contact.pressure_over(request.distance, contact_centre, half_width)


def _state_of(
    request: Request, snapshot: Snapshot, loads_and_edges: Mapping[str, Array]
) -> NDArray[np.int8]:
    """State of contact at the instants and distances of a request, (n, k): open, stick, slip
    forward or slip in reverse, by the codes of a ContactSolution.

    A point in contact sticks between the stick edges. Outside of them it slips in the direction
    that `snapshot` has, and sticks where that is 0. Edges of contact and of stick, (n, 2), are in
    `loads_and_edges`. Where no edges of stick are left, NaN, the stick zone is x = 0 alone.
    `snapshot` holds P as `load` and the direction, 1 forward, -1 in reverse, 0 none.
    """
    contact = request.contact
    distances = request.distance
    # Where the ends of the contact slip in opposite directions, the snapshot has that of one end.
    sign_at_points = (
        contact.slip_direction_at(distances).astype(int) if isinstance(contact, OppositeSlip) else 1
    )
    codes_by_direction = np.array((SLIP_REVERSE, STICK, SLIP_FORWARD), dtype=np.int8)
    direction_at_points = snapshot.direction[:, None] * sign_at_points  # -1, 0 or 1
    state_outside_stick_edges = codes_by_direction[direction_at_points + 1]
    is_between_stick_edges = is_between_edges(loads_and_edges["stick_edges"], distances)
    is_in_contact = is_between_edges(loads_and_edges["contact_edges"], distances)
    is_in_contact &= snapshot.load[:, None] > 0
    contact_state = np.where(is_between_stick_edges, np.int8(STICK), state_outside_stick_edges)
    return np.where(is_in_contact, contact_state, np.int8(OPEN))


def _require_finite(name: str, values: NDArray[Any], request: Request) -> None:
    """Raise NotFoundError, with place and instant, where a value (n, k) of the field `name` is not
    finite. Tractions may be infinite at x = 0, the tip of a sharp wedge. The request holds its
    instants `time` (n,) and the different |x|, `distance` (k,).
    """
    is_finite = np.isfinite(values)
    if name in ("pressure", "shear"):
        is_finite |= np.isinf(values) & (request.distance == 0)
    if np.all(is_finite):
        return
    instant_indices, point_indices = np.nonzero(~is_finite)
    x = request.distance[point_indices[0]]
    time = request.time[instant_indices[0]]
    raise NotFoundError(f"no {name} was found at |x| = {x:.17g}, time {time:.17g}")


# ---------------------------------------------------------------- what a solution says of itself
def _relative_errors(
    request: Request, path_answer: PathAnswer, answer_fields: _AnswerFields, loop_work: float
) -> dict[str, float]:
    """Estimated relative errors of the values that were asked for, by name. Each is a share of the
    largest pressure p, f p, slip, tangential displacement U, friction work per area W(x) or W.

    Those of fields next to edges are named "... at the edge". Closed forms promise round-off and
    have no entry. "cycle_dissipation" is the error of the worst cycle, where it is above that of
    the last.

    Parameters
    ----------
    request
        holds the normal contact, the fields that are wanted, and A/pi, `unit_compliance`
    path_answer
        friction states at the instants, and friction work of the covered cycles
    answer_fields
        the answer's values over time, and its fields at points
    loop_work
        closed integral of Q dU of the last cycle, NaN where there is none to compare W with

    Raises
    ------
    NotFoundError
        For an error that is not a number.
    """
    errors = {"dissipation_density": path_answer.friction_work.density_error}
    errors |= _errors_of_fields(request, path_answer, answer_fields)
    if request.wants("dissipation"):
        work_errors = _errors_of_work(request, path_answer, loop_work)
        errors["dissipation_density"] += work_errors["dissipation"]
        errors |= work_errors
    # only what was asked for, and is not 0
    names_in_answer = (
        *request.wanted_fields,
        "cycle_dissipation",
        *(f"{name} at the edge" for name in request.wanted_fields),
    )
    errors = {name: error for name, error in errors.items() if error and name in names_in_answer}
    for name, error in _errors_of_neglect(request).items():
        errors[name] = errors.get(name, 0.0) + error
    return errors


def _errors_of_fields(
    request: Request, path_answer: PathAnswer, answer_fields: _AnswerFields
) -> dict[str, float]:
    """Relative errors of pressure, shear, slip and tangential displacement U, by name, 0 or more;
    some have no entry where the field was not asked for.

    `path_answer` holds the friction states at the instants, `answer_fields` the answer's values
    over time and at points. The request holds the normal contact and A/pi, `unit_compliance`, A =
    2/E*.
    """
    errors: dict[str, float] = {}
    if request.wants("pressure", "shear", "slip"):
        # points, loads and sizes from which the errors of fields follow
        kernel_sums = _kernel_sums(request, path_answer.snapshot, answer_fields)
        errors |= errors_of_sums(request.contact, kernel_sums)
    # by the last digits of P_c, the load at the stick edge, where little slips
    errors["slip"] = errors.get("slip", 0.0) + roundoff_error_of_little_slip(
        "slip", path_answer.largest_slip_zone_share
    )
    if request.wants("tangential_displacement"):
        # from the integrals of ln(2 L/a) over loads and over the memory curve: a(P) is
        # the contact half-width, L the datum length
        errors["tangential_displacement"] = error_of_displacement(
            path_answer.snapshot.friction,
            request.contact.approach_integral(answer_fields.over_time["normal_load"]),
            answer_fields.over_time["tangential_displacement"] / request.unit_compliance,
        )
    return errors


def _errors_of_work(
    request: Request, path_answer: PathAnswer, loop_work: float
) -> dict[str, float]:
    """Relative errors of the friction work W of the last cycle, "dissipation", and of the closed
    integral of Q dU, "loop_work", which should be the same; U is the relative tangential
    displacement.

    The error of W has two parts: that of the quadrature along the path, and that of its kernel.
    The error of "loop_work" is that of the quadrature, plus how much the integral differs from W.
    "cycle_dissipation" is the error of the worst cycle, where it is above that of the last.
    `loop_work` is the integral, NaN where there is none; `spans` of the followed path are times of
    stick or slip in the last cycle.
    """
    friction_work = path_answer.friction_work
    kernel_error, difference_of_routes = error_of_work(
        request.contact,
        path_answer.spans,
        friction_work.of_last_cycle / request.unit_compliance,
        _loop_integral_of(request, path_answer, loop_work),
    )
    error_of_last_cycle = float(friction_work.relative_errors[-1])
    loop_error = error_of_last_cycle + difference_of_routes
    # PROMISED_ERROR: 1e-12, which closed forms promise
    errors = {
        "loop_work": loop_error if loop_error > PROMISED_ERROR else 0.0,
        "dissipation": error_of_last_cycle + kernel_error,
    }
    error_of_worst_cycle = float(np.max(friction_work.relative_errors))
    if error_of_worst_cycle > errors["dissipation"]:
        errors["cycle_dissipation"] = error_of_worst_cycle
    return errors


def _loop_integral_of(request: Request, path_answer: PathAnswer, loop_work: float) -> LoopIntegral:
    """The closed integral of Q dU of the last cycle, `loop_work`, a second route to the friction
    work, and its round-off; both over A/pi [force^2 per thickness^2]. NaN and 0 where there is
    none.
    """
    loop_integral = path_answer.friction_work.loop_integral
    roundoff = loop_integral.roundoff if loop_integral is not None else 0.0
    return LoopIntegral(loop_work / request.unit_compliance, roundoff / request.unit_compliance)


def _kernel_sums(
    request: Request, snapshot: Snapshot, answer_fields: _AnswerFields
) -> SumsOfKernels:
    """Sizes from which the errors of pressure, shear and slip are estimated: the points,
    half-widths, loads, the largest slip, and how many terms a field is the sum of at most.

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta. Each
    straight piece of it adds two terms to shear and slip: its slope times a kernel at both its
    ends. A kernel is the field of all flat punches up to a load, each with its load as force. The
    request holds the different |x|, `distance`, and A/pi, `unit_compliance`, A = 2/E*.

    Parameters
    ----------
    snapshot
        friction states at the instants, with the memory curve of each
    answer_fields
        half-widths of contact and of stick at each instant, and the answer's slip, NaN where it was
        not asked for
    """
    # _SAMPLED_INSTANTS: 7
    sampled_instants = np.unique(
        np.linspace(0, len(snapshot.load) - 1, _SAMPLED_INSTANTS).astype(int)
    )
    sampled_loads = snapshot.load[sampled_instants]
    slip = np.abs(answer_fields.at_points["slip"])
    largest_slip = float(np.max(slip, where=np.isfinite(slip), initial=0.0))
    # Beside the stored pieces a curve has a straight one by slip, from the stick edge to the load.
    most_pieces = _largest_piece_count(snapshot, sampled_instants) + 1
    return SumsOfKernels(
        distances=request.distance,
        loads=np.unique(np.append(sampled_loads, np.max(snapshot.load))),
        half_widths=answer_fields.over_time["contact_half_width"],
        stick_half_widths=answer_fields.over_time["stick_half_width"],
        friction=snapshot.friction,
        largest_slip=largest_slip / request.unit_compliance,
        n_kernels=2 * most_pieces,
        arc_errors=answer_fields.arc_errors,
    )


def _largest_piece_count(snapshot: Snapshot, instants: Indices) -> int:
    """The largest number of pieces of the memory curves at some instants (k,). The snapshot stores
    the piece in which the stick edge is; that piece holds all pieces below it.
    """
    curves = [snapshot.sticking_pieces[number] for number in snapshot.piece_number[instants]]
    return max((len(list(pieces(curve))) for curve in curves), default=0)


def _errors_of_neglect(request: Request) -> dict[str, float]:
    """Relative errors of the fields of friction, by name, by small loads that were left out so that
    one memory curve is enough.

    Empty where these are negligible, below 1e-12 in all. A memory curve is the tangential force, or
    the bulk strain, locked in up to each load. `bulk_tilt_path` of the request is None without bulk
    stress and tilt.
    """
    if request.bulk_tilt_path is None:
        return {}
    # Each neglected load is a share of what makes an edge of contact slip or lift.
    neglected_share = sum(request.bulk_tilt_path.neglected_loads.values())
    if neglected_share <= PROMISED_ERROR:
        return {}
    return dict.fromkeys(sorted(request.wanted_fields & _FIELDS_OF_FRICTION), neglected_share)


def _neglected_loads(bulk_tilt_path: OneCurve | None) -> Iterator[str]:
    """A sentence for each load that is below rounding and was left out, so that the memory of
    friction is one curve.
    """
    neglected_shares = bulk_tilt_path.neglected_loads if bulk_tilt_path is not None else {}
    for name, share in neglected_shares.items():
        size_of_load = f"{share:.1e} of what makes an edge of contact slip"
        yield f"{name}: {size_of_load} is below rounding and was left out of the memory of friction"


def _notes_of_path(
    question: Question, followed_path: LoadSeries | History, n_rows: int, n_rows_left_out: int
) -> Iterator[str]:
    """Sentences for the notes of an answer on its path: that the last cycle is not steady, and that
    rows of a measurement are left out.

    The first comes if friction work was wanted and the path is periodic. The second states the
    `n_rows` of the answer and the `n_rows_left_out`. The question states which fields are wanted;
    `covered` are the cycles of the answer, `steady_from` is the first steady one, None without one.
    """
    is_steady = (
        followed_path.steady_from is not None
        and followed_path.covered[-1] >= followed_path.steady_from
    )
    if question.wants("dissipation") and followed_path.period is not None and not is_steady:
        yield (
            "the last cycle is not steady: no closed integral of Q dU to compare the dissipation"
            " with"
        )
    if n_rows_left_out:
        yield (
            f"with pointwise fields the answer is given at {n_rows} rows, {n_rows_left_out} were"
            " left out; `time` chooses others"
        )


def _notes_of_errors(errors: Mapping[str, float]) -> Iterator[str]:
    """Sentences for the notes of an answer: one for each relative error above 1e-9, but for those
    of fields next to an edge.
    """
    for name, error in errors.items():
        if error > _DOUBTFUL_RELATIVE_ERROR and "edge" not in name:
            reference = "the largest value"
            if name in ("dissipation", "loop_work"):
                reference = "it"
            elif name == "cycle_dissipation":
                reference = "W of a cycle before the last"
            error_words = f"an error of {error:.1e} of {reference}"
            yield f"{name}: quadratures and rounding may have left {error_words}"


def _termination_and_message(followed_path: LoadSeries | History) -> tuple[str, str]:
    """How a followed path ended, as a term, "steady" or "end of path", and as a sentence."""
    if followed_path.period is None:
        return "end of path", "the path was followed to its end"
    if followed_path.steady_from is None:
        return "end of path", f"no steady cycle among the first {len(followed_path.cycles)}"
    return "steady", f"cycle {followed_path.steady_from + 1} ends in the state it started from"


def _skipped_computations(
    scene: Scene, followed_path: LoadSeries | History, path_answer: PathAnswer
) -> dict[str, tuple[int, str]]:
    """Computations that were not needed and not done, by name, with their number and the reason.
    They are cycles that are copies of the steady one, and quadratures over times of full stick.

    `covered` has one entry for each whole cycle of the answer, `cycles` the solved ones;
    `steady_from` is the first steady one, None without one. `repeats` is whether cycles after it
    are copies. `cycles` of the scene is the number of cycles that it states. `n_skipped_in_stick`
    counts those quadratures.
    """
    skipped_computations = {}
    n_copies = max(scene.cycles, len(followed_path.covered)) - len(followed_path.cycles)
    if followed_path.repeats and followed_path.steady_from is not None and n_copies > 0:
        skipped_computations["cycles"] = (
            n_copies,
            f"copies of cycle {followed_path.steady_from + 1}, which is steady",
        )
    if path_answer.n_skipped_in_stick:
        skipped_computations["quadratures"] = (
            path_answer.n_skipped_in_stick,
            "full stick: nothing slips",
        )
    return skipped_computations


def _permanent_stick(
    contact: Contact, path_answer: PathAnswer, largest_load: float
) -> dict[str, Any]:
    """Half-width of the permanent stick zone, which sticks all through the last cycle, by name; for
    an unsymmetric contact also its two edges [length]. NaN where nothing sticks throughout.

    The stick zone at an instant is as wide as the contact under a load P_c. The permanent one
    belongs to the least P_c of the cycle. `largest_load` is the largest P of the path,
    `least_stick_load` of the answer the least P_c of the cycle.
    """
    # A P_c below the round-off of P counts as 0: nothing sticks at that instant, not even under a
    # flat face, whose half-width at no load is not 0.
    # LAST_DIGITS: four round-offs
    roundoff_of_load = LAST_DIGITS * largest_load
    stick_load = (
        path_answer.least_stick_load if path_answer.least_stick_load > roundoff_of_load else 0.0
    )
    has_stick = stick_load > 0
    half_width = float(contact.half_width(stick_load)) if has_stick else math.nan
    half_width_and_edges: dict[str, Any] = {"permanent_stick_half_width": half_width}
    if isinstance(contact, TiltedProfile):
        # left and right end of the contact under P_c
        stick_zone_edges = contact.interval(stick_load) if has_stick else np.full(2, math.nan)
        half_width_and_edges["permanent_stick_edges"] = stick_zone_edges
    return half_width_and_edges


def _admissibility_checks(
    request: Request, path_answer: PathAnswer, fields: Mapping[str, NDArray[Any]]
) -> dict[str, Array]:
    """Checks of tangential equilibrium and of the Coulomb limit at each instant, by name, (n,)
    each, 0 where satisfied.

        tangential_balance    |M(P) - Q| / (f times the largest P)
        cone                  the largest |q| - f p, over f times the largest p

    M(P) is the tangential force that the memory curve carries over the whole contact. The Coulomb
    limit ("cone") is checked where `fields` have both tractions. `force_error` of the answer is
    M(P) - Q, its snapshot holds P as `load` and f.
    """
    friction_coefficient = path_answer.snapshot.friction
    largest_friction_force = friction_coefficient * float(np.max(path_answer.snapshot.load))
    relative_force_error = np.abs(path_answer.force_error) / max(
        largest_friction_force, _SMALLEST_FLOAT
    )
    checks = {"tangential_balance": read_only_copy(relative_force_error)}
    if request.wants("pressure") and request.wants("shear"):
        pressure = fields["pressure"]
        # At the tip of a wedge p is infinite: no q is above the Coulomb limit there, and none is a
        # measure of the others.
        with np.errstate(invalid="ignore"):
            excess_shear = np.abs(fields["shear"]) - friction_coefficient * pressure
        # at each instant; NaN is ignored
        largest_excess = np.fmax.reduce(excess_shear, axis=1, initial=0.0)
        largest_pressure = float(np.max(pressure, where=np.isfinite(pressure), initial=0.0))
        checks["cone"] = read_only_copy(
            largest_excess / max(friction_coefficient * largest_pressure, _SMALLEST_FLOAT)
        )
    return checks
