"""Simulated rooms run through the front end, and the comparison of a shape with the truth."""

from dataclasses import dataclass, replace

import numpy as np

from indoorfit.classify import ClassifyConfig, classify
from indoorfit.fitting.greedy import GreedyConfig, GreedyFit, fit_greedy
from indoorfit.geometry import exposures
from indoorfit.model import FaceClass, Frame, Scan, Segments, Shape, Surfels
from indoorfit.segment import SegmentConfig, grow_surfaces
from indoorfit.simulate import SamplingSettings, VirtualScan, room_shape, sample_surface
from indoorfit.thin import SurfelConfig, ThinConfig, surfels, thin

SIGMA_M = 0.005
N_POINTS = 60_000


@dataclass(frozen=True)
class FrontEnd:
    """Everything that `fit_greedy` is handed."""

    scan: Scan
    frame: Frame
    surfels: Surfels
    segments: Segments
    classes: tuple[FaceClass | None, ...]
    point_surfel: np.ndarray

    def fit(self, config: GreedyConfig | None = None, seed: int = 0) -> GreedyFit:
        return fit_greedy(
            self.scan,
            self.frame,
            self.surfels,
            self.segments,
            self.classes,
            self.point_surfel,
            config or GreedyConfig(),
            np.random.default_rng(seed),
        )


def front_end(scan: Scan, R_manhattan_scan: np.ndarray) -> FrontEnd:
    """Thin, segment and classify in a given frame: finding the frame is not what is tested."""
    cloud = thin(scan, ThinConfig(voxel_m=0.06))
    found = surfels(cloud, SurfelConfig())
    found = replace(
        found,
        positions_m=found.positions_m @ R_manhattan_scan.T,
        normals=found.normals @ R_manhattan_scan.T,
    )
    segments = grow_surfaces(found, SegmentConfig())
    classes = classify(segments, ClassifyConfig())
    return FrontEnd(
        scan, Frame(R_manhattan_scan, cloud.origin_m), found, segments, classes, cloud.point_voxel
    )


def scan_of(shape: Shape, seed: int = 0, **settings) -> VirtualScan:
    """A scan of a room with the thesis' 0.5 cm noise, axes one degree off, and its truth."""
    values = {"n_points": N_POINTS, "sigma_m": SIGMA_M, "yaw_rad": 0.017, "tilt_rad": 0.01} | settings
    return sample_surface(shape, SamplingSettings(**values), np.random.default_rng(seed))


def scanned(shape: Shape, **settings) -> Scan:
    """The scan alone."""
    return scan_of(shape, **settings).scan


def preset(kind: str, **settings) -> tuple[Shape, FrontEnd]:
    shape = room_shape(kind)
    return shape, front_end(scanned(shape, **settings), np.eye(3))


def visible_offsets(shape: Shape) -> dict[tuple[int, int], np.ndarray]:
    """Sorted offsets of the visible planes by axis and outward direction, the lowest one at 0 per axis."""
    areas_m2 = {exposure.plane: exposure.area_m2 for exposure in exposures(shape)}
    found: dict[tuple[int, int], list[float]] = {}
    for k, plane in enumerate(shape.planes):
        if areas_m2[k] > 0.0:
            found.setdefault((plane.axis, plane.outward), []).append(plane.offset_m)
    lowest = {axis: min(min(v) for key, v in found.items() if key[0] == axis) for axis in range(3)}
    return {key: np.sort(values) - lowest[key[0]] for key, values in found.items()}


def assert_same_rooms(found: Shape, expected: Shape, atol_m: float) -> None:
    """The same visible planes, each within `atol_m`."""
    a, b = visible_offsets(found), visible_offsets(expected)
    assert {key: len(v) for key, v in a.items()} == {key: len(v) for key, v in b.items()}
    for key, values in b.items():
        np.testing.assert_allclose(a[key], values, rtol=0.0, atol=atol_m)
