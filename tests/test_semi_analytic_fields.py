"""Tractions, slip and shift at extreme points of extreme scenes, by brute force in more digits (`semi_analytic_oracle`)."""

import math

import mpmath as mp
import numpy as np
import pytest

from scenes import EllipseLeg
from semi_analytic.arcs import arc_slip
from semi_analytic.power_law import PowerLawContact


@pytest.mark.parametrize("n", [2.0, 7.0, 20.0, 40.0])
@pytest.mark.parametrize("place", [1.01, 3.0, 10.0])
def test_slip_of_an_arc_where_the_load_to_reach_it_is_far_above_all(n, place):
    """The sine part of an arc at thirty digits, P_x being up to 10^40 times P: a short arc was lost in the last digits of a large
    logarithm, 1e-5 of it at 3 a of |x|^40, all of it at 10 a. Measured: 3e-14 at 1.01 a, 5e-16 farther out.
    """
    contact = PowerLawContact(1.0, n, 1.0, 1.0, 3.0)
    leg, first, last = EllipseLeg(0.0, 10.0, (1.0, 0.0), (0.3, 0.3), 1.0), math.pi + 1.5, math.pi + 2.3
    x = place * contact.half_width(leg.loads(np.array([last]))[0])
    with mp.workdps(30):

        def moved(t):
            half = ((1 + mp.mpf(0.3) * mp.cos(t)) / contact.factor) ** (1 / mp.mpf(n))
            return mp.mpf(0.3) * mp.sin(1) * mp.cos(t) * mp.acosh(mp.mpf(x.item()) / half)

        exact = float(mp.quad(moved, [first, last]))
    assert arc_slip(contact, leg, first, np.array([last]), x).item() == pytest.approx(exact, rel=1e-13, abs=0)
