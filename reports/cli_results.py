"""The commands that judge results."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from reports.application import JUDGE, Json, Quiet, Silent, app


@app.command(group=JUDGE, sort_key=2, help_epilogue="")
def diff(
    a: Annotated[str, Parameter(help="Folder of a run, its comparison.json, a solution (.nc), or a baseline.")],
    b: Annotated[str, Parameter(help="The same; with --accept the baseline to write.")],
    *,
    tolerance: Annotated[
        tuple[str, ...],
        Parameter(consume_multiple=True, negative="", help='KEY=VALUE of one figure, or of many: "metric.*=1e-4".'),
    ] = (),
    accept: Annotated[bool, Parameter(negative="", help="Make B a baseline of A; the tolerances given are kept in it.")] = False,
    json: Json = False,
    quiet: Silent = False,
) -> int:
    """Two runs, or a run and a baseline, figure by figure: 0 the same within tolerance, 1 not."""
    from reports import regression

    return regression.diff(a, b, tolerance, accept, json, quiet)


@app.command(group=JUDGE, sort_key=1, help_epilogue="")
def score(
    result: Annotated[
        str | None,
        Parameter(help="Somebody else's result: a table (.csv, .txt, .rpt), fields, a solution (.nc); or a folder."),
    ] = None,
    *,
    scene: Annotated[str | None, Parameter(help="The scene that it answers: a library name, or a .toml or .json file.")] = None,
    mapping: Annotated[Path | None, Parameter(help="TOML file: names of columns, units, signs. Usual ones need none.")] = None,
    against: Annotated[
        Literal["exact", "fe"], Parameter(help="Half-plane theory, or the project's own finite elements.")
    ] = "exact",
    out: Annotated[Path | None, Parameter(help="Folder for the results; out/score-<result> if left out.")] = None,
    quiet: Quiet = False,
    json: Annotated[bool, Parameter(negative="", help="The verdict as JSON.")] = False,
    mapping_example: Annotated[bool, Parameter(negative="", help="Print a commented mapping file and stop.")] = False,
) -> int:
    """Somebody else's result against the reference: verdict, what it suffers from, page."""
    from reports.scoring import command

    return command.score(result, scene, mapping, against, out, quiet=quiet, as_json=json, example=mapping_example)
