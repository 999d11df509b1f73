"""The answer where one memory curve holds what friction remembers, as `Findings`: fields at the
points and instants that are asked for, and the dissipations, exact to rounding.

A path is followed by `load_series` where all of it is straight, else by `history`. Either leaves a
`PathResult`, the states at the instants and the work of the cycles, and the rest does not ask which
it was.

Errors are estimates from above. A field is a sum of M' times differences of a kernel at the knots
of the memory: its error is that of the kernel, f times, twice a knot. Integrals over arcs come with
their error. The dissipation of a steady cycle is found as f int Lam dw and as closed-int Q dU: what
the two differ by counts as error. Of long series a sample of slip areas counts. Closed forms keep
1e-13 of their own value against forty digits and have no entry but for what arcs lose beyond 1e-12.

# notation: M' slope of the memory curve, |M'| <= f; W dissipation, Lam slip area of the normal
problem
"""

from __future__ import annotations

import math
import time as clock
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
    freeze,
)
from scenes.array_types import Array
from semi_analytic.answer import (
    Findings,
    Question,
    between,
    mirrored_points,
    neglected_coupling,
)
from semi_analytic.bulk_and_tilt import OneCurve
from semi_analytic.elasticity import composite_modulus
from semi_analytic.fields import Integrals
from semi_analytic.friction_work import (
    Loop,
    LoopWork,
    closed_integral,
    density_of_records,
    global_dissipation,
    pointwise_dissipation,
    slip_work,
    work_error,
)
from semi_analytic.history import History, Span, history_of, slipped_share
from semi_analytic.load_series import (
    LoadSeries,
    PathPart,
    Records,
    States,
    StepBlock,
    blocks,
    depth_of,
    series_of,
    straight_series,
)
from semi_analytic.memory import (
    LAST_DIGITS,
    PROMISED,
    Piece,
    Snapshot,
    force_on_piece,
    pieces,
)
from semi_analytic.opposite_slip import OppositeSlip
from semi_analytic.profiles import Contact, SymmetricContact, contact_of
from semi_analytic.quadrature import NODES
from semi_analytic.stated_errors import (
    LoopIntegral,
    Sums,
    error_by_slipped_load,
    error_of_displacement,
    error_of_work,
    errors_of_sums,
)
from semi_analytic.steady_ellipse import Ellipses, digits_of_loop, ellipses_of, works_over_time
from semi_analytic.tilted_profile import TiltedProfile

Indices = NDArray[np.int64]

# Instants at which the errors of fields are looked at.
_INSTANTS = 7
_TINY = float(np.finfo(float).tiny)
# Rounding of the closed integral of Q dU over the dissipation, above which it is no second route
# any more.
_TOO_ROUGH = 1e-2
# Errors that a note says, share of the largest value.
_DOUBTFUL = 1e-9

_OF_FRICTION = frozenset(
    ("shear", "slip", "tangential_displacement", "dissipation", "dissipation_density")
)
"""Those that bulk strain and tilt change in the first order."""


# --------------------------------------------------------------------------------- the whole answer
@dataclass(frozen=True, eq=False)
class Request:
    """What is to be evaluated.

    Attributes
    ----------
    contact, modulus
        normal contact, E*
    time
        (n,) instants as asked for
    x
        (m,) points as asked for
    distance
        (k,) different |x|; different x of an unsymmetric contact
    number_of_distance
        (m,) where each x finds its own distance
    fields
        the fields that are wanted
    family
        the path with bulk stress and tilt; None without
    """

    contact: Contact
    modulus: float
    time: Array
    x: Array
    distance: Array
    number_of_distance: Indices
    fields: frozenset[str]
    family: OneCurve | None = None

    @property
    def unit_compliance(self) -> float:
        """A/pi, with A = 2/E*."""
        return 2 / (math.pi * self.modulus)

    def wants(self, *names: str) -> bool:
        """Whether one of these fields is wanted."""
        return not self.fields.isdisjoint(names)


def by_memory(question: Question, family: OneCurve | None) -> Findings:
    """Half-plane answer where one memory curve holds what friction remembers: fields, friction work
    of the cycles, their errors and notes.

    The memory curve is the tangential force carried up to each load. With bulk stress or tilt there
    is one only for some load paths: `family` is then the tilted contact, None without.
    """
    started = clock.perf_counter()
    scene = question.scene
    path = path_of_question(question, family)
    time = question.time
    rows_left_out = 0
    if time is None:
        time, rows_left_out = path.default_times(
            question.cycles == "steady", question.wants_pointwise
        )
        if question.cycles == "steady":
            path = replace(path, covered=path.covered[-1:])
    request = _request_of(question, family, path, time)
    history_done = clock.perf_counter()
    path_answer = path_result(path, request)
    work_done = clock.perf_counter()
    loads_and_edges = _series_of(request, path_answer.snapshot)
    fields, arc_errors = _grids_of(request, path_answer.snapshot, loads_and_edges)
    fields_done = clock.perf_counter()
    work_of_last_cycle = float(path_answer.works[-1])
    loop_work = _loop_work_of(path_answer)
    errors = _errors(request, path_answer, loads_and_edges, fields, arc_errors, loop_work)
    errors_of_neglect = _errors_of_neglect(question, family)
    for name, error in errors_of_neglect.items():
        errors[name] = errors.get(name, 0.0) + error
    notes = [
        *neglected_coupling(scene.material),
        *_neglected_loads(family),
        *_notes_of_path(question, path, len(time), rows_left_out),
        *_notes_of_errors(errors),
    ]
    termination, message = _ending_of(path)
    permanent_stick = _permanent_stick(request.contact, path_answer, path.largest_load)
    seconds = {"history": history_done - started, "fields": fields_done - work_done}
    seconds["dissipation"] = work_done - history_done + clock.perf_counter() - fields_done
    # Work of each increment, where every instant is a row of the path.
    energy_over_time = {}
    if len(path_answer.increments):
        energy_over_time["dissipation"] = freeze(path_answer.increments)
    return Findings(
        time=time,
        x=request.x,
        values=loads_and_edges
        | fields
        | permanent_stick
        | {
            "dissipation": work_of_last_cycle,
            "loop_work": loop_work,
            "cycle_dissipation": path_answer.works,
            "dissipation_density": path_answer.density[request.number_of_distance],
            "steady_from": path.steady_from,
        },
        termination=termination,
        message=message,
        notes=tuple(notes),
        errors=errors,
        certificates=_admissibility(request, path_answer, fields),
        energy=energy_over_time,
        counts={"points_evaluated": len(request.distance), "cycles_solved": len(path.cycles)}
        | path_answer.counts,
        skipped=_skipped_of(scene, path, path_answer),
        seconds=seconds,
    )


