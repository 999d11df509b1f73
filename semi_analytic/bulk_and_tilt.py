"""From a scene with bulk stress and tilt to the family of its contact intervals: which load paths have one memory curve.

# notation: alpha tilt, eps = sigma_lower/E'_lower - sigma_upper/E'_upper with E' = E/(1 - nu^2), kappa as in `unsymmetric`
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from scenes import NORMAL_LOAD, Hertz, InputError, LoadPath, LoadSegment, Materials, Scene
from semi_analytic.elasticity import composite_modulus
from semi_analytic.tilted_profile import NestedIntervals, TiltedProfile, piecewise_parabola
from semi_analytic.unsymmetric import TiltedParabola

Array = NDArray[np.float64]

# Share of the largest value within which two affine functions are one.
_ROUNDING = 1e-11
# Instants of a curved leg that are compared, besides two for each turn that it may take.
_SAMPLES = 40


@dataclass(frozen=True, eq=False)
class OneCurve:
    """A load path with bulk stress and tilt whose memory is one curve.

    Attributes
    ----------
    contact : the nested intervals of its family
    path : P and Q alone
    bulk, turning : stresses of both bodies, tilt and moment as paths over the same time; None for none
    moment_given : whether `turning` states the moment
    """

    contact: TiltedParabola | TiltedProfile
    path: LoadPath
    bulk: LoadPath | None
    turning: LoadPath | None
    moment_given: bool

    def series(self, time: Array, load: Array) -> dict[str, Array]:
        """Bulk stresses, tilt and moment at instants (n,) with the normal loads (n,)."""
        # Somebody else's instant may be before the start by rounding.
        inside = np.maximum(time, self.path.start)
        lower, upper = self.bulk.at(inside) if self.bulk is not None else np.zeros((2, len(time)))
        tilt, moment = self.turning.at(inside) if self.turning is not None else np.zeros((2, len(time)))
        if self.moment_given and isinstance(self.contact, TiltedParabola):
            tilt = _tilt_of(self.contact.radius, load, moment)
        else:
            moment = self.contact.moment(load, tilt)
        return {"bulk_stress_lower": lower, "bulk_stress_upper": upper, "tilt": tilt, "moment": moment}


def _tilt_of(radius: float, load: Array, moment: Array) -> Array:
    """Tilt of a parabola that carries `moment`; 0 where it carries no load."""
    return -moment / (radius * np.where(load > 0, load, np.inf))


def strain_of(materials: Materials) -> tuple[float, float]:
    """What the bulk stress of the lower and of the upper body adds to eps: 1/E' and -1/E', E' = E/(1 - nu^2) (plane strain).

    >>> strain_of(Materials(lower=Elastic(young_modulus=0.91, poisson_ratio=0.3), upper=Elastic(young_modulus=2, poisson_ratio=0)))
    (1.0, -0.5)
    """
    lower, upper = ((1 - body.poisson_ratio**2) / body.young_modulus for body in (materials.lower, materials.upper))
    return lower, -upper


def one_curve(scene: Scene) -> OneCurve | None:
    """The scene's path where its memory is one curve: alpha = alpha_0 + kappa P and eps = eps_0 + kappa Q with nested intervals.

    While the load is pressed on at first, with no Q and no change of bulk strain, the tilt may do what it will: nothing is sheared,
    and nothing is remembered. None where there is another memory, or intervals are not nested.

    Raises
    ------
    InputError
        For a profile that is no piecewise parabola, a moment on another one than Hertz', a contact that leaves the profile.
    """
    path, profile = scene.load.path(), scene.profile
    legs = (*path.initial_loading, *path.cycle)
    radius = profile.radius if isinstance(profile, Hertz) else None
    shape = piecewise_parabola(profile)
    if shape is None:
        raise InputError(
            f"profile.kind = {profile.kind!r}: under bulk stress or tilt half-plane theory takes hertz, flat_rounded, compound, "
            "wedge and tabulated"
        )
    found = [_sampled(leg, radius, strain_of(scene.material), path.moment_given) for leg in legs]
    first = 0
    largest, _, strained = np.max([np.max(np.abs(each[:3]), axis=1) for each in found], axis=0).tolist()
    while first < len(path.initial_loading) and _presses_only(found[first], largest, strained):
        first += 1
    p, q, eps, alpha = np.concatenate(found[first:] or [found[-1][:, -1:]], axis=1)
    turned = np.isfinite(alpha)
    slope = _slope_of(q, eps) if np.ptp(q) > _ROUNDING * np.max(np.abs(q)) else _slope_of(p[turned], alpha[turned])
    tilt = float(np.mean(alpha[turned] - slope * p[turned])) if np.any(turned) else 0.0
    offset = eps - slope * q
    apart = np.abs(alpha[turned] - tilt - slope * p[turned])
    if np.ptp(offset) > _ROUNDING * (np.max(np.abs(eps)) + abs(slope) * np.max(np.abs(q))):
        return None
    if np.any(apart > _ROUNDING * (np.max(np.abs(alpha[turned])) + abs(slope) * np.max(p))):
        return None
    modulus, datum, most = composite_modulus(scene.material), profile.datum_length, float(np.max(p))
    contact: TiltedParabola | TiltedProfile
    if radius is not None:
        contact = TiltedParabola(modulus, radius, datum, tilt=tilt, slope=slope)
    else:
        contact = TiltedProfile(NestedIntervals(shape, 2 / modulus, tilt, slope, most), datum)
    if not contact.is_nested(most):
        return None
    loading, cycle = (tuple(replace(leg, bulk=None, turning=None) for leg in part) for part in (path.initial_loading, path.cycle))
    bare, bulk, turning = LoadPath(loading, cycle), _companions(path, "bulk"), _companions(path, "turning")
    return OneCurve(contact, bare, bulk, turning, path.moment_given)


def _presses_only(samples: Array, largest: float, strained: float) -> bool:
    """Whether a leg has no Q and no change of bulk strain, to rounding of the largest P and eps."""
    _, q, eps, _ = samples
    return bool(np.max(np.abs(q)) <= _ROUNDING * largest and np.ptp(eps) <= _ROUNDING * strained)


def _sampled(leg: LoadSegment, radius: float | None, strain: tuple[float, float], moment_given: bool) -> Array:
    """P, Q, eps and alpha at instants of a leg, (4, n): enough to tell two legs apart; no alpha where a moment has no load.

    InputError for a moment where there is no radius to find the tilt from.
    """
    parts = [part for part in (leg, leg.bulk, leg.turning) if part is not None]
    turns = max(part.most_turns for part in parts)
    share = np.linspace(0, 1, 3) if all(part.is_straight for part in parts) else np.linspace(0, 1, _SAMPLES + 2 * turns)
    # The turning points too: the largest load is among them.
    time = np.unique(np.append(leg.start + (leg.end - leg.start) * share, leg.turning_points(NORMAL_LOAD)))
    p, q = leg.loads(time)
    lower, upper = leg.bulk.loads(time) if leg.bulk is not None else (0.0, 0.0)
    tilt, moment = leg.turning.loads(time) if leg.turning is not None else (0.0 * p, 0.0 * p)
    if moment_given and np.any(moment):
        if radius is None:
            raise InputError("load: half-plane theory takes a moment or a line of action under the parabola alone; state the tilt")
        tilt = np.where(p > 0, _tilt_of(radius, p, moment), np.nan)
    return np.stack([p, q, strain[0] * lower + strain[1] * upper + 0 * p, tilt])


def _slope_of(load: Array, what: Array) -> float:
    """Least-squares slope; 0 where the load is constant."""
    away = load - np.mean(load) if len(load) else load
    square = float(away @ away)
    return float(away @ what) / square if square > 0 and np.ptp(load) > _ROUNDING * np.max(np.abs(load)) else 0.0


def _companions(path: LoadPath, name: str) -> LoadPath | None:
    """What all segments carry under this name, as a path."""
    loading, cycle = ([getattr(leg, name) for leg in legs] for legs in (path.initial_loading, path.cycle))
    return None if None in (*loading, *cycle) else LoadPath(tuple(loading), tuple(cycle))
