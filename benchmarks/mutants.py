"""Random mutants of both engines: which share of small wrong changes do the tests see?

    python benchmarks/mutants.py --drawn 60 --seed 19                         # all tests; the same call again resumes
    python benchmarks/mutants.py --drawn 60 --stages likely contract engine   # a quick figure: what these alone see

A place is drawn uniformly over the executable lines of both engines that an operator fits, then one of the operators that fit
there: constant x 1.01, sign, comparison, dropped term, neighbouring index. Each mutant is put into a scratch copy of the tree and
the stages of tests run in turn until one fails: tests that killed this mutant, or another of its file, in any run before; the
frozen values of the engine changed; its tests and doctests (those first that speak of the module most); the rest. What failed must
pass on the unchanged tree. A stage that takes an hour is stopped and counts as killed; the table states how many. A survivor that
is no wrong program leaves the count only by a written reason in mutants_equivalent.toml, and is not run. Results: one line of JSON
a mutant, in a file named by the seed and the engines' sources; of files of other sources only the names of tests count.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
ENGINES, STAGES = ("semi_analytic", "halfplane_fe"), ("likely", "contract", "engine", "rest")
MOST_LIKELY = 12  # tests, so that a stage of a few seconds comes first
LEFT = shutil.ignore_patterns(".git", ".venv", ".cache", ".peers", "out", "_build", "__pycache__")
OPPOSITES = ((ast.Lt, ast.GtE), (ast.Gt, ast.LtE), (ast.Eq, ast.NotEq), (ast.Is, ast.IsNot), (ast.In, ast.NotIn))
NEGATED = {one: other for pair in OPPOSITES for one, other in (pair, pair[::-1])}
# Annotations and the like change no result; texts, patterns and messages are not arithmetic.
NOT_ARITHMETIC = {"annotation", "returns", "decorator_list", "type_params", "ops", "op", "ctx"}
USAGE = 4  # exit code of pytest where a name is not found
LIMIT = 3600.0  # seconds of a stage: a slow machine is no killer
Mutant = dict[str, Any]


# ---------------------------------------------------------------------------------------------------------------- the draw
def executable_lines(source: str) -> set[int]:
    """Lines that carry bytecode, in any function of the module."""
    lines, codes = set(), [compile(source, "module", "exec")]
    for code in codes:  # grows
        lines |= {line for _, _, line in code.co_lines() if line}
        codes += [constant for constant in code.co_consts if hasattr(constant, "co_lines")]
    return lines


def number(node: ast.AST | None) -> float | None:
    """The value of a written number, with its sign."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and (value := number(node.operand)) is not None:
        return -value
    return node.value if isinstance(node, ast.Constant) and type(node.value) in {int, float} else None


def changes(node: ast.AST) -> Iterator[tuple[str, ast.expr, ast.expr | str]]:
    """Each (operator, expression, its replacement) in a tree, every place that an operator fits."""
    skipped: set[ast.AST] = set()
    match node:
        case ast.JoinedStr() | ast.Raise():
            return
        case ast.match_case():
            skipped = {node.pattern}
        case ast.Subscript():
            parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
            ends = [end for part in parts for end in ((part.lower, part.upper) if isinstance(part, ast.Slice) else (part,))]
            for end in ends:
                if (value := number(end)) is not None:
                    yield "neighbouring index", end, str(value + 1 if value >= 0 else value - 1)
            skipped = {part for end in ends if number(end) is not None for part in (end, getattr(end, "operand", end))}
        case ast.Constant() if number(node):
            yield "constant x 1.01", node, f"({node.value!r} * 1.01)"
        case ast.UnaryOp(op=ast.USub()):
            yield "sign", node, node.operand
        case ast.BinOp(op=ast.Add() | ast.Sub(), left=left) if number(left) is not None or not isinstance(
            left, ast.Constant | ast.JoinedStr
        ):
            other = ast.Sub() if isinstance(node.op, ast.Add) else ast.Add()
            yield "sign", node, ast.BinOp(left, other, node.right)
            yield "dropped term", node, left
        case ast.BinOp(op=ast.Mult()):
            yield "dropped term", node, node.left
        case ast.BoolOp():
            yield "dropped term", node, ast.BoolOp(node.op, node.values[:-1]) if len(node.values) > 2 else node.values[0]
        case ast.Compare(ops=[sign]):
            yield "comparison", node, ast.Compare(node.left, [NEGATED[type(sign)]()], node.comparators)
    for name, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and name not in NOT_ARITHMETIC:
                yield from (found for found in changes(child) if found[1] not in skipped) if child not in skipped else ()


