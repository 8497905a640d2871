"""Hand-made results of rectilinear rooms, tilted and far from the origin, with exact meshes."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import manifold3d
import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from indoorfit.model import (
    Cube,
    Dimension,
    Face,
    FaceClass,
    FitResult,
    Frame,
    Interval,
    Note,
    Plane,
    Quantity,
    Room,
    RoomMesh,
    Shape,
    Side,
)

Corners = Sequence[tuple[float, float]]


@dataclass(frozen=True)
class Plan:
    """One room: corners counter-clockwise from above, pillars clockwise, Manhattan frame, metres."""

    corners: Corners
    pillars: tuple[Corners, ...] = ()
    z_m: tuple[float, float] = (-1.3, 1.4)
    inferred: tuple[int, ...] = ()
    """Walls without points, numbered along the corners."""


# The L of the thesis: 5.08 x 3.20 x 2.70 m, notch 0.33 x 1.50 m.
L_ROOM = Plan([(0, 0), (5.08, 0), (5.08, 1.7), (4.75, 1.7), (4.75, 3.2), (0, 3.2)], inferred=(3,))
BOX = Plan([(-2, -1.5), (2, -1.5), (2, 1.5), (-2, 1.5)])
U_ROOM = Plan([(0, 0), (6, 0), (6, 4), (3.9, 4), (3.9, 2.6), (2.3, 2.6), (2.3, 4), (0, 4)])
X_ROOM = Plan(
    [
        (1.2, 0), (4.5, 0), (4.5, 1.1), (6, 1.1), (6, 4.0), (4.9, 4.0),
        (4.9, 5.5), (0.9, 5.5), (0.9, 4.3), (0, 4.3), (0, 1.4), (1.2, 1.4),
    ]
)  # fmt: skip
RAGGED = Plan(
    [
        (0, 0), (2.0, 0), (2.0, 0.18), (2.18, 0.18), (2.18, 0), (7.4, 0), (7.4, 2.1), (7.22, 2.1),
        (7.22, 2.28), (7.4, 2.28), (7.4, 4.6), (0.18, 4.6), (0.18, 4.2), (0, 4.2),
    ]
)  # fmt: skip
PILLAR = Plan(
    [(0, 0), (6.0, 0), (6.0, 4.2), (0, 4.2)],
    pillars=(((4.2, 2.0), (4.2, 2.4), (4.6, 2.4), (4.6, 2.0)),),
)
FLAT = (
    Plan([(0, 0), (4.2, 0), (4.2, 3.1), (0, 3.1)]),
    Plan([(4.3, 0), (7.9, 0), (7.9, 5.0), (6.1, 5.0), (6.1, 3.1), (4.3, 3.1)], z_m=(-1.3, 1.15)),
    Plan([(0, 3.22), (6.0, 3.22), (6.0, 5.0), (0, 5.0)], inferred=(2,)),
)

FRAME = Frame(
    Rotation.from_euler("zyx", [23.0, 4.0, -2.5], degrees=True).as_matrix(),
    np.array([4.0e5, 5.0e6, 100.0]),
)

_CLASSES: dict[tuple[int, int], tuple[FaceClass, Side]] = {
    (0, -1): ("left", "-x"), (0, 1): ("right", "+x"), (1, -1): ("back", "-y"),
    (1, 1): ("front", "+y"), (2, -1): ("floor", "-z"), (2, 1): ("ceiling", "+z"),
}  # fmt: skip


def make_result(*plans: Plan, frame: Frame = FRAME, input_name: str = "hand-made.ply") -> FitResult:
    """A result whose polygons, meshes and dimensions agree exactly."""
    builder = _Builder(frame)
    for plan in plans:
        builder.add(plan)
    builder.name_dimensions()
    return FitResult(
        method="joint",
        level=0.95,
        frame=frame,
        shape=Shape(tuple(builder.planes), tuple(builder.cubes)),
        rooms=tuple(builder.rooms),
        faces=tuple(builder.faces),
        dimensions=tuple(builder.dimensions),
        meshes=tuple(builder.meshes),
        noise={"sigma_m": 0.005, "explanation": "Points scatter by 5 mm about their wall."},
        notes=(Note("WALL_INFERRED", "One wall has no points; its place follows from the floor."),),
        provenance={"version": "0", "input": {"name": input_name, "sha256": None}, "seed": 1},
        converged=True,
    )


def plan_area_m2(plan: Plan) -> float:
    """Shoelace area less the pillars."""
    return sum(_shoelace_m2(ring) for ring in (plan.corners, *plan.pillars))


def _shoelace_m2(ring: Corners) -> float:
    x, y = np.array(ring, float).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def _quantity(value: float, std: float, skew: float = 1.0) -> Quantity:
    return Quantity(value, std, Interval(0.95, value - 1.96 * std * skew, value + 1.96 * std))


@dataclass
class _Builder:
    frame: Frame
    planes: list[Plane] = field(default_factory=list)
    cubes: list[Cube] = field(default_factory=list)
    rooms: list[Room] = field(default_factory=list)
    faces: list[Face] = field(default_factory=list)
    dimensions: list[Dimension] = field(default_factory=list)
    meshes: list[RoomMesh] = field(default_factory=list)
    walls: int = 0

    def add(self, plan: Plan) -> None:
        number = len(self.rooms) + 1
        room, first = f"room-{number}", len(self.faces)
        low, high = plan.z_m
        rings = [np.array(ring, float) for ring in (plan.corners, *plan.pillars)]
        for ring in rings:
            for k, (a, b) in enumerate(zip(ring, np.roll(ring, -1, axis=0), strict=True)):
                self.walls += 1
                corners = np.array([[*a, low], [*a, high], [*b, high], [*b, low]])
                tangent = (b - a) / np.linalg.norm(b - a)
                missing = ring is rings[0] and k in plan.inferred
                self._face(f"wall-{self.walls}", room, [corners], (-tangent[1], tangent[0], 0), missing)
        for name, z, sign in (("floor", low, 1), ("ceiling", high, -1)):
            flat = [np.column_stack([ring, np.full(len(ring), z)])[::sign] for ring in rings]
            self._face(f"{name}-{number}", room, flat, (0, 0, sign), False)
        faces = self.faces[first:]
        self._cube(faces)
        self._mesh(room, faces)
        area, height = plan_area_m2(plan), high - low
        around = sum(float(np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1).sum()) for ring in rings)
        self.rooms.append(
            Room(
                room,
                self.cubes[-1].id,
                _quantity(area, 0.004),
                _quantity(area * height, 0.011),
                _quantity(around, 0.002),
            )
        )
        self._dimensions(room, faces, rings)

    def _face(self, name: str, room: str, rings: list[np.ndarray], normal, inferred: bool) -> None:
        normal = np.asarray(normal, float)
        axis = int(np.argmax(np.abs(normal)))
        outward = -int(np.sign(normal[axis]))
        face_class, side = _CLASSES[axis, outward]
        status = "inferred" if inferred else "observed"
        self.planes.append(Plane(axis, outward, float(rings[0][0, axis]), status))
        kind = "wall" if axis < 2 else ("floor" if outward < 0 else "ceiling")
        self.faces.append(
            Face(
                name, kind, face_class, room, f"cube-{len(self.cubes)}", side, len(self.planes) - 1,
                self.frame.directions_to_scan(normal),
                tuple(self.frame.to_scan(ring) for ring in rings),
                0.0005, 0 if inferred else 1000, 0.0 if inferred else 0.9, 0.005, status,
            )
        )  # fmt: skip

    def _cube(self, faces: list[Face]) -> None:
        sides: dict[Side, int | None] = {}
        for face in faces:
            plane = self.planes[face.plane]
            kept = sides.get(face.side)
            if kept is None or plane.outward * (plane.offset_m - self.planes[kept].offset_m) > 0:
                sides[face.side] = face.plane
        self.cubes.append(Cube(f"cube-{len(self.cubes)}", "room", None, sides))

    def _mesh(self, room: str, faces: list[Face]) -> None:
        index: dict[tuple[float, ...], int] = {}
        triangles, ids = [], []
        for face in faces:
            corners = np.concatenate(face.rings_m)
            numbers = [index.setdefault(tuple(p), len(index)) for p in corners.tolist()]
            plane = self.planes[face.plane]
            flat = [self.frame.to_manhattan(ring) @ _in_plane(plane) for ring in face.rings_m]
            for triangle in manifold3d.triangulate(flat):
                triangles.append([numbers[k] for k in triangle])
                ids.append(face.id)
        self.meshes.append(RoomMesh(room, np.array(list(index)), np.array(triangles), tuple(ids)))

    def _dimensions(self, room: str, faces: list[Face], rings: list[np.ndarray]) -> None:
        first = 0
        for ring in rings:
            walls = faces[first : first + len(ring)]
            first += len(ring)
            for k, wall in enumerate(walls):
                a, b = wall.rings_m[0][0], wall.rings_m[0][3]
                self._dimension("wall", room, walls[k - 1], walls[(k + 1) % len(walls)], a, b, wall)
        outer = self.frame.to_manhattan(np.concatenate([faces[0].rings_m[0], faces[-1].rings_m[0]]))
        middle = 0.5 * (outer.min(axis=0) + outer.max(axis=0))
        cube = self.cubes[-1]
        for kind, low, high in (("overall", "-x", "+x"), ("overall", "-y", "+y"), ("height", "-z", "+z")):
            pair = [next(f for f in faces if f.plane == cube.sides[side]) for side in (low, high)]
            ends = [middle.copy(), middle.copy()]
            for end, face in zip(ends, pair, strict=True):
                end["xyz".index(low[1])] = self.planes[face.plane].offset_m
            a, b = (self.frame.to_scan(end) for end in ends)
            self._dimension(kind, room, pair[0], pair[1], a, b, None)

    def _dimension(self, kind, room: str, f: Face, g: Face, a, b, wall: Face | None) -> None:
        if self.planes[f.plane].offset_m > self.planes[g.plane].offset_m:
            f, g, a, b = g, f, b, a
        inferred = "inferred" in (f.status, g.status)
        std = 0.021 if inferred else 0.0003 + 0.0001 * (len(self.dimensions) % 7)
        length = float(np.linalg.norm(np.asarray(b) - np.asarray(a)))
        quantity = _quantity(length, std, 2.0 if inferred else 1.0)
        status = "inferred" if inferred else "observed"
        name = wall.id if wall else None
        self.dimensions.append(Dimension("", kind, room, (f.id, g.id), name, a, b, quantity, status))

    def name_dimensions(self) -> None:
        from dataclasses import replace

        for k, dimension in enumerate(self.dimensions):
            letter = chr(ord("A") + k % 26)
            name = letter if k < 26 else chr(ord("A") + k // 26 - 1) + letter
            self.dimensions[k] = replace(dimension, id=name)


def _in_plane(plane: Plane) -> Float[np.ndarray, "3 2"]:
    """Two axes of the plane such that counter-clockwise is as seen from inside the room."""
    first, second = (plane.axis + 1) % 3, (plane.axis + 2) % 3
    axes = np.zeros((3, 2))
    axes[first if plane.outward < 0 else second, 0] = 1.0
    axes[second if plane.outward < 0 else first, 1] = 1.0
    return axes
