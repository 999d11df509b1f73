"""Before anything is solved: whether a load path has a solution (|Q| <= f P, P >= 0 all along), and
the size of the contact.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from reports.charts.templating import in_template
from reports.comparison.work_of_loads import bulk_strains_per_stress
from reports.record_parts import sliding_rows_in_words
from reports.units import load_unit, number, units
from scenes import (
    Block,
    ContactSolution,
    Cylinder,
    EllipseLoad,
    Hertz,
    InadmissibleLoadError,
    InputError,
    LoadSegment,
    Pad,
    PolygonLoad,
    ProfileDataError,
    Scene,
    ShoulderedPad,
    StraightSegment,
    TimeSeriesLoad,
    TShape,
    sampled_times,
)
from scenes.array_types import Array
from scenes.unit_words import UNITS

# |Q| = f P is allowed (the stick zone has just closed): rounding of the loads must not forbid it.
_ROUND_OFF_SHARE = 1e-12
_N_SAMPLES = 513
# Of the largest P: below this share Q beyond f P is taken for noise of the sensors.
_LARGEST_NOISE_SHARE = 0.05
# Rows of a record that are looked at together.
_ROWS_PER_BLOCK = 100_000
# Beyond these shares linear elasticity and half-planes mean little: hardened steel yields long
# before p0 = E*/10, and at a slope of 0.3 the parabola is 2 % off the circle that it stands for.
_LARGEST_STRAIN = 0.1
_LARGEST_SLOPE = 0.3
# Pa. What is softer than the first and no rubber (by Poisson's ratio) may be in GPa; nothing is
# stiffer than diamond.
_SOFT_MODULUS = 1e9
_POISSON_RATIO_OF_RUBBER = 0.45
_MODULUS_OF_STEEL = 210e9
_MODULUS_OF_DIAMOND = 1.3e12
# Half-width of a contact by theory over that of the narrower face beyond which there is no room for
# it: theory is some per cent off for blocks, and thin layers have contacts several times narrower.
_LARGEST_SHARE_OF_FACE = 1.1
_LARGEST_SHARE_OF_LAYER = 10.0
# No pair of solids in air has more friction than clean indium or gold, about 2 to 3.
_LARGEST_FRICTION = 3.0
_SYMBOL_OF_RADIUS = {"radius": "R", "tip_radius": "R", "inner_radius": "R1", "outer_radius": "R2"}
_KEYS_OF_HALF_LENGTHS = ("flat_half_length", "tip_half_length", "inner_half_length")


@dataclass(frozen=True)
class NearestToSliding:
    """How near a load path comes to gross sliding."""

    # largest |Q|/(f P), 1 being gross sliding; 0 for a frictionless path without Q; infinite where
    # it separates
    ratio: float
    # where that is, `part` being "initial loading", "cycle", or "path" if nothing repeats
    part: str
    time: float
    normal_load: float
    tangential_load: float


def nearest_to_sliding(scene: Scene) -> NearestToSliding:
    """How near the loads come to gross sliding: the largest |Q|/(f P) of the initial loading and
    one cycle, with its time, its loads and the part of the path.

    The part is "initial loading", "cycle", or "path" where nothing repeats. The ratio is searched
    on samples of each load segment, then twice on closer samples around the largest.

    >>> from scenes import load_scene
    >>> round(nearest_to_sliding(load_scene("cattaneo-mindlin")).ratio, 12)
    0.6
    """
    # Load segments among which the ratio can be largest, each with its part of the path.
    named_segments = _deciding_segments(scene)
    friction_coefficient = scene.friction.coefficient

    def highest_ratio_and_time(segment: LoadSegment) -> tuple[float, float]:
        """Largest |Q|/(f P) on a segment, and its time."""
        return _highest_value_and_time(
            segment, lambda time: _load_ratio(*segment.loads(time), friction_coefficient)
        )

    ratios_and_times = [highest_ratio_and_time(segment) for segment, _ in named_segments]
    segment_number = int(np.argmax([ratio for ratio, _ in ratios_and_times]))
    ratio, time = ratios_and_times[segment_number]
    segment, part_of_path = named_segments[segment_number]
    normal_load, tangential_load = segment.loads(time)
    return NearestToSliding(ratio, part_of_path, time, float(normal_load), float(tangential_load))


def _deciding_segments(scene: Scene) -> list[tuple[LoadSegment, str]]:
    """The load segments among which |Q|/(f P) can be largest, each with the part of the path that
    it belongs to: "initial loading", "cycle", or "path" where nothing repeats.

    Of a load path these are all segments; of a record of loads (`TimeSeriesLoad`), which may have
    millions of rows, a few lines between neighbouring rows.
    """
    load_history = scene.load
    if isinstance(load_history, TimeSeriesLoad):
        return list(_deciding_lines_of_record(load_history, scene.friction.coefficient))
    path = load_history.path()
    part_of_loading = "initial loading" if path.cycle else "path"
    segments_before_cycle = [(segment, part_of_loading) for segment in path.initial_loading]
    return segments_before_cycle + [(segment, "cycle") for segment in path.cycle]


def _deciding_lines_of_record(
    load_record: TimeSeriesLoad, friction_coefficient: float
) -> Iterator[tuple[LoadSegment, str]]:
    """Lines between neighbouring rows of a record of loads, among which |Q|/(f P) can be largest,
    each with its part of the path. Of each block of 100,000 rows these are the line with the
    largest ratio and that with the largest P.

    The first line is "initial loading" and all others are "cycle" where the record repeats; else
    each is "path". `load_record` has rows of time, P and Q. `friction_coefficient` is f.
    """
    part_of_first_line = "initial loading" if load_record.repeats else "path"
    part_after_first_line = "cycle" if load_record.repeats else "path"
    rows = load_record.series()  # (n, 3) time, P, Q
    for first_row in range(0, len(rows) - 1, _ROWS_PER_BLOCK):
        block = rows[first_row : first_row + _ROWS_PER_BLOCK + 1]
        # loads at the start and at the end of the line between two rows, (n, 2)
        normal_load = np.stack([block[:-1, 1], block[1:, 1]], axis=1)
        tangential_load = np.stack([block[:-1, 2], block[1:, 2]], axis=1)
        # The larger |Q|/(f P) of both ends.
        ratio = np.max(_load_ratio(normal_load, tangential_load, friction_coefficient), axis=1)
        line_of_highest_ratio = np.argmax(ratio)
        line_of_highest_p = np.argmax(np.max(normal_load, axis=1))
        for line in np.unique([line_of_highest_ratio, line_of_highest_p]).tolist():
            start_time, start_p, start_q = block[line].tolist()
            end_time, end_p, end_q = block[line + 1].tolist()
            segment = StraightSegment(start_time, end_time, (start_p, start_q), (end_p, end_q))
            is_first_line = first_row + line == 0
            yield segment, part_of_first_line if is_first_line else part_after_first_line


def require_admissible(scene: Scene, source: str) -> None:
    """Check that P is nowhere negative, and |Q| at most f P, along the path of a scene.

    Loads that follow from prescribed displacements (`load.is_driven`) are always admissible.

    Raises
    ------
    InputError
        Naming `source` (the scene's name or file), the instant, the loads and the rule, and where
        it is known what to write instead.
    """
    if scene.load.is_driven:
        return
    try:
        _require_admissible_loads(scene)
    except InadmissibleLoadError as fault:
        # the loads may count compression as negative
        if _has_only_tension(scene):
            sign_in_words = (
                "never positive" if largest_normal_load(scene) <= 0 else "negative but for noise"
            )
            raise InputError(
                f"{source}: load: P is {sign_in_words}; it is a compression, positive where the"
                " bodies are pressed together, so turn its sign if compression is negative in this"
                " record: sign = {P = -1} beside the file"
            ) from fault

        # What to write instead: a straight initial loading, or fewer rows of a record.
        hint = ""
        if isinstance(scene.load, EllipseLoad) and scene.load.initial_loading == "parabola":
            with suppress(InadmissibleLoadError):  # the parabola alone is at fault
                _require_admissible_loads(scene.vary(load={"initial_loading": "straight"}))
                hint = '; or write load.initial_loading = "straight", which is admissible'
        if isinstance(scene.load, TimeSeriesLoad):
            # `worst_time`: when the loads are inadmissible
            hint = _hint_on_rows_to_leave_out(
                scene.load, scene.friction.coefficient, fault.worst_time
            )
        raise InputError(f"{source}: {fault}{hint}") from fault


def _has_only_tension(scene: Scene) -> bool:
    """Whether P is negative all along, but for noise of a sensor without a load."""
    highest_load = largest_normal_load(scene)
    if highest_load <= 0:
        return True
    return (
        isinstance(scene.load, TimeSeriesLoad)
        and -float(np.min(scene.load.used_rows().values[:, 1])) * _LARGEST_NOISE_SHARE
        > highest_load
    )


def _hint_on_rows_to_leave_out(
    load_record: TimeSeriesLoad, friction_coefficient: float, time: float
) -> str:
    """The end of an error message on a record of loads that slides or lifts off at `time`: the
    number of that row, and the keys of the scene that leave such rows out.

    Where only rows with less than a twentieth of the largest P slide, that key is a least normal
    load, below which sensors give noise; not for rows that repeat, nor with bulk stress or tilt.
    Else it is one for rows that slide, or another start or end.

    Parameters
    ----------
    load_record
        a record of loads: `rows` holds time, P and Q; `repeats`: the rows are one cycle;
        `has_bulk_or_tilt`: it has bulk stress, tilt or moment too; `least_normal_load`: the P below
        which rows are noise, None where it is not stated
    friction_coefficient
        coefficient f
    time
        of the row at fault
    """
    rows = load_record.rows.values  # time, P, Q in its columns
    # Numbers, from 0, of the first row used and of the one after the last.
    first_row, row_beyond = load_record.row_bounds()
    row = first_row + int(np.argmax(np.append(rows[first_row:row_beyond, 0] >= time, True)))
    row = min(row, row_beyond - 1)

    # Rows that slide, with |Q| > f P, and the largest P of these.
    used_rows = rows[first_row:row_beyond]
    is_sliding = np.abs(used_rows[:, 2]) > friction_coefficient * used_rows[:, 1]
    row_in_words = f"; that is row {row + 1:,} of {len(rows):,}"
    largest_sliding_normal_load = float(np.max(used_rows[is_sliding, 1], initial=0.0))
    largest_normal_load = float(np.max(used_rows[:, 1]))
    # _LARGEST_NOISE_SHARE: 0.05 of the largest P
    if (
        load_record.least_normal_load is None
        and not load_record.repeats
        and not load_record.has_bulk_or_tilt
        and largest_sliding_normal_load < _LARGEST_NOISE_SHARE * largest_normal_load
    ):
        # Twice the largest P of these rows, rounded up to two digits: noise does not end there.
        exact_least_normal_load = max(
            2 * largest_sliding_normal_load, _LARGEST_NOISE_SHARE / 50 * largest_normal_load
        )
        unit_of_second_digit = 10.0 ** (np.floor(np.log10(exact_least_normal_load)) - 1)
        suggested_least_load = (
            float(np.floor(exact_least_normal_load / unit_of_second_digit) + 1)
            * unit_of_second_digit
        )
        return (
            f"{row_in_words}. Rows of so little load are noise where it is: write"
            f" load.least_normal_load = {suggested_least_load:.6g}"
        )

    # A sentence on the keys that leave out rows that slide; "" where none helps.
    if advice_on_sliding := sliding_rows_in_words(load_record, friction_coefficient):
        return f"{row_in_words}. {advice_on_sliding}"
    return (
        f"{row_in_words}. To leave rows out, write load.start or load.end: a time, or"
        f" {{row = {row + 2}}}"
    )


def _require_admissible_loads(scene: Scene) -> None:
    """Follow the loads of a scene from its start; InadmissibleLoadError where P is negative or |Q|
    exceeds f P.
    """
    from semi_analytic.history import require_admissible
    from semi_analytic.load_series import require_admissible_rows

    if isinstance(scene.load, TimeSeriesLoad):
        return require_admissible_rows(scene.load.series(), scene.friction.coefficient)
    path = scene.load.path()
    return require_admissible([*path.initial_loading, *path.cycle], scene.friction.coefficient)


def largest_normal_load(scene: Scene) -> float:
    """Largest P of the path [force per thickness]."""
    return _largest_load_and_time(scene)[0]


def _largest_load_and_time(scene: Scene) -> tuple[float, float]:
    """Largest P of the path and when that is."""

    def largest_of(segment: LoadSegment) -> tuple[float, float]:
        return _highest_value_and_time(segment, lambda time: segment.loads(time)[0])

    return max(largest_of(segment) for segment, _ in _deciding_segments(scene))


def _load_ratio(normal_load: Array, tangential_load: Array, friction_coefficient: float) -> Array:
    """|Q|/(f P) at the samples of load segments, all (..., n): infinite at P < 0, and where f P is
    0 but Q is not; 0 elsewhere at Q = 0.

    Q counts as 0 below 1e-12 of the largest f |P| of its segment.

    Parameters
    ----------
    normal_load, tangential_load
        P and Q (..., n), a row for each segment [force per thickness]
    friction_coefficient
        coefficient f
    """
    magnitude_of_q = np.abs(tangential_load)
    # Q that is zero but for the round-off error of its own segment is zero.
    magnitude_of_q = np.where(
        magnitude_of_q
        <= _ROUND_OFF_SHARE
        * friction_coefficient
        * np.max(np.abs(normal_load), axis=-1, keepdims=True),
        0.0,
        magnitude_of_q,
    )
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = magnitude_of_q / (friction_coefficient * normal_load)
    return np.asarray(np.where(normal_load < 0, np.inf, np.where(magnitude_of_q == 0, 0.0, ratio)))


def _highest_value_and_time(
    segment: LoadSegment, value_at: Callable[[Array], Array]
) -> tuple[float, float]:
    """The largest value of a function of time on one load segment, and its time. It is the largest
    of 513 samples or more; then, two times over, that of 513 closer samples between the neighbours
    of the largest. On a straight segment its two ends alone are samples.

    `value_at` gives the values at times (n,).
    """
    # _N_SAMPLES: 513 times; `sampled_times`: at least so many, of a straight segment both ends
    times = sampled_times(segment, _N_SAMPLES)
    for _ in range(3):
        values = value_at(times)
        index_of_highest_value = int(np.argmax(values))
        highest_value = float(values[index_of_highest_value])
        time_of_highest_value = float(times[index_of_highest_value])
        # At an end of the samples, or infinite: closer samples add nothing.
        if not np.isfinite(highest_value) or index_of_highest_value in (0, len(times) - 1):
            break
        times = np.linspace(
            times[index_of_highest_value - 1], times[index_of_highest_value + 1], _N_SAMPLES
        )
    return highest_value, time_of_highest_value


_NO_THEORY_OF_CURVED_FACES = (
    "how far a pad or a cylinder moves under its loads is known to finite elements alone; a block"
    " or a t_shape has theory"
)


@dataclass(frozen=True)
class EngineRefusals:
    """Why each engine does not take a scene; "" for one that does."""

    refusal_of_theory: str
    refusal_of_elements: str
    # how it was found out that bodies have room for the contact; "" where nothing was estimated
    size_in_words: str = ""
    # whether each engine finds loads of its own, under a displacement that is prescribed
    finds_own_loads: bool = False

    @property
    def reasons(self) -> dict[str, str]:
        """The reasons for JSON, by engine: "" for one that takes the scene; and how the size of the
        contact was estimated.
        """
        return {
            "half_plane": self.refusal_of_theory,
            "finite_elements": self.refusal_of_elements,
            "room": self.size_in_words,
        }

    def in_words(self, source: str) -> str:
        """Which of theory and finite elements solves the scene, which does not and why, and the
        command that works for it. "" where both solve it.

        `refusal_of_theory` and `refusal_of_elements` are the reasons why one does not, "" where it
        does. `finds_own_loads`: a displacement is prescribed, so that each computes loads of its
        own. `source` is the scene's name in the command.
        """
        if self.finds_own_loads:
            return (
                "Under a prescribed displacement each engine finds loads of its own, and no"
                f" tolerance judges the difference: `halfplane run {source}` shows both, `halfplane"
                f" exact {source}` corrected theory alone, `halfplane fe {source}` finite elements,"
                " where the bodies do not part"
            )
        if self.refusal_of_theory:
            return (
                f"Finite elements alone take this scene, `halfplane fe {source}`; half-plane theory"
                f" does not: {self.refusal_of_theory}"
            )
        if self.refusal_of_elements:
            return (
                f"Half-plane theory alone takes this scene, `halfplane exact {source}`; finite"
                f" elements do not: {self.refusal_of_elements}"
            )
        return ""


def engine_refusals(scene: Scene, source: str, *, finite_elements: bool = True) -> EngineRefusals:
    """Which of theory and finite elements can solve a scene whose load path is admissible: for each
    the reason why it refuses, "" where it accepts.

    Parameters
    ----------
    scene
        `load.is_driven`: a displacement is prescribed instead of Q; `bodies.faces_are_true`: a
        face is modelled with its curve
    source
        name of the scene in messages
    finite_elements
        False: finite elements are asked only where theory refuses; their reason is "" then too

    Returns
    -------
    EngineRefusals
        Reason of theory, reason of finite elements, a sentence on how the size of the contact was
        estimated ("" where it was not), and whether each computes loads of its own.

    Raises
    ------
    InputError
        One sentence, for what no engine answers: rows of a table that do not define the profile,
        real bodies that finite elements refuse (theory replaces them by half-planes), a contact
        wider than the narrower face of the bodies, and what both engines refuse.
    """
    # Under prescribed displacements each engine finds loads of its own. Theory then needs the
    # responses of flat faces.
    if scene.load.is_driven:
        if scene.bodies.faces_are_true:
            # _NO_THEORY_OF_CURVED_FACES: the reason, as a sentence
            return EngineRefusals(_NO_THEORY_OF_CURVED_FACES, "")
        return EngineRefusals("", "", finds_own_loads=True)

    # Theory first, then whether the contact fits on bodies of a finite size, then finite elements.
    reason_of_theory = _refusal_of_theory(scene, source)
    if not reason_of_theory and not scene.bodies.half_planes:
        _require_face_wider_than_contact(scene, source)
    if not finite_elements and not reason_of_theory:
        return EngineRefusals("", "")
    reason_of_elements, size_in_words = _refusal_of_elements(scene, source, reason_of_theory)
    return EngineRefusals(reason_of_theory, reason_of_elements, size_in_words)


def _refusal_of_theory(scene: Scene, source: str) -> str:
    """Why half-plane theory does not solve a scene, in words; "" where it does.

    An `unsymmetric` scene has bulk stress, tilt or an unsymmetric profile. Of others theory needs
    the contact half-width under the largest P.

    Raises
    ------
    InputError
        Naming `source`, for rows of a profile that neither theory nor finite elements can use.
    """
    from semi_analytic.profiles import contact_of

    try:
        if scene.unsymmetric:
            from semi_analytic.solution import require_followable

            require_followable(scene)
        else:
            contact_of(scene.profile, scene.material).half_width(largest_normal_load(scene))
    except InputError as fault:
        if isinstance(fault, ProfileDataError):
            raise InputError(f"{source}: half-plane theory refuses it: {fault}") from fault
        return str(fault)
    return ""


def _refusal_of_elements(scene: Scene, source: str, reason_of_theory: str) -> tuple[str, str]:
    """Why finite elements do not solve a scene ("" where they do); and a sentence on how the size
    of its contact was estimated ("" where it was not).

    Raises
    ------
    InputError
        Naming `source`, where no engine is left: theory refuses too, as `reason_of_theory` states,
        or replaces bodies of a finite size by half-planes.
    """
    import halfplane_fe

    try:
        # Refuses the scene (InputError), or estimates the size of its contact; None: no estimate
        # needed.
        estimate = halfplane_fe.require_solvable(scene)
    except InputError as fault:
        if reason_of_theory:
            raise InputError(
                f"{source}: {fault}; half-plane theory refuses the scene too: {reason_of_theory}"
            ) from fault
        if not scene.bodies.half_planes:
            raise InputError(
                f"{source}: {fault}; `halfplane exact {source}` gives half-plane theory's"
                " answer, which knows no bodies"
            ) from fault
        return str(fault), ""
    return "", "" if estimate is None else estimate.in_words


def _require_face_wider_than_contact(scene: Scene, source: str) -> None:
    """Refuse a scene whose contact at the largest load, by half-plane theory, is more than 1.1
    times as wide as the narrower face of the two bodies (InputError); nothing is meshed.

    On a layer, a body thinner than three quarters of its face, the contact is narrower than by
    theory, so the limit is 10 there; finite elements check narrower contacts later. `source` names
    the scene in the message.
    """
    from halfplane_fe.supports import least_face_half_width

    half_width_of_face = float(least_face_half_width(scene))
    # A body without a height is a half-plane or cylinder.
    heights = [
        float(getattr(body, "height", np.inf)) for body in (scene.bodies.lower, scene.bodies.upper)
    ]
    is_layer = min(heights) < 1.5 * half_width_of_face
    # _LARGEST_SHARE_OF_LAYER, _LARGEST_SHARE_OF_FACE: 10 and 1.1, of the half-width of the face
    largest_ratio = _LARGEST_SHARE_OF_LAYER if is_layer else _LARGEST_SHARE_OF_FACE

    # The contact at the largest load: P, half-width, pressure.
    contact = largest_contact(scene, source)
    if contact.half_width <= largest_ratio * half_width_of_face:
        return

    # The message, with remarks on input that looks like a mistake.
    unit_of_force, unit_of_length, unit_of_stress = units(scene)
    remarks_in_words = "".join(f"{remark} " for remark in remarks_on_input(scene, contact))
    raise InputError(
        f"{source}: {remarks_in_words}Check the units first: loads are in {unit_of_force} per"
        f" {unit_of_length} of thickness, E is in {unit_of_stress}, sizes are in {unit_of_length}."
        " bodies: the contact at the largest load reaches past the end of the narrower face, at |x|"
        f" = {half_width_of_face:.6g}: by half-plane theory P = {contact.normal_load:.6g} gives the"
        f" half-width {contact.half_width:.4g}, which is"
        f" {contact.half_width / half_width_of_face:.3g} times that. If the units are right, make"
        f" the bodies wider, or the load less; `halfplane exact {source}` gives half-plane theory's"
        " answer, which knows no bodies"
    )


@dataclass(frozen=True)
class LargestContact:
    """The contact at the largest normal load of the path, by half-plane theory."""

    normal_load: float  # P [force per thickness]
    half_width: float  # a [length]
    peak_pressure: float  # p0 [stress]; infinite at the tip of a sharp wedge
    strain: float  # p0/E*; the mean pressure over E* where p0 is infinite
    edge_slope: float  # h'(a), which is a/R for Hertz
    # a over the radii of the profile, its half-length over a, sizes of the bodies over a
    ratios: dict[str, float]


def largest_contact(scene: Scene, source: str) -> LargestContact:
    """The contact at the largest P of a scene, by half-plane theory: half-width, peak pressure p0,
    strain p0/E*, largest slope of the gap at its edges, and ratios of sizes to the half-width.

    Neither the history nor bulk stress matters: they do not change the pressure. Where p0 is
    infinite, at the tip of a wedge, the strain is the mean pressure over E*. `source` names the
    scene in messages.

    Raises
    ------
    InputError
        Where theory can't solve the profile under that load: a table or function that ends within
        the contact, a profile with which the contact would split, a tilt of a profile that bends
        down somewhere.
    """
    from semi_analytic.elasticity import composite_modulus

    largest_normal_load, time = _largest_load_and_time(scene)
    # x of both edges, and the pressure as a function of x; None where the quick formula for convex
    # profiles does not hold.
    contact = _contact_of_convex_profile(scene, largest_normal_load, time)
    if contact is None:
        contact = _contact_by_theory(scene, largest_normal_load, time, source)
    half_width = (contact.right_edge - contact.left_edge) / 2
    peak_pressure = _peak_pressure(contact, scene)
    typical_pressure = peak_pressure
    if not np.isfinite(peak_pressure):  # at the tip of a wedge: take the mean pressure
        typical_pressure = largest_normal_load / (2 * half_width)

    # Slope of the gap at both edges: differences of its height (2, 2) over 2e-6 of their x.
    contact_edges = np.array([contact.left_edge, contact.right_edge])
    heights = scene.profile.height(contact_edges[:, None] * np.array([1 - 1e-6, 1 + 1e-6]))
    slopes = (heights[:, 1] - heights[:, 0]) / (2e-6 * np.abs(contact_edges))
    return LargestContact(
        normal_load=largest_normal_load,
        half_width=half_width,
        peak_pressure=peak_pressure,
        strain=typical_pressure / composite_modulus(scene.material),
        edge_slope=float(np.max(slopes)),
        ratios=_size_ratios(scene, half_width),
    )


def _peak_pressure(contact: _Contact, scene: Scene) -> float:
    """Largest pressure of a contact [stress], among points x that are dense at the edges and around
    the largest; infinite at the tip of a wedge.

    `contact` holds x of both edges [length], and `pressure` as a function of x (n,).
    `profile.kinks` are the distances from x = 0 at which the curvature of the profile jumps.
    """
    # A flat with rounded corners has its peak near the edges.
    half_width = (contact.right_edge - contact.left_edge) / 2
    middle_x = (contact.left_edge + contact.right_edge) / 2
    x = middle_x + half_width * np.sin(np.linspace(-np.pi / 2, np.pi / 2, 257))
    kinks = np.array([*scene.profile.kinks, *(-kink for kink in scene.profile.kinks)])
    x = np.union1d(x, kinks[(contact.left_edge < kinks) & (kinks < contact.right_edge)])
    pressure = contact.pressure(x)

    # Closer points between the neighbours of the largest.
    peak_index = int(np.argmax(pressure))
    x_around_peak = np.linspace(x[max(peak_index - 1, 0)], x[min(peak_index + 1, len(x) - 1)], 65)
    return max(float(pressure[peak_index]), float(np.max(contact.pressure(x_around_peak))))


@dataclass(frozen=True)
class _Contact:
    """The contact of a profile under one load."""

    left_edge: float  # its x [length]
    right_edge: float  # its x [length]
    pressure: Callable[[Array], Array]  # x (n,) -> p [stress] (n,)


def _contact_of_convex_profile(scene: Scene, normal_load: float, time: float) -> _Contact | None:
    """Edges and pressure of the contact of a convex profile under one load P, with the tilt that
    the load path has at `time`; a thousandth of the computing effort of a solution by theory.

    None for a profile that is not convex, under a moment, and where the profile can't carry P.

    Parameters
    ----------
    normal_load
        P [force per thickness]
    time
        instant of the load path whose tilt counts

    Returns
    -------
    _Contact or None
        x of the left and of the right edge, and the pressure as a function of x (n,).
    """
    from semi_analytic.elasticity import composite_modulus
    from semi_analytic.profiles import convex_profile

    # By key, "tilt" [rad] or "moment" [force]; empty where the path has neither.
    tilt_or_moment = _tilt_or_moment_at(scene, time)
    if "moment" in tilt_or_moment:
        return None
    # 1/(pi A) with A = 2/E*: `convex_shape` takes A P and gives pi A p
    pressure_scale = composite_modulus(scene.material) / (2 * np.pi)
    tilt = np.array([tilt_or_moment.get("tilt", 0.0)])
    try:
        # A convex profile gives middle and half-width of the contact under a load and a tilt.
        convex_shape = convex_profile(scene.profile)
        middle_x, half_width = convex_shape.contact_centre_and_half_width(
            normal_load / (np.pi * pressure_scale), tilt
        )
    except InputError:
        return None

    def pressure(x: Array) -> Array:
        """Pressure [stress] at places x (n,); 0 out of contact."""
        return pressure_scale * np.maximum(convex_shape.pressure(x, middle_x, half_width), 0.0)

    # middle and half-width are arrays of one, for one tilt
    (left_edge,) = (middle_x - half_width).tolist()
    (right_edge,) = (middle_x + half_width).tolist()
    return _Contact(left_edge, right_edge, pressure)


def _contact_by_theory(scene: Scene, normal_load: float, time: float, source: str) -> _Contact:
    """Edges and pressure of the contact under one normal load P, by half-plane theory. The scene is
    solved with this load alone, and with the tilt or moment that the load path has at `time`.

    Parameters
    ----------
    normal_load
        P [force per thickness]
    source
        name of the scene in messages

    Raises
    ------
    InputError
        Where theory refuses profile or load.
    """
    import semi_analytic

    # A load path from 0 to P, which is reached at time 1.
    path_to_p = PolygonLoad(
        initial_loading=((normal_load, 0.0),), **_tilt_or_moment_at(scene, time)
    )
    scene_at_p = scene.model_copy(update={"load": path_to_p})

    def solution_at_places(x: Array, *fields: str) -> ContactSolution:
        """Solution under P at places x, with the named fields."""
        return semi_analytic.solve(scene_at_p, x=x, time=[1.0], fields=fields)

    try:
        left_edge, right_edge = solution_at_places(np.zeros(1)).contact_edges[0].tolist()
    except InputError as fault:
        raise InputError(f"{source}: half-plane theory refuses it: {fault}") from fault
    return _Contact(left_edge, right_edge, lambda x: solution_at_places(x, "pressure").pressure[0])


def _tilt_or_moment_at(scene: Scene, time: float) -> dict[str, float]:
    """The tilt [rad] or the moment [force] of the load path at a time, by the key "tilt" or
    "moment" of a load. Empty where the path has neither at that time, and after the first cycle.

    `load.has_bulk_or_tilt`: the load states bulk stress, tilt, moment or line of action.
    `moment_is_given`: it states the moment, or the line of action from which the moment follows;
    the tilt follows from the moment.
    """
    if not scene.load.has_bulk_or_tilt:
        return {}
    path = scene.load.path()
    key = "moment" if path.moment_is_given else "tilt"
    value_by_key: dict[str, float] = {}
    for segment in (*path.initial_loading, *path.cycle):
        # tilt and moment over time; None where the segment has neither
        if segment.tilt_and_moment is not None and segment.start <= time <= segment.end:
            tilt, moment = segment.tilt_and_moment.loads(time)
            value_by_key = {key: float(moment if path.moment_is_given else tilt)}
    return value_by_key


@dataclass(frozen=True)
class BulkAndTilt:
    """What bulk stress and tilt do to a contact, from the loads alone."""

    # largest |eps| of the path: eps = sigma/E' of the lower body minus that of the upper body, with
    # E' = E/(1 - nu^2)
    strain: float
    # e = eps R/(f a) by the amplitude of eps in the cycle; None for other profiles than Hertz and
    # without friction
    eccentricity: float | None
    # amplitude of eps over the largest moderate one, A/(pi a) times the amplitude of Q: up to 1
    # both ends of the contact slip one way, in phase and at constant P (see
    # `semi_analytic.eccentricity`). Infinite where Q is constant, None where eps is
    share_of_moderate: float | None
    # x of the middle of a Hertz contact over its half-width, the largest of the path with its sign:
    # -tilt R, or M/P; None for other profiles
    centre: float | None


def bulk_and_tilt(scene: Scene) -> BulkAndTilt | None:
    """What bulk stress and tilt do to a contact, from the loads alone: the largest bulk strain, the
    shift of the stick zone by it, and the shift of the contact by tilt or moment. None for a scene
    that has neither.

    Both shifts are over the half-width of a parabola's contact. Where bulk stress varies, its
    amplitude is returned too, over the largest moderate one.
    """
    import semi_analytic

    if not scene.load.has_bulk_or_tilt:
        return None
    # Bulk strain at samples of the path; shift of the contact's middle over its half-width.
    strain_at_samples, largest_shift = _strain_and_shift(scene)
    largest_strain = float(np.max(np.abs(strain_at_samples)))
    # `value`: shift of the stick zone over the half-width; `strain`: amplitude of the bulk strain;
    # `limit`: the largest amplitude that is moderate, so that both ends of the contact slip one
    # way.
    stick_shift = semi_analytic.eccentricity(scene)
    if stick_shift is None:  # no bulk stress
        return BulkAndTilt(largest_strain, None, None, largest_shift)

    # amplitude of the strain over the largest moderate one: None where the strain is constant,
    # infinite where Q is, for then no strain is moderate
    share_of_limit = None
    strain_amplitude = stick_shift.strain
    if strain_amplitude:
        share_of_limit = np.inf
        if stick_shift.limit:
            share_of_limit = strain_amplitude / stick_shift.limit
    eccentricity = stick_shift.value if np.isfinite(stick_shift.value) else None
    return BulkAndTilt(largest_strain, eccentricity, share_of_limit, largest_shift)


class _BulkSamples(NamedTuple):
    """Loads and bulk strain at n samples of a load path, (n,) each."""

    normal_load: Array  # P
    strain: Array  # bulk strain of the lower body minus that of the upper
    tilt: Array
    moment: Array


def _strain_and_shift(scene: Scene) -> tuple[Array, float | None]:
    """Bulk strain of the lower body minus that of the upper at samples of the load path, (n,); and
    for a parabola x of the contact's middle over the half-width, where that is largest, with its
    sign. The second value is None for other profiles.
    """
    samples = _bulk_samples(scene)
    if not isinstance(scene.profile, Hertz):
        return samples.strain, None
    return samples.strain, _largest_shift_of_parabola(scene, scene.profile.radius, samples)


def _bulk_samples(scene: Scene) -> _BulkSamples:
    """P, bulk strain, tilt and moment at 129 times or more of each load segment of initial loading
    and cycle; of a straight one at its two ends.
    """
    path = scene.load.path()
    # of the lower body positive, of the upper body negative
    strain_per_stress = bulk_strains_per_stress(scene.material)
    samples_of_segments = []
    for segment in (*path.initial_loading, *path.cycle):
        times = sampled_times(segment, 129)
        zeros = np.zeros((2, len(times)))
        # Of the lower body, then of the upper body.
        bulk_stress = segment.bulk.loads(times) if segment.bulk is not None else zeros
        tilt_and_moment = (
            segment.tilt_and_moment.loads(times) if segment.tilt_and_moment is not None else zeros
        )
        strain_of_lower = strain_per_stress[0] * np.asarray(bulk_stress[0])
        minus_strain_of_upper = strain_per_stress[1] * np.asarray(bulk_stress[1])
        strain = strain_of_lower + minus_strain_of_upper
        normal_load = segment.loads(times)[0]
        samples_of_segments.append(np.array([normal_load, strain, *tilt_and_moment]))
    return _BulkSamples(*np.concatenate(samples_of_segments, axis=1))


def _largest_shift_of_parabola(scene: Scene, radius: float, samples: _BulkSamples) -> float:
    """x of the middle of a parabola's contact over the half-width a, at the sample where its size
    is largest, with its sign. `radius` R is that of the parabola [length].

    The middle lies at M/P under a moment M, and at -tilt R under a tilt. By Hertz a = sqrt(4 R
    P/(pi E*)). Samples without load do not count. `samples` are P, tilt and moment along the load
    path, (n,) each.
    """
    from semi_analytic.elasticity import composite_modulus

    is_pressed = samples.normal_load > 0
    normal_load = samples.normal_load[is_pressed]
    modulus = composite_modulus(scene.material)
    half_width = np.sqrt(4 * radius * normal_load / (np.pi * modulus))
    # `moment_is_given`: the load states a moment, not a tilt
    if scene.load.path().moment_is_given:
        middle_x = samples.moment[is_pressed] / normal_load
    else:
        middle_x = -radius * samples.tilt[is_pressed]
    shift = middle_x / half_width
    return float(shift[np.argmax(np.abs(shift))])


def bulk_in_words(effect: BulkAndTilt) -> str:
    """Sentences on what bulk stress and tilt do to the contact of a scene."""
    return in_template("bulk", effect)


def _size_ratios(scene: Scene, half_width: float) -> dict[str, float]:
    """Sizes of profile and bodies as ratios with the half-width a of the contact, by name, such as
    "a/R", "b/a" and "lower width/a".

    These are a (`half_width` [length]) over the radii of the profile, and the half-length b of its
    flat and the sizes of the bodies over a. Profile keys of radii have symbols in
    `_SYMBOL_OF_RADIUS`.
    """
    # _KEYS_OF_HALF_LENGTHS: keys of the half-length of a flat, tip or middle
    sizes = scene.profile.model_dump(include={*_SYMBOL_OF_RADIUS, *_KEYS_OF_HALF_LENGTHS})
    ratios = {
        f"a/{symbol}": half_width / sizes[key]
        for key, symbol in _SYMBOL_OF_RADIUS.items()
        if key in sizes
    }
    for key in _KEYS_OF_HALF_LENGTHS:
        if key in sizes:
            ratios["b/a"] = sizes[key] / half_width
    for body_name, body in (("lower", scene.bodies.lower), ("upper", scene.bodies.upper)):
        if isinstance(body, Block | Pad | TShape | ShoulderedPad):
            ratios[f"{body_name} width/a"] = body.width / half_width
            ratios[f"{body_name} height/a"] = body.height / half_width
        elif isinstance(body, Cylinder):
            ratios[f"{body_name} radius/a"] = body.radius / half_width
    return ratios


def rows_of_sliding(scene: Scene, nearest: NearestToSliding) -> list[tuple[str, str]]:
    """How near the loads come to gross sliding, and where, as rows of a table."""
    place = f"{number(nearest.time)}, in the {nearest.part}"
    loads = f"{number(nearest.normal_load)}, {number(nearest.tangential_load)}"
    return [
        ("largest |Q|/(f P), 1 where all slides", f"{nearest.ratio:.4g}"),
        ("time of it", place),
        (f"P, Q there [{load_unit(scene)}]", loads),
    ]


def rows_of_contact(scene: Scene, contact: LargestContact) -> list[tuple[str, str]]:
    """Rows (label with unit, value) of a table on the contact at the largest load, by half-plane
    theory.

    `contact` holds that load, the half-width, the peak pressure (infinite at the tip of a wedge),
    `strain` = p0/E*, and ratios of sizes by name.
    """
    _, unit_of_length, unit_of_stress = units(scene)
    rows = [
        (f"largest P [{load_unit(scene)}]", number(contact.normal_load)),
        (f"half-width a there [{unit_of_length}]", f"{contact.half_width:.4g}"),
    ]
    if math.isfinite(contact.peak_pressure):
        rows.append((f"peak pressure p0 there [{unit_of_stress}]", f"{contact.peak_pressure:.4g}"))
        rows.append(("p0/E*", f"{contact.strain:.4g}"))
    else:
        rows.append(("peak pressure p0 there", "infinite at the tip"))
    rows += [(name, f"{ratio:.4g}") for name, ratio in contact.ratios.items()]
    return rows


def remarks_on_input(scene: Scene, contact: LargestContact) -> list[str]:
    """Sentences about input that is allowed but looks like a mistake: a modulus in a wrong unit,
    friction in per cent, strains or slopes beyond linear elasticity. An empty list where nothing is
    unusual.

    `contact` is the contact at the largest load: `strain` is p0/E*, the peak pressure over the
    composite modulus, `edge_slope` the slope of the gap at its edge.
    """
    sentences = list(_remarks_on_moduli(scene))
    # _LARGEST_FRICTION: 3, the coefficient of clean indium or gold
    friction_coefficient = scene.friction.coefficient
    if friction_coefficient > _LARGEST_FRICTION:
        sentences.append(
            f"friction.coefficient = {friction_coefficient:g} is more than any pair of solids"
            f" has. Is it in per cent? {friction_coefficient:g} % is"
            f" {friction_coefficient / 100:g}."
        )
    # _LARGEST_STRAIN, _LARGEST_SLOPE: 0.1 and 0.3
    if contact.strain > _LARGEST_STRAIN or contact.edge_slope > _LARGEST_SLOPE:
        # `in_template`: the sentence of this name, filled with these values; then the words for the
        # units of force, length and stress
        sentences.append(
            in_template(
                "beyond_elasticity", contact, _LARGEST_STRAIN, _LARGEST_SLOPE, *units(scene)
            )
        )
    return sentences


def _remarks_on_moduli(scene: Scene) -> Iterator[str]:
    """A sentence for each Young's modulus that may be in a wrong unit: above that of diamond, or
    below 1 GPa where the material is no rubber by its Poisson's ratio. None where the unit of
    stress has no known size.
    """
    _, _, unit_of_stress = units(scene)
    # UNITS: size in Pa of each unit of stress
    pascals_per_unit = UNITS["stress"].get(unit_of_stress)
    if pascals_per_unit is None:
        return
    # Materials by their key in the scene; one where both bodies have the same.
    material_by_key = {"material": scene.material.upper}
    if not scene.material.alike:
        material_by_key = {
            "material.upper": scene.material.upper,
            "material.lower": scene.material.lower,
        }
    # _MODULUS_OF_STEEL: 210 GPa, to compare with
    modulus_of_steel = _MODULUS_OF_STEEL / pascals_per_unit
    for key, material in material_by_key.items():
        modulus_in_pascals = material.young_modulus * pascals_per_unit
        # _MODULUS_OF_DIAMOND: 1.3e12 Pa
        is_too_stiff = modulus_in_pascals > _MODULUS_OF_DIAMOND
        # _SOFT_MODULUS, _POISSON_RATIO_OF_RUBBER: 1e9 Pa, and Poisson's ratio 0.45
        is_rubber = material.poisson_ratio >= _POISSON_RATIO_OF_RUBBER
        is_too_soft = modulus_in_pascals < _SOFT_MODULUS and not is_rubber
        if is_too_stiff or is_too_soft:
            # `in_template`: the sentence of this name, filled with these values
            yield in_template(
                "odd_modulus",
                key,
                material.young_modulus,
                unit_of_stress,
                is_too_stiff,
                modulus_of_steel,
            )
