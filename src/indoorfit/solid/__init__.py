"""Shape -> watertight solids and their faces as polygons."""

from .csg import subtract_cubes as subtract_cubes
from .polygons import face_polygons as face_polygons
