"""Before anything is solved: whether a load path has a solution (|Q| <= f P, P >= 0 all along), and
the size of the contact.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from reports.charts.templating import in_template
from reports.comparison.work_of_loads import bulk_strains
from reports.record_parts import sliding_in_words
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
    sampled,
)
from scenes.array_types import Array
from scenes.unit_words import UNITS

# |Q| = f P is allowed (the stick zone has just closed): rounding of the loads must not forbid it.
_ROUNDING = 1e-12
_SAMPLES = 513
# Of the largest P: below this share Q beyond f P is taken for noise of the sensors.
_NOISE = 0.05
# Rows of a record that are looked at together.
_BLOCK = 100_000
# Beyond these shares linear elasticity and half-planes mean little: hardened steel yields long
# before p0 = E*/10, and at a slope of 0.3 the parabola is 2 % off the circle that it stands for.
_STRAIN = 0.1
_SLOPE = 0.3
# Pa. What is softer than the first and no rubber (by Poisson's ratio) may be in GPa; nothing is
# stiffer than diamond.
_SOFT = 1e9
_RUBBER = 0.45
_STEEL = 210e9
_DIAMOND = 1.3e12
# Half-width of a contact by theory over that of the narrower face beyond which there is no room for
# it: theory is some per cent off for blocks, and thin layers have contacts several times narrower.
_ROOM = 1.1
_ROOM_OF_LAYERS = 10.0
# No pair of solids in air has more friction than clean indium or gold, about 2 to 3.
_FRICTION = 3.0
_RADII = {"radius": "R", "tip_radius": "R", "inner_radius": "R1", "outer_radius": "R2"}
_HALF_LENGTHS = ("flat_half_length", "tip_half_length", "inner_half_length")


@dataclass(frozen=True)
class _NearestToSliding:
    """How near a load path comes to gross sliding."""

    # largest |Q|/(f P), 1 being gross sliding; 0 for a frictionless path without Q; infinite where
    # it separates
    ratio: float
    # part, time, normal_load, tangential_load: where that is, `part` being "initial loading",
    # "cycle", or "path" if none repeats
    part: str
    time: float
    normal_load: float
    tangential_load: float


def nearest_to_sliding(scene: Scene) -> _NearestToSliding:
    """How near the loads come to gross sliding: the largest |Q|/(f P) of the initial loading and
    one cycle, with its time and loads. Each load segment is sampled, and the samples around the
    largest once more.

    >>> from scenes import load_scene
    >>> round(nearest_to_sliding(load_scene("cattaneo-mindlin")).ratio, 12)
    0.6
    """
    named_segments = _deciding_segments(scene)
    friction = scene.friction.coefficient

    def highest_ratio_and_time(segment: LoadSegment) -> tuple[float, float]:
        return _highest(segment, lambda time: _ratio(*segment.loads(time), friction))

    worst_instants = [highest_ratio_and_time(segment) for segment, _ in named_segments]
    number_of_worst = int(np.argmax([ratio for ratio, _ in worst_instants]))
    ratio, time = worst_instants[number_of_worst]
    segment, part_of_path = named_segments[number_of_worst]
    normal_load, tangential_load = segment.loads(time)
    return _NearestToSliding(ratio, part_of_path, time, float(normal_load), float(tangential_load))


def _deciding_segments(scene: Scene) -> list[tuple[LoadSegment, str]]:
    """The load segments among which |Q|/(f P) can be largest, each with the part of the path that
    it belongs to: "initial loading", "cycle" or "path".

    Of a load path all segments. Of a record of loads, which may have millions of rows, two steps
    between rows in each block of rows: that with the largest ratio and that with the largest P.
    """
    load = scene.load
    if not isinstance(load, TimeSeriesLoad):
        path = load.path()
        name_of_first = "initial loading" if path.cycle else "path"
        parts = [(segment, name_of_first) for segment in path.initial_loading]
        return parts + [(segment, "cycle") for segment in path.cycle]
    name_of_first = "initial loading" if load.repeats else "path"
    name_of_later = "cycle" if load.repeats else "path"
    rows = load.series()
    segments: list[tuple[LoadSegment, str]] = []
    for first_of_block in range(0, len(rows) - 1, _BLOCK):
        block = rows[first_of_block : first_of_block + _BLOCK + 1]
        normal_load = np.stack([block[:-1, 1], block[1:, 1]], axis=1)
        tangential_load = np.stack([block[:-1, 2], block[1:, 2]], axis=1)
        ratio = np.max(_ratio(normal_load, tangential_load, scene.friction.coefficient), axis=1)
        row_of_highest_ratio = np.argmax(ratio)
        row_of_highest_load = np.argmax(np.max(normal_load, axis=1))
        for row in np.unique([row_of_highest_ratio, row_of_highest_load]).tolist():
            start, *loads_before = block[row].tolist()
            end, *loads_after = block[row + 1].tolist()
            segment = StraightSegment(
                start, end, (loads_before[0], loads_before[1]), (loads_after[0], loads_after[1])
            )
            segments.append((segment, name_of_later if first_of_block + row > 0 else name_of_first))
    return segments


def require_admissible(scene: Scene, source: str) -> None:
    """Check that P stays positive and |Q| below f P throughout the path of a scene.

    InputError naming `source`, the instant, the loads and the rule if not. Loads that follow from
    prescribed displacements are always admissible.
    """
    if scene.load.is_driven:
        return
    try:
        _check(scene)
    except InadmissibleLoadError as fault:
        # a record that counts compression as negative
        if _is_tension(scene):
            sign_in_words = (
                "never positive" if largest_normal_load(scene) <= 0 else "negative but for noise"
            )
            raise InputError(
                f"{source}: load: P is {sign_in_words}; it is a compression, positive where the"
                " bodies are pressed together, so turn its sign if compression is negative in this"
                " record: sign = {P = -1} beside the file"
            ) from fault
        hint = ""
        if isinstance(scene.load, EllipseLoad) and scene.load.initial_loading == "parabola":
            with suppress(InadmissibleLoadError):  # the parabola alone is at fault
                _check(scene.vary(load={"initial_loading": "straight"}))
                hint = '; or write load.initial_loading = "straight", which is admissible'
        if isinstance(scene.load, TimeSeriesLoad):
            hint = _cure_of_record(scene.load, scene.friction.coefficient, fault.worst_time)
        raise InputError(f"{source}: {fault}{hint}") from fault


def _is_tension(scene: Scene) -> bool:
    """Whether P is negative all along, but for noise of a sensor without a load."""
    highest_load = largest_normal_load(scene)
    if highest_load <= 0:
        return True
    return (
        isinstance(scene.load, TimeSeriesLoad)
        and -float(np.min(scene.load.used_rows().values[:, 1])) * _NOISE > highest_load
    )


def _cure_of_record(load: TimeSeriesLoad, friction: float, time: float) -> str:
    """For a record of loads that slides or lifts off at `time`: the number of that row, and the
    keys of the scene that take such rows out.

    These are a least normal load below which there is only noise, rows that slide, or another start
    or end.
    """
    rows = load.rows.values
    first_row, row_beyond = load.bounds()
    row = first_row + int(np.argmax(np.append(rows[first_row:row_beyond, 0] >= time, True)))
    row = min(row, row_beyond - 1)
    used_rows = rows[first_row:row_beyond]
    slides = np.abs(used_rows[:, 2]) > friction * used_rows[:, 1]
    row_in_words = f"; that is row {row + 1:,} of {len(rows):,}"
    largest_load_of_noise = float(np.max(used_rows[slides, 1], initial=0.0))
    largest_load = float(np.max(used_rows[:, 1]))
    if (
        load.least_normal_load is None
        and not load.repeats
        and not load.has_bulk_or_tilt
        and largest_load_of_noise < _NOISE * largest_load
    ):
        # Twice the largest P of the bad rows, to two digits: noise does not end there.
        largest_load_of_noise = max(2 * largest_load_of_noise, _NOISE / 50 * largest_load)
        last_digit = 10.0 ** (np.floor(np.log10(largest_load_of_noise)) - 1)
        least_load = float(np.floor(largest_load_of_noise / last_digit) + 1) * last_digit
        return (
            f"{row_in_words}. Rows of so little load are noise where it is: write"
            f" load.least_normal_load = {least_load:.6g}"
        )
    if sliding := sliding_in_words(load, friction):
        return f"{row_in_words}. {sliding}"
    return (
        f"{row_in_words}. To leave rows out, write load.start or load.end: a time, or"
        f" {{row = {row + 2}}}"
    )


def _check(scene: Scene) -> None:
    """Follow the loads of a scene from its start; InadmissibleLoadError where P is negative or |Q|
    reaches f P.
    """
    from semi_analytic.history import check
    from semi_analytic.load_series import check_rows

    if isinstance(scene.load, TimeSeriesLoad):
        return check_rows(scene.load.series(), scene.friction.coefficient)
    path = scene.load.path()
    return check([*path.initial_loading, *path.cycle], scene.friction.coefficient)


def largest_normal_load(scene: Scene) -> float:
    """Largest P of the path [force per thickness]."""
    return _when_largest(scene)[0]


def _when_largest(scene: Scene) -> tuple[float, float]:
    """Largest P of the path and when that is."""

    def largest_of(segment: LoadSegment) -> tuple[float, float]:
        return _highest(segment, lambda time: segment.loads(time)[0])

    return max(largest_of(segment) for segment, _ in _deciding_segments(scene))


def _ratio(normal_load: Array, tangential_load: Array, friction: float) -> Array:
    """|Q|/(f P) at the samples of load segments, all (..., n). 0 at P = Q = 0; infinite at P < 0,
    and at Q where f P = 0.
    """
    size_of_q = np.abs(tangential_load)
    # A load that is zero but for the rounding of its own segment is zero.
    size_of_q = np.where(
        size_of_q <= _ROUNDING * friction * np.max(np.abs(normal_load), axis=-1, keepdims=True),
        0.0,
        size_of_q,
    )
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = size_of_q / (friction * normal_load)
    return np.asarray(np.where(normal_load < 0, np.inf, np.where(size_of_q == 0, 0.0, ratio)))


def _highest(segment: LoadSegment, value_at: Callable[[Array], Array]) -> tuple[float, float]:
    """The largest value of a function of time on one load segment, and its time: the best of some
    samples, then twice the best of closer samples around it. `value_at` gives the values at times
    (n,).
    """
    time = sampled(segment, _SAMPLES)
    for _ in range(3):
        values = value_at(time)
        index_of_highest = int(np.argmax(values))
        highest_value = float(values[index_of_highest])
        time_of_highest = float(time[index_of_highest])
        if not np.isfinite(highest_value) or index_of_highest in (0, len(time) - 1):
            break
        time = np.linspace(time[index_of_highest - 1], time[index_of_highest + 1], _SAMPLES)
    return highest_value, time_of_highest


_NO_THEORY_OF_CURVED_FACES = (
    "how far a pad or a cylinder moves under its loads is known to finite elements alone; a block"
    " or a t_shape has theory"
)


@dataclass(frozen=True)
class Engines:
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
        """Which engine takes the scene, which does not and why, and the command that works for it.
        "" where both take it; `source` is the scene's name in that command.
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