def path_of_question(question: Question, family: OneCurve | None) -> LoadSeries | History:
    """The load path of a question with its friction history: straight steps between the times asked
    for, or the curved path of the scene.

    With bulk stress or tilt, `family` has the loads along the path that one memory curve needs. A
    memory curve is the tangential force, or the bulk strain, locked in up to each load.

    Raises
    ------
    InputError
        For straight steps without times.
    """
    scene = question.scene
    friction = scene.friction.coefficient
    if question.straight_steps:
        if question.time is None:
            raise InputError("straight_steps: give the times between which the steps are straight")
        path = scene.load.path() if family is None else family.path
        return straight_series(path, friction, question.time)
    if family is not None:
        return history_of(family.path, friction, scene.cycles, question.time)
    return _path_of(scene, question.time)


def _path_of(scene: Scene, time: Array | None) -> LoadSeries | History:
    """The scene's own path, followed by straight steps where no leg is curved: on a curved one some
    sum of P and Q turns round.
    """
    if not isinstance(scene.load, TimeSeriesLoad):
        path = scene.load.path()
        if any(leg.most_turns for leg in (*path.initial_loading, *path.cycle)):
            return history_of(path, scene.friction.coefficient, scene.cycles, time)
    return series_of(scene, time)


def _request_of(
    question: Question, family: OneCurve | None, path: LoadSeries | History, time: Array
) -> Request:
    """What the memory curves of a followed `path` are evaluated for: contact, fields, instants
    `time` (n,) and points. A memory curve M(eta) is the tangential force of the flat punches up to
    the load eta.

    Where the question has no points they are chosen across the contact at the largest P; on a long
    path, of which nothing asks for points, x = 0 alone. A symmetric contact is evaluated at
    different |x| only. `family` holds the contacts of all loads under bulk stress or tilt on which
    one memory curve exists; None without these.
    """
    scene = question.scene
    contact = family.contact if family is not None else contact_of(scene.profile, scene.material)
    x = question.x
    if x is None:
        needs_points = question.wants_pointwise or question.wants("dissipation_density")
        x = (
            _points_of(contact, path.largest_load)
            if needs_points or not path.is_long_record
            else np.zeros(1)
        )
    if family is None:
        different_points, number_of_point = folded(x)
    else:
        different_points, number_of_point = np.unique(x, return_inverse=True)
    modulus = composite_modulus(scene.material)
    return Request(
        contact, modulus, time, x, different_points, number_of_point, question.fields, family
    )


def folded(x: Array) -> tuple[Array, Indices]:
    """Different |x| (k,), ascending, and where each point (m,) finds its own; sides that differ by
    a last digit are one.

    >>> folded(np.array([-1.0, 0.0, 1.0 + 2.3e-16]))
    (array([0., 1.]), array([1, 0, 1]))
    """
    distances, place_of_distance = np.unique(np.abs(x), return_inverse=True)
    is_new = np.diff(distances, prepend=-np.inf) > 2 * np.finfo(float).eps * distances[-1]
    return distances[is_new], (np.cumsum(is_new) - 1)[place_of_distance]


def _points_of(contact: Contact, largest_load: float) -> Array:
    """Points across the largest contact and a little beyond; an unsymmetric one is not mirrored."""
    points = mirrored_points(1.05 * float(contact.half_width(largest_load)))
    return (
        points + float(contact.centre(largest_load))
        if isinstance(contact, TiltedProfile)
        else points
    )


def memory_at(scene: Scene, time: Array) -> tuple[SymmetricContact, Snapshot]:
    """Normal contact of a scene, and its friction memory at instants (n,) of the load path: the
    tangential force carried up to each load.

    Raises
    ------
    InputError, InadmissibleLoadError
        For what half-plane theory cannot solve: gross sliding, separation, a profile that splits.
    """
    contact = contact_of(scene.profile, scene.material)
    path = _path_of(scene, time)
    if isinstance(path, History):
        return contact, path.snapshot(time)
    middle_point, number_of_point = folded(np.zeros(1))
    modulus = composite_modulus(scene.material)
    request = Request(
        contact, modulus, time, middle_point, middle_point, number_of_point, frozenset({"shear"})
    )
    return contact, path_result(path, request).snapshot


