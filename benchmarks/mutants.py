"""Random mutants of both engines: which share of small wrong changes do the tests see?

    python benchmarks/mutants.py --drawn 60 --seed 19                    # all tests; the same call again resumes
    python benchmarks/mutants.py --drawn 20 --stages contract engine     # a quick figure: what these two alone see

A place is drawn uniformly over the executable lines of both engines that an operator fits, then one of the operators that fit
there: constant x 1.01, sign, comparison, dropped term, neighbouring index. Each mutant is put into a scratch copy of the tree and
the stages of tests run in turn until one fails: the contract, the tests and doctests of the engine changed, then the rest. A run of
five times the time of the unchanged tree is stopped and counts as killed; the table states how many. A survivor that is no wrong
program leaves the count only by a written reason in mutants_equivalent.toml. Results: one line of JSON a mutant, in a file named by
the seed and the engines' sources.
"""

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
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
ENGINES = ("semi_analytic", "halfplane_fe")
STAGES = ("contract", "engine", "rest")
UNCHANGED = shutil.ignore_patterns(".git", ".venv", ".cache", ".peers", "out", "_build", "__pycache__", ".mutants")
NEGATED = {ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
           ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In}  # fmt: skip
# A slow machine is no killer: a mutant is stopped only far beyond the time that the unchanged tree took in the same session.
TIMES_THE_UNCHANGED, AT_LEAST = 5.0, 60.0


def executable_lines(source: str) -> set[int]:
    """Lines that carry bytecode, in any function of the module."""
    lines, codes = set(), [compile(source, "module", "exec")]
    while codes:
        code = codes.pop()
        lines |= {line for _, _, line in code.co_lines() if line}
        codes += [constant for constant in code.co_consts if hasattr(constant, "co_lines")]
    return lines


def is_number(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and type(node.value) in {int, float}


def index_constants(node: ast.Subscript) -> Iterator[ast.expr]:
    """The integers written inside square brackets, also in a tuple and as the ends of a slice."""
    for part in node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]:
        for end in (part.lower, part.upper) if isinstance(part, ast.Slice) else (part,):
            inner = end.operand if isinstance(end, ast.UnaryOp) else end
            if inner is not None and is_number(inner):
                yield end


def changes(tree: ast.Module) -> Iterator[tuple[str, ast.expr, str]]:
    """Each (operator, expression, its replacement): every place that an operator fits, annotations, texts and patterns left out."""
    indices: set[ast.AST] = set()
    pending: list[ast.AST] = [tree]
    while pending:
        node = pending.pop()
        match node:
            case ast.JoinedStr() | ast.match_case() | ast.Raise():
                pending += node.body if isinstance(node, ast.match_case) else []
                continue
            case ast.Subscript():
                for index in index_constants(node):
                    indices |= {index, getattr(index, "operand", index)}
                    value = ast.literal_eval(index)
                    yield "neighbouring index", index, str(value + 1 if value >= 0 else value - 1)
            case ast.Constant() if node not in indices and is_number(node) and node.value != 0:
                yield "constant x 1.01", node, f"({node.value!r} * 1.01)"
            case ast.UnaryOp(op=ast.USub()) if node not in indices and not is_number(node.operand):
                yield "sign", node, f"({ast.unparse(node.operand)})"
            case ast.UnaryOp(op=ast.USub()) if node not in indices:
                yield "sign", node, ast.unparse(node.operand)
            case ast.BinOp(op=ast.Add() | ast.Sub()) if not isinstance(node.left, ast.Constant | ast.JoinedStr) or is_number(
                node.left
            ):
                other = ast.Sub() if isinstance(node.op, ast.Add) else ast.Add()
                yield "sign", node, f"({ast.unparse(ast.BinOp(node.left, other, node.right))})"
                yield "dropped term", node, f"({ast.unparse(node.left)})"
            case ast.BinOp(op=ast.Mult()):
                yield "dropped term", node, f"({ast.unparse(node.left)})"
            case ast.BoolOp():
                yield (
                    "dropped term",
                    node,
                    f"({ast.unparse(ast.BoolOp(node.op, node.values[:-1]) if len(node.values) > 2 else node.values[0])})",
                )
            case ast.Compare() if len(node.ops) == 1:
                yield (
                    "comparison",
                    node,
                    f"({ast.unparse(ast.Compare(node.left, [NEGATED[type(node.ops[0])]()], node.comparators))})",
                )
        for name, value in ast.iter_fields(node):
            if name not in {"annotation", "returns", "decorator_list", "type_params", "ops", "op", "ctx"}:
                pending += [child for child in (value if isinstance(value, list) else [value]) if isinstance(child, ast.AST)]


