"""The options of ``indoorfit fit`` for the images on the faces."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import tyro

from indoorfit.errors import ConfigError

from .maybe import Flag, Maybe

if TYPE_CHECKING:
    from indoorfit.model import Pictures
    from indoorfit.texture import TextureConfig


@dataclass(frozen=True)
class Textures:
    """Images on the faces; by default from the points' colours, if the scan has any."""

    no_textures: Flag = False
    """Make none."""
    images: Maybe[Path] = None
    """Folder of colour images with poses (rgb.txt, estimated.txt or groundtruth.txt, intrinsics.txt)."""
    photo: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """A photo put on a face by its corners: FACE=FILE:x1,y1,x2,y2,x3,y3,x4,y4 (upper left, upper right, lower
    right, lower left as seen from inside, in pixels). May be given again for other faces."""
    photos: Maybe[Path] = None
    """The same as a TOML file: a table per face with file and corners."""
    texture_pixel: Maybe[float] = None
    """Side of a texture pixel, metres; default 0.01 from points, 0.005 from images, photos their own."""
    fill_gaps: Flag = False
    """Let the colours around gaps diffuse into them; by default gaps are transparent."""
    atlas: Flag = False
    """One image for all faces."""
    power_of_two: Flag = False
    """Images with sides of 2, 4, 8, ... pixels."""
    image_format: Maybe[Literal["png", "jpeg", "webp"]] = None
    """Of the texture files; default png."""

    def settings(self, config: "TextureConfig") -> "TextureConfig":
        """The settings of a file with these options over them.

        Raises:
            ConfigError: a value is out of range, or options contradict each other.
        """
        if self.no_textures:
            if self != Textures(no_textures=True):
                raise ConfigError("--no-textures: other texture options are given. Fix: leave one out.")
            return replace(config, enabled=False)
        if self.texture_pixel is not None:
            if not 0.0005 <= self.texture_pixel <= 1.0:
                raise ConfigError(
                    f"--texture-pixel {self.texture_pixel:g}: needed 0.0005 to 1 m. Fix: sizes are in metres."
                )
            size_m = self.texture_pixel
            config = replace(config, pixel_m=size_m, image_pixel_m=size_m, photo_pixel_m=size_m)
        given = {
            "gaps": "fill" if self.fill_gaps else None,
            "atlas": self.atlas or None,
            "power_of_two": self.power_of_two or None,
            "format": self.image_format,
        }
        return replace(config, **{name: value for name, value in given.items() if value is not None})  # type: ignore[arg-type]

    def pictures(self) -> "Pictures":
        """The images and photos.

        Raises:
            InputError: a file is missing, wrong or too large.
        """
        from indoorfit.io import photo_from_text, read_photos, read_posed_images
        from indoorfit.model import Pictures

        photos = tuple(photo_from_text(text) for text in self.photo)
        if self.photos is not None:
            photos += read_photos(self.photos)
        return Pictures(() if self.images is None else read_posed_images(self.images), photos)
