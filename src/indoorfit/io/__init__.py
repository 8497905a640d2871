"""Files to typed values and back: scans, sensor poses and ``model.json``."""

from .checked_scan import MIN_POINTS as MIN_POINTS
from .frames import frames_path as frames_path
from .frames import read_frames_json as read_frames_json
from .frames import write_frames_json as write_frames_json
from .model_json import SCHEMA_PATH as SCHEMA_PATH
from .model_json import document_bytes as document_bytes
from .model_json import to_document as to_document
from .model_json import write_model_json as write_model_json
from .model_reader import read_model_json as read_model_json
from .photos import photo_from_text as photo_from_text
from .photos import read_photos as read_photos
from .pictures import MAX_PICTURE_PIXELS as MAX_PICTURE_PIXELS
from .pictures import read_picture as read_picture
from .ply_writer import write_ply as write_ply
from .posed_images import read_posed_images as read_posed_images
from .scan import read_scan as read_scan
from .scan import scan_from_arrays as scan_from_arrays
from .tape import read_tape as read_tape
from .text_names import printable_name as printable_name
from .units import Unit as Unit
from .units import metres_per_unit as metres_per_unit
