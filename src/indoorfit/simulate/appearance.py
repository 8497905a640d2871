"""What the planes of a scene look like, without a camera: the truth that textures are judged by."""

import numpy as np
from jaxtyping import Float

from .scene_build import BuiltScene
from .surfaces import shade


def plane_colours(
    built: BuiltScene, plane: int, points_m: Float[np.ndarray, "points 3"]
) -> Float[np.ndarray, "points 3"]:
    """True colours of points on one plane, 0 to 255, whatever stands before it.

    Args:
        built: the scene.
        plane: index in the shape's planes.
        points_m: Manhattan frame, on the plane.
    """
    return shade(built.surfaces[plane], plane, points_m)
