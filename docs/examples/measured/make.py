"""One small file of each kind that is read: loads and profiles of spreadsheets, data loggers and
scripts; reports of Abaqus.

    python docs/examples/measured/make.py FOLDER

No rig stands behind them: the numbers are formulas with noise from a seed. `SCENES` has the keys
that each file needs. Nor was Abaqus run: its reports are laid out like those of its users, and hold
half-plane theory of the scene `RESULT`.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

THICKNESS = 10.0  # of the specimen [mm]
# By file: keys of [load] or [profile] beside `file`.
SCENES = {
    "spreadsheet.csv": 'kind = "time_series"\nthickness = 10.0',
    "logger.txt": (
        'kind = "time_series"\nthickness = 10.0\nzero = {P = 0.02, Q = -3.5}\nsign = {P = -1}'
    ),
    "script.txt": 'kind = "time_series"',
    "channels.csv": 'kind = "time_series"\ncolumns = {time = 1, P = 3, Q = 2}\nthickness = 10.0',
    "noisy.csv": (
        'kind = "time_series"\naverage = 7\nreduce = "tolerance"\nthreshold = {P = 0.4, Q = 0.2}'
    ),
    "trace.txt": 'kind = "tabulated"\nzero = {x = 1500.0}',
}

# Scene, times and reports of a result.
RESULT = "cattaneo-mindlin"
TIMES = (1.0, 1.5, 2.0)
REPORTS = ("field.rpt", "xy.rpt")


def record(rows: int, noise: float = 0.0) -> NDArray[np.float64]:
    """Time [s], P and Q [N/mm], (rows, 3): a run-up, then swings of Q of two periods while P swings
    too; noise of P and Q.
    """
    time = np.linspace(0.0, 8.0, rows)
    up = 1 - np.exp(-4 * time)
    normal = 2 + 88 * up + 9 * up * np.sin(2 * np.pi * 0.7 * time)
    tangential = up * (
        16 * np.sin(2 * np.pi * 0.7 * time + 0.6) + 7 * np.sin(2 * np.pi * 0.23 * time)
    )
    loads = np.column_stack([normal, tangential])
    loads = loads + noise * np.random.default_rng(21).normal(size=(rows, 2))
    return np.column_stack([time, loads])


def main(folder: Path) -> None:
    """Writes them all."""
    time, normal, tangential = record(161).T
    lines = [
        f"{t:.2f};{p:.4f};{q:.1f}"
        for t, p, q in zip(time, normal * THICKNESS / 1e3, tangential * THICKNESS, strict=True)
    ]
    text = "\r\n".join(["Time [s];Normal force [kN];Shear force [N]", *lines]) + "\r\n"
    (folder / "spreadsheet.csv").write_bytes(text.replace(".", ",").encode("utf-8-sig"))

    rows = zip(
        1e3 * time, 0.02 - normal * THICKNESS / 1e3, tangential * THICKNESS - 3.5, strict=True
    )
    lines = [
        "Rig 4, run 12",
        "Date\t3.2.2026",
        "t\tFN\tFT\tstate",
        "ms\tkN\tN\t-",
        *(f"{t:.0f}\t{p:.5f}\t{q:.2f}\tok" for t, p, q in rows),
    ]
    (folder / "logger.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")

    np.savetxt(
        folder / "script.txt",
        np.column_stack([time, tangential, normal]),
        fmt="%.6e",
        header="time Q P",
    )

    lines = [
        f"{t:.2f},{q:.3f},{p:.3f},21.5"
        for t, p, q in zip(time, normal * THICKNESS, tangential * THICKNESS, strict=True)
    ]
    (folder / "channels.csv").write_text(
        "\n".join(["channel data", *lines]) + "\n", encoding="utf-8"
    )

    lines = [
        "time,P [N/mm],Q [N/mm]",
        *(f"{t:.4f},{p:.3f},{q:.3f}" for t, p, q in record(2000, noise=0.3)),
    ]
    (folder / "noisy.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")

    place = np.linspace(-1.5, 1.5, 61)
    lines = [
        "x [µm];z [nm]",
        *(f"{1e3 * x + 1500:.0f};{1e6 * x**2 / 2000:.3f}".replace(".", ",") for x in place),
    ]
    (folder / "trace.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    reports(folder)


def figure(value: float) -> str:
    """As Abaqus writes it: powers of ten by threes.

    >>> figure(0.0), figure(-1.1), figure(0.0123456)
    ('0.', '-1.10000', '12.3456E-03')
    """
    if value == 0:
        return "0."
    power = 3 * int(np.floor(np.log10(abs(value)) / 3))
    return f"{value / 10.0**power:.6g}E{power:+03d}" if power else f"{value:.5f}"


def reports(folder: Path) -> None:
    """`field.rpt`: nodal values of both parts, nodes within them too, at three frames. `xy.rpt`:
    along the path, side by side.
    """
    import semi_analytic
    from scenes import load_scene

    x = np.linspace(-1.2, 1.2, 61)
    scene = load_scene(RESULT)
    solution = semi_analytic.solve(scene, x=x, time=TIMES, fields=("pressure", "shear"))
    text = []
    for k, time in enumerate(TIMES):
        for part, sign in (("BLOCK-1", -1.0), ("PAD-1", 1.0)):
            text += [
                "*" * 80,
                "Field Output Report, written Tue Feb  3 10:00:00 2026",
                "",
                "Source 1",
                "---------",
                "",
            ]
            text += [
                "   ODB: C:/temp/fretting.odb",
                "   Step: Step-1",
                f"   Frame: Increment     {k + 5}: Step Time =    {time:.3f}",
            ]
            text += [
                "",
                "Loc 1 : Nodal values from source 1",
                "",
                'Output sorted by column "Node Label".',
                "",
            ]
            text += [f"Field Output reported at nodes for part: {part}", ""]
            names = ("Node", "COORD.COORD1", "COORD.COORD2", "CPRESS", "CSHEAR1")
            text.append("".join(f"{name:>18}" for name in names))
            text.append("".join(f"{word:>18}" for word in ("Label", *["@Loc 1"] * 4)))
            text.append("-" * 90)
            for depth in (0.0, 0.1):  # the face, and a row of nodes beneath
                for node, place in enumerate(x):
                    slave = part == "BLOCK-1" and depth == 0
                    values = (
                        place,
                        sign * depth,
                        solution.pressure[k, node] * slave,
                        solution.shear[k, node] * slave,
                    )
                    text.append(
                        f"{node + 1 + (1000 if depth else 0):>18}"
                        + "".join(f"{figure(float(v)):>18}" for v in values)
                    )
            text += [
                "",
                "",
                "  Minimum              -1.20000",
                "      At Node                 1",
                "",
            ]
    (folder / "field.rpt").write_text("\n".join(text) + "\n", encoding="utf-8")
    names = [
        "X",
        *(f"{name} Frame {k + 5}" for k in range(len(TIMES)) for name in ("CPRESS", "CSHEAR1")),
    ]
    columns = [
        x,
        *(values[k] for k in range(len(TIMES)) for values in (solution.pressure, solution.shear)),
    ]
    lines = ["", "".join(f"{name:>20}" for name in names), ""]
    for row in zip(*columns, strict=True):
        cells = [f"{figure(float(value)):>20}" for value in row]
        lines.append("".join(cells))
    (folder / "xy.rpt").write_text("\n".join(lines) + "\n\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
