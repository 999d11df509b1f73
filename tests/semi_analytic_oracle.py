"""Fields, friction work, edges of slip and memory of any scene by brute force in extended
precision, without the engine's rules.

# notation: alpha half-width of a punch, g = dP/d alpha, M(eta) memory, A = 2/E*; s = +1 forward, -1
#           reverse slip; low = s Q - f P, high = s Q + f P; P_c load at the edge of the slip zone;
#           P_x load at which a = |x|

Fields:  p = (1/pi) int g/sqrt(alpha^2 - x^2), q the same with M', s = (A/pi) int M' g
arccosh(|x|/alpha),
         U = (A/pi) int M' g ln(2 L/alpha).
Memory:  Coulomb's law asks low + f eta <= s M(eta) <= high - f eta of every punch; both bounds meet
         while P passes eta. So M(eta, t) is where the largest lower and the least upper bound meet,
         looking back, and
         P_c(t) = [min of high over (tau, t) - low(t)]/(2 f), tau being the last time at which low
         was above low(t).
Work:    W(x) = (f A/pi) int p(x, P) low' arccosh(|x|/c) dt,
         W = (f A/pi) int low' int_{P_c}^P ln(a(eta)/c) d eta dt.

Each integral by one rule for singular ends between all knots and corners. Of the fields the knots
of the memory are the engine's own.
"""

import math
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise

import mpmath as mp
import numpy as np
from numpy.polynomial import chebyshev

from scenes import CallableProfile, ChebyshevSegment, HarmonicSegment, PowerLaw, StraightSegment
from semi_analytic.history import history_of
from semi_analytic.memory import pieces
from semi_analytic.profiles import contact_of

LONG = np.longdouble
PI = LONG("3.14159265358979323846264338327950288")


def _rule(step):
    s = LONG(step) * np.arange(-round(46 / step), round(46 / step) + 1)
    near = 1 / (1 + np.exp(np.abs(s)))
    return s < 0, near, LONG(step) * near * (1 - near)


_RULES = {step: _rule(step) for step in (0.1, 0.2)}


def integrate(function, marks, step=0.2):
    """int function between consecutive marks: trapezoidal rule in s of 1/(1 + exp(-s))."""
    lower, near, weight = _RULES[step]
    total = LONG(0)
    for begin, end in pairwise(marks):
        if end > begin:
            length = end - begin
            total += length * np.sum(
                weight * function(np.where(lower, begin + length * near, end - length * near))
            )
    return total


def _flat(half, b):
    """P of a flat of half-length b whose edges have h'' = 1: (alpha^2 arccos(b/alpha) - b
    sqrt(alpha^2 - b^2))/2.
    """
    if b == 0:
        return PI / 4 * half * half
    tau = np.sqrt(np.maximum((half - b) * (half + b), 0)) / b
    area = (1 + tau * tau) * np.arctan(tau) - tau
    if np.all(tau >= 0.1):
        return b * b / 2 * area
    small = np.minimum(tau, LONG(0.1))
    series = 0 * small
    for k in range(11, 0, -1):
        series = small * small * (2 / LONG(4 * k * k - 1) - series)
    series = series * small
    return b * b / 2 * np.where(tau < 0.1, series, area)


def _flat_rate(half, b):
    return half * np.arctan2(np.sqrt(np.maximum((half - b) * (half + b), 0)), b)


@dataclass(frozen=True)
class Bends:
    """h'' that jumps by `jumps` at `knots`: Hertz, flat and rounded, compound, wedge, tables. E* =
    1.
    """

    knots: tuple
    jumps: tuple

    @property
    def breaks(self):
        return self.knots

    def load(self, half):
        return sum(jump * _flat(half, b) for b, jump in zip(self.knots, self.jumps, strict=True))

    def rate(self, half):
        return sum(
            jump * _flat_rate(half, b) for b, jump in zip(self.knots, self.jumps, strict=True)
        )


@cache
def _sine_power(n):
    """int_0^(pi/2) sin^n."""
    with mp.workdps(40):
        value = mp.sqrt(mp.pi) / 2 * mp.gamma((mp.mpf(n) + 1) / 2) / mp.gamma(mp.mpf(n) / 2 + 1)
        return LONG(mp.nstr(value, 25))


