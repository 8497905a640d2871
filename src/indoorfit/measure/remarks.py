"""What a reader of the dimensions must know about the faces behind them."""

from collections.abc import Collection

from indoorfit.model import Note, Shape

from .named import NamedFace, Survey


def face_notes(shape: Shape, found: Survey, put_back: Collection[int]) -> tuple[Note, ...]:
    """One note naming the faces that nobody saw.

    Args:
        shape: that was surveyed.
        found: its survey.
        put_back: planes that count as not observed for another reason, which a note of its own tells.
    """
    unseen = [face for face in found.faces if face.status == "inferred"]
    inferred = [face for face in unseen if face.polygon.plane not in put_back]
    if not inferred:
        return ()
    names = ", ".join(face.id for face in inferred)
    guessed = [face for face in inferred if shape.planes[face.polygon.plane].doubt_m > 0.0]
    return (
        Note(
            "FACE_INFERRED",
            f"Not observed: {names}. Each is placed where the surfaces around it end"
            f"{_guesses(shape, guessed)}{_in_line(found)}, and dimensions that rest on it are "
            "marked inferred; scan it, or measure it by hand, to be sure.",
            tuple(face.id for face in inferred),
        ),
    )


def _guesses(shape: Shape, guessed: list[NamedFace]) -> str:
    """Of the faces that stand in a shadow, how far they may be from where they are put."""
    if not guessed:
        return ""
    told = [f"{face.id} by {2.0 * shape.planes[face.polygon.plane].doubt_m:.2f} m" for face in guessed]
    return f", or in the middle of the shadow that hides it (it may be off: {', '.join(told)})"


def _in_line(found: Survey) -> str:
    """Of the faces whose plane was seen elsewhere, what they are taken to be in line with."""
    told = []
    for face in found.faces:
        plane = face.polygon.plane
        seen = [f.id for f in found.faces if f.polygon.plane == plane and f.status == "observed"]
        if face.status == "inferred" and seen:
            told.append(f"{face.id} with {seen[0]}")
    if not told:
        return ""
    return f", or taken to be in line with what was seen ({', '.join(told)}; intervals hold if it is)"
