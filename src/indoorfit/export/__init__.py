"""One way out: the model in the formats of other programs."""

from .dimensions import write_dimensions_csv as write_dimensions_csv
from .files import replace_file as replace_file
from .glb import T_scan_gltf as T_scan_gltf
from .glb import write_glb as write_glb
from .images import image_of as image_of
from .images import placement_of as placement_of
from .images import textured_name as textured_name
from .images import write_images as write_images
from .numbers import QuantityText as QuantityText
from .numbers import half_width as half_width
from .numbers import quantity_text as quantity_text
from .obj import write_obj as write_obj
from .palette import face_colour as face_colour
from .vrml import write_vrml as write_vrml