@dataclass(frozen=True)
class Powers:
    """h = sum c |x|^n by (n, c). E* = 1."""

    terms: tuple
    breaks = (LONG(0),)

    def _sum(self, half, order):
        total = LONG(0) * half
        for n, c in self.terms:
            total = total + _sine_power(n) * n * c * n**order * half ** LONG(n - order)
        return total

    def load(self, half):
        return self._sum(half, 0)

    def rate(self, half):
        return self._sum(half, 1)


def law_of(profile):
    """The same pile of punches from the numbers of the scene alone."""
    kind = profile.kind if not isinstance(profile, CallableProfile) else "callable"
    match kind:
        case "hertz":
            return Bends((LONG(0),), (1 / LONG(profile.radius),))
        case "flat_rounded":
            return Bends((LONG(profile.flat_half_length),), (1 / LONG(profile.radius),))
        case "compound":
            inner_curvature = 1 / LONG(profile.inner_radius)
            outer_curvature = 1 / LONG(profile.outer_radius)
            return Bends(
                (LONG(0), LONG(profile.inner_half_length)),
                (inner_curvature, outer_curvature - inner_curvature),
            )
        case "wedge":
            return Bends(
                (LONG(0), LONG(profile.tip_half_length)),
                (1 / LONG(profile.tip_radius), -1 / LONG(profile.tip_radius)),
            )
        case "power_law":
            assert isinstance(profile, PowerLaw)
            n = float(profile.exponent)
            return Powers(((n, LONG(profile.rise) / LONG(profile.length) ** LONG(n)),))
        case "polynomial":
            length = LONG(profile.length)
            return Powers(
                tuple(
                    (2.0 * k, LONG(c) / length ** (2 * k)) for k, c in enumerate(profile.rises, 1)
                )
            )
        case "tabulated":
            spline = profile.spline()
            bends = np.concatenate([[0.0], spline.curvature]).astype(LONG)
            jumps = np.diff(bends)
            first = int(np.flatnonzero(jumps)[0])
            return Bends(tuple(LONG(v) for v in spline.x[first:-1]), tuple(jumps[first:]))
    # a slope by differences has ten digits
    part = LONG(round(float(profile.slope(np.array(1.0)) / np.sinh(1.0)), 9))
    # part (cosh x - 1)
    return Powers(tuple((2.0 * k, part / LONG(math.factorial(2 * k))) for k in range(1, 31)))


def half_width(law, load, guess):
    """a(P), (n,): Newton's method inside a bracket about a guess."""
    load, guess = (np.atleast_1d(np.asarray(values, dtype=LONG)) for values in (load, guess))
    least = law.breaks[0]
    low = np.full(load.shape, least)
    high = 2 * guess + least
    half = np.maximum(guess, least)
    for _ in range(100):
        fault = law.load(half) - load
        rate = law.rate(half)
        low = np.where(fault <= 0, half, low)
        high = np.where(fault >= 0, half, high)
        newton = half - fault / np.where(rate > 0, rate, 1)
        new = np.where((newton >= low) & (newton <= high) & (rate > 0), newton, (low + high) / 2)
        if np.all(np.abs(new - half) <= 3e-19 * half):
            break
        half = new
    return np.where(load > 0, half, least)


