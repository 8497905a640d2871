"""The single steps of the procedure."""

import numpy as np
from scipy.spatial.transform import Rotation

from indoorfit.fitting.greedy import FittedPlane, GreedyConfig
from indoorfit.fitting.greedy.components import connected_segments
from indoorfit.fitting.greedy.first_cube import fit_unit_cube
from indoorfit.fitting.greedy.ransac import ransac_inliers, ransac_plane
from indoorfit.fitting.greedy.segment_points import segment_points
from indoorfit.fitting.greedy.selection import CLASS_SIDES, farthest_groups, wall_classes

ORIGIN = np.zeros(3)
ROUNDING_M = 1e-9  # float64 over some metres and a few hundred sums


def _plane(normal, centre_m) -> FittedPlane:
    return FittedPlane("", np.array(normal, float), np.array(centre_m, float), 10, 10, 0.0)


def test_unit_cube_is_brought_exactly_onto_exact_faces():
    rng = np.random.default_rng(0)
    rotation = Rotation.from_rotvec([0.03, -0.05, 0.08]).as_matrix()
    centre_m, size_m = np.array([0.3, -0.2, 0.1]), np.array([5.08, 3.2, 2.7])
    faces = {}
    for name, (axis, sign) in CLASS_SIDES.items():
        unit = rng.uniform(-0.5, 0.5, (40, 3))
        unit[:, axis] = 0.5 * sign
        faces[name] = (unit * size_m) @ rotation.T + centre_m
    cube = fit_unit_cube(faces)
    assert cube.converged
    # Solver: Levenberg-Marquardt stops at relative changes of 1e-8; on an exact zero it is far below.
    np.testing.assert_allclose(cube.rotation, rotation, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(cube.centre_m, centre_m, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(cube.size_m, size_m, rtol=0.0, atol=1e-7)


def test_ransac_separates_inliers_from_outliers():
    rng = np.random.default_rng(0)
    points_m = rng.uniform(-1.0, 1.0, (400, 3))
    points_m[:240, 2] = 0.5
    points_m[240:, 2] = np.where(points_m[240:, 2] > 0, 0.7, 0.3) + 0.05 * points_m[240:, 2]
    inliers = ransac_inliers(points_m, GreedyConfig(), rng)
    np.testing.assert_array_equal(np.flatnonzero(inliers), np.arange(240))


def test_ransac_plane_points_away_from_the_origin_in_use():
    rng = np.random.default_rng(0)
    points_m = rng.uniform(-1.0, 1.0, (100, 3)) * [1.0, 0.0, 1.0] + [0.0, 2.0, 0.0]
    for origin_m, sign in ((ORIGIN, 1.0), (np.array([0.0, 3.0, 0.0]), -1.0)):
        plane = ransac_plane("", points_m, origin_m, GreedyConfig(), rng)
        np.testing.assert_allclose(plane.normal, [0.0, sign, 0.0], rtol=0.0, atol=ROUNDING_M)
        assert plane.distance_m(origin_m) > 0.0


def test_farthest_groups_join_within_ten_centimetres_and_split_the_rest():
    planes = {k: _plane([1, 0, 0], [d, 0, 0]) for k, d in enumerate([2.0, 2.35, 2.42, 2.31, 1.95])}
    assert farthest_groups(planes, planes, ORIGIN, 0.10) == [(2, 1), (3,), (0, 4)]


def test_wall_classes_are_seen_from_the_components_own_origin():
    planes = {
        0: _plane([1, 0, 0], [4.7, 0, 0]),
        1: _plane([0, 1, 0.05], [0, 1.7, 0]),
        2: _plane([0, 0, 1], [0, 0, 1]),
    }
    assert wall_classes(planes, planes, ORIGIN, GreedyConfig()) == {"right": [0], "front": [1]}
    beyond_m = np.array([4.8, 2.0, 0.0])
    assert wall_classes(planes, planes, beyond_m, GreedyConfig()) == {"left": [0], "back": [1]}


def test_components_are_split_where_the_gap_exceeds_the_link():
    line_m = np.stack([np.arange(0.0, 1.0, 0.05), np.zeros(20), np.zeros(20)], axis=1)
    gaps_m = [0.0, 1.1, 2.4]
    surfels_m = np.concatenate([line_m + np.array([gap, 0.0, 0.0]) for gap in gaps_m])
    labels = np.repeat(np.arange(3), 20)
    cloud = segment_points(surfels_m, labels, surfels_m, labels, 3)
    assert connected_segments(cloud, [0, 1, 2], 0.20) == [(0, 1), (2,)]
    assert connected_segments(cloud, [0, 1, 2], 0.50) == [(0, 1, 2)]
    assert connected_segments(cloud, [], 0.20) == []
