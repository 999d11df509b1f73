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
_N_CELLS = 120
_N_CELLS_OF_SHEAR = 80
# Half-widths of theory's contact that are covered: a layer of a_ref/(10 E*) makes a contact wider
# by a tenth, the widest one of a search by three quarters.
_REACH_OF_CELLS_ON_LAYER = 1.8
_REACH_OF_SHEAR_CELLS = 1.02
# States of stick and slip that one step tries with all cells that break a law changed at once; of
# the Coulomb limit and of a displacement, below which it is kept.
_MOST_STATES_AT_ONCE = 10
_ROUND_OFF = 1e-9


def cell_centres_and_width(reach: float, count: int) -> tuple[Array, float]:
    """Middles (count,) and width of equal cells between -reach and reach [length]."""
    cell_borders = np.linspace(-reach, reach, count + 1)
    return (cell_borders[1:] + cell_borders[:-1]) / 2, float(cell_borders[1] - cell_borders[0])


def influence_matrix(scene: Scene, cell_centres: Array, cell_width: float) -> Array:
    """Influence matrix (n, n) of cells of constant traction on the surface of two half-planes:
    relative displacement at the centre of cell i by a unit traction on cell j, A_ij
    [length/stress]. It is the integral of -2/(pi E*) ln|x_i - xi| over the places xi of cell j.

    # notation: E* composite modulus, x_i centre of cell i
    """
    # x_i minus the centre, the left end and the right end of cell j
    distance = cell_centres[:, None] - cell_centres[None, :]
    distance_from_left_end = distance + cell_width / 2
    distance_from_right_end = distance - cell_width / 2
    # d (ln|d| - 1) is the antiderivative of ln|d|
    integral_to_left_end = distance_from_left_end * (np.log(np.abs(distance_from_left_end)) - 1)
    integral_to_right_end = distance_from_right_end * (np.log(np.abs(distance_from_right_end)) - 1)
    integral_of_log = integral_to_left_end - integral_to_right_end
    # composite modulus: E*
    return np.asarray(-2 / (np.pi * composite_modulus(scene.material)) * integral_of_log)


def pressure_on_layer(
    scene: Scene, x: Array, normal_loads: Array, layer_compliance: float
) -> Array:
    """Pressure (k, n) at points x (n,) under each of k loads P, of half-planes covered by a soft
    layer [stress]: the faces sink into each other by `layer_compliance` times p.

    On closed cells A p + layer_compliance p = normal approach - initial gap, A being the influence
    matrix (n_cells, n_cells) [length/stress], and p adds up to P. Cells that pull are opened until
    none does.

    Parameters
    ----------
    scene
        profile and material of the half-planes
    x
        (n,) points [length]
    normal_loads
        (k,) P [force / thickness]
    layer_compliance
        indentation of the layer per pressure [length/stress]

    # notation: P normal load, p pressure
    """
    # theory of bare half-planes: half-width under any load
    contact = contact_of(scene.profile, scene.material)
    # cells reach 1.8 half-widths of the contact of bare half-planes: a layer makes it wider
    half_width_of_grid = _REACH_OF_CELLS_ON_LAYER * float(contact.half_width(normal_loads.max()))
    cell_centres, cell_width = cell_centres_and_width(half_width_of_grid, _N_CELLS)
    compliance_matrix = influence_matrix(
        scene, cell_centres, cell_width
    ) + layer_compliance * np.eye(_N_CELLS)
    initial_gap = np.asarray(scene.profile.height(cell_centres))
    pressures = np.zeros((len(normal_loads), _N_CELLS))
    for load_number, normal_load in enumerate(normal_loads):
        is_closed = np.full(_N_CELLS, normal_load > 0)
        while is_closed.any():  # each pass opens a cell, or is the last
            # pressures of the closed cells; the rigid motion is the approach
            closed_pressure, _ = _tractions_and_rigid_motion(
                compliance_matrix,
                is_closed,
                -initial_gap[is_closed],
                cell_width,
                float(normal_load),
            )
            if np.all(closed_pressure >= 0):
                pressures[load_number, is_closed] = closed_pressure
                break
            is_closed[is_closed] = closed_pressure > 0
    return _interpolated_to_points(x, cell_centres, pressures)


