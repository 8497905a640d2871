"""Furniture as rectangles."""

import itertools

import numpy as np

from .quads import QuadList
from .scene import Furniture


def add_furniture(quads: QuadList, item: Furniture, surface: int) -> None:
    """Append all sides of one thing.

    Args:
        quads: where to append.
        item: what, where and how large.
        surface: its surface number; all parts share it.
    """
    length, width, height = item.size_m
    if item.kind in ("box", "cupboard"):
        _part(quads, item, (0.0, 0.0, 0.0), item.size_m, surface)
    elif item.kind == "bookcase":
        _bookcase(quads, item, surface)
    elif item.kind == "table":
        _table(quads, item, surface)
    elif item.kind == "chair":
        _chair(quads, item, surface)
    elif item.kind == "lamp":
        _part(quads, item, (0.0, 0.0, 0.0), (0.5 * length, 0.5 * width, 0.03), surface)
        _part(quads, item, (0.0, 0.0, 0.03), (0.03, 0.03, 0.75 * height), surface)
        _part(quads, item, (0.0, 0.0, 0.75 * height), (length, width, 0.25 * height), surface, bottom=True)
    elif item.kind == "pendant":
        # `base_m` is the lower rim of the shade; the cord reaches up to the ceiling.
        _part(quads, item, (0.0, 0.0, 0.25), (0.02, 0.02, max(height - 0.25, 0.01)), surface)
        _part(quads, item, (0.0, 0.0, 0.0), (length, width, 0.25), surface, bottom=True)
    else:
        _curtain(quads, item, surface)


def _part(
    quads: QuadList,
    item: Furniture,
    foot_m: tuple[float, float, float],
    size_m: tuple[float, float, float],
    surface: int,
    *,
    bottom: bool = False,
) -> None:
    """One upright box; `foot_m` is the middle of its base in the item's own axes."""
    c, s = np.cos(item.yaw_rad), np.sin(item.yaw_rad)
    x = item.centre_m[0] + c * foot_m[0] - s * foot_m[1]
    y = item.centre_m[1] + s * foot_m[0] + c * foot_m[1]
    centre = np.array([x, y, item.base_m + foot_m[2] + 0.5 * size_m[2]])
    # Things stand a hair above the floor, so that their foot and the floor never tie.
    quads.add_box(centre, np.array(size_m), item.yaw_rad, surface, bottom=bottom or item.base_m > 0.0)


def _table(quads: QuadList, item: Furniture, surface: int) -> None:
    length, width, height = item.size_m
    top_m, leg_m = 0.04, 0.06
    _part(quads, item, (0.0, 0.0, height - top_m), (length, width, top_m), surface, bottom=True)
    for sx in (-0.5, 0.5):
        for sy in (-0.5, 0.5):
            foot = (sx * (length - leg_m), sy * (width - leg_m), 0.0)
            _part(quads, item, foot, (leg_m, leg_m, height - top_m), surface)


def _chair(quads: QuadList, item: Furniture, surface: int) -> None:
    length, width, height = item.size_m
    seat_m, leg_m = 0.5 * height, 0.04
    _part(quads, item, (0.0, 0.0, seat_m - 0.04), (length, width, 0.04), surface, bottom=True)
    _part(quads, item, (0.0, 0.5 * (width - leg_m), seat_m), (length, leg_m, height - seat_m), surface)
    for sx in (-0.5, 0.5):
        for sy in (-0.5, 0.5):
            foot = (sx * (length - leg_m), sy * (width - leg_m), 0.0)
            _part(quads, item, foot, (leg_m, leg_m, seat_m - 0.04), surface)


def _bookcase(quads: QuadList, item: Furniture, surface: int) -> None:
    """A body 3 cm shallower than the boards that divide it: its front is not one plane, as with books."""
    length, width, height = item.size_m
    _part(quads, item, (0.0, 0.0, 0.0), (length, width - 0.06, height - 0.02), surface)
    n_boards = max(2, round(height / 0.35) + 1)
    for k in range(n_boards):
        z = k * (height - 0.02) / (n_boards - 1)
        _part(quads, item, (0.0, 0.0, z), (length, width, 0.02), surface, bottom=True)


def _curtain(quads: QuadList, item: Furniture, surface: int) -> None:
    """Folds of 12 cm, as deep as the item is wide, visible from both sides."""
    length, depth, height = item.size_m
    n_folds = max(2, 2 * round(length / 0.12))
    x = np.linspace(-0.5 * length, 0.5 * length, n_folds + 1)
    y = 0.5 * depth * (-1.0) ** np.arange(n_folds + 1)
    c, s = np.cos(item.yaw_rad), np.sin(item.yaw_rad)
    points = np.stack([item.centre_m[0] + c * x - s * y, item.centre_m[1] + s * x + c * y], axis=1)
    up = np.array([0.0, 0.0, height])
    for start, end in itertools.pairwise(points):
        edge = np.array([*(end - start), 0.0])
        across = np.cross(edge, up)
        for towards in (across, -across):
            quads.add(np.array([*start, item.base_m]), edge, up, towards, surface)
