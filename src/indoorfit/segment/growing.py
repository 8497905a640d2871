"""Surface growing: flat, connected pieces of the cloud (Vosselman 2009; thesis 3.2.1)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from indoorfit.model import Segments, Surfels


@dataclass(frozen=True)
class SegmentConfig:
    """When a surfel belongs to a growing surface."""

    distance_sigmas: float = 3.0
    """Largest distance to the surface's plane, in local noise levels: 99.7 % of a Gaussian."""
    angle_deg: float = 20.0
    """Largest angle between the surfel's normal and the plane's, degrees. Normals of the noisiest sensor
    spread by 3 to 6 degrees; the next Manhattan direction is 90 away."""
    seed_planarity: float = 0.8
    """Least planarity of a seed, 0 to 1."""
    min_surfels: int = 12
    """Smaller pieces are no surface: half of one neighbourhood."""


def grow_surfaces(surfels: Surfels, config: SegmentConfig) -> Segments:
    """Split the surfels into planar segments.

    A seed's local plane is grown over neighbouring surfels that lie within the local noise of it and
    face the same way, and is fitted anew whenever the piece has doubled.

    Args:
        surfels: local planes, in any frame whose origin is the centroid.
        config: see `SegmentConfig`.

    Returns:
        segments in the order in which they were seeded (flattest first), normals pointing away from
        the centroid, distances >= 0.
    """
    noise_m = _local_noise(surfels)
    growth = _Growth(surfels, config.distance_sigmas * noise_m, np.cos(np.deg2rad(config.angle_deg)))
    flat = np.flatnonzero(surfels.planarity >= config.seed_planarity)
    n_segments = 0
    for seed in flat[np.argsort(surfels.roughness_m[flat], kind="stable")]:
        if growth.labels[seed] == -1:
            members = growth.grow(int(seed), n_segments)
            if len(members) >= config.min_surfels:
                n_segments += 1
            else:
                # Marked apart from "untouched", so that the remains do not seed one after the other.
                growth.labels[members] = -2
    return _summarise(surfels, np.maximum(growth.labels, -1), n_segments)


def _local_noise(surfels: Surfels) -> Float[np.ndarray, " surfels"]:
    """Noise level per surfel: the lower quartile of its neighbours' roughness, which edges do not raise."""
    rough_m = np.sort(surfels.roughness_m[surfels.neighbours], axis=1)
    # A tenth of a millimetre keeps exact synthetic planes from having a tolerance of nothing.
    return np.maximum(rough_m[:, rough_m.shape[1] // 4], 1e-4)


class _Growth:
    """Labels in the making; one region is grown at a time."""

    def __init__(self, surfels: Surfels, reach_m: Float[np.ndarray, " surfels"], min_cosine: float):
        self.surfels = surfels
        self.reach_m = reach_m
        self.min_cosine = min_cosine
        self.labels = np.full(len(surfels.positions_m), -1)

    def grow(self, seed: int, label: int) -> Int[np.ndarray, " members"]:
        """Grow one region from its seed until no neighbour fits; returns its members."""
        positions_m = self.surfels.positions_m
        normal, centre_m = self.surfels.normals[seed], positions_m[seed]
        frontier = np.array([seed])
        self.labels[seed] = label
        members = [frontier]
        size, next_fit = 1, 12
        while len(frontier):
            near = self.surfels.neighbours[frontier].ravel()
            near = np.unique(near[self.labels[near] == -1])
            fits = np.abs((positions_m[near] - centre_m) @ normal) < self.reach_m[near]
            fits &= np.abs(self.surfels.normals[near] @ normal) > self.min_cosine
            frontier = near[fits]
            self.labels[frontier] = label
            members.append(frontier)
            size += len(frontier)
            if size >= next_fit:
                normal, centre_m = fit_plane(positions_m[np.concatenate(members)])
                next_fit = 2 * size
        return np.concatenate(members)


def fit_plane(
    points_m: Float[np.ndarray, "points 3"],
) -> tuple[Float[np.ndarray, " 3"], Float[np.ndarray, " 3"]]:
    """Unit normal and centre of the least squares plane."""
    centre_m = points_m.mean(axis=0)
    centred = points_m - centre_m
    _, axes = np.linalg.eigh(centred.T @ centred)
    return axes[:, 0], centre_m


def _summarise(surfels: Surfels, labels: Int[np.ndarray, " surfels"], n_segments: int) -> Segments:
    normals, centres_m = np.zeros((n_segments, 3)), np.zeros((n_segments, 3))
    distances_m = np.zeros(n_segments)
    areas_m2, rms_m = np.zeros(n_segments), np.zeros(n_segments)
    order = np.argsort(labels, kind="stable")
    starts = np.searchsorted(labels[order], np.arange(n_segments + 1))
    for k in range(n_segments):
        members = surfels.positions_m[order[starts[k] : starts[k + 1]]]
        normal, centre_m = fit_plane(members)
        outward = 1.0 if normal @ centre_m >= 0 else -1.0
        normals[k], centres_m[k], distances_m[k] = outward * normal, centre_m, abs(normal @ centre_m)
        areas_m2[k] = surfels.area_m2 * len(members)
        rms_m[k] = np.sqrt(np.mean(np.square((members - centre_m) @ normal)))
    return Segments(labels, normals, distances_m, centres_m, areas_m2, rms_m)
