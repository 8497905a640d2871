"""The ray caster finds what brute force finds, on the surface itself."""

import numpy as np

from indoorfit.simulate import RandomSceneSettings, build_scene, random_scene
from indoorfit.simulate.raycast import cast


def brute_force(quads, origin_m, ray):
    """Nearest front hit of a single ray, by a loop over all rectangles."""
    best, which = np.inf, -1
    for k in range(quads.n):
        slope = quads.normal[k] @ ray
        if slope >= 0.0:
            continue
        t = quads.normal[k] @ (quads.corner_m[k] - origin_m) / slope
        inside_m = origin_m + t * ray - quads.corner_m[k]
        u, v = inside_m @ quads.along[k], inside_m @ quads.across[k]
        if 0.0 < t < best and 0.0 <= u <= quads.size_m[k, 0] and 0.0 <= v <= quads.size_m[k, 1]:
            best, which = t, k
    return best, which


def test_cast_agrees_with_brute_force_in_every_direction():
    rng = np.random.default_rng(3)
    scene = random_scene(rng, RandomSceneSettings(n_walls=10, n_furniture=8, oblique=True))
    quads = build_scene(scene).quads
    room = scene.rooms[0]
    origin_m = np.array([np.mean(room.x_lines_m[:2]), np.mean(room.y_lines_m[-2:]), 1.4])
    # Neither sorted nor of unit length: the culling must not rely on either.
    rays = rng.normal(size=(3000, 3)) * rng.uniform(0.1, 5.0, (3000, 1))
    narrow = np.array([0.6, 0.5, -0.1]) + 0.2 * rng.normal(size=(3000, 3))
    for bundle in (rays, narrow):
        hits = cast(quads, origin_m, bundle)
        for k in range(0, len(bundle), 20):
            t, which = brute_force(quads, origin_m, bundle[k])
            assert hits.quad[k] == which
            if which >= 0:
                # Rounding of a few products of order 10.
                assert abs(hits.distance[k] - t) < 1e-12 * max(1.0, t)


def test_cast_ignores_hits_before_the_nearest_allowed():
    quads = build_scene(random_scene(np.random.default_rng(0), RandomSceneSettings(n_walls=4))).quads
    origin_m, rays = np.array([1.5, 1.5, 1.2]), np.array([[0.0, 0.0, 1.0]])
    first = cast(quads, origin_m, rays)
    beyond = cast(quads, origin_m, rays, nearest=first.distance + 1e-6)
    assert beyond.distance[0] > first.distance[0]


def test_rays_that_leave_the_scene_hit_nothing():
    quads = build_scene(random_scene(np.random.default_rng(0), RandomSceneSettings(n_walls=4))).quads
    hits = cast(quads, np.array([0.0, 0.0, 100.0]), np.array([[0.0, 0.1, 1.0], [0.1, 0.0, 1.0]]))
    assert (hits.quad == -1).all()
    assert np.isinf(hits.distance).all()