class Punches:
    """Integrals over the superposition of flat punches of a profile, E* = 1, each weighted by a
    function of the half-width.
    """

    def __init__(self, profile, step=0.2):
        self.law = law_of(profile)
        self.datum = LONG(profile.datum_length)
        self.step = step
        self.least = self.law.breaks[0]

    def _marks(self, low, high):
        return [low, *(b for b in self.law.breaks if low < b < high), high]

    def traction(self, x, low, high, weight=None):
        """(1/pi) int dP/sqrt(alpha^2 - x^2) with alpha^2 = x^2 + w^2."""
        low = max(low, x)
        if not high > low:
            return LONG(0)

        def strip(w):
            alpha = np.sqrt(x * x + w * w)
            return (1 if weight is None else weight(alpha)) * self.law.rate(alpha) / alpha / PI

        return integrate(
            strip, [np.sqrt((m - x) * (m + x)) for m in self._marks(low, high)], self.step
        )

    def total(self, kernel, low, high, weight=None):
        """int kernel(alpha) dP."""
        if not high > low:
            return LONG(0)

        def strip(alpha):
            factor = 1 if weight is None else weight(alpha)
            return factor * self.law.rate(alpha) * kernel(alpha)

        return integrate(strip, self._marks(low, high), self.step)

    def slip(self, x, low, high, weight=None):
        """int arccosh(x/alpha) dP."""
        return self.total(
            lambda alpha: np.arcsinh(np.sqrt((x - alpha) * (x + alpha)) / alpha),
            low,
            min(high, x),
            weight,
        )

    def log(self, low, high, weight=None):
        """int ln(2 L/alpha) dP."""
        return self.total(lambda alpha: np.log(2 * self.datum / alpha), low, high, weight)


def _slope_on(piece):
    """M' as a function of eta on a piece of the engine's curve."""
    leg = piece.anchor.segment
    anchor = LONG(piece.anchor.normal_load)
    if piece.arc_times is None:
        return lambda eta: LONG(piece.slope) + 2 * LONG(piece.bend) * (eta - anchor)
    if leg.ellipse:
        p0, p1, q1 = (LONG(v) for v in (leg.mean[0], *leg.ellipse.amplitude))
        sine = np.sin(LONG(leg.ellipse.phase_radians))
        cosine = np.cos(LONG(leg.ellipse.phase_radians))

        def slope(eta):
            # At an end of the arc the difference may round to 0, where M' has no bound.
            up, down = (
                np.maximum(way / (2 * p1), LONG(1e-40))
                for way in (eta - (p0 - p1), (p0 + p1) - eta)
            )
            return q1 / p1 * (cosine + sine * (up - down) / (2 * np.sqrt(up * down)))

        return slope
    wave = lambda t: _load_and_rate(leg.normal, leg.mean[0], t)  # noqa: E731

    def slope(eta):
        """Q'/P' at the time on the arc at which P = eta."""
        t = root(wave, eta, piece.arc_times[0], piece.anchor.time)
        return _load_and_rate(leg.tangential, 0, t)[1] / wave(t)[1]

    return slope


class Oracle(Punches):
    """Every field of one scene; `at` gives those of one of `times` at points x."""

    def __init__(self, scene, times):
        history = history_of(
            scene.load.path(),
            scene.friction.coefficient,
            scene.cycles,
            np.array(times, dtype=float),
        )
        super().__init__(scene.profile)
        self.snapshot = history.snapshot(np.array(times, dtype=float))
        self.contact = contact_of(scene.profile, scene.material)

    def half(self, load):
        return half_width(self.law, load, float(self.contact.half_width(load))).item()

    def parts(self, k):
        """(lower, upper half-width, M') of the curve of instant k, M' as a function of the
        half-width.
        """
        s = self.snapshot
        load = self.law.load
        front = float(s.load[k] - s.slip_zone_load[k])
        if s.slip_zone_load[k]:
            line = LONG(float(s.direction[k]) * s.friction)
            yield self.half(front), self.half(float(s.load[k])), lambda alpha: line + 0 * alpha
        upper = front
        for piece in pieces(s.sticking_pieces[s.piece_number[k]]):
            # What an arc starts from is its time: P0 + P1 cos t may have few digits of a small P.
            leg = piece.anchor.segment
            slope = _slope_on(piece)
            bottom = (
                piece.bottom_load
                if piece.arc_times is None
                else _load_and_rate(leg.normal, leg.mean[0], LONG(piece.arc_times[0]))[0]
            )
            yield self.half(bottom), self.half(upper), lambda alpha, slope=slope: slope(load(alpha))
            upper = piece.bottom_load

    def at(self, k, x):
        """pressure, shear and slip at |x| (m,), and shift, approach, contact and stick half-width,
        of instant k.
        """
        half = self.half(float(self.snapshot.load[k]))
        parts = list(self.parts(k))
        points = np.abs(np.asarray(x, dtype=float)).astype(LONG)

        def shear(place):
            return sum(self.traction(place, *part) for part in parts)

        def slip(place):
            return 2 / PI * sum(self.slip(place, *part) for part in parts)

        return {
            "pressure": np.array([self.traction(at, self.least, half) for at in points]),
            "shear": np.array([shear(place) for place in points]),
            "slip": np.array([slip(place) for place in points]),
            "tangential_displacement": 2 / PI * sum(self.log(*part) for part in parts),
            "normal_approach": 2 / PI * self.log(self.least, half),
            "contact_half_width": half,
            "stick_half_width": self.half(
                float(self.snapshot.load[k] - self.snapshot.slip_zone_load[k])
            ),
        }


