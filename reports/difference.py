"""`halfplane diff`: the figures of two runs, or of a run and a baseline, side by side, with a tolerance for each.

Same machine, same answer: half-plane theory repeats itself to the last digit, finite elements too. The default tolerances
leave room for another order of sums (another processor, another BLAS), and for nothing else.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from reports.baseline import Findings, flat, physics
from reports.verdicts import Verdict, verdict_on
from scenes import InputError

# The first pattern that fits a key counts. What processors of other kinds give is told in docs/regression.md.
DEFAULTS: tuple[tuple[str, float], ...] = (
    ("*.counts.*", 0.05),  # rounding decides whether an increment is halved, and the next ones follow
    ("metric.*", 1e-6),
    ("semi_analytic.*", 1e-9),
    ("*", 1e-6),
)
# Of two mirrored peaks rounding says which is the larger: the place of a peak is compared without its sign.
MIRRORED = "metric.*_place"
# Below this share of A f^2 P^2 a dissipation is the rounding of a sum whose truth is 0.
NOTHING = 1e-6
SAME, DIFFERS, ONLY_A, ONLY_B = "same", "differs", "only in A", "only in B"


@dataclass(frozen=True)
class Row:
    """One figure of two findings.

    Attributes
    ----------
    key : of the figure
    a, b : its values; None for "no such thing"
    difference : B less A; None where there is nothing to subtract
    kind : "absolute", or "relative": over the larger of |A| and |B|
    tolerance : largest admitted |difference|
    verdict : same, differs, only in A, only in B
    """

    key: str
    a: float | None
    b: float | None
    difference: float | None
    kind: str
    tolerance: float
    verdict: str


@dataclass(frozen=True)
class Difference:
    """Two findings compared: the rows, and what else a reader must know."""

    a: str
    b: str
    scene: str
    rows: tuple[Row, ...]
    notes: tuple[str, ...]

    @property
    def same(self) -> bool:
        """Whether every figure of what both have is in both and within its tolerance."""
        return all(row.verdict == SAME for row in self.rows)

    def as_json(self) -> str:
        """The table as strict JSON."""
        content = {"format": "halfplane difference 1", "same": self.same, **asdict(self)}
        for row in content["rows"]:
            row["tolerance"] = row["tolerance"] if math.isfinite(row["tolerance"]) else None
        return json.dumps(content, allow_nan=False, indent=1, ensure_ascii=False)


def difference(a: Findings, b: Findings, tolerances: Mapping[str, float] | None = None) -> Difference:
    """How far the figures of `b` are from those of `a`.

    Parameters
    ----------
    a, b : of one scene
    tolerances : pattern of keys -> tolerance; before those kept with either, which come before the defaults

    Raises
    ------
    InputError
        For different scenes, no common engine, or a pattern that fits no key.
    """
    _refuse_other_scene(a, b)
    shared = _groups(a) & _groups(b)
    keys = [key for key in {**a.figures, **b.figures} if _group(key) in shared]
    if not keys:
        raise InputError(f"{a.source} and {b.source} have no figure in common: {_engines(a)} and {_engines(b)}")
    _refuse_unknown(tolerances or {}, keys)
    patterns = [*(tolerances or {}).items(), *b.tolerances.items(), *a.tolerances.items(), *DEFAULTS]
    rows = tuple(_row(key, a, b, next(value for pattern, value in patterns if fnmatchcase(key, pattern))) for key in keys)
    return Difference(a.source, b.source, a.scene.name or b.scene.name, rows, tuple(_notes(a, b)))


def tolerances_of(words: Sequence[str]) -> dict[str, float]:
    """What --tolerance KEY=VALUE says; InputError for anything else.

    >>> tolerances_of(["metric.*=1e-4"])
    {'metric.*': 0.0001}
    """
    found = {}
    for word in words:
        key, equals, text = word.rpartition("=")
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (equals and key and value >= 0):
            raise InputError(f"--tolerance {word}: write KEY=VALUE, VALUE a number not below 0 (inf: not judged)")
        found[key] = value
    return found


def _refuse_unknown(tolerances: Mapping[str, float], keys: Sequence[str]) -> None:
    for pattern in tolerances:
        if not any(fnmatchcase(key, pattern) for key in keys):
            raise InputError(f"--tolerance {pattern}: no figure is called so; there are {', '.join(keys)}")


def _refuse_other_scene(a: Findings, b: Findings) -> None:
    ours, theirs = physics(a.scene), physics(b.scene)
    apart = [key for key in {**ours, **theirs} if ours.get(key) != theirs.get(key)]
    if apart:
        named = "; ".join(f"{key} is {ours.get(key, 'absent')} and {theirs.get(key, 'absent')}" for key in apart[:6])
        more = f"; and {len(apart) - 6} more" if len(apart) > 6 else ""
        raise InputError(f"{a.source} and {b.source} answer different scenes: {named}{more}")


def _group(key: str) -> str:
    """What a figure belongs to: the comparison, or an engine."""
    return key.partition(".")[0]


def _groups(findings: Findings) -> set[str]:
    return {_group(key) for key in findings.figures}


def _engines(findings: Findings) -> str:
    return " and ".join(findings.engines) or "no engine"


def _row(key: str, a: Findings, b: Findings, tolerance: float) -> Row:
    first, second = a.figures.get(key), b.figures.get(key)
    kind = "absolute" if key.startswith("metric.") else "relative"
    if key not in a.figures or key not in b.figures:
        return Row(key, first, second, None, kind, tolerance, ONLY_A if key in a.figures else ONLY_B)
    if first is None or second is None:
        return Row(key, first, second, None, kind, tolerance, SAME if first is second else DIFFERS)
    size = 1.0 if kind == "absolute" else max(abs(first), abs(second), _floor(key, a))
    change = abs(second) - abs(first) if fnmatchcase(key, MIRRORED) else second - first
    apart = change / size if change else 0.0
    return Row(key, first, second, apart, kind, tolerance, SAME if verdict_on(apart, tolerance) is Verdict.WITHIN else DIFFERS)


def _floor(key: str, findings: Findings) -> float:
    """What a dissipation is at least taken relative to [energy / thickness]; 0 for all else."""
    from reports.metrics import compliance

    engine, _, quantity = key.partition(".")
    if quantity not in ("dissipation", "loop_work"):
        return 0.0
    load = (findings.figures[f"{engine}.largest_pressure"] or 0.0) * (findings.figures[f"{engine}.largest_half_width"] or 0.0)
    friction = findings.scene.friction.coefficient or 1.0
    return NOTHING * compliance(findings.scene.material) * (friction * load) ** 2


def _notes(a: Findings, b: Findings) -> Iterator[str]:
    """What is not compared, what moves figures without being one (settings, versions), engines that did not converge."""
    for letter, more, less in (("A", a, b), ("B", b, a)):
        for group in sorted(_groups(more) - _groups(less)):
            yield f"not compared, for it is only in {letter}: {group}.*"
    for engine in sorted(a.engines.keys() & b.engines.keys()):
        ours, theirs = flat(a.engines[engine]), flat(b.engines[engine])
        for key in {**ours, **theirs}:
            if ours.get(key) != theirs.get(key):
                yield f"{engine}: {key} is {ours.get(key, 'absent')} in A and {theirs.get(key, 'absent')} in B"
    for letter, findings in (("A", a), ("B", b)):
        yield from (f"{letter} did not converge: {sentence}" for sentence in findings.unfinished)


def is_baseline(path: Path) -> bool:
    """Whether a file says that it is a baseline, whole or spoilt."""
    from reports.baseline import BASELINE

    if not path.is_file():
        return False
    with path.open(encoding="utf-8", errors="replace") as file:
        return BASELINE in file.read(200)
