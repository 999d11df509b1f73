"""Load histories P(t), Q(t) as load segments, and what loads state beside them: bulk stresses in
the bodies, tilt or moment.

# notation: sigma_l, sigma_u bulk stresses of the lower and the upper body; alpha tilt; M moment of
the pressure about x = 0
"""

from __future__ import annotations

import abc
import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Generic, Literal, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, model_validator

from scenes.array_types import Array
from scenes.chebyshev import (
    CHEBYSHEV_NODES,
    UnresolvedError,
    chebyshev_coefficients,
    function_of_arrays,
    piecewise_series_of,
)
from scenes.column_names import aliases_of, normalised_name
from scenes.errors import InputError, RowError
from scenes.frozen import Frozen, Positive, PythonFunction, require_squarable
from scenes.measured import (
    DESCRIPTION_OF_COLUMNS,
    DESCRIPTION_OF_READ_AS,
    DESCRIPTION_OF_SCALE,
    DESCRIPTION_OF_UNITS,
    DESCRIPTION_OF_ZERO,
    FromFile,
    ReadAs,
    Reduction,
    Table,
    reduced_record,
)
from scenes.segments import (
    ChebyshevSegment,
    Combination,
    HarmonicSegment,
    LoadPath,
    LoadSegment,
    Point,
    StraightSegment,
    Waves,
    ellipse_segment,
    parabola_segment,
    straight_segments,
)
from scenes.unit_words import Kind

if TYPE_CHECKING:
    from scenes.text_tables import MissingColumnError, TextTable

# Loads that differ by less than this, over their size, are taken as equal.
_ROUND_OFF_LOAD_SHARE = 1e-12


InitialLoading = Literal["straight"] | tuple[Point, ...]


def straight_loading(
    initial_loading: InitialLoading, first_segment: LoadSegment, line_duration: float
) -> tuple[StraightSegment, ...]:
    """Initial loading of a load path: straight segments in the P-Q plane from P = Q = 0 through
    given points to the loads at the start of the first segment after it. Movements of actuators may
    stand in the place of P and Q.

    Parameters
    ----------
    initial_loading
        (P, Q) points between [force per thickness], or movements [length]; "straight" for none
    first_segment
        after the initial loading: of the cycle, or of functions that do not repeat. Its start is
        the end of the initial loading, in time and in loads
    line_duration
        duration of each straight segment
    """
    points_between = () if initial_loading == "straight" else initial_loading
    end_time = first_segment.start
    end_loads = tuple(float(load) for load in first_segment.loads(end_time))
    points = [(0.0, 0.0), *points_between, end_loads]
    begin_time = end_time - (len(points) - 1) * line_duration
    times_and_loads = [(begin_time + k * line_duration, *point) for k, point in enumerate(points)]
    return straight_segments(times_and_loads)


Harmonic = tuple[
    Annotated[float, Field(ge=0, description="amplitude")],
    Annotated[float, Field(description="lag, degrees")],
]
_DESCRIPTION_OF_INITIAL_VALUES = (
    "values at the points of the load's initial_loading; in proportion to P if left out"
)


class Wave(Frozen):
    """mean + amplitude cos(t - phase), t being the time of the ellipse."""

    mean: float = Field(0.0, description="in the unit of the key")
    amplitude: float = Field(0.0, ge=0, description="in the unit of the key")
    phase_degrees: float = Field(0.0, ge=-180, le=180, description="lag behind P")
    initial_loading: tuple[float, ...] = Field((), description=_DESCRIPTION_OF_INITIAL_VALUES)

    def waves(self) -> tuple[float, Waves]:
        """(mean, ((amplitude, phase in radians),))."""
        return self.mean, ((self.amplitude, math.radians(self.phase_degrees)),)


class DrivenWave(Frozen):
    """U_act = mean + amplitude cos(t - phase) of an actuator, t being the time of the ellipse."""

    mean: float = Field(0.0, description="length units (library: mm)")
    amplitude: float = Field(0.0, ge=0, description="length units (library: mm)")
    phase_degrees: float = Field(90.0, ge=-180, le=180, description="lag of U_act behind P")


class DrivenApproach(Frozen):
    """Approach = mean + amplitude cos t of a normal actuator, t being the time of the ellipse."""

    mean: Positive = Field(description="length units (library: mm)")
    amplitude: float = Field(0.0, ge=0, description="length units (library: mm)")


class DrivenWaveSum(Frozen):
    """U_act = mean + sum over k of amplitude_k cos(k t - phase_k) of an actuator."""

    mean: float = Field(0.0, description="length units (library: mm)")
    harmonics: tuple[Harmonic, ...] = Field(
        (), description="[amplitude, phase in degrees] of k = 1, 2, ... (library: mm, degrees)"
    )


_DESCRIPTION_OF_U_ACT = "U_act of a tangential actuator, in place of the tangential loads"
_DESCRIPTION_OF_APPROACH = (
    "approach of a normal actuator, in place of the normal loads; needs U_act"
)
# 0 where the approach is stated in its place.
_MeanNormalLoad = Annotated[
    float, Field(ge=0), AfterValidator(lambda load: require_squarable(load) if load else load)
]
_DESCRIPTION_OF_MEAN_NORMAL_LOAD = (
    "P0, force per unit thickness (library: N/mm); needed unless the approach is stated"
)
_DESCRIPTION_OF_U_ACT_FLAG = (
    "true: U_act of a tangential actuator stands in the place of Q (library: mm)"
)
_DESCRIPTION_OF_APPROACH_FLAG = (
    "true: the approach of a normal actuator stands in the place of P; needs U_act (library: mm)"
)


class WaveSum(Frozen):
    """mean + sum over k of amplitude_k cos(k t - phase_k), t being the time of the harmonics."""

    mean: float = Field(0.0, description="in the unit of the key")
    harmonics: tuple[Harmonic, ...] = Field(
        (), description="[amplitude, phase in degrees] of k = 1, 2, ..."
    )
    initial_loading: tuple[float, ...] = Field((), description=_DESCRIPTION_OF_INITIAL_VALUES)

    def waves(self) -> tuple[float, Waves]:
        """(mean, ((amplitude, phase in radians), ...))."""
        return self.mean, tuple(
            (amplitude, math.radians(phase)) for amplitude, phase in self.harmonics
        )


class LineOfAction(Frozen):
    """Where the load acts on the upper body: M = x P + height Q."""

    x: float = Field(0.0, description="of the line along which P acts, length units (library: mm)")
    height: float = Field(
        0.0, description="above the contact at which Q acts, length units (library: mm)"
    )


REFUSAL_OF_DISPLACEMENTS = (
    "load.tangential_displacement: P and Q follow from the displacement that is prescribed, and"
    " this takes loads. `halfplane exact` finds them by corrected half-plane theory, `halfplane fe`"
    " by finite elements; the scene.json that they write states them, without slides of the whole"
)
"""What is said where loads are needed and a displacement is prescribed."""


V = TypeVar("V")
Pair = tuple[Any, Any]
# Attribute of a load segment -> keys of the two quantities that it carries.
_KEYS_OF_SEGMENT_ATTRIBUTES = {
    "bulk": ("bulk_stress_lower", "bulk_stress_upper"),
    "tilt_and_moment": ("tilt", "moment"),
}
BULK_AND_TILT_KEYS = (
    *_KEYS_OF_SEGMENT_ATTRIBUTES["bulk"],
    *_KEYS_OF_SEGMENT_ATTRIBUTES["tilt_and_moment"],
    "line_of_action",
)
"""Keys of bulk stress, tilt and moment, which every load has."""