# ------------------------------------------------------- the path, its edges of slip and its memory


TURN = LONG("6.28318530717958647692528676655900577")
_SAMPLES = 2001


def root(function, value, low, high):
    """Times in [low, high] at which function = (values, rates), monotone there, has `value`, any
    shape: Newton inside a bracket.
    """
    value = np.asarray(value, dtype=LONG)
    a = np.full(value.shape, LONG(low))
    b = np.full(value.shape, LONG(high))
    rising = np.sign(function(b)[0] - function(a)[0])
    t = (a + b) / 2
    for _ in range(140):
        now, rate = function(t)
        fault = rising * (now - value)
        a = np.where(fault <= 0, t, a)
        b = np.where(fault >= 0, t, b)
        newton = t - rising * fault / np.where(rate != 0, rate, 1)
        new = np.where((newton > a) & (newton < b) & (rate != 0), newton, (a + b) / 2)
        if np.all(np.abs(new - t) <= 3e-19 * np.abs(t)):
            break
        t = new
    return t


def _load_and_rate(waves, mean, t):
    """mean + sum of waves, and its rate."""
    angles = [(LONG(size), k, k * t - LONG(phase)) for k, (size, phase) in enumerate(waves, 1)]
    return (
        sum((size * np.cos(angle) for size, _, angle in angles), LONG(mean) + 0 * t),
        sum((-k * size * np.sin(angle) for size, k, angle in angles), 0 * t),
    )


@dataclass(frozen=True, eq=False)
class Phase:
    """A stretch of one leg on which neither P nor Q - f P nor Q + f P turns round; `first`, `last`:
    ends of a straight leg.
    """

    leg: object
    begin: LONG
    end: LONG
    first: tuple = ()
    last: tuple = ()

    def loads(self, time):
        """P, Q, dP/dt, dQ/dt."""
        t = np.asarray(time, dtype=LONG)
        leg = self.leg
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
        (p, p_rate), (q, q_rate) = (
            _load_and_rate(wave, mean, t) for wave, mean in zip(waves, leg.mean, strict=True)
        )
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


def _phases(wave_of_loads, friction):
    """A leg in phases: sign changes of the three rates among samples, halved to the last digit."""
    times = wave_of_loads.begin + (wave_of_loads.end - wave_of_loads.begin) * np.linspace(
        0, 1, _SAMPLES
    ).astype(LONG)
    marks = [wave_of_loads.begin, wave_of_loads.end]
    for combination in ((LONG(1), 0), (-friction, 1), (friction, 1)):
        rate = lambda t, combination=combination: wave_of_loads.of(*combination)(t)[1]  # noqa: E731
        sign = np.sign(rate(times))
        sign[np.abs(rate(times)) <= 1e-17 * np.max(np.abs(rate(times)))] = 0
        known = np.flatnonzero(sign)
        for left, right in pairwise(known):
            if sign[left] != sign[right]:
                low = times[left]
                high = times[right]
                for _ in range(90):
                    middle = (low + high) / 2
                    low, high = (
                        (middle, high) if np.sign(rate(middle)) == sign[left] else (low, middle)
                    )
                marks.append((low + high) / 2)
    marks = sorted(marks)
    return [
        replace(wave_of_loads, begin=a, end=b)
        for a, b in pairwise(marks)
        if b - a > 1e-17 * max(abs(a), abs(b))
    ]


