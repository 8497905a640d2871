"""What is seen along rays: nearest surface, its bows, glass and mirror images."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from .quads import Quads
from .raycast import Hits, cast
from .scene_build import BuiltScene
from .sensors import Sensor
from .surfaces import displacement_m, shade


@dataclass(frozen=True)
class Sight:
    """Truth along each ray."""

    distance_m: Float[np.ndarray, " rays"]
    """In lengths of the ray's direction; infinite where nothing is seen."""
    incidence_rad: Float[np.ndarray, " rays"]
    plane: Int[np.ndarray, " rays"]
    colours: Float[np.ndarray, "rays 3"]


def look(
    built: BuiltScene,
    sensor: Sensor,
    origin_m: Float[np.ndarray, " 3"],
    rays: Float[np.ndarray, "rays 3"],
    rng: np.random.Generator,
) -> Sight:
    """Follow rays from one origin to what the sensor would see.

    Args:
        built: the scene.
        sensor: only its behaviour at glass is used.
        origin_m: Manhattan frame.
        rays: directions, neighbours next to each other.
        rng: decides for each ray whether glass sends it back, mirrors it or lets it pass.
    """
    chance = rng.random(len(rays))
    opaque = built.quads.select(~built.quads.glass)
    glass = built.quads.select(built.quads.glass)
    sight = _seen(built, opaque, origin_m, rays, cast(opaque, origin_m, rays))
    if not glass.n:
        return sight
    panes = cast(glass, origin_m, rays)
    at_pane = panes.distance < sight.distance_m
    back = at_pane & (chance < sensor.glass_return)
    mirrored = at_pane & ~back & (chance < sensor.glass_return + sensor.glass_reflection)
    found = [sight.distance_m, sight.incidence_rad, sight.plane, sight.colours]
    if back.any():
        hits = Hits(panes.distance[back], panes.quad[back])
        _replace(found, back, _seen(built, glass, origin_m, rays[back], hits))
    for pane in np.unique(panes.quad[mirrored]):
        chosen = mirrored & (panes.quad == pane)
        ghost = _mirrored(built, opaque, glass, int(pane), origin_m, rays[chosen], panes.distance[chosen])
        _replace(found, chosen, ghost)
    return Sight(*found)


def _replace(found: list[np.ndarray], where: Bool[np.ndarray, " rays"], other: Sight) -> None:
    parts = (other.distance_m, other.incidence_rad, other.plane, other.colours)
    for target, values in zip(found, parts, strict=True):
        target[where] = values


def _mirrored(
    built: BuiltScene,
    opaque: Quads,
    glass: Quads,
    pane: int,
    origin_m: Float[np.ndarray, " 3"],
    rays: Float[np.ndarray, "rays 3"],
    pane_distance: Float[np.ndarray, " rays"],
) -> Sight:
    """What a pane mirrors: the scene seen from the mirror image of the sensor, beyond the pane."""
    normal = glass.normal[pane]
    image_m = origin_m - 2.0 * normal * (normal @ (origin_m - glass.corner_m[pane]))
    reflected = rays - 2.0 * (rays @ normal)[:, None] * normal
    hits = cast(opaque, image_m, reflected, nearest=pane_distance)
    ghost = _seen(built, opaque, image_m, reflected, hits)
    # Whatever plane it was, the sensor places it elsewhere.
    return Sight(ghost.distance_m, ghost.incidence_rad, np.full(len(rays), -1), ghost.colours)


def _seen(
    built: BuiltScene,
    quads: Quads,
    origin_m: Float[np.ndarray, " 3"],
    rays: Float[np.ndarray, "rays 3"],
    hits: Hits,
) -> Sight:
    """Distances on the displaced surfaces, incidence, planes and colours of hits."""
    hit = np.flatnonzero(hits.quad >= 0)
    quad, ray = hits.quad[hit], rays[hit]
    normal, surface = quads.normal[quad], quads.surface[quad]
    slope = np.einsum("ri,ri->r", normal, ray)
    distance = hits.distance.copy()
    colours = np.full((len(rays), 3), 200.0)
    # Sorting groups the rays by surface in one pass; 16 bits sort by counting.
    by_surface = np.argsort(surface.astype(np.int16), kind="stable")
    starts = np.flatnonzero(np.diff(surface[by_surface], prepend=-1))
    for here in np.split(by_surface, starts[1:]) if len(starts) else ():
        index = surface[here[0]]
        finish = built.surfaces[index]
        if not finish.is_flat:
            distance[hit[here]] = _on_displaced(
                built, int(index), origin_m, ray[here], hits.distance[hit[here]], slope[here]
            )
        points_m = origin_m + ray[here] * distance[hit[here], None]
        colours[hit[here]] = shade(finish, int(index), points_m)
    incidence = np.zeros(len(rays))
    incidence[hit] = np.arccos(np.clip(-slope / np.linalg.norm(ray, axis=1), 0.0, 1.0))
    plane = np.full(len(rays), -1)
    plane[hit] = quads.plane[quad]
    return Sight(distance, incidence, plane, colours)


def _on_displaced(
    built: BuiltScene,
    index: int,
    origin_m: Float[np.ndarray, " 3"],
    rays: Float[np.ndarray, "rays 3"],
    flat: Float[np.ndarray, " rays"],
    slope: Float[np.ndarray, " rays"],
) -> Float[np.ndarray, " rays"]:
    """Distance to a surface that bows out of its plane.

    The displacement changes by some millimetres per metre, so each turn gains two digits or more; ten
    reach rounding even at grazing incidence.
    """
    distance = flat
    # Limited slope: a ray along the wall would otherwise jump off to infinity.
    divisor = np.minimum(slope, -0.02)
    for _ in range(10):
        points_m = origin_m + rays * distance[:, None]
        distance = flat + displacement_m(built.surfaces[index], points_m) / divisor
    return distance