def engines_for(scene: Scene, source: str, *, finite_elements: bool = True) -> Engines:
    """Which of theory and finite elements can solve a scene whose load path is admissible.

    In the answer the reason why an engine refuses is "" where it accepts. With `finite_elements`
    False these are looked at only where theory refuses; else their reason is "" unexamined.
    `size_in_words`, how the width of the contact was estimated, is "" where it was not.
    `source` names the scene in messages.

    Raises
    ------
    InputError
        One sentence, for what no engine answers: rows of a table that do not define the profile,
        real bodies that finite elements refuse (theory has half-planes in their place), a contact
        wider than the narrower face of the bodies, and what both engines refuse.
    """
    # Under prescribed displacements each engine finds loads of its own. Theory then needs the
    # responses of flat faces.
    if scene.load.is_driven:
        if scene.bodies.faces_are_true:
            return Engines(_NO_THEORY_OF_CURVED_FACES, "")
        return Engines("", "", finds_own_loads=True)
    reason_of_theory = _refusal_of_theory(scene, source)
    if not reason_of_theory and not scene.bodies.half_planes:
        _require_face_wider_than_contact(scene, source)
    if not finite_elements and not reason_of_theory:
        return Engines("", "")
    reason_of_elements, size_in_words = _refusal_of_elements(scene, source, reason_of_theory)
    return Engines(reason_of_theory, reason_of_elements, size_in_words)


