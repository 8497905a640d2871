"""Scan -> VoxelCloud: fewer points for the front end, exact moments for the fit."""

from .surfels import SurfelConfig as SurfelConfig
from .surfels import surfels as surfels
from .voxels import ThinConfig as ThinConfig
from .voxels import thin as thin
