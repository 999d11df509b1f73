"""The form of every answer, whoever computed it."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes.array_types import Array
from scenes.errors import InputError, first_line, require_class, require_path
from scenes.files import replace_file
from scenes.netcdf import StoredArray, StoredArrays, netcdf_of, read_netcdf
from scenes.notebook_forms import forms_for, registered_forms
from scenes.scene import Scene

if TYPE_CHECKING:
    import xarray as xr


class SurfaceState(IntEnum):
    """What a pair of surface points does at an instant; forward is the upper body sliding along +x
    over the lower.
    """

    OPEN = 0
    STICK = 1
    SLIP_FORWARD = 2
    SLIP_REVERSE = 3


# For arrays, plain integers: numpy first searches a member of an enumeration for methods of its
# own, which takes four times the comparison, and a Ctrl-C that falls into the search is lost.
OPEN, STICK, SLIP_FORWARD, SLIP_REVERSE = (int(state) for state in SurfaceState)


def read_only_copy(values: ArrayLike, dtype: Any = float) -> NDArray[Any]:
    """A read-only copy of `values`."""
    array = np.array(values, dtype=dtype)
    array.flags.writeable = False
    return array


def _array_metadata(words: str, dimension: str, unit: str = "") -> dict[str, Any]:
    """Metadata of an array of an answer: its name in words, its dimensions, of which unit it is."""
    return {"words": words, "over": tuple(dimension.split()), "unit": unit}


@dataclass(frozen=True, eq=False, repr=False)
class Record:
    """How a solution came about.

    Attributes
    ----------
    converged
        whether every step met its tolerance
    termination
        "steady", "ratcheting" (U drifts by the same in each cycle), "end of path", "not
        converged" or "interrupted"
    message
        the same, as a sentence
    iterations
        (n_steps,) contact iterations of each step
    certificates
        name -> (n_steps,), dimensionless residuals and violations of each step (0 is perfect)
    energy
        name -> (n_steps,), energies of each step alone (increments, not running totals) per
        unit thickness, in the scene's units; "layer", of the penalty method, is part of "elastic"
    notes
        everything that a reader must not miss: fallbacks, neglected coupling, clipped values
    errors
        field -> estimate, from above, of the largest error that quadratures and series left in
        it, over the largest value of the field (of f p for the shear), 1 % of a away from
        edges, where tractions are roots; "... at the edge" for the points asked for, however
        near; of `dissipation` and `loop_work` over themselves. Fields in closed form, and
        engines that estimate none, have no entry
    """

    converged: bool
    termination: str
    message: str
    iterations: NDArray[np.int64] = field(metadata=_array_metadata("contact iterations", "time"))
    certificates: Mapping[str, Array] = field(default_factory=dict)
    energy: Mapping[str, Array] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    errors: Mapping[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        return (
            f"Record({self.termination!r}, {int(self.iterations.sum())} iterations,"
            f" {len(self.notes)} notes)"
        )


@dataclass(frozen=True)
class Work:
    """What was done and what was not: `counts` by name, `skipped` by name with (count, reason),
    `seconds` by stage.
    """

    counts: Mapping[str, int] = field(default_factory=dict)
    skipped: Mapping[str, tuple[int, str]] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)


def require_solution(solution: object, caller: str) -> None:
    """Raise InputError, one sentence, where what a Python caller passes to the public function
    `caller` is no ContactSolution, such as a Scene or the path of a file.
    """
    require_class(
        solution, ContactSolution, caller, "semi_analytic.solve and halfplane_fe.solve return one"
    )


@dataclass(frozen=True, eq=False)
class ContactSolution:
    """One load history through one engine. Arrays are read-only; loads and dissipations are per
    unit thickness.

    Attributes
    ----------
    time, normal_load, tangential_load
        (n_steps,)
    x
        (n_points,), contact points of the lower body, ascending [length]
    pressure, shear
        (n_steps, n_points) [stress]; pressure >= 0; shear along +x on the lower body, positive
        with Q
    slip
        (n_steps, n_points) [length], upper over lower; goes on as relative displacement while a
        point is open
    state
        (n_steps, n_points), SurfaceState as int8
    contact_edges, stick_edges
        (n_steps, 2) [length], left and right; in full stick the stick edges are the contact
        edges, in full slip NaN
    contact_half_width, stick_half_width
        (n_steps,) [length]
    tangential_displacement, normal_approach
        (n_steps,) [length], upper relative to lower (along +x; towards each other), counted
        from half-planes whose surface does not move at `profile.datum_length` from the load: U
        = (A/pi) int M' ln(2 L/a) d eta
    dissipation_density
        (n_points,) [energy / area], of the last whole cycle
    dissipation
        energy per unit thickness, of the last whole cycle
    dissipation_uncertainty
        of `dissipation`, by mesh and steps of finite elements [energy / thickness]; NaN where
        it is unknown, as of other engines
    uncertainties
        of other values by their names, each in the unit of its value and for all instants of the
        last cycle; NaN where there is no estimate. Of finite elements by their mesh, of half-plane
        theory permanent stick and stick edges on grids; empty of what is exact, and of external
        results
    loop_work
        closed integral of Q dU - m_q d(eps) over the last whole cycle, m_q the `shear_moment`
        and eps the bulk strain (0 without bulk stress, where Q dU alone is left): between
        half-planes of like materials the second and independent way to the dissipation (of
        other bodies that of P dV, V the approach, comes to it); NaN where the last cycle does
        not end in the state it started from
    cycle_dissipation
        (n_cycles,); a path that is not periodic counts as one cycle
    permanent_stick_half_width
        largest half-width that sticks through the whole last cycle [length]; NaN if none. Under
        bulk stress or tilt, and in finite elements of coupled bodies, places that slip by a few
        1e-4 or 1e-5 of the largest slip count as stuck
    steady_from
        index of the first cycle that ends in the state it started from; None if none did
    bulk_stress_lower, bulk_stress_upper
        (n_steps,) bulk stress along x in each body, tension positive [stress]; these and the
        next four are None where the scene has neither bulk stress nor tilt and a symmetric
        profile
    tilt, moment
        (n_steps,) turn of the upper body that opens the gap at x > 0 [rad]; int x p dx [force]
    shear_moment
        (n_steps,) m_q = int x q dx [force]
    permanent_stick_edges
        (2,) left and right end of what sticks through the whole last cycle [length]; NaN if
        nothing does
    record, work, scene, settings, versions
        how it came about
    engine
        "semi_analytic", "halfplane_fe", or somebody else's name
    """

    engine: str
    scene: Scene
    time: Array = field(metadata=_array_metadata("time of the load path", "time"))
    normal_load: Array = field(
        metadata=_array_metadata("normal load P per unit thickness", "time", "load")
    )
    tangential_load: Array = field(
        metadata=_array_metadata("tangential load Q per unit thickness", "time", "load")
    )
    x: Array = field(
        metadata=_array_metadata("position along the surface of the lower body", "x", "length")
    )
    pressure: Array = field(metadata=_array_metadata("contact pressure p", "time x", "stress"))
    shear: Array = field(
        metadata=_array_metadata("shear traction q on the lower body", "time x", "stress")
    )
    slip: Array = field(
        metadata=_array_metadata("slip of the upper body over the lower", "time x", "length")
    )
    state: NDArray[np.int8] = field(
        metadata=_array_metadata("0 open, 1 stick, 2 forward slip, 3 reverse slip", "time x")
    )
    contact_edges: Array = field(
        metadata=_array_metadata("edges of the contact", "time side", "length")
    )
    stick_edges: Array = field(
        metadata=_array_metadata("edges of the stick zone", "time side", "length")
    )
    contact_half_width: Array = field(
        metadata=_array_metadata("contact half-width a", "time", "length")
    )
    stick_half_width: Array = field(
        metadata=_array_metadata("stick half-width c", "time", "length")
    )
    tangential_displacement: Array = field(
        metadata=_array_metadata("relative tangential displacement U", "time", "length")
    )
    normal_approach: Array = field(metadata=_array_metadata("normal approach", "time", "length"))
    dissipation_density: Array = field(
        metadata=_array_metadata("friction work per unit area of the last cycle", "x", "load")
    )
    dissipation: float
    cycle_dissipation: Array = field(
        metadata=_array_metadata(
            "friction work of each cycle per unit thickness", "cycle", "energy"
        )
    )
    permanent_stick_half_width: float
    steady_from: int | None
    record: Record
    work: Work
    settings: Mapping[str, Any] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    loop_work: float = float("nan")
    dissipation_uncertainty: float = float("nan")
    uncertainties: Mapping[str, float] = field(default_factory=dict)
    bulk_stress_lower: Array | None = field(
        default=None, metadata=_array_metadata("bulk stress of the lower body", "time", "stress")
    )
    bulk_stress_upper: Array | None = field(
        default=None, metadata=_array_metadata("bulk stress of the upper body", "time", "stress")
    )
    tilt: Array | None = field(
        default=None, metadata=_array_metadata("tilt of the upper body", "time")
    )
    moment: Array | None = field(
        default=None,
        metadata=_array_metadata(
            "moment of the pressure about x = 0 per unit thickness", "time", "force"
        ),
    )
    shear_moment: Array | None = field(
        default=None,
        metadata=_array_metadata(
            "integral of x times shear traction per unit thickness", "time", "force"
        ),
    )
    permanent_stick_edges: Array | None = field(
        default=None,
        metadata=_array_metadata("edges of what sticks through the whole cycle", "side", "length"),
    )

    @property
    def thinned(self) -> bool:
        """Whether instants of a long path of straight lines were left out, counted in
        `work.skipped`; W is of all of them.
        """
        return "instants" in self.work.skipped

    @property
    def dissipation_drift(self) -> float:
        """Change of the friction work W from the last cycle but one to the last, over W of the
        last: a measure of how far the solution is from a steady cycle.

        0 where a cycle ends in the state it started from, NaN where there are fewer than two cycles
        or the last has no friction work. `steady_from` is the index of the first cycle that ends in
        the state it started from, None if none does; `cycle_dissipation` (n_cycles,) is W of each.
        """
        if self.steady_from is not None:
            return 0.0
        last_friction_works = self.cycle_dissipation[-2:]
        if len(last_friction_works) < 2 or not last_friction_works[1] > 0:
            return float("nan")
        return float((last_friction_works[1] - last_friction_works[0]) / last_friction_works[1])

    def __repr__(self) -> str:
        """Five lines of text on the solution: scene and engine, how the run ended, numbers of
        instants and points, largest contact and permanent stick, friction work.
        """
        # Names of the units of force and length.
        force_unit, length_unit, _ = self.scene.unit_words
        name = self.scene.name or self.scene.title or "a scene"

        # `period` is None for a path that does not repeat; a NaN uncertainty is unknown.
        largest_half_width = np.nanmax(self.contact_half_width, initial=0.0)
        interval_text = "whole path" if self.scene.load.path().period is None else "last cycle"
        uncertainty = self.dissipation_uncertainty
        uncertainty_text = "" if np.isnan(uncertainty) else f" ± {uncertainty:.2g}"
        return "\n".join(
            (
                f"{type(self).__name__} of {name!r} by {self.engine}",
                f"  ended: {self.record.message}",
                f"  {len(self.time)} instants, {len(self.x)} surface points",
                (
                    f"  largest half-width {largest_half_width:.6g} {length_unit}, permanent stick"
                    f" half-width {self.permanent_stick_half_width:.6g} {length_unit}"
                ),
                (
                    f"  dissipation of the {interval_text} {self.dissipation:.6g}{uncertainty_text}"
                    f" {force_unit}·{length_unit}/{length_unit}"
                ),
            )
        )

    def to_dataset(self) -> xr.Dataset:
        """Everything but the meshes as an xarray.Dataset over time and x, with units; the inverse
        is `from_dataset`.
        """
        import xarray as xr

        content = self._file_content()
        return xr.Dataset(
            {name: tuple(array) for name, array in content.arrays.items()},
            attrs=dict(content.attributes),
        ).set_coords(_SIDE_COORDINATE)

    def to_dataframe(self) -> Any:
        """Time series of the solution as a pandas.DataFrame, a row for each instant: time, loads,
        edges, half-widths, displacements, contact iterations.

        A pair of edges becomes two columns with "_left" and "_right" behind the name. Fields along
        the contact (pressure, shear, slip) are left out. Units are those of the attributes.
        """
        import xarray as xr

        # `_ARRAY_FIELDS`: the arrays of a solution by name, with the dimensions of each.
        columns: dict[str, NDArray[Any]] = {}
        for name, array_field in _ARRAY_FIELDS.items():
            values = getattr(self.record if name == "iterations" else self, name)
            if values is None:
                continue
            # "iterations" belongs to the record of the run, all else to the solution itself.
            dimensions = array_field.metadata["over"]
            if dimensions == ("time",):
                columns[name] = values
            elif dimensions == ("time", "side"):
                columns[f"{name}_left"] = values[:, 0]
                columns[f"{name}_right"] = values[:, 1]
        variables = {name: ("instant", values) for name, values in columns.items()}
        return xr.Dataset(variables).to_dataframe()

    @classmethod
    def from_dataset(cls, data: xr.Dataset) -> ContactSolution:
        """The solution that `to_dataset` wrote."""
        arrays = {
            str(name): StoredArray(tuple(map(str, array.dims)), array.values)
            for name, array in data.variables.items()
        }
        return cls._from_file_content(StoredArrays(arrays, data.attrs))

    def _file_content(self) -> StoredArrays:
        """Content of the NetCDF file of the solution: its arrays with dimensions, units and
        descriptions, and attributes.

        Attributes are single numbers, and JSON texts of the scene and of two parts of the solution:

        - `record`: convergence of the run, its messages, and stated errors;
        - `work`, the effort of the run (not friction work): counts, what was skipped, seconds.

        `steady_from`, the index of the first steady cycle, is -1 where none is.
        """
        record_entries = {
            "converged": self.record.converged,
            "termination": self.record.termination,
            "message": self.record.message,
            "notes": self.record.notes,
            "errors": dict(self.record.errors),
        }
        work_entries = {
            "counts": dict(self.work.counts),
            "skipped": dict(self.work.skipped),
            "seconds": dict(self.work.seconds),
        }
        # `_NAMES_OF_NUMBERS`: dissipation, its uncertainty, loop work, permanent stick half-width.
        attributes: dict[str, Any] = {"engine": self.engine}
        attributes |= {name: getattr(self, name) for name in _NAMES_OF_NUMBERS}
        # FILE_FORMAT: name and version of the form of the file
        attributes |= {
            "format": FILE_FORMAT,
            "steady_from": -1 if self.steady_from is None else self.steady_from,
            "scene": self.scene.model_dump_json(),
            "record": json.dumps(record_entries),
            "work": json.dumps(work_entries),
            "settings": json.dumps(dict(self.settings)),
            "uncertainties": json.dumps(
                {
                    name: value if math.isfinite(value) else None
                    for name, value in self.uncertainties.items()
                }
            ),
            "versions": json.dumps(dict(self.versions)),
        }
        return StoredArrays(self._stored_arrays(), attributes)

    def _stored_arrays(self) -> dict[str, StoredArray]:
        """Arrays of the solution for its NetCDF file, by name, with dimensions, units and
        descriptions: fields along the contact, time series, and the record's admissibility checks
        and energies of each step.

        Loads and energies are per unit thickness. `record.certificates` are the checks, by name:
        dimensionless residuals of the laws of contact.
        """
        force_unit, length_unit, stress_unit = self.scene.unit_words
        unit_texts = {
            "length": length_unit,
            "stress": stress_unit,
            "load": f"{force_unit}/{length_unit}",
            "force": force_unit,
            "energy": f"{force_unit}·{length_unit}/{length_unit}",
            "": "1",
        }
        # _SIDE_COORDINATE: "side", the coordinate of arrays with a left and a right side
        arrays = {_SIDE_COORDINATE: StoredArray((_SIDE_COORDINATE,), np.array(["left", "right"]))}
        # Fields and time series; None for those of other kinds of scenes. "iterations" belongs to
        # the record of the run. The metadata of each hold its description ("words"), its dimensions
        # ("over") and the kind of its unit.
        for name, array_field in _ARRAY_FIELDS.items():
            values = getattr(self.record if name == "iterations" else self, name)
            if values is None:
                continue
            attributes = {
                "long_name": array_field.metadata["words"],
                "units": unit_texts[array_field.metadata["unit"]],
            }
            if name == "time" and self.scene.load.kind == "ellipse":
                attributes["units"] = "rad"
            arrays[name] = StoredArray(array_field.metadata["over"], values, attributes)

        # Checks and energies have names with a prefix of their own.
        for name, values in self.record.certificates.items():
            arrays[_CERTIFICATE_PREFIX + name] = StoredArray(("time",), values)
        for name, values in self.record.energy.items():
            arrays[_ENERGY_PREFIX + name] = StoredArray(("time",), values)
        return arrays

    @classmethod
    def _from_file_content(cls, content: StoredArrays) -> ContactSolution:
        """The solution whose NetCDF file has this `content`: arrays by name, and attributes, which
        are numbers, and JSON texts of the scene, the settings and two parts of the solution.

        - `record`: convergence of the run, and its messages; the checks and the energies of each
          step are among the arrays
        - `work`: effort of the run (not friction work): counts, what was skipped, seconds

        Arrays that only scenes with bulk stress, tilt or an unsymmetric profile have may be
        missing. KeyError or ValueError for content that is no solution.
        """
        attributes = content.attributes
        record_entries = json.loads(attributes["record"])
        arrays = {name: array.values for name, array in content.arrays.items()}

        def arrays_named(prefix: str) -> dict[str, Array]:
            """Arrays whose names begin with `prefix`, by the rest of their names."""
            return {
                name.removeprefix(prefix): read_only_copy(values)
                for name, values in arrays.items()
                if name.startswith(prefix)
            }

        # Uncertainties are not in files of earlier versions.
        uncertainties = json.loads(attributes.get("uncertainties", "{}"))

        # A `steady_from` below 0 means that no cycle is steady.
        # _CERTIFICATE_PREFIX, _ENERGY_PREFIX: beginnings of the names of checks and of energies
        return cls(
            engine=attributes["engine"],
            scene=Scene.model_validate_json(attributes["scene"]),
            steady_from=None if attributes["steady_from"] < 0 else int(attributes["steady_from"]),
            record=Record(
                iterations=read_only_copy(arrays["iterations"], np.int64),
                certificates=arrays_named(_CERTIFICATE_PREFIX),
                energy=arrays_named(_ENERGY_PREFIX),
                **(record_entries | {"notes": tuple(record_entries["notes"])}),
            ),
            work=_work_from_json(attributes["work"]),
            settings=json.loads(attributes["settings"]),
            uncertainties={
                name: math.nan if value is None else float(value)
                for name, value in uncertainties.items()
            },
            versions=json.loads(attributes["versions"]),
            **_arrays_and_numbers(arrays, attributes),
        )

    def save(self, path: str | Path) -> None:
        """Write NetCDF, whole or not at all; OSError where that can't be."""
        replace_file(path, netcdf_of(self._file_content()))

    @classmethod
    def load(cls, path: str | Path) -> ContactSolution:
        """Read a solution back from the NetCDF file at `path` that it was saved in.

        Raises
        ------
        InputError
            For a file that can't be read, is too large, or holds something else.
        """
        require_path(path, "ContactSolution.load")
        # Arrays with their dimensions checked, and attributes of the file.
        # _AXES_OF_ARRAYS, FILE_FORMAT: axes of each array that has to be there; the newest format
        content = read_netcdf(Path(path), _AXES_OF_ARRAYS, FILE_FORMAT)
        try:
            return cls._from_file_content(content)
        except (
            ArithmeticError,
            AttributeError,
            KeyError,
            RecursionError,
            TypeError,
            ValueError,
        ) as reason:
            raise InputError(
                f"{path}: the solution can't be read: {first_line(reason)}"
            ) from reason

    def _repr_html_(self) -> str | None:
        """For a notebook; None, and so the text, where no HTML is registered."""
        forms = registered_forms()
        return None if forms is None else forms.solution_html(self)

    def plot(self, time: float | None = None) -> Any:
        """Plot pressure, shear and the states of the surface (stick, slip, open) with matplotlib:
        at one instant, and through the last cycle; the Figure.

        The instant is the stored one next to `time`, or without it that of the largest |Q| of the
        last cycle.

        Raises
        ------
        InputError
            Where no figures are loaded: `import reports.page.notebook` loads them.
        """
        # The registered function that draws solutions; InputError without one.
        return forms_for("plot").solution_figure(self, time)

    def plot_loop(self) -> Any:
        """A matplotlib Figure of Q over the relative tangential displacement U through the last
        cycle; InputError as of `plot`.
        """
        return forms_for("plot_loop").loop_figure(self)

    def __dir__(self) -> list[str]:
        """What tab completion shows: no private names."""
        return sorted(name for name in super().__dir__() if not name.startswith("_"))

    @property
    def last_cycle(self) -> NDArray[np.intp]:
        """(k,) indices of the instants of the last whole cycle, both its ends included.

        All instants for a path that is not periodic, and for an external result that states in
        `work.skipped` that it holds no "whole_cycle".
        """
        path = self.scene.load.path()
        if path.period is None or "whole_cycle" in self.work.skipped:
            return np.arange(len(self.time))
        return last_whole_cycle(self.time, path.period, path.cycle_start)[0]


