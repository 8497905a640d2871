"""Surface growing finds the flat pieces of a room, each once."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from indoorfit.segment import SegmentConfig, grow_surfaces
from indoorfit.segment.growing import fit_plane
from synthetic import oriented, virtual


@pytest.fixture(scope="module")
def grown():
    _, local, _ = oriented(virtual("U", 1, n_points=40_000).scan)
    return local, grow_surfaces(local, SegmentConfig())


def test_segments_are_flat_and_large_ones_are_the_walls(grown):
    _, segments = grown
    # The U has 8 walls, floor and ceiling; its smallest wall has 2.7 x 1.4 m2.
    large = segments.areas_m2 > 1.5
    assert large.sum() == 10
    # Surfels average several points of 5 mm noise.
    assert segments.rms_m[large].max() < 0.005
    # Least squares over hundreds of surfels: a tenth of a degree.
    assert np.abs(segments.normals[large]).max(axis=1).min() > np.cos(np.deg2rad(0.5))


def test_normals_point_away_from_the_centroid_and_distances_fit(grown):
    _, segments = grown
    assert np.all(segments.distances_m >= 0)
    # Rounding.
    np.testing.assert_allclose(
        np.sum(segments.normals * segments.centres_m, axis=1), segments.distances_m, atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.norm(segments.normals, axis=1), 1.0, atol=1e-12)


def test_labels_count_every_segment_and_small_ones_are_left_out(grown):
    local, segments = grown
    assert segments.labels.min() >= -1
    sizes = np.bincount(segments.labels[segments.labels >= 0], minlength=segments.n_segments)
    assert sizes.min() >= SegmentConfig().min_surfels
    np.testing.assert_allclose(segments.areas_m2, sizes * local.area_m2, rtol=1e-12)


def test_segments_are_connected(grown):
    local, segments = grown
    for k in range(segments.n_segments):
        members = np.flatnonzero(segments.labels == k)
        reached, frontier = set(), [int(members[0])]
        own = set(members.tolist())
        edges = {int(m): [] for m in members}
        for m in members:
            for other in local.neighbours[m]:
                if int(other) in own:
                    # Growing goes along neighbour lists, which are not symmetric.
                    edges[int(m)].append(int(other))
                    edges[int(other)].append(int(m))
        while frontier:
            here = frontier.pop()
            if here not in reached:
                reached.add(here)
                frontier += edges[here]
        assert reached == own


def test_nothing_flat_gives_no_segment():
    _, local, _ = oriented(virtual("box", 2, n_points=20_000).scan)
    assert grow_surfaces(local, SegmentConfig(seed_planarity=1.0)).n_segments == 0


def test_plane_of_points_is_exact_and_turns_with_them():
    rng = np.random.default_rng(3)
    flat = rng.uniform(-1, 1, (50, 3)) * (2.0, 1.0, 0.0)
    turn = Rotation.from_rotvec([0.4, -0.8, 0.2]).as_matrix()
    normal, centre = fit_plane(flat @ turn.T + (1.0, 2.0, 3.0))
    # Rounding; the eigenvector of a zero eigenvalue is good to the square root of nothing here.
    np.testing.assert_allclose(np.abs(normal @ turn[:, 2]), 1.0, atol=1e-12)
    shift = np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(centre, (flat @ turn.T).mean(axis=0) + shift, atol=1e-12)
