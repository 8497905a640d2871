"""Pure maths that two stages or more use."""

from .boxes import box_exposures as box_exposures
from .boxes import room_of_planes as room_of_planes
from .exposure import Corner as Corner
from .exposure import Exposure as Exposure
from .exposures import corner_of as corner_of
from .exposures import exposures as exposures
from .levels import Level as Level
from .levels import with_levels as with_levels
from .oblique import walls_at as walls_at
from .oblique import with_oblique_wall as with_oblique_wall
from .order import SAME_WALL_M as SAME_WALL_M
from .order import passed as passed
from .order import reverted as reverted
from .pieces import SeenPiece as SeenPiece
from .pieces import pieces as pieces
from .pieces import seen_pieces as seen_pieces
from .plan import shape_from_plan as shape_from_plan
from .planar import shared_area as shared_area
from .planar import union as union
from .robust import MAD_TO_STD as MAD_TO_STD
