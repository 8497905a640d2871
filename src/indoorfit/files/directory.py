"""A whole directory of results."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from indoorfit.errors import OutputError

from .place import os_errors_told, remove, resolved, sibling, swap_in

_MARK = "model.json"
_SCHEMA_PREFIX = b'"indoorfit.model/'
_HEAD_BYTES = 4096


def check_output_directory(path: str | Path, *, overwrite: bool = False) -> None:
    """Raise now what `atomic_directory` would raise, so that no long run ends in it.

    Raises:
        OutputError: the target exists without `overwrite`, or is nothing that indoorfit wrote, or its
            place cannot be written to.
    """
    target = resolved(path)
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
    target = resolved(path)
    temporary = sibling(target, "part")
    with os_errors_told(target):
        missing = [parent for parent in target.parents if not parent.exists()]
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            temporary.mkdir()
            yield temporary
            if os.path.lexists(target):
                # Asked again: the block may have taken minutes, and someone may have used the name since.
                _check_replaceable(target, overwrite)
            aside = swap_in(temporary, target)
        except BaseException:
            remove(temporary)
            for parent in missing:
                _remove_if_empty(parent)
            raise
        if aside is not None:
            # From here on the new result stands; a remnant of the old one is no reason to fail.
            remove(aside)


def _check_replaceable(target: Path, overwrite: bool) -> None:
    if not target.is_dir():
        raise OutputError(f"{target}: exists and is no directory. Fix: choose another output directory.")
    if not overwrite:
        raise OutputError(
            f"{target}: exists already. Fix: choose another directory, or give --overwrite (overwrite=True)."
        )
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


def _remove_if_empty(directory: Path) -> None:
    try:
        directory.rmdir()
    except OSError:
        return  # someone put something in; it is theirs now
