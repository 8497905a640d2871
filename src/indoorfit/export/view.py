"""Where a viewer should start from."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from indoorfit.model import FitResult


@dataclass(frozen=True)
class Viewpoint:
    """A camera that looks along its own -z with y up, as VRML and X3D have it."""

    position_m: Float[np.ndarray, " 3"]
    """Scan axes, relative to the frame's origin."""
    axis: Float[np.ndarray, " 3"]
    angle_rad: float
    """The turn from the scan's axes to the camera's."""


def view_from_above(result: FitResult) -> Viewpoint:
    """A look into the doll's house from above; viewers would start beside map coordinates otherwise."""
    corners = result.frame.to_manhattan(np.concatenate([mesh.vertices_m for mesh in result.meshes]))
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    size_m = float(np.linalg.norm(corners.max(axis=0) - corners.min(axis=0)))
    backward = np.array([-0.45, -0.65, 0.9]) / np.linalg.norm([-0.45, -0.65, 0.9])
    right = np.cross([0.0, 0.0, 1.0], backward)
    right /= np.linalg.norm(right)
    R_manhattan_camera = np.column_stack([right, np.cross(backward, right), backward])
    # The default field of view is 45 degrees; 1.4 diagonals away the whole model is in it.
    position = result.frame.directions_to_scan(middle + 1.4 * size_m * backward)
    turn = Rotation.from_matrix(result.frame.R_manhattan_scan.T @ R_manhattan_camera).as_rotvec()
    angle = float(np.linalg.norm(turn))
    axis = turn / angle if angle > 0 else np.array([0.0, 0.0, 1.0])
    return Viewpoint(position, axis, angle)