# --------------------------------------------------------------- states at instants, work of cycles
@dataclass(frozen=True, eq=False)
class PathResult:
    """What a followed path leaves for an answer, whichever way it was followed.

    Attributes
    ----------
    snapshot
        memory curves at the instants; without their pieces where no field needs them
    balance
        (n,) M(P) - Q there
    least_stick_load
        least P_c of the last cycle
    slipped_share
        largest (P - P_c)/P of all that was followed
    works
        (n_cycles,) friction work of the covered cycles, NaN where it was not wanted
    work_errors
        (n_cycles,) their relative errors
    density
        (k,) W(x) of the last cycle, NaN where it was not wanted
    density_error
        its error over its largest value
    loop
        closed integral of Q dU of the last cycle; None where it is not steady, or neither
        asked for nor needed for the error of the dissipation
    spans
        of the last cycle, none for straight steps
    increments
        (n,) friction work since the instant before, empty where instants lie between rows
    counts
        what was done
    full_stick
        how many quadratures were not done, since nothing slips
    """

    snapshot: Snapshot
    balance: Array
    least_stick_load: float
    slipped_share: float
    works: Array
    work_errors: Array
    density: Array
    density_error: float
    loop: LoopWork | None
    spans: Sequence[Span]
    increments: Array
    counts: dict[str, int]
    full_stick: int


def path_result(path: LoadSeries | History, request: Request) -> PathResult:
    """States at the instants of the request and the friction work of the cycles.

    Raises
    ------
    InputError
        For a time outside the path.
    """
    if isinstance(path, History):
        return _result_of_history(path, request)
    return _result_of_series(path, request)


class _Located(NamedTuple):
    """The instants of a request in the order of the path, (n,) each: step, share of it that is
    over, how far the share may be off. `back` brings them into the order of the request.
    """

    step: Indices
    share: Array
    slack: Array
    back: Indices

    @classmethod
    def along(cls, series: LoadSeries, time: Array) -> _Located:
        """Instants (n,) along a series."""
        step, share, slack = series.locate(time)
        order_in_path = np.lexsort((share, step))
        return cls(
            step[order_in_path],
            share[order_in_path],
            slack[order_in_path],
            np.argsort(order_in_path),
        )

    @property
    def all_at_rows(self) -> bool:
        """Whether each instant is a row of the series."""
        is_start = (self.share == 0) & (self.step == 0)
        return bool(np.all((self.share == 1) | is_start))

    def within(self, first_step: int, n_steps: int) -> tuple[Indices, Array, Array]:
        """Of the instants that lie in `n_steps` steps from number `first_step` on: step counted
        from that one, share of the step that is over, error of that share; (k,) each.
        """
        bounds = np.searchsorted(self.step, [first_step, first_step + n_steps])
        instants = slice(*bounds.tolist())
        return self.step[instants] - first_step, self.share[instants], self.slack[instants]


class _WantedOfPart(NamedTuple):
    """What is wanted of one part of a load path: its friction work, that of each step, and W(x)."""

    work: bool
    work_of_steps: bool
    density: bool


@dataclass(eq=False)
class _SeriesSums:
    """Sums over the blocks of a load series.

    Attributes
    ----------
    works, errors, shares
        (parts,) friction work of each part, its error, largest (P - P_c)/P
    step_works
        (steps + 1,) friction work of each step, behind a 0; (1,) where it is not wanted
    density
        (k,) W(x) of the last cycle
    least_stick_load
        least P_c of the last cycle
    full_stick
        records without slip in what was integrated
    counts
        what was done
    """

    works: Array
    errors: Array
    shares: Array
    step_works: Array
    density: Array
    least_stick_load: float = math.inf
    full_stick: int = 0
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

    def count(self, block: StepBlock, integrals_per_span: int, pieces_before: int) -> None:
        """Count what a block of load steps took: parts of steps, slip zones, integrals, pieces of
        the memory curve.

        A step has one part or several, each with slip in one direction or in full stick. The memory
        curve M(eta) is the tangential force of the flat punches up to the load eta. It consists of
        straight pieces: each step adds one, and slip drops those that it passes.

        Parameters
        ----------
        integrals_per_span
            integrals (work, its density) that are taken over each part of a step
        pieces_before
            pieces of the memory curve before the block
        """
        n_spans = len(block.records.row)
        n_slips = int(np.count_nonzero(block.records.direction))
        n_steps = len(block.rows) - 1
        pieces_after = depth_of(block.curve)
        self.counts["spans"] += n_spans
        self.counts["slips"] += n_slips
        self.counts["slip_quadratures"] += integrals_per_span * n_slips
        self.full_stick += integrals_per_span * (n_spans - n_slips)
        self.counts["pieces_dropped"] += n_steps + pieces_before - pieces_after
        self.counts["pieces_alive"] = max(self.counts["pieces_alive"], block.most_lines)

    def add_block(
        self,
        block: StepBlock,
        part_number: int,
        first_step: int,
        wanted: _WantedOfPart,
        request: Request,
        friction: float,
    ) -> None:
        """Add the friction work of a block of load steps, and its density W(x), where they are
        wanted.

        Parameters
        ----------
        part_number, first_step
            number of the part of the path, and number of the block's first step in the whole path
        request
            contact, A/pi and the points of W(x)
        friction
            f
        """
        contact = request.contact
        work_per_sum = request.unit_compliance * friction
        slipping_records = block.records.slipping()
        if wanted.work:
            integrals = self.add_work(part_number, contact, slipping_records, work_per_sum)
            if wanted.work_of_steps:
                n_steps = len(block.rows) - 1
                step_numbers = slice(first_step + 1, first_step + 1 + n_steps)
                self.step_works[step_numbers] = work_per_sum * np.bincount(
                    slipping_records.row, integrals, n_steps
                )
        if wanted.density:
            self.density += work_per_sum * density_of_records(
                contact, slipping_records, request.distance
            )

    def add_work(
        self, part_number: int, contact: Contact, records: Records, work_per_sum: float
    ) -> Array:
        """Add the friction work of a block of slip `records`, and its error, to part `part_number`
        of the path; the integral of each record is returned, (m,).

        An integral is int Lam dw, Lam the integral of ln(a/c) over loads, dw the slip force over f;
        `work_per_sum` = f A/pi times it is work.
        """
        integrals, n_nodes = slip_work(contact, records)
        self.works[part_number] += work_per_sum * float(np.sum(integrals))
        self.errors[part_number] += work_per_sum * work_error(contact, records)
        self.counts["quadrature_nodes"] += n_nodes
        return integrals

    def rounding_of_parts(self) -> Array:
        """Relative error by rounding of the friction work of each part, (parts,)."""
        return np.array(
            [error_by_slipped_load("dissipation", share) for share in self.shares.tolist()]
        )

    def quadrature_errors(self) -> Array:
        """Relative error by quadrature of the friction work of each part, (parts,); 0 of none."""
        no_work = np.zeros(len(self.works))
        return np.divide(self.errors, self.works, out=no_work, where=self.works > 0)

    def see_stick_edge(self, block: StepBlock) -> None:
        """Lower the least load P_c at the stick edge of the last cycle, where it is lower in a
        block of load steps.
        """
        records = block.records
        edge_loads = records.load - records.slipped
        edge_loads_after = records.load_after - records.slipped_after
        least_of_block = min(float(np.min(edge_loads)), float(np.min(edge_loads_after)))
        self.least_stick_load = min(self.least_stick_load, least_of_block)