def _arrays_and_numbers(
    arrays: Mapping[str, Array], attributes: Mapping[str, Any]
) -> dict[str, Any]:
    """Values of those attributes of a solution that are arrays or plain numbers, by name, from the
    arrays and attributes of its file.

    Those in `_AXES_OF_ARRAYS` every solution has; a missing one is a KeyError. Arrays that only
    scenes with bulk stress, tilt or an unsymmetric profile have may be missing. So may the
    uncertainty of the dissipation, which is then NaN: files of earlier versions have none.
    """
    # _ARRAY_FIELDS: all arrays of a solution, by name
    names_present = [
        name
        for name in _ARRAY_FIELDS
        if name != "iterations" and (name in _AXES_OF_ARRAYS or name in arrays)
    ]
    values: dict[str, Any] = {
        name: read_only_copy(arrays[name], arrays[name].dtype) for name in names_present
    }
    # _NAMES_OF_NUMBERS: dissipation, its uncertainty, loop work, permanent stick half-width
    for name in _NAMES_OF_NUMBERS:
        values[name] = float(
            attributes.get(name, "nan") if name == "dissipation_uncertainty" else attributes[name]
        )
    return values


def _work_from_json(text: str) -> Work:
    """The `Work` of a solution from the JSON text in its file."""
    entries = json.loads(text)
    skipped = {
        name: (int(count), str(reason)) for name, (count, reason) in entries["skipped"].items()
    }
    return Work(entries["counts"], skipped, entries["seconds"])


