"""Files and directories that appear whole or not at all.

The work goes to a sibling with a temporary name, which is renamed at the end. This guards against
errors and interrupts of the program, not against a loss of power (nothing is flushed to the disk).
"""

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from ..errors import OutputError

_MARK = "model.json"
_SCHEMA_PREFIX = b'"indoorfit.model/'
_HEAD_BYTES = 4096


@contextmanager
def atomic_file(path: str | Path, *, overwrite: bool = True) -> Iterator[BinaryIO]:
    """A binary file that takes the place of `path` when the block ends without an error.

    Raises:
        OutputError: the target is a directory, exists without `overwrite`, or cannot be written.
    """
    target = _resolved(path)
    if target.is_dir():
        raise OutputError(f"{target}: is a directory; a file is to be written. Fix: name a file.")
    if target.exists() and not overwrite:
        raise OutputError(f"{target}: exists already. Fix: choose another name, or allow overwriting.")
    temporary = _sibling(target, "part")
    with _os_errors_told(target):
        try:
            # Mode x: a name that someone else made in the meantime is never written to.
            with open(temporary, "xb") as file:
                yield file
            os.replace(temporary, target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise


def check_output_directory(path: str | Path, *, overwrite: bool = False) -> None:
    """Raise now what `atomic_directory` would raise, so that no long run ends in it.

    Raises:
        OutputError: the target exists without `overwrite`, or is nothing that indoorfit wrote, or its
            place cannot be written to.
    """
    target = _resolved(path)
    if os.path.lexists(target):
        _check_replaceable(target, overwrite)
    place = next(parent for parent in target.parents if parent.exists())
    if not place.is_dir():
        raise OutputError(f"{target}: {place} is no directory. Fix: choose another place.")
    if not os.access(place, os.W_OK | os.X_OK):
        raise OutputError(f"{target}: {place} cannot be written to. Fix: choose another place.")


@contextmanager
def atomic_directory(path: str | Path, *, overwrite: bool = False) -> Iterator[Path]:
    """An empty directory to fill, which becomes `path` when the block ends without an error.

    Parents that are missing are made, and taken away again after an error. With `overwrite` an older
    result is replaced as a whole: moved aside, swapped, then deleted.

    Raises:
        OutputError: as `check_output_directory`, or the writing fails.
    """
    check_output_directory(path, overwrite=overwrite)
    target = _resolved(path)
    temporary = _sibling(target, "part")
    with _os_errors_told(target):
        missing = [parent for parent in target.parents if not parent.exists()]
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            temporary.mkdir()
            yield temporary
            _swap_in(temporary, target, overwrite)
        except BaseException:
            shutil.rmtree(temporary, ignore_errors=True)
            for parent in missing:
                _remove_if_empty(parent)
            raise


def _swap_in(temporary: Path, target: Path, overwrite: bool) -> None:
    if not os.path.lexists(target):
        os.rename(temporary, target)
        return
    # Asked again: the block may have taken minutes, and someone may have used the name since.
    _check_replaceable(target, overwrite)
    aside = _sibling(target, "old")
    os.rename(target, aside)
    try:
        os.rename(temporary, target)
    except BaseException:
        os.rename(aside, target)
        raise
    # From here on the new result stands; a remnant of the old one is no reason to fail.
    shutil.rmtree(aside, ignore_errors=True)


def _check_replaceable(target: Path, overwrite: bool) -> None:
    if not target.is_dir():
        raise OutputError(f"{target}: exists and is no directory. Fix: choose another output directory.")
    if not overwrite:
        raise OutputError(f"{target}: exists already. Fix: choose another directory, or give --overwrite.")
    try:
        ours = not any(target.iterdir()) or _is_result(target)
    except OSError as e:
        raise OutputError(
            f"{target}: cannot be looked into: {e.strerror}. Fix: check its permissions."
        ) from e
    # Overwriting deletes the whole directory: '--out ~' must not be able to.
    if not ours:
        raise OutputError(
            f"{target}: is not empty and holds no {_MARK} of indoorfit, so it is not overwritten. "
            "Fix: choose another directory."
        )


def _is_result(directory: Path) -> bool:
    mark = directory / _MARK
    if not mark.is_file():
        return False
    with open(mark, "rb") as file:
        return _SCHEMA_PREFIX in file.read(_HEAD_BYTES)


def _resolved(path: str | Path) -> Path:
    """Absolute, links followed: what is replaced is the thing itself, and '.' gets a name."""
    try:
        return Path(path).resolve()
    except (OSError, RuntimeError, ValueError) as e:
        raise OutputError(f"{path}: is no usable path: {e}. Fix: choose another place.") from e


def _sibling(target: Path, kind: str) -> Path:
    return target.with_name(f".{target.name[:100]}.{secrets.token_hex(4)}.{kind}")


def _remove_if_empty(directory: Path) -> None:
    try:
        directory.rmdir()
    except OSError:
        return  # someone put something in; it is theirs now


@contextmanager
def _os_errors_told(target: Path) -> Iterator[None]:
    try:
        yield
    except OSError as e:
        reason = e.strerror or type(e).__name__
        raise OutputError(
            f"{target}: cannot be written: {reason}. Fix: check space, permissions and path."
        ) from e