def _result_of_series(series: LoadSeries, request: Request) -> PathResult:
    """State of friction at the instants of a request, and friction work, along a load path of
    straight steps, a load `series`.

    The path was followed once to find its cycles. Now the parts of it that the answer needs are
    followed again, block by block, and work and states are gathered.
    """
    contact = request.contact
    friction = series.friction
    wants_work = request.wants("dissipation")
    wants_density = request.wants("dissipation_density")
    located = _Located.along(series, request.time)
    wants_increments = wants_work and located.all_at_rows
    covered_parts = series.covered_parts
    last_part = covered_parts[-1]
    is_steady = series.steady_from is not None and series.covered[-1] >= series.steady_from
    loop = None
    if request.wants("loop_work") and is_steady:
        loop = Loop(contact, request.modulus, friction, series.parts[last_part].largest_load)
    states = States(friction, request.wants("shear", "slip", "tangential_displacement"))
    sums = _SeriesSums(
        works=np.zeros(len(series.parts)),
        errors=np.zeros(len(series.parts)),
        shares=np.zeros(len(series.parts)),
        step_works=np.zeros(1 + (series.first_steps[-1] if wants_increments else 0)),
        density=np.zeros(len(request.distance)),
    )
    for part_number in _parts_needed(series, located.step):
        part: PathPart = series.parts[part_number]
        is_last = part_number == last_part
        wanted = _WantedOfPart(
            work=wants_work and (wants_increments or part_number in covered_parts),
            work_of_steps=wants_increments,
            density=wants_density and is_last,
        )
        depth_before = depth_of(part.curve)
        for first_row, block in blocks(part, friction, states.curves):
            first_step = series.first_steps[part_number] + first_row
            states.add(block, *located.within(first_step, len(block.rows) - 1))
            sums.shares[part_number] = max(
                sums.shares[part_number], block.largest_slipped_load / part.largest_load
            )
            sums.count(block, wanted.work + wanted.density, depth_before)
            depth_before = depth_of(block.curve)
            sums.add_block(block, part_number, first_step, wanted, request, friction)
            if is_last:
                sums.see_stick_edge(block)
                if loop is not None:
                    loop.add(block)
    rounding_of_parts = sums.rounding_of_parts()
    relative_errors = sums.quadrature_errors() + rounding_of_parts
    increments = np.empty(0)
    if wants_increments:
        revolutions = series.revolutions_beyond(request.time)
        increments = _increments_of_work(sums, located, revolutions * sums.works[last_part])
    snapshot, balance = states.snapshot(request.time, located.back)
    return PathResult(
        snapshot=snapshot,
        balance=balance,
        least_stick_load=sums.least_stick_load,
        slipped_share=float(np.max(sums.shares)),
        works=sums.works[covered_parts] if wants_work else np.full(len(covered_parts), math.nan),
        work_errors=relative_errors[covered_parts] if wants_work else np.zeros(len(covered_parts)),
        density=sums.density if wants_density else np.full(len(sums.density), math.nan),
        density_error=rounding_of_parts[last_part] if wants_density else 0.0,
        loop=loop.value if loop is not None else None,
        spans=(),
        increments=increments,
        counts={
            "rows": len(series.times),
            **sums.counts,
            "curves": len(snapshot.uppermost_pieces) if states.curves else 0,
        },
        full_stick=sums.full_stick,
    )


def _increments_of_work(sums: _SeriesSums, located: _Located, work_beyond: Array) -> Array:
    """Friction work between successive instants of a request, (n,), 0 for the first one [energy per
    thickness].

    Parameters
    ----------
    sums
        with the work of each step of the path
    located
        where the instants are in the path: at ends of steps, all of them
    work_beyond
        (n,) work of the whole cycles by which instants lie beyond the path that was followed
    """
    rows_passed = (located.step + (located.share == 1))[located.back]
    work_so_far = np.cumsum(sums.step_works)[rows_passed]
    work_so_far += work_beyond
    return np.diff(work_so_far, prepend=work_so_far[:1])


def _parts_needed(series: LoadSeries, step: Indices) -> list[int]:
    """Numbers of the parts that hold some steps (n,), ascending, or that the answer covers."""
    first_part, last_part = np.searchsorted(series.first_steps, step[[0, -1]], side="right") - 1
    return sorted({*series.covered_parts, *range(int(first_part), int(last_part) + 1)})


class _WorkOfCycle(NamedTuple):
    """Friction work of a cycle, and its relative error."""

    work: float
    error: float


