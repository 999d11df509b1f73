"""The commands that judge results."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from reports.application import app


@app.command(sort_key=3, help_epilogue="")
def diff(
    a: Annotated[str, Parameter(help="Folder of a run, its comparison.json, a solution (.nc), or a baseline.")],
    b: Annotated[str, Parameter(help="The same; with --accept the baseline to write.")],
    *,
    tolerance: Annotated[
        tuple[str, ...],
        Parameter(consume_multiple=True, negative="", help='KEY=VALUE of one figure, or of many: "metric.*=1e-4".'),
    ] = (),
    accept: Annotated[bool, Parameter(negative="", help="Make B a baseline of A; the tolerances given are kept in it.")] = False,
    json: Annotated[bool, Parameter(negative="", help="The table as JSON.")] = False,
) -> int:
    """Two runs, or a run and a baseline, figure by figure: 0 the same within tolerance, 1 not."""
    from reports import regression

    return regression.diff(a, b, tolerance, accept, json)
