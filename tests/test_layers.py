"""The gate: import directions, style and types are tests like the others."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def gate(tool: str, *arguments: str) -> None:
    executable = Path(sys.executable).with_name(tool)
    done = subprocess.run(
        [str(executable), *arguments], cwd=ROOT, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_imports_run_one_way():
    gate("lint-imports", "--no-cache")


@pytest.mark.parametrize("arguments", [("check",), ("format", "--check")], ids=["lint", "format"])
def test_style(arguments):
    gate("ruff", *arguments, "--no-cache", "src", "tests", "benchmarks")


def test_types():
    gate("pyright", "--pythonpath", sys.executable)
