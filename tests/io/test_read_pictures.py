"""Pictures and posed images: read right, refused with a reason."""

import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from indoorfit.errors import InputError
from indoorfit.io import MAX_PICTURE_PIXELS, photo_from_text, read_photos, read_picture, read_posed_images


def png_header(width, height):
    """A PNG that promises a size and holds next to nothing."""

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(b"\0" * 1000)) + chunk(b"IEND", b"")


@pytest.mark.parametrize("side", [9_000, 12_000, 60_000], ids=["over-ours", "warned", "bomb"])
def test_huge_pictures_are_refused_before_they_are_unpacked(side, tmp_path):
    assert side**2 > MAX_PICTURE_PIXELS
    (tmp_path / "big.png").write_bytes(png_header(side, side))
    with pytest.raises(InputError, match=r"big\.png: .*80 million.*Fix:"):
        read_picture(tmp_path / "big.png")


@pytest.mark.parametrize("content", [b"", b"no picture", png_header(64, 64)], ids=["empty", "text", "cut"])
def test_damaged_pictures_are_refused(content, tmp_path):
    (tmp_path / "x.png").write_bytes(content)
    with pytest.raises(InputError, match="Fix:"):
        read_picture(tmp_path / "x.png")
    with pytest.raises(InputError, match="Fix:"):
        read_picture(tmp_path / "missing.png")


def test_formats_that_run_programs_are_not_opened(tmp_path):
    (tmp_path / "x.jpg").write_bytes(b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EndComments\n")
    with pytest.raises(InputError, match="JPEG"):
        read_picture(tmp_path / "x.jpg")


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "L", "P", "CMYK", "I;16"])
def test_every_kind_of_pixel_becomes_three_bytes(mode, tmp_path):
    grey = np.arange(0, 250, 10, dtype=np.uint8).reshape(5, 5)
    if mode == "I;16":
        picture = Image.fromarray(grey.astype(np.uint16) << 8)
    elif mode == "P":
        picture = Image.fromarray(grey).convert("RGB").quantize(256)
    else:
        picture = Image.fromarray(grey).convert("RGB").convert(mode)
    name = "x.tif" if mode == "CMYK" else "x.png"
    picture.save(tmp_path / name)
    found = read_picture(tmp_path / name)
    # A palette of 256 entries and the round trip over CMYK may shift a grey by one.
    np.testing.assert_allclose(found, np.repeat(grey[..., None], 3, axis=2), rtol=0.0, atol=3.0)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "rgb").mkdir()
    for name in ("a", "b"):
        Image.new("RGB", (8, 6), (1, 2, 3)).save(tmp_path / "rgb" / f"{name}.png")
    (tmp_path / "rgb.txt").write_text("# time file\n0.0 rgb/a.png\n1.0 rgb/b.png\n5.0 rgb/a.png\n")
    (tmp_path / "groundtruth.txt").write_text("# pose\n0.01 1 2 3 0 0 0 1\n0.99 4 5 6 0 0 1 0\n")
    (tmp_path / "intrinsics.txt").write_text("# fx\n5 6 3.5 2.5 8 6 5000\n")
    return tmp_path


def test_posed_images_take_the_nearest_pose_and_load_late(folder):
    first, second = read_posed_images(folder)
    np.testing.assert_array_equal(first.position_m, [1, 2, 3])
    # Half a turn about z.
    np.testing.assert_allclose(second.R_scan_camera, np.diag([-1.0, -1.0, 1.0]), rtol=0.0, atol=1e-12)
    assert (first.camera.fx, first.camera.cy, first.camera.width) == (5.0, 2.5, 8)
    np.testing.assert_array_equal(first.load(), np.full((6, 8, 3), [1, 2, 3]))


def test_estimated_poses_win_over_true_ones(folder):
    (folder / "estimated.txt").write_text("0 7 7 7 0 0 0 1\n")
    (image,) = read_posed_images(folder)
    np.testing.assert_array_equal(image.position_m, [7, 7, 7])


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("intrinsics.txt", "5 6 3.5\n"),
        ("intrinsics.txt", "5 0 3.5 2.5 8 6\n"),
        ("intrinsics.txt", "5 6 3.5 2.5 8.5 6\n"),
        ("groundtruth.txt", ""),
        ("groundtruth.txt", "0 1 2 3 0 0 0 0\n"),
        ("groundtruth.txt", "0 1 2 nan 0 0 0 1\n"),
        ("groundtruth.txt", "0 1 2 3\n"),
        ("groundtruth.txt", "100 1 2 3 0 0 0 1\n"),
        ("rgb.txt", "0.0 rgb/none.png\n"),
        ("rgb.txt", "0.0 ../../etc/passwd\n"),
        ("rgb.txt", "0.0\n"),
        ("rgb.txt", None),
    ],
)
def test_wrong_folders_are_the_users_error(folder, name, text):
    (folder / name).unlink()
    if text is not None:
        (folder / name).write_text(text)
    with pytest.raises(InputError, match=rf"{name}.*Fix:"):
        read_posed_images(folder)


def test_an_image_of_another_size_than_the_intrinsics_say_is_refused(folder):
    Image.new("RGB", (16, 12)).save(folder / "rgb" / "a.png")
    with pytest.raises(InputError, match="16 x 12"):
        read_posed_images(folder)[0].load()


@pytest.mark.parametrize(
    "text", ["wall-1", "wall-1=x.png", "=x.png:1", "wall-1=x.png:1,2,3", "wall-1=x.png:1,2,3,4,5,6,7,nan"]
)
def test_wrong_photo_options_say_what_is_needed(text):
    with pytest.raises(InputError, match="Fix:"):
        photo_from_text(text)


@pytest.mark.parametrize(
    "text",
    [
        "x",
        "[wall-1]\n",
        '[wall-1]\nfile = "x.png"\ncorners = 3\n',
        "wall-1 = 3\n",
        "[w]\nfile = 3\ncorners = []",
    ],
)
def test_wrong_photo_files_say_what_is_needed(text, tmp_path):
    (tmp_path / "photos.toml").write_text(text)
    with pytest.raises(InputError, match=r"photos\.toml.*Fix:"):
        read_photos(tmp_path / "photos.toml")