def cut(source: str, span: list[int]) -> tuple[str, str, str]:
    """What stands before an expression, itself, and after; ast counts columns in bytes."""
    lines = [line.encode() for line in source.splitlines(keepends=True)]
    begin, end = (sum(map(len, lines[: line - 1])) + column for line, column in (span[:2], span[2:]))
    text = b"".join(lines)
    return text[:begin].decode(), text[begin:end].decode(), text[end:].decode()


def mutated(source: str, row: Mutant) -> str:
    """The source with the change made."""
    before, _, after = cut(source, row["span"])
    return f"{before}{row['after']}{after}"


def sources(tree: Path) -> dict[str, str]:
    """File -> text, of both engines."""
    paths = sorted(path for engine in ENGINES for path in (tree / engine).glob("**/*.py"))
    return {path.relative_to(tree).as_posix(): path.read_text(encoding="utf-8") for path in paths}


def places(tree: Path) -> tuple[dict[tuple[str, int], list[Mutant]], int]:
    """Mutants by (file, executable line), and the number of executable lines, fitting or not."""
    found: dict[tuple[str, int], list[Mutant]] = {}
    executable = 0
    for file, source in sources(tree).items():
        lines = executable_lines(source)
        executable += len(lines)
        for operator, node, new in changes(ast.parse(source)):
            if node.lineno in lines:
                text = new if isinstance(new, str) else f"({ast.unparse(new)})"
                span = [node.lineno, node.col_offset, node.end_lineno, node.end_col_offset]
                found.setdefault((file, node.lineno), []).append({"file": file, "operator": operator, "after": text, "span": span})
    return found, executable


def draw(found: dict[tuple[str, int], list[Mutant]], count: int, seed: int, tree: Path) -> list[Mutant]:
    """Mutants on different lines: the line uniformly, then the operator, then the place on the line."""
    generator, texts = random.Random(seed), sources(tree)
    drawn, order = [], sorted(found)
    generator.shuffle(order)  # the first 20 of 60 are the 20 of a draw of 20
    for file, line in order[:count]:
        rows = found[file, line]
        operator = generator.choice(sorted({row["operator"] for row in rows}))
        row = generator.choice([row for row in rows if row["operator"] == operator])
        source = texts[file].splitlines()[line - 1].strip()
        drawn.append(row | {"line": line, "source": source, "before": cut(texts[file], row["span"])[1]})
    return drawn


# ------------------------------------------------------------------------------------------------------------ the verdict
def paths_of(stage: str, file: str, tree: Path) -> list[str]:
    """The tests of a stage for a change in a file."""
    engine, module = file.partition("/")[0], Path(file).stem
    texts = {path: path.read_text(encoding="utf-8") for path in (tree / "tests").glob(f"test_{engine}_*.py")}
    first = sorted(texts, key=lambda path: (-texts[path].count(module), path))
    own = [*(path.relative_to(tree).as_posix() for path in first), engine]
    contract = ["tests/contract", "-k", {"semi_analytic": "half_plane", "halfplane_fe": "finite_elements"}[engine]]
    return {"contract": contract, "engine": own, "rest": [f"--ignore={path}" for path in ("tests/contract", *own)]}[stage]


