"""A fitted model against the exact one: which faces are which, and how far its lengths are off.

Faces are matched by where they lie, not by their names: both models are brought into the true Manhattan
frame through the scan's coordinates, so a model turned by 90 degrees about its vertical counts the same.
"""

from dataclasses import dataclass

import numpy as np
import trimesh
from jaxtyping import Float
from scipy.optimize import linear_sum_assignment

from indoorfit.model import Dimension, Face, FitResult, Frame

REACH_M = 0.15
"""A face counts as found when its plane and all its ends are within this of the true ones: far more than
any error of a length, far less than the smallest wall of the rooms."""

_FORBIDDEN = 1e6


@dataclass(frozen=True)
class Comparison:
    """What a judge of one room needs."""

    missing: tuple[str, ...]
    """Ids of true faces that were not found."""
    extra: tuple[str, ...]
    """Ids of fitted faces that do not exist."""
    lost: tuple[str, ...]
    """Ids of true dimensions for which the model has no number."""
    watertight: bool
    n_rooms: int
    errors_m: Float[np.ndarray, " dimensions"]
    """Fitted minus true, once for every pair of planes."""
    hits: Float[np.ndarray, " dimensions"]
    """1 where the interval holds the true length."""
    widths_m: Float[np.ndarray, " dimensions"]
    """High minus low end of the interval."""

    @property
    def right(self) -> bool:
        """Every face found, none invented, no dimension lost, one body."""
        return not (self.missing or self.extra or self.lost) and self.n_rooms == 1


def compare(truth: FitResult, result: FitResult) -> Comparison:
    """Compare two models of the same scan.

    Args:
        truth: exact.
        result: fitted.
    """
    pairs = _pairs(truth, result)
    errors, hits, widths, lost = _lengths(truth, result, pairs)
    return Comparison(
        missing=tuple(face.id for face in truth.faces if face.id not in pairs),
        extra=tuple(face.id for face in result.faces if face.id not in set(pairs.values())),
        lost=lost,
        watertight=bool(result.meshes) and all(_is_watertight(mesh) for mesh in result.meshes),
        n_rooms=len(result.rooms),
        errors_m=np.array(errors),
        hits=np.array(hits, float),
        widths_m=np.array(widths),
    )


def _pairs(truth: FitResult, result: FitResult) -> dict[str, str]:
    """Id of the fitted face for every true face that was found; the best of all assignments."""
    cost = np.array([[_distance(a, b, truth.frame) for b in result.faces] for a in truth.faces])
    if not cost.size:
        return {}
    rows, columns = linear_sum_assignment(cost)
    return {
        truth.faces[i].id: result.faces[j].id
        for i, j in zip(rows, columns, strict=True)
        if cost[i, j] < _FORBIDDEN
    }


def _distance(true: Face, found: Face, frame: Frame) -> float:
    """Largest difference of the two faces' bounds, metres; `_FORBIDDEN` for different faces."""
    normals = frame.R_manhattan_scan @ np.column_stack([true.normal, found.normal])
    if normals[:, 0] @ normals[:, 1] < 0.9:
        return _FORBIDDEN
    # Bounds only: the ring of a floor has as many corners as walls were found, right or wrong.
    difference = _bounds_m(true, frame) - _bounds_m(found, frame)
    reach = float(np.abs(difference).max())
    return reach if reach <= REACH_M else _FORBIDDEN


def _bounds_m(face: Face, frame: Frame) -> Float[np.ndarray, "2 3"]:
    corners = frame.to_manhattan(face.rings_m[0])
    return np.array([corners.min(axis=0), corners.max(axis=0)])


def _lengths(
    truth: FitResult, result: FitResult, pairs: dict[str, str]
) -> tuple[list[float], list[bool], list[float], tuple[str, ...]]:
    """Errors, hits and widths of the true dimensions, and those that have no fitted counterpart."""
    found = {_planes(result, dimension): dimension for dimension in result.dimensions}
    errors, hits, widths, lost, done = [], [], [], [], set()
    for dimension in truth.dimensions:
        planes = _planes(truth, dimension)
        if planes in done:
            continue
        done.add(planes)
        ends = [pairs.get(face) for face in dimension.faces]
        counterpart = None
        if None not in ends:
            counterpart = found.get(frozenset(result.face(str(end)).plane for end in ends))
        if counterpart is None:
            lost.append(dimension.id)
            continue
        quantity, true_m = counterpart.quantity, dimension.quantity.value
        errors.append(quantity.value - true_m)
        hits.append(quantity.interval.low <= true_m <= quantity.interval.high)
        widths.append(quantity.interval.high - quantity.interval.low)
    return errors, hits, widths, tuple(lost)


def _planes(result: FitResult, dimension: Dimension) -> frozenset[int]:
    return frozenset(result.face(face).plane for face in dimension.faces)


def _is_watertight(mesh) -> bool:
    # An independent look: the program's own verdict is what is being judged.
    body = trimesh.Trimesh(mesh.vertices_m, mesh.triangles, process=False)
    return bool(body.is_watertight and body.is_winding_consistent)