def _result_of_history(history: History, request: Request) -> PathResult:
    """State of friction at the instants of a request, and friction work, along a curved load path,
    from its spans: ranges of time with slip in one direction or full stick.

    W(x) and the loop of Q over U are those of the last covered cycle.
    """
    contact = request.contact
    last_cycle = history.covered[-1]
    last_spans = history.cycles[last_cycle]
    snapshot = history.snapshot(request.time)
    works_of_cycles = _works_of_cycles(history, request) if request.wants("dissipation") else {}
    integrated_spans = [
        span for cycle_number in works_of_cycles for span in history.cycles[cycle_number]
    ]
    density: Array = np.full(len(request.distance), np.nan)
    density_error = 0.0
    if request.wants("dissipation_density"):
        integrated_spans.extend(last_spans)
        density_parts = pointwise_dissipation(
            contact, request.modulus, last_spans, request.distance
        )
        density = density_parts.total
        largest_density_error = float(np.max(density_parts.error))
        if largest_density_error:
            density_error = largest_density_error / float(np.max(density))
        density_error += error_by_slipped_load("dissipation_density", slipped_share(last_spans))
    loop = None
    # Where W is no closed form, what both routes to it differ by is in its error.
    needs_loop = request.wants("loop_work") or not contact.closed_form
    is_steady = history.steady_from is not None and last_cycle >= history.steady_from
    if works_of_cycles and is_steady and needs_loop:
        loop = LoopWork(0.0, 0.0)
        if works_of_cycles[last_cycle].work:
            loop = closed_integral(contact, request.modulus, last_spans)
    least_stick_load = math.inf
    for span in last_spans:
        times = np.array([span.begin.time, span.end.time])
        load, _ = span.segment.loads(times)
        least_of_span = float(np.min(load - span.slipped_at(times, load)))
        least_stick_load = min(least_stick_load, least_of_span)
    n_slipping = sum(span.direction != 0 for span in integrated_spans)
    return PathResult(
        snapshot=snapshot,
        balance=_balance_of(snapshot),
        least_stick_load=least_stick_load,
        slipped_share=slipped_share(history.spans),
        works=np.array(
            [works_of_cycles[k].work if works_of_cycles else math.nan for k in history.covered]
        ),
        work_errors=np.array(
            [works_of_cycles[k].error if works_of_cycles else 0.0 for k in history.covered]
        ),
        density=density,
        density_error=density_error,
        loop=loop,
        spans=last_spans,
        increments=np.empty(0),
        counts={
            "spans": len(history.spans),
            "pieces_alive": max(len(list(pieces(span.sticking_piece))) for span in history.spans),
            "slip_quadratures": n_slipping,
            "quadrature_nodes": n_slipping * NODES,
        },
        full_stick=len(integrated_spans) - n_slipping,
    )


def _balance_of(snapshot: Snapshot) -> Array:
    """M(P) - Q of the curves of a history, (n,)."""
    slope_of_slip = snapshot.direction * snapshot.friction
    force_error = slope_of_slip * snapshot.slipped - snapshot.force
    edge_load = snapshot.load - snapshot.slipped
    for piece, instants in snapshot.groups:
        assert isinstance(piece, Piece)  # for the type checker: a history has no others
        force_error[instants] += force_on_piece(piece, edge_load[instants])
    return force_error


def _works_of_cycles(history: History, request: Request) -> dict[int, _WorkOfCycle]:
    """Friction work of each covered cycle of a curved load path, with its relative error, by the
    number of the cycle.

    W of a steady ellipse of P and Q comes from formulas that keep their digits, however small the
    slip. Other cycles are integrated over their ranges of slip.
    """
    contact = request.contact
    friction = history.spans[0].friction
    ellipses = None
    if friction > 0 and history.loop is not None:
        ellipses = _ellipses_of_leg(history.loop, friction)
    works_of_cycles: dict[int, _WorkOfCycle] = {}
    for cycle in set(history.covered):
        is_steady = history.steady_from is not None and cycle >= history.steady_from
        if ellipses is not None and is_steady:
            error = float(digits_of_loop(ellipses)[0])
            forward_and_reverse = [part[0] for part in works_over_time(ellipses, contact)]
            work = request.unit_compliance * friction**2 * float(sum(forward_and_reverse))
            works_of_cycles[cycle] = _WorkOfCycle(work, error if error > PROMISED else 0.0)
        else:
            spans = history.cycles[cycle]
            work_parts = global_dissipation(contact, request.modulus, spans)
            error = float(work_parts.error / work_parts.total) if work_parts.error else 0.0
            error += error_by_slipped_load("dissipation", slipped_share(spans))
            works_of_cycles[cycle] = _WorkOfCycle(float(work_parts.total), error)
    return works_of_cycles


def _ellipses_of_leg(segment: LoadSegment, friction: float) -> Ellipses | None:
    """The steady ellipse of P and Q that a segment of the load path describes, with its angles and
    amplitudes, as an array of one; None where the segment is none.
    """
    ellipse = segment.ellipse
    if ellipse is None:
        return None
    mean_load, _ = ellipse.mean
    load_amplitude, force_amplitude = ellipse.amplitude
    return ellipses_of(
        np.array([mean_load]),
        np.array([load_amplitude]),
        np.array([force_amplitude]),
        np.array([ellipse.phase_radians]),
        np.array([friction]),
    )


def _loop_work_of(answer: PathResult) -> float:
    """Closed integral of Q dU; NaN where there is none, or rounding leaves less than two digits of
    it: it is no second route any more.
    """
    if answer.loop is None:
        return math.nan
    work_of_last_cycle = float(answer.works[-1])
    if not work_of_last_cycle:
        return 0.0
    return answer.loop.value if answer.loop.rounding < _TOO_ROUGH * work_of_last_cycle else math.nan


