"""The verdict on one model whose truth is known."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from indoorfit.model import FitResult, PlaneStatus, RoomMesh, Shape

from .alignment import align, boxes_of, flat_faces
from .lengths import LengthCheck, check_lengths
from .matching import Misplaced, RoomPair, match_faces, match_rooms
from .volumes import common_grid, footprint_iou, occupied, solid_iou

MAX_TURN_RAD = np.radians(2.0)
"""Axes that are further off than this are not those of the room: at 5 m it is 17 cm."""


@dataclass(frozen=True)
class StatusCheck:
    """Whether a face says rightly that it was seen."""

    truth: str
    """Id of the true face."""
    model: str
    expected: PlaneStatus
    found: PlaneStatus


@dataclass(frozen=True)
class Comparison:
    """What a judge of one room needs."""

    missing: tuple[str, ...]
    """Ids of true faces that the model lacks."""
    extra: tuple[str, ...]
    """Ids of the model's faces that do not exist."""
    misplaced: tuple[Misplaced, ...]
    """Faces that exist but lie somewhere else."""
    pairs: Mapping[str, str]
    """The model's face for every true face that was found."""
    rooms: tuple[RoomPair, ...]
    n_rooms: tuple[int, int]
    """Rooms of the model and of the truth."""
    lengths: tuple[LengthCheck, ...]
    """Each true length that the model has a number for, once for each pair of planes."""
    lost: tuple[str, ...]
    """Ids of true lengths without a number in the model."""
    statuses: tuple[StatusCheck, ...]
    """Of the faces that were found and of which it is known whether they were seen."""
    unseen: Mapping[str, str]
    """True faces that the scan does not show, or hardly, with that in words."""
    footprint_iou: float
    solid_iou: float
    """Over all rooms together; boxes turned by `turn_rad` are taken as parallel, and corners that oblique
    walls cut off as square."""
    turn_rad: float
    """Angle between the axes of the two models, right angles left out."""
    watertight: bool
    """Every mesh of the model is closed, by an independent count of its edges."""

    @property
    def right(self) -> bool:
        """Whether the structure is right; lengths do not count, unless a face is out of reach."""
        return not self.faults

    @property
    def faults(self) -> tuple[str, ...]:
        """What is wrong with the structure, in words that name the faces."""
        said = []
        if self.turn_rad > MAX_TURN_RAD:
            said.append(f"axes {np.degrees(self.turn_rad):.1f} degrees off")
        if self.n_rooms[0] != self.n_rooms[1]:
            said.append(f"{self.n_rooms[0]} room(s) instead of {self.n_rooms[1]}")
        if not self.watertight:
            said.append("not watertight")
        said += [f"missing {name}{self._excuse(name)}" for name in self.missing]
        said += [f"extra {name}" for name in self.extra]
        said += [
            f"{item.truth} {item.distance_m:+.2f} m off as {item.model}{self._excuse(item.truth)}"
            for item in self.misplaced
        ]
        return tuple(said)

    def _excuse(self, face: str) -> str:
        return f" ({self.unseen[face]})" if face in self.unseen else ""


def compare(model: FitResult, truth: FitResult, seen: Mapping[str, bool] | None = None) -> Comparison:
    """Compare two models of the same scan, in the truth's Manhattan frame.

    Args:
        model: what was found.
        truth: exact.
        seen: for faces of the truth, whether the scan has points on them. Faces that are left
            out are in doubt and their status is not judged; None judges none.
    """
    alignment = align(model, truth)
    matched = match_faces(flat_faces(model, alignment), flat_faces(truth))
    # A wall in the wrong place has lengths that somebody will read, so they count as they are.
    off = {item.truth: item.model for item in matched.misplaced}
    lengths, lost = check_lengths(model, truth, {**off, **matched.pairs})
    boxes, true_boxes = boxes_of(model.shape, alignment), boxes_of(truth.shape)
    lines_m = common_grid(boxes, true_boxes)
    cells = {
        room.id: occupied(model.shape.squared, _cube(model.shape, room.cube), boxes, lines_m)
        for room in model.rooms
    }
    true_cells = {
        room.id: occupied(truth.shape.squared, _cube(truth.shape, room.cube), true_boxes, lines_m)
        for room in truth.rooms
    }
    whole, true_whole = (np.logical_or.reduce(list(part.values())) for part in (cells, true_cells))
    return Comparison(
        missing=matched.missing,
        extra=matched.extra,
        misplaced=matched.misplaced,
        pairs=matched.pairs,
        rooms=match_rooms(cells, true_cells, lines_m),
        n_rooms=(len(model.rooms), len(truth.rooms)),
        lengths=lengths,
        lost=lost,
        statuses=_statuses(model, truth, matched.pairs, seen or {}),
        unseen={} if seen is None else _unseen(truth, seen),
        footprint_iou=footprint_iou(whole, true_whole, lines_m),
        solid_iou=solid_iou(whole, true_whole, lines_m),
        turn_rad=alignment.angle_rad,
        watertight=bool(model.meshes) and all(_is_closed(mesh) for mesh in model.meshes),
    )


def _cube(shape: Shape, cube_id: str):
    return next(cube for cube in shape.cubes if cube.id == cube_id)


def _statuses(
    model: FitResult, truth: FitResult, pairs: Mapping[str, str], seen: Mapping[str, bool]
) -> tuple[StatusCheck, ...]:
    checks = []
    for face in truth.faces:
        if face.id in pairs and face.id in seen:
            expected: PlaneStatus = "observed" if seen[face.id] else "inferred"
            found = model.face(pairs[face.id])
            checks.append(StatusCheck(face.id, found.id, expected, found.status))
    return tuple(checks)


def _unseen(truth: FitResult, seen: Mapping[str, bool]) -> dict[str, str]:
    words = {None: "hardly seen", False: "not seen"}
    return {face.id: words[seen.get(face.id)] for face in truth.faces if seen.get(face.id) is not True}


def _is_closed(mesh: RoomMesh) -> bool:
    """Every edge is walked once in each direction: closed, and all triangles face the same way."""
    triangles = np.asarray(mesh.triangles)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    forward, counts = np.unique(edges, axis=0, return_counts=True)
    backward = np.unique(edges[:, ::-1], axis=0)
    return len(edges) > 0 and bool((counts == 1).all()) and np.array_equal(forward, backward)
