"""Lam of the flat face with rounded edges in few passes, for sums in which slip is not small everywhere.

# notation: as in `flat_rounded`; y load over unit, J(y) = int_0^y L d eta, L(y) = ln(a/b) = ln(1 + tau^2)/2

    Lam/unit = J(p) - J(p_c) - (p - p_c) L(p_c)

As a function of tau, y L(tau) - G(tau) is stationary at the tau of y: a tau known to 4e-7 gives J to its square. L(p_c) takes one
step of Newton's method. Below y = 0.4, where all that cancels, both are polynomials of y^(2/3).
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.typing import NDArray

from semi_analytic.batch_kernel import Room
from semi_analytic.flat_law import inverse_load_function, log_function
from semi_analytic.flat_rounded import FlatRoundedContact
from semi_analytic.quadrature import gauss

Array = NDArray[np.float64]

LOW = 0.4
"""Largest y of the polynomials."""

# tau/y^(1/3) as a rational function of y^(1/6), to 4.2e-7 for all y >= 0: a fit of least largest relative error.
_UP = (1.14471285, 0.49642956, 1.32937948, 1.04008637, 1.09347623, 0.78012209, 0.27688122, 0.46231244)
_DOWN = (1.0, 0.43356221, 1.16379014, 0.88529263, 0.97964962, 0.34695493, 0.57942319)


def _horner(coefficients: tuple[float, ...], at: Array, out: Array) -> Array:
    """A polynomial, coefficients from the lowest power on, in place."""
    np.multiply(at, coefficients[-1], out=out)
    out += coefficients[-2]
    for coefficient in coefficients[-3::-1]:
        out *= at
        out += coefficient
    return out


def area_at_all_loads(contact: FlatRoundedContact, room: Room, front: Array, slipped: Array, free: Array) -> Array:
    """Lam from P_c and P - P_c (n, m), to some 1e-16 of P^2 over P - P_c; overwrites `front` and `free`."""
    loads, tau, angle, wide, log, fault = room.of(6, 2, *front.shape)
    loads[1] = front
    np.add(front, slipped, out=loads[0])
    loads /= contact.unit
    np.cbrt(loads, out=tau)
    np.sqrt(tau, out=fault)
    tau *= _horner(_UP, fault, log)
    tau /= _horner(_DOWN, fault, log)
    np.arctan(tau, out=angle)
    np.multiply(tau, tau, out=wide)
    wide += 1
    np.log(wide, out=log)
    log *= 0.5
    wide *= angle
    # F of this tau is wide - tau; what is missing of the load, and that over wide
    np.subtract(loads, wide, out=fault)
    fault += tau
    change = np.divide(fault[1], wide[1], out=free)
    # y L - G + L' fault^2/2 with G = F/2 - tau + arctan tau
    loads *= log
    _second(log[1], change, tau[1], angle[1], front)
    np.square(fault, out=fault)
    fault /= wide
    fault *= 0.25
    loads += fault
    wide *= 0.5
    loads -= wide
    loads -= angle
    tau *= 1.5
    loads += tau
    return _difference(loads, log[1], contact.unit, slipped, free)


def _second(log: Array, change: Array, tau: Array, angle: Array, free: Array) -> None:
    """L(p_c) to second order in `change`, in place: L' = 1/(2 w), L'' = -(1 + 1/(2 tau arctan tau))/(2 w^2), w being `wide`."""
    np.multiply(tau, angle, out=free)
    np.divide(0.125, free, out=free)
    free += 0.25
    free *= change
    np.subtract(0.5, free, out=free)
    change *= free
    log += change


def _difference(whole: Array, log: Array, unit: Array | float, slipped: Array, free: Array) -> Array:
    """unit (J(p) - J(p_c)) - (P - P_c) L(p_c)."""
    np.subtract(whole[0], whole[1], out=free)
    free *= unit
    log *= slipped
    free -= log
    return free


def area_at_low_loads(contact: FlatRoundedContact, room: Room, front: Array, slipped: Array, free: Array) -> Array:
    """The same for P <= 0.4 unit."""
    loads, power, work = room.of(3, 2, *front.shape)
    loads[1] = front
    np.add(front, slipped, out=loads[0])
    loads /= contact.unit
    np.cbrt(loads, out=power)
    power *= power
    loads *= power
    loads *= _horner(_J_FIT, power, work)
    log = _horner(_L_FIT, power[1], work[1])
    log *= power[1]
    return _difference(loads, log, contact.unit, slipped, free)


def careful_area(low: bool, contact: FlatRoundedContact, room: Room, front: Array, slipped: Array, free: Array) -> Array:
    """The same to some 1e-12 of itself: where P - P_c < 0.3 P as (P - P_c)^2 int_0^1 (1 - z) L'(p_c + z (p - p_c)) dz / unit."""
    unit = contact.unit
    start, step, load, total, spare, more = room.of(6, *front.shape)
    np.divide(front, unit, out=start)
    np.divide(slipped, unit, out=step)
    total[...] = 0
    for node, weight in _NEAR_RULE:
        np.multiply(step, node, out=load)
        load += start
        rate = _rate_at_low_loads(load, spare, more) if low else _rate_at_all_loads(load, spare, more, free)
        rate *= weight
        total += rate
    total *= step
    total *= slipped
    near = 0.7 * slipped < 0.3 * front
    whole = area_at_low_loads if low else area_at_all_loads
    return np.where(near, total, whole(contact, Room(), front, slipped, free))


def _rate_at_all_loads(load: Array, tau: Array, root: Array, work: Array) -> Array:
    """L' = 1/(2 (y + tau)), tau by one step of Newton's method: y = (1 + tau^2) arctan tau - tau, dy/dtau = 2 tau arctan tau."""
    np.cbrt(load, out=tau)
    np.sqrt(tau, out=root)
    tau *= _horner(_UP, root, work)
    tau /= _horner(_DOWN, root, work)
    angle = np.arctan(tau, out=root)
    np.multiply(tau, angle, out=work)
    # (y + tau - arctan tau - tau^2 arctan tau)/(2 tau arctan tau)
    change = load + tau
    change -= angle
    change /= work
    change -= tau
    change *= 0.5
    tau += change
    tau += load
    return np.divide(0.5, tau, out=tau)


def _rate_at_low_loads(load: Array, power: Array, work: Array) -> Array:
    """L' as y^(-1/3) times a polynomial of y^(2/3)."""
    root = np.cbrt(load)
    np.multiply(root, root, out=power)
    _horner(_RATE_FIT, power, work)
    return np.divide(work, root, out=work)


def _fits() -> tuple[tuple[float, ...], ...]:
    """L/y^(2/3), J/y^(5/3) and L' y^(1/3) as polynomials of y^(2/3)."""
    power = LOW ** (2 / 3) * (1 - np.cos(np.pi * (np.arange(200) + 0.5) / 200)) / 2
    y = power**1.5
    tau = inverse_load_function(y)
    log = np.log1p(tau * tau) / 2
    values = (log / power, (y * log - log_function(tau)) / (y * power), np.sqrt(power) / (2 * (y + tau)))
    domain = [0.0, float(LOW ** (2 / 3))]
    fits = (Chebyshev.fit(power, value, 17, domain=domain).convert(kind=np.polynomial.Polynomial) for value in values)
    return tuple(tuple(fit.coef.tolist()) for fit in fits)


_L_FIT, _J_FIT, _RATE_FIT = _fits()
_NODES, _WEIGHTS = gauss(7)
_NEAR_RULE = tuple(zip(_NODES.tolist(), (_WEIGHTS * (1 - _NODES)).tolist(), strict=True))
