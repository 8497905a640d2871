"""Why a model that was written may yet not be sound, and which walls have two places."""

import numpy as np
from jaxtyping import Float

from indoorfit.measure import Survey
from indoorfit.model import Note

_NAMED = 5
"""More faces in a message are not read."""


def fit_doubts(
    closed: bool,
    converged: bool,
    swing_m: Float[np.ndarray, " planes"],
    std_m: Float[np.ndarray, " planes"],
    found: Survey,
) -> tuple[Note, ...]:
    """Notes on a model that is not closed or not converged (exit code 3), and on walls with two places.

    Args:
        closed: whether the solid of every room is.
        converged: whether the fit came to rest.
        swing_m: how far each plane's points call it away from where it was put, metres; 0 where they do not.
        std_m: standard uncertainty of each plane's offset, in which the swing is contained.
        found: the faces.
    """
    notes = []
    if not closed:
        message = "A room's solid is not closed or not in one piece; do not use its volume."
        notes.append(Note("NOT_CLOSED", message))
    if not converged:
        faces = _faces(swing_m, swing_m > 0.0, found)
        at = f": the points{_named(faces)} keep changing" if faces else ""
        notes.append(
            Note(
                "NOT_CONVERGED",
                f"The fit did not come to rest{at}. Fix: raise joint.max_rounds; or look at the plan there "
                "for a wall that is not there, and forbid it.",
                faces,
            )
        )
        return tuple(notes)
    # Where the swing is less than all other doubts together, the interval says it all.
    twofold = (swing_m > 0.0) & (2.0 * np.square(swing_m) > np.square(std_m))
    faces = _faces(swing_m, twofold, found)
    if faces:
        farthest_mm = 1e3 * swing_m[twofold].max()
        notes.append(
            Note(
                "TWO_PLACES",
                f"The points{_named(faces)} do not agree on one place, as where a wall was seen in two "
                f"layers: they call it to both sides of where it was put, by up to {farthest_mm:.0f} mm. "
                "Intervals reach over both. Fix: scan it again, or measure there by hand.",
                faces,
            )
        )
    return tuple(notes)


def put_back_notes(put_back: tuple[int, ...], found: Survey) -> tuple[Note, ...]:
    """One note naming the faces of planes that passed others in the fit and were put back.

    Args:
        put_back: the planes.
        found: the faces.
    """
    faces = tuple(face.id for face in found.faces if face.polygon.plane in put_back)
    if not faces:
        return ()
    return (
        Note(
            "STEP_UNRESOLVED",
            f"Narrower than the scan is good: the step{_named(faces)}. Its points lie beyond the wall that "
            "it steps back from or stands before, so it was put back to where it was first seen beside that "
            "wall, and counts as not observed. Fix: measure its depth by hand, or scan it more closely.",
            faces,
        ),
    )


def _faces(swing_m: Float[np.ndarray, " planes"], chosen: np.ndarray, found: Survey) -> tuple[str, ...]:
    """Ids of the faces of the chosen planes, the one with the greatest swing first."""
    order = [k for k in np.argsort(-swing_m, kind="stable").tolist() if chosen[k]]
    return tuple(face.id for k in order for face in found.faces if face.polygon.plane == k)


def _named(faces: tuple[str, ...]) -> str:
    return f" of {', '.join(faces[:_NAMED])}{' and others' if len(faces) > _NAMED else ''}"
