"""Old names of load segments, for callers that still ask for the type of a segment. To be deleted with the last of these."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from scenes.segments import ChebyshevSegment, HarmonicSegment, LoadSegment, StraightSegment, ellipse_segment, parabola_segment

if TYPE_CHECKING:
    EllipseLeg = HarmonicSegment
    ParabolaLeg = ChebyshevSegment
else:

    class _OldName(type):
        """A call makes a segment, `isinstance` asks what it is."""

        make: Callable[..., LoadSegment]

        def __call__(cls, *args):
            return cls.make(*args)

        def __instancecheck__(cls, segment):
            return cls.holds(segment)

    class EllipseLeg(metaclass=_OldName):
        """P is largest at t = 0; not the cycle of a `HarmonicLoad`, which starts at 0 and not at the paper's point A."""

        make = staticmethod(ellipse_segment)

        @staticmethod
        def holds(segment):
            wave = getattr(segment, "ellipse", None)
            return wave is not None and wave.origin == 0 and segment.start != 0

    class ParabolaLeg(metaclass=_OldName):
        """P linear in time, Q a parabola of P."""

        make = staticmethod(parabola_segment)

        @staticmethod
        def holds(segment):
            return not isinstance(segment, StraightSegment) and segment.slope_and_bend(segment.end) is not None


StraightLeg = StraightSegment
HarmonicLeg = HarmonicSegment
ChebyshevLeg = ChebyshevSegment
Leg = LoadSegment
