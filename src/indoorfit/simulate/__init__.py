"""Simulated rooms and scans whose truth is known exactly."""

from .patches import Box as Box
from .placement import Hole as Hole
from .placement import place_furniture as place_furniture
from .placement import place_windows as place_windows
from .pose import scan_frame as scan_frame
from .presets import RoomKind as RoomKind
from .presets import room_shape as room_shape
from .random_plan import RandomRoomSettings as RandomRoomSettings
from .random_plan import random_room as random_room
from .sampling import SamplingSettings as SamplingSettings
from .sampling import sample_surface as sample_surface
from .virtual import VirtualScan as VirtualScan
