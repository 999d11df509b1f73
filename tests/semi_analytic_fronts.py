"""Fronts of slip and the memory curve straight from P(t) and Q(t), in extended precision: no stack, no rule of the engine's.

# notation: eta load of a flat punch in the pile, M(eta) its share of Q; s = +1 forward, -1 reverse slip; low = s Q - f P, high =
#           s Q + f P; P_c load at the front of slip

The law of friction asks low + f eta <= s M(eta) <= high - f eta of every punch, at all times; otherwise M(eta) stays. Both bounds
meet while P passes eta. So M(eta, t) is where the largest lower and the least upper bound meet, looking back from t; and low grows
in forward slip, whose front is, tau being the last time at which low was above low(t),

    P_c(t) = [min of high over (tau, t) - low(t)]/(2 f)
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev

from scenes import ChebyshevSegment, HarmonicSegment, StraightSegment

LONG = np.longdouble
TURN = LONG("6.28318530717958647692528676655900577")
_SAMPLES = 2001


def root(function, value, low, high):
    """Times in [low, high] at which function = (values, rates), monotone there, has `value`, any shape: Newton inside a bracket."""
    value = np.asarray(value, dtype=LONG)
    a, b = np.full(value.shape, LONG(low)), np.full(value.shape, LONG(high))
    rising = np.sign(function(b)[0] - function(a)[0])
    t = (a + b) / 2
    for _ in range(140):
        now, rate = function(t)
        fault = rising * (now - value)
        a, b = np.where(fault <= 0, t, a), np.where(fault >= 0, t, b)
        newton = t - rising * fault / np.where(rate != 0, rate, 1)
        new = np.where((newton > a) & (newton < b) & (rate != 0), newton, (a + b) / 2)
        if np.all(np.abs(new - t) <= 3e-19 * np.abs(t)):
            break
        t = new
    return t


def _wave(waves, mean, t):
    value, rate = LONG(mean) + 0 * t, 0 * t
    for k, (size, phase) in enumerate(waves, 1):
        angle = k * t - LONG(phase)
        value, rate = value + LONG(size) * np.cos(angle), rate - k * LONG(size) * np.sin(angle)
    return value, rate


@dataclass(frozen=True, eq=False)
class Phase:
    """A stretch of one leg on which neither P nor Q - f P nor Q + f P turns round; `first`, `last`: ends of a straight leg."""

    leg: object
    begin: LONG
    end: LONG
    first: tuple = ()
    last: tuple = ()

    def loads(self, time):
        """P, Q, dP/dt, dQ/dt."""
        t, leg = np.asarray(time, dtype=LONG), self.leg
        if isinstance(leg, StraightSegment):
            length = LONG(leg.end) - LONG(leg.start)
            share = (t - LONG(leg.start)) / length
            steps = [last - first for first, last in zip(self.first, self.last, strict=True)]
            values = [first + step * share for first, step in zip(self.first, steps, strict=True)]
            return (*values, *(step / length + 0 * t for step in steps))
        if isinstance(leg, ChebyshevSegment):
            scale = 2 / (LONG(leg.end) - LONG(leg.start))
            u = (t - LONG(leg.start)) * scale - 1
            series = [np.array(part, dtype=LONG) for part in (leg.normal, leg.tangential)]
            rates = [chebyshev.chebval(u, chebyshev.chebder(part)) * scale for part in series]
            return (*(chebyshev.chebval(u, part) for part in series), *rates)
        waves = [leg.normal, leg.tangential]
        (p, p_rate), (q, q_rate) = (_wave(wave, mean, t) for wave, mean in zip(waves, leg.mean, strict=True))
        return p, q, p_rate, q_rate

    def of(self, normal, tangential):
        """The combination normal P + tangential Q as a function of time: value and rate."""

        def combined(time):
            p, q, p_rate, q_rate = self.loads(time)
            return normal * p + tangential * q, normal * p_rate + tangential * q_rate

        return combined

    def ends(self, normal, tangential):
        """The combination at begin and end."""
        return tuple(self.of(normal, tangential)(np.array([self.begin, self.end], dtype=LONG))[0])


def _phases(whole, friction):
    """A leg in phases: sign changes of the three rates among samples, halved to the last digit."""
    times = whole.begin + (whole.end - whole.begin) * np.linspace(0, 1, _SAMPLES).astype(LONG)
    marks = [whole.begin, whole.end]
    for what in ((LONG(1), 0), (-friction, 1), (friction, 1)):
        rate = lambda t, what=what: whole.of(*what)(t)[1]  # noqa: E731
        sign = np.sign(rate(times))
        sign[np.abs(rate(times)) <= 1e-17 * np.max(np.abs(rate(times)))] = 0
        known = np.flatnonzero(sign)
        for left, right in pairwise(known):
            if sign[left] != sign[right]:
                low, high = times[left], times[right]
                for _ in range(90):
                    middle = (low + high) / 2
                    low, high = (middle, high) if np.sign(rate(middle)) == sign[left] else (low, middle)
                marks.append((low + high) / 2)
    marks = sorted(marks)
    return [replace(whole, begin=a, end=b) for a, b in pairwise(marks) if b - a > 1e-17 * max(abs(a), abs(b))]


def phases_of(path, friction, cycles):
    """All phases of the initial loading and of `cycles` revolutions, and the number of the first phase of the last revolution."""
    friction, groups = LONG(friction), []
    if path.period is None:
        groups.append(path.initial_loading)
    else:
        groups += [path.initial_loading, *[path.cycle] * cycles]
    wholes = {}
    for leg in (*path.initial_loading, *path.cycle):
        begin, end = LONG(leg.start), LONG(leg.end)
        # A revolution ends where it began, to all digits.
        end = begin + TURN if isinstance(leg, HarmonicSegment) else end
        ends = [tuple(LONG(v) for v in getattr(leg, name, ())) for name in ("first", "last")]
        wholes[id(leg)] = Phase(leg, begin, end, *ends)
    if path.cycle:
        joint = wholes[id(path.initial_loading[-1])]
        wholes[id(path.initial_loading[-1])] = replace(joint, last=wholes[id(path.cycle[0])].loads(LONG(path.cycle[0].start))[:2])
    cut = {key: _phases(whole, friction) for key, whole in wholes.items()}
    listed = [[phase for leg in group for phase in cut[id(leg)]] for group in groups]
    return [phase for group in listed for phase in group], sum(len(group) for group in listed[:-1])


@dataclass(frozen=True, eq=False)
class Slip:
    """A span of time of a phase in which slip in one direction has its front on a line, or on an earlier phase `past`."""

    phase: Phase
    sign: int
    friction: LONG
    begin: LONG
    end: LONG
    level: LONG
    past: Phase | None = None

    @property
    def growth(self):
        """low as a function of time: value and rate."""
        return self.phase.of(-self.friction, self.sign)

    def front(self, time):
        """P_c."""
        low = self.growth(time)[0]
        if self.past is None:
            return (self.level - low) / (2 * self.friction)
        back = root(self.past.of(-self.friction, self.sign), low, self.past.begin, self.past.end)
        return self.past.loads(back)[0]


def slips_of(phases, number, friction):
    """The slips of phase `number` in both directions."""
    friction = LONG(friction)
    return [slip for sign in (1, -1) for slip in _slips(phases, number, sign, friction)]


def _slips(phases, number, sign, friction):
    """Looking back from a phase in which low rises: every phase in which low was higher gives one or two fronts."""
    phase = phases[number]
    first, last = phase.ends(-friction, sign)
    if not last > first:
        return
    reach, least = first, phase.ends(friction, sign)[0]
    for past in reversed(phases[:number]):
        if reach >= last:
            return
        (low, low_after), (high, high_after) = past.ends(-friction, sign), past.ends(friction, sign)
        least = min(least, high_after)
        if low_after > reach:  # the path jumps by rounding
            yield from _held(Slip(phase, sign, friction, reach, low_after, least), phase)
            reach = low_after
        if low > reach:
            turn = reach  # low at which high comes below what it was later
            if high < least:
                turn = past.of(-friction, sign)(root(past.of(friction, sign), least, past.begin, past.end))[0]
                turn = max(turn, reach)
            else:
                turn = low
            yield from _held(Slip(phase, sign, friction, reach, min(turn, last), least), phase)
            yield from _held(Slip(phase, sign, friction, turn, min(low, last), least, past), phase)
            reach = low
        least = min(least, high)
    # Nothing was higher: the unloaded state itself, low = 0, was met again to rounding.


def _held(slip, phase):
    """The slip with times in place of values of low, where there is any; where P falls the path may come to the other side."""
    if not slip.end > slip.begin:
        return
    marks = np.array([slip.begin, slip.end])
    lows = slip.growth(np.array([phase.begin, phase.end]))[0]
    times = np.where(marks == lows[1], phase.end, root(slip.growth, marks, phase.begin, phase.end))
    begin, end = np.where(marks == lows[0], phase.begin, times)  # half the digits of a root are lost where low turns
    if not end > begin:
        return
    found = replace(slip, begin=begin, end=end)
    inner = begin + (end - begin) * (np.arange(65).astype(LONG) + LONG(0.5)) / 65
    load = phase.loads(inner)[0]
    ahead = load - found.front(inner) > 1e-17 * load
    if np.all(ahead):
        yield found
    elif np.any(ahead):
        marks = [begin, end]
        for k in np.flatnonzero(ahead[1:] != ahead[:-1]):
            low, high = inner[k], inner[k + 1]
            for _ in range(80):
                middle = (low + high) / 2
                inside = phase.loads(middle)[0] - found.front(middle) > 0
                low, high = (middle, high) if inside == ahead[k] else (low, middle)
            marks.append((low + high) / 2)
        state = bool(ahead[0])
        for a, b in pairwise(sorted(marks)):
            if state:
                yield replace(found, begin=a, end=b)
            state = not state


def memory(phases, number, time, eta, friction):
    """M(eta) at `time` of phase `number`, 0 < eta <= P: where the largest lower and the least upper bound meet, looking back."""
    friction, eta, time = LONG(friction), LONG(eta), LONG(time)
    lowest, highest = -LONG(np.inf), LONG(np.inf)
    for past in [replace(phases[number], end=time), *reversed(phases[:number])]:
        below, above = past.of(-friction, 1), past.of(friction, 1)
        ends = np.array([past.end, past.begin], dtype=LONG)
        low, high = below(ends)[0] + friction * eta, above(ends)[0] - friction * eta
        for k in range(2):
            a, b = max(lowest, low[k]), min(highest, high[k])
            if a >= b:
                if k == 0:
                    return (a + b) / 2
                return _meeting(past, below, above, friction * eta, lowest, highest)
            if k == 0:
                lowest, highest = a, b
        lowest, highest = max(lowest, low[1]), min(highest, high[1])
    return (lowest + highest) / 2


def _meeting(past, below, above, half, lowest, highest):
    """The value at which both bounds meet within a phase."""
    late, early = past.end, past.begin
    for _ in range(100):
        middle = (late + early) / 2
        if max(lowest, below(middle)[0] + half) >= min(highest, above(middle)[0] - half):
            early = middle
        else:
            late = middle
    a, b = max(lowest, below(early)[0] + half), min(highest, above(early)[0] - half)
    return (a + b) / 2
