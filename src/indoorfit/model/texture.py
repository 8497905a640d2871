"""Images on the faces of a model: one raster per face, and the files that hold them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float, UInt8

TextureSource = Literal["points", "images", "photo"]
"""Colours of the scan's points, posed camera images, or one photo put on by its corners."""

ImageFormat = Literal["png", "jpeg", "webp"]

TEXTURE_FOLDER = "textures"
"""Folder of the images, beside ``model.json`` and the model files; these name it with a forward slash."""


@dataclass(frozen=True)
class FaceTexture:
    """The raster of one face, as it is seen from inside the room: row 0 is its upper edge.

    A texture pixel (row r, column c) covers the square around
    ``origin_m + (c + 0.5) * pixel_m * right + (r + 0.5) * pixel_m * down``.
    """

    face: str
    origin_m: Float[np.ndarray, " 3"]
    """Scan frame, metres: the outer corner of row 0, column 0."""
    right: Float[np.ndarray, " 3"]
    """Scan frame, unit length: the direction of growing columns, to the right as seen from inside."""
    down: Float[np.ndarray, " 3"]
    """Scan frame, unit length, perpendicular to `right`; ``right x down`` points out of the room."""
    pixel_m: float
    """Side of a pixel."""
    rgba: UInt8[np.ndarray, "rows columns 4"]
    """Red, green, blue (sRGB) and 255 where the colour was seen or filled, 0 in gaps and off the face.
    Colour also lies under an alpha of 0, so that formats and viewers without alpha show something calm."""
    source: TextureSource
    seen: float
    """Share of the face's pixels whose colour was observed, 0 to 1."""
    filled: float
    """Share of the face's pixels that were filled from their surroundings, 0 to 1."""


@dataclass(frozen=True)
class TextureImage:
    """One image file, encoded once for all formats that hold it."""

    name: str
    """File name without folder, e.g. ``wall-1.png``."""
    format: ImageFormat
    width: int
    height: int
    content: bytes
    """The bytes of the file."""

    @property
    def media_type(self) -> str:
        """``image/png``, ``image/jpeg`` or ``image/webp``."""
        return f"image/{self.format}"


@dataclass(frozen=True)
class TexturePlacement:
    """Which part of which image lies on a face. Affine: any point of the face's plane has its place."""

    face: str
    image: str
    """Name of the `TextureImage`."""
    origin_m: Float[np.ndarray, " 3"]
    """Scan frame, metres: the point whose image coordinates are `origin_uv`."""
    origin_uv: Float[np.ndarray, " 2"]
    u_per_m: Float[np.ndarray, " 3"]
    """Scan frame, 1/m: gradient of u."""
    v_per_m: Float[np.ndarray, " 3"]
    """Scan frame, 1/m: gradient of v."""
    pixel_m: float
    """Side of a texture pixel before any change of size to a power of two."""
    source: TextureSource
    seen: float
    filled: float
    """As in `FaceTexture`."""

    def uv(self, points_m: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 2"]:
        """Image coordinates of points on the face.

        Args:
            points_m: scan frame, metres.

        Returns:
            u to the right and v **upward**, both from 0 to 1 over the image, as in OBJ, VRML97, X3D and
            COLLADA. glTF has v downward from the upper edge: take 1 - v there (trimesh does it by itself).
        """
        return self.origin_uv + (points_m - self.origin_m) @ np.stack([self.u_per_m, self.v_per_m], axis=1)


@dataclass(frozen=True)
class TextureSet:
    """All images of a model, and where they lie."""

    images: tuple[TextureImage, ...]
    placements: Mapping[str, TexturePlacement]
    """By face id. Faces that are not in it have no texture."""

    def image(self, name: str) -> TextureImage:
        """The image with this name; KeyError if there is none."""
        for image in self.images:
            if image.name == name:
                return image
        raise KeyError(name)
