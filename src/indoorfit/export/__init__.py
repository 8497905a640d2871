"""One way out: the model in the formats of other programs."""

from .cityjson import write_cityjson as write_cityjson
from .collada import write_collada as write_collada
from .dimensions import write_dimensions_csv as write_dimensions_csv
from .extras import optional_module as optional_module
from .facts import dimension_facts as dimension_facts
from .facts import face_facts as face_facts
from .facts import model_facts as model_facts
from .facts import one_line as one_line
from .facts import room_facts as room_facts
from .glb import T_scan_gltf as T_scan_gltf
from .glb import write_glb as write_glb
from .ifc import write_ifc as write_ifc
from .images import image_of as image_of
from .images import placement_of as placement_of
from .images import textured_name as textured_name
from .images import write_images as write_images
from .numbers import QuantityText as QuantityText
from .numbers import half_width as half_width
from .numbers import quantity_text as quantity_text
from .obj import write_obj as write_obj
from .palette import face_colour as face_colour
from .ply import write_mesh_ply as write_mesh_ply
from .stl import write_stl as write_stl
from .threemf import write_3mf as write_3mf
from .vrml import write_vrml as write_vrml
from .x3d import write_x3d as write_x3d
