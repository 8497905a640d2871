"""Levels of floor and ceiling are found, and what only looks like one is not."""

import numpy as np
import pytest

from indoorfit.model import Scan, Shape
from synthetic import discovered

SIZE_M = (5.0, 4.0, 2.7)
NOISE_M = 0.004
DENSITY = 2_500
"""Points per square metre: a surfel every 2 to 5 cm."""


def rectangle(rng, low, high) -> np.ndarray:
    """Points on an axis-aligned rectangle."""
    low, high = np.array(low, float), np.array(high, float)
    size = high - low
    flat = size == 0
    assert flat.sum() == 1
    n = int(np.prod(size[~flat]) * DENSITY)
    return low + rng.uniform(0, 1, (n, 3)) * size


def shell(rng) -> list[np.ndarray]:
    """The four walls of the box."""
    x, y, z = SIZE_M
    return [
        rectangle(rng, (0, 0, 0), (0, y, z)),
        rectangle(rng, (x, 0, 0), (x, y, z)),
        rectangle(rng, (0, 0, 0), (x, 0, z)),
        rectangle(rng, (0, y, 0), (x, y, z)),
    ]


def scanned(parts: list[np.ndarray], rng) -> tuple[Shape, list[str]]:
    points = np.vstack(parts)
    shape, notes = discovered(Scan(points + rng.normal(0, NOISE_M, points.shape)))
    return shape, [note.code for note in notes]


def levels_m(shape: Shape, outward: int) -> list[float]:
    """Heights above the lowest plane."""
    heights = [plane.offset_m for plane in shape.planes if plane.axis == 2]
    found = [plane.offset_m for plane in shape.planes if (plane.axis, plane.outward) == (2, outward)]
    return sorted(height - min(heights) for height in found)


def room(rng, *, floor=(), ceiling=(), without=None) -> list[np.ndarray]:
    """The box with more parts; a hole is left in floor or ceiling where `without` says (kind, low, high)."""
    x, y, z = SIZE_M
    parts = [*shell(rng), *floor, *ceiling]
    for kind, at in (("floor", 0.0), ("ceiling", z)):
        points = rectangle(rng, (0, 0, at), (x, y, at))
        if without is not None and without[0] == kind:
            inside = np.all((points[:, :2] > without[1]) & (points[:, :2] < without[2]), axis=1)
            points = points[~inside]
        parts.append(points)
    return parts


@pytest.mark.parametrize("rise_m", [0.1, 0.17, 0.35])
def test_a_platform_from_wall_to_wall_is_a_level_of_the_floor(rise_m):
    rng = np.random.default_rng(1)
    top = rectangle(rng, (0, 0, rise_m), (1.5, 4, rise_m))
    front = rectangle(rng, (1.5, 0, 0), (1.5, 4, rise_m))
    shape, notes = scanned(room(rng, floor=(top, front), without=("floor", (0, 0), (1.5, 4))), rng)
    assert [cube.role for cube in shape.cubes] == ["room", "step"]
    # Medians of thousands of surfels.
    assert levels_m(shape, -1) == pytest.approx([0.0, rise_m], abs=0.005)
    assert not notes


@pytest.mark.parametrize("side_seen", [True, False], ids=["sides-seen", "only-its-underside-seen"])
def test_a_beam_from_wall_to_wall_is_a_level_of_the_ceiling(side_seen):
    rng = np.random.default_rng(2)
    z = SIZE_M[2]
    parts = [rectangle(rng, (2, 0, z - 0.3), (2.3, 4, z - 0.3))]
    if side_seen:
        parts += [rectangle(rng, (x, 0, z - 0.3), (x, 4, z)) for x in (2.0, 2.3)]
    shape, notes = scanned(room(rng, ceiling=parts, without=("ceiling", (2, 0), (2.3, 4))), rng)
    assert [cube.role for cube in shape.cubes] == ["room", "beam"]
    assert levels_m(shape, 1) == pytest.approx([z - 0.3, z], abs=0.005)
    low, high = shape.bounds_m()[shape.cubes[1].id]
    # Its sides where they were seen; where not, where the underside ends, within a surfel's spacing.
    width_m = min(high[:2] - low[:2])
    assert width_m == pytest.approx(0.3, abs=0.01 if side_seen else 0.06)
    assert not notes


def test_a_lowered_corner_of_the_ceiling_is_a_step_if_its_sides_hang_from_the_ceiling():
    rng = np.random.default_rng(3)
    z = SIZE_M[2]
    low = rectangle(rng, (0, 0, z - 0.4), (2, 2, z - 0.4))
    sides = [rectangle(rng, (2, 0, z - 0.4), (2, 2, z)), rectangle(rng, (0, 2, z - 0.4), (2, 2, z))]
    hole = ("ceiling", (0, 0), (2, 2))
    shape, _ = scanned(room(rng, ceiling=(low, *sides), without=hole), rng)
    assert [cube.role for cube in shape.cubes] == ["room", "step"]
    free, notes = scanned(room(rng, ceiling=(low,), without=hole), rng)
    assert [cube.role for cube in free.cubes] == ["room"]
    assert notes == ["CEILING_STEP"]


def test_a_box_on_the_floor_is_furniture_whatever_it_hides():
    rng = np.random.default_rng(4)
    low, high = np.array((1.5, 1.5, 0.0)), np.array((3.5, 3.1, 0.36))
    top = rectangle(rng, (*low[:2], high[2]), high)
    sides = [
        rectangle(rng, low, (low[0], *high[1:])),
        rectangle(rng, (high[0], *low[1:]), high),
        rectangle(rng, low, (high[0], low[1], high[2])),
        rectangle(rng, (low[0], high[1], 0), high),
    ]
    shape, _ = scanned(room(rng, floor=(top, *sides), without=("floor", low[:2], high[:2])), rng)
    assert [cube.role for cube in shape.cubes] == ["room"]


def test_a_cupboard_top_below_a_ceiling_that_goes_on_is_no_lowered_ceiling():
    rng = np.random.default_rng(5)
    top = rectangle(rng, (0, 0, 2.2), (0.6, 4, 2.2))
    front = rectangle(rng, (0.6, 0, 0), (0.6, 4, 2.2))
    shape, _ = scanned(room(rng, ceiling=(top, front)), rng)
    assert len(levels_m(shape, 1)) == 1


def test_a_floor_that_slopes_has_no_steps():
    rng = np.random.default_rng(6)
    x, y, z = SIZE_M
    floor = rectangle(rng, (0, 0, 0), (x, y, 0))
    floor[:, 2] += 0.04 * (floor[:, 0] - 0.5 * x)
    shape, _ = scanned([*shell(rng), floor, rectangle(rng, (0, 0, z), (x, y, z))], rng)
    assert [cube.role for cube in shape.cubes] == ["room"]
