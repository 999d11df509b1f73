"""What each metric is: one row for each, the same words on the page, in the docs, in the terminal and in comparison.json."""

from __future__ import annotations

from reports import definitions_work, definitions_zones
from reports.definition import Definition
from reports.definitions_tractions import TRACTIONS

_ROWS = (*TRACTIONS, *definitions_zones.HEADLINES, *definitions_work.HEADLINES, *definitions_zones.ZONES, *definitions_work.WORK)
# In the order of the tables: the headlines first.
DEFINITIONS: dict[str, Definition] = {row.key: row for row in sorted(_ROWS, key=lambda row: not row.headline)}

_ENGINES = {"semi_analytic": "half-plane theory", "halfplane_fe": "finite elements"}


def name_of(engine: str) -> str:
    """What an engine is called on the page.

    >>> name_of("halfplane_fe"), name_of("somebody's code")
    ('finite elements', "somebody's code")
    """
    return _ENGINES.get(engine, engine)


def markdown() -> str:
    """The table of docs/metrics.md: one row for each metric, in the order of the tables."""
    rows = (
        f"| `{row.key}` | {row.label} | {_units(row)} | {row.norm} | {row.region} | {'yes' if row.signed else 'no'} | {row.text} |"
        for row in DEFINITIONS.values()
    )
    return "\n".join(("| Key | Label | Unit | Norm | Region | Signed | How |", "|---|---|---|---|---|---|---|", *rows))


def _units(row: Definition) -> str:
    return f"{row.unit}; {row.absolute_unit} where that is 0" if row.absolute_unit else row.unit
