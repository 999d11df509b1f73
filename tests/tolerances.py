"""Every tolerance of the finite-element tests in one table: what was measured, what is admitted, and why there is any error at all.

`check(name, value)` is the only way in. An order of convergence has a floor and a ceiling: too fast is as suspect as too slow.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np


class Tolerance(NamedTuple):
    measured: float
    limit: float
    reason: str


class Order(NamedTuple):
    measured: float
    least: float
    most: float
    reason: str


EDGE = "the contact or stick edge lies somewhere inside an element, where p or q falls like a square root"
FLAT = "at b the pressure has a steep flank (a logarithm's derivative) and no node stands there"
MESH = "elements of a/16 and a/12, quadratic"
ALGEBRA = "an identity of the discrete problem: rounding, of sums over a few hundred nodes"

TOLERANCES = {
    # Coarse mesh (problems.COARSE), every problem of the table, largest of them.
    "hertz pressure": Tolerance(4.3e-3, 6e-3, EDGE),
    "hertz shear": Tolerance(1.5e-2, 2.2e-2, EDGE + "; over f ||p||"),
    "hertz contact_half_width": Tolerance(1.1e-3, 3e-3, EDGE + "; over a, an element being 0.06"),
    "hertz stick_half_width": Tolerance(1.7e-2, 3.2e-2, EDGE + "; found to half an element"),
    "hertz peak_pressure": Tolerance(1.1e-4, 2.5e-4, MESH),
    "hertz rigid_approach": Tolerance(4.6e-5, 1e-4, MESH),
    "hertz rigid_shift": Tolerance(4.8e-4, 8e-4, MESH + "; a node counts as stuck from the instant at which it touches"),
    "hertz dissipation": Tolerance(3.7e-3, 6e-3, EDGE),
    "flat and rounded pressure": Tolerance(8.4e-3, 1.3e-2, FLAT),
    "flat and rounded shear": Tolerance(1.9e-2, 2.8e-2, FLAT + "; " + EDGE),
    "flat and rounded contact_half_width": Tolerance(1.5e-3, 3e-3, EDGE),
    "flat and rounded stick_half_width": Tolerance(5.3e-3, 3.2e-2, EDGE + "; found to half an element"),
    # One condensed body under a uniform traction.
    "compliance": Tolerance(5.5e-5, 8e-5, "elements of a/16, nu = 0.49; 1e-5 at nu = 0.3; over the largest displacement"),
    "asymmetry": Tolerance(3e-7, 1e-6, "Betti's theorem fails by the mesh of the arc alone"),
    "second moment of p, L = 5a against 20a": Tolerance(
        1.6e-5, 4e-5, "the two meshes differ below the contact; 1.2e-2 with nothing but the resultant on the arc"
    ),
    # Default mesh and steps, the paper's cycle: the promised figures.
    "default pressure": Tolerance(7.7e-4, 2.5e-3, "promised: 0.25 %; " + EDGE),
    "default shear": Tolerance(4.2e-3, 8e-3, "promised: 0.8 %; " + EDGE),
    "default contact_half_width": Tolerance(4.3e-4, 1 / 120, "promised: one element"),
    "default stick_half_width": Tolerance(8.3e-4, 1 / 120, "promised: one element"),
    "default peak_pressure": Tolerance(3.1e-5, 2e-4, "promised: 0.02 %"),
    "default rigid_approach": Tolerance(1.3e-5, 3e-5, "far field and bulk mesh"),
    "default dissipation": Tolerance(3.6e-4, 1.5e-3, "promised: 0.15 %; mesh and step"),
}

ORDERS = {
    "compliance, linear elements": Order(1.87, 1.6, 2.2, "displacement of linear triangles: 2, less where the bulk mesh is rough"),
    "compliance, quadratic elements": Order(
        3.5, 3.0, 4.0, "quadratic triangles: 4 at nodes of a smooth load, the ends' logarithm costs"
    ),
}


def check(name: str, value: float) -> None:
    """Fail where `value` is above its limit, or no number."""
    assert abs(value) <= TOLERANCES[name].limit, f"{name}: {value:.3g} is above {TOLERANCES[name]}"


def order_of(sizes: Sequence[float], errors: Sequence[float]) -> float:
    """Slope of log(error) over log(size) by least squares."""
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def check_order(name: str, sizes: Sequence[float], errors: Sequence[float]) -> None:
    """Fail where the order of convergence lies outside its range on either side, or an error is no positive number."""
    assert np.all(np.asarray(errors) > 0), f"{name}: not an error sequence: {errors}"
    found, wanted = order_of(sizes, errors), ORDERS[name]
    assert wanted.least <= found <= wanted.most, f"{name}: order {found:.2f} from {errors} is outside {wanted}"