# ------------------------------------------------------------------------------- fields at instants
def _series_of(request: Request, snapshot: Snapshot) -> dict[str, Array]:
    """Values of the answer with one number per instant (n,), or per edge (n, 2), by name: loads,
    displacements, half-widths and edges.

    With bulk stress and tilt also their values and the moments of the tractions; edges are then
    those of the tilted contact. `snapshot` has the friction memory at the instants. NotFoundError
    where no half-width was found for a load.
    """
    contact = request.contact
    family = request.family
    edge_load = snapshot.load - snapshot.slipped
    half_width = _half_width(contact, snapshot.load)
    instants_with_slip = np.flatnonzero(snapshot.slipped)
    stick_half_width = half_width.copy()
    stick_half_width[instants_with_slip] = _half_width(contact, edge_load[instants_with_slip])
    stick_half_width[(edge_load <= 0) & (stick_half_width == 0)] = np.nan
    displacement_over_unit = np.full(len(request.time), np.nan)
    approach = displacement_over_unit
    if request.wants("tangential_displacement"):
        displacement_over_unit = Integrals(contact, np.zeros(1), "shift").over(snapshot)[:, 0]
    if request.wants("normal_approach"):
        approach = request.unit_compliance * contact.log_distance(snapshot.load)
    sides = np.array([-1.0, 1.0])
    contact_edges = half_width[:, None] * sides
    stick_edges = stick_half_width[:, None] * sides
    tangential_load = snapshot.force
    bulk_and_tilt: dict[str, Array] = {}
    if family is not None:
        tangential_load = tangential_load * family.contact.tangential_fraction
        bulk_and_tilt = family.series(request.time, snapshot.load)
        moment_contact = replace(family.contact, rigid="moment")
        shear_moment = Integrals(moment_contact, np.zeros(1), "shift").over(snapshot)[:, 0]
        bulk_and_tilt["shear_moment"] = shear_moment
        contact_edges = bulk_and_tilt.pop("contact_edges")
        half_width = np.diff(contact_edges)[:, 0] / 2
        has_slip_zones = (snapshot.slipped > 0) | np.isnan(stick_half_width)
        shifted_stick_edges = family.contact.centre(edge_load)[:, None] + stick_edges
        stick_edges = np.where(has_slip_zones[:, None], shifted_stick_edges, contact_edges)
        family_approach = bulk_and_tilt.pop("normal_approach")
        if request.wants("normal_approach"):
            approach = family_approach
    return bulk_and_tilt | {
        "normal_load": snapshot.load,
        "tangential_load": tangential_load,
        "tangential_displacement": request.unit_compliance * displacement_over_unit,
        "normal_approach": approach,
        "contact_half_width": half_width,
        "stick_half_width": stick_half_width,
        "contact_edges": contact_edges,
        "stick_edges": stick_edges,
    }


def _half_width(contact: Contact, load: Array) -> Array:
    """a(P), (n,): an inverse that was not found, NaN, must not go on as an answer."""
    half_width = contact.half_width(load)
    numbers_not_found = np.flatnonzero(~np.isfinite(half_width))
    if len(numbers_not_found):
        raise NotFoundError(
            f"no half-width was found for the normal load {float(load[numbers_not_found[0]]):.17g}"
        )
    return half_width


def _grids_of(
    request: Request, snapshot: Snapshot, series: Mapping[str, Array]
) -> tuple[dict[str, NDArray[Any]], dict[str, float]]:
    """Pressure, shear, slip and state of contact at the instants and points of a request, (n, m)
    each, read-only; and the errors of shear and slip by arcs of the memory curve.

    A field that was not asked for is NaN, or open, and takes no room. An arc is a curved part of
    the memory curve, over which is integrated. Tractions are infinite at the tip of a sharp wedge.

    Parameters
    ----------
    snapshot
        the memory curve M(eta) at each instant: the tangential force of the flat punches up to the
        load eta
    series
        half-widths and edges at each instant, by name

    Raises
    ------
    NotFoundError
        Where a value that is due was not found.
    """
    contact = request.contact
    distances = request.distance
    shape = (len(request.time), len(request.number_of_distance))
    fields: dict[str, NDArray[Any]] = {
        name: np.broadcast_to(np.nan, shape) for name in ("pressure", "shear", "slip")
    }
    fields["state"] = np.broadcast_to(np.int8(OPEN), shape)
    fields_at_distances: dict[str, NDArray[Any]] = {}
    shear_integrals = Integrals(contact, distances, "shear")
    slip_integrals = Integrals(contact, distances, "slip")
    if request.wants("pressure"):
        fields_at_distances["pressure"] = _pressure_of(request, snapshot, series)
    if request.wants("shear"):
        fields_at_distances["shear"] = shear_integrals.over(snapshot)
    if request.wants("slip"):
        fields_at_distances["slip"] = request.unit_compliance * slip_integrals.over(snapshot)
    if request.wants("state"):
        fields_at_distances["state"] = _state_of(request, snapshot, series)
    for name, values in fields_at_distances.items():
        _require_finite(name, values, request)
        field_at_points = values.take(request.number_of_distance, axis=1)
        field_at_points.flags.writeable = False
        fields[name] = field_at_points
    return fields, {"shear": shear_integrals.arc_error, "slip": slip_integrals.arc_error}


def _pressure_of(request: Request, snapshot: Snapshot, series: Mapping[str, Array]) -> Array:
    """p at the instants and distances, (n, k)."""
    if request.family is None:
        return request.contact.pressure(request.distance, snapshot.load[:, None])
    contact_centre = np.mean(series["contact_edges"], axis=1)
    half_width = series["contact_half_width"]
    return request.family.contact.pressure_over(request.distance, contact_centre, half_width)


