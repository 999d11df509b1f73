"""Stress inside both half-planes, for every profile and every memory curve: Muskhelishvili's potential of the flat punches.

A flat punch of half-width a under unit load has the potential i/(2 pi sqrt(z^2 - a^2)), z = x + i y (Muskhelishvili 1953). The
contact is a superposition of such punches, each with its share M' d eta of the tangential load, so

    N(z) = int_0^P d eta / sqrt(z^2 - a^2),   T(z) = int_0^P M'(eta) d eta / sqrt(z^2 - a^2)

    pi s_xx = -Im N - 2 Re T - y (Re N' - Im T')
    pi s_yy = -Im N          + y (Re N' - Im T')          y <= 0, in the lower body
    pi s_xy =  Im T          + y (Im N' + Re T')

On the face s_yy = -p, s_xy = q, s_xx = -p - (2/pi) Re T: only punches narrower than |x| stretch the face at x, and the tension
at the trailing edge is (2/pi) int M' d eta / sqrt(a(P)^2 - a(eta)^2). For the parabola under P alone this is McEwen (1949).

# notation: eta normal load, a(eta) half-width, M(eta) tangential load of the punches up to eta, f friction, delta = a - |x|
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import ContactSolution, InputError, Scene, scene_of
from semi_analytic.memory import Piece, Snapshot, front_time, pieces
from semi_analytic.profiles import SymmetricContact
from semi_analytic.quadrature import INVERSE_ROOTS
from semi_analytic.solution import memory_at, vector

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Slope = Callable[[Array], Array]
Body = Literal["lower", "upper"]

# Kernels that are held at a time.
_AT_ONCE = 1_000_000


def stress(
    source: ContactSolution | Scene | str | Path, x: ArrayLike, y: ArrayLike, instants: ArrayLike, *, body: Body = "lower"
) -> Array:
    """Stress inside one body, or on its face, at instants of the load path: s_xx, s_yy, s_xy, s_zz.

    Parameters
    ----------
    source : the scene, its name or file, or a solution of it
    x, y : (n_points,) places, or numbers that go with each other [length]; y points out of the lower body: y <= 0 in the lower
        one, y >= 0 in the upper one, 0 on its face
    instants : (n_instants,) times of the load path
    body : "lower" or "upper"

    Returns
    -------
    (n_instants, n_points, 4) s_xx, s_yy, s_xy and s_zz = nu (s_xx + s_yy), tension positive [stress]. To about 1e-11 of the
    largest pressure; infinite at the tip of a sharp wedge. Stress of the contact alone: unlike materials as in `solve`.

    Raises
    ------
    InputError
        For a place outside the body, a time outside the path, or numbers that are not finite.
    InadmissibleLoadError
        For gross sliding or separation anywhere in the path.

    >>> import numpy as np
    >>> a, p0 = 1.0, 2 * 90.62286500739786 / np.pi
    >>> on_axis = stress("hertz-normal", 0.0, -0.786, 1.0)[0, 0] / p0  # largest shear of Hertz: 0.3003 p0 at 0.786 a
    >>> float(((on_axis[0] - on_axis[1]) / 2).round(4))
    0.3003
    """
    scene = source.scene if isinstance(source, ContactSolution) else scene_of(source)
    across, height, times = vector(x, "x"), vector(y, "y"), vector(instants, "instants")
    if body not in ("lower", "upper"):
        raise InputError(f"body: {body!r} is neither 'lower' nor 'upper'")
    if across is None or height is None or times is None:
        raise InputError("stress: x, y and instants are needed")
    if len(across) != len(height) and min(len(across), len(height)) > 1:
        raise InputError(f"x and y: {len(across)} and {len(height)} places; give as many of both")
    across, height = np.broadcast_arrays(across, height)
    side = 1.0 if body == "lower" else -1.0
    if np.any(side * height > 0):
        raise InputError(f"y: {side * float(np.max(side * height)):.6g} is outside the {body} body; y points out of the lower one")
    contact, snapshot = memory_at(scene, times)
    depth, nu = side * height, getattr(scene.material, body).poisson_ratio
    found = np.empty((len(times), len(across), 4))
    for k in range(len(times)):
        if snapshot.load[k] > 0:
            normal, tangential, of_normal, of_tangential = _potentials(contact, _lines(snapshot, k), across, depth)
            found[k, :, :3] = _from_potentials(normal, side * tangential, depth * of_normal, depth * side * of_tangential)
        else:
            found[k] = 0.0
    found[..., 2] *= side
    found[..., 3] = nu * (found[..., 0] + found[..., 1])
    return found


def edge_tension(source: ContactSolution | Scene | str | Path, instants: ArrayLike) -> Array:
    """Tension s_xx of the lower body at its left edge of contact, (n_instants,) [stress].

    It is -s_xx at the right edge, and in the upper body the opposite.

    (2/pi) int_0^P M'(eta) d eta / sqrt(a(P)^2 - a(eta)^2), positive for Q > 0 at constant P: the trailing edge of the lower body is
    the left one then. 0 out of contact.

    >>> from scenes import load_scene
    >>> scene = load_scene("cattaneo-mindlin")  # Q = 0.6 f P at time 2: 2 f p0 sqrt(0.6), Cattaneo-Mindlin
    >>> f, p0 = scene.friction.coefficient, -stress(scene, 0.0, 0.0, 1.0)[0, 0, 1]
    >>> round(float(edge_tension(scene, 2.0)[0] / (2 * f * p0)) ** 2, 9)
    0.6
    """
    scene = source.scene if isinstance(source, ContactSolution) else scene_of(source)
    times = vector(instants, "instants")
    if times is None:
        raise InputError("edge_tension: instants are needed")
    contact, snapshot = memory_at(scene, times)
    found = np.zeros(len(times))
    for k in np.flatnonzero(snapshot.load > 0).tolist():
        edge = np.atleast_1d(contact.half_width(snapshot.load[k]))
        found[k] = 2 / math.pi * _potentials(contact, _lines(snapshot, k), edge, np.zeros(1))[1].real[0]
    return found


def _from_potentials(normal: Complex, tangential: Complex, of_normal: Complex, of_tangential: Complex) -> Array:
    """(n, 3) s_xx, s_yy, s_xy of a body below y = 0 from N, T, y N' and y T'."""
    bent = of_normal.real - of_tangential.imag
    pressed = -normal.imag
    rows = pressed - 2 * tangential.real - bent, pressed + bent, tangential.imag + of_normal.imag + of_tangential.real
    return np.stack(rows, axis=-1) / math.pi


def _lines(snapshot: Snapshot, k: int) -> Iterator[tuple[float, float, Slope]]:
    """(lower load, upper load, M' of loads between) of the memory curve of instant k, from the top to 0."""
    load, front = float(snapshot.load[k]), float(snapshot.load[k] - snapshot.slipped[k])
    if front < load:
        slope = float(snapshot.direction[k] * snapshot.friction)
        yield max(front, 0.0), load, lambda eta: np.full(eta.shape, slope)
    for piece in pieces(snapshot.actives[snapshot.which[k]]):
        if piece.bottom < front:
            yield piece.bottom, min(piece.top, front), _slope_of(piece, snapshot.friction)


def _slope_of(piece: Piece, friction: float) -> Slope:
    """M'(eta) on a piece: of an arc dQ/dP of the path, 0/0 where both loads turn at once and |M'| <= f."""

    def slope(eta: Array) -> Array:
        if piece.arc is None:
            return piece.slope + 2 * piece.bend * (eta - piece.anchor.normal)
        normal, tangential = piece.anchor.leg.rates(front_time(piece, eta))
        ratio = np.divide(tangential, normal, out=np.zeros(eta.shape), where=normal != 0)
        return np.asarray(np.clip(ratio, -friction, friction))

    return slope


def _potentials(contact: SymmetricContact, lines: Iterator[tuple[float, float, Slope]], x: Array, y: Array) -> Complex:
    """N, T, N' and T' at x + i y, y <= 0: (4, n). N' and T' are left 0 on the face, where they go with y."""
    found = np.zeros((4, len(x)), dtype=complex)
    distance = np.abs(x)
    for bottom, top, slope in lines:
        low, high = (float(contact.half_width(load)) for load in (bottom, top))
        marks = [low, *(b for b in contact.breaks if low < b < high), high]
        for first, last in pairwise(marks):
            if last > first:
                _add_panel(found, contact, slope, (first, last), distance, y)
    found[:2, x < 0] = -found[:2, x < 0].conj()
    found[2:, x < 0] = found[2:, x < 0].conj()
    return found


def _add_panel(found: Complex, contact: SymmetricContact, slope: Slope, ends: tuple[float, float], x: Array, y: Array) -> None:
    """Adds the punches of half-widths between `ends`; where |x| is one of them the panel is cut there."""
    low, high = ends
    inside, rule = (x > low) & (x < high), INVERSE_ROOTS
    length, lower, at_once = high - low, rule.up < 0.5, _AT_ONCE // len(rule.up)
    half = np.where(lower, low + length * rule.up, high - length * rule.down)
    weights, outside, within = _weights(contact, slope, half, length * rule.share), np.flatnonzero(~inside), np.flatnonzero(inside)
    for here in np.array_split(outside, 1 + len(outside) // at_once):
        point = x[here, None]
        _add(found, here, weights, np.where(lower, (low - point) + length * rule.up, (high - point) - length * rule.down), x, y)
    for here in np.array_split(within, 1 + len(within) // at_once):
        point = x[here, None]
        for sign, far in ((-1.0, low), (1.0, high)):
            reach = sign * (far - point)
            delta = sign * reach * rule.up
            half = np.where(lower, point + delta, far - sign * reach * rule.down)
            _add(found, here, _weights(contact, slope, half, reach * rule.share), delta, x, y)


def _weights(contact: SymmetricContact, slope: Slope, half: Array, share: Array) -> Array:
    """d eta and M' d eta of the nodes `half`, (2, ...)."""
    rise = contact.stiffness(half) * share
    return np.stack([rise, rise * slope(contact.load(half))])


def _add(found: Complex, here: NDArray[np.intp], weights: Array, delta: Array, x: Array, y: Array) -> None:
    """Adds the sums over the nodes (the last axis) at the points `here`; z^2 - a^2 from delta = a - x, which does not cancel."""
    point, height = x[here, None], y[here, None]
    # The root is that of -0 i on the face: from inside the lower body.
    square = np.empty(delta.shape, dtype=complex)
    square.real = -delta * (2 * point + delta) - height * height
    square.imag = 2 * point * -np.abs(height)
    kernel = 1 / np.sqrt(square)
    found[:2, here] += np.einsum("...mn,mn->...m" if weights.ndim == 3 else "kn,mn->km", weights, kernel)
    deep = np.flatnonzero(height[:, 0] != 0)
    if len(deep):
        kernel = kernel[deep] / square[deep]
        part = weights[:, deep] if weights.ndim == 3 else weights
        z = (point + 1j * height)[deep, 0]
        found[2:, here[deep]] -= z * np.einsum("...mn,mn->...m" if weights.ndim == 3 else "kn,mn->km", part, kernel)
