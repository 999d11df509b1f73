"""A path table in the form in which Abaqus/CAE reports it, with CalculiX' numbers: nobody here has
Abaqus.

    python make.py DECK.inp FOLDER

Takes the deck that `halfplane export SCENE` writes, runs CalculiX, and reports CPRESS and CSHEAR1
along the lower face at every instant of the last revolution: path.rpt, and the same as path.csv.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

from reports.scoring.mapping import Mapping
from reports.scoring.reading import read_result
from reports.studies.third.calculix import attempts_in, calculix_version, find_calculix
from scenes import load_scene

SCENE = "cattaneo-mindlin"
NAME = "path"
REVOLUTION = 2.0  # of the scene's load path, in its time
REACH = 1.5  # of the path to each side of the middle [mm]


def figure(value: float) -> str:
    """Six digits, zero with a point."""
    text = f"{value + 0.0:.6G}"
    return text if "." in text or "E" in text else f"{text}."


def report(folder: Path, names: list[str], columns: np.ndarray) -> None:
    """path.rpt, all XY data in one table, page width without limit; path.csv."""
    head = "".join(f"{name:>18}" for name in names)
    report_lines = []
    csv_lines = [",".join(names)]
    for row in columns:
        cells = [figure(value) for value in row]
        report_lines.append("".join(f"{cell:>18}" for cell in cells))
        csv_lines.append(",".join(cells))
    body = "\n".join(report_lines)
    (folder / "path.rpt").write_text(f"\n{head}\n\n{body}\n\n", encoding="utf-8")
    (folder / "path.csv").write_text("\n".join(csv_lines) + "\n", encoding="utf-8")


def main(deck: Path, folder: Path) -> None:
    """Deck, run, tables, mapping, and what made them."""
    program = find_calculix()
    shutil.copyfile(deck, folder / f"{NAME}.inp")
    alone = {**os.environ, "OMP_NUM_THREADS": "1", "CCX_NPROC_RESULTS": "1"}
    with (folder / "ccx.log").open("w", encoding="utf-8") as log:
        subprocess.run([program, "-i", NAME], cwd=folder, env=alone, stdout=log, check=True)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    scene = load_scene(SCENE)
    surface = read_result(folder / f"{NAME}.frd", Mapping())
    if surface.time is None:
        raise ValueError(f"{NAME}.frd states no times")
    is_on_path = np.abs(surface.x) < REACH
    x = surface.x[is_on_path]
    steps = np.flatnonzero(surface.time > surface.time[-1] - REVOLUTION * (1 + 1e-6))
    # The first step of the deck, the touch, is none of the instants.
    names = ["X", *(f"{field}_STEP{step + 2}" for step in steps for field in ("CPRESS", "CSHEAR1"))]
    fields = []
    for step in steps:
        fields += [surface.pressure[step, is_on_path], surface.shear[step, is_on_path]]
    start = float(x[0])
    report(folder, names, np.column_stack([x - start, *fields]))
    words = f'code = "CalculiX {calculix_version(program)} in the form of an Abaqus path table"\n'
    words += (
        "# The path counts the true distance from its first node.\n" + f"x_offset = {-start:.7g}\n"
    )
    times = surface.time[steps] + scene.load.path().start
    words += "# Times of the scene's load path: the names of the columns count steps.\n"
    words += f"times = [{', '.join(f'{value:.7g}' for value in times)}]\n"
    (folder / "mapping.toml").write_text(words, encoding="utf-8")
    accepted = sum(attempt.is_accepted for attempt in attempts_in(folder / f"{NAME}.sta"))
    origin = {
        "code": f"CalculiX {calculix_version(program)}",
        "seconds": round(seconds, 1),
        "increments": accepted,
    }
    (folder / "made.json").write_text(json.dumps(origin) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve())
