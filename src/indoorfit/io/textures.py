"""Textures beside ``model.json``, read back."""

import re
from pathlib import Path
from typing import get_args

from ..model import (
    TEXTURE_FOLDER,
    ImageFormat,
    TextureImage,
    TexturePlacement,
    TextureSet,
    TextureSource,
)
from .checked_json import JsonNode

_FILE_NAME = re.compile(r"[A-Za-z0-9_-]+\.(png|jpg|webp)")
"""A name in the folder and no way out of it."""


def read_textures(root: JsonNode, folder: Path, face_ids: tuple[str, ...]) -> TextureSet | None:
    """The textures that a document names.

    Args:
        root: the document; one without the key is from before there were textures.
        folder: of the document; the images are in its ``textures``.
        face_ids: of the document.

    Returns:
        None where there are none, or an image is not there.

    Raises:
        InputError: the entry is wrong.
    """
    if not isinstance(root.value, dict) or "textures" not in root.value:
        return None
    node = root["textures"]
    images = []
    for item in node["images"].items():
        name = item["file"].text()
        if not _FILE_NAME.fullmatch(name):
            item["file"].fail(repr(name)[:60], "the name of a .png, .jpg or .webp file")
        path = folder / TEXTURE_FOLDER / name
        if not path.is_file():
            return None
        images.append(
            TextureImage(
                name,
                item["format"].choice(*get_args(ImageFormat)),
                item["width"].integer(1, 2**16),
                item["height"].integer(1, 2**16),
                path.read_bytes(),
            )
        )
    names = tuple(image.name for image in images)
    placements = [_placement(item, face_ids, names) for item in node["faces"].items()]
    return TextureSet(tuple(images), {placement.face: placement for placement in placements})


def _placement(node: JsonNode, face_ids: tuple[str, ...], images: tuple[str, ...]) -> TexturePlacement:
    for key, known in (("face", face_ids), ("image", images)):
        if node[key].text() not in known:
            node[key].fail(repr(node[key].value)[:60], f"a known {key}")
    return TexturePlacement(
        face=node["face"].text(),
        image=node["image"].text(),
        origin_m=node["origin"].array(3),
        origin_uv=node["origin_uv"].array(2),
        u_per_m=node["u_per_m"].array(3),
        v_per_m=node["v_per_m"].array(3),
        pixel_m=node["pixel"].number(),
        source=node["source"].choice(*get_args(TextureSource)),
        seen=node["seen"].number(),
        filled=node["filled"].number(),
    )