def phases_of(path, friction, cycles):
    """All phases of the initial loading and of `cycles` revolutions, and the number of the first
    phase of the last revolution.
    """
    friction = LONG(friction)
    groups = []
    if path.period is None:
        groups.append(path.initial_loading)
    else:
        groups += [path.initial_loading, *[path.cycle] * cycles]
    wholes = {}
    for leg in (*path.initial_loading, *path.cycle):
        begin = LONG(leg.start)
        end = LONG(leg.end)
        # A revolution ends where it began, to all digits.
        end = begin + TURN if isinstance(leg, HarmonicSegment) else end
        first = tuple(map(LONG, getattr(leg, "first_point", ())))
        last = tuple(map(LONG, getattr(leg, "last_point", ())))
        wholes[id(leg)] = Phase(leg, begin, end, first, last)
    if path.cycle:
        joint = wholes[id(path.initial_loading[-1])]
        wholes[id(path.initial_loading[-1])] = replace(
            joint, last=wholes[id(path.cycle[0])].loads(LONG(path.cycle[0].start))[:2]
        )
    cut = {key: _phases(wave_of_loads, friction) for key, wave_of_loads in wholes.items()}
    phases = []
    for group in groups:
        before_last_group = len(phases)
        for leg in group:
            phases += cut[id(leg)]
    return phases, before_last_group


@dataclass(frozen=True, eq=False)
class Slip:
    """A span of time of a phase in which slip in one direction has its front on a line, or on an
    earlier phase `past`.
    """

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
    """Looking back from a phase in which low rises: every phase in which low was higher gives one
    or two fronts.
    """
    phase = phases[number]
    first, last = phase.ends(-friction, sign)
    if not last > first:
        return
    reach = first
    least = phase.ends(friction, sign)[0]
    for past in reversed(phases[:number]):
        if reach >= last:
            return
        low, low_after = past.ends(-friction, sign)
        high, high_after = past.ends(friction, sign)
        least = min(least, high_after)
        if low_after > reach:  # the path jumps by rounding
            yield from _held(Slip(phase, sign, friction, reach, low_after, least), phase)
            reach = low_after
        if low > reach:
            turn = reach  # low at which high comes below what it was later
            if high < least:
                turn = past.of(-friction, sign)(
                    root(past.of(friction, sign), least, past.begin, past.end)
                )[0]
                turn = max(turn, reach)
            else:
                turn = low
            yield from _held(Slip(phase, sign, friction, reach, min(turn, last), least), phase)
            yield from _held(Slip(phase, sign, friction, turn, min(low, last), least, past), phase)
            reach = low
        least = min(least, high)


def _held(slip, phase):
    """The slip with times in place of values of low, where there is any; where P falls the path may
    come to the other side.
    """
    if not slip.end > slip.begin:
        return
    marks = np.array([slip.begin, slip.end])
    lows = slip.growth(np.array([phase.begin, phase.end]))[0]
    times = np.where(marks == lows[1], phase.end, root(slip.growth, marks, phase.begin, phase.end))
    # half the digits of a root are lost where low turns
    begin, end = np.where(marks == lows[0], phase.begin, times)
    if not end > begin:
        return
    held_slip = replace(slip, begin=begin, end=end)
    # Crowded to both ends: what lies between an end and the first of them is lost, with the cube of
    # its length.
    inner = (
        begin + (end - begin) * np.sin((np.arange(129).astype(LONG) + LONG(0.5)) * PI / 258) ** 2
    )
    load = phase.loads(inner)[0]
    ahead = load - held_slip.front(inner) > 1e-17 * load
    if np.all(ahead):
        yield held_slip
    elif np.any(ahead):
        marks = [begin, end]
        for k in np.flatnonzero(ahead[1:] != ahead[:-1]):
            low = inner[k]
            high = inner[k + 1]
            for _ in range(80):
                middle = (low + high) / 2
                inside = phase.loads(middle)[0] - held_slip.front(middle) > 0
                low, high = (middle, high) if inside == ahead[k] else (low, middle)
            marks.append((low + high) / 2)
        state = bool(ahead[0])
        for a, b in pairwise(sorted(marks)):
            if state:
                yield replace(held_slip, begin=a, end=b)
            state = not state


