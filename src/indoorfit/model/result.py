"""What a fit says, in the terms of the output contract ``indoorfit.model/1``."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from jaxtyping import Float

from .grammar import FaceClass, PlaneStatus, Shape, Side
from .notes import Note
from .registration import FrameMotion
from .spread import Prediction
from .tape import TapeVerdict
from .texture import TextureSet

Method = Literal["joint", "greedy", "truth"]
"""How the numbers came about; `truth` marks the exact model of a simulated scan."""

FaceKind = Literal["wall", "floor", "ceiling", "step"]
"""A `step` is an upright face between two levels: the side of a beam, a platform or a lowered ceiling."""

DimensionKind = Literal["wall", "height", "overall", "step", "width", "thickness"]
"""`wall`: the clear length of a wall; `overall`: the extents of a room; `height`: from a floor to the ceiling
above it, the main levels first; `step`: from the main level of floor or ceiling to another; `width`: the
extents of a floor or ceiling at another level; `thickness`: of a wall between two rooms."""

LoaClass = Literal["LOA10", "LOA20", "LOA30", "LOA40", "LOA50"]
"""Level of Accuracy (USIBD C120): LOA10 is the coarsest, LOA50 the finest."""

DoorEvidence = Literal["holes", "floor", "reveal", "truth"]
"""`holes`: both faces of the wall lack points at the same place. `floor`: floor lies between the faces.
`reveal`: jambs or a lintel lie between them. `truth`: the scene was built with it."""


@dataclass(frozen=True)
class Frame:
    """The pose of the Manhattan frame: ``p_manhattan = R_manhattan_scan @ (p_scan - origin_scan_m)``."""

    R_manhattan_scan: Float[np.ndarray, "3 3"]
    origin_scan_m: Float[np.ndarray, " 3"]

    def to_scan(self, points_m: Float[np.ndarray, "... 3"]) -> Float[np.ndarray, "... 3"]:
        """Points from the Manhattan frame to the scan frame, metres."""
        return points_m @ self.R_manhattan_scan + self.origin_scan_m

    def to_manhattan(self, points_m: Float[np.ndarray, "... 3"]) -> Float[np.ndarray, "... 3"]:
        """Points from the scan frame to the Manhattan frame, metres."""
        return (points_m - self.origin_scan_m) @ self.R_manhattan_scan.T

    def directions_to_scan(self, vectors: Float[np.ndarray, "... 3"]) -> Float[np.ndarray, "... 3"]:
        """Directions from the Manhattan frame to the scan frame."""
        return vectors @ self.R_manhattan_scan


@dataclass(frozen=True)
class Interval:
    """A two-sided confidence interval."""

    level: float
    """Nominal coverage, 0 to 1."""
    low: float
    high: float


@dataclass(frozen=True)
class Budget:
    """What a standard uncertainty is made of (JCGM 100, 5.1), in the unit of its quantity."""

    data_std: float
    """Seen in the residuals of the scan (Type A)."""
    scale_std: float
    """From a possible error of the scan's scale (Type B)."""
    definition_std: float
    """From what the wall is taken to be (Type B)."""
    effective_dof: float
    """Degrees of freedom of the combined standard uncertainty (JCGM 100, G.4); may be infinite."""


@dataclass(frozen=True)
class Quantity:
    """A value with its standard uncertainty and interval, all in the same unit (m, m² or m³)."""

    value: float
    std: float
    """Combined standard uncertainty u_c."""
    interval: Interval
    """At the level that was asked for."""
    budget: Budget | None = None
    """Where `std` comes from; None where nothing is known of that."""
    intervals: tuple[Interval, ...] = ()
    """The same at the standard levels of 50, 80, 90, 95 and 99 %."""

    @property
    def coverage_factor(self) -> float | None:
        """k: half the width of the interval over the standard uncertainty; None for an exact value."""
        if self.std == 0.0:
            return None
        return (self.interval.high - self.interval.low) / (2.0 * self.std)


@dataclass(frozen=True)
class Face:
    """One flat polygon of the model."""

    id: str
    """``wall-1``, ``floor-1``, ``ceiling-1``, ... stable for the same scan and settings."""
    kind: FaceKind
    face_class: FaceClass
    room: str
    cube: str
    """The cube whose side this face is."""
    side: Side
    """That side of the cube."""
    plane: int
    """Index of the face's plane in the shape."""
    normal: Float[np.ndarray, " 3"]
    """Scan frame, unit length, into the room."""
    rings_m: tuple[Float[np.ndarray, "_ 3"], ...]
    """Scan frame, metres, not closed. The first is the outer ring, counter-clockwise as seen from
    inside the room; the others are holes, clockwise."""
    offset_std_m: float
    """Standard uncertainty of the plane along its normal."""
    n_points: int
    """Points that the fit assigned to the face."""
    coverage: float
    """Share of the face's area that points were seen on, 0 to 1."""
    rms_m: float
    """Spread of those points about the plane, 0 without points: the standard deviation of a normal
    distribution with their median absolute deviation, which single points far off do not move."""
    status: PlaneStatus