def _interpolated_to_points(x: Array, cell_centres: Array, tractions: Array) -> Array:
    """Tractions (k, n) at points x (n,), interpolated from (k, n_cells) on cells; 0 beyond them."""
    return np.array([np.interp(x, cell_centres, row, left=0.0, right=0.0) for row in tractions])


def shear_by_coupling(
    scene: Scene, x: Array, loads: Array, step_numbers: NDArray[np.intp], beta: float
) -> Array:
    """Shear (k, n) of two half-planes with Dundurs' `beta` minus that of like ones [stress], at
    points x (n,) and at the ends of k load steps. Both are computed on cells of constant traction.

    The pressure moves the faces along x, with the slope 2 beta p/E*; what the shear adds to the
    pressure is neglected (Goodman's approximation). The Coulomb law is met at the end of each
    load step.

    Parameters
    ----------
    scene
        profile, material and friction
    x
        (n,) points [length]
    loads
        (n_steps, 2): P and Q at the ends of the load steps [force / thickness]
    step_numbers
        (k,) numbers of the load steps at whose ends the shear is returned
    beta
        Dundurs' constant of the unlike materials

    # notation: E* composite modulus, P normal load, p pressure, Q tangential load
    """
    # theory of like half-planes: half-width and pressure under any load
    contact = contact_of(scene.profile, scene.material)
    half_width_of_grid = _REACH_OF_SHEAR_CELLS * float(contact.half_width(loads[:, 0].max()))
    cell_centres, cell_width = cell_centres_and_width(half_width_of_grid, _N_CELLS_OF_SHEAR)
    # displacement at each cell by a unit traction on each
    matrix = influence_matrix(scene, cell_centres, cell_width)
    pressure = contact.pressure(cell_centres, loads[:, :1])
    # composite modulus: E*
    slope_per_pressure = 2 * beta / composite_modulus(scene.material)
    pressure_up_to_centre = np.cumsum(pressure, axis=1) - pressure / 2  # summed from the left
    displacement_by_pressure = slope_per_pressure * cell_width * pressure_up_to_centre
    coulomb_limit = scene.friction.coefficient * pressure
    tangential_load = loads[:, 1]
    # shear of the cells after each load step
    shear_with_coupling = _shear_history(
        matrix, cell_width, coulomb_limit, tangential_load, displacement_by_pressure
    )
    shear_without_coupling = _shear_history(
        matrix, cell_width, coulomb_limit, tangential_load, 0 * displacement_by_pressure
    )
    shear_by_coupling_on_cells = np.array(shear_with_coupling) - np.array(shear_without_coupling)
    return _interpolated_to_points(x, cell_centres, shear_by_coupling_on_cells[step_numbers])


def _shear_history(
    matrix: Array,
    cell_width: float,
    coulomb_limits: Array,
    tangential_loads: Array,
    displacements_by_pressure: Array,
) -> list[Array]:
    """Shear of n cells on the surface of two half-planes after each of m load steps, (n,) each
    [stress]; the slip of a step is where the next one starts.

    Parameters
    ----------
    matrix
        (n, n) displacement A of the cells by a unit shear of each [length/stress]
    cell_width
        [length]
    coulomb_limits
        (m, n) Coulomb limit f p after each step [stress]
    tangential_loads
        (m,) Q after each step [force / thickness]
    displacements_by_pressure
        (m, n) what the pressure adds to the slip after each step [length]

    # notation: f coefficient of friction, p pressure, Q tangential load
    """
    slip = np.zeros(len(matrix))
    shear_of_steps = []
    for coulomb_limit, tangential_load, displacement_by_pressure in zip(
        coulomb_limits, tangential_loads, displacements_by_pressure, strict=True
    ):
        shear, tangential_displacement = _shear_after_step(
            matrix,
            cell_width,
            coulomb_limit,
            slip - displacement_by_pressure,
            float(tangential_load),
        )
        # that of the bodies, minus what the shear takes off, plus what the pressure adds
        slip = tangential_displacement - matrix @ shear + displacement_by_pressure
        shear_of_steps.append(shear)
    return shear_of_steps


