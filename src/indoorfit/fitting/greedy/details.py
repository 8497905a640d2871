"""Adding details: cubes from the remaining wall segments (thesis 3.2.5)."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from indoorfit.model import FaceClass, Side

from .components import connected_segments
from .config import GreedyConfig
from .ransac import ransac_plane
from .record import FittedPlane, GreedyStep
from .segment_points import SegmentPoints
from .selection import CLASS_SIDES, farthest_groups, wall_classes
from .tree import CubeTree

_CLASS_SIDE: dict[FaceClass, Side] = {"left": "-x", "right": "+x", "back": "-y", "front": "+y"}

Groups = dict[FaceClass, tuple[int, ...]]


@dataclass
class DetailFitter:
    """Repeats the procedure on what is left, until fewer than two planes are (3.2.5)."""

    cloud: SegmentPoints
    """Frame of the first cube."""
    planes: dict[int, FittedPlane]
    """RANSAC plane of each segment (3.2.2), same frame."""
    tree: CubeTree
    """Holds the first cube and receives the others."""
    link_m: float
    config: GreedyConfig
    rng: np.random.Generator
    steps: list[GreedyStep] = field(default_factory=list)
    unused: list[int] = field(default_factory=list)
    """Wall segments that made no cube."""

    def add(self, segments: Sequence[int], parent: str) -> None:
        """Split segments into components and make the cubes of each, children of `parent`."""
        components = connected_segments(self.cloud, segments, self.link_m)
        if components:
            names = {f"component-{k + 1}": component for k, component in enumerate(components)}
            self.steps.append(GreedyStep("3.2.5", "components", names, parent=parent))
        for component in components:
            self._add_component(component, parent)

    def _add_component(self, component: tuple[int, ...], parent: str) -> None:
        # New coordinate system with the origin on the component's centroid; classes anew.
        origin_m = self.cloud.points(component).mean(axis=0)
        classes = wall_classes(self.planes, component, origin_m, self.config)
        groups: dict[FaceClass, list[tuple[int, ...]]] = {
            name: farthest_groups(self.planes, members, origin_m, self.config.join_m)
            for name, members in classes.items()
        }
        low = tuple(
            k for found in groups.values() for group in found if not self._reaches(group) for k in group
        )
        if low:
            # Stands for "here we can separate the favorite component" (5.1.2): what remains is split again.
            self.steps.append(GreedyStep("5.1.2", "set aside", {"furniture": low}, parent=parent))
            self.add([k for k in component if k not in low], parent)
            return
        selected = self._outermost(groups, component)
        planes = self._fit(selected, origin_m)
        corners_m = self._corners(planes)
        offsets_m = _offsets(planes, corners_m)
        bounds_m = self._bounds(offsets_m)
        if len(offsets_m) < 2 or not self._fits_into(parent, bounds_m):
            step = GreedyStep("3.2.5", "no cube", selected or {"left over": component}, parent=parent)
            self.steps.append(step)
            self.unused += component
            return
        cube = self.tree.add_part(parent, offsets_m)
        step = GreedyStep(
            "3.2.5", "cube", selected, cube, parent, bounds_m, tuple(planes.values()), _stack(corners_m)
        )
        self.steps.append(step)
        # "If we had remained segments from second step, then we should repeat the mentioned procedure."
        used = {k for group in selected.values() for k in group}
        self.add([k for k in component if k not in used], cube)

    def _reaches(self, group: tuple[int, ...]) -> bool:
        """Whether a plane spans the room's height, so that it is wall and not furniture."""
        heights_m = self.cloud.surfels(group)[:, 2]
        floor_m, ceiling_m = self._levels()
        # Segments stop short of floor and ceiling as they stop short of corners, hence the link.
        span_m = float(np.ptp(heights_m)) + self.link_m
        return span_m >= self.config.reach_share * (ceiling_m - floor_m)

    def _levels(self) -> tuple[float, float]:
        """Heights of floor and ceiling, the same for all cubes."""
        room = self.tree.cubes[0]
        floor, ceiling = room.sides["-z"], room.sides["+z"]
        assert floor is not None, "a room has no open side"
        assert ceiling is not None, "a room has no open side"
        return self.tree.planes[floor].offset_m, self.tree.planes[ceiling].offset_m

    def _outermost(
        self, groups: dict[FaceClass, list[tuple[int, ...]]], component: tuple[int, ...]
    ) -> Groups:
        """The farthest planes beyond which the component does not go on; the other sides are infinite."""
        surfels_m = self.cloud.surfels(component)
        kept: Groups = {}
        for name, (group, *_) in groups.items():
            axis, sign = CLASS_SIDES[name]
            end_m = np.max(sign * surfels_m[:, axis])
            if np.mean(sign * self.cloud.surfels(group)[:, axis]) >= end_m - self.config.join_m:
                kept[name] = group
        return kept

    def _fit(self, selected: Groups, origin_m: Float[np.ndarray, " 3"]) -> dict[FaceClass, FittedPlane]:
        """New planes with free normals, by RANSAC over the selected segments of each class."""
        return {
            name: ransac_plane(name, self.cloud.points(group), origin_m, self.config, self.rng)
            for name, group in selected.items()
        }

    def _corners(
        self, planes: dict[FaceClass, FittedPlane]
    ) -> dict[tuple[FaceClass, FaceClass], Float[np.ndarray, "2 3"]]:
        """Each pair of perpendicular walls, once intersected with the floor and once with the ceiling."""
        corners_m = {}
        for first, a in planes.items():
            for second, b in planes.items():
                if CLASS_SIDES[first][0] == 0 and CLASS_SIDES[second][0] == 1:
                    matrix = np.array([a.normal, b.normal, [0.0, 0.0, 1.0]])
                    ends = [
                        np.linalg.solve(
                            matrix, np.array([a.normal @ a.centre_m, b.normal @ b.centre_m, level_m])
                        )
                        for level_m in self._levels()
                    ]
                    corners_m[first, second] = np.array(ends)
        return corners_m

    def _bounds(self, offsets_m: dict[Side, float]) -> Float[np.ndarray, "2 3"]:
        bounds_m = np.array([[-np.inf] * 3, [np.inf] * 3])
        bounds_m[:, 2] = self._levels()
        for side, offset_m in offsets_m.items():
            bounds_m[int(side[0] == "+"), "xyz".index(side[1])] = offset_m
        return bounds_m

    def _fits_into(self, parent: str, bounds_m: Float[np.ndarray, "2 3"]) -> bool:
        """Whether the cube takes something away: not inside out, and not beside its parent."""
        outer_m = self.tree.shape().bounds_m()[parent]
        low_m, high_m = np.maximum(bounds_m[0], outer_m[0]), np.minimum(bounds_m[1], outer_m[1])
        return bool(np.all(high_m > low_m))


def _offsets(
    planes: dict[FaceClass, FittedPlane],
    corners_m: dict[tuple[FaceClass, FaceClass], Float[np.ndarray, "2 3"]],
) -> dict[Side, float]:
    """Position and scale of the cube from its intersection points.

    One point: the previous cube is moved there, both scales infinite. Two points along x: their distance is
    the x scale, y infinite; along y alike (3.2.5). Four points: both scales, a pillar. Each wall lies at the
    mean of its points on floor and ceiling, as the cube keeps the rotation of the first one.
    """
    offsets_m: dict[Side, float] = {}
    for name in planes:
        ends = [corner_m for pair, corner_m in corners_m.items() if name in pair]
        if ends:
            offsets_m[_CLASS_SIDE[name]] = float(np.mean(np.array(ends)[..., CLASS_SIDES[name][0]]))
    return offsets_m


def _stack(
    corners_m: dict[tuple[FaceClass, FaceClass], Float[np.ndarray, "2 3"]],
) -> Float[np.ndarray, "corners 2 3"]:
    return np.array(list(corners_m.values())).reshape(-1, 2, 3)