class BulkAndTilt(Frozen, Generic[V]):
    """Keys of bulk stress and tilt. During initial loading they grow in proportion to P, to their
    values at the cycle's start.

    >>> from scenes import EllipseLoad
    >>> load = EllipseLoad(
    ...     mean_normal_load=3.0,
    ...     tangential_amplitude=1.0,
    ...     bulk_stress_lower={"amplitude": 0.5, "phase_degrees": 90},
    ... )
    >>> path = load.path()
    >>> [round(float(one), 12) for one in path.cycle[0].bulk.loads(path.cycle_start)]
    [-0.5, 0.0]
    """

    bulk_stress_lower: float | V | None = Field(
        None,
        description=(
            "bulk stress along x in the lower body, tension positive, stress units (library: MPa)"
        ),
    )
    bulk_stress_upper: float | V | None = Field(
        None, description="likewise in the upper body (library: MPa)"
    )
    tilt: float | V | None = Field(
        None, description="turn of the upper body that opens the gap at x > 0 (library: rad)"
    )
    moment: float | V | None = Field(
        None,
        description=(
            "moment of the pressure about x = 0 per unit thickness, in place of the tilt"
            " (library: N)"
        ),
    )
    line_of_action: LineOfAction | None = Field(
        None, description="where P and Q act on the upper body, in place of the moment"
    )

    @model_validator(mode="after")
    def _require_consistent_bulk_and_tilt(self) -> Self:
        """Return this load, if its keys agree; refuse (ValueError) a tilt stated in two ways, or
        bulk stress or tilt beside a prescribed displacement.

        With bulk stress, tilt or moment the load path is made too: that refuses lists of their
        values that do not fit it.
        """
        # Tilt and moment follow from each other, and the moment from the line along which loads
        # act.
        tilt_keys = [
            key for key in ("tilt", "moment", "line_of_action") if getattr(self, key) is not None
        ]
        if len(tilt_keys) > 1:
            raise ValueError(f"{' and '.join(tilt_keys)} say the same thing: state one of them")
        # `is_driven`: a displacement is prescribed in the place of Q.
        if self.has_bulk_or_tilt and self.is_driven:
            # BULK_AND_TILT_KEYS: keys of both bulk stresses, tilt, moment and line of action
            key = next(key for key in BULK_AND_TILT_KEYS if getattr(self, key) is not None)
            raise ValueError(
                f"{key} does not go with tangential_displacement: leave one of the two out"
            )
        if self.has_bulk_or_tilt:
            self.path()  # refuses lists of another length
        return self

    @property
    def is_driven(self) -> bool:
        """Whether a displacement is prescribed in the place of Q, so that P and Q follow from the
        contact.
        """
        return bool(getattr(self, "tangential_displacement", None))

    @property
    def states_approach(self) -> bool:
        """Whether the approach is prescribed in the place of P."""
        return bool(getattr(self, "approach", False))

    def path_of_actuators(self) -> LoadPath:
        """Path over time of the two prescribed quantities, in the places of P and Q of a load path.

        The first is P [force per unit thickness], or the approach of a normal actuator [length].
        The second is Q, or the displacement U of a tangential actuator [length]. In the example P
        is 2 throughout, and U is 0.01 at time 2.

        >>> load = PolygonLoad(
        ...     initial_loading=[(2, 0)],
        ...     cycle=[(2, 0.01), (2, -0.01)],
        ...     tangential_displacement=True,
        ... )
        >>> [float(value) for value in load.path_of_actuators().at(2.0)]
        [2.0, 0.01]
        """
        # Each kind of load fills in what its keys prescribe.
        return self.path_of_loads()

    @property
    def has_bulk_or_tilt(self) -> bool:
        """Whether any of these keys is stated."""
        return any(getattr(self, key) is not None for key in BULK_AND_TILT_KEYS)

    @property
    def moment_is_given(self) -> bool:
        """Whether the moment is stated, by itself or by a line of action, so that the tilt follows
        from it.
        """
        return self.moment is not None or self.line_of_action is not None

    def path(self) -> LoadPath:
        """Load path P(t), Q(t) of this load: initial loading, then the cycle. Each of its segments
        also holds the bulk stresses over its time, and tilt or moment, where the load states them.

        Raises
        ------
        InputError
            Where a displacement is prescribed: the loads follow from the contact.
        """
        if self.is_driven:  # a displacement is prescribed in the place of Q
            # REFUSAL_OF_DISPLACEMENTS: a sentence, that loads are needed here
            raise InputError(REFUSAL_OF_DISPLACEMENTS)
        # P and Q alone.
        path = self.path_of_loads()
        # `has_bulk_or_tilt`: whether the load states a bulk stress, tilt or moment.
        if not self.has_bulk_or_tilt:
            return path
        load_segments: tuple[LoadSegment, ...] = (*path.initial_loading, *path.cycle)
        companions = self._companions_of(path, load_segments)
        # Each load segment gets its companions; then the path is put together again.
        complete_segments = [
            replace(segment, **dict(zip(companions, companions_of_segment, strict=True)))
            for segment, *companions_of_segment in zip(
                load_segments, *companions.values(), strict=True
            )
        ]
        n_initial_segments = len(path.initial_loading)
        # `moment_is_given`: the moment is stated, and the tilt follows from it.
        return LoadPath(
            tuple(complete_segments[:n_initial_segments]),
            tuple(complete_segments[n_initial_segments:]),
            self.moment_is_given,
        )

    def _companions_of(
        self, path: LoadPath, load_segments: Sequence[LoadSegment]
    ) -> dict[str, Sequence[LoadSegment]]:
        """Histories of bulk stress, tilt and moment over the segments of a load path, one for each
        load segment, over the same time. They are what the load states, by attribute of a segment:

        - "bulk": both bulk stresses
        - "tilt_and_moment": tilt and moment

        `load_segments` are all segments of the `path`: initial loading, then the cycle.
        """
        companions: dict[str, Sequence[LoadSegment]] = {}
        # `line_of_action`: the line along which P acts, x, and the height at which Q acts; or None.
        if (line_of_action := self.line_of_action) is not None:
            # The moment is M = x P + height Q; in the place of the tilt, which follows from it,
            # stands 0.
            moment_of_loads = Combination(line_of_action.x, line_of_action.height)
            companions["tilt_and_moment"] = [
                segment.companion_of(moment_of_loads) for segment in load_segments
            ]
        # The other companions follow from the values of the keys, None where a key is not stated.
        # _KEYS_OF_SEGMENT_ATTRIBUTES: attribute of a load segment -> keys of its two quantities
        for attribute, (first_key, second_key) in _KEYS_OF_SEGMENT_ATTRIBUTES.items():
            key_values = getattr(self, first_key), getattr(self, second_key)
            if key_values != (None, None):
                companions[attribute] = self._companion_segments(path, load_segments, key_values)
        return companions

    @abc.abstractmethod
    def path_of_loads(self) -> LoadPath:
        """Load path of P and Q alone, or of what is prescribed in their places, without bulk stress
        and tilt.
        """

    def formula_segments(
        self,
        path: LoadPath,  # noqa: ARG002 straight loads follow no formula
        key_values: Pair,  # noqa: ARG002
    ) -> Sequence[LoadSegment]:
        """Two quantities beside P and Q, such as both bulk stresses: one segment for each of the
        last segments of the load `path`, on which they follow formulas of time. Here there are
        none: such quantities are straight lines on all segments.

        `key_values` are the values of their two keys in the scene; None counts as 0.
        """
        return ()

    def _companion_segments(
        self, path: LoadPath, load_segments: Sequence[LoadSegment], key_values: Pair
    ) -> list[LoadSegment]:
        """Two quantities over time beside P and Q, such as both bulk stresses: one segment of the
        pair for each load segment, over the same time.

        On the last load segments they follow formulas of time, if this kind of load has formulas:
        on the cycle, or of functions without a cycle from time 0 on. On the load segments before,
        they are straight lines between their values at the vertices, where load segments meet.

        Parameters
        ----------
        path
            load path of P and Q: initial loading, then the cycle
        load_segments
            all segments of the path, in this order
        key_values
            what the scene states for the two quantities: number, list, formula, or None for 0
        """
        # On the last load segments the quantities follow formulas of time; `load_segments_before`
        # are those before, on which they are straight lines.
        segments_by_formula = self.formula_segments(path, key_values)
        n_segments_before = len(load_segments) - len(segments_by_formula)
        load_segments_before = load_segments[:n_segments_before]
        values_where_formulas_begin: Pair = (0.0, 0.0)
        if segments_by_formula:
            values_where_formulas_begin = segments_by_formula[0].loads(segments_by_formula[0].start)

        # P at the vertices, from 0 on, and the values of both quantities there. A list states them.
        # A number or formula grows in proportion to P up to the last vertex, or up to a cycle of
        # straight lines, on which a number holds at each vertex.
        normal_loads_at_ends = (
            float(segment.loads(segment.end)[0]) for segment in load_segments_before
        )
        normal_loads = np.array([0.0, *normal_loads_at_ends])
        values_of_first_quantity, values_of_second_quantity = (
            self.values_at_vertices(
                key_value, normal_loads, float(value_where_formula_begins)
            ).tolist()
            for key_value, value_where_formula_begins in zip(
                key_values, values_where_formulas_begin, strict=True
            )
        )
        pairs_at_vertices = zip(values_of_first_quantity, values_of_second_quantity, strict=True)
        straight_segments_of_pair = (
            StraightSegment(segment.start, segment.end, begin_values, end_values)
            for segment, (begin_values, end_values) in zip(
                load_segments_before, pairwise(pairs_at_vertices), strict=True
            )
        )
        return [*straight_segments_of_pair, *segments_by_formula]

    def values_at_vertices(
        self, key_value: Any, normal_loads: NDArray[np.float64], value_at_cycle_start: float
    ) -> NDArray[np.float64]:
        """Values (n,) of a bulk stress, tilt or moment at the n vertices of the initial loading: in
        proportion to P, or as its own list states them.

        Parameters
        ----------
        key_value
            what the scene states for the quantity: None, a number, or a formula of time whose
            `initial_loading` may list values
        normal_loads
            (n,) P at the vertices, from 0 on
        value_at_cycle_start
            value of the quantity at the last vertex, where the cycle begins, or where functions
            that do not repeat begin

        Raises
        ------
        ValueError
            Where the list has another number of values than the initial loading has points.
        """
        stated_values = getattr(key_value, "initial_loading", ())
        # No list states the values at (0, 0) and at the start of the cycle.
        n_points = len(normal_loads) - 2
        if stated_values and len(stated_values) != n_points:
            raise ValueError(
                f"initial_loading of a bulk stress or tilt has {len(stated_values)} values"
                f" for {n_points} points of the load"
            )
        if stated_values:
            return np.array([0.0, *stated_values, value_at_cycle_start])
        # A path that ends at P = 0 is not divided by it.
        return np.asarray(value_at_cycle_start * normal_loads / (normal_loads[-1] or 1.0))


