"""Texture images made small enough to travel inside a page."""

import base64
import io

from PIL import Image

from indoorfit.model import TextureImage, TextureSet

_BUDGET_BYTES = 4_000_000
"""Of all images together: with the viewer (0.6 MB) and a third for base64 a report stays below 8 MB."""
_QUALITY = 82
_SMALLEST = 0.1


def data_urls(textures: TextureSet) -> dict[str, str]:
    """Every image as a JPEG in a data URL, by name; all shrunk alike where they exceed the budget together.

    What was not seen keeps the calm colour that lies under its alpha.
    """
    shrink = 1.0
    encoded = _encoded(textures.images, shrink)
    while (size := sum(map(len, encoded.values()))) > _BUDGET_BYTES and shrink > _SMALLEST:
        # Bytes go with the area; a little less than needed, since small images compress worse.
        shrink *= 0.95 * (_BUDGET_BYTES / size) ** 0.5
        encoded = _encoded(textures.images, shrink)
    return {
        name: f"data:image/jpeg;base64,{base64.b64encode(content).decode()}"
        for name, content in encoded.items()
    }


def _encoded(images: tuple[TextureImage, ...], shrink: float) -> dict[str, bytes]:
    return {image.name: _jpeg(image, shrink) for image in images}


def _jpeg(image: TextureImage, shrink: float) -> bytes:
    if image.format == "jpeg" and shrink == 1.0:
        return image.content
    with Image.open(io.BytesIO(image.content)) as opened:
        # Not convert("RGB") of the alpha's mixture: the colours below stand as they are.
        picture = Image.merge("RGB", opened.convert("RGBA").split()[:3])
    if shrink < 1.0:
        size = max(1, round(shrink * image.width)), max(1, round(shrink * image.height))
        picture = picture.resize(size, Image.Resampling.LANCZOS)
    content = io.BytesIO()
    picture.save(content, "JPEG", quality=_QUALITY, optimize=True)
    return content.getvalue()
