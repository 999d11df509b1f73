"""Friction work of any history of straight and harmonic legs in 30 digits: the memory curve of the theory, followed in mpmath.

Shares no code with the engine: turning points are roots of polynomials, the front of slip is a root of the memory curve's level,
the work an integral over time between the instants at which something changes. Slow, plain, and the truth for `regress.py`. Run it
to make `exact_history.json` anew, harmonics that are hard on a quadrature (some minutes):

    python benchmarks/exact_history.py [NAME ...]

# notation: A = 2/E*; P_c load at the front of slip, c = a(P_c); w = d Q - f P, d direction of slip
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import mpmath as mp
from exact_legs import legs_of, root
from exact_memory import Run, steady_runs

FILE = Path(__file__).with_suffix(".json")
DIGITS = 30
_PARTS = 4


class Contact(NamedTuple):
    """a(P), P(a), p(x, a) and int_{P_c}^P ln(a(eta)/c) d eta of (P, a, P_c, c), all in mpmath."""

    half_width: Callable[[mp.mpf], mp.mpf]
    load: Callable[[mp.mpf], mp.mpf]
    pressure: Callable[[mp.mpf, mp.mpf], mp.mpf]
    area: Callable[[mp.mpf, mp.mpf, mp.mpf, mp.mpf], mp.mpf]


def hertz(modulus: mp.mpf, radius: mp.mpf) -> Contact:
    """A parabola of that relative radius."""
    factor = mp.pi * modulus / (4 * radius)
    return Contact(
        lambda p: mp.sqrt(p / factor),
        lambda a: factor * a * a,
        lambda x, a: modulus / (2 * radius) * mp.sqrt(max((a - x) * (a + x), 0)),
        lambda p, a, front, c: (p * mp.log(p / front) - p + front) / 2,
    )


def dissipation(runs: Sequence[Run], contact: Contact, f: mp.mpf, modulus: mp.mpf) -> mp.mpf:
    """Friction work of the runs: (f A/pi) int w' Lam dt, A = 2/E*."""

    def power(run: Run, t: mp.mpf) -> mp.mpf:
        p, front = run.leg.loads(t)[0], run.front(f, t)
        if not 0 < front < p:
            return mp.mpf(0)
        return run.growth(f, t) * contact.area(p, contact.half_width(p), front, contact.half_width(front))

    total = sum(_integral(lambda t, run=run: power(run, t), [run.begin, run.end]) for run in runs)
    return 2 * f / (mp.pi * modulus) * total


def density(runs: Sequence[Run], contact: Contact, f: mp.mpf, modulus: mp.mpf, x: mp.mpf) -> mp.mpf:
    """Friction work of the runs per unit area at x: (f A/pi) int p(x, P) w' arccosh(x/c) dt while c < x < a."""
    edge, total = contact.load(x), mp.mpf(0)

    def power(run: Run, t: mp.mpf) -> mp.mpf:
        p, front = run.leg.loads(t)[0], run.front(f, t)
        if not 0 < front < edge < p:
            return mp.mpf(0)
        return contact.pressure(x, contact.half_width(p)) * run.growth(f, t) * mp.acosh(max(x / contact.half_width(front), 1))

    for run in runs:
        marks = [run.begin, run.end, root(run.leg, (1, 0), edge, run.begin, run.end)]
        if run.piece and run.front(f, run.begin) > edge > run.front(f, run.end):
            level = run.direction * run.piece.value(edge) - f * edge
            marks.append(root(run.leg, (-f, run.direction), level, run.begin, run.end))
        for begin, end in pairwise(sorted(marks)):
            middle = (begin + end) / 2
            if end > begin and run.front(f, middle) < edge < run.leg.loads(middle)[0]:
                total += _integral(lambda t, run=run: power(run, t), [begin, end])
    return 2 * f / (mp.pi * modulus) * total


def _integral(power: Callable[[mp.mpf], mp.mpf], ends: Sequence[mp.mpf]) -> mp.mpf:
    """Tanh-sinh on parts, and on halves of a part until its own estimate is small enough."""
    todo = list(pairwise(mp.linspace(*ends, _PARTS + 1)))
    total, size = mp.mpf(0), mp.mpf(0)
    while todo:
        begin, end = todo.pop()
        part, error = mp.quad(power, [begin, end], error=True)
        size = max(size, abs(part))
        if error > size * mp.mpf(10) ** (3 - mp.mp.dps) and end - begin > (ends[1] - ends[0]) / 4096:
            middle = (begin + end) / 2
            todo += [(begin, middle), (middle, end)]
        else:
            total += part
    return total


_SLIDING = 2.2656448181047733  # times this, |Q|/(f P) reaches 1 - 1e-6

NASTY: dict[str, dict[str, Any]] = {
    "square wave": {  # eleven odd harmonics of Q under a slow P: ripples of the front
        "friction": 0.5,
        "mean": (1.0, 0.0),
        "normal": [(0.3, 0.0)],
        "tangential": [(0.25 / k if k % 2 else 0.0, 90.0) for k in range(1, 12)],
        "x": [0.75, 0.85, 0.98, 1.1],
    },
    "near sliding": {  # once a revolution
        "friction": 0.5,
        "mean": (1.0, 0.0),
        "normal": [(0.3, 0.0), (0.1, 50.0), (0.1, -30.0)],
        "tangential": [(size * _SLIDING, phase) for size, phase in ((0.1, 90.0), (0.05, 20.0), (0.06, 10.0), (0.02, 200.0))],
        "x": [0.2, 0.7, 0.95, 1.1],
    },
}
"""E* = 1, R = 1; [amplitude, phase in degrees] of k = 1, 2, ..."""


def main() -> None:
    """All of them, or those that are named."""
    mp.mp.dps = DIGITS + 10
    found = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    contact = hertz(mp.mpf(1), mp.mpf(1))
    for name in sys.argv[1:] or NASTY:
        case = NASTY[name]
        f = mp.mpf(case["friction"])
        runs = steady_runs(*legs_of(case["mean"], case["normal"], case["tangential"]), f)
        work = mp.nstr(dissipation(runs, contact, f, mp.mpf(1)), DIGITS)
        each = [mp.nstr(density(runs, contact, f, mp.mpf(1), mp.mpf(x)), DIGITS) for x in case["x"]]
        print(name, work, *each, flush=True)
        found[name] = {**case, "dissipation": work, "density": each}
        FILE.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
