"""All sources together."""

from indoorfit.errors import InputError
from indoorfit.model import FaceTexture, FitResult, Pictures, Scan, TextureSet

from .config import TextureConfig
from .images import texture_from_images
from .pack import pack
from .photos import texture_from_photo
from .points import texture_from_points


def paint(result: FitResult, scan: Scan, pictures: Pictures, config: TextureConfig) -> TextureSet | None:
    """Textures for the faces: a photo where there is one, else camera images, else the points' colours.

    Args:
        result: the fitted model.
        scan: the cloud that it was fitted to.
        pictures: what the user brought along.
        config: see `TextureConfig`.

    Returns:
        None where there is nothing to take colours from.

    Raises:
        InputError: a picture cannot be read or belongs to no face.
    """
    found: dict[str, FaceTexture] = {}
    twice = [p.face for k, p in enumerate(pictures.photos) if p.face in {q.face for q in pictures.photos[:k]}]
    if twice:
        raise InputError(f"photos: {twice[0]} has two. Fix: give one photo for each face.")
    # First, for it fails at once where a name is wrong.
    photos = {photo.face: texture_from_photo(result, photo, config) for photo in pictures.photos}
    if pictures.images:
        found = {t.face: t for t in texture_from_images(result, scan, pictures.images, config)}
    elif scan.colours is not None:
        found = {t.face: t for t in texture_from_points(result, scan, config)}
    found |= photos
    if not found:
        return None
    # In the order of the faces, so that equal runs give equal files.
    return pack([found[face.id] for face in result.faces if face.id in found], config)
