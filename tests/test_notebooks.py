"""Notebooks run from top to bottom, import only what is there, stay short and carry no outputs."""

import ast
import os
import shutil
import sys
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
IMPORTABLE = {"indoorfit", "numpy", "IPython"} | sys.stdlib_module_names
"""Who can open a notebook after `pip install indoorfit` has these."""
MAX_CELLS = 25
MAX_LINES = 25


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def notebook(request):
    return nbformat.read(request.param, as_version=4)


def code_of(notebook):
    return [cell.source for cell in notebook.cells if cell.cell_type == "code"]


# The kernel is another process with sockets of its own; what its libraries warn of is not ours to mend.
@pytest.mark.filterwarnings("ignore")
def test_notebook_runs(notebook, tmp_path, monkeypatch):
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    monkeypatch.setenv("PATH", path)
    # Beside what it reads, as in the repository, but where it may write.
    place, data = tmp_path / "notebooks", tmp_path / "benchmarks"
    place.mkdir()
    data.mkdir()
    shutil.copy(ROOT / "benchmarks" / "calibration.json", data)
    client = NotebookClient(
        notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": place}}
    )
    client.execute()
    failed = [
        output.text
        for cell in notebook.cells
        if cell.cell_type == "code"
        for output in cell.outputs
        if output.output_type == "stream" and "indoorfit: " in output.text
    ]
    # A shell line that fails raises nothing; its message is all there is.
    assert failed == []


def test_there_are_notebooks():
    # Without this an empty folder would pass as four skipped tests.
    assert NOTEBOOKS


def test_notebook_imports_only_what_is_there(notebook):
    modules = set()
    for source in code_of(notebook):
        plain = "\n".join(line for line in source.splitlines() if not line.startswith(("!", "%")))
        for node in ast.walk(ast.parse(plain)):
            if isinstance(node, ast.Import):
                modules |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                modules.add(node.module or "")
    roots = {name.partition(".")[0] for name in modules}
    assert "indoorfit" in roots
    assert roots <= IMPORTABLE


def test_notebook_is_short(notebook):
    assert len(notebook.cells) <= MAX_CELLS
    assert max(source.count("\n") + 1 for source in code_of(notebook)) <= MAX_LINES


def test_notebook_is_committed_without_outputs(notebook):
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(cell.outputs == [] and cell.execution_count is None for cell in cells)
