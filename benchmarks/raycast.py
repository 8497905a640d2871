"""Rays and points per second of the virtual scanner in a furnished room.

Run ``python benchmarks/raycast.py``. The target is a million points a second on two cores, from the
scene to noisy, coloured points, with frames of 77 thousand rays.
"""

import time

import numpy as np

from indoorfit.simulate import (
    RandomSceneSettings,
    ScanSettings,
    build_scene,
    handheld_path,
    load_sensor,
    random_scene,
    regime,
    scan_frames,
)
from indoorfit.simulate.raycast import cast
from indoorfit.simulate.rays import bundle_order, directions, pixel_grid

N_FRAMES = 30


def main() -> None:
    """Print one line for the bare ray caster and one for whole frames."""
    rng = np.random.default_rng(0)
    scene = random_scene(rng, RandomSceneSettings(n_walls=10, n_furniture=8, bookcase=True))
    built = build_scene(scene)
    sensor = load_sensor("kinect_v1").thinned(2)
    path = handheld_path(scene, N_FRAMES, rng)
    rays = directions(sensor, pixel_grid(sensor)).reshape(-1, 3)[bundle_order(sensor)]
    start = time.perf_counter()
    for pose in path:
        cast(built.quads, pose.position_m, rays @ pose.R_manhattan_sensor.T)
    seconds = time.perf_counter() - start
    n_rays = N_FRAMES * sensor.n_rays
    print(f"cast     {built.quads.n} rectangles  {n_rays / seconds / 1e6:.2f} M rays/s, one thread")
    for threads in (1, 2):
        settings = ScanSettings(n_threads=threads)
        start = time.perf_counter()
        frames = scan_frames(built, sensor, path, regime("2cm"), np.random.default_rng(1), settings)
        n_points = sum(int(np.isfinite(frame.distance_m).sum()) for frame in frames)
        seconds = time.perf_counter() - start
        print(f"frames   {n_points / seconds / 1e6:.2f} M points/s, {threads} thread(s)")


if __name__ == "__main__":
    main()
