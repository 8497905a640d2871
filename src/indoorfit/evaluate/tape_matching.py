"""Which dimension of a model a reading is of."""

import math

import numpy as np
from jaxtyping import Float

from indoorfit.model import Dimension, Face, FitResult, TapeReading

REACH_M = 0.5
"""A point is given by eye or taken from a viewer: within half a metre of its face is near enough, for what
tells faces apart is which one is nearest."""
_CLEARLY = 0.5
"""The best match must be twice as near as the next one between other planes."""
_UNITS_M = (1.0, 0.01, 0.001, 0.3048, 0.0254)
_FACTOR = 10.0
_UNIT_LIKE = math.log(1.15)
"""Within 15 % of the ratio of two units: a wrong unit errs by 2.5 at least, no scan does."""


def find_dimension(result: FitResult, reading: TapeReading) -> Dimension | str:
    """The dimension that a reading is of, or why there is none, as a phrase that follows `line 7`."""
    if reading.dimension is not None:
        found = _by_id(result, reading)
    elif reading.faces is not None:
        found = _by_faces(result, reading.faces)
    else:
        assert reading.points_m is not None
        first, second = reading.points_m
        found = _by_points(result, np.array(first), np.array(second))
    if isinstance(found, Dimension) and _means_something_else(reading.value_m, found.quantity.value):
        return (
            f"reads {reading.value_m:g} m where the model has {found.quantity.value:.3f} m for {found.id}: "
            "a wrong unit or another length"
        )
    return found


def _by_id(result: FitResult, reading: TapeReading) -> Dimension | str:
    found = next((d for d in result.dimensions if d.id == reading.dimension), None)
    if found is None:
        return f"names the dimension {str(reading.dimension)[:40]!r}, which the model does not have"
    if reading.faces is not None and set(reading.faces) != set(found.faces):
        return (
            f"names the dimension {found.id} and the faces {' and '.join(reading.faces)[:80]}, but "
            f"{found.id} lies between {' and '.join(found.faces)}: the table may be of another fit"
        )
    return found


def _by_faces(result: FitResult, faces: tuple[str, str]) -> Dimension | str:
    known = {face.id: face.plane for face in result.faces}
    for name in faces:
        if name not in known:
            return f"names the face {name[:40]!r}, which the model does not have"
    exact = next((d for d in result.dimensions if set(d.faces) == set(faces)), None)
    if exact is not None:
        return exact
    # Faces in one plane are as far from the third as each other.
    planes = {known[name] for name in faces}
    same = next((d for d in result.dimensions if {known[name] for name in d.faces} == planes), None)
    return same or f"asks for the length between {faces[0]} and {faces[1]}; the model has none between them"


def _by_points(
    result: FitResult, first_m: Float[np.ndarray, " 3"], second_m: Float[np.ndarray, " 3"]
) -> Dimension | str:
    """The dimension whose two faces lie nearest to the two points, the farther of them counting."""
    nearness = {
        face.id: (distance_to_face(face, first_m), distance_to_face(face, second_m)) for face in result.faces
    }
    ranked = []
    for dimension in result.dimensions:
        (a1, a2), (b1, b2) = (nearness[face] for face in dimension.faces)
        ranked.append((min(max(a1, b2), max(a2, b1)), dimension))
    ranked.sort(key=lambda entry: entry[0])
    if not ranked or ranked[0][0] > REACH_M:
        away = f"{ranked[0][0]:.2f} m away" if ranked else "missing"
        return (
            f"has points that lie on no two faces of a dimension (the nearest are {away}, needed {REACH_M} m)"
        )
    distance_m, best = ranked[0]
    planes = result.decided_by(best)
    other = next((entry for entry in ranked if result.decided_by(entry[1]) != planes), None)
    if other is not None and distance_m > max(_CLEARLY * other[0], 1e-9):
        return (
            f"has points that may mean {best.id} or {other[1].id}. Fix: give points nearer to the two "
            "faces, or the dimension"
        )
    return best


def distance_to_face(face: Face, point_m: Float[np.ndarray, " 3"]) -> float:
    """Distance of a point from a face with its holes filled, metres, scan frame."""
    outer = np.asarray(face.rings_m[0])
    normal = np.asarray(face.normal)
    across = float((point_m - outer[0]) @ normal)
    u = outer[1] - outer[0]
    u = u / np.linalg.norm(u)
    basis = np.stack([u, np.cross(normal, u)])
    ring, at = (outer - outer[0]) @ basis.T, basis @ (point_m - outer[0])
    return math.hypot(across, 0.0 if _inside(ring, at) else _to_ring(ring, at))


def _inside(ring: Float[np.ndarray, "corners 2"], at: Float[np.ndarray, " 2"]) -> bool:
    """Even-odd rule."""
    start, end = ring, np.roll(ring, -1, axis=0)
    straddles = (start[:, 1] > at[1]) != (end[:, 1] > at[1])
    rise = np.where(straddles, end[:, 1] - start[:, 1], 1.0)
    x = start[:, 0] + (at[1] - start[:, 1]) / rise * (end[:, 0] - start[:, 0])
    return bool(np.count_nonzero(straddles & (x > at[0])) % 2)


def _to_ring(ring: Float[np.ndarray, "corners 2"], at: Float[np.ndarray, " 2"]) -> float:
    edge = np.roll(ring, -1, axis=0) - ring
    squared = np.maximum(np.sum(edge**2, axis=1), 1e-18)
    along = np.clip(np.sum((at - ring) * edge, axis=1) / squared, 0.0, 1.0)
    return float(np.min(np.linalg.norm(ring + along[:, None] * edge - at, axis=1)))


def _means_something_else(reading_m: float, model_m: float) -> bool:
    """Whether the two differ as units do, or by more than any fit that found the right two faces can err."""
    if model_m <= 0.0:
        return False
    ratio = math.log(reading_m / model_m)
    if abs(ratio) > math.log(_FACTOR):
        return True
    wrong = (math.log(a / b) for a in _UNITS_M for b in _UNITS_M if a != b)
    return any(abs(ratio - unit) < _UNIT_LIKE for unit in wrong)
