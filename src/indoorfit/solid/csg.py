"""The tree of cubes as one watertight solid per room: boolean differences from the leaves (thesis 3.2.5)."""

import manifold3d as m3
import numpy as np
from jaxtyping import Float

from indoorfit.model import SIDES, Cube, RoomSolid, Shape

_NO_PLANE = 1_000_000
"""Face id of open sides; they lie outside the parent and must not survive the difference."""
_SIMPLIFY_M = 1e-6
"""Triangles on one plane are merged within a thousandth of a millimetre."""


def subtract_cubes(shape: Shape, room: Cube) -> RoomSolid:
    """One room minus its notches, each notch minus its parts, and so on.

    The boolean runs in the Manhattan frame, where faces that touch share bitwise equal coordinates: that
    keeps it exact, and fast.

    Args:
        shape: the whole grammar.
        room: one of `shape.rooms`.
    """
    solid = _difference(shape, room, shape.bounds_m())
    # Rebuilding with the face ids but without the history of runs lets coplanar triangles be merged.
    mesh = solid.to_mesh64()
    merged = m3.Manifold(
        m3.Mesh64(
            vert_properties=np.array(mesh.vert_properties),
            tri_verts=np.array(mesh.tri_verts),
            face_id=np.array(mesh.face_id),
        )
    ).simplify(_SIMPLIFY_M)
    mesh = merged.to_mesh64()
    planes = np.array(mesh.face_id).astype(np.int64)
    # Planes that passed each other turn a box inside out, which no later difference shows.
    ordered = all(np.all(corners[0] < corners[1]) for corners in shape.bounds_m().values())
    closed = (
        ordered
        and merged.volume() > 0.0
        and merged.status() == m3.Error.NoError
        and not merged.is_empty()
        and len(merged.decompose()) == 1
        and not np.any(planes == _NO_PLANE)
    )
    return RoomSolid(
        vertices_m=np.array(mesh.vert_properties)[:, :3],
        triangles=np.array(mesh.tri_verts).astype(np.int64),
        planes=planes,
        volume_m3=float(merged.volume()),
        is_closed=bool(closed),
    )


def _difference(shape: Shape, cube: Cube, bounds_m: dict[str, Float[np.ndarray, "2 3"]]) -> m3.Manifold:
    solid = _box(cube, bounds_m[cube.id])
    if cube.between is not None:
        solid = solid.rotate((0.0, 0.0, float(np.degrees(shape.yaw_of(cube)))))
    for child in shape.children(cube.id):
        solid = solid - _difference(shape, child, bounds_m)
    return solid


_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
_QUADS = {
    "-x": (0, 1, 3, 2),
    "+x": (4, 6, 7, 5),
    "-y": (0, 4, 5, 1),
    "+y": (2, 3, 7, 6),
    "-z": (0, 2, 6, 4),
    "+z": (1, 5, 7, 3),
}
"""Corners of each side, counter-clockwise as seen from outside the box."""


def _box(cube: Cube, corners_m: Float[np.ndarray, "2 3"]) -> m3.Manifold:
    """A box whose triangles carry the index of their plane as face id."""
    vertices = np.take_along_axis(corners_m, _CORNERS, axis=0)
    triangles, planes = [], []
    for side in SIDES:
        a, b, c, d = _QUADS[side]
        plane = cube.sides[side]
        triangles += [(a, b, c), (a, c, d)]
        planes += [_NO_PLANE if plane is None else plane] * 2
    return m3.Manifold(
        m3.Mesh64(
            vert_properties=vertices,
            tri_verts=np.array(triangles, np.uint64),
            face_id=np.array(planes, np.uint64),
        )
    )