def _state_of(
    request: Request, snapshot: Snapshot, series: Mapping[str, Array]
) -> NDArray[np.int8]:
    """State of contact, open, stick or slip, at the instants of a `snapshot` of the friction memory
    and at the distances of a request, (n, k).

    Edges of contact and of stick, (n, 2), are in `series`. A point in contact sticks between the
    stick edges and slips outside of them.
    """
    contact = request.contact
    distances = request.distance
    # Where the ends slip opposite ways a direction is that of one side.
    slip_sign = contact.sense(distances).astype(int) if isinstance(contact, OppositeSlip) else 1
    states_by_direction = np.array((SLIP_REVERSE, STICK, SLIP_FORWARD), dtype=np.int8)
    state_of_slip = states_by_direction[snapshot.direction[:, None] * slip_sign + 1]
    is_stuck = between(series["stick_edges"], distances)
    is_in_contact = between(series["contact_edges"], distances) & (snapshot.load[:, None] > 0)
    contact_state = np.where(is_stuck, np.int8(STICK), state_of_slip)
    return np.where(is_in_contact, contact_state, np.int8(OPEN))


def _require_finite(name: str, values: NDArray[Any], request: Request) -> None:
    """NotFoundError where a value (n, k) of a field is not a number."""
    is_finite = np.isfinite(values)
    if name in ("pressure", "shear"):
        is_finite |= np.isinf(values) & (request.distance == 0)
    if np.all(is_finite):
        return
    instants, points = np.nonzero(~is_finite)
    x = request.distance[points[0]]
    time = request.time[instants[0]]
    raise NotFoundError(f"no {name} was found at |x| = {x:.17g}, time {time:.17g}")


# ---------------------------------------------------------------- what a solution says of itself
def _errors(
    request: Request,
    path_answer: PathResult,
    loads_and_edges: dict[str, Array],
    fields: dict[str, NDArray[Any]],
    arc_errors: Mapping[str, float],
    loop_work: float,
) -> dict[str, float]:
    """Estimated relative errors of what was asked for, by name, each over the largest p, f p, slip,
    U, W(x) or W. Closed forms promise round-off and have no entry.

    "cycle_dissipation" is the error of the worst cycle, where it is above that of the last.

    Parameters
    ----------
    path_answer
        states at the instants, and friction work of the cycles
    loads_and_edges, fields
        the answer's values over time, and its fields, by name
    arc_errors
        errors of the integrals of shear and slip over arcs, curved parts of the memory curve. That
        is M(eta), the tangential force of the flat punches up to the load eta
    loop_work
        closed integral of Q dU of the last cycle

    Raises
    ------
    NotFoundError
        For an error that is not a number.
    """
    contact = request.contact
    errors = {"dissipation_density": path_answer.density_error}
    if request.wants("pressure", *arc_errors):
        errors |= errors_of_sums(
            contact, _sums_of(request, path_answer.snapshot, loads_and_edges, fields, arc_errors)
        )
    errors["slip"] = errors.get("slip", 0.0) + error_by_slipped_load(
        "slip", path_answer.slipped_share
    )
    if request.wants("tangential_displacement"):
        errors["tangential_displacement"] = error_of_displacement(
            path_answer.snapshot.friction,
            contact.log_distance(loads_and_edges["normal_load"]),
            loads_and_edges["tangential_displacement"] / request.unit_compliance,
        )
    if request.wants("dissipation"):
        error_of_kernel, difference = error_of_work(
            contact,
            path_answer.spans,
            float(path_answer.works[-1]) / request.unit_compliance,
            _loop_integral_of(request, path_answer, loop_work),
        )
        error_of_last = float(path_answer.work_errors[-1])
        loop_error = error_of_last + difference
        errors["loop_work"] = loop_error if loop_error > PROMISED else 0.0
        errors["dissipation"] = error_of_last + error_of_kernel
        errors["dissipation_density"] += errors["dissipation"]
        error_of_worst_cycle = float(np.max(path_answer.work_errors))
        if error_of_worst_cycle > errors["dissipation"]:
            errors["cycle_dissipation"] = error_of_worst_cycle
    allowed_names = (
        *request.fields,
        "cycle_dissipation",
        *(f"{name} at the edge" for name in request.fields),
    )
    return {name: error for name, error in errors.items() if error and name in allowed_names}


def _loop_integral_of(request: Request, path_answer: PathResult, loop_work: float) -> LoopIntegral:
    """The closed integral of Q dU, over A/pi."""
    roundoff = path_answer.loop.rounding if path_answer.loop is not None else 0.0
    return LoopIntegral(loop_work / request.unit_compliance, roundoff / request.unit_compliance)


def _sums_of(
    request: Request,
    snapshot: Snapshot,
    loads_and_edges: Mapping[str, Array],
    fields: Mapping[str, NDArray[Any]],
    arc_errors: Mapping[str, float],
) -> Sums:
    """The sums of kernels that pressure, shear and slip are, at a sample of instants.

    Parameters
    ----------
    snapshot
        the memory curve M(eta) at each instant: the tangential force of the flat punches up to the
        load eta
    loads_and_edges
        half-widths of contact and of stick at each instant, by name
    fields
        the answer's slip, NaN where it was not asked for
    arc_errors
        errors of the integrals of shear and slip over arcs of the memory curve
    """
    instants = np.unique(np.linspace(0, len(snapshot.load) - 1, _INSTANTS).astype(int))
    slip = np.abs(fields["slip"])
    return Sums(
        distance=request.distance,
        load=np.unique(np.append(snapshot.load[instants], np.max(snapshot.load))),
        half_widths=loads_and_edges["contact_half_width"],
        stick_half_widths=loads_and_edges["stick_half_width"],
        friction=snapshot.friction,
        largest_slip=float(np.max(slip, where=np.isfinite(slip), initial=0.0))
        / request.unit_compliance,
        n_kernels=2 * _most_pieces(snapshot, instants) + 2,
        arc_errors=arc_errors,
    )


