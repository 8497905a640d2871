"""The modelling procedure of the thesis, step by step (3.2.2 to 3.2.5); the research baseline.

Segmentation (3.2.1) and the six classes (3.2.3) come from the front end. Then follow, with the thesis'
section numbers:

- 3.2.2  a RANSAC plane per segment, its normal away from the centroid, its perpendicular distance;
- 3.2.4  per class the farthest segment and all within 10 cm of it; a unit cube brought onto their points by
  rotation, translation and scale: the largest cube, whose rotation all others share;
- 3.2.5  the remaining wall segments in connected components; per component a new origin, new classes, the
  farthest planes with free normals, their intersections with floor and ceiling, and from these a cube;
  again for what is left of the component; the subtraction runs from the smallest to the largest.

Where the thesis is silent, or shows a hand at work, this is what is done:

- **Slivers.** Only segments of `min_area_m2` and more take part: one tilted sliver along an edge is else the
  farthest segment of its class.
- **Inliers of the first cube.** "We select inlier points and then calculate the transformation" (6.1): the
  inliers of one RANSAC plane per face. The start frame is the one of the front end, not the centroid's axes.
- **A class without segments.** The face lies at the outermost classified point in that direction, is marked
  inferred and noted. In the least squares this point stands for the face.
- **Remaining segments** are of the four wall classes; those of floor and ceiling (one plane each, 3.2) that
  were not selected are left out.
- **Furniture.** "We can separate the favorite component" (5.1.2) is a choice by hand. Instead, planes of a
  class that do not span `reach_share` of the room's height are set aside, and the rest is split into
  components again. Walls half hidden by furniture are lost with it. In the first cube every segment counts.
- **Which of the farthest planes bound the cube.** The first cube is the farthest planes "containing whole
  indoor"; so is each later one of its component. A farthest plane beyond which the component goes on (by more
  than `join_m`) cannot bound it: that side is infinite, and the plane stays for the next round. Otherwise the
  two steps of a stair, seen from their centroid, look like the four walls of a pillar.
- **Infinite sides** point away from the plane of the opposite class: the cube lies on the component's side of
  its planes. An intersection point in the middle of the room thus takes away everything up to the outer
  walls, as the thesis' text has it.
- **Four planes** give four intersection points, hence both scales: a pillar.
- **Tilted planes.** The cube keeps the first cube's rotation, so a wall lies where its intersection points
  with floor and ceiling are, on average; the plane itself with its tilt is kept in the step.
- **Planes without a cube.** Fewer than two planes, or only parallel ones, have no intersection point and make
  no cube (3.2.5: "until there was less than two planes remained"); they are noted.
- **Several rooms.** The thesis models one; so does this.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int

from indoorfit.errors import InputError
from indoorfit.geometry import exposures
from indoorfit.model import (
    SIDES,
    FaceClass,
    Frame,
    Note,
    PlaneStatus,
    Scan,
    Segments,
    Shape,
    Side,
    Surfels,
    side_axis,
    side_sign,
)

from .config import GreedyConfig
from .details import DetailFitter
from .first_cube import CubeTransform, fit_unit_cube
from .ransac import ransac_inliers, ransac_plane
from .record import FittedPlane, GreedyFit, GreedyStep
from .segment_points import SegmentPoints, segment_points
from .selection import CLASS_SIDES, WALLS, farthest_groups
from .tree import CubeTree

_ORIGIN = np.zeros(3)
"""The centroid of the cloud is the origin (4.2.2)."""


def fit_greedy(
    scan: Scan,
    frame: Frame,
    surfels: Surfels,
    segments: Segments,
    classes: tuple[FaceClass | None, ...],
    point_surfel: Int[np.ndarray, " points"],
    config: GreedyConfig,
    rng: np.random.Generator,
) -> GreedyFit:
    """Model one room as the thesis does; see the module's text for every decision.

    Args:
        scan: metres, scan frame.
        frame: Manhattan frame, right within a few degrees, its origin the centroid of the cloud.
        surfels: in `frame`.
        segments: of these surfels.
        classes: of these segments (table 3-1 and the rule of half the height).
        point_surfel: the surfel of each point of the scan.
        config: see `GreedyConfig`.
        rng: for RANSAC.

    Returns:
        the tree of cubes in the frame of the first cube, every step, and remarks.

    Raises:
        InputError: no floor and no ceiling, no wall along x or along y, or nothing left of the room.
    """
    points_m, labels = frame.to_manhattan(scan.points_m), segments.labels
    cloud = segment_points(points_m, labels[point_surfel], surfels.positions_m, labels, segments.n_segments)
    usable = _usable(segments, classes, config)
    planes = {k: ransac_plane(str(k), cloud.points([k]), _ORIGIN, config, rng) for k in usable}
    selected = _select_farthest(usable, planes, config)
    _require_walls(selected)
    cube, inferred = _first_cube(cloud, usable, selected, config, rng)

    # From here on everything is in the frame of the first cube.
    R_new_old = cube.rotation.T
    cloud = cloud.turned(R_new_old)
    planes = {k: _turned(plane, R_new_old) for k, plane in planes.items()}
    tree = CubeTree()
    bounds_m = R_new_old @ cube.centre_m + np.outer([-0.5, 0.5], cube.size_m)
    room = tree.add_room(bounds_m, _status(inferred))
    link_m = max(config.link_m, config.link_spacings * surfels.spacing_m)
    details = DetailFitter(cloud, planes, tree, link_m, config, rng)
    details.add(_remaining_walls(usable, selected), room)

    shape = tree.shape()
    steps = (
        GreedyStep("3.2.2", "planes", _by_class(usable), planes=tuple(planes.values())),
        GreedyStep("3.2.4", "first cube", selected, room, None, bounds_m),
        *details.steps,
    )
    notes = (*_inferred_notes(inferred), *_unused_notes(details.unused, segments), *_check_room(shape))
    return GreedyFit(
        shape, Frame(R_new_old @ frame.R_manhattan_scan, frame.origin_scan_m), steps, notes, cube.converged
    )


def _usable(
    segments: Segments, classes: tuple[FaceClass | None, ...], config: GreedyConfig
) -> dict[int, FaceClass]:
    """Classified segments of some size."""
    return {
        k: name
        for k, name in enumerate(classes)
        if name is not None and segments.areas_m2[k] >= config.min_area_m2
    }


def _by_class(usable: Mapping[int, FaceClass]) -> dict[FaceClass, tuple[int, ...]]:
    return {name: tuple(k for k in usable if usable[k] == name) for name in CLASS_SIDES}


def _select_farthest(
    usable: Mapping[int, FaceClass], planes: Mapping[int, FittedPlane], config: GreedyConfig
) -> dict[FaceClass, tuple[int, ...]]:
    """Per class the farthest segment and its neighbours (3.2.4); classes without segments are left out."""
    return {
        name: farthest_groups(planes, members, _ORIGIN, config.join_m)[0]
        for name, members in _by_class(usable).items()
        if members
    }


def _remaining_walls(
    usable: Mapping[int, FaceClass], selected: Mapping[FaceClass, tuple[int, ...]]
) -> list[int]:
    """Wall segments that the first cube did not use (3.2.5)."""
    taken = {k for group in selected.values() for k in group}
    return [k for k in usable if usable[k] in WALLS and k not in taken]


def _require_walls(selected: Mapping[FaceClass, tuple[int, ...]]) -> None:
    seen = {CLASS_SIDES[name][0] for name in selected}
    missing = [
        what
        for axis, what in enumerate(("wall along y", "wall along x", "floor or ceiling"))
        if axis not in seen
    ]
    if missing:
        raise InputError(
            f"fit.greedy: no {' and no '.join(missing)} among the segments; a cube needs one face in each "
            "of the three directions. Fix: lower fit.greedy.min_area_m2, or check --unit and --up."
        )


def _first_cube(
    cloud: SegmentPoints,
    usable: Mapping[int, FaceClass],
    selected: Mapping[FaceClass, tuple[int, ...]],
    config: GreedyConfig,
    rng: np.random.Generator,
) -> tuple[CubeTransform, tuple[FaceClass, ...]]:
    """The largest cube, and the faces that no segment was found for."""
    classified_m = cloud.points(usable)
    face_points_m: dict[FaceClass, Float[np.ndarray, "points 3"]] = {}
    inferred: list[FaceClass] = []
    for name, (axis, sign) in CLASS_SIDES.items():
        if name in selected:
            points_m = cloud.points(selected[name])
            face_points_m[name] = points_m[ransac_inliers(points_m, config, rng)]
        else:
            outermost = int(np.argmax(sign * classified_m[:, axis]))
            face_points_m[name] = classified_m[outermost : outermost + 1]
            inferred.append(name)
    cube = fit_unit_cube(face_points_m)
    if np.min(cube.size_m) <= config.join_m:
        edges = " x ".join(f"{edge_m:.2f}" for edge_m in cube.size_m)
        raise InputError(
            f"fit.greedy: the largest cube measures {edges} m; a room is more than {config.join_m:.2f} m "
            "in each direction. Fix: check --unit, and that opposite walls were scanned."
        )
    return cube, tuple(inferred)


def _turned(plane: FittedPlane, R_new_old: Float[np.ndarray, "3 3"]) -> FittedPlane:
    return replace(plane, normal=R_new_old @ plane.normal, centre_m=R_new_old @ plane.centre_m)


def _status(inferred: tuple[FaceClass, ...]) -> dict[Side, PlaneStatus]:
    unseen = {CLASS_SIDES[name] for name in inferred}
    return {
        side: "inferred" if (side_axis(side), side_sign(side)) in unseen else "observed" for side in SIDES
    }


def _inferred_notes(inferred: tuple[FaceClass, ...]) -> list[Note]:
    return [
        Note(
            "GREEDY_FACE_INFERRED",
            f"No segment of class {name} was found; the face was put at the outermost point in that "
            "direction. Check its dimensions, or scan that side.",
        )
        for name in inferred
    ]


def _unused_notes(unused: list[int], segments: Segments) -> list[Note]:
    if not unused:
        return []
    return [
        Note(
            "GREEDY_WALLS_UNUSED",
            f"{len(unused)} wall segment(s) of {segments.areas_m2[unused].sum():.1f} m² in all have no "
            "perpendicular partner and made no cube. Compare the plan with the scan, or use --method joint.",
        )
    ]


def _check_room(shape: Shape) -> list[Note]:
    """Remarks on planes that other cubes took away altogether.

    Raises:
        InputError: no floor is left.
    """
    areas_m2 = {exposure.plane: exposure.area_m2 for exposure in exposures(shape)}
    floor = shape.rooms[0].sides["-z"]
    assert floor is not None, "a room has no open side"
    if areas_m2[floor] <= 0.0:
        raise InputError(
            f"fit.greedy: the {len(shape.cubes) - 1} cubes to be subtracted leave nothing of the room. "
            "Fix: use --method joint, or raise fit.greedy.reach_share to set more furniture aside."
        )
    swallowed = sum(area_m2 <= 0.0 for area_m2 in areas_m2.values())
    if not swallowed:
        return []
    return [
        Note(
            "GREEDY_WALLS_SWALLOWED",
            f"{swallowed} plane(s) lie wholly within cubes that were taken away. The plan is likely wrong "
            "there; compare it with the scan, or use --method joint.",
        )
    ]