def memory(phases, number, time, eta, friction):
    """M(eta) at `time` of phase `number`, 0 < eta <= P: where the largest lower and the least upper
    bound meet, looking back.
    """
    friction = LONG(friction)
    eta = LONG(eta)
    time = LONG(time)
    lowest = -LONG(np.inf)
    highest = LONG(np.inf)
    for past in [replace(phases[number], end=time), *reversed(phases[:number])]:
        below = past.of(-friction, 1)
        above = past.of(friction, 1)
        ends = np.array([past.end, past.begin], dtype=LONG)
        low = below(ends)[0] + friction * eta
        high = above(ends)[0] - friction * eta
        for k in range(2):
            a = max(lowest, low[k])
            b = min(highest, high[k])
            if a >= b:
                if k == 0:
                    return (a + b) / 2
                return _meeting(past, below, above, friction * eta, lowest, highest)
            if k == 0:
                lowest = a
                highest = b
        lowest = max(lowest, low[1])
        highest = min(highest, high[1])
    return (lowest + highest) / 2


def _meeting(past, below, above, half, lowest, highest):
    """The value at which both bounds meet within a phase."""
    late = past.end
    early = past.begin
    for _ in range(100):
        middle = (late + early) / 2
        if max(lowest, below(middle)[0] + half) >= min(highest, above(middle)[0] - half):
            early = middle
        else:
            late = middle
    a = max(lowest, below(early)[0] + half)
    b = min(highest, above(early)[0] - half)
    return (a + b) / 2


# ------------------------------------------------------------------------------------ friction work


