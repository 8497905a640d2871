"""The doorways that a scene was built with, in the terms of its truth."""

import numpy as np

from indoorfit.measure import Survey, backings
from indoorfit.model import Doorway, Frame, Shape
from indoorfit.simulate import Opening, Scene


def true_doors(scene: Scene, shape: Shape, frame: Frame, found: Survey) -> tuple[Doorway, ...]:
    """Every door of the scene that pierces a wall between two of its rooms, in the order of the scene.

    Args:
        scene: what was scanned.
        shape: its grammar, same Manhattan frame.
        frame: its exact pose in the scan.
        found: the survey of the shape.
    """
    doors: list[Doorway] = []
    for opening in scene.openings:
        if opening.kind != "door":
            continue
        axis = "xy".index(opening.axis)
        for backing in backings(shape, found):
            faces = (backing.low, backing.high)
            offsets_m = [shape.planes[face.polygon.plane].offset_m for face in faces]
            if backing.axis == axis and _pierces(opening, axis, offsets_m, backing.span_m):
                sill_m = np.array([*opening.centre_m, backing.rise_m[0]])
                sill_m[axis] = np.mean(offsets_m)
                doors.append(
                    Doorway(
                        id=f"door-{len(doors) + 1}",
                        rooms=(faces[0].room, faces[1].room),
                        faces=(faces[0].id, faces[1].id),
                        sill_m=frame.to_scan(sill_m),
                        width_m=opening.width_m,
                        evidence=("truth",),
                        height_m=min(opening.top_m, backing.rise_m[1]) - backing.rise_m[0],
                    )
                )
    return tuple(doors)


def _pierces(opening: Opening, axis: int, offsets_m: list[float], span_m: tuple[float, float]) -> bool:
    """Whether both faces are within the opening's reach and the opening lies between the wall's ends."""
    across_m, along_m = opening.centre_m[axis], opening.centre_m[1 - axis]
    near = all(abs(offset - across_m) <= opening.reach_m for offset in offsets_m)
    return near and span_m[0] < along_m < span_m[1]
