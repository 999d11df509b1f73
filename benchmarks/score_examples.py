"""The scored examples of docs/examples/score: how far each foreign result is from half-plane theory, from its shipped files.

python benchmarks/score_examples.py
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from claim import Row, table

sys.path.insert(0, str(Path(__file__).parents[1] / "docs" / "examples" / "score"))
import measure

QUANTITIES = {"calculix": "dissipation", "kratos": "dissipation", "abaqus": "shear"}


def rows() -> Iterator[Row]:
    """One headline figure of each example; the table of Abaqus' form has no dissipation. Shown: they are other codes' figures."""
    for example in measure.EXAMPLES:
        comparison = measure.scored(example)
        metric = comparison.metric(QUANTITIES[example.name])
        faults = ", ".join(one.fault for one in comparison.diagnoses)
        pressure = comparison.metric("pressure").value
        how = f"{measure.SCENE}, {example.result}; p, relative L2: {pressure:.2g}; diagnosis: {faults}"
        yield Row(f"score of the example {example.name}: {metric.label}", float(metric.value), None, how)


def main() -> None:
    print(table(list(rows())))


if __name__ == "__main__":
    main()
