"""Levelling and turning: the Manhattan frame of a scan (thesis 4.2.2, without the manual picking)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from indoorfit.errors import InputError
from indoorfit.model import Frame, Note, Surfels

from .triad import dominant_triad
from .up import Up, UpChoice, choose_up, is_single_view, named_direction


@dataclass(frozen=True)
class OrientConfig:
    """How the Manhattan frame is found."""

    up: Up = "auto"
    """The up direction in the scan's own axes; `auto` decides by evidence."""
    min_support: float = 0.15
    """Least share of the surfaces that must follow three perpendicular directions. Random directions
    give 0.4 %, a sphere the same; furnished rooms give more than 50 %."""
    min_margin: float = 0.75
    """Below this lead of the chosen up direction over the next one a warning says that it is a guess."""


def orient(
    surfels: Surfels,
    origin_m: Float[np.ndarray, " 3"],
    config: OrientConfig,
    rng: np.random.Generator,
    yaw_rad: float | None = None,
) -> tuple[Frame, tuple[Note, ...]]:
    """Find gravity and the direction of the walls.

    Args:
        surfels: local planes, scan axes.
        origin_m: the cloud's centroid, scan frame; becomes the frame's origin.
        config: see `OrientConfig`.
        rng: for the proposals of directions.
        yaw_rad: direction of the frame's x axis, from the scan's x (y where x is up), counter-clockwise seen
            from above; None for the direction of the walls.

    Returns:
        the frame, x as near to the scan's x as the walls allow, z up; and what was uncertain.

    Raises:
        InputError: no three perpendicular directions, so not a Manhattan room.
    """
    weights = np.maximum(surfels.planarity - 0.5, 0.0)
    if not np.any(weights > 0):
        raise InputError(_not_a_room(0.0))
    triad, support = dominant_triad(surfels.normals, weights, rng)
    if support < config.min_support:
        raise InputError(_not_a_room(support))
    single_view = is_single_view(surfels.positions_m + origin_m)
    choice = choose_up(triad, surfels.positions_m, surfels.normals, config.up, single_view)
    rotation = _manhattan_axes(triad, choice.direction)
    if yaw_rad is not None:
        rotation = _turned_to(choice.direction, yaw_rad)
    return Frame(rotation, origin_m), _notes(choice, config, single_view)


def _not_a_room(support: float) -> str:
    return (
        f"orient: only {100 * support:.0f} % of the surfaces follow three perpendicular directions; "
        "a room's walls, floor and ceiling do. Fix: check that the file holds a room, and --unit."
    )


def _manhattan_axes(triad: Float[np.ndarray, "3 3"], up: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "3 3"]:
    """Rows x, y, z of the Manhattan frame in scan axes; of the four turns the one that turns least."""
    level = triad[np.abs(triad @ up) < 0.5]
    candidates = np.concatenate([level, -level])
    x_axis = candidates[np.argmax(candidates @ _reference(up))]
    return np.stack([x_axis, np.cross(up, x_axis), up])


def _turned_to(up: Float[np.ndarray, " 3"], yaw_rad: float) -> Float[np.ndarray, "3 3"]:
    """Rows x, y, z of the frame whose x axis is turned by a given angle from the scan's."""
    reference = _reference(up)
    ahead = reference - (reference @ up) * up
    ahead /= np.linalg.norm(ahead)
    x_axis = np.cos(yaw_rad) * ahead + np.sin(yaw_rad) * np.cross(up, ahead)
    return np.stack([x_axis, np.cross(up, x_axis), up])


def _reference(up: Float[np.ndarray, " 3"]) -> Float[np.ndarray, " 3"]:
    """The scan's own x tells which way is x; where up is along it, the scan's y does."""
    return named_direction("x") if abs(up[0]) < 0.7 else named_direction("y")


def _notes(choice: UpChoice, config: OrientConfig, single_view: bool) -> tuple[Note, ...]:
    if config.up != "auto":
        return ()
    if single_view:
        return (
            Note(
                "UP_UNCERTAIN",
                "The scan is one picture: up was taken from the way depth cameras are held, whose own y axis "
                "points down. Give --up if the camera was turned.",
            ),
        )
    if choice.margin >= config.min_margin:
        return ()
    other = ", ".join(f"{c:+.2f}" for c in choice.runner_up)
    return (
        Note(
            "UP_UNCERTAIN",
            f"The up direction is a guess: the direction ({other}) explains the scan almost as well "
            f"(lead {choice.margin:.2f}, sure from {config.min_margin:.2f}). Give --up if it is wrong.",
        ),
    )