W = TypeVar("W", bound=Wave | WaveSum)


class CyclicLoad(BulkAndTilt[W], Generic[W]):
    """A load whose P, Q, bulk stresses and tilt are sums of cosines of time along the cycle."""

    def formula_segments(self, path: LoadPath, key_values: Pair) -> Sequence[LoadSegment]:
        """Two quantities beside P and Q, such as both bulk stresses, as sums of cosines over the
        segments of the cycle of the load `path`.

        `key_values` are what the scene states for the two: a wave or a sum of waves, a number, or
        None for 0.
        """
        # waves(): mean and (amplitude, phase in radians) of each cosine; a number has none.
        mean_and_waves_of_each = [
            key_value.waves() if isinstance(key_value, Wave | WaveSum) else (key_value or 0.0, ())
            for key_value in key_values
        ]
        means, waves = zip(*mean_and_waves_of_each, strict=True)
        return [
            HarmonicSegment(segment.start, segment.end, means, *waves) for segment in path.cycle
        ]


class EllipseLoad(CyclicLoad[Wave]):
    """P = P0 + P1 cos t, Q = Q0 + Q1 cos(t - phase); a revolution takes 2 pi.

    The cycle starts where |Q - Q0| is largest while P grows.

    >>> load = EllipseLoad(
    ...     mean_normal_load=3, normal_amplitude=1, mean_tangential_load=1.1, tangential_amplitude=1
    ... )
    >>> p, q = load.path().at(load.path().cycle_start)  # the paper's point H
    >>> float(p), round(float(q), 12)
    (3.0, 0.1)
    """

    kind: Literal["ellipse"] = "ellipse"
    mean_normal_load: _MeanNormalLoad = Field(0.0, description=_DESCRIPTION_OF_MEAN_NORMAL_LOAD)
    normal_amplitude: float = Field(
        0.0, ge=0, description="P1, force per unit thickness (library: N/mm)"
    )
    mean_tangential_load: float = Field(
        0.0, description="Q0, force per unit thickness (library: N/mm)"
    )
    tangential_amplitude: float = Field(
        0.0, ge=0, description="Q1, force per unit thickness (library: N/mm)"
    )
    phase_degrees: float = Field(
        90.0, ge=-180, le=180, description="lag of Q behind P; positive goes round anticlockwise"
    )
    tangential_displacement: DrivenWave | None = Field(None, description=_DESCRIPTION_OF_U_ACT)
    approach: DrivenApproach | None = Field(None, description=_DESCRIPTION_OF_APPROACH)
    initial_loading: Literal["straight", "parabola"] | tuple[Point, ...] = Field(
        "straight",
        description=(
            "from (0, 0) to the cycle: straight, along the paper's parabola (tangent to the"
            " ellipse), or along [P, Q] points"
        ),
    )

    @model_validator(mode="after")
    def _require_loads_or_displacement(self) -> Self:
        """Return this load; refuse (ValueError) tangential loads beside a prescribed displacement,
        and a normal load that is neither stated nor replaced by an approach.
        """
        tangential_values = (
            self.mean_tangential_load,
            self.tangential_amplitude,
            self.phase_degrees,
        )
        # `is_driven`: a displacement is prescribed; (0, 0, 90) are the values of keys left out.
        if self.is_driven and tangential_values != (0.0, 0.0, 90.0):
            raise ValueError(
                "tangential_displacement stands in the place of mean_tangential_load,"
                " tangential_amplitude and phase_degrees: leave these out"
            )
        _require_load_or_approach(self, "normal_amplitude")
        return self

    @property
    def phase_radians(self) -> float:
        """Lag of Q behind P in radians."""
        return math.radians(self.phase_degrees)

    @property
    def phase(self) -> float:
        """`phase_radians` under its old name, for one release, with a DeprecationWarning."""
        warnings.warn(
            "EllipseLoad.phase, in radians, is the old name of phase_radians and leaves with the"
            " next release",
            DeprecationWarning,
            stacklevel=2,
        )
        return self.phase_radians

    def path_of_loads(self) -> LoadPath:
        """Load path of P and Q over time: initial loading, then one revolution of the ellipse,
        which begins where |Q - Q0| is largest while P grows.

        P = P0 + P1 cos t and Q = Q0 + Q1 cos(t - phase). Where actuators are prescribed, `approach`
        [length] stands in the place of P, and `tangential_displacement` [length] in that of Q: each
        holds its mean and amplitude.
        """
        # Mean and amplitude of the quantities in the places of Q and P; lag of the former [rad].
        tangential_mean = self.mean_tangential_load
        tangential_amplitude = self.tangential_amplitude
        phase_lag = self.phase_radians
        if (displacement := self.tangential_displacement) is not None:
            tangential_mean = displacement.mean
            tangential_amplitude = displacement.amplitude
            phase_lag = math.radians(displacement.phase_degrees)
        normal_mean = self.mean_normal_load
        normal_amplitude = self.normal_amplitude
        if self.approach is not None:
            normal_mean = self.approach.mean
            normal_amplitude = self.approach.amplitude

        # |Q - Q0| is largest at t = phase_lag and half a revolution later; P grows for
        # pi < t < 2 pi.
        start_time = phase_lag + math.pi if phase_lag >= 0 else phase_lag + 2 * math.pi

        # One revolution of the ellipse as a load segment.
        revolution = ellipse_segment(
            start_time,
            start_time + 2 * math.pi,
            (normal_mean, tangential_mean),
            (normal_amplitude, tangential_amplitude),
            phase_lag,
        )
        if self.initial_loading == "parabola":
            # A parabola in the P-Q plane from (0, 0), tangent to the ellipse: half a revolution
            # long.
            first_p, first_q = revolution.loads(start_time)
            first_loads = (float(first_p), float(first_q))
            # dQ/dP = 0 at its end: there Q is at an extreme of the ellipse.
            parabola = parabola_segment(start_time - math.pi, start_time, first_loads, 0.0)
            return LoadPath((parabola,), (revolution,))

        # Otherwise straight lines through the stated points, each over half a revolution.
        loading = straight_loading(self.initial_loading, revolution, math.pi)
        return LoadPath(loading, (revolution,))