def _refusal_of_theory(scene: Scene, source: str) -> str:
    """Why half-plane theory does not solve a scene; "" where it does. InputError naming `source`
    for rows of a profile that no engine can use.
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
    """Why finite elements do not solve a scene ("" where they do), and how the size of its contact
    was estimated ("" where it was not).

    InputError naming `source` where no engine is left: theory refuses too, as `reason_of_theory`
    states, or knows no bodies of a finite size.
    """
    import halfplane_fe

    try:
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
    """InputError where the contact at the largest load, by half-plane theory, is wider than the
    narrower face; nothing is meshed.

    A layer thinner than the face is wide makes the contact narrower than theory's: there the limit
    is wider, and finite elements look at what is below it.
    """
    from halfplane_fe.supports import face_room

    half_width_of_face = float(face_room(scene))
    heights = [
        float(getattr(body, "height", np.inf)) for body in (scene.bodies.lower, scene.bodies.upper)
    ]
    largest_share = _ROOM if min(heights) >= 1.5 * half_width_of_face else _ROOM_OF_LAYERS
    contact = largest_contact(scene, source)
    if contact.half_width <= largest_share * half_width_of_face:
        return
    unit_of_force, unit_of_length, unit_of_stress = units(scene)
    remarks_before = "".join(f"{remark} " for remark in remarks(scene, contact))
    raise InputError(
        f"{source}: {remarks_before}Check the units first: loads are in {unit_of_force} per"
        f" {unit_of_length} of thickness, E is in {unit_of_stress}, sizes are in {unit_of_length}."
        " bodies: the contact at the largest load reaches past the end of the narrower face, at |x|"
        f" = {half_width_of_face:.6g}: by half-plane theory P = {contact.normal_load:.6g} gives the"
        f" half-width {contact.half_width:.4g}, which is"
        f" {contact.half_width / half_width_of_face:.3g} times that. If the units are right, make"
        f" the bodies wider, or the load less; `halfplane exact {source}` gives half-plane theory's"
        " answer, which knows no bodies"
    )


@dataclass(frozen=True)
class _LargestContact:
    """The contact at the largest normal load of the path, by half-plane theory."""

    normal_load: float  # P [force per thickness]
    half_width: float  # a [length]
    peak_pressure: float  # p0 [stress]; infinite at the tip of a sharp wedge
    strain: float  # p0/E*; the mean pressure over E* where p0 is infinite
    edge_slope: float  # h'(a), which is a/R for Hertz
    # a over the radii of the profile, its half-length over a, sizes of the bodies over a
    ratios: dict[str, float]


def largest_contact(scene: Scene, source: str) -> _LargestContact:
    """Half-width, peak pressure, strain and slope of the contact at the largest load of a scene, by
    half-plane theory.

    Neither the history nor bulk stress matters: they do not move p. InputError, naming `source`,
    where theory can't press the profile with that load: a table or function that ends within the
    contact, a shape under which the contact would split, a tilt of a profile that bends down
    somewhere.
    """
    from semi_analytic.elasticity import composite_modulus

    largest_load, time = _when_largest(scene)
    contact = _pressed_convex(scene, largest_load, time)
    if contact is None:
        contact = _pressed_by_the_engine(scene, largest_load, time, source)
    half_width = (contact.right - contact.left) / 2
    peak_pressure = _peak_pressure(contact, scene)
    typical_pressure = peak_pressure
    if not np.isfinite(peak_pressure):  # at the tip of a wedge: the mean pressure in its place
        typical_pressure = largest_load / (2 * half_width)
    contact_edges = np.array([contact.left, contact.right])
    heights = scene.profile.height(contact_edges[:, None] * np.array([1 - 1e-6, 1 + 1e-6]))
    slopes = (heights[:, 1] - heights[:, 0]) / (2e-6 * np.abs(contact_edges))
    return _LargestContact(
        normal_load=largest_load,
        half_width=half_width,
        peak_pressure=peak_pressure,
        strain=typical_pressure / composite_modulus(scene.material),
        edge_slope=float(np.max(slopes)),
        ratios=_ratios(scene, half_width),
    )


def _peak_pressure(contact: _Pressed, scene: Scene) -> float:
    """Largest pressure of a contact [stress], of many points; infinite at the tip of a wedge."""
    # Close points at the edges, where a flat with rounded corners has its peak; then closer ones
    # around the best.
    half_width = (contact.right - contact.left) / 2
    middle_x = (contact.left + contact.right) / 2
    x = middle_x + half_width * np.sin(np.linspace(-np.pi / 2, np.pi / 2, 257))
    kinks = np.array([*scene.profile.kinks, *(-kink for kink in scene.profile.kinks)])
    x = np.union1d(x, kinks[(contact.left < kinks) & (kinks < contact.right)])
    pressure = contact.pressure(x)
    peak_index = int(np.argmax(pressure))
    x_around_peak = np.linspace(x[max(peak_index - 1, 0)], x[min(peak_index + 1, len(x) - 1)], 65)
    return max(float(pressure[peak_index]), float(np.max(contact.pressure(x_around_peak))))


@dataclass(frozen=True)
class _Pressed:
    """The profile under one load: ends of the contact, and p [stress] at points (n,)."""

    left: float
    right: float
    pressure: Callable[[Array], Array]


def _pressed_convex(scene: Scene, load: float, time: float) -> _Pressed | None:
    """Ends and pressure of the contact of a convex profile under one load, in a thousandth of the
    engine's time.

    None for another profile, under a moment, and where the profile can't carry the load.
    """
    from semi_analytic.elasticity import composite_modulus
    from semi_analytic.profiles import convex_profile

    tilt_or_moment = _tilt_or_moment_at(scene, time)
    if "moment" in tilt_or_moment:
        return None
    pressure_by_slope = composite_modulus(scene.material) / (2 * np.pi)
    tilt = np.array([tilt_or_moment.get("tilt", 0.0)])
    try:
        shape = convex_profile(scene.profile)
        middle_x, half_width = shape.contact(load / (np.pi * pressure_by_slope), tilt)
    except InputError:
        return None

    def pressure(x: Array) -> Array:
        return pressure_by_slope * np.maximum(shape.pressure(x, middle_x, half_width), 0.0)

    return _Pressed(float((middle_x - half_width)[0]), float((middle_x + half_width)[0]), pressure)


def _pressed_by_the_engine(scene: Scene, load: float, time: float, source: str) -> _Pressed:
    """Ends and pressure of the contact under one normal load P, by solving the scene with this load
    alone.

    It takes any profile that theory takes, and the tilt or moment that the load path has at `time`.
    InputError, naming `source`, for what theory does not take.
    """
    import semi_analytic

    pressed_load = PolygonLoad(initial_loading=((load, 0.0),), **_tilt_or_moment_at(scene, time))
    pressed_scene = scene.model_copy(update={"load": pressed_load})

    def solution_at(x: Array, *fields: str) -> ContactSolution:
        return semi_analytic.solve(pressed_scene, x=x, time=[1.0], fields=fields)

    try:
        left_edge, right_edge = solution_at(np.zeros(1)).contact_edges[0].tolist()
    except InputError as fault:
        raise InputError(f"{source}: half-plane theory refuses it: {fault}") from fault
    return _Pressed(left_edge, right_edge, lambda x: solution_at(x, "pressure").pressure[0])


def _tilt_or_moment_at(scene: Scene, time: float) -> dict[str, float]:
    """The tilt [rad] or the moment [force] of the load path at a time, whichever the scene states,
    by its key in the scene's load. Empty where the path has neither.
    """
    if not scene.load.has_bulk_or_tilt:
        return {}
    path = scene.load.path()
    key = "moment" if path.moment_given else "tilt"
    value_by_key: dict[str, float] = {}
    for segment in (*path.initial_loading, *path.cycle):
        if segment.turning is not None and segment.start <= time <= segment.end:
            tilt, moment = segment.turning.loads(time)
            value_by_key = {key: float(moment if path.moment_given else tilt)}
    return value_by_key


@dataclass(frozen=True)
class _BulkAndTilt:
    """What bulk stress and tilt do to a contact, from the loads alone."""

    # largest |eps| of the path, eps = sigma/E' of the lower body less that of the upper, E' = E/(1
    # - nu^2)
    strain: float
    # e = eps R/(f a) by the amplitude of eps in the cycle; None of other profiles than Hertz and
    # without friction
    eccentricity: float | None
    # that amplitude over A/(pi a) times that of Q, see `semi_analytic.eccentricity`; up to 1 bulk
    # is moderate. Infinite where Q stands still, None where eps does
    share_of_moderate: float | None
    # middle of a Hertz contact over its half-width, where that is largest: -tilt R, or M/P; None of
    # other profiles
    centre: float | None


def bulk_and_tilt(scene: Scene) -> _BulkAndTilt | None:
    """What bulk stress and tilt do to a contact, from the loads alone: the largest bulk strain, the
    shift of the stick zone by it, and the shift of the contact by tilt or moment over its
    half-width. None for a scene without both.
    """
    import semi_analytic

    if not scene.load.has_bulk_or_tilt:
        return None
    strain, largest_shift = _strain_and_shift(scene)
    largest_strain = float(np.max(np.abs(strain)))
    eccentricity = semi_analytic.eccentricity(scene)
    if eccentricity is None:
        return _BulkAndTilt(largest_strain, None, None, largest_shift)
    # None where no strain varies; infinite where Q stands still, so that any strain is large
    share_of_limit = None
    if eccentricity.strain:
        share_of_limit = np.inf
        if eccentricity.limit:
            share_of_limit = eccentricity.strain / eccentricity.limit
    value = eccentricity.value if np.isfinite(eccentricity.value) else None
    return _BulkAndTilt(largest_strain, value, share_of_limit, largest_shift)


def _strain_and_shift(scene: Scene) -> tuple[Array, float | None]:
    """Bulk strain of the lower body minus that of the upper at samples of the load path, (n,); and
    the largest distance of the contact's middle from x = 0, over the half-width, for a parabola.

    The middle lies at M/P under a moment M, at -tilt R under a tilt. None for other profiles.
    """
    from semi_analytic.elasticity import composite_modulus

    path = scene.load.path()
    strain_per_stress = bulk_strains(scene.material)
    samples = []
    for segment in (*path.initial_loading, *path.cycle):
        time = sampled(segment, 129)
        zeros = np.zeros((2, len(time)))
        bulk = segment.bulk.loads(time) if segment.bulk is not None else zeros
        tilt_and_moment = segment.turning.loads(time) if segment.turning is not None else zeros
        strain_of_lower = strain_per_stress[0] * np.asarray(bulk[0])
        strain_of_upper = strain_per_stress[1] * np.asarray(bulk[1])
        normal_load = segment.loads(time)[0]
        samples.append(np.array([normal_load, strain_of_lower + strain_of_upper, *tilt_and_moment]))
    normal_load, strain, tilt, moment = np.concatenate(samples, axis=1)
    if not isinstance(scene.profile, Hertz):
        return strain, None
    is_pressed = normal_load > 0
    radius = scene.profile.radius
    modulus = composite_modulus(scene.material)
    half_width = np.sqrt(4 * radius * normal_load[is_pressed] / (np.pi * modulus))
    if path.moment_given:
        middle_x = moment[is_pressed] / normal_load[is_pressed]
    else:
        middle_x = -radius * tilt[is_pressed]
    shift = middle_x / half_width
    return strain, float(shift[np.argmax(np.abs(shift))])


def bulk_in_words(effect: _BulkAndTilt) -> str:
    """Sentences on what bulk stress and tilt do to the contact of a scene."""
    return in_template("bulk", effect)


def _ratios(scene: Scene, half_width: float) -> dict[str, float]:
    """Ratios of the sizes of profile and bodies to the half-width a of the contact (`half_width`
    [length]), by name, such as "a/R" and "lower width/a".
    """
    sizes = scene.profile.model_dump(include={*_RADII, *_HALF_LENGTHS})
    ratios = {
        f"a/{symbol}": half_width / sizes[key] for key, symbol in _RADII.items() if key in sizes
    }
    for key in _HALF_LENGTHS:
        if key in sizes:
            ratios["b/a"] = sizes[key] / half_width
    for body_name, body in (("lower", scene.bodies.lower), ("upper", scene.bodies.upper)):
        if isinstance(body, Block | Pad | TShape | ShoulderedPad):
            ratios[f"{body_name} width/a"] = body.width / half_width
            ratios[f"{body_name} height/a"] = body.height / half_width
        elif isinstance(body, Cylinder):
            ratios[f"{body_name} radius/a"] = body.radius / half_width
    return ratios


def rows_of_sliding(scene: Scene, nearest: _NearestToSliding) -> list[tuple[str, str]]:
    """How near the loads come to gross sliding, and where, as rows of a table."""
    place = f"{number(nearest.time)}, in the {nearest.part}"
    loads = f"{number(nearest.normal_load)}, {number(nearest.tangential_load)}"
    return [
        ("largest |Q|/(f P), 1 where all slides", f"{nearest.ratio:.4g}"),
        ("time of it", place),
        (f"P, Q there [{load_unit(scene)}]", loads),
    ]


def rows_of_contact(scene: Scene, contact: _LargestContact) -> list[tuple[str, str]]:
    """Rows (label with unit, value) of a table on the contact at the largest load, by half-plane
    theory.
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


