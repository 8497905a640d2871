"""Two models of one scan in one set of axes: the truth's Manhattan frame."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.optimize import linear_sum_assignment

from indoorfit.geometry import shared_area
from indoorfit.model import Face, FitResult, Shape

_SAME_M = 1e-9
"""Corners of a ring that agree to a nanometre are the same line; they went through a rotation and back."""


@dataclass(frozen=True)
class Alignment:
    """``p_truth = turn @ (p_model - pivot_model_m) + pivot_truth_m``, both Manhattan frames."""

    turn: Float[np.ndarray, "3 3"]
    """The signed permutation nearest to the rotation from the model's to the truth's frame. The rest of
    that rotation is left out, so that boxes stay boxes: at d from the pivot it moves a point by d times
    `angle_rad`, some millimetres in a room."""
    pivot_model_m: Float[np.ndarray, " 3"]
    pivot_truth_m: Float[np.ndarray, " 3"]
    """Middle of the true bounding box: the place from which the neglected rotation does least harm."""
    angle_rad: float
    """Angle of the neglected rotation; anything above a few degrees means that the axes were not found."""

    def points_m(self, points_m: Float[np.ndarray, "points 3"]) -> Float[np.ndarray, "points 3"]:
        """Points, from the model's to the truth's Manhattan frame."""
        return (points_m - self.pivot_model_m) @ self.turn.T + self.pivot_truth_m

    def boxes_m(self, boxes_m: Float[np.ndarray, "boxes 2 3"]) -> Float[np.ndarray, "boxes 2 3"]:
        """Low and high corners, from the model's to the truth's Manhattan frame."""
        return np.sort(self.points_m(boxes_m.reshape(-1, 3)).reshape(-1, 2, 3), axis=1)


def align(model: FitResult, truth: FitResult) -> Alignment:
    """Bring a model into the Manhattan frame of another one of the same scan."""
    rotation = truth.frame.R_manhattan_scan @ model.frame.R_manhattan_scan.T
    rows, columns = linear_sum_assignment(-np.abs(rotation))
    turn = np.zeros((3, 3))
    turn[rows, columns] = np.where(rotation[rows, columns] < 0.0, -1.0, 1.0)
    corners_m = np.concatenate([face.rings_m[0] for face in truth.faces])
    corners_m = truth.frame.to_manhattan(corners_m)
    pivot_truth_m = 0.5 * (corners_m.min(axis=0) + corners_m.max(axis=0))
    pivot_model_m = model.frame.to_manhattan(truth.frame.to_scan(pivot_truth_m))
    cosine = 0.5 * (np.trace(turn.T @ rotation) - 1.0)
    return Alignment(turn, pivot_model_m, pivot_truth_m, float(np.arccos(np.clip(cosine, -1.0, 1.0))))


@dataclass(frozen=True)
class FlatFace:
    """A face as a polygon, in the truth's Manhattan frame."""

    face: Face
    inward: Float[np.ndarray, " 3"]
    """Unit vector into the room."""
    rings_m: tuple[Float[np.ndarray, "_ 3"], ...]
    """The outer ring first, then holes."""

    @property
    def area_m2(self) -> float:
        """Area of the face."""
        return self.overlap_m2(self)

    def overlap_m2(self, other: "FlatFace") -> float:
        """Area that two faces share when seen along this one's normal; exact."""
        # One axis upright, or along x for floors; which does not matter.
        up = np.eye(3)[2] if abs(self.inward[2]) < 0.5 else np.eye(3)[0]
        basis = np.stack([np.cross(up, self.inward), up], axis=1)
        own, their = ([ring @ basis for ring in face.rings_m] for face in (self, other))
        return shared_area(own, their)

    def distance_m(self, other: "FlatFace") -> float:
        """How far the middle of another face lies before this one's plane, towards the room."""
        middles_m = [0.5 * (f.rings_m[0].min(axis=0) + f.rings_m[0].max(axis=0)) for f in (self, other)]
        return float((middles_m[1] - middles_m[0]) @ self.inward)

    def same_way(self, other: "FlatFace") -> bool:
        """Whether two faces look in one direction, up to what tells an oblique wall from the others."""
        return float(self.inward @ other.inward) > _SAME_WAY

    @property
    def cells_m(self) -> Float[np.ndarray, "cells 2 3"]:
        """Boxes that hold the face, low and high corner: flat, and exact, where it follows the axes.

        Along oblique sides they are strips of half a decimetre, which an oblique wall crosses diagonally.
        """
        return _boxes(self.rings_m, int(np.argmax(np.abs(self.inward))))


