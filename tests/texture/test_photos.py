"""Photos by four corners: a projective map, the right way round, at the face's own shape."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from rooms import BOX, L_ROOM, make_result

from indoorfit.errors import InputError
from indoorfit.io import photo_from_text, read_photos
from indoorfit.model import Photo, Pictures
from indoorfit.texture import TextureConfig, homography_of, paint, texture_from_photo
from indoorfit.texture.canvas import canvas_of

COARSE = TextureConfig(pixel_m=0.05, photo_pixel_m=0.02)
SIZE = (480, 360)


def camera(result, face_id):
    """A pinhole that looks at the middle of a face at a slant: scan points to pixels and depth."""
    face = result.face(face_id)
    canvas = canvas_of(face, result.frame, 0.01, 8192)
    middle = face.rings_m[0].mean(axis=0)
    eye = middle + 3.2 * face.normal + 1.1 * canvas.right - 0.5 * canvas.down
    forward = (middle - eye) / np.linalg.norm(middle - eye)
    right = np.cross(canvas.down, forward)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(forward, right), forward])

    def project(points_m):
        x, y, z = ((points_m - eye) @ axes.T).T
        return np.stack([240.0 + 260.0 * x / z, 180.0 + 260.0 * y / z], axis=1)

    return canvas, eye, axes, project


def pattern(x_m, y_m):
    """Asymmetric in both directions, smooth against the 2 cm of a pixel."""
    return np.stack([60 + 30 * x_m, 40 + 50 * y_m, 128 + 60 * np.sin(2 * x_m + y_m)], axis=-1)


def photograph(result, face_id):
    """What that camera sees of the pattern on the face, and where the face's corners are."""
    canvas, eye, axes, project = camera(result, face_id)
    v, u = np.mgrid[: SIZE[1], : SIZE[0]] + 0.5
    rays = np.stack([(u - 240) / 260, (v - 180) / 260, np.ones_like(u)], axis=-1) @ axes
    normal = canvas.face.normal
    t = ((canvas.origin_m - eye) @ normal) / (rays @ normal)
    x_m, y_m = canvas.coordinates_m((eye + rays * t[..., None]).reshape(-1, 3), np.zeros(3))
    rgb = np.clip(pattern(x_m, y_m), 0, 255).round().astype(np.uint8).reshape(SIZE[1], SIZE[0], 3)
    width, height = np.ptp(canvas.rings_m[0], axis=0)
    corners = [(0, 0), (width, 0), (width, height), (0, height)]
    places = [canvas.origin_m + x * canvas.right + y * canvas.down for x, y in corners]
    return rgb, project(np.array(places))


def assert_shows_pattern(texture):
    rows, columns = texture.rgba.shape[:2]
    x_m, y_m = np.meshgrid((np.arange(columns) + 0.5), (np.arange(rows) + 0.5))
    wanted = np.clip(pattern(texture.pixel_m * x_m, texture.pixel_m * y_m), 0, 255)
    seen = texture.rgba[..., 3] == 255
    # Two roundings to bytes, and a pixel of the photo (1.3 cm) of its clipped corners.
    assert np.abs(texture.rgba[..., :3] - wanted)[seen].max() < 3.0


@pytest.mark.parametrize("face", ["wall-1", "wall-4", "floor-1", "ceiling-1"])
def test_a_slanted_photo_lands_undistorted_on_the_face(face):
    result = make_result(L_ROOM)
    rgb, corners = photograph(result, face)
    texture = texture_from_photo(result, Photo(face, "p", rgb, corners), COARSE)
    assert texture.source == "photo"
    assert texture.seen > 0.3
    assert_shows_pattern(texture)


def test_homography_takes_the_corners_where_they_belong():
    rng = np.random.default_rng(0)
    for _ in range(20):
        corners = np.array([[0, 0], [9, 0], [9, 6], [0, 6]]) + rng.uniform(-1, 1, (4, 2))
        size = rng.uniform(1, 5, 2)
        h = homography_of(size, corners)
        rectangle = np.array([[0, 0, 1], [size[0], 0, 1], [*size, 1], [0, size[1], 1]])
        found = rectangle @ h.T
        # Rounding.
        np.testing.assert_allclose(found[:, :2] / found[:, 2:], corners, rtol=0.0, atol=1e-12)


