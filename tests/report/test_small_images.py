"""Textures in the page."""

import io

import numpy as np
from PIL import Image

from indoorfit.model import TextureImage, TextureSet
from indoorfit.report.small_images import _BUDGET_BYTES, data_urls


def noise_image(name, rng):
    content = io.BytesIO()
    Image.fromarray(rng.integers(0, 256, (1600, 1600, 3), dtype=np.uint8)).save(
        content, "PNG", compress_level=1
    )
    return TextureImage(name, "png", 1600, 1600, content.getvalue())


def test_images_that_compress_badly_are_shrunk_until_the_page_stays_small():
    rng = np.random.default_rng(3)
    images = (noise_image("a.png", rng), noise_image("b.png", rng))
    urls = data_urls(TextureSet(images, {}))
    assert urls.keys() == {"a.png", "b.png"}
    # Four letters for three bytes, and the head of each address.
    total = sum(map(len, urls.values()))
    assert 0.5 * _BUDGET_BYTES < total < 4.0 / 3.0 * _BUDGET_BYTES + 100 * len(urls)
