"""From a scene to rectangles that rays can be cast against, with the truth that belongs to them."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool

from indoorfit.geometry import Corner, Exposure, exposures, room_of_planes
from indoorfit.model import Plane, Shape

from .furniture import add_furniture
from .openings import Rect, add_openings, pierced, without
from .quads import QuadList, Quads
from .scene import Finish, Scene
from .scene_shape import scene_shape
from .surfaces import Surface

_DEFAULT_COLOURS = {"floor": (150, 120, 90), "ceiling": (240, 240, 236)}
_WALL_COLOUR = (225, 222, 212)


@dataclass(frozen=True)
class BuiltScene:
    """A scene ready to be scanned."""

    scene: Scene
    shape: Shape
    quads: Quads
    surfaces: tuple[Surface, ...]


def build_scene(scene: Scene) -> BuiltScene:
    """Cut the openings, place the furniture, give every surface its finish.

    Raises:
        ConfigError: rooms, steps or openings do not fit together.
    """
    shape = scene_shape(scene)
    found = exposures(shape)
    quads, surfaces = QuadList(), []
    holes = [pierced(scene, shape, found, opening) for opening in scene.openings]
    home = {room.id: k for k, room in enumerate(shape.rooms)}
    rooms = room_of_planes(shape)
    for exposure in found:
        plane = shape.planes[exposure.plane]
        if plane.oblique:
            surfaces.append(Surface(colour=_WALL_COLOUR))
            _add_oblique(quads, exposure, plane)
            continue
        if not exposure.mask.any():
            # An oblique wall stands in its place.
            surfaces.append(Surface(colour=_WALL_COLOUR))
            continue
        surfaces.append(_surface(scene, shape, exposure, home[rooms[exposure.plane]]))
        cut = [hole.rect for opening in holes for hole in opening if hole.plane == exposure.plane]
        opened = [_behind(corner) for corner in exposure.corners if corner.floor]
        for rect in [*rectangles(exposure), *opened]:
            for piece in without(rect, cut):
                low = np.insert([piece[0], piece[2]], plane.axis, plane.offset_m)
                high = np.insert([piece[1], piece[3]], plane.axis, plane.offset_m)
                quads.add_axis_aligned(
                    plane.axis, low, high, -plane.outward, exposure.plane, plane=exposure.plane
                )
    for opening, walls in zip(scene.openings, holes, strict=True):
        add_openings(quads, surfaces, shape, opening, walls)
    for item in scene.furniture:
        surfaces.append(Surface(colour=item.colour, texture="grain"))
        add_furniture(quads, item, len(surfaces) - 1)
    return BuiltScene(scene, shape, quads.build(), tuple(surfaces))


def rectangles(exposure: Exposure) -> list[Rect]:
    """The visible cells of a plane, joined to few rectangles (u from, u to, v from, v to)."""
    left = exposure.mask.copy()
    found: list[Rect] = []
    for i, j in np.argwhere(exposure.mask):
        if not left[i, j]:
            continue
        i1, j1 = _grow(left, int(i), int(j))
        left[i:i1, j:j1] = False
        u, v = exposure.u_m, exposure.v_m
        found.append((float(u[i]), float(u[i1]), float(v[j]), float(v[j1])))
    return found


def _grow(free: Bool[np.ndarray, "nu nv"], i: int, j: int) -> tuple[int, int]:
    j1 = j + 1
    while j1 < free.shape[1] and free[i, j1]:
        j1 += 1
    i1 = i + 1
    while i1 < free.shape[0] and free[i1, j:j1].all():
        i1 += 1
    return i1, j1


def _surface(scene: Scene, shape: Shape, exposure: Exposure, room: int) -> Surface:
    plane = shape.planes[exposure.plane]
    face = plane.face_class
    finish = Finish(colour=_DEFAULT_COLOURS.get(face, _WALL_COLOUR))
    for candidate in scene.finishes:
        matches = candidate.face in ("all", face) or (candidate.face == "wall" and plane.axis < 2)
        near = candidate.near_m is None or abs(plane.offset_m - candidate.near_m) < 0.01
        if matches and near and candidate.room in (None, room):
            finish = candidate
    i, j = np.nonzero(exposure.mask)
    u = (float(exposure.u_m[i.min()]), float(exposure.u_m[i.max() + 1]))
    v = (float(exposure.v_m[j.min()]), float(exposure.v_m[j.max() + 1]))
    first, second = (axis for axis in range(3) if axis != plane.axis)
    return Surface(
        colour=finish.colour, texture=finish.texture, bow_m=finish.bow_m, tilt_m=finish.tilt_m,
        axes=(first, second), u_m=u, v_m=v,
    )  # fmt: skip


def _add_oblique(quads: QuadList, exposure: Exposure, plane: Plane) -> None:
    for u0, u1, v0, v1 in rectangles(exposure):
        own_m = np.array([[plane.offset_m, u0, v0], [0.0, u1 - u0, 0.0], [0.0, 0.0, v1 - v0]])
        corner, along, up = plane.from_own(own_m)
        quads.add(corner, along, up, -plane.outward * plane.normal, exposure.plane, exposure.plane)


def _behind(corner: Corner) -> Rect:
    """The rectangle around the corner that an oblique wall opens; what is too much of it nobody can see."""
    (x0, y0), (x1, y1) = corner.corners_m.min(axis=0), corner.corners_m.max(axis=0)
    return float(x0), float(x1), float(y0), float(y1)
