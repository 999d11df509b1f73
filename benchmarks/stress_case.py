"""What a case of numerical stress is, what a trial finds, and the scenes that both engines are put under it with."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

import mpmath
import numpy as np

from scenes import ContactSolution, Elastic, EllipseLoad, Friction, Hertz, Materials, PolygonLoad, Profile, Scene
from scenes.scene import Load


@dataclass(frozen=True)
class Found:
    """What a trial measured.

    Attributes
    ----------
    errors : by the name of what is off, for instance {"p": 0.01}; each is held against the case's limit
    notes : what the answer itself says of its uncertainty
    shown : figures that stand in the table and are held against nothing
    """

    errors: Mapping[str, float]
    notes: tuple[str, ...] = ()
    shown: Mapping[str, float] = field(default_factory=dict)


Trial = tuple[str, Callable[[], "float | Found"]]


@dataclass(frozen=True)
class Case:
    """A few trials of one kind.

    Attributes
    ----------
    engine, what, tried : who, which end of the range, and the values
    measure : what the error is of and against what
    limit : of each error
    trials : called for (name, function that gives errors or refuses)
    may_refuse, must_refuse : whether some or all of the trials may or must end in a sentence
    may_tell : whether an error above the limit passes if the answer says so: it is shown with its note, and counted as told
    """

    engine: str
    what: str
    tried: str
    measure: str
    limit: float
    trials: Callable[[], Iterable[Trial]]
    may_refuse: bool = False
    must_refuse: bool = False
    may_tell: bool = False


def like(modulus: float = 1.0, poisson_ratio: float = 0.0) -> Materials:
    """Like bodies with that E*."""
    body = Elastic(young_modulus=2 * modulus * (1 - poisson_ratio**2), poisson_ratio=poisson_ratio)
    return Materials(upper=body, lower=body)


def scene_of(load: Load, friction: float = 0.5, profile: Profile | None = None, material: Materials | None = None) -> Scene:
    """Hertz of radius 100 and E* = 1 where nothing else is said."""
    return Scene(
        name="stress",
        material=material or like(),
        profile=profile or Hertz(radius=100.0),
        friction=Friction(coefficient=friction),
        load=load,
    )


def ellipse(p0: float, p1: float, q0: float, q1: float, phase: float) -> EllipseLoad:
    """P0, P1, Q0, Q1 and the phase in degrees."""
    return EllipseLoad(
        mean_normal_load=p0, normal_amplitude=p1, mean_tangential_load=q0, tangential_amplitude=q1, phase_degrees=phase
    )


def to_and_fro(share: float, friction: float, load: float = 1.0) -> PolygonLoad:
    """Q between +-share f P at constant P."""
    force = share * friction * load
    return PolygonLoad(initial_loading=((load, 0.0),), cycle=((load, force), (load, -force)))


def mindlin(share: mpmath.mpf, friction: float, load: float = 1.0) -> mpmath.mpf:
    """W of a cycle of Q between +-share f P at constant P, E* = 1; finite at share = 1."""
    with mpmath.workdps(60):
        k = mpmath.mpf(share)
        log = (1 - k) * mpmath.log(1 - k) if k < 1 else mpmath.mpf(0)
        return 4 * (mpmath.mpf(friction) * load) ** 2 / mpmath.pi * (log + k - k * k / 2)


def broken_by(answer: ContactSolution) -> float:
    """The worst certificate."""
    return max(float(np.max(values)) for values in answer.record.certificates.values())
