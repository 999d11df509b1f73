"""Where an error stays below a level: read off the points of a line, with their uncertainty on the safe side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reports.maps.fitting import Line

_SURE = 0.5  # half the interval of an exponent up to which its law is gone on with


@dataclass(frozen=True)
class Bound:
    """The largest s up to which |error| + uncertainty stays below a level.

    Attributes
    ----------
    s : None where no point stays below it and there is no law to go on with
    how : "points" between two of them; "all" where every point stays below (s is the largest tried); "law" by extrapolation
    """

    s: float | None
    how: str


def bound(line: Line, level: float) -> Bound:
    """Read a line from small s upwards; straight in logarithms between the last point below the level and the first above.

    Points at which theory's error changes its sign may fall below a level in between: the first that exceeds it counts.
    """
    order = np.argsort(line.s)
    s, size = line.s[order], (np.abs(line.error) + np.nan_to_num(line.uncertainty))[order]
    known = np.isfinite(size)
    s, size = s[known], size[known]
    above = np.flatnonzero(size > level)
    if not len(above):
        return Bound(float(s[-1]), "all") if len(s) else Bound(None, "none")
    first = int(above[0])
    if first == 0:
        law = line.law
        if law is None or not law.agrees() or law.order_doubt > _SURE:
            return Bound(None, "none")
        return Bound((level / (law.fixed + law.fixed_doubt)) ** (1 / law.expected), "law")
    share = np.log(level / size[first - 1]) / np.log(size[first] / size[first - 1])
    return Bound(float(s[first - 1] * (s[first] / s[first - 1]) ** share), "points")


def words(found: Bound, inverse: bool) -> str:
    """For a table: in units of the map's axis, rounded to the safe side; * where extrapolated.

    >>> words(Bound(0.1234, "points"), True), words(Bound(0.1234, "points"), False), words(Bound(0.5, "all"), True)
    ('8.2', '0.123', '2 (all tried)')
    """
    if found.s is None:
        return "none tried"
    value = 1 / found.s if inverse else found.s
    scale = 10.0 ** (2 - int(np.floor(np.log10(value)))) if value < 1 else 10.0
    near = value * scale
    rounded = (np.ceil(near - 1e-9) if inverse else np.floor(near + 1e-9)) / scale
    return f"{rounded:g}" + {"points": "", "all": " (all tried)", "law": "*"}[found.how]
