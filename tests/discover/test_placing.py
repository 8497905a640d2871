"""Planes are put where the surfels are, and never beyond one another."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from indoorfit.discover.outline import Outline
from indoorfit.discover.placing import placed
from indoorfit.discover.surfaces import Surfaces
from indoorfit.geometry import passed, shape_from_plan
from synthetic import plans

PIXEL_M = 0.2


def surfaces_of(walls_m, floor_m, ceiling_m) -> Surfaces:
    nothing_m = np.zeros((0, 3))
    return Surfaces(
        walls_m=walls_m,
        wall_segments=(np.zeros(len(walls_m[0]), int), np.zeros(len(walls_m[1]), int)),
        stray_m=nothing_m,
        ceiling_m=ceiling_m,
        vault_m=nothing_m,
        floor_m=floor_m,
        floor_height_m=0.0,
        ceiling_height_m=2.5,
        pixel_m=PIXEL_M,
        noise_m=0.005,
        scatter_m=0.01,
    )


@given(plan=plans(), seed=st.integers(0, 1000))
@settings(deadline=None, max_examples=50)
def test_planes_keep_their_order_whatever_lies_between_them(plan, seed):
    """Surfels anywhere: those between two lines may be either wall's."""
    x, y, mask, z = plan
    shape = shape_from_plan(x, y, [mask], [z])
    rng = np.random.default_rng(seed)
    low_m, high_m = np.array([x[0], y[0], z[0]]) - 0.2, np.array([x[-1], y[-1], z[1]]) + 0.2
    everywhere = [rng.uniform(low_m, high_m, (2000, 3)) for _ in range(4)]
    surfaces = surfaces_of(tuple(everywhere[:2]), *everywhere[2:])
    found = placed(shape, surfaces, Outline((np.array(x), np.array(y)), [mask]))
    assert passed(shape, found) == []


def test_the_two_sides_of_a_narrow_step_do_not_share_their_surfels():
    """A step of 12 cm: both lines are within 10 cm of the surfels of one wall that lies between them."""
    mask = np.array([[True, False], [True, True]])
    x, y = [0.0, 2.0, 4.0], [0.0, 3.0, 3.12]
    shape = shape_from_plan(x, y, [mask], [(0.0, 2.5)])
    front, back = (
        next(k for k, plane in enumerate(shape.planes) if plane.axis == 1 and plane.offset_m == y_m)
        for y_m in (3.0, 3.12)
    )
    rng = np.random.default_rng(0)
    wall_m = np.column_stack(
        [rng.uniform(0, 4, 2000), rng.normal(3.08, 0.005, 2000), rng.uniform(0, 2.5, 2000)]
    )
    nothing_m = np.zeros((0, 3))
    surfaces = surfaces_of((nothing_m, wall_m), nothing_m, nothing_m)
    found = placed(shape, surfaces, Outline((np.array(x), np.array(y)), [mask]))
    # A thousand surfels of 5 mm: 0.2 mm.
    assert abs(found.planes[back].offset_m - 3.08) < 1e-3
    assert found.planes[front].offset_m == 3.0
    assert found.planes[front].status == "inferred"