def last_whole_cycle(
    time: Array, period: float, cycle_start: float
) -> tuple[NDArray[np.intp], bool]:
    """Find the last whole cycle of a periodic load path among the instants of a solution: indices
    (k,) of the cycle's instants, and whether it is whole, with an instant at both of its ends.

    It is the last cycle of the path that has ended at the last instant. If no instant lies at one
    of its ends, the period up to the last instant is tried. If no instant lies at the begin of that
    period either, the instants within the last cycle of the path are returned, as not whole. An
    instant may miss an end by round-off or by 2 % of the shorter step beside it.

    Parameters
    ----------
    time
        (n_steps,) ascending instants
    period, cycle_start
        duration of a cycle, and time at which the first one starts, in the unit of `time`

    Examples
    --------
    >>> instants = np.array([1.3, 1.8, 2.3])
    >>> indices, is_whole = last_whole_cycle(instants, period=1.0, cycle_start=1.0)
    >>> indices.tolist(), is_whole
    ([0, 1, 2], True)
    """
    time_roundoff = 1e-9 * period
    n_cycles = np.floor((time[-1] - cycle_start + time_roundoff) / period)
    end_of_last_cycle = cycle_start + n_cycles * period

    # A cycle with an instant at both its ends: the last of the path, else the last period.
    for end_of_cycle in (end_of_last_cycle, time[-1]):
        begin_index = _instant_at(time, end_of_cycle - period, time_roundoff)
        end_index = _instant_at(time, end_of_cycle, time_roundoff)
        if begin_index is not None and end_index is not None and begin_index < end_index:
            # Instants within round-off of an end belong to the cycle too.
            first_index = np.searchsorted(time, time[begin_index] - time_roundoff, side="left")
            index_beyond_end = np.searchsorted(time, time[end_index] + time_roundoff, side="right")
            return np.arange(first_index, index_beyond_end), True

    # No whole cycle.
    is_after_begin = time >= end_of_last_cycle - period - time_roundoff
    is_before_end = time <= end_of_last_cycle + time_roundoff
    return np.flatnonzero(is_after_begin & is_before_end), False


