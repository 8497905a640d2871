"""One image a face, or all faces on one."""

import re
from collections.abc import Sequence

import numpy as np
from jaxtyping import UInt8

from indoorfit.model import FaceTexture, TextureImage, TexturePlacement, TextureSet

from .config import TextureConfig
from .encode import encoded

_GUTTER = 4
"""Pixels around each face of an atlas that repeat its rim: a viewer that draws at a quarter of the size
still mixes no neighbour in."""


def pack(textures: Sequence[FaceTexture], config: TextureConfig) -> TextureSet:
    """Encode textures and say where they lie.

    Args:
        textures: at most one a face.
        config: `atlas`, `power_of_two`, `format` and `max_side` count here.
    """
    return _atlas(textures, config) if config.atlas else _single(textures, config)


def _single(textures: Sequence[FaceTexture], config: TextureConfig) -> TextureSet:
    images: list[TextureImage] = []
    placements: dict[str, TexturePlacement] = {}
    taken: set[str] = set()
    for texture in textures:
        image = encoded(_stem(texture.face, taken), texture.rgba, config)
        images.append(image)
        rows, columns = texture.rgba.shape[:2]
        placements[texture.face] = _placement(texture, image.name, (0, 0), (columns, rows))
    return TextureSet(tuple(images), placements)


def _stem(face: str, taken: set[str]) -> str:
    """A file name for a face: its id, without what file systems and model formats stumble over."""
    stem = re.sub(r"[^A-Za-z0-9_-]", "_", face)[:80] or "face"
    while stem.lower() in taken:
        stem += "_"
    taken.add(stem.lower())
    return stem


def _placement(
    texture: FaceTexture, image: str, corner: tuple[int, int], size: tuple[int, int]
) -> TexturePlacement:
    """The mapping of a raster that begins at column and row `corner` of an image of `size` pixels."""
    width, height = size
    return TexturePlacement(
        face=texture.face,
        image=image,
        origin_m=texture.origin_m,
        origin_uv=np.array([corner[0] / width, 1.0 - corner[1] / height]),
        u_per_m=texture.right / (texture.pixel_m * width),
        v_per_m=-texture.down / (texture.pixel_m * height),
        pixel_m=texture.pixel_m,
        source=texture.source,
        seen=texture.seen,
        filled=texture.filled,
    )


def _atlas(textures: Sequence[FaceTexture], config: TextureConfig) -> TextureSet:
    """Shelves: the highest rasters first, in rows from the left, on as many pages as they need."""
    padded = {texture.face: _with_gutter(texture.rgba, config.max_side) for texture in textures}
    area = sum(raster.shape[0] * raster.shape[1] for raster in padded.values())
    widest = max((raster.shape[1] for raster in padded.values()), default=1)
    # A little wider than a square of the same area: shelves waste some of the height.
    width = min(max(widest, int(1.1 * area**0.5)), config.max_side)
    if config.power_of_two:
        width = min(1 << (width - 1).bit_length(), 1 << (config.max_side.bit_length() - 1))
        width = max(width, widest)
    pages: list[dict[str, tuple[int, int]]] = []
    heights: list[int] = []
    x = y = shelf = 0
    for texture in sorted(textures, key=lambda t: (-t.rgba.shape[0], t.face)):
        rows, columns = padded[texture.face].shape[:2]
        if x + columns > width:
            x, y, shelf = 0, y + shelf, 0
        if not pages or y + rows > config.max_side:
            pages.append({})
            heights.append(0)
            x = y = shelf = 0
        pages[-1][texture.face] = (x, y)
        shelf, heights[-1] = max(shelf, rows), max(heights[-1], y + rows)
        x += columns
    images, placements = [], {}
    for number, (page, height) in enumerate(zip(pages, heights, strict=True), start=1):
        canvas = np.zeros((_side(height, config), _side(width, config), 4), np.uint8)
        for face, (x, y) in page.items():
            rows, columns = padded[face].shape[:2]
            canvas[y : y + rows, x : x + columns] = padded[face]
        image = encoded(f"atlas-{number}", canvas, config)
        images.append(image)
        size = (canvas.shape[1], canvas.shape[0])
        for texture in textures:
            if texture.face in page:
                x, y = page[texture.face]
                rim = _rim(texture.rgba, config.max_side)
                placements[texture.face] = _placement(texture, image.name, (x + rim, y + rim), size)
    return TextureSet(tuple(images), placements)


def _rim(rgba: UInt8[np.ndarray, "rows columns 4"], max_side: int) -> int:
    """The gutter, unless a face fills a whole page."""
    return max(0, min(_GUTTER, (max_side - max(rgba.shape[:2])) // 2))


def _with_gutter(
    rgba: UInt8[np.ndarray, "rows columns 4"], max_side: int
) -> UInt8[np.ndarray, "padded_rows padded_columns 4"]:
    rim = _rim(rgba, max_side)
    return np.pad(rgba, ((rim, rim), (rim, rim), (0, 0)), mode="edge")


def _side(n: int, config: TextureConfig) -> int:
    return 1 << (n - 1).bit_length() if config.power_of_two else n
