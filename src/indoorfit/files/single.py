"""One file."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from indoorfit.errors import OutputError

from .place import os_errors_told, resolved, sibling


@contextmanager
def atomic_file(path: str | Path, *, overwrite: bool = True) -> Iterator[BinaryIO]:
    """A binary file that takes the place of `path` when the block ends without an error.

    Raises:
        OutputError: the target is a directory or a device, exists without `overwrite`, or cannot be written.
    """
    target = resolved(path)
    if target.is_dir():
        raise OutputError(f"{target}: is a directory; a file is to be written. Fix: name a file.")
    if target.exists() and not target.is_file():
        # A device: renaming a file over /dev/null would take it from every other program.
        raise OutputError(f"{target}: is no ordinary file. Fix: name a file.")
    if target.exists() and not overwrite:
        raise OutputError(f"{target}: exists already. Fix: choose another name, or allow overwriting.")
    temporary = sibling(target, "part")
    with os_errors_told(target):
        try:
            # Mode x: a name that someone else made in the meantime is never written to.
            with open(temporary, "xb") as file:
                yield file
            os.replace(temporary, target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise


def replace_file(path: str | Path, content: bytes) -> None:
    """Write a file that is complete in memory; one that is there already is replaced.

    Raises:
        OutputError: as `atomic_file`.
    """
    with atomic_file(path) as file:
        file.write(content)
