"""What the page on maps says of their tables beyond what stands on the published pages: read off the tables, no finite elements.

python benchmarks/map_laws.py
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from claim import Row, table

from reports.maps.atlas import PUBLISHED, map_named
from reports.maps.laws import lines, read
from reports.maps.pages import straight_exponent

FIGURE = "error.dissipation"
HEIGHT = 6.0


def rows() -> Iterator[Row]:
    """All rows of this page."""
    (chart,) = map_named("block").charts
    readings = read(PUBLISHED, chart.study)
    found = {", ".join(line.at.values()): line for line in lines(chart, readings) if line.figure == FIGURE}
    orders = {name: straight_exponent(line) for name, line in found.items()}
    for words, of in (("lowest", min), ("highest", max)):
        name = of(orders, key=lambda one: orders[one])
        what = f"exponent of dissipation between two blocks without the next term, {words}"
        yield Row(what, orders[name], None, f"base and width / height: {name}; of {len(orders)} lines")
    off = found["fixed, 1"]
    at = int(np.argmin(np.abs(off.s - 1 / HEIGHT)))
    how = f"block.csv, base fixed, height {1 / off.s[at]:.3g} half-widths"
    yield Row("dissipation between square blocks six half-widths high", 100 * float(off.error[at]), None, how, "%")


if __name__ == "__main__":
    print(table(list(rows())))
