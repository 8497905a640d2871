"""Several output files that appear together or not at all."""

import os
import secrets
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from indoorfit.errors import OutputError


@contextmanager
def staged(
    targets: Sequence[Path], *, overwrite: bool, marks: tuple[str, ...] = (), stale: Sequence[Path] = ()
) -> Iterator[list[Path]]:
    """Places to write to, which take the targets' names when the block ends without an error.

    Args:
        targets: files, or directories to be filled.
        overwrite: whether existing targets may be replaced.
        marks: files that a directory must hold to be replaced, so that none of someone else's ever is.
        stale: files that would contradict the new ones; removed with `overwrite`, refused without.

    Yields:
        for each target a path beside it that does not exist yet, with the same suffix.

    Raises:
        OutputError: a target exists, has no writable directory to lie in, or comes twice.
    """
    for path in (*targets, *stale):
        _check(path, overwrite, marks)
    if len({path.resolve() for path in targets}) < len(targets):
        raise OutputError(
            f"{targets[0].name}: two outputs have the same name. Fix: give each a name of its own."
        )
    places = [path.with_name(f".{secrets.token_hex(4)}.{path.name}") for path in targets]
    try:
        yield places
        for place, target in zip(places, targets, strict=True):
            _take_the_place(place, target)
        for path in stale:
            path.unlink(missing_ok=True)
    except OutputError as e:
        text = str(e)
        for place, target in zip(places, targets, strict=True):
            text = text.replace(place.name, target.name)
        raise OutputError(text) from e
    except OSError as e:
        raise OutputError(f"{targets[0]}: cannot be written: {e.strerror}. Fix: check the directory.") from e
    finally:
        for place in places:
            _remove(place)


def _check(path: Path, overwrite: bool, marks: tuple[str, ...]) -> None:
    parent = path.absolute().parent
    if not parent.is_dir():
        raise OutputError(f"{path}: there is no directory {path.parent}. Fix: make it, or choose another.")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise OutputError(f"{path}: {path.parent} cannot be written to. Fix: choose another directory.")
    if os.path.lexists(path) and not overwrite:
        raise OutputError(f"{path}: exists already. Fix: choose another name, or give --overwrite.")
    if path.is_dir() and any(path.iterdir()) and not (marks and all((path / m).is_file() for m in marks)):
        raise OutputError(f"{path}: is a directory with other things in it. Fix: choose another name.")


def _take_the_place(place: Path, target: Path) -> None:
    if not target.is_dir():
        os.replace(place, target)
        return
    # A directory cannot be replaced in one step: aside, in, and only then away.
    aside = target.with_name(f".{secrets.token_hex(4)}.{target.name}")
    os.rename(target, aside)
    try:
        os.rename(place, target)
    except BaseException:
        os.rename(aside, target)
        raise
    _remove(aside)


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)
