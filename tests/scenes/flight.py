"""Makes flight.csv, a made-up record of one flight, not a measured one:

    python flight.py > flight.csv

A blade root in the small. The centrifugal load goes with the square of the speed and presses the
flank, P = PULL n^2; a constant share of it pulls along the flank, Q = SHARE P; the blade's bending
vibration adds a wave to Q and, through the slope of the flank, a smaller one to P. Start-up,
take-off at full speed, cruise at nine tenths of it, descent at idle, landing with reverse thrust,
shut-down. Time in minutes, loads in N/mm rounded to 0.01; rows joined by straight lines.
"""

import math
import sys
from collections.abc import Iterator

PULL, SHARE = 110.0, 0.12
# Name of the phase; minutes, rows and waves in it; speed at its end over the full one; amplitude of
# the wave in Q [N/mm].
PHASES = (
    ("start-up", 2.0, 8, 0, 0.60, 0.0),
    ("take-off", 3.0, 12, 2, 1.00, 12.0),
    ("cruise, vibration", 40.0, 32, 4, 0.90, 26.0),
    ("descent", 15.0, 10, 1, 0.60, 8.0),
    ("reverse thrust", 1.0, 8, 1, 0.85, 14.0),
    ("shut-down", 2.0, 10, 0, 0.20, 0.0),
)


def rows() -> Iterator[tuple[float, float, float]]:
    """Time, P, Q; the speed changes over the first fifth of a phase and then stays, without
    vibration over the whole of it.
    """
    begin, before = 0.0, 0.15
    yield 0.0, round(PULL * before**2, 2), round(SHARE * PULL * before**2, 2)
    for _, minutes, count, waves, after, amplitude in PHASES:
        for k in range(1, count + 1):
            part = k / count
            speed = before + (after - before) * min(1.0, part * (5 if waves else 1))
            wave = amplitude * math.sin(2 * math.pi * waves * part)
            pull = PULL * speed**2
            yield (
                round(begin + minutes * part, 4),
                round(pull + 0.25 * wave, 2),
                round(SHARE * pull + wave, 2),
            )
        begin, before = begin + minutes, after


def text() -> str:
    """The file, its head included."""
    head = (
        "# made by flight.py, not measured: "
        + ", ".join(phase[0] for phase in PHASES)
        + "\n# minutes, N/mm, N/mm\n"
    )
    return (
        head
        + "time,P,Q\n"
        + "".join(f"{time:g},{normal:g},{tangential:g}\n" for time, normal, tangential in rows())
    )


if __name__ == "__main__":
    sys.stdout.write(text())
