"""What a case of numerical stress is, and the scenes that both engines are put under it with."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from scenes import Elastic, EllipseLoad, Friction, Hertz, Materials, PolygonLoad, Profile, Scene
from scenes.scene import Load

Trial = tuple[str, Callable[[], float]]


@dataclass(frozen=True)
class Case:
    """A few trials of one kind.

    Attributes
    ----------
    engine, what, tried : who, which end of the range, and the values
    measure : what the error is of and against what
    limit : of each error
    trials : called for (name, function that gives an error or refuses)
    may_refuse, must_refuse : whether some or all of the trials may or must end in a sentence
    """

    engine: str
    what: str
    tried: str
    measure: str
    limit: float
    trials: Callable[[], Iterable[Trial]]
    may_refuse: bool = False
    must_refuse: bool = False


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
    return PolygonLoad(way_in=((load, 0.0),), cycle=((load, force), (load, -force)))