def replaced(source: str, node: ast.expr, text: str) -> str:
    """The source with the text of one expression replaced; ast counts columns in bytes."""
    lines = [line.encode() for line in source.splitlines(keepends=True)]
    before, after = lines[node.lineno - 1][: node.col_offset], lines[node.end_lineno - 1][node.end_col_offset :]
    return b"".join([*lines[: node.lineno - 1], before, text.encode(), after, *lines[node.end_lineno :]]).decode()


def places(tree: Path) -> tuple[dict[tuple[str, int], list[dict]], int]:
    """Mutants by (file, executable line), and the number of executable lines, fitting or not."""
    found: dict[tuple[str, int], list[dict]] = {}
    executable = 0
    for path in sorted(path for engine in ENGINES for path in (tree / engine).glob("**/*.py")):
        source, file = path.read_text(encoding="utf-8"), path.relative_to(tree).as_posix()
        lines = executable_lines(source)
        executable += len(lines)
        for operator, node, text in changes(ast.parse(source)):
            if node.lineno in lines:
                row = {"file": file, "line": node.lineno, "column": node.col_offset, "operator": operator}
                row |= {"before": ast.get_source_segment(source, node), "after": text, "source": replaced(source, node, text)}
                found.setdefault((file, node.lineno), []).append(row)
    return found, executable


def draw(found: dict[tuple[str, int], list[dict]], number: int, seed: int) -> list[dict]:
    """Mutants on different lines: the line uniformly, then the operator, then the place on the line."""
    generator = random.Random(seed)
    drawn = []
    order = sorted(found)
    generator.shuffle(order)  # the first 20 of 60 are the 20 of a draw of 20
    for place in order[:number]:
        operator = generator.choice(sorted({row["operator"] for row in found[place]}))
        drawn.append(generator.choice([row for row in found[place] if row["operator"] == operator]))
    return drawn


def key_of(row: dict) -> tuple:
    return tuple(row[name] for name in ("file", "line", "column", "operator", "after"))


def paths_of(stage: str, engine: str, tree: Path) -> list[str]:
    own = [path.relative_to(tree).as_posix() for path in sorted((tree / "tests").glob(f"test_{engine}_*.py"))]
    if stage == "contract":
        return ["tests/contract"]
    return (
        [*own, engine]
        if stage == "engine"
        else ["--ignore=tests/contract", f"--ignore={engine}", *(f"--ignore={path}" for path in own)]
    )


def run_tests(stage: str, engine: str, tree: Path, processes: int, limit: float | None) -> tuple[int | None, str]:
    """Exit code of pytest, None where it was stopped; and the first test that failed, or the last line."""
    parallel = ["-n", str(processes)] if processes > 1 else ["-p", "no:xdist"]
    options = ["-x", "-q", "--benchmark-disable", "--hypothesis-profile=ci"]
    command = [sys.executable, "-m", "pytest", *options, *parallel, *paths_of(stage, engine, tree)]
    cache = tree / ".cache"
    cache.mkdir(exist_ok=True)
    environment = os.environ | {
        "PYTHONPATH": str(tree),
        "PYTHONDONTWRITEBYTECODE": "1",
        "HALFPLANE_CACHE": "off",
        "MPLBACKEND": "Agg",
    }
    environment |= {
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
        "HOME": str(cache),
        "XDG_CACHE_HOME": str(cache),
        "TMPDIR": str(cache),
    }
    process = subprocess.Popen(
        command, cwd=tree, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True
    )
    try:
        output, _ = process.communicate(timeout=limit)
    except BaseException as stopped:  # an interrupt ends the tests as well
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        if not isinstance(stopped, subprocess.TimeoutExpired):
            raise
        return None, f"stopped after {limit:.0f} s"
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", output, re.MULTILINE)
    return process.returncode, failed[1] if failed else output.strip().splitlines()[-1]


def judge(row: dict, stages: list[str], tree: Path, processes: int, limits: dict[tuple[str, str], float]) -> dict:
    """Put the mutant in, run the stages until one fails, put the original back."""
    path, engine = tree / row["file"], row["file"].split("/")[0]
    original = path.read_text(encoding="utf-8")
    started = time.monotonic()
    verdict = {"verdict": "survived", "stages": stages}
    try:
        path.write_text(row["source"], encoding="utf-8")
        for stage in stages:
            if (stage, engine) not in limits:
                limits[stage, engine] = time_unchanged(stage, engine, tree, processes, path, original)
                path.write_text(row["source"], encoding="utf-8")
            code, test = run_tests(stage, engine, tree, processes, limits[stage, engine])
            if code != 0:
                verdict = {"verdict": "timeout" if code is None else "killed", "stage": stage, "by": test, "stages": stages}
                break
    finally:
        path.write_text(original, encoding="utf-8")
    return (
        {key: value for key, value in row.items() if key != "source"} | verdict | {"seconds": round(time.monotonic() - started, 1)}
    )


