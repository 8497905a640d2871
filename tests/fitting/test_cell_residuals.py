"""Residuals of patches and their derivatives say what moving and turning the planes does."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from indoorfit.fitting import AssociationConfig, associate, build_cells
from indoorfit.fitting.residuals import with_inferred
from synthetic import virtual


@pytest.fixture(scope="module")
def fitted():
    scan = virtual("L", n_points=20_000)
    patches = associate(
        scan.frame.to_manhattan(scan.scan.points_m), scan.shape, AssociationConfig(), 0.15
    ).patches
    return scan.shape, patches, build_cells(patches, scan.shape)


def test_derivatives_are_those_of_the_signed_distance(fitted):
    shape, patches, cells = fitted
    axes = np.array([plane.axis for plane in shape.planes])[patches.plane]

    def distances(parameters):
        normals = Rotation.from_rotvec(parameters[:3]).as_matrix()[:, axes].T
        return np.sum(normals * patches.means_m, axis=1) - (shape.offsets_m + parameters[3:])[patches.plane]

    np.testing.assert_allclose(distances(np.zeros(cells.n_params)), cells.residuals_m, atol=1e-14)
    for k in range(cells.n_params):
        step = 1e-6 * np.eye(cells.n_params)[k]
        numeric = (distances(step) - distances(-step)) / 2e-6
        # Rounding 1e-16 * 5 m / 1e-6; the truncation is a thousandth of it.
        np.testing.assert_allclose(cells.design[:, k], numeric, atol=2e-9)


def test_planes_without_points_get_one_cell_of_the_given_width(fitted):
    shape, patches, cells = fitted
    keep = patches.plane != 4
    fewer = replace(
        patches,
        plane=patches.plane[keep],
        means_m=patches.means_m[keep],
        variances_m2=patches.variances_m2[keep],
        counts=patches.counts[keep],
    )
    extended = with_inferred(build_cells(fewer, shape), shape, 0.07)
    assert extended.plane.tolist()[-1] == 4
    assert len(extended.plane) == keep.sum() + 1
    assert extended.variances_m2[-1] == pytest.approx(0.07**2)
    np.testing.assert_array_equal(extended.design[-1], -np.eye(cells.n_params)[3 + 4])
    assert len(with_inferred(cells, shape, 0.07).plane) == len(cells.plane)
    planes = [replace(plane, doubt_m=0.24) for plane in shape.planes]
    guessed = with_inferred(build_cells(fewer, shape), replace(shape, planes=tuple(planes)), 0.07)
    assert guessed.variances_m2[-1] == pytest.approx(0.25**2), "it is off by both"


def test_an_oblique_wall_is_no_level_wherever_it_stands(fitted):
    """Before the middle of the cloud the coordinate along it is small, as the height is under a level's."""
    shape, _, cells = fitted
    axes = np.array([plane.axis for plane in shape.planes])[cells.plane]
    np.testing.assert_array_equal(cells.axes, axes)
    wall = int(np.flatnonzero(axes < 2)[0])
    own = cells.plane == cells.plane[wall]
    normals, design = np.eye(3)[axes], cells.design.copy()
    normals[own] = np.sqrt([0.5, 0.5, 0.0])
    design[own, 2] = 0.0
    turned = replace(cells, normals=normals, design=design)
    assert np.all(turned.axes[own] < 2)
    np.testing.assert_array_equal(turned.axes[~own], axes[~own])