class StraightLoad(BulkAndTilt[tuple[float, ...]]):
    """A load of straight lines, whose bulk stresses and tilts are straight between its vertices
    too.
    """

    rule_of_entries: ClassVar[str]
    """What the entries of a list of bulk stresses or tilts belong to, for messages."""

    @abc.abstractmethod
    def entries_of_vertices(self, n_vertices: int) -> tuple[Sequence[int], int]:
        """Index of the list entry that belongs to each vertex of the load path, -1 for a vertex
        whose value is 0; and index of the vertex up to which a single value grows with P.
        """

    def needed_entry_count(self, entry_indices: Sequence[int]) -> int:
        """How many entries a list must have."""
        return max(entry_indices) + 1

    def values_at_vertices(
        self,
        key_value: Any,
        normal_loads: NDArray[np.float64],
        value_at_cycle_start: float,  # noqa: ARG002 straight loads follow no formula
    ) -> NDArray[np.float64]:
        """Values (n,) of a bulk stress, tilt or moment at the n vertices of a load path of straight
        lines.

        Parameters
        ----------
        key_value
            what the scene states for the quantity: a number, which holds at all vertices of the
            cycle and grows in proportion to P before; a tuple with an entry for each vertex; or
            None for 0
        normal_loads
            (n,) P at the vertices, from 0 on
        value_at_cycle_start
            not used: no formula of time begins there

        Raises
        ------
        ValueError
            For a tuple of another length.
        """
        # Index of each vertex's entry in a tuple, -1 for a vertex of value 0; index of the vertex
        # at which the cycle starts. A load of 0 there is not divided by.
        entry_indices, cycle_start_vertex = self.entries_of_vertices(len(normal_loads))
        if not isinstance(key_value, tuple):
            load_over_load_at_cycle_start = normal_loads / (normal_loads[cycle_start_vertex] or 1.0)
            is_before_cycle = np.arange(len(normal_loads)) < cycle_start_vertex
            return (key_value or 0.0) * np.where(
                is_before_cycle, load_over_load_at_cycle_start, 1.0
            )

        # `rule_of_entries`: words for the message on what the entries belong to.
        n_needed_entries = self.needed_entry_count(entry_indices)
        if len(key_value) != n_needed_entries:
            raise ValueError(
                f"a bulk stress or tilt has {len(key_value)} values, and {n_needed_entries} are"
                f" needed, {self.rule_of_entries}"
            )
        return np.array([key_value[k] if k >= 0 else 0.0 for k in entry_indices])


class PolygonLoad(StraightLoad):
    """Straight lines in the P-Q plane, one unit of time each: from (0, 0) along `initial_loading`,
    then `cycle` and back.

    The cycle starts at the last point of the initial loading, not repeated in `cycle`; an empty
    cycle is a path that just ends. A point may stand twice in a row where the lists of bulk stress
    or tilt change from one to the other.

    >>> load = PolygonLoad(initial_loading=[(2, 0)], cycle=[(2, 1), (2, -1)])
    >>> [float(v) for v in load.path().at(1.5)], load.path().period
    ([2.0, 0.5], 3.0)
    """

    kind: Literal["polygon"] = "polygon"
    initial_loading: tuple[Point, ...] = Field(
        min_length=1, description="[P, Q] points after (0, 0) (library: N/mm)"
    )
    cycle: tuple[Point, ...] = Field(
        (),
        description=(
            "[P, Q] points after the last one of the initial loading, force per unit thickness"
            " (library: N/mm)"
        ),
    )
    times: tuple[float, ...] | None = Field(
        None,
        description=(
            "ascending times of (0, 0), of each point, and of the return where there is a cycle;"
            " 0, 1, 2, ... if left out (library: s)"
        ),
    )
    tangential_displacement: bool = Field(False, description=_DESCRIPTION_OF_U_ACT_FLAG)
    approach: bool = Field(False, description=_DESCRIPTION_OF_APPROACH_FLAG)

    rule_of_entries = "one for each point of initial_loading and cycle"

    def entries_of_vertices(self, n_vertices: int) -> tuple[Sequence[int], int]:
        """Index of the list entry that belongs to each of the `n_vertices` vertices of the
        polygon, -1 for (0, 0); and index of the vertex at which the cycle starts.
        """
        cycle_start_vertex = len(self.initial_loading)
        # -1 for (0, 0); the return to the start of the cycle has the entry of that start.
        entry_indices = [*range(-1, cycle_start_vertex + len(self.cycle)), cycle_start_vertex - 1]
        return entry_indices[:n_vertices], cycle_start_vertex

    @model_validator(mode="after")
    def _require_distinct_vertices(self) -> Self:
        """Return this polygon of loads; refuse (ValueError) two successive vertices with equal
        loads, bulk stresses and tilt, since nothing happens between them.

        Where the scene states the times of the vertices, equal ones are a rest, which is allowed;
        the times are checked instead.
        """
        _require_displacement_beside_approach(self)
        if self.times is not None:
            self._check_times(self.times)
            return self
        # `is_driven`: a displacement is prescribed in the place of Q.
        path = self.path_of_actuators() if self.is_driven else self.path()
        for segment in (*path.initial_loading, *path.cycle):
            times_of_ends = np.array([segment.start, segment.end])
            # (P, Q), both bulk stresses, and tilt and moment, at both ends of each line.
            end_values_of_pairs = [
                segment_of_pair.loads(times_of_ends)
                for segment_of_pair in (segment, segment.bulk, segment.tilt_and_moment)
                if segment_of_pair is not None
            ]
            if all(
                value_at_begin == value_at_end
                for end_values in end_values_of_pairs
                for value_at_begin, value_at_end in end_values
            ):
                # BULK_AND_TILT_KEYS: keys of both bulk stresses, tilt, moment and line of action
                has_lists = any(isinstance(getattr(self, key), tuple) for key in BULK_AND_TILT_KEYS)
                remark = " with the same bulk stress and tilt" if has_lists else ""
                point = [float(load) for load in segment.loads(segment.start)]
                raise ValueError(f"the point {point} stands twice in a row{remark}: leave one out")
        return self

    @property
    def _vertices(self) -> list[Point]:
        """(P, Q) at the vertices of the load path, with (0, 0) first and, where there is a cycle,
        the return to its start last.
        """
        return [
            (0.0, 0.0),
            *self.initial_loading,
            *self.cycle,
            *(self.initial_loading[-1:] if self.cycle else ()),
        ]

    def _check_times(self, times: tuple[float, ...]) -> None:
        """Refuse times of the vertices of a polygon that are too few, too many, or do not ascend
        (ValueError). Two vertices with equal loads and different times are a rest.

        `times` are those of (0, 0), of each point, and of the return where there is a cycle.
        """
        n_vertices = len(self._vertices)
        if len(times) != n_vertices:
            raise ValueError(
                f"times has {len(times)} entries, and {n_vertices} are needed: of (0, 0), of each"
                " point of initial_loading and cycle, and of the return where there is a cycle"
            )
        for time_before, time_after in pairwise(times):
            if not time_before < time_after:
                raise ValueError(
                    f"times: {time_after:.12g} comes after {time_before:.12g}: they must ascend"
                )

    def path_of_loads(self) -> LoadPath:
        """Load path of P and Q over time along the polygon's vertices: initial loading, then the
        cycle.
        """
        vertices = self._vertices
        times = self.times or tuple(float(k) for k in range(len(vertices)))
        times_and_loads = [(time, *vertex) for time, vertex in zip(times, vertices, strict=True)]
        segments = straight_segments(times_and_loads)
        n_initial_segments = len(self.initial_loading)
        return LoadPath(segments[:n_initial_segments], segments[n_initial_segments:])


def _require_load_or_approach(load: EllipseLoad | HarmonicLoad, variation_key: str) -> None:
    """Refuse keys of a cyclic load path by which P is not stated in exactly one way (ValueError):
    by its mean, or by an approach beside a tangential displacement.

    Parameters
    ----------
    load
        the keys: `mean_normal_load` is the mean of P, 0 if not stated; `approach` is None if not
        stated; `is_driven` is true where a tangential displacement stands in the place of Q
    variation_key
        key of what is added to the mean of P: its amplitude or its harmonics
    """
    if load.approach is None:
        if not load.mean_normal_load:
            raise ValueError(
                "mean_normal_load is missing: state it, above 0, or the approach in the place of P"
            )
        return
    if not load.is_driven:
        raise ValueError(
            "approach goes with tangential_displacement: state that too, with mean = 0 alone where"
            " nothing moves along the faces"
        )
    if load.mean_normal_load or getattr(load, variation_key):
        raise ValueError(
            f"approach stands in the place of mean_normal_load and {variation_key}: leave these out"
        )
    if not load.approach.mean > 0:
        raise ValueError(
            f"approach.mean = {load.approach.mean:g}: the bodies are to touch; state it above 0"
        )


def _require_displacement_beside_approach(load: PolygonLoad | TimeSeriesLoad) -> None:
    """ValueError for an approach beside a tangential load."""
    if load.approach and not load.tangential_displacement:
        raise ValueError(
            "approach goes with tangential_displacement: write tangential_displacement = true, and"
            " 0 for U where nothing moves along the faces"
        )


