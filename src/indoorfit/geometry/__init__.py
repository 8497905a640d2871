"""Pure maths that two stages or more use."""

from .exposure import Exposure as Exposure
from .exposure import exposures as exposures
from .exposure import room_of_planes as room_of_planes
from .levels import Level as Level
from .levels import with_levels as with_levels
from .plan import shape_from_plan as shape_from_plan
