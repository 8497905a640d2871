"""A remark for the user that travels with the data."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Note:
    """One warning of the output contract: a stable code for machines, a sentence for people."""

    code: str
    """Upper case with underscores, e.g. ``WALL_INFERRED``."""
    message: str
    """What was found, with numbers and units, and what to do about it."""
    faces: tuple[str, ...] = ()
    """Ids of the faces that it is about, for the plan to point them out; empty where it is about none."""
