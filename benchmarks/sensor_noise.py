"""Noise of simulated sensors against their laws, and size of the registration errors.

    python benchmarks/sensor_noise.py

First table: for each sensor and distance the law, the standard deviation that a simulated wall shows, and the
difference, which must be within 5 %. The wall is scanned as any scene is, ray by ray; only the middle of the
image is taken, where the law (for normal incidence) applies. The range limit and the systematic bowl are off,
so that every sensor has a figure at 5 m. Second table: RMS of the position errors along each axis and of the
rotation errors, for each regime. Exit code 1 if anything is out of bounds.
"""

import sys
from dataclasses import replace

import numpy as np

from indoorfit.simulate import (
    SENSOR_PRESETS,
    RoomPlan,
    Scene,
    Sensor,
    build_scene,
    load_sensor,
    looking,
    pose_errors,
    regime,
    scan_frames,
)
from indoorfit.simulate.path import Pose

DISTANCES_M = (1.0, 2.0, 3.0, 4.0, 5.0)
BOUND = 0.05
N_FRAMES = 80
"""Each a little nearer or farther: rounding makes the spread at one exact depth depend on the depth."""
REGIMES = ("5mm", "2cm", "5cm")


def main() -> None:
    """Print both tables."""
    ok = True
    print(f"{'sensor':12} {'distance m':>10} {'law mm':>8} {'found mm':>9} {'difference':>11}")
    for name in SENSOR_PRESETS:
        sensor = replace(load_sensor(name), bowl_m=0.0, max_m=99.0)
        for distance_m in DISTANCES_M:
            law_m = float(sensor.law_m(np.array([distance_m]))[0])
            found_m = spread_m(sensor, distance_m, np.random.default_rng(0))
            difference = found_m / law_m - 1.0
            ok &= abs(difference) <= BOUND
            figures = f"{1e3 * law_m:8.2f} {1e3 * found_m:9.2f} {100 * difference:+10.1f}%"
            print(f"{name:12} {distance_m:10.1f} {figures}")
    print()
    print(
        f"{'regime':12} {'asked mm':>10} {'found mm':>8} {'found mrad':>11}   (90 frames, mean of 20 draws)"
    )
    for name in REGIMES:
        registration = regime(name)
        draws = [pose_errors(registration, 90, np.random.default_rng(seed)) for seed in range(20)]
        rms_m = np.sqrt(np.mean([draw.translation_m**2 for draw in draws]))
        rms_rad = np.sqrt(np.mean([draw.rotation_rad**2 for draw in draws]))
        # Each draw is scaled to the size asked for: rounding only.
        ok &= abs(rms_m / registration.rms_m - 1.0) < 1e-9
        print(f"{name:12} {1e3 * registration.rms_m:10.1f} {1e3 * rms_m:8.3f} {1e3 * rms_rad:11.3f}")
    sys.exit(0 if ok else 1)


def spread_m(sensor: Sensor, distance_m: float, rng: np.random.Generator) -> float:
    """Standard deviation of depths (ranges, for a scanner) from a wall straight ahead."""
    built = build_scene(Scene((RoomPlan((0.0, 12.0), (-9.0, 9.0), ("#",), 0.0, 6.0),)))
    used = narrowed(sensor)
    path = []
    for share in np.linspace(-0.005, 0.005, N_FRAMES if sensor.correlation_pixels == 0.0 else 4 * N_FRAMES):
        position_m = np.array([12.0 - distance_m * (1.0 + share), 0.0, 3.0])
        # A scanner's own x axis looks along the room's.
        scanner = Pose(position_m, np.eye(3))
        path.append(scanner if sensor.kind == "scanner" else looking(position_m, 0.0, 0.0))
    # Two scans of the same wall, the second without errors: their difference is the noise, whatever the
    # angle of the ray.
    noisy = scan_frames(built, used, tuple(path), regime("0"), rng)
    exact = scan_frames(built, used.exact(), tuple(path), regime("0"), rng)
    residuals_m = []
    for found, true in zip(noisy, exact, strict=True):
        rows = level_rows(used)
        difference_m = (found.distance_m - true.distance_m)[rows]
        residuals_m.append(difference_m[np.isfinite(difference_m)])
    return float(np.std(np.concatenate(residuals_m)))


def narrowed(sensor: Sensor) -> Sensor:
    """The middle of the image, some 5 degrees to each side: the laws are for normal incidence."""
    if sensor.kind == "scanner":
        # From azimuth 0 on; elevations cannot be left out at the top.
        columns = sensor.columns // 90
        return replace(sensor, columns=columns, width_rad=sensor.width_rad * columns / sensor.columns)
    fx, fy = sensor.focal_pixels
    columns, rows = round(0.18 * fx), round(0.18 * fy)
    width_rad, height_rad = 2.0 * np.arctan(0.5 * columns / fx), 2.0 * np.arctan(0.5 * rows / fy)
    return replace(sensor, columns=columns, rows=rows, width_rad=width_rad, height_rad=height_rad)


def level_rows(sensor: Sensor) -> slice:
    """All rows of a camera; those within 4 degrees of the horizon of a scanner."""
    if sensor.kind == "camera":
        return slice(None)
    per_rad = sensor.rows / sensor.height_rad
    return slice(round((0.5 * np.pi - 0.07) * per_rad), round((0.5 * np.pi + 0.07) * per_rad))


if __name__ == "__main__":
    main()