def _shear_after_step(
    matrix: Array,
    cell_width: float,
    coulomb_limit: Array,
    stick_displacement: Array,
    tangential_load: float,
) -> tuple[Array, float]:
    """Shear q (n,) of cells after a load step [stress], and the relative tangential displacement U
    of the bodies [length].

    q adds up to the load, and meets Coulomb's law |q| <= f p. Cells that stick have U - A q =
    `stick_displacement`; the others have slipped in the direction of their shear. The set of cells
    that stick is found by trial: cells that break the law change between stick and slip.

    Parameters
    ----------
    matrix
        (n, n) displacement A of the cells by a unit shear of each [length/stress]
    cell_width
        [length]
    coulomb_limit
        (n,) f p [stress]
    stick_displacement
        (n,) slip of each cell before the step minus what the pressure adds to its slip [length].
        The slip is U - A q plus what the pressure adds, so a cell sticks where U - A q has this
        value
    tangential_load
        Q after the step [force / thickness]

    Raises
    ------
    InputError
        Where all cells slip, or no state is found.

    # notation: A influence matrix `matrix`, f coefficient of friction, p pressure, Q tangential
    #           load
    """
    largest_limit = max(float(coulomb_limit.max(initial=0.0)), 1e-300)
    is_pressed = coulomb_limit > 1e-9 * coulomb_limit.max(initial=0.0)
    # displacement of a cell by the largest shear on itself
    slip_scale = largest_limit * float(np.abs(np.diag(matrix)).max())
    slip_direction = np.zeros(len(coulomb_limit))  # 1 or -1; 0 of cells that stick
    for attempt in range(_MOST_STATES_AT_ONCE + 2 * len(coulomb_limit)):
        is_sticking = is_pressed & (slip_direction == 0)
        if not is_sticking.any():
            break
        shear = np.where(is_pressed, slip_direction * coulomb_limit, 0.0)
        load_on_stick_cells = tangential_load - cell_width * float(shear.sum())
        right_side_at_stick_cells = -stick_displacement[is_sticking] - matrix[is_sticking] @ shear
        # A q - U = -stick_displacement at stick cells, and the shear of all cells adds up to Q
        shear[is_sticking], tangential_displacement = _tractions_and_rigid_motion(
            matrix, is_sticking, right_side_at_stick_cells, cell_width, load_on_stick_cells
        )
        slip = tangential_displacement - matrix @ shear - stick_displacement
        excess_of_shear = np.where(
            is_sticking, (np.abs(shear) - coulomb_limit) / largest_limit, 0.0
        )
        slip_against_shear = np.where(
            is_pressed & (slip_direction != 0), -slip * slip_direction / slip_scale, 0.0
        )
        # cells that break Coulomb's law change between stick and slip
        violation = np.maximum(excess_of_shear, slip_against_shear)
        breaks_law = violation > _ROUND_OFF
        if not breaks_law.any():
            return shear, tangential_displacement
        changes_state = breaks_law
        # one cell at a time comes to an end where all at once do not
        if attempt >= _MOST_STATES_AT_ONCE:
            changes_state = violation == violation.max()
        new_direction = np.where(is_sticking, np.sign(shear), 0.0)
        slip_direction = np.where(changes_state, new_direction, slip_direction)
    raise InputError("no state of stick and slip on cells")


def _tractions_and_rigid_motion(
    matrix: Array, is_chosen: Array, right_side: Array, cell_width: float, load: float
) -> tuple[Array, float]:
    """Tractions t (n,) of n chosen cells that add up to `load`, and the rigid motion of the body,
    from A t - rigid motion = `right_side` [length].

    Parameters
    ----------
    matrix
        (m, m) displacement A of all cells by a unit traction of each [length/stress]
    is_chosen
        (m,) marks the n chosen cells
    right_side
        (n,) what A t minus the rigid motion must be at the chosen cells [length]
    cell_width
        width of a cell [length]
    load
        sum of the tractions over the cells [force / thickness]
    """
    n_chosen = int(is_chosen.sum())
    # unknowns: the tractions, then the rigid motion; the last equation is the sum
    system = np.zeros((n_chosen + 1, n_chosen + 1))
    system[:-1, :-1] = matrix[np.ix_(is_chosen, is_chosen)]
    system[:-1, -1] = -1.0
    system[-1, :-1] = cell_width
    solution = np.linalg.solve(system, np.append(right_side, load))
    return solution[:-1], float(solution[-1])
