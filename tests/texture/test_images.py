"""Textures from posed images: what is hidden stays off the wall, exposures agree, detail survives."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit.io import read_posed_images
from indoorfit.model import Camera, CameraImage
from indoorfit.pipeline import truth_result
from indoorfit.simulate import (
    Finish,
    Furniture,
    ScanSettings,
    Scene,
    assemble_scan,
    build_scene,
    load_sensor,
    looking,
    plane_colours,
    recorded_rgbd,
    regime,
    room_plans,
    room_shape,
    scan_frames,
)
from indoorfit.texture import TextureConfig, texture_from_images, texture_from_points
from indoorfit.texture.canvas import canvas_of
from indoorfit.texture.exposure import balance
from indoorfit.texture.sampling import bilinear, sampled, sharpness

CONFIG = TextureConfig(image_pixel_m=0.01, pixel_m=0.01)
RED = (255, 0, 0)


def towards(eye, at):
    """A camera at one place that looks at another."""
    way = np.subtract(at, eye)
    pitch_rad = np.arctan2(way[2], np.hypot(way[0], way[1]))
    return looking(np.array(eye), float(np.arctan2(way[1], way[0])), float(pitch_rad))


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """A box room with a mosaic on every face and a red cupboard, filmed from six places; images on disk."""
    scene = Scene(
        room_plans(room_shape("box", length_m=3.0, width_m=2.5, height_m=2.4)),
        finishes=(Finish(texture="mosaic"),),
        furniture=(Furniture("cupboard", (1.5, 0.5), (0.7, 0.4, 1.2), colour=RED),),
    )
    built = build_scene(scene)
    # What the scan has no points of cannot hide anything: here the cupboard's top is seen at a slant as well.
    sensor = replace(load_sensor("kinect_v1").exact(), max_incidence_rad=1.5)
    # The walls at x = 0 and x = 3 and behind the cupboard, from both sides of it.
    path = tuple(
        towards(eye, at)
        for eye, at in (
            ((1.5, 2.2, 1.3), (1.5, 0.0, 1.0)),
            ((0.5, 2.2, 1.5), (1.5, 0.0, 1.0)),
            ((2.5, 2.2, 1.5), (1.5, 0.0, 1.0)),
            ((2.6, 1.2, 1.2), (0.0, 1.2, 1.2)),
            ((0.4, 1.2, 1.2), (3.0, 1.2, 1.2)),
            ((1.5, 1.4, 2.2), (1.5, 1.5, 0.0)),
        )
    )
    folder = tmp_path_factory.mktemp("filmed")
    settings = ScanSettings(yaw_rad=0.5, tilt_rad=0.1, translation_m=(4e5, 5e6, 30.0))
    still, rng = regime("0"), np.random.default_rng(0)
    # Images at the full resolution, the cloud with every fourth row and column: as clouds are thinned.
    for _ in recorded_rgbd(folder, scan_frames(built, sensor, path, still, rng, settings), sensor):
        pass
    thin = sensor.thinned(4)
    frames = scan_frames(built, thin, path, still, np.random.default_rng(0), settings)
    virtual = assemble_scan(built, thin, frames, still, settings)
    return built, virtual, truth_result(virtual.shape, virtual.frame, {}, 0, virtual), folder


def errors(built, result, texture):
    """Squared error of each pixel against the true texture, averaged over the pixel; NaN in gaps."""
    face = result.face(texture.face)
    canvas = canvas_of(face, result.frame, texture.pixel_m, 8192)
    at = canvas.positions_m(np.ones((canvas.rows, canvas.columns), bool))
    truth = np.zeros((len(at), 3))
    steps = texture.pixel_m * (np.arange(3) - 1.0) / 3.0
    for dx in steps:
        for dy in steps:
            moved = result.frame.to_manhattan(at + dx * canvas.right + dy * canvas.down)
            truth += plane_colours(built, face.plane, moved) / 9.0
    squared = ((texture.rgba[..., :3] - truth.reshape(canvas.rows, canvas.columns, 3)) ** 2).mean(axis=2)
    return np.where(texture.rgba[..., 3] > 0, squared, np.nan)


def psnr_db(squared):
    return 10.0 * np.log10(255.0**2 / np.nanmean(squared))


def by_face(textures):
    return {texture.face: texture for texture in textures}


@pytest.fixture(scope="module")
def painted(filmed):
    _, virtual, result, folder = filmed
    return by_face(texture_from_images(result, virtual.scan, read_posed_images(folder), CONFIG))


def test_images_are_sharper_than_points(filmed, painted):
    built, virtual, result, _ = filmed
    points = by_face(texture_from_points(result, virtual.scan, CONFIG))
    both = []
    for face in painted.keys() & points.keys():
        a, b = (errors(built, result, textures[face]) for textures in (painted, points))
        both.append(np.stack([a, b])[:, np.isfinite(a) & np.isfinite(b)])
    from_images, from_points = np.concatenate(both, axis=1)
    # Four times as many pixels in each direction as points.
    assert psnr_db(from_images) > psnr_db(from_points) + 3.0


def test_furniture_stays_off_the_wall_and_the_floor(painted):
    for texture in painted.values():
        seen = texture.rgba[texture.rgba[..., 3] > 0].astype(int)
        red = (seen[:, 0] > 200) & (seen[:, 1:3].max(axis=1) < 40)
        assert red.mean() < 2e-4, texture.face


def test_images_hit_the_wall_where_they_should(filmed, painted):
    """A shift by one pixel in any direction fits the truth worse."""
    built, _, result, _ = filmed
    texture = max(painted.values(), key=lambda t: t.seen)
    here = psnr_db(errors(built, result, texture))
    for shift in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        moved = replace(texture, rgba=np.roll(texture.rgba, shift, axis=(0, 1)))
        assert psnr_db(errors(built, result, moved)) < here - 1.0


def test_images_whose_poses_err_are_moved_together(filmed, painted):
    """Every image twice, with poses that err by 8 mm either way: the right place is in the middle."""
    built, virtual, result, folder = filmed
    rng = np.random.default_rng(3)
    images = []
    for image in read_posed_images(folder):
        slip_m = rng.standard_normal(3)
        slip_m *= 0.008 / np.linalg.norm(slip_m)
        images += [replace(image, position_m=image.position_m + sign * slip_m) for sign in (1.0, -1.0)]
    aligned, still = (
        by_face(texture_from_images(result, virtual.scan, images, replace(CONFIG, align=align)))
        for align in (True, False)
    )
    scores_db = []
    for textures in (painted, aligned, still):
        squared = np.concatenate([errors(built, result, textures[f]).ravel() for f in painted])
        scores_db.append(psnr_db(squared))
    exact_db, aligned_db, still_db = scores_db
    # What doubled edges cost is won back for the better part.
    assert aligned_db > 0.5 * (exact_db + still_db)
    assert exact_db > still_db + 1.0


def with_gains(image: CameraImage, gain: np.ndarray) -> CameraImage:
    pixels = np.clip(image.load() * gain, 0, 255).round().astype(np.uint8)
    return replace(image, load=lambda: pixels)


def test_exposures_are_balanced(filmed, painted):
    _, virtual, result, folder = filmed
    # Darker only: what is cut off at 255 cannot come back.
    gains = np.random.default_rng(1).uniform(0.6, 1.0, (6, 1)) * np.ones((6, 3))
    images = [with_gains(i, g) for i, g in zip(read_posed_images(folder), gains, strict=True)]
    balanced, left = (
        by_face(texture_from_images(result, virtual.scan, images, replace(CONFIG, exposure=on)))
        for on in (True, False)
    )
    spread = {}
    for name, textures in (("balanced", balanced), ("left", left)):
        means = [(t.rgba[..., :3].mean(), painted[face].rgba[..., :3].mean()) for face, t in textures.items()]
        spread[name] = np.std([np.log(now / before) for now, before in means])
    # Gains of 0.6 to 1 have a standard deviation of 0.15 in the logarithm.
    assert spread["balanced"] < 0.02
    assert spread["left"] > 0.04


def test_balance_finds_gains_along_a_chain_and_ignores_glare():
    rng = np.random.default_rng(0)
    truth = rng.uniform(40, 160, (400, 3))
    gains = np.exp(rng.normal(0, 0.2, (12, 3)))
    samples = np.full((12, 400, 3), np.nan)
    for k in range(12):
        # Each image overlaps with the next two only.
        places = slice(30 * k, 30 * k + 70)
        samples[k, places] = truth[places] * gains[k] * np.exp(rng.normal(0, 0.02, truth[places].shape))
        samples[k, 30 * k + 5] = 250.0
    found = balance(samples)
    left = np.log(found * gains)
    # Errors add up along the chain: 12 links of 0.02 * sqrt(2 / 40) each. Glare that counted in full would
    # add about 1 / 70 a link, all in the same direction.
    assert (left - left.mean(axis=0)).std() < 0.02
    np.testing.assert_allclose(np.log(found).mean(axis=0), 0.0, rtol=0.0, atol=1e-9)


def test_an_image_that_shows_nothing_keeps_its_exposure():
    samples = np.full((3, 10, 3), np.nan)
    samples[:2] = [[[80.0]], [[100.0]]]
    np.testing.assert_array_equal(balance(samples)[2], 1.0)


def test_bilinear_reproduces_linear_images():
    row, column = np.mgrid[:7, :9]
    image = np.stack([row, column, 2.0 * row - column], axis=2)
    u, v = np.random.default_rng(0).uniform(0, [8, 6], (50, 2)).T
    # Single precision of numbers below 16.
    np.testing.assert_allclose(
        bilinear(image, u, v), np.stack([v, u, 2 * v - u], axis=1), rtol=0.0, atol=1e-5
    )


def test_sampling_averages_what_a_texture_pixel_covers():
    rng = np.random.default_rng(0)
    image = rng.integers(0, 256, (64, 64, 3)).astype(np.uint8)
    # The middle of the 8 x 8 pixels from (16, 24).
    found = sampled(image, np.array([19.5]), np.array([27.5]), footprint=8.0)
    np.testing.assert_allclose(found[0], image[24:32, 16:24].mean(axis=(0, 1)), rtol=0.0, atol=1e-3)


def test_blurred_images_count_less():
    from scipy import ndimage

    rng = np.random.default_rng(0)
    crisp = np.kron(rng.integers(0, 256, (30, 40, 1)), np.ones((4, 4, 3))).astype(np.uint8)
    blurred = ndimage.uniform_filter(crisp, (7, 7, 0)).astype(np.uint8)
    assert 0.0 <= sharpness(blurred) < sharpness(crisp) - 0.1 <= 1.0
    assert sharpness(np.full((9, 9, 3), 7, np.uint8)) == 0.0


def test_a_wall_hides_what_is_behind_it(filmed):
    """Seen from outside no face shows: walls are looked at from within the room."""
    _, virtual, result, _ = filmed
    outside = virtual.frame.to_scan(np.array([[1.5, 8.0, 1.2]]))[0]
    pose = towards((1.5, 8.0, 1.2), (1.5, 0.0, 1.2))
    rotation = virtual.frame.R_manhattan_scan.T @ pose.R_manhattan_sensor
    green = np.full((48, 64, 3), (0, 255, 0), np.uint8)
    camera = Camera(50.0, 50.0, 31.5, 23.5, 64, 48)
    image = CameraImage("outside", camera, outside, rotation, lambda: green)
    bare = replace(virtual.scan, colours=None)
    assert texture_from_images(result, bare, [image], CONFIG) == ()
