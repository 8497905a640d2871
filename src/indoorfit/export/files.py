"""Files appear whole or not at all."""

import os
from pathlib import Path

from indoorfit.errors import OutputError


def replace_file(path: Path, content: bytes) -> None:
    """Write a file beside its target and move it there in one step.

    Args:
        path: the target; a file that is there already is replaced.
        content: everything that it shall hold.

    Raises:
        OutputError: the folder is missing, full or not writable. Nothing is left behind.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        temporary.write_bytes(content)
        os.replace(temporary, path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise OutputError(
            f"{path.name}: cannot be written ({error.strerror}); a writable folder with free space is "
            "needed. Fix: choose another folder with --out."
        ) from error