def flat_faces(result: FitResult, alignment: Alignment | None = None) -> tuple[FlatFace, ...]:
    """All faces of a model.

    Args:
        result: the model.
        alignment: from this model's frame to another one's; None to stay in its own.
    """
    faces = []
    for face in result.faces:
        rings_m = [result.frame.to_manhattan(ring) for ring in face.rings_m]
        inward = result.frame.R_manhattan_scan @ face.normal
        if alignment is not None:
            rings_m, inward = [alignment.points_m(ring) for ring in rings_m], alignment.turn @ inward
        faces.append(FlatFace(face, inward, tuple(rings_m)))
    return tuple(faces)


def _boxes(rings_m: Sequence[Float[np.ndarray, "_ 3"]], axis: int) -> Float[np.ndarray, "cells 2 3"]:
    """The cells of the rings' own grid that lie inside by the even-odd rule."""
    first, second = (a for a in range(3) if a != axis)
    cut = [_cut(ring) for ring in rings_m]
    corners = np.concatenate(cut)
    u, v = _lines(corners[:, first]), _lines(corners[:, second])
    u_mid, v_mid = 0.5 * (u[1:] + u[:-1]), 0.5 * (v[1:] + v[:-1])
    inside = np.zeros((len(u_mid), len(v_mid)), bool)
    for ring in rings_m:
        ends = np.roll(ring, -1, axis=0)
        for start, end in zip(ring, ends, strict=True):
            low, high = sorted((start[second], end[second]))
            # An edge along `first` straddles no row of cells, so only those that rise along `second` count.
            rise = end[second] - start[second]
            share = (v_mid - start[second]) / (rise if rise != 0.0 else 1.0)
            crossed = start[first] + share * (end[first] - start[first])
            inside ^= (v_mid > low) & (v_mid < high) & (u_mid[:, None] > crossed)
    i, j = np.nonzero(inside)
    cells = np.full((len(i), 2, 3), float(np.mean(corners[:, axis])))
    cells[:, 0, first], cells[:, 1, first] = u[i], u[i + 1]
    cells[:, 0, second], cells[:, 1, second] = v[j], v[j + 1]
    if np.ptp(corners[:, axis]) > _STRIP_M:
        # The wall itself is oblique: upright strips, each as thick as it is deep.
        at = np.array([np.interp(edge, *_foot(corners, first, axis)) for edge in cells[:, :, first].T]).T
        cells[:, :, axis] = np.sort(at, axis=1)
    return cells


_STRIP_M = 0.05
"""Width of the strips along an oblique side, as of the cells that are sampled."""
_SAME_WAY = float(np.cos(np.radians(8.0)))


def _cut(ring_m: Float[np.ndarray, "_ 3"]) -> Float[np.ndarray, "_ 3"]:
    """A ring with corners every few centimetres along its oblique sides."""
    pieces = []
    for start, end in zip(ring_m, np.roll(ring_m, -1, axis=0), strict=True):
        across = np.sort(np.abs(end - start))
        n = max(1, int(np.ceil(across[1] / _STRIP_M - 1e-9))) if across[1] > _SAME_M else 1
        pieces.append(start + np.arange(n)[:, None] / n * (end - start))
    return np.concatenate(pieces)


def _foot(
    corners: Float[np.ndarray, "n 3"], first: int, axis: int
) -> tuple[Float[np.ndarray, " m"], Float[np.ndarray, " m"]]:
    """An oblique wall as a line: its places along one axis, and along the other one."""
    along, index = np.unique(corners[:, first], return_index=True)
    return along, corners[index, axis]


def _lines(values: Float[np.ndarray, " n"]) -> Float[np.ndarray, " lines"]:
    ordered = np.sort(values)
    return ordered[np.append(True, np.diff(ordered) > _SAME_M)]


def boxes_of(shape: Shape, alignment: Alignment | None = None) -> dict[str, Float[np.ndarray, "2 3"]]:
    """Low and high corner of every cube, by id; those behind oblique walls are left out."""
    bounds = shape.squared.bounds_m()
    if alignment is None:
        return bounds
    return {name: alignment.boxes_m(box[None])[0] for name, box in bounds.items()}
