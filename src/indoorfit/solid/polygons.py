"""Triangles that share a plane, as polygons with holes."""

import numpy as np
from jaxtyping import Float, Int

from indoorfit.model import Polygon, RoomSolid


def face_polygons(solid: RoomSolid) -> tuple[Polygon, ...]:
    """The faces of a room: one polygon per connected group of triangles on one plane.

    Args:
        solid: closed, outward triangles.

    Returns:
        polygons ordered by plane, then by lowest corner, so that ids are stable.
    """
    found: list[Polygon] = []
    for plane in np.unique(solid.planes):
        members = np.flatnonzero(solid.planes == plane)
        for group in _connected(solid.triangles, members):
            # Inward orientation: the solid's triangles the other way round.
            rings = _rings(solid.triangles[group][:, ::-1])
            corners = [_without_straight_corners(solid.vertices_m[ring]) for ring in rings]
            area_m2 = float(_areas(solid, group).sum())
            found.append(Polygon(int(plane), tuple(_outer_first(corners)), group, area_m2))
    return tuple(sorted(found, key=lambda polygon: (polygon.plane, *polygon.rings_m[0].min(axis=0))))


def _connected(
    triangles: Int[np.ndarray, "n 3"], members: Int[np.ndarray, " m"]
) -> list[Int[np.ndarray, " _"]]:
    """Groups of triangles that hang together by edges."""
    by_edge: dict[tuple[int, int], list[int]] = {}
    for t in members:
        for a, b in _edges(triangles[t]):
            by_edge.setdefault((min(a, b), max(a, b)), []).append(int(t))
    group_of = {int(t): int(t) for t in members}

    def root(t: int) -> int:
        while group_of[t] != t:
            t = group_of[t]
        return t

    for sharing in by_edge.values():
        for other in sharing[1:]:
            group_of[root(other)] = root(sharing[0])
    roots = np.array([root(int(t)) for t in members])
    return [members[roots == r] for r in np.unique(roots)]


def _edges(triangle: Int[np.ndarray, " 3"]) -> list[tuple[int, int]]:
    a, b, c = (int(v) for v in triangle)
    return [(a, b), (b, c), (c, a)]


def _rings(triangles: Int[np.ndarray, "n 3"]) -> list[list[int]]:
    """Boundary loops: the directed edges without an opposite, chained."""
    directed = {edge for triangle in triangles for edge in _edges(triangle)}
    following: dict[int, list[int]] = {}
    for a, b in sorted(directed):
        if (b, a) not in directed:
            following.setdefault(a, []).append(b)
    rings = []
    while following:
        start = min(following)
        ring, here = [start], _take(following, start)
        while here != start:
            ring.append(here)
            here = _take(following, here)
        rings.append(ring)
    return rings


def _take(following: dict[int, list[int]], vertex: int) -> int:
    successors = following[vertex]
    taken = successors.pop(0)
    if not successors:
        del following[vertex]
    return taken


def _without_straight_corners(ring_m: Float[np.ndarray, "corners 3"]) -> Float[np.ndarray, "kept 3"]:
    """Drop vertices in the middle of a straight edge, which belong to the neighbouring faces' corners."""
    before, after = ring_m - np.roll(ring_m, 1, axis=0), np.roll(ring_m, -1, axis=0) - ring_m
    turns = np.linalg.norm(np.cross(before, after), axis=1)
    lengths = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    kept = ring_m[turns > 1e-9 * lengths]
    # Rings start at their lowest corner whatever the mesh's numbering was.
    first = min(range(len(kept)), key=lambda k: tuple(kept[k]))
    return np.roll(kept, -first, axis=0)


def _outer_first(rings_m: list[Float[np.ndarray, "_ 3"]]) -> list[Float[np.ndarray, "_ 3"]]:
    """The ring with the largest extent encloses the others."""
    return sorted(rings_m, key=lambda ring: -float(np.ptp(ring, axis=0).sum()))


def _areas(solid: RoomSolid, group: Int[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    a, b, c = np.moveaxis(solid.vertices_m[solid.triangles[group]], 1, 0)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
