"""Two models of one scan in one set of axes: the truth's Manhattan frame."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.optimize import linear_sum_assignment

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

    def boxes_m(self, boxes_m: Float[np.ndarray, "boxes 2 3"]) -> Float[np.ndarray, "boxes 2 3"]:
        """Low and high corners, from the model's to the truth's Manhattan frame."""
        turned = (boxes_m - self.pivot_model_m) @ self.turn.T + self.pivot_truth_m
        return np.sort(turned, axis=1)


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
    """A face as rectangles that do not overlap, in the truth's Manhattan frame."""

    face: Face
    axis: int
    """The axis that the face is perpendicular to."""
    inward: int
    """+1 or -1: the direction along `axis` that leads into the room."""
    cells_m: Float[np.ndarray, "cells 2 3"]
    """Low and high corners; flat along `axis`."""

    @property
    def offset_m(self) -> float:
        """Where the plane cuts `axis`."""
        return float(self.cells_m[0, 0, self.axis])

    @property
    def area_m2(self) -> float:
        """Area of the face."""
        return self.overlap_m2(self)

    def overlap_m2(self, other: "FlatFace") -> float:
        """Area that two faces of one axis share when seen along it; exact."""
        across = [axis for axis in range(3) if axis != self.axis]
        own, their = self.cells_m[:, None, :, across], other.cells_m[None, :, :, across]
        low = np.maximum(own[:, :, 0], their[:, :, 0])
        high = np.minimum(own[:, :, 1], their[:, :, 1])
        return float(np.prod(np.maximum(high - low, 0.0), axis=-1).sum())


def flat_faces(result: FitResult, alignment: Alignment | None = None) -> tuple[FlatFace, ...]:
    """All faces of a model as rectangles.

    Args:
        result: its rings must follow its own Manhattan axes, as those of every fit and every truth do.
        alignment: from this model's frame to another one's; None to stay in its own.
    """
    faces = []
    for face in result.faces:
        rings_m = [result.frame.to_manhattan(ring) for ring in face.rings_m]
        inward = result.frame.R_manhattan_scan @ face.normal
        axis = int(np.argmax(np.abs(inward)))
        cells_m = _rectangles(rings_m, axis)
        if alignment is not None:
            cells_m, inward = alignment.boxes_m(cells_m), alignment.turn @ inward
            axis = int(np.argmax(np.abs(inward)))
        faces.append(FlatFace(face, axis, 1 if inward[axis] > 0.0 else -1, cells_m))
    return tuple(faces)


def _rectangles(rings_m: list[Float[np.ndarray, "_ 3"]], axis: int) -> Float[np.ndarray, "cells 2 3"]:
    """The cells of the rings' own grid that lie inside by the even-odd rule."""
    first, second = (a for a in range(3) if a != axis)
    corners = np.concatenate(rings_m)
    u, v = _lines(corners[:, first]), _lines(corners[:, second])
    u_mid, v_mid = 0.5 * (u[1:] + u[:-1]), 0.5 * (v[1:] + v[:-1])
    inside = np.zeros((len(u_mid), len(v_mid)), bool)
    for ring in rings_m:
        ends = np.roll(ring, -1, axis=0)
        for start, end in zip(ring, ends, strict=True):
            low, high = sorted((start[second], end[second]))
            # An edge along `first` straddles no row of cells, so only edges along `second` count.
            inside ^= (v_mid > low) & (v_mid < high) & (u_mid[:, None] > start[first])
    i, j = np.nonzero(inside)
    cells = np.full((len(i), 2, 3), float(np.mean(corners[:, axis])))
    cells[:, 0, first], cells[:, 1, first] = u[i], u[i + 1]
    cells[:, 0, second], cells[:, 1, second] = v[j], v[j + 1]
    return cells


def _lines(values: Float[np.ndarray, " n"]) -> Float[np.ndarray, " lines"]:
    ordered = np.sort(values)
    return ordered[np.append(True, np.diff(ordered) > _SAME_M)]


def boxes_of(shape: Shape, alignment: Alignment | None = None) -> dict[str, Float[np.ndarray, "2 3"]]:
    """Low and high corner of every cube, by id."""
    bounds = shape.bounds_m()
    if alignment is None:
        return bounds
    return {name: alignment.boxes_m(box[None])[0] for name, box in bounds.items()}
