"""Lines of sight are taken from the scan where it tells them all, and few of them are enough."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit.config import RunConfig
from indoorfit.fitting import BeliefConfig
from indoorfit.model import Scan
from indoorfit.pipeline import explain_scan, fit_scan
from indoorfit.pipeline.rays import rays_of, thinned
from indoorfit.simulate import RandomSceneSettings, random_scene
from indoorfit.simulate.path import handheld_path
from indoorfit.simulate.registration import Registration
from indoorfit.simulate.scanner import ScanSettings, virtual_scan
from indoorfit.simulate.sensors import load_sensor
from indoorfit.texture import TextureConfig


@pytest.fixture(scope="module")
def scan() -> Scan:
    """A small furnished room, from twelve places of a depth camera."""
    rng = np.random.default_rng(4)
    scene = random_scene(rng, RandomSceneSettings(n_walls=6, n_furniture=2, n_windows=1, n_doors=1))
    settings = ScanSettings(pixel_step=12, n_threads=1, yaw_rad=0.4)
    path = handheld_path(scene, 30, rng, "walk")
    made = virtual_scan(scene, load_sensor("kinect_v1"), path, Registration(), rng, settings).scan
    return replace(made, colours=None)


@pytest.fixture(scope="module")
def explained(scan):
    return explain_scan(scan)


def test_scans_that_do_not_tell_every_sensor_s_place_have_no_rays(scan, explained):
    frame = explained.frame
    assert rays_of(scan, frame) is not None
    for poor in (
        replace(scan, frames=()),
        replace(scan, frame_ids=None),
        replace(scan, frames=scan.frames[1:]),
    ):
        assert rays_of(poor, frame) is None


def test_without_sensor_positions_ids_change_nothing(scan):
    bare = explain_scan(replace(scan, frame_ids=None, frames=())).explanation
    with_ids = explain_scan(replace(scan, frames=())).explanation
    assert bare.evidence.free is None
    assert all(candidate.passed_m is None for candidate in bare.candidates)
    np.testing.assert_array_equal(bare.inside, with_ids.inside)
    np.testing.assert_array_equal(bare.log_odds, with_ids.log_odds)
    assert bare.energy_nats == with_ids.energy_nats


def test_the_order_of_points_and_of_frames_does_not_matter():
    rng = np.random.default_rng(2)
    origins_m, ends_m = rng.uniform(-1.0, 1.0, (30, 3)), rng.uniform(-3.0, 3.0, (50_000, 3))
    index = rng.integers(0, 30, len(ends_m))
    points, frames = rng.permutation(len(ends_m)), rng.permutation(30)
    first = thinned(origins_m, index, ends_m)
    second = thinned(origins_m[frames], np.argsort(frames)[index[points]], ends_m[points])
    told = [{tuple(row) for row in np.hstack([r.origins_m, r.ends_m]).tolist()} for r in (first, second)]
    assert told[0] == told[1]


def test_rays_are_few_and_the_shortest_of_their_neighbours():
    rng = np.random.default_rng(3)
    ends_m = rng.uniform(-5.0, 5.0, (200_000, 3))
    ends_m[0] = [0.01, 0.0, 0.0]
    rays = thinned(np.zeros((1, 3)), np.zeros(len(ends_m), int), ends_m)
    # The promise of the module.
    assert len(rays.ends_m) <= 60_000
    given = {tuple(end) for end in ends_m.tolist()}
    assert all(tuple(end) in given for end in rays.ends_m.tolist())
    assert ends_m[0].tolist() in rays.ends_m.tolist()


def test_more_frames_than_rays_are_thinned_too():
    # A trajectory with a pose for every return, as walking scanners write them.
    rng = np.random.default_rng(5)
    origins_m, ends_m = rng.uniform(-1.0, 1.0, (70_000, 3)), rng.uniform(-3.0, 3.0, (70_000, 3))
    rays = thinned(origins_m, np.arange(len(ends_m)), ends_m)
    assert len(rays.ends_m) == 60_000


def test_explanation_tells_what_was_looked_through(explained):
    found = explained.explanation
    assert found.evidence.free is not None
    passed = [c for c in found.candidates if c.passed_m > 0.5]
    assert passed, "some candidates of furniture in the middle of the room are looked through"
    assert any("lines of sight pass it on" in c.reason for c in passed if c.verdict == "refused")


def test_the_fit_uses_the_same_lines_of_sight(scan, explained):
    light = RunConfig(belief=BeliefConfig(use_frames=False), texture=TextureConfig(enabled=False))
    shape = fit_scan(scan, light).shape
    for axis in (0, 1):
        walls = {round(p.offset_m, 6) for p in shape.planes if p.axis == axis}
        accepted = [c for c in explained.explanation.candidates if c.axis == axis and c.verdict == "accepted"]
        assert len(accepted) == len(walls)