# Of the distance to the next instant: one that misses an end of the cycle by less is taken for the
# end. What is left out of the cycle, or counted twice, is then this share of one step at most.
_MISSED_STEP_SHARE = 0.02


def _instant_at(time: Array, target: float, round_off: float) -> int | None:
    """Index of the instant at the time `target`, which it may miss by `round_off` (a time) or by 2
    % of the shorter step to a neighbouring instant; None where there is none.
    """
    nearest_index = int(np.argmin(np.abs(time - target)))
    steps = np.diff(time[max(nearest_index - 1, 0) : nearest_index + 2])
    shorter_step = float(steps.min()) if len(steps) else 0.0
    largest_distance = max(round_off, _MISSED_STEP_SHARE * shorter_step)
    is_at_target = abs(time[nearest_index] - target) <= largest_distance
    return nearest_index if is_at_target else None


FILE_FORMAT = "halfplane solution 2"
"""Of a stored solution. Files of version 0.1 have no such word, and are refused."""
_ARRAY_FIELDS = {
    array.name: array
    for array in (*fields(ContactSolution), *fields(Record))
    if "words" in array.metadata
}
# Coordinate of the columns of what has two sides; beginnings of names of what the record holds.
_SIDE_COORDINATE = "side"
_CERTIFICATE_PREFIX = "certificate_"
_ENERGY_PREFIX = "energy_"
# All but those of scenes with bulk stress, tilt or an unsymmetric profile.
_AXES_OF_ARRAYS = {
    name: array.metadata["over"]
    for name, array in _ARRAY_FIELDS.items()
    if array.default is MISSING
}
_NAMES_OF_NUMBERS = (
    "dissipation",
    "loop_work",
    "dissipation_uncertainty",
    "permanent_stick_half_width",
)


def range_of_slip(slip: Array, is_in_contact: NDArray[np.bool_]) -> Array:
    """Range of slip (largest minus least) of each of n points over k instants, those left out at
    which it is not in contact: (n,); 0 where it never is.

    Out of contact the slip is a relative displacement, and nothing slips. `slip` [length] and
    `is_in_contact` are (k, n).

    >>> range_of_slip(
    ...     np.array([[0.0, 1.0], [2.0, 5.0]]), np.array([[True, True], [True, False]])
    ... ).tolist()
    [2.0, 0.0]
    """
    largest_slip = np.max(slip, axis=0, where=is_in_contact, initial=-np.inf)
    least_slip = np.min(slip, axis=0, where=is_in_contact, initial=np.inf)
    is_ever_in_contact = is_in_contact.any(axis=0)
    slip_range = np.zeros(slip.shape[1])
    slip_range[is_ever_in_contact] = (largest_slip - least_slip)[is_ever_in_contact]
    return slip_range