def _in_radians(harmonics: tuple[Harmonic, ...]) -> tuple[tuple[float, float], ...]:
    """Amplitude and phase of each harmonic, whose phase is in degrees."""
    return tuple((amplitude, math.radians(phase)) for amplitude, phase in harmonics)


class HarmonicLoad(CyclicLoad[WaveSum]):
    """P = P0 + sum over k of P_k cos(k t - phi_k), Q likewise; a revolution takes 2 pi and starts
    at t = 0.

    >>> load = HarmonicLoad(
    ...     mean_normal_load=3,
    ...     normal_harmonics=[(1, 0)],
    ...     tangential_harmonics=[(0.5, 90), (0.25, 0)],
    ... )
    >>> p, q = load.path().at(0.0)
    >>> float(p), round(float(q), 12)
    (4.0, 0.25)
    """

    kind: Literal["harmonics"] = "harmonics"
    mean_normal_load: _MeanNormalLoad = Field(0.0, description=_DESCRIPTION_OF_MEAN_NORMAL_LOAD)
    mean_tangential_load: float = Field(
        0.0, description="Q0, force per unit thickness (library: N/mm)"
    )
    normal_harmonics: tuple[Harmonic, ...] = Field(
        (), description="[P_k, phi_k] of k = 1, 2, ... (library: N/mm, degrees)"
    )
    tangential_harmonics: tuple[Harmonic, ...] = Field(
        (), description="[Q_k, phi_k] of k = 1, 2, ... (library: N/mm, degrees)"
    )
    tangential_displacement: DrivenWaveSum | None = Field(None, description=_DESCRIPTION_OF_U_ACT)
    approach: DrivenWaveSum | None = Field(None, description=_DESCRIPTION_OF_APPROACH)
    initial_loading: InitialLoading = Field(
        "straight",
        description="from (0, 0) to the cycle: straight, or along [P, Q] points",
    )

    @model_validator(mode="after")
    def _require_loads_or_displacement(self) -> Self:
        """Return this load; refuse (ValueError) tangential loads beside a prescribed displacement,
        and a normal load that is neither stated nor replaced by an approach.
        """
        # `is_driven`: a displacement is prescribed in the place of Q.
        if self.is_driven and (self.mean_tangential_load or self.tangential_harmonics):
            raise ValueError(
                "tangential_displacement stands in the place of mean_tangential_load and"
                " tangential_harmonics: leave these out"
            )
        _require_load_or_approach(self, "normal_harmonics")
        return self

    def path_of_loads(self) -> LoadPath:
        """Load path of P and Q over time: initial loading, then one cycle of the harmonics, from
        time 0 to 2 pi.

        Harmonics are pairs (amplitude, phase lag in degrees) of k = 1, 2, ... Where actuators are
        prescribed, `approach` [length] stands in the place of P, and `tangential_displacement`
        [length] in that of Q: each holds its mean and harmonics.
        """
        tangential_mean = self.mean_tangential_load
        tangential_harmonics = self.tangential_harmonics
        if (displacement := self.tangential_displacement) is not None:
            tangential_mean = displacement.mean
            tangential_harmonics = displacement.harmonics
        normal_mean = self.mean_normal_load
        normal_harmonics = self.normal_harmonics
        if self.approach is not None:
            normal_mean = self.approach.mean
            normal_harmonics = self.approach.harmonics
        cycle = HarmonicSegment(
            0.0,
            2 * math.pi,
            (normal_mean, tangential_mean),
            _in_radians(normal_harmonics),
            _in_radians(tangential_harmonics),
        )
        # Each line of the initial loading takes half a cycle.
        return LoadPath(straight_loading(self.initial_loading, cycle, math.pi), (cycle,))

    def in_words(self, unit: str) -> str:
        """Describe the load for the user: how many harmonics P and Q have, and their means."""
        return (
            f"the loads hold {len(self.normal_harmonics)} and {len(self.tangential_harmonics)}"
            f" harmonics about P = {self.mean_normal_load:.6g}, Q = {self.mean_tangential_load:.6g}"
            f" {unit}"
        )


T = TypeVar("T")


class OfLoads(Frozen, Generic[T]):
    """One of each column of a record; what is left out is not stated."""

    time: T | None = None
    P: T | None = None
    Q: T | None = None
    U: T | None = None
    approach: T | None = None
    bulk_stress_lower: T | None = None
    bulk_stress_upper: T | None = None
    tilt: T | None = None
    moment: T | None = None


class Threshold(Frozen):
    """Of a record that is reduced: one number of each load."""

    P: float = Field(0.0, ge=0, description="of P, force per unit thickness (library: N/mm)")
    Q: float = Field(0.0, ge=0, description="of Q, force per unit thickness (library: N/mm)")


class RecordRow(Frozen):
    """A row of a record by its number."""

    row: int = Field(ge=1, description="number of the row of numbers, from 1 on")


_ADVICE_ON_TIMES = (
    "; where they have too few digits, state interval, the time from row to row; where a second"
    " test follows, leave it out by end"
)


