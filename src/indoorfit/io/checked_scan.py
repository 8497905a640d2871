"""What a cloud of any source must satisfy before it is a `Scan`."""

from dataclasses import replace
from typing import get_args

import numpy as np
from jaxtyping import Bool, Float

from ..errors import InputError
from ..model import Note, Scan, SensorFrame
from .raw import RawCloud
from .units import Unit, implausible_unit_note, metres_per_unit

MIN_POINTS = 9
"""A box has nine unknowns (rotation and six planes); each point settles at most one."""

MAX_COORDINATE_M = 1e8
"""National grids (with zone numbers) and geocentric coordinates stay below 4e7 m, so more is a wrong
unit or damage. Up to here float64 steps by at most 1.5e-8 m: digits enough for a tenth of a millimetre
after the centroid is taken off; at 1e9 m and beyond the margin for the arithmetic is gone."""

MAX_FAR_SHARE = 0.01
"""So many points beyond `MAX_COORDINATE_M` are dropped as a sensor's errors; more are a wrong unit."""

COARSE_STEP_M = 1e-4
"""Steps of 32-bit coordinates above this are worth a note: a tenth of a millimetre."""


def checked_scan(raw: RawCloud, name: str, unit: Unit) -> Scan:
    """The cloud in metres, without the points that are no points, and with notes about what was found.

    Args:
        raw: file units; its points are converted in place.
        name: of the source, for messages.
        unit: of the coordinates.

    Raises:
        InputError: too few points, none finite, or coordinates beyond `MAX_COORDINATE_M`.
    """
    if unit != "m":
        np.multiply(raw.points, metres_per_unit(unit), out=raw.points)
    raw = _without_invalid(raw, name, unit)
    n_points = len(raw.points)
    if n_points < MIN_POINTS:
        dropped = " ".join(note.message for note in raw.notes if note.code == "POINTS_DROPPED")
        raise InputError(
            f"{name}: found {n_points} points; at least {MIN_POINTS} are needed for a box, and thousands "
            f"for a room. {dropped}{' ' if dropped else ''}Fix: check that the file holds the scan's points."
        )
    notes = list(raw.notes)
    if raw.colours is None:
        notes.append(Note("COLOURS_MISSING", f"{name} has no colours; surfaces will be grey."))
    if raw.single_precision:
        notes.extend(_coarse_notes(raw.points / metres_per_unit(unit), name, unit))
    implausible = implausible_unit_note(raw.points, unit)
    if implausible is not None:
        notes.append(implausible)
    return Scan(raw.points, raw.colours, raw.frame_ids, name=name, notes=tuple(notes), unit=unit)


def _without_invalid(raw: RawCloud, name: str, unit: Unit) -> RawCloud:
    points_m = raw.points
    # A NaN makes both extremes NaN, which no comparison passes: the common case costs no mask.
    if len(points_m) == 0 or (points_m.max() <= MAX_COORDINATE_M and points_m.min() >= -MAX_COORDINATE_M):
        return raw
    finite = np.isfinite(points_m).all(axis=1)
    n_finite = int(finite.sum())
    if n_finite == 0:
        raise InputError(
            f"{name}: none of the {len(points_m)} points has finite coordinates (all are NaN or infinite). "
            "Fix: export the scan again."
        )
    with np.errstate(invalid="ignore"):
        # A NaN compares as false, an infinity is beyond: what is near is also finite.
        kept = np.all(np.abs(points_m) <= MAX_COORDINATE_M, axis=1)
    n_far = n_finite - int(kept.sum())
    if n_far > MAX_FAR_SHARE * n_finite:
        largest_m = np.abs(points_m[finite]).max()
        raise InputError(
            f"{name}: {n_far} of {n_finite} points have coordinates beyond {MAX_COORDINATE_M:g} m (largest "
            f"{largest_m:.3g} m, read as {unit}); no map reaches so far. Fix: give the file's unit with "
            f"--unit ({', '.join(get_args(Unit))}), or subtract an offset."
        )
    return _keep(raw, np.asarray(kept), len(points_m) - n_finite, n_far)


def _keep(raw: RawCloud, kept: Bool[np.ndarray, " points"], n_bad: int, n_far: int) -> RawCloud:
    far = f" and {n_far} beyond {MAX_COORDINATE_M:g} m" if n_far else ""
    text = f"Dropped {n_bad} of {len(kept)} points with NaN or infinite coordinates{far}."
    return replace(
        raw,
        points=raw.points[kept],
        colours=None if raw.colours is None else raw.colours[kept],
        frame_ids=None if raw.frame_ids is None else raw.frame_ids[kept],
        notes=(*raw.notes, Note("POINTS_DROPPED", text)),
    )


def _coarse_notes(points: Float[np.ndarray, "points 3"], name: str, unit: Unit) -> list[Note]:
    """A note if 32-bit coordinates (file units) are so far out that they have lost digits."""
    largest = np.abs(points).max()
    step_m = float(np.spacing(np.float32(largest))) * metres_per_unit(unit)
    if step_m <= COARSE_STEP_M:
        return []
    text = (
        f"{name} stores coordinates up to {largest:.6g} {unit} as 32-bit floats, which there lie "
        f"{step_m * 1000:.2g} mm apart: digits are lost. Fix: export as double, or with an offset taken off."
    )
    return [Note("COORDINATES_COARSE", text)]


def frame_notes(scan: Scan, frames: tuple[SensorFrame, ...]) -> tuple[Note, ...]:
    """A note where points belong to frames that the sidecar does not list."""
    if scan.frame_ids is None or not frames:
        return ()
    unknown = np.setdiff1d(scan.frame_ids, [frame.id for frame in frames])
    if len(unknown) == 0:
        return ()
    n_points = int(np.isin(scan.frame_ids, unknown).sum())
    text = (
        f"{n_points} points are of {len(unknown)} frames without a pose in the sidecar (first: {unknown[0]})."
    )
    return (Note("FRAMES_UNKNOWN", text),)