@dataclass(frozen=True)
class Dimension:
    """The distance of two parallel faces, as a tape would read it."""

    id: str
    """``A``, ``B``, ... ``Z``, ``AA``, ..."""
    kind: DimensionKind
    room: str
    faces: tuple[str, str]
    """Ids of the two faces, the one at the lower Manhattan coordinate first."""
    wall: str | None
    """For kind ``wall`` the face whose clear length this is."""
    from_m: Float[np.ndarray, " 3"]
    """Scan frame, a point on the first face."""
    to_m: Float[np.ndarray, " 3"]
    """Scan frame, the opposite point on the second face."""
    quantity: Quantity
    status: PlaneStatus
    loa: LoaClass | None = None
    """The class that its half width at 95 % belongs to, at whatever level `quantity` is stated."""


@dataclass(frozen=True)
class Room:
    """One room: a closed body of the solid."""

    id: str
    cube: str
    floor_area: Quantity
    volume: Quantity
    perimeter: Quantity


@dataclass(frozen=True)
class RoomMesh:
    """The watertight triangle mesh of one room, facing inward, scan frame."""

    room: str
    vertices_m: Float[np.ndarray, "vertices 3"]
    triangles: np.ndarray
    """(triangles, 3) vertex indices, counter-clockwise as seen from inside the room."""
    face_ids: tuple[str, ...]
    """For each triangle the id of its face."""


@dataclass(frozen=True)
class Doorway:
    """An open passage through the wall between two rooms."""

    id: str
    """``door-1``, ``door-2``, ..."""
    rooms: tuple[str, str]
    faces: tuple[str, str]
    """The wall face on either side, in the order of `rooms`."""
    sill_m: Float[np.ndarray, " 3"]
    """Scan frame: the middle of the opening, in the middle of the wall, at the height of the floor."""
    width_m: float
    """Clear width, approximate: to the nearest points of the wall."""
    evidence: tuple[DoorEvidence, ...]
    """What speaks for it."""
    height_m: float | None = None
    """Clear height above `sill_m`, approximate like the width; None where no lintel was seen."""


@dataclass(frozen=True)
class FitResult:
    """Everything that one run found. Immutable; `io.write_model_json` is its lossless form."""

    method: Method
    level: float
    frame: Frame
    shape: Shape
    rooms: tuple[Room, ...]
    faces: tuple[Face, ...]
    dimensions: tuple[Dimension, ...]
    meshes: tuple[RoomMesh, ...]
    noise: Mapping[str, Any]
    """The estimated noise model, plain values for JSON, with a sentence under ``explanation``."""
    notes: tuple[Note, ...]
    provenance: Mapping[str, Any]
    converged: bool
    """False where the fit hit its step limit or a room could not be closed (exit code 3)."""
    textures: TextureSet | None = None
    """Images on the faces; None where there are no colours, or none were wanted."""
    adjacency: tuple[Doorway, ...] = ()
    """Doorways between the rooms."""
    prediction: Prediction | None = field(default=None, repr=False, compare=False)
    """Intervals at any level, for dimensions, rooms and plane offsets in the order of `measure.measurands`;
    None for a result that was read from a file."""
    registration: tuple[FrameMotion, ...] = ()
    """How to move each frame of the scan, where frame ids showed it. About the scan and not about the room:
    the one field that ``model.json`` leaves out."""
    plane_covariance_m2: Float[np.ndarray, "planes planes"] | None = None
    """Of the offsets of the shape's planes: how lengths that share a wall err together; or None."""
    tape: TapeVerdict | None = None
    """How the lengths compare with readings of a tape or laser meter, where some were given."""

    def face(self, face_id: str) -> Face:
        """The face with this id; KeyError if there is none."""
        for face in self.faces:
            if face.id == face_id:
                return face
        raise KeyError(face_id)

    def decided_by(self, dimension: Dimension) -> frozenset[int]:
        """The planes that a length hangs on: two dimensions with the same ones are the same length.

        Two planes, and that of the wall it is measured along where one of the two is oblique: the two long
        walls of a room with an oblique end differ.
        """
        ends = [self.face(face).plane for face in dimension.faces]
        if dimension.wall is not None and any(self.shape.planes[k].oblique for k in ends):
            ends.append(self.face(dimension.wall).plane)
        return frozenset(ends)

    def cube_bounds_m(self) -> dict[str, Float[np.ndarray, "2 3"]]:
        """Low and high corner of every cube, Manhattan frame."""
        return self.shape.bounds_m()