class TimeSeriesLoad(StraightLoad, FromFile):
    """Rows of time, P and Q joined by straight lines; before the first row a straight line from (0,
    0), unless it is (0, 0) itself.

    With `repeats` the rows are one cycle, which must end with the loads that it starts with. With
    `reduce` the path goes through some of the rows only: `series` has them, `rows` all.

    >>> load = TimeSeriesLoad(rows=[[0, 2, 0], [1, 2, 1], [3, 2, 0]])
    >>> [float(v) for v in load.path().at(2.0)], load.path().start
    ([2.0, 0.5], -1.5)
    """

    key_of_rows = "rows"
    quantities: ClassVar[dict[str, Kind]] = {"time": "time", "P": "load", "Q": "load"}
    optional_column_kinds: ClassVar[dict[str, Kind]] = {
        "bulk_stress_lower": "stress",
        "bulk_stress_upper": "stress",
        "tilt": "angle",
        "moment": "moment",
    }

    kind: Literal["time_series"] = "time_series"
    file: str | None = Field(
        None, description="text table with the columns time, P, Q; path relative to the scene file"
    )
    rows: Table = Field(
        default_factory=Table.before_reading,
        description=(
            "the rows themselves, [time, P, Q] each, in place of a file (library: s, N/mm, N/mm)"
        ),
    )
    tangential_displacement: bool = Field(False, description=_DESCRIPTION_OF_U_ACT_FLAG)
    approach: bool = Field(False, description=_DESCRIPTION_OF_APPROACH_FLAG)
    repeats: bool = Field(False, description="whether the rows are one cycle that repeats")
    columns: OfLoads[str | int] | None = Field(None, description=DESCRIPTION_OF_COLUMNS)
    units: OfLoads[str] | None = Field(None, description=DESCRIPTION_OF_UNITS)
    thickness: Positive | None = Field(
        None,
        description=(
            "of the contact out of the plane, by which forces of the file are divided, length"
            " units (library: mm)"
        ),
    )
    interval: Positive | None = Field(
        None,
        description=("time from row to row of a file, in place of a column of times (library: s)"),
    )
    constant_normal_load: Positive | None = Field(
        None,
        description=(
            "P of all rows of a file, in place of a column, force per unit thickness (library:"
            " N/mm)"
        ),
    )
    scale: OfLoads[Positive] | None = Field(None, description=DESCRIPTION_OF_SCALE)
    zero: OfLoads[float] | None = Field(None, description=DESCRIPTION_OF_ZERO)
    sign: OfLoads[Literal[1, -1]] | None = Field(
        None, description="-1 turns a column, such as P of a cell that counts tension"
    )
    read_as: ReadAs | None = Field(None, description=DESCRIPTION_OF_READ_AS)
    start: float | RecordRow | None = Field(
        None,
        description=(
            "first row that counts: its time, or {row = 10}; the record's if left out (library: s)"
        ),
    )
    end: float | RecordRow | None = Field(
        None,
        description=(
            "last row that counts: its time, or {row = 900}; the record's if left out (library: s)"
        ),
    )
    least_normal_load: Positive | None = Field(
        None,
        description=(
            "P below which rows are noise: Q counts as 0 there, and rows before the first that"
            " reaches it as initial loading at Q = 0, force per unit thickness (library: N/mm)"
        ),
    )
    average: int = Field(
        1, ge=1, description="how many neighbouring rows one mean stands for: it takes noise out"
    )
    reduce: Reduction | None = Field(
        None,
        description=(
            "rows that the path goes through: turning_points of P or Q above the threshold, or as"
            " few as keep it within the threshold as a tolerance; without, all"
        ),
    )
    threshold: Threshold | None = Field(
        None,
        description=(
            "of turning_points the largest swing that is left out, of tolerance the largest"
            " distance in P and in Q"
        ),
    )

    @property
    def column_kinds(self) -> dict[str, Kind]:
        """The columns that are read from a file."""
        kinds = dict(self.quantities)
        if self.tangential_displacement:
            kinds = {"time": "time", "P": "load", "U": "length"}
        if self.approach:
            kinds = {"time": "time", "approach": "length", "U": "length"}
        for name in self._stated_quantities:
            kinds.pop(name, None)
        return kinds

    @property
    def _stated_quantities(self) -> dict[str, float]:
        """Quantities that are stated in place of a column."""
        stated_values = {"time": self.interval, "P": self.constant_normal_load}
        return {name: value for name, value in stated_values.items() if value is not None}

    def _table_of(
        self, path: Path, quantities: tuple[str, ...], stated_columns: Frozen | None
    ) -> TextTable:
        """Table of the columns of a record that are read from the file at `path`: one column for
        each of the `quantities`.

        `stated_columns` is the scene's key `columns`: headings, or numbers from 1, of the columns
        that the user names.

        Raises
        ------
        InputError
            For columns that are missing, with keys of the scene that can stand in their place; and
            for a constant normal load beside an approach, since both stand in the place of P.
        """
        from scenes.text_tables import MissingColumnError  # only a load from a file needs it

        # `approach`: true where the file has a normal actuator's approach in the place of P.
        if self.approach and self.constant_normal_load is not None:
            raise InputError(
                "approach stands in the place of P: leave out constant_normal_load, or approach"
            )
        try:
            return super()._table_of(path, quantities, stated_columns)
        except MissingColumnError as fault:
            raise InputError(f"{fault}{self._advice_on_missing_columns(fault)}") from fault

    def _advice_on_missing_columns(self, fault: MissingColumnError) -> str:
        """Advice for the message on columns that a measured file lacks: keys of the scene that can
        stand in their place. Empty where there are no such keys, or the file has none of the
        columns.

        `fault` holds the missing `columns`, such as "time", "P" and "Q", and the `headings` of the
        file. `approach` is true where a normal actuator's approach is prescribed in the place of P.
        """
        missing_names = set(fault.columns)
        # `column_kinds`: the columns that the file must have.
        if missing_names == set(self.column_kinds):
            return ""
        # Headings under which files state a tangential displacement U, in a common spelling.
        headings_of_displacement = {normalised_name(alias) for alias in aliases_of("U")}
        has_displacement = any(
            normalised_name(heading) in headings_of_displacement for heading in fault.headings
        )
        proposals = []
        if "time" in missing_names:
            proposals.append("interval = 0.01, the time from row to row, where it has no times")
        if "P" in missing_names and not self.approach:
            proposals.append(
                "constant_normal_load = 100.0 (a force per thickness), where P was constant and"
                " not recorded"
            )
        if "Q" in missing_names and has_displacement:
            proposals.append("tangential_displacement = true, where the rig prescribed U")
        return "".join(f"; or {proposal}" for proposal in proposals)

    def _stated_quantities_in_words(self) -> list[tuple[str, str]]:
        """(quantity, sentence part on its value) for the time and P where the scene states them in
        place of columns: `interval` is the time from row to row, `constant_normal_load` P of all
        rows.
        """
        descriptions: list[tuple[str, str]] = []
        if self.interval is not None:
            interval_text = f"{self.interval:.9g}"
            descriptions.append(("time", f"no column: {interval_text} from row to row (interval)"))
        if self.constant_normal_load is not None:
            normal_load_text = f"{self.constant_normal_load:.9g}"
            descriptions.append(
                ("P", f"no column: {normal_load_text} in every row (constant_normal_load)")
            )
        return descriptions

    def _with_stated_quantities(self, values: Array) -> Array:
        """Rows of the record from the m columns of its file, `values` (n, m), with a column
        inserted for each quantity that the scene states in its place: a constant P
        (`constant_normal_load`), and times from the time between two rows (`interval`).
        """
        if self.constant_normal_load is not None:
            # P comes after the times, which are put before it below where the file has none.
            column_of_p = 0 if self.interval is not None else 1
            values = np.insert(values, column_of_p, self.constant_normal_load, axis=1)
        if self.interval is not None:
            values = np.insert(values, 0, self.interval * np.arange(len(values)), axis=1)
        return values

    @model_validator(mode="after")
    def _require_unreduced_displacement(self) -> Self:
        """Return this record; refuse (ValueError) keys of means or reduction beside a prescribed
        displacement, and an approach without one.
        """
        _require_displacement_beside_approach(self)
        # `is_driven`: a displacement is prescribed; `average`: number of rows of one mean
        reduces_rows = self.reduce is not None or self.least_normal_load is not None
        if self.is_driven and (self.average > 1 or reduces_rows):
            raise ValueError(
                "average, reduce and least_normal_load go with records of P and Q: leave them out"
                " beside tangential_displacement"
            )
        return self

    @model_validator(mode="after")
    def _require_useful_reduction_keys(self) -> Self:
        """Return this record of loads; refuse (ValueError) keys that reduce it, where they have no
        effect or contradict other keys.

        `average` is the number of neighbouring rows of one mean, `reduce` how rows are chosen,
        `threshold` the swing or tolerance (P, Q) of that choice. `least_normal_load` is the P below
        which rows are noise. `repeats`: the rows are one cycle; `has_bulk_or_tilt`: bulk stress,
        tilt or moment are stated.
        """
        if self.threshold is not None and self.reduce is None:
            raise ValueError(
                'threshold has a use with reduce = "turning_points" or reduce = "tolerance" only:'
                " add one of them"
            )
        if self.average > 1 and self.repeats:
            raise ValueError(
                "average goes with records that do not repeat: means have no row at which the cycle"
                " closes"
            )
        if self.least_normal_load is not None and (self.repeats or self.has_bulk_or_tilt):
            raise ValueError(
                "least_normal_load goes with records of P and Q alone that do not repeat: leave it"
                " out, and cut the noise by start and end"
            )
        # `used_rows`: the rows from the keys `start` to `end`
        if self.average > 1 and (n_used_rows := len(self.used_rows())) < 2 * self.average:
            raise ValueError(
                f"average = {self.average} leaves one of {n_used_rows} rows: two at least are"
                " needed"
            )
        if self.has_bulk_or_tilt and (self.average > 1 or self.reduce is not None):
            raise ValueError(
                "average and reduce go with records of P and Q alone: leave them out beside bulk"
                " stress or tilt"
            )
        if self.reduce == "tolerance" and (
            self.threshold is None or not max(self.threshold.P, self.threshold.Q)
        ):
            raise ValueError('reduce = "tolerance" needs a threshold, such as {P = 1.0, Q = 0.5}')
        return self

    def check_rows(self) -> None:
        """Refuse rows between the keys `start` and `end` that are no record of time, P and Q.

        Rows are (time, P, Q). With `repeats` they are one cycle. `least_normal_load` is the P below
        which rows are noise.

        Raises
        ------
        RowError
            With the first row at fault: not three numbers (time, P, Q), too few rows, times that do
            not ascend, no row that reaches the least normal load, a cycle that starts unloaded or
            does not close.
        """
        rows = self.rows.values
        if rows.shape[1] != 3:
            raise RowError(0, f"three numbers (time, P, Q) are needed, not {rows.shape[1]}")
        if len(rows) < 2:
            raise RowError(0, "one row is no history: two at least are needed")

        # Numbers, from 0, of the first row used and of the one after the last.
        first_row, row_after_last = self.row_bounds()
        if row_after_last - first_row < 2:
            raise RowError(
                min(first_row, len(rows) - 1),
                f"start and end leave {max(row_after_last - first_row, 0)} rows: two at least are"
                " needed",
            )
        # `RowError.refuse` raises for the first row k at which the condition holds.
        # _ADVICE_ON_TIMES: end of the sentence, what to do about times of a file
        times = rows[:, 0]
        advice_on_times = _ADVICE_ON_TIMES if self.file is not None else ""

        def fault_of_time(k: int) -> str:
            """Sentence on row k, whose time is that of the row before, or an earlier one."""
            is_earlier = times[k] < times[k - 1]
            fault_text = "comes after a later one" if is_earlier else "stands there twice"
            return f"time = {times[k]:.12g} {fault_text}: the times must ascend{advice_on_times}"

        RowError.refuse(np.diff(times[first_row:row_after_last]) <= 0, fault_of_time, first_row + 1)

        if self.least_normal_load is not None and not np.any(
            rows[first_row:row_after_last, 1] >= self.least_normal_load
        ):
            highest_load = float(np.max(rows[first_row:row_after_last, 1]))
            raise RowError(
                first_row,
                f"no row reaches least_normal_load = {self.least_normal_load:.6g}: P is"
                f" {highest_load:.6g} at most",
            )
        if self.repeats and not np.any(rows[first_row, 1:]):
            raise RowError(
                first_row,
                "a cycle that repeats can't start unloaded: its first row is where the initial"
                " loading ends",
            )
        if self.repeats and np.any(rows[first_row, 1:] != rows[row_after_last - 1, 1:]):
            raise RowError(
                row_after_last - 1, "a cycle that repeats must end with the loads of its first row"
            )

    def row_bounds(self) -> tuple[int, int]:
        """Numbers, from 0, of the first row of the record that is used and of the one after the
        last, by the keys `start` and `end`.

        Each key is a time, or the number of a row from 1. The rows at both are used too; a key that
        is not stated leaves out no row.
        """
        times = self.rows.values[:, 0]
        # `argmax` finds the first True: at the True behind the last row where no time satisfies.
        first_row = 0
        row_after_last = len(self.rows)
        if isinstance(self.start, RecordRow):
            first_row = self.start.row - 1
        elif self.start is not None:
            first_row = int(np.argmax(np.append(times >= self.start, True)))
        if isinstance(self.end, RecordRow):
            row_after_last = min(self.end.row, row_after_last)
        elif self.end is not None:
            row_after_last = len(times) - int(np.argmax(np.append(times[::-1] <= self.end, True)))
        return first_row, row_after_last

    def used_rows(self) -> Table:
        """Rows (n, 3) of time, P and Q of the record from the keys `start` to `end`, with noise at
        small loads removed.

        Where a least normal load is stated, rows below it get Q = 0 and P not below 0. All but the
        last of those before the first loaded row are dropped, and that one gets the least load.

        >>> noisy = [[0, 0.1, -0.9], [1, 0.3, 0.7], [2, 50, 1], [3, 100, 30], [4, 0.2, -0.5]]
        >>> TimeSeriesLoad(rows=noisy, least_normal_load=5.0).used_rows().values.tolist()
        [[1.0, 5.0, 0.0], [2.0, 50.0, 1.0], [3.0, 100.0, 30.0], [4.0, 0.2, 0.0]]
        """
        # Numbers, from 0, of the first row used and of the one after the last.
        first_row, row_after_last = self.row_bounds()
        if self.least_normal_load is None:
            if (first_row, row_after_last) == (0, len(self.rows)):
                return self.rows
            return Table.of_rows(self.rows.values[first_row:row_after_last])
        # Columns: time, P, Q.
        rows_between = self.rows.values[first_row:row_after_last].copy()
        is_below_least = rows_between[:, 1] < self.least_normal_load
        rows_between[is_below_least, 1] = np.maximum(rows_between[is_below_least, 1], 0.0)
        rows_between[is_below_least, 2] = 0.0
        # How many rows come before the first loaded one: of these only the last stays.
        n_rows_before_loaded = int(np.argmin(is_below_least))
        if n_rows_before_loaded > 0:
            rows_between = rows_between[n_rows_before_loaded - 1 :]
            rows_between[0, 1] = self.least_normal_load
        return Table.of_rows(rows_between)

    def kept_rows(self) -> NDArray[np.float64]:
        """Rows (m, 3) of time, P and Q that the load path goes through: the used rows after means
        and reduction.
        """
        rows = self.used_rows()
        if self.average == 1 and self.reduce is None:
            return rows.values
        threshold = self.threshold or Threshold()
        return reduced_record(rows, self.average, self.reduce, threshold.P, threshold.Q)

    def series(self) -> NDArray[np.float64]:
        """Load series (n, 3) of time, P and Q: the rows that the load path goes through.

        1. The rows of the record from the keys `start` to `end` are taken.
        2. Where a least normal load is stated, rows below it get Q = 0.
        3. Every `average` rows are replaced by their mean.
        4. `reduce` leaves out rows that change the path little: see `reduced_record`.
        5. A record that starts loaded gets a row P = Q = 0 before.

        Raises
        ------
        InputError
            Where a displacement is prescribed (`is_driven`): the loads follow from the contact.
        """
        # REFUSAL_OF_DISPLACEMENTS: a sentence, that loads are needed here
        if self.is_driven:
            raise InputError(REFUSAL_OF_DISPLACEMENTS)
        return self._rows_from_rest()

    def _rows_from_rest(self) -> NDArray[np.float64]:
        """Rows (n, 3) that the path goes through, from (0, 0) on: time, P or the approach, Q or the
        displacement U. Before rows that start loaded (0, 0) is put, by the mean time from row to
        row.
        """
        rows = self.kept_rows()
        if not np.any(rows[0, 1:]):
            return rows
        mean_interval = (rows[-1, 0] - rows[0, 0]) / (len(rows) - 1)
        return np.concatenate([[[rows[0, 0] - mean_interval, 0.0, 0.0]], rows])

    rule_of_entries = "one for each row"

    def entries_of_vertices(self, n_vertices: int) -> tuple[Sequence[int], int]:
        """Index of the list entry (row of the record) that belongs to each of the `n_vertices`
        vertices of the load path; -1 for a vertex at (0, 0) before the rows. Second, the number 1:
        the index of the vertex up to which a single value grows with P.
        """
        first_row, row_after_last = self.row_bounds()
        # 1 where a line from (0, 0) comes before the rows, else 0
        n_vertices_before = n_vertices - (row_after_last - first_row)
        return [*[-1] * n_vertices_before, *range(first_row, row_after_last)], 1

    def needed_entry_count(self, entry_indices: Sequence[int]) -> int:  # noqa: ARG002
        return len(self.rows)

    def path_of_loads(self) -> LoadPath:
        """Load path of straight lines through the rows of the record, from (0, 0) on; with
        `repeats` all but the first line are the cycle.
        """
        segments = straight_segments(self._rows_from_rest().tolist())
        return LoadPath(segments[:1], segments[1:]) if self.repeats else LoadPath(segments, ())

    def in_words(self, unit: str) -> str:
        """Describe a record of loads for the user: how many of its rows the load path goes through,
        by which reduction, and the ranges of P and Q in their `unit`.

        Of the record's `rows` some are used, after cuts at its ends. `average` is the number of
        rows of one mean, 1 for none; `reduce` is "turning_points", "tolerance" or None, `threshold`
        its limits in P and Q.
        """
        used_rows = self.used_rows().values
        # Of time, P and Q.
        least_values = np.min(used_rows, axis=0)
        largest_values = np.max(used_rows, axis=0)
        repetition_text = ", again and again" if self.repeats else ""
        rows_text = f"{len(self.rows)} rows of a record"
        if len(used_rows) != len(self.rows):
            rows_text = f"{len(used_rows)} of the {rows_text}"
        if self.average > 1 or self.reduce is not None:
            rows_text = f"{len(self.kept_rows())} of the {rows_text}"
        rows_text += f", means of {self.average} each" if self.average > 1 else ""
        threshold = self.threshold or Threshold()
        if self.reduce == "turning_points":
            rows_text += (
                f", turning points with swings above {threshold.P:.6g} in P or"
                f" {threshold.Q:.6g} in Q"
            )
        elif self.reduce == "tolerance":
            rows_text += (
                f", which pass the others within {threshold.P:.6g} in P and {threshold.Q:.6g} in Q"
            )
        ranges_text = (
            f"P goes from {least_values[1]:.6g} to {largest_values[1]:.6g} and Q from"
            f" {least_values[2]:.6g} to {largest_values[2]:.6g}"
            f" {unit}"
        )
        return f"the loads follow {rows_text}. {ranges_text}{repetition_text}"