def _most_pieces(snapshot: Snapshot, instants: Indices) -> int:
    """Of how many pieces a memory curve of some instants is at most."""
    curves = [snapshot.uppermost_pieces[k] for k in snapshot.piece_number[instants]]
    return max((len(list(pieces(curve))) for curve in curves), default=0)


def _errors_of_neglect(question: Question, family: OneCurve | None) -> dict[str, float]:
    """What loads that were left out of the memory of friction may do to the fields of friction."""
    if family is None:
        return {}
    share = sum(family.neglected.values())
    if share <= PROMISED:
        return {}
    return dict.fromkeys(sorted(question.fields & _OF_FRICTION), share)


def _neglected_loads(family: OneCurve | None) -> Iterator[str]:
    """A sentence for each load that is below rounding and was left out, so that the memory of
    friction is one curve.
    """
    for name, share in (family.neglected if family is not None else {}).items():
        size = f"{share:.1e} of what makes an edge of contact slip"
        yield f"{name}: {size} is below rounding and was left out of the memory of friction"


def _notes_of_path(
    question: Question, path: LoadSeries | History, rows: int, rows_left_out: int
) -> Iterator[str]:
    """Sentences for the notes of an answer: that the last cycle is not steady, and that rows of a
    measured record were left out.

    The answer is given at `rows` of them, without `rows_left_out`.
    """
    is_steady = path.steady_from is not None and path.covered[-1] >= path.steady_from
    if question.wants("dissipation") and path.period is not None and not is_steady:
        yield (
            "the last cycle is not steady: no closed integral of Q dU to compare the dissipation"
            " with"
        )
    if rows_left_out:
        yield (
            f"with pointwise fields the answer is given at {rows} rows, {rows_left_out} were left"
            " out; `time` chooses others"
        )


def _notes_of_errors(errors: Mapping[str, float]) -> Iterator[str]:
    """A sentence for each error that is large."""
    for name, error in errors.items():
        if error > _DOUBTFUL and "edge" not in name:
            reference = "the largest value"
            if name in ("dissipation", "loop_work"):
                reference = "it"
            elif name == "cycle_dissipation":
                reference = "W of a cycle before the last"
            error_words = f"an error of {error:.1e} of {reference}"
            yield f"{name}: quadratures and rounding may have left {error_words}"


def _ending_of(path: LoadSeries | History) -> tuple[str, str]:
    """How a path ended, in a word and in a sentence."""
    if path.period is None:
        return "end of path", "the path was followed to its end"
    if path.steady_from is None:
        return "end of path", f"no steady cycle among the first {len(path.cycles)}"
    return "steady", f"cycle {path.steady_from + 1} ends in the state it started from"


def _skipped_of(
    scene: Scene, path: LoadSeries | History, answer: PathResult
) -> dict[str, tuple[int, str]]:
    """What was not computed because it needs not be, by name: how often and why. Copies of a steady
    cycle, and integrals over time in full stick.
    """
    skipped_work = {}
    copies = max(scene.cycles, len(path.covered)) - len(path.cycles)
    if path.repeats and path.steady_from is not None and copies > 0:
        skipped_work["cycles"] = (
            copies,
            f"copies of cycle {path.steady_from + 1}, which is steady",
        )
    if answer.full_stick:
        skipped_work["quadratures"] = (answer.full_stick, "full stick: nothing slips")
    return skipped_work


def _permanent_stick(contact: Contact, answer: PathResult, largest_load: float) -> dict[str, Any]:
    """Half-width of the zone that sticks all through the last cycle, and its two edges for an
    unsymmetric contact; NaN where nothing does.

    The zone is the contact under the least load P_c at the stick edge. `largest_load` is the
    largest P of the path.
    """
    # A P_c that is no more than the last digits of P counts as 0: nothing sticks at that instant,
    # not even a flat face, which has its half-width without any load.
    least_load = (
        answer.least_stick_load if answer.least_stick_load > LAST_DIGITS * largest_load else 0.0
    )
    has_stick = least_load > 0
    half_width = float(contact.half_width(least_load)) if has_stick else math.nan
    values: dict[str, Any] = {"permanent_stick_half_width": half_width}
    if isinstance(contact, TiltedProfile):
        edges = contact.interval(least_load) if has_stick else np.full(2, math.nan)
        values["permanent_stick_edges"] = edges
    return values


def _admissibility(
    request: Request, answer: PathResult, grids: Mapping[str, NDArray[Any]]
) -> dict[str, Array]:
    """Checks of the laws of contact at each instant, by name, (n,) each, 0 where satisfied.

        tangential_balance    |M(P) - Q| / (f times the largest P)
        cone                  the largest |q| - f p, over f times the largest p

    The memory curve M(eta) is the tangential force carried up to the load eta, M(P) that of the
    whole contact. The Coulomb limit ("cone") is checked where `grids` have both tractions.
    """
    friction = answer.snapshot.friction
    largest_limit = friction * float(np.max(answer.snapshot.load))
    checks = {"tangential_balance": freeze(np.abs(answer.balance) / max(largest_limit, _TINY))}
    if request.wants("pressure") and request.wants("shear"):
        pressure = grids["pressure"]
        # At the tip of a wedge p is infinite: no q is outside the cone there, and none is a measure
        # of the others.
        with np.errstate(invalid="ignore"):
            excess = np.abs(grids["shear"]) - friction * pressure
        largest_excess = np.fmax.reduce(excess, axis=1, initial=0.0)
        largest_pressure = float(np.max(pressure, where=np.isfinite(pressure), initial=0.0))
        checks["cone"] = freeze(largest_excess / max(friction * largest_pressure, _TINY))
    return checks