def test_resolution_is_the_photos_own_and_pixels_stay_square():
    result = make_result(BOX)
    face = result.face("wall-1")
    canvas = canvas_of(face, result.frame, 0.01, 8192)
    width, height = np.ptp(canvas.rings_m[0], axis=0)
    # A photo that was squeezed: 40 pixels a metre across, 100 down. The finer one is kept.
    n, m = round(40 * width), round(100 * height)
    rgb = np.zeros((m, n, 3), np.uint8)
    corners = np.array([[0, 0], [n, 0], [n, m], [0, m]], float)
    texture = texture_from_photo(result, Photo("wall-1", "p", rgb, corners), TextureConfig())
    assert texture.pixel_m == pytest.approx(0.01, rel=0.01)
    assert texture.rgba.shape[1] / texture.rgba.shape[0] == pytest.approx(width / height, rel=0.02)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_exif_orientation_is_respected(orientation, tmp_path):
    """Whatever way the pixels are stored: the corners are those of the photo as it is shown."""
    turn = {
        2: Image.Transpose.FLIP_LEFT_RIGHT, 3: Image.Transpose.ROTATE_180, 4: Image.Transpose.FLIP_TOP_BOTTOM,
        5: Image.Transpose.TRANSPOSE, 6: Image.Transpose.ROTATE_90, 7: Image.Transpose.TRANSVERSE,
        8: Image.Transpose.ROTATE_270,
    }  # fmt: skip
    result = make_result(BOX)
    rgb, corners = photograph(result, "wall-1")
    picture = Image.fromarray(rgb)
    stored = picture if orientation == 1 else picture.transpose(turn[orientation])
    exif = Image.Exif()
    exif[0x0112] = orientation
    stored.save(tmp_path / "p.png", exif=exif)
    text = ",".join(f"{x:.6f}" for x in corners.ravel())
    photo = photo_from_text(f"wall-1={tmp_path / 'p.png'}:{text}")
    np.testing.assert_array_equal(photo.rgb, rgb)
    assert_shows_pattern(texture_from_photo(result, photo, COARSE))


def test_a_toml_file_says_the_same_as_the_option(tmp_path):
    rgb, corners = photograph(make_result(BOX), "wall-1")
    Image.fromarray(rgb).save(tmp_path / "p.png")
    pairs = ", ".join(f"[{x!r}, {y!r}]" for x, y in corners.tolist())
    (tmp_path / "photos.toml").write_text(f'[wall-1]\nfile = "p.png"\ncorners = [{pairs}]\n')
    (photo,) = read_photos(tmp_path / "photos.toml")
    text = ",".join(repr(x) for x in corners.ravel().tolist())
    same = photo_from_text(f"wall-1={tmp_path / 'p.png'}:{text}")
    assert photo.face == same.face
    np.testing.assert_array_equal(photo.corners, same.corners)
    np.testing.assert_array_equal(photo.rgb, same.rgb)


def test_what_lies_off_the_photo_is_a_gap():
    result = make_result(BOX)
    rgb = np.full((100, 100, 3), 200, np.uint8)
    corners = np.array([[-100, 0], [100, 0], [100, 100], [-100, 100]], float)
    texture = texture_from_photo(result, Photo("wall-1", "p", rgb, corners), COARSE)
    columns = texture.rgba.shape[1]
    assert texture.seen == pytest.approx(0.5, abs=1.0 / columns)
    assert (texture.rgba[:, : columns // 2 - 1, 3] == 0).all()


def test_a_photo_wins_over_the_points():
    result = make_result(BOX)
    rgb, corners = photograph(result, "wall-1")
    from test_points import on_faces

    scan = on_faces(result, 500, np.random.default_rng(0), lambda p, face: np.full((len(p), 3), 90.0))
    textures = paint(result, scan, Pictures(photos=(Photo("wall-1", "p", rgb, corners),)), COARSE)
    assert textures is not None
    assert {face: p.source for face, p in textures.placements.items()} == {
        face.id: "photo" if face.id == "wall-1" else "points" for face in result.faces
    }


@pytest.mark.parametrize(
    ("face", "corners", "word"),
    [
        ("wall-99", [[0, 0], [9, 0], [9, 9], [0, 9]], "wall-1"),
        ("wall-1", [[0, 0], [0, 9], [9, 9], [9, 0]], "once around"),
        ("wall-1", [[0, 0], [9, 9], [9, 0], [0, 9]], "once around"),
        ("wall-1", [[0, 0], [9, 0], [9, 0], [0, 0]], "once around"),
        ("wall-1", [[900, 0], [990, 0], [990, 9], [900, 9]], "nothing of"),
    ],
    ids=["no-such-face", "other-way-round", "crossed", "flat", "beside"],
)
def test_impossible_photos_are_the_users_error(face, corners, word):
    photo = Photo(face, "img.jpg", np.zeros((50, 50, 3), np.uint8), np.array(corners, float))
    with pytest.raises(InputError, match=word) as caught:
        texture_from_photo(make_result(BOX), photo, COARSE)
    assert "img.jpg" in str(caught.value)
    assert "Fix:" in str(caught.value)


def test_two_photos_for_one_face_are_refused():
    rgb, corners = photograph(make_result(BOX), "wall-1")
    photo = Photo("wall-1", "p", rgb, corners)
    from indoorfit.model import Scan

    scan = Scan(np.zeros((3, 3)))
    with pytest.raises(InputError, match="two"):
        paint(make_result(BOX), scan, Pictures(photos=(photo, replace(photo, name="q"))), COARSE)
