"""Fatigue measures of the stress through a cycle, at points in plane strain: critical planes,
invariants, ranges.

`survey` computes them beside the contact in both bodies, by both engines, from the linear elastic
stress of contact and bulk.

Arrays of stress are (n_instants, n_points, 4): s_xx, s_yy, s_xy, s_zz, tension positive. Planes are
those that contain the z axis, a degree apart; strains are elastic. Every formula is for the history
as it is, whatever its phase.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from scenes import InputError
from scenes.array_types import Array

if TYPE_CHECKING:
    import pandas as pd

    from halfplane_fe import FiniteElementSolution
    from halfplane_fe.body_fields import LargestTension
    from scenes import ContactSolution


# Number of critical planes over half a turn. Number of steps to the centre of the least sphere
# around a path: its radius is then at most 1e-3 too large.
_N_PLANES = 180
_N_STEPS_TO_CENTRE = 1000
# Most instants of the cycle, besides those of the largest and least loads. Places along the contact
# and depths below the face, over the half-width of contact. Gauss points of an average over depth.
_MOST_INSTANTS = 40
_PLACES_OVER_HALF_WIDTH = np.arange(-80, 81) / 64
_DEPTHS_OVER_HALF_WIDTH = np.array([0.0, 0.02, 0.1, 0.3, 0.8])
_N_POINTS_OVER_DEPTH = 8
ENGINES = ("theory", "finite elements")


@dataclass(frozen=True)
class Criteria:
    """Constants of fatigue measures; a measure is left out where its constants are None.

    Attributes
    ----------
    fatemi_socie
        k and the yield stress [-], [stress]
    findley
        k
    critical_distance
        depth below the face over which the stress is averaged first, as by Taylor (1999)
        [length]; None: points
    """

    fatemi_socie: tuple[float, float] | None = None
    findley: float | None = None
    critical_distance: float | None = None

    def require_valid(self) -> None:
        """InputError where a constant is not a number above 0."""
        options = [("--findley", self.findley), ("--critical-distance", self.critical_distance)]
        options += [("--fatemi-socie", value) for value in self.fatemi_socie or ()]
        for option, value in options:
            if value is not None and not (np.isfinite(value) and value > 0):
                raise InputError(f"{option} {value:g}: a number above 0 is needed")


class _Places(NamedTuple):
    """Places beside the contact at which both engines are evaluated.

    They lie at the same x/a and depth in the contact of each engine, a its half-width. The last two
    arrays have half-plane theory first, then finite elements, as `ENGINES`.
    """

    x_over_half_width: Array  # (n_points,) from the middle of the contact, −1.25 to 1.25
    depth: Array  # (n_points,) below the face [length], 0 or more
    # (n_depths,) weights of the average over depth, None where each point is taken by itself; the
    # points lie depth after depth
    weights: Array | None
    centres: Array  # (2,) x of the middle of the contact [length]
    half_widths: Array  # (2,) of the contact [length]


def survey(solution: FiniteElementSolution, criteria: Criteria) -> pd.DataFrame:
    """A table of fatigue measures of the last cycle at places beside the contact in both bodies, by
    half-plane theory and by finite elements; one row for each place.

    Columns: body; x in theory and x in finite elements [length]; y, positive out of the lower body,
    0 for averages over depth [length]; each measure, which is a stress or a strain of the whole
    cycle, by both engines (`ENGINES`). `criteria` has the constants of the measures, and the
    critical distance, a depth over which the stress is averaged; if it is None the stress is taken
    at points.

    Both engines are evaluated at the same places relative to their own contact at the instant of
    the largest tension. So the contact edges, where stress has an infinite slope, are among the
    places of both. Instants at which a load closes fewer than three nodes of the mesh are left out.

    Raises
    ------
    InputError
        For a body so thin, or a critical distance so long, that the stress beside the contact is
        not known.
    """
    import pandas as pd

    import semi_analytic

    # half-plane theory at instants of the cycle, and the contact of both engines at the largest
    # tension s_xx beside an edge of contact
    edge_tension = _largest_edge_tension(solution)
    times = np.unique([*_times_of_cycle(solution), edge_tension.time])
    theory = semi_analytic.solve(
        solution.scene, x=solution.x, time=times, fields=("pressure", "shear")
    )
    theory_edges = theory.contact_edges[np.searchsorted(times, edge_tension.time)]
    places = _places_beside_contact(criteria, np.array([theory_edges, edge_tension.edges]))

    # a table for each body
    tables = []
    bodies: tuple[Literal["lower", "upper"], ...] = ("lower", "upper")
    for body in bodies:
        material = getattr(solution.scene.material, body)
        # for each engine, name of a measure -> its value at each place
        measures_by_engine = [
            measures(stress, criteria, material.young_modulus, material.poisson_ratio)
            for stress in _stresses_by_engine(solution, theory, times, places, body)
        ]
        tables.append(_table_of_body(body, places, measures_by_engine))
    return pd.concat(tables, ignore_index=True)


def _largest_edge_tension(solution: FiniteElementSolution) -> LargestTension:
    """The largest tension s_xx beside an edge of contact in the last cycle of a solution: it has
    its time and the x of both edges of contact then, `edges` [length]. InputError where it is not
    known, or where nothing touches.
    """
    import halfplane_fe
    from halfplane_fe.body_fields import why_tension_is_unknown

    edge_tension = halfplane_fe.largest_edge_tension(solution)
    if edge_tension is None:
        reason = why_tension_is_unknown(solution) or "nothing touches in the last cycle"
        raise InputError(f"--fatigue: no stress is known beside the contact: {reason}")
    return edge_tension


def _places_beside_contact(criteria: Criteria, edges: Array) -> _Places:
    """The places at which a survey of fatigue evaluates the stress: a grid of 161 values of x/a by
    a few depths. `edges` (2, 2) are x of the left and right edge of contact [length], a row by
    half-plane theory and a row by finite elements.

    The depths are fractions of the half-width by theory, or Gauss points over the critical distance
    of `criteria` where it has one.
    """
    centres = edges.mean(axis=1)
    half_widths = (edges[:, 1] - edges[:, 0]) / 2
    depths, weights = _depths_and_weights(criteria, half_widths[0])
    # _PLACES_OVER_HALF_WIDTH: x/a from −1.25 to 1.25 in steps of 1/64
    depth, x_over_half_width = (
        axis.ravel() for axis in np.meshgrid(depths, _PLACES_OVER_HALF_WIDTH, indexing="ij")
    )
    return _Places(x_over_half_width, depth, weights, centres, half_widths)


def _stresses_by_engine(
    solution: FiniteElementSolution,
    theory: ContactSolution,
    times: Array,
    places: _Places,
    body: Literal["lower", "upper"],
) -> list[Array]:
    """Stress of one body through a cycle by half-plane theory and by finite elements, at the same
    places relative to the contact of each. Each array is (n_instants, n_points, 4): s_xx, s_yy,
    s_xy, s_zz [stress].

    `times` are those of `theory`. Instants at which finite elements give no stress are left out of
    both. Where the places have weights, the stress is averaged over depth, and n_points is the
    number of values of x.
    """
    import halfplane_fe
    import semi_analytic

    y = -places.depth if body == "lower" else places.depth
    x_theory, x_elements = (
        places.centres[:, None] + places.half_widths[:, None] * places.x_over_half_width
    )
    stress_by_theory = semi_analytic.stress(theory, x_theory, y, times, body=body)
    stress_by_elements = halfplane_fe.stress(solution, x_elements, y, times, body=body)
    is_known = ~np.isnan(stress_by_elements).any(axis=(1, 2))  # (n_instants,)
    stresses = [stress_by_theory[is_known], stress_by_elements[is_known]]
    if places.weights is not None:
        stresses = [_averaged_over_depth(stress, places.weights) for stress in stresses]
    return stresses


def _table_of_body(
    body: str, places: _Places, measures_by_engine: Sequence[dict[str, Array]]
) -> pd.DataFrame:
    """Fatigue measures of one body as a table with a row for each place: the body, x by each engine
    and y [length], and each measure by each engine.

    `measures_by_engine` has half-plane theory and then finite elements: name of a measure -> its
    value at each place. With an average over depth the places are the 161 values of x/a, and y = 0.
    """
    import pandas as pd

    x_over_half_width = places.x_over_half_width
    y = -places.depth if body == "lower" else places.depth
    if places.weights is not None:
        x_over_half_width = _PLACES_OVER_HALF_WIDTH
        y = np.zeros(len(_PLACES_OVER_HALF_WIDTH))
    columns: dict[str, Any] = {"body": body}
    contacts = zip(ENGINES, places.centres, places.half_widths, strict=True)
    for engine, centre_x, half_width in contacts:
        columns[f"x, {engine}"] = centre_x + half_width * x_over_half_width
    columns["y"] = y
    for measure in measures_by_engine[0]:
        for engine, value_by_measure in zip(ENGINES, measures_by_engine, strict=True):
            columns[f"{measure}, {engine}"] = value_by_measure[measure]
    return pd.DataFrame(columns)


def _times_of_cycle(solution: FiniteElementSolution) -> Array:
    """Times of the last cycle of a solution at which stress is evaluated: evenly chosen ones, and
    those at which P or Q is largest or least.
    """
    # indices of the cycle's instants in the solution; those chosen are indices into them
    cycle_indices = np.asarray(solution.last_cycle)
    # _MOST_INSTANTS: 40
    n_even = min(_MOST_INSTANTS, len(cycle_indices))
    even_indices = np.linspace(0, len(cycle_indices) - 1, n_even).round().astype(int)
    turning_indices = []
    for load in (solution.normal_load[cycle_indices], solution.tangential_load[cycle_indices]):
        turning_indices += [int(load.argmax()), int(load.argmin())]
    chosen_indices = np.unique([*even_indices, *turning_indices])
    return np.asarray(solution.time[cycle_indices[chosen_indices]])


def _depths_and_weights(criteria: Criteria, half_width: float) -> tuple[Array, Array | None]:
    """Depths below the face [length] at which stress is evaluated, and the weights of its average
    over them; None where there is no critical distance, over which it would be averaged.
    `half_width` is that of the contact.
    """
    if criteria.critical_distance is None:
        return half_width * _DEPTHS_OVER_HALF_WIDTH, None
    nodes, weights = np.polynomial.legendre.leggauss(_N_POINTS_OVER_DEPTH)
    return criteria.critical_distance * (1 + nodes) / 2, weights / 2


def _averaged_over_depth(stress: Array, weights: Array) -> Array:
    """Average (times, across, 4) of stress (times, depths * across, 4) over the depths."""
    by_depth = stress.reshape(len(stress), len(weights), -1, 4)
    return np.asarray(np.einsum("tdxc,d->txc", by_depth, weights))


def largest(table: pd.DataFrame) -> list[dict[str, Any]]:
    """The largest values in a table of fatigue measures: for each body and measure a dict with the
    largest value and its place, by half-plane theory and by finite elements (`ENGINES`).

    The table has a row for each place, with the columns "body", "y", and "MEASURE, ENGINE" for each
    measure and for x.
    """
    largest_values = []
    for body, rows_of_body in table.groupby("body", sort=False):
        # those of the first engine name all measures
        first_columns = (column for column in table.columns if column.endswith(f", {ENGINES[0]}"))
        for measure in (column.removesuffix(f", {ENGINES[0]}") for column in first_columns):
            if measure == "x":
                continue
            largest_of_measure: dict[str, Any] = {"body": body, "measure": measure}
            for engine in ENGINES:
                largest_row = rows_of_body.loc[rows_of_body[f"{measure}, {engine}"].idxmax()]
                largest_of_measure[engine.replace(" ", "_")] = {
                    "value": float(largest_row[f"{measure}, {engine}"]),
                    "x": float(largest_row[f"x, {engine}"]),
                    "y": float(largest_row["y"]) + 0.0,
                }
            largest_values.append(largest_of_measure)
    return largest_values


def measures(
    stress: Array, criteria: Criteria, young_modulus: float, poisson_ratio: float
) -> dict[str, Array]:
    """Fatigue measures of a cycle of stress, at each point: name in words -> (n_points,) [stress],
    for Fatemi and Socie a strain.

    Largest values through the cycle: principal stress; shear stress (s_1 − s_3)/2; von Mises stress
    of the difference of two instants.

    Largest values over all planes that contain the z axis. On a plane s_n is the normal stress, e_n
    the normal strain, tau the shear stress and gamma the shear strain:

    - Smith, Watson and Topper (1970; on critical planes Socie 1987): s_n,max (range of e_n)/2, for
      tension only;
    - Fatemi and Socie (1988): (range of gamma)/2 (1 + k s_n,max/s_yield), at least 0, k a constant;
    - Findley (1959): (range of tau)/2 + k s_n,max, k another constant than that before.

    Crossland (1956): amplitude of sqrt(J2), the radius of the least sphere around the path of the
    stress deviator (Papadopoulos 1994, by the steps of Badoiu and Clarkson 2003); and largest
    hydrostatic stress.

    Parameters
    ----------
    young_modulus
        E of the body [stress]
    poisson_ratio
        nu of the body
    stress
        (n_instants, n_points, 4) s_xx, s_yy, s_xy, s_zz of a cycle
    criteria
        the measures that were asked for, with their constants

    Examples
    --------
    One point under s_xx between 0 and 100: sigma_max^2/(2 E), and tau on planes at 45 degrees.

    >>> stress = np.zeros((2, 1, 4))
    >>> stress[1, 0, 0] = 100.0
    >>> values = measures(stress, Criteria(fatemi_socie=(0.0, 300.0), findley=0.0), 2e5, 0.3)
    >>> round(float(values["Smith-Watson-Topper"][0]), 12)
    0.025
    >>> round(float(values["Findley"][0]), 9), round(float(values["Fatemi-Socie"][0]), 12)
    (25.0, 0.000325)
    """
    # of the stress itself, without planes: principal stresses in descending order
    principal_stress = principal(stress)
    shear_stress = (principal_stress[..., 0] - principal_stress[..., 2]) / 2
    largest_values = {
        "largest principal stress": principal_stress[..., 0].max(axis=0),
        "largest shear stress": shear_stress.max(axis=0),
        "range of von Mises stress": _von_mises_range(stress),
        "Smith-Watson-Topper": np.zeros(stress.shape[1]),
    }

    # the largest values on planes whose normals have these angles from x (_N_PLANES: 180)
    for angle in np.pi * np.arange(_N_PLANES) / _N_PLANES:
        measures_on_plane = _measures_on_plane(
            stress, angle, criteria, young_modulus, poisson_ratio
        )
        for name, value in measures_on_plane.items():
            largest_values[name] = np.maximum(value, largest_values.get(name, value))

    # by the path of the stress deviator
    amplitude, hydrostatic_stress = _crossland_measures(stress)
    largest_values["Crossland, amplitude of sqrt(J2)"] = amplitude
    largest_values["Crossland, largest hydrostatic stress"] = hydrostatic_stress
    return largest_values


def _measures_on_plane(
    stress: Array, angle: float, criteria: Criteria, young_modulus: float, poisson_ratio: float
) -> dict[str, Array]:
    """Fatigue measures of a cycle on one plane that contains the z axis, at each point: name ->
    (n_points,). They are those of Smith, Watson and Topper [stress]; and of Fatemi and Socie [-]
    and of Findley [stress], where `criteria` has their constants.

    Parameters
    ----------
    stress
        (n_instants, n_points, 4) s_xx, s_yy, s_xy, s_zz of the cycle
    angle
        from x to the normal of the plane [rad]
    young_modulus
        E of the body [stress]
    poisson_ratio
        nu of the body
    """
    # normal stress and strain, and shear stress, (n_instants, n_points); s_xx + s_yy -
    # normal_stress is the normal stress at right angles to it, in x and y
    s_xx, s_yy, s_xy, s_zz = np.moveaxis(stress, -1, 0)
    cosine = np.cos(2 * angle)
    sine = np.sin(2 * angle)
    normal_stress = (s_xx + s_yy) / 2 + (s_xx - s_yy) / 2 * cosine + s_xy * sine
    normal_strain = (
        normal_stress - poisson_ratio * (s_xx + s_yy - normal_stress + s_zz)
    ) / young_modulus
    shear_stress = -(s_xx - s_yy) / 2 * sine + s_xy * cosine

    # the measures, from largest values and half ranges through the cycle
    shear_amplitude = np.ptp(shear_stress, axis=0) / 2
    largest_normal_stress = normal_stress.max(axis=0)
    measures_on_plane = {
        "Smith-Watson-Topper": largest_normal_stress * np.ptp(normal_strain, axis=0) / 2
    }
    if criteria.fatemi_socie is not None:
        k_of_fatemi_socie, yield_stress = criteria.fatemi_socie
        shear_modulus = young_modulus / (2 * (1 + poisson_ratio))
        strain_amplitude = shear_amplitude / shear_modulus
        fatemi_socie_measure = strain_amplitude * (
            1 + k_of_fatemi_socie * largest_normal_stress / yield_stress
        )
        measures_on_plane["Fatemi-Socie"] = np.maximum(fatemi_socie_measure, 0.0)
    if criteria.findley is not None:
        k_of_findley = criteria.findley
        measures_on_plane["Findley"] = shear_amplitude + k_of_findley * largest_normal_stress
    return measures_on_plane


def _crossland_measures(stress: Array) -> tuple[Array, Array]:
    """Crossland's two measures of a cycle of stresses (n_instants, n_points, 4), (n_points,) each
    [stress]: the amplitude of sqrt(J2), and the largest hydrostatic stress.

    The amplitude is the radius of the least sphere around the path of the stress deviator. The
    centre of the sphere moves in each step towards the instant that is farthest from it; each step
    is shorter than the one before.
    """
    s_xx, s_yy, s_xy, s_zz = np.moveaxis(stress, -1, 0)
    mean_stress = (s_xx + s_yy + s_zz) / 3
    # coordinates of the deviator, (n_instants, n_points, 3), in which the distance of two of its
    # values is sqrt(J2) of their difference
    path = np.stack([(s_xx - s_yy) / 2, s_xy, (s_zz - mean_stress) * np.sqrt(0.75)], axis=-1)
    centre = path.mean(axis=0)
    # _N_STEPS_TO_CENTRE: 1000
    for step in range(_N_STEPS_TO_CENTRE):
        farthest_instants = np.argmax(np.sum((path - centre) ** 2, axis=-1), axis=0)
        farthest_deviators = path[farthest_instants, np.arange(path.shape[1])]
        centre = centre + (farthest_deviators - centre) / (step + 2)
    radius = np.sqrt(np.sum((path - centre) ** 2, axis=-1).max(axis=0))
    return radius, mean_stress.max(axis=0)


def _von_mises_range(stress: Array) -> Array:
    """Largest von Mises stress, (n_points,), of the difference between the stresses of any two
    instants, from `stress` (n_instants, n_points, 4).
    """
    largest_range = np.zeros(stress.shape[1])
    for stress_at_instant in stress:
        xx, yy, xy, zz = np.moveaxis(stress - stress_at_instant, -1, 0)
        squares = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * xy**2
        largest_range = np.maximum(largest_range, np.sqrt(squares.max(axis=0)))
    return largest_range


def principal(stress: Array) -> Array:
    """Principal stresses in descending order, (..., 3), from s_xx, s_yy, s_xy, s_zz (..., 4) in
    plane strain.

    >>> principal(np.array([3.0, 1.0, 0.0, 2.0])).tolist()
    [3.0, 2.0, 1.0]
    """
    xx, yy, xy, zz = np.moveaxis(stress, -1, 0)
    mean_stress = (xx + yy) / 2
    radius = np.hypot((xx - yy) / 2, xy)
    return -np.sort(-np.stack([mean_stress + radius, mean_stress - radius, zz], axis=-1), axis=-1)