def remarks(scene: Scene, contact: _LargestContact) -> list[str]:
    """Sentences about input that is allowed but looks like a mistake: a modulus in a wrong unit,
    friction in per cent, strains or slopes beyond linear elasticity. An empty list where nothing is
    unusual. `contact` is the contact at the largest load.
    """
    sentences = []
    unit_of_force, unit_of_length, unit_of_stress = units(scene)
    pascal = UNITS["stress"].get(unit_of_stress, 0.0)
    material_by_key = {"material": scene.material.upper}
    if not scene.material.alike:
        material_by_key = {
            "material.upper": scene.material.upper,
            "material.lower": scene.material.lower,
        }
    for key, material in material_by_key.items() if pascal else ():
        modulus = material.young_modulus * pascal
        too_stiff = modulus > _DIAMOND
        too_soft = modulus < _SOFT and material.poisson_ratio < _RUBBER
        if too_stiff or too_soft:
            steel = _STEEL / pascal
            sentences.append(
                in_template(
                    "odd_modulus", key, material.young_modulus, unit_of_stress, too_stiff, steel
                )
            )
    if scene.friction.coefficient > _FRICTION:
        sentences.append(
            f"friction.coefficient = {scene.friction.coefficient:g} is more than any pair of solids"
            f" has. Is it in per cent? {scene.friction.coefficient:g} % is"
            f" {scene.friction.coefficient / 100:g}."
        )
    if contact.strain > _STRAIN or contact.edge_slope > _SLOPE:
        sentences.append(
            in_template(
                "beyond_elasticity",
                contact,
                _STRAIN,
                _SLOPE,
                unit_of_force,
                unit_of_length,
                unit_of_stress,
            )
        )
    return sentences
