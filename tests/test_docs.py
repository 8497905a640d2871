"""Every example in README.md and docs/ runs, and what they say of files and commands is so."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from indoorfit.config import config_from_dict

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
EVERY_PAGE = [
    *PAGES,
    *sorted((ROOT / "docs" / "api").glob("*.md")),
    *sorted(path for path in ROOT.glob("*.md") if path.name != "README.md"),
]
SET_UP = "python3 -m venv .venv && .venv/bin/pip install "
"""Lines that begin so make an environment from the network: that is what `.ci/run` does."""
SHELL = frozenset("|<>;&$`*")
"""A line with one of these is for a shell."""


def blocks(page, *languages):
    """(language, text) of the fenced examples of a page, in order, without the indent of lists."""
    pattern = re.compile(r"^( *)```(\w+)\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)
    for indent, language, text in pattern.findall(page.read_text(encoding="utf-8")):
        if language in languages:
            yield language, "".join(line.removeprefix(indent) for line in text.splitlines(keepends=True))


def ids(path):
    return path.stem


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    path = tmp_path_factory.mktemp("scan") / "scan.ply"
    run(["indoorfit", "simulate", "L", "-o", str(path), "--points", "8000"], path.parent)
    return path


def run(command, folder):
    """Run in the interpreter's own environment, whether or not it is active in the shell."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(
        command, cwd=folder, env={**os.environ, "PATH": path}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.mark.parametrize("page", PAGES, ids=ids)
def test_examples_run(page, scan, tmp_path, run_cli, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(scan, tmp_path)
    program = ""
    for language, text in blocks(page, "sh", "python"):
        if language == "python":
            program += text
            continue
        for line in text.splitlines():
            command = line.rpartition("&& .venv/bin/")[2] if line.startswith(SET_UP) else line
            if command.startswith("indoorfit ") and not SHELL & set(command):
                # Here and not in a process of its own, which takes two seconds to load what is loaded here.
                outcome = run_cli(*shlex.split(command)[1:])
                assert outcome.code == 0, f"{command}\n{outcome.out}\n{outcome.err}"
            elif not command.startswith("pytest"):  # the tests are what is running now
                run(["bash", "-c", command], tmp_path)
    if program:
        run([sys.executable, "-W", "error", "-c", program], tmp_path)


@pytest.mark.parametrize("page", PAGES, ids=ids)
def test_data_examples_are_valid(page):
    import tomllib

    for language, text in blocks(page, "toml", "json"):
        if language == "json":
            json.loads(text)
        else:
            config_from_dict(tomllib.loads(text))


def test_ci_runs_the_readme_test_command():
    lines = [line for _, text in blocks(ROOT / "README.md", "sh") for line in text.splitlines()]
    commands = [line for line in lines if "pytest" in line]
    assert len(commands) == 1
    assert commands[0] in (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()


def test_readme_lists_the_files_that_fit_writes(scan, tmp_path):
    run(["indoorfit", "fit", str(scan), "--out", str(tmp_path / "room"), "--quiet"], tmp_path)
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    table = text.split("## What comes out")[1].split("\n## ")[0]
    cells = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    named = {name for cell in cells for name in re.findall(r"`([^`]+)`", cell)}
    assert named == {path.name for path in (tmp_path / "room").iterdir()}


def test_api_reference_is_current(tmp_path):
    # In a process of its own: the type checks of the tests change what a function shows of itself.
    run([sys.executable, str(ROOT / "docs" / "make_api.py"), str(tmp_path)], ROOT)
    written = {path.name: path.read_text(encoding="utf-8") for path in (ROOT / "docs" / "api").glob("*.md")}
    fresh = {path.name: path.read_text(encoding="utf-8") for path in tmp_path.glob("*.md")}
    assert written == fresh, "run: python docs/make_api.py"


def test_every_command_is_in_the_documentation():
    from typing import get_args

    from indoorfit.cli.main import Command

    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    for kind in get_args(Command):
        name = get_args(kind)[0].__name__.removesuffix("Command")
        command = re.sub(r"(?<!^)(?=[A-Z])", "-", name).lower()
        assert f"indoorfit {command}" in text, command


@pytest.mark.parametrize("page", EVERY_PAGE, ids=ids)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8")):
        if "://" not in target:
            assert (page.parent / target).exists(), target
