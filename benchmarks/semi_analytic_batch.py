"""A million random Hertz ellipses in one call: rate against bare numpy, error against 30 digits, memory.

    python benchmarks/semi_analytic_batch.py        (a minute and a half, most of it the 30 digits)

Bare numpy is timed on what the batch really asks for: its calls are counted while it runs, tiers of nodes, members one by one and
all, and made again on arrays of the same sizes, nothing else. Two accounts of the same calls are given:

- by the formulas of theory section 4: at each node two angles' sines and cosines and three logarithms, and what each member needs;
- as the batch makes them: one tangent in place of a sine and a cosine (numpy 2.4 has vector code for tangent and logarithm, not for
  sine and cosine in double precision), so that bare numpy is faster too, and the ratio to it says how much arithmetic there is.

Times are least process times of several repetitions, taken in turn in one run.
"""

from __future__ import annotations

import math
import time
import tracemalloc
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import mpmath as mp
import numpy as np
from claim import Row, table
from semi_analytic_reference import Case
from semi_analytic_reference import dissipation as reference
from semi_analytic_speed import random_ellipses

from scenes import FlatRounded, Hertz
from semi_analytic import dissipation

MEMBERS = 1_000_000
SAMPLE = 200
REPEATED = 5
FUNCTIONS = ("sin", "cos", "tan", "arctan", "arctan2", "hypot", "arcsinh", "sqrt", "cbrt", "log", "log1p", "exp")
HERTZ, FLAT = Hertz(radius=1.0), FlatRounded(radius=1.0, flat_half_length=0.7)

Call = tuple[str, tuple[int, ...]]


def calls_of(work: Callable[[], Any]) -> list[Call]:
    """Transcendental calls and roots that `work` makes, each with the shape of its result."""
    found: list[Call] = []
    own = {name: getattr(np, name) for name in FUNCTIONS}

    def counting(name: str) -> Callable[..., Any]:
        def call(*arguments: Any, **keys: Any) -> Any:
            result = own[name](*arguments, **keys)
            found.append((name, np.shape(result)))
            return result

        return call

    try:
        for name in FUNCTIONS:
            setattr(np, name, counting(name))
        work()
    finally:
        for name in FUNCTIONS:
            setattr(np, name, own[name])
    return found


def by_formulas(calls: list[Call]) -> list[Call]:
    """Sine and cosine in place of each tangent at nodes (n, m)."""
    return [(name, shape) for call, shape in calls for name in (("sin", "cos") if call == "tan" and len(shape) == 2 else (call,))]


def bare(calls: list[Call]) -> Callable[[], None]:
    """The calls alone, on arrays of the same sizes that are there already."""
    sizes = [(getattr(np, name), name in ("arctan2", "hypot"), math.prod(shape)) for name, shape in calls]
    one, out = np.full(max(size for *_, size in sizes), 0.7), np.empty(max(size for *_, size in sizes))

    def run() -> None:
        for function, of_two, size in sizes:
            function(*((one[:size], one[:size]) if of_two else (one[:size],)), out=out[:size])

    return run


def least_times(*works: Callable[[], Any]) -> list[float]:
    """Least process time of each, in turn, after one round to warm up."""
    times = np.full((REPEATED, len(works)), np.inf)
    for work in works:
        work()
    for row in times:
        for k, work in enumerate(works):
            begun = time.process_time()
            work()
            row[k] = time.process_time() - begun
    return np.min(times, axis=0).tolist()


def part_of(members: dict[str, Any], count: int) -> dict[str, Any]:
    return {name: value[:count] if isinstance(value, np.ndarray) else value for name, value in members.items()}


def speed(members: dict[str, Any]) -> Iterator[Row]:
    """Rates and ratios of a tenth of the members, and of all."""
    few = part_of(members, MEMBERS // 10)
    count = MEMBERS // 10

    def hertz() -> Any:
        return dissipation(profile=HERTZ, **few)

    def flat() -> Any:
        return dissipation(profile=FLAT, **few)

    calls = calls_of(hertz)
    own, formulas, took, flat_took = least_times(bare(calls), bare(by_formulas(calls)), hertz, flat)
    counts = Counter({name: sum(math.prod(shape) for call, shape in calls if call == name) for name in FUNCTIONS})
    counted = ", ".join(f"{counts[name] / count:.1f} {name}" for name in FUNCTIONS if counts[name])
    begun = time.process_time()
    dissipation(profile=HERTZ, **members)
    whole = time.process_time() - begun
    yield Row("batch of 10^6 Hertz ellipses: time", whole, None, f"{MEMBERS / whole / 1e6:.2f} million a second, one core", "s")
    yield Row(
        "the same over bare numpy: sin, cos and log of the formulas", took / formulas, 2.0, "at the batch's own nodes, 10^5 members"
    )
    yield Row("the same over bare numpy: the calls as the batch makes them", took / own, None, f"a member: {counted}")
    yield Row(
        "batch of flat-and-rounded ellipses over Hertz", flat_took / took, 5.0, f"{count / flat_took / 1e6:.2f} million a second"
    )


def accuracy(members: dict[str, Any]) -> Iterator[Row]:
    """A random sample of the very members against 30 digits."""
    chosen = np.sort(np.random.default_rng(1).choice(MEMBERS, SAMPLE, replace=False))
    for name, profile, radius in (("Hertz", HERTZ, 0.0), ("flat-and-rounded", FLAT, 0.7)):
        some = {key: value[chosen] if isinstance(value, np.ndarray) else value for key, value in members.items()}
        found = dissipation(profile=profile, **some).value
        keys = ("normal_amplitude", "tangential_amplitude", "phase", "friction_coefficient")
        size = SAMPLE if radius == 0 else SAMPLE // 10
        worst, relative = 0.0, 0.0
        for value, *row in zip(found[:size], *(some[key][:size] for key in keys), strict=True):
            ratio, force, phase, friction = (float(part) for part in row)
            error = abs(float(mp.mpf(float(value)) - (truth := reference(Case(radius, 1.0, ratio, force, phase, friction, True)))))
            worst, relative = max(worst, error / (2 * friction**2)), max(relative, error / float(truth))
        yield Row(f"{name}: worst error of {size} random members, in A f^2 P0^2", worst, 1e-11, "against 30 digits")
        yield Row(f"{name}: the same, relative", relative, None, "against 30 digits")


def memory(members: dict[str, Any]) -> Iterator[Row]:
    """Peak beyond arguments and results, of a tenth of the members and of all."""
    peaks = []
    for count in (MEMBERS // 10, MEMBERS):
        some = part_of(members, count)
        tracemalloc.start()
        batch = dissipation(profile=HERTZ, **some)
        results = sum(part.nbytes for part in vars(batch).values())
        peaks.append((tracemalloc.get_traced_memory()[1] - results) / 1e6)
        tracemalloc.stop()
    yield Row("peak memory beyond arguments and results, 10^5 members", peaks[0], None, "tracemalloc", "MB")
    yield Row("growth of that from 10^5 to 10^6 members", peaks[1] - peaks[0], 0.5, f"{peaks[1]:.2f} MB", "MB")


def rows() -> Iterator[Row]:
    """All of them."""
    members = random_ellipses(MEMBERS)
    yield from speed(members)
    yield from memory(members)
    mp.mp.dps = 30
    yield from accuracy(members)


if __name__ == "__main__":
    print(table(list(rows())))
