"""Dundurs' parameters: against the coupling that the condensed bodies have, which no formula of theirs went into."""

import numpy as np
import pytest

import halfplane_fe
from halfplane_fe.dundurs import dundurs
from halfplane_fe.interface import couple
from problems import COARSE, FEW_STEPS
from scenes import Elastic, Materials, load_scene

STEEL, RUBBER, CORK = (Elastic(young_modulus=e, poisson_ratio=nu) for e, nu in ((210e3, 0.3), (7e3, 0.45), (70e3, 0.0)))


def test_like_bodies_have_none_and_exchanged_ones_the_opposite() -> None:
    assert dundurs(Materials(upper=STEEL, lower=STEEL)) == (0.0, 0.0)
    one, other = dundurs(Materials(upper=RUBBER, lower=STEEL)), dundurs(Materials(upper=STEEL, lower=RUBBER))
    assert one.alpha > 0
    assert one.beta > 0
    assert other == (-one.alpha, -one.beta)


@pytest.mark.parametrize(("upper", "lower"), [(STEEL, RUBBER), (RUBBER, STEEL), (CORK, STEEL)])
def test_beta_is_the_jump_of_the_coupling_across_a_point_force(upper: Elastic, lower: Elastic) -> None:
    """A unit normal force draws a half-plane's face towards it by (1 - 2 nu)/(4 G) on either side.

    So the slip by pressure, K of the interface, jumps across the force by (1 - 2 nu2)/(2 G2) - (1 - 2 nu1)/(2 G1) = -2 beta/E*, 1
    being the upper body.
    """
    material = Materials(upper=upper, lower=lower)
    scene = load_scene("hertz-normal").vary(material=material)
    answer = halfplane_fe.solve(scene, COARSE, FEW_STEPS)
    assert answer.settings["dundurs"] == pytest.approx(dundurs(material)._asdict())
    interface = couple(*answer.condensed)
    assert interface.coupling is not None
    middle = int(np.argmin(np.abs(interface.x)))
    column = interface.coupling[:, middle]
    jump = float(column[-8] - column[7])
    assert -jump * answer.scales.modulus / 2 == pytest.approx(dundurs(material).beta, rel=0.03)
