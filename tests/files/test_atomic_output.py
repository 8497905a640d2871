"""Files and directories appear whole or not at all, and nothing foreign is deleted."""

import errno
import os
import stat
from pathlib import Path

import pytest

from indoorfit.errors import OutputError
from indoorfit.files import atomic_directory, atomic_file, check_output_directory

RESULT = '{"schema": "indoorfit.model/1"}'


def tree(root: Path) -> dict[str, bytes | None]:
    return {
        str(p.relative_to(root)): p.read_bytes() if p.is_file() else None for p in sorted(root.rglob("*"))
    }


def fill(directory: Path, content: str = RESULT) -> None:
    (directory / "model.json").write_text(content)
    (directory / "textures").mkdir()
    (directory / "textures" / "a.png").write_bytes(b"png")


def fill_and_fail(target: Path, error: BaseException, overwrite: bool = False) -> None:
    with atomic_directory(target, overwrite=overwrite) as work:
        fill(work, "{}")
        raise error


def test_atomic_file_appears_at_the_end_of_the_block(tmp_path):
    target = tmp_path / "a.bin"
    with atomic_file(target) as file:
        file.write(b"new")
        assert not target.exists()
    assert tree(tmp_path) == {"a.bin": b"new"}


def test_atomic_file_keeps_the_old_content_after_an_error(tmp_path):
    target = tmp_path / "a.bin"
    target.write_bytes(b"old")

    def interrupted():
        with atomic_file(target) as file:
            file.write(b"half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert tree(tmp_path) == {"a.bin": b"old"}


def test_atomic_file_refuses_what_it_may_not_replace(tmp_path):
    (tmp_path / "a.bin").write_bytes(b"old")
    before = tree(tmp_path)
    for path, options in ((tmp_path / "a.bin", {"overwrite": False}), (tmp_path, {})):
        with pytest.raises(OutputError), atomic_file(path, **options) as file:
            file.write(b"new")
    assert tree(tmp_path) == before


def test_atomic_file_tells_of_a_missing_folder(tmp_path):
    with pytest.raises(OutputError, match="No such file"), atomic_file(tmp_path / "absent" / "a.bin") as file:
        file.write(b"new")


@pytest.mark.parametrize("depth", ["out", "a/b/out"])
def test_atomic_directory_appears_whole_with_its_parents(tmp_path, depth):
    with atomic_directory(tmp_path / depth) as work:
        fill(work)
        assert not (tmp_path / depth).exists()
    assert (tmp_path / depth / "textures" / "a.png").read_bytes() == b"png"
    assert not [name for name in tree(tmp_path) if name.split("/")[-1].startswith(".")]
    # As any directory that the user makes, not the private one of tempfile.
    (tmp_path / "plain").mkdir()
    assert stat.S_IMODE((tmp_path / depth).stat().st_mode) == stat.S_IMODE(
        (tmp_path / "plain").stat().st_mode
    )


@pytest.mark.parametrize("depth", ["out", "a/b/out"])
@pytest.mark.parametrize(
    "error", [ValueError("x"), KeyboardInterrupt(), OSError(errno.ENOSPC, "No space left")]
)
def test_atomic_directory_leaves_nothing_after_an_error(tmp_path, depth, error):
    expected = OutputError if isinstance(error, OSError) else type(error)
    with pytest.raises(expected):
        fill_and_fail(tmp_path / depth, error)
    assert tree(tmp_path) == {}


def test_atomic_directory_replaces_an_older_result_as_a_whole(tmp_path):
    with atomic_directory(tmp_path / "out") as work:
        fill(work)
        (work / "old.txt").touch()
    with atomic_directory(tmp_path / "out", overwrite=True) as work:
        (work / "model.json").write_text(RESULT)
        assert (tmp_path / "out" / "old.txt").exists()
    assert tree(tmp_path) == {"out": None, "out/model.json": RESULT.encode()}


def test_atomic_directory_keeps_the_older_result_after_an_error(tmp_path):
    with atomic_directory(tmp_path / "out") as work:
        fill(work)
    before = tree(tmp_path)
    with pytest.raises(ValueError, match="fit"):
        fill_and_fail(tmp_path / "out", ValueError("fit"), overwrite=True)
    assert tree(tmp_path) == before


def test_atomic_directory_puts_the_older_result_back_when_the_swap_fails(tmp_path, monkeypatch):
    with atomic_directory(tmp_path / "out") as work:
        fill(work)
    before = tree(tmp_path)
    rename, calls = os.rename, []

    def second_fails(source, target):
        calls.append(source)
        if len(calls) == 2:
            raise OSError(errno.EIO, "Input/output error")
        rename(source, target)

    monkeypatch.setattr(os, "rename", second_fails)
    with pytest.raises(OutputError, match="Input/output"), atomic_directory(tmp_path / "out", overwrite=True):
        pass
    assert tree(tmp_path) == before


FOREIGN = {
    "someone's files": {"thesis.tex": "x"},
    "a model.json of another program": {"model.json": '{"layers": []}', "weights.bin": "x"},
}


@pytest.mark.parametrize("files", FOREIGN.values(), ids=FOREIGN)
def test_overwriting_never_touches_a_directory_that_indoorfit_did_not_write(tmp_path, files):
    for name, content in files.items():
        (tmp_path / name).write_text(content)
    before = tree(tmp_path)
    with pytest.raises(OutputError, match="not overwritten"), atomic_directory(tmp_path, overwrite=True):
        pass
    with pytest.raises(OutputError, match="not overwritten"):
        check_output_directory(tmp_path / "x" / "..", overwrite=True)
    assert tree(tmp_path) == before


def test_an_existing_directory_needs_overwriting_even_if_empty(tmp_path):
    (tmp_path / "out").mkdir()
    with pytest.raises(OutputError, match="--overwrite"):
        check_output_directory(tmp_path / "out")
    with atomic_directory(tmp_path / "out", overwrite=True) as work:
        fill(work)
    assert (tmp_path / "out" / "model.json").exists()


def test_a_link_to_an_older_result_stays_a_link(tmp_path):
    with atomic_directory(tmp_path / "real") as work:
        fill(work)
    (tmp_path / "link").symlink_to("real")
    with atomic_directory(tmp_path / "link", overwrite=True) as work:
        fill(work, RESULT + " ")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real" / "model.json").read_text() == RESULT + " "


def test_a_file_in_the_way_is_told_before_any_work(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    for path in (tmp_path / "file", tmp_path / "file" / "out"):
        with pytest.raises(OutputError, match="no directory"):
            check_output_directory(path, overwrite=True)
    # Patched, for the superuser may write everywhere and tests may run as one.
    monkeypatch.setattr(os, "access", lambda *args: False)
    with pytest.raises(OutputError, match="cannot be written"):
        check_output_directory(tmp_path / "out")
