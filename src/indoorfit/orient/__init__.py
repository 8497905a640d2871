"""Surfels -> the Manhattan frame: gravity up, axes along the walls."""

from .level import OrientConfig as OrientConfig
from .level import orient as orient
from .up import Up as Up
