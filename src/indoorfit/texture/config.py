"""Settings of the textures."""

from dataclasses import dataclass
from typing import Literal

from indoorfit.errors import ConfigError


@dataclass(frozen=True)
class TextureConfig:
    """Images on the faces: how fine, from which points, and in which files."""

    enabled: bool = True
    """Make textures where the scan has colours, or images or photos are given."""
    pixel_m: float = 0.01
    """Side of a texture pixel from point colours: the thesis' 1 x 1 cm (3.3.1)."""
    image_pixel_m: float = 0.005
    """The same from camera images; a depth camera's pixel covers 4 mm at 2 m."""
    photo_pixel_m: float = 0.002
    """The finest pixel from a photo; coarser where the photo itself is. 2 mm is what an eye resolves from
    7 m (1 minute of arc)."""
    view_power: float = 4.0
    """How much better images outweigh worse ones: an image of twice the resolution counts 16 times. Higher is
    sharper where poses err, lower is less noisy."""
    exposure: bool = True
    """Give each camera image a gain that makes it as bright as the others where they overlap."""
    gaps: Literal["alpha", "fill"] = "alpha"
    """What nobody saw: `alpha` leaves it transparent over the face's mean colour, `fill` lets the colours
    around diffuse into it."""
    align: bool = True
    """Move each camera image on each face to where it agrees with the others, as far as poses err."""
    pose_error_m: float = 0.01
    """How far images may lie beside their place, as a standard deviation: what the poses of hand-held depth
    cameras are good to. A plain wall, on which nothing can be aligned, is left where it is."""
    noise_sigmas: float = 3.0
    """Points further from the plane than this many of the face's own standard deviations are furniture or
    stray: of a Gaussian wall 0.3 % are lost."""
    min_reach_m: float = 0.001
    """Distance to the plane that is always allowed: exact points have no spread, and no wall is flatter."""
    atlas: bool = False
    """One image for all faces (or few, if they do not fit) in place of one a face."""
    power_of_two: bool = False
    """Images with sides of 2, 4, 8, ... pixels, which some old renderers need."""
    format: Literal["png", "jpeg", "webp"] = "png"
    """Of the image files. `jpeg` has no alpha; VRML97 viewers need not know `webp`."""
    quality: int = 90
    """Of JPEG and WebP, 1 to 100; at 90 the errors are below those of a depth camera's colours."""
    max_side: int = 8192
    """Longest side of an image in pixels, which every present graphics card takes; larger faces get larger
    pixels, larger atlases several images."""

    def __post_init__(self) -> None:
        if not 1 <= self.quality <= 100:
            raise ConfigError(f"texture.quality: got {self.quality}; needed 1 to 100. Fix: 90 is good.")
        if self.max_side < 64:
            raise ConfigError(f"texture.max_side: got {self.max_side}; needed 64 or more. Fix: write 4096.")
