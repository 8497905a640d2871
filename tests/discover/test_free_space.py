"""What lines of sight passed is no wall and no absence, and nothing beyond an opening counts."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit.discover.candidates import Lines
from indoorfit.discover.evidence import Evidence, FreeShares, gather_evidence
from indoorfit.discover.free_shares import free_shares
from indoorfit.discover.free_space import passages, trace
from indoorfit.discover.labelling import LabelConfig, cell_costs, plan_energy
from indoorfit.discover.passages import open_borders
from indoorfit.discover.rooms import RoomConfig, split_rooms
from indoorfit.discover.surfaces import Surfaces
from indoorfit.model import Rays

PITCH_M = 0.05
TOP_M = 2.6
X_M, Y_M = (0.0, 4.0), (0.0, 3.0)


def grid_of(a_m, b_m):
    """Places every 5 cm in a rectangle."""
    a, b = (np.arange(low + PITCH_M / 2, high, PITCH_M) for low, high in (a_m, b_m))
    return np.stack(np.meshgrid(a, b, indexing="ij"), axis=-1).reshape(-1, 2)


def upright(axis, offset_m, along_m, z_m):
    """Surfels of a wall."""
    at = grid_of(along_m, z_m)
    return np.insert(at, axis, offset_m, axis=1)


def level(z_m, x_m=X_M):
    """Surfels of a floor or a ceiling."""
    return np.insert(grid_of(x_m, Y_M), 2, z_m, axis=1)


def box(door: bool = False) -> tuple[Surfaces, tuple[Lines, Lines]]:
    """A room of 4 m x 3 m x 2.6 m; with a door of 1 m x 2 m in the wall x = 4 m, if wanted."""
    right = [upright(0, 4.0, Y_M, (0.0, TOP_M))]
    if door:
        right = [upright(0, 4.0, (0.0, 1.0), (0.0, TOP_M)), upright(0, 4.0, (2.0, 3.0), (0.0, TOP_M))]
        right.append(upright(0, 4.0, (1.0, 2.0), (2.0, TOP_M)))
    walls_x = [upright(0, 0.0, Y_M, (0.0, TOP_M)), np.concatenate(right)]
    walls_y = [upright(1, y_m, X_M, (0.0, TOP_M)) for y_m in Y_M]
    of_x, of_y = (np.repeat([0, 1], [len(w) for w in walls]) for walls in (walls_x, walls_y))
    surfaces = Surfaces(
        walls_m=(np.concatenate(walls_x), np.concatenate(walls_y)),
        wall_segments=(of_x, of_y),
        stray_m=np.zeros((0, 3)),
        ceiling_m=level(TOP_M),
        vault_m=np.zeros((0, 3)),
        floor_m=level(0.0),
        floor_height_m=0.0,
        ceiling_height_m=TOP_M,
        pixel_m=2.0 * PITCH_M,
        noise_m=0.005,
        scatter_m=0.005,
    )
    # A candidate in the middle of the room where nothing is.
    x_lines = Lines(np.array([0.0, 2.0, 4.0]), np.array([True, False, True]), 2 * of_x)
    return surfaces, (x_lines, Lines(np.array(Y_M), np.array([True, True]), of_y))


def without(surfaces, lines, gone):
    """The same with some surfels of the walls across x gone."""
    walls_m = (surfaces.walls_m[0][~gone], surfaces.walls_m[1])
    segments = (surfaces.wall_segments[0][~gone], surfaces.wall_segments[1])
    line = replace(lines[0], surfel_line=lines[0].surfel_line[~gone])
    return replace(surfaces, walls_m=walls_m, wall_segments=segments), (line, lines[1])


def looks(origin_m, ends_m) -> Rays:
    ends_m = np.asarray(ends_m, float)
    return Rays(np.tile(np.asarray(origin_m, float), (len(ends_m), 1)), ends_m)


def joined(*several: Rays) -> Rays:
    return Rays(*(np.concatenate([getattr(r, name) for r in several]) for name in ("origins_m", "ends_m")))


def looks_around(surfaces: Surfaces) -> Rays:
    """From two places in the room at everything that was seen."""
    seen_m = np.concatenate([*surfaces.walls_m, surfaces.ceiling_m, surfaces.floor_m])[::3]
    return joined(looks((1.0, 1.0, 1.5), seen_m), looks((3.0, 2.0, 1.5), seen_m))


def evidence_with(surfaces, lines, rays) -> Evidence:
    evidence = gather_evidence(surfaces, lines)
    return replace(evidence, free=free_shares(trace(rays, surfaces, lines), evidence, surfaces, lines))


def test_a_candidate_that_looks_pass_is_likelier_no_wall_and_seen_walls_stay():
    surfaces, lines = box()
    grid, config = (lines[0].offsets_m, lines[1].offsets_m), LabelConfig()
    before = plan_energy(gather_evidence(surfaces, lines), grid, 2.0, config)
    after = plan_energy(evidence_with(surfaces, lines, looks_around(surfaces)), grid, 2.0, config)
    # Odds of the band that counts 0.6 and of the rest, unseen as before; nearly all of the band was passed.
    assert after.borders[0][1, 0] > 1.5 * before.borders[0][1, 0] > 0.0
    np.testing.assert_array_equal(after.borders[0][[0, 2]], before.borders[0][[0, 2]])
    np.testing.assert_array_equal(after.borders[1], before.borders[1])


def test_a_look_passes_a_plane_only_if_it_goes_on_for_more_than_the_margin():
    ends_m = [(x_m, 1.5, 2.4) for x_m in (1.9, 2.0, 2.05, 2.3)]
    rays = looks((1.0, 1.5, 2.4), ends_m)
    assert len(passages(rays, np.ones(4), 0, 2.0, 0.1).height_m) == 1
    # It left the room before.
    assert len(passages(rays, np.full(4, 0.5), 0, 2.0, 0.1).height_m) == 0


def test_one_look_alone_tells_of_no_free_space():
    """It may end at an outlier; two that end at one place seldom do."""
    surfaces, lines = box()
    rng = np.random.default_rng(6)
    for end_m in zip(rng.uniform(2.0, 4.0, 20), rng.uniform(0.0, 3.0, 20), strict=True):
        look = looks((0.5, 1.5, 1.5), [(*end_m, 1.2)])
        assert len(trace(look, surfaces, lines).air_m) == 0
        assert len(trace(joined(look, look), surfaces, lines).air_m) > 0


def test_what_is_seen_under_a_lintel_is_no_free_space_of_the_room():
    surfaces, lines = box(door=True)
    beyond = upright(0, 6.0, (1.0, 2.0), (0.5, 2.0))
    surfaces = replace(surfaces, floor_m=np.concatenate([surfaces.floor_m, level(0.0, (4.0, 8.0))]))
    free = trace(looks((1.0, 1.5, 1.5), beyond), surfaces, lines)
    assert len(free.air_m) > 0
    assert free.air_m[:, 0].max() < 4.0 + surfaces.pixel_m
    # Without the lintel, the same looks go on.
    x_m, y_m, _ = surfaces.walls_m[0].T
    bare = without(surfaces, lines, (x_m == 4.0) & (y_m > 1.0) & (y_m < 2.0))
    assert trace(looks((1.0, 1.5, 1.5), beyond), *bare).air_m[:, 0].max() > 5.0


def test_what_is_seen_under_a_window_s_head_is_no_free_space_of_the_room():
    surfaces, lines = box()
    head_m = np.insert(grid_of((4.0, 4.3), (1.0, 2.0)), 2, 2.1, axis=1)
    x_m, y_m, _ = surfaces.walls_m[0].T
    surfaces, lines = without(surfaces, lines, (x_m == 4.0) & (y_m > 1.0) & (y_m < 2.0))
    surfaces = replace(
        surfaces,
        ceiling_m=np.concatenate([surfaces.ceiling_m, head_m]),
        floor_m=np.concatenate([surfaces.floor_m, level(0.0, (4.0, 8.0))]),
    )
    rays = looks((1.0, 1.5, 1.5), upright(0, 7.0, (1.2, 1.8), (1.0, 1.6)))
    assert trace(rays, surfaces, lines).air_m[:, 0].max() < 4.3


def test_who_stands_under_a_lowered_ceiling_looks_through_no_opening():
    surfaces, lines = box()
    low_m = surfaces.ceiling_m[:, 0] < 2.0
    surfaces = replace(surfaces, ceiling_m=surfaces.ceiling_m - [0.0, 0.0, 0.3] * low_m[:, None])
    free = trace(looks((1.0, 1.5, 1.5), upright(0, 4.0, (1.0, 2.0), (0.5, 2.0))), surfaces, lines)
    assert free.air_m[:, 0].max() > 3.5


def test_the_order_of_the_looks_does_not_matter():
    surfaces, lines = box(door=True)
    rays = looks_around(surfaces)
    order = np.random.default_rng(1).permutation(len(rays.ends_m))
    first = evidence_with(surfaces, lines, rays).free
    second = evidence_with(surfaces, lines, Rays(rays.origins_m[order], rays.ends_m[order])).free
    for name in ("overhead", "air"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    for name in ("walls", "over"):
        for a, b in zip(getattr(first, name), getattr(second, name), strict=True):
            np.testing.assert_array_equal(a, b)


def evidence_of(ceiling: float, floor: float, air: float | None, overhead: float = 0.0) -> Evidence:
    """One cell."""
    walls = (np.zeros((2, 1)), np.zeros((1, 2)))
    share = np.ones((1, 1))
    free = None if air is None else FreeShares(overhead * share, air * share, walls, walls)
    return Evidence(ceiling * share, floor * share, 0 * share, 2.5 * share, walls, walls, free)


def cost(evidence: Evidence) -> float:
    return float(cell_costs(evidence, np.ones((1, 1)), LabelConfig())[0, 0])


def test_floor_and_ceiling_that_were_not_seen_say_nothing_where_looks_passed():
    # A trace of ceiling: in a scan without any, a missing one never counts.
    unlooked, passed = (evidence_of(1e-12, 0.0, share, share) for share in (0.0, 1.0))
    # Odds of a square metre of unseen floor and ceiling.
    assert cost(unlooked) > 5.0
    assert cost(passed) == pytest.approx(0.0, abs=1e-9)


def test_nothing_passed_says_the_same_as_no_sensor_positions():
    for ceiling, floor in ((0.0, 0.0), (0.4, 0.9), (1.0, 0.2)):
        assert cost(evidence_of(ceiling, floor, 0.0)) == cost(evidence_of(ceiling, floor, None))


def test_floor_under_a_free_look_is_no_terrace_though_nobody_looked_up():
    shown = 0.05  # of the ceiling
    assert cost(evidence_of(shown, 1.0, 0.0)) > 0.0 > cost(evidence_of(shown, 1.0, 1.0))


def halves(walls: float, over: float, air: tuple[float, float]) -> Evidence:
    """Two cells of 9 m², walled all around; between them a border with wall and passes."""
    across_x, across_y = np.array([[1.0], [walls], [1.0]]), np.ones((2, 2))
    no_x, no_y, full = np.zeros((3, 1)), np.zeros((2, 2)), np.ones((2, 1))
    passed = np.array([[0.0], [over], [0.0]])
    free = FreeShares(full, np.array(air)[:, None], (no_x, no_y), (passed, no_y))
    return Evidence(full, full, 0 * full, 2.5 * full, (across_x, across_y), (no_x, no_y), free)


GRID = (np.array([0.0, 3.0, 6.0]), np.array([0.0, 3.0]))


def test_a_cupboard_that_looks_pass_above_parts_no_rooms():
    inside = np.ones((2, 1), bool)
    for over, is_open in ((0.0, False), (0.9, True)):
        links = open_borders(inside, halves(0.8, over, (1.0, 1.0)), GRID, 0.6, 1.5)
        assert links[0][0, 0] == is_open


def test_what_was_seen_through_openings_only_is_no_room():
    inside = np.ones((2, 1), bool)
    both = split_rooms(inside, halves(1.0, 0.0, (1.0, 0.9)), GRID, RoomConfig())
    one = split_rooms(inside, halves(1.0, 0.0, (0.0, 0.9)), GRID, RoomConfig())
    assert len(both) == 2
    assert [mask.ravel().tolist() for mask in one] == [[False, True]]
