"""A small coverage study: 24 rooms a regime, 95 % intervals, true labels.

Bounds are binomial: 24 rooms have some 100 dimensions, those of a room correlate, so that the effective
number is about 50; four standard errors at 95 % are then 12 %. The large study is
`benchmarks/uncertainty_cells.py`.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from cell_rooms import REGIMES, CellRoom, simulate_cell_room

from indoorfit.fitting.uncertainty import (
    PoseFieldConfig,
    Predictive,
    WallFieldConfig,
    cluster_robust,
    independent_points,
    pose_field_predictive,
    wall_field_predictive,
)

ROOMS = 24
LOWEST = 0.83


@cache
def rooms(name: str) -> tuple[CellRoom, ...]:
    return tuple(simulate_cell_room(seed, REGIMES[name]) for seed in range(500, 500 + ROOMS))


def coverage(name: str, answer) -> float:
    hits: list[bool] = []
    for k, room in enumerate(rooms(name)):
        low, high = answer(room, np.random.default_rng(k)).interval(0.95)
        hits.extend((low <= room.truth_m) & (room.truth_m <= high))
    return float(np.mean(hits))


def wall(room: CellRoom, rng: np.random.Generator):
    return wall_field_predictive(room.cells, room.contrasts, WallFieldConfig(), rng)


@cache
def pose_answers() -> tuple[tuple[CellRoom, Predictive], ...]:
    """Rooms with few frames, for the time."""
    small = [room for room in rooms("p20") if len(room.pose_errors) < 60][:6]
    return tuple(
        (
            room,
            pose_field_predictive(
                room.frame_cells, room.contrasts, PoseFieldConfig(), np.random.default_rng(k)
            )[0],
        )
        for k, room in enumerate(small)
    )


@pytest.mark.parametrize("name", ["p5", "p20real"])
def test_wall_field_intervals_hold_their_promise(name: str) -> None:
    assert coverage(name, wall) >= LOWEST


def test_pose_field_intervals_hold_their_promise() -> None:
    hits: list[bool] = []
    for room, answer in pose_answers():
        low, high = answer.interval(0.95)
        hits.extend((low <= room.truth_m) & (room.truth_m <= high))
    # Six rooms only: 25 dimensions, 15 effective, four standard errors of 5.6 %.
    assert np.mean(hits) >= 0.73


def test_frame_ids_halve_the_error_at_two_centimetres() -> None:
    pose_errors, wall_errors = [], []
    for k, (room, answer) in enumerate(pose_answers()):
        pose_errors.extend(answer.mean - room.truth_m)
        wall_errors.extend(wall(room, np.random.default_rng(k)).mean - room.truth_m)
    # Root mean squares are ruled by single rooms; the median error falls by four and more.
    assert np.median(np.abs(pose_errors)) < 0.5 * np.median(np.abs(wall_errors))


def test_independent_points_fail_as_they_must() -> None:
    assert coverage("p5", lambda room, _: independent_points(room.cells, room.contrasts)) < 0.25


def test_clusters_of_patches_fail_where_whole_walls_move() -> None:
    def patches(room: CellRoom, _: np.random.Generator):
        cells = room.cells
        return cluster_robust(cells, room.contrasts, np.arange(len(cells.plane)), np.sqrt(cells.counts))

    assert coverage("p20", patches) < 0.80


def test_cluster_robust_intervals_hold_for_independent_clusters() -> None:
    # Errors drawn per cluster of three cells, independent: what CR2 with Satterthwaite is made for.
    rng = np.random.default_rng(4)
    room = rooms("p0")[1]
    cells = room.cells
    clusters = np.arange(len(cells.plane)) // 3
    hits: list[bool] = []
    for _ in range(40):
        noise = 0.01 * rng.standard_normal(clusters.max() + 1)[clusters]
        noisy = replace(cells, residuals_m=noise)
        low, high = cluster_robust(noisy, room.contrasts, clusters, np.ones(len(clusters))).interval(0.9)
        hits.extend((low <= room.contrasts.values_m) & (room.contrasts.values_m <= high))
    # 40 draws of some 5 correlated dimensions: one standard error about 2.5 %, four of them either way.
    assert 0.80 <= np.mean(hits) <= 0.99
