"""Several files and directories that appear together or not at all."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from indoorfit.errors import OutputError

from .place import os_errors_told, remove, sibling, swap_in


@contextmanager
def staged(
    targets: Sequence[Path],
    *,
    overwrite: bool,
    marks: tuple[str, ...] = (),
    stale: Sequence[Path] = (),
    folders: bool = False,
) -> Iterator[list[Path]]:
    """Places to write to, which take the targets' names when the block ends without an error.

    A writer may put further files beside its place (the materials of an OBJ, a folder of images): they go
    to the same place beside the target, under the same rule of overwriting.

    Args:
        targets: files, or directories to be filled.
        overwrite: whether existing targets may be replaced.
        marks: files that a directory must hold to be replaced, so that none of someone else's ever is.
        stale: files that would contradict the new ones; removed with `overwrite`, refused without.
        folders: the targets are directories, so that a file in the place of one is told at once. A file is
            never replaced by a directory, nor a directory by a file.

    Yields:
        for each target a path of the same name in a temporary folder beside it.

    Raises:
        OutputError: a target exists, has no writable directory to lie in, or comes twice.
    """
    for path in (*targets, *stale):
        check_staged(path, overwrite=overwrite, marks=marks, folder=folders)
    if len({path.resolve() for path in targets}) < len(targets):
        raise OutputError(
            f"{targets[0].name}: two outputs have the same name. Fix: give each a name of its own."
        )
    stages = {path.absolute().parent: sibling(path.absolute(), "part") for path in targets}
    with os_errors_told(targets[0]):
        try:
            for stage in stages.values():
                stage.mkdir()
            yield [stages[path.absolute().parent] / path.name for path in targets]
            _move_in(stages, targets, overwrite)
            for path in stale:
                path.unlink(missing_ok=True)
        except OutputError as e:
            raise OutputError(_without(stages, str(e))) from e
        finally:
            for stage in stages.values():
                remove(stage)


def check_staged(path: Path, *, overwrite: bool, marks: tuple[str, ...] = (), folder: bool = False) -> None:
    """Raise now what `staged` would raise for a target, so that no long run ends in it.

    Raises:
        OutputError: as `staged`.
    """
    parent = path.absolute().parent
    if not parent.is_dir():
        raise OutputError(f"{path}: there is no directory {path.parent}. Fix: make it, or choose another.")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise OutputError(f"{path}: {path.parent} cannot be written to. Fix: choose another directory.")
    if os.path.lexists(path) and not overwrite:
        raise OutputError(f"{path}: exists already. Fix: choose another name, or give --overwrite.")
    if folder and os.path.lexists(path) and not path.is_dir():
        raise OutputError(_NO_DIRECTORY.format(path))
    if path.exists() and not path.is_dir() and not path.is_file():
        raise OutputError(f"{path}: is no ordinary file. Fix: name a file.")
    with os_errors_told(path):
        others = path.is_dir() and any(path.iterdir())
        if others and not (marks and all((path / mark).is_file() for mark in marks)):
            raise OutputError(f"{path}: is a directory with other things in it. Fix: choose another name.")


_NO_DIRECTORY = "{}: is no directory, and one is to be written. Fix: choose another name."


def _move_in(folders: dict[Path, Path], targets: Sequence[Path], overwrite: bool) -> None:
    """Put all that was written in place; after an error everything is as it was."""
    wanted = {path.absolute() for path in targets}
    moves = [
        (place, parent / place.relative_to(folder))
        for parent, folder in folders.items()
        for place in _pieces(folder, {folder / path.name for path in wanted if path.parent == parent})
    ]
    for place, target in moves:
        if place.is_dir() and os.path.lexists(target) and not target.is_dir():
            raise OutputError(_NO_DIRECTORY.format(target))
        if target not in wanted and os.path.lexists(target) and (not overwrite or target.is_dir()):
            raise OutputError(f"{target}: exists already. Fix: choose another name, or give --overwrite.")
    done: list[tuple[Path, Path, Path | None]] = []
    try:
        for place, target in moves:
            target.parent.mkdir(exist_ok=True, parents=True)
            done.append((place, target, swap_in(place, target)))
    except BaseException:
        for place, target, aside in reversed(done):
            os.rename(target, place)
            if aside is not None:
                os.rename(aside, target)
        raise
    for _, _, aside in done:
        if aside is not None:
            remove(aside)


def _pieces(folder: Path, wholes: set[Path]) -> Iterator[Path]:
    """What is moved in one step: targets as they are, everything else file by file."""
    for path in sorted(folder.iterdir()):
        if path in wholes or not path.is_dir():
            yield path
        else:
            yield from _pieces(path, wholes)


def _without(folders: dict[Path, Path], text: str) -> str:
    """A message as if the work had been done in place."""
    for folder in folders.values():
        text = text.replace(f"{folder.name}{os.sep}", "")
    return text
