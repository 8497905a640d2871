"""Which face of a model is which of the truth, judged by where they lie and never by their names."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy.optimize import linear_sum_assignment

from .alignment import FlatFace
from .volumes import solid_iou

REACH_M = 0.15
"""A face is found when its plane is this near the true one: far more than any error of a fit of a sound
scan, and the smallest distance of parallel walls in the simulator's random rooms. An inferred face claims no
such accuracy: it may be off by two of its own standard uncertainties."""
MISPLACED_M = 1.0
"""A face that is further off than `REACH_M` but within this is the right wall in the wrong place."""
MIN_OVERLAP = 0.3
"""Shared over joint area, seen along the normal. Low, because a wall of 15 cm whose ends are 5 cm off shares
half of it; high enough that a wall and the neighbour that continues it after a step are never mixed up."""


@dataclass(frozen=True)
class Misplaced:
    """The right wall in the wrong place."""

    truth: str
    """Id of the true face."""
    model: str
    """Id of the model's."""
    distance_m: float
    """Model minus truth along the direction into the room."""


@dataclass(frozen=True)
class FaceMatch:
    """Every face of both models in exactly one of these."""

    pairs: dict[str, str]
    """Id of the model's face for every true face that was found."""
    misplaced: tuple[Misplaced, ...]
    missing: tuple[str, ...]
    """True faces without any counterpart."""
    extra: tuple[str, ...]
    """Faces of the model that do not exist."""


def match_faces(model: Sequence[FlatFace], truth: Sequence[FlatFace]) -> FaceMatch:
    """Pair faces one to one by direction, distance of the planes and overlap.

    Args:
        model: in the truth's Manhattan frame.
        truth: likewise.
    """
    overlap, distance_m = _relations(model, truth)
    near = _assign(np.where(np.abs(distance_m) <= _reaches_m(model), overlap, 0.0))
    rows = [i for i in range(len(truth)) if i not in {i for i, _ in near}]
    columns = [j for j in range(len(model)) if j not in {j for _, j in near}]
    rest = np.where(np.abs(distance_m) <= MISPLACED_M, overlap, 0.0)[np.ix_(rows, columns)]
    far = [(rows[i], columns[j]) for i, j in _assign(rest)]
    lost = set(rows) - {i for i, _ in far}
    invented = set(columns) - {j for _, j in far}
    return FaceMatch(
        {truth[i].face.id: model[j].face.id for i, j in near},
        tuple(Misplaced(truth[i].face.id, model[j].face.id, float(distance_m[i, j])) for i, j in far),
        tuple(truth[i].face.id for i in sorted(lost)),
        tuple(model[j].face.id for j in sorted(invented)),
    )


def _reaches_m(model: Sequence[FlatFace]) -> Float[np.ndarray, " model"]:
    claimed_m = [2.0 * f.face.offset_std_m if f.face.status == "inferred" else 0.0 for f in model]
    return np.clip(np.array(claimed_m), REACH_M, MISPLACED_M)


def _relations(
    model: Sequence[FlatFace], truth: Sequence[FlatFace]
) -> tuple[Float[np.ndarray, "truth model"], Float[np.ndarray, "truth model"]]:
    """Shared over joint area (0 for faces of different direction) and distance of the planes."""
    overlap, distance_m = np.zeros((len(truth), len(model))), np.full((len(truth), len(model)), np.inf)
    areas = [face.area_m2 for face in model]
    for i, true in enumerate(truth):
        own = true.area_m2
        for j, found in enumerate(model):
            if not true.same_way(found):
                continue
            both = true.overlap_m2(found)
            overlap[i, j] = both / (own + areas[j] - both)
            distance_m[i, j] = true.distance_m(found)
    return overlap, distance_m


def _assign(overlap: Float[np.ndarray, "truth model"]) -> list[tuple[int, int]]:
    """The one-to-one pairs of largest total overlap; those below `MIN_OVERLAP` stay single."""
    allowed = np.where(overlap >= MIN_OVERLAP, overlap, 0.0)
    rows, columns = linear_sum_assignment(-allowed)
    return [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if allowed[i, j] > 0.0]


@dataclass(frozen=True)
class RoomPair:
    """A true room and the room of the model that shares most of its volume."""

    truth: str
    model: str
    iou: float
    """Shared over joint volume."""


def match_rooms(
    model: dict[str, Bool[np.ndarray, "nx ny nz"]],
    truth: dict[str, Bool[np.ndarray, "nx ny nz"]],
    lines_m: tuple[Float[np.ndarray, " _"], ...],
) -> tuple[RoomPair, ...]:
    """Pair rooms one to one by shared volume; rooms that share none stay single.

    Args:
        model: cells of each room by its id.
        truth: likewise.
        lines_m: the grid of the cells.
    """
    names, true_names = list(model), list(truth)
    iou = np.array([[solid_iou(truth[t], model[m], lines_m) for m in names] for t in true_names])
    iou = iou.reshape(len(true_names), len(names))
    rows, columns = linear_sum_assignment(-iou)
    return tuple(
        RoomPair(true_names[i], names[j], float(iou[i, j]))
        for i, j in zip(rows, columns, strict=True)
        if iou[i, j] > 0.0
    )
