"""Texture images beside the files that name them."""

from pathlib import Path

from indoorfit.errors import OutputError
from indoorfit.files import replace_file
from indoorfit.model import TEXTURE_FOLDER, Face, FitResult, TextureImage, TexturePlacement

from .palette import material_name


def write_images(folder: Path, result: FitResult) -> None:
    """Write all images of a result to ``folder/textures``; nothing where it has none.

    Raises:
        OutputError: a file cannot be written.
    """
    if result.textures is None:
        return
    target = folder / TEXTURE_FOLDER
    try:
        target.mkdir(exist_ok=True)
    except OSError as error:
        raise OutputError(
            f"{target.name}: cannot be made ({error.strerror}); a writable folder is needed. "
            "Fix: choose another folder with --out."
        ) from error
    for image in result.textures.images:
        replace_file(target / image.name, image.content)


def placement_of(result: FitResult, face: Face) -> TexturePlacement | None:
    """Where the face's image lies, or None where it has no texture."""
    return None if result.textures is None else result.textures.placements.get(face.id)


def image_of(result: FitResult, face: Face) -> TextureImage | None:
    """The image that (part of) lies on a face."""
    placement = placement_of(result, face)
    if placement is None or result.textures is None:
        return None
    return result.textures.image(placement.image)


def textured_name(result: FitResult, face: Face) -> str:
    """Name of the face's material: its image's stem, or without a texture that of its plain colour."""
    image = image_of(result, face)
    return material_name(face) if image is None else f"texture_{image.name.rpartition('.')[0]}"