class CallableLoad(BulkAndTilt[PythonFunction]):
    """P and Q given by Python functions of time on 0 <= time <= duration; corners are found, jumps
    refused.

    >>> import math
    >>> load = CallableLoad(
    ...     normal_load=lambda t: 2 + math.cos(t),
    ...     tangential_load=math.sin,
    ...     duration=2 * math.pi,
    ...     repeats=True,
    ... )
    >>> [round(float(v), 12) for v in load.path().at(math.pi / 2)]
    [2.0, 1.0]
    """

    kind: Literal["callable"] = "callable"
    normal_load: PythonFunction = Field(
        description="P(time), force per unit thickness (library: N/mm)"
    )
    tangential_load: PythonFunction = Field(
        description="Q(time), force per unit thickness (library: N/mm)"
    )
    duration: Positive = Field(
        description=(
            "time that the functions cover, one cycle if it repeats, any time unit (library: s)"
        )
    )
    repeats: bool = Field(False, description="whether the functions are one cycle that repeats")
    initial_loading: InitialLoading = Field(
        "straight",
        description="from (0, 0) to the loads at time 0: straight, or along [P, Q] points",
    )

    @model_validator(mode="after")
    def _require_continuous_loads(self) -> Self:
        """Return this load; refuse (ValueError with time and values) functions of time whose P or Q
        jumps, also from the end of a cycle that repeats to its begin.
        """
        # Successive segments of the load history, each smooth, and the one after each: after the
        # last one of a cycle the first again. `duration`: time that the functions cover.
        segments = self._segments()
        next_segments = [
            *segments[1:],
            *([segments[0].shifted(self.duration)] if self.repeats else []),
        ]
        for segment, next_segment in zip(segments, next_segments, strict=False):
            loads_before = segment.loads(segment.end)
            loads_after = next_segment.loads(next_segment.start)
            for name, value_before, value_after in zip(
                ("normal_load", "tangential_load"), loads_before, loads_after, strict=True
            ):
                # A jump exceeds 1e-9 of P: smaller ones may be errors of the series.
                if abs(float(value_before - value_after)) > 1e3 * _ROUND_OFF_LOAD_SHARE * max(
                    abs(float(loads_before[0])), abs(float(loads_after[0]))
                ):
                    raise ValueError(
                        f"{name} jumps from {float(value_before):.6g} to {float(value_after):.6g}"
                        f" at time {segment.end:.6g}"
                    )
        return self

    def _segments(self) -> list[ChebyshevSegment]:
        """Load segments of P and Q, given as functions of time, by Chebyshev series on successive
        intervals of time.

        The intervals are short enough also for bulk stresses and tilt that are functions. They end
        where any of the functions has a corner, a jump of its rate.

        Raises
        ------
        ValueError
            For a function that is not finite, or too rough for its series.
        """
        # 65 times, from 0 to the duration of the functions.
        sample_times = np.linspace(0, self.duration, 65)
        functions = self._finite_functions(sample_times)
        # The value against which errors of a function are small: its own largest one, for Q that of
        # P.
        error_scales = {
            name: float(np.max(np.abs(function(sample_times))))
            for name, function in functions.items()
        }
        load_scale = error_scales["normal_load"]
        error_scales["tangential_load"] = load_scale
        # Not at simple fractions of the duration, where a function of few periods has its corners:
        # a corner is to lie inside an interval, and is located there.
        interval_ends = self.duration * np.array([0.0, 0.23, 0.47, 0.74, 1.0])
        # Halve the intervals until a Chebyshev series is accurate on each. Two passes over the
        # functions, so that the corners of each are ends of intervals for all.
        for name, function in [*functions.items()] * 2:
            try:
                interval_ends = piecewise_series_of(
                    function, interval_ends, error_scales[name] or 1.0
                ).interval_ends
            except UnresolvedError as fault:
                cause = "not finite, or it jumps or swings too fast"
                raise ValueError(
                    f"{name} is too rough between time {fault.low:.6g} and {fault.high:.6g}:"
                    f" {cause}"
                ) from fault
        # One segment on each interval.
        load_functions = [functions["normal_load"], functions["tangential_load"]]
        return [
            _chebyshev_segment(begin, end, load_functions, load_scale)
            for begin, end in pairwise(interval_ends.tolist())
        ]

    def _finite_functions(self, sample_times: Array) -> dict[str, Callable[[Array], Array]]:
        """Functions of time of this load by their keys, P and Q first, then bulk stresses, tilt or
        moment that are functions: each from an array of times to an array of values.

        ValueError for a function that is not finite at one of the `sample_times`.
        """
        functions = {
            "normal_load": function_of_arrays(self.normal_load),
            "tangential_load": function_of_arrays(self.tangential_load),
        }
        # BULK_AND_TILT_KEYS: keys of both bulk stresses, tilt, moment and line of action
        for key in BULK_AND_TILT_KEYS:
            key_value = getattr(self, key)
            if callable(key_value):
                functions[key] = function_of_arrays(key_value)
        for name, function in functions.items():
            is_not_finite = ~np.isfinite(function(sample_times))
            if np.any(is_not_finite):
                raise ValueError(
                    f"{name} is not finite at time {sample_times[is_not_finite][0]:.6g}"
                )
        return functions

    def path_of_loads(self) -> LoadPath:
        """Load path of P and Q over time: initial loading, unless P and Q start at 0, then their
        functions of time, as a cycle where they repeat.

        Functions that start at 0 and do not repeat get an initial loading only where points are
        stated for it.
        """
        segments = tuple(self._segments())
        first_load_sizes = np.abs(segments[0].loads(0.0))
        last_load_sizes = np.abs(segments[-1].loads(self.duration))
        # Loads at time 0 count as 0 below 1e-12 of those at the end.
        starts_loaded = np.max(first_load_sizes) > _ROUND_OFF_LOAD_SHARE * np.max(last_load_sizes)

        # Each line of the initial loading takes half the duration of the functions.
        initial_loading: tuple[LoadSegment, ...] = ()
        if self.repeats or self.initial_loading != "straight" or starts_loaded:
            initial_loading = straight_loading(self.initial_loading, segments[0], self.duration / 2)
        if self.repeats:
            return LoadPath(initial_loading, segments)
        return LoadPath((*initial_loading, *segments), ())

    def formula_segments(self, path: LoadPath, key_values: Pair) -> Sequence[LoadSegment]:
        """Two quantities over time beside P and Q, such as both bulk stresses: segments of
        Chebyshev series, over the same times as the segments of the load `path` from time 0 on.

        `key_values` are what the scene states for the two: functions of time, numbers, or None
        for 0.
        """

        def as_function(key_value: Any) -> Callable[[Any], Any]:
            """A function from an array of times to one of values; constant for a number."""
            if callable(key_value):
                return function_of_arrays(key_value)
            return lambda time: np.full(np.shape(time), key_value or 0.0)

        functions = [as_function(key_value) for key_value in key_values]
        # Straight lines of the initial loading end at time 0.
        return [
            _chebyshev_segment(segment.start, segment.end, functions)
            for segment in (*path.initial_loading, *path.cycle)
            if segment.start >= 0
        ]

    def in_words(self, unit: str) -> str:
        """Describe the load for the user: functions of time, and how long they last."""
        return (
            f"the loads (in {unit}) are Python functions of time over"
            f" {self.duration:.6g}{', repeated' if self.repeats else ''}"
        )


