"""Measures of fatigue of the stress through a cycle, at points of plane strain: critical planes,
invariants, ranges.

`survey` takes them beside the contact in both bodies, of both engines, from the linear elastic
stress of contact and bulk.

Arrays of stress are (n_instants, n_points, 4): s_xx, s_yy, s_xy, s_zz, tension positive. Planes are
those that contain the z axis, a degree apart; strains are elastic. Every formula is for the history
as it is, whatever its phase.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from scenes import InputError

if TYPE_CHECKING:
    import pandas as pd

    from halfplane_fe import FiniteElementSolution

Array = NDArray[np.float64]

# Angles of planes, half a turn in all, and steps towards the least sphere around a path, whose
# radius they leave 1e-3 too large.
_PLANES, _STEPS = 180, 1000
# Instants of the cycle, at most, beside those of the largest and least loads; places across the
# contact, over its half-width, and depths below the face; Gauss' points of an average over depth.
_INSTANTS = 40
_ACROSS = np.arange(-80, 81) / 64
_DEPTHS = np.array([0.0, 0.02, 0.1, 0.3, 0.8])
_OVER_DEPTH = 8
ENGINES = ("theory", "finite elements")


@dataclass(frozen=True)
class Criteria:
    """What is needed beside the stress; None leaves a measure out.

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
        """InputError for numbers that make no sense."""
        given = [("--findley", self.findley), ("--critical-distance", self.critical_distance)]
        given += [("--fatemi-socie", value) for value in self.fatemi_socie or ()]
        for option, value in given:
            if value is not None and not (np.isfinite(value) and value > 0):
                raise InputError(f"{option} {value:g}: a number above 0 is needed")


def survey(solution: FiniteElementSolution, criteria: Criteria) -> pd.DataFrame:
    """Measures through the last cycle at places beside the contact in both bodies, of theory and
    finite elements; a row a place.

    Columns: body; x in theory and in finite elements, the same over their own half-widths at the
    largest tension, so that the edges, where stress has an infinite slope, are among them in both
    [length]; y out of the lower body, 0 for averages over depth [length]; each measure by both
    engines.

    Raises
    ------
    InputError
        For a body so thin, or a critical distance so long, that the stress beside the contact is
        not known.
    """
    import pandas as pd

    import halfplane_fe
    import semi_analytic

    cycle = np.asarray(solution.last_cycle)
    loads = solution.normal_load[cycle], solution.tangential_load[cycle]
    turns = [index for load in loads for index in (int(load.argmax()), int(load.argmin()))]
    evenly = np.linspace(0, len(cycle) - 1, min(_INSTANTS, len(cycle))).round().astype(int)
    times = solution.time[cycle[np.unique([*evenly, *turns])]]
    largest = halfplane_fe.largest_edge_tension(solution)
    if largest is None:
        raise InputError(
            "--fatigue: no stress is known beside the contact: a body is too thin, or nothing"
            " touches in the last cycle"
        )
    times = np.unique([*times, largest.time])
    reference = semi_analytic.solve(
        solution.scene, x=solution.x, time=times, fields=("pressure", "shear")
    )
    edges = np.array([reference.contact_edges[np.searchsorted(times, largest.time)], largest.edges])
    middle, half = edges.mean(axis=1), (edges[:, 1] - edges[:, 0]) / 2
    averaged, shares = criteria.critical_distance is not None, np.ones((1, 1))
    depths = half[0] * _DEPTHS
    if criteria.critical_distance is not None:
        node, weight = np.polynomial.legendre.leggauss(_OVER_DEPTH)
        depths, shares = criteria.critical_distance * (1 + node) / 2, weight[:, None] / 2
    depth, across = (part.ravel() for part in np.meshgrid(depths, _ACROSS, indexing="ij"))
    found = []
    bodies: tuple[Literal["lower", "upper"], ...] = ("lower", "upper")
    for body in bodies:
        y, material = -depth if body == "lower" else depth, getattr(solution.scene.material, body)
        theory = semi_analytic.stress(reference, middle[0] + half[0] * across, y, times, body=body)
        elements = halfplane_fe.stress(solution, middle[1] + half[1] * across, y, times, body=body)
        if averaged:
            theory, elements = (
                np.einsum("tdxc,da->txc", side.reshape(len(times), len(depths), -1, 4), shares)
                for side in (theory, elements)
            )
        sides = [
            measures(side, criteria, material.young_modulus, material.poisson_ratio)
            for side in (theory, elements)
        ]
        places, heights = (_ACROSS, np.zeros(len(_ACROSS))) if averaged else (across, y)
        at = {
            f"x, {name}": m + h * places for name, m, h in zip(ENGINES, middle, half, strict=True)
        }
        columns = {"body": body, **at, "y": heights}
        pairs = {
            f"{words}, {name}": side[words]
            for words in sides[0]
            for name, side in zip(ENGINES, sides, strict=True)
        }
        found.append(pd.DataFrame(columns | pairs))
    return pd.concat(found, ignore_index=True)


