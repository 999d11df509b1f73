"""The notebook of the manual runs from its first cell to its last, and its objects show themselves."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

NOTEBOOK = Path(__file__).parents[1] / "docs" / "first-steps.ipynb"


def run(path: Path, folder: Path, added: str = "") -> list[dict]:
    """Outputs of every code cell."""
    book = nbformat.read(path, as_version=4)
    if added:
        book.cells.append(nbformat.v4.new_code_cell(added))
    os.environ.setdefault("PYDEVD_DISABLE_FILE_VALIDATION", "1")
    nbclient.NotebookClient(book, timeout=120, resources={"metadata": {"path": str(folder)}}).execute()
    return [output for cell in book.cells if cell.cell_type == "code" for output in cell.outputs]


def test_the_notebook_runs_and_shows_scene_solution_and_comparison(tmp_path: Path) -> None:
    outputs = run(NOTEBOOK, tmp_path)
    shown = [output["data"]["text/html"] for output in outputs if "text/html" in output.get("data", {})]
    assert any("Cattaneo-Mindlin" in html for html in shown)
    assert any("tolerance" in html for html in shown)
    printed = "".join(output["text"] for output in outputs if output["output_type"] == "stream" and output["name"] == "stdout")
    assert "0.0012117117" in printed
    assert not [output for output in outputs if output["output_type"] == "stream" and output["name"] == "stderr"]


def test_a_cell_that_fails_is_a_failure(tmp_path: Path) -> None:
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell("1 / 0")])
    path = tmp_path / "broken.ipynb"
    nbformat.write(book, path)
    with pytest.raises(nbclient.exceptions.CellExecutionError, match="ZeroDivisionError"):
        run(path, tmp_path)


def test_the_notebook_is_kept_without_outputs() -> None:
    book = nbformat.read(NOTEBOOK, as_version=4)
    assert not [cell for cell in book.cells if cell.cell_type == "code" and (cell.outputs or cell.execution_count)]