def _chebyshev_segment(
    begin: float, end: float, functions: Sequence[Callable[[Any], Any]], load_scale: float = 0.0
) -> ChebyshevSegment:
    """Segment of a load path from time `begin` to `end` with two Chebyshev series over time: of P
    and Q, or of a pair that takes their places, such as both bulk stresses.

    The series go through values of two `functions`, each from an array of times to one of values.
    Terms at the end of a series below 1e-16 of `load_scale`, the size of the loads, are left out as
    round-off; with 0 only terms that are 0.
    """
    # CHEBYSHEV_NODES: points of [-1, 1], -1 being the time `begin` and 1 the time `end`.
    times = begin + (end - begin) * (1 + CHEBYSHEV_NODES) / 2

    def coefficients_of(function: Callable[[Any], Any]) -> tuple[float, ...]:
        """Coefficients of the series through a function's values, up to the last that is not
        round-off.
        """
        coefficients = chebyshev_coefficients(function(times))
        is_above_roundoff = np.abs(coefficients) > 1e-16 * load_scale
        degree = int(np.max(np.flatnonzero(is_above_roundoff), initial=0))
        return tuple(coefficients[: degree + 1].tolist())

    first_function, second_function = functions
    return ChebyshevSegment(
        begin, end, coefficients_of(first_function), coefficients_of(second_function)
    )
