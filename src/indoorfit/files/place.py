"""What all ways of writing share: temporary names, swaps and error texts."""

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from indoorfit.errors import OutputError


def resolved(path: str | Path) -> Path:
    """Absolute, links followed: what is replaced is the thing itself, and '.' gets a name.

    Raises:
        OutputError: there is no such path, e.g. a loop of links.
    """
    try:
        return Path(path).resolve()
    except (OSError, RuntimeError, ValueError) as e:
        raise OutputError(f"{path}: is no usable path: {e}. Fix: choose another place.") from e


def sibling(target: Path, kind: str) -> Path:
    """A name beside the target that nothing else has."""
    return target.with_name(f".{target.name[:100]}.{secrets.token_hex(4)}.{kind}")


def swap_in(new: Path, target: Path) -> Path | None:
    """Rename `new` to `target`.

    Returns:
        where the thing that was there before is now, or None where there was none.
    """
    if not os.path.lexists(target):
        os.rename(new, target)
        return None
    aside = sibling(target, "old")
    os.rename(target, aside)
    try:
        os.rename(new, target)
    except BaseException:
        os.rename(aside, target)
        raise
    return aside


def remove(path: Path) -> None:
    """Delete a file or a directory; that it is gone already is no error."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


@contextmanager
def os_errors_told(target: Path) -> Iterator[None]:
    """Turn an OSError of the block into an OutputError that names the target."""
    try:
        yield
    except OSError as e:
        reason = e.strerror or type(e).__name__
        raise OutputError(
            f"{target}: cannot be written: {reason}. Fix: check space, permissions and path."
        ) from e
