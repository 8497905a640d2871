"""What the tests look at."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from indoorfit.model import Frame, Scan, Shape

from ..association import AssociationConfig, claims
from ..patches import PatchData
from ..uncertainty import Cells, Predictive
from ..uncertainty.cells import ROTATIONS

U95 = 1.96
"""Half width of a 95 % interval in standard uncertainties."""
_NAMED = 6
"""Faces that a warning names one by one."""


@dataclass(frozen=True)
class Evidence:
    """A fitted model, its residuals and its points."""

    shape: Shape
    cells: Cells
    """Residuals at `shape`, one cell per plane and patch."""
    wall: Predictive
    """The wall field that the intervals rest on."""
    data: PatchData
    faces: Mapping[int, tuple[str, ...]]
    """Ids of the faces on each plane; planes without one are not judged."""

    @property
    def offset_std_m(self) -> Float[np.ndarray, " planes"]:
        """Standard uncertainty of every plane's position, from the data."""
        return np.sqrt(np.einsum("k,kpp->p", self.wall.weights, self.wall.covariances)[ROTATIONS:])

    @property
    def judged(self) -> list[int]:
        """Observed planes that are part of the model's surface."""
        return [k for k in sorted(self.faces) if self.shape.planes[k].status == "observed"]

    def named(self, planes: Iterable[int]) -> tuple[str, ...]:
        """Ids of all faces on these planes."""
        return tuple(name for plane in planes for name in self.faces[plane])

    def listed(self, planes: Iterable[int]) -> str:
        """Names of the faces on these planes, the first few of many."""
        names = self.named(planes)
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        return ", ".join(names[:_NAMED]) + more


@dataclass(frozen=True)
class FacePoints:
    """The points that each plane claims, in its own coordinates, and the frames they come from."""

    places_m: tuple[Float[np.ndarray, "_ 2"], ...]
    """For each plane, along the two axes within it."""
    residuals_m: tuple[Float[np.ndarray, " _"], ...]
    frames: tuple[Int[np.ndarray, " _"], ...] | None
    """Index of each point's frame, in the order of the ids; None without frame ids."""
    n_frames: int


def face_points(
    scan: Scan, frame: Frame, shape: Shape, config: AssociationConfig, max_points: int
) -> FacePoints:
    """Claim points for every plane.

    Args:
        scan: metres, scan frame.
        frame: fitted.
        shape: fitted.
        config: which points a plane may claim.
        max_points: at most this many are looked at, every k-th.
    """
    step = -(-scan.n_points // max_points)
    points_m = frame.to_manhattan(scan.points_m[::step])
    index, n_frames = None, 0
    if scan.frame_ids is not None:
        ids, index = np.unique(scan.frame_ids, return_inverse=True)
        index, n_frames = index[::step], len(ids)
    chosen = [indices for indices, _ in claims(points_m, shape, config)]
    places, residuals = [], []
    for plane, own in zip(shape.planes, chosen, strict=True):
        within = [axis for axis in range(3) if axis != plane.axis]
        own_m = plane.to_own(points_m[own])
        places.append(own_m[:, within])
        residuals.append(own_m[:, plane.axis] - plane.offset_m)
    frames = None if index is None else tuple(index[own] for own in chosen)
    return FacePoints(tuple(places), tuple(residuals), frames, n_frames)
