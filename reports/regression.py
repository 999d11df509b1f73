"""What `halfplane diff` does once its options are read: read, compare, show, accept, and choose the exit code."""

from __future__ import annotations

from pathlib import Path

from reports import baseline
from reports.application import OUTSIDE, WITHIN
from reports.console import say, show_table
from reports.difference import SAME, Difference, Row, difference, is_baseline, tolerances_of
from scenes import InputError


def diff(a: str, b: str, tolerance: tuple[str, ...], accept: bool, as_json: bool, quiet: bool) -> int:
    """The table of A and B, unless `quiet`; with `accept` B becomes a baseline of A."""
    asked = tolerances_of(tolerance)
    first = baseline.read(a)
    if accept:
        return _accept(first, b, asked, as_json, quiet)
    if not Path(b).exists():
        raise InputError(f"{b}: there is no such file or folder; `halfplane diff {a} {b} --accept` writes it as a baseline")
    found = difference(first, baseline.read(b), asked)
    _show(found, as_json, quiet)
    return WITHIN if found.same else OUTSIDE


def _accept(findings: baseline.Findings, b: str, asked: dict[str, float], as_json: bool, quiet: bool) -> int:
    """Show what changes, then write."""
    path = Path(b)
    before = None
    if path.exists():
        if not is_baseline(path):
            raise InputError(f"{b}: this is not a baseline, and --accept writes over nothing else; name another file")
        before = baseline.read(b)
    # Compared with itself where there is nothing yet: that is how an unknown key of --tolerance is found.
    found = difference(findings, before or findings, asked)
    baseline.write(findings, path, {**(before.tolerances if before else {}), **asked})
    if before or as_json:
        _show(found, as_json, quiet)
    if not as_json and not quiet:
        say(f"{b}: {len(findings.figures)} figures of {a_name(findings)} accepted")
    return WITHIN


def a_name(findings: baseline.Findings) -> str:
    """What the scene is called, or where it was read."""
    return findings.scene.name or findings.source


def _show(found: Difference, as_json: bool, quiet: bool) -> None:
    if as_json:
        say(found.as_json())
    elif not quiet:
        _tell(found)


def _tell(found: Difference) -> None:
    shown = [_cells(row) for row in found.rows if not _identical(row)]
    title = f"{found.scene}: A = {found.a}, B = {found.b}"
    if shown:
        show_table(title, ("figure", "A", "B", "B less A", "tolerance", "verdict"), shown, right=(1, 2, 3, 4))
    else:
        say(title)
    if identical := len(found.rows) - len(shown):
        say(f"{identical} figures are the same to the last digit and not listed (--json has them)")
    for note in found.notes:
        say(note)
    apart = [row.key for row in found.rows if row.verdict != SAME]
    say(
        f"{len(found.rows)} figures, {len(apart)} differ: {', '.join(apart)}"
        if apart
        else f"all {len(found.rows)} figures are the same within tolerance"
    )


def _identical(row: Row) -> bool:
    return row.verdict == SAME and (row.difference == 0 or row.a == row.b)


def _cells(row: Row) -> tuple[str, ...]:
    value_a, value_b = ("none" if value is None else f"{value:.10g}" for value in (row.a, row.b))
    apart = "–" if row.difference is None else f"{row.difference:+.1e} {'' if row.kind == 'absolute' else 'rel.'}".rstrip()
    return row.key, value_a, value_b, "0" if row.difference == 0 else apart, f"{row.tolerance:g}", row.verdict