class Work:
    """W(x) at |x| and W of revolution number `cycle`, of a scene with E* = 1; every span of slip in
    `parts`.
    """

    def __init__(self, scene, cycle, step=0.3, parts=1):
        self.friction = LONG(scene.friction.coefficient)
        self.phases, self.first = phases_of(
            scene.load.path(), scene.friction.coefficient, cycle + 1
        )
        numbers = range(self.first, len(self.phases))
        self.slips = [slip for k in numbers for slip in slips_of(self.phases, k, self.friction)]
        self.law = law_of(scene.profile)
        self.parts = parts
        self.contact = contact_of(scene.profile, scene.material)
        self.lower, self.near, self.weight = _rule(step)
        self.corners = [b for b in self.law.breaks if b > 0]
        self.corner_loads = [LONG(self.law.load(b)) for b in self.corners]

    def nodes(self, begin, end):
        """Nodes and weights on [begin, end]."""
        length = np.asarray(end - begin)[..., None]
        begin = np.asarray(begin)[..., None]
        end = np.asarray(end)[..., None]
        return (
            np.where(self.lower, begin + length * self.near, end - length * self.near),
            length * self.weight,
        )

    def half(self, load):
        """a(P), (n,)."""
        load = np.atleast_1d(np.asarray(load, dtype=LONG))
        return half_width(self.law, load, self.contact.half_width(load.astype(float)))

    def _marks(self, slip, begin, end):
        """Times between `begin` and `end` at which an edge of contact or of stick passes a corner,
        and those of `parts`.
        """
        marks = [begin, end]
        for corner in self.corner_loads:
            marks += [
                t
                for t in (self._passes(slip.phase.of(LONG(1), 0), corner, begin, end),)
                if t is not None
            ]
            marks += [t for t in (self._meets(slip, corner, begin, end),) if t is not None]
        marks = sorted(marks)
        return [
            a + (b - a) * k / self.parts for a, b in pairwise(marks) for k in range(self.parts)
        ] + [end]

    @staticmethod
    def _passes(load, value, begin, end):
        ends = load(np.array([begin, end]))[0]
        return (
            root(load, value, begin, end)[()] if (ends[0] - value) * (ends[1] - value) < 0 else None
        )

    @staticmethod
    def _meets(slip, value, begin, end):
        """When the front, which runs down, is at `value`."""
        first, last = slip.front(np.array([begin, end]))
        if not first > value > last:
            return None
        for _ in range(100):
            middle = (begin + end) / 2
            if not begin < middle < end:
                break
            begin, end = (middle, end) if slip.front(middle) > value else (begin, middle)
        return (begin + end) / 2

    def times_at(self, slip, edge_load):
        """(begin, end) of the slip at points of that edge load, None if there is none."""
        begin = slip.begin
        end = slip.end
        loads = slip.phase.loads(np.array([begin, end]))[0]
        fronts = slip.front(np.array([begin, end]))
        if fronts[1] >= edge_load or max(loads) <= edge_load:
            return None
        meets = self._meets(slip, edge_load, begin, end)
        passes = self._passes(slip.phase.of(LONG(1), 0), edge_load, begin, end)
        begin = begin if meets is None else meets
        if passes is not None:
            begin, end = (
                (max(begin, passes), end) if loads[1] > loads[0] else (begin, min(end, passes))
            )
        return (begin, end) if end > begin else None

    def pressure(self, x, half):
        """p(x, P) at the half-widths (n,) >= x, all between the same two corners: alpha^2 = x^2 +
        w^2.
        """
        total = 0 * half
        edge = np.sqrt((half - x) * (half + x))
        marks = [
            0 * half,
            *(
                np.sqrt((b - x) * (b + x)) + 0 * half
                for b in self.law.breaks
                if x < b < half[len(half) // 2]
            ),
            edge,
        ]
        for low, high in pairwise(marks):
            w, weight = self.nodes(low, np.maximum(low, high))
            at = np.sqrt(x * x + w * w)
            total += np.sum(weight * self.law.rate(at) / at, axis=-1) / PI
        return total

    def density(self, x):
        """W(x) at |x| (m,), forward and in reverse: (2, m)."""
        places = [LONG(place) for place in np.abs(np.asarray(x, dtype=float))]
        forward = [self._at(place, 1) for place in places]
        reverse = [self._at(place, -1) for place in places]
        return np.array([forward, reverse])

    def _at(self, x, sign):
        edge_load = LONG(self.law.load(x)) if x > self.law.breaks[0] else LONG(0)
        total = LONG(0)
        for slip in self.slips:
            span = self.times_at(slip, edge_load) if slip.sign == sign else None
            for begin, end in pairwise(self._marks(slip, *span)) if span else ():
                times, weight = self.nodes(begin, end)
                p = slip.phase.loads(times)[0]
                front = slip.front(times)
                growth = slip.growth(times)[1]
                a = self.half(p)
                c = self.half(front)
                reach = np.arcsinh(np.sqrt(np.maximum((x - c) * (x + c), 0)) / c)
                total += np.sum(weight * self.pressure(x, np.maximum(a, x)) * growth * reach)
        return 2 / PI * self.friction * total

    def whole(self):
        """W, forward and in reverse."""
        total = {1: LONG(0), -1: LONG(0)}
        for slip in self.slips:
            for begin, end in pairwise(self._marks(slip, slip.begin, slip.end)):
                times, weight = self.nodes(begin, end)
                a = self.half(slip.phase.loads(times)[0])
                c = self.half(np.maximum(slip.front(times), 0))
                total[slip.sign] += np.sum(weight * slip.growth(times)[1] * self._area(a, c))
        return 2 / PI * self.friction * np.array([total[1], total[-1]])

    def _area(self, half, stick):
        """int_{P_c}^P ln(a/c) d eta at half-widths (n,), the same corners between them."""
        # Of a contact that is about to be unloaded P_c is 0 to the last digit, and ln(a/c) an end
        # of the rule.
        stick = np.maximum(stick, LONG(1e-300))
        inside = [b for b in self.law.breaks if stick[len(stick) // 2] < b < half[len(half) // 2]]
        marks = [stick, *(np.full(half.shape, b) for b in inside), half]
        area = 0 * half
        for low, high in pairwise(marks):
            at, weight = self.nodes(low, np.maximum(low, high))
            ratio = np.log1p(np.maximum(at - stick[:, None], 0) / stick[:, None])
            area += np.sum(weight * self.law.rate(at) * ratio, axis=-1)
        return area
