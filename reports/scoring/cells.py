"""Contact on cells of constant traction, for the two causes that half-plane theory of like, bare
bodies does not have: a layer between the faces, and bodies that are not alike.

    u(x_i) = sum_j A_ij t_j,  A_ij the integral over cell j of -2/(pi E*) ln|x_i - xi|

is the relative displacement by either traction t (Johnson 1985, 2.4).

# notation: p pressure, q shear, f friction coefficient, P and Q loads, h width of a cell, beta
Dundurs' constant
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenes import InputError, Scene
from scenes.array_types import Array
from semi_analytic.elasticity import composite_modulus
from semi_analytic.profiles import contact_of

# Cells over the contact: the error of a difference between two results on the same cells is far
# below the third of it that a cause may leave.
_CELLS = 120
_CELLS_OF_SHEAR = 80
# Half-widths of theory's contact that are covered: a layer of a_ref/(10 E*) makes a contact wider
# by a tenth, the widest one of a search by three quarters.
_REACH_OF_LAYER = 1.8
_REACH_OF_SHEAR = 1.02
# States of stick and slip that one step tries with all cells that break a law changed at once; of
# the Coulomb limit and of a displacement, below which it is kept.
_MOST_STATES = 10
_ROUND_OFF = 1e-9


def cells(reach: float, count: int) -> tuple[Array, float]:
    """Middles (count,) and width of equal cells between -reach and reach [length]."""
    edges = np.linspace(-reach, reach, count + 1)
    return (edges[1:] + edges[:-1]) / 2, float(edges[1] - edges[0])


def influence(scene: Scene, middle: Array, width: float) -> Array:
    """(n, n) A_ij [length/stress]."""
    distance = middle[:, None] - middle[None, :]
    right = distance + width / 2
    left = distance - width / 2
    integral = right * (np.log(np.abs(right)) - 1) - left * (np.log(np.abs(left)) - 1)
    return np.asarray(-2 / (np.pi * composite_modulus(scene.material)) * integral)


def pressure_on_layer(scene: Scene, x: Array, normal_load: Array, layer: float) -> Array:
    """Pressure at points x (n,) under each of the loads P (k,), (k, n), of half-planes covered by a
    soft layer: the faces sink into each other by `layer` times p [length/stress].

    On cells A p + layer p = approach - gap where they are closed, A being the influence matrix, and
    p adds up to P. Cells that pull are opened until none does.
    """
    contact = contact_of(scene.profile, scene.material)
    half_width_of_cells = _REACH_OF_LAYER * float(contact.half_width(normal_load.max()))
    cell_centres, cell_width = cells(half_width_of_cells, _CELLS)
    matrix = influence(scene, cell_centres, cell_width) + layer * np.eye(_CELLS)
    gap = np.asarray(scene.profile.height(cell_centres))
    pressures = np.zeros((len(normal_load), _CELLS))
    for instant, load_at_instant in enumerate(normal_load):
        is_closed = np.full(_CELLS, load_at_instant > 0)
        while is_closed.any():  # each pass opens a cell, or is the last
            pressure, _ = _bordered(
                matrix, is_closed, -gap[is_closed], cell_width, float(load_at_instant)
            )
            if np.all(pressure >= 0):
                pressures[instant, is_closed] = pressure
                break
            is_closed[is_closed] = pressure > 0
    return np.array([np.interp(x, cell_centres, row, left=0.0, right=0.0) for row in pressures])


def shear_by_coupling(
    scene: Scene, x: Array, loads: Array, rows: NDArray[np.intp], beta: float
) -> Array:
    """Shear (k, n) at x of bodies with Dundurs' `beta` minus that of like ones, at the `rows` (k,)
    of the load steps.

    The pressure moves the faces along x, with the slope 2 beta p/E*; what the shear adds to the
    pressure is neglected (Goodman's approximation). The Coulomb law is met at the end of each
    load step.

    Parameters
    ----------
    loads
        (n_steps, 2): P and Q at the ends of the steps [force / thickness]
    """
    contact = contact_of(scene.profile, scene.material)
    half_width_of_cells = _REACH_OF_SHEAR * float(contact.half_width(loads[:, 0].max()))
    cell_centres, cell_width = cells(half_width_of_cells, _CELLS_OF_SHEAR)
    matrix = influence(scene, cell_centres, cell_width)
    pressure = contact.pressure(cell_centres, loads[:, :1])
    slope = 2 * beta / composite_modulus(scene.material)
    displacement_by_pressure = slope * cell_width * (np.cumsum(pressure, axis=1) - pressure / 2)
    coulomb_limit = scene.friction.coefficient * pressure
    tangential_load = loads[:, 1]
    shear_with_coupling = _shear_history(
        matrix, cell_width, coulomb_limit, tangential_load, displacement_by_pressure
    )
    shear_without_coupling = _shear_history(
        matrix, cell_width, coulomb_limit, tangential_load, 0 * displacement_by_pressure
    )
    change = np.array(shear_with_coupling) - np.array(shear_without_coupling)
    return np.array([np.interp(x, cell_centres, row, left=0.0, right=0.0) for row in change[rows]])


def _shear_history(
    matrix: Array,
    width: float,
    coulomb_limit: Array,
    tangential_load: Array,
    displacement_by_pressure: Array,
) -> list[Array]:
    """Shear of n cells after each load step, (n,) each; slip is kept from step to step.

    Parameters
    ----------
    matrix, width
        (n, n) displacement of the cells by a unit shear of each; width of a cell [length]
    coulomb_limit
        (n_steps, n) Coulomb limit f p
    tangential_load
        (n_steps,) Q
    displacement_by_pressure
        (n_steps, n) relative displacement that the pressure makes along x [length]
    """
    slip = np.zeros(len(matrix))
    shears = []
    for step, force in enumerate(tangential_load):
        shear, shift = _shear_of_state(
            matrix, width, coulomb_limit[step], slip - displacement_by_pressure[step], float(force)
        )
        slip = shift - matrix @ shear + displacement_by_pressure[step]
        shears.append(shear)
    return shears


def _shear_of_state(
    matrix: Array, width: float, coulomb_limit: Array, held_shear: Array, force: float
) -> tuple[Array, float]:
    """Shear q of cells under Coulomb's law |q| <= limit that adds up to `force`, and the relative
    tangential displacement U. The set of cells that stick is found by trial.

    Cells that stick have U - A q = held_shear; the others have slipped in the direction of their
    shear.

    Parameters
    ----------
    matrix
        (n, n) displacement A of the cells by a unit shear of each
    width
        of a cell [length]
    coulomb_limit
        (n,) f p
    held_shear
        (n,) what slip so far and the pressure have moved each cell by [length]

    Raises
    ------
    InputError
        Where all cells slip, or no state is found.
    """
    is_pressed = coulomb_limit > 1e-9 * coulomb_limit.max(initial=0.0)
    scale = max(float(coulomb_limit.max(initial=0.0)), 1e-300)
    slip_scale = scale * float(np.abs(np.diag(matrix)).max())
    slip_direction = np.zeros(len(coulomb_limit))  # of slip: 0 for stick
    for attempt in range(_MOST_STATES + 2 * len(coulomb_limit)):
        sticks = is_pressed & (slip_direction == 0)
        if not sticks.any():
            break
        shear = np.where(is_pressed, slip_direction * coulomb_limit, 0.0)
        force_left = force - width * float(shear.sum())
        right_side = -held_shear[sticks] - matrix[sticks] @ shear
        shear[sticks], shift = _bordered(matrix, sticks, right_side, width, force_left)
        slip = shift - matrix @ shear - held_shear
        excess = np.where(sticks, (np.abs(shear) - coulomb_limit) / scale, 0.0)
        slip_against_shear = np.where(
            is_pressed & (slip_direction != 0), -slip * slip_direction / slip_scale, 0.0
        )
        violation = np.maximum(excess, slip_against_shear)
        has_changed = violation > _ROUND_OFF
        if not has_changed.any():
            return shear, shift
        if attempt >= _MOST_STATES:  # one cell at a time, which ends where all at once do not
            has_changed = violation == violation.max()
        slip_direction = np.where(
            has_changed, np.where(sticks, np.sign(shear), 0.0), slip_direction
        )
    raise InputError("no state of stick and slip on cells")


def _bordered(
    matrix: Array, chosen_cells: Array, right: Array, width: float, total: float
) -> tuple[Array, float]:
    """Tractions of the chosen cells, A t - shift = right, that add up to `total`, and the shift."""
    count = int(chosen_cells.sum())
    system = np.zeros((count + 1, count + 1))
    system[:-1, :-1] = matrix[np.ix_(chosen_cells, chosen_cells)]
    system[:-1, -1] = -1.0
    system[-1, :-1] = width
    solution = np.linalg.solve(system, np.append(right, total))
    return solution[:-1], float(solution[-1])