def largest(table: pd.DataFrame) -> list[dict[str, Any]]:
    """The largest value of each measure of a survey in each body with its place, by both
    engines.
    """
    rows = []
    for body, part in table.groupby("body", sort=False):
        for words in (name.removesuffix(f", {ENGINES[0]}") for name in table.columns[4::2]):
            row: dict[str, Any] = {"body": body, "measure": words}
            for name in ENGINES:
                at = part[f"{words}, {name}"].idxmax()
                value, x, y = (
                    float(part[column][at]) for column in (f"{words}, {name}", f"x, {name}", "y")
                )
                row[name.replace(" ", "_")] = {"value": value, "x": x, "y": y + 0.0}
            rows.append(row)
    return rows


def measures(
    stress: Array, criteria: Criteria, young_modulus: float, poisson_ratio: float
) -> dict[str, Array]:
    """Every measure by its words, (n_points,) each [stress], but Fatemi and Socie's, a strain.

    Largest of the cycle: principal stress, shear stress (s_1 - s_3)/2, von Mises stress of the
    difference of two instants. Largest over the planes, s_n their normal stress, tau and gamma
    their shear stress and strain, e_n their normal strain:

    - s_n,max (range of e_n)/2, tension only (Smith, Watson and Topper 1970; on critical planes
      Socie 1987);
    - (range of gamma)/2 (1 + k s_n,max/s_yield), at least 0: compression reduces it (Fatemi and
      Socie 1988);
    - (range of tau)/2 + k s_n,max (Findley 1959).

    Crossland (1956): amplitude of sqrt(J2), the radius of the least sphere around the path of the
    deviator (Papadopoulos 1994, by the steps of Badoiu and Clarkson 2003), and largest hydrostatic
    stress.
    """
    xx, yy, xy, zz = np.moveaxis(stress, -1, 0)
    main, mises, shear_modulus = (
        principal(stress),
        np.zeros(stress.shape[1]),
        young_modulus / (2 * (1 + poisson_ratio)),
    )
    for instant in stress:
        a, b, c, d = np.moveaxis(stress - instant, -1, 0)
        mises = np.maximum(
            mises,
            np.sqrt((((a - b) ** 2 + (b - d) ** 2 + (d - a) ** 2) / 2 + 3 * c**2).max(axis=0)),
        )
    found = {
        "largest principal stress": main[..., 0].max(axis=0),
        "largest shear stress": ((main[..., 0] - main[..., 2]) / 2).max(axis=0),
        "range of von Mises stress": mises,
        "Smith-Watson-Topper": np.zeros(stress.shape[1]),
    }
    for angle in np.pi * np.arange(_PLANES) / _PLANES:
        cosine, sine = np.cos(2 * angle), np.sin(2 * angle)
        normal = (xx + yy) / 2 + (xx - yy) / 2 * cosine + xy * sine
        strain = (normal - poisson_ratio * (xx + yy - normal + zz)) / young_modulus
        tau = np.ptp(-(xx - yy) / 2 * sine + xy * cosine, axis=0) / 2
        largest_normal = normal.max(axis=0)
        here = {"Smith-Watson-Topper": largest_normal * np.ptp(strain, axis=0) / 2}
        if criteria.fatemi_socie is not None:
            k, yield_stress = criteria.fatemi_socie
            here["Fatemi-Socie"] = np.maximum(
                tau / shear_modulus * (1 + k * largest_normal / yield_stress), 0.0
            )
        if criteria.findley is not None:
            here["Findley"] = tau + criteria.findley * largest_normal
        found |= {
            words: np.maximum(value, found.get(words, value)) for words, value in here.items()
        }
    mean = (xx + yy + zz) / 3
    # Coordinates in which distances are sqrt(J2): half the double product of the deviator.
    path = np.stack([(xx - yy) / 2, xy, (zz - mean) * np.sqrt(0.75)], axis=-1)
    centre = path.mean(axis=0)
    for step in range(_STEPS):
        away = np.argmax(np.sum((path - centre) ** 2, axis=-1), axis=0)
        centre = centre + (path[away, np.arange(path.shape[1])] - centre) / (step + 2)
    found["Crossland, amplitude of sqrt(J2)"] = np.sqrt(
        np.sum((path - centre) ** 2, axis=-1).max(axis=0)
    )
    return found | {"Crossland, largest hydrostatic stress": mean.max(axis=0)}


def principal(stress: Array) -> Array:
    """Principal stresses in descending order, (..., 3) from (..., 4).

    >>> principal(np.array([3.0, 1.0, 0.0, 2.0])).tolist()
    [3.0, 2.0, 1.0]
    """
    xx, yy, xy, zz = np.moveaxis(stress, -1, 0)
    mean, radius = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    return -np.sort(-np.stack([mean + radius, mean - radius, zz], axis=-1), axis=-1)