def time_unchanged(stage: str, engine: str, tree: Path, processes: int, path: Path, original: str) -> float:
    """The limit of a stage, from a run of the unchanged tree, which must pass."""
    path.write_text(original, encoding="utf-8")
    started = time.monotonic()
    code, test = run_tests(stage, engine, tree, processes, None)
    if code != 0:
        raise SystemExit(f"the unchanged tree fails the stage {stage!r} of {engine} (exit code {code}): {test}")
    seconds = time.monotonic() - started
    print(f"unchanged: {stage} of {engine} in {seconds:.0f} s", flush=True)
    return max(AT_LEAST, TIMES_THE_UNCHANGED * seconds)


def equivalents() -> dict[tuple[str, str, str], str]:
    """Written reasons by (file, before, after)."""
    entries = tomllib.loads(Path(__file__).with_name("mutants_equivalent.toml").read_text(encoding="utf-8")).get("mutant", [])
    return {(entry["file"], entry["before"], entry["after"]): entry["reason"] for entry in entries if entry["reason"].strip()}


def report(rows: list[dict]) -> str:
    """Counts, equivalent mutants with their reasons, and a table of survivors."""
    reasons = equivalents()
    survivors = [row for row in rows if row["verdict"] == "survived"]
    excused = [row for row in survivors if (row["file"], row["before"], row["after"]) in reasons]
    stopped = sum(row["verdict"] == "timeout" for row in rows)
    counted = len(rows) - len(excused)
    killed = len(rows) - len(survivors)
    lines = [
        f"{len(rows)} drawn, {len(excused)} equivalent, {killed} of {counted} killed ({100 * killed / max(1, counted):.0f} %),"
    ]
    lines[0] += f" {stopped} of them stopped at the limit of time"
    lines += [f"equivalent: {row['file']}:{row['line']}: {reasons[row['file'], row['before'], row['after']]}" for row in excused]
    lines += ["", "| survivor | operator | before | after | survived |", "|---|---|---|---|---|"]
    for row in survivors:
        if row not in excused:
            before, after = (" ".join(row[key].split()).replace("|", "\\|") for key in ("before", "after"))
            lines.append(
                f"| {row['file']}:{row['line']} | {row['operator']} | `{before}` | `{after}` | {', '.join(row['stages'])} |"
            )
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
    mutants = draw(found, options.drawn, options.seed)
    sources = "".join(path.read_text(encoding="utf-8") for engine in ENGINES for path in sorted((ROOT / engine).glob("**/*.py")))
    digest = hashlib.sha256(sources.encode()).hexdigest()[:12]
    print(f"seed {options.seed}, sources {digest}: {len(mutants)} drawn of {len(found)} lines that an operator fits")
    print(f"(of {executable} executable lines)", flush=True)
    if options.list:
        for row in mutants:
            print(f"{row['file']}:{row['line']}: {row['operator']}: {' '.join(row['before'].split())} -> {row['after']}")
        return

    options.out.mkdir(parents=True, exist_ok=True)
    results = options.out / f"{options.seed}-{digest}.jsonl"
    done: dict[tuple, dict] = {}
    for line in results.read_text(encoding="utf-8").splitlines() if results.exists() else []:
        row = json.loads(line)
        done[key_of(row)] = row
    scratch = options.out / f"tree-{os.getpid()}"
    shutil.copytree(ROOT, scratch, ignore=UNCHANGED)
    limits: dict[tuple[str, str], float] = {}
    try:
        for number, row in enumerate(mutants):
            key = key_of(row)
            before = done.get(key, {"verdict": "survived", "stages": []})
            left = [stage for stage in options.stages if stage not in before["stages"]]
            if before["verdict"] == "survived" and left:
                result = judge(row, left, scratch, options.processes, limits)
                done[key] = result | {"stages": [*before["stages"], *left]}
                with results.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(done[key], ensure_ascii=False) + "\n")
            mutants[number] = done[key]
            verdict = f"{done[key]['verdict']} {done[key].get('by', '')}"
            print(f"{number + 1}/{len(mutants)} {row['file']}:{row['line']} {row['operator']}: {verdict}", flush=True)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    print(report(mutants))


if __name__ == "__main__":
    main()
