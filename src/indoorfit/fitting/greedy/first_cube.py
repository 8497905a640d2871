"""The largest cube: a unit cube transformed onto the farthest segments (thesis 3.2.4)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from indoorfit.model import FaceClass

from ..moments import PlaneMoments, plane_moments
from .selection import CLASS_SIDES


@dataclass(frozen=True)
class CubeTransform:
    """Takes the unit cube about the origin to the room: ``p = rotation @ (size_m * unit) + centre_m``."""

    rotation: Float[np.ndarray, "3 3"]
    centre_m: Float[np.ndarray, " 3"]
    size_m: Float[np.ndarray, " 3"]
    converged: bool


def fit_unit_cube(face_points_m: Mapping[FaceClass, Float[np.ndarray, "points 3"]]) -> CubeTransform:
    """Rotation, translation and scale that bring each face of a unit cube onto its points.

    Args:
        face_points_m: points of all six faces, one or more each; axes right within a few degrees.

    Returns:
        the least squares estimate over the perpendicular distances of all points, equal weights.

    Source: thesis 3.2.4 (the point matrix with a face id per point, the unit cube, one transformation);
    the sum over points is taken exactly through their moments.
    """
    names = list(CLASS_SIDES)
    axes = np.array([CLASS_SIDES[name][0] for name in names])
    signs = np.array([CLASS_SIDES[name][1] for name in names])
    points_m = np.concatenate([face_points_m[name] for name in names])
    face_ids = np.repeat(np.arange(6), [len(face_points_m[name]) for name in names])
    moments = plane_moments(points_m, face_ids, np.ones(len(points_m)), 6)
    levels_m = moments.means_m[np.arange(6), axes]
    low_m, high_m = levels_m[signs < 0], levels_m[signs > 0]
    start = np.concatenate([np.zeros(3), 0.5 * (low_m + high_m), high_m - low_m])
    found = least_squares(_residuals, start, args=(moments, axes, signs), method="lm")
    rotation = Rotation.from_rotvec(found.x[:3]).as_matrix()
    return CubeTransform(rotation, found.x[3:6], found.x[6:], bool(found.success))


def _residuals(
    unknowns: Float[np.ndarray, " 9"], moments: PlaneMoments, axes: np.ndarray, signs: np.ndarray
) -> Float[np.ndarray, " rows"]:
    """Four rows per face; their squares add up to the squared distances of all its points, m²."""
    normals = (Rotation.from_rotvec(unknowns[:3]).as_matrix()[:, axes] * signs).T
    spread = np.einsum("fij,fj->fi", moments.roots, normals)
    outer_m = normals @ unknowns[3:6] + 0.5 * unknowns[6:][axes]
    gaps_m = np.einsum("fi,fi->f", normals, moments.means_m) - outer_m
    return np.concatenate([spread.ravel(), np.sqrt(moments.weights) * gaps_m])