def run_tests(paths: list[str], tree: Path, processes: int) -> tuple[int | None, str]:
    """Exit code of pytest, None where it was stopped; and the first test that failed, or the last line."""
    parallel = ["-n", str(processes)] if processes > 1 else ["-p", "no:xdist"]
    command = [sys.executable, "-m", "pytest", "-x", "-q", "--benchmark-disable", "--hypothesis-profile=ci", *parallel, *paths]
    cache = tree / ".cache"
    cache.mkdir(exist_ok=True)
    environment = os.environ | {"PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"}
    environment |= {"HALFPLANE_CACHE": "off", "MPLBACKEND": "Agg", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    environment |= dict.fromkeys(("HOME", "XDG_CACHE_HOME", "TMPDIR"), str(cache))
    process = subprocess.Popen(
        command, cwd=tree, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True
    )
    try:
        output, _ = process.communicate(timeout=LIMIT)
    except BaseException as stopped:  # an interrupt ends the tests as well
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        if not isinstance(stopped, subprocess.TimeoutExpired):
            raise
        return None, f"stopped after {LIMIT:.0f} s"
    failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", output, re.MULTILINE)
    return process.returncode, failed[1] if failed else output.strip().splitlines()[-1]


def likely(row: Mutant, before: list[Mutant], tree: Path) -> list[str]:
    """Tests that killed this mutant in another run, then those of other mutants of its file, the most frequent first."""

    def own(other: Mutant) -> bool:
        return all(other[key] == row[key] for key in ("operator", "before", "after"))

    killers = [(other["by"], own(other)) for other in before if other["file"] == row["file"] and "::" in other.get("by", "")]
    counts = Counter(by for by, _ in killers)
    ranked = sorted(counts, key=lambda by: ((by, True) not in killers, -counts[by], by))
    return [by for by in ranked if stands(by, tree)][:MOST_LIKELY]


def stands(test: str, tree: Path) -> bool:
    """Whether the tree has a test function of that name."""
    path, _, rest = test.partition("::")
    file = tree / path
    return file.exists() and f"def {rest.split('::')[-1].split('[')[0]}(" in file.read_text(encoding="utf-8")


def judge(row: Mutant, stages: list[str], before: list[Mutant], tree: Path, processes: int) -> Mutant:
    """Run the stages with the mutant until one fails; the test that failed must pass on the unchanged tree."""
    path, started = tree / row["file"], time.monotonic()
    original, verdict = path.read_text(encoding="utf-8"), {"verdict": "survived", "stages": stages}
    for stage in stages:
        paths = likely(row, before, tree) if stage == "likely" else paths_of(stage, row["file"], tree)
        if not paths:
            continue
        path.write_text(mutated(original, row), encoding="utf-8")
        try:
            code, test = run_tests(paths, tree, 1 if stage == "likely" else processes)
        finally:
            path.write_text(original, encoding="utf-8")
        if code == USAGE and stage == "likely":  # a case of that name is gone
            continue
        if code != 0:
            if code is not None and "::" in test and not passes_unchanged(test, tree):
                raise SystemExit(f"the unchanged tree fails {test}")
            verdict |= {"verdict": "timeout" if code is None else "killed", "stage": stage, "by": test}
            break
    return row | verdict | {"seconds": round(time.monotonic() - started, 1)}


@cache
def passes_unchanged(test: str, tree: Path) -> bool:
    """Asked once of each test: the tree has no mutant in it now."""
    return run_tests([test], tree, 1)[0] == 0


PLACE = ("file", "source", "before", "after")


def equivalents() -> dict[tuple[str, ...], str]:
    """Written reasons by (file, source of the line, before, after)."""
    entries = tomllib.loads(Path(__file__).with_name("mutants_equivalent.toml").read_text(encoding="utf-8")).get("mutant", [])
    return {tuple(entry[key] for key in PLACE): entry["reason"] for entry in entries if entry["reason"].strip()}


def report(rows: list[Mutant]) -> str:
    """Counts, equivalent mutants with their reasons, and a table of survivors."""
    reasons = equivalents()
    survivors = [row for row in rows if row["verdict"] == "survived"]
    excused = [row for row in survivors if tuple(row[key] for key in PLACE) in reasons]
    stopped, counted, killed = sum(r["verdict"] == "timeout" for r in rows), len(rows) - len(excused), len(rows) - len(survivors)
    share = f"{killed} of {counted} killed ({100 * killed / max(1, counted):.0f} %), {stopped} of them stopped at the limit of time"
    lines = [f"{len(rows)} drawn, {len(excused)} equivalent, {share}"]
    lines += [f"equivalent: {row['file']}:{row['line']}: {reasons[tuple(row[key] for key in PLACE)]}" for row in excused]
    lines += ["", "| survivor | operator | before | after | survived |", "|---|---|---|---|---|"]
    for row in (row for row in survivors if row not in excused):
        before, after = (" ".join(row[key].split()).replace("|", "\\|") for key in ("before", "after"))
        lines += [f"| {row['file']}:{row['line']} | {row['operator']} | `{before}` | `{after}` | {', '.join(row['stages'])} |"]
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drawn", type=int, default=60, help="mutants (default: 60)")
    parser.add_argument("--seed", type=int, default=19, help="of the draw (default: 19)")
    parser.add_argument("--stages", nargs="+", choices=STAGES, default=list(STAGES), help="tests to run, in turn (default: all)")
    parser.add_argument("--processes", type=int, default=1, help="of pytest (default: 1)")
    parser.add_argument("--list", action="store_true", help="print the draw and run nothing")
    parser.add_argument("--out", type=Path, default=ROOT / ".cache" / "mutants", help="folder of results and of the scratch copy")
    options = parser.parse_args()
    found, executable = places(ROOT)
    mutants = draw(found, options.drawn, options.seed, ROOT)
    digest = hashlib.sha256("".join(sources(ROOT).values()).encode()).hexdigest()[:12]
    print(f"seed {options.seed}, sources {digest}: {len(mutants)} drawn of {len(found)} lines that an operator fits")
    print(f"(of {executable} executable lines)", flush=True)
    if options.list:
        for row in mutants:
            print(f"{row['file']}:{row['line']}: {row['operator']}: {' '.join(row['before'].split())} -> {row['after']}")
        return

    def key(row: Mutant) -> tuple:
        return row["file"], *row["span"], row["operator"], row["after"]

    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))  # ends the tests and removes the copy
    options.out.mkdir(parents=True, exist_ok=True)
    results, scratch = options.out / f"{options.seed}-{digest}.jsonl", options.out / f"tree-{os.getpid()}"
    rows = map(json.loads, results.read_text(encoding="utf-8").splitlines() if results.exists() else [])
    done = {key(row): row for row in rows}
    every = [json.loads(line) for file in options.out.glob("*.jsonl") for line in file.read_text(encoding="utf-8").splitlines()]
    excused = equivalents()
    shutil.copytree(ROOT, scratch, ignore=LEFT)
    try:
        for count, row in enumerate(mutants):
            before = done.get(key(row), {"verdict": "survived", "stages": []})
            left = [stage for stage in options.stages if stage not in before["stages"]]
            if tuple(row[key] for key in PLACE) in excused:
                done[key(row)] = row | before
            elif before["verdict"] == "survived" and left:
                result = judge(row, left, every, scratch, options.processes)
                done[key(row)] = result | {"stages": [*before["stages"], *left]}
                every.append(done[key(row)])
                with results.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(done[key(row)], ensure_ascii=False) + "\n")
            mutants[count] = one = done[key(row)]
            verdict = f"{one['verdict']} {one.get('by', '')}"
            print(f"{count + 1}/{len(mutants)} {row['file']}:{row['line']} {row['operator']}: {verdict}", flush=True)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    print(report(mutants))


if __name__ == "__main__":
    main()
