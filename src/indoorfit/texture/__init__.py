"""Images on the faces of a model, from points, camera images and photos."""

from .config import TextureConfig as TextureConfig
from .images import texture_from_images as texture_from_images
from .pack import pack as pack
from .paint import paint as paint
from .photos import homography_of as homography_of
from .photos import texture_from_photo as texture_from_photo
from .points import texture_from_points as texture_from_points
